// Scattering models agree with themselves: samples follow the density (χ² over the
// sphere), sampled albedo equals albedo by quadrature, and no model gains energy.
#include "support/bsdf_lanes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdbool.h>
#include <string.h>

#include <cmocka.h>

#ifdef REFRAME_SANITIZED
#define SAMPLES 20000
#define SUB 12
#define FURNACE_SIDE 48
#else
#define SAMPLES 300000
#define SUB 40
#define FURNACE_SIDE 160
#endif

static const double s_pi = 3.14159265358979323846;

// ---- χ² and albedo ----------------------------------------------------------

#define T_BINS 24
#define PHI_BINS 32
#define BINS ( T_BINS * PHI_BINS + 1 ) // the last: below the surface

// Bins over t and v in [0, 1), of equal probability nowhere but fine where the
// lobe is. About the mirror direction: 1 − cos θ = 2 t^k and φ = 2πv; for sharp
// lobes. About the normal, upper hemisphere only, φ from the mirror azimuth:
// cos θ = (1 − t)^k and φ = π (2v − 1)^p; for wide lobes and for grazing eyes,
// whose lobes are much narrower in φ than in θ.
typedef struct Grid
{
    RfVec3 axis, t, b;
    double k, p;
    bool about_normal;
} Grid;

typedef struct Tally
{
    double expected[BINS]; // probability
    double observed[BINS]; // samples
    double quadrature_albedo, albedo, albedo_error;
} Tally;

static Grid make_grid( const Material* m, RfVec3 n, RfVec3 wo )
{
    bool is_phong = m->kind == RF_BSDF_PHONG, is_ggx = m->kind == RF_BSDF_GGX || m->kind == RF_BSDF_COATED;
    double lobe = is_phong ? 2.0 / ( m->shape + 1.0 ) : is_ggx ? 2.0 * (double)m->shape * m->shape : 2.0;
    double cos_o = (double)rf_dot( n, wo );
    RfVec3 across = rf_madd( wo, n, -rf_dot( n, wo ) );
    Grid grid = { .axis = n, .k = 1.0, .p = 1.0 };
    grid.about_normal = lobe > 0.015 || cos_o < 0.1;
    if ( !grid.about_normal )
    {
        grid.axis = rf_normalize( rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo ) );
        grid.k = log2( 2.0 / lobe );
        rf_basis( grid.axis, &grid.t, &grid.b );
        return grid;
    }
    rf_basis( n, &grid.t, &grid.b );
    if ( cos_o < 0.1 )
    {
        double width = sqrt( lobe ) * ( is_ggx ? fmax( cos_o, sqrt( lobe ) ) : 1.0 );
        grid.k = 3.0;
        grid.p = fmin( fmax( log( width / 3.14 ) / log( 0.3 ), 1.0 ), 9.0 );
        grid.t = rf_normalize( rf_scale( across, -1.0f ) );
        grid.b = rf_cross( n, grid.t );
    }
    return grid;
}

// cos θ, 1 − cos θ and the length of dω/dt at t; φ and dφ/dv at v.
static void warp_t( const Grid* grid, double t, double* cos_theta, double* one_minus, double* slope )
{
    double k = grid->k;
    *slope = grid->about_normal ? k * pow( 1.0 - t, k - 1.0 ) : 2.0 * k * pow( t, k - 1.0 );
    *one_minus = grid->about_normal ? 1.0 - pow( 1.0 - t, k ) : 2.0 * pow( t, k );
    *cos_theta = grid->about_normal ? pow( 1.0 - t, k ) : 1.0 - *one_minus;
}

static void warp_v( const Grid* grid, double v, double* phi, double* slope )
{
    double x = 2.0 * v - 1.0;
    *phi = s_pi * copysign( pow( fabs( x ), grid->p ), x );
    *slope = 2.0 * s_pi * grid->p * pow( fabs( x ), grid->p - 1.0 );
}

static int find_bin( const Grid* grid, RfVec3 w )
{
    RfVec3 chord = rf_sub( w, grid->axis );
    double t = grid->about_normal ? 1.0 - pow( fmax( (double)rf_dot( w, grid->axis ), 0.0 ), 1.0 / grid->k )
                                  : pow( 0.25 * (double)rf_dot( chord, chord ), 1.0 / grid->k );
    double x = atan2( (double)rf_dot( w, grid->b ), (double)rf_dot( w, grid->t ) ) / s_pi;
    double v = 0.5 + 0.5 * copysign( pow( fabs( x ), 1.0 / grid->p ), x );
    int row = (int)fmin( fmax( t, 0.0 ) * T_BINS, T_BINS - 1 );
    return row * PHI_BINS + (int)fmin( v * PHI_BINS, PHI_BINS - 1 );
}

// Adds one row of the quadrature: all directions of one t.
static void integrate_row( const Material* m, const Grid* grid, RfVec3 n, int row, Tally* tally )
{
    enum
    {
        COLUMNS = PHI_BINS * SUB,
        ROWS = T_BINS * SUB
    };
    static double sines[COLUMNS], cosines[COLUMNS], slopes[COLUMNS];
    for ( int c = 0; row == 0 && c < COLUMNS; ++c )
    {
        double phi;
        warp_v( grid, ( c + 0.5 ) / COLUMNS, &phi, slopes + c );
        sines[c] = sin( phi );
        cosines[c] = cos( phi );
    }
    double d, cos_theta, slope;
    warp_t( grid, ( row + 0.5 ) / ROWS, &cos_theta, &d, &slope );
    double s = sqrt( d * ( 1.0 + cos_theta ) );
    for ( int first = 0; first < COLUMNS; first += BATCH )
    {
        int count = COLUMNS - first < BATCH ? COLUMNS - first : BATCH;
        for ( int i = 0; i < count; ++i )
        {
            RfVec3 w = rf_scale( grid->t, (float)( s * cosines[first + i] ) );
            w = rf_madd( w, grid->b, (float)( s * sines[first + i] ) );
            put( WI, i, rf_madd( w, grid->axis, (float)cos_theta ) );
        }
        evaluate_range( m->kind, 0, count );
        for ( int i = 0; i < count; ++i )
        {
            double solid_angle = slope / ROWS * slopes[first + i] / COLUMNS;
            tally->expected[row / SUB * PHI_BINS + ( first + i ) / SUB] += solid_angle * s_lanes[PDF][i];
            double cos_i = fmax( (double)rf_dot( n, get( WI, i ) ), 0.0 );
            tally->quadrature_albedo += solid_angle * cos_i * s_lanes[F + 1][i];
        }
    }
}

static void draw_samples( const Material* m, const Grid* grid, RfVec3 n, uint32_t stream, Tally* tally )
{
    double sum = 0.0, squares = 0.0;
    for ( int first = 0; first < SAMPLES; first += BATCH )
    {
        for ( int i = 0; i < BATCH; ++i )
        {
            for ( int k = 0; k < 3; ++k )
                s_lanes[U + k][i] = uniform( stream, first + i, (uint32_t)k );
        }
        sample_range( m->kind, 0, BATCH );
        evaluate_range( m->kind, 0, BATCH );
        for ( int i = 0; i < BATCH; ++i )
        {
            RfVec3 w = get( WI, i );
            float cos_i = rf_dot( n, w );
            tally->observed[cos_i > 0.0f ? find_bin( grid, w ) : BINS - 1] += 1.0;
            if ( cos_i <= 0.0f )
                continue;
            assert_true( s_lanes[PDF][i] > 0.0f );
            double weight = (double)s_lanes[F + 1][i] * cos_i / s_lanes[PDF][i];
            sum += weight;
            squares += weight * weight;
        }
    }
    tally->albedo = sum / SAMPLES;
    tally->albedo_error = sqrt( fmax( squares / SAMPLES - tally->albedo * tally->albedo, 0.0 ) / SAMPLES );
}

// The chance of a χ² this large or larger (Wilson, Hilferty 1931).
static double chi_squared_tail( double statistic, int freedom )
{
    double v = 2.0 / ( 9.0 * freedom );
    return 0.5 * erfc( ( cbrt( statistic / freedom ) - 1.0 + v ) / sqrt( 2.0 * v ) );
}

static double chi_squared_chance( const Tally* tally )
{
    double statistic = 0.0, pool_expected = 0.0, pool_observed = 0.0;
    int cells = 0;
    for ( int i = 0; i < BINS; ++i )
    {
        pool_expected += SAMPLES * tally->expected[i];
        pool_observed += tally->observed[i];
        if ( pool_expected < 5.0 )
            continue;
        statistic += ( pool_observed - pool_expected ) * ( pool_observed - pool_expected ) / pool_expected;
        pool_expected = pool_observed = 0.0;
        ++cells;
    }
    // What is left over counts as one more, small cell.
    statistic += ( pool_observed - pool_expected ) * ( pool_observed - pool_expected ) / ( pool_expected + 1.0 );
    return chi_squared_tail( statistic, cells - 1 );
}

static bool sampling_agrees( const Material* m, float cos_o, uint32_t stream, double significance )
{
    static Tally tally;
    memset( &tally, 0, sizeof( tally ) );
    RfVec3 n = uniform_direction( stream, 0, 30 );
    RfVec3 wo = view_direction( n, cos_o );
    Grid grid = make_grid( m, n, wo );
    put_surface( m, n, wo );
    for ( int row = 0; row < T_BINS * SUB; ++row )
        integrate_row( m, &grid, n, row, &tally );
    double total = 0.0;
    for ( int i = 0; i < BINS - 1; ++i )
        total += tally.expected[i];
    tally.expected[BINS - 1] = fmax( 1.0 - total, 0.0 );
    draw_samples( m, &grid, n, stream, &tally );

    double chance = chi_squared_chance( &tally );
    double gap = fabs( tally.albedo - tally.quadrature_albedo );
    bool passed = chance > significance && total < 1.0 + 1e-3 && gap <= 4.5 * tally.albedo_error + 1e-3 * tally.quadrature_albedo;
    if ( !passed )
        print_message( "kind %d shape %g diffuse %g specular %g cos %g: p %.3g, pdf integral %.6f, below %.0f, "
                       "albedo %.6f +- %.6f by sampling, %.6f by quadrature\n",
                       m->kind, m->shape, m->diffuse.y, m->specular.y, cos_o, chance, total, tally.observed[BINS - 1],
                       tally.albedo, tally.albedo_error, tally.quadrature_albedo );
    return passed;
}

static void check_sampling( const Material* materials, int count )
{
    const float cosines[] = { 1.0f, 0.7f, 0.2f, 0.02f, -0.3f };
    // Šidák: 0.01 for all cases of all models together.
    double significance = 1.0 - pow( 0.99, 1.0 / 89.0 );
    int failed = 0;
    for ( int i = 0; i < count; ++i )
    {
        // Not the sharpest GGX from the horizon: that lobe is 2 μ α = 2e-6 wide, and
        // the 6e-8 between the floats of a direction show up as some percent of
        // the density, in whatever way it is computed.
        bool is_beyond_float = materials[i].kind == RF_BSDF_GGX && materials[i].shape == RF_MIN_ALPHA;
        for ( int k = 0; k < ( is_beyond_float ? 4 : 5 ); ++k )
        {
            uint32_t stream = 100u * (uint32_t)materials[i].kind + 10u * (uint32_t)( i + 10 ) + (uint32_t)k;
            failed += !sampling_agrees( materials + i, cosines[k], stream, significance );
        }
    }
    assert_int_equal( failed, 0 );
}

static void test_lambert_samples_follow_density( void** state )
{
    (void)state;
    const Material m = { RF_BSDF_LAMBERT, { 0.3f, 0.5f, 0.7f }, { 0, 0, 0 }, 0, 0, 0, 0, 0, 0 };
    check_sampling( &m, 1 );
}

static void test_phong_samples_follow_density( void** state )
{
    (void)state;
    const Material m[] = { { RF_BSDF_PHONG, { 0.2f, 0.5f, 0.7f }, { 0.1f, 0.2f, 0.3f }, 1.0f, 0, 0, 0, 0, 0 },
                           { RF_BSDF_PHONG, { 0, 0, 0 }, { 1, 1, 1 }, 0.0f, 0, 0, 0, 0, 0 },
                           { RF_BSDF_PHONG, { 0.3f, 0.3f, 0.3f }, { 0.6f, 0.6f, 0.6f }, 20.0f, 0, 0, 0, 0, 0 },
                           { RF_BSDF_PHONG, { 0, 0, 0 }, { 0.9f, 0.9f, 0.9f }, 200.0f, 0, 0, 0, 0, 0 },
                           { RF_BSDF_PHONG, { 0.2f, 0.2f, 0.2f }, { 0.7f, 0.7f, 0.7f }, 5000.0f, 0, 0, 0, 0, 0 },
                           { RF_BSDF_PHONG, { 0.1f, 0.1f, 0.1f }, { 0.8f, 0.8f, 0.8f }, 1e6f, 0, 0, 0, 0, 0 },
                           { RF_BSDF_PHONG, { 0, 0, 0 }, { 0, 0, 0 }, 10.0f, 0, 0, 0, 0, 0 } };
    check_sampling( m, 7 );
}

static void test_ggx_samples_follow_density( void** state )
{
    (void)state;
    const Material m[] = { { RF_BSDF_GGX, { 0.2f, 0.5f, 0.8f }, { 0.04f, 0.04f, 0.04f }, 1.0f, 1, 0.04f, 1, 0, 0 },
                           { RF_BSDF_GGX, { 0, 0, 0 }, { 1.0f, 0.8f, 0.3f }, 0.5f, 1, 0.04f, 1, 0, 0 },
                           { RF_BSDF_GGX, { 0.8f, 0.8f, 0.8f }, { 0.04f, 0.04f, 0.04f }, 0.1f, 1, 0.04f, 1, 0, 0 },
                           { RF_BSDF_GGX, { 0, 0, 0 }, { 0.9f, 0.9f, 0.9f }, 0.03f, 1, 0.04f, 1, 0, 0 },
                           { RF_BSDF_GGX, { 0.5f, 0.5f, 0.5f }, { 0.5f, 0.5f, 0.5f }, 0.01f, 1, 0.04f, 1, 0, 0 },
                           { RF_BSDF_GGX, { 0.8f, 0.8f, 0.8f }, { 0.17f, 0.17f, 0.17f }, RF_MIN_ALPHA, 1, 0.17f, 1, 0, 0 },
                           { RF_BSDF_GGX, { 0, 0, 0 }, { 0, 0, 0 }, 0.3f, 0, 0, 0, 0, 0 } };
    check_sampling( m, 7 );
}

// ---- Energy -----------------------------------------------------------------

// Directional albedo by stratified sampling, whose weights stay small at any
// roughness; that sampling and density agree is tested above.
static double furnace_albedo( const Material* m, float cos_o )
{
    RfVec3 n = uniform_direction( 5, 0, 0 );
    put_surface( m, n, view_direction( n, cos_o ) );
    const int side = FURNACE_SIDE, total = side * side;
    double sum = 0.0;
    for ( int first = 0; first < total; first += BATCH )
    {
        int count = total - first < BATCH ? total - first : BATCH;
        for ( int i = 0; i < count; ++i )
        {
            int k = first + i;
            double third = k * 0.6180339887498949; // the lobe: golden-ratio steps
            s_lanes[U][i] = ( (float)( k / side ) + uniform( 6, k, 0 ) ) / (float)side;
            s_lanes[U + 1][i] = ( (float)( k % side ) + uniform( 6, k, 1 ) ) / (float)side;
            s_lanes[U + 2][i] = rf_minf( (float)( third - floor( third ) ), 1.0f - 0x1p-24f );
            s_lanes[U][i] = rf_minf( s_lanes[U][i], 1.0f - 0x1p-24f );
        }
        sample_range( m->kind, 0, count );
        evaluate_range( m->kind, 0, count );
        for ( int i = 0; i < count; ++i )
        {
            if ( s_lanes[PDF][i] > 0.0f )
                sum += (double)s_lanes[F][i] * rf_dot( n, get( WI, i ) ) / s_lanes[PDF][i];
        }
    }
    return sum / total;
}

static const float s_furnace_cosines[] = { 1.0f, 0.9f, 0.7f, 0.5f, 0.3f, 0.1f, 0.03f, 0.003f };

static void check_furnace( const Material* m, double* least, double* most )
{
    for ( int k = 0; k < 8; ++k )
    {
        double albedo = furnace_albedo( m, s_furnace_cosines[k] );
        if ( !( albedo <= 1.005 ) )
            fail_msg( "albedo %.5f: kind %d shape %g diffuse %g specular %g coat %g cos %g", albedo, m->kind, m->shape,
                      m->diffuse.x, m->specular.x, m->coat_f0, s_furnace_cosines[k] );
        *least = fmin( *least, albedo );
        *most = fmax( *most, albedo );
    }
}

static void test_ggx_keeps_energy( void** state )
{
    (void)state;
    const float alphas[] = { RF_MIN_ALPHA, 0.01f, 0.05f, 0.1f, 0.2f, 0.4f, 0.7f, 1.0f };
    const float coats[] = { 0.0f, 0.04f, 0.17f }, metals[] = { 0.0f, 0.5f, 1.0f };
    for ( int j = 0; j < 9; ++j )
    {
        float coat = coats[j / 3], metallic = metals[j % 3];
        double least = 2.0, most = 0.0;
        for ( int i = 0; i < 8; ++i )
        {
            Material m = { RF_BSDF_GGX,
                           grey( 1.0f - metallic ),
                           grey( ( 1.0f - metallic ) * coat + metallic ),
                           alphas[i],
                           1.0f,
                           coat,
                           1.0f,
                           0,
                           0 };
            check_furnace( &m, &least, &most );
        }
        print_message( "GGX coat %.2f metallic %.1f: albedo %.4f to %.4f\n", coat, metallic, least, most );
    }
}

static void test_coated_samples_follow_density( void** state )
{
    (void)state;
    const Material m[] = { { RF_BSDF_COATED, { 0.2f, 0.5f, 0.8f }, { 0.04f, 0.04f, 0.04f }, 0.5f, 1, 0.04f, 1, 1.0f, 0.3f },
                           { RF_BSDF_COATED, { 0, 0, 0 }, { 0.9f, 0.7f, 0.3f }, 0.3f, 1, 0.04f, 1, 0.5f, 0.2f },
                           { RF_BSDF_COATED, { 0, 0, 0 }, { 0, 0, 0 }, 0.2f, 0, 0, 0, 1.0f, 0.2f } };
    check_sampling( m, 3 );
}

// Coats that lean away from what they cover.
static void test_leaning_coat_samples_follow_density( void** state )
{
    (void)state;
    const Material m[] = { { RF_BSDF_COATED, { 0.2f, 0.5f, 0.8f }, { 0.04f, 0.04f, 0.04f }, 0.5f, 1, 0.04f, 1, 1.0f, 0.3f },
                           { RF_BSDF_COATED, { 0, 0, 0 }, { 0.9f, 0.7f, 0.3f }, 0.3f, 1, 0.04f, 1, 0.5f, 0.2f } };
    s_coat_lean = rf_vec3( 0.4f, -0.1f, 0.2f );
    check_sampling( m, 2 );
    double least = 2.0, most = 0.0;
    for ( int k = 0; k < 3; ++k )
    {
        Material white = { RF_BSDF_COATED, grey( 1.0f ), grey( 0.04f ), 0.4f, 1.0f, 0.04f, 1.0f, 1.0f, 0.05f + 0.3f * (float)k };
        s_coat_lean = rf_vec3( 0.1f, 0.3f * (float)k, -0.2f );
        check_furnace( &white, &least, &most );
    }
    s_coat_lean = rf_vec3( 0, 0, 0 );
    print_message( "leaning coat: albedo %.4f to %.4f\n", least, most );
}

static void test_coats_keep_energy( void** state )
{
    (void)state;
    const float alphas[] = { RF_MIN_ALPHA, 0.05f, 0.2f, 1.0f };
    for ( int j = 0; j < 4; ++j )
    {
        double least = 2.0, most = 0.0;
        for ( int i = 0; i < 4; ++i )
        {
            Material m = { RF_BSDF_COATED,
                           grey( j < 2 ? 1.0f : 0.0f ),
                           grey( j < 2 ? 0.04f : 1.0f ),
                           alphas[i],
                           1.0f,
                           0.04f,
                           1.0f,
                           j % 2 == 0 ? 1.0f : 0.5f,
                           alphas[3 - i] };
            check_furnace( &m, &least, &most );
        }
        print_message( "coated %s, clearcoat %g: albedo %.4f to %.4f\n", j < 2 ? "plastic" : "metal", j % 2 == 0 ? 1.0 : 0.5,
                       least, most );
    }
}

static void test_phong_keeps_energy( void** state )
{
    (void)state;
    const float exponents[] = { 0.0f, 1.0f, 5.0f, 50.0f, 1000.0f, 1e6f };
    for ( int j = 0; j < 3; ++j )
    {
        float kd = 0.5f * (float)j;
        double least = 2.0, most = 0.0;
        for ( int i = 0; i < 6; ++i )
        {
            Material m = { RF_BSDF_PHONG, grey( kd ), grey( 1.0f - kd ), exponents[i], 0, 0, 0, 0, 0 };
            check_furnace( &m, &least, &most );
        }
        print_message( "Phong kd %.1f: albedo %.4f to %.4f\n", kd, least, most );
    }
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_lambert_samples_follow_density ),      cmocka_unit_test( test_phong_samples_follow_density ),
        cmocka_unit_test( test_ggx_samples_follow_density ),          cmocka_unit_test( test_ggx_keeps_energy ),
        cmocka_unit_test( test_coated_samples_follow_density ),       cmocka_unit_test( test_coats_keep_energy ),
        cmocka_unit_test( test_leaning_coat_samples_follow_density ), cmocka_unit_test( test_phong_keeps_energy ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
