// The sides of translucent first hits that cameras see (src/reuse/estimators.md, section 20).
#include "reuse/harvest/harvest_steps.h"

void rf_face_cameras( const RfVertexLanes* v, RfHitBatch* batch )
{
    for ( int i = v->first[RF_BSDF_TRANSLUCENT]; i < v->first[RF_BSDF_TRANSLUCENT + 1]; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->ng[c][i] *= v->param[RF_PARAM_CHOICE][i];
    }
}
