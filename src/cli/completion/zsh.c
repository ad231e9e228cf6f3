#include "cli/completion/shells.h"

#include <stdio.h>
#include <string.h>

#define WORDS 512

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
    RfCompletion completion = rf_completion_of( option, words, sizeof words );
    if ( completion == RF_COMPLETE_NOTHING )
        return;
    fputs( completion == RF_COMPLETE_OPTIONAL_WORDS ? "::" : ":", file );
    print_text( option->meta != NULL ? option->meta : option->name, file );
    if ( completion == RF_COMPLETE_FILE )
        fputs( ":_files", file );
    else if ( completion == RF_COMPLETE_TEXT )
        fputs( ": ", file );
    else
        fprintf( file, ":(%s)", words );
}

static void print_option( const RfOption* option, FILE* file )
{
    bool value = option->type != RF_OPTION_BOOL, negated = !value || option->negated != NULL;
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
    if ( rf_positional_words( table, words, sizeof words ) )
        fprintf( file, "                '1:word:(%s)' ;;\n", words );
    else
        fputs( "                '*:file:_files' ;;\n", file );
}

int rf_print_zsh_completion( const RfCommand* commands )
{
    printf( "#compdef reframe\n"
            "# Completion of reframe for zsh, printed by: reframe completion zsh\n"
            "_reframe()\n"
            "{\n"
            "    local -a commands\n"
            "    commands=(\n" );
    for ( int i = 0; commands[i].name != NULL; ++i )
    {
        printf( "        '%s:", commands[i].name );
        print_text( commands[i].summary, stdout );
        printf( "'\n" );
    }
    printf( "        'help:the options of a command'\n"
            "    )\n"
            "    if (( CURRENT == 2 )); then\n"
            "        _describe command commands\n"
            "        compadd -- --help --man --version\n"
            "        return\n"
            "    fi\n"
            "    local command=$words[2]\n"
            "    shift words\n"
            "    (( CURRENT-- ))\n"
            "    case $command in\n"
            "        help) _describe command commands ;;\n" );
    int status = rf_print_commands( commands, print_command );
    printf( "    esac\n"
            "}\n"
            "# sourced, or loaded as the function itself\n"
            "if [ \"$funcstack[1]\" = _reframe ]; then\n"
            "    _reframe \"$@\"\n"
            "else\n"
            "    compdef _reframe reframe\n"
            "fi\n" );
    return status;
}
