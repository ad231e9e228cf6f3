// Writes the manual page (groff) from the option tables that also give the help texts.
#include "cli/help.h"

#include "reframe/aov.h"
#include "reframe/types.h"

#include <string.h>

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

const char* rf_print_until_mark( const char* text, FILE* file )
{
    const char *mark = strstr( text, "{{" ), *end = mark != NULL ? mark : text + strlen( text );
    fwrite( text, 1, (size_t)( end - text ), file );
    return mark != NULL ? strstr( mark, "}}" ) + 2 : end;
}

// Escapes what roff would interpret.
static void print_text( const char* text, FILE* file )
{
    if ( *text == '.' || *text == '\'' )
        fputs( "\\&", file );
    for ( const char* c = text; *c != '\0'; ++c )
    {
        if ( *c == '-' )
            fputs( "\\-", file );
        else if ( *c == '\\' )
            fputs( "\\e", file );
        else
            fputc( *c, file );
    }
}

static void print_heading( const char* name, FILE* file ) { fprintf( file, ".SS %c%s\n", name[0] - 'a' + 'A', name + 1 ); }

static void print_option( const RfOption* option, FILE* file )
{
    char usage[128], usual[RF_DEFAULT_SIZE];
    rf_format_option( option, usage, sizeof usage );
    rf_format_default( option, usual );
    fputs( ".TP\n.B ", file );
    print_text( usage, file );
    fputc( '\n', file );
    print_text( option->help, file );
    if ( usual[0] != '\0' )
    {
        fputs( " (default: ", file );
        print_text( usual, file );
        fputc( ')', file );
    }
    fputc( '\n', file );
}

static void print_manual_section( const RfCommandTable* table, FILE* file )
{
    fprintf( file, ".SH \"reframe %s\"\n.B reframe %s\n[\\fIOPTIONS\\fR]", table->command, table->command );
    for ( int i = 0; i < table->file_count; ++i )
        fprintf( file, " \\fI%s\\fR%s", table->files[i], rf_file_dots( table, i ) );
    fputs( "\n.PP\n", file );
    print_text( table->summary, file );
    fputc( '\n', file );
    rf_list_options( table, file, print_heading, print_option );
}

// A paragraph for each AOV: its channels and what it is.
static void print_aovs( FILE* file )
{
    static const struct
    {
        const char* what;
        bool half;
    } rows[RF_AOV_ALPHA] = {
#define ROW( constant, name, letters, half, source, what ) { what, half },
        RF_AOV_LIST( ROW )
#undef ROW
    };
    for ( int i = 0; i < RF_AOV_ALPHA; ++i )
    {
        fputs( ".TP\n.B", file );
        for ( const char* c = rf_aov_letters( (RfAov)i ); *c != '\0'; ++c )
            fprintf( file, " %s.%c", rf_aov_name( (RfAov)i ), *c );
        fprintf( file, "\n%s%s\n", rows[i].what, rows[i].half ? "; 16-bit floats unless \\fB\\-\\-float\\fR is given" : "" );
    }
}

int rf_print_manual( const RfCommand* commands )
{
    const char* rest = rf_print_until_mark( rf_manual_roff, stdout );
    fputs( rf_version(), stdout ); // without a date: equal sources make equal pages
    rest = rf_print_until_mark( rest, stdout );
    int status = rf_print_commands( commands, print_manual_section );
    if ( status != 0 )
        return status;
    rest = rf_print_until_mark( rest, stdout );
    print_aovs( stdout );
    rf_print_until_mark( rest, stdout );
    return 0;
}
