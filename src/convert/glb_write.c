// Writes a model as binary glTF 2.0: checks it, builds the JSON, then writes JSON and buffers in one atomic file.
#include "base/try.h"
#include "convert/model.h"

#include "base/json.h"
#include "base/remedy.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

RfModelMaterial rf_default_model_material( void )
{
    return ( RfModelMaterial ){
        .base_color = { 1, 1, 1, 1 },
        .roughness = 1.0f,
        .specular = 1.0f,
        .ior = 1.5f,
        .alpha_cutoff = 0.5f,
        .base_color_image = -1,
        .normal_image = -1,
        .emissive_image = -1,
    };
}

static void free_mesh( RfModelMesh* mesh )
{
    free( mesh->name );
    free( mesh->positions );
    free( mesh->normals );
    free( mesh->uvs );
    free( mesh->colors );
    free( mesh->indices );
}

void rf_destroy_model( RfModel* model )
{
    for ( int i = 0; model->meshes != NULL && i < model->mesh_count; ++i )
        free_mesh( model->meshes + i );
    for ( int i = 0; model->materials != NULL && i < model->material_count; ++i )
        free( model->materials[i].name );
    for ( int i = 0; model->images != NULL && i < model->image_count; ++i )
    {
        free( model->images[i].name );
        free( model->images[i].bytes );
    }
    for ( int i = 0; model->cameras != NULL && i < model->camera_count; ++i )
        free( model->cameras[i].name );
    for ( int i = 0; model->lights != NULL && i < model->light_count; ++i )
        free( model->lights[i].name );
    for ( int i = 0; model->nodes != NULL && i < model->node_count; ++i )
    {
        free( model->nodes[i].name );
        free( model->nodes[i].meshes );
    }
    free( model->meshes );
    free( model->materials );
    free( model->images );
    free( model->cameras );
    free( model->lights );
    free( model->nodes );
    memset( model, 0, sizeof *model );
}

RfResult rf_apply_root_transform( RfModel* model, bool z_up, double scale, RfError* error )
{
    if ( !z_up && scale == 1.0 )
        return RF_OK;
    RfModelNode* nodes = malloc( ( (size_t)model->node_count + 1 ) * sizeof *nodes );
    if ( nodes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d nodes", model->node_count + 1 );
    RfMat4 matrix = { { scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, 1 } };
    if ( z_up ) // x stays, z becomes y, y becomes −z
        matrix = ( RfMat4 ){ { scale, 0, 0, 0, 0, 0, -scale, 0, 0, scale, 0, 0, 0, 0, 0, 1 } };
    nodes[0] = ( RfModelNode ){ .name = NULL, .parent = -1, .matrix = matrix };
    for ( int i = 0; i < model->node_count; ++i )
    {
        nodes[i + 1] = model->nodes[i];
        nodes[i + 1].parent += 1; // the −1 of former roots becomes 0, the new node
    }
    free( model->nodes );
    model->nodes = nodes;
    model->node_count += 1;
    for ( int i = 0; i < model->camera_count; ++i )
        model->cameras[i].node += 1;
    for ( int i = 0; i < model->light_count; ++i )
        model->lights[i].node += 1;
    return RF_OK;
}

RfModelCounts rf_count_model( const RfModel* model )
{
    RfModelCounts counts = { .meshes = model->mesh_count,
                             .nodes = model->node_count,
                             .materials = model->material_count,
                             .images = model->image_count,
                             .cameras = model->camera_count,
                             .lights = model->light_count };
    for ( int i = 0; i < model->mesh_count; ++i )
        counts.triangles += model->meshes[i].triangle_count;
    return counts;
}

// A byte range inside the model, not a copy.
typedef struct RfGlbPart
{
    const void* bytes;
    uint64_t size;
} RfGlbPart;

typedef struct RfGlbDocument
{
    const RfModel* model;
    json_t* root;
    json_t *accessors, *views, *meshes; // borrowed from root
    json_t* extensions;                 // the names of those that are used are its keys
    RfGlbPart* parts;                   // one per buffer view, each aligned to 4 bytes
    int part_count;
    uint64_t size;    // of the buffer, padded
    int* lone_meshes; // per model mesh: the glTF mesh that holds only this one, or −1
    bool failed;      // out of memory
} RfGlbDocument;

// Pieces of JSON. Sets a key of an object; a failed allocation sets `failed`.
static void set( RfGlbDocument* d, json_t* object, const char* key, json_t* value )
{
    if ( json_object_set_new( object, key, value ) != 0 )
        d->failed = true;
}

// Appends to an array; a failed allocation sets `failed`.
static void append( RfGlbDocument* d, json_t* array, json_t* value )
{
    if ( json_array_append_new( array, value ) != 0 )
        d->failed = true;
}

// A value that is not NULL unless memory ran out.
static json_t* made( RfGlbDocument* d, json_t* value )
{
    d->failed |= value == NULL;
    return value;
}

static json_t* reals( RfGlbDocument* d, const float* values, int count )
{
    json_t* array = json_array();
    for ( int i = 0; i < count; ++i )
        append( d, array, json_real( (double)values[i] ) );
    return made( d, array );
}

// NULL where there is none.
static json_t* glb_name( RfGlbDocument* d, const char* name ) { return name != NULL ? made( d, rf_json_text( name ) ) : NULL; }

static float emission_strength( const RfModelMaterial* m )
{
    return fmaxf( fmaxf( m->emission[0], m->emission[1] ), fmaxf( m->emission[2], 1.0f ) );
}

// An extension with one factor; NULL where that has its default.
static json_t* extension( RfGlbDocument* d, const char* factor, float value, float usual )
{
    return value != usual ? made( d, json_pack( "{s:f}", factor, (double)value ) ) : NULL;
}

// Texture i of the file uses image i of the model.
static json_t* texture( RfGlbDocument* d, int image )
{
    return image >= 0 ? made( d, json_pack( "{s:i}", "index", image ) ) : NULL;
}

static json_t* glb_material( RfGlbDocument* d, const RfModelMaterial* m )
{
    static const char* const modes[] = { [RF_MODEL_OPAQUE] = NULL, [RF_MODEL_MASK] = "MASK", [RF_MODEL_BLEND] = "BLEND" };
    float strength = emission_strength( m ), factor[3];
    for ( int i = 0; i < 3; ++i )
        factor[i] = m->emission[i] / strength;
    bool shines = factor[0] > 0.0f || factor[1] > 0.0f || factor[2] > 0.0f, masked = m->alpha_mode == RF_MODEL_MASK;
    json_t* extensions = made( d, json_pack( "{s:o*, s:o*, s:o*, s:o*}", "KHR_materials_emissive_strength",
                                             extension( d, "emissiveStrength", strength, 1.0f ), "KHR_materials_specular",
                                             extension( d, "specularFactor", m->specular, 1.0f ), "KHR_materials_ior",
                                             extension( d, "ior", m->ior, 1.5f ), "KHR_materials_transmission",
                                             extension( d, "transmissionFactor", m->transmission, 0.0f ) ) );
    json_t* material =
        made( d, json_pack( "{s:o*, s:{s:o, s:f, s:f, s:o*}, s:o*, s:o*, s:o*, s:s*, s:o*, s:o*, s:O*}", "name",
                            glb_name( d, m->name ), "pbrMetallicRoughness", "baseColorFactor", reals( d, m->base_color, 4 ),
                            "metallicFactor", (double)m->metallic, "roughnessFactor", (double)m->roughness, "baseColorTexture",
                            texture( d, m->base_color_image ), "normalTexture", texture( d, m->normal_image ), "emissiveTexture",
                            texture( d, m->emissive_image ), "emissiveFactor", shines ? reals( d, factor, 3 ) : NULL, "alphaMode",
                            modes[m->alpha_mode], "alphaCutoff", masked ? made( d, json_real( (double)m->alpha_cutoff ) ) : NULL,
                            "doubleSided", m->double_sided ? json_true() : NULL, "extensions",
                            json_object_size( extensions ) > 0 ? extensions : NULL ) );
    json_decref( extensions );
    return material;
}

// Adds the names of extensions, which are the keys of an object, to those that the document uses.
static void use_extensions( RfGlbDocument* d, const json_t* extensions )
{
    const char* key;
    json_t* unused;
    json_object_foreach( (json_t*)extensions, key, unused ) set( d, d->extensions, key, json_true() );
}

// The two chunks of a .glb file: the JSON document, and the byte ranges of the
// binary buffer, one per buffer view and in their order.

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
    set( d, d->root, key, array );
    return d->failed ? NULL : array;
}

// Adds a byte range and its buffer view; returns the index of the view.
static int add_part( RfGlbDocument* d, const void* bytes, uint64_t size, int target )
{
    int index = d->part_count++;
    d->parts[index] = ( RfGlbPart ){ bytes, size };
    json_t* view = json_pack( "{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)d->size, "byteLength", (json_int_t)size );
    if ( target != 0 )
        set( d, view, "target", json_integer( target ) );
    append( d, d->views, view );
    d->size += ( size + 3 ) / 4 * 4;
    return index;
}

static json_t* add_accessor( RfGlbDocument* d, const void* bytes, uint64_t count, const char* type, int width, bool indices )
{
    int view = add_part( d, bytes, count * (uint64_t)width * 4, indices ? INDICES : VERTICES );
    json_t* accessor = json_pack( "{s:i, s:i, s:I, s:s}", "bufferView", view, "componentType", indices ? UNSIGNED_INT : FLOAT,
                                  "count", (json_int_t)count, "type", type );
    append( d, d->accessors, accessor );
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
    set( d, accessor, "min", reals( d, low, 3 ) );
    set( d, accessor, "max", reals( d, high, 3 ) );
}

// The primitive of a model mesh, as JSON, with its accessors.
static json_t* make_primitive( RfGlbDocument* d, const RfModelMesh* mesh )
{
    json_t* attributes = json_object();
    int next = (int)json_array_size( d->accessors );
    set( d, attributes, "POSITION", json_integer( next++ ) );
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
        set( d, attributes, more[i].name, json_integer( next++ ) );
        add_accessor( d, more[i].values, mesh->vertex_count, more[i].type, more[i].width, false );
    }
    add_accessor( d, mesh->indices, 3ull * mesh->triangle_count, "SCALAR", 1, true );
    json_t* primitive = json_pack( "{s:o, s:i}", "attributes", attributes, "indices", next );
    if ( mesh->material >= 0 )
        set( d, primitive, "material", json_integer( mesh->material ) );
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
    json_t* mesh = json_pack( "{s:o, s:o*}", "primitives", list, "name", glb_name( d, d->model->meshes[node->meshes[0]].name ) );
    int index = (int)json_array_size( d->meshes );
    append( d, d->meshes, mesh );
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
    json_t* object = json_pack( "{s:o*}", "name", glb_name( d, node->name ) );
    if ( !is_identity( &node->matrix ) )
    {
        json_t* matrix = json_array();
        for ( int i = 0; i < 16; ++i )
            append( d, matrix, json_real( node->matrix.m[i] ) );
        set( d, object, "matrix", matrix );
    }
    if ( node->mesh_count > 0 )
        set( d, object, "mesh", json_integer( mesh_of_node( d, primitives, node ) ) );
    int index = (int)json_array_size( nodes );
    append( d, nodes, object );
    if ( node->parent < 0 )
    {
        append( d, roots, json_integer( index ) );
        return;
    }
    json_t* parent = json_array_get( nodes, (size_t)node->parent );
    json_t* children = json_object_get( parent, "children" );
    if ( children == NULL )
    {
        children = json_array();
        set( d, parent, "children", children );
    }
    append( d, children, json_integer( index ) );
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
        append( d, primitives, make_primitive( d, model->meshes + i ) );
    json_t* nodes = model->node_count > 0 ? root_array( d, "nodes" ) : NULL;
    for ( int i = 0; i < model->node_count && !d->failed; ++i )
        add_node( d, nodes, roots, primitives, model->nodes + i );
    if ( json_array_size( d->meshes ) == 0 )
        json_object_del( d->root, "meshes" ); // glTF forbids empty arrays
    json_t* scene = json_object();
    if ( json_array_size( roots ) > 0 )
        set( d, scene, "nodes", roots );
    else
        json_decref( roots );
    set( d, d->root, "scene", json_integer( 0 ) );
    set( d, d->root, "scenes", json_pack( "[o]", scene ) );
    json_decref( primitives );
}

static void add_materials( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    json_t* materials = model->material_count > 0 ? root_array( d, "materials" ) : NULL;
    for ( int i = 0; i < model->material_count && !d->failed; ++i )
    {
        json_t* material = glb_material( d, model->materials + i );
        use_extensions( d, json_object_get( material, "extensions" ) );
        append( d, materials, material );
    }
    json_t* images = model->image_count > 0 ? root_array( d, "images" ) : NULL;
    json_t* textures = model->image_count > 0 ? root_array( d, "textures" ) : NULL;
    for ( int i = 0; i < model->image_count && !d->failed; ++i )
    {
        const RfModelImage* image = model->images + i;
        int view = add_part( d, image->bytes, image->size, 0 );
        append(
            d, images,
            json_pack( "{s:i, s:s, s:o*}", "bufferView", view, "mimeType", image->mime, "name", glb_name( d, image->name ) ) );
        append( d, textures, json_pack( "{s:i}", "source", i ) );
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
        append( d, cameras,
                json_pack( "{s:s, s:{s:f, s:f}, s:o*}", "type", "perspective", "perspective", "yfov", camera->yfov, "znear", 0.01,
                           "name", glb_name( d, camera->name ) ) );
        set( d, json_array_get( nodes, (size_t)camera->node ), "camera", json_integer( i ) );
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
        json_t* object = json_pack( "{s:s, s:f, s:o*, s:o}", "type", kinds[light->kind], "intensity", (double)light->intensity,
                                    "name", glb_name( d, light->name ), "color", reals( d, light->color, 3 ) );
        if ( light->kind == RF_MODEL_SPOT )
            set( d, object, "spot",
                 json_pack( "{s:f, s:f}", "innerConeAngle", (double)light->inner_angle, "outerConeAngle",
                            (double)light->outer_angle ) );
        append( d, lights, object );
        set( d, json_array_get( nodes, (size_t)light->node ), "extensions",
             json_pack( "{s:{s:i}}", "KHR_lights_punctual", "light", i ) );
    }
    if ( model->light_count > 0 )
    {
        set( d, d->root, "extensions", json_pack( "{s:{s:O}}", "KHR_lights_punctual", "lights", lights ) );
        use_extensions( d, json_object_get( d->root, "extensions" ) );
    }
    json_decref( lights );
}

static void add_extensions( RfGlbDocument* d )
{
    const char* name;
    json_t *unused, *names = json_object_size( d->extensions ) > 0 ? root_array( d, "extensionsUsed" ) : NULL;
    json_object_foreach( d->extensions, name, unused ) append( d, names, json_string( name ) );
}

// Builds both chunks; destroy_glb_document frees them, also after a failure.
static RfResult make_glb_document( const RfModel* model, RfGlbDocument* d, RfError* error )
{
    size_t meshes = (size_t)model->mesh_count, images = (size_t)model->image_count;
    *d = ( RfGlbDocument ){ .model = model, .root = json_object(), .extensions = json_object() };
    d->parts = calloc( 5 * meshes + images + 1, sizeof *d->parts );
    d->lone_meshes = malloc( ( meshes + 1 ) * sizeof *d->lone_meshes );
    d->failed = d->root == NULL || d->extensions == NULL || d->parts == NULL || d->lone_meshes == NULL;
    for ( size_t i = 0; i < meshes && !d->failed; ++i )
        d->lone_meshes[i] = -1;
    if ( !d->failed )
    {
        set( d, d->root, "asset", json_pack( "{s:s, s:s}", "version", "2.0", "generator", "reframe convert" ) );
        d->views = meshes + images > 0 ? root_array( d, "bufferViews" ) : NULL;
        add_materials( d );
        add_nodes( d );
        add_cameras( d );
        add_lights( d );
        add_extensions( d );
        if ( d->size > 0 )
            set( d, d->root, "buffers", json_pack( "[{s:I}]", "byteLength", (json_int_t)d->size ) );
    }
    return d->failed ? rf_fail( error, RF_ERROR_MEMORY, "out of memory for a model of %zu meshes", meshes ) : RF_OK;
}

static void destroy_glb_document( RfGlbDocument* d )
{
    json_decref( d->root );
    json_decref( d->extensions );
    free( d->parts );
    free( d->lone_meshes );
    *d = ( RfGlbDocument ){ 0 };
}

static bool all_finite( const float* values, uint64_t count )
{
    for ( uint64_t i = 0; values != NULL && i < count; ++i )
    {
        if ( !isfinite( values[i] ) )
            return false;
    }
    return true;
}

static RfResult check_mesh( const RfModel* model, int index, RfError* error )
{
    const RfModelMesh* mesh = model->meshes + index;
    const char* name = mesh->name != NULL ? mesh->name : "";
    uint64_t vertices = mesh->vertex_count, corners = 3ull * mesh->triangle_count;
    if ( vertices == 0 || corners == 0 || mesh->positions == NULL || mesh->indices == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': has no triangles", index, name );
    if ( mesh->material < -1 || mesh->material >= model->material_count )
        return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': there is no material %d", index, name, mesh->material );
    if ( !all_finite( mesh->positions, 3 * vertices ) || !all_finite( mesh->normals, 3 * vertices ) ||
         !all_finite( mesh->uvs, 2 * vertices ) || !all_finite( mesh->colors, 4 * vertices ) )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "mesh %d '%s': has coordinates that are not finite numbers: repair the file it came from", index, name );
    for ( uint64_t i = 0; i < corners; ++i )
    {
        if ( mesh->indices[i] >= vertices )
            return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': triangle %llu: there is no vertex %lu", index, name,
                            (unsigned long long)( i / 3 ), (unsigned long)mesh->indices[i] );
    }
    return RF_OK;
}

static bool within( float value, float low, float high )
{
    return value >= low && value <= high; // false for NaN
}

static RfResult check_material( const RfModel* model, int index, RfError* error )
{
    const RfModelMaterial* m = model->materials + index;
    bool good = within( m->metallic, 0, 1 ) && within( m->roughness, 0, 1 ) && within( m->specular, 0, 1 ) &&
                within( m->transmission, 0, 1 ) && within( m->alpha_cutoff, 0, 1 ) && m->ior >= 1.0f && isfinite( m->ior );
    for ( int i = 0; i < 4; ++i )
        good = good && within( m->base_color[i], 0, 1 );
    for ( int i = 0; i < 3; ++i )
        good = good && m->emission[i] >= 0.0f && isfinite( m->emission[i] );
    const int images[3] = { m->base_color_image, m->normal_image, m->emissive_image };
    for ( int i = 0; i < 3; ++i )
        good = good && images[i] >= -1 && images[i] < model->image_count;
    if ( good )
        return RF_OK;
    return rf_fail( error, RF_ERROR_FORMAT, "material %d '%s': has a value that glTF cannot hold", index,
                    m->name != NULL ? m->name : "" );
}

static RfResult check_node( const RfModel* model, int index, RfError* error )
{
    const RfModelNode* node = model->nodes + index;
    bool good = node->parent >= -1 && node->parent < index;
    for ( int i = 0; i < 16; ++i )
        good = good && isfinite( node->matrix.m[i] );
    for ( int i = 0; i < node->mesh_count; ++i )
        good = good && node->meshes[i] >= 0 && node->meshes[i] < model->mesh_count;
    if ( good )
        return RF_OK;
    return rf_fail( error, RF_ERROR_FORMAT, "node %d '%s': its parent, matrix or meshes are out of range", index,
                    node->name != NULL ? node->name : "" );
}

static RfResult check_lights_and_cameras( const RfModel* model, RfError* error )
{
    for ( int i = 0; i < model->camera_count; ++i )
    {
        const RfModelCamera* camera = model->cameras + i;
        if ( !( camera->yfov > 0.0 && camera->yfov < 3.14159265 ) || camera->node < 0 || camera->node >= model->node_count )
            return rf_fail( error, RF_ERROR_FORMAT, "camera %d: its field of view or node is out of range", i );
    }
    for ( int i = 0; i < model->light_count; ++i )
    {
        const RfModelLight* light = model->lights + i;
        bool good =
            light->node >= 0 && light->node < model->node_count && light->intensity >= 0.0f && isfinite( light->intensity );
        for ( int k = 0; k < 3; ++k )
            good = good && within( light->color[k], 0, 1 );
        if ( light->kind == RF_MODEL_SPOT )
            good =
                good && light->inner_angle >= 0.0f && light->inner_angle < light->outer_angle && light->outer_angle <= 1.5707964f;
        if ( !good )
            return rf_fail( error, RF_ERROR_FORMAT, "light %d: has a value that glTF cannot hold", i );
    }
    return RF_OK;
}

// Rejects a model that glTF cannot represent; the message names the part.
static RfResult check_model( const RfModel* model, RfError* error )
{
    for ( int i = 0; i < model->mesh_count; ++i )
        RF_TRY( check_mesh( model, i, error ) );
    for ( int i = 0; i < model->material_count; ++i )
        RF_TRY( check_material( model, i, error ) );
    for ( int i = 0; i < model->node_count; ++i )
        RF_TRY( check_node( model, i, error ) );
    return check_lights_and_cameras( model, error );
}

static void put_u32( uint8_t* at, uint64_t value )
{
    for ( int i = 0; i < 4; ++i )
        at[i] = (uint8_t)( value >> ( 8 * i ) );
}

static RfResult append_padding( RfAtomicFile* file, uint64_t size, char fill, RfError* error )
{
    const char padding[3] = { fill, fill, fill };
    return rf_append_atomic_file( file, padding, (size_t)( ( 4 - size % 4 ) % 4 ), error );
}

static RfResult append_chunk_head( RfAtomicFile* file, uint64_t size, const char* type, RfError* error )
{
    uint8_t head[8];
    put_u32( head, ( size + 3 ) / 4 * 4 );
    memcpy( head + 4, type, 4 );
    return rf_append_atomic_file( file, head, sizeof head, error );
}

static RfResult append_binary( RfAtomicFile* file, const RfGlbDocument* document, RfError* error )
{
    RF_TRY( append_chunk_head( file, document->size, "BIN\0", error ) );
    for ( int i = 0; i < document->part_count; ++i )
    {
        const RfGlbPart* part = document->parts + i;
        RF_TRY( rf_append_atomic_file( file, part->bytes, (size_t)part->size, error ) );
        RF_TRY( append_padding( file, part->size, 0, error ) );
    }
    return RF_OK;
}

static RfResult append_all( RfAtomicFile* file, const RfGlbDocument* document, const char* text, RfError* error )
{
    uint64_t text_size = strlen( text );
    uint64_t total = 12 + 8 + ( text_size + 3 ) / 4 * 4 + ( document->size > 0 ? 8 + document->size : 0 );
    if ( total > UINT32_MAX )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: would have %llu bytes, a .glb holds up to 4 GiB: split the model",
                        file->path, (unsigned long long)total );
    uint8_t head[12] = { 'g', 'l', 'T', 'F' };
    put_u32( head + 4, 2 );
    put_u32( head + 8, total );
    RF_TRY( rf_append_atomic_file( file, head, sizeof head, error ) );
    RF_TRY( append_chunk_head( file, text_size, "JSON", error ) );
    RF_TRY( rf_append_atomic_file( file, text, (size_t)text_size, error ) );
    RF_TRY( append_padding( file, text_size, ' ', error ) );
    return document->size > 0 ? append_binary( file, document, error ) : RF_OK;
}

RfResult rf_append_glb( RfAtomicFile* file, const RfModel* model, RfError* error )
{
    RF_TRY( check_model( model, error ) );
    RfGlbDocument document;
    RfResult result = make_glb_document( model, &document, error );
    if ( result == RF_OK )
    {
        char* text = json_dumps( document.root, JSON_COMPACT );
        if ( text == NULL )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its JSON", file->path );
        else
            result = append_all( file, &document, text, error );
        free( text );
    }
    destroy_glb_document( &document );
    return result;
}

RfResult rf_write_glb( const char* path, const RfModel* model, bool overwrite, RfError* error )
{
    if ( !overwrite && access( path, F_OK ) == 0 )
        return rf_advise( rf_fail( error, RF_ERROR_IO, "%s: already exists", path ), RF_REMEDY_OVERWRITE, 0, error );
    RfAtomicFile file;
    RF_TRY( rf_open_atomic_file( path, &file, error ) );
    RfResult result = rf_append_glb( &file, model, error );
    return rf_end_atomic_file( &file, result, error );
}
