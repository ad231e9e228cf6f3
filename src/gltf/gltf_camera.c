// Cameras: one for each node of the default scene that has a camera.

#include "gltf/gltf_material.h"

#include "reframe/camera.h"
#include "scene/animation.h"
#include "scene/camera.h"
#include "scene/projection.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

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
    RfResult result = read_camera( gltf, index, camera );
    if ( result == RF_OK )
        result = base_name( gltf, node, index, &base );
    if ( result != RF_OK )
        return result;
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
    result = load_zoom( gltf, index, camera );
    if ( result == RF_OK && camera->animated )
        result = rf_find_step_cuts( gltf->scene, camera, gltf->error );
    if ( result != RF_OK )
        return result;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_NODES, node );
    return rf_gltf_read_camera_path( gltf, &json, camera );
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
