// Cameras: one for each node of the default scene that has one; and `extras.reframe` of the scene: environment, view, settings of
// a render, what moves, warnings of the exporter.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "base/file.h"
#include "base/words.h"
#include "reframe/camera.h"
#include "reframe/render.h"
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/projection.h"
#include "scene/shared_json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What a file says about its shot: how it wants to be rendered (`extras.reframe` of the scene),
//
//     {"render": {"size": [1920, 1080], "fps": [30000, 1001], "alpha": true, "max_depth": 14}, "moving": ["door"],
//      "view": {"transform": "AgX", "exposure": 0.5}}
//
// and the path of a camera frame by frame (`extras.reframe` of its node), which goes before the glTF
// animation of the node: {"path": …}, as in a camera-path file.

#define MAX_NAMED 5 // in the warning
#define PI 3.14159265358979323846

static RfResult read_two( const RfField* field, double high, int* first, int* second )
{
    rf_field_array( field, "whole number", 2, 2 );
    RfField items[2] = { rf_field_item( field, 0 ), rf_field_item( field, 1 ) };
    rf_field_whole( items, 1.0, high, first );
    return rf_field_whole( items + 1, 1.0, high, second );
}

// A number, or numerator and denominator.
static RfResult read_fps( const RfField* field, RfFps* fps )
{
    if ( field->json == NULL )
        return RF_OK;
    fps->denominator = 1;
    if ( json_is_real( field->json ) && rf_broadcast_fps( json_real_value( field->json ), fps ) )
        return RF_OK;
    return json_is_array( field->json ) ? read_two( field, 1e9, &fps->numerator, &fps->denominator )
                                        : rf_field_whole( field, 1.0, 1e6, &fps->numerator );
}

const json_t* rf_gltf_document_extras( const json_t* root )
{
    json_int_t index = json_integer_value( json_object_get( root, "scene" ) );
    const json_t* scene = json_array_get( json_object_get( root, "scenes" ), index > 0 ? (size_t)index : 0 );
    return json_object_get( json_object_get( scene, "extras" ), "reframe" );
}

RfFps rf_gltf_document_fps( const json_t* root )
{
    const json_t* render = json_object_get( rf_gltf_document_extras( root ), "render" );
    RfError none;
    RfField field = rf_make_field( "", "fps", json_object_get( render, "fps" ), rf_begin_reading( &none ) );
    RfFps fps = { 0 };
    return read_fps( &field, &fps ) == RF_OK && fps.numerator > 0 ? fps : ( RfFps ){ 24, 1 };
}

// Appends the texts of a list to those that there are.
static RfResult read_texts( const RfField* ours, const char* key, const char* item, size_t most, char*** texts, int* count )
{
    RfField list = rf_field_member( ours, key );
    if ( list.json == NULL )
        return rf_json_result( ours );
    RfResult result = rf_field_array( &list, item, 0, most );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( list.json ); ++i )
    {
        const char* text = "";
        RfField one = rf_field_item( &list, i );
        result = rf_field_text( &one, &text );
        if ( result != RF_OK || !rf_gltf_grow( texts, *count, sizeof **texts ) )
            return result != RF_OK ? result : rf_field_no_memory( &list );
        ( *texts )[*count] = strdup( text );
        if ( ( *texts )[*count] == NULL )
            return rf_field_no_memory( &list );
        *count += 1;
    }
    return result;
}

static RfResult read_shot( RfGltf* gltf, const RfField* ours )
{
    static const char* const s_keys[] = { "size", "fps", "alpha", "max_depth", NULL };
    RfScene* scene = gltf->scene;
    RfField render = rf_field_member( ours, "render" );
    if ( render.json != NULL )
        rf_field_keys( &render, s_keys );
    RfField size = rf_field_member( &render, "size" ), fps = rf_field_member( &render, "fps" ),
            view = rf_field_member( ours, "view" );
    if ( size.json != NULL )
        read_two( &size, RF_MAX_IMAGE_SIDE, &scene->film_width, &scene->film_height );
    read_fps( &fps, &scene->fps );
    rf_get_bool( &render, "alpha", &scene->film_alpha );
    rf_get_whole( &render, "max_depth", 1.0, RF_MAX_DEPTH, &scene->max_depth );
    rf_read_view( &view, &scene->view );
    return read_texts( ours, "moving", "name", 1000000, &scene->moving, &scene->moving_count );
}

static RfResult read_lens( RfGltf* gltf, const RfField* ours, RfCamera* camera )
{
    camera->optics = calloc( 1, sizeof *camera->optics );
    return camera->optics != NULL ? rf_read_optics( ours, camera->optics ) : rf_gltf_no_memory( gltf, "cameras" );
}

// What glTF has no cameras for: a perspective one may be made one.
static RfResult read_projection( const RfField* ours, bool has_path, RfCamera* camera )
{
    const char* names[RF_PROJECTION_COUNT + 1] = { NULL };
    int kinds[RF_PROJECTION_COUNT], count = 0, index = 0;
    RfField field = rf_field_member( ours, "projection" );
    if ( field.json == NULL )
        return rf_json_result( ours );
    if ( has_path )
        return rf_field_fail( &field, "not together with path: that has a projection of its own" );
    for ( int k = 0; k < RF_PROJECTION_COUNT; ++k )
    {
        if ( rf_projection_traits( (RfProjectionKind)k )->in_gltf )
            continue;
        kinds[count] = k;
        names[count++] = g_rf_projection_names[k];
    }
    rf_field_choice( &field, names, &index );
    camera->projection = kinds[index];
    return rf_json_result( ours );
}

// Reads the path in a camera node's extras.reframe, where there is one.
static RfResult read_camera_path( RfGltf* gltf, const RfField* node, RfCamera* camera )
{
    static const char* const s_keys[] = { "path", "lens", "projection", "object", "asset", "pass_index", "light_group", NULL };
    RfField field = rf_gltf_extras( node );
    if ( field.json == NULL )
        return rf_json_result( node );
    rf_field_keys( &field, s_keys );
    RfField path = rf_field_member( &field, "path" ), lens = rf_field_member( &field, "lens" );
    RF_TRY( read_projection( &field, path.json != NULL, camera ) );
    if ( path.json != NULL && lens.json != NULL )
        return rf_field_fail( &lens, "not together with path: that has a lens of its own" );
    if ( lens.json != NULL )
        return read_lens( gltf, &field, camera );
    if ( path.json == NULL )
        return RF_OK;
    RfCamera read;
    RF_TRY( rf_read_camera( &path, camera->name, &read ) );
    camera->track = read.track;
    camera->animated = read.animated;
    camera->start = read.start;
    camera->end = read.end;
    free( read.name );
    return RF_OK;
}

bool rf_gltf_has_varying( const RfGltf* gltf, int node, RfAnimatedPath first, RfAnimatedPath last )
{
    const RfScene* scene = gltf->scene;
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        int count;
        const RfChannel* channels = rf_node_channels( scene, node, &count );
        for ( int i = 0; i < count; ++i )
        {
            if ( channels[i].path >= first && channels[i].path <= last && rf_channel_varies( channels + i ) )
                return true;
        }
    }
    return false;
}

RfResult rf_gltf_note_moving( RfGltf* gltf, const char* name )
{
    RfScene* scene = gltf->scene;
    bool room = rf_gltf_grow( &scene->moving, scene->moving_count, sizeof *scene->moving );
    if ( room )
        scene->moving[scene->moving_count] = strdup( name );
    if ( !room || scene->moving[scene->moving_count] == NULL )
        return rf_gltf_no_memory( gltf, "animations" );
    scene->moving_count += 1;
    return RF_OK;
}

static int compare_names( const void* a, const void* b ) { return strcmp( *(char* const*)a, *(char* const*)b ); }

// The file's own list and its animations may both have a name.
static void sort_names( RfScene* scene )
{
    int kept = 0;
    if ( scene->moving_count > 1 )
        qsort( scene->moving, (size_t)scene->moving_count, sizeof *scene->moving, compare_names );
    for ( int i = 0; i < scene->moving_count; ++i )
    {
        if ( kept > 0 && strcmp( scene->moving[i], scene->moving[kept - 1] ) == 0 )
            free( scene->moving[i] );
        else
            scene->moving[kept++] = scene->moving[i];
    }
    scene->moving_count = kept;
}

// Of what moves and of what else changes.
static void warn_of_frozen( const RfGltf* gltf )
{
    const RfScene* scene = gltf->scene;
    char names[MAX_NAMED * 64 + 32] = "";
    int moving = scene->moving_count, count = moving + scene->unrendered_count;
    int listed = count < MAX_NAMED ? count : MAX_NAMED;
    if ( count == 0 )
        return;
    for ( int i = 0; i < listed && i < moving; ++i )
        rf_append( names, sizeof names, "%s'%.50s'", i > 0 ? ", " : "", scene->moving[i] );
    for ( int i = moving; i < listed; ++i )
        rf_append( names, sizeof names, "%s%.50s", i > 0 ? ", " : "", scene->unrendered[i - moving].what );
    if ( count > listed )
        rf_append( names, sizeof names, " and %d more", count - listed );
    rf_warn( gltf->log, "%s: %s move%s or change%s: frozen as in the first frame", gltf->path, names, count == 1 ? "s" : "",
             count == 1 ? "s" : "" );
}

static bool any_material_changes( const RfGltf* gltf, int mesh )
{
    RfField primitives = rf_gltf_primitives( gltf, mesh );
    for ( size_t i = 0; i < json_array_size( primitives.json ); ++i )
    {
        RfField primitive = rf_field_item( &primitives, i );
        int material;
        bool has = rf_gltf_material_of( gltf, &primitive, &material ) == RF_OK && material >= 0;
        if ( has && ( gltf->scene->materials[material].dims || gltf->scene->materials[material].changes ) )
            return true;
    }
    return false;
}

// Whether a node that stands still has something that changes: all of it has been read.
static bool changes_at( const RfGltf* gltf, int node )
{
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_NODES, node );
    int mesh = gltf->nodes[node].mesh;
    const json_t* light =
        json_object_get( json_object_get( json_object_get( json, "extensions" ), "KHR_lights_punctual" ), "light" );
    return ( mesh >= 0 && any_material_changes( gltf, mesh ) ) ||
           ( light != NULL && rf_gltf_light_changes( gltf, (int)json_integer_value( light ) ) );
}

// The place of a name in the sorted list; −1: it is not there.
static ptrdiff_t find_name( const RfScene* scene, const char* name )
{
    char** found = bsearch( &name, scene->moving, (size_t)scene->moving_count, sizeof *scene->moving, compare_names );
    return found != NULL ? found - scene->moving : -1;
}

// Marks the names of what moves, with all that it hangs on, or changes in the file.
static void mark_moved( const RfGltf* gltf, bool* moved )
{
    const RfScene* scene = gltf->scene;
    int nodes = scene->movement != NULL ? scene->movement->node_count : 0,
        checked = gltf->change_count > 0 ? gltf->order_count : 0;
    for ( int i = 0; i < nodes; ++i )
    {
        ptrdiff_t at = find_name( scene, scene->nodes[scene->movement->nodes[i].node].name );
        if ( at >= 0 )
            moved[at] = true;
    }
    for ( int i = 0; i < checked; ++i )
    {
        ptrdiff_t at = find_name( scene, scene->nodes[gltf->order[i]].name );
        if ( at >= 0 && !moved[at] )
            moved[at] = changes_at( gltf, gltf->order[i] );
    }
}

// Takes what does not move or change in the file out of the names.
static RfResult list_unmoved( RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    RfResult result = RF_OK;
    int kept = 0, count = scene->moving_count;
    bool* moved;
    RF_TRY( rf_gltf_allocate( gltf, "animations", &moved, (size_t)count, sizeof *moved ) );
    if ( count > 0 )
        mark_moved( gltf, moved );
    for ( int i = 0; i < count; ++i )
    {
        char* name = scene->moving[i];
        if ( moved[i] )
        {
            scene->moving[kept++] = name;
            continue;
        }
        RfWhere what = rf_where( "object '%.80s'", name );
        if ( result == RF_OK )
            result =
                rf_gltf_note_unrendered( gltf, what.text, "it moves or changes where the file was made, but not in the file" );
        free( name );
    }
    scene->moving_count = kept;
    free( moved );
    return result;
}

RfResult rf_gltf_list_moving( RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    sort_names( scene );
    if ( !gltf->freeze )
        return list_unmoved( gltf );
    warn_of_frozen( gltf );
    scene->frozen = scene->moving_count + scene->unrendered_count > 0;
    if ( scene->frozen )
        scene->content_hash = rf_hash_bytes( scene->content_hash, &gltf->frozen_at, sizeof gltf->frozen_at );
    return RF_OK;
}

// What the program that wrote a file could not carry, in `extras.reframe` of the scene: what freezes a movement or changes the light
// of the whole picture, and smaller things.
//
//     {"export_losses": ["world 'sky': animated or driven: taken as in the first frame"],
//      "export_warnings": ["'Sphere': material 'skin': subsurface scattering: taken as diffuse"]}

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

static RfResult read_warnings( RfGltf* gltf, const RfField* ours )
{
    RfScene* scene = gltf->scene;
    read_texts( ours, "export_losses", "texts", MAX_WARNINGS, &scene->export_losses, &scene->export_loss_count );
    RfResult result =
        read_texts( ours, "export_warnings", "texts", MAX_WARNINGS, &scene->export_warnings, &scene->export_warning_count );
    for ( int i = 0; i < scene->export_loss_count; ++i )
        make_printable( scene->export_losses[i] );
    for ( int i = 0; i < scene->export_warning_count; ++i )
        make_printable( scene->export_warnings[i] );
    return result;
}

// The environment.
//
//     {"environment": {"radiance": [r, g, b], "map": "sky.exr", "rotation": 90, "visible": false}}
//
// A map inside the file is a bufferView with the bytes of an EXR or HDR instead: {"bufferView": 7}.

static RfResult load_map( RfGltf* gltf, const RfField* object, RfEnvironmentText* text )
{
    char* path;
    RF_TRY( rf_gltf_resolve_uri( gltf, object->path, text->map, &path ) );
    RfResult result = rf_load_environment( object, path, text );
    free( path );
    if ( result == RF_OK )
        gltf->scene->content_hash = rf_hash_environment( gltf->scene->content_hash, &text->environment );
    return result;
}

// The bytes of the file, and with them those of the view, are in the scene's hash already.
static RfResult decode_map( const RfGltf* gltf, const RfField* object, RfEnvironmentText* text )
{
    size_t length = 0;
    const uint8_t* bytes = NULL;
    RfField field = rf_field_member( object, "bufferView" );
    if ( text->view >= gltf->counts[RF_GLTF_BUFFER_VIEWS] )
        return rf_field_fail( &field, "names bufferView %d, but there are %d", text->view, gltf->counts[RF_GLTF_BUFFER_VIEWS] );
    RfResult result = rf_gltf_whole_view( gltf, object->path, text->view, INT64_MAX, &bytes, &length );
    return result == RF_OK ? rf_decode_environment( object, bytes, length, text ) : result;
}

static RfResult load_environment( RfGltf* gltf, const RfField* object )
{
    RfScene* scene = gltf->scene;
    RfEnvironmentText text;
    RfResult result = rf_read_environment( object, true, rf_scene_fps( scene ), &text );
    if ( result == RF_OK && text.view >= 0 )
        result = decode_map( gltf, object, &text );
    else if ( result == RF_OK && text.map != NULL )
        result = load_map( gltf, object, &text );
    if ( result == RF_OK )
        result = rf_give_environment( object, &text, scene, gltf->log );
    if ( result == RF_OK && text.in_frames )
        scene->key_fps = rf_scene_fps( scene );
    rf_destroy_environment_text( &text );
    return result;
}

RfResult rf_gltf_load_extras( RfGltf* gltf )
{
    static const char* const s_keys[] = { "environment", "render", "moving", "export_losses", "export_warnings", "view", NULL };
    if ( gltf->counts[RF_GLTF_SCENES] == 0 )
        return RF_OK;
    RfField root = rf_gltf_root( gltf );
    int index = rf_gltf_get_index( gltf, &root, "scene", RF_GLTF_SCENES );
    RfField scene = rf_gltf_item_field( gltf, RF_GLTF_SCENES, index >= 0 ? index : 0 ), field = rf_gltf_extras( &scene );
    if ( field.json == NULL )
        return rf_json_result( &root );
    rf_field_keys( &field, s_keys );
    RF_TRY( read_shot( gltf, &field ) );
    RF_TRY( read_warnings( gltf, &field ) );
    RfField object = rf_field_member( &field, "environment" );
    if ( object.json == NULL || gltf->options->no_environment )
        return RF_OK;
    return load_environment( gltf, &object );
}

// What a camera of this type says of itself, with a number that it must have.
static RfField open_type( const RfField* json, const char* type, const char* key )
{
    rf_gltf_require( json, type, NULL );
    RfField object = rf_get_object( json, type );
    snprintf( object.path, sizeof object.path, "%s", json->path ); // of which messages name the camera
    rf_gltf_require( &object, key, NULL );
    return object;
}

// The shape of the picture may be left open.
static RfResult read_perspective( const RfField* json, RfCamera* camera )
{
    RfField object = open_type( json, "perspective", "yfov" );
    RfResult result = rf_get_number( &object, "yfov", rf_any_number(), &camera->yfov );
    if ( result == RF_OK && !( camera->yfov > 0.0 && camera->yfov < PI ) )
        return rf_field_fail( json, "yfov is %g, it must be more than 0 and less than pi radians", camera->yfov );
    return rf_get_number( &object, "aspectRatio", rf_above( 0.0, HUGE_VAL ), &camera->aspect );
}

static RfResult read_orthographic( const RfField* json, RfCamera* camera )
{
    double xmag = 0.0;
    RfField object = open_type( json, "orthographic", "ymag" );
    RfResult result = rf_get_number( &object, "ymag", rf_any_number(), &camera->ymag );
    camera->ymag = fabs( camera->ymag ); // below 0 says the same
    if ( result == RF_OK && !( camera->ymag > 0.0 && camera->ymag < rf_changed_traits( RF_CHANGED_YMAG )->high ) )
        return rf_field_fail( json, "ymag is %g, it must be more than 0 and less than 1e12", camera->ymag );
    rf_get_number( &object, "xmag", rf_any_number(), &xmag );
    camera->aspect = fabs( xmag ) / camera->ymag;
    return rf_json_result( json );
}

static RfResult read_camera( const RfGltf* gltf, int index, RfCamera* camera )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_CAMERAS, index );
    const char* type = "";
    rf_gltf_require( &json, "type", NULL );
    RfResult result = rf_get_text( &json, "type", &type );
    bool wide = strcmp( type, "perspective" ) == 0;
    if ( result == RF_OK && !wide && strcmp( type, "orthographic" ) != 0 )
        return rf_field_fail( &json, "type '%.20s' must be perspective or orthographic", type );
    camera->projection = wide ? RF_PERSPECTIVE : RF_ORTHOGRAPHIC;
    return result != RF_OK ? result : wide ? read_perspective( &json, camera ) : read_orthographic( &json, camera );
}

// The name of the node, else of the camera, else "camera".
static RfResult base_name( const RfGltf* gltf, int node, int camera, const char** name )
{
    const char *node_name = "", *camera_name = "";
    RfField of_node = rf_gltf_item_field( gltf, RF_GLTF_NODES, node ),
            of_camera = rf_gltf_item_field( gltf, RF_GLTF_CAMERAS, camera );
    rf_get_text( &of_node, "name", &node_name );
    rf_get_text( &of_camera, "name", &camera_name );
    *name = node_name[0] != 0 ? node_name : camera_name[0] != 0 ? camera_name : "camera";
    return rf_json_result( &of_node );
}

// Makes names unique: the first keeps its name, later ones get "#2", "#3" and so on. `names`
// maps each name to the next number to try, so that many equal names take constant time each.
static char* make_unique( json_t* names, const char* base )
{
    size_t size = strlen( base ) + 24;
    char* name = malloc( size );
    if ( name == NULL )
        return NULL;
    json_int_t next = json_integer_value( json_object_get( names, base ) );
    snprintf( name, size, "%s", base );
    if ( next > 0 )
    {
        do
            snprintf( name, size, "%s#%lld", base, (long long)next++ );
        while ( json_object_get( names, name ) != NULL );
        json_object_set_new( names, base, json_integer( next ) );
    }
    if ( json_object_set_new( names, name, json_integer( 2 ) ) == 0 )
        return name;
    free( name );
    return NULL;
}

// Where its field of view changes. Cameras are never frozen.
static RfResult load_zoom( const RfGltf* gltf, int index, RfCamera* camera )
{
    bool wide = camera->projection == RF_PERSPECTIVE;
    double* still = wide ? &camera->yfov : &camera->ymag;
    int change = rf_gltf_find_change( gltf, wide ? RF_CHANGED_YFOV : RF_CHANGED_YMAG, index, 0, still );
    double start, end;
    if ( change < 0 )
        return RF_OK;
    camera->zoom = malloc( sizeof *camera->zoom );
    if ( camera->zoom == NULL )
        return rf_gltf_no_memory( gltf, "cameras" );
    *camera->zoom = gltf->changes[change];
    rf_channel_span( &gltf->changes[change].channel, &start, &end );
    camera->start = camera->animated ? fmin( camera->start, start ) : start;
    camera->end = camera->animated ? fmax( camera->end, end ) : end;
    camera->animated = true;
    return rf_copy_channel( &gltf->changes[change].channel, &camera->zoom->channel, gltf->error );
}

static RfResult load_camera( RfGltf* gltf, json_t* names, int node, int index )
{
    const char* base;
    RfScene* scene = gltf->scene;
    if ( !rf_gltf_grow( &scene->cameras, scene->camera_count, sizeof *scene->cameras ) )
        return rf_gltf_no_memory( gltf, "cameras" );
    RfCamera* camera = scene->cameras + scene->camera_count;
    memset( camera, 0, sizeof *camera );
    RF_TRY( read_camera( gltf, index, camera ) );
    RF_TRY( base_name( gltf, node, index, &base ) );
    camera->name = make_unique( names, base );
    if ( camera->name == NULL )
        return rf_gltf_no_memory( gltf, "cameras" );
    gltf->scene->camera_count += 1;
    camera->node = node;
    camera->animated = rf_gltf_moves( gltf, node );
    if ( camera->animated )
    {
        camera->start = gltf->nodes[node].span.start;
        camera->end = gltf->nodes[node].span.end;
    }
    RF_TRY( load_zoom( gltf, index, camera ) );
    if ( camera->animated )
        RF_TRY( rf_find_step_cuts( gltf->scene, camera, gltf->error ) );
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_NODES, node );
    return read_camera_path( gltf, &json, camera );
}

// For all nodes with a camera.
RfResult rf_gltf_load_cameras( RfGltf* gltf )
{
    json_t* names = json_object();
    RfResult result = RF_OK;
    if ( names == NULL )
        result = rf_gltf_no_memory( gltf, "cameras" );
    for ( int i = 0; result == RF_OK && i < gltf->order_count; ++i )
    {
        int node = gltf->order[i];
        if ( gltf->nodes[node].camera >= 0 )
            result = load_camera( gltf, names, node, gltf->nodes[node].camera );
    }
    json_decref( names );
    return result;
}
