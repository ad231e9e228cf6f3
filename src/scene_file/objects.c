// Reads `objects` of a scene file (places, keys, how an animation is played), and does to the scene what they say.
#include "scene_file/objects.h"

#include "base/remedy.h"
#include "base/try.h"
#include "base/words.h"
#include "gltf/gltf_document.h"
#include "scene/camera_path/camera_track.h"
#include "scene/shared_json.h"
#include "scene/merge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_OBJECTS 100000
#define MAX_LENGTH 1e15

// One number is the same scale along all axes.
static RfResult read_scale( const RfField* field, double value[3] )
{
    RfRange range = rf_range( -MAX_LENGTH, MAX_LENGTH );
    if ( json_is_array( field->json ) )
        return rf_field_numbers( field, range, 3, value );
    if ( !json_is_number( field->json ) )
        return rf_field_must_be( field, "a number or an array of 3 numbers" );
    RfResult result = rf_field_number( field, range, value );
    value[1] = value[2] = value[0];
    return result;
}

static RfResult read_visible( const RfField* field, double value[1] )
{
    bool visible = true;
    rf_field_bool( field, &visible );
    value[0] = visible ? 1.0 : 0.0;
    return rf_json_result( field );
}

static const RfKeyed s_keyed[] = {
    { "translation", RF_TRANSLATION, 3, -MAX_LENGTH, MAX_LENGTH, 1, NULL },
    { "rotation", RF_ROTATION, 4, 0, 0, 1, rf_read_rotation },
    { "scale", RF_SCALE, 3, 0, 0, 1, read_scale },
    { "visible", RF_VISIBILITY, 1, 0, 0, 1, read_visible },
};
#define KEYED_COUNT ( (int)( sizeof s_keyed / sizeof s_keyed[0] ) )

static RfResult read_keys( const RfField* field, RfFps fps, RfObject* object, bool* in_frames )
{
    RfChannel channels[KEYED_COUNT];
    rf_read_keys( field, fps, s_keyed, KEYED_COUNT, channels, in_frames );
    for ( int i = 0; i < KEYED_COUNT; ++i )
        object->channels[s_keyed[i].path] = channels[i];
    return rf_json_result( field );
}

// What has no keys.
static RfResult read_still( const RfField* field, RfObject* object )
{
    for ( int i = 0; i < KEYED_COUNT; ++i )
    {
        const RfKeyed* kind = s_keyed + i;
        RfField member = rf_field_member( field, kind->name );
        object->given |= object->channels[kind->path].count > 0 || member.json != NULL ? 1u << kind->path : 0u;
        if ( member.json != NULL )
            rf_read_keyed( &member, kind, object->still[kind->path] );
    }
    return rf_json_result( field );
}

static RfResult read_playing( const RfField* field, RfObject* object )
{
    static const char* const s_how[] = { "animation", "start", "speed", "repeat" };
    static const char* const s_repeats[] = { "hold", "loop", NULL };
    int repeat = 0;
    object->clock.speed = 1.0;
    for ( int i = 0; object->plays == NULL && i < 4; ++i )
        object->plays = rf_has_member( field, s_how[i] ) ? s_how[i] : NULL;
    rf_get_text( field, "animation", &object->animation );
    rf_get_number( field, "start", rf_range( -RF_MAX_TRACK_SECONDS, RF_MAX_TRACK_SECONDS ), &object->clock.start );
    rf_get_number( field, "speed", rf_range( 1e-6, 1e6 ), &object->clock.speed );
    rf_get_choice( field, "repeat", s_repeats, &repeat );
    object->clock.loops = repeat == 1;
    return rf_json_result( field );
}

static RfResult read_file( const RfField* field, RfObject* object )
{
    RfField file = rf_field_member( field, "file" );
    RfResult result = rf_field_text( &file, &object->file );
    if ( result == RF_OK && rf_ends_with( object->file, ".json" ) )
        return rf_field_must_be( &file, "a .glb or .gltf file: scene files do not nest" );
    rf_get_text( field, "name", &object->name );
    rf_get_text( field, "variant", &object->variant );
    return read_playing( field, object );
}

static RfResult read_object( const RfField* field, RfFps fps, RfObject* object, bool* in_frames )
{
    static const char* const s_of_node[] = {
        "node", "translation", "rotation", "scale", "visible", "keys", "interpolation", NULL
    };
    static const char* const s_of_file[] = { "file",  "name",    "materials",     "translation", "rotation",
                                             "scale", "visible", "interpolation", "animation",   "keys",
                                             "start", "speed",   "repeat",        "variant",     NULL };
    RfField node = rf_field_member( field, "node" );
    bool places = rf_has_member( field, "file" );
    *in_frames = false;
    if ( !json_is_object( field->json ) )
        return rf_field_must_be( field, "an object" );
    if ( places && node.json != NULL )
        return rf_field_fail( &node, "not together with file: leave one of the two out" );
    if ( !places && node.json == NULL )
        return rf_field_fail( field, "has neither node, one of the scene, nor file, a .glb or .gltf to place" );
    RF_TRY( rf_field_keys( field, places ? s_of_file : s_of_node ) );
    RF_TRY( places ? read_file( field, object ) : rf_field_text( &node, &object->node ) );
    read_keys( field, fps, object, in_frames );
    RF_TRY( read_still( field, object ) );
    if ( !places && object->given == 0 )
        return rf_field_fail( field, "changes nothing: give it keys, translation, rotation, scale or visible" );
    return RF_OK;
}

RfResult rf_read_objects( const RfField* list, RfFps fps, RfObjects* objects )
{
    *objects = ( RfObjects ){ 0 };
    if ( list->json == NULL )
        return RF_OK;
    RF_TRY( rf_field_array( list, "objects", 0, MAX_OBJECTS ) );
    size_t count = json_array_size( list->json );
    objects->list = calloc( count + 1, sizeof *objects->list );
    if ( objects->list == NULL )
        return rf_field_no_memory( list );
    for ( size_t i = 0; i < count; ++i )
    {
        bool in_frames;
        RfObject* object = objects->list + objects->count++;
        object->field = rf_field_item( list, i );
        object->field.notes = true;
        RF_TRY( read_object( &object->field, fps, object, &in_frames ) );
        objects->in_frames = objects->in_frames || in_frames;
    }
    return RF_OK;
}

void rf_destroy_objects( RfObjects* objects )
{
    for ( int i = 0; i < objects->count; ++i )
    {
        for ( int path = 0; path < RF_OBJECT_PATHS; ++path )
            rf_destroy_channel( objects->list[i].channels + path );
    }
    free( objects->list );
    *objects = ( RfObjects ){ 0 };
}

// What objects do to a scene: they move nodes of its own file, and place other files, each under a node of its own.

#define NAMES_LISTED 6

// Of the scene's own file.

// The number of each node by its name, SEVERAL where more than one has it. NULL: there is no memory.
#define SEVERAL ( -1 )
static json_t* list_names( const json_t* nodes )
{
    json_t* names = json_object();
    const json_t* node;
    size_t i;
    json_array_foreach( nodes, i, node )
    {
        const char* name = json_string_value( json_object_get( node, "name" ) );
        name = name != NULL ? name : "";
        json_int_t number = json_object_get( names, name ) == NULL ? (json_int_t)i : SEVERAL;
        if ( json_object_set_new( names, name, json_integer( number ) ) == 0 )
            continue;
        json_decref( names );
        return NULL;
    }
    return names;
}

// nodes[3], as messages name one that has no name.
static bool find_number( const char* text, size_t count, int* index )
{
    char again[RF_ITEM_NAME];
    unsigned number;
    if ( sscanf( text, "nodes[%9u]", &number ) != 1 || number >= count )
        return false;
    snprintf( again, sizeof again, "nodes[%u]", number );
    *index = (int)number;
    return strcmp( again, text ) == 0;
}

static RfResult fail_several( const RfField* field, const char* name, const json_t* nodes )
{
    char text[NAMES_LISTED * 32] = "";
    size_t i;
    int found = 0;
    const json_t* node;
    json_array_foreach( nodes, i, node )
    {
        const char* own = json_string_value( json_object_get( node, "name" ) );
        if ( strcmp( own != NULL ? own : "", name ) == 0 && found++ < NAMES_LISTED )
            rf_append( text, sizeof text, "%snodes[%zu]", found > 1 ? ", " : "", i );
    }
    return rf_field_fail( field, "%d nodes are called '%.60s': give the number of one: %s%s", found, name, text,
                          found > NAMES_LISTED ? " and so on" : "" );
}

static RfResult find_node( const RfObject* object, const json_t* nodes, const json_t* names, int* index )
{
    const json_t* number = json_object_get( names, object->node );
    RfField field = rf_field_member( &object->field, "node" );
    if ( find_number( object->node, json_array_size( nodes ), index ) )
        return RF_OK;
    if ( number == NULL )
        return rf_fail_unknown_item( &field, "node", object->node, nodes );
    *index = (int)json_integer_value( number );
    return *index != SEVERAL ? RF_OK : fail_several( &field, object->node, nodes );
}

// What glTF or a camera's own path would pass over.
static RfResult check_effect( const RfObject* object, const json_t* node, bool moves )
{
    const char* name = object->node;
    const json_t* reframe = json_object_get( json_object_get( node, "extras" ), "reframe" );
    if ( json_object_get( node, "children" ) != NULL )
        return RF_OK;
    if ( moves && json_object_get( node, "skin" ) != NULL )
        return rf_field_fail( &object->field, "'%.60s' has a skin, which its joints alone move: name a node above them", name );
    if ( moves && json_object_get( node, "camera" ) != NULL && json_object_get( reframe, "path" ) != NULL )
        return rf_field_fail(
            &object->field, "'%.60s' is a camera with a path of its own, which goes first: give \"camera\" another path", name );
    if ( ( object->given & 1u << RF_VISIBILITY ) != 0 && json_object_get( node, "mesh" ) == NULL &&
         json_object_get( node, "extensions" ) == NULL )
        return rf_field_fail( &object->field, "'%.60s' has nothing that could be hidden: leave visible out", name );
    return RF_OK;
}

static RfResult check_node( const RfObject* object, const json_t* node )
{
    const unsigned all = 1u << RF_TRANSLATION | 1u << RF_ROTATION | 1u << RF_SCALE;
    RF_TRY( check_effect( object, node, ( object->given & all ) != 0 ) );
    if ( ( object->given & all ) != 0 && ( object->given & all ) != all && json_object_get( node, "matrix" ) != NULL )
        return rf_field_fail( &object->field,
                              "'%.60s' has a matrix in the file: give it translation, rotation and scale, all three",
                              object->node );
    return RF_OK;
}

// Appends what an object sets of a node, with the node's number.
static void append_channels( const RfObject* object, int node, RfChannel* channels, int* count )
{
    for ( int path = 0; path < RF_OBJECT_PATHS; ++path )
    {
        if ( ( object->given & 1u << path ) == 0 )
            continue;
        channels[*count] = object->channels[path];
        channels[*count].path = (RfAnimatedPath)path;
        if ( object->channels[path].count == 0 )
            channels[*count].values = (double*)object->still[path];
        channels[( *count )++].node = node;
    }
}

RfResult rf_find_nodes( const RfObjects* objects, const json_t* root, RfChannel* channels, int* count )
{
    const json_t* nodes = json_object_get( root, "nodes" );
    int* named = calloc( json_array_size( nodes ) + 1, sizeof *named ); // 1 + the object that names a node
    json_t* names = list_names( nodes );
    RfResult result = RF_OK;
    *count = 0;
    for ( int i = 0; result == RF_OK && i < objects->count; ++i )
    {
        const RfObject* object = objects->list + i;
        int index = 0;
        if ( object->node == NULL )
            continue;
        result =
            named != NULL && names != NULL ? find_node( object, nodes, names, &index ) : rf_field_no_memory( &object->field );
        if ( result == RF_OK && named[index] > 0 )
            result = rf_field_fail( &object->field, "sets '%.60s', as objects[%d] does: leave one of the two out", object->node,
                                    named[index] - 1 );
        if ( result == RF_OK )
            result = check_node( object, json_array_get( nodes, (size_t)index ) );
        if ( result != RF_OK )
            break;
        named[index] = i + 1;
        append_channels( object, index, channels, count );
    }
    json_decref( names );
    free( named );
    return result;
}

// Of files that are placed.

static const char* name_of( const RfObject* object ) { return object->name != NULL ? object->name : object->file; }

// A file on its way.
typedef struct Placing
{
    const RfObject* object;
    RfChannel channels[RF_OBJECT_PATHS];
    RfGltfOptions options;
    bool environment; // it has one
    bool in_frames;   // keys of materials are numbers of frames
} Placing;

static RfResult survey_placed( void* user, const json_t* root, RfError* error )
{
    Placing* p = user;
    p->environment = json_object_get( rf_gltf_document_extras( root ), "environment" ) != NULL;
    return error->code;
}

// Names the scene file, the member at fault and the placed file.
static RfResult fail( const RfObject* object, RfResult result, const RfError* error )
{
    // the names that a user of the reader can get wrong
    const char* name =
        object->variant != NULL && strstr( error->text, "KHR_materials_variants: none" ) != NULL ? "variant" : "animation";
    RfField field = rf_field_member( &object->field, result == RF_ERROR_USAGE ? name : "file" );
    if ( strncmp( error->text, field.file, strlen( field.file ) ) == 0 ) // by materials of the scene file, which it names
        return rf_fail( field.error, result, "%.900s", error->text );
    return rf_advise( rf_field_fail_as( &field, result == RF_ERROR_USAGE ? RF_ERROR_SCENE : result, error ), error->remedy, 0,
                      field.error );
}

static RfResult check_placed( const Placing* p, const RfScene* placed, RfLog* log )
{
    const RfObject* object = p->object;
    int own = placed->channel_count;
    for ( int i = 0; i < p->options.channel_count; ++i )
        own -= p->channels[i].count > 0;
    if ( object->plays != NULL && own == 0 && !( placed->change_end > placed->change_start ) )
    {
        RfField field = rf_field_member( &object->field, object->plays );
        return rf_field_fail( &field, "'%.80s' has no animation: leave it out", object->file );
    }
    if ( p->environment )
        rf_warn( log, "%s: %s: the environment of '%s' is left out: the scene has its own", object->field.file,
                 object->field.path, object->file );
    return RF_OK;
}

static bool same_text( const char* a, const char* b ) { return a == NULL || b == NULL ? a == b : strcmp( a, b ) == 0; }

// Warnings of a file and its animation are given once, however often they are placed.
static bool is_repeated( const RfObjects* objects, int index )
{
    const RfObject* one = objects->list + index;
    for ( int i = 0; i < index; ++i )
    {
        if ( same_text( objects->list[i].file, one->file ) && same_text( objects->list[i].animation, one->animation ) )
            return true;
    }
    return false;
}

static RfResult place_file( const RfObject* object, RfFps fps, const double* frozen_at, bool accept_losses, RfScene* scene,
                            RfLog* log )
{
    RfScene placed;
    RfError error = { 0 };
    Placing p = { .object = object };
    p.options = ( RfGltfOptions ){
        .freeze = frozen_at != NULL,
        .frozen_at = frozen_at,
        .animation = object->animation,
        .accept_losses = accept_losses,
        .variant = object->variant,
        .materials = rf_field_member( &object->field, "materials" ),
        .survey = survey_placed,
        .user = &p,
        .channels = p.channels,
        .top = name_of( object ),
        .no_environment = true,
        .clock = &object->clock,
        .origin = scene->origin,
        .fps = fps,
        .in_frames = &p.in_frames,
    };
    append_channels( object, -1, p.channels, &p.options.channel_count );
    char* path = rf_path_beside( object->field.file, object->file );
    if ( path == NULL )
        return rf_field_no_memory( &object->field );
    RfResult result = rf_load_gltf_with( path, &p.options, &placed, log, &error );
    free( path );
    if ( result == RF_OK && p.in_frames && scene->key_fps.numerator == 0 )
        scene->key_fps = fps;
    if ( result != RF_OK )
        return fail( object, result, &error );
    result = check_placed( &p, &placed, log );
    if ( result != RF_OK )
        rf_destroy_scene( &placed );
    return result == RF_OK ? rf_merge_scene( scene, &placed, name_of( object ), object->field.error ) : result;
}

RfResult rf_place_files( const RfObjects* objects, RfFps fps, const double* frozen_at, bool accept_losses, RfScene* scene,
                         RfLog* log )
{
    for ( int i = 0; i < objects->count; ++i )
    {
        if ( objects->list[i].file != NULL )
            RF_TRY(
                place_file( objects->list + i, fps, frozen_at, accept_losses, scene, is_repeated( objects, i ) ? NULL : log ) );
    }
    return RF_OK;
}
