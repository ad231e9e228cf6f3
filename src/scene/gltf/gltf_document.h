// Inside of the glTF reader: the parsed document, and the calls its parts
// share. Not for users of the library: they have scene/gltf.h.
//
// Every part checks what it reads at the moment it reads it. `where` names the
// object in error lines, such as "accessors[3]".
#ifndef REFRAME_SCENE_GLTF_GLTF_DOCUMENT_H
#define REFRAME_SCENE_GLTF_GLTF_DOCUMENT_H

#include "scene/textured.h"

#include <jansson.h>
#include <stddef.h>

// The top-level arrays of a document.
typedef enum RfGltfList
{
    RF_GLTF_ACCESSORS,
    RF_GLTF_ANIMATIONS,
    RF_GLTF_BUFFERS,
    RF_GLTF_BUFFER_VIEWS,
    RF_GLTF_CAMERAS,
    RF_GLTF_IMAGES,
    RF_GLTF_MATERIALS,
    RF_GLTF_MESHES,
    RF_GLTF_NODES,
    RF_GLTF_SAMPLERS,
    RF_GLTF_SCENES,
    RF_GLTF_TEXTURES_LIST,
    RF_GLTF_LIST_COUNT
} RfGltfList;

// What is said once, with the first object that asks for it. (Extensions that
// are not read keep their own marks.)
typedef enum RfGltfNotice
{
    RF_GLTF_COATED_GLASS,
    RF_GLTF_POINTS_LINES,
    RF_GLTF_NO_POSITIONS,
    RF_GLTF_MORPH_TARGETS,
    RF_GLTF_SKINS,
    RF_GLTF_ORTHOGRAPHIC,
    RF_GLTF_MOVING_MESH,
    RF_GLTF_MOVING_LIGHT,
    RF_GLTF_WEIGHT_CHANNELS,
    RF_GLTF_POINTER_CHANNELS,
    RF_GLTF_DOUBLE_CHANNELS,
    RF_GLTF_NOTICE_COUNT
} RfGltfNotice;

// A checked accessor: every element lies inside its buffer.
typedef struct RfGltfAccessor
{
    bool open; // the rest is filled in
    bool normalized;
    uint32_t count;
    int components;      // 1 to 16
    int component_type;  // glTF's number, 5120 (byte) to 5126 (float)
    const uint8_t* data; // NULL: zeros
    uint64_t stride;
    uint32_t sparse_count;
    int sparse_type;               // component type of the sparse indices
    const uint8_t* sparse_indices; // strictly increasing
    const uint8_t* sparse_values;
} RfGltfAccessor;

typedef struct RfGltfBuffer
{
    const uint8_t* data;
    uint64_t size;  // byteLength
    uint8_t* owned; // freed with the document; NULL for the chunk of a .glb
} RfGltfBuffer;

// First and last key time that move a node; start > end: it stands still.
typedef struct RfGltfSpan
{
    double start, end;
} RfGltfSpan;

typedef struct RfGltf
{
    const char* path;
    RfScene* scene; // what is being filled
    RfLog* log;
    RfError* error;

    uint8_t* file;
    size_t file_size;
    const uint8_t* bin; // chunk of a .glb, or NULL
    size_t bin_size;
    json_t* root;
    const json_t* lists[RF_GLTF_LIST_COUNT]; // NULL where empty
    int counts[RF_GLTF_LIST_COUNT];

    RfGltfBuffer* buffers;
    RfGltfAccessor* accessors;
    RfGltfSpan* spans; // by node; own channels and those of ancestors
    int* order;        // nodes of the default scene, parents first
    int order_count;
    int default_material; // index of the one for primitives without, or −1

    // vertices of the primitive being read, see gltf_primitive.c
    uint32_t* remap;
    uint32_t* remap_stamp;
    uint32_t remap_size;
    uint32_t stamp;

    bool noticed[RF_GLTF_NOTICE_COUNT];
    uint32_t noticed_extensions; // a bit by row of the table in gltf_extension.c
} RfGltf;

// A name made by printf, for `where`.
typedef struct RfWhere
{
    char text[160];
} RfWhere;

RfWhere rf_where( const char* format, ... ) __attribute__( ( format( printf, 1, 2 ) ) );

// One error line: file, object, what is wrong; RF_ERROR_FORMAT says what to do
// by itself, the others in their text.
RfResult rf_gltf_fail( const RfGltf* gltf, RfResult code, const char* where, const char* format, ... )
    __attribute__( ( format( printf, 4, 5 ) ) );
// Radiance above this would overflow where floats are squared.
#define RF_GLTF_MAX_EMISSION 1e15

// Fails (RF_ERROR_UNSUPPORTED) where |value| is above a limit of ours that glTF
// does not set: such a file is valid, only beyond what we read.
RfResult rf_gltf_check_limit( const RfGltf* gltf, const char* where, const char* key, double value, double limit );
RfResult rf_gltf_no_memory( const RfGltf* gltf, const char* where );

// A warning line, said for the first object of a kind only.
void rf_gltf_notice( RfGltf* gltf, RfGltfNotice notice, const char* format, ... ) __attribute__( ( format( printf, 3, 4 ) ) );

// gltf_document.c: members of JSON objects by type. An absent member leaves
// the value as the caller set it; a member of another type is an error.
RfResult rf_gltf_open_lists( RfGltf* gltf );
const json_t* rf_gltf_item( const RfGltf* gltf, RfGltfList list, int index );
RfResult rf_gltf_require( const RfGltf* gltf, const json_t* object, const char* where, const char* key );
RfResult rf_gltf_get_number( const RfGltf* gltf, const json_t* object, const char* where, const char* key, double* value );
RfResult rf_gltf_get_numbers( const RfGltf* gltf, const json_t* object, const char* where, const char* key, int count,
                              double* values );
RfResult rf_gltf_get_integer( const RfGltf* gltf, const json_t* object, const char* where, const char* key, int64_t low,
                              int64_t high, int64_t* value );
RfResult rf_gltf_get_bool( const RfGltf* gltf, const json_t* object, const char* where, const char* key, bool* value );
RfResult rf_gltf_get_string( const RfGltf* gltf, const json_t* object, const char* where, const char* key, const char** value );
RfResult rf_gltf_get_object( const RfGltf* gltf, const json_t* object, const char* where, const char* key, const json_t** value );
RfResult rf_gltf_get_array( const RfGltf* gltf, const json_t* object, const char* where, const char* key, const json_t** value );
// An index into one of the lists; an absent one gives −1.
RfResult rf_gltf_get_index( const RfGltf* gltf, const json_t* object, const char* where, const char* key, RfGltfList list,
                            int* index );
// One extension of an object, or NULL.
RfResult rf_gltf_get_extension( const RfGltf* gltf, const json_t* object, const char* where, const char* name,
                                const json_t** extension );
// A copy of the object's name, or of `fallback` where it has none.
RfResult rf_gltf_copy_name( const RfGltf* gltf, const json_t* object, const char* where, const char* fallback, char** name );

// gltf_extension.c
RfResult rf_gltf_check_required( const RfGltf* gltf );
void rf_gltf_notice_extensions( RfGltf* gltf, const json_t* object, const char* kind, const char* name );
RfResult rf_gltf_notice_unread( RfGltf* gltf );

// gltf_uri.c
bool rf_is_data_uri( const char* uri );
RfResult rf_gltf_decode_data_uri( const RfGltf* gltf, const char* where, const char* uri, uint8_t** bytes, size_t* size );
RfResult rf_gltf_resolve_uri( const RfGltf* gltf, const char* where, const char* uri, char** path );

// gltf_environment.c
RfResult rf_gltf_load_environment( RfGltf* gltf );

// gltf.c. A change to the parsed text before anything of it is read, which need
// not be valid glTF then. What it makes of it is read, and checked, as if the
// file had it.
typedef struct RfGltfEdit
{
    RfResult ( *run )( void* user, json_t* root, RfError* error );
    void* user;
} RfGltfEdit;
RfResult rf_load_edited_gltf( const char* path, const RfGltfEdit* edit, RfScene* scene, RfLog* log, RfError* error );

// gltf_buffer.c
RfResult rf_gltf_load_buffers( RfGltf* gltf );
void rf_gltf_free_buffers( RfGltf* gltf );
// Bytes of a view that has `need` of them from `offset` on.
RfResult rf_gltf_view_bytes( const RfGltf* gltf, const char* where, int view, uint64_t offset, uint64_t need,
                             const uint8_t** bytes );
RfResult rf_gltf_view_stride( const RfGltf* gltf, int view, uint64_t element, uint64_t* stride );

// gltf_accessor.c, gltf_element.c
RfResult rf_gltf_open_accessor( RfGltf* gltf, int index, const RfGltfAccessor** accessor );
// Fails where the accessor is not of `components`; `user` names who asks.
RfResult rf_gltf_expect( const RfGltf* gltf, int index, const RfGltfAccessor* accessor, const char* user, int components );
int rf_gltf_component_size( int component_type );
uint32_t rf_gltf_read_u32( const uint8_t* at, int component_type );
RfResult rf_gltf_read_floats( const RfGltf* gltf, int index, uint32_t element, float* values );
uint32_t rf_gltf_read_index( const RfGltfAccessor* accessor, uint32_t element );

// gltf_material.c, gltf_lobe.c
RfResult rf_gltf_load_materials( RfGltf* gltf );
RfResult rf_gltf_use_default_material( RfGltf* gltf, uint32_t* index );
RfResult rf_gltf_read_lobes( const RfGltf* gltf, const json_t* material, const char* where, RfMaterial* out );

// gltf_texture.c: one use of a texture, `key` of `parent`; `info` is NULL where
// there is none. Until rf_gltf_load_images `texture` is 2 · image + srgb.
RfResult rf_gltf_read_texture_info( RfGltf* gltf, const json_t* parent, const char* owner, const char* key, bool srgb,
                                    RfTextureRef* out, const json_t** info );

// gltf_textured.c: gives the material its `textured`, after everything else of
// it has been read. rf_gltf_load_images removes it again where it is not needed.
RfResult rf_gltf_read_textured( RfGltf* gltf, const json_t* json, const char* where, const RfFactors* factors, RfMaterial* out );
// One without textures, or NULL where there is no memory.
RfTextured* rf_gltf_textured( const RfFactors* factors );

// gltf_image.c: decodes what the materials of triangles need; after the meshes.
RfResult rf_gltf_load_images( RfGltf* gltf );

// gltf_node.c, gltf_animation.c, gltf_camera.c
RfResult rf_gltf_load_nodes( RfGltf* gltf );
RfResult rf_gltf_load_animations( RfGltf* gltf );
RfResult rf_gltf_load_cameras( RfGltf* gltf );

// gltf_light.c: the lights of KHR_lights_punctual
RfResult rf_gltf_load_lights( RfGltf* gltf );

// gltf_glass.c: KHR_materials_transmission, _volume and _unlit, and metals
// without roughness; after the other factors have been applied
RfResult rf_gltf_read_glass( const RfGltf* gltf, const json_t* material, const char* where, const RfFactors* factors,
                             RfMaterial* out );
// gltf_clearcoat.c; last of the extensions
RfResult rf_gltf_read_clearcoat( RfGltf* gltf, const json_t* material, const char* where, RfMaterial* out );
bool rf_gltf_is_unlit( const json_t* material );
static inline bool rf_gltf_moves( const RfGltf* gltf, int node ) { return gltf->spans[node].start <= gltf->spans[node].end; }

// gltf_primitive.c, gltf_triangles.c: triangles of one primitive in the space of its mesh, only
// the vertices that they use.
typedef struct RfGltfPrimitive
{
    uint32_t vertex_count;
    uint32_t triangle_count; // 0: nothing to draw
    float* positions;
    float* normals; // NULL: flat
    float* uvs;     // or NULL, as the following
    float* uvs1;
    float* colors;   // 4 numbers each, in [0, 1]
    float* tangents; // 4 numbers each
    uint32_t* indices;
    uint32_t material;
} RfGltfPrimitive;

RfResult rf_gltf_read_primitive( RfGltf* gltf, const json_t* primitive, const char* where, RfGltfPrimitive* out );
void rf_gltf_free_primitive( RfGltfPrimitive* primitive );
// Rows of three vertex numbers from indices or none, by mode.
RfResult rf_gltf_read_triangles( RfGltf* gltf, const json_t* primitive, const char* where, int mode, uint32_t vertex_count,
                                 uint32_t** indices, uint32_t* triangle_count );

// gltf_flat.c: a primitive's normals become those of its faces.
RfResult rf_gltf_make_flat( const RfGltf* gltf, const char* where, RfGltfPrimitive* primitive );

// gltf_tangents.c: gives a primitive, which has normals and that texture's
// coordinates, the tangents that a texture of normals needs. Vertices whose
// triangles lie on the image in both ways become two.
RfResult rf_gltf_make_tangents( const RfGltf* gltf, const char* where, const RfTextureRef* ref, RfGltfPrimitive* primitive );

// gltf_bake.c: primitives into the scene's soup.
typedef struct RfGltfBaker
{
    uint32_t vertex_capacity, triangle_capacity;
    float* world; // positions of the primitive being placed
    uint32_t world_capacity;
    uint32_t placed; // triangles so far, with those that were dropped
    uint64_t degenerate;
    RfWhere first_degenerate;
} RfGltfBaker;

RfResult rf_gltf_bake( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                       const char* where );
void rf_gltf_finish_bake( RfGltf* gltf, RfGltfBaker* baker );

// gltf_attributes.c: coordinates of textures, colours and tangents of vertices.
RfResult rf_gltf_reserve_attributes( const RfGltf* gltf, const RfGltfBaker* baker, const RfGltfPrimitive* primitive,
                                     const char* where );
void rf_gltf_copy_attributes( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from );
// `sign`: −1 for a matrix that mirrors.
void rf_gltf_place_tangent( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from, const RfMat4* matrix,
                            double sign );

// gltf_instancing.c: how often a node places its mesh, once without the
// extension, and where within the node.
typedef struct RfGltfInstances
{
    uint32_t count;
    int translation, rotation, scale; // accessors, or −1
} RfGltfInstances;

RfResult rf_gltf_open_instances( RfGltf* gltf, int node, RfGltfInstances* instances );
RfResult rf_gltf_instance_matrix( const RfGltf* gltf, const RfGltfInstances* instances, uint32_t element, RfMat4* matrix );

// gltf_mesh.c: places every mesh that a node of the default scene has.
RfResult rf_gltf_load_meshes( RfGltf* gltf );

#endif
