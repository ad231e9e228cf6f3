// Escapes control characters of names by walking UTF-8, so that a terminal never obeys them.
#include "base/plain_text.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

size_t rf_utf8_bytes( const char* text )
{
    const unsigned char* c = (const unsigned char*)text;
    size_t more = c[0] < 0x80                   ? 0
                  : c[0] >= 0xc2 && c[0] < 0xe0 ? 1
                  : c[0] >= 0xe0 && c[0] < 0xf0 ? 2
                  : c[0] >= 0xf0 && c[0] < 0xf5 ? 3
                                                : 4;
    for ( size_t i = 1; i <= more; ++i )
    {
        if ( more == 4 || ( c[i] & 0xc0 ) != 0x80 )
            return 0;
    }
    bool wrong = ( c[0] == 0xe0 && c[1] < 0xa0 ) || ( c[0] == 0xed && c[1] > 0x9f ) || ( c[0] == 0xf0 && c[1] < 0x90 ) ||
                 ( c[0] == 0xf4 && c[1] > 0x8f );
    return wrong ? 0 : more + 1;
}

// The code of a control character, −1 for all others.
static int control_code( const unsigned char* c, size_t bytes )
{
    if ( bytes == 1 )
        return c[0] < 0x20 || ( c[0] >= 0x7f && c[0] < 0xa0 ) ? c[0] : -1;
    return bytes == 2 && c[0] == 0xc2 && c[1] < 0xa0 ? c[1] : -1;
}

char* rf_plain_text( const char* text, char* plain, size_t size )
{
    size_t used = 0;
    for ( const unsigned char* c = (const unsigned char*)text; *c != '\0'; )
    {
        size_t known = rf_utf8_bytes( (const char*)c ), bytes = known > 0 ? known : 1, length = bytes;
        int code = control_code( c, bytes );
        char escape[8];
        if ( code >= 0 )
            length = (size_t)snprintf( escape, sizeof escape, code == '\n' ? "\\n" : code == '\t' ? "\\t" : "\\x%02x", code );
        if ( used + length >= size )
            break;
        memcpy( plain + used, code >= 0 ? (const void*)escape : c, length );
        used += length;
        c += bytes;
    }
    plain[used] = '\0';
    return plain;
}
