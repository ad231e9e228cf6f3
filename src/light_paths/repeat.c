// The exact normalisation of connections: by repeated trials (src/reuse/estimators.md, section 16).
#include "light_paths/connections_internal.h"

#define MOST_REPEATS 4096 // so many are never needed but for rounding
#define SAME 0.05f        // solutions closer than this, in reaches, are one

// Draws what steers evenly from all within reach of the solution. False: nothing is emitted there.
static bool draw_start( const RfConnectionWork* w, const RfConnection* connection, uint32_t trial, RfEmission* e )
{
    const RfTracer* tracer = w->settings->path->tracer;
    *e = connection->chain.start;
    float chord;
    RfVec3 across = rf_sample_reach( &connection->reach, e->direction, rf_random( connection->key, 2 * trial ),
                                     rf_random( connection->key, 2 * trial + 1 ), &chord );
    if ( e->infinite )
    {
        e->position = rf_madd( e->position, across, chord );
        return true;
    }
    float versine = 0.5f * chord * chord, sine = sqrtf( versine * ( 2.0f - versine ) );
    RfVec3 d = rf_normalize( rf_madd( rf_scale( across, sine ), e->direction, 1.0f - versine ) );
    return rf_emit_towards( rf_tracer_lights( tracer ), rf_tracer_scene( tracer ), d, e );
}

// One more trial of the connections that are pending: light paths from around the solution, until one is found that a connection would
// bend to the same. Returns how many are pending still.
static int try_again( RfConnectionWork* w, uint32_t trial, bool* pending )
{
    const RfTracer* tracer = w->settings->path->tracer;
    const RfTriangleRecord* triangles = rf_tracer_triangles( tracer );
    const RfLightPaths* paths = w->settings->paths;
    RfChain* chains[RF_CHAIN_BLOCK];
    bool active[RF_CHAIN_BLOCK];
    RfLanding land;
    for ( int k = 0; k < w->count; ++k )
    {
        const RfConnection* connection = w->connection + k;
        RfBend* bend = w->bend + k;
        chains[k] = &bend->at;
        bend->active = active[k] = pending[k] && draw_start( w, connection, trial, &bend->at.start );
        bend->at.events = connection->chain.events;
        bend->at.length = connection->chain.length;
        w->out->trials += pending[k];
    }
    rf_walk_chains( tracer, RF_CHAIN_COPY, NULL, active, w->count, chains, &land, &w->out->rays );
    for ( int k = 0; k < w->count; ++k )
    {
        RfBend* bend = w->bend + k;
        if ( !active[k] || bend->at.length == 0 )
        {
            bend->active = false;
            continue;
        }
        const RfConnection* connection = w->connection + k;
        RfFootprint footprint = rf_find_footprint( paths, rf_tracer_lights( tracer ), &bend->at, rf_steer_pdf( paths, &bend->at ),
                                                   land.p[k], triangles[land.triangle[k]].ng );
        RfFootprintBox box = { land.p[k], footprint.half };
        bend->most = rf_scaled_reach( &footprint.reach, RF_STEP_MARGIN );
        bend->active = footprint.reach.along > 0.0f && rf_box_holds( &box, rf_start_of( w->v, connection->lane ) );
    }
    rf_bend_chains( tracer, w->count, w->bend, &w->out->rays );
    int left = 0;
    for ( int k = 0; k < w->count; ++k )
    {
        if ( !pending[k] )
            continue;
        RfConnection* connection = w->connection + k;
        const RfBend* bend = w->bend + k;
        bool same = bend->met && rf_reach_to( &connection->reach, &connection->chain.start, &bend->at.start ) <= SAME * SAME;
        pending[k] = !same;
        connection->repeats += pending[k] ? 1.0f : 0.0f;
        left += pending[k];
    }
    return left;
}

void rf_repeat_trials( RfConnectionWork* w )
{
    bool pending[RF_CHAIN_BLOCK];
    int left = 0;
    for ( int k = 0; k < w->count; ++k )
        left += pending[k] = w->connection[k].open;
    for ( uint32_t trial = 0; left > 0 && trial < MOST_REPEATS; ++trial )
        left = try_again( w, trial, pending );
}
