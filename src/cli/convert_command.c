// reframe convert: other formats as .glb.
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/options.h"
#include "cli/signals.h"
#include "reframe/convert.h"

#include <stdio.h>
#include <string.h>

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

static RfConvertOptions s_convert; // the table points here
static int s_importer, s_up;
static bool s_quiet;
static const char* s_json;
static const char* const s_importers[] = { "auto", "assimp", NULL };
static const char* const s_ups[] = { "y", "z", NULL };
static const char* const s_files[] = { "IN", "OUT.glb" };

static const RfOption s_options[] = {
    { .name = "up",
      .type = RF_OPTION_CHOICE,
      .value = &s_up,
      .choices = s_ups,
      .help = "up axis of IN; z is rotated to glTF's y" },
    { .name = "scale",
      .type = RF_OPTION_REAL,
      .value = &s_convert.scale,
      .min = 1e-9,
      .max = 1e9,
      .meta = "S",
      .help = "metres per unit of IN, in addition to the file's own unit" },
    { .name = "importer",
      .type = RF_OPTION_CHOICE,
      .value = &s_importer,
      .choices = s_importers,
      .help = "reader for IN; auto: Reframe's own for PLY, assimp for the rest" },
    { .name = "memory",
      .type = RF_OPTION_MEMORY,
      .value = &s_convert.memory,
      .min = 128 << 20,
      .meta = "SIZE",
      .help = "address space limit for assimp" },
    { .name = "timeout",
      .type = RF_OPTION_TIME,
      .value = &s_convert.seconds,
      .min = 0.1,
      .max = 86400,
      .meta = "SECONDS",
      .help = "time limit for assimp" },
    { .name = "overwrite", .type = RF_OPTION_BOOL, .value = &s_convert.overwrite, .help = "replace an existing OUT.glb" },
    { .name = "json",
      .writes = ".json",
      .type = RF_OPTION_STRING,
      .value = &s_json,
      .meta = "FILE",
      .help = "write the result as JSON; - for standard output" },
    { .name = "quiet", .type = RF_OPTION_BOOL, .value = &s_quiet, .help = "no summary, no warnings" },
};
static const RfCommandTable s_table = { .command = COMMAND,
                                        .summary = "Converts OBJ, PLY, FBX or Collada to .glb.",
                                        .files = s_files,
                                        .file_count = 2,
                                        .writes_last = ".glb",
                                        .options = s_options,
                                        .option_count = (int)( sizeof s_options / sizeof s_options[0] ) };

static bool is_interrupted( void* user )
{
    (void)user;
    return rf_is_interrupted();
}

static RfResult report_result( const char* from, const char* to, const RfModelCounts* c, int warnings, RfError* error )
{
    if ( !s_quiet && rf_prints_text( s_json ) )
        rf_print( "%s: %llu triangles in %d meshes, %d materials, %d images, %d cameras, %d lights\n", to, c->triangles,
                  c->meshes, c->materials, c->images, c->cameras, c->lights );
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
    RfModelCounts counts;
    RfLog log = rf_stderr_log( COMMAND );
    if ( s_quiet )
        log.fn = NULL;
    rf_catch_interrupts();
    s_convert.z_up = s_up == UP_Z;
    s_convert.assimp = s_importer == IMPORTER_ASSIMP;
    s_convert.is_interrupted = is_interrupted;
    RfResult result = rf_convert_model( from, to, &s_convert, &counts, &log, error );
    return result == RF_OK ? report_result( from, to, &counts, log.count, error ) : result;
}

int rf_command_convert( int argc, char** argv )
{
    const char* files[2];
    bool help;
    RfError error;
    s_convert = rf_default_convert_options();
    RfResult result = rf_parse_options( &s_table, argc, argv, files, &help, &error );
    if ( result == RF_OK && help )
        result = rf_show_help( &s_table, &error );
    else if ( result == RF_OK )
        result = convert( files[0], files[1], &error );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
