// The picture of the gradient estimator's films: samples that are not finite and solves that do not converge are reported of,
// and the variance is that of the picture's halves.
#include "support/test.h"
#include "gradient/gradient.h"

#include "base/random.h"

#define WIDTH 40
#define HEIGHT 30
#define PIXELS ( WIDTH * HEIGHT )
#define PASSES 8

typedef struct Films
{
    RfFilm film[RF_GRADIENT_FILMS];
    float sums[RF_GRADIENT_FILMS][2][4 * PIXELS];
} Films;

typedef struct Solved
{
    float rgb[3 * PIXELS], variance[3 * PIXELS];
    RfRelmse relmse;
    RfSolved solved;
} Solved;

static float draw( int pass, int pixel, uint32_t dimension )
{
    return rf_random( rf_pixel_key( rf_pass_key( 5, (uint32_t)pass, 0, 0 ), (uint32_t)pixel ), dimension );
}

static void add( Films* films, int f, int half, int pixel, float value )
{
    float* sum = films->sums[f][half] + 4 * pixel;
    for ( int c = 0; c < 3; ++c )
        sum[c] += value;
    sum[3] += 1.0f;
    films->sums[RF_FILM_SQUARES][half][4 * pixel + f] += 3.0f * value * value;
}

// A slope with noise in the pixels, less of it in the differences; the noise is exp(spread · (u − 1/2)) large.
static Films* make_films( float spread, int told_passes )
{
    Films* films = calloc( 1, sizeof *films );
    assert_non_null( films );
    for ( int f = 0; f < RF_GRADIENT_FILMS; ++f )
        films->film[f] = ( RfFilm ){ .width = WIDTH,
                                     .height = HEIGHT,
                                     .half = { films->sums[f][0], films->sums[f][1] },
                                     .passes = { told_passes / 2, told_passes / 2 },
                                     .weight = { PASSES / 2, PASSES / 2 } };
    for ( int pass = 0; pass < PASSES; ++pass )
    {
        for ( int i = 0; i < PIXELS; ++i )
        {
            float noise[3], size = expf( spread * ( draw( pass, i, 6 ) - 0.5f ) );
            for ( uint32_t k = 0; k < 3; ++k )
                noise[k] = size * ( draw( pass, i, k ) - 0.5f );
            add( films, RF_FILM_PRIMAL, pass % 2, i, 1.0f + 0.01f * (float)( i % WIDTH ) + noise[0] );
            add( films, RF_FILM_DX, pass % 2, i, 0.01f + 0.1f * noise[1] );
            add( films, RF_FILM_DY, pass % 2, i, 0.1f * noise[2] );
        }
    }
    return films;
}

static Solved* solve( const Films* films, RfReconstruction reconstruction )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.reconstruction = reconstruction;
    Solved* out = calloc( 1, sizeof *out );
    AUTO_FREE void* scratch = aligned_alloc( 64, rf_finish_gradients_bytes( &settings, WIDTH, HEIGHT ) + 64 );
    assert_true( out != NULL && scratch != NULL );
    RfPicture picture = { .rgb = out->rgb, .variance = out->variance };
    out->relmse = rf_finish_gradients( &settings, films->film, &picture, scratch );
    out->solved = picture.solved;
    return out;
}

TEST( test_what_is_not_finite_is_reported )
{
    AUTO_FREE Films* films = make_films( 0.0f, PASSES );
    films->sums[RF_FILM_DX][0][4 * 77] = INFINITY;
    for ( RfReconstruction r = RF_RECONSTRUCTION_WEIGHTED; r <= RF_RECONSTRUCTION_L1; ++r )
    {
        Solved *solved = solve( films, r ), *pixels = solve( films, RF_RECONSTRUCTION_NONE );
        assert_int_equal( solved->solved, RF_SOLVED_NOT );
        assert_int_equal( pixels->solved, RF_SOLVED );
        assert_memory_equal( solved->rgb, pixels->rgb, sizeof pixels->rgb );
        assert_memory_equal( solved->variance, pixels->variance, sizeof pixels->variance );
        assert_true( isnan( solved->relmse.likely ) && !isnan( pixels->relmse.likely ) );
        free( pixels );
        free( solved );
    }
}

TEST( test_a_solve_that_stops_early_is_reported )
{
    Films *quiet = make_films( 1.0f, PASSES ), *wild = make_films( 30.0f, 1 << 20 );
    Solved *solved = solve( quiet, RF_RECONSTRUCTION_WEIGHTED ), *rough = solve( wild, RF_RECONSTRUCTION_L1 );
    assert_int_equal( solved->solved, RF_SOLVED );
    assert_int_equal( rough->solved, RF_SOLVED_ROUGHLY );
    free( rough );
    free( solved );
    free( wild );
    free( quiet );
}

// The error of the slope, squared, is on average what the variance says: differences make it far less than that of the pixels.
TEST( test_variance_is_that_of_the_picture )
{
    AUTO_FREE Films* films = make_films( 0.0f, PASSES );
    double pixels_told = 0.0;
    for ( int r = RF_RECONSTRUCTION_NONE; r >= RF_RECONSTRUCTION_WEIGHTED; --r )
    {
        AUTO_FREE Solved* solved = solve( films, (RfReconstruction)r );
        double told = 0.0, error = 0.0;
        for ( int i = 0; i < PIXELS; ++i )
        {
            double away = (double)solved->rgb[3 * i] - ( 1.0 + 0.01 * ( i % WIDTH ) );
            error += away * away;
            told += (double)solved->variance[3 * i];
        }
        if ( r == RF_RECONSTRUCTION_NONE )
            pixels_told = told;
        if ( r != RF_RECONSTRUCTION_L1 ) // biased
            assert_true( told > 0.6 * error && told < 1.6 * error );
        assert_true( r == RF_RECONSTRUCTION_NONE || told < 0.3 * pixels_told );
    }
}

// Light that tiles do not share, of a single pixel in a single pass, ends up in that pixel and nowhere else.
TEST( test_what_is_not_shared_stays_in_its_pixel )
{
    enum
    {
        AT = 10 * WIDTH + 17,
        HALF = 1,
    };
    const float light = 5.0f * PASSES;
    Films *films = make_films( 1.0f, PASSES ), *lit = make_films( 1.0f, PASSES );
    for ( int i = 0; i < PIXELS; ++i )
    {
        for ( int h = 0; h < 2; ++h )
            lit->sums[RF_FILM_UNSHARED][h][4 * i + 3] = (float)PASSES / 2.0f;
    }
    for ( int c = 0; c < 3; ++c )
    {
        lit->sums[RF_FILM_PRIMAL][HALF][4 * AT + c] += light;
        lit->sums[RF_FILM_UNSHARED][HALF][4 * AT + c] += light;
    }
    Solved *before = solve( films, RF_RECONSTRUCTION_L2 ), *after = solve( lit, RF_RECONSTRUCTION_L2 );
    for ( int i = 0; i < PIXELS; ++i )
    {
        for ( int c = 0; c < 3; ++c )
        {
            float more = after->rgb[3 * i + c] - before->rgb[3 * i + c];
            assert_true( fabsf( more - ( i == AT ? light / PASSES : 0.0f ) ) < 1e-4f );
        }
    }
    free( after );
    free( before );
    free( lit );
    free( films );
}
