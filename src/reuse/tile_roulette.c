// Russian roulette on the paths of a tile by the light that they bring (Bauszat, Petitjean, Eisemann,
// Gradient-Domain Path Reusing, 2017): a path that brings little is connected to the other hits of its tile
// only now and then.
#include "reuse/tile_reuse.h"

// Paths are certain to survive from this share of the mean of their tile on, and with this probability at least.
#define CERTAIN_SHARE 0.1f
#define LEAST_SURVIVAL 0.1f

// By second vertex: the mean over the paths of its tile, those that found no vertex included.
static void find_tile_means( const RfTileReuse* reuse, const float* luminance, float* mean )
{
    float sum[RF_LANES]; // by the first member of the tile
    int count = rf_record_count( &reuse->second );
    for ( int a = 0; a < count; ++a )
    {
        if ( reuse->owner[a] >= 0 )
            sum[reuse->begin[reuse->owner[a]]] = 0.0f;
    }
    for ( int a = 0; a < count; ++a )
    {
        if ( reuse->owner[a] >= 0 )
            sum[reuse->begin[reuse->owner[a]]] += rf_maxf( luminance[a], 0.0f );
    }
    for ( int a = 0; a < count; ++a )
    {
        int i = reuse->owner[a];
        mean[a] = i >= 0 ? sum[reuse->begin[i]] / (float)reuse->size[i] : 0.0f;
    }
}

// Scales all light of second vertex a.
static void scale_light( const RfPathSettings* path, RfTileReuse* reuse, int a, float scale )
{
    int slot = reuse->second.slot[a];
    for ( int c = 0; c < 3; ++c )
    {
        for ( int j = 0; j < path->light_samples; ++j )
            reuse->direct[j].radiance_cos[c][a] *= scale;
        reuse->arrivals_at_second.emitted[c][slot] *= scale;
        reuse->arrivals_at_second.rest[c][slot] *= scale;
    }
}

void rf_thin_paths( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    float luminance[RF_LANES], mean[RF_LANES];
    rf_light_own_paths( path, wavefront, reuse, luminance );
    find_tile_means( reuse, luminance, mean );
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        int i = reuse->owner[a], slot = y->slot[a];
        if ( i < 0 )
            continue;
        RfRandomKey key = { wavefront->key_a[slot], wavefront->key_b[slot] };
        float certain = CERTAIN_SHARE * mean[a];
        float survival = luminance[a] < certain && certain > 0.0f ? rf_maxf( luminance[a] / certain, LEAST_SURVIVAL ) : 1.0f;
        bool survives = luminance[a] >= 0.0f && ( survival == 1.0f || rf_random( key, RF_DIMENSION_CONNECTIONS ) < survival );
        if ( !survives )
            reuse->second_of[i] = -1;
        if ( !survives || survival < 1.0f )
            scale_light( path, reuse, a, survives ? 1.0f / survival : 0.0f );
    }
}
