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
    low.variance += t * ( high.variance - low.variance );
    low.apart += t * ( high.apart - low.apart );
    return low;
}

static double ratio( double from, double to ) { return from > 0.0 && to > 0.0 ? to / from : 1.0; }

double rf_noise_ahead( const RfStop* stop, int from, int to )
{
    if ( stop->ahead.count < 2 )
        return 1.0;
    return ratio( place_at( &stop->ahead, from ).noise, place_at( &stop->ahead, to ).noise );
}

double rf_variance_ahead( const RfStop* stop, int from, int to )
{
    if ( stop->ahead.count < 2 )
        return 1.0;
    return ratio( place_at( &stop->ahead, from ).variance, place_at( &stop->ahead, to ).variance );
}

static double part_apart( RfStopPlace place ) { return place.variance > 0.0 ? fmin( place.apart / place.variance, 1.0 ) : 0.0; }

double rf_apart_ahead( const RfStop* stop, int frame )
{
    return stop->ahead.count < 2 ? 0.0 : part_apart( place_at( &stop->ahead, frame ) );
}

double rf_usual_apart_ahead( const RfStop* stop )
{
    double sum = 0.0;
    for ( int i = 0; i < stop->ahead.count && stop->ahead.count > 1; ++i )
        sum += part_apart( stop->ahead.places[i] ) / stop->ahead.count;
    return sum;
}

double rf_expected_samples( const RfStop* stop, int frames )
{
    double sum = 0.0;
    for ( int i = 0; i < stop->ahead.count; ++i )
    {
        const RfStopPlace* place = stop->ahead.places + i;
        double needed = stop->goals.noise > 0.0 ? place->noise / stop->goals.noise : 0.0;
        if ( stop->goals.flicker > 0.0 )
            needed = fmax( needed, rf_planned_flicker( stop, place->frame,
                                                       ( RfPairNoise ){ .variance = place->variance,
                                                                        .covariance = place->variance - place->apart } ) /
                                       stop->goals.flicker );
        sum += fmax( stop->least, fmin( needed / stop->plan.eyes, stop->most ) ) * stop->plan.eyes;
    }
    return sum / stop->ahead.count * frames;
}
