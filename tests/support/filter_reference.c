#include "support/filter_reference.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846
#define STEPS 2000   // of Simpson's rule, even
#define FEW_STEPS 16 // over a part of a pixel

static double reach_of( RfFilter filter, double width ) { return filter == RF_FILTER_BOX ? 0.5 * width : width; }

double filter_value( RfFilter filter, double width, double x )
{
    double t = fabs( x ) / width;
    if ( fabs( x ) > reach_of( filter, width ) )
        return 0.0;
    switch ( filter )
    {
        case RF_FILTER_BOX: return 1.0;
        case RF_FILTER_TENT: return 1.0 - t;
        case RF_FILTER_GAUSSIAN: return exp( -0.5 * ( 4.0 * t ) * ( 4.0 * t ) );
        case RF_FILTER_BLACKMAN_HARRIS:
            return 0.35875 + 0.48829 * cos( PI * t ) + 0.14128 * cos( 2.0 * PI * t ) + 0.01168 * cos( 3.0 * PI * t );
    }
    return 0.0;
}

static double simpson( RfFilter filter, double width, double from, double to, int steps )
{
    double step = ( to - from ) / steps, sum = 0.0;
    for ( int i = 0; i <= steps; ++i )
        sum += ( i == 0 || i == steps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0 ) * filter_value( filter, width, from + i * step );
    return sum * step / 3.0;
}

double filter_integral( RfFilter filter, double width, double from, double to )
{
    double reach = reach_of( filter, width );
    from = fmin( fmax( from, -reach ), reach );
    to = fmin( fmax( to, -reach ), reach );
    return simpson( filter, width, from, to, STEPS ) / simpson( filter, width, -reach, reach, STEPS );
}

// weights[p·fine + i]: of fine pixel i in pixel p
static double* make_weights( RfFilter filter, double width, int times, int pixels )
{
    int fine = times * pixels;
    double* weights = calloc( (size_t)pixels * (size_t)fine, sizeof *weights );
    if ( weights == NULL )
        abort();
    for ( int p = 0; p < pixels; ++p )
    {
        double sum = 0.0, *row = weights + (size_t)p * (size_t)fine;
        for ( int i = 0; i < fine; ++i )
        {
            double reach = reach_of( filter, width );
            double from = fmin( fmax( (double)i / times - p - 0.5, -reach ), reach );
            double to = fmin( fmax( (double)( i + 1 ) / times - p - 0.5, -reach ), reach );
            row[i] = to > from ? simpson( filter, width, from, to, FEW_STEPS ) : 0.0;
            sum += row[i];
        }
        for ( int i = 0; i < fine; ++i )
            row[i] /= sum;
    }
    return weights;
}

void filter_picture( RfFilter filter, double filter_width, const float* fine, int times, int width, int height, float* rgb )
{
    double* across = make_weights( filter, filter_width, times, width );
    double* down = make_weights( filter, filter_width, times, height );
    int fine_width = times * width, fine_height = times * height;
    double* rows = calloc( 3 * (size_t)width * (size_t)fine_height, sizeof *rows );
    if ( rows == NULL )
        abort();
    for ( int y = 0; y < fine_height; ++y )
    {
        for ( int x = 0; x < 3 * width; ++x )
        {
            for ( int i = 0; i < fine_width; ++i )
                rows[(size_t)y * 3 * (size_t)width + (size_t)x] +=
                    across[( x / 3 ) * fine_width + i] * (double)fine[3 * ( y * fine_width + i ) + x % 3];
        }
    }
    for ( int y = 0; y < height; ++y )
    {
        for ( int x = 0; x < 3 * width; ++x )
        {
            double sum = 0.0;
            for ( int i = 0; i < fine_height; ++i )
                sum += down[y * fine_height + i] * rows[(size_t)i * 3 * (size_t)width + (size_t)x];
            rgb[y * 3 * width + x] = (float)sum;
        }
    }
    free( across );
    free( down );
    free( rows );
}
