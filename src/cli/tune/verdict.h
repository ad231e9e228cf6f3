// What `tune` and `cost` found, in plain words. No figure is printed whose 95 % interval spans more than a factor of four.
#ifndef REFRAME_CLI_TUNE_VERDICT_H
#define REFRAME_CLI_TUNE_VERDICT_H

#include "measure/image_error.h"
#include "reframe/render.h"

#define RF_VERDICT_SIZE 1000

// Is the value known well enough to be printed?
bool rf_is_known( const RfInterval* value );

// "1.8 times faster than path tracing at equal noise (95 %: 1.5 to 2.2)", "at least 5 times faster …", "not compared with …", or
// how many seconds it takes to know, of which `spent` were spent.
void rf_format_gain( const RfInterval* gain, double spent, char* text, size_t size );
// The same at equal flicker, of which the interval is not known.
void rf_tell_flicker_gain( const RfInterval* gain, char* text, size_t size );

// A cell of a table: "0.042", ">0.011" or "?".
#define RF_FIGURE_SIZE 24
void rf_format_figure( const RfInterval* value, char text[RF_FIGURE_SIZE] );

// "4.1 s", "16 min", "2.6 h", "3 days".
void rf_format_span( double seconds, char* text, size_t size );

// "groups of 7 and 3x3 tiles", "groups of 7", "3x3 tiles", "path tracing".
void rf_format_reuse( int eyes, const RfTile* tile, char* text, size_t size );

#endif
