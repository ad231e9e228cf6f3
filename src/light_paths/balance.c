// Balance weights of connections against scattered rays that come through mirrors and glass to the same emitter by chance
// (src/reuse/estimators.md, section 16).
#include "light_paths/connections_internal.h"

float rf_chance_area( const RfLightPaths* paths, const RfChain* chain, float area, float steer_pdf, RfVec3 p )
{
    const RfEmission* e = &chain->start;
    RfVec3 meet, m[2];
    if ( e->infinite || e->delta_position )
        return 0.0f;
    if ( !rf_meet_plane( &chain->end, p, chain->end.d, &meet, m ) )
        return INFINITY;
    float spread = fabsf( rf_dot( rf_cross( m[0], m[1] ), chain->end.d ) ), cosine = rf_dot( e->normal, e->direction );
    float starts = e->pdf_light * e->pdf_area * spread / rf_maxf( cosine, 1e-6f ); // per solid angle at p
    float connections = (float)paths->emitted * area * steer_pdf * starts;
    return connections > 0.0f ? 1.0f / connections : INFINITY;
}
