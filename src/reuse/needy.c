// Which tiles of a patch are traced, of pieces, and which get extra samples in adaptive sampling, and where in the pixels.
#include "reuse/harvest_internal.h"

#include <math.h>
#include <string.h>

// The tiles of the pixels listed for a patch. Without tile reuse each pixel is a tile.
typedef struct Tiles
{
    int count;
    int32_t of[RF_LANES]; // each pixel's
    int32_t size[RF_LANES];
    float need[RF_LANES]; // mean over its pixels
} Tiles;

static void list_tiles( const RfHarvest* harvest, int count, int tiles, const RfHarvestScratch* scratch, Tiles* out )
{
    bool in_tiles = rf_reuses_tiles( scratch );
    out->count = in_tiles ? tiles : count;
    memset( out->size, 0, sizeof out->size );
    memset( out->need, 0, sizeof out->need );
    for ( int i = 0; i < count; ++i )
    {
        int t = in_tiles ? scratch->tile_of[i] : i;
        out->of[i] = t;
        out->need[t] += harvest->need[scratch->pixel[i]];
        out->size[t] += 1;
    }
    for ( int t = 0; t < out->count; ++t )
        out->need[t] = out->size[t] > 0 ? out->need[t] / (float)out->size[t] : 0.0f;
}

static float draw_tile( uint64_t key, int tile ) { return rf_random( rf_pixel_key( rf_mix64( key ), (uint32_t)tile ), 0 ); }

bool rf_is_patch_traced( const RfHarvest* harvest, RfTraceJob job )
{
    const RfEye* eye = harvest->eyes + job.eye;
    const uint8_t* cells = rf_frame_cells( harvest->pieces, harvest->first_frame + job.eye );
    int x0, y0, x1, y1;
    rf_bound_patch( &harvest->patches, eye, rf_harvest_key( harvest, job.eye, job.pass ), job.job, &x0, &y0, &x1, &y1 );
    for ( int y = y0 / RF_CELL_SIDE; y < rf_cells_along( y1 ); ++y )
    {
        for ( int x = x0 / RF_CELL_SIDE; x < rf_cells_along( x1 ); ++x )
        {
            if ( rf_is_traced( harvest->pieces, cells, x * RF_CELL_SIDE, y * RF_CELL_SIDE ) )
                return true;
        }
    }
    return false;
}

int rf_choose_traced( const RfHarvest* harvest, const RfEye* eye, int count, RfHarvestScratch* scratch )
{
    const uint8_t* cells = rf_frame_cells( harvest->pieces, harvest->first_frame + (int)( eye - harvest->eyes ) );
    bool in_tiles = rf_reuses_tiles( scratch ), traced[RF_LANES] = { false };
    for ( int i = 0; i < count; ++i )
    {
        int y = scratch->pixel[i] / eye->width, x = scratch->pixel[i] - y * eye->width;
        int tile = in_tiles ? scratch->tile_of[i] : i;
        traced[tile] = traced[tile] || rf_is_traced( harvest->pieces, cells, x, y );
    }
    int left = 0;
    for ( int i = 0; i < count; ++i )
    {
        int tile = in_tiles ? scratch->tile_of[i] : i;
        scratch->pixel[left] = scratch->pixel[i];
        scratch->tile_of[left] = tile;
        left += traced[tile];
    }
    return left;
}

int rf_choose_needy( const RfHarvest* harvest, uint64_t key, int count, int tiles, RfHarvestScratch* scratch )
{
    Tiles list;
    list_tiles( harvest, count, tiles, scratch, &list );
    bool chosen[RF_LANES];
    for ( int t = 0; t < list.count; ++t )
        chosen[t] = list.size[t] > 0 && list.need[t] - (float)harvest->round > draw_tile( key, t );
    int left = 0;
    for ( int i = 0; i < count; ++i )
    {
        scratch->pixel[left] = scratch->pixel[i];
        scratch->tile_of[left] = list.of[i];
        left += chosen[list.of[i]];
    }
    return left;
}

// Counts the samples of each tile: the whole part of its need, and one more with the rest as probability.
static int count_copies( const Tiles* list, uint64_t key, int32_t* copies )
{
    int most = 0;
    for ( int t = 0; t < list->count; ++t )
    {
        float whole = floorf( list->need[t] );
        copies[t] = (int32_t)whole + ( list->need[t] - whole > draw_tile( key, t ) );
        most = copies[t] > most ? copies[t] : most;
    }
    return most;
}

int rf_pack_needy( const RfHarvest* harvest, uint64_t key, int count, int* tiles, RfHarvestScratch* scratch, int32_t* copy )
{
    Tiles list;
    int32_t copies[RF_LANES], pixel[RF_LANES], number[RF_LANES];
    list_tiles( harvest, count, *tiles, scratch, &list );
    memcpy( pixel, scratch->pixel, (size_t)count * sizeof *pixel );
    int most = count_copies( &list, key, copies ), wavefront = 0, used = 0, left = 0;
    *tiles = 0;
    for ( int k = 0; k < most; ++k )
    {
        for ( int t = 0; t < list.count; ++t )
        {
            number[t] = -1;
            if ( copies[t] <= k )
                continue;
            wavefront += used + list.size[t] > RF_PATCH_PIXELS;
            used = used + list.size[t] > RF_PATCH_PIXELS ? list.size[t] : used + list.size[t];
            if ( wavefront == harvest->round )
                number[t] = ( *tiles )++;
        }
        for ( int i = 0; i < count; ++i )
        {
            if ( number[list.of[i]] < 0 )
                continue;
            scratch->pixel[left] = pixel[i];
            scratch->tile_of[left] = number[list.of[i]];
            copy[left++] = k;
        }
    }
    return left;
}

void rf_draw_places( const RfPixelFilter* filter, const RfEye* eye, int count, const int32_t* pixel, float random[][RF_LANES] )
{
    for ( int i = 0; i < count; ++i )
    {
        int y = pixel[i] / eye->width, x = pixel[i] - y * eye->width;
        random[0][i] = rf_draw_filter_place( filter, x, eye->width, random[0][i] );
        random[1][i] = rf_draw_filter_place( filter, y, eye->height, random[1][i] );
    }
}
