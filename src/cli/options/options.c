#include "cli/options/options.h"

#include "cli/options/synonyms.h"
#include "cli/options/written_files.h"

#include <ctype.h>
#include <string.h>

#define MAX_OPTIONS 64

// The state of one parse.
typedef struct Parse
{
    const RfCommandTable* table;
    int argc;
    char** argv;
    int next; // argument to be read
    const char** files;
    int file_count;
    bool seen[MAX_OPTIONS];
} Parse;

static RfResult fail_unknown( const RfCommandTable* table, const char* argument, const char* name, RfError* error )
{
    const char* names[MAX_OPTIONS + 1];
    for ( int i = 0; i < table->option_count; ++i )
        names[i] = table->options[i].name;
    names[table->option_count] = "help";
    const char* nearest = rf_find_synonym( name, names, table->option_count );
    if ( nearest == NULL )
        nearest = rf_nearest_word( name, names, table->option_count + 1 );
    int length = (int)strcspn( argument, "=" );
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "%.*s: no such option, did you mean --%s?", length, argument, nearest );
    return rf_fail( error, RF_ERROR_USAGE, "%.*s: no such option, see reframe %s --help", length, argument, table->command );
}

static bool has_negation( const RfOption* option ) { return option->type == RF_OPTION_BOOL || option->negated != NULL; }

// Index of the option with this name (length characters), or −1. Sets *negated for --no-name.
static int find_long( const RfCommandTable* table, const char* name, size_t length, bool* negated )
{
    for ( int i = 0; i < table->option_count; ++i )
    {
        const char* known = table->options[i].name;
        *negated = false;
        if ( strlen( known ) == length && strncmp( known, name, length ) == 0 )
            return i;
        *negated = true;
        if ( has_negation( table->options + i ) && length == strlen( known ) + 3 && strncmp( name, "no-", 3 ) == 0 &&
             strncmp( known, name + 3, length - 3 ) == 0 )
            return i;
    }
    *negated = false;
    return -1;
}

static int find_letter( const RfCommandTable* table, char letter )
{
    for ( int i = 0; i < table->option_count; ++i )
    {
        if ( table->options[i].letter == letter )
            return i;
    }
    return -1;
}

// "-5--1" and "-1.5" are values, "-" is standard output; "-o" and "--spp" are
// the next option, so the value was left out.
static bool looks_like_option( const char* text )
{
    return text[0] == '-' && ( isalpha( (unsigned char)text[1] ) || text[1] == '-' );
}

static RfResult fail_value( const RfOption* option, bool negated, const char* value, RfError* error )
{
    return rf_fail( error, RF_ERROR_USAGE, "--%s%s: takes no value, got '%s'", negated ? "no-" : "", option->name, value );
}

// A value that may be left out: the next argument counts as one only if it is one of the choices.
static const char* optional_value( Parse* parse, const RfOption* option )
{
    if ( parse->next < parse->argc && rf_is_choice( option, parse->argv[parse->next] ) )
        return parse->argv[parse->next++];
    return option->bare;
}

// Stores option `index`; `value` is what stood after '=', or NULL.
static RfResult take_option( Parse* parse, int index, bool negated, const char* value, RfError* error )
{
    const RfOption* option = parse->table->options + index;
    if ( parse->seen[index] )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: given twice", option->name );
    parse->seen[index] = true;
    if ( option->given != NULL )
        *option->given = true;
    if ( option->type == RF_OPTION_BOOL )
    {
        if ( value != NULL )
            return fail_value( option, negated, value, error );
        *(bool*)option->value = !negated;
        return RF_OK;
    }
    if ( negated && value != NULL )
        return fail_value( option, negated, value, error );
    if ( negated )
        value = option->negated;
    if ( value == NULL && option->bare != NULL )
        value = optional_value( parse, option );
    if ( value == NULL )
    {
        if ( parse->next == parse->argc || looks_like_option( parse->argv[parse->next] ) )
            return rf_fail( error, RF_ERROR_USAGE, "--%s: its value is missing", option->name );
        value = parse->argv[parse->next++];
    }
    return rf_parse_option_value( option, value, error );
}

static RfResult take_argument( Parse* parse, const char* argument, RfError* error )
{
    const RfCommandTable* table = parse->table;
    bool negated = false;
    if ( strncmp( argument, "--", 2 ) == 0 )
    {
        const char* name = argument + 2;
        size_t length = strcspn( name, "=" );
        int index = find_long( table, name, length, &negated );
        if ( index >= 0 )
            return take_option( parse, index, negated, name[length] == '=' ? name + length + 1 : NULL, error );
        char copy[64];
        snprintf( copy, sizeof copy, "%.*s", (int)( length < 60 ? length : 60 ), name );
        return fail_unknown( table, argument, copy, error );
    }
    int index = argument[2] == '\0' ? find_letter( table, argument[1] ) : -1;
    if ( index < 0 )
        return fail_unknown( table, argument, argument + 1, error );
    return take_option( parse, index, false, NULL, error );
}

static RfResult take_file( Parse* parse, const char* argument, RfError* error )
{
    const RfCommandTable* table = parse->table;
    int last = table->file_count - 1, most = table->file_max > 0 ? table->file_max : table->file_count;
    if ( parse->file_count == most )
        return rf_fail( error, RF_ERROR_USAGE, "'%s' is one file too many, see reframe %s --help", argument, table->command );
    if ( argument[0] == '\0' )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is empty",
                        table->files[parse->file_count < last ? parse->file_count : last] );
    parse->files[parse->file_count++] = argument;
    return RF_OK;
}

RfResult rf_parse_options( const RfCommandTable* table, int argc, char** argv, const char** files, bool* help, RfError* error )
{
    Parse parse = { .table = table, .argc = argc, .argv = argv, .next = 1, .files = files };
    *help = false;
    if ( table->option_count > MAX_OPTIONS )
        return rf_fail( error, RF_ERROR_USAGE, "%s has too many options", table->command );
    bool ended = false;
    while ( parse.next < argc )
    {
        const char* argument = argv[parse.next++];
        RfResult result = RF_OK;
        if ( !ended && strcmp( argument, "--" ) == 0 )
            ended = true;
        else if ( !ended && ( strcmp( argument, "--help" ) == 0 || strcmp( argument, "-h" ) == 0 ) )
        {
            *help = true;
            return RF_OK;
        }
        else if ( !ended && argument[0] == '-' && argument[1] != '\0' )
            result = take_argument( &parse, argument, error );
        else
            result = take_file( &parse, argument, error );
        if ( result != RF_OK )
            return result;
    }
    if ( parse.file_count < table->file_count )
        return rf_fail( error, RF_ERROR_USAGE, "%s is missing, see reframe %s --help", table->files[parse.file_count],
                        table->command );
    if ( table->file_max > 0 )
        *table->file_total = parse.file_count;
    return rf_check_written_files( table, files, parse.file_count, error );
}

void rf_format_option( const RfOption* option, char* text, size_t size )
{
    size_t used = 0;
    if ( option->letter != 0 )
        used += (size_t)snprintf( text, size, "-%c, ", option->letter );
    if ( option->type == RF_OPTION_BOOL )
    {
        snprintf( text + used, size - used, "--[no-]%s", option->name );
        return;
    }
    const char* no = option->negated != NULL ? "[no-]" : "";
    used += (size_t)snprintf( text + used, size - used, "--%s%s %s", no, option->name, option->bare != NULL ? "[" : "" );
    if ( option->type != RF_OPTION_CHOICE )
    {
        snprintf( text + used, size - used, "%s", option->meta );
        return;
    }
    for ( int i = 0; option->choices[i] != NULL && used < size; ++i )
        used += (size_t)snprintf( text + used, size - used, "%s%s", i > 0 ? "|" : "", option->choices[i] );
    if ( option->bare != NULL && used < size )
        snprintf( text + used, size - used, "]" );
}

const char* rf_file_dots( const RfCommandTable* table, int i )
{
    return table->file_max > table->file_count && i == table->file_count - 1 ? "..." : "";
}

static RfHelpPrinter* s_help_printer;

void rf_set_help_printer( RfHelpPrinter* printer ) { s_help_printer = printer; }

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
    fprintf( file, "\n%s\n\n", table->summary );
    for ( int i = 0; i < table->option_count; ++i )
    {
        const RfOption* option = table->options + i;
        char name[128];
        rf_format_option( option, name, sizeof name );
        fprintf( file, strlen( name ) > 30 ? "  %s\n%34s" : "  %-30s  %s", name, "" );
        fprintf( file, "%s", option->help );
        if ( option->default_text != NULL )
            fprintf( file, " (default: %s)", option->default_text );
        fputc( '\n', file );
    }
    fprintf( file, "  %-30s  %s\n", "-h, --help", "this text" );
}
