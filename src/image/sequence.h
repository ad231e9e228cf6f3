// What the library does with names of sequences besides reframe/image.h.
#ifndef REFRAME_IMAGE_SEQUENCE_H
#define REFRAME_IMAGE_SEQUENCE_H

#include "reframe/image.h"

// True if writing one file might overwrite the other: both name the same file, also through
// links, or one is a pattern that matches the other.
bool rf_may_be_same_file( const char* a, const char* b );

// Ascending, for qsort and bsearch.
int rf_compare_frames( const void* a, const void* b );

#define RF_MAX_MISSING 100000

// Lists the numbers missing between the first and the last frame, at most RF_MAX_MISSING, in
// *missing, which the caller frees (NULL if none). The smallest step between frames is taken
// as the regular one: 1, 3, 7 lack 5.
RfResult rf_missing_frames( const int* frames, int count, int** missing, int* missing_count, RfError* error );

// Formats frame numbers as "-3 to 1, 3, 4, 8-12", truncated with "..." if too long.
void rf_format_frames( const int* frames, int count, char* text, size_t size );

#endif
