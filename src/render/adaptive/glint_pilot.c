// Foresees glints by a pilot, and how many extra samples they get.

#include "base/system.h"
#include "render/adaptive/adaptive.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define GLINT_PILOT 0x60000000u // no group of the path has this number
#define USUAL_VARIANCE 0.3      // of a sample of other pixels, over the squared mean: of most rooms
#define LEAST_RATIO 16.0        // to that, of the variances of glints
#define DARK 1e-3               // what relMSE adds to squares
#define MOST_SHARE 0.08         // of extra samples in all, with the pilot within a tenth
#define MOST_HALVINGS 4         // of θ, the first of which brings more for a sample
#define SAVED_FOR_COST 3.0      // the share of error that is saved over that of samples, at least

// Sums over pixels are those of so many parts, each by one thread: the same for any number of threads.
#define PARTS 256

typedef struct Sums
{
    double first, second, third;
} Sums;

static size_t part( size_t pixels, int number ) { return pixels * (size_t)number / PARTS; }

static Sums add_parts( const Sums* parts )
{
    Sums sums = { .first = 0.0 };
    for ( int k = 0; k < PARTS; ++k )
    {
        sums.first += parts[k].first;
        sums.second += parts[k].second;
        sums.third += parts[k].third;
    }
    return sums;
}

// The light that other surfaces are taken to have: the mean of what lights those with sharp lobes.
static double base_light( const float* sums, size_t pixels )
{
    Sums parts[PARTS] = { { .first = 0.0 } };
#pragma omp parallel for schedule( static )
    for ( int k = 0; k < PARTS; ++k )
    {
        rf_set_float_mode();
        for ( size_t i = part( pixels, k ); i < part( pixels, k + 1 ); ++i )
        {
            parts[k].first += (double)sums[4 * i + 2];
            parts[k].second += (double)sums[4 * i + 3];
        }
    }
    Sums all = add_parts( parts );
    return all.second > 0.0 ? all.first / all.second : 0.0;
}

// Variance of a sample over that of other pixels.
static double variance_ratio( const float* sums, size_t i, double base )
{
    double mean = (double)sums[4 * i], square = (double)sums[4 * i + 1], all = mean + base;
    if ( !( all > 0.0 ) )
        return 0.0;
    double seen = mean * mean / ( all * all );
    return seen * fmax( 0.0, square - mean * mean ) / ( all * all + DARK ) / USUAL_VARIANCE;
}

// The error is least for its cost where samples go with the root of the variance: θ of what makes all pixels alike.
static double extra_of( double ratio, double theta, double reach, double worth )
{
    if ( ratio < LEAST_RATIO )
        return 0.0;
    return fmin( fmax( 0.0, theta * sqrt( ratio ) - 1.0 ) * reach / worth, RF_MOST_GLINTS );
}

static double sum_extra( const float* ratio, size_t pixels, double theta, double reach, double worth )
{
    Sums parts[PARTS] = { { .first = 0.0 } };
#pragma omp parallel for schedule( static )
    for ( int k = 0; k < PARTS; ++k )
    {
        rf_set_float_mode();
        for ( size_t i = part( pixels, k ); i < part( pixels, k + 1 ); ++i )
            parts[k].first += extra_of( (double)ratio[i], theta, reach, worth );
    }
    return add_parts( parts ).first;
}

// The θ, at most 1, that keeps within the budget.
static double affordable( const float* ratio, size_t pixels, double reach, double worth, double budget )
{
    double low = 0.0, high = 1.0;
    if ( sum_extra( ratio, pixels, high, reach, worth ) <= budget )
        return high;
    for ( int step = 0; step < 24; ++step )
    {
        double middle = 0.5 * ( low + high );
        bool fits = sum_extra( ratio, pixels, middle, reach, worth ) <= budget;
        low = fits ? middle : low;
        high = fits ? high : middle;
    }
    return low;
}

// Do samples by θ save enough?
static bool pays( const float* ratio, size_t pixels, double theta, double reach, double worth )
{
    Sums parts[PARTS] = { { .first = 0.0 } }; // error, what is saved of it, samples
#pragma omp parallel for schedule( static )
    for ( int k = 0; k < PARTS; ++k )
    {
        rf_set_float_mode();
        for ( size_t i = part( pixels, k ); i < part( pixels, k + 1 ); ++i )
        {
            double more = extra_of( (double)ratio[i], theta, reach, worth );
            parts[k].first += 1.0 + (double)ratio[i];
            parts[k].second += (double)ratio[i] * ( 1.0 - reach / ( reach + worth * more ) );
            parts[k].third += more;
        }
    }
    Sums all = add_parts( parts );
    return all.second / all.first > SAVED_FOR_COST * all.third / (double)pixels;
}

float rf_set_glints( const float* sums, size_t pixels, double reach, double worth, float* extra )
{
    double base = base_light( sums, pixels );
#pragma omp parallel for schedule( static )
    for ( int k = 0; k < PARTS; ++k )
    {
        rf_set_float_mode();
        for ( size_t i = part( pixels, k ); i < part( pixels, k + 1 ); ++i )
            extra[i] = (float)variance_ratio( sums, i, base );
    }
    double theta = affordable( extra, pixels, reach, worth, MOST_SHARE * (double)pixels );
    for ( int halved = 0; !pays( extra, pixels, theta, reach, worth ); ++halved, theta *= 0.5 )
    {
        if ( halved == MOST_HALVINGS )
            return 0.0f;
    }
    float most = 0.0f;
#pragma omp parallel for schedule( static ) reduction( max : most )
    for ( int k = 0; k < PARTS; ++k )
    {
        rf_set_float_mode();
        for ( size_t i = part( pixels, k ); i < part( pixels, k + 1 ); ++i )
        {
            extra[i] = (float)extra_of( (double)extra[i], theta, reach, worth );
            most = fmaxf( most, extra[i] );
        }
    }
    return most;
}

// Spreads the first two of `stride` floats of each pixel over its neighbours along one axis, as wide pixel filters do.
static void spread_along( float* sums, int count, size_t stride )
{
    for ( size_t c = 0; c < 2; ++c )
    {
        float before = sums[c];
        for ( int i = 0; i < count; ++i )
        {
            float* here = sums + (size_t)i * stride + c;
            float own = *here, next = i + 1 < count ? here[stride] : own;
            *here = 0.5f * own + 0.25f * ( before + next );
            before = own;
        }
    }
}

static void spread_by_filter( float* sums, int width, int height )
{
#pragma omp parallel
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( int y = 0; y < height; ++y )
            spread_along( sums + 4 * (size_t)y * (size_t)width, width, 4 );
#pragma omp for schedule( static )
        for ( int x = 0; x < width; ++x )
            spread_along( sums + 4 * x, height, 4 * (size_t)width );
    }
}

void rf_find_glints( RfRenderer* r, RfLiveFilm* live, double worth )
{
    const RfEstimator* estimator = r->setup->settings.estimator;
    int width = r->setup->sizes.width, height = r->setup->sizes.height;
    int jobs = ( ( width + RF_GLINT_BLOCK - 1 ) / RF_GLINT_BLOCK ) * ( ( height + RF_GLINT_BLOCK - 1 ) / RF_GLINT_BLOCK );
    RfEstimatorGroup group = rf_frames_as_group( r, live->frame, 1, (int)GLINT_PILOT );
    float* sums = live->films[0].half[0];
#pragma omp parallel num_threads( r->setup->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
#pragma omp for schedule( dynamic, 1 )
        for ( int job = 0; job < jobs; ++job )
            estimator->add_glints( &group, job, r->memory.trace_scratch[omp_get_thread_num()], sums, &mine );
#pragma omp critical
        rf_add_rays( &r->rays, &mine );
    }
    if ( group.filter != NULL )
        spread_by_filter( sums, width, height );
    live->most_glints = rf_set_glints( sums, (size_t)width * (size_t)height, r->setup->plan.eyes, worth, live->glints );
    rf_clear_film( live->films );
}
