// Smooths the results of trials over the rows. Error and time per sample vary smoothly with
// the size of the group, and similarly for all tiles, but the noise of a trial does not: a
// firefly hits one group and not the next, and other load on the machine hits one trial and
// not the next. So the logarithm of each is fitted by
//
//     q(x) + u_tile + v_tile x,    x = log of the frames in a group, q a cubic,
//
// and each row is shrunk towards the fit, the more the larger its own noise (estimated from
// the residuals) is compared to the model error of the fit.
#include "measure/tune_internal.h"

#include <math.h>
#include <string.h>

#define MAX_TERMS ( 4 + 2 * ( RF_TUNE_TILES - 1 ) )
#define FIT_ERROR 0.06  // model error: standard deviation of true values about the fit, in logarithms
#define FIRST_NOISE 0.2 // initial guess for a first trial

typedef struct Point
{
    double terms[MAX_TERMS];
    double value;    // logarithm of the measured value
    double evidence; // relative weight of its trials; the smallest is 1
    int row;
} Point;

typedef struct Fit
{
    Point points[RF_TUNE_ROWS];
    int count, terms;
} Fit;

static int tile_number( const RfTune* tune, int row )
{
    int number = 0;
    for ( int i = 1; i <= row; ++i )
        number += memcmp( &tune->rows[i].tile, &tune->rows[i - 1].tile, sizeof tune->rows[i].tile ) != 0;
    return number;
}

// Number of group sizes that have been tried with any tile.
static int count_groups( const RfTune* tune )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
    {
        bool known = tune->rows[i].rounds == 0;
        for ( int k = 0; k < i && !known; ++k )
            known = tune->rows[k].rounds > 0 && tune->rows[k].eyes == tune->rows[i].eyes;
        count += !known;
    }
    return count;
}

static void collect( const RfTune* tune, bool time, Fit* fit )
{
    int groups = count_groups( tune ), powers = groups < 4 ? groups : 4;
    double least = (double)INFINITY;
    fit->count = 0;
    fit->terms = powers + 2 * ( RF_TUNE_TILES - 1 );
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTrial* trial = &tune->rows[i].trial;
        if ( tune->rows[i].rounds == 0 )
            continue;
        double measured = time ? rf_trial_sample_seconds( trial ) : rf_tune_error( tune, trial );
        if ( !isgreater( measured, 0.0 ) || isinf( measured ) )
            continue;
        Point* p = fit->points + fit->count++;
        *p = ( Point ){ .value = log( measured ), .evidence = trial->weight, .row = i };
        least = p->evidence < least ? p->evidence : least;
        double x = log( tune->rows[i].eyes ), power = 1.0;
        for ( int k = 0; k < powers; ++k, power *= x )
            p->terms[k] = power;
        int tile = tile_number( tune, i );
        if ( tile > 0 )
        {
            p->terms[powers + 2 * ( tile - 1 )] = 1.0;
            p->terms[powers + 2 * ( tile - 1 ) + 1] = x;
        }
    }
    for ( int i = 0; i < fit->count; ++i )
        fit->points[i].evidence /= least;
}

// Solves the symmetric, positive definite system m c = v by elimination; v receives c.
static void solve( double m[MAX_TERMS][MAX_TERMS], double v[MAX_TERMS], int n )
{
    for ( int i = 0; i < n; ++i )
    {
        for ( int r = i + 1; r < n; ++r )
        {
            double factor = m[r][i] / m[i][i];
            for ( int c = i; c < n; ++c )
                m[r][c] -= factor * m[i][c];
            v[r] -= factor * v[i];
        }
    }
    for ( int i = n - 1; i >= 0; --i )
    {
        for ( int c = i + 1; c < n; ++c )
            v[i] -= m[i][c] * v[c];
        v[i] /= m[i][i];
    }
}

static double noise_of( const Point* p, double first ) { return first * first / p->evidence; }

// Weighted least squares; terms without data come out as 0.
static void fit_terms( const Fit* fit, double noise, double terms[MAX_TERMS] )
{
    double m[MAX_TERMS][MAX_TERMS] = { { 0.0 } };
    memset( terms, 0, MAX_TERMS * sizeof *terms );
    for ( int k = 0; k < fit->terms; ++k )
        m[k][k] = 1e-6;
    for ( int i = 0; i < fit->count; ++i )
    {
        const Point* p = fit->points + i;
        double weight = 1.0 / ( FIT_ERROR * FIT_ERROR + noise_of( p, noise ) );
        for ( int r = 0; r < fit->terms; ++r )
        {
            for ( int c = 0; c < fit->terms; ++c )
                m[r][c] += weight * p->terms[r] * p->terms[c];
            terms[r] += weight * p->terms[r] * p->value;
        }
    }
    solve( m, terms, fit->terms );
}

static double fitted( const Fit* fit, const double terms[MAX_TERMS], const Point* p )
{
    double sum = 0.0;
    for ( int k = 0; k < fit->terms; ++k )
        sum += terms[k] * p->terms[k];
    return sum;
}

static void smooth_rows( RfTune* tune, bool time )
{
    Fit fit;
    collect( tune, time, &fit );
    int free_terms = fit.count - fit.terms;
    if ( free_terms <= 0 ) // the fit would interpolate all of them
        return;
    double terms[MAX_TERMS], sum = 0.0;
    fit_terms( &fit, FIRST_NOISE, terms );
    for ( int i = 0; i < fit.count; ++i )
    {
        double away = fit.points[i].value - fitted( &fit, terms, fit.points + i );
        sum += away * away * fit.points[i].evidence;
    }
    double noise = sqrt( sum / free_terms );
    fit_terms( &fit, noise, terms );
    for ( int i = 0; i < fit.count; ++i )
    {
        const Point* p = fit.points + i;
        double by_noise = noise_of( p, noise ), away = fitted( &fit, terms, p ) - p->value;
        double move = away * by_noise / ( by_noise + FIT_ERROR * FIT_ERROR );
        *( time ? &tune->rows[p->row].log_time : &tune->rows[p->row].log_error ) = move;
    }
}

void rf_smooth_tune_rows( RfTune* tune )
{
    for ( int i = 0; i < tune->count; ++i )
        tune->rows[i].log_time = tune->rows[i].log_error = 0.0;
    smooth_rows( tune, false );
    smooth_rows( tune, true );
}
