// Reads keys of scene files into channels.
#include "scene/keys.h"

#include "scene/camera_path/camera_track_read.h"
#include "scene/camera_path/curve.h"

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

// "a, b or c".
static RfResult fail_without_value( const RfField* key, const RfKeyed* kinds, int count )
{
    char names[160];
    size_t used = 0;
    names[0] = 0;
    for ( int i = 0; i < count && used < sizeof names; ++i )
    {
        const char* before = i == 0 ? "" : i + 1 < count ? ", " : " or ";
        used += (size_t)snprintf( names + used, sizeof names - used, "%s%s", before, kinds[i].name );
    }
    return rf_field_fail( key, "has no %s: give it one, or leave it out", names );
}

static RfResult read_key( const RfField* key, double seconds, const RfKeyed* kinds, int count, RfChannel* channels )
{
    bool any = false;
    for ( int i = 0; i < count; ++i )
    {
        RfChannel* channel = channels + i;
        double value[MAX_COMPONENTS] = { 0 };
        RfField field = rf_field_member( key, kinds[i].name );
        if ( field.json == NULL )
            continue;
        RfResult result = rf_read_keyed( &field, kinds + i, value );
        if ( result != RF_OK )
            return result;
        size_t n = (size_t)channel->components;
        memcpy( channel->values + n * (size_t)channel->count, value, n * sizeof *value );
        channel->times[channel->count++] = seconds;
        any = true;
    }
    return any ? RF_OK : fail_without_value( key, kinds, count );
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
    RfResult result = rf_read_interpolation( object, &linear );
    for ( int i = 0; result == RF_OK && i < count; ++i )
        result = open_channel( &keys, kinds + i, channels + i );
    if ( result == RF_OK )
        result = read_all( &keys, fps, kinds, count, channels, in_frames );
    for ( int i = 0; result == RF_OK && !linear && i < count; ++i )
        result = smooth( &keys, channels + i );
    return result == RF_OK ? refuse_twice( object, kinds, count, channels ) : result;
}
