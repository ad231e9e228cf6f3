// Decides after each pass of a group whether another one is due: by error, by flicker or by time.
#include "render/stop/stop_rule.h"

#include <limits.h>
#include <math.h>

static double shares_of( const RfStopRule* rule, int group ) { return rf_group( &rule->plan, group ).passes / rule->scale; }

double rf_planned_weight( const RfStopRule* rule, int frame, int from )
{
    int first, last;
    rf_groups_of_frame( &rule->plan, frame, &first, &last );
    double sum = 0.0;
    for ( int w = from > first ? from : first; w <= last; ++w )
        sum += shares_of( rule, w ) * rf_group( &rule->plan, w ).weight;
    return sum;
}

// With these weights of both frames and of what they share. 0: the later frame has none, and none are planned yet.
static double f1_squared_of( const RfPairNow* pair, double end, double shared, double now_end )
{
    const RfFlicker* f = &pair->flicker;
    double before = pair->before->weight, now = pair->now->weight;
    if ( !( now_end > 0.0 ) )
        return 0.0;
    return f->before * before / end + f->now * now / now_end - 2.0 * f->product * before * shared / ( end * now_end );
}

// (E13) with the passes to come: those of both frames make errors and their product smaller, those of the later frame alone
// are taken as independent of what the earlier one has.
double rf_final_flicker( const RfStopRule* rule, const RfPairNow* pair )
{
    const RfFrameNoise *before = pair->before, *now = pair->now;
    int first, last;
    rf_groups_of_frame( &rule->plan, before->frame, &first, &last );
    double whole = rf_planned_weight( rule, before->frame, first );
    double both = rf_planned_weight( rule, before->frame, pair->group + 1 );
    double alone = rf_planned_weight( rule, now->frame, last > pair->group ? last + 1 : pair->group + 1 );
    double rate = before->weight / ( whole - both ); // passes of a share so far
    double end = before->weight + rate * both, shared = now->weight + rate * both, now_end = shared + rate * alone;
    double planned = f1_squared_of( pair, end, shared, now_end );
    return isnan( planned ) ? planned
                            : fmax( fmax( planned, f1_squared_of( pair, end, shared, now_end + pair->spare ) ), 0.0 ) * end;
}

// The passes of the later frame are spread unevenly where there are few, and follow what other frames need.
#define SPARE 0.25 // of what is planned for its last group, and a pass
#define MARGIN 1.1 // of F1², since the later frame is estimated again when nothing can be mended

double rf_flicker_ahead( const RfStopRule* rule, RfPairNow* pair )
{
    int first, last, next_first, next_last;
    rf_groups_of_frame( &rule->plan, pair->before->frame, &first, &last );
    rf_groups_of_frame( &rule->plan, pair->now->frame, &next_first, &next_last );
    if ( next_last > last )
        pair->spare = SPARE * pair->before->weight / ( last - first + 1 ) + rf_group( &rule->plan, next_last ).weight;
    return ( next_last > last ? MARGIN : 1.0 ) * rf_flicker_doubt( &pair->flicker ) * rf_final_flicker( rule, pair );
}

// While both are rendered the later frame shares all that it has.
RfPairNoise rf_pair_noise( const RfPairNow* pair )
{
    const RfFlicker* f = &pair->flicker;
    double doubt = rf_flicker_doubt( f ), before = pair->before->weight;
    return ( RfPairNoise ){ .variance = 0.5 * doubt * ( f->before * before + f->now * pair->now->weight ),
                            .covariance = doubt * f->product * before };
}

// v of F1² of a frame and the next (of the one before and the last) by the plan of groups.
static double planned_flicker( const RfStopRule* rule, int frame, RfPairNoise pair )
{
    frame -= !rf_share_shot( &rule->plan, frame, frame + 1 ) && rf_share_shot( &rule->plan, frame - 1, frame );
    if ( !rf_share_shot( &rule->plan, frame, frame + 1 ) ) // a single frame: as with another one like it
        return 2.0 * pair.variance;
    int first, last, next_first, next_last;
    rf_groups_of_frame( &rule->plan, frame, &first, &last );
    rf_groups_of_frame( &rule->plan, frame + 1, &next_first, &next_last );
    double whole = rf_planned_weight( rule, frame, first ), next = rf_planned_weight( rule, frame + 1, next_first );
    double shared = next_first <= last ? rf_planned_weight( rule, frame, next_first ) : 0.0;
    return fmax( pair.variance * ( 1.0 + whole / next ) - 2.0 * pair.covariance * shared / next, 0.0 );
}

double rf_late_flicker( const RfStopRule* rule, const RfFrameNoise* now, const RfFlicker* flicker )
{
    double doubt = rf_flicker_doubt( flicker ), wanted = rule->goals.flicker / doubt;
    double falls = flicker->now - 2.0 * flicker->product; // with the inverse of the weight; the rest stays
    if ( rf_flicker_f1_squared( flicker ) <= wanted || falls <= 0.0 || flicker->before >= wanted )
        return 0.0;
    return rule->goals.flicker * now->weight * falls / ( wanted - flicker->before );
}

#define LEAST_PASSES 2 // one in each half: without both there is no estimate
#define AIM 0.95       // of the wanted error: most frames are then below it at the first estimate

int rf_passes_for( const RfStopGoals* goals ) { return goals->passes > 0 ? goals->passes : LEAST_PASSES; }

RfStop rf_create_stop( const RfGroupPlan* plan, int most_spp, const RfStopGoals* goals )
{
    int share = INT_MAX / plan->eyes < 1024 ? INT_MAX / plan->eyes : 1024, least = rf_passes_for( goals );
    return ( RfStop ){ .rule = {
                           .goals = *goals,
                           .plan = rf_plan_shots( plan->cameras, plan->frames, plan->eyes / 2, share * plan->eyes ),
                           .scale = share,
                           .most = (double)most_spp / plan->eyes,
                           .least = (double)least / plan->eyes,
                       } };
}

double rf_group_units( const RfStop* stop, int group )
{
    return shares_of( &stop->rule, group ) * rf_group( &stop->rule.plan, group ).eyes;
}

RfGroup rf_group_in_work( const RfStop* stop )
{
    RfGroup group = rf_group( &stop->rule.plan, stop->group );
    group.passes = 0;
    group.passes_before = stop->passes;
    return group;
}

RfGroup rf_begin_group( RfStop* stop, int number )
{
    stop->group = number;
    stop->group_units = rf_group_units( stop, number );
    stop->group_share = 0.0;
    if ( stop->units_all <= 0.0 )
        stop->units_all = stop->units_left;
    stop->units_left -= stop->group_units;
    stop->due = 0.0;
    return rf_group_in_work( stop );
}

// The goals that frames are estimated for.
enum
{
    NOISE,
    FLICKER,
    GOALS
};

static double wanted_of( const RfStop* stop, int goal )
{
    return goal == NOISE ? stop->rule.goals.noise : stop->rule.goals.flicker;
}

// v of a frame for a goal; NaN: not known.
static double value_of( const RfFrameNoise* f, int goal )
{
    double value = goal == NOISE ? f->noise : f->flicker;
    return f->seen > 0.0 && isfinite( value ) ? value : (double)NAN;
}

// Is all known that the frame is to reach? A frame whose neighbours are not rendered has no flicker of its own.
static bool is_known( const RfStop* stop, const RfFrameNoise* f )
{
    bool noise = !isnan( value_of( f, NOISE ) ), flicker = !isnan( value_of( f, FLICKER ) );
    return stop->rule.goals.noise > 0.0 ? noise : stop->rule.goals.flicker > 0.0 && flicker;
}

// An estimate counts more the closer its frame and the more passes it is made from: with few
// passes it is noisy, and too high, since the cross-fitted quotients are noisy, too.
static double pooling_weight( const RfStop* stop, const RfFrameNoise* f, int frame )
{
    double reach = fmax( 1.0, stop->rule.plan.eyes / 4.0 ), d = ( f->frame - frame ) / reach;
    return f->seen * f->seen / ( 1.0 + d * d );
}

// Sums over the estimated and the finished frames around one.
typedef struct Pool
{
    double noise, noise_weights;
    RfPairNoise pair; // summed
    double pair_weights;
} Pool;

// Frames of other shots say nothing.
static void pool( const RfStop* stop, const RfFrameNoise* f, int frame, Pool* pool )
{
    if ( !rf_share_shot( &stop->rule.plan, f->frame, frame ) )
        return;
    double noise = value_of( f, NOISE ), weight = pooling_weight( stop, f, frame );
    if ( !isnan( noise ) )
    {
        pool->noise += weight * noise;
        pool->noise_weights += weight;
    }
    if ( f->seen > 0.0 && isfinite( f->pair.variance ) && isfinite( f->pair.covariance ) )
    {
        pool->pair.variance += weight * f->pair.variance;
        pool->pair.covariance += weight * f->pair.covariance;
        pool->pair_weights += weight;
    }
}

static Pool pool_all( const RfStop* stop, const RfNoiseEstimates* look, int frame )
{
    Pool sums = { 0 };
    for ( int i = 0; i < look->count; ++i )
        pool( stop, look->frames + i, frame, &sums );
    for ( int i = 0; i < stop->finished_count && i < RF_STOP_HISTORY; ++i )
        pool( stop, stop->finished + i, frame, &sums );
    return sums;
}

static double noise_of( const Pool* p ) { return p->noise_weights > 0.0 ? p->noise / p->noise_weights : (double)NAN; }

static RfPairNoise pair_of( const Pool* p )
{
    double w = p->pair_weights > 0.0 ? p->pair_weights : (double)NAN;
    return ( RfPairNoise ){ .variance = p->pair.variance / w, .covariance = p->pair.covariance / w };
}

// v of a frame by all that is known; NaN where nothing is.
static double pooled( const RfStop* stop, const RfNoiseEstimates* look, int goal, int frame )
{
    Pool sums = pool_all( stop, look, frame );
    return goal == NOISE ? noise_of( &sums ) : planned_flicker( &stop->rule, frame, pair_of( &sums ) );
}

// Weight that the frame needs for the hardest goal, by the pooled estimates and with `own` by its own, too; NaN: not known.
static double needed_weight( const RfStop* stop, const RfNoiseEstimates* look, const RfFrameNoise* f, bool own )
{
    double needed = (double)NAN;
    for ( int goal = 0; goal < GOALS; ++goal )
    {
        if ( wanted_of( stop, goal ) <= 0.0 )
            continue;
        double value = pooled( stop, look, goal, f->frame );
        value = own ? fmax( value, value_of( f, goal ) ) : value; // fmax takes the number of a number and NaN
        needed = fmax( needed, value / wanted_of( stop, goal ) );
    }
    return needed;
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
    rf_groups_of_frame( &stop->rule.plan, f->frame, &first, &last );
    RfGroup group = rf_group( &stop->rule.plan, look->group );
    double share = shares_of( &stop->rule, look->group ), whole = rf_planned_weight( &stop->rule, f->frame, first );
    if ( last == look->group && is_known( stop, f ) )
    {
        double needed = needed_weight( stop, look, f, true );
        double missing = missing_at_last( f, needed, group.weight, stop->rule.most * whole );
        return missing > 0.0 ? look->done + missing / group.weight : 0.0;
    }
    double needed = needed_weight( stop, look, f, false );
    double wanted = isfinite( needed ) ? needed / AIM : stop->rule.least * whole;
    wanted = fmax( stop->rule.least * whole, fmin( wanted, stop->rule.most * whole ) );
    double after = share > 0.0 ? rf_planned_weight( &stop->rule, f->frame, look->group + 1 ) / share : 0.0;
    return ( wanted - f->weight + look->done * (double)group.weight ) / ( group.weight + after );
}

// Frames that differ much in their samples share few, and flicker: with a flicker to reach, the passes of a share fall by
// no more than half over the length of a group, whatever the frames have already.
static double due_to_be_even( const RfStop* stop, const RfNoiseEstimates* look )
{
    if ( stop->rule.goals.flicker <= 0.0 || stop->rule.plan.eyes == 1 )
        return 0.0;
    return shares_of( &stop->rule, look->group ) *
           fmin( stop->last_rate * pow( 0.5, 1.0 / stop->rule.plan.eyes ), stop->rule.most );
}

// At most twice the passes that the estimates are made from: later ones are better.
static double trusted_passes( const RfStop* stop, const RfNoiseEstimates* look )
{
    int most = 0;
    for ( int i = 0; i < look->count; ++i )
        most = is_known( stop, look->frames + i ) && look->frames[i].passes > most ? look->frames[i].passes : most;
    for ( int i = 0; i < stop->finished_count && i < RF_STOP_HISTORY; ++i )
        most = stop->finished[i].passes > most ? stop->finished[i].passes : most;
    int least = rf_passes_for( &stop->rule.goals );
    return look->done + ( most > least ? most : least );
}

// What is wanted by the estimates, before it is known how far they can be trusted.
static double due_by_estimates( const RfStop* stop, const RfNoiseEstimates* look )
{
    double due = 0.0;
    for ( int i = 0; i < look->count; ++i )
        due = fmax( due, due_to_frame( stop, look, look->frames + i ) );
    return due;
}

// X with pace · ( (X − done) frames + X / share · units to come ) = what is left.
static double due_by_time( RfStop* stop, const RfNoiseEstimates* look, int done, double now )
{
    if ( stop->units_done <= 0.0 )
        return done + 1.0; // one pass, to measure the pace
    double share = shares_of( &stop->rule, look->group ), eyes = rf_group( &stop->rule.plan, look->group ).eyes;
    double left = fmax( 0.0, stop->rule.goals.seconds - now ) * stop->units_done / stop->seconds_done;
    return share > 0.0 ? ( left + done * eyes ) / ( eyes + stop->units_left / share ) : 0.0;
}

// A frame that ends here with too few passes for an estimate, or whose flicker is unknown as the film of the next one has an empty half.
static bool is_too_few( const RfStop* stop, const RfNoiseEstimates* look, int done )
{
    for ( int i = 0; i < look->count; ++i )
    {
        int first, last, passes = look->frames[i].passes;
        rf_groups_of_frame( &stop->rule.plan, look->frames[i].frame, &first, &last );
        bool paired = stop->rule.goals.flicker > 0.0 && i + 1 < look->count &&
                      look->frames[i + 1].frame == look->frames[i].frame + 1 && look->frames[i + 1].passes < passes;
        passes = paired ? look->frames[i + 1].passes : passes;
        if ( last == look->group && passes + done - look->done < rf_passes_for( &stop->rule.goals ) )
            return true;
    }
    return false;
}

int rf_passes_due( RfStop* stop, const RfNoiseEstimates* look, int done, double now )
{
    double share = shares_of( &stop->rule, look->group ), least = share * stop->rule.least, due = share * stop->rule.most;
    if ( stop->rule.goals.noise > 0.0 || stop->rule.goals.flicker > 0.0 )
    {
        due = fmax( due_by_estimates( stop, look ), due_to_be_even( stop, look ) );
        due = fmin( due, trusted_passes( stop, look ) );
    }
    if ( stop->rule.goals.seconds > 0.0 )
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

static double part_done( const RfStop* stop )
{
    double done = stop->units_all - stop->units_left - stop->group_units * ( 1.0 - stop->group_share );
    return stop->units_all > 0.0 ? done / stop->units_all : 0.0;
}

double rf_stop_share( const RfStop* stop, double now )
{
    double by_time = stop->rule.goals.seconds > 0.0 ? fmin( now / stop->rule.goals.seconds, 1.0 ) : 0.0;
    return fmax( part_done( stop ), by_time );
}

double rf_stop_left( const RfStop* stop, double now )
{
    double left = (double)NAN, done = part_done( stop );
    bool has_goal = stop->rule.goals.noise > 0.0 || stop->rule.goals.flicker > 0.0;
    if ( has_goal && stop->groups_done > 0 )
        left = now * ( 1.0 - done ) / done;
    if ( stop->rule.goals.seconds > 0.0 )
        left = fmin( left, fmax( stop->rule.goals.seconds - now, 0.0 ) ); // which is all that is known where `left` is NaN
    return left;
}

void rf_end_group( RfStop* stop, int done )
{
    stop->passes += done;
    stop->groups_done += 1;
    double share = shares_of( &stop->rule, stop->group );
    stop->last_rate = share > 0.0 ? stop->due / share : 0.0; // whole passes would never fall
    stop->owed = fmin( fmax( stop->due + stop->owed - done, 0.0 ), 1.0 );
}

// NaN of a flicker is no miss: the pair was not rendered.
RfMissed rf_note_finished( RfStop* stop, RfFrameNoise frame )
{
    RfMissed missed = {
        .noise = stop->rule.goals.noise > 0.0 && !islessequal( frame.noise, stop->rule.goals.noise * frame.weight ),
        .flicker = stop->rule.goals.flicker > 0.0 && isgreater( frame.flicker, stop->rule.goals.flicker * frame.weight )
    };
    stop->missed += missed.noise;
    stop->flicker_missed += missed.flicker;
    if ( is_known( stop, &frame ) )
        stop->finished[stop->finished_count++ % RF_STOP_HISTORY] = frame;
    return missed;
}
