// Weights: the inverse of variances, which are averaged over neighbours, but for those that are much brighter. A dark wall
// beside a window would be taken for as uncertain as the window's edge, so that its own value counted for nothing against
// differences across the edge.
#include "base/fault.h"
#include "gradient/reconstruct.h"

#include <math.h>

#define RADIUS 2            // of the average
#define MUCH_BRIGHTER 10.0f // times as bright
#define LEAST_VARIANCE 1e-6 // relative to the geometric mean: a few passes that agree by chance are not certain

// Pixels of a plane that count: columns·rows of width·height.
typedef struct Extent
{
    int width, columns, rows;
} Extent;

// What averages need of the pixels.
typedef struct Brightness
{
    const float *squares, *limit; // squared brightness, and how much is too bright for the pixel
} Brightness;

static int from_of( int i, int radius ) { return i > radius ? i - radius : 0; }

static int to_of( int i, int radius, int count ) { return i + radius < count ? i + radius + 1 : count; }

// The third smallest of 3x3 values, cut at the border; of one or two pixels, 0.
static float third_smallest( const float* values, Extent e, int x, int y )
{
    float least[3] = { INFINITY, INFINITY, INFINITY };
    for ( int v = from_of( y, 1 ); v < to_of( y, 1, e.rows ); ++v )
    {
        for ( int u = from_of( x, 1 ); u < to_of( x, 1, e.columns ); ++u )
        {
            float value = values[(size_t)v * (size_t)e.width + (size_t)u];
            float second = fmaxf( least[0], value ), third = fmaxf( least[1], second );
            least[0] = fminf( least[0], value );
            least[1] = fminf( least[1], second );
            least[2] = fminf( least[2], third );
        }
    }
    return isfinite( least[2] ) ? least[2] : 0.0f;
}

// A pixel that is darker than all but two around it is taken for as bright as those: few samples may have missed its light.
static Brightness find_brightness( const RfGradientImages* images, float* const scratch[2] )
{
    Extent all = { images->width, images->width, images->height };
    float *squares = scratch[0], *limit = scratch[1];
    for ( size_t i = 0; i < (size_t)all.width * (size_t)all.rows; ++i )
    {
        const float* value = images->primal + 3 * i;
        squares[i] = value[0] * value[0] + value[1] * value[1] + value[2] * value[2];
    }
    for ( int y = 0; y < all.rows; ++y )
    {
        for ( int x = 0; x < all.width; ++x )
        {
            size_t i = (size_t)y * (size_t)all.width + (size_t)x;
            limit[i] = MUCH_BRIGHTER * MUCH_BRIGHTER * fmaxf( squares[i], third_smallest( squares, all, x, y ) );
        }
    }
    return ( Brightness ){ squares, limit };
}

// The average around (x, y) of what is not too bright: of differences, by the brighter of two pixels, `step` apart.
static float average( const float* values, Brightness b, Extent e, size_t step, int x, int y )
{
    size_t width = (size_t)e.width, at = (size_t)y * width + (size_t)x;
    float limit = fmaxf( b.limit[at], b.limit[at + step] ), sum = 0.0f, count = 0.0f;
    for ( int v = from_of( y, RADIUS ); v < to_of( y, RADIUS, e.rows ); ++v )
    {
        for ( int u = from_of( x, RADIUS ); u < to_of( x, RADIUS, e.columns ); ++u )
        {
            size_t i = (size_t)v * width + (size_t)u;
            bool counts = b.squares[i] <= limit && b.squares[i + step] <= limit;
            sum += counts ? values[i] : 0.0f;
            count += counts ? 1.0f : 0.0f;
        }
    }
    return sum / count; // (x, y) itself counts
}

static void smooth( const float* from, Brightness b, Extent e, size_t step, float* to )
{
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
            to[(size_t)y * (size_t)e.width + (size_t)x] = average( from, b, e, step, x, y );
    }
}

// Σ log of the values above 0, and their number.
static double sum_logs( const float* values, Extent e, size_t* count )
{
    double sum = 0.0;
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
        {
            float value = values[(size_t)y * (size_t)e.width + (size_t)x];
            sum += value > 0.0f ? log( (double)value ) : 0.0;
            *count += value > 0.0f;
        }
    }
    return sum;
}

static void invert( float* values, Extent e, int height, double typical )
{
    for ( int y = 0; y < height; ++y )
    {
        for ( int x = 0; x < e.width; ++x )
        {
            float* value = values + (size_t)y * (size_t)e.width + (size_t)x;
            double variance = fmax( (double)*value, LEAST_VARIANCE * typical );
            *value = x < e.columns && y < e.rows ? (float)( typical / variance ) : 0.0f;
        }
    }
}

void rf_weights_of_half( const RfGradientHalf* half, float* const scratch[2], float* a, float* b_x, float* b_y )
{
    int w = half->images.width, h = half->images.height;
    const float* variances[3] = { half->variance, half->variance_dx, half->variance_dy };
    const Extent extents[3] = { { w, w, h }, { w, w - 1, h }, { w, w, h - 1 } };
    const size_t steps[3] = { 0, 1, (size_t)w };
    float* weights[3] = { a, b_x, b_y };
    Brightness brightness = find_brightness( &half->images, scratch );
    size_t count = 0;
    double sum = 0.0;
    for ( int k = 0; k < 3; ++k )
    {
        smooth( variances[k], brightness, extents[k], steps[k], weights[k] );
        sum += sum_logs( weights[k], extents[k], &count );
    }
    double typical = count > 0 || RF_FAULT( typical ) ? exp( sum / (double)count ) : 1.0;
    for ( int k = 0; k < 3; ++k )
        invert( weights[k], extents[k], h, typical );
}
