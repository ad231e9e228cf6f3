// Finds the vertices that rays hit, behind thin panes too, sorted by scattering model.
#include "path/wavefront.h"

#include "base/fault.h"
#include "scene/textured.h"

#include <string.h>

#define AHEAD 12 // records of triangles are fetched so many lanes before they are read

static inline void prefetch_record( const RfTriangleRecord* t )
{
    __builtin_prefetch( t );
    __builtin_prefetch( &t->material );
}

// The number of the triangle's material; `placed`: the triangle may be one of a placement.
static inline uint32_t material_of( const RfTracer* tracer, const RfTriangleRecord* triangles, uint32_t triangle, bool placed )
{
    return placed ? rf_triangle_material( tracer, triangle ) : triangles[triangle].material;
}

// Counts the hits of each model.
static inline __attribute__( ( always_inline ) ) void count_kinds( const RfTracer* tracer, int count, RfLaneScratch* scratch,
                                                                   int* bucket, bool placed )
{
    const RfTriangleRecord* triangles = rf_tracer_records( tracer )->records;
    const RfMaterial* materials = rf_tracer_scene( tracer )->materials;
    for ( int i = 0; i < count; ++i )
    {
        uint32_t t = scratch->triangle[i];
        if ( !placed && i + AHEAD < count && scratch->triangle[i + AHEAD] != RF_MISS )
            prefetch_record( triangles + scratch->triangle[i + AHEAD] );
        int kind = t == RF_MISS ? RF_BSDF_KIND_COUNT : (int)materials[material_of( tracer, triangles, t, placed )].kind;
        scratch->kind[i] = (uint8_t)kind;
        bucket[kind] += 1;
    }
}

// The hits of camera rays on rough glass that the frames of a group share, from outside unless it is thin.
static void find_frosted( const RfTracer* tracer, const RfRayLanes* rays, RfLaneScratch* scratch, int* bucket )
{
    for ( int i = 0; i < rays->count && bucket[RF_BSDF_GLASS] > 0; ++i )
    {
        if ( scratch->kind[i] != RF_BSDF_GLASS )
            continue;
        RfTriangleRecord place;
        const RfTriangleRecord* t = rf_triangle_record( tracer, scratch->triangle[i], &place );
        const RfMaterial* m = rf_tracer_scene( tracer )->materials + t->material;
        if ( !rf_is_frosted( m ) || ( !m->thin && rf_dot( t->ng, RF_GET3( rays->d, i ) ) > 0.0f ) )
            continue;
        scratch->kind[i] = RF_BSDF_FROSTED;
        bucket[RF_BSDF_FROSTED] += 1;
        bucket[RF_BSDF_GLASS] -= 1;
    }
}

// Stable counting sort of the hits by model: index[] lists their ray lanes.
static void sort_by_kind( const RfTracer* tracer, const RfRayLanes* rays, bool frosted, RfLaneScratch* scratch,
                          RfVertexLanes* vertices )
{
    int bucket[RF_BSDF_KIND_COUNT + 1] = { 0 }, count = rays->count;
    if ( rf_tracer_has_placements( tracer ) )
        count_kinds( tracer, count, scratch, bucket, true );
    else
        count_kinds( tracer, count, scratch, bucket, false );
    if ( frosted )
        find_frosted( tracer, rays, scratch, bucket );
    int start = 0;
    for ( int k = 0; k <= RF_BSDF_KIND_COUNT; ++k )
    {
        int size = bucket[k];
        vertices->first[k] = bucket[k] = start;
        start += size;
    }
    vertices->count = vertices->first[RF_BSDF_KIND_COUNT];
    for ( int i = 0; i < count; ++i )
        scratch->index[bucket[scratch->kind[i]]++] = i;
}

// Index of refraction of the far side over the near side (RF_PARAM_IOR).
static float relative_ior( const RfMaterial* m, float facing )
{
    if ( m->thin )
        return -m->ior;
    return facing >= 0.0f || m->ior == 0.0f ? m->ior : 1.0f / m->ior;
}

// Gathers the parameters that come from the material alone into lanes [first, end)
// of one model. Lane first + k has material number[k].
static void gather_params( const RfMaterial* materials, const int32_t* restrict number, RfBsdfKind kind, int first, int end,
                           RfVertexLanes* v )
{
    const int32_t stride = sizeof *materials / sizeof( float );
    for ( RfBsdfParams left = rf_bsdf_model( kind )->params & ~RF_PARAMS_OF_HIT; left != 0; left &= left - 1 )
    {
        RfBsdfParam p = rf_first_param( left );
        const float* restrict from = rf_material_param( materials, p );
        float* restrict to = v->param[p] + first;
#pragma omp simd
        for ( int k = 0; k < end - first; ++k )
            to[k] = from[number[k] * stride];
    }
}

static RfVec3 throughput_of( const RfRayLanes* rays, int r ) { return RF_GET3( rays->throughput, r ); }

// Sets the parameters of a lane that depend on the hit and its ray. v->n is still the
// interpolated normal, which a coat keeps.
static inline void fill_params_of_hit( RfVertexLanes* v, int i, const RfMaterial* m, float facing, const RfRayLanes* rays, int r )
{
    RfBsdfParams params = rf_bsdf_model( m->kind )->params & RF_PARAMS_OF_HIT;
    if ( params == 0 )
        return;
    if ( rf_has_param( params, RF_PARAM_CLEARCOAT_N ) )
        RF_PUT3( v->param + RF_PARAM_CLEARCOAT_N, i, RF_GET3( v->n, i ) );
    if ( rf_has_param( params, RF_PARAM_CHOICE ) )
        v->param[RF_PARAM_CHOICE][i] = m->kind == RF_BSDF_SPECTRAL ? rf_pack_channels( throughput_of( rays, r ) ) : 1.0f;
    if ( rf_has_param( params, RF_PARAM_IOR ) )
    {
        v->param[RF_PARAM_IOR][i] = relative_ior( m, facing );
        RF_PUT3( v->absorption, i, facing < 0.0f && !m->thin ? m->absorption : rf_vec3( 0, 0, 0 ) );
    }
}

// Emission towards wo, and the density of this point for a light sample at the
// ray's origin, given the light: 0 of what is unlit, which only cameras see.
static inline __attribute__( ( always_inline ) ) void
fill_emission( RfVertexLanes* v, int i, const RfLights* lights, uint32_t index, const RfMaterial* m, float facing, RfVec3 to_hit )
{
    v->light_pdf_solid_angle[i] = 0.0f;
    RF_PUT3( v->emission, i, rf_vec3( 0, 0, 0 ) );
    if ( m->unlit && ( facing > 0.0f || rf_calls_for( m->double_sided, RF_EFFECT_TWO_SIDED_EMISSION ) ) )
        RF_PUT3( v->emission, i, m->emission );
    if ( index == RF_NO_LIGHT )
        return;
    const RfLight* light = lights->light + index;
    if ( facing <= 0.0f && ( RF_FAULT( two_sided ) || !rf_calls_for( light->two_sided, RF_EFFECT_TWO_SIDED_EMISSION ) ) )
        return;
    RF_PUT3( v->emission, i, light->radiance );
    float cos_light = fabsf( facing );
    if ( cos_light > 0.0f )
        v->light_pdf_solid_angle[i] = light->pdf_area * rf_dot( to_hit, to_hit ) / cos_light;
}

static inline RfVec3 shading_normal( const RfTriangleRecord* t, float u, float v, float side, RfVec3 ng )
{
    RfVec3 n = rf_add( t->n0, rf_add( rf_scale( t->d1, u ), rf_scale( t->d2, v ) ) );
    float length2 = rf_dot( n, n );
    n = rf_scale( n, side / sqrtf( rf_maxf( length2, 1e-30f ) ) );
    // normals that face the wrong way or cancel are replaced
    return RF_FAULT( shading_normal ) || ( rf_dot( n, ng ) > 0.0f && length2 > 1e-12f ) ? n : ng;
}

// What the lanes of the vertices are filled from.
typedef struct Source
{
    const RfTracer* tracer;
    const RfTriangleRecord* triangles; // in world space
    const RfMaterial* materials;
    const RfLights* lights;
    const RfRayLanes* rays;
    const RfLaneScratch* scratch;
    bool seen; // the rays are camera rays
} Source;

// `placed`: the triangle may be one of a placement. Where none can be, nothing is spent on it.
static inline __attribute__( ( always_inline ) ) void fill_lane( const Source* from, RfVertexLanes* restrict v, int i,
                                                                 bool placed )
{
    const RfRayLanes* restrict rays = from->rays;
    int r = from->scratch->index[i];
    float bu = from->scratch->u[r], bv = from->scratch->v[r];
    RfTriangleRecord place;
    const RfTriangleRecord* t = placed ? rf_triangle_record( from->tracer, from->scratch->triangle[r], &place )
                                       : from->triangles + from->scratch->triangle[r];
    RfVec3 o = RF_GET3( rays->o, r );
    RfVec3 wo = rf_vec3( -rays->d[0][r], -rays->d[1][r], -rays->d[2][r] );
    RfHitPoint hit = rf_hit_point( t, bu, bv, o, rf_scale( wo, -1.0f ) );
    float facing = rf_dot( t->ng, wo );
    float side = facing < 0.0f ? -1.0f : 1.0f;
    RfVec3 ng = rf_scale( t->ng, side );
    bool smooth = rf_calls_for( !t->flat, RF_EFFECT_INTERPOLATED_NORMALS );
    RfVec3 n = smooth ? shading_normal( t, bu, bv, side, ng ) : ng;
    RF_PUT3( v->p, i, hit.p );
    RF_PUT3( v->ng, i, ng );
    RF_PUT3( v->n, i, n );
    RF_PUT3( v->wo, i, wo );
    v->offset[i] = hit.offset;
    v->ray[i] = r;
    v->slot[i] = rays->slot[r];
    v->material[i] = (int32_t)t->material;
    fill_params_of_hit( v, i, from->materials + t->material, facing, rays, r );
    fill_emission( v, i, from->lights, t->light, from->materials + t->material, facing, rf_sub( hit.p, o ) );
}

// A point on a triangle; side is −1 where the triangle is seen from behind.
typedef struct Hit
{
    uint32_t triangle;
    float u, v, side;
} Hit;

// Applies the normal textures of the surface and of its coat.
static void look_up_normals( const RfScene* scene, const RfMaterial* m, const Hit* hit, RfVec3 ng, RfVertexLanes* v, int i )
{
    if ( !rf_is_built( RF_EFFECT_NORMAL_MAPS ) )
        return;
    RfVec3 n = rf_scale( RF_GET3( v->n, i ), hit->side );
    if ( m->textured->refs[RF_TEXTURE_NORMAL].texture >= 0 )
        RF_PUT3( v->n, i, rf_scale( rf_normal_at( scene, m, hit->triangle, hit->u, hit->v, n, ng ), hit->side ) );
    if ( m->textured->refs[RF_TEXTURE_CLEARCOAT_NORMAL].texture >= 0 )
        RF_PUT3( v->param + RF_PARAM_CLEARCOAT_N, i,
                 rf_scale( rf_coat_normal_at( scene, m, hit->triangle, hit->u, hit->v, n, ng ), hit->side ) );
}

// A camera ray sees mean colours over a square this wide, in pixels, whatever the samples are: an anisotropic footprint's narrow
// side (Igehy 1999), so that pictures stay sharp where surfaces are seen at a grazing angle.
#define FOOTPRINT_WIDTH 0.25f
#define FOOTPRINT_SHARE 1e9f // the most

// The footprint of a camera ray as a share of the triangle, 0 for other rays: a function of camera and point alone, so that the
// colour is one, too (src/reuse/estimators.md, section 26).
static inline float footprint_share( const Source* from, const RfTriangleRecord* t, const RfVertexLanes* v, int i )
{
    if ( !from->seen || !rf_is_built( RF_EFFECT_MIP_LEVELS ) )
        return 0.0f;
    int r = from->scratch->index[i];
    RfVec3 along = rf_sub( RF_GET3( v->p, i ), RF_GET3( from->rays->o, r ) ), normal = rf_cross( t->e1, t->e2 );
    float distance = sqrtf( rf_dot( along, along ) ), triangle = 0.5f * sqrtf( rf_dot( normal, normal ) );
    float width = FOOTPRINT_WIDTH * ( from->rays->pixel_width + from->rays->pixel_spread * distance );
    return width * width < FOOTPRINT_SHARE * triangle ? width * width / triangle : FOOTPRINT_SHARE;
}

// Looks up the material of a textured lane into `here`, and replaces the normals and
// emission of the lane.
static void look_up_lane( const RfScene* scene, const Source* from, const RfMaterial* m, RfVertexLanes* v, int i,
                          RfMaterial* here )
{
    int r = from->scratch->index[i];
    uint32_t triangle = from->scratch->triangle[r];
    float bu = from->scratch->u[r], bv = from->scratch->v[r];
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( from->tracer, triangle, &place );
    float facing = rf_dot( t->ng, RF_GET3( v->wo, i ) );
    float share = footprint_share( from, t, v, i );
    rf_material_within( scene, m, triangle, bu, bv, share, here );
    fill_params_of_hit( v, i, here, facing, from->rays, r );
    Hit hit = { .triangle = triangle, .u = bu, .v = bv, .side = facing < 0.0f ? -1.0f : 1.0f };
    look_up_normals( scene, m, &hit, t->ng, v, i );
    if ( v->emission[0][i] + v->emission[1][i] + v->emission[2][i] > 0.0f )
        RF_PUT3( v->emission, i, rf_emission_within( scene, m, triangle, bu, bv, share ) );
}

// The tangents of lanes [first, end), which have their normals. Lane first + k has material number[k].
static void fill_tangents( const RfScene* scene, const Source* from, const RfMaterial* materials, const int32_t* number,
                           int first, int end, RfVertexLanes* v )
{
    for ( int i = first; i < end; ++i )
    {
        int r = from->scratch->index[i];
        uint32_t triangle = from->scratch->triangle[r];
        RfTriangleRecord place;
        const RfTriangleRecord* t = rf_triangle_record( from->tracer, triangle, &place );
        float side = rf_dot( t->ng, RF_GET3( v->wo, i ) ) < 0.0f ? -1.0f : 1.0f;
        RfVec3 n = rf_scale( RF_GET3( v->n, i ), side );
        RF_PUT3( v->param + RF_PARAM_TANGENT, i,
                 rf_stretch_at( scene, materials + number[i - first], triangle, from->scratch->u[r], from->scratch->v[r], n ) );
    }
}

static inline bool has_tangents( RfBsdfKind kind ) { return rf_has_param( rf_bsdf_model( kind )->params, RF_PARAM_TANGENT ); }

#define BLOCK 32 // lanes whose materials are looked up before their parameters are gathered

static void prefetch_block( const RfScene* scene, const Source* from, const RfVertexLanes* v, int first, int end )
{
    RfTexturedPoint points[BLOCK];
    int count = 0;
    for ( int i = first; i < end; ++i )
    {
        const RfMaterial* m = from->materials + v->material[i];
        int r = from->scratch->index[i];
        if ( m->textured != NULL )
            points[count++] = ( RfTexturedPoint ){ m, from->scratch->triangle[r], from->scratch->u[r], from->scratch->v[r] };
    }
    if ( count > 0 )
        rf_prefetch_textures( scene, points, count );
}

static void look_up_block( const RfScene* scene, const Source* from, RfVertexLanes* v, RfBsdfKind kind, int first, int end )
{
    RfMaterial here[BLOCK];
    int32_t number[BLOCK];
    prefetch_block( scene, from, v, first, end );
    for ( int i = first; i < end; ++i )
    {
        const RfMaterial* m = from->materials + v->material[i];
        number[i - first] = i - first;
        if ( m->textured != NULL )
            look_up_lane( scene, from, m, v, i, here + ( i - first ) );
        else
            here[i - first] = *m;
    }
    gather_params( here, number, kind, first, end, v );
    if ( has_tangents( kind ) )
        fill_tangents( scene, from, here, number, first, end, v );
}

static void look_up_textures( const RfScene* scene, const Source* from, RfBsdfKind kind, RfVertexLanes* v )
{
    int end = v->first[kind + 1];
    for ( int first = v->first[kind]; first < end; first += BLOCK )
        look_up_block( scene, from, v, kind, first, end - first < BLOCK ? end : first + BLOCK );
}

// The guide's tables. Surfaces that light is drawn to reach on a side have none.
static void find_tables( const RfGuide* guide, RfVertexLanes* v )
{
    v->guide = guide;
    if ( guide == NULL )
        return;
    int guided = rf_first_sided( v );
    const float *p[3] = { v->p[0], v->p[1], v->p[2] }, *n[3] = { v->n[0], v->n[1], v->n[2] };
    rf_find_guide_tables( guide, guided, p, n, v->table );
    for ( int i = guided; i < rf_record_count( v ); ++i )
        v->table[i] = RF_NOT_GUIDED;
}

// Fills the vertices of the rays' hits, which are in the scratch, as rf_find_vertices does.
static void fill_vertices( const RfPathSettings* settings, const RfRayLanes* rays, bool seen, bool frosted,
                           RfVertexLanes* vertices, RfLaneScratch* scratch )
{
    const RfTracer* tracer = settings->tracer;
    sort_by_kind( tracer, rays, frosted, scratch, vertices );
    const RfMaterial* materials = rf_tracer_scene( tracer )->materials;
    Source from = { .tracer = tracer,
                    .triangles = rf_tracer_records( tracer )->records,
                    .materials = materials,
                    .lights = rf_tracer_lights( tracer ),
                    .rays = rays,
                    .scratch = scratch,
                    .seen = seen };
    bool placed = rf_tracer_has_placements( tracer );
    for ( int i = 0; i < vertices->count && placed; ++i )
        fill_lane( &from, vertices, i, true );
    for ( int i = 0; i < vertices->count && !placed; ++i )
        fill_lane( &from, vertices, i, false );
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        int first = vertices->first[kind], end = vertices->first[kind + 1];
        if ( !rf_is_model_built( (RfBsdfKind)kind ) )
            continue;
        if ( rf_tracer_is_textured( tracer ) )
        {
            look_up_textures( rf_tracer_scene( tracer ), &from, (RfBsdfKind)kind, vertices );
            continue;
        }
        gather_params( materials, vertices->material + first, (RfBsdfKind)kind, first, end, vertices );
        if ( has_tangents( (RfBsdfKind)kind ) )
            fill_tangents( rf_tracer_scene( tracer ), &from, materials, vertices->material + first, first, end, vertices );
    }
    find_tables( settings->guide, vertices );
}

void rf_find_vertices( const RfPathSettings* settings, const RfRayLanes* rays, bool coherent, RfVertexLanes* vertices,
                       RfLaneScratch* scratch )
{
    const float* o[3] = { rays->o[0], rays->o[1], rays->o[2] };
    const float* d[3] = { rays->d[0], rays->d[1], rays->d[2] };
    rf_trace_nearest( settings->tracer, rays->count, o, d, coherent, scratch->triangle, scratch->u, scratch->v );
    fill_vertices( settings, rays, coherent, coherent && settings->frosted, vertices, scratch );
    for ( int i = vertices->first[RF_BSDF_FROSTED]; i < vertices->first[RF_BSDF_FROSTED + 1]; ++i )
        vertices->param[RF_PARAM_CHOICE][i] = 1.0f;
}

// Panes that rays from `first_past` on did not pass, which has the probability 1 − q: what is left of them is
// their base and their reflection.
static void stop_at_panes_of( RfBsdfKind kind, const RfVertexLanes* v, RfRayLanes* rays, int first_past, float* const tint[3] )
{
    RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, kind, 0 );
    for ( int i = v->first[kind]; i < v->first[kind + 1]; ++i )
    {
        RfPane pane = rf_pane_of_lane( kind, &lanes, i, RF_GET3( v->wo, i ) );
        if ( v->ray[i] < first_past || !( pane.probability > 0.0f ) )
            continue;
        float stopped = rf_maxf( 1.0f - pane.probability, 0x1p-24f );
        for ( int c = 0; c < 3; ++c )
        {
            rays->throughput[c][v->ray[i]] /= stopped;
            tint[c][i] = 0.0f;
        }
    }
}

static void stop_at_panes( const RfVertexLanes* v, RfRayLanes* rays, int first_past, float* const tint[3] )
{
    for ( int kind = RF_BSDF_FIRST_SPECULAR; kind < RF_BSDF_KIND_COUNT; ++kind )
        stop_at_panes_of( (RfBsdfKind)kind, v, rays, first_past, tint );
}

// Rays [0, first_past), for which panes are surfaces like any others.
static void trace_to_panes( const RfPathSettings* settings, const RfRayLanes* rays, int first_past, RfLaneScratch* scratch )
{
    const float* o[3] = { rays->o[0], rays->o[1], rays->o[2] };
    const float* d[3] = { rays->d[0], rays->d[1], rays->d[2] };
    rf_trace_nearest( settings->tracer, first_past, o, d, false, scratch->triangle, scratch->u, scratch->v );
    for ( int r = 0; r < first_past; ++r )
        scratch->visible[r] = 1.0f;
}

static void trace_past_panes( const RfPathSettings* settings, RfRayLanes* rays, int first_past, RfLaneScratch* scratch )
{
    int at = first_past, count = rays->count - first_past;
    const float* o[3] = { rays->o[0] + at, rays->o[1] + at, rays->o[2] + at };
    const float* d[3] = { rays->d[0] + at, rays->d[1] + at, rays->d[2] + at };
    RfPaneLanes panes = { .probability = scratch->visible + at,
                          .weight = { scratch->f[0] + at, scratch->f[1] + at, scratch->f[2] + at } };
    rf_trace_nearest_past_panes( settings->tracer, count, o, d, scratch->triangle + at, scratch->u + at, scratch->v + at,
                                 &panes );
    for ( int c = 0; c < 3; ++c )
    {
        for ( int r = 0; r < count; ++r )
            rays->throughput[c][at + r] *= panes.weight[c][r];
    }
}

const float* rf_find_vertices_past_panes( const RfPathSettings* settings, RfRayLanes* rays, int first_past,
                                          RfVertexLanes* vertices, RfLaneScratch* scratch )
{
    if ( !rf_tracer_has_panes( settings->tracer ) )
    {
        rf_find_vertices( settings, rays, false, vertices, scratch );
        return NULL;
    }
    trace_to_panes( settings, rays, first_past, scratch );
    trace_past_panes( settings, rays, first_past, scratch );
    fill_vertices( settings, rays, false, false, vertices, scratch );
    float* tint[3] = { vertices->param[RF_PARAM_TINT], vertices->param[RF_PARAM_TINT + 1], vertices->param[RF_PARAM_TINT + 2] };
    stop_at_panes( vertices, rays, first_past, tint );
    return scratch->visible;
}

// ---- The sides of translucent surfaces and of rough glass on which light is drawn to arrive (src/reuse/estimators.md, section 20)

static RfVec3 colour_at( const RfVertexLanes* v, RfBsdfParam param, int i ) { return RF_GET3( v->param + param, i ); }

static float through_probability_of( const RfVertexLanes* v, int i )
{
    if ( i >= v->first[RF_BSDF_FROSTED] )
    {
        RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, RF_BSDF_FROSTED, 0 );
        return rf_frosted_through_probability( &lanes, i );
    }
    return rf_through_probability( colour_at( v, RF_PARAM_THROUGH, i ), colour_at( v, RF_PARAM_DIFFUSE, i ),
                                   colour_at( v, RF_PARAM_SPECULAR, i ), v->param[RF_PARAM_F90][i] );
}

void rf_draw_sides( const RfWavefront* keys, int vertex, RfVertexLanes* v )
{
    int first = rf_first_sided( v ), count = rf_record_count( v ) - first;
    if ( count == 0 )
        return;
    float u[1][RF_LANES];
    rf_draw_lanes( keys, count, v->slot + first, RF_DIMENSION_SIDES + (uint32_t)vertex, 1, u );
    for ( int i = first; i < first + count; ++i )
    {
        float p = through_probability_of( v, i );
        float side = u[0][i - first] < p ? -1.0f : 1.0f;
        v->param[RF_PARAM_CHOICE][i] = side;
        for ( int c = 0; c < 3; ++c )
        {
            v->n[c][i] *= side;
            v->ng[c][i] *= side;
        }
    }
}

void rf_face_rays( RfVertexLanes* v )
{
    for ( int i = rf_first_sided( v ); i < rf_record_count( v ); ++i )
    {
        for ( int c = 0; c < 3; ++c )
            v->ng[c][i] *= v->param[RF_PARAM_CHOICE][i];
    }
}
