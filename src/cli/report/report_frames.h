// Passes of a sequence on the page, as pictures.
#ifndef REFRAME_CLI_REPORT_REPORT_FRAMES_H
#define REFRAME_CLI_REPORT_REPORT_FRAMES_H

#include "cli/report/report_input.h"
#include "page/matte_names.h"
#include "page/passes.h"
#include "page/page.h"
#include "measure/image_error.h"
#include "measure/flicker.h"

#include <jansson.h>

#define RF_PAGE_LAYER_BYTES 16e6 // of all passes of the page; pictures are made smaller to stay below,

#define RF_PAGE_LAYER_WIDTH 160 // and passes are left out where they would become narrower, unless frames are

typedef struct RfPageLayers
{
    RfFilePasses passes; // of the first file; those that are shown come first
    int count;           // of these
    RfLookRange* ranges; // of each
    RfMatteNames* names; // of each that is a Cryptomatte; the others have none
    char left_out[512];  // names of the others; "": all are shown
    int factor;          // pictures are smaller by it
    int width, height;
    double bits; // per pixel, at most
} RfPageLayers;

// { name, look, group, low, high, factor, width, height } of each, of Cryptomattes also names.
json_t* rf_page_layers_json( const RfPageLayers* layers );

// Whether there are light groups, all of them on the page: their sum is the picture.
bool rf_has_page_mix( const RfPageLayers* layers );

// Adds the frames of a sequence to the page: pictures, error, flicker.

// Figures of a frame of the page; NaN: not known.
typedef struct RfPageFrame
{
    bool has_layers;        // pictures of its passes
    bool shown;             // its picture is in the page
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

typedef struct RfPageTrack
{
    const RfPageSequence* sequence;
    const RfPageSequence* reference; // or NULL: none, or this is the reference
    int index;                       // of the sequence on the page
    int width;                       // pictures are no wider; 0: as they are
    const int* numbers;              // of the page's frames
    int count;
    const int* holes; // between them, that no sequence has
    int hole_count;
    int value_factor;   // scene values are means of boxes of so many pixels; 0: none
    double layer_share; // bytes of the page for pictures of passes

    RfPageLayers layers;
    RfPageFrame* frames; // `count` of them
    char damage[512];    // what is wrong with the first of those that are damaged
    int picture_width, picture_height;
    uint64_t picture_bytes;
    bool compensated, has_variance; // of the flicker without reference
    RfFlickerSums flicker;
    RfFlickerSums followed; // against a reference: the same along the motion, where there are layers
    bool follows;
    int pair_count;       // neighbours that are there, also where they lack the layers
    RfErrorMetrics error; // of all frames, against the reference
    bool has_error;
    uint64_t value_bytes, layer_bytes; // of the page
    int fine_frame, fine_factor;       // number of the frame with finer values, and their factor; 0: none
    double estimate;                   // mean of the estimates of relMSE; NaN: none
} RfPageTrack;

// Adds the frames that the sequence has to the page; `progress` is called after each
// and stops the work by false (RF_ERROR_INTERRUPTED). rf_free_page_track in any case.
typedef bool RfPageProgressFn( void* user );
RfResult rf_add_page_track( RfPage* page, RfPageTrack* track, RfPageProgressFn* progress, void* user, RfError* error );
void rf_free_page_track( RfPageTrack* track );

// The frames of the page, and the holes between them, that the sequence lacks, ascending, *count of
// them. The caller frees it; NULL: none, or no memory.
int* rf_page_missing_frames( const RfPageTrack* track, int* count );

// The numbers of the frames whose files are not whole.
json_t* rf_page_damaged_json( const RfPageTrack* track );

// The same as a line, with what is wrong with the first; false where there are none.
#define RF_DAMAGE_SIZE 800
bool rf_format_damage( const RfPageTrack* track, char text[RF_DAMAGE_SIZE] );

// The id of a frame's block.
void rf_page_block_id( const RfPageTrack* track, int number, char id[32] );

// The blocks of a frame on the page: what a person looks at.
//   s<track>-<number>          the picture, see page/picture.h
//   v<track>-<number>          scene values, see page/page.h
//   w<track>-<number>          finer ones, of one frame
//   l<track>-<layer>-<number>  a pass, as a picture
//   n<track>-<layer>-<number>  which name of a Cryptomatte covers most of each pixel of its picture: runs of pixels from the top left
//                              on, the name (from 1 on; 0: none) and the length, 16 bits each, little-endian

// Adds scene values of a frame at a factor of its own.
RfResult rf_add_page_fine_values( RfPage* page, RfPageTrack* track, int number, int factor, RfError* error );

#endif
