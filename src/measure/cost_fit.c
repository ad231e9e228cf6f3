#include "measure/cost_fit.h"

#include "measure/bias_interval.h"

#include <math.h>

static const RfInterval s_unknown = { (double)NAN, (double)NAN, (double)NAN };

RfInterval rf_fit_slope( const double* x, const double* y, int count )
{
    double n = 0.0, su = 0.0, sv = 0.0, suu = 0.0, suv = 0.0, svv = 0.0;
    RfInterval slope = s_unknown;
    for ( int i = 0; i < count; ++i )
    {
        if ( !( x[i] > 0.0 && y[i] > 0.0 && isfinite( x[i] ) && isfinite( y[i] ) ) )
            continue;
        double u = log( x[i] ), v = log( y[i] );
        n += 1.0;
        su += u;
        sv += v;
        suu += u * u;
        suv += u * v;
        svv += v * v;
    }
    double spread = suu - su * su / n;
    if ( n < 2.0 || !( spread > 1e-12 * suu ) ) // all x are equal up to rounding
        return slope;
    slope.value = ( suv - su * sv / n ) / spread;
    if ( n < 3.0 )
        return slope;
    double rest = svv - sv * sv / n - slope.value * slope.value * spread;
    double margin = rf_student_quantile( (int)n - 2 ) * sqrt( fmax( rest, 0.0 ) / ( n - 2.0 ) / spread );
    slope.low = slope.value - margin;
    slope.high = slope.value + margin;
    return slope;
}

RfCostPart rf_sum_cost_units( const RfCostUnit* units, int count, int part )
{
    double weight = 0.0;
    RfCostPart sum = { 0.0, 0.0, 0.0, 0.0 };
    for ( int i = 0; i < count; ++i )
    {
        const RfCostPart* p = units[i].parts + part;
        weight += units[i].passes;
        sum.relmse += units[i].passes * p->relmse;
        sum.wall_seconds += p->wall_seconds;
        sum.cpu_seconds += p->cpu_seconds;
        sum.samples += p->samples;
    }
    return ( RfCostPart ){ sum.relmse / weight, sum.wall_seconds / sum.samples, sum.cpu_seconds / sum.samples, 1.0 };
}
