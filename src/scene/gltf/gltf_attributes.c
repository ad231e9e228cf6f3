// Bakes the other vertex attributes: texture coordinates, colours, tangents.

#include "scene/gltf/gltf_geometry.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

// Allocates an attribute when the first mesh has it; vertices before it get `fill`.
static RfResult reserve_attribute( const RfGltf* gltf, const RfGltfBaker* baker, const char* where, const float* needed,
                                   int components, float fill, float** all )
{
    if ( needed == NULL || *all != NULL )
        return RF_OK;
    size_t count = (size_t)baker->vertex_capacity * (size_t)components;
    *all = malloc( ( count + 1 ) * sizeof **all );
    if ( *all == NULL )
        return rf_gltf_no_memory( gltf, where );
    for ( size_t i = 0; i < count; ++i )
        ( *all )[i] = fill;
    return RF_OK;
}

RfResult rf_gltf_reserve_attributes( const RfGltf* gltf, const RfGltfBaker* baker, const RfGltfPrimitive* primitive,
                                     const char* where )
{
    RfTriangles* t = &gltf->scene->triangles;
    RfResult result = reserve_attribute( gltf, baker, where, primitive->uvs, 2, 0.0f, &t->uvs );
    if ( result == RF_OK )
        result = reserve_attribute( gltf, baker, where, primitive->uvs1, 2, 0.0f, &t->uvs1 );
    if ( result == RF_OK )
        result = reserve_attribute( gltf, baker, where, primitive->colors, 4, 1.0f, &t->colors );
    if ( result == RF_OK )
        result = reserve_attribute( gltf, baker, where, primitive->tangents, 4, 0.0f, &t->tangents );
    return result;
}

static void copy_attribute( float* all, const float* values, int components, float fill, uint32_t to, uint32_t from )
{
    if ( all == NULL )
        return;
    for ( size_t i = 0, n = (size_t)components; i < n; ++i )
        all[n * to + i] = values != NULL ? values[n * from + i] : fill;
}

void rf_gltf_copy_attributes( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from )
{
    copy_attribute( t->uvs, primitive->uvs, 2, 0.0f, to, from );
    copy_attribute( t->uvs1, primitive->uvs1, 2, 0.0f, to, from );
    copy_attribute( t->colors, primitive->colors, 4, 1.0f, to, from );
    copy_attribute( t->tangents, NULL, 4, 0.0f, to, from );
}

// Transforms a tangent to world space and normalises it. If the matrix collapses it, its sign
// is 0 (no tangent). A mirroring matrix flips the bitangent.
void rf_gltf_transform_tangent( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from,
                                const RfMat4* matrix, double sign )
{
    if ( primitive->tangents == NULL )
        return;
    const float* tangent = primitive->tangents + 4 * (size_t)from;
    float* out = t->tangents + 4 * (size_t)to;
    double local[3] = { (double)tangent[0], (double)tangent[1], (double)tangent[2] }, placed[3];
    rf_mat4_apply( matrix, local, 0.0, placed );
    double length = sqrt( placed[0] * placed[0] + placed[1] * placed[1] + placed[2] * placed[2] );
    bool usable = length > 0.0 && length <= DBL_MAX;
    for ( int i = 0; i < 3; ++i )
        out[i] = usable ? (float)( placed[i] / length ) : 0.0f;
    out[3] = !usable ? 0.0f : (float)( ( tangent[3] < 0.0f ? -1.0 : 1.0 ) * sign );
}
