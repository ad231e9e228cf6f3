// Embree's filter function: what is there in part, and hits that its floats invent.
#include "trace/bvh.h"

#include "base/fault.h"
#include "base/float_traps.h"
#include "base/random.h"
#include "bsdf/bsdf.h"
#include "scene/textured.h"
#include "trace/far.h"
#include "trace/tracer.h"

#include <string.h>

// Offsets of the fields in Embree's packets (the accessors of its header are C++ only).
enum
{
    RAY_ORIGIN = 0,
    RAY_DIRECTION = 4,
    RAY_FAR = 8, // of the hit
    RAY_ID = 10,
    HIT_U = 3,
    HIT_V = 4,
    HIT_NUMBER = 5,
    HIT_INSTANCE = 7,
};

static uint32_t ray_bits( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    return ( (const uint32_t*)(const void*)args->ray )[row * args->N + lane];
}

// Origin (0 to 2) and direction (3 to 5) of the ray, in Embree's scene of the world: within an instance it has them in the
// mesh's.
static uint32_t world_bits( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    const RfQuery* query = (const RfQuery*)args->context;
    if ( query->tracer->bvh.placed == NULL )
        return ray_bits( args, row < 3 ? RAY_ORIGIN + row : RAY_DIRECTION + row - 3, lane );
    uint32_t bits;
    memcpy( &bits, query->world[row] + ray_bits( args, RAY_ID, lane ), sizeof bits );
    return bits;
}

static RfVec3 world_vec3( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    float v[3];
    for ( unsigned int c = 0; c < 3; ++c )
    {
        uint32_t bits = world_bits( args, row + c, lane );
        memcpy( v + c, &bits, sizeof bits );
    }
    return rf_vec3( v[0], v[1], v[2] );
}

// Uniform in [0, 1), a hash of the ray and the triangle.
static float random_of_ray( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle )
{
    uint32_t hash = rf_mix32( triangle + 0x9e3779b9u );
    for ( unsigned int c = 0; c < 3; ++c )
    {
        hash = rf_mix32( hash ^ world_bits( args, c, lane ) );
        hash = rf_mix32( hash ^ world_bits( args, 3 + c, lane ) );
    }
    return (float)( hash >> 8 ) * 0x1p-24f;
}

// Decides stochastically whether the ray hits a blended surface.
static bool hits_blended( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle, float opacity )
{
    RfQuery* query = (RfQuery*)args->context;
    if ( query->kind == RF_QUERY_NEAREST )
        return random_of_ray( args, lane, triangle ) < opacity;
    float* left = query->transmittance + ray_bits( args, RAY_ID, lane );
    *left *= 1.0f - opacity;
    return *left <= 0.0f;
}

// A point on a triangle that a ray meets.
typedef struct Crossing
{
    uint32_t triangle;
    float u, v;
    RfVec3 d; // of the ray, of any length; where the triangle may be a pane
} Crossing;

static RfVec3 front_normal( const RfTriangleRecord* t, float u, float v )
{
    if ( t->flat )
        return t->ng;
    RfVec3 n = rf_add( t->n0, rf_add( rf_scale( t->d1, u ), rf_scale( t->d2, v ) ) );
    float length2 = rf_dot( n, n );
    n = rf_scale( n, 1.0f / sqrtf( length2 ) );
    return rf_dot( n, t->ng ) > 0.0f && length2 > 1e-12f ? n : t->ng;
}

// The pane at a crossing, with the holes that its alpha leaves.
static RfPane pane_at( const RfTracer* tracer, const Crossing* x, float opacity )
{
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, x->triangle, &place );
    const RfScene* scene = tracer->scene;
    const RfMaterial* material = scene->materials + t->material;
    RfMaterial here;
    RfVec3 n = front_normal( t, x->u, x->v );
    if ( material->textured != NULL )
    {
        rf_material_at( scene, material, x->triangle, x->u, x->v, &here );
        n = rf_normal_at( scene, material, x->triangle, x->u, x->v, n, t->ng );
        material = &here;
    }
    float cos_o = rf_dot( n, x->d ) / rf_length( x->d );
    RfPane pane = rf_pane_of_material( material, rf_dot( t->ng, x->d ) < 0.0f ? -cos_o : cos_o );
    float hole = 1.0f - opacity;
    if ( !( pane.probability > 0.0f ) || hole <= 0.0f )
        return pane;
    return ( RfPane ){
        hole + opacity * pane.probability,
        rf_add( rf_vec3( hole, hole, hole ), rf_scale( pane.colour, opacity ) ),
    };
}

// Panes come in any order.
static void note_first( RfQuery* query, uint32_t id, uint32_t triangle, uint32_t bits )
{
    float at;
    memcpy( &at, &bits, sizeof at );
    bool before = at < query->first_at[id];
    query->first_pane[id] = before ? triangle : query->first_pane[id];
    query->first_at[id] = before ? at : query->first_at[id];
}

static bool hits_pane( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle, RfPane pane )
{
    RfQuery* query = (RfQuery*)args->context;
    uint32_t id = ray_bits( args, RAY_ID, lane );
    if ( query->kind == RF_QUERY_NEAREST )
    {
        bool hits = !query->surely && random_of_ray( args, lane, triangle ) >= pane.probability;
        query->passed |= !hits;
        return hits;
    }
    query->passed = true;
    if ( query->notes_first )
        note_first( query, id, triangle, ray_bits( args, RAY_FAR, lane ) );
    query->pane_probability[id] *= pane.probability;
    query->pane_weight[0][id] *= pane.colour.x / pane.probability;
    query->pane_weight[1][id] *= pane.colour.y / pane.probability;
    query->pane_weight[2][id] *= pane.colour.z / pane.probability;
    return query->pane_probability[id] <= 0.0f;
}

// Whether a surface that is there in part, or a pane, stops the ray.
static bool is_hit( const struct RTCFilterFunctionNArguments* args, unsigned int lane, const Crossing* x, float opacity,
                    bool may_be_pane )
{
    if ( may_be_pane )
    {
        RfPane pane = pane_at( ( (const RfQuery*)args->context )->tracer, x, opacity );
        if ( pane.probability > 0.0f )
            return hits_pane( args, lane, x->triangle, pane );
    }
    return opacity >= 1.0f || hits_blended( args, lane, x->triangle, opacity );
}

// A far triangle that the ray does not reach, though Embree's floats say so: mostly the one that it starts from.
static bool misses_far( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle )
{
    const RfQuery* query = (const RfQuery*)args->context;
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( query->tracer, triangle, &place );
    float scale = 1.0f / query->tracer->bvh.base.scale;
    RfVec3 o = rf_scale( world_vec3( args, 0, lane ), scale ), d = rf_scale( world_vec3( args, 3, lane ), scale );
    double distance;
    if ( !t->far )
        return false;
    if ( !rf_cross_plane( t, o, d, &distance ) || !( distance > 0.0 ) )
        return true;
    return query->kind == RF_QUERY_SEGMENTS && distance > 1.0;
}

// What a lane may have hit.
static RfTriangleAt locate_hit( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t* triangle )
{
    const RfMeshBvh* mesh = args->geometryUserPtr;
    const RfTracer* tracer = ( (const RfQuery*)args->context )->tracer;
    const unsigned int* hit = (const unsigned int*)(const void*)args->hit + lane;
    RfTriangleAt at = { mesh->triangles, mesh->order[mesh->masked_first + hit[HIT_NUMBER * args->N]], NULL };
    *triangle = at.index;
    if ( tracer->bvh.placed == NULL || hit[HIT_INSTANCE * args->N] == RTC_INVALID_GEOMETRY_ID )
        return at;
    at.placement = tracer->scene->placements + ( hit[HIT_INSTANCE * args->N] - RF_GEOMETRY_PLACEMENTS );
    *triangle += at.placement->first;
    return at;
}

static void filter_hits( const struct RTCFilterFunctionNArguments* args )
{
    const RfMeshBvh* mesh = args->geometryUserPtr;
    const RfQuery* query = (const RfQuery*)args->context;
    const RfScene* scene = query->tracer->scene;
    const float* u = (const float*)(const void*)args->hit + HIT_U * args->N;
    const float* v = (const float*)(const void*)args->hit + HIT_V * args->N;
    for ( unsigned int i = 0; i < args->N; ++i )
    {
        if ( args->valid[i] == 0 )
            continue;
        Crossing x = { .u = u[i], .v = v[i] };
        RfTriangleAt at = locate_hit( args, i, &x.triangle );
        if ( mesh->far && !RF_FAULT( far_filter ) && misses_far( args, i, x.triangle ) )
        {
            args->valid[i] = 0;
            continue;
        }
        const RfMaterial* material = scene->materials + at.triangles->material[at.index];
        bool may_be_pane = query->pass_panes && rf_may_be_pane( material );
        bool ignored = query->kind == RF_QUERY_PANES && ( !may_be_pane || x.triangle == query->hit[ray_bits( args, RAY_ID, i )] );
        float opacity = material->textured != NULL ? rf_opacity_on( scene, material, at.triangles, at.index, u[i], v[i] ) : 1.0f;
        if ( may_be_pane )
            x.d = world_vec3( args, 3, i );
        if ( ignored || opacity <= 0.0f || !is_hit( args, i, &x, opacity, may_be_pane ) || query->kind == RF_QUERY_PANES )
            args->valid[i] = 0;
    }
}

void rf_filter_hits( const struct RTCFilterFunctionNArguments* args )
{
    if ( ( (const RfQuery*)args->context )->kind == RF_QUERY_GHOSTS )
        return; // ghosts are there as a whole
    // Embree, which calls this, runs without traps
    rf_resume_float_traps( ( (const RfQuery*)args->context )->traps );
    filter_hits( args );
    rf_pause_float_traps();
}
