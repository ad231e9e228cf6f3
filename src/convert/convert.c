// From a file of another format to a .glb (reframe/convert.h).
#include "base/file.h"
#include "base/remedy.h"
#include "base/words.h"
#include "convert/glb_write.h"
#include "convert/ply_read.h"
#include "convert/run_importer.h"
#include "image/atomic_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

RfConvertOptions rf_default_convert_options( void )
{
    return ( RfConvertOptions ){ .scale = 1.0, .memory = (size_t)4 << 30, .seconds = 120.0 };
}

#define HEAD_BYTES 8

// The first bytes; what cannot be read is an error of the system's words.
static RfResult read_head( const char* path, char head[HEAD_BYTES], RfError* error )
{
    struct stat status;
    memset( head, 0, HEAD_BYTES );
    if ( stat( path, &status ) == 0 && !S_ISREG( status.st_mode ) )
        return rf_fail( error, RF_ERROR_IO, "%s: not a regular file", path );
    FILE* file = fopen( path, "rb" );
    if ( file == NULL )
        return rf_fail_io( path, "cannot be read", errno, error );
    size_t count = fread( head, 1, HEAD_BYTES, file );
    fclose( file );
    return count > 0 ? RF_OK : rf_fail( error, RF_ERROR_FORMAT, "%s: is empty: write it anew", path );
}

static RfResult check_files( const char* from, const char* to, bool overwrite, char head[HEAD_BYTES], RfError* error )
{
    if ( !rf_has_extension( to, ".glb" ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: only .glb is written: name it .glb", to );
    RfResult result = read_head( from, head, error );
    if ( result != RF_OK )
        return result;
    result = rf_refuse_blend_file( from, head, HEAD_BYTES, error );
    if ( result != RF_OK )
        return result;
    if ( rf_has_extension( from, ".glb" ) || rf_has_extension( from, ".gltf" ) || memcmp( head, "glTF", 4 ) == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: is glTF already and needs no conversion: render it as it is", from );
    struct stat status;
    if ( !overwrite && lstat( to, &status ) == 0 )
        return rf_advise( rf_fail( error, RF_ERROR_IO, "%s: already exists", to ), RF_REMEDY_OVERWRITE, 0, error );
    return rf_try_output_file( to, error );
}

static RfResult convert_by_assimp( const char* from, const char* to, const RfConvertOptions* options, RfModelCounts* counts,
                                   RfLog* log, RfError* error )
{
    char program[8192];
    RfResult result = options->importer == NULL ? rf_find_importer( program, sizeof program, error ) : RF_OK;
    RfImporterRun run = { .program = options->importer != NULL ? options->importer : program,
                          .source = from,
                          .target = to,
                          .memory = options->memory,
                          .seconds = options->seconds,
                          .z_up = options->z_up,
                          .scale = options->scale,
                          .is_interrupted = options->is_interrupted,
                          .user = options->user };
    return result == RF_OK ? rf_run_importer( &run, counts, log, error ) : result;
}

static RfResult convert_ply( const char* from, const char* to, const RfConvertOptions* options, RfModelCounts* counts, RfLog* log,
                             RfError* error )
{
    RfModel model;
    RfResult result = rf_read_ply( from, &model, log, error );
    if ( result == RF_OK )
        result = rf_apply_root_transform( &model, options->z_up, options->scale, error );
    if ( result == RF_OK )
        result = rf_write_glb( to, &model, options->overwrite, error );
    if ( result == RF_OK )
        *counts = rf_count_model( &model );
    rf_destroy_model( &model );
    return result;
}

RfResult rf_convert_model( const char* source, const char* target, const RfConvertOptions* options, RfModelCounts* counts,
                           RfLog* log, RfError* error )
{
    char head[HEAD_BYTES];
    RfModelCounts found = { 0 };
    RfResult result = check_files( source, target, options->overwrite, head, error );
    if ( result != RF_OK )
        return result;
    bool is_ply = memcmp( head, "ply", 3 ) == 0 && ( head[3] == '\n' || head[3] == '\r' || head[3] == ' ' );
    result = is_ply && !options->assimp ? convert_ply( source, target, options, &found, log, error )
                                        : convert_by_assimp( source, target, options, &found, log, error );
    if ( counts != NULL )
        *counts = found;
    return result;
}
