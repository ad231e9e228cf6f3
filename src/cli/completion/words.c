#include "cli/completion/shells.h"

#include <string.h>

static void append( char* words, size_t size, const char* word )
{
    size_t used = strlen( words );
    snprintf( words + used, size - used, "%s%s", used > 0 ? " " : "", word );
}

RfCompletion rf_completion_of( const RfOption* option, char* words, size_t size )
{
    words[0] = '\0';
    switch ( option->type )
    {
        case RF_OPTION_BOOL: return RF_COMPLETE_NOTHING;
        case RF_OPTION_CHOICE:
            for ( int i = 0; option->choices[i] != NULL; ++i )
                append( words, size, option->choices[i] );
            return option->bare != NULL ? RF_COMPLETE_OPTIONAL_WORDS : RF_COMPLETE_WORDS;
        case RF_OPTION_SIZE: append( words, size, "720p 1080p 1440p 2160p 4k" ); return RF_COMPLETE_WORDS;
        case RF_OPTION_STRING: return option->reads || option->writes != NULL ? RF_COMPLETE_FILE : RF_COMPLETE_TEXT;
        default: break;
    }
    if ( option->keyword == NULL )
        return RF_COMPLETE_TEXT;
    append( words, size, option->keyword );
    return RF_COMPLETE_WORDS;
}

bool rf_positional_words( const RfCommandTable* table, char* words, size_t size )
{
    if ( strchr( table->files[0], '|' ) == NULL )
        return false;
    snprintf( words, size, "%s", table->files[0] );
    for ( char* c = words; *c != '\0'; ++c )
        *c = *c == '|' ? ' ' : *c;
    return true;
}
