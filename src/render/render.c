// The driver: windows of the path, their passes in chunks of batches, each
// harvested and then computed into the films of the frames it serves.
#include "base/system.h"
#include "render/adaptive.h"

#include <math.h>
#include <omp.h>
#include <string.h>

void rf_add_rays( RfRayCounts* sum, const RfRayCounts* part )
{
    sum->primary += part->primary;
    sum->path += part->path;
    sum->shadow += part->shadow;
    sum->tile += part->tile;
    sum->eye += part->eye;
}

void rf_harvest_chunk( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int pass, int first, int count )
{
    RfRayCounts rays = { 0 };
#pragma omp parallel num_threads( r->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        RfHarvestScratch* scratch = r->memory.harvest_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            RfHarvestJob job = { ( first + i ) / r->sizes.patches.count, ( first + i ) % r->sizes.patches.count, pass };
            rf_harvest_batch( harvest, job, r->memory.batches + i, scratch, &mine );
            if ( ( r->settings.layers & RF_FIRST_HIT_AOVS ) != 0 )
                rf_add_aovs( r, harvest, window, job.eye, scratch );
        }
#pragma omp critical
        rf_add_rays( &rays, &mine );
    }
    rf_add_rays( &r->rays, &rays );
}

// A job is some rows of one film, so no two jobs touch the same pixel and every
// pixel is added to in the batches' order.
void rf_accumulate_chunk( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int pass, const RfHitBatch* batches,
                          int count )
{
    int live = 0;
    for ( int i = 0; i < r->memory.film_slots; ++i )
        live += r->memory.films[i].frame != -1;
    if ( live == 0 )
        return;
    int bands = r->sizes.shape.eq15 ? 1 : ( 2 * r->settings.threads + live - 1 ) / live;
    bands = bands < r->sizes.height ? bands : r->sizes.height;
    RfAccumulate compute = {
        .eyes = harvest->eyes,
        .shape = harvest->shape,
        .weights = r->settings.weights,
        .weight = (float)window->weight,
        .batches = batches,
        .batch_count = count,
    };
#pragma omp parallel num_threads( r->settings.threads )
    {
        rf_set_float_mode();
        RfAccumulateScratch* scratch = r->memory.compute_scratch + omp_get_thread_num();
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < r->memory.film_slots * bands; ++i )
        {
            LiveFilm* film = r->memory.films + i / bands;
            if ( film->frame == -1 )
                continue;
            int band = i % bands;
            RfAccumulateJob job = {
                .eye = film->frame - harvest->first_frame,
                .first_row = (int)( (long)r->sizes.height * band / bands ),
                .end_row = (int)( (long)r->sizes.height * ( band + 1 ) / bands ),
                .film = &film->film,
                .half = rf_half_of_pass( window, pass ),
                .landed = film->layers.landed,
            };
            uint64_t landed = rf_accumulate_rows( &compute, job, film->landed_eyes, scratch );
#pragma omp atomic
            film->film.landed += landed;
        }
    }
}

static bool report_progress( RfRenderer* r, int count )
{
    r->batches_done += count;
    if ( r->callbacks.progress == NULL )
        return true;
    double seconds = rf_wall_seconds() - r->start;
    RfProgress progress = {
        .frames_done = r->frames_done,
        .frames_all = r->frames_all,
        .share = rf_is_stopping( &r->settings ) ? rf_stop_share( &r->stop, seconds ) : r->batches_done / r->batches_all,
        .samples = (double)r->rays.primary,
        .seconds = seconds,
        .relmse = r->last_relmse,
    };
    return r->callbacks.progress( r->callbacks.user, &progress );
}

// Which eyes' hits landed where: known by pass.
static void forget_landed_eyes( RfRenderer* r )
{
    size_t words = (size_t)r->sizes.width * (size_t)r->sizes.height * (size_t)rf_seen_words( r->sizes.shape.eyes );
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame != -1 )
            memset( r->memory.films[i].landed_eyes, 0, words * sizeof( uint32_t ) );
    }
}

RfResult rf_end_chunk( RfRenderer* r, int count, RfError* error )
{
    if ( !report_progress( r, count ) )
        return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted after %d of %d frames", r->frames_done, r->frames_all );
    return rf_check_frame_queue( &r->delivery, error );
}

void rf_begin_pass( RfRenderer* r, const RfHarvest* harvest )
{
    if ( harvest->shape.eq15 )
        forget_landed_eyes( r );
}

void rf_end_pass( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int pass )
{
    if ( r->settings.adaptive )
        rf_render_extra( r, harvest, window, pass, rf_half_of_pass( window, pass ) );
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame != -1 )
            rf_end_film_pass( &r->memory.films[i].film, rf_half_of_pass( window, pass ), window->weight );
    }
}

RfResult rf_render_pass( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int pass, RfError* error )
{
    rf_begin_pass( r, harvest );
    int jobs = harvest->shape.eyes * r->sizes.patches.count;
    for ( int first = 0; first < jobs; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
        rf_harvest_chunk( r, harvest, window, pass, first, count );
        rf_accumulate_chunk( r, harvest, window, pass, r->memory.batches, count );
        RfResult result = rf_end_chunk( r, count, error );
        if ( result != RF_OK )
            return result;
    }
    rf_end_pass( r, harvest, window, pass );
    return RF_OK;
}

static RfResult render_passes( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, RfError* error )
{
    RfResult result = RF_OK;
    for ( int pass = 0; pass < window->passes && result == RF_OK; ++pass )
        result = rf_render_pass( r, harvest, window, pass, error );
    return result;
}

static RfResult render_window( RfRenderer* r, int number, RfError* error )
{
    RfGroup window = rf_group( &r->plan, number );
    RfHarvest harvest = rf_group_harvest( r, number );
    rf_open_films( r, number );
    RfResult result;
    if ( rf_is_stopping( &r->settings ) )
        result = rf_render_until( r, &harvest, error );
    else
        result =
            r->settings.hold_all ? rf_render_held( r, &harvest, &window, error ) : render_passes( r, &harvest, &window, error );
    return result == RF_OK ? rf_close_films( r, number, error ) : result;
}

// And what the windows cost, for r->stop.
static double count_batches( RfRenderer* r )
{
    double batches = 0.0;
    for ( int w = 0; w < r->plan.windows; ++w )
    {
        RfGroup window = rf_group( &r->plan, w );
        if ( !rf_group_wanted( r, window ) )
            continue;
        batches += (double)window.passes * window.eyes * r->sizes.patches.count;
        r->stop.units_left += rf_is_stopping( &r->settings ) ? rf_group_units( &r->stop, w ) : 0.0;
    }
    return batches;
}

// The windows that hold frames of the sweep.
static RfResult render_windows( RfRenderer* r, RfError* error )
{
    for ( int w = 0; w < r->plan.windows; ++w )
    {
        RfResult result = rf_group_wanted( r, rf_group( &r->plan, w ) ) ? render_window( r, w, error ) : RF_OK;
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

static void begin_sweep( RfRenderer* r, const int* frames, int first )
{
    int most = r->fit.sweeps == 1 ? r->frames_all : r->fit.films;
    r->frames = frames + first;
    r->frame_count = r->frames_all - first < most ? r->frames_all - first : most;
}

// The frames in sweeps; a frame is the same whichever others are asked for.
static RfResult render_sweeps( RfRenderer* r, RfError* error )
{
    const int* frames = r->frames;
    r->batches_all = 0.0;
    for ( int first = 0; first < r->frames_all; first += r->frame_count )
    {
        begin_sweep( r, frames, first );
        r->batches_all += count_batches( r );
    }
    RfResult result = RF_OK;
    for ( int first = 0; first < r->frames_all && result == RF_OK; first += r->frame_count )
    {
        begin_sweep( r, frames, first );
        result = render_windows( r, error );
    }
    return result;
}

static RfResult check_frames( const int* frames, int frame_count, int eye_count, RfError* error )
{
    if ( frame_count < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "a render needs at least one frame" );
    for ( int k = 0; k < frame_count; ++k )
    {
        if ( frames[k] < 0 || frames[k] >= eye_count || ( k > 0 && frames[k] <= frames[k - 1] ) )
            return rf_fail( error, RF_ERROR_USAGE, "frame %d is not in the path of %d, or not in order", frames[k], eye_count );
    }
    return RF_OK;
}

// All windows, with the frames handed over as they are finished. What the
// caller says of a frame counts more than an interruption.
static RfResult render_and_deliver( RfRenderer* r, RfError* error )
{
    rf_start_frame_queue( &r->delivery, &r->callbacks, r->memory.buffers, r->memory.buffer_count, r->settings.queue > 0 );
    RfResult result = render_sweeps( r, error );
    RfResult delivered = rf_end_frame_queue( &r->delivery, error );
    return delivered != RF_OK ? delivered : result;
}

static void fill_stats( const RfRenderer* r, RfRenderStats* stats )
{
    *stats = ( RfRenderStats ){
        .seconds = rf_wall_seconds() - r->start,
        .rays = r->rays,
        .peak_bytes = r->memory.arena.peak,
        .budget_bytes = r->memory.arena.budget,
        .group = r->settings.group,
        .spp = r->settings.spp,
        .threads = r->settings.threads,
        .fit = r->fit,
        .missed = r->stop.missed,
        .hurried = r->stop.hurried,
        .entry_count = r->memory.arena.entry_count,
    };
    memcpy( stats->entries, r->memory.arena.entries, sizeof stats->entries );
}

RfResult rf_render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                    const RfRenderSettings* settings, const RfRenderCallbacks* callbacks, RfRenderStats* stats, RfError* error )
{
    RfRenderer r = { .tracer = tracer, .eyes = eyes, .frames = frames, .frames_all = frame_count, .last_relmse = (double)NAN };
    RfResult result = rf_resolve_settings( tracer, eyes, eye_count, settings, &r.settings, error );
    if ( result == RF_OK )
        result = check_frames( frames, frame_count, eye_count, error );
    if ( result != RF_OK )
        return result;
    if ( callbacks != NULL )
        r.callbacks = *callbacks;
    r.plan = rf_plan_groups( eye_count, r.settings.group, r.settings.spp );
    if ( rf_is_stopping( &r.settings ) )
        r.stop = rf_create_stop( &r.plan, r.settings.spp, r.settings.noise, r.settings.time * frame_count );
    r.sizes = rf_render_sizes( rf_tracer_scene( tracer ), eyes, &r.plan, frame_count, &r.settings );
    r.memory.arena = rf_create_arena( r.settings.memory );
    r.start = r.last_frame = rf_wall_seconds();
    r.frame_count = frame_count;
    result = r.settings.hold_all ? rf_count_held( &r, error ) : RF_OK;
    if ( result == RF_OK )
        result = rf_fit_sizes( r.settings.memory, frame_count, &r.sizes, &r.fit, error );
    if ( result != RF_OK )
    {
        if ( stats != NULL )
            fill_stats( &r, stats );
        return result;
    }
    r.settings.threads = r.sizes.threads;
    result = rf_alloc_render_memory( &r.sizes, &r.memory, error );
    if ( result == RF_OK )
        result = render_and_deliver( &r, error );
    if ( stats != NULL )
        fill_stats( &r, stats );
    rf_free_render_memory( &r.sizes, &r.memory );
    return result;
}
