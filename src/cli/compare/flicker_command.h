// The results of `flicker`: table, verdict in words, JSON.
#ifndef REFRAME_CLI_COMPARE_FLICKER_COMMAND_H
#define REFRAME_CLI_COMPARE_FLICKER_COMMAND_H

#include "measure/flicker_sequence.h"

#include <jansson.h>

// Prints everything: the verdict in two lines, then a row for each pair, and the rest. `unfollowed`: why nothing is followed
// along the motion where layers are there; else empty.
void rf_print_flicker( const RfFlickerRun* run, const char* unfollowed );

json_t* rf_flicker_json( const RfFlickerRun* run );

#endif
