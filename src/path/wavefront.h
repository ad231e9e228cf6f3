// The path tracer, by wavefronts. The caller finds first vertices, samples lights
// and scatters there itself, and hands the scattered rays to rf_trace_tails, which
// returns the radiance that arrives along them.
#ifndef REFRAME_PATH_WAVEFRONT_H
#define REFRAME_PATH_WAVEFRONT_H

#include "path/own_light.h"
#include "trace/occluders.h"

#include <string.h>

// Light that a path finds by a specular chain from its first hit to emission. Other hits of its tile may follow
// the same chain (src/reuse/tile).
#define RF_MAX_CHAIN_LIGHT 16 // vertices of such a chain

// By slot.
typedef struct RfChainLight
{
    RF_ALIGN float light[3][RF_LANES]; // leaving the chain's first vertex towards the hit; 0: none
    uint16_t transmitted[RF_LANES];    // bit v: transmission at vertex v of the chain, from 0; else reflection
    uint8_t length[RF_LANES];          // its vertices
    uint8_t touched[RF_LANES];         // with RfPathSettings.own: 1 where what moves touches the way to the light
    uint8_t* part;                     // with RfPathSettings.grouped: the base part of the light; NULL: has no groups
    bool open[RF_LANES];               // the path has only seen such vertices since its hit, and no emission yet
} RfChainLight;

// Whether a lane scattered, with density `pdf`, as a mirror or smooth glass does. Thin panes do not count: rays
// pass them without stopping; nor does SPECTRAL, which draws the channel that it refracts.
static inline bool rf_is_chain_event( const RfVertexLanes* v, int i, float pdf )
{
    return i >= rf_record_count( v ) && i < v->first[RF_BSDF_SPECTRAL] && pdf == RF_DELTA_PDF &&
           v->param[RF_PARAM_SHAPE][i] == 0.0f && v->param[RF_PARAM_IOR][i] >= 0.0f;
}

// Whether emission that a slot's path hits now has come by a chain.
static inline bool rf_may_take_chain_light( const RfChainLight* chain_light, int slot )
{
    return chain_light->open[slot] && chain_light->length[slot] > 0;
}

// Takes the emission that a slot's path has hit, times throughput, if it came by a chain.
static inline bool rf_take_chain_light( RfChainLight* chain_light, int slot, const float light[3] )
{
    bool taken = rf_may_take_chain_light( chain_light, slot ) && light[0] + light[1] + light[2] > 0.0f;
    for ( int c = 0; c < 3 && taken; ++c )
        chain_light->light[c][slot] = light[c];
    chain_light->open[slot] = chain_light->open[slot] && !taken;
    return taken;
}

// A path that hits emission without a chain has no chain light.
static inline void rf_close_chain( RfChainLight* chain_light, int slot, const float light[3] )
{
    if ( chain_light != NULL && light[0] + light[1] + light[2] > 0.0f )
        chain_light->open[slot] = false;
}

typedef struct RfConnector RfConnector;
typedef struct RfGuideNotes RfGuideNotes;

// How the paths of a batch are traced. Const while they are: where a part of them is traced otherwise, it has settings of its own.
typedef struct RfPathSettings
{
    const RfTracer* tracer; // of the paths' frame
    int max_depth;          // path vertices after the camera, ≥ 1
    int light_samples;      // K ≥ 1 per vertex
    RfLightSampling light_sampling;
    RfOccluders* occluders;       // of the thread; NULL: none
    const RfConnector* connector; // NULL: caustics are found by scattered rays alone
    RfOwnLight* own;      // keeps light of paths that what moves touches, or caustics, apart from the arrivals; NULL: none
    const RfGuide* guide; // of scattering at vertices that become records; NULL: none
    RfGuideNotes* notes;  // get the vertices of rf_trace_tails (path/guide_learner.h); NULL: nothing is learned
    bool frosted;         // camera rays find rough glass as RF_BSDF_FROSTED
    bool parts;           // keeps that of each part apart (light/light.h); else it is as in the tracer's frame
    bool grouped;         // keeps light groups apart: what has no part of its own counts in the base part of its group
    // with parts: the tracers of the frames, where light of one frame is looked up in each; NULL: it is not
    const RfTracer* const* frames;
    int frame;            // of the paths
    const int32_t* spent; // by slot: vertices before the first one, which max_depth counts as well, or −1: the first is a pane
                          // that was passed, which it does not count; NULL: none
    RfChainLight* chain_light; // keeps light by chains apart from the arrivals; NULL: it is among them
} RfPathSettings;

// A thread's wavefront.
typedef struct RfWavefront
{
    // in, by slot
    RF_ALIGN uint32_t key_a[RF_LANES];
    uint32_t key_b[RF_LANES];
    RfLattice lattice;
    float roulette_scale[RF_LANES]; // largest channel of the path's weight up to where throughput starts
    RfRayLanes rays;                // the scattered rays; overwritten
    // out, by slot
    RfArrivals arrivals;
    RfArrivals* dimmed;              // of all parts from 1 on: use rf_arrivals_of_part
    uint64_t path_rays, shadow_rays; // counted up
    uint16_t rays_of[RF_LANES];      // path rays by slot, counted up
    uint8_t deltas[RF_LANES];        // with a connector, by slot: 1 + the specular vertices since the last non-specular one;
                                     // RF_NOT_CONNECTED: none yet, or others are among them
    bool matte[RF_LANES];            // with a connector, by slot: whether the ray left a matte vertex (rf_is_matte)
    float lit[RF_LANES]; // with a connector, by vertex lane: luminance of the irradiance that light samples found there
    // inside
    RfRayLanes next;
    RfVertexLanes vertices;
    RfLightLanes lights;
    RfLaneScratch scratch;
} RfWavefront;

static inline RfArrivals* rf_arrivals_of_part( RfWavefront* wavefront, int part )
{
    return part == 0 ? &wavefront->arrivals : wavefront->dimmed + part - 1;
}

static inline void rf_clear_ray_counts( RfWavefront* wavefront )
{
    wavefront->path_rays = wavefront->shadow_rays = 0;
    memset( wavefront->rays_of, 0, sizeof wavefront->rays_of );
}

static inline void rf_count_path_rays( RfWavefront* wavefront, const RfRayLanes* rays )
{
    wavefront->path_rays += (uint64_t)rays->count;
    for ( int r = 0; r < rays->count; ++r )
        wavefront->rays_of[rays->slot[r]] += 1;
}

// The specular chain by which a path left a non-specular vertex.
typedef struct RfTrail
{
    RfVec3 start;                    // where rays leave the vertex
    RfVec3 n, ng;                    // unit shading and geometric normal there
    int vertex;                      // its number in the path
    uint32_t triangle[RF_MAX_CHAIN]; // that were hit, with barycentrics
    float u[RF_MAX_CHAIN], v[RF_MAX_CHAIN];
} RfTrail;

// Finds light that reaches non-specular vertices by specular chains (src/light_paths), which scattered rays may
// find as well.
struct RfConnector
{
    // Samples such light at the paths' `vertex`-th vertices, hit by `rays`, like light samples that no scattered
    // ray finds: densities are RF_DELTA_PDF, or 1 where there is none. Fewer are tried where wavefront->lit is
    // large. Adds to keys->path_rays. Connections that the previous vertex may find as well are weighted, unless
    // `area` is given, which gets the area for rf_own_weight.
    void ( *sample )( const RfConnector* connector, RfWavefront* keys, const RfRayLanes* rays, const RfVertexLanes* vertices,
                      int vertex, RfLightLanes* out, float* area );
    // Connections that a vertex finds, on average, to the VPLs of one light path.
    float vpl_connections;
    bool emission;   // of surfaces and the sky is found, not of punctual lights alone
    RfTrail* trails; // by slot: workspace
    // The weight of a scattered ray that came by `length` vertices of a trail to a point of an emitter: one minus
    // that of connections.
    float ( *weigh_chance )( const RfConnector* connector, const RfTrail* trail, int length, uint32_t triangle, RfVec3 point );
};

// The base parts of light groups, of which part 0 is one.
static inline int rf_base_parts( const RfPathSettings* settings )
{
    return settings->grouped ? rf_tracer_lights( settings->tracer )->group_count : 1;
}

// The base part that light of a part counts in where it has none of its own.
static inline int rf_counts_in( const RfPathSettings* settings, int part )
{
    return settings->grouped && !RF_FAULT( light_group ) ? rf_base_part( rf_tracer_lights( settings->tracer ), part ) : 0;
}

// The frames in which paths look up light of one frame.
static inline int rf_lit_frames( const RfPathSettings* settings )
{
    return settings->frames != NULL ? rf_tracer_lights( settings->tracer )->frame_count : 1;
}

// The part that light of one frame has there, which has the number `part` otherwise.
static inline int rf_frame_part( const RfPathSettings* settings, int part, int frame )
{
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    return lights->dimmed_count + 1 + lights->frame_group[rf_base_part( lights, part )] * lights->frame_count + frame;
}

// How many parts light has that is kept apart by group, lamp or frame, from 1 on.
static inline int rf_dimmed_parts( const RfPathSettings* settings )
{
    if ( !settings->parts )
        return 0;
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    return lights->dimmed_count + ( settings->frames != NULL ? lights->frame_groups * lights->frame_count : 0 );
}

// Light samples per vertex, `samples` of them for each frame in which light is looked up, the paths' own first, without that of the
// connector.
static inline int rf_light_set_count( const RfPathSettings* settings, int samples )
{
    return samples * rf_lit_frames( settings );
}

// The frame that a light sample is of.
static inline int rf_frame_of_sample( const RfPathSettings* settings, int samples, int sample )
{
    int n = sample / samples;
    return n == 0 ? settings->frame : n <= settings->frame ? n - 1 : n;
}

// Whether a light sample may have light of a part.
static inline bool rf_sample_has_part( const RfPathSettings* settings, int samples, int sample, int part )
{
    if ( settings->frames == NULL )
        return true;
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    if ( part <= lights->dimmed_count )
        return sample < samples;
    return ( part - lights->dimmed_count - 1 ) % lights->frame_count == rf_frame_of_sample( settings, samples, sample );
}

// Emission of a vertex, and the sky, as they are in the tracer's frame.
static inline RfVec3 rf_emission_in_frame( const RfPathSettings* settings, const RfVertexLanes* v, int i )
{
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    RfVec3 emission = RF_GET3( v->emission, i );
    return rf_mul( emission, rf_part_scale( lights, rf_material_part( lights, v->material[i] ) ) );
}

static inline RfVec3 rf_sky_in_frame( const RfPathSettings* settings, RfVec3 d )
{
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    RfVec3 scale = rf_part_scale( lights, rf_light_part( lights, rf_sky_number( lights ) ) );
    return rf_mul( rf_sky_radiance( &lights->sky, d ), scale );
}

// Light samples per vertex, with that of the connector.
static inline int rf_light_lanes_count( const RfPathSettings* settings )
{
    return rf_light_set_count( settings, settings->light_samples ) + ( settings->connector != NULL );
}

// Traces the rays and fills the vertices they hit, sorted by scattering model and
// by ray within a model. Rays that miss leave no vertex. `coherent`: these are camera rays, which are
// traversed together, and see colours of textures by mip levels.
void rf_find_vertices( const RfPathSettings* settings, const RfRayLanes* rays, bool coherent, RfVertexLanes* vertices,
                       RfLaneScratch* scratch );

// The same, but rays from `first_past` on pass thin panes by chance, undeflected, and their throughput gets the
// panes' factor κ. Panes that they did not pass are vertices without transmission. Returns the probability q of
// each ray of passing its panes, in the scratch; NULL: the scene has no panes (src/reuse/estimators.md,
// section 11).
const float* rf_find_vertices_past_panes( const RfPathSettings* settings, RfRayLanes* rays, int first_past,
                                          RfVertexLanes* vertices, RfLaneScratch* scratch );

// `numbers` uniform numbers per lane, from `dimension` on: random, or of keys->lattice.
void rf_draw_lanes( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, int numbers,
                    float random[][RF_LANES] );

// Random numbers of a light sample, in the scratch: two words that select the light, two numbers for the point on
// it. With RF_DIMENSION_OPPOSITE in `dimension` they are half an interval from those without it.
void rf_draw_light_numbers( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, RfLaneScratch* scratch );

// Draws the sides on which light arrives at TRANSLUCENT and FROSTED lanes, the paths' `vertex`-th (src/reuse/estimators.md,
// section 20): where it is not the side that is seen, n and ng are turned over. After rf_face_rays ng is on the side of wo again.
void rf_draw_sides( const RfWavefront* keys, int vertex, RfVertexLanes* vertices );
void rf_face_rays( RfVertexLanes* vertices );

// A light sample: its random numbers are `dimension` and the two after it. In another frame than the paths' own it has light of one
// frame alone.
typedef struct RfLightSample
{
    uint32_t dimension;
    int frame;
} RfLightSample;

// Takes one light sample per vertex lane and tests its visibility. Returns the number of shadow rays.
int rf_sample_lights( const RfPathSettings* settings, const RfWavefront* keys, const RfVertexLanes* vertices,
                      RfLightSample sample, RfLightLanes* lights, RfLaneScratch* scratch );

// f and density for all lanes of the vertices, model by model (see bsdf.h).
void rf_evaluate_lanes( const RfVertexLanes* vertices, const float* const wi[3], float* const f[3], float* pdf_solid_angle );

// The same for the lanes of one model, seen from wo. Lane i of all arrays is lane i
// of the vertices. Either output may be NULL.
void rf_evaluate_seen_from( const RfVertexLanes* vertices, RfBsdfKind kind, const float* const wo[3], const float* const wi[3],
                            float* const f[3], float* pdf_solid_angle );

// Samples wi for all lanes of the vertices from three random numbers each. Its f
// and density go to scratch; for specular lanes the weight f |cos| / density
// takes the place of f.
void rf_scatter_lanes( const RfWavefront* keys, const RfVertexLanes* vertices, uint32_t dimension, float* const wi[3],
                       RfLaneScratch* scratch );

// Where emission that rays hit goes.
typedef struct RfReceiver
{
    bool defer_mis;            // to `emitted` of the arrivals, unweighted; else to `rest`, weighted by the balance heuristic
    RfChainLight* chain_light; // takes what it waits for instead; NULL: nothing
    RfArrivals* arrivals;
    RfOwnLight* own;      // takes that of touched paths; NULL: there are none
    RfArrivals* dimmed;   // take that of parts from 1 on; not set without RfPathSettings.parts or grouped
    const uint8_t* event; // by slot: which of `events` arrivals of a base part takes it; NULL: there is one of each part
    int events;
} RfReceiver;

// Adds emission hit by the rays, of surfaces (the vertices) and of the sky. The rays have passed panes with these probabilities
// (NULL: no panes).
void rf_add_emission_hits( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* vertices,
                           const uint32_t* triangle, const float* pane_probability, RfReceiver to );

// The side on which wi leaves a specular lane: 1 that of wo, −1 the other; 0
// where shading and geometric normal disagree and the path ends.
static inline float rf_leaving_side( const RfVertexLanes* v, int i, const float wi[3] )
{
    float cos_x = v->n[0][i] * wi[0] + v->n[1][i] * wi[1] + v->n[2][i] * wi[2];
    float cos_g = v->ng[0][i] * wi[0] + v->ng[1][i] * wi[1] + v->ng[2][i] * wi[2];
    if ( cos_x * cos_g <= 0.0f )
        return 0.0f;
    return cos_g > 0.0f ? 1.0f : -1.0f;
}

// Writes the ray that leaves a vertex lane on a side to a lane of the rays, except for its throughput.
static inline void rf_write_ray( const RfVertexLanes* v, int i, const float wi[3], float side, float pdf, RfRayLanes* rays,
                                 int to )
{
    for ( int c = 0; c < 3; ++c )
    {
        rays->o[c][to] = v->p[c][i] + v->ng[c][i] * ( side * v->offset[i] );
        rays->d[c][to] = wi[c];
        rays->n[c][to] = v->n[c][i];
    }
    rays->pdf_solid_angle[to] = pdf;
    rays->slot[to] = v->slot[i];
}

// Transmittance of an absorbing medium (Beer, Lambert).
static inline RfVec3 rf_transmittance( RfVec3 absorption, float distance )
{
    return rf_vec3( expf( -absorption.x * distance ), expf( -absorption.y * distance ), expf( -absorption.z * distance ) );
}

// Transmittance between a glass lane and `o`, the origin of the ray that hit it: 1
// unless the ray ran inside the body.
static inline RfVec3 rf_transmittance_from( const RfVertexLanes* v, int i, RfVec3 o )
{
    RfVec3 absorption = RF_GET3( v->absorption, i );
    if ( !rf_calls_for( rf_max_component( absorption ) > 0.0f, RF_EFFECT_ABSORPTION ) )
        return rf_vec3( 1, 1, 1 );
    return rf_transmittance( absorption, rf_length( rf_sub( RF_GET3( v->p, i ), o ) ) );
}

// Scatters all lanes of the vertices, the path's `vertex`-th, with deferred MIS.
// wavefront->rays gets the rays that can carry light. Their throughput is 1 for
// lanes that become records, whose weight only scales wavefront->roulette_scale,
// and the weight f |cos| / density for specular lanes. Directions go to wi,
// densities to wavefront->scratch.pdf.
void rf_scatter_deferred( const RfPathSettings* settings, RfWavefront* wavefront, const RfVertexLanes* vertices, int vertex,
                          float* const wi[3] );

#define RF_NOT_CONNECTED 255

// Lower bound of the cosine at a VPL, for the search of connections.
#define RF_LEAST_VPL_COSINE 0.1f

// Light that reaches a vertex x by a chain and y from there, both matte, is found in two ways: by a ray from y to
// x and a connection there, and by a connection from y to the VPL at x. Returns the balance weight of the first,
// with cosine densities (src/reuse/estimators.md, section 16). `area`: covered by the connection at x, per
// connection found in it; infinity: the second does not find it.
static inline float rf_own_weight( float vpl_connections, float area, RfVec3 y, RfVec3 n_y, RfVec3 x, RfVec3 ng_x )
{
    if ( area == INFINITY )
        return 1.0f;
    RfVec3 way = rf_sub( x, y );
    float d2 = rf_maxf( rf_dot( way, way ), 1e-20f ), inverse = 1.0f / sqrtf( d2 );
    float cos_y = rf_maxf( rf_dot( way, n_y ) * inverse, 0.0f ), cos_x = rf_maxf( -rf_dot( way, ng_x ) * inverse, 0.0f );
    float by_ray = RF_INV_PI * cos_y * area / d2; // over cos_x, like the next
    return rf_balance_weight( by_ray, vpl_connections / rf_maxf( cos_x, RF_LEAST_VPL_COSINE ) );
}

// Whether a lane is matte.
static inline bool rf_is_matte_lane( const RfPathSettings* settings, const RfVertexLanes* v, int i )
{
    return rf_is_matte( rf_tracer_scene( settings->tracer )->materials[v->material[i]].kind, v->param[RF_PARAM_SHAPE][i] );
}

// Adds a light sample of each vertex to wavefront->lit; the first (`sample` 0) replaces what is there.
void rf_note_lit( const RfPathSettings* settings, RfWavefront* wavefront, const RfLightLanes* lights, int sample, int count );

// Ends the paths for which `vertex` is the last one: their throughput becomes 0.
void rf_end_spent_paths( const RfPathSettings* settings, int vertex, RfRayLanes* rays );

// Absorption along rays that reach the surface of a body from inside.
void rf_absorb( const RfVertexLanes* vertices, RfRayLanes* rays );

// Finds the vertices that the rays hit, behind panes too, applies absorption, marks touched paths, and adds their emission to
// wavefront->arrivals (see rf_add_emission_hits). Returns what rf_find_vertices_past_panes returns.
const float* rf_find_lit_vertices( const RfPathSettings* settings, RfWavefront* wavefront, RfRayLanes* rays, bool defer_mis,
                                   RfVertexLanes* vertices );

// Computes the radiance that arrives along wavefront->rays, which left vertex
// first_vertex − 1 of their paths: light and BSDF sampling at all further vertices,
// combined by the balance heuristic, with Russian roulette from the third vertex on.
// wavefront->arrivals must be zero for the slots of the rays.
void rf_trace_tails( const RfPathSettings* settings, RfWavefront* wavefront, int first_vertex );

#endif
