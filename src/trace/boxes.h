// Internal to this folder: boxes around what moves. Rays that miss them need not be traced through it.
#ifndef REFRAME_TRACE_BOXES_H
#define REFRAME_TRACE_BOXES_H

#include "scene/scene.h"

#include <stdbool.h>
#include <stdint.h>

// Objects beyond as many share boxes, those that follow each other in the scene first.
#define RF_MOST_BOXES 4

typedef struct RfBoxes
{
    int count;                                           // of boxes that are not empty
    float low[RF_MOST_BOXES][3], high[RF_MOST_BOXES][3]; // widened by the error of floats
} RfBoxes;

RfBoxes rf_no_boxes( void );

// Adds what moves in a posed scene, while its shutter is open, in the world multiplied by `scale`.
void rf_add_moving_boxes( const RfScene* posed, float scale, RfBoxes* boxes );
// To be called when all is added.
void rf_finish_boxes( RfBoxes* boxes );

// Both are conservative: rays that miss a box by less than the error of floats count as meeting it.

#define RF_BOX_LANES 16

// Sets near[i] to −1 for those of RF_BOX_LANES rays o + t d, 0 < t < far, that meet a box and whose valid[i] is −1; to 0 for the others.
// Returns whether there are any.
bool rf_find_near_lanes( const RfBoxes* boxes, const float* const o[3], const float* const d[3], const float* far,
                         const int* valid, int* near );

#define RF_BOX_BLOCK 256

// Lists those rays o + t d, 0 < t < length, of up to RF_BOX_BLOCK that meet a box and are not marked in `touched`. Returns how many.
int rf_list_near_rays( const RfBoxes* boxes, int count, const float* const o[3], const float* const d[3], float length,
                       const uint8_t* touched, int32_t near[RF_BOX_BLOCK] );

#endif
