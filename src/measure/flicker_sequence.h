// Reads frames for flicker from EXR files of any program: the colour as in rf_read_exr_layer,
// and the layers for motion compensation under their usual names, in any part; those in the
// part with the colour take precedence.
//   motion    X and Y of a layer "motion" (Reframe) or "Vector" (Blender)
//   depth     Z of a layer "depth" or "Depth", V of "Depth", or Z alone
//   variance  R, G, B of a layer "variance" (Reframe)
// Each may be prefixed by a view layer, as in "ViewLayer.Vector.X", or be a part of its own
// whose name is that of the layer.
#ifndef REFRAME_MEASURE_FLICKER_SEQUENCE_H
#define REFRAME_MEASURE_FLICKER_SEQUENCE_H

#include "image/exr.h"
#include "measure/flicker.h"

// Channel names; they point into the header in which they were found.
typedef struct RfFlickerLayers
{
    const char* colour;      // as in rf_read_exr_layer; NULL: the colour
    bool may_lack;           // layers missing from a frame are skipped; else they are an error
    const char* motion[2];   // X, Y; NULL: none
    const char* depth;       // NULL: none
    const char* variance[3]; // NULL: none
} RfFlickerLayers;

// Selects motion and depth of a file. `motion` ("backward.u,backward.v") and `depth` name
// channels that must exist; NULL selects the usual names. Several candidates are an error
// whose message says how to choose. Clears the other fields. `path` is for messages.
RfResult rf_find_flicker_layers( const char* path, const RfExrHeader* header, const char* motion, const char* depth,
                                 RfFlickerLayers* layers, RfError* error );

// Selects the variance and leaves the other fields alone.
RfResult rf_find_variance_layers( const char* path, const RfExrHeader* header, RfFlickerLayers* layers, RfError* error );

// Reads the colour of a frame into `signal` (not marked finite yet), its layers and its
// camera. The data window of the colour and of the layers must equal that of `first`, the
// header of an earlier file `first_path`; with `may_lack`, layers with another window are
// skipped.
RfResult rf_read_flicker_frame( const char* path, const RfFlickerLayers* layers, const RfExrHeader* first, const char* first_path,
                                RfFlickerFrame* frame, RfError* error );

// True if both frames have all of the selected layers, so that they can be compared.
bool rf_has_flicker_layers( const RfFlickerLayers* layers, const RfFlickerFrame* now, const RfFlickerFrame* before );

// Reads a reference image (`layer` as in rf_read_exr_layer), whose data window must equal that
// of `first`.
RfResult rf_read_aligned( const char* path, const char* layer, const RfExrHeader* first, const char* first_path, RfImage* image,
                          RfError* error );

#endif
