// Reads and validates a view. Whether there is one of its name is asked where a picture is shown.
#include "scene/json/view_json.h"

#include <stdio.h>
#include <string.h>

static RfResult read_name( const RfField* object, const char* key, char name[RF_VIEW_NAME_SIZE] )
{
    RfField field = rf_field_member( object, key );
    const char* text = "";
    RfResult result = rf_field_text( &field, &text );
    if ( result == RF_OK && strlen( text ) >= RF_VIEW_NAME_SIZE )
        return rf_field_fail( &field, "is longer than %d characters", RF_VIEW_NAME_SIZE - 1 );
    snprintf( name, RF_VIEW_NAME_SIZE, "%s", text );
    return result;
}

RfResult rf_read_view( const RfField* object, RfViewText* view )
{
    static const char* const s_keys[] = { "transform", "look", "exposure", "gamma", NULL };
    if ( object->json == NULL )
        return RF_OK;
    RfViewText read = { .gamma = 1.0 };
    rf_field_keys( object, s_keys );
    rf_field_require( object, "transform", "the name of a view, such as \"AgX\"" );
    read_name( object, "transform", read.transform );
    read_name( object, "look", read.look );
    rf_get_number( object, "exposure", rf_range( -32.0, 32.0 ), &read.exposure );
    RfResult result = rf_get_number( object, "gamma", rf_range( 0.01, 100.0 ), &read.gamma );
    *view = result == RF_OK ? read : *view;
    return result;
}
