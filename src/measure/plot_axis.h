// From values to places on paper.
#ifndef REFRAME_MEASURE_PLOT_AXIS_H
#define REFRAME_MEASURE_PLOT_AXIS_H

#include "measure/plot.h"

// An axis with its range settled, and where its ends lie on the paper.
typedef struct PlotScale
{
    bool log;
    double min, max;
    double from, to;
} PlotScale;

bool rf_plot_has( const RfPlotAxis* axis, double value );
PlotScale rf_plot_scale( const RfPlot* plot, bool vertical, double from, double to );
double rf_plot_place( const PlotScale* scale, double value );

#endif
