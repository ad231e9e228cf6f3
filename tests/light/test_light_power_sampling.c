// Lights are collected and sampled in proportion to their power, with densities that
// integrate to one; a square light on a small receiver matches Lambert's closed form.
#include "base/random.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "light/light.h"

#define MOST_LIGHTS 256

static void add_patch( SceneBuilder* b, uint32_t material, float x, float side )
{
    add_quad( b, material, rf_vec3( x, 0, 0 ), rf_vec3( x + side, 0, 0 ), rf_vec3( x + side, side, 0 ), rf_vec3( x, side, 0 ) );
}

// Lights of many powers, some two-sided, among what must not become one.
static RfScene make_lights_scene( void )
{
    SceneBuilder b = { 0 };
    uint32_t black = add_material( &b, make_light( 0.0f, true ) );
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    uint32_t one = add_material( &b, make_light( 1.0f, false ) );
    uint32_t two = add_material( &b, make_light( 1.0f, true ) );
    uint32_t blue = add_material( &b, make_light( 1.0f, false ) );
    b.scene.materials[blue].emission = rf_vec3( 0, 0, 5.0f );
    uint32_t strong = add_material( &b, make_light( 300.0f, false ) );
    add_patch( &b, grey, 0.0f, 1.0f );
    add_patch( &b, black, 2.0f, 1.0f );
    add_patch( &b, one, 4.0f, 0.0f ); // no area
    for ( int k = 0; k < 12; ++k )
        add_patch( &b, k % 3 == 0 ? two : ( k % 3 == 1 ? one : blue ), 6.0f + 2.0f * (float)k, 0.1f * (float)( k + 1 ) );
    add_patch( &b, strong, 40.0f, 0.05f );
    add_patch( &b, black, 42.0f, 1.0f );
    return finish_scene( &b );
}

static double power_of( const RfScene* scene, const RfLight* light )
{
    const RfMaterial* m = scene->materials + scene->triangles.material[light->triangle];
    double area = 0.5 * (double)rf_length( rf_cross( light->e1, light->e2 ) );
    return area * (double)rf_luminance( m->emission ) * ( m->double_sided ? 2.0 : 1.0 );
}

// Probability of every light as the alias table has it.
static void table_shares( const RfLights* lights, double* share )
{
    for ( uint32_t i = 0; i < lights->count; ++i )
        share[i] = 0.0;
    for ( uint32_t i = 0; i < lights->count; ++i )
    {
        double own = lights->alias[i] == i ? 1.0 : (double)lights->alias_threshold[i] * 0x1p-32;
        assert_true( own >= 0.0 && own <= 1.0 && lights->alias[i] < lights->count );
        share[i] += own / lights->count;
        share[lights->alias[i]] += ( 1.0 - own ) / lights->count;
    }
}

static RfLights collect( const RfScene* scene )
{
    RfLights lights;
    RfError error;
    assert_int_equal( rf_collect_lights( scene, &lights, &error ), RF_OK );
    assert_true( lights.count <= MOST_LIGHTS );
    return lights;
}

TEST( test_who_is_a_light )
{
    AUTO_SCENE scene = make_lights_scene();
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    assert_int_equal( lights.count, 2 * 13 );
    uint32_t of_lights = 0;
    for ( uint32_t i = 0; i < scene.triangles.count; ++i )
    {
        uint32_t k = lights.of_triangle[i];
        if ( k == RF_NO_LIGHT )
            continue;
        of_lights += 1;
        assert_int_equal( lights.light[k].triangle, i );
        const RfMaterial* m = scene.materials + scene.triangles.material[i];
        assert_true( m->emission.x + m->emission.y + m->emission.z > 0.0f );
        assert_true( lights.light[k].area > 0.0f && lights.light[k].two_sided == m->double_sided );
        assert_true( fabsf( rf_length( lights.light[k].normal ) - 1.0f ) < 1e-6f && lights.light[k].normal.z > 0.0f );
    }
    assert_int_equal( of_lights, lights.count );
}

TEST( test_shares_and_densities )
{
    AUTO_SCENE scene = make_lights_scene();
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    double share[MOST_LIGHTS], total = 0.0, integral = 0.0;
    table_shares( &lights, share );
    for ( uint32_t i = 0; i < lights.count; ++i )
        total += power_of( &scene, lights.light + i );
    for ( uint32_t i = 0; i < lights.count; ++i )
    {
        const RfLight* light = lights.light + i;
        double expected = power_of( &scene, light ) / total;
        assert_true( fabs( share[i] - expected ) < 1e-7 ); // alias_threshold is a float
        assert_true( fabs( (double)lights.power_fraction[i] / expected - 1.0 ) < 1e-6 );
        assert_true( fabs( (double)light->pdf_area * (double)light->area - 1.0 ) < 1e-6 );
        integral += (double)lights.power_fraction[i];
    }
    assert_true( fabs( integral - 1.0 ) < 1e-6 );
}

TEST( test_two_sided_counts_double )
{
    SceneBuilder b = { 0 };
    uint32_t one = add_material( &b, make_light( 3.0f, false ) ), two = add_material( &b, make_light( 3.0f, true ) );
    add_patch( &b, one, 0.0f, 1.0f );
    add_patch( &b, two, 2.0f, 1.0f );
    AUTO_SCENE scene = finish_scene( &b );
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    double share[MOST_LIGHTS];
    table_shares( &lights, share );
    for ( uint32_t i = 0; i < 4; ++i )
        assert_true( fabs( share[i] - ( lights.light[i].two_sided ? 2.0 : 1.0 ) / 6.0 ) < 1e-7 );
}

TEST( test_picks_follow_power )
{
    enum
    {
        PICKS = 2000000
    };
    AUTO_SCENE scene = make_lights_scene();
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    double count[MOST_LIGHTS] = { 0 }, total = 0.0, chi_square = 0.0;
    for ( uint32_t k = 0; k < PICKS; ++k )
        count[rf_select_light_by_power( &lights, rf_random_bits( rf_pixel_key( 99, k ), 0 ),
                                        rf_random_bits( rf_pixel_key( 99, k ), 1 ) )] += 1.0;
    for ( uint32_t i = 0; i < lights.count; ++i )
        total += power_of( &scene, lights.light + i );
    for ( uint32_t i = 0; i < lights.count; ++i )
    {
        double expected = PICKS * power_of( &scene, lights.light + i ) / total;
        chi_square += ( count[i] - expected ) * ( count[i] - expected ) / expected;
    }
    double p = chi_square_p( chi_square, lights.count - 1 );
    printf( "picks of %u lights: chi-square p %.3g\n", lights.count, p );
    assert_true( p > 1e-4 && p < 1.0 - 1e-4 );
    assert_true( rf_select_light_by_power( &lights, 0, 0 ) < lights.count &&
                 rf_select_light_by_power( &lights, UINT32_MAX, UINT32_MAX ) < lights.count );
}

// Many lights, every second one a thousandth as strong: picked as the densities
// say, which a share test with the bits that the column left over is not.
TEST( test_small_among_many )
{
    enum
    {
        LIGHTS = 20000,
        PICKS = 40000000
    };
    SceneBuilder b = { 0 };
    uint32_t strong = add_material( &b, make_light( 1000.0f, false ) ), weak = add_material( &b, make_light( 1.0f, false ) );
    for ( int i = 0; i < LIGHTS / 2; ++i )
        add_quad( &b, i % 2 == 0 ? strong : weak, rf_vec3( (float)i, 0, 0 ), rf_vec3( (float)i + 0.5f, 0, 0 ),
                  rf_vec3( (float)i + 0.5f, 1, 0 ), rf_vec3( (float)i, 1, 0 ) );
    AUTO_SCENE scene = finish_scene( &b );
    AUTO_BY( rf_destroy_lights ) RfLights lights;
    RfError error;
    assert_int_equal( rf_collect_lights( &scene, &lights, &error ), RF_OK );
    assert_int_equal( lights.count, LIGHTS );
    double weak_picks = 0.0, expected = 0.0;
    for ( uint32_t k = 0; k < PICKS; ++k )
    {
        RfRandomKey key = rf_pixel_key( rf_pass_key( 7, 0, 0, 0 ), k );
        uint32_t light = rf_select_light_by_power( &lights, rf_random_bits( key, 0 ), rf_random_bits( key, 1 ) );
        weak_picks += (double)( lights.light[light].radiance.x < 10.0f );
    }
    for ( uint32_t i = 0; i < LIGHTS; ++i )
        expected += lights.light[i].radiance.x < 10.0f ? PICKS * (double)lights.power_fraction[i] : 0.0;
    printf( "weak lights: %.0f picks, %.0f expected\n", weak_picks, expected );
    assert_true( fabs( weak_picks - expected ) < 4.0 * sqrt( expected ) );
}

TEST( test_no_lights_no_picks )
{
    RfScene empty = { 0 };
    RfLights lights = collect( &empty );
    assert_int_equal( lights.count, 0 );
    rf_destroy_lights( &lights );
    SceneBuilder b = { 0 };
    add_patch( &b, add_material( &b, make_light( 0.0f, true ) ), 0.0f, 1.0f );
    add_patch( &b, add_material( &b, make_light( 5.0f, true ) ), 0.0f, 0.0f ); // all of them without area
    AUTO_SCENE scene = finish_scene( &b );
    lights = collect( &scene );
    assert_int_equal( lights.count, 0 );
    rf_destroy_lights( &lights );
}

// Irradiance at the origin of a surface with normal n from a polygon of
// radiance 1 wholly above its horizon: ½ Σ θ_i Γ_i·n (Lambert 1760).
static double polygon_irradiance( const RfVec3* corner, int count, RfVec3 n )
{
    double sum = 0.0;
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 a = rf_normalize( corner[i] ), b = rf_normalize( corner[( i + 1 ) % count] );
        RfVec3 axis = rf_normalize( rf_cross( a, b ) );
        sum += 0.5 * acos( (double)rf_dot( a, b ) ) * (double)rf_dot( axis, n );
    }
    return fabs( sum );
}

// A square light above the origin, facing down; the receiver lies in the
// plane y = 0 (parallel) or z = 0 (perpendicular to the light).
typedef struct Receiver
{
    const char* name;
    RfVec3 normal, eye;
    float z0; // the light reaches from here on
} Receiver;

static const Receiver receivers[] = {
    { "parallel", { 0, 1, 0 }, { 1.5f, 0.7f, 0.3f }, -0.5f },
    { "perpendicular", { 0, 0, 1 }, { 0.6f, -0.3f, 1.5f }, 0.2f },
};

#define RADIANCE 5.0f
#define SEED_COUNT 16

static void check_square( const Receiver* receiver, bool facing, bool two_sided, int light_samples )
{
    const float albedo = 0.7f;
    RfVec3 p[4] = { { -0.5f, 0.8f, receiver->z0 },
                    { 0.5f, 0.8f, receiver->z0 },
                    { 0.5f, 0.8f, receiver->z0 + 1.0f },
                    { -0.5f, 0.8f, receiver->z0 + 1.0f } };
    SceneBuilder b = { 0 };
    uint32_t light = add_material( &b, make_light( RADIANCE, two_sided ) );
    uint32_t plane = add_material( &b, make_lambert( albedo, albedo, albedo ) );
    if ( facing )
        add_quad( &b, light, p[0], p[1], p[2], p[3] );
    else
        add_quad( &b, light, p[3], p[2], p[1], p[0] );
    RfVec3 t, s;
    rf_basis( receiver->normal, &t, &s );
    add_quad( &b, plane, rf_scale( t, -0.1f ), rf_scale( s, -0.1f ), rf_scale( t, 0.1f ), rf_scale( s, 0.1f ) );
    AUTO_SCENE scene = finish_scene( &b );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eye = rf_make_eye( receiver->eye, rf_scale( receiver->eye, -1.0f ), rf_vec3( 0.1f, 1, 0.2f ), 1e-5, 16, 16 );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = 32;
    settings.threads = 1;
    settings.max_depth = 2;
    settings.light_samples = light_samples;
    double mean[SEED_COUNT];
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        settings.seed = (uint64_t)( k + 1 );
        AUTO_BY( free_rendered ) Rendered r = render_all( tracer, &eye, 1, &settings );
        mean[k] = 0.0;
        for ( size_t i = 0; i < r.pixels; ++i )
            mean[k] += (double)r.rgb[3 * i] / (double)r.pixels;
    }
    double exact = (double)( RADIANCE * albedo ) / (double)RF_PI * polygon_irradiance( p, 4, receiver->normal );
    double error, value = mean_of( mean, SEED_COUNT, &error );
    bool lit = facing || two_sided;
    printf( "%-13s %s %s, %d light samples: %.6f, closed form %.6f, %.2f SE (SE %.2g)\n", receiver->name,
            facing ? "front" : "back ", two_sided ? "two-sided" : "one-sided", light_samples, value, lit ? exact : 0.0,
            lit ? ( value - exact ) / error : 0.0, error );
    if ( lit )
        assert_true( error < 0.002 * exact && !is_far_off( ( value - exact ) / error, SEED_COUNT - 1 ) );
    else
        assert_true( value == 0.0 );
}

TEST( test_square_light_is_lambert_s_formula )
{
    for ( int k = 0; k < 2; ++k )
    {
        for ( int facing = 0; facing < 2; ++facing )
        {
            check_square( receivers + k, facing != 0, false, 1 );
            check_square( receivers + k, facing != 0, true, 1 );
            check_square( receivers + k, facing != 0, facing == 0, 4 );
        }
    }
}
