// Bakes primitives into lists of triangles; what deforms them: morph targets, with their weights where nothing animates them, and skins.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// Vertices of all targets, 4 GiB of deltas: targets may share accessors, so a small file could request any amount.
#define MAX_TARGET_VERTICES ( (uint64_t)1 << 28 )

#define NO_ACCESSOR ( -1 )

RfResult rf_gltf_mesh_targets( const RfGltf* gltf, int mesh, int* count )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_MESHES, mesh ), primitives = rf_get_array( &json, "primitives" );
    size_t all = 0;
    *count = 0;
    for ( size_t i = 0; i < json_array_size( primitives.json ); ++i )
    {
        RfField self = rf_field_item( &primitives, i );
        size_t own = json_array_size( rf_get_array( &self, "targets" ).json );
        if ( i > 0 && own != all )
            return rf_field_fail( &self, "has %zu targets, the primitives before it have %zu", own, all );
        all = own;
    }
    *count = (int)all;
    return rf_json_result( &json );
}

RfResult rf_gltf_count_targets( const RfGltf* gltf, int node, const char* where, int* count )
{
    int mesh = gltf->nodes[node].mesh;
    *count = 0;
    RfResult result = mesh >= 0 ? rf_gltf_mesh_targets( gltf, mesh, count ) : RF_OK;
    if ( result == RF_OK && *count == 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "animates the weights of nodes[%d], which has no morph targets",
                             node );
    return result;
}

RfResult rf_gltf_read_rest_weights( const RfGltf* gltf, int node, int mesh, int count, double* weights )
{
    RfField of_node = rf_gltf_item_field( gltf, RF_GLTF_NODES, node ), of_mesh = rf_gltf_item_field( gltf, RF_GLTF_MESHES, mesh );
    bool own = rf_has_member( &of_node, "weights" );
    for ( int i = 0; i < count; ++i )
        weights[i] = 0.0;
    return rf_get_numbers( own ? &of_node : &of_mesh, "weights", rf_any_number(), count, weights );
}

// Appends `more` triples to those of `before` vertices; NULL: zeros. An attribute that no primitive has stays NULL.
static bool append( float** all, size_t before, size_t more, const float* values )
{
    if ( *all == NULL && values == NULL )
        return true;
    bool fresh = *all == NULL;
    if ( !rf_make_room( all, 3 * ( before + more ), sizeof **all ) )
        return false;
    for ( size_t i = fresh ? 0 : 3 * before; i < 3 * ( before + more ); ++i )
        ( *all )[i] = i >= 3 * before && values != NULL ? values[i - 3 * before] : 0.0f;
    return true;
}

// The deltas of one target in one primitive: accessors, and the values of the vertices that they change.
typedef struct Deltas
{
    int accessor[3]; // POSITION, NORMAL, TANGENT
    uint32_t count;
    uint32_t* vertices;
    float* values[3];
} Deltas;

static void free_deltas( Deltas* deltas )
{
    free( deltas->vertices );
    for ( int k = 0; k < 3; ++k )
        free( deltas->values[k] );
}

static RfResult open_delta( RfGltf* gltf, const RfField* target, const char* name, uint32_t count, int* index )
{
    *index = rf_gltf_get_index( gltf, target, name, RF_GLTF_ACCESSORS );
    if ( *index < 0 )
        return rf_json_result( target );
    const RfGltfAccessor* accessor;
    RfResult result = rf_gltf_open_accessor( gltf, *index, target->path, 3, &accessor );
    if ( result == RF_OK && accessor->count != count )
        return rf_field_fail( target, "%s has %u elements, the primitive has %u", name, accessor->count, count );
    if ( result == RF_OK && accessor->data == NULL && accessor->sparse_count == 0 )
        *index = NO_ACCESSOR; // zeros
    return result;
}

// Colours and texture coordinates may change as well; what begins with _ is of applications.
static void notice_left_out( RfGltf* gltf, const RfField* target )
{
    const char* name;
    const json_t* value;
    json_object_foreach( (json_t*)target->json, name, value )
    {
        bool read = strcmp( name, "POSITION" ) == 0 || strcmp( name, "NORMAL" ) == 0 || strcmp( name, "TANGENT" ) == 0;
        if ( !read && name[0] != '_' )
            rf_gltf_notice( gltf, "%s changes %.40s, which stays as it is", target->path, name );
    }
}

static RfResult open_target( RfGltf* gltf, const RfField* target, const RfField* owner, const RfGltfPrimitive* primitive,
                             int accessors[3] )
{
    static const char* const s_names[] = { "POSITION", "NORMAL", "TANGENT" };
    const json_t* attributes = json_object_get( owner->json, "attributes" );
    int base = NO_ACCESSOR;
    if ( !json_is_object( target->json ) )
        return rf_field_fail( target, "must be an object" );
    notice_left_out( gltf, target );
    RfResult result = rf_gltf_find_attribute( gltf, owner, "POSITION", &base );
    for ( int k = 0; result == RF_OK && k < 3; ++k )
        result = open_delta( gltf, target, s_names[k], gltf->accessors[base].count, accessors + k );
    // normals of triangles follow them; tangents that are made here belong to the shape at rest
    if ( primitive->flat || json_object_get( attributes, "NORMAL" ) == NULL )
        accessors[1] = NO_ACCESSOR;
    if ( primitive->t.tangents == NULL || json_object_get( attributes, "TANGENT" ) == NULL )
        accessors[2] = NO_ACCESSOR;
    return result;
}

static RfResult collect( const RfGltf* gltf, const char* where, const RfGltfPrimitive* primitive, uint32_t base, Deltas* deltas )
{
    size_t room = (size_t)primitive->t.vertex_count + 1;
    deltas->vertices = malloc( room * sizeof *deltas->vertices );
    bool fits = deltas->vertices != NULL;
    for ( int k = 0; k < 3; ++k )
    {
        if ( deltas->accessor[k] >= 0 )
            deltas->values[k] = malloc( room * 3 * sizeof *deltas->values[k] );
        fits = fits && ( deltas->accessor[k] < 0 || deltas->values[k] != NULL );
    }
    if ( !fits )
        return rf_gltf_no_memory( gltf, where );
    for ( uint32_t v = 0; v < primitive->t.vertex_count; ++v )
    {
        bool changed = false;
        for ( int k = 0; k < 3; ++k )
        {
            if ( deltas->accessor[k] < 0 )
                continue;
            float* value = deltas->values[k] + 3 * (size_t)deltas->count;
            RF_TRY( rf_gltf_read_floats( gltf, deltas->accessor[k], primitive->sources[v], value ) );
            changed = changed || value[0] != 0.0f || value[1] != 0.0f || value[2] != 0.0f;
        }
        if ( changed )
            deltas->vertices[deltas->count++] = base + v;
    }
    return RF_OK;
}

static RfResult add_target( RfGltf* gltf, const char* where, const RfGltfPrimitive* primitive, uint32_t base, Deltas* deltas,
                            RfMorphTarget* target )
{
    if ( deltas->accessor[0] < 0 && deltas->accessor[1] < 0 && deltas->accessor[2] < 0 )
        return RF_OK;
    gltf->target_vertices += primitive->t.vertex_count;
    if ( gltf->target_vertices > MAX_TARGET_VERTICES )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %llu vertices in all morph targets: split the scene",
                             (unsigned long long)MAX_TARGET_VERTICES );
    RfResult result = collect( gltf, where, primitive, base, deltas );
    if ( result != RF_OK || deltas->count == 0 )
        return result;
    size_t before = target->count, more = deltas->count;
    if ( !rf_make_room( &target->vertices, before + more, sizeof *target->vertices ) ||
         !append( &target->positions, before, more, deltas->values[0] ) ||
         !append( &target->normals, before, more, deltas->values[1] ) ||
         !append( &target->tangents, before, more, deltas->values[2] ) )
        return rf_gltf_no_memory( gltf, where );
    memcpy( target->vertices + before, deltas->vertices, more * sizeof *target->vertices );
    target->count += deltas->count;
    return RF_OK;
}

// Adds the targets of a primitive whose vertices begin at `base` of the mesh.
static RfResult read_targets( RfGltf* gltf, const RfField* json, const RfGltfPrimitive* primitive, uint32_t base,
                              RfDeformation* deformation )
{
    RfField targets = rf_get_array( json, "targets" );
    RfResult result = rf_json_result( json );
    for ( int i = 0; result == RF_OK && i < deformation->target_count; ++i )
    {
        RfField self = rf_field_item( &targets, (size_t)i );
        Deltas deltas = { .accessor = { NO_ACCESSOR, NO_ACCESSOR, NO_ACCESSOR } };
        result = open_target( gltf, &self, json, primitive, deltas.accessor );
        if ( result == RF_OK )
            result = add_target( gltf, self.path, primitive, base, &deltas, deformation->targets + i );
        free_deltas( &deltas );
    }
    return result;
}

// Skins, and which joints each vertex follows.

#define MAX_JOINTS 65536

// Exporters write weights as bytes: their sum may miss 1 by so much before it is worth a warning.
#define WEIGHT_TOLERANCE 0.05f

// Of the largest: less moves nothing, and denormal numbers count as 0 later.
#define LEAST_WEIGHT 1e-9f

static RfResult read_joints( const RfGltf* gltf, const RfField* json, RfSkin* skin )
{
    const char* where = json->path;
    RfResult result = rf_gltf_require( json, "joints", NULL );
    const json_t* joints = rf_get_array( json, "joints" ).json;
    if ( result != RF_OK || joints == NULL )
        return rf_json_result( json );
    size_t count = json_array_size( joints );
    if ( count == 0 || count > MAX_JOINTS )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "joints must be 1 to %d nodes, got %zu", MAX_JOINTS, count );
    skin->joints = malloc( count * sizeof *skin->joints );
    skin->inverse_binds = malloc( count * sizeof *skin->inverse_binds );
    if ( skin->joints == NULL || skin->inverse_binds == NULL )
        return rf_gltf_no_memory( gltf, where );
    skin->joint_count = (int)count;
    for ( size_t i = 0; result == RF_OK && i < count; ++i )
    {
        result = rf_gltf_read_node_index( gltf, joints, i, where, "joints", skin->joints + i );
        skin->inverse_binds[i] = rf_mat4_identity();
    }
    return result;
}

static RfResult read_inverse_bind( const RfGltf* gltf, const char* where, int index, uint32_t element, RfMat4* out )
{
    float m[16];
    RF_TRY( rf_gltf_read_floats( gltf, index, element, m ) );
    for ( int i = 0; i < 16; ++i )
        out->m[i] = (double)m[i];
    return rf_gltf_make_affine( out->m ) ? RF_OK
                                         : rf_gltf_fail( gltf, RF_ERROR_FORMAT, where,
                                                         "inverseBindMatrices[%u] has a last row other than 0 0 0 1", element );
}

// Without them they are the identity.
static RfResult read_inverse_binds( RfGltf* gltf, const RfField* json, RfSkin* skin )
{
    const char* where = json->path;
    int index = rf_gltf_get_index( gltf, json, "inverseBindMatrices", RF_GLTF_ACCESSORS );
    if ( index < 0 )
        return rf_json_result( json );
    const RfGltfAccessor* accessor;
    RF_TRY( rf_gltf_open_accessor( gltf, index, "skins", 16, &accessor ) );
    if ( accessor->count < (uint32_t)skin->joint_count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "inverseBindMatrices has %u elements for %d joints", accessor->count,
                             skin->joint_count );
    for ( int i = 0; i < skin->joint_count; ++i )
        RF_TRY( read_inverse_bind( gltf, where, index, (uint32_t)i, skin->inverse_binds + i ) );
    return RF_OK;
}

RfResult rf_gltf_load_skins( RfGltf* gltf, RfMovement* movement )
{
    int count = gltf->counts[RF_GLTF_SKINS_LIST];
    RF_TRY( rf_gltf_allocate( gltf, "skins", &movement->skins, (size_t)count, sizeof *movement->skins ) );
    movement->skin_count = count;
    for ( int i = 0; i < count; ++i )
    {
        RfField json = rf_gltf_item_field( gltf, RF_GLTF_SKINS_LIST, i );
        RF_TRY( read_joints( gltf, &json, movement->skins + i ) );
        RF_TRY( read_inverse_binds( gltf, &json, movement->skins + i ) );
    }
    return RF_OK;
}

// JOINTS_0 and WEIGHTS_0, JOINTS_1 and WEIGHTS_1: accessors, or −1.
typedef struct Influences
{
    int joints[2], weights[2];
} Influences;

static RfResult open_influence( RfGltf* gltf, const RfField* primitive, const char* where, const char* name, bool joints,
                                int* index )
{
    int base = -1;
    RfResult result = rf_gltf_find_attribute( gltf, primitive, name, index );
    if ( result == RF_OK )
        result = rf_gltf_find_attribute( gltf, primitive, "POSITION", &base );
    if ( result != RF_OK || *index < 0 )
        return result;
    const RfGltfAccessor* accessor;
    result = rf_gltf_open_accessor( gltf, *index, where, 4, &accessor );
    if ( result != RF_OK )
        return result;
    bool whole = accessor->component_type == 5121 || accessor->component_type == 5123, real = accessor->component_type == 5126;
    if ( joints && ( !whole || accessor->normalized ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s must be unsigned bytes or shorts", name );
    if ( !joints && !real && !( whole && accessor->normalized ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s must be floats or normalized unsigned bytes or shorts", name );
    if ( accessor->count != gltf->accessors[base].count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s has %u elements, POSITION has %u", name, accessor->count,
                             gltf->accessors[base].count );
    return RF_OK;
}

static RfResult open_influences( RfGltf* gltf, const RfField* json, Influences* out )
{
    static const char* const s_names[][2] = { { "JOINTS_0", "WEIGHTS_0" }, { "JOINTS_1", "WEIGHTS_1" } };
    RfField attributes = rf_get_object( json, "attributes" );
    for ( int i = 0; i < 2; ++i )
    {
        RfResult result = open_influence( gltf, json, attributes.path, s_names[i][0], true, out->joints + i );
        if ( result == RF_OK )
            result = open_influence( gltf, json, attributes.path, s_names[i][1], false, out->weights + i );
        if ( result != RF_OK )
            return result;
        if ( ( out->joints[i] < 0 ) != ( out->weights[i] < 0 ) )
            return rf_field_fail( &attributes, "must have %s and %s, or neither", s_names[i][0], s_names[i][1] );
    }
    if ( out->joints[0] < 0 )
        return rf_field_fail( &attributes, "has no JOINTS_0, but a node has its mesh with a skin" );
    if ( rf_has_member( &attributes, "JOINTS_2" ) )
        rf_gltf_notice( gltf, "%s has JOINTS_2: each vertex follows the first eight of its joints", attributes.path );
    return RF_OK;
}

// Keeps the joints with a weight, which then sum to 1; `count` of them are read.
static RfResult keep_influences( RfGltf* gltf, const char* where, uint32_t vertex, const float* joints, const float* weights,
                                 int count, RfDeformation* deformation )
{
    const size_t at = (size_t)vertex * (size_t)deformation->influences;
    uint16_t* joint = deformation->joints + at;
    float* weight = deformation->weights + at;
    double sum = 0.0;
    float largest = 0.0f;
    int kept = 0;
    for ( int i = 0; i < count; ++i )
    {
        if ( weights[i] < 0.0f )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "a weight of a joint is %g, must be 0 or more",
                                 (double)weights[i] );
        largest = rf_maxf( largest, weights[i] );
    }
    for ( int i = 0; i < count; ++i )
    {
        if ( !( weights[i] > LEAST_WEIGHT * largest ) )
            continue;
        sum += (double)weights[i];
        joint[kept] = (uint16_t)joints[i];
        weight[kept++] = weights[i];
    }
    if ( kept == 0 )
    {
        joint[0] = (uint16_t)joints[0];
        weight[0] = 1.0f;
        sum = kept = 1;
        rf_gltf_notice( gltf, "%s has vertices without weights: they follow their first joint", where );
    }
    else if ( fabs( sum - 1.0 ) > (double)WEIGHT_TOLERANCE )
        rf_gltf_notice( gltf, "%s has vertices whose weights sum to %g: they are scaled to 1", where, sum );
    for ( int i = 0; i < kept; ++i )
    {
        weight[i] = (float)( (double)weight[i] / sum );
        if ( joint[i] >= deformation->joint_count )
            deformation->joint_count = joint[i] + 1;
    }
    return RF_OK;
}

// Adds joints and weights of a primitive, likewise.
static RfResult read_influences( RfGltf* gltf, const RfField* json, const RfGltfPrimitive* primitive, uint32_t base,
                                 RfDeformation* deformation )
{
    const char* where = json->path;
    Influences from;
    RF_TRY( open_influences( gltf, json, &from ) );
    size_t all = ( (size_t)base + primitive->t.vertex_count ) * (size_t)deformation->influences;
    if ( !rf_make_room( &deformation->joints, all, sizeof *deformation->joints ) ||
         !rf_make_room( &deformation->weights, all, sizeof *deformation->weights ) )
        return rf_gltf_no_memory( gltf, where );
    size_t before = (size_t)base * (size_t)deformation->influences;
    memset( deformation->joints + before, 0, ( all - before ) * sizeof *deformation->joints );
    memset( deformation->weights + before, 0, ( all - before ) * sizeof *deformation->weights );
    for ( uint32_t v = 0; v < primitive->t.vertex_count; ++v )
    {
        float joint[8] = { 0 }, weight[8] = { 0 };
        for ( int i = 0; i < 2 && from.joints[i] >= 0; ++i )
        {
            RF_TRY( rf_gltf_read_floats( gltf, from.joints[i], primitive->sources[v], joint + 4 * i ) );
            RF_TRY( rf_gltf_read_floats( gltf, from.weights[i], primitive->sources[v], weight + 4 * i ) );
        }
        RF_TRY( keep_influences( gltf, where, base + v, joint, weight, deformation->influences, deformation ) );
    }
    return RF_OK;
}

// Up to eight joints for a vertex, rather than four?
static bool has_eight_joints( const json_t* primitive )
{
    return json_object_get( json_object_get( primitive, "attributes" ), "JOINTS_1" ) != NULL;
}

#define MAX_VERTICES ( 3u << 28 )

// Those of all attributes that some mesh has, and in any case positions and normals.
static bool grow_attributes( RfTriangles* t, size_t vertices )
{
    bool room = true;
    for ( int a = 0; a < RF_ATTRIBUTE_COUNT; ++a )
    {
        float** all = rf_attribute( t, a );
        room =
            ( ( *all == NULL && a >= RF_UV ) || rf_make_room( all, vertices * g_rf_attributes[a].components, sizeof **all ) ) &&
            room;
    }
    return room;
}

static uint32_t next_capacity( uint32_t capacity, uint32_t need, uint32_t most )
{
    uint32_t larger = capacity < most / 2 ? capacity + capacity / 2 : most;
    return larger > need ? larger : need;
}

static RfResult reserve_vertices( const RfGltf* gltf, RfGltfBaker* baker, uint32_t more, const char* where )
{
    RfTriangles* t = baker->triangles;
    if ( more > MAX_VERTICES - t->vertex_count )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %u vertices in all: split the scene", MAX_VERTICES );
    if ( t->vertex_count + more <= baker->vertex_capacity )
        return RF_OK;
    size_t capacity = next_capacity( baker->vertex_capacity, t->vertex_count + more, MAX_VERTICES );
    if ( !grow_attributes( t, capacity ) )
        return rf_gltf_no_memory( gltf, where );
    baker->vertex_capacity = (uint32_t)capacity;
    return RF_OK;
}

static RfResult reserve_triangles( const RfGltf* gltf, RfGltfBaker* baker, uint32_t more, const char* where )
{
    RfTriangles* t = baker->triangles;
    // dropped triangles count too, else a small file could request any amount of work
    if ( more > RF_GLTF_MAX_TRIANGLES - baker->placed )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %u triangles in all: split the scene",
                             RF_GLTF_MAX_TRIANGLES );
    baker->placed += more;
    if ( t->count + more <= baker->triangle_capacity )
        return RF_OK;
    size_t capacity = next_capacity( baker->triangle_capacity, t->count + more, RF_GLTF_MAX_TRIANGLES );
    if ( !rf_make_room( &t->indices, capacity * 3, sizeof *t->indices ) ||
         !rf_make_room( &t->material, capacity, sizeof *t->material ) )
        return rf_gltf_no_memory( gltf, where );
    baker->triangle_capacity = (uint32_t)capacity;
    return RF_OK;
}

// Appends the vertices of a primitive. An attribute is allocated when the first primitive has it.
static RfResult append_vertices( const RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const char* where )
{
    RfTriangles* t = baker->triangles;
    size_t base = t->vertex_count, more = primitive->t.vertex_count;
    RfResult result = reserve_vertices( gltf, baker, primitive->t.vertex_count, where );
    for ( int a = 0; result == RF_OK && a < RF_ATTRIBUTE_COUNT; ++a )
    {
        const size_t n = g_rf_attributes[a].components;
        const float* own = *rf_attribute( (RfTriangles*)&primitive->t, a );
        float** all = rf_attribute( t, a );
        bool fresh = *all == NULL && own != NULL;
        if ( fresh && !rf_make_room( all, baker->vertex_capacity * n, sizeof **all ) )
            return rf_gltf_no_memory( gltf, where );
        for ( size_t i = fresh ? 0 : n * base; *all != NULL && i < ( own != NULL ? n * base : n * ( base + more ) ); ++i )
            ( *all )[i] = g_rf_attributes[a].fill;
        if ( own != NULL )
            memcpy( *all + n * base, own, n * more * sizeof *own );
    }
    t->vertex_count += result == RF_OK ? primitive->t.vertex_count : 0;
    return result;
}

// `sign` is −1 for a mirroring matrix.
static void transform_tangent( const RfMat4* matrix, double sign, float* tangent )
{
    double local[3] = { (double)tangent[0], (double)tangent[1], (double)tangent[2] }, placed[3];
    rf_mat4_apply( matrix, local, 0.0, placed );
    double length = sqrt( placed[0] * placed[0] + placed[1] * placed[1] + placed[2] * placed[2] );
    bool usable = length > 0.0 && length <= DBL_MAX;
    for ( int i = 0; i < 3; ++i )
        tangent[i] = usable ? (float)( placed[i] / length ) : 0.0f;
    tangent[3] = !usable ? 0.0f : (float)( ( tangent[3] < 0.0f ? -1.0 : 1.0 ) * sign );
}

static RfResult fail_far( const RfGltf* gltf, const char* where, double at, double most )
{
    return rf_gltf_fail( gltf, RF_ERROR_SCENE, where, "a vertex is at %g, beyond %g: scale the scene down", at, most );
}

// Places the vertices from `base` on. The normals of flat faces follow from where they come to lie.
static RfResult transform_vertices( const RfGltf* gltf, RfTriangles* t, uint32_t base, const RfGltfPrimitive* primitive,
                                    const RfMat4* matrix, const char* where )
{
    double sign = rf_mat4_det3( matrix ) < 0.0 ? -1.0 : 1.0;
    bool flat = primitive->flat && primitive->t.tangents == NULL;
    for ( size_t v = base; v < t->vertex_count; ++v )
    {
        float *at = t->positions + 3 * v, *normal = t->normals + 3 * v;
        double local[3] = { (double)at[0], (double)at[1], (double)at[2] }, placed[3],
               own[3] = { (double)normal[0], (double)normal[1], (double)normal[2] }, n[3] = { 0.0 };
        rf_mat4_apply( matrix, local, 1.0, placed );
        for ( int i = 0; i < 3; ++i )
        {
            if ( !( fabs( placed[i] ) <= RF_MAX_COORDINATE ) ) // written so that NaN fails
                return fail_far( gltf, where, placed[i], RF_MAX_COORDINATE );
            at[i] = (float)placed[i];
        }
        if ( !flat )
            rf_mat4_apply_cofactor( matrix, own, n );
        rf_normalise( n, sign, normal ); // zero if it is zero in the file, or if the matrix collapses it
        if ( primitive->t.tangents != NULL )
            transform_tangent( matrix, sign, t->tangents + 4 * v );
    }
    return RF_OK;
}

static void normalise( float* v ) { rf_normalise( ( const double[3] ){ (double)v[0], (double)v[1], (double)v[2] }, 1.0, v ); }

// In their own space: unit normals and tangents, where they are not 0; tangents with a sign.
static RfResult check_vertices( const RfGltf* gltf, RfTriangles* t, uint32_t base, const char* where )
{
    for ( size_t v = base; v < t->vertex_count; ++v )
    {
        for ( size_t c = 0; c < 3; ++c )
        {
            if ( fabs( (double)t->positions[3 * v + c] ) > RF_MAX_COORDINATE )
                return fail_far( gltf, where, (double)t->positions[3 * v + c], RF_MAX_COORDINATE );
        }
        normalise( t->normals + 3 * v );
        if ( t->tangents == NULL )
            continue;
        float* tangent = t->tangents + 4 * v;
        normalise( tangent );
        bool usable = tangent[0] != 0.0f || tangent[1] != 0.0f || tangent[2] != 0.0f;
        tangent[3] = !usable ? 0.0f : tangent[3] < 0.0f ? -1.0f : 1.0f;
    }
    return RF_OK;
}

static bool is_zero( const float* v ) { return v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f; }

// One without area is dropped, except from a mesh that deforms: it may have one in another shape.
static void append_triangle( RfGltfBaker* baker, const uint32_t corners[3], uint32_t material, const char* where )
{
    RfTriangles* t = baker->triangles;
    float normal[3];
    bool whole = rf_face_normal( t->positions, corners, baker->least_double_area, normal );
    if ( !whole && !baker->deforms )
    {
        if ( baker->degenerate++ == 0 )
            baker->first_degenerate = rf_where( "%s", where );
        return;
    }
    for ( size_t i = 0; i < 3; ++i )
    {
        const float* p = t->positions + 3 * (size_t)corners[i];
        float* own = t->normals + 3 * (size_t)corners[i];
        if ( is_zero( own ) )
            memcpy( own, normal, sizeof normal );
        t->indices[3 * (size_t)t->count + i] = corners[i];
        rf_grow_bounds( &baker->bounds_min, &baker->bounds_max, t->count == 0 && i == 0, rf_vec3( p[0], p[1], p[2] ) );
    }
    t->material[t->count++] = material;
}

RfResult rf_gltf_bake( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                       const char* where )
{
    RfTriangles* t = baker->triangles;
    uint32_t base = t->vertex_count, first = t->count;
    RF_TRY( append_vertices( gltf, baker, primitive, where ) );
    RF_TRY( reserve_triangles( gltf, baker, primitive->t.count, where ) );
    RF_TRY( matrix != NULL ? transform_vertices( gltf, t, base, primitive, matrix, where )
                           : check_vertices( gltf, t, base, where ) );
    // a mirroring matrix reverses the winding: swap two corners to restore it
    bool mirrored = matrix != NULL && rf_mat4_det3( matrix ) < 0.0;
    for ( size_t i = 0; i < primitive->t.count; ++i )
    {
        const uint32_t* from = primitive->t.indices + 3 * i;
        uint32_t corners[3] = { base + from[0], base + from[mirrored ? 2 : 1], base + from[mirrored ? 1 : 2] };
        append_triangle( baker, corners, primitive->material, where );
    }
    if ( t->count == first && matrix != NULL )
        t->vertex_count = base;
    for ( size_t v = base; v < t->vertex_count && !baker->deforms; ++v )
    {
        if ( is_zero( t->normals + 3 * v ) ) // used only by dropped triangles
            t->normals[3 * v + 2] = 1.0f;
    }
    if ( primitive->t.colors != NULL )
        gltf->scene->materials[primitive->material].textured->vertex_colors = true;
    return RF_OK;
}

void rf_gltf_finish_baker( RfGltfBaker* baker )
{
    RfTriangles* t = baker->triangles;
    if ( t->count > 0 ) // a failure to shrink changes nothing
    {
        grow_attributes( t, t->vertex_count );
        rf_make_room( &t->indices, 3 * (size_t)t->count, sizeof *t->indices );
        rf_make_room( &t->material, t->count, sizeof *t->material );
    }
}

void rf_gltf_warn_of_degenerate( const RfGltf* gltf, RfLog* log, uint64_t count, const RfWhere* first )
{
    if ( count > 0 )
        rf_warn( log, "%s: %llu triangles without area are dropped, the first in %s", gltf->path, (unsigned long long)count,
                 first->text );
}

// Meshes in their own space: all primitives of one, for what moves.

// Of all meshes in their own space.
#define MAX_TRIANGLES ( (uint64_t)1 << 28 )

#define EIGHT 8
#define FOUR 4

// What is read of one mesh.
typedef struct Reader
{
    RfGltf* gltf;
    const RfGltfShape* shape;
    RfMesh* out;
    RfGltfBaker baker;
    bool* flat; // of its vertices
} Reader;

static RfResult add_primitive( Reader* r, const RfField* json, const RfGltfPrimitive* p )
{
    const char* where = json->path;
    RfMesh* mesh = r->out;
    uint32_t base = mesh->triangles.vertex_count;
    r->gltf->shape_triangles += p->t.count;
    if ( r->gltf->shape_triangles > MAX_TRIANGLES )
        return rf_gltf_fail( r->gltf, RF_ERROR_UNSUPPORTED, where, "more than %llu triangles in all that moves: split the scene",
                             (unsigned long long)MAX_TRIANGLES );
    RfResult result = rf_gltf_bake( r->gltf, &r->baker, p, NULL, where );
    if ( !rf_make_room( &r->flat, (size_t)base + p->t.vertex_count, sizeof *r->flat ) )
        return rf_gltf_no_memory( r->gltf, where );
    memset( r->flat + base, p->flat, p->t.vertex_count );
    if ( result == RF_OK && mesh->deformation != NULL )
        result = read_targets( r->gltf, json, p, base, mesh->deformation );
    if ( result == RF_OK && r->shape->skinned )
        result = read_influences( r->gltf, json, p, base, mesh->deformation );
    return result;
}

static RfResult read_primitive( Reader* r, const RfField* json )
{
    RfGltfPrimitive p;
    if ( r->shape->changing_only && !rf_gltf_primitive_changes( r->gltf, json ) )
        return RF_OK;
    RfResult result = rf_gltf_read_primitive( r->gltf, json, false, &p );
    if ( result != RF_OK )
        return result;
    p.material = rf_gltf_tagged_material( r->gltf, r->shape->use, p.material );
    if ( p.t.count > 0 )
        result = add_primitive( r, json, &p );
    rf_gltf_free_primitive( &p );
    return result;
}

static RfResult begin_deformation( const Reader* r, const json_t* primitives, const char* where )
{
    RfDeformation* deformation = calloc( 1, sizeof *deformation );
    r->out->deformation = deformation;
    if ( deformation == NULL )
        return rf_gltf_no_memory( r->gltf, where );
    for ( size_t i = 0; r->shape->skinned && i < json_array_size( primitives ); ++i )
    {
        if ( deformation->influences < EIGHT )
            deformation->influences = has_eight_joints( json_array_get( primitives, i ) ) ? EIGHT : FOUR;
    }
    int count;
    RF_TRY( rf_gltf_mesh_targets( r->gltf, r->gltf->uses[r->shape->use].mesh, &count ) );
    RF_TRY( rf_gltf_allocate( r->gltf, where, &deformation->targets, (size_t)count, sizeof *deformation->targets ) );
    deformation->target_count = count;
    return RF_OK;
}

static RfResult read_primitives( Reader* r )
{
    RfField primitives = rf_gltf_primitives( r->gltf, r->gltf->uses[r->shape->use].mesh );
    RfResult result = rf_json_result( &primitives );
    if ( result == RF_OK && r->shape->deforms )
        result = begin_deformation( r, primitives.json, primitives.path );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( primitives.json ); ++i )
    {
        RfField primitive = rf_field_item( &primitives, i );
        result = read_primitive( r, &primitive );
    }
    return result;
}

// On failure, what was read stays with the scene, which is destroyed.
RfResult rf_gltf_read_shape( RfGltf* gltf, const RfGltfShape* shape, RfMesh* out )
{
    Reader reader = { .gltf = gltf, .shape = shape, .out = out };
    reader.baker = ( RfGltfBaker ){ .triangles = &out->triangles, .deforms = shape->deforms };
    RfResult result = read_primitives( &reader );
    rf_gltf_finish_baker( &reader.baker );
    out->bounds_min = reader.baker.bounds_min;
    out->bounds_max = reader.baker.bounds_max;
    if ( out->deformation != NULL )
        out->deformation->flat = reader.flat;
    else
        free( reader.flat );
    rf_gltf_warn_of_degenerate( gltf, gltf->log, reader.baker.degenerate, &reader.baker.first_degenerate );
    return result;
}
