// Primal, gradients and their variances from the layers of EXR files.
#ifndef REFRAME_CLI_RECONSTRUCT_INPUT_H
#define REFRAME_CLI_RECONSTRUCT_INPUT_H

#include "cli/options/sequence_input.h"
#include "reframe/image.h"
#include "reframe/reconstruct.h"

// What was asked for; NULL where it was not.
typedef struct RfReconstructFiles
{
    const char* images[2]; // a file, sequence or folder, and that of the other half
    int image_count;
    const char *frames, *primal, *dx, *dy, *variance; // of the options of these names
    const char *dx_from, *dy_from;
    RfSequenceInput inputs[4]; // images[0], images[1], dx_from, dy_from
} RfReconstructFiles;

// The data of one frame. Images of a half that is not there are empty.
typedef struct RfReconstructFrame
{
    RfExrWindow window;
    int fps_numerator; // of the first file; 0: it has none
    unsigned int fps_denominator;
    int half_count;    // 1 or 2
    bool has_variance; // of all halves
    RfImage primal[2], dx[2], dy[2];
    float* variance[2][3]; // of the primal, of dx, of dy
} RfReconstructFrame;

// Finds the frames of all inputs, and checks that what is given goes together. Free it in any case.
RfResult rf_find_reconstruct_files( RfReconstructFiles* files, RfError* error );
void rf_free_reconstruct_files( RfReconstructFiles* files );

// Reads a frame of this number. Free it in any case.
RfResult rf_read_reconstruct_frame( const RfReconstructFiles* files, int number, RfReconstructFrame* frame, RfError* error );
void rf_free_reconstruct_frame( RfReconstructFrame* frame );

// The data of half k.
RfGradientImages rf_reconstruct_images( const RfReconstructFrame* frame, int k );

#endif
