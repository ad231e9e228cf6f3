// Vertices of rays that pass thin panes on their way.
#include "path/wavefront.h"

// Panes that rays from `first_past` on did not pass, which has the probability 1 − q: what is left of them is
// their base and their reflection.
static void stop_at_panes( const RfVertexLanes* v, RfRayLanes* rays, int first_past, float* const tint[3] )
{
    const float* n[3] = { v->n[0], v->n[1], v->n[2] };
    const float* param[RF_PARAM_COUNT];
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        param[p] = v->param[p];
    RfBsdfLanes lanes = rf_bsdf_lanes( RF_BSDF_GLASS, n, param, 0 );
    for ( int i = v->first[RF_BSDF_GLASS]; i < v->first[RF_BSDF_GLASS + 1]; ++i )
    {
        RfPane pane = rf_pane_of_lane( &lanes, i, rf_vec3( v->wo[0][i], v->wo[1][i], v->wo[2][i] ) );
        if ( v->ray[i] < first_past || !( pane.probability > 0.0f ) )
            continue;
        float stopped = rf_maxf( 1.0f - pane.probability, 0x1p-24f );
        for ( int c = 0; c < 3; ++c )
        {
            rays->throughput[c][v->ray[i]] /= stopped;
            tint[c][i] = 0.0f;
        }
    }
}

// Rays [0, first_past), for which panes are surfaces like any others.
static void trace_to_panes( const RfPathSettings* settings, const RfRayLanes* rays, int first_past, RfLaneScratch* scratch )
{
    const float* o[3] = { rays->o[0], rays->o[1], rays->o[2] };
    const float* d[3] = { rays->d[0], rays->d[1], rays->d[2] };
    rf_trace_nearest( settings->tracer, first_past, o, d, false, scratch->triangle, scratch->u, scratch->v );
    for ( int r = 0; r < first_past; ++r )
        scratch->visible[r] = 1.0f;
}

static void trace_past_panes( const RfPathSettings* settings, RfRayLanes* rays, int first_past, RfLaneScratch* scratch )
{
    int at = first_past, count = rays->count - first_past;
    const float* o[3] = { rays->o[0] + at, rays->o[1] + at, rays->o[2] + at };
    const float* d[3] = { rays->d[0] + at, rays->d[1] + at, rays->d[2] + at };
    RfPaneLanes panes = { scratch->visible + at, { scratch->f[0] + at, scratch->f[1] + at, scratch->f[2] + at } };
    rf_trace_nearest_past_panes( settings->tracer, count, o, d, scratch->triangle + at, scratch->u + at, scratch->v + at,
                                 &panes );
    for ( int c = 0; c < 3; ++c )
    {
        for ( int r = 0; r < count; ++r )
            rays->throughput[c][at + r] *= panes.weight[c][r];
    }
}

const float* rf_find_vertices_past_panes( const RfPathSettings* settings, RfRayLanes* rays, int first_past,
                                          RfVertexLanes* vertices, RfLaneScratch* scratch )
{
    if ( !rf_tracer_has_panes( settings->tracer ) )
    {
        rf_find_vertices( settings, rays, false, vertices, scratch );
        return NULL;
    }
    trace_to_panes( settings, rays, first_past, scratch );
    trace_past_panes( settings, rays, first_past, scratch );
    rf_fill_vertices( settings->tracer, rays, vertices, scratch );
    float* tint[3] = { vertices->param[RF_PARAM_TINT], vertices->param[RF_PARAM_TINT + 1], vertices->param[RF_PARAM_TINT + 2] };
    stop_at_panes( vertices, rays, first_past, tint );
    return scratch->visible;
}
