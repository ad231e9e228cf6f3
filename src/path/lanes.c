#include "path/lanes.h"

#include <string.h>

#define COPY( array ) memcpy( to->array + at, from->array + first, (size_t)count * sizeof to->array[0] )
#define COPY3( array )                                                                                                           \
    for ( int c = 0; c < 3; ++c )                                                                                                \
    COPY( array[c] )
#define COPY_LANE( array ) to->array[at] = from->array[first]
#define COPY_LANE3( array )                                                                                                      \
    for ( int c = 0; c < 3; ++c )                                                                                                \
    COPY_LANE( array[c] )

// A single lane, without calls.
static void copy_lane( const RfVertexLanes* from, int first, uint32_t params, RfVertexLanes* to, int at )
{
    COPY_LANE3( p );
    COPY_LANE3( ng );
    COPY_LANE3( n );
    COPY_LANE3( wo );
    COPY_LANE( offset );
    for ( uint32_t left = params; left != 0; left &= left - 1 )
    {
        int p = __builtin_ctz( left );
        COPY_LANE( param[p] );
    }
    COPY_LANE3( absorption );
    COPY_LANE3( emission );
    COPY_LANE( light_pdf_solid_angle );
    COPY_LANE( material );
    COPY_LANE( ray );
    COPY_LANE( slot );
}

void rf_copy_vertices( const RfVertexLanes* from, int first, int count, uint32_t params, RfVertexLanes* to, int at )
{
    if ( count == 1 )
    {
        copy_lane( from, first, params, to, at );
        return;
    }
    COPY3( p );
    COPY3( ng );
    COPY3( n );
    COPY3( wo );
    COPY( offset );
    for ( uint32_t left = params; left != 0; left &= left - 1 )
    {
        int p = __builtin_ctz( left );
        COPY( param[p] );
    }
    COPY3( absorption );
    COPY3( emission );
    COPY( light_pdf_solid_angle );
    COPY( material );
    COPY( ray );
    COPY( slot );
}
