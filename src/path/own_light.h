// Light that holds in the frame of its path alone: something that moves touches the path in some frame of the group. All other
// light is the same in every frame, and shared (src/reuse/estimators.md, section 18).
#ifndef REFRAME_PATH_OWN_LIGHT_H
#define REFRAME_PATH_OWN_LIGHT_H

#include "path/mis.h"

// What the paths of a wavefront find of it, by slot.
typedef struct RfOwnLight
{
    RfArrivals arrivals;
    uint8_t touched[RF_LANES]; // 1: what moves touches the path as far as it is traced. Its first vertex does not count
} RfOwnLight;

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
