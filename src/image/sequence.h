// Names of image sequences: a run of '#' stands for the frame number, zero-padded to the
// length of the run (longer numbers take more digits).
#ifndef REFRAME_IMAGE_SEQUENCE_H
#define REFRAME_IMAGE_SEQUENCE_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>

// True if the last path component has a run of '#'. Several runs, or one in the name of a
// folder, are errors that rf_sequence_name reports.
bool rf_is_sequence( const char* pattern );

// The file name of `frame`, which counts from 1. A pattern without '#' is copied.
RfResult rf_sequence_name( const char* pattern, int frame, char* name, size_t size, RfError* error );

// Lists the numbers of all existing frames in ascending order in *frames, which the caller
// frees. Fails with RF_ERROR_IO if there are none.
RfResult rf_sequence_frames( const char* pattern, int** frames, int* count, RfError* error );

// True if writing one file might overwrite the other: both name the same file, also through
// links, or one is a pattern that matches the other.
bool rf_may_be_same_file( const char* a, const char* b );

#define RF_MAX_MISSING 100000

// Lists the numbers missing between the first and the last frame, at most RF_MAX_MISSING, in
// *missing, which the caller frees (NULL if none). The smallest step between frames is taken
// as the regular one: 1, 3, 7 lack 5.
RfResult rf_missing_frames( const int* frames, int count, int** missing, int* missing_count, RfError* error );

// Formats frame numbers as "3, 4, 8-12", truncated with "..." if too long.
void rf_format_frames( const int* frames, int count, char* text, size_t size );

#endif
