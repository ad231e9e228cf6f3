// Walks chains from the light with their differentials; Newton steps move them to points.
#include "light_paths/manifold_walk.h"

#include "bsdf/bsdf.h"

#define MOST_STEPS 12
#define LEAST_DAMPING 0.05f
#define RELATIVE_MISS 2e-5f // of the last segment's length
#define ABSOLUTE_MISS 1e-6f // of the scene's radius
// Where a normal is nearly perpendicular to a direction, cameras would be lifted to the horizon (bsdf/bsdf.h); chains end.
#define MIN_COS RF_MIN_COS

static RfPaneLanes lanes_of( RfPassedPanes* panes )
{
    return ( RfPaneLanes ){ .probability = panes->probability,
                            .weight = { panes->weight[0], panes->weight[1], panes->weight[2] } };
}

void rf_trace_light( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], uint32_t* triangle,
                     float* u, float* v, RfPassedPanes* panes )
{
    RfPaneLanes lanes = lanes_of( panes );
    panes->any = rf_tracer_has_panes( tracer );
    if ( panes->any )
        rf_trace_nearest_through_panes( tracer, count, o, d, triangle, u, v, &lanes );
    else
        rf_trace_nearest( tracer, count, o, d, false, triangle, u, v );
}

void rf_trace_light_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float* visible,
                              RfPassedPanes* panes )
{
    RfPaneLanes lanes = lanes_of( panes );
    panes->any = rf_tracer_has_panes( tracer );
    if ( panes->any )
        rf_trace_segments_past_panes( tracer, count, o, d, visible, &lanes );
    else
        rf_trace_segments( tracer, count, o, d, visible );
}

// Transfers the differentials to the plane of a surface at the hit.
static void transfer( RfRayPair* ray, RfVec3 p, RfVec3 n )
{
    float along = rf_dot( ray->d, n ), t = rf_dot( rf_sub( p, ray->o ), n ) / along;
    for ( int k = 0; k < 2; ++k )
    {
        RfVec3 moved = rf_madd( ray->dp[k], ray->dd[k], t );
        ray->dp[k] = rf_madd( moved, ray->d, -rf_dot( moved, n ) / along );
    }
    ray->o = p;
}

// The derivative of the shading normal along dp.
static RfVec3 normal_change( const RfTriangleRecord* t, const RfChainVertex* v, RfVec3 n, float sign, RfVec3 dp )
{
    if ( v->normal_scale == 0.0f )
        return rf_vec3( 0, 0, 0 );
    RfVec3 cross = rf_cross( t->e1, t->e2 );
    float inverse = 1.0f / rf_dot( cross, cross );
    float du = rf_dot( dp, rf_cross( t->e2, cross ) ) * inverse, dv = rf_dot( dp, rf_cross( cross, t->e1 ) ) * inverse;
    RfVec3 raw = rf_add( rf_scale( t->d1, du ), rf_scale( t->d2, dv ) );
    raw = rf_sub( raw, rf_scale( n, rf_dot( n, raw ) ) );
    return rf_scale( raw, v->normal_scale * sign );
}

// The refracted direction; false: total reflection.
static bool refract( RfVec3 d, RfVec3 n, float eta, RfVec3* out )
{
    float c = -rf_dot( d, n ), inverse = 1.0f / eta, cos2 = 1.0f - inverse * inverse * ( 1.0f - c * c );
    if ( cos2 <= 0.0f )
        return false;
    *out = rf_normalize( rf_madd( rf_scale( d, inverse ), n, inverse * c - sqrtf( cos2 ) ) );
    return true;
}

// The facet of a vertex that reflects, and how it turns where the shading normal does.
static RfVec3 facet_of( const RfChainVertex* v, RfVec3 n, RfVec3* turns )
{
    RfVec3 t, b, dn = *turns;
    float sign = copysignf( 1.0f, n.z ), a = -1.0f / ( sign + n.z ), da = a * a * dn.z;
    float dc = ( dn.x * n.y + n.x * dn.y ) * a + n.x * n.y * da;
    RfVec3 dt = rf_vec3( sign * n.x * ( 2.0f * dn.x * a + n.x * da ), sign * dc, -sign * dn.x ),
           db = rf_vec3( dc, n.y * ( 2.0f * dn.y * a + n.y * da ), -dn.y );
    float up = sqrtf( rf_maxf( 1.0f - v->at[0] * v->at[0] - v->at[1] * v->at[1], 0.0f ) );
    rf_basis( n, &t, &b );
    *turns = rf_add( rf_add( rf_scale( dt, v->at[0] ), rf_scale( db, v->at[1] ) ), rf_scale( dn, up ) );
    return rf_add( rf_add( rf_scale( t, v->at[0] ), rf_scale( b, v->at[1] ) ), rf_scale( n, up ) );
}

// Propagates the differentials through reflection or refraction towards `out`. n is on the side that it comes from, eta as
// seen from there; sign is −1 where that is not the side that the light comes from.
static void scatter_pair( RfRayPair* ray, const RfTriangleRecord* t, const RfChainVertex* v, RfVec3 n, float eta, float sign,
                          RfVec3 out )
{
    RfVec3 d = ray->d, shading = n;
    if ( v->facet )
    {
        RfVec3 still = rf_vec3( 0, 0, 0 );
        n = facet_of( v, shading, &still );
    }
    float c = -rf_dot( d, n );
    for ( int k = 0; k < 2; ++k )
    {
        RfVec3 dn = normal_change( t, v, shading, sign, ray->dp[k] ), dd = ray->dd[k];
        if ( v->facet )
            facet_of( v, shading, &dn );
        float dc = -( rf_dot( dd, n ) + rf_dot( d, dn ) );
        if ( v->refracted )
        {
            float inverse = 1.0f / eta, ct = sqrtf( rf_maxf( 1.0f - inverse * inverse * ( 1.0f - c * c ), 1e-12f ) );
            float dct = inverse * inverse * c * dc / ct;
            ray->dd[k] = rf_add( rf_madd( rf_scale( dd, inverse ), n, inverse * dc - dct ), rf_scale( dn, inverse * c - ct ) );
        }
        else
            ray->dd[k] = rf_add( dd, rf_add( rf_scale( n, 2.0f * dc ), rf_scale( dn, 2.0f * c ) ) );
    }
    ray->d = out;
}

void rf_begin_chain( RfChain* chain )
{
    const RfEmission* e = &chain->start;
    RfVec3 t, b, none = rf_vec3( 0, 0, 0 );
    rf_basis( e->direction, &t, &b );
    chain->end = ( RfRayPair ){ .o = rf_madd( e->position, e->normal, e->offset ), .d = e->direction };
    for ( int k = 0; k < 2; ++k )
    {
        RfVec3 unit = k == 0 ? t : b;
        chain->end.dp[k] = e->infinite ? unit : none;
        chain->end.dd[k] = e->infinite ? none : unit;
    }
    chain->length = 0;
    chain->weight = rf_vec3( 1, 1, 1 );
    chain->probability = chain->passes = 1.0f;
    chain->way = 0.0f;
    chain->end_absorption = none;
}

static RfVec3 transmittance( RfVec3 absorption, float distance )
{
    return rf_vec3( expf( -absorption.x * distance ), expf( -absorption.y * distance ), expf( -absorption.z * distance ) );
}

// The geometry of a vertex. False: its normals disagree.
static bool fill_vertex( const RfTriangleRecord* t, float u, float v, const RfMaterial* m, const RfRayPair* ray,
                         RfChainVertex* out, float* facing )
{
    RfHitPoint hit = rf_hit_point( t, u, v, ray->o, ray->d );
    *facing = -rf_dot( t->ng, ray->d );
    float side = *facing < 0.0f ? -1.0f : 1.0f;
    RfVec3 ng = rf_scale( t->ng, side );
    *out = ( RfChainVertex ){ .p = hit.p, .n = ng };
    if ( !t->flat )
    {
        RfVec3 n = rf_add( t->n0, rf_add( rf_scale( t->d1, u ), rf_scale( t->d2, v ) ) );
        float length = rf_length( n );
        RfVec3 unit = rf_scale( n, side / length );
        if ( length > 1e-6f && rf_dot( unit, ng ) > 0.0f )
        {
            out->n = unit;
            out->normal_scale = side / length;
        }
    }
    out->eta = *facing >= 0.0f || m->ior == 0.0f ? m->ior : 1.0f / m->ior;
    return -rf_dot( out->n, ray->d ) > MIN_COS;
}

// Reflects or refracts at the vertex. False: the event is impossible there.
static bool take_event( const RfMaterial* m, RfChainVertex* v, RfVec3 ng, RfChainEvents events, float random, RfChain* chain )
{
    RfVec3 d = chain->end.d, reflected, transmitted;
    float cos_o = -rf_dot( d, v->n );
    rf_glass_delta_lobes( m, v->eta, cos_o, &reflected, &transmitted );
    float r = reflected.x + reflected.y + reflected.z, t = transmitted.x + transmitted.y + transmitted.z;
    float reflect = r + t > 0.0f ? r / ( r + t ) : 0.0f;
    int k = chain->length;
    v->refracted = events == RF_CHAIN_DRAW ? random >= reflect : ( chain->events >> k & 1u ) != 0;
    chain->probability *= v->refracted ? 1.0f - reflect : reflect;
    if ( v->refracted && ( v->eta == 0.0f || !refract( d, v->n, v->eta, &v->out ) ) )
        return false;
    if ( !v->refracted )
        v->out = rf_sub( d, rf_scale( v->n, 2.0f * rf_dot( d, v->n ) ) );
    if ( events == RF_CHAIN_DRAW )
        chain->events = ( chain->events & ~( 1u << k ) ) | (uint32_t)v->refracted << k;
    // radiance scales with the squared index, from the end's side
    RfVec3 left = v->refracted ? rf_scale( transmitted, v->eta * v->eta ) : reflected;
    chain->weight = rf_mul( chain->weight, left );
    float cos_n = rf_dot( v->out, v->n ), cos_g = rf_dot( v->out, ng );
    return cos_n * cos_g > 0.0f && ( cos_n < 0.0f ) == v->refracted && fabsf( cos_n ) > MIN_COS &&
           rf_max_component( chain->weight ) > 0.0f && chain->probability > 0.0f;
}

static float smith( float alpha, float cosine ) { return sqrtf( alpha * alpha + ( 1.0f - alpha * alpha ) * cosine * cosine ); }

// Reflects at the facet of a plate: what the GGX lobe reflects, over the density D (n·h) of drawing the facet
// (src/reuse/estimators.md, section 16). False: it is turned away.
static bool take_facet( const RfMaterial* m, RfChainVertex* v, RfVec3 ng, RfChain* chain )
{
    RfVec3 d = chain->end.d, still = rf_vec3( 0, 0, 0 );
    v->facet = true;
    v->at[0] = chain->facet[0];
    v->at[1] = chain->facet[1];
    RfVec3 h = facet_of( v, v->n, &still );
    float cos_h = -rf_dot( d, h ), cos_i = -rf_dot( d, v->n ), up = rf_dot( h, v->n );
    v->out = rf_normalize( rf_madd( d, h, 2.0f * cos_h ) );
    float cos_o = rf_dot( v->out, v->n );
    if ( !( cos_h > 0.0f && cos_o > MIN_COS && up > 0.0f && rf_dot( v->out, ng ) > 0.0f ) )
        return false;
    float miss = rf_maxf( 1.0f - cos_h, 0.0f ), w = miss * miss * miss * miss * miss;
    float shadow = 2.0f * cos_o * cos_i / ( cos_o * smith( m->alpha, cos_i ) + cos_i * smith( m->alpha, cos_o ) );
    float grazing = w * m->f90, scale = shadow * cos_h / ( cos_o * up );
    RfVec3 fresnel = rf_add( rf_scale( m->specular, 1.0f - w ), rf_vec3( grazing, grazing, grazing ) );
    chain->weight = rf_mul( chain->weight, rf_scale( fresnel, scale ) );
    v->flux_scale = cos_o / cos_i;
    return rf_max_component( chain->weight ) > 0.0f;
}

bool rf_step_chain( const RfTracer* tracer, uint32_t triangle, float bu, float bv, RfChainEvents events, RfRandomKey key,
                    RfChain* chain )
{
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, triangle, &place );
    const RfMaterial* m = rf_tracer_scene( tracer )->materials + t->material;
    RfChainVertex* v = chain->vertex + chain->length;
    float facing;
    if ( !fill_vertex( t, bu, bv, m, &chain->end, v, &facing ) )
        return false;
    v->triangle = triangle;
    RfVec3 ng = rf_scale( t->ng, facing < 0.0f ? -1.0f : 1.0f );
    RfVec3 from = chain->length > 0 ? chain->vertex[chain->length - 1].p : chain->start.position;
    float distance = rf_length( rf_sub( v->p, from ) );
    chain->way += distance;
    if ( chain->length == 0 )
    {
        chain->first_triangle = triangle;
        chain->first_area_pdf = chain->start.infinite ? fabsf( facing ) : fabsf( facing ) / ( distance * distance );
    }
    else if ( facing < 0.0f )
        chain->weight = rf_mul( chain->weight, transmittance( m->absorption, distance ) );
    transfer( &chain->end, v->p, t->ng );
    bool goes_on = chain->plate != 0 ? take_facet( m, v, ng, chain )
                                     : take_event( m, v, ng, events, rf_random( key, (uint32_t)chain->length ), chain );
    if ( !goes_on )
        return false;
    scatter_pair( &chain->end, t, v, v->n, v->eta, 1.0f, v->out );
    float offset = rf_hit_point( t, bu, bv, from, v->out ).offset;
    chain->end.o = rf_madd( v->p, ng, v->refracted ? -offset : offset );
    bool inside = rf_dot( v->out, t->ng ) < 0.0f;
    chain->ends_inside = inside && m->ior > 0.0f;
    chain->end_absorption = inside ? m->absorption : rf_vec3( 0, 0, 0 );
    chain->length += 1;
    return true;
}

typedef struct Rays
{
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK];
    uint32_t triangle[RF_CHAIN_BLOCK];
    float u[RF_CHAIN_BLOCK], v[RF_CHAIN_BLOCK];
    int index[RF_CHAIN_BLOCK];
    int count;
} Rays;

static void add_ray( Rays* rays, int index, const RfRayPair* ray )
{
    int k = rays->count++;
    RF_PUT3( rays->o, k, ray->o );
    RF_PUT3( rays->d, k, ray->d );
    rays->index[k] = index;
}

// Whether the chain begins at a plate: drawn, it has a facet, drawn in proportion to its area as seen along the normal.
static bool begins_at_plate( const RfMaterial* materials, uint32_t material, RfChainEvents events, const RfRandomKey* key,
                             RfChain* chain )
{
    if ( chain->length > 0 || !rf_is_plate( materials + material ) )
        return false;
    if ( events == RF_CHAIN_COPY )
        return chain->plate == material + 1;
    if ( !chain->start.delta_position && !chain->start.delta_direction )
        return false;
    float u = rf_random( *key, RF_MAX_CHAIN ), phi = 2.0f * RF_PI * rf_random( *key, RF_MAX_CHAIN + 1 );
    float alpha = materials[material].alpha, tan2 = alpha * alpha * u / ( 1.0f - u ), sine = sqrtf( tan2 / ( 1.0f + tan2 ) );
    chain->plate = material + 1;
    chain->facet[0] = sine * cosf( phi );
    chain->facet[1] = sine * sinf( phi );
    return true;
}

void rf_walk_chains( const RfTracer* tracer, RfChainEvents events, const RfRandomKey* keys, const bool* active, int count,
                     RfChain* const* chains, RfLanding* land, uint64_t* ray_count )
{
    RfTriangleRecord place;
    const RfMaterial* materials = rf_tracer_scene( tracer )->materials;
    int wanted[RF_CHAIN_BLOCK];
    Rays rays = { .count = 0 };
    for ( int i = 0; i < count; ++i )
    {
        if ( !active[i] )
            continue;
        wanted[i] = events == RF_CHAIN_COPY ? chains[i]->length : RF_MAX_CHAIN;
        chains[i]->plate = events == RF_CHAIN_COPY ? chains[i]->plate : 0;
        rf_begin_chain( chains[i] );
        add_ray( &rays, i, &chains[i]->end );
    }
    while ( rays.count > 0 )
    {
        Rays now = rays;
        RfPassedPanes panes;
        const float *o[3] = { now.o[0], now.o[1], now.o[2] }, *d[3] = { now.d[0], now.d[1], now.d[2] };
        rf_trace_light( tracer, now.count, o, d, now.triangle, now.u, now.v, &panes );
        *ray_count += (uint64_t)now.count;
        rays.count = 0;
        for ( int k = 0; k < now.count; ++k )
        {
            int i = now.index[k];
            RfChain* chain = chains[i];
            uint32_t triangle = now.triangle[k];
            uint32_t material = triangle != RF_MISS ? rf_triangle_material( tracer, triangle ) : 0;
            const RfMaterial* m = triangle != RF_MISS ? materials + material : NULL;
            bool delta = m != NULL && ( ( rf_is_chain_surface( m ) && chain->plate == 0 ) ||
                                        begins_at_plate( materials, material, events, keys != NULL ? keys + i : NULL, chain ) );
            bool full = chain->length == wanted[i];
            if ( panes.any )
                rf_pass_panes( &panes, k, chain );
            if ( delta && !full &&
                 rf_step_chain( tracer, triangle, now.u[k], now.v[k], events, keys != NULL ? keys[i] : ( RfRandomKey ){ 0, 0 },
                                chain ) )
            {
                if ( events == RF_CHAIN_DRAW || chain->length < wanted[i] || land != NULL )
                    add_ray( &rays, i, &chain->end );
                continue;
            }
            bool lands = !delta && m != NULL && m->kind < RF_BSDF_FIRST_SPECULAR && land != NULL && chain->length > 0 &&
                         ( events == RF_CHAIN_DRAW || full );
            if ( !lands )
            {
                chain->length = 0;
                continue;
            }
            land->triangle[i] = triangle;
            RfHitPoint hit =
                rf_hit_point( rf_triangle_record( tracer, triangle, &place ), now.u[k], now.v[k], chain->end.o, chain->end.d );
            land->u[i] = now.u[k];
            land->v[i] = now.v[k];
            land->p[i] = hit.p;
            land->offset[i] = hit.offset;
        }
    }
}

bool rf_meet_plane( const RfRayPair* ray, RfVec3 p, RfVec3 n, RfVec3* meet, RfVec3 moves[2] )
{
    float along = rf_dot( ray->d, n ), t = rf_dot( rf_sub( p, ray->o ), n ) / along;
    if ( !( fabsf( along ) > 1e-5f && t > 0.0f ) )
        return false;
    *meet = rf_madd( ray->o, ray->d, t );
    for ( int k = 0; k < 2; ++k )
    {
        RfVec3 moved = rf_madd( ray->dp[k], ray->dd[k], t );
        moves[k] = rf_madd( moved, ray->d, -rf_dot( moved, n ) / along );
    }
    return true;
}

float rf_chain_spread( const RfTracer* tracer, const RfChain* chain, RfVec3 y )
{
    RfTriangleRecord place;
    const RfChainVertex* last = chain->vertex + chain->length - 1;
    RfRayPair ray = { .o = y, .d = rf_normalize( rf_sub( last->p, y ) ) };
    rf_basis( ray.d, ray.dd, ray.dd + 1 );
    for ( int k = chain->length - 1; k >= 0; --k )
    {
        const RfChainVertex* v = chain->vertex + k;
        const RfTriangleRecord* t = rf_triangle_record( tracer, v->triangle, &place );
        RfVec3 in = k > 0 ? chain->vertex[k - 1].out : chain->start.direction;
        float sign = v->refracted ? -1.0f : 1.0f, eta = v->refracted ? 1.0f / v->eta : v->eta;
        transfer( &ray, v->p, t->ng );
        scatter_pair( &ray, t, v, rf_scale( v->n, sign ), eta, sign, rf_scale( in, -1.0f ) );
    }
    if ( chain->start.infinite )
        return fabsf( rf_dot( rf_cross( ray.dd[0], ray.dd[1] ), ray.d ) );
    float distance = rf_length( rf_sub( chain->start.position, ray.o ) );
    RfVec3 a = rf_madd( ray.dp[0], ray.dd[0], distance ), b = rf_madd( ray.dp[1], ray.dd[1], distance );
    return fabsf( rf_dot( rf_cross( a, b ), ray.d ) );
}

bool rf_newton_step( const RfRayPair* ray, RfVec3 y, RfVec3 n, float step[2], float* miss, float* spread )
{
    RfVec3 meet, moves[2];
    if ( !rf_meet_plane( ray, y, n, &meet, moves ) )
        return false;
    RfVec3 f = rf_sub( meet, y );
    *miss = rf_length( f );
    float det = rf_dot( rf_cross( moves[0], moves[1] ), n );
    if ( !( fabsf( det ) > 1e-20f ) )
        return false;
    *spread = fabsf( det );
    step[0] = -rf_dot( rf_cross( f, moves[1] ), n ) / det;
    step[1] = -rf_dot( rf_cross( moves[0], f ), n ) / det;
    return true;
}

// The next step of a walk.
typedef struct Next
{
    float step[2];
    float miss, damping;
    bool walked; // `at` has all its vertices
} Next;

static float tolerance( const RfTracer* tracer, const RfManifoldWalk* b )
{
    return RELATIVE_MISS * rf_length( rf_sub( b->at.end.o, b->y ) ) + ABSOLUTE_MISS * rf_tracer_lights( tracer )->radius;
}

static void start_walk( RfManifoldWalk* b, Next* next )
{
    float spread;
    b->met = false;
    *next = ( Next ){ .damping = 1.0f };
    b->active = b->active && rf_newton_step( &b->at.end, b->y, b->n, next->step, &next->miss, &spread ) &&
                rf_reach_squared( &b->most, next->step[0], next->step[1] ) <= 1.0f;
}

// Accepts or rejects the chain that was tried.
static void judge( const RfTracer* tracer, RfManifoldWalk* b, const RfChain* tried, Next* next )
{
    float step[2], miss, spread;
    if ( tried->length == b->at.length && rf_newton_step( &tried->end, b->y, b->n, step, &miss, &spread ) &&
         ( miss < next->miss || !next->walked ) && ( next->walked || miss < 4.0f * next->miss + tolerance( tracer, b ) ) )
    {
        b->at = *tried;
        *next = ( Next ){ { step[0], step[1] }, miss, rf_minf( 2.0f * next->damping, 1.0f ), true };
        b->met = miss <= tolerance( tracer, b );
        b->active = !b->met;
        return;
    }
    next->damping *= 0.5f;
    b->active = next->damping > LEAST_DAMPING;
}

void rf_walk_manifold( const RfTracer* tracer, int count, RfManifoldWalk* walks, uint64_t* rays )
{
    RfChain tried[RF_CHAIN_BLOCK], *chains[RF_CHAIN_BLOCK];
    Next next[RF_CHAIN_BLOCK];
    bool active[RF_CHAIN_BLOCK];
    for ( int i = 0; i < count; ++i )
    {
        chains[i] = tried + i;
        start_walk( walks + i, next + i );
    }
    for ( int k = 0; k < MOST_STEPS; ++k )
    {
        bool any = false;
        for ( int i = 0; i < count; ++i )
        {
            RfManifoldWalk* b = walks + i;
            active[i] = b->active;
            if ( !b->active )
                continue;
            RfEmission e = b->at.start;
            rf_steer( &e, next[i].damping * next[i].step[0], next[i].damping * next[i].step[1] );
            tried[i].start = e;
            tried[i].events = b->at.events;
            tried[i].length = b->at.length;
            tried[i].plate = b->at.plate;
            tried[i].facet[0] = b->at.facet[0];
            tried[i].facet[1] = b->at.facet[1];
            active[i] = e.infinite || rf_emit_towards( rf_tracer_lights( tracer ), e.direction, &tried[i].start );
            any = true;
            if ( !active[i] )
                tried[i].length = 0;
        }
        if ( !any )
            break;
        rf_walk_chains( tracer, RF_CHAIN_COPY, NULL, active, count, chains, NULL, rays );
        for ( int i = 0; i < count; ++i )
        {
            if ( walks[i].active )
                judge( tracer, walks + i, tried + i, next + i );
        }
    }
    for ( int i = 0; i < count; ++i )
        walks[i].active = false;
}
