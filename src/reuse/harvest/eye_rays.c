// Segments from cameras to points: in packets from one origin, or one by one for parallel projections.
#include "reuse/harvest/eye_rays.h"

#include "path/lanes.h"
#include "scene/projection.h"

// The segments of a parallel camera to the points with weight > 0.
typedef struct Segments
{
    int count;
    int32_t lane[RF_LANES];
    float from[3][RF_LANES], way[3][RF_LANES];
    float visible[RF_LANES];
    float probability[RF_LANES], weight[3][RF_LANES]; // of panes
    uint32_t first[RF_LANES];
} Segments;

static void pack( const RfEye* eye, int count, const float* const point[3], const float* weight, Segments* s )
{
    s->count = 0;
    for ( int i = 0; i < count; ++i )
    {
        if ( !( weight[i] > 0.0f ) )
            continue;
        RfVec3 p = RF_GET3( point, i ), from = rf_eye_start( eye, p );
        int k = s->count++;
        s->lane[k] = i;
        RF_PUT3( s->from, k, from );
        s->way[0][k] = p.x - from.x;
        s->way[1][k] = p.y - from.y;
        s->way[2][k] = p.z - from.z;
    }
}

static int trace_parallel( const RfTracer* tracer, const RfEye* eye, int count, const float* const point[3], float* weight,
                           const RfPaneLanes* panes )
{
    Segments s;
    pack( eye, count, point, weight, &s );
    const float *from[3] = { s.from[0], s.from[1], s.from[2] }, *way[3] = { s.way[0], s.way[1], s.way[2] };
    if ( panes == NULL )
        rf_trace_segments( tracer, s.count, from, way, s.visible );
    else
        rf_trace_segments_past_panes( tracer, s.count, from, way, s.visible,
                                      &( RfPaneLanes ){ .probability = s.probability,
                                                        .weight = { s.weight[0], s.weight[1], s.weight[2] },
                                                        .first = s.first } );
    for ( int k = 0; k < s.count; ++k )
    {
        int i = s.lane[k];
        weight[i] *= s.visible[k];
        if ( panes == NULL )
            continue;
        panes->probability[i] = s.probability[k];
        if ( panes->first != NULL )
            panes->first[i] = s.first[k];
        for ( int c = 0; c < 3; ++c )
            panes->weight[c][i] = s.weight[c][k];
    }
    return s.count;
}

int rf_trace_from_eye( const RfTracer* tracer, const RfEye* eye, int count, const float* const point[3], float* weight )
{
    if ( rf_is_parallel( eye ) )
        return trace_parallel( tracer, eye, count, point, weight, NULL );
    return rf_trace_from_origin( tracer, eye->origin, count, point, weight );
}

int rf_trace_from_eye_past_panes( const RfTracer* tracer, const RfEye* eye, int count, const float* const point[3], float* weight,
                                  const RfPaneLanes* panes )
{
    if ( rf_is_parallel( eye ) )
        return trace_parallel( tracer, eye, count, point, weight, panes );
    return rf_trace_from_origin_past_panes( tracer, eye->origin, count, point, weight, panes );
}

void rf_trace_mirrors_from_eye( const RfTracer* tracer, const RfEye* eye, int count, const float* const point[3],
                                const uint8_t* mirror, float* const hit[3], uint32_t* triangle, float* weight )
{
    if ( !rf_is_parallel( eye ) )
    {
        rf_trace_mirrors( tracer, eye->origin, count, point, mirror, hit, triangle, weight );
        return;
    }
    for ( int i = 0; i < count; ++i )
    {
        const float* one[3] = { point[0] + i, point[1] + i, point[2] + i };
        float* out[3] = { hit[0] + i, hit[1] + i, hit[2] + i };
        RfVec3 from = rf_eye_start( eye, RF_GET3( point, i ) );
        rf_trace_mirrors( tracer, from, 1, one, mirror + i, out, triangle + i, weight + i );
    }
}
