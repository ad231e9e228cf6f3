// Puts lights out, and splits them by groups.
#include "trace/relit.h"

#include "trace/tracer.h"

#include <stdlib.h>
#include <string.h>

struct RfRelitTracer
{
    RfTracer tracer;
    RfScene scene;
    RfEnvironment environment;
    RfPunctual* punctual;
    RfLight* light;
};

static const RfVec3 s_black = { 0, 0, 0 };

static void put_out( RfRelitTracer* relit, uint32_t number )
{
    RfLights* lights = &relit->tracer.lights;
    if ( number < lights->triangle_count )
    {
        relit->light[number].radiance = s_black;
        relit->light[number].textured = false; // or it would be looked up
    }
    else if ( number - lights->triangle_count < (uint32_t)lights->punctual_count )
        relit->punctual[number - lights->triangle_count].intensity = s_black;
    else
        relit->environment.radiance = s_black;
}

RfResult rf_create_relit_tracer( const RfTracer* tracer, RfIsLit* is_lit, void* user, RfRelitTracer** out, RfError* error )
{
    const RfLights* of = &tracer->lights;
    size_t triangles = of->triangle_count, lamps = (size_t)of->punctual_count;
    RfRelitTracer* relit = *out = malloc( sizeof *relit );
    if ( relit != NULL )
        *relit = ( RfRelitTracer ){ .tracer = *tracer,
                                    .scene = *tracer->scene,
                                    .punctual = malloc( ( lamps + 1 ) * sizeof *relit->punctual ),
                                    .light = malloc( ( triangles + 1 ) * sizeof *relit->light ) };
    if ( relit == NULL || relit->punctual == NULL || relit->light == NULL )
    {
        rf_destroy_relit_tracer( relit );
        *out = NULL;
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a copy of %u lights", of->count );
    }
    if ( lamps > 0 )
        memcpy( relit->punctual, of->punctual, lamps * sizeof *relit->punctual );
    if ( triangles > 0 )
        memcpy( relit->light, of->light, triangles * sizeof *relit->light );
    relit->tracer.scene = &relit->scene;
    relit->scene.movement = NULL;
    relit->tracer.lights.punctual = relit->punctual;
    relit->tracer.lights.light = relit->light;
    if ( of->sky.environment != NULL )
    {
        relit->environment = *of->sky.environment;
        relit->tracer.lights.sky.environment = &relit->environment;
    }
    for ( uint32_t i = 0; i < of->count; ++i )
    {
        if ( !is_lit( user, i ) )
            put_out( relit, i );
    }
    return RF_OK;
}

void rf_destroy_relit_tracer( RfRelitTracer* relit )
{
    if ( relit == NULL )
        return;
    free( relit->punctual );
    free( relit->light );
    free( relit );
}

const RfTracer* rf_relit_tracer( const RfRelitTracer* relit ) { return &relit->tracer; }

RfResult rf_create_split_tracer( const RfTracer* tracer, const RfLightGroups* groups, RfTracer** out, RfError* error )
{
    RfTracer* split = *out = malloc( sizeof *split );
    if ( split == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the groups of %u lights", tracer->lights.count );
    *split = *tracer;
    split->still = tracer;
    RfResult result = rf_split_lights( tracer->scene, groups, &split->lights, error );
    if ( result == RF_OK )
        return RF_OK;
    rf_destroy_split_tracer( split );
    *out = NULL;
    return result;
}

void rf_destroy_split_tracer( RfTracer* split )
{
    if ( split == NULL )
        return;
    rf_join_lights( &split->lights );
    free( split );
}
