#include "scene/gltf/gltf.h"

#include "base/blend_file.h"
#include "base/file.h"
#include "scene/gltf/glb.h"
#include "scene/gltf/gltf_geometry.h"
#include "scene/gltf/gltf_materials.h"
#include "scene/json/json_value.h"

#include <stdlib.h>
#include <string.h>

#define MAX_FILE_BYTES ( (uint64_t)64 << 30 )

// The parser needs about twenty times the size of the text.
#define MAX_JSON_BYTES ( (size_t)1 << 29 )

static RfResult parse( RfGltf* gltf, const char* text, size_t size )
{
    if ( size > MAX_JSON_BYTES )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "document",
                             "%zu bytes of JSON are too many, the limit is %zu: put buffers into a .glb or .bin", size,
                             MAX_JSON_BYTES );
    return rf_parse_json( gltf->path, text, size, "not valid glTF JSON, export the scene as .glb or .gltf",
                          "document: ", &gltf->root, gltf->error );
}

static RfResult open_document( RfGltf* gltf )
{
    RfResult result = rf_read_file( gltf->path, MAX_FILE_BYTES, &gltf->file, &gltf->file_size, gltf->error );
    if ( result != RF_OK )
        return result;
    gltf->scene->content_hash = rf_hash_bytes( RF_HASH_START, gltf->file, gltf->file_size );
    result = rf_refuse_blend_file( gltf->path, gltf->file, gltf->file_size, gltf->error );
    if ( result != RF_OK )
        return result;
    if ( rf_is_glb( gltf->file, gltf->file_size ) == false )
        return parse( gltf, (const char*)gltf->file, gltf->file_size );

    RfGlb glb;
    result = rf_split_glb( gltf->path, gltf->file, gltf->file_size, &glb, gltf->error );
    if ( result != RF_OK )
        return result;
    gltf->bin = glb.bin;
    gltf->bin_size = glb.bin_size;
    return parse( gltf, (const char*)glb.json, glb.json_size );
}

// True for "2." followed by digits.
static bool is_version_2( const char* version )
{
    return strncmp( version, "2.", 2 ) == 0 && version[2] != 0 && strspn( version + 2, "0123456789" ) == strlen( version + 2 );
}

static RfResult check_asset( const RfGltf* gltf )
{
    const json_t* asset = NULL;
    const char *version = "", *least = "2.0";
    RfResult result = rf_gltf_require( gltf, gltf->root, "document", "asset" );
    if ( result == RF_OK )
        result = rf_gltf_get_object( gltf, gltf->root, "document", "asset", &asset );
    if ( result == RF_OK )
        result = rf_gltf_require( gltf, asset, "asset", "version" );
    if ( result == RF_OK )
        result = rf_gltf_get_string( gltf, asset, "asset", "version", &version );
    if ( result == RF_OK )
        result = rf_gltf_get_string( gltf, asset, "asset", "minVersion", &least );
    if ( result != RF_OK )
        return result;
    if ( is_version_2( version ) == false || strcmp( least, "2.0" ) != 0 )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "asset",
                             "is glTF %.20s and needs a reader of %.20s or later: export it as glTF 2.0", version, least );
    return RF_OK;
}

static RfResult read_document( RfGltf* gltf )
{
    RfResult result = check_asset( gltf );
    if ( result == RF_OK )
        result = rf_gltf_check_required( gltf );
    if ( result == RF_OK )
        result = rf_gltf_open_lists( gltf );
    if ( result != RF_OK )
        return result;
    gltf->accessors = calloc( (size_t)gltf->counts[RF_GLTF_ACCESSORS] + 1, sizeof *gltf->accessors );
    if ( gltf->accessors == NULL )
        return rf_gltf_no_memory( gltf, "accessors" );
    result = rf_gltf_load_buffers( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_materials( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_nodes( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_animations( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_cameras( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_lights( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_environment( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_meshes( gltf );
    if ( result == RF_OK )
        result = rf_gltf_load_images( gltf );
    if ( result == RF_OK )
        rf_gltf_warn_of_moving( gltf );
    return result == RF_OK ? rf_gltf_notice_unread( gltf ) : result;
}

static void close_document( RfGltf* gltf )
{
    rf_gltf_free_buffers( gltf );
    json_decref( gltf->root );
    free( gltf->file );
    free( gltf->accessors );
    free( gltf->spans );
    free( gltf->order );
    free( gltf->remap );
    free( gltf->remap_stamp );
}

static RfResult load_around( const double origin[3], const char* path, const RfGltfEdit* edit, RfScene* scene, RfLog* log,
                             RfError* error )
{
    memset( scene, 0, sizeof *scene );
    memcpy( scene->origin, origin, sizeof scene->origin );
    RfGltf gltf = { .path = path, .scene = scene, .log = log, .error = error, .default_material = -1 };
    scene->path = strdup( path );
    RfResult result = scene->path != NULL ? open_document( &gltf ) : rf_gltf_no_memory( &gltf, "document" );
    if ( result == RF_OK && edit != NULL )
        result = edit->run( edit->user, gltf.root, error );
    if ( result == RF_OK )
        result = read_document( &gltf );
    close_document( &gltf );
    if ( result != RF_OK )
        rf_destroy_scene( scene );
    return result;
}

// A scene that lies far out is loaded a second time, around its middle: rounded to floats only then.
RfResult rf_load_edited_gltf( const char* path, const RfGltfEdit* edit, RfScene* scene, RfLog* log, RfError* error )
{
    double origin[3] = { 0 };
    RfResult result = load_around( origin, path, edit, scene, log, error );
    if ( result != RF_OK || !rf_gltf_find_origin( scene, origin ) )
        return result;
    rf_destroy_scene( scene );
    return load_around( origin, path, edit, scene, NULL, error );
}

RfResult rf_load_gltf( const char* path, RfScene* scene, RfLog* log, RfError* error )
{
    return rf_load_edited_gltf( path, NULL, scene, log, error );
}
