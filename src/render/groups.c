// Sliding groups of consecutive frames, and how the samples of a frame divide among its groups' passes.
#include "render/groups.h"

#include "base/fault.h"

#include <math.h>

// Frames [first, end) between two cuts.
typedef struct Stretch
{
    int first, end;
} Stretch;

// The first frame of this shot or a later one: the numbers of shots ascend.
static int find_shot( const RfEye* cameras, int frames, int64_t shot )
{
    int low = 0, end = frames;
    while ( low < end )
    {
        int middle = low + ( end - low ) / 2;
        if ( cameras[middle].shot < shot )
            low = middle + 1;
        else
            end = middle;
    }
    return low;
}

static Stretch shot_around( const RfEye* cameras, int frames, int frame )
{
    int64_t shot = cameras[frame].shot;
    return ( Stretch ){ find_shot( cameras, frames, shot ), find_shot( cameras, frames, shot + 1 ) };
}

void rf_shot_of_frame( const RfGroupPlan* plan, int frame, int* first, int* end )
{
    Stretch shot = plan->cameras != NULL ? shot_around( plan->cameras, plan->frames, frame ) : ( Stretch ){ 0, plan->frames };
    *first = shot.first;
    *end = shot.end;
}

void rf_frames_around( const RfGroupPlan* plan, int frame, int* first, int* count )
{
    int start, end;
    rf_shot_of_frame( plan, frame, &start, &end );
    *count = *count < end - start ? *count : end - start;
    *first = frame - *count / 2;
    *first = *first < end - *count ? *first : end - *count;
    *first = *first > start ? *first : start;
}

bool rf_share_shot( const RfGroupPlan* plan, int frame, int other )
{
    if ( frame < 0 || other < 0 || frame >= plan->frames || other >= plan->frames )
        return false;
    return plan->cameras == NULL || plan->cameras[frame].shot == plan->cameras[other].shot;
}

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

RfGroupPlan rf_plan_shots( const RfEye* cameras, int frames, int half_width, int spp )
{
    if ( cameras == NULL || cameras[0].shot == cameras[frames - 1].shot )
        return rf_plan_groups( frames, half_width, spp );
    RfGroupPlan plan = { .frames = frames, .spp = spp, .groups = 2 * frames, .cameras = cameras };
    for ( int frame = 0; frame < frames; )
    {
        Stretch shot = shot_around( cameras, frames, frame );
        RfGroupPlan part = rf_plan_groups( shot.end - frame, half_width, spp );
        plan.eyes = part.eyes > plan.eyes ? part.eyes : plan.eyes;
        plan.spp = part.spp > plan.spp ? part.spp : plan.spp; // the same for all that round
        plan.passes = part.passes > 0 && part.groups > 1 ? part.passes : plan.passes;
        frame = shot.end;
    }
    return plan;
}

// The plan of a shot as a path of its own.
static RfGroupPlan plan_of( const RfGroupPlan* plan, Stretch shot )
{
    return rf_plan_groups( shot.end - shot.first, plan->eyes / 2, plan->spp );
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

// Groups of the shot that begins with frame f have numbers from 2f on: a path has at most two groups for each frame.
static RfGroup group_of_shot( const RfGroupPlan* plan, int number )
{
    Stretch shot = shot_around( plan->cameras, plan->frames, number / 2 );
    RfGroupPlan own = plan_of( plan, shot );
    number -= 2 * shot.first;
    RfGroup group = number < own.groups ? rf_group( &own, number ) : ( RfGroup ){ 0 };
    group.first += shot.first;
    return group;
}

RfGroup rf_group( const RfGroupPlan* plan, int number )
{
    if ( plan->cameras != NULL )
        return group_of_shot( plan, number );
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
    if ( plan->cameras != NULL )
    {
        Stretch shot = shot_around( plan->cameras, plan->frames, frame );
        RfGroupPlan own = plan_of( plan, shot );
        rf_groups_of_frame( &own, frame - shot.first, first, last );
        *first += 2 * shot.first;
        *last += 2 * shot.first;
        return;
    }
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

double rf_plan_work( const RfGroupPlan* plan, double own, double reuse )
{
    double work = 0.0;
    for ( int g = 0; g < plan->groups; ++g )
    {
        RfGroup group = rf_group( plan, g );
        work += (double)group.passes * group.eyes * ( own + ( group.eyes - 1 ) * reuse );
    }
    return work;
}
