#include "measure/seams.h"

// True if the frame is in full groups only, and in as many as any frame can be.
static bool is_inside( const RfGroupPlan* plan, int frame )
{
    if ( plan->groups == 1 )
        return true;
    if ( frame < 0 || frame >= plan->frames )
        return false;
    int first, last;
    rf_groups_of_frame( plan, frame, &first, &last );
    return last - first + 1 == plan->eyes && rf_group( plan, first ).eyes == plan->eyes &&
           rf_group( plan, last ).eyes == plan->eyes;
}

bool rf_is_seam( const RfSeams* seams, int frame )
{
    int index = frame - seams->first;
    if ( seams->period > 0 )
        return index % seams->period == 0;
    return seams->slides && !( is_inside( &seams->plan, index ) && is_inside( &seams->plan, index - 1 ) );
}
