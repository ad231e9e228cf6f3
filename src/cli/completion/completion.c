// reframe completion: scripts that make shells complete commands, options and their values.
#include "cli/commands.h"
#include "cli/completion/shells.h"
#include "cli/messages.h"

#include <string.h>

#define COMMAND "completion"

static const char* const s_files[] = { "bash|zsh" };
static const RfCommandTable s_table = {
    .command = COMMAND,
    .summary = "Prints what makes bash or zsh complete commands, options and their values: source <(reframe completion bash). "
               "Where Reframe is installed, its shells find it by themselves.",
    .files = s_files,
    .file_count = 1,
};

static const RfCommand* s_commands;

void rf_set_completion_commands( const RfCommand* commands ) { s_commands = commands; }

int rf_command_completion( int argc, char** argv )
{
    const char* files[1];
    bool help;
    RfError error;
    RfResult result = rf_parse_options( &s_table, argc, argv, files, &help, &error );
    int status = 0;
    if ( result == RF_OK && help )
        rf_print_help( &s_table, stdout );
    else if ( result == RF_OK && strcmp( files[0], "bash" ) == 0 )
        status = rf_print_bash_completion( s_commands );
    else if ( result == RF_OK && strcmp( files[0], "zsh" ) == 0 )
        status = rf_print_zsh_completion( s_commands );
    else if ( result == RF_OK )
        result = rf_fail( &error, RF_ERROR_USAGE, "'%s': no such shell, there are bash and zsh", files[0] );
    if ( result == RF_OK && status == 0 )
        result = rf_flush_output( &error );
    return result == RF_OK ? status : rf_report_error( COMMAND, &error );
}
