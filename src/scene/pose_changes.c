// Poses lamps, materials and the sky.
#include "scene/pose_changes.h"

#include "base/file.h"
#include "scene/deformation.h"
#include "scene/movement.h"
#include "scene/textured.h"

#include <math.h>
#include <string.h>

// Lamps.

static RfResult fail_lamp( const RfScene* scene, const RfPunctual* lamp, double time, const char* what, RfError* error )
{
    return rf_fail( error, RF_ERROR_SCENE, "%s: light '%.80s' at %g s: %s", scene->path, lamp->name, time, what );
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
            return "it is too far from the origin: scale the scene down";
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
    RfLampValues now = lamp->values;
    const double *color = now.color, *cone = now.cone;
    if ( lamp->node >= 0 && !nodes->shown[lamp->node] )
    {
        out->intensity = rf_vec3( 0.0f, 0.0f, 0.0f );
        return NULL;
    }
    for ( int v = 0; v < RF_CHANGED_LAMP_VALUES; ++v )
    {
        double all[4];
        if ( lamp->changes[v] < 0 )
            continue;
        rf_sample_change( movement->changes + lamp->changes[v], nodes->time, all );
        memcpy( rf_value_in( &now, (RfChangedValue)v ), all,
                (size_t)rf_changed_traits( (RfChangedValue)v )->components * sizeof *all );
    }
    out->intensity =
        rf_vec3( (float)( color[0] * now.intensity ), (float)( color[1] * now.intensity ), (float)( color[2] * now.intensity ) );
    out->range = (float)fmin( now.range, HUGE_VAL );
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
    const RfChangedTraits* traits = rf_changed_traits( change->value );
    void* values = traits->owner == RF_OF_TEXTURE ? (void*)to->transform[change->slot] : (void*)&to->values;
    rf_sample_change( change, time, v );
    memcpy( rf_value_in( values, change->value ), v, (size_t)traits->components * sizeof *v );
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
        out->emission = rf_emission_of( &now.values );
    if ( !out->changes || out->textured == NULL )
        return;
    *textured = *out->textured;
    out->textured = textured;
    if ( textured->model == RF_TEXTURED_DIFFUSE ) // which has a base of its own
        memcpy( now.values.lobes.base, textured->factors.base, 3 * sizeof *now.values.lobes.base );
    textured->factors = now.values.lobes;
    for ( int i = 0; i < self->change_count; ++i )
    {
        if ( rf_changed_traits( changes[i].value )->owner == RF_OF_TEXTURE )
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
    posed->environment.radiance = scene->environment.radiance;
    for ( int i = 0; scene->environment.changes && i < movement->change_count; ++i )
    {
        const RfChange* change = movement->changes + i;
        double v[4];
        if ( !rf_is_of_sky( change->value ) )
            continue;
        rf_sample_change( change, time, v );
        rf_change_sky( &posed->environment, change->value, v );
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
