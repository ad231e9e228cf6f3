// Runs the program as a user does, in a folder of its own, and keeps what it said.
#ifndef REFRAME_TESTS_CLI_RUN_H
#define REFRAME_TESTS_CLI_RUN_H

#include "image/exr.h"
#include "reframe/image.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct CliResult
{
    int status;      // exit status, or 1000 + signal
    char out[65536]; // standard output, cut where longer
    char err[65536]; // standard error
} CliResult;

// Makes a fresh folder, in which all commands run; cli_leave removes it.
void cli_enter( void );
void cli_leave( void );
const char* cli_folder( void );
// The path of a file in it, or what is an absolute path, good until the 32nd call after.
const char* cli_path( const char* name );

// The same as set-up and tear-down of a group of tests.
int cli_enter_group( void** state );
int cli_leave_group( void** state );

// Runs a shell line in the folder, with $R the program and $VASE the vase room.
const CliResult* cli_run( const char* format, ... ) __attribute__( ( format( printf, 1, 2 ) ) );

// Runs what measures for so many seconds, with four times as many where a busy machine makes them too few to know anything.
const CliResult* cli_measure( const char* command, int budget );

// Starts the same and does not wait; cli_wait does.
void cli_start( const char* format, ... ) __attribute__( ( format( printf, 1, 2 ) ) );
const CliResult* cli_wait( int signal_number ); // sends the signal first unless it is 0

// Files of the folder.
bool cli_exists( const char* name );
void cli_write( const char* name, const void* bytes, size_t size );
char* cli_read( const char* name, size_t* size ); // to be freed
json_t* cli_read_json( const char* name );        // to be released
RfImage cli_read_exr( const char* name );         // its colours, to be destroyed
void cli_expect_size( const char* name, int width, int height );
// A channel, to be freed; NULL where the file has none of this name.
float* cli_read_channel( const char* name, const char* channel, RfExrWindow* window );
// A text of its header, valid until the next call; NULL where there is none.
const char* cli_exr_text( const char* name, const char* key );
void cli_expect_exr_text( const char* name, const char* key, const char* wanted );
void cli_expect_exr_texts( const char* name, const char* const ( *wanted )[2], size_t count );
int cli_count_files( const char* suffix, const char* subfolder );

// Fails the test with all that was said unless status is as wanted and `part`
// (may be NULL) is in standard error, which must then be one line.
void cli_expect( const CliResult* result, int status, const char* part );

// Fails the test unless the text begins with the "verdict" of the JSON: two lines, the first of which begins with
// `first`, and an empty one.
void cli_expect_verdict( const char* text, const json_t* json, const char* first );

// ---- command run ----

// Runs a command's function inside of the test, and keeps what it says.

// The exit status. What is said on standard error is kept for the checks.
int run_command( int ( *command )( int argc, char** argv ), int argc, char** argv );

#define COMMAND_ARGUMENTS 20

// The same with further arguments up to NULL. The first `count`, with room for
// COMMAND_ARGUMENTS, name a file by --json, which is removed before and then read by load_json.
int run_command_to_json( int ( *command )( int argc, char** argv ), int count, char** arguments, va_list more );
json_t* load_json( void );

// It failed with this status, and one line that has `part`.
void check_failed( int status, int wanted, const char* part );
// It did what it should, in silence.
void check_done( int status );

// A number of a JSON object.
double number( const json_t* json, const char* key );

#endif
