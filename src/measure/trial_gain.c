// The gain of a trial over another one, and how sure it is.
#include "measure/trial.h"

#include <math.h>

// Where the ten worst pixels hold 30 % of an error, 19 of 20 errors are below twice what is seen (render/README.md, "At
// least"): rarer and larger ones have not been hit yet. So much is added to the margin of the error's logarithm, in
// proportion to the share that the worst cells hold.
#define TAIL_MARGIN ( 0.693147 / 0.3 )

#define TIME_NOISE 0.03 // the least standard deviation of the logarithm of seconds per sample

// Sums over the pieces that are common to both.
typedef struct Sums
{
    double weight[2], relmse[2];
} Sums;

static Sums sum_pieces( const RfTrial* const trials[2], int count )
{
    Sums s = { { 0.0, 0.0 }, { 0.0, 0.0 } };
    for ( int i = 0; i < count; ++i )
    {
        for ( int t = 0; t < 2; ++t )
        {
            s.weight[t] += trials[t]->pieces[i].weight;
            s.relmse[t] += trials[t]->pieces[i].relmse;
        }
    }
    return s;
}

// Share of a piece in the relMSE of a trial, less that in its pixels.
static double influence_on( const RfTrial* trial, int i, double weight, double relmse )
{
    return trial->pieces[i].relmse / relmse - trial->pieces[i].weight / weight;
}

static double time_variance( const RfTrial* trial )
{
    double variance = trial->time_count > 0 ? trial->time_noise / ( 4.0 * trial->time_count * trial->time_count ) : 0.0;
    return fmax( variance, TIME_NOISE * TIME_NOISE );
}

static double tail_margin( const RfTrial* trial )
{
    double worst = 0.0;
    for ( int k = 0; k < RF_WORST_CELLS; ++k )
        worst += trial->worst[k];
    return isgreater( trial->relmse, 0.0 ) ? TAIL_MARGIN * worst / trial->relmse : 0.0;
}

RfInterval rf_trial_gain( const RfTrial* plain, const RfTrial* reuse )
{
    const RfTrial* trials[2] = { plain, reuse };
    double influence[RF_TRIAL_PIECES];
    int count = plain->piece_count < reuse->piece_count ? plain->piece_count : reuse->piece_count;
    Sums s = sum_pieces( trials, count );
    // cost times both weights
    double plain_cost = s.relmse[0] * s.weight[1] * rf_trial_sample_seconds( plain );
    double reuse_cost = s.relmse[1] * s.weight[0] * rf_trial_sample_seconds( reuse );
    if ( !isgreater( plain_cost, 0.0 ) || !isgreater( reuse_cost, 0.0 ) || isinf( plain_cost ) || isinf( reuse_cost ) )
        return ( RfInterval ){ (double)NAN, (double)NAN, (double)NAN };
    double value = plain_cost / reuse_cost;
    for ( int i = 0; i < count; ++i )
        influence[i] = influence_on( plain, i, s.weight[0], s.relmse[0] ) - influence_on( reuse, i, s.weight[1], s.relmse[1] );
    double margin = rf_influence_margin( influence, count, time_variance( plain ) + time_variance( reuse ) );
    double plain_tail = tail_margin( plain ), reuse_tail = tail_margin( reuse );
    return rf_log_interval( value, sqrt( margin * margin + plain_tail * plain_tail + reuse_tail * reuse_tail ) );
}
