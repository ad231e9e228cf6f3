// Light that comes by specular chains, in tiles: how hits start for a chain, and the walk along it, vertex by vertex.
#include "reuse/tile/tile_chains.h"

#include "reuse/tile/tile.h"

#include <string.h>

static RfVec3 point_of( const RfVertexLanes* v, int i ) { return RF_GET3( v->p, i ); }

static RfVec3 direction_of( float* const d[3], int i ) { return RF_GET3( d, i ); }

static float distance2( RfVec3 a, RfVec3 b )
{
    RfVec3 way = rf_sub( a, b );
    return rf_dot( way, way );
}

// The square of the largest distance of a hit of the tile from its first.
static float extent2( const RfTileReuse* reuse, int hit )
{
    const int32_t* member = reuse->hits.member + reuse->hits.begin[hit];
    RfVec3 first = point_of( reuse->hits.lanes, member[0] );
    float most = 0.0f;
    for ( int k = 1; k < reuse->hits.size[hit]; ++k )
        most = rf_maxf( most, distance2( point_of( reuse->hits.lanes, member[k] ), first ) );
    return most;
}

// Whether a chain that begins at vertex i of `v` is near a hit: within the extent of its tile. Aimed at such a vertex, the hits
// would differ so much in density that all weight would go to the path's own. All hits decide by this rule; where the other
// start would be theirs, their weight is 0.
static bool is_near_chain( const RfTileReuse* reuse, int hit, const RfVertexLanes* v, int i )
{
    return distance2( point_of( v, i ), point_of( reuse->hits.lanes, hit ) ) < extent2( reuse, hit );
}

void rf_sort_chains( RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    for ( int a = rf_record_count( y ); a < y->count; ++a )
        reuse->second.parallel[a] = reuse->second.owner[a] >= 0 && is_near_chain( reuse, reuse->second.owner[a], y, a );
}

// Hit i starts in the direction that another has drawn.
static void leave_parallel( const RfVertexLanes* hits, int i, RfVec3 wi, RfPairingLanes* pairing )
{
    RfVec3 n = RF_GET3( hits->n, i );
    RfVec3 ng = RF_GET3( hits->ng, i );
    bool leaves = rf_dot( n, wi ) > 0.0f && rf_dot( ng, wi ) > 0.0f;
    RfVec3 to = leaves ? wi : n;
    RF_PUT3( pairing->wi, i, to );
    pairing->weight[i] = leaves ? 1.0f : 0.0f;
}

void rf_aim_at_chains( float* const scattered[3], int s, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    RfPairingLanes* pairing = reuse->pairings + s;
    for ( int a = rf_record_count( y ); a < y->count; ++a )
    {
        int own = reuse->second.owner[a];
        if ( own < 0 || s >= reuse->hits.size[own] )
            continue;
        int i = rf_receiver( reuse, a, s );
        for ( int c = 0; c < 3 && reuse->second.parallel[a] && pairing->pane_weight != NULL; ++c )
            pairing->pane_weight[c][i] = 1.0f; // chains that pass panes are not followed
        if ( reuse->second.parallel[a] )
            leave_parallel( reuse->hits.lanes, i, direction_of( scattered, own ), pairing );
        else if ( is_near_chain( reuse, i, y, a ) )
            pairing->weight[i] = 0.0f;
    }
}

// Hits that follow the chain of another path of their tile.
typedef struct Followers
{
    int count;
    int32_t vertex[RF_PATCH_PIXELS]; // the second vertex that begins the chain
    int32_t pairing[RF_PATCH_PIXELS];
    int32_t hit[RF_PATCH_PIXELS];
    float probability[RF_PATCH_PIXELS]; // of the events so far; 0 if they do not lead to emission
    float light[3][RF_PATCH_PIXELS];    // that leaves the chain's first vertex; of parallel chains, that arrives at the hit
    uint8_t touched[RF_PATCH_PIXELS];   // by what moves, as far as they are followed; only if light is split
    uint8_t part[RF_PATCH_PIXELS];      // base part of the light; with groups
} Followers;

typedef struct Walk
{
    const RfPathSettings* path;
    RfWavefront* wavefront;
    RfTileReuse* reuse;
    Followers all;
    float scale[RF_LANES]; // by second vertex: the light of its path over what following its chain again finds (roulette)
    uint64_t rays;
} Walk;

static int slot_of( const Walk* walk, int follower ) { return walk->reuse->second.lanes.slot[walk->all.vertex[follower]]; }

static RfDeltaEvent event_at( const Walk* walk, int follower, int at, const RfVertexLanes* v, int i, RfVec3 wo )
{
    RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, RF_BSDF_GLASS, 0 );
    bool pane = rf_tracer_has_panes( walk->path->tracer ) && v->param[RF_PARAM_IOR][i] < 0.0f; // passed by chance
    if ( i < rf_record_count( v ) || i >= v->first[RF_BSDF_SPECTRAL] || pane )
        return ( RfDeltaEvent ){ wo, { 0, 0, 0 }, 0.0f };
    unsigned events = walk->reuse->slots.chain_light.transmitted[slot_of( walk, follower )];
    return rf_glass_event( &lanes, i, wo, ( events >> at & 1u ) != 0 );
}

// A follower reflects or transmits as its chain does at vertex number `at`, lane i; the ray that leaves is appended to `next`.
static void take_event( Walk* walk, int follower, int at, const RfVertexLanes* v, int i, RfVec3 wo, RfVec3 throughput,
                        RfRayLanes* next )
{
    RfDeltaEvent event = event_at( walk, follower, at, v, i, wo );
    float wi[3] = { event.wi.x, event.wi.y, event.wi.z };
    float side = rf_leaving_side( v, i, wi );
    RfVec3 t = rf_mul( throughput, event.weight );
    float* probability = walk->all.probability + follower;
    *probability = side != 0.0f && rf_max_component( t ) > 0.0f ? *probability * event.probability : 0.0f;
    if ( !( *probability > 0.0f ) )
        return;
    int to = next->count++;
    for ( int c = 0; c < 3; ++c )
        next->o[c][to] = v->p[c][i] + v->ng[c][i] * ( side * v->offset[i] );
    RF_PUT3( next->d, to, event.wi );
    RF_PUT3( next->throughput, to, t );
    next->slot[to] = follower;
}

static void end( Walk* walk, int follower, RfVec3 light )
{
    RF_PUT3( walk->all.light, follower, light );
    if ( !( light.x + light.y + light.z > 0.0f ) )
        walk->all.probability[follower] = 0.0f;
}

// Chains have no parts but those of groups: what they find of lights that change is for their own frame alone.
static void note_part( Walk* walk, int follower, int part )
{
    if ( walk->reuse->split )
        walk->all.touched[follower] |= part >= rf_base_parts( walk->path );
    walk->all.part[follower] = (uint8_t)rf_counts_in( walk->path, part );
}

// Rays that miss see the sky.
static void end_misses( Walk* walk, int at, const RfRayLanes* rays )
{
    const RfLights* lights = rf_tracer_lights( walk->path->tracer );
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( walk->wavefront->scratch.triangle[r] != RF_MISS )
            continue;
        int follower = rays->slot[r];
        RfVec3 d = RF_GET3( rays->d, r ), sky = rf_vec3( 0, 0, 0 );
        if ( rf_has_sky( lights ) && at == walk->reuse->slots.chain_light.length[slot_of( walk, follower )] )
        {
            sky = rf_sky_in_frame( walk->path, d );
            note_part( walk, follower, rf_light_part( lights, rf_sky_number( lights ) ) );
        }
        end( walk, follower, rf_mul( sky, RF_GET3( rays->throughput, r ) ) );
    }
}

// At vertex number `at` a follower ends where its chain does, and must have found emission there but no sooner.
static void arrive( Walk* walk, int at, int i, const RfRayLanes* rays, RfRayLanes* next )
{
    const RfTileReuse* reuse = walk->reuse;
    const RfVertexLanes* v = &walk->wavefront->vertices;
    int follower = v->slot[i], r = v->ray[i];
    RfVec3 t = RF_GET3( rays->throughput, r ), light = rf_vec3( 0, 0, 0 );
    if ( v->light_pdf_solid_angle[i] > 0.0f )
        light = rf_mul( t, rf_emission_in_frame( walk->path, v, i ) );
    bool lit = rf_max_component( light ) > 0.0f, ends = at == reuse->slots.chain_light.length[slot_of( walk, follower )];
    bool strays = at == 0 && !is_near_chain( reuse, walk->all.hit[follower], v, i );
    if ( ends && lit )
        note_part( walk, follower, rf_material_part( rf_tracer_lights( walk->path->tracer ), v->material[i] ) );
    if ( ends )
        end( walk, follower, light );
    else if ( lit || strays )
        walk->all.probability[follower] = 0.0f;
    else
        take_event( walk, follower, at, v, i, RF_GET3( v->wo, i ), t, next );
}

// Traces the rays to vertices number `at` of the chains, and appends those that leave them to `next`.
static void advance( Walk* walk, int at, RfRayLanes* rays, RfRayLanes* next )
{
    RfWavefront* wavefront = walk->wavefront;
    if ( rays->count == 0 )
        return;
    rf_find_vertices( walk->path, rays, false, &wavefront->vertices, &wavefront->scratch );
    rf_absorb( &wavefront->vertices, rays );
    if ( walk->reuse->split )
        rf_touch_by_rays( walk->path->tracer, rays, &wavefront->vertices, wavefront->scratch.triangle, walk->all.touched );
    walk->rays += (uint64_t)rays->count;
    end_misses( walk, at, rays );
    for ( int i = 0; i < wavefront->vertices.count; ++i )
        arrive( walk, at, i, rays, next );
}

// Followers that aim know the first vertex; the others need a ray to find theirs.
static void start( Walk* walk, RfRayLanes* to_first, RfRayLanes* beyond )
{
    const RfTileReuse* reuse = walk->reuse;
    Followers* all = &walk->all;
    to_first->count = beyond->count = 0;
    for ( int k = 0; k < all->count; ++k )
    {
        int a = all->vertex[k], i = all->hit[k];
        RfVec3 wi = RF_GET3( reuse->pairings[all->pairing[k]].wi, i );
        all->probability[k] = 1.0f;
        all->touched[k] = reuse->split && ( reuse->pairings[all->pairing[k]].touched[i] ||
                                            ( !reuse->second.parallel[a] && reuse->own->moving[slot_of( walk, k )] ) );
        if ( !reuse->second.parallel[a] )
        {
            take_event( walk, k, 0, &reuse->second.lanes, a, rf_scale( wi, -1.0f ), rf_vec3( 1, 1, 1 ), beyond );
            continue;
        }
        int to = to_first->count++;
        for ( int c = 0; c < 3; ++c )
            to_first->o[c][to] = reuse->hits.lifted[c][i];
        RF_PUT3( to_first->d, to, wi );
        RF_PUT3( to_first->throughput, to, rf_vec3( 1, 1, 1 ) );
        to_first->slot[to] = k;
    }
}

static void follow( Walk* walk )
{
    RfRayLanes *rays = &walk->wavefront->rays, *next = &walk->wavefront->next;
    start( walk, next, rays );
    advance( walk, 0, next, rays );
    for ( int at = 1; rays->count > 0; ++at )
    {
        next->count = 0;
        advance( walk, at, rays, next );
        RfRayLanes* swap = rays;
        rays = next;
        next = swap;
    }
}

static void add_follower( Followers* all, int vertex, int pairing, int hit )
{
    all->vertex[all->count] = vertex;
    all->pairing[all->count] = pairing;
    all->hit[all->count++] = hit;
}

// A path that did not come to the same end by its own chain keeps its light for itself.
static void keep_own( RfTileReuse* reuse, int a, int hit )
{
    for ( int s = 0; s < reuse->hits.size[hit]; ++s )
        reuse->pairings[s].weight[rf_receiver( reuse, a, s )] = 0.0f;
    reuse->second.owner[a] = -1;
}

static void finish_own( Walk* walk, int k )
{
    RfTileReuse* reuse = walk->reuse;
    const Followers* all = &walk->all;
    int a = all->vertex[k], brightest = 0;
    RfVec3 light = RF_GET3( reuse->slots.chain_light.light, slot_of( walk, k ) );
    if ( reuse->second.parallel[a] )
        light = rf_mul( light, RF_GET3( reuse->second.throughput, a ) );
    float found[3] = { light.x, light.y, light.z };
    for ( int c = 1; c < 3; ++c )
        brightest = found[c] > found[brightest] ? c : brightest;
    if ( !( all->probability[k] > 0.0f && all->light[brightest][k] > 0.0f ) )
    {
        keep_own( reuse, a, all->hit[k] );
        return;
    }
    walk->scale[a] = found[brightest] / all->light[brightest][k];
    reuse->pairings[0].weight[all->hit[k]] *= all->probability[k];
}

// The paths that found the light follow their own chains, for the probability of the events. This fails where they have passed
// panes by chance.
static void follow_own( Walk* walk )
{
    const RfVertexLanes* y = &walk->reuse->second.lanes;
    walk->all.count = 0;
    for ( int a = rf_record_count( y ); a < y->count; ++a )
    {
        if ( walk->reuse->second.owner[a] >= 0 )
            add_follower( &walk->all, a, 0, walk->reuse->second.owner[a] );
    }
    follow( walk );
    for ( int k = 0; k < walk->all.count; ++k )
        finish_own( walk, k );
}

// Gives the pairings what the followers found, and empties the list.
static void follow_others( Walk* walk )
{
    RfTileReuse* reuse = walk->reuse;
    Followers* all = &walk->all;
    follow( walk );
    for ( int k = 0; k < all->count; ++k )
    {
        int a = all->vertex[k], i = all->hit[k];
        RfPairingLanes* pairing = reuse->pairings + all->pairing[k];
        RfVec3 left = rf_vec3( 1, 1, 1 ), light = RF_GET3( all->light, k );
        if ( !reuse->second.parallel[a] )
            left = rf_transmittance_from( &reuse->second.lanes, a, RF_GET3( reuse->hits.lifted, i ) );
        pairing->weight[i] *= all->probability[k];
        if ( reuse->split )
        {
            pairing->touched[i] = all->touched[k];
            pairing->any_touched = pairing->any_touched || all->touched[k];
        }
        int part = walk->path->grouped && all->probability[k] > 0.0f ? all->part[k] : 0;
        RF_PUT3( pairing->of_part[part].light, a, rf_scale( rf_mul( light, left ), walk->scale[a] ) );
    }
    all->count = 0;
}

uint64_t rf_follow_chain_light( const RfTileReuseSettings* settings, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    int first = rf_record_count( y );
    if ( !settings->chain_light || first == y->count )
        return 0;
    for ( int k = 0; k < settings->tile_pixels * reuse->part_count && reuse->part_count > 1;
          ++k ) // each brings light of one part
    {
        RfPairingLight* t = reuse->pairings[k / reuse->part_count].of_part + k % reuse->part_count;
        for ( int c = 0; c < 3; ++c )
            memset( t->light[c] + first, 0, (size_t)( y->count - first ) * sizeof( float ) );
    }
    Walk walk = { .path = settings->path, .wavefront = wavefront, .reuse = reuse };
    follow_own( &walk );
    walk.all.count = 0;
    for ( int a = first; a < y->count; ++a )
    {
        for ( int s = 1; reuse->second.owner[a] >= 0 && s < reuse->hits.size[reuse->second.owner[a]]; ++s )
        {
            int i = rf_receiver( reuse, a, s );
            if ( reuse->pairings[s].weight[i] > 0.0f )
                add_follower( &walk.all, a, s, i );
            if ( walk.all.count == RF_PATCH_PIXELS )
                follow_others( &walk );
        }
    }
    follow_others( &walk );
    return walk.rays;
}

void rf_weight_chain_light( const RfPathSettings* path, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    for ( int a = rf_record_count( y ); a < y->count; ++a )
    {
        int i = reuse->second.owner[a], slot = y->slot[a];
        float weight = i >= 0 ? reuse->pairings[0].weight[i] : 1.0f;
        if ( reuse->split )
            reuse->slots.chain_light.touched[slot] |= path->own->touched[slot];
        for ( int c = 0; c < 3; ++c )
            reuse->slots.chain_light.light[c][slot] =
                weight * reuse->second.throughput[c][a] * reuse->slots.chain_light.light[c][slot];
    }
}
