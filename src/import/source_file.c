// The file that assimp reads: in memory, with what assimp would lose noted down, and an OBJ near its origin.
#include "import/assimp_import.h"

#include "base/file.h"
#include "base/try.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define SOURCE_LIMIT ( 1ull << 36 )

static RfSourceFormat format_of( const char* path )
{
    const char* dot = strrchr( path, '.' );
    if ( dot == NULL )
        return RF_SOURCE_OTHER;
    static const struct
    {
        const char* ending;
        RfSourceFormat format;
    } all[] = { { ".obj", RF_SOURCE_OBJ },
                { ".ply", RF_SOURCE_PLY },
                { ".dae", RF_SOURCE_COLLADA },
                { ".zae", RF_SOURCE_COLLADA },
                { ".fbx", RF_SOURCE_FBX } };
    for ( size_t i = 0; i < sizeof all / sizeof all[0]; ++i )
    {
        if ( strcasecmp( dot, all[i].ending ) == 0 )
            return all[i].format;
    }
    return RF_SOURCE_OTHER;
}

RfFact* rf_add_fact( RfSource* source, RfFactKind kind, const char* name, size_t length )
{
    int count = source->fact_count;
    if ( ( count & ( count - 1 ) ) == 0 ) // full at powers of two
    {
        RfFact* more = realloc( source->facts, ( count > 0 ? 2 * (size_t)count : 1 ) * sizeof *more );
        source->failed |= more == NULL;
        if ( more == NULL )
            return NULL;
        source->facts = more;
    }
    char* copy = strndup( name, length );
    source->failed |= copy == NULL;
    if ( copy == NULL )
        return NULL;
    source->facts[count] = ( RfFact ){ .kind = kind, .name = copy };
    source->fact_count += 1;
    return source->facts + count;
}

const RfFact* rf_find_fact( const RfSource* source, RfFactKind kind, const char* name, int slot )
{
    for ( int i = 0; i < source->fact_count; ++i )
    {
        const RfFact* fact = source->facts + i;
        if ( fact->kind == kind && fact->slot == slot && strcmp( fact->name, name ) == 0 )
            return fact;
    }
    return NULL;
}

const char* rf_name_in_file( const RfSource* source, const char* name )
{
    const RfFact* fact = rf_find_fact( source, RF_FACT_NAME, name, 0 );
    return fact != NULL ? fact->text : name;
}

static char* next_line( char* line )
{
    char* end = strchr( line, '\n' );
    return end != NULL ? end + 1 : NULL;
}

// The three numbers of a line "v x y z"; returns where they end, or NULL for another line.
static char* read_vertex( char* line, double out[3] )
{
    const char* next = next_line( line );
    while ( *line == ' ' || *line == '\t' )
        ++line;
    if ( line[0] != 'v' || ( line[1] != ' ' && line[1] != '\t' ) )
        return NULL;
    char* at = line + 1;
    for ( int i = 0; i < 3; ++i )
    {
        char* end;
        out[i] = strtod( at, &end );
        if ( end == at || !isfinite( out[i] ) || ( next != NULL && end >= next ) )
            return NULL;
        at = end;
    }
    return at;
}

// Writes the lines anew, the positions less the origin. `out` has room for all.
static size_t write_near( char* text, const double origin[3], char* out )
{
    size_t size = 0;
    for ( char* line = text; line != NULL; )
    {
        double p[3];
        char *rest = read_vertex( line, p ), *next = next_line( line );
        if ( rest != NULL )
            size += (size_t)sprintf( out + size, "v %.9g %.9g %.9g", p[0] - origin[0], p[1] - origin[1], p[2] - origin[2] );
        else
            rest = line;
        size_t length = next != NULL ? (size_t)( next - rest ) : strlen( rest );
        memcpy( out + size, rest, length );
        size += length;
        line = next;
    }
    out[size] = 0;
    return size;
}

bool rf_is_far( const double low[3], const double high[3], double origin[3] )
{
    double far = 0.0, size = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        origin[i] = round( 0.5 * ( low[i] + high[i] ) );
        far = fmax( far, fabs( 0.5 * ( low[i] + high[i] ) ) );
        size = fmax( size, high[i] - low[i] );
    }
    return far > 16.0 * size && far <= 1e15 && far >= 16.0;
}

// assimp has positions as floats, which are 0.03 m apart at 500 km. Where all are far from the origin, the middle of their
// box is taken off, in whole units.
static void bring_near( RfSource* source )
{
    double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY };
    size_t count = 0;
    for ( char* line = source->text; line != NULL; line = next_line( line ) )
    {
        double p[3];
        if ( read_vertex( line, p ) == NULL )
            continue;
        ++count;
        for ( int i = 0; i < 3; ++i )
        {
            low[i] = fmin( low[i], p[i] );
            high[i] = fmax( high[i], p[i] );
        }
    }
    double origin[3];
    if ( count == 0 || !rf_is_far( low, high, origin ) || strlen( source->text ) != source->size )
        return;
    char* out = malloc( source->size + 48 * count + 1 );
    source->failed |= out == NULL;
    if ( out == NULL )
        return;
    memcpy( source->origin, origin, sizeof origin );
    source->size = write_near( source->text, source->origin, out );
    free( source->text );
    source->text = out;
}

RfResult rf_open_source( const char* path, RfSource* source, RfLog* log, RfError* error )
{
    *source = ( RfSource ){ .path = path, .format = format_of( path ), .unit = 1.0, .log = log };
    uint8_t* bytes;
    RF_TRY( rf_read_file( path, SOURCE_LIMIT, &bytes, &source->size, error ) );
    source->text = realloc( bytes, source->size + 1 );
    if ( source->text == NULL )
    {
        free( bytes );
        return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
    }
    source->text[source->size] = 0;
    if ( source->format == RF_SOURCE_OBJ )
        bring_near( source );
    else if ( source->format == RF_SOURCE_FBX )
        rf_note_fbx( source );
    else if ( source->format == RF_SOURCE_COLLADA )
        rf_note_collada( source );
    return source->failed ? rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY ) : RF_OK;
}

void rf_close_source( RfSource* source )
{
    for ( int i = 0; i < source->fact_count; ++i )
    {
        free( source->facts[i].name );
        free( source->facts[i].text );
    }
    free( source->facts );
    free( source->text );
    *source = ( RfSource ){ 0 };
}

// Files for assimp: `text` of the source, or one on the disk.
typedef struct OpenFile
{
    struct aiFile file; // first, so that it can be cast
    const RfSource* source;
    size_t at;
    FILE* disk; // NULL: the source
} OpenFile;

static size_t read_bytes( struct aiFile* file, char* out, size_t size, size_t count )
{
    OpenFile* f = (OpenFile*)file;
    if ( f->disk != NULL )
        return fread( out, size, count, f->disk );
    size_t left = f->source->size - f->at;
    count = size > 0 && count > left / size ? left / size : count;
    memcpy( out, f->source->text + f->at, size * count );
    f->at += size * count;
    return count;
}

static size_t write_bytes( struct aiFile* file, const char* bytes, size_t size, size_t count )
{
    (void)file, (void)bytes, (void)size, (void)count;
    return 0;
}

static size_t tell( struct aiFile* file )
{
    OpenFile* f = (OpenFile*)file;
    return f->disk != NULL ? (size_t)ftell( f->disk ) : f->at;
}

static enum aiReturn seek( struct aiFile* file, size_t offset, enum aiOrigin origin )
{
    OpenFile* f = (OpenFile*)file;
    static const int from[] = { [aiOrigin_SET] = SEEK_SET, [aiOrigin_CUR] = SEEK_CUR, [aiOrigin_END] = SEEK_END };
    if ( origin > aiOrigin_END )
        return aiReturn_FAILURE;
    if ( f->disk != NULL )
        return fseek( f->disk, (long)offset, from[origin] ) == 0 ? aiReturn_SUCCESS : aiReturn_FAILURE;
    size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? f->at : f->source->size;
    size_t target = base + offset; // a negative offset wraps around, as it should
    if ( target > f->source->size )
        return aiReturn_FAILURE;
    f->at = target;
    return aiReturn_SUCCESS;
}

static size_t size_of( struct aiFile* file )
{
    OpenFile* f = (OpenFile*)file;
    if ( f->disk == NULL )
        return f->source->size;
    long at = ftell( f->disk );
    fseek( f->disk, 0, SEEK_END );
    long size = ftell( f->disk );
    fseek( f->disk, at, SEEK_SET );
    return size > 0 ? (size_t)size : 0;
}

static void flush( struct aiFile* file ) { (void)file; }

static void note_library( RfSource* source, const char* path )
{
    const char* dot = strrchr( path, '.' );
    uint8_t* bytes;
    size_t size;
    if ( dot == NULL || strcasecmp( dot, ".mtl" ) != 0 || rf_read_file( path, SOURCE_LIMIT, &bytes, &size, NULL ) != RF_OK )
        return;
    char* text = strndup( (const char*)bytes, size );
    if ( text != NULL )
        rf_note_mtl( source, text );
    free( text );
    free( bytes );
}

static struct aiFile* open_file( struct aiFileIO* io, const char* path, const char* mode )
{
    RfSource* source = (RfSource*)io->UserData;
    bool own = strcmp( path, source->path ) == 0;
    FILE* disk = own || strchr( mode, 'r' ) == NULL ? NULL : fopen( path, "rb" );
    OpenFile* f = own || disk != NULL ? malloc( sizeof *f ) : NULL;
    if ( f == NULL )
    {
        if ( disk != NULL )
            fclose( disk );
        return NULL;
    }
    *f = ( OpenFile ){ .file = { .ReadProc = read_bytes,
                                 .WriteProc = write_bytes,
                                 .TellProc = tell,
                                 .FileSizeProc = size_of,
                                 .SeekProc = seek,
                                 .FlushProc = flush },
                       .source = source,
                       .disk = disk };
    if ( disk != NULL && source->format == RF_SOURCE_OBJ )
        note_library( source, path );
    return &f->file;
}

static void close_file( struct aiFileIO* io, struct aiFile* file )
{
    (void)io;
    OpenFile* f = (OpenFile*)file;
    if ( f->disk != NULL )
        fclose( f->disk );
    free( f );
}

// FBX pivots stay nodes of their own: assimp has animations of them only so.
const struct aiScene* rf_read_source( RfSource* source, unsigned steps )
{
    struct aiPropertyStore* store = aiCreatePropertyStore();
    if ( store == NULL )
        return NULL;
    aiSetImportPropertyInteger( store, AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, 1 );
    struct aiFileIO io = { .OpenProc = open_file, .CloseProc = close_file, .UserData = (char*)source };
    const struct aiScene* scene = aiImportFileExWithProperties( source->path, steps, &io, store );
    aiReleasePropertyStore( store );
    return scene;
}
