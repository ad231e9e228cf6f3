#include "reuse/reprojection.h"

#include "reuse/coats.h"
#include "reuse/mirrored.h"
#include "scene/pinhole.h"

// Lanes without a filter of their own.
static void clear_filter( const RfHitBatch* batch, float* const filter[3] )
{
    for ( int c = 0; c < 3 && filter != NULL; ++c )
    {
        for ( int i = 0; i < batch->count; ++i )
            filter[c][i] = 1.0f;
    }
}

// Straight ways to the eye.
static void project( const RfEye* eye_in, const RfHitBatch* batch, int32_t* restrict pixel, float* restrict density )
{
    RfEye eye = *eye_in;
    const float* restrict px = batch->p[0];
    const float* restrict py = batch->p[1];
    const float* restrict pz = batch->p[2];
    const float* restrict nx = batch->ng[0];
    const float* restrict ny = batch->ng[1];
    const float* restrict nz = batch->ng[2];
#pragma omp simd
    for ( int i = 0; i < batch->count; ++i )
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
#pragma omp simd
    for ( int i = 0; i < batch->count; ++i )
    {
        RfVec3 p = rf_vec3( batch->p[0][i], batch->p[1][i], batch->p[2][i] );
        RfProjection at = rf_project( &eye, p, rf_vec3( batch->ng[0][i], batch->ng[1][i], batch->ng[2][i] ) );
        u[i] = at.u;
        v[i] = at.v;
    }
}

void rf_project_batch( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, int32_t* pixel, float* density,
                       float* const filter[3], float* const offset[2] )
{
    project( eye, batch, pixel, density );
    if ( offset != NULL )
        project_places( eye, batch, offset[0], offset[1] );
    if ( !rf_has_views( batch ) )
        return;
    for ( int i = 0; i < batch->count; ++i )
        density[i] = rf_is_straight( batch->view[i] ) ? density[i] : 0.0f;
    clear_filter( batch, filter );
    rf_project_mirrored( mirrors, eye, batch, pixel, density, filter, offset );
    rf_weight_bases( batch, rf_pinhole_origin( eye ), density, filter );
}

void rf_own_densities( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, float* density,
                       float* const filter[3] )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        RfVec3 p = rf_vec3( batch->p[0][i], batch->p[1][i], batch->p[2][i] );
        RfVec3 ng = rf_vec3( batch->ng[0][i], batch->ng[1][i], batch->ng[2][i] );
        density[i] = rf_project( eye, p, ng ).density;
    }
    if ( !rf_has_views( batch ) )
        return;
    for ( int i = 0; i < batch->count; ++i )
        density[i] = rf_is_straight( batch->view[i] ) ? density[i] : 1.0f;
    clear_filter( batch, filter );
    rf_own_mirrored_densities( mirrors, eye, batch, density, filter );
    rf_weight_bases( batch, rf_pinhole_origin( eye ), density, filter );
}
