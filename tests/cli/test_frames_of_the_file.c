// What a file says about its shot is taken from it: numbers of frames, rate, size, lens; frames
// with the same eye are rendered once; what moves in the file and not here is named.
#include "support/cli_run.h"
#include "support/frame_files.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "image/exr.h"
#include "reframe/camera.h"
#include "reframe/image.h"

#include <jansson.h>

#define FILM "\"render\":{\"size\":[32,24],\"fps\":[30000,1001]}"
#define SHOT ",\"extras\":{\"reframe\":{" FILM "}}"
#define KEY( frame, x, fov )                                                                                                     \
    "{\"frame\":" #frame ",\"position\":[" #x ",0,0],\"rotation\":[0,0,0,1],\"fov\":" #fov ",\"shift\":[0.25,0]}"

// As cli_expect, where standard error has warnings too.
static void expect_among( const CliResult* result, int status, const char* part )
{
    assert_int_equal( result->status, status );
    if ( strstr( result->err, part ) == NULL )
        fail_msg( "'%s' is not said: %s", part, result->err );
}

// room.gltf whose camera "Side" has a path in the file itself.
static void write_shot( const char* path, const char* extras )
{
    static const char at[] = "\"name\":\"Side\",";
    write_room( extras );
    size_t size;
    AUTO_FREE char* text = cli_read( "room.gltf", &size );
    char* place = strstr( text, at );
    assert_non_null( place );
    place += strlen( at );
    AUTO_FREE char* whole = malloc( size + strlen( path ) + 64 );
    int length = sprintf( whole, "%.*s\"extras\":{\"reframe\":{\"path\":%s}},%s", (int)( place - text ), text, path, place );
    cli_write( "room.gltf", whole, (size_t)length );
}

#define MOVING                                                                                                                   \
    "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"pixelAspect\":2,%s\"keys\":[" KEY( 101, 0, 40 ) "," KEY( 110, 0.9,       \
                                                                                                                 60 ) "]}"

static void write_moving( const char* more )
{
    char text[1024];
    snprintf( text, sizeof text, MOVING, more );
    write_shot( text, SHOT );
}

static bool is_same_picture( const char* a, const char* b )
{
    AUTO_IMAGE x = cli_read_exr( a ), y = cli_read_exr( b );
    bool same = x.width == y.width && x.height == y.height &&
                memcmp( x.rgb, y.rgb, 3 * (size_t)x.width * (size_t)x.height * sizeof *x.rgb ) == 0;
    return same;
}

TEST_WITHIN( test_frames_are_called_as_in_the_file, cli_enter_group, cli_leave_group )
{
    write_moving( "" );
    const CliResult* told = cli_run( "$R info room.gltf" );
    assert_int_equal( told->status, 0 );
    assert_non_null( strstr( told->out, "Side: 10 frames (101 to 110) at 29.97 frames/s, animated" ) );
    assert_non_null( strstr( told->out, "size       32x24" ) );
    cli_expect(
        cli_run( "$R render room.gltf -o f.####.exr --frames 103-104,-1 --group 1 --spp 3 --tile 1 --quiet --json f.json" ), 0,
        NULL );
    assert_int_equal( cli_count_files( ".exr", "." ), 3 );
    assert_true( cli_exists( "f.0103.exr" ) && cli_exists( "f.0104.exr" ) && cli_exists( "f.0110.exr" ) );
    cli_expect_exr_text( "f.0104.exr", "reframe/frame", "104" );
    json_auto_t* json = cli_read_json( "f.json" );
    json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_integer_value( json_object_get( json_array_get( frames, 2 ), "frame" ) ), 110 );
    expect_among( cli_run( "$R render room.gltf -o f.####.exr --frames 5" ), 2,
                  "there is no frame 5, the camera's path has frames 101 to 110" );
    expect_among( cli_run( "$R render room.gltf -o f.####.exr --frames -11" ), 2, "there is no frame -11" );
    // the command line goes before the file
    cli_expect( cli_run( "$R render room.gltf -o g.####.exr --frames 110 --size 8x4 --spp 1 --quiet" ), 0, NULL );
    cli_expect_size( "g.0110.exr", 8, 4 );
    cli_expect_size( "f.0110.exr", 32, 24 );
}

// What the export lost is said first, with --quiet too; smaller things are for info.
TEST_WITHIN( test_losses_of_the_export, cli_enter_group, cli_leave_group )
{
    write_room( ",\"extras\":{\"reframe\":{" FILM ",\"export_losses\":[\"'door': moves\",\"'sun': dims\"],"
                "\"export_warnings\":[\"'pot': has no bump\"]}}" );
    const CliResult* told = cli_run( "$R info room.gltf" );
    assert_int_equal( told->status, 0 );
    static const char first[] =
        "room.gltf\nLOST       by the export, 2: movements stand still, or the light of the picture is another\n"
        "  'door': moves\n  'sun': dims\n";
    assert_non_null( strstr( told->out, first ) );
    assert_non_null( strstr( told->out, "warnings   1 from the export\n  'pot': has no bump\n" ) );
#define RENDER_LOST "$R render room.gltf -o lost/f.####.exr --spp 1 --size 8x6 --overwrite --json lost/f.json "
    told = cli_run( "mkdir lost && " RENDER_LOST );
    static const char lost[] =
        "reframe render: lost by the export: 'door': moves\nreframe render: lost by the export: 'sun': dims\n";
    assert_int_equal( strncmp( told->err, lost, sizeof lost - 1 ), 0 );
    assert_non_null( strstr( told->err, "reframe render: 1 warning of the export: see reframe info\n" ) );
    told = cli_run( RENDER_LOST "--quiet" );
    assert_string_equal( told->err, lost );
    json_t* json = cli_read_json( "lost/f.json" );
    const json_t* losses = json_object_get( json, "export_losses" );
    assert_int_equal( json_array_size( losses ), 2 );
    assert_string_equal( json_string_value( json_array_get( losses, 1 ) ), "'sun': dims" );
    json_decref( json );
}

TEST_WITHIN( test_frames_in_steps, cli_enter_group, cli_leave_group )
{
    write_moving( "\"step\":3," );
    const CliResult* told = cli_run( "$R info room.gltf" );
    assert_non_null( strstr( told->out, "Side: 4 frames (101 to 110 in steps of 3)" ) );
    cli_expect( cli_run( "$R render room.gltf -o s.####.exr --frames 101-106 --group 0 --spp 1 --quiet" ), 0, NULL );
    assert_true( cli_exists( "s.0101.exr" ) && cli_exists( "s.0104.exr" ) && !cli_exists( "s.0107.exr" ) );
    cli_expect( cli_run( "$R flicker s.####.exr" ), 0, NULL ); // they are neighbours
    expect_among( cli_run( "$R render room.gltf -o s.####.exr --frames 102" ), 2,
                  "there is no frame 102, the camera's path has frames 101 to 110 in steps of 3" );
}

// Key 101 looks along −z with 40 degrees, shifted by a quarter of the height; pixels are twice as wide as high.
TEST_WITHIN( test_lens_of_every_frame, cli_enter_group, cli_leave_group )
{
    write_moving( "" );
    RfScene* scene;
    RfCameraPath path;
    RfError error;
    RfPathOptions of_file = { 0 };
    assert_int_equal( rf_open_scene( cli_path( "room.gltf" ), &scene, NULL, &error ), RF_OK );
    assert_int_equal( rf_create_camera_path( scene, &of_file, &path, &error ), RF_OK );
    assert_int_equal( path.count, 10 );
    assert_int_equal( path.run_count, 10 );
    assert_int_equal( rf_frame_number( &path, 9 ), 110 );
    assert_true( path.fps.numerator == 30000 && path.fps.denominator == 1001 );
    for ( int i = 0; i < path.count; ++i )
    {
        const RfEye* eye = path.eyes + i;
        double half = 0.5 * ( 40.0 + 20.0 * i / 9.0 ) * 3.14159265358979 / 180.0;
        assert_true( fabs( (double)eye->focal - 12.0 / tan( half ) ) < 1e-4 );
        assert_true( fabs( 2.0 * (double)eye->focal_x - (double)eye->focal ) < 1e-4 );
        assert_true( fabs( (double)eye->axis_x - ( 16.0 - 0.25 * 24.0 / 2.0 ) ) < 1e-5 && eye->axis_y == 12.0f );
        assert_true( fabs( (double)eye->origin.x - 0.1 * i ) < 1e-6 );
    }
    rf_destroy_camera_path( &path );
    rf_close_scene( scene );
}

static void expect_motion( const char* name, bool before, bool after )
{
    bool moved[2] = { false, false };
    for ( int c = 0; c < 4; ++c )
    {
        RfExrWindow window;
        AUTO_FREE float* values =
            cli_read_channel( name, ( ( const char* const[] ){ "motion.X", "motion.Y", "motion.Z", "motion.W" } )[c], &window );
        assert_non_null( values );
        for ( int i = 0; i < window.width * window.height; ++i )
            moved[c / 2] |= values[i] != 0.0f;
    }
    assert_int_equal( moved[0], before );
    assert_int_equal( moved[1], after );
}

#define CUT( rest )                                                                                                              \
    "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"lens\":{\"shutter\":0.5},\"keys\":[" KEY( 101, 0, 40 ) "," KEY(          \
        104, 0.3, 40 ) ",{\"frame\":105," rest                                                                                   \
                       "\"position\":[0.4,0.2,0],\"rotation\":[0,0,0,1],\"fov\":45}," KEY( 108, 0.2, 50 ) "]}"

// Two shots in one path: what is rendered on one side is the same whatever is on the other.
TEST_WITHIN( test_cuts_part_a_path, cli_enter_group, cli_leave_group )
{
#define RENDER_CUT "$R render room.gltf --group 2 --spp 4 --aov motion,depth --quiet "
    write_shot( CUT( "" ), SHOT );
    cli_expect( cli_run( RENDER_CUT "-o one.####.exr" ), 0, NULL );
    write_shot( CUT( "\"cut\":true," ), SHOT );
    assert_non_null(
        strstr( cli_run( "$R info room.gltf" )->out, "8 frames (101 to 108) at 29.97 frames/s, animated, 2 shots" ) );
    cli_expect( cli_run( RENDER_CUT "-o cut.####.exr" ), 0, NULL );
    assert_false( is_same_picture( "one.0104.exr", "cut.0104.exr" ) );
    cli_expect_exr_text( "cut.0104.exr", "reframe/shot", "101-104" );
    cli_expect_exr_text( "cut.0105.exr", "reframe/shot", "105-108" );
    cli_expect_exr_text( "one.0104.exr", "reframe/shot", NULL );
    expect_motion( "cut.0104.exr", true, false );
    expect_motion( "cut.0105.exr", false, true );
    assert_non_null( strstr( cli_run( "$R flicker cut.####.exr" )->out, "1 cut: no pair of frames is compared across one" ) );
    // the first shot as a path of its own, a frame alone, and one that is kept
    write_shot( "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"lens\":{\"shutter\":0.5},\"keys\":[" KEY(
                    101, 0, 40 ) "," KEY( 104, 0.3, 40 ) "]}",
                SHOT );
    cli_expect( cli_run( RENDER_CUT "-o first.####.exr" ), 0, NULL );
    write_shot( CUT( "\"cut\":true," ), SHOT );
    cli_expect( cli_run( RENDER_CUT "-o alone.####.exr --frames 104-105" ), 0, NULL );
    cli_expect( cli_run( RENDER_CUT "-o alone.####.exr --resume" ), 0, NULL );
    for ( int i = 101; i <= 108; ++i )
    {
        char cut[16], first[16], alone[16];
        snprintf( cut, sizeof cut, "cut.%04d.exr", i );
        snprintf( first, sizeof first, "first.%04d.exr", i );
        snprintf( alone, sizeof alone, "alone.%04d.exr", i );
        assert_true( is_same_picture( cut, alone ) );
        assert_true( i > 104 || is_same_picture( cut, first ) );
    }
    expect_among( cli_run( RENDER_CUT "-o one.####.exr --resume" ), 1, "one.0101.exr" ); // of another path
    // machines share no group at a cut
    cli_expect( cli_run( "$R tune room.gltf --budget 0 --group 2 --spp 4 --nodes 2 --json tune.json >told" ), 0, NULL );
    json_auto_t* json = cli_read_json( "tune.json" );
    const json_t* ranges = json_object_get( json_object_get( json, "nodes" ), "ranges" );
    assert_string_equal( json_string_value( json_object_get( json_array_get( ranges, 0 ), "frames" ) ), "101-104" );
}

// Cameras of the file one after the other; each stands still, so that each shot is one picture.
TEST_WITHIN( test_cameras_one_after_the_other, cli_enter_group, cli_leave_group )
{
    static const char edit[] = "{\"scene\":\"room.gltf\",\"camera\":[{\"name\":\"Eye\"},{\"name\":\"Side\",\"frame\":3},"
                               "{\"name\":\"Eye\",\"frame\":4}],\"render\":{\"size\":[32,24]}}";
    write_room( "" );
    cli_write( "edit.json", edit, strlen( edit ) );
    assert_non_null( strstr( cli_run( "$R info edit.json" )->out, "edit: 4 frames at 24 frames/s, animated, 3 shots" ) );
#define RENDER_EDIT "$R render edit.json --spp 2 --quiet --frames "
    cli_expect( cli_run( RENDER_EDIT "1-4 -o e.#.exr --group 3" ), 0, NULL );
    cli_expect( cli_run( RENDER_EDIT "1 -o a.#.exr --camera Eye" ), 0, NULL );
    assert_true( is_same_picture( "e.1.exr", "e.2.exr" ) && is_same_picture( "e.1.exr", "a.1.exr" ) );
    cli_expect_exr_text( "e.2.exr", "reframe/shot", "1-2" );
    cli_expect_exr_text( "e.3.exr", "reframe/shot", "3-3" );
    cli_expect_exr_text( "e.4.exr", "reframe/shot", "4-4" );
    cli_expect_exr_text( "e.4.exr", "reframe/camera", "edit" );
}

#define STILL                                                                                                                    \
    "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"keys\":[" KEY( 1, 0, 40 ) "," KEY( 2, 0.2, 40 ) "," KEY(                 \
        4, 0.2, 40 ) "," KEY( 6, 0.4, 40 ) "]}"

TEST_WITHIN( test_equal_eyes_are_rendered_once, cli_enter_group, cli_leave_group )
{
    write_shot( STILL, SHOT );
#define RENDER "$R render room.gltf --group 1 --spp 6 --aov motion "
    const CliResult* told = cli_run( RENDER "-o a.####.exr --json a.json" );
    assert_int_equal( told->status, 0 );
    assert_non_null( strstr( told->err, "nothing changes in frames 2 to 4: equal frames are rendered once, 4 of 6 in all" ) );
    assert_int_equal( cli_count_files( ".exr", "." ), 6 );
    assert_true( is_same_picture( "a.0002.exr", "a.0003.exr" ) && is_same_picture( "a.0002.exr", "a.0004.exr" ) );
    assert_false( is_same_picture( "a.0001.exr", "a.0002.exr" ) );
    assert_false( is_same_picture( "a.0004.exr", "a.0005.exr" ) );
    expect_motion( "a.0001.exr", false, true ); // there is no frame before the first
    expect_motion( "a.0002.exr", true, false );
    expect_motion( "a.0003.exr", false, false );
    expect_motion( "a.0004.exr", false, true );
    expect_motion( "a.0005.exr", true, true );
    json_t* json = cli_read_json( "a.json" );
    assert_int_equal( json_integer_value( json_object_get( json, "repeated_frames" ) ), 2 );
    json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 6 );
    for ( size_t i = 0; i < 6; ++i )
    {
        const json_t* same = json_object_get( json_array_get( frames, i ), "same_as" );
        assert_int_equal( json_integer_value( same ), i == 2 || i == 3 ? 2 : 0 );
    }
    json_decref( json );
    // a frame does not depend on the others asked for, nor on those kept
    cli_expect( cli_run( RENDER "-o b.####.exr --frames 3,5 --quiet" ), 0, NULL );
    assert_true( is_same_picture( "a.0003.exr", "b.0003.exr" ) && is_same_picture( "a.0005.exr", "b.0005.exr" ) );
    expect_motion( "b.0003.exr", false, false );
    told = cli_run( RENDER "-o b.####.exr --resume --json b.json --threads 1 --memory 8M" );
    assert_int_equal( told->status, 0 );
    for ( int i = 1; i <= 6; ++i )
    {
        char a[16], b[16];
        snprintf( a, sizeof a, "a.%04d.exr", i );
        snprintf( b, sizeof b, "b.%04d.exr", i );
        assert_true( is_same_picture( a, b ) );
    }
    json = cli_read_json( "b.json" );
    frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 6 );
    assert_int_equal( json_integer_value( json_object_get( json, "kept_frames" ) ), 2 );
    assert_int_equal( json_integer_value( json_object_get( json_array_get( frames, 3 ), "same_as" ) ), 2 );
    json_decref( json );
    // with a stop rule
    cli_expect( cli_run( RENDER "-o c.####.exr --noise 0.5 --quiet" ), 0, NULL );
    assert_true( is_same_picture( "c.0002.exr", "c.0004.exr" ) );
    const CliResult* flicker = cli_run( "$R flicker a.####.exr --frames 2-4 --json -" );
    assert_int_equal( flicker->status, 0 );
    cli_expect( cli_run( "$R tune room.gltf --budget 0 --quiet" ), 0, NULL );
}

TEST_WITHIN( test_still_cameras_are_reported, cli_enter_group, cli_leave_group )
{
    write_shot( "{\"kind\":\"keyed\",\"keys\":[" KEY( 1, 0, 40 ) "," KEY( 48, 0, 40 ) "]}", SHOT );
    const CliResult* told = cli_run( "$R info room.gltf" );
    assert_non_null( strstr( told->out, "Side: 48 frames at 29.97 frames/s, static" ) );
    assert_non_null( strstr( told->out, "no camera of the scene moves" ) );
    told = cli_run( "$R render room.gltf -o w.####.exr --spp 2" );
    assert_int_equal( told->status, 0 );
    assert_non_null( strstr( told->err, "nothing changes in frames 1 to 48: equal frames are rendered once, 1 of 48" ) );
    assert_int_equal( cli_count_files( ".exr", "." ), 48 );
}

TEST_WITHIN( test_moving_objects_are_named, cli_enter_group, cli_leave_group )
{
    char text[1024];
    snprintf( text, sizeof text, MOVING, "" );
    write_shot( text, ",\"extras\":{\"reframe\":{" FILM ",\"moving\":[\"door\",\"cup\"]}}" );
    cli_expect( cli_run( "$R render room.gltf -o m.####.exr --frames 101 --spp 1 --size 4x4" ), 1,
                "room.gltf: object 'cup': it moves or changes where the file was made, but not in the file (and 1 more)" );
    assert_int_equal( cli_count_files( ".exr", "." ), 0 );
    const CliResult* told = cli_run( "$R render room.gltf -o m.####.exr --frames 101 --spp 1 --size 4x4 --freeze" );
    assert_int_equal( told->status, 0 );
    assert_non_null( strstr( told->err, "'cup', 'door' move or change: frozen as in the first frame" ) );
    told = cli_run( "$R info room.gltf --freeze --json -" );
    json_auto_t* json = json_loads( told->out, 0, NULL );
    json_t* moving = json_object_get( json, "moving" );
    assert_int_equal( json_array_size( moving ), 2 );
    assert_string_equal( json_string_value( json_array_get( moving, 0 ) ), "cup" );
    assert_int_equal( json_integer_value( json_array_get( json_object_get( json, "size" ), 1 ) ), 24 );
    assert_non_null( strstr( cli_run( "$R info room.gltf --freeze" )->out, "frozen     2 objects\n  cup\n" ) );
    assert_non_null( strstr( cli_run( "$R info room.gltf" )->out,
                             "not rendered: an error, unless --freeze is given\n  object 'cup': it moves" ) );
}

TEST_WITHIN( test_variants_are_listed, cli_enter_group, cli_leave_group )
{
    write_room( "}],\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"Oak\"},{\"name\":\"Pine\"}]}},"
                "\"textures\":[{" );
    assert_non_null( strstr( cli_run( "$R info room.gltf --variant Oak" )->out, "variants   2\n  Oak\n  Pine\n" ) );
    assert_non_null( strstr( cli_run( "$R info room.gltf --json -" )->out, "\"Pine\"" ) );
    cli_expect( cli_run( "$R info room.gltf --variant Elm" ), 2, "none is called 'Elm': there are 'Oak', 'Pine'" );
    const char* render = "$R render room.gltf -o v.####.exr --frames 1 --spp 1 --size 4x4 --variant %s";
    cli_expect( cli_run( render, "Oak" ), 0, NULL );
    cli_expect( cli_run( render, "Oak --resume" ), 0, NULL );
    cli_expect( cli_run( render, "Pine --resume" ), 1, "--variant" );
}

TEST_WITHIN( test_wrong_shots_are_errors, cli_enter_group, cli_leave_group )
{
    static const char* const cases[][2] = {
        { ",\"extras\":{\"reframe\":{\"render\":{\"size\":[0,4]}}}", "scenes[0].extras.reframe.render.size[0]: must be" },
        { ",\"extras\":{\"reframe\":{\"render\":{\"fps\":24.5}}}", "render.fps: must be a whole number" },
        { ",\"extras\":{\"reframe\":{\"render\":{\"spp\":1}}}", "render.spp: unknown key" },
        { ",\"extras\":{\"reframe\":{\"render\":{\"max_depth\":0}}}", "render.max_depth: must be" },
        { ",\"extras\":{\"reframe\":{\"moving\":[1]}}", "moving[0]: must be" },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        write_room( cases[i][0] );
        cli_expect( cli_run( "$R info room.gltf" ), 1, cases[i][1] );
    }
    write_moving( "\"step\":1.5," );
    cli_expect( cli_run( "$R info room.gltf" ), 1, "nodes[1].extras.reframe.path.step: must be a whole number" );
}

// Paths are as long as the file asks for, unless a scene file or the command line says otherwise.
TEST_WITHIN( test_depth_of_the_file, cli_enter_group, cli_leave_group )
{
    static const struct
    {
        const char *scene, *option, *depth, *line;
    } cases[] = {
        { "room.gltf", "", "3", "reframe render: max depth 3, from the glTF\n" },
        { "room.gltf", "--max-depth 5", "5", NULL },
        { "room.gltf", "--max-depth none", NULL, NULL },
        { "cut.json", "", "2", NULL },
        { "whole.json", "", NULL, NULL },
    };
    write_room( ",\"extras\":{\"reframe\":{\"render\":{\"max_depth\":3}}}" );
    write_text( "cut.json", "{\"scene\":\"room.gltf\",\"render\":{\"max_depth\":2}}" );
    write_text( "whole.json", "{\"scene\":\"room.gltf\",\"render\":{\"max_depth\":\"none\"}}" );
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        const CliResult* done =
            cli_run( "$R render %s -o f.exr --frames 1 --size 8x6 --spp 1 --overwrite %s", cases[i].scene, cases[i].option );
        assert_int_equal( done->status, 0 );
        assert_true( ( cases[i].line != NULL ) == ( strstr( done->err, ", from the glTF" ) != NULL ) );
        if ( cases[i].line != NULL )
            expect_among( done, 0, cases[i].line );
        cli_expect_exr_text( "f.exr", "reframe/max-depth", cases[i].depth );
    }
    assert_non_null( strstr( cli_run( "$R info room.gltf" )->out, "max depth  3, from the glTF: " ) );
    assert_null( strstr( cli_run( "$R info cut.json" )->out, "from the glTF" ) );
    assert_null( strstr( cli_run( "$R info whole.json" )->out, "max depth" ) );
}

// A path from frame -2 to frame 2, in files, lists, ranges and the commands that read them.
TEST_WITHIN( test_negative_frames, cli_enter_group, cli_leave_group )
{
    write_shot( "{\"kind\":\"keyed\",\"keys\":[" KEY( -2, 0, 40 ) "," KEY( 2, 0.9, 60 ) "]}", SHOT );
#define RENDER_SHOT "$R render room.gltf --spp 2 --tile 1 --group 1 --quiet "
    cli_expect( cli_run( RENDER_SHOT "-o n/f.####.exr" ), 0, NULL );
    static const char* const s_names[] = { "n/f.-0002.exr", "n/f.-0001.exr", "n/f.0000.exr", "n/f.0001.exr", "n/f.0002.exr" };
    for ( int i = 0; i < 5; ++i )
        assert_true( cli_exists( s_names[i] ) );
    cli_expect_exr_text( "n/f.-0002.exr", "reframe/frame", "-2" );
    cli_expect( cli_run( "rm n/f.-0001.exr n/f.-0002.exr; mkdir n/slurm" ), 0, NULL );
    cli_expect( cli_run( RENDER_SHOT "-o n/f.####.exr --check --nodes 2 --json n/slurm/job.json" ), 1, "not there: -2, -1:" );
    json_auto_t* json = cli_read_json( "n/slurm/job.json" );
    const json_t* ranges = json_object_get( json_object_get( json, "nodes" ), "ranges" );
    assert_string_equal( json_string_value( json_object_get( json_array_get( ranges, 0 ), "frames" ) ), "@-2" );
    cli_expect( cli_run( RENDER_SHOT "-o n/f.####.exr --frames @-2 --resume" ), 0, NULL );
    cli_expect( cli_run( "$R report n -o n.html --quiet" ), 0, NULL );
    json_auto_t* data = page_read_data( "n.html", 4 );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Picture", "Missing frames" ), "-1" );
    cli_expect( cli_run( RENDER_SHOT "-o m/f.####.exr --frames @-2--1,-1" ), 0, NULL ); // and the last
    assert_int_equal( cli_count_files( ".exr", "m" ), 3 );
    assert_true( is_same_picture( "m/f.-0002.exr", "n/f.-0002.exr" ) && is_same_picture( "m/f.0002.exr", "n/f.0002.exr" ) );
    expect_among( cli_run( RENDER_SHOT "-o n/f.####.exr --frames -6" ), 2, "those of the path are written as @-3-3" );
    cli_expect( cli_run( "$R compare m m --frames @-2--1 >told && $R png m z.####.png --frames @-2 >told && "
                         "$R flicker m/f.####.exr --frames @-2--1 >told && $R compare m n >told" ),
                0, NULL );
    assert_true( cli_exists( "z.-0002.png" ) );
}

// In a glTF, and in a scene file, which times its keys by the same fraction.
TEST_WITHIN( test_decimals_of_broadcast_rates, cli_enter_group, cli_leave_group )
{
    static const char* const s_rates[] = { "29.97", "\"29.97\"", "\"30000/1001\"" };
    write_room( ",\"extras\":{\"reframe\":{\"render\":{\"fps\":59.94}}}" );
    cli_expect( cli_run( "$R render room.gltf -o f.exr --frames 1 --size 8x6 --spp 1 --quiet" ), 0, NULL );
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    assert_int_equal( rf_read_exr_header( cli_path( "f.exr" ), NULL, &header, NULL ), RF_OK );
    assert_int_equal( header.fps_numerator, 60000 );
    for ( size_t i = 0; i < sizeof s_rates / sizeof s_rates[0]; ++i )
    {
        char text[320];
        int length = snprintf( text, sizeof text,
                               "{\"scene\":\"room.gltf\",\"render\":{\"fps\":%s},\"environment\":{\"radiance\":[1,1,1],\"keys\":["
                               "{\"frame\":1,\"strength\":1},{\"frame\":31,\"strength\":0.5}]}}",
                               s_rates[i] );
        cli_write( "keyed.json", text, (size_t)length );
        assert_non_null( strstr( cli_run( "$R info keyed.json" )->out, "31 frames at 29.97 frames/s" ) );
    }
}

// Of a camera for pictures that are higher than wide.
TEST_WITHIN( test_another_aspect_ratio_is_said, cli_enter_group, cli_leave_group )
{
    write_room( "" );
    cli_run( "sed 's/\"yfov\":/\"aspectRatio\":0.5,\"yfov\":/' room.gltf > tall.gltf" );
    const CliResult* run = cli_run( "$R render tall.gltf -o f.exr --frames 1 --spp 1 --size 32x16 --quiet --json f.json" );
    expect_among( run, 0,
                  "is for pictures of an aspect ratio of 0.5, and 32x16 has 2: the vertical field of view is kept, and the sides "
                  "show more (--size 8x16 has the camera's)" );
    json_auto_t* json = cli_read_json( "f.json" );
    assert_int_equal( json_array_size( json_object_get( json, "warnings" ) ), 1 );
    cli_expect( cli_run( "$R render tall.gltf -o f.exr --frames 1 --spp 1 --size 8x16 --overwrite --quiet" ), 0, NULL );
}
