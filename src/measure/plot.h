// Plots as SVG: lines with markers over linear or logarithmic axes, a legend, notes at points.
// The result is a self-contained file; equal plots give equal bytes.
#ifndef REFRAME_MEASURE_PLOT_H
#define REFRAME_MEASURE_PLOT_H

#include "reframe/error.h"

typedef struct RfPlotAxis
{
    const char* label;
    bool log;        // base 10; values that are not above 0 are skipped
    double min, max; // if equal: the range of the values plus a margin
} RfPlotAxis;

typedef struct RfPlotSeries
{
    const char* name; // in the legend; NULL: not listed
    const double* x;  // points that are not finite are skipped and interrupt the line
    const double* y;
    int count;
    const char* const* labels; // tooltips of the points; NULL: none
    bool show_labels;          // also print the labels above the markers
    bool dashed;
    bool no_markers; // a line alone, such as a fit
    bool no_line;    // markers alone
    int style;       // colour and marker, 0 to RF_PLOT_STYLES − 1
} RfPlotSeries;

// A ring around a point, with an explanation below the legend.
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

// Draws the SVG as text, which the caller frees. Labels may hold any bytes: they are escaped,
// and bytes that are not UTF-8 or not valid in XML become '?'. Fails with RF_ERROR_MEMORY.
RfResult rf_draw_plot( const RfPlot* plot, char** svg, size_t* size, RfError* error );

// The same into a file.
RfResult rf_write_plot( const RfPlot* plot, const char* path, RfError* error );

// Ascending tick positions between min and max, at most `room`. Long logarithmic axes: powers
// of ten; short ones: 1, 2 and 5 times powers of ten. Linear axes, and logarithmic ones of
// less than a decade: multiples of 1, 2 or 5 times a power of ten. Returns the number of
// ticks.
#define RF_PLOT_TICKS 24
int rf_plot_ticks( bool log, double min, double max, double* ticks, int room );

#endif
