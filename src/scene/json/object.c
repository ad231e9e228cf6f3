// Reads `objects` of a scene file: places, keys, and how an animation is played.
#include "scene/json/object.h"

#include "base/words.h"
#include "scene/camera_path/camera_track_read.h"
#include "scene/json/keys.h"

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
    RfResult result = rf_field_keys( field, places ? s_of_file : s_of_node );
    if ( result == RF_OK )
        result = places ? read_file( field, object ) : rf_field_text( &node, &object->node );
    if ( result != RF_OK )
        return result;
    read_keys( field, fps, object, in_frames );
    result = read_still( field, object );
    if ( result == RF_OK && !places && object->given == 0 )
        return rf_field_fail( field, "changes nothing: give it keys, translation, rotation, scale or visible" );
    return result;
}

RfResult rf_read_objects( const RfField* list, RfFps fps, RfObjects* objects )
{
    *objects = ( RfObjects ){ 0 };
    if ( list->json == NULL )
        return RF_OK;
    RfResult result = rf_field_array( list, "objects", 0, MAX_OBJECTS );
    size_t count = json_array_size( list->json );
    if ( result == RF_OK )
        objects->list = calloc( count + 1, sizeof *objects->list );
    if ( result == RF_OK && objects->list == NULL )
        return rf_field_no_memory( list );
    for ( size_t i = 0; result == RF_OK && i < count; ++i )
    {
        bool in_frames;
        RfObject* object = objects->list + objects->count++;
        object->field = rf_field_item( list, i );
        object->field.notes = true;
        result = read_object( &object->field, fps, object, &in_frames );
        objects->in_frames = objects->in_frames || in_frames;
    }
    return result;
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
