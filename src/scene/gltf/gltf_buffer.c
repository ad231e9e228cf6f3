// Where the numbers of a document are: URIs, buffers, their views, and accessors.
#include "scene/gltf/gltf_document.h"

#include "base/file.h"
#include "scene/gltf/draco_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// URIs of buffers: base64 data in the document, or a file beside it.

bool rf_is_data_uri( const char* uri ) { return strncmp( uri, "data:", 5 ) == 0; }

static int base64_value( unsigned char c )
{
    if ( c >= 'A' && c <= 'Z' )
        return c - 'A';
    if ( c >= 'a' && c <= 'z' )
        return c - 'a' + 26;
    if ( c >= '0' && c <= '9' )
        return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// False if a character is not in the base64 alphabet.
static bool decode_base64( const char* text, size_t length, uint8_t* bytes )
{
    uint32_t bits = 0;
    int held = 0;
    for ( size_t i = 0; i < length; ++i )
    {
        int value = base64_value( (unsigned char)text[i] );
        if ( value < 0 )
            return false;
        bits = bits << 6 | (uint32_t)value;
        held += 6;
        if ( held >= 8 )
        {
            held -= 8;
            *bytes++ = (uint8_t)( bits >> held );
        }
    }
    return true;
}

RfResult rf_gltf_decode_data_uri( const RfGltf* gltf, const char* where, const char* uri, uint8_t** bytes, size_t* size )
{
    const char* comma = strchr( uri, ',' );
    if ( comma == NULL || comma - uri < 7 || strncmp( comma - 7, ";base64", 7 ) != 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "uri is data that is not base64" );
    const char* text = comma + 1;
    size_t length = strlen( text );
    for ( int pad = 0; pad < 2 && length > 0 && text[length - 1] == '='; ++pad )
        length -= 1;
    if ( length % 4 == 1 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "uri has base64 data that is truncated" );
    *size = length / 4 * 3 + ( length % 4 > 0 ? length % 4 - 1 : 0 );
    *bytes = malloc( *size > 0 ? *size : 1 );
    if ( *bytes == NULL )
        return rf_gltf_no_memory( gltf, where );
    if ( decode_base64( text, length, *bytes ) )
        return RF_OK;
    free( *bytes );
    *bytes = NULL;
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "uri has a character that is not base64" );
}

static int hex_value( char c )
{
    if ( c >= '0' && c <= '9' )
        return c - '0';
    if ( c >= 'a' && c <= 'f' )
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

// Decodes in place; false on an invalid escape or an encoded zero byte.
static bool decode_percent( char* text )
{
    char* out = text;
    for ( const char* in = text; *in != 0; ++in )
    {
        char c = *in;
        if ( c == '%' )
        {
            int high = hex_value( in[1] );
            int low = high >= 0 ? hex_value( in[2] ) : -1;
            if ( low < 0 || high * 16 + low == 0 )
                return false;
            c = (char)( high * 16 + low );
            in += 2;
        }
        *out++ = c;
    }
    *out = 0;
    return true;
}

static bool leaves_folder( const char* path )
{
    for ( const char* part = path; part != NULL; )
    {
        const char* slash = strchr( part, '/' );
        size_t length = slash != NULL ? (size_t)( slash - part ) : strlen( part );
        if ( length == 2 && strncmp( part, "..", 2 ) == 0 )
            return true;
        part = slash != NULL ? slash + 1 : NULL;
    }
    return false;
}

// Only files beside or below the scene may be named: an untrusted scene must not read other
// files of the machine.
static const char* find_fault( const char* path )
{
    if ( path[0] == 0 )
        return "is empty";
    if ( path[0] == '/' )
        return "begins with '/'";
    if ( strchr( path, '\\' ) != NULL )
        return "has a backslash";
    if ( leaves_folder( path ) )
        return "leaves the folder by '..'";
    const char* colon = strchr( path, ':' );
    const char* slash = strchr( path, '/' );
    if ( colon != NULL && ( slash == NULL || colon < slash ) )
        return "has a scheme";
    return NULL;
}

RfResult rf_gltf_resolve_uri( const RfGltf* gltf, const char* where, const char* uri, char** path )
{
    *path = NULL;
    if ( rf_is_web_address( uri ) )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                             "uri '%.300s' is not fetched: download it beside the scene, and give its file name as the uri",
                             uri );
    const char* slash = strrchr( gltf->path, '/' );
    size_t folder = slash != NULL ? (size_t)( slash - gltf->path ) + 1 : 0;
    char* text = malloc( folder + strlen( uri ) + 1 );
    if ( text == NULL )
        return rf_gltf_no_memory( gltf, where );
    memcpy( text, gltf->path, folder );
    strcpy( text + folder, uri );

    // checked before and after decoding: either form may hide a violation
    const char* fault = find_fault( text + folder );
    if ( fault == NULL && decode_percent( text + folder ) == false )
        fault = "has a broken %-escape";
    if ( fault == NULL )
        fault = find_fault( text + folder );
    if ( fault != NULL )
    {
        free( text );
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                             "uri '%.80s' %s: put the file beside the scene and name it without a folder", uri, fault );
    }
    *path = text;
    return RF_OK;
}

// Buffers and buffer views. All sizes are compared as 64-bit differences, which cannot
// overflow.

// Limit of the sum over all buffer files, since a file may name the same one many times.
#define MAX_BUFFER_BYTES ( (uint64_t)16 << 30 )

// Limit of what compressed views hold, since few bytes may stand for many.
#define LEAST_ROOM ( (uint64_t)1 << 30 )
#define ROOM_PER_BYTE 256

static RfResult load_uri( RfGltf* gltf, const char* where, const char* uri, uint64_t limit, RfGltfBuffer* buffer, size_t* size )
{
    if ( rf_is_data_uri( uri ) )
        return rf_gltf_decode_data_uri( gltf, where, uri, &buffer->owned, size );
    char* path;
    RfResult result = rf_gltf_resolve_uri( gltf, where, uri, &path );
    if ( result != RF_OK )
        return result;
    RfError error;
    result = rf_read_file( path, limit, &buffer->owned, size, &error );
    free( path );
    if ( result != RF_OK )
        return rf_gltf_fail( gltf, result, where, "%.560s", error.text );
    // data inside the document is covered by the hash of the file itself
    gltf->scene->content_hash = rf_hash_bytes( gltf->scene->content_hash, buffer->owned, *size );
    return RF_OK;
}

static RfResult fail_empty( const RfGltf* gltf, const char* where )
{
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "has no uri, and the file no bytes for it" );
}

// A buffer without bytes is of views that meshoptimizer compressed, and need not say so.
static bool may_be_empty( const RfGltf* gltf, const json_t* buffer )
{
    const json_t *used = json_object_get( gltf->root, "extensionsUsed" ), *name;
    size_t i;
    bool found = rf_gltf_is_fallback( buffer );
    json_array_foreach( used, i, name )
    {
        const char* text = json_is_string( name ) ? json_string_value( name ) : "";
        found = found || strcmp( text, "EXT_meshopt_compression" ) == 0 || strcmp( text, "KHR_meshopt_compression" ) == 0;
    }
    return found;
}

static RfResult load_buffer( RfGltf* gltf, int index, uint64_t* room )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFERS, index );
    RfGltfBuffer* buffer = gltf->buffers + index;
    int64_t length = 0;
    const char* uri = NULL;
    rf_gltf_require( &json, "byteLength", NULL );
    rf_get_integer( &json, "byteLength", 1, (int64_t)1 << 53, &length );
    RfResult result = rf_get_text( &json, "uri", &uri );
    if ( result != RF_OK )
        return result;

    size_t size = 0;
    if ( rf_gltf_is_fallback( json.json ) && rf_gltf_has_meshopt() )
    {
        buffer->size = (uint64_t)length;
        return RF_OK;
    }
    if ( uri != NULL )
    {
        result = load_uri( gltf, json.path, uri, *room, buffer, &size );
        if ( result != RF_OK )
            return result;
        *room -= size < *room ? size : *room;
        buffer->data = buffer->owned;
    }
    else if ( index == 0 && gltf->bin != NULL )
    {
        buffer->data = gltf->bin;
        size = gltf->bin_size;
    }
    else if ( may_be_empty( gltf, json.json ) )
    {
        buffer->size = (uint64_t)length;
        return RF_OK;
    }
    else
        return fail_empty( gltf, json.path );
    if ( (uint64_t)length > size )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json.path, "byteLength is %lld, but there are %zu bytes", (long long)length,
                             size );
    buffer->size = (uint64_t)length;
    return RF_OK;
}

RfResult rf_gltf_load_buffers( RfGltf* gltf )
{
    int count = gltf->counts[RF_GLTF_BUFFERS];
    gltf->buffers = calloc( (size_t)count + 1, sizeof *gltf->buffers );
    if ( gltf->buffers == NULL )
        return rf_gltf_no_memory( gltf, "buffers" );
    uint64_t room = MAX_BUFFER_BYTES;
    for ( int i = 0; i < count; ++i )
    {
        RfResult result = load_buffer( gltf, i, &room );
        if ( result != RF_OK )
            return result;
    }
    size_t views = (size_t)gltf->counts[RF_GLTF_BUFFER_VIEWS];
    gltf->unpacked = calloc( 1, sizeof *gltf->unpacked + views * sizeof gltf->unpacked->views[0] );
    if ( gltf->unpacked == NULL )
        return rf_gltf_no_memory( gltf, "bufferViews" );
    gltf->unpacked->room = LEAST_ROOM + ROOM_PER_BYTE * ( MAX_BUFFER_BYTES - room + gltf->bin_size );
    return RF_OK;
}

static void free_unpacked( RfGltfUnpackedView* view )
{
    int attributes = view->mesh != NULL && view->attributes != NULL ? rf_draco_attributes( view->mesh ) : 0;
    for ( int i = 0; i < attributes; ++i )
        free( view->attributes[i].values );
    free( view->attributes );
    free( view->corners );
    free( view->bytes );
    rf_draco_free( view->mesh );
}

void rf_gltf_free_buffers( RfGltf* gltf )
{
    for ( int i = 0; gltf->buffers != NULL && i < gltf->counts[RF_GLTF_BUFFERS]; ++i )
        free( gltf->buffers[i].owned );
    free( gltf->buffers );
    for ( int i = 0; gltf->unpacked != NULL && i < gltf->counts[RF_GLTF_BUFFER_VIEWS]; ++i )
        free_unpacked( gltf->unpacked->views + i );
    free( gltf->unpacked );
}

RfResult rf_gltf_take_room( const RfGltf* gltf, const char* where, uint64_t bytes )
{
    if ( bytes > gltf->unpacked->room )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                             "unpacks to %llu bytes, beyond what reframe reads of a file of this size: split the scene",
                             (unsigned long long)bytes );
    gltf->unpacked->room -= bytes;
    return RF_OK;
}

RfResult rf_gltf_read_range( const RfGltf* gltf, const RfField* json, const uint8_t** bytes, uint64_t* length )
{
    int64_t offset = 0, extent = 0;
    rf_gltf_require( json, "buffer", "byteLength", NULL );
    int buffer = rf_gltf_get_index( gltf, json, "buffer", RF_GLTF_BUFFERS );
    rf_get_integer( json, "byteOffset", 0, INT64_MAX, &offset );
    RfResult result = rf_get_integer( json, "byteLength", 1, INT64_MAX, &extent );
    if ( result != RF_OK )
        return result;

    uint64_t size = gltf->buffers[buffer].size, start = (uint64_t)offset;
    *length = (uint64_t)extent;
    if ( start > size || *length > size - start )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json->path, "bytes %llu + %llu are outside buffers[%d] of %llu bytes",
                             (unsigned long long)start, (unsigned long long)*length, buffer, (unsigned long long)size );
    if ( gltf->buffers[buffer].data == NULL )
        return fail_empty( gltf, rf_where( "buffers[%d]", buffer ).text );
    *bytes = gltf->buffers[buffer].data + start;
    return RF_OK;
}

RfResult rf_gltf_view_bytes( const RfGltf* gltf, const char* where, int view, uint64_t offset, uint64_t need,
                             const uint8_t** bytes )
{
    const RfGltfUnpackedView* unpacked;
    const uint8_t* start = NULL;
    uint64_t extent = 0;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view );
    RfResult result = rf_gltf_unpack_view( gltf, view, &unpacked );
    if ( result == RF_OK && unpacked == NULL )
        result = rf_gltf_read_range( gltf, &json, &start, &extent );
    if ( result != RF_OK )
        return result;
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

// The stride of a view for elements of `element` bytes.
static RfResult view_stride( const RfGltf* gltf, int view, uint64_t element, uint64_t* stride )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view );
    int64_t value = (int64_t)element;
    RfResult result = rf_get_integer( &json, "byteStride", 4, 252, &value );
    if ( result != RF_OK )
        return result;
    if ( (uint64_t)value < element )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json.path, "byteStride is %lld, but the elements have %llu bytes",
                             (long long)value, (unsigned long long)element );
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

static RfResult read_type( const RfGltf* gltf, const RfField* json, bool matrix, RfGltfAccessor* out )
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
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json->path, "type '%.20s' must be MAT4 of floats here", type );
    }
    if ( out->components == 0 || type[0] == 'M' )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json->path, "type '%.20s' must be SCALAR, VEC2, VEC3 or VEC4 here", type );
    return RF_OK;
}

static RfResult read_component_type( const RfGltf* gltf, const RfField* json, int* component_type )
{
    int64_t value = 0;
    rf_gltf_require( json, "componentType", NULL );
    RfResult result = rf_get_integer( json, "componentType", BYTE, FLOAT, &value );
    if ( result == RF_OK && rf_gltf_component_size( (int)value ) == 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json->path, "componentType %d does not exist", (int)value );
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
    read_component_type( gltf, json, &out->component_type );
    RfResult result = read_type( gltf, json, matrix, out );
    if ( result == RF_OK )
        result = rf_get_bool( json, "normalized", &out->normalized );
    if ( result == RF_OK && out->normalized && out->component_type >= UNSIGNED_INT )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json->path, "normalized needs components of 8 or 16 bits" );
    return result;
}

static uint64_t element_size( const RfGltfAccessor* accessor )
{
    return (uint64_t)accessor->components * (uint64_t)rf_gltf_component_size( accessor->component_type );
}

static RfResult read_view( const RfGltf* gltf, const RfField* json, RfGltfAccessor* out )
{
    int64_t offset = 0;
    int view = rf_gltf_get_index( gltf, json, "bufferView", RF_GLTF_BUFFER_VIEWS );
    RfResult result = rf_get_integer( json, "byteOffset", 0, INT64_MAX, &offset );
    if ( result != RF_OK )
        return result;
    if ( view < 0 && out->count > MAX_ZEROS )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, json->path,
                             "%u elements without a bufferView are too many, the limit is %lld: "
                             "export the scene with its data",
                             out->count, (long long)MAX_ZEROS );
    if ( view < 0 )
        return RF_OK;
    uint64_t size = element_size( out );
    result = view_stride( gltf, view, size, &out->stride );
    if ( result != RF_OK )
        return result;
    // count ≤ 2³¹ and stride ≤ 252: no overflow
    uint64_t need = out->stride * ( (uint64_t)out->count - 1 ) + size;
    return rf_gltf_view_bytes( gltf, json->path, view, (uint64_t)offset, need, &out->data );
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
    return result == RF_OK ? rf_gltf_view_bytes( gltf, part.path, view, (uint64_t)offset, bytes, data ) : result;
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
        result = read_component_type( gltf, &indices, &out->sparse_type );
    if ( result != RF_OK )
        return result;
    if ( typed && out->sparse_type != UNSIGNED_BYTE && out->sparse_type != UNSIGNED_SHORT && out->sparse_type != UNSIGNED_INT )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, sparse.path, "indices must have an unsigned componentType" );

    uint64_t index_bytes = (uint64_t)count * (uint64_t)rf_gltf_component_size( out->sparse_type );
    result = read_sparse_part( gltf, &sparse, "indices", index_bytes, &out->sparse_indices );
    if ( result == RF_OK )
        result = read_sparse_part( gltf, &sparse, "values", (uint64_t)count * element_size( out ), &out->sparse_values );
    if ( result != RF_OK )
        return result;
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
    RfResult result = rf_gltf_read_layout( gltf, &json, matrix, self );
    if ( result == RF_OK )
        result = read_view( gltf, &json, self );
    if ( result == RF_OK )
        result = read_sparse( gltf, &json, self );
    self->open = result == RF_OK;
    return result;
}

RfResult rf_gltf_open_accessor( RfGltf* gltf, int index, const RfGltfAccessor** accessor )
{
    return open_accessor( gltf, index, false, accessor );
}

RfResult rf_gltf_open_matrices( RfGltf* gltf, int index, const RfGltfAccessor** accessor )
{
    RfResult result = open_accessor( gltf, index, true, accessor );
    return result == RF_OK ? rf_gltf_expect( gltf, index, *accessor, "skins", 16 ) : result;
}

RfResult rf_gltf_expect( const RfGltf* gltf, int index, const RfGltfAccessor* accessor, const char* user, int components )
{
    if ( accessor->components == components )
        return RF_OK;
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, user, "accessors[%d] has elements of %d numbers, %d are needed",
                         declared_index( gltf, index ), accessor->components, components );
}
