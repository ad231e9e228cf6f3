// A small lamp behind a slab of glass, behind a glass ball, and by way of a mirror: connections bring its light without bias. Welch
// tests over 16 seeds, by path tracing and in groups of frames with tiles. The referee is bidirectional path tracing, which
// finds this light with little noise, and is itself compared with the reference tracer for a lamp that is large enough to be hit by chance:
// where a pixel of the reference is hit once or never, Welch's test takes the small variance of what it has for the whole.
#include "support/bidirectional.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#define WIDTH 16
#define HEIGHT 12
#define EYES 3
#define BLOCK 4
#define LARGE_LAMP 0.2f // m, half its width: 0.1 sr as seen from the floor
#define SMALL_LAMP 0.03f
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

// A floor and a wall behind it, with a lamp above the body, or below the mirror. No edge but that between floor and wall is in
// view: a pixel that sees a lit surface by a sliver alone has too skewed a distribution for its own test.
static RfScene make_scene( Body body, float lamp_half )
{
    SceneBuilder b = { 0 };
    uint32_t white = add_material( &b, make_lambert( 0.7f, 0.6f, 0.5f ) );
    uint32_t satin = add_material( &b, make_plastic( 0.6f, 0.6f ) );
    uint32_t lamp = add_material( &b, make_light( 0.3f / ( lamp_half * lamp_half ), false ) );
    uint32_t glass = add_material( &b, make_glass( 1.5f, 0.0f, false ) );
    add_level( &b, white, 2.0f, 0.0f, true );
    add_quad( &b, satin, rf_vec3( -2, 0, -1 ), rf_vec3( 2, 0, -1 ), rf_vec3( 2, 0.55f, -1 ), rf_vec3( -2, 0.55f, -1 ) );
    if ( body == MIRROR )
    {
        RfMaterial perfect = make_mirror( 1.0f );
        perfect.specular = rf_vec3( 0.9f, 0.8f, 0.7f );
        add_level( &b, add_material( &b, perfect ), 1.5f, LAMP_HEIGHT, false );
        add_level( &b, lamp, lamp_half, 0.7f, true );
        return finish_scene( &b );
    }
    add_level( &b, lamp, lamp_half, LAMP_HEIGHT, false );
    if ( body == SLAB )
        add_box( &b, glass, rf_vec3( -1.5f, 0.6f, -1.5f ), rf_vec3( 1.5f, 0.75f, 1.5f ), false );
    else
        add_sphere( &b, glass, rf_vec3( 0.1f, 0.64f, 0.0f ), 0.25f, 16 );
    return finish_scene( &b );
}

// They look down at the floor and at the foot of the wall, below the bodies.
static void make_eyes( RfEye eyes[EYES] )
{
    for ( int i = 0; i < EYES; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0.05f * (float)i, 0.5f, 1.4f ), rf_vec3( 0.0f, -0.36f, -1.0f ), rf_vec3( 0, 1, 0 ), 0.5,
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

// The lamp that chance finds.
static void check_referee( Body body, int max_depth )
{
    AUTO_SCENE scene = make_scene( body, LARGE_LAMP );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    make_eyes( eyes );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.max_depth = max_depth;
    Images reference = reference_images( tracer, eyes, 1, samples( 128 ), &settings );
    Images bidirectional = bidirectional_images( tracer, eyes + 1, samples( 24 ), max_depth );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    settings.spp = samples( 96 ); // connections leave most of a large lamp to chance, so pixels need as many samples as without
    Images connected = rendered_images( tracer, eyes, EYES, 1, settings );
    assert_unbiased( "  large lamp, bidirectional", &bidirectional, &reference, BLOCK );
    assert_unbiased( "  large lamp, connected", &connected, &reference, BLOCK );
    free_images( &reference );
    free_images( &bidirectional );
    free_images( &connected );
}

static void check_body( const char* what, Body body, int max_depth )
{
    printf( "%s\n", what );
    check_referee( body, max_depth );
    AUTO_SCENE scene = make_scene( body, SMALL_LAMP );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    make_eyes( eyes );
    RfRenderSettings settings = plain_settings();
    settings.max_depth = max_depth;
    settings.group = 0;
    settings.light_paths = RF_LIGHT_PATHS_ON;
    settings.spp = samples( 16 );
    Images bidirectional = bidirectional_images( tracer, eyes + 1, samples( 64 ), max_depth );
    Images alone = rendered_images( tracer, eyes, EYES, 1, settings );
    settings.group = EYES;
    assert_true( rf_parse_tile( "3x3", &settings.tile ) );
    settings.spp = samples( 14 );
    Images together = rendered_images( tracer, eyes, EYES, 1, settings );
    assert_unbiased( "  small lamp, connected", &alone, &bidirectional, BLOCK );
    assert_unbiased( "  small lamp, group 3, tiles 3x3", &together, &bidirectional, BLOCK );
    free_images( &bidirectional );
    free_images( &alone );
    free_images( &together );
}

TEST( test_a_slab_of_glass ) { check_body( "slab", SLAB, 5 ); }

TEST( test_a_glass_ball ) { check_body( "ball", BALL, 5 ); }

TEST( test_by_way_of_a_mirror ) { check_body( "mirror", MIRROR, 5 ); }

// The referee with all its ways: connections, and glossy surfaces with interpolated normals.
TEST( test_bidirectional_path_tracing )
{
    AUTO_SCENE scene = make_room( ROOM_GGX );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eye;
    orbit_eyes( &eye, 1, 0.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = plain_settings();
    settings.max_depth = 5;
    Images reference = reference_images( tracer, &eye, 0, samples( 64 ), &settings );
    Images bidirectional = bidirectional_images( tracer, &eye, samples( 24 ), 5 );
    assert_unbiased( "bidirectional, closed room", &bidirectional, &reference, BLOCK );
    free_images( &reference );
    free_images( &bidirectional );
}

STATISTICAL_TESTS
