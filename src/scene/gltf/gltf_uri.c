// URIs of buffers: base64 data in the document, or a file beside it.

#include "scene/gltf/gltf_document.h"

#include <stdlib.h>
#include <string.h>

bool rf_is_data_uri( const char* uri ) { return strncmp( uri, "data:", 5 ) == 0; }

static int base64_value( unsigned char c )
{
    if ( c >= 'A' && c <= 'Z' )
        return c - 'A';
    if ( c >= 'a' && c <= 'z' )
        return c - 'a' + 26;
    if ( c >= '0' && c <= '9' )
        return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// False if a character is not in the base64 alphabet.
static bool decode_base64( const char* text, size_t length, uint8_t* bytes )
{
    uint32_t bits = 0;
    int held = 0;
    for ( size_t i = 0; i < length; ++i )
    {
        int value = base64_value( (unsigned char)text[i] );
        if ( value < 0 )
            return false;
        bits = bits << 6 | (uint32_t)value;
        held += 6;
        if ( held >= 8 )
        {
            held -= 8;
            *bytes++ = (uint8_t)( bits >> held );
        }
    }
    return true;
}

RfResult rf_gltf_decode_data_uri( const RfGltf* gltf, const char* where, const char* uri, uint8_t** bytes, size_t* size )
{
    const char* comma = strchr( uri, ',' );
    if ( comma == NULL || comma - uri < 7 || strncmp( comma - 7, ";base64", 7 ) != 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "uri is data that is not base64" );
    const char* text = comma + 1;
    size_t length = strlen( text );
    for ( int pad = 0; pad < 2 && length > 0 && text[length - 1] == '='; ++pad )
        length -= 1;
    if ( length % 4 == 1 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "uri has base64 data that is truncated" );
    *size = length / 4 * 3 + ( length % 4 > 0 ? length % 4 - 1 : 0 );
    *bytes = malloc( *size > 0 ? *size : 1 );
    if ( *bytes == NULL )
        return rf_gltf_no_memory( gltf, where );
    if ( decode_base64( text, length, *bytes ) )
        return RF_OK;
    free( *bytes );
    *bytes = NULL;
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "uri has a character that is not base64" );
}

static int hex_value( char c )
{
    if ( c >= '0' && c <= '9' )
        return c - '0';
    if ( c >= 'a' && c <= 'f' )
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

// Decodes in place; false on an invalid escape or an encoded zero byte.
static bool decode_percent( char* text )
{
    char* out = text;
    for ( const char* in = text; *in != 0; ++in )
    {
        char c = *in;
        if ( c == '%' )
        {
            int high = hex_value( in[1] );
            int low = high >= 0 ? hex_value( in[2] ) : -1;
            if ( low < 0 || high * 16 + low == 0 )
                return false;
            c = (char)( high * 16 + low );
            in += 2;
        }
        *out++ = c;
    }
    *out = 0;
    return true;
}

static bool leaves_folder( const char* path )
{
    for ( const char* part = path; part != NULL; )
    {
        const char* slash = strchr( part, '/' );
        size_t length = slash != NULL ? (size_t)( slash - part ) : strlen( part );
        if ( length == 2 && strncmp( part, "..", 2 ) == 0 )
            return true;
        part = slash != NULL ? slash + 1 : NULL;
    }
    return false;
}

// Only files beside or below the scene may be named: an untrusted scene must not read other
// files of the machine.
static const char* find_fault( const char* path )
{
    if ( path[0] == 0 )
        return "is empty";
    if ( path[0] == '/' )
        return "begins with '/'";
    if ( strchr( path, '\\' ) != NULL )
        return "has a backslash";
    if ( leaves_folder( path ) )
        return "leaves the folder by '..'";
    const char* colon = strchr( path, ':' );
    const char* slash = strchr( path, '/' );
    if ( colon != NULL && ( slash == NULL || colon < slash ) )
        return "has a scheme";
    return NULL;
}

RfResult rf_gltf_resolve_uri( const RfGltf* gltf, const char* where, const char* uri, char** path )
{
    *path = NULL;
    const char* slash = strrchr( gltf->path, '/' );
    size_t folder = slash != NULL ? (size_t)( slash - gltf->path ) + 1 : 0;
    char* text = malloc( folder + strlen( uri ) + 1 );
    if ( text == NULL )
        return rf_gltf_no_memory( gltf, where );
    memcpy( text, gltf->path, folder );
    strcpy( text + folder, uri );

    // checked before and after decoding: either form may hide a violation
    const char* fault = find_fault( text + folder );
    if ( fault == NULL && decode_percent( text + folder ) == false )
        fault = "has a broken %-escape";
    if ( fault == NULL )
        fault = find_fault( text + folder );
    if ( fault != NULL )
    {
        free( text );
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                             "uri '%.80s' %s: put the file beside the scene and name it without a folder", uri, fault );
    }
    *path = text;
    return RF_OK;
}
