// What may change, its values over time (channels of glTF: step, linear, cubic spline), the matrices of nodes, and the list of it.
#include "scene/movement.h"

#include "math/quat.h"
#include "scene/camera_path/curve.h"
#include "scene/texture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
        key = rf_last_not_above( channel->times, last, time );

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

#define PI 3.14159265358979323846

#define LAMP( member ) RF_OF_LAMP, offsetof( RfLampValues, member )
#define MATERIAL( member ) RF_OF_MATERIAL, offsetof( RfMaterialValues, member )
#define TEXTURE( number ) RF_OF_TEXTURE, number * sizeof( double )
#define ANY HUGE_VAL
#define SAME 0, 0 // the range in scene files

#define PBR "pbrMetallicRoughness"
#define SPECULAR "KHR_materials_specular"
#define VOLUME "KHR_materials_volume"
#define COAT "KHR_materials_clearcoat"
#define SHEEN "KHR_materials_sheen"
#define THROUGH "KHR_materials_diffuse_transmission"
#define TURNED "KHR_materials_anisotropy"
#define FILM "KHR_materials_iridescence"
#define SCATTER "KHR_materials_volume_scatter"

enum
{
    ABOVE = RF_VALUE_ABOVE,
    LIMIT = RF_VALUE_LIMITED,
    MOVES = RF_VALUE_ANIMATED,
    KEYED = RF_VALUE_ANIMATED | RF_VALUE_IN_FILE | RF_VALUE_KEYED,
    MODEL = RF_VALUE_OF_MODEL,
    STILL = RF_VALUE_IN_FILE | RF_VALUE_OF_MODEL,
};

// Name, place, home, components, range in glTF, flags, word, and where it differs the range in scene files.
static const RfChangedTraits s_traits[RF_CHANGED_COUNT] = {
    [RF_CHANGED_INTENSITY] = { "intensity", LAMP( intensity ), NULL, 1, 0, 1e9, MOVES | LIMIT, "intensity", SAME },
    [RF_CHANGED_COLOR] = { "color", LAMP( color ), NULL, 3, 0, 1, MOVES, "colour", SAME },
    [RF_CHANGED_RANGE] = { "range", LAMP( range ), NULL, 1, 0, ANY, MOVES | ABOVE, "range", SAME },
    [RF_CHANGED_INNER_CONE] = { "innerConeAngle", LAMP( cone[0] ), "spot", 1, 0, 0.5 * PI + 1e-6, MOVES, "cone", SAME },
    [RF_CHANGED_OUTER_CONE] = { "outerConeAngle", LAMP( cone[1] ), "spot", 1, 0, 0.5 * PI + 1e-6, MOVES | ABOVE, "cone", SAME },
    [RF_CHANGED_BASE_COLOR] = { "baseColorFactor", MATERIAL( lobes.base ), PBR, 4, 0, 1, KEYED | MODEL, "base colour", SAME },
    [RF_CHANGED_METALLIC] = { "metallicFactor", MATERIAL( lobes.metallic ), PBR, 1, 0, 1, KEYED | MODEL, "metallic", SAME },
    [RF_CHANGED_ROUGHNESS] = { "roughnessFactor", MATERIAL( lobes.roughness ), PBR, 1, 0, 1, KEYED | MODEL, "roughness", SAME },
    [RF_CHANGED_EMISSIVE] = { "emissiveFactor", MATERIAL( emissive ), NULL, 3, 0, 1, KEYED, "emission", SAME },
    [RF_CHANGED_EMISSIVE_STRENGTH] = { "emissiveStrength", MATERIAL( strength ), "KHR_materials_emissive_strength", 1, 0, 1e15,
                                       KEYED | LIMIT, "emission", SAME },
    [RF_CHANGED_SPECULAR] = { "specularFactor", MATERIAL( lobes.specular ), SPECULAR, 1, 0, 1, STILL, NULL, SAME },
    // a colour may exceed one: the resulting reflectance is clamped
    [RF_CHANGED_SPECULAR_COLOR] = { "specularColorFactor", MATERIAL( lobes.specular_color ), SPECULAR, 3, 0, ANY, STILL, NULL, 0,
                                    1e6 },
    [RF_CHANGED_IOR] = { "ior", MATERIAL( lobes.ior ), "KHR_materials_ior", 1, 0, ANY, STILL, NULL, 1, 100 },
    [RF_CHANGED_TRANSMISSION] = { "transmissionFactor", MATERIAL( transmission ), "KHR_materials_transmission", 1, 0, 1, STILL,
                                  NULL, SAME },
    [RF_CHANGED_THICKNESS] = { "thicknessFactor", MATERIAL( thickness ), VOLUME, 1, 0, ANY, STILL, NULL, 0, 1e15 },
    [RF_CHANGED_ATTENUATION_DISTANCE] = { "attenuationDistance", MATERIAL( attenuation_distance ), VOLUME, 1, 0, ANY,
                                          STILL | ABOVE, NULL, 1e-15, 1e15 },
    [RF_CHANGED_ATTENUATION_COLOR] = { "attenuationColor", MATERIAL( attenuation_color ), VOLUME, 3, 0, 1, STILL, NULL, SAME },
    [RF_CHANGED_CLEARCOAT] = { "clearcoatFactor", MATERIAL( clearcoat ), COAT, 1, 0, 1, STILL, NULL, SAME },
    [RF_CHANGED_CLEARCOAT_ROUGHNESS] = { "clearcoatRoughnessFactor", MATERIAL( clearcoat_roughness ), COAT, 1, 0, 1, STILL, NULL,
                                         SAME },
    [RF_CHANGED_SHEEN_COLOR] = { "sheenColorFactor", MATERIAL( lobes.sheen_color ), SHEEN, 3, 0, 1, STILL, NULL, SAME },
    [RF_CHANGED_SHEEN_ROUGHNESS] = { "sheenRoughnessFactor", MATERIAL( lobes.sheen_roughness ), SHEEN, 1, 0, 1, STILL, NULL,
                                     SAME },
    [RF_CHANGED_THROUGH] = { "diffuseTransmissionFactor", MATERIAL( lobes.through ), THROUGH, 1, 0, 1, STILL, NULL, SAME },
    [RF_CHANGED_THROUGH_COLOR] = { "diffuseTransmissionColorFactor", MATERIAL( lobes.through_color ), THROUGH, 3, 0, 1, STILL,
                                   NULL, SAME },
    [RF_CHANGED_ANISOTROPY] = { "anisotropyStrength", MATERIAL( lobes.anisotropy ), TURNED, 1, 0, 1, 0, NULL, SAME },
    [RF_CHANGED_ANISOTROPY_ROTATION] = { "anisotropyRotation", MATERIAL( lobes.anisotropy_rotation ), TURNED, 1, -1e6, 1e6, LIMIT,
                                         NULL, SAME },
    [RF_CHANGED_FILM] = { "iridescenceFactor", MATERIAL( lobes.film ), FILM, 1, 0, 1, 0, NULL, SAME },
    [RF_CHANGED_FILM_IOR] = { "iridescenceIor", MATERIAL( lobes.film_ior ), FILM, 1, 1, 100, 0, NULL, SAME },
    [RF_CHANGED_FILM_LEAST] = { "iridescenceThicknessMinimum", MATERIAL( lobes.film_least ), FILM, 1, 0, 1e5, 0, NULL,
                                SAME }, // nm
    [RF_CHANGED_FILM_MOST] = { "iridescenceThicknessMaximum", MATERIAL( lobes.film_most ), FILM, 1, 0, 1e5, 0, NULL, SAME },
    [RF_CHANGED_DISPERSION] = { "dispersion", MATERIAL( lobes.dispersion ), "KHR_materials_dispersion", 1, 0, 1e6, LIMIT, NULL,
                                SAME },
    [RF_CHANGED_MULTISCATTER] = { "multiscatterColor", MATERIAL( multiscatter ), SCATTER, 3, 0, 1, 0, NULL, SAME },
    [RF_CHANGED_SCATTER_ANISOTROPY] = { "scatterAnisotropy", MATERIAL( scatter_anisotropy ), SCATTER, 1, -ANY, ANY, 0, NULL,
                                        SAME },
    [RF_CHANGED_ALPHA_CUTOFF] = { "alphaCutoff", MATERIAL( alpha_cutoff ), NULL, 1, 0, ANY, RF_VALUE_IN_FILE, NULL, 0, 1e6 },
    [RF_CHANGED_TEXTURE_OFFSET] = { "offset", TEXTURE( 0 ), NULL, 2, -1e6, 1e6, MOVES | LIMIT, NULL, SAME },
    [RF_CHANGED_TEXTURE_ROTATION] = { "rotation", TEXTURE( 2 ), NULL, 1, -ANY, ANY, MOVES, NULL, SAME },
    [RF_CHANGED_TEXTURE_SCALE] = { "scale", TEXTURE( 3 ), NULL, 2, -1e6, 1e6, MOVES | LIMIT, NULL, SAME },
    [RF_CHANGED_SKY_STRENGTH] = { "strength", RF_OF_SKY, 0, NULL, 1, 0, ANY, 0, "strength", 0, 1e15 },
    [RF_CHANGED_SKY_RADIANCE] = { "radiance", RF_OF_SKY, 0, NULL, 3, 0, ANY, 0, "radiance", 0, 1e15 },
    [RF_CHANGED_SKY_ROTATION] = { "rotation", RF_OF_SKY, 0, NULL, 1, -ANY, ANY, RF_VALUE_DEGREES, "rotation", -1e6, 1e6 },
    [RF_CHANGED_YFOV] = { "yfov", RF_OF_CAMERA, 0, "perspective", 1, 0, PI, MOVES | ABOVE, "field of view", SAME },
    [RF_CHANGED_YMAG] = { "ymag", RF_OF_CAMERA, 0, "orthographic", 1, 0, 1e12, MOVES | ABOVE, "field of view", SAME },
};

const RfChangedTraits* rf_changed_traits( RfChangedValue value ) { return s_traits + value; }

RfChangedValue rf_next_value( RfValueOwner owner, int value )
{
    do
        ++value;
    while ( value < RF_CHANGED_COUNT && s_traits[value].owner != owner );
    return (RfChangedValue)value;
}

void rf_member_path( const char* home, const char* name, char path[RF_VALUE_PATH] )
{
    const char* before = home != NULL && strncmp( home, "KHR_", 4 ) == 0 ? "extensions/" : "";
    snprintf( path, RF_VALUE_PATH, "%s%s%s%s", before, home != NULL ? home : "", home != NULL ? "/" : "", name );
}

void rf_change_sky( RfEnvironment* sky, RfChangedValue value, const double* v )
{
    if ( value == RF_CHANGED_SKY_STRENGTH )
        sky->radiance = rf_scale( sky->radiance, (float)v[0] );
    else if ( value == RF_CHANGED_SKY_RADIANCE )
        sky->radiance = rf_mul( sky->radiance, rf_vec3_of( v, 1.0 ) );
    else
        sky->rotation = (float)fmod( v[0], 2.0 * PI );
}

void rf_sample_change( const RfChange* change, double time, double value[4] )
{
    const RfChangedTraits* traits = rf_changed_traits( change->value );
    rf_sample_channel( &change->channel, time, value );
    for ( int i = 0; i < traits->components; ++i )
        value[i] = fmin( fmax( value[i], traits->low ), traits->high );
}

// The largest value of one component of a cubic spline between two keys: at one of them, or where its derivative is 0.
static double most_between( double v0, double slope0, double v1, double slope1 )
{
    double most = fmax( v0, v1 );
    // v(t) = a t³ + b t² + c t + v0
    double a = 2.0 * ( v0 - v1 ) + slope0 + slope1, b = 3.0 * ( v1 - v0 ) - 2.0 * slope0 - slope1, c = slope0;
    double root = b * b - 3.0 * a * c;
    if ( !( root >= 0.0 ) )
        return most;
    double q = -( b + copysign( sqrt( root ), b ) );
    double turns[2] = { a != 0.0 ? q / ( 3.0 * a ) : 0.0, q != 0.0 ? c / q : 0.0 }; // of degree 2, one; of less, none
    for ( int k = 0; k < 2; ++k )
    {
        double t = turns[k];
        if ( t > 0.0 && t < 1.0 )
            most = fmax( most, ( ( a * t + b ) * t + c ) * t + v0 );
    }
    return most;
}

void rf_most_of_change( const RfChange* change, double most[4] )
{
    const RfChannel* channel = &change->channel;
    const RfChangedTraits* traits = rf_changed_traits( change->value );
    bool cubic = channel->interpolation == RF_CUBICSPLINE;
    size_t n = (size_t)channel->components, per_key = cubic ? 3 * n : n;
    for ( size_t i = 0; i < n; ++i )
    {
        const double* value = channel->values + ( cubic ? n : 0 ) + i;
        most[i] = value[0];
        for ( size_t k = 1; k < (size_t)channel->count; ++k )
        {
            const double *v0 = value + ( k - 1 ) * per_key, *v1 = v0 + per_key;
            double spacing = channel->times[k] - channel->times[k - 1];
            double between = cubic ? most_between( *v0, spacing * v0[n], *v1, spacing * *( v1 - n ) ) : *v1;
            most[i] = fmax( most[i], between );
        }
        most[i] = fmin( most[i], traits->high );
    }
}

static bool is_empty( const RfMovement* m )
{
    return m->mover_count == 0 && m->lamp_count == 0 && m->change_count == 0 && m->sequence_count == 0;
}

RfMovement* rf_open_movement( RfScene* scene )
{
    if ( scene->movement == NULL )
        scene->movement = calloc( 1, sizeof *scene->movement );
    return scene->movement;
}

static void widen( RfMovement* movement, double start, double end )
{
    bool first = is_empty( movement );
    movement->start = first ? start : fmin( movement->start, start );
    movement->end = first ? end : fmax( movement->end, end );
}

bool rf_add_change( RfScene* scene, RfChange* change )
{
    RfMovement* movement = rf_open_movement( scene );
    if ( movement == NULL || !rf_make_room( &movement->changes, (size_t)movement->change_count, sizeof *movement->changes ) )
    {
        rf_destroy_channel( &change->channel );
        return false;
    }
    double start, end;
    rf_channel_span( &change->channel, &start, &end );
    widen( movement, start, end );
    bool others = scene->change_end > scene->change_start;
    scene->change_start = others ? fmin( scene->change_start, start ) : start;
    scene->change_end = others ? fmax( scene->change_end, end ) : end;
    movement->changes[movement->change_count++] = *change;
    return true;
}

bool rf_add_sequence( RfScene* scene, RfImageSequence* sequence )
{
    RfMovement* movement = rf_open_movement( scene );
    if ( movement == NULL ||
         !rf_make_room( &movement->sequences, (size_t)movement->sequence_count, sizeof *movement->sequences ) )
    {
        free( sequence->pattern );
        return false;
    }
    double start, end;
    rf_sequence_span( sequence, &start, &end );
    widen( movement, start, end );
    movement->sequences[movement->sequence_count++] = *sequence;
    return true;
}

void rf_drop_empty_movement( RfScene* scene )
{
    if ( scene->movement == NULL || !is_empty( scene->movement ) )
        return;
    rf_destroy_movement( scene->movement );
    scene->movement = NULL;
}
