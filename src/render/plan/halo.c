// What the halo of a short range costs, and which group costs least for it.
#include "reframe/plan.h"

#include "render/settings.h"

#include <math.h>

// Another group is named where it is so many times as efficient: a tenth is within the error of the model.
#define FASTER 1.25

// What paths of a group cost and bring: by the rows of a plan, between them by the line through the nearest two.
typedef struct Costs
{
    double reach;
    double reuse; // of a sample in another frame, over that of tracing it
} Costs;

static Costs costs_of_row( const RfShot* shot, const RfRenderSettings* settings, const RfPlanRow* row )
{
    RfGroupPlan plan = rf_plan_samples( shot, row->group, settings->spp );
    double traced = 0.0, others = 0.0, all = (double)plan.frames * plan.spp;
    for ( int g = 0; g < plan.groups; ++g )
    {
        RfGroup group = rf_group( &plan, g );
        traced += (double)group.passes * group.eyes;
        others += (double)group.passes * group.eyes * ( group.eyes - 1 );
    }
    Costs costs = { row->reach, 0.0 };
    if ( others > 0.0 && row->gain > 0.0 ) // gain = reach · all / ( traced + reuse · others )
        costs.reuse = fmax( ( row->reach * all / row->gain - traced ) / others, 0.0 );
    return costs;
}

static Costs costs_of( const RfShot* shot, const RfRenderSettings* settings, const RfPlan* plan, int group )
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
    Costs a = costs_of_row( shot, settings, below );
    if ( above == NULL )
        return a;
    Costs b = costs_of_row( shot, settings, above );
    double t = (double)( group - below->group ) / ( above->group - below->group );
    return ( Costs ){ a.reach + t * ( b.reach - a.reach ), a.reuse + t * ( b.reuse - a.reuse ) };
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
    double whole = 0.0, part = work_of( plan, shot, reuse );
    for ( int g = 0; g < plan->groups; ++g )
    {
        RfGroup group = rf_group( plan, g );
        whole += (double)group.passes * group.eyes * ( 1.0 + reuse * ( group.eyes - 1 ) );
    }
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
    Costs now = costs_of( shot, settings, &plan, settings->group );
    halo->share = halo_of( &groups, shot, now.reuse );
    double each = now.reach * groups.spp / work_of( &groups, shot, now.reuse ), best = FASTER * each;
    for ( int i = 0; i < plan.count; ++i )
    {
        const RfPlanRow* row = plan.rows + i;
        if ( row->excluded != NULL || !rf_plan_row_fits( row ) || row->group >= settings->group )
            continue;
        RfGroupPlan other = rf_plan_samples( shot, row->group, settings->spp );
        Costs costs = costs_of_row( shot, settings, row );
        double efficiency = costs.reach * other.spp / work_of( &other, shot, costs.reuse );
        if ( efficiency <= best )
            continue;
        best = efficiency;
        halo->group = row->group;
        halo->saved = 1.0 - each / best;
    }
    return RF_OK;
}
