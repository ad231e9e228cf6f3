#include "reuse/tile_chains.h"

static RfVec3 point_of( const RfVertexLanes* v, int i ) { return rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] ); }

static RfVec3 direction_of( float* const d[3], int i ) { return rf_vec3( d[0][i], d[1][i], d[2][i] ); }

static float distance2( RfVec3 a, RfVec3 b )
{
    RfVec3 way = rf_sub( a, b );
    return rf_dot( way, way );
}

// The square of the largest distance of a hit of the tile from its first.
static float extent2( const RfTileReuse* reuse, int hit )
{
    const int32_t* member = reuse->member + reuse->begin[hit];
    RfVec3 first = point_of( reuse->hits, member[0] );
    float most = 0.0f;
    for ( int k = 1; k < reuse->size[hit]; ++k )
        most = rf_maxf( most, distance2( point_of( reuse->hits, member[k] ), first ) );
    return most;
}

bool rf_is_near_chain( const RfTileReuse* reuse, int hit, const RfVertexLanes* v, int i )
{
    return distance2( point_of( v, i ), point_of( reuse->hits, hit ) ) < extent2( reuse, hit );
}

void rf_sort_chains( RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    for ( int a = rf_record_count( y ); a < y->count; ++a )
        reuse->parallel[a] = reuse->owner[a] >= 0 && rf_is_near_chain( reuse, reuse->owner[a], y, a );
}

// Hit i leaves in a direction that another has drawn.
static void leave_parallel( const RfVertexLanes* hits, int i, RfVec3 wi, RfPairingLanes* pairing )
{
    RfVec3 n = rf_vec3( hits->n[0][i], hits->n[1][i], hits->n[2][i] );
    RfVec3 ng = rf_vec3( hits->ng[0][i], hits->ng[1][i], hits->ng[2][i] );
    bool leaves = rf_dot( n, wi ) > 0.0f && rf_dot( ng, wi ) > 0.0f;
    RfVec3 to = leaves ? wi : n;
    pairing->wi[0][i] = to.x;
    pairing->wi[1][i] = to.y;
    pairing->wi[2][i] = to.z;
    pairing->weight[i] = leaves ? 1.0f : 0.0f;
}

void rf_aim_at_chains( float* const scattered[3], int s, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    RfPairingLanes* pairing = reuse->pairings + s;
    for ( int a = rf_record_count( y ); a < y->count; ++a )
    {
        int own = reuse->owner[a];
        if ( own < 0 || s >= reuse->size[own] )
            continue;
        int i = rf_receiver( reuse, a, s );
        for ( int c = 0; c < 3 && reuse->parallel[a] && reuse->pane_weight != NULL; ++c )
            reuse->pane_weight[s][c][i] = 1.0f; // chains that pass panes are not followed
        if ( reuse->parallel[a] )
            leave_parallel( reuse->hits, i, direction_of( scattered, own ), pairing );
        else if ( rf_is_near_chain( reuse, i, y, a ) )
            pairing->weight[i] = 0.0f;
    }
}

void rf_weight_chain_light( RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    for ( int a = rf_record_count( y ); a < y->count; ++a )
    {
        int i = reuse->owner[a], slot = y->slot[a];
        float weight = i >= 0 ? reuse->pairings[0].weight[i] : 1.0f;
        for ( int c = 0; c < 3; ++c )
            reuse->chain_light.light[c][slot] = weight * reuse->throughput[c][a] * reuse->chain_light.light[c][slot];
    }
}
