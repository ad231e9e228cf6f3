// Nodes and the animations that move them.
#include "scene/gltf/gltf_document.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Nodes: transforms, the hierarchy, and which nodes the default scene contains. All traversals
// are iterative: a deep hierarchy cannot overflow the stack.

// Limit of the depth of a node. Rigs have a few hundred levels; more means a broken or
// malicious file.
#define MAX_DEPTH 1000

// Exporters write the last row of a matrix with rounding errors.
#define AFFINE_TOLERANCE 1e-5

static RfResult read_matrix( const RfGltf* gltf, const json_t* json, const char* where, RfNode* node )
{
    if ( json_object_get( json, "translation" ) != NULL || json_object_get( json, "rotation" ) != NULL ||
         json_object_get( json, "scale" ) != NULL )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "has both a matrix and translation, rotation or scale" );
    double* m = node->matrix.m;
    RfResult result = rf_gltf_get_numbers( gltf, json, where, "matrix", 16, m );
    if ( result != RF_OK )
        return result;
    if ( fabs( m[3] ) > AFFINE_TOLERANCE || fabs( m[7] ) > AFFINE_TOLERANCE || fabs( m[11] ) > AFFINE_TOLERANCE ||
         fabs( m[15] - 1.0 ) > AFFINE_TOLERANCE )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "matrix has a last row other than 0 0 0 1" );
    m[3] = m[7] = m[11] = 0.0;
    m[15] = 1.0;
    node->has_matrix = true;
    return RF_OK;
}

static RfResult read_trs( const RfGltf* gltf, const json_t* json, const char* where, RfNode* node )
{
    RfResult result = rf_gltf_get_numbers( gltf, json, where, "translation", 3, node->translation );
    if ( result == RF_OK )
        result = rf_gltf_get_numbers( gltf, json, where, "rotation", 4, node->rotation );
    if ( result == RF_OK )
        result = rf_gltf_get_numbers( gltf, json, where, "scale", 3, node->scale );
    if ( result != RF_OK )
        return result;
    double* q = node->rotation;
    double length = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] );
    if ( ( length > 1e-6 && length < 1e6 ) == false )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "rotation is not a unit quaternion" );
    for ( int i = 0; i < 4; ++i )
        q[i] /= length;
    return RF_OK;
}

static RfResult load_node( RfGltf* gltf, int index )
{
    RfWhere where = rf_where( "nodes[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_NODES, index );
    RfNode* node = gltf->scene->nodes + index;
    node->matrix = rf_mat4_identity();
    node->rotation[3] = 1.0;
    node->scale[0] = node->scale[1] = node->scale[2] = 1.0;
    RfResult result = rf_gltf_copy_name( gltf, json, where.text, where.text, &node->name );
    if ( result != RF_OK )
        return result;
    if ( json_object_get( json, "matrix" ) != NULL )
        return read_matrix( gltf, json, where.text, node );
    return read_trs( gltf, json, where.text, node );
}

// Reads one index of an array, such as children[2].
static RfResult read_node_index( const RfGltf* gltf, const json_t* list, size_t at, const char* where, const char* key,
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
    RfWhere where = rf_where( "nodes[%d]", parent );
    const json_t* children = NULL;
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_NODES, parent );
    RfResult result = rf_gltf_get_array( gltf, json, where.text, "children", &children );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( children ); ++i )
    {
        int child = 0;
        result = read_node_index( gltf, children, i, where.text, "children", &child );
        if ( result != RF_OK )
            break;
        RfNode* node = gltf->scene->nodes + child;
        if ( node->parent >= 0 )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text,
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

static RfResult order_scene( RfGltf* gltf, int index, int* depth )
{
    RfWhere where = rf_where( "scenes[%d]", index );
    const json_t* roots = NULL;
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_SCENES, index );
    RfResult result = rf_gltf_get_array( gltf, json, where.text, "nodes", &roots );
    gltf->order_count = 0;
    for ( int i = 0; i < gltf->scene->node_count; ++i )
        depth[i] = -1;
    for ( size_t i = 0; result == RF_OK && i < json_array_size( roots ); ++i )
    {
        int root = 0;
        result = read_node_index( gltf, roots, i, where.text, "nodes", &root );
        if ( result != RF_OK )
            break;
        if ( gltf->scene->nodes[root].parent >= 0 || depth[root] == 0 )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text,
                                 "nodes[%zu] is node %d, which is not a root or listed "
                                 "twice",
                                 i, root );
        depth[root] = 0;
        gltf->order[gltf->order_count++] = root;
    }
    return result == RF_OK ? append_descendants( gltf, 0, gltf->order, &gltf->order_count, depth ) : result;
}

static RfResult order_nodes( RfGltf* gltf, int* depth )
{
    RfResult result = order_all( gltf, gltf->order, &gltf->order_count, depth );
    if ( result != RF_OK )
        return result;
    int scene;
    result = rf_gltf_get_index( gltf, gltf->root, "document", "scene", RF_GLTF_SCENES, &scene );
    if ( result != RF_OK )
        return result;
    // without scenes, everything in the file is shown
    if ( gltf->counts[RF_GLTF_SCENES] == 0 )
        return RF_OK;
    return order_scene( gltf, scene >= 0 ? scene : 0, depth );
}

RfResult rf_gltf_load_nodes( RfGltf* gltf )
{
    int count = gltf->counts[RF_GLTF_NODES];
    RfNode* nodes = calloc( (size_t)count + 1, sizeof *nodes );
    int* depth = calloc( (size_t)count + 1, sizeof *depth );
    gltf->order = calloc( (size_t)count + 1, sizeof *gltf->order );
    gltf->scene->nodes = nodes;
    gltf->scene->node_count = nodes != NULL ? count : 0;
    RfResult result = RF_OK;
    if ( nodes == NULL || depth == NULL || gltf->order == NULL )
        result = rf_gltf_no_memory( gltf, "nodes" );
    for ( int i = 0; result == RF_OK && i < count; ++i )
    {
        nodes[i].parent = -1;
        result = load_node( gltf, i );
    }
    for ( int i = 0; result == RF_OK && i < count; ++i )
        result = link_children( gltf, i );
    if ( result == RF_OK )
        result = order_nodes( gltf, depth );
    free( depth );
    return result;
}

// Animations: the channels of all of them merged into one list sorted by node, and the time
// span in which each node moves.

// Numbers in all channels, 1 GiB: channels may share samplers, so a small file could otherwise
// request any amount.
#define MAX_VALUES ( (uint64_t)1 << 27 )

typedef struct Loader
{
    int capacity;
    uint64_t values;
    uint8_t* taken; // per node: one bit per animated property
} Loader;

static RfResult read_times( RfGltf* gltf, int index, const char* where, RfChannel* channel )
{
    const RfGltfAccessor* accessor = gltf->accessors + index;
    channel->times = malloc( (size_t)channel->count * sizeof *channel->times );
    if ( channel->times == NULL )
        return rf_gltf_no_memory( gltf, where );
    if ( accessor->component_type != 5126 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "input accessors[%d] must be floats", index );
    double last = -1.0;
    for ( int i = 0; i < channel->count; ++i )
    {
        float time;
        RfResult result = rf_gltf_read_floats( gltf, index, (uint32_t)i, &time );
        if ( result != RF_OK )
            return result;
        if ( time < 0.0f || (double)time <= last )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where,
                                 "input accessors[%d], key %d is at %g s: times must be at "
                                 "least 0 and increase",
                                 index, i, (double)time );
        last = channel->times[i] = (double)time;
    }
    return RF_OK;
}

static RfResult check_rotation( const RfGltf* gltf, const char* where, const RfChannel* channel, int element, double* q )
{
    // tangents are not unit quaternions
    if ( channel->path != RF_ROTATION || ( channel->interpolation == RF_CUBICSPLINE && element % 3 != 1 ) )
        return RF_OK;
    double length = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] );
    if ( ( length > 1e-6 && length < 1e6 ) == false )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "output %d is not a unit quaternion", element );
    // the tangents of a spline belong to unnormalised values: it is normalised after interpolation
    for ( int i = 0; i < 4 && channel->interpolation != RF_CUBICSPLINE; ++i )
        q[i] /= length;
    return RF_OK;
}

static RfResult read_values( RfGltf* gltf, int index, const char* where, RfChannel* channel )
{
    const RfGltfAccessor* accessor = gltf->accessors + index;
    int per_key = channel->interpolation == RF_CUBICSPLINE ? 3 : 1;
    int components = channel->path == RF_ROTATION ? 4 : 3;
    int64_t elements = (int64_t)channel->count * per_key;
    RfResult result = rf_gltf_expect( gltf, index, accessor, where, components );
    if ( result != RF_OK )
        return result;
    if ( accessor->count != elements )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "output accessors[%d] has %u elements, %lld are needed", index,
                             accessor->count, (long long)elements );
    channel->values = malloc( (size_t)elements * (size_t)components * sizeof *channel->values );
    if ( channel->values == NULL )
        return rf_gltf_no_memory( gltf, where );
    for ( int i = 0; result == RF_OK && i < elements; ++i )
    {
        float value[4];
        double* out = channel->values + (size_t)i * (size_t)components;
        result = rf_gltf_read_floats( gltf, index, (uint32_t)i, value );
        for ( int c = 0; result == RF_OK && c < components; ++c )
            out[c] = (double)value[c];
        if ( result == RF_OK )
            result = check_rotation( gltf, where, channel, i, out );
    }
    return result;
}

static RfResult read_interpolation( const RfGltf* gltf, const json_t* json, const char* where, RfInterpolation* out )
{
    static const char* const s_names[] = { "STEP", "LINEAR", "CUBICSPLINE" };
    const char* name = "LINEAR";
    RfResult result = rf_gltf_get_string( gltf, json, where, "interpolation", &name );
    if ( result != RF_OK )
        return result;
    for ( int i = 0; i < 3; ++i )
    {
        if ( strcmp( name, s_names[i] ) == 0 )
        {
            *out = (RfInterpolation)i;
            return RF_OK;
        }
    }
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "interpolation '%.20s' must be STEP, LINEAR or CUBICSPLINE", name );
}

static RfResult read_sampler( RfGltf* gltf, Loader* loader, const json_t* json, const char* where, RfChannel* channel )
{
    int input = -1, output = -1;
    const RfGltfAccessor *times = NULL, *values = NULL;
    RfResult result = read_interpolation( gltf, json, where, &channel->interpolation );
    if ( result == RF_OK )
        result = rf_gltf_require( gltf, json, where, "input" );
    if ( result == RF_OK )
        result = rf_gltf_require( gltf, json, where, "output" );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, json, where, "input", RF_GLTF_ACCESSORS, &input );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, json, where, "output", RF_GLTF_ACCESSORS, &output );
    if ( result == RF_OK )
        result = rf_gltf_open_accessor( gltf, input, &times );
    if ( result == RF_OK )
        result = rf_gltf_expect( gltf, input, times, where, 1 );
    if ( result == RF_OK )
        result = rf_gltf_open_accessor( gltf, output, &values );
    if ( result != RF_OK )
        return result;

    loader->values += (uint64_t)times->count + (uint64_t)values->count * (uint64_t)values->components;
    if ( loader->values > MAX_VALUES )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %llu numbers in the animations: bake fewer keys",
                             (unsigned long long)MAX_VALUES );
    channel->count = (int)times->count;
    result = read_times( gltf, input, where, channel );
    return result == RF_OK ? read_values( gltf, output, where, channel ) : result;
}

// Reads which node and property the channel animates, and whether it is supported.
static RfResult read_target( RfGltf* gltf, const json_t* json, const char* where, RfChannel* channel, bool* wanted )
{
    const json_t* target = NULL;
    const char* path = "";
    *wanted = false;
    RfResult result = rf_gltf_require( gltf, json, where, "target" );
    if ( result == RF_OK )
        result = rf_gltf_get_object( gltf, json, where, "target", &target );
    if ( result == RF_OK )
        result = rf_gltf_require( gltf, target, where, "path" );
    if ( result == RF_OK )
        result = rf_gltf_get_string( gltf, target, where, "path", &path );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, target, where, "node", RF_GLTF_NODES, &channel->node );
    if ( result != RF_OK )
        return result;

    if ( strcmp( path, "pointer" ) == 0 )
        rf_gltf_notice( gltf, RF_GLTF_POINTER_CHANNELS, "KHR_animation_pointer is not supported: what %s moves stands still",
                        where );
    else if ( strcmp( path, "weights" ) == 0 )
        rf_gltf_notice( gltf, RF_GLTF_WEIGHT_CHANNELS, "morph targets are not supported: what %s moves stands still", where );
    else
    {
        static const char* const s_paths[] = { "translation", "rotation", "scale" };
        int i = 0;
        while ( i < 3 && strcmp( path, s_paths[i] ) != 0 )
            ++i;
        if ( i == 3 )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "target.path '%.20s' does not exist", path );
        channel->path = (RfAnimatedPath)i;
        // without a node, an extension defines the target
        *wanted = channel->node >= 0;
    }
    return RF_OK;
}

static RfResult check_target( RfGltf* gltf, Loader* loader, const char* where, const RfChannel* channel, bool* wanted )
{
    const RfNode* node = gltf->scene->nodes + channel->node;
    if ( node->has_matrix )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "moves nodes[%d], which has a matrix", channel->node );
    uint8_t bit = (uint8_t)( 1u << channel->path );
    if ( ( loader->taken[channel->node] & bit ) != 0 )
    {
        rf_gltf_notice( gltf, RF_GLTF_DOUBLE_CHANNELS, "%s moves node '%.80s', which an earlier channel moves: the first is used",
                        where, node->name );
        *wanted = false;
    }
    loader->taken[channel->node] |= bit;
    return RF_OK;
}

static RfResult append_channel( RfGltf* gltf, Loader* loader, const RfChannel* channel )
{
    RfScene* scene = gltf->scene;
    if ( scene->channel_count == loader->capacity )
    {
        int capacity = loader->capacity > 0 ? loader->capacity * 2 : 8;
        RfChannel* grown = realloc( scene->channels, (size_t)capacity * sizeof *grown );
        if ( grown == NULL )
            return rf_gltf_no_memory( gltf, "animations" );
        scene->channels = grown;
        loader->capacity = capacity;
    }
    scene->channels[scene->channel_count++] = *channel;
    return RF_OK;
}

static RfResult load_channel( RfGltf* gltf, Loader* loader, const json_t* json, const json_t* samplers, int animation,
                              size_t index )
{
    RfWhere where = rf_where( "animations[%d].channels[%zu]", animation, index );
    if ( json_is_object( json ) == 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "must be an object" );
    RfChannel channel = { 0 };
    bool wanted;
    RfResult result = read_target( gltf, json, where.text, &channel, &wanted );
    if ( result == RF_OK && wanted )
        result = check_target( gltf, loader, where.text, &channel, &wanted );
    if ( result != RF_OK || wanted == false )
        return result;

    int64_t sampler = -1;
    result = rf_gltf_require( gltf, json, where.text, "sampler" );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, where.text, "sampler", 0, (int64_t)json_array_size( samplers ) - 1, &sampler );
    if ( result != RF_OK )
        return result;
    RfWhere self = rf_where( "animations[%d].samplers[%lld]", animation, (long long)sampler );
    const json_t* sampler_json = json_array_get( samplers, (size_t)sampler );
    if ( json_is_object( sampler_json ) == 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, self.text, "must be an object" );
    result = read_sampler( gltf, loader, sampler_json, self.text, &channel );
    if ( result == RF_OK )
        result = append_channel( gltf, loader, &channel );
    if ( result != RF_OK )
    {
        free( channel.times );
        free( channel.values );
    }
    return result; // NOLINT(clang-analyzer-unix.Malloc): append_channel does not fail with RF_OK
}

static RfResult load_animation( RfGltf* gltf, Loader* loader, int index )
{
    RfWhere where = rf_where( "animations[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_ANIMATIONS, index );
    const json_t *channels = NULL, *samplers = NULL;
    RfResult result = rf_gltf_get_array( gltf, json, where.text, "channels", &channels );
    if ( result == RF_OK )
        result = rf_gltf_get_array( gltf, json, where.text, "samplers", &samplers );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( channels ); ++i )
        result = load_channel( gltf, loader, json_array_get( channels, i ), samplers, index, i );
    return result;
}

static int compare_channels( const void* a, const void* b )
{
    const RfChannel *left = a, *right = b;
    if ( left->node != right->node )
        return left->node < right->node ? -1 : 1;
    return (int)left->path - (int)right->path;
}

static void widen( RfGltfSpan* span, double start, double end )
{
    span->start = fmin( span->start, start );
    span->end = fmax( span->end, end );
}

static RfResult find_spans( RfGltf* gltf )
{
    const RfScene* scene = gltf->scene;
    gltf->spans = malloc( ( (size_t)scene->node_count + 1 ) * sizeof *gltf->spans );
    if ( gltf->spans == NULL )
        return rf_gltf_no_memory( gltf, "animations" );
    for ( int i = 0; i < scene->node_count; ++i )
        gltf->spans[i] = ( RfGltfSpan ){ INFINITY, -INFINITY };
    for ( int i = 0; i < scene->channel_count; ++i )
    {
        const RfChannel* channel = scene->channels + i;
        widen( gltf->spans + channel->node, channel->times[0], channel->times[channel->count - 1] );
    }
    // parents come first, so one pass propagates all ancestors
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        int node = gltf->order[i], parent = scene->nodes[node].parent;
        if ( parent >= 0 )
            widen( gltf->spans + node, gltf->spans[parent].start, gltf->spans[parent].end );
    }
    return RF_OK;
}

RfResult rf_gltf_load_animations( RfGltf* gltf )
{
    Loader loader = { .taken = calloc( (size_t)gltf->scene->node_count + 1, 1 ) };
    if ( loader.taken == NULL )
        return rf_gltf_no_memory( gltf, "animations" );
    RfResult result = RF_OK;
    for ( int i = 0; result == RF_OK && i < gltf->counts[RF_GLTF_ANIMATIONS]; ++i )
        result = load_animation( gltf, &loader, i );
    free( loader.taken );
    if ( result != RF_OK )
        return result;
    if ( gltf->scene->channel_count > 0 )
        qsort( gltf->scene->channels, (size_t)gltf->scene->channel_count, sizeof( RfChannel ), compare_channels );
    return find_spans( gltf );
}
