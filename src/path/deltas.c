// With a connector (src/light_paths): which emission it finds as well.
#include "path/wavefront.h"

void rf_note_lit( const RfPathSettings* settings, RfWavefront* wavefront, const RfLightLanes* lights, int sample, int count )
{
    if ( settings->connector == NULL )
        return;
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 radiance = rf_vec3( lights->radiance_cos[0][i], lights->radiance_cos[1][i], lights->radiance_cos[2][i] );
        float lit = rf_luminance( radiance ) / ( (float)settings->light_samples * lights->pdf_solid_angle[i] );
        wavefront->lit[i] = lit + ( sample > 0 ? wavefront->lit[i] : 0.0f );
    }
}

static void begin_trail( const RfVertexLanes* v, int i, int vertex, RfTrail* trail )
{
    trail->n = rf_vec3( v->n[0][i], v->n[1][i], v->n[2][i] );
    trail->ng = rf_vec3( v->ng[0][i], v->ng[1][i], v->ng[2][i] );
    trail->start = rf_madd( rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] ), trail->ng, v->offset[i] );
    trail->vertex = vertex;
}

void rf_count_deltas( const RfPathSettings* settings, RfWavefront* wavefront, const RfVertexLanes* v, int vertex,
                      const float* pdf )
{
    if ( settings->connector == NULL )
        return;
    const RfMaterial* materials = rf_tracer_scene( settings->tracer )->materials;
    int records = rf_record_count( v );
    for ( int i = 0; i < v->count; ++i )
    {
        uint8_t* deltas = wavefront->deltas + v->slot[i];
        bool follows = i >= records && vertex > 1 && pdf[i] == RF_DELTA_PDF && *deltas <= RF_MAX_CHAIN &&
                       rf_is_chain_surface( materials + v->material[i] );
        wavefront->matte[v->slot[i]] = i < records && rf_is_matte_lane( settings, v, i );
        if ( i < records )
            begin_trail( v, i, vertex, settings->connector->trails + v->slot[i] );
        *deltas = i < records ? 1 : follows ? (uint8_t)( *deltas + 1 ) : RF_NOT_LINKED;
    }
}

// Of a vertex lane that a path has come to by so many delta vertices.
static void share_emission( const RfPathSettings* settings, const RfLaneScratch* hits, RfVertexLanes* v, int i, int length )
{
    const RfConnector* connector = settings->connector;
    RfTrail* trail = connector->trails + v->slot[i];
    int r = v->ray[i];
    if ( length > 0 && connector->connected[v->material[i]] && v->light_pdf_solid_angle[i] > 0.0f )
    {
        RfVec3 p = rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] );
        float weight = connector->weigh_chance( connector, trail, length, hits->triangle[r], p );
        v->light_pdf_solid_angle[i] = weight > 0.0f ? v->light_pdf_solid_angle[i] : 0.0f;
        for ( int c = 0; c < 3; ++c )
            v->emission[c][i] *= weight;
    }
    if ( i < rf_record_count( v ) || length >= RF_MAX_CHAIN )
        return;
    trail->triangle[length] = hits->triangle[r];
    trail->u[length] = hits->u[r];
    trail->v[length] = hits->v[r];
}

void rf_leave_to_connections( const RfPathSettings* settings, const RfWavefront* wavefront, RfRayLanes* rays,
                              RfVertexLanes* vertices )
{
    if ( settings->connector == NULL )
        return;
    for ( int i = 0; i < vertices->count; ++i )
    {
        uint8_t deltas = wavefront->deltas[vertices->slot[i]];
        if ( deltas != RF_NOT_LINKED )
            share_emission( settings, &wavefront->scratch, vertices, i, deltas - 1 );
    }
    bool sky = settings->connector->connected[rf_tracer_scene( settings->tracer )->material_count];
    for ( int r = 0; r < rays->count && sky; ++r )
    {
        uint8_t deltas = wavefront->deltas[rays->slot[r]];
        for ( int c = 0; c < 3 && deltas > 1 && deltas != RF_NOT_LINKED && wavefront->scratch.triangle[r] == RF_MISS; ++c )
            rays->throughput[c][r] = 0.0f;
    }
}
