// Names of sequences: a run of '#' stands for the frame number, padded with
// zeros to as many digits (more where the number needs them).
#ifndef REFRAME_IMAGE_SEQUENCE_H
#define REFRAME_IMAGE_SEQUENCE_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>

// Has a run of '#' in its last path component. More than one run, or one in a
// folder's name, is an error that rf_sequence_name reports.
bool rf_is_sequence( const char* pattern );

// The file name of `frame` (1-based). A pattern without '#' is copied as it is.
RfResult rf_sequence_name( const char* pattern, int frame, char* name, size_t size, RfError* error );

// The frame numbers for which a file exists, ascending, in *frames (to be
// freed), *count of them. Fails (RF_ERROR_IO) where there are none.
RfResult rf_sequence_frames( const char* pattern, int** frames, int* count, RfError* error );

// Whether writing the one may write the other: names of one file, by links and
// other folders' names too, or a name that the other, a pattern, has for a frame.
bool rf_may_be_same_file( const char* a, const char* b );

#define RF_MOST_MISSING 100000

// The numbers that ascending ones lack between the first and the last, in *missing (to be
// freed, NULL where there are none), *missing_count of them, RF_MOST_MISSING at most. The
// smallest step that occurs is the regular one: 1, 3, 7 lack 5.
RfResult rf_missing_frames( const int* frames, int count, int** missing, int* missing_count, RfError* error );

// "3, 4, 8-12", cut with "..." where it is too long.
void rf_format_frames( const int* frames, int count, char* text, size_t size );

#endif
