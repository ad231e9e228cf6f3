// The names of effects, and what a picture is without them.
#include "base/built_in.h"
#include "base/words.h"

#include <stdio.h>
#include <string.h>

typedef struct Row
{
    const char* name;
    RfWithout without;
    bool forcible;
    const char* what;
} Row;

#define ROW( constant, name, without, forcible, what ) { name, RF_WITHOUT_##without, forcible, what },
static const Row s_rows[RF_EFFECT_COUNT] = { RF_EFFECT_LIST( ROW ) };
#undef ROW

#define NAME_BYTES( constant, name, without, forcible, what ) +sizeof( name ) // with a comma or the end
_Static_assert( 0 RF_EFFECT_LIST( NAME_BYTES ) <= RF_EFFECTS_TEXT_SIZE, "all names fit" );
#undef NAME_BYTES
_Static_assert( RF_EFFECT_COUNT <= RF_MAX_EFFECTS, "a set of effects has 64 bits" );

const char* rf_effect_name( RfEffectId effect ) { return s_rows[effect].name; }

RfWithout rf_effect_without( RfEffectId effect ) { return s_rows[effect].without; }

const char* rf_effect_without_text( RfEffectId effect ) { return s_rows[effect].what; }

uint64_t rf_effects_not_built( void ) { return RF_EFFECTS_NOT_BUILT; }

uint64_t rf_forcible_effects( void )
{
    uint64_t set = 0;
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
        set |= s_rows[i].forcible ? RF_EFFECT_BIT( i ) : 0;
    return set;
}

// The effect called by `length` characters, or −1.
static int find( const char* word, size_t length )
{
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        if ( strlen( s_rows[i].name ) == length && strncmp( s_rows[i].name, word, length ) == 0 )
            return i;
    }
    return -1;
}

static RfResult fail_unknown( const char* word, size_t length, RfError* error )
{
    const char* names[RF_EFFECT_COUNT];
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
        names[i] = s_rows[i].name;
    char copy[32], all[RF_EFFECTS_TEXT_SIZE];
    snprintf( copy, sizeof copy, "%.*s", (int)( length < 31 ? length : 31 ), word );
    const char* nearest = length > 0 ? rf_nearest_word( copy, names, RF_EFFECT_COUNT ) : NULL;
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "unknown effect '%s', did you mean %s?", copy, nearest );
    rf_format_effects( ( RF_EFFECT_BIT( RF_EFFECT_COUNT - 1 ) - 1 ) * 2 + 1, all, sizeof all );
    return rf_fail( error, RF_ERROR_USAGE, "unknown effect '%s', expected %s", copy, all );
}

RfResult rf_parse_effects( const char* text, uint64_t* effects, RfError* error )
{
    *effects = 0;
    while ( text != NULL )
    {
        size_t length = strcspn( text, "," );
        int effect = find( text, length );
        if ( effect < 0 )
            return fail_unknown( text, length, error );
        if ( ( *effects & RF_EFFECT_BIT( effect ) ) != 0 )
            return rf_fail( error, RF_ERROR_USAGE, "the effect %s is given twice", s_rows[effect].name );
        *effects |= RF_EFFECT_BIT( effect );
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}

void rf_format_effects( uint64_t effects, char* text, size_t size )
{
    size_t used = 0;
    text[0] = '\0';
    for ( int i = 0; i < RF_EFFECT_COUNT && used < size; ++i )
    {
        if ( ( effects & RF_EFFECT_BIT( i ) ) != 0 )
            used += (size_t)snprintf( text + used, size - used, "%s%s", used > 0 ? "," : "", s_rows[i].name );
    }
}
