// What is left to do of a render that is to reach a noise or a flicker: the stop rule gone through to the end of the path,
// with the estimates as they are likely to be. Numbers alone, as the rule.
#ifndef REFRAME_RENDER_FORECAST_H
#define REFRAME_RENDER_FORECAST_H

#include "render/stop_pool.h"

// A frame of the forecast.
typedef struct RfForecastFrame
{
    bool asked, expects;
    int passes;
    double weight, shared; // shared with the frame after it
    RfExpected expected;
} RfForecastFrame;

// Foretells stop->work_left after an estimate; `frames` is room for all of the path, of which `asked` is filled in.
void rf_forecast( RfStop* stop, const RfNoiseEstimates* look, int done, RfForecastFrame* frames );

#endif
