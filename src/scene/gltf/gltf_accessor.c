// Accessors: validated once on first use, then read element by element, so that primitives
// that share a large accessor only pay for the elements they use.

#include "scene/gltf/gltf_document.h"

#include <math.h>
#include <string.h>

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

static RfResult read_type( const RfGltf* gltf, const json_t* json, const char* where, RfGltfAccessor* out )
{
    const char* type = "";
    RfResult result = rf_gltf_get_string( gltf, json, where, "type", &type );
    if ( result != RF_OK )
        return result;
    for ( size_t i = 0; i < sizeof s_types / sizeof s_types[0]; ++i )
    {
        if ( strcmp( type, s_types[i].name ) == 0 )
            out->components = s_types[i].components;
    }
    // matrices pad their columns, but no attribute that is read here is a matrix
    if ( out->components == 0 || type[0] == 'M' )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "type '%.20s' wants SCALAR, VEC2, VEC3 or VEC4 here", type );
    return RF_OK;
}

static RfResult read_component_type( const RfGltf* gltf, const json_t* json, const char* where, int* component_type )
{
    int64_t value = 0;
    RfResult result = rf_gltf_require( gltf, json, where, "componentType" );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, where, "componentType", BYTE, FLOAT, &value );
    if ( result == RF_OK && rf_gltf_component_size( (int)value ) == 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "componentType %d does not exist", (int)value );
    *component_type = (int)value;
    return result;
}

static RfResult read_layout( const RfGltf* gltf, const json_t* json, const char* where, RfGltfAccessor* out )
{
    int64_t count = 0;
    RfResult result = rf_gltf_require( gltf, json, where, "count" );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, where, "count", 1, INT64_MAX, &count );
    if ( result == RF_OK )
        result = rf_gltf_check_limit( gltf, where, "count", (double)count, (double)MAX_ELEMENTS );
    out->count = (uint32_t)count;
    if ( result == RF_OK )
        result = read_component_type( gltf, json, where, &out->component_type );
    if ( result == RF_OK )
        result = read_type( gltf, json, where, out );
    if ( result == RF_OK )
        result = rf_gltf_get_bool( gltf, json, where, "normalized", &out->normalized );
    if ( result == RF_OK && out->normalized && out->component_type >= UNSIGNED_INT )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "normalized wants components of 8 or 16 bits" );
    return result;
}

static uint64_t element_size( const RfGltfAccessor* accessor )
{
    return (uint64_t)accessor->components * (uint64_t)rf_gltf_component_size( accessor->component_type );
}

static RfResult read_view( const RfGltf* gltf, const json_t* json, const char* where, RfGltfAccessor* out )
{
    int view;
    int64_t offset = 0;
    RfResult result = rf_gltf_get_index( gltf, json, where, "bufferView", RF_GLTF_BUFFER_VIEWS, &view );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, where, "byteOffset", 0, INT64_MAX, &offset );
    if ( result != RF_OK )
        return result;
    if ( view < 0 && out->count > MAX_ZEROS )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                             "%u elements without a bufferView are too many, the limit is %lld: "
                             "export the scene with its data",
                             out->count, (long long)MAX_ZEROS );
    if ( view < 0 )
        return RF_OK;
    uint64_t size = element_size( out );
    result = rf_gltf_view_stride( gltf, view, size, &out->stride );
    if ( result != RF_OK )
        return result;
    // count ≤ 2³¹ and stride ≤ 252: no overflow
    uint64_t need = out->stride * ( (uint64_t)out->count - 1 ) + size;
    return rf_gltf_view_bytes( gltf, where, view, (uint64_t)offset, need, &out->data );
}

static RfResult read_sparse_part( const RfGltf* gltf, const json_t* sparse, const char* where, const char* key, uint64_t bytes,
                                  const uint8_t** data )
{
    const json_t* part = NULL;
    int view = -1;
    int64_t offset = 0;
    RfResult result = rf_gltf_require( gltf, sparse, where, key );
    if ( result == RF_OK )
        result = rf_gltf_get_object( gltf, sparse, where, key, &part );
    if ( result != RF_OK )
        return result;
    RfWhere self = rf_where( "%s.%s", where, key );
    result = rf_gltf_require( gltf, part, self.text, "bufferView" );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, part, self.text, "bufferView", RF_GLTF_BUFFER_VIEWS, &view );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, part, self.text, "byteOffset", 0, INT64_MAX, &offset );
    if ( result == RF_OK )
        result = rf_gltf_view_bytes( gltf, self.text, view, (uint64_t)offset, bytes, data );
    return result;
}

static RfResult check_sparse_indices( const RfGltf* gltf, const char* where, const RfGltfAccessor* out )
{
    uint64_t size = (uint64_t)rf_gltf_component_size( out->sparse_type );
    int64_t last = -1;
    for ( uint32_t i = 0; i < out->sparse_count; ++i )
    {
        int64_t index = rf_gltf_read_u32( out->sparse_indices + i * size, out->sparse_type );
        if ( index <= last || index >= (int64_t)out->count )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "indices[%u] is %lld: they must increase and stay below %u", i,
                                 (long long)index, out->count );
        last = index;
    }
    return RF_OK;
}

static RfResult read_sparse( const RfGltf* gltf, const json_t* json, const char* accessor, RfGltfAccessor* out )
{
    const json_t* sparse = NULL;
    RfResult result = rf_gltf_get_object( gltf, json, accessor, "sparse", &sparse );
    if ( result != RF_OK || sparse == NULL )
        return result;
    RfWhere where = rf_where( "%s.sparse", accessor );
    int64_t count = 0;
    result = rf_gltf_require( gltf, sparse, where.text, "count" );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, sparse, where.text, "count", 1, out->count, &count );
    const json_t* indices = json_object_get( sparse, "indices" );
    if ( result == RF_OK && json_is_object( indices ) )
        result = read_component_type( gltf, indices, where.text, &out->sparse_type );
    if ( result != RF_OK )
        return result;
    if ( json_is_object( indices ) && out->sparse_type != UNSIGNED_BYTE && out->sparse_type != UNSIGNED_SHORT &&
         out->sparse_type != UNSIGNED_INT )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "indices want an unsigned componentType" );

    uint64_t index_bytes = (uint64_t)count * (uint64_t)rf_gltf_component_size( out->sparse_type );
    result = read_sparse_part( gltf, sparse, where.text, "indices", index_bytes, &out->sparse_indices );
    if ( result == RF_OK )
        result =
            read_sparse_part( gltf, sparse, where.text, "values", (uint64_t)count * element_size( out ), &out->sparse_values );
    if ( result != RF_OK )
        return result;
    out->sparse_count = (uint32_t)count;
    return check_sparse_indices( gltf, where.text, out );
}

RfResult rf_gltf_open_accessor( RfGltf* gltf, int index, const RfGltfAccessor** accessor )
{
    RfGltfAccessor* self = gltf->accessors + index;
    *accessor = self;
    if ( self->open )
        return RF_OK;
    RfWhere where = rf_where( "accessors[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_ACCESSORS, index );
    RfResult result = read_layout( gltf, json, where.text, self );
    if ( result == RF_OK )
        result = read_view( gltf, json, where.text, self );
    if ( result == RF_OK )
        result = read_sparse( gltf, json, where.text, self );
    self->open = result == RF_OK;
    return result;
}

RfResult rf_gltf_expect( const RfGltf* gltf, int index, const RfGltfAccessor* accessor, const char* user, int components )
{
    if ( accessor->components == components )
        return RF_OK;
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, user, "accessors[%d] has elements of %d numbers, %d are needed", index,
                         accessor->components, components );
}
