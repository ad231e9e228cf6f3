// The films of an interrupted render as a file: a header that says of which render it is, the frames that are left, the bytes, and
// their checksum.
#include "cli/render/films_file.h"

#include "base/file.h"
#include "base/system.h"
#include "image/sequence.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#define MAGIC "reframe films 3\n"
#define ENDING ".films"

typedef struct Header
{
    char magic[sizeof MAGIC - 1];
    char fingerprint[RF_FINGERPRINT_SIZE + 7];
    int32_t count, first, last; // of the frames that are left
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
    if ( result == RF_OK )
        result = rf_append_films( writer, &header, sizeof header, error );
    return result == RF_OK ? rf_append_films( writer, left->frames, (size_t)left->count * sizeof( int ), error ) : result;
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
    return rf_end_atomic_file( &writer->file, result, error );
}

// Is it a file of this kind, with the bytes that were written? It is then at its begin.
static bool is_whole( FILE* file )
{
    unsigned char block[RF_FILMS_BLOCK];
    Trailer trailer;
    char magic[sizeof MAGIC - 1];
    uint64_t hash = 0, left;
    long size = fseek( file, 0, SEEK_END ) == 0 ? ftell( file ) : -1;
    if ( size < (long)( sizeof( Header ) + sizeof trailer ) || fseek( file, 0, SEEK_SET ) != 0 )
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
           fread( magic, sizeof magic, 1, file ) == 1 && memcmp( magic, MAGIC, sizeof magic ) == 0 &&
           fseek( file, 0, SEEK_SET ) == 0;
}

static bool has( const int* frames, int count, int frame )
{
    return count > 0 && bsearch( &frame, frames, (size_t)count, sizeof frame, rf_compare_frames ) != NULL;
}

// Are the frames of the films those that are left, and others that were finished since? Then these are left, too.
static bool take_back( const int* frames, int count, RfFramesLeft* left )
{
    int found = 0, kept = 0;
    for ( int i = 0; i < count; ++i )
    {
        bool is_left = has( left->frames, left->count, frames[i] );
        found += is_left;
        if ( !is_left && !has( left->kept, left->kept_count, frames[i] ) )
            return false;
    }
    if ( found != left->count )
        return false;
    for ( int i = 0; i < left->kept_count; ++i )
    {
        if ( !has( frames, count, left->kept[i] ) )
            left->kept[kept++] = left->kept[i];
    }
    memcpy( left->frames, frames, (size_t)count * sizeof( int ) );
    left->count = count;
    left->kept_count = kept;
    return true;
}

static RfFilmsState compare( FILE* file, const char* name, int first, RfFramesLeft* left, RfError* error )
{
    char fingerprint[RF_FINGERPRINT_SIZE];
    Header there;
    int* frames = NULL;
    RfFilmsState state = RF_FILMS_UNREADABLE;
    rf_frame_fingerprint( left->output, first, fingerprint );
    if ( fread( &there, sizeof there, 1, file ) == 1 && there.count > 0 )
        frames = malloc( (size_t)there.count * sizeof( int ) );
    if ( frames == NULL || fread( frames, (size_t)there.count * sizeof( int ), 1, file ) != 1 )
        rf_fail( error, RF_ERROR_IO, "%s: cannot be read", name );
    else if ( strncmp( there.fingerprint, fingerprint, sizeof there.fingerprint ) != 0 )
    {
        rf_fail( error, RF_ERROR_IO, "%s: are the films of another render: of another scene, path, version or settings", name );
        state = RF_FILMS_OTHER;
    }
    else if ( take_back( frames, there.count, left ) )
        state = RF_FILMS_SAME;
    else
    {
        Header here = header_of( left );
        rf_fail( error, RF_ERROR_IO, "%s: are films for frames %d to %d (%d), and frames %d to %d (%d) are left to be rendered",
                 name, (int)there.first, (int)there.last, (int)there.count, (int)here.first, (int)here.last, (int)here.count );
        state = RF_FILMS_OTHER_FRAMES;
    }
    free( frames );
    return state;
}

// Those that begin with frame `first`.
static RfFilmsState open_films( int first, RfFramesLeft* left, FILE** file, RfError* error )
{
    char name[RF_FILMS_NAME_SIZE];
    RfFilmsState state = RF_FILMS_UNREADABLE;
    if ( rf_films_file_name( left->output, first, name, error ) != RF_OK )
        return RF_FILMS_MISSING; // nor has the frame a name
    *file = fopen( name, "rb" );
    if ( *file == NULL && errno == ENOENT )
        return RF_FILMS_MISSING;
    if ( *file == NULL )
        rf_fail_io( name, "cannot be read", errno, error );
    else if ( !is_whole( *file ) )
        rf_fail( error, RF_ERROR_IO, "%s: not a complete films file", name );
    else
        state = compare( *file, name, first, left, error );
    if ( *file != NULL && state != RF_FILMS_SAME )
    {
        fclose( *file );
        *file = NULL;
    }
    return state;
}

RfFilmsState rf_open_films_file( RfFramesLeft* left, FILE** file, RfError* error )
{
    RfFilmsState state = open_films( left->frames[0], left, file, error );
    for ( int i = left->kept_count - 1; i >= 0 && state == RF_FILMS_MISSING; --i )
    {
        if ( left->kept[i] < left->frames[0] && open_films( left->kept[i], left, file, error ) == RF_FILMS_SAME )
            state = RF_FILMS_SAME;
    }
    return state;
}

void rf_remove_films_file( const RfOutput* output, int frame )
{
    char name[RF_FILMS_NAME_SIZE], magic[sizeof "reframe films" - 1]; // of other versions, too
    FILE* file = rf_films_file_name( output, frame, name, NULL ) == RF_OK ? fopen( name, "rb" ) : NULL;
    if ( file == NULL )
        return;
    bool ours = fread( magic, sizeof magic, 1, file ) == 1 && memcmp( magic, MAGIC, sizeof magic ) == 0;
    fclose( file );
    if ( ours )
        (void)unlink( name );
}

#define MOST_SHARE 0.01        // of the time that saving may take
#define BYTES_PER_SECOND 500e6 // of a disk, before the first save

static bool has_room( RfAutosave* autosave, const RfOutput* output, size_t bytes, RfError* error )
{
    char folder[RF_FILMS_NAME_SIZE], wanted[RF_BYTES_TEXT_SIZE], there[RF_BYTES_TEXT_SIZE];
    struct statvfs disk;
    if ( rf_folder_of_file( output->pattern, folder, sizeof folder, NULL ) != RF_OK || statvfs( folder, &disk ) != 0 )
        return true; // writing will tell
    double room = (double)disk.f_bavail * (double)disk.f_frsize;
    bytes *= autosave->spent > 0.0 ? 1 : 2; // the old file stays until the new one is whole
    if ( room >= (double)bytes )
        return true;
    rf_format_memory( bytes, wanted );
    rf_format_memory( (size_t)room, there );
    if ( !autosave->in_trouble )
        rf_fail( error, RF_ERROR_IO, "%s: has %s free, and the films of frames in work need %s: not saved until there is room",
                 folder, there, wanted );
    autosave->in_trouble = true;
    return false;
}

bool rf_is_save_due( RfAutosave* a, const RfOutput* output, size_t bytes, RfError* error )
{
    double now = rf_wall_seconds();
    bool first = a->began == 0.0;
    if ( first )
    {
        a->began = now;
        a->next = now + fmax( a->interval, (double)bytes / BYTES_PER_SECOND / MOST_SHARE );
    }
    if ( !first && now < a->next )
        return false;
    bool room = has_room( a, output, bytes, error );
    if ( !first && !room )
        a->next = now + a->interval;
    a->since = now;
    return !first && room;
}

double rf_note_saved( RfAutosave* a )
{
    double now = rf_wall_seconds(), last = now - a->since;
    a->spent += last;
    a->next = fmax( now + a->interval, a->began + ( a->spent + last ) / MOST_SHARE );
    double interval = a->next - now;
    if ( a->told > 0.0 && interval <= 2.0 * a->told )
        return 0.0;
    a->told = interval;
    return interval;
}
