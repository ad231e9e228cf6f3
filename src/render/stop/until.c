// What the stop rule decides by, taken from the films and the clock.
#include "render/stop/until.h"

#include "base/system.h"
#include "render/frames.h"
#include "render/stop/stop_rule.h"

#include <math.h>

static RfFrameNoise known_of( const RfLiveFilm* live )
{
    const RfFilm* film = live->films;
    return ( RfFrameNoise ){ .frame = live->frame,
                             .passes = film->passes[0] + film->passes[1],
                             .weight = film->weight[0] + film->weight[1],
                             .noise = live->noise,
                             .flicker = live->flicker,
                             .pair = live->pair,
                             .seen = live->noise_seen };
}

// v of F1², to stop by: what a frame of group `number` and the one after it will be.
static double flicker_ahead( const RfRenderer* r, int number, RfLiveFilm* live, RfNormalize normalize )
{
    const RfLiveFilm* next = rf_find_film( r, live->frame + 1 );
    if ( next == NULL )
        return (double)NAN;
    RfFrameNoise before = known_of( live ), now = known_of( next );
    RfPairNow pair = {
        .group = number, .before = &before, .now = &now, .flicker = rf_flicker_of_films( live->films, next->films, normalize )
    };
    live->pair = rf_pair_noise( &pair );
    return rf_flicker_ahead( &r->stop.rule, &pair );
}

// What the frame before, which may be finished, asks of a frame in its last group.
static double flicker_behind( const RfRenderer* r, int number, const RfLiveFilm* live, RfNormalize normalize )
{
    RfFrameNoise now = known_of( live );
    RfLiveFilm* before = rf_find_film( r, live->frame - 1 );
    if ( before != NULL )
        return flicker_ahead( r, number, before, normalize );
    if ( !rf_is_kept_before( r, live->frame ) )
        return (double)NAN;
    RfFlicker flicker = rf_flicker_since( r->memory.kept_errors, live->films, normalize );
    return rf_late_flicker( &r->stop.rule, &now, &flicker );
}

// A frame whose neighbours are rendered later without sharing passes with it, or not at all, is held to what two
// independent frames like it would have.
static double flicker_of_two( RfLiveFilm* live, RfNormalize normalize )
{
    live->pair = ( RfPairNoise ){ .variance = rf_film_mean_square( live->films, normalize ) * known_of( live ).weight };
    return 2.0 * live->pair.variance;
}

static double estimate_flicker( const RfRenderer* r, int number, RfLiveFilm* live )
{
    int first, last;
    rf_groups_of_frame( &r->setup->plan, live->frame, &first, &last );
    RfNormalize normalize = r->setup->settings.normalize;
    double ahead = flicker_ahead( r, number, live, normalize ), behind = (double)NAN;
    bool has_next = rf_is_asked( r, live->frame + 1 ) && rf_share_shot( &r->setup->plan, live->frame, live->frame + 1 );
    if ( last == number && ( !has_next || rf_is_kept_before( r, live->frame ) ) )
        behind = flicker_behind( r, number, live, normalize );
    bool alone = isnan( ahead ) && ( has_next || isnan( behind ) );
    if ( alone && ( last == number || r->setup->plan.eyes == 1 ) )
        ahead = flicker_of_two( live, normalize );
    return fmax( ahead, behind );
}

// A judge takes time: none is asked as long as the noise is so many times what is wanted.
#define MOST_GAIN 30.0

static bool is_judged( const RfRenderer* r ) { return r->setup->callbacks.judge != NULL && r->setup->settings.noise > 0.0; }

// v of what is made of the picture in the buffer.
static double judge( const RfRenderer* r, const RfLiveFilm* live, RfFrameBuffer* buffer )
{
    RfFrameResult* frame = &buffer->result;
    *frame = ( RfFrameResult ){ .frame = live->frame,
                                .width = r->setup->sizes.width,
                                .height = r->setup->sizes.height,
                                .rgb = buffer->rgb,
                                .native_spp = rf_native_spp( r, live->films ) };
    rf_finish_aovs( r, live, RF_DENOISE_AOVS | RF_AOV_BIT( RF_AOV_HALF ), buffer );
    RfJudged judged = r->setup->callbacks.judge( r->setup->callbacks.user, frame );
    double wanted = r->setup->settings.noise;
    return live->noise_seen * wanted * pow( judged.relmse / wanted, 1.0 / judged.exponent );
}

// The picture is made in a buffer that waits for the next frame.
static void estimate_noise( RfRenderer* r, RfLiveFilm* live )
{
    RfFrameBuffer* buffer = rf_next_frame_buffer( &r->queue );
    RfRelmse relmse = rf_finish_picture( r, live, &( RfPicture ){ .rgb = buffer->rgb } );
    live->noise_seen = live->films->weight[0] + live->films->weight[1];
    live->noise = live->noise_seen * rf_prudent_relmse( &relmse );
    if ( !is_judged( r ) )
        return;
    if ( rf_prudent_relmse( &relmse ) > MOST_GAIN * r->setup->settings.noise )
        live->noise /= MOST_GAIN;
    else
        live->noise = fmin( live->noise, judge( r, live, buffer ) );
}

static void estimate( RfRenderer* r, int number, RfLiveFilm* live )
{
    if ( r->setup->settings.noise > 0.0 )
        estimate_noise( r, live );
    live->noise_seen = live->films->weight[0] + live->films->weight[1];
    if ( r->setup->settings.flicker > 0.0 )
        live->flicker = estimate_flicker( r, number, live );
}

// Estimates take time: they are made where they decide, and for enough others to predict the frames to come; by a judge, which
// takes more, for others only as long as none is finished.
static bool wants_estimate( const RfRenderer* r, const RfNoiseEstimates* estimates, int i )
{
    int first, last;
    rf_groups_of_frame( &r->setup->plan, estimates->frames[i].frame, &first, &last );
    bool as_good = estimates->frames[i].passes >= estimates->frames[0].passes;
    bool few = is_judged( r );
    return last == estimates->group || ( i == estimates->count / 2 && !( few && r->stop.finished_count > 0 ) ) ||
           ( i == estimates->count - 1 && as_good && !few );
}

// The films of a group after `done` passes of it.
static RfNoiseEstimates estimate_films( RfRenderer* r, int number, int done )
{
    RfFrameNoise* frames = r->memory.noise_estimates;
    RfNoiseEstimates estimates = { .group = number, .done = done, .frames = frames };
    RfGroup group = rf_group( &r->setup->plan, number );
    bool has_goal = r->setup->settings.noise > 0.0 || r->setup->settings.flicker > 0.0;
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        const RfLiveFilm* live = rf_find_film( r, frame );
        if ( live == NULL )
            continue;
        frames[estimates.count++] = known_of( live );
    }
    for ( int i = 0; i < estimates.count && has_goal; ++i )
    {
        if ( frames[i].passes < rf_passes_for( &r->stop.rule.goals ) || !wants_estimate( r, &estimates, i ) )
            continue;
        RfLiveFilm* live = rf_find_film( r, frames[i].frame );
        if ( live->noise_seen != frames[i].weight ) // new samples since the last estimate
            estimate( r, number, live );
        frames[i] = known_of( live );
    }
    return estimates;
}

// Decides how many passes are due, and after how many the next decision is.
static bool is_more_due( RfRenderer* r )
{
    RfUntil* u = &r->until;
    u->due = rf_passes_due( &r->stop, &u->estimates, u->done, rf_wall_seconds() - r->start );
    u->next = r->stop.rule.goals.seconds > 0.0 ? u->done + 1 : u->due;
    return u->due > u->done;
}

RfGroup rf_begin_until( RfRenderer* r, int number )
{
    if ( r->resuming )
        return rf_group_in_work( &r->stop );
    r->until = ( RfUntil ){ 0 };
    return rf_begin_group( &r->stop, number );
}

bool rf_is_pass_due( RfRenderer* r, int number )
{
    RfUntil* u = &r->until;
    if ( u->done < u->next )
        return true;
    if ( u->next == u->due )
        u->estimates = estimate_films( r, number, u->done );
    return is_more_due( r );
}

void rf_note_group_pass( RfRenderer* r, int eyes )
{
    rf_note_pass( &r->stop, eyes, rf_wall_seconds() - r->start );
    r->until.done += 1;
}

void rf_end_until( RfRenderer* r, int number )
{
    if ( is_judged( r ) )
        estimate_films( r, number, r->until.done );
    rf_end_group( &r->stop, r->until.done );
}
