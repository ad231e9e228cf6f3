#include "render/stop_pool.h"

#include "render/pair_rule.h"

#include <math.h>

// The goals that frames are estimated for.
enum
{
    NOISE,
    FLICKER,
    GOALS
};

static double wanted_of( const RfStop* stop, int goal ) { return goal == NOISE ? stop->goals.noise : stop->goals.flicker; }

// v of a frame for a goal; NaN: not known.
static double value_of( const RfFrameNoise* f, int goal )
{
    double value = goal == NOISE ? f->noise : f->flicker;
    return f->seen > 0.0 && isfinite( value ) ? value : (double)NAN;
}

bool rf_is_known( const RfStop* stop, const RfFrameNoise* f )
{
    bool noise = !isnan( value_of( f, NOISE ) ), flicker = !isnan( value_of( f, FLICKER ) );
    return stop->goals.noise > 0.0 ? noise : stop->goals.flicker > 0.0 && flicker;
}

// An estimate counts more the closer its frame and the more passes it is made from: with few
// passes it is noisy, and too high, since the cross-fitted quotients are noisy, too.
static double pooling_weight( const RfStop* stop, const RfFrameNoise* f, int frame )
{
    double reach = fmax( 1.0, stop->plan.eyes / 4.0 ), d = ( f->frame - frame ) / reach;
    return f->seen * f->seen / ( 1.0 + d * d );
}

// Sums over the estimated and the finished frames around one.
typedef struct Pool
{
    double noise, noise_weights;
    RfPairNoise pair; // summed
    double pair_weights;
} Pool;

static void pool( const RfStop* stop, const RfFrameNoise* f, int frame, Pool* pool )
{
    double noise = value_of( f, NOISE ), weight = pooling_weight( stop, f, frame );
    if ( !isnan( noise ) )
    {
        pool->noise += weight * noise;
        pool->noise_weights += weight;
    }
    if ( f->seen > 0.0 && isfinite( f->pair.variance ) && isfinite( f->pair.covariance ) )
    {
        pool->pair.variance += weight * f->pair.variance;
        pool->pair.covariance += weight * f->pair.covariance;
        pool->pair_weights += weight;
    }
}

static Pool pool_all( const RfStop* stop, const RfNoiseEstimates* look, int frame )
{
    Pool sums = { 0 };
    for ( int i = 0; i < look->count; ++i )
        pool( stop, look->frames + i, frame, &sums );
    for ( int i = 0; i < stop->finished_count && i < RF_STOP_HISTORY; ++i )
        pool( stop, stop->finished + i, frame, &sums );
    return sums;
}

static double noise_of( const Pool* p ) { return p->noise_weights > 0.0 ? p->noise / p->noise_weights : (double)NAN; }

static RfPairNoise pair_of( const Pool* p )
{
    double w = p->pair_weights > 0.0 ? p->pair_weights : (double)NAN;
    return ( RfPairNoise ){ .variance = p->pair.variance / w, .covariance = p->pair.covariance / w };
}

// v of a frame by all that is known; NaN where nothing is.
static double pooled( const RfStop* stop, const RfNoiseEstimates* look, int goal, int frame )
{
    Pool sums = pool_all( stop, look, frame );
    return goal == NOISE ? noise_of( &sums ) : rf_planned_flicker( stop, frame, pair_of( &sums ) );
}

double rf_needed_weight( const RfStop* stop, const RfNoiseEstimates* look, const RfFrameNoise* f, bool own )
{
    double needed = (double)NAN;
    for ( int goal = 0; goal < GOALS; ++goal )
    {
        if ( wanted_of( stop, goal ) <= 0.0 )
            continue;
        double value = pooled( stop, look, goal, f->frame );
        value = own ? fmax( value, value_of( f, goal ) ) : value; // fmax takes the number of a number and NaN
        needed = fmax( needed, value / wanted_of( stop, goal ) );
    }
    return needed;
}
