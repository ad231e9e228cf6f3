// What `tune`, `cost` and `plan` found, in plain words.
#ifndef REFRAME_CLI_TUNE_VERDICT_H
#define REFRAME_CLI_TUNE_VERDICT_H

#include "measure/image_error.h"
#include "reframe/render.h"

#define RF_VERDICT_SIZE 640

// "1.8 times faster than path tracing at equal noise (95 %: 1.5 to 2.2)".
void rf_format_gain( const RfInterval* gain, char* text, size_t size );
// The same at equal flicker, of which the interval is not known.
void rf_tell_flicker_gain( const RfInterval* gain, char* text, size_t size );

// "4.1 s", "16 min", "2.6 h", "3 days".
void rf_format_span( double seconds, char* text, size_t size );

// "groups of 7 and 3x3 tiles", "groups of 7", "3x3 tiles", "path tracing".
void rf_format_reuse( int eyes, const RfTile* tile, char* text, size_t size );

#endif
