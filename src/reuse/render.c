#include "reuse/render.h"

#include "base/arena.h"
#include "base/system.h"
#include "reuse/compute.h"
#include "reuse/group.h"
#include "reuse/harvest.h"

#include <omp.h>
#include <string.h>

#define AUTO_GROUP 3          // what --group auto takes where memory allows
#define BATCHES_PER_THREAD 16 // in a chunk: enough to share out, few enough to stay in the cache

// A film in use, of one frame of the path.
typedef struct LiveFilm
{
    int frame; // −1: free
    RfFilm film;
    uint32_t* landed_eyes; // eq15 only
} LiveFilm;

typedef struct Renderer
{
    const RfTracer* tracer;
    const RfEye* eyes;
    const int* frames;
    int frame_count;
    RfRenderSettings settings;
    RfRenderCallbacks callbacks;
    RfGroupPlan plan;
    RfBatchShape shape;
    RfArena arena;
    int width, height, tiles;
    // memory
    RfHarvestScratch** harvest_scratch; // per thread
    RfComputeScratch* compute_scratch;  // per thread
    RfHitBatch* batches;
    int batch_slots;
    LiveFilm* films;
    int film_slots;
    float* rgb;
    float* weight;
    // where we are
    RfRayCounts rays;
    double start, last_frame;
    double batches_done, batches_all;
    int frames_done;
} Renderer;

RfRenderSettings rf_default_render_settings( void )
{
    return ( RfRenderSettings ){
        .spp = 28,
        .group = RF_GROUP_AUTO,
        .weights = RF_WEIGHTS_EXACT,
        .normalize = RF_NORMALIZE_CROSSFIT,
        .max_depth = 12,
        .light_samples = 1,
        .seed = 1,
    };
}

static RfResult check_settings( const RfRenderSettings* s, const RfEye* eyes, int eye_count, const int* frames,
                                int frame_count, RfError* error )
{
    if ( eye_count < 1 || frame_count < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "a render needs at least one frame" );
    if ( s->spp < 1 || s->spp > 1 << 20 )
        return rf_fail( error, RF_ERROR_USAGE, "samples per pixel must be 1 to 1048576, got %d", s->spp );
    if ( s->group < RF_GROUP_AUTO || s->group > 1 << 20 )
        return rf_fail( error, RF_ERROR_USAGE, "group must be 0 to 1048576, got %d", s->group );
    if ( s->max_depth < 1 || s->max_depth > 1 << 20 )
        return rf_fail( error, RF_ERROR_USAGE, "depth must be 1 to 1048576, got %d", s->max_depth );
    if ( s->light_samples < 1 || s->light_samples > 64 )
        return rf_fail( error, RF_ERROR_USAGE, "light samples must be 1 to 64, got %d", s->light_samples );
    for ( int k = 0; k < frame_count; ++k )
    {
        if ( frames[k] < 0 || frames[k] >= eye_count || ( k > 0 && frames[k] <= frames[k - 1] ) )
            return rf_fail( error, RF_ERROR_USAGE, "frame %d is not in the path of %d, or not in order", frames[k], eye_count );
    }
    for ( int k = 0; k < eye_count; ++k )
    {
        if ( eyes[k].width < 1 || eyes[k].height < 1 || eyes[k].width > 1 << 15 || eyes[k].height > 1 << 15 )
            return rf_fail( error, RF_ERROR_USAGE, "the image must be 1x1 to 32768x32768 pixels, got %dx%d", eyes[k].width,
                            eyes[k].height );
        if ( eyes[k].width != eyes[0].width || eyes[k].height != eyes[0].height )
            return rf_fail( error, RF_ERROR_USAGE, "all frames of a path must have the same size" );
    }
    return RF_OK;
}

static bool has_glossy( const RfScene* scene )
{
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        if ( scene->materials[scene->triangles.material[i]].kind != RF_BSDF_LAMBERT )
            return true;
    }
    return false;
}

// The scene has no light: nothing to sample, walk or combine beyond emission.
static int useful_depth( const RfTracer* tracer, int max_depth )
{
    return rf_tracer_lights( tracer )->count > 0 ? max_depth : 1;
}

static int films_needed( int eyes, int frame_count ) { return frame_count < eyes ? frame_count : eyes; }

// Bytes that do not depend on how much is held at once.
static size_t fixed_bytes( const Renderer* r )
{
    size_t pixels = (size_t)r->width * (size_t)r->height;
    size_t film = 2 * rf_film_half_bytes( r->width, r->height );
    if ( r->shape.eq15 )
        film += pixels * (size_t)rf_seen_words( r->shape.eyes ) * sizeof( uint32_t );
    size_t threads = (size_t)r->settings.threads;
    return (size_t)films_needed( r->shape.eyes, r->frame_count ) * film + pixels * 4 * sizeof( float ) +
           threads * ( rf_harvest_scratch_bytes( &r->shape ) + sizeof( RfComputeScratch ) ) + ( 1 << 16 );
}

static void set_shape( Renderer* r, int half_width )
{
    r->plan = rf_plan_groups( r->plan.frames, half_width, r->settings.spp );
    r->shape.eyes = r->plan.eyes;
}

// The largest group up to the usual one whose films leave room for a chunk.
static void choose_group( Renderer* r )
{
    int n = r->settings.group;
    if ( n == RF_GROUP_AUTO )
    {
        for ( n = AUTO_GROUP; n > 0; --n )
        {
            set_shape( r, n );
            if ( fixed_bytes( r ) + rf_batch_bytes( &r->shape ) <= r->settings.memory )
                break;
        }
    }
    set_shape( r, n );
}

static RfResult alloc_films( Renderer* r, RfError* error )
{
    r->film_slots = films_needed( r->shape.eyes, r->frame_count );
    RfResult result = rf_arena_alloc( &r->arena, "film table", (size_t)r->film_slots * sizeof *r->films, (void**)&r->films, error );
    if ( result != RF_OK )
        return result;
    memset( r->films, 0, (size_t)r->film_slots * sizeof *r->films );
    size_t pixels = (size_t)r->width * (size_t)r->height;
    size_t eye_words = pixels * (size_t)rf_seen_words( r->shape.eyes ) * sizeof( uint32_t );
    for ( int i = 0; i < r->film_slots && result == RF_OK; ++i )
    {
        LiveFilm* live = r->films + i;
        live->frame = -1;
        live->film.width = r->width;
        live->film.height = r->height;
        for ( int h = 0; h < 2 && result == RF_OK; ++h )
            result = rf_arena_alloc( &r->arena, "films", rf_film_half_bytes( r->width, r->height ),
                                     (void**)&live->film.half[h], error );
        if ( r->shape.eq15 && result == RF_OK )
            result = rf_arena_alloc( &r->arena, "landed eyes", eye_words, (void**)&live->landed_eyes, error );
    }
    if ( result == RF_OK )
        result = rf_arena_alloc( &r->arena, "image", pixels * 3 * sizeof( float ), (void**)&r->rgb, error );
    if ( result == RF_OK )
        result = rf_arena_alloc( &r->arena, "image", pixels * sizeof( float ), (void**)&r->weight, error );
    return result;
}

static RfResult alloc_scratch( Renderer* r, RfError* error )
{
    size_t threads = (size_t)r->settings.threads;
    RfResult result = rf_arena_alloc( &r->arena, "scratch", threads * sizeof *r->harvest_scratch, (void**)&r->harvest_scratch, error );
    if ( result != RF_OK )
        return result;
    memset( r->harvest_scratch, 0, threads * sizeof *r->harvest_scratch );
    for ( size_t t = 0; t < threads; ++t )
    {
        void* memory = NULL;
        result = rf_arena_alloc( &r->arena, "scratch", rf_harvest_scratch_bytes( &r->shape ), &memory, error );
        if ( result != RF_OK )
            return result;
        r->harvest_scratch[t] = rf_lay_out_harvest_scratch( &r->shape, memory );
    }
    return rf_arena_alloc( &r->arena, "scratch", threads * sizeof *r->compute_scratch, (void**)&r->compute_scratch, error );
}

// As many batches at once as serve the threads and fit the budget; the biased
// eq15 needs all of a pass.
static RfResult alloc_batches( Renderer* r, RfError* error )
{
    int jobs = r->shape.eyes * r->tiles;
    size_t each = rf_batch_bytes( &r->shape ) + sizeof *r->batches;
    size_t room = rf_arena_room( &r->arena ) / ( each + 64 );
    int slots = r->shape.eq15 ? jobs : r->settings.threads * BATCHES_PER_THREAD;
    slots = slots < jobs ? slots : jobs;
    if ( !r->shape.eq15 && (size_t)slots > room )
        slots = room > 1 ? (int)room : 1;
    RfResult result = rf_arena_alloc( &r->arena, "hit records", (size_t)slots * sizeof *r->batches, (void**)&r->batches, error );
    if ( result != RF_OK )
        return result;
    for ( int i = 0; i < slots; ++i )
    {
        void* memory = NULL;
        result = rf_arena_alloc( &r->arena, "hit records", rf_batch_bytes( &r->shape ), &memory, error );
        if ( result != RF_OK )
            return result;
        r->batches[i] = rf_lay_out_batch( &r->shape, memory );
        r->batch_slots = i + 1;
    }
    return RF_OK;
}

static void free_films( Renderer* r )
{
    size_t pixels = (size_t)r->width * (size_t)r->height;
    for ( int i = 0; r->films != NULL && i < r->film_slots; ++i )
    {
        for ( int h = 0; h < 2; ++h )
            rf_arena_free( &r->arena, "films", r->films[i].film.half[h], rf_film_half_bytes( r->width, r->height ) );
        rf_arena_free( &r->arena, "landed eyes", r->films[i].landed_eyes,
                       pixels * (size_t)rf_seen_words( r->shape.eyes ) * sizeof( uint32_t ) );
    }
    rf_arena_free( &r->arena, "film table", r->films, (size_t)r->film_slots * sizeof *r->films );
    rf_arena_free( &r->arena, "image", r->rgb, pixels * 3 * sizeof( float ) );
    rf_arena_free( &r->arena, "image", r->weight, pixels * sizeof( float ) );
}

static void free_all( Renderer* r )
{
    free_films( r );
    size_t threads = (size_t)r->settings.threads;
    for ( size_t t = 0; r->harvest_scratch != NULL && t < threads; ++t )
        rf_arena_free( &r->arena, "scratch", r->harvest_scratch[t], rf_harvest_scratch_bytes( &r->shape ) );
    rf_arena_free( &r->arena, "scratch", r->harvest_scratch, threads * sizeof *r->harvest_scratch );
    rf_arena_free( &r->arena, "scratch", r->compute_scratch, threads * sizeof *r->compute_scratch );
    for ( int i = 0; i < r->batch_slots; ++i )
        rf_arena_free( &r->arena, "hit records", r->batches[i].p[0], rf_batch_bytes( &r->shape ) );
    rf_arena_free( &r->arena, "hit records", r->batches, 1 );
}

// The films of the asked frames that a window holds, cleared where new.
static void open_films( Renderer* r, int window )
{
    size_t bytes = rf_film_half_bytes( r->width, r->height );
    for ( int k = 0; k < r->frame_count; ++k )
    {
        int frame = r->frames[k], first, last;
        rf_windows_of_frame( &r->plan, frame, &first, &last );
        if ( first != window )
            continue;
        LiveFilm* live = r->films;
        while ( live->frame != -1 )
            ++live;
        live->frame = frame;
        live->film.passes[0] = live->film.passes[1] = 0;
        live->film.landed = 0;
        memset( live->film.half[0], 0, bytes );
        memset( live->film.half[1], 0, bytes );
    }
}

static RfFilmCombine combine_of( const RfRenderSettings* s )
{
    if ( s->weights != RF_WEIGHTS_EXACT || s->normalize == RF_NORMALIZE_RATIO )
        return RF_FILM_RATIO; // counts of hits have no known mean
    return s->normalize == RF_NORMALIZE_NONE ? RF_FILM_PLAIN : RF_FILM_CROSSFIT;
}

static RfResult finish_film( Renderer* r, LiveFilm* live, RfError* error )
{
    RfFilmCombine combine = combine_of( &r->settings );
    rf_combine_film( &live->film, combine, r->rgb, r->weight );
    double now = rf_wall_seconds();
    RfFrameResult result = {
        .frame = live->frame,
        .width = r->width,
        .height = r->height,
        .rgb = r->rgb,
        .weight = r->weight,
        .seconds = now - r->last_frame,
        .relmse_estimate = rf_estimate_relmse( &live->film, combine, r->rgb ),
        .native_spp = rf_frame_passes( &r->plan, live->frame ),
        .effective_spp = (double)live->film.landed / ( (double)r->width * (double)r->height ),
    };
    r->last_frame = now;
    live->frame = -1;
    r->frames_done += 1;
    return r->callbacks.frame != NULL ? r->callbacks.frame( r->callbacks.user, &result, error ) : RF_OK;
}

// Hands over the frames whose last window is done, in order.
static RfResult close_films( Renderer* r, int window, RfError* error )
{
    for ( int k = 0; k < r->frame_count; ++k )
    {
        int first, last;
        rf_windows_of_frame( &r->plan, r->frames[k], &first, &last );
        if ( last != window )
            continue;
        LiveFilm* live = r->films;
        while ( live->frame != r->frames[k] )
            ++live;
        RfResult result = finish_film( r, live, error );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

static bool window_wanted( const Renderer* r, int window )
{
    for ( int k = 0; k < r->frame_count; ++k )
    {
        if ( r->frames[k] >= window && r->frames[k] < window + r->shape.eyes )
            return true;
    }
    return false;
}

static void add_rays( RfRayCounts* sum, const RfRayCounts* part )
{
    sum->primary += part->primary;
    sum->path += part->path;
    sum->shadow += part->shadow;
    sum->tile += part->tile;
    sum->eye += part->eye;
}

// Jobs [first, first + count) of a pass into the batches.
static void harvest_chunk( Renderer* r, const RfHarvest* harvest, int pass, int first, int count )
{
    RfRayCounts rays = { 0 };
#pragma omp parallel num_threads( r->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        RfHarvestScratch* scratch = r->harvest_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            RfHarvestJob job = { ( first + i ) / r->tiles, ( first + i ) % r->tiles, pass };
            rf_harvest_batch( harvest, job, r->batches + i, scratch, &mine );
        }
#pragma omp critical
        add_rays( &rays, &mine );
    }
    add_rays( &r->rays, &rays );
}

// The chunk into the films: a job is some rows of one film, so no two jobs
// touch the same pixel and every pixel is added to in the batches' order.
static void compute_chunk( Renderer* r, const RfHarvest* harvest, int half, int count )
{
    int live = 0;
    for ( int i = 0; i < r->film_slots; ++i )
        live += r->films[i].frame != -1;
    if ( live == 0 )
        return;
    int bands = r->shape.eq15 ? 1 : ( 2 * r->settings.threads + live - 1 ) / live;
    bands = bands < r->height ? bands : r->height;
    RfCompute compute = { r->eyes + harvest->first_frame, r->shape, r->settings.weights, r->batches, count };
#pragma omp parallel num_threads( r->settings.threads )
    {
        rf_set_float_mode();
        RfComputeScratch* scratch = r->compute_scratch + omp_get_thread_num();
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < r->film_slots * bands; ++i )
        {
            LiveFilm* film = r->films + i / bands;
            if ( film->frame == -1 )
                continue;
            int band = i % bands;
            RfComputeJob job = {
                .eye = film->frame - harvest->first_frame,
                .first_row = (int)( (long)r->height * band / bands ),
                .end_row = (int)( (long)r->height * ( band + 1 ) / bands ),
                .film = &film->film,
                .half = half,
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

static RfResult render_pass( Renderer* r, const RfHarvest* harvest, int pass, RfError* error )
{
    int half = rf_half_of_pass( harvest->first_frame, pass );
    for ( int i = 0; i < r->film_slots; ++i )
    {
        if ( r->films[i].frame == -1 )
            continue;
        r->films[i].film.passes[half] += 1;
        if ( r->shape.eq15 )
            memset( r->films[i].landed_eyes, 0,
                    (size_t)r->width * (size_t)r->height * (size_t)rf_seen_words( r->shape.eyes ) * sizeof( uint32_t ) );
    }
    int jobs = r->shape.eyes * r->tiles;
    for ( int first = 0; first < jobs; first += r->batch_slots )
    {
        int count = jobs - first < r->batch_slots ? jobs - first : r->batch_slots;
        harvest_chunk( r, harvest, pass, first, count );
        compute_chunk( r, harvest, half, count );
        if ( !report_progress( r, count ) )
            return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted after %d of %d frames", r->frames_done, r->frame_count );
    }
    return RF_OK;
}

static RfResult render_window( Renderer* r, int window, RfError* error )
{
    RfHarvest harvest = {
        .walk = { r->tracer, useful_depth( r->tracer, r->settings.max_depth ), r->settings.light_samples },
        .shape = r->shape,
        .weights = r->settings.weights,
        .seed = r->settings.seed,
        .eyes = r->eyes + window,
        .first_frame = window,
    };
    open_films( r, window );
    for ( int pass = 0; pass < rf_window_passes( &r->plan, window ); ++pass )
    {
        RfResult result = render_pass( r, &harvest, pass, error );
        if ( result != RF_OK )
            return result;
    }
    return close_films( r, window, error );
}

static RfResult render_windows( Renderer* r, RfError* error )
{
    r->batches_all = 0.0;
    for ( int w = 0; w < r->plan.windows; ++w )
        r->batches_all += window_wanted( r, w ) ? (double)rf_window_passes( &r->plan, w ) * r->shape.eyes * r->tiles : 0.0;
    for ( int w = 0; w < r->plan.windows; ++w )
    {
        RfResult result = window_wanted( r, w ) ? render_window( r, w, error ) : RF_OK;
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

static void set_up( Renderer* r, int eye_count )
{
    if ( r->settings.threads < 1 )
        r->settings.threads = rf_core_count();
    if ( r->settings.memory == 0 )
        r->settings.memory = rf_free_memory() / 2;
    r->width = r->eyes[0].width;
    r->height = r->eyes[0].height;
    r->tiles = rf_tile_count( r->width, r->height );
    r->arena = rf_create_arena( r->settings.memory );
    r->plan.frames = eye_count;
    r->shape.light_samples = r->settings.light_samples;
    r->shape.glossy = has_glossy( rf_tracer_scene( r->tracer ) );
    r->shape.eq15 = r->settings.weights == RF_WEIGHTS_EQ15;
    choose_group( r );
    r->start = r->last_frame = rf_wall_seconds();
}

static void fill_stats( const Renderer* r, RfRenderStats* stats )
{
    *stats = ( RfRenderStats ){
        .seconds = rf_wall_seconds() - r->start,
        .rays = r->rays,
        .peak_bytes = r->arena.peak,
        .budget_bytes = r->arena.budget,
        .group = r->plan.eyes / 2,
        .spp = r->plan.spp,
        .threads = r->settings.threads,
    };
}

RfResult rf_render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                    const RfRenderSettings* settings, const RfRenderCallbacks* callbacks, RfRenderStats* stats,
                    RfError* error )
{
    RfResult result = check_settings( settings, eyes, eye_count, frames, frame_count, error );
    if ( result != RF_OK )
        return result;
    Renderer r = { .tracer = tracer, .eyes = eyes, .frames = frames, .frame_count = frame_count, .settings = *settings };
    if ( callbacks != NULL )
        r.callbacks = *callbacks;
    set_up( &r, eye_count );
    result = alloc_films( &r, error );
    if ( result == RF_OK )
        result = alloc_scratch( &r, error );
    if ( result == RF_OK )
        result = alloc_batches( &r, error );
    if ( result == RF_OK )
        result = render_windows( &r, error );
    if ( stats != NULL )
        fill_stats( &r, stats );
    free_all( &r );
    return result;
}
