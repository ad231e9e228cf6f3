// Frames for flicker from EXR files of any program: colour as rf_read_exr_layer finds
// it, and the layers that follow motion, by the names that they usually have, in
// whichever parts: those of the colour's part before others.
//   motion    X and Y of a layer "motion" (Reframe) or "Vector" (Blender)
//   depth     Z of a layer "depth" or "Depth", V of "Depth", or Z alone
//   variance  R, G, B of a layer "variance" (Reframe)
// each also behind the name of a view layer, as in "ViewLayer.Vector.X", or with the
// part's name as that of the layer.
#ifndef REFRAME_MEASURE_FLICKER_READ_H
#define REFRAME_MEASURE_FLICKER_READ_H

#include "image/exr.h"
#include "measure/follow.h"

// Names of channels, in the header that they were found in.
typedef struct RfFlickerLayers
{
    const char* colour;      // as of rf_read_exr_layer; NULL: the colour
    bool may_lack;           // what a frame does not have is left out; else it is an error
    const char* motion[2];   // X, Y: NULL where there are none
    const char* depth;       // NULL: none
    const char* variance[3]; // NULL: none
} RfFlickerLayers;

// Picks motion and depth of a file. `motion` ("backward.u,backward.v") and `depth` name
// channels that must be there; NULL: by the usual names. More than one of a kind
// is an error, which says how to choose. Clears the others. `path` is for messages.
RfResult rf_find_flicker_layers( const char* path, const RfExrHeader* header, const char* motion, const char* depth,
                                 RfFlickerLayers* layers, RfError* error );

// Picks the variance, and leaves the others.
RfResult rf_find_variance_layers( const char* path, const RfExrHeader* header, RfFlickerLayers* layers, RfError* error );

// A frame's colour in `signal` (not finite unless told), its layers and camera.
// The data window, of the layers too, must be that of `first`, a file before it by the
// name `first_path`; with `may_lack` layers of another one are left out.
RfResult rf_read_flicker_frame( const char* path, const RfFlickerLayers* layers, const RfExrHeader* first, const char* first_path,
                                RfFlickerFrame* frame, RfError* error );

// Have these two frames what is among the layers, so that they can be held against each other?
bool rf_has_flicker_layers( const RfFlickerLayers* layers, const RfFlickerFrame* now, const RfFlickerFrame* before );

// Reads a reference's image (`layer` as of rf_read_exr_layer), whose data window must be that of `first`.
RfResult rf_read_aligned( const char* path, const char* layer, const RfExrHeader* first, const char* first_path, RfImage* image,
                          RfError* error );

#endif
