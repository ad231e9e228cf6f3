#include "cli/completion/shells.h"

#include <stdio.h>

#define WORDS 512

static bool has_negation( const RfOption* option ) { return option->type == RF_OPTION_BOOL || option->negated != NULL; }

// The options of a command, as words.
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
    if ( rf_positional_words( table, words, sizeof words ) )
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
    static const char* const kinds[] = { [RF_COMPLETE_WORDS] = "words",
                                         [RF_COMPLETE_OPTIONAL_WORDS] = "maybe",
                                         [RF_COMPLETE_FILE] = "file",
                                         [RF_COMPLETE_TEXT] = "text" };
    for ( int i = 0; i < table->option_count; ++i )
    {
        char words[WORDS];
        RfCompletion completion = rf_completion_of( table->options + i, words, sizeof words );
        if ( completion == RF_COMPLETE_NOTHING )
            continue;
        print_pattern( table, table->options + i, file );
        fprintf( file, ") kind=%s words='%s' ;;\n", kinds[completion], words );
    }
}

static void print_commands( const RfCommand* commands )
{
    for ( int i = 0; commands[i].name != NULL; ++i )
        printf( "%s ", commands[i].name );
}

int rf_print_bash_completion( const RfCommand* commands )
{
    printf( "# Completion of reframe for bash, printed by: reframe completion bash\n"
            "_reframe()\n"
            "{\n"
            "    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}\n"
            "    local command=${COMP_WORDS[1]} options= kind= words= commands='" );
    print_commands( commands );
    printf( "help'\n"
            "    COMPREPLY=()\n"
            "    # bash takes --name=value for three words\n"
            "    if [ \"$current\" = = ]; then\n"
            "        current=\n"
            "    elif [ \"$previous\" = = ]; then\n"
            "        previous=${COMP_WORDS[COMP_CWORD - 2]}\n"
            "    fi\n"
            "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
            "        COMPREPLY=($(compgen -W \"$commands --help --man --version\" -- \"$current\"))\n"
            "        return\n"
            "    fi\n"
            "    case $command in\n"
            "        help) kind=words words=$commands ;;\n" );
    int status = rf_print_commands( commands, print_options );
    printf( "    esac\n"
            "    case $command:$previous in\n" );
    status = status == 0 ? rf_print_commands( commands, print_values ) : status;
    printf( "    esac\n"
            "    case $kind in\n"
            "        words | text) compopt +o default +o bashdefault 2>/dev/null ;;\n"
            "    esac\n"
            "    case $kind:$current in\n"
            "        words:* | maybe:[!-]* | maybe:) COMPREPLY=($(compgen -W \"$words\" -- \"$current\")) ;;\n"
            "        maybe:-* | :-*) COMPREPLY=($(compgen -W \"$options\" -- \"$current\")) ;;\n"
            "    esac # files are bash's own affair\n"
            "}\n"
            "complete -o default -o bashdefault -F _reframe reframe\n" );
    return status;
}
