#include "kernel/links.h"

#include "base/random.h"
#include "kernel/solve.h"

#include <string.h>

#define TRIAL_LINKS 8.0f        // of an eye's first vertex
#define TRIAL_LINKS_BEYOND 1.0f // of others
#define MOST_REPEATS 4096       // trials of a normalisation; so many are never needed but for rounding
#define STEP_MARGIN 1.4f        // first steps, in reaches of links
#define SAME 0.05f              // solutions closer than this, in reaches, are one
#define MOST_CANDIDATES 512

// Of the random numbers of a link; below them those of its repeated trials.
#define DIMENSION_CHOOSE 0x40000000u
#define DIMENSION_ACCEPT 0x40000001u

// A light path and the eye vertex that its footprint holds.
typedef struct Link
{
    int lane;
    const RfLightPath* path;
    RfRandomKey key;
    float scale;   // one over the probability with which it was accepted
    RfChain chain; // solved
    float reach;   // of the solution
    float repeats; // trials until it was found again
    bool open;
    RfVec3 wi, light;
} Link;

typedef struct Work
{
    const RfKernelLinker* settings;
    RfWavefront* keys;
    int vertex;
    const RfVertexLanes* v;
    RfLinkLanes* out;
    Link link[RF_CHAIN_BLOCK];
    RfBend bend[RF_CHAIN_BLOCK];
    int count;
    float chosen[RF_LANES]; // the sum of what was drawn from
} Work;

typedef struct Candidates
{
    const RfKernelLinker* settings;
    RfVec3 y, n;
    int spent;
    int count;
    int kept;
    uint32_t path[MOST_CANDIDATES];
    float light[MOST_CANDIDATES]; // that they are expected to bring
    // second search, where there are more: those numbered next, next + stride …
    double next, stride;
    bool thinned;
} Candidates;

static RfVec3 lane_of( const float ( *array )[RF_LANES], int i ) { return rf_vec3( array[0][i], array[1][i], array[2][i] ); }

// Where segments to lights start as well.
static RfVec3 start_of( const RfVertexLanes* v, int i )
{
    return rf_madd( lane_of( v->p, i ), lane_of( v->ng, i ), v->offset[i] );
}

static void note( void* user, uint32_t number )
{
    Candidates* c = user;
    const RfLightPath* path = c->settings->paths->path + number;
    float step[2], miss, most = STEP_MARGIN * path->reach, spread;
    if ( c->spent + path->length + 2 > c->settings->path->max_depth ||
         !rf_newton_step( &path->end, c->y, c->n, step, &miss, &spread ) ||
         !( step[0] * step[0] + step[1] * step[1] <= most * most ) )
        return;
    int k = c->count++;
    if ( c->thinned && (double)k < c->next )
        return;
    if ( c->kept == MOST_CANDIDATES )
        return;
    c->path[c->kept] = number;
    c->light[c->kept++] = path->light / spread;
    c->next += c->stride;
}

// Finds candidates; of more than there is room for every k-th. Returns one over the probability of being among them.
static float find_candidates( Candidates* c, RfRandomKey key )
{
    rf_find_footprints( c->settings->paths, c->y, note, c );
    if ( c->count <= MOST_CANDIDATES )
        return 1.0f;
    c->stride = (double)c->count / MOST_CANDIDATES;
    c->next = c->stride * (double)rf_random( key, 0 );
    c->count = c->kept = 0;
    c->thinned = true;
    rf_find_footprints( c->settings->paths, c->y, note, c );
    return (float)c->stride;
}

static float distance_of( const RfEmission* a, const RfEmission* b )
{
    RfVec3 apart = a->infinite ? rf_sub( a->position, b->position ) : rf_sub( a->direction, b->direction );
    return rf_length( apart );
}

// The light of a solved link before its normalisation; 0 where nothing arrives.
static RfVec3 light_of( const Work* w, const Link* link )
{
    const RfVertexLanes* v = w->v;
    const RfChain* chain = &link->chain;
    const RfEmission* e = &chain->start;
    int i = link->lane;
    RfVec3 y = start_of( v, i ), none = rf_vec3( 0, 0, 0 );
    float cos_x = rf_dot( lane_of( v->n, i ), link->wi );
    if ( !( cos_x > 0.0f && rf_dot( lane_of( v->ng, i ), link->wi ) > 0.0f ) )
        return none;
    float spread = rf_chain_spread( w->settings->path->tracer, chain, y );
    float cos_light = e->infinite || e->delta_position ? 1.0f : rf_dot( e->normal, e->direction );
    float fixed_pdf = e->pdf_light * ( e->infinite ? e->pdf_solid_angle : e->pdf_area );
    float last = rf_length( rf_sub( chain->vertex[chain->length - 1].p, y ) );
    float falloff = rf_emission_falloff( e, chain->way + last );
    float scale = cos_x * cos_light * falloff * link->scale * link->path->weight / ( spread * fixed_pdf );
    RfVec3 absorbed = rf_vec3( expf( -chain->end_absorption.x * last ), expf( -chain->end_absorption.y * last ),
                               expf( -chain->end_absorption.z * last ) );
    RfVec3 light = rf_scale( rf_mul( rf_mul( e->radiance, chain->weight ), absorbed ), scale );
    float sum = light.x + light.y + light.z;
    return sum > 0.0f && sum < INFINITY ? light : none;
}

// Solves all links; those that fail, or whose solution is out of reach, are closed.
static void solve( Work* w )
{
    const RfTracer* tracer = w->settings->path->tracer;
    const RfLightPaths* paths = w->settings->paths;
    for ( int k = 0; k < w->count; ++k )
    {
        const Link* link = w->link + k;
        RfBend* bend = w->bend + k;
        bend->at.start = link->path->start;
        bend->at.events = link->path->events;
        bend->at.length = link->path->length;
        bend->at.end = link->path->end;
        bend->y = start_of( w->v, link->lane );
        bend->n = lane_of( w->v->ng, link->lane );
        bend->most = STEP_MARGIN * link->path->reach;
        bend->active = true;
    }
    rf_bend_chains( tracer, w->count, w->bend, &w->out->rays );
    for ( int k = 0; k < w->count; ++k )
    {
        Link* link = w->link + k;
        link->open = w->bend[k].met;
        if ( !link->open )
            continue;
        link->chain = w->bend[k].at;
        link->reach = rf_find_footprint( paths, rf_tracer_lights( tracer ), &link->chain, rf_steer_pdf( paths, &link->chain ),
                                         w->bend[k].y, w->bend[k].n )
                          .reach;
        link->open = link->reach > 0.0f && distance_of( &link->chain.start, &link->path->start ) <= link->reach;
        RfVec3 way = rf_sub( link->chain.vertex[link->chain.length - 1].p, start_of( w->v, link->lane ) );
        link->wi = rf_normalize( way );
        link->light = link->open ? light_of( w, link ) : rf_vec3( 0, 0, 0 );
        link->open = link->open && rf_max_component( link->light ) > 0.0f;
        link->repeats = 1.0f;
    }
}

// Shadow rays to the last vertices of the chains.
static void test_visibility( Work* w )
{
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK], visible[RF_CHAIN_BLOCK];
    int index[RF_CHAIN_BLOCK], count = 0;
    for ( int k = 0; k < w->count; ++k )
    {
        const Link* link = w->link + k;
        if ( !link->open )
            continue;
        RfVec3 from = start_of( w->v, link->lane ), way = rf_sub( link->chain.end.o, from );
        o[0][count] = from.x;
        o[1][count] = from.y;
        o[2][count] = from.z;
        d[0][count] = way.x;
        d[1][count] = way.y;
        d[2][count] = way.z;
        index[count++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    rf_trace_segments( w->settings->path->tracer, count, from, way, visible );
    w->out->rays += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
        w->link[index[k]].open = visible[k] > 0.0f;
}

// Draws what steers evenly from all within reach of the solution. False: nothing is emitted there.
static bool draw_start( const Work* w, const Link* link, uint32_t trial, RfEmission* e )
{
    const RfTracer* tracer = w->settings->path->tracer;
    *e = link->chain.start;
    float u = rf_random( link->key, 2 * trial ), phi = 2.0f * RF_PI * rf_random( link->key, 2 * trial + 1 );
    float chord = link->reach * sqrtf( u );
    RfVec3 t, b;
    rf_basis( e->direction, &t, &b );
    RfVec3 across = rf_add( rf_scale( t, cosf( phi ) ), rf_scale( b, sinf( phi ) ) );
    if ( e->infinite )
    {
        e->position = rf_madd( e->position, across, chord );
        return true;
    }
    float versine = 0.5f * chord * chord, sine = sqrtf( versine * ( 2.0f - versine ) );
    RfVec3 d = rf_normalize( rf_madd( rf_scale( across, sine ), e->direction, 1.0f - versine ) );
    return rf_emit_towards( rf_tracer_lights( tracer ), rf_tracer_scene( tracer ), d, e );
}

// One more trial of the links that are pending: light paths from around the solution, until one is found that a link would
// bend to the same. Returns how many are pending still.
static int try_again( Work* w, uint32_t trial, bool* pending )
{
    const RfTracer* tracer = w->settings->path->tracer;
    const RfTriangleRecord* triangles = rf_tracer_triangles( tracer );
    const RfLightPaths* paths = w->settings->paths;
    RfChain* chains[RF_CHAIN_BLOCK];
    bool active[RF_CHAIN_BLOCK];
    RfLanding land;
    for ( int k = 0; k < w->count; ++k )
    {
        const Link* link = w->link + k;
        RfBend* bend = w->bend + k;
        chains[k] = &bend->at;
        bend->active = active[k] = pending[k] && draw_start( w, link, trial, &bend->at.start );
        bend->at.events = link->chain.events;
        bend->at.length = link->chain.length;
        w->out->trials += pending[k];
    }
    rf_walk_chains( tracer, RF_CHAIN_COPY, NULL, active, w->count, chains, &land, &w->out->rays );
    for ( int k = 0; k < w->count; ++k )
    {
        RfBend* bend = w->bend + k;
        if ( !active[k] || bend->at.length == 0 )
        {
            bend->active = false;
            continue;
        }
        const Link* link = w->link + k;
        RfVec3 apart = rf_sub( start_of( w->v, link->lane ), land.p[k] );
        RfFootprint footprint = rf_find_footprint( paths, rf_tracer_lights( tracer ), &bend->at, rf_steer_pdf( paths, &bend->at ),
                                                   land.p[k], triangles[land.triangle[k]].ng );
        bend->most = STEP_MARGIN * footprint.reach;
        bend->active = footprint.radius > 0.0f && rf_dot( apart, apart ) <= footprint.radius * footprint.radius;
    }
    rf_bend_chains( tracer, w->count, w->bend, &w->out->rays );
    int left = 0;
    for ( int k = 0; k < w->count; ++k )
    {
        if ( !pending[k] )
            continue;
        Link* link = w->link + k;
        const RfBend* bend = w->bend + k;
        bool same = bend->met && distance_of( &bend->at.start, &link->chain.start ) <= SAME * link->reach;
        pending[k] = !same;
        link->repeats += pending[k] ? 1.0f : 0.0f;
        left += pending[k];
    }
    return left;
}

static void repeat_trials( Work* w )
{
    bool pending[RF_CHAIN_BLOCK];
    int left = 0;
    for ( int k = 0; k < w->count; ++k )
        left += pending[k] = w->link[k].open;
    for ( uint32_t trial = 0; left > 0 && trial < MOST_REPEATS; ++trial )
        left = try_again( w, trial, pending );
}

static void add( Work* w, const Link* link )
{
    int i = link->lane;
    RfLinkLanes* out = w->out;
    float n = (float)w->settings->paths->emitted, found = RF_PI * link->reach * link->reach * n;
    RfVec3 light = rf_scale( link->light, link->repeats / found );
    float add[3] = { light.x, light.y, light.z }, weight = rf_luminance( light );
    w->chosen[i] += weight;
    bool choose = rf_random( link->key, DIMENSION_CHOOSE ) * w->chosen[i] < weight || out->found[i] == 0;
    for ( int c = 0; c < 3; ++c )
        out->light[c][i] += add[c];
    out->found[i] += 1;
    if ( !choose )
        return;
    float wi[3] = { link->wi.x, link->wi.y, link->wi.z };
    for ( int c = 0; c < 3; ++c )
    {
        out->wi[c][i] = wi[c];
        out->one[c][i] = add[c] / weight;
    }
}

#ifdef DBG
#include <stdio.h>
#include <stdlib.h>
static long d_cand, d_open, d_vis, d_len[10], d_k[10], d_big[10];
static double d_light[10];
static void d_print( void )
{
    fprintf( stderr, "cand %ld open %ld vis %ld\n", d_cand, d_open, d_vis );
    for ( int i = 0; i < 10; i++ )
        fprintf( stderr, "len %d: %ld meanK %.1f big %ld light %g\n", i, d_len[i], d_len[i] ? (double)d_k[i] / d_len[i] : 0,
                 d_big[i], d_light[i] );
}
#endif
static void flush( Work* w )
{
    if ( w->count == 0 )
        return;
    solve( w );
#ifdef DBG
    static int reg;
    if ( !reg )
    {
        reg = 1;
        atexit( d_print );
    }
    d_cand += w->count;
    for ( int k = 0; k < w->count; ++k )
        d_open += w->link[k].open;
#endif
    test_visibility( w );
    if ( w->settings->normalization == RF_KERNEL_EXACT )
        repeat_trials( w );
    for ( int k = 0; k < w->count; ++k )
    {
        if ( w->link[k].open )
            add( w, w->link + k );
#ifdef DBG
        if ( w->link[k].open )
        {
            int l = w->link[k].chain.length;
            d_vis++;
            d_len[l]++;
            d_k[l] += w->link[k].repeats;
            d_big[l] += w->link[k].repeats > 100;
            d_light[l] += rf_luminance( w->link[k].light ) * w->link[k].repeats / ( w->link[k].reach * w->link[k].reach );
        }
#endif
    }
    w->count = 0;
}

static void link_lane( Work* w, int i )
{
    const RfVertexLanes* v = w->v;
    int slot = v->slot[i];
    RfRandomKey lane =
        rf_pixel_key( (uint64_t)w->keys->key_a[slot] << 32 | w->keys->key_b[slot], 0x6b65726eu + (uint32_t)w->vertex );
    Candidates c = { .settings = w->settings, .y = start_of( v, i ), .n = lane_of( v->ng, i ) };
    c.spent = w->vertex - 1 + ( w->keys->spent != NULL ? w->keys->spent[slot] : 0 );
    float scale = find_candidates( &c, lane ), sum = 0.0f, trials = w->vertex == 1 ? TRIAL_LINKS : TRIAL_LINKS_BEYOND;
    for ( int k = 0; k < c.kept; ++k )
        sum += c.light[k];
    for ( int k = 0; k < c.kept; ++k )
    {
        // trial links: so many, in proportion to what they are expected to bring
        RfRandomKey key = rf_pixel_key( (uint64_t)lane.a << 32 | lane.b, c.path[k] );
        float accepted = rf_minf( trials * c.light[k] / sum, 1.0f );
        if ( rf_random( key, DIMENSION_ACCEPT ) >= accepted )
            continue;
        Link* link = w->link + w->count++;
        *link = ( Link ){ .lane = i, .path = w->settings->paths->path + c.path[k], .key = key, .scale = scale / accepted };
        if ( w->count == RF_CHAIN_BLOCK )
            flush( w );
    }
}

void rf_link_vertices( const RfKernelLinker* linker, RfWavefront* keys, const RfVertexLanes* v, int vertex )
{
    RfLinkLanes* out = linker->out;
    Work w = { .settings = linker, .keys = keys, .vertex = vertex, .v = v, .out = out };
    int count = rf_record_count( v );
    out->rays = out->trials = 0;
    memset( out->light, 0, sizeof out->light );
    memset( out->one, 0, sizeof out->one );
    memset( out->found, 0, sizeof out->found );
    for ( int c = 0; c < 3; ++c )
        memcpy( out->wi[c], v->n[c], (size_t)count * sizeof( float ) );
    for ( int i = 0; i < count; ++i )
        link_lane( &w, i );
    flush( &w );
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            out->one[c][i] *= w.chosen[i];
    }
    keys->path_rays += out->rays;
}

// Links as light samples.
static void sample( const RfLinker* linker, RfWavefront* keys, const RfVertexLanes* v, int vertex, RfLightLanes* out )
{
    const RfKernelLinker* kernel = (const RfKernelLinker*)(const void*)linker;
    const RfLinkLanes* links = kernel->out;
    int count = rf_record_count( v );
    rf_link_vertices( kernel, keys, v, vertex );
    float scale = RF_DELTA_PDF * (float)kernel->path->light_samples;
    for ( int i = 0; i < v->count; ++i )
    {
        bool found = i < count && links->found[i] > 0;
        for ( int c = 0; c < 3; ++c )
        {
            out->wi[c][i] = found ? links->wi[c][i] : v->n[c][i];
            out->radiance_cos[c][i] = found ? links->one[c][i] * scale : 0.0f;
        }
        out->pdf_solid_angle[i] = found ? RF_DELTA_PDF : 1.0f;
    }
}

RfKernelLinker rf_make_linker( const RfLightPaths* paths, RfKernelNormalization normalization, const RfPathSettings* path,
                               RfLinkLanes* lanes )
{
    return ( RfKernelLinker ){ { sample }, path, paths, normalization, lanes };
}
