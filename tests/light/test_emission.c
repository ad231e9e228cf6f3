// Light that leaves emitters carries the flux of closed forms, has the densities that are asked for, and lights a floor as
// the light samples of the path tracer do.
#include "light/emission.h"
#include "trace/trace.h"
#include "support/render_support.h"
#include "support/statistics.h"
#include "support/rooms.h"
#include "support/test.h"

#include "base/random.h"

#define PI 3.14159265358979324

static void numbers_of( uint64_t seed, uint32_t i, float u[6] )
{
    RfRandomKey key = rf_pixel_key( rf_pass_key( seed, 0, 0, 0 ), i );
    for ( uint32_t k = 0; k < 6; ++k )
        u[k] = rf_random( key, k );
}

static RfLights collect( const RfScene* scene )
{
    RfLights lights;
    RfError error;
    assert_int_equal( rf_collect_lights( scene, &lights, &error ), RF_OK );
    assert_true( lights.count > 0 );
    return lights;
}

static void add_lamp( RfScene* scene, RfPunctual lamp )
{
    scene->punctuals = realloc( scene->punctuals, (size_t)( scene->punctual_count + 1 ) * sizeof lamp );
    scene->punctuals[scene->punctual_count++] = lamp;
}

static RfPunctual make_spot( RfVec3 position, RfVec3 direction, float intensity, float cos_inner, float cos_outer )
{
    RfPunctual spot = make_point_light( position, intensity );
    spot.kind = RF_PUNCTUAL_SPOT;
    spot.direction = rf_normalize( direction );
    spot.cos_inner = cos_inner;
    spot.cos_outer = cos_outer;
    return spot;
}

static RfPunctual make_sun( RfVec3 direction, float irradiance )
{
    RfPunctual sun = make_point_light( rf_vec3( 0, 0, 0 ), irradiance );
    sun.kind = RF_PUNCTUAL_DIRECTIONAL;
    sun.direction = rf_normalize( direction );
    return sun;
}

// A square of side 2, and what lights it.
static RfScene make_square( RfMaterial material )
{
    SceneBuilder b = { 0 };
    uint32_t m = add_material( &b, material );
    add_quad( &b, m, rf_vec3( -1, 0, 1 ), rf_vec3( 1, 0, 1 ), rf_vec3( 1, 0, -1 ), rf_vec3( -1, 0, -1 ) );
    return finish_scene( &b );
}

static RfScene make_lit_square( RfPunctual lamp )
{
    RfScene scene = make_square( make_lambert( 0.5f, 0.5f, 0.5f ) );
    add_lamp( &scene, lamp );
    return scene;
}

static RfVec3 sphere_direction( float u, float v )
{
    float z = 1.0f - 2.0f * u, r = sqrtf( 1.0f - z * z );
    return rf_vec3( r * cosf( 2.0f * RF_PI * v ), z, r * sinf( 2.0f * RF_PI * v ) );
}

static uint32_t bits_of( float u ) { return (uint32_t)( (double)u * 0x1p32 ); }

// A light by its power, and a place on it or its direction from infinity.
static bool draw( const RfLights* lights, const RfScene* scene, const float u[4], RfEmission* e )
{
    uint32_t light = rf_select_light_by_power( lights, bits_of( u[0] ), bits_of( u[1] ) );
    float column = u[0] * (float)lights->count;
    return rf_sample_emitter( lights, scene, light, lights->power_fraction[light], column - floorf( column ), u + 2, e );
}

// Its light in an even direction, or through the disc around the scene, over the density: red flux.
static double flux_of( const RfLights* lights, const RfScene* scene, const float u[6] )
{
    RfEmission e;
    if ( !draw( lights, scene, u, &e ) )
        return 0.0;
    double disc = PI * (double)lights->radius * (double)lights->radius;
    if ( e.infinite )
        return (double)e.radiance.x * disc / ( (double)e.pdf_light * (double)e.pdf_solid_angle );
    if ( !rf_emit_towards( lights, sphere_direction( u[4], u[5] ), &e ) )
        return 0.0;
    assert_true( fabsf( rf_length( e.normal ) - 1.0f ) < 1e-5f && rf_dot( e.normal, e.direction ) > 0.0f );
    double cosine = e.delta_position ? 1.0 : (double)rf_dot( e.normal, e.direction );
    return (double)e.radiance.x * cosine * 4.0 * PI / ( (double)e.pdf_light * (double)e.pdf_area );
}

enum
{
    STRATA = 400 // of directions, along each axis
};

// The mean flux, and its standard error where directions were random.
static double mean_flux( const RfLights* lights, const RfScene* scene, double* error )
{
    double sum = 0.0, sum2 = 0.0, count = (double)STRATA * STRATA;
    for ( uint32_t i = 0; i < STRATA * STRATA; ++i )
    {
        float u[6];
        numbers_of( 1, i, u );
        u[4] = ( (float)( i % STRATA ) + u[4] ) / STRATA;
        u[5] = ( (float)( i / STRATA ) + u[5] ) / STRATA;
        double value = flux_of( lights, scene, u );
        sum += value / count;
        sum2 += value * value / count;
    }
    *error = sqrt( fmax( sum2 - sum * sum, 0.0 ) / count );
    return sum;
}

// The flux of emitted light against the closed form.
static void check_flux( const char* what, RfScene scene, double expected, double tolerance )
{
    RfLights lights = collect( &scene );
    double error, flux = mean_flux( &lights, &scene, &error );
    printf( "%s: flux %.6g, expected %.6g\n", what, flux, expected );
    assert_true( fabs( flux - expected ) <= tolerance * expected );
    rf_destroy_lights( &lights );
    rf_destroy_scene( &scene );
}

TEST( test_flux_is_the_closed_form )
{
    RfVec3 above = rf_vec3( 0, 2, 0 ), down = rf_vec3( 0.3f, -1, 0.1f );
    check_flux( "one-sided square", make_square( make_light( 3.0f, false ) ), PI * 4.0 * 3.0, 2e-3 );
    check_flux( "two-sided square", make_square( make_light( 3.0f, true ) ), 2.0 * PI * 4.0 * 3.0, 1e-2 );
    check_flux( "point", make_lit_square( make_point_light( above, 5.0f ) ), 4.0 * PI * 5.0, 2e-3 );
    // 2π times ∫ t² over the blend, and the rest
    check_flux( "spot", make_lit_square( make_spot( above, down, 5.0f, 0.9f, 0.8f ) ), 2.0 * PI * ( 0.1 / 3.0 + 0.1 ) * 5.0,
                2e-3 );
    check_flux( "spot without blend", make_lit_square( make_spot( above, down, 5.0f, 0.8f, 0.8f ) ), 2.0 * PI * 0.2 * 5.0, 5e-3 );
    check_flux( "spot that is all blend", make_lit_square( make_spot( above, down, 5.0f, 1.0f, 0.5f ) ),
                2.0 * PI * 0.5 / 3.0 * 5.0, 2e-3 );
    RfPunctual ball = make_spot( above, down, 5.0f, 1.0f, 0.5f ), plane = make_point_light( above, 5.0f );
    ball.radius = 0.3f;
    check_flux( "spot with a radius", make_lit_square( ball ), 2.0 * PI * 0.5 / 3.0 * 5.0, 2e-2 );
    plane.kind = RF_PUNCTUAL_PLANE;
    plane.across = rf_vec3( 1, 0, 0 );
    plane.half[0] = plane.half[1] = 0.5f;
    check_flux( "plane", make_lit_square( plane ), PI * 5.0, 2e-3 );
    plane.tan_spread = 1.0f;
    plane.spread_scale = (float)( 1.0 / ( 1.0 - PI / 4.0 ) );
    plane.ellipse = true;
    check_flux( "ellipse with a spread", make_lit_square( plane ), PI * 5.0, 2e-3 );
    // the ball around the square has the radius √2
    check_flux( "sun", make_lit_square( make_sun( down, 7.0f ) ), PI * 2.0 * 7.0, 2e-3 );
    RfScene scene = make_square( make_lambert( 0.5f, 0.5f, 0.5f ) );
    scene.environment.radiance = rf_vec3( 2, 2, 1 );
    check_flux( "even sky", scene, 4.0 * PI * 2.0 * PI * 2.0, 2e-3 );
}

// The mean over a map's interpolated pixels, by quadrature.
TEST( test_flux_of_a_map )
{
    enum
    {
        ROWS = 400
    };
    RfScene scene = make_open_scene( LIT_BY_MAP );
    RfLights lights = collect( &scene );
    double light = 0.0, radius2 = (double)lights.radius * (double)lights.radius;
    for ( int i = 0; i < 2 * ROWS * ROWS; ++i )
    {
        double z = 1.0 - ( i / ( 2 * ROWS ) + 0.5 ) * 2.0 / ROWS, phi = ( i % ( 2 * ROWS ) + 0.5 ) * PI / ROWS,
               r = sqrt( 1.0 - z * z );
        RfVec3 d = rf_vec3( (float)( r * cos( phi ) ), (float)z, (float)( r * sin( phi ) ) );
        light += (double)rf_sky_radiance( &lights.sky, d ).x * 4.0 * PI / ( 2.0 * ROWS * ROWS );
    }
    rf_destroy_lights( &lights );
    check_flux( "map", scene, light * PI * radius2, 3e-3 );
}

// The flux of textured light is π times the mean radiance of its area; what blends emits that much less.
TEST( test_flux_of_a_texture )
{
    enum
    {
        SIDE = 300
    };
    for ( int blended = 0; blended < 2; ++blended )
    {
        RfScene scene = make_square( make_light( 3.0f, false ) );
        add_test_textures( &scene );
        RfFactors factors = { .base = { 1, 1, 1, blended ? 0.25 : 1 }, .roughness = 1, .ior = 1.5 };
        RfTextured* t = texture_material( &scene, 0, factors );
        t->blended = blended;
        use_texture( t, RF_TEXTURE_EMISSIVE, 3, 0 );
        double mean = 0.0;
        for ( int i = 0; i < 2 * SIDE * SIDE; ++i )
        {
            float root = sqrtf( ( (float)( i / 2 % SIDE ) + 0.5f ) / SIDE ), v = ( (float)( i / 2 / SIDE ) + 0.5f ) / SIDE;
            mean += (double)rf_emission_at( &scene, scene.materials, (uint32_t)( i % 2 ), 1.0f - root, v * root ).x /
                    ( 2.0 * SIDE * SIDE );
        }
        RfLights lights = collect( &scene );
        double error, flux = mean_flux( &lights, &scene, &error ), expected = PI * 4.0 * mean * ( blended ? 0.25 : 1.0 );
        printf( "textured, blended %d: flux %.5g (SE %.2g), expected %.5g\n", blended, flux, error, expected );
        assert_true( fabs( flux - expected ) < 4.0 * error + 2e-3 * expected && error < 0.02 * expected );
        rf_destroy_lights( &lights );
        rf_destroy_scene( &scene );
    }
}

// What connections ask of a place on a triangle is what it was drawn with, the density of the sky that of its samples.
TEST( test_densities_are_those_of_samples )
{
    RfScene scene = make_open_scene( LIT_BY_ALL );
    RfLights lights = collect( &scene );
    int triangles = 0, skies = 0;
    for ( uint32_t i = 0; i < 4000; ++i )
    {
        float u[6];
        numbers_of( 3, i, u );
        RfEmission e;
        if ( !draw( &lights, &scene, u, &e ) )
            continue;
        RfEmission asked = { .light = e.light };
        if ( e.light < lights.triangle_count )
        {
            rf_find_emission_pdf( &lights, &asked );
            assert_true( asked.pdf_light == e.pdf_light && asked.pdf_area == e.pdf_area );
            ++triangles;
        }
        else if ( e.light == rf_sky_number( &lights ) )
        {
            float pdf = rf_sky_pdf_solid_angle( &lights.sky, rf_scale( e.direction, -1.0f ) );
            assert_true( e.infinite && fabsf( pdf / e.pdf_solid_angle - 1.0f ) < 2e-3f );
            ++skies;
        }
        else
            assert_true( e.infinite ? e.pdf_solid_angle == 1.0f : e.pdf_area == 1.0f );
    }
    printf( "%d on triangles, %d from the sky\n", triangles, skies );
    assert_true( triangles > 20 && skies > 100 );
    rf_destroy_lights( &lights );
    rf_destroy_scene( &scene );
    scene = make_square( make_light( 3.0f, true ) );
    lights = collect( &scene );
    RfEmission e = { .light = 0 };
    rf_find_emission_pdf( &lights, &e );
    assert_true( e.pdf_area == 0.5f ); // a triangle of half the square
    assert_true( e.pdf_light == 0.25f );
    rf_destroy_lights( &lights );
    rf_destroy_scene( &scene );
}

// A triangle emits on its side, a lamp by its falloff.
TEST( test_steered_rays )
{
    RfScene scene = make_open_scene( LIT_BY_ALL );
    RfLights lights = collect( &scene );
    int lit = 0;
    for ( uint32_t i = 0; i < 20000; ++i )
    {
        float u[6];
        numbers_of( 4, i, u );
        RfEmission e;
        if ( !draw( &lights, &scene, u, &e ) || e.infinite )
            continue;
        RfVec3 direction = sphere_direction( u[4], u[5] );
        bool emits = rf_emit_towards( &lights, direction, &e );
        if ( e.light < lights.triangle_count )
            assert_true( emits == ( rf_dot( e.normal, direction ) > 0.0f ) );
        else if ( emits )
        {
            const RfPunctual* lamp = lights.punctual + ( e.light - lights.triangle_count );
            if ( lamp->kind != RF_PUNCTUAL_PLANE && !( lamp->radius > 0.0f ) )
                assert_true( e.radiance.x == lamp->intensity.x * rf_lamp_falloff( lamp, direction ) );
        }
        lit += emits;
    }
    assert_true( lit > 200 );
    rf_destroy_lights( &lights );
    rf_destroy_scene( &scene );
}

enum
{
    PATCHES = 4, // along each side of the floor
    SEEDS = 12,
    RAYS = 100000
};

// A floor of side 2 under a black ball: no light is reflected to it.
static RfScene make_shaded_floor( void )
{
    SceneBuilder b = { 0 };
    uint32_t white = add_material( &b, make_lambert( 1, 1, 1 ) ), black = add_material( &b, make_lambert( 0, 0, 0 ) );
    add_quad( &b, white, rf_vec3( -1, 0, 1 ), rf_vec3( 1, 0, 1 ), rf_vec3( 1, 0, -1 ), rf_vec3( -1, 0, -1 ) );
    add_sphere( &b, black, rf_vec3( 0.3f, 0.5f, 0 ), 0.25f, 8 );
    uint32_t lamp = add_material( &b, make_light( 2.0f, true ) );
    add_quad( &b, lamp, rf_vec3( -0.9f, 0.9f, -0.3f ), rf_vec3( -0.6f, 0.9f, -0.3f ), rf_vec3( -0.6f, 1.2f, 0.3f ),
              rf_vec3( -0.9f, 1.2f, 0.3f ) );
    RfScene scene = finish_scene( &b );
    add_lamp( &scene, make_point_light( rf_vec3( 0.5f, 1.2f, 0.3f ), 1.0f ) );
    scene.punctuals[0].range = 2.0f;
    add_lamp( &scene, make_spot( rf_vec3( 0.6f, 1.0f, -0.6f ), rf_vec3( -0.4f, -1, 0.2f ), 2.0f, 0.95f, 0.8f ) );
    add_lamp( &scene, make_sun( rf_vec3( 0.5f, -1, 0.4f ), 0.6f ) );
    add_lamp( &scene, make_beam( rf_vec3( -0.4f, 1.3f, 0.5f ), rf_vec3( 0.3f, -1, -0.2f ), 1.0f ) );
    scene.environment.radiance = rf_vec3( 0.3f, 0.3f, 0.3f );
    return scene;
}

// Irradiance of the patches by light that is emitted towards points of the floor and arrives there, W/m².
static void irradiance_by_rays( const RfTracer* tracer, uint64_t seed, double irradiance[PATCHES * PATCHES] )
{
    const RfLights* lights = rf_tracer_lights( tracer );
    for ( int i = 0; i < PATCHES * PATCHES; ++i )
        irradiance[i] = 0.0;
    for ( uint32_t i = 0; i < RAYS; ++i )
    {
        float u[6], b1, b2;
        uint32_t triangle;
        RfEmission e;
        numbers_of( seed, i, u );
        if ( !draw( lights, rf_tracer_scene( tracer ), u, &e ) )
            continue;
        RfVec3 p = rf_vec3( 2.0f * u[4] - 1.0f, 0.0f, 2.0f * u[5] - 1.0f ), from;
        if ( e.infinite )
            from = rf_madd( p, e.direction, -3.0f * lights->reach );
        else
        {
            from = rf_madd( e.position, e.normal, e.offset );
            if ( !rf_emit_towards( lights, rf_normalize( rf_sub( p, from ) ), &e ) )
                continue;
        }
        const float* o[3] = { &from.x, &from.y, &from.z };
        const float* d[3] = { &e.direction.x, &e.direction.y, &e.direction.z };
        rf_trace_nearest( tracer, 1, o, d, false, &triangle, &b1, &b2 );
        if ( triangle > 1 || e.direction.y >= 0.0f ) // the floor comes first, and is lit from above
            continue;
        RfVec3 way = rf_sub( p, from );
        double geometry = -(double)e.direction.y, density = (double)e.pdf_light * (double)e.pdf_solid_angle;
        if ( !e.infinite )
        {
            geometry *= ( e.delta_position ? 1.0 : (double)rf_dot( e.normal, e.direction ) ) / (double)rf_dot( way, way );
            density = (double)e.pdf_light * (double)e.pdf_area;
        }
        int column = (int)( u[4] * PATCHES ), row = (int)( u[5] * PATCHES );
        irradiance[row * PATCHES + column] += (double)( e.radiance.x * rf_emission_falloff( &e, p, rf_length( way ) ) ) *
                                              geometry / density * ( PATCHES * PATCHES ) / RAYS;
    }
}

// The same by light samples: π times what a parallel eye below the lamps sees of a white floor.
static void irradiance_by_light_samples( const RfTracer* tracer, uint64_t seed, double irradiance[PATCHES * PATCHES] )
{
    RfEye eye =
        rf_make_orthographic_eye( rf_vec3( 0, 0.2f, 0 ), rf_vec3( 0, -1, 0 ), rf_vec3( 0, 0, -1 ), 1.0, PATCHES, PATCHES );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = 3000;
    settings.max_depth = 2;
    settings.seed = seed;
    settings.threads = 1;
    int frame = 0;
    Rendered r = render_frames( tracer, &eye, 1, &frame, 1, &settings );
    for ( int i = 0; i < PATCHES * PATCHES; ++i )
        irradiance[i] = PI * (double)r.rgb[3 * i];
    free_rendered( &r );
}

TEST( test_floor_is_lit_as_by_light_samples )
{
    RfScene scene = make_shaded_floor();
    RfTracer* tracer = make_tracer( &scene );
    static double rays[PATCHES * PATCHES][SEEDS], samples[PATCHES * PATCHES][SEEDS];
    for ( int k = 0; k < SEEDS; ++k )
    {
        double by_rays[PATCHES * PATCHES], by_samples[PATCHES * PATCHES];
        irradiance_by_rays( tracer, (uint64_t)k + 10, by_rays );
        irradiance_by_light_samples( tracer, (uint64_t)k + 1, by_samples );
        for ( int i = 0; i < PATCHES * PATCHES; ++i )
        {
            rays[i][k] = by_rays[i];
            samples[i][k] = by_samples[i];
        }
    }
    for ( int i = 0; i < PATCHES * PATCHES; ++i )
    {
        double error[2], a = mean_of( rays[i], SEEDS, error ), b = mean_of( samples[i], SEEDS, error + 1 ),
                         p = welch_p( rays[i], SEEDS, samples[i], SEEDS );
        printf( "patch %2d: %.4f (SE %.4f) by emitted rays, %.4f (SE %.4f) by light samples, p %.3g\n", i, a, error[0], b,
                error[1], p );
        assert_true( p > 1e-4 && error[0] < 0.015 * a && error[1] < 0.01 * b );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

int main( void )
{
    rf_set_float_mode();
    return run_listed_tests();
}
