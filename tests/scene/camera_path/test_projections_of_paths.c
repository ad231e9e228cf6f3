// Orthographic and panoramic cameras in paths and glTF files, and what a shutter sees at the ends of a path and of a lens
// that is being shifted.
#include "support/scene_files.h"
#include "support/cli_run.h"
#include "support/test.h"

#include "scene/lens.h"

#define KEYED( rest ) "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"rotation\":[0,0,0,1]," rest "}"
#define PLACE "\"position\":[0,0,0]"

static RfEye eye_of( const RfCamera* camera, double frame )
{
    RfScene scene = { 0 };
    RfEye eye;
    RfError error = { 0 };
    if ( rf_camera_eye( &( RfCameraSampling ){ &scene, camera, NULL, { 24, 1 }, 200, 100 }, frame, &eye, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return eye;
}

TEST( test_orthographic_paths )
{
    RfCamera camera = load_path( KEYED( "\"projection\":\"orthographic\",\"keys\":[{\"frame\":1,\"ymag\":2," PLACE
                                        "},{\"frame\":3,\"ymag\":4,\"shift\":[0.25,0.1]," PLACE "}],\"pixelAspect\":2" ) );
    RfEye eye = eye_of( &camera, 1 );
    assert_int_equal( eye.projection, RF_ORTHOGRAPHIC );
    assert_close( (double)eye.focal, 100.0 / 6.0, 1e-5 ); // pixels per metre
    assert_close( (double)eye.focal_x, 50.0 / 6.0, 1e-5 );
    assert_close( (double)eye.axis_x, 100.0 - 0.125 * 50.0, 1e-4 );
    assert_close( (double)eye.axis_y, 50.0 + 5.0, 1e-4 );
    rf_destroy_camera( &camera );
    camera = load_path( "{\"kind\":\"zoom\",\"projection\":\"orthographic\",\"position\":[0,0,0],\"rotation\":{},\"frames\":3,"
                        "\"ymag\":{\"from\":1,\"to\":3},\"lens\":{\"fstop\":2,\"focus\":5}}" );
    eye = eye_of( &camera, 1 );
    assert_close( (double)eye.focal, 25.0, 1e-5 );
    assert_close( (double)eye.lens_radius, 0.25, 1e-7 ); // of a focal length of 1 m
    rf_destroy_camera( &camera );
}

TEST( test_panoramic_paths )
{
    RfCamera camera = load_path( KEYED( "\"projection\":\"panoramic\",\"keys\":[{\"frame\":1," PLACE "}]" ) );
    RfEye eye = eye_of( &camera, 0 );
    assert_int_equal( eye.projection, RF_PANORAMIC );
    assert_close( (double)eye.focal * 3.14159265, 100.0, 1e-4 );
    assert_close( (double)eye.focal_x * 3.14159265, 100.0, 1e-4 );
    rf_destroy_camera( &camera );
    camera = load_path(
        KEYED( "\"projection\":\"panoramic\",\"keys\":[{\"frame\":1," PLACE "}],\"lens\":{\"radius\":1,\"focus\":1}" ) );
    RfScene scene = { 0 };
    RfError error = { 0 };
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, NULL, { 24, 1 }, 8, 8 }, 0, &eye, &error ),
                      RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "a panoramic camera has no depth of field here" ) );
    rf_destroy_camera( &camera );
}

// A caller's lens has the limits of one in a file.
TEST( test_lenses_have_limits )
{
    static const RfLens s_wrong[] = {
        { .has_fstop = true, .fstop = -1.0 },
        { .has_fstop = true, .fstop = 2.0 * RF_MAX_FSTOP },
        { .has_fstop = true, .fstop = (double)NAN },
        { .focus = -1.0 },
        { .focus = 2.0 * RF_MAX_FOCUS },
        { .has_shutter = true, .shutter = { 0.5, 0.0 } },
        { .has_shutter = true, .shutter = { -RF_MAX_SHUTTER - 1.0, 0.0 } },
        { .has_shutter = true, .shutter = { 0.0, RF_MAX_SHUTTER + 1.0 } },
    };
    AUTO_CAMERA camera = load_path( KEYED( "\"projection\":\"orthographic\",\"ymag\":2,\"keys\":[{\"frame\":1," PLACE "}]" ) );
    RfLens right = { .has_fstop = true, .fstop = 2.0, .focus = 5.0, .has_shutter = true, .shutter = { -0.25, 0.25 } };
    RfScene scene = { 0 };
    RfEye eye;
    RfError error = { 0 };
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, &right, { 24, 1 }, 8, 8 }, 0, &eye, &error ),
                      RF_OK );
    assert_close( (double)eye.focus, 5.0, 1e-6 );
    for ( size_t i = 0; i < sizeof s_wrong / sizeof s_wrong[0]; ++i )
        assert_int_equal(
            rf_camera_eye( &( RfCameraSampling ){ &scene, &camera, s_wrong + i, { 24, 1 }, 8, 8 }, 0, &eye, &error ),
            RF_ERROR_USAGE );
}

TEST( test_faults_name_the_key )
{
    static const char* const s_faults[][2] = {
        { KEYED( "\"projection\":\"fisheye\",\"keys\":[{\"frame\":1," PLACE "}]" ),
          "projection: must be one of perspective, orthographic, panoramic, got \"fisheye\"" },
        { KEYED( "\"projection\":\"orthographic\",\"keys\":[{\"frame\":1," PLACE "}]" ), "keys[0].ymag: is missing" },
        { KEYED( "\"projection\":\"orthographic\",\"ymag\":0,\"keys\":[{\"frame\":1," PLACE "}]" ),
          "ymag: must be a number > 0" },
        { KEYED( "\"projection\":\"orthographic\",\"keys\":[{\"frame\":1,\"ymag\":1,\"fov\":40," PLACE "}]" ),
          "keys[0].fov: is that of a perspective camera" },
        { KEYED( "\"keys\":[{\"frame\":1,\"ymag\":1," PLACE "}]" ), "keys[0].ymag: is that of an orthographic camera" },
        { KEYED( "\"projection\":\"panoramic\",\"fov\":40,\"keys\":[{\"frame\":1," PLACE "}]" ),
          "fov: is that of a perspective camera" },
        { KEYED( "\"projection\":\"panoramic\",\"keys\":[{\"frame\":1,\"shift\":[0,1]," PLACE "}]" ),
          "shift: a panorama cannot" },
    };
    for ( size_t i = 0; i < sizeof s_faults / sizeof *s_faults; ++i )
        expect_path_fault( s_faults[i][0], s_faults[i][1] );
}

#define ONE_CAMERA "\"nodes\":[{\"name\":\"it\",\"camera\":0%s}],\"cameras\":[%s]"

static RfScene scene_of( const char* node, const char* camera )
{
    char json[512];
    GltfBuilder b = { 0 };
    snprintf( json, sizeof json, ONE_CAMERA, node, camera );
    return gltf_load_built( &b, json );
}

TEST( test_cameras_of_gltf )
{
    RfEye eye;
    RfScene scene = scene_of( "", "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":9,\"ymag\":2,\"zfar\":9,\"znear\":0}}" );
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 200, 100 }, 0.0, &eye, NULL ),
                      RF_OK );
    assert_int_equal( eye.projection, RF_ORTHOGRAPHIC );
    assert_close( (double)eye.focal, 25.0, 1e-5 );
    RfCameraInfo info;
    assert_int_equal( rf_scene_camera( &scene, 0, ( RfFps ){ 24, 1 }, &info, NULL ), RF_OK );
    assert_string_equal( info.projection, "orthographic" );
    rf_destroy_scene( &scene );
    scene = scene_of( ",\"extras\":{\"reframe\":{\"projection\":\"panoramic\"}}",
                      "{\"type\":\"perspective\",\"perspective\":{\"yfov\":1}}" );
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 200, 100 }, 0.0, &eye, NULL ),
                      RF_OK );
    assert_int_equal( eye.projection, RF_PANORAMIC );
    rf_destroy_scene( &scene );
}

// The path goes on as it came: a frame's blur is the same at its ends as within.
TEST( test_shutters_see_beyond_the_ends )
{
    RfCamera camera = load_path( "{\"kind\":\"dolly\",\"from\":[0,0,0],\"to\":[10,0,0],\"rotation\":{},\"frames\":11,"
                                 "\"lens\":{\"shutter\":0.5}}" );
    for ( int frame = 0; frame <= 10; frame += 5 )
    {
        RfEye eye = eye_of( &camera, frame );
        assert_true( eye.moves );
        assert_close( (double)eye.open.origin.x, frame - 0.25, 1e-5 );
        assert_close( (double)eye.origin.x, frame, 1e-5 );
        assert_close( (double)eye.close.origin.x, frame + 0.25, 1e-5 );
    }
    rf_destroy_camera( &camera );
    // open for the whole of the frame that follows, also after the last; in a pan with a zoom
    camera = load_path( "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"keys\":[{\"time\":1,\"position\":[0,0,0],\"fov\":40,"
                        "\"rotation\":{\"yaw\":0}},{\"time\":2,\"position\":[0,0,0],\"fov\":60,\"rotation\":{\"yaw\":120}}],"
                        "\"lens\":{\"shutter\":[0,2]}}" );
    for ( int frame = 24; frame <= 48; frame += 24 )
    {
        RfEye eye = eye_of( &camera, frame );
        const RfVec3 seen[3] = { eye.open.forward, eye.forward, eye.close.forward };
        for ( int k = 0; k < 3; ++k )
        {
            double yaw = 3.14159265358979 / 180.0 * 5.0 * ( frame - 24 + k );
            assert_close( (double)seen[k].x, -sin( yaw ), 1e-5 );
            assert_close( (double)seen[k].z, -cos( yaw ), 1e-5 );
        }
        assert_true( eye.close.focal < eye.focal && eye.focal < eye.open.focal );
        assert_close( (double)rf_length( eye.right ), 1.0, 1e-6 );
        assert_close( (double)rf_dot( eye.right, eye.forward ), 0.0, 1e-6 );
    }
    rf_destroy_camera( &camera );
    // around the first key of a path that has waited for it
    camera =
        load_path( "{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"rotation\":{},\"keys\":[{\"time\":1,\"position\":[0,0,0]},"
                   "{\"time\":2,\"position\":[24,0,0]}],\"lens\":{\"shutter\":1}}" );
    RfEye eye = eye_of( &camera, 24 );
    assert_close( (double)eye.open.origin.x, 0.0, 1e-5 );
    assert_close( (double)eye.close.origin.x, 0.5, 1e-5 );
    assert_false( eye_of( &camera, 12 ).moves );
    rf_destroy_camera( &camera );
    camera = load_path( KEYED( "\"keys\":[{\"frame\":1," PLACE "}],\"lens\":{\"shutter\":0.5}" ) );
    assert_false( eye_of( &camera, 0 ).moves ); // it stands still
    rf_destroy_camera( &camera );
}

TEST( test_shifts_move_within_the_shutter )
{
    AUTO_CAMERA camera = load_path( KEYED( "\"keys\":[{\"frame\":1,\"shift\":[0,0]," PLACE
                                           "},{\"frame\":3,\"shift\":[0.2,0.4]," PLACE "}],\"lens\":{\"shutter\":1}" ) );
    RfEye eye = eye_of( &camera, 1 );
    assert_true( eye.moves );
    for ( int k = 0; k < 3; ++k )
    {
        RfEye at = rf_sample_eye( &eye, ( RfLensSample ){ 0.0f, 0.0f, 0.5f * (float)k } );
        assert_close( (double)at.axis_x, 100.0 - 5.0 * ( k + 1 ), 1e-4 );
        assert_close( (double)at.axis_y, 50.0 + 10.0 * ( k + 1 ), 1e-4 );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
