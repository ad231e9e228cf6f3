// Vertex indices of the triangles of a primitive: indexed or not, as a list, strip or fan.

#include "scene/gltf/gltf_geometry.h"

#include <stdlib.h>

// Of a single primitive; baking limits the sum over the scene.
#define MAX_TRIANGLES ( 1u << 28 )

enum
{
    LIST = 4,
    STRIP = 5,
    FAN = 6,
};

static RfResult open_indices( RfGltf* gltf, const json_t* primitive, const char* where, const RfGltfAccessor** accessor )
{
    int index;
    *accessor = NULL;
    RfResult result = rf_gltf_get_index( gltf, primitive, where, "indices", RF_GLTF_ACCESSORS, &index );
    if ( result != RF_OK || index < 0 )
        return result;
    result = rf_gltf_open_accessor( gltf, index, accessor );
    if ( result == RF_OK )
        result = rf_gltf_expect( gltf, index, *accessor, where, 1 );
    if ( result != RF_OK )
        return result;
    int type = ( *accessor )->component_type;
    if ( ( type != 5121 && type != 5123 && type != 5125 ) || ( *accessor )->normalized )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "indices accessors[%d] wants unsigned integers", index );
    return RF_OK;
}

static RfResult count_triangles( const RfGltf* gltf, const char* where, int mode, uint32_t corners, uint32_t* count )
{
    if ( mode == LIST && corners % 3 != 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%u corners do not make whole triangles", corners );
    *count = mode == LIST ? corners / 3 : corners >= 3 ? corners - 2 : 0;
    if ( *count > MAX_TRIANGLES )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "%u triangles are too many, the limit is %u: split the scene",
                             *count, MAX_TRIANGLES );
    return RF_OK;
}

// The corners of triangle t, counter-clockwise, by the specification's section on topology
// types.
static void find_corners( int mode, uint32_t t, uint32_t corners[3] )
{
    uint32_t odd = t % 2;
    switch ( mode )
    {
        case STRIP: corners[0] = t, corners[1] = t + 1 + odd, corners[2] = t + 2 - odd; break;
        case FAN: corners[0] = t + 1, corners[1] = t + 2, corners[2] = 0; break;
        default: corners[0] = 3 * t, corners[1] = 3 * t + 1, corners[2] = 3 * t + 2; break;
    }
}

RfResult rf_gltf_read_triangles( RfGltf* gltf, const json_t* primitive, const char* where, int mode, uint32_t vertex_count,
                                 uint32_t** indices, uint32_t* triangle_count )
{
    const RfGltfAccessor* accessor;
    RfResult result = open_indices( gltf, primitive, where, &accessor );
    if ( result == RF_OK )
        result = count_triangles( gltf, where, mode, accessor != NULL ? accessor->count : vertex_count, triangle_count );
    if ( result != RF_OK )
        return result;

    *indices = malloc( ( (size_t)*triangle_count * 3 + 1 ) * sizeof **indices );
    if ( *indices == NULL )
        return rf_gltf_no_memory( gltf, where );
    for ( uint32_t t = 0; t < *triangle_count; ++t )
    {
        uint32_t corners[3];
        find_corners( mode, t, corners );
        for ( int i = 0; i < 3; ++i )
        {
            uint32_t vertex = accessor != NULL ? rf_gltf_read_index( accessor, corners[i] ) : corners[i];
            if ( vertex >= vertex_count )
                return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "index %u is %u, but there are %u vertices", corners[i],
                                     vertex, vertex_count );
            ( *indices )[3 * (size_t)t + (size_t)i] = vertex;
        }
    }
    return RF_OK;
}
