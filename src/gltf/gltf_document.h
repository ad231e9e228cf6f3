// Internal to the glTF reader: the parsed document, and the functions that its parts share.
// Users of the library include gltf/gltf.h.
//
// Every value is validated when it is read. `where` names the object in messages, such as
// "accessors[3]".
#ifndef REFRAME_GLTF_GLTF_DOCUMENT_H
#define REFRAME_GLTF_GLTF_DOCUMENT_H

#include "base/json.h"
#include "gltf/gltf.h"
#include "scene/deformation.h"
#include "scene/movement.h"
#include "scene/textured.h"

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
    RF_GLTF_SKINS_LIST,
    RF_GLTF_TEXTURES_LIST,
    RF_GLTF_LIST_COUNT
} RfGltfList;

// A validated accessor: every element is inside its buffer.
typedef struct RfGltfAccessor
{
    bool open; // validated; the other fields are set
    bool normalized;
    uint32_t count;
    int components;      // 1 to 16
    int component_type;  // glTF's enumerant, 5120 (byte) to 5126 (float)
    const uint8_t* data; // NULL: zeros
    uint64_t stride;
    uint32_t sparse_count;
    int sparse_type;               // component type of the sparse indices
    const uint8_t* sparse_indices; // strictly increasing
    const uint8_t* sparse_values;
    int declared; // of a compressed mesh: its index in the file
} RfGltfAccessor;

// An attribute of a compressed mesh.
typedef struct RfGltfUnpackedAttribute
{
    int accessor; // its index in RfGltf.accessors; 0: not copied yet
    uint8_t* values;
} RfGltfUnpackedAttribute;

// What a compressed view holds, once it was needed.
typedef struct RfGltfUnpackedView
{
    uint8_t* bytes; // of meshoptimizer; NULL: not decoded yet
    uint64_t size;
    struct RfDracoMesh* mesh; // of Draco; NULL likewise
    RfGltfUnpackedAttribute* attributes;
    uint32_t* corners;
    RfGltfAccessor indices;
} RfGltfUnpackedView;

typedef struct RfGltfUnpacked
{
    uint64_t room; // bytes that may still be decoded
    RfGltfUnpackedView views[];
} RfGltfUnpacked;

typedef struct RfGltfBuffer
{
    const uint8_t* data; // NULL: what its views hold is compressed elsewhere
    uint64_t size;       // byteLength
    uint8_t* owned;      // freed with the document; NULL for the binary chunk of a .glb
} RfGltfBuffer;

// First and last key time that animate a node; start > end: static.
typedef struct RfGltfSpan
{
    double start, end;
} RfGltfSpan;

// How the mesh of a node is set apart from those that stand still (gltf_mover.c).
typedef enum RfGltfApart
{
    RF_GLTF_NOT_APART,
    RF_GLTF_APART,
    RF_GLTF_PART_APART, // its primitives with materials that change
} RfGltfApart;

// What a node of the document has; −1: nothing.
typedef struct RfGltfNode
{
    int mesh, skin, camera;
    int light_group; // as rf_gltf_read_light_group
    int use;         // of its mesh
    int here, next;  // the use that is among what stands still, and the next node of that
    RfGltfApart apart;
    int moving;      // its place among the moving nodes
    RfGltfSpan span; // of its own channels and its ancestors'
} RfGltfNode;

// A mesh as nodes of one light group have it.
typedef struct RfGltfUse
{
    int mesh, light_group;
    int first;     // of its nodes among what stands still, −1: none
    bool placed;   // where it can be, rather than baked
    int shapes[4]; // meshes of the scene that are made of it (gltf_mover.c), −1: none
} RfGltfUse;

#define RF_GLTF_NOTICES 32 // kinds of warnings

// A formatted name, for `where`.
typedef struct RfWhere
{
    char text[160];
} RfWhere;

typedef struct RfGltf
{
    const char* path;
    RfScene* scene; // the result
    RfLog* log;
    RfError* error;
    bool freeze;                  // as RfGltfOptions
    double frozen_at;             // seconds, once cameras are read
    const RfGltfOptions* options; // for what is read once

    uint8_t* file;
    size_t file_size;
    const uint8_t* bin; // binary chunk of a .glb, or NULL
    size_t bin_size;
    json_t* root;
    const json_t* lists[RF_GLTF_LIST_COUNT]; // NULL if empty
    int counts[RF_GLTF_LIST_COUNT];
    RfField *material_edits, *light_edits; // by number: what a scene file says; NULL: it says nothing of any
    RfField* films;                        // image sequences of a scene file: images after those of the document
    int film_count;
    int64_t variant;           // whose materials primitives have; −1: their own
    struct RfGltfSplit* split; // of materials by light groups; NULL: there is none
    RfGltfUse* uses;           // of the document's meshes, then one for each further light group of nodes that has one
    int use_count;
    size_t profile_values; // of all lights, which each read their own
    RfResult lost;         // why the last image that cannot be read cannot be
    bool plays;            // a texture of some material is an image sequence
    uint64_t degenerate;   // triangles without area that were dropped
    RfWhere first_degenerate;

    RfGltfBuffer* buffers;
    RfGltfAccessor* accessors; // of the file, then those of compressed meshes
    int accessor_count;
    RfGltfUnpacked* unpacked;
    RfGltfNode* nodes;
    int* order; // nodes of the default scene, parents first
    int order_count;
    int default_material; // index of the material for primitives without one, or −1

    // vertices of the current primitive, see gltf_primitive.c
    uint32_t* remap;
    uint32_t* remap_stamp;
    uint32_t remap_size;
    uint32_t stamp;

    uint64_t target_vertices; // of morph targets, so far
    uint64_t shape_triangles; // of meshes in their own space, so far

    // what changes by keys and is not of a node, see gltf_changes.c: sorted once all is read
    struct RfChange* changes;
    int change_count;
    bool* change_used; // by the scene
    struct RfMovingLamp* lamps;
    int lamp_count;
    struct RfMovingMaterial* moving_materials;
    int moving_material_count;

    const char* noticed[RF_GLTF_NOTICES];
    uint64_t noticed_extensions; // one bit per row of the table in gltf_document.c
} RfGltf;

// Sets the last row of a matrix to 0 0 0 1, which exporters write with rounding errors. False: it is another.
static inline bool rf_gltf_make_affine( double m[16] )
{
    const double most = 1e-5;
    if ( fabs( m[3] ) > most || fabs( m[7] ) > most || fabs( m[11] ) > most || fabs( m[15] - 1.0 ) > most )
        return false;
    m[3] = m[7] = m[11] = 0.0;
    m[15] = 1.0;
    return true;
}

// Formats a name.
RfWhere rf_where( const char* format, ... ) __attribute__( ( format( printf, 1, 2 ) ) );

// Fails with a message of file, object and cause; for RF_ERROR_FORMAT it appends what to do,
// other codes need it in their text.
RfResult rf_gltf_fail( const RfGltf* gltf, RfResult code, const char* where, const char* format, ... )
    __attribute__( ( format( printf, 4, 5 ) ) );

// Brighter radiance would overflow when floats are squared.
#define RF_GLTF_MAX_EMISSION 1e15

// Fails with RF_ERROR_UNSUPPORTED if |value| exceeds a limit of this reader: the file is valid
// glTF.
RfResult rf_gltf_check_limit( const RfGltf* gltf, const char* where, const char* key, double value, double limit );

// Makes room for one more in a list that grows only by this, whose address is given; false: there is no memory.
bool rf_gltf_grow( void* list, int count, size_t size );

// Allocates `count` items of zeros, and room for one more, for a list whose address is given. Fails with RF_ERROR_MEMORY.
RfResult rf_gltf_allocate( const RfGltf* gltf, const char* where, void* list, size_t count, size_t size );

// Fails with RF_ERROR_MEMORY.
RfResult rf_gltf_no_memory( const RfGltf* gltf, const char* where );

// Logs a warning, once for each format, for the first object concerned.
void rf_gltf_notice( RfGltf* gltf, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );

// What to do with a file that is compressed in a way that cannot be read.
#define RF_GLTF_UNPACK "unpack the file by `npx @gltf-transform/cli copy in.glb out.glb`"

// Fails, since the library that an extension needs was left out of this build.
RfResult rf_gltf_fail_left_out( const RfGltf* gltf, const char* where, const char* extension, const char* library );

// The steps of a reading, in their order (gltf.c).
RfResult rf_gltf_check_required( RfGltf* gltf ); // that all extensions which the file requires are read
RfResult rf_gltf_open_lists( RfGltf* gltf );     // the top-level lists
RfResult rf_gltf_choose_variant( RfGltf* gltf ); // of materials, of those that are listed
RfResult rf_gltf_load_buffers( RfGltf* gltf );
RfResult rf_gltf_load_nodes( RfGltf* gltf );
RfResult rf_gltf_load_animations( RfGltf* gltf );
RfResult rf_gltf_load_cameras( RfGltf* gltf );
RfResult rf_gltf_load_extras( RfGltf* gltf ); // of the default scene (gltf_shot.c), with its environment
RfResult rf_gltf_load_materials( RfGltf* gltf );
RfResult rf_gltf_split_light_groups( RfGltf* gltf ); // materials that meshes of tagged nodes emit by
RfResult rf_gltf_load_lights( RfGltf* gltf );        // of KHR_lights_punctual
RfResult rf_gltf_load_meshes( RfGltf* gltf );        // of all nodes of the default scene, baked or placed
RfResult rf_gltf_load_images( RfGltf* gltf );        // that materials of triangles use
RfResult rf_gltf_list_moving( RfGltf* gltf );        // names of all that moves; warns of what is frozen or does not move
RfResult rf_gltf_notice_unread( RfGltf* gltf );      // extensionsUsed, but for those that objects were warned of

// What they leave behind in the document.
void rf_gltf_free_unpacked( RfGltf* gltf );
void rf_gltf_free_buffers( RfGltf* gltf );
void rf_gltf_free_split( RfGltf* gltf );

// An object of a top-level list.
const json_t* rf_gltf_item( const RfGltf* gltf, RfGltfList list, int index );

// A value of the document as a field, whose errors are those of glTF: `path` is for messages.
RfField rf_gltf_field( const RfGltf* gltf, const char* path, const json_t* json );
RfField rf_gltf_root( const RfGltf* gltf );

// An object of a top-level list.
RfField rf_gltf_item_field( const RfGltf* gltf, RfGltfList list, int index );

// The primitives of a mesh, all of which are objects.
RfField rf_gltf_primitives( const RfGltf* gltf, int mesh );

// Fails if one of several members is missing; the list of their names ends with NULL.
RfResult rf_gltf_require( const RfField* object, ... ) __attribute__( ( sentinel ) );

// Reads an index into one of the lists; −1 if missing, or if it fails.
int rf_gltf_get_index( const RfGltf* gltf, const RfField* object, const char* key, RfGltfList list );

// An extension of an object; its json is NULL without one.
RfField rf_gltf_extension( const RfField* object, const char* name );

// What of an object has a member (RfChangedTraits.home): an extension, an object, or itself.
RfField rf_gltf_home( const RfField* object, const char* home );

// `extras.reframe` of an object, which is ours: its errors are not those of glTF. Extras of other programs may have any type.
RfField rf_gltf_extras( const RfField* object );

// Copies the name of the object, or `fallback` if it has none.
RfResult rf_gltf_copy_name( const RfField* object, const char* fallback, char** name );

// Is what an extension says read?
bool rf_gltf_reads( const char* extension );

// Fails for a texture without an image that is read, with what to do.
RfResult rf_gltf_refuse_texture( const RfGltf* gltf, const RfField* texture );

// Warns of unsupported extensions of an object, which messages call `kind` and `name`.
void rf_gltf_notice_extensions( RfGltf* gltf, const RfField* object, const char* kind, const char* name );

// True for a data: URI (gltf_buffer.c).
bool rf_is_data_uri( const char* uri );

// Reads the bytes that a URI names, a base64 data: URI or a file; the caller frees them.
RfResult rf_gltf_read_uri( const RfGltf* gltf, const char* where, const char* uri, uint64_t limit, uint8_t** bytes,
                           size_t* size );

// Converts a relative URI to a path beside the file; the caller frees it.
RfResult rf_gltf_resolve_uri( const RfGltf* gltf, const char* where, const char* uri, char** path );

// Fails since no item of the list, such as a "material" of "materials", has the name; says which there are.
#define RF_ITEM_NAME 32 // of one without a name
RfResult rf_fail_unknown_item( const RfField* field, const char* kind, const char* name, const json_t* list );

// The material of a primitive, in that variant; −1: none.
RfResult rf_gltf_material_of( const RfGltf* gltf, const RfField* primitive, int* material );

// All of a view, which may have so many.
RfResult rf_gltf_whole_view( const RfGltf* gltf, const char* where, int view, uint64_t most, const uint8_t** bytes,
                             size_t* size );

// The bytes that `buffer`, `byteOffset` and `byteLength` of an object name.
RfResult rf_gltf_read_range( const RfGltf* gltf, const RfField* object, const uint8_t** bytes, uint64_t* length );

// Counts bytes that are decoded; fails where a file of its size must not hold so many.
RfResult rf_gltf_take_room( const RfGltf* gltf, const char* where, uint64_t bytes );

// Whether the build has libmeshoptimizer (gltf_document.c).
bool rf_gltf_has_meshopt( void );

// Decodes a view; `out` is NULL where it is not compressed.
RfResult rf_gltf_unpack_view( const RfGltf* gltf, int view, const RfGltfUnpackedView** out );

// The accessor of an attribute of a primitive, −1 if it has none (gltf_draco.c); `where` names its attributes. Of a compressed
// primitive it is one after those of the file, and open.
RfResult rf_gltf_find_attribute( RfGltf* gltf, const RfField* primitive, const char* name, int* index );

// The indices of a compressed primitive, a list of triangles; NULL where it is not compressed.
RfResult rf_gltf_packed_indices( RfGltf* gltf, const RfField* primitive, const RfGltfAccessor** indices );

// The most accessors of compressed meshes that there may be.
size_t rf_gltf_count_packed( const RfGltf* gltf );

// Bytes of a component type, 0 if it does not exist (gltf_accessor.c).
int rf_gltf_component_size( int component_type );

// Reads count, type and component type of an accessor.
RfResult rf_gltf_read_layout( const RfGltf* gltf, const RfField* object, bool matrix, RfGltfAccessor* out );

// Finds a validated accessor of that many components, with 16 a 4×4 matrix of floats; 0: of any. `user` names the attribute.
RfResult rf_gltf_open_accessor( RfGltf* gltf, int index, const char* user, int components, const RfGltfAccessor** accessor );

// Fails unless the accessor has `components` components; `user` names the attribute.
RfResult rf_gltf_expect( const RfGltf* gltf, int index, const RfGltfAccessor* accessor, const char* user, int components );

// Reads an element as floats, normalised if the accessor is; they must be finite.
RfResult rf_gltf_read_floats( const RfGltf* gltf, int index, uint32_t element, float* values );

// Reads an element as an index.
uint32_t rf_gltf_read_index( const RfGltfAccessor* accessor, uint32_t element );

// The light group in the extras of a light, node or material (gltf_light_group.c): its tag (rf_tag_light), 0 for "rest"; −1: none.
RfResult rf_gltf_read_light_group( const RfGltf* gltf, const RfField* object, int* tag );

// The same of an object that may have the member "light_group" itself.
RfResult rf_gltf_read_tag( const RfGltf* gltf, const RfField* ours, int* tag );

// What a material is in the use of a mesh.
uint32_t rf_gltf_tagged_material( const RfGltf* gltf, int use, uint32_t material );

// Reads item `at` of a list of nodes that is called `key` (gltf_node.c).
RfResult rf_gltf_read_node_index( const RfGltf* gltf, const json_t* list, size_t at, const char* where, const char* key,
                                  int* node );

// The number of morph targets of a node's mesh; fails if it has none (gltf_bake.c).
RfResult rf_gltf_count_targets( const RfGltf* gltf, int node, const char* where, int* count );

// Adds to what changes in the file and cannot be rendered so; the same is listed once.
RfResult rf_gltf_note_unrendered( RfGltf* gltf, const char* what, const char* format, ... )
    __attribute__( ( format( printf, 3, 4 ) ) );

// The node that a channel from outside the file is of.
static inline int rf_gltf_given_node( const RfGltf* gltf, const RfChannel* channel )
{
    return channel->node >= 0 ? channel->node : gltf->counts[RF_GLTF_NODES];
}

// Does a node move?
static inline bool rf_gltf_moves( const RfGltf* gltf, int node )
{
    return gltf->nodes[node].span.start <= gltf->nodes[node].span.end;
}

// Do some of its properties differ over time, or those of an ancestor (gltf_shot.c)?
bool rf_gltf_has_varying( const RfGltf* gltf, int node, RfAnimatedPath first, RfAnimatedPath last );

// Do its transforms?
static inline bool rf_gltf_varies( const RfGltf* gltf, int node )
{
    return rf_gltf_moves( gltf, node ) && rf_gltf_has_varying( gltf, node, RF_TRANSLATION, RF_SCALE );
}

// Does it move, or is it shown and hidden, as the file has it?
static inline bool rf_gltf_changes( const RfGltf* gltf, int node )
{
    return rf_gltf_varies( gltf, node ) || rf_gltf_has_varying( gltf, node, RF_VISIBILITY, RF_VISIBILITY );
}

// At which time a node that does not move here is placed.
static inline double rf_gltf_rest_time( const RfGltf* gltf, int node )
{
    return gltf->freeze ? gltf->frozen_at : rf_gltf_moves( gltf, node ) ? gltf->nodes[node].span.start : 0.0;
}

// Adds the name of something that moves in the file.
RfResult rf_gltf_note_moving( RfGltf* gltf, const char* name );

// Whether materials change at all, and that of a primitive, unread (gltf_changes.c).
static inline bool rf_gltf_has_changing( const RfGltf* gltf ) { return gltf->moving_material_count > 0 || gltf->plays; }
bool rf_gltf_primitive_changes( const RfGltf* gltf, const RfField* primitive );

// Whether a node and its ancestors are shown (gltf_mover.c).
typedef enum RfGltfVisibility
{
    RF_GLTF_HIDDEN,
    RF_GLTF_SHOWN,
    RF_GLTF_SHOWN_AT_TIMES,
} RfGltfVisibility;

RfGltfVisibility rf_gltf_visibility( const RfGltf* gltf, int node );

// `extras.reframe` of the default scene of a document, which need not be valid.
const json_t* rf_gltf_document_extras( const json_t* root );

// The frames per second that a document asks for, 24 if it does not or is not valid.
RfFps rf_gltf_document_fps( const json_t* root );

// ---- From the meshes of a document to the triangles of the scene

// The triangles of a primitive in object space, with only the vertices that they use
// (gltf_primitive.c).
typedef struct RfGltfPrimitive
{
    RfTriangles t;     // count 0: nothing to draw
    uint32_t* sources; // per vertex: its number in the accessors
    bool flat;         // the normals are those of the triangles, which share no vertices
    uint32_t material;
} RfGltfPrimitive;

// Reads a primitive; to survey it, the number of its triangles and its material alone.
RfResult rf_gltf_read_primitive( RfGltf* gltf, const RfField* primitive, bool survey, RfGltfPrimitive* out );

// Frees a primitive.
void rf_gltf_free_primitive( RfGltfPrimitive* primitive );

// Of all that is baked.
#define RF_GLTF_MAX_TRIANGLES ( 1u << 28 )

// Bakes primitives into a list of triangles (gltf_bake.c).
typedef struct RfGltfBaker
{
    RfTriangles* triangles;
    RfVec3 bounds_min, bounds_max; // of the triangles; both 0 if there are none
    double least_double_area;      // twice the smallest triangle area that is kept
    uint32_t vertex_capacity, triangle_capacity;
    bool deforms;    // triangles without area stay
    uint32_t placed; // triangles so far, including dropped ones
    uint64_t degenerate;
    RfWhere first_degenerate;
} RfGltfBaker;

// Appends a primitive, transformed by a matrix; NULL: in its own space.
RfResult rf_gltf_bake( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                       const char* where );

// Frees spare memory of the triangles.
void rf_gltf_finish_baker( RfGltfBaker* baker );

// Says how many triangles were dropped, if any.
void rf_gltf_warn_of_degenerate( const RfGltf* gltf, RfLog* log, uint64_t count, const RfWhere* first );

// The instances of a node's mesh and their transforms within the node; a single one without
// the extension (gltf_node.c).
typedef struct RfGltfInstances
{
    uint32_t count;
    int translation, rotation, scale; // accessors, or −1
} RfGltfInstances;

// Reads the instances of a node.
RfResult rf_gltf_open_instances( RfGltf* gltf, int node, RfGltfInstances* out );

// The transform of one instance within its node.
RfResult rf_gltf_instance_matrix( const RfGltf* gltf, const RfGltfInstances* instances, uint32_t element, RfMat4* matrix );

// The number of morph targets of all primitives of a mesh (gltf_bake.c).
RfResult rf_gltf_mesh_targets( const RfGltf* gltf, int mesh, int* count );

// The weights of a node's mesh where nothing animates them.
RfResult rf_gltf_read_rest_weights( const RfGltf* gltf, int node, int mesh, int count, double* weights );

// Reads the skins, with nodes of the scene for joints (gltf_bake.c).
RfResult rf_gltf_load_skins( RfGltf* gltf, RfMovement* movement );

// A mesh in its own space, of all primitives, or of those with materials that change. `deforms`: with its morph targets and all triangles; `skinned`: with its
// joints as well; else without the triangles that have no area (gltf_bake.c).
typedef struct RfGltfShape
{
    int use; // of a mesh
    bool deforms, skinned, changing_only;
} RfGltfShape;

RfResult rf_gltf_read_shape( RfGltf* gltf, const RfGltfShape* shape, RfMesh* out );

// Takes the mesh of a node out of those that stand still, where it moves, deforms or is hidden. Where only
// some of its materials change, its primitives with these are to be left out (gltf_mover.c).
RfResult rf_gltf_set_apart( RfGltf* gltf, int node );

// Places what was set apart, after everything else.
RfResult rf_gltf_place_movers( RfGltf* gltf );

// ---- From materials, textures and images to those of the scene, and what changes by keys and is not of a node

// Reads a value of glTF into the struct of its owner's values, and checks its range (gltf_changes.c); one that is missing is left as
// it is. `home`: the object that has it.
RfResult rf_gltf_read_value( const RfGltf* gltf, const RfField* home, RfChangedValue value, void* values );

// Reads all values of an owner.
RfResult rf_gltf_read_values( const RfGltf* gltf, const RfField* owner, RfValueOwner kind, void* values );

// That all keys of a change are values that the file may have (gltf_changes.c).
RfResult rf_gltf_check_change( const RfGltf* gltf, const char* where, const RfChange* change );

// Reads the keys that a scene file gives a material, and adds them.
RfResult rf_gltf_read_keys( RfGltf* gltf, int material );

// Adds a change, whose channel it takes unless it fails.
RfResult rf_gltf_add_change( RfGltf* gltf, const RfChange* change );

// Sorts them by what they are of, and finds their span.
RfResult rf_gltf_sort_changes( RfGltf* gltf );

void rf_gltf_free_changes( RfGltf* gltf );

// The change of a value, or −1 where it stands still or is frozen: `still` is then what it is, unless nothing is said of it.
int rf_gltf_find_change( const RfGltf* gltf, RfChangedValue value, int of, int slot, double* still );

// The changes of all values of an owner, by value: `still` becomes what they are where they stand still, `most` (of the same type)
// the most that they are at any time.
void rf_gltf_find_changes( const RfGltf* gltf, RfValueOwner owner, int of, void* still, void* most, int* changes );

// Says in the list of what is frozen that something changes, where it is frozen.
RfResult rf_gltf_note_frozen( RfGltf* gltf, const char* kind, const char* name );

// Adds to the materials that change.
RfResult rf_gltf_add_moving_material( RfGltf* gltf, const RfMovingMaterial* moving );

// Whether the document changes a light by keys.
bool rf_gltf_light_changes( const RfGltf* gltf, int index );

// Notes a punctual light that moves, is switched or changes. Its node is one of the scene, its changes are numbers of
// rf_gltf_find_change.
RfResult rf_gltf_add_lamp( RfGltf* gltf, const RfMovingLamp* lamp );

// Notes a material that dims or changes, in which its factors are as in the file, and prepares it for that: `out` is as it
// stands still, but for the transforms of textures, which are followed here.
RfResult rf_gltf_change_material( RfGltf* gltf, RfMovingMaterial* moving, RfMaterial* out );

// Moves what has been noted, and is of what is in the scene, to a movement. The nodes of lamps are moving ones by now.
RfResult rf_gltf_move_changes( RfGltf* gltf, RfMovement* movement );

// A use of a texture by its path within a material: its slot, −1 where it is ignored. False: there is no such use
// (gltf_texture.c).
bool rf_gltf_texture_slot( const char* path, size_t length, int* slot );

// The index of the material for primitives without one, created on first use.
RfResult rf_gltf_use_default_material( RfGltf* gltf, uint32_t* index );

// A scattering model of extras.reframe.
typedef struct RfGltfModel RfGltfModel;

// What is said of a material.
typedef struct RfGltfMaterial
{
    int index;
    RfField json;             // by the document
    RfField own;              // by its extras.reframe
    RfField edit;             // by a scene file, which goes first
    RfField glossiness;       // by KHR_materials_pbrSpecularGlossiness, in the place of the metallic-roughness model
    const RfGltfModel* model; // NULL: glTF's
    bool chosen;              // by the scene file
    bool textures;            // it has those of the document
    bool unlit;
} RfGltfMaterial;

// Has it a texture there?
bool rf_gltf_has_texture( const RfGltfMaterial* material, RfTextureSlot slot );

// Sets the `textured` member of a material, and the transforms of its textures, after all its other properties have been read
// (gltf_texture.c). rf_gltf_load_images removes it again if it is not needed.
RfResult rf_gltf_read_textured( RfGltf* gltf, const RfGltfMaterial* material, RfMovingMaterial* moving, RfMaterial* out );

// A struct without textures; NULL if out of memory.
RfTextured* rf_gltf_textured( const RfFactors* factors );

#endif
