// What may change, its values over time, and the list of it.
#include "scene/movement.h"

#include "scene/animation.h"
#include "scene/image_sequence.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

const RfChangedTraits* rf_changed_traits( RfChangedValue value )
{
    static const RfChangedTraits s_traits[RF_CHANGED_COUNT] = {
        [RF_CHANGED_INTENSITY] = { "intensity", 1, 0, 1e9, false, true },
        [RF_CHANGED_COLOR] = { "color", 3, 0, 1, false, false },
        [RF_CHANGED_RANGE] = { "range", 1, 0, HUGE_VAL, true, false },
        [RF_CHANGED_INNER_CONE] = { "innerConeAngle", 1, 0, 0.5 * PI + 1e-6, false, false },
        [RF_CHANGED_OUTER_CONE] = { "outerConeAngle", 1, 0, 0.5 * PI + 1e-6, true, false },
        [RF_CHANGED_BASE_COLOR] = { "baseColorFactor", 4, 0, 1, false, false },
        [RF_CHANGED_METALLIC] = { "metallicFactor", 1, 0, 1, false, false },
        [RF_CHANGED_ROUGHNESS] = { "roughnessFactor", 1, 0, 1, false, false },
        [RF_CHANGED_EMISSIVE] = { "emissiveFactor", 3, 0, 1, false, false },
        [RF_CHANGED_EMISSIVE_STRENGTH] = { "emissiveStrength", 1, 0, 1e15, false, true },
        [RF_CHANGED_TEXTURE_OFFSET] = { "offset", 2, -1e6, 1e6, false, true },
        [RF_CHANGED_TEXTURE_ROTATION] = { "rotation", 1, -HUGE_VAL, HUGE_VAL, false, false },
        [RF_CHANGED_TEXTURE_SCALE] = { "scale", 2, -1e6, 1e6, false, true },
        [RF_CHANGED_SKY_STRENGTH] = { "strength", 1, 0, HUGE_VAL, false, false },
        [RF_CHANGED_SKY_RADIANCE] = { "radiance", 3, 0, HUGE_VAL, false, false },
        [RF_CHANGED_SKY_ROTATION] = { "rotation", 1, -HUGE_VAL, HUGE_VAL, false, false },
        [RF_CHANGED_YFOV] = { "yfov", 1, 0, PI, true, false },
        [RF_CHANGED_YMAG] = { "ymag", 1, 0, 1e12, true, false },
    };
    return s_traits + value;
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
    size_t count = movement != NULL ? (size_t)movement->change_count : 0;
    RfChange* grown = movement != NULL ? realloc( movement->changes, ( count + 1 ) * sizeof *grown ) : NULL;
    if ( grown == NULL )
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
    movement->changes = grown;
    movement->changes[movement->change_count++] = *change;
    return true;
}

bool rf_add_sequence( RfScene* scene, RfImageSequence* sequence )
{
    RfMovement* movement = rf_open_movement( scene );
    size_t count = movement != NULL ? (size_t)movement->sequence_count : 0;
    RfImageSequence* grown = movement != NULL ? realloc( movement->sequences, ( count + 1 ) * sizeof *grown ) : NULL;
    if ( grown == NULL )
    {
        free( sequence->pattern );
        return false;
    }
    double start, end;
    rf_sequence_span( sequence, &start, &end );
    widen( movement, start, end );
    movement->sequences = grown;
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

void rf_destroy_movement( RfMovement* movement )
{
    if ( movement == NULL )
        return;
    for ( int i = 0; movement->skins != NULL && i < movement->skin_count; ++i )
    {
        free( movement->skins[i].joints );
        free( movement->skins[i].inverse_binds );
    }
    for ( int i = 0; movement->movers != NULL && i < movement->mover_count; ++i )
        free( movement->movers[i].weights );
    for ( int i = 0; movement->changes != NULL && i < movement->change_count; ++i )
        rf_destroy_channel( &movement->changes[i].channel );
    for ( int i = 0; movement->sequences != NULL && i < movement->sequence_count; ++i )
        free( movement->sequences[i].pattern );
    free( movement->sequences );
    free( movement->lamps );
    free( movement->materials );
    free( movement->changes );
    free( movement->nodes );
    free( movement->skins );
    free( movement->movers );
    free( movement );
}
