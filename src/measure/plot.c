// Draws plots as SVG: ticks, axes, curves, markers, legend and notes.
#include "measure/plot.h"

#include "base/plain_text.h"
#include "image/atomic_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// An axis with its final range, and the coordinates of its ends.
typedef struct PlotScale
{
    bool log;
    double min, max;
    double from, to;
} PlotScale;

#define RF_PLOT_STYLES 7

#define MARGIN 0.06   // fraction of the range, at either end
#define LONG_AXIS 3.2 // decades; longer axes have ticks at powers of ten only

// True if the axis can show the value: finite and, if logarithmic, above 0.
static bool plot_has( const RfPlotAxis* axis, double value ) { return isfinite( value ) && ( !axis->log || value > 0.0 ); }

static void extend_range( const RfPlot* plot, bool vertical, double x, double y, double* low, double* high )
{
    if ( !plot_has( &plot->x, x ) || !plot_has( &plot->y, y ) )
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

// Determines the range of the x axis or, if `vertical`, the y axis, drawn between the
// coordinates `from` and `to`.
static PlotScale plot_scale( const RfPlot* plot, bool vertical, double from, double to )
{
    const RfPlotAxis* axis = vertical ? &plot->y : &plot->x;
    PlotScale scale = { axis->log, axis->min, axis->max, from, to };
    if ( !( axis->min < axis->max ) )
        find_range( plot, vertical, axis->log, &scale.min, &scale.max );
    return scale;
}

static double plot_position( const PlotScale* s, double value )
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

// Layout, in SVG units.
#define WIDTH 940.0
#define HEIGHT 560.0
#define LEFT 92.0
#define RIGHT 720.0
#define TOP 76.0
#define BOTTOM 484.0
#define LEGEND ( RIGHT + 20.0 )
#define MARKER 4.5

#define INK "#222"
#define GRID "#e3e3e3"

// Series differ by their markers as well, not only by colour.
static const char* const s_colours[RF_PLOT_STYLES] = {
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8c6d1f", "#56b4e9", "#555555"
};

typedef struct Paper
{
    FILE* file;
    const RfPlot* plot;
    PlotScale x, y;
} Paper;

// What XML forbids, and what is no UTF-8, becomes '?'.
static void print_text( FILE* file, const char* text )
{
    static const char* const escapes[][2] = { { "<", "&lt;" }, { ">", "&gt;" }, { "&", "&amp;" }, { "\"", "&quot;" } };
    while ( *text != '\0' )
    {
        size_t bytes = rf_utf8_bytes( text );
        unsigned char first = (unsigned char)*text;
        bool forbidden = bytes == 0 || ( first < 0x20 && first != '\t' ) || strncmp( text, "\xef\xbf\xbe", 3 ) == 0 ||
                         strncmp( text, "\xef\xbf\xbf", 3 ) == 0;
        const char* shown = forbidden ? "?" : NULL;
        for ( size_t k = 0; k < 4 && !forbidden; ++k )
            shown = *text == *escapes[k][0] ? escapes[k][1] : shown;
        if ( shown != NULL )
            fputs( shown, file );
        else
            fwrite( text, 1, bytes, file );
        text += bytes > 0 ? bytes : 1;
    }
}

static void draw_text( FILE* file, double x, double y, const char* anchor, const char* attributes, const char* text )
{
    fprintf( file, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\"%s>", x, y, anchor, attributes );
    print_text( file, text );
    fputs( "</text>\n", file );
}

static void draw_line( FILE* file, double x0, double y0, double x1, double y1, const char* colour )
{
    fprintf( file, "<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\" fill=\"none\"/>\n", x0, y0, x1, y1, colour );
}

static void draw_ticks( const Paper* p, bool vertical )
{
    const PlotScale* scale = vertical ? &p->y : &p->x;
    double ticks[RF_PLOT_TICKS];
    int count = rf_plot_ticks( scale->log, scale->min, scale->max, ticks, RF_PLOT_TICKS );
    for ( int i = 0; i < count; ++i )
    {
        double at = plot_position( scale, ticks[i] );
        char text[32];
        snprintf( text, sizeof text, "%.6g", ticks[i] );
        if ( vertical )
        {
            draw_line( p->file, LEFT, at, RIGHT, at, GRID );
            draw_text( p->file, LEFT - 9.0, at + 4.5, "end", "", text );
        }
        else
        {
            draw_line( p->file, at, TOP, at, BOTTOM, GRID );
            draw_text( p->file, at, BOTTOM + 20.0, "middle", "", text );
        }
    }
}

static void draw_frame( const Paper* p )
{
    const RfPlot* plot = p->plot;
    draw_text( p->file, LEFT, 32.0, "start", " font-size=\"19\" font-weight=\"bold\"", plot->title );
    if ( plot->subtitle != NULL )
        draw_text( p->file, LEFT, 55.0, "start", " fill=\"#555\"", plot->subtitle );
    draw_ticks( p, false );
    draw_ticks( p, true );
    fprintf( p->file, "<path d=\"M%.1f %.1fV%.1fH%.1f\" stroke=\"%s\" fill=\"none\"/>\n", LEFT, TOP, BOTTOM, RIGHT, INK );
    draw_text( p->file, 0.5 * ( LEFT + RIGHT ), BOTTOM + 50.0, "middle", " font-size=\"15\"", plot->x.label );
    fprintf( p->file, "<g transform=\"translate(28 %.1f) rotate(-90)\">", 0.5 * ( TOP + BOTTOM ) );
    draw_text( p->file, 0.0, 0.0, "middle", " font-size=\"15\"", plot->y.label );
    fputs( "</g>\n", p->file );
}

// A marker, as far as its end tag or its slash: circle, square, triangle, diamond, triangle upside down, triangle to the left, cross.
static void draw_marker( FILE* file, double x, double y, int style )
{
    static const char* const paths[RF_PLOT_STYLES] = { NULL,
                                                       "m-4.5 -4.5h9v9h-9z",
                                                       "m0 -5.4l5.4 9.5h-10.8z",
                                                       "m0 -5.9l5.9 5.9 -5.9 5.9 -5.9 -5.9z",
                                                       "m0 5.4l5.4 -9.5h-10.8z",
                                                       "m-5.4 0l9.5 -5.4v10.8z",
                                                       "m-4.5 -4.5l9 9m0 -9l-9 9" };
    bool cross = style == RF_PLOT_STYLES - 1;
    if ( paths[style] == NULL )
        fprintf( file, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\"", x, y, MARKER );
    else
        fprintf( file, "<path d=\"M%.1f %.1f%s\"%s", x, y, paths[style], cross ? " stroke-width=\"2.5\"" : "" );
    fprintf( file, " fill=\"%s\" stroke=\"%s\"", s_colours[style], cross ? s_colours[style] : "#fff" );
}

static bool is_inside( const Paper* p, double x, double y )
{
    return plot_has( &p->plot->x, x ) && plot_has( &p->plot->y, y ) && x >= p->x.min && x <= p->x.max && y >= p->y.min &&
           y <= p->y.max;
}

static void draw_curve( const Paper* p, const RfPlotSeries* s )
{
    const char* colour = s_colours[s->style % RF_PLOT_STYLES];
    fputs( "<path d=\"", p->file );
    bool down = false;
    for ( int i = 0; i < s->count; ++i )
    {
        bool drawn = plot_has( &p->plot->x, s->x[i] ) && plot_has( &p->plot->y, s->y[i] );
        if ( drawn )
            fprintf( p->file, "%s%.1f %.1f", down ? "L" : "M", plot_position( &p->x, s->x[i] ), plot_position( &p->y, s->y[i] ) );
        down = drawn;
    }
    fprintf( p->file,
             "\" fill=\"none\" stroke=\"%s\" stroke-width=\"2\" stroke-linejoin=\"round\" clip-path=\"url(#plot)\"%s/>\n", colour,
             s->dashed ? " stroke-dasharray=\"6 5\"" : "" );
}

static void draw_points( const Paper* p, const RfPlotSeries* s )
{
    int style = s->style % RF_PLOT_STYLES;
    for ( int i = 0; i < s->count; ++i )
    {
        if ( !is_inside( p, s->x[i], s->y[i] ) )
            continue;
        double x = plot_position( &p->x, s->x[i] ), y = plot_position( &p->y, s->y[i] );
        draw_marker( p->file, x, y, style );
        if ( s->labels == NULL )
        {
            fputs( "/>\n", p->file );
            continue;
        }
        fputs( "><title>", p->file );
        print_text( p->file, s->labels[i] );
        fprintf( p->file, "</title></%s>\n", style == 0 ? "circle" : "path" );
        if ( s->show_labels )
            draw_text( p->file, x, y - 11.0, "middle", " font-size=\"12\" class=\"halo\"", s->labels[i] );
    }
}

// Returns the y coordinate of its lower end.
static double draw_legend( const Paper* p )
{
    double x = LEGEND, y = TOP + 14.0;
    for ( int i = 0; i < p->plot->series_count; ++i )
    {
        const RfPlotSeries* s = p->plot->series + i;
        const char* colour = s_colours[s->style % RF_PLOT_STYLES];
        if ( s->name == NULL )
            continue;
        if ( !s->no_line )
            fprintf( p->file, "<path d=\"M%.1f %.1fh30\" stroke=\"%s\" stroke-width=\"2\"%s/>\n", x, y, colour,
                     s->dashed ? " stroke-dasharray=\"6 5\"" : "" );
        if ( !s->no_markers )
        {
            draw_marker( p->file, x + 15.0, y, s->style % RF_PLOT_STYLES );
            fputs( "/>\n", p->file );
        }
        draw_text( p->file, x + 40.0, y + 4.5, "start", "", s->name );
        y += 24.0;
    }
    return y;
}

static void draw_ring( const Paper* p, double x, double y )
{
    fprintf( p->file, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"none\" stroke=\"%s\" stroke-width=\"2\"/>\n", x, y,
             2.2 * MARKER, INK );
}

// The texts of notes go below the legend, where they cover nothing.
static void draw_notes( const Paper* p, double y )
{
    for ( int i = 0; i < p->plot->note_count; ++i )
    {
        const RfPlotNote* note = p->plot->notes + i;
        if ( !is_inside( p, note->x, note->y ) )
            continue;
        draw_ring( p, plot_position( &p->x, note->x ), plot_position( &p->y, note->y ) );
        y += 30.0;
        draw_ring( p, LEGEND + 15.0, y );
        draw_text( p->file, LEGEND + 40.0, y + 4.5, "start", " font-weight=\"bold\"", note->text );
    }
}

static void draw( FILE* file, const RfPlot* plot )
{
    Paper p = { file, plot, plot_scale( plot, false, LEFT, RIGHT ), plot_scale( plot, true, BOTTOM, TOP ) };
    fprintf( file,
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" "
             "font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"%s\">\n"
             "<style>.halo{paint-order:stroke;stroke:#fff;stroke-width:4px;stroke-linejoin:round}</style>\n"
             "<clipPath id=\"plot\"><rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/></clipPath>\n"
             "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
             WIDTH, HEIGHT, WIDTH, HEIGHT, INK, LEFT, TOP, RIGHT - LEFT, BOTTOM - TOP );
    draw_frame( &p );
    for ( int i = 0; i < plot->series_count; ++i )
    {
        if ( !plot->series[i].no_line )
            draw_curve( &p, plot->series + i );
    }
    for ( int i = 0; i < plot->series_count; ++i )
    {
        if ( !plot->series[i].no_markers )
            draw_points( &p, plot->series + i );
    }
    draw_notes( &p, draw_legend( &p ) - 24.0 );
    fputs( "</svg>\n", file );
}

RfResult rf_draw_plot( const RfPlot* plot, char** svg, size_t* size, RfError* error )
{
    *svg = NULL;
    FILE* file = open_memstream( svg, size );
    if ( file == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the plot" );
    draw( file, plot );
    bool failed = ferror( file ) != 0;
    if ( fclose( file ) != 0 || failed )
    {
        free( *svg );
        *svg = NULL;
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the plot" );
    }
    return RF_OK;
}

RfResult rf_write_plot( const RfPlot* plot, const char* path, RfError* error )
{
    char* svg;
    size_t size;
    RfResult result = rf_draw_plot( plot, &svg, &size, error );
    if ( result == RF_OK )
        result = rf_write_file_atomic( path, svg, size, error );
    free( svg );
    return result;
}
