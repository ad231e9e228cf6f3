// The pixel filters there are: tabulates them from the integrals of their windows, and draws places from them.
#include "film/pixel_filter.h"

#include <math.h>
#include <stddef.h>

#define PI 3.14159265358979323846

// The integrals ∫ h from −∞ to x within the reach.

static double box( double x, double width ) { return x / width + 0.5; }

static double tent( double x, double width )
{
    return x < 0.0 ? 0.5 * pow( 1.0 + x / width, 2.0 ) : 1.0 - 0.5 * pow( 1.0 - x / width, 2.0 );
}

// exp(−8 x²/width²), as Blender's: a standard deviation of a quarter of the width.
static double gaussian( double x, double width ) { return 0.5 + 0.5 * erf( sqrt( 8.0 ) * x / width ) / erf( sqrt( 8.0 ) ); }

// ∫ of the Blackman-Harris window from its centre to x (Harris, On the use of windows for harmonic analysis with the
// discrete Fourier transform, Proc. IEEE 1978: four terms, −92 dB), over a width of 2 `reach`.
static double window( double x, double reach )
{
    double angle = PI * x / reach, scale = reach / PI;
    return 0.35875 * x +
           scale * ( 0.48829 * sin( angle ) + 0.14128 / 2.0 * sin( 2.0 * angle ) + 0.01168 / 3.0 * sin( 3.0 * angle ) );
}

static double blackman_harris( double x, double width ) { return 0.5 + 0.5 * window( x, width ) / window( width, width ); }

// X( constant, name, reach over width, usual width in pixels, integral ), a row per RfFilter.
#define FILTERS( X )                                                                                                             \
    X( BOX, "box", 0.5, 1.0, box )                                                                                               \
    X( TENT, "tent", 1.0, 1.0, tent )                                                                                            \
    X( GAUSSIAN, "gaussian", 1.0, 1.5, gaussian )                                                                                \
    X( BLACKMAN_HARRIS, "blackman-harris", 1.0, 1.5, blackman_harris )

typedef struct Kind
{
    double reach, width;
    double ( *integral )( double x, double width );
} Kind;

#define ROW( constant, name, reach, width, integral ) [RF_FILTER_##constant] = { reach, width, integral },
static const Kind s_kinds[] = { FILTERS( ROW ) };
#undef ROW

#define WORD( constant, name, reach, width, integral ) [RF_FILTER_##constant] = name,
const char* const rf_filter_words[] = { FILTERS( WORD ) NULL };
#undef WORD

bool rf_is_filter( RfFilter filter ) { return (size_t)(unsigned)filter < sizeof s_kinds / sizeof s_kinds[0]; }

double rf_default_filter_width( RfFilter filter ) { return s_kinds[filter].width; }

// Pixels from the centre beyond which the filter is 0.
static double reach_of( RfFilter kind, double width ) { return s_kinds[kind].reach * width; }

// Whole pixels to each side of a sample's own that it may count in.
static int whole_reach( const RfRenderSettings* s ) { return (int)ceil( reach_of( s->filter, s->filter_width ) - 0.5 ); }

int rf_filter_pixels( const RfRenderSettings* settings )
{
    int taps = 2 * whole_reach( settings ) + 1;
    return taps * taps;
}

// ∫ h from −∞ to x.
static double integral( RfFilter kind, double width, double x )
{
    double reach = reach_of( kind, width );
    return s_kinds[kind].integral( fmin( fmax( x, -reach ), reach ), width );
}

void rf_make_pixel_filter( const RfRenderSettings* settings, RfPixelFilter* filter )
{
    RfFilter kind = settings->filter;
    double width = settings->filter_width, square = 0.0;
    int reach = whole_reach( settings ), taps = 2 * reach + 1;
    filter->reach = reach;
    filter->taps = taps;
    for ( int tap = 0; tap < taps; ++tap )
    {
        for ( int step = 0; step < RF_FILTER_STEPS; ++step )
        {
            // from the centre of the pixel that the sample counts in to the sample
            double from = (double)step / RF_FILTER_STEPS - ( tap - reach ) - 0.5, to = from + 1.0 / RF_FILTER_STEPS;
            double mean = ( integral( kind, width, to ) - integral( kind, width, from ) ) * RF_FILTER_STEPS;
            filter->rows[step * taps + tap] = (float)mean;
            square += mean * mean / RF_FILTER_STEPS;
        }
    }
    for ( int d = 0; d < reach; ++d )
        filter->beyond[d] = (float)( 1.0 - integral( kind, width, d + 0.5 ) );
    for ( int i = 0; i <= taps * RF_FILTER_STEPS; ++i )
        filter->cumulative[i] = (float)integral( kind, width, (double)i / RF_FILTER_STEPS - ( reach + 0.5 ) );
    filter->worth = square * square;
}

float rf_draw_filter_place( const RfPixelFilter* filter, int p, int size, float random )
{
    int left = p < filter->reach ? filter->reach - p : 0; // pixels of the filter outside the film
    int right = size - 1 - p < filter->reach ? filter->reach - ( size - 1 - p ) : 0;
    int low = left * RF_FILTER_STEPS, high = ( filter->taps - right ) * RF_FILTER_STEPS;
    const float* c = filter->cumulative;
    float wanted = c[low] + random * ( c[high] - c[low] );
    while ( high - low > 1 )
    {
        int middle = low + ( high - low ) / 2;
        if ( c[middle] <= wanted )
            low = middle;
        else
            high = middle;
    }
    float part = c[high] > c[low] ? ( wanted - c[low] ) / ( c[high] - c[low] ) : 0.5f;
    return ( (float)low + fminf( part, 1.0f ) ) / RF_FILTER_STEPS - (float)filter->reach;
}
