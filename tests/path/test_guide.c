// Guides: tables are densities, sampled as they say; what is learned leads to the light, differs from place to place and from wall to
// wall, and is nothing where there is nothing to learn.
#include "base/random.h"
#include "path/guide_learner.h"
#include "support/statistics.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static float draw( uint32_t number, uint32_t dimension )
{
    return rf_random( rf_pixel_key( rf_mix64( suite_seed() ), number ), dimension );
}

// Weights of very different sizes, some of them 0, and a row of zeros.
static void fill_table( RfGuideTable* table )
{
    *table = ( RfGuideTable ){ .share = 0.5f };
    for ( int k = 0; k < RF_GUIDE_BINS; ++k )
    {
        float u = draw( (uint32_t)k, 9 );
        table->density[k] = k / RF_GUIDE_SIDE == 7 || u < 0.3f ? 0.0f : expf( 8.0f * u );
    }
    rf_finish_guide_table( table );
}

// A unit direction, evenly drawn.
static RfVec3 draw_direction( uint32_t number )
{
    float z = 2.0f * draw( number, 0 ) - 1.0f, r = sqrtf( 1.0f - z * z ), phi = 2.0f * RF_PI * draw( number, 1 );
    return rf_vec3( r * cosf( phi ), r * sinf( phi ), z );
}

TEST( test_a_table_is_a_density )
{
    static RfGuideTable s_table;
    fill_table( &s_table );
    enum
    {
        DIRECTIONS = 1 << 20
    };
    double sum = 0.0, squares = 0.0;
    for ( uint32_t k = 0; k < DIRECTIONS; ++k )
    {
        double value = 4.0 * (double)RF_PI * (double)rf_guide_pdf_solid_angle( &s_table, draw_direction( k ) );
        sum += value;
        squares += value * value;
    }
    double mean = sum / DIRECTIONS, error = sqrt( ( squares / DIRECTIONS - mean * mean ) / DIRECTIONS );
    print_message( "integral %.5f +- %.5f\n", mean, error );
    assert_false( is_far_off( ( mean - 1.0 ) / error, DIRECTIONS - 1 ) );
    assert_true( error < 0.01 );
}

// The directions fall into each bin as often as the density there says, and evenly within: the factor from the square to solid
// angles is right where the mean of 1 / g is the solid angle of the bins that are not 0.
TEST( test_directions_are_drawn_by_the_density )
{
    static RfGuideTable s_table;
    static double s_count[RF_GUIDE_BINS];
    fill_table( &s_table );
    memset( s_count, 0, sizeof s_count );
    enum
    {
        DIRECTIONS = 1 << 20
    };
    double inverse = 0.0, area = 0.0;
    for ( uint32_t k = 0; k < DIRECTIONS; ++k )
    {
        RfVec3 d = rf_sample_guide( &s_table, draw( k, 2 ), draw( k, 3 ) );
        float per_solid_angle, pdf = rf_guide_pdf_solid_angle( &s_table, d );
        assert_true( fabsf( rf_dot( d, d ) - 1.0f ) < 1e-5f );
        s_count[rf_guide_bin( d, &per_solid_angle )] += 1.0;
        inverse += pdf > 0.0f ? 1.0 / (double)pdf : 0.0;
    }
    double chi_square = 0.0, bins = 0.0, few = 0.0;
    for ( int k = 0; k < RF_GUIDE_BINS; ++k )
    {
        double expected = 4.0 / RF_GUIDE_BINS * (double)s_table.density[k] * DIRECTIONS;
        few += s_table.density[k] > 0.0f ? 0.0 : s_count[k]; // rounding alone leads there
        if ( expected < 10.0 )
            continue;
        chi_square += ( s_count[k] - expected ) * ( s_count[k] - expected ) / expected;
        bins += 1.0;
    }
    for ( uint32_t k = 0; k < DIRECTIONS; ++k )
        area += rf_guide_pdf_solid_angle( &s_table, draw_direction( k ) ) > 0.0f ? 4.0 * (double)RF_PI / DIRECTIONS : 0.0;
    print_message( "%g bins, chi square p %.3g; solid angle %.4f, by samples %.4f; %g beside the table\n", bins,
                   chi_square_p( chi_square, bins - 1.0 ), area, inverse / DIRECTIONS, few );
    assert_true( is_likely( chi_square_p( chi_square, bins - 1.0 ) ) );
    assert_true( few < 1e-4 * DIRECTIONS );
    assert_true( fabs( inverse / DIRECTIONS - area ) < 0.02 * area );
}

TEST( test_extreme_numbers_give_directions )
{
    static RfGuideTable s_table;
    static const float numbers[] = { 0.0f, 0x1p-24f, 0.5f, 0x1.fffffep-1f };
    for ( int single = 0; single < RF_GUIDE_BINS; single += 93 )
    {
        memset( &s_table, 0, sizeof s_table );
        s_table.density[single] = 1e-20f;
        rf_finish_guide_table( &s_table );
        for ( int k = 0; k < 16; ++k )
        {
            RfVec3 d = rf_sample_guide( &s_table, numbers[k / 4], numbers[k % 4] );
            float per_solid_angle;
            int bin = rf_guide_bin( d, &per_solid_angle );
            assert_true( fabsf( rf_dot( d, d ) - 1.0f ) < 1e-5f );
            bool inside = k / 4 > 0 && k / 4 < 3 && k % 4 > 0 && k % 4 < 3; // at borders rounding decides
            assert_true( bin == single || !inside || numbers[k / 4] < 1e-6f || numbers[k % 4] < 1e-6f );
        }
    }
}

// ---- Learning

// Points on the floor and the ceiling of a box, to the left and to the right.
enum
{
    SAMPLES = 1 << 16
};

static RfVec3 point_of( int k )
{
    return rf_vec3( 4.0f * draw( (uint32_t)k, 4 ) - 2.0f, k % 2 ? 3.0f : 0.0f, draw( (uint32_t)k, 5 ) );
}

static RfVec3 normal_of( int k ) { return rf_vec3( 0.0f, k % 2 ? -1.0f : 1.0f, 0.0f ); }

// Light comes to the floor by a cone around this direction, to the ceiling from everywhere alike.
static RfVec3 light_of( RfVec3 p ) { return rf_normalize( rf_vec3( p.x < 0.0f ? 1.0f : -1.0f, 1.0f, 0.0f ) ); }

// Directions by the cosine, from all of the hemisphere. `noise`: the ceiling's light is seldom found.
static RfGuideSample draw_sample( int k, bool noise )
{
    RfVec3 n = normal_of( k ), p = point_of( k ), d = draw_direction( (uint32_t)k );
    d = rf_normalize( rf_add( d, n ) );
    float cosine = rf_maxf( rf_dot( d, n ), 1e-6f ), light = 1.0f;
    if ( k % 2 == 0 )
        light = rf_dot( d, light_of( p ) ) > 0.95f ? 1.0f : 0.0f;
    else if ( noise )
        light = draw( (uint32_t)k, 6 ) < 0.02f ? 50.0f : 0.0f;
    RfGuideSample s = { .p = { p.x, p.y, p.z },
                        .light = light * cosine,
                        .brought = light,
                        .pdf_solid_angle = RF_INV_PI * cosine,
                        .pdf_bsdf = RF_INV_PI * cosine,
                        .axis = (uint8_t)rf_guide_axis( n ) };
    s.bin = (int16_t)rf_guide_bin( d, &s.per_solid_angle );
    return s;
}

static int32_t table_at( const RfGuide* guide, RfVec3 p, RfVec3 n )
{
    int32_t table;
    rf_find_guide_tables( guide, 1, ( const float*[] ){ &p.x, &p.y, &p.z }, ( const float*[] ){ &n.x, &n.y, &n.z }, &table );
    return table;
}

TEST( test_a_guide_leads_to_the_light )
{
    RfGuideSample* samples = malloc( SAMPLES * sizeof *samples );
    assert_non_null( samples );
    for ( int k = 0; k < SAMPLES; ++k )
        samples[k] = draw_sample( k, true );
    RfGuide* guide = rf_learn_guide( samples, SAMPLES );
    assert_non_null( guide );
    int lead = 0, floors = 0, ceilings = 0;
    for ( int k = 0; k < 400; ++k )
    {
        RfVec3 p = point_of( k );
        int32_t number = table_at( guide, p, normal_of( k ) );
        if ( k % 2 == 1 )
        {
            ceilings += number != RF_NOT_GUIDED; // noise alone
            continue;
        }
        ++floors;
        assert_true( number != RF_NOT_GUIDED );
        const RfGuideTable* table = guide->tables + number;
        float uniform = 0.25f * RF_INV_PI, towards = rf_guide_pdf_solid_angle( table, light_of( p ) );
        RfVec3 away = rf_vec3( -light_of( p ).x, light_of( p ).y, 0.0f );
        assert_true( table->share > 0.0f && table->share < 1.0f );
        lead += towards > 10.0f * uniform && ( fabsf( p.x ) < 0.3f || towards > 10.0f * rf_guide_pdf_solid_angle( table, away ) );
    }
    print_message( "%d tables; %d of %d floors lead to the light, %d of 200 ceilings are guided\n", guide->table_count, lead,
                   floors, ceilings );
    assert_true( lead > 0.9 * floors );
    assert_true( ceilings < 40 );
    // a wall that no sample was on
    assert_int_equal( table_at( guide, rf_vec3( 2.0f, 1.0f, 0.5f ), rf_vec3( -1.0f, 0.0f, 0.0f ) ), RF_NOT_GUIDED );
    rf_destroy_guide( guide );
    free( samples );
}

TEST( test_few_samples_teach_nothing )
{
    RfGuideSample samples[8];
    for ( int k = 0; k < 8; ++k )
        samples[k] = draw_sample( k, false );
    for ( int count = 0; count <= 8; count += 8 )
    {
        RfGuide* guide = rf_learn_guide( samples, count );
        assert_non_null( guide );
        assert_int_equal( guide->table_count, 0 );
        rf_destroy_guide( guide );
    }
}

// All samples at one point, and on a line: nothing to split by, or by one coordinate alone.
TEST( test_degenerate_places )
{
    RfGuideSample* samples = malloc( SAMPLES * sizeof *samples );
    assert_non_null( samples );
    for ( int line = 0; line < 2; ++line )
    {
        for ( int k = 0; k < SAMPLES; ++k )
        {
            samples[k] = draw_sample( 2 * ( k / 2 ), false );
            for ( int c = 0; c < 3; ++c )
                samples[k].p[c] = line && c == 2 && k % 16 == 0 ? (float)k : 1e6f;
        }
        RfGuide* guide = rf_learn_guide( samples, SAMPLES );
        assert_non_null( guide );
        rf_destroy_guide( guide );
    }
    free( samples );
}

// Where a lane has a table, its density is the mixture; elsewhere it stays.
TEST( test_mixtures )
{
    static RfGuideTable s_table;
    fill_table( &s_table );
    RfGuide guide = { .tables = &s_table, .table_count = 1 };
    enum
    {
        LANES = 37
    };
    float wi[3][LANES], pdf[LANES];
    int32_t table[LANES];
    for ( int i = 0; i < LANES; ++i )
    {
        RF_PUT3( wi, i, draw_direction( (uint32_t)i ) );
        pdf[i] = draw( (uint32_t)i, 8 );
        table[i] = i % 3 ? RF_NOT_GUIDED : 0;
    }
    rf_mix_guide( &guide, LANES, table, ( const float*[] ){ wi[0], wi[1], wi[2] }, pdf );
    for ( int i = 0; i < LANES; ++i )
    {
        float before = draw( (uint32_t)i, 8 ), guided = rf_guide_pdf_solid_angle( &s_table, RF_GET3( wi, i ) );
        float expected = i % 3 ? before : 0.5f * before + 0.5f * guided;
        assert_true( fabsf( pdf[i] - expected ) <= 1e-5f * ( expected + guided ) );
        assert_true( i % 3 == 0 || pdf[i] == before );
    }
}

STATISTICAL_TESTS
