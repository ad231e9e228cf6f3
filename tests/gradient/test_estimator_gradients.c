// Pixels and differences of neighbours are unbiased, and so is the picture that is made of them, against independent
// references over 16 seeds: with tiles of several sizes, cut by the border of the film, and by gradient-domain path
// tracing; on glossy surfaces, with glass in the tiles; the long run adds diffuse rooms, alpha blending, panes and a sky.
#include "gradient/gradient.h"
#include "support/rooms.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#define WIDTH 31
#define HEIGHT 23
#define BLOCK 6
#define SPP 6

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

// What `finish` of the tested estimator leaves besides the pixels.
static float s_difference[2][3 * WIDTH * HEIGHT];

// The pixels alone.
static RfRelmse keep_differences( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch )
{
    (void)settings;
    (void)scratch;
    rf_combine_film( films + RF_FILM_PRIMAL, RF_NORMALIZE_RATIO, picture->rgb, picture->weight );
    rf_combine_film( films + RF_FILM_DX, RF_NORMALIZE_RATIO, s_difference[0], NULL );
    rf_combine_film( films + RF_FILM_DY, RF_NORMALIZE_RATIO, s_difference[1], NULL );
    for ( int d = 0; d < 2; ++d )
        rf_add_film_steps( films + RF_FILM_UNSHARED, 0, 1, d == 1, s_difference[d] );
    return rf_plain_relmse( (double)NAN );
}

static Images new_images( void )
{
    Images images = { .width = WIDTH, .height = HEIGHT, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
    {
        images.rgb[k] = calloc( 3 * WIDTH * HEIGHT, sizeof( float ) );
        assert_non_null( images.rgb[k] );
    }
    return images;
}

// The differences of neighbours, right (0) or below (1); 0 where there is no neighbour.
static Images differences_of( const Images* images, int below )
{
    Images out = new_images();
    for ( int k = 0; k < SEEDS; ++k )
    {
        for ( int y = 0; y < HEIGHT - below; ++y )
        {
            for ( int x = 0; x < WIDTH - 1 + below; ++x )
            {
                const float* here = images->rgb[k] + 3 * ( y * WIDTH + x );
                const float* there = here + 3 * ( below ? WIDTH : 1 );
                for ( int c = 0; c < 3; ++c )
                    out.rgb[k][3 * ( y * WIDTH + x ) + c] = there[c] - here[c];
            }
        }
    }
    return out;
}

static RfRenderSettings settings_of( const char* tile, int spp )
{
    RfRenderSettings settings = plain_settings();
    settings.estimator = rf_find_estimator( "gradient" );
    assert_non_null( settings.estimator );
    settings.tile = rf_default_tile( settings.estimator );
    if ( tile != NULL )
        assert_true( rf_parse_tile( tile, &settings.tile ) );
    settings.group = 0;
    settings.spp = spp * ( is_long() ? 4 : 1 );
    settings.max_depth = 6;
    settings.memory = (size_t)512 << 20;
    return settings;
}

// Pixels and both differences, one image per seed.
static void check_films( const char* what, const RfTracer* tracer, const RfEye* eye, RfRenderSettings settings,
                         const Images reference[3] )
{
    RfEstimator films = *settings.estimator;
    films.finish = keep_differences;
    settings.estimator = &films;
    Images found[3] = { new_images(), new_images(), new_images() };
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = (uint64_t)( k + 1 );
        AUTO_BY( free_rendered ) Rendered r = render_all( tracer, eye, 1, &settings );
        memcpy( found[0].rgb[k], r.rgb, sizeof s_difference[0] );
        memcpy( found[1].rgb[k], s_difference[0], sizeof s_difference[0] );
        memcpy( found[2].rgb[k], s_difference[1], sizeof s_difference[1] );
    }
    static const char* const s_names[] = { "pixels", "dx", "dy" };
    for ( int i = 0; i < 3; ++i )
    {
        char name[96], tile[RF_TILE_NAME_SIZE];
        rf_tile_name( &settings.tile, tile );
        snprintf( name, sizeof name, "%s, tile %s, %s:", what, tile, s_names[i] );
        assert_unbiased( name, found + i, reference + i, BLOCK );
        free_images( found + i );
    }
}

// The pictures that are made of them.
static void check_pictures( const char* what, const RfTracer* tracer, const RfEye* eye, RfRenderSettings settings,
                            const Images* reference )
{
    static const RfReconstruction s_methods[] = { RF_RECONSTRUCTION_WEIGHTED, RF_RECONSTRUCTION_L2 };
    for ( int i = 0; i < 2; ++i )
    {
        settings.reconstruction = s_methods[i];
        Images found = rendered_images( tracer, eye, 1, 0, settings );
        char name[96];
        snprintf( name, sizeof name, "%s, %s:", what, rf_reconstruction_name( s_methods[i] ) );
        assert_unbiased( name, &found, reference, BLOCK );
        free_images( &found );
    }
}

static void check_scene( const char* what, RfScene scene, const char* const* tiles, int tile_count, bool pictures )
{
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eye;
    orbit_eyes( &eye, 1, 0.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = settings_of( NULL, SPP );
    Images reference[3] = { reference_images( tracer, &eye, 0, 48 * ( is_long() ? 4 : 1 ), &settings ) };
    reference[1] = differences_of( reference, 0 );
    reference[2] = differences_of( reference, 1 );
    for ( int t = 0; t < tile_count; ++t )
        check_films( what, tracer, &eye, settings_of( tiles[t], SPP ), reference );
    if ( pictures )
        check_pictures( what, tracer, &eye, settings, reference );
    for ( int i = 0; i < 3; ++i )
        free_images( reference + i );
    rf_destroy_scene( &scene );
}

TEST( test_tiles_are_unbiased )
{
    static const char* const tiles[] = { "6x6", "1", "2x2", "8x8", "5x3" };
    check_scene( "GGX", make_room( ROOM_GGX ), tiles, is_long() ? 5 : 2, true );
    if ( is_long() )
        check_scene( "diffuse", make_room( ROOM_DIFFUSE ), tiles, 5, true );
}

TEST( test_glass_blending_and_lamps_are_unbiased )
{
    static const char* const tiles[] = { "8x8", "1" };
    check_scene( "glass", make_glass_room(), tiles, 2, is_long() );
    if ( is_long() )
        check_scene( "blended", make_blended_room(), tiles, 2, true );
    if ( is_long() )
        check_scene( "panes", make_pane_room( PANES_AND_AREA_LIGHT ), tiles, 2, true );
    if ( is_long() )
        check_scene( "all lights", make_open_scene( LIT_BY_ALL ), tiles, 2, true );
}

// Samples are drawn by a pixel filter; the other estimator spreads them by it.
TEST( test_filters_are_unbiased )
{
    AUTO_SCENE scene = make_room( ROOM_GGX );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[2]; // of the second, random numbers of its own
    orbit_eyes( eyes, 1, 0.0f, WIDTH, HEIGHT );
    eyes[1] = eyes[0];
    RfRenderSettings settings = settings_of( NULL, 4 ), spread = settings;
    settings.filter = spread.filter = RF_FILTER_BLACKMAN_HARRIS;
    settings.filter_width = spread.filter_width = 1.5;
    spread.estimator = rf_default_render_settings().estimator;
    spread.tile = rf_default_tile( spread.estimator );
    spread.spp *= 6;
    Images found = rendered_images( tracer, eyes, 1, 0, settings ), reference = rendered_images( tracer, eyes, 2, 1, spread );
    assert_unbiased( "GGX, Blackman-Harris, weighted:", &found, &reference, BLOCK );
    free_images( &reference );
    free_images( &found );
}

STATISTICAL_TESTS
