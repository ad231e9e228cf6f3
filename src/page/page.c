// Streams an HTML page: template, base64 blocks and JSON, with everything escaped for its place.
#include "page/page.h"

#include "base/try.h"
#include "page/page_assets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Nothing once a write has failed.
static void put( RfPage* page, const char* text, size_t size )
{
    if ( page->result != RF_OK )
        return;
    page->bytes += size;
    page->result = rf_append_atomic_file( &page->file, text, size, page->error );
}

static void put_text( RfPage* page, const char* text ) { put( page, text, strlen( text ) ); }

// Writes text with some characters replaced: `replace` returns the replacement, or NULL.
static void put_escaped( RfPage* page, const char* text, const char* ( *replace )(char))
{
    while ( *text != '\0' )
    {
        size_t plain = 0;
        while ( text[plain] != '\0' && replace( text[plain] ) == NULL )
            ++plain;
        put( page, text, plain );
        text += plain;
        if ( *text != '\0' )
            put_text( page, replace( *text++ ) );
    }
}

static const char* escape_html( char c )
{
    return c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : NULL;
}

// In JSON '<' occurs only inside strings, where it can be escaped; so no text can end the
// script element.
static const char* escape_json( char c ) { return c == '<' ? "\\u003c" : NULL; }

// Writes the template from where it is up to a mark, which is left out; NULL: to its end.
static void put_until( RfPage* page, const char* mark )
{
    const char *begin = page->rest, *end = mark != NULL ? strstr( begin, mark ) : begin + strlen( begin );
    put( page, begin, (size_t)( end - begin ) );
    page->rest = mark != NULL ? end + strlen( mark ) : end;
}

RfResult rf_open_page( const char* path, const char* title, RfPage* page, RfError* error )
{
    *page = ( RfPage ){ .rest = rf_page_html, .error = error };
    RF_TRY( rf_open_atomic_file( path, &page->file, error ) );
    put_until( page, "{{title}}" );
    put_escaped( page, title, escape_html );
    put_until( page, "{{style}}" );
    put_text( page, rf_page_css );
    put_until( page, "{{blocks}}" );
    if ( page->result != RF_OK )
        rf_discard_atomic_file( &page->file );
    return page->result;
}

static size_t encode_base64( const unsigned char* in, size_t size, char* out )
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char* to = out;
    for ( size_t i = 0; i < size; i += 3 )
    {
        size_t left = size - i;
        uint32_t bits = (uint32_t)in[i] << 16 | ( left > 1 ? (uint32_t)in[i + 1] << 8 : 0u ) | ( left > 2 ? in[i + 2] : 0u );
        *to++ = digits[bits >> 18];
        *to++ = digits[bits >> 12 & 63u];
        *to++ = left > 1 ? digits[bits >> 6 & 63u] : '=';
        *to++ = left > 2 ? digits[bits & 63u] : '=';
    }
    return (size_t)( to - out );
}

RfResult rf_add_page_block( RfPage* page, const char* id, const void* bytes, size_t size, RfError* error )
{
    char head[128];
    snprintf( head, sizeof head, "<script type=\"text/plain\" id=\"%.64s\">", id );
    char* text = malloc( ( size + 2 ) / 3 * 4 + 1 );
    if ( text == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for %zu bytes of the page", page->file.path, size );
    size_t length = encode_base64( bytes, size, text );
    page->raw += size;
    page->error = error;
    put_text( page, head );
    put( page, text, length );
    put_text( page, "</script>\n" );
    free( text );
    return page->result;
}

RfResult rf_end_page( RfPage* page, const char* json, RfError* error )
{
    page->error = error;
    put_until( page, "{{data}}" );
    put_escaped( page, json, escape_json );
    put_until( page, "{{script}}" );
    put_text( page, rf_page_js );
    put_until( page, NULL );
    return rf_end_atomic_file( &page->file, page->result, error );
}

void rf_discard_page( RfPage* page ) { rf_discard_atomic_file( &page->file ); }
