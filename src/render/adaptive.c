#include "render/adaptive.h"

#include "base/system.h"
#include "render/adaptive_need.h"
#include "render/adaptive_noise.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define PILOT_PASSES 2
// The coarse look before the pilot: this part of a frame's pixels, and so many where it is small.
#define LOOK_SHARE ( 1.0 / 16.0 )
#define LOOK_PIXELS 512.0
#define PILOT_GROUP 0x40000000u // no group of the path has these numbers

// The frames around one, as far as the path goes.
static RfEstimatorGroup pilot_group( const RfRenderer* r, int frame )
{
    int eyes = r->plan.eyes, first = frame - eyes / 2, last_first = r->plan.frames - eyes;
    first = first < last_first ? first : last_first;
    first = first > 0 ? first : 0;
    RfEstimatorGroup group = rf_frames_as_group( r, first, eyes, (int)PILOT_GROUP );
    group.first_hits_only = true;
    group.filter = NULL;
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
                if ( r->memory.noise != NULL )
                    rf_add_noise( r->memory.noise, estimator->first_hits( scratch ), live->films[0].half[0] );
                if ( samples != NULL )
                    estimator->count_samples( batch, 1.0f, samples );
            }
        }
#pragma omp critical
        rf_add_rays( &r->rays, &mine );
    }
}

static float* noise_sums( const RfRenderer* r, const RfLiveFilm* live )
{
    return r->memory.noise != NULL ? live->films[0].half[0] : NULL;
}

// One ray for each pixel of some tiles, drawn like those of an extra sample: are there enough pixels without help for
// a pilot to be worth it? The film is empty yet and lends its counts of extra samples.
static bool look_for_gain( RfRenderer* r, RfEstimatorGroup group, RfLiveFilm* live )
{
    size_t pixels = (size_t)r->sizes.width * (size_t)r->sizes.height;
    float *drawn = live->films[0].extra[0], *samples = live->films[0].extra[1];
    for ( size_t i = 0; i < pixels; ++i )
        drawn[i] = (float)fmax( LOOK_SHARE, LOOK_PIXELS / (double)pixels );
    group.need = drawn;
    run_pilot_pass( r, &group, PILOT_PASSES, live, samples );
    RfPilotSums sums = { live->need, noise_sums( r, live ), samples, pixels, 1.0f, group.eye_count, true, rf_extra_worth( r ) };
    bool pays = rf_extra_may_pay( &sums );
    memset( live->need, 0, rf_need_bytes( &r->sizes ) );
    rf_clear_film( live->films );
    return pays;
}

static void find_need( RfRenderer* r, RfLiveFilm* live )
{
    RfEstimatorGroup group = pilot_group( r, live->frame );
    if ( r->settings.adaptive == RF_ADAPTIVE_AUTO && !look_for_gain( r, group, live ) )
        return;
    for ( int pass = 0; pass < PILOT_PASSES; ++pass )
        run_pilot_pass( r, &group, pass, live, NULL );
    size_t pixels = (size_t)r->sizes.width * (size_t)r->sizes.height;
    RfPilotSums sums = { live->need,
                         noise_sums( r, live ),
                         NULL,
                         pixels,
                         PILOT_PASSES,
                         group.eye_count,
                         r->settings.adaptive == RF_ADAPTIVE_AUTO,
                         rf_extra_worth( r ) };
    live->most_need = rf_set_need( &sums );
    rf_clear_film( live->films );
}

void rf_run_pilot( RfRenderer* r, RfLiveFilm* live )
{
    memset( live->need, 0, rf_need_bytes( &r->sizes ) );
    live->most_need = 0.0f;
    if ( r->plan.eyes > 1 )
    {
        rf_measure_noise( r, live );
        find_need( r, live );
    }
    // without extra samples the sums are those of a render without adaptive sampling, bit for bit
    live->films[0].total_every = rf_film_total_every( r->plan.eyes * rf_filter_pixels( &r->settings ) +
                                                      ( live->most_need > 0.0f ? rf_most_extra( r->memory.noise != NULL ) : 0 ) );
}
