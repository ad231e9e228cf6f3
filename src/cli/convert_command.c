// reframe convert: other formats as .glb.
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/options.h"
#include "reframe/convert.h"

#include <stdio.h>

#define COMMAND "convert"

enum
{
    IMPORTER_AUTO,
    IMPORTER_ASSIMP
};

static RfConvertOptions s_convert; // the table points here
static int s_importer, s_up;
static bool s_quiet;
static const char* s_json;
static const char* const s_importers[] = { "auto", "assimp", NULL };
static const char* const s_ups[] = { "file", "y", "z", NULL } /* as RfUpAxis */;
static const char* const s_files[] = { "IN", "OUT.glb" };

static const RfOption s_options[] = {
    RF_CHOICE_OPTION( "up", &s_up, s_ups, "up axis of IN; file: as FBX and Collada say, y for others; z is rotated to glTF's y" ),
    RF_REAL_OPTION( "scale", &s_convert.scale, 1e-9, 1e9, "S", "metres per unit of IN, in addition to the file's own unit" ),
    RF_CHOICE_OPTION( "importer", &s_importer, s_importers, "reader for IN; auto: Reframe's own for PLY, assimp for the rest" ),
    RF_MEMORY_OPTION( "memory", &s_convert.memory, 128 << 20, "SIZE", "address space limit for assimp" ),
    RF_TIME_OPTION( "timeout", &s_convert.seconds, 0.1, 86400, "SECONDS", "time limit for assimp" ),
    RF_FLAG_OPTION( "accept-losses", &s_convert.accept_losses,
                    "leave textures out that cannot be read, with a warning; else they are an error" ),
    RF_FLAG_OPTION( "overwrite", &s_convert.overwrite, "replace an existing OUT.glb" ),
    RF_TEXT_OPTION( "json", &s_json, "FILE", "write the result as JSON; - for standard output", .writes = ".json" ),
    RF_FLAG_OPTION( "quiet", &s_quiet, "no summary, no warnings" ),
};
static const RfCommandTable s_table = { .command = COMMAND,
                                        .summary = "Converts OBJ, PLY, FBX or Collada to .glb.",
                                        RF_TABLE_ROWS( s_files, s_options ),
                                        .writes_last = ".glb" };

static bool is_interrupted( void* user )
{
    (void)user;
    return rf_is_interrupted();
}

static void keep_loss( void* user, const char* line )
{
    RfLog log = rf_stderr_log( COMMAND );
    if ( !s_quiet )
        log.fn( log.user, line );
    json_array_append_new( user, rf_json_text( line ) );
}

static RfResult report_result( const char* from, const char* to, const RfModelCounts* c, json_t* losses, RfError* error )
{
    if ( !s_quiet && rf_prints_text( s_json ) )
        rf_print( "%s: %llu triangles in %d meshes, %d materials, %d images, %d cameras, %d lights, %d skins, %d morph targets, "
                  "%d animations\n",
                  to, c->triangles, c->meshes, c->materials, c->images, c->cameras, c->lights, c->skins, c->morphs,
                  c->animations );
    if ( s_json == NULL )
        return rf_flush_output( error );
    json_t* json = json_pack( "{s:o, s:o, s:I, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:O}", "source",
                              rf_json_text( from ), "output", rf_json_text( to ), "triangles", (json_int_t)c->triangles, "meshes",
                              c->meshes, "nodes", c->nodes, "materials", c->materials, "images", c->images, "cameras", c->cameras,
                              "lights", c->lights, "skins", c->skins, "morphs", c->morphs, "animations", c->animations,
                              "warnings", (int)json_array_size( losses ), "losses", losses );
    return rf_write_json( s_json, json, error );
}

static RfResult convert( void* user, RfError* error )
{
    const char *const *files = user, *from = files[0], *to = files[1];
    RfModelCounts counts;
    json_t* losses = json_array();
    RfLog log = { .fn = keep_loss, .user = losses };
    rf_catch_interrupts();
    s_convert.up = (RfUpAxis)s_up;
    s_convert.assimp = s_importer == IMPORTER_ASSIMP;
    s_convert.is_interrupted = is_interrupted;
    RfResult result = rf_convert_model( from, to, &s_convert, &counts, &log, error );
    if ( result == RF_OK )
        result = report_result( from, to, &counts, losses, error );
    json_decref( losses );
    return result;
}

int rf_command_convert( int argc, char** argv )
{
    const char* files[2];
    s_convert = rf_default_convert_options();
    return rf_run_command( &s_table, argc, argv, files, convert, files );
}
