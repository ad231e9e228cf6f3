// The manual page, made of the same tables as the help of the commands.
#ifndef REFRAME_CLI_HELP_H
#define REFRAME_CLI_HELP_H

#include "cli/options/options.h"

// Prints what comes before the commands: name, synopsis, description.
void rf_print_manual_head( FILE* file );

// Prints the section of a command: an RfHelpPrinter.
void rf_print_manual_section( const RfCommandTable* table, FILE* file );

// Prints what comes after the commands.
void rf_print_manual_tail( FILE* file );

#endif
