#include "measure/interval.h"

#include "measure/bias_interval.h"

#include <math.h>

RfInterval rf_log_interval( double value, double margin )
{
    return ( RfInterval ){ value, value * exp( -margin ), value * exp( margin ) };
}

double rf_influence_margin( const double* influence, int count, double variance )
{
    double square = 0.0, fourth = 0.0;
    if ( count < 2 )
        return NAN;
    for ( int i = 0; i < count; ++i )
    {
        double i2 = influence[i] * influence[i];
        square += i2;
        fourth += i2 * i2;
    }
    // the mean of the fourth power is three times the squared mean of the second for normal influences
    double freedom = fourth > 0.0 ? 3.0 * square * square / fourth - 1.0 : count - 1.0;
    freedom = fmin( fmax( freedom, 1.0 ), count - 1.0 );
    double spread = rf_student_quantile( (int)freedom ) * sqrt( square * count / ( count - 1.0 ) );
    return sqrt( spread * spread + 1.96 * 1.96 * variance );
}
