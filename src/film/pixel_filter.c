// Tabulates pixel filters from the integrals of their windows, and draws places from them. The filters there are: RfFilter
// (reframe/render_settings.h).
#include "film/pixel_filter.h"

#include <math.h>
#include <stddef.h>

#define PI 3.14159265358979323846

const char* const rf_filter_words[] = { [RF_FILTER_BOX] = "box",
                                        [RF_FILTER_TENT] = "tent",
                                        [RF_FILTER_GAUSSIAN] = "gaussian",
                                        [RF_FILTER_BLACKMAN_HARRIS] = "blackman-harris",
                                        NULL };

bool rf_is_filter( RfFilter filter ) { return (size_t)(unsigned)filter < sizeof rf_filter_words / sizeof rf_filter_words[0] - 1; }

// Pixels from the centre beyond which the filter is 0.
static double reach_of( RfFilter kind, double width ) { return kind == RF_FILTER_BOX ? 0.5 * width : width; }

// ∫ of the Blackman-Harris window from its centre to x (Harris, On the use of windows for harmonic analysis with the
// discrete Fourier transform, Proc. IEEE 1978: four terms, −92 dB), over a width of 2 `reach`.
static double blackman_harris( double x, double reach )
{
    double angle = PI * x / reach, scale = reach / PI;
    return 0.35875 * x +
           scale * ( 0.48829 * sin( angle ) + 0.14128 / 2.0 * sin( 2.0 * angle ) + 0.01168 / 3.0 * sin( 3.0 * angle ) );
}

// ∫ h from −∞ to x.
static double integral( RfFilter kind, double width, double x )
{
    double reach = reach_of( kind, width );
    x = fmin( fmax( x, -reach ), reach );
    switch ( kind )
    {
        case RF_FILTER_BOX: return x / width + 0.5;
        case RF_FILTER_TENT: return x < 0.0 ? 0.5 * pow( 1.0 + x / reach, 2.0 ) : 1.0 - 0.5 * pow( 1.0 - x / reach, 2.0 );
        // exp(−8 x²/width²), as Blender's: a standard deviation of a quarter of the width
        case RF_FILTER_GAUSSIAN: return 0.5 + 0.5 * erf( sqrt( 8.0 ) * x / width ) / erf( sqrt( 8.0 ) );
        case RF_FILTER_BLACKMAN_HARRIS: return 0.5 + 0.5 * blackman_harris( x, reach ) / blackman_harris( reach, reach );
    }
    return 0.0;
}

void rf_make_pixel_filter( const RfRenderSettings* settings, RfPixelFilter* filter )
{
    RfFilter kind = settings->filter;
    double width = settings->filter_width, square = 0.0;
    int reach = (int)ceil( reach_of( kind, width ) - 0.5 ), taps = 2 * reach + 1;
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
