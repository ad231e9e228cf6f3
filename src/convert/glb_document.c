#include "convert/glb_document.h"

#include <stdlib.h>
#include <string.h>

enum
{
    VERTICES = 34962, // bufferView targets: ARRAY_BUFFER
    INDICES = 34963,  // ELEMENT_ARRAY_BUFFER
    FLOAT = 5126,     // component types
    UNSIGNED_INT = 5125,
};

// A new array under `key` of the root, which owns it; NULL if out of memory.
static json_t* root_array( RfGlbDocument* d, const char* key )
{
    json_t* array = json_array();
    rf_glb_set( d, d->root, key, array );
    return d->failed ? NULL : array;
}

// Adds a byte range and its buffer view; returns the index of the view.
static int add_part( RfGlbDocument* d, const void* bytes, uint64_t size, int target )
{
    int index = d->part_count++;
    d->parts[index] = ( RfGlbPart ){ bytes, size };
    json_t* view = json_pack( "{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)d->size, "byteLength", (json_int_t)size );
    if ( target != 0 )
        rf_glb_set( d, view, "target", json_integer( target ) );
    rf_glb_append( d, d->views, view );
    d->size += ( size + 3 ) / 4 * 4;
    return index;
}

static json_t* add_accessor( RfGlbDocument* d, const void* bytes, uint64_t count, const char* type, int width, bool indices )
{
    int view = add_part( d, bytes, count * (uint64_t)width * 4, indices ? INDICES : VERTICES );
    json_t* accessor = json_pack( "{s:i, s:i, s:I, s:s}", "bufferView", view, "componentType", indices ? UNSIGNED_INT : FLOAT,
                                  "count", (json_int_t)count, "type", type );
    rf_glb_append( d, d->accessors, accessor );
    return accessor;
}

static void set_bounds( RfGlbDocument* d, json_t* accessor, const RfModelMesh* mesh )
{
    float low[3], high[3];
    memcpy( low, mesh->positions, sizeof low );
    memcpy( high, mesh->positions, sizeof high );
    for ( uint64_t i = 0; i < 3ull * mesh->vertex_count; ++i )
    {
        float value = mesh->positions[i];
        int axis = (int)( i % 3 );
        low[axis] = value < low[axis] ? value : low[axis];
        high[axis] = value > high[axis] ? value : high[axis];
    }
    rf_glb_set( d, accessor, "min", rf_glb_reals( low, 3 ) );
    rf_glb_set( d, accessor, "max", rf_glb_reals( high, 3 ) );
}

// The primitive of a model mesh, as JSON, with its accessors.
static json_t* make_primitive( RfGlbDocument* d, const RfModelMesh* mesh )
{
    json_t* attributes = json_object();
    int next = (int)json_array_size( d->accessors );
    rf_glb_set( d, attributes, "POSITION", json_integer( next++ ) );
    set_bounds( d, add_accessor( d, mesh->positions, mesh->vertex_count, "VEC3", 3, false ), mesh );
    const struct
    {
        const float* values;
        const char *name, *type;
        int width;
    } more[] = { { mesh->normals, "NORMAL", "VEC3", 3 },
                 { mesh->uvs, "TEXCOORD_0", "VEC2", 2 },
                 { mesh->colors, "COLOR_0", "VEC4", 4 } };
    for ( int i = 0; i < 3; ++i )
    {
        if ( more[i].values == NULL )
            continue;
        rf_glb_set( d, attributes, more[i].name, json_integer( next++ ) );
        add_accessor( d, more[i].values, mesh->vertex_count, more[i].type, more[i].width, false );
    }
    add_accessor( d, mesh->indices, 3ull * mesh->triangle_count, "SCALAR", 1, true );
    json_t* primitive = json_pack( "{s:o, s:i}", "attributes", attributes, "indices", next );
    if ( mesh->material >= 0 )
        rf_glb_set( d, primitive, "material", json_integer( mesh->material ) );
    return primitive;
}

// Creates the glTF mesh of a node: a list of primitives, one for each mesh of the node. Nodes
// with the same single mesh share it.
static int mesh_of_node( RfGlbDocument* d, json_t* primitives, const RfModelNode* node )
{
    int lone = node->mesh_count == 1 ? node->meshes[0] : -1;
    if ( lone >= 0 && d->lone_meshes[lone] >= 0 )
        return d->lone_meshes[lone];
    json_t* list = json_array();
    for ( int i = 0; i < node->mesh_count; ++i )
    {
        if ( json_array_append( list, json_array_get( primitives, (size_t)node->meshes[i] ) ) != 0 )
            d->failed = true;
    }
    json_t* mesh = json_pack( "{s:o}", "primitives", list );
    const char* name = d->model->meshes[node->meshes[0]].name;
    if ( name != NULL )
        rf_glb_set( d, mesh, "name", rf_glb_name( name ) );
    int index = (int)json_array_size( d->meshes );
    rf_glb_append( d, d->meshes, mesh );
    if ( lone >= 0 )
        d->lone_meshes[lone] = index;
    return index;
}

static bool is_identity( const RfMat4* matrix )
{
    for ( int i = 0; i < 16; ++i )
    {
        if ( matrix->m[i] != ( i % 5 == 0 ? 1.0 : 0.0 ) )
            return false;
    }
    return true;
}

static void add_node( RfGlbDocument* d, json_t* nodes, json_t* roots, json_t* primitives, const RfModelNode* node )
{
    json_t* object = json_object();
    if ( node->name != NULL )
        rf_glb_set( d, object, "name", rf_glb_name( node->name ) );
    if ( !is_identity( &node->matrix ) )
    {
        json_t* matrix = json_array();
        for ( int i = 0; i < 16; ++i )
            rf_glb_append( d, matrix, json_real( node->matrix.m[i] ) );
        rf_glb_set( d, object, "matrix", matrix );
    }
    if ( node->mesh_count > 0 )
        rf_glb_set( d, object, "mesh", json_integer( mesh_of_node( d, primitives, node ) ) );
    int index = (int)json_array_size( nodes );
    rf_glb_append( d, nodes, object );
    if ( node->parent < 0 )
    {
        rf_glb_append( d, roots, json_integer( index ) );
        return;
    }
    json_t* parent = json_array_get( nodes, (size_t)node->parent );
    json_t* children = json_object_get( parent, "children" );
    if ( children == NULL )
    {
        children = json_array();
        rf_glb_set( d, parent, "children", children );
    }
    rf_glb_append( d, children, json_integer( index ) );
}

static void add_nodes( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    json_t* primitives = json_array();
    json_t* roots = json_array();
    if ( model->mesh_count > 0 )
    {
        d->accessors = root_array( d, "accessors" );
        d->meshes = root_array( d, "meshes" );
    }
    for ( int i = 0; i < model->mesh_count && !d->failed; ++i )
        rf_glb_append( d, primitives, make_primitive( d, model->meshes + i ) );
    json_t* nodes = model->node_count > 0 ? root_array( d, "nodes" ) : NULL;
    for ( int i = 0; i < model->node_count && !d->failed; ++i )
        add_node( d, nodes, roots, primitives, model->nodes + i );
    if ( json_array_size( d->meshes ) == 0 )
        json_object_del( d->root, "meshes" ); // glTF forbids empty arrays
    json_t* scene = json_object();
    if ( json_array_size( roots ) > 0 )
        rf_glb_set( d, scene, "nodes", roots );
    else
        json_decref( roots );
    rf_glb_set( d, d->root, "scene", json_integer( 0 ) );
    rf_glb_set( d, d->root, "scenes", json_pack( "[o]", scene ) );
    json_decref( primitives );
}

static void add_materials( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    json_t* materials = model->material_count > 0 ? root_array( d, "materials" ) : NULL;
    for ( int i = 0; i < model->material_count && !d->failed; ++i )
        rf_glb_append( d, materials, rf_glb_material( d, model->materials + i ) );
    json_t* images = model->image_count > 0 ? root_array( d, "images" ) : NULL;
    json_t* textures = model->image_count > 0 ? root_array( d, "textures" ) : NULL;
    for ( int i = 0; i < model->image_count && !d->failed; ++i )
    {
        const RfModelImage* image = model->images + i;
        int view = add_part( d, image->bytes, image->size, 0 );
        json_t* object = json_pack( "{s:i, s:s}", "bufferView", view, "mimeType", image->mime );
        if ( image->name != NULL )
            rf_glb_set( d, object, "name", rf_glb_name( image->name ) );
        rf_glb_append( d, images, object );
        rf_glb_append( d, textures, json_pack( "{s:i}", "source", i ) );
    }
}

static void add_cameras( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    json_t* nodes = json_object_get( d->root, "nodes" );
    json_t* cameras = model->camera_count > 0 ? root_array( d, "cameras" ) : NULL;
    for ( int i = 0; i < model->camera_count && !d->failed; ++i )
    {
        const RfModelCamera* camera = model->cameras + i;
        json_t* object =
            json_pack( "{s:s, s:{s:f, s:f}}", "type", "perspective", "perspective", "yfov", camera->yfov, "znear", 0.01 );
        if ( camera->name != NULL )
            rf_glb_set( d, object, "name", rf_glb_name( camera->name ) );
        rf_glb_append( d, cameras, object );
        rf_glb_set( d, json_array_get( nodes, (size_t)camera->node ), "camera", json_integer( i ) );
    }
}

static void add_lights( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    static const char* const kinds[] = { "point", "spot", "directional" };
    json_t* nodes = json_object_get( d->root, "nodes" );
    json_t* lights = json_array();
    for ( int i = 0; i < model->light_count; ++i )
    {
        const RfModelLight* light = model->lights + i;
        json_t* object = json_pack( "{s:s, s:f}", "type", kinds[light->kind], "intensity", (double)light->intensity );
        if ( light->name != NULL )
            rf_glb_set( d, object, "name", rf_glb_name( light->name ) );
        rf_glb_set( d, object, "color", rf_glb_reals( light->color, 3 ) );
        if ( light->kind == RF_MODEL_SPOT )
            rf_glb_set( d, object, "spot",
                        json_pack( "{s:f, s:f}", "innerConeAngle", (double)light->inner_angle, "outerConeAngle",
                                   (double)light->outer_angle ) );
        rf_glb_append( d, lights, object );
        rf_glb_set( d, json_array_get( nodes, (size_t)light->node ), "extensions",
                    json_pack( "{s:{s:i}}", "KHR_lights_punctual", "light", i ) );
    }
    if ( model->light_count > 0 )
        rf_glb_set( d, d->root, "extensions", json_pack( "{s:{s:o}}", "KHR_lights_punctual", "lights", lights ) );
    else
        json_decref( lights );
}

RfResult rf_make_glb_document( const RfModel* model, RfGlbDocument* d, RfError* error )
{
    size_t meshes = (size_t)model->mesh_count, images = (size_t)model->image_count;
    *d = ( RfGlbDocument ){ .model = model, .root = json_object() };
    d->parts = calloc( 5 * meshes + images + 1, sizeof *d->parts );
    d->lone_meshes = malloc( ( meshes + 1 ) * sizeof *d->lone_meshes );
    d->failed = d->root == NULL || d->parts == NULL || d->lone_meshes == NULL;
    for ( size_t i = 0; i < meshes && !d->failed; ++i )
        d->lone_meshes[i] = -1;
    if ( !d->failed )
    {
        rf_glb_set( d, d->root, "asset", json_pack( "{s:s, s:s}", "version", "2.0", "generator", "reframe convert" ) );
        json_t* extensions = rf_glb_extensions( d );
        if ( extensions != NULL )
            rf_glb_set( d, d->root, "extensionsUsed", extensions );
        d->views = meshes + images > 0 ? root_array( d, "bufferViews" ) : NULL;
        add_materials( d );
        add_nodes( d );
        add_cameras( d );
        add_lights( d );
        if ( d->size > 0 )
            rf_glb_set( d, d->root, "buffers", json_pack( "[{s:I}]", "byteLength", (json_int_t)d->size ) );
    }
    return d->failed ? rf_fail( error, RF_ERROR_MEMORY, "out of memory for a model of %zu meshes", meshes ) : RF_OK;
}

void rf_destroy_glb_document( RfGlbDocument* d )
{
    json_decref( d->root );
    free( d->parts );
    free( d->lone_meshes );
    *d = ( RfGlbDocument ){ 0 };
}
