// Cuts films into extended tiles, and traces their pixels through the harvest of frames and tiles.
#include "gradient/sampling.h"

#include "path/lanes.h"
#include "reuse/accumulate/accumulate.h"
#include "reuse/harvest/camera_rays.h"
#include "reuse/harvest/hit_list.h"
#include "reuse/harvest/own_frame.h"
#include "reuse/harvest/record_weights.h"
#include "reuse/harvest/visibility.h"
#include "reuse/tile/tile.h"

#include <string.h>

#define SALT 0x6d41e00000000u     // keeps the random numbers of the shift apart
#define TILE_SALT 0x3b1c00000000u // keeps the random numbers of tiles apart from those of paths

static int up( int a, int b ) { return ( a + b - 1 ) / b; }
static int at_most( int a, int b ) { return a < b ? a : b; }
static int at_least( int a, int b ) { return a > b ? a : b; }

RfExtendedTiles rf_lay_out_extended_tiles( const RfTile* tile, bool scattered, int width, int height )
{
    RfExtendedTiles l = { .film_width = width, .film_height = height, .scattered = scattered };
    l.pairs = tile->kind == RF_TILE_NONE;
    l.width = l.pairs ? 1 : tile->width;
    l.height = l.pairs ? 1 : tile->height;
    l.across = up( width + l.width - 1, l.width );
    l.down = up( height + l.height - 1, l.height );
    int tiles = RF_PATCH_PIXELS / ( l.pairs ? 4 * rf_extended_pixels( tile ) : rf_extended_pixels( tile ) );
    l.patch_across = 1;
    while ( ( l.patch_across + 1 ) * ( l.patch_across + 1 ) <= tiles )
        ++l.patch_across;
    l.patch_down = tiles / l.patch_across;
    l.patches_x = up( l.across, l.patch_across );
    l.patches = l.patches_x * up( l.down, l.patch_down );
    return l;
}

// The number of tile k of a patch; past the last one: none.
static int tile_number( const RfExtendedTiles* l, int patch, int k )
{
    if ( l->scattered )
        return k * l->patches + patch;
    int x = patch % l->patches_x * l->patch_across + k % l->patch_across;
    int y = patch / l->patches_x * l->patch_down + k / l->patch_across;
    return x < l->across && y < l->down ? y * l->across + x : l->across * l->down;
}

// The pairs of pixel (x, y) with its neighbours on the film, left, right, above and below.
static int list_pairs( const RfExtendedTiles* l, int x, int y, RfExtendedTile* tiles )
{
    static const int s_step[4][2] = { { -1, 0 }, { 1, 0 }, { 0, -1 }, { 0, 1 } };
    int count = 0;
    for ( int k = 0; k < 4; ++k )
    {
        int dx = s_step[k][0], dy = s_step[k][1];
        if ( x + dx < 0 || y + dy < 0 || x + dx >= l->film_width || y + dy >= l->film_height )
            continue;
        int x0 = at_most( x, x + dx ), y0 = at_most( y, y + dy ), x1 = at_least( x, x + dx ) + 1, y1 = at_least( y, y + dy ) + 1;
        tiles[count] = ( RfExtendedTile ){ y * l->film_width + x, x0, y0, x1, y1, count == 0 ? x1 : x0, y1, dx + dy < 0 };
        ++count;
    }
    return count;
}

int rf_list_extended_tiles( const RfExtendedTiles* l, uint64_t pass_key, int patch, RfExtendedTile* tiles )
{
    uint64_t state = rf_mix64( pass_key ^ SALT );
    int shift_x = (int)( ( state >> 32 ) % (uint64_t)l->width );
    int shift_y = (int)( ( state & 0xffffffffu ) % (uint64_t)l->height );
    int count = 0;
    for ( int k = 0; k < l->patch_across * l->patch_down; ++k )
    {
        int number = tile_number( l, patch, k );
        int x = number % l->across * l->width - shift_x, y = number / l->across * l->height - shift_y;
        if ( number >= l->across * l->down || x + l->width <= 0 || y + l->height <= 0 || x >= l->film_width ||
             y >= l->film_height )
            continue;
        int right = at_most( x + l->width + 1, l->film_width ), bottom = at_most( y + l->height + 1, l->film_height );
        if ( l->pairs )
            count += list_pairs( l, x, y, tiles + count );
        else
            tiles[count++] = ( RfExtendedTile ){ number,
                                                 at_least( x, 0 ),
                                                 at_least( y, 0 ),
                                                 right,
                                                 bottom,
                                                 at_most( x + l->width, l->film_width ),
                                                 at_most( y + l->height, l->film_height ),
                                                 0 };
    }
    return count;
}

struct RfGradientScratch
{
    RfHarvestScratch* harvest;
    RfHitBatch* hits;
    int32_t pixel[RF_LANES];     // by slot
    int32_t own_pixel[RF_LANES]; // the same, −1 where the pixel is not its tile's own
    int32_t number[RF_LANES];    // of its tile in the pass
    int32_t source[RF_LANES];    // tiles of one pixel: of the paths (reuse/tile/tile_paths.h)
    float missed[RF_LANES];      // 1 where the camera ray did, with RF_AOV_ALPHA
    char* accumulate;            // workspace of accumulation
    RfArrivals arrivals;         // kept while some are left out
};

void rf_compile_gradients( const RfEstimatorGroup* group, RfGradientPlan* out )
{
    RfTile tile = group->settings->tile;
    out->settings = *group->settings;
    out->settings.tile = ( RfTile ){ RF_TILE_BLOCK, tile.width + 1, tile.height + 1 };
    if ( tile.kind == RF_TILE_NONE )
        out->settings.tile = ( RfTile ){ RF_TILE_BLOCK, 2, 1 };
    out->settings.filter = RF_FILTER_BOX; // samples are drawn by the filter, and count in their own pixels
    out->settings.filter_width = 1.0;
    RfEstimatorGroup extended = *group;
    extended.settings = &out->settings;
    // in differences of pixels with common random numbers most of the noise of light samples is gone
    rf_compile_reuse( &extended, true, &out->reuse );
    out->tiles = rf_lay_out_extended_tiles( &tile, rf_is_blurred( &group->traits ), group->width, group->height );
}

RfGradientScratch* rf_place_gradient_scratch( const RfGradientPlan* plan, RfLayout* layout )
{
    RfGradientScratch* scratch = rf_take( layout, 1, sizeof *scratch );
    RfHitBatch* hits = rf_place_batch( &plan->reuse.shape, layout );
    RfHarvestScratch* harvest = rf_place_harvest_scratch( &plan->reuse.shape, layout );
    RfLayout accumulation = { 0 };
    rf_place_accumulation( &plan->reuse, &accumulation );
    char* accumulate = rf_take( layout, accumulation.bytes, 1 );
    if ( scratch == NULL )
        return NULL;
    scratch->accumulate = accumulate;
    scratch->hits = hits;
    scratch->harvest = harvest;
    return scratch;
}

// Lists the pixels of the tiles: each lane is a pixel of its own, since tiles overlap. Returns how many.
static int list_pixels( const RfGradientBatch* batch, int width, bool pairs, RfGradientScratch* scratch )
{
    RfHarvestScratch* harvest = scratch->harvest;
    int count = 0;
    for ( int t = 0; t < batch->tile_count; ++t )
    {
        const RfExtendedTile* tile = batch->tile + t;
        int first = count;
        for ( int y = tile->y0; y < tile->y1; ++y )
        {
            for ( int x = tile->x0; x < tile->x1; ++x, ++count )
            {
                bool own = x < tile->own_x1 && y < tile->own_y1 && ( !pairs || count - first == tile->source );
                scratch->pixel[count] = y * width + x;
                scratch->own_pixel[count] = own ? scratch->pixel[count] : -1;
                scratch->number[count] = tile->number;
                harvest->pixel[count] = count; // of a film with one pixel for each lane
                harvest->tile_of[count] = t;
            }
        }
    }
    harvest->tile_count = batch->tile_count;
    return count;
}

// The slots with the paths of pairs, of which those of a pixel follow each other.
static void find_sources( const RfGradientBatch* batch, RfGradientScratch* scratch )
{
    int32_t first = 0;
    memset( scratch->source, -1, sizeof scratch->source );
    for ( int t = 0; t < batch->tile_count; ++t )
    {
        const RfExtendedTile* tile = batch->tile + t;
        if ( t == 0 || tile->number != tile[-1].number )
            first = 2 * t + tile->source;
        scratch->source[2 * t + tile->source] = first;
    }
}

// The same random numbers for all pixels of a tile.
static void set_tile_keys( uint64_t pass_key, int count, RfGradientScratch* scratch )
{
    RfWavefront* wavefront = &scratch->harvest->wavefront;
    for ( int i = 0; i < count; ++i )
    {
        RfRandomKey key = rf_pixel_key( pass_key ^ TILE_SALT, (uint32_t)scratch->number[i] );
        wavefront->key_a[i] = key.a;
        wavefront->key_b[i] = key.b;
    }
}

// Random numbers of its own for each path; the pixels of a pair have those of its one path.
static void set_path_keys( uint64_t pass_key, const RfEstimatorGroup* group, const RfGradientBatch* batch,
                           RfGradientScratch* scratch )
{
    RfWavefront* wavefront = &scratch->harvest->wavefront;
    bool pairs = group->settings->tile.kind == RF_TILE_NONE;
    uint32_t area = (uint32_t)rf_extended_pixels( &group->settings->tile );
    for ( int t = 0, i = 0; t < batch->tile_count; ++t )
    {
        for ( int k = 0; k < rf_tile_area( batch->tile + t ); ++k, ++i )
        {
            RfRandomKey key = rf_pixel_key( pass_key, (uint32_t)batch->tile[t].number * area + (uint32_t)( pairs ? 0 : k ) );
            wavefront->key_a[i] = key.a;
            wavefront->key_b[i] = key.b;
        }
    }
}

// Camera rays, and what they hit.
static void find_hits( const RfHarvest* harvest, const RfPixelFilter* filter, int count, RfGradientScratch* scratch,
                       RfRayCounts* rays )
{
    RfHarvestScratch* h = scratch->harvest;
    RfWavefront* wavefront = &h->wavefront;
    rf_clear_ray_counts( wavefront );
    rf_make_camera_rays( filter, harvest->eyes + scratch->hits->eye, count, scratch->pixel, wavefront, &h->camera_rays );
    rf_find_first_hits( harvest, h );
    rays->primary += (uint64_t)count;
    rf_follow_camera_rays( harvest, h );
    rf_draw_sides( wavefront, 1, h->hits ); // alike in all pixels of a tile
    rf_list_hits( harvest, count, h, scratch->hits );
}

// The rest of the paths.
static void light_hits( const RfHarvest* harvest, int count, RfGradientScratch* scratch, RfRayCounts* rays )
{
    RfHarvestScratch* h = scratch->harvest;
    RfWavefront* wavefront = &h->wavefront;
    memset( &wavefront->arrivals, 0, sizeof wavefront->arrivals );
    wavefront->rays.count = 0;
    rf_scale_roulette( h, count );
    if ( harvest->path.max_depth > 1 )
    {
        rf_trace_hit_tails( harvest, h, rays );
        rays->thinned += (uint64_t)h->tiles->thinned;
        rays->kept += (uint64_t)h->tiles->kept;
    }
    rays->path += wavefront->path_rays;
    rays->shadow += wavefront->shadow_rays;
    rf_test_batch_visibility( harvest, scratch->hits, h, rays );
}

// The radiance of every lane, by way of a film with a pixel for each.
static void add_up( const RfEstimatorGroup* group, const RfHarvest* harvest, float ( *value )[4], RfGradientScratch* scratch )
{
    rf_weight_batch( harvest, scratch->hits, scratch->harvest );
    if ( harvest->shape->own_frame_light )
        rf_light_own_frame( harvest, scratch->hits, scratch->harvest );
    memset( value, 0, sizeof( float[RF_LANES][4] ) );
    memset( scratch->missed, 0, sizeof scratch->missed );
    bool alpha = ( group->settings->aovs & RF_AOV_BIT( RF_AOV_ALPHA ) ) != 0;
    RfFilm film = { .half = { value[0] } };
    RfAccumulateJob job = {
        .eye = scratch->hits->eye, .end_row = RF_LANES, .films = &film, .weight = 1.0f, .sky = alpha ? scratch->missed : NULL
    };
    rf_accumulate_rows( group, job, &( void* ){ scratch->hits }, 1, scratch->accumulate );
    for ( int i = 0; i < RF_LANES; ++i )
        value[i][3] = scratch->missed[i];
}

// Takes out of the arrivals what tiles do not share: light that a scattered ray meets, and what comes by way of second vertices
// that no other pixel can connect to. Returns whether there was any.
static bool drop_unshared( const RfTileReuse* reuse, bool shares, RfArrivals* arrivals )
{
    bool shared[RF_LANES] = { false }, any = false;
    const RfVertexLanes* y = &reuse->second.lanes;
    int count = shares && y->count > 0 ? rf_record_count( y ) : 0; // without rays, the vertices are not sorted by kind
    for ( int a = 0; a < count; ++a )
        shared[y->slot[a]] = reuse->second.owner[a] >= 0;
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < RF_LANES; ++i )
        {
            float rest = shared[i] ? arrivals->rest[c][i] : 0.0f;
            any = any || arrivals->emitted[c][i] != 0.0f || arrivals->rest[c][i] != rest;
            arrivals->emitted[c][i] = 0.0f;
            arrivals->rest[c][i] = rest;
        }
    }
    return any;
}

// Values with the light samples that tiles have in common: without what tiles do not share, and that by itself.
static void find_common( const RfEstimatorGroup* group, const RfHarvest* harvest, RfGradientBatch* batch,
                         RfGradientScratch* scratch )
{
    RfArrivals* arrivals = &scratch->harvest->wavefront.arrivals;
    scratch->arrivals = *arrivals;
    bool any = drop_unshared( scratch->harvest->tiles, harvest->path.max_depth > 2, arrivals );
    add_up( group, harvest, batch->value, scratch );
    *arrivals = scratch->arrivals;
    for ( int i = 0; i < RF_LANES; ++i )
        memcpy( batch->common[i], batch->value[i], sizeof batch->common[i] );
    if ( any )
        add_up( group, harvest, batch->value, scratch );
    for ( int i = 0; i < RF_LANES; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->unshared[i][c] = batch->value[i][c] - batch->common[i][c];
    }
}

// Adds values with light samples of each pixel. A pair has a single path, whose differences are those of its values.
static void find_values( const RfEstimatorGroup* group, const RfHarvest* harvest, bool pairs, RfGradientBatch* batch,
                         RfGradientScratch* scratch, RfRayCounts* rays )
{
    if ( !pairs && harvest->path.max_depth > 1 )
    {
        find_common( group, harvest, batch, scratch );
        rf_sample_direct( harvest, scratch->harvest, rays );
        add_up( group, harvest, batch->value, scratch );
        return;
    }
    add_up( group, harvest, batch->value, scratch );
    memset( batch->unshared, 0, sizeof batch->unshared );
    for ( int i = 0; i < RF_LANES; ++i )
        memcpy( batch->common[i], batch->value[i], sizeof batch->common[i] );
}

int rf_sample_patch( const RfEstimatorGroup* group, RfTraceJob job, RfGradientBatch* batch, RfGradientScratch* scratch,
                     RfRayCounts* rays )
{
    const RfGradientPlan* plan = group->compiled;
    const RfExtendedTiles* tiles = &plan->tiles;
    RfEstimatorGroup extended = *group; // as the harvest of frames and tiles sees it: whole extended tiles
    extended.settings = &plan->settings;
    extended.compiled = &plan->reuse;
    extended.filter = NULL;
    RfHarvest harvest = rf_make_harvest( &extended );
    harvest.path_roulette = true;
    uint64_t key = rf_harvest_key( &harvest, job.eye, job.pass );
    scratch->hits->eye = batch->eye = job.eye;
    if ( harvest.shape->blurred )
        scratch->hits->lens = rf_draw_lens( &harvest, job );
    RfHarvest at = rf_harvest_at( &harvest, job.eye, scratch->hits->lens, scratch->harvest );
    batch->tile_count = rf_list_extended_tiles( tiles, key, job.job, batch->tile );
    int count = list_pixels( batch, group->width, tiles->pairs, scratch );
    if ( tiles->pairs )
    {
        find_sources( batch, scratch );
        at.path_source = scratch->source;
    }
    scratch->harvest->wavefront.lattice.vertex = 0;
    set_tile_keys( key, count, scratch );
    find_hits( &at, group->filter, count, scratch, rays );
    const RfHarvest hits = rf_harvest_hits( &at, job.eye, scratch->harvest );
    if ( hits.path.max_depth > 1 )
        rf_sample_direct( &hits, scratch->harvest, rays );
    set_path_keys( key, group, batch, scratch );
    light_hits( &hits, count, scratch, rays );
    find_values( &extended, &hits, tiles->pairs, batch, scratch, rays );
    return count;
}

RfFirstHits rf_first_hits_of_patch( const RfGradientScratch* scratch )
{
    const RfHarvestScratch* h = scratch->harvest;
    return ( RfFirstHits ){
        .hits = &h->first, .rays = &h->camera_rays, .surfaces = h->surfaces, .pixel = scratch->own_pixel, .features = h->features
    };
}
