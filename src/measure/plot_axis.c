#include "measure/plot_axis.h"

#include <math.h>

#define MARGIN 0.06   // fraction of the range, at either end
#define LONG_AXIS 3.2 // decades; longer axes have ticks at powers of ten only

bool rf_plot_has( const RfPlotAxis* axis, double value ) { return isfinite( value ) && ( !axis->log || value > 0.0 ); }

static void extend_range( const RfPlot* plot, bool vertical, double x, double y, double* low, double* high )
{
    if ( !rf_plot_has( &plot->x, x ) || !rf_plot_has( &plot->y, y ) )
        return;
    double value = vertical ? y : x;
    *low = fmin( *low, value );
    *high = fmax( *high, value );
}

// The range of all points plus a margin; for a single value, a range around it.
static void find_range( const RfPlot* plot, bool vertical, bool log, double* min, double* max )
{
    double low = (double)INFINITY, high = -(double)INFINITY;
    for ( int s = 0; s < plot->series_count; ++s )
    {
        for ( int i = 0; i < plot->series[s].count; ++i )
            extend_range( plot, vertical, plot->series[s].x[i], plot->series[s].y[i], &low, &high );
    }
    if ( low > high )
        low = high = 1.0;
    low = log ? log10( low ) : low;
    high = log ? log10( high ) : high;
    double air = high > low ? MARGIN * ( high - low ) : log || low == 0.0 ? 0.5 : 0.5 * fabs( low );
    *min = log ? pow( 10.0, low - air ) : low - air;
    *max = log ? pow( 10.0, high + air ) : high + air;
}

PlotScale rf_plot_scale( const RfPlot* plot, bool vertical, double from, double to )
{
    const RfPlotAxis* axis = vertical ? &plot->y : &plot->x;
    PlotScale scale = { axis->log, axis->min, axis->max, from, to };
    if ( !( axis->min < axis->max ) )
        find_range( plot, vertical, axis->log, &scale.min, &scale.max );
    return scale;
}

double rf_plot_position( const PlotScale* s, double value )
{
    double share = s->log ? log( value / s->min ) / log( s->max / s->min ) : ( value - s->min ) / ( s->max - s->min );
    return s->from + share * ( s->to - s->from );
}

static int log_ticks( double min, double max, double* ticks, int room )
{
    static const double steps[] = { 1.0, 2.0, 5.0 };
    double first = floor( log10( min ) ), last = ceil( log10( max ) );
    bool decades = log10( max / min ) > LONG_AXIS;
    double by = decades ? fmax( 1.0, ceil( ( last - first ) / room ) ) : 1.0;
    int count = 0;
    for ( double decade = first; decade <= last; decade += by )
    {
        for ( int i = 0; i < ( decades ? 1 : 3 ); ++i )
        {
            double tick = steps[i] * pow( 10.0, decade );
            if ( tick >= min * ( 1.0 - 1e-9 ) && tick <= max * ( 1.0 + 1e-9 ) && count < room )
                ticks[count++] = tick;
        }
    }
    return count;
}

static int linear_ticks( double min, double max, double* ticks, int room )
{
    double rough = ( max - min ) / 8.0, power = pow( 10.0, floor( log10( rough ) ) ), step = power;
    if ( rough > 5.0 * power )
        step = 10.0 * power;
    else if ( rough > 2.0 * power )
        step = 5.0 * power;
    else if ( rough > power )
        step = 2.0 * power;
    int count = 0;
    for ( double k = ceil( min / step - 1e-9 ); k * step <= max + 1e-9 * step && count < room; k += 1.0 )
        ticks[count++] = k * step;
    return count;
}

int rf_plot_ticks( bool log, double min, double max, double* ticks, int room )
{
    if ( !( min < max ) || !isfinite( max - min ) || ( log && min <= 0.0 ) )
        return 0;
    return log && max / min > 10.0 ? log_ticks( min, max, ticks, room ) : linear_ticks( min, max, ticks, room );
}
