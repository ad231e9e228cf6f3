// Opens .gltf and .glb, reads all parts of the document, and moves scenes that lie far from the origin.
#include "gltf/gltf.h"

#include "base/file.h"
#include "base/try.h"
#include "base/words.h"
#include "gltf/gltf_document.h"
#include "reframe/error.h"
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/placement.h"
#include "scene/pose.h"
#include "scene/shared_json.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What a scene file says of materials and lights by their names, or by "materials[3]" where they have none. It is read where the
// values of the document are (gltf_material.c, gltf_light.c), after them.

#define NAMES_LISTED 12
#define MATERIAL_KEYS 14 // besides those of values

// The name of an item of a list that is called `plural`.
static const char* item_name( const json_t* list, const char* plural, size_t index, char fallback[RF_ITEM_NAME] )
{
    const char* name = json_string_value( json_object_get( json_array_get( list, index ), "name" ) );
    snprintf( fallback, RF_ITEM_NAME, "%.9s[%zu]", plural, index );
    return name != NULL && name[0] != 0 ? name : fallback;
}

RfResult rf_fail_unknown_item( const RfField* field, const char* kind, const char* name, const json_t* list )
{
    char text[400] = "", plural[16], fallback[RF_ITEM_NAME], nearest[128] = "";
    size_t count = json_array_size( list );
    snprintf( plural, sizeof plural, "%.9ss", kind );
    for ( size_t i = 0; i < count; ++i )
    {
        const char* one = item_name( list, plural, i, fallback );
        if ( nearest[0] == 0 && rf_nearest_word( name, &one, 1 ) != NULL )
            snprintf( nearest, sizeof nearest, "did you mean '%.60s'? ", one );
        if ( i < NAMES_LISTED )
            rf_append( text, sizeof text, "%s'%.24s'", i > 0 ? ", " : "", one );
    }
    if ( count > NAMES_LISTED )
        rf_append( text, sizeof text, " and %zu more", count - NAMES_LISTED );
    return rf_field_fail( field, "the scene has no such %s: %sthere are %s", kind, nearest, count > 0 ? text : "none" );
}

// Gives the edit to all items of its name.
static RfResult set_edit( const RfField* edit, const char* name, const char* kind, const json_t* list, RfField* edits )
{
    char fallback[RF_ITEM_NAME], plural[16];
    bool found = false;
    snprintf( plural, sizeof plural, "%.9ss", kind );
    for ( size_t i = 0; i < json_array_size( list ); ++i )
    {
        if ( strcmp( item_name( list, plural, i, fallback ), name ) != 0 )
            continue;
        found = true;
        edits[i] = *edit;
    }
    return found ? rf_json_result( edit ) : rf_fail_unknown_item( edit, kind, name, list );
}

// Finds the items of a list that `all` has a member for, each of which has some of `keys`.
static RfResult open_edits( RfGltf* gltf, const RfField* all, const char* kind, const json_t* list, const char* const* keys,
                            RfField** edits )
{
    char want[40];
    const char* name;
    json_t* value;
    RfField named = rf_make_field( all->file, all->path, all->json, gltf->error );
    RfResult result = gltf->error->code;
    if ( all->json == NULL )
        return result;
    snprintf( want, sizeof want, "an object of %.9ss by name", kind );
    if ( !json_is_object( all->json ) )
        return rf_field_must_be( &named, want );
    RF_TRY( rf_gltf_allocate( gltf, kind, edits, json_array_size( list ), sizeof **edits ) );
    json_object_foreach( (json_t*)all->json, name, value )
    {
        RfField edit = rf_field_member( &named, name );
        rf_field_keys( &edit, keys );
        if ( result == RF_OK )
            result = set_edit( &edit, name, kind, list, *edits );
    }
    return result;
}

static RfResult open_all_edits( RfGltf* gltf )
{
    static const char* const s_light_keys[] = {
        "ies", "radius", "soft", "angle", "shape", "size", "spread", "light_group", NULL
    };
    const char* keys[MATERIAL_KEYS + RF_CHANGED_COUNT + 1] = {
        "bsdf",
        "diffuse",
        "specular",
        "exponent",
        "doubleSided",
        "alphaMode",
        "baseColorTexture",
        "metallicRoughnessTexture",
        "normalTexture",
        "emissiveTexture",
        "textures",
        "light_group",
        "interpolation",
        "keys",
    };
    int count = MATERIAL_KEYS;
    const json_t* punctual = json_object_get( json_object_get( gltf->root, "extensions" ), "KHR_lights_punctual" );
    for ( RfChangedValue v = rf_next_value( RF_OF_MATERIAL, -1 ); v < RF_CHANGED_COUNT; v = rf_next_value( RF_OF_MATERIAL, v ) )
    {
        if ( ( rf_changed_traits( v )->flags & RF_VALUE_IN_FILE ) != 0 )
            keys[count++] = rf_changed_traits( v )->name;
    }
    RF_TRY(
        open_edits( gltf, &gltf->options->materials, "material", gltf->lists[RF_GLTF_MATERIALS], keys, &gltf->material_edits ) );
    return open_edits( gltf, &gltf->options->lights, "light", json_object_get( punctual, "lights" ), s_light_keys,
                       &gltf->light_edits );
}

// Views into the bytes of the file.
typedef struct RfGlb
{
    const uint8_t* json;
    size_t json_size;
    const uint8_t* bin; // NULL: none
    size_t bin_size;
} RfGlb;

// The GLB container of glTF: a header, a JSON chunk, a binary chunk.

#define MAGIC "glTF"
#define CHUNK_JSON 0x4e4f534au
#define CHUNK_BIN 0x004e4942u
#define HEADER_SIZE 12
#define CHUNK_HEADER_SIZE 8

static uint32_t read_u32( const uint8_t* at )
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

// True if the bytes begin with the GLB header; the file name does not matter.
static bool is_glb( const uint8_t* bytes, size_t size ) { return size >= 4 && memcmp( bytes, MAGIC, 4 ) == 0; }

static RfResult check_header( const char* path, const uint8_t* bytes, size_t size, RfError* error )
{
    if ( size < HEADER_SIZE )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB header: the file ends inside it: copy or export it again", path );
    uint32_t version = read_u32( bytes + 4 );
    if ( version != 2 )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: GLB header: version %u, not 2: export it as glTF 2.0", path, version );
    uint32_t length = read_u32( bytes + 8 );
    if ( length != size )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB header: says %u bytes, the file has %zu: copy or export it again", path,
                        length, size );
    return RF_OK;
}

// Finds the chunks. `path` is only for messages.
static RfResult split_glb( const char* path, const uint8_t* bytes, size_t size, RfGlb* glb, RfError* error )
{
    *glb = ( RfGlb ){ 0 };
    RF_TRY( check_header( path, bytes, size, error ) );

    size_t at = HEADER_SIZE;
    for ( int chunk = 0; at < size; ++chunk )
    {
        if ( size - at < CHUNK_HEADER_SIZE )
            return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB chunk %d: the file ends inside its header: export it again", path,
                            chunk );
        uint32_t length = read_u32( bytes + at ), type = read_u32( bytes + at + 4 );
        at += CHUNK_HEADER_SIZE;
        if ( length > size - at )
            return rf_fail( error, RF_ERROR_FORMAT,
                            "%s: GLB chunk %d: says %u bytes, %zu are left in the file: copy or export it again", path, chunk,
                            length, size - at );
        if ( ( chunk == 0 ) != ( type == CHUNK_JSON ) )
            return rf_fail( error, RF_ERROR_FORMAT,
                            "%s: GLB chunk %d: the first chunk, and no other, must be JSON: export it again", path, chunk );
        if ( chunk == 0 )
        {
            glb->json = bytes + at;
            glb->json_size = length;
        }
        else if ( chunk == 1 && type == CHUNK_BIN )
        {
            glb->bin = bytes + at;
            glb->bin_size = length;
        }
        // other chunks belong to extensions and are skipped, as the specification requires
        at += length;
    }
    if ( glb->json == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB: has no JSON chunk: export it again", path );
    return RF_OK;
}

// Where a scene that lies far from the origin is moved to, so that floats can resolve its details. At
// 100 km they are 8 mm apart.

#define SAMPLES 1024 // corners of triangles, evenly spread over the list

// As far out as this, in distances of the median corner from the middle.
#define FAR_OUT 16.0

static int compare( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

static double median( double* values, size_t count )
{
    qsort( values, count, sizeof *values, compare );
    return values[count / 2];
}

// Triangles of what stands still: they have the first numbers.
static uint32_t still_triangles( const RfScene* scene )
{
    bool moves = scene->still_placement_count < scene->placement_count;
    return moves ? scene->placements[scene->still_placement_count].first : rf_triangle_count( scene );
}

static size_t sample_corners( const RfScene* scene, double corners[3][SAMPLES] )
{
    size_t all = 3 * (size_t)still_triangles( scene ), step = all / SAMPLES + 1, count = 0;
    for ( size_t i = 0; i < all; i += step, ++count )
    {
        RfVec3 p = rf_triangle_corner( scene, (uint32_t)( i / 3 ), (int)( i % 3 ) );
        corners[0][count] = (double)p.x;
        corners[1][count] = (double)p.y;
        corners[2][count] = (double)p.z;
    }
    return count;
}

// Where everything moves: the corners of its bounds, as it starts.
static size_t sample_movers( const RfScene* scene, double corners[3][SAMPLES] )
{
    size_t count = 0;
    RfPosedScene pose = { 0 };
    if ( scene->movement == NULL || rf_pose_scene( scene, scene->movement->start, &pose, NULL ) != RF_OK )
        pose.scene.placement_count = 0;
    for ( int i = 0; i < pose.scene.placement_count && count + 2 <= SAMPLES; ++i )
    {
        const RfPlacement* placement = pose.scene.placements + i;
        const RfMesh* mesh = pose.scene.meshes + placement->mesh;
        const RfVec3 bounds[2] = { mesh->bounds_min, mesh->bounds_max };
        for ( int k = 0; k < 2 && placement->shown; ++k, ++count )
        {
            double local[3] = { (double)bounds[k].x, (double)bounds[k].y, (double)bounds[k].z }, at[3];
            rf_mat4_apply( &placement->matrix, local, 1.0, at );
            for ( int c = 0; c < 3; ++c )
                corners[c][count] = at[c];
        }
    }
    rf_destroy_pose( &pose );
    return count;
}

// Whether the camera that is rendered by default starts nearer to the middle than to where the origin is.
static bool eye_agrees( const RfScene* scene, const double middle[3] )
{
    int index;
    if ( rf_find_camera( scene, NULL, &index, NULL ) != RF_OK || scene->cameras[index].node < 0 )
        return true;
    RfMat4 world;
    rf_node_world_matrix( scene, scene->cameras[index].node, scene->cameras[index].start, &world );
    double before = 0.0, after = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        before = fmax( before, fabs( world.m[12 + c] ) );
        after = fmax( after, fabs( world.m[12 + c] - middle[c] ) );
    }
    return after < before;
}

// True if the scene lies so far out that it is to be loaded around another origin, which is set.
static bool find_origin( const RfScene* scene, double origin[3] )
{
    double corners[3][SAMPLES], sorted[SAMPLES], middle[3], distance[SAMPLES], out = 0.0;
    size_t count = still_triangles( scene ) > 0 ? sample_corners( scene, corners ) : sample_movers( scene, corners );
    if ( count == 0 )
        return false;
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( sorted, corners[c], count * sizeof *sorted );
        middle[c] = median( sorted, count );
        out = fmax( out, fabs( middle[c] ) );
    }
    for ( size_t i = 0; i < count; ++i )
        distance[i] = fmax( fabs( corners[0][i] - middle[0] ),
                            fmax( fabs( corners[1][i] - middle[1] ), fabs( corners[2][i] - middle[2] ) ) );
    double size = median( distance, count );
    if ( !( size > 0.0 && out > FAR_OUT * size && eye_agrees( scene, middle ) ) )
        return false;
    // to a multiple of a power of two, so that round numbers stay round
    double unit = exp2( ceil( log2( 8.0 * size ) ) );
    for ( int c = 0; c < 3; ++c )
        origin[c] = unit * round( middle[c] / unit );
    return true;
}

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
    RF_TRY( rf_read_file( gltf->path, MAX_FILE_BYTES, &gltf->file, &gltf->file_size, gltf->error ) );
    gltf->scene->content_hash = rf_hash_bytes( RF_HASH_START, gltf->file, gltf->file_size );
    RF_TRY( rf_refuse_foreign_file( gltf->path, gltf->file, gltf->file_size, false, gltf->error ) );
    if ( is_glb( gltf->file, gltf->file_size ) == false )
        return parse( gltf, (const char*)gltf->file, gltf->file_size );

    RfGlb glb;
    RF_TRY( split_glb( gltf->path, gltf->file, gltf->file_size, &glb, gltf->error ) );
    gltf->bin = glb.bin;
    gltf->bin_size = glb.bin_size;
    return parse( gltf, (const char*)glb.json, glb.json_size );
}

// True for "2." followed by digits.
static bool is_version_2( const char* version )
{
    return strncmp( version, "2.", 2 ) == 0 && version[2] != 0 && strspn( version + 2, "0123456789" ) == strlen( version + 2 );
}

static RfResult check_asset( RfGltf* gltf )
{
    const char *version = "", *least = "2.0";
    RfField root = rf_gltf_root( gltf );
    rf_gltf_require( &root, "asset", NULL );
    rf_get_object( &root, "asset" ); // or fails
    RfField asset = rf_gltf_field( gltf, "asset", json_object_get( gltf->root, "asset" ) );
    rf_gltf_require( &asset, "version", NULL );
    rf_get_text( &asset, "version", &version );
    RF_TRY( rf_get_text( &asset, "minVersion", &least ) );
    if ( is_version_2( version ) == false || strcmp( least, "2.0" ) != 0 )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "asset",
                             "is glTF %.20s and needs a reader of %.20s or later: export it as glTF 2.0", version, least );
    return RF_OK;
}

double rf_gltf_first_time( const RfScene* scene )
{
    int index;
    const RfCamera* camera = rf_find_camera( scene, NULL, &index, NULL ) == RF_OK ? scene->cameras + index : NULL;
    RfFps fps = rf_scene_fps( scene );
    bool counts = camera != NULL && camera->track != NULL && camera->track->in_frames;
    return counts ? camera->start * (double)fps.denominator / (double)fps.numerator : 0.0;
}

static RfResult create_accessors( RfGltf* gltf )
{
    gltf->accessor_count = gltf->counts[RF_GLTF_ACCESSORS];
    gltf->accessors = calloc( (size_t)gltf->accessor_count + rf_gltf_count_packed( gltf ) + 1, sizeof *gltf->accessors );
    return gltf->accessors != NULL ? RF_OK : rf_gltf_no_memory( gltf, "accessors" );
}

// What is frozen is as the default camera sees it first.
static RfResult choose_time( RfGltf* gltf )
{
    gltf->frozen_at = gltf->options->frozen_at != NULL ? *gltf->options->frozen_at : rf_gltf_first_time( gltf->scene );
    return gltf->freeze ? rf_freeze_environment( gltf->scene, gltf->frozen_at, gltf->error ) : RF_OK;
}

static RfResult read_document( RfGltf* gltf )
{
    static RfResult ( *const s_steps[] )( RfGltf * gltf ) = {
        check_asset,         rf_gltf_check_required, rf_gltf_open_lists,         rf_gltf_choose_variant,  open_all_edits,
        create_accessors,    rf_gltf_load_buffers,   rf_gltf_load_nodes,         rf_gltf_load_animations, rf_gltf_load_cameras,
        rf_gltf_load_extras, // with the frames per second
        choose_time,         rf_gltf_load_materials, rf_gltf_split_light_groups, rf_gltf_load_lights,     rf_gltf_load_meshes,
        rf_gltf_load_images, rf_gltf_list_moving,    rf_gltf_notice_unread,
    };
    for ( size_t i = 0; i < sizeof s_steps / sizeof s_steps[0]; ++i )
        RF_TRY( s_steps[i]( gltf ) );
    return RF_OK;
}

static void close_document( RfGltf* gltf )
{
    rf_gltf_free_unpacked( gltf );
    rf_gltf_free_buffers( gltf );
    json_decref( gltf->root );
    free( gltf->file );
    free( gltf->accessors );
    free( gltf->nodes );
    free( gltf->order );
    free( gltf->remap );
    free( gltf->remap_stamp );
    free( gltf->uses );
    free( gltf->material_edits );
    free( gltf->light_edits );
    free( gltf->films );
    rf_gltf_free_split( gltf );
    rf_gltf_free_changes( gltf );
}

// `again`: where the first time, which has warned of all else, found it far out.
static RfResult load_around( const double origin[3], const char* path, const RfGltfOptions* options, bool again, RfScene* scene,
                             RfLog* log, RfError* error )
{
    memset( scene, 0, sizeof *scene );
    memcpy( scene->origin, origin, sizeof scene->origin );
    RfGltf gltf = { .path = path,
                    .scene = scene,
                    .log = again ? NULL : log,
                    .error = rf_begin_reading( error ),
                    .default_material = -1,
                    .variant = -1 };
    gltf.freeze = options->freeze;
    gltf.options = options;
    scene->path = strdup( path );
    RfResult result = scene->path != NULL ? open_document( &gltf ) : rf_gltf_no_memory( &gltf, "document" );
    if ( result == RF_OK && options->survey != NULL )
        result = options->survey( options->user, gltf.root, gltf.error );
    if ( result == RF_OK && options->animation != NULL )
        scene->content_hash = rf_hash_bytes( scene->content_hash, options->animation, strlen( options->animation ) );
    if ( result == RF_OK && options->variant != NULL )
    {
        scene->content_hash = rf_hash_bytes( scene->content_hash, "variant", 8 );
        scene->content_hash = rf_hash_bytes( scene->content_hash, options->variant, strlen( options->variant ) );
    }
    if ( result == RF_OK )
        result = read_document( &gltf );
    // far out, floats may leave triangles without area that have one around the middle
    double middle[3];
    if ( result == RF_OK && gltf.degenerate > 0 && ( again || options->origin != NULL || !find_origin( scene, middle ) ) )
        rf_gltf_warn_of_degenerate( &gltf, log, gltf.degenerate, &gltf.first_degenerate );
    close_document( &gltf );
    if ( result != RF_OK )
        rf_destroy_scene( scene );
    return result;
}

// A scene that lies far out is loaded a second time, around its middle: rounded to floats only then.
RfResult rf_load_gltf_with( const char* path, const RfGltfOptions* options, RfScene* scene, RfLog* log, RfError* error )
{
    double origin[3] = { 0 };
    if ( options->origin != NULL )
        memcpy( origin, options->origin, sizeof origin );
    RfResult result = load_around( origin, path, options, false, scene, log, error );
    if ( result != RF_OK || options->origin != NULL || !find_origin( scene, origin ) )
        return result;
    rf_destroy_scene( scene );
    return load_around( origin, path, options, true, scene, log, error );
}

RfResult rf_load_gltf( const char* path, RfScene* scene, RfLog* log, RfError* error )
{
    RfGltfOptions options = { 0 };
    return rf_load_gltf_with( path, &options, scene, log, error );
}
