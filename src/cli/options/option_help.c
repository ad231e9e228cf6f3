// Options as the help shows them.
#include "base/words.h"
#include "cli/messages.h"
#include "cli/options/options.h"

#include <string.h>

void rf_format_option( const RfOption* option, char* text, size_t size )
{
    text[0] = '\0';
    if ( option->letter != 0 )
        rf_append( text, size, "-%c, ", option->letter );
    if ( option->type == RF_OPTION_BOOL )
        rf_append( text, size, "--[no-]%s", option->name );
    else
        rf_append( text, size, "--%s%s %s", option->negated != NULL ? "[no-]" : "", option->name,
                   option->bare != NULL ? "[" : "" );
    if ( option->type != RF_OPTION_CHOICE )
        rf_append( text, size, "%s", option->type != RF_OPTION_BOOL ? option->meta : "" );
    else
        rf_append_words( text, size, option->choices, "|", "|" );
    rf_append( text, size, "%s", option->bare != NULL ? "]" : "" );
}

const char* rf_file_dots( const RfCommandTable* table, int i )
{
    return table->file_max > table->file_count && i == table->file_count - 1 ? "..." : "";
}

static RfHelpPrinter* s_help_printer;

void rf_set_help_printer( RfHelpPrinter* printer ) { s_help_printer = printer; }

#define VALUE_SIZE 100

// Formats the default that a value holds; false where it holds none, or none to speak of.
static bool format_value( const RfOption* option, char text[VALUE_SIZE] )
{
    const void* value = option->value;
    size_t size = VALUE_SIZE, bytes;
    switch ( option->type )
    {
        case RF_OPTION_INT:
            if ( option->keyword != NULL && *(const int*)value == option->keyword_value )
                snprintf( text, size, "%s", option->keyword );
            else
                snprintf( text, size, "%d", *(const int*)value );
            return *(const int*)value >= option->min || option->keyword != NULL;
        case RF_OPTION_UINT64: snprintf( text, size, "%llu", (unsigned long long)*(const uint64_t*)value ); return true;
        case RF_OPTION_REAL:
        case RF_OPTION_NOISE:
        case RF_OPTION_TIME: snprintf( text, size, "%g", *(const double*)value ); return *(const double*)value >= option->min;
        case RF_OPTION_MEMORY:
            bytes = *(const size_t*)value;
            snprintf( text, size, bytes % ( (size_t)1 << 30 ) == 0 ? "%zuG" : "%zuM",
                      bytes % ( (size_t)1 << 30 ) == 0 ? bytes >> 30 : bytes >> 20 );
            return bytes > 0;
        case RF_OPTION_CHOICE:
            snprintf( text, size, "%s", *(const int*)value >= 0 ? option->choices[*(const int*)value] : "" );
            return text[0] != '\0';
        case RF_OPTION_STRING:
            snprintf( text, size, "%s", *(const char* const*)value != NULL ? *(const char* const*)value : "" );
            return text[0] != '\0';
        case RF_OPTION_BOOL: snprintf( text, size, "yes" ); return *(const bool*)value;
        case RF_OPTION_SIZE:
        case RF_OPTION_FPS: break;
    }
    return false;
}

void rf_format_default( const RfOption* option, char text[RF_DEFAULT_SIZE] )
{
    char value[VALUE_SIZE];
    bool has_value = format_value( option, value );
    const char* words = option->default_text != NULL ? option->default_text : has_value ? "%s" : "";
    const char* place = strstr( words, "%s" );
    if ( place == NULL )
        snprintf( text, RF_DEFAULT_SIZE, "%s", words );
    else
        snprintf( text, RF_DEFAULT_SIZE, "%.*s%s%.100s", place - words > 50 ? 50 : (int)( place - words ), words, value,
                  place + 2 );
}

#define MOST_WITHOUT_HEADINGS 12

void rf_list_options( const RfCommandTable* table, FILE* file, void ( *heading )( const char* name, FILE* file ),
                      void ( *option )( const RfOption* option, FILE* file ) )
{
    static const char* const names[RF_HEADING_COUNT] = {
        [RF_HEADING_BASIC] = "basic",      [RF_HEADING_QUALITY] = "quality", [RF_HEADING_MEASUREMENT] = "measurement",
        [RF_HEADING_PASSES] = "passes",    [RF_HEADING_OUTPUT] = "output",   [RF_HEADING_PERFORMANCE] = "performance",
        [RF_HEADING_RESEARCH] = "research"
    };
    bool has_headings = table->option_count > MOST_WITHOUT_HEADINGS;
    for ( int h = 0; h < ( has_headings ? RF_HEADING_COUNT : 1 ); ++h )
    {
        bool is_first = true;
        for ( int i = 0; i < table->option_count; ++i )
        {
            if ( has_headings && (int)table->options[i].heading != h )
                continue;
            if ( has_headings && is_first )
                heading( names[h], file );
            is_first = false;
            option( table->options + i, file );
        }
    }
}

static void print_heading( const char* name, FILE* file ) { fprintf( file, "\n%s:\n", name ); }

static void print_row( const char* name, const char* help, FILE* file )
{
    fprintf( file, strlen( name ) > 30 ? "  %s\n%34s" : "  %-30s  %s", name, "" );
    fprintf( file, "%s", help );
}

static void print_option( const RfOption* option, FILE* file )
{
    char name[128], usual[RF_DEFAULT_SIZE];
    rf_format_option( option, name, sizeof name );
    rf_format_default( option, usual );
    print_row( name, option->help, file );
    if ( usual[0] != '\0' )
        fprintf( file, " (default: %s)", usual );
    fputc( '\n', file );
}

void rf_print_help( const RfCommandTable* table, FILE* file )
{
    if ( s_help_printer != NULL )
    {
        s_help_printer( table, file );
        return;
    }
    fprintf( file, "usage: reframe %s [OPTIONS]", table->command );
    for ( int i = 0; i < table->file_count; ++i )
        fprintf( file, " %s%s", table->files[i], rf_file_dots( table, i ) );
    fprintf( file, "\n%s\n", table->summary );
    if ( table->option_count <= MOST_WITHOUT_HEADINGS )
        fputc( '\n', file );
    rf_list_options( table, file, print_heading, print_option );
    fputs( table->option_count > MOST_WITHOUT_HEADINGS ? "\n" : "", file );
    print_row( "-h, --help", "print this help", file );
    fputc( '\n', file );
}

RfResult rf_show_help( const RfCommandTable* table, RfError* error )
{
    rf_print_help( table, stdout );
    return rf_flush_output( error );
}

int rf_run_command( const RfCommandTable* table, int argc, char** argv, const char** files,
                    RfResult ( *run )( void* user, RfError* error ), void* user )
{
    RfError error = { 0 };
    bool help = false;
    RfResult result = rf_parse_options( table, argc, argv, files, &help, &error );
    if ( result == RF_OK )
        result = help ? rf_show_help( table, &error ) : run( user, &error );
    return result == RF_OK ? 0 : rf_report_error( table->command, &error );
}
