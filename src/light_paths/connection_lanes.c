// What connections bring to the lanes of vertices.
#include "light_paths/connections_internal.h"

void rf_add_light( RfConnectionWork* w, int i, RfRandomKey key, RfVec3 wi_of, RfVec3 light, float area )
{
    RfConnectionLanes* out = w->out;
    float add[3] = { light.x, light.y, light.z }, weight = rf_luminance( light );
    w->chosen[i] += weight;
    bool choose = rf_random( key, RF_DIMENSION_CHOOSE ) * w->chosen[i] < weight || out->found[i] == 0;
    for ( int c = 0; c < 3; ++c )
        out->light[c][i] += add[c];
    out->found[i] += 1;
    if ( !choose )
        return;
    float wi[3] = { wi_of.x, wi_of.y, wi_of.z };
    out->area[i] = area;
    for ( int c = 0; c < 3; ++c )
    {
        out->wi[c][i] = wi[c];
        out->one[c][i] = add[c] / weight;
    }
}
