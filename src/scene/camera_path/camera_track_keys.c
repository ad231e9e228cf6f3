// Reads keyed camera paths.

#include "scene/camera_path/camera_track_read.h"

#include <math.h>
#include <stdlib.h>

#define MAX_KEYS 1000000
// Keys closer than this in time are an error: their speed would be infinite.
#define MIN_STEP 1e-6

// The value of the key, else the default of the whole path.
static RfField inherited( const RfField* key, const RfField* top, const char* name )
{
    return rf_field_member( rf_has_member( key, name ) ? key : top, name );
}

// The values of all keys, one array per property.
typedef struct Keys
{
    int count;
    double *times, *position, *target, *up, *rotation, *fov, *shift[2], *focus, *fstop;
    bool shifts; // any of them
    bool focuses, stops;
} Keys;

static RfResult read_time( const RfField* key, bool in_frames, int index, double* times )
{
    const char* name = in_frames ? "frame" : "time";
    const char* want = in_frames ? "a frame number" : "a number of seconds";
    RfField field = rf_field_member( key, name );
    RfResult result = rf_field_require( key, name, want );
    if ( result == RF_OK )
        result = rf_field_number(
            &field, in_frames ? rf_range( 0.0, RF_MAX_TRACK_FRAMES ) : rf_range( 0.0, RF_MAX_TRACK_SECONDS ), times + index );
    if ( result != RF_OK )
        return result;
    if ( index > 0 && !( times[index] - times[index - 1] >= MIN_STEP ) )
        return rf_field_fail( &field, "%g is not later than the key before it, at %g", times[index], times[index - 1] );
    return RF_OK;
}

static RfResult read_shift( const RfField* field, Keys* keys, int i )
{
    double shift[2] = { 0.0, 0.0 };
    RfResult result = rf_field_numbers( field, rf_range( -RF_MAX_SHIFT, RF_MAX_SHIFT ), 2, shift );
    keys->shifts = keys->shifts || field->json != NULL;
    keys->shift[0][i] = shift[0];
    keys->shift[1][i] = shift[1];
    return result;
}

// All keys have such a value, or none.
static RfResult read_lens_value( const RfField* key, const char* name, double high, int i, bool* any, double* values )
{
    RfField field = rf_field_member( key, name );
    if ( i > 0 && ( field.json != NULL ) != *any )
        return rf_field_fail( key, "%s: give all keys one, or none", name );
    *any = field.json != NULL;
    return rf_field_number( &field, rf_above( 0.0, high ), values + i );
}

static RfResult read_lens_key( const RfField* key, Keys* keys, int i )
{
    RfResult result = read_lens_value( key, "focus", 1e6, i, &keys->focuses, keys->focus );
    return result == RF_OK ? read_lens_value( key, "fstop", 1e6, i, &keys->stops, keys->fstop ) : result;
}

static RfResult read_key( const RfField* top, const RfField* key, Keys* keys, int i, bool rotates, const RfCameraTrack* track )
{
    static const char* const s_seconds[] = { "time", "position", "target", "rotation", "up", "fov",
                                             "ymag", "shift",    "focus",  "fstop",    NULL };
    static const char* const s_frames[] = { "frame", "position", "target", "rotation", "up", "fov",
                                            "ymag",  "shift",    "focus",  "fstop",    NULL };
    bool in_frames = track->in_frames;
    RfResult result = rf_field_keys( key, in_frames ? s_frames : s_seconds );
    if ( result == RF_OK )
        result = rf_check_projection( key, track->projection );
    if ( result == RF_OK )
        result = read_time( key, in_frames, i, keys->times );
    if ( result == RF_OK )
        result = rf_read_point( key, "position", keys->position + 3 * i );
    if ( result == RF_OK )
        result = rf_check_look( key, rotates );
    RfField fov = inherited( key, top, rf_extent_name( track->projection ) ), up = inherited( key, top, "up" ),
            shift = inherited( key, top, "shift" );
    if ( fov.json == NULL )
        fov = rf_field_member( key, rf_extent_name( track->projection ) );
    if ( result == RF_OK )
        result = read_shift( &shift, keys, i );
    if ( result == RF_OK )
        result = read_lens_key( key, keys, i );
    if ( result == RF_OK )
        result = rf_read_extent( &fov, track->projection, keys->fov + i );
    if ( result == RF_OK )
        result = rf_read_up( &up, keys->up + 3 * i );
    if ( result != RF_OK )
        return result;
    if ( rotates )
    {
        RfField rotation = inherited( key, top, "rotation" );
        if ( rotation.json == NULL )
            rotation = rf_field_member( key, "rotation" );
        return rf_read_rotation( &rotation, keys->rotation + 4 * i );
    }
    RfField target = inherited( key, top, "target" );
    if ( target.json == NULL )
        return rf_field_fail( key, "has neither target nor rotation, and the path has none for all keys" );
    result = rf_field_numbers( &target, rf_coordinates(), 3, keys->target + 3 * i );
    if ( result == RF_OK && rf_is_same_point( keys->target + 3 * i, keys->position + 3 * i ) )
        return rf_field_fail( &target, "is at the position of the camera: move one of them" );
    return result;
}

static RfResult make_curves( const Keys* keys, bool linear, bool rotates, RfCameraTrack* track, RfError* error )
{
    int n = keys->count;
    const double* t = keys->times;
    RfResult result = rf_create_curve( RF_CURVE_POINT, linear, n, t, keys->position, &track->position, error );
    if ( result == RF_OK )
        result = rf_create_curve( RF_CURVE_NUMBER, linear, n, t, keys->fov, &track->fov, error );
    for ( int i = 0; i < 2 && result == RF_OK && keys->shifts; ++i )
        result = rf_create_curve( RF_CURVE_NUMBER, linear, n, t, keys->shift[i], track->shift + i, error );
    if ( result == RF_OK && keys->focuses )
        result = rf_create_curve( RF_CURVE_NUMBER, linear, n, t, keys->focus, &track->focus, error );
    if ( result == RF_OK && keys->stops )
        result = rf_create_curve( RF_CURVE_NUMBER, linear, n, t, keys->fstop, &track->fstop, error );
    if ( result == RF_OK && rotates )
        return rf_create_curve( RF_CURVE_ROTATION, linear, n, t, keys->rotation, &track->rotation, error );
    if ( result == RF_OK )
        result = rf_create_curve( RF_CURVE_POINT, linear, n, t, keys->target, &track->target, error );
    return result == RF_OK ? rf_create_curve( RF_CURVE_POINT, linear, n, t, keys->up, &track->up, error ) : result;
}

#define NUMBERS 19 // per key

static Keys split_memory( double* memory, int count )
{
    size_t n = (size_t)count;
    Keys keys = { .count = count,
                  .times = memory,
                  .position = memory + n,
                  .target = memory + 4 * n,
                  .up = memory + 7 * n,
                  .rotation = memory + 10 * n,
                  .fov = memory + 14 * n,
                  .shift = { memory + 15 * n, memory + 16 * n },
                  .focus = memory + 17 * n,
                  .fstop = memory + 18 * n };
    for ( size_t i = 0; i < n; ++i )
    {
        keys.up[3 * i + 1] = 1.0;
        keys.fov[i] = RF_DEFAULT_FOV;
    }
    return keys;
}

// What holds for all keys: the numbers of frames and the shape of a pixel.
static RfResult read_film( const RfField* top, RfCameraTrack* track )
{
    double step = 1.0;
    RfField field = rf_field_member( top, "step" ), aspect = rf_field_member( top, "pixelAspect" );
    RfResult result = rf_field_number( &aspect, rf_range( 0.01, 100.0 ), &track->aspect );
    if ( result == RF_OK )
        result = rf_field_number( &field, rf_range( 1.0, RF_MAX_TRACK_FRAMES ), &step );
    if ( result == RF_OK && floor( step ) != step )
        return rf_field_wants( &field, "a whole number" );
    if ( result == RF_OK && field.json != NULL && !track->in_frames )
        return rf_field_fail( &field, "wants keys with frames, not times" );
    track->step = (int)step;
    return result;
}

static RfResult read_keys( const RfField* top, const RfField* list, RfCameraTrack* track )
{
    int count = (int)json_array_size( list->json );
    RfField first = rf_field_item( list, 0 );
    bool rotates = rf_has_member( top, "rotation" ) || rf_has_member( &first, "rotation" ), linear;
    track->in_frames = rf_has_member( &first, "frame" );
    RfResult result = rf_read_interpolation( top, &linear );
    if ( result == RF_OK )
        result = rf_read_projection( top, track );
    if ( result == RF_OK )
        result = rf_check_look( top, rotates );
    if ( result == RF_OK )
        result = read_film( top, track );
    if ( result != RF_OK )
        return result;
    double* memory = calloc( (size_t)count * NUMBERS, sizeof *memory );
    if ( memory == NULL )
        return rf_fail( top->error, RF_ERROR_MEMORY, "%s: no memory left for %d keys", top->file, count );
    Keys keys = split_memory( memory, count );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        RfField key = rf_field_item( list, (size_t)i );
        result = read_key( top, &key, &keys, i, rotates, track );
    }
    for ( int i = 0; i < count && track->in_frames; ++i )
        keys.times[i] -= 1.0; // frame 1 is at time 0
    if ( result == RF_OK )
        result = make_curves( &keys, linear, rotates, track, top->error );
    track->start = keys.times[0];
    track->end = keys.times[count - 1];
    free( memory );
    RfField last = rf_field_item( list, (size_t)count - 1 ),
            field = rf_field_member( &last, track->in_frames ? "frame" : "time" );
    return result == RF_OK ? rf_name_clock( &field, track ) : result;
}

RfResult rf_read_keyed( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "interpolation", "keys",  "target", "rotation",    "up",   "projection",
                                          "fov",  "ymag",          "shift", "step",   "pixelAspect", "lens", NULL };
    RfField list = rf_field_member( top, "keys" );
    RfResult result = rf_field_keys( top, s_keys );
    if ( result == RF_OK )
        result = rf_field_array( &list, "keys", 1, MAX_KEYS );
    return result == RF_OK ? read_keys( top, &list, track ) : result;
}
