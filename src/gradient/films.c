// Accumulates the samples of tiles into the films of a frame, and makes its picture from them. The two halves of
// the passes are independent. Each is solved with weights from the other, so the image is unbiased, and the
// difference of the solutions estimates its noise.
#include "gradient/films.h"

#include "reframe/reconstruct.h"

#include <math.h>
#include <string.h>

// Of the solve with constant weights: tiles leave less noise in pixels than path tracing does, for which 0.2 is usual.
#define ALPHA 0.5f
// Few passes say little about the variance of differences: a half that misses a rare path would trust them too
// much. So this share of the pixel's variance, over the passes of both halves, is added to it.
#define LEAST_SHARE 0.4f
// Relative residual at which the solve with weights stops, times the passes: far below the noise.
#define TOLERANCE 1e-3
#define LEAST_TOLERANCE 1e-6 // which floats reach
// Conjugate gradients that have not converged by then are reported of. Very noisy weights take some twenty.
#define MOST_ITERATIONS 50

typedef struct Target
{
    float* film[RF_GRADIENT_FILMS];
    float weight, primal_weight; // of differences, of values
    int width;
} Target;

// Adds `value` with its weight to a film, and its square to that of the squares.
static inline void add( const Target* t, int film, size_t pixel, float weight, const float value[3] )
{
    float *sum = t->film[film] + 4 * pixel, square = 0.0f;
    for ( int c = 0; c < 3; ++c )
    {
        sum[c] += weight * value[c];
        square += value[c] * value[c];
    }
    sum[3] += weight;
    t->film[RF_FILM_SQUARES][4 * pixel + (size_t)film] += weight * square;
}

static inline void add_difference( const Target* t, int film, size_t pixel, const float here[3], const float there[3] )
{
    add( t, film, pixel, t->weight, ( float[3] ){ there[0] - here[0], there[1] - here[1], there[2] - here[2] } );
}

static inline void add_unshared( const Target* t, size_t pixel, const float value[3] )
{
    float* sum = t->film[RF_FILM_UNSHARED] + 4 * pixel;
    for ( int c = 0; c < 3; ++c )
        sum[c] += t->primal_weight * value[c];
    sum[3] += t->primal_weight;
}

// Adds the rows of a tile that belong to the job. All its pixels and pairs count, also those that other tiles have.
static uint64_t add_tile( const Target* t, const RfExtendedTile* tile, const RfGradientBatch* batch, int lane,
                          RfAccumulateJob job )
{
    int across = tile->x1 - tile->x0;
    int first = tile->y0 > job.first_row ? tile->y0 : job.first_row, end = tile->y1 < job.end_row ? tile->y1 : job.end_row;
    for ( int y = first; y < end; ++y )
    {
        for ( int x = tile->x0; x < tile->x1; ++x )
        {
            int here = lane + ( y - tile->y0 ) * across + ( x - tile->x0 );
            size_t pixel = (size_t)y * (size_t)t->width + (size_t)x;
            add( t, RF_FILM_PRIMAL, pixel, t->primal_weight, batch->value[here] );
            add_unshared( t, pixel, batch->unshared[here] );
            if ( x + 1 < tile->x1 )
                add_difference( t, RF_FILM_DX, pixel, batch->common[here], batch->common[here + 1] );
            if ( y + 1 < tile->y1 )
                add_difference( t, RF_FILM_DY, pixel, batch->common[here], batch->common[here + across] );
            if ( job.landed != NULL )
                job.landed[pixel] += 1;
            if ( job.sky != NULL )
                job.sky[pixel] += t->primal_weight * batch->value[here][3];
        }
    }
    return end > first ? (uint64_t)( end - first ) * (uint64_t)across : 0;
}

uint64_t rf_accumulate_gradients( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count )
{
    // a pixel is in eight pairs, of which four have the same path
    float share = group->settings->tile.kind == RF_TILE_NONE ? 0.25f : 1.0f;
    Target target = { .weight = job.weight, .primal_weight = share * job.weight, .width = group->width };
    for ( int f = 0; f < RF_GRADIENT_FILMS; ++f )
        target.film[f] = job.films[f].half[job.half];
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfGradientBatch* batch = batches[k];
        int lane = 0;
        for ( int i = 0; i < batch->tile_count && batch->eye == job.eye; ++i )
        {
            landed += add_tile( &target, batch->tile + i, batch, lane, job );
            lane += rf_tile_area( batch->tile + i );
        }
    }
    return landed;
}

// What the solve works on, by half: means of the three films, 9 floats a pixel, and their variances, 3; the solution, 4.
typedef struct Work
{
    float *means[2], *variance[2], *solution[2];
    void* solver;
} Work;

typedef struct Halves
{
    RfGradientHalf half[2];
    float* solution[2]; // of each half alone
} Halves;

static size_t pixels_of( const RfFilm* film ) { return (size_t)film->width * (size_t)film->height; }

static Work place_work( int width, int height, RfLayout* layout )
{
    size_t pixels = (size_t)width * (size_t)height;
    Work work;
    for ( int h = 0; h < 2; ++h )
    {
        work.means[h] = rf_take( layout, 9 * pixels, sizeof( float ) );
        work.variance[h] = rf_take( layout, 3 * pixels, sizeof( float ) );
        work.solution[h] = rf_take( layout, 4 * pixels, sizeof( float ) );
    }
    work.solver = rf_take( layout, rf_reconstruct_bytes( width, height ), 1 );
    return work;
}

size_t rf_finish_gradients_bytes( const RfRenderSettings* settings, int width, int height )
{
    if ( settings->reconstruction == RF_RECONSTRUCTION_NONE )
        return 0;
    RfLayout layout = { 0 };
    place_work( width, height, &layout );
    return layout.bytes;
}

// Mean and variance of the mean of one film in one half. With a single value the variance is not known: its square, which
// is above it, stands for it.
static void find_means( const RfFilm* films, int f, int h, float* mean, float* variance )
{
    const RfFilm *film = films + f, *squares = films + RF_FILM_SQUARES;
    for ( size_t i = 0; i < pixels_of( film ); ++i )
    {
        double sums[4], of_squares[4], square = 0.0;
        rf_film_sums_at( film, i, h, sums );
        rf_film_sums_at( squares, i, h, of_squares );
        double count = sums[3];
        for ( size_t c = 0; c < 3; ++c )
        {
            double value = count > 0.0 ? sums[c] / count : 0.0;
            mean[3 * i + c] = (float)value;
            square += value * value;
        }
        double mean_square = count > 0.0 ? of_squares[f] / count : 0.0;
        variance[i] = (float)( count > 1.0 ? fmax( mean_square - square, 0.0 ) / ( count - 1.0 ) : mean_square );
    }
}

// Differences get what tiles do not share from the means of the pixels, so that all four of a pixel have the same.
static void add_unshared_steps( const RfFilm* films, int first, int last, float* means )
{
    for ( int f = RF_FILM_DX; f <= RF_FILM_DY; ++f )
        rf_add_film_steps( films + RF_FILM_UNSHARED, first, last, f == RF_FILM_DY, means + 3 * pixels_of( films ) * (size_t)f );
}

static void bound_variances( float share, size_t pixels, float* variance )
{
    for ( size_t i = 0; i < pixels; ++i )
    {
        variance[pixels + i] += share * variance[i];
        variance[2 * pixels + i] += share * variance[i];
    }
}

// Fills the halves that have passes.
static Halves load_halves( const RfFilm* films, const Work* work )
{
    size_t pixels = pixels_of( films );
    Halves out;
    for ( int h = 0; h < 2; ++h )
    {
        float *means = work->means[h], *variance = work->variance[h];
        for ( int f = 0; f < RF_FILM_SQUARES; ++f )
            find_means( films, f, h, means + 3 * pixels * (size_t)f, variance + pixels * (size_t)f );
        add_unshared_steps( films, h, h, means );
        bound_variances( LEAST_SHARE / (float)( films->passes[0] + films->passes[1] ), pixels, variance );
        out.half[h] = ( RfGradientHalf ){
            .images = { films->width, films->height, means, means + 3 * pixels, means + 6 * pixels },
            .variance = variance,
            .variance_dx = variance + pixels,
            .variance_dy = variance + 2 * pixels,
            .passes = films->passes[h],
        };
        out.solution[h] = work->solution[h];
    }
    return out;
}

// Constant weights, or L1, which is not linear: each half by itself, for the noise, and all data together.
static RfResult solve_constant( const RfFilm* films, const Halves* halves, const RfReconstructOptions* options, float* rgb,
                                RfReconstructInfo* info )
{
    RfResult result = RF_OK;
    for ( int h = 0; h < 2 && result == RF_OK; ++h )
    {
        if ( halves->half[h].passes > 0.0 )
            result = rf_reconstruct( &halves->half[h].images, NULL, options, halves->solution[h], NULL, NULL );
    }
    float* means = (float*)halves->half[0].images.primal;
    for ( int f = 0; f < RF_FILM_SQUARES; ++f )
        rf_combine_film( films + f, RF_NORMALIZE_RATIO, means + 3 * pixels_of( films ) * (size_t)f, NULL );
    add_unshared_steps( films, 0, 1, means );
    return result == RF_OK ? rf_reconstruct( &halves->half[0].images, NULL, options, rgb, info, NULL ) : result;
}

static RfResult solve( const RfRenderSettings* settings, const RfFilm* films, const Halves* halves, void* work, float* rgb,
                       RfReconstructInfo* info )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    bool variances = halves->half[0].passes >= 2.0 && halves->half[1].passes >= 2.0;
    options.alpha = ALPHA;
    options.tolerance = fmax( TOLERANCE / ( halves->half[0].passes + halves->half[1].passes ), LEAST_TOLERANCE );
    options.max_iterations = MOST_ITERATIONS;
    options.work = work;
    options.method = RF_RECONSTRUCT_WEIGHTED;
    if ( settings->reconstruction == RF_RECONSTRUCTION_L1 )
        options.method = RF_RECONSTRUCT_L1;
    else if ( settings->reconstruction == RF_RECONSTRUCTION_L2 || !variances )
        options.method = RF_RECONSTRUCT_L2;
    return options.method == RF_RECONSTRUCT_WEIGHTED
               ? rf_reconstruct_halves( halves->half, &options, rgb, halves->solution, info, NULL )
               : solve_constant( films, halves, &options, rgb, info );
}

// The noise of the picture, as that of a film with the solutions as its halves, which are spread to four floats a pixel in place.
static RfRelmse estimate_noise( const Halves* halves, const RfFilm* film, const RfPicture* picture )
{
    RfFilm solved = { .width = film->width, .height = film->height };
    for ( int h = 0; h < 2; ++h )
    {
        float* solution = halves->solution[h];
        for ( size_t i = pixels_of( film ); i-- > 0; )
        {
            float of_pixel[4] = { solution[3 * i], solution[3 * i + 1], solution[3 * i + 2], 1.0f };
            for ( size_t c = 0; c < 4; ++c )
                solution[4 * i + c] = (float)halves->half[h].passes * of_pixel[c];
        }
        solved.half[h] = solution;
        solved.passes[h] = film->passes[h];
        solved.weight[h] = halves->half[h].passes;
    }
    if ( picture->variance != NULL )
        rf_estimate_variance( &solved, RF_NORMALIZE_RATIO, picture->variance );
    return rf_estimate_relmse( &solved, RF_NORMALIZE_RATIO, picture->rgb );
}

// The pixels alone.
static RfRelmse finish_pixels( const RfFilm* primal, RfPicture* picture )
{
    rf_combine_film( primal, RF_NORMALIZE_RATIO, picture->rgb, NULL );
    if ( picture->variance != NULL )
        rf_estimate_variance( primal, RF_NORMALIZE_RATIO, picture->variance );
    return rf_estimate_relmse( primal, RF_NORMALIZE_RATIO, picture->rgb );
}

RfRelmse rf_finish_gradients( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch )
{
    const RfFilm* primal = films + RF_FILM_PRIMAL;
    rf_combine_film( primal, RF_NORMALIZE_RATIO, picture->rgb, picture->weight );
    if ( settings->reconstruction == RF_RECONSTRUCTION_NONE )
        return finish_pixels( primal, picture );
    Work work = place_work( films->width, films->height, &( RfLayout ){ .memory = scratch } );
    Halves halves = load_halves( films, &work );
    RfReconstructInfo info;
    if ( solve( settings, films, &halves, work.solver, picture->rgb, &info ) != RF_OK )
    {
        // samples that are not finite: the pixels as they are show where
        picture->solved = RF_SOLVED_NOT;
        finish_pixels( primal, picture );
        return rf_plain_relmse( (double)NAN );
    }
    picture->solved = info.converged ? RF_SOLVED : RF_SOLVED_ROUGHLY;
    if ( halves.half[0].passes > 0.0 && halves.half[1].passes > 0.0 ) // a single pass may lie in either half
        return estimate_noise( &halves, primal, picture );
    if ( picture->variance != NULL )
        rf_estimate_variance( primal, RF_NORMALIZE_RATIO, picture->variance ); // 0: a single pass
    return rf_plain_relmse( (double)NAN );
}
