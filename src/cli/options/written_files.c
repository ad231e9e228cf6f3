#include "cli/options/written_files.h"

#include "image/sequence.h"

#include <string.h>
#include <strings.h>
#include <sys/stat.h>

// Endings that belong to one kind of file: --json scene.glb is a mistake.
static const char* const s_kinds[] = { ".json", ".svg", ".png", ".html", ".exr", ".hdr", ".glb", ".gltf",
                                       ".bin",  ".obj", ".ply", ".fbx",  ".dae", ".jpg", ".jpeg" };

// A file named on the command line.
typedef struct Named
{
    const char* path;
    const char* option; // NULL: positional
    const char* writes; // the ending required where it is written, "" for any; NULL: it is read
} Named;

static bool is_file( const char* path )
{
    struct stat status;
    return path != NULL && strcmp( path, "-" ) != 0 && ( stat( path, &status ) != 0 || S_ISREG( status.st_mode ) );
}

static bool ends_with( const char* path, const char* ending )
{
    size_t length = strlen( path ), more = strlen( ending );
    return length > more && strcasecmp( path + length - more, ending ) == 0;
}

static RfResult check_kind( const Named* file, RfError* error )
{
    for ( size_t i = 0; i < sizeof s_kinds / sizeof s_kinds[0] && file->writes[0] != '\0'; ++i )
    {
        if ( ends_with( file->path, s_kinds[i] ) && strcmp( s_kinds[i], file->writes ) != 0 )
            return rf_fail( error, RF_ERROR_USAGE, "--%s: %s: ends as a file of another kind: name it %s", file->option,
                            file->path, file->writes );
    }
    return RF_OK;
}

static RfResult check_pair( const Named* file, const Named* other, RfError* error )
{
    if ( !rf_may_be_same_file( file->path, other->path ) )
        return RF_OK;
    const char* name = file->option != NULL ? file->option : other->option;
    if ( name == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "%s: is what is read: choose another name for what is written", file->path );
    if ( other->option == NULL || file->option == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: %s: would overwrite %s: choose another name", name, file->path,
                        other->writes != NULL ? "what else is written" : "what is read" );
    return rf_fail( error, RF_ERROR_USAGE, "--%s: %s: is the file of --%s too: choose another name", name, file->path,
                    other->option );
}

static int collect( const RfCommandTable* table, const char* const* files, int file_count, Named* named, int room )
{
    int count = 0;
    for ( int i = 0; i < file_count && count < room; ++i )
        named[count++] = ( Named ){ .path = files[i], .writes = table->writes_last && i == file_count - 1 ? "" : NULL };
    for ( int i = 0; i < table->option_count && count < room; ++i )
    {
        const RfOption* option = table->options + i;
        if ( !option->reads && option->writes == NULL )
            continue;
        named[count++] = ( Named ){ *(const char* const*)option->value, option->name, option->writes };
    }
    return count;
}

RfResult rf_check_written_files( const RfCommandTable* table, const char* const* files, int file_count, RfError* error )
{
    Named named[64];
    int count = collect( table, files, file_count, named, 64 );
    for ( int i = 0; i < count; ++i )
    {
        if ( named[i].writes == NULL || !is_file( named[i].path ) )
            continue;
        RfResult result = check_kind( named + i, error );
        for ( int k = 0; k < count && result == RF_OK; ++k )
        {
            if ( k != i && is_file( named[k].path ) )
                result = check_pair( named + i, named + k, error );
        }
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}
