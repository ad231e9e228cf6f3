#include "path/lanes.h"

#include <string.h>

#define LANE_BYTES 4 // of every array

// A single lane is copied without a call.
static inline void copy( const void* from, int count, void* to )
{
    if ( count == 1 )
        memcpy( to, from, LANE_BYTES );
    else
        memcpy( to, from, (size_t)count * LANE_BYTES );
}

#define COPY( array )                                                                                                            \
    do                                                                                                                           \
    {                                                                                                                            \
        _Static_assert( sizeof to->array[0] == LANE_BYTES, "lanes of another size" );                                            \
        copy( from->array + first, count, to->array + at );                                                                      \
    } while ( 0 )
#define COPY3( array )                                                                                                           \
    for ( int c = 0; c < 3; ++c )                                                                                                \
    COPY( array[c] )

void rf_copy_vertices( const RfVertexLanes* from, int first, int count, uint32_t params, RfVertexLanes* to, int at )
{
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
