// A job is some rows of one frame, so no two jobs touch the same pixel, and every pixel is added to in the order of the batches.
#include "render/accumulation.h"

#include "trace/trace.h"

#include <omp.h>

#define BANDS_PER_THREAD 2        // over all frames
#define LANDED_BANDS_PER_THREAD 8 // where these take little: batches that are traced together land in few of them
#define LEAST_ROWS 4

// Bands of rows of each frame. By a pixel filter, samples count in rows of several bands, and are looked at in each.
static int count_bands( const RfRenderer* r, RfFilmRange films, int per_thread )
{
    int threads = r->setup->settings.threads, live = 0, height = r->setup->sizes.height;
    int most = r->setup->sizes.filtered ? ( height + LEAST_ROWS - 1 ) / LEAST_ROWS : height;
    for ( int i = 0; i < films.count; ++i )
        live += films.films[i].frame != -1;
    if ( live == 0 || threads == 1 )
        return live > 0;
    int bands = ( per_thread * threads + live - 1 ) / live;
    return bands < most ? bands : most;
}

static RfAccumulateJob make_job( const RfRenderer* r, RfLiveFilm* film, const RfPass* pass, float worth, int band, int bands )
{
    RfAccumulateJob job = rf_accumulate_job( r, film, pass, band, bands );
    job.weight *= worth;
    return job;
}

// Band by band, with all that a band needs of the batches.
static void accumulate_bands( RfRenderer* r, const RfPass* pass, RfFilmRange films, float worth, int first, int count )
{
    int bands = count_bands( r, films, BANDS_PER_THREAD );
#pragma omp parallel num_threads( r->setup->settings.threads )
    {
        rf_set_float_mode();
        void* scratch = r->memory.accumulate_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < films.count * bands; ++i )
        {
            RfLiveFilm* film = films.films + i / bands;
            if ( film->frame == -1 )
                continue;
            RfAccumulateJob job = make_job( r, film, pass, worth, i % bands, bands );
            uint64_t landed =
                r->setup->settings.estimator->accumulate( pass->group, job, r->memory.batches + first, count, scratch );
#pragma omp atomic
            film->films[0].landed += landed;
        }
    }
}

// Some batches, as many as there are landings for in all of the films: each first for each film, then band by band.
static void accumulate_landings( RfRenderer* r, const RfPass* pass, RfFilmRange films, float worth, int first, int count )
{
    const RfEstimator* estimator = r->setup->settings.estimator;
    int bands = count_bands( r, films, LANDED_BANDS_PER_THREAD );
    void* const* batches = r->memory.batches + first;
#pragma omp parallel num_threads( r->setup->settings.threads )
    {
        rf_set_float_mode();
        void* scratch = r->memory.accumulate_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < films.count * count; ++i )
        {
            RfLiveFilm* film = films.films + i / count;
            if ( film->frame != -1 )
                estimator->land( pass->group, make_job( r, film, pass, worth, 0, 1 ), batches[i % count], scratch,
                                 r->memory.landings[i] );
        }
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < films.count * bands; ++i )
        {
            RfLiveFilm* film = films.films + i / bands;
            if ( film->frame == -1 )
                continue;
            RfAccumulateJob job = make_job( r, film, pass, worth, i % bands, bands );
            uint64_t landed = estimator->add_landings( pass->group, job, batches, r->memory.landings + i / bands * count, count );
#pragma omp atomic
            film->films[0].landed += landed;
        }
    }
}

void rf_accumulate_batches( RfRenderer* r, const RfPass* pass, RfFilmRange films, float worth, int first, int count )
{
    int at_once = r->memory.landing_slots / films.count, end = first + count;
    if ( r->memory.landing_slots == 0 )
        accumulate_bands( r, pass, films, worth, first, count );
    for ( int from = first; from < end && at_once > 0; from += at_once )
        accumulate_landings( r, pass, films, worth, from, end - from < at_once ? end - from : at_once );
}
