#include "reuse/weight_range.h"

#include <stddef.h>

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
