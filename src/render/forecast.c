#include "render/forecast.h"

#include "render/pair_rule.h"
#include "render/stop_plan.h"
#include "render/stop_pool.h"

#include <math.h>
#include <stdlib.h>

#define MOST_GROUPS 128 // that are gone through; those after them are taken to be like these
#define MOST_LOOKS 24   // at a group
#define WORTH 0.03      // more work, after which it is predicted anew

RfResult rf_alloc_forecast( int frames, RfForecast* f, RfError* error )
{
    f->frames = calloc( (size_t)frames, sizeof *f->frames );
    f->room = malloc( (size_t)frames * sizeof *f->room );
    return f->frames != NULL && f->room != NULL
               ? RF_OK
               : rf_fail( error, RF_ERROR_MEMORY, "no memory left to predict %d frames", frames );
}

void rf_free_forecast( RfForecast* f )
{
    free( f->frames );
    free( f->room );
    *f = ( RfForecast ){ 0 };
}

typedef struct Walk
{
    RfStop stop;
    const RfStop* now;
    const RfNoiseEstimates* known;
    RfForecastFrame* frames;
    RfFrameNoise* room;
    int group, done;
} Walk;

// F1 of frame `before` and the next by what is known of such pairs.
static RfFlicker flicker_of( const Walk* w, RfPairNoise pair, int before )
{
    const RfForecastFrame *a = w->frames + before, *b = a + 1;
    return ( RfFlicker ){ .before = pair.variance / a->weight,
                          .now = pair.variance / b->weight,
                          .product = pair.covariance * a->shared / ( a->weight * b->weight ) };
}

static RfFrameNoise noise_of( const Walk* w, int frame )
{
    RfForecastFrame* f = w->frames + frame;
    if ( !f->expects )
        f->expected = rf_expect( w->now, w->known, frame );
    f->expects = true;
    return ( RfFrameNoise ){ .frame = frame,
                             .passes = f->passes,
                             .weight = f->weight,
                             .noise = f->expected.noise,
                             .flicker = (double)NAN,
                             .pair = f->expected.pair,
                             .seen = f->passes >= 2 ? f->weight : 0.0 };
}

// NaN: not known, since the next frame has no samples yet.
static double flicker_ahead( const Walk* w, RfFrameNoise* before )
{
    if ( !( w->frames[before->frame + 1].weight > 0.0 ) )
        return (double)NAN;
    RfFrameNoise now = noise_of( w, before->frame + 1 );
    RfFlicker flicker = flicker_of( w, before->pair, before->frame );
    RfPairNow pair = { .group = w->group, .before = before, .now = &now, .flicker = flicker };
    return rf_flicker_ahead( &w->stop, &pair );
}

// As estimate_flicker in until.c has it of films.
static double flicker_at( const Walk* w, RfFrameNoise* f )
{
    int first, last, t = f->frame;
    rf_groups_of_frame( &w->stop.plan, t, &first, &last );
    RfGroup group = rf_group( &w->stop.plan, w->group );
    bool has_next = t + 1 < w->stop.plan.frames && w->frames[t + 1].asked, has_before = t > 0 && w->frames[t - 1].asked;
    double ahead = (double)NAN, behind = (double)NAN;
    if ( has_next && t + 1 < group.first + group.eyes )
        ahead = flicker_ahead( w, f );
    if ( last == w->group && has_before && w->frames[t - 1].passes >= 2 )
    {
        RfFrameNoise before = noise_of( w, t - 1 );
        RfFlicker flicker = flicker_of( w, before.pair, t - 1 );
        if ( t - 1 < group.first )
            behind = rf_late_flicker( &w->stop, f, &flicker );
        else if ( !has_next )
            behind = flicker_ahead( w, &before );
    }
    bool alone = isnan( ahead ) && ( has_next || isnan( behind ) );
    if ( alone && ( last == w->group || w->stop.plan.eyes == 1 ) )
        ahead = 2.0 * f->pair.variance;
    return fmax( ahead, behind );
}

static RfNoiseEstimates look_at( const Walk* w )
{
    RfNoiseEstimates look = { .group = w->group, .done = w->done, .frames = w->room };
    RfGroup group = rf_group( &w->stop.plan, w->group );
    for ( int t = group.first; t < group.first + group.eyes; ++t )
    {
        if ( !w->frames[t].asked )
            continue;
        RfFrameNoise* f = w->room + look.count++;
        *f = noise_of( w, t );
        if ( w->stop.goals.flicker > 0.0 && f->seen > 0.0 )
            f->flicker = flicker_at( w, f );
    }
    return look;
}

static void take_passes( Walk* w, int passes )
{
    RfGroup group = rf_group( &w->stop.plan, w->group );
    for ( int t = group.first; t < group.first + group.eyes; ++t )
    {
        w->frames[t].passes += passes;
        w->frames[t].weight += (double)passes * group.weight;
    }
    for ( int t = group.first; t + 1 < group.first + group.eyes; ++t )
        w->frames[t].shared += (double)passes * group.weight;
    w->done += passes;
}

// The rest of a group; returns its passes × eyes.
static double walk_group( Walk* w )
{
    int before = w->done;
    for ( int i = 0; i < MOST_LOOKS; ++i )
    {
        RfNoiseEstimates look = look_at( w );
        int due = rf_passes_due( &w->stop, &look, w->done, 0.0 );
        if ( due <= w->done )
            break;
        take_passes( w, due - w->done );
    }
    rf_end_group( &w->stop, w->done );
    return ( w->done - before ) * (double)rf_group( &w->stop.plan, w->group ).eyes;
}

static bool is_wanted( const Walk* w, RfGroup group )
{
    for ( int t = group.first; t < group.first + group.eyes; ++t )
    {
        if ( w->frames[t].asked )
            return true;
    }
    return false;
}

static void start_walk( Walk* w )
{
    RfGroup group = rf_group( &w->stop.plan, w->group );
    for ( int t = 0; t < w->stop.plan.frames; ++t )
    {
        bool alive = t >= group.first && t < group.first + group.eyes;
        RfForecastFrame* f = w->frames + t;
        f->expects = false;
        if ( alive || t < group.first )
            continue;
        f->passes = 0;
        f->weight = f->shared = 0.0;
    }
    // while both are rendered the later frame shares all that it has
    for ( int i = 0; i < w->known->count; ++i )
    {
        const RfFrameNoise* known = w->known->frames + i;
        RfForecastFrame* f = w->frames + known->frame;
        f->passes = known->passes;
        f->weight = known->weight;
        f->shared = 0.0;
        if ( known->frame > 0 )
            f[-1].shared = known->weight;
    }
}

void rf_forecast( RfStop* stop, const RfNoiseEstimates* look, int done, RfForecast* forecast )
{
    if ( look->count == 0 || !rf_is_any_known( stop, look ) )
        return;
    if ( stop->work < ( 1.0 + WORTH ) * stop->predicted_at )
        return;
    Walk w = { .stop = *stop,
               .now = stop,
               .known = look,
               .frames = forecast->frames,
               .room = forecast->room,
               .group = look->group,
               .done = done };
    w.stop.goals.seconds = 0.0;
    w.stop.finished_count = 0;
    start_walk( &w );
    double work = walk_group( &w ), units = 0.0, ahead = 0.0;
    for ( int g = look->group + 1, count = 0; g < stop->plan.groups && count < MOST_GROUPS; ++g )
    {
        if ( !is_wanted( &w, rf_group( &stop->plan, g ) ) )
            continue;
        count += 1;
        units += rf_group_units( stop, g );
        rf_begin_group( &w.stop, g );
        w.group = g;
        w.done = 0;
        ahead += walk_group( &w );
    }
    // those of further sweeps, too
    stop->work_left = work + ( units > 0.0 ? ahead * stop->units_left / units : 0.0 );
    stop->predicted_at = stop->work;
}
