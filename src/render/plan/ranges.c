// Cuts the frames of a render into ranges for several machines. A range renders all groups that hold its frames, so
// the groups at a cut are rendered on both sides: its halo. It is least where the frames asked for have a gap, more
// within the path, and most at its ends, where groups have more passes, or between frames of a camera that stands still.
#include "reframe/plan.h"

#include "render/settings.h"

#include <math.h>
#include <stdlib.h>

#define UNEVEN 1.05 // the longest range may take so many times the least possible, if that makes halos smaller
#define HALVINGS 50

// Samples per pixel that frames trace: of [a, b) it is halo[a] + sum[b] - sum[a].
typedef struct Work
{
    int count;    // frames asked for
    double* sum;  // count + 1: of groups, each with the first of the frames that it holds
    double* halo; // count: of groups that hold the frame and one before it
} Work;

static double work_of( const Work* w, int first, int end ) { return w->halo[first] + w->sum[end] - w->sum[first]; }

static void add_frames( const RfGroupPlan* plan, const int* eyes, Work* w )
{
    int done = 0; // groups
    w->sum[0] = 0.0;
    for ( int i = 0; i < w->count; ++i )
    {
        int first, last;
        rf_groups_of_frame( plan, eyes[i], &first, &last );
        double fresh = 0.0, again = 0.0;
        for ( int g = first; g <= last; ++g )
        {
            RfGroup group = rf_group( plan, g );
            *( g < done ? &again : &fresh ) += (double)group.passes * group.eyes;
        }
        w->sum[i + 1] = w->sum[i] + fresh;
        w->halo[i] = again;
        done = last + 1;
    }
}

// First frame after the longest range from `first` on that stays within the limit; at least one frame.
static int farthest( const Work* w, int first, double limit )
{
    int end = first + 1;
    while ( end < w->count && work_of( w, first, end + 1 ) <= limit )
        ++end;
    return end;
}

static bool is_enough( const Work* w, int ranges, double limit )
{
    int end = 0;
    for ( int i = 0; i < ranges && end < w->count; ++i )
        end = farthest( w, end, limit );
    return end == w->count;
}

// The least that the longest of so many ranges can take.
static double least_limit( const Work* w, int ranges )
{
    double low = 0.0, high = work_of( w, 0, w->count );
    for ( int i = 0; i < w->count; ++i )
        low = fmax( low, work_of( w, i, i + 1 ) );
    if ( is_enough( w, ranges, low ) )
        return low;
    for ( int i = 0; i < HALVINGS; ++i )
    {
        double middle = 0.5 * ( low + high );
        *( is_enough( w, ranges, middle ) ? &high : &low ) = middle;
    }
    return high;
}

// The earliest ends of ranges such that those after them can take the rest.
static void find_earliest( const Work* w, int ranges, double limit, RfPlanRange* list )
{
    int first = w->count;
    for ( int k = ranges - 1; k > 0; --k )
    {
        int end = first--;
        while ( first > k && work_of( w, first - 1, end ) <= limit )
            --first;
        first = first > k ? first : k;
        list[k - 1].end = first;
    }
}

// The end with the least halo; of equal ones that which comes nearest to even ranges.
static int best_end( const Work* w, int earliest, int latest, double even )
{
    int best = earliest;
    for ( int end = earliest + 1; end <= latest; ++end )
    {
        double more = w->halo[end] - w->halo[best];
        if ( more < 0.0 || ( more == 0.0 && fabs( w->sum[end] - even ) < fabs( w->sum[best] - even ) ) )
            best = end;
    }
    return best;
}

static void cut( const Work* w, int ranges, RfPlanRange* list )
{
    double limit = UNEVEN * least_limit( w, ranges ), whole = w->sum[w->count];
    find_earliest( w, ranges, limit, list );
    for ( int k = 0, first = 0; k < ranges; ++k )
    {
        int latest = farthest( w, first, limit ), most = w->count - ( ranges - 1 - k );
        int earliest = k < ranges - 1 && list[k].end > first ? list[k].end : first + 1;
        latest = latest < most ? latest : most;
        int end = k == ranges - 1 ? w->count : best_end( w, earliest, latest, whole * ( k + 1 ) / ranges );
        list[k] = ( RfPlanRange ){ first, end, work_of( w, first, end ) / whole };
        first = end;
    }
}

RfResult rf_plan_ranges( const RfShot* shot, const RfRenderSettings* settings, int machines, RfPlanRange* ranges,
                         int* range_count, RfError* error )
{
    int frame_count = shot->frame_count;
    if ( frame_count < 1 || machines < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "ranges need at least one frame and one machine" );
    size_t count = (size_t)frame_count;
    Work w = { .count = frame_count,
               .sum = malloc( ( count + 1 ) * sizeof( double ) ),
               .halo = malloc( count * sizeof( double ) ) };
    RfResult result = RF_OK;
    if ( w.sum != NULL && w.halo != NULL )
    {
        RfGroupPlan plan = rf_plan_samples( shot, settings->group, settings->spp );
        add_frames( &plan, shot->frames, &w );
        *range_count = machines < frame_count ? machines : frame_count;
        cut( &w, *range_count, ranges );
    }
    else
        result = rf_fail( error, RF_ERROR_MEMORY, "out of memory for the ranges of %d frames", frame_count );
    free( w.sum );
    free( w.halo );
    return result;
}
