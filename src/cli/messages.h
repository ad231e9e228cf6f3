// Messages of all commands: errors and warnings as one line on standard error, results as JSON in a file or on standard output.
#ifndef REFRAME_CLI_MESSAGES_H
#define REFRAME_CLI_MESSAGES_H

#include "base/json.h"
#include "reframe/denoise.h"
#include "reframe/error.h"

#include <jansson.h>

// Formats an error with what to type to get past it, where the library knows a remedy: "a budget
// of 1 MiB is too small for frames of 64x36: give --memory 3M or more, or lower --size".
// Truncated to `size`.
void rf_format_error( const RfError* error, char* text, size_t size );

// A budget as users are reported to give it, rounded up to MiB.
size_t rf_whole_mib( size_t bytes );

// Prints "reframe COMMAND: LINE" on standard error, with the remedy; returns the exit status.
int rf_report_error( const char* command, const RfError* error );

// A log that prints "reframe COMMAND: warning: LINE" on standard error.
// `command` must be a string that outlives the log.
RfLog rf_stderr_log( const char* command );

// Prints a line of a result, or a part of one, on standard output. Control characters, which names
// may hold, are written as \x1b; a newline at the end of the text stays.
void rf_print( const char* format, ... ) __attribute__( ( format( printf, 1, 2 ) ) );

// Warnings that are printed and kept for a command's JSON.
typedef struct RfReportedWarnings
{
    const char* command;
    json_t* lines; // an array of strings; its owner's
} RfReportedWarnings;

// A log that prints like rf_stderr_log and appends the lines to reported->lines. `reported` must outlive it.
RfLog rf_keeping_log( RfReportedWarnings* reported );

// Arrays of texts, and of frame numbers.
json_t* rf_json_texts( const char* const* texts, int count );
json_t* rf_json_frames( const int* frames, int count );

// A JSON number, null where it is not finite.
json_t* rf_json_number( double value );

// Adds keys to an object, as json_pack has them, and returns it: "s:o*" leaves out a key whose value is NULL.
json_t* rf_json_add( json_t* object, const char* format, ... );

// A key and its number, null where it is not finite.
typedef struct RfFigure
{
    const char* key;
    double value;
} RfFigure;

// Sets keys of an object to numbers, up to one that is NULL; returns the object. RF_SET_FIGURES takes the figures as a list.
json_t* rf_set_figures( json_t* object, const RfFigure* figures );
#define RF_SET_FIGURES( object, ... ) rf_set_figures( object, ( const RfFigure[] ){ __VA_ARGS__, { NULL, 0.0 } } )

// The number of an object's key; NaN where there is none, or no object.
double rf_json_number_of( const json_t* object, const char* key );

// The relative RMS error of a channel, percent, of a relMSE, which adds up three channels. All commands call it noise.
double rf_noise_percent( double relmse );
double rf_relmse_of_noise( double percent );

// The same as text: "15 %", "1.2 %", "0.034 %"; "unknown" where it is not finite.
#define RF_NOISE_TEXT_SIZE 32
void rf_format_noise( double relmse, char text[RF_NOISE_TEXT_SIZE] );

// A relative F1 in percent, as text.
void rf_format_flicker( double f1, char text[RF_NOISE_TEXT_SIZE] );

// The errors of frames before and after denoising, as a part of JSON and as text: "noise 1.9 %, denoised 0.7 % (95 %: 0.6 % to 0.9 %;
// bias included)". `noisy`: relMSE.
json_t* rf_denoised_json( double noisy, const RfErrorEstimate* denoised );
#define RF_DENOISED_TEXT_SIZE 192
void rf_format_denoised( double noisy, const RfErrorEstimate* denoised, char text[RF_DENOISED_TEXT_SIZE] );

// Is the result printed as text? Yes, unless the file of --json (NULL: none) is standard output.
bool rf_prints_text( const char* json );

// Writes `json` and a newline to `path` ("-": standard output) and releases it.
// A file is written whole or not at all. NULL json is RF_ERROR_MEMORY.
RfResult rf_write_json( const char* path, json_t* json, RfError* error );

// Flushes standard output and says so where that fails (a full disk, a closed pipe).
RfResult rf_flush_output( RfError* error );

// SIGINT, SIGTERM, SIGHUP and SIGPIPE set a flag: the work stops at the next progress call and keeps what is finished. A second
// SIGINT or SIGTERM ends the program at once. SIGHUP and SIGPIPE stay ignored where they are.

void rf_catch_interrupts( void );
bool rf_is_interrupted( void );

// The opposite, for callbacks that say whether to go on.
bool rf_may_go_on( void* user );

// The end of the program by a library in C++ that cannot go on: Embree and TBB without memory.

// From here on an exception that nothing catches ends the program with a line of ours and exit status 1, not with abort.
void rf_catch_terminate( void );

#endif
