// Errors with the place in the document, typed reads of its values, which extensions are read, and variants of materials.
#include "gltf/gltf_document.h"

#include "base/try.h"
#include "base/words.h"
#include "image/decode.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Limit of objects of a kind: more means a broken or malicious file.
#define MAX_ITEMS 16777216

static const char* const s_list_names[RF_GLTF_LIST_COUNT] = {
    [RF_GLTF_ACCESSORS] = "accessors", [RF_GLTF_ANIMATIONS] = "animations",
    [RF_GLTF_BUFFERS] = "buffers",     [RF_GLTF_BUFFER_VIEWS] = "bufferViews",
    [RF_GLTF_CAMERAS] = "cameras",     [RF_GLTF_MATERIALS] = "materials",
    [RF_GLTF_MESHES] = "meshes",       [RF_GLTF_NODES] = "nodes",
    [RF_GLTF_SCENES] = "scenes",       [RF_GLTF_IMAGES] = "images",
    [RF_GLTF_SAMPLERS] = "samplers",   [RF_GLTF_TEXTURES_LIST] = "textures",
    [RF_GLTF_SKINS_LIST] = "skins",
};

RfWhere rf_where( const char* format, ... )
{
    RfWhere where;
    va_list args;
    va_start( args, format );
    vsnprintf( where.text, sizeof where.text, format, args );
    va_end( args );
    return where;
}

RfResult rf_gltf_fail( const RfGltf* gltf, RfResult code, const char* where, const char* format, ... )
{
    char text[640];
    va_list args;
    if ( gltf->error->code != RF_OK ) // which came first
        return gltf->error->code;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    const char* advice = code == RF_ERROR_FORMAT ? ": not valid glTF 2.0, export the scene again" : "";
    return rf_fail( gltf->error, code, "%s: %s: %s%s", gltf->path, where, text, advice );
}

RfResult rf_gltf_check_limit( const RfGltf* gltf, const char* where, const char* key, double value, double limit )
{
    if ( fabs( value ) <= limit )
        return gltf->error->code;
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                         "%s is %g, beyond what reframe reads: at most %g, change it in the scene", key, value, limit );
}

// Room doubles where the count is a power of two.
bool rf_gltf_grow( void* list, int count, size_t size )
{
    size_t items = (size_t)count;
    return ( items & ( items - 1 ) ) != 0 || rf_make_room( list, 2 * items, size );
}

RfResult rf_gltf_allocate( const RfGltf* gltf, const char* where, void* list, size_t count, size_t size )
{
    void* made = calloc( count + 1, size );
    memcpy( list, &made, sizeof made );
    return made != NULL ? RF_OK : rf_gltf_no_memory( gltf, where );
}

RfResult rf_gltf_no_memory( const RfGltf* gltf, const char* where )
{
    return rf_gltf_fail( gltf, RF_ERROR_MEMORY, where, "out of memory: close other programs" );
}

void rf_gltf_notice( RfGltf* gltf, const char* format, ... )
{
    int kind = 0;
    while ( kind < RF_GLTF_NOTICES && gltf->noticed[kind] != NULL && strcmp( gltf->noticed[kind], format ) != 0 )
        ++kind;
    if ( kind == RF_GLTF_NOTICES || gltf->noticed[kind] != NULL )
        return;
    gltf->noticed[kind] = format;
    char text[512];
    va_list args;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    rf_warn( gltf->log, "%s: %s", gltf->path, text );
}

RfResult rf_gltf_note_unrendered( RfGltf* gltf, const char* what, const char* format, ... )
{
    char why[256];
    va_list args;
    va_start( args, format );
    vsnprintf( why, sizeof why, format, args );
    va_end( args );
    return rf_note_unrendered( gltf->scene, what, why ) ? RF_OK : rf_gltf_no_memory( gltf, "animations" );
}

RfResult rf_gltf_fail_left_out( const RfGltf* gltf, const char* where, const char* extension, const char* library )
{
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "%s needs %s, which this build of reframe lacks: " RF_GLTF_UNPACK,
                         extension, library );
}

static bool has_draco( void )
{
#ifdef REFRAME_DRACO
    return true;
#else
    return false;
#endif
}

bool rf_gltf_has_meshopt( void )
{
#ifdef REFRAME_MESHOPT
    return true;
#else
    return false;
#endif
}

RfField rf_gltf_field( const RfGltf* gltf, const char* path, const json_t* json )
{
    RfField field = rf_make_field( gltf->path, path, json, gltf->error );
    field.gltf = true;
    return field;
}

RfField rf_gltf_root( const RfGltf* gltf ) { return rf_gltf_field( gltf, "document", gltf->root ); }

RfField rf_gltf_item_field( const RfGltf* gltf, RfGltfList list, int index )
{
    RfField all = rf_gltf_field( gltf, s_list_names[list], gltf->lists[list] );
    return rf_field_item( &all, (size_t)index );
}

RfField rf_gltf_primitives( const RfGltf* gltf, int mesh )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_MESHES, mesh );
    rf_gltf_require( &json, "primitives", NULL );
    RfField primitives = rf_get_array( &json, "primitives" );
    for ( size_t i = 0; i < json_array_size( primitives.json ); ++i )
    {
        if ( !json_is_object( json_array_get( primitives.json, i ) ) )
            rf_gltf_fail( gltf, RF_ERROR_FORMAT, rf_where( "%s[%zu]", primitives.path, i ).text, "must be an object" );
    }
    return primitives;
}

RfResult rf_gltf_require( const RfField* object, ... )
{
    va_list args;
    va_start( args, object );
    for ( const char* key = va_arg( args, const char* ); key != NULL; key = va_arg( args, const char* ) )
        rf_field_require( object, key, "" );
    va_end( args );
    return rf_json_result( object );
}

int rf_gltf_get_index( const RfGltf* gltf, const RfField* object, const char* key, RfGltfList list )
{
    int64_t value = -1;
    // the range is checked below, for a message with the length of the list
    RfResult result = rf_get_integer( object, key, INT64_MIN, INT64_MAX, &value );
    if ( result != RF_OK || !rf_has_member( object, key ) || ( value >= 0 && value < gltf->counts[list] ) )
        return result == RF_OK ? (int)value : -1;
    RfField member = rf_field_member( object, key );
    rf_field_fail( &member, "is %lld, but there are %d %s", (long long)value, gltf->counts[list], s_list_names[list] );
    return -1;
}

RfField rf_gltf_extension( const RfField* object, const char* name )
{
    if ( !rf_has_member( object, "extensions" ) )
        return rf_make_field( object->file, "", NULL, object->error );
    RfField extensions = rf_get_object( object, "extensions" );
    return rf_get_object( &extensions, name );
}

RfField rf_gltf_home( const RfField* object, const char* home )
{
    if ( home == NULL )
        return *object;
    return strncmp( home, "KHR_", 4 ) == 0 ? rf_gltf_extension( object, home ) : rf_get_object( object, home );
}

RfField rf_gltf_extras( const RfField* object )
{
    const json_t* ours = json_object_get( json_object_get( object->json, "extras" ), "reframe" );
    if ( ours == NULL )
        return rf_make_field( object->file, "", NULL, object->error );
    return rf_make_field( object->file, rf_where( "%.140s.extras.reframe", object->path ).text, ours, object->error );
}

RfResult rf_gltf_copy_name( const RfField* object, const char* fallback, char** name )
{
    const char* text = fallback;
    RF_TRY( rf_get_text( object, "name", &text ) );
    *name = strdup( text[0] != 0 ? text : fallback );
    return *name != NULL ? RF_OK : rf_field_no_memory( object );
}

const json_t* rf_gltf_item( const RfGltf* gltf, RfGltfList list, int index )
{
    return json_array_get( gltf->lists[list], (size_t)index );
}

RfResult rf_gltf_open_lists( RfGltf* gltf )
{
    RfField root = rf_gltf_root( gltf );
    for ( int list = 0; list < RF_GLTF_LIST_COUNT; ++list )
    {
        const char* name = s_list_names[list];
        gltf->lists[list] = rf_get_array( &root, name ).json;
        size_t count = json_array_size( gltf->lists[list] );
        if ( count > MAX_ITEMS )
            return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, name, "%zu objects are too many, the limit is %d: split the scene",
                                 count, MAX_ITEMS );
        gltf->counts[list] = (int)count;
        for ( int i = 0; i < gltf->counts[list]; ++i )
        {
            const json_t* item = rf_gltf_item( gltf, (RfGltfList)list, i );
            if ( json_is_object( item ) == 0 )
                return rf_gltf_fail( gltf, RF_ERROR_FORMAT, name, "[%d] must be an object, got %s", i, rf_json_kind( item ) );
        }
    }
    return rf_json_result( &root );
}

// Extensions: those that change the image are supported, rejected if required, or reported. Here are their names alone; their
// values are read where they belong: gltf_material.c, gltf_texture.c, gltf_light.c, gltf_node.c, gltf_primitive.c,
// gltf_draco.c, gltf_buffer.c.

#define MAX_NAMED 32 // unknown ones, per file

static bool never( void ) { return false; }

// What is done with an extension, which a file may require where it is read.
typedef struct Extension
{
    const char* name;
    bool ( *is_read )( void ); // NULL: always
    const char* library;       // without which it is not
    const char* instead;       // what the user sees where it is not read; objects that use it are reported
    const char* advice;        // of images that are not decoded: what to do
} Extension;

#define READ NULL, NULL, NULL, NULL
#define HARMLESS READ // nothing is lost without it
#define OTHER_IMAGE NULL, "its other image is used"

static const Extension s_extensions[] = {
    { "KHR_materials_emissive_strength", READ },
    { "KHR_materials_specular", READ },
    { "KHR_materials_ior", READ },
    { "KHR_materials_transmission", READ },
    { "KHR_materials_volume", READ },
    { "KHR_materials_unlit", READ },
    { "KHR_materials_clearcoat", READ },
    { "KHR_lights_punctual", READ },
    { "KHR_texture_transform", READ },
    { "KHR_mesh_quantization", READ },
    { "EXT_mesh_gpu_instancing", READ },
    { "KHR_node_visibility", READ },
    { "KHR_animation_pointer", READ },
    { "EXT_texture_exr", READ },
    { "KHR_materials_diffuse_transmission", READ },
    { "KHR_materials_sheen", READ },
    { "KHR_materials_variants", READ },
    { "KHR_materials_anisotropy", READ },
    { "KHR_materials_iridescence", READ },
    { "KHR_materials_pbrSpecularGlossiness", READ },
    { "KHR_materials_dispersion", READ },
    { "CESIUM_RTC", READ },
    // metadata, sounds, what users do, levels of detail besides the finest
    { "KHR_xmp", HARMLESS },
    { "KHR_xmp_json_ld", HARMLESS },
    { "KHR_audio_emitter", HARMLESS },
    { "KHR_node_hoverability", HARMLESS },
    { "KHR_node_selectability", HARMLESS },
    { "EXT_structural_metadata", HARMLESS },
    { "EXT_mesh_features", HARMLESS },
    { "EXT_instance_features", HARMLESS },
    { "EXT_feature_metadata", HARMLESS },
    { "AGI_stk_metadata", HARMLESS },
    { "FB_geometry_metadata", HARMLESS },
    { "FB_ngon_encoding", HARMLESS },
    { "MSFT_audio_emitter", HARMLESS },
    { "MSFT_lod", HARMLESS },
    { "KHR_draco_mesh_compression", has_draco, "Draco", NULL, NULL },
    { "EXT_meshopt_compression", rf_gltf_has_meshopt, "meshoptimizer", NULL, NULL },
    { "KHR_meshopt_compression", rf_gltf_has_meshopt, "meshoptimizer", NULL, NULL },
    { "KHR_materials_volume_scatter", never, NULL,
      "dense bodies are rendered opaque, in the colour of their multiple scattering, others without scattering inside", NULL },
    { "KHR_texture_basisu", never, OTHER_IMAGE,
      "KTX2 images are not supported: convert them by `npx @gltf-transform/cli ktxdecompress in.glb out.glb`, which "
      "needs Khronos' KTX-Software" },
    { "EXT_texture_avif", never, OTHER_IMAGE,
      "AVIF images are not supported: convert them by `npx @gltf-transform/cli png --formats \"*\" in.glb out.glb`" },
    { "EXT_texture_webp", rf_decodes_webp, OTHER_IMAGE,
      "this Reframe was built without libwebp: convert the images by `npx @gltf-transform/cli png --formats \"*\" "
      "in.glb out.glb`" },
    { "MSFT_texture_dds", never, OTHER_IMAGE, "DDS images are not supported: store them as PNG" },
    { "KHR_interactivity", never, NULL, "it is as before anything happens", NULL },
    { "EXT_lights_image_based", never, NULL,
      "it is rendered without that light: name an image by \"environment\" in a scene file", NULL },
    { "EXT_lights_ies", never, NULL, "it shines without its profile", NULL },
};

#define COUNT_OF( array ) ( sizeof( array ) / sizeof( array )[0] )

_Static_assert( COUNT_OF( s_extensions ) <= 64, "RfGltf.noticed_extensions has a bit for each" );

// NULL: it is unknown.
static const Extension* find_extension( const char* name )
{
    for ( size_t i = 0; i < COUNT_OF( s_extensions ); ++i )
    {
        if ( strcmp( name, s_extensions[i].name ) == 0 )
            return s_extensions + i;
    }
    return NULL;
}

static bool is_read( const Extension* e ) { return e != NULL && ( e->is_read == NULL || e->is_read() ); }

bool rf_gltf_reads( const char* extension ) { return is_read( find_extension( extension ) ); }

// What to do about an image of this extension, or NULL.
static const char* find_image_advice( const char* name )
{
    const Extension* e = find_extension( name );
    return e != NULL && !is_read( e ) ? e->advice : NULL;
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
    const Extension* e = find_extension( name );
    if ( e != NULL && e->library != NULL )
        return rf_gltf_fail_left_out( gltf, "extensionsRequired", name, e->library );
    if ( e != NULL && e->advice != NULL )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "extensionsRequired", "%s: %s", name, e->advice );
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
        if ( !rf_gltf_reads( name ) )
            result = fail_unsupported( gltf, name );
    }
    return result;
}

// Warns once of an extension, of which `user` makes use.
static void notice_extension( RfGltf* gltf, const Extension* e, const char* user )
{
    uint64_t bit = (uint64_t)1 << ( e - s_extensions );
    if ( ( gltf->noticed_extensions & bit ) == 0 )
        rf_warn( gltf->log, "%s: %s is not supported yet: %s: %s", gltf->path, e->name, user, e->instead );
    gltf->noticed_extensions |= bit;
}

void rf_gltf_notice_extensions( RfGltf* gltf, const RfField* object, const char* kind, const char* name )
{
    const json_t* extensions = json_object_get( object->json, "extensions" );
    RfWhere user = rf_where( "%s '%.80s'", kind, name );
    for ( size_t i = 0; json_object_size( extensions ) > 0 && i < COUNT_OF( s_extensions ); ++i )
    {
        const Extension* e = s_extensions + i;
        if ( e->instead != NULL && !is_read( e ) && json_object_get( extensions, e->name ) != NULL )
            notice_extension( gltf, e, user.text );
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

// Of `count` items, in an order or as they are listed.
static bool find_in_list( const json_t* list, const int* order, size_t count, const char* extension, const char* const names[2],
                          RfWhere* user )
{
    for ( size_t i = 0; i < count; ++i )
    {
        size_t at = order != NULL ? (size_t)order[i] : i;
        const json_t* item = json_array_get( list, at );
        if ( !uses( item, extension ) )
            continue;
        *user = name_item( item, names[0], names[1], at );
        return true;
    }
    return false;
}

// The first object with an extension, in words: "material 'paint'" or "nodes[3]".
static bool find_user( const RfGltf* gltf, const char* extension, RfWhere* user )
{
    static const char *const s_nodes[2] = { "nodes", "node" }, *const s_lights[2] = { "lights", "light" };
    static const char* const s_lists[][2] = {
        { "materials", "material" }, { "meshes", "mesh" },          { "textures", "texture" }, { "images", "image" },
        { "cameras", "camera" },     { "animations", "animation" }, { "scenes", "scene" },     { "skins", "skin" },
        { "samplers", "sampler" },   { "accessors", "accessor" },   { "buffers", "buffer" },   { "bufferViews", "view" },
    };
    const json_t* own = json_object_get( gltf->root, "extensions" );
    const json_t* lights = json_object_get( json_object_get( own, "KHR_lights_punctual" ), "lights" );
    // of the nodes, those of the default scene: nothing is lost with others
    if ( find_in_list( gltf->lists[RF_GLTF_NODES], gltf->order, (size_t)gltf->order_count, extension, s_nodes, user ) ||
         find_in_list( lights, NULL, json_array_size( lights ), extension, s_lights, user ) )
        return true;
    for ( size_t k = 0; k < COUNT_OF( s_lists ); ++k )
    {
        const json_t* list = json_object_get( gltf->root, s_lists[k][0] );
        if ( find_in_list( list, NULL, json_array_size( list ), extension, s_lists[k], user ) )
            return true;
    }
    *user = rf_where( "the file" );
    return json_object_get( own, extension ) != NULL || uses( own, extension ) ||
           uses( json_object_get( gltf->root, "asset" ), extension );
}

static void notice_used( RfGltf* gltf, const char* name, int* unknown )
{
    RfWhere user;
    const Extension* e = find_extension( name );
    if ( is_read( e ) )
        return;
    if ( e != NULL && e->library != NULL )
        rf_warn( gltf->log, "%s: %s needs %s, which this build of reframe lacks: the uncompressed meshes are taken", gltf->path,
                 name, e->library );
    else if ( e != NULL )
    {
        if ( ( gltf->noticed_extensions >> ( e - s_extensions ) & 1 ) == 0 && find_user( gltf, name, &user ) )
            notice_extension( gltf, e, user.text );
    }
    else if ( ++*unknown <= MAX_NAMED )
    {
        bool found = find_user( gltf, name, &user );
        rf_warn( gltf->log, "%s: extension %.80s is unknown: what it adds%s%s is left out", gltf->path, name, found ? " to " : "",
                 found ? user.text : "" );
    }
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

// KHR_materials_variants: lists the variants of a file, and finds the materials of primitives in the one that is chosen.

#define VARIANTS "KHR_materials_variants"
#define NAMED_VARIANTS 16 // by a message

static RfResult list_variants( RfGltf* gltf, const RfField* list )
{
    RfScene* scene = gltf->scene;
    size_t count = json_array_size( list->json );
    RF_TRY( rf_gltf_allocate( gltf, VARIANTS, &scene->variants, count, sizeof *scene->variants ) );
    RfResult result = RF_OK;
    for ( size_t i = 0; result == RF_OK && i < count; ++i )
    {
        RfField item = rf_field_item( list, i );
        result = rf_gltf_require( &item, "name", NULL );
        if ( result == RF_OK )
            result = rf_gltf_copy_name( &item, item.path, scene->variants + i );
        scene->variant_count += result == RF_OK;
    }
    return result;
}

static RfResult find_chosen( const RfGltf* gltf, const json_t* list, int64_t* chosen )
{
    const RfScene* scene = gltf->scene;
    const char* wanted = gltf->options->variant;
    char names[NAMED_VARIANTS * 64 + 32] = "";
    const json_t* item;
    size_t i;
    json_array_foreach( list, i, item )
    {
        *chosen = (int64_t)i;
        if ( strcmp( scene->variants[i], wanted ) == 0 ) // as it is listed, where its name is empty too
            return RF_OK;
        if ( i < NAMED_VARIANTS )
            rf_append( names, sizeof names, "%s'%.50s'", i > 0 ? ", " : "", scene->variants[i] );
    }
    if ( i > NAMED_VARIANTS )
        rf_append( names, sizeof names, " and %zu more", i - NAMED_VARIANTS );
    return rf_gltf_fail( gltf, RF_ERROR_USAGE, VARIANTS, "none is called '%.80s'%s%s", wanted,
                         i > 0 ? ": there are " : ": there are none", names );
}

RfResult rf_gltf_material_of( const RfGltf* gltf, const RfField* primitive, int* material )
{
    const json_t* variant;
    size_t k;
    RfField extension = gltf->variant >= 0 ? rf_gltf_extension( primitive, VARIANTS ) : *primitive,
            mappings = gltf->variant >= 0 ? rf_get_array( &extension, "mappings" ) : extension;
    *material = -1;
    for ( size_t i = 0; i < json_array_size( mappings.json ); ++i )
    {
        RfField mapping = rf_field_item( &mappings, i );
        if ( !json_is_object( mapping.json ) )
            return rf_field_fail( &mapping, "must be an object" );
        RfField variants = rf_get_array( &mapping, "variants" );
        json_array_foreach( variants.json, k, variant )
        {
            if ( !json_is_integer( variant ) || json_integer_value( variant ) != gltf->variant || *material >= 0 )
                continue;
            rf_gltf_require( &mapping, "material", NULL );
            *material = rf_gltf_get_index( gltf, &mapping, "material", RF_GLTF_MATERIALS );
        }
    }
    if ( *material < 0 )
        *material = rf_gltf_get_index( gltf, primitive, "material", RF_GLTF_MATERIALS );
    return rf_json_result( primitive );
}

RfResult rf_gltf_choose_variant( RfGltf* gltf )
{
    RfField root = rf_gltf_root( gltf );
    RfField json = rf_gltf_field( gltf, VARIANTS, rf_gltf_extension( &root, VARIANTS ).json ),
            list = rf_get_array( &json, "variants" );
    RfResult result = rf_json_result( &root ) == RF_OK ? list_variants( gltf, &list ) : rf_json_result( &root );
    return result == RF_OK && gltf->options->variant != NULL ? find_chosen( gltf, list.json, &gltf->variant ) : result;
}
