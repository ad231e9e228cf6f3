#include "render/stop_ahead.h"

#include "render/pair_rule.h"
#include "render/stop_plan.h"

#include <math.h>

// The look's values at a frame, between the places around it.
static RfStopPlace place_at( const RfStopAhead* ahead, int frame )
{
    int k = 0;
    while ( k + 1 < ahead->count && ahead->places[k + 1].frame <= frame )
        k += 1;
    RfStopPlace low = ahead->places[k];
    if ( k + 1 >= ahead->count || frame <= low.frame )
        return low;
    RfStopPlace high = ahead->places[k + 1];
    double t = (double)( frame - low.frame ) / ( high.frame - low.frame );
    low.noise += t * ( high.noise - low.noise );
    low.pair.variance += t * ( high.pair.variance - low.pair.variance );
    low.pair.covariance += t * ( high.pair.covariance - low.pair.covariance );
    low.rays += t * ( high.rays - low.rays );
    return low;
}

static double ratio( double from, double to ) { return from > 0.0 && to > 0.0 ? to / from : 1.0; }

double rf_noise_ahead( const RfStop* stop, int from, int to )
{
    if ( stop->ahead.count < 2 )
        return 1.0;
    return ratio( place_at( &stop->ahead, from ).noise, place_at( &stop->ahead, to ).noise );
}

// The variance by that of the look, and the part of it that two frames do not share by the same part there.
RfPairNoise rf_pair_ahead( const RfStop* stop, RfPairNoise pair, int from, int to )
{
    if ( stop->ahead.count < 2 )
        return pair;
    RfPairNoise a = place_at( &stop->ahead, from ).pair, b = place_at( &stop->ahead, to ).pair;
    double apart = ( pair.variance - pair.covariance ) * ratio( a.variance - a.covariance, b.variance - b.covariance );
    double variance = pair.variance * ratio( a.variance, b.variance );
    return ( RfPairNoise ){ variance, variance - apart };
}

double rf_expected_samples( const RfStop* stop, int frames )
{
    double sum = 0.0;
    for ( int i = 0; i < stop->ahead.count; ++i )
    {
        const RfStopPlace* place = stop->ahead.places + i;
        double needed = stop->goals.noise > 0.0 ? place->noise / stop->goals.noise : 0.0;
        if ( stop->goals.flicker > 0.0 )
            needed = fmax( needed, rf_planned_flicker( stop, place->frame, place->pair ) / stop->goals.flicker );
        sum += fmax( stop->least, fmin( needed / stop->plan.eyes, stop->most ) ) * stop->plan.eyes;
    }
    return sum / stop->ahead.count * frames;
}
