// Orthographic cameras see a plane at one angle everywhere, so their pictures have closed forms: what a slab of absorbing
// glass lets through is a geometric series of Fresnel's reflections, and GGX under a white sky has its single-scattering
// albedo. By tiles and frames.
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 24
#define HEIGHT 18
#define SEEDS 4
#define EYES 3

// Eyes a little apart that look down at the origin, at an angle from the vertical.
static void make_eyes( RfEye* eyes, double angle )
{
    for ( int i = 0; i < EYES; ++i )
    {
        RfVec3 back = rf_vec3( (float)sin( angle ), (float)cos( angle ), 0 );
        RfVec3 o = rf_madd( rf_vec3( 0, 0, 0.02f * (float)( i - 1 ) ), back, 3.0f );
        eyes[i] = rf_make_orthographic_eye( o, rf_scale( back, -1.0f ), rf_vec3( 0, 0, -1 ), 0.3, WIDTH, HEIGHT );
    }
}

// The means of the channels of the middle frame over its pixels, for each seed.
static void render_means( const RfScene* scene, double angle, int group, double means[3][SEEDS] )
{
    RfTracer* tracer = make_tracer( scene );
    RfEye eyes[EYES];
    make_eyes( eyes, angle );
    for ( int k = 0; k < SEEDS; ++k )
    {
        RfRenderSettings settings = plain_settings();
        settings.group = group;
        settings.tile = group > 0 ? ( RfTile ){ RF_TILE_BLOCK, 3, 3 } : settings.tile;
        settings.spp = group > 0 ? 120 : 160;
        settings.max_depth = 32;
        settings.seed = (uint64_t)k + 1;
        int frame = EYES / 2;
        Rendered r = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
        for ( int c = 0; c < 3; ++c )
        {
            means[c][k] = 0.0;
            for ( size_t i = 0; i < r.pixels; ++i )
                means[c][k] += (double)frame_rgb( &r, 0 )[3 * i + (size_t)c] / (double)r.pixels;
        }
        free_rendered( &r );
    }
    rf_destroy_tracer( tracer );
}

static void check( const char* what, const RfScene* scene, double angle, const double wanted[3] )
{
    for ( int group = 0; group <= 1; ++group )
    {
        double means[3][SEEDS];
        render_means( scene, angle, group, means );
        for ( int c = 0; c < 3; ++c )
        {
            double se, mean = mean_of( means[c], SEEDS, &se );
            printf( "%s, group %d, channel %d: %.5f, wanted %.5f, standard error %.5f\n", what, group, c, mean, wanted[c], se );
            assert_true( se < 0.0016 * wanted[c] ); // or the bound would say nothing
            assert_true( fabs( mean / wanted[c] - 1.0 ) < 0.005 );
        }
    }
}

// ── a slab ──

#define IOR 1.5
#define THICKNESS 0.5

// Before a wall of radiance 1 that shines upwards.
static RfScene make_slab( void )
{
    SceneBuilder b = { 0 };
    RfMaterial glass = make_glass( (float)IOR, 0.0f, false );
    glass.absorption = rf_vec3( 0.0f, 0.6f, 1.5f );
    RfMaterial light = make_light( 1.0f, false );
    light.emission = rf_vec3( 1, 1, 1 );
    add_box( &b, add_material( &b, glass ), rf_vec3( -20, 0, -20 ), rf_vec3( 20, (float)THICKNESS, 20 ), false );
    float far = 90.0f;
    add_quad( &b, add_material( &b, light ), rf_vec3( -far, -1, far ), rf_vec3( far, -1, far ), rf_vec3( far, -1, -far ),
              rf_vec3( -far, -1, -far ) );
    return finish_scene( &b );
}

TEST( test_slabs_let_through_what_fresnel_says )
{
    RfScene scene = make_slab();
    static const double s_angles[] = { 0.0, 1.0 }, s_absorption[] = { 0.0, 0.6, 1.5 };
    for ( int k = 0; k < 2; ++k )
    {
        double inside = sqrt( 1.0 - pow( sin( s_angles[k] ) / IOR, 2.0 ) ), f = fresnel( cos( s_angles[k] ), IOR );
        double wanted[3];
        for ( int c = 0; c < 3; ++c )
        {
            double t = exp( -s_absorption[c] * THICKNESS / inside );
            wanted[c] = ( 1.0 - f ) * ( 1.0 - f ) * t / ( 1.0 - f * f * t * t );
        }
        char what[64];
        snprintf( what, sizeof what, "slab at %.0f degrees", s_angles[k] * 57.2958 );
        check( what, &scene, s_angles[k], wanted );
    }
    rf_destroy_scene( &scene );
}

// ── GGX ──

// What GGX with height-correlated shadowing and without Fresnel reflects once, of light from everywhere: the integral of
// D G2 (o·m) / μo over the normals m.
static double single_scattering_albedo( double alpha, double cos_o )
{
    const int steps = 1000;
    double sum = 0.0, sin_o = sqrt( 1.0 - cos_o * cos_o ), a2 = alpha * alpha;
    for ( int i = 0; i < steps; ++i )
    {
        // tan θ = α √(u / (1 − u)) is distributed as D cos θ
        double u = ( i + 0.5 ) / steps, tan2 = a2 * u / ( 1.0 - u ), cos_m = 1.0 / sqrt( 1.0 + tan2 ),
               sin_m = sqrt( 1.0 - cos_m * cos_m );
        for ( int j = 0; j < steps / 4; ++j )
        {
            double phi = 3.14159265358979 * ( j + 0.5 ) / ( steps / 4 );
            double o_m = sin_o * sin_m * cos( phi ) + cos_o * cos_m, cos_i = 2.0 * o_m * cos_m - cos_o;
            if ( o_m <= 0.0 || cos_i <= 0.0 )
                continue;
            double so = sqrt( a2 + ( 1.0 - a2 ) * cos_o * cos_o ), si = sqrt( a2 + ( 1.0 - a2 ) * cos_i * cos_i );
            sum += 2.0 / ( so / cos_o + si / cos_i ) * o_m / ( cos_o * cos_m );
        }
    }
    return sum / ( (double)steps * ( steps / 4 ) );
}

TEST( test_ggx_has_its_single_scattering_albedo )
{
    static const double s_roughness[] = { 0.4, 0.7, 1.0 }, s_angles[] = { 0.3, 1.2 };
    for ( int i = 0; i < 6; ++i )
    {
        double roughness = s_roughness[i / 2], angle = s_angles[i % 2];
        SceneBuilder b = { 0 };
        RfMaterial white = make_metal( 1.0f, (float)roughness );
        white.specular = rf_vec3( 1, 1, 1 );
        uint32_t metal = add_material( &b, white );
        add_quad( &b, metal, rf_vec3( -9, 0, 9 ), rf_vec3( 9, 0, 9 ), rf_vec3( 9, 0, -9 ), rf_vec3( -9, 0, -9 ) );
        RfScene scene = finish_scene( &b );
        scene.environment.radiance = rf_vec3( 1, 1, 1 );
        char what[64];
        snprintf( what, sizeof what, "GGX of roughness %.1f at %.0f degrees", roughness, angle * 57.2958 );
        double albedo = single_scattering_albedo( roughness * roughness, cos( angle ) );
        check( what, &scene, angle, ( double[3] ){ albedo, albedo, albedo } );
        rf_destroy_scene( &scene );
    }
}

STATISTICAL_TESTS
