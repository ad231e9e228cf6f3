// Buffers and buffer views. All sizes are compared as 64-bit differences, which cannot
// overflow.

#include "scene/gltf/gltf_document.h"

#include "base/file.h"

#include <stdlib.h>

// Limit of the sum over all buffer files, since a file may name the same one many times.
#define MAX_BUFFER_BYTES ( (uint64_t)16 << 30 )

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

static RfResult load_buffer( RfGltf* gltf, int index, uint64_t* room )
{
    RfWhere where = rf_where( "buffers[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_BUFFERS, index );
    RfGltfBuffer* buffer = gltf->buffers + index;
    int64_t length = 0;
    const char* uri = NULL;
    RfResult result = rf_gltf_require( gltf, json, where.text, "byteLength" );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, where.text, "byteLength", 1, (int64_t)1 << 53, &length );
    if ( result == RF_OK )
        result = rf_gltf_get_string( gltf, json, where.text, "uri", &uri );
    if ( result != RF_OK )
        return result;

    size_t size = 0;
    if ( uri != NULL )
    {
        result = load_uri( gltf, where.text, uri, *room, buffer, &size );
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
    else
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "has no uri, and the file no bytes for it" );
    if ( (uint64_t)length > size )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "byteLength is %lld, but there are %zu bytes", (long long)length,
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
    return RF_OK;
}

void rf_gltf_free_buffers( RfGltf* gltf )
{
    for ( int i = 0; gltf->buffers != NULL && i < gltf->counts[RF_GLTF_BUFFERS]; ++i )
        free( gltf->buffers[i].owned );
    free( gltf->buffers );
}

RfResult rf_gltf_view_bytes( const RfGltf* gltf, const char* where, int view, uint64_t offset, uint64_t need,
                             const uint8_t** bytes )
{
    RfWhere self = rf_where( "bufferViews[%d]", view );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_BUFFER_VIEWS, view );
    int64_t view_offset = 0, length = 0;
    int buffer = -1;
    RfResult result = rf_gltf_require( gltf, json, self.text, "buffer" );
    if ( result == RF_OK )
        result = rf_gltf_require( gltf, json, self.text, "byteLength" );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, json, self.text, "buffer", RF_GLTF_BUFFERS, &buffer );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, self.text, "byteOffset", 0, INT64_MAX, &view_offset );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, self.text, "byteLength", 1, INT64_MAX, &length );
    if ( result != RF_OK )
        return result;

    uint64_t size = gltf->buffers[buffer].size, start = (uint64_t)view_offset, extent = (uint64_t)length;
    if ( start > size || extent > size - start )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, self.text, "bytes %llu + %llu are outside buffers[%d] of %llu bytes",
                             (unsigned long long)start, (unsigned long long)extent, buffer, (unsigned long long)size );
    if ( offset > extent || need > extent - offset )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "bytes %llu + %llu are outside bufferViews[%d] of %llu bytes",
                             (unsigned long long)offset, (unsigned long long)need, view, (unsigned long long)extent );
    *bytes = gltf->buffers[buffer].data + start + offset;
    return RF_OK;
}

RfResult rf_gltf_view_stride( const RfGltf* gltf, int view, uint64_t element, uint64_t* stride )
{
    RfWhere where = rf_where( "bufferViews[%d]", view );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_BUFFER_VIEWS, view );
    int64_t value = (int64_t)element;
    if ( json_object_get( json, "byteStride" ) != NULL )
    {
        RfResult result = rf_gltf_get_integer( gltf, json, where.text, "byteStride", 4, 252, &value );
        if ( result != RF_OK )
            return result;
    }
    if ( (uint64_t)value < element )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "byteStride is %lld, but the elements have %llu bytes",
                             (long long)value, (unsigned long long)element );
    *stride = (uint64_t)value;
    return RF_OK;
}
