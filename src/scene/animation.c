// Samples animation channels of glTF (step, linear, cubic spline) into the matrices of nodes, and frees them.
#include "scene/animation.h"

#include "math/quat.h"
#include "scene/camera_path/curve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void rf_destroy_channel( RfChannel* channel )
{
    if ( channel->curve != NULL )
        rf_destroy_curve( channel->curve );
    free( channel->curve );
    free( channel->times );
    free( channel->values );
    memset( channel, 0, sizeof *channel );
}

// Index of the last key at or before `time`, which the caller has clamped.
static int find_key( const RfChannel* channel, double time )
{
    int low = 0, high = channel->count - 1;
    while ( low < high )
    {
        int middle = low + ( high - low + 1 ) / 2;
        if ( channel->times[middle] <= time )
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

static const double* key_value( const RfChannel* channel, int key )
{
    int n = channel->components;
    // a cubic key is in-tangent, value, out-tangent
    if ( channel->interpolation == RF_CUBICSPLINE )
        return channel->values + ( (size_t)key * 3 + 1 ) * (size_t)n;
    return channel->values + (size_t)key * (size_t)n;
}

// Cubic Hermite spline of the glTF specification, appendix C: tangents are per second, hence
// multiplied by the key spacing.
static void sample_cubic( const RfChannel* channel, int key, double t, double spacing, double* value )
{
    int n = channel->components;
    const double* v0 = key_value( channel, key );
    const double* v1 = key_value( channel, key + 1 );
    const double* out_tangent = v0 + n;
    const double* in_tangent = v1 - n;
    double t2 = t * t, t3 = t2 * t;
    for ( int i = 0; i < n; ++i )
        value[i] = ( 2.0 * t3 - 3.0 * t2 + 1.0 ) * v0[i] + spacing * ( t3 - 2.0 * t2 + t ) * out_tangent[i] +
                   ( 3.0 * t2 - 2.0 * t3 ) * v1[i] + spacing * ( t3 - t2 ) * in_tangent[i];
}

// Between equal keys, with tangents of 0, a value stands still to the last bit: frames in which nothing moves are told by that.
static bool stands_still( const RfChannel* channel, int key )
{
    size_t n = (size_t)channel->components;
    const double *v0 = key_value( channel, key ), *v1 = key_value( channel, key + 1 );
    const double *out_tangent = v0 + n, *in_tangent = v1 - n;
    for ( size_t i = 0; i < n; ++i )
    {
        bool slopes = channel->interpolation == RF_CUBICSPLINE && ( out_tangent[i] != 0.0 || in_tangent[i] != 0.0 );
        if ( v0[i] != v1[i] || slopes )
            return false;
    }
    return true;
}

static void sample_between( const RfChannel* channel, int key, double time, double* value )
{
    int n = channel->components;
    if ( stands_still( channel, key ) )
    {
        memcpy( value, key_value( channel, key ), (size_t)n * sizeof *value );
        return;
    }
    double spacing = channel->times[key + 1] - channel->times[key];
    double t = ( time - channel->times[key] ) / spacing;
    if ( channel->interpolation == RF_CUBICSPLINE )
    {
        sample_cubic( channel, key, t, spacing, value );
        return;
    }
    const double* v0 = key_value( channel, key );
    const double* v1 = key_value( channel, key + 1 );
    if ( channel->path == RF_ROTATION )
    {
        rf_quat_slerp( v0, v1, t, value );
        return;
    }
    for ( int i = 0; i < n; ++i )
        value[i] = ( 1.0 - t ) * v0[i] + t * v1[i];
}

// The time of a channel at one of the scene.
static double read_clock( const RfClock* clock, double time )
{
    if ( clock->speed == 0.0 )
        return time;
    double length = clock->last - clock->first, played = fmax( ( time - clock->start ) * clock->speed, 0.0 );
    if ( clock->loops && length > 0.0 )
        played = fmod( played, length );
    return clock->first + fmin( played, length );
}

void rf_channel_span( const RfChannel* channel, double* start, double* end )
{
    const RfClock* clock = &channel->clock;
    *start = channel->times[0];
    *end = channel->times[channel->count - 1];
    if ( clock->speed == 0.0 )
        return;
    if ( clock->loops )
    {
        *start = fmax( clock->start, 0.0 );
        *end = *start + ( clock->last - clock->first ) / clock->speed;
        return;
    }
    *start = fmax( clock->start + ( *start - clock->first ) / clock->speed, 0.0 );
    *end = fmax( clock->start + ( *end - clock->first ) / clock->speed, 0.0 );
}

// Files round the times of keys to floats, up as well as down: a value that steps at the time of a frame is that of the frame.
#define STEP_SLACK 0x1p-22

void rf_sample_channel( const RfChannel* channel, double time, double* value )
{
    time = read_clock( &channel->clock, time );
    if ( channel->curve != NULL )
    {
        rf_sample_curve( channel->curve, time, value );
        return;
    }
    int n = channel->components;
    int last = channel->count - 1;
    int key = 0;
    if ( channel->interpolation == RF_STEP )
        time += STEP_SLACK * fabs( time );
    if ( time >= channel->times[last] )
        key = last;
    else if ( time > channel->times[0] )
        key = find_key( channel, time );

    bool between = key < last && time > channel->times[key];
    if ( between && channel->interpolation != RF_STEP )
        sample_between( channel, key, time, value );
    else
        memcpy( value, key_value( channel, key ), (size_t)n * sizeof( double ) );
    // a spline between opposite keys may pass through zero, which normalises to no rotation
    if ( channel->path == RF_ROTATION )
        rf_quat_normalize( value );
}

bool rf_channel_varies( const RfChannel* channel )
{
    size_t values = (size_t)channel->components, cubic = channel->interpolation == RF_CUBICSPLINE ? 3 : 1;
    const double* first = channel->values + ( cubic == 3 ? values : 0 );
    for ( int k = 1; k < channel->count; ++k )
    {
        for ( size_t i = 0; i < values; ++i )
        {
            if ( first[(size_t)k * cubic * values + i] != first[i] )
                return true;
            if ( cubic == 1 )
                continue;
            // equal keys with tangents: out of the key before, into this one
            const double* out = channel->values + ( 3 * (size_t)k - 1 ) * values;
            if ( out[i] != 0.0 || out[values + i] != 0.0 )
                return true;
        }
    }
    return false;
}

RfResult rf_copy_channel( const RfChannel* from, RfChannel* to, RfError* error )
{
    size_t keys = (size_t)from->count, per_key = from->interpolation == RF_CUBICSPLINE && from->curve == NULL ? 3 : 1;
    size_t times = keys * sizeof *to->times, values = times * per_key * (size_t)from->components;
    *to = *from;
    to->times = malloc( times );
    to->values = malloc( values );
    to->curve = from->curve != NULL ? calloc( 1, sizeof *to->curve ) : NULL;
    if ( to->times == NULL || to->values == NULL || ( from->curve != NULL && to->curve == NULL ) )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory copying %d keys: close other programs", from->count );
    memcpy( to->times, from->times, times );
    memcpy( to->values, from->values, values );
    if ( from->curve == NULL )
        return RF_OK;
    return rf_create_curve( from->curve->kind, from->curve->linear, from->count, from->times, from->values, to->curve, error );
}

const RfChannel* rf_node_channels( const RfScene* scene, int node, int* count )
{
    int low = 0, high = scene->channel_count;
    while ( low < high )
    {
        int middle = low + ( high - low ) / 2;
        if ( scene->channels[middle].node < node )
            low = middle + 1;
        else
            high = middle;
    }
    *count = 0;
    while ( low + *count < scene->channel_count && scene->channels[low + *count].node == node )
        *count += 1;
    return *count > 0 ? scene->channels + low : NULL;
}

void rf_node_local_matrix( const RfScene* scene, int node, double time, RfMat4* matrix )
{
    const RfNode* self = scene->nodes + node;
    if ( self->has_matrix )
    {
        *matrix = self->matrix;
        return;
    }
    double trs[3][4] = { { 0 } };
    memcpy( trs[RF_TRANSLATION], self->translation, sizeof self->translation );
    memcpy( trs[RF_ROTATION], self->rotation, sizeof self->rotation );
    memcpy( trs[RF_SCALE], self->scale, sizeof self->scale );

    int count;
    const RfChannel* channels = rf_node_channels( scene, node, &count );
    for ( int i = 0; i < count && channels[i].path <= RF_SCALE; ++i )
        rf_sample_channel( channels + i, time, trs[channels[i].path] );
    *matrix = rf_mat4_from_trs( trs[RF_TRANSLATION], trs[RF_ROTATION], trs[RF_SCALE] );
}
