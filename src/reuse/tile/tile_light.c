// The light that second vertices scatter to the hits of their tile (E4): from light samples, from the continuation of their
// path, and from light paths. Every path of the tile that reaches a vertex could have sampled a direction there, so
// directions are drawn by the mixture of these paths, as those at first hits by that of the cameras (path/mis.h):
// Q = A / (K p_L + P) + B / P with P = Σ_k (ρ_k / Σ ρ) p(ω; seen from x^k).
#include "reuse/tile/tile_reuse.h"

#include <string.h>

// Whether light of a part that holds in its own frame alone arrives at second vertices; parts beyond base parts have none.
static inline bool has_own( const RfTileReuse* reuse, int part )
{
    return reuse->split && part < reuse->base_parts && reuse->own->groups[part].any;
}

// What arrives of a part at all second vertices by one direction: that of a light sample, or the scattered one.
static void gather_light_sample( const RfPathSettings* settings, RfTileReuse* reuse, int part, int sample )
{
    RfSecondVertices* second = &reuse->second;
    const RfLightLanes* direct = second->direct + sample;
    rf_gather_light_sample( direct, settings->parts ? part : RF_ALL_PARTS, second->lanes.count, (float)settings->light_samples,
                            &second->arrival );
    if ( has_own( reuse, part ) )
        rf_split_arrival( direct->touched, second->lanes.count, &second->arrival, &reuse->own->arrival );
}

static void gather_scattered( const RfPathSettings* settings, RfTileReuse* reuse, int part )
{
    RfSecondVertices* second = &reuse->second;
    const float* wi[3] = { second->wi[0], second->wi[1], second->wi[2] };
    rf_gather_scattered( &second->lanes, second->lanes.count, wi, reuse->at_second + part, (float)settings->light_samples,
                         &second->arrival );
    if ( has_own( reuse, part ) )
        rf_gather_scattered( &second->lanes, second->lanes.count, wi, rf_own_arrivals( &reuse->own->beyond, part ),
                             (float)settings->light_samples, &reuse->own->arrival );
}

// Diffuse vertices scatter the same light to all receivers; their f and densities are in the scratch.
static void add_diffuse( int part, RfTileReuse* reuse, const RfLaneScratch* s )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    const float* f[3] = { s->f[0], s->f[1], s->f[2] };
    for ( int a = 0; a < y->first[RF_BSDF_FIRST_GLOSSY]; ++a )
    {
        float q[3];
        rf_weigh_arrival( &reuse->second.arrival, a, s->pdf[a], q );
        for ( int c = 0; c < 3; ++c )
            reuse->pairings[0].of_part[part].light[c][a] += f[c][a] * q[c];
    }
    for ( int a = 0; a < y->first[RF_BSDF_FIRST_GLOSSY] && has_own( reuse, part ); ++a )
    {
        float q[3];
        rf_weigh_arrival( &reuse->own->arrival, a, s->pdf[a], q );
        for ( int c = 0; c < 3; ++c )
            reuse->pairings[0].own[part].light[c][a] += f[c][a] * q[c];
    }
}

// The weight of the light path's connection at second vertex `a` in what hit i receives from there: a connection at the hit
// may find the same light. i < 0: none does.
static float connection_weight( const RfPathSettings* settings, const RfTileReuse* reuse, int i, int a )
{
    const RfVertexLanes *x = reuse->hits.lanes, *y = &reuse->second.lanes;
    if ( i < 0 || reuse->second.connection_area[a] == INFINITY || !rf_is_matte_lane( settings, x, i ) )
        return 1.0f;
    RfVec3 from = rf_madd( RF_GET3( x->p, i ), RF_GET3( x->ng, i ), x->offset[i] );
    return rf_own_weight( settings->connector->vpl_connections, reuse->second.connection_area[a], from, RF_GET3( x->n, i ),
                          RF_GET3( y->p, a ), RF_GET3( y->ng, a ) );
}

// The same for second vertices [first, end) and their receivers in a pairing; 0 without one.
static void find_connection_weights( const RfPathSettings* settings, const RfTileReuse* reuse, int pairing, int first, int end,
                                     float* weight )
{
    for ( int a = first; a < end; ++a )
    {
        int i = reuse->second.owner[a];
        bool has_receiver = i >= 0 && pairing < reuse->hits.size[i];
        weight[a] = has_receiver ? connection_weight( settings, reuse, rf_receiver( reuse, a, pairing ), a ) : 0.0f;
    }
}

// Adds the light of light paths, as gathered, that diffuse vertices scatter to each receiver. All other light was added before.
static void add_diffuse_connections( const RfPathSettings* settings, int part, int tile_pixels, RfTileReuse* reuse,
                                     RfLaneScratch* scratch )
{
    int count = reuse->second.lanes.first[RF_BSDF_FIRST_GLOSSY];
    float( *found )[RF_LANES] = scratch->wi, *weight = scratch->visible;
    for ( int a = 0; a < count; ++a )
    {
        float scale = rf_balance_scale( reuse->second.arrival.light_pdf[a], scratch->pdf[a] );
        for ( int c = 0; c < 3; ++c )
            found[c][a] = scratch->f[c][a] * ( reuse->second.arrival.a[c][a] * scale );
    }
    for ( int pairing = tile_pixels - 1; pairing >= 0; --pairing )
    {
        RfPairingLanes* t = reuse->pairings + pairing;
        find_connection_weights( settings, reuse, pairing, 0, count, weight );
        for ( int c = 0; c < 3; ++c )
        {
            for ( int a = 0; a < count; ++a )
                t->of_part[part].light[c][a] = reuse->pairings[0].of_part[part].light[c][a] + weight[a] * found[c][a];
        }
    }
}

// Directions from glossy vertices to their receivers in a pairing, and the weights of these; without a receiver, back along
// the vertex's own path, with weight 0.
static void find_receivers( const RfTileReuse* reuse, int pairing, float wo[3][RF_LANES], float* weight )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    const RfPairingLanes* t = reuse->pairings + pairing;
    for ( int a = y->first[RF_BSDF_FIRST_GLOSSY]; a < rf_record_count( y ); ++a )
    {
        int i = reuse->second.owner[a];
        weight[a] = 0.0f;
        bool has_receiver = i >= 0 && pairing < reuse->hits.size[i];
        if ( has_receiver )
        {
            i = rf_receiver( reuse, a, pairing );
            weight[a] = t->weight[i];
            has_receiver = weight[a] > 0.0f;
        }
        for ( int c = 0; c < 3; ++c )
            wo[c][a] = has_receiver ? -t->wi[c][i] : y->wo[c][a];
    }
}

// Replaces what arrives at glossy vertices [first, end) by what is to be scattered of it (Q), in `a`.
static void weigh_glossy( const RfSecondVertices* second, int first, int end, RfArrivalLanes* arrival )
{
    for ( int i = first; i < end; ++i )
    {
        float q[3];
        rf_weigh_arrival( arrival, i, second->mixture[i], q );
        for ( int c = 0; c < 3; ++c )
            arrival->a[c][i] = q[c];
    }
}

// Light of glossy vertices for their own frame alone, weighted as above.
static void add_own_glossy( int part, int tile_pixels, int first, int end, RfTileReuse* reuse )
{
    weigh_glossy( &reuse->second, first, end, &reuse->own->arrival );
    for ( int pairing = 0; pairing < tile_pixels; ++pairing )
    {
        RfPairingLanes* t = reuse->pairings + pairing;
        for ( int c = 0; c < 3; ++c )
        {
            for ( int a = first; a < end; ++a )
                t->own[part].light[c][a] += t->f[c][a] * reuse->own->arrival.a[c][a];
        }
    }
}

// f of glossy vertices towards the receivers of all pairings, and the mixture of their densities.
static void evaluate_glossy( const float* const wi[3], int tile_pixels, RfTileReuse* reuse, RfLaneScratch* s )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    int first = y->first[RF_BSDF_FIRST_GLOSSY], end = rf_record_count( y );
    const float* wo[3] = { reuse->second.wo[0], reuse->second.wo[1], reuse->second.wo[2] };
    memset( reuse->second.mixture, 0, sizeof reuse->second.mixture );
    for ( int pairing = 0; pairing < tile_pixels; ++pairing )
    {
        RfPairingLanes* t = reuse->pairings + pairing;
        float* f[3] = { t->f[0], t->f[1], t->f[2] };
        float* weight = s->visible;
        find_receivers( reuse, pairing, reuse->second.wo, weight );
        for ( int kind = RF_BSDF_FIRST_GLOSSY; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
        {
            if ( rf_is_model_built( (RfBsdfKind)kind ) )
                rf_evaluate_seen_from( y, (RfBsdfKind)kind, wo, wi, f, s->pdf );
        }
#pragma omp simd
        for ( int a = first; a < end; ++a )
            reuse->second.mixture[a] += weight[a] * s->pdf[a];
    }
}

static void add_glossy( const RfPathSettings* settings, int part, int tile_pixels, bool connections, RfTileReuse* reuse,
                        RfLaneScratch* s )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    int first = y->first[RF_BSDF_FIRST_GLOSSY], end = rf_record_count( y );
    if ( first == end )
        return;
    weigh_glossy( &reuse->second, first, end, &reuse->second.arrival );
    if ( has_own( reuse, part ) && rf_any_arrives( &reuse->own->arrival, first, end ) )
        add_own_glossy( part, tile_pixels, first, end, reuse );
    float* weight = s->visible; // of light paths; other light has none beside that of its mixture
    for ( int a = first; a < end; ++a )
        weight[a] = 1.0f;
    for ( int pairing = 0; pairing < tile_pixels; ++pairing )
    {
        RfPairingLanes* t = reuse->pairings + pairing;
        float( *light )[RF_LANES] = t->of_part[part].light;
        if ( connections )
            find_connection_weights( settings, reuse, pairing, first, end, weight );
        for ( int c = 0; c < 3; ++c )
        {
#pragma omp simd
            for ( int a = first; a < end; ++a )
                light[c][a] += t->f[c][a] * reuse->second.arrival.a[c][a] * weight[a];
        }
    }
}

// One direction at second vertices.
typedef struct Direction
{
    const float* wi[3];
    bool scattered, connections;
} Direction;

// Light of vertices that are not reused reaches the hit of their path as it would without tiles: one of the two is specular. Of a
// part; `own`: what of it holds in its own frame alone.
static void add_not_reused( const RfPathSettings* settings, RfWavefront* wavefront, const Direction* by, int part, bool own,
                            RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    const RfArrivalLanes* arrival = own ? &reuse->own->arrival : &reuse->second.arrival;
    const RfArrivals* at_second = own ? rf_own_arrivals( &reuse->own->beyond, part ) : reuse->at_second + part;
    const RfLaneScratch* s = &wavefront->scratch;
    RfVec3 scale = rf_part_scale( rf_tracer_lights( settings->tracer ), part );
    const float of_frame[3] = { scale.x, scale.y, scale.z };
    for ( int a = 0; a < y->count; ++a )
    {
        if ( rf_scatters_to_tile( reuse, a ) )
            continue;
        int slot = y->slot[a];
        bool specular = by->scattered && a >= rf_record_count( y ); // its ray carried the weight
        float pdf = specular ? reuse->second.pdf[a] : s->pdf[a], q[3];
        float weight = by->connections ? connection_weight( settings, reuse, reuse->second.hit[a], a ) : 1.0f;
        rf_weigh_arrival( arrival, a, pdf, q );
        bool to_own = own || ( reuse->split && settings->own->touched[slot] );
        RfArrivals* to =
            to_own ? rf_own_arrivals( settings->own, rf_counts_in( settings, part ) ) : rf_arrivals_of_part( wavefront, part );
        for ( int c = 0; c < 3; ++c )
        {
            float light = s->f[c][a] * q[c] * weight;
            if ( specular )
            {
                float k = (float)settings->light_samples * at_second->light_pdf_solid_angle[slot];
                light =
                    at_second->rest[c][slot] + ( pdf > 0.0f ? at_second->emitted[c][slot] * rf_balance_weight( pdf, k ) : 0.0f );
            }
            to->rest[c][slot] += reuse->second.throughput[c][a] * light * ( to_own ? of_frame[c] : 1.0f );
        }
    }
}

static bool all_reused( const RfTileReuse* reuse )
{
    for ( int a = 0; a < reuse->second.lanes.count; ++a )
    {
        if ( !rf_scatters_to_tile( reuse, a ) )
            return false;
    }
    return true;
}

// store_own where light is split: what holds in its own frame alone is as in that frame.
static void store_own_split( const RfPathSettings* path, int part, RfArrivals* held, const RfTileReuse* reuse )
{
    RfOwnLight* paths = path->own;
    RfArrivals* to = rf_own_arrivals( paths, rf_counts_in( path, part ) );
    RfVec3 scale = rf_part_scale( rf_tracer_lights( path->tracer ), part );
    const float of_frame[3] = { scale.x, scale.y, scale.z };
    const RfVertexLanes* y = &reuse->second.lanes;
    const RfPairingLanes* own = reuse->pairings;
    float( *light )[RF_LANES] = own->of_part[part].light;
    bool any = has_own( reuse, part );
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        if ( reuse->second.owner[a] < 0 )
            continue;
        int slot = y->slot[a];
        bool touched = paths->touched[slot];
        float weight = own->weight[reuse->second.owner[a]];
        for ( int c = 0; c < 3; ++c )
        {
            float throughput = reuse->second.throughput[c][a];
            float beyond = ( any ? own->own[part].light[c][a] : 0.0f ) + ( touched ? light[c][a] * of_frame[c] : 0.0f );
            held->rest[c][slot] = touched ? 0.0f : weight * light[c][a] * throughput;
            to->rest[c][slot] = ( part < reuse->base_parts ? 0.0f : to->rest[c][slot] ) + weight * beyond * throughput;
        }
    }
}

// Pairing 0 is the light of the hits' own paths; their throughput is that of the panes they passed.
static void store_own( int part, RfArrivals* arrivals, const RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    const RfPairingLanes* own = reuse->pairings;
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        if ( reuse->second.owner[a] < 0 )
            continue;
        for ( int c = 0; c < 3; ++c )
            arrivals->rest[c][y->slot[a]] =
                own->weight[reuse->second.owner[a]] * own->of_part[part].light[c][a] * reuse->second.throughput[c][a];
    }
}

void rf_light_own_paths( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse, float* luminance, bool* lit )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    RfLaneScratch* s = &wavefront->scratch;
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    int k = rf_light_lanes_count( path );
    memset( luminance, 0, (size_t)rf_record_count( y ) * sizeof *luminance );
    memset( lit, 0, (size_t)rf_record_count( y ) * sizeof *lit );
    for ( int d = 0; d <= k; ++d )
    {
        float( *from )[RF_LANES] = d < k ? reuse->second.direct[d].wi : reuse->second.wi;
        const float* wi[3] = { from[0], from[1], from[2] };
        if ( d < k )
            gather_light_sample( path, reuse, 0, d );
        else
            gather_scattered( path, reuse, 0 );
        rf_evaluate_lanes( y, wi, f, s->pdf );
        for ( int a = 0; a < rf_record_count( y ); ++a )
        {
            float q[3], arrives = 0.0f;
            for ( int c = 0; c < 3; ++c )
                arrives += reuse->second.arrival.a[c][a] + reuse->second.arrival.b[c][a];
            lit[a] = lit[a] || arrives > 0.0f;
            rf_weigh_arrival( &reuse->second.arrival, a, s->pdf[a], q );
            luminance[a] += rf_luminance( rf_vec3( s->f[0][a] * q[0], s->f[1][a] * q[1], s->f[2][a] * q[2] ) );
        }
    }
}

static float arriving( const RfPathSettings* path, const RfTileReuse* reuse, int base, int a )
{
    const RfArrivals* arrivals = rf_own_arrivals( &reuse->own->beyond, base );
    int slot = reuse->second.lanes.slot[a];
    float sum = 0.0f;
    for ( int c = 0; c < 3; ++c )
        sum += arrivals->emitted[c][slot] + arrivals->rest[c][slot];
    for ( int j = 0; j < path->light_samples; ++j )
    {
        const RfLightLanes* direct = reuse->second.direct + j;
        if ( direct->touched[a] && ( !path->grouped || direct->part[a] == base ) )
            sum += direct->radiance_cos[0][a] + direct->radiance_cos[1][a] + direct->radiance_cos[2][a];
    }
    return sum;
}

// Finds at which second vertices there is light, of a base part, that holds in its own frame alone; if at any, there is none yet in
// the pairings. Chains bring none.
static void begin_own( const RfPathSettings* path, int tile_pixels, int base, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    RfTileOwnGroup* own = reuse->own->groups + base;
    own->any = false;
    for ( int a = 0; a < y->count; ++a )
    {
        own->lit[a] = arriving( path, reuse, base, a ) > 0.0f;
        own->any = own->any || own->lit[a];
    }
    for ( int k = 0; k < 3 * tile_pixels && own->any; ++k )
    {
        int first = k < 3 ? 0 : reuse->second.shared; // theirs is in pairing 0
        memset( reuse->pairings[k / 3].own[base].light[k % 3] + first, 0, (size_t)( y->count - first ) * sizeof( float ) );
    }
}

// Whether any light of a part comes to second vertices by the direction that was gathered. What a specular vertex scatters carries the
// weight of its ray, and counts behind any cosine.
static bool brings_light( const RfTileReuse* reuse, int part, bool scattered )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    if ( rf_any_arrives( &reuse->second.arrival, 0, y->count ) ||
         ( has_own( reuse, part ) && rf_any_arrives( &reuse->own->arrival, 0, y->count ) ) )
        return true;
    return scattered && rf_record_count( y ) < y->count;
}

// f and densities of the second vertices for a direction, which all parts have in common: the diffuse ones' in the scratch, or with
// `all` those of all that are not seen by receivers, and the glossy ones' in the pairings.
static void evaluate( const Direction* by, bool all, int tile_pixels, RfTileReuse* reuse, RfLaneScratch* s )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    const float *wi[3] = { by->wi[0], by->wi[1], by->wi[2] }, *wo[3] = { y->wo[0], y->wo[1], y->wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    if ( y->first[RF_BSDF_FIRST_GLOSSY] < rf_record_count( y ) )
        evaluate_glossy( wi, tile_pixels, reuse, s );
    if ( all )
        rf_evaluate_lanes( y, wi, f, s->pdf );
    else
        rf_evaluate_seen_from( y, RF_BSDF_LAMBERT, wo, wi, f, s->pdf );
}

// Adds the light of a part that comes to second vertices by a direction to what they scatter to their receivers.
static void add_direction( const RfTileReuseSettings* settings, const Direction* by, int part, bool reused,
                           RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfPathSettings* path = settings->path;
    if ( !reused )
        add_not_reused( path, wavefront, by, part, false, reuse );
    if ( !reused && has_own( reuse, part ) )
        add_not_reused( path, wavefront, by, part, true, reuse );
    if ( by->connections )
        add_diffuse_connections( path, part, settings->tile_pixels, reuse, &wavefront->scratch );
    else
        add_diffuse( part, reuse, &wavefront->scratch );
    add_glossy( path, part, settings->tile_pixels, by->connections, reuse, &wavefront->scratch );
}

// No light comes from second vertices yet; beyond them is that of chains.
static void begin_pairings( const RfTileReuseSettings* settings, RfTileReuse* reuse )
{
    int count = rf_record_count( &reuse->second.lanes ), glossy = count - reuse->second.lanes.first[RF_BSDF_FIRST_GLOSSY];
    bool connected = settings->path->connector != NULL;
    reuse->second.shared = connected ? 0 : count - glossy;
    for ( int part = 0; part < reuse->part_count; ++part )
    {
        for ( int k = 0; k < 3 * ( glossy > 0 || connected ? settings->tile_pixels : 1 ); ++k )
            memset( reuse->pairings[k / 3].of_part[part].light[k % 3], 0, (size_t)count * sizeof( float ) );
    }
    for ( int base = 0; base < reuse->base_parts && reuse->split; ++base )
        begin_own( settings->path, settings->tile_pixels, base, reuse );
}

void rf_light_pairings( const RfTileReuseSettings* settings, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfPathSettings* path = settings->path;
    bool reused = all_reused( reuse ), connected = path->connector != NULL;
    int k = rf_light_set_count( path, path->light_samples );
    begin_pairings( settings, reuse );
    for ( int d = 0; d <= k + connected; ++d ) // light samples, what was scattered, connections
    {
        const RfLightLanes* direct = reuse->second.direct + ( d < k ? d : k );
        Direction by = { .scattered = d == k, .connections = d > k };
        bool evaluated = false;
        for ( int c = 0; c < 3; ++c )
            by.wi[c] = by.scattered ? reuse->second.wi[c] : direct->wi[c];
        for ( int part = 0; part < reuse->part_count; ++part )
        {
            if ( d < k && !rf_sample_has_part( path, path->light_samples, d, part ) )
                continue;
            if ( by.scattered )
                gather_scattered( path, reuse, part );
            else
                gather_light_sample( path, reuse, part, by.connections ? k : d );
            if ( part > 0 && !brings_light( reuse, part, by.scattered ) )
                continue;
            if ( !evaluated )
                evaluate( &by, !reused, settings->tile_pixels, reuse, &wavefront->scratch );
            evaluated = true;
            add_direction( settings, &by, part, reused, wavefront, reuse );
        }
    }
    for ( int part = 0; part < reuse->part_count; ++part )
    {
        RfArrivals* arrivals = rf_arrivals_of_part( wavefront, part );
        if ( reuse->split )
            store_own_split( path, part, arrivals, reuse );
        else
            store_own( part, arrivals, reuse );
    }
}

// The light of a part for its own frame alone that second vertex a sends to hit i by pairing t; `from` has the vertex's light.
static inline float own_light( const RfTileReuse* reuse, int part, const RfPairingLanes* t, const RfPairingLanes* from, int c,
                               int a, int i )
{
    return ( has_own( reuse, part ) ? from->own[part].light[c][a] : 0.0f ) +
           ( t->touched[i] ? from->of_part[part].light[c][a] : 0.0f );
}

// Whether pairing t brings hit i such light.
static inline bool brings_own( const RfTileReuse* reuse, int part, const RfPairingLanes* t, int i )
{
    return t->weight[i] > 0.0f && ( t->touched[i] || ( has_own( reuse, part ) && reuse->own->groups[part].lit[t->vertex[i]] ) );
}

static void gather_own( const RfTileReuse* reuse, int part, int pairing, int first, int end, float light[3][RF_LANES] )
{
    const RfVertexLanes* hits = reuse->hits.lanes;
    const RfPairingLanes* t = reuse->pairings + pairing;
    for ( int i = first; i < end; ++i )
    {
        int a = t->vertex[i];
        bool brings = brings_own( reuse, part, t, i );
        float cos_x = hits->n[0][i] * t->wi[0][i] + hits->n[1][i] * t->wi[1][i] + hits->n[2][i] * t->wi[2][i];
        const RfPairingLanes* from = a < reuse->second.shared ? reuse->pairings : t;
        for ( int c = 0; c < 3; ++c )
        {
            float kappa = brings && t->pane_weight != NULL ? t->pane_weight[c][i] : 1.0f;
            light[c][i] = brings ? cos_x * t->weight[i] * kappa * own_light( reuse, part, t, from, c, a, i ) : 0.0f;
        }
    }
}

void rf_gather_tile_light( const RfTileReuse* reuse, int part, int pairing, int first, int end, bool own_frame,
                           float light[3][RF_LANES] )
{
    const RfVertexLanes* hits = reuse->hits.lanes;
    if ( own_frame )
    {
        gather_own( reuse, part, pairing, first, end, light );
        return;
    }
    int diffuse = reuse->second.shared;
    const RfPairingLanes *t = reuse->pairings + pairing, *own = reuse->pairings;
    bool touched = reuse->split && t->any_touched;
    for ( int i = first; i < end; ++i )
    {
        int a = t->vertex[i];
        float weight = touched && t->touched[i] ? 0.0f : t->weight[i];
        float cos_x = hits->n[0][i] * t->wi[0][i] + hits->n[1][i] * t->wi[1][i] + hits->n[2][i] * t->wi[2][i];
        const RfPairingLanes* from = a < diffuse ? own : t;
        for ( int c = 0; c < 3; ++c )
            light[c][i] = weight > 0.0f ? cos_x * weight * from->of_part[part].light[c][a] : 0.0f;
    }
    for ( int c = 0; c < 3 && t->pane_weight != NULL; ++c )
    {
        for ( int i = first; i < end; ++i )
            light[c][i] = t->weight[i] > 0.0f ? light[c][i] * t->pane_weight[c][i] : 0.0f;
    }
}

// Adds a pairing whose connections pass panes.
static void sum_behind_panes( const RfTileReuse* reuse, int part, const RfPairingLanes* t, const float* weight, int count,
                              float sum[3][RF_LANES] )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( t->weight[i] == 0.0f )
            continue;
        int a = t->vertex[i];
        const RfPairingLanes* from = a < reuse->second.shared ? reuse->pairings : t;
        for ( int c = 0; c < 3; ++c )
            sum[c][i] += weight[i] * t->pane_weight[c][i] * from->of_part[part].light[c][a];
    }
}

// Adds what of a pairing holds in its own frame alone.
static void sum_own( const RfTileReuse* reuse, int part, const RfPairingLanes* t, const float* weight, int count,
                     float sum[3][RF_LANES] )
{
    const uint8_t* lit = has_own( reuse, part ) ? reuse->own->groups[part].lit : NULL;
    for ( int i = 0; i < count && ( t->any_touched || lit != NULL ); ++i )
    {
        if ( !( t->touched[i] | ( lit != NULL ? lit[t->vertex[i]] : 0 ) ) || !brings_own( reuse, part, t, i ) )
            continue; // most, by the first
        int a = t->vertex[i];
        const RfPairingLanes* from = a < reuse->second.shared ? reuse->pairings : t;
        for ( int c = 0; c < 3; ++c )
            sum[c][i] +=
                weight[i] * ( t->pane_weight != NULL ? t->pane_weight[c][i] : 1.0f ) * own_light( reuse, part, t, from, c, a, i );
    }
}

// The weights of a pairing without what moves touches, in `scaled`.
static const float* held_weights( const RfPairingLanes* t, const float* weight, int count, float* scaled )
{
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        scaled[i] = t->touched[i] ? 0.0f : weight[i];
    return scaled;
}

void rf_gather_diffuse_tile_light( const RfTileReuse* reuse, int part, int first, int end, bool own_frame, const bool* weighted,
                                   float chain_weight, float sum[3][RF_LANES] )
{
    int diffuse = reuse->second.shared, count = reuse->hits.lanes->first[RF_BSDF_FIRST_GLOSSY];
    for ( int c = 0; c < 3; ++c )
        memset( sum[c], 0, (size_t)count * sizeof( float ) );
    for ( int s = first; s < end; ++s )
    {
        const RfPairingLanes* t = reuse->pairings + s;
        const float* weight = t->weight;
        float scaled[RF_LANES], guided[RF_LANES];
        for ( int i = 0; i < count && reuse->hits.lanes->guide != NULL; ++i )
            guided[i] = t->weight[i] * t->guided[i];
        if ( reuse->hits.lanes->guide != NULL )
            weight = guided;
        if ( weighted != NULL )
        {
            for ( int i = 0; i < count; ++i )
                scaled[i] = weight[i] * ( weighted[i] && rf_receives_chain_light( reuse, s, i ) ? chain_weight : 1.0f );
            weight = scaled;
        }
        if ( own_frame )
        {
            sum_own( reuse, part, t, weight, count, sum );
            continue;
        }
        if ( reuse->split && t->any_touched )
            weight = held_weights( t, weight, count, scaled );
        if ( t->pane_weight != NULL )
        {
            sum_behind_panes( reuse, part, t, weight, count, sum );
            continue;
        }
        const RfPairingLight *own = reuse->pairings->of_part + part, *others = t->of_part + part;
        for ( int i = 0; i < count; ++i )
        {
            if ( t->weight[i] == 0.0f )
                continue;
            int a = t->vertex[i];
            const RfPairingLight* from = a < diffuse ? own : others;
            for ( int c = 0; c < 3; ++c )
                sum[c][i] += weight[i] * from->light[c][a];
        }
    }
}
