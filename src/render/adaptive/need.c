// From a pilot's variances to extra samples per pixel: by the root of variance over cost, above the best threshold.
#include "render/adaptive/need.h"

#include "render/adaptive/adaptive.h"
#include "trace/trace.h"

#include <math.h>

#define BINS 64
// Cost of a sample beside that of a path: for each further camera of a group, and
// of an extra one, which comes in broken wavefronts.
#define COST_OF_EYE 0.05
#define COST_OF_EXTRA 1.2
#define COST_OF_EXTRA_NOISY 1.6 // packed into few batches, with a pilot that follows chains
#define LEAST_GAIN 0.02         // by these figures, which are rough
#define LOOK_GAIN 0.01          // that justifies a pilot: a coarse look may miss some of it
// The same with RF_ADAPTIVE_AUTO where materials differ in noise, of which little is known, too: samples that promised a fifth of
// error times cost brought nothing (src/reuse/tried.md).
#define LEAST_GAIN_NOISY 0.25
#define LOOK_GAIN_NOISY 0.2
// Where materials differ in noise: θ from the least to the most, over about so many pixels.
#define LEAST_THETA 0.05
#define MOST_THETA 64.0
#define THETA_STEP 1.1
#define SOME_PIXELS 1024

// rf_extra_threshold for gains from `least_gain` on.
static double threshold( const double* counts, int bins, double all, int eyes, double worth, double least_gain )
{
    double best = 1.0, least = 0.0, without = 0.0;
    for ( int step = 0; step <= 10 * ( RF_MOST_EXTRA - 1 ) * fmin( worth, 1.0 ); ++step )
    {
        double theta = 1.0 + 0.1 * step, error = 0.0, cost = all * ( 1.0 + COST_OF_EYE * ( eyes - 1 ) );
        for ( int b = 0; b < bins; ++b )
        {
            double info = (double)bins / ( b + 1 );
            error += counts[b] / fmax( info, theta );
            cost += counts[b] * COST_OF_EXTRA * fmax( 0.0, theta - info ) / worth;
        }
        without = step == 0 ? error * cost : without;
        if ( step > 0 && error * cost >= least )
            continue;
        best = theta;
        least = error * cost;
    }
    return least > ( 1.0 - least_gain ) * without ? 1.0 : best;
}

double rf_extra_threshold( const double* counts, int bins, double all, int eyes )
{
    return threshold( counts, bins, all, eyes, 1.0, LEAST_GAIN );
}

// The mean of ρ over the passes.
static float pixel_share( const RfPilotSums* sums, size_t i ) { return fminf( sums->share[i] / sums->passes, 1.0f ); }

// Which of the two measurements of variance is meant.
typedef enum Measured
{
    FIRST,
    SECOND,
    BOTH,
} Measured;

// The mean variance of a pixel's samples.
static float pixel_variance( const RfPilotSums* sums, size_t i, Measured which )
{
    if ( sums->noise == NULL || sums->noise[4 * i + 2] == 0.0f )
        return 1.0f;
    float variance = which == BOTH ? 0.5f * ( sums->noise[4 * i] + sums->noise[4 * i + 1] ) : sums->noise[4 * i + (size_t)which];
    return variance / sums->noise[4 * i + 2];
}

// The mean cost of a pixel's samples. Only ratios matter.
static float pixel_cost( const RfPilotSums* sums, size_t i )
{
    return sums->noise != NULL && sums->noise[4 * i + 2] > 0.0f ? sums->noise[4 * i + 3] / sums->noise[4 * i + 2] : 1.0f;
}

// Extra samples of a pixel in a pass: the error is least for its cost where samples go with the root of variance over cost.
static float extra_of( const RfPilotSums* sums, size_t i, Measured which, float share, double theta )
{
    float wanted = (float)theta * sqrtf( pixel_variance( sums, i, which ) / pixel_cost( sums, i ) );
    float extra = fmaxf( 0.0f, wanted - 1.0f / share ) / (float)sums->worth;
    return fminf( extra, RF_MOST_EXTRA_NOISY );
}

static void count_share( float share, double* counts )
{
    if ( share > 0.0f )
        counts[(int)fminf( share * BINS, BINS - 1 )] += 1.0;
}

// θ for the pixels with samples where all materials are alike.
static double threshold_alike( const RfPilotSums* sums, double least_gain )
{
    double counts[BINS] = { 0 }, seen = 0.0; // whole numbers: in any order the same
#pragma omp parallel reduction( + : seen, counts[:BINS] )
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( size_t i = 0; i < sums->pixels; ++i )
        {
            if ( sums->samples != NULL && sums->samples[i] == 0.0f )
                continue;
            count_share( pixel_share( sums, i ), counts );
            seen += 1.0;
        }
    }
    return threshold( counts, BINS, seen, sums->eyes, sums->worth, least_gain );
}

// Error times cost for a theta, over some pixels: of samples placed by one measurement, by the variances of another.
static double error_times_cost( const RfPilotSums* sums, Measured placed_by, Measured judged_by, double theta )
{
    size_t stride = sums->pixels / SOME_PIXELS + 1;
    double error = 0.0, cost = 0.0, passes = 0.0;
    for ( size_t i = 0; i < sums->pixels; i += stride )
    {
        if ( sums->samples != NULL && sums->samples[i] == 0.0f )
            continue;
        passes += (double)pixel_cost( sums, i );
        float share = pixel_share( sums, i );
        if ( share <= 0.0f )
            continue;
        float extra = extra_of( sums, i, placed_by, share, theta );
        error += (double)( pixel_variance( sums, i, judged_by ) / ( 1.0f / share + (float)sums->worth * extra ) );
        cost += COST_OF_EXTRA_NOISY * (double)( extra * pixel_cost( sums, i ) );
    }
    return error * ( passes * ( 1.0 + COST_OF_EYE * ( sums->eyes - 1 ) ) + cost );
}

// The theta that is best by one measurement. 0: no extra samples pay.
static double best_theta( const RfPilotSums* sums, Measured which )
{
    double least = error_times_cost( sums, which, which, 0.0 ), best = 0.0;
    for ( double theta = LEAST_THETA; theta <= MOST_THETA; theta *= THETA_STEP )
    {
        double product = error_times_cost( sums, which, which, theta );
        if ( product >= least )
            continue;
        least = product;
        best = theta;
    }
    return best;
}

// The same, where a margin is asked for. A few bright paths make a material look noisier than it is, and samples that are placed
// by them look better than they are. So what is placed by each measurement is judged by the other.
static double threshold_wary( const RfPilotSums* sums, double least_gain )
{
    double with = 0.0, without = 0.0;
    for ( int judge = FIRST; judge <= SECOND; ++judge )
    {
        Measured other = judge == FIRST ? SECOND : FIRST;
        double scale = error_times_cost( sums, other, (Measured)judge, 0.0 );
        if ( scale > 0.0 )
            with += error_times_cost( sums, other, (Measured)judge, best_theta( sums, other ) ) / scale;
        without += scale > 0.0;
    }
    return with > ( 1.0 - least_gain ) * without || without == 0.0 ? 0.0 : best_theta( sums, BOTH );
}

// The same where materials differ. 0: no extra samples pay.
static double threshold_noisy( const RfPilotSums* sums )
{
    if ( sums->wary )
        return threshold_wary( sums, LEAST_GAIN_NOISY );
    double theta = best_theta( sums, BOTH );
    bool pays = error_times_cost( sums, BOTH, BOTH, theta ) < ( 1.0 - LEAST_GAIN ) * error_times_cost( sums, BOTH, BOTH, 0.0 );
    return pays ? theta : 0.0;
}

bool rf_extra_may_pay( const RfPilotSums* sums )
{
    return sums->noise != NULL ? threshold_wary( sums, LOOK_GAIN_NOISY ) > 0.0 : threshold_alike( sums, LOOK_GAIN ) > 1.0;
}

float rf_set_need( const RfPilotSums* sums )
{
    double theta = sums->noise != NULL ? threshold_noisy( sums ) : threshold_alike( sums, LEAST_GAIN );
    float most = 0.0f;
#pragma omp parallel reduction( max : most )
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( size_t i = 0; i < sums->pixels; ++i )
        {
            float share = pixel_share( sums, i );
            sums->share[i] = share > 0.0f ? extra_of( sums, i, BOTH, share, theta ) : 0.0f;
            most = fmaxf( most, sums->share[i] );
        }
    }
    return most;
}
