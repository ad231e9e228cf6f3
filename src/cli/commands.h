// The commands. argv[0] is the name of the command. They return the exit status: 0, 1 failed,
// 2 usage, 130 interrupted.
#ifndef REFRAME_CLI_COMMANDS_H
#define REFRAME_CLI_COMMANDS_H

#include "cli/options/options.h"
#include "reframe/measure.h"

int rf_command_render( int argc, char** argv );
int rf_command_info( int argc, char** argv );
int rf_command_tune( int argc, char** argv );
int rf_command_cost( int argc, char** argv );
int rf_command_compare( int argc, char** argv );
int rf_command_flicker( int argc, char** argv );
int rf_command_report( int argc, char** argv );
int rf_command_reconstruct( int argc, char** argv );
int rf_command_denoise( int argc, char** argv );
int rf_command_png( int argc, char** argv );
int rf_command_convert( int argc, char** argv );
int rf_command_completion( int argc, char** argv );

typedef struct RfCommand
{
    const char* name;
    int ( *run )( int argc, char** argv );
    const char* summary;
} RfCommand;

// Prints the manual page of the commands, which a row without a name ends; returns the exit status.
int rf_print_manual( const RfCommand* commands );

// Names the commands that `completion` completes.
void rf_set_completion_commands( const RfCommand* commands );

// The verdict of `compare` in words: "no significant bias: mean error +0.02 % (95 %: -0.30 to +0.40 %);
// relMSE 0.0123 (about 6.4 % noise per pixel); worst pixel …".
// `clipped`: pixels of A and of B that are at the end of the range of half floats, which leave no verdict on bias.
// `worst_frame` NULL: of a single file, whose number says nothing.
void rf_error_verdict( const RfErrorMetrics* metrics, const size_t clipped[2], const int* worst_frame, char* text, size_t size );

#endif
