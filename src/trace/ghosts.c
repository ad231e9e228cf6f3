// What moves in a group of frames, as rays and segments meet it.
#include "trace/trace.h"

#include <math.h>

bool rf_tracer_has_ghosts( const RfTracer* tracer ) { return rf_tracer_scene( tracer )->feigned != NULL; }

// Whether o + t d, 0 < t < length, meets a box.
static bool meets_box( const RfVec3 box[2], const float o[3], const float d[3], float length )
{
    const float low[3] = { box[0].x, box[0].y, box[0].z }, high[3] = { box[1].x, box[1].y, box[1].z };
    float near = 0.0f, far = length;
    for ( int c = 0; c < 3; ++c )
    {
        if ( d[c] == 0.0f )
        {
            near = o[c] < low[c] || o[c] > high[c] ? INFINITY : near;
            continue;
        }
        float a = ( low[c] - o[c] ) / d[c], b = ( high[c] - o[c] ) / d[c];
        near = fmaxf( near, fminf( a, b ) );
        far = fminf( far, fmaxf( a, b ) );
    }
    return near < far;
}

static void meet_boxes( const RfFeignedGhosts* ghosts, int count, const float* const o[3], const float* const d[3], float length,
                        uint8_t* touched )
{
    for ( int i = 0; i < count; ++i )
    {
        const float from[3] = { o[0][i], o[1][i], o[2][i] }, way[3] = { d[0][i], d[1][i], d[2][i] };
        for ( int k = 0; k < ghosts->count && !touched[i]; ++k )
            touched[i] = meets_box( ghosts->box[k], from, way, length );
    }
}

void rf_find_ghosts( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float length,
                     uint8_t* touched )
{
    const RfFeignedGhosts* feigned = rf_tracer_scene( tracer )->feigned;
    if ( feigned != NULL )
        meet_boxes( feigned, count, o, d, length, touched );
}
