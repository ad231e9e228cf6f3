// Own-frame samples: hits of specular materials, and the sky in the background.
// They are stored with the misses, which have weight 1 in their own frame and 0
// elsewhere (src/reuse/estimators.md, section 2), but are not black.
#include "reuse/harvest/own_frame.h"

#include <string.h>

// The light of a miss, of a base part. What specular hits bring is of the kind of emission where chains are not followed.
static inline float* light_of( const RfHitBatch* batch, int base, int miss )
{
    return rf_layer_light( batch, base, RF_KIND_EMISSION )->radiance + 4 * (size_t)( batch->count + miss );
}

static inline float* removed_of( const RfHitBatch* batch, int base, int miss )
{
    return rf_removed_light( batch, base )->radiance + 4 * (size_t)( batch->count + miss );
}

static inline void put_light( float* light, RfVec3 seen )
{
    light[0] = seen.x;
    light[1] = seen.y;
    light[2] = seen.z;
}

// The sky where camera rays missed.
static void light_misses( const RfHarvest* harvest, const RfHarvestScratch* scratch, const RfHitBatch* batch, int count )
{
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    bool seen = rf_has_sky( lights ) && !lights->sky.environment->hidden && !harvest->plan->alpha;
    int base = seen ? rf_counts_in( &harvest->path, rf_light_part( lights, rf_sky_number( lights ) ) ) : 0;
    const RfRayLanes* rays = &scratch->camera_rays;
    for ( int k = 0; k < count && seen; ++k )
        put_light( light_of( batch, base, k ), rf_sky_in_frame( &harvest->path, RF_GET3( rays->d, scratch->miss_slot[k] ) ) );
}

// Adds light sampling at the specular hits; their delta lobes do not contribute.
static void add_light_samples( const RfHarvest* harvest, RfHarvestScratch* scratch, const RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    RfLaneScratch* s = &scratch->wavefront.scratch;
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    float k = (float)harvest->shape->light_samples;
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    for ( int j = 0; j < harvest->shape->light_samples; ++j )
    {
        const RfLightLanes* direct = scratch->direct + j;
        const float* wi[3] = { direct->wi[0], direct->wi[1], direct->wi[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = rf_record_count( v ); i < v->count; ++i )
        {
            int part = harvest->path.parts ? direct->part[i] : 0;
            float* light = light_of( batch, rf_counts_in( &harvest->path, part ), first_miss + i - rf_record_count( v ) );
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

// Adds what a path has found for a miss, clamped; what is removed goes to the removed layer.
static void add_clamped( const RfHarvestScratch* scratch, RfClampKind kind, const float value[3], int base, int miss,
                         float* light, RfHitBatch* batch )
{
    if ( rf_add_clamped( scratch->clamp, kind, batch, batch->count + miss, value, light, removed_of( batch, base, miss ) ) )
        rf_removed_light( batch, base )->dark = false;
}

// Caustics at specular hits: all of them longer paths.
static void take_out_caustics( const RfHarvestScratch* scratch, const RfArrivals* arrivals, int base, RfHitBatch* batch,
                               int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float* removed = removed_of( batch, base, first_miss + i - rf_record_count( v ) );
        for ( int c = 0; c < 3; ++c )
            removed[c] += arrivals->rest[c][v->slot[i]];
        rf_removed_light( batch, base )->dark = false;
    }
}

static void add_scattered( const RfHarvest* harvest, const RfHarvestScratch* scratch, const RfArrivals* arrivals, int base,
                           RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    float k = (float)harvest->shape->light_samples;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        int slot = v->slot[i], n = i - rf_record_count( v );
        float *light = light_of( batch, base, first_miss + n ), rest[3];
        float pdf = scratch->specular_pdf[n];
        float weight = pdf > 0.0f ? rf_balance_weight( pdf, k * arrivals->light_pdf_solid_angle[slot] ) : 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            rest[c] = arrivals->rest[c][slot];
            light[c] += arrivals->emitted[c][slot] * weight + ( scratch->clamp != NULL ? 0.0f : rest[c] );
        }
        if ( scratch->clamp != NULL )
            add_clamped( scratch, RF_CLAMP_PATHS, rest, base, first_miss + n, light, batch );
    }
}

// Absorption along the camera rays, for a camera inside a body.
static void absorb( const RfHarvestScratch* scratch, int base, const RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    const RfRayLanes* rays = &scratch->camera_rays;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        int slot = v->slot[i], miss = first_miss + i - rf_record_count( v );
        float* light = light_of( batch, base, miss );
        RfVec3 transmittance = rf_transmittance_from( v, i, RF_GET3( rays->o, slot ) );
        float left[3] = { transmittance.x, transmittance.y, transmittance.z };
        for ( int c = 0; c < 3; ++c )
        {
            light[c] *= left[c];
            if ( batch->layers.removed )
                removed_of( batch, base, miss )[c] *= left[c];
        }
    }
}

// Light that chains find on their way, of a base part, for a miss or glint: what their first vertices emit, and beyond these, by
// their first event, what is left of it by the clamp.
static void light_chain( const RfHarvestScratch* scratch, int base, int slot, int miss, RfHitBatch* batch )
{
    static const RfLayerKind s_kinds[] = { [RF_EVENT_NONE] = RF_KIND_EMISSION,
                                           [RF_EVENT_REFLECTION] = RF_KIND_REFLECTION,
                                           [RF_EVENT_TRANSMISSION] = RF_KIND_TRANSMISSION };
    const RfChains* chains = scratch->chains;
    float found[3] = { 0.0f, 0.0f, 0.0f }, share = 1.0f;
    for ( int event = 0; event < chains->events; ++event )
    {
        const RfChainFinds* of = rf_chain_finds( chains, base, event );
        for ( int c = 0; c < 3 && chains->clamped; ++c )
            found[c] += of->found[c][slot];
    }
    if ( found[0] + found[1] + found[2] > 0.0f )
        share = rf_clamp_share( scratch->clamp, RF_CLAMP_CHAINS, batch, batch->count + miss, found );
    for ( int event = 0; event < chains->events; ++event )
    {
        const RfChainFinds* of = rf_chain_finds( chains, base, event );
        float* light = rf_layer_light( batch, base, s_kinds[event] )->radiance + 4 * (size_t)( batch->count + miss );
        for ( int c = 0; c < 3; ++c )
        {
            float kept = chains->clamped ? share * of->found[c][slot] : 0.0f;
            light[c] = of->light[c][slot] + kept;
            if ( chains->clamped )
                removed_of( batch, base, miss )[c] += of->found[c][slot] - kept;
        }
    }
    if ( share < 1.0f )
        rf_removed_light( batch, base )->dark = false;
}

static void light_chains( const RfHarvestScratch* scratch, int base, RfHitBatch* batch )
{
    for ( int k = scratch->ray_miss_count; k < batch->miss_count; ++k )
        light_chain( scratch, base, scratch->miss_slot[k], k, batch );
    for ( int g = 0; g < batch->glint_count; ++g )
        light_chain( scratch, base, scratch->glint_slot[g], batch->miss_count + g, batch );
}

// What paths from specular hits bring, of a base part.
static void light_specular( const RfHarvest* harvest, int base, RfHitBatch* batch, RfHarvestScratch* scratch, int first_miss )
{
    if ( harvest->path.max_depth > 1 )
    {
        add_scattered( harvest, scratch, rf_arrivals_of_part( &scratch->wavefront, base ), base, batch, first_miss );
        if ( harvest->path.own != NULL && harvest->path.own->caustics )
            take_out_caustics( scratch, rf_own_arrivals( harvest->path.own, base ), base, batch, first_miss );
        else if ( harvest->path.own != NULL )
            add_scattered( harvest, scratch, rf_own_arrivals( harvest->path.own, base ), base, batch, first_miss );
    }
    absorb( scratch, base, batch, first_miss );
}

static void see_specular( const RfHarvest* harvest, const RfHarvestScratch* scratch, const RfHitBatch* batch, int first_miss )
{
    const RfVertexLanes* v = &scratch->first;
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        int base = rf_counts_in( &harvest->path, rf_material_part( lights, v->material[i] ) );
        put_light( light_of( batch, base, first_miss + i - rf_record_count( v ) ), rf_emission_in_frame( &harvest->path, v, i ) );
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
        if ( chains )
            light_chains( scratch, base, batch );
        else if ( specular > 0 )
            light_specular( harvest, base, batch, scratch, first_miss );
    }
}

// ---- Light at hits that is kept apart, weighted as in a group of one frame and added to the hit's own pixel as a glint: what holds
// in the frame of its path alone, since what moves touches the path in some frame of the group (src/reuse/estimators.md, section 18),
// or caustics, which go to the removed light (section 19)

void rf_note_moving_hits( const RfTracer* tracer, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->own->moving, 0, sizeof scratch->own->moving );
    for ( int i = 0; i < rf_record_count( v ) && rf_tracer_has_swept( tracer ); ++i )
        scratch->own->moving[v->slot[i]] = rf_is_moving( tracer, scratch->wavefront.scratch.triangle[v->ray[i]] );
}

// Filters of the ways to the hits' own camera, as accumulation has them for what is shared, and the throughput of chains.
static void find_filters( const RfHarvest* harvest, const RfHitBatch* batch, const RfHarvestScratch* scratch,
                          float ( *filter )[RF_LANES] )
{
    RF_ALIGN float density[RF_LANES];
    RfProjectedLanes out = { .density = density, .filter = { filter[0], filter[1], filter[2] } };
    rf_own_densities( rf_tracer_mirrors( harvest->path.tracer ), harvest->eyes + batch->eye, batch, out );
    for ( int c = 0; c < 3; ++c )
    {
        const float* kappa = batch->panes[c] != NULL ? batch->panes[c] + (size_t)batch->eye * RF_LANES : NULL;
        for ( int i = 0; i < batch->count; ++i )
        {
            bool chain = batch->view[i] == RF_VIEW_CHAIN;
            float left = chain ? scratch->chains->throughput[c][scratch->hits->slot[i]] : filter[c][i];
            filter[c][i] = left * ( kappa != NULL ? kappa[i] : 1.0f );
        }
    }
}

// A new glint for a hit, without light. Returns its number among all that is listed.
static int append_glint( const RfHarvestScratch* scratch, int hit, RfHitBatch* batch )
{
    int slot = scratch->hits->slot[hit], at = rf_listed( batch ), base_parts = batch->layers.base_parts;
    batch->pixel[at] = scratch->pixel[slot];
    batch->glint_count += 1;
    for ( int layer = 0; layer < base_parts * rf_kinds( &batch->layers ); ++layer )
        memset( batch->light[layer].radiance + 4 * (size_t)at, 0, 4 * sizeof( float ) );
    for ( int base = 0; base < base_parts && batch->layers.removed; ++base )
        memset( rf_removed_light( batch, base )->radiance + 4 * (size_t)at, 0, 4 * sizeof( float ) );
    for ( int c = 0; c < 2 && batch->offset[0] != NULL; ++c )
        batch->offset[c][at] = scratch->place[c][slot];
    return at;
}

// The glints of hits.
typedef struct Glints
{
    int32_t of[RF_LANES]; // by slot: number among all that is listed, or −1
    bool filtered;
    RF_ALIGN float filter[3][RF_LANES];
} Glints;

// Adds the light of a hit to that of its glint.
static void add_glint( const float* light, int hit, const RfHarvestScratch* scratch, RfHitBatch* batch, Glints* glints,
                       RfLayerLight* to )
{
    int32_t* glint = glints->of + scratch->hits->slot[hit];
    if ( !( light[0] + light[1] + light[2] > 0.0f ) )
        return;
    *glint = *glint >= 0 ? *glint : append_glint( scratch, hit, batch );
    for ( int c = 0; c < 3; ++c )
        to->radiance[4 * *glint + c] += light[c] * ( glints->filtered ? glints->filter[c][hit] : 1.0f );
    to->dark = false;
}

// The kind that light of a hit has in its picture.
static RfLayerKind kind_seen( const RfHitBatch* batch, int hit, int kind )
{
    static const RfLayerKind s_events[] = {
        [RF_EVENT_REFLECTION] = RF_KIND_REFLECTION, [RF_EVENT_TRANSMISSION] = RF_KIND_TRANSMISSION
    };
    bool by_event = batch->event != NULL && batch->event[hit] != RF_EVENT_NONE;
    return by_event ? s_events[batch->event[hit]] : (RfLayerKind)kind;
}

void rf_add_own_light( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    const RfOwnHits* own = scratch->own;
    Glints glints = { .filtered = rf_has_views( batch ) };
    int kinds = rf_hit_kinds( &batch->layers );
    memset( glints.of, -1, sizeof glints.of );
    for ( int g = 0; g < batch->glint_count; ++g )
        glints.of[scratch->glint_slot[g]] = batch->count + batch->miss_count + g;
    if ( glints.filtered )
        find_filters( harvest, batch, scratch, glints.filter );
    for ( int base = 0; base < rf_base_parts( &harvest->path ); ++base )
    {
        for ( int i = 0; i < kinds * batch->count && !own->paths.caustics; ++i )
        {
            int hit = i % batch->count, kind = i / batch->count;
            add_glint( rf_own_at( scratch, base, (RfLayerKind)kind, hit ), hit, scratch, batch, &glints,
                       rf_layer_light( batch, base, kind_seen( batch, hit, kind ) ) );
        }
        for ( int hit = 0; hit < batch->count && own->removed != NULL; ++hit )
            add_glint( rf_own_removed_at( scratch, base, hit ), hit, scratch, batch, &glints, rf_removed_light( batch, base ) );
    }
}

static float sample_luminance( const RfLightLanes* direct, int i )
{
    RfVec3 light = RF_GET3( direct->radiance_cos, i );
    return direct->pdf_solid_angle[i] > 0.0f ? rf_luminance( light ) / direct->pdf_solid_angle[i] : 0.0f;
}

// The light samples that bring light, and as much the scattered ray, if it reached anything.
static float part_of_hit( const RfHarvest* harvest, const RfHarvestScratch* scratch, bool reached, int i )
{
    float own = 0.0f, all = 0.0f, scattered = (float)scratch->own->paths.touched[scratch->hits->slot[i]];
    for ( int j = 0; j < harvest->shape->light_samples; ++j )
    {
        float light = sample_luminance( scratch->direct + j, i );
        all += light;
        own += scratch->direct[j].touched[i] ? light : 0.0f;
    }
    if ( all == 0.0f )
        return scattered;
    return reached ? 0.5f * ( own / all + scattered ) : own / all;
}

void rf_find_own_parts( const RfHarvest* harvest, const uint32_t* triangle, RfHarvestScratch* scratch )
{
    const RfVertexLanes* second = &scratch->wavefront.vertices;
    const RfTracer* tracer = harvest->path.tracer;
    bool reached[RF_LANES];
    rf_touch_by_rays( tracer, &scratch->wavefront.rays, second, triangle, scratch->own->paths.touched );
    memset( reached, rf_has_sky( rf_tracer_lights( tracer ) ), sizeof reached );
    for ( int i = 0; i < second->count; ++i )
        reached[second->slot[i]] = true;
    for ( int i = 0; i < rf_record_count( scratch->hits ); ++i )
        scratch->own->part[i] = part_of_hit( harvest, scratch, reached[scratch->hits->slot[i]], i );
}
