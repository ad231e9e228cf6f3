// reframe flicker as a script sees it: JSON, files of Reframe and of other programs, and
// what it refuses.
#include "cli/commands.h"
#include "measure/flicker_sequence.h"
#include "support/cli_run.h"
#include "support/image_files.h"
#include "image/sequence.h"
#include "measure/flicker_sequence.h"
#include "support/image_support.h"
#include "support/test.h"

#include <jansson.h>
#include <unistd.h>

enum
{
    SIDE = 24,
    PIXELS = SIDE * SIDE
};

static const char* frame_name( const char* pattern, int frame )
{
    static char name[64];
    assert_int_equal( rf_sequence_name( pattern, frame, name, sizeof name, NULL ), RF_OK );
    return name;
}

static void write_frame( const char* name, int side, float value, const RfExrOptions* more )
{
    AUTO_IMAGE image;
    RfError error = { 0 };
    assert_int_equal( rf_create_image( side, side, &image, &error ), RF_OK );
    for ( int i = 0; i < 3 * side * side; ++i )
        image.rgb[i] = value;
    RfExrOptions options = more != NULL ? *more : rf_default_exr_options();
    options.half = false;
    if ( rf_write_exr( cli_path( name ), &image, &options, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

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

static bool is_near( double a, double b ) { return fabs( a - b ) <= 1e-7 * fabs( b ) + 1e-12; }

// Errors 1, 1, -1, 3 against a constant: pairs 0, 2, 4; φ 0, 2, 1.6.
TEST( test_phi_against_a_constant_by_hand )
{
    static const float errors[] = { 1, 1, -1, 3 };
    for ( int i = 0; i < 4; ++i )
    {
        write_frame( frame_name( "v.####.exr", 7 + i ), SIDE, 5.0f + errors[i], NULL );
        write_frame( frame_name( "r.####.exr", 7 + i ), SIDE, 5.0f, NULL );
    }
    check_done( flicker( "v.####.exr", "--reference", cli_path( "r.####.exr" ), "--border", "2", NULL ) );
    json_t* json = load_json();
    const json_t* pairs = json_object_get( json, "pairs" );
    assert_string_equal(
        json_string_value( json_object_get( json, "verdict" ) ),
        "the error alternates: it flickers more than independent noise (phi 1.43)\nFlicker 52 % (RMS change of the error "
        "from frame to frame, in place, largest at frame 10: 80 %); relMSE 0.36 (35 % noise per pixel)" );
    assert_int_equal( json_array_size( pairs ), 3 );
    static const double f1[] = { 0, 2, 4 }, phi[] = { 0, 2, 1.6 };
    for ( size_t i = 0; i < 3; ++i )
    {
        const json_t* pair = json_array_get( pairs, i );
        assert_true( number( pair, "frame" ) == 8.0 + (double)i );
        assert_true( is_near( number( pair, "f1" ), f1[i] ) && is_near( number( pair, "phi" ), phi[i] ) );
        assert_true( number( pair, "coverage" ) == 1.0 );
        assert_true( json_is_true( json_object_get( pair, "border" ) ) == ( i == 1 ) ); // 7 8 | 9 10
    }
    assert_true( is_near( number( json, "f1" ), sqrt( 20.0 / 3.0 ) ) && is_near( number( json, "phi" ), 20.0 / 14.0 ) );
    assert_true( is_near( number( json, "f1_relative" ), sqrt( 20.0 / 3.0 / 25.001 ) ) );
    assert_true( is_near( number( json, "mse" ), 14.0 / 6.0 ) && is_near( number( json, "relmse" ), 3.0 * 3.0 / 25.001 ) );
    assert_true( json_is_false( json_object_get( json, "compensated" ) ) );
    assert_string_equal( json_string_value( json_object_get( json, "error_from" ) ), "reference" );
    const json_t *groups = json_object_get( json, "groups" ), *border = json_object_get( groups, "border" );
    assert_true( number( border, "pairs" ) == 1.0 && is_near( number( border, "f1" ), 2.0 ) );
    assert_true( is_near( number( json_object_get( groups, "inside" ), "f1" ), sqrt( 8.0 ) ) );
    const json_t* spectrum = json_object_get( json, "spectrum" );
    assert_true( number( spectrum, "frames" ) == 4.0 && number( spectrum, "windows" ) == 1.0 &&
                 is_near( number( spectrum, "split" ), 2.0 / 24.0 ) && json_is_null( json_object_get( spectrum, "drift" ) ) );
    double frozen = number( spectrum, "frozen" ), boiling = number( spectrum, "boiling" );
    assert_true( is_near( frozen, sqrt( 1.0 / 25.001 ) ) && is_near( frozen * frozen + boiling * boiling, 3.0 / 25.001 ) );
    json_decref( json );
    // against itself nothing is left; part of the frames; no spectrum
    check_done( flicker( "v.####.exr", "--reference", cli_path( "v.####.exr" ), "--frames", "8-9", "--no-spectrum", NULL ) );
    json = load_json();
    assert_true( number( json, "f1" ) == 0.0 && number( json, "phi" ) == 0.0 && number( json, "relmse" ) == 0.0 );
    assert_int_equal( json_array_size( json_object_get( json, "pairs" ) ), 1 );
    assert_true( json_is_null( json_object_get( json, "spectrum" ) ) && json_is_null( json_object_get( json, "groups" ) ) );
    json_decref( json );
}

// Without a reference and layers: plain differences, φ unknown.
TEST( test_without_reference_phi_is_unknown )
{
    check_done( flicker( "v.####.exr", "--png", cli_path( "slit.png" ), "--column", "24", "--exposure", "-3", NULL ) );
    json_auto_t* json = load_json();
    assert_true( is_near( number( json, "f1" ), sqrt( 20.0 / 3.0 ) ) && json_is_null( json_object_get( json, "phi" ) ) );
    assert_true( json_is_null( json_object_get( json, "error_from" ) ) && json_is_null( json_object_get( json, "relmse" ) ) );
    assert_true( json_is_null( json_object_get( json_object_get( json, "spectrum" ), "frozen" ) ) );
    size_t size;
    AUTO_FREE char* png = cli_read( "slit.png", &size );
    const unsigned char* b = (const unsigned char*)png;
    assert_memory_equal( png, "\x89PNG", 4 );
    assert_int_equal( b[18] * 256 + b[19], 480 ); // four frames, each 120 wide
    assert_int_equal( b[22] * 256 + b[23], SIDE );
}

// Ours: motion, depth and variance by their names, the group from the header.
TEST( test_own_layers_are_found_by_name )
{
    static float motion[2][PIXELS], depth[PIXELS], variance[PIXELS];
    for ( int i = 0; i < PIXELS; ++i )
    {
        motion[0][i] = i % SIDE < 4 ? -9.0f : 0.0f; // 4 columns come from outside
        motion[1][i] = 0.0f;
        depth[i] = i % SIDE == 23 ? 1e10f : 2.0f;
        variance[i] = 0.5f;
    }
    static const char* const names[][6] = { { "motion.X", "motion.Y", "depth.Z", "variance.R", "variance.G", "variance.B" },
                                            { "View.Vector.X", "View.Vector.Y", "View.Depth.Z", "View.variance.R",
                                              "View.variance.G", "View.variance.B" } };
    for ( int set = 0; set < 2; ++set )
    {
        for ( int frame = 1; frame <= 3; ++frame )
        {
            char number_text[8];
            snprintf( number_text, sizeof number_text, "%d", frame );
            const RfExrString strings[] = {
                { "reframe/group", "1" }, { "reframe/spp", "4" }, { "reframe/frame", number_text }, { "reframe/frames", "9" }
            };
            const RfExrChannel channels[] = { { .name = names[set][0], .values = motion[0], .stride = 1 },
                                              { .name = names[set][1], .values = motion[1], .stride = 1, .half = set == 1 },
                                              { .name = names[set][2], .values = depth, .stride = 1 },
                                              { .name = names[set][3], .values = variance, .stride = 1, .half = true },
                                              { .name = names[set][4], .values = variance, .stride = 1, .half = true },
                                              { .name = names[set][5], .values = variance, .stride = 1, .half = true } };
            RfExrOptions options = rf_default_exr_options();
            options.strings = strings;
            options.string_count = set == 0 ? 4 : 0;
            options.channels = channels;
            options.channel_count = 6;
            write_frame( frame_name( set == 0 ? "m.##.exr" : "n.##.exr", frame ), SIDE, (float)( frame % 2 ), &options );
        }
    }
    for ( int set = 0; set < 2; ++set )
    {
        check_done( flicker( set == 0 ? "m.##.exr" : "n.##.exr", NULL ) );
        json_auto_t* json = load_json();
        assert_true( json_is_true( json_object_get( json, "compensated" ) ) &&
                     json_is_true( json_object_get( json, "masked" ) ) );
        assert_true( is_near( number( json, "f1" ), 1.0 ) && is_near( number( json, "phi" ), 1.0 ) &&
                     is_near( number( json, "mse" ), 0.5 ) );
        assert_true( is_near( number( json, "coverage" ), 20.0 / 24.0 ) );
        assert_string_equal( json_string_value( json_object_get( json, "error_from" ) ), "variance" );
        const json_t* groups = json_object_get( json, "groups" );
        if ( set == 0 ) // groups of three: frames 1 and 2 of 9 lie in fewer
            assert_true( number( json_object_get( groups, "border" ), "pairs" ) == 2.0 );
        else
            assert_true( json_is_null( groups ) );
    }
    check_done( flicker( "m.##.exr", "--no-compensate", NULL ) );
    json_t* json = load_json();
    assert_true( json_is_false( json_object_get( json, "compensated" ) ) && number( json, "coverage" ) == 1.0 );
    json_decref( json );
    // the error along the motion: variance does not count then
    check_done( flicker( "m.##.exr", "--reference", cli_path( "n.##.exr" ), "--compensate", NULL ) );
    json = load_json();
    assert_true( json_is_true( json_object_get( json, "compensated" ) ) && number( json, "f1" ) == 0.0 );
    assert_true( is_near( number( json, "coverage" ), 20.0 / 24.0 ) );
    json_decref( json );
    // channels by name, the same one twice too
    check_done( flicker( "m.##.exr", "--motion", "motion.Y,motion.Y", "--depth", "variance.R", NULL ) );
    json = load_json();
    assert_true( number( json, "coverage" ) == 1.0 );
    json_decref( json );
    check_failed( flicker( "m.##.exr", "--motion", "motion.X,none", NULL ), 1, "no channel none" );
    check_failed( flicker( "m.##.exr", "--depth", "none", NULL ), 1, "no channel none" );
    check_failed( flicker( "m.##.exr", "--motion", "motion.X", NULL ), 2, "must be the names of two channels" );
    check_failed( flicker( "m.##.exr", "--motion", "motion.X,motion.Y", "--no-compensate", NULL ), 2, "--motion" );
    check_failed( flicker( "v.####.exr", "--compensate", NULL ), 1, "has no motion layer" );
}

TEST( test_groups_of_files )
{
    RfSeams seams = rf_read_seams( cli_path( "m.02.exr" ), 102, 103 );
    assert_true( seams.slides && seams.first == 101 && seams.plan.frames == 9 && seams.plan.eyes == 3 );
    assert_false( rf_has_seams( &( RfSeams ){ 0 } ) );
    seams = rf_read_seams( cli_path( "n.02.exr" ), 2, 3 );
    assert_false( rf_has_seams( &seams ) );
}

// Two shots: the picture changes at the cut alone, and each has the groups of a path of its own.
TEST( test_no_flicker_across_cuts )
{
    for ( int frame = 1; frame <= 18; ++frame )
    {
        char number_text[8];
        snprintf( number_text, sizeof number_text, "%d", frame );
        const RfExrString strings[] = { { "reframe/group", "1" },
                                        { "reframe/spp", "4" },
                                        { "reframe/frame", number_text },
                                        { "reframe/frames", "18" },
                                        { "reframe/shot", frame < 3 ? "1-2" : "3-18" } };
        RfExrOptions options = rf_default_exr_options();
        options.strings = strings;
        options.string_count = 5;
        write_frame( frame_name( "cut.##.exr", frame ), SIDE, frame < 3 ? 1.0f : 5.0f, &options );
    }
    check_done( flicker( "cut.##.exr", "--spectrum", NULL ) );
    json_auto_t* json = load_json();
    assert_true( number( json, "f1" ) == 0.0 && number( json, "cuts" ) == 1.0 );
    assert_int_equal( json_array_size( json_object_get( json, "pairs" ) ), 16 );
    assert_true( number( json_object_get( json, "spectrum" ), "windows" ) == 1.0 ); // of those that end with frames 16 and 18
    // of the 15 pairs of the second shot the first two and the last two are in fewer or longer groups; the first is one group
    const json_t* groups = json_object_get( json, "groups" );
    assert_true( number( json_object_get( groups, "border" ), "pairs" ) == 4.0 );
    assert_true( number( json_object_get( groups, "inside" ), "pairs" ) == 12.0 );
}

static void write_foreign( const char* name, const Foreign* foreign ) { write_foreign_exr( cli_path( name ), foreign, 1 ); }

TEST( test_files_of_other_programs )
{
    for ( int half = 0; half < 2; ++half )
    {
        Foreign foreign = { .names = { "L.Combined.B", "L.Combined.G", "L.Combined.R", "L.Depth.Z", "L.Vector.X", "L.Vector.Y" },
                            .values = { 1, 1, 1, 2, 3, 1 },
                            .x = -4,
                            .y = 6,
                            .width = 20,
                            .height = 10,
                            .half = half == 1 };
        write_foreign( "f.1.exr", &foreign );
        foreign.values[1] = 2.0f; // green
        write_foreign( "f.2.exr", &foreign );
        check_done( flicker( "f.#.exr", NULL ) );
        json_auto_t* json = load_json();
        assert_true( is_near( number( json, "f1" ), sqrt( 1.0 / 3.0 ) ) &&
                     is_near( number( json, "coverage" ), 17.0 * 9.0 / 200.0 ) );
    }
    Foreign other = { .names = { "B", "G", "R", "Z" }, .values = { 1, 1, 1, 2 }, .x = -4, .y = 6, .width = 20, .height = 10 };
    write_foreign( "f.2.exr", &other );
    check_failed( flicker( "f.#.exr", NULL ), 1, "has no channel L.Vector.X" );
    check_done( flicker( "f.#.exr", "--no-compensate", NULL ) );
    other.x = -3;
    write_foreign( "f.2.exr", &other );
    check_failed( flicker( "f.#.exr", "--no-compensate", NULL ), 1, "data window begins at (-3, 6)" );
    other.width = 21;
    write_foreign( "f.2.exr", &other );
    check_failed( flicker( "f.#.exr", "--no-compensate", NULL ), 1, "21x10" );
    other = ( Foreign ){ .names = { "B", "G", "R", "a.motion.X", "b.motion.X", "b.motion.Y" }, .width = 20, .height = 10 };
    write_foreign( "f.1.exr", &other );
    check_failed( flicker( "f.#.exr", NULL ), 1, "a.motion.X and b.motion.X" );
    other = ( Foreign ){ .names = { "foo", "normal.Z" }, .width = 20, .height = 10 };
    write_foreign( "f.1.exr", &other );
    check_failed( flicker( "f.#.exr", NULL ), 1, "has no channels R, G, B" );
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    RfFlickerLayers layers;
    assert_int_equal( rf_read_exr_header( cli_path( "f.1.exr" ), NULL, &header, NULL ), RF_OK );
    assert_true( header.channel_count == 2 && header.width == 20 && header.display_width == 64 && !header.has_world_to_ndc );
    assert_int_equal( rf_find_flicker_layers( "f", &header, NULL, NULL, &layers, NULL ), RF_OK );
    assert_true( layers.depth == NULL && layers.motion[0] == NULL ); // a normal is no depth
}

// The matrix that Reframe writes: 90 degrees, looking along −z from z = 3.
TEST( test_motion_from_camera_matrices )
{
    static float depth[PIXELS];
    const RfExrChannel channels[] = { { .name = "depth.Z", .values = depth, .stride = 1 },
                                      { .name = "motion.X", .values = depth, .stride = 1 },
                                      { .name = "motion.Y", .values = depth, .stride = 1 } };
    RfExrOptions options = rf_default_exr_options();
    options.channels = channels;
    options.channel_count = 3;
    options.has_camera = true;
    const float matrix[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, 3, 3 };
    memcpy( options.world_to_ndc, matrix, sizeof matrix );
    memcpy( options.world_to_camera, matrix, sizeof matrix );
    write_frame( "camera.exr", SIDE, 1.0f, &options );
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    RfFlickerLayers layers;
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame frame;
    const char* path = cli_path( "camera.exr" );
    assert_int_equal( rf_read_exr_header( path, NULL, &header, NULL ), RF_OK );
    assert_int_equal( rf_find_flicker_layers( path, &header, NULL, NULL, &layers, NULL ), RF_OK );
    assert_int_equal( rf_read_flicker_frame( path, &layers, &header, path, &frame, NULL ), RF_OK );
    assert_true( frame.has_camera && frame.depth != NULL && frame.motion != NULL && frame.variance.rgb == NULL );
    // (0.5, 1, 1): 2 m ahead, a quarter of the film's half to the right and a half up
    const double p[4] = { 0.5, 1, 1, 1 };
    double at[3] = { 0 };
    for ( int i = 0; i < 3; ++i )
    {
        for ( int j = 0; j < 4; ++j )
            at[i] += frame.camera[i][j] * p[j];
    }
    assert_true( is_near( at[2], 2.0 ) && is_near( at[0] / at[2], 12.0 * 1.25 - 0.5 ) &&
                 is_near( at[1] / at[2], 12.0 * 0.5 - 0.5 ) );
}

TEST( test_wrong_input_is_refused )
{
    check_failed( flicker( "v.0007.exr", NULL ), 2, "has no ####" );
    check_failed( flicker( "none.####.exr", NULL ), 1, "no such file" );
    check_failed( flicker( "v.####.exr", "--frames", "7", NULL ), 1, "two neighbouring" );
    check_failed( flicker( "v.####.exr", "--frames", "60", NULL ), 2, "--frames: there is no frame 60" );
    check_failed( flicker( "v.####.exr", "--frames", "7-9x2", NULL ), 1, "frame 7 is followed by 9" );
    check_failed( flicker( "v.####.exr", "--frames", "6-9", NULL ), 1, "frame 6 is missing" );
    check_failed( flicker( "v.####.exr", "--reference", cli_path( "m.##.exr" ), NULL ), 1, "needs frame 7" );
    check_failed( flicker( "v.####.exr", "--reference", cli_path( "r.0007.exr" ), NULL ), 2, "--reference" );
    check_failed( flicker( "v.####.exr", "--border", "1", NULL ), 2, "--border" );
    check_failed( flicker( "v.####.exr", "--column", "2", NULL ), 2, "--png" );
    check_failed( flicker( "v.####.exr", "--column", "25", "--png", cli_path( "a.png" ), NULL ), 2, "no column 25" );
    write_frame( "s.1.exr", SIDE, 1.0f, NULL );
    write_frame( "s.2.exr", SIDE - 1, 1.0f, NULL );
    check_failed( flicker( "s.#.exr", NULL ), 1, "23x23" );
    assert_int_equal( remove( cli_path( "v.0009.exr" ) ), 0 );
    check_failed( flicker( "v.####.exr", NULL ), 1, "frame 8 is followed by 10" );
    write_frame( "v.0009.exr", SIDE, NAN, NULL );
    check_failed( flicker( "v.####.exr", NULL ), 1, "576 pixels with NaN" );
    json_auto_t* json = load_json(); // written all the same
    assert_true( json_is_null( json_object_get( json, "f1" ) ) && number( json, "nan" ) == 576.0 );
    assert_true( number( json_array_get( json_object_get( json, "pairs" ), 0 ), "f1" ) == 0.0 );
    assert_true( json_is_null( json_object_get( json_array_get( json_object_get( json, "pairs" ), 1 ), "f1" ) ) );
    write_frame( "v.0009.exr", SIDE, 1.0f, NULL );
    write_frame( "r.0010.exr", SIDE, INFINITY, NULL );
    check_failed( flicker( "v.####.exr", "--reference", cli_path( "r.####.exr" ), NULL ), 1,
                  "r.####.exr: 0 pixels with NaN, 576" );
    cli_write( "v.0009.exr", "nothing", 7 );
    check_failed( flicker( "v.####.exr", NULL ), 1, "v.0009.exr" );
}

// Frames of ours, a fast turn about a matt vase: what is left along the motion is
// little beside what moves, and less than without depth, where walls come out
// from behind the vase.
TEST( test_compensation_beats_plain_on_a_render )
{
    char command[2048];
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    for ( int k = 0; k < 2; ++k )
    {
        snprintf( command, sizeof command,
                  "'" REFRAME_BINARY "' render '" REFRAME_SCENE_FOLDER
                  "/vase-room-lambert.glb' -o '%s' --camera '" REFRAME_SOURCE_DIR
                  "/anim/orbit.json' --frames 10-11 --size 64x36 --spp 28 --group 3 --tile 1 --aov %s --float --quiet "
                  ">/dev/null",
                  cli_path( k == 0 ? "o.##.exr" : "p.##.exr" ), k == 0 ? "depth,motion" : "motion" );
        assert_int_equal( system( command ), 0 );
    }
    double f1[3], coverage[3];
    const char* const sequences[3] = { "o.##.exr", "p.##.exr", "o.##.exr" };
    for ( int k = 0; k < 3; ++k )
    {
        check_done( flicker( sequences[k], k < 2 ? "--compensate" : "--no-compensate", NULL ) );
        json_auto_t* json = load_json();
        f1[k] = number( json, "f1" );
        coverage[k] = number( json, "coverage" );
        assert_true( json_is_true( json_object_get( json, "masked" ) ) == ( k == 0 ) );
        json_t* border = json_object_get( json_object_get( json, "groups" ), "border" );
        assert_true( number( border, "pairs" ) == 0.0 ); // frames 10 and 11 of 48
    }
    print_message( "F1 %g along the motion, %g without depth, %g without motion; coverage %g\n", f1[0], f1[1], f1[2],
                   coverage[0] );
    assert_true( f1[0] < 0.5 * f1[1] && f1[0] < 0.5 * f1[2] );
    assert_true( coverage[0] > 0.65 && coverage[0] < coverage[1] && coverage[1] < 1.0 && coverage[2] == 1.0 );
    assert_int_equal( rf_read_exr_header( cli_path( "o.10.exr" ), NULL, &header, NULL ), RF_OK );
    assert_true( header.has_world_to_ndc );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
