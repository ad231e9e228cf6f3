// Names of passes in files: those that Blender writes, those that Nuke reserves, and the way back from each.
#include "output/names.h"
#include "support/image_support.h"
#include "support/test.h"

typedef struct Pass
{
    const char* name;
    const char* letters;
} Pass;

static const Pass s_passes[] = {
    { RF_PASS_PICTURE, "RGB" },
    { "alpha", "A" },
    { "albedo", "RGB" },
    { "denoise_albedo", "RGB" },
    { "denoise_normal", "XYZ" },
    { "normal", "XYZ" },
    { "depth", "Z" },
    { "motion", "XYZW" },
    { "variance", "RGB" },
    { "samples", "Y" },
    { "emission", "RGB" },
    { "object_index", "X" },
    { "light_key", "RGB" },
    { "light_key.left", "RGB" },
    { "material_index", "X" },
    { "CryptoObject00", "rgba" },
    { "CryptoMaterial02", "rgba" },
};

#define PASSES ( sizeof s_passes / sizeof s_passes[0] )

// What Cycles of Blender 3.4 and 4.3 called the channels of the passes that Reframe has too, with all passes and a light group
// "key" on.
static const char* const s_blender[] = {
    "ViewLayer.Combined.R",
    "ViewLayer.Combined.G",
    "ViewLayer.Combined.B",
    "ViewLayer.Combined.A",
    "ViewLayer.Denoising Albedo.R",
    "ViewLayer.Denoising Albedo.G",
    "ViewLayer.Denoising Albedo.B",
    "ViewLayer.DiffCol.R",
    "ViewLayer.DiffCol.G",
    "ViewLayer.DiffCol.B",
    "ViewLayer.Denoising Normal.X",
    "ViewLayer.Denoising Normal.Y",
    "ViewLayer.Denoising Normal.Z",
    "ViewLayer.Normal.X",
    "ViewLayer.Normal.Y",
    "ViewLayer.Normal.Z",
    "ViewLayer.Depth.Z",
    "ViewLayer.Vector.X",
    "ViewLayer.Vector.Y",
    "ViewLayer.Vector.Z",
    "ViewLayer.Vector.W",
    "ViewLayer.Emit.R",
    "ViewLayer.Emit.G",
    "ViewLayer.Emit.B",
    "ViewLayer.IndexOB.X",
    "ViewLayer.IndexMA.X",
    "ViewLayer.Combined_key.R",
    "ViewLayer.Combined_key.G",
    "ViewLayer.Combined_key.B",
    "ViewLayer.CryptoObject00.r",
    "ViewLayer.CryptoObject00.g",
    "ViewLayer.CryptoObject00.b",
    "ViewLayer.CryptoObject00.a",
    "ViewLayer.CryptoMaterial02.r",
    "ViewLayer.CryptoMaterial02.g",
    "ViewLayer.CryptoMaterial02.b",
    "ViewLayer.CryptoMaterial02.a",
};

static bool has( RfPassNames names, const char* channel )
{
    RfPassChannel made;
    for ( size_t p = 0; p < PASSES; ++p )
    {
        for ( int i = 0; s_passes[p].letters[i] != '\0'; ++i )
        {
            rf_name_pass_channel( names, s_passes[p].name, s_passes[p].letters, i, &made );
            if ( strcmp( made.name, channel ) == 0 )
                return true;
        }
    }
    return false;
}

TEST( test_blender_names_are_blenders )
{
    for ( size_t i = 0; i < sizeof s_blender / sizeof s_blender[0]; ++i )
    {
        if ( !has( RF_NAMES_BLENDER, s_blender[i] ) )
            fail_msg( "no pass is called %s", s_blender[i] );
    }
    // from Blender 5.0 on four have others
    static const char* const five[] = { "ViewLayer.Diffuse Color.R",  "ViewLayer.Emission.B", "ViewLayer.Object Index.X",
                                        "ViewLayer.Material Index.X", "ViewLayer.Combined.A", "ViewLayer.Vector.W" };
    for ( size_t i = 0; i < sizeof five / sizeof five[0]; ++i )
        assert_true( has( RF_NAMES_BLENDER_5, five[i] ) );
    assert_false( has( RF_NAMES_BLENDER_5, "ViewLayer.Emit.R" ) );
    // and none has a dot more, by which Blender would split it
    RfPassChannel made;
    rf_name_pass_channel( RF_NAMES_BLENDER, "light_key.left", "RGB", 1, &made );
    assert_string_equal( made.name, "ViewLayer.Combined_key_left.G" );
    rf_name_pass_channel( RF_NAMES_BLENDER, "variance", "RGB", 2, &made );
    assert_string_equal( made.name, "ViewLayer.variance.B" );
}

// Reserved channels of Nuke (Foundry, Nuke's online help, "Creating Channels and Layers").
TEST( test_nuke_names_are_nukes )
{
    static const char* const channels[] = { "R", "G", "B", "A", "depth.Z", "backward.u", "backward.v", "forward.u", "forward.v" };
    for ( size_t i = 0; i < sizeof channels / sizeof channels[0]; ++i )
        assert_true( has( RF_NAMES_NUKE, channels[i] ) );
    // the layer "CryptoObject00" of a Cryptomatte called "CryptoObject"
    assert_true( has( RF_NAMES_NUKE, "CryptoObject00.r" ) );
    assert_true( has( RF_NAMES_NUKE, "light_key.R" ) );
}

// Values (x, y, z, w) of a pass as a file has them.
static void assert_values( RfPassNames names, const char* pass, const char* letters, const char* const* expected )
{
    for ( int i = 0; letters[i] != '\0'; ++i )
    {
        RfPassChannel made;
        char text[RF_PASS_CHANNEL_SIZE + 4];
        rf_name_pass_channel( names, pass, letters, i, &made );
        snprintf( text, sizeof text, "%s=%s%c", made.name, made.negated ? "-" : "", letters[made.component] );
        assert_string_equal( text, expected[i] );
    }
}

TEST( test_conventions )
{
    const char* const own[] = { "motion.X=X", "motion.Y=Y", "motion.Z=Z", "motion.W=W" };
    const char* const blender[] = { "ViewLayer.Vector.X=X", "ViewLayer.Vector.Y=Y", "ViewLayer.Vector.Z=-Z",
                                    "ViewLayer.Vector.W=-W" };
    const char* const nuke[] = { "backward.u=X", "backward.v=Y", "forward.u=Z", "forward.v=W" };
    const char* const z_up[] = { "ViewLayer.Normal.X=X", "ViewLayer.Normal.Y=-Z", "ViewLayer.Normal.Z=Y" };
    assert_values( RF_NAMES_REFRAME, "motion", "XYZW", own );
    assert_values( RF_NAMES_BLENDER, "motion", "XYZW", blender );
    assert_values( RF_NAMES_BLENDER_5, "motion", "XYZW", blender );
    assert_values( RF_NAMES_NUKE, "motion", "XYZW", nuke );
    assert_values( RF_NAMES_BLENDER, "normal", "XYZ", z_up );
}

// Each channel of each naming is found again by its pass and its letter, with its sign, and by no other.
TEST( test_every_channel_is_found_again )
{
    for ( int n = RF_NAMES_REFRAME; n <= RF_NAMES_NUKE; ++n )
    {
        for ( size_t p = 0; p < PASSES; ++p )
        {
            const Pass* pass = s_passes + p;
            for ( int i = 0; pass->letters[i] != '\0'; ++i )
            {
                RfPassChannel made;
                rf_name_pass_channel( (RfPassNames)n, pass->name, pass->letters, i, &made );
                for ( size_t q = 0; q < PASSES; ++q )
                {
                    for ( int k = 0; s_passes[q].letters[k] != '\0'; ++k )
                    {
                        bool negated, same = p == q && k == made.component;
                        bool found = rf_is_pass_channel( made.name, s_passes[q].name, s_passes[q].letters[k], &negated );
                        if ( found != same || ( same && negated != made.negated ) )
                            fail_msg( "%s: %s of %s.%c", made.name, found ? "taken for one" : "not found as one",
                                      s_passes[q].name, s_passes[q].letters[k] );
                    }
                }
            }
        }
    }
    bool negated;
    assert_true( rf_is_pass_channel( "ViewLayer.DiffCol.G", "albedo", 'G', &negated ) );
    assert_true( rf_is_pass_channel( "View.Depth.V", "depth", 'Z', &negated ) );
    assert_true( rf_is_pass_channel( "depth.depth.Z", "depth", 'Z', &negated ) ); // of a part
    assert_false( rf_is_pass_channel( "albedo.R", RF_PASS_PICTURE, 'R', &negated ) );
    assert_false( rf_is_pass_channel( "mydepth.Z", "depth", 'Z', &negated ) );
}

TEST( test_layers )
{
    char name[RF_PASS_CHANNEL_SIZE];
    rf_name_pass_layer( RF_NAMES_BLENDER, "CryptoObject", name );
    assert_string_equal( name, "ViewLayer.CryptoObject" );
    rf_name_pass_layer( RF_NAMES_NUKE, "CryptoObject", name );
    assert_string_equal( name, "CryptoObject" );
}
