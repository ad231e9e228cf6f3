// All hit records of a group at once, as the frame-reuse paper has them (settings.hold_all).
#ifndef REFRAME_RENDER_HELD_RECORDS_H
#define REFRAME_RENDER_HELD_RECORDS_H

#include "render/renderer.h"

// Sets sizes.held for the frames asked for, by tracing the camera rays of each group. Fails with
// RF_ERROR_MEMORY where the system has no room for a batch.
RfResult rf_count_held( RfRenderer* renderer, RfError* error );

// Renders a group: all its passes are traced and their records serialised, then all are accumulated.
RfResult rf_render_held( RfRenderer* renderer, const RfEstimatorGroup* estimator_group, const RfGroup* group, RfError* error );

#endif
