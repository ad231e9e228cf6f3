#include "cli/commands.h"

int rf_print_commands( const RfCommand* commands, RfHelpPrinter* printer )
{
    char help[] = "--help";
    int status = 0;
    rf_set_help_printer( printer );
    for ( int i = 0; commands[i].name != NULL && status == 0; ++i )
    {
        char name[32];
        snprintf( name, sizeof name, "%s", commands[i].name );
        char* arguments[] = { name, help, NULL };
        status = commands[i].run( 2, arguments );
    }
    rf_set_help_printer( NULL );
    return status;
}
