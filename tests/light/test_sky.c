// The environment as a light: densities, directions, look-ups; and pictures under
// environments and punctual lights whose radiance has a closed form.
#include "light/sky.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/select_light.h"
#include "support/statistics.h"
#include "support/test.h"

#include "base/random.h"

#define WIDTH 12
#define HEIGHT 6

static float s_map[3 * WIDTH * HEIGHT];

static RfEnvironment make_environment( float rotation )
{
    for ( int i = 0; i < 3 * WIDTH * HEIGHT; ++i )
        s_map[i] = i / 3 % 5 == 0 ? 0.0f : (float)( i * i % 23 ) + ( i / 3 == 40 ? 500.0f : 0.0f );
    for ( int i = 0; i < 3 * WIDTH; ++i )
        s_map[3 * WIDTH * 3 + i] = 0.0f; // a black row, lit by its neighbours alone
    return ( RfEnvironment ){
        .radiance = rf_vec3( 1.0f, 2.0f, 0.5f ), .width = WIDTH, .height = HEIGHT, .map = s_map, .rotation = rotation
    };
}

static RfSky make_sky( const RfEnvironment* e )
{
    RfSky sky;
    RfError error;
    assert_int_equal( rf_make_sky( e, &sky, &error ), RF_OK );
    assert_non_null( sky.environment );
    return sky;
}

static float uniform( uint32_t i, uint32_t dimension ) { return rf_random( rf_pixel_key( 99, i ), dimension ); }
static uint32_t bits( uint32_t i, uint32_t dimension ) { return rf_random_bits( rf_pixel_key( 99, i ), dimension ); }

static RfVec3 sphere_direction( float u, float v )
{
    float z = 1.0f - 2.0f * u, r = sqrtf( 1.0f - z * z );
    return rf_vec3( r * cosf( 2.0f * RF_PI * v ), z, r * sinf( 2.0f * RF_PI * v ) );
}

TEST( test_middle_of_the_map )
{
    RfEnvironment e = make_environment( 0.0f );
    e.radiance = rf_vec3( 1, 1, 1 );
    RfSky sky = make_sky( &e );
    // between columns 5 and 6, rows 2 and 3: −z
    const float* m = s_map;
    for ( int c = 0; c < 1; ++c )
    {
        float expected =
            0.25f * ( m[3 * ( 2 * WIDTH + 5 )] + m[3 * ( 2 * WIDTH + 6 )] + m[3 * ( 3 * WIDTH + 5 )] + m[3 * ( 3 * WIDTH + 6 )] );
        assert_true( expected > 0.0f );
        assert_true( fabsf( rf_sky_radiance( &sky, rf_vec3( 0, 0, -1 ) ).x - expected ) < 1e-3f * expected );
    }
    // +x lies a quarter to the right: between columns 8 and 9
    float right =
        0.25f * ( m[3 * ( 2 * WIDTH + 8 )] + m[3 * ( 2 * WIDTH + 9 )] + m[3 * ( 3 * WIDTH + 8 )] + m[3 * ( 3 * WIDTH + 9 )] );
    assert_true( fabsf( rf_sky_radiance( &sky, rf_vec3( 1, 0, 0 ) ).x - right ) < 1e-3f * right );
    rf_destroy_sky( &sky );
    // turned a quarter counter-clockwise, what was in −z lies in −x
    RfEnvironment turned = make_environment( 0.5f * RF_PI );
    turned.radiance = rf_vec3( 1, 1, 1 );
    AUTO_BY( rf_destroy_sky ) RfSky other = make_sky( &turned );
    sky = make_sky( &e );
    for ( uint32_t i = 0; i < 100; ++i )
    {
        RfVec3 d = sphere_direction( uniform( i, 0 ), uniform( i, 1 ) );
        float a = rf_sky_radiance( &sky, d ).x, b = rf_sky_radiance( &other, rf_vec3( d.z, d.y, -d.x ) ).x;
        assert_true( fabsf( a - b ) < 1e-3f * ( 1.0f + a ) );
    }
    rf_destroy_sky( &sky );
}

// ∫ p = 1, p > 0 wherever there is light, and E[L / p] = ∫ L by uniform directions.
TEST( test_density_integrates_to_one )
{
    enum
    {
        COUNT = 400000
    };
    RfEnvironment e = make_environment( 0.4f );
    AUTO_BY( rf_destroy_sky ) RfSky sky = make_sky( &e );
    double sum_p = 0.0, light = 0.0;
    for ( uint32_t i = 0; i < COUNT; ++i )
    {
        RfVec3 d =
            sphere_direction( ( (float)( i / 1000 ) + 0.5f ) / 400.0f, ( (float)( i % 1000 ) + uniform( i, 2 ) ) / 1000.0f );
        float p = rf_sky_pdf_solid_angle( &sky, d ), l = rf_luminance( rf_sky_radiance( &sky, d ) );
        assert_true( p > 0.0f || l == 0.0f );
        sum_p += (double)p;
        light += (double)l;
    }
    double sphere = 4.0 * 3.14159265358979324;
    assert_true( fabs( sum_p * sphere / COUNT - 1.0 ) < 5e-3 );
    light *= sphere / COUNT;
    assert_true( fabs( (double)sky.mean_luminance * sphere / light - 1.0 ) < 5e-3 );
    double sum = 0.0, sum2 = 0.0;
    for ( uint32_t i = 0; i < 40000; ++i )
    {
        uint32_t pick[2] = { bits( i, 0 ), bits( i, 1 ) };
        float place[2] = { uniform( i, 2 ), uniform( i, 3 ) };
        RfSkySample s = rf_sample_sky( &sky, pick, place );
        assert_true( fabsf( rf_length( s.wi ) - 1.0f ) < 1e-5f );
        assert_true( s.pdf_solid_angle > 0.0f );
        assert_true( fabsf( rf_sky_pdf_solid_angle( &sky, s.wi ) / s.pdf_solid_angle - 1.0f ) < 1e-4f );
        double value = (double)( rf_luminance( s.radiance ) / s.pdf_solid_angle );
        sum += value;
        sum2 += value * value;
    }
    double mean = sum / 40000, error = sqrt( ( sum2 / 40000 - mean * mean ) / 40000 );
    assert_true( fabs( mean - light ) < 4.0 * error + 5e-3 * light );
    assert_true( error < 0.01 * light ); // in proportion to the light: little noise
}

// Directions fall into the map's pixels as the density says.
TEST( test_directions_follow_the_density )
{
    enum
    {
        COUNT = 200000
    };
    RfEnvironment e = make_environment( 0.0f );
    AUTO_BY( rf_destroy_sky ) RfSky sky = make_sky( &e );
    static double seen[WIDTH * HEIGHT], expected[WIDTH * HEIGHT];
    for ( uint32_t i = 0; i < COUNT; ++i )
    {
        uint32_t pick[2] = { bits( i, 4 ), bits( i, 5 ) };
        float place[2] = { uniform( i, 6 ), uniform( i, 7 ) };
        RfVec3 d = rf_sample_sky( &sky, pick, place ).wi;
        int x = (int)( ( atan2f( d.x, -d.z ) / ( 2.0f * RF_PI ) + 0.5f ) * WIDTH ), y = (int)( acosf( d.y ) / RF_PI * HEIGHT );
        seen[( y < HEIGHT ? y : HEIGHT - 1 ) * WIDTH + ( x < WIDTH ? x : WIDTH - 1 )] += 1.0;
    }
    double chi_square = 0.0;
    int cells = 0;
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        double top = cos( i / WIDTH * 3.14159265358979324 / HEIGHT ),
               bottom = cos( ( i / WIDTH + 1 ) * 3.14159265358979324 / HEIGHT );
        RfVec3 middle = rf_vec3( 0, 0, 0 );
        double azimuth = ( i % WIDTH + 0.5 ) / WIDTH * 2.0 * 3.14159265358979324 - 3.14159265358979324,
               z = 0.5 * ( top + bottom );
        middle =
            rf_vec3( (float)( sqrt( 1 - z * z ) * sin( azimuth ) ), (float)z, (float)( -sqrt( 1 - z * z ) * cos( azimuth ) ) );
        expected[i] =
            (double)rf_sky_pdf_solid_angle( &sky, middle ) * ( top - bottom ) * 2.0 * 3.14159265358979324 / WIDTH * COUNT;
        if ( expected[i] < 5.0 )
            continue;
        chi_square += ( seen[i] - expected[i] ) * ( seen[i] - expected[i] ) / expected[i];
        ++cells;
    }
    assert_true( cells > WIDTH * HEIGHT / 2 );
    assert_true( chi_square_p( chi_square, cells - 1 ) > 1e-4 );
}

// ---- Light samples of surfaces

enum
{
    NORMALS = 5,
    BANDS = 12,
    SECTORS = 24
};

static RfVec3 normal_of( int k )
{
    static const float s_normals[NORMALS][3] = { { 0, 1, 0 }, { 0, -1, 0 }, { 1, 0, 0 }, { 0.6f, 0.0f, -0.8f }, { -2, 1, 3 } };
    return rf_normalize( rf_vec3( s_normals[k][0], s_normals[k][1], s_normals[k][2] ) );
}

// A sky that has turned since its tables were made.
static RfSky make_turned_sky( RfEnvironment* e )
{
    RfSky sky = make_sky( e );
    e->rotation += 1.1f;
    sky.cos_rotation = cosf( e->rotation );
    sky.sin_rotation = sinf( e->rotation );
    return sky;
}

// The density integrates to 1, and is above 0 wherever light arrives from; the irradiance, by the same directions.
static double check_density( const RfSky* sky, RfVec3 n )
{
    enum
    {
        ROWS = 600,
        COLUMNS = 1200
    };
    double sum = 0.0, irradiance = 0.0;
    for ( uint32_t i = 0; i < ROWS * COLUMNS; ++i )
    {
        RfVec3 d = sphere_direction( ( (float)( i / COLUMNS ) + uniform( i, 3 ) ) / ROWS,
                                     ( (float)( i % COLUMNS ) + uniform( i, 2 ) ) / COLUMNS );
        float p = rf_sky_pdf_solid_angle_at( sky, n, d );
        float light = rf_luminance( rf_sky_radiance( sky, d ) ) * rf_maxf( rf_dot( n, d ), 0.0f );
        assert_true( p > 0.0f || light <= 0.0f );
        sum += (double)p;
        irradiance += (double)light;
    }
    double area = 4.0 * 3.14159265358979324 / ( ROWS * COLUMNS );
    if ( fabs( sum * area - 1.0 ) > 4e-3 )
        fail_msg( "the density integrates to %g", sum * area );
    return irradiance * area;
}

// Directions fall into bands and sectors about +y as the density says, which is that of the sample; their mean is the irradiance.
static void check_samples( const RfSky* sky, RfVec3 n, double irradiance )
{
    enum
    {
        COUNT = 200000,
        POINTS = 4000 // of each bin
    };
    static double seen[BANDS * SECTORS];
    memset( seen, 0, sizeof seen );
    double sum = 0.0, sum2 = 0.0;
    int off = 0;
    for ( uint32_t i = 0; i < COUNT; ++i )
    {
        uint32_t pick[2] = { bits( i, 4 ), bits( i, 5 ) };
        float place[2] = { uniform( i, 6 ), uniform( i, 7 ) };
        RfSkySample s = sample_sky_direction_at( sky, n, pick, place );
        assert_true( fabsf( rf_length( s.wi ) - 1.0f ) < 1e-5f && s.pdf_solid_angle > 0.0f );
        off += !( fabsf( rf_sky_pdf_solid_angle_at( sky, n, s.wi ) / s.pdf_solid_angle - 1.0f ) < 1e-4f );
        double value =
            (double)( rf_luminance( rf_sky_radiance( sky, s.wi ) ) * rf_maxf( rf_dot( n, s.wi ), 0.0f ) / s.pdf_solid_angle );
        sum += value;
        sum2 += value * value;
        int band = (int)( ( 0.5f - 0.5f * s.wi.y ) * BANDS ),
            sector = (int)( ( atan2f( s.wi.z, s.wi.x ) / RF_PI + 1.0f ) / 2 * SECTORS );
        seen[( band < BANDS ? band : BANDS - 1 ) * SECTORS + ( sector < SECTORS ? sector : SECTORS - 1 )] += 1.0;
    }
    assert_true( off < COUNT / 2000 ); // at borders of pixels alone
    double mean = sum / COUNT, error = sqrt( ( sum2 / COUNT - mean * mean ) / COUNT );
    if ( fabs( mean - irradiance ) > 4.0 * error + 3e-3 * irradiance )
        fail_msg( "irradiance %g (SE %g), not %g", mean, error, irradiance );
    double chi_square = 0.0;
    int bins = 0;
    for ( int i = 0; i < BANDS * SECTORS; ++i )
    {
        double expected = 0.0;
        for ( uint32_t k = 0; k < POINTS; ++k )
        {
            uint32_t at = (uint32_t)i * POINTS + k;
            float azimuth = 2.0f * RF_PI * ( ( (float)( i % SECTORS ) + uniform( at, 8 ) ) / SECTORS - 0.5f );
            float y = 1.0f - 2.0f * ( (float)( i / SECTORS ) + ( (float)k + 0.5f ) / POINTS ) / BANDS, r = sqrtf( 1.0f - y * y );
            expected += (double)rf_sky_pdf_solid_angle_at( sky, n, rf_vec3( r * cosf( azimuth ), y, r * sinf( azimuth ) ) );
        }
        expected *= 4.0 * 3.14159265358979324 / ( BANDS * SECTORS ) / POINTS * COUNT;
        assert_true( expected > 0.0 || seen[i] == 0.0 );
        if ( expected < 5.0 )
            continue;
        chi_square += ( seen[i] - expected ) * ( seen[i] - expected ) / ( expected + expected * expected * 1e-4 );
        ++bins;
    }
    assert_true( bins > 5 && chi_square_p( chi_square, bins - 1 ) > 1e-4 );
}

TEST( test_surfaces_sample_what_lights_them )
{
    for ( int turned = 0; turned < 3; ++turned )
    {
        RfEnvironment e = make_environment( 0.3f );
        RfSky sky = turned == 1 ? make_turned_sky( &e ) : make_sky( &e );
        if ( turned == 2 )
        {
            rf_destroy_sky( &sky );
            e = ( RfEnvironment ){ .radiance = rf_vec3( 1, 2, 3 ) };
            sky = make_sky( &e );
        }
        for ( int k = 0; k < NORMALS; ++k )
            check_samples( &sky, normal_of( k ), check_density( &sky, normal_of( k ) ) );
        rf_destroy_sky( &sky );
    }
}

// Cells of many pixels, of which some at the border are not on the map, and a sun that is 10⁷ times as bright as what is around it.
TEST( test_cells_of_many_pixels )
{
    enum
    {
        ACROSS = 150,
        DOWN = 70
    };
    static float map[3 * ACROSS * DOWN];
    for ( int i = 0; i < ACROSS * DOWN; ++i )
    {
        float light = i / ACROSS > 50 ? 0.0f : 0.5f + uniform( (uint32_t)i, 1 );
        for ( int c = 0; c < 3; ++c )
            map[3 * i + c] = i == 20 * ACROSS + 77 ? 1e7f : light;
    }
    RfEnvironment e = { .radiance = rf_vec3( 1, 1, 1 ), .width = ACROSS, .height = DOWN, .map = map };
    AUTO_BY( rf_destroy_sky ) RfSky sky = make_sky( &e );
    assert_true( sky.column_bits > 0 && sky.row_bits > 0 );
    for ( int k = 0; k < NORMALS; ++k )
    {
        RfVec3 n = normal_of( k );
        double sum = 0.0;
        for ( uint32_t i = 0; i < 40 * ACROSS * DOWN; ++i ) // 40 in each pixel, one below the other
        {
            int pixel = (int)( i / 40 ), y = pixel / ACROSS;
            double top = cos( y * 3.14159265358979324 / DOWN ), bottom = cos( ( y + 1 ) * 3.14159265358979324 / DOWN );
            float up = (float)( top + ( i % 40 + 0.5 ) / 40.0 * ( bottom - top ) ), across = sqrtf( 1.0f - up * up );
            float azimuth = 2.0f * RF_PI * ( ( (float)( pixel % ACROSS ) + 0.5f ) / ACROSS - 0.5f );
            RfVec3 d = rf_vec3( across * sinf( azimuth ), up, -across * cosf( azimuth ) );
            float p = rf_sky_pdf_solid_angle_at( &sky, n, d );
            assert_true( p > 0.0f || rf_dot( n, d ) <= 0.0f || rf_luminance( rf_sky_radiance( &sky, d ) ) <= 0.0f );
            sum += (double)p * ( top - bottom ) * 2.0 * 3.14159265358979324 / ACROSS / 40.0;
        }
        if ( fabs( sum - 1.0 ) > 1e-3 )
            fail_msg( "normal %d: the density integrates to %g", k, sum );
        int off = 0;
        for ( uint32_t i = 0; i < 20000; ++i )
        {
            uint32_t pick[2] = { bits( i, 4 ), bits( i, 5 ) };
            float place[2] = { uniform( i, 6 ), uniform( i, 7 ) };
            RfSkySample s = sample_sky_direction_at( &sky, n, pick, place );
            off += !( fabsf( rf_sky_pdf_solid_angle_at( &sky, n, s.wi ) / s.pdf_solid_angle - 1.0f ) < 1e-4f );
        }
        assert_true( off < 40 );
    }
}

// Half of an even sky is below the horizon of a wall: no sample goes there.
TEST( test_no_sample_below_the_horizon )
{
    static float map[3 * 64 * 32];
    for ( int i = 0; i < 3 * 64 * 32; ++i )
        map[i] = 1.0f;
    RfEnvironment e = { .radiance = rf_vec3( 1, 1, 1 ), .width = 64, .height = 32, .map = map };
    AUTO_BY( rf_destroy_sky ) RfSky sky = make_sky( &e );
    for ( int k = 0; k < NORMALS; ++k )
    {
        int below = 0;
        for ( uint32_t i = 0; i < 10000; ++i )
        {
            uint32_t pick[2] = { bits( i, 4 ), bits( i, 5 ) };
            float place[2] = { uniform( i, 6 ), uniform( i, 7 ) };
            below += rf_dot( normal_of( k ), sample_sky_direction_at( &sky, normal_of( k ), pick, place ).wi ) <= 0.0f;
        }
        if ( below > ( k < 3 ? 200 : 2200 ) )
            fail_msg( "normal %d: %d of 10000 samples below the horizon", k, below );
    }
}

TEST( test_black_is_no_sky )
{
    RfEnvironment e = make_environment( 0.0f );
    for ( int i = 0; i < 3 * WIDTH * HEIGHT; ++i )
        s_map[i] = 0.0f;
    RfSky sky;
    RfError error;
    assert_int_equal( rf_make_sky( &e, &sky, &error ), RF_OK );
    assert_null( sky.environment );
    e = ( RfEnvironment ){ 0 };
    assert_int_equal( rf_make_sky( &e, &sky, &error ), RF_OK );
    assert_null( sky.environment );
}

static RfEye eye_above( float height, int width )
{
    return rf_make_eye( rf_vec3( 0, height, 0 ), rf_vec3( 0, -1, 0 ), rf_vec3( 0, 0, -1 ), 0.002, width, width );
}

static Rendered render_one( RfScene* scene, const RfEye* eye, int spp, int max_depth )
{
    AUTO_TRACER tracer = make_tracer( scene );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = spp;
    settings.max_depth = max_depth;
    int frame = 0;
    Rendered r = render_frames( tracer, eye, 1, &frame, 1, &settings );
    rf_destroy_scene( scene );
    return r;
}

static double mean_red( const Rendered* r )
{
    double sum = 0.0;
    for ( size_t i = 0; i < r->pixels; ++i )
        sum += (double)r->rgb[3 * i];
    return sum / (double)r->pixels;
}

static RfScene make_floor( void )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    add_quad( &b, grey, rf_vec3( -1, 0, 1 ), rf_vec3( 1, 0, 1 ), rf_vec3( 1, 0, -1 ), rf_vec3( -1, 0, -1 ) );
    return finish_scene( &b );
}

// albedo/π times the irradiance, without noise.
static void check_lamp( RfPunctual lamp, double irradiance )
{
    RfScene scene = make_floor();
    scene.punctuals = malloc( sizeof lamp );
    scene.punctuals[0] = lamp;
    scene.punctual_count = 1;
    RfEye eye = eye_above( 1.0f, 4 );
    AUTO_BY( free_rendered ) Rendered r = render_one( &scene, &eye, 4, 12 );
    double expected = 0.5 / 3.14159265358979324 * irradiance;
    if ( fabs( mean_red( &r ) - expected ) > 2e-3 * expected )
        fail_msg( "irradiance %g: radiance %g, not %g", irradiance, mean_red( &r ), expected );
}

TEST( test_lamps_by_closed_form )
{
    RfPunctual lamp = make_point_light( rf_vec3( 0, 2, 0 ), 8.0f );
    check_lamp( lamp, 8.0 / 4.0 );
    lamp.position = rf_vec3( 3, 4, 0 ); // 5 away, cosine 0.8
    check_lamp( lamp, 8.0 / 25.0 * 0.8 );
    lamp.range = 10.0f;
    check_lamp( lamp, 8.0 / 25.0 * 0.8 * ( 1.0 - 1.0 / 16.0 ) );
    lamp.range = 4.0f;
    check_lamp( lamp, 0.0 );
    lamp = make_point_light( rf_vec3( 0, 2, 0 ), 8.0f );
    lamp.kind = RF_PUNCTUAL_SPOT;
    lamp.cos_inner = 0.9f;
    lamp.cos_outer = 0.8f;
    check_lamp( lamp, 2.0 );
    lamp.direction = rf_normalize( rf_vec3( sqrtf( 1.0f - 0.85f * 0.85f ), -0.85f, 0 ) ); // half way in: a quarter
    check_lamp( lamp, 0.5 );
    lamp.direction = rf_vec3( 1, 0, 0 );
    check_lamp( lamp, 0.0 );
    lamp = make_point_light( rf_vec3( 0, 0, 0 ), 3.0f );
    lamp.kind = RF_PUNCTUAL_DIRECTIONAL;
    check_lamp( lamp, 3.0 );
    lamp.direction = rf_vec3( 0.8f, -0.6f, 0 );
    check_lamp( lamp, 1.8 );
    lamp.direction = rf_vec3( 0, 1, 0 ); // from below
    check_lamp( lamp, 0.0 );
}

TEST( test_floor_under_a_sky )
{
    RfScene scene = make_floor();
    scene.environment.radiance = rf_vec3( 2, 2, 2 );
    RfEye eye = eye_above( 1.0f, 16 );
    AUTO_BY( free_rendered ) Rendered r = render_one( &scene, &eye, 64, 12 );
    assert_true( fabs( mean_red( &r ) - 0.5 * 2.0 ) < 5e-3 );
}

// Whatever takes nothing from the light is invisible in front of an even sky.
static void check_invisible( RfMaterial material, double low, double high )
{
    SceneBuilder b = { 0 };
    uint32_t m = add_material( &b, material );
    add_sphere( &b, m, rf_vec3( 0, 0, 0 ), 0.5f, 24 );
    RfScene scene = finish_scene( &b );
    scene.environment.radiance = rf_vec3( 1, 1, 1 );
    RfEye eye = rf_make_eye( rf_vec3( 0, 0, 3 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.2, 24, 24 );
    AUTO_BY( free_rendered ) Rendered r = render_one( &scene, &eye, 64, 64 );
    double mean = mean_red( &r );
    assert_true( mean > low && mean < high );
}

TEST( test_lossless_things_are_invisible )
{
    RfMaterial mirror = make_mirror( 1.0f );
    check_invisible( mirror, 1.0 - 1e-3, 1.0 + 1e-5 );
    check_invisible( make_glass( 1.5f, 0.0f, true ), 1.0 - 1e-3, 1.0 + 1e-5 );
    check_invisible( make_glass( 1.5f, 0.0f, false ), 1.0 - 2e-2, 1.0 + 1e-3 );
    check_invisible( make_glass( 1.5f, 0.3f, false ), 0.9, 1.0 ); // one bounce off facets only
    RfMaterial milky = make_glass( 1.5f, 0.0f, true );
    milky.tint = rf_vec3( 0.5f, 0.5f, 0.5f );
    milky.diffuse = rf_vec3( 0.5f, 0.5f, 0.5f );
    check_invisible( milky, 0.8, 1.0 );
}

// Within a body light is lost on its way to the eye.
TEST( test_eye_inside_of_glass )
{
    for ( int rough = 0; rough < 2; ++rough )
    {
        SceneBuilder b = { 0 };
        RfMaterial glass = make_glass( 1.0001f, rough ? 0.1f : 0.0f, false );
        glass.absorption = rf_vec3( 2.0f, 1.0f, 0.0f );
        add_box( &b, add_material( &b, glass ), rf_vec3( -0.5f, -0.5f, -0.5f ), rf_vec3( 0.5f, 0.5f, 0.5f ), false );
        RfScene scene = finish_scene( &b );
        scene.environment.radiance = rf_vec3( 1, 1, 1 );
        RfEye eye = rf_make_eye( rf_vec3( 0, 0, -0.25f ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.02, 16, 16 );
        AUTO_BY( free_rendered ) Rendered r = render_one( &scene, &eye, 16, 8 );
        double mean = mean_red( &r );
        assert_true( fabs( mean - exp( -0.5 ) ) < 2e-3 );
    }
}
