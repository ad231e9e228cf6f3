// The results of `compare`: table, verdict in words, JSON.
#ifndef REFRAME_CLI_COMPARE_COMPARE_COMMAND_H
#define REFRAME_CLI_COMPARE_COMPARE_COMMAND_H

#include "reframe/image.h"
#include "reframe/measure.h"

#include <jansson.h>

// The verdict in words: "no significant bias: mean error +0.02 % (95 %: -0.30 to +0.40 %);
// relMSE 0.0123 (about 6.4 % noise per pixel); worst pixel …".
// `clipped`: pixels of A and of B that are at the end of the range of half floats, which leave no verdict on bias.
// `worst_frame` NULL: of a single file, whose number says nothing.
void rf_error_verdict( const RfErrorMetrics* metrics, const size_t clipped[2], const int* worst_frame, char* text, size_t size );

#endif
