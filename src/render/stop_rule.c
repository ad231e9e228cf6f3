#include "render/stop_rule.h"

#include <limits.h>
#include <math.h>

#define LEAST_PASSES 2 // one in each half: without both there is no estimate
#define AIM 0.95       // of the wanted error: most frames are then below it at the first estimate

RfStop rf_create_stop( const RfGroupPlan* plan, int most_spp, double noise, double seconds )
{
    int share = INT_MAX / plan->eyes < 1024 ? INT_MAX / plan->eyes : 1024;
    return ( RfStop ){
        .noise = noise,
        .seconds = seconds,
        .plan = rf_plan_groups( plan->frames, plan->eyes / 2, share * plan->eyes ),
        .scale = share,
        .most = (double)most_spp / plan->eyes,
        .least = (double)LEAST_PASSES / plan->eyes,
    };
}

static double share_of( const RfStop* stop, int group ) { return rf_group( &stop->plan, group ).passes / stop->scale; }

double rf_group_units( const RfStop* stop, int group ) { return share_of( stop, group ) * rf_group( &stop->plan, group ).eyes; }

RfGroup rf_begin_group( RfStop* stop, int number )
{
    RfGroup group = rf_group( &stop->plan, number );
    group.passes = 0;
    group.passes_before = stop->passes;
    stop->group_units = rf_group_units( stop, number );
    stop->group_share = 0.0;
    if ( stop->units_all <= 0.0 )
        stop->units_all = stop->units_left;
    stop->units_left -= stop->group_units;
    stop->due = 0.0;
    return group;
}

// Weight of a frame's groups from `from` on for one pass a share.
static double planned_weight( const RfStop* stop, int frame, int from )
{
    int first, last;
    rf_groups_of_frame( &stop->plan, frame, &first, &last );
    double sum = 0.0;
    for ( int w = from > first ? from : first; w <= last; ++w )
        sum += share_of( stop, w ) * rf_group( &stop->plan, w ).weight;
    return sum;
}

static bool is_known( const RfFrameNoise* f ) { return f->seen > 0.0 && isfinite( f->noise ); }

// An estimate counts more the closer its frame and the more passes it is made from: with few
// passes it is noisy, and too high, since the cross-fitted quotients are noisy, too.
static void pool( const RfStop* stop, const RfFrameNoise* f, int frame, double* sum, double* weights )
{
    if ( !is_known( f ) )
        return;
    double reach = fmax( 1.0, stop->plan.eyes / 4.0 ), d = ( f->frame - frame ) / reach;
    double weight = f->seen * f->seen / ( 1.0 + d * d );
    *sum += weight * f->noise;
    *weights += weight;
}

double rf_pooled_noise( const RfStop* stop, const RfNoiseEstimates* look, int frame )
{
    double sum = 0.0, weights = 0.0;
    for ( int i = 0; i < look->count; ++i )
        pool( stop, look->frames + i, frame, &sum, &weights );
    for ( int i = 0; i < stop->finished_count && i < RF_STOP_HISTORY; ++i )
        pool( stop, stop->finished + i, frame, &sum, &weights );
    return weights > 0.0 ? sum / weights : (double)NAN;
}

// Weight that a frame still needs in its last group.
static double missing_at_last( const RfStop* stop, const RfFrameNoise* f, double pooled, double weight_of_pass, double most )
{
    double noise = fmax( f->noise, pooled );
    if ( noise <= stop->noise * f->weight )
        return 0.0;
    double missing = fmax( noise / stop->noise - f->weight, fmax( weight_of_pass, f->weight / 32.0 ) );
    return fmin( missing, fmax( 0.0, most - f->weight ) );
}

// Passes of this group, including those done, that one of its frames needs: as many
// per share as in its groups to come.
static double due_to_frame( const RfStop* stop, const RfNoiseEstimates* look, const RfFrameNoise* f )
{
    int first, last;
    rf_groups_of_frame( &stop->plan, f->frame, &first, &last );
    RfGroup group = rf_group( &stop->plan, look->group );
    double share = share_of( stop, look->group ), whole = planned_weight( stop, f->frame, first );
    double pooled = rf_pooled_noise( stop, look, f->frame );
    if ( last == look->group && is_known( f ) )
    {
        double missing = missing_at_last( stop, f, pooled, group.weight, stop->most * whole );
        return missing > 0.0 ? look->done + missing / group.weight : 0.0;
    }
    double wanted = isfinite( pooled ) ? pooled / ( AIM * stop->noise ) : stop->least * whole;
    wanted = fmax( stop->least * whole, fmin( wanted, stop->most * whole ) );
    double after = share > 0.0 ? planned_weight( stop, f->frame, look->group + 1 ) / share : 0.0;
    return ( wanted - f->weight + look->done * (double)group.weight ) / ( group.weight + after );
}

// At most twice the passes that the estimates are made from: later ones are better.
static double trusted_passes( const RfStop* stop, const RfNoiseEstimates* look )
{
    int most = 0;
    for ( int i = 0; i < look->count; ++i )
        most = is_known( look->frames + i ) && look->frames[i].passes > most ? look->frames[i].passes : most;
    for ( int i = 0; i < stop->finished_count && i < RF_STOP_HISTORY; ++i )
        most = stop->finished[i].passes > most ? stop->finished[i].passes : most;
    return look->done + ( most > LEAST_PASSES ? most : LEAST_PASSES );
}

static double due_by_noise( const RfStop* stop, const RfNoiseEstimates* look )
{
    double due = 0.0;
    for ( int i = 0; i < look->count; ++i )
        due = fmax( due, due_to_frame( stop, look, look->frames + i ) );
    return fmin( due, trusted_passes( stop, look ) );
}

// X with pace · ( (X − done) eyes + X / share · units to come ) = what is left.
static double due_by_time( RfStop* stop, const RfNoiseEstimates* look, int done, double now )
{
    if ( stop->units_done <= 0.0 )
        return done + 1.0; // one pass, to measure the pace
    double share = share_of( stop, look->group ), eyes = rf_group( &stop->plan, look->group ).eyes;
    double left = fmax( 0.0, stop->seconds - now ) * stop->units_done / stop->seconds_done;
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
    double share = share_of( stop, look->group ), least = share * stop->least, due = share * stop->most;
    if ( stop->noise > 0.0 )
        due = due_by_noise( stop, look );
    if ( stop->seconds > 0.0 )
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

double rf_stop_share( const RfStop* stop, double now )
{
    double done = stop->units_all - stop->units_left - stop->group_units * ( 1.0 - stop->group_share );
    double by_work = stop->units_all > 0.0 ? done / stop->units_all : 0.0;
    double by_time = stop->seconds > 0.0 ? fmin( now / stop->seconds, 1.0 ) : 0.0;
    return fmax( by_work, by_time );
}

void rf_end_group( RfStop* stop, int done )
{
    stop->passes += done;
    stop->owed = fmin( fmax( stop->due + stop->owed - done, 0.0 ), 1.0 );
}

bool rf_note_finished( RfStop* stop, RfFrameNoise frame )
{
    bool reached = stop->noise <= 0.0 || frame.noise <= stop->noise * frame.weight;
    stop->missed += !reached;
    if ( is_known( &frame ) )
        stop->finished[stop->finished_count++ % RF_STOP_HISTORY] = frame;
    return reached;
}
