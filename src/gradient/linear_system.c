// The system as an operator on planes, its residual, and the multigrid cycle.
#include "gradient/linear_system.h"

#include "base/fault.h"

#include <math.h>
#include <string.h>

#define DAMPING 0.8f      // of the Jacobi steps; below 1 they converge for every such matrix
#define COARSEST_STEPS 16 // Jacobi steps on the coarsest level, of a few pixels

// Floats before the first pixel: at least a row, and a multiple of 16 for the alignment.
static size_t lead( int width ) { return ( (size_t)width + 15 ) / 16 * 16; }

float* rf_place_plane( int width, int height, RfLayout* layout )
{
    size_t before = lead( width ), count = (size_t)width * (size_t)height;
    float* first = rf_take( layout, before + count + before, sizeof *first );
    if ( first == NULL )
        return NULL;
    memset( first, 0, before * sizeof *first );
    memset( first + before + count, 0, before * sizeof *first );
    return first + before;
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

static int half_of( int n ) { return ( n + 1 ) / 2; }

static bool is_coarsest( int width, int height ) { return width <= 2 && height <= 2; }

static float weight_at( const RfGradientSystem* s, const float* plane, int x, int y )
{
    return x < s->width && y < s->height ? plane[(size_t)y * (size_t)s->width + (size_t)x] : 0.0f;
}

static void coarsen( const RfGradientSystem* fine, RfGradientSystem* coarse )
{
    for ( int y = 0; y < coarse->height; ++y )
    {
        for ( int x = 0; x < coarse->width; ++x )
        {
            size_t i = (size_t)y * (size_t)coarse->width + (size_t)x;
            float a = 0.0f, b_x = 0.0f, b_y = 0.0f;
            for ( int k = 0; k < 2; ++k )
            {
                a += weight_at( fine, fine->a, 2 * x, 2 * y + k ) + weight_at( fine, fine->a, 2 * x + 1, 2 * y + k );
                b_x += weight_at( fine, fine->b_x, 2 * x + 1, 2 * y + k );
                b_y += weight_at( fine, fine->b_y, 2 * x + k, 2 * y + 1 );
            }
            coarse->a[i] = a;
            coarse->b_x[i] = 0.5f * b_x; // a pair twice as far apart
            coarse->b_y[i] = 0.5f * b_y;
        }
    }
    rf_finish_system( coarse );
}

void rf_coarsen_multigrid( RfMultigrid* grid )
{
    for ( int k = 1; k < grid->count; ++k )
        coarsen( grid->levels + k - 1, grid->levels + k );
}

void rf_place_system( int width, int height, RfLayout* layout, RfGradientSystem* system )
{
    system->width = width, system->height = height;
    system->a = rf_place_plane( width, height, layout );
    system->b_x = rf_place_plane( width, height, layout );
    system->b_y = rf_place_plane( width, height, layout );
    system->inverse_diagonal = rf_place_plane( width, height, layout );
}

void rf_place_multigrid( const RfGradientSystem* system, RfLayout* layout, RfMultigrid* grid )
{
    grid->count = 1;
    grid->levels[0] = *system;
    int width = system->width, height = system->height;
    while ( !is_coarsest( width, height ) && grid->count < RF_MULTIGRID_LEVELS )
    {
        width = half_of( width ), height = half_of( height );
        rf_place_system( width, height, layout, grid->levels + grid->count++ );
    }
}

void rf_place_multigrid_vectors( const RfMultigrid* grid, RfLayout* layout, RfMultigridVectors* vectors )
{
    for ( int k = 0; k < grid->count; ++k )
    {
        int width = grid->levels[k].width, height = grid->levels[k].height;
        vectors->t[k] = rf_place_plane( width, height, layout );
        vectors->x[k] = k > 0 ? rf_place_plane( width, height, layout ) : NULL;
        vectors->b[k] = k > 0 ? rf_place_plane( width, height, layout ) : NULL;
    }
}

// x = DAMPING · b / diagonal: a step from 0.
static void first_step( const RfGradientSystem* s, const float* b, float* x )
{
    size_t count = (size_t)s->width * (size_t)s->height;
    for ( size_t i = 0; i < count; ++i )
        x[i] = DAMPING * s->inverse_diagonal[i] * b[i];
}

// One more, through t.
static void step( const RfGradientSystem* s, const float* b, float* x, float* t )
{
    size_t count = (size_t)s->width * (size_t)s->height;
    rf_system_apply( s, x, t );
    for ( size_t i = 0; i < count; ++i )
        x[i] += DAMPING * s->inverse_diagonal[i] * ( b[i] - t[i] );
}

// Sums of b − t over 2x2 pixels.
static void restrict_residual( const RfGradientSystem* fine, const RfGradientSystem* coarse, const float* b, const float* t,
                               float* to )
{
    int w = fine->width;
    memset( to, 0, sizeof( float ) * (size_t)coarse->width * (size_t)coarse->height );
    for ( int y = 0; y < fine->height; ++y )
    {
        const float *row_b = b + (size_t)y * (size_t)w, *row_t = t + (size_t)y * (size_t)w;
        float* row = to + (size_t)( y / 2 ) * (size_t)coarse->width;
        for ( int x = 0; x + 1 < w; x += 2 )
            row[x / 2] += ( row_b[x] - row_t[x] ) + ( row_b[x + 1] - row_t[x + 1] );
        if ( w % 2 == 1 )
            row[w / 2] += row_b[w - 1] - row_t[w - 1];
    }
}

static void prolong( const RfGradientSystem* fine, const RfGradientSystem* coarse, const float* from, float* x )
{
    int w = fine->width;
    for ( int y = 0; y < fine->height; ++y )
    {
        const float* row = from + (size_t)( y / 2 ) * (size_t)coarse->width;
        float* to = x + (size_t)y * (size_t)w;
        for ( int k = 0; k < w; ++k )
            to[k] += row[k / 2];
    }
}

static void cycle( const RfMultigrid* grid, const RfMultigridVectors* v, int k, const float* b, float* x )
{
    const RfGradientSystem* s = grid->levels + k;
    first_step( s, b, x );
    if ( k + 1 == grid->count )
    {
        for ( int i = 0; i < COARSEST_STEPS; ++i )
            step( s, b, x, v->t[k] );
        return;
    }
    step( s, b, x, v->t[k] );
    rf_system_apply( s, x, v->t[k] );
    restrict_residual( s, s + 1, b, v->t[k], v->b[k + 1] );
    cycle( grid, v, k + 1, v->b[k + 1], v->x[k + 1] );
    prolong( s, s + 1, v->x[k + 1], x );
    step( s, b, x, v->t[k] );
    step( s, b, x, v->t[k] );
}

void rf_multigrid_cycle( const RfMultigrid* grid, const RfMultigridVectors* vectors, const float* r, float* z )
{
    cycle( grid, vectors, 0, r, z );
}
