#include "render/stop_rule.h"

#include "render/stop_plan.h"
#include "render/stop_pool.h"

#include <limits.h>
#include <math.h>

#define LEAST_PASSES 2 // one in each half: without both there is no estimate
#define AIM 0.95       // of the wanted error: most frames are then below it at the first estimate

RfStop rf_create_stop( const RfGroupPlan* plan, int most_spp, const RfStopGoals* goals )
{
    int share = INT_MAX / plan->eyes < 1024 ? INT_MAX / plan->eyes : 1024;
    return ( RfStop ){
        .goals = *goals,
        .plan = rf_plan_groups( plan->frames, plan->eyes / 2, share * plan->eyes ),
        .scale = share,
        .most = (double)most_spp / plan->eyes,
        .least = (double)LEAST_PASSES / plan->eyes,
    };
}

double rf_group_units( const RfStop* stop, int group )
{
    return rf_shares_of( stop, group ) * rf_group( &stop->plan, group ).eyes;
}

RfGroup rf_begin_group( RfStop* stop, int number )
{
    RfGroup group = rf_group( &stop->plan, number );
    group.passes = 0;
    group.passes_before = stop->passes;
    stop->group = number;
    stop->group_units = rf_group_units( stop, number );
    stop->group_share = 0.0;
    if ( stop->units_all <= 0.0 )
        stop->units_all = stop->units_left;
    stop->units_left -= stop->group_units;
    stop->due = 0.0;
    return group;
}

// Weight that a frame still needs in its last group.
static double missing_at_last( const RfFrameNoise* f, double needed, double weight_of_pass, double most )
{
    if ( needed <= f->weight )
        return 0.0;
    double missing = fmax( needed - f->weight, fmax( weight_of_pass, f->weight / 32.0 ) );
    return fmin( missing, fmax( 0.0, most - f->weight ) );
}

// Passes of this group, including those done, that one of its frames needs: as many
// per share as in its groups to come.
static double due_to_frame( const RfStop* stop, const RfNoiseEstimates* look, const RfFrameNoise* f )
{
    int first, last;
    rf_groups_of_frame( &stop->plan, f->frame, &first, &last );
    RfGroup group = rf_group( &stop->plan, look->group );
    double share = rf_shares_of( stop, look->group ), whole = rf_planned_weight( stop, f->frame, first );
    if ( last == look->group && rf_is_known( stop, f ) )
    {
        double needed = rf_needed_weight( stop, look, f, true );
        double missing = missing_at_last( f, needed, group.weight, stop->most * whole );
        return missing > 0.0 ? look->done + missing / group.weight : 0.0;
    }
    double needed = rf_needed_weight( stop, look, f, false );
    double wanted = isfinite( needed ) ? needed / AIM : stop->least * whole;
    wanted = fmax( stop->least * whole, fmin( wanted, stop->most * whole ) );
    double after = share > 0.0 ? rf_planned_weight( stop, f->frame, look->group + 1 ) / share : 0.0;
    return ( wanted - f->weight + look->done * (double)group.weight ) / ( group.weight + after );
}

// Frames that differ much in their samples share few, and flicker: with a flicker to reach, the passes of a share fall by
// no more than half over the length of a group, whatever the frames have already.
static double due_to_be_even( const RfStop* stop, const RfNoiseEstimates* look )
{
    if ( stop->goals.flicker <= 0.0 || stop->plan.eyes == 1 )
        return 0.0;
    return rf_shares_of( stop, look->group ) * fmin( stop->last_rate * pow( 0.5, 1.0 / stop->plan.eyes ), stop->most );
}

// At most twice the passes that the estimates are made from: later ones are better.
static double trusted_passes( const RfStop* stop, const RfNoiseEstimates* look )
{
    int most = 0;
    for ( int i = 0; i < look->count; ++i )
        most = rf_is_known( stop, look->frames + i ) && look->frames[i].passes > most ? look->frames[i].passes : most;
    for ( int i = 0; i < stop->finished_count && i < RF_STOP_HISTORY; ++i )
        most = stop->finished[i].passes > most ? stop->finished[i].passes : most;
    return look->done + ( most > LEAST_PASSES ? most : LEAST_PASSES );
}

// What is wanted by the estimates, before it is known how far they can be trusted.
static double due_by_estimates( const RfStop* stop, const RfNoiseEstimates* look )
{
    double due = 0.0;
    for ( int i = 0; i < look->count; ++i )
        due = fmax( due, due_to_frame( stop, look, look->frames + i ) );
    return due;
}

// X with pace · ( (X − done) eyes + X / share · units to come ) = what is left.
static double due_by_time( RfStop* stop, const RfNoiseEstimates* look, int done, double now )
{
    if ( stop->units_done <= 0.0 )
        return done + 1.0; // one pass, to measure the pace
    double share = rf_shares_of( stop, look->group ), eyes = rf_group( &stop->plan, look->group ).eyes;
    double left = fmax( 0.0, stop->goals.seconds - now ) * stop->units_done / stop->seconds_done;
    return share > 0.0 ? ( left + done * eyes ) / ( eyes + stop->units_left / share ) : 0.0;
}

// A frame that ends here with a half of its film empty.
static bool is_too_few( const RfStop* stop, const RfNoiseEstimates* look, int done )
{
    for ( int i = 0; i < look->count; ++i )
    {
        int first, last;
        rf_groups_of_frame( &stop->plan, look->frames[i].frame, &first, &last );
        if ( last == look->group && look->frames[i].passes + done - look->done < LEAST_PASSES )
            return true;
    }
    return false;
}

int rf_passes_due( RfStop* stop, const RfNoiseEstimates* look, int done, double now )
{
    double share = rf_shares_of( stop, look->group ), least = share * stop->least, due = share * stop->most;
    if ( stop->goals.noise > 0.0 || stop->goals.flicker > 0.0 )
    {
        due = fmax( due_by_estimates( stop, look ), due_to_be_even( stop, look ) );
        due = fmin( due, trusted_passes( stop, look ) );
    }
    if ( stop->goals.seconds > 0.0 )
    {
        double by_time = due_by_time( stop, look, done, now );
        stop->hurried = stop->hurried || ( by_time < least && due > least && now > 0.0 && stop->units_done > 0.0 );
        due = fmin( due, by_time );
    }
    stop->due = fmax( due, least );
    stop->group_share = stop->due > 0.0 ? fmin( done / stop->due, 1.0 ) : 1.0;
    int whole = (int)fmin( floor( stop->due + stop->owed + 1e-9 ), INT_MAX );
    return whole <= done && is_too_few( stop, look, done ) ? done + 1 : whole;
}

void rf_note_pass( RfStop* stop, int eyes, double now )
{
    // pace of about the last twenty passes: it differs along the path
    stop->seconds_done = 0.95 * stop->seconds_done + ( now - stop->last );
    stop->units_done = 0.95 * stop->units_done + eyes;
    stop->last = now;
}

// The part of the shares that is done.
static double part_done( const RfStop* stop )
{
    double done = stop->units_all - stop->units_left - stop->group_units * ( 1.0 - stop->group_share );
    return stop->units_all > 0.0 ? done / stop->units_all : 0.0;
}

double rf_stop_share( const RfStop* stop, double now )
{
    double by_time = stop->goals.seconds > 0.0 ? fmin( now / stop->goals.seconds, 1.0 ) : 0.0;
    return fmax( part_done( stop ), by_time );
}

double rf_stop_left( const RfStop* stop, double now )
{
    double left = (double)NAN, done = part_done( stop );
    bool has_goal = stop->goals.noise > 0.0 || stop->goals.flicker > 0.0;
    if ( has_goal && stop->groups_done > 0 )
        left = now * ( 1.0 - done ) / done;
    if ( stop->goals.seconds > 0.0 )
        left = fmin( left, fmax( stop->goals.seconds - now, 0.0 ) ); // which is all that is known where `left` is NaN
    return left;
}

void rf_end_group( RfStop* stop, int done )
{
    stop->passes += done;
    stop->groups_done += 1;
    double share = rf_shares_of( stop, stop->group );
    stop->last_rate = share > 0.0 ? stop->due / share : 0.0; // whole passes would never fall
    stop->owed = fmin( fmax( stop->due + stop->owed - done, 0.0 ), 1.0 );
}

// NaN of a flicker is no miss: the pair was not rendered.
RfMissed rf_note_finished( RfStop* stop, RfFrameNoise frame )
{
    RfMissed missed = { .noise = stop->goals.noise > 0.0 && !islessequal( frame.noise, stop->goals.noise * frame.weight ),
                        .flicker = stop->goals.flicker > 0.0 && isgreater( frame.flicker, stop->goals.flicker * frame.weight ) };
    stop->missed += missed.noise;
    stop->flicker_missed += missed.flicker;
    if ( rf_is_known( stop, &frame ) )
        stop->finished[stop->finished_count++ % RF_STOP_HISTORY] = frame;
    return missed;
}
