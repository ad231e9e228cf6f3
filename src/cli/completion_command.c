// reframe completion: scripts that make shells complete commands, options and their values.
#include "base/words.h"
#include "cli/commands.h"
#include "cli/help.h"
#include "cli/messages.h"

#include <stdio.h>
#include <string.h>

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
static void print_text( const char* text, FILE* file )
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

static void print_value( const RfOption* option, FILE* file )
{
    char words[WORDS];
    RfCompletion completion = completion_of( option, words, sizeof words );
    if ( completion == COMPLETE_NOTHING )
        return;
    fputs( completion == COMPLETE_OPTIONAL_WORDS ? "::" : ":", file );
    print_text( option->meta != NULL ? option->meta : option->name, file );
    if ( completion == COMPLETE_FILE )
        fputs( ":_files", file );
    else if ( completion == COMPLETE_TEXT )
        fputs( ": ", file );
    else
        fprintf( file, ":(%s)", words );
}

static bool has_negation( const RfOption* option ) { return option->type == RF_OPTION_BOOL || option->negated != NULL; }

static void print_option( const RfOption* option, FILE* file )
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
    print_text( option->help, file );
    fputc( ']', file );
    print_value( option, file );
    fputs( "' \\\n", file );
    if ( negated )
        fprintf( file, "                '(--%s)--no-%s[not --%s]' \\\n", option->name, option->name, option->name );
}

static void print_command( const RfCommandTable* table, FILE* file )
{
    char words[WORDS];
    fprintf( file, "        %s)\n            _arguments \\\n", table->command );
    for ( int i = 0; i < table->option_count; ++i )
        print_option( table->options + i, file );
    fputs( "                '(- *)'{-h,--help}'[the options of the command]' \\\n", file );
    if ( positional_words( table, words, sizeof words ) )
        fprintf( file, "                '1:word:(%s)' ;;\n", words );
    else
        fputs( "                '*:file:_files' ;;\n", file );
}

static int print_zsh_completion( const RfCommand* commands )
{
    const char* rest = rf_print_until_mark( rf_completion_zsh, stdout );
    for ( int i = 0; commands[i].name != NULL; ++i )
    {
        printf( "        '%s:", commands[i].name );
        print_text( commands[i].summary, stdout );
        printf( "'\n" );
    }
    rest = rf_print_until_mark( rest, stdout );
    int status = rf_print_commands( commands, print_command );
    rf_print_until_mark( rest, stdout );
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
    const char* rest = rf_print_until_mark( rf_completion_bash, stdout );
    for ( int i = 0; commands[i].name != NULL; ++i )
        printf( "%s ", commands[i].name );
    rest = rf_print_until_mark( rest, stdout );
    int status = rf_print_commands( commands, print_options );
    rest = rf_print_until_mark( rest, stdout );
    status = status == 0 ? rf_print_commands( commands, print_values ) : status;
    rf_print_until_mark( rest, stdout );
    return status;
}

#define COMMAND "completion"

static const char* const s_files[] = { "bash|zsh" };
static const RfCommandTable s_table = {
    .command = COMMAND,
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
    return result == RF_OK ? status : rf_report_error( COMMAND, &error );
}
