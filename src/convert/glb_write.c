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
    int part_count, part_room;
    uint64_t size;    // of the buffer, padded
    int* lone_meshes; // per model mesh: the glTF mesh that holds only this one, or −1
    int* skins;       // per model mesh: its skin
    bool* moves;      // per node: whether an animation moves it
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

// Adds the names of extensions, which are the keys of an object, to those that the document uses.
static void use_extensions( RfGlbDocument* d, const json_t* extensions )
{
    const char* key;
    json_t* unused;
    json_object_foreach( (json_t*)extensions, key, unused ) set( d, d->extensions, key, json_true() );
}

static float emission_strength( const RfModelMaterial* m )
{
    return fmaxf( fmaxf( m->emission[0], m->emission[1] ), fmaxf( m->emission[2], 1.0f ) );
}

// An extension with one factor; NULL where that has its default.
static json_t* extension( RfGlbDocument* d, const char* factor, float value, float usual )
{
    return value != usual ? made( d, json_pack( "{s:f}", factor, (double)value ) ) : NULL;
}

// Texture i of the file uses image i of the model; those after them are the same, clamped.
static json_t* texture( RfGlbDocument* d, const RfModelTexture* t )
{
    if ( t->image < 0 )
        return NULL;
    json_t* object = made( d, json_pack( "{s:i}", "index", t->image + ( t->clamp ? d->model->image_count : 0 ) ) );
    bool plain = t->scale[0] == 1.0f && t->scale[1] == 1.0f && t->offset[0] == 0.0f && t->offset[1] == 0.0f;
    if ( plain || ( t->scale[0] == 0.0f && t->scale[1] == 0.0f ) )
        return object;
    json_t* extensions = made( d, json_pack( "{s:{s:o, s:o}}", "KHR_texture_transform", "offset", reals( d, t->offset, 2 ),
                                             "scale", reals( d, t->scale, 2 ) ) );
    use_extensions( d, extensions );
    set( d, object, "extensions", extensions );
    return object;
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
    json_t* material = made(
        d,
        json_pack( "{s:o*, s:{s:o, s:f, s:f, s:o*}, s:o*, s:o*, s:o*, s:s*, s:o*, s:o*, s:O*}", "name", glb_name( d, m->name ),
                   "pbrMetallicRoughness", "baseColorFactor", reals( d, m->base_color, 4 ), "metallicFactor", (double)m->metallic,
                   "roughnessFactor", (double)m->roughness, "baseColorTexture", texture( d, &m->base_color_texture ),
                   "normalTexture", texture( d, &m->normal_texture ), "emissiveTexture", texture( d, &m->emissive_texture ),
                   "emissiveFactor", shines ? reals( d, factor, 3 ) : NULL, "alphaMode", modes[m->alpha_mode], "alphaCutoff",
                   masked ? made( d, json_real( (double)m->alpha_cutoff ) ) : NULL, "doubleSided",
                   m->double_sided ? json_true() : NULL, "extensions", json_object_size( extensions ) > 0 ? extensions : NULL ) );
    json_decref( extensions );
    return material;
}

// The two chunks of a .glb file: the JSON document, and the byte ranges of the
// binary buffer, one per buffer view and in their order.

enum
{
    VERTICES = 34962, // bufferView targets: ARRAY_BUFFER
    INDICES = 34963,  // ELEMENT_ARRAY_BUFFER
    FLOAT = 5126,     // component types
    UNSIGNED_INT = 5125,
    UNSIGNED_SHORT = 5123,
    CLAMP_TO_EDGE = 33071,
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
    if ( d->part_count == d->part_room )
    {
        int room = d->part_room > 0 ? 2 * d->part_room : 64;
        RfGlbPart* more = realloc( d->parts, (size_t)room * sizeof *more );
        d->failed |= more == NULL;
        if ( more == NULL )
            return 0;
        d->parts = more;
        d->part_room = room;
    }
    int index = d->part_count++;
    d->parts[index] = ( RfGlbPart ){ bytes, size };
    json_t* view = json_pack( "{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)d->size, "byteLength", (json_int_t)size );
    if ( target != 0 )
        set( d, view, "target", json_integer( target ) );
    append( d, d->views, view );
    d->size += ( size + 3 ) / 4 * 4;
    return index;
}

// A table of numbers, 4 bytes each. Returns the accessor, which is the last one.
static json_t* add_accessor( RfGlbDocument* d, const void* bytes, uint64_t count, const char* type, int width, int target )
{
    int view = add_part( d, bytes, count * (uint64_t)width * 4, target );
    json_t* accessor = json_pack( "{s:i, s:i, s:I, s:s}", "bufferView", view, "componentType",
                                  target == INDICES ? UNSIGNED_INT : FLOAT, "count", (json_int_t)count, "type", type );
    append( d, d->accessors, accessor );
    return accessor;
}

static json_t* last_accessor( const RfGlbDocument* d ) { return json_integer( (json_int_t)json_array_size( d->accessors ) - 1 ); }

static void set_bounds( RfGlbDocument* d, json_t* accessor, const float* positions, uint32_t count )
{
    float low[3], high[3];
    memcpy( low, positions, sizeof low );
    memcpy( high, positions, sizeof high );
    for ( uint64_t i = 0; i < 3ull * count; ++i )
    {
        float value = positions[i];
        int axis = (int)( i % 3 );
        low[axis] = value < low[axis] ? value : low[axis];
        high[axis] = value > high[axis] ? value : high[axis];
    }
    set( d, accessor, "min", reals( d, low, 3 ) );
    set( d, accessor, "max", reals( d, high, 3 ) );
}

static void add_positions( RfGlbDocument* d, json_t* attributes, const float* positions, uint32_t count )
{
    set_bounds( d, add_accessor( d, positions, count, "VEC3", 3, VERTICES ), positions, count );
    set( d, attributes, "POSITION", last_accessor( d ) );
}

// Joints and weights of the vertices, four by four: the second four only where they count.
static void add_influences( RfGlbDocument* d, json_t* attributes, const RfModelMesh* mesh )
{
    static const char* const names[2][2] = { { "JOINTS_0", "WEIGHTS_0" }, { "JOINTS_1", "WEIGHTS_1" } };
    uint32_t count = mesh->vertex_count;
    bool more = false;
    for ( size_t i = 0; i < count; ++i )
        more = more || mesh->skin->weights[RF_MODEL_INFLUENCES * i + 4] > 0.0f;
    int joints = add_part( d, mesh->skin->influences, (uint64_t)count * RF_MODEL_INFLUENCES * 2, VERTICES );
    set( d, json_array_get( d->views, (size_t)joints ), "byteStride", json_integer( RF_MODEL_INFLUENCES * 2 ) );
    int weights = add_part( d, mesh->skin->weights, (uint64_t)count * RF_MODEL_INFLUENCES * 4, VERTICES );
    set( d, json_array_get( d->views, (size_t)weights ), "byteStride", json_integer( RF_MODEL_INFLUENCES * 4 ) );
    for ( int i = 0; i < ( more ? 2 : 1 ); ++i )
    {
        const int views[2] = { joints, weights }, sizes[2] = { 8, 16 }, types[2] = { UNSIGNED_SHORT, FLOAT };
        for ( int k = 0; k < 2; ++k )
        {
            append( d, d->accessors,
                    json_pack( "{s:i, s:i, s:i, s:I, s:s}", "bufferView", views[k], "byteOffset", i * sizes[k], "componentType",
                               types[k], "count", (json_int_t)count, "type", "VEC4" ) );
            set( d, attributes, names[i][k], last_accessor( d ) );
        }
    }
}

static json_t* make_targets( RfGlbDocument* d, const RfModelMesh* mesh )
{
    json_t* targets = json_array();
    for ( int i = 0; i < mesh->morph_count; ++i )
    {
        json_t* target = json_object();
        add_positions( d, target, mesh->morphs[i].positions, mesh->vertex_count );
        if ( mesh->normals != NULL && mesh->morphs[i].normals != NULL )
        {
            add_accessor( d, mesh->morphs[i].normals, mesh->vertex_count, "VEC3", 3, VERTICES );
            set( d, target, "NORMAL", last_accessor( d ) );
        }
        append( d, targets, target );
    }
    return targets;
}

// The primitive of a model mesh, as JSON, with its accessors.
static json_t* make_primitive( RfGlbDocument* d, const RfModelMesh* mesh )
{
    json_t* attributes = json_object();
    add_positions( d, attributes, mesh->positions, mesh->vertex_count );
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
        add_accessor( d, more[i].values, mesh->vertex_count, more[i].type, more[i].width, VERTICES );
        set( d, attributes, more[i].name, last_accessor( d ) );
    }
    if ( mesh->skin != NULL )
        add_influences( d, attributes, mesh );
    json_t* targets = mesh->morph_count > 0 ? make_targets( d, mesh ) : NULL;
    add_accessor( d, mesh->indices, 3ull * mesh->triangle_count, "SCALAR", 1, INDICES );
    json_t* primitive =
        json_pack( "{s:o, s:o, s:o*}", "attributes", attributes, "indices", last_accessor( d ), "targets", targets );
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
    const RfModelMesh* first = d->model->meshes + node->meshes[0];
    json_t* mesh = json_pack( "{s:o, s:o*}", "primitives", list, "name", glb_name( d, first->name ) );
    json_t* names = json_array();
    for ( int i = 0; i < first->morph_count; ++i )
        append( d, names, first->morphs[i].name != NULL ? glb_name( d, first->morphs[i].name ) : json_string( "" ) );
    if ( first->morph_count > 0 )
        set( d, mesh, "extras", json_pack( "{s:O}", "targetNames", names ) );
    json_decref( names );
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

// The skin of a mesh, which all nodes with it share.
static int add_skin( RfGlbDocument* d, const RfModelSkin* skin )
{
    json_t* skins = json_object_get( d->root, "skins" );
    if ( skins == NULL )
        skins = root_array( d, "skins" );
    json_t* joints = json_array();
    for ( int i = 0; i < skin->joint_count; ++i )
        append( d, joints, json_integer( skin->joints[i] ) );
    add_accessor( d, skin->inverse_binds, (uint64_t)skin->joint_count, "MAT4", 16, 0 );
    append( d, skins, json_pack( "{s:o, s:o}", "joints", joints, "inverseBindMatrices", last_accessor( d ) ) );
    return (int)json_array_size( skins ) - 1;
}

static json_t* doubles( RfGlbDocument* d, const double* values, int count )
{
    json_t* array = json_array();
    for ( int i = 0; i < count; ++i )
        append( d, array, json_real( values[i] ) );
    return array;
}

// A node that an animation moves has translation, rotation and scale instead of a matrix.
static void set_parts( RfGlbDocument* d, json_t* object, const RfMat4* matrix )
{
    double t[3], q[4], s[3];
    rf_split_matrix( matrix, t, q, s );
    set( d, object, "translation", doubles( d, t, 3 ) );
    set( d, object, "rotation", doubles( d, q, 4 ) );
    set( d, object, "scale", doubles( d, s, 3 ) );
}

static void add_node( RfGlbDocument* d, json_t* nodes, json_t* roots, json_t* primitives, const RfModelNode* node )
{
    json_t* object = json_pack( "{s:o*}", "name", glb_name( d, node->name ) );
    const RfModelMesh* mesh = node->mesh_count == 1 ? d->model->meshes + node->meshes[0] : NULL;
    if ( d->moves[node - d->model->nodes] )
        set_parts( d, object, &node->matrix );
    else if ( !is_identity( &node->matrix ) )
    {
        set( d, object, "matrix", doubles( d, node->matrix.m, 16 ) );
    }
    if ( node->mesh_count > 0 )
        set( d, object, "mesh", json_integer( mesh_of_node( d, primitives, node ) ) );
    if ( mesh != NULL && node->weights != NULL )
        set( d, object, "weights", reals( d, node->weights, mesh->morph_count ) );
    if ( mesh != NULL && mesh->skin != NULL )
        set( d, object, "skin", json_integer( d->skins[node->meshes[0]] ) );
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
    {
        append( d, primitives, make_primitive( d, model->meshes + i ) );
        d->skins[i] = model->meshes[i].skin != NULL ? add_skin( d, model->meshes[i].skin ) : -1;
    }
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
    bool clamps = false;
    for ( int i = 0; i < model->material_count; ++i )
    {
        const RfModelMaterial* m = model->materials + i;
        clamps = clamps || m->base_color_texture.clamp || m->normal_texture.clamp || m->emissive_texture.clamp;
    }
    for ( int i = 0; clamps && i < model->image_count; ++i )
        append( d, textures, json_pack( "{s:i, s:i}", "source", i, "sampler", 0 ) );
    if ( clamps && model->image_count > 0 )
        set( d, d->root, "samplers", json_pack( "[{s:i, s:i}]", "wrapS", CLAMP_TO_EDGE, "wrapT", CLAMP_TO_EDGE ) );
}

static void add_cameras( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    json_t* nodes = json_object_get( d->root, "nodes" );
    json_t* cameras = model->camera_count > 0 ? root_array( d, "cameras" ) : NULL;
    for ( int i = 0; i < model->camera_count && !d->failed; ++i )
    {
        const RfModelCamera* camera = model->cameras + i;
        json_t* name = glb_name( d, camera->name );
        if ( camera->xmag > 0.0 )
            append( d, cameras,
                    json_pack( "{s:s, s:{s:f, s:f, s:f, s:f}, s:o*}", "type", "orthographic", "orthographic", "xmag",
                               camera->xmag, "ymag", camera->ymag, "znear", 0.0, "zfar", 1e6, "name", name ) );
        else
            append( d, cameras,
                    json_pack( "{s:s, s:{s:f, s:f}, s:o*}", "type", "perspective", "perspective", "yfov", camera->yfov, "znear",
                               0.01, "name", name ) );
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

static void add_animation( RfGlbDocument* d, json_t* animations, const RfModelAnimation* animation )
{
    static const char* const paths[] = { "translation", "rotation", "scale", "weights" };
    json_t *samplers = json_array(), *channels = json_array();
    for ( int i = 0; i < animation->track_count; ++i )
    {
        const RfModelTrack* track = animation->tracks + i;
        uint64_t keys = (uint64_t)track->key_count, values = keys;
        const char* type = track->path == RF_MODEL_ROTATION ? "VEC4" : "VEC3";
        int width = track->width;
        if ( track->path == RF_MODEL_WEIGHTS )
        {
            type = "SCALAR";
            values *= (uint64_t)width;
            width = 1;
        }
        json_t* times = add_accessor( d, track->times, keys, "SCALAR", 1, 0 );
        set( d, times, "min", reals( d, track->times, 1 ) );
        set( d, times, "max", reals( d, track->times + keys - 1, 1 ) );
        json_t* input = last_accessor( d );
        add_accessor( d, track->values, values, type, width, 0 );
        append( d, samplers, json_pack( "{s:o, s:o}", "input", input, "output", last_accessor( d ) ) );
        append( d, channels,
                json_pack( "{s:i, s:{s:i, s:s}}", "sampler", i, "target", "node", track->node, "path", paths[track->path] ) );
    }
    append( d, animations,
            json_pack( "{s:o, s:o, s:o*}", "samplers", samplers, "channels", channels, "name", glb_name( d, animation->name ) ) );
}

static void add_animations( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    json_t* animations = model->animation_count > 0 ? root_array( d, "animations" ) : NULL;
    for ( int i = 0; i < model->animation_count && !d->failed; ++i )
        add_animation( d, animations, model->animations + i );
}

// Whether each node has a track that moves it.
static void find_moves( RfGlbDocument* d )
{
    for ( int i = 0; i < d->model->animation_count; ++i )
    {
        const RfModelAnimation* animation = d->model->animations + i;
        for ( int k = 0; k < animation->track_count; ++k )
            d->moves[animation->tracks[k].node] |= animation->tracks[k].path != RF_MODEL_WEIGHTS;
    }
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
    d->lone_meshes = malloc( ( meshes + 1 ) * sizeof *d->lone_meshes );
    d->skins = malloc( ( meshes + 1 ) * sizeof *d->skins );
    d->moves = calloc( (size_t)model->node_count + 1, sizeof *d->moves );
    d->failed = d->root == NULL || d->extensions == NULL || d->lone_meshes == NULL || d->skins == NULL || d->moves == NULL;
    for ( size_t i = 0; i < meshes && !d->failed; ++i )
        d->lone_meshes[i] = -1;
    if ( !d->failed )
    {
        set( d, d->root, "asset", json_pack( "{s:s, s:s}", "version", "2.0", "generator", "reframe convert" ) );
        d->views = meshes + images > 0 ? root_array( d, "bufferViews" ) : NULL;
        add_materials( d );
        find_moves( d );
        add_nodes( d );
        add_cameras( d );
        add_lights( d );
        add_animations( d );
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
    free( d->skins );
    free( d->moves );
    *d = ( RfGlbDocument ){ 0 };
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
    RF_TRY( rf_check_model( model, error ) );
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
