#include "gradient/transform.h"

#include <fftw3.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>

// FFTW plans share tables: one thread at a time.
static pthread_mutex_t s_planner = PTHREAD_MUTEX_INITIALIZER;

// Eigenvalue k of Dᵀ D for n pixels: 2 − 2 cos(π k / n), without cancellation.
static double eigenvalue( int k, int n )
{
    double s = sin( 0.5 * 3.14159265358979323846 * (double)k / (double)n );
    return 4.0 * s * s;
}

RfResult rf_create_transform( int width, int height, float* plane, RfCosineTransform* transform, RfError* error )
{
    *transform = ( RfCosineTransform ){ .width = width, .height = height };
    transform->eigenvalues = malloc( (size_t)width * sizeof *transform->eigenvalues );
    for ( int x = 0; x < width && transform->eigenvalues != NULL; ++x )
        transform->eigenvalues[x] = eigenvalue( x, width );
    pthread_mutex_lock( &s_planner );
    transform->forward = fftwf_plan_r2r_2d( height, width, plane, plane, FFTW_REDFT10, FFTW_REDFT10, FFTW_ESTIMATE );
    transform->backward = fftwf_plan_r2r_2d( height, width, plane, plane, FFTW_REDFT01, FFTW_REDFT01, FFTW_ESTIMATE );
    pthread_mutex_unlock( &s_planner );
    if ( transform->forward != NULL && transform->backward != NULL && transform->eigenvalues != NULL )
        return RF_OK;
    rf_destroy_transform( transform );
    return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the cosine transform of %dx%d pixels", width, height );
}

void rf_destroy_transform( RfCosineTransform* transform )
{
    pthread_mutex_lock( &s_planner );
    if ( transform->forward != NULL )
        fftwf_destroy_plan( transform->forward );
    if ( transform->backward != NULL )
        fftwf_destroy_plan( transform->backward );
    pthread_mutex_unlock( &s_planner );
    free( transform->eigenvalues );
    *transform = ( RfCosineTransform ){ 0 };
}

void rf_solve_constant( const RfCosineTransform* transform, double a, double b_x, double b_y, float* plane )
{
    int w = transform->width, h = transform->height;
    fftwf_execute_r2r( transform->forward, plane, plane );
    double scale = 0.25 / ( (double)w * (double)h ); // of forward and backward: 2 w · 2 h
    for ( int y = 0; y < h; ++y )
    {
        double row = a + b_y * eigenvalue( y, h );
        float* values = plane + (size_t)y * (size_t)w;
        for ( int x = 0; x < w; ++x )
            values[x] *= (float)( scale / ( row + b_x * transform->eigenvalues[x] ) );
    }
    fftwf_execute_r2r( transform->backward, plane, plane );
}
