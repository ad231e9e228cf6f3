#include "convert/glb_write.h"

#include "base/remedy.h"

#include "convert/glb_document.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void put_u32( uint8_t* at, uint64_t value )
{
    for ( int i = 0; i < 4; ++i )
        at[i] = (uint8_t)( value >> ( 8 * i ) );
}

static RfResult append_padding( RfAtomicFile* file, uint64_t size, char fill, RfError* error )
{
    const char padding[3] = { fill, fill, fill };
    return rf_append_atomic_file( file, padding, (size_t)( ( 4 - size % 4 ) % 4 ), error );
}

static RfResult append_chunk_head( RfAtomicFile* file, uint64_t size, const char* type, RfError* error )
{
    uint8_t head[8];
    put_u32( head, ( size + 3 ) / 4 * 4 );
    memcpy( head + 4, type, 4 );
    return rf_append_atomic_file( file, head, sizeof head, error );
}

static RfResult append_binary( RfAtomicFile* file, const RfGlbDocument* document, RfError* error )
{
    RfResult result = append_chunk_head( file, document->size, "BIN\0", error );
    for ( int i = 0; i < document->part_count && result == RF_OK; ++i )
    {
        const RfGlbPart* part = document->parts + i;
        result = rf_append_atomic_file( file, part->bytes, (size_t)part->size, error );
        if ( result == RF_OK )
            result = append_padding( file, part->size, 0, error );
    }
    return result;
}

static RfResult append_all( RfAtomicFile* file, const RfGlbDocument* document, const char* text, RfError* error )
{
    uint64_t text_size = strlen( text );
    uint64_t total = 12 + 8 + ( text_size + 3 ) / 4 * 4 + ( document->size > 0 ? 8 + document->size : 0 );
    if ( total > UINT32_MAX )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: would have %llu bytes, a .glb holds up to 4 GiB: split the model",
                        file->path, (unsigned long long)total );
    uint8_t head[12] = { 'g', 'l', 'T', 'F' };
    put_u32( head + 4, 2 );
    put_u32( head + 8, total );
    RfResult result = rf_append_atomic_file( file, head, sizeof head, error );
    if ( result == RF_OK )
        result = append_chunk_head( file, text_size, "JSON", error );
    if ( result == RF_OK )
        result = rf_append_atomic_file( file, text, (size_t)text_size, error );
    if ( result == RF_OK )
        result = append_padding( file, text_size, ' ', error );
    return result == RF_OK && document->size > 0 ? append_binary( file, document, error ) : result;
}

RfResult rf_append_glb( RfAtomicFile* file, const RfModel* model, RfError* error )
{
    RfResult result = rf_check_model( model, error );
    if ( result != RF_OK )
        return result;
    RfGlbDocument document;
    result = rf_make_glb_document( model, &document, error );
    if ( result == RF_OK )
    {
        char* text = json_dumps( document.root, JSON_COMPACT );
        if ( text == NULL )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its JSON", file->path );
        else
            result = append_all( file, &document, text, error );
        free( text );
    }
    rf_destroy_glb_document( &document );
    return result;
}

RfResult rf_write_glb( const char* path, const RfModel* model, bool overwrite, RfError* error )
{
    if ( !overwrite && access( path, F_OK ) == 0 )
        return rf_advise( rf_fail( error, RF_ERROR_IO, "%s: is there already", path ), RF_REMEDY_OVERWRITE, 0, error );
    RfAtomicFile file;
    RfResult result = rf_open_atomic_file( path, &file, error );
    if ( result != RF_OK )
        return result;
    result = rf_append_glb( &file, model, error );
    if ( result == RF_OK )
        return rf_commit_atomic_file( &file, error );
    rf_discard_atomic_file( &file );
    return result;
}
