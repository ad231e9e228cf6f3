// reframe convert: other formats as .glb.
#include "cli/commands.h"
#include "cli/render/interrupt.h"
#include "cli/options/options.h"
#include "cli/messages.h"
#include "convert/glb_write.h"
#include "convert/ply_read.h"
#include "convert/run_importer.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#define COMMAND "convert"

enum
{
    IMPORTER_AUTO,
    IMPORTER_ASSIMP
};
enum
{
    UP_Y,
    UP_Z
};

static size_t s_memory;
static double s_timeout, s_scale;
static int s_importer, s_up;
static bool s_overwrite, s_quiet;
static const char* s_json;
static const char* const s_importers[] = { "auto", "assimp", NULL };
static const char* const s_ups[] = { "y", "z", NULL };
static const char* const s_files[] = { "IN", "OUT.glb" };

static const RfOption s_options[] = {
    { .name = "up",
      .type = RF_OPTION_CHOICE,
      .value = &s_up,
      .choices = s_ups,
      .default_text = "y",
      .help = "the axis of IN that points up; z is turned to glTF's y" },
    { .name = "scale",
      .type = RF_OPTION_REAL,
      .value = &s_scale,
      .min = 1e-9,
      .max = 1e9,
      .meta = "S",
      .default_text = "1",
      .help = "metres per unit of IN, after what its own units say" },
    { .name = "importer",
      .type = RF_OPTION_CHOICE,
      .value = &s_importer,
      .choices = s_importers,
      .default_text = "auto",
      .help = "what reads IN; auto: PLY by a strict reader of ours, all else by assimp" },
    { .name = "memory",
      .type = RF_OPTION_MEMORY,
      .value = &s_memory,
      .min = 128 << 20,
      .meta = "SIZE",
      .default_text = "4G",
      .help = "address space assimp may take before it is stopped" },
    { .name = "timeout",
      .type = RF_OPTION_REAL,
      .value = &s_timeout,
      .min = 0.1,
      .max = 86400,
      .meta = "SECONDS",
      .default_text = "120",
      .help = "time assimp may take before it is stopped" },
    { .name = "overwrite",
      .type = RF_OPTION_BOOL,
      .value = &s_overwrite,
      .default_text = "off",
      .help = "replace OUT.glb where it is there" },
    { .name = "json",
      .writes = ".json",
      .type = RF_OPTION_STRING,
      .value = &s_json,
      .meta = "FILE",
      .help = "what was converted as JSON in FILE, or - for standard output" },
    { .name = "quiet",
      .type = RF_OPTION_BOOL,
      .value = &s_quiet,
      .default_text = "off",
      .help = "no line about what was converted, no warnings" },
};
static const RfCommandTable s_table = { .command = COMMAND,
                                        .summary = "Writes OBJ, PLY, FBX or Collada as .glb.",
                                        .files = s_files,
                                        .file_count = 2,
                                        .writes_last = true,
                                        .options = s_options,
                                        .option_count = (int)( sizeof s_options / sizeof s_options[0] ) };

static bool ends_with( const char* name, const char* ending )
{
    size_t length = strlen( name ), end = strlen( ending );
    return length > end && strcasecmp( name + length - end, ending ) == 0;
}

// The first bytes; what cannot be read is an error of the system's words.
static RfResult read_head( const char* path, char head[4], RfError* error )
{
    struct stat status;
    memset( head, 0, 4 );
    if ( stat( path, &status ) == 0 && !S_ISREG( status.st_mode ) )
        return rf_fail( error, RF_ERROR_IO, "%s: is no regular file: name a file", path );
    FILE* file = fopen( path, "rb" );
    if ( file == NULL )
        return rf_fail_io( path, "cannot be read", errno, error );
    size_t count = fread( head, 1, 4, file );
    fclose( file );
    return count > 0 ? RF_OK : rf_fail( error, RF_ERROR_FORMAT, "%s: is empty: write it anew", path );
}

static RfResult check_files( const char* from, const char* to, char head[4], RfError* error )
{
    if ( !ends_with( to, ".glb" ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: only .glb is written: name it .glb", to );
    RfResult result = read_head( from, head, error );
    if ( result != RF_OK )
        return result;
    if ( ends_with( from, ".glb" ) || ends_with( from, ".gltf" ) || memcmp( head, "glTF", 4 ) == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: is glTF already and needs no conversion: give it to reframe render", from );
    struct stat status;
    if ( !s_overwrite && lstat( to, &status ) == 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: is there already: give another name or --overwrite", to );
    return RF_OK;
}

static RfResult convert_by_assimp( const char* from, const char* to, RfModelCounts* counts, RfLog* log, RfError* error )
{
    char program[8192];
    RfResult result = rf_find_importer( program, sizeof program, error );
    RfImporterRun run = { .program = program,
                          .source = from,
                          .target = to,
                          .memory = s_memory,
                          .seconds = s_timeout,
                          .z_up = s_up == UP_Z,
                          .scale = s_scale,
                          .is_interrupted = rf_is_interrupted };
    return result == RF_OK ? rf_run_importer( &run, counts, log, error ) : result;
}

static RfResult convert_ply( const char* from, const char* to, RfModelCounts* counts, RfLog* log, RfError* error )
{
    RfModel model;
    RfResult result = rf_read_ply( from, &model, log, error );
    if ( result == RF_OK )
        result = rf_apply_root_transform( &model, s_up == UP_Z, s_scale, error );
    if ( result == RF_OK )
        result = rf_write_glb( to, &model, s_overwrite, error );
    if ( result == RF_OK )
        *counts = rf_count_model( &model );
    rf_destroy_model( &model );
    return result;
}

static RfResult tell( const char* from, const char* to, const RfModelCounts* c, int warnings, RfError* error )
{
    bool json_out = s_json != NULL && strcmp( s_json, "-" ) == 0;
    if ( !s_quiet && !json_out )
        printf( "%s: %llu triangles in %d meshes, %d materials, %d images, %d cameras, %d lights\n", to, c->triangles, c->meshes,
                c->materials, c->images, c->cameras, c->lights );
    if ( s_json == NULL )
        return rf_flush_output( error );
    json_t* json =
        json_pack( "{s:o, s:o, s:I, s:i, s:i, s:i, s:i, s:i, s:i, s:i}", "source", rf_json_text( from ), "output",
                   rf_json_text( to ), "triangles", (json_int_t)c->triangles, "meshes", c->meshes, "nodes", c->nodes, "materials",
                   c->materials, "images", c->images, "cameras", c->cameras, "lights", c->lights, "warnings", warnings );
    return rf_write_json( s_json, json, error );
}

static RfResult convert( const char* from, const char* to, RfError* error )
{
    char head[4];
    RfModelCounts counts;
    RfLog log = rf_stderr_log( COMMAND );
    if ( s_quiet )
        log.fn = NULL;
    RfResult result = check_files( from, to, head, error );
    if ( result != RF_OK )
        return result;
    rf_catch_interrupts();
    if ( s_importer == IMPORTER_AUTO && memcmp( head, "ply", 3 ) == 0 &&
         ( head[3] == '\n' || head[3] == '\r' || head[3] == ' ' ) )
        result = convert_ply( from, to, &counts, &log, error );
    else
        result = convert_by_assimp( from, to, &counts, &log, error );
    return result == RF_OK ? tell( from, to, &counts, log.count, error ) : result;
}

int rf_command_convert( int argc, char** argv )
{
    const char* files[2];
    bool help;
    RfError error;
    s_memory = (size_t)4 << 30;
    s_timeout = 120;
    s_scale = 1;
    RfResult result = rf_parse_options( &s_table, argc, argv, files, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &s_table, stdout );
        result = rf_flush_output( &error );
    }
    else if ( result == RF_OK )
        result = convert( files[0], files[1], &error );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
