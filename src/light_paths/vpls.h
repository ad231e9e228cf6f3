// VPLs: where light paths land and scatter. Particles go on from there; an eye vertex in the footprint of a particle is
// connected to its VPL. src/reuse/estimators.md, section 16.
#ifndef REFRAME_LIGHT_PATHS_VPLS_H
#define REFRAME_LIGHT_PATHS_VPLS_H

#include "light_paths/light_paths.h"
#include "path/wavefront.h"

#define RF_SCATTERED_PER_PATH 2u
#define RF_VPL_CONNECTIONS 3.0f // that a point finds, on average

// The bytes of the particles of n light paths, and their layout in memory of that size.
size_t rf_scattered_bytes( size_t n );
void rf_lay_out_scattered( RfLightPaths* paths, void* memory );

// Sets path->VPL from where its chain, that of lane `i`, landed.
void rf_set_vpl( const RfTracer* tracer, const RfLightPaths* paths, const RfChain* chain, const RfLanding* land, int i,
                 RfLightPath* path );

// Whether VPLs are connected where a chain ends. Not inside of bodies, where flux and radiance scale differently, and nowhere
// if rays pass surfaces by chance.
static inline bool rf_may_scatter( const RfTracer* tracer, const RfChain* chain )
{
    return !chain->ends_inside && !rf_tracer_has_panes( tracer ) && !rf_tracer_is_blended( tracer );
}

// Draws what the stored paths scatter. Returns the rays traced.
uint64_t rf_scatter_light_paths( const RfEstimatorGroup* group, RfLightPaths* paths, uint64_t pass_key );

// Where rays start at the VPL.
static inline RfVec3 rf_vpl_start( const RfLightPath* path ) { return rf_madd( path->at.p, path->vpl.ng, path->vpl.offset ); }

// The squared sine of the cone around the way to a point, which leaves the VPL at this cosine: particles whose direction
// lies in it cover the point. With one over the cosine as many connections are found everywhere.
static inline float rf_vpl_cone( const RfLightPaths* paths, float cosine )
{
    return paths->vpl_connections / ( (float)RF_SCATTERED_PER_PATH * rf_maxf( cosine, RF_LEAST_VPL_COSINE ) );
}

// The footprints of particles: points further away are not covered. `hit`: where they landed.
float rf_scattered_radius( const RfLightPaths* paths, const RfLightPath* path, RfVec3 hit, RfVec3 ng );

#endif
