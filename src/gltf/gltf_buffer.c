// Where the bytes of a document are: URIs, buffers, and views that meshoptimizer compressed.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "base/file.h"
#include "base/float_traps.h"

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

static RfResult decode_data_uri( const RfGltf* gltf, const char* where, const char* uri, uint8_t** bytes, size_t* size )
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

// Files are named from the folder of the scene on, which `..` may leave, as folders of textures do.
static const char* find_fault( const char* path )
{
    if ( path[0] == 0 )
        return "is empty";
    if ( path[0] == '/' )
        return "begins with '/'";
    const char* colon = strchr( path, ':' );
    const char* slash = strchr( path, '/' );
    if ( colon != NULL && ( slash == NULL || colon < slash ) )
        return "has a scheme";
    return NULL;
}

// Programs for Windows write backslashes.
static void use_slashes( char* path )
{
    for ( ; *path != 0; ++path )
        *path = *path == '\\' ? '/' : *path;
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
    char* text;
    RF_TRY( rf_gltf_allocate( gltf, where, &text, folder + strlen( uri ), sizeof *text ) );
    memcpy( text, gltf->path, folder );
    strcpy( text + folder, uri );

    // checked before and after decoding: either form may hide a violation
    use_slashes( text + folder );
    const char* fault = find_fault( text + folder );
    if ( fault == NULL && decode_percent( text + folder ) == false )
        fault = "has a broken %-escape";
    use_slashes( text + folder );
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

RfResult rf_gltf_read_uri( const RfGltf* gltf, const char* where, const char* uri, uint64_t limit, uint8_t** bytes, size_t* size )
{
    if ( rf_is_data_uri( uri ) )
        return decode_data_uri( gltf, where, uri, bytes, size );
    char* path;
    RfError error;
    RF_TRY( rf_gltf_resolve_uri( gltf, where, uri, &path ) );
    RfResult result = rf_read_file( path, limit, bytes, size, &error );
    free( path );
    return result == RF_OK ? RF_OK : rf_gltf_fail( gltf, result, where, "%.560s", error.text );
}

// Buffers and buffer views. All sizes are compared as 64-bit differences, which cannot
// overflow.

// Limit of the sum over all buffer files, since a file may name the same one many times.
#define MAX_BUFFER_BYTES ( (uint64_t)16 << 30 )

// Limit of what compressed views hold, since few bytes may stand for many.
#define LEAST_ROOM ( (uint64_t)1 << 30 )
#define ROOM_PER_BYTE 256

static RfResult fail_empty( const RfGltf* gltf, const char* where )
{
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "has no uri, and the file no bytes for it" );
}

// Whether it holds what is compressed elsewhere.
static bool is_fallback( const json_t* buffer )
{
    const json_t* extensions = json_object_get( buffer, "extensions" );
    return json_is_true( json_object_get( json_object_get( extensions, "KHR_meshopt_compression" ), "fallback" ) ) ||
           json_is_true( json_object_get( json_object_get( extensions, "EXT_meshopt_compression" ), "fallback" ) );
}

// A buffer without bytes is of views that meshoptimizer compressed, and need not say so.
static bool may_be_empty( const RfGltf* gltf, const json_t* buffer )
{
    const json_t *used = json_object_get( gltf->root, "extensionsUsed" ), *name;
    size_t i;
    bool found = is_fallback( buffer );
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
    if ( is_fallback( json.json ) && rf_gltf_has_meshopt() )
    {
        buffer->size = (uint64_t)length;
        return RF_OK;
    }
    if ( uri != NULL )
    {
        result = rf_gltf_read_uri( gltf, json.path, uri, *room, &buffer->owned, &size );
        if ( result != RF_OK )
            return result;
        if ( !rf_is_data_uri( uri ) ) // data inside the document is covered by the hash of the file itself
            gltf->scene->content_hash = rf_hash_bytes( gltf->scene->content_hash, buffer->owned, size );
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
        return rf_field_fail( &json, "byteLength is %lld, but there are %zu bytes", (long long)length, size );
    buffer->size = (uint64_t)length;
    return RF_OK;
}

RfResult rf_gltf_load_buffers( RfGltf* gltf )
{
    int count = gltf->counts[RF_GLTF_BUFFERS];
    RF_TRY( rf_gltf_allocate( gltf, "buffers", &gltf->buffers, (size_t)count, sizeof *gltf->buffers ) );
    uint64_t room = MAX_BUFFER_BYTES;
    for ( int i = 0; i < count; ++i )
    {
        RF_TRY( load_buffer( gltf, i, &room ) );
    }
    size_t views = (size_t)gltf->counts[RF_GLTF_BUFFER_VIEWS];
    gltf->unpacked = calloc( 1, sizeof *gltf->unpacked + views * sizeof gltf->unpacked->views[0] );
    if ( gltf->unpacked == NULL )
        return rf_gltf_no_memory( gltf, "bufferViews" );
    gltf->unpacked->room = LEAST_ROOM + ROOM_PER_BYTE * ( MAX_BUFFER_BYTES - room + gltf->bin_size );
    return RF_OK;
}

void rf_gltf_free_buffers( RfGltf* gltf )
{
    for ( int i = 0; gltf->buffers != NULL && i < gltf->counts[RF_GLTF_BUFFERS]; ++i )
        free( gltf->buffers[i].owned );
    free( gltf->buffers );
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
    RF_TRY( rf_get_integer( json, "byteLength", 1, INT64_MAX, &extent ) );

    uint64_t size = gltf->buffers[buffer].size, start = (uint64_t)offset;
    *length = (uint64_t)extent;
    if ( start > size || *length > size - start )
        return rf_field_fail( json, "bytes %llu + %llu are outside buffers[%d] of %llu bytes", (unsigned long long)start,
                              (unsigned long long)*length, buffer, (unsigned long long)size );
    if ( gltf->buffers[buffer].data == NULL )
        return fail_empty( gltf, rf_where( "buffers[%d]", buffer ).text );
    *bytes = gltf->buffers[buffer].data + start;
    return RF_OK;
}

#define EXT "EXT_meshopt_compression"
#define KHR "KHR_meshopt_compression"

static RfField find_extension( const RfField* object, const char** name )
{
    *name = KHR;
    RfField extension = rf_gltf_extension( object, KHR );
    if ( extension.json != NULL )
        return extension;
    *name = EXT;
    return rf_gltf_extension( object, EXT );
}

#ifdef REFRAME_MESHOPT

#include <meshoptimizer.h>

typedef enum Mode
{
    ATTRIBUTES,
    TRIANGLES,
    INDICES,
} Mode;

typedef enum Filter
{
    NONE,
    OCTAHEDRAL,
    QUATERNION,
    EXPONENTIAL,
    COLOR,
} Filter;

// What a view says of its data.
typedef struct Packed
{
    const char* name; // of the extension
    const uint8_t* bytes;
    uint64_t length;
    uint64_t count, stride; // of elements when decoded
    Mode mode;
    Filter filter;
} Packed;

// 256 elements take at least a byte for every four of an element.
#define MOST_PER_BYTE 1024

// What may stand together, by the specification.
static const char* find_packed_fault( const Packed* p )
{
    uint64_t stride = p->stride;
    if ( p->mode == ATTRIBUTES && stride % 4 != 0 )
        return "byteStride must be a multiple of 4";
    if ( p->mode != ATTRIBUTES && stride != 2 && stride != 4 )
        return "byteStride must be 2 or 4";
    if ( p->mode != ATTRIBUTES && p->filter != NONE )
        return "a filter needs the mode ATTRIBUTES";
    if ( p->mode == TRIANGLES && p->count % 3 != 0 )
        return "count must be a multiple of 3";
    if ( ( p->filter == OCTAHEDRAL || p->filter == COLOR ) && stride != 4 && stride != 8 )
        return "byteStride must be 4 or 8 with this filter";
    if ( p->filter == QUATERNION && stride != 8 )
        return "byteStride must be 8 with this filter";
    if ( p->filter == COLOR && strcmp( p->name, EXT ) == 0 )
        return "the filter COLOR is of " KHR " only";
    return NULL;
}

static RfResult read_packed( const RfGltf* gltf, const RfField* json, Packed* out )
{
    static const char* const s_modes[] = { "ATTRIBUTES", "TRIANGLES", "INDICES", NULL };
    static const char* const s_filters[] = { "NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR", NULL };
    int64_t count = 0, stride = 0;
    int mode = 0, filter = 0;
    rf_gltf_read_range( gltf, json, &out->bytes, &out->length );
    rf_gltf_require( json, "byteStride", "count", "mode", NULL );
    rf_get_integer( json, "byteStride", 2, 256, &stride );
    rf_get_integer( json, "count", 1, UINT32_MAX, &count );
    rf_get_choice( json, "mode", s_modes, &mode );
    RF_TRY( rf_get_choice( json, "filter", s_filters, &filter ) );
    out->count = (uint64_t)count;
    out->stride = (uint64_t)stride;
    out->mode = (Mode)mode;
    out->filter = (Filter)filter;
    const char* fault = find_packed_fault( out );
    if ( fault != NULL )
        return rf_field_fail( json, "%s", fault );
    if ( out->count * out->stride / MOST_PER_BYTE > out->length )
        return rf_field_fail( json, "%llu bytes cannot hold %llu elements of %llu bytes", (unsigned long long)out->length,
                              (unsigned long long)out->count, (unsigned long long)out->stride );
    return RF_OK;
}

// A colour of K bits as Y, Co, Cg and an alpha of K−1 bits below a bit that is 1 (KHR_meshopt_compression, filter 4).
static void decode_color( int y, int co, int cg, int alpha, int most, int out[4] )
{
    int ones = 0;
    while ( ones < alpha )
        ones = 2 * ones + 1;
    int low = alpha & ( ones >> 1 );
    int color[4] = { y + co - cg, y + cg, y - co - cg, 2 * low + ( low & 1 ) };
    for ( int i = 0; i < 4; ++i )
    {
        // a sum outside K bits is of a broken file
        float value = ones > 0 ? roundf( (float)color[i] * ( (float)most / (float)ones ) ) : 0.0f;
        out[i] = value < 0.0f ? 0 : value > (float)most ? most : (int)value;
    }
}

static void filter_colors( uint8_t* bytes, size_t count, size_t stride )
{
    int out[4];
    for ( size_t i = 0; i < count; ++i, bytes += stride )
    {
        if ( stride == 4 )
        {
            decode_color( bytes[0], (int8_t)bytes[1], (int8_t)bytes[2], bytes[3], 255, out );
            for ( int c = 0; c < 4; ++c )
                bytes[c] = (uint8_t)out[c];
            continue;
        }
        uint16_t in[4];
        memcpy( in, bytes, 8 );
        decode_color( in[0], (int16_t)in[1], (int16_t)in[2], in[3], 65535, out );
        for ( int c = 0; c < 4; ++c )
            in[c] = (uint16_t)out[c];
        memcpy( bytes, in, 8 );
    }
}

// False where the bytes are not of the mode.
static bool decode( const Packed* p, uint8_t* out )
{
    size_t count = (size_t)p->count, stride = (size_t)p->stride, length = (size_t)p->length;
    switch ( p->mode )
    {
        case ATTRIBUTES: return meshopt_decodeVertexBuffer( out, count, stride, p->bytes, length ) == 0;
        case TRIANGLES: return meshopt_decodeIndexBuffer( out, count, stride, p->bytes, length ) == 0;
        case INDICES: return meshopt_decodeIndexSequence( out, count, stride, p->bytes, length ) == 0;
    }
    return false;
}

static void apply_filter( const Packed* p, uint8_t* out )
{
    size_t count = (size_t)p->count, stride = (size_t)p->stride;
    int traps = rf_pause_float_traps(); // lanes beyond the last element are zeros
    switch ( p->filter )
    {
        case NONE: break;
        case OCTAHEDRAL: meshopt_decodeFilterOct( out, count, stride ); break;
        case QUATERNION: meshopt_decodeFilterQuat( out, count, stride ); break;
        case EXPONENTIAL: meshopt_decodeFilterExp( out, count, stride ); break;
        case COLOR: filter_colors( out, count, stride ); break;
    }
    rf_resume_float_traps( traps );
}

static RfResult fail_decode( const RfGltf* gltf, const char* where, const Packed* p )
{
    // attributes of version 1 are read since 0.23
    if ( p->mode == ATTRIBUTES && p->bytes[0] == 0xa1 && MESHOPTIMIZER_VERSION < 230 )
        return rf_gltf_fail(
            gltf, RF_ERROR_UNSUPPORTED, where,
            "has attributes of version 1, which meshoptimizer decodes since 0.23, and this one is %d.%d: " RF_GLTF_UNPACK,
            MESHOPTIMIZER_VERSION / 1000, MESHOPTIMIZER_VERSION % 1000 / 10 );
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "its %llu bytes are not %llu elements that meshoptimizer decodes",
                         (unsigned long long)p->length, (unsigned long long)p->count );
}

static RfResult unpack( const RfGltf* gltf, const RfField* view, const RfField* extension, const char* name,
                        RfGltfUnpackedView* out )
{
    Packed packed = { .name = name };
    int64_t length = 0;
    RF_TRY( read_packed( gltf, extension, &packed ) );
    RF_TRY( rf_get_integer( view, "byteLength", 1, INT64_MAX, &length ) );
    uint64_t bytes = packed.count * packed.stride;
    if ( (uint64_t)length != bytes )
        return rf_field_fail( view, "byteLength is %lld, but %llu elements of %llu bytes are compressed", (long long)length,
                              (unsigned long long)packed.count, (unsigned long long)packed.stride );
    RF_TRY( rf_gltf_take_room( gltf, extension->path, bytes ) );
    uint8_t* decoded;
    RF_TRY( rf_gltf_allocate( gltf, extension->path, &decoded, bytes, sizeof *decoded ) );
    if ( !decode( &packed, decoded ) )
    {
        free( decoded );
        return fail_decode( gltf, extension->path, &packed );
    }
    apply_filter( &packed, decoded );
    out->bytes = decoded;
    out->size = bytes;
    return RF_OK;
}

RfResult rf_gltf_unpack_view( const RfGltf* gltf, int view, const RfGltfUnpackedView** out )
{
    RfGltfUnpackedView* self = gltf->unpacked->views + view;
    const char* name;
    *out = self->size > 0 ? self : NULL;
    if ( *out != NULL )
        return RF_OK;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view ), extension = find_extension( &json, &name );
    if ( extension.json == NULL )
        return rf_json_result( &json );
    *out = self;
    return unpack( gltf, &json, &extension, name, self );
}

#else

RfResult rf_gltf_unpack_view( const RfGltf* gltf, int view, const RfGltfUnpackedView** out )
{
    const char* name;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view ), extension = find_extension( &json, &name );
    *out = NULL;
    int buffer = extension.json != NULL ? rf_gltf_get_index( gltf, &json, "buffer", RF_GLTF_BUFFERS ) : -1;
    if ( buffer < 0 || gltf->buffers[buffer].data != NULL )
        return rf_json_result( &json );
    return rf_gltf_fail_left_out( gltf, json.path, name, "meshoptimizer" );
}

#endif
