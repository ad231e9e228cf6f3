// The light that second vertices send to the hits of their tile (E4): from
// their light samples, and from where their own path went on. Each direction at
// a vertex could have been drawn by any path of the tile that finds the vertex,
// so it is weighed over them as directions at a first hit are over the eyes:
// Q = A / (K p_L + P) + B / P with P = Σ_k (ρ_k / Σ ρ) p(ω; seen from x^k).
#include "reuse/tile_reuse.h"

#include <string.h>

#define MIN_PDF 1e-30f

// A direction at the second vertices, and its light in two parts.
static void gather_light_sample( const RfPathSettings* settings, RfTileReuse* share, int sample )
{
    const RfLightLanes* direct = share->direct + sample;
    size_t bytes = (size_t)share->second.count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( share->a[c], direct->radiance_cos[c], bytes );
        memset( share->b[c], 0, bytes );
    }
    for ( int a = 0; a < share->second.count; ++a )
        share->light_pdf[a] = (float)settings->light_samples * direct->pdf_solid_angle[a];
}

static void gather_scattered( const RfPathSettings* settings, RfTileReuse* share )
{
    const RfVertexLanes* y = &share->second;
    const RfArrivals* beyond = &share->beyond;
    for ( int a = 0; a < y->count; ++a )
    {
        int slot = y->slot[a];
        float cos_y = y->n[0][a] * share->wi[0][a] + y->n[1][a] * share->wi[1][a] + y->n[2][a] * share->wi[2][a];
        for ( int c = 0; c < 3; ++c )
        {
            share->a[c][a] = cos_y * beyond->emitted[c][slot];
            share->b[c][a] = cos_y * beyond->rest[c][slot];
        }
        share->light_pdf[a] = (float)settings->light_samples * beyond->light_pdf_solid_angle[slot];
    }
}

static inline void light_of( const RfTileReuse* share, int a, float mixture, float q[3] )
{
    float both = share->light_pdf[a] + mixture;
    float scale_a = both > MIN_PDF ? 1.0f / both : 0.0f;
    float scale_b = mixture > MIN_PDF ? 1.0f / mixture : 0.0f;
    for ( int c = 0; c < 3; ++c )
        q[c] = share->a[c][a] * scale_a + share->b[c][a] * scale_b;
}

// Diffuse vertices send the same to all.
static void add_diffuse( const float* const wi[3], RfTileReuse* share, RfLaneScratch* s )
{
    const RfVertexLanes* y = &share->second;
    const float* wo[3] = { y->wo[0], y->wo[1], y->wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_seen_from( y, RF_BSDF_LAMBERT, wo, wi, f, s->pdf );
    for ( int a = 0; a < y->first[RF_BSDF_PHONG]; ++a )
    {
        float q[3];
        light_of( share, a, s->pdf[a], q );
        for ( int c = 0; c < 3; ++c )
            share->turns[0].light[c][a] += f[c][a] * q[c];
    }
}

// Directions from shiny vertices to the hits of a turn, and these hits' weights;
// where none looks, back along the vertex's own path with weight 0.
static void look_back( const RfTileReuse* share, int turn, float wo[3][RF_LANES], float* weight )
{
    const RfVertexLanes* y = &share->second;
    const RfPairingLanes* t = share->turns + turn;
    for ( int a = y->first[RF_BSDF_PHONG]; a < rf_record_count( y ); ++a )
    {
        int i = share->owner[a];
        weight[a] = 0.0f;
        bool looks = i >= 0 && turn < share->size[i];
        if ( looks )
        {
            i = rf_receiver( share, a, turn );
            weight[a] = t->weight[i];
            looks = weight[a] > 0.0f;
        }
        for ( int c = 0; c < 3; ++c )
            wo[c][a] = looks ? -t->wi[c][i] : y->wo[c][a];
    }
}

static void add_shiny( const float* const wi[3], int tile_pixels, RfTileReuse* share, RfLaneScratch* s )
{
    const RfVertexLanes* y = &share->second;
    int first = y->first[RF_BSDF_PHONG], end = rf_record_count( y );
    if ( first == end )
        return;
    const float* wo[3] = { share->wo[0], share->wo[1], share->wo[2] };
    memset( share->mixture, 0, sizeof share->mixture );
    for ( int turn = 0; turn < tile_pixels; ++turn )
    {
        RfPairingLanes* t = share->turns + turn;
        float* f[3] = { t->f[0], t->f[1], t->f[2] };
        float* weight = s->visible;
        look_back( share, turn, share->wo, weight );
        for ( int kind = RF_BSDF_PHONG; kind < RF_BSDF_FIRST_UNEVALUABLE; ++kind )
            rf_evaluate_seen_from( y, (RfBsdfKind)kind, wo, wi, f, s->pdf );
#pragma omp simd
        for ( int a = first; a < end; ++a )
            share->mixture[a] += weight[a] * s->pdf[a];
    }
    for ( int a = first; a < end; ++a )
    {
        float q[3];
        light_of( share, a, share->mixture[a], q );
        for ( int c = 0; c < 3; ++c )
            share->a[c][a] = q[c];
    }
    for ( int turn = 0; turn < tile_pixels; ++turn )
    {
        RfPairingLanes* t = share->turns + turn;
        for ( int c = 0; c < 3; ++c )
        {
#pragma omp simd
            for ( int a = first; a < end; ++a )
                t->light[c][a] += t->f[c][a] * share->a[c][a];
        }
    }
}

// What is not shared reaches its own hit as it would without tiles: paths from
// or to a surface without densities.
static void add_unshared( const RfPathSettings* settings, RfWavefront* walk, const float* const wi[3], bool scattered,
                          RfTileReuse* share )
{
    const RfVertexLanes* y = &share->second;
    RfLaneScratch* s = &walk->scratch;
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_lanes( y, wi, f, s->pdf );
    for ( int a = 0; a < y->count; ++a )
    {
        if ( share->owner[a] >= 0 )
            continue;
        int slot = y->slot[a];
        bool native = scattered && a >= rf_record_count( y ); // whose rays took the weight along
        float pdf = native ? share->pdf[a] : s->pdf[a], q[3];
        light_of( share, a, pdf, q );
        for ( int c = 0; c < 3; ++c )
        {
            float light = f[c][a] * q[c];
            if ( native )
            {
                float k = (float)settings->light_samples * share->beyond.light_pdf_solid_angle[slot];
                light =
                    share->beyond.rest[c][slot] + ( pdf > 0.0f ? share->beyond.emitted[c][slot] * ( pdf / ( pdf + k ) ) : 0.0f );
            }
            walk->arrivals.rest[c][slot] += share->throughput[c][a] * light;
        }
    }
}

static bool all_shared( const RfTileReuse* share )
{
    for ( int a = 0; a < share->second.count; ++a )
    {
        if ( share->owner[a] < 0 )
            return false;
    }
    return true;
}

// Light of turn 0 to the hits' own paths.
static void keep_own( RfWavefront* walk, const RfTileReuse* share )
{
    const RfVertexLanes* y = &share->second;
    const RfPairingLanes* own = share->turns;
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        if ( share->owner[a] < 0 )
            continue;
        for ( int c = 0; c < 3; ++c )
            walk->arrivals.rest[c][y->slot[a]] = own->weight[share->owner[a]] * own->light[c][a];
    }
}

void rf_light_pairings( const RfTileReuseSettings* settings, RfWavefront* walk, RfTileReuse* share )
{
    const RfPathSettings* path = settings->walk;
    int tile_pixels = settings->tile_pixels;
    bool shiny = share->second.first[RF_BSDF_PHONG] < rf_record_count( &share->second );
    for ( int s = 0; s < ( shiny ? tile_pixels : 1 ); ++s )
        memset( share->turns[s].light, 0, sizeof share->turns[s].light );
    bool shared = all_shared( share );
    int k = path->light_samples;
    for ( int d = 0; d <= k; ++d )
    {
        float( *from )[RF_LANES] = d < k ? share->direct[d].wi : share->wi;
        const float* wi[3] = { from[0], from[1], from[2] };
        if ( d < k )
            gather_light_sample( path, share, d );
        else
            gather_scattered( path, share );
        if ( !shared )
            add_unshared( path, walk, wi, d == k, share );
        add_diffuse( wi, share, &walk->scratch );
        add_shiny( wi, tile_pixels, share, &walk->scratch );
    }
    keep_own( walk, share );
}

void rf_gather_tile_light( const RfTileReuse* share, int turn, const RfVertexLanes* hits, int first, int end,
                           float borrowed[3][RF_LANES] )
{
    int diffuse = share->second.first[RF_BSDF_PHONG];
    const RfPairingLanes *t = share->turns + turn, *own = share->turns;
    for ( int i = first; i < end; ++i )
    {
        int a = t->mate[i];
        float weight = t->weight[i];
        float cos_x = hits->n[0][i] * t->wi[0][i] + hits->n[1][i] * t->wi[1][i] + hits->n[2][i] * t->wi[2][i];
        const RfPairingLanes* from = a < diffuse ? own : t;
        for ( int c = 0; c < 3; ++c )
            borrowed[c][i] = weight > 0.0f ? cos_x * weight * from->light[c][a] : 0.0f;
    }
}

void rf_gather_diffuse_tile_light( const RfTileReuse* share, int turns, int count, float sum[3][RF_LANES] )
{
    int diffuse = share->second.first[RF_BSDF_PHONG];
    const RfPairingLanes* own = share->turns;
    for ( int c = 0; c < 3; ++c )
        memset( sum[c], 0, (size_t)count * sizeof( float ) );
    for ( int s = 1; s < turns; ++s )
    {
        const RfPairingLanes* t = share->turns + s;
        for ( int i = 0; i < count; ++i )
        {
            if ( t->weight[i] == 0.0f )
                continue;
            int a = t->mate[i];
            const RfPairingLanes* from = a < diffuse ? own : t;
            for ( int c = 0; c < 3; ++c )
                sum[c][i] += t->weight[i] * from->light[c][a];
        }
    }
}
