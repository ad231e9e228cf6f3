// The light of hit records, weighted over the cameras that could have drawn each
// direction (src/reuse/estimators.md, E1 and E3), in each layer.
#include "reuse/harvest/record_weights.h"

#include "reuse/chains/chain_arrivals.h"

#include <string.h>

// A direction that light comes by at all hits. f and densities, seen from the hits' own camera, are the same for all parts of the light;
// they are in the wavefront's scratch by hit, once they are asked for.
typedef struct Direction
{
    int number;
    int pairing;  // of a tile: 0 is the scattered direction; below: light samples and chain samples
    bool sampled; // by light sampling
    bool found;   // by chain samples
    const float* wi[3];
    bool has_diffuse, has_glossy;
    const RfChainLight* chain_light; // RfPathSettings.chain_light
} Direction;

// Light samples of other frames are taken only where light has parts by frame.
static bool is_taken( const RfHarvest* harvest, int direction )
{
    return direction >= rf_light_directions( harvest->shape ) ||
           direction < rf_light_set_count( &harvest->path, harvest->shape->light_samples );
}

static Direction find_direction( const RfHarvest* harvest, RfHarvestScratch* scratch, int number )
{
    Direction by = { .number = number,
                     .pairing = number - rf_first_pairing( harvest->shape ),
                     .sampled = number < rf_light_directions( harvest->shape ),
                     .chain_light = harvest->path.chain_light };
    by.found = !by.sampled && by.pairing < 0;
    float( *lanes )[RF_LANES] = by.sampled        ? scratch->direct[number].wi
                                : by.found        ? scratch->chain_samples->found.wi
                                : by.pairing == 0 ? scratch->scattered
                                                  : scratch->tiles->pairings[by.pairing].wi;
    for ( int c = 0; c < 3; ++c )
        by.wi[c] = lanes[c];
    return by;
}

static int first_glossy( const RfHitBatch* batch ) { return batch->first[RF_BSDF_FIRST_GLOSSY]; }

// ---- What arrives

// Tiles' light of a dimmed lamp that holds in its own frame alone is as in that frame.
static void scale_for_frame( const RfHarvest* harvest, int part, int first, int end, float ( *light )[RF_LANES] )
{
    RfVec3 scale = rf_part_scale( rf_tracer_lights( harvest->path.tracer ), part );
    const float of_frame[3] = { scale.x, scale.y, scale.z };
    for ( int c = 0; c < 3 && part > 0; ++c )
    {
        for ( int i = first; i < end; ++i )
            light[c][i] *= of_frame[c];
    }
}

// Of the glossy hits: what holds in their own frame alone, or what all share.
static void gather_tile_light( const RfHarvest* harvest, const RfHarvestScratch* scratch, int part, int pairing, bool own,
                               RfArrivalLanes* out )
{
    int first = scratch->hits->first[RF_BSDF_FIRST_GLOSSY], end = rf_record_count( scratch->hits );
    size_t bytes = (size_t)( end - first ) * sizeof( float );
    rf_gather_tile_light( scratch->tiles, part, pairing, first, end, own, out->b );
    if ( own )
        scale_for_frame( harvest, part, first, end, out->b );
    for ( int c = 0; c < 3; ++c )
        memset( out->a[c] + first, 0, bytes );
    memset( out->light_pdf + first, 0, bytes );
    out->scattered = true;
    if ( harvest->shape->chain_samples > 0 )
        rf_share_chain_light( harvest, scratch, pairing, out );
}

// What arrives of a part at the hits from one direction, and with own != NULL what of it holds in their own frame alone, there.
static void gather_direction( const RfHarvest* harvest, RfHarvestScratch* scratch, const Direction* by, int part,
                              RfArrivalLanes* arrival, RfArrivalLanes* own )
{
    const RfVertexLanes* v = scratch->hits;
    float k = (float)harvest->shape->light_samples;
    if ( by->sampled )
    {
        rf_gather_light_sample( scratch->direct + by->number, harvest->path.parts ? part : RF_ALL_PARTS, v->count, k, arrival );
        if ( own != NULL )
            rf_split_arrival( scratch->direct[by->number].touched, v->count, arrival, own );
    }
    else if ( by->found ) // other cameras do not see hits with chain samples, so all of a group is one
    {
        rf_gather_light_sample( &scratch->chain_samples->found, RF_ALL_PARTS, v->count, 1.0f, arrival );
        for ( int c = 0; c < 3 && part > 0; ++c )
            memcpy( arrival->a[c], rf_chain_samples_of( scratch->chain_samples, part )[c], (size_t)v->count * sizeof( float ) );
    }
    else if ( by->pairing == 0 )
    {
        rf_gather_scattered( v, rf_record_count( v ), by->wi, rf_arrivals_of_part( &scratch->wavefront, part ), k, arrival );
        if ( own != NULL )
            rf_gather_scattered( v, rf_record_count( v ), by->wi, rf_own_arrivals( harvest->path.own, part ), k, own );
    }
    else
    {
        gather_tile_light( harvest, scratch, part, by->pairing, false, arrival );
        if ( own != NULL )
            gather_tile_light( harvest, scratch, part, by->pairing, true, own );
    }
}

// Whether light of a part may come by a direction. Lamps that are dimmed, and light by frame, have no chain samples.
static bool may_bring( const RfHarvest* harvest, const Direction* by, int part )
{
    if ( by->sampled )
        return rf_sample_has_part( &harvest->path, harvest->shape->light_samples, by->number, part );
    return !by->found || part < rf_base_parts( &harvest->path );
}

// Whether light that arrives by a direction may hold in the hits' own frame alone. What paths and light samples bring of that is all
// of base parts.
static bool may_bring_own( const RfHarvest* harvest, const Direction* by, int part )
{
    return harvest->path.own != NULL && !by->found && ( by->pairing > 0 || part < rf_base_parts( &harvest->path ) );
}

// ---- Where it goes

// Light of one hit from one direction, times f: what light sampling could have found as well, and the rest, which alone is clamped.
typedef struct Value
{
    float direct[3], indirect[3];
} Value;

static Value find_value( const RfArrivalLanes* arrival, const Direction* by, int i, float pdf, const float f[3] )
{
    Value value;
    float scale_a, scale_b;
    rf_arrival_scales( arrival, i, pdf, &scale_a, &scale_b );
    for ( int c = 0; c < 3; ++c )
    {
        float a = f[c] * ( arrival->a[c][i] * scale_a );
        value.direct[c] = by->found ? 0.0f : a;
        value.indirect[c] = f[c] * ( arrival->b[c][i] * scale_b ) + ( by->found ? a : 0.0f );
    }
    return value;
}

// The kind of what light sampling could have found at a hit: what its scattered ray has met may be no light but that of chains, which
// chain samples find.
static RfLayerKind kind_of_direct( const RfHarvestScratch* scratch, const Direction* by, int hit )
{
    const RfChainLight* light = by->chain_light;
    if ( by->sampled )
        return RF_KIND_DIRECT;
    if ( by->pairing != 0 )
        return RF_KIND_INDIRECT;
    if ( scratch->chain_samples == NULL || !scratch->chain_samples->taken[hit] || light == NULL )
        return RF_KIND_DIRECT;
    int slot = scratch->hits->slot[hit];
    return light->light[0][slot] + light->light[1][slot] + light->light[2][slot] > 0.0f ? RF_KIND_INDIRECT : RF_KIND_DIRECT;
}

// Adds the value of a hit: `direct` and `indirect` are where its light is, by channel; `removed` takes what is clamped.
static void add_value( const RfHarvestScratch* scratch, RfHitBatch* batch, int hit, const Value* value, float* direct,
                       float* indirect, RfLayerLight* layer, float* removed )
{
    for ( int c = 0; c < 3; ++c )
        direct[c] += value->direct[c];
    if ( removed == NULL )
    {
        for ( int c = 0; c < 3; ++c )
            indirect[c] += value->indirect[c];
        return;
    }
    if ( rf_add_clamped( scratch->clamp, RF_CLAMP_PATHS, batch, hit, value->indirect, indirect, removed ) )
        layer->dark = false;
}

// Diffuse hits: the density is the same for all cameras, so the light to any of
// them is known here.
static void add_diffuse( const RfArrivalLanes* arrival, const Direction* by, int part, RfHitBatch* batch,
                         RfHarvestScratch* scratch )
{
    const RfLaneScratch* s = &scratch->wavefront.scratch;
    if ( !batch->layers.by_kind && scratch->clamp == NULL )
    {
        float* radiance = rf_layer_light( batch, part, RF_KIND_DIRECT )->radiance;
        for ( int i = 0; i < first_glossy( batch ); ++i )
        {
            float q[3];
            rf_weigh_arrival( arrival, i, s->pdf[i], q );
            for ( int c = 0; c < 3; ++c )
                radiance[4 * i + c] += s->f[c][i] * q[c];
        }
        return;
    }
    RfLayerLight* removed = scratch->clamp != NULL ? rf_removed_light( batch, part ) : NULL;
    for ( int i = 0; i < first_glossy( batch ); ++i )
    {
        Value value = find_value( arrival, by, i, s->pdf[i], ( float[3] ){ s->f[0][i], s->f[1][i], s->f[2][i] } );
        size_t at = 4 * (size_t)i;
        add_value( scratch, batch, i, &value, rf_layer_light( batch, part, kind_of_direct( scratch, by, i ) )->radiance + at,
                   rf_layer_light( batch, part, RF_KIND_INDIRECT )->radiance + at, removed,
                   removed != NULL ? removed->radiance + at : NULL );
    }
}

// Of hits [first, end), what holds in their own frame alone.
static void add_own( const RfArrivalLanes* own, const Direction* by, int base, int first, int end, RfHitBatch* batch,
                     RfHarvestScratch* scratch )
{
    const RfLaneScratch* s = &scratch->wavefront.scratch;
    RfLayerLight* removed = rf_clamps_own( scratch ) ? rf_removed_light( batch, base ) : NULL;
    for ( int i = first; i < end; ++i )
    {
        Value value = find_value( own, by, i, s->pdf[i], ( float[3] ){ s->f[0][i], s->f[1][i], s->f[2][i] } );
        add_value( scratch, batch, i, &value, rf_own_at( scratch, base, kind_of_direct( scratch, by, i ), i ),
                   rf_own_at( scratch, base, RF_KIND_INDIRECT, i ), removed,
                   removed != NULL ? rf_own_removed_at( scratch, base, i ) : NULL );
    }
}

// Glossy hits: light that light sampling could have found, and the rest, are of two kinds.
static void store_by_kind( const RfArrivalLanes* arrival, const Direction* by, int part, const float* mixture,
                           const RfHarvestScratch* scratch, const RfHitBatch* batch )
{
    int first = first_glossy( batch );
    RfLayerLight *direct = rf_layer_light( batch, part, RF_KIND_DIRECT ),
                 *indirect = rf_layer_light( batch, part, RF_KIND_INDIRECT );
    RfWeightedLanes* of_direct = by->pairing <= 0 && !by->found ? rf_weighted( direct, by->number ) : NULL;
    RfWeightedLanes* of_indirect = by->sampled ? NULL : rf_weighted( indirect, by->number );
    for ( int i = 0; i < batch->count - first; ++i )
    {
        float scale_a, scale_b;
        rf_arrival_scales( arrival, first + i, mixture[i], &scale_a, &scale_b );
        bool is_direct = kind_of_direct( scratch, by, first + i ) == RF_KIND_DIRECT;
        for ( int c = 0; c < 3; ++c )
        {
            float a = arrival->a[c][first + i] * scale_a, b = arrival->b[c][first + i] * scale_b;
            if ( of_direct != NULL )
                of_direct->q[c][i] = is_direct ? a : 0.0f;
            if ( of_indirect != NULL )
                of_indirect->q[c][i] = b + ( is_direct ? 0.0f : a );
        }
    }
    if ( of_direct != NULL )
        of_direct->dark = false;
    if ( of_indirect != NULL )
        of_indirect->dark = false;
}

// Glossy hits: all kinds are one.
static void store( const RfArrivalLanes* arrival, const Direction* by, int part, const float* mixture, const RfHitBatch* batch )
{
    int first = first_glossy( batch );
    RfWeightedLanes* out = rf_weighted( rf_layer_light( batch, part, RF_KIND_DIRECT ), by->number );
    for ( int i = 0; i < batch->count - first; ++i )
    {
        float q[3];
        rf_weigh_arrival( arrival, first + i, mixture[i], q );
        for ( int c = 0; c < 3; ++c )
            out->q[c][i] = q[c];
    }
    out->dark = false;
}

static bool any_indirect( const RfArrivalLanes* arrival, bool found, int first, int end )
{
    for ( int i = first; i < end; ++i )
    {
        float sum = arrival->b[0][i] + arrival->b[1][i] + arrival->b[2][i];
        if ( sum + ( found ? arrival->a[0][i] + arrival->a[1][i] + arrival->a[2][i] : 0.0f ) > 0.0f )
            return true;
    }
    return false;
}

static void evaluate_glossy( const RfHitBatch* batch, const RfVertexLanes* v, Direction* by, RfLaneScratch* s )
{
    int first = first_glossy( batch );
    const float *wo[3] = { batch->wo[0], batch->wo[1], batch->wo[2] },
                *wi[3] = { by->wi[0] + first, by->wi[1] + first, by->wi[2] + first };
    float* f[3] = { s->f[0] + first, s->f[1] + first, s->f[2] + first };
    if ( !by->has_glossy )
        rf_evaluate_glossy( batch, wo, wi, f, s->pdf + first );
    if ( !by->has_glossy && v->guide != NULL )
        rf_mix_guide( v->guide, batch->count - first, v->table + first, wi, s->pdf + first );
    by->has_glossy = true;
}

// Moves light of a direction of glossy hits that the clamp removes to the removed layer. The bound is on what their own camera alone
// would have drawn.
static void clamp_glossy( const RfArrivalLanes* arrival, Direction* by, int part, const float* mixture, RfHitBatch* batch,
                          RfHarvestScratch* scratch )
{
    int first = first_glossy( batch );
    RfLayerLight* removed = rf_removed_light( batch, part );
    if ( by->sampled || !any_indirect( arrival, by->found, first, batch->count ) )
        return;
    RfLaneScratch* s = &scratch->wavefront.scratch;
    const RfWeightedLanes *kept = rf_weighted( rf_layer_light( batch, part, RF_KIND_INDIRECT ), by->number ),
                          *taken = rf_weighted( removed, by->number );
    bool any = false;
    evaluate_glossy( batch, scratch->hits, by, s );
    for ( int i = first; i < batch->count; ++i )
    {
        const float one[3] = { 1.0f, 1.0f, 1.0f };
        Value q = find_value( arrival, by, i, mixture[i - first], one );
        Value value = find_value( arrival, by, i, s->pdf[i], ( float[3] ){ s->f[0][i], s->f[1][i], s->f[2][i] } );
        float share = rf_clamp_share( scratch->clamp, RF_CLAMP_PATHS, batch, i, value.indirect );
        bool together = !batch->layers.by_kind || kind_of_direct( scratch, by, i ) != RF_KIND_DIRECT;
        for ( int c = 0; c < 3; ++c )
        {
            float left = share * q.indirect[c];
            kept->q[c][i - first] = ( together ? q.direct[c] : 0.0f ) + left;
            taken->q[c][i - first] = q.indirect[c] - left;
        }
        any |= share < 1.0f;
    }
    rf_weighted( removed, by->number )->dark = !any;
    removed->dark = removed->dark && !any;
}

// ---- All parts of the light by one direction

// Whether light arrives; by pairings of tiles at glossy hits alone.
static bool is_lit( const RfHitBatch* batch, int pairing, const RfArrivalLanes* arrival )
{
    return rf_any_arrives( arrival, pairing > 0 ? first_glossy( batch ) : 0, batch->count );
}

static void evaluate_diffuse( const RfHarvestScratch* scratch, Direction* by, RfLaneScratch* s )
{
    const RfVertexLanes* v = scratch->hits;
    const float *wo[3] = { v->wo[0], v->wo[1], v->wo[2] }, *wi[3] = { by->wi[0], by->wi[1], by->wi[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    if ( !by->has_diffuse )
        rf_evaluate_seen_from( v, RF_BSDF_LAMBERT, wo, wi, f, s->pdf );
    by->has_diffuse = true;
}

static void weight_part( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, Direction* by, int part )
{
    RfArrivalLanes *arrival = &scratch->arrival, *own = may_bring_own( harvest, by, part ) ? &scratch->own->arrival : NULL;
    RfLaneScratch* s = &scratch->wavefront.scratch;
    bool glossy = first_glossy( batch ) < batch->count;
    gather_direction( harvest, scratch, by, part, arrival, own );
    if ( is_lit( batch, by->pairing, arrival ) )
    {
        const float* mixture = scratch->mixture + (size_t)by->number * RF_LANES;
        if ( by->pairing <= 0 )
        {
            evaluate_diffuse( scratch, by, s );
            add_diffuse( arrival, by, part, batch, scratch );
        }
        if ( glossy && batch->layers.by_kind )
            store_by_kind( arrival, by, part, mixture, scratch, batch );
        else if ( glossy )
            store( arrival, by, part, mixture, batch );
        if ( glossy && scratch->clamp != NULL )
            clamp_glossy( arrival, by, part, mixture, batch, scratch );
    }
    if ( own == NULL || !is_lit( batch, by->pairing, own ) )
        return;
    int base = rf_counts_in( &harvest->path, part );
    if ( by->pairing <= 0 )
    {
        evaluate_diffuse( scratch, by, s );
        add_own( own, by, base, 0, first_glossy( batch ), batch, scratch );
    }
    if ( !glossy || !rf_any_arrives( own, first_glossy( batch ), batch->count ) )
        return;
    evaluate_glossy( batch, scratch->hits, by, s );
    add_own( own, by, base, first_glossy( batch ), batch->count, batch, scratch );
}

static void weight_direction( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, int number )
{
    if ( !is_taken( harvest, number ) )
        return;
    Direction by = find_direction( harvest, scratch, number );
    int first = first_glossy( batch );
    for ( int c = 0; c < 3 && first < batch->count; ++c )
        memcpy( batch->directions[number].wi[c], by.wi[c] + first, (size_t)( batch->count - first ) * sizeof( float ) );
    for ( int part = 0; part < batch->part_count; ++part )
    {
        if ( may_bring( harvest, &by, part ) )
            weight_part( harvest, batch, scratch, &by, part );
    }
}

// ---- Tiles at diffuse hits

// Adds light times the albedo of diffuse hits, that of each path clamped.
static void add_tile_light( const RfHarvestScratch* scratch, float ( *const light )[RF_LANES], RfHitBatch* batch, float* to,
                            RfLayerLight* layer, float* removed )
{
    const RfVertexLanes* v = scratch->hits;
    for ( int i = 0; i < first_glossy( batch ); ++i )
    {
        Value value = { .direct = { 0 } };
        for ( int c = 0; c < 3; ++c )
            value.indirect[c] = v->param[RF_PARAM_DIFFUSE + c][i] * light[c][i];
        if ( removed == NULL || value.indirect[0] + value.indirect[1] + value.indirect[2] > 0.0f )
            add_value( scratch, batch, i, &value, to + 4 * i, to + 4 * i, layer,
                       removed != NULL ? removed + 4 * (size_t)i : NULL );
    }
}

// The light of a part by all neighbour paths at once: for diffuse hits their directions do not matter. The clamp looks at each path.
static void add_diffuse_tile_light( const RfHarvest* harvest, int part, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    float( *sum )[RF_LANES] = scratch->arrival.b;
    const RfChainSamples* samples = scratch->chain_samples;
    RfChainSampling sampling = rf_chain_sampling( harvest, true );
    float worth = rf_balance_weight( sampling.worth, (float)sampling.count ); // of diffuse hits, for any direction
    const bool* taken = samples != NULL ? samples->taken : NULL;
    int pixels = harvest->shape->tile_pixels, base = rf_counts_in( &harvest->path, part );
    bool clamps = scratch->clamp != NULL, clamps_own = rf_clamps_own( scratch );
    RfLayerLight* removed = clamps ? rf_removed_light( batch, part ) : NULL;
    RfLayerLight* own_removed = clamps_own ? rf_removed_light( batch, base ) : NULL;
    for ( int s = 1; s < ( clamps ? pixels : 2 ); ++s )
    {
        rf_gather_diffuse_tile_light( scratch->tiles, part, s, clamps ? s + 1 : pixels, false, taken, worth, sum );
        add_tile_light( scratch, sum, batch, rf_layer_light( batch, part, RF_KIND_INDIRECT )->radiance, removed,
                        clamps ? removed->radiance : NULL );
    }
    for ( int s = 1; s < ( clamps_own ? pixels : 2 ) && harvest->path.own != NULL; ++s )
    {
        rf_gather_diffuse_tile_light( scratch->tiles, part, s, clamps_own ? s + 1 : pixels, true, taken, worth, sum );
        scale_for_frame( harvest, part, 0, first_glossy( batch ), sum );
        add_tile_light( scratch, sum, batch, rf_own_at( scratch, base, RF_KIND_INDIRECT, 0 ), own_removed,
                        clamps_own ? rf_own_removed_at( scratch, base, 0 ) : NULL );
    }
}

// ---- Densities

// P += r_l p_l(wi; x) of the glossy hits for one camera and direction, r_l = J_l V_l / Σ J V.
static void add_density( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch, int eye, int direction )
{
    int first = first_glossy( batch ), count = batch->count - first;
    Direction by = find_direction( harvest, scratch, direction );
    const float *wo[3] = { scratch->wo[0], scratch->wo[1], scratch->wo[2] },
                *wi[3] = { by.wi[0] + first, by.wi[1] + first, by.wi[2] + first };
    float* restrict pdf = scratch->wavefront.scratch.pdf;
    float* restrict mixture = scratch->mixture + (size_t)direction * RF_LANES;
    rf_evaluate_glossy( batch, wo, wi, NULL, scratch->wavefront.scratch.pdf );
    const float* restrict sum = batch->density_sum + first;
    const float* restrict density = scratch->density + (size_t)eye * RF_LANES + first;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        mixture[i] += rf_mixture_share( density[i], sum[i] ) * pdf[i];
}

// P becomes (1 − c) P + c g: the guide is the same for all cameras.
static void mix_guide( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch, int direction )
{
    int first = first_glossy( batch );
    const RfVertexLanes* v = scratch->hits;
    Direction by = find_direction( harvest, scratch, direction );
    const float* wi[3] = { by.wi[0] + first, by.wi[1] + first, by.wi[2] + first };
    rf_mix_guide( v->guide, batch->count - first, v->table + first, wi, scratch->mixture + (size_t)direction * RF_LANES );
}

// P of all directions.
static void mix_densities( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch )
{
    int directions = rf_first_pairing( harvest->shape ) + harvest->shape->tile_pixels; // connections do not depend on densities
    float* wo[3] = { scratch->wo[0], scratch->wo[1], scratch->wo[2] };
    for ( int d = 0; d < directions; ++d )
        memset( scratch->mixture + (size_t)d * RF_LANES, 0, (size_t)rf_glossy_count( batch ) * sizeof( float ) );
    for ( int l = 0; l < harvest->shape->eyes; ++l )
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
    for ( int d = 0; d < directions && scratch->hits->guide != NULL; ++d )
    {
        if ( is_taken( harvest, d ) )
            mix_guide( harvest, batch, scratch, d );
    }
}

// ---- The steps

// The light of connections, which no other technique finds: it needs no weight.
static void add_connections( const RfHarvest* harvest, RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    const RfConnectionLanes* connections = scratch->connections;
    int first = first_glossy( batch ), last = rf_direction_count( harvest->shape ) - 1;
    size_t bytes = (size_t)( batch->count - first ) * sizeof( float );
    RfLayerLight* light = rf_layer_light( batch, 0, RF_KIND_INDIRECT );
    if ( harvest->light_paths == NULL )
        return;
    for ( int i = 0; i < first; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            light->radiance[4 * i + c] += v->param[RF_PARAM_DIFFUSE + c][i] * RF_INV_PI * connections->light[c][i];
    }
    if ( bytes == 0 )
        return;
    RfWeightedLanes* out = rf_weighted( light, last );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( batch->directions[last].wi[c], connections->wi[c] + first, bytes );
        memcpy( out->q[c], connections->one[c] + first, bytes );
    }
    out->dark = false;
}

// Multiplies hit i by the throughput of its chain.
static void dim_hit( int i, const float left[3], RfHitBatch* batch )
{
    int glossy = i - first_glossy( batch );
    for ( int layer = 0; layer < rf_layer_count( &batch->layers ); ++layer )
    {
        RfLayerLight* light = batch->light + layer;
        for ( int c = 0; c < 3 && light->radiance != NULL; ++c )
            light->radiance[4 * i + c] *= left[c];
        for ( int d = light->first_direction; d < light->end_direction && glossy >= 0; ++d )
        {
            for ( int c = 0; c < 3 && !rf_weighted( light, d )->dark; ++c )
                rf_weighted( light, d )->q[c][glossy] *= left[c];
        }
    }
}

static void dim_chains( RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        const float left[3] = { scratch->chains->throughput[0][slot], scratch->chains->throughput[1][slot],
                                scratch->chains->throughput[2][slot] };
        if ( batch->view[i] == RF_VIEW_CHAIN )
            dim_hit( i, left, batch );
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
        part = harvest->path.parts ? part : 0;
        float* to = own ? rf_own_at( scratch, part, RF_KIND_EMISSION, i )
                        : rf_layer_light( batch, part, RF_KIND_EMISSION )->radiance + 4 * (size_t)i;
        for ( int c = 0; c < 3; ++c )
            to[c] += v->emission[c][i];
    }
}

static void begin_layers( const RfHarvest* harvest, RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    static const float s_black[4] = { 0.0f, 0.0f, 0.0f, 1.0f };
    const RfLayerSet* set = &batch->layers;
    int listed = rf_listed( batch );
    batch->part_count = 1 + rf_dimmed_parts( &harvest->path );
    for ( int layer = 0; layer < rf_layer_count( set ); ++layer )
    {
        RfLayerLight* light = batch->light + layer;
        bool base = layer < rf_kinds( set ) * set->base_parts ||
                    ( layer >= rf_removed_layer( set, 0 ) && layer < rf_removed_layer( set, set->base_parts ) );
        light->dark = layer >= rf_removed_layer( set, 0 );
        rf_find_layer_directions( harvest->shape, set, layer, &light->first_direction, &light->end_direction );
        if ( light->radiance != NULL && layer > 0 )
            memset( light->radiance, 0, 4 * (size_t)( base ? listed : batch->count ) * sizeof( float ) );
        for ( int d = light->first_direction; d < light->end_direction; ++d )
            rf_weighted( light, d )->dark = true;
    }
    for ( int i = 0; i < batch->count + batch->miss_count; ++i )
        memcpy( batch->light->radiance + 4 * i, s_black, sizeof s_black );
    memset( batch->light->radiance + 4 * ( listed - batch->glint_count ), 0, 4 * (size_t)batch->glint_count * sizeof( float ) );
    for ( int i = 0; i < batch->count && batch->event != NULL; ++i )
        batch->event[i] = rf_follows_chains( scratch ) ? scratch->chains->event[scratch->hits->slot[i]] : (uint8_t)RF_EVENT_NONE;
    for ( int i = batch->first[RF_BSDF_FROSTED]; i < batch->first[RF_BSDF_FROSTED + 1] && batch->event != NULL; ++i )
        batch->event[i] = rf_drawn_side( scratch->hits, i ) < 0.0f ? RF_EVENT_TRANSMISSION : RF_EVENT_REFLECTION;
}

// ---- The clamp

static void begin_clamp( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch )
{
    RfClampHits* clamp = scratch->clamp;
    for ( int kind = 0; kind < RF_CLAMP_KINDS; ++kind )
        clamp->threshold[kind] = harvest->group->clamp != NULL ? harvest->group->clamp[batch->eye].threshold[kind] : INFINITY;
    clamp->watch = harvest->group->clamp_watch;
    bool chains = rf_follows_chains( scratch );
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        clamp->dimmed[i] = 1.0f;
        if ( chains && batch->view[i] == RF_VIEW_CHAIN )
            clamp->dimmed[i] = rf_luminance( RF_GET3( scratch->chains->throughput, slot ) );
    }
}

// Clamps emission of hits at the end of chains that no other camera can follow.
static void clamp_seen_emission( RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    for ( int i = 0; i < batch->part_count * batch->count; ++i )
    {
        int part = i / batch->count, hit = i % batch->count;
        RfLayerLight* removed = rf_removed_light( batch, part );
        float* radiance = rf_layer_light( batch, part, RF_KIND_EMISSION )->radiance + 4 * (size_t)hit;
        float value[3] = { radiance[0], radiance[1], radiance[2] };
        if ( batch->view[hit] != RF_VIEW_CHAIN || !( value[0] + value[1] + value[2] > 0.0f ) )
            continue;
        memset( radiance, 0, sizeof value );
        if ( rf_add_clamped( scratch->clamp, RF_CLAMP_CHAINS, batch, hit, value, radiance, removed->radiance + 4 * (size_t)hit ) )
            removed->dark = false;
    }
}

void rf_weight_batch( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    bool glossy = first_glossy( batch ) < batch->count;
    begin_layers( harvest, batch, scratch );
    if ( scratch->clamp != NULL )
        begin_clamp( harvest, batch, scratch );
    add_emission( harvest, batch, scratch );
    if ( scratch->clamp != NULL && rf_follows_chains( scratch ) )
        clamp_seen_emission( batch, scratch );
    if ( harvest->path.max_depth == 1 )
        return;
    if ( glossy )
        mix_densities( harvest, batch, scratch );
    for ( int part = 0; part < batch->part_count && rf_reuses_tiles( scratch ); ++part )
        add_diffuse_tile_light( harvest, part, scratch, batch );
    int directions = rf_first_pairing( harvest->shape ) + ( glossy ? harvest->shape->tile_pixels : 1 );
    for ( int d = 0; d < directions; ++d )
        weight_direction( harvest, batch, scratch, d );
    if ( harvest->shape->connections )
        add_connections( harvest, batch, scratch );
    if ( rf_follows_chains( scratch ) )
        dim_chains( batch, scratch );
}
