#include "trace/filter.h"

#include "base/random.h"
#include "scene/textured.h"

// Offsets of the fields in Embree's packets (the accessors of its header are C++ only).
enum
{
    RAY_ORIGIN = 0,
    RAY_DIRECTION = 4,
    RAY_ID = 10,
    HIT_U = 3,
    HIT_V = 4,
    HIT_NUMBER = 5,
};

static uint32_t ray_bits( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    return ( (const uint32_t*)(const void*)args->ray )[row * args->N + lane];
}

// Uniform in [0, 1), a hash of the ray and the triangle.
static float random_of_ray( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle )
{
    uint32_t hash = rf_mix32( triangle + 0x9e3779b9u );
    for ( unsigned int c = 0; c < 3; ++c )
    {
        hash = rf_mix32( hash ^ ray_bits( args, RAY_ORIGIN + c, lane ) );
        hash = rf_mix32( hash ^ ray_bits( args, RAY_DIRECTION + c, lane ) );
    }
    return (float)( hash >> 8 ) * 0x1p-24f;
}

// Decides stochastically whether the ray hits a blended surface.
static bool hits_blended( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle, float opacity )
{
    RfQuery* query = (RfQuery*)args->context;
    if ( !query->segments )
        return random_of_ray( args, lane, triangle ) < opacity;
    float* left = query->transmittance + ray_bits( args, RAY_ID, lane );
    *left *= 1.0f - opacity;
    return *left <= 0.0f;
}

void rf_filter_hits( const struct RTCFilterFunctionNArguments* args )
{
    const RfBvh* bvh = args->geometryUserPtr;
    const RfScene* scene = bvh->scene;
    const float* u = (const float*)(const void*)args->hit + HIT_U * args->N;
    const float* v = (const float*)(const void*)args->hit + HIT_V * args->N;
    const unsigned int* number = (const unsigned int*)(const void*)args->hit + HIT_NUMBER * args->N;
    for ( unsigned int i = 0; i < args->N; ++i )
    {
        if ( args->valid[i] == 0 )
            continue;
        uint32_t triangle = bvh->order[bvh->masked_first + number[i]];
        const RfMaterial* material = scene->materials + scene->triangles.material[triangle];
        float opacity = rf_opacity_at( scene, material, triangle, u[i], v[i] );
        if ( opacity <= 0.0f || ( opacity < 1.0f && !hits_blended( args, i, triangle, opacity ) ) )
            args->valid[i] = 0;
    }
}
