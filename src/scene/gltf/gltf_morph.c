// Morph targets of meshes, and their weights where nothing animates them.
#include "scene/gltf/gltf_geometry.h"

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
    float* grown = realloc( *all, ( before + more + 1 ) * 3 * sizeof *grown );
    if ( grown == NULL )
        return false;
    *all = grown;
    if ( fresh )
        memset( grown, 0, before * 3 * sizeof *grown );
    if ( values != NULL )
        memcpy( grown + 3 * before, values, more * 3 * sizeof *grown );
    else
        memset( grown + 3 * before, 0, more * 3 * sizeof *grown );
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
    RfResult result = rf_gltf_open_accessor( gltf, *index, &accessor );
    if ( result == RF_OK )
        result = rf_gltf_expect( gltf, *index, accessor, target->path, 3 );
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
            rf_gltf_notice( gltf, RF_GLTF_TARGETS_LEFT_OUT, "%s changes %.40s, which stays as it is", target->path, name );
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
    if ( primitive->tangents == NULL || json_object_get( attributes, "TANGENT" ) == NULL )
        accessors[2] = NO_ACCESSOR;
    return result;
}

static RfResult collect( const RfGltf* gltf, const char* where, const RfGltfPrimitive* primitive, uint32_t base, Deltas* deltas )
{
    size_t room = (size_t)primitive->vertex_count + 1;
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
    for ( uint32_t v = 0; v < primitive->vertex_count; ++v )
    {
        bool changed = false;
        for ( int k = 0; k < 3; ++k )
        {
            if ( deltas->accessor[k] < 0 )
                continue;
            float* value = deltas->values[k] + 3 * (size_t)deltas->count;
            RfResult result = rf_gltf_read_floats( gltf, deltas->accessor[k], primitive->sources[v], value );
            if ( result != RF_OK )
                return result;
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
    gltf->target_vertices += primitive->vertex_count;
    if ( gltf->target_vertices > MAX_TARGET_VERTICES )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %llu vertices in all morph targets: split the scene",
                             (unsigned long long)MAX_TARGET_VERTICES );
    RfResult result = collect( gltf, where, primitive, base, deltas );
    if ( result != RF_OK || deltas->count == 0 )
        return result;
    size_t before = target->count, more = deltas->count;
    uint32_t* grown = realloc( target->vertices, ( before + more ) * sizeof *grown );
    if ( grown == NULL )
        return rf_gltf_no_memory( gltf, where );
    target->vertices = grown;
    memcpy( grown + before, deltas->vertices, more * sizeof *grown );
    if ( !append( &target->positions, before, more, deltas->values[0] ) ||
         !append( &target->normals, before, more, deltas->values[1] ) ||
         !append( &target->tangents, before, more, deltas->values[2] ) )
        return rf_gltf_no_memory( gltf, where );
    target->count += deltas->count;
    return RF_OK;
}

RfResult rf_gltf_read_targets( RfGltf* gltf, const RfField* json, const RfGltfPrimitive* primitive, uint32_t base,
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
