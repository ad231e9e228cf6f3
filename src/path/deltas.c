// With a linker (src/kernel): which emission is left to it.
#include "path/wavefront.h"

void rf_note_lit( const RfPathSettings* settings, RfWavefront* wavefront, const RfLightLanes* lights, int sample, int count )
{
    if ( settings->linker == NULL )
        return;
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 radiance = rf_vec3( lights->radiance_cos[0][i], lights->radiance_cos[1][i], lights->radiance_cos[2][i] );
        float lit = rf_luminance( radiance ) / ( (float)settings->light_samples * lights->pdf_solid_angle[i] );
        wavefront->lit[i] = lit + ( sample > 0 ? wavefront->lit[i] : 0.0f );
    }
}

void rf_count_deltas( const RfPathSettings* settings, RfWavefront* wavefront, const RfVertexLanes* v, int vertex,
                      const float* pdf )
{
    if ( settings->linker == NULL )
        return;
    const RfMaterial* materials = rf_tracer_scene( settings->tracer )->materials;
    int records = rf_record_count( v );
    for ( int i = 0; i < v->count; ++i )
    {
        uint8_t* deltas = wavefront->deltas + v->slot[i];
        bool follows = i >= records && vertex > 1 && pdf[i] == RF_DELTA_PDF && *deltas <= RF_MAX_CHAIN &&
                       rf_is_chain_surface( materials + v->material[i] );
        wavefront->matte[v->slot[i]] = i < records && rf_is_matte_lane( settings, v, i );
        *deltas = i < records ? 1 : follows ? (uint8_t)( *deltas + 1 ) : RF_NOT_LINKED;
    }
}

void rf_leave_to_links( const RfPathSettings* settings, const RfWavefront* wavefront, RfRayLanes* rays, RfVertexLanes* vertices )
{
    if ( settings->linker == NULL )
        return;
    for ( int i = 0; i < vertices->count; ++i )
    {
        uint8_t deltas = wavefront->deltas[vertices->slot[i]];
        if ( deltas > 1 && deltas != RF_NOT_LINKED && settings->linker->linked[vertices->material[i]] )
            vertices->light_pdf_solid_angle[i] = 0.0f;
    }
    bool sky = settings->linker->linked[rf_tracer_scene( settings->tracer )->material_count];
    for ( int r = 0; r < rays->count && sky; ++r )
    {
        uint8_t deltas = wavefront->deltas[rays->slot[r]];
        for ( int c = 0; c < 3 && deltas > 1 && deltas != RF_NOT_LINKED && wavefront->scratch.triangle[r] == RF_MISS; ++c )
            rays->throughput[c][r] = 0.0f;
    }
}
