// Orthographic and panoramic cameras under frames and tiles are unbiased: against a path tracer that draws their rays in
// another way. Their densities are derivatives of their projections, and rays and projections are inverse to each other.
#include "support/rooms.h"
#include "support/scene_builder.h"
#include "support/test.h"
#include "support/unbiased.h"

#include "scene/lens.h"
#include "scene/projection.h"
#include "support/statistics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 36
#define HEIGHT 24
#define BLOCK 6
#define EYES 5
#define YMAG 1.1

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef enum Camera
{
    ORTHOGRAPHIC,
    ORTHOGRAPHIC_BLURRED, // with a lens and an open shutter
    PANORAMIC,
    PANORAMIC_MOVING,
} Camera;

static const char* const s_cameras[] = { "orthographic", "orthographic, lens and shutter", "panoramic", "panoramic, shutter" };

static RfEye like( const RfEye* eye, bool panoramic )
{
    return panoramic ? rf_make_panoramic_eye( eye->origin, eye->forward, eye->up, WIDTH, HEIGHT )
                     : rf_make_orthographic_eye( eye->origin, eye->forward, eye->up, YMAG, WIDTH, HEIGHT );
}

static void make_eyes( RfEye* eyes, Camera camera )
{
    RfEye path[2 * EYES + 1];
    orbit_eyes( path, 2 * EYES + 1, 4.0f, WIDTH, HEIGHT );
    for ( int i = 0; i < 2 * EYES + 1; ++i )
        path[i] = like( path + i, camera >= PANORAMIC );
    for ( int i = 0; i < EYES; ++i )
    {
        eyes[i] = path[2 * i + 1];
        if ( camera == ORTHOGRAPHIC_BLURRED )
            rf_set_lens( eyes + i, 0.3, 1.6, 0, 0.0 );
        if ( camera == ORTHOGRAPHIC_BLURRED || camera == PANORAMIC_MOVING )
            rf_set_shutter( eyes + i, path + 2 * i, path + 2 * i + 2 );
    }
    if ( camera != ORTHOGRAPHIC && camera != ORTHOGRAPHIC_BLURRED )
        return;
    for ( int i = 0; i < EYES; ++i )
        rf_shift_eye( eyes + i, 1.2, 0.05, -0.03 );
}

static void check( const char* scene_name, RfScene scene, Camera camera )
{
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    make_eyes( eyes, camera );
    RfRenderSettings plain = plain_settings();
    int times = is_long() ? 9 : 1;
    Images reference = reference_images( tracer, eyes, EYES / 2, 20 * times, &plain );
    static const struct
    {
        int group;
        bool tiles;
        int spp;
    } s_ways[] = { { 0, false, 10 }, { 0, true, 8 }, { 2, false, 5 }, { 2, true, 5 } };
    // the short run takes all at once
    for ( size_t k = is_long() ? 0 : 3; k < sizeof s_ways / sizeof *s_ways; ++k )
    {
        RfRenderSettings settings = plain_settings();
        settings.group = s_ways[k].group;
        settings.spp = s_ways[k].spp * times;
        settings.memory = (size_t)512 << 20;
        if ( s_ways[k].tiles )
            settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
        Images rendered = rendered_images( tracer, eyes, EYES, EYES / 2, settings );
        char what[96];
        snprintf( what, sizeof what, "%s, %s, group %d%s:", scene_name, s_cameras[camera], s_ways[k].group,
                  s_ways[k].tiles ? ", tiles" : "" );
        // pixels of a pass share points of the lens, so p-values of blocks need not be uniform
        Verdict v = compare_images( what, &rendered, &reference, BLOCK );
        printf( "%-60s whole %.3g, smallest of the blocks %.3g\n", what, v.whole_p, v.smallest_p );
        assert_true( is_likely( v.whole_p ) );
        assert_true( is_likely( v.smallest_p ) );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_glossy_rooms_are_unbiased )
{
    check( "GGX", make_room( ROOM_GGX ), ORTHOGRAPHIC );
    check( "GGX", make_room( ROOM_GGX ), PANORAMIC );
    check( "GGX", make_room( ROOM_GGX ), ORTHOGRAPHIC_BLURRED );
    if ( is_long() )
        check( "GGX", make_room( ROOM_GGX ), PANORAMIC_MOVING );
}

TEST( test_mirrors_coats_and_panes_are_unbiased )
{
    check( "mirror", make_mirror_room( FLAT_MIRROR ), ORTHOGRAPHIC );
    check( "panes", make_pane_room( PANES_AND_AREA_LIGHT ), ORTHOGRAPHIC );
    if ( !is_long() )
        return;
    check( "clear coat", make_mirror_room( CLEAR_COAT ), ORTHOGRAPHIC );
    check( "mirror", make_mirror_room( FLAT_MIRROR ), PANORAMIC );
    check( "clear coat", make_mirror_room( CLEAR_COAT ), PANORAMIC );
    check( "panes", make_pane_room( PANES_AND_AREA_LIGHT ), PANORAMIC );
    check( "mirror", make_mirror_room( FLAT_MIRROR ), ORTHOGRAPHIC_BLURRED );
}

// A point on a wall before the eye, its pixel, and pixels per metre in two directions by differences.
static void check_density( const RfEye* eye, float column, float row )
{
    const float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    RfVec3 o, d, n = rf_normalize( rf_vec3( 0.2f, 0.3f, 1.0f ) );
    rf_eye_ray( eye, inverse, (int)column, (int)row, column - floorf( column ), row - floorf( row ), &o, &d );
    assert_float_equal( rf_length( d ), 1.0, 1e-5 );
    n = rf_dot( n, d ) > 0.0f ? rf_scale( n, -1.0f ) : n;
    RfVec3 x = rf_madd( o, d, 2.5f ), a = rf_normalize( rf_cross( n, rf_vec3( 0, 1, 0 ) ) ), b = rf_cross( n, a );
    RfProjection at = rf_project_any( eye, x, n );
    assert_true( at.seen );
    assert_int_equal( at.x, (int)column );
    assert_int_equal( at.y, (int)row );
    RfVec3 back = rf_eye_way( eye, x ), start = rf_eye_start( eye, x );
    assert_float_equal( rf_length( rf_sub( back, rf_scale( d, 2.5f ) ) ), 0.0, 1e-5 );
    assert_float_equal( rf_length( rf_sub( start, o ) ), 0.0, 1e-5 );
    assert_false( rf_project_any( eye, x, rf_scale( n, -1.0f ) ).seen );
    const float h = 0.01f;
    float p[4][2];
    assert_true( rf_eye_position( eye, rf_madd( x, a, h ), false, p[0] ) );
    assert_true( rf_eye_position( eye, rf_madd( x, a, -h ), false, p[1] ) );
    assert_true( rf_eye_position( eye, rf_madd( x, b, h ), false, p[2] ) );
    assert_true( rf_eye_position( eye, rf_madd( x, b, -h ), false, p[3] ) );
    double ax = (double)rf_film_difference( eye, p[0][0] - p[1][0] ), ay = (double)( p[0][1] - p[1][1] );
    double bx = (double)rf_film_difference( eye, p[2][0] - p[3][0] ), by = (double)( p[2][1] - p[3][1] );
    double density = fabs( ax * by - ay * bx ) / ( 4.0 * (double)h * (double)h );
    assert_float_equal( (double)at.density / density, 1.0, 2e-3 );
}

TEST( test_densities_are_derivatives )
{
    RfVec3 o = rf_vec3( 0.3f, 1.2f, 2.0f ), forward = rf_vec3( 0.3f, -0.2f, -1.0f ), up = rf_vec3( 0, 1, 0 );
    RfEye perspective = rf_make_eye( o, forward, up, 0.9, 640, 480 ),
          parallel = rf_make_orthographic_eye( o, forward, up, 1.3, 640, 480 ),
          panoramic = rf_make_panoramic_eye( o, forward, up, 640, 480 );
    rf_shift_eye( &perspective, 1.2, 0.1, 0.05 );
    rf_shift_eye( &parallel, 1.2, 0.1, 0.05 );
    RfEye sheared = parallel;
    rf_set_lens( &sheared, 0.4, 1.5, 0, 0.0 );
    sheared = rf_sample_eye( &sheared, ( RfLensSample ){ 0.8f, 0.3f, 0.5f } );
    const RfEye eyes[] = { perspective, parallel, sheared, panoramic };
    for ( size_t k = 0; k < sizeof eyes / sizeof *eyes; ++k )
    {
        for ( int i = 0; i < 25; ++i )
            check_density( eyes + k, 8.4f + 130.0f * (float)( i % 5 ), 30.6f + 100.0f * (float)( i / 5 ) );
    }
    // both sides of the seam
    check_density( &panoramic, 0.3f, 200.5f );
    check_density( &panoramic, 639.7f, 200.5f );
}

// A point in focus stays in its place; others become discs of radius f R |z − F| / F, f pixels per metre.
TEST( test_the_lens_of_an_orthographic_camera )
{
    RfEye eye = rf_make_orthographic_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 1.0, 64, 48 );
    rf_set_lens( &eye, 0.25, 2.0, 0, 0.0 );
    static const float s_depth[] = { 2.0f, 3.0f, 1.0f };
    for ( int k = 0; k < 3; ++k )
    {
        double most = 0.0;
        for ( int i = 0; i < 256; ++i )
        {
            RfEye at = rf_sample_eye( &eye, ( RfLensSample ){ 0.999f, (float)i / 256.0f, 0.5f } );
            float seen[2];
            assert_true( rf_eye_position( &at, rf_vec3( 0.1f, 0.2f, -s_depth[k] ), false, seen ) );
            most = fmax( most, hypot( (double)seen[0] - 2.4, (double)seen[1] - 4.8 ) );
        }
        assert_float_equal( most, 24.0 * 0.25 * fabs( (double)s_depth[k] - 2.0 ) / 2.0, 4e-3 );
    }
}

STATISTICAL_TESTS
