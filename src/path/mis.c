// Gathers samples for the balance heuristic, and observes the weights where a build checks their sums.
#include "path/mis.h"

#include <stddef.h>
#include <string.h>

void rf_clear_arrivals( int count, RfArrivals* arrivals )
{
    size_t bytes = (size_t)count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memset( arrivals->emitted[c], 0, bytes );
        memset( arrivals->rest[c], 0, bytes );
    }
    memset( arrivals->light_pdf_solid_angle, 0, bytes );
}

void rf_copy_arrivals( int count, const RfArrivals* from, RfArrivals* to )
{
    size_t bytes = (size_t)count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( to->emitted[c], from->emitted[c], bytes );
        memcpy( to->rest[c], from->rest[c], bytes );
    }
    memcpy( to->light_pdf_solid_angle, from->light_pdf_solid_angle, bytes );
}

void rf_gather_light_sample( const RfLightLanes* light, int part, int count, float k, RfArrivalLanes* out )
{
    size_t bytes = (size_t)count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        const float* restrict from = light->radiance_cos[c];
        float* restrict to = out->a[c];
        if ( part == RF_ALL_PARTS )
            memcpy( to, from, bytes );
#pragma omp simd
        for ( int i = 0; i < ( part == RF_ALL_PARTS ? 0 : count ); ++i )
            to[i] = light->part[i] == part ? from[i] : 0.0f;
        memset( out->b[c], 0, bytes );
    }
    for ( int i = 0; i < count; ++i )
        out->light_pdf[i] = k * light->pdf_solid_angle[i];
    out->scattered = false;
}

void rf_gather_scattered( const RfVertexLanes* v, int count, const float* const wi[3], const RfArrivals* arrivals, float k,
                          RfArrivalLanes* out )
{
    for ( int i = 0; i < count; ++i )
    {
        int slot = v->slot[i];
        float cos_x = v->n[0][i] * wi[0][i] + v->n[1][i] * wi[1][i] + v->n[2][i] * wi[2][i];
        for ( int c = 0; c < 3; ++c )
        {
            out->a[c][i] = cos_x * arrivals->emitted[c][slot];
            out->b[c][i] = cos_x * arrivals->rest[c][slot];
        }
        out->light_pdf[i] = k * arrivals->light_pdf_solid_angle[slot];
    }
    out->scattered = true;
}

static RfWeightRange* s_range;

void rf_watch_weights( RfWeightRange* range ) { s_range = range; }

void rf_note_weights( const float* weight, int count, float scale )
{
    if ( s_range == NULL )
        return;
    for ( int i = 0; i < count; ++i )
    {
        float w = weight[i] / scale;
        s_range->nans += !( w == w );
        s_range->count += w > 0.0f;
        s_range->least = w < s_range->least ? w : s_range->least;
        s_range->most = w > s_range->most ? w : s_range->most;
    }
}
