// The films of an interrupted render as a file: a header that says of which render it is, the bytes, and their checksum.
#include "cli/render/films_file.h"

#include "base/file.h"
#include "reframe/image.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#define MAGIC "reframe films 1\n"
#define ENDING ".films"

typedef struct Header
{
    char magic[sizeof MAGIC - 1];
    char fingerprint[RF_FINGERPRINT_SIZE + 7];
    uint64_t frames; // hash of the numbers of those left
    int32_t count, first, last;
    uint32_t none;
} Header;

typedef struct Trailer
{
    uint64_t bytes, hash;
} Trailer;

RfResult rf_films_file_name( const RfOutput* output, int frame, char name[RF_FILMS_NAME_SIZE], RfError* error )
{
    RfResult result =
        rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, RF_FILMS_NAME_SIZE, error );
    if ( result != RF_OK )
        return result;
    char* end = strrchr( name, '.' ); // of .exr
    size_t length = end != NULL ? (size_t)( end - name ) : strlen( name );
    if ( length + sizeof ENDING > RF_FILMS_NAME_SIZE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", name );
    memcpy( name + length, ENDING, sizeof ENDING );
    return RF_OK;
}

static Header header_of( const RfFramesLeft* left )
{
    const RfCameraPath* path = left->output->path;
    Header header = { .count = left->count,
                      .first = rf_frame_number( path, left->frames[0] ),
                      .last = rf_frame_number( path, left->frames[left->count - 1] ) };
    memcpy( header.magic, MAGIC, sizeof header.magic );
    rf_frame_fingerprint( left->output, left->frames[0], header.fingerprint );
    header.frames = rf_hash_bytes( 0, left->frames, (size_t)left->count * sizeof( int ) );
    return header;
}

// The block so far.
static RfResult write_block( RfFilmsWriter* writer, RfError* error )
{
    RfResult result = rf_append_atomic_file( &writer->file, writer->block, writer->used, error );
    writer->bytes += writer->used;
    writer->hash = rf_hash_bytes( writer->hash, writer->block, writer->used );
    writer->used = 0;
    if ( result != RF_OK )
        rf_discard_atomic_file( &writer->file );
    writer->open = result == RF_OK;
    return result;
}

RfResult rf_create_films_file( const RfFramesLeft* left, RfFilmsWriter* writer, RfError* error )
{
    writer->bytes = writer->hash = writer->used = 0;
    RfResult result = rf_films_file_name( left->output, left->frames[0], writer->name, error );
    if ( result == RF_OK )
        result = rf_open_atomic_file( writer->name, &writer->file, error );
    writer->open = result == RF_OK;
    Header header = header_of( left );
    return result == RF_OK ? rf_append_films( writer, &header, sizeof header, error ) : result;
}

RfResult rf_append_films( RfFilmsWriter* writer, const void* bytes, size_t size, RfError* error )
{
    const unsigned char* at = bytes;
    RfResult result = RF_OK;
    while ( size > 0 && result == RF_OK )
    {
        size_t room = sizeof writer->block - writer->used, part = size < room ? size : room;
        memcpy( writer->block + writer->used, at, part );
        writer->used += part;
        at += part;
        size -= part;
        if ( writer->used == sizeof writer->block )
            result = write_block( writer, error );
    }
    return result;
}

RfResult rf_end_films_file( RfFilmsWriter* writer, RfError* error )
{
    RfResult result = write_block( writer, error );
    Trailer trailer = { writer->bytes, writer->hash };
    if ( result != RF_OK )
        return result;
    writer->open = false;
    result = rf_append_atomic_file( &writer->file, &trailer, sizeof trailer, error );
    if ( result == RF_OK )
        return rf_commit_atomic_file( &writer->file, error );
    rf_discard_atomic_file( &writer->file );
    return result;
}

// The header, unless the bytes after it are not those that were written.
static bool read_whole( FILE* file, Header* header )
{
    unsigned char block[RF_FILMS_BLOCK];
    Trailer trailer;
    uint64_t hash = 0, left;
    long size = fseek( file, 0, SEEK_END ) == 0 ? ftell( file ) : -1;
    if ( size < (long)( sizeof *header + sizeof trailer ) || fseek( file, 0, SEEK_SET ) != 0 )
        return false;
    left = (uint64_t)size - sizeof trailer;
    for ( size_t part; left > 0; left -= part )
    {
        part = left < sizeof block ? (size_t)left : sizeof block;
        if ( fread( block, part, 1, file ) != 1 )
            return false;
        hash = rf_hash_bytes( hash, block, part );
    }
    return fread( &trailer, sizeof trailer, 1, file ) == 1 && trailer.hash == hash &&
           trailer.bytes == (uint64_t)size - sizeof trailer && fseek( file, 0, SEEK_SET ) == 0 &&
           fread( header, sizeof *header, 1, file ) == 1 && memcmp( header->magic, MAGIC, sizeof header->magic ) == 0;
}

static RfFilmsState compare( const RfFramesLeft* left, const char* name, const Header* there, RfError* error )
{
    Header here = header_of( left );
    if ( memcmp( there->fingerprint, here.fingerprint, sizeof here.fingerprint ) != 0 )
    {
        rf_fail( error, RF_ERROR_IO, "%s: are the films of another render: of another scene, path, version or settings", name );
        return RF_FILMS_OTHER;
    }
    if ( memcmp( there, &here, sizeof here ) == 0 )
        return RF_FILMS_SAME;
    rf_fail( error, RF_ERROR_IO, "%s: are films for frames %d to %d (%d), and frames %d to %d (%d) are left to be rendered", name,
             (int)there->first, (int)there->last, (int)there->count, (int)here.first, (int)here.last, (int)here.count );
    return RF_FILMS_OTHER_FRAMES;
}

RfFilmsState rf_open_films_file( const RfFramesLeft* left, FILE** file, RfError* error )
{
    char name[RF_FILMS_NAME_SIZE];
    Header header;
    RfFilmsState state = RF_FILMS_UNREADABLE;
    if ( rf_films_file_name( left->output, left->frames[0], name, error ) != RF_OK )
        return RF_FILMS_MISSING; // nor has the frame a name
    *file = fopen( name, "rb" );
    if ( *file == NULL && errno == ENOENT )
        return RF_FILMS_MISSING;
    if ( *file == NULL )
        rf_fail_io( name, "cannot be read", errno, error );
    else if ( !read_whole( *file, &header ) )
        rf_fail( error, RF_ERROR_IO, "%s: are no whole films of a render", name );
    else
        state = compare( left, name, &header, error );
    if ( *file != NULL && state != RF_FILMS_SAME )
    {
        fclose( *file );
        *file = NULL;
    }
    return state;
}

void rf_remove_films_file( const RfOutput* output, int frame )
{
    char name[RF_FILMS_NAME_SIZE], magic[sizeof MAGIC - 1];
    FILE* file = rf_films_file_name( output, frame, name, NULL ) == RF_OK ? fopen( name, "rb" ) : NULL;
    if ( file == NULL )
        return;
    bool ours = fread( magic, sizeof magic, 1, file ) == 1 && memcmp( magic, MAGIC, sizeof magic ) == 0;
    fclose( file );
    if ( ours )
        (void)unlink( name );
}
