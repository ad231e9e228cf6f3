// The frames of `compare`: their list, and pairs of images aligned by their data windows.
#ifndef REFRAME_CLI_COMPARE_COMPARE_FRAMES_H
#define REFRAME_CLI_COMPARE_COMPARE_FRAMES_H

#include "reframe/image.h"

#include <stdbool.h>

#define RF_COMPARE_NAME_SIZE 4096

typedef struct RfCompareFrames
{
    const char* patterns[2]; // A, B; a folder's sequence once it is found
    char found[2][RF_COMPARE_NAME_SIZE];
    bool by_number;        // one is a folder: what both have is measured
    const char* layers[2]; // NULL: the colour
    const char* list;      // of --frames; NULL: all
    bool overlap;          // measure what both have
    int* frames;           // NULL: two files, which count as frame 1
    int count;
    int* missing; // between the first and the last, of both sequences
    int missing_count;
    int* lacking[2]; // frames that the other alone has; by_number
    int lacking_count[2];
} RfCompareFrames;

// Finds the frames of two sequences, which must be the same but for those of folders, or the two files.
// rf_free_compare_frames in any case.
RfResult rf_find_compare_frames( RfCompareFrames* frames, RfError* error );
void rf_free_compare_frames( RfCompareFrames* frames );

// The file of a frame. '#' is special only in sequences.
RfResult rf_compare_name( const RfCompareFrames* frames, const char* pattern, int frame, char name[RF_COMPARE_NAME_SIZE],
                          RfError* error );

// Two images of the same pixels, and their window.
typedef struct RfComparePair
{
    char names[2][RF_COMPARE_NAME_SIZE];
    RfImage images[2];
    RfExrWindow window;
} RfComparePair;

RfResult rf_read_compare_pair( const RfCompareFrames* frames, int frame, RfComparePair* pair, RfError* error );
void rf_destroy_compare_pair( RfComparePair* pair );

#endif
