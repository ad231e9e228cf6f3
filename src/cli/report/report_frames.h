// Adds the frames of a sequence to the page: pictures, passes, values for the probe, error and flicker.
//
// The blocks of a frame on the page:
//   s<track>-<number>          the picture, see page/picture.h
//   v<track>-<number>          scene values, see page/page.h
//   l<track>-<layer>-<number>  a pass, as a picture
//   n<track>-<layer>-<number>  which name of a Cryptomatte covers most of each pixel of its picture: runs of pixels from the top left
//                              on, the name (from 1 on; 0: none) and the length, 16 bits each, little-endian
#ifndef REFRAME_CLI_REPORT_REPORT_FRAMES_H
#define REFRAME_CLI_REPORT_REPORT_FRAMES_H

#include "cli/report/report_input.h"
#include "cli/view/view.h"
#include "measure/flicker.h"
#include "measure/image_error.h"
#include "page/page.h"
#include "page/pass_groups.h"

#include <jansson.h>

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
    bool shown;             // its picture is in the page
    bool has_layers;        // and those of its passes
    bool damaged;           // its file is not whole; it may be shown, where its pixels can be read
    double relmse;          // against the reference, or an estimate
    bool at_least;          // the estimate is a lower bound only
    double worst_ten_share; // of the estimate: what the ten worst pixels carry
    double seconds;
    double samples, effective; // traced per pixel; landed in a pixel
    double phi, f1;            // of this frame and the one before
    size_t bad;                // pixels with NaN or infinity
    size_t clipped;            // pixels at the end of the range of the file's channels, or beyond as its header says
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
    char damage[512];    // what is wrong with the first of those that are damaged
    int picture_width, picture_height;
    int value_factor;                  // scene values are means of boxes of so many pixels; 0: none
    uint64_t picture_bytes;            // before base64
    uint64_t value_bytes, layer_bytes; // of the page
    bool compensated, has_variance;    // of the flicker without reference
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

// Adds the frames that an open sequence has to the page. rf_free_page_track in any case.
RfResult rf_add_page_track( RfPage* page, RfPageTrack* track, RfError* error );
void rf_free_page_track( RfPageTrack* track );

// The id of a frame's picture.
void rf_page_block_id( const RfPageTrack* track, int number, char id[32] );

// { name, look, group, low, high, width, height, names } of each pass that is shown.
json_t* rf_page_layers_json( const RfPageLayers* layers );

// Whether there are light groups, all of them on the page: their sum is the picture.
bool rf_has_page_mix( const RfPageLayers* layers );

// The numbers of the frames of the page, and of the holes between them, that the sequence lacks, ascending, and of those whose files
// are not whole.
json_t* rf_page_missing_json( const RfPageTrack* track );
json_t* rf_page_damaged_json( const RfPageTrack* track );

// The damaged ones as a line, with what is wrong with the first; false where there are none.
#define RF_DAMAGE_SIZE 800
bool rf_format_damage( const RfPageTrack* track, char text[RF_DAMAGE_SIZE] );

#endif
