#include "render/adaptive.h"

#include "base/system.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define PILOT_PASSES 2
// The coarse look before the pilot: this part of a frame's pixels, and so many where it is small.
#define LOOK_SHARE ( 1.0 / 16.0 )
#define LOOK_PIXELS 512.0
#define PILOT_GROUP 0x40000000u // no group of the path has these numbers
#define EXTRA_GROUP 0x80000000u
#define BINS 64
// Cost of a sample beside that of a path: for each further eye of a group, and
// of an extra one, which comes in broken wavefronts.
#define COST_OF_EYE 0.05
#define COST_OF_EXTRA 1.2
#define LEAST_GAIN 0.02 // by these figures, which are rough
#define LOOK_GAIN 0.01  // that justifies a pilot: a coarse look may miss some of it

// rf_extra_threshold for gains from `least_gain` on.
static double threshold( const double* counts, int bins, double all, int eyes, double least_gain )
{
    double best = 1.0, least = 0.0, without = 0.0;
    for ( int step = 0; step <= 10 * ( RF_MOST_EXTRA - 1 ); ++step )
    {
        double theta = 1.0 + 0.1 * step, error = 0.0, cost = all * ( 1.0 + COST_OF_EYE * ( eyes - 1 ) );
        for ( int b = 0; b < bins; ++b )
        {
            double info = (double)bins / ( b + 1 );
            error += counts[b] / fmax( info, theta );
            cost += counts[b] * COST_OF_EXTRA * fmax( 0.0, theta - info );
        }
        without = step == 0 ? error * cost : without;
        if ( step > 0 && error * cost >= least )
            continue;
        best = theta;
        least = error * cost;
    }
    return least > ( 1.0 - least_gain ) * without ? 1.0 : best;
}

double rf_extra_threshold( const double* counts, int bins, double all, int eyes )
{
    return threshold( counts, bins, all, eyes, LEAST_GAIN );
}

static void count_share( float share, double* counts )
{
    if ( share > 0.0f )
        counts[(int)fminf( share * BINS, BINS - 1 )] += 1.0;
}

// From sums of ρ to extra samples for each pass.
static void set_need( RfLiveFilm* live, int eyes )
{
    double counts[BINS] = { 0 };
    size_t pixels = (size_t)live->films[0].width * (size_t)live->films[0].height;
    for ( size_t i = 0; i < pixels; ++i )
    {
        live->need[i] = fminf( live->need[i] / PILOT_PASSES, 1.0f );
        count_share( live->need[i], counts );
    }
    float theta = (float)rf_extra_threshold( counts, BINS, (double)pixels, eyes );
    live->most_need = 0.0f;
    for ( size_t i = 0; i < pixels; ++i )
    {
        float need = live->need[i] > 0.0f ? fmaxf( 0.0f, theta - 1.0f / live->need[i] ) : 0.0f;
        live->need[i] = need;
        live->most_need = fmaxf( live->most_need, need );
    }
}

// The frames around one, as far as the path goes.
static RfEstimatorGroup pilot_group( const RfRenderer* r, int frame )
{
    int eyes = r->plan.eyes, first = frame - eyes / 2, last_first = r->plan.frames - eyes;
    first = first < last_first ? first : last_first;
    first = first > 0 ? first : 0;
    RfEstimatorGroup group = rf_frames_as_group( r, first, eyes, (int)PILOT_GROUP );
    group.first_hits_only = true;
    return group;
}

// One pass over the batches of the frame: as many at once as there is memory for. They share no pixel. `samples`, if
// not NULL, counts the camera rays of each pixel.
static void run_pilot_pass( RfRenderer* r, const RfEstimatorGroup* group, int pass, RfLiveFilm* live, float* samples )
{
    const RfEstimator* estimator = r->settings.estimator;
#pragma omp parallel num_threads( r->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        void* scratch = r->memory.trace_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int slot = 0; slot < r->memory.batch_slots; ++slot )
        {
            void* batch = r->memory.batches[slot];
            for ( int job = slot; job < r->sizes.of_estimator.jobs; job += r->memory.batch_slots )
            {
                estimator->trace( group, ( RfTraceJob ){ live->frame - group->first_frame, job, pass }, batch, scratch, &mine );
                estimator->add_own_shares( batch, scratch, live->need );
                if ( samples != NULL )
                    estimator->count_samples( batch, 1.0f, samples );
            }
        }
#pragma omp critical
        rf_add_rays( &r->rays, &mine );
    }
}

// One ray for each pixel of some tiles, drawn like those of an extra sample: are there enough pixels without help for
// a pilot to be worth it? The film is empty yet and lends its counts of extra samples.
static bool look_for_gain( RfRenderer* r, RfEstimatorGroup group, RfLiveFilm* live )
{
    double counts[BINS] = { 0 }, seen = 0.0;
    size_t pixels = (size_t)r->sizes.width * (size_t)r->sizes.height;
    float *drawn = live->films[0].extra[0], *samples = live->films[0].extra[1];
    for ( size_t i = 0; i < pixels; ++i )
        drawn[i] = (float)fmax( LOOK_SHARE, LOOK_PIXELS / (double)pixels );
    group.need = drawn;
    run_pilot_pass( r, &group, PILOT_PASSES, live, samples );
    for ( size_t i = 0; i < pixels; ++i )
    {
        if ( samples[i] == 0.0f )
            continue;
        count_share( live->need[i], counts );
        seen += 1.0;
    }
    memset( live->need, 0, rf_need_bytes( &r->sizes ) );
    memset( drawn, 0, rf_extra_bytes( &r->sizes ) );
    memset( samples, 0, rf_extra_bytes( &r->sizes ) );
    return threshold( counts, BINS, seen, group.eye_count, LOOK_GAIN ) > 1.0;
}

static void find_need( RfRenderer* r, RfLiveFilm* live )
{
    RfEstimatorGroup group = pilot_group( r, live->frame );
    if ( r->settings.adaptive == RF_ADAPTIVE_AUTO && !look_for_gain( r, group, live ) )
        return;
    for ( int pass = 0; pass < PILOT_PASSES; ++pass )
        run_pilot_pass( r, &group, pass, live, NULL );
    set_need( live, group.eye_count );
}

void rf_run_pilot( RfRenderer* r, RfLiveFilm* live )
{
    memset( live->need, 0, rf_need_bytes( &r->sizes ) );
    live->most_need = 0.0f;
    if ( r->plan.eyes > 1 )
        find_need( r, live );
    // without extra samples the sums are those of a render without adaptive sampling, bit for bit
    live->films[0].total_every = rf_film_total_every( r->plan.eyes + ( live->most_need > 0.0f ? RF_MOST_EXTRA : 0 ) );
}

// Batches [first, first + count) of a frame alone.
static void trace_extra( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int first, int count )
{
    const RfEstimator* estimator = r->settings.estimator;
    RfRayCounts rays = { 0 };
    uint64_t samples = 0;
#pragma omp parallel num_threads( r->settings.threads ) reduction( + : samples )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        void* scratch = r->memory.trace_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            void* batch = r->memory.batches[i];
            estimator->trace( pass->group, ( RfTraceJob ){ 0, first + i, pass->number }, batch, scratch, &mine );
            samples += estimator->count_samples( batch, (float)pass->weight, live->films[0].extra[pass->half] );
        }
#pragma omp critical
        rf_add_rays( &rays, &mine );
    }
    rf_add_rays( &r->rays, &rays );
    live->films[0].extra_samples += samples;
}

static void accumulate_extra( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int count )
{
    int bands = 2 * r->settings.threads < r->sizes.height ? 2 * r->settings.threads : r->sizes.height;
#pragma omp parallel for num_threads( r->settings.threads ) schedule( dynamic, 1 )
    for ( int band = 0; band < bands; ++band )
    {
        rf_set_float_mode();
        RfAccumulateJob job = rf_accumulate_job( r, live, pass, band, bands );
        void* scratch = r->memory.accumulate_scratch[omp_get_thread_num()];
        uint64_t landed = r->settings.estimator->accumulate( pass->group, job, r->memory.batches, count, scratch );
#pragma omp atomic
        live->films[0].landed += landed;
    }
}

// One more sample for the tiles of a frame that are drawn.
static void render_round( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int round )
{
    RfEstimatorGroup group = rf_frames_as_group( r, live->frame, 1, (int)( EXTRA_GROUP | (uint32_t)pass->group->number ) );
    group.need = live->need;
    group.round = round;
    RfPass extra = { &group, RF_MOST_EXTRA * pass->number + round, pass->half, pass->weight };
    int jobs = r->sizes.of_estimator.jobs;
    for ( int first = 0; first < jobs; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
        trace_extra( r, &extra, live, first, count );
        accumulate_extra( r, &extra, live, count );
    }
}

void rf_render_extra( RfRenderer* r, const RfPass* pass )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        RfLiveFilm* live = r->memory.films + i;
        for ( int round = 0; live->frame != -1 && (float)round < live->most_need; ++round )
            render_round( r, pass, live, round );
    }
}
