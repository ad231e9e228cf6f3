// Streams an HTML page: template, base64 blocks and JSON, with everything escaped for its place.
#include "page/page.h"

#include "image/atomic_file.h"
#include "image/half.h"
#include "page/page_assets.h"
#include "page/picture.h"
#include "reframe/image.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int divide_up( int a, int b ) { return ( a + b - 1 ) / b; }

double rf_values_page_bytes( int width, int height, int factor )
{
    double bytes = RF_VALUES_HEADER_BYTES + 6.0 * divide_up( width, factor ) * divide_up( height, factor );
    return 4.0 * ceil( bytes / 3.0 );
}

int rf_values_factor( int width, int height, double most )
{
    for ( int factor = 1; factor <= RF_VALUES_MAX_FACTOR; ++factor )
    {
        if ( rf_values_page_bytes( width, height, factor ) <= most )
            return factor;
    }
    return 0;
}

static unsigned char* put16( unsigned char* out, unsigned int value )
{
    out[0] = (unsigned char)( value & 255u );
    out[1] = (unsigned char)( value >> 8 & 255u );
    return out + 2;
}

RfResult rf_encode_values( const RfImage* image, int factor, const char* name, unsigned char** bytes, size_t* size,
                           RfError* error )
{
    *bytes = NULL;
    *size = 0;
    RfImage small = { 0 };
    RfResult result = factor > 1 ? rf_shrink_image( image, factor, &small, error ) : RF_OK;
    if ( result != RF_OK )
        return result;
    const RfImage* from = factor > 1 ? &small : image;
    size_t count = 3 * (size_t)from->width * (size_t)from->height;
    *bytes = malloc( RF_VALUES_HEADER_BYTES + 2 * count );
    if ( *bytes != NULL )
    {
        unsigned char* out = put16( *bytes, (unsigned int)factor );
        out = put16( put16( out, (unsigned int)from->width ), (unsigned int)from->height );
        for ( size_t i = 0; i < count; ++i )
            out = put16( out, rf_float_to_half( rf_clamp_half( from->rgb[i] ) ) );
        *size = (size_t)( out - *bytes );
    }
    else
        result = rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for its values", name );
    rf_destroy_image( &small );
    return result;
}

static RfResult put( RfPage* page, const char* text, size_t size, RfError* error )
{
    page->bytes += size;
    return rf_append_atomic_file( &page->file, text, size, error );
}

static RfResult put_text( RfPage* page, const char* text, RfError* error ) { return put( page, text, strlen( text ), error ); }

// Writes text with some characters replaced: `replace` returns the replacement, or NULL.
static RfResult put_escaped( RfPage* page, const char* text, const char* ( *replace )(char), RfError* error )
{
    RfResult result = RF_OK;
    while ( *text != '\0' && result == RF_OK )
    {
        size_t plain = 0;
        while ( text[plain] != '\0' && replace( text[plain] ) == NULL )
            ++plain;
        result = put( page, text, plain, error );
        text += plain;
        if ( result == RF_OK && *text != '\0' )
            result = put_text( page, replace( *text++ ), error );
    }
    return result;
}

static const char* escape_html( char c )
{
    return c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : NULL;
}

// In JSON '<' occurs only inside strings, where it can be escaped; so no text can end the
// script element.
static const char* escape_json( char c ) { return c == '<' ? "\\u003c" : NULL; }

// Writes the part of the template between two marks, "{{name}}"; NULL stands for its start or
// end.
static RfResult put_frame( RfPage* page, const char* from, const char* to, RfError* error )
{
    const char* begin = rf_page_html;
    if ( from != NULL )
        begin = strstr( begin, from ) + strlen( from );
    const char* end = to != NULL ? strstr( begin, to ) : begin + strlen( begin );
    return put( page, begin, (size_t)( end - begin ), error );
}

static RfResult put_head( RfPage* page, const char* title, RfError* error )
{
    RfResult result = put_frame( page, NULL, "{{title}}", error );
    if ( result == RF_OK )
        result = put_escaped( page, title, escape_html, error );
    if ( result == RF_OK )
        result = put_frame( page, "{{title}}", "{{style}}", error );
    if ( result == RF_OK )
        result = put_text( page, rf_page_css, error );
    return result == RF_OK ? put_frame( page, "{{style}}", "{{blocks}}", error ) : result;
}

RfResult rf_open_page( const char* path, const char* title, RfPage* page, RfError* error )
{
    *page = ( RfPage ){ 0 };
    RfResult result = rf_open_atomic_file( path, &page->file, error );
    if ( result != RF_OK )
        return result;
    result = put_head( page, title, error );
    if ( result != RF_OK )
        rf_discard_atomic_file( &page->file );
    return result;
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
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for %zu bytes of the page", page->file.path, size );
    size_t length = encode_base64( bytes, size, text );
    page->raw += size;
    RfResult result = put_text( page, head, error );
    if ( result == RF_OK )
        result = put( page, text, length, error );
    if ( result == RF_OK )
        result = put_text( page, "</script>\n", error );
    free( text );
    return result;
}

RfResult rf_end_page( RfPage* page, const char* json, RfError* error )
{
    RfResult result = put_frame( page, "{{blocks}}", "{{data}}", error );
    if ( result == RF_OK )
        result = put_escaped( page, json, escape_json, error );
    if ( result == RF_OK )
        result = put_frame( page, "{{data}}", "{{script}}", error );
    if ( result == RF_OK )
        result = put_text( page, rf_page_js, error );
    if ( result == RF_OK )
        result = put_frame( page, "{{script}}", NULL, error );
    if ( result == RF_OK )
        return rf_commit_atomic_file( &page->file, error );
    rf_discard_atomic_file( &page->file );
    return result;
}

void rf_discard_page( RfPage* page ) { rf_discard_atomic_file( &page->file ); }
