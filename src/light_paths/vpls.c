#include "light_paths/vpls.h"

#include "light_paths/solve.h"
#include "scene/textured.h"

#include <string.h>

#define FOOTPRINT_MARGIN 1.3f // over what planes tell
#define LEAST_COSINE 0.2f     // at which particles land, for their footprints
#define MOST_FOOTPRINT 4.0f   // in those of light paths
#define PARTICLES 0x9e3779b9u // makes the key of what is scattered

static size_t aligned( size_t bytes ) { return ( bytes + 63 ) / 64 * 64; }

size_t rf_scattered_bytes( size_t n )
{
    n *= RF_SCATTERED_PER_PATH;
    return aligned( n * sizeof( RfScatteredPath ) ) + aligned( n * sizeof( uint32_t ) ) +
           aligned( n * sizeof( RfFootprintNode ) );
}

void rf_lay_out_scattered( RfLightPaths* paths, void* memory )
{
    size_t n = (size_t)paths->emitted * RF_SCATTERED_PER_PATH;
    char* at = memory;
    paths->scattered = (RfScatteredPath*)(void*)at;
    at += aligned( n * sizeof( RfScatteredPath ) );
    paths->scattered_tree = ( RfFootprintTree ){ .boxes = (const char*)paths->scattered, .stride = sizeof *paths->scattered };
    paths->scattered_tree.order = (uint32_t*)(void*)at;
    paths->scattered_tree.node = (RfFootprintNode*)(void*)( at + aligned( n * sizeof( uint32_t ) ) );
    paths->vpl_connections = RF_VPL_CONNECTIONS / (float)paths->emitted;
}

static RfVec3 shading_normal( const RfScene* scene, const RfMaterial* m, const RfTriangleRecord* t, const RfVpl* vpl, float side )
{
    RfVec3 n = vpl->ng;
    if ( !t->flat )
    {
        RfVec3 raw = rf_add( t->n0, rf_add( rf_scale( t->d1, vpl->u ), rf_scale( t->d2, vpl->v ) ) );
        float length2 = rf_dot( raw, raw );
        raw = rf_scale( raw, side / sqrtf( rf_maxf( length2, 1e-30f ) ) );
        n = rf_dot( raw, vpl->ng ) > 0.0f && length2 > 1e-12f ? raw : n;
    }
    if ( m->textured == NULL || m->textured->refs[RF_TEXTURE_NORMAL].texture < 0 )
        return n;
    return rf_scale( rf_normal_at( scene, m, vpl->triangle, vpl->u, vpl->v, rf_scale( n, side ), t->ng ), side );
}

void rf_set_vpl( const RfTracer* tracer, const RfLightPaths* paths, const RfChain* chain, const RfLanding* land, int i,
                 RfLightPath* path )
{
    RfVpl* vpl = &path->vpl;
    const RfScene* scene = rf_tracer_scene( tracer );
    const RfTriangleRecord* t = rf_tracer_triangles( tracer ) + land->triangle[i];
    const RfMaterial* m = scene->materials + t->material;
    RfVec3 wi = rf_scale( path->end.d, -1.0f );
    float side = rf_dot( t->ng, wi ) < 0.0f ? -1.0f : 1.0f, step[2], miss, spread = 0.0f;
    *vpl = ( RfVpl ){
        .ng = rf_scale( t->ng, side ), .triangle = land->triangle[i], .u = land->u[i], .v = land->v[i], .offset = land->offset[i]
    };
    vpl->n = shading_normal( scene, m, t, vpl, side );
    float shape = m->alpha;
    if ( m->textured != NULL )
    {
        RfMaterial here;
        rf_material_at( scene, m, vpl->triangle, vpl->u, vpl->v, &here );
        shape = here.alpha;
    }
    bool reached = rf_newton_step( &path->end, path->at.p, vpl->ng, step, &miss, &spread );
    vpl->area = rf_reach_area( &path->reach ) * spread / paths->connections;
    vpl->share = rf_connection_weight( paths, path->chance, -rf_dot( vpl->n, path->end.d ), 2 );
    vpl->falloff =
        rf_emission_falloff( &path->start, chain->way + rf_length( rf_sub( path->at.p, chain->vertex[chain->length - 1].p ) ) );
    vpl->scatters = reached && rf_may_scatter( tracer, chain ) && vpl->falloff > 0.0f && path->length > 0 &&
                    rf_is_matte( m->kind, shape ) && rf_dot( vpl->n, wi ) > 0.0f;
}

float rf_scattered_radius( const RfLightPaths* paths, const RfLightPath* path, RfVec3 hit, RfVec3 ng )
{
    RfVec3 way = rf_sub( hit, rf_vpl_start( path ) );
    float distance = rf_length( way ), inverse = 1.0f / rf_maxf( distance, 1e-20f );
    float leaves = rf_dot( way, path->vpl.ng ) * inverse, lands = fabsf( rf_dot( way, ng ) ) * inverse;
    float radius = FOOTPRINT_MARGIN * sqrtf( rf_vpl_cone( paths, leaves ) ) * distance / rf_maxf( lands, LEAST_COSINE );
    return rf_minf( radius, MOST_FOOTPRINT * paths->most_radius );
}

// A direction by the cosine. Particle `number` of the set, from a sequence of low discrepancy (Roberts, R2).
static RfVec3 draw_direction( RfRandomKey shift, uint32_t number, RfVec3 n )
{
    double a = (double)number * 0.75487766624669276 + (double)rf_random( shift, 2 );
    double b = (double)number * 0.56984029099805327 + (double)rf_random( shift, 3 );
    float u = (float)( a - floor( a ) ), phi = 2.0f * RF_PI * (float)( b - floor( b ) ), sine = sqrtf( u );
    RfVec3 t, s;
    rf_basis( n, &t, &s );
    RfVec3 across = rf_add( rf_scale( t, sine * cosf( phi ) ), rf_scale( s, sine * sinf( phi ) ) );
    return rf_normalize( rf_madd( across, n, sqrtf( rf_maxf( 1.0f - u, 0.0f ) ) ) );
}

// Particles `first` and those that follow it.
static uint64_t scatter_block( const RfEstimatorGroup* group, RfLightPaths* paths, RfRandomKey shift, uint32_t first,
                               uint32_t count )
{
    const RfTriangleRecord* triangles = rf_tracer_triangles( group->tracer );
    const RfMaterial* materials = rf_tracer_scene( group->tracer )->materials;
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK], u[RF_CHAIN_BLOCK], v[RF_CHAIN_BLOCK];
    uint32_t hit[RF_CHAIN_BLOCK], number[RF_CHAIN_BLOCK];
    int rays = 0;
    for ( uint32_t k = first; k < first + count; ++k )
    {
        const RfLightPath* path = paths->path + k / RF_SCATTERED_PER_PATH;
        paths->scattered[k].at.half.x = 0.0f;
        if ( !path->vpl.scatters )
            continue;
        RfVec3 from = rf_vpl_start( path ), way = draw_direction( shift, k, path->vpl.ng );
        rf_put_ray( o, d, rays, from, way );
        number[rays++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    rf_trace_nearest( group->tracer, rays, from, way, false, hit, u, v );
    for ( int k = 0; k < rays; ++k )
    {
        if ( hit[k] == RF_MISS || materials[triangles[hit[k]].material].kind >= RF_BSDF_FIRST_SPECULAR )
            continue;
        const RfTriangleRecord* t = triangles + hit[k];
        uint32_t path = number[k] / RF_SCATTERED_PER_PATH;
        RfVec3 p = rf_hit_point( t, u[k], v[k], rf_vec3( o[0][k], o[1][k], o[2][k] ), rf_vec3( d[0][k], d[1][k], d[2][k] ) ).p;
        float radius = rf_scattered_radius( paths, paths->path + path, p, t->ng );
        paths->scattered[number[k]] = ( RfScatteredPath ){ { p, rf_vec3( radius, radius, radius ) }, path };
    }
    return (uint64_t)rays;
}

uint64_t rf_scatter_light_paths( const RfEstimatorGroup* group, RfLightPaths* paths, uint64_t pass_key )
{
    RfRandomKey shift = rf_pixel_key( pass_key ^ PARTICLES, UINT32_MAX );
    uint32_t count = paths->count * RF_SCATTERED_PER_PATH;
    int blocks = (int)( ( count + RF_CHAIN_BLOCK - 1 ) / RF_CHAIN_BLOCK );
    uint64_t rays = 0;
#pragma omp parallel num_threads( group->settings->threads ) reduction( + : rays )
    {
        rf_set_float_mode();
#pragma omp for schedule( dynamic, 4 )
        for ( int b = 0; b < blocks; ++b )
        {
            uint32_t first = (uint32_t)b * RF_CHAIN_BLOCK, left = count - first;
            rays += scatter_block( group, paths, shift, first, left < RF_CHAIN_BLOCK ? left : RF_CHAIN_BLOCK );
        }
    }
    paths->scattered_count = 0;
    for ( uint32_t k = 0; k < count; ++k )
    {
        if ( paths->scattered[k].at.half.x > 0.0f )
            paths->scattered[paths->scattered_count++] = paths->scattered[k];
    }
    paths->scattered_tree.count = paths->scattered_count;
    rf_build_footprints( &paths->scattered_tree );
    return rays;
}
