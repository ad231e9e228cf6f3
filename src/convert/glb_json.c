#include "convert/glb_document.h"

#include <stdlib.h>
#include <string.h>

void rf_glb_set( RfGlbDocument* d, json_t* object, const char* key, json_t* value )
{
    if ( json_object_set_new( object, key, value ) != 0 )
        d->failed = true;
}

void rf_glb_append( RfGlbDocument* d, json_t* array, json_t* value )
{
    if ( json_array_append_new( array, value ) != 0 )
        d->failed = true;
}

json_t* rf_glb_reals( const float* values, int count )
{
    json_t* array = json_array();
    for ( int i = 0; i < count; ++i )
    {
        if ( json_array_append_new( array, json_real( (double)values[i] ) ) != 0 )
        {
            json_decref( array );
            return NULL;
        }
    }
    return array;
}

json_t* rf_glb_name( const char* name )
{
    json_t* text = json_string( name );
    if ( text != NULL )
        return text;
    char* plain = strdup( name );
    for ( char* c = plain; c != NULL && *c != 0; ++c )
        *c = (unsigned char)*c >= 0x80 ? '?' : *c;
    text = plain != NULL ? json_string( plain ) : NULL;
    free( plain );
    return text;
}
