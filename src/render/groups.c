// Sliding groups of consecutive frames, and how the samples of a frame divide among its groups' passes.
#include "render/groups.h"

#include "base/fault.h"

#include <math.h>
#include <stdbool.h>

RfGroupPlan rf_plan_groups( int frames, int half_width, int spp )
{
    RfGroupPlan plan = { .frames = frames, .spp = spp };
    plan.eyes = half_width <= ( frames - 1 ) / 2 || RF_FAULT( group_in_path ) ? 2 * half_width + 1 : frames;
    if ( plan.eyes == frames )
    {
        plan.groups = 1;
        plan.passes = plan.end_passes = spp;
        return plan;
    }
    if ( plan.eyes > 1 && plan.eyes > ( frames - 1 ) / 2 )
    {
        plan.cut = plan.eyes - 1;
        plan.groups = frames + plan.cut;
        return plan;
    }
    plan.groups = frames - plan.eyes + 1;
    plan.passes = ( spp - 1 ) / plan.eyes + 1;
    plan.spp = plan.end_passes = plan.passes * plan.eyes;
    return plan;
}

// Passes of the cut groups of 1 … m frames, where a full one of N gets one:
// Σ (N/m)^0.9, as the integral over m from ½ to m + ½. With (N/m)^1 the ends
// would get as many samples as the middle, own-frame and reused, and cost 10 %
// more; with (N/m)^¾ their error was up to 1.38 times the middle's.
static double cut_passes( const RfGroupPlan* plan, int m )
{
    double n = plan->eyes;
    return 10.0 * pow( n, 0.9 ) * ( pow( m + 0.5, 0.1 ) - pow( 0.5, 0.1 ) );
}

// Passes of the groups with a lower number, where groups are cut: shares of
// whole passes go to the group in which they are full.
static int64_t passes_before( const RfGroupPlan* plan, int number )
{
    int full_end = plan->frames, left = number < plan->cut ? number : plan->cut;
    double sum = cut_passes( plan, left );
    if ( number > plan->cut )
        sum += ( number < full_end ? number : full_end ) - plan->cut;
    if ( number > full_end )
        sum += cut_passes( plan, plan->cut ) - cut_passes( plan, plan->cut - ( number - full_end ) );
    return (int64_t)floor( sum * plan->spp / plan->eyes + 0.5 );
}

RfGroup rf_group( const RfGroupPlan* plan, int number )
{
    if ( plan->cut > 0 )
    {
        int first = number - plan->cut, end = first + plan->eyes;
        int64_t before = passes_before( plan, number );
        first = first > 0 ? first : 0;
        end = end < plan->frames ? end : plan->frames;
        return ( RfGroup ){
            .first = first,
            .eyes = end - first,
            .passes = (int)( passes_before( plan, number + 1 ) - before ),
            .weight = end - first, // samples that land in a pixel per pass
            .passes_before = before,
        };
    }
    bool at_end = number == 0 || number == plan->groups - 1;
    int64_t before = number == 0 ? 0 : plan->end_passes + ( number - 1 ) * (int64_t)plan->passes;
    return ( RfGroup ){
        .first = number,
        .eyes = plan->eyes,
        .passes = at_end ? plan->end_passes : plan->passes,
        .weight = 1,
        .passes_before = before,
    };
}

void rf_groups_of_frame( const RfGroupPlan* plan, int frame, int* first, int* last )
{
    int start = frame + plan->cut, end = plan->groups - 1;
    *first = start >= plan->eyes ? start - plan->eyes + 1 : 0;
    *last = start < end ? start : end;
}

int rf_frame_passes( const RfGroupPlan* plan, int frame )
{
    int first, last;
    rf_groups_of_frame( plan, frame, &first, &last );
    RfGroup end = rf_group( plan, last );
    return (int)( end.passes_before - rf_group( plan, first ).passes_before ) + end.passes;
}

int64_t rf_most_passes( const RfGroupPlan* plan )
{
    if ( plan->groups == 1 )
        return plan->passes;
    if ( plan->cut > 0 ) // the end frames lie in the shortest groups
        return passes_before( plan, plan->eyes ) + 1;
    return (int64_t)plan->end_passes + (int64_t)( plan->eyes - 1 ) * plan->passes;
}

void rf_add_group_samples( const RfGroupPlan* plan, const int* frames, int first, int end, double* samples, double* others )
{
    int done = 0;
    for ( int i = first; i < end; ++i )
    {
        int group, last;
        rf_groups_of_frame( plan, frames[i], &group, &last );
        for ( group = group > done ? group : done; group <= last; ++group )
        {
            RfGroup w = rf_group( plan, group );
            *samples += (double)w.passes * w.eyes;
            *others += (double)w.passes * w.eyes * ( w.eyes - 1 );
        }
        done = last + 1 > done ? last + 1 : done;
    }
}
