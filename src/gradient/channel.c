#include "gradient/channel.h"

#include "base/fault.h"

#include <math.h>
#include <string.h>

#define RESTARTS 4              // with the residual computed anew; conjugate gradients in floats drift from it
#define CONSTANT_TOLERANCE 1e-5 // of the direct solve, whose residual is that of rounding

size_t rf_channel_bytes( int width, int height )
{
    return 4 * rf_plane_bytes( width, height ) + rf_multigrid_vector_bytes( width, height );
}

void rf_build_channel( const RfMultigrid* grid, char** memory, RfGradientChannel* channel )
{
    int width = grid->levels[0].width, height = grid->levels[0].height;
    channel->u = rf_plane( width, height, memory );
    channel->r = rf_plane( width, height, memory );
    channel->p = rf_plane( width, height, memory );
    channel->q = rf_plane( width, height, memory );
    rf_build_multigrid_vectors( grid, memory, &channel->multigrid );
}

static size_t pixels( const RfGradientChannel* channel ) { return (size_t)channel->in->width * (size_t)channel->in->height; }

void rf_read_primal( const RfGradientChannel* channel, float* plane )
{
    const float* primal = channel->in->primal + channel->index;
    size_t count = pixels( channel );
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
static void add( float* to, double factor, const float* from, size_t count )
{
    float f = (float)factor;
    for ( size_t i = 0; i < count; ++i )
        to[i] += f * from[i];
}

// Computes r anew and the relative residual.
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
    size_t count = pixels( channel );
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

void rf_solve_channel_constant( const RfGradientSystem* system, const RfCosineTransform* transform, double a,
                                RfGradientChannel* channel )
{
    double norm = rf_system_norm( system, channel->in, channel->index, channel->scale );
    // the second solve is for the rounding of the first: bright pixels leave traces everywhere
    for ( int i = 0; i < 2; ++i )
    {
        rf_system_residual( system, channel->in, channel->index, channel->scale, channel->u, channel->r );
        rf_solve_constant( transform, a, 1.0, 1.0, channel->r );
        add( channel->u, 1.0, channel->r, pixels( channel ) );
    }
    set_level( system, channel );
    measure( system, norm, CONSTANT_TOLERANCE, channel );
}

// Conjugate gradients for the correction to u, until the updated residual is below `bound`.
static void correct( const RfMultigrid* grid, double bound, int max_iterations, RfGradientChannel* channel )
{
    size_t count = pixels( channel );
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
        add( channel->u, product / energy, p, count );
        add( r, -product / energy, q, count );
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

void rf_solve_channel( const RfMultigrid* grid, double tolerance, int max_iterations, RfGradientChannel* channel )
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
