#include "render/pair_rule.h"

#include <math.h>

// With these weights of both frames and of what they share.
static double f1_squared_of( const RfPairNow* pair, double end, double shared, double now_end )
{
    const RfFlicker* f = &pair->flicker;
    double before = pair->before->weight, now = pair->now->weight;
    return f->before * before / end + f->now * now / now_end - 2.0 * f->product * before * shared / ( end * now_end );
}

// (E13) with the passes to come: those of both frames make errors and their product smaller, those of the later frame alone
// are independent of what the earlier one has.
double rf_final_flicker( const RfStop* stop, const RfPairNow* pair )
{
    const RfFrameNoise *before = pair->before, *now = pair->now;
    int first, last;
    rf_groups_of_frame( &stop->plan, before->frame, &first, &last );
    double whole = rf_planned_weight( stop, before->frame, first );
    double both = rf_planned_weight( stop, before->frame, pair->group + 1 );
    double alone = rf_planned_weight( stop, now->frame, last > pair->group ? last + 1 : pair->group + 1 );
    double rate = before->weight / ( whole - both ); // passes of a share so far
    double end = before->weight + rate * both, shared = now->weight + rate * both, now_end = shared + rate * alone;
    double planned = f1_squared_of( pair, end, shared, now_end );
    return fmax( fmax( planned, f1_squared_of( pair, end, shared, now_end + pair->spare ) ), 0.0 ) * end;
}

double rf_late_flicker( const RfStop* stop, const RfFrameNoise* now, const RfFlicker* flicker )
{
    double doubt = rf_flicker_doubt( flicker ), wanted = stop->goals.flicker / doubt;
    double falls = flicker->now - 2.0 * flicker->product; // with the inverse of the weight; the rest stays
    if ( rf_flicker_f1_squared( flicker ) <= wanted || falls <= 0.0 || flicker->before >= wanted )
        return 0.0;
    return stop->goals.flicker * now->weight * falls / ( wanted - flicker->before );
}
