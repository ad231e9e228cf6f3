// Primitives without normals that need tangents: every triangle gets three vertices of its own
// with the face normal, as the specification requires. (Other primitives get face normals in
// gltf_bake.c.)

#include "scene/gltf/gltf_geometry.h"

#include <math.h>
#include <stdlib.h>

// Expands an attribute of `components` numbers to one value per corner.
static bool spread( float** values, size_t components, const RfGltfPrimitive* p )
{
    if ( *values == NULL )
        return true;
    size_t corners = 3 * (size_t)p->triangle_count;
    float* out = malloc( ( corners * components + 1 ) * sizeof *out );
    if ( out == NULL )
        return false;
    for ( size_t i = 0; i < corners * components; ++i )
        out[i] = ( *values )[p->indices[i / components] * components + i % components];
    free( *values );
    *values = out;
    return true;
}

// Zero for a degenerate triangle, which is dropped later.
static void face_normal( const float* a, float out[9] )
{
    double u[3], v[3];
    for ( int i = 0; i < 3; ++i )
    {
        u[i] = (double)a[3 + i] - (double)a[i];
        v[i] = (double)a[6 + i] - (double)a[i];
    }
    double n[3] = { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
    double length = sqrt( n[0] * n[0] + n[1] * n[1] + n[2] * n[2] );
    for ( int i = 0; i < 9; ++i )
        out[i] = length > 0.0 ? (float)( n[i % 3] / length ) : 0.0f;
}

RfResult rf_gltf_make_flat( const RfGltf* gltf, const char* where, RfGltfPrimitive* p )
{
    size_t corners = 3 * (size_t)p->triangle_count;
    p->normals = malloc( ( 3 * corners + 1 ) * sizeof *p->normals );
    if ( p->normals == NULL || !spread( &p->positions, 3, p ) || !spread( &p->uvs, 2, p ) || !spread( &p->uvs1, 2, p ) ||
         !spread( &p->colors, 4, p ) )
        return rf_gltf_no_memory( gltf, where );
    for ( size_t i = 0; i < corners; ++i )
        p->indices[i] = (uint32_t)i;
    for ( size_t t = 0; t < p->triangle_count; ++t )
        face_normal( p->positions + 9 * t, p->normals + 9 * t );
    p->vertex_count = (uint32_t)corners;
    return RF_OK;
}
