#include "light_paths/solve.h"

#define MOST_STEPS 12
#define LEAST_DAMPING 0.05f
#define RELATIVE_MISS 2e-5f // of the last segment's length
#define ABSOLUTE_MISS 1e-6f // of the scene's radius

bool rf_newton_step( const RfRayPair* ray, RfVec3 y, RfVec3 n, float step[2], float* miss, float* spread )
{
    RfVec3 meet, moves[2];
    if ( !rf_meet_plane( ray, y, n, &meet, moves ) )
        return false;
    RfVec3 f = rf_sub( meet, y );
    *miss = rf_length( f );
    float det = rf_dot( rf_cross( moves[0], moves[1] ), n );
    if ( !( fabsf( det ) > 1e-20f ) )
        return false;
    *spread = fabsf( det );
    step[0] = -rf_dot( rf_cross( f, moves[1] ), n ) / det;
    step[1] = -rf_dot( rf_cross( moves[0], f ), n ) / det;
    return true;
}

// Where a bend goes next.
typedef struct Next
{
    float step[2];
    float miss, damping;
    bool walked; // `at` has all its vertices
} Next;

static float tolerance( const RfTracer* tracer, const RfBend* b )
{
    return RELATIVE_MISS * rf_length( rf_sub( b->at.end.o, b->y ) ) + ABSOLUTE_MISS * rf_tracer_lights( tracer )->radius;
}

static void start( RfBend* b, Next* next )
{
    float spread;
    b->met = false;
    *next = ( Next ){ .damping = 1.0f };
    b->active = b->active && rf_newton_step( &b->at.end, b->y, b->n, next->step, &next->miss, &spread ) &&
                rf_reach_squared( &b->most, next->step[0], next->step[1] ) <= 1.0f;
}

// Takes or refuses the chain that was tried.
static void judge( const RfTracer* tracer, RfBend* b, const RfChain* tried, Next* next )
{
    float step[2], miss, spread;
    if ( tried->length == b->at.length && rf_newton_step( &tried->end, b->y, b->n, step, &miss, &spread ) &&
         ( miss < next->miss || !next->walked ) && ( next->walked || miss < 4.0f * next->miss + tolerance( tracer, b ) ) )
    {
        b->at = *tried;
        *next = ( Next ){ { step[0], step[1] }, miss, rf_minf( 2.0f * next->damping, 1.0f ), true };
        b->met = miss <= tolerance( tracer, b );
        b->active = !b->met;
        return;
    }
    next->damping *= 0.5f;
    b->active = next->damping > LEAST_DAMPING;
}

void rf_bend_chains( const RfTracer* tracer, int count, RfBend* bends, uint64_t* rays )
{
    RfChain tried[RF_CHAIN_BLOCK], *chains[RF_CHAIN_BLOCK];
    Next next[RF_CHAIN_BLOCK];
    bool active[RF_CHAIN_BLOCK];
    for ( int i = 0; i < count; ++i )
    {
        chains[i] = tried + i;
        start( bends + i, next + i );
    }
    for ( int k = 0; k < MOST_STEPS; ++k )
    {
        bool any = false;
        for ( int i = 0; i < count; ++i )
        {
            RfBend* b = bends + i;
            active[i] = b->active;
            if ( !b->active )
                continue;
            RfEmission e = b->at.start;
            rf_steer( &e, next[i].damping * next[i].step[0], next[i].damping * next[i].step[1] );
            tried[i].start = e;
            tried[i].events = b->at.events;
            tried[i].length = b->at.length;
            active[i] = e.infinite ||
                        rf_emit_towards( rf_tracer_lights( tracer ), rf_tracer_scene( tracer ), e.direction, &tried[i].start );
            any = true;
            if ( !active[i] )
                tried[i].length = 0;
        }
        if ( !any )
            break;
        rf_walk_chains( tracer, RF_CHAIN_COPY, NULL, active, count, chains, NULL, rays );
        for ( int i = 0; i < count; ++i )
        {
            if ( bends[i].active )
                judge( tracer, bends + i, tried + i, next + i );
        }
    }
    for ( int i = 0; i < count; ++i )
        bends[i].active = false;
}
