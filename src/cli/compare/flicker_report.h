// The results of `flicker`: table, verdict in words, JSON.
#ifndef REFRAME_CLI_COMPARE_FLICKER_REPORT_H
#define REFRAME_CLI_COMPARE_FLICKER_REPORT_H

#include "measure/image_error.h"
#include "measure/flicker.h"

#include <jansson.h>

typedef enum RfErrorSource
{
    RF_ERROR_UNKNOWN,
    RF_ERROR_FROM_REFERENCE,
    RF_ERROR_FROM_VARIANCE,
} RfErrorSource;

// Sums over the pairs, of all and of those inside and at the border of groups.
typedef struct RfFlickerParts
{
    RfFlickerSums all, inside, border;
} RfFlickerParts;

void rf_add_flicker_pair( RfFlickerParts* parts, bool border, const RfFlickerSums* pair );

typedef struct RfFlickerReport
{
    bool compensated;     // along the motion
    bool follows;         // it is not, but is followed beside that
    bool masked;          // by depth, the one or the other
    char unfollowed[512]; // why nothing is followed where layers are there; else empty
    bool has_seams;
    bool has_spectrum;
    int cuts;                       // between shots, which are not compared
    RfErrorSource source;           // of the errors' mean squares
    RfFlickerParts plain, followed; // the second: with `follows`
    RfSpectrumSums spectrum;
    int window;            // frames of each window of the spectrum
    RfErrorMetrics errors; // of all frames; without a reference only the counts mean something
    json_t* pairs;         // an array
} RfFlickerReport;

// Prints everything: the verdict in two lines, then a row for each pair, and the rest.
void rf_print_flicker( const RfFlickerReport* report );

json_t* rf_flicker_pair_json( int frame, bool border, const RfFlickerSums* sums );

// The same pair along the motion; NULL: left out, for its frames lack the layers.
json_t* rf_followed_pair_json( const RfFlickerSums* sums );

// Takes ownership of `pairs`.
json_t* rf_flicker_json( RfFlickerReport* report );

// Borders of the groups that a sequence was rendered with, from its files.

// Reads group, spp, frame number and number of frames from the header of a file by Reframe.
// `number` is the frame's in the sequence, whose last frame ends the path where the header does
// not say; of a path with cuts they are those of the frame's shot. There are no seams (rf_has_seams) where the file is another
// program's or has no groups.
RfSeams rf_read_seams( const char* path, int number, int last );

// Groups of `period` frames that follow each other, the first from frame `first` on.
RfSeams rf_fixed_seams( int period, int first );

#endif
