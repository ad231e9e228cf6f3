// render --preview: the frame in work as a PNG, or everything on a live page.
#ifndef REFRAME_CLI_RENDER_PREVIEW_OUTPUT_H
#define REFRAME_CLI_RENDER_PREVIEW_OUTPUT_H

#include "page/picture.h"
#include "reframe/image.h"
#include "reframe/output.h"

#include <jansson.h>
#include <pthread.h>

typedef struct RfLivePreview
{
    const char* file;       // NULL: none
    const RfOutput* output; // of the live page
    bool broken;            // the file could not be written
    bool serving;
    int port; // where it is served
    struct MHD_Daemon* daemon;
    pthread_mutex_t mutex; // of all below
    RfImage image;         // of the frame in work
    int frame;             // its number
    double spp;
    int version;    // counts the pictures
    double encoded; // seconds that it took to encode one for the page
    double taken;   // when the last was taken
    RfProgress progress;
    int* finished; // numbers of frames
    int finished_count;

    // Of the thread of the page alone, once a frame is finished.
    json_t* passes;      // of its file: [ { name, light } ]
    RfLookRange* ranges; // of each, by the first frame that was asked for; low is NaN before
} RfLivePreview;

// Begins as the option says; NULL: there is no preview. `frames`: in all, to be finished. `output` must stay. Fails with RF_ERROR_IO
// where the file or the port cannot be used.
RfResult rf_start_preview( const char* option, const RfOutput* output, int frames, RfLivePreview* preview, RfError* error );
void rf_stop_preview( RfLivePreview* preview );

// `number`: of the frame. Fails where the file cannot be written, the first time only.
RfResult rf_take_preview( RfLivePreview* preview, const RfPreview* picture, int number, int threads, RfError* error );
void rf_note_live_progress( RfLivePreview* preview, const RfProgress* progress );
void rf_note_live_frame( RfLivePreview* preview, int number );

#endif
