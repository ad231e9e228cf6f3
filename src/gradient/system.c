#include "gradient/system.h"

#include "base/fault.h"

#include <math.h>
#include <string.h>

// Floats before the first pixel: at least a row, and a multiple of 16 for the alignment.
static size_t lead( int width ) { return ( (size_t)width + 15 ) / 16 * 16; }

size_t rf_plane_bytes( int width, int height )
{
    size_t floats = 2 * lead( width ) + (size_t)width * (size_t)height;
    return ( floats + 15 ) / 16 * 64;
}

float* rf_plane( int width, int height, char** memory )
{
    size_t bytes = rf_plane_bytes( width, height ), before = lead( width ) * sizeof( float );
    char* first = *memory;
    size_t end = before + (size_t)width * (size_t)height * sizeof( float );
    memset( first, 0, before );
    memset( first + end, 0, bytes - end );
    *memory += bytes;
    return (float*)(void*)( first + before );
}

void rf_finish_system( RfGradientSystem* system )
{
    size_t w = (size_t)system->width, count = w * (size_t)system->height;
    const float *a = system->a, *b_x = system->b_x, *b_y = system->b_y, *b_w = b_x - 1, *b_n = b_y - w;
    float* inverse = system->inverse_diagonal;
    for ( size_t i = 0; i < count; ++i )
    {
        float d = a[i] + b_x[i] + b_w[i] + b_y[i] + b_n[i];
        inverse[i] = d > 0.0f || RF_FAULT( diagonal_0 ) ? 1.0f / d : 0.0f;
    }
}

void rf_system_apply( const RfGradientSystem* system, const float* u, float* to )
{
    size_t w = (size_t)system->width, count = w * (size_t)system->height;
    const float *a = system->a, *b_x = system->b_x, *b_y = system->b_y, *b_w = b_x - 1, *b_n = b_y - w;
    const float *east = u + 1, *west = u - 1, *south = u + w, *north = u - w;
    for ( size_t i = 0; i < count; ++i )
        to[i] = a[i] * u[i] + b_x[i] * ( u[i] - east[i] ) + b_w[i] * ( u[i] - west[i] ) + b_y[i] * ( u[i] - south[i] ) +
                b_n[i] * ( u[i] - north[i] );
}

// Data of weight 0 may be NaN.
static float masked( float weight, float value ) { return weight > 0.0f ? weight * value : 0.0f; }

void rf_system_residual( const RfGradientSystem* system, const RfGradientImages* in, int channel, float scale, const float* u,
                         float* r )
{
    size_t w = (size_t)system->width, count = w * (size_t)system->height;
    const float *primal = in->primal + channel, *dx = in->dx + channel, *dy = in->dy + channel;
    const float *a = system->a, *b_x = system->b_x, *b_y = system->b_y;
    for ( size_t i = 0; i < count; ++i )
        r[i] = masked( a[i], scale * primal[3 * i] - u[i] );
    for ( size_t i = 0; i < count; ++i )
    {
        float f = masked( b_x[i], ( u[i + 1] - u[i] ) - scale * dx[3 * i] );
        r[i] += f;
        r[i + 1] -= f; // past the last pixel: 0, since its weight is 0
    }
    for ( size_t i = 0; i + w < count; ++i )
    {
        float f = masked( b_y[i], ( u[i + w] - u[i] ) - scale * dy[3 * i] );
        r[i] += f;
        r[i + w] -= f;
    }
}

// Sums of squares by rows, in doubles, in fixed order.
static double sum_squares( const RfGradientSystem* system, const float* r )
{
    size_t w = (size_t)system->width;
    double sum = 0.0;
    for ( int y = 0; y < system->height; ++y )
    {
        double row = 0.0;
        const float *values = r + (size_t)y * w, *inverse = system->inverse_diagonal + (size_t)y * w;
        for ( size_t x = 0; x < w; ++x )
        {
            double value = (double)( values[x] * inverse[x] );
            row += value * value;
        }
        sum += row;
    }
    return sum;
}

double rf_system_residual_norm( const RfGradientSystem* system, const float* r ) { return sqrt( sum_squares( system, r ) ); }

double rf_system_norm( const RfGradientSystem* system, const RfGradientImages* in, int channel, float scale )
{
    size_t w = (size_t)system->width, count = w * (size_t)system->height;
    const float *primal = in->primal + channel, *dx = in->dx + channel, *dy = in->dy + channel;
    const float *a = system->a, *b_x = system->b_x, *b_y = system->b_y, *inverse = system->inverse_diagonal;
    double of_primal = 0.0, of_gradients = 0.0;
    for ( size_t i = 0; i < count; ++i )
    {
        float value = masked( a[i], scale * primal[3 * i] ) * inverse[i];
        of_primal += (double)value * (double)value;
        float g = -masked( b_x[i], scale * dx[3 * i] ) - masked( b_y[i], scale * dy[3 * i] );
        g += i >= 1 ? masked( b_x[i - 1], scale * dx[3 * ( i - 1 )] ) : 0.0f;
        g += i >= w ? masked( b_y[i - w], scale * dy[3 * ( i - w )] ) : 0.0f;
        g *= inverse[i];
        of_gradients += (double)g * (double)g;
    }
    double norm = sqrt( of_primal ) + sqrt( of_gradients );
    return norm > 0.0 || RF_FAULT( zero_data ) ? norm : 1.0;
}
