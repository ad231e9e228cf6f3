#include "path/lanes.h"

#include <string.h>

#define COPY( array ) memcpy( to->array + at, from->array + first, (size_t)count * sizeof to->array[0] )
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
    COPY( ray );
    COPY( material );
    COPY( slot );
}
