// Follows camera rays through mirrors and clear glass to the surfaces whose albedo and normal a denoiser needs.
#include "path/features.h"

#include "bsdf/thin_film.h"
#include "bsdf/sheen.h"

#include <string.h>

#define MOST_VERTICES 16 // mirrors and glass that a ray is followed through; the next one has its own albedo and normal

static RfVec3 colour_param( const RfVertexLanes* v, RfBsdfParams params, RfBsdfParam param, int i )
{
    return rf_has_param( params, param ) ? RF_GET3( v->param + param, i ) : rf_vec3( 0, 0, 0 );
}

// Whether there may be a film, on GGX or on a mirror. What glass under a film does not reflect it transmits.
static bool has_opaque_film( const RfVertexLanes* v, RfBsdfKind kind, int i )
{
    bool opaque = rf_is_ggx( kind ) || ( kind == RF_BSDF_SPECTRAL && v->param[RF_PARAM_IOR][i] == 0.0f );
    return opaque && rf_has_param( rf_bsdf_model( kind )->params, RF_PARAM_FILM );
}

RfVec3 rf_albedo_of_lane( const RfVertexLanes* v, int i )
{
    RfBsdfKind kind = rf_kind_of_lane( v, i );
    RfBsdfParams params = rf_bsdf_model( kind )->params;
    RfVec3 diffuse = colour_param( v, params, RF_PARAM_DIFFUSE, i );
    RfVec3 specular = colour_param( v, params, RF_PARAM_SPECULAR, i );
    float lost = rf_has_param( params, RF_PARAM_COAT_F0 ) ? v->param[RF_PARAM_COAT_F0][i] : 0.0f;
    if ( has_opaque_film( v, kind, i ) )
    {
        float ior = v->param[RF_PARAM_FILM_IOR][i], thickness = v->param[RF_PARAM_FILM_THICKNESS][i];
        float strength = rf_film_strength( v->param[RF_PARAM_FILM][i], thickness );
        RfVec3 dielectric = rf_film_fresnel( rf_vec3( lost, lost, lost ), 1.0f, ior, thickness );
        specular = rf_film_mix( specular, rf_film_fresnel( specular, 1.0f, ior, thickness ), strength );
        lost += ( rf_max_component( dielectric ) - lost ) * strength;
    }
    RfVec3 tint = colour_param( v, params, RF_PARAM_TINT, i );
    if ( kind == RF_BSDF_TRANSLUCENT )
    {
        diffuse = rf_add( diffuse, colour_param( v, params, RF_PARAM_THROUGH, i ) );
        tint = rf_vec3( 0, 0, 0 );
    }
    RfVec3 albedo = rf_add( rf_madd( specular, diffuse, 1.0f - lost ), tint );
    if ( !rf_has_param( params, RF_PARAM_SHEEN ) )
        return albedo;
    RfVec3 sheen =
        rf_scale( colour_param( v, params, RF_PARAM_SHEEN, i ), rf_sheen_albedo( 1.0f, v->param[RF_PARAM_SHEEN_ALPHA][i] ) );
    return rf_madd( sheen, albedo, 1.0f - rf_max_component( sheen ) );
}

RfVec3 rf_seen_normal( const RfVertexLanes* v, int i )
{
    bool drawn = i >= rf_first_sided( v ) && i < rf_record_count( v );
    return rf_scale( RF_GET3( v->n, i ), drawn ? v->param[RF_PARAM_CHOICE][i] : 1.0f );
}

// What happens at a vertex, in shares of the albedo: what it shows of itself, and the ways that go on.
typedef struct Event
{
    RfVec3 own;
    RfVec3 way[2], wi[2]; // reflection, transmission
} Event;

// Very smooth metals reflect like mirrors. What coats cover shows through them: such surfaces have their own albedo.
static bool is_smooth_metal( const RfVertexLanes* v, RfBsdfKind kind, int i )
{
    return rf_is_ggx( kind ) && kind != RF_BSDF_TRANSLUCENT && v->param[RF_PARAM_SHAPE][i] < RF_SMOOTH_ALPHA &&
           rf_max_component( colour_param( v, RF_PARAM_BITS3( RF_PARAM_DIFFUSE ), RF_PARAM_DIFFUSE, i ) ) == 0.0f;
}

static Event event_at( const RfVertexLanes* v, int i )
{
    RfBsdfKind kind = rf_kind_of_lane( v, i );
    RfVec3 n = RF_GET3( v->n, i ), wo = RF_GET3( v->wo, i );
    Event e = { .own = { 0, 0, 0 } };
    if ( is_smooth_metal( v, kind, i ) )
    {
        e.way[0] = rf_albedo_of_lane( v, i );
        e.wi[0] = rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo );
        return e;
    }
    if ( kind < RF_BSDF_FIRST_SPECULAR || v->param[RF_PARAM_SHAPE][i] >= RF_SMOOTH_ALPHA )
    {
        e.own = rf_albedo_of_lane( v, i );
        return e;
    }
    RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, kind, 0 );
    RfSmoothLobes lobes = rf_smooth_lobes_of_lane( kind, &lanes, i, wo );
    return ( Event ){ lobes.base, { lobes.reflected, lobes.transmitted }, { lobes.reflected_wi, lobes.transmitted_wi } };
}

// Goes on by both ways, or by one with the weight of both, or ends.
static bool goes_on( const Event* e ) { return rf_mean( e->way[0] ) + rf_mean( e->way[1] ) > 0.0f; }

static float share_of( const Event* e, RfVec3 part )
{
    return rf_mean( part ) / ( rf_mean( e->own ) + rf_mean( e->way[0] ) + rf_mean( e->way[1] ) );
}

// A way to a vertex: its weights, of the albedo and of the normal.
typedef struct Way
{
    RfVec3 throughput;
    float share;
} Way;

static void add( RfFeatures* f, int slot, RfVec3 albedo, RfVec3 normal )
{
    const float a[3] = { albedo.x, albedo.y, albedo.z }, n[3] = { normal.x, normal.y, normal.z };
    for ( int c = 0; c < 3; ++c )
    {
        f->albedo[c][slot] += a[c];
        f->normal[c][slot] += n[c];
    }
}

static void add_vertex( const RfVertexLanes* v, int i, RfVec3 shown, Way way, RfFeatures* f )
{
    add( f, v->slot[i], rf_mul( way.throughput, shown ), rf_scale( rf_seen_normal( v, i ), way.share ) );
}

// What the vertex shows of itself, where the ways go on.
static void add_own( const RfPathSettings* path, const RfVertexLanes* v, int i, const Event* e, Way way, RfFeatures* f )
{
    way.share *= goes_on( e ) ? share_of( e, e->own ) : 1.0f;
    add_vertex( v, i, rf_add( e->own, rf_emission_in_frame( path, v, i ) ), way, f );
}

static void add_sky( const RfPathSettings* path, const RfRayLanes* rays, int r, RfFeatures* f )
{
    if ( !rf_has_sky( rf_tracer_lights( path->tracer ) ) )
        return;
    RfVec3 sky = rf_sky_in_frame( path, RF_GET3( rays->d, r ) );
    RfVec3 throughput = RF_GET3( rays->throughput, r );
    add( f, rays->slot[r], rf_mul( throughput, sky ), rf_vec3( 0, 0, 0 ) );
}

// Goes on to wi. Where shading and geometric normal disagree about the side, the vertex has the features of the way.
static void append( const RfVertexLanes* v, int i, RfVec3 wi, Way way, RfRayLanes* rays, RfFeatures* f )
{
    const float direction[3] = { wi.x, wi.y, wi.z };
    float side = rf_leaving_side( v, i, direction );
    if ( side == 0.0f )
    {
        add_vertex( v, i, rf_vec3( 1, 1, 1 ), way, f );
        return;
    }
    int to = rays->count++;
    RF_PUT3( rays->throughput, to, way.throughput );
    f->share[v->slot[i]] = way.share;
    rf_write_ray( v, i, direction, side, RF_DELTA_PDF, rays, to );
}

static void find_next( const RfPathSettings* path, RfRayLanes* rays, RfWavefront* wavefront, RfFeatures* f )
{
    wavefront->path_rays += (uint64_t)rays->count;
    rf_find_vertices( path, rays, false, &wavefront->vertices, &wavefront->scratch );
    rf_absorb( &wavefront->vertices, rays );
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( wavefront->scratch.triangle[r] == RF_MISS )
            add_sky( path, rays, r, f );
    }
}

// Follows wavefront->rays to their ends.
static void follow( const RfPathSettings* path, RfWavefront* wavefront, RfFeatures* f )
{
    RfRayLanes *rays = &wavefront->rays, *next = &wavefront->next;
    const RfVertexLanes* v = &wavefront->vertices;
    for ( int vertex = 2; rays->count > 0; ++vertex )
    {
        find_next( path, rays, wavefront, f );
        next->count = 0;
        for ( int i = 0; i < v->count; ++i )
        {
            int r = v->ray[i];
            Event e = event_at( v, i );
            Way way = { RF_GET3( rays->throughput, r ), f->share[v->slot[i]] };
            RfVec3 both = rf_add( e.way[0], e.way[1] );
            add_own( path, v, i, &e, way, f );
            if ( !goes_on( &e ) )
                continue;
            way = ( Way ){ rf_mul( way.throughput, both ), way.share * share_of( &e, both ) };
            if ( vertex > MOST_VERTICES )
                add_vertex( v, i, rf_vec3( 1, 1, 1 ), way, f );
            else
                append( v, i, e.wi[rf_mean( e.way[1] ) > rf_mean( e.way[0] )], way, next, f );
        }
        RfRayLanes* swap = rays;
        rays = next;
        next = swap;
    }
}

// Reflection (`k` 0) or transmission (1) at the first vertices, to wavefront->rays.
static void split( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, int k,
                   RfWavefront* wavefront, RfFeatures* f )
{
    wavefront->rays.count = 0;
    for ( int i = 0; i < first->count; ++i )
    {
        Event e = event_at( first, i );
        int r = first->ray[i];
        Way way = { rf_vec3( 1, 1, 1 ), 1.0f };
        if ( i >= rf_record_count( first ) )
            way.throughput = rf_transmittance_from( first, i, RF_GET3( camera_rays->o, r ) );
        if ( k == 0 )
            add_own( path, first, i, &e, way, f );
        if ( !( rf_mean( e.way[k] ) > 0.0f ) )
            continue;
        way = ( Way ){ rf_mul( way.throughput, e.way[k] ), share_of( &e, e.way[k] ) };
        append( first, i, e.wi[k], way, &wavefront->rays, f );
    }
}

static void add_misses( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, RfFeatures* f )
{
    bool hit[RF_LANES] = { false };
    for ( int i = 0; i < first->count; ++i )
        hit[first->ray[i]] = true;
    for ( int r = 0; r < camera_rays->count; ++r )
    {
        if ( !hit[r] )
            add_sky( path, camera_rays, r, f );
    }
}

void rf_find_features( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool sky,
                       RfWavefront* wavefront, RfFeatures* features )
{
    memset( features, 0, sizeof *features );
    if ( sky )
        add_misses( path, first, camera_rays, features );
    for ( int k = 0; k < 2; ++k )
    {
        split( path, first, camera_rays, k, wavefront, features );
        follow( path, wavefront, features );
    }
    for ( int c = 0; c < 3; ++c )
    {
        for ( int slot = 0; slot < RF_LANES; ++slot )
            features->albedo[c][slot] = rf_minf( features->albedo[c][slot], 1.0f );
    }
}
