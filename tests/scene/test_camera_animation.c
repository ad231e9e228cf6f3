// Animation channels, camera placement and frame counts, on scenes made by hand.

#include "support/test.h"
#include "scene/movement.h"
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"

#define HALF_SQRT2 0.70710678118654752440

static void assert_near( double got, double want, double tolerance )
{
    if ( ( fabs( got - want ) <= tolerance ) == false )
        fail_msg( "got %.17g, want %.17g", got, want );
}

static void assert_vec( RfVec3 v, double x, double y, double z )
{
    assert_near( (double)v.x, x, 1e-6 );
    assert_near( (double)v.y, y, 1e-6 );
    assert_near( (double)v.z, z, 1e-6 );
}

static RfNode make_node( int parent )
{
    return ( RfNode ){
        .name = "node", .parent = parent, .matrix = rf_mat4_identity(), .rotation = { 0, 0, 0, 1 }, .scale = { 1, 1, 1 }
    };
}

static RfScene make_scene( RfNode* nodes, int node_count, RfCamera* cameras, int camera_count )
{
    return (
        RfScene ){ .path = "test", .nodes = nodes, .node_count = node_count, .cameras = cameras, .camera_count = camera_count };
}

TEST( test_step_holds_the_last_key )
{
    double times[] = { 1, 2, 4 }, values[] = { 1, 2, 3, 4, 5, 6, 7, 8, 9 }, v[4];
    RfChannel channel = {
        .path = RF_TRANSLATION, .components = 3, .interpolation = RF_STEP, .count = 3, .times = times, .values = values
    };
    const double samples[][2] = { { 0, 1 }, { 1, 1 }, { 1.999, 1 }, { 2, 4 }, { 3.9, 4 }, { 4, 7 }, { 99, 7 } };
    for ( size_t i = 0; i < sizeof samples / sizeof samples[0]; ++i )
    {
        rf_sample_channel( &channel, samples[i][0], v );
        assert_near( v[0], samples[i][1], 0.0 );
        assert_near( v[2], samples[i][1] + 2.0, 0.0 );
    }
}

// Times of keys are floats: half of those that stand for a frame's time are rounded up.
TEST( test_steps_fall_on_their_frames )
{
    static double times[2000], values[2000];
    static const double fps[] = { 24.0, 25.0, 30.0, 60.0, 24000.0 / 1001.0 };
    for ( size_t k = 0; k < sizeof fps / sizeof fps[0]; ++k )
    {
        for ( int i = 0; i < 2000; ++i )
        {
            times[i] = (double)(float)( i / fps[k] );
            values[i] = i;
        }
        RfChannel channel = {
            .path = RF_TRANSLATION, .components = 1, .interpolation = RF_STEP, .count = 2000, .times = times, .values = values
        };
        for ( int i = 0; i < 2000; ++i )
        {
            double at, before;
            rf_sample_channel( &channel, i / fps[k], &at );
            rf_sample_channel( &channel, ( i - 0.02 ) / fps[k], &before );
            assert_near( at, i, 0.0 );
            assert_near( before, i > 0 ? i - 1 : 0, 0.0 );
        }
    }
}

TEST( test_linear_is_straight )
{
    double times[] = { 1, 2, 4 }, values[] = { 0, 0, 0, 2, 4, 8, 0, 0, 0 }, v[4];
    RfChannel channel = {
        .path = RF_SCALE, .components = 3, .interpolation = RF_LINEAR, .count = 3, .times = times, .values = values
    };
    rf_sample_channel( &channel, 1.25, v );
    assert_near( v[0], 0.5, 1e-15 );
    assert_near( v[2], 2.0, 1e-15 );
    rf_sample_channel( &channel, 3.5, v );
    assert_near( v[1], 1.0, 1e-15 );
    rf_sample_channel( &channel, -5.0, v );
    assert_near( v[1], 0.0, 0.0 );
    rf_sample_channel( &channel, NAN, v );
    assert_true( isfinite( v[0] ) );
}

// From no rotation to 90° around y: half way is 45°, also when the second key
// is written as its negative.
TEST( test_slerp_takes_the_short_way )
{
    for ( int sign = -1; sign <= 1; sign += 2 )
    {
        double times[] = { 0, 1 }, q[4];
        double values[] = { 0, 0, 0, 1, 0, sign * HALF_SQRT2, 0, sign * HALF_SQRT2 };
        RfChannel channel = {
            .path = RF_ROTATION, .components = 4, .interpolation = RF_LINEAR, .count = 2, .times = times, .values = values
        };
        for ( double t = 0.0; t <= 1.0; t += 0.125 )
        {
            rf_sample_channel( &channel, t, q );
            double turn = q[3] < 0.0 ? -1.0 : 1.0;
            assert_near( turn * q[1], sin( t * 0.25 * 3.14159265358979323846 ), 1e-12 );
            assert_near( turn * q[3], cos( t * 0.25 * 3.14159265358979323846 ), 1e-12 );
        }
    }
}

TEST( test_slerp_of_equal_keys )
{
    double times[] = { 0, 1 }, values[] = { 0, 0, 0, 1, 1e-9, 0, 0, 1 }, q[4];
    RfChannel channel = {
        .path = RF_ROTATION, .components = 4, .interpolation = RF_LINEAR, .count = 2, .times = times, .values = values
    };
    rf_sample_channel( &channel, 0.5, q );
    assert_near( q[0], 0.5e-9, 1e-15 );
    assert_near( q[3], 1.0, 1e-15 );
}

// A cubic that the basis reproduces exactly: x = t³ on keys 0 and 2, where the
// tangents are 0 and 12 per second.
TEST( test_cubicspline_scales_tangents )
{
    double times[] = { 0, 2 }, v[4];
    double values[] = { 99, 99, 99, 0, 0, 0, 0, 0, 0, 12, 12, 12, 8, 8, 8, 99, 99, 99 };
    RfChannel channel = {
        .path = RF_TRANSLATION, .components = 3, .interpolation = RF_CUBICSPLINE, .count = 2, .times = times, .values = values
    };
    for ( double t = 0.0; t <= 2.0; t += 0.25 )
    {
        rf_sample_channel( &channel, t, v );
        assert_near( v[1], t * t * t, 1e-12 );
    }
    rf_sample_channel( &channel, 3.0, v );
    assert_near( v[0], 8.0, 0.0 );
    rf_sample_channel( &channel, -1.0, v );
    assert_near( v[0], 0.0, 0.0 );
}

TEST( test_cubicspline_rotation_is_unit )
{
    double times[] = { 0, 1 }, q[4];
    double values[] = { 0, 0, 0, 0, 0, 0, 0, 1, 0, 3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0 };
    RfChannel channel = {
        .path = RF_ROTATION, .components = 4, .interpolation = RF_CUBICSPLINE, .count = 2, .times = times, .values = values
    };
    rf_sample_channel( &channel, 0.5, q );
    assert_near( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0, 1e-12 );
    assert_true( q[1] > 0.1 );
}

TEST( test_cameras_are_found_by_name )
{
    RfCamera cameras[] = { { .name = "still" }, { .name = "moving", .animated = true } };
    RfScene scene = make_scene( NULL, 0, cameras, 2 );
    RfError error;
    int index;
    assert_int_equal( rf_find_camera( &scene, NULL, &index, &error ), RF_OK );
    assert_int_equal( index, 1 );
    assert_int_equal( rf_find_camera( &scene, "still", &index, &error ), RF_OK );
    assert_int_equal( index, 0 );
    assert_int_equal( rf_find_camera( &scene, "nobody", &index, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "'still', 'moving'" ) );
    scene.camera_count = 1;
    assert_int_equal( rf_find_camera( &scene, NULL, &index, &error ), RF_OK );
    assert_int_equal( index, 0 );
    scene.camera_count = 0;
    assert_int_equal( rf_find_camera( &scene, NULL, &index, &error ), RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "has no camera" ) );
}

static void check_frames( const RfScene* scene, const RfCamera* camera, RfCameraFrames wanted )
{
    RfCameraFrames frames;
    assert_int_equal( rf_camera_frames( scene, camera, 24.0, &frames, NULL ), RF_OK );
    assert_int_equal( frames.first, wanted.first );
    assert_int_equal( frames.step, wanted.step );
    assert_int_equal( frames.count, wanted.count );
}

TEST( test_frames_cover_the_animation )
{
    RfCamera camera = { .name = "c", .animated = true, .start = 0.0, .end = (double)( 47.0f / 24.0f ) };
    RfScene scene = { .path = "file.glb" };
    RfError error;
    RfCameraFrames frames;
    check_frames( &scene, &camera, ( RfCameraFrames ){ 1, 1, 48 } );
    assert_int_equal( rf_camera_frames( &scene, &camera, 12.0, &frames, &error ), RF_OK );
    assert_int_equal( frames.count, 24 );
    camera.start = 1.0; // they begin at 0 s
    check_frames( &scene, &camera, ( RfCameraFrames ){ 1, 1, 48 } );
    camera.start = camera.end;
    check_frames( &scene, &camera, ( RfCameraFrames ){ 1, 1, 1 } );
    camera.animated = false;
    check_frames( &scene, &camera, ( RfCameraFrames ){ 1, 1, 1 } );
    camera = ( RfCamera ){ .name = "c", .animated = true, .end = 1e9 };
    assert_int_equal( rf_camera_frames( &scene, &camera, 24.0, &frames, &error ), RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "file.glb: camera 'c'" ) );
    assert_int_equal( rf_camera_frames( &scene, &camera, 0.0, &frames, &error ), RF_ERROR_USAGE );
    assert_int_equal( rf_camera_frames( &scene, &camera, NAN, &frames, &error ), RF_ERROR_USAGE );
}

// Something moves from 0.5 s to 2 s: up to frame 49.
TEST( test_frames_cover_what_moves )
{
    RfMovement movement = { .start = 0.5, .end = 2.0 };
    RfScene scene = { .path = "file.glb", .movement = &movement };
    RfCamera still = { .name = "still" }, early = { .name = "early", .animated = true, .start = 0.5, .end = 1.0 },
             late = { .name = "late", .animated = true, .start = 1.0, .end = 3.0 };
    check_frames( &scene, &still, ( RfCameraFrames ){ 1, 1, 49 } );
    check_frames( &scene, &early, ( RfCameraFrames ){ 1, 1, 49 } );
    check_frames( &scene, &late, ( RfCameraFrames ){ 1, 1, 73 } );
    RfEditShot shots[] = { { 0, 0.0 }, { 0, 60.0 } };
    RfEdit edit = { 2, shots, true };
    check_frames( &scene, &( RfCamera ){ .name = "edit", .edit = &edit, .animated = true }, ( RfCameraFrames ){ 1, 1, 61 } );

    RfCameraTrack track = { .kind = RF_TRACK_KEYED, .step = 1 };
    RfCamera path = { .name = "path", .track = &track };
    check_frames( &scene, &path, ( RfCameraFrames ){ 1, 1, 49 } ); // one key
    path.animated = true;
    path.end = 1.0;
    check_frames( &scene, &path, ( RfCameraFrames ){ 1, 1, 49 } );
    track.kind = RF_TRACK_ORBIT; // which has a duration
    check_frames( &scene, &path, ( RfCameraFrames ){ 1, 1, 25 } );

    // keys by frame numbers: 13 to 37 in steps of 2; 13 alone; 12 alone; 101 alone; −3 alone
    track = ( RfCameraTrack ){ .kind = RF_TRACK_KEYED, .in_frames = true, .step = 2 };
    path = ( RfCamera ){ .name = "path", .track = &track, .animated = true, .start = 12, .end = 36 };
    check_frames( &scene, &path, ( RfCameraFrames ){ 13, 2, 13 } );
    path = ( RfCamera ){ .name = "path", .track = &track, .start = 12, .end = 12 };
    check_frames( &scene, &path, ( RfCameraFrames ){ 1, 2, 25 } );
    path.start = path.end = 11;
    check_frames( &scene, &path, ( RfCameraFrames ){ 2, 2, 24 } );
    track.step = 1;
    path.start = path.end = 100;
    check_frames( &scene, &path, ( RfCameraFrames ){ 1, 1, 101 } );
    path.start = path.end = -4;
    check_frames( &scene, &path, ( RfCameraFrames ){ -3, 1, 53 } );
    scene.movement = NULL;
    check_frames( &scene, &path, ( RfCameraFrames ){ -3, 1, 1 } );
    track = ( RfCameraTrack ){ .kind = RF_TRACK_DOLLY, .in_frames = true, .step = 1 }; // of one frame
    scene.movement = &movement;
    path.start = path.end = 0;
    check_frames( &scene, &path, ( RfCameraFrames ){ 1, 1, 1 } );
}

TEST( test_eye_looks_down_minus_z )
{
    RfNode node = make_node( -1 );
    node.translation[1] = 2.0;
    RfCamera camera = { .name = "c", .yfov = 1.5707963267948966 };
    RfScene scene = make_scene( &node, 1, &camera, 1 );
    RfEye eye;
    RfError error;
    assert_int_equal(
        rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 200, 100 }, 0.0, &eye, &error ), RF_OK );
    assert_vec( eye.origin, 0, 2, 0 );
    assert_vec( eye.forward, 0, 0, -1 );
    assert_vec( eye.up, 0, 1, 0 );
    assert_vec( eye.right, 1, 0, 0 );
    assert_near( (double)eye.focal, 50.0, 1e-4 );
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 0, 100 }, 0.0, &eye, &error ),
                      RF_ERROR_USAGE );
}

// A parent that turns 90° around y within a second, above a camera at (0,0,5).
TEST( test_parents_move_cameras )
{
    RfNode nodes[] = { make_node( -1 ), make_node( 0 ) };
    nodes[1].translation[2] = 5.0;
    double times[] = { 0, 1 }, values[] = { 0, 0, 0, 1, 0, HALF_SQRT2, 0, HALF_SQRT2 };
    RfChannel channel = {
        .path = RF_ROTATION, .components = 4, .interpolation = RF_LINEAR, .count = 2, .times = times, .values = values
    };
    RfCamera camera = { .name = "c", .node = 1, .yfov = 1.0, .animated = true, .end = 1.0 };
    RfScene scene = make_scene( nodes, 2, &camera, 1 );
    scene.channels = &channel;
    scene.channel_count = 1;
    RfEye eye;
    RfError error;
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 4, 4 }, 1.0, &eye, &error ),
                      RF_OK );
    assert_vec( eye.origin, 5, 0, 0 );
    assert_vec( eye.forward, -1, 0, 0 );
    assert_vec( eye.up, 0, 1, 0 );
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 4, 4 }, 0.5, &eye, &error ),
                      RF_OK );
    assert_vec( eye.origin, 5 * HALF_SQRT2, 0, 5 * HALF_SQRT2 );
}

// Mirroring keeps what the camera sees upright and to the front.
TEST( test_scale_and_mirror_keep_the_view )
{
    RfNode nodes[] = { make_node( -1 ), make_node( 0 ) };
    nodes[0].scale[0] = -3.0;
    nodes[0].scale[1] = 1e-30;
    nodes[1].translation[0] = 1.0;
    RfCamera camera = { .name = "c", .node = 1, .yfov = 1.0 };
    RfScene scene = make_scene( nodes, 2, &camera, 1 );
    RfEye eye;
    RfError error;
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 4, 4 }, 0.0, &eye, &error ),
                      RF_OK );
    assert_vec( eye.origin, -3, 0, 0 );
    assert_vec( eye.forward, 0, 0, -1 );
    assert_vec( eye.up, 0, 1, 0 );
    assert_vec( eye.right, 1, 0, 0 );
}

TEST( test_collapsed_camera_fails )
{
    RfNode node = make_node( -1 );
    RfCamera camera = { .name = "flat", .yfov = 1.0 };
    RfScene scene = make_scene( &node, 1, &camera, 1 );
    RfEye eye;
    RfError error;
    node.scale[2] = 0.0;
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 4, 4 }, 0.0, &eye, &error ),
                      RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "flat" ) );
    node.scale[2] = 1.0;
    node.translation[0] = INFINITY;
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 4, 4 }, 0.0, &eye, &error ),
                      RF_ERROR_SCENE );
}

// Columns 1 and 2 of a shear may become parallel.
TEST( test_parallel_axes_fail )
{
    RfNode node = make_node( -1 );
    node.has_matrix = true;
    node.matrix.m[4] = 0.0, node.matrix.m[5] = 0.0, node.matrix.m[6] = 1.0;
    RfCamera camera = { .name = "c", .yfov = 1.0 };
    RfScene scene = make_scene( &node, 1, &camera, 1 );
    RfEye eye;
    RfError error;
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 4, 4 }, 0.0, &eye, &error ),
                      RF_ERROR_SCENE );
}

TEST( test_destroying_nothing_is_allowed )
{
    AUTO_SCENE scene = { 0 };
    rf_destroy_scene( NULL );
}

// Three shots of two cameras: each frame is what its camera alone shows at that moment, with its own shutter.
static void check_edit( const RfScene* scene, RfEdit edit )
{
    RfCamera film = { .name = "edit", .edit = &edit, .animated = true, .end = 2.5 };
    RfLens lens = { .has_shutter = true, .shutter = { -0.5, 0.5 } };
    assert_int_equal( rf_camera_shots( &film ), 3 );
    check_frames( scene, &film, ( RfCameraFrames ){ 1, 1, 61 } );
    for ( int i = 0; i < 61; ++i )
    {
        int shot = i < 24 ? 0 : i < 48 ? 1 : 2;
        const RfCamera* shown = scene->cameras + ( shot == 1 );
        RfEye eye, alone;
        RfCameraSampling whole = { scene, &film, &lens, { 24, 1 }, 64, 36 }, own = { scene, shown, &lens, { 24, 1 }, 64, 36 };
        assert_int_equal( rf_camera_eye( &whole, i, &eye, NULL ), RF_OK );
        assert_int_equal( rf_camera_eye( &own, i, &alone, NULL ), RF_OK );
        assert_int_equal( (int)( eye.shot >> 32 ), shot );
        assert_int_equal( eye.moves, i < 24 || i == 48 ); // to its last key, at 2 s
        assert_int_equal( alone.moves, eye.moves );
        assert_vec( eye.origin, (double)alone.origin.x, (double)alone.origin.y, (double)alone.origin.z );
        if ( eye.moves )
            assert_vec( eye.open.origin, (double)alone.open.origin.x, (double)alone.open.origin.y, (double)alone.open.origin.z );
    }
}

TEST( test_cameras_of_an_edit )
{
    double times[] = { 0, 2 }, values[] = { 0, 1, 0, 4, 1, 2 };
    RfChannel channel = {
        .path = RF_TRANSLATION, .components = 3, .interpolation = RF_LINEAR, .count = 2, .times = times, .values = values
    };
    RfNode nodes[] = { make_node( -1 ), make_node( -1 ) };
    nodes[1].translation[0] = -7.0;
    RfCamera cameras[] = { { .name = "Moves", .node = 0, .yfov = 0.7, .animated = true, .start = 0.0, .end = 2.0 },
                           { .name = "Stands", .node = 1, .yfov = 0.9 } };
    RfScene scene = make_scene( nodes, 2, cameras, 2 );
    scene.channels = &channel;
    scene.channel_count = 1;
    RfEditShot by_time[] = { { 0, 0.0 }, { 1, 1.00001 }, { 0, 2.0 } }, by_frame[] = { { 0, 0.0 }, { 1, 24.0 }, { 0, 47.5 } };
    check_edit( &scene, ( RfEdit ){ 3, by_time, false } );
    check_edit( &scene, ( RfEdit ){ 3, by_frame, true } );
}

// A node that steps on under a parent that moves: at 1 s, 1.5 s and 2 s; and 0.1 s later, as stop motion does.
TEST( test_steps_are_cuts )
{
    double times[] = { 0, 1, 1.5, 2, 2.5, 2.6 }, values[] = { 0, 0, 0, 5, 0, 0, 5, 0, 0, -3, 0, 0, 1, 0, 0, 2, 0, 0 };
    double span[] = { 0, 4 }, rise[] = { 0, 0, 0, 0, 4, 0 };
    RfChannel channels[] = {
        { .path = RF_TRANSLATION, .components = 3, .interpolation = RF_LINEAR, .count = 2, .times = span, .values = rise },
        { .node = 1,
          .path = RF_TRANSLATION,
          .components = 3,
          .interpolation = RF_STEP,
          .count = 6,
          .times = times,
          .values = values }
    };
    RfNode nodes[] = { make_node( -1 ), make_node( 0 ) };
    RfCamera camera = { .name = "Steps", .node = 1, .yfov = 0.7, .animated = true, .start = 0.0, .end = 4.0 };
    RfScene scene = make_scene( nodes, 2, &camera, 1 );
    scene.channels = channels;
    scene.channel_count = 2;
    assert_int_equal( rf_find_step_cuts( &scene, &camera, NULL ), RF_OK );
    assert_int_equal( camera.cut_count, 2 ); // at 1.5 s nothing jumps, at 2.5 s the next key is near
    assert_near( camera.cuts[0], 1.0, 0.0 );
    assert_near( camera.cuts[1], 2.0, 0.0 );
    assert_int_equal( rf_camera_shots( &camera ), 3 );
    RfLens lens = { .has_shutter = true, .shutter = { -0.5, 0.5 } };
    for ( int i = 0; i < 60; ++i )
    {
        RfEye eye;
        RfCameraSampling sampling = { &scene, &camera, &lens, { 24, 1 }, 64, 36 };
        int shot = i < 24 ? 0 : i < 48 ? 1 : 2;
        double x = shot == 0 ? 0.0 : shot == 1 ? 5.0 : -3.0;
        assert_int_equal( rf_camera_eye( &sampling, i, &eye, NULL ), RF_OK );
        assert_int_equal( eye.shot, shot );
        assert_true( eye.moves == 1 );
        assert_vec( eye.origin, x, i / 24.0, 0.0 );
        assert_vec( eye.open.origin, x, fmax( i - 0.5, -0.5 ) / 24.0, 0.0 ); // the parent goes on
        if ( i < 59 )
            assert_vec( eye.close.origin, x, ( i + 0.5 ) / 24.0, 0.0 );
    }
    rise[4] = 0.0; // it stands still: each shot is one picture
    for ( int i = 0; i < 59; ++i )
    {
        RfEye eye;
        RfCameraSampling sampling = { &scene, &camera, &lens, { 24, 1 }, 64, 36 };
        assert_int_equal( rf_camera_eye( &sampling, i, &eye, NULL ), RF_OK );
        assert_int_equal( eye.moves, 0 );
    }
    free( camera.cuts );
}
