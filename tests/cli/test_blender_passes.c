// Passes in Blender's compositor: a scene made inside Blender (support/blender_passes.py) is exported, rendered with the options
// that the exporter names, and its frames go through the nodes Image, Cryptomatte and Mix. Skipped where Blender or its numpy is
// missing.
#include "support/blender_run.h"
#include "support/statistics.h"

#include "gltf/gltf.h"
#include "scene/light_groups.h"
#include "scene/placement.h"

#define SIZE "64x36"
#define SAMPLES 128 // of a pixel, traced for the frame itself
#define SEEDS 8
#define PARTS 36 // three channels of 12 parts of the picture

// Exports a scene; returns the options for the passes of its view layer.
static const char* export_scene( const char* scene )
{
    static char s_options[1024];
    const CliResult* done = blender_export( scene, "--no-bake 2> err" );
    const char *begin = strstr( done->out, "passes of 'ViewLayer': " ), *end = begin != NULL ? strchr( begin, '\n' ) : NULL;
    if ( done->status != 0 || end == NULL )
        fail_msg( "%s: says of no passes: %s", scene, done->out );
    snprintf( s_options, sizeof s_options, "%.*s", (int)( end - begin - 23 ), begin + 23 );
    return s_options;
}

static int material_index( const RfScene* scene, const char* name )
{
    return (int)( find_material( scene, name ) - scene->materials );
}

// An object with this name, asset and number.
static bool has_object( const RfScene* scene, const char* name, const char* asset, int pass_index )
{
    for ( int i = 0; i < scene->node_count; ++i )
    {
        if ( strcmp( rf_object_name( scene, i ), name ) == 0 && strcmp( rf_asset_name( scene, i ), asset ) == 0 &&
             scene->nodes[i].pass_index == pass_index )
            return true;
    }
    return false;
}

BLENDER_TEST( test_names_and_groups_are_carried )
{
    blender_make( "passes make" );
    export_scene( "passes" );
    AUTO_SCENE scene = convert_load( "passes.glb" );
    static const struct
    {
        const char *name, *asset;
        int pass_index;
    } s_objects[] = { { "Floor", "Floor", 4 }, { "Left box", "Set", 1 }, { "Mid", "Set", 2 }, { "Right", "Right", 5 },
                      { "Stone", "Stone", 9 }, { "Strip", "Strip", 0 },  { "Top", "Top", 0 } };
    for ( size_t i = 0; i < sizeof s_objects / sizeof *s_objects; ++i )
    {
        if ( !has_object( &scene, s_objects[i].name, s_objects[i].asset, s_objects[i].pass_index ) )
            fail_msg( "there is no object '%s' of '%s' with the index %d", s_objects[i].name, s_objects[i].asset,
                      s_objects[i].pass_index );
    }
    assert_int_equal( find_material( &scene, "Red paint" )->pass_index, 3 );
    assert_int_equal( find_material( &scene, "Blue.001" )->pass_index, 7 );
    AUTO_BY( rf_destroy_light_groups ) RfLightGroups groups;
    assert_int_equal( rf_find_light_groups( &scene, "all", &groups, NULL ), RF_OK );
    assert_int_equal( groups.count, 2 ); // all light is in one of them
    assert_string_equal( groups.names[groups.punctual[0]], "fill light" );
    assert_string_equal( groups.names[groups.sky], "fill light" );
    assert_string_equal( groups.names[groups.material[material_index( &scene, "Key" )]], "key" );
    assert_string_equal( groups.names[groups.material[material_index( &scene, "Top" )]], "fill light" );
}

#define OPTIONS                                                                                                                  \
    "--aov depth,normal,motion,object_index,material_index,denoise_albedo,denoise_normal "                                       \
    "--cryptomatte object,material,asset --light-groups all --compression zips --names "

BLENDER_TEST( test_compositor_takes_the_passes )
{
    const char* wanted = blender_major() < 5 ? OPTIONS "blender" : OPTIONS "blender5";
    blender_make( "passes make" );
    const char* options = export_scene( "passes" );
    assert_string_equal( options, wanted );
    size_t size;
    AUTO_FREE char* said = cli_read( "err", &size );
    expect_said( said, "Cryptomatte of 'ViewLayer': 6 levels here, not 8\n" );
    expect_said( said, "passes of 'ViewLayer' that are not rendered here: Mist\n" );
    cli_expect( cli_run( "$R render passes.glb -o f.####.exr --size " SIZE " --spp %d --group 1 %s --quiet", SAMPLES, options ),
                0, NULL );
    cli_expect(
        cli_run( "$R render passes.glb -o noisy.####.exr --frames 2 --size " SIZE " --spp 4 --group 0 %s --quiet", options ), 0,
        NULL );
    const char* found = blender_make( "passes look f.0002.exr %d noisy.0002.exr", SAMPLES )->out;
    expect_said( found, "the passes are Blender's\n" );
    if ( strstr( found, "no OpenImageDenoise" ) != NULL )
        print_message( "skipped: the Denoise node, without OpenImageDenoise\n" );
}

// Of the frame with each seed: its groups mixed anew, and the frame itself.
typedef struct Means
{
    double mixed[PARTS][SEEDS], whole[PARTS][SEEDS];
} Means;

// Frames of a scene with seeds of their own, read by Blender.
static void render_seeds( const char* scene, uint64_t seed, const char* options, Means* means )
{
    char arguments[1024], *at = arguments + snprintf( arguments, sizeof arguments, "mix %s.txt", scene );
    for ( int i = 0; i < SEEDS; ++i )
    {
        cli_expect( cli_run( "$R render %s.glb -o %s-%d.####.exr --frames 2 --size " SIZE
                             " --spp %d --group 1 --seed %llu %s --float --quiet",
                             scene, scene, i, 16 * suite_samples(), (unsigned long long)( suite_seed() + seed + (uint64_t)i ),
                             options ),
                    0, NULL );
        at += snprintf( at, (size_t)( arguments + sizeof arguments - at ), " %s-%d.0002.exr", scene, i );
    }
    blender_make( "passes %s", arguments );
    char name[80];
    snprintf( name, sizeof name, "%s.txt", scene );
    size_t size;
    char *text = cli_read( name, &size ), *next = text;
    for ( int i = 0; i < SEEDS; ++i )
    {
        for ( int part = 0; part < PARTS; ++part )
            means->mixed[part][i] = strtod( next, &next );
        for ( int part = 0; part < PARTS; ++part )
            means->whole[part][i] = strtod( next, &next );
    }
    assert_true( means->whole[0][SEEDS - 1] > 0.0 );
    free( text );
}

// Lamps of two groups dimmed in the compositor give the picture of lamps that are dimmed.
BLENDER_TEST( test_groups_are_balanced_in_the_compositor )
{
    blender_make( "passes make" );
    export_scene( "passes" );
    expect_said( export_scene( "balanced" ),
                 "--light-groups all --compression dwaa --names blender" ); // --float is refused beside it
    size_t size;
    AUTO_FREE char* said = cli_read( "err", &size );
    expect_said( said, "files of 'Scene': colours that DWAA compresses have 16 bits\n" );
    static Means s_split, s_dimmed;
    render_seeds( "passes", 1, "--light-groups all --names blender", &s_split );
    render_seeds( "balanced", 101, "--names blender", &s_dimmed );
    int apart = 0;
    for ( int i = 0; i < PARTS; ++i )
    {
        double p = welch_p( s_split.mixed[i], SEEDS, s_dimmed.whole[i], SEEDS );
        if ( !is_likely( p ) )
            fail_msg( "part %d, channel %d: %g mixed, %g dimmed: p = %g", i / 3, i % 3, mean_of( s_split.mixed[i], SEEDS, NULL ),
                      mean_of( s_dimmed.whole[i], SEEDS, NULL ), p );
        apart += welch_p( s_split.whole[i], SEEDS, s_dimmed.whole[i], SEEDS ) < FIRST_LEVEL;
    }
    if ( apart < PARTS / 2 )
        fail_msg( "only %d of %d means tell the picture from the dimmed one", apart, PARTS );
}

STATISTICAL_TESTS
