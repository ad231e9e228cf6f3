// A small lamp behind a slab of glass, behind a glass ball, and seen by way of a mirror: links bring its light without bias.
// The lamp covers some 0.014 sr as seen from the floor, so the reference tracer still hits it by chance. Welch tests over
// 16 seeds, by path tracing and in groups of frames with tiles.
#include "support/bidirectional.h"
#include "support/scene_builder.h"
#include "support/unbiased.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define WIDTH 16
#define HEIGHT 12
#define EYES 3
#define BLOCK 4
#define LAMP_HALF 0.07f // m
#define LAMP_HEIGHT 1.2f

typedef enum Body
{
    SLAB,
    BALL,
    MIRROR,
} Body;

static int samples( int spp ) { return getenv( "REFRAME_LONG" ) != NULL ? 16 * spp : spp; }

// Level, with its front up or down.
static void add_level( SceneBuilder* b, uint32_t material, float half, float y, bool up )
{
    float z = up ? half : -half;
    add_quad( b, material, rf_vec3( -half, y, z ), rf_vec3( half, y, z ), rf_vec3( half, y, -z ), rf_vec3( -half, y, -z ) );
}

// A floor and a wall behind it, with a lamp above the body, or below the mirror.
static RfScene make_scene( Body body )
{
    SceneBuilder b = { 0 };
    uint32_t white = add_material( &b, make_lambert( 0.7f, 0.6f, 0.5f ) );
    uint32_t satin = add_material( &b, make_plastic( 0.6f, 0.6f ) );
    uint32_t lamp = add_material( &b, make_light( 60.0f, false ) );
    uint32_t glass = add_material( &b, make_glass( 1.5f, 0.0f, false ) );
    add_level( &b, white, 1.0f, 0.0f, true );
    add_quad( &b, satin, rf_vec3( -1, 0, -1 ), rf_vec3( 1, 0, -1 ), rf_vec3( 1, 1, -1 ), rf_vec3( -1, 1, -1 ) );
    if ( body == MIRROR )
    {
        RfMaterial perfect = make_mirror( 1.0f );
        perfect.specular = rf_vec3( 0.9f, 0.8f, 0.7f );
        add_level( &b, add_material( &b, perfect ), 1.5f, LAMP_HEIGHT, false );
        add_level( &b, lamp, LAMP_HALF, 0.7f, true );
        return finish_scene( &b );
    }
    add_level( &b, lamp, LAMP_HALF, LAMP_HEIGHT, false );
    if ( body == SLAB )
        add_box( &b, glass, rf_vec3( -1.5f, 0.6f, -1.5f ), rf_vec3( 1.5f, 0.75f, 1.5f ), false );
    else
        add_sphere( &b, glass, rf_vec3( 0.1f, 0.4f, 0.0f ), 0.3f, 16 );
    return finish_scene( &b );
}

// They look down at the floor and at the foot of the wall, below slab and mirror.
static void make_eyes( RfEye eyes[EYES] )
{
    for ( int i = 0; i < EYES; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0.05f * (float)i, 0.5f, 1.4f ), rf_vec3( 0.0f, -0.45f, -1.0f ), rf_vec3( 0, 1, 0 ), 0.8,
                               WIDTH, HEIGHT );
}

static Images bidirectional_images( const RfTracer* tracer, const RfEye* eye, int spp, int max_depth )
{
    Images images = { .width = eye->width, .height = eye->height, .count = SEEDS };
    assert_null( bidirectional_lacks( tracer, eye ) );
    for ( int k = 0; k < SEEDS; ++k )
    {
        images.rgb[k] = malloc( 3 * (size_t)eye->width * (size_t)eye->height * sizeof( float ) );
        if ( images.rgb[k] == NULL )
            abort();
        BidirectionalSettings settings = { .spp = spp, .max_depth = max_depth, .seed = (uint64_t)( 7001 + k ) };
        bidirectional_image( tracer, eye, &settings, images.rgb[k] );
    }
    return images;
}

static void check_body( const char* what, Body body, int max_depth )
{
    RfScene scene = make_scene( body );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    make_eyes( eyes );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.max_depth = max_depth;
    Images reference = reference_images( tracer, eyes, 1, samples( 400 ), &settings );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    settings.spp = samples( 16 );
    Images alone = rendered_images( tracer, eyes, EYES, 1, settings );
    settings.group = EYES;
    assert_true( rf_parse_tile( "3x3", &settings.tile ) );
    settings.spp = samples( 14 );
    Images together = rendered_images( tracer, eyes, EYES, 1, settings );
    Images bidirectional = bidirectional_images( tracer, eyes + 1, samples( 24 ), max_depth );
    printf( "%s\n", what );
    assert_unbiased( "  bidirectional", &bidirectional, &reference, BLOCK );
    assert_unbiased( "  alone", &alone, &reference, BLOCK );
    assert_unbiased( "  group 3, tiles 3x3", &together, &reference, BLOCK );
    free_images( &reference );
    free_images( &bidirectional );
    free_images( &alone );
    free_images( &together );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void test_a_slab_of_glass( void** state )
{
    (void)state;
    check_body( "slab", SLAB, 5 );
}

static void test_a_glass_ball( void** state )
{
    (void)state;
    check_body( "ball", BALL, 5 );
}

static void test_by_way_of_a_mirror( void** state )
{
    (void)state;
    check_body( "mirror", MIRROR, 5 );
}

// The referee with all its ways: connections, and glossy surfaces with interpolated normals.
static void test_bidirectional_path_tracing( void** state )
{
    (void)state;
    RfScene scene = make_room( ROOM_GGX );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eye;
    orbit_eyes( &eye, 1, 0.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = plain_settings();
    settings.max_depth = 5;
    Images reference = reference_images( tracer, &eye, 0, samples( 64 ), &settings );
    Images bidirectional = bidirectional_images( tracer, &eye, samples( 24 ), 5 );
    assert_unbiased( "bidirectional, closed room", &bidirectional, &reference, BLOCK );
    free_images( &reference );
    free_images( &bidirectional );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_bidirectional_path_tracing ),
        cmocka_unit_test( test_a_slab_of_glass ),
        cmocka_unit_test( test_a_glass_ball ),
        cmocka_unit_test( test_by_way_of_a_mirror ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
