// The driver: the groups of the path, their passes, and the frames they finish.
#include "base/system.h"
#include "reframe/plan.h"
#include "render/frames.h"
#include "render/guide_pilot.h"
#include "render/pass.h"
#include "render/settings.h"
#include "render/state.h"
#include "trace/trace.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Group and tile, where they are to be chosen: never a matter of which frames are asked for.
static RfResult choose( const RfShot* shot, const RfRenderSettings* asked, RfRenderSettings* settings, RfError* error )
{
    bool group = settings->group == RF_GROUP_AUTO,
         tile = asked->tile.kind == RF_TILE_AUTO && settings->estimator->count_tiles != NULL;
    if ( !group && !tile )
        return RF_OK;
    RfShot first = { shot->tracer, shot->eyes, shot->eye_count, &( int ){ 0 }, 1 };
    RfPlan plan;
    RfResult result =
        group ? rf_plan_render( &first, asked, &plan, error ) : rf_plan_group( &first, asked, settings->group, &plan, error );
    if ( result != RF_OK && ( group || result != RF_ERROR_MEMORY ) )
        return result;
    const RfPlanRow* row = plan.rows + ( group || plan.count == 0 ? plan.chosen : plan.count - 1 );
    if ( group )
    {
        settings->group = row->group;
        settings->adaptive = plan.adaptive;
    }
    if ( tile ) // the least memory is wanted where the group does not fit
        settings->tile = result == RF_OK && rf_plan_row_fits( row ) ? row->tile : ( RfTile ){ RF_TILE_NONE, 1, 1 };
    return RF_OK;
}

RfResult rf_resolve_settings( const RfShot* shot, const RfRenderSettings* settings, RfRenderSettings* resolved, RfError* error )
{
    RfResult result = rf_resolve_common( shot, settings, resolved, error );
    if ( result == RF_OK )
        result = rf_check_built( shot, resolved, error );
    if ( result == RF_OK )
        result = choose( shot, settings, resolved, error );
    if ( result != RF_OK )
        return result;
    RfGroupPlan plan = rf_plan_samples( shot, resolved->group, settings->spp );
    resolved->group = plan.eyes / 2;
    if ( resolved->adaptive == RF_ADAPTIVE_AUTO && plan.eyes == 1 )
        resolved->adaptive = RF_ADAPTIVE_OFF;
    if ( !rf_is_stopping( settings ) )
        resolved->spp = plan.spp;
    return RF_OK;
}

// Batches of the groups of a sweep; adds what they cost to r->stop.
static double count_batches( RfRenderer* r )
{
    double batches = 0.0;
    for ( int g = 0; g < r->setup->plan.groups; ++g )
    {
        RfGroup group = rf_group( &r->setup->plan, g );
        if ( !rf_group_wanted( r, group ) )
            continue;
        batches += (double)group.passes * group.eyes * r->setup->sizes.of_estimator.jobs;
        r->stop.units_left += r->setup->sizes.stopping ? rf_group_units( &r->stop, g ) : 0.0;
    }
    return batches;
}

// The groups that hold frames of the sweep.
static RfResult render_groups( RfRenderer* r, RfError* error )
{
    for ( int g = r->resuming ? r->at.group : 0; g < r->setup->plan.groups; ++g )
    {
        RfResult result = rf_group_wanted( r, rf_group( &r->setup->plan, g ) ) ? rf_render_group( r, g, error ) : RF_OK;
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

static void begin_sweep( RfRenderer* r, int first )
{
    const RfShot* shot = &r->setup->shot;
    int left = shot->frame_count - first, most = r->setup->fit.sweeps == 1 ? left : r->setup->fit.films;
    most = first == 0 && r->first_sweep > 0 ? r->first_sweep : most;
    r->sweep = ( RfSweep ){ .frames = shot->frames + first, .count = left < most ? left : most };
}

static void count_all_batches( RfRenderer* r )
{
    for ( int first = 0; first < r->setup->shot.frame_count; first += r->sweep.count )
    {
        begin_sweep( r, first );
        r->batches_all += count_batches( r );
    }
}

// The frames in sweeps; a frame is the same whichever others are asked for.
static RfResult render_sweeps( RfRenderer* r, RfError* error )
{
    RfResult result = RF_OK;
    if ( r->setup->callbacks.load != NULL )
        result = rf_load_state( r, error );
    else
        count_all_batches( r );
    for ( int first = 0; first < r->setup->shot.frame_count && result == RF_OK; first += r->sweep.count )
    {
        begin_sweep( r, first );
        result = render_groups( r, error );
    }
    return result;
}

static RfStop make_stop( const RfRenderSetup* setup )
{
    const RfRenderSettings* settings = &setup->settings;
    bool judged = settings->noise > 0.0 && setup->callbacks.judge != NULL;
    return rf_create_stop( &setup->plan, settings->spp,
                           &( RfStopGoals ){ .noise = settings->noise,
                                             .flicker = settings->flicker * settings->flicker,
                                             .passes = judged ? RF_LEAST_DENOISED_PASSES : 0,
                                             .seconds = settings->time * setup->shot.frame_count } );
}

// Groups, sizes and threads, as the resolved settings have them. Fails with RF_ERROR_MEMORY where no render fits the budget.
static RfResult set_up_render( RfRenderSetup* setup, RfError* error )
{
    RfRenderSettings* settings = &setup->settings;
    const RfShot* shot = &setup->shot;
    const RfScene* scene = rf_tracer_scene( shot->tracer );
    setup->plan = rf_plan_shots( shot->eyes, shot->eye_count, settings->group, settings->spp );
    setup->sizes = rf_render_sizes( scene, shot->eyes, &setup->plan, shot->frame_count, settings );
    setup->traits = rf_running_traits( scene, rf_scene_traits( scene, shot->eyes, shot->eye_count, settings ) );
    if ( !rf_is_plain_filter( settings ) )
        rf_make_pixel_filter( settings, &setup->filter );
    RfResult result = rf_fit_sizes( settings->memory, shot->frame_count, &setup->sizes, &setup->fit, error );
    if ( result == RF_OK )
        settings->threads = setup->sizes.threads;
    return result;
}

// Splits the light by the groups that are asked for.
static RfResult split_light( RfRenderSetup* setup, RfError* error )
{
    const RfShot* shot = &setup->shot;
    if ( setup->settings.light_groups == NULL )
        return RF_OK;
    RfResult result =
        rf_find_light_groups( rf_tracer_scene( shot->tracer ), setup->settings.light_groups, &setup->groups, error );
    for ( int g = 0; g < setup->groups.count && result == RF_OK; ++g )
    {
        size_t size = sizeof RF_LIGHT_LAYER + strlen( setup->groups.names[g] );
        setup->group_names[g] = malloc( size );
        if ( setup->group_names[g] == NULL )
            result = rf_fail( error, RF_ERROR_MEMORY, "out of memory for the names of light groups" );
        else
            snprintf( setup->group_names[g], size, RF_LIGHT_LAYER "%s", setup->groups.names[g] );
    }
    if ( result == RF_OK && setup->groups.count > 0 )
        result = rf_create_split_tracer( shot->tracer, &setup->groups, &setup->split, error );
    setup->shot.tracer = setup->split != NULL ? setup->split : shot->tracer;
    return result;
}

static void join_light( RfRenderSetup* setup )
{
    rf_destroy_split_tracer( setup->split );
    for ( int g = 0; g < RF_LIGHT_GROUPS_MOST; ++g )
        free( setup->group_names[g] );
    rf_destroy_light_groups( &setup->groups );
}

// The memory of a render that is set up; what was allocated before a failure is freed as after a render.
static RfResult alloc_render( RfRenderer* r, RfError* error )
{
    RfResult result = rf_compile_groups( r, error );
    if ( result != RF_OK )
        return result;
    RfEstimatorGroup group = rf_frames_as_group( r, 0, r->setup->plan.eyes, 0 );
    result = rf_alloc_render_memory( &group, &r->setup->sizes, &r->memory, error );
    if ( result == RF_OK )
        result = rf_make_surface_tables( rf_tracer_scene( r->setup->shot.tracer ), &r->setup->settings, &r->surfaces, error );
    return result == RF_OK ? rf_alloc_traced_jobs( r, error ) : result;
}

static RfResult check_frames( const RfShot* shot, RfError* error )
{
    if ( shot->frame_count < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "a render needs at least one frame" );
    for ( int k = 0; k < shot->frame_count; ++k )
    {
        int frame = shot->frames[k];
        if ( frame < 0 || frame >= shot->eye_count || ( k > 0 && frame <= shot->frames[k - 1] ) )
            return rf_fail( error, RF_ERROR_USAGE, "frame %d is not in the path of %d, or not in order", frame, shot->eye_count );
    }
    return RF_OK;
}

// All groups, with the frames handed over as they are finished. What the
// caller says of a frame counts more than an interruption.
static RfResult render_and_deliver( RfRenderer* r, RfError* error )
{
    rf_start_frame_queue( &r->queue, &r->setup->callbacks, r->memory.buffers, r->memory.buffer_count,
                          r->setup->settings.queue > 0 );
    RfResult result = render_sweeps( r, error );
    RfResult delivered = rf_end_frame_queue( &r->queue, error );
    if ( delivered == RF_OK && result == RF_ERROR_INTERRUPTED && r->setup->callbacks.save != NULL )
        rf_save_state( r, &( RfError ){ 0 } );
    return delivered != RF_OK ? delivered : result;
}

static void fill_stats( const RfRenderer* r, RfRenderStats* stats )
{
    *stats = ( RfRenderStats ){
        .seconds = rf_wall_seconds() - r->start,
        .rays = r->rays,
        .peak_bytes = r->memory.arena.peak,
        .budget_bytes = r->memory.arena.budget,
        .group = r->setup->settings.group,
        .spp = r->setup->settings.spp,
        .threads = r->setup->settings.threads,
        .fit = r->setup->fit,
        .missed = r->stop.missed,
        .flicker_missed = r->stop.flicker_missed,
        .hurried = r->stop.hurried,
        .adaptive_frames = r->adaptive_frames,
        .guide_tables = r->guide != NULL ? r->guide->table_count : 0,
        .clamp = r->clamps != NULL ? (double)r->clamps[*r->setup->shot.frames].threshold[RF_CLAMP_PATHS] : 0.0,
        .clamp_chains = r->clamps != NULL ? (double)r->clamps[*r->setup->shot.frames].threshold[RF_CLAMP_CHAINS] : 0.0,
        .entry_count = r->memory.arena.entry_count,
    };
    memcpy( stats->entries, r->memory.arena.entries, sizeof stats->entries );
}

static RfRenderer make_renderer( const RfRenderSetup* setup )
{
    double now = rf_wall_seconds();
    RfRenderer r = { .setup = setup, .start = now, .last_frame = now, .kept_frame = RF_NO_FRAME };
    r.last_relmse = r.last_flicker = (double)NAN;
    r.memory.arena = rf_create_arena( setup->settings.memory );
    if ( rf_is_stopping( &setup->settings ) )
        r.stop = make_stop( setup );
    return r;
}

// `guide`: takes what was learned to guide paths, and nothing is rendered; NULL: all is.
static RfResult render( const RfShot* shot, const RfRenderSettings* settings, const RfRenderCallbacks* callbacks,
                        RfRenderStats* stats, RfGuide** guide, RfError* error )
{
    RfRenderSetup setup = { .shot = *shot };
    RfResult result = rf_resolve_settings( shot, settings, &setup.settings, error );
    if ( result == RF_OK )
        result = check_frames( shot, error );
    if ( result != RF_OK )
        return result;
    if ( callbacks != NULL )
        setup.callbacks = *callbacks;
    result = split_light( &setup, error );
    if ( result == RF_OK )
        result = set_up_render( &setup, error );
    RfRenderer r = make_renderer( &setup );
    if ( result == RF_OK )
    {
        int before = omp_get_max_threads();
        omp_set_num_threads( setup.settings.threads ); // of loops that do not say so themselves, as in a reconstruction
        result = alloc_render( &r, error );
        if ( result == RF_OK )
            result = rf_create_worlds( &setup.shot, setup.sizes.worlds, rf_follows_motion( &setup.settings ), &r.worlds, error );
        if ( result == RF_OK )
            result = rf_find_guide( &r, error );
        if ( result == RF_OK && guide == NULL )
            result = rf_find_clamps( &r, error );
        if ( result == RF_OK && guide == NULL )
            result = render_and_deliver( &r, error );
        rf_destroy_worlds( &r.worlds );
        omp_set_num_threads( before );
        free( r.traced_jobs );
        free( r.compiled );
        rf_destroy_surface_tables( &r.surfaces );
    }
    if ( stats != NULL )
        fill_stats( &r, stats );
    free( r.clamps );
    if ( guide != NULL && result == RF_OK )
        *guide = r.learned;
    else
        rf_destroy_guide( r.learned );
    rf_free_render_memory( &setup.sizes, &r.memory );
    join_light( &setup );
    return result;
}

RfResult rf_render( const RfShot* shot, const RfRenderSettings* settings, const RfRenderCallbacks* callbacks,
                    RfRenderStats* stats, RfError* error )
{
    return render( shot, settings, callbacks, stats, NULL, error );
}

RfResult rf_guide_parts( const RfShot* shot, const RfRenderSettings* settings, RfRenderSettings* parts, RfGuide** guide,
                         RfError* error )
{
    *guide = NULL;
    *parts = *settings;
    if ( settings->guide == RF_GUIDE_OFF || !settings->estimator->guides )
        return RF_OK;
    RfRenderSettings own = *settings;
    own.group = 0; // the guide does not depend on these, but for the rounding of samples by groups
    own.tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
    own.adaptive = RF_ADAPTIVE_OFF;
    own.clamp = own.clamp_chains = 0.0;
    own.aovs = 0;
    own.light_groups = NULL;
    own.cryptomatte = 0;
    RfResult result = render( shot, &own, NULL, NULL, guide, error );
    parts->learned = *guide;
    parts->guide = *guide != NULL ? RF_GUIDE_AUTO : RF_GUIDE_OFF;
    return result;
}

void rf_forget_guide( RfGuide* guide ) { rf_destroy_guide( guide ); }
