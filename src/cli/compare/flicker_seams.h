// The groups that a sequence was rendered with, from its files.
#ifndef REFRAME_CLI_COMPARE_FLICKER_SEAMS_H
#define REFRAME_CLI_COMPARE_FLICKER_SEAMS_H

#include "measure/seams.h"

// From what Reframe wrote into the header of a file: group, spp, the frame's
// number and how many its path has. `number` is the frame's in the sequence,
// whose last frame ends the path where the header does not say. No seams
// (rf_has_seams) where a file of others, or one without groups, says nothing.
RfSeams rf_read_seams( const char* path, int number, int last );

// Groups of `period` frames that follow each other, the first from frame `first` on.
RfSeams rf_fixed_seams( int period, int first );

#endif
