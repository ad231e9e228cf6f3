// Solves the three channels: with constant weights by a cosine transform, else by conjugate gradients
// preconditioned by multigrid.
#include "gradient/solver.h"

#include "base/fault.h"
#include "trace/trace.h"

#include <fftw3.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define RESTARTS 4              // with the residual recomputed; conjugate gradients in floats drift from it
#define CONSTANT_TOLERANCE 1e-5 // of the direct solve, whose residual is that of rounding

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
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the cosine transform of %dx%d pixels", width, height );
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

static void place_solver( int width, int height, RfLayout* layout, RfGradientSolver* solver )
{
    rf_place_system( width, height, layout, &solver->system );
    rf_place_multigrid( &solver->system, layout, &solver->grid );
    for ( int c = 0; c < 3; ++c )
    {
        RfGradientChannel* channel = solver->channels + c;
        channel->u = rf_place_plane( width, height, layout );
        channel->r = rf_place_plane( width, height, layout );
        channel->p = rf_place_plane( width, height, layout );
        channel->q = rf_place_plane( width, height, layout );
        rf_place_multigrid_vectors( &solver->grid, layout, &channel->multigrid );
    }
}

static size_t pixels_of( const RfGradientChannel* channel ) { return (size_t)channel->in->width * (size_t)channel->in->height; }

void rf_read_primal( const RfGradientChannel* channel, float* plane )
{
    const float* primal = channel->in->primal + channel->index;
    size_t count = pixels_of( channel );
    for ( size_t i = 0; i < count; ++i )
        plane[i] = isfinite( primal[3 * i] ) ? channel->scale * primal[3 * i] : 0.0f;
}

// Σ a b in doubles, in fixed order.
static double dot( const float* a, const float* b, size_t count )
{
    double sums[4] = { 0.0, 0.0, 0.0, 0.0 };
    size_t i = 0;
    for ( ; i + 4 <= count; i += 4 )
    {
        for ( size_t k = 0; k < 4; ++k )
            sums[k] += (double)a[i + k] * (double)b[i + k];
    }
    for ( ; i < count; ++i )
        sums[0] += (double)a[i] * (double)b[i];
    return ( sums[0] + sums[1] ) + ( sums[2] + sums[3] );
}

// to += factor · from.
static void add_times( float* to, double factor, const float* from, size_t count )
{
    float f = (float)factor;
    for ( size_t i = 0; i < count; ++i )
        to[i] += f * from[i];
}

// Recomputes r and the relative residual.
static void measure( const RfGradientSystem* system, double norm, double tolerance, RfGradientChannel* channel )
{
    rf_system_residual( system, channel->in, channel->index, channel->scale, channel->u, channel->r );
    double residual = rf_system_residual_norm( system, channel->r );
    channel->residual = residual > 0.0 || RF_FAULT( zero_data ) ? residual / norm : 0.0;
    channel->converged = channel->residual <= tolerance;
}

// Moves u as a whole to Σ a (I − u) = 0, which the solution fulfils. Where a is small against b, floats would leave
// the level open else.
static void set_level( const RfGradientSystem* system, RfGradientChannel* channel )
{
    const float* primal = channel->in->primal + channel->index;
    size_t count = pixels_of( channel );
    double sum = 0.0, weights = 0.0;
    for ( size_t i = 0; i < count; ++i )
    {
        double a = (double)system->a[i];
        sum += a > 0.0 ? a * ( (double)( channel->scale * primal[3 * i] ) - (double)channel->u[i] ) : 0.0;
        weights += a;
    }
    float shift = weights > 0.0 ? (float)( sum / weights ) : 0.0f;
    for ( size_t i = 0; i < count; ++i )
        channel->u[i] += shift;
}

// Solves with weights a and 1 exactly, from the u that is there. `system` holds the same weights.
static void solve_channel_constant( const RfGradientSystem* system, const RfCosineTransform* transform, double a,
                                    RfGradientChannel* channel )
{
    double norm = rf_system_norm( system, channel->in, channel->index, channel->scale );
    // the second solve is for the rounding of the first: bright pixels_of leave traces everywhere
    for ( int i = 0; i < 2; ++i )
    {
        rf_system_residual( system, channel->in, channel->index, channel->scale, channel->u, channel->r );
        rf_solve_constant( transform, a, 1.0, 1.0, channel->r );
        add_times( channel->u, 1.0, channel->r, pixels_of( channel ) );
    }
    set_level( system, channel );
    measure( system, norm, CONSTANT_TOLERANCE, channel );
}

// Conjugate gradients for the correction to u, until the updated residual is below `bound`.
static void correct( const RfMultigrid* grid, double bound, int max_iterations, RfGradientChannel* channel )
{
    size_t count = pixels_of( channel );
    float *r = channel->r, *p = channel->p, *q = channel->q; // q is also the preconditioned residual
    rf_multigrid_cycle( grid, &channel->multigrid, r, q );
    memcpy( p, q, count * sizeof *p );
    double product = dot( r, q, count );
    while ( channel->iterations < max_iterations && product > 0.0 )
    {
        rf_system_apply( grid->levels, p, q );
        double energy = dot( p, q, count );
        if ( !( energy > 0.0 ) )
            return;
        add_times( channel->u, product / energy, p, count );
        add_times( r, -product / energy, q, count );
        channel->iterations += 1;
        if ( rf_system_residual_norm( grid->levels, r ) <= bound )
            return;
        rf_multigrid_cycle( grid, &channel->multigrid, r, q );
        double next = dot( r, q, count );
        float beta = (float)( next / product );
        for ( size_t i = 0; i < count; ++i )
            p[i] = q[i] + beta * p[i];
        product = next;
    }
}

// Solves by conjugate gradients, from the u that is there, to a relative residual of `tolerance`.
static void solve_channel( const RfMultigrid* grid, double tolerance, int max_iterations, RfGradientChannel* channel )
{
    double norm = rf_system_norm( grid->levels, channel->in, channel->index, channel->scale );
    int last = channel->iterations + max_iterations;
    measure( grid->levels, norm, tolerance, channel );
    for ( int i = 0; i < RESTARTS && !channel->converged && channel->iterations < last; ++i )
    {
        double before = channel->residual;
        correct( grid, 0.5 * tolerance * norm, last, channel );
        measure( grid->levels, norm, tolerance, channel );
        if ( channel->residual > 0.5 * before )
            break; // floats give no more
    }
}

size_t rf_reconstruct_bytes( int width, int height )
{
    RfGradientSolver solver;
    RfLayout layout = { 0 };
    place_solver( width, height, &layout, &solver );
    return layout.bytes;
}

RfResult rf_create_solver( const RfGradientImages* in, float scale, const RfReconstructOptions* options, RfGradientSolver* solver,
                           RfError* error )
{
    size_t bytes = rf_reconstruct_bytes( in->width, in->height );
    *solver = ( RfGradientSolver ){ 0 };
    solver->own = options->work == NULL ? aligned_alloc( 64, bytes ) : NULL;
    RfLayout layout = { .memory = options->work != NULL ? options->work : solver->own };
    if ( layout.memory == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a reconstruction of %dx%d pixels, %zu MiB", in->width,
                        in->height, bytes >> 20 );
    place_solver( in->width, in->height, &layout, solver );
    for ( int c = 0; c < 3; ++c )
    {
        RfGradientChannel* channel = solver->channels + c;
        channel->in = in;
        channel->index = c;
        channel->scale = scale;
        rf_read_primal( channel, channel->u );
    }
    return RF_OK;
}

void rf_destroy_solver( RfGradientSolver* solver )
{
    free( solver->own );
    solver->own = NULL;
}

// Sets constant weights: a, and 1 for gradients.
static void set_constant_weights( double a, RfGradientSolver* solver )
{
    RfGradientSystem* system = &solver->system;
    size_t w = (size_t)system->width, count = w * (size_t)system->height;
    for ( size_t i = 0; i < count; ++i )
    {
        system->a[i] = (float)a;
        system->b_x[i] = ( i + 1 ) % w != 0 ? 1.0f : 0.0f;
        system->b_y[i] = i + w < count ? 1.0f : 0.0f;
    }
    rf_finish_system( system );
}

void rf_solve_weighted( const RfReconstructOptions* options, RfGradientSolver* solver )
{
    rf_finish_system( &solver->system );
    rf_coarsen_multigrid( &solver->grid );
#pragma omp parallel for schedule( static, 1 )
    for ( int c = 0; c < 3; ++c )
    {
        rf_set_float_mode(); // light that fades out in the dark would take forever in subnormals
        solve_channel( &solver->grid, options->tolerance, options->max_iterations, solver->channels + c );
    }
}

RfResult rf_solve_constant_channels( double a, RfGradientSolver* solver, RfError* error )
{
    RfCosineTransform transform;
    const RfGradientSystem* system = &solver->system;
    set_constant_weights( a, solver );
    RfResult result = rf_create_transform( system->width, system->height, solver->channels[0].r, &transform, error );
    if ( result != RF_OK )
        return result;
#pragma omp parallel for schedule( static, 1 )
    for ( int c = 0; c < 3; ++c )
    {
        rf_set_float_mode();
        solve_channel_constant( system, &transform, a, solver->channels + c );
    }
    rf_destroy_transform( &transform );
    return RF_OK;
}

RfReconstructInfo rf_solver_info( const RfGradientSolver* solver )
{
    RfReconstructInfo info = { .converged = true };
    for ( int c = 0; c < 3; ++c )
    {
        const RfGradientChannel* channel = solver->channels + c;
        info.iterations = channel->iterations > info.iterations ? channel->iterations : info.iterations;
        info.residual = channel->residual > info.residual ? channel->residual : info.residual;
        info.converged = info.converged && channel->converged;
    }
    return info;
}

RfResult rf_write_solution( const RfGradientSolver* solver, double share, bool add, float* rgb, RfError* error )
{
    const RfGradientChannel* channels = solver->channels;
    size_t count = (size_t)solver->system.width * (size_t)solver->system.height;
    float factor = (float)( share / (double)channels[0].scale );
    bool finite = true;
    for ( size_t i = 0; i < count; ++i )
    {
        for ( size_t c = 0; c < 3; ++c )
        {
            float value = channels[c].u[i] * factor + ( add ? rgb[3 * i + c] : 0.0f );
            finite = finite && isfinite( value );
            rgb[3 * i + c] = value;
        }
    }
    return finite ? RF_OK : rf_fail( error, RF_ERROR_USAGE, "the gradients add up to more than a float holds" );
}
