// The driver: windows of the path, their passes in chunks of batches, each
// harvested and then computed into the films of the frames it serves.
#include "base/system.h"
#include "reuse/render_internal.h"

#include <omp.h>
#include <string.h>

typedef struct Renderer
{
    const RfTracer* tracer;
    const RfEye* eyes;
    const int* frames; // asked for, ascending
    int frame_count;
    RfRenderSettings settings; // resolved
    RfRenderCallbacks callbacks;
    RfGroupPlan plan;
    RenderSizes sizes;
    RenderMemory memory;
    RfDelivery delivery;
    RfRayCounts rays;
    double start, last_frame; // seconds
    double batches_done, batches_all;
    int frames_done;
} Renderer;

// Was the frame asked for? The frames are in ascending order.
static bool asked_for( const Renderer* r, int frame )
{
    int low = 0, end = r->frame_count;
    while ( low < end )
    {
        int middle = low + ( end - low ) / 2;
        if ( r->frames[middle] == frame )
            return true;
        if ( r->frames[middle] < frame )
            low = middle + 1;
        else
            end = middle;
    }
    return false;
}

// The slot that holds a frame's film, −1 for a free one; NULL where none does.
static LiveFilm* find_film( const Renderer* r, int frame )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame == frame )
            return r->memory.films + i;
    }
    return NULL;
}

// The films of the asked frames that a window is the first to hold, cleared.
static void open_films( Renderer* r, int window )
{
    RfWindow group = rf_window( &r->plan, window );
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        int first, last;
        rf_windows_of_frame( &r->plan, frame, &first, &last );
        if ( first != window || !asked_for( r, frame ) )
            continue;
        LiveFilm* live = find_film( r, -1 );
        live->frame = frame;
        rf_clear_film( &live->film );
        rf_clear_layer_film( &live->layers, r->sizes.width, r->sizes.height );
    }
}

static RfFilmCombine combine_of( RfNormalize normalize )
{
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return RF_FILM_CROSSFIT;
        case RF_NORMALIZE_RATIO: return RF_FILM_RATIO;
        case RF_NORMALIZE_NONE: return RF_FILM_PLAIN;
    }
    return RF_FILM_CROSSFIT;
}

static RfResult finish_film( Renderer* r, LiveFilm* live, RfError* error )
{
    RfFilmCombine combine = combine_of( r->settings.normalize );
    RfFrameBuffer* buffer = rf_next_frame_buffer( &r->delivery );
    rf_combine_film( &live->film, combine, buffer->rgb, buffer->weight );
    double now = rf_wall_seconds();
    buffer->result = ( RfFrameResult ){
        .frame = live->frame,
        .width = r->sizes.width,
        .height = r->sizes.height,
        .rgb = buffer->rgb,
        .weight = buffer->weight,
        .seconds = now - r->last_frame,
        .relmse_estimate = rf_estimate_relmse( &live->film, combine, buffer->rgb ),
        .native_spp = rf_frame_passes( &r->plan, live->frame ),
        .effective_spp = (double)live->film.landed / ( (double)r->sizes.width * (double)r->sizes.height ),
    };
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
    {
        buffer->result.layers[l] = buffer->layers[l];
        if ( buffer->layers[l] != NULL )
            rf_finish_layer( &live->layers, (RfLayer)l, &live->film, combine, buffer->layers[l] );
    }
    r->last_frame = now;
    live->frame = -1;
    r->frames_done += 1;
    rf_deliver( &r->delivery );
    return rf_check_delivery( &r->delivery, error );
}

// Hands over the frames whose last window is done, in order.
static RfResult close_films( Renderer* r, int window, RfError* error )
{
    RfWindow group = rf_window( &r->plan, window );
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        int first, last;
        rf_windows_of_frame( &r->plan, frame, &first, &last );
        if ( last != window || !asked_for( r, frame ) )
            continue;
        RfResult result = finish_film( r, find_film( r, frame ), error );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

static bool window_wanted( const Renderer* r, RfWindow window )
{
    bool wanted = false;
    for ( int frame = window.first; frame < window.first + window.eyes && !wanted; ++frame )
        wanted = asked_for( r, frame );
    return wanted;
}

static void add_rays( RfRayCounts* sum, const RfRayCounts* part )
{
    sum->primary += part->primary;
    sum->path += part->path;
    sum->shadow += part->shadow;
    sum->tile += part->tile;
    sum->eye += part->eye;
}

// The native hits of a batch, into the layers of its own frame.
static void add_to_layers( const Renderer* r, const RfHarvest* harvest, const RfWindow* window, int eye,
                           const RfHarvestScratch* scratch )
{
    int frame = harvest->first_frame + eye;
    LiveFilm* live = find_film( r, frame );
    if ( live == NULL )
        return;
    RfLayerJob job = {
        .film = &live->layers,
        .eye = r->eyes + frame,
        .previous = frame > 0 ? r->eyes + frame - 1 : NULL,
        .next = frame + 1 < r->plan.frames ? r->eyes + frame + 1 : NULL,
        .weight = (float)window->weight,
        .weight_before = (float)( live->film.weight[0] + live->film.weight[1] ),
    };
    rf_add_to_layers( &job, scratch );
}

// Jobs [first, first + count) of a pass into the batches.
static void harvest_chunk( Renderer* r, const RfHarvest* harvest, const RfWindow* window, int pass, int first, int count )
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
            RfHarvestJob job = { ( first + i ) / r->sizes.tiles, ( first + i ) % r->sizes.tiles, pass };
            rf_harvest_batch( harvest, job, r->memory.batches + i, scratch, &mine );
            if ( ( r->settings.layers & RF_HARVESTED_LAYERS ) != 0 )
                add_to_layers( r, harvest, window, job.eye, scratch );
        }
#pragma omp critical
        add_rays( &rays, &mine );
    }
    add_rays( &r->rays, &rays );
}

// The chunk into the films: a job is some rows of one film, so no two jobs
// touch the same pixel and every pixel is added to in the batches' order.
static void compute_chunk( Renderer* r, const RfHarvest* harvest, const RfWindow* window, int half, int count )
{
    int live = 0;
    for ( int i = 0; i < r->memory.film_slots; ++i )
        live += r->memory.films[i].frame != -1;
    if ( live == 0 )
        return;
    int bands = r->sizes.shape.eq15 ? 1 : ( 2 * r->settings.threads + live - 1 ) / live;
    bands = bands < r->sizes.height ? bands : r->sizes.height;
    RfCompute compute = {
        .eyes = harvest->eyes,
        .shape = harvest->shape,
        .weights = r->settings.weights,
        .weight = (float)window->weight,
        .batches = r->memory.batches,
        .batch_count = count,
    };
#pragma omp parallel num_threads( r->settings.threads )
    {
        rf_set_float_mode();
        RfComputeScratch* scratch = r->memory.compute_scratch + omp_get_thread_num();
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < r->memory.film_slots * bands; ++i )
        {
            LiveFilm* film = r->memory.films + i / bands;
            if ( film->frame == -1 )
                continue;
            int band = i % bands;
            RfComputeJob job = {
                .eye = film->frame - harvest->first_frame,
                .first_row = (int)( (long)r->sizes.height * band / bands ),
                .end_row = (int)( (long)r->sizes.height * ( band + 1 ) / bands ),
                .film = &film->film,
                .half = half,
                .landed = film->layers.landed,
            };
            uint64_t landed = rf_compute_rows( &compute, job, film->landed_eyes, scratch );
#pragma omp atomic
            film->film.landed += landed;
        }
    }
}

static bool report_progress( Renderer* r, int count )
{
    r->batches_done += count;
    if ( r->callbacks.progress == NULL )
        return true;
    RfProgress progress = {
        .frames_done = r->frames_done,
        .frames_all = r->frame_count,
        .share = r->batches_done / r->batches_all,
        .samples = (double)r->rays.primary,
        .seconds = rf_wall_seconds() - r->start,
    };
    return r->callbacks.progress( r->callbacks.user, &progress );
}

// Which eyes' hits landed where: known by pass.
static void forget_landed_eyes( Renderer* r )
{
    size_t words = (size_t)r->sizes.width * (size_t)r->sizes.height * (size_t)rf_seen_words( r->sizes.shape.eyes );
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame != -1 )
            memset( r->memory.films[i].landed_eyes, 0, words * sizeof( uint32_t ) );
    }
}

static RfResult render_pass( Renderer* r, const RfHarvest* harvest, const RfWindow* window, int pass, RfError* error )
{
    int half = rf_half_of_pass( window, pass );
    if ( harvest->shape.eq15 )
        forget_landed_eyes( r );
    int jobs = harvest->shape.eyes * r->sizes.tiles;
    for ( int first = 0; first < jobs; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
        harvest_chunk( r, harvest, window, pass, first, count );
        compute_chunk( r, harvest, window, half, count );
        if ( !report_progress( r, count ) )
            return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted after %d of %d frames", r->frames_done, r->frame_count );
        RfResult delivered = rf_check_delivery( &r->delivery, error );
        if ( delivered != RF_OK )
            return delivered;
    }
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame != -1 )
            rf_end_film_pass( &r->memory.films[i].film, half, window->weight );
    }
    return RF_OK;
}

// A scene without lights has nothing to sample, walk or combine.
static int useful_depth( const Renderer* r )
{
    return rf_tracer_lights( r->tracer )->count > 0 ? r->settings.max_depth : 1;
}

static RfResult render_window( Renderer* r, int number, RfError* error )
{
    RfWindow window = rf_window( &r->plan, number );
    RfHarvest harvest = {
        .walk = { r->tracer, useful_depth( r ), r->settings.light_samples },
        .shape = r->sizes.shape,
        .weights = r->settings.weights,
        .seed = r->settings.seed,
        .eyes = r->eyes + window.first,
        .first_frame = window.first,
        .window = number,
    };
    harvest.shape.eyes = window.eyes;
    open_films( r, number );
    for ( int pass = 0; pass < window.passes; ++pass )
    {
        RfResult result = render_pass( r, &harvest, &window, pass, error );
        if ( result != RF_OK )
            return result;
    }
    return close_films( r, number, error );
}

static RfResult render_windows( Renderer* r, RfError* error )
{
    r->batches_all = 0.0;
    for ( int w = 0; w < r->plan.windows; ++w )
    {
        RfWindow window = rf_window( &r->plan, w );
        r->batches_all += window_wanted( r, window ) ? (double)window.passes * window.eyes * r->sizes.tiles : 0.0;
    }
    for ( int w = 0; w < r->plan.windows; ++w )
    {
        RfResult result = window_wanted( r, rf_window( &r->plan, w ) ) ? render_window( r, w, error ) : RF_OK;
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
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
static RfResult render_and_deliver( Renderer* r, RfError* error )
{
    rf_start_delivery( &r->delivery, &r->callbacks, r->memory.buffers, r->memory.buffer_count, r->settings.queue > 0 );
    RfResult result = render_windows( r, error );
    RfResult delivered = rf_end_delivery( &r->delivery, error );
    return delivered != RF_OK ? delivered : result;
}

static void fill_stats( const Renderer* r, RfRenderStats* stats )
{
    *stats = ( RfRenderStats ){
        .seconds = rf_wall_seconds() - r->start,
        .rays = r->rays,
        .peak_bytes = r->memory.arena.peak,
        .budget_bytes = r->memory.arena.budget,
        .group = r->settings.group,
        .spp = r->settings.spp,
        .threads = r->settings.threads,
    };
}

RfResult rf_render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                    const RfRenderSettings* settings, const RfRenderCallbacks* callbacks, RfRenderStats* stats,
                    RfError* error )
{
    Renderer r = { .tracer = tracer, .eyes = eyes, .frames = frames, .frame_count = frame_count };
    RfResult result = rf_resolve_settings( rf_tracer_scene( tracer ), eyes, eye_count, settings, &r.settings, error );
    if ( result == RF_OK )
        result = check_frames( frames, frame_count, eye_count, error );
    if ( result != RF_OK )
        return result;
    if ( callbacks != NULL )
        r.callbacks = *callbacks;
    r.plan = rf_plan_groups( eye_count, r.settings.group, r.settings.spp );
    r.sizes = rf_render_sizes( rf_tracer_scene( tracer ), eyes, &r.plan, frame_count, &r.settings );
    r.memory.arena = rf_create_arena( r.settings.memory );
    r.start = r.last_frame = rf_wall_seconds();
    result = rf_alloc_render_memory( &r.sizes, &r.memory, error );
    if ( result == RF_OK )
        result = render_and_deliver( &r, error );
    if ( stats != NULL )
        fill_stats( &r, stats );
    rf_free_render_memory( &r.sizes, &r.memory );
    return result;
}
