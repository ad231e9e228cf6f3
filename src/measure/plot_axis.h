// Maps values to coordinates in the plot.
#ifndef REFRAME_MEASURE_PLOT_AXIS_H
#define REFRAME_MEASURE_PLOT_AXIS_H

#include "measure/plot.h"

// An axis with its final range, and the coordinates of its ends.
typedef struct PlotScale
{
    bool log;
    double min, max;
    double from, to;
} PlotScale;

// True if the axis can show the value: finite and, if logarithmic, above 0.
bool rf_plot_has( const RfPlotAxis* axis, double value );

// Determines the range of the x axis or, if `vertical`, the y axis, drawn between the
// coordinates `from` and `to`.
PlotScale rf_plot_scale( const RfPlot* plot, bool vertical, double from, double to );

// The coordinate of a value.
double rf_plot_position( const PlotScale* scale, double value );

#endif
