// `extras.reframe` of the scene object: the environment, and what gltf_shot.c reads.
//
//     {"environment": {"radiance": [r, g, b], "map": "sky.exr", "rotation": 90, "visible":
//     false}}

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

RfResult rf_gltf_load_environment( RfGltf* gltf )
{
    static const char* const s_keys[] = { "environment", "render", "moving", NULL };
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
    RfField object = rf_field_member( &field, "environment" );
    if ( result != RF_OK || object.json == NULL )
        return result;
    const char* map;
    result = rf_read_environment( &object, &gltf->scene->environment, &map );
    return result == RF_OK && map != NULL ? load_map( gltf, &object, map ) : result;
}
