// The solve of one frame by the method that fits what is in its files.
#ifndef REFRAME_CLI_RECONSTRUCT_SOLVE_H
#define REFRAME_CLI_RECONSTRUCT_SOLVE_H

#include "cli/reconstruct/reconstruct_input.h"

// The words of --method, in the order of RfReconstructMethod; NULL ends them.
extern const char* const rf_reconstruct_methods[];

// What was asked for.
typedef struct RfReconstructChoice
{
    int method;
    double alpha;
    bool method_given, alpha_given;
} RfReconstructChoice;

// What was done with a frame.
typedef struct RfReconstructSolve
{
    RfReconstructOptions options;
    bool own_weights; // they come from the data that they weigh
    int half_count;
} RfReconstructSolve;

// Chooses the method and solves into `image`, which the caller destroys. `name` is the file, for messages. The
// frame's images are used up.
RfResult rf_solve_frame( const RfReconstructChoice* choice, RfReconstructFrame* frame, const char* name,
                         RfReconstructSolve* solve, RfImage* image, RfReconstructInfo* info, RfError* error );

#endif
