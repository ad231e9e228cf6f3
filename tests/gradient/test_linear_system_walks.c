// Random walks for x = A x + b, reused among the states of a tile with balance weights, against the exact inverse
// (Bekaert, Sbert, Halton 2002, 2.1 to 2.3): the weights of tile reuse and of gradients in closed form. States are
// the pixels of a small image, whose reconstruction is unbiased too.
#include "base/random.h"
#include "reframe/reconstruct.h"
#include "support/statistics.h"
#include "support/test.h"

#include <omp.h>

#define WIDTH 8
#define HEIGHT 6
#define STATES ( WIDTH * HEIGHT )
#define TILE 3
#define PASSES 2      // per half
#define MOST_STEPS 64 // an albedo of 0.8 leaves 6e-7 of the light beyond

static double s_a[STATES][STATES], s_b[STATES], s_p[STATES][STATES], s_survival[STATES], s_x[STATES];

static double even( uint64_t key, uint32_t i, uint32_t k ) { return (double)rf_random( rf_pixel_key( key, i ), k ); }

// Every state reflects light of all others that it sees, as patches of an albedo do. Its walk goes only to those that are
// likely: states that it never samples it has from its neighbours alone.
static void make_system( void )
{
    uint64_t key = rf_pass_key( 4242, 0, 0, 0 );
    for ( uint32_t i = 0; i < STATES; ++i )
    {
        double sum = 0.0, sampled = 0.0, albedo = 0.3 + 0.5 * even( key, i, 0 );
        for ( uint32_t j = 0; j < STATES; ++j )
        {
            s_a[i][j] = i == j ? 0.0 : pow( even( key, i * STATES + j, 1 ), 2.0 );
            sum += s_a[i][j];
        }
        for ( uint32_t j = 0; j < STATES; ++j )
        {
            s_a[i][j] *= albedo / sum;
            // a third of the states is not sampled, another one by neighbours; the last pixel may be alone in its tile
            s_p[i][j] = ( j + i % WIDTH + i / WIDTH ) % 3 == 0 && i < STATES - 1 ? 0.0 : s_a[i][j] + 0.2 / STATES;
            sampled += s_p[i][j];
        }
        for ( uint32_t j = 0; j < STATES; ++j )
            s_p[i][j] /= sampled;
        s_b[i] = even( key, i, 2 ) < 0.2 ? 1.0 + even( key, i, 3 ) : 0.0;
        s_survival[i] = 0.4 + 0.6 * even( key, i, 4 );
    }
}

// x = (1 − A)⁻¹ b, by Gauss's elimination: the matrix is diagonally dominant.
static void solve_exactly( void )
{
    static double m[STATES][STATES];
    for ( int i = 0; i < STATES; ++i )
    {
        s_x[i] = s_b[i];
        for ( int j = 0; j < STATES; ++j )
            m[i][j] = ( i == j ? 1.0 : 0.0 ) - s_a[i][j];
    }
    for ( int k = 0; k < STATES; ++k )
    {
        for ( int i = k + 1; i < STATES; ++i )
        {
            double factor = m[i][k] / m[k][k];
            for ( int j = k; j < STATES; ++j )
                m[i][j] -= factor * m[k][j];
            s_x[i] -= factor * s_x[k];
        }
    }
    for ( int i = STATES - 1; i >= 0; --i )
    {
        for ( int j = i + 1; j < STATES; ++j )
            s_x[i] -= m[i][j] * s_x[j];
        s_x[i] /= m[i][i];
    }
}

// A walk's first step from a state, −1 where roulette ended it, and its unbiased estimate of x there.
typedef struct Walk
{
    int to;
    double x;
} Walk;

static int step( const double p[STATES], double u )
{
    int j = -1;
    for ( int k = 0; k < STATES && u >= 0.0; ++k )
    {
        j = p[k] > 0.0 ? k : j;
        u -= p[k];
    }
    return j;
}

// By sampling what is reflected: the step's weight is the albedo, which is the chance to go on.
static double estimate( int state, uint64_t key, uint32_t walk )
{
    double sum = s_b[state];
    for ( uint32_t k = 0; k < MOST_STEPS; ++k )
    {
        double u = even( key, walk, k + 10 );
        for ( int j = 0; j <= STATES; ++j )
        {
            if ( j == STATES )
                return sum; // absorbed
            u -= s_a[state][j];
            if ( u < 0.0 )
            {
                state = j;
                break;
            }
        }
        sum += s_b[state];
    }
    return sum;
}

static Walk make_walk( int from, uint64_t key )
{
    Walk walk = { -1, 0.0 };
    uint32_t i = (uint32_t)from;
    if ( even( key, i, 0 ) >= s_survival[from] )
        return walk;
    walk.to = step( s_p[from], even( key, i, 1 ) );
    walk.x = estimate( walk.to, key, i + STATES );
    return walk;
}

// What the estimators add up: x of each state, and the differences to the right and below, each by a tile that holds both.
typedef struct Sums
{
    double x[STATES], dx[STATES], dy[STATES];
} Sums;

typedef enum Weights
{
    BALANCE,
    OWN_DENSITY // of the walk's own state instead of the sum over the tile: misses what it never samples
} Weights;

// Σ_k F_{k→i} = Σ_k a_i,to x̂ / Σ_l q_l p_l,to over the walks k and the states l of the tile.
static double gather( int i, const int* states, int count, const Walk* walks, Weights weights )
{
    double sum = 0.0;
    for ( int k = 0; k < count; ++k )
    {
        const Walk* walk = walks + states[k];
        double density = 0.0;
        for ( int l = 0; l < count && walk->to >= 0; ++l )
            density += s_survival[states[l]] * s_p[states[l]][walk->to];
        if ( weights == OWN_DENSITY && walk->to >= 0 )
            density = count * s_survival[states[k]] * s_p[states[k]][walk->to];
        sum += walk->to >= 0 ? s_a[i][walk->to] * walk->x / density : 0.0;
    }
    return sum;
}

// The tile whose inner states begin at (x0, y0), cut by the border, with a column and a row more.
static void add_tile( int x0, int y0, const Walk* walks, Weights weights, Sums* sums )
{
    int states[( TILE + 1 ) * ( TILE + 1 )], count = 0;
    double f[STATES] = { 0.0 };
    for ( int y = y0; y <= y0 + TILE; ++y )
    {
        for ( int x = x0; x <= x0 + TILE; ++x )
        {
            if ( x >= 0 && y >= 0 && x < WIDTH && y < HEIGHT )
                states[count++] = y * WIDTH + x;
        }
    }
    for ( int k = 0; k < count; ++k )
        f[states[k]] = s_b[states[k]] + gather( states[k], states, count, walks, weights );
    for ( int k = 0; k < count; ++k )
    {
        int i = states[k], x = i % WIDTH, y = i / WIDTH;
        if ( x == x0 + TILE || y == y0 + TILE )
            continue; // the state is another tile's
        sums->x[i] += f[i];
        sums->dx[i] += x + 1 < WIDTH ? f[i + 1] - f[i] : 0.0;
        sums->dy[i] += y + 1 < HEIGHT ? f[i + WIDTH] - f[i] : 0.0;
    }
}

// One pass: a walk from each state, tiles at a random offset.
static void add_pass( uint64_t key, Weights weights, Sums* sums )
{
    Walk walks[STATES];
    for ( int i = 0; i < STATES; ++i )
        walks[i] = make_walk( i, key );
    int offset_x = (int)( TILE * even( key, 3 * STATES, 0 ) ), offset_y = (int)( TILE * even( key, 3 * STATES, 1 ) );
    for ( int y = offset_y - TILE; y < HEIGHT; y += TILE )
    {
        for ( int x = offset_x - TILE; x < WIDTH; x += TILE )
            add_tile( x, y, walks, weights, sums );
    }
}

// Whether `count` values per seed have these means.
typedef struct Verdict
{
    double worst; // largest |t|
    double all;   // p-value of all together
    double variance;
} Verdict;

// Solves the symmetric, positive definite system m c = v by elimination; v receives c.
static void solve_symmetric( double m[STATES][STATES], double v[STATES], int n )
{
    for ( int k = 0; k < n; ++k )
    {
        for ( int i = k + 1; i < n; ++i )
        {
            double factor = m[i][k] / m[k][k];
            for ( int j = k; j < n; ++j )
                m[i][j] -= factor * m[k][j];
            v[i] -= factor * v[k];
        }
    }
    for ( int i = n - 1; i >= 0; --i )
    {
        for ( int j = i + 1; j < n; ++j )
            v[i] -= m[i][j] * v[j];
        v[i] /= m[i][i];
    }
}

// Hotelling's test: neighbours share walks, so their errors go together, which the covariance knows and p-values that are
// taken for independent do not. `which` are the values that vary.
static double hotelling_p( const double* values, int seeds, int count, const double* means, const int* which, int used )
{
    static double covariance[STATES][STATES];
    double away[STATES] = { 0.0 }, solved[STATES], t2 = 0.0;
    memset( covariance, 0, sizeof covariance );
    for ( int i = 0; i < used; ++i )
    {
        for ( int seed = 0; seed < seeds; ++seed )
            away[i] += ( values[seed * count + which[i]] - means[which[i]] ) / seeds;
    }
    for ( int seed = 0; seed < seeds; ++seed )
    {
        double d[STATES];
        for ( int i = 0; i < used; ++i )
            d[i] = values[seed * count + which[i]] - means[which[i]] - away[i];
        for ( int i = 0; i < used; ++i )
        {
            for ( int j = 0; j < used; ++j )
                covariance[i][j] += d[i] * d[j] / ( seeds - 1 );
        }
    }
    memcpy( solved, away, sizeof solved );
    solve_symmetric( covariance, solved, used );
    for ( int i = 0; i < used; ++i )
        t2 += seeds * away[i] * solved[i];
    // the F distribution of so many seeds is that of chi^2, but for its mean
    return chi_square_p( t2 * ( seeds - used ) / ( seeds - 1.0 ), used );
}

static Verdict judge( const double* values, int seeds, int count, const double* means )
{
    Verdict verdict = { 0.0, 0.0, 0.0 };
    AUTO_FREE double* of_one = malloc( (size_t)seeds * sizeof *of_one );
    int used = 0, which[STATES];
    assert_non_null( of_one );
    for ( int i = 0; i < count; ++i )
    {
        for ( int seed = 0; seed < seeds; ++seed )
            of_one[seed] = values[seed * count + i];
        double error, mean = mean_of( of_one, seeds, &error );
        if ( error == 0.0 )
            continue; // a difference that leaves the image
        verdict.worst = fmax( verdict.worst, fabs( mean - means[i] ) / error );
        verdict.variance += error * error * seeds / count;
        which[used++] = i;
    }
    verdict.all = hotelling_p( values, seeds, count, means, which, used );
    return verdict;
}

static void check( const char* what, Verdict verdict )
{
    printf( "%s: variance %.4g, largest |t| %.2f, all together %.3f\n", what, verdict.variance, verdict.worst, verdict.all );
    assert_true( verdict.worst < 4.8 ); // of 48: 8e-5
    assert_true( verdict.all > 1e-4 );
}

static void check_system( void )
{
    make_system();
    solve_exactly();
    for ( int i = 0; i < STATES; ++i )
    {
        double sum = s_b[i];
        for ( int j = 0; j < STATES; ++j )
            sum += s_a[i][j] * s_x[j];
        assert_true( fabs( sum - s_x[i] ) < 1e-12 );
    }
}

// What should come out as differences; 0 past the border.
static void exact_differences( double* dx, double* dy )
{
    for ( int i = 0; i < STATES; ++i )
    {
        dx[i] = i % WIDTH + 1 < WIDTH ? s_x[i + 1] - s_x[i] : 0.0;
        dy[i] = i / WIDTH + 1 < HEIGHT ? s_x[i + WIDTH] - s_x[i] : 0.0;
    }
}

static int seeds( void ) { return getenv( "REFRAME_LONG" ) != NULL ? 40000 : 4000; }

TEST( test_reused_walks_solve_the_system )
{
    check_system();
    int count = seeds();
    double dx[STATES], dy[STATES];
    double* values[3];
    for ( int k = 0; k < 3; ++k )
        assert_non_null( values[k] = malloc( (size_t)( count * STATES ) * sizeof( double ) ) );
    exact_differences( dx, dy );
    for ( int seed = 0; seed < count; ++seed )
    {
        Sums sums = { .x = { 0.0 } };
        add_pass( rf_pass_key( (uint64_t)seed, 1, 0, 0 ), BALANCE, &sums );
        memcpy( values[0] + seed * STATES, sums.x, sizeof sums.x );
        memcpy( values[1] + seed * STATES, sums.dx, sizeof sums.dx );
        memcpy( values[2] + seed * STATES, sums.dy, sizeof sums.dy );
    }
    Verdict x = judge( values[0], count, STATES, s_x ), of_dx = judge( values[1], count, STATES, dx );
    check( "x", x );
    check( "dx", of_dx );
    check( "dy", judge( values[2], count, STATES, dy ) );
    assert_true( of_dx.variance < 2.0 * x.variance ); // paths shared cancel in the difference
    for ( int k = 0; k < 3; ++k )
        free( values[k] );
}

TEST( test_the_density_of_the_own_state_alone_is_biased )
{
    check_system();
    int count = seeds() / 4;
    AUTO_FREE double* values = malloc( (size_t)( count * STATES ) * sizeof *values );
    assert_non_null( values );
    for ( int seed = 0; seed < count; ++seed )
    {
        Sums sums = { .x = { 0.0 } };
        add_pass( rf_pass_key( (uint64_t)seed, 1, 0, 0 ), OWN_DENSITY, &sums );
        memcpy( values + seed * STATES, sums.x, sizeof sums.x );
    }
    Verdict verdict = judge( values, count, STATES, s_x );
    printf( "own density: largest |t| %.1f\n", verdict.worst );
    assert_true( verdict.worst > 8.0 && verdict.all < 1e-9 );
}

// The images of one half and the variances of their means, from its passes.
typedef struct Half
{
    float images[3][3 * STATES], variances[3][STATES];
} Half;

static RfGradientHalf make_half( uint64_t seed, uint32_t half, Half* out )
{
    Sums passes[PASSES];
    for ( uint32_t k = 0; k < PASSES; ++k )
    {
        passes[k] = ( Sums ){ .x = { 0.0 } };
        add_pass( rf_pass_key( seed, 2 + half, 0, k ), BALANCE, passes + k );
    }
    for ( int i = 0; i < STATES; ++i )
    {
        const double values[3][2] = { { passes[0].x[i], passes[1].x[i] },
                                      { passes[0].dx[i], passes[1].dx[i] },
                                      { passes[0].dy[i], passes[1].dy[i] } };
        for ( int k = 0; k < 3; ++k )
        {
            double difference = values[k][0] - values[k][1];
            for ( int c = 0; c < 3; ++c )
                out->images[k][3 * i + c] = (float)( 0.5 * ( values[k][0] + values[k][1] ) );
            out->variances[k][i] = (float)( 0.25 * difference * difference );
        }
    }
    return ( RfGradientHalf ){ { WIDTH, HEIGHT, out->images[0], out->images[1], out->images[2] },
                               out->variances[0],
                               out->variances[1],
                               out->variances[2],
                               PASSES };
}

TEST( test_reconstructions_solve_the_system )
{
    check_system();
    static Half halves[2];
    int count = seeds() / 2;
    double* values[3]; // the mean of the primals, constant weights, weights of the other half
    RfReconstructOptions options = rf_default_reconstruct_options(), weighted = options;
    RfError error;
    weighted.method = RF_RECONSTRUCT_WEIGHTED;
    for ( int k = 0; k < 3; ++k )
        assert_non_null( values[k] = malloc( (size_t)( count * STATES ) * sizeof( double ) ) );
    for ( int seed = 0; seed < count; ++seed )
    {
        float constant[2][3 * STATES], crossfit[3 * STATES];
        RfGradientHalf in[2];
        for ( uint32_t k = 0; k < 2; ++k )
        {
            in[k] = make_half( (uint64_t)seed, k, halves + k );
            assert_int_equal( rf_reconstruct( &in[k].images, NULL, &options, constant[k], NULL, &error ), RF_OK );
        }
        assert_int_equal( rf_reconstruct_halves( in, &weighted, crossfit, NULL, NULL, &error ), RF_OK );
        for ( int i = 0; i < STATES; ++i )
        {
            values[0][seed * STATES + i] = 0.5 * (double)( halves[0].images[0][3 * i] + halves[1].images[0][3 * i] );
            values[1][seed * STATES + i] = 0.5 * (double)( constant[0][3 * i] + constant[1][3 * i] );
            values[2][seed * STATES + i] = (double)crossfit[3 * i];
        }
    }
    check( "primal", judge( values[0], count, STATES, s_x ) );
    check( "constant weights", judge( values[1], count, STATES, s_x ) );
    check( "weights of the other half", judge( values[2], count, STATES, s_x ) );
    for ( int k = 0; k < 3; ++k )
        free( values[k] );
}

int main( void )
{
    omp_set_num_threads( 1 ); // the images are tiny
    return run_listed_tests();
}
