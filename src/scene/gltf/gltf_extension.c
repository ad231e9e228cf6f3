// Extensions: those that change the image are supported, rejected if required, or reported. Here are their names alone; their
// values are read where they belong: gltf_material.c, gltf_texture.c, gltf_light.c, gltf_node.c, gltf_primitive.c.

#include "scene/gltf/gltf_document.h"

#include <string.h>

// Limit of unknown extensions reported per file.
#define MAX_NAMED 32

// Fully supported: a file may require these.
static const char* const s_read[] = {
    "KHR_materials_emissive_strength", "KHR_materials_specular",  "KHR_materials_ior",
    "KHR_materials_transmission",      "KHR_materials_volume",    "KHR_materials_unlit",
    "KHR_materials_clearcoat",         "KHR_lights_punctual",     "KHR_texture_transform",
    "KHR_mesh_quantization",           "EXT_mesh_gpu_instancing", "KHR_node_visibility",
    "KHR_animation_pointer",
};

// Not supported, with what the user sees instead. Objects that use one are reported.
static const struct
{
    const char* name;
    const char* instead;
} s_unread[] = {
    { "KHR_materials_sheen", "it is rendered without its sheen" },
    { "KHR_materials_anisotropy", "it is rendered isotropic" },
    { "KHR_materials_iridescence", "it is rendered without its film" },
    { "KHR_materials_dispersion", "it is rendered without dispersion" },
    { "KHR_materials_pbrSpecularGlossiness", "it is rendered by its metallic-roughness factors" },
};

#define COUNT_OF( array ) ( sizeof( array ) / sizeof( array )[0] )

_Static_assert( COUNT_OF( s_unread ) <= 32, "RfGltf.noticed_extensions has a bit for each" );

static bool is_read( const char* name )
{
    for ( size_t i = 0; i < COUNT_OF( s_read ); ++i )
    {
        if ( strcmp( name, s_read[i] ) == 0 )
            return true;
    }
    return false;
}

static bool is_compression( const char* name )
{
    return strcmp( name, "KHR_draco_mesh_compression" ) == 0 || strcmp( name, "EXT_meshopt_compression" ) == 0 ||
           strcmp( name, "KHR_meshopt_compression" ) == 0;
}

static RfResult fail_unsupported( const RfGltf* gltf, const char* name )
{
    if ( is_compression( name ) )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "extensionsRequired",
                             "%.80s is not supported: unpack the file by `npx @gltf-transform/cli copy in.glb out.glb`", name );
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "extensionsRequired", "%.80s is not supported: export the scene without it",
                         name );
}

RfResult rf_gltf_check_required( const RfGltf* gltf )
{
    const json_t* list = NULL;
    RfResult result = rf_gltf_get_array( gltf, gltf->root, "document", "extensionsRequired", &list );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( list ); ++i )
    {
        const char* name = json_string_value( json_array_get( list, i ) );
        if ( name == NULL )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, "extensionsRequired", "[%zu] must be a string", i );
        if ( is_read( name ) == false )
            result = fail_unsupported( gltf, name );
    }
    return result;
}

// Warns once of row i, of which `user` makes use.
static void notice_row( RfGltf* gltf, size_t i, const char* user )
{
    uint32_t bit = 1u << i;
    if ( ( gltf->noticed_extensions & bit ) == 0 )
        rf_warn( gltf->log, "%s: %s is not supported yet: %s: %s", gltf->path, s_unread[i].name, user, s_unread[i].instead );
    gltf->noticed_extensions |= bit;
}

void rf_gltf_notice_extensions( RfGltf* gltf, const json_t* object, const char* kind, const char* name )
{
    const json_t* extensions = json_object_get( object, "extensions" );
    if ( json_object_size( extensions ) == 0 )
        return;
    RfWhere user = rf_where( "%s '%.80s'", kind, name );
    for ( size_t i = 0; i < COUNT_OF( s_unread ); ++i )
    {
        if ( json_object_get( extensions, s_unread[i].name ) != NULL && !is_read( s_unread[i].name ) )
            notice_row( gltf, i, user.text );
    }
}

static bool uses( const json_t* value, const char* extension )
{
    const char* key;
    const json_t* item;
    size_t i;
    bool found = json_object_get( json_object_get( value, "extensions" ), extension ) != NULL;
    json_object_foreach( (json_t*)value, key, item ) found = found || uses( item, extension );
    json_array_foreach( value, i, item ) found = found || uses( item, extension );
    return found;
}

static RfWhere name_item( const json_t* item, const char* list, const char* kind, size_t i )
{
    const char* name = json_string_value( json_object_get( item, "name" ) );
    return name != NULL && name[0] != 0 ? rf_where( "%s '%.60s'", kind, name ) : rf_where( "%s[%zu]", list, i );
}

static bool find_in_list( const json_t* list, const char* extension, const char* list_name, const char* kind, RfWhere* user )
{
    const json_t* item;
    size_t i;
    json_array_foreach( list, i, item )
    {
        if ( !uses( item, extension ) )
            continue;
        *user = name_item( item, list_name, kind, i );
        return true;
    }
    return false;
}

// Of the default scene: nothing is lost with others.
static bool find_in_nodes( const RfGltf* gltf, const char* extension, RfWhere* user )
{
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        const json_t* item = rf_gltf_item( gltf, RF_GLTF_NODES, gltf->order[i] );
        if ( !uses( item, extension ) )
            continue;
        *user = name_item( item, "nodes", "node", (size_t)gltf->order[i] );
        return true;
    }
    return false;
}

// The first object with an extension, in words: "material 'paint'" or "nodes[3]".
static bool find_user( const RfGltf* gltf, const char* extension, RfWhere* user )
{
    static const char* const s_lists[][2] = {
        { "materials", "material" }, { "meshes", "mesh" },          { "textures", "texture" }, { "images", "image" },
        { "cameras", "camera" },     { "animations", "animation" }, { "scenes", "scene" },     { "skins", "skin" },
        { "samplers", "sampler" },   { "accessors", "accessor" },   { "buffers", "buffer" },   { "bufferViews", "view" },
    };
    const json_t* own = json_object_get( gltf->root, "extensions" );
    const json_t* lights = json_object_get( json_object_get( own, "KHR_lights_punctual" ), "lights" );
    if ( find_in_nodes( gltf, extension, user ) || find_in_list( lights, extension, "lights", "light", user ) )
        return true;
    for ( size_t k = 0; k < COUNT_OF( s_lists ); ++k )
    {
        const json_t* list = json_object_get( gltf->root, s_lists[k][0] );
        if ( find_in_list( list, extension, s_lists[k][0], s_lists[k][1], user ) )
            return true;
    }
    *user = rf_where( "the file" );
    return json_object_get( own, extension ) != NULL || uses( own, extension ) ||
           uses( json_object_get( gltf->root, "asset" ), extension );
}

static void notice_used( RfGltf* gltf, const char* name, int* unknown )
{
    RfWhere user;
    if ( is_read( name ) )
        return;
    for ( size_t i = 0; i < COUNT_OF( s_unread ); ++i )
    {
        if ( strcmp( name, s_unread[i].name ) != 0 )
            continue;
        if ( ( gltf->noticed_extensions >> i & 1 ) == 0 && find_user( gltf, name, &user ) )
            notice_row( gltf, i, user.text );
        return;
    }
    if ( ++*unknown > MAX_NAMED )
        return;
    bool found = find_user( gltf, name, &user );
    rf_warn( gltf->log, "%s: extension %.80s is unknown: what it adds%s%s is left out", gltf->path, name, found ? " to " : "",
             found ? user.text : "" );
}

RfResult rf_gltf_notice_unread( RfGltf* gltf )
{
    const json_t* list = NULL;
    RfResult result = rf_gltf_get_array( gltf, gltf->root, "document", "extensionsUsed", &list );
    int unknown = 0;
    for ( size_t i = 0; result == RF_OK && i < json_array_size( list ); ++i )
    {
        const char* name = json_string_value( json_array_get( list, i ) );
        if ( name == NULL )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, "extensionsUsed", "[%zu] must be a string", i );
        notice_used( gltf, name, &unknown );
    }
    return result;
}
