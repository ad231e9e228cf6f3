// Runs a command's function inside of the test, and keeps what it says.
#ifndef REFRAME_TESTS_COMMAND_RUN_H
#define REFRAME_TESTS_COMMAND_RUN_H

#include <jansson.h>
#include <stdarg.h>

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
