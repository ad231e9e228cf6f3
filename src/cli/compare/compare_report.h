// The results of `compare`: table, verdict in words, JSON.
#ifndef REFRAME_CLI_COMPARE_COMPARE_REPORT_H
#define REFRAME_CLI_COMPARE_COMPARE_REPORT_H

#include "cli/compare/compare_frames.h"
#include "reframe/measure.h"

#include <jansson.h>

void rf_print_error_head( void );

// Prints the row of a frame, or of "all", with the NaN and Inf of both images.
void rf_print_error_row( const char* frame, const RfErrorMetrics* metrics );

// One element of "frames".
json_t* rf_error_frame_json( int frame, const RfErrorMetrics* metrics );

// The complete JSON; takes ownership of `rows`. `worst_frame` is the number of the frame with the worst pixel.
json_t* rf_error_json( json_t* rows, const RfErrorMetrics* metrics, int worst_frame, const char* verdict );

// The verdict in words: "no bias seen: mean error +0.02 % (95 %: -0.30 to +0.40 %);
// relMSE 0.0123, about 6.4 % of noise in each channel of a pixel; worst pixel …".
// `worst_frame` below 0: of a single file, whose number says nothing.
void rf_error_verdict( const RfErrorMetrics* metrics, int worst_frame, char* text, size_t size );

// Prints which frames were not measured, and whose they lack; nothing where there is none. And the same
// as keys of the JSON.
void rf_print_missing( const RfCompareFrames* frames );
void rf_set_missing( json_t* json, const RfCompareFrames* frames );

#endif
