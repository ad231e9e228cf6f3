// `extras.reframe` of the scene object: the environment, and what gltf_shot.c reads.
//
//     {"environment": {"radiance": [r, g, b], "map": "sky.exr", "rotation": 90, "visible":
//     false}}
//
// A map inside the file is a bufferView with the bytes of an EXR or HDR instead: {"bufferView": 7}.

#include "scene/json/environment_json.h"
#include "scene/gltf/gltf_document.h"

#include <stdlib.h>

static RfResult load_map( RfGltf* gltf, const RfField* object, const char* uri )
{
    char* path;
    RfEnvironment* environment = &gltf->scene->environment;
    RfResult result = rf_gltf_resolve_uri( gltf, object->path, uri, &path );
    if ( result != RF_OK )
        return result;
    result = rf_load_environment( object, path, environment );
    free( path );
    if ( result == RF_OK )
        gltf->scene->content_hash = rf_hash_environment( gltf->scene->content_hash, environment );
    return result;
}

// The bytes of the file, and with them those of the view, are in the scene's hash already.
static RfResult decode_map( const RfGltf* gltf, const RfField* object, int view )
{
    RfWhere where = rf_where( "bufferViews[%d]", view );
    int64_t length = 0;
    const uint8_t* bytes = NULL;
    RfField field = rf_field_member( object, "bufferView" );
    if ( view >= gltf->counts[RF_GLTF_BUFFER_VIEWS] )
        return rf_field_fail( &field, "names bufferView %d, but there are %d", view, gltf->counts[RF_GLTF_BUFFER_VIEWS] );
    RfResult result = rf_gltf_get_integer( gltf, rf_gltf_item( gltf, RF_GLTF_BUFFER_VIEWS, view ), where.text, "byteLength", 1,
                                           INT64_MAX, &length );
    if ( result == RF_OK )
        result = rf_gltf_view_bytes( gltf, object->path, view, 0, (uint64_t)length, &bytes );
    return result == RF_OK ? rf_decode_environment( object, bytes, (size_t)length, &gltf->scene->environment ) : result;
}

RfResult rf_gltf_load_environment( RfGltf* gltf )
{
    static const char* const s_keys[] = { "environment", "render", "moving", "export_warnings", NULL };
    int index = 0;
    if ( gltf->counts[RF_GLTF_SCENES] == 0 )
        return RF_OK;
    RfResult result = rf_gltf_get_index( gltf, gltf->root, "document", "scene", RF_GLTF_SCENES, &index );
    index = index >= 0 ? index : 0;
    // extras of other programs may have any type
    const json_t* extras = json_object_get( rf_gltf_item( gltf, RF_GLTF_SCENES, index ), "extras" );
    const json_t* ours = json_object_get( extras, "reframe" );
    if ( result != RF_OK || ours == NULL )
        return result;
    RfWhere where = rf_where( "scenes[%d].extras.reframe", index );
    RfField field = rf_make_field( gltf->path, where.text, ours, gltf->error );
    result = rf_field_keys( &field, s_keys );
    if ( result == RF_OK )
        result = rf_gltf_read_shot( gltf, &field );
    if ( result == RF_OK )
        result = rf_gltf_read_warnings( gltf, &field );
    RfField object = rf_field_member( &field, "environment" );
    if ( result != RF_OK || object.json == NULL )
        return result;
    const char* map;
    int view = -1;
    result = rf_read_environment( &object, &gltf->scene->environment, &map, &view );
    if ( result == RF_OK && view >= 0 )
        return decode_map( gltf, &object, view );
    return result == RF_OK && map != NULL ? load_map( gltf, &object, map ) : result;
}
