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
#include "measure/image_error.h"

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

// Reads group, spp, frame number and number of frames from the header of a file by Reframe.
// `number` is the frame's in the sequence, whose last frame ends the path where the header does
// not say; of a path with cuts they are those of the frame's shot. There are no seams (rf_has_seams) where the file is another
// program's or has no groups.
RfSeams rf_read_seams( const char* path, int number, int last );

// Sums over the pairs, of all and of those inside and at the border of groups.
typedef struct RfFlickerParts
{
    RfFlickerSums all, inside, border;
} RfFlickerParts;

// A frame and the one before.
typedef struct RfFlickerPair
{
    int frame; // number of the later one
    bool border;
    bool is_followed; // with `follows`; else its frames lack the layers
    RfFlickerSums sums, followed;
} RfFlickerPair;

#define RF_FLICKER_NAME_SIZE 4096

// The measurement of a sequence, frame by frame. All zero but for what is asked for.
typedef struct RfFlickerRun
{
    // what is measured
    const char* pattern;
    const char* reference;       // a pattern; NULL: none
    const char* reference_layer; // as in rf_read_exr_layer
    const int* frames;           // numbers, the caller's
    int frame_count;
    int period;        // of consecutive groups, counted from frame `first_frame` on; 0: the groups of the files
    int first_frame;   // of the whole sequence
    bool has_spectrum; // keeps RF_SPECTRUM_FRAMES frames
    bool follows;      // the error in place, and beside it along the motion; else along the motion where `layers` has one
    RfFlickerLayers layers;
    RfExrHeader first;                          // of the first frame: all have its data window
    RfSlitScan* slit;                           // gets a column of each frame, and of the reference's; or NULL
    int column;                                 // from 0
    void ( *progress )( void* user, int done ); // after each frame; may be NULL
    void* user;
    char first_path[RF_FLICKER_NAME_SIZE]; // as opened
    // what is found
    RfFlickerPair* pairs;
    int pair_count;
    RfFlickerParts plain, followed; // the second: with `follows`
    RfSpectrumSums spectrum;
    int window;   // frames of each window of the spectrum
    double split; // upper end of its slow band, cycles per frame
    int cuts;     // between shots, which are not compared
    bool has_seams;
    RfErrorMetrics errors; // of all frames; without a reference only the counts mean something
    // while it runs
    RfSeams seams;
    RfErrorSummary summary;
    RfFlickerFrame ring[RF_SPECTRUM_FRAMES]; // frame i at i modulo the number of them
    int ring_size;
} RfFlickerRun;

// Are the main figures those along the motion?
static inline bool rf_is_compensated( const RfFlickerRun* run ) { return !run->follows && run->layers.motion[0] != NULL; }

// Checks that the frames are at least two and consecutive, and that the reference has them; names the first one. Then the caller
// reads its header and chooses layers.
RfResult rf_open_flicker_run( RfFlickerRun* run, RfError* error );

// Goes through the frames. NaN and infinite pixels are counted, and do not fail.
RfResult rf_measure_flicker_run( RfFlickerRun* run, RfError* error );

// Frees what the run holds, also after a failure.
void rf_close_flicker_run( RfFlickerRun* run );

#endif
