// EXT_mesh_gpu_instancing: a node that instances its mesh many times, with accessors for
// translation, rotation and scale.
#include "scene/gltf/gltf_geometry.h"

#include <math.h>

#define EXTENSION "EXT_mesh_gpu_instancing"

static RfResult open_attribute( RfGltf* gltf, const RfField* attributes, const char* where, const char* key, int components,
                                int* index, uint32_t* count )
{
    const RfGltfAccessor* accessor;
    *index = rf_gltf_get_index( gltf, attributes, key, RF_GLTF_ACCESSORS );
    RfResult result = *index >= 0 ? rf_gltf_open_accessor( gltf, *index, &accessor ) : rf_json_result( attributes );
    if ( result != RF_OK || *index < 0 )
        return result;
    result = rf_gltf_expect( gltf, *index, accessor, where, components );
    if ( result == RF_OK && *count != 0 && *count != accessor->count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s has %u elements, the attribute before it %u", key, accessor->count,
                             *count );
    *count = accessor->count;
    return result;
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
    RfResult result = read_doubles( gltf, instances->scale, element, 3, s );
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
