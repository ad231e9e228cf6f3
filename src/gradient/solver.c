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

// The linear system, for one channel: (diag a + Dᵀ B D) u = a I + Dᵀ B Δ, where D takes the differences of neighbours.
// Matrix-free: the weights are the matrix. A plane is width·height floats with a row of zeros before and after it, so that the
// operator is one loop without borders.
//
// Its preconditioner is a multigrid V-cycle. On each level 2x2 pixels become one: their a is added, and so is half of each b
// across the new border. Unlike a cosine transform with the mean of the weights it follows weights that differ by orders of
// magnitude.

#define DAMPING 0.8f      // of the Jacobi steps; below 1 they converge for every such matrix
#define COARSEST_STEPS 16 // Jacobi steps on the coarsest level, of a few pixels

// Floats before the first pixel: at least a row, and a multiple of 16 for the alignment.
static size_t lead( int width ) { return ( (size_t)width + 15 ) / 16 * 16; }

// Zeroes the rows before and after. The plane is aligned to 64.
static float* place_plane( int width, int height, RfLayout* layout )
{
    size_t before = lead( width ), count = (size_t)width * (size_t)height;
    float* first = rf_take( layout, before + count + before, sizeof *first );
    if ( first == NULL )
        return NULL;
    memset( first, 0, before * sizeof *first );
    memset( first + before + count, 0, before * sizeof *first );
    return first + before;
}

static void finish_system( RfGradientSystem* system )
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

// to = (diag a + Dᵀ B D) u.
static void system_apply( const RfGradientSystem* system, const float* u, float* to )
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

// r = right-hand side − matrix · u for the channel, of data times `scale`. The sums cancel best where u is close
// to the data: no large numbers are subtracted that are not neighbours.
static void system_residual( const RfGradientSystem* system, const RfGradientImages* in, int channel, float scale, const float* u,
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

// ‖r / diagonal‖: sums of squares by rows, in doubles, in fixed order.
static double system_residual_norm( const RfGradientSystem* system, const float* r )
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
    return sqrt( sum );
}

// Norm of the data in the units of r over the diagonal, by which residuals are divided:
// ‖a I / diagonal‖ + ‖Dᵀ B Δ / diagonal‖, or 1 where that is 0.
static double system_norm( const RfGradientSystem* system, const RfGradientImages* in, int channel, float scale )
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
    finish_system( coarse );
}

static void coarsen_multigrid( RfMultigrid* grid )
{
    for ( int k = 1; k < grid->count; ++k )
        coarsen( grid->levels + k - 1, grid->levels + k );
}

static void place_system( int width, int height, RfLayout* layout, RfGradientSystem* system )
{
    system->width = width, system->height = height;
    system->a = place_plane( width, height, layout );
    system->b_x = place_plane( width, height, layout );
    system->b_y = place_plane( width, height, layout );
    system->inverse_diagonal = place_plane( width, height, layout );
}

// The levels below `system`; coarsen_multigrid computes them.
static void place_multigrid( const RfGradientSystem* system, RfLayout* layout, RfMultigrid* grid )
{
    grid->count = 1;
    grid->levels[0] = *system;
    int width = system->width, height = system->height;
    while ( !is_coarsest( width, height ) && grid->count < RF_MULTIGRID_LEVELS )
    {
        width = half_of( width ), height = half_of( height );
        place_system( width, height, layout, grid->levels + grid->count++ );
    }
}

static void place_multigrid_vectors( const RfMultigrid* grid, RfLayout* layout, RfMultigridVectors* vectors )
{
    for ( int k = 0; k < grid->count; ++k )
    {
        int width = grid->levels[k].width, height = grid->levels[k].height;
        vectors->t[k] = place_plane( width, height, layout );
        vectors->x[k] = k > 0 ? place_plane( width, height, layout ) : NULL;
        vectors->b[k] = k > 0 ? place_plane( width, height, layout ) : NULL;
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
    system_apply( s, x, t );
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

// From level k on: x ≈ the solution of (matrix) x = b, by a symmetric positive definite operator.
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
    system_apply( s, x, v->t[k] );
    restrict_residual( s, s + 1, b, v->t[k], v->b[k + 1] );
    cycle( grid, v, k + 1, v->b[k + 1], v->x[k + 1] );
    prolong( s, s + 1, v->x[k + 1], x );
    step( s, b, x, v->t[k] );
    step( s, b, x, v->t[k] );
}

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

// Frees the plans. Takes an empty struct.
static void destroy_transform( RfCosineTransform* transform )
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

// Plans transforms of width·height floats in place. Any thread may call it. The plan depends on the size alone
// (FFTW_ESTIMATE). `plane` is any plane, which is not changed. Fails with RF_ERROR_MEMORY.
static RfResult create_transform( int width, int height, float* plane, RfCosineTransform* transform, RfError* error )
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
    destroy_transform( transform );
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the cosine transform of %dx%d pixels", width, height );
}

// Solves (a + b_x Dxᵀ Dx + b_y Dyᵀ Dy) u = r in place, for constant weights, a > 0. `plane` is aligned as the one of the
// plan. Several threads may use one transform.
static void solve_constant( const RfCosineTransform* transform, double a, double b_x, double b_y, float* plane )
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
    place_system( width, height, layout, &solver->system );
    place_multigrid( &solver->system, layout, &solver->grid );
    for ( int c = 0; c < 3; ++c )
    {
        RfGradientChannel* channel = solver->channels + c;
        channel->u = place_plane( width, height, layout );
        channel->r = place_plane( width, height, layout );
        channel->p = place_plane( width, height, layout );
        channel->q = place_plane( width, height, layout );
        place_multigrid_vectors( &solver->grid, layout, &channel->multigrid );
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

static void add_times( float* to, double factor, const float* from, size_t count )
{
    float f = (float)factor;
    for ( size_t i = 0; i < count; ++i )
        to[i] += f * from[i];
}

// Recomputes r and the relative residual.
static void measure( const RfGradientSystem* system, double norm, double tolerance, RfGradientChannel* channel )
{
    system_residual( system, channel->in, channel->index, channel->scale, channel->u, channel->r );
    double residual = system_residual_norm( system, channel->r );
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
    double norm = system_norm( system, channel->in, channel->index, channel->scale );
    // the second solve is for the rounding of the first: bright pixels leave traces everywhere
    for ( int i = 0; i < 2; ++i )
    {
        system_residual( system, channel->in, channel->index, channel->scale, channel->u, channel->r );
        solve_constant( transform, a, 1.0, 1.0, channel->r );
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
    cycle( grid, &channel->multigrid, 0, r, q );
    memcpy( p, q, count * sizeof *p );
    double product = dot( r, q, count );
    while ( channel->iterations < max_iterations && product > 0.0 )
    {
        system_apply( grid->levels, p, q );
        double energy = dot( p, q, count );
        if ( !( energy > 0.0 ) )
            return;
        add_times( channel->u, product / energy, p, count );
        add_times( r, -product / energy, q, count );
        channel->iterations += 1;
        if ( system_residual_norm( grid->levels, r ) <= bound )
            return;
        cycle( grid, &channel->multigrid, 0, r, q );
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
    double norm = system_norm( grid->levels, channel->in, channel->index, channel->scale );
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
    finish_system( system );
}

void rf_solve_weighted( const RfReconstructOptions* options, RfGradientSolver* solver )
{
    finish_system( &solver->system );
    coarsen_multigrid( &solver->grid );
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
    RfResult result = create_transform( system->width, system->height, solver->channels[0].r, &transform, error );
    if ( result != RF_OK )
        return result;
#pragma omp parallel for schedule( static, 1 )
    for ( int c = 0; c < 3; ++c )
    {
        rf_set_float_mode();
        solve_channel_constant( system, &transform, a, solver->channels + c );
    }
    destroy_transform( &transform );
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
