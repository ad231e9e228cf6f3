// What the error would be with other shares of light paths and connections (src/reuse/estimators.md, section 16).
#include "light_paths/connections_internal.h"

#define SCATTERED 0.5f // that a surface is taken to scatter of what arrives, beyond the first vertex

const float rf_connection_shares[RF_CONNECTION_SHARES] = { 0.0f, 0.03f, 0.06f, 0.125f, 0.25f, 0.5f, 1.0f };

// How the light of a vertex counts at the first one.
static float throughput_of( const RfConnectionWork* w, int i )
{
    if ( w->vertex == 1 )
        return 1.0f;
    int r = w->v->ray[i];
    return SCATTERED *
           ( w->rays == NULL
                 ? 1.0f
                 : rf_luminance( rf_vec3( w->rays->throughput[0][r], w->rays->throughput[1][r], w->rays->throughput[2][r] ) ) );
}

// Connections of its way that are found with a share of all light paths (rf_find_footprint).
static float find_count( const RfLightPaths* paths, const RfConnection* connection, float share )
{
    return rf_maxf( rf_minf( paths->connections, share * connection->most ),
                    rf_minf( paths->rare_connections, share * connection->rare_most ) );
}

// Counts up the scattered rays that would find light on their own.
static void count_chance( RfConnectionLanes* out, double light, double found, double through )
{
    if ( !( found * through > 0.0 && found < INFINITY ) )
        return;
    int octave = (int)floor( log2( found * through ) ) - RF_FIRST_OCTAVE;
    octave = octave < 0 ? 0 : octave >= RF_CHANCE_OCTAVES ? RF_CHANCE_OCTAVES - 1 : octave;
    out->chance[octave].rays += light / found;
    out->chance[octave].square += through * through * light * found;
}

void rf_measure_connection( const RfConnectionWork* w, const RfConnection* connection, float light )
{
    const RfChain* chain = &connection->chain;
    float cosine = rf_dot( rf_lane_of( w->v->n, connection->lane ), connection->wi ), chance = RF_INV_PI * cosine,
          through = throughput_of( w, connection->lane );
    // what a scattered ray that finds the same light brings
    float found = rf_luminance( rf_mul( chain->start.radiance, chain->weight ) ) * cosine / ( chance * chain->probability );
    const RfLightPaths* paths = w->settings->paths;
    count_chance( w->out, (double)light, (double)found, (double)through );
    float found_now = find_count( paths, connection, paths->share );
    for ( int k = 0; k < RF_CONNECTION_SHARES; ++k )
    {
        float share = rf_connection_shares[k], tried = rf_tried( w->settings->paths, share, w->vertex );
        float fewer = share > 0.0f ? found_now / find_count( paths, connection, share ) : 0.0f;
        float weight = share == 0.0f               ? 0.0f
                       : connection->chance > 0.0f ? tried / ( tried + connection->chance * fewer * chance )
                                                   : 1.0f;
        float accepted = rf_minf( w->settings->paths->share * connection->offered, 1.0f ),
              then = rf_minf( share * connection->offered, 1.0f );
        float by_connections = share > 0.0f ? weight * weight * light * light * fewer * accepted / then : 0.0f;
        float by_chance = ( 1.0f - weight ) * ( 1.0f - weight ) * light * found;
        w->out->moment[k] += (double)( through * through ) * (double)( by_connections + by_chance );
    }
}
