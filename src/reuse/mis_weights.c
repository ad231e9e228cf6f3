// The light of hit records, weighted over the eyes that could have drawn each
// direction (src/reuse/estimators.md, E1 and E3).
#include "base/fault.h"
#include "reuse/accumulate/biased_weights.h"
#include "reuse/harvest/harvest_internal.h"

#include <string.h>

// A mixture density below this is no density: nothing was drawn there.
#define MIN_PDF 1e-30f

typedef RfArrivalLanes Arrival;

static void direction_lanes( const RfHarvest* harvest, RfHarvestScratch* scratch, int direction, const float* wi[3] )
{
    int pairing = direction - rf_first_pairing( &harvest->shape );
    float( *lanes )[RF_LANES] = pairing == harvest->shape.tile_pixels      ? scratch->connections->wi
                                : direction < harvest->shape.light_samples ? scratch->direct[direction].wi
                                : pairing < 0                              ? scratch->chain_samples->found.wi
                                : pairing == 0                             ? scratch->scattered
                                                                           : scratch->tiles->pairings[pairing].wi;
    for ( int c = 0; c < 3; ++c )
        wi[c] = lanes[c];
}

static void gather_light_sample( const RfHarvest* harvest, const RfHarvestScratch* scratch, int sample, Arrival* out )
{
    const RfLightLanes* direct = scratch->direct + sample;
    size_t bytes = (size_t)scratch->hits->count * sizeof( float );
    float k = (float)harvest->shape.light_samples;
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( out->a[c], direct->radiance_cos[c], bytes );
        memset( out->b[c], 0, bytes );
    }
    for ( int i = 0; i < scratch->hits->count; ++i )
        out->light_pdf[i] = k * direct->pdf_solid_angle[i];
}

static void gather_scattered( const RfHarvest* harvest, const RfHarvestScratch* scratch, Arrival* out )
{
    const RfVertexLanes* v = scratch->hits;
    const RfArrivals* arrivals = &scratch->wavefront.arrivals;
    const float( *wi )[RF_LANES] = scratch->scattered;
    float k = (float)harvest->shape.light_samples;
    int count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        int slot = v->slot[i];
        float cos_x = v->n[0][i] * wi[0][i] + v->n[1][i] * wi[1][i] + v->n[2][i] * wi[2][i];
        for ( int c = 0; c < 3; ++c )
        {
            out->a[c][i] = cos_x * arrivals->emitted[c][slot];
            out->b[c][i] = cos_x * arrivals->rest[c][slot];
        }
        out->light_pdf[i] = k * arrivals->light_pdf_solid_angle[slot];
    }
}

// Of the glossy hits.
static void gather_tile_light( const RfHarvest* harvest, const RfHarvestScratch* scratch, int pairing, Arrival* out )
{
    int first = scratch->hits->first[RF_BSDF_FIRST_GLOSSY], end = rf_record_count( scratch->hits );
    size_t bytes = (size_t)( end - first ) * sizeof( float );
    rf_gather_tile_light( scratch->tiles, pairing, scratch->hits, first, end, out->b );
    for ( int c = 0; c < 3; ++c )
        memset( out->a[c] + first, 0, bytes );
    memset( out->light_pdf + first, 0, bytes );
    if ( harvest->shape.chain_samples > 0 )
        rf_share_chain_light( harvest, scratch, pairing, out );
}

// Q = A / (K p_L + P) + B / P, at lane i.
static void light_of( const Arrival* arrival, int i, float mixture, float q[3] )
{
    float both = arrival->light_pdf[i] + mixture;
    float scale_a = both > MIN_PDF ? 1.0f / both : 0.0f;
    float scale_b = mixture > MIN_PDF || RF_FAULT( mixture ) ? 1.0f / mixture : 0.0f;
    for ( int c = 0; c < 3; ++c )
        q[c] = arrival->a[c][i] * scale_a + arrival->b[c][i] * scale_b;
}

// Diffuse hits: the density is the same for all eyes, so the light to any of
// them is known here.
static void add_diffuse( const RfHarvestScratch* scratch, const Arrival* arrival, const float* const wi[3], RfHitBatch* batch,
                         RfLaneScratch* s )
{
    int count = batch->first[RF_BSDF_FIRST_GLOSSY];
    const RfVertexLanes* v = scratch->hits;
    const float* wo[3] = { v->wo[0], v->wo[1], v->wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_seen_from( v, RF_BSDF_LAMBERT, wo, wi, f, s->pdf );
    for ( int i = 0; i < count; ++i )
    {
        float q[3];
        light_of( arrival, i, s->pdf[i], q );
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] += f[c][i] * q[c];
    }
}

// The light of all neighbour paths at once: for diffuse hits their directions do not matter.
static void add_diffuse_tile_light( const RfHarvest* harvest, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    int count = batch->first[RF_BSDF_FIRST_GLOSSY];
    const RfVertexLanes* v = scratch->hits;
    float( *sum )[RF_LANES] = scratch->arrival.b;
    const RfChainSamples* samples = scratch->chain_samples;
    RfChainSampling sampling = rf_chain_sampling( harvest, true );
    float worth = sampling.worth / ( sampling.worth + (float)sampling.count ); // of diffuse hits, for any direction
    rf_gather_diffuse_tile_light( scratch->tiles, harvest->shape.tile_pixels, count, samples != NULL ? samples->taken : NULL,
                                  worth, sum );
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] += v->param[RF_PARAM_DIFFUSE + c][i] * sum[c][i];
    }
}

// P += r_l p_l(wi; x) of the glossy hits for one eye and direction, r_l = J_l V_l / Σ J V.
static void add_density( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch, int eye, int direction )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = batch->count - first;
    const float *wo[3] = { scratch->wo[0], scratch->wo[1], scratch->wo[2] }, *wi[3];
    direction_lanes( harvest, scratch, direction, wi );
    for ( int c = 0; c < 3; ++c )
        wi[c] += first;
    float* restrict pdf = scratch->wavefront.scratch.pdf;
    float* restrict mixture = scratch->mixture + (size_t)direction * RF_LANES;
    rf_evaluate_glossy( batch, wo, wi, NULL, scratch->wavefront.scratch.pdf );
    if ( harvest->weights != RF_WEIGHTS_EXACT )
    {
        memcpy( mixture, pdf, (size_t)count * sizeof( float ) );
        return;
    }
    const float* restrict sum = batch->density_sum + first;
    const float* restrict density = scratch->density + (size_t)eye * RF_LANES + first;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        mixture[i] += density[i] / sum[i] * pdf[i];
}

// P of all directions. With eyes that are not weighted, the density is that of
// the hit's own eye.
static void mix_densities( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch )
{
    int directions = rf_first_pairing( &harvest->shape ) + harvest->shape.tile_pixels; // connections do not depend on densities
    float* wo[3] = { scratch->wo[0], scratch->wo[1], scratch->wo[2] };
    memset( scratch->mixture, 0, (size_t)directions * RF_LANES * sizeof( float ) );
    for ( int l = 0; l < harvest->shape.eyes; ++l )
    {
        if ( harvest->weights != RF_WEIGHTS_EXACT && l != batch->eye )
            continue;
        if ( batch->rows[2 * l] > batch->rows[2 * l + 1] )
            continue; // sees nothing of the batch
        rf_directions_to( rf_tracer_mirrors( harvest->path.tracer ), harvest->eyes + l, l, batch, wo );
        for ( int d = 0; d < directions; ++d )
            add_density( harvest, batch, scratch, l, d );
    }
}

static void store_direction( const RfHitBatch* batch, const Arrival* arrival, const float* const wi[3], const float* mixture,
                             RfDirectionLanes* out )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = batch->count - first;
    for ( int i = 0; i < count; ++i )
    {
        float q[3];
        light_of( arrival, first + i, mixture[i], q );
        for ( int c = 0; c < 3; ++c )
        {
            out->wi[c][i] = wi[c][first + i];
            out->q[c][i] = q[c];
        }
    }
}

static void weight_direction( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, int direction )
{
    Arrival* arrival = &scratch->arrival;
    int pairing = direction - rf_first_pairing( &harvest->shape );
    if ( direction < harvest->shape.light_samples )
        gather_light_sample( harvest, scratch, direction, arrival );
    else if ( pairing < 0 )
        rf_gather_chain_samples( scratch, arrival );
    else if ( pairing == 0 )
        gather_scattered( harvest, scratch, arrival );
    else
        gather_tile_light( harvest, scratch, pairing, arrival );
    const float* wi[3];
    direction_lanes( harvest, scratch, direction, wi );
    if ( pairing <= 0 )
        add_diffuse( scratch, arrival, wi, batch, &scratch->wavefront.scratch );
    if ( batch->first[RF_BSDF_FIRST_GLOSSY] < batch->count )
        store_direction( batch, arrival, wi, scratch->mixture + (size_t)direction * RF_LANES, batch->directions + direction );
    if ( batch->eq15 != NULL )
        rf_keep_eq15( batch, arrival, batch->eq15 + direction );
}

// The light of connections. It needs no weight: nothing else brings it.
static void add_connections( const RfHarvest* harvest, RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    const RfConnectionLanes* connections = scratch->connections;
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = batch->count - first;
    bool any = harvest->light_paths != NULL;
    for ( int i = 0; i < first && any; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] += v->param[RF_PARAM_DIFFUSE + c][i] * RF_INV_PI * connections->light[c][i];
    }
    if ( count == 0 )
        return;
    RfDirectionLanes* out = batch->directions + rf_direction_count( &harvest->shape ) - 1;
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( out->wi[c], any ? connections->wi[c] + first : v->n[c] + first, (size_t)count * sizeof( float ) );
        if ( any )
            memcpy( out->q[c], connections->one[c] + first, (size_t)count * sizeof( float ) );
        else
            memset( out->q[c], 0, (size_t)count * sizeof( float ) );
    }
}

// What a chain leaves of the light at its end.
static void dim_chains( const RfHarvest* harvest, RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        if ( batch->view[i] != RF_VIEW_CHAIN )
            continue;
        for ( int c = 0; c < 3; ++c )
        {
            float left = scratch->chains->throughput[c][slot];
            batch->radiance[4 * i + c] *= left;
            for ( int d = 0; i >= first && d < rf_direction_count( &harvest->shape ); ++d )
                batch->directions[d].q[c][i - first] *= left;
        }
    }
}

void rf_weight_batch( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    for ( int i = 0; i < batch->count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] = v->emission[c][i];
        batch->radiance[4 * i + 3] = 1.0f;
    }
    if ( harvest->path.max_depth == 1 )
    {
        rf_clear_directions( batch, rf_direction_count( &harvest->shape ) );
        if ( batch->eq15 != NULL )
            rf_clear_eq15( batch, rf_direction_count( &harvest->shape ) );
        return;
    }
    bool glossy = batch->first[RF_BSDF_FIRST_GLOSSY] < batch->count;
    if ( glossy )
        mix_densities( harvest, batch, scratch );
    if ( rf_reuses_tiles( scratch ) )
        add_diffuse_tile_light( harvest, scratch, batch );
    int directions = rf_first_pairing( &harvest->shape ) + ( glossy ? harvest->shape.tile_pixels : 1 );
    for ( int d = 0; d < directions; ++d )
        weight_direction( harvest, batch, scratch, d );
    if ( harvest->shape.connections )
        add_connections( harvest, batch, scratch );
    if ( rf_follows_chains( scratch ) )
        dim_chains( harvest, batch, scratch );
}
