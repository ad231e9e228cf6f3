// The sides of translucent surfaces on which light is drawn to arrive (src/reuse/estimators.md, section 20).
#include "path/wavefront.h"

static RfVec3 colour_at( const RfVertexLanes* v, RfBsdfParam param, int i ) { return RF_GET3( v->param + param, i ); }

void rf_draw_sides( const RfWavefront* keys, int vertex, RfVertexLanes* v )
{
    int first = v->first[RF_BSDF_TRANSLUCENT], count = v->first[RF_BSDF_TRANSLUCENT + 1] - first;
    if ( count == 0 )
        return;
    float u[1][RF_LANES];
    rf_draw_lanes( keys, count, v->slot + first, RF_DIMENSION_SIDES + (uint32_t)vertex, 1, u );
    for ( int i = first; i < first + count; ++i )
    {
        float p = rf_through_probability( colour_at( v, RF_PARAM_THROUGH, i ), colour_at( v, RF_PARAM_DIFFUSE, i ),
                                          colour_at( v, RF_PARAM_SPECULAR, i ), v->param[RF_PARAM_F90][i] );
        float side = u[0][i - first] < p ? -1.0f : 1.0f;
        v->param[RF_PARAM_CHOICE][i] = side;
        for ( int c = 0; c < 3; ++c )
        {
            v->n[c][i] *= side;
            v->ng[c][i] *= side;
        }
    }
}

void rf_face_rays( RfVertexLanes* v )
{
    for ( int i = v->first[RF_BSDF_TRANSLUCENT]; i < v->first[RF_BSDF_TRANSLUCENT + 1]; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            v->ng[c][i] *= v->param[RF_PARAM_CHOICE][i];
    }
}
