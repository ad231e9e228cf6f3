// The path tracer proper: scattering, emission that scattered rays hit, and path tails from the second vertex on.
#include "path/wavefront.h"

#include "base/fault.h"
#include "path/guide_learner.h"
#include "path/roulette.h"

#include <string.h>

// Events of the chain by which a path may find light.
static void add_event( RfChainLight* chain_light, const RfVertexLanes* v, int i, const float* const wi[3], float pdf )
{
    int slot = v->slot[i], at = chain_light->length[slot];
    if ( !chain_light->open[slot] || at == RF_MAX_CHAIN_LIGHT || !rf_is_chain_event( v, i, pdf ) )
    {
        chain_light->open[slot] = false;
        return;
    }
    bool transmits = v->n[0][i] * wi[0][i] + v->n[1][i] * wi[1][i] + v->n[2][i] * wi[2][i] < 0.0f;
    chain_light->transmitted[slot] |= (uint16_t)( (unsigned)transmits << at );
    chain_light->length[slot] += 1;
}

static void begin_chain( RfChainLight* chain_light, const RfVertexLanes* v, int i )
{
    int slot = v->slot[i];
    for ( int c = 0; c < 3; ++c )
        chain_light->light[c][slot] = 0.0f;
    chain_light->transmitted[slot] = 0;
    chain_light->length[slot] = 0;
    chain_light->open[slot] = i < rf_record_count( v );
}

// Notes what happened at the path's `vertex`-th vertices, from which it goes on to wi. The first of them begins it.
static void note_chain_events( RfChainLight* chain_light, const RfVertexLanes* v, int vertex, const float* const wi[3],
                               const float* pdf )
{
    for ( int i = 0; i < v->count && chain_light != NULL; ++i )
    {
        if ( vertex == 1 )
            begin_chain( chain_light, v, i );
        else
            add_event( chain_light, v, i, wi, pdf[i] );
    }
}

static void note_caustics( const RfPathSettings* settings, const RfVertexLanes* v, const float* pdf )
{
    if ( settings->own != NULL && settings->own->caustics )
        rf_note_caustics( v, pdf, settings->own );
}

// Light of a part, which what moves may touch, goes to the arrivals that are returned.
static inline RfArrivals* take_part( const RfPathSettings* settings, int slot, int part, const RfReceiver* to, bool* touched,
                                     RfVec3* light )
{
    bool of_frame = rf_is_own_part( part );
    *touched = *touched || ( of_frame && to->own != NULL );
    bool apart = settings->parts && !of_frame && !*touched;
    if ( part != 0 && !apart )
        *light = rf_mul( *light, rf_part_scale( rf_tracer_lights( settings->tracer ), part ) );
    int counts_in = apart ? part : rf_counts_in( settings, part );
    if ( *touched )
        return rf_own_arrivals( to->own, counts_in );
    if ( to->event != NULL )
        counts_in = counts_in * to->events + to->event[slot];
    return counts_in != 0 ? to->dimmed + counts_in - 1 : to->arrivals;
}

static inline void add_arrival( const RfPathSettings* settings, const RfRayLanes* rays, int r, RfVec3 light, int part,
                                float light_pdf, const RfReceiver* to )
{
    int slot = rays->slot[r];
    bool touched = to->own != NULL && to->own->touched[slot];
    // chains have no parts but those of groups
    bool by_chain =
        part >= rf_base_parts( settings ) && to->chain_light != NULL && rf_may_take_chain_light( to->chain_light, slot );
    touched = touched || ( by_chain && to->own != NULL );
    RfArrivals* arrivals = take_part( settings, slot, part, to, &touched, &light );
    float l[3] = { light.x * rays->throughput[0][r], light.y * rays->throughput[1][r], light.z * rays->throughput[2][r] };
    if ( to->chain_light != NULL && rf_take_chain_light( to->chain_light, slot, l ) )
    {
        to->chain_light->touched[slot] = touched;
        if ( settings->grouped && to->chain_light->part != NULL )
            to->chain_light->part[slot] = (uint8_t)rf_counts_in( settings, part );
        return;
    }
    rf_close_chain( to->chain_light, slot, l );
    if ( to->defer_mis )
    {
        for ( int c = 0; c < 3; ++c )
            arrivals->emitted[c][slot] = l[c];
        arrivals->light_pdf_solid_angle[slot] = light_pdf;
        return;
    }
    float pdf = rays->pdf_solid_angle[r];
    float weight = rf_balance_weight( pdf, (float)settings->light_samples * light_pdf );
    for ( int c = 0; c < 3; ++c )
        arrivals->rest[c][slot] += l[c] * weight;
}

// The probability that a light sample at the ray's origin selects this light.
static float selection_probability( const RfPathSettings* settings, const RfRayLanes* rays, int r, uint32_t light )
{
    RfVec3 o = RF_GET3( rays->o, r );
    RfVec3 n = RF_GET3( rays->n, r );
    return rf_light_probability( rf_tracer_lights( settings->tracer ), settings->light_sampling, light, o, n );
}

// Behind panes the ray's density is q times as large. Only the quotient of the two
// densities matters.
static inline float light_pdf_behind( const float* pane_probability, int r, float light_pdf )
{
    return pane_probability != NULL ? light_pdf / pane_probability[r] : light_pdf;
}

static void add_emission( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* v,
                          const uint32_t* triangle, const float* pane_probability, const RfReceiver* to )
{
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    for ( int i = 0; i < v->count; ++i )
    {
        if ( v->light_pdf_solid_angle[i] == 0.0f )
            continue;
        int r = v->ray[i];
        RfVec3 emission = RF_GET3( v->emission, i );
        uint32_t light = rf_triangle_light( settings->tracer, triangle[r] );
        float probability = RF_FAULT( selection ) ? 1.0f : selection_probability( settings, rays, r, light );
        float light_pdf = light_pdf_behind( pane_probability, r, v->light_pdf_solid_angle[i] * probability );
        add_arrival( settings, rays, r, emission, rf_light_part( lights, light ), light_pdf, to );
    }
}

// The sky where it changes, in each frame as it is there.
static void add_changing_sky( const RfPathSettings* settings, const RfRayLanes* rays, int r, int part, float probability,
                              const RfReceiver* to )
{
    RfVec3 d = RF_GET3( rays->d, r );
    RfVec3 n = RF_GET3( rays->n, r );
    int slot = rays->slot[r], frames = rf_lit_frames( settings );
    bool alone = ( to->own != NULL && to->own->touched[slot] ) ||
                 ( to->chain_light != NULL && rf_may_take_chain_light( to->chain_light, slot ) );
    for ( int l = 0; l < frames; ++l )
    {
        if ( alone && l != settings->frame )
            continue;
        const RfSky* sky = &rf_tracer_lights( settings->frames[l] )->sky;
        add_arrival( settings, rays, r, rf_sky_radiance( sky, d ), rf_frame_part( settings, part, l ),
                     rf_sky_pdf_solid_angle_at( sky, n, d ) * probability, to );
    }
}

static void add_sky( const RfPathSettings* settings, const RfRayLanes* rays, const uint32_t* triangle,
                     const float* pane_probability, const RfReceiver* to )
{
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    if ( !rf_has_sky( lights ) )
        return;
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( triangle[r] != RF_MISS )
            continue;
        RfVec3 d = RF_GET3( rays->d, r );
        float probability = selection_probability( settings, rays, r, rf_sky_number( lights ) );
        int part = rf_light_part( lights, rf_sky_number( lights ) );
        if ( rf_is_own_part( part ) && settings->parts && settings->frames != NULL )
        {
            add_changing_sky( settings, rays, r, part, light_pdf_behind( pane_probability, r, probability ), to );
            continue;
        }
        RfVec3 n = RF_GET3( rays->n, r );
        float light_pdf = rf_sky_pdf_solid_angle_at( &lights->sky, n, d ) * probability;
        add_arrival( settings, rays, r, rf_sky_radiance( &lights->sky, d ), part,
                     light_pdf_behind( pane_probability, r, light_pdf ), to );
    }
}

void rf_add_emission_hits( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* vertices,
                           const uint32_t* triangle, const float* pane_probability, RfReceiver to )
{
    add_emission( settings, rays, vertices, triangle, pane_probability, &to );
    add_sky( settings, rays, triangle, pane_probability, &to );
}

void rf_note_lit( const RfPathSettings* settings, RfWavefront* wavefront, const RfLightLanes* lights, int sample, int count )
{
    if ( settings->connector == NULL )
        return;
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 radiance = RF_GET3( lights->radiance_cos, i );
        float lit = rf_luminance( radiance ) / ( (float)settings->light_samples * lights->pdf_solid_angle[i] );
        wavefront->lit[i] = lit + ( sample > 0 ? wavefront->lit[i] : 0.0f );
    }
}

static void begin_trail( const RfVertexLanes* v, int i, int vertex, RfTrail* trail )
{
    trail->n = RF_GET3( v->n, i );
    trail->ng = RF_GET3( v->ng, i );
    trail->start = rf_madd( RF_GET3( v->p, i ), trail->ng, v->offset[i] );
    trail->vertex = vertex;
}

// Counts the delta vertices of paths, after the path's `vertex`-th was scattered from with these densities.
static void count_deltas( const RfPathSettings* settings, RfWavefront* wavefront, const RfVertexLanes* v, int vertex,
                          const float* pdf )
{
    if ( settings->connector == NULL )
        return;
    const RfMaterial* materials = rf_tracer_scene( settings->tracer )->materials;
    int records = rf_record_count( v );
    for ( int i = 0; i < v->count; ++i )
    {
        uint8_t* deltas = wavefront->deltas + v->slot[i];
        bool follows = i >= records && vertex > 1 && pdf[i] == RF_DELTA_PDF && *deltas <= RF_MAX_CHAIN &&
                       rf_is_chain_surface( materials + v->material[i] );
        wavefront->matte[v->slot[i]] = i < records && rf_is_matte_lane( settings, v, i );
        if ( i < records )
            begin_trail( v, i, vertex, settings->connector->trails + v->slot[i] );
        *deltas = i < records ? 1 : follows ? (uint8_t)( *deltas + 1 ) : RF_NOT_CONNECTED;
    }
}

// Weights the emission of a vertex that a path has reached by a chain of `length` against connections.
static void share_emission( const RfPathSettings* settings, const RfLaneScratch* hits, RfVertexLanes* v, int i, int length )
{
    const RfConnector* connector = settings->connector;
    RfTrail* trail = connector->trails + v->slot[i];
    int r = v->ray[i];
    if ( length > 0 && connector->emission && v->light_pdf_solid_angle[i] > 0.0f )
    {
        RfVec3 p = RF_GET3( v->p, i );
        float weight = connector->weigh_chance( connector, trail, length, hits->triangle[r], p );
        v->light_pdf_solid_angle[i] = weight > 0.0f ? v->light_pdf_solid_angle[i] : 0.0f;
        for ( int c = 0; c < 3; ++c )
            v->emission[c][i] *= weight;
    }
    if ( i < rf_record_count( v ) || length >= RF_MAX_CHAIN )
        return;
    trail->triangle[length] = hits->triangle[r];
    trail->u[length] = hits->u[r];
    trail->v[length] = hits->v[r];
}

// Emission at the end of chains from non-specular vertices is shared with the connector: what was hit shines as much as its
// weight says; the sky where nothing was hit is left to the connector. Notes the vertices for what comes.
static void leave_to_connections( const RfPathSettings* settings, const RfWavefront* wavefront, RfRayLanes* rays,
                                  RfVertexLanes* vertices )
{
    if ( settings->connector == NULL )
        return;
    for ( int i = 0; i < vertices->count; ++i )
    {
        uint8_t deltas = wavefront->deltas[vertices->slot[i]];
        if ( deltas != RF_NOT_CONNECTED )
            share_emission( settings, &wavefront->scratch, vertices, i, deltas - 1 );
    }
    for ( int r = 0; r < rays->count && settings->connector->emission; ++r )
    {
        uint8_t deltas = wavefront->deltas[rays->slot[r]];
        for ( int c = 0; c < 3 && deltas > 1 && deltas != RF_NOT_CONNECTED && wavefront->scratch.triangle[r] == RF_MISS; ++c )
            rays->throughput[c][r] = 0.0f;
    }
}

// f and density of the BSDF alone.
static void evaluate_bsdf( const RfVertexLanes* v, RfBsdfKind kind, const float* const wo[3], const float* const wi[3],
                           float* const f[3], float* pdf_solid_angle )
{
    int first = v->first[kind], count = v->first[kind + 1] - first;
    if ( count == 0 )
        return;
    RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, kind, first );
    const float* seen_from[3] = { wo[0] + first, wo[1] + first, wo[2] + first };
    const float* in[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
    float* pdf = pdf_solid_angle != NULL ? pdf_solid_angle + first : NULL;
    if ( f == NULL )
    {
        rf_bsdf_evaluate( kind, count, &lanes, seen_from, in, NULL, pdf );
        return;
    }
    float* out[3] = { f[0] + first, f[1] + first, f[2] + first };
    rf_bsdf_evaluate( kind, count, &lanes, seen_from, in, out, pdf );
}

static void mix_guide( const RfVertexLanes* v, int first, int end, const float* const wi[3], float* pdf_solid_angle )
{
    const float* in[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
    if ( v->guide != NULL && pdf_solid_angle != NULL )
        rf_mix_guide( v->guide, end - first, v->table + first, in, pdf_solid_angle + first );
}

void rf_evaluate_seen_from( const RfVertexLanes* v, RfBsdfKind kind, const float* const wo[3], const float* const wi[3],
                            float* const f[3], float* pdf_solid_angle )
{
    evaluate_bsdf( v, kind, wo, wi, f, pdf_solid_angle );
    if ( kind < RF_BSDF_FIRST_SPECULAR )
        mix_guide( v, v->first[kind], v->first[kind + 1], wi, pdf_solid_angle );
}

static void evaluate_kinds( const RfVertexLanes* v, int kinds, const float* const wi[3], float* const f[3],
                            float* pdf_solid_angle )
{
    const float* wo[3] = { v->wo[0], v->wo[1], v->wo[2] };
    for ( int kind = 0; kind < kinds; ++kind )
    {
        if ( rf_is_model_built( (RfBsdfKind)kind ) )
            evaluate_bsdf( v, (RfBsdfKind)kind, wo, wi, f, pdf_solid_angle );
    }
}

void rf_evaluate_lanes( const RfVertexLanes* v, const float* const wi[3], float* const f[3], float* pdf_solid_angle )
{
    evaluate_kinds( v, RF_BSDF_KIND_COUNT, wi, f, pdf_solid_angle );
    mix_guide( v, 0, rf_record_count( v ), wi, pdf_solid_angle );
}

// Samples directions for the lanes of non-specular models.
static void sample_nonspecular_lanes( const RfVertexLanes* v, const RfLaneScratch* scratch, float* const wi[3] )
{
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        int first = v->first[kind], count = v->first[kind + 1] - first;
        if ( count == 0 || !rf_is_model_built( (RfBsdfKind)kind ) )
            continue;
        RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, (RfBsdfKind)kind, first );
        const float* wo[3] = { v->wo[0] + first, v->wo[1] + first, v->wo[2] + first };
        const float* u[3] = { scratch->random[0] + first, scratch->random[1] + first, scratch->random[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        rf_bsdf_sample( (RfBsdfKind)kind, count, &lanes, wo, u, out );
    }
}

static void sample_specular_lanes( const RfVertexLanes* v, RfLaneScratch* s, float* const wi[3] )
{
    for ( int kind = RF_BSDF_FIRST_SPECULAR; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        int first = v->first[kind], count = v->first[kind + 1] - first;
        if ( count == 0 || !rf_is_model_built( (RfBsdfKind)kind ) )
            continue;
        RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, (RfBsdfKind)kind, first );
        const float* wo[3] = { v->wo[0] + first, v->wo[1] + first, v->wo[2] + first };
        const float* u[3] = { s->random[0] + first, s->random[1] + first, s->random[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        float* weight[3] = { s->f[0] + first, s->f[1] + first, s->f[2] + first };
        rf_bsdf_sample_weighted( (RfBsdfKind)kind, count, &lanes, wo, u, out, weight, s->pdf + first );
    }
}

// Samples the guide instead of the BSDF where the number that selects lobes is below its share. The others keep what is left of it.
static void sample_guided_lanes( const RfVertexLanes* v, RfLaneScratch* s, float* const wi[3] )
{
    bool guided[RF_LANES];
    int count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        float share = v->table[i] >= 0 ? v->guide->tables[v->table[i]].share : 0.0f, u = s->random[2][i];
        guided[i] = u < share;
        s->random[2][i] = guided[i] ? 0.0f : rf_minf( ( u - share ) / ( 1.0f - share ), 0x1.fffffep-1f );
    }
    sample_nonspecular_lanes( v, s, wi );
    for ( int i = 0; i < count; ++i )
    {
        if ( guided[i] )
            RF_PUT3( wi, i, rf_sample_guide( v->guide->tables + v->table[i], s->random[0][i], s->random[1][i] ) );
    }
}

void rf_scatter_lanes( const RfWavefront* keys, const RfVertexLanes* v, uint32_t dimension, float* const wi[3],
                       RfLaneScratch* scratch )
{
    const float* wi_in[3] = { wi[0], wi[1], wi[2] };
    float* f[3] = { scratch->f[0], scratch->f[1], scratch->f[2] };
    rf_draw_lanes( keys, v->count, v->slot, dimension, 3, scratch->random );
    if ( v->guide != NULL )
        sample_guided_lanes( v, scratch, wi );
    else
        sample_nonspecular_lanes( v, scratch, wi );
    evaluate_kinds( v, RF_BSDF_FIRST_SPECULAR, wi_in, f, scratch->pdf );
    if ( v->guide != NULL )
    {
        memcpy( scratch->pdf_bsdf, scratch->pdf, (size_t)rf_record_count( v ) * sizeof( float ) );
        mix_guide( v, 0, rf_record_count( v ), wi_in, scratch->pdf );
    }
    sample_specular_lanes( v, scratch, wi );
}

static void add_light_samples( const RfPathSettings* settings, RfWavefront* wavefront, const RfRayLanes* rays, int vertex )
{
    const RfVertexLanes* v = &wavefront->vertices;
    RfLightLanes* lights = &wavefront->lights;
    RfLaneScratch* s = &wavefront->scratch;
    int samples = settings->light_samples, count = rf_light_set_count( settings, samples );
    bool apart = settings->parts || settings->grouped;
    float k = (float)samples;
    for ( int j = 0; j < rf_light_lanes_count( settings ); ++j )
    {
        uint32_t dimension = rf_vertex_dimension( vertex, samples ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)( j % samples );
        if ( j < count )
        {
            RfLightSample sample = { dimension, rf_frame_of_sample( settings, samples, j ) };
            int lit = rf_sample_lights( settings, wavefront, v, sample, lights, s );
            wavefront->shadow_rays += (uint64_t)lit;
            if ( lit == 0 && j >= samples )
                continue;
            rf_note_lit( settings, wavefront, lights, j, v->count );
        }
        else
            settings->connector->sample( settings->connector, wavefront, rays, v, vertex, lights, NULL );
        const float* wi[3] = { lights->wi[0], lights->wi[1], lights->wi[2] };
        float* f[3] = { s->f[0], s->f[1], s->f[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = 0; i < v->count; ++i )
        {
            int slot = v->slot[i], r = v->ray[i];
            float scale = rf_balance_scale( k * lights->pdf_solid_angle[i], s->pdf[i] );
            int part = apart ? lights->part[i] : 0;
            RfArrivals* to = settings->own != NULL && lights->touched[i] ? rf_own_arrivals( settings->own, part )
                                                                         : rf_arrivals_of_part( wavefront, part );
            for ( int c = 0; c < 3; ++c )
                to->rest[c][slot] += rays->throughput[c][r] * s->f[c][i] * lights->radiance_cos[c][i] * scale;
        }
    }
}

// Guides are used where light is hard to find: paths end later there.
#define GUIDED_WORTH 4.0f

// The factor by which a guide lowers the throughput of a path, for roulette: where a guide leads, more light is to be expected than the
// throughput tells (Vorba, Křivánek, Adjoint-Driven Russian Roulette and Splitting, 2016).
static float lowered_by_guide( const RfLaneScratch* s, int i )
{
    const float most = 1e4f; // of directions that the BSDF hardly draws
    return rf_minf( s->pdf[i] / rf_maxf( s->pdf_bsdf[i], 1e-30f ), most );
}

// Survival probability of the roulette, from the throughput of the path.
static float survival( const RfWavefront* wavefront, int vertex, int slot, const float throughput[3] )
{
    if ( vertex < RF_ROULETTE_VERTEX )
        return 1.0f;
    float carried = rf_maxf( throughput[0], rf_maxf( throughput[1], throughput[2] ) ) * wavefront->roulette_scale[slot];
    return rf_survival( wavefront->vertices.guide != NULL ? GUIDED_WORTH * carried : carried, vertex );
}

// Lanes with a non-specular BSDF.
static int scatter_nonspecular_lanes( RfWavefront* wavefront, const RfRayLanes* rays, int vertex, RfRayLanes* next )
{
    const RfVertexLanes* v = &wavefront->vertices;
    const RfLaneScratch* s = &wavefront->scratch;
    int kept = 0, count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        float wi[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float cos_x = v->n[0][i] * wi[0] + v->n[1][i] * wi[1] + v->n[2][i] * wi[2];
        float cos_g = v->ng[0][i] * wi[0] + v->ng[1][i] * wi[1] + v->ng[2][i] * wi[2];
        float pdf = s->pdf[i];
        int r = v->ray[i];
        float scale = pdf > 0.0f ? cos_x / pdf : 0.0f;
        float t[3];
        for ( int c = 0; c < 3; ++c )
            t[c] = rays->throughput[c][r] * s->f[c][i] * scale;
        if ( v->guide != NULL )
            wavefront->roulette_scale[v->slot[i]] *= lowered_by_guide( s, i );
        float q = survival( wavefront, vertex, v->slot[i], t );
        for ( int c = 0; c < 3; ++c )
            next->throughput[c][kept] = q > 0.0f ? t[c] / q : 0.0f;
        rf_write_ray( v, i, wi, 1.0f, pdf, next, kept );
        kept += ( cos_x > 0.0f ) & ( cos_g > 0.0f || RF_FAULT( below_triangle ) ) & ( pdf > 0.0f ) & ( s->random[0][i] < q );
    }
    return kept;
}

// Specular lanes: sampling returned their weight, and they may leave on either side.
static int scatter_specular_lanes( RfWavefront* wavefront, const RfRayLanes* rays, int vertex, RfRayLanes* next, int kept )
{
    const RfVertexLanes* v = &wavefront->vertices;
    const RfLaneScratch* s = &wavefront->scratch;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float wi[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, wi );
        int r = v->ray[i];
        float t[3];
        for ( int c = 0; c < 3; ++c )
            t[c] = rays->throughput[c][r] * s->f[c][i];
        float q = survival( wavefront, vertex, v->slot[i], t );
        for ( int c = 0; c < 3; ++c )
            next->throughput[c][kept] = q > 0.0f || RF_FAULT( roulette_0 ) ? t[c] / q : 0.0f;
        rf_write_ray( v, i, wi, side, s->pdf[i], next, kept );
        kept += ( side != 0.0f ) & ( rf_maxf( t[0], rf_maxf( t[1], t[2] ) ) > 0.0f ) & ( s->random[0][i] < q );
    }
    return kept;
}

static void scatter( const RfPathSettings* settings, RfWavefront* wavefront, const RfRayLanes* rays, int vertex,
                     RfRayLanes* next )
{
    const RfVertexLanes* v = &wavefront->vertices;
    RfLaneScratch* s = &wavefront->scratch;
    uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples );
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    rf_scatter_lanes( wavefront, v, dimension + RF_DIMENSION_SCATTER, wi, s );
    count_deltas( settings, wavefront, v, vertex, s->pdf );
    note_chain_events( settings->chain_light, v, vertex, (const float* const*)wi, s->pdf );
    note_caustics( settings, v, s->pdf );
    rf_draw_lanes( wavefront, v->count, v->slot, dimension + RF_DIMENSION_ROULETTE, 1, s->random );
    int kept = scatter_nonspecular_lanes( wavefront, rays, vertex, next );
    if ( settings->notes != NULL )
        rf_note_vertices( wavefront, rays, next, kept, settings->notes );
    next->count = scatter_specular_lanes( wavefront, rays, vertex, next, kept );
}

void rf_absorb( const RfVertexLanes* v, RfRayLanes* rays )
{
    for ( int i = rf_record_count( v ); rf_is_built( RF_EFFECT_ABSORPTION ) && i < v->count; ++i )
    {
        int r = v->ray[i];
        RfVec3 transmittance = rf_transmittance_from( v, i, RF_GET3( rays->o, r ) );
        rays->throughput[0][r] *= transmittance.x;
        rays->throughput[1][r] *= transmittance.y;
        rays->throughput[2][r] *= transmittance.z;
    }
}

const float* rf_find_lit_vertices( const RfPathSettings* settings, RfWavefront* wavefront, RfRayLanes* rays, bool defer_mis,
                                   RfVertexLanes* vertices )
{
    rf_count_path_rays( wavefront, rays );
    const float* pane_probability = rf_find_vertices_past_panes( settings, rays, 0, vertices, &wavefront->scratch );
    rf_absorb( vertices, rays );
    leave_to_connections( settings, wavefront, rays, vertices );
    if ( settings->own != NULL && !settings->own->caustics )
        rf_touch_by_rays( settings->tracer, rays, vertices, wavefront->scratch.triangle, settings->own->touched );
    RfReceiver to = { .defer_mis = defer_mis,
                      .chain_light = settings->chain_light,
                      .arrivals = &wavefront->arrivals,
                      .own = settings->own,
                      .dimmed = wavefront->dimmed };
    rf_add_emission_hits( settings, rays, vertices, wavefront->scratch.triangle, pane_probability, to );
    return pane_probability;
}

void rf_end_spent_paths( const RfPathSettings* settings, int vertex, RfRayLanes* rays )
{
    if ( settings->spent == NULL )
        return;
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( settings->spent[rays->slot[r]] + vertex < settings->max_depth )
            continue;
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][r] = 0.0f;
    }
}

void rf_trace_tails( const RfPathSettings* settings, RfWavefront* wavefront, int first_vertex )
{
    RfRayLanes* rays = &wavefront->rays;
    RfRayLanes* next = &wavefront->next;
    int most = settings->max_depth + ( settings->spent != NULL && rf_tracer_has_panes( settings->tracer ) );
    for ( int vertex = first_vertex; vertex <= most && rays->count > 0; ++vertex )
    {
        rf_find_lit_vertices( settings, wavefront, rays, vertex == first_vertex, &wavefront->vertices );
        if ( vertex == most )
            break;
        rf_draw_sides( wavefront, vertex, &wavefront->vertices );
        rf_end_spent_paths( settings, vertex, rays );
        add_light_samples( settings, wavefront, rays, vertex );
        scatter( settings, wavefront, rays, vertex, next );
        RfRayLanes* swap = rays;
        rays = next;
        next = swap;
    }
}

// Lanes that become records: the caller applies f and the weight.
static int scatter_nonspecular_deferred( const RfVertexLanes* v, float* const wi[3], RfWavefront* wavefront )
{
    RfRayLanes* rays = &wavefront->rays;
    const RfLaneScratch* s = &wavefront->scratch;
    int kept = 0, count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        float direction[3] = { wi[0][i], wi[1][i], wi[2][i] };
        float cos_x = v->n[0][i] * direction[0] + v->n[1][i] * direction[1] + v->n[2][i] * direction[2];
        float cos_g = v->ng[0][i] * direction[0] + v->ng[1][i] * direction[1] + v->ng[2][i] * direction[2];
        float pdf = s->pdf[i];
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][kept] = 1.0f;
        rf_write_ray( v, i, direction, 1.0f, pdf, rays, kept );
        float weight = pdf > 0.0f ? rf_maxf( s->f[0][i], rf_maxf( s->f[1][i], s->f[2][i] ) ) * cos_x / pdf : 0.0f;
        if ( v->guide != NULL )
            weight *= lowered_by_guide( s, i );
        wavefront->roulette_scale[v->slot[i]] *= rf_shared_factor( weight );
        kept += ( cos_x > 0.0f ) & ( cos_g > 0.0f || RF_FAULT( below_triangle ) ) & ( pdf > 0.0f );
    }
    return kept;
}

// Specular lanes: the ray carries the weight.
static int scatter_specular_deferred( const RfVertexLanes* v, float* const wi[3], RfWavefront* wavefront, int kept )
{
    RfRayLanes* rays = &wavefront->rays;
    const RfLaneScratch* s = &wavefront->scratch;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float direction[3] = { wi[0][i], wi[1][i], wi[2][i] };
        float side = rf_leaving_side( v, i, direction );
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][kept] = s->f[c][i];
        rf_write_ray( v, i, direction, side, s->pdf[i], rays, kept );
        kept += ( side != 0.0f ) & ( rf_maxf( s->f[0][i], rf_maxf( s->f[1][i], s->f[2][i] ) ) > 0.0f );
    }
    return kept;
}

void rf_scatter_deferred( const RfPathSettings* settings, RfWavefront* wavefront, const RfVertexLanes* v, int vertex,
                          float* const wi[3] )
{
    uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples ) + RF_DIMENSION_SCATTER;
    rf_scatter_lanes( wavefront, v, dimension, wi, &wavefront->scratch );
    count_deltas( settings, wavefront, v, vertex, wavefront->scratch.pdf );
    note_chain_events( settings->chain_light, v, vertex, (const float* const*)wi, wavefront->scratch.pdf );
    note_caustics( settings, v, wavefront->scratch.pdf );
    wavefront->rays.count = scatter_specular_deferred( v, wi, wavefront, scatter_nonspecular_deferred( v, wi, wavefront ) );
}
