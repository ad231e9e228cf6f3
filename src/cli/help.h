// The manual page, made of the same tables as the help of the commands.
#ifndef REFRAME_CLI_HELP_H
#define REFRAME_CLI_HELP_H

#include "cli/commands.h"

// Prints the manual page; returns the exit status.
int rf_print_manual( const RfCommand* commands );

// The files of src/cli/texts, with marks such as {{commands}} where something goes in.
extern const char rf_manual_roff[], rf_completion_bash[], rf_completion_zsh[];

// Prints a text up to its next mark, which is left out, and returns what follows it; else to its end.
const char* rf_print_until_mark( const char* text, FILE* file );

#endif
