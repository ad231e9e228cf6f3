// Weights: the inverse of variances, which are averaged over neighbours relative to their brightness. Absolute variances of a
// window's edge would be taken for those of the dark wall beside it, whose own value would then count for nothing against
// differences across the edge.
#include "gradient/reconstruct.h"

#include <math.h>

#define RADIUS 2            // of the smoothing
#define DARKEST 1e-4        // brightness at least, relative to the square of the mean: black pixels
#define LEAST_VARIANCE 1e-6 // relative to the geometric mean: a few passes that agree by chance are not certain

// Pixels of a plane that count: columns·rows of width·height.
typedef struct Extent
{
    int width, columns, rows;
} Extent;

static int from_of( int i ) { return i > RADIUS ? i - RADIUS : 0; }

static int to_of( int i, int count ) { return i + RADIUS < count ? i + RADIUS + 1 : count; }

// Averages over 5x5 pixels, first along rows, then along columns. `to` may be `from`.
static void smooth( const float* from, Extent e, float* scratch, float* to )
{
    for ( int y = 0; y < e.rows; ++y )
    {
        const float* row = from + (size_t)y * (size_t)e.width;
        for ( int x = 0; x < e.columns; ++x )
        {
            int first = from_of( x ), end = to_of( x, e.columns );
            double sum = 0.0;
            for ( int k = first; k < end; ++k )
                sum += (double)row[k];
            scratch[(size_t)y * (size_t)e.width + (size_t)x] = (float)( sum / ( end - first ) );
        }
    }
    for ( int y = 0; y < e.rows; ++y )
    {
        int first = from_of( y ), end = to_of( y, e.rows );
        for ( int x = 0; x < e.columns; ++x )
        {
            double sum = 0.0;
            for ( int k = first; k < end; ++k )
                sum += (double)scratch[(size_t)k * (size_t)e.width + (size_t)x];
            to[(size_t)y * (size_t)e.width + (size_t)x] = (float)( sum / ( end - first ) );
        }
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

// The third smallest of 3x3 values, cut at the border.
static float third_darkest( const float* values, int w, int h, int x, int y )
{
    float least[3] = { INFINITY, INFINITY, INFINITY };
    for ( int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < h; ++v )
    {
        for ( int u = x > 0 ? x - 1 : 0; u <= x + 1 && u < w; ++u )
        {
            float value = values[(size_t)v * (size_t)w + (size_t)u], second = fmaxf( least[0], value );
            least[0] = fminf( least[0], value );
            float third = fmaxf( least[1], second );
            least[1] = fminf( least[1], second );
            least[2] = fminf( least[2], third );
        }
    }
    return isfinite( least[2] ) ? least[2] : 0.0f; // of one or two pixels
}

// The squared brightness of pixels, as far as it is not a chance: at least that of the third darkest of 3x3.
static void find_brightness( const RfGradientHalf* half, float* scratch, float* brightness )
{
    int w = half->images.width, h = half->images.height;
    double sum = 0.0;
    for ( size_t i = 0; i < (size_t)w * (size_t)h; ++i )
    {
        const float* value = half->images.primal + 3 * i;
        scratch[i] = value[0] * value[0] + value[1] * value[1] + value[2] * value[2];
        sum += sqrt( (double)scratch[i] );
    }
    double mean = sum / ( (double)w * h );
    for ( int y = 0; y < h; ++y )
    {
        for ( int x = 0; x < w; ++x )
        {
            size_t i = (size_t)y * (size_t)w + (size_t)x;
            brightness[i] = fmaxf( scratch[i], third_darkest( scratch, w, h, x, y ) ) + (float)( DARKEST * mean * mean );
        }
    }
}

// The brightness that a variance is relative to: of a difference, that of the brighter pixel, `step` pixels on.
static void scale_by_brightness( const float* from, const float* brightness, Extent e, size_t step, bool divide, float* to )
{
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
        {
            size_t i = (size_t)y * (size_t)e.width + (size_t)x;
            float scale = fmaxf( brightness[i], brightness[i + step] );
            to[i] = scale > 0.0f ? ( divide ? from[i] / scale : from[i] * scale ) : 0.0f;
        }
    }
}

void rf_weights_of_half( const RfGradientHalf* half, float* const scratch[2], float* a, float* b_x, float* b_y )
{
    int w = half->images.width, h = half->images.height;
    const float* variances[3] = { half->variance, half->variance_dx, half->variance_dy };
    const Extent extents[3] = { { w, w, h }, { w, w - 1, h }, { w, w, h - 1 } };
    const size_t steps[3] = { 0, 1, (size_t)w };
    float *weights[3] = { a, b_x, b_y }, *brightness = scratch[1];
    size_t count = 0;
    double sum = 0.0;
    find_brightness( half, scratch[0], brightness );
    for ( int k = 0; k < 3; ++k )
    {
        scale_by_brightness( variances[k], brightness, extents[k], steps[k], true, weights[k] );
        smooth( weights[k], extents[k], scratch[0], weights[k] );
        scale_by_brightness( weights[k], brightness, extents[k], steps[k], false, weights[k] );
        sum += sum_logs( weights[k], extents[k], &count );
    }
    double typical = count > 0 ? exp( sum / (double)count ) : 1.0;
    for ( int k = 0; k < 3; ++k )
        invert( weights[k], extents[k], h, typical );
}
