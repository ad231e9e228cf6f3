#include "render/adaptive_extra.h"

#include "base/system.h"
#include "render/adaptive.h"

#include <omp.h>

#define EXTRA_GROUP 0x80000000u // no group of the path has these numbers

// Batches [first, first + count) of a frame alone.
static uint64_t trace_extra( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int first, int count )
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
            samples += estimator->count_samples( batch, (float)( pass->weight * rf_extra_worth( r ) ),
                                                 live->films[0].extra[pass->half] );
        }
#pragma omp critical
        rf_add_rays( &rays, &mine );
    }
    rf_add_rays( &r->rays, &rays );
    live->films[0].extra_samples += samples;
    return samples;
}

void rf_accumulate_extra( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int count )
{
    int bands = 2 * r->settings.threads < r->sizes.height ? 2 * r->settings.threads : r->sizes.height;
#pragma omp parallel for num_threads( r->settings.threads ) schedule( dynamic, 1 )
    for ( int band = 0; band < bands; ++band )
    {
        rf_set_float_mode();
        RfAccumulateJob job = rf_accumulate_job( r, live, pass, band, bands );
        job.weight *= pass->group->filter != NULL ? (float)rf_extra_worth( r ) : 1.0f;
        void* scratch = r->memory.accumulate_scratch[omp_get_thread_num()];
        uint64_t landed = r->settings.estimator->accumulate( pass->group, job, r->memory.batches, count, scratch );
#pragma omp atomic
        live->films[0].landed += landed;
    }
}

// Extra samples of a frame: of the tiles that are drawn one more, or, packed, as many as fill a batch of each job. Returns
// their number.
static uint64_t render_round( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int round )
{
    bool packed = r->memory.noise != NULL;
    RfEstimatorGroup group = rf_frames_as_group( r, live->frame, 1, (int)( EXTRA_GROUP | (uint32_t)pass->group->number ) );
    group.need = live->need;
    group.round = round;
    group.packed = packed;
    group.shared = pass->group->shared; // that of the pass
    RfPass extra = { &group, rf_most_extra( packed ) * pass->number + ( packed ? 0 : round ), pass->half, pass->weight };
    int jobs = r->sizes.of_estimator.jobs;
    uint64_t samples = 0;
    for ( int first = 0; first < jobs; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
        samples += trace_extra( r, &extra, live, first, count );
        rf_accumulate_extra( r, &extra, live, count );
    }
    return samples;
}

static void render_frame_extra( RfRenderer* r, const RfPass* pass, RfLiveFilm* live )
{
    if ( r->memory.noise != NULL )
    {
        for ( int round = 0; render_round( r, pass, live, round ) > 0; ++round )
            ;
        return;
    }
    for ( int round = 0; (float)round < live->most_need; ++round )
        render_round( r, pass, live, round );
}

void rf_render_extra( RfRenderer* r, const RfPass* pass )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        RfLiveFilm* live = r->memory.films + i;
        if ( live->frame != -1 && live->most_need > 0.0f )
            render_frame_extra( r, pass, live );
    }
}
