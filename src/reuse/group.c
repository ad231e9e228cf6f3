#include "reuse/group.h"

RfGroupPlan rf_plan_groups( int frames, int half_width, int spp )
{
    RfGroupPlan plan = { .frames = frames };
    plan.eyes = half_width <= ( frames - 1 ) / 2 ? 2 * half_width + 1 : frames;
    plan.windows = frames - plan.eyes + 1;
    if ( plan.windows == 1 )
    {
        plan.passes = plan.end_passes = plan.spp = spp;
        return plan;
    }
    plan.passes = ( spp - 1 ) / plan.eyes + 1;
    plan.spp = plan.passes * plan.eyes;
    plan.end_passes = plan.spp;
    return plan;
}

int rf_window_passes( const RfGroupPlan* plan, int window )
{
    return window == 0 || window == plan->windows - 1 ? plan->end_passes : plan->passes;
}

void rf_windows_of_frame( const RfGroupPlan* plan, int frame, int* first, int* last )
{
    *first = frame >= plan->eyes ? frame - plan->eyes + 1 : 0;
    *last = frame < plan->windows ? frame : plan->windows - 1;
}

int rf_frame_passes( const RfGroupPlan* plan, int frame )
{
    int first, last, sum = 0;
    rf_windows_of_frame( plan, frame, &first, &last );
    for ( int w = first; w <= last; ++w )
        sum += rf_window_passes( plan, w );
    return sum;
}
