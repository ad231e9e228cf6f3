#include "light_paths/vpls.h"

#include "base/random.h"

#include <string.h>

#define CONNECTIONS 3.0f      // c
#define MOST_FOOTPRINT 0.05f  // of half the axes, in radii of the scene
#define RARE_CONNECTIONS 0.2f // found where MOST_FOOTPRINT allows fewer, by larger ones
#define PATHS_PER_PIXEL 0.125
#define LEAST_PATHS 512u
#define MOST_PATHS 65536u
#define LIGHT_PATHS 0xfffffff1u // in the place of a frame, for the random numbers
#define EVENTS 0x51ed270bu      // makes the key of a chain's events

enum
{
    DIMENSION_EMITTER, // four
    DIMENSION_SURFACE = DIMENSION_EMITTER + 4,
};

static uint32_t in_blocks( double n ) { return (uint32_t)ceil( n / RF_CHAIN_BLOCK ) * RF_CHAIN_BLOCK; }

uint32_t rf_light_path_count( const RfEstimatorGroup* group )
{
    double wanted = PATHS_PER_PIXEL * group->width * group->height * group->eye_count;
    uint32_t n = wanted < LEAST_PATHS ? LEAST_PATHS : wanted > MOST_PATHS ? MOST_PATHS : (uint32_t)wanted;
    return in_blocks( (double)n );
}

static size_t aligned( size_t bytes ) { return ( bytes + 63 ) / 64 * 64; }

size_t rf_light_paths_bytes( const RfEstimatorGroup* group )
{
    size_t n = rf_light_path_count( group ), s = group->traits.chain_triangles, l = group->traits.most_lights;
    return aligned( sizeof( RfLightPaths ) ) + aligned( n * sizeof( RfLightPath ) ) + aligned( n * sizeof( uint32_t ) ) +
           aligned( n * sizeof( RfFootprintNode ) ) + rf_scattered_bytes( n ) + aligned( s * sizeof( uint32_t ) ) +
           aligned( s * sizeof( double ) ) + aligned( s * sizeof( float ) ) +
           aligned( ( group->traits.materials + 1 ) * sizeof( bool ) ) + aligned( l * sizeof( uint32_t ) ) +
           aligned( l * sizeof( double ) );
}

static void* take( char** at, size_t bytes )
{
    void* here = *at;
    *at += aligned( bytes );
    return here;
}

// Every material has the same share of the points, and every point of a material the same density.
static void list_surfaces( const RfTracer* tracer, RfLightPaths* paths )
{
    const RfScene* scene = rf_tracer_scene( tracer );
    const RfTriangleRecord* triangles = rf_tracer_triangles( tracer );
    uint32_t count = 0, materials = 0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        if ( rf_is_chain_surface( scene->materials + scene->triangles.material[i] ) )
            paths->triangle[count++] = i;
    }
    paths->surface_count = count;
    for ( uint32_t m = 0; m < scene->material_count; ++m )
    {
        double area = 0.0;
        for ( uint32_t k = 0; k < count && rf_is_chain_surface( scene->materials + m ); ++k )
        {
            const RfTriangleRecord* t = triangles + paths->triangle[k];
            double twice;
            rf_unit_cross( t->e1, t->e2, &twice );
            area += t->material == m ? 0.5 * twice : 0.0;
        }
        if ( !( area > 0.0 ) )
            continue;
        materials += 1;
        for ( uint32_t k = 0; k < count; ++k )
        {
            if ( triangles[paths->triangle[k]].material == m )
                paths->pdf_area[k] = (float)( 1.0 / area );
        }
    }
    double sum = 0.0;
    for ( uint32_t k = 0; k < count; ++k )
    {
        const RfTriangleRecord* t = triangles + paths->triangle[k];
        double twice;
        rf_unit_cross( t->e1, t->e2, &twice );
        paths->pdf_area[k] /= (float)materials;
        sum += 0.5 * twice * (double)paths->pdf_area[k];
        paths->cumulative[k] = sum;
    }
}

static bool is_connected( const RfTracer* tracer, const RfLightPaths* paths, uint32_t light )
{
    const RfLights* lights = rf_tracer_lights( tracer );
    const RfScene* scene = rf_tracer_scene( tracer );
    if ( light < lights->triangle_count )
        return paths->connected[scene->triangles.material[lights->light[light].triangle]];
    bool sky = light >= lights->triangle_count + (uint32_t)lights->punctual_count;
    return !sky || paths->connected[scene->material_count];
}

static void list_emitters( const RfEstimatorGroup* group, RfLightPaths* paths )
{
    const RfLights* lights = rf_tracer_lights( group->tracer );
    const RfScene* scene = rf_tracer_scene( group->tracer );
    rf_divide_emitters( scene, paths->connected );
    for ( uint32_t m = 0; m <= scene->material_count && group->settings->light_paths == RF_LIGHT_PATHS_ON; ++m )
        paths->connected[m] = true;
    double sum = 0.0;
    uint32_t count = 0;
    for ( uint32_t i = 0; i < lights->count; ++i )
    {
        if ( !is_connected( group->tracer, paths, i ) || !( lights->power_fraction[i] > 0.0f ) )
            continue;
        sum += (double)lights->power_fraction[i];
        paths->light[count] = i;
        paths->light_cumulative[count++] = sum;
    }
    paths->light_count = count;
}

// The surfaces are listed once; groups at the ends of a camera's path have fewer light paths than others.
static RfLightPaths* lay_out( const RfEstimatorGroup* group, void* memory )
{
    size_t n = rf_light_path_count( group ), s = group->traits.chain_triangles, l = group->traits.most_lights;
    char* at = memory;
    RfLightPaths* paths = take( &at, sizeof *paths );
    paths->share = paths->share > 0.0f ? paths->share : 1.0f;
    paths->emitted = in_blocks( (double)paths->share * (double)n );
    paths->triangle = take( &at, s * sizeof *paths->triangle );
    paths->cumulative = take( &at, s * sizeof *paths->cumulative );
    paths->pdf_area = take( &at, s * sizeof *paths->pdf_area );
    paths->connected = take( &at, ( group->traits.materials + 1 ) * sizeof *paths->connected );
    paths->light = take( &at, l * sizeof *paths->light );
    paths->light_cumulative = take( &at, l * sizeof *paths->light_cumulative );
    paths->path = take( &at, n * sizeof *paths->path );
    paths->tree = ( RfFootprintTree ){ .boxes = (const char*)&paths->path->at, .stride = sizeof *paths->path };
    paths->tree.order = take( &at, n * sizeof *paths->tree.order );
    paths->tree.node = take( &at, n * sizeof *paths->tree.node );
    rf_lay_out_scattered( paths, take( &at, rf_scattered_bytes( n ) ) );
    paths->connections = CONNECTIONS;
    paths->rare_connections = RARE_CONNECTIONS;
    paths->most_radius = MOST_FOOTPRINT * rf_tracer_lights( group->tracer )->radius;
    if ( !paths->prepared )
    {
        list_surfaces( group->tracer, paths );
        list_emitters( group, paths );
    }
    paths->prepared = true;
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

// A point of the mirrors and glass. Path `number` of the set; neighbours in the set have neighbouring triangles and points
// of a sequence of low discrepancy (Roberts, R2).
static RfVec3 sample_surface( const RfLightPaths* paths, const RfTracer* tracer, RfRandomKey shift, RfRandomKey key,
                              uint32_t number, uint32_t* triangle )
{
    double u = ( (double)number + (double)rf_random( key, DIMENSION_SURFACE ) ) / (double)paths->emitted;
    uint32_t low = select_by( paths->cumulative, paths->surface_count, u );
    const RfTriangleRecord* t = rf_tracer_triangles( tracer ) + paths->triangle[low];
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
    if ( !rf_sample_emitter_of( lights, rf_tracer_scene( group->tracer ), light, pdf, u[1], u + 2, e ) )
        return false;
    if ( !e->infinite )
    {
        RfVec3 way = rf_sub( to, rf_madd( e->position, e->normal, e->offset ) );
        return rf_dot( way, way ) > 0.0f && rf_emit_towards( lights, rf_tracer_scene( group->tracer ), rf_normalize( way ), e );
    }
    float back = rf_dot( rf_sub( to, lights->center ), e->direction ) + 1.1f * lights->radius;
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
    const RfTriangleRecord* triangles = rf_tracer_triangles( group->tracer );
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
        *path = ( RfLightPath ){ .start = c->start, .events = c->events, .length = c->length, .end = c->end };
        path->weight = 1.0f / ( pdf * c->probability );
        RfFootprint footprint =
            rf_find_footprint( paths, rf_tracer_lights( group->tracer ), c, pdf, land.p[i], triangles[land.triangle[i]].ng );
        path->reach = footprint.reach;
        path->at = ( RfFootprintBox ){ land.p[i], footprint.half };
        if ( group->settings->kernel_normalization == RF_KERNEL_DENSITY )
            path->at.half = rf_vec3( footprint.radius, footprint.radius, footprint.radius );
        path->chance = rf_chance_area( paths, c, rf_reach_area( &path->reach ), pdf, land.p[i] );
        path->flux = flux_of( path, c );
        path->light = rf_luminance( path->flux ) / ( path->reach.along * path->reach.across );
        if ( !( path->reach.along > 0.0f && path->light > 0.0f && path->light < INFINITY ) )
            path->length = 0;
        rf_set_vpl( group->tracer, paths, c, &land, i, path );
    }
    return rays;
}

void rf_draw_light_paths( const RfEstimatorGroup* group, int pass, void* memory )
{
    RfLightPaths* paths = lay_out( group, memory );
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
    paths->rays = rays + rf_scatter_light_paths( group, paths, key );
}
