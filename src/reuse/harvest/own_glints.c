// Light at hits that is kept apart, weighted as in a group of one frame and added to the hit's own pixel as a glint: what holds in
// the frame of its path alone, since what moves touches the path in some frame of the group (src/reuse/estimators.md, section 18), or
// caustics, which go to the removed light (section 19).
#include "reuse/harvest/own_glints.h"

#include <string.h>

void rf_note_moving_hits( const RfTracer* tracer, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->own->moving, 0, sizeof scratch->own->moving );
    for ( int i = 0; i < rf_record_count( v ) && rf_tracer_has_ghosts( tracer ); ++i )
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
