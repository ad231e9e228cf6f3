#include "render/stop_plan.h"

double rf_shares_of( const RfStop* stop, int group ) { return rf_group( &stop->plan, group ).passes / stop->scale; }

double rf_planned_weight( const RfStop* stop, int frame, int from )
{
    int first, last;
    rf_groups_of_frame( &stop->plan, frame, &first, &last );
    double sum = 0.0;
    for ( int w = from > first ? from : first; w <= last; ++w )
        sum += rf_shares_of( stop, w ) * rf_group( &stop->plan, w ).weight;
    return sum;
}
