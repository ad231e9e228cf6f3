// What is left to do of a render that is to reach a noise or a flicker: the stop rule gone through to the end of the path,
// with the estimates as they are likely to be. Numbers alone, as the rule.
#ifndef REFRAME_RENDER_FORECAST_H
#define REFRAME_RENDER_FORECAST_H

#include "reframe/error.h"
#include "render/stop_pool.h"

// A frame of the forecast.
typedef struct RfForecastFrame
{
    bool asked;
    bool expects; // `expected` is known
    int passes;
    double weight, shared; // shared with the frame after it
    RfExpected expected;
} RfForecastFrame;

typedef struct RfForecast
{
    RfForecastFrame* frames; // of the whole path; NULL: nothing is predicted
    RfFrameNoise* room;      // for those of a group
} RfForecast;

// Fails with RF_ERROR_MEMORY. Free with rf_free_forecast, also after a failure.
RfResult rf_alloc_forecast( int frames, RfForecast* forecast, RfError* error );
void rf_free_forecast( RfForecast* forecast );

// Predicts stop->work_left after an estimate. Of the frames of the path `asked` is filled in.
void rf_forecast( RfStop* stop, const RfNoiseEstimates* look, int done, RfForecast* forecast );

#endif
