// Where the numbers of a document are: views of buffers, and accessors.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include <math.h>
#include <string.h>

// The bytes of a view (gltf_accessor.c) from `offset` on, of which `need` must exist.
static RfResult view_bytes( const RfGltf* gltf, const char* where, int view, uint64_t offset, uint64_t need,
                            const uint8_t** bytes )
{
    const RfGltfUnpackedView* unpacked;
    const uint8_t* start = NULL;
    uint64_t extent = 0;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view );
    RF_TRY( rf_gltf_unpack_view( gltf, view, &unpacked ) );
    if ( unpacked == NULL )
        RF_TRY( rf_gltf_read_range( gltf, &json, &start, &extent ) );
    if ( unpacked != NULL )
    {
        start = unpacked->bytes;
        extent = unpacked->size;
    }
    if ( offset > extent || need > extent - offset )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "bytes %llu + %llu are outside bufferViews[%d] of %llu bytes",
                             (unsigned long long)offset, (unsigned long long)need, view, (unsigned long long)extent );
    *bytes = start + offset;
    return RF_OK;
}

RfResult rf_gltf_whole_view( const RfGltf* gltf, const char* where, int view, uint64_t most, const uint8_t** bytes, size_t* size )
{
    int64_t length = 0;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view );
    RfResult result = rf_get_integer( &json, "byteLength", 1, (int64_t)most, &length );
    *size = (size_t)length;
    return result == RF_OK ? view_bytes( gltf, where, view, 0, (uint64_t)length, bytes ) : result;
}

// The stride of a view for elements of `element` bytes.
static RfResult view_stride( const RfGltf* gltf, int view, uint64_t element, uint64_t* stride )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view );
    int64_t value = (int64_t)element;
    RF_TRY( rf_get_integer( &json, "byteStride", 4, 252, &value ) );
    if ( (uint64_t)value < element )
        return rf_field_fail( &json, "byteStride is %lld, but the elements have %llu bytes", (long long)value,
                              (unsigned long long)element );
    *stride = (uint64_t)value;
    return RF_OK;
}

// Single elements of accessors. Addresses may be unaligned, so every read is a copy;
// validation of the accessor ensures that it is inside its buffer.

// Reads an unsigned integer of a component type.
static uint32_t read_u32( const uint8_t* at, int component_type )
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
        uint32_t index = read_u32( accessor->sparse_indices + middle * index_size, accessor->sparse_type );
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

static int declared_index( const RfGltf* gltf, int index )
{
    return index < gltf->counts[RF_GLTF_ACCESSORS] ? index : gltf->accessors[index].declared;
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
            RfWhere where = rf_where( "accessors[%d]", declared_index( gltf, index ) );
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "element %u, number %d is not finite", element, i );
        }
    }
    return RF_OK;
}

uint32_t rf_gltf_read_index( const RfGltfAccessor* accessor, uint32_t element )
{
    const uint8_t* at = find_element( accessor, element );
    return at != NULL ? read_u32( at, accessor->component_type ) : 0;
}

// Accessors: validated once on first use, then read element by element, so that primitives
// that share a large accessor only pay for the elements they use.

// Accessors without a view take no bytes in the file, so their zeros are limited.
#define MAX_ELEMENTS ( (int64_t)1 << 31 )

#define MAX_ZEROS ( (int64_t)1 << 24 )

enum
{
    BYTE = 5120,
    UNSIGNED_BYTE = 5121,
    SHORT = 5122,
    UNSIGNED_SHORT = 5123,
    UNSIGNED_INT = 5125,
    FLOAT = 5126,
};

int rf_gltf_component_size( int component_type )
{
    switch ( component_type )
    {
        case BYTE:
        case UNSIGNED_BYTE: return 1;
        case SHORT:
        case UNSIGNED_SHORT: return 2;
        case UNSIGNED_INT:
        case FLOAT: return 4;
    }
    return 0;
}

static const struct
{
    const char* name;
    int components;
} s_types[] = {
    { "SCALAR", 1 }, { "VEC2", 2 }, { "VEC3", 3 }, { "VEC4", 4 }, { "MAT2", 4 }, { "MAT3", 9 }, { "MAT4", 16 },
};

static RfResult read_type( const RfField* json, bool matrix, RfGltfAccessor* out )
{
    const char* type = "";
    RfResult result = rf_get_text( json, "type", &type );
    if ( result != RF_OK )
        return result;
    for ( size_t i = 0; i < sizeof s_types / sizeof s_types[0]; ++i )
    {
        if ( strcmp( type, s_types[i].name ) == 0 )
            out->components = s_types[i].components;
    }
    // matrices of floats alone are read, which have no padding
    if ( matrix )
    {
        if ( out->components == 16 && out->component_type == FLOAT )
            return RF_OK;
        return rf_field_fail( json, "type '%.20s' must be MAT4 of floats here", type );
    }
    if ( out->components == 0 || type[0] == 'M' )
        return rf_field_fail( json, "type '%.20s' must be SCALAR, VEC2, VEC3 or VEC4 here", type );
    return RF_OK;
}

static RfResult read_component_type( const RfField* json, int* component_type )
{
    int64_t value = 0;
    rf_gltf_require( json, "componentType", NULL );
    RfResult result = rf_get_integer( json, "componentType", BYTE, FLOAT, &value );
    if ( result == RF_OK && rf_gltf_component_size( (int)value ) == 0 )
        return rf_field_fail( json, "componentType %d does not exist", (int)value );
    *component_type = (int)value;
    return result;
}

RfResult rf_gltf_read_layout( const RfGltf* gltf, const RfField* json, bool matrix, RfGltfAccessor* out )
{
    int64_t count = 0;
    rf_gltf_require( json, "count", NULL );
    rf_get_integer( json, "count", 1, INT64_MAX, &count );
    rf_gltf_check_limit( gltf, json->path, "count", (double)count, (double)MAX_ELEMENTS );
    out->count = (uint32_t)count;
    read_component_type( json, &out->component_type );
    RF_TRY( read_type( json, matrix, out ) );
    RF_TRY( rf_get_bool( json, "normalized", &out->normalized ) );
    if ( out->normalized && out->component_type >= UNSIGNED_INT )
        return rf_field_fail( json, "normalized needs components of 8 or 16 bits" );
    return RF_OK;
}

static uint64_t element_size( const RfGltfAccessor* accessor )
{
    return (uint64_t)accessor->components * (uint64_t)rf_gltf_component_size( accessor->component_type );
}

static RfResult read_view( const RfGltf* gltf, const RfField* json, RfGltfAccessor* out )
{
    int64_t offset = 0;
    int view = rf_gltf_get_index( gltf, json, "bufferView", RF_GLTF_BUFFER_VIEWS );
    RF_TRY( rf_get_integer( json, "byteOffset", 0, INT64_MAX, &offset ) );
    if ( view < 0 && out->count > MAX_ZEROS )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, json->path,
                             "%u elements without a bufferView are too many, the limit is %lld: "
                             "export the scene with its data",
                             out->count, (long long)MAX_ZEROS );
    if ( view < 0 )
        return RF_OK;
    uint64_t size = element_size( out );
    RF_TRY( view_stride( gltf, view, size, &out->stride ) );
    // count ≤ 2³¹ and stride ≤ 252: no overflow
    uint64_t need = out->stride * ( (uint64_t)out->count - 1 ) + size;
    return view_bytes( gltf, json->path, view, (uint64_t)offset, need, &out->data );
}

static RfResult read_sparse_part( const RfGltf* gltf, const RfField* sparse, const char* key, uint64_t bytes,
                                  const uint8_t** data )
{
    int64_t offset = 0;
    rf_gltf_require( sparse, key, NULL );
    RfField part = rf_get_object( sparse, key );
    rf_gltf_require( &part, "bufferView", NULL );
    int view = rf_gltf_get_index( gltf, &part, "bufferView", RF_GLTF_BUFFER_VIEWS );
    RfResult result = rf_get_integer( &part, "byteOffset", 0, INT64_MAX, &offset );
    return result == RF_OK ? view_bytes( gltf, part.path, view, (uint64_t)offset, bytes, data ) : result;
}

static RfResult check_sparse_indices( const RfGltf* gltf, const char* where, const RfGltfAccessor* out )
{
    uint64_t size = (uint64_t)rf_gltf_component_size( out->sparse_type );
    int64_t last = -1;
    for ( uint32_t i = 0; i < out->sparse_count; ++i )
    {
        int64_t index = read_u32( out->sparse_indices + i * size, out->sparse_type );
        if ( index <= last || index >= (int64_t)out->count )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "indices[%u] is %lld: they must increase and stay below %u", i,
                                 (long long)index, out->count );
        last = index;
    }
    return RF_OK;
}

static RfResult read_sparse( const RfGltf* gltf, const RfField* accessor, RfGltfAccessor* out )
{
    int64_t count = 0;
    RfField sparse = rf_get_object( accessor, "sparse" );
    if ( sparse.json == NULL )
        return rf_json_result( accessor );
    rf_gltf_require( &sparse, "count", NULL );
    RfResult result = rf_get_integer( &sparse, "count", 1, out->count, &count );
    RfField indices = rf_gltf_field( gltf, sparse.path, json_object_get( sparse.json, "indices" ) );
    bool typed = json_is_object( indices.json );
    if ( typed )
        result = read_component_type( &indices, &out->sparse_type );
    if ( result != RF_OK )
        return result;
    if ( typed && out->sparse_type != UNSIGNED_BYTE && out->sparse_type != UNSIGNED_SHORT && out->sparse_type != UNSIGNED_INT )
        return rf_field_fail( &sparse, "indices must have an unsigned componentType" );

    uint64_t index_bytes = (uint64_t)count * (uint64_t)rf_gltf_component_size( out->sparse_type );
    RF_TRY( read_sparse_part( gltf, &sparse, "indices", index_bytes, &out->sparse_indices ) );
    RF_TRY( read_sparse_part( gltf, &sparse, "values", (uint64_t)count * element_size( out ), &out->sparse_values ) );
    out->sparse_count = (uint32_t)count;
    return check_sparse_indices( gltf, sparse.path, out );
}

static RfResult open_accessor( RfGltf* gltf, int index, bool matrix, const RfGltfAccessor** accessor )
{
    RfGltfAccessor* self = gltf->accessors + index;
    *accessor = self;
    if ( self->open )
        return RF_OK;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_ACCESSORS, index );
    RF_TRY( rf_gltf_read_layout( gltf, &json, matrix, self ) );
    RF_TRY( read_view( gltf, &json, self ) );
    RF_TRY( read_sparse( gltf, &json, self ) );
    self->open = true;
    return RF_OK;
}

RfResult rf_gltf_open_accessor( RfGltf* gltf, int index, const char* user, int components, const RfGltfAccessor** accessor )
{
    RfResult result = open_accessor( gltf, index, components == 16, accessor );
    return result == RF_OK && components > 0 ? rf_gltf_expect( gltf, index, *accessor, user, components ) : result;
}

RfResult rf_gltf_expect( const RfGltf* gltf, int index, const RfGltfAccessor* accessor, const char* user, int components )
{
    if ( accessor->components == components )
        return RF_OK;
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, user, "accessors[%d] has elements of %d numbers, %d are needed",
                         declared_index( gltf, index ), accessor->components, components );
}
