// Sequences that belong together.
#ifndef REFRAME_MEASURE_SEQUENCES_H
#define REFRAME_MEASURE_SEQUENCES_H

#include "reframe/measure.h"

// The numbers of the frames of two sequences, ascending, in *numbers (the caller frees them). Fails with
// RF_ERROR_IO where one lacks a frame that the other has, and names it.
RfResult rf_match_sequences( const char* a, const char* b, int** numbers, int* count, RfError* error );

// From the number of a frame to that of the next, as the file of frame `number` says (a camera path may go in
// steps); 1 where it does not.
int rf_sequence_step( const char* pattern, int number );

// Both are sequences, or none: else RF_ERROR_USAGE.
RfResult rf_check_patterns( const char* a, const char* b, bool* are_sequences, RfError* error );

#endif
