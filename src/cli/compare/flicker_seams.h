// Borders of the groups that a sequence was rendered with, from its files.
#ifndef REFRAME_CLI_COMPARE_FLICKER_SEAMS_H
#define REFRAME_CLI_COMPARE_FLICKER_SEAMS_H

#include "measure/seams.h"

// Reads group, spp, frame number and number of frames from the header of a file by Reframe.
// `number` is the frame's in the sequence, whose last frame ends the path where the header does
// not say. There are no seams (rf_has_seams) where the file is another program's or has no groups.
RfSeams rf_read_seams( const char* path, int number, int last );

// Groups of `period` frames that follow each other, the first from frame `first` on.
RfSeams rf_fixed_seams( int period, int first );

#endif
