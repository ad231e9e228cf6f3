// Pictures lit by many lamps have the same mean whether lights are sampled by the tree or
// by power, with one light sample or several, alone and in groups of frames; with the tree
// they equal the plain path tracer bit for bit.
#include "support/reference_tracer.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"

enum
{
    SIDE = 16,
    SEEDS = 16,
    QUARTERS = 4,
    EYES = 3
};

// A closed hall with 36 lamps, every third of them two-sided, a row of boxes, a
// lamp with a profile and a spot, under a sky that reaches nothing.
static RfScene make_lamps( void )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.6f, 0.6f, 0.5f ) ), coat = add_material( &b, make_plastic( 0.5f, 0.4f ) );
    uint32_t lamp[2] = { add_material( &b, make_light( 8.0f, false ) ), add_material( &b, make_light( 5.0f, true ) ) };
    add_box( &b, grey, rf_vec3( -6, 0, -6 ), rf_vec3( 6, 3, 6 ), true );
    for ( int i = 0; i < 5; ++i )
        add_box( &b, i % 2 == 0 ? coat : grey, rf_vec3( 2.0f * (float)i - 4.5f, 0, -1 ), rf_vec3( 2.0f * (float)i - 3.5f, 1, 0 ),
                 false );
    for ( int i = 0; i < 36; ++i )
    {
        float x = 2.0f * (float)( i % 6 ) - 5.2f, z = 2.0f * (float)( i / 6 ) - 5.2f, y = 2.4f + 0.1f * (float)( i % 5 );
        add_quad( &b, lamp[i % 3 == 0], rf_vec3( x, y, z ), rf_vec3( x + 0.4f, y, z ), rf_vec3( x + 0.4f, y, z + 0.4f ),
                  rf_vec3( x, y, z + 0.4f ) );
    }
    RfScene scene = finish_scene( &b );
    scene.punctuals = calloc( 2, sizeof *scene.punctuals );
    scene.punctual_count = 2;
    scene.punctuals[0] = make_beam( rf_vec3( 0, 2, 2 ), rf_vec3( 0.4f, -1, 0.2f ), 2.0f );
    scene.punctuals[1] = make_point_light( rf_vec3( 3, 2.5f, 0 ), 6.0f );
    scene.punctuals[1].kind = RF_PUNCTUAL_SPOT;
    scene.punctuals[1].direction = rf_vec3( 0, -1, 0 );
    scene.punctuals[1].cos_inner = 0.9f;
    scene.punctuals[1].cos_outer = 0.7f;
    scene.environment.radiance = rf_vec3( 0.5f, 0.5f, 0.5f );
    return scene;
}

static void make_eyes( RfEye* eyes )
{
    for ( int k = 0; k < EYES; ++k )
        eyes[k] = rf_make_eye( rf_vec3( -1.0f + 0.3f * (float)k, 1.6f, 5.0f ), rf_vec3( 0.1f, -0.6f, -1 ), rf_vec3( 0, 1, 0 ),
                               0.8, SIDE, SIDE );
}

// Means of the quarters of the middle frame.
static void quarters( const RfTracer* tracer, const RfEye* eyes, const RfRenderSettings* settings, double mean[QUARTERS] )
{
    const int middle = 1;
    AUTO_BY( free_rendered ) Rendered r = render_frames( tracer, eyes, EYES, &middle, 1, settings );
    memset( mean, 0, QUARTERS * sizeof *mean );
    for ( int i = 0; i < SIDE * SIDE; ++i )
    {
        int quarter = i / SIDE / ( SIDE / 2 ) * 2 + i % SIDE / ( SIDE / 2 );
        for ( int c = 0; c < 3; ++c )
            mean[quarter] += (double)r.rgb[3 * i + c] * QUARTERS / ( 3.0 * SIDE * SIDE );
    }
}

static void check_same_mean( const RfTracer* tracer, int light_samples, int group )
{
    RfEye eyes[EYES];
    make_eyes( eyes );
    RfRenderSettings settings = plain_settings();
    settings.spp = 40;
    settings.group = group;
    settings.light_samples = light_samples;
    settings.max_depth = 4;
    settings.threads = 1;
    double mean[2][QUARTERS][SEEDS];
    for ( int way = 0; way < 2; ++way )
    {
        settings.light_sampling = way == 0 ? RF_LIGHTS_BY_TREE : RF_LIGHTS_BY_POWER;
        for ( int k = 0; k < SEEDS; ++k )
        {
            double one[QUARTERS];
            settings.seed = (uint64_t)( 100 * way + k + 1 );
            quarters( tracer, eyes, &settings, one );
            for ( int q = 0; q < QUARTERS; ++q )
                mean[way][q][k] = one[q];
        }
    }
    for ( int q = 0; q < QUARTERS; ++q )
    {
        double error[2], m[2];
        for ( int way = 0; way < 2; ++way )
            m[way] = mean_of( mean[way][q], SEEDS, error + way );
        double p = welch_p( mean[0][q], SEEDS, mean[1][q], SEEDS );
        printf( "%d light samples, group %d, quarter %d: %.4f (SE %.4f) by the tree, %.4f (SE %.4f) by power, p %.3g\n",
                light_samples, group, q, m[0], error[0], m[1], error[1], p );
        assert_true( p > 1e-4 && error[0] < 0.02 * m[0] && error[1] < 0.04 * m[1] );
    }
}

TEST( test_tree_and_power_have_the_same_mean )
{
    AUTO_SCENE scene = make_lamps();
    AUTO_TRACER tracer = make_tracer( &scene );
    for ( int k = 0; k < 4; ++k )
        check_same_mean( tracer, k % 2 == 0 ? 1 : 4, k / 2 );
}

TEST( test_tree_is_the_plain_tracer_to_the_bit )
{
    AUTO_SCENE scene = make_lamps();
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    make_eyes( eyes );
    for ( int k = 0; k < 4; ++k )
    {
        RfRenderSettings settings = plain_settings();
        settings.spp = 4;
        settings.group = 0;
        settings.light_samples = 1 + k % 2;
        settings.light_sampling = k < 2 ? RF_LIGHTS_BY_TREE : RF_LIGHTS_BY_POWER;
        AUTO_BY( free_rendered ) Rendered r = render_all( tracer, eyes, EYES, &settings );
        for ( int frame = 0; frame < EYES; ++frame )
        {
            float plain[3 * SIDE * SIDE];
            ReferenceSettings s = reference_settings_of( &settings, frame );
            reference_image( tracer, eyes + frame, &s, plain );
            assert_memory_equal( plain, frame_rgb( &r, frame ), sizeof plain );
        }
    }
}

int main( void )
{
    rf_set_float_mode();
    return run_listed_tests();
}
