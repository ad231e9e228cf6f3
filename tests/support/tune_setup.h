// What the tests of tuning share: a room, a short path, a job.
#ifndef REFRAME_TESTS_TUNE_SETUP_H
#define REFRAME_TESTS_TUNE_SETUP_H

#include "measure/tune_rows.h"
#include "support/scene_builder.h"

#define TUNE_EYES 48
#define TUNE_WIDTH 16
#define TUNE_HEIGHT 12

typedef struct TuneSetup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[TUNE_EYES];
    int frames[TUNE_EYES];
    RfRenderSettings settings;
    RfTuneJob job;
} TuneSetup;

// A job of the first `eyes` frames, with 256 MiB and 2 threads; to be ended.
void begin_tune_setup( TuneSetup* s, int eyes, int spp );
void end_tune_setup( TuneSetup* s );

// Rows that are not left out.
int tune_rows_tried( const RfTune* tune );

#endif
