// reframe render --aov as a user sees it: the channels in the files, and what is refused.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "film/cryptomatte.h"
#include "image/exr.h"

#include <jansson.h>

#define ALL "albedo,normal,denoise_albedo,denoise_normal,depth,motion,variance,half,samples,object_index,material_index"
#define PASSES "emission,direct,indirect,reflection,transmission"
#define SMALL "--size 48x27 --spp 6 --group 1 --frames 10-11 --quiet"

// One channel of a frame, to be freed; NULL where it has none.
static float* channel_of( const char* name, const char* channel, int width, int height )
{
    RfExrWindow window;
    float* values = cli_read_channel( name, channel, &window );
    if ( values == NULL )
        return NULL;
    assert_true( window.width == width && window.height == height );
    return values;
}

TEST( test_every_channel_is_written )
{
    static const char* const names[] = { "denoise_albedo.R",
                                         "denoise_albedo.G",
                                         "denoise_albedo.B",
                                         "denoise_normal.X",
                                         "denoise_normal.Y",
                                         "denoise_normal.Z",
                                         "albedo.R",
                                         "albedo.G",
                                         "albedo.B",
                                         "normal.X",
                                         "normal.Y",
                                         "normal.Z",
                                         "depth.Z",
                                         "motion.X",
                                         "motion.Y",
                                         "motion.Z",
                                         "motion.W",
                                         "direct.G",
                                         "indirect.B",
                                         "variance.R",
                                         "variance.G",
                                         "variance.B",
                                         "samples.Y",
                                         "R",
                                         "G",
                                         "B",
                                         "object_index.X",
                                         "material_index.X" };
    cli_expect( cli_run( "$R render $VASE -o a/f.####.exr " SMALL " --aov " ALL "," PASSES ), 0, NULL );
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        AUTO_FREE float* values = channel_of( "a/f.0010.exr", names[i], 48, 27 );
        assert_non_null( values );
        double sum = 0.0;
        for ( int k = 0; k < 48 * 27; ++k )
        {
            assert_true( isfinite( values[k] ) );
            sum += fabs( (double)values[k] );
        }
        if ( !( sum > 0.0 ) )
            fail_msg( "%s is 0 everywhere", names[i] );
    }
    assert_null( channel_of( "a/f.0010.exr", "alpha.A", 48, 27 ) );
    AUTO_FREE float* glass = channel_of( "a/f.0010.exr", "transmission.R", 48, 27 );
    assert_non_null( glass );
    // the colour is what it is without, and other commands find it
    cli_expect( cli_run( "$R render $VASE -o b/f.####.exr " SMALL ), 0, NULL );
    const CliResult* result = cli_run( "$R compare a/f.####.exr b/f.####.exr --json -" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "\"max\": 0.0" ) );
    cli_expect( cli_run( "$R png a/f.0010.exr a.png" ), 0, NULL );
    // threads and frames alone make no difference to the bytes
    cli_expect(
        cli_run( "$R render $VASE -o c/f.####.exr --threads 3 --size 48x27 --spp 6 --group 1 --frames 11 --quiet --aov " ALL
                 "," PASSES ),
        0, NULL );
    cli_expect( cli_run( "cmp a/f.0011.exr c/f.0011.exr" ), 0, NULL );
    // only what was asked for
    cli_expect( cli_run( "$R render $VASE -o d/f.####.exr " SMALL " --aov depth --float" ), 0, NULL );
    AUTO_FREE float* depth = channel_of( "d/f.0010.exr", "depth.Z", 48, 27 );
    assert_true( depth != NULL && depth[0] > 0.1f && depth[0] < 100.0f );
    assert_null( channel_of( "d/f.0010.exr", "albedo.R", 48, 27 ) );
}

TEST( test_wrong_names_are_refused )
{
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov colour" ), 2,
                "reframe render: --aov: unknown AOV 'colour', expected " ALL ",removed," PASSES ",primal,dx,dy" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth,normals" ), 2, "did you mean normal?" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth,,normal" ), 2, "unknown AOV ''" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth," ), 2, "unknown AOV ''" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov ''" ), 2, "--aov" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth,normal,depth" ), 2, "--aov: AOV depth is given twice" );
    assert_false( cli_exists( "r.exr" ) );
}

TEST( test_resume_wants_the_same_aovs )
{
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --aov depth,albedo" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --resume --aov albedo,depth" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --resume" ), 1, "--resume: s/f.0010.exr" );
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --resume --aov albedo" ), 1, "--resume: s/f.0010.exr" );
    cli_expect( cli_run( "$R render $VASE -o b/f.####.exr " SMALL " --resume --aov depth" ), 1, "--resume: b/f.0010.exr" );
}

// The mattes of a name in a frame: the sum of the coverages of its id over all ranks.
static double coverage_of( const char* name, const char* kind, const char* attribute, const char* what )
{
    char channel[64];
    float id = 0.0f;
    double sum = 0.0;
    const char* manifest = cli_exr_text( name, attribute );
    assert_non_null( manifest );
    json_auto_t* json = json_loads( manifest, 0, NULL );
    const char* digits = json_string_value( json_object_get( json, what ) );
    assert_non_null( digits );
    uint32_t bits = (uint32_t)strtoul( digits, NULL, 16 );
    memcpy( &id, &bits, sizeof id );
    for ( int rank = 0; rank < 6; ++rank )
    {
        snprintf( channel, sizeof channel, "%s%02d.%c", kind, rank / 2, "rb"[rank % 2] );
        AUTO_FREE float* ids = channel_of( name, channel, 48, 27 );
        snprintf( channel, sizeof channel, "%s%02d.%c", kind, rank / 2, "ga"[rank % 2] );
        AUTO_FREE float* coverage = channel_of( name, channel, 48, 27 );
        assert_true( ids != NULL && coverage != NULL );
        for ( int i = 0; i < 48 * 27; ++i )
        {
            assert_true( coverage[i] >= 0.0f && coverage[i] <= 1.0f );
            sum += ids[i] == id ? (double)coverage[i] / ( 48 * 27 ) : 0.0;
        }
    }
    return sum;
}

// Every compression leaves the ids as they are, and so do names and parts.
TEST( test_mattes_are_found_by_name )
{
    static const char* const s_options[] = { "", " --compression dwaa", " --names blender",
                                             " --parts each --light-groups lamps" };
    double vase = 0.0;
    for ( int i = 0; i < 4; ++i )
    {
        char command[256], layer[64];
        snprintf( command, sizeof command, "$R render $VASE -o m/f%d.####.exr " SMALL " --cryptomatte object,asset%s", i,
                  s_options[i] );
        cli_expect( cli_run( "%s", command ), 0, NULL );
        char name[64], attribute[64];
        snprintf( name, sizeof name, "m/f%d.0010.exr", i );
        snprintf( layer, sizeof layer, "%sCryptoObject", i == 2 ? "ViewLayer." : "" );
        snprintf( attribute, sizeof attribute, "cryptomatte/%07x/manifest", rf_murmur3_32( layer ) >> 4 );
        double here = coverage_of( name, layer, attribute, "vase" );
        vase = i == 0 ? here : vase;
        assert_true( here == vase && here > 0.01 && here < 0.9 );
        assert_null( channel_of( name, "CryptoMaterial00.r", 48, 27 ) );
        AUTO_FREE float* group = channel_of( name, "light_light.G", 48, 27 ); // beside mattes
        assert_true( ( group != NULL ) == ( i == 3 ) );
    }
    cli_expect( cli_run( "$R render $VASE -o m/f0.####.exr " SMALL " --cryptomatte asset,object --resume" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o m/f0.####.exr " SMALL " --resume --cryptomatte object" ), 1,
                "cryptomatte object,asset" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --cryptomatte objects" ), 2,
                "--cryptomatte: unknown Cryptomatte 'objects', did you mean object?" );
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL " --estimator gradient --cryptomatte object" ), 2,
                "the estimator 'gradient' has no Cryptomatte" );
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL " --estimator gradient --aov object_index" ), 2,
                "the estimator 'gradient' has no Cryptomatte" );
}

// MurmurHash3 of "c100368" and "c119089" is the same.
TEST( test_names_of_one_id_are_named )
{
    const char* warning = "warning: two.gltf: 'c100368' and 'c119089' have one Cryptomatte id, 51d7b4d8, and so one matte";
    write_room( "" ); // equal names are one thing
    cli_expect( cli_run( "sed 's/wood floor/c100368/;s/\"lamp\"/\"c119089\"/' room.gltf >two.gltf" ), 0, NULL );
    cli_expect( cli_run( "$R info two.gltf" ), 0, warning ); // one line
    cli_expect( cli_run( "$R info room.gltf 2>&1 >told | { ! grep Cryptomatte; }" ), 0, NULL );
    const CliResult* result = cli_run( "$R render two.gltf -o t.exr --size 8x6 --spp 1 --group 0 --quiet --cryptomatte object" );
    assert_null( strstr( result->err, "Cryptomatte" ) ); // materials alone have these names
    cli_expect( cli_run( "$R render two.gltf -o u.exr --size 8x6 --spp 1 --group 0 --quiet --cryptomatte object,material" ), 0,
                warning );
}

TEST( test_variance_of_one_pass )
{
    const CliResult* result =
        cli_run( "$R render $VASE -o v.exr --size 8x6 --spp 1 --group 0 --frames 3 --quiet --aov variance" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->err, "warning: --aov variance: will be 0 in frame 3" ) );
    AUTO_FREE float* values = channel_of( "v.exr", "variance.G", 8, 6 );
    for ( int i = 0; i < 48; ++i )
        assert_true( values[i] == 0.0f );
    result = cli_run( "$R render $VASE -o w.exr --size 8x6 --spp 2 --group 0 --frames 3 --quiet --aov variance" );
    cli_expect( result, 0, NULL );
    assert_string_equal( result->err, "" );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
