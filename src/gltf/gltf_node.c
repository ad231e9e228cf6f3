// Nodes: their transforms, their hierarchy, and instances at them.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "scene/placement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Nodes: transforms, the hierarchy, and which nodes the default scene contains. All traversals
// are iterative: a deep hierarchy cannot overflow the stack.

// Limit of the depth of a node. Rigs have a few hundred levels; more means a broken or
// malicious file.
#define MAX_DEPTH 1000

static RfResult read_matrix( const RfField* json, RfNode* node )
{
    if ( rf_has_member( json, "translation" ) || rf_has_member( json, "rotation" ) || rf_has_member( json, "scale" ) )
        return rf_field_fail( json, "has both a matrix and translation, rotation or scale" );
    RF_TRY( rf_get_numbers( json, "matrix", rf_any_number(), 16, node->matrix.m ) );
    if ( !rf_gltf_make_affine( node->matrix.m ) )
        return rf_field_fail( json, "matrix has a last row other than 0 0 0 1" );
    node->has_matrix = true;
    return RF_OK;
}

static RfResult read_trs( const RfField* json, RfNode* node )
{
    rf_get_numbers( json, "translation", rf_any_number(), 3, node->translation );
    rf_get_numbers( json, "rotation", rf_any_number(), 4, node->rotation );
    return rf_get_numbers( json, "scale", rf_any_number(), 3, node->scale );
}

static RfResult copy_text( const RfField* ours, const char* key, char** copy )
{
    const char* text = NULL;
    RfResult result = rf_get_text( ours, key, &text );
    if ( result != RF_OK || text == NULL )
        return result;
    RfField field = rf_field_member( ours, key );
    if ( text[0] == '\0' )
        return rf_field_fail( &field, "must not be empty: leave it out" );
    *copy = strdup( text );
    return *copy != NULL ? RF_OK : rf_field_no_memory( ours );
}

// `extras.reframe`: what compositors know the node's surfaces by.
static RfResult read_extras( const RfField* json, RfNode* node )
{
    RfField ours = rf_gltf_extras( json );
    int64_t index = 0;
    if ( !json_is_object( ours.json ) )
        return rf_json_result( json );
    ours.gltf = true;
    copy_text( &ours, "object", &node->object );
    copy_text( &ours, "asset", &node->asset );
    rf_get_integer( &ours, "pass_index", 0, RF_MOST_PASS_INDEX, &index );
    node->pass_index = (int)index;
    return rf_json_result( json );
}

static RfResult normalise_rotation( const RfField* json, double q[4] )
{
    double length = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] );
    if ( ( length > 1e-6 && length < 1e6 ) == false )
        return rf_field_fail( json, "rotation is not a unit quaternion" );
    for ( int i = 0; i < 4; ++i )
        q[i] /= length;
    return RF_OK;
}

// Places and hides a node as a scene file has it.
static RfResult set_still( const RfGltf* gltf, const RfChannel* channel )
{
    int index = rf_gltf_given_node( gltf, channel );
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_NODES, index );
    RfNode* node = gltf->scene->nodes + index;
    double* const to[] = { node->translation, node->rotation, node->scale };
    if ( channel->path == RF_VISIBILITY )
        node->hidden = channel->count == 0 && channel->values[0] == 0.0;
    else
        node->has_matrix = false; // all three are given
    if ( channel->path <= RF_SCALE && channel->count == 0 )
        memcpy( to[channel->path], channel->values, (size_t)channel->components * sizeof *channel->values );
    return normalise_rotation( &json, node->rotation );
}

// Puts all of the file below a node that is not of the document.
static RfResult add_above( RfGltf* gltf, int index, const char* name )
{
    RfNode* nodes = gltf->scene->nodes;
    for ( int i = gltf->order_count++; i > 0; --i )
    {
        int node = gltf->order[i] = gltf->order[i - 1];
        nodes[node].parent = nodes[node].parent < 0 ? index : nodes[node].parent;
    }
    gltf->order[0] = index;
    nodes[index].parent = -1;
    nodes[index].name = strdup( name );
    return nodes[index].name != NULL ? RF_OK : rf_gltf_no_memory( gltf, "nodes" );
}

#define RTC "CESIUM_RTC"

static RfField find_centre( const RfGltf* gltf )
{
    RfField root = rf_gltf_root( gltf );
    return rf_gltf_field( gltf, RTC, rf_gltf_extension( &root, RTC ).json );
}

// The centre that CESIUM_RTC gives the file moves all of it; a node that the scene file adds, of the number after those of the
// document, moves that.
static RfResult add_tops( RfGltf* gltf )
{
    RfField rtc = find_centre( gltf );
    int top = gltf->counts[RF_GLTF_NODES], centre = top + ( gltf->options->top != NULL );
    if ( rtc.json != NULL )
    {
        rf_gltf_require( &rtc, "center", NULL );
        RF_TRY( rf_get_numbers( &rtc, "center", rf_any_number(), 3, gltf->scene->nodes[centre].translation ) );
        RF_TRY( add_above( gltf, centre, RTC ) );
    }
    return gltf->options->top != NULL ? add_above( gltf, top, gltf->options->top ) : RF_OK;
}

static RfResult load_node( RfGltf* gltf, int index )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_NODES, index );
    RfGltfNode* own = gltf->nodes + index;
    RfNode* node = gltf->scene->nodes + index;
    bool visible = true;
    node->matrix = rf_mat4_identity();
    node->rotation[3] = 1.0;
    node->scale[0] = node->scale[1] = node->scale[2] = 1.0;
    own->light_group = own->moving = own->here = -1;
    own->span = ( RfGltfSpan ){ INFINITY, -INFINITY };
    if ( json.json != NULL )
        rf_gltf_copy_name( &json, json.path, &node->name );
    own->use = own->mesh = rf_gltf_get_index( gltf, &json, "mesh", RF_GLTF_MESHES );
    own->camera = rf_gltf_get_index( gltf, &json, "camera", RF_GLTF_CAMERAS );
    own->skin = rf_gltf_get_index( gltf, &json, "skin", RF_GLTF_SKINS_LIST );
    rf_gltf_read_light_group( gltf, &json, &own->light_group );
    RfField visibility = rf_gltf_extension( &json, "KHR_node_visibility" );
    rf_get_bool( &visibility, "visible", &visible );
    node->hidden = !visible;
    read_extras( &json, node );
    if ( rf_has_member( &json, "matrix" ) )
        read_matrix( &json, node );
    else
        read_trs( &json, node );
    return rf_json_result( &json ) == RF_OK ? normalise_rotation( &json, node->rotation ) : rf_json_result( &json );
}

RfResult rf_gltf_read_node_index( const RfGltf* gltf, const json_t* list, size_t at, const char* where, const char* key,
                                  int* node )
{
    const json_t* value = json_array_get( list, at );
    if ( json_is_integer( value ) == 0 || json_integer_value( value ) < 0 ||
         json_integer_value( value ) >= gltf->counts[RF_GLTF_NODES] )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s[%zu] must be an index below %d", key, at,
                             gltf->counts[RF_GLTF_NODES] );
    *node = (int)json_integer_value( value );
    return RF_OK;
}

static RfResult link_children( RfGltf* gltf, int parent )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_NODES, parent );
    if ( !rf_has_member( &json, "children" ) )
        return RF_OK;
    const json_t* children = rf_get_array( &json, "children" ).json;
    RfResult result = rf_json_result( &json );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( children ); ++i )
    {
        int child = 0;
        result = rf_gltf_read_node_index( gltf, children, i, json.path, "children", &child );
        if ( result != RF_OK )
            break;
        RfNode* node = gltf->scene->nodes + child;
        if ( node->parent >= 0 )
            return rf_field_fail( &json,
                                  "children[%zu] is nodes[%d], which is a child of "
                                  "nodes[%d] already",
                                  i, child, node->parent );
        node->parent = parent;
    }
    return result;
}

// Appends all descendants of the nodes in `order` from `first` on.
static RfResult append_descendants( const RfGltf* gltf, int first, int* order, int* count, int* depth )
{
    for ( int at = first; at < *count; ++at )
    {
        int parent = order[at];
        if ( depth[parent] > MAX_DEPTH )
            return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "nodes",
                                 "nodes[%d] is more than %d levels deep: "
                                 "flatten the hierarchy in the modelling program",
                                 parent, MAX_DEPTH );
        const json_t* children = json_object_get( rf_gltf_item( gltf, RF_GLTF_NODES, parent ), "children" );
        for ( size_t i = 0; i < json_array_size( children ); ++i )
        {
            int child = (int)json_integer_value( json_array_get( children, i ) );
            depth[child] = depth[parent] + 1;
            order[( *count )++] = child;
        }
    }
    return RF_OK;
}

// By now every node has at most one parent, so nodes not reached from a root form a cycle.
static RfResult order_all( const RfGltf* gltf, int* order, int* count, int* depth )
{
    *count = 0;
    for ( int i = 0; i < gltf->scene->node_count; ++i )
    {
        if ( gltf->scene->nodes[i].parent < 0 )
            order[( *count )++] = i;
    }
    RfResult result = append_descendants( gltf, 0, order, count, depth );
    if ( result == RF_OK && *count < gltf->scene->node_count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, "nodes", "%d of them are their own ancestors",
                             gltf->scene->node_count - *count );
    return result;
}

// UniGLTF lists nodes whose parent is not of the scene; others read them as roots, without the parent's transform.
static RfResult make_root( RfGltf* gltf, const char* where, int i, const int* depth )
{
    RfNode *nodes = gltf->scene->nodes, *root = nodes + gltf->order[i];
    for ( int above = root->parent; above >= 0; above = nodes[above].parent )
    {
        if ( depth[above] == 0 )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "nodes[%d] is node %d, which is below another of the scene", i,
                                 gltf->order[i] );
    }
    if ( root->parent >= 0 )
        rf_gltf_notice( gltf, "%s has node '%.80s', but not its parent '%.80s': it is placed without it", where, root->name,
                        nodes[root->parent].name );
    root->parent = -1;
    return RF_OK;
}

static RfResult order_scene( RfGltf* gltf, int index, int* depth )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_SCENES, index );
    const json_t* roots = rf_get_array( &json, "nodes" ).json;
    RfResult result = rf_json_result( &json );
    gltf->order_count = 0;
    for ( int i = 0; i < gltf->scene->node_count; ++i )
        depth[i] = -1;
    for ( size_t i = 0; result == RF_OK && i < json_array_size( roots ); ++i )
    {
        int root = 0;
        result = rf_gltf_read_node_index( gltf, roots, i, json.path, "nodes", &root );
        if ( result != RF_OK )
            break;
        if ( depth[root] == 0 )
            return rf_field_fail( &json, "nodes[%zu] is node %d, which is listed twice", i, root );
        depth[root] = 0;
        gltf->order[gltf->order_count++] = root;
    }
    for ( int i = 0; result == RF_OK && i < gltf->order_count; ++i )
        result = make_root( gltf, json.path, i, depth );
    return result == RF_OK ? append_descendants( gltf, 0, gltf->order, &gltf->order_count, depth ) : result;
}

static RfResult order_nodes( RfGltf* gltf, int* depth )
{
    RF_TRY( order_all( gltf, gltf->order, &gltf->order_count, depth ) );
    RfField root = rf_gltf_root( gltf );
    int scene = rf_gltf_get_index( gltf, &root, "scene", RF_GLTF_SCENES );
    if ( rf_json_result( &root ) != RF_OK )
        return rf_json_result( &root );
    // without scenes, everything in the file is shown
    if ( gltf->counts[RF_GLTF_SCENES] == 0 )
        return RF_OK;
    return order_scene( gltf, scene >= 0 ? scene : 0, depth );
}

RfResult rf_gltf_load_nodes( RfGltf* gltf )
{
    int own = gltf->counts[RF_GLTF_NODES], count = own + ( gltf->options->top != NULL ) + ( find_centre( gltf ).json != NULL );
    RfNode* nodes = calloc( (size_t)count + 1, sizeof *nodes );
    int* depth = calloc( (size_t)count + 1, sizeof *depth );
    gltf->order = calloc( (size_t)count + 1, sizeof *gltf->order );
    gltf->nodes = calloc( (size_t)count + 1, sizeof *gltf->nodes );
    gltf->scene->nodes = nodes;
    gltf->scene->node_count = nodes != NULL ? own : 0;
    RfResult result = RF_OK;
    if ( nodes == NULL || depth == NULL || gltf->order == NULL || gltf->nodes == NULL )
        result = rf_gltf_no_memory( gltf, "nodes" );
    for ( int i = 0; result == RF_OK && i < count; ++i )
    {
        nodes[i].parent = -1;
        result = load_node( gltf, i );
    }
    for ( int i = 0; result == RF_OK && i < gltf->options->channel_count; ++i )
        result = set_still( gltf, gltf->options->channels + i );
    for ( int i = 0; result == RF_OK && i < own; ++i )
        result = link_children( gltf, i );
    if ( result == RF_OK )
        result = order_nodes( gltf, depth );
    if ( result == RF_OK )
        result = add_tops( gltf );
    gltf->scene->node_count = nodes != NULL ? count : 0;
    free( depth );
    return result;
}

// EXT_mesh_gpu_instancing: a node that instances its mesh many times, with accessors for translation, rotation and scale.

#define EXTENSION "EXT_mesh_gpu_instancing"

static RfResult open_attribute( RfGltf* gltf, const RfField* attributes, const char* where, const char* key, int components,
                                int* index, uint32_t* count )
{
    const RfGltfAccessor* accessor;
    *index = rf_gltf_get_index( gltf, attributes, key, RF_GLTF_ACCESSORS );
    RF_TRY( *index >= 0 ? rf_gltf_open_accessor( gltf, *index, where, components, &accessor ) : rf_json_result( attributes ) );
    if ( *index < 0 )
        return RF_OK;
    if ( *count != 0 && *count != accessor->count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s has %u elements, the attribute before it %u", key, accessor->count,
                             *count );
    *count = accessor->count;
    return RF_OK;
}

RfResult rf_gltf_open_instances( RfGltf* gltf, int node, RfGltfInstances* out )
{
    *out = ( RfGltfInstances ){ .count = 1, .translation = -1, .rotation = -1, .scale = -1 };
    RfField self = rf_gltf_item_field( gltf, RF_GLTF_NODES, node ), json = rf_gltf_extension( &self, EXTENSION );
    uint32_t count = 0;
    if ( json.json == NULL )
        return rf_json_result( &self );
    rf_gltf_require( &json, "attributes", NULL );
    RfField attributes = rf_get_object( &json, "attributes" );
    open_attribute( gltf, &attributes, json.path, "TRANSLATION", 3, &out->translation, &count );
    open_attribute( gltf, &attributes, json.path, "ROTATION", 4, &out->rotation, &count );
    RfResult result = open_attribute( gltf, &attributes, json.path, "SCALE", 3, &out->scale, &count );
    if ( result == RF_OK && count == 0 )
        return rf_field_fail( &json, "must have at least one of TRANSLATION, ROTATION and SCALE" );
    out->count = count;
    return result;
}

static RfResult read_doubles( const RfGltf* gltf, int accessor, uint32_t element, int count, double* values )
{
    float floats[4];
    if ( accessor < 0 || gltf->error->code != RF_OK )
        return gltf->error->code;
    RfResult result = rf_gltf_read_floats( gltf, accessor, element, floats );
    for ( int i = 0; result == RF_OK && i < count; ++i )
        values[i] = (double)floats[i];
    return result;
}

RfResult rf_gltf_instance_matrix( const RfGltf* gltf, const RfGltfInstances* instances, uint32_t element, RfMat4* matrix )
{
    double t[3] = { 0 }, q[4] = { 0, 0, 0, 1 }, s[3] = { 1, 1, 1 };
    read_doubles( gltf, instances->translation, element, 3, t );
    read_doubles( gltf, instances->rotation, element, 4, q );
    RF_TRY( read_doubles( gltf, instances->scale, element, 3, s ) );
    double length = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] );
    if ( !( length > 1e-3 ) )
    {
        RfWhere where = rf_where( "accessors[%d]", instances->rotation );
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "element %u is not a unit quaternion", element );
    }
    for ( int i = 0; i < 4; ++i )
        q[i] /= length;
    *matrix = rf_mat4_from_trs( t, q, s );
    return RF_OK;
}
