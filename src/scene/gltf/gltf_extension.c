// Extensions: those that change the image are supported, rejected if required, or reported. Here are their names alone; their
// values are read where they belong: gltf_material.c, gltf_texture.c, gltf_light.c, gltf_node.c, gltf_primitive.c,
// gltf_draco.c, gltf_meshopt.c.

#include "scene/gltf/gltf_document.h"

#include "image/decode.h"

#include <string.h>

// Limit of unknown extensions reported per file.
#define MAX_NAMED 32

// Fully supported: a file may require these.
static const char* const s_read[] = {
    "KHR_materials_emissive_strength",
    "KHR_materials_specular",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_unlit",
    "KHR_materials_clearcoat",
    "KHR_lights_punctual",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    "KHR_node_visibility",
    "KHR_animation_pointer",
    "EXT_texture_exr",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_sheen",
    "KHR_materials_variants",
    "KHR_materials_anisotropy",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_dispersion",
};

// Without effect on pictures: metadata, sounds, what users do, levels of detail besides the finest.
static const char* const s_harmless[] = {
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_audio_emitter",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "EXT_structural_metadata",
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_feature_metadata",
    "AGI_stk_metadata",
    "FB_geometry_metadata",
    "FB_ngon_encoding",
    "MSFT_audio_emitter",
    "MSFT_lod",
};

// Not supported, with what the user sees instead. Objects that use one are reported.
static const struct
{
    const char* name;
    const char* instead;
} s_unread[] = {
    { "KHR_materials_volume_scatter",
      "dense bodies are rendered opaque, in the colour of their multiple scattering, others without scattering inside" },
    { "KHR_texture_basisu", "its other image is used" },
    { "EXT_texture_avif", "its other image is used" },
    { "EXT_texture_webp", "its other image is used" }, // of a build without libwebp
    { "MSFT_texture_dds", "its other image is used" },
    { "KHR_interactivity", "it is as before anything happens" },
    { "EXT_lights_image_based", "it is rendered without that light: name an image by \"environment\" in a scene file" },
    { "EXT_lights_ies", "it shines without its profile" },
};

#define COUNT_OF( array ) ( sizeof( array ) / sizeof( array )[0] )

_Static_assert( COUNT_OF( s_unread ) <= 32, "RfGltf.noticed_extensions has a bit for each" );

static bool is_listed( const char* name, const char* const* list, size_t count )
{
    for ( size_t i = 0; i < count; ++i )
    {
        if ( strcmp( name, list[i] ) == 0 )
            return true;
    }
    return false;
}

// Of meshes and buffers: read where the build has the library.
static const struct
{
    const char *name, *library;
    bool ( *is_built )( void );
} s_packed[] = {
    { "KHR_draco_mesh_compression", "Draco", rf_gltf_has_draco },
    { "EXT_meshopt_compression", "meshoptimizer", rf_gltf_has_meshopt },
    { "KHR_meshopt_compression", "meshoptimizer", rf_gltf_has_meshopt },
};

// Its row of s_packed, or −1.
static int find_packed( const char* name )
{
    for ( size_t i = 0; i < COUNT_OF( s_packed ); ++i )
    {
        if ( strcmp( name, s_packed[i].name ) == 0 )
            return (int)i;
    }
    return -1;
}

// The library of an extension that this build lacks, or NULL.
static const char* missing_library( const char* extension )
{
    int row = find_packed( extension );
    return row >= 0 && !s_packed[row].is_built() ? s_packed[row].library : NULL;
}

bool rf_gltf_reads( const char* extension )
{
    return is_listed( extension, s_read, COUNT_OF( s_read ) ) ||
           ( rf_decodes_webp() && strcmp( extension, "EXT_texture_webp" ) == 0 ) ||
           ( find_packed( extension ) >= 0 && missing_library( extension ) == NULL );
}

// Nothing is lost.
static bool is_read( const char* name ) { return rf_gltf_reads( name ) || is_listed( name, s_harmless, COUNT_OF( s_harmless ) ); }

// Images that are not decoded, with what to do.
static const struct
{
    const char* name;
    const char* advice;
} s_images[] = {
    { "KHR_texture_basisu",
      "KTX2 images are not supported: convert them by `npx @gltf-transform/cli ktxdecompress in.glb out.glb`, which "
      "needs Khronos' KTX-Software" },
    { "EXT_texture_webp",
      "this Reframe was built without libwebp: convert the images by `npx @gltf-transform/cli png --formats \"*\" "
      "in.glb out.glb`" },
    { "EXT_texture_avif",
      "AVIF images are not supported: convert them by `npx @gltf-transform/cli png --formats \"*\" in.glb out.glb`" },
    { "MSFT_texture_dds", "DDS images are not supported: store them as PNG" },
};

// What to do about an image of this extension, or NULL.
static const char* find_image_advice( const char* name )
{
    for ( size_t i = 0; i < COUNT_OF( s_images ); ++i )
    {
        if ( strcmp( name, s_images[i].name ) == 0 && !rf_gltf_reads( name ) )
            return s_images[i].advice;
    }
    return NULL;
}

RfResult rf_gltf_refuse_texture( const RfGltf* gltf, const RfField* texture )
{
    const char* key;
    json_t* value;
    json_object_foreach( json_object_get( texture->json, "extensions" ), key, value )
    {
        const char* advice = find_image_advice( key );
        if ( advice != NULL )
            return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, texture->path, "%s", advice );
    }
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, texture->path, "has no source: give it a PNG, JPEG or WebP" );
}

static RfResult fail_unsupported( const RfGltf* gltf, const char* name )
{
    if ( missing_library( name ) != NULL )
        return rf_gltf_fail_left_out( gltf, "extensionsRequired", name, missing_library( name ) );
    const char* advice = find_image_advice( name );
    if ( advice != NULL )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "extensionsRequired", "%s: %s", name, advice );
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "extensionsRequired", "%.80s is not supported: export the scene without it",
                         name );
}

RfResult rf_gltf_check_required( RfGltf* gltf )
{
    RfField root = rf_gltf_root( gltf );
    const json_t* list = rf_get_array( &root, "extensionsRequired" ).json;
    RfResult result = rf_json_result( &root );
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

void rf_gltf_notice_extensions( RfGltf* gltf, const RfField* object, const char* kind, const char* name )
{
    const json_t* extensions = json_object_get( object->json, "extensions" );
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
    const char* library = missing_library( name );
    if ( library != NULL )
    {
        rf_warn( gltf->log, "%s: %s needs %s, which this build of reframe lacks: the uncompressed meshes are taken", gltf->path,
                 name, library );
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
    RfField root = rf_gltf_root( gltf );
    const json_t* list = rf_get_array( &root, "extensionsUsed" ).json;
    RfResult result = rf_json_result( &root );
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
