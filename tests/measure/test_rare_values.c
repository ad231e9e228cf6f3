// Where a few rare values decide, 16 values that lack them have too small a mean and too small a variance, and Welch's test
// fails by itself. place_p, which compares pixels and blocks of pictures, keeps its level there, and finds what is different.
#include "support/statistics.h"
#include "support/test.h"

#define ACROSS 16
#define DOWN 12
#define PLACES ( ACROSS * DOWN )
#define SEEDS 16
#define PICTURES 400

// In (0, 1), by xorshift.
static double draw( uint64_t* state )
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return ( (double)( *state >> 11 ) + 0.5 ) / 9007199254740992.0;
}

static double draw_normal( uint64_t* state )
{
    double r = sqrt( -2.0 * log( draw( state ) ) );
    return r * cos( 6.283185307179586 * draw( state ) );
}

// Lognormal values of mean 1: spread 1.5 has skewness 33, 0.1 is nearly normal.
static void draw_places( uint64_t* state, double spread, Sample places[PLACES] )
{
    for ( int i = 0; i < PLACES; ++i )
    {
        double values[SEEDS];
        for ( int k = 0; k < SEEDS; ++k )
            values[k] = exp( spread * draw_normal( state ) - 0.5 * spread * spread );
        places[i] = sample_of( values, SEEDS );
    }
}

static void scale_place( Sample* place, double by )
{
    place->mean *= by;
    place->variance *= by * by;
}

// The smallest p of a picture by place_p and by Welch's test, by Šidák.
static void smallest_p( const Sample* a, const Sample* b, double* by_place, double* by_welch )
{
    double place = 1.0, welch = 1.0;
    for ( int i = 0; i < PLACES; ++i )
    {
        place = fmin( place, place_p( a, b, ACROSS, DOWN, i ) );
        welch = fmin( welch, welch_of( a[i], b[i] ) );
    }
    *by_place = 1.0 - pow( 1.0 - place, PLACES );
    *by_welch = 1.0 - pow( 1.0 - welch, PLACES );
}

// Pictures of equal means, one of which may be skewed: how many fall below the level.
static void count_false( double spread, double level, int* by_place, int* by_welch )
{
    uint64_t state = 88172645463325252u;
    *by_place = *by_welch = 0;
    for ( int n = 0; n < PICTURES; ++n )
    {
        Sample a[PLACES], b[PLACES];
        double place, welch;
        draw_places( &state, spread, a );
        draw_places( &state, 0.1, b );
        smallest_p( a, b, &place, &welch );
        *by_place += place < level;
        *by_welch += welch < level;
    }
    printf( "spread %.1f: %d of %d pictures below %g, %d by Welch's test\n", spread, *by_place, PICTURES, level, *by_welch );
}

TEST( test_skewed_data_keep_the_level )
{
    static const double s_spreads[] = { 0.5, 1.0, 1.5 };
    for ( int k = 0; k < 3; ++k )
    {
        int place, welch;
        count_false( s_spreads[k], 0.01, &place, &welch );
        assert_true( place <= 12 ); // 4 are to be expected: by chance more than 12 once in 4000
        assert_true( k == 0 || welch > 100 );
        count_false( s_spreads[k], FIRST_LEVEL, &place, &welch );
        assert_true( place == 0 );
        assert_true( k == 0 || welch > 10 );
    }
}

// Of one place in the whole picture.
TEST( test_differences_are_found )
{
    static const struct
    {
        double spread, by;
    } s_found[] = { { 0.1, 1.4 }, { 0.3, 0.4 }, { 0.5, 0.2 } };
    for ( int k = 0; k < 3; ++k )
    {
        uint64_t random = 88172645463325252u;
        int place_found = 0, welch_found = 0;
        for ( int n = 0; n < PICTURES; ++n )
        {
            Sample a[PLACES], b[PLACES];
            double place, welch;
            draw_places( &random, s_found[k].spread, a );
            draw_places( &random, 0.1, b );
            scale_place( a + n % PLACES, s_found[k].by );
            smallest_p( a, b, &place, &welch );
            place_found += place < FIRST_LEVEL;
            welch_found += welch < FIRST_LEVEL;
        }
        printf( "spread %.1f, one place times %.1f: found %d of %d times, %d by Welch's test\n", s_found[k].spread, s_found[k].by,
                place_found, PICTURES, welch_found );
        assert_true( place_found > 0.9 * PICTURES );
    }
}
