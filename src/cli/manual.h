// The manual page, made of the same tables as the help of the commands.
#ifndef REFRAME_CLI_MANUAL_H
#define REFRAME_CLI_MANUAL_H

#include "cli/options/options.h"

// Up to the commands: name, synopsis, description.
void rf_print_manual_head( FILE* file );

// One command: an RfHelpPrinter.
void rf_print_manual_section( const RfCommandTable* table, FILE* file );

// What comes after the commands.
void rf_print_manual_tail( FILE* file );

#endif
