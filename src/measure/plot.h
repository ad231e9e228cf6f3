// Plots as SVG: lines with markers over linear or logarithmic axes, a legend,
// notes at points. The text is a whole file that needs nothing else; equal plots
// give equal bytes.
#ifndef REFRAME_MEASURE_PLOT_H
#define REFRAME_MEASURE_PLOT_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct RfPlotAxis
{
    const char* label;
    bool log;        // base 10; values that are not above 0 are left out
    double min, max; // where they are equal: from the values, with a margin
} RfPlotAxis;

typedef struct RfPlotSeries
{
    const char* name; // in the legend; NULL: not there
    const double* x;  // points that are not finite are left out, and interrupt the line
    const double* y;
    int count;
    const char* const* labels; // of the points, shown to who points at them; NULL: none
    bool show_labels;          // above the markers, to be read at once
    bool dashed;
    bool no_markers; // a line alone, as of a fit
    bool no_line;    // markers alone
    int style;       // colour and marker, 0 to RF_PLOT_STYLES − 1
} RfPlotSeries;

#define RF_PLOT_STYLES 6

// A ring around a point, and what it is, which stands below the legend.
typedef struct RfPlotNote
{
    double x, y;
    const char* text;
} RfPlotNote;

typedef struct RfPlot
{
    const char* title;
    const char* subtitle; // may be NULL
    RfPlotAxis x, y;
    const RfPlotSeries* series;
    int series_count;
    const RfPlotNote* notes;
    int note_count;
} RfPlot;

// The SVG as text, to be freed. Names may hold anything: it is escaped, bytes
// that are no UTF-8 or no character of XML become '?'. Fails with RF_ERROR_MEMORY.
RfResult rf_draw_plot( const RfPlot* plot, char** svg, size_t* size, RfError* error );

// Positions of ticks between min and max, ascending, at most `room`: 1, 2, 5 times
// powers of ten on a short logarithmic axis, powers of ten on a long one, and
// multiples of 1, 2 or 5 times a power of ten on a linear one and on a logarithmic
// one of less than a decade. Returns how many.
#define RF_PLOT_TICKS 24
int rf_plot_ticks( bool log, double min, double max, double* ticks, int room );

#endif
