// Poses lamps, materials and the sky.
#include "scene/pose_changes.h"

#include "base/file.h"
#include "scene/deformation.h"
#include "scene/movement.h"
#include "scene/textured.h"

#include <math.h>
#include <string.h>

#define TURN 6.28318530717958648

// Lamps.

static RfResult fail_lamp( const RfScene* scene, const RfPunctual* lamp, double time, const char* what, RfError* error )
{
    return rf_fail( error, RF_ERROR_SCENE, "%s: light '%.80s' at %g s: %s", scene->path, lamp->name, time, what );
}

static void sample_lamp_value( const RfMovement* movement, const RfMovingLamp* lamp, RfChangedValue value, double time,
                               double* out )
{
    double all[4];
    if ( lamp->changes[value] < 0 )
        return;
    rf_sample_change( movement->changes + lamp->changes[value], time, all );
    memcpy( out, all, (size_t)rf_changed_traits( value )->components * sizeof *out );
}

// At the origin of the node, pointing along −z.
static const char* place_lamp( const RfScene* scene, const RfMat4* world, RfPunctual* out )
{
    const double *m = world->m, *origin = scene->origin;
    double at[3];
    for ( int c = 0; c < 3; ++c )
    {
        at[c] = m[12 + c] - origin[c];
        // written so that NaN fails
        if ( !( fabs( at[c] ) <= RF_MAX_COORDINATE ) )
            return "it lies too far out: scale the scene down";
    }
    out->position = rf_vec3( (float)at[0], (float)at[1], (float)at[2] );
    if ( out->kind == RF_PUNCTUAL_POINT && !out->turned )
        return NULL;
    return rf_turn_lamp( m, out ) ? NULL : "it has no direction: remove zero scales from its node and from its parents";
}

// Returns what is wrong, or NULL. One that is hidden is where it was loaded.
static const char* pose_lamp( const RfScene* scene, const RfMovingLamp* lamp, const RfNodesAt* nodes, RfPunctual* out )
{
    const RfMovement* movement = scene->movement;
    double time = nodes->time, color[3], intensity = lamp->intensity, cone[2] = { lamp->cone[0], lamp->cone[1] },
           range = (double)out->range;
    if ( lamp->node >= 0 && !nodes->shown[lamp->node] )
    {
        out->intensity = rf_vec3( 0.0f, 0.0f, 0.0f );
        return NULL;
    }
    memcpy( color, lamp->color, sizeof color );
    sample_lamp_value( movement, lamp, RF_CHANGED_INTENSITY, time, &intensity );
    sample_lamp_value( movement, lamp, RF_CHANGED_COLOR, time, color );
    sample_lamp_value( movement, lamp, RF_CHANGED_RANGE, time, &range );
    sample_lamp_value( movement, lamp, RF_CHANGED_INNER_CONE, time, cone );
    sample_lamp_value( movement, lamp, RF_CHANGED_OUTER_CONE, time, cone + 1 );
    out->intensity = rf_vec3( (float)( color[0] * intensity ), (float)( color[1] * intensity ), (float)( color[2] * intensity ) );
    out->range = (float)fmin( range, HUGE_VAL );
    if ( !( out->range > 0.0f ) )
        return "its range is not more than 0";
    if ( out->kind == RF_PUNCTUAL_SPOT && !( cone[0] <= cone[1] && cone[1] > 0.0 ) )
        return "the inner angle of its cone is larger than the outer, which must be more than 0";
    if ( out->kind == RF_PUNCTUAL_SPOT )
        rf_set_cone( out, cone[0], cone[1] );
    return lamp->node >= 0 ? place_lamp( scene, nodes->worlds + lamp->node, out ) : NULL;
}

static RfResult pose_lamps( const RfScene* scene, const RfNodesAt* nodes, RfScene* posed, RfError* error )
{
    const RfMovement* movement = scene->movement;
    if ( movement->lamp_count == 0 )
        return RF_OK;
    memcpy( posed->punctuals, scene->punctuals, (size_t)scene->punctual_count * sizeof *posed->punctuals );
    for ( int i = 0; i < movement->lamp_count; ++i )
    {
        const RfMovingLamp* lamp = movement->lamps + i;
        RfPunctual* out = posed->punctuals + lamp->punctual;
        const char* wrong = pose_lamp( scene, lamp, nodes, out );
        if ( wrong != NULL )
            return fail_lamp( scene, out, nodes->time, wrong, error );
    }
    return RF_OK;
}

static uint64_t hash_lamp( const RfScene* scene, const RfMovingLamp* lamp, const RfNodesAt* nodes, uint64_t hash )
{
    RfPunctual posed = scene->punctuals[lamp->punctual];
    pose_lamp( scene, lamp, nodes, &posed );
    hash = rf_hash_bytes( hash, &posed.intensity, sizeof posed.intensity );
    if ( !( rf_max_component( posed.intensity ) > 0.0f ) )
        return hash;
    float rest[12] = { posed.position.x,  posed.position.y,  posed.position.z, posed.direction.x,
                       posed.direction.y, posed.direction.z, posed.cos_inner,  posed.cos_outer,
                       posed.range,       posed.across.x,    posed.across.y,   posed.across.z };
    return rf_hash_bytes( hash, rest, sizeof rest );
}

// Materials.

static void sample_materials_change( const RfChange* change, double time, RfMovingMaterial* to )
{
    double v[4];
    double* transform = to->transform[change->slot];
    rf_sample_change( change, time, v );
    switch ( change->value )
    {
        case RF_CHANGED_BASE_COLOR: memcpy( to->base, v, sizeof to->base ); break;
        case RF_CHANGED_METALLIC: to->metallic = v[0]; break;
        case RF_CHANGED_ROUGHNESS: to->roughness = v[0]; break;
        case RF_CHANGED_EMISSIVE: memcpy( to->emissive, v, sizeof to->emissive ); break;
        case RF_CHANGED_EMISSIVE_STRENGTH: to->strength = v[0]; break;
        case RF_CHANGED_TEXTURE_OFFSET: memcpy( transform, v, 2 * sizeof *transform ); break;
        case RF_CHANGED_TEXTURE_ROTATION: transform[2] = v[0]; break;
        case RF_CHANGED_TEXTURE_SCALE: memcpy( transform + 3, v, 2 * sizeof *transform ); break;
        default: break; // not of a material
    }
}

static bool is_of_texture( RfChangedValue value )
{
    return value == RF_CHANGED_TEXTURE_OFFSET || value == RF_CHANGED_TEXTURE_ROTATION || value == RF_CHANGED_TEXTURE_SCALE;
}

static void pose_material( const RfScene* scene, const RfMovingMaterial* self, double time, RfTextured* textured,
                           RfMaterial* out )
{
    RfMovingMaterial now = *self;
    const RfChange* changes = scene->movement->changes + self->first_change;
    for ( int i = 0; i < self->change_count; ++i )
        sample_materials_change( changes + i, time, &now );
    // a loaded one is the most that there is, and 0 where emission is left out
    if ( rf_max_component( out->emission ) > 0.0f )
        out->emission = rf_vec3( (float)( now.emissive[0] * now.strength ), (float)( now.emissive[1] * now.strength ),
                                 (float)( now.emissive[2] * now.strength ) );
    if ( !out->changes || out->textured == NULL )
        return;
    *textured = *out->textured;
    out->textured = textured;
    if ( textured->model != RF_TEXTURED_DIFFUSE ) // which has a base of its own
        memcpy( textured->factors.base, now.base, 3 * sizeof *now.base );
    textured->factors.base[3] = now.base[3];
    textured->factors.metallic = now.metallic;
    textured->factors.roughness = now.roughness;
    for ( int i = 0; i < self->change_count; ++i )
    {
        if ( is_of_texture( changes[i].value ) )
            rf_set_uv_transform( now.transform[changes[i].slot], textured->refs[changes[i].slot].transform );
    }
    RfVec3 emission = out->emission;
    rf_derive_material( out );
    if ( !( rf_max_component( scene->materials[self->material].emission ) > 0.0f ) )
        out->emission = emission;
}

static void pose_materials( const RfScene* scene, double time, RfTextured* textured, RfScene* posed )
{
    const RfMovement* movement = scene->movement;
    if ( movement->material_count == 0 )
        return;
    memcpy( posed->materials, scene->materials, scene->material_count * sizeof *posed->materials );
    for ( int i = 0; i < movement->material_count; ++i )
    {
        const RfMovingMaterial* self = movement->materials + i;
        pose_material( scene, self, time, textured + i, posed->materials + self->material );
    }
}

// The sky.

static void pose_sky( const RfScene* scene, double time, RfScene* posed )
{
    const RfMovement* movement = scene->movement;
    RfVec3* radiance = &posed->environment.radiance;
    *radiance = scene->environment.radiance;
    for ( int i = 0; scene->environment.changes && i < movement->change_count; ++i )
    {
        const RfChange* change = movement->changes + i;
        double v[4];
        if ( !rf_is_of_sky( change->value ) )
            continue;
        rf_sample_change( change, time, v );
        if ( change->value == RF_CHANGED_SKY_STRENGTH )
            *radiance = rf_scale( *radiance, (float)v[0] );
        else if ( change->value == RF_CHANGED_SKY_RADIANCE )
            *radiance = rf_mul( *radiance, rf_vec3( (float)v[0], (float)v[1], (float)v[2] ) );
        else
            posed->environment.rotation = (float)fmod( v[0], TURN );
    }
}

RfResult rf_pose_changes( const RfScene* scene, const RfNodesAt* nodes, RfLayout* layout, RfScene* posed, RfError* error )
{
    const RfMovement* movement = scene->movement;
    RfTextured* textured = rf_take( layout, (size_t)movement->material_count, sizeof *textured );
    if ( movement->lamp_count > 0 )
        RF_PLACE( layout, posed->punctuals, scene->punctual_count );
    if ( movement->material_count > 0 )
        RF_PLACE( layout, posed->materials, scene->material_count );
    if ( layout->memory == NULL )
        return RF_OK;
    RfResult result = pose_lamps( scene, nodes, posed, error );
    if ( result == RF_OK )
        pose_materials( scene, nodes->time, textured, posed );
    if ( result == RF_OK )
        pose_sky( scene, nodes->time, posed );
    return result;
}

uint64_t rf_hash_changes( const RfScene* scene, const RfNodesAt* nodes, uint64_t hash )
{
    const RfMovement* movement = scene->movement;
    for ( int i = 0; i < movement->lamp_count; ++i )
        hash = hash_lamp( scene, movement->lamps + i, nodes, hash );
    for ( int i = 0; i < movement->change_count; ++i )
    {
        const RfChange* change = movement->changes + i;
        double v[4];
        if ( change->value <= RF_CHANGED_OUTER_CONE )
            continue;
        rf_sample_change( change, nodes->time, v );
        hash = rf_hash_bytes( hash, v, (size_t)rf_changed_traits( change->value )->components * sizeof *v );
    }
    return hash;
}
