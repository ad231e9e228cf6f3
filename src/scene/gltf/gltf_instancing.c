// EXT_mesh_gpu_instancing: a node that instances its mesh many times, with accessors for
// translation, rotation and scale.
#include "scene/gltf/gltf_geometry.h"

#include <math.h>

#define EXTENSION "EXT_mesh_gpu_instancing"

static RfResult open_attribute( RfGltf* gltf, const json_t* attributes, const char* where, const char* key, int components,
                                int* index, uint32_t* count )
{
    RfResult result = rf_gltf_get_index( gltf, attributes, where, key, RF_GLTF_ACCESSORS, index );
    if ( result != RF_OK || *index < 0 )
        return result;
    const RfGltfAccessor* accessor;
    result = rf_gltf_open_accessor( gltf, *index, &accessor );
    if ( result == RF_OK )
        result = rf_gltf_expect( gltf, *index, accessor, where, components );
    if ( result != RF_OK )
        return result;
    if ( *count != 0 && *count != accessor->count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s has %u elements, the attribute before it %u", key, accessor->count,
                             *count );
    *count = accessor->count;
    return RF_OK;
}

RfResult rf_gltf_open_instances( RfGltf* gltf, int node, RfGltfInstances* out )
{
    *out = ( RfGltfInstances ){ .count = 1, .translation = -1, .rotation = -1, .scale = -1 };
    RfWhere where = rf_where( "nodes[%d]", node );
    const json_t *json, *attributes = NULL;
    RfResult result = rf_gltf_get_extension( gltf, rf_gltf_item( gltf, RF_GLTF_NODES, node ), where.text, EXTENSION, &json );
    if ( result != RF_OK || json == NULL )
        return result;
    where = rf_where( "nodes[%d].extensions." EXTENSION, node );
    uint32_t count = 0;
    result = rf_gltf_require( gltf, json, where.text, "attributes" );
    if ( result == RF_OK )
        result = rf_gltf_get_object( gltf, json, where.text, "attributes", &attributes );
    if ( result == RF_OK )
        result = open_attribute( gltf, attributes, where.text, "TRANSLATION", 3, &out->translation, &count );
    if ( result == RF_OK )
        result = open_attribute( gltf, attributes, where.text, "ROTATION", 4, &out->rotation, &count );
    if ( result == RF_OK )
        result = open_attribute( gltf, attributes, where.text, "SCALE", 3, &out->scale, &count );
    if ( result == RF_OK && count == 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "must have at least one of TRANSLATION, ROTATION and SCALE" );
    out->count = count;
    return result;
}

static RfResult read_doubles( const RfGltf* gltf, int accessor, uint32_t element, int count, double* values )
{
    float floats[4];
    if ( accessor < 0 )
        return RF_OK;
    RfResult result = rf_gltf_read_floats( gltf, accessor, element, floats );
    for ( int i = 0; result == RF_OK && i < count; ++i )
        values[i] = (double)floats[i];
    return result;
}

RfResult rf_gltf_instance_matrix( const RfGltf* gltf, const RfGltfInstances* instances, uint32_t element, RfMat4* matrix )
{
    double t[3] = { 0 }, q[4] = { 0, 0, 0, 1 }, s[3] = { 1, 1, 1 };
    RfResult result = read_doubles( gltf, instances->translation, element, 3, t );
    if ( result == RF_OK )
        result = read_doubles( gltf, instances->rotation, element, 4, q );
    if ( result == RF_OK )
        result = read_doubles( gltf, instances->scale, element, 3, s );
    if ( result != RF_OK )
        return result;
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
