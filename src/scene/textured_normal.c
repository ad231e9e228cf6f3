// Shading normals of surfaces and clear coats from normal textures.

#include "scene/textured_lookup.h"

#include <math.h>
#include <string.h>

// True if the vertex tangents belong to this use of a texture. They belong to the normal
// texture of the surface or, without one, to that of the coat.
static bool has_vertex_tangents( const RfScene* scene, const RfTextured* textured, const RfTextureRef* ref )
{
    const RfTextureRef* of = textured->refs + RF_TEXTURE_NORMAL;
    if ( scene->triangles.tangents == NULL )
        return false;
    // the bits of the same file: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    return of->texture < 0 || ( of->uv_set == ref->uv_set && memcmp( of->transform, ref->transform, sizeof of->transform ) == 0 );
}

// Tangent and bitangent, from the vertex tangents or else from the texture coordinates.
static bool find_tangents( const RfScene* scene, const RfTextured* textured, const RfTextureRef* ref, uint32_t triangle, float u,
                           float v, RfVec3 n, RfVec3* tangent, RfVec3* bitangent )
{
    const RfTriangles* t = &scene->triangles;
    const uint32_t* corners = t->indices + 3 * (size_t)triangle;
    RfVec3 along;
    float sign = 0.0f;
    if ( has_vertex_tangents( scene, textured, ref ) )
    {
        float given[4];
        rf_interpolate_corners( t->tangents, 4, corners, u, v, given );
        along = rf_vec3( given[0], given[1], given[2] );
        sign = given[3];
    }
    if ( sign == 0.0f )
    {
        float a[2], b[2], c[2], p[3][3];
        rf_texture_coordinates( scene, ref, triangle, 0.0f, 0.0f, a );
        rf_texture_coordinates( scene, ref, triangle, 1.0f, 0.0f, b );
        rf_texture_coordinates( scene, ref, triangle, 0.0f, 1.0f, c );
        for ( int i = 0; i < 3; ++i )
            rf_interpolate_corners( t->positions, 3, corners, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f, p[i] );
        RfVec3 e1 = rf_vec3( p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2] );
        RfVec3 e2 = rf_vec3( p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2] );
        float du1 = b[0] - a[0], dv1 = b[1] - a[1], du2 = c[0] - a[0], dv2 = c[1] - a[1];
        float det = du1 * dv2 - du2 * dv1;
        if ( !( fabsf( det ) > 0.0f ) )
            return false;
        // v' points down the image and the bitangent up: for det < 0 it is n × t
        along = rf_scale( rf_sub( rf_scale( e1, dv2 ), rf_scale( e2, dv1 ) ), det < 0.0f ? -1.0f : 1.0f );
        sign = det < 0.0f ? 1.0f : -1.0f;
    }
    along = rf_madd( along, n, -rf_dot( along, n ) );
    float length2 = rf_dot( along, along );
    if ( !( length2 > 0.0f && length2 < INFINITY ) )
        return false;
    *tangent = rf_scale( along, 1.0f / sqrtf( length2 ) );
    *bitangent = rf_scale( rf_cross( n, *tangent ), sign < 0.0f ? -1.0f : 1.0f );
    return true;
}

static RfVec3 mapped_normal( const RfScene* scene, const RfMaterial* m, RfTextureSlot slot, float scale, uint32_t triangle,
                             float u, float v, RfVec3 n, RfVec3 ng )
{
    float rgba[4];
    RfVec3 tangent, bitangent;
    if ( !rf_look_up_slot( scene, m, slot, triangle, u, v, rgba ) ||
         !find_tangents( scene, m->textured, m->textured->refs + slot, triangle, u, v, n, &tangent, &bitangent ) )
        return n;
    float x = ( 2.0f * rgba[0] - 1.0f ) * scale, y = ( 2.0f * rgba[1] - 1.0f ) * scale;
    RfVec3 mapped = rf_madd( rf_madd( rf_scale( n, 2.0f * rgba[2] - 1.0f ), tangent, x ), bitangent, y );
    float length2 = rf_dot( mapped, mapped );
    if ( !( length2 > 1e-12f ) )
        return n;
    mapped = rf_scale( mapped, 1.0f / sqrtf( length2 ) );
    // a normal that points below the surface is raised to the horizon
    float above = rf_dot( mapped, ng );
    return above > 1e-3f ? mapped : rf_normalize( rf_madd( mapped, ng, 2e-3f - above ) );
}

RfVec3 rf_normal_at( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, RfVec3 n, RfVec3 ng )
{
    return mapped_normal( scene, m, RF_TEXTURE_NORMAL, m->textured->normal_scale, triangle, u, v, n, ng );
}

RfVec3 rf_coat_normal_at( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, RfVec3 n, RfVec3 ng )
{
    return mapped_normal( scene, m, RF_TEXTURE_CLEARCOAT_NORMAL, m->textured->clearcoat_normal_scale, triangle, u, v, n, ng );
}
