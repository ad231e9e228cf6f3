// What the library does with names of sequences besides reframe/image.h.
#ifndef REFRAME_IMAGE_SEQUENCE_H
#define REFRAME_IMAGE_SEQUENCE_H

#include "reframe/image.h"

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
