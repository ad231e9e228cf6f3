// Light that is kept apart from the rest of what paths find, for the frame of its path alone (src/reuse/estimators.md): where
// something moves, that of paths which it touches in some frame of the group (section 18); without caustics, these (section 19).
#ifndef REFRAME_PATH_OWN_LIGHT_H
#define REFRAME_PATH_OWN_LIGHT_H

#include "bsdf/bsdf.h"
#include "path/mis.h"

// What the paths of a wavefront find of it, by slot.
typedef struct RfOwnLight
{
    RfArrivals arrivals;
    RfArrivals* of_groups;     // with RfPathSettings.grouped: of light groups, by base part (light/light.h) from 1 on
    uint8_t touched[RF_LANES]; // 1: what moves touches the path as far as it is traced. Its first vertex does not count
    // Caustics are kept apart, and nothing moves. `touched` is 1 then where the path has thrown caustics at all vertices since it
    // came by one that does not; emission that its ray hits is a caustic.
    bool caustics;
    uint8_t seen[RF_LANES]; // 1: all vertices throw caustics or are of glass: what the path finds, the camera sees by them
} RfOwnLight;

static inline RfArrivals* rf_own_arrivals( RfOwnLight* own, int base )
{
    return base == 0 ? &own->arrivals : own->of_groups + base - 1;
}

// Whether what lane i of a model sends on falls on other surfaces as a caustic: of mirrors, of glass without a base, and of metals
// up to RF_CAUSTIC_ALPHA. A function of the vertex alone.
static inline bool rf_throws_caustics( const RfVertexLanes* v, RfBsdfKind kind, int i )
{
    float base = v->param[RF_PARAM_DIFFUSE][i] + v->param[RF_PARAM_DIFFUSE + 1][i] + v->param[RF_PARAM_DIFFUSE + 2][i];
    switch ( rf_bsdf_model( kind )->caustics )
    {
        case RF_CAUSTICS_NEVER: break;
        case RF_CAUSTICS_OF_METAL: return base == 0.0f && v->param[RF_PARAM_SHAPE][i] <= RF_CAUSTIC_ALPHA;
        case RF_CAUSTICS_OF_GLASS: return base == 0.0f || v->param[RF_PARAM_IOR][i] == 0.0f; // mirrors have no base
    }
    return false;
}

// Begins paths at slots [0, count) from the camera, with caustics kept apart.
void rf_begin_caustics( int count, RfOwnLight* own );

// Sets own->touched and own->seen for the rays that leave vertices, scattered with these densities.
void rf_note_caustics( const RfVertexLanes* vertices, const float* pdf, RfOwnLight* own );

// Sets touched[i] to 1 where what vertex i gets from light samples is a caustic, else to 0. Before the vertices are scattered from.
void rf_find_lit_caustics( const RfOwnLight* own, const RfVertexLanes* vertices, uint8_t* touched );

// Marks the slots of rays that meet what moves on their way to the vertices they hit, or to the sky, and of those that hit what
// moves. `triangle`: by ray, what it hit. Slots that are marked already are not tested.
void rf_touch_by_rays( const RfTracer* tracer, const RfRayLanes* rays, const RfVertexLanes* vertices, const uint32_t* triangle,
                       uint8_t* touched );

// Segments o + t d, 0 < t < length: sets touched[k] where what moves touches one that is open, at visible[k] > 0; else to 0.
void rf_touch_by_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float length,
                           const float* visible, uint8_t* touched );

// Moves the lanes that are touched from one set to the other.
void rf_split_arrival( const uint8_t* touched, int count, RfArrivalLanes* held, RfArrivalLanes* own );

// Whether any light arrives at lanes [first, end).
bool rf_any_arrives( const RfArrivalLanes* arrival, int first, int end );

#endif
