// The sides of translucent first hits on which light is drawn to arrive (src/reuse/estimators.md, section 20).
#include "reuse/harvest/harvest_steps.h"

#define SIDES_SALT 0x51de500000000u // keeps their random numbers apart

// The number of the sequence in a pass: k φ by the pass of its half, φ the golden ratio, and the R2 sequence (Roberts) by the place
// of the pixel, all shifted by one random number for each half of a frame. Each number by itself is uniform, and the halves are
// independent.
static float number_of( uint32_t shift, uint32_t pass, uint32_t x, uint32_t y )
{
    uint32_t bits = shift + 0x9e3779b9u * pass + 0xc13fa9a9u * x + 0x91e10da5u * y;
    return (float)(int32_t)( bits >> 8 ) * 0x1p-24f;
}

void rf_draw_hit_sides( const RfHarvest* harvest, RfTraceJob job, RfHarvestScratch* scratch )
{
    RfVertexLanes* v = scratch->hits;
    int first = v->first[RF_BSDF_TRANSLUCENT], end = v->first[RF_BSDF_TRANSLUCENT + 1];
    if ( first == end )
        return;
    if ( harvest->passes_before < 0 || harvest->need != NULL )
    {
        rf_draw_sides( &scratch->wavefront, 1, v );
        return;
    }
    int64_t pass = harvest->passes_before + job.pass;
    uint64_t half =
        rf_pass_key( harvest->seed ^ SIDES_SALT, (uint32_t)( harvest->first_frame + job.eye ), 0, (uint32_t)( pass & 1 ) );
    uint32_t width = (uint32_t)harvest->eyes[job.eye].width;
    float u[RF_LANES];
    for ( int i = first; i < end; ++i )
    {
        uint32_t pixel = (uint32_t)scratch->pixel[v->slot[i]];
        u[i - first] = number_of( (uint32_t)half, (uint32_t)( pass >> 1 ), pixel % width, pixel / width );
    }
    rf_turn_sides( u, v );
}

void rf_face_cameras( const RfVertexLanes* v, RfHitBatch* batch )
{
    for ( int i = v->first[RF_BSDF_TRANSLUCENT]; i < v->first[RF_BSDF_TRANSLUCENT + 1]; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->ng[c][i] *= v->param[RF_PARAM_CHOICE][i];
    }
}
