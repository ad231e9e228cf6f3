// Formats errors and warnings as single lines, and names result codes.
#include "base/plain_text.h"
#include "base/remedy.h"

#include <stdarg.h>
#include <stdio.h>

static void format_line( char* text, size_t size, const char* format, va_list args )
{
    char raw[1024];
    vsnprintf( raw, sizeof raw, format, args );
    rf_plain_text( raw, text, size );
}

RfResult rf_fail( RfError* error, RfResult code, const char* format, ... )
{
    if ( error != NULL )
    {
        // formatted into a copy first: an argument may be error->text itself
        char text[sizeof error->text];
        va_list args;
        va_start( args, format );
        format_line( text, sizeof text, format, args );
        va_end( args );
        error->code = code;
        error->remedy = RF_REMEDY_NONE;
        error->least_memory = 0;
        snprintf( error->text, sizeof error->text, "%s", text );
    }
    return code;
}

RfResult rf_advise( RfResult code, RfRemedy remedy, size_t least_memory, RfError* error )
{
    if ( error != NULL )
    {
        error->remedy = remedy;
        error->least_memory = least_memory;
    }
    return code;
}

const char* rf_result_name( RfResult code )
{
    switch ( code )
    {
        case RF_OK: return "RF_OK";
        case RF_ERROR_USAGE: return "RF_ERROR_USAGE";
        case RF_ERROR_IO: return "RF_ERROR_IO";
        case RF_ERROR_FORMAT: return "RF_ERROR_FORMAT";
        case RF_ERROR_UNSUPPORTED: return "RF_ERROR_UNSUPPORTED";
        case RF_ERROR_MEMORY: return "RF_ERROR_MEMORY";
        case RF_ERROR_SCENE: return "RF_ERROR_SCENE";
        case RF_ERROR_DEVICE: return "RF_ERROR_DEVICE";
        case RF_ERROR_INTERRUPTED: return "RF_ERROR_INTERRUPTED";
    }
    return "RF_ERROR_UNKNOWN";
}

void rf_warn( RfLog* log, const char* format, ... )
{
    if ( log == NULL )
        return;
    log->count += 1;
    if ( log->fn == NULL )
        return;
    char text[1024];
    va_list args;
    va_start( args, format );
    format_line( text, sizeof text, format, args );
    va_end( args );
    log->fn( log->user, text );
}
