// What scene files and the extras of a glTF say alike: keys, the environment, image sequences, views.
#include "scene/shared_json.h"

#include "base/file.h"
#include "base/try.h"
#include "base/words.h"
#include "image/decode.h"
#include "reframe/image.h"
#include "scene/camera_path/camera_track.h"
#include "scene/camera_path/curve.h"
#include "scene/light_groups.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define MAX_KEYS 1000000
#define MAX_KINDS 8
#define MAX_COMPONENTS 4

RfKeyed rf_keyed_value( RfChangedValue value )
{
    const RfChangedTraits* traits = rf_changed_traits( value );
    bool own = traits->file_high > 0.0;
    return ( RfKeyed ){ traits->name,
                        RF_VALUE,
                        traits->components,
                        own ? traits->file_low : traits->low,
                        own ? traits->file_high : traits->high,
                        ( traits->flags & RF_VALUE_DEGREES ) != 0 ? PI / 180.0 : 1.0,
                        NULL };
}

RfResult rf_read_keyed( const RfField* field, const RfKeyed* kind, double* value )
{
    if ( kind->read != NULL )
        return kind->read( field, value );
    RfRange range = rf_range( kind->low, kind->high );
    RfResult result = kind->components == 1 ? rf_field_number( field, range, value )
                                            : rf_field_numbers( field, range, kind->components, value );
    for ( int i = 0; field->json != NULL && result == RF_OK && i < kind->components; ++i )
        value[i] *= kind->unit;
    return result;
}

// Makes room for those of the keys that have such a value.
static RfResult open_channel( const RfField* keys, const RfKeyed* kind, RfChannel* channel )
{
    size_t count = 0, all = json_array_size( keys->json );
    for ( size_t i = 0; i < all; ++i )
        count += json_object_get( json_array_get( keys->json, i ), kind->name ) != NULL;
    if ( count == 0 )
        return RF_OK;
    channel->times = malloc( count * sizeof *channel->times );
    channel->values = malloc( count * (size_t)kind->components * sizeof *channel->values );
    return channel->times != NULL && channel->values != NULL ? RF_OK : rf_field_no_memory( keys );
}

static RfResult read_key( const RfField* key, double seconds, const RfKeyed* kinds, int count, RfChannel* channels )
{
    const char* names[MAX_KINDS + 1] = { NULL };
    char list[160] = "";
    bool any = false;
    for ( int i = 0; i < count; ++i )
    {
        RfChannel* channel = channels + i;
        double value[MAX_COMPONENTS] = { 0 };
        RfField field = rf_field_member( key, kinds[i].name );
        names[i] = kinds[i].name;
        if ( field.json == NULL )
            continue;
        RF_TRY( rf_read_keyed( &field, kinds + i, value ) );
        size_t n = (size_t)channel->components;
        memcpy( channel->values + n * (size_t)channel->count, value, n * sizeof *value );
        channel->times[channel->count++] = seconds;
        any = true;
    }
    rf_append_words( list, sizeof list, names, ", ", " or " );
    return any ? RF_OK : rf_field_fail( key, "has no %s: give it one, or leave it out", list );
}

static RfResult read_all( const RfField* keys, RfFps fps, const RfKeyed* kinds, int kind_count, RfChannel* channels,
                          bool* in_frames )
{
    const char* names[MAX_KINDS + 2] = { NULL };
    RfField first = rf_field_item( keys, 0 );
    int count = (int)json_array_size( keys->json );
    *in_frames = rf_has_member( &first, "frame" );
    names[0] = *in_frames ? "frame" : "time";
    for ( int i = 0; i < kind_count; ++i )
        names[i + 1] = kinds[i].name;
    double* times = calloc( (size_t)count, sizeof *times );
    RfResult result = times != NULL ? RF_OK : rf_field_no_memory( keys );
    for ( int i = 0; result == RF_OK && i < count; ++i )
    {
        RfField key = rf_field_item( keys, (size_t)i );
        rf_field_keys( &key, names );
        result = rf_read_key_time( &key, *in_frames, i, times );
        // as the times of the frames of a camera, to the bit
        double seconds = *in_frames ? ( times[i] - 1.0 ) * (double)fps.denominator / (double)fps.numerator : times[i];
        if ( result == RF_OK )
            result = read_key( &key, seconds, kinds, kind_count, channels );
    }
    free( times );
    return result;
}

// Colours: each component as a number is, by a monotone cubic, which does not leave the range of the keys.
static RfResult make_monotone( const RfField* keys, RfChannel* channel )
{
    size_t n = (size_t)channel->components, count = (size_t)channel->count;
    double* values = malloc( 3 * n * count * sizeof *values );
    double* one = malloc( count * sizeof *one );
    RfResult result = values != NULL && one != NULL ? RF_OK : rf_field_no_memory( keys );
    for ( size_t c = 0; result == RF_OK && c < n; ++c )
    {
        RfCurve curve;
        for ( size_t k = 0; k < count; ++k )
            one[k] = channel->values[n * k + c];
        result = rf_create_curve( RF_CURVE_NUMBER, false, channel->count, channel->times, one, &curve, keys->error );
        for ( size_t k = 0; result == RF_OK && k < count; ++k )
        {
            double* key = values + 3 * n * k + c; // in-tangent, value, out-tangent
            key[0] = key[2 * n] = curve.slopes[k];
            key[n] = one[k];
        }
        if ( result == RF_OK )
            rf_destroy_curve( &curve );
    }
    free( one );
    if ( result != RF_OK )
    {
        free( values );
        return result;
    }
    free( channel->values );
    channel->values = values;
    channel->interpolation = RF_CUBICSPLINE;
    return RF_OK;
}

static RfResult smooth( const RfField* keys, RfChannel* channel )
{
    if ( channel->count < 2 || channel->path == RF_VISIBILITY )
        return RF_OK;
    if ( channel->path == RF_VALUE && channel->components > 1 )
        return make_monotone( keys, channel );
    channel->curve = calloc( 1, sizeof *channel->curve );
    if ( channel->curve == NULL )
        return rf_field_no_memory( keys );
    RfCurveKind kind = channel->path == RF_ROTATION ? RF_CURVE_ROTATION
                       : channel->components == 1   ? RF_CURVE_NUMBER
                                                    : RF_CURVE_POINT;
    return rf_create_curve( kind, false, channel->count, channel->times, channel->values, channel->curve, keys->error );
}

static RfResult refuse_twice( const RfField* object, const RfKeyed* kinds, int count, const RfChannel* channels )
{
    for ( int i = 0; i < count; ++i )
    {
        RfField member = rf_field_member( object, kinds[i].name );
        if ( channels[i].count > 0 && member.json != NULL )
            return rf_field_fail( &member, "keys have it too: leave one of the two out" );
    }
    return RF_OK;
}

RfResult rf_read_keys( const RfField* object, RfFps fps, const RfKeyed* kinds, int count, RfChannel* channels, bool* in_frames )
{
    RfField keys = rf_field_member( object, "keys" ), how = rf_field_member( object, "interpolation" );
    bool linear;
    *in_frames = false;
    for ( int i = 0; i < count; ++i )
        channels[i] = ( RfChannel ){ .node = -1,
                                     .path = kinds[i].path,
                                     .components = kinds[i].components,
                                     .interpolation = kinds[i].path == RF_VISIBILITY ? RF_STEP : RF_LINEAR };
    if ( keys.json == NULL && how.json != NULL )
        return rf_field_fail( &how, "has no effect without keys: leave it out" );
    if ( keys.json == NULL )
        return rf_json_result( object );
    rf_field_array( &keys, "keys", 1, MAX_KEYS );
    RF_TRY( rf_read_interpolation( object, &linear ) );
    for ( int i = 0; i < count; ++i )
        RF_TRY( open_channel( &keys, kinds + i, channels + i ) );
    RF_TRY( read_all( &keys, fps, kinds, count, channels, in_frames ) );
    for ( int i = 0; !linear && i < count; ++i )
        RF_TRY( smooth( &keys, channels + i ) );
    return refuse_twice( object, kinds, count, channels );
}

// Brighter radiance would overflow when floats are squared.
#define MAX_RADIANCE 1e15

// Those of its values that change, from RF_CHANGED_SKY_STRENGTH on.
enum
{
    STRENGTH,
    RADIANCE,
    ROTATION,
    SKY_VALUES
};

static RfChangedValue sky_value( int i ) { return (RfChangedValue)( (int)RF_CHANGED_SKY_STRENGTH + i ); }

// The view in place of the file; −1: none.
static RfResult read_view( const RfField* object, const RfField* map, int* view )
{
    *view = -1;
    if ( map->json != NULL && rf_has_member( object, "bufferView" ) )
        return rf_field_fail( object, "has both map and bufferView: give one of them" );
    return rf_get_whole( object, "bufferView", 0.0, 1e9, view );
}

// The most of the radiance at any time.
static double most_radiance( const RfEnvironmentText* text )
{
    const RfChannel* strength = text->changes + STRENGTH;
    double most = strength->count > 0 ? 0.0 : 1.0;
    for ( int i = 0; i < strength->count; ++i )
        most = fmax( most, strength->values[i] );
    const RfChannel* radiance = text->changes + RADIANCE;
    double color = radiance->count > 0 ? 0.0 : 1.0;
    for ( int i = 0; i < 3 * radiance->count; ++i )
        color = fmax( color, radiance->values[i] );
    return most * color * (double)rf_max_component( text->environment.radiance );
}

RfResult rf_read_environment( const RfField* object, bool in_gltf, RfFps fps, RfEnvironmentText* text )
{
    static const char* const s_file_keys[] = { "radiance",      "map",  "strength",    "rotation", "visible",
                                               "interpolation", "keys", "light_group", NULL };
    static const char* const s_keys[] = { "radiance",      "map",  "strength",   "rotation",    "visible",
                                          "interpolation", "keys", "bufferView", "light_group", NULL };
    double values[SKY_VALUES][3] = { [STRENGTH] = { 1.0 }, [RADIANCE] = { 1.0, 1.0, 1.0 } };
    RfKeyed kinds[SKY_VALUES];
    bool visible = true;
    *text = ( RfEnvironmentText ){ .view = -1 };
    RfField map_field = rf_field_member( object, "map" );
    for ( int i = 0; i < SKY_VALUES; ++i )
        kinds[i] = rf_keyed_value( sky_value( i ) );
    rf_field_keys( object, in_gltf ? s_keys : s_file_keys );
    if ( in_gltf )
        read_view( object, &map_field, &text->view );
    bool has_map = map_field.json != NULL || text->view >= 0;
    rf_read_light_group( object, &text->light_group );
    rf_field_text( &map_field, &text->map );
    rf_get_bool( object, "visible", &visible );
    rf_read_keys( object, fps, kinds, SKY_VALUES, text->changes, &text->in_frames );
    if ( !rf_has_member( object, "radiance" ) && text->changes[RADIANCE].count == 0 && !has_map )
        return rf_field_fail( object, "gives no light: give radiance, map or both" );
    for ( int i = 0; i < SKY_VALUES; ++i )
    {
        RfField field = rf_field_member( object, kinds[i].name );
        rf_read_keyed( &field, kinds + i, values[i] );
    }
    RF_TRY( rf_json_result( object ) );
    text->environment = ( RfEnvironment ){
        .radiance = rf_vec3_of( values[RADIANCE], values[STRENGTH][0] ),
        .rotation = (float)fmod( values[ROTATION][0], 2.0 * PI ),
        .hidden = !visible,
    };
    return most_radiance( text ) <= MAX_RADIANCE
               ? RF_OK
               : rf_field_fail( object, "radiance times strength is brighter than %g: lower one of them", MAX_RADIANCE );
}

void rf_destroy_environment_text( RfEnvironmentText* text )
{
    free( text->environment.map );
    for ( int i = 0; i < SKY_VALUES; ++i )
        rf_destroy_channel( text->changes + i );
    *text = ( RfEnvironmentText ){ 0 };
}

static bool is_too_bright( const RfEnvironmentText* text )
{
    const RfEnvironment* e = &text->environment;
    double most = most_radiance( text );
    size_t count = 3 * (size_t)e->width * (size_t)e->height;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( most * (double)e->map[i] > MAX_RADIANCE )
            return true;
    }
    return false;
}

// Checks a map that has been loaded with `result`; the decoder's message names the file.
static RfResult check_map( const RfField* object, const char* key, RfResult result, const RfError* error,
                           const RfEnvironmentText* text )
{
    RfField field = rf_field_member( object, key );
    if ( result == RF_OK && !is_too_bright( text ) )
        return RF_OK;
    if ( result == RF_OK )
        return rf_field_fail( &field, "times radiance is brighter than %g somewhere: lower radiance", MAX_RADIANCE );
    return rf_field_fail_as( &field, result, error );
}

RfResult rf_load_environment( const RfField* object, const char* path, RfEnvironmentText* text )
{
    RfError error = { 0 };
    RfEnvironment* e = &text->environment;
    RfResult result = rf_load_environment_map( path, &e->width, &e->height, &e->map, &text->outside, &error );
    return check_map( object, "map", result, &error, text );
}

RfResult rf_decode_environment( const RfField* object, const void* bytes, size_t size, RfEnvironmentText* text )
{
    RfError error = { 0 };
    RfEnvironment* e = &text->environment;
    RfResult result = rf_decode_environment_map( bytes, size, "the map", &e->width, &e->height, &e->map, &text->outside, &error );
    return check_map( object, "bufferView", result, &error, text );
}

RfResult rf_give_environment( const RfField* object, RfEnvironmentText* text, RfScene* scene, RfLog* log )
{
    RfResult result = RF_OK;
    bool constant = text->environment.map == NULL;
    if ( text->light_group != NULL && !rf_tag_light( scene, text->light_group, &text->environment.light_group ) )
        return rf_field_no_memory( object );
    for ( int i = 0; result == RF_OK && i < SKY_VALUES; ++i )
    {
        RfChange change = { .value = sky_value( i ), .channel = text->changes[i] };
        if ( change.channel.count == 0 || ( i == ROTATION && constant ) )
            continue;
        if ( !rf_channel_varies( &change.channel ) )
        {
            int value = change.channel.interpolation == RF_CUBICSPLINE ? change.channel.components : 0; // after its tangent
            rf_change_sky( &text->environment, sky_value( i ), change.channel.values + value );
            continue;
        }
        text->environment.changes = true;
        text->changes[i] = ( RfChannel ){ 0 };
        if ( !rf_add_change( scene, &change ) )
            result = rf_field_no_memory( object );
    }
    if ( text->outside > 1e-4 )
        rf_warn( log, "%s: the environment has colours outside Rec. 709, which are clipped: %.2g %% of its light", object->file,
                 100.0 * text->outside );
    free( scene->environment.map ); // it is replaced
    scene->environment = text->environment;
    text->environment.map = NULL;
    return result;
}

RfResult rf_freeze_environment( RfScene* scene, double time, RfError* error )
{
    RfMovement* movement = scene->movement;
    int kept = 0;
    if ( !scene->environment.changes )
        return RF_OK;
    for ( int i = 0; i < movement->change_count; ++i )
    {
        RfChange* change = movement->changes + i;
        double value[4] = { 0.0 };
        if ( !rf_is_of_sky( change->value ) )
        {
            movement->changes[kept++] = *change;
            continue;
        }
        rf_sample_channel( &change->channel, time, value );
        rf_change_sky( &scene->environment, change->value, value );
        rf_destroy_channel( &change->channel );
    }
    movement->change_count = kept;
    rf_drop_empty_movement( scene );
    scene->environment.changes = false;
    scene->frozen = true;
    scene->content_hash = rf_hash_bytes( scene->content_hash, &time, sizeof time );
    return rf_note_unrendered( scene, "environment", "its keys change it" )
               ? RF_OK
               : rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", scene->path );
}

uint64_t rf_hash_environment( uint64_t hash, const RfEnvironment* environment )
{
    if ( environment->map == NULL )
        return hash;
    int size[2] = { environment->width, environment->height };
    size_t count = 3 * (size_t)environment->width * (size_t)environment->height;
    hash = rf_hash_bytes( hash, size, sizeof size );
    return rf_hash_bytes( hash, environment->map, count * sizeof *environment->map );
}

// Image sequences.

#define MAX_NUMBER 1e6
#define MAX_IMAGES 100000
#define NAME "the name of a sequence, such as \"film.####.png\""

RfResult rf_read_sequence( const RfField* object, RfImageSequence* s, const char** frames )
{
    static const char* const s_keys[] = { "frames", "first", "last", "start", "fps", "repeat", NULL };
    static const char* const s_repeats[] = { "hold", "loop", NULL };
    char name[PATH_MAX];
    RfError error;
    int repeat = 0;
    *s = ( RfImageSequence ){ .first = 1, .most = (double)INFINITY };
    *frames = "";
    RfField pattern = rf_field_member( object, "frames" ), last = rf_field_member( object, "last" );
    rf_field_keys( object, s_keys );
    rf_field_require( object, "frames", NAME );
    RfResult result = rf_field_text( &pattern, frames );
    if ( result == RF_OK && !rf_is_sequence( *frames ) )
        return rf_field_must_be( &pattern, NAME );
    if ( result == RF_OK && rf_sequence_name( *frames, 1, name, sizeof name, &error ) != RF_OK )
        return rf_field_fail( &pattern, "%.560s", error.text );
    rf_field_require( object, "last", "the number of the last image" );
    rf_get_whole( object, "first", 0.0, MAX_NUMBER, &s->first );
    result = rf_field_whole( &last, 0.0, MAX_NUMBER, &s->last );
    if ( result == RF_OK && ( s->last < s->first || s->last - s->first >= MAX_IMAGES ) )
        return rf_field_fail( &last, "must be from %d, the first image, to %d", s->first, s->first + MAX_IMAGES - 1 );
    rf_get_number( object, "start", rf_range( -RF_MAX_TRACK_SECONDS, RF_MAX_TRACK_SECONDS ), &s->start );
    rf_get_number( object, "fps", rf_range( 1e-6, 1e6 ), &s->fps );
    rf_get_choice( object, "repeat", s_repeats, &repeat );
    RfFps exact;
    if ( rf_broadcast_fps( s->fps, &exact ) )
        s->fps = (double)exact.numerator / exact.denominator;
    s->loops = repeat == 1;
    return rf_json_result( object );
}

// Views. Whether there is one of its name is asked where a picture is shown.

static RfResult read_name( const RfField* object, const char* key, char name[RF_VIEW_NAME_SIZE] )
{
    RfField field = rf_field_member( object, key );
    const char* text = "";
    RfResult result = rf_field_text( &field, &text );
    if ( result == RF_OK && strlen( text ) >= RF_VIEW_NAME_SIZE )
        return rf_field_fail( &field, "is longer than %d characters", RF_VIEW_NAME_SIZE - 1 );
    snprintf( name, RF_VIEW_NAME_SIZE, "%s", text );
    return result;
}

RfResult rf_read_view( const RfField* object, RfViewText* view )
{
    static const char* const s_keys[] = { "transform", "look", "exposure", "gamma", NULL };
    if ( object->json == NULL )
        return RF_OK;
    RfViewText read = { .gamma = 1.0 };
    rf_field_keys( object, s_keys );
    rf_field_require( object, "transform", "the name of a view, such as \"AgX\"" );
    read_name( object, "transform", read.transform );
    read_name( object, "look", read.look );
    rf_get_number( object, "exposure", rf_range( -32.0, 32.0 ), &read.exposure );
    RfResult result = rf_get_number( object, "gamma", rf_range( 0.01, 100.0 ), &read.gamma );
    *view = result == RF_OK ? read : *view;
    return result;
}
