// Draws light paths: their starts at emitters, towards points of mirrors and glass; their footprints where they land; and the
// particles that are scattered there.
#include "light_paths/light_paths.h"

#include "base/random.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <string.h>

#define MOST_REACH 0.3f              // of directions: a chord of the unit sphere
#define MOST_SHIFT 0.1f              // of the rays of infinite lights, in radii of the scene
#define RARE_FOOTPRINT 4.0f          // times as large as others, at most
#define FOOTPRINT_MARGIN 1.3f        // over the estimate by derivatives, or for a plane
#define LEAST_COSINE 0.2f            // at which light lands, for footprints
#define MOST_PARTICLE_FOOTPRINT 4.0f // in those of light paths
#define PARTICLES 0x9e3779b9u        // makes the key of what is scattered
#define CONNECTIONS 3.0f             // c
#define MOST_FOOTPRINT 0.05f         // of half the axes, in radii of the scene
#define RARE_CONNECTIONS 0.2f        // found where MOST_FOOTPRINT allows fewer, by larger ones
#define PATHS_PER_PIXEL 0.125
#define LEAST_PATHS 512u
#define MOST_PATHS 65536u
#define LIGHT_PATHS 0xfffffff1u // in place of a frame, for the random numbers
#define EVENTS 0x51ed270bu      // makes the key of a chain's events

// The principal axes of how the chain's end moves over the surface at p, longer first.
static bool find_moves( const RfChain* chain, RfVec3 p, RfVec3 normal, RfVec3 moves[2], float axis[2], float stretch[2] )
{
    RfVec3 meet, m[2], d = chain->end.d;
    if ( !rf_meet_plane( &chain->end, p, d, &meet, m ) )
        return false;
    float cosine = rf_dot( normal, d ), away = copysignf( rf_maxf( fabsf( cosine ), LEAST_COSINE ), cosine );
    for ( int k = 0; k < 2; ++k )
        m[k] = rf_madd( m[k], d, -rf_dot( m[k], normal ) / away );
    float a = rf_dot( m[0], m[0] ), b = rf_dot( m[0], m[1] ), c = rf_dot( m[1], m[1] ), half = 0.5f * ( a - c );
    float root = sqrtf( half * half + b * b ), phi = 0.5f * atan2f( b, half );
    axis[0] = cosf( phi );
    axis[1] = sinf( phi );
    moves[0] = rf_add( rf_scale( m[0], axis[0] ), rf_scale( m[1], axis[1] ) );
    moves[1] = rf_sub( rf_scale( m[1], axis[0] ), rf_scale( m[0], axis[1] ) );
    stretch[0] = FOOTPRINT_MARGIN * sqrtf( 0.5f * ( a + c ) + root );
    stretch[1] = FOOTPRINT_MARGIN * rf_length( moves[1] );
    return stretch[0] > 0.0f;
}

// How far a footprint of at most this radius allows connections to reach in each axis.
static void find_most( float radius, float limit, const float stretch[2], float most[2] )
{
    most[0] = rf_minf( limit, radius / stretch[0] );
    most[1] = rf_minf( limit, radius / rf_maxf( stretch[1], 1e-6f * stretch[0] ) );
}

// An ellipse of this area within the limits: what is cut off one axis is added to the other.
static void set_reach( float area, const float most[2], RfReach* reach )
{
    reach->along = rf_minf( sqrtf( area ), most[0] );
    reach->across = rf_minf( area / reach->along, most[1] );
}

RfFootprint rf_find_footprint( const RfLightPaths* paths, const RfLights* lights, const RfChain* chain, float pdf, RfVec3 p,
                               RfVec3 normal )
{
    RfVec3 moves[2];
    RfFootprint f = { .most = 0.0f };
    float stretch[2], limit = chain->start.infinite ? MOST_SHIFT * lights->radius : MOST_REACH;
    if ( !( pdf > 0.0f ) || !find_moves( chain, p, normal, moves, f.reach.axis, stretch ) )
        return f;
    float area = paths->connections / ( RF_PI * (float)paths->emitted * pdf ), most[2], least_most[2];
    find_most( paths->most_radius, limit, stretch, most );
    find_most( RARE_FOOTPRINT * paths->most_radius, limit, stretch, least_most );
    f.most = RF_PI * most[0] * most[1];
    f.rare_most = RF_PI * least_most[0] * least_most[1];
    set_reach( area, most, &f.reach );
    float rare = paths->rare_connections / paths->connections * area;
    if ( f.reach.along * f.reach.across < rare )
        set_reach( rare, least_most, &f.reach );
    RfVec3 a = rf_scale( moves[0], FOOTPRINT_MARGIN * f.reach.along ),
           b = rf_scale( moves[1], FOOTPRINT_MARGIN * f.reach.across );
    float thick = sqrtf( rf_length( a ) * rf_length( b ) );
    f.half = rf_vec3( sqrtf( a.x * a.x + b.x * b.x ) + thick, sqrtf( a.y * a.y + b.y * b.y ) + thick,
                      sqrtf( a.z * a.z + b.z * b.z ) + thick );
    f.radius = f.reach.along * stretch[0];
    return f;
}

float rf_chance_area( const RfLightPaths* paths, const RfChain* chain, float area, float steer_pdf, RfVec3 p )
{
    const RfEmission* e = &chain->start;
    RfVec3 meet, m[2];
    if ( e->infinite || e->delta_position )
        return 0.0f;
    if ( !rf_meet_plane( &chain->end, p, chain->end.d, &meet, m ) )
        return INFINITY;
    float spread = fabsf( rf_dot( rf_cross( m[0], m[1] ), chain->end.d ) ), cosine = rf_dot( e->normal, e->direction );
    float starts = e->pdf_light * e->pdf_area * spread / rf_maxf( cosine, 1e-6f ); // per solid angle at p
    float connections = (float)paths->emitted * area * steer_pdf * starts;
    return connections > 0.0f ? 1.0f / connections : INFINITY;
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

// Sets path->vpl from where its chain, that of lane `i`, landed.
static void set_vpl( const RfTracer* tracer, const RfLightPaths* paths, const RfChain* chain, const RfLanding* land, int i,
                     RfLightPath* path )
{
    RfVpl* vpl = &path->vpl;
    const RfScene* scene = rf_tracer_scene( tracer );
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, land->triangle[i], &place );
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
    float last = rf_length( rf_sub( path->at.p, chain->vertex[chain->length - 1].p ) );
    vpl->falloff = rf_emission_falloff( &path->start, chain->vertex[0].p, chain->way + last );
    vpl->scatters = reached && rf_may_scatter( chain ) && vpl->falloff > 0.0f && path->length > 0 &&
                    rf_is_matte( m->kind, shape ) && rf_dot( vpl->n, wi ) > 0.0f;
}

float rf_scattered_radius( const RfLightPaths* paths, const RfLightPath* path, RfVec3 hit, RfVec3 ng )
{
    RfVec3 way = rf_sub( hit, rf_vpl_start( path ) );
    float distance = rf_length( way ), inverse = 1.0f / rf_maxf( distance, 1e-20f );
    float leaves = rf_dot( way, path->vpl.ng ) * inverse, lands = fabsf( rf_dot( way, ng ) ) * inverse;
    float radius = FOOTPRINT_MARGIN * sqrtf( rf_vpl_cone( paths, leaves ) ) * distance / rf_maxf( lands, LEAST_COSINE );
    return rf_minf( radius, MOST_PARTICLE_FOOTPRINT * paths->most_radius );
}

// A cosine-weighted direction. Particle `number` of the set, from the R2 sequence (Roberts).
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
    RfTriangleRecord place;
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
    RfPassedPanes panes;
    rf_trace_light( group->tracer, rays, from, way, hit, u, v, &panes );
    for ( int k = 0; k < rays; ++k )
    {
        if ( hit[k] == RF_MISS || materials[rf_triangle_material( group->tracer, hit[k] )].kind >= RF_BSDF_FIRST_SPECULAR )
            continue;
        const RfTriangleRecord* t = rf_triangle_record( group->tracer, hit[k], &place );
        uint32_t path = number[k] / RF_SCATTERED_PER_PATH;
        RfVec3 p = rf_hit_point( t, u[k], v[k], RF_GET3( o, k ), RF_GET3( d, k ) ).p;
        float radius = rf_scattered_radius( paths, paths->path + path, p, t->ng );
        paths->scattered[number[k]] = ( RfScatteredPath ){ { p, rf_vec3( radius, radius, radius ) }, path };
    }
    return (uint64_t)rays;
}

// Scatters particles from the VPLs of the stored paths. Returns the rays traced.
static uint64_t scatter_light_paths( const RfEstimatorGroup* group, RfLightPaths* paths, uint64_t pass_key )
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

enum
{
    DIMENSION_EMITTER, // four
    DIMENSION_SURFACE = DIMENSION_EMITTER + 4,
};

static uint32_t in_blocks( double n ) { return (uint32_t)ceil( n / RF_CHAIN_BLOCK ) * RF_CHAIN_BLOCK; }

// The number of light paths for a pass of a group.
static uint32_t light_path_count( const RfEstimatorGroup* group )
{
    double wanted = PATHS_PER_PIXEL * group->width * group->height * group->eye_count;
    uint32_t n = wanted < LEAST_PATHS ? LEAST_PATHS : wanted > MOST_PATHS ? MOST_PATHS : (uint32_t)wanted;
    return in_blocks( (double)n );
}

RfLightPaths* rf_place_light_paths( const RfEstimatorGroup* group, RfLayout* layout )
{
    size_t n = light_path_count( group ), surfaces = group->traits.chain_triangles + group->traits.plate_triangles,
           lights = group->traits.most_lights, particles = n * RF_SCATTERED_PER_PATH;
    RfLightPaths* paths = rf_take( layout, 1, sizeof *paths );
    RF_PLACE( layout, paths->triangle, surfaces );
    RF_PLACE( layout, paths->cumulative, surfaces );
    RF_PLACE( layout, paths->pdf_area, surfaces );
    RF_PLACE( layout, paths->light, lights );
    RF_PLACE( layout, paths->light_cumulative, lights );
    RF_PLACE( layout, paths->path, n );
    RF_PLACE( layout, paths->tree.order, n );
    RF_PLACE( layout, paths->tree.node, n );
    RF_PLACE( layout, paths->scattered, particles );
    RF_PLACE( layout, paths->scattered_tree.order, particles );
    RF_PLACE( layout, paths->scattered_tree.node, particles );
    return paths;
}

static bool is_followed( const RfMaterial* m ) { return rf_is_chain_surface( m ) || rf_is_plate( m ); }

// Points are drawn uniformly by area on each material, and every material has the same share of them.
static void list_surfaces( const RfTracer* tracer, bool plates, RfLightPaths* paths )
{
    const RfScene* scene = rf_tracer_scene( tracer );
    bool ( *is )( const RfMaterial* ) = plates ? is_followed : rf_is_chain_surface;
    RfTriangleRecord place;
    uint32_t count = rf_list_triangles( scene, is, paths->triangle ), materials = 0;
    paths->surface_count = count;
    for ( uint32_t m = 0; m < scene->material_count; ++m )
    {
        double area = 0.0;
        for ( uint32_t k = 0; k < count && is( scene->materials + m ); ++k )
        {
            const RfTriangleRecord* t = rf_triangle_record( tracer, paths->triangle[k], &place );
            double twice;
            rf_unit_cross( t->e1, t->e2, &twice );
            area += t->material == m ? 0.5 * twice : 0.0;
        }
        if ( !( area > 0.0 ) )
            continue;
        materials += 1;
        for ( uint32_t k = 0; k < count; ++k )
        {
            if ( rf_triangle_material( tracer, paths->triangle[k] ) == m )
                paths->pdf_area[k] = (float)( 1.0 / area );
        }
    }
    double sum = 0.0;
    for ( uint32_t k = 0; k < count; ++k )
    {
        const RfTriangleRecord* t = rf_triangle_record( tracer, paths->triangle[k], &place );
        double twice;
        rf_unit_cross( t->e1, t->e2, &twice );
        paths->pdf_area[k] /= (float)materials;
        sum += 0.5 * twice * (double)paths->pdf_area[k];
        paths->cumulative[k] = sum;
    }
}

static void list_emitters( const RfEstimatorGroup* group, RfLightPaths* paths )
{
    const RfLights* lights = rf_tracer_lights( group->tracer );
    paths->emission = group->traits.chain_triangles > 0;
    double sum = 0.0;
    uint32_t count = 0;
    for ( uint32_t i = 0; i < lights->count; ++i )
    {
        RfLightKind kind = rf_light_kind( lights, i );
        bool punctual = kind != RF_LIGHT_TRIANGLE && kind != RF_LIGHT_SKY;
        if ( !( paths->emission || punctual ) || !( lights->power_fraction[i] > 0.0f ) )
            continue;
        sum += (double)lights->power_fraction[i];
        paths->light[count] = i;
        paths->light_cumulative[count++] = sum;
    }
    paths->light_count = count;
}

// The surfaces are listed once, or, where something moves, for every group; groups at the ends of a camera's path have fewer light
// paths than others.
static RfLightPaths* begin_set( const RfEstimatorGroup* group, void* memory )
{
    RfLightPaths* paths = rf_place_light_paths( group, &( RfLayout ){ .memory = memory } );
    paths->share = paths->share > 0.0f ? paths->share : 1.0f;
    paths->emitted = in_blocks( (double)paths->share * (double)light_path_count( group ) );
    paths->tree.boxes = (const char*)&paths->path->at;
    paths->tree.stride = sizeof *paths->path;
    paths->scattered_tree.boxes = (const char*)paths->scattered;
    paths->scattered_tree.stride = sizeof *paths->scattered;
    paths->vpl_connections = RF_VPL_CONNECTIONS / (float)paths->emitted;
    paths->connections = CONNECTIONS;
    paths->rare_connections = RARE_CONNECTIONS;
    paths->most_radius = MOST_FOOTPRINT * rf_tracer_lights( group->tracer )->radius;
    if ( paths->listed_for == 0 || ( group->traits.moves && paths->listed_for != group->number + 1 ) )
    {
        list_surfaces( group->tracer, group->traits.plate_triangles > 0, paths );
        list_emitters( group, paths );
    }
    paths->listed_for = group->number + 1;
    return paths;
}

float rf_steer_pdf( const RfLightPaths* paths, const RfChain* chain )
{
    uint32_t low = 0, high = paths->surface_count;
    while ( low < high )
    {
        uint32_t middle = ( low + high ) / 2;
        if ( paths->triangle[middle] < chain->first_triangle )
            low = middle + 1;
        else
            high = middle;
    }
    return chain->first_area_pdf > 0.0f ? paths->pdf_area[low] / chain->first_area_pdf : 0.0f;
}

// One of `count` by a number u in [0, 1).
static uint32_t select_by( const double* cumulative, uint32_t count, double u )
{
    uint32_t low = 0, high = count - 1;
    while ( low < high )
    {
        uint32_t middle = ( low + high ) / 2;
        if ( cumulative[middle] <= u * cumulative[count - 1] )
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// A point of the mirrors and glass. Path `number` of the set; neighbours in the set have neighbouring triangles
// and points of the R2 sequence (Roberts).
static RfVec3 sample_surface( const RfLightPaths* paths, const RfTracer* tracer, RfRandomKey shift, RfRandomKey key,
                              uint32_t number, uint32_t* triangle )
{
    double u = ( (double)number + (double)rf_random( key, DIMENSION_SURFACE ) ) / (double)paths->emitted;
    uint32_t low = select_by( paths->cumulative, paths->surface_count, u );
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, paths->triangle[low], &place );
    double a = (double)number * 0.75487766624669276 + (double)rf_random( shift, 0 );
    double b = (double)number * 0.56984029099805327 + (double)rf_random( shift, 1 );
    float root = sqrtf( (float)( a - floor( a ) ) ), v = (float)( b - floor( b ) ) * root;
    *triangle = paths->triangle[low];
    return rf_add( t->p0, rf_add( rf_scale( t->e1, 1.0f - root ), rf_scale( t->e2, v ) ) );
}

// Emission towards a point of the mirrors and glass.
static bool emit( const RfEstimatorGroup* group, const RfLightPaths* paths, RfRandomKey shift, RfRandomKey key, uint32_t number,
                  RfEmission* e, uint32_t* triangle )
{
    const RfLights* lights = rf_tracer_lights( group->tracer );
    float u[4];
    for ( uint32_t k = 0; k < 4; ++k )
        u[k] = rf_random( key, DIMENSION_EMITTER + k );
    RfVec3 to = sample_surface( paths, group->tracer, shift, key, number, triangle );
    uint32_t light = paths->light[select_by( paths->light_cumulative, paths->light_count, (double)u[0] )];
    float pdf = lights->power_fraction[light] / (float)paths->light_cumulative[paths->light_count - 1];
    if ( !rf_sample_emitter( lights, rf_tracer_scene( group->tracer ), light, pdf, u[1], u + 2, e ) )
        return false;
    if ( !e->infinite )
    {
        RfVec3 way = rf_sub( to, rf_madd( e->position, e->normal, e->offset ) );
        return rf_dot( way, way ) > 0.0f && rf_emit_towards( lights, rf_normalize( way ), e );
    }
    float back = rf_dot( rf_sub( to, lights->center ), e->direction ) + 1.1f * lights->reach;
    e->position = rf_madd( to, e->direction, -back );
    return true;
}

static RfVec3 flux_of( const RfLightPath* path, const RfChain* chain )
{
    const RfEmission* e = &path->start;
    float cosine = e->infinite || e->delta_position ? 1.0f : rf_dot( e->normal, e->direction );
    float scale = cosine * path->weight / ( e->pdf_light * ( e->infinite ? e->pdf_solid_angle : e->pdf_area ) );
    return rf_scale( rf_mul( e->radiance, chain->weight ), scale * rf_flux_over_radiance( chain ) );
}

static uint64_t draw_block( const RfEstimatorGroup* group, RfLightPaths* paths, uint64_t pass_key, uint32_t first )
{
    RfTriangleRecord place;
    RfChain chain[RF_CHAIN_BLOCK], *chains[RF_CHAIN_BLOCK];
    RfRandomKey events[RF_CHAIN_BLOCK], shift = rf_pixel_key( pass_key, UINT32_MAX );
    bool active[RF_CHAIN_BLOCK];
    uint32_t target[RF_CHAIN_BLOCK];
    RfLanding land;
    uint64_t rays = 0;
    for ( int i = 0; i < RF_CHAIN_BLOCK; ++i )
    {
        RfRandomKey key = rf_pixel_key( pass_key, first + (uint32_t)i );
        chains[i] = chain + i;
        chain[i].length = 0;
        chain[i].events = 0;
        events[i] = ( RfRandomKey ){ key.a ^ EVENTS, key.b };
        active[i] = emit( group, paths, shift, key, first + (uint32_t)i, &chain[i].start, target + i );
    }
    rf_walk_chains( group->tracer, RF_CHAIN_DRAW, events, active, RF_CHAIN_BLOCK, chains, &land, &rays );
    for ( int i = 0; i < RF_CHAIN_BLOCK; ++i )
    {
        const RfChain* c = chain + i;
        RfLightPath* path = paths->path + first + (uint32_t)i;
        path->length = 0;
        if ( !active[i] || c->length == 0 || c->first_triangle != target[i] )
            continue;
        float pdf = rf_steer_pdf( paths, c );
        *path = ( RfLightPath ){ .start = c->start,
                                 .events = c->events,
                                 .plate = c->plate,
                                 .facet = { c->facet[0], c->facet[1] },
                                 .length = c->length,
                                 .end = c->end };
        path->weight = 1.0f / ( pdf * c->probability );
        RfFootprint footprint = rf_find_footprint( paths, rf_tracer_lights( group->tracer ), c, pdf, land.p[i],
                                                   rf_triangle_record( group->tracer, land.triangle[i], &place )->ng );
        path->reach = footprint.reach;
        path->at = ( RfFootprintBox ){ land.p[i], footprint.half };
        if ( paths->balls )
            path->at.half = rf_vec3( footprint.radius, footprint.radius, footprint.radius );
        path->chance = rf_chance_area( paths, c, rf_reach_area( &path->reach ), pdf, land.p[i] );
        path->flux = flux_of( path, c );
        path->light = rf_luminance( path->flux ) / ( path->reach.along * path->reach.across );
        if ( !( path->reach.along > 0.0f && path->light > 0.0f && path->light < INFINITY ) )
            path->length = 0;
        set_vpl( group->tracer, paths, c, &land, i, path );
    }
    return rays;
}

void rf_draw_light_paths( const RfEstimatorGroup* group, int pass, void* memory )
{
    RfLightPaths* paths = begin_set( group, memory );
    uint64_t key = rf_pass_key( group->settings->seed, LIGHT_PATHS, (uint32_t)group->number, (uint32_t)pass ), rays = 0;
    int blocks = paths->light_count > 0 && paths->surface_count > 0 ? (int)( paths->emitted / RF_CHAIN_BLOCK ) : 0;
#pragma omp parallel num_threads( group->settings->threads ) reduction( + : rays )
    {
        rf_set_float_mode();
#pragma omp for schedule( dynamic, 4 )
        for ( int b = 0; b < blocks; ++b )
            rays += draw_block( group, paths, key, (uint32_t)b * RF_CHAIN_BLOCK );
    }
    paths->count = 0;
    for ( uint32_t i = 0; i < (uint32_t)blocks * RF_CHAIN_BLOCK; ++i )
    {
        if ( paths->path[i].length > 0 )
            paths->path[paths->count++] = paths->path[i];
    }
    paths->tree.count = paths->count;
    rf_build_footprints( &paths->tree );
    paths->rays = rays + scatter_light_paths( group, paths, key );
}
