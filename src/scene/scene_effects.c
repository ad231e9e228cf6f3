// Effects: their names, those that a scene calls for, and going without them.
#include "scene/leave_out.h"

#include "base/words.h"
#include "scene/camera_path/camera_track.h"
#include "scene/changes.h"
#include "scene/merge.h"
#include "scene/mirrors.h"
#include "scene/movement.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Row
{
    const char* name;
    RfWithout without;
    bool forcible;
    const char* what;
} Row;

#define ROW( constant, name, without, forcible, what ) { name, RF_WITHOUT_##without, forcible, what },
static const Row s_rows[RF_EFFECT_COUNT] = { RF_EFFECT_LIST( ROW ) };
#undef ROW

#define NAME_BYTES( constant, name, without, forcible, what ) +sizeof( name ) // with a comma or the end
_Static_assert( 0 RF_EFFECT_LIST( NAME_BYTES ) <= RF_EFFECTS_TEXT_SIZE, "all names fit" );
#undef NAME_BYTES
_Static_assert( RF_EFFECT_COUNT <= RF_MAX_EFFECTS, "a set of effects has 64 bits" );

const char* rf_effect_name( RfEffectId effect ) { return s_rows[effect].name; }

RfWithout rf_effect_without( RfEffectId effect ) { return s_rows[effect].without; }

const char* rf_effect_without_text( RfEffectId effect ) { return s_rows[effect].what; }

uint64_t rf_effects_not_built( void ) { return RF_EFFECTS_NOT_BUILT; }

uint64_t rf_forcible_effects( void )
{
    uint64_t set = 0;
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
        set |= s_rows[i].forcible ? RF_EFFECT_BIT( i ) : 0;
    return set;
}

// The effect called by `length` characters, or −1.
static int find( const char* word, size_t length )
{
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        if ( strlen( s_rows[i].name ) == length && strncmp( s_rows[i].name, word, length ) == 0 )
            return i;
    }
    return -1;
}

static RfResult fail_unknown( const char* word, size_t length, RfError* error )
{
    const char* names[RF_EFFECT_COUNT];
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
        names[i] = s_rows[i].name;
    char copy[32], all[RF_EFFECTS_TEXT_SIZE];
    snprintf( copy, sizeof copy, "%.*s", (int)( length < 31 ? length : 31 ), word );
    const char* nearest = length > 0 ? rf_nearest_word( copy, names, RF_EFFECT_COUNT ) : NULL;
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "unknown effect '%s', did you mean %s?", copy, nearest );
    rf_format_effects( ( RF_EFFECT_BIT( RF_EFFECT_COUNT - 1 ) - 1 ) * 2 + 1, all, sizeof all );
    return rf_fail( error, RF_ERROR_USAGE, "unknown effect '%s', expected %s", copy, all );
}

RfResult rf_parse_effects( const char* text, uint64_t* effects, RfError* error )
{
    *effects = 0;
    while ( text != NULL )
    {
        size_t length = strcspn( text, "," );
        int effect = find( text, length );
        if ( effect < 0 )
            return fail_unknown( text, length, error );
        if ( ( *effects & RF_EFFECT_BIT( effect ) ) != 0 )
            return rf_fail( error, RF_ERROR_USAGE, "the effect %s is given twice", s_rows[effect].name );
        *effects |= RF_EFFECT_BIT( effect );
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}

void rf_format_effects( uint64_t effects, char* text, size_t size )
{
    text[0] = '\0';
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        if ( ( effects & RF_EFFECT_BIT( i ) ) != 0 )
            rf_append( text, size, "%s%s", text[0] != '\0' ? "," : "", s_rows[i].name );
    }
}

// Effects that are left out: the scene becomes one without them. What changes no picture (panes aside) is left to the tracer
// and the estimator, and the camera's lens and shutter to its path.

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
    if ( leaves( set, RF_EFFECT_AREA_LIGHTS ) && !m->unlit )
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
    for ( int i = 0; leaves( left_out, RF_EFFECT_MIP_LEVELS ) && i < scene->texture_count; ++i )
        rf_drop_mip_levels( scene->textures + i );
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

// Counts what the triangles use: a material without triangles requires no effect.
typedef struct Census
{
    const RfScene* scene;
    uint32_t* triangles; // per material; NULL if out of memory: every material counts as used
    uint32_t smooth;     // triangles whose normals are interpolated
} Census;

static bool is_used( const Census* census, uint32_t material )
{
    return census->triangles == NULL || census->triangles[material] > 0;
}

static bool is_nonzero( RfVec3 c ) { return rf_max_component( c ) > 0.0f; }

// True if a shading normal deviates more than half a degree from the geometric normal.
static bool is_smooth( const RfTriangles* triangles, uint32_t triangle )
{
    const uint32_t* index = triangles->indices + 3 * (size_t)triangle;
    RfVec3 p0 = rf_load_vec3( triangles->positions, index[0] );
    RfVec3 e1 = rf_sub( rf_load_vec3( triangles->positions, index[1] ), p0 );
    RfVec3 e2 = rf_sub( rf_load_vec3( triangles->positions, index[2] ), p0 );
    RfVec3 face = rf_cross( e1, e2 );
    float length = rf_length( face );
    for ( int k = 0; k < 3 && length > 0.0f; ++k )
    {
        if ( rf_dot( rf_load_vec3( triangles->normals, index[k] ), face ) < 0.99996f * length )
            return true;
    }
    return false;
}

static Census count_uses( const RfScene* scene )
{
    Census census = { .scene = scene };
    if ( scene->material_count > 0 )
        census.triangles = calloc( scene->material_count, sizeof *census.triangles );
    for ( int k = 0; k < rf_triangle_list_count( scene ); ++k )
    {
        RfTriangleList list = rf_triangle_list( scene, k );
        for ( uint32_t i = 0; i < list.triangles->count; ++i )
        {
            if ( census.triangles != NULL && list.triangles->material[i] < scene->material_count )
                census.triangles[list.triangles->material[i]] += list.uses;
            census.smooth += is_smooth( list.triangles, i ) ? list.uses : 0;
        }
    }
    return census;
}

static bool has_diffuse( const RfMaterial* m ) { return is_nonzero( m->diffuse ); }

static bool has_phong( const RfMaterial* m ) { return m->kind == RF_BSDF_PHONG && is_nonzero( m->specular ); }

static bool is_translucent( const RfMaterial* m ) { return m->kind == RF_BSDF_TRANSLUCENT; }

static bool has_ggx( const RfMaterial* m ) { return rf_is_ggx( m->kind ); }

static bool reads( const RfMaterial* m, RfBsdfParam param ) { return rf_has_param( rf_bsdf_model( m->kind )->params, param ); }

static bool has_clearcoat( const RfMaterial* m )
{
    return m->kind == RF_BSDF_COATED || ( m->kind == RF_BSDF_LAYERED && m->clearcoat > 0.0f );
}

static bool has_sheen( const RfMaterial* m )
{
    return m->kind == RF_BSDF_SHEEN || ( m->kind == RF_BSDF_LAYERED && is_nonzero( m->sheen ) );
}

static bool has_anisotropy( const RfMaterial* m ) { return reads( m, RF_PARAM_ANISOTROPY ) && m->anisotropy > 0.0f; }

static bool has_film( const RfMaterial* m ) { return reads( m, RF_PARAM_FILM ) && m->film > 0.0f; }

static bool has_mirror( const RfMaterial* m ) { return m->kind >= RF_BSDF_FIRST_SPECULAR && m->ior == 0.0f; }

static bool has_transmission( const RfMaterial* m ) { return m->kind >= RF_BSDF_FIRST_SPECULAR && m->ior > 0.0f; }

static bool has_dispersion( const RfMaterial* m ) { return m->kind == RF_BSDF_SPECTRAL && m->dispersion > 0.0f; }

static bool has_absorption( const RfMaterial* m ) { return has_transmission( m ) && is_nonzero( m->absorption ); }

static bool has_emission( const RfMaterial* m ) { return rf_emits( m ); }

static bool has_two_sided_emission( const RfMaterial* m ) { return is_nonzero( m->emission ) && m->double_sided; }

static bool has_texture( const RfMaterial* m )
{
    for ( int i = 0; m->textured != NULL && i < RF_TEXTURE_SLOT_COUNT; ++i )
    {
        if ( m->textured->refs[i].texture >= 0 )
            return true;
    }
    return false;
}

static bool has_vertex_colors( const RfMaterial* m ) { return m->textured != NULL && m->textured->vertex_colors; }

// Names the first of what calls for an effect, and counts the rest.
static RfEffect named_effect( RfEffectId id, const char* kind, const char* first, uint32_t count, const char* none )
{
    RfEffect effect = { .id = id, .on = count > 0 };
    if ( count == 0 )
        snprintf( effect.why, sizeof effect.why, "%s", none );
    else if ( count == 1 )
        snprintf( effect.why, sizeof effect.why, "%s '%.80s'", kind, first );
    else
        snprintf( effect.why, sizeof effect.why, "%s '%.80s' and %u more", kind, first, count - 1 );
    return effect;
}

static RfEffect material_effect( const Census* census, RfEffectId id, bool ( *calls )( const RfMaterial* ), const char* none )
{
    const char* first = NULL;
    uint32_t count = 0;
    for ( uint32_t i = 0; i < census->scene->material_count; ++i )
    {
        const RfMaterial* material = census->scene->materials + i;
        if ( !is_used( census, i ) || !calls( material ) )
            continue;
        first = first == NULL ? material->name : first;
        ++count;
    }
    return named_effect( id, "material", first, count, none );
}

static RfEffect count_effect( RfEffectId id, uint32_t count, const char* what, const char* none )
{
    RfEffect effect = { .id = id, .on = count > 0 };
    if ( count > 0 )
        snprintf( effect.why, sizeof effect.why, "%u %s", count, what );
    else
        snprintf( effect.why, sizeof effect.why, "%s", none );
    return effect;
}

static bool moves( const RfCamera* camera )
{
    return camera->animated && ( camera->track == NULL || rf_camera_track_moves( camera->track ) );
}

// The camera selected by the scene file if it moves, else the first that does.
static const RfCamera* moving_camera( const RfScene* scene )
{
    if ( scene->chosen_camera > 0 && moves( scene->cameras + scene->chosen_camera - 1 ) )
        return scene->cameras + scene->chosen_camera - 1;
    for ( int i = 0; i < scene->camera_count; ++i )
    {
        if ( moves( scene->cameras + i ) )
            return scene->cameras + i;
    }
    return NULL;
}

static RfEffect camera_effect( const RfScene* scene )
{
    const RfCamera* camera = moving_camera( scene );
    if ( camera == NULL )
        return ( RfEffect ){ .id = RF_EFFECT_CAMERA_ANIMATION, .why = "no camera of the scene moves" };
    RfEffect effect = { .id = RF_EFFECT_CAMERA_ANIMATION, .on = true };
    if ( camera->track != NULL )
        snprintf( effect.why, sizeof effect.why, "camera path '%.80s'", camera->name );
    else
        snprintf( effect.why, sizeof effect.why, "camera '%.80s' from %g to %g s", camera->name, camera->start, camera->end );
    return effect;
}

// Names the first that changes and counts the rest.
static int name_changing( const RfScene* scene, char* text, size_t size )
{
    RfChanging* list;
    int count = rf_list_changing( scene, &list );
    while ( count > 0 && list[count - 1].kind == RF_CHANGING_LENS ) // of cameras
        --count;
    if ( count == 1 )
        snprintf( text, size, "%s '%.60s' changes", rf_changing_kind( list->kind ), list->name );
    else if ( count > 1 )
        snprintf( text, size, "%s '%.60s' and %d more change", rf_changing_kind( list->kind ), list->name, count - 1 );
    free( list );
    return count;
}

static RfEffect moving_effect( const RfScene* scene )
{
    const RfMovement* movement = scene->movement;
    RfEffect effect = { .id = RF_EFFECT_MOVING, .on = movement != NULL };
    char meshes[32] = "", changing[120] = "";
    snprintf( effect.why, sizeof effect.why, "nothing but cameras moves or changes" );
    if ( !effect.on )
        return effect;
    int movers = movement->mover_count, changes = name_changing( scene, changing, sizeof changing );
    if ( movers > 0 )
        snprintf( meshes, sizeof meshes, "%d mesh%s%s", movers, movers == 1 ? " moves" : "es move", changes > 0 ? ", " : "" );
    snprintf( effect.why, sizeof effect.why, "%s%s from %g to %g s", meshes, changing, movement->start, movement->end );
    return effect;
}

static bool has_normal_map( const RfMaterial* m )
{
    return m->textured != NULL &&
           ( m->textured->refs[RF_TEXTURE_NORMAL].texture >= 0 || m->textured->refs[RF_TEXTURE_CLEARCOAT_NORMAL].texture >= 0 );
}

// Names the first camera with a lens, or with a shutter.
static RfEffect optics_effect( const RfScene* scene, RfEffectId id, bool ( *has )( const RfOptics* ), const char* none )
{
    RfEffect effect = { .id = id };
    snprintf( effect.why, sizeof effect.why, "%s", none );
    for ( int i = 0; i < scene->camera_count && !effect.on; ++i )
    {
        const RfCamera* camera = scene->cameras + i;
        const RfOptics* optics = camera->track != NULL ? &camera->track->optics : camera->optics;
        bool by_keys = camera->track != NULL && camera->track->fstop.count > 0 && id == RF_EFFECT_DEPTH_OF_FIELD;
        effect.on = by_keys || ( optics != NULL && has( optics ) );
        if ( effect.on )
            snprintf( effect.why, sizeof effect.why, "camera '%.80s'", camera->name );
    }
    return effect;
}

static RfEffect punctual_effect( const RfScene* scene )
{
    const char* first = scene->punctual_count > 0 ? scene->punctuals[0].name : NULL;
    return named_effect( RF_EFFECT_PUNCTUAL_LIGHTS, "light", first, (uint32_t)scene->punctual_count, "no punctual light" );
}

static RfEffect flat_mirror_effect( const RfScene* scene )
{
    RfEffect effect = { .id = RF_EFFECT_FLAT_MIRRORS };
    RfMirrors mirrors;
    if ( rf_find_mirrors( scene, &mirrors, NULL ) == RF_OK && mirrors.count > 0 )
    {
        effect.on = true;
        snprintf( effect.why, sizeof effect.why, "%d plane%s that reflect%s, the largest %.3g m2 of material '%.60s'",
                  mirrors.count, mirrors.count == 1 ? "" : "s", mirrors.count == 1 ? "s" : "", mirrors.mirror->area,
                  mirrors.mirror->material.name );
    }
    else
        snprintf( effect.why, sizeof effect.why, "no plane reflects like a mirror" );
    rf_destroy_mirrors( &mirrors );
    return effect;
}

static RfEffect environment_effect( const RfScene* scene )
{
    const RfEnvironment* e = &scene->environment;
    RfEffect effect = { .id = RF_EFFECT_ENVIRONMENT, .on = is_nonzero( e->radiance ) };
    if ( !effect.on )
        snprintf( effect.why, sizeof effect.why, "no environment light" );
    else if ( e->map != NULL )
        snprintf( effect.why, sizeof effect.why, "a map of %d x %d pixels%s", e->width, e->height,
                  e->hidden ? ", hidden from the camera" : "" );
    else
        snprintf( effect.why, sizeof effect.why, "constant radiance %g %g %g%s", (double)e->radiance.x, (double)e->radiance.y,
                  (double)e->radiance.z, e->hidden ? ", hidden from the camera" : "" );
    return effect;
}

static RfEffect caustics_effect( const Census* census )
{
    const RfScene* scene = census->scene;
    RfEffect effect =
        material_effect( census, RF_EFFECT_CAUSTICS, rf_may_throw_caustics, "no mirror, no glass, no smooth metal" );
    bool lit = scene->punctual_count > 0 || is_nonzero( scene->environment.radiance );
    for ( uint32_t i = 0; i < scene->material_count && !lit; ++i )
        lit = is_used( census, i ) && has_emission( scene->materials + i );
    if ( effect.on && !lit )
        snprintf( effect.why, sizeof effect.why, "no light" );
    effect.on = effect.on && lit;
    return effect;
}

void rf_finish_effect( const RfScene* scene, RfEffect* effect )
{
    effect->name = rf_effect_name( effect->id );
    effect->left_out = ( scene->effects_left_out & RF_EFFECT_BIT( effect->id ) ) != 0;
    effect->forced = !effect->on && rf_is_forced( scene, effect->id );
    if ( !effect->left_out )
        return;
    effect->on = false;
    snprintf( effect->why, sizeof effect->why, "left out: %s", rf_effect_without_text( effect->id ) );
}

int rf_list_effects( const RfScene* scene, RfEffect effects[RF_MAX_EFFECTS] )
{
    Census census = count_uses( scene );
    int count = 0;
    effects[count++] = material_effect( &census, RF_EFFECT_DIFFUSE, has_diffuse, "no material reflects diffusely" );
    effects[count++] = material_effect( &census, RF_EFFECT_PHONG, has_phong, "no material has a Phong lobe" );
    effects[count++] = material_effect( &census, RF_EFFECT_GGX, has_ggx, "no material is metallic or coated" );
    effects[count++] = material_effect( &census, RF_EFFECT_AREA_LIGHTS, has_emission, "no material emits" );
    effects[count++] =
        material_effect( &census, RF_EFFECT_TWO_SIDED_EMISSION, has_two_sided_emission, "no emitting material is double-sided" );
    effects[count++] = count_effect( RF_EFFECT_INTERPOLATED_NORMALS, census.smooth, "triangles with interpolated normals",
                                     "no normals are interpolated" );
    effects[count++] = camera_effect( scene );
    effects[count++] = moving_effect( scene );
    effects[count++] = optics_effect( scene, RF_EFFECT_DEPTH_OF_FIELD, rf_has_lens, "no camera of the scene has a lens" );
    effects[count++] = optics_effect( scene, RF_EFFECT_MOTION_BLUR, rf_has_shutter, "no camera of the scene has a shutter" );
    effects[count++] = material_effect( &census, RF_EFFECT_CLEARCOAT, has_clearcoat, "no material has a clear coat" );
    effects[count++] = material_effect( &census, RF_EFFECT_SHEEN, has_sheen, "no material has a sheen" );
    effects[count++] = material_effect( &census, RF_EFFECT_DIFFUSE_TRANSMISSION, is_translucent,
                                        "no material scatters light to its other side" );
    effects[count++] = material_effect( &census, RF_EFFECT_ANISOTROPY, has_anisotropy, "no material stretches highlights" );
    effects[count++] = material_effect( &census, RF_EFFECT_IRIDESCENCE, has_film, "no material has a thin film" );
    effects[count++] = material_effect( &census, RF_EFFECT_MIRRORS, has_mirror, "no material is a perfect mirror" );
    effects[count++] = flat_mirror_effect( scene );
    effects[count++] = material_effect( &census, RF_EFFECT_TRANSMISSION, has_transmission, "no material transmits light" );
    effects[count++] = material_effect( &census, RF_EFFECT_DISPERSION, has_dispersion, "no glass refracts colours differently" );
    effects[count++] = material_effect( &census, RF_EFFECT_PANES, rf_may_be_pane, "no smooth thin wall transmits light" );
    effects[count++] = material_effect( &census, RF_EFFECT_ABSORPTION, has_absorption, "no glass absorbs light" );
    effects[count++] = punctual_effect( scene );
    effects[count++] = environment_effect( scene );
    effects[count++] = material_effect( &census, RF_EFFECT_TEXTURES, has_texture, "no material has a texture" );
    effects[count++] =
        material_effect( &census, RF_EFFECT_MIP_LEVELS, rf_has_colour_texture, "no material has a texture of colours" );
    effects[count++] = material_effect( &census, RF_EFFECT_VERTEX_COLORS, has_vertex_colors, "no mesh has vertex colours" );
    effects[count++] = material_effect( &census, RF_EFFECT_ALPHA_BLEND, rf_is_blended, "no material is blended by its alpha" );
    effects[count++] = material_effect( &census, RF_EFFECT_ALPHA_MASK, rf_is_masked, "no material is masked by its alpha" );
    effects[count++] = material_effect( &census, RF_EFFECT_NORMAL_MAPS, has_normal_map, "no material has a normal texture" );
    effects[count++] =
        material_effect( &census, RF_EFFECT_SMOOTH_GLOSS, rf_may_be_smooth, "no GGX lobe is almost a perfect mirror" );
    effects[count++] = caustics_effect( &census );
    free( census.triangles );
    for ( int i = 0; i < count; ++i )
        rf_finish_effect( scene, effects + i );
    return count;
}
