// The lights of a group of frames: what each is in every frame, its part, and how they are selected.
#include "light/changing.h"

#include "base/layout.h"
#include "light/emission.h"
#include "scene/moments.h"

#include <stdlib.h>
#include <string.h>

#define MOST_DIMMERS 64  // that lamps are sorted by; those of any further ones are light of their own frames
#define SAME_SCALE 1e-6f // by which the scales of two lamps differ that one dimmer dims

typedef enum LampKind
{
    LAMP_PUNCTUAL,
    LAMP_MATERIAL, // all triangles of it that stand still
    LAMP_SKY,
} LampKind;

// What is dimmed as one.
typedef struct Lamp
{
    LampKind kind;
    uint32_t index; // of the light, of RfChangingLights.dim
    RfVec3 most;    // of each channel, in all frames
    double power;
    int lit;     // the first frame in which it shines
    bool scaled; // nothing but its strength differs
    int dimmer;  // −1: none
    int part;
    RfVec3* value; // in each frame
} Lamp;

// Lamps of a light group with the same scales.
typedef struct Dimmer
{
    RfVec3 known; // 1 for channels of which some lamp has light
    RfVec3* scale;
    double power;
    int part;
    int base; // part of the lamps' light group
} Dimmer;

// A group in the making.
typedef struct Making
{
    const RfLights* still;
    const RfChangingLights* changing;
    const RfScene* loaded;
    const RfLitFrame* frame;
    RfGroupLights* group;
    int count;       // of frames
    bool parts_only; // nothing is placed, and no selection is made
    int lamp_count;
    Lamp* lamp;
    RfVec3* values;
    Dimmer dimmer[MOST_DIMMERS];
    int dimmer_count;
    RfVec3* scales; // of dimmers
} Making;

static RfResult no_memory( RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the lights of a group of frames" );
}

static bool is_same( RfVec3 a, RfVec3 b ) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static RfVec3 larger( RfVec3 a, RfVec3 b ) { return rf_vec3( rf_maxf( a.x, b.x ), rf_maxf( a.y, b.y ), rf_maxf( a.z, b.z ) ); }

static float over( float a, float b ) { return b > 0.0f ? a / b : 0.0f; }

static RfVec3 quotient( RfVec3 a, RfVec3 b ) { return rf_vec3( over( a.x, b.x ), over( a.y, b.y ), over( a.z, b.z ) ); }

static const RfMaterial* material_of( const RfScene* scene, const RfLight* light )
{
    return scene->materials + rf_material_of( scene, light->triangle );
}

// Whether textures make of the emission what no factor does.
static bool is_looked_up( const RfMaterial* m )
{
    return m->textured != NULL && ( m->changes || m->textured->model == RF_TEXTURED_UNLIT );
}

// ---- What lights are in each frame

static void set_emission( const Making* m, int at, uint32_t dim, RfVec3 emission )
{
    const RfScene* posed = m->frame[at].scene;
    if ( posed->materials != m->loaded->materials )
        posed->materials[m->changing->dim[dim]].emission = emission;
}

// `emission`: of the light's material, as far as it dims.
static RfVec3 radiance_of( const Making* m, int at, const RfChangingLight* light, const RfLight* shape, RfVec3 emission )
{
    const RfScene* posed = m->frame[at].scene;
    const RfMaterial *now = material_of( posed, shape ), *then = material_of( m->loaded, shape );
    if ( is_looked_up( now ) )
        return rf_mean_emission( posed, now, shape->triangle );
    if ( light->dim < 0 )
        return light->mean;
    return shape->textured ? rf_mul( light->mean, quotient( emission, then->emission ) ) : emission;
}

// One that moves; hidden, without an area or black it brings nothing.
static void place_light( const Making* m, int at, const RfChangingLight* light, RfLight* out )
{
    const RfScene* posed = m->frame[at].scene;
    RfTriangleAt of = rf_locate_placed_triangle( posed, out->triangle );
    out->radiance = rf_vec3( 0, 0, 0 );
    out->area = 0.0f;
    out->pdf_area = 1.0f;
    out->p0 = out->e1 = out->e2 = posed->bounds_min;
    out->normal = rf_vec3( 0, 0, 1 );
    if ( !of.placement->shown )
        return;
    RfLight shape = *out;
    const RfMat4* matrix = &of.placement->matrix;
    rf_shape_light( rf_place_point( matrix, rf_corner( of.triangles, of.index, 0 ) ),
                    rf_place_point( matrix, rf_corner( of.triangles, of.index, 1 ) ),
                    rf_place_point( matrix, rf_corner( of.triangles, of.index, 2 ) ), &shape );
    if ( !( shape.area > 0.0f ) )
        return;
    if ( rf_mat4_det3( matrix ) < 0.0 )
        shape.normal = rf_scale( shape.normal, -1.0f ); // the winding is that of the mesh
    *out = shape;
    out->radiance = radiance_of( m, at, light, out, light->dim >= 0 ? m->frame[at].emission[light->dim] : light->mean );
}

// The lights of a frame as they are, but for triangles that stand still.
static void fill_frame( const Making* m, int at )
{
    const RfLights* still = m->still;
    RfLights* lights = m->group->lights + at;
    const RfScene* posed = m->frame[at].scene;
    size_t triangles = still->triangle_count, punctuals = (size_t)still->punctual_count;
    *lights = *still;
    if ( m->group->light != NULL )
    {
        lights->light = m->group->light + (size_t)at * triangles;
        memcpy( lights->light, still->light, triangles * sizeof *lights->light );
    }
    if ( punctuals > 0 )
    {
        lights->punctual = m->group->punctual + (size_t)at * punctuals;
        memcpy( m->group->punctual + (size_t)at * punctuals, posed->punctuals, punctuals * sizeof *lights->punctual );
    }
    for ( uint32_t i = 0; i < m->changing->dim_count; ++i )
        set_emission( m, at, i, m->frame[at].emission[i] );
    for ( uint32_t i = 0; i < m->changing->count && !m->parts_only; ++i )
    {
        const RfChangingLight* light = m->changing->light + i;
        if ( light->number >= m->changing->still_triangles && light->number < still->triangle_count )
            place_light( m, at, light, lights->light + light->number );
    }
    if ( still->sky.environment == NULL || !still->sky.environment->changes )
        return;
    RfEnvironment* e = m->group->environment + at;
    *e = posed->environment;
    lights->sky.environment = e;
    lights->sky.cos_rotation = cosf( e->rotation );
    lights->sky.sin_rotation = sinf( e->rotation );
}

// Those of RfChangingLights.dimmed that are of a material.
static const uint32_t* dimmed_by( const RfChangingLights* changing, uint32_t dim, const uint32_t** end )
{
    *end = changing->dimmed + changing->dimmed_end[dim];
    return changing->dimmed + ( dim > 0 ? changing->dimmed_end[dim - 1] : 0 );
}

// Triangles of a material that dims, which stand still, in a frame.
static void fill_dimmed( const Making* m, int at, uint32_t dim, RfVec3 emission )
{
    RfLights* lights = m->group->lights + at;
    const uint32_t* end;
    set_emission( m, at, dim, emission );
    for ( const uint32_t* i = dimmed_by( m->changing, dim, &end ); i < end; ++i )
    {
        const RfChangingLight* light = m->changing->light + *i;
        lights->light[light->number].radiance = radiance_of( m, at, light, lights->light + light->number, emission );
    }
}

// ---- Which part each light is

static RfPunctual* punctual_at( const Making* m, int at, uint32_t number )
{
    int count = m->still->punctual_count;
    return m->group->punctual + (size_t)at * (size_t)count + ( number - m->still->triangle_count );
}

static RfVec3 value_at( const Making* m, int at, const Lamp* lamp )
{
    switch ( lamp->kind )
    {
        case LAMP_PUNCTUAL: return punctual_at( m, at, lamp->index )->intensity;
        case LAMP_MATERIAL: return m->frame[at].emission[lamp->index];
        case LAMP_SKY: return m->group->environment[at].radiance;
    }
    return rf_vec3( 0, 0, 0 );
}

// Whether all but the strength is the same in two frames.
static bool is_alike( const Making* m, const Lamp* lamp, int a, int b )
{
    if ( lamp->kind == LAMP_MATERIAL )
        return true;
    if ( lamp->kind == LAMP_SKY )
        return m->loaded->environment.map == NULL || m->group->environment[a].rotation == m->group->environment[b].rotation;
    const RfPunctual *p = punctual_at( m, a, lamp->index ), *q = punctual_at( m, b, lamp->index );
    return is_same( p->position, q->position ) && is_same( p->direction, q->direction ) && is_same( p->across, q->across ) &&
           p->cos_inner == q->cos_inner && p->cos_outer == q->cos_outer && p->range == q->range;
}

static bool is_lit( RfVec3 value ) { return rf_max_component( value ) > 0.0f; }

static bool holds( const Making* m, const Lamp* lamp )
{
    for ( int i = 1; i < m->count; ++i )
    {
        if ( !is_same( lamp->value[i], lamp->value[0] ) || ( is_lit( lamp->value[i] ) && !is_alike( m, lamp, i, 0 ) ) )
            return false;
    }
    return true;
}

static int base_of( const Making* m, const Lamp* lamp )
{
    const RfLights* still = m->still;
    if ( still->part == NULL )
        return 0;
    if ( lamp->kind == LAMP_MATERIAL )
        return still->material_part[m->changing->dim[lamp->index]];
    return still->part[lamp->kind == LAMP_SKY ? still->count - 1 : lamp->index];
}

static void look_at_lamp( const Making* m, Lamp* lamp )
{
    lamp->lit = -1;
    lamp->most = rf_vec3( 0, 0, 0 );
    lamp->scaled = true;
    for ( int i = 0; i < m->count; ++i )
    {
        lamp->value[i] = value_at( m, i, lamp );
        lamp->most = larger( lamp->most, lamp->value[i] );
        if ( !is_lit( lamp->value[i] ) )
            continue;
        lamp->lit = lamp->lit < 0 ? i : lamp->lit;
        lamp->scaled = lamp->scaled && is_alike( m, lamp, i, lamp->lit );
    }
    bool looked_up = false;
    if ( lamp->kind == LAMP_MATERIAL )
        looked_up = m->changing->dim_moves[lamp->index] || is_looked_up( m->loaded->materials + m->changing->dim[lamp->index] );
    lamp->scaled = lamp->scaled && !looked_up;
    lamp->dimmer = -1;
    int base = base_of( m, lamp );
    lamp->part = holds( m, lamp ) ? base : RF_PART_OWN - base;
}

// Of the light of a lamp if it shone with `value`: only quotients count.
static double power_of( const Making* m, const Lamp* lamp )
{
    const RfLights* lights = m->group->lights + lamp->lit;
    double sum = 0.0, now = (double)rf_luminance( lamp->value[lamp->lit] ), most = (double)rf_luminance( lamp->most );
    if ( lamp->kind == LAMP_PUNCTUAL )
        sum = rf_light_model( lights, lamp->index )->selection_power( lights, lamp->index );
    else if ( lamp->kind == LAMP_SKY )
        sum = g_rf_light_models[RF_LIGHT_SKY].selection_power( lights, 0 ) * now /
              (double)rf_luminance( rf_sky_reference( &m->loaded->environment ) );
    if ( lamp->kind == LAMP_MATERIAL )
    {
        const uint32_t* end;
        for ( const uint32_t* i = dimmed_by( m->changing, lamp->index, &end ); i < end; ++i )
            sum += g_rf_light_models[RF_LIGHT_TRIANGLE].selection_power( m->still, m->changing->light[*i].number );
        now = (double)rf_luminance( m->loaded->materials[m->changing->dim[lamp->index]].emission );
    }
    return now > 0.0 ? sum * most / now : 0.0;
}

static int by_power( const void* a, const void* b )
{
    const Lamp *p = a, *q = b;
    if ( p->power != q->power )
        return p->power > q->power ? -1 : 1;
    return p->kind != q->kind ? ( p->kind < q->kind ? -1 : 1 ) : ( p->index < q->index ? -1 : p->index > q->index );
}

static bool agrees( float scale, float of_lamp, float known, float most )
{
    return !( known > 0.0f && most > 0.0f ) || fabsf( scale - of_lamp ) <= SAME_SCALE * rf_maxf( scale, of_lamp );
}

static bool is_dimmed_by( const Making* m, const Lamp* lamp, const Dimmer* dimmer )
{
    if ( dimmer->base != base_of( m, lamp ) )
        return false;
    for ( int i = 0; i < m->count; ++i )
    {
        RfVec3 a = dimmer->scale[i], b = quotient( lamp->value[i], lamp->most ), known = dimmer->known, most = lamp->most;
        if ( !agrees( a.x, b.x, known.x, most.x ) || !agrees( a.y, b.y, known.y, most.y ) ||
             !agrees( a.z, b.z, known.z, most.z ) )
            return false;
    }
    return true;
}

// The dimmer of a lamp, which may be a new one; −1: there are too many.
static int find_dimmer( Making* m, const Lamp* lamp )
{
    int at = 0;
    while ( at < m->dimmer_count && !is_dimmed_by( m, lamp, m->dimmer + at ) )
        ++at;
    if ( at == MOST_DIMMERS )
        return -1;
    Dimmer* dimmer = m->dimmer + at;
    if ( at == m->dimmer_count )
        *dimmer = ( Dimmer ){ .scale = m->scales + (size_t)at * (size_t)m->count, .base = base_of( m, lamp ) };
    m->dimmer_count = at == m->dimmer_count ? at + 1 : m->dimmer_count;
    for ( int i = 0; i < m->count; ++i )
    {
        RfVec3 *a = dimmer->scale + i, b = quotient( lamp->value[i], lamp->most );
        *a = rf_vec3( dimmer->known.x > 0.0f ? a->x : b.x, dimmer->known.y > 0.0f ? a->y : b.y,
                      dimmer->known.z > 0.0f ? a->z : b.z );
    }
    dimmer->known = larger( dimmer->known, rf_vec3( lamp->most.x > 0.0f, lamp->most.y > 0.0f, lamp->most.z > 0.0f ) );
    dimmer->power += lamp->power;
    return at;
}

// The parts that the base parts of light groups take from 1 on.
static int base_parts( const Making* m ) { return m->still->part != NULL ? m->still->group_count - 1 : 0; }

static void number_dimmers( Making* m )
{
    for ( int part = base_parts( m ) + 1; part <= base_parts( m ) + RF_DIMMED_MOST; ++part )
    {
        int best = -1;
        for ( int k = 0; k < m->dimmer_count; ++k )
        {
            if ( m->dimmer[k].part == 0 && ( best < 0 || m->dimmer[k].power > m->dimmer[best].power ) )
                best = k;
        }
        if ( best < 0 )
            return;
        m->dimmer[best].part = part;
        for ( int i = 0; i < m->count; ++i )
        {
            m->group->lights[i].dimmed_count = part;
            m->group->lights[i].base_part[part] = (uint8_t)m->dimmer[best].base;
            m->group->lights[i].part_scale[part] = m->dimmer[best].scale[i];
        }
    }
}

static void sort_lamps( Making* m )
{
    for ( int k = 0; k < m->lamp_count; ++k )
    {
        Lamp* lamp = m->lamp + k;
        look_at_lamp( m, lamp );
        lamp->power = lamp->lit >= 0 ? power_of( m, lamp ) : 0.0;
    }
    if ( m->count == 1 )
        return;
    qsort( m->lamp, (size_t)m->lamp_count, sizeof *m->lamp, by_power );
    for ( int k = 0; k < m->lamp_count; ++k )
    {
        Lamp* lamp = m->lamp + k;
        if ( rf_is_own_part( lamp->part ) && lamp->scaled )
            lamp->dimmer = find_dimmer( m, lamp );
    }
    number_dimmers( m );
    for ( int k = 0; k < m->lamp_count; ++k )
    {
        Lamp* lamp = m->lamp + k;
        if ( lamp->dimmer >= 0 && m->dimmer[lamp->dimmer].part > 0 )
            lamp->part = m->dimmer[lamp->dimmer].part;
    }
}

// Sets the lights of a lamp to what they are in its part.
static void settle_lamp( const Making* m, const Lamp* lamp )
{
    bool dimmed = lamp->part > base_parts( m ) && !rf_is_own_part( lamp->part );
    for ( int i = 0; i < m->count; ++i )
    {
        if ( lamp->kind == LAMP_MATERIAL )
            fill_dimmed( m, i, lamp->index, dimmed ? lamp->most : lamp->value[i] );
        if ( !dimmed || lamp->kind == LAMP_MATERIAL )
            continue;
        if ( lamp->kind == LAMP_PUNCTUAL )
        {
            *punctual_at( m, i, lamp->index ) = *punctual_at( m, lamp->lit, lamp->index );
            punctual_at( m, i, lamp->index )->intensity = lamp->most;
        }
        else
        {
            RfLights* lights = m->group->lights + i;
            m->group->environment[i] = m->group->environment[lamp->lit];
            m->group->environment[i].radiance = lamp->most;
            lights->sky.cos_rotation = m->group->lights[lamp->lit].sky.cos_rotation;
            lights->sky.sin_rotation = m->group->lights[lamp->lit].sky.sin_rotation;
        }
    }
}

// The parts of all lights, which the frames share.
static void note_parts( const Making* m )
{
    RfLights* first = m->group->lights;
    uint32_t moving = m->still->triangle_count - m->changing->still_triangles;
    if ( m->still->part != NULL )
    {
        memcpy( first->part, m->still->part, m->still->count * sizeof *first->part );
        memcpy( first->material_part, m->still->material_part, m->loaded->material_count * sizeof *first->material_part );
    }
    if ( m->count == 1 )
        return;
    first->any_own = moving > 0;
    for ( uint32_t i = m->changing->still_triangles; i < m->still->triangle_count; ++i )
        first->part[i] = (uint8_t)( RF_PART_OWN - first->part[i] );
    for ( int k = 0; k < m->lamp_count; ++k )
    {
        const Lamp* lamp = m->lamp + k;
        first->any_own = first->any_own || rf_is_own_part( lamp->part );
        if ( lamp->kind == LAMP_MATERIAL )
            first->material_part[m->changing->dim[lamp->index]] = (uint8_t)lamp->part;
        else
            first->part[lamp->kind == LAMP_SKY ? m->still->count - 1 : lamp->index] = (uint8_t)lamp->part;
    }
    for ( uint32_t i = 0; i < m->changing->count; ++i )
    {
        const RfChangingLight* light = m->changing->light + i;
        if ( light->number < m->changing->still_triangles )
            first->part[light->number] = first->material_part[m->changing->dim[light->dim]];
    }
}

// Numbers the light groups with light of one frame; returns how many there are.
static int number_frame_groups( const Making* m, uint8_t* number, uint8_t* base )
{
    int count = 0;
    memset( number, RF_PART_OWN, RF_LIGHT_GROUPS_MOST );
    for ( int k = 0; k < m->lamp_count; ++k )
    {
        int part = m->lamp[k].part, of = RF_PART_OWN - part;
        if ( !rf_is_own_part( part ) || number[of] != RF_PART_OWN )
            continue;
        base[count] = (uint8_t)of;
        number[of] = (uint8_t)count++;
    }
    return count;
}

// Light of one frame has parts by frame where nothing moves but lamps without size and the sky.
static void add_frame_parts( const Making* m )
{
    const RfLights* first = m->group->lights;
    uint8_t number[RF_LIGHT_GROUPS_MOST], base[RF_LIGHT_GROUPS_MOST];
    int frames = m->count, groups = number_frame_groups( m, number, base );
    bool alone = m->loaded->placement_count > m->loaded->still_placement_count;
    for ( int k = 0; k < m->lamp_count; ++k )
        alone = alone || ( m->lamp[k].kind == LAMP_MATERIAL && rf_is_own_part( m->lamp[k].part ) );
    if ( frames > RF_FRAMES_MOST || !first->any_own || alone || first->dimmed_count + groups * frames > RF_PARTS_MOST )
        return;
    for ( int i = 0; i < m->count; ++i )
    {
        RfLights* lights = m->group->lights + i;
        lights->frame_count = frames;
        lights->frame_groups = groups;
        memcpy( lights->frame_group, number, sizeof lights->frame_group );
        for ( int k = 0; k < groups * frames; ++k )
        {
            float scale = k % frames == i ? 1.0f : 0.0f;
            lights->part_scale[lights->dimmed_count + 1 + k] = rf_vec3( scale, scale, scale );
            lights->base_part[lights->dimmed_count + 1 + k] = base[k / frames];
        }
    }
}

// ---- How lights are selected

static RfVec3 turned( RfVec3 v, float angle )
{
    float c = cosf( angle ), s = sinf( angle );
    return rf_vec3( v.x * c + v.z * s, v.y, v.z * c - v.x * s );
}

// The mean of the sky over all frames, by which it is selected in each; none where it is dark in all of them.
static void average_sky( const Making* m, const Lamp* lamp )
{
    const RfEnvironment* loaded = &m->loaded->environment;
    float reference = rf_luminance( rf_sky_reference( loaded ) ), mean = 0.0f;
    RfVec3 moment = rf_vec3( 0, 0, 0 );
    for ( int i = 0; i < m->count; ++i )
    {
        float share = rf_luminance( lamp->value[i] ) / ( reference * (float)m->count );
        float turn = m->group->environment[i].rotation - loaded->rotation;
        mean += share * m->still->sky.mean_luminance;
        moment = rf_madd( moment, turned( m->still->sky.luminance_moment, turn ), share );
    }
    for ( int i = 0; i < m->count; ++i )
    {
        RfLights* lights = m->group->lights + i;
        lights->sky.mean_luminance = mean;
        lights->sky.luminance_moment = moment;
        lights->sky.environment = lamp->lit >= 0 ? lights->sky.environment : NULL;
        lights->count -= lamp->lit < 0;
    }
}

// The most of its powers.
static double most_power( const Making* m, uint32_t number )
{
    double most = 0.0;
    for ( int i = 0; i < m->count; ++i )
        most = fmax( most, rf_light_model( m->group->lights + i, number )->selection_power( m->group->lights + i, number ) );
    return most;
}

static RfResult find_powers( const Making* m, RfError* error )
{
    RfLights* first = m->group->lights;
    double* powers = malloc( ( (size_t)first->count + 1 ) * sizeof *powers );
    if ( powers == NULL )
        return no_memory( error );
    double total = 0.0;
    uint32_t next = 0;
    first->all_own = m->count > 1;
    for ( uint32_t i = 0; i < first->count; ++i )
    {
        bool changes = next < m->changing->count && m->changing->light[next].number == i;
        powers[i] = changes ? most_power( m, i ) : rf_light_model( first, i )->selection_power( first, i );
        total += powers[i];
        next += changes;
        first->all_own = first->all_own && ( powers[i] == 0.0 || rf_is_own_part( first->part[i] ) );
    }
    for ( uint32_t i = 0; i < first->count; ++i )
        first->power_fraction[i] = total > 0.0 ? (float)( powers[i] / total ) : 0.0f;
    RfResult result = RF_OK;
    if ( total > 0.0 )
        result = rf_build_alias( first, powers, total, error );
    else
        first->count = 0;
    m->group->alias = first->alias;
    m->group->alias_threshold = first->alias_threshold;
    free( powers );
    return result;
}

// Extends the bounds of a triangle to all that it is while the shutter of a frame is open, where that is posed at moments: between
// them its corners go straight, as what deforms stands in the world.
static void sweep_shutter( const Making* m, int at, uint32_t number, RfTreeLight* out )
{
    const RfScene* posed = m->frame[at].scene;
    const RfLights* lights = m->group->lights + at;
    const RfLight* light = lights->light + number;
    if ( posed->moments == NULL || number < m->changing->still_triangles || number >= lights->triangle_count ||
         !is_lit( light->radiance ) )
        return;
    RfTriangleAt of = rf_locate_placed_triangle( posed, light->triangle );
    bool turns = false;
    for ( int k = 0; k < rf_moment_count( posed ); ++k )
    {
        RfLight shape = *light;
        rf_shape_light( rf_corner_at( posed, k, &of, 0 ), rf_corner_at( posed, k, &of, 1 ), rf_corner_at( posed, k, &of, 2 ),
                        &shape );
        turns = turns || !is_same( shape.e1, light->e1 ) || !is_same( shape.e2, light->e2 );
        shape.normal = light->normal;
        RfTreeLight bound = rf_bound_triangle( lights, &shape, number );
        rf_sweep_tree_light( out, &bound );
    }
    out->cos_spread = turns ? -1.0 : out->cos_spread; // between moments it may face any way
    out->two_sided = out->two_sided && !turns;
}

// The bounds of a light that hold in all frames.
static RfTreeLight swept_bound( const Making* m, uint32_t number )
{
    const RfLights* first = m->group->lights;
    RfTreeLight out = rf_light_model( first, number )->bound( first, number );
    for ( int i = 1; i < m->count; ++i )
    {
        const RfLights* lights = m->group->lights + i;
        RfTreeLight other = rf_light_model( lights, number )->bound( lights, number );
        rf_sweep_tree_light( &out, &other );
    }
    for ( int i = 0; i < m->count; ++i )
        sweep_shutter( m, i, number, &out );
    return out;
}

// The second tree, and the scales of all three.
static RfResult build_tree( const Making* m, RfError* error )
{
    RfLights* first = m->group->lights;
    RfTreeLight* leaves = malloc( ( (size_t)m->changing->count + 1 ) * sizeof *leaves );
    if ( leaves == NULL )
        return no_memory( error );
    uint32_t count = 0;
    double sum = 0.0, sky = rf_has_sky( first ) ? 3.14159265358979324 * (double)first->sky.mean_luminance : 0.0;
    for ( uint32_t i = 0; i < m->changing->count; ++i )
    {
        leaves[count] = swept_bound( m, m->changing->light[i].number );
        sum += leaves[count].intensity;
        count += leaves[count].intensity > 0.0;
    }
    for ( uint32_t i = 0; i < count; ++i )
        leaves[i].intensity /= sum;
    double all = m->changing->still_sum + sum + sky;
    first->second = &m->group->tree;
    first->tree_scale = all > 0.0 ? (float)( m->changing->still_sum / all ) : 0.0f;
    first->second_scale = all > 0.0 ? (float)( sum / all ) : 0.0f;
    first->sky_scale = all > 0.0 ? (float)( 1.0 / all ) : 0.0f;
    RfResult result = count > 0 ? rf_build_light_tree( leaves, count, first->count, &m->group->tree, error ) : RF_OK;
    free( leaves );
    return result;
}

static RfResult find_selection( const Making* m, RfError* error )
{
    RfLights* first = m->group->lights;
    RfResult result = find_powers( m, error );
    if ( result == RF_OK && m->changing->by_tree )
        result = build_tree( m, error );
    for ( int i = 1; i < m->count; ++i )
    {
        RfLights* lights = m->group->lights + i;
        lights->count = first->count;
        lights->power_fraction = first->power_fraction;
        lights->alias = first->alias;
        lights->alias_threshold = first->alias_threshold;
        lights->second = first->second;
        lights->tree_scale = first->tree_scale;
        lights->second_scale = first->second_scale;
        lights->sky_scale = first->sky_scale;
        lights->part = first->part;
        lights->material_part = first->material_part;
        lights->any_own = first->any_own;
        lights->all_own = first->all_own;
    }
    return result;
}

// ---- Making a group

static size_t lamps_of( const RfLights* still ) { return (size_t)still->changing->dim_count + (size_t)still->punctual_count + 1; }

// A frame alone has no parts but those of light groups: all holds.
static RfGroupLights* place_group( Making* m, RfLayout* layout )
{
    const RfLights* still = m->still;
    size_t count = (size_t)m->count, lamps = lamps_of( still );
    bool moves = still->triangle_count - m->changing->still_triangles + m->changing->dim_count > 0 && !m->parts_only;
    bool parts = m->count > 1 || still->part != NULL;
    RfGroupLights* group = rf_take( layout, 1, sizeof *group );
    RF_PLACE( layout, group->lights, count );
    RF_PLACE( layout, group->environment, count );
    RF_PLACE( layout, group->punctual, count * (size_t)still->punctual_count );
    RF_PLACE( layout, group->light, moves ? count * still->triangle_count : 0 );
    RF_PLACE( layout, group->power_fraction, (size_t)still->count + 1 );
    RF_PLACE( layout, group->part, parts ? (size_t)still->count + 1 : 0 );
    RF_PLACE( layout, group->material_part, parts ? (size_t)m->loaded->material_count + 1 : 0 );
    RF_PLACE( layout, m->lamp, lamps );
    RF_PLACE( layout, m->values, lamps * count );
    RF_PLACE( layout, m->scales, MOST_DIMMERS * count );
    return group;
}

static void list_lamps( Making* m )
{
    const RfLights* still = m->still;
    for ( uint32_t i = 0; i < m->changing->dim_count; ++i )
        m->lamp[m->lamp_count++] = ( Lamp ){ .kind = LAMP_MATERIAL, .index = i };
    for ( uint32_t i = 0; i < (uint32_t)still->punctual_count; ++i )
    {
        if ( still->punctual[i].changes )
            m->lamp[m->lamp_count++] = ( Lamp ){ .kind = LAMP_PUNCTUAL, .index = still->triangle_count + i };
    }
    if ( still->sky.environment != NULL && still->sky.environment->changes )
        m->lamp[m->lamp_count++] = ( Lamp ){ .kind = LAMP_SKY };
    for ( int k = 0; k < m->lamp_count; ++k )
        m->lamp[k].value = m->values + (size_t)k * (size_t)m->count;
}

static RfResult make_group( Making* m, RfError* error )
{
    for ( int i = 0; i < m->count; ++i )
        fill_frame( m, i );
    RfLights* first = m->group->lights;
    first->alias = first->alias_threshold = NULL;
    first->power_fraction = m->group->power_fraction;
    first->part = m->group->part;
    first->material_part = m->group->material_part;
    list_lamps( m );
    sort_lamps( m );
    for ( int k = 0; k < m->lamp_count && !m->parts_only; ++k )
        settle_lamp( m, m->lamp + k );
    note_parts( m );
    add_frame_parts( m );
    for ( int k = 0; k < m->lamp_count; ++k )
    {
        if ( m->lamp[k].kind == LAMP_SKY )
            average_sky( m, m->lamp + k );
    }
    return m->parts_only ? RF_OK : find_selection( m, error );
}

static RfResult create_group( Making m, RfGroupLights** out, RfError* error )
{
    RfLayout measured = { 0 };
    place_group( &m, &measured );
    RfLayout placed = { .memory = aligned_alloc( 64, measured.bytes ) };
    *out = NULL;
    if ( placed.memory == NULL )
        return no_memory( error );
    memset( placed.memory, 0, measured.bytes );
    m.group = *out = place_group( &m, &placed );
    RfResult result = make_group( &m, error );
    if ( result == RF_OK )
        return RF_OK;
    rf_destroy_group_lights( m.group );
    *out = NULL;
    return result;
}

RfResult rf_create_group_lights( const RfLights* still, const RfScene* loaded, int count, const RfLitFrame* frame,
                                 RfGroupLights** out, RfError* error )
{
    Making m = { .still = still, .changing = still->changing, .loaded = loaded, .frame = frame, .count = count };
    return create_group( m, out, error );
}

RfResult rf_create_group_parts( const RfLights* still, const RfScene* loaded, int count, const RfLitFrame* frame,
                                RfGroupLights** out, RfError* error )
{
    Making m = {
        .still = still, .changing = still->changing, .loaded = loaded, .frame = frame, .count = count, .parts_only = true
    };
    return create_group( m, out, error );
}

void rf_destroy_group_lights( RfGroupLights* group )
{
    if ( group == NULL )
        return;
    free( group->alias );
    free( group->alias_threshold );
    rf_destroy_light_tree( &group->tree );
    free( group );
}

size_t rf_group_lights_bytes( const RfScene* scene, int frames )
{
    if ( !rf_lights_change( scene ) )
        return 0;
    size_t triangles = rf_count_moving_emitters( scene ), punctuals = (size_t)scene->punctual_count, dims = 0;
    size_t changing = triangles + punctuals;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        dims += scene->materials[i].dims;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        const RfMaterial* m = scene->materials + scene->triangles.material[i];
        bool emits = rf_emits( m );
        triangles += emits;
        changing += emits && m->dims;
    }
    size_t lamps = dims + punctuals + 1, lights = triangles + punctuals + 1;
    size_t frame = sizeof( RfLights ) + sizeof( RfEnvironment ) + punctuals * sizeof( RfPunctual ) + lamps * sizeof( RfVec3 ) +
                   triangles * sizeof( RfLight ) + dims * sizeof( RfVec3 ) + MOST_DIMMERS * sizeof( RfVec3 );
    size_t light = sizeof( double ) + 5 * sizeof( uint32_t ) + sizeof( uint8_t ); // powers, tables, places in the tree, part
    size_t of_tree = sizeof( RfTreeLight ) + sizeof( RfLightNode );
    return (size_t)frames * frame + lights * light + changing * of_tree + lamps * sizeof( Lamp ) + scene->material_count;
}
