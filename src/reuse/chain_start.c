// Where chains start: at mirrors and glass, and at coats so smooth that they are better followed than evaluated.
#include "reuse/chain_steps.h"
#include "reuse/coats.h"

#include <string.h>

bool rf_has_chains( const RfVertexLanes* first )
{
    if ( rf_record_count( first ) < first->count )
        return true;
    for ( int i = first->first[RF_BSDF_GGX]; i < first->first[RF_BSDF_GGX + 1]; ++i )
    {
        if ( rf_is_smooth_coat( first, i ) )
            return true;
    }
    return false;
}

// The view of a chain that starts here, if it is reflected and then ends.
static uint8_t view_of( const RfPathSettings* path, const RfVertexLanes* v, int i, uint32_t triangle, RfVec3 throughput )
{
    uint16_t mirror = rf_tracer_triangles( path->tracer )[triangle].mirror;
    float cos_o = v->n[0][i] * v->wo[0][i] + v->n[1][i] * v->wo[1][i] + v->n[2][i] * v->wo[2][i], ior = v->param[RF_PARAM_IOR][i];
    bool inside = rf_max_component( throughput ) < 1.0f || ( ior > 0.0f && ior < 1.0f );
    return mirror == RF_NO_MIRROR || cos_o < RF_MIN_COS || inside ? RF_VIEW_CHAIN : (uint8_t)( RF_VIEW_FIRST_MIRROR + mirror );
}

bool rf_is_at_pane( const RfTracer* tracer, const RfVertexLanes* v, int i )
{
    if ( !rf_tracer_has_panes( tracer ) )
        return false;
    const float *n[3] = { v->n[0], v->n[1], v->n[2] }, *param[RF_PARAM_COUNT];
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        param[p] = v->param[p];
    RfBsdfLanes lanes = rf_bsdf_lanes( RF_BSDF_GLASS, n, param, 0 );
    return rf_pane_of_lane( &lanes, i, rf_vec3( v->wo[0][i], v->wo[1][i], v->wo[2][i] ) ).probability > 0.0f;
}

// Mirrors and glass: what the eyes see of their emission, absorbed on the way if the eye is inside a body.
static void start_at_glass( const RfPathSettings* path, const RfRayLanes* rays, RfWavefront* wavefront, RfChains* chains )
{
    const RfVertexLanes* v = &chains->at;
    for ( int i = 0; i < v->count; ++i )
    {
        int slot = v->slot[i];
        RfVec3 t = rf_transmittance_from( v, i, rf_vec3( rays->o[0][slot], rays->o[1][slot], rays->o[2][slot] ) );
        float left[3] = { t.x, t.y, t.z };
        rf_set_throughput( chains, slot, t );
        chains->view[slot] = view_of( path, v, i, wavefront->scratch.triangle[v->ray[i]], t );
        for ( int c = 0; c < 3; ++c )
            wavefront->arrivals.rest[c][slot] += left[c] * v->emission[c][i];
    }
}

static void append( RfVertexLanes* lanes, int count )
{
    lanes->count += count;
    for ( int kind = RF_BSDF_GLASS + 1; kind <= RF_BSDF_KIND_COUNT; ++kind )
        lanes->first[kind] += count;
}

// Smooth coats: draws the base or the lobe.
static void start_at_coats( const RfVertexLanes* first, RfWavefront* wavefront, RfChains* chains )
{
    RfVertexLanes* at = &chains->at;
    for ( int i = first->first[RF_BSDF_GGX]; i < first->first[RF_BSDF_GGX + 1]; ++i )
    {
        if ( !rf_is_smooth_coat( first, i ) )
            continue;
        int slot = first->slot[i];
        RfRandomKey key = { wavefront->key_a[slot], wavefront->key_b[slot] };
        float base = rf_base_probability_of( first, i );
        chains->view[slot] = rf_random( key, RF_DIMENSION_CHAINS ) < base ? RF_VIEW_BASE : RF_VIEW_CHAIN;
        if ( chains->view[slot] == RF_VIEW_BASE )
            continue;
        for ( int c = 0; c < 3 && base == 0.0f; ++c ) // otherwise the base has it
            wavefront->arrivals.rest[c][slot] += first->emission[c][i];
        chains->lobe_weight[slot] = 1.0f / ( 1.0f - base );
        rf_make_lobe( first, i, at, at->count );
        append( at, 1 );
    }
}

void rf_start_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                      RfWavefront* wavefront, RfChains* chains )
{
    memset( chains->length, 0, sizeof chains->length );
    memset( chains->view, RF_VIEW_DIRECT, sizeof chains->view );
    memset( chains->split, 0, sizeof chains->split );
    memset( chains->counted, 0, sizeof chains->counted );
    memset( chains->pane, 0, sizeof chains->pane );
    memset( chains->straight, 0, sizeof chains->straight );
    memset( &wavefront->arrivals, 0, sizeof wavefront->arrivals );
    for ( int i = 0; i < camera_rays->count; ++i )
    {
        rf_set_throughput( chains, i, rf_vec3( 1, 1, 1 ) );
        chains->lobe_weight[i] = 1.0f;
    }
    rf_go_to( first, &chains->at );
    start_at_glass( path, camera_rays, wavefront, chains );
    start_at_coats( first, wavefront, chains );
    if ( lit && path->max_depth > 1 )
        rf_split_reflections( path, 1, first, wavefront, chains );
    for ( int i = 0; i < chains->at.count; ++i )
    {
        int slot = chains->at.slot[i];
        rf_set_throughput( chains, slot, rf_scale( rf_throughput_of( chains, slot ), chains->lobe_weight[slot] ) );
    }
    chains->ends.count = 0;
}
