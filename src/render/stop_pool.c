#include "render/stop_pool.h"

#include "render/pair_rule.h"
#include "render/stop_ahead.h"

#include <math.h>

// The goals that frames are estimated for.
enum
{
    NOISE,
    FLICKER,
    GOALS
};

static double wanted_of( const RfStop* stop, int goal ) { return goal == NOISE ? stop->goals.noise : stop->goals.flicker; }

// v of a frame for a goal; NaN: not known. A noise in doubt counts double where it is to stop by, but not where it is to
// predict: with more passes most doubts end. Those of flicker stay, such as the rims of lamps.
static double value_of( const RfFrameNoise* f, int goal, bool likely )
{
    double value = goal == NOISE ? f->noise : f->flicker;
    if ( !( f->seen > 0.0 && isfinite( value ) ) )
        return (double)NAN;
    return likely && goal == NOISE ? value / fmax( f->doubt, 1.0 ) : value;
}

bool rf_is_known( const RfStop* stop, const RfFrameNoise* f )
{
    bool noise = !isnan( value_of( f, NOISE, false ) ), flicker = !isnan( value_of( f, FLICKER, false ) );
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
    double apart, apart_ahead; // what neighbours do not share, and what that is by the look ahead
    double in_doubt;           // of the latter
} Pool;

// A pair in doubt says the less of others the less of F1 it has, as where the camera hardly moves.
static void pool_apart( const RfStop* stop, const RfFrameNoise* f, double weight, Pool* pool )
{
    double doubt = fmax( f->pair.doubt, 1.0 ), ahead = weight * f->pair.variance / doubt * rf_apart_ahead( stop, f->frame );
    pool->apart += weight * ( f->pair.variance - f->pair.covariance ) / doubt;
    pool->apart_ahead += ahead;
    pool->in_doubt += ( doubt - 1.0 ) * f->pair.lasting * ahead;
}

static void pool( const RfStop* stop, const RfFrameNoise* f, int frame, bool likely, Pool* pool )
{
    double noise = value_of( f, NOISE, likely ), weight = pooling_weight( stop, f, frame );
    if ( !isnan( noise ) )
    {
        noise *= likely ? rf_noise_ahead( stop, f->frame, frame ) : 1.0;
        pool->noise += weight * noise;
        pool->noise_weights += weight;
    }
    if ( f->seen > 0.0 && isfinite( f->pair.variance ) && isfinite( f->pair.covariance ) )
    {
        double times = likely ? rf_variance_ahead( stop, f->frame, frame ) / fmax( f->pair.doubt, 1.0 ) : 1.0;
        pool->pair.variance += weight * f->pair.variance * times;
        pool->pair.covariance += weight * f->pair.covariance;
        pool_apart( stop, f, weight, pool );
        pool->pair_weights += weight;
    }
}

static Pool pool_all( const RfStop* stop, const RfNoiseEstimates* look, int frame, bool likely )
{
    Pool sums = { 0 };
    for ( int i = 0; i < look->count; ++i )
        pool( stop, look->frames + i, frame, likely, &sums );
    for ( int i = 0; i < stop->finished_count && i < RF_STOP_HISTORY; ++i )
        pool( stop, stop->finished + i, frame, likely, &sums );
    return sums;
}

static double noise_of( const Pool* p ) { return p->noise_weights > 0.0 ? p->noise / p->noise_weights : (double)NAN; }

static RfPairNoise pair_of( const Pool* p )
{
    double w = p->pair_weights > 0.0 ? p->pair_weights : (double)NAN;
    return ( RfPairNoise ){ .variance = p->pair.variance / w, .covariance = p->pair.covariance / w };
}

RfExpected rf_expect( const RfStop* stop, const RfNoiseEstimates* look, int frame )
{
    Pool sums = pool_all( stop, look, frame, true );
    double usual = sums.pair.variance * rf_usual_apart_ahead( stop );
    if ( usual > 0.0 )
    {
        double times = fmax( ( sums.apart + usual ) / ( sums.apart_ahead + usual ), 0.0 );
        sums.pair.covariance = sums.pair.variance * ( 1.0 - times * rf_apart_ahead( stop, frame ) );
        double doubt = sums.apart_ahead > 0.0 ? 1.0 + sums.in_doubt / sums.apart_ahead : 1.0;
        sums.pair.variance *= doubt;
        sums.pair.covariance *= doubt;
    }
    return ( RfExpected ){ .noise = noise_of( &sums ), .pair = pair_of( &sums ) };
}

// v of a frame by all that is known; NaN where nothing is.
static double pooled( const RfStop* stop, const RfNoiseEstimates* look, int goal, int frame )
{
    Pool sums = pool_all( stop, look, frame, false );
    return goal == NOISE ? noise_of( &sums ) : rf_planned_flicker( stop, frame, pair_of( &sums ) );
}

bool rf_is_any_known( const RfStop* stop, const RfNoiseEstimates* look )
{
    bool known = stop->finished_count > 0;
    for ( int i = 0; i < look->count && !known; ++i )
        known = rf_is_known( stop, look->frames + i );
    return known;
}

double rf_needed_weight( const RfStop* stop, const RfNoiseEstimates* look, const RfFrameNoise* f, bool own )
{
    double needed = (double)NAN;
    for ( int goal = 0; goal < GOALS; ++goal )
    {
        if ( wanted_of( stop, goal ) <= 0.0 )
            continue;
        double value = pooled( stop, look, goal, f->frame );
        value = own ? fmax( value, value_of( f, goal, false ) ) : value; // fmax takes the number of a number and NaN
        needed = fmax( needed, value / wanted_of( stop, goal ) );
    }
    return needed;
}
