// Single elements of accessors. Addresses may be unaligned, so every read is a copy;
// validation of the accessor ensures that it is inside its buffer.

#include "scene/gltf/gltf_document.h"

#include <math.h>
#include <string.h>

uint32_t rf_gltf_read_u32( const uint8_t* at, int component_type )
{
    uint16_t half;
    uint32_t word;
    switch ( component_type )
    {
        case 5121: return at[0];
        case 5123: memcpy( &half, at, 2 ); return half;
        default: memcpy( &word, at, 4 ); return word;
    }
}

static float read_component( const uint8_t* at, int component_type, bool normalized )
{
    int16_t s16;
    uint16_t u16;
    uint32_t u32;
    float real;
    switch ( component_type )
    {
        case 5120: real = (float)(int8_t)at[0]; return normalized ? fmaxf( real / 127.0f, -1.0f ) : real;
        case 5121: real = (float)at[0]; return normalized ? real / 255.0f : real;
        case 5122: memcpy( &s16, at, 2 ); return normalized ? fmaxf( (float)s16 / 32767.0f, -1.0f ) : (float)s16;
        case 5123: memcpy( &u16, at, 2 ); return normalized ? (float)u16 / 65535.0f : (float)u16;
        case 5125: memcpy( &u32, at, 4 ); return (float)u32;
        default: memcpy( &real, at, 4 ); return real;
    }
}

// The address of an element; NULL for zeros.
static const uint8_t* find_element( const RfGltfAccessor* accessor, uint32_t element )
{
    uint64_t index_size = accessor->sparse_count > 0 ? (uint64_t)rf_gltf_component_size( accessor->sparse_type ) : 0;
    uint32_t low = 0, high = accessor->sparse_count;
    while ( low < high )
    {
        uint32_t middle = low + ( high - low ) / 2;
        uint32_t index = rf_gltf_read_u32( accessor->sparse_indices + middle * index_size, accessor->sparse_type );
        if ( index == element )
        {
            uint64_t size = (uint64_t)accessor->components * (uint64_t)rf_gltf_component_size( accessor->component_type );
            return accessor->sparse_values + middle * size;
        }
        if ( index < element )
            low = middle + 1;
        else
            high = middle;
    }
    return accessor->data != NULL ? accessor->data + element * accessor->stride : NULL;
}

RfResult rf_gltf_read_floats( const RfGltf* gltf, int index, uint32_t element, float* values )
{
    const RfGltfAccessor* accessor = gltf->accessors + index;
    const uint8_t* at = find_element( accessor, element );
    if ( at == NULL )
    {
        memset( values, 0, (size_t)accessor->components * sizeof *values );
        return RF_OK;
    }
    int size = rf_gltf_component_size( accessor->component_type );
    for ( int i = 0; i < accessor->components; ++i )
    {
        values[i] = read_component( at + i * size, accessor->component_type, accessor->normalized );
        if ( isfinite( values[i] ) == 0 )
        {
            RfWhere where = rf_where( "accessors[%d]", index );
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "element %u, number %d is not finite", element, i );
        }
    }
    return RF_OK;
}

uint32_t rf_gltf_read_index( const RfGltfAccessor* accessor, uint32_t element )
{
    const uint8_t* at = find_element( accessor, element );
    return at != NULL ? rf_gltf_read_u32( at, accessor->component_type ) : 0;
}
