// What the program that wrote a file warned of, in `extras.reframe` of the scene:
//
//     {"export_warnings": ["'Sphere': material 'skin': subsurface scattering: taken as diffuse"]}

#include "scene/gltf/gltf_document.h"
#include "scene/json/json_document.h"

#include <stdlib.h>
#include <string.h>

#define MAX_WARNINGS 100000

// Control characters, C1 in UTF-8 among them, would reach the terminal.
static void make_printable( char* text )
{
    for ( unsigned char* c = (unsigned char*)text; *c != 0; ++c )
    {
        if ( *c < 0x20 || *c == 0x7f )
            *c = '?';
        else if ( c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0 )
            c[0] = c[1] = '?';
    }
}

RfResult rf_gltf_read_warnings( RfGltf* gltf, const RfField* ours )
{
    RfScene* scene = gltf->scene;
    RfField list = rf_field_member( ours, "export_warnings" );
    if ( list.json == NULL )
        return RF_OK;
    RfResult result = rf_field_array( &list, "texts", 0, MAX_WARNINGS );
    if ( result != RF_OK )
        return result;
    size_t count = json_array_size( list.json );
    scene->export_warnings = calloc( count + 1, sizeof *scene->export_warnings );
    if ( scene->export_warnings == NULL )
        return rf_gltf_no_memory( gltf, "export_warnings" );
    for ( size_t i = 0; i < count; ++i )
    {
        const char* text = "";
        RfField item = rf_field_item( &list, i );
        result = rf_field_text( &item, &text );
        if ( result != RF_OK )
            return result;
        scene->export_warnings[i] = strdup( text );
        if ( scene->export_warnings[i] == NULL )
            return rf_gltf_no_memory( gltf, "export_warnings" );
        make_printable( scene->export_warnings[i] );
        scene->export_warning_count += 1;
    }
    return RF_OK;
}
