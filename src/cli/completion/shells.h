// Completion scripts, made of the same tables as the help of the commands.
#ifndef REFRAME_CLI_COMPLETION_SHELLS_H
#define REFRAME_CLI_COMPLETION_SHELLS_H

#include "cli/commands.h"

// How the value of an option is completed.
typedef enum RfCompletion
{
    RF_COMPLETE_NOTHING, // there is no value
    RF_COMPLETE_WORDS,   // one of a few words, maybe besides others
    RF_COMPLETE_OPTIONAL_WORDS,
    RF_COMPLETE_FILE,
    RF_COMPLETE_TEXT, // anything
} RfCompletion;

// Its words go into `words` with blanks between them.
RfCompletion rf_completion_of( const RfOption* option, char* words, size_t size );

// The words that a command's files may be, with blanks between them: "bash|zsh". False where they are files.
bool rf_positional_words( const RfCommandTable* table, char* words, size_t size );

// Print the script for these commands on standard output; return the exit status.
int rf_print_bash_completion( const RfCommand* commands );
int rf_print_zsh_completion( const RfCommand* commands );

#endif
