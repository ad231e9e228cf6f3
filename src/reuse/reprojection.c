#include "reuse/reprojection.h"

#include "scene/pinhole.h"

void rf_project_batch( const RfEye* eye_in, const RfHitBatch* batch, int32_t* restrict pixel, float* restrict density )
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

void rf_own_densities( const RfEye* eye, const RfHitBatch* batch, float* density )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        RfVec3 p = rf_vec3( batch->p[0][i], batch->p[1][i], batch->p[2][i] );
        RfVec3 ng = rf_vec3( batch->ng[0][i], batch->ng[1][i], batch->ng[2][i] );
        density[i] = rf_project( eye, p, ng ).density;
    }
}
