// The program with scene files and camera-path files: defaults, errors, schemas, examples.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "cli/options/render_options.h"
#include "image/exr.h"

#include <dirent.h>
#include <jansson.h>

#define PATH "{\"kind\":\"dolly\",\"from\":[0,0,5],\"to\":[0,0,3],\"target\":[0,0,0],\"frames\":7}"

static void write_render( const char* render )
{
    char text[1024];
    snprintf( text, sizeof text, "{\"scene\":\"room.gltf\",\"camera\":" PATH ",\"render\":%s}", render );
    write_text( "scene.json", text );
}

TEST( test_render_defaults )
{
    write_render(
        "{\"size\":[20,10],\"spp\":3,\"group\":0,\"seed\":9,\"fps\":\"24000/1001\",\"weights\":\"exact\","
        "\"normalize\":\"ratio\",\"max_depth\":4,\"light_samples\":2,\"frames\":\"2-3\",\"tile\":\"1\",\"aov\":\"albedo\"}" );
    cli_expect( cli_run( "$R render scene.json -o a.####.exr --quiet" ), 0, NULL );
    assert_true( !cli_exists( "a.0001.exr" ) && cli_exists( "a.0003.exr" ) );
    cli_expect_size( "a.0002.exr", 20, 10 );
    static const char* const wanted[][2] = { { "reframe/spp", "3" },       { "reframe/group", "0" },
                                             { "reframe/seed", "9" },      { "reframe/normalize", "ratio" },
                                             { "reframe/max-depth", "4" }, { "reframe/light-samples", "2" },
                                             { "reframe/camera", "path" } };
    cli_expect_exr_texts( "a.0002.exr", wanted, sizeof wanted / sizeof wanted[0] );
    // the command line wins
    cli_expect( cli_run( "$R render scene.json -o b.exr --quiet --size 8x6 --seed 4 --frames 1 --camera Side" ), 0, NULL );
    cli_expect_size( "b.exr", 8, 6 );
    cli_expect_exr_text( "b.exr", "reframe/seed", "4" );
    cli_expect_exr_text( "b.exr", "reframe/camera", "Side" );
}

TEST( test_render_faults )
{
    static const char* const faults[][2] = {
        { "3", "scene.json: render: must be an object, got 3" },
        { "{\"spp\":0}", "scene.json: render.spp: must be a whole number from 1 to 1048576, got 0" },
        { "{\"spp\":2.5}", "scene.json: render.spp: must be a whole number from 1 to 1048576, got 2.5" },
        { "{\"spp\":\"many\"}", "scene.json: render.spp: must be a whole number from 1 to 1048576, got \"many\"" },
        { "{\"group\":\"off\"}", "scene.json: render.group: must be a whole number from 0 to 1048576 or \"auto\", got \"off\"" },
        { "{\"size\":\"960x540\"}", "scene.json: render.size: must be an array of width and height, such as [960, 540], each a "
                                    "whole number from 1 to 32768, got \"960x540\"" },
        { "{\"size\":[0,5]}", "each a whole number from 1 to 32768, got [0, 5]" },
        { "{\"size\":[20,1e9]}",
          "render.size: must be an array of width and height, such as [960, 540], each a whole number from "
          "1 to 32768, got [20, 1000000000]" },
        { "{\"size\":[20.5,10]}", "got [20.5, 10]" },
        { "{\"size\":[20,10,5]}", "from 1 to 32768, got an array of 3" },
        { "{\"fps\":0}", "scene.json: render.fps: must be a whole number from 1 to 1000000, 29.97 and the like, or a string such "
                         "as \"24000/1001\", got 0" },
        { "{\"fps\":\"24/0\"}", "such as \"24000/1001\", got \"24/0\"" },
        { "{\"adaptive\":\"yes\"}", "scene.json: render.adaptive: must be true, false, or one of auto, on, off, got \"yes\"" },
        { "{\"adaptive\":1}", "scene.json: render.adaptive: must be true, false, or one of auto, on, off, got 1" },
        { "{\"weights\":\"best\"}", "scene.json: render.weights: must be one of exact, eq15, unweighted, got \"best\"" },
        { "{\"frames\":\"\"}", "scene.json: render.frames: must be a string that is not empty, got \"\"" },
        { "{\"max-depth\":3}", "scene.json: render.max-depth: unknown key, did you mean max_depth?" },
        { "{\"output\":\"a.exr\"}", "scene.json: render.output: unknown key, the keys here are: frames, fps" },
        { "{\"threads\":3}", "scene.json: render.threads: unknown key" },
        { "{\"seed\":-1}", "scene.json: render.seed: must be a whole number from 0" },
        { "{\"noise\":\"0.01\"}", "scene.json: render.noise: must be a relMSE from 0 to 1e+06, or the noise of a channel" },
        { "{\"tile\":\"9x9\"}", "scene.json: render.tile: expected auto, 1, WxH such as 3x3, or rooksN" },
        { "{\"aov\":\"depht\"}", "scene.json: render.aov: unknown AOV 'depht', did you mean depth?" },
        { "{\"aov\":\"depth,depth\"}", "scene.json: render.aov: AOV depth is given twice" },
        { "{\"cryptomatte\":\"objekt\"}", "scene.json: render.cryptomatte: unknown Cryptomatte 'objekt', did you mean object?" },
        { "{\"cryptomatte\":\"asset,asset\"}", "scene.json: render.cryptomatte: Cryptomatte of kind asset is given twice" },
        { "{\"cryptomatte\":true}", "scene.json: render.cryptomatte: must be a string that is not empty, got true" },
        { "{\"light_groups\":\"kye\"}", "scene.json: render.light_groups: no light group or light is called 'kye': there are" },
        { "{\"light_groups\":\"all\"}", "scene.json: render.light_groups: has no light groups" },
        { "{\"light_groups\":\"\"}", "scene.json: render.light_groups: must be a string that is not empty, got \"\"" },
    };
    static const char* const frames[][2] = {
        { "\"9\"", "scene.json: render.frames: there is no frame 9, the camera's path has 7 frames" },
        { "\"3-2\"", "scene.json: render.frames: 3-2 runs backwards" },
        { "\"one\"", "scene.json: render.frames: expected frames such as 7" },
    };
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
    {
        write_render( faults[i][0] );
        cli_expect( cli_run( "$R render scene.json -o x.####.exr --quiet" ), 1, faults[i][1] );
        cli_expect( cli_run( "$R info scene.json" ), 1, faults[i][1] );
    }
    for ( size_t i = 0; i < sizeof frames / sizeof frames[0]; ++i )
    {
        char render[64];
        snprintf( render, sizeof render, "{\"frames\":%s}", frames[i][0] );
        write_render( render );
        cli_expect( cli_run( "$R render scene.json -o x.####.exr --quiet" ), 1, frames[i][1] );
    }
    // what the command line says in its place is not the file's fault, and makes its own good
    cli_expect( cli_run( "$R render scene.json -o x.####.exr --quiet --frames 9" ), 2,
                "reframe render: --frames: there is no frame 9" );
    assert_false( cli_exists( "x.0001.exr" ) );
}

// Broken copies of defaults, in this process.
TEST( test_mutated_defaults )
{
    static const char text[] = "{\"scene\":\"a.glb\",\"render\":{\"size\":[20,10],\"spp\":3,\"group\":\"auto\",\"seed\":9,"
                               "\"fps\":\"24000/1001\",\"weights\":\"exact\",\"max_depth\":4,\"frames\":\"2-3\"}}";
    int read = 0;
    for ( uint64_t i = 0; i < 2000; ++i )
    {
        char bytes[sizeof text];
        memcpy( bytes, text, sizeof text );
        cli_write( "scene.json", bytes, mutate_bytes( (uint8_t*)bytes, sizeof text - 1, 5 * ( i + 1 ) ) );
        RfSceneFile file;
        RfRenderOptions options;
        RfError error = { 0 };
        RfResult result = rf_open_scene_file( cli_path( "scene.json" ), &file, &error );
        if ( result == RF_OK )
        {
            RfField defaults = rf_scene_file_defaults( &file, &error );
            result = rf_read_render_defaults( &defaults, &options );
        }
        assert_true( result == RF_OK ? options.settings.spp >= 1 && options.size.width >= 1 : error.text[0] != 0 );
        read += result == RF_OK;
        rf_close_scene_file( &file );
    }
    assert_true( read > 0 );
}

TEST( test_info_reads_scene_files )
{
    write_text( "scene.json", "{\"scene\":\"room.gltf\",\"camera\":{\"kind\":\"orbit\",\"center\":[0,0,-2],\"radius\":3,"
                              "\"duration\":2},\"render\":{\"fps\":30}}" );
    const CliResult* result = cli_run( "$R info scene.json" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "path: 61 frames at 30 frames/s, animated" ) );
    assert_non_null( strstr( result->out, "camera path 'path'" ) );
    result = cli_run( "$R info scene.json --fps 10" );
    assert_non_null( strstr( result->out, "path: 21 frames at 10 frames/s" ) );
}

TEST( test_camera_option_takes_a_path_file )
{
    write_text( "move.json", PATH );
    cli_expect( cli_run( "$R render room.gltf -o c.####.exr --camera move.json --size 8x6 --spp 1 --group 0 --quiet" ), 0, NULL );
    assert_true( cli_exists( "c.0007.exr" ) && !cli_exists( "c.0008.exr" ) );
    cli_expect( cli_run( "$R render room.gltf -o c.####.exr --camera none.json" ), 1, "none.json: cannot be opened" );
    write_text( "broken.json", "{\"kind\":\"orbit\"" );
    cli_expect( cli_run( "$R render room.gltf -o c.####.exr --camera broken.json" ), 1, "broken.json: line 1, column " );
    // --resume knows a changed path, also one whose frames are the same
    cli_expect( cli_run( "$R render room.gltf -o c.####.exr --camera move.json --size 8x6 --spp 1 --group 0 --quiet --resume" ),
                0, NULL );
    write_text( "move.json", PATH " " );
    cli_expect( cli_run( "$R render room.gltf -o c.####.exr --camera move.json --size 8x6 --spp 1 --group 0 --quiet --resume" ),
                1, "but from another scene or camera path" );
    write_text( "blind.json", "{\"kind\":\"dolly\",\"from\":[0,9,0],\"to\":[1,9,0],\"target\":[0,0,0],\"frames\":2}" );
    cli_expect( cli_run( "$R render room.gltf -o d.####.exr --camera blind.json" ), 1, "looks along its up" );
}

// Of more frames than there may be: the file's fault, told with its place in it.
TEST( test_too_many_frames_is_the_files_fault )
{
#define DOLLY "\"kind\":\"dolly\",\"from\":[0,0,5],\"to\":[0,0,3],\"target\":[0,0,0],\"duration\":1e6"
    write_text( "long.json", "{" DOLLY "}" );
    cli_expect( cli_run( "$R render room.gltf -o e.####.exr --camera long.json" ), 1,
                "reframe render: long.json: duration: 1e+06 s at 24 frames/s are more than 1000000 frames" );
    write_text( "scene.json", "{\"scene\":\"room.gltf\",\"camera\":{" DOLLY "}}" );
    cli_expect( cli_run( "$R render scene.json -o e.####.exr" ), 1, "scene.json: camera.duration: 1e+06 s at 24" );
    cli_expect( cli_run( "$R info scene.json" ), 1, "scene.json: camera.duration: 1e+06 s at 24" );
    write_text(
        "keyed.json",
        "{\"kind\":\"keyed\",\"rotation\":{},\"keys\":[{\"time\":0,\"position\":[0,0,1]},{\"time\":1e6,\"position\":[0,0,2]}]}" );
    cli_expect( cli_run( "$R render room.gltf -o e.####.exr --camera keyed.json" ), 1,
                "keyed.json: keys[1].time: 1e+06 s at 24" );
    write_text( "none.json", "[]" );
    cli_expect( cli_run( "$R render room.gltf -o e.####.exr --camera none.json" ), 1,
                "reframe render: none.json: must be an object, got an array of 0" );
    write_text( "scene.json", "3" );
    cli_expect( cli_run( "$R info scene.json" ), 1, "reframe info: scene.json: must be an object, got 3" );
    write_text( "list.gltf", "[]" );
    cli_expect( cli_run( "$R info list.gltf" ), 1, "reframe info: list.gltf: document: must be an object, got an array of 0" );
}

static json_t* load_schema( const char* name )
{
    char path[512];
    json_error_t error;
    snprintf( path, sizeof path, "%s/%s", REFRAME_SOURCE_DIR, name );
    json_t* schema = json_load_file( path, JSON_REJECT_DUPLICATES, &error );
    if ( schema == NULL )
        fail_msg( "%s: %s", path, error.text );
    return schema;
}

// The reader's keys, which it lists when it meets one that it does not know,
// are those of the schema.
static void expect_same_keys( const json_t* properties, const char* line )
{
    const char* list = strstr( line, "keys here are: " );
    assert_non_null( list );
    char copy[1024];
    list += strlen( "keys here are: " );
    snprintf( copy, sizeof copy, "%.*s", (int)strcspn( list, "\n" ), list );
    size_t known = 0, notes = 0;
    for ( char* key = strtok( copy, ", " ); key != NULL; key = strtok( NULL, ", " ), ++known )
    {
        if ( json_object_get( properties, key ) == NULL )
            fail_msg( "the schema does not know %s", key );
    }
    notes += json_object_get( properties, "about" ) != NULL;
    notes += json_object_get( properties, "$schema" ) != NULL;
    assert_int_equal( json_object_size( properties ), known + notes );
}

TEST( test_schemas_match_the_readers )
{
    static const char* const objects[][2] = {
        { "\"zzzzzz\":0", "" },
        { "\"environment\":{\"zzzzzz\":0}", "environment" },
        { "\"materials\":{\"lamp\":{\"zzzzzz\":0}}", "materials" },
        { "\"materials\":{\"lamp\":{\"emissiveTexture\":{\"zzzzzz\":0}}}", "sequence" },
    };
    json_t* schema = load_schema( "scenes/scene.schema.json" );
    RfScene scene;
    for ( size_t i = 0; i < 4; ++i )
    {
        RfError error = { 0 };
        const json_t* part = json_object_get( schema, i < 3 ? "properties" : "$defs" );
        if ( i > 0 )
            part = json_object_get( part, objects[i][1] );
        if ( i == 2 )
            part = json_object_get( part, "additionalProperties" );
        assert_int_not_equal( try_members( objects[i][0], &scene, &error ), RF_OK );
        expect_same_keys( i > 0 ? json_object_get( part, "properties" ) : part, error.text );
    }
    write_render( "{\"zzzzzz\":0}" );
    expect_same_keys( json_object_get( json_object_get( json_object_get( schema, "properties" ), "render" ), "properties" ),
                      cli_run( "$R info scene.json" )->err );
    json_decref( schema );

    schema = load_schema( "anim/camera-path.schema.json" );
    static const char* const kinds[] = { "keyed", "orbit", "dolly", "zoom", "walk" };
    for ( size_t i = 0; i < 5; ++i )
    {
        char members[128];
        RfError error = { 0 };
        snprintf( members, sizeof members, "\"camera\":{\"kind\":\"%s\",\"zzzzzz\":0}", kinds[i] );
        assert_int_not_equal( try_members( members, &scene, &error ), RF_OK );
        const json_t* kind = json_object_get( json_object_get( schema, "$defs" ), kinds[i] );
        expect_same_keys( json_object_get( kind, "properties" ), error.text );
    }
    json_decref( schema );
}

// Of a schema that may be one of several, the one of this type.
static const json_t* of_type( const json_t* schema, const char* type )
{
    size_t i;
    const json_t *choices = json_object_get( schema, "oneOf" ), *choice;
    json_array_foreach( choices, i, choice )
    {
        if ( json_is_string( json_object_get( choice, "type" ) ) &&
             strcmp( json_string_value( json_object_get( choice, "type" ) ), type ) == 0 )
            return choice;
    }
    return schema;
}

static void expect_limits( const json_t* schema, const RfOption* option )
{
    const json_t *least = json_object_get( schema, "minimum" ), *most = json_object_get( schema, "maximum" );
    if ( !json_is_number( least ) || !json_is_number( most ) || json_number_value( least ) != option->min ||
         json_number_value( most ) != option->max )
        fail_msg( "--%s takes %g to %g, the schema has other limits", option->name, option->min, option->max );
}

static void expect_words( const json_t* schema, const RfOption* option )
{
    size_t i, count = 0;
    const json_t *words = json_object_get( schema, "enum" ), *word;
    json_array_foreach( words, i, word )
    {
        if ( json_is_string( word ) &&
             ( option->choices[count] == NULL || strcmp( json_string_value( word ), option->choices[count++] ) != 0 ) )
            fail_msg( "--%s has other words in the schema", option->name );
    }
    assert_null( option->choices[count] );
}

// A scene file may give what the command line may.
TEST( test_schema_has_the_limits_of_the_options )
{
    json_auto_t* schema = load_schema( "scenes/scene.schema.json" );
    const json_t* render = json_object_get( json_object_get( schema, "properties" ), "render" );
    int checked = 0;
    for ( int i = 0; i < rf_render_table.option_count; ++i )
    {
        const RfOption* option = rf_render_table.options + i;
        char key[64];
        snprintf( key, sizeof key, "%s", option->name );
        for ( char* c = key; *c != '\0'; ++c )
            *c = *c == '-' ? '_' : *c;
        const json_t* property = json_object_get( json_object_get( render, "properties" ), key );
        assert_true( ( property != NULL ) == option->in_file );
        if ( property == NULL )
            continue;
        ++checked;
        if ( option->type == RF_OPTION_INT )
            expect_limits( of_type( property, "integer" ), option );
        else if ( option->type == RF_OPTION_REAL || option->type == RF_OPTION_NOISE || option->type == RF_OPTION_FLICKER ||
                  option->type == RF_OPTION_TIME )
            expect_limits( of_type( property, "number" ), option );
        else if ( option->type == RF_OPTION_SIZE )
            expect_limits( json_object_get( property, "items" ), option );
        else if ( option->type == RF_OPTION_CHOICE )
            expect_words( property, option );
    }
    assert_true( checked > 20 );
}

// A number at a limit of the schema is read, one beyond is not.
static void expect_limit( const char* members, double limit, double beyond )
{
    char text[256];
    RfScene scene;
    RfError error = { 0 };
    snprintf( text, sizeof text, members, limit );
    if ( try_members( text, &scene, &error ) != RF_OK )
        fail_msg( "%s: %s", text, error.text );
    rf_destroy_scene( &scene );
    snprintf( text, sizeof text, members, beyond );
    if ( try_members( text, &scene, &error ) == RF_OK )
        fail_msg( "%s is read", text );
}

TEST( test_schema_has_the_limits_of_keys )
{
    static const char* const keyed[][2] = {
        { "skyStrength", "\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"time\":0,\"strength\":%.17g}]}" },
        { "skyRotation", "\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"time\":0,\"rotation\":%.17g}]}" },
        { "metallicFactor", "\"materials\":{\"lamp\":{\"keys\":[{\"time\":0,\"metallicFactor\":%.17g}]}}" },
        { "roughnessFactor", "\"materials\":{\"lamp\":{\"keys\":[{\"time\":0,\"roughnessFactor\":%.17g}]}}" },
        { "emissiveStrength", "\"materials\":{\"lamp\":{\"keys\":[{\"time\":0,\"emissiveStrength\":%.17g}]}}" },
        { "time", "\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"time\":%.17g,\"strength\":1}]}" },
        { "frame", "\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"frame\":%.17g,\"strength\":1}]}" },
    };
    json_auto_t* schema = load_schema( "scenes/scene.schema.json" );
    for ( size_t i = 0; i < sizeof keyed / sizeof keyed[0]; ++i )
    {
        const json_t* definition = json_object_get( json_object_get( schema, "$defs" ), keyed[i][0] );
        double low = json_number_value( json_object_get( definition, "minimum" ) ),
               high = json_number_value( json_object_get( definition, "maximum" ) );
        assert_true( low < high );
        expect_limit( keyed[i][1], low, low - 0.5 );
        expect_limit( keyed[i][1], high, high * 1.01 );
    }
}

static int count_examples( const char* folder, const char* command )
{
    char path[512];
    snprintf( path, sizeof path, "%s/%s", REFRAME_SOURCE_DIR, folder );
    DIR* dir = opendir( path );
    assert_non_null( dir );
    int count = 0;
    for ( struct dirent* entry = readdir( dir ); entry != NULL; entry = readdir( dir ) )
    {
        size_t length = strlen( entry->d_name );
        if ( length < 6 || strcmp( entry->d_name + length - 5, ".json" ) != 0 || strstr( entry->d_name, ".schema." ) != NULL )
            continue;
        const CliResult* result = cli_run( command, entry->d_name );
        if ( result->status != 0 || strstr( result->err, "is black" ) != NULL )
            fail_msg( "%s/%s: %s", folder, entry->d_name, result->err );
        ++count;
    }
    closedir( dir );
    return count;
}

// Every file of anim/ and scenes/ renders, beginning, middle and end.
TEST( test_every_example_renders )
{
    cli_run( "mkdir tree tree/out; cp -r %s/anim %s/scenes tree/; cp $VASE tree/scenes/vase-room.glb", REFRAME_SOURCE_DIR,
             REFRAME_SOURCE_DIR );
#define TINY "--size 16x9 --spp 1 --group 0 --frames 1,20,-1 --overwrite --quiet"
    assert_true( count_examples( "anim", "$R render $VASE --camera tree/anim/%s -o tree/out/f.####.exr " TINY ) >= 6 );
    assert_true( count_examples( "scenes", "$R render tree/scenes/%s -o tree/out/f.####.exr " TINY ) >= 2 );
}

static int enter( void** state )
{
    (void)state;
    cli_enter();
    write_room( "" );
    return 0;
}

static int leave( void** state )
{
    (void)state;
    cli_leave();
    return 0;
}

SHARED_BY_TESTS( enter, leave )
