// The sequences of `reframe report`, folders or patterns, and their frames on the page: pictures, passes, values for the probe, error
// and flicker.
//
// The blocks of a frame on the page:
//   s<track>-<number>          the picture, see page/picture.h
//   v<track>-<number>          scene values, see page/page.h
//   l<track>-<layer>-<number>  a pass, as a picture
//   n<track>-<layer>-<number>  which name of a Cryptomatte covers most of each pixel of its picture: runs of pixels from the top left
//                              on, the name (from 1 on; 0: none) and the length, 16 bits each, little-endian
#ifndef REFRAME_CLI_REPORT_REPORT_FRAMES_H
#define REFRAME_CLI_REPORT_REPORT_FRAMES_H

#include "cli/options/frame_lists.h"
#include "cli/view/view.h"
#include "image/exr.h"
#include "measure/flicker.h"
#include "measure/image_error.h"
#include "page/page.h"
#include "page/pass_groups.h"

#include <jansson.h>

typedef struct RfPageSequence
{
    char name[256];    // for people: the folder's name
    const char* layer; // as of rf_read_exr_layer; NULL: the colour
    char layer_text[RF_PASS_LAYER_SIZE];
    RfSequenceInput input;         // of a single file the frame 1
    char first[RF_FILE_NAME_SIZE]; // the file of its first frame
    bool is_reference;
    RfExrHeader header; // of the first file
    json_t* render;     // of `render --json`, or NULL
} RfPageSequence;

typedef struct RfPageLayers
{
    RfFilePasses passes; // of the first file; those that are shown come first
    int count;           // of these
    RfLookRange* ranges; // of each
    RfMatteNames* names; // of each that is a Cryptomatte; the others have none
    int factor;          // pictures are smaller by it
    int width, height;
    double bits; // per pixel, at most
} RfPageLayers;

// Figures of a frame of the page; NaN: not known.
typedef struct RfPageFrame
{
    bool shown;      // its picture is in the page
    bool has_layers; // and those of its passes
    double relmse;   // against the reference, or an estimate
    bool at_least;   // the estimate is a lower bound only
    double seconds;
    double samples, effective; // traced per pixel; landed in a pixel
    double phi, f1;            // of this frame and the one before; relative
    size_t bad;                // pixels with NaN or infinity
} RfPageFrame;

// A sequence of the page.
typedef struct RfPageTrack
{
    RfPageSequence sequence;
    struct RfPageRun* run;
    const struct RfPageTrack* reference; // or NULL: none, or this is the reference
    int index;                           // on the page

    RfPageLayers layers;
    RfPageFrame* frames; // of the page
    int* missing;        // numbers of its frames, and of the holes between them, that the sequence lacks, ascending
    int missing_count;
    int picture_width, picture_height;
    int value_factor;                  // scene values are means of boxes of so many pixels; 0: none
    uint64_t picture_bytes;            // before base64
    uint64_t value_bytes, layer_bytes; // of the page
    bool compensated;                  // of the flicker without reference: along the motion
    RfFlickerSums flicker;
    RfErrorMetrics error; // of all frames, against the reference
    bool has_error;
    double estimate; // mean of the estimates of relMSE; NaN: none
} RfPageTrack;

#define RF_PAGE_MOST_SEQUENCES 8 // on one page, without the reference

// A run of `report`: what was asked for, and what goes to the page.
typedef struct RfPageRun
{
    const char* places[RF_PAGE_MOST_SEQUENCES];
    int place_count;
    const char* output;
    const char* reference; // this and the next may be NULL
    const char* layer;     // NULL: the colour
    const char* reference_layer;
    const char* render_file;
    const char* frame_list;
    const char* title;
    RfFps fps;
    RfViewOptions view;
    int width;             // pictures are no wider; 0: as they are
    size_t values, passes; // bytes of the page that scene values and pictures of passes may take
    bool overwrite, quiet;
    const char* json;

    RfPageTrack tracks[RF_PAGE_MOST_SEQUENCES + 1]; // the reference is the last
    int track_count;
    int* numbers; // of the page's frames, ascending
    int count;
    int* holes; // between them, that no sequence has
    int hole_count;
    RfViewText shown;     // as chosen; without a transform: by the sRGB curve
    int done, all;        // pictures
    char own_title[1024]; // where none is given
} RfPageRun;

// Finds the only sequence of a folder, or the one that `place` names by #### or as a single file, and the JSON of `render` in its
// folder. rf_free_page_track in any case.
RfResult rf_open_page_sequence( const char* place, const char* layer, RfPageSequence* sequence, RfError* error );

// Is the frame there?
bool rf_has_page_frame( const RfPageSequence* sequence, int frame );

// What the page shows of the data window, in its pixels: what lies in the display window, without overscan; all where nothing does.
RfExrWindow rf_page_window( const RfExrHeader* header );

// Adds the frames that an open sequence has to the page. rf_free_page_track in any case.
RfResult rf_add_page_track( RfPage* page, RfPageTrack* track, RfError* error );
void rf_free_page_track( RfPageTrack* track );

// The id of a frame's picture.
void rf_page_block_id( const RfPageTrack* track, int number, char id[32] );

// { name, look, group, low, high, width, height, names } of each pass that is shown.
json_t* rf_page_layers_json( const RfPageLayers* layers );

// Whether there are light groups, all of them on the page: their sum is the picture.
bool rf_has_page_mix( const RfPageLayers* layers );

#endif
