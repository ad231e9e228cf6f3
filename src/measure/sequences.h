// Sequences that belong together.
#ifndef REFRAME_MEASURE_SEQUENCES_H
#define REFRAME_MEASURE_SEQUENCES_H

#include "reframe/measure.h"

// The frames of two sequences, ascending.
typedef struct RfFramePairs
{
    int *both, count;
    int *lacking[2], lacking_count[2]; // what the other alone has
    int *all, all_count;
} RfFramePairs;

// Matches frames by their numbers, which ascend. Free with rf_free_frame_pairs.
RfResult rf_pair_frames( const int* const numbers[2], const int counts[2], RfFramePairs* pairs, RfError* error );
void rf_free_frame_pairs( RfFramePairs* pairs );

// Fails with RF_ERROR_IO where one lacks a frame that the other has, and names it.
RfResult rf_check_all_paired( const RfFramePairs* pairs, const char* const patterns[2], RfError* error );

// From the number of a frame to that of the next, as the file of frame `number` says (a camera path may go in
// steps); 1 where it does not.
int rf_sequence_step( const char* pattern, int number );

#endif
