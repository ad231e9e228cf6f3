// The other side of the balance weights: scattered rays that came to an emitter (src/reuse/estimators.md, section 16).
#include "light_paths/connections_internal.h"

// The chain of a trail, from a point of an emitter on. False: light does not go that way.
static bool follow_back( const RfTracer* tracer, const RfTrail* trail, int length, uint32_t emitter, RfVec3 point,
                         RfChain* chain )
{
    const RfTriangleRecord* triangles = rf_tracer_triangles( tracer );
    const RfLights* lights = rf_tracer_lights( tracer );
    const RfLight* light = lights->light + triangles[emitter].light;
    RfVec3 at[RF_MAX_CHAIN + 2]; // from the emitter on
    at[0] = point;
    at[length + 1] = trail->start;
    for ( int k = 0; k < length; ++k )
    {
        const RfTriangleRecord* t = triangles + trail->triangle[k];
        at[length - k] = rf_add( t->p0, rf_add( rf_scale( t->e1, trail->u[k] ), rf_scale( t->e2, trail->v[k] ) ) );
    }
    RfEmission e = { .position = point, .range = INFINITY, .light = triangles[emitter].light, .offset = light->offset };
    e.direction = rf_normalize( rf_sub( at[1], at[0] ) );
    e.normal = rf_dot( light->normal, e.direction ) < 0.0f ? rf_scale( light->normal, -1.0f ) : light->normal;
    rf_find_emission_pdf( lights, &e );
    *chain = ( RfChain ){ .start = e };
    rf_begin_chain( chain );
    for ( int k = 0; k < length; ++k )
    {
        const RfTriangleRecord* t = triangles + trail->triangle[length - 1 - k];
        RfVec3 in = rf_sub( at[k], at[k + 1] ), out = rf_sub( at[k + 2], at[k + 1] );
        bool refracted = ( rf_dot( in, t->ng ) < 0.0f ) != ( rf_dot( out, t->ng ) < 0.0f );
        chain->events |= (uint32_t)refracted << k;
        if ( !rf_step_chain( tracer, trail->triangle[length - 1 - k], trail->u[length - 1 - k], trail->v[length - 1 - k],
                             RF_CHAIN_COPY, ( RfRandomKey ){ 0, 0 }, chain ) )
            return false;
        chain->end.d = rf_normalize( out ); // where it went, not where rounding would lead
    }
    return true;
}

float rf_weigh_chance( const RfConnector* connector, const RfTrail* trail, int length, uint32_t triangle, RfVec3 point )
{
    const RfLightPathConnector* kernel = (const RfLightPathConnector*)(const void*)connector;
    const RfTracer* tracer = kernel->path->tracer;
    const RfLightPaths* paths = kernel->paths;
    RfChain chain;
    if ( kernel->normalization == RF_KERNEL_DENSITY )
        return 0.0f;
    if ( paths->light_count == 0 || !follow_back( tracer, trail, length, triangle, point, &chain ) )
        return 1.0f;
    chain.start.pdf_light /= (float)paths->light_cumulative[paths->light_count - 1];
    float pdf = rf_steer_pdf( paths, &chain );
    RfReach reach = rf_find_footprint( paths, rf_tracer_lights( tracer ), &chain, pdf, trail->start, trail->ng ).reach;
    float area = rf_chance_area( paths, &chain, rf_reach_area( &reach ), pdf, trail->start );
    return 1.0f - rf_connection_weight( paths, area, -rf_dot( trail->n, chain.end.d ), trail->vertex );
}
