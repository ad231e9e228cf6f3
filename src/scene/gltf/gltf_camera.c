// Cameras: one for each node of the default scene that has a camera.

#include "scene/gltf/gltf_changes.h"

#include "reframe/camera.h"
#include "scene/animation.h"
#include "scene/camera.h"
#include "scene/projection.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

// A number that a camera of this type must have.
static RfResult read_extent( const RfGltf* gltf, const json_t* json, const char* where, const char* type, const char* key,
                             double* value )
{
    const json_t* object = NULL;
    RfResult result = rf_gltf_require( gltf, json, where, type );
    if ( result == RF_OK )
        result = rf_gltf_get_object( gltf, json, where, type, &object );
    if ( result == RF_OK )
        result = rf_gltf_require( gltf, object, where, key );
    return result == RF_OK ? rf_gltf_get_number( gltf, object, where, key, value ) : result;
}

static RfResult read_yfov( const RfGltf* gltf, const json_t* json, const char* where, double* yfov )
{
    RfResult result = read_extent( gltf, json, where, "perspective", "yfov", yfov );
    if ( result == RF_OK && ( *yfov > 0.0 && *yfov < PI ) == false )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "yfov is %g, it must be more than 0 and less than pi radians", *yfov );
    return result;
}

// The shape of the picture, which perspective cameras may leave open.
static RfResult read_aspect( const RfGltf* gltf, const json_t* json, const char* where, double* aspect )
{
    const json_t* object = json_object_get( json, "perspective" );
    RfResult result = rf_gltf_get_number( gltf, object, where, "aspectRatio", aspect );
    if ( result == RF_OK && json_object_get( object, "aspectRatio" ) != NULL && !( *aspect > 0.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "aspectRatio is %g, it must be more than 0", *aspect );
    return result;
}

static RfResult read_xmag( const RfGltf* gltf, const json_t* json, const char* where, double ymag, double* aspect )
{
    double xmag = 0.0;
    RfResult result = rf_gltf_get_number( gltf, json_object_get( json, "orthographic" ), where, "xmag", &xmag );
    *aspect = fabs( xmag ) / ymag;
    return result;
}

static RfResult read_ymag( const RfGltf* gltf, const json_t* json, const char* where, double* ymag )
{
    RfResult result = read_extent( gltf, json, where, "orthographic", "ymag", ymag );
    *ymag = fabs( *ymag ); // below 0 says the same
    if ( result == RF_OK && !( *ymag > 0.0 && *ymag < 1e12 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "ymag is %g, it must be more than 0 and less than 1e12", *ymag );
    return result;
}

// The projection of glTF that has this name, or -1.
static int kind_of( const char* type )
{
    for ( int k = 0; k < RF_PROJECTION_COUNT; ++k )
    {
        const RfProjectionTraits* traits = rf_projection_traits( (RfProjectionKind)k );
        if ( traits->in_gltf && strcmp( type, traits->name ) == 0 )
            return k;
    }
    return -1;
}

static RfResult read_camera( const RfGltf* gltf, int index, RfCamera* camera )
{
    RfWhere where = rf_where( "cameras[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_CAMERAS, index );
    const char* type = "";
    RfResult result = rf_gltf_require( gltf, json, where.text, "type" );
    if ( result == RF_OK )
        result = rf_gltf_get_string( gltf, json, where.text, "type", &type );
    if ( result != RF_OK )
        return result;
    int kind = kind_of( type );
    if ( kind < 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "type '%.20s' must be perspective or orthographic", type );
    camera->projection = kind;
    switch ( (RfProjectionKind)kind )
    {
        case RF_PERSPECTIVE:
            result = read_yfov( gltf, json, where.text, &camera->yfov );
            return result == RF_OK ? read_aspect( gltf, json, where.text, &camera->aspect ) : result;
        case RF_ORTHOGRAPHIC:
            result = read_ymag( gltf, json, where.text, &camera->ymag );
            return result == RF_OK ? read_xmag( gltf, json, where.text, camera->ymag, &camera->aspect ) : result;
        case RF_PANORAMIC: break; // glTF has none
    }
    return RF_OK;
}

// The name of the node, else of the camera, else "camera".
static RfResult base_name( const RfGltf* gltf, int node, int camera, const char** name )
{
    RfWhere where = rf_where( "cameras[%d]", camera );
    const char *node_name = "", *camera_name = "";
    RfResult result = rf_gltf_get_string( gltf, rf_gltf_item( gltf, RF_GLTF_NODES, node ), "nodes", "name", &node_name );
    if ( result == RF_OK )
        result = rf_gltf_get_string( gltf, rf_gltf_item( gltf, RF_GLTF_CAMERAS, camera ), where.text, "name", &camera_name );
    *name = node_name[0] != 0 ? node_name : camera_name[0] != 0 ? camera_name : "camera";
    return result;
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
    return rf_gltf_copy_channel( gltf, &gltf->changes[change].channel, &camera->zoom->channel );
}

static RfResult load_camera( RfGltf* gltf, json_t* names, int node, int index )
{
    const char* base;
    RfCamera* camera = gltf->scene->cameras + gltf->scene->camera_count;
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
        camera->start = gltf->spans[node].start;
        camera->end = gltf->spans[node].end;
    }
    result = load_zoom( gltf, index, camera );
    if ( result == RF_OK && camera->animated )
        result = rf_find_step_cuts( gltf->scene, camera, gltf->error );
    if ( result != RF_OK )
        return result;
    RfWhere where = rf_where( "nodes[%d]", node );
    return rf_gltf_read_camera_path( gltf, rf_gltf_item( gltf, RF_GLTF_NODES, node ), where.text, camera );
}

// Allocates for all nodes with a camera.
static RfResult find_cameras( RfGltf* gltf, int* indices )
{
    size_t count = 0;
    RfResult result = RF_OK;
    for ( int i = 0; result == RF_OK && i < gltf->order_count; ++i )
    {
        RfWhere where = rf_where( "nodes[%d]", gltf->order[i] );
        const json_t* json = rf_gltf_item( gltf, RF_GLTF_NODES, gltf->order[i] );
        result = rf_gltf_get_index( gltf, json, where.text, "camera", RF_GLTF_CAMERAS, indices + i );
        count += indices[i] >= 0;
    }
    if ( result != RF_OK )
        return result;
    gltf->scene->cameras = calloc( count + 1, sizeof *gltf->scene->cameras );
    return gltf->scene->cameras != NULL ? RF_OK : rf_gltf_no_memory( gltf, "cameras" );
}

RfResult rf_gltf_load_cameras( RfGltf* gltf )
{
    int* indices = malloc( ( (size_t)gltf->order_count + 1 ) * sizeof *indices );
    json_t* names = json_object();
    RfResult result = RF_OK;
    if ( indices == NULL || names == NULL )
        result = rf_gltf_no_memory( gltf, "cameras" );
    if ( result == RF_OK )
        result = find_cameras( gltf, indices );
    for ( int i = 0; result == RF_OK && i < gltf->order_count; ++i )
    {
        if ( indices[i] >= 0 )
            result = load_camera( gltf, names, gltf->order[i], indices[i] );
    }
    json_decref( names );
    free( indices );
    return result;
}
