// Sorts the light of records into passes.
#include "reuse/harvest/passes.h"

#include <string.h>

static void clear_lanes( float* const lanes[3], int count )
{
    for ( int c = 0; c < 3 && count > 0; ++c )
        memset( lanes[c], 0, (size_t)count * sizeof( float ) );
}

static void clear_light( const RfPassLight* light, const RfHitBatch* batch )
{
    int glossy = batch->count - batch->first[RF_BSDF_FIRST_GLOSSY];
    clear_lanes( light->emission, batch->count );
    clear_lanes( light->direct, batch->first[RF_BSDF_FIRST_GLOSSY] );
    clear_lanes( light->direct_q, glossy );
}

// Parts of dimmed lamps have passes of their own; base parts have them together.
static RfPassLight* light_of_part( const RfHarvest* harvest, const RfHitBatch* batch, int part )
{
    return part < rf_base_parts( &harvest->path ) ? batch->passes : batch->dimmed[part - 1].passes;
}

void rf_begin_passes( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    clear_light( batch->passes, batch );
    for ( int part = rf_base_parts( &harvest->path ); part <= batch->dimmed_count; ++part )
        clear_light( light_of_part( harvest, batch, part ), batch );
    size_t others = 4 * sizeof( float ) * (size_t)( batch->miss_count + batch->glint_count );
    for ( int k = 0; k < RF_OTHER_PASSES && others > 0; ++k )
        memset( rf_other_pass( batch, k, batch->count ), 0, others );
    for ( int i = 0; i < batch->count; ++i )
        batch->event[i] = rf_follows_chains( scratch ) ? scratch->chains->event[scratch->hits->slot[i]] : (uint8_t)RF_EVENT_NONE;
    if ( scratch->own != NULL )
        memset( scratch->own_passes, 0, sizeof *scratch->own_passes );
    scratch->way = RF_WAY_OTHER;
}

void rf_pass_emission( const RfHitBatch* batch )
{
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < batch->count; ++i )
            batch->passes->emission[c][i] += batch->radiance[4 * i + c];
    }
}

// Whether what a hit's scattered ray has met is no light but that of chains.
static bool is_by_chain( const RfHarvestScratch* scratch, int hit )
{
    const RfChainLight* light = scratch->wavefront.chain_light;
    if ( scratch->way != RF_WAY_SCATTERED || scratch->chain_samples == NULL || !scratch->chain_samples->taken[hit] ||
         light == NULL )
        return false;
    int slot = scratch->hits->slot[hit];
    return light->light[0][slot] + light->light[1][slot] + light->light[2][slot] > 0.0f;
}

// Q of what light sampling could have found as well.
static void weigh_direct( const RfArrivalLanes* arrival, int hit, float pdf, const RfHarvestScratch* scratch, float q[3] )
{
    float scale_a, scale_b;
    rf_arrival_scales( arrival, hit, pdf, &scale_a, &scale_b );
    if ( is_by_chain( scratch, hit ) )
        scale_a = 0.0f;
    for ( int c = 0; c < 3; ++c )
        q[c] = arrival->a[c][hit] * scale_a;
}

void rf_pass_diffuse( const RfArrivalLanes* arrival, const float* pdf, float* const f[3], const RfHitBatch* batch,
                      const RfHarvestScratch* scratch )
{
    for ( int i = 0; i < batch->first[RF_BSDF_FIRST_GLOSSY] && scratch->way != RF_WAY_OTHER; ++i )
    {
        float q[3];
        weigh_direct( arrival, i, pdf[i], scratch, q );
        for ( int c = 0; c < 3; ++c )
            batch->passes->direct[c][i] += f[c][i] * q[c];
    }
}

// Light samples are direct whole, which accumulation knows.
void rf_pass_glossy( const RfArrivalLanes* arrival, const float* mixture, const RfHitBatch* batch,
                     const RfHarvestScratch* scratch )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = first; i < batch->count && scratch->way == RF_WAY_SCATTERED; ++i )
    {
        float q[3];
        weigh_direct( arrival, i, mixture[i - first], scratch, q );
        for ( int c = 0; c < 3; ++c )
            batch->passes->direct_q[c][i - first] += q[c];
    }
}

void rf_pass_own( const RfArrivalLanes* arrival, int first, int end, const float* pdf, float* const f[3],
                  RfHarvestScratch* scratch )
{
    for ( int i = first; i < end && scratch->way != RF_WAY_OTHER; ++i )
    {
        float q[3];
        weigh_direct( arrival, i, pdf[i - first], scratch, q );
        for ( int c = 0; c < 3; ++c )
            scratch->own_passes->direct[c][i] += f[c][i - first] * q[c];
    }
}

// What is left by the clamp of all that chains have found for an item of the batch.
static float kept_share( const RfHarvest* harvest, const RfHitBatch* batch, RfChains* chains, int item, int slot )
{
    float found = 0.0f, kept = 0.0f;
    if ( !chains->clamped )
        return 1.0f;
    for ( int base = 0; base < rf_base_parts( &harvest->path ); ++base )
    {
        RfHitBatch of_part = rf_batch_of_part( batch, base, true );
        for ( int c = 0; c < 3; ++c )
        {
            found += rf_chain_found( chains, base )[c][slot];
            kept += of_part.radiance[4 * item + c] - rf_chain_light( chains, base )[c][slot];
        }
    }
    return found > 0.0f ? rf_minf( rf_maxf( kept / found, 0.0f ), 1.0f ) : 0.0f;
}

static void pass_chain( const RfHarvest* harvest, RfHitBatch* batch, RfChains* chains, int item, int slot )
{
    float share = kept_share( harvest, batch, chains, item, slot );
    for ( int c = 0; c < 3; ++c )
    {
        rf_other_pass( batch, RF_OTHER_REFLECTION, item )[c] = share * chains->by_event->reflection[c][slot];
        rf_other_pass( batch, RF_OTHER_TRANSMISSION, item )[c] = share * chains->by_event->transmission[c][slot];
    }
}

void rf_pass_chains( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    for ( int k = scratch->ray_miss_count; k < batch->miss_count; ++k )
        pass_chain( harvest, batch, scratch->chains, batch->count + k, scratch->miss_slot[k] );
    for ( int g = 0; g < batch->glint_count; ++g )
        pass_chain( harvest, batch, scratch->chains, batch->count + batch->miss_count + g, scratch->glint_slot[g] );
}

void rf_dim_own( const RfHarvest* harvest, const RfHitBatch* batch, const RfHarvestScratch* scratch, float ( *light )[RF_LANES] )
{
    RF_ALIGN float filter[3][RF_LANES], density[RF_LANES];
    RfProjectedLanes out = { .density = density, .filter = { filter[0], filter[1], filter[2] } };
    rf_own_densities( rf_tracer_mirrors( harvest->path.tracer ), harvest->eyes + batch->eye, batch, out );
    for ( int c = 0; c < 3; ++c )
    {
        const float* kappa = batch->panes[c] != NULL ? batch->panes[c] + (size_t)batch->eye * RF_LANES : NULL;
        for ( int i = 0; i < batch->count; ++i )
        {
            bool chain = batch->view[i] == RF_VIEW_CHAIN;
            float left = chain ? scratch->chains->throughput[c][scratch->hits->slot[i]] : filter[c][i];
            light[c][i] *= left * ( kappa != NULL ? kappa[i] : 1.0f );
        }
    }
}

void rf_pass_own_light( const RfHarvest* harvest, const int32_t* glint_of, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    RfOwnPasses* own = scratch->own_passes;
    if ( rf_has_views( batch ) )
    {
        rf_dim_own( harvest, batch, scratch, own->emission );
        rf_dim_own( harvest, batch, scratch, own->direct );
    }
    for ( int i = 0; i < batch->count; ++i )
    {
        int glint = glint_of[scratch->hits->slot[i]], item = batch->count + batch->miss_count + glint;
        for ( int c = 0; c < 3 && glint >= 0; ++c )
        {
            float all = 0.0f, direct = own->direct[c][i];
            for ( int base = 0; base < rf_base_parts( &harvest->path ); ++base )
                all += rf_own_group( scratch, base )->light[c][i];
            if ( batch->event[i] != RF_EVENT_NONE )
            {
                bool reflected = batch->event[i] == RF_EVENT_REFLECTION;
                rf_other_pass( batch, reflected ? RF_OTHER_REFLECTION : RF_OTHER_TRANSMISSION, item )[c] += all;
                continue;
            }
            rf_other_pass( batch, RF_OTHER_DIRECT, item )[c] += direct;
            rf_other_pass( batch, RF_OTHER_INDIRECT, item )[c] += rf_without_rounding( all - direct - own->emission[c][i], all );
        }
    }
}

static void dim( float* const lanes[3], int at, RfVec3 left )
{
    const float of[3] = { left.x, left.y, left.z };
    for ( int c = 0; c < 3; ++c )
        lanes[c][at] *= of[c];
}

void rf_pass_throughput( const RfHarvest* harvest, RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = 0; i < batch->count && rf_follows_chains( scratch ); ++i )
    {
        int slot = scratch->hits->slot[i];
        if ( batch->view[i] != RF_VIEW_CHAIN )
            continue;
        const RfChains* chains = scratch->chains;
        RfVec3 left = RF_GET3( chains->throughput, slot );
        for ( int part = rf_base_parts( &harvest->path ) - 1; part <= batch->dimmed_count; ++part )
        {
            const RfPassLight* light = light_of_part( harvest, batch, part );
            dim( light->emission, i, left );
            dim( i < first ? light->direct : light->direct_q, i < first ? i : i - first, left );
        }
    }
}
