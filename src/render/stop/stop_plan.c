// Weights of the shares by which the stop rule approaches its goal.
#include "render/stop/stop_plan.h"

double rf_shares_of( const RfStopRule* rule, int group ) { return rf_group( &rule->plan, group ).passes / rule->scale; }

double rf_planned_weight( const RfStopRule* rule, int frame, int from )
{
    int first, last;
    rf_groups_of_frame( &rule->plan, frame, &first, &last );
    double sum = 0.0;
    for ( int w = from > first ? from : first; w <= last; ++w )
        sum += rf_shares_of( rule, w ) * rf_group( &rule->plan, w ).weight;
    return sum;
}
