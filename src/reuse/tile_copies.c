// Tiles that share one path: the hits of several slots are copies of one, whose path is traced once, and the other hits of
// their tiles have none of their own. For gradient-domain path tracing (Kettunen et al., 2015).
#include "reuse/tile_copies.h"

#include "reuse/tile_lanes.h"

#include <string.h>

#define COPIES_APART 8 // slots, at most, from a hit to its copies

void rf_drop_copies( const int32_t* source, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    int32_t from[RF_LANES] = { 0 }, slot[RF_LANES] = { 0 };
    int count = 0;
    for ( int a = 0; a < y->count; ++a )
    {
        from[count] = a;
        slot[count] = y->slot[a];
        count += reuse->owner[a] < 0 || source[y->slot[a]] == y->slot[a];
    }
    rf_take_vertices( from, slot, count, &wavefront->vertices, &reuse->second );
    rf_gather_vectors( from, count, reuse->throughput );
    for ( int b = 0; b < count; ++b )
        reuse->owner[b] = reuse->owner[from[b]];
}

// What the light of reused paths is multiplied by: both hits of a tile take turns.
#define TURNS 2.0f

static void copy_light( const int32_t* from, const int32_t* slot, int count, int light_samples, RfTileReuse* reuse )
{
    RfArrivals* at_second = &reuse->arrivals_at_second;
    for ( int j = 0; j < light_samples; ++j )
    {
        rf_gather_vectors( from, count, reuse->direct[j].wi );
        rf_gather_vectors( from, count, reuse->direct[j].radiance_cos );
        rf_gather_lanes( from, count, reuse->direct[j].pdf_solid_angle );
    }
    rf_gather_vectors( from, count, reuse->throughput );
    rf_gather_vectors( from, count, reuse->wi );
    rf_gather_lanes( from, count, reuse->pdf );
    for ( int b = 0; b < count; ++b )
    {
        int of = reuse->second.slot[from[b]];
        at_second->light_pdf_solid_angle[slot[b]] = at_second->light_pdf_solid_angle[of];
        for ( int c = 0; c < 3; ++c )
        {
            at_second->emitted[c][slot[b]] = at_second->emitted[c][of];
            at_second->rest[c][slot[b]] = at_second->rest[c][of];
        }
    }
}

// Of the lanes of a path that is reused.
static void scale_light( int b, int slot, int light_samples, RfTileReuse* reuse )
{
    for ( int c = 0; c < 3; ++c )
    {
        for ( int j = 0; j < light_samples; ++j )
            reuse->direct[j].radiance_cos[c][b] *= TURNS;
        reuse->arrivals_at_second.emitted[c][slot] *= TURNS;
        reuse->arrivals_at_second.rest[c][slot] *= TURNS;
    }
}

void rf_restore_copies( const int32_t* source, int light_samples, RfWavefront* wavefront, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second;
    int32_t from[RF_LANES] = { 0 }, slot[RF_LANES] = { 0 };
    bool reused[RF_LANES];
    int count = 0;
    for ( int a = 0; a < y->count; ++a )
    {
        int first = y->slot[a], end = reuse->owner[a] < 0 ? first + 1 : first + COPIES_APART;
        for ( int s = first; s < end && s < RF_LANES; ++s )
        {
            if ( s > first && source[s] != first )
                continue;
            from[count] = a;
            slot[count] = s;
            reused[count++] = reuse->owner[a] >= 0;
        }
    }
    copy_light( from, slot, count, light_samples, reuse );
    rf_take_vertices( from, slot, count, &wavefront->vertices, &reuse->second );
    for ( int b = 0; b < count; ++b )
    {
        if ( reused[b] )
            scale_light( b, slot[b], light_samples, reuse );
    }
}
