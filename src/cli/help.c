// What the tables of options give besides parsing: the help of a command, the manual page (groff), and scripts that make shells
// complete commands, options and their values.
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "reframe/aov.h"
#include "reframe/types.h"

#include <string.h>

// The files of src/cli/texts, with marks such as {{commands}} where something goes in.
extern const char rf_manual_roff[], rf_completion_bash[], rf_completion_zsh[];

// "--weights exact|eq15|unweighted", "-o, --output PATTERN", "--[no-]resume", "--[no-]adaptive [auto|on|off]".
static void format_option( const RfOption* option, char* text, size_t size )
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

// "..." for a positional argument that may be repeated, else "".
static const char* file_dots( const RfCommandTable* table, int i )
{
    return table->file_max > table->file_count && i == table->file_count - 1 ? "..." : "";
}

// Replaces what rf_print_help prints, for other texts from the same tables.
typedef void HelpPrinter( const RfCommandTable* table, FILE* file );
static HelpPrinter* s_help_printer;

#define VALUE_SIZE 100
#define DEFAULT_SIZE 256

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
        case RF_OPTION_FLICKER:
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

// What its value holds, or words; empty where there is none.
static void format_default( const RfOption* option, char text[DEFAULT_SIZE] )
{
    char value[VALUE_SIZE];
    bool has_value = format_value( option, value );
    const char* words = option->default_text != NULL ? option->default_text : has_value ? "%s" : "";
    const char* place = strstr( words, "%s" );
    if ( place == NULL )
        snprintf( text, DEFAULT_SIZE, "%s", words );
    else
        snprintf( text, DEFAULT_SIZE, "%.*s%s%.100s", place - words > 50 ? 50 : (int)( place - words ), words, value, place + 2 );
}

#define MOST_WITHOUT_HEADINGS 12

// Calls `heading` with the name of each heading, where there are so many options that the help has any, and `option` for each below it.
static void list_options( const RfCommandTable* table, FILE* file, void ( *heading )( const char* name, FILE* file ),
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
    char name[128], usual[DEFAULT_SIZE];
    format_option( option, name, sizeof name );
    format_default( option, usual );
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
        fprintf( file, " %s%s", table->files[i], file_dots( table, i ) );
    fprintf( file, "\n%s\n", table->summary );
    if ( table->option_count <= MOST_WITHOUT_HEADINGS )
        fputc( '\n', file );
    list_options( table, file, print_heading, print_option );
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

// Prints something of each command's table; a row without a name ends them. Returns an exit status.
static int print_commands( const RfCommand* commands, HelpPrinter* printer )
{
    char help[] = "--help";
    int status = 0;
    s_help_printer = printer;
    for ( int i = 0; commands[i].name != NULL && status == 0; ++i )
    {
        char name[32];
        snprintf( name, sizeof name, "%s", commands[i].name );
        char* arguments[] = { name, help, NULL };
        status = commands[i].run( 2, arguments );
    }
    s_help_printer = NULL;
    return status;
}

// Prints a text up to its next mark, which is left out, and returns what follows it; else to its end.
static const char* print_until_mark( const char* text, FILE* file )
{
    const char *mark = strstr( text, "{{" ), *end = mark != NULL ? mark : text + strlen( text );
    fwrite( text, 1, (size_t)( end - text ), file );
    return mark != NULL ? strstr( mark, "}}" ) + 2 : end;
}

// Escapes what roff would interpret.
static void print_roff( const char* text, FILE* file )
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

static void print_roff_heading( const char* name, FILE* file ) { fprintf( file, ".SS %c%s\n", name[0] - 'a' + 'A', name + 1 ); }

static void print_roff_option( const RfOption* option, FILE* file )
{
    char usage[128], usual[DEFAULT_SIZE];
    format_option( option, usage, sizeof usage );
    format_default( option, usual );
    fputs( ".TP\n.B ", file );
    print_roff( usage, file );
    fputc( '\n', file );
    print_roff( option->help, file );
    if ( usual[0] != '\0' )
    {
        fputs( " (default: ", file );
        print_roff( usual, file );
        fputc( ')', file );
    }
    fputc( '\n', file );
}

static void print_manual_section( const RfCommandTable* table, FILE* file )
{
    fprintf( file, ".SH \"reframe %s\"\n.B reframe %s\n[\\fIOPTIONS\\fR]", table->command, table->command );
    for ( int i = 0; i < table->file_count; ++i )
        fprintf( file, " \\fI%s\\fR%s", table->files[i], file_dots( table, i ) );
    fputs( "\n.PP\n", file );
    print_roff( table->summary, file );
    fputc( '\n', file );
    list_options( table, file, print_roff_heading, print_roff_option );
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
    const char* rest = print_until_mark( rf_manual_roff, stdout );
    fputs( rf_version(), stdout ); // without a date: equal sources make equal pages
    rest = print_until_mark( rest, stdout );
    int status = print_commands( commands, print_manual_section );
    if ( status != 0 )
        return status;
    rest = print_until_mark( rest, stdout );
    print_aovs( stdout );
    print_until_mark( rest, stdout );
    return 0;
}

#define WORDS 512

// How the value of an option is completed.
typedef enum RfCompletion
{
    COMPLETE_NOTHING, // there is no value
    COMPLETE_WORDS,   // one of a few words, maybe besides others
    COMPLETE_OPTIONAL_WORDS,
    COMPLETE_FILE,
    COMPLETE_TEXT, // anything
} RfCompletion;

// Its words go into `words` with blanks between them.
static RfCompletion completion_of( const RfOption* option, char* words, size_t size )
{
    words[0] = '\0';
    switch ( option->type )
    {
        case RF_OPTION_BOOL: return COMPLETE_NOTHING;
        case RF_OPTION_CHOICE:
            rf_append_words( words, size, option->choices, " ", " " );
            return option->bare != NULL ? COMPLETE_OPTIONAL_WORDS : COMPLETE_WORDS;
        case RF_OPTION_SIZE: rf_append( words, size, "720p 1080p 1440p 2160p 4k" ); return COMPLETE_WORDS;
        case RF_OPTION_STRING: return option->reads || option->writes != NULL ? COMPLETE_FILE : COMPLETE_TEXT;
        default: break;
    }
    if ( option->keyword == NULL )
        return COMPLETE_TEXT;
    rf_append( words, size, "%s", option->keyword );
    return COMPLETE_WORDS;
}

// The words that a command's files may be, with blanks between them: "bash|zsh". False where they are files.
static bool positional_words( const RfCommandTable* table, char* words, size_t size )
{
    if ( strchr( table->files[0], '|' ) == NULL )
        return false;
    snprintf( words, size, "%s", table->files[0] );
    for ( char* c = words; *c != '\0'; ++c )
        *c = *c == '|' ? ' ' : *c;
    return true;
}

// Text within single quotes and a [description] of _arguments.
static void print_zsh_text( const char* text, FILE* file )
{
    for ( const char* c = text; *c != '\0'; ++c )
    {
        if ( *c == '\'' )
            fputs( "'\\''", file );
        else if ( strchr( "[]:\\", *c ) != NULL )
            fprintf( file, "\\%c", *c );
        else
            fputc( *c, file );
    }
}

static void print_zsh_value( const RfOption* option, FILE* file )
{
    char words[WORDS];
    RfCompletion completion = completion_of( option, words, sizeof words );
    if ( completion == COMPLETE_NOTHING )
        return;
    fputs( completion == COMPLETE_OPTIONAL_WORDS ? "::" : ":", file );
    print_zsh_text( option->meta != NULL ? option->meta : option->name, file );
    if ( completion == COMPLETE_FILE )
        fputs( ":_files", file );
    else if ( completion == COMPLETE_TEXT )
        fputs( ": ", file );
    else
        fprintf( file, ":(%s)", words );
}

static bool has_negation( const RfOption* option ) { return option->type == RF_OPTION_BOOL || option->negated != NULL; }

static void print_zsh_option( const RfOption* option, FILE* file )
{
    bool value = option->type != RF_OPTION_BOOL, negated = has_negation( option );
    fputs( "                ", file );
    if ( negated )
        fprintf( file, "'(--no-%s)", option->name );
    if ( option->letter != 0 )
        fprintf( file, "'(-%c --%s)'{-%c,--%s=}'", option->letter, option->name, option->letter, option->name );
    else
        fprintf( file, "%s--%s%s", negated ? "" : "'", option->name, value ? "=" : "" );
    fputc( '[', file );
    print_zsh_text( option->help, file );
    fputc( ']', file );
    print_zsh_value( option, file );
    fputs( "' \\\n", file );
    if ( negated )
        fprintf( file, "                '(--%s)--no-%s[not --%s]' \\\n", option->name, option->name, option->name );
}

static void print_zsh_command( const RfCommandTable* table, FILE* file )
{
    char words[WORDS];
    fprintf( file, "        %s)\n            _arguments \\\n", table->command );
    for ( int i = 0; i < table->option_count; ++i )
        print_zsh_option( table->options + i, file );
    fputs( "                '(- *)'{-h,--help}'[the options of the command]' \\\n", file );
    if ( positional_words( table, words, sizeof words ) )
        fprintf( file, "                '1:word:(%s)' ;;\n", words );
    else
        fputs( "                '*:file:_files' ;;\n", file );
}

static int print_zsh_completion( const RfCommand* commands )
{
    const char* rest = print_until_mark( rf_completion_zsh, stdout );
    for ( int i = 0; commands[i].name != NULL; ++i )
    {
        printf( "        '%s:", commands[i].name );
        print_zsh_text( commands[i].summary, stdout );
        printf( "'\n" );
    }
    rest = print_until_mark( rest, stdout );
    int status = print_commands( commands, print_zsh_command );
    print_until_mark( rest, stdout );
    return status;
}

static void print_options( const RfCommandTable* table, FILE* file )
{
    char words[WORDS];
    fprintf( file, "        %s)\n            options='", table->command );
    for ( int i = 0; i < table->option_count; ++i )
    {
        const RfOption* option = table->options + i;
        fprintf( file, "--%s %s%s%s", option->name, has_negation( option ) ? "--no-" : "",
                 has_negation( option ) ? option->name : "", has_negation( option ) ? " " : "" );
    }
    fputs( "--help'", file );
    if ( positional_words( table, words, sizeof words ) )
        fprintf( file, " kind=maybe words='%s'", words );
    fputs( " ;;\n", file );
}

static void print_pattern( const RfCommandTable* table, const RfOption* option, FILE* file )
{
    fprintf( file, "        %s:--%s", table->command, option->name );
    if ( option->letter != 0 )
        fprintf( file, "|%s:-%c", table->command, option->letter );
}

// What follows each option that has a value.
static void print_values( const RfCommandTable* table, FILE* file )
{
    static const char* const kinds[] = {
        [COMPLETE_WORDS] = "words", [COMPLETE_OPTIONAL_WORDS] = "maybe", [COMPLETE_FILE] = "file", [COMPLETE_TEXT] = "text"
    };
    for ( int i = 0; i < table->option_count; ++i )
    {
        char words[WORDS];
        RfCompletion completion = completion_of( table->options + i, words, sizeof words );
        if ( completion == COMPLETE_NOTHING )
            continue;
        print_pattern( table, table->options + i, file );
        fprintf( file, ") kind=%s words='%s' ;;\n", kinds[completion], words );
    }
}

// Print the script for these commands on standard output; return the exit status.
static int print_bash_completion( const RfCommand* commands )
{
    const char* rest = print_until_mark( rf_completion_bash, stdout );
    for ( int i = 0; commands[i].name != NULL; ++i )
        printf( "%s ", commands[i].name );
    rest = print_until_mark( rest, stdout );
    int status = print_commands( commands, print_options );
    rest = print_until_mark( rest, stdout );
    status = status == 0 ? print_commands( commands, print_values ) : status;
    print_until_mark( rest, stdout );
    return status;
}

static const char* const s_files[] = { "bash|zsh" };
static const RfCommandTable s_table = {
    .command = "completion",
    .summary = "Prints the completion of commands, options and their values for bash or zsh: source <(reframe completion bash). "
               "Where Reframe is installed, the shells find it by themselves.",
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
        status = print_bash_completion( s_commands );
    else if ( result == RF_OK && strcmp( files[0], "zsh" ) == 0 )
        status = print_zsh_completion( s_commands );
    else if ( result == RF_OK )
        result = rf_fail( &error, RF_ERROR_USAGE, "'%s': no such shell, there are bash and zsh", files[0] );
    if ( result == RF_OK && status == 0 )
        result = rf_flush_output( &error );
    return result == RF_OK ? status : rf_report_error( "completion", &error );
}
