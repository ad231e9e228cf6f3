// The numbers with which paths begin (src/base/lattice.h; src/reuse/estimators.md, section 24): even over seeds, independent in the
// two halves and in blocks of pixels, and stratified over passes, pixels and frames.
#include "support/test.h"
#include "path/wavefront.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct Place
{
    int pass, frame, x, y;
} Place;

static RfWavefront* s_keys;

// The first two numbers of a scattered direction, a number that chooses, and a place on the film.
static void draw( uint64_t seed, Place at, float u[5] )
{
    RfRandomKey path =
        rf_pixel_key( rf_pass_key( seed, (uint32_t)at.frame, 1, (uint32_t)at.pass ), (uint32_t)( 64 * at.y + at.x ) );
    s_keys->key_a[0] = path.a;
    s_keys->key_b[0] = path.b;
    s_keys->lattice.half = rf_pass_key( seed, 0, 0, (uint32_t)( at.pass & 1 ) );
    s_keys->lattice.pass = (uint32_t)at.pass >> 1;
    s_keys->lattice.frame = (uint32_t)at.frame;
    rf_set_lattice_pixel( &s_keys->lattice, 0, (uint32_t)at.x, (uint32_t)at.y );
    float random[3][RF_LANES];
    const int32_t slot[1] = { 0 };
    rf_draw_lanes( s_keys, 1, slot, RF_DIMENSION_FIRST_VERTEX + RF_DIMENSION_SCATTER, 3, random );
    for ( int k = 0; k < 3; ++k )
        u[k] = random[k][0];
    rf_draw_lanes( s_keys, 1, slot, RF_DIMENSION_FILM_X, 2, random );
    u[3] = random[0][0];
    u[4] = random[1][0];
}

// A light's edge across the pixel, in a product with what is smooth; the mean is 1.
static double integrand( const float u[5] )
{
    double light = u[0] < 0.3f + 0.4f * u[3] ? 2.0 : 0.0;
    return light * ( 0.5 + (double)u[1] ) * ( 0.5 + (double)u[4] ) * ( u[2] < 0.5f ? 0.7 : 1.3 );
}

// Mean square error over seeds of the mean over places.
static double mean_square_error( const Place* places, int count, bool lattice )
{
    enum
    {
        SEEDS = 400
    };
    double sum = 0.0;
    s_keys->lattice.vertex = lattice ? 7 : 0;
    for ( int seed = 0; seed < SEEDS; ++seed )
    {
        double mean = 0.0;
        for ( int i = 0; i < count; ++i )
        {
            float u[5];
            draw( (uint64_t)seed, places[i], u );
            mean += integrand( u ) / count;
        }
        sum += ( mean - 1.0 ) * ( mean - 1.0 );
    }
    return sum / SEEDS;
}

// How many times less the error is than with random numbers.
static double gain( int passes, int side, int frames )
{
    Place places[1024];
    int count = 0;
    for ( int k = 0; k < passes; ++k )
        for ( int y = 0; y < side; ++y )
            for ( int x = 0; x < side; ++x )
                for ( int f = 0; f < frames; ++f )
                    places[count++] = ( Place ){ 2 * ( 11 + k ), 5 + f, 20 + x, 20 + y };
    return mean_square_error( places, count, false ) / mean_square_error( places, count, true );
}

TEST( test_numbers_are_stratified )
{
    static const struct
    {
        int passes, side, frames;
        double least;
    } s_sets[] = { { 7, 1, 1, 1.5 }, { 16, 1, 1, 2.0 }, { 64, 1, 1, 3.5 }, { 1, 3, 1, 1.5 },
                   { 7, 3, 1, 3.0 }, { 1, 1, 7, 1.3 },  { 1, 3, 7, 3.0 } };
    for ( size_t i = 0; i < sizeof s_sets / sizeof s_sets[0]; ++i )
    {
        double times = gain( s_sets[i].passes, s_sets[i].side, s_sets[i].frames );
        print_message( "%d passes, %dx%d pixels, %d frames: %.2f times less error\n", s_sets[i].passes, s_sets[i].side,
                       s_sets[i].side, s_sets[i].frames, times );
        assert_true( times > s_sets[i].least );
    }
}

// By seed, each number at any place is even, and pairs of numbers are.
TEST( test_numbers_are_even_over_seeds )
{
    enum
    {
        SEEDS = 20000,
        BINS = 8
    };
    s_keys->lattice.vertex = 7;
    static const Place s_places[] = { { 0, 0, 0, 0 }, { 14, 3, 17, 9 }, { 1001, 240, 1919, 1079 } };
    for ( size_t p = 0; p < sizeof s_places / sizeof s_places[0]; ++p )
    {
        static int count[5][5][BINS][BINS];
        memset( count, 0, sizeof count );
        for ( int seed = 0; seed < SEEDS; ++seed )
        {
            float u[5];
            draw( (uint64_t)seed, s_places[p], u );
            for ( int i = 0; i < 5; ++i )
            {
                assert_true( u[i] >= 0.0f && u[i] < 1.0f );
                for ( int j = 0; j < 5; ++j )
                    count[i][j][(int)( u[i] * BINS )][(int)( u[j] * BINS )] += 1;
            }
        }
        for ( int i = 0; i < 5; ++i )
        {
            for ( int j = 0; j < i; ++j )
            {
                double chi = 0.0, expected = (double)SEEDS / ( BINS * BINS );
                for ( int k = 0; k < BINS * BINS; ++k )
                {
                    double d = count[i][j][k / BINS][k % BINS] - expected;
                    chi += d * d / expected;
                }
                assert_true( chi < 130.0 ); // 63 degrees of freedom: p = 1e-6
            }
        }
    }
}

// By seed, numbers are independent if they are of different halves or blocks of pixels, and not if they are of one.
TEST( test_halves_and_blocks_are_independent )
{
    enum
    {
        SEEDS = 20000
    };
    s_keys->lattice.vertex = 7;
    static const Place s_other[] = { { 7, 3, 8, 9 }, { 6, 3, 16, 9 }, { 6, 3, 8, 16 }, { 8, 3, 8, 9 }, { 6, 3, 9, 9 } };
    for ( int other = 0; other < 5; ++other )
    {
        double along[5] = { 0 }, across[5] = { 0 }; // of the difference, as an angle
        for ( int seed = 0; seed < SEEDS; ++seed )
        {
            float a[5], b[5];
            draw( (uint64_t)seed, ( Place ){ 6, 3, 8, 9 }, a );
            draw( (uint64_t)seed, s_other[other], b );
            for ( int k = 0; k < 5; ++k )
            {
                double angle = 6.283185307179586 * ( (double)a[k] - (double)b[k] );
                along[k] += cos( angle ) / SEEDS;
                across[k] += sin( angle ) / SEEDS;
            }
        }
        for ( int k = 0; k < 5; ++k )
        {
            double length = hypot( along[k], across[k] );
            assert_true( other < 3 ? length < 5.0 * sqrt( 1.0 / SEEDS ) : length > 0.99 );
        }
    }
}

static int set_up( void** state )
{
    (void)state;
    s_keys = aligned_alloc( 64, ( sizeof *s_keys + 63 ) / 64 * 64 );
    if ( s_keys == NULL )
        return -1;
    memset( s_keys, 0, sizeof *s_keys );
    return 0;
}

static int tear_down( void** state )
{
    (void)state;
    free( s_keys );
    return 0;
}

SHARED_BY_TESTS( set_up, tear_down )
