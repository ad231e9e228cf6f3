// Reads `objects` of a scene file: places, keys, and how an animation is played.
#include "scene/json/object.h"

#include "base/words.h"
#include "scene/camera_path/camera_track_read.h"
#include "scene/camera_path/curve.h"

#include <stdlib.h>
#include <string.h>

#define MAX_OBJECTS 100000
#define MAX_KEYS 1000000
#define MAX_LENGTH 1e15

// By RfAnimatedPath; files alone have weights.
static const char* const s_names[RF_OBJECT_PATHS] = { "translation", "rotation", "scale", NULL, "visible" };
static const int s_components[RF_OBJECT_PATHS] = { 3, 4, 3, 0, 1 };

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

static RfResult read_value( const RfField* field, RfAnimatedPath path, double value[4] )
{
    bool visible = true;
    RfResult result;
    switch ( path )
    {
        case RF_TRANSLATION: return rf_field_numbers( field, rf_range( -MAX_LENGTH, MAX_LENGTH ), 3, value );
        case RF_ROTATION: return rf_read_rotation( field, value );
        case RF_SCALE: return read_scale( field, value );
        case RF_WEIGHTS:
        case RF_VALUE: break;
        case RF_VISIBILITY:
            result = rf_field_bool( field, &visible );
            value[0] = visible ? 1.0 : 0.0;
            return result;
    }
    return RF_OK;
}

static RfResult no_memory( const RfField* field )
{
    return rf_fail( field->error, RF_ERROR_MEMORY, "%s: no memory left for %s", field->file, field->path );
}

// Makes room for those of the keys that have such a value.
static RfResult open_channel( const RfField* keys, RfAnimatedPath path, RfChannel* channel )
{
    size_t count = 0, all = json_array_size( keys->json );
    for ( size_t i = 0; i < all; ++i )
        count += json_object_get( json_array_get( keys->json, i ), s_names[path] ) != NULL;
    *channel = ( RfChannel ){ .node = -1, .path = path, .components = s_components[path], .interpolation = RF_LINEAR };
    if ( count == 0 )
        return RF_OK;
    if ( path == RF_VISIBILITY )
        channel->interpolation = RF_STEP;
    channel->times = malloc( count * sizeof *channel->times );
    channel->values = malloc( count * (size_t)channel->components * sizeof *channel->values );
    return channel->times != NULL && channel->values != NULL ? RF_OK : no_memory( keys );
}

static RfResult read_key( const RfField* key, double seconds, RfObject* object )
{
    bool any = false;
    for ( int path = 0; path < RF_OBJECT_PATHS; ++path )
    {
        RfChannel* channel = object->channels + path;
        if ( s_names[path] == NULL || !rf_has_member( key, s_names[path] ) )
            continue;
        double value[4];
        RfField field = rf_field_member( key, s_names[path] );
        RfResult result = read_value( &field, (RfAnimatedPath)path, value );
        if ( result != RF_OK )
            return result;
        size_t n = (size_t)channel->components;
        memcpy( channel->values + n * (size_t)channel->count, value, n * sizeof *value );
        channel->times[channel->count++] = seconds;
        any = true;
    }
    return any ? RF_OK : rf_field_fail( key, "has no translation, rotation, scale or visible: give it one, or leave it out" );
}

static RfResult smooth( const RfField* keys, RfChannel* channel )
{
    if ( channel->count < 2 || channel->path == RF_VISIBILITY )
        return RF_OK;
    channel->curve = calloc( 1, sizeof *channel->curve );
    if ( channel->curve == NULL )
        return no_memory( keys );
    RfCurveKind kind = channel->path == RF_ROTATION ? RF_CURVE_ROTATION : RF_CURVE_POINT;
    return rf_create_curve( kind, false, channel->count, channel->times, channel->values, channel->curve, keys->error );
}

static RfResult read_all_keys( const RfField* keys, RfFps fps, RfObject* object, bool* in_frames )
{
    static const char* const s_seconds[] = { "time", "translation", "rotation", "scale", "visible", NULL };
    static const char* const s_frames[] = { "frame", "translation", "rotation", "scale", "visible", NULL };
    RfField first = rf_field_item( keys, 0 );
    int count = (int)json_array_size( keys->json );
    *in_frames = rf_has_member( &first, "frame" );
    double* times = malloc( (size_t)count * sizeof *times );
    RfResult result = times != NULL ? RF_OK : no_memory( keys );
    for ( int i = 0; result == RF_OK && i < count; ++i )
    {
        RfField key = rf_field_item( keys, (size_t)i );
        result = rf_field_keys( &key, *in_frames ? s_frames : s_seconds );
        if ( result == RF_OK )
            result = rf_read_key_time( &key, *in_frames, i, times );
        // as the times of the frames of a camera, to the bit
        double seconds =
            *in_frames && result == RF_OK ? ( times[i] - 1.0 ) * (double)fps.denominator / (double)fps.numerator : 0.0;
        if ( result == RF_OK )
            result = read_key( &key, *in_frames ? seconds : times[i], object );
    }
    free( times );
    return result;
}

static RfResult read_keys( const RfField* object_field, RfFps fps, RfObject* object, bool* in_frames )
{
    RfField keys = rf_field_member( object_field, "keys" ), how = rf_field_member( object_field, "interpolation" );
    bool linear;
    *in_frames = false;
    if ( keys.json == NULL && how.json != NULL )
        return rf_field_fail( &how, "has no effect without keys: leave it out" );
    if ( keys.json == NULL )
        return RF_OK;
    RfResult result = rf_field_array( &keys, "keys", 1, MAX_KEYS );
    if ( result == RF_OK )
        result = rf_read_interpolation( object_field, &linear );
    for ( int path = 0; result == RF_OK && path < RF_OBJECT_PATHS; ++path )
    {
        if ( s_names[path] != NULL )
            result = open_channel( &keys, (RfAnimatedPath)path, object->channels + path );
    }
    if ( result == RF_OK )
        result = read_all_keys( &keys, fps, object, in_frames );
    for ( int path = 0; result == RF_OK && !linear && path < RF_OBJECT_PATHS; ++path )
    {
        if ( object->channels[path].count > 0 )
            result = smooth( &keys, object->channels + path );
    }
    return result;
}

// What has no keys.
static RfResult read_still( const RfField* field, RfObject* object )
{
    RfResult result = RF_OK;
    for ( int path = 0; result == RF_OK && path < RF_OBJECT_PATHS; ++path )
    {
        RfField member = rf_field_member( field, s_names[path] != NULL ? s_names[path] : "weights" );
        bool keyed = object->channels[path].count > 0;
        double value[4] = { 0 };
        if ( keyed && member.json != NULL )
            return rf_field_fail( &member, "keys have it too: leave one of the two out" );
        object->given |= keyed || member.json != NULL ? 1u << path : 0u;
        if ( member.json == NULL )
            continue;
        result = read_value( &member, (RfAnimatedPath)path, value );
        if ( path <= RF_SCALE )
            memcpy( object->still[path], value, sizeof value );
        else
            object->hidden = value[0] == 0.0;
    }
    return result;
}

static RfResult read_playing( const RfField* field, RfObject* object )
{
    static const char* const s_how[] = { "animation", "start", "speed", "repeat" };
    static const char* const s_repeats[] = { "hold", "loop", NULL };
    int repeat = 0;
    RfField animation = rf_field_member( field, "animation" ), start = rf_field_member( field, "start" ),
            speed = rf_field_member( field, "speed" ), loops = rf_field_member( field, "repeat" );
    object->clock.speed = 1.0;
    for ( int i = 0; object->plays == NULL && i < 4; ++i )
        object->plays = rf_has_member( field, s_how[i] ) ? s_how[i] : NULL;
    RfResult result = rf_field_text( &animation, &object->animation );
    if ( result == RF_OK )
        result = rf_field_number( &start, rf_range( -RF_MAX_TRACK_SECONDS, RF_MAX_TRACK_SECONDS ), &object->clock.start );
    if ( result == RF_OK )
        result = rf_field_number( &speed, rf_range( 1e-6, 1e6 ), &object->clock.speed );
    if ( result == RF_OK )
        result = rf_field_choice( &loops, s_repeats, &repeat );
    object->clock.loops = repeat == 1;
    return result;
}

static RfResult read_file( const RfField* field, RfObject* object )
{
    RfField file = rf_field_member( field, "file" ), name = rf_field_member( field, "name" );
    RfResult result = rf_field_text( &file, &object->file );
    if ( result == RF_OK && rf_ends_with( object->file, ".json" ) )
        return rf_field_must_be( &file, "a .glb or .gltf file: scene files do not nest" );
    if ( result == RF_OK )
        result = rf_field_text( &name, &object->name );
    return result == RF_OK ? read_playing( field, object ) : result;
}

static RfResult read_object( const RfField* field, RfFps fps, RfObject* object, bool* in_frames )
{
    static const char* const s_of_node[] = {
        "node", "translation", "rotation", "scale", "visible", "keys", "interpolation", NULL
    };
    static const char* const s_of_file[] = { "file",  "name",    "materials",     "translation", "rotation",
                                             "scale", "visible", "interpolation", "animation",   "keys",
                                             "start", "speed",   "repeat",        NULL };
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
    if ( result == RF_OK )
        result = read_keys( field, fps, object, in_frames );
    if ( result == RF_OK )
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
        return no_memory( list );
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
