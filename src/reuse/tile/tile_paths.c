// Handles copies of one path in several tiles, and thins paths by Russian roulette.
#include "reuse/tile/tile_paths.h"

#include "path/roulette.h"

#include <string.h>

// Moves lane from[b] of an array to lane b.
static void gather_lanes( const int32_t* from, int count, float* lanes )
{
    float old[RF_LANES];
    memcpy( old, lanes, sizeof old );
    for ( int b = 0; b < count; ++b )
        lanes[b] = old[from[b]];
}

static void gather_vectors( const int32_t* from, int count, float lanes[3][RF_LANES] )
{
    for ( int c = 0; c < 3; ++c )
        gather_lanes( from, count, lanes[c] );
}

// Keeps the listed lanes of the second vertices, in the order of their models.
static void take_vertices( const int32_t* from, const int32_t* slot, int count, RfVertexLanes* spare, RfVertexLanes* second )
{
    for ( int b = 0, kind = 0; b < count; ++b )
    {
        while ( from[b] >= second->first[kind + 1] )
            ++kind;
        rf_copy_vertices( second, from[b], 1, rf_bsdf_model( (RfBsdfKind)kind )->params, spare, b );
        spare->slot[b] = slot[b];
    }
    for ( int kind = 0, b = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
    {
        while ( b < count && from[b] < second->first[kind] )
            ++b;
        spare->first[kind] = b;
    }
    spare->count = count;
    spare->guide = second->guide;
    *second = *spare;
}

#define COPIES_APART 8 // slots, at most, from a hit to its copies

void rf_drop_copies( const int32_t* source, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    int32_t from[RF_LANES] = { 0 }, slot[RF_LANES] = { 0 };
    int count = 0;
    for ( int a = 0; a < y->count; ++a )
    {
        from[count] = a;
        slot[count] = y->slot[a];
        count += reuse->second.owner[a] < 0 || source[y->slot[a]] == y->slot[a];
    }
    take_vertices( from, slot, count, &wavefront->vertices, &reuse->second.lanes );
    gather_vectors( from, count, reuse->second.throughput );
    for ( int b = 0; b < count; ++b )
        reuse->second.owner[b] = reuse->second.owner[from[b]];
}

// The light of reused paths is multiplied by this: the two hits of a tile take turns.
#define TURNS 2.0f

static void gather_samples( const int32_t* from, int count, int light_samples, RfSecondVertices* second )
{
    for ( int j = 0; j < light_samples; ++j )
    {
        gather_vectors( from, count, second->direct[j].wi );
        gather_vectors( from, count, second->direct[j].radiance_cos );
        gather_lanes( from, count, second->direct[j].pdf_solid_angle );
    }
    gather_vectors( from, count, second->throughput );
    gather_vectors( from, count, second->wi );
    gather_lanes( from, count, second->pdf );
}

static void copy_light( const int32_t* from, const int32_t* slot, int count, int light_samples, RfTileReuse* reuse )
{
    RfArrivals* at_second = reuse->at_second;
    gather_samples( from, count, light_samples, &reuse->second );
    for ( int b = 0; b < count; ++b )
    {
        int of = reuse->second.lanes.slot[from[b]];
        at_second->light_pdf_solid_angle[slot[b]] = at_second->light_pdf_solid_angle[of];
        for ( int c = 0; c < 3; ++c )
        {
            at_second->emitted[c][slot[b]] = at_second->emitted[c][of];
            at_second->rest[c][slot[b]] = at_second->rest[c][of];
        }
    }
}

// Scales all light of second vertex a.
static void scale_light( int light_samples, RfTileReuse* reuse, int a, float scale )
{
    int slot = reuse->second.lanes.slot[a];
    for ( int c = 0; c < 3; ++c )
    {
        for ( int j = 0; j < light_samples; ++j )
            reuse->second.direct[j].radiance_cos[c][a] *= scale;
        reuse->at_second->emitted[c][slot] *= scale;
        reuse->at_second->rest[c][slot] *= scale;
    }
}

void rf_restore_copies( const int32_t* source, int light_samples, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    int32_t from[RF_LANES] = { 0 }, slot[RF_LANES] = { 0 };
    bool reused[RF_LANES];
    int count = 0;
    for ( int a = 0; a < y->count; ++a )
    {
        int first = y->slot[a], end = reuse->second.owner[a] < 0 ? first + 1 : first + COPIES_APART;
        for ( int s = first; s < end && s < RF_LANES; ++s )
        {
            if ( s > first && source[s] != first )
                continue;
            from[count] = a;
            slot[count] = s;
            reused[count++] = reuse->second.owner[a] >= 0;
        }
    }
    copy_light( from, slot, count, light_samples, reuse );
    take_vertices( from, slot, count, &wavefront->vertices, &reuse->second.lanes );
    for ( int b = 0; b < count; ++b )
    {
        if ( reused[b] )
            scale_light( light_samples, reuse, b, TURNS );
    }
}

// By second vertex: the mean over all paths of its tile, those without a second vertex included.
static void find_tile_means( const RfTileReuse* reuse, const float* luminance, float* mean )
{
    float sum[RF_LANES]; // by the first member of the tile
    int count = rf_record_count( &reuse->second.lanes );
    for ( int a = 0; a < count; ++a )
    {
        if ( reuse->second.owner[a] >= 0 )
            sum[reuse->hits.begin[reuse->second.owner[a]]] = 0.0f;
    }
    for ( int a = 0; a < count; ++a )
    {
        if ( reuse->second.owner[a] >= 0 )
            sum[reuse->hits.begin[reuse->second.owner[a]]] += luminance[a];
    }
    for ( int a = 0; a < count; ++a )
    {
        int i = reuse->second.owner[a];
        mean[a] = i >= 0 ? sum[reuse->hits.begin[i]] / (float)reuse->hits.size[i] : 0.0f;
    }
}

// Keeps the second vertices that survived, and those that are not reused.
static void drop_thinned( int light_samples, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    int32_t from[RF_LANES] = { 0 }, slot[RF_LANES] = { 0 }, owner[RF_LANES];
    int count = 0;
    for ( int a = 0; a < y->count; ++a )
    {
        int i = reuse->second.owner[a];
        bool stays = i < 0 || reuse->hits.second[i] == a;
        from[count] = a;
        slot[count] = y->slot[a];
        owner[count] = i;
        count += stays;
        for ( int c = 0; c < 3 && !stays; ++c )
            wavefront->arrivals.rest[c][y->slot[a]] = 0.0f; // light that comes by way of it
    }
    gather_samples( from, count, light_samples, &reuse->second );
    gather_lanes( from, count, reuse->second.own_distance2_cos );
    take_vertices( from, slot, count, &wavefront->vertices, &reuse->second.lanes );
    for ( int b = 0; b < count; ++b )
    {
        reuse->second.owner[b] = owner[b];
        if ( owner[b] >= 0 )
            reuse->hits.second[owner[b]] = b;
    }
}

void rf_thin_paths( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    float luminance[RF_LANES], mean[RF_LANES];
    bool lit[RF_LANES];
    rf_light_own_paths( path, wavefront, reuse, luminance, lit );
    find_tile_means( reuse, luminance, mean );
    reuse->thinned = reuse->kept = 0;
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        int i = reuse->second.owner[a], slot = y->slot[a];
        if ( i < 0 )
            continue;
        RfRandomKey key = { wavefront->key_a[slot], wavefront->key_b[slot] };
        float survival = rf_reuse_survival( luminance[a], mean[a] );
        bool survives = lit[a] && ( survival == 1.0f || rf_random( key, RF_DIMENSION_CONNECTIONS ) < survival );
        reuse->thinned += 1;
        reuse->kept += survives;
        if ( !survives )
            reuse->hits.second[i] = -1;
        if ( survives && survival < 1.0f )
            scale_light( path->light_samples, reuse, a, 1.0f / survival );
    }
    drop_thinned( path->light_samples, wavefront, reuse );
}
