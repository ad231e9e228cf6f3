// The light of a batch in one pass of the picture (reuse/harvest/passes.h), towards a camera.
#ifndef REFRAME_REUSE_ACCUMULATE_PASS_LIGHT_H
#define REFRAME_REUSE_ACCUMULATE_PASS_LIGHT_H

#include "reuse/accumulate/accumulate.h"

// Sets s->whole, of a batch with all of its light and, of glossy hits, s->sum; and clears s->emission and s->direct.
void rf_begin_pass_light( const RfHitBatch* lit, RfAccumulateScratch* s );

// Adds emission of hits and direct light of diffuse ones, times the scale of their part.
void rf_add_pass_light( const RfHitBatch* lit, const RfPassLight* light, RfVec3 scale, RfAccumulateScratch* s );

// Sets the light of one of RF_PASS_AOVS: s->pass, and of glossy hits s->sum.
void rf_light_pass( const RfHitBatch* lit, RfAov pass, RfAccumulateScratch* s );

#endif
