// The driver: the groups of the path, their passes, and the frames they finish.
#include "base/system.h"
#include "reframe/plan.h"
#include "render/frames.h"
#include "render/pass.h"
#include "render/render_effects.h"
#include "render/settings.h"
#include "render/stop/until.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

// Never a matter of which frames are asked for.
static RfResult choose_group( const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings* settings,
                              RfError* error )
{
    if ( settings->group != RF_GROUP_AUTO )
        return RF_OK;
    RfPlan plan;
    RfResult result = rf_plan_render( tracer, eyes, eye_count, &( int ){ 0 }, 1, settings, &plan, error );
    if ( result != RF_OK )
        return result;
    settings->group = plan.rows[plan.chosen].group;
    settings->adaptive = plan.adaptive;
    return RF_OK;
}

RfResult rf_resolve_settings( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                              RfRenderSettings* resolved, RfError* error )
{
    RfResult result = rf_resolve_common( eyes, eye_count, settings, resolved, error );
    if ( result == RF_OK )
        result = rf_check_built( rf_tracer_scene( tracer ), eyes, eye_count, resolved, error );
    if ( result == RF_OK )
        result = choose_group( tracer, eyes, eye_count, resolved, error );
    if ( result != RF_OK )
        return result;
    RfGroupPlan plan = rf_plan_samples( eye_count, resolved->group, settings->spp );
    resolved->group = plan.eyes / 2;
    if ( resolved->adaptive == RF_ADAPTIVE_AUTO && plan.eyes == 1 )
        resolved->adaptive = RF_ADAPTIVE_OFF;
    if ( !rf_is_stopping( settings ) )
        resolved->spp = plan.spp;
    return RF_OK;
}

static RfResult render_passes( RfRenderer* r, const RfEstimatorGroup* estimator_group, const RfGroup* group, RfError* error )
{
    RfResult result = RF_OK;
    for ( int k = 0; k < group->passes && result == RF_OK; ++k )
    {
        RfPass pass = rf_make_pass( estimator_group, group, k );
        result = rf_render_pass( r, &pass, error );
    }
    return result;
}

static RfResult render_group( RfRenderer* r, int number, RfError* error )
{
    RfGroup group = rf_group( &r->plan, number );
    RfEstimatorGroup estimator_group = rf_estimator_group( r, number );
    estimator_group.shared = r->memory.shared;
    rf_open_films( r, number );
    RfResult result;
    if ( r->sizes.stopping )
        result = rf_render_until( r, &estimator_group, error );
    else
        result = render_passes( r, &estimator_group, &group, error );
    return result == RF_OK ? rf_close_films( r, number, error ) : result;
}

// Batches of the groups of a sweep; adds what they cost to r->stop.
static double count_batches( RfRenderer* r )
{
    double batches = 0.0;
    for ( int g = 0; g < r->plan.groups; ++g )
    {
        RfGroup group = rf_group( &r->plan, g );
        if ( !rf_group_wanted( r, group ) )
            continue;
        batches += (double)group.passes * group.eyes * r->sizes.of_estimator.jobs;
        r->stop.units_left += r->sizes.stopping ? rf_group_units( &r->stop, g ) : 0.0;
    }
    return batches;
}

// The groups that hold frames of the sweep.
static RfResult render_groups( RfRenderer* r, RfError* error )
{
    for ( int g = 0; g < r->plan.groups; ++g )
    {
        RfResult result = rf_group_wanted( r, rf_group( &r->plan, g ) ) ? render_group( r, g, error ) : RF_OK;
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
        result = render_groups( r, error );
    }
    return result;
}

// Frames, groups and sizes, as the resolved settings have them. Fails with RF_ERROR_MEMORY where no render fits the budget.
static RfResult set_up_render( RfRenderer* r, int eye_count, RfError* error )
{
    RfRenderSettings* settings = &r->settings;
    const RfScene* scene = rf_tracer_scene( r->tracer );
    r->plan = rf_plan_groups( eye_count, settings->group, settings->spp );
    if ( rf_is_stopping( settings ) )
        r->stop = rf_create_stop( &r->plan, settings->spp,
                                  &( RfStopGoals ){ .noise = settings->noise,
                                                    .flicker = settings->flicker * settings->flicker,
                                                    .seconds = settings->time * r->frames_all } );
    r->sizes = rf_render_sizes( scene, r->eyes, &r->plan, r->frames_all, settings );
    r->traits = rf_running_traits( scene, rf_scene_traits( scene, r->eyes, eye_count, settings ) );
    if ( !rf_is_plain_filter( settings ) )
        rf_make_pixel_filter( settings, &r->filter );
    r->memory.arena = rf_create_arena( settings->memory );
    r->start = r->last_frame = rf_wall_seconds();
    r->frame_count = r->frames_all;
    return rf_fit_sizes( settings->memory, r->frames_all, &r->sizes, &r->fit, error );
}

// The memory of a render that is set up; what was allocated before a failure is freed as after a render.
static RfResult alloc_render( RfRenderer* r, RfError* error )
{
    RfEstimatorGroup group = rf_frames_as_group( r, 0, r->plan.eyes, 0 );
    RfResult result = rf_alloc_render_memory( &group, &r->sizes, &r->memory, error );
    return result == RF_OK ? rf_alloc_traced_jobs( r, error ) : result;
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

// All groups, with the frames handed over as they are finished. What the
// caller says of a frame counts more than an interruption.
static RfResult render_and_deliver( RfRenderer* r, RfError* error )
{
    rf_start_frame_queue( &r->queue, &r->callbacks, r->memory.buffers, r->memory.buffer_count, r->settings.queue > 0 );
    RfResult result = render_sweeps( r, error );
    RfResult delivered = rf_end_frame_queue( &r->queue, error );
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
        .flicker_missed = r->stop.flicker_missed,
        .hurried = r->stop.hurried,
        .adaptive_frames = r->adaptive_frames,
        .entry_count = r->memory.arena.entry_count,
    };
    memcpy( stats->entries, r->memory.arena.entries, sizeof stats->entries );
}

RfResult rf_render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                    const RfRenderSettings* settings, const RfRenderCallbacks* callbacks, RfRenderStats* stats, RfError* error )
{
    RfRenderer r = { .tracer = tracer,
                     .eyes = eyes,
                     .frames = frames,
                     .frames_all = frame_count,
                     .last_relmse = (double)NAN,
                     .last_flicker = (double)NAN,
                     .kept_frame = RF_NO_FRAME };
    RfResult result = rf_resolve_settings( tracer, eyes, eye_count, settings, &r.settings, error );
    if ( result == RF_OK )
        result = check_frames( frames, frame_count, eye_count, error );
    if ( result != RF_OK )
        return result;
    if ( callbacks != NULL )
        r.callbacks = *callbacks;
    result = set_up_render( &r, eye_count, error );
    if ( result == RF_OK )
    {
        r.settings.threads = r.sizes.threads;
        int before = omp_get_max_threads();
        omp_set_num_threads( r.settings.threads ); // of loops that do not say so themselves, as in a reconstruction
        result = alloc_render( &r, error );
        if ( result == RF_OK )
            result = render_and_deliver( &r, error );
        omp_set_num_threads( before );
        free( r.traced_jobs );
    }
    if ( stats != NULL )
        fill_stats( &r, stats );
    rf_free_render_memory( &r.sizes, &r.memory );
    return result;
}
