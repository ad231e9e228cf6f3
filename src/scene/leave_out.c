// Effects that are left out: the scene becomes one without them. What changes no picture (panes aside) is left to the tracer
// and the estimator, and the camera's lens and shutter to its path.
#include "scene/leave_out.h"

#include "scene/merge.h"
#include "scene/movement.h"
#include "scene/textured.h"

#include <stdlib.h>
#include <string.h>

static bool leaves( uint64_t set, RfEffectId effect ) { return ( set & RF_EFFECT_BIT( effect ) ) != 0; }

static const RfVec3 s_black = { 0.0f, 0.0f, 0.0f };

// Vertices of their own for all triangles, with the normals of these.
static RfResult make_flat( RfTriangles* t, RfError* error )
{
    if ( !rf_spread_vertices( t ) )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the vertices of %u triangles", t->count );
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        const float* p = t->positions + 9 * (size_t)i;
        RfVec3 p0 = rf_vec3( p[0], p[1], p[2] ), e1 = rf_sub( rf_vec3( p[3], p[4], p[5] ), p0 ),
               e2 = rf_sub( rf_vec3( p[6], p[7], p[8] ), p0 );
        double twice;
        RfVec3 n = rf_unit_cross( e1, e2, &twice );
        float face[3] = { n.x, n.y, n.z };
        for ( int k = 0; twice > 0.0 && k < 3; ++k )
            memcpy( t->normals + 9 * (size_t)i + 3 * k, face, sizeof face );
    }
    return RF_OK;
}

// With the same diffuse part.
static void make_lambert( RfMaterial* m )
{
    m->kind = RF_BSDF_LAMBERT;
    m->specular = s_black;
}

// Without normal maps (`normals`), or without all other textures.
static void remove_textures( RfMaterial* m, bool normals )
{
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
    {
        if ( ( i == RF_TEXTURE_NORMAL || i == RF_TEXTURE_CLEARCOAT_NORMAL ) == normals )
            m->textured->refs[i].texture = -1;
    }
}

static void leave_out_of_textured( uint64_t set, RfMaterial* m )
{
    if ( leaves( set, RF_EFFECT_TEXTURES ) )
        remove_textures( m, false );
    if ( leaves( set, RF_EFFECT_NORMAL_MAPS ) || leaves( set, RF_EFFECT_TEXTURES ) )
        remove_textures( m, true );
    if ( leaves( set, RF_EFFECT_VERTEX_COLORS ) )
        m->textured->vertex_colors = false;
    if ( leaves( set, RF_EFFECT_ALPHA_BLEND ) )
        m->textured->blended = false;
    if ( leaves( set, RF_EFFECT_ALPHA_MASK ) )
        m->textured->masked = false;
}

static void leave_out_of_glass( uint64_t set, RfMaterial* m )
{
    bool mirror = m->ior == 0.0f;
    if ( mirror && leaves( set, RF_EFFECT_MIRRORS ) )
        make_lambert( m );
    if ( !mirror && leaves( set, RF_EFFECT_TRANSMISSION ) )
    {
        m->diffuse = rf_add( m->diffuse, m->tint );
        m->tint = s_black;
        if ( m->textured != NULL )
            m->textured->transmission = 0.0;
    }
    if ( leaves( set, RF_EFFECT_ABSORPTION ) )
        m->absorption = s_black;
    if ( leaves( set, RF_EFFECT_DISPERSION ) )
        m->dispersion = 0.0f;
    if ( leaves( set, RF_EFFECT_IRIDESCENCE ) )
        m->film = 0.0f;
    if ( m->kind == RF_BSDF_SPECTRAL && !( m->dispersion > 0.0f ) && !( m->film > 0.0f ) )
        m->kind = RF_BSDF_GLASS;
}

// GGX without some of what lies over it or changes its lobe.
static void leave_out_layers( uint64_t set, RfMaterial* m )
{
    const uint64_t layers = RF_EFFECT_BIT( RF_EFFECT_CLEARCOAT ) | RF_EFFECT_BIT( RF_EFFECT_SHEEN ) |
                            RF_EFFECT_BIT( RF_EFFECT_ANISOTROPY ) | RF_EFFECT_BIT( RF_EFFECT_IRIDESCENCE );
    if ( ( set & layers ) == 0 )
        return;
    if ( leaves( set, RF_EFFECT_CLEARCOAT ) )
        m->clearcoat = 0.0f;
    if ( leaves( set, RF_EFFECT_CLEARCOAT ) && m->textured != NULL )
        m->textured->clearcoat = 0.0;
    if ( leaves( set, RF_EFFECT_SHEEN ) )
        m->sheen = s_black;
    if ( leaves( set, RF_EFFECT_ANISOTROPY ) )
        m->anisotropy = 0.0f;
    if ( leaves( set, RF_EFFECT_IRIDESCENCE ) )
        m->film = 0.0f;
    rf_choose_layers( m );
}

static void leave_out_of_material( uint64_t set, RfMaterial* m )
{
    if ( m->kind > RF_BSDF_GGX && m->kind <= RF_BSDF_LAYERED )
        leave_out_layers( set, m );
    if ( m->kind == RF_BSDF_TRANSLUCENT && ( leaves( set, RF_EFFECT_DIFFUSE_TRANSMISSION ) || leaves( set, RF_EFFECT_GGX ) ) )
        m->kind = RF_BSDF_GGX;
    if ( ( m->kind == RF_BSDF_PHONG && leaves( set, RF_EFFECT_PHONG ) ) ||
         ( rf_is_ggx( m->kind ) && leaves( set, RF_EFFECT_GGX ) ) )
        make_lambert( m );
    if ( m->kind >= RF_BSDF_FIRST_SPECULAR )
        leave_out_of_glass( set, m );
    if ( leaves( set, RF_EFFECT_AREA_LIGHTS ) )
        m->emission = s_black;
    if ( leaves( set, RF_EFFECT_TWO_SIDED_EMISSION ) )
        m->double_sided = false;
    if ( m->textured != NULL )
        leave_out_of_textured( set, m );
}

static void remove_punctual_lights( RfScene* scene )
{
    for ( int i = 0; i < scene->punctual_count; ++i )
        rf_destroy_punctual( scene->punctuals + i );
    scene->punctual_count = 0;
    if ( scene->movement != NULL )
        scene->movement->lamp_count = 0;
}

static RfResult check_choice( uint64_t forced, uint64_t left_out, RfError* error )
{
    char names[RF_EFFECTS_TEXT_SIZE];
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        if ( leaves( left_out, (RfEffectId)i ) && rf_effect_without( (RfEffectId)i ) == RF_WITHOUT_IMPOSSIBLE )
            return rf_fail( error, RF_ERROR_USAGE, "the effect %s cannot be left out of a scene: %s",
                            rf_effect_name( (RfEffectId)i ), rf_effect_without_text( (RfEffectId)i ) );
    }
    rf_format_effects( forced & ~rf_forcible_effects(), names, sizeof names );
    if ( names[0] != '\0' )
        return rf_fail( error, RF_ERROR_USAGE, "these effects cannot be forced: %.900s", names );
    rf_format_effects( forced & left_out, names, sizeof names );
    if ( names[0] != '\0' )
        return rf_fail( error, RF_ERROR_USAGE, "these effects are forced and left out: %.900s", names );
    return RF_OK;
}

static bool varies( const RfTextured* t )
{
    bool any = t->vertex_colors || t->masked || t->blended;
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
        any = any || t->refs[i].texture >= 0;
    return any;
}

// A material of which nothing is left that varies is one without textures.
static void settle_textured( const RfScene* scene, RfMaterial* m )
{
    if ( m->textured == NULL || m->changes || varies( m->textured ) )
        return;
    RfMaterial constant;
    rf_material_at( scene, m, 0, 0.0f, 0.0f, &constant );
    if ( rf_max_component( m->emission ) > 0.0f )
        constant.emission = rf_emission_at( scene, m, 0, 0.0f, 0.0f );
    free( m->textured );
    constant.textured = NULL;
    *m = constant;
}

RfResult rf_choose_effects( RfScene* scene, uint64_t forced, uint64_t left_out, RfError* error )
{
    RfResult result = check_choice( forced, left_out, error );
    if ( result == RF_OK && leaves( left_out, RF_EFFECT_INTERPOLATED_NORMALS ) )
        result = make_flat( &scene->triangles, error );
    for ( int m = 0; m < scene->mesh_count && result == RF_OK && leaves( left_out, RF_EFFECT_INTERPOLATED_NORMALS ); ++m )
        result = make_flat( &scene->meshes[m].triangles, error );
    if ( result != RF_OK )
        return result;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        leave_out_of_material( left_out, scene->materials + i );
    for ( uint32_t i = 0; left_out != 0 && i < scene->material_count; ++i )
        settle_textured( scene, scene->materials + i );
    if ( leaves( left_out, RF_EFFECT_PUNCTUAL_LIGHTS ) )
        remove_punctual_lights( scene );
    if ( leaves( left_out, RF_EFFECT_ENVIRONMENT ) )
    {
        scene->environment.radiance = s_black;
        scene->environment.changes = false;
    }
    scene->effects_forced |= forced;
    scene->effects_left_out |= left_out;
    return RF_OK;
}
