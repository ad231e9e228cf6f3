#include "film/aov.h"

#include "base/words.h"

#include <stdio.h>
#include <string.h>

typedef struct Aov
{
    const char* name;
    const char* letters;
    bool half;
} Aov;

#define ROW( constant, name, letters, half, first_hit, what ) { name, letters, half },
static const Aov s_aovs[RF_AOV_COUNT] = { RF_AOV_LIST( ROW ){ "alpha", "A", true } };
#undef ROW

#define NAME_BYTES( constant, name, letters, half, first_hit, what ) +sizeof( name ) // with a comma or the end
_Static_assert( sizeof "alpha" RF_AOV_LIST( NAME_BYTES ) <= RF_AOVS_TEXT_SIZE, "all names fit" );
#undef NAME_BYTES

const char* rf_aov_name( RfAov aov ) { return s_aovs[aov].name; }

const char* rf_aov_letters( RfAov aov ) { return s_aovs[aov].letters; }

int rf_aov_channels( RfAov aov ) { return (int)strlen( s_aovs[aov].letters ); }

bool rf_aov_is_half( RfAov aov ) { return s_aovs[aov].half; }

static bool is_word( const char* name, const char* word, size_t length )
{
    return strlen( name ) == length && strncmp( name, word, length ) == 0;
}

// The AOVs called by `length` characters, 0 if there are none.
static unsigned find_aovs( const char* word, size_t length )
{
    if ( is_word( RF_GRADIENT_AOVS_NAME, word, length ) )
        return RF_GRADIENT_AOVS;
    for ( int i = 0; i < RF_AOV_ALPHA; ++i )
    {
        if ( is_word( rf_aov_name( (RfAov)i ), word, length ) )
            return RF_AOV_BIT( i );
    }
    return 0;
}

static RfResult fail_unknown( const char* word, size_t length, RfError* error )
{
    const char* names[RF_AOV_ALPHA + 1] = { [RF_AOV_ALPHA] = RF_GRADIENT_AOVS_NAME };
    for ( int i = 0; i < RF_AOV_ALPHA; ++i )
        names[i] = rf_aov_name( (RfAov)i );
    char copy[32], all[RF_AOVS_TEXT_SIZE];
    snprintf( copy, sizeof copy, "%.*s", (int)( length < 31 ? length : 31 ), word );
    const char* nearest = length > 0 ? rf_nearest_word( copy, names, RF_AOV_ALPHA + 1 ) : NULL;
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "'%s' is no AOV, did you mean %s?", copy, nearest );
    rf_format_aovs( RF_ALL_AOVS, all, sizeof all );
    return rf_fail( error, RF_ERROR_USAGE, "'%s' is no AOV, there are %s", copy, all );
}

RfResult rf_parse_aovs( const char* text, unsigned* aovs, RfError* error )
{
    *aovs = 0;
    while ( text != NULL )
    {
        size_t length = strcspn( text, "," );
        unsigned found = find_aovs( text, length );
        if ( found == 0 )
            return fail_unknown( text, length, error );
        for ( int i = 0; i < RF_AOV_ALPHA; ++i )
        {
            if ( ( *aovs & found & RF_AOV_BIT( i ) ) != 0 )
                return rf_fail( error, RF_ERROR_USAGE, "AOV %s is given twice", rf_aov_name( (RfAov)i ) );
        }
        *aovs |= found;
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}

void rf_format_aovs( unsigned aovs, char* text, size_t size )
{
    size_t used = 0;
    text[0] = '\0';
    for ( int i = 0; i < RF_AOV_COUNT && used < size; ++i )
    {
        if ( ( aovs & RF_AOV_BIT( i ) ) != 0 )
            used += (size_t)snprintf( text + used, size - used, "%s%s", used > 0 ? "," : "", rf_aov_name( (RfAov)i ) );
    }
}
