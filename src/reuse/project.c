// The hits of a batch as seen from another camera: their pixel and density, and the BSDF of glossy ones.
#include "reuse/project.h"

#include "reuse/chains/coats.h"
#include "scene/projection.h"

#include <string.h>

// Lanes without a filter of their own.
static void clear_filter( const RfHitBatch* batch, float* const filter[3] )
{
    for ( int c = 0; c < 3 && filter[0] != NULL; ++c )
    {
        for ( int i = 0; i < batch->count; ++i )
            filter[c][i] = 1.0f;
    }
}

static void project_lanes( const RfEye* eye, const RfHitBatch* batch, int32_t* pixel, float* density )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        RfProjection at = rf_project_any( eye, RF_GET3( batch->p, i ), RF_GET3( batch->ng, i ) );
        pixel[i] = at.y * eye->width + at.x;
        density[i] = at.seen ? at.density : 0.0f;
    }
}

// Straight ways to the camera.
static void project( const RfEye* eye_in, const RfHitBatch* batch, int32_t* restrict pixel, float* restrict density )
{
    RfEye eye = *eye_in;
    const float* restrict px = batch->p[0];
    const float* restrict py = batch->p[1];
    const float* restrict pz = batch->p[2];
    const float* restrict nx = batch->ng[0];
    const float* restrict ny = batch->ng[1];
    const float* restrict nz = batch->ng[2];
    int straight = rf_is_perspective( eye_in ) ? batch->count : 0;
    if ( straight == 0 )
        project_lanes( eye_in, batch, pixel, density );
#pragma omp simd
    for ( int i = 0; i < straight; ++i )
    {
        RfProjection at = rf_project( &eye, rf_vec3( px[i], py[i], pz[i] ), rf_vec3( nx[i], ny[i], nz[i] ) );
        pixel[i] = at.y * eye.width + at.x;
        density[i] = at.seen ? at.density : 0.0f;
    }
}

// The places in the pixels, apart from these: most renders need none.
static void project_places( const RfEye* eye_in, const RfHitBatch* batch, float* restrict u, float* restrict v )
{
    RfEye eye = *eye_in;
    int straight = rf_is_perspective( eye_in ) ? batch->count : 0;
#pragma omp simd
    for ( int i = 0; i < straight; ++i )
    {
        RfVec3 p = RF_GET3( batch->p, i );
        RfProjection at = rf_project( &eye, p, RF_GET3( batch->ng, i ) );
        u[i] = at.u;
        v[i] = at.v;
    }
    for ( int i = straight; i < batch->count; ++i )
    {
        RfVec3 p = RF_GET3( batch->p, i );
        RfProjection at = rf_project_any( eye_in, p, RF_GET3( batch->ng, i ) );
        u[i] = at.u;
        v[i] = at.v;
    }
}

void rf_project_batch( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out )
{
    project( eye, batch, out.pixel, out.density );
    if ( out.offset[0] != NULL )
        project_places( eye, batch, out.offset[0], out.offset[1] );
    if ( !rf_has_views( batch ) )
        return;
    for ( int i = 0; i < batch->count; ++i )
        out.density[i] = rf_is_straight( batch->view[i] ) ? out.density[i] : 0.0f;
    clear_filter( batch, out.filter );
    rf_project_mirrored( mirrors, eye, batch, out );
    rf_weight_bases( batch, eye, out.density, out.filter[0] != NULL ? out.filter : NULL );
}

void rf_own_densities( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out )
{
    int straight = rf_is_perspective( eye ) ? batch->count : 0;
    for ( int i = 0; i < straight; ++i )
    {
        RfVec3 p = RF_GET3( batch->p, i );
        RfVec3 ng = RF_GET3( batch->ng, i );
        out.density[i] = rf_project( eye, p, ng ).density;
    }
    for ( int i = straight; i < batch->count; ++i )
    {
        RfVec3 p = RF_GET3( batch->p, i );
        RfVec3 ng = RF_GET3( batch->ng, i );
        out.density[i] = rf_project_any( eye, p, ng ).density;
    }
    if ( !rf_has_views( batch ) )
        return;
    for ( int i = 0; i < batch->count; ++i )
        out.density[i] = rf_is_straight( batch->view[i] ) ? out.density[i] : 1.0f;
    clear_filter( batch, out.filter );
    rf_own_mirrored_densities( mirrors, eye, batch, out );
    rf_weight_bases( batch, eye, out.density, out.filter[0] != NULL ? out.filter : NULL );
}

void rf_directions_to( const RfMirrors* mirrors, const RfEye* at, int eye, const RfHitBatch* batch, float* const wo[3] )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    if ( eye == batch->eye )
    {
        for ( int c = 0; c < 3; ++c )
            memcpy( wo[c], batch->wo[c], (size_t)count * sizeof( float ) );
        return;
    }
    RfVec3 o = at->origin;
    const float* restrict px = batch->p[0] + first;
    const float* restrict py = batch->p[1] + first;
    const float* restrict pz = batch->p[2] + first;
    float* restrict x = wo[0];
    float* restrict y = wo[1];
    float* restrict z = wo[2];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 v = rf_sub( o, rf_vec3( px[i], py[i], pz[i] ) );
        float d2 = rf_dot( v, v );
        float scale = d2 > 0.0f ? 1.0f / sqrtf( d2 ) : 0.0f;
        x[i] = v.x * scale;
        y[i] = v.y * scale;
        z[i] = v.z * scale;
    }
    if ( rf_is_parallel( at ) )
    {
        RfVec3 back = rf_scale( rf_normalize( rf_parallel_direction( at ) ), -1.0f );
        for ( int i = 0; i < count; ++i )
        {
            x[i] = back.x;
            y[i] = back.y;
            z[i] = back.z;
        }
    }
    if ( rf_has_views( batch ) )
        rf_directions_to_image( mirrors, at, batch, wo );
}

void rf_evaluate_glossy( const RfHitBatch* b, const float* const wo[3], const float* const wi[3], float* const f[3],
                         float* pdf_solid_angle )
{
    int base = b->first[RF_BSDF_FIRST_GLOSSY];
    for ( int kind = RF_BSDF_FIRST_GLOSSY; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        int k = b->first[kind] - base, count = b->first[kind + 1] - b->first[kind];
        if ( count == 0 || !rf_is_model_built( (RfBsdfKind)kind ) )
            continue;
        RfBsdfLanes lanes = rf_bsdf_lanes( (RfBsdfKind)kind, (const float* const*)b->n, (const float* const*)b->param, k );
        const float* out_dir[3] = { wo[0] + k, wo[1] + k, wo[2] + k };
        const float* in_dir[3] = { wi[0] + k, wi[1] + k, wi[2] + k };
        if ( f != NULL )
        {
            float* out[3] = { f[0] + k, f[1] + k, f[2] + k };
            rf_bsdf_evaluate( (RfBsdfKind)kind, count, &lanes, out_dir, in_dir, out,
                              pdf_solid_angle != NULL ? pdf_solid_angle + k : NULL );
        }
        else
            rf_bsdf_evaluate( (RfBsdfKind)kind, count, &lanes, out_dir, in_dir, NULL, pdf_solid_angle + k );
    }
}
