// The light of hit records, weighted over the eyes that could have drawn each
// direction (estimators.md E1, E3).
#include "reuse/harvest_internal.h"

#include <string.h>

// A mixture density below this is no density: nothing was drawn there.
#define MIN_PDF 1e-30f

typedef RfArrivalLanes Arrival;

static void gather_light_sample( const RfHarvest* harvest, const RfHarvestScratch* scratch, int sample, Arrival* out )
{
    const RfLightLanes* direct = scratch->direct + sample;
    size_t bytes = (size_t)scratch->first.count * sizeof( float );
    float k = (float)harvest->walk.light_samples;
    for ( int c = 0; c < 3; ++c )
    {
        out->wi[c] = direct->wi[c];
        memcpy( out->a[c], direct->radiance_cos[c], bytes );
        memset( out->b[c], 0, bytes );
    }
    for ( int i = 0; i < scratch->first.count; ++i )
        out->light_pdf[i] = k * direct->pdf_solid_angle[i];
}

static void gather_scattered( const RfHarvest* harvest, const RfHarvestScratch* scratch, Arrival* out )
{
    const RfVertexLanes* v = &scratch->first;
    const RfArrivals* arrivals = &scratch->walk.arrivals;
    float k = (float)harvest->walk.light_samples;
    for ( int c = 0; c < 3; ++c )
        out->wi[c] = scratch->scattered[c];
    int count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        int slot = v->slot[i];
        float cos_x = v->n[0][i] * out->wi[0][i] + v->n[1][i] * out->wi[1][i] + v->n[2][i] * out->wi[2][i];
        for ( int c = 0; c < 3; ++c )
        {
            out->a[c][i] = cos_x * arrivals->emitted[c][slot];
            out->b[c][i] = cos_x * arrivals->rest[c][slot];
        }
        out->light_pdf[i] = k * arrivals->light_pdf_solid_angle[slot];
    }
}

// Q = A / (K p_L + P) + B / P, at lane i.
static void light_of( const Arrival* arrival, int i, float mixture, float q[3] )
{
    float both = arrival->light_pdf[i] + mixture;
    float scale_a = both > MIN_PDF ? 1.0f / both : 0.0f;
    float scale_b = mixture > MIN_PDF ? 1.0f / mixture : 0.0f;
    for ( int c = 0; c < 3; ++c )
        q[c] = arrival->a[c][i] * scale_a + arrival->b[c][i] * scale_b;
}

// Diffuse hits: the density is the same for all eyes, so the light to any of
// them is known here.
static void add_diffuse( const RfHarvestScratch* scratch, const Arrival* arrival, RfHitBatch* batch, RfLaneScratch* s )
{
    int count = batch->first[RF_BSDF_PHONG];
    const RfVertexLanes* v = &scratch->first;
    RfBsdfLanes lanes = { .n = { v->n[0], v->n[1], v->n[2] }, .diffuse = { v->diffuse[0], v->diffuse[1], v->diffuse[2] } };
    const float* wo[3] = { v->wo[0], v->wo[1], v->wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_bsdf_evaluate( RF_BSDF_LAMBERT, count, &lanes, wo, arrival->wi, f, s->pdf );
    for ( int i = 0; i < count; ++i )
    {
        float q[3];
        light_of( arrival, i, s->pdf[i], q );
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] += f[c][i] * q[c];
    }
}

// P = Σ_l r_l p_l(wi; x) of the glossy hits, r_l = J_l V_l / Σ J V. With
// eyes that are not weighted, the density is that of the hit's own eye.
static void mix_densities( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch,
                           const Arrival* arrival )
{
    int first = batch->first[RF_BSDF_PHONG], count = batch->count - first;
    const float* wi[3] = { arrival->wi[0] + first, arrival->wi[1] + first, arrival->wi[2] + first };
    float* wo[3] = { scratch->wo[0], scratch->wo[1], scratch->wo[2] };
    const float* wo_in[3] = { wo[0], wo[1], wo[2] };
    const float* restrict sum = batch->density_sum + first;
    const float* restrict pdf = scratch->walk.scratch.pdf;
    float* restrict mixture = scratch->mixture;
    memset( mixture, 0, (size_t)count * sizeof( float ) );
    for ( int l = 0; l < harvest->shape.eyes; ++l )
    {
        if ( harvest->weights != RF_WEIGHTS_EXACT && l != batch->eye )
            continue;
        if ( batch->rows[2 * l] > batch->rows[2 * l + 1] )
            continue; // sees nothing of the batch
        rf_directions_to( harvest->eyes, l, batch, wo );
        rf_evaluate_glossy( batch, wo_in, wi, NULL, scratch->walk.scratch.pdf );
        const float* restrict density = scratch->density + (size_t)l * RF_LANES + first;
        if ( harvest->weights == RF_WEIGHTS_EXACT )
        {
#pragma omp simd
            for ( int i = 0; i < count; ++i )
                mixture[i] += density[i] / sum[i] * pdf[i];
        }
        else
            memcpy( mixture, pdf, (size_t)count * sizeof( float ) );
    }
}

static void store_direction( const RfHarvest* harvest, const RfHitBatch* batch, const Arrival* arrival,
                             const float* mixture, RfDirectionLanes* out )
{
    int first = batch->first[RF_BSDF_PHONG], count = batch->count - first;
    for ( int i = 0; i < count; ++i )
    {
        float q[3];
        light_of( arrival, first + i, mixture[i], q );
        for ( int c = 0; c < 3; ++c )
        {
            out->wi[c][i] = arrival->wi[c][first + i];
            out->q[c][i] = q[c];
        }
    }
    if ( !harvest->shape.eq15 )
        return;
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( out->a[c], arrival->a[c] + first, (size_t)count * sizeof( float ) );
        memcpy( out->b[c], arrival->b[c] + first, (size_t)count * sizeof( float ) );
    }
    memcpy( out->light_pdf, arrival->light_pdf + first, (size_t)count * sizeof( float ) );
}

static void weigh_direction( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, int direction )
{
    Arrival* arrival = &scratch->arrival;
    if ( direction < harvest->walk.light_samples )
        gather_light_sample( harvest, scratch, direction, arrival );
    else
        gather_scattered( harvest, scratch, arrival );
    add_diffuse( scratch, arrival, batch, &scratch->walk.scratch );
    if ( batch->first[RF_BSDF_PHONG] == batch->count )
        return;
    mix_densities( harvest, batch, scratch, arrival );
    store_direction( harvest, batch, arrival, scratch->mixture, batch->directions + direction );
}

void rf_weigh_batch( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = &scratch->first;
    for ( int i = 0; i < batch->count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] = v->emission[c][i];
        batch->radiance[4 * i + 3] = 1.0f;
    }
    if ( harvest->walk.max_depth == 1 )
    {
        rf_clear_directions( batch, harvest->walk.light_samples + 1, harvest->shape.eq15 );
        return;
    }
    for ( int d = 0; d <= harvest->walk.light_samples; ++d )
        weigh_direction( harvest, batch, scratch, d );
}
