// Ranges of frames for several machines. A range renders all groups that hold its frames, so the groups at a cut are rendered
// on both sides: its halo. It is least where the frames asked for have a gap, more within the path, and most at its ends, where
// groups have more passes, or between frames of a camera that stands still.
#include "reframe/plan.h"
#include "render/groups.h"
#include "render/settings.h"

#include <math.h>
#include <stdlib.h>

// ---- The halo of some frames

// Another group is named where it is so many times as efficient: a tenth is within the error of the model.
#define FASTER 1.25

// What a sample of a group leaves of the error, and what it costs in another frame, over that of tracing it: by the rows of a plan,
// between them by the line through the nearest two.
typedef struct Costs
{
    double error, reuse;
} Costs;

static Costs costs_of( const RfPlan* plan, int group )
{
    const RfPlanRow *below = plan->rows, *above = NULL;
    for ( int i = 0; i < plan->count && above == NULL; ++i )
    {
        const RfPlanRow* row = plan->rows + i;
        if ( !rf_plan_row_fits( row ) )
            continue;
        below = row->group <= group ? row : below;
        above = row->group > group ? row : NULL;
    }
    if ( above == NULL )
        return ( Costs ){ below->error, below->reuse };
    double t = (double)( group - below->group ) / ( above->group - below->group );
    return ( Costs ){ below->error + t * ( above->error - below->error ), below->reuse + t * ( above->reuse - below->reuse ) };
}

// The work of the frames asked for, where a sample costs 1, and `reuse` for each of them that it is tested for.
static double work_of( const RfGroupPlan* plan, const RfShot* shot, double reuse )
{
    double work = 0.0;
    for ( int g = 0, first = 0; g < plan->groups; ++g )
    {
        RfGroup group = rf_group( plan, g );
        int wanted = 0;
        while ( first < shot->frame_count && shot->frames[first] < group.first )
            ++first;
        while ( first + wanted < shot->frame_count && shot->frames[first + wanted] < group.first + group.eyes )
            ++wanted;
        if ( wanted > 0 )
            work += (double)group.passes * ( group.eyes + reuse * wanted * ( group.eyes - 1 ) );
    }
    return work;
}

// What is beyond the work that these frames have of a render of the whole path.
static double halo_of( const RfGroupPlan* plan, const RfShot* shot, double reuse )
{
    double whole = rf_plan_work( plan, 1.0, reuse ), part = work_of( plan, shot, reuse );
    return fmax( 1.0 - whole * shot->frame_count / plan->frames / part, 0.0 );
}

RfResult rf_plan_halo( const RfShot* shot, const RfRenderSettings* settings, double least, RfHalo* halo, RfError* error )
{
    RfPlan plan;
    RfGroupPlan groups = rf_plan_samples( shot, settings->group, settings->spp );
    *halo = ( RfHalo ){ halo_of( &groups, shot, 0.0 ), settings->group, 0.0 };
    if ( halo->share < least ) // reuse only makes it less
        return RF_OK;
    RfResult result = rf_plan_render( shot, settings, &plan, error );
    if ( result != RF_OK )
        return result;
    Costs now = costs_of( &plan, settings->group );
    halo->share = halo_of( &groups, shot, now.reuse );
    double each = groups.spp / ( now.error * work_of( &groups, shot, now.reuse ) ), best = FASTER * each;
    for ( int i = 0; i < plan.count; ++i )
    {
        const RfPlanRow* row = plan.rows + i;
        if ( row->excluded != NULL || !rf_plan_row_fits( row ) || row->group >= settings->group )
            continue;
        RfGroupPlan other = rf_plan_samples( shot, row->group, settings->spp );
        double efficiency = other.spp / ( row->error * work_of( &other, shot, row->reuse ) );
        if ( efficiency <= best )
            continue;
        best = efficiency;
        halo->group = row->group;
        halo->saved = 1.0 - each / best;
    }
    return RF_OK;
}

// ---- Ranges

#define UNEVEN 1.05 // the longest range may take so many times the least possible, if that makes halos smaller
#define HALVINGS 50

// Samples per pixel that frames trace: of [a, b) it is halo[a] + sum[b] - sum[a].
typedef struct Work
{
    int count;    // frames asked for
    double* sum;  // count + 1: of groups, each with the first of the frames that it holds
    double* halo; // count: of groups that hold the frame and one before it
} Work;

static double range_work( const Work* w, int first, int end ) { return w->halo[first] + w->sum[end] - w->sum[first]; }

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
    while ( end < w->count && range_work( w, first, end + 1 ) <= limit )
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
    double low = 0.0, high = range_work( w, 0, w->count );
    for ( int i = 0; i < w->count; ++i )
        low = fmax( low, range_work( w, i, i + 1 ) );
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
        while ( first > k && range_work( w, first - 1, end ) <= limit )
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
        list[k] = ( RfPlanRange ){ first, end, range_work( w, first, end ) / whole };
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
