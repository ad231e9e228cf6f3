// reframe flicker reports plain and motion-compensated figures side by side, and finds
// colour and layers spread over the parts of a file.
#include "cli/commands.h"
#include "support/cli_run.h"
#include "support/image_files.h"
#include "image/sequence.h"
#include "support/image_support.h"
#include "support/test.h"

#include <jansson.h>

enum
{
    WIDTH = 20,
    HEIGHT = 10
};

// Runs flicker; further arguments up to NULL.
static int flicker( const char* sequence, ... )
{
    char* arguments[COMMAND_ARGUMENTS] = { "flicker", (char*)cli_path( sequence ), "--json", (char*)cli_path( "out.json" ),
                                           "--quiet" };
    const int count = 5;
    va_list more;
    va_start( more, sequence );
    int status = run_command_to_json( rf_command_flicker, count, arguments, more );
    va_end( more );
    return status;
}

static void check_number( const json_t* object, const char* key, double wanted )
{
    double value = number( object, key );
    if ( !( fabs( value - wanted ) <= 1e-6 * fabs( wanted ) + 1e-12 ) )
        fail_msg( "%s: %.12g, not %.12g", key, value, wanted );
}

static const char* frame_name( const char* pattern, int frame )
{
    static char name[64];
    assert_int_equal( rf_sequence_name( pattern, frame, name, sizeof name, NULL ), RF_OK );
    return name;
}

// A stripe every second column, which moves by a pixel to the right in each frame.
static void write_stripes( const char* pattern, int frame, bool has_motion )
{
    static float motion[2][WIDTH * HEIGHT], depth[WIDTH * HEIGHT];
    AUTO_IMAGE image;
    RfError error = { 0 };
    assert_int_equal( rf_create_image( WIDTH, HEIGHT, &image, &error ), RF_OK );
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            image.rgb[3 * i + c] = ( i % WIDTH + frame ) % 2 == 0 ? 2.0f : 0.0f;
        motion[0][i] = -1.0f;
        depth[i] = 3.0f;
    }
    const RfExrString strings[] = {
        { "reframe/group", "1" }, { "reframe/spp", "4" }, { "reframe/frame", "1" }, { "reframe/frames", "9" }
    };
    const RfExrChannel channels[] = { { .name = "depth.Z", .values = depth, .stride = 1 },
                                      { .name = "motion.X", .values = motion[0], .stride = 1 },
                                      { .name = "motion.Y", .values = motion[1], .stride = 1 } };
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    options.strings = strings;
    options.string_count = frame == 1 ? 4 : 0;
    options.channels = channels;
    options.channel_count = has_motion ? 3 : 0;
    if ( rf_write_exr( cli_path( frame_name( pattern, frame ) ), &image, &options, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

static void write_reference( const char* pattern, int frame )
{
    const Foreign reference = { .names = { "B", "G", "R" }, .values = { 1, 1, 1 }, .width = WIDTH, .height = HEIGHT };
    write_foreign_exr( cli_path( frame_name( pattern, frame ) ), &reference, 1 );
}

// The error alternates where it is and stands still along the motion.
TEST( test_plain_and_followed_figures_side_by_side )
{
    for ( int frame = 1; frame <= 4; ++frame )
    {
        write_stripes( "a.#.exr", frame, true );
        write_reference( "r.#.exr", frame );
    }
    check_done( flicker( "a.#.exr", "--reference", cli_path( "r.#.exr" ), NULL ) );
    json_t* json = load_json();
    const json_t *followed = json_object_get( json, "followed" ), *pair = json_array_get( json_object_get( json, "pairs" ), 2 );
    check_number( json, "phi", 2.0 );
    check_number( json, "f1", 2.0 );
    check_number( json, "coverage", 1.0 );
    assert_true( json_is_false( json_object_get( json, "compensated" ) ) && json_is_null( json_object_get( json, "motion" ) ) );
    assert_true( json_is_false( json_object_get( json, "masked" ) ) && json_is_true( json_object_get( followed, "masked" ) ) );
    const json_t *groups = json_object_get( json, "groups" ),
                 *border = json_object_get( json_object_get( groups, "border" ), "followed" );
    const json_t* const all[] = { followed, json_object_get( pair, "followed" ), border };
    for ( int i = 0; i < 3; ++i )
    {
        check_number( all[i], "phi", 0.0 );
        check_number( all[i], "f1", 0.0 );
        check_number( all[i], "mse", 1.0 );
        check_number( all[i], "coverage", 19.0 / 20.0 );
        check_number( all[i], "motion", 1.0 );
    }
    check_number( followed, "pairs", 3.0 );
    check_number( border, "pairs", 2.0 ); // groups of three in 9 frames: 1-2 and 2-3
    check_number( pair, "phi", 2.0 );
    json_decref( json );
    // the main figures are the compensated ones then, and there are no others
    for ( int i = 0; i < 2; ++i )
    {
        check_done(
            flicker( "a.#.exr", "--reference", cli_path( "r.#.exr" ), i == 0 ? "--compensate" : "--no-compensate", NULL ) );
        json = load_json();
        check_number( json, "phi", i == 0 ? 0.0 : 2.0 );
        assert_null( json_object_get( json, "followed" ) );
        assert_null( json_object_get( json_array_get( json_object_get( json, "pairs" ), 0 ), "followed" ) );
        json_decref( json );
    }
    check_done( flicker( "r.#.exr", "--reference", cli_path( "a.#.exr" ), NULL ) ); // none to follow
    json = load_json();
    assert_null( json_object_get( json, "followed" ) );
    json_decref( json );
    check_failed( flicker( "r.#.exr", "--reference", cli_path( "a.#.exr" ), "--depth", "R", NULL ), 1, "has no motion layer" );
    check_failed( flicker( "a.#.exr", "--reference-layer", "R", NULL ), 2, "--reference-layer" );
}

// Pairs whose frames lack the layers are left out of the second figures alone.
TEST( test_pairs_without_motion_are_left_out )
{
    for ( int frame = 1; frame <= 5; ++frame )
    {
        write_stripes( "s.#.exr", frame, frame != 1 && frame != 4 );
        write_reference( "r.#.exr", frame );
    }
    check_done( flicker( "s.#.exr", "--reference", cli_path( "r.#.exr" ), NULL ) );
    json_auto_t* json = load_json();
    const json_t* pairs = json_object_get( json, "pairs" );
    check_number( json, "phi", 2.0 );
    check_number( json_object_get( json, "followed" ), "pairs", 1.0 );
    for ( size_t i = 0; i < 4; ++i ) // depth of both is wanted too
        assert_true( json_is_object( json_object_get( json_array_get( pairs, i ), "followed" ) ) == ( i == 1 ) );
    check_failed( flicker( "s.#.exr", "--reference", cli_path( "r.#.exr" ), "--compensate", NULL ), 1,
                  "s.1.exr: has no motion layer" );
    check_failed( flicker( "s.#.exr", "--frames", "2-5", NULL ), 1, "s.4.exr: has no channel motion.X" );
}

static void write_parts( const char* name, const Foreign* parts, int count )
{
    write_foreign_exr( cli_path( name ), parts, count );
}

// Depth in the first part, motion in the second, colour in the third, and a normal to be left alone.
TEST( test_layers_found_across_parts )
{
    Foreign parts[4] = {
        { .names = { "Z" }, .values = { 7 }, .x = 3, .y = 5, .width = WIDTH, .height = HEIGHT, .part = "depth" },
        { .names = { "X", "Y" },
          .values = { 5, 0 },
          .x = 3,
          .y = 5,
          .width = WIDTH,
          .height = HEIGHT,
          .half = true,
          .part = "motion" },
        { .names = { "B", "G", "R" }, .values = { 1, 1, 1 }, .x = 3, .y = 5, .width = WIDTH, .height = HEIGHT, .part = "rgba" },
        { .names = { "X", "Y", "Z" }, .values = { 4, 4, 4 }, .x = 3, .y = 5, .width = WIDTH, .height = HEIGHT, .part = "normal" }
    };
    write_parts( "p.1.exr", parts, 4 );
    parts[2].values[0] = parts[2].values[1] = parts[2].values[2] = 4.0f;
    parts[0].values[0] = 7.1f; // within 2 %
    write_parts( "p.2.exr", parts, 4 );
    check_done( flicker( "p.#.exr", NULL ) );
    json_t* json = load_json();
    assert_true( json_is_true( json_object_get( json, "compensated" ) ) && json_is_true( json_object_get( json, "masked" ) ) );
    check_number( json, "f1", 3.0 );
    check_number( json, "coverage", 15.0 / 20.0 );
    check_number( json, "motion", 5.0 );
    json_decref( json );
    // by name, behind the part's or not; depth that differs is not seen
    check_done( flicker( "p.#.exr", "--motion", "motion.X,motion.Y", "--depth", "rgba.R", NULL ) );
    json = load_json();
    check_number( json, "coverage", 0.0 );
    json_decref( json );
    check_failed( flicker( "p.#.exr", "--motion", "motion.X,motion.Z", NULL ), 1, "has no channel motion.Z" );
    // other layers, of the reference too
    check_done( flicker( "p.#.exr", "--layer", "Z", "--no-compensate", NULL ) );
    json = load_json();
    check_number( json, "f1", 0.1 );
    json_decref( json );
    check_done( flicker( "p.#.exr", "--reference", cli_path( "p.#.exr" ), "--layer", "R", "--reference-layer", "G,B,R", NULL ) );
    json = load_json();
    check_number( json, "relmse", 0.0 );
    check_number( json_object_get( json, "followed" ), "coverage", 15.0 / 20.0 );
    json_decref( json );
    check_failed( flicker( "p.#.exr", "--layer", "none", NULL ), 1, "has no layer none" );
    check_failed( flicker( "p.#.exr", "--reference", cli_path( "p.#.exr" ), "--reference-layer", "none", NULL ), 1,
                  "has no layer none" );
    // a part that lies elsewhere: to be reported, or left out beside the plain figures
    parts[1].x = 2;
    write_parts( "p.2.exr", parts, 4 );
    check_failed( flicker( "p.#.exr", NULL ), 1,
                  "p.2.exr: motion.X has 20x10 pixels from (2, 5) on, depth.Z 20x10 from (3, 5) on" );
    check_done( flicker( "p.#.exr", "--reference", cli_path( "p.#.exr" ), NULL ) );
    json = load_json();
    check_number( json_object_get( json, "followed" ), "pairs", 0.0 );
    json_decref( json );
}

// Two eyes in one file: the layers of the part whose colour is measured.
TEST( test_layers_of_the_measured_view )
{
    for ( int frame = 1; frame <= 2; ++frame )
    {
        float value = (float)frame;
        const Foreign views[2] = { { .names = { "B", "G", "R", "motion.X", "motion.Y" },
                                     .values = { value, value, value, 5, 0 },
                                     .width = WIDTH,
                                     .height = HEIGHT,
                                     .part = "left" },
                                   { .names = { "B", "G", "R", "motion.X", "motion.Y" },
                                     .values = { 3 * value, 3 * value, 3 * value, 10, 0 },
                                     .width = WIDTH,
                                     .height = HEIGHT,
                                     .part = "right" } };
        write_parts( frame_name( "v.#.exr", frame ), views, 2 );
    }
    for ( int k = 0; k < 2; ++k )
    {
        check_done( flicker( "v.#.exr", k == 1 ? "--layer" : NULL, "right", NULL ) );
        json_auto_t* json = load_json();
        check_number( json, "f1", k == 0 ? 1.0 : 3.0 );
        check_number( json, "motion", k == 0 ? 5.0 : 10.0 );
    }
    Foreign both[2] = {
        { .names = { "B", "G", "R" }, .values = { 1, 1, 1 }, .width = WIDTH, .height = HEIGHT, .part = "rgba" },
        { .names = { "a.motion.X", "a.motion.Y", "b.motion.X", "b.motion.Y" }, .width = WIDTH, .height = HEIGHT, .part = "m" }
    };
    write_parts( "v.1.exr", both, 2 );
    write_parts( "v.2.exr", both, 2 );
    check_failed( flicker( "v.#.exr", NULL ), 1, "has both m.a.motion.X and m.b.motion.X: choose by --motion X,Y" );
    check_done( flicker( "v.#.exr", "--motion", "m.a.motion.X,b.motion.Y", NULL ) );
    // beside the plain figures it is no failure
    check_done( flicker( "v.#.exr", "--reference", cli_path( "v.#.exr" ), NULL ) );
    json_auto_t* json = load_json();
    assert_null( json_object_get( json, "followed" ) );
    check_failed( flicker( "v.#.exr", "--reference", cli_path( "v.#.exr" ), "--depth", "R", NULL ), 1, "choose by --motion" );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
