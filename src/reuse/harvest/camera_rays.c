// The pixels of a batch and their camera rays: which are sampled, by which random numbers, and by which point of the lens and moment
// of the shutter.
#include "reuse/harvest/camera_rays.h"

#include "render/pieces.h"
#include "scene/projection.h"

#include <math.h>
#include <string.h>

#define LATTICE_SALT 0x1a771ce00000u // keeps the keys of lattices apart
#define LENS_SALT 0x1e4500000000u    // keeps the random numbers of the lens apart

// The lattice of a pass of a frame: its half and its number in that. False for pilots and extra samples, whose numbers are random.
static bool find_point( const RfHarvest* harvest, int eye, int pass, RfLattice* lattice )
{
    if ( harvest->group->passes_before < 0 || harvest->group->need != NULL )
        return false;
    int64_t number = harvest->group->passes_before + pass;
    lattice->half = rf_pass_key( harvest->group->settings->seed ^ LATTICE_SALT, 0, 0, (uint32_t)( number & 1 ) );
    lattice->pass = (uint32_t)( number >> 1 );
    lattice->frame = (uint32_t)( harvest->group->first_frame + eye );
    return true;
}

RfLensSample rf_draw_lens( const RfHarvest* harvest, RfTraceJob job )
{
    uint64_t pass_key = rf_harvest_key( harvest, job.eye, job.pass ) ^ LENS_SALT;
    RfRandomKey key = rf_pixel_key( rf_mix64( pass_key + (uint64_t)harvest->group->round ), (uint32_t)job.job );
    float u[3];
    for ( uint32_t c = 0; c < 3; ++c )
        u[c] = rf_random( key, c );
    RfLattice lattice;
    if ( find_point( harvest, job.eye, job.pass, &lattice ) )
    {
        // A pixel is in another patch in every pass, so all patches have the lattice's points, moved by up to a quarter.
        RfRandomKey half = rf_pixel_key( lattice.half, 0 );
        for ( uint32_t c = 0; c < 3; ++c )
        {
            RfLatticeSteps step = rf_lattice_steps[RF_LATTICE_LENS + c];
            uint32_t word = rf_random_bits( half, RF_DIMENSION_LENS + c ) + step.pass * lattice.pass + step.frame * lattice.frame;
            u[c] = rf_fraction( word + ( rf_random_bits( key, c ) >> 2 ) );
        }
    }
    return ( RfLensSample ){ u[0], u[1], u[2] };
}

// The tiles of the pixels listed for a patch. Without tile reuse each pixel is a tile.
typedef struct Tiles
{
    int count;
    int32_t of[RF_LANES]; // each pixel's
    int32_t size[RF_LANES];
    float need[RF_LANES]; // mean over its pixels
} Tiles;

static void list_tiles( const RfHarvest* harvest, int count, const RfHarvestScratch* scratch, Tiles* out )
{
    bool in_tiles = rf_reuses_tiles( scratch ) && !harvest->group->single;
    out->count = in_tiles ? scratch->tile_count : count;
    memset( out->size, 0, sizeof out->size );
    memset( out->need, 0, sizeof out->need );
    for ( int i = 0; i < count; ++i )
    {
        int t = in_tiles ? scratch->tile_of[i] : i;
        out->of[i] = t;
        out->need[t] += harvest->group->need[scratch->pixel[i]];
        out->size[t] += 1;
    }
    for ( int t = 0; t < out->count; ++t )
        out->need[t] = out->size[t] > 0 ? out->need[t] / (float)out->size[t] : 0.0f;
}

static float draw_tile( uint64_t key, int tile ) { return rf_random( rf_pixel_key( rf_mix64( key ), (uint32_t)tile ), 0 ); }

bool rf_is_patch_traced( const RfHarvest* harvest, RfTraceJob job )
{
    const RfEye* eye = harvest->eyes + job.eye;
    const uint8_t* cells = rf_frame_cells( harvest->group->settings->pieces, harvest->group->first_frame + job.eye );
    int x0, y0, x1, y1;
    rf_bound_patch( &harvest->plan->patches, eye, rf_harvest_key( harvest, job.eye, job.pass ), job.job, &x0, &y0, &x1, &y1 );
    for ( int y = y0 / RF_CELL_SIDE; y < rf_cells_along( y1 ); ++y )
    {
        for ( int x = x0 / RF_CELL_SIDE; x < rf_cells_along( x1 ); ++x )
        {
            if ( rf_is_traced( harvest->group->settings->pieces, cells, x * RF_CELL_SIDE, y * RF_CELL_SIDE ) )
                return true;
        }
    }
    return false;
}

// Drops the listed pixels whose tiles have no pixel in the pieces that are traced. Returns how many are left.
static int choose_traced( const RfHarvest* harvest, int eye, int count, RfHarvestScratch* scratch )
{
    const uint8_t* cells = rf_frame_cells( harvest->group->settings->pieces, harvest->group->first_frame + eye );
    int width = harvest->eyes[eye].width;
    bool in_tiles = rf_reuses_tiles( scratch ), traced[RF_LANES] = { false };
    for ( int i = 0; i < count; ++i )
    {
        int y = scratch->pixel[i] / width, x = scratch->pixel[i] - y * width;
        int tile = in_tiles ? scratch->tile_of[i] : i;
        traced[tile] = traced[tile] || rf_is_traced( harvest->group->settings->pieces, cells, x, y );
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

// Adaptive sampling by rounds: a tile is sampled with the probability mean need − harvest->group->round. Returns how many pixels are
// left.
static int choose_needy( const RfHarvest* harvest, uint64_t key, int count, RfHarvestScratch* scratch )
{
    Tiles list;
    list_tiles( harvest, count, scratch, &list );
    bool chosen[RF_LANES];
    for ( int t = 0; t < list.count; ++t )
        chosen[t] = list.size[t] > 0 && list.need[t] - (float)harvest->group->round > draw_tile( key, t );
    int left = 0;
    for ( int i = 0; i < count; ++i )
    {
        scratch->pixel[left] = scratch->pixel[i];
        scratch->tile_of[left] = list.of[i];
        left += chosen[list.of[i]];
    }
    return left;
}

// Samples per tile: the integer part of its need, and one more with the fraction as probability.
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

// All rounds at once: each sample of a tile is a tile of its own, copy[] its number among these. Tiles are packed into
// wavefronts, of which this lists number harvest->group->round.
static int pack_needy( const RfHarvest* harvest, uint64_t key, int count, RfHarvestScratch* scratch, int32_t* copy )
{
    Tiles list;
    int32_t copies[RF_LANES], pixel[RF_LANES], number[RF_LANES];
    list_tiles( harvest, count, scratch, &list );
    memcpy( pixel, scratch->pixel, (size_t)count * sizeof *pixel );
    int most = count_copies( &list, key, copies ), wavefront = 0, used = 0, left = 0;
    scratch->tile_count = 0;
    for ( int k = 0; k < most; ++k )
    {
        for ( int t = 0; t < list.count; ++t )
        {
            number[t] = -1;
            if ( copies[t] <= k )
                continue;
            wavefront += used + list.size[t] > RF_PATCH_PIXELS;
            used = used + list.size[t] > RF_PATCH_PIXELS ? list.size[t] : used + list.size[t];
            if ( wavefront == harvest->group->round )
                number[t] = scratch->tile_count++;
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

static void make_keys( uint64_t pass_key, int count, const int32_t* pixel, RfWavefront* wavefront )
{
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfRandomKey key = rf_pixel_key( pass_key, (uint32_t)pixel[i] );
        wavefront->key_a[i] = key.a;
        wavefront->key_b[i] = key.b;
    }
}

static void set_lattice( const RfHarvest* harvest, RfTraceJob job, int count, const int32_t* pixel, RfLattice* lattice )
{
    uint32_t width = (uint32_t)harvest->eyes[job.eye].width;
    bool found = find_point( harvest, job.eye, job.pass, lattice );
    lattice->vertex = found ? RF_DIMENSION_LIGHTS + 3u * (uint32_t)harvest->path.light_samples : 0;
    for ( int i = 0; found && i < count; ++i )
        rf_set_lattice_pixel( lattice, i, (uint32_t)pixel[i] % width, (uint32_t)pixel[i] / width );
}

// Extra samples of a pixel take the random numbers of later passes.
static void make_copies_keys( const RfHarvest* harvest, RfTraceJob job, int count, const int32_t* copy,
                              RfHarvestScratch* scratch )
{
    for ( int i = 0; i < count; ++i )
    {
        RfRandomKey key = rf_pixel_key( rf_harvest_key( harvest, job.eye, job.pass + copy[i] ), (uint32_t)scratch->pixel[i] );
        scratch->wavefront.key_a[i] = key.a;
        scratch->wavefront.key_b[i] = key.b;
    }
}

int rf_list_pixels( const RfHarvest* harvest, RfTraceJob job, RfHarvestScratch* scratch )
{
    const RfEye* eye = harvest->eyes + job.eye;
    RfWavefront* wavefront = &scratch->wavefront;
    uint64_t key = rf_harvest_key( harvest, job.eye, job.pass );
    int count =
        rf_list_patch( &harvest->plan->patches, eye, key, job.job, scratch->pixel, scratch->tile_of, &scratch->tile_count );
    int32_t copy[RF_LANES];
    if ( rf_is_adaptive( harvest ) && harvest->group->packed )
        count = pack_needy( harvest, key, count, scratch, copy );
    else if ( rf_is_adaptive( harvest ) )
        count = choose_needy( harvest, key, count, scratch );
    else if ( harvest->group->settings->pieces != NULL )
        count = choose_traced( harvest, job.eye, count, scratch );
    make_keys( key, count, scratch->pixel, wavefront );
    set_lattice( harvest, job, count, scratch->pixel, &wavefront->lattice );
    if ( rf_is_adaptive( harvest ) && harvest->group->packed )
        make_copies_keys( harvest, job, count, copy, scratch );
    return count;
}

// Importance samples the pixel filter: turns uniform numbers into places in the pixels.
static void draw_places( const RfPixelFilter* filter, const RfEye* eye, int count, const int32_t* pixel,
                         float random[][RF_LANES] )
{
    for ( int i = 0; i < count; ++i )
    {
        int y = pixel[i] / eye->width, x = pixel[i] - y * eye->width;
        random[0][i] = rf_draw_filter_place( filter, x, eye->width, random[0][i] );
        random[1][i] = rf_draw_filter_place( filter, y, eye->height, random[1][i] );
    }
}

// Rays of orthographic and panoramic cameras.
static void make_other_rays( const RfEye* eye, int count, const int32_t* pixel, float ( *random )[RF_LANES], RfRayLanes* rays )
{
    const float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 o, d;
        rf_eye_ray( eye, inverse, pixel[i] % eye->width, pixel[i] / eye->width, random[0][i], random[1][i], &o, &d );
        RF_PUT3( rays->o, i, o );
        RF_PUT3( rays->d, i, d );
    }
}

void rf_make_camera_rays( const RfPixelFilter* filter, const RfEye* eye, int count, const int32_t* pixel, RfWavefront* wavefront,
                          RfRayLanes* rays )
{
    int32_t* slot = rays->slot;
    for ( int i = 0; i < count; ++i )
    {
        slot[i] = i;
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][i] = 1.0f;
    }
    float( *random )[RF_LANES] = wavefront->scratch.random;
    rf_draw_lanes( wavefront, count, slot, RF_DIMENSION_FILM_X, 2, random );
    if ( rf_has_filter( filter ) )
        draw_places( filter, eye, count, pixel, random );
    RfEye e = *eye;
    const float inverse[2] = { 1.0f / e.focal_x, 1.0f / e.focal };
    RfVec3 origin = rf_pinhole_origin( &e );
    int straight = rf_is_perspective( eye ) ? count : 0;
    if ( straight < count )
        make_other_rays( eye, count, pixel, random, rays );
#pragma omp simd
    for ( int i = 0; i < straight; ++i )
    {
        int y = pixel[i] / e.width, x = pixel[i] - y * e.width;
        RfVec3 d = rf_pinhole_ray( &e, inverse, x, y, random[0][i], random[1][i] );
        RF_PUT3( rays->o, i, origin );
        RF_PUT3( rays->d, i, d );
    }
    rays->count = count;
    bool parallel = rf_is_parallel( eye );
    rays->pixel_width = parallel ? inverse[1] : 0.0f;
    rays->pixel_spread = parallel ? 0.0f : inverse[1];
}
