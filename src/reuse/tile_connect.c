#include "reuse/tile_connect.h"

#include <float.h>
#include <string.h>

// Direction of hit i in a pairing, and ρ without density and visibility; 0 where hit and vertex face away from each other.
static inline void connect( const RfVertexLanes* restrict x, const RfTileReuse* restrict reuse, RfPairingLanes* restrict pairing,
                            int i )
{
    const RfVertexLanes* restrict y = &reuse->second;
    int a = pairing->vertex[i];
    RfVec3 ng = rf_vec3( x->ng[0][i], x->ng[1][i], x->ng[2][i] );
    RfVec3 n = rf_vec3( x->n[0][i], x->n[1][i], x->n[2][i] );
    RfVec3 from = rf_madd( rf_vec3( x->p[0][i], x->p[1][i], x->p[2][i] ), ng, x->offset[i] );
    RfVec3 to_vertex = rf_sub( rf_vec3( y->p[0][a], y->p[1][a], y->p[2][a] ), from );
    float d2 = rf_maxf( rf_dot( to_vertex, to_vertex ), FLT_MIN );
    RfVec3 wi = rf_scale( to_vertex, 1.0f / sqrtf( d2 ) );
    float cos_y = -rf_dot( rf_vec3( y->ng[0][a], y->ng[1][a], y->ng[2][a] ), wi );
    float geometry = cos_y / d2 * reuse->own_distance2_cos[a];
    // & of int: the loop stays free of branches
    int sees = (int)( pairing->weight[i] > 0.0f ) & (int)( cos_y > 0.0f ) & (int)( rf_dot( n, wi ) > 0.0f ) &
               (int)( rf_dot( ng, wi ) > 0.0f ) & (int)( geometry < 1e18f );
    // the BSDFs need a valid direction in every lane
    pairing->wi[0][i] = sees ? wi.x : n.x;
    pairing->wi[1][i] = sees ? wi.y : n.y;
    pairing->wi[2][i] = sees ? wi.z : n.z;
    pairing->weight[i] = sees ? geometry : 0.0f;
}

void rf_connect_neighbours( const RfVertexLanes* restrict x, const RfTileReuse* restrict reuse, RfPairingLanes* restrict pairing )
{
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        connect( x, reuse, pairing, i );
}

void rf_connect_few( const RfVertexLanes* x, RfTileReuse* reuse, int s )
{
    RfPairingLanes* pairing = reuse->pairings + s;
    for ( int c = 0; c < 3; ++c )
        memcpy( pairing->wi[c], x->n[c], (size_t)rf_record_count( x ) * sizeof( float ) );
    for ( int a = 0; a < rf_record_count( &reuse->second ); ++a )
    {
        if ( reuse->owner[a] >= 0 && s < reuse->size[reuse->owner[a]] )
            connect( x, reuse, pairing, rf_receiver( reuse, a, s ) );
    }
}
