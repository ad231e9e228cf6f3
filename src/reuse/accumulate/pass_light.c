// Takes the light of hits, misses and glints apart.
#include "reuse/accumulate/pass_light.h"

#include <string.h>

void rf_begin_pass_light( const RfHitBatch* lit, RfAccumulateScratch* s )
{
    int first = lit->first[RF_BSDF_FIRST_GLOSSY];
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < first; ++i )
            s->whole[c][i] = lit->radiance[4 * i + c];
        if ( lit->count > first )
            memcpy( s->whole[c] + first, s->sum[c], (size_t)( lit->count - first ) * sizeof( float ) );
        memset( s->emission[c], 0, (size_t)lit->count * sizeof( float ) );
        memset( s->direct[c], 0, (size_t)lit->count * sizeof( float ) );
    }
}

void rf_add_pass_light( const RfHitBatch* lit, const RfPassLight* light, RfVec3 scale, RfAccumulateScratch* s )
{
    const float of_part[3] = { scale.x, scale.y, scale.z };
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < lit->count; ++i )
            s->emission[c][i] += of_part[c] * light->emission[c][i];
        for ( int i = 0; i < lit->first[RF_BSDF_FIRST_GLOSSY]; ++i )
            s->direct[c][i] += of_part[c] * light->direct[c][i];
    }
}

static float of_hit( const RfHitBatch* lit, RfAov pass, int i, int c, const RfAccumulateScratch* s )
{
    float whole = s->whole[c][i];
    switch ( lit->event[i] )
    {
        case RF_EVENT_REFLECTION: return pass == RF_AOV_REFLECTION ? whole : 0.0f;
        case RF_EVENT_TRANSMISSION: return pass == RF_AOV_TRANSMISSION ? whole : 0.0f;
        default: break;
    }
    return pass == RF_AOV_EMISSION   ? s->emission[c][i]
           : pass == RF_AOV_DIRECT   ? s->direct[c][i]
           : pass == RF_AOV_INDIRECT ? rf_without_rounding( whole - s->emission[c][i] - s->direct[c][i], whole )
                                     : 0.0f;
}

// Of a miss or a glint.
static float of_other( const RfHitBatch* lit, RfAov pass, int item, int c )
{
    static const RfAov s_passes[RF_OTHER_PASSES] = { [RF_OTHER_DIRECT] = RF_AOV_DIRECT,
                                                     [RF_OTHER_INDIRECT] = RF_AOV_INDIRECT,
                                                     [RF_OTHER_REFLECTION] = RF_AOV_REFLECTION,
                                                     [RF_OTHER_TRANSMISSION] = RF_AOV_TRANSMISSION };
    float whole = lit->radiance[4 * item + c], left = whole;
    for ( int k = 0; k < RF_OTHER_PASSES; ++k )
    {
        float light = rf_other_pass( lit, k, item )[c];
        left -= light;
        if ( s_passes[k] == pass )
            return light;
    }
    return rf_without_rounding( left, whole );
}

void rf_light_pass( const RfHitBatch* lit, RfAov pass, RfAccumulateScratch* s )
{
    int first = lit->first[RF_BSDF_FIRST_GLOSSY], listed = lit->count + lit->miss_count + lit->glint_count;
    for ( int i = 0; i < lit->count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            *( i < first ? s->pass + 4 * i + c : s->sum[c] + i - first ) = of_hit( lit, pass, i, c, s );
        s->pass[4 * i + 3] = 1.0f;
    }
    for ( int item = lit->count; item < listed; ++item )
    {
        for ( int c = 0; c < 3; ++c )
            s->pass[4 * item + c] = of_other( lit, pass, item, c );
        s->pass[4 * item + 3] = lit->radiance[4 * item + 3];
    }
}
