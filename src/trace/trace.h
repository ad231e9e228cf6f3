// A thin wrapper of Embree: nearest hits and occlusion for arrays of rays, as structures of
// arrays. Rays are traced in packets of 16 in the given order, so neighbours in the arrays
// should be close in space.
// Creating a tracer, and its scene and device: reframe/scene.h.
#ifndef REFRAME_TRACE_TRACE_H
#define REFRAME_TRACE_TRACE_H

#include "base/built_in.h"
#include "light/light.h"
#include "scene/mirrors.h"
#include "scene/scene.h"

#include <stddef.h>
#include <stdint.h>

// What the code for some effects runs for: for scenes that call for these, unless they are left out, or where they are forced.
typedef struct RfTracerRuns
{
    bool blended;     // some surface is alpha-blended
    bool panes;       // some may be a thin pane
    bool textured;    // some material has `textured`
    bool any_blended; // some surface is blended, and not because of what is forced
    bool partial;     // segments may be open in part: a surface is blended or a pane, and not because of what is forced
} RfTracerRuns;

// rf_create_tracer with a BVH that is built by so many threads; 0: all cores this process may use.
RfResult rf_create_tracer_by( int threads, const RfScene* scene, RfTracer** tracer, RfError* error );

// A tracer for a moment of a scene that moves (scene/pose.h). It shares all that stands still with `still`, which was created for
// the scene as it was loaded, and must outlive it, as must the posed scene. What moves is no flat mirror. Where lights move or
// change, it has none of them until rf_set_lights.
RfResult rf_create_posed_tracer( const RfTracer* still, const RfScene* posed, RfTracer** tracer, RfError* error );

// A posed tracer at a moment of its frame's shutter, 0 to 1: a copy at `memory`, of rf_tracer_at_bytes and aligned to 64, which goes
// with the tracer. The tracer itself where the shutter is closed, or nothing moves in it. As it was created it is in the middle.
size_t rf_tracer_at_bytes( uint32_t lights ); // at least the triangles that emit, where some of them move, else 0
const RfTracer* rf_tracer_at( const RfTracer* posed, float moment, void* memory );

// Swept geometry: what moves in a group of frames, at all of them together (src/reuse/estimators.md, section 18).
typedef struct RfSwept RfSwept;

// Those of `count` posed tracers, which must outlive them: a BVH, and nothing is copied. On failure *swept is NULL.
RfResult rf_create_swept( int count, const RfTracer* const* posed, RfSwept** swept, RfError* error );
void rf_destroy_swept( RfSwept* swept );
// NULL: the tracer has none from now on.
void rf_set_swept( RfTracer* posed, const RfSwept* swept );

// Gives a posed tracer its lights among those of a group of frames (light/changing.h), which must outlive it or other lights; NULL:
// those of `still`.
void rf_set_lights( RfTracer* posed, RfLights* lights );

// Whether paths may hold in some frames of the group only.
bool rf_tracer_has_swept( const RfTracer* tracer );

// Sets touched[i] to 1 for those of the rays o + t d, 0 < t < length, that meet swept geometry, whatever its opacity; leaves the others.
// length: 1 for segments, infinity for rays.
void rf_find_swept( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float length,
                    uint8_t* touched );

RfTracerRuns rf_tracer_runs( const RfTracer* tracer );

// True if some surface is alpha-blended. Visibility is then a number between 0 and 1.
static inline bool rf_tracer_is_blended( const RfTracer* tracer )
{
    return rf_is_built( RF_EFFECT_ALPHA_BLEND ) && rf_tracer_runs( tracer ).blended;
}

// True if some surface may be a thin pane (bsdf/bsdf.h).
static inline bool rf_tracer_has_panes( const RfTracer* tracer )
{
    return rf_is_built( RF_EFFECT_PANES ) && rf_tracer_runs( tracer ).panes;
}

// True if the way that a path took may be open in part, so that it is worth another look.
static inline bool rf_tracer_is_partial( const RfTracer* tracer )
{
    return ( rf_tracer_is_blended( tracer ) || rf_tracer_has_panes( tracer ) ) && rf_tracer_runs( tracer ).partial;
}

// True if some material is textured, so that hits must look up RfMaterial.textured.
static inline bool rf_tracer_is_textured( const RfTracer* tracer )
{
    return rf_is_built( RF_EFFECT_TEXTURES ) && rf_tracer_runs( tracer ).textured;
}

// The lights of the scene, collected at creation (light/light.h), or as they have been set.
const RfLights* rf_tracer_lights( const RfTracer* tracer );
const RfMirrors* rf_tracer_mirrors( const RfTracer* tracer );

// Where its mirrors and its glass are.
const RfChainBounds* rf_tracer_chain_bounds( const RfTracer* tracer );

#define RF_MISS 0xffffffffu
#define RF_NO_MIRROR 0xffu

// The geometry of a triangle in world space, in one record, so that a hit reads only one place. Edges and
// normal differences are relative to vertex 0, for barycentrics u, v.
typedef struct RfTriangleRecord
{
    RfVec3 p0, e1, e2; // position = p0 + u e1 + v e2
    RfVec3 n0, d1, d2; // shading normal = n0 + u d1 + v d2, not normalised
    RfVec3 ng;         // unit geometric normal of the front side
    uint32_t material;
    uint32_t light; // index into RfLights, or RF_NO_LIGHT
    uint8_t flat;   // 1: the shading normal is the geometric normal
    uint8_t far;    // 1: hits are checked in doubles (trace/tracer.h)
    uint8_t mirror; // index into RfMirrors, or RF_NO_MIRROR
    uint8_t placed; // 1: of a placement; ng points to the front side, but need not be along e1 × e2
    float offset;   // ray offset for hits interpolated from its vertices (rf_ray_offset)
} RfTriangleRecord;

// What tracers begin with.
typedef struct RfTracerRecords
{
    const RfTriangleRecord* records;
    uint32_t count;  // further triangles are those of placements
    uint32_t moving; // the first of those that move; RF_MISS: none does
    bool placed;     // there are placements
} RfTracerRecords;

static inline const RfTracerRecords* rf_tracer_records( const RfTracer* tracer )
{
    return (const RfTracerRecords*)(const void*)tracer;
}

static inline bool rf_tracer_has_placements( const RfTracer* tracer ) { return rf_tracer_records( tracer )->placed; }

const RfTriangleRecord* rf_place_triangle_record( const RfTracer* tracer, uint32_t triangle, RfTriangleRecord* place );
uint32_t rf_placed_material( const RfTracer* tracer, uint32_t triangle );
uint32_t rf_placed_light( const RfTracer* tracer, uint32_t triangle );

// The record of a triangle: among those of the tracer, or made at `place`, which costs about a tenth of a ray.
static inline const RfTriangleRecord* rf_triangle_record( const RfTracer* tracer, uint32_t triangle, RfTriangleRecord* place )
{
    const RfTracerRecords* known = rf_tracer_records( tracer );
    return triangle < known->count ? known->records + triangle : rf_place_triangle_record( tracer, triangle, place );
}

static inline bool rf_is_moving( const RfTracer* tracer, uint32_t triangle )
{
    return triangle >= rf_tracer_records( tracer )->moving && triangle != RF_MISS;
}

static inline uint32_t rf_triangle_material( const RfTracer* tracer, uint32_t triangle )
{
    const RfTracerRecords* known = rf_tracer_records( tracer );
    return triangle < known->count ? known->records[triangle].material : rf_placed_material( tracer, triangle );
}

// The light that a triangle is, or RF_NO_LIGHT: of those of placements, some that move.
static inline uint32_t rf_triangle_light( const RfTracer* tracer, uint32_t triangle )
{
    const RfTracerRecords* known = rf_tracer_records( tracer );
    return triangle < known->count ? known->records[triangle].light : rf_placed_light( tracer, triangle );
}

// The flat mirror that it belongs to, or RF_NO_MIRROR: none for placements.
static inline unsigned rf_triangle_mirror( const RfTracer* tracer, uint32_t triangle )
{
    const RfTracerRecords* known = rf_tracer_records( tracer );
    return triangle < known->count ? known->records[triangle].mirror : RF_NO_MIRROR;
}

// Where a ray hits a triangle, in world space, and its ray offset there.
typedef struct RfHitPoint
{
    RfVec3 p;
    float offset;
} RfHitPoint;

// Beyond this ratio of the triangle's ray offset to that of a hit the hit is computed from its ray, in doubles.
// Up to there interpolated points serve, which cost less.
#define RF_OFFSET_RATIO 16.0f
#define RF_NEAR_LIMIT ( 1e6f / RF_OFFSET_RATIO ) // coordinates over ray offset: rf_ray_offset

// The hit of a ray o + t d on a triangle that reaches much further than ray and hit.
RfHitPoint rf_hit_far_triangle( const RfTriangleRecord* triangle, RfVec3 o, RfVec3 d, RfHitPoint interpolated );

// Whether a point lies so near the origin that a triangle's ray offset is far too large there. Mostly the first
// comparison decides.
static inline bool rf_is_near( RfVec3 p, float limit )
{
    return fabsf( p.x ) < limit && fabsf( p.y ) < limit && fabsf( p.z ) < limit;
}

// The hit of a ray on a triangle, at these barycentrics by Embree.
static inline RfHitPoint rf_hit_point( const RfTriangleRecord* t, float u, float v, RfVec3 o, RfVec3 d )
{
    RfHitPoint hit = { rf_add( t->p0, rf_add( rf_scale( t->e1, u ), rf_scale( t->e2, v ) ) ), t->offset };
    float limit = t->offset * RF_NEAR_LIMIT;
    return rf_is_near( hit.p, limit ) && rf_is_near( o, limit ) ? rf_hit_far_triangle( t, o, d, hit ) : hit;
}

// Thin panes are surfaces like any others to the first three queries.
//
// Nearest hits of `count` rays o + t d, t > 0: triangle number (scene/placement.h; RF_MISS if there is none) and
// barycentrics. `coherent` is a hint for the traversal. Alpha-blended surfaces are hit
// stochastically, with alpha as the probability; the random number is a hash of the ray.
void rf_trace_nearest( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], bool coherent,
                       uint32_t* triangle, float* u, float* v );

// Transmittance of the segments from o to o + d: 1 if unoccluded, 0 if occluded, in between
// behind alpha-blended surfaces.
void rf_trace_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float* visible );

// Transmittance of segments from a common origin to points, in packets
// (src/reuse/estimators.md, section 8). Only points with weight > 0 are tested; their weight
// is multiplied by the transmittance. Returns the number of tested points.
int rf_trace_from_origin( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], float* weight );

// The same three queries, but straight rays and segments pass thin panes
// (src/reuse/estimators.md, section 11). Rays pass with the probability q of the transmitted lobe, by a hash
// of ray and triangle, or hit the pane. Segments are open if all on them are panes or blended; panes do not
// count in their transmittance.

// The panes passed: the products of q and, per channel, of κ = T / q, the weight of a ray that passes by
// chance. 1 without panes. A pane that is alpha-blended counts here as a whole.
typedef struct RfPaneLanes
{
    float* probability;
    float* weight[3];
    uint32_t* first; // of segments from eyes: the triangle of the pane that comes first, RF_MISS without any; NULL: not asked for
} RfPaneLanes;

void rf_trace_nearest_past_panes( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                                  uint32_t* triangle, float* u, float* v, const RfPaneLanes* panes );
void rf_trace_segments_past_panes( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                                   float* visible, const RfPaneLanes* panes );
// Rays that pass all thin panes for sure.
void rf_trace_nearest_through_panes( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                                     uint32_t* triangle, float* u, float* v, const RfPaneLanes* panes );
int rf_trace_from_origin_past_panes( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], float* weight,
                                     const RfPaneLanes* panes );

// Whether points in the planes of mirrors lie inside of the mirrors' outlines: rays from a common
// origin to points beyond the first mirror, whatever else is in the way, hit mirror[i] first.
// Only points with weight > 0 are tested; the others' weight becomes 0. `hit` gets the points on the mirrors, and
// `triangle` the triangles of these.
void rf_trace_mirrors( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], const uint8_t* mirror,
                       float* const hit[3], uint32_t* triangle, float* weight );

// Enables flush-to-zero and rounding to nearest for the calling thread. Call at the start of main and of every
// parallel region, so that results do not depend on the thread.
void rf_set_float_mode( void );

// Tracers that share all but the light with another.

// A tracer under some of its lights alone: since light is linear, pictures by it sum to the picture under all of them, and with the
// same random numbers they do so to rounding.
typedef struct RfRelitTracer RfRelitTracer;

// Whether a light of the tracer stays lit.
typedef bool RfIsLit( void* user, uint32_t light );

// For a tracer that paths of one frame are traced with; it must outlive this one. All but the light is shared, lights are selected
// with the same probabilities, and nothing moves in its scene. Fails with RF_ERROR_MEMORY.
RfResult rf_create_relit_tracer( const RfTracer* tracer, RfIsLit* is_lit, void* user, RfRelitTracer** relit, RfError* error );
void rf_destroy_relit_tracer( RfRelitTracer* relit );

const RfTracer* rf_relit_tracer( const RfRelitTracer* relit );

// A tracer whose lights that hold are split by light groups (light/light.h). The other must outlive it. Fails with RF_ERROR_MEMORY.
RfResult rf_create_split_tracer( const RfTracer* tracer, const RfLightGroups* groups, RfTracer** split, RfError* error );
// NULL is allowed.
void rf_destroy_split_tracer( RfTracer* split );

#endif
