// L1 by iteratively reweighted least squares: the weight of each datum is the inverse of how far the last solution
// is from it. Weights that come from the data themselves make it biased.

#include "gradient/solver.h"

#include <math.h>

#define FIRST_FLOOR 0.05f // of distances, relative to the mean of the primal; it is halved in each round
#define LAST_FLOOR 1e-4f
#define SETTLED 1e-3         // relative change of the norm in a round
#define ROUND_TOLERANCE 1e-3 // of the solves before the last

// Distance over the three channels of a datum (at index `at` of `rgb`) from u_j − u_i, or from u_i where j is i.
static float distance( const RfGradientSolver* solver, const float* rgb, size_t i, size_t j )
{
    float sum = 0.0f;
    for ( int c = 0; c < 3; ++c )
    {
        const RfGradientChannel* channel = solver->channels + c;
        float value = i == j ? channel->u[i] : channel->u[j] - channel->u[i];
        float difference = value - channel->scale * rgb[3 * i + (size_t)c];
        sum += difference * difference;
    }
    return sqrtf( sum );
}

static float weight_of( float distance, float floor ) { return 1.0f / ( distance > floor ? distance : floor ); }

// Sets the weights by the solution, and returns its L1 norm.
static double reweigh( float alpha, float floor, RfGradientSolver* solver )
{
    RfGradientSystem* system = &solver->system;
    const RfGradientImages* in = solver->channels[0].in;
    size_t w = (size_t)system->width;
    double norm = 0.0;
    for ( int y = 0; y < system->height; ++y )
    {
        double row = 0.0;
        for ( size_t x = 0; x < w; ++x )
        {
            size_t i = (size_t)y * w + x;
            float d = distance( solver, in->primal, i, i );
            system->a[i] = alpha * weight_of( d, floor );
            row += (double)( alpha * d );
            if ( x + 1 < w )
            {
                d = distance( solver, in->dx, i, i + 1 );
                system->b_x[i] = weight_of( d, floor );
                row += (double)d;
            }
            if ( y + 1 < system->height )
            {
                d = distance( solver, in->dy, i, i + w );
                system->b_y[i] = weight_of( d, floor );
                row += (double)d;
            }
        }
        norm += row;
    }
    return norm;
}

static float mean_of_primal( const RfGradientSolver* solver )
{
    const RfGradientSystem* system = &solver->system;
    const RfGradientImages* in = solver->channels[0].in;
    size_t count = 3 * (size_t)system->width * (size_t)system->height;
    double sum = 0.0;
    for ( size_t i = 0; i < count; ++i )
        sum += fabs( (double)( in->primal[i] * solver->channels[0].scale ) );
    return (float)( sum / (double)count );
}

void rf_solve_l1( const RfReconstructOptions* options, RfGradientSolver* solver, bool* settled )
{
    float mean = mean_of_primal( solver );
    float floor = FIRST_FLOOR * ( mean > 0.0f ? mean : 1.0f ), least = floor * ( LAST_FLOOR / FIRST_FLOOR );
    double before = reweigh( options->alpha, floor, solver );
    RfReconstructOptions coarse = *options;
    coarse.tolerance = fmax( ROUND_TOLERANCE, options->tolerance );
    *settled = false;
    for ( int round = 1; round < options->l1_rounds && !( *settled && floor <= least ); ++round )
    {
        rf_solve_weighted( &coarse, solver );
        floor = 0.5f * floor > least ? 0.5f * floor : least;
        double norm = reweigh( options->alpha, floor, solver );
        *settled = fabs( before - norm ) <= SETTLED * norm;
        before = norm;
    }
    rf_solve_weighted( options, solver );
}
