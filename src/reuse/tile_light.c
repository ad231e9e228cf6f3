// The light that second vertices scatter to the hits of their tile (E4): from
// their light samples, and from the continuation of their own path. Each direction
// at a vertex could have been sampled by any path of the tile that reaches the
// vertex, so it is weighted over them as directions at a first hit are over the eyes:
// Q = A / (K p_L + P) + B / P with P = Σ_k (ρ_k / Σ ρ) p(ω; seen from x^k).
#include "reuse/tile_connections.h"

#include <string.h>

#define MIN_PDF 1e-30f

// Loads one direction at all second vertices, with its light in two parts.
static void gather_light_sample( const RfPathSettings* settings, RfTileReuse* reuse, int sample )
{
    const RfLightLanes* direct = reuse->direct + sample;
    size_t bytes = (size_t)reuse->second.count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( reuse->a[c], direct->radiance_cos[c], bytes );
        memset( reuse->b[c], 0, bytes );
    }
    for ( int a = 0; a < reuse->second.count; ++a )
        reuse->light_pdf[a] = (float)settings->light_samples * direct->pdf_solid_angle[a];
}

static void gather_scattered( const RfPathSettings* settings, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    const RfArrivals* arrivals_at_second = &reuse->arrivals_at_second;
    for ( int a = 0; a < y->count; ++a )
    {
        int slot = y->slot[a];
        float cos_y = y->n[0][a] * reuse->wi[0][a] + y->n[1][a] * reuse->wi[1][a] + y->n[2][a] * reuse->wi[2][a];
        for ( int c = 0; c < 3; ++c )
        {
            reuse->a[c][a] = cos_y * arrivals_at_second->emitted[c][slot];
            reuse->b[c][a] = cos_y * arrivals_at_second->rest[c][slot];
        }
        reuse->light_pdf[a] = (float)settings->light_samples * arrivals_at_second->light_pdf_solid_angle[slot];
    }
}

static inline void light_of( const RfTileReuse* reuse, int a, float mixture, float q[3] )
{
    float both = reuse->light_pdf[a] + mixture;
    float scale_a = both > MIN_PDF ? 1.0f / both : 0.0f;
    float scale_b = mixture > MIN_PDF ? 1.0f / mixture : 0.0f;
    for ( int c = 0; c < 3; ++c )
        q[c] = reuse->a[c][a] * scale_a + reuse->b[c][a] * scale_b;
}

// Diffuse vertices scatter the same light to all receivers.
static void add_diffuse( const float* const wi[3], RfTileReuse* reuse, RfLaneScratch* s )
{
    const RfVertexLanes* y = &reuse->second;
    const float* wo[3] = { y->wo[0], y->wo[1], y->wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_seen_from( y, RF_BSDF_LAMBERT, wo, wi, f, s->pdf );
    for ( int a = 0; a < y->first[RF_BSDF_FIRST_GLOSSY]; ++a )
    {
        float q[3];
        light_of( reuse, a, s->pdf[a], q );
        for ( int c = 0; c < 3; ++c )
            reuse->pairings[0].light[c][a] += f[c][a] * q[c];
    }
}

// Directions from glossy vertices to their receivers in a pairing, with their
// weights; without a receiver, back along the vertex's own path with weight 0.
static void find_receivers( const RfTileReuse* reuse, int pairing, float wo[3][RF_LANES], float* weight )
{
    const RfVertexLanes* y = &reuse->second;
    const RfPairingLanes* t = reuse->pairings + pairing;
    for ( int a = y->first[RF_BSDF_FIRST_GLOSSY]; a < rf_record_count( y ); ++a )
    {
        int i = reuse->owner[a];
        weight[a] = 0.0f;
        bool has_receiver = i >= 0 && pairing < reuse->size[i];
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

static void add_glossy( const RfPathSettings* settings, const float* const wi[3], int tile_pixels, bool connections,
                        RfTileReuse* reuse, RfLaneScratch* s )
{
    const RfVertexLanes* y = &reuse->second;
    int first = y->first[RF_BSDF_FIRST_GLOSSY], end = rf_record_count( y );
    if ( first == end )
        return;
    const float* wo[3] = { reuse->wo[0], reuse->wo[1], reuse->wo[2] };
    memset( reuse->mixture, 0, sizeof reuse->mixture );
    for ( int pairing = 0; pairing < tile_pixels; ++pairing )
    {
        RfPairingLanes* t = reuse->pairings + pairing;
        float* f[3] = { t->f[0], t->f[1], t->f[2] };
        float* weight = s->visible;
        find_receivers( reuse, pairing, reuse->wo, weight );
        for ( int kind = RF_BSDF_FIRST_GLOSSY; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
        {
            if ( rf_is_model_built( (RfBsdfKind)kind ) )
                rf_evaluate_seen_from( y, (RfBsdfKind)kind, wo, wi, f, s->pdf );
        }
#pragma omp simd
        for ( int a = first; a < end; ++a )
            reuse->mixture[a] += weight[a] * s->pdf[a];
    }
    for ( int a = first; a < end; ++a )
    {
        float q[3];
        light_of( reuse, a, reuse->mixture[a], q );
        for ( int c = 0; c < 3; ++c )
            reuse->a[c][a] = q[c];
    }
    for ( int pairing = 0; pairing < tile_pixels; ++pairing )
    {
        RfPairingLanes* t = reuse->pairings + pairing;
        const float* weight = s->visible;
        rf_find_connection_weights( settings, reuse, pairing, connections, s->visible );
        for ( int c = 0; c < 3; ++c )
        {
#pragma omp simd
            for ( int a = first; a < end; ++a )
                t->light[c][a] += t->f[c][a] * reuse->a[c][a] * weight[a];
        }
    }
}

// Light of vertices that are not reused reaches its own hit as it would without
// tiles: either surface is specular.
static void add_not_reused( const RfPathSettings* settings, RfWavefront* wavefront, const float* const wi[3], bool scattered,
                            bool connections, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    RfLaneScratch* s = &wavefront->scratch;
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_lanes( y, wi, f, s->pdf );
    for ( int a = 0; a < y->count; ++a )
    {
        if ( rf_scatters_to_tile( reuse, a ) )
            continue;
        int slot = y->slot[a];
        bool specular = scattered && a >= rf_record_count( y ); // its ray carried the weight
        float pdf = specular ? reuse->pdf[a] : s->pdf[a], q[3];
        float weight = connections ? rf_connection_weight( settings, reuse, reuse->hit_of[a], a ) : 1.0f;
        light_of( reuse, a, pdf, q );
        for ( int c = 0; c < 3; ++c )
        {
            float light = f[c][a] * q[c] * weight;
            if ( specular )
            {
                float k = (float)settings->light_samples * reuse->arrivals_at_second.light_pdf_solid_angle[slot];
                light = reuse->arrivals_at_second.rest[c][slot] +
                        ( pdf > 0.0f ? reuse->arrivals_at_second.emitted[c][slot] * ( pdf / ( pdf + k ) ) : 0.0f );
            }
            wavefront->arrivals.rest[c][slot] += reuse->throughput[c][a] * light;
        }
    }
}

static bool all_reused( const RfTileReuse* reuse )
{
    for ( int a = 0; a < reuse->second.count; ++a )
    {
        if ( !rf_scatters_to_tile( reuse, a ) )
            return false;
    }
    return true;
}

// Stores the light of pairing 0 as that of the hits' own paths, whose throughput is that
// of the panes they passed.
static void store_own( RfWavefront* wavefront, const RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    const RfPairingLanes* own = reuse->pairings;
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        if ( reuse->owner[a] < 0 )
            continue;
        for ( int c = 0; c < 3; ++c )
            wavefront->arrivals.rest[c][y->slot[a]] = own->weight[reuse->owner[a]] * own->light[c][a] * reuse->throughput[c][a];
    }
}

void rf_light_own_paths( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse, float* luminance )
{
    const RfVertexLanes* y = &reuse->second;
    RfLaneScratch* s = &wavefront->scratch;
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    int k = rf_light_lanes_count( path );
    for ( int a = 0; a < rf_record_count( y ); ++a )
        luminance[a] = -1.0f;
    for ( int d = 0; d <= k; ++d )
    {
        float( *from )[RF_LANES] = d < k ? reuse->direct[d].wi : reuse->wi;
        const float* wi[3] = { from[0], from[1], from[2] };
        if ( d < k )
            gather_light_sample( path, reuse, d );
        else
            gather_scattered( path, reuse );
        rf_evaluate_lanes( y, wi, f, s->pdf );
        for ( int a = 0; a < rf_record_count( y ); ++a )
        {
            float q[3], arrives = 0.0f;
            for ( int c = 0; c < 3; ++c )
                arrives += reuse->a[c][a] + reuse->b[c][a];
            if ( arrives > 0.0f )
                luminance[a] = rf_maxf( luminance[a], 0.0f );
            light_of( reuse, a, s->pdf[a], q );
            luminance[a] += rf_luminance( rf_vec3( s->f[0][a] * q[0], s->f[1][a] * q[1], s->f[2][a] * q[2] ) );
        }
    }
}

void rf_light_pairings( const RfTileReuseSettings* settings, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfPathSettings* path = settings->path;
    int tile_pixels = settings->tile_pixels;
    bool glossy = reuse->second.first[RF_BSDF_FIRST_GLOSSY] < rf_record_count( &reuse->second );
    size_t bytes = (size_t)rf_record_count( &reuse->second ) * sizeof( float ); // beyond is the light of chains
    bool connected = path->connector != NULL;
    reuse->shared = connected ? 0 : reuse->second.first[RF_BSDF_FIRST_GLOSSY];
    for ( int k = 0; k < 3 * ( glossy || connected ? tile_pixels : 1 ); ++k )
        memset( reuse->pairings[k / 3].light[k % 3], 0, bytes );
    bool reused = all_reused( reuse );
    int k = path->light_samples;
    for ( int d = 0; d <= k + connected; ++d ) // light samples, what was scattered, connections
    {
        const RfLightLanes* direct = reuse->direct + ( d < k ? d : k );
        bool scattered = d == k, connections = d > k;
        const float* wi[3] = { scattered ? reuse->wi[0] : direct->wi[0], scattered ? reuse->wi[1] : direct->wi[1],
                               scattered ? reuse->wi[2] : direct->wi[2] };
        if ( scattered )
            gather_scattered( path, reuse );
        else
            gather_light_sample( path, reuse, connections ? k : d );
        if ( !reused )
            add_not_reused( path, wavefront, wi, scattered, connections, reuse );
        if ( connections )
            rf_add_diffuse_connections( path, wi, tile_pixels, reuse, &wavefront->scratch );
        else
            add_diffuse( wi, reuse, &wavefront->scratch );
        add_glossy( path, wi, tile_pixels, connections, reuse, &wavefront->scratch );
    }
    store_own( wavefront, reuse );
}
