// EXT_meshopt_compression and KHR_meshopt_compression: buffer views that libmeshoptimizer decodes, and their filters.
#include "gltf/gltf_document.h"

#include "base/float_traps.h"
#include "base/try.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
static const char* find_fault( const Packed* p )
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
    const char* fault = find_fault( out );
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
    uint8_t* decoded = malloc( bytes );
    if ( decoded == NULL )
        return rf_gltf_no_memory( gltf, extension->path );
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
