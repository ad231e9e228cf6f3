// The light of hit records, weighted over the cameras that could have drawn each
// direction (src/reuse/estimators.md, E1 and E3).
#include "reuse/harvest/passes.h"

#include <string.h>

// Light samples of other frames are taken only where light has parts by frame.
static bool is_taken( const RfHarvest* harvest, int direction )
{
    return direction >= rf_light_directions( &harvest->shape ) ||
           direction < rf_light_set_count( &harvest->path, harvest->shape.light_samples );
}

static void direction_lanes( const RfHarvest* harvest, RfHarvestScratch* scratch, int direction, const float* wi[3] )
{
    int pairing = direction - rf_first_pairing( &harvest->shape );
    float( *lanes )[RF_LANES] = pairing == harvest->shape.tile_pixels                ? scratch->connections->wi
                                : direction < rf_light_directions( &harvest->shape ) ? scratch->direct[direction].wi
                                : pairing < 0                                        ? scratch->chain_samples->found.wi
                                : pairing == 0                                       ? scratch->scattered
                                                                                     : scratch->tiles->pairings[pairing].wi;
    for ( int c = 0; c < 3; ++c )
        wi[c] = lanes[c];
}

// Tiles' light of a dimmed lamp that holds in its own frame alone is as in that frame.
static void scale_for_frame( const RfHarvest* harvest, const RfHarvestScratch* scratch, int first, int end,
                             float ( *light )[RF_LANES] )
{
    RfVec3 scale = rf_part_scale( rf_tracer_lights( harvest->path.tracer ), scratch->part );
    const float of_frame[3] = { scale.x, scale.y, scale.z };
    for ( int c = 0; c < 3 && scratch->part > 0; ++c )
    {
        for ( int i = first; i < end; ++i )
            light[c][i] *= of_frame[c];
    }
}

// Of the glossy hits: what holds in their own frame alone, or what all share.
static void gather_tile_light( const RfHarvest* harvest, const RfHarvestScratch* scratch, int pairing, bool own,
                               RfArrivalLanes* out )
{
    int first = scratch->hits->first[RF_BSDF_FIRST_GLOSSY], end = rf_record_count( scratch->hits );
    size_t bytes = (size_t)( end - first ) * sizeof( float );
    rf_gather_tile_light( scratch->tiles, pairing, scratch->hits, first, end, own, out->b );
    if ( own )
        scale_for_frame( harvest, scratch, first, end, out->b );
    for ( int c = 0; c < 3; ++c )
        memset( out->a[c] + first, 0, bytes );
    memset( out->light_pdf + first, 0, bytes );
    out->scattered = true;
    if ( harvest->shape.chain_samples > 0 )
        rf_share_chain_light( harvest, scratch, pairing, out );
}

// Of diffuse hits, what is kept apart.
static void add_own_diffuse( const RfArrivalLanes* own, const float* pdf, float* const f[3], RfHitBatch* batch,
                             RfHarvestScratch* scratch )
{
    for ( int i = 0; i < batch->first[RF_BSDF_FIRST_GLOSSY]; ++i )
    {
        float q[3];
        if ( rf_clamps_own( scratch ) )
        {
            rf_add_clamped_own( own, i, pdf[i], ( float[3] ){ f[0][i], f[1][i], f[2][i] }, batch, scratch );
            continue;
        }
        rf_weigh_arrival( own, i, pdf[i], q );
        for ( int c = 0; c < 3; ++c )
            scratch->own->light[c][i] += f[c][i] * q[c];
    }
}

// Diffuse hits: the density is the same for all cameras, so the light to any of
// them is known here.
static void add_diffuse( RfHarvestScratch* scratch, const RfArrivalLanes* arrival, const RfArrivalLanes* own, bool all_indirect,
                         const float* const wi[3], RfHitBatch* batch, RfLaneScratch* s )
{
    int count = batch->first[RF_BSDF_FIRST_GLOSSY];
    const RfVertexLanes* v = scratch->hits;
    const float* wo[3] = { v->wo[0], v->wo[1], v->wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_seen_from( v, RF_BSDF_LAMBERT, wo, wi, f, s->pdf );
    if ( scratch->clamp != NULL )
        rf_add_clamped_diffuse( arrival, all_indirect, s->pdf, f, batch, scratch );
    int left = scratch->clamp == NULL ? count : 0;
    for ( int i = 0; i < left; ++i )
    {
        float q[3];
        rf_weigh_arrival( arrival, i, s->pdf[i], q );
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] += f[c][i] * q[c];
    }
    if ( own != NULL )
        add_own_diffuse( own, s->pdf, f, batch, scratch );
    if ( batch->passes == NULL )
        return;
    rf_pass_diffuse( arrival, s->pdf, f, batch, scratch );
    if ( own != NULL )
        rf_pass_own( own, 0, count, s->pdf, f, scratch );
}

// Path by path.
static void clamp_diffuse_tile_light( const RfHarvest* harvest, const bool* taken, float worth, RfHitBatch* batch,
                                      RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    const float* albedo[3] = { v->param[RF_PARAM_DIFFUSE], v->param[RF_PARAM_DIFFUSE + 1], v->param[RF_PARAM_DIFFUSE + 2] };
    float( *light )[RF_LANES] = scratch->arrival.b;
    int count = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int s = 1; s < harvest->shape.tile_pixels; ++s )
    {
        rf_gather_diffuse_tile_light( scratch->tiles, s, s + 1, count, false, taken, worth, light );
        rf_add_clamped_light( light, albedo, count, batch, scratch );
        if ( harvest->path.own == NULL || !rf_clamps_own( scratch ) )
            continue;
        rf_gather_diffuse_tile_light( scratch->tiles, s, s + 1, count, true, taken, worth, light );
        scale_for_frame( harvest, scratch, 0, count, light );
        rf_add_clamped_own_light( light, albedo, count, batch, scratch );
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
    float worth = rf_balance_weight( sampling.worth, (float)sampling.count ); // of diffuse hits, for any direction
    const bool* taken = samples != NULL ? samples->taken : NULL;
    if ( scratch->clamp != NULL )
        clamp_diffuse_tile_light( harvest, taken, worth, batch, scratch );
    else
    {
        rf_gather_diffuse_tile_light( scratch->tiles, 1, harvest->shape.tile_pixels, count, false, taken, worth, sum );
        for ( int i = 0; i < count; ++i )
        {
            for ( int c = 0; c < 3; ++c )
                batch->radiance[4 * i + c] += v->param[RF_PARAM_DIFFUSE + c][i] * sum[c][i];
        }
    }
    if ( harvest->path.own == NULL || rf_clamps_own( scratch ) )
        return;
    rf_gather_diffuse_tile_light( scratch->tiles, 1, harvest->shape.tile_pixels, count, true, taken, worth, sum );
    scale_for_frame( harvest, scratch, 0, count, sum );
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < count; ++i )
            scratch->own->light[c][i] += v->param[RF_PARAM_DIFFUSE + c][i] * sum[c][i];
    }
}

// P += r_l p_l(wi; x) of the glossy hits for one camera and direction, r_l = J_l V_l / Σ J V.
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
    const float* restrict sum = batch->density_sum + first;
    const float* restrict density = scratch->density + (size_t)eye * RF_LANES + first;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        mixture[i] += rf_mixture_share( density[i], sum[i] ) * pdf[i];
}

// P of all directions.
static void mix_densities( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch )
{
    int directions = rf_first_pairing( &harvest->shape ) + harvest->shape.tile_pixels; // connections do not depend on densities
    float* wo[3] = { scratch->wo[0], scratch->wo[1], scratch->wo[2] };
    memset( scratch->mixture, 0, (size_t)directions * RF_LANES * sizeof( float ) );
    for ( int l = 0; l < harvest->shape.eyes; ++l )
    {
        if ( batch->rows[2 * l] > batch->rows[2 * l + 1] )
            continue; // sees nothing of the batch
        rf_directions_to( rf_tracer_mirrors( harvest->path.tracer ), harvest->eyes + l, l, batch, wo );
        for ( int d = 0; d < directions; ++d )
        {
            if ( is_taken( harvest, d ) )
                add_density( harvest, batch, scratch, l, d );
        }
    }
}

static void store_direction( const RfHitBatch* batch, const RfArrivalLanes* arrival, const float* const wi[3],
                             const float* mixture, RfDirectionLanes* out )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = batch->count - first;
    for ( int i = 0; i < count; ++i )
    {
        float q[3];
        rf_weigh_arrival( arrival, first + i, mixture[i], q );
        for ( int c = 0; c < 3; ++c )
        {
            out->wi[c][i] = wi[c][first + i];
            out->q[c][i] = q[c];
        }
    }
    out->dark = false;
}

// What arrives at the hits from one direction, and with own != NULL the part that holds in their own frame alone, there.
static void gather_direction( const RfHarvest* harvest, RfHarvestScratch* scratch, int direction, const float* const wi[3],
                              RfArrivalLanes* arrival, RfArrivalLanes* own )
{
    int pairing = direction - rf_first_pairing( &harvest->shape );
    const RfVertexLanes* v = scratch->hits;
    float k = (float)harvest->shape.light_samples;
    if ( direction < rf_light_directions( &harvest->shape ) )
    {
        rf_gather_light_sample( scratch->direct + direction, v->count, k, arrival );
        if ( harvest->path.parts )
            rf_keep_part( scratch->direct[direction].part, scratch->part, v->count, arrival );
        if ( own != NULL )
            rf_split_arrival( scratch->direct[direction].touched, v->count, arrival, own );
    }
    else if ( pairing < 0 ) // other cameras do not see hits with chain samples, so all of a group is one
    {
        rf_gather_light_sample( &scratch->chain_samples->found, v->count, 1.0f, arrival );
        for ( int c = 0; c < 3 && scratch->part > 0; ++c )
            memcpy( arrival->a[c], rf_chain_samples_of( scratch->chain_samples, scratch->part )[c],
                    (size_t)v->count * sizeof( float ) );
    }
    else if ( pairing == 0 )
    {
        rf_gather_scattered( v, rf_record_count( v ), wi, rf_arrivals_of_part( &scratch->wavefront, scratch->part ), k, arrival );
        if ( own != NULL )
            rf_gather_scattered( v, rf_record_count( v ), wi,
                                 rf_own_arrivals( harvest->path.own, rf_counts_in( &harvest->path, scratch->part ) ), k, own );
    }
    else
    {
        gather_tile_light( harvest, scratch, pairing, false, arrival );
        if ( own != NULL )
            gather_tile_light( harvest, scratch, pairing, true, own );
    }
}

// Whether light arrives; by pairings of tiles at glossy hits alone.
static bool is_lit( const RfHitBatch* batch, int pairing, const RfArrivalLanes* arrival, const RfArrivalLanes* own )
{
    int first = pairing > 0 ? batch->first[RF_BSDF_FIRST_GLOSSY] : 0;
    return rf_any_arrives( arrival, first, batch->count ) || ( own != NULL && rf_any_arrives( own, first, batch->count ) );
}

// No light comes by a direction.
static void leave_dark( const RfHitBatch* batch, int direction, const float* const wi[3] )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = batch->count - first;
    for ( int c = 0; c < 3 && count > 0; ++c ) // other parts of the light may come by it
        memcpy( batch->directions[direction].wi[c], wi[c] + first, (size_t)count * sizeof( float ) );
    if ( count > 0 )
        batch->directions[direction].dark = true;
}

static void weight_direction( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, int direction )
{
    RfArrivalLanes* arrival = &scratch->arrival;
    int pairing = direction - rf_first_pairing( &harvest->shape );
    bool found = direction >= rf_light_directions( &harvest->shape ) && pairing < 0; // by chain samples
    RfArrivalLanes* own = harvest->path.own != NULL && !found ? &scratch->own->arrival : NULL;
    const float* wi[3];
    bool taken = is_taken( harvest, direction ), sampled = direction < rf_light_directions( &harvest->shape );
    if ( !taken || ( sampled && !rf_sample_has_part( &harvest->path, harvest->shape.light_samples, direction, scratch->part ) ) )
    {
        if ( batch->first[RF_BSDF_FIRST_GLOSSY] < batch->count )
            batch->directions[direction].dark = true;
        return;
    }
    direction_lanes( harvest, scratch, direction, wi );
    bool has_part = !found || scratch->part < rf_base_parts( &harvest->path );
    if ( has_part )
        gather_direction( harvest, scratch, direction, wi, arrival, own );
    if ( harvest->path.parts && !( has_part && is_lit( batch, pairing, arrival, own ) ) )
    {
        leave_dark( batch, direction, wi );
        return;
    }
    scratch->way = sampled ? RF_WAY_LIGHT_SAMPLE : pairing == 0 ? RF_WAY_SCATTERED : RF_WAY_OTHER;
    if ( pairing <= 0 )
        add_diffuse( scratch, arrival, own, found, wi, batch, &scratch->wavefront.scratch );
    if ( batch->first[RF_BSDF_FIRST_GLOSSY] < batch->count )
        store_direction( batch, arrival, wi, scratch->mixture + (size_t)direction * RF_LANES, batch->directions + direction );
    if ( batch->first[RF_BSDF_FIRST_GLOSSY] < batch->count && scratch->clamp != NULL )
        rf_clamp_direction( direction, arrival, found, scratch->mixture + (size_t)direction * RF_LANES, batch, scratch );
    if ( batch->passes != NULL )
        rf_pass_glossy( arrival, scratch->mixture + (size_t)direction * RF_LANES, batch, scratch );
    if ( own != NULL )
        rf_add_own_glossy( batch, wi, scratch );
}

// The light of connections, which no other technique finds: it needs no weight.
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

static void dim_removed( const RfHarvest* harvest, int channel, int i, float left, RfHitBatch* batch )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    batch->removed[4 * i + channel] *= left;
    for ( int d = 0; i >= first && d < rf_direction_count( &harvest->shape ); ++d )
    {
        if ( !batch->removed_directions[d].dark )
            batch->removed_directions[d].q[channel][i - first] *= left;
    }
}

// Throughput of chains.
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
            if ( scratch->clamp != NULL )
                dim_removed( harvest, c, i, left, batch );
            for ( int d = 0; i >= first && d < rf_direction_count( &harvest->shape ); ++d )
                batch->directions[d].q[c][i - first] *= left;
        }
    }
}

// Emission of the hits. That of lights that change otherwise than by a scale other cameras must not see; behind chains none does.
static void add_emission( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    bool splits = harvest->path.own != NULL && !harvest->path.own->caustics;
    for ( int i = 0; i < batch->count; ++i )
    {
        int part = rf_material_part( lights, v->material[i] );
        bool of_frame = rf_is_own_part( part );
        bool own = of_frame && splits && !( rf_has_views( batch ) && batch->view[i] == RF_VIEW_CHAIN );
        part = of_frame ? rf_counts_in( &harvest->path, part ) : part;
        bool shines = !own && ( !harvest->path.parts || part == scratch->part );
        for ( int c = 0; c < 3; ++c )
        {
            batch->radiance[4 * i + c] = shines ? v->emission[c][i] : 0.0f;
            if ( own && part == scratch->part )
                scratch->own->light[c][i] += v->emission[c][i];
            if ( own && part == scratch->part && batch->passes != NULL )
                scratch->own_passes->emission[c][i] += v->emission[c][i];
        }
        batch->radiance[4 * i + 3] = scratch->part == 0 ? 1.0f : 0.0f;
    }
}

void rf_weight_batch( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    add_emission( harvest, batch, scratch );
    if ( scratch->clamp != NULL && rf_follows_chains( scratch ) )
        rf_clamp_seen_emission( batch, scratch );
    if ( batch->passes != NULL )
        rf_pass_emission( batch );
    if ( harvest->path.max_depth == 1 )
    {
        rf_clear_directions( batch, rf_direction_count( &harvest->shape ) );
        return;
    }
    bool glossy = batch->first[RF_BSDF_FIRST_GLOSSY] < batch->count;
    if ( glossy && scratch->part == 0 ) // the mixtures are the same for all parts
        mix_densities( harvest, batch, scratch );
    if ( rf_reuses_tiles( scratch ) )
        add_diffuse_tile_light( harvest, scratch, batch );
    int directions = rf_first_pairing( &harvest->shape ) + ( glossy ? harvest->shape.tile_pixels : 1 );
    for ( int d = 0; d < directions; ++d )
        weight_direction( harvest, batch, scratch, d );
    if ( harvest->shape.connections && scratch->part == 0 )
        add_connections( harvest, batch, scratch );
    if ( rf_follows_chains( scratch ) )
        dim_chains( harvest, batch, scratch );
}
