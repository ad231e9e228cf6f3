// Renders the passes of a group: batches are traced in parallel and accumulated in a fixed order.
#include "render/pass.h"

#include "base/system.h"
#include "render/accumulation.h"
#include "render/adaptive/adaptive.h"
#include "render/frames.h"
#include "render/preview.h"
#include "render/settings.h"
#include "render/state.h"
#include "render/stop/until.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// NULL where nothing moves, or the frame is not open.
static const RfScene* world_scene( const RfRenderer* r, int frame )
{
    const RfTracer* tracer = rf_world_tracer( &r->worlds, frame );
    return tracer != NULL ? rf_tracer_scene( tracer ) : NULL;
}

// The first hits of the batch just traced, into the AOVs of its own frame.
static void add_aovs( RfRenderer* r, const RfPass* pass, int eye, const void* batch, const void* scratch, void* user )
{
    (void)batch;
    (void)user;
    int frame = pass->group->first_frame + eye;
    RfLiveFilm* live = rf_find_film( r, frame );
    if ( live == NULL )
        return;
    RfAovJob job = {
        .film = &live->aovs,
        .eye = r->setup->shot.eyes + frame,
        .others = { rf_share_shot( &r->setup->plan, frame, frame - 1 ) ? r->setup->shot.eyes + frame - 1 : NULL,
                    rf_share_shot( &r->setup->plan, frame, frame + 1 ) ? r->setup->shot.eyes + frame + 1 : NULL },
        .scene = world_scene( r, frame ),
        .scenes = { world_scene( r, frame - 1 ), world_scene( r, frame + 1 ) },
        .weight = (float)pass->weight,
        .weight_before = (float)( live->films[0].weight[0] + live->films[0].weight[1] ),
    };
    rf_add_to_aovs( &job, r->setup->settings.estimator->first_hits( scratch ) );
}

// After all batches of a pass are traced: spreads what they left in the AOVs, where there is a pixel filter.
static void filter_aovs( RfRenderer* r, const RfPass* pass )
{
    if ( !r->setup->sizes.filtered || ( r->setup->settings.aovs & RF_FILTERED_AOVS ) == 0 )
        return;
    int height = r->setup->sizes.height, bands = r->setup->settings.threads < height ? r->setup->settings.threads : height;
#pragma omp parallel for num_threads( r->setup->settings.threads ) schedule( dynamic, 1 )
    for ( int i = 0; i < r->memory.film_slots * bands; ++i )
    {
        const RfLiveFilm* live = r->memory.films + i / bands;
        int band = i % bands;
        rf_set_float_mode();
        if ( live->frame != -1 )
            rf_spread_aovs( &live->aovs, r->setup->sizes.width, height, (float)pass->weight, height * band / bands,
                            height * ( band + 1 ) / bands );
    }
}

// What is left takes as long as what is done did, in proportion to its batches.
static double seconds_left( const RfRenderer* r, double seconds )
{
    if ( r->setup->sizes.stopping )
        return rf_stop_left( &r->stop, seconds );
    return seconds * ( r->batches_all - r->batches_done ) / r->batches_done;
}

static bool report_progress( RfRenderer* r, int count )
{
    r->batches_done += count;
    if ( r->setup->callbacks.progress == NULL )
        return true;
    double seconds = rf_wall_seconds() - r->start, left = seconds_left( r, seconds );
    double share = r->setup->sizes.stopping ? rf_stop_share( &r->stop, seconds ) : r->batches_done / r->batches_all;
    r->share = fmax( r->share, isfinite( left ) ? seconds / ( seconds + left ) : share ); // never backwards
    RfProgress progress = {
        .frames_done = r->frames_done,
        .frames_all = r->setup->shot.frame_count,
        .share = r->share,
        .left = left,
        .samples = (double)r->rays.primary,
        .seconds = seconds,
        .relmse = r->last_relmse,
        .relmse_is_lower_bound = r->last_is_lower_bound,
        .flicker = r->last_flicker,
        .flicker_is_lower_bound = r->last_flicker_is_lower_bound,
    };
    return r->setup->callbacks.progress( r->setup->callbacks.user, &progress );
}

// Saves the state where the caller wants it. What fails there is the caller's, but for frames that it did not take.
static RfResult save_if_asked( RfRenderer* r, RfError* error )
{
    const RfRenderCallbacks* callbacks = &r->setup->callbacks;
    if ( callbacks->saves == NULL || !callbacks->saves( callbacks->user, rf_state_bytes( r ) ) )
        return RF_OK;
    RfResult result = rf_drain_frame_queue( &r->queue, error );
    RfError own = { 0 };
    if ( result == RF_OK && rf_save_state( r, &own ) == RF_OK )
        callbacks->save( callbacks->user, NULL, 0, &own );
    return result;
}

// Fails where the caller interrupts, or failed to take a frame.
static RfResult end_chunk( RfRenderer* r, int count, RfError* error )
{
    if ( !report_progress( r, count ) )
        return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted after %d of %d frames", r->frames_done,
                        r->setup->shot.frame_count );
    RfResult result = rf_check_frame_queue( &r->queue, error );
    return result == RF_OK ? save_if_asked( r, error ) : result;
}

RfResult rf_alloc_traced_jobs( RfRenderer* r, RfError* error )
{
    if ( r->setup->settings.pieces == NULL )
        return RF_OK;
    size_t jobs = (size_t)r->setup->plan.eyes * (size_t)r->setup->sizes.of_estimator.jobs;
    r->traced_jobs = malloc( jobs * sizeof *r->traced_jobs );
    return r->traced_jobs != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "out of memory for a list of %zu batches", jobs );
}

// The jobs of a pass that have something to trace; returns how many.
static int list_jobs( RfRenderer* r, const RfPass* pass )
{
    const RfEstimator* estimator = r->setup->settings.estimator;
    int jobs = r->setup->sizes.of_estimator.jobs, all = pass->group->eye_count * jobs, count = 0;
    if ( r->traced_jobs == NULL )
        return all;
    for ( int i = 0; i < all; ++i )
    {
        r->traced_jobs[count] = i;
        count += estimator->is_traced( pass->group, ( RfTraceJob ){ i / jobs, i % jobs, pass->number } );
    }
    r->batches_done += all - count;
    return count;
}

// Do extra samples take the memory of batches after each pass?
static bool has_extra( const RfRenderer* r )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        const RfLiveFilm* live = r->memory.films + i;
        if ( live->frame != -1 && r->setup->sizes.adaptive && ( live->most_need > 0.0f || live->most_glints > 0.0f ) )
            return true;
    }
    return false;
}

// Extra samples of a pass whose batches are all in the films; then it counts.
static void end_pass( RfRenderer* r, const RfPass* pass )
{
    filter_aovs( r, pass );
    if ( r->setup->sizes.adaptive )
        rf_render_extra( r, pass );
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        RfLiveFilm* live = r->memory.films + i;
        for ( int f = 0; f < r->setup->sizes.film_count && live->frame != -1; ++f )
            rf_end_film_pass( live->films + f, pass->half, pass->weight );
    }
    rf_show_preview( r );
    r->at.pass += 1;
    r->at.batches = 0;
}

// The pass that the next batches are of, where each has so many; the one before it is over if it has all of them.
static RfPass next_pass( RfRenderer* r, const RfEstimatorGroup* estimator_group, const RfGroup* group, int jobs )
{
    RfPass pass = rf_make_pass( estimator_group, group, r->at.pass );
    if ( r->at.batches < jobs )
        return pass;
    end_pass( r, &pass );
    return rf_make_pass( estimator_group, group, r->at.pass );
}

// Phase 2: adds `count` batches, from that at r->at on, to all films. The last pass that this completes is not over yet: an
// interrupted render goes on from there.
static void accumulate_chunk( RfRenderer* r, const RfEstimatorGroup* estimator_group, const RfGroup* group, int jobs, int count )
{
    RfFilmRange films = { r->memory.films, r->memory.film_slots };
    for ( int done = 0; done < count; )
    {
        RfPass pass = next_pass( r, estimator_group, group, jobs );
        int left = jobs - r->at.batches, part = left < count - done ? left : count - done;
        rf_accumulate_batches( r, &pass, films, 1.0f, done, part );
        r->at.batches += part;
        done += part;
    }
}

RfResult rf_render_group( RfRenderer* r, int number, RfError* error )
{
    const RfRenderSetup* setup = r->setup;

    // ---- frames: the films of those that are asked for, and the world as it is in each
    r->at.group = number;
    if ( !r->resuming )
        rf_open_films( r, number );
    RfEstimatorGroup estimator_group = rf_estimator_group( r, number );
    estimator_group.shared = r->memory.shared;
    RfResult result = rf_check_worlds( &r->worlds, error );
    if ( result != RF_OK )
        return result;

    // ---- passes: as many as are planned, or as goals ask for after each
    RfGroup group = setup->sizes.stopping ? rf_begin_until( r, number ) : rf_group( &setup->plan, number );
    bool one_by_one = setup->sizes.passes == 1 || has_extra( r );
    RfTracedFn* traced = ( setup->settings.aovs & RF_FIRST_HIT_AOVS ) != 0 ? add_aovs : NULL;
    if ( !r->resuming )
        r->at.pass = r->at.batches = 0;
    r->resuming = false;
    while ( setup->sizes.stopping ? rf_is_pass_due( r, number ) : r->at.pass < group.passes )
    {
        // ---- one or more of them begin: what all of their batches share, as light paths
        int end = one_by_one ? r->at.pass + 1 : group.passes, left;
        RfPass pass = rf_make_pass( &estimator_group, &group, r->at.pass );
        if ( r->memory.shared != NULL )
            setup->settings.estimator->prepare( &estimator_group, pass.number, r->memory.shared, &r->rays );
        int jobs = list_jobs( r, &pass );

        // ---- their batches, in chunks of as many as there is memory for: harvest, then accumulation
        while ( ( left = ( end - r->at.pass ) * jobs - r->at.batches ) > 0 )
        {
            int count = left < r->memory.batch_slots ? left : r->memory.batch_slots;
            pass = next_pass( r, &estimator_group, &group, jobs );
            rf_trace_batches( r, &pass, r->at.batches, count, traced, NULL );
            accumulate_chunk( r, &estimator_group, &group, jobs, count );
            result = end_chunk( r, count, error );
            if ( result != RF_OK )
                return result;
        }

        // ---- the last one is over: extra samples, the error so far
        pass = rf_make_pass( &estimator_group, &group, r->at.pass );
        end_pass( r, &pass );
        if ( setup->sizes.stopping )
            rf_note_group_pass( r, group.eyes );
    }
    if ( setup->sizes.stopping )
        rf_end_until( r, number );

    // ---- frames that no later group sees are finished
    return rf_close_films( r, number, error );
}
