// What a render to an error or a flicker will take, for `plan`.
#ifndef REFRAME_CLI_TUNE_FORETELL_H
#define REFRAME_CLI_TUNE_FORETELL_H

#include "measure/cost.h"

#include <jansson.h>

// The samples of the harder of the goals of job->settings, and the seconds of the frames asked for, by a measured curve.
// spp is 0 where there is no goal, or more than a render can have are needed.
RfCostPrediction rf_predict_goals( const RfCostJob* job, const RfCostCurve* curve, int per_sweep );

// {"spp", "seconds"}; null where nothing is predicted.
json_t* rf_predicted_json( const RfCostPrediction* predicted );

#endif
