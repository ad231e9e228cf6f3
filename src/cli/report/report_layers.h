// AOVs of a sequence on the page, as pictures: those that the files have under the usual names.
#ifndef REFRAME_CLI_REPORT_REPORT_LAYERS_H
#define REFRAME_CLI_REPORT_REPORT_LAYERS_H

#include "cli/report/report_input.h"
#include "page/layer_picture.h"
#include "page/page.h"

#define RF_PAGE_MOST_LAYERS 7
#define RF_PAGE_LAYER_BYTES 16e6 // of all AOVs of the page; pictures are made smaller to stay below

typedef struct RfPageLayer
{
    const char* name; // "albedo"
    RfLook look;
    const char* channels[3]; // full names; they point into the sequence's header
    RfLookRange range;
} RfPageLayer;

typedef struct RfPageLayers
{
    RfPageLayer layers[RF_PAGE_MOST_LAYERS];
    int count;
    int factor; // pictures are smaller by it
    int width, height;
    double bits; // per pixel, at most
} RfPageLayers;

// Finds the AOVs of the first file, and the ranges of their values in `typical`. `pictures` is the number
// of frames that the AOVs of this sequence will have, `share` its part of RF_PAGE_LAYER_BYTES.
void rf_find_page_layers( const RfPageSequence* sequence, const char* typical, int pictures, double share, RfPageLayers* layers );

// Adds their pictures of a frame; *added is false where its file lacks one of them.
RfResult rf_add_page_layers( RfPage* page, const RfPageLayers* layers, int track, int number, const char* path, bool* added,
                             RfError* error );

// { name, look, low, high, factor, width, height } of each.
json_t* rf_page_layers_json( const RfPageLayers* layers );

#endif
