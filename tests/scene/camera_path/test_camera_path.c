// Camera-path files: every kind against its closed form, frame times, and every way to get
// a file wrong.
#include "support/scene_files.h"
#include "support/cli_run.h"
#include "support/test.h"

#include "gltf/gltf.h"

#define PI 3.14159265358979323846
#define MUTATIONS 3000

static int frames_of( const RfCamera* camera, double fps )
{
    RfCameraFrames frames;
    RfError error = { 0 };
    if ( rf_camera_frames( &( RfScene ){ 0 }, camera, fps, &frames, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return frames.count;
}

TEST( test_orbit_by_closed_form )
{
    RfCamera camera =
        load_path( "{\"kind\":\"orbit\",\"center\":[1,2,3],\"radius\":2,\"height\":0.5,\"duration\":4,\"fov\":90}" );
    static const double wanted[][2] = { { 1, 5 }, { 3, 3 }, { 1, 1 }, { -1, 3 }, { 1, 5 } };
    for ( int i = 0; i < 5; ++i )
    {
        RfView view = view_at( &camera, i );
        assert_three( view.position, wanted[i][0], 2.5, wanted[i][1], 1e-12 );
        double s = 1.0 / sqrt( 4.25 );
        assert_three( view.forward, ( 1 - wanted[i][0] ) * s, -0.5 * s, ( 3 - wanted[i][1] ) * s, 1e-12 );
        assert_close( view.fov, 0.5 * PI, 1e-12 );
    }
    assert_int_equal( frames_of( &camera, 24.0 ), 97 );
    rf_destroy_camera( &camera );
    camera = load_path( "{\"kind\":\"orbit\",\"center\":[0,0,0],\"radius\":1,\"start\":90,\"turn\":-90,\"frames\":11,"
                        "\"target\":[0,5,0],\"up\":[0,0,-1]}" );
    assert_int_equal( frames_of( &camera, 24.0 ), 11 );
    assert_int_equal( frames_of( &camera, 7.0 ), 11 );
    assert_three( view_at( &camera, 0 ).position, 1, 0, 0, 1e-12 );
    assert_three( view_at( &camera, 5 ).position, sqrt( 0.5 ), 0, sqrt( 0.5 ), 1e-12 );
    assert_three( view_at( &camera, 10 ).position, 0, 0, 1, 1e-12 );
    assert_three( view_at( &camera, 10 ).up, 0, 0, -1, 1e-12 );
    rf_destroy_camera( &camera );
}

TEST( test_dolly_and_zoom_by_closed_form )
{
    RfCamera camera = load_path( "{\"kind\":\"dolly\",\"from\":[0,1,10],\"to\":[4,1,2],\"target\":[0,1,0],"
                                 "\"fov\":{\"from\":20,\"to\":60},\"duration\":2}" );
    assert_three( view_at( &camera, 0.5 ).position, 1, 1, 8, 1e-12 );
    assert_close( view_at( &camera, 0.5 ).fov, 30.0 * PI / 180.0, 1e-12 );
    assert_three( view_at( &camera, 2 ).forward, -4 / sqrt( 20 ), 0, -2 / sqrt( 20 ), 1e-12 );
    rf_destroy_camera( &camera );
    camera = load_path( "{\"kind\":\"zoom\",\"position\":[1,2,3],\"rotation\":{\"yaw\":90},\"fov\":{\"from\":50,\"to\":10},"
                        "\"frames\":5}" );
    assert_three( view_at( &camera, 1 ).position, 1, 2, 3, 0 );
    assert_three( view_at( &camera, 1 ).forward, -1, 0, 0, 1e-12 );
    assert_close( view_at( &camera, 1 ).fov, 40.0 * PI / 180.0, 1e-12 );
    assert_close( view_at( &camera, 4 ).fov, 10.0 * PI / 180.0, 1e-12 );
    rf_destroy_camera( &camera );
    // one frame alone is the beginning
    camera =
        load_path( "{\"kind\":\"zoom\",\"position\":[0,0,1],\"target\":[0,0,0],\"fov\":{\"from\":50,\"to\":10},\"frames\":1}" );
    assert_int_equal( frames_of( &camera, 24.0 ), 1 );
    assert_close( view_at( &camera, 0 ).fov, 50.0 * PI / 180.0, 1e-12 );
    rf_destroy_camera( &camera );
}

TEST( test_walk_by_closed_form )
{
    RfCamera camera = load_path( "{\"kind\":\"walk\",\"interpolation\":\"linear\",\"waypoints\":[[0,1,0],[4,1,0],[4,1,-4]],"
                                 "\"look_ahead\":2,\"speed\":2}" );
    assert_int_equal( frames_of( &camera, 10.0 ), 41 );
    assert_three( view_at( &camera, 1 ).position, 2, 1, 0, 1e-9 );
    assert_three( view_at( &camera, 1 ).forward, 1, 0, 0, 1e-9 );
    assert_three( view_at( &camera, 1.5 ).forward, sqrt( 0.5 ), 0, -sqrt( 0.5 ), 1e-9 ); // around the corner
    assert_three( view_at( &camera, 4 ).position, 4, 1, -4, 1e-9 );
    assert_three( view_at( &camera, 4 ).forward, 0, 0, -1, 1e-9 ); // past the end
    rf_destroy_camera( &camera );
    camera = load_path( "{\"kind\":\"walk\",\"waypoints\":[[0,0,0],[1,0,0],[2,1,0]],\"target\":[0,0,-9],\"frames\":100}" );
    double last = 0.0, first = 0.0;
    for ( int i = 1; i < 100; ++i )
    {
        RfView a = view_at( &camera, i - 1 ), b = view_at( &camera, i );
        double step =
            hypot( hypot( b.position[0] - a.position[0], b.position[1] - a.position[1] ), b.position[2] - a.position[2] );
        first = i == 1 ? step : first;
        last = step;
        assert_close( step / first, 1.0, 1e-3 );
    }
    assert_true( last > 0.01 );
    rf_destroy_camera( &camera );
}

TEST( test_keys_are_met )
{
    RfCamera camera = load_path( "{\"about\":\"x\",\"kind\":\"keyed\",\"target\":[0,0,0],\"fov\":30,\"keys\":["
                                 "{\"time\":1,\"position\":[0,0,4]},{\"time\":1.5,\"position\":[3,1,4],\"fov\":50},"
                                 "{\"time\":3,\"position\":[5,0,0],\"target\":[0,1,0],\"up\":[0,2,1]}]}" );
    assert_int_equal( frames_of( &camera, 24.0 ), 73 ); // from 0 s
    assert_three( view_at( &camera, 0 ).position, 0, 0, 4, 1e-12 );
    assert_three( view_at( &camera, 1 ).position, 0, 0, 4, 1e-12 );
    assert_three( view_at( &camera, 1 ).forward, 0, 0, -1, 1e-12 );
    assert_three( view_at( &camera, 1.5 ).position, 3, 1, 4, 1e-12 );
    assert_close( view_at( &camera, 1.5 ).fov, 50.0 * PI / 180.0, 1e-12 );
    assert_close( view_at( &camera, 3 ).fov, 30.0 * PI / 180.0, 1e-12 );
    assert_three( view_at( &camera, 3 ).forward, -5 / sqrt( 26 ), 1 / sqrt( 26 ), 0, 1e-12 );
    assert_three( view_at( &camera, 3 ).up, 0, 2 / sqrt( 5 ), 1 / sqrt( 5 ), 1e-12 );
    rf_destroy_camera( &camera );

    camera = load_path( "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"keys\":["
                        "{\"frame\":1,\"position\":[0,0,0],\"rotation\":{\"yaw\":0}},"
                        "{\"frame\":11,\"position\":[1,0,0],\"rotation\":{\"yaw\":90,\"roll\":0}},"
                        "{\"frame\":21.5,\"position\":[1,0,0],\"rotation\":[0,0,0,1]}]}" );
    assert_int_equal( frames_of( &camera, 24.0 ), 21 );
    assert_three( view_at( &camera, 5 ).position, 0.5, 0, 0, 1e-12 );
    assert_three( view_at( &camera, 5 ).forward, -sqrt( 0.5 ), 0, -sqrt( 0.5 ), 1e-12 );
    assert_close( view_at( &camera, 5 ).fov, 40.0 * PI / 180.0, 1e-12 );
    rf_destroy_camera( &camera );

    camera = load_path( "{\"kind\":\"keyed\",\"keys\":[{\"time\":2,\"position\":[0,0,1],\"target\":[0,0,0]}]}" );
    assert_int_equal( frames_of( &camera, 24.0 ), 1 );
    assert_three( view_at( &camera, 2 ).position, 0, 0, 1, 0 );
    rf_destroy_camera( &camera );
}

static RfView turned( const char* rotation )
{
    char text[256];
    snprintf( text, sizeof text, "{\"kind\":\"keyed\",\"rotation\":%s,\"keys\":[{\"time\":0,\"position\":[0,0,0]}]}", rotation );
    AUTO_CAMERA camera = load_path( text );
    RfView view = view_at( &camera, 0 );
    return view;
}

TEST( test_angles_turn_as_documented )
{
    assert_three( turned( "{}" ).forward, 0, 0, -1, 0 );
    assert_three( turned( "{\"yaw\":90}" ).forward, -1, 0, 0, 1e-12 );
    assert_three( turned( "{\"pitch\":30}" ).forward, 0, 0.5, -sqrt( 0.75 ), 1e-12 );
    assert_three( turned( "{\"roll\":90}" ).up, -1, 0, 0, 1e-12 ); // leans to its left
    RfView view = turned( "{\"yaw\":90,\"pitch\":30}" );
    assert_three( view.forward, -sqrt( 0.75 ), 0.5, 0, 1e-12 );
    assert_three( view.up, 0.5, sqrt( 0.75 ), 0, 1e-12 );
    // as glTF turns a camera: by 90 degrees about x it looks up
    assert_three( turned( "[0.7071,0,0,0.7071]" ).forward, 0, 1, 0, 1e-12 );
}

// Frames of a path, as eyes: their times are whole multiples, whatever the unit.
TEST( test_frame_times_are_exact_multiples )
{
    RfScene scene = { 0 };
    RfCamera camera =
        load_path( "{\"kind\":\"dolly\",\"from\":[0,0,0],\"to\":[10,0,0],\"rotation\":{},\"fov\":90,\"duration\":1}" );
    RfEye eye;
    RfError error = { 0 };
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, NULL, { 30, 1 }, 200, 100 }, 3, &eye, &error ),
                      RF_OK );
    assert_close( (double)eye.origin.x, 1.0, 1e-6 );
    assert_close( (double)eye.focal, 50.0, 1e-4 );
    assert_int_equal( eye.width, 200 );
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, NULL, { 30, 1 }, 0, 100 }, 3, &eye, &error ),
                      RF_ERROR_USAGE );
    rf_destroy_camera( &camera );

    camera = load_path( "{\"kind\":\"dolly\",\"from\":[0,0,0],\"to\":[10,0,0],\"rotation\":{},\"frames\":11}" );
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, NULL, { 30, 1 }, 8, 8 }, 3, &eye, &error ), RF_OK );
    assert_close( (double)eye.origin.x, 3.0, 1e-6 );
    rf_destroy_camera( &camera );
    camera = load_path( "{\"kind\":\"dolly\",\"from\":[0,0,0],\"to\":[10,0,0],\"rotation\":{},\"duration\":1e6}" );
    RfCameraFrames frames;
    assert_int_equal( rf_camera_frames( &scene, &camera, 24.0, &frames, &error ), RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, ": duration: 1e+06 s at 24 frames/s are more than 1000000 frames" ) );
    rf_destroy_camera( &camera );
}

static void expect_no_view( const char* text, double time, const char* part )
{
    AUTO_CAMERA camera = load_path( text );
    RfView view;
    RfError error = { 0 };
    assert_int_equal( rf_sample_camera_track( camera.track, time, &view, &error ), RF_ERROR_SCENE );
    if ( strstr( error.text, part ) == NULL || strstr( error.text, "path.json: " ) == NULL )
        fail_msg( "%s", error.text );
}

TEST( test_views_without_direction )
{
    expect_no_view( "{\"kind\":\"dolly\",\"from\":[-1,0,0],\"to\":[1,0,0],\"target\":[0,0,0],\"duration\":1}", 0.5,
                    "at 0.5 s the camera stands on its target" );
    expect_no_view( "{\"kind\":\"dolly\",\"from\":[-1,0,0],\"to\":[1,0,0],\"target\":[0,0,0],\"frames\":3}", 1.0,
                    "at frame 2 the camera stands on its target" );
    expect_no_view( "{\"kind\":\"dolly\",\"from\":[0,9,0],\"to\":[1,9,0],\"target\":[0,0,0],\"duration\":1}", 0.0,
                    "looks along its up" );
    expect_no_view( "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"target\":[0,0,0],\"keys\":["
                    "{\"time\":0,\"position\":[0,0,1]},{\"time\":2,\"position\":[0,0,2],\"up\":[0,-1,0]}]}",
                    1.0, "looks along its up" );
}

#define KEYED( rest ) "{\"kind\":\"keyed\",\"keys\":[{\"time\":0,\"position\":[0,0,1],\"target\":[0,0,0]}" rest
#define TWO( second ) KEYED( "," second "]}" )
#define ORBIT( rest ) "{\"kind\":\"orbit\",\"center\":[0,0,0],\"radius\":1" rest "}"
#define WALK( points, rest ) "{\"kind\":\"walk\",\"waypoints\":[" points "]" rest "}"

TEST( test_faults_are_one_line )
{
    static const char* const faults[][2] = {
        { "", "line 1, column 0" },
        { "{\n  \"kind\": \"orbit\",\n}", "line 3, column 1: " },
        { "{\"kind\":\"orbit\",\"kind\":\"orbit\"}", "duplicate" },
        { "{\"kind\":NaN}", "line 1" },
        { ORBIT( ",\"fov\":1e999" ), "overflow" },
        { "[]", ": must be an object, got an array of 0" },
        { "3", ": must be an object, got 3" },
        { "\"orbit\"", ": must be an object, got \"orbit\"" },
        { "{\"kind\":\"orb\"}", ": kind: must be one of keyed, orbit, dolly, zoom, walk, got \"orb\"" },
        { "{}", "kind: is missing: must be one of keyed, orbit, dolly, zoom, walk" },
        { "{\"kind\":\"fly\"}", "kind: must be one of keyed, orbit, dolly, zoom, walk, got \"fly\"" },
        { "{\"kind\":3}", "kind: must be one of keyed, orbit, dolly, zoom, walk, got 3" },
        { KEYED( "],\"about\":3}" ), "about: must be a string, got 3" },
        { KEYED( "],\"speed\":3}" ), "speed: unknown key, the keys here are: kind, interpolation, keys" },
        { KEYED( "],\"intrepolation\":3}" ), "did you mean interpolation?" },
        { KEYED( "],\"interpolation\":\"cubic\"}" ), "interpolation: must be one of catmull-rom, linear, got \"cubic\"" },
        { "{\"kind\":\"keyed\"}", "keys: is missing: must be an array of 1 to 1000000 keys" },
        { "{\"kind\":\"keyed\",\"keys\":[]}", "keys: must be an array of 1 to 1000000 keys, got an array of 0" },
        { TWO( "3" ), "keys[1]: must be an object, got 3" },
        { TWO( "{\"position\":[0,0,1]}" ), "keys[1].time: is missing: must be a number of seconds" },
        { TWO( "{\"time\":\"2\",\"position\":[0,0,1]}" ), "keys[1].time: must be a number from 0 to 1e+06, got \"2\"" },
        { TWO( "{\"time\":-2,\"position\":[0,0,1]}" ), "keys[1].time: must be a number from 0 to 1e+06, got -2" },
        { TWO( "{\"time\":0,\"position\":[0,0,2],\"target\":[0,0,0]}" ), "keys[1].time: 0 is not later than the key before" },
        { TWO( "{\"time\":1,\"cut\":1,\"position\":[0,0,2]}" ), "keys[1].cut: must be true or false" },
        { "{\"kind\":\"keyed\",\"keys\":[{\"time\":0,\"cut\":true,\"position\":[0,0,1]}]}",
          "keys[0].cut: the first key begins the path" },
        { TWO( "{\"frame\":2,\"position\":[0,0,2]}" ), "keys[1].frame: unknown key" },
        { TWO( "{\"time\":1,\"target\":[0,0,2]}" ), "keys[1].position: is missing" },
        { TWO( "{\"time\":1,\"position\":[0,2]}" ), "keys[1].position: must be an array of 3 numbers, got an array of 2" },
        { TWO( "{\"time\":1,\"position\":[0,2,\"x\"]}" ),
          "keys[1].position[2]: must be a number from -1e+15 to 1e+15, got \"x\"" },
        { TWO( "{\"time\":1,\"position\":[0,2,1e16]}" ), "keys[1].position[2]: must be a number" },
        { TWO( "{\"time\":1,\"position\":[0,2,3]}" ), "keys[1]: has neither target nor rotation" },
        { TWO( "{\"time\":1,\"position\":[0,2,3],\"target\":[0,2,3]}" ), "keys[1].target: is at the position of the camera" },
        { TWO( "{\"time\":1,\"position\":[0,0,3],\"target\":[-0.0,0,3]}" ), "keys[1].target: is at the position of the camera" },
        { TWO( "{\"time\":1,\"position\":[0,2,3],\"rotation\":{}}" ), "keys[1].rotation: the keys before it have none" },
        { TWO( "{\"time\":1,\"position\":[0,2,3],\"target\":[0,0,0],\"up\":[0,0,0]}" ), "keys[1].up: must be a direction" },
        { TWO( "{\"time\":1,\"position\":[0,2,3],\"target\":[0,0,0],\"fov\":180}" ),
          "keys[1].fov: must be a number from 0.1 to 179" },
        { KEYED( "],\"rotation\":{}}" ), "keys[0].target: not together with rotation" },
        { "{\"kind\":\"keyed\",\"rotation\":[0,0,0,2],\"keys\":[{\"time\":0,\"position\":[0,0,1]}]}",
          "rotation: must be a quaternion of length 1, got length 2" },
        { "{\"kind\":\"keyed\",\"rotation\":3,\"keys\":[{\"time\":0,\"position\":[0,0,1]}]}",
          "rotation: must be a quaternion [x, y, z, w] or" },
        { "{\"kind\":\"keyed\",\"rotation\":{\"yow\":3},\"keys\":[{\"time\":0,\"position\":[0,0,1]}]}",
          "rotation.yow: unknown key, did you mean yaw?" },
        { ORBIT( "" ), "the duration is missing: give duration (seconds) or frames (their number)" },
        { ORBIT( ",\"duration\":1,\"frames\":2" ), "frames: not together with duration" },
        { ORBIT( ",\"duration\":0" ), "duration: must be a number > 0 and <= 1e+06, got 0" },
        { ORBIT( ",\"frames\":1.5" ), "frames: must be a whole number, got 1.5" },
        { ORBIT( ",\"frames\":0" ), "frames: must be a number from 1 to 1e+06, got 0" },
        { ORBIT( ",\"frames\":2,\"rotation\":{},\"target\":[0,0,0]" ), "target: not together with rotation" },
        { ORBIT( ",\"frames\":2,\"fov\":\"wide\"" ), "fov: must be a number from 0.1 to 179, got \"wide\"" },
        { ORBIT( ",\"frames\":2,\"fov\":{\"from\":20}" ), "fov.to: is missing" },
        { ORBIT( ",\"frames\":2,\"center\":[0,0,0]" ), "duplicate" },
        { "{\"kind\":\"orbit\",\"radius\":1,\"frames\":2}", "center: is missing: must be an array of 3 numbers" },
        { "{\"kind\":\"orbit\",\"center\":[0,0,0],\"radius\":0,\"frames\":2}", "radius: must be a number > 0" },
        { "{\"kind\":\"dolly\",\"from\":[0,0,0],\"to\":[1,0,0],\"frames\":2}", "target: is missing" },
        { "{\"kind\":\"zoom\",\"position\":[0,0,0],\"target\":[1,0,0],\"frames\":2}",
          "fov: is missing: must be an object of from and to" },
        { "{\"kind\":\"zoom\",\"position\":[0,0,0],\"target\":[1,0,0],\"fov\":3,\"frames\":2}",
          "fov: must be an object of from and to" },
        { WALK( "[0,0,0]", ",\"speed\":1" ), "waypoints: must be an array of 2 to 10000 points, got an array of 1" },
        { WALK( "[0,0,0],[1,0,0],[1,0,0]", ",\"speed\":1" ), "waypoints[2]: is the same point as the one before it" },
        { WALK( "[0,0,0],[1,0,0],[1,-0.0,0]", ",\"speed\":1" ), "waypoints[2]: is the same point as the one before it" },
        { WALK( "[0,0,0],[1e-300,0,0]", ",\"speed\":1" ), "waypoints: are too close together" },
        { WALK( "[0,0,0],[1,0,0]", "" ), "or speed (metres per second)" },
        { WALK( "[0,0,0],[1,0,0]", ",\"speed\":1e-9" ), "speed: 1 m at 1e-09 m/s take longer than" },
        { WALK( "[0,0,0],[1,0,0]", ",\"speed\":1,\"look_ahead\":0" ), "look_ahead: must be a number > 0" },
        { WALK( "[0,0,0],[1,0,0]", ",\"speed\":1,\"look_ahead\":1,\"target\":[0,0,0]" ), "look_ahead: not together with target" },
    };
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
        expect_path_fault( faults[i][0], faults[i][1] );
    RfCamera camera;
    RfError error;
    assert_int_equal( rf_load_camera( "/no/such/path.json", &camera, &error ), RF_ERROR_IO );
    assert_int_equal( rf_load_camera( cli_folder(), &camera, &error ), RF_ERROR_IO );
}

#define FIRST_SHOT                                                                                                               \
    "{\"frame\":1,\"position\":[0,1,4],\"fov\":40},{\"frame\":3,\"position\":[1,1,4],\"fov\":44},"                               \
    "{\"frame\":4.5,\"position\":[2,1,3],\"fov\":43},{\"frame\":8,\"position\":[3,2,1],\"fov\":50}"
#define SECOND_SHOT( cut )                                                                                                       \
    "{\"frame\":11," cut "\"position\":[-9,1,4],\"fov\":20},{\"frame\":14,\"position\":[-8,2,3],\"fov\":25},"                    \
    "{\"frame\":20,\"position\":[-4,2,3],\"fov\":21}"
#define KEYS_OF( interpolation, keys )                                                                                           \
    "{\"kind\":\"keyed\",\"interpolation\":\"" interpolation                                                                     \
    "\",\"target\":[0,0,0],\"lens\":{\"shutter\":[-0.3,0.9]},\"keys\":[" keys "]}"

static RfEye blurred_eye( const RfCamera* camera, int frame )
{
    RfScene scene = { 0 };
    RfEye eye;
    RfError error = { 0 };
    RfCameraSampling sampling = { &scene, camera, NULL, { 24, 1 }, 64, 36 };
    if ( rf_camera_eye( &sampling, frame, &eye, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return eye;
}

// Frames of a path with a cut are those of two paths, shutter and all; between the last key and the cut the camera is held.
static void check_cut( const char* cut, const char* first, const char* second )
{
    RfCamera whole = load_path( cut ), parts[2] = { load_path( first ), load_path( second ) };
    assert_int_equal( rf_camera_shots( &whole ), 2 );
    assert_int_equal( rf_camera_shots( parts ), 1 );
    assert_int_equal( frames_of( &whole, 24.0 ), 20 );
    for ( int i = 0; i < 20; ++i )
    {
        RfEye eye = blurred_eye( &whole, i ), wanted = blurred_eye( parts + ( i >= 10 ), i >= 10 ? i - 10 : i < 7 ? i : 7 );
        assert_int_equal( eye.shot, i >= 10 );
        wanted.shot = eye.shot;
        if ( i == 8 || i == 9 )
        {
            assert_false( eye.moves );
            assert_true( wanted.moves );
            RfEye still;
            RfScene scene = { 0 };
            RfCameraSampling closed = { &scene, parts, &( RfLens ){ .has_shutter = true }, { 24, 1 }, 64, 36 };
            assert_int_equal( rf_camera_eye( &closed, 7, &still, NULL ), RF_OK );
            assert_memory_equal( &eye, &still, 15 * sizeof( float ) );
        }
        else
            assert_memory_equal( &eye, &wanted, sizeof eye );
    }
    rf_destroy_camera( &whole );
    rf_destroy_camera( parts );
    rf_destroy_camera( parts + 1 );
}

TEST( test_cuts_end_the_curves )
{
    check_cut( KEYS_OF( "catmull-rom", FIRST_SHOT "," SECOND_SHOT( "\"cut\":true," ) ), KEYS_OF( "catmull-rom", FIRST_SHOT ),
               KEYS_OF( "catmull-rom", SECOND_SHOT( "" ) ) );
    check_cut( KEYS_OF( "linear", FIRST_SHOT "," SECOND_SHOT( "\"cut\":true," ) ), KEYS_OF( "linear", FIRST_SHOT ),
               KEYS_OF( "linear", SECOND_SHOT( "\"cut\":false," ) ) );
    // a cut that misses its frame slightly, and one between frames
    AUTO_CAMERA camera = load_path( KEYED( ",{\"time\":0.41667,\"cut\":true,\"position\":[0,0,2],\"target\":[0,0,0]}"
                                           ",{\"time\":0.6,\"cut\":true,\"position\":[0,0,3],\"target\":[0,0,0]}]}" ) );
    for ( int i = 0; i < 15; ++i )
        assert_int_equal( blurred_eye( &camera, i ).shot, i < 10 ? 0 : 1 );
    assert_three( view_at( &camera, 0.41 ).position, 0, 0, 1, 0 );
    assert_three( view_at( &camera, 0.42 ).position, 0, 0, 2, 0 );
    assert_three( view_at( &camera, 0.6 ).position, 0, 0, 3, 0 );
}

// Broken copies of a text: an error line, or a path whose frames are numbers or errors.
static int load_mutations( const char* text, uint64_t count )
{
    size_t size = strlen( text );
    AUTO_FREE char* bytes = malloc( size );
    int loaded = 0;
    for ( uint64_t i = 0; i < count; ++i )
    {
        memcpy( bytes, text, size );
        cli_write( "broken.json", bytes, mutate_bytes( (uint8_t*)bytes, size, 5 * ( i + 1 ) ) );
        AUTO_CAMERA camera;
        RfError error = { 0 };
        RfScene scene = { 0 };
        RfResult result = rf_load_camera( cli_path( "broken.json" ), &camera, &error );
        assert_true( result == RF_OK ? camera.track != NULL : error.text[0] != 0 );
        for ( int frame = 0; frame < 5 && result == RF_OK; ++frame )
        {
            RfEye eye;
            RfResult seen =
                rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, NULL, { 24, 1 }, 16, 9 }, 7.0 * frame, &eye, &error );
            assert_true( seen != RF_OK || ( isfinite( eye.origin.x ) && isfinite( eye.forward.x ) && eye.focal > 0.0f ) );
        }
        loaded += result == RF_OK;
    }
    return loaded;
}

TEST( test_mutations_never_crash )
{
    static const char* const texts[] = {
        ( "{\"kind\":\"keyed\",\"interpolation\":\"catmull-rom\",\"up\":[0,1,0],\"keys\":["
          "{\"time\":0.0,\"position\":[0.5,1.5,2.25],\"target\":[0,1,0],\"fov\":30},"
          "{\"time\":0.5,\"position\":[1.5,1.5,2.25],\"target\":[0,1,0],\"fov\":40},"
          "{\"time\":1.25,\"position\":[1.5,2.5,1.25],\"target\":[0,1,0],\"fov\":30}]}" ),
        ( "{\"kind\":\"keyed\",\"keys\":[{\"frame\":1,\"position\":[0.5,1.5,2.25],\"rotation\":[0,0.6,0,0.8]},"
          "{\"frame\":20,\"cut\":true,\"position\":[0.5,2.5,1.25],\"rotation\":{\"yaw\":90,\"pitch\":10}}]}" ),
        "{\"kind\":\"walk\",\"waypoints\":[[0,1,0],[4,1,0],[4,1,-4],[3,2,1]],\"look_ahead\":2,\"speed\":2}",
    };
    const char* many = getenv( "REFRAME_MUTATIONS" );
    for ( size_t i = 0; i < 3; ++i )
        assert_true( load_mutations( texts[i], ( many != NULL ? (uint64_t)atoll( many ) : MUTATIONS ) / 3 ) > 0 );
}

// The path from which the vase room's camera is made is that camera.
TEST( test_vase_zoom_is_the_scenes_camera )
{
    AUTO_SCENE scene;
    AUTO_CAMERA camera;
    RfError error = { 0 };
    int count;
    assert_int_equal( rf_load_gltf( REFRAME_VASE_ROOM, &scene, NULL, &error ), RF_OK );
    assert_int_equal( rf_load_camera( REFRAME_SOURCE_DIR "/anim/vase-zoom.json", &camera, &error ), RF_OK );
    count = frames_of( &camera, 24.0 );
    assert_int_equal( count, frames_of( scene.cameras, 24.0 ) );
    for ( int i = 0; i < count; ++i )
    {
        RfEye a, b;
        assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, NULL, { 24, 1 }, 160, 90 }, i, &a, &error ),
                          RF_OK );
        assert_int_equal(
            rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 24, 1 }, 160, 90 }, i, &b, &error ), RF_OK );
        assert_close( (double)rf_length( rf_sub( a.origin, b.origin ) ), 0.0, 1e-5 );
        assert_close( (double)rf_length( rf_sub( a.forward, b.forward ) ), 0.0, 1e-5 );
        assert_close( (double)rf_length( rf_sub( a.up, b.up ) ), 0.0, 1e-5 );
        assert_close( (double)( a.focal - b.focal ), 0.0, 1e-4 );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
