// The blocks of a frame on the page: what a person looks at.
//   s<track>-<number>          the picture, see page/picture.h
//   v<track>-<number>          scene values, see page/values.h
//   w<track>-<number>          finer ones, of one frame
//   l<track>-<layer>-<number>  an AOV, as a picture
#ifndef REFRAME_CLI_REPORT_REPORT_BLOCKS_H
#define REFRAME_CLI_REPORT_REPORT_BLOCKS_H

#include "cli/report/report_frames.h"

// Finds the AOVs of the sequence; the ranges of their values are those of the middle frame.
RfResult rf_find_page_aovs( RfPageTrack* track, RfError* error );

// Adds picture, scene values and AOVs of a frame, an index into track->numbers; `path` is its file.
RfResult rf_add_page_blocks( RfPage* page, RfPageTrack* track, int frame, const RfImage* image, const char* path,
                             RfError* error );

// Adds scene values of a frame at a factor of its own.
RfResult rf_add_page_fine_values( RfPage* page, RfPageTrack* track, int number, int factor, RfError* error );

#endif
