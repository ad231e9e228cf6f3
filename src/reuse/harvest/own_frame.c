// Own-frame samples: hits of specular materials, and the sky in the background.
// They are stored with the misses, which have weight 1 in their own frame and 0
// elsewhere (src/reuse/estimators.md, section 2), but are not black.
#include "reuse/harvest/passes.h"

static inline float* light_of( const RfHitBatch* batch, int miss ) { return rf_miss_radiance( batch ) + 4 * (size_t)miss; }

// The light of a base part.
static inline float* light_of_part( const RfHitBatch* batch, int base, int miss )
{
    return base == 0 ? light_of( batch, miss ) : batch->dimmed[base - 1].radiance + 4 * (size_t)( batch->count + miss );
}

// A sample without a hit, with what it sees: light of one base part.
static inline void put_light( const RfHitBatch* batch, int base, int miss, RfVec3 seen )
{
    float *all = light_of( batch, miss ), *light = light_of_part( batch, base, miss );
    all[0] = all[1] = all[2] = 0.0f;
    all[3] = 1.0f;
    light[0] = seen.x;
    light[1] = seen.y;
    light[2] = seen.z;
}

// The sky where camera rays missed.
static void light_misses( const RfHarvest* harvest, const RfHarvestScratch* scratch, const RfHitBatch* batch, int count )
{
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    bool seen = rf_has_sky( lights ) && !lights->sky.environment->hidden && !harvest->alpha;
    int base = seen ? rf_counts_in( &harvest->path, rf_light_part( lights, rf_sky_number( lights ) ) ) : 0;
    const RfRayLanes* rays = &scratch->camera_rays;
    for ( int k = 0; k < count; ++k )
    {
        RfVec3 sky = rf_vec3( 0, 0, 0 );
        if ( seen )
        {
            int slot = scratch->miss_slot[k];
            sky = rf_sky_in_frame( &harvest->path, RF_GET3( rays->d, slot ) );
        }
        put_light( batch, base, k, sky );
    }
}

// Adds light sampling at the specular hits; their delta lobes do not contribute.
static void add_light_samples( const RfHarvest* harvest, RfHarvestScratch* scratch, const RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    RfLaneScratch* s = &scratch->wavefront.scratch;
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    float k = (float)harvest->shape.light_samples;
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    for ( int j = 0; j < harvest->shape.light_samples; ++j )
    {
        const RfLightLanes* direct = scratch->direct + j;
        const float* wi[3] = { direct->wi[0], direct->wi[1], direct->wi[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = rf_record_count( v ); i < v->count; ++i )
        {
            int part = harvest->path.parts ? direct->part[i] : 0;
            float* light = light_of_part( batch, rf_counts_in( &harvest->path, part ), first_miss + i - rf_record_count( v ) );
            float scale = rf_balance_scale( k * direct->pdf_solid_angle[i], s->pdf[i] );
            RfVec3 of_part = rf_part_scale( lights, part );
            const float of_frame[3] = { of_part.x, of_part.y, of_part.z };
            for ( int c = 0; c < 3; ++c )
                light[c] += s->f[c][i] * ( direct->radiance_cos[c][i] * of_frame[c] * scale );
        }
    }
}

// What paths from specular hits have found of dimmed lamps, as it is in their frame, goes to the base parts.
static void gather_dimmed( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = &scratch->first;
    for ( int part = rf_base_parts( &harvest->path ); part <= rf_dimmed_parts( &harvest->path ); ++part )
    {
        RfArrivals* to = rf_arrivals_of_part( &scratch->wavefront, rf_counts_in( &harvest->path, part ) );
        const RfArrivals* from = scratch->dimmed + part - 1;
        RfVec3 scale = rf_part_scale( rf_tracer_lights( harvest->path.tracer ), part );
        const float of_frame[3] = { scale.x, scale.y, scale.z };
        if ( !( rf_max_component( scale ) > 0.0f ) ) // of other frames, too
            continue;
        for ( int i = rf_record_count( v ); i < v->count; ++i )
        {
            int slot = v->slot[i];
            bool emitted = from->emitted[0][slot] + from->emitted[1][slot] + from->emitted[2][slot] > 0.0f;
            for ( int c = 0; c < 3; ++c )
            {
                to->rest[c][slot] += from->rest[c][slot] * of_frame[c];
                to->emitted[c][slot] += from->emitted[c][slot] * of_frame[c];
            }
            if ( emitted ) // by one part only: that of what the ray has hit
                to->light_pdf_solid_angle[slot] = from->light_pdf_solid_angle[slot];
        }
    }
}

static void add_clamped_scattered( const RfHarvestScratch* scratch, const RfArrivals* arrivals, int slot, float weight,
                                   RfHitBatch* batch, int miss )
{
    float *light = light_of( batch, miss ), rest[3];
    for ( int c = 0; c < 3; ++c )
    {
        light[c] += arrivals->emitted[c][slot] * weight;
        rest[c] = arrivals->rest[c][slot];
    }
    float* removed = batch->removed + 4 * (size_t)( batch->count + miss );
    batch->any_removed |= rf_add_clamped( scratch->clamp, RF_CLAMP_PATHS, batch, batch->count + miss, rest, light, removed );
}

// Caustics at specular hits: all of them longer paths.
static void take_out_caustics( const RfHarvestScratch* scratch, const RfArrivals* arrivals, RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float* removed = batch->removed + 4 * (size_t)( batch->count + first_miss + i - rf_record_count( v ) );
        for ( int c = 0; c < 3; ++c )
        {
            removed[c] += arrivals->rest[c][v->slot[i]];
            batch->any_removed |= removed[c] > 0.0f;
        }
    }
}

static void add_scattered( const RfHarvest* harvest, const RfHarvestScratch* scratch, const RfArrivals* arrivals,
                           RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    float k = (float)harvest->shape.light_samples;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        int slot = v->slot[i], n = i - rf_record_count( v );
        float* light = light_of( batch, first_miss + n );
        float pdf = scratch->specular_pdf[n];
        float weight = pdf > 0.0f ? rf_balance_weight( pdf, k * arrivals->light_pdf_solid_angle[slot] ) : 0.0f;
        if ( scratch->clamp != NULL )
        {
            add_clamped_scattered( scratch, arrivals, slot, weight, batch, first_miss + n );
            continue;
        }
        for ( int c = 0; c < 3; ++c )
            light[c] += arrivals->emitted[c][slot] * weight + arrivals->rest[c][slot];
    }
}

// Absorption along the camera rays, for a camera inside a body.
static void absorb( const RfHarvestScratch* scratch, const RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    const RfRayLanes* rays = &scratch->camera_rays;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        int slot = v->slot[i];
        float* light = light_of( batch, first_miss + i - rf_record_count( v ) );
        RfVec3 transmittance = rf_transmittance_from( v, i, RF_GET3( rays->o, slot ) );
        float left[3] = { transmittance.x, transmittance.y, transmittance.z };
        float* removed = batch->removed + 4 * (size_t)( batch->count + first_miss + i - rf_record_count( v ) );
        for ( int c = 0; c < 3; ++c )
        {
            light[c] *= left[c];
            if ( batch->removed != NULL )
                removed[c] *= left[c];
        }
    }
}

static void copy_chain_light( float ( *const light )[RF_LANES], const int32_t* slot, int count, float fourth, float* out )
{
    for ( int k = 0; k < count; ++k )
    {
        for ( int c = 0; c < 3; ++c )
            out[4 * k + c] = light[c][slot[k]];
        out[4 * k + 3] = fourth;
    }
}

// What chains find beyond their first vertices, clamped.
static void add_found_light( const RfHarvestScratch* scratch, float ( *const found )[RF_LANES], RfHitBatch* batch, int first,
                             int count, const int32_t* slot )
{
    for ( int k = 0; k < count; ++k )
    {
        size_t at = 4 * (size_t)( first + k );
        float value[3] = { found[0][slot[k]], found[1][slot[k]], found[2][slot[k]] };
        if ( value[0] + value[1] + value[2] > 0.0f )
            batch->any_removed |= rf_add_clamped( scratch->clamp, RF_CLAMP_CHAINS, batch, first + k, value, batch->radiance + at,
                                                  batch->removed + at );
    }
}

// Light that chains find on their way, of a base part, for pixels without a hit and for pixels with one.
static void light_chains( const RfHarvestScratch* scratch, int base, RfHitBatch* batch )
{
    int first = scratch->ray_miss_count;
    float fourth = base == 0 ? 1.0f : 0.0f, ( *light )[RF_LANES] = rf_chain_light( scratch->chains, base );
    copy_chain_light( light, scratch->miss_slot + first, batch->miss_count - first, fourth,
                      rf_miss_radiance( batch ) + 4 * (size_t)first );
    copy_chain_light( light, scratch->glint_slot, batch->glint_count, 0.0f, rf_glint_radiance( batch ) );
    if ( scratch->clamp == NULL )
        return;
    float( *found )[RF_LANES] = rf_chain_found( scratch->chains, base );
    add_found_light( scratch, found, batch, batch->count + first, batch->miss_count - first, scratch->miss_slot + first );
    add_found_light( scratch, found, batch, batch->count + batch->miss_count, batch->glint_count, scratch->glint_slot );
}

// What paths from specular hits bring, of a base part.
static void light_specular( const RfHarvest* harvest, int base, RfHitBatch* batch, RfHarvestScratch* scratch, int first_miss )
{
    if ( harvest->path.max_depth > 1 )
    {
        add_scattered( harvest, scratch, rf_arrivals_of_part( &scratch->wavefront, base ), batch, first_miss );
        if ( harvest->path.own != NULL && harvest->path.own->caustics )
            take_out_caustics( scratch, &harvest->path.own->arrivals, batch, first_miss );
        else if ( harvest->path.own != NULL )
            add_scattered( harvest, scratch, rf_own_arrivals( harvest->path.own, base ), batch, first_miss );
    }
    absorb( scratch, batch, first_miss );
}

static void see_specular( const RfHarvest* harvest, const RfHarvestScratch* scratch, const RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        int part = rf_counts_in( &harvest->path, rf_material_part( lights, v->material[i] ) );
        put_light( batch, part, first_miss + i - rf_record_count( v ), rf_emission_in_frame( &harvest->path, v, i ) );
    }
}

void rf_light_own_frame( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = &scratch->first;
    bool chains = rf_follows_chains( scratch );
    int specular = v->count - rf_record_count( v ), first_miss = batch->miss_count - specular;
    light_misses( harvest, scratch, batch, scratch->ray_miss_count );
    if ( !chains )
        see_specular( harvest, scratch, batch, first_miss );
    if ( !chains && specular > 0 && harvest->path.max_depth > 1 )
    {
        add_light_samples( harvest, scratch, batch, first_miss );
        gather_dimmed( harvest, scratch );
    }
    for ( int base = 0; base < rf_base_parts( &harvest->path ); ++base )
    {
        RfHitBatch of_part = rf_batch_of_part( batch, base, true );
        if ( chains )
            light_chains( scratch, base, &of_part );
        else if ( specular > 0 )
            light_specular( harvest, base, &of_part, scratch, first_miss );
        batch->any_removed = batch->any_removed || of_part.any_removed;
        if ( base > 0 )
            batch->dimmed[base - 1].any_removed = of_part.any_removed;
    }
    if ( chains && batch->passes != NULL )
        rf_pass_chains( harvest, batch, scratch );
}
