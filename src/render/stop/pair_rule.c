// Predicts the flicker of a pair of frames from their noise and the passes that are still to come.
#include "render/stop/pair_rule.h"

#include <math.h>

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

double rf_planned_flicker( const RfStopRule* rule, int frame, RfPairNoise pair )
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
