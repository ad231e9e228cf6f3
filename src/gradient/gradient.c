// The table entry of gradient-domain path reusing (render/estimator.h).
#include "gradient/gradient.h"

#include "reframe/reconstruct.h"
#include "reuse/accumulate/accumulate.h"
#include "reuse/harvest/camera_rays.h"
#include "reuse/harvest/hit_list.h"
#include "reuse/harvest/own_frame.h"
#include "reuse/harvest/record_weights.h"
#include "reuse/harvest/visibility.h"
#include "reuse/tile/tile.h"

#include <math.h>
#include <string.h>

// Tiles: films are cut into extended tiles, whose pixels are traced through the harvest of frames and tiles. They share their
// paths (src/reuse/estimators.md, E4), the position inside the pixel, and random numbers in chains. For differences they also
// share the light samples of first hits; values have their own, since a common error of a whole tile would show in no difference.

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

// A patch, as the films need it.
typedef struct GradientBatch
{
    int eye; // index in the group of the frame whose pixels these are
    int tile_count;
    RfExtendedTile tile[RF_LISTED_TILES];
    float value[RF_LANES][4];    // radiance: red, green, blue, and 1 where the camera ray missed; tile after tile, row after row
    float common[RF_LANES][3];   // radiance with the light samples that the tile has in common: for differences
    float unshared[RF_LANES][3]; // what tiles do not share; not part of `common`
} GradientBatch;

// A thread's workspace.
typedef struct GradientScratch
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
} GradientScratch;

// A group compiled.
typedef struct GradientPlan
{
    RfExtendedTiles tiles;     // of its films
    RfRenderSettings settings; // as the harvest of frames and tiles has them: with whole extended tiles
    RfReusePlan reuse;
} GradientPlan;

static void compile( const RfEstimatorGroup* group, void* compiled )
{
    GradientPlan* out = compiled;
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

static GradientScratch* place_gradient_scratch( const GradientPlan* plan, RfLayout* layout )
{
    GradientScratch* scratch = rf_take( layout, 1, sizeof *scratch );
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
static int list_pixels( const GradientBatch* batch, int width, bool pairs, GradientScratch* scratch )
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
static void find_sources( const GradientBatch* batch, GradientScratch* scratch )
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
static void set_tile_keys( uint64_t pass_key, int count, GradientScratch* scratch )
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
static void set_path_keys( uint64_t pass_key, const RfEstimatorGroup* group, const GradientBatch* batch,
                           GradientScratch* scratch )
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
static void find_hits( const RfHarvest* harvest, const RfPixelFilter* filter, int count, GradientScratch* scratch,
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

static void light_hits( const RfHarvest* harvest, int count, GradientScratch* scratch, RfRayCounts* rays )
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
static void add_up( const RfEstimatorGroup* group, const RfHarvest* harvest, float ( *value )[4], GradientScratch* scratch )
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
static void find_common( const RfEstimatorGroup* group, const RfHarvest* harvest, GradientBatch* batch, GradientScratch* scratch )
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
static void find_values( const RfEstimatorGroup* group, const RfHarvest* harvest, bool pairs, GradientBatch* batch,
                         GradientScratch* scratch, RfRayCounts* rays )
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

// Fills the batch with patch job.job.
static int trace( const RfEstimatorGroup* group, RfTraceJob job, void* batch_memory, void* scratch_memory, RfRayCounts* rays )
{
    GradientBatch* batch = batch_memory;
    GradientScratch* scratch = scratch_memory;
    const GradientPlan* plan = group->compiled;
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

static RfFirstHits first_hits( const void* memory )
{
    const GradientScratch* scratch = memory;
    const RfHarvestScratch* h = scratch->harvest;
    return ( RfFirstHits ){
        .hits = &h->first, .rays = &h->camera_rays, .surfaces = h->surfaces, .pixel = scratch->own_pixel, .features = h->features
    };
}

// Films, and the picture that fits them best (E9). The two halves of the passes are independent. Each is solved with weights from
// the other, so the image is unbiased, and the difference of the solutions estimates its noise.

// Of the solve with constant weights: tiles leave less noise in pixels than path tracing does, for which 0.2 is usual.
#define ALPHA 0.5f
// Few passes say little about the variance of differences: a half that misses a rare path would trust them too
// much. So this share of the pixel's variance, over the passes of both halves, is added to it.
#define LEAST_SHARE 0.4f
// Relative residual at which the solve with weights stops, times the passes: far below the noise.
#define TOLERANCE 1e-3
#define LEAST_TOLERANCE 1e-6 // which floats reach
// Conjugate gradients that have not converged by then are reported of. Very noisy weights take some twenty.
#define MOST_ITERATIONS 50

typedef struct Target
{
    float* film[RF_GRADIENT_FILMS];
    float weight, primal_weight; // of differences, of values
    int width;
} Target;

// Adds `value` with its weight to a film, and its square to that of the squares.
static inline void add( const Target* t, int film, size_t pixel, float weight, const float value[3] )
{
    float *sum = t->film[film] + 4 * pixel, square = 0.0f;
    for ( int c = 0; c < 3; ++c )
    {
        sum[c] += weight * value[c];
        square += value[c] * value[c];
    }
    sum[3] += weight;
    t->film[RF_FILM_SQUARES][4 * pixel + (size_t)film] += weight * square;
}

static inline void add_difference( const Target* t, int film, size_t pixel, const float here[3], const float there[3] )
{
    add( t, film, pixel, t->weight, ( float[3] ){ there[0] - here[0], there[1] - here[1], there[2] - here[2] } );
}

static inline void add_unshared( const Target* t, size_t pixel, const float value[3] )
{
    float* sum = t->film[RF_FILM_UNSHARED] + 4 * pixel;
    for ( int c = 0; c < 3; ++c )
        sum[c] += t->primal_weight * value[c];
    sum[3] += t->primal_weight;
}

// Adds the rows of a tile that belong to the job. All its pixels and pairs count, also those that other tiles have.
static uint64_t add_tile( const Target* t, const RfExtendedTile* tile, const GradientBatch* batch, int lane, RfAccumulateJob job )
{
    int across = tile->x1 - tile->x0;
    int first = tile->y0 > job.first_row ? tile->y0 : job.first_row, end = tile->y1 < job.end_row ? tile->y1 : job.end_row;
    for ( int y = first; y < end; ++y )
    {
        for ( int x = tile->x0; x < tile->x1; ++x )
        {
            int here = lane + ( y - tile->y0 ) * across + ( x - tile->x0 );
            size_t pixel = (size_t)y * (size_t)t->width + (size_t)x;
            add( t, RF_FILM_PRIMAL, pixel, t->primal_weight, batch->value[here] );
            add_unshared( t, pixel, batch->unshared[here] );
            if ( x + 1 < tile->x1 )
                add_difference( t, RF_FILM_DX, pixel, batch->common[here], batch->common[here + 1] );
            if ( y + 1 < tile->y1 )
                add_difference( t, RF_FILM_DY, pixel, batch->common[here], batch->common[here + across] );
            if ( job.landed != NULL )
                job.landed[pixel] += 1;
            if ( job.sky != NULL )
                job.sky[pixel] += t->primal_weight * batch->value[here][3];
        }
    }
    return end > first ? (uint64_t)( end - first ) * (uint64_t)across : 0;
}

// Adds batches to some rows of the films; returns how many samples landed there.
static uint64_t accumulate( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                            void* scratch )
{
    (void)scratch;
    // a pixel is in eight pairs, of which four have the same path
    float share = group->settings->tile.kind == RF_TILE_NONE ? 0.25f : 1.0f;
    Target target = { .weight = job.weight, .primal_weight = share * job.weight, .width = group->width };
    for ( int f = 0; f < RF_GRADIENT_FILMS; ++f )
        target.film[f] = job.films[f].half[job.half];
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const GradientBatch* batch = batches[k];
        int lane = 0;
        for ( int i = 0; i < batch->tile_count && batch->eye == job.eye; ++i )
        {
            landed += add_tile( &target, batch->tile + i, batch, lane, job );
            lane += rf_tile_area( batch->tile + i );
        }
    }
    return landed;
}

// What the solve works on, by half: means of the three films, 9 floats a pixel, and their variances, 3; the solution, 4.
typedef struct Work
{
    float *means[2], *variance[2], *solution[2];
    void* solver;
} Work;

typedef struct Halves
{
    RfGradientHalf half[2];
    float* solution[2]; // of each half alone
} Halves;

static size_t pixels_of( const RfFilm* film ) { return (size_t)film->width * (size_t)film->height; }

static Work place_work( int width, int height, RfLayout* layout )
{
    size_t pixels = (size_t)width * (size_t)height;
    Work work;
    for ( int h = 0; h < 2; ++h )
    {
        work.means[h] = rf_take( layout, 9 * pixels, sizeof( float ) );
        work.variance[h] = rf_take( layout, 3 * pixels, sizeof( float ) );
        work.solution[h] = rf_take( layout, 4 * pixels, sizeof( float ) );
    }
    work.solver = rf_take( layout, rf_reconstruct_bytes( width, height ), 1 );
    return work;
}

size_t rf_finish_gradients_bytes( const RfRenderSettings* settings, int width, int height )
{
    if ( settings->reconstruction == RF_RECONSTRUCTION_NONE )
        return 0;
    RfLayout layout = { 0 };
    place_work( width, height, &layout );
    return layout.bytes;
}

// Mean and variance of the mean of one film in one half. With a single value the variance is not known: its square, which
// is above it, stands for it.
static void find_means( const RfFilm* films, int f, int h, float* mean, float* variance )
{
    const RfFilm *film = films + f, *squares = films + RF_FILM_SQUARES;
    for ( size_t i = 0; i < pixels_of( film ); ++i )
    {
        double sums[4], of_squares[4], square = 0.0;
        rf_film_sums_at( film, i, h, sums );
        rf_film_sums_at( squares, i, h, of_squares );
        double count = sums[3];
        for ( size_t c = 0; c < 3; ++c )
        {
            double value = count > 0.0 ? sums[c] / count : 0.0;
            mean[3 * i + c] = (float)value;
            square += value * value;
        }
        double mean_square = count > 0.0 ? of_squares[f] / count : 0.0;
        variance[i] = (float)( count > 1.0 ? fmax( mean_square - square, 0.0 ) / ( count - 1.0 ) : mean_square );
    }
}

// Differences get what tiles do not share from the means of the pixels, so that all four of a pixel have the same.
static void add_unshared_steps( const RfFilm* films, int first, int last, float* means )
{
    for ( int f = RF_FILM_DX; f <= RF_FILM_DY; ++f )
        rf_add_film_steps( films + RF_FILM_UNSHARED, first, last, f == RF_FILM_DY, means + 3 * pixels_of( films ) * (size_t)f );
}

static void bound_variances( float share, size_t pixels, float* variance )
{
    for ( size_t i = 0; i < pixels; ++i )
    {
        variance[pixels + i] += share * variance[i];
        variance[2 * pixels + i] += share * variance[i];
    }
}

static Halves load_halves( const RfFilm* films, const Work* work )
{
    size_t pixels = pixels_of( films );
    Halves out;
    for ( int h = 0; h < 2; ++h )
    {
        float *means = work->means[h], *variance = work->variance[h];
        for ( int f = 0; f < RF_FILM_SQUARES; ++f )
            find_means( films, f, h, means + 3 * pixels * (size_t)f, variance + pixels * (size_t)f );
        add_unshared_steps( films, h, h, means );
        bound_variances( LEAST_SHARE / (float)( films->passes[0] + films->passes[1] ), pixels, variance );
        out.half[h] = ( RfGradientHalf ){
            .images = { films->width, films->height, means, means + 3 * pixels, means + 6 * pixels },
            .variance = variance,
            .variance_dx = variance + pixels,
            .variance_dy = variance + 2 * pixels,
            .passes = films->passes[h],
        };
        out.solution[h] = work->solution[h];
    }
    return out;
}

// Constant weights, or L1, which is not linear: each half by itself, for the noise, and all data together.
static RfResult solve_constant( const RfFilm* films, const Halves* halves, const RfReconstructOptions* options, float* rgb,
                                RfReconstructInfo* info )
{
    RfResult result = RF_OK;
    for ( int h = 0; h < 2 && result == RF_OK; ++h )
    {
        if ( halves->half[h].passes > 0.0 )
            result = rf_reconstruct( &halves->half[h].images, NULL, options, halves->solution[h], NULL, NULL );
    }
    float* means = (float*)halves->half[0].images.primal;
    for ( int f = 0; f < RF_FILM_SQUARES; ++f )
        rf_combine_film( films + f, RF_NORMALIZE_RATIO, means + 3 * pixels_of( films ) * (size_t)f, NULL );
    add_unshared_steps( films, 0, 1, means );
    return result == RF_OK ? rf_reconstruct( &halves->half[0].images, NULL, options, rgb, info, NULL ) : result;
}

static RfResult solve( const RfRenderSettings* settings, const RfFilm* films, const Halves* halves, void* work, float* rgb,
                       RfReconstructInfo* info )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    bool variances = halves->half[0].passes >= 2.0 && halves->half[1].passes >= 2.0;
    options.alpha = ALPHA;
    options.tolerance = fmax( TOLERANCE / ( halves->half[0].passes + halves->half[1].passes ), LEAST_TOLERANCE );
    options.max_iterations = MOST_ITERATIONS;
    options.work = work;
    options.method = RF_RECONSTRUCT_WEIGHTED;
    if ( settings->reconstruction == RF_RECONSTRUCTION_L1 )
        options.method = RF_RECONSTRUCT_L1;
    else if ( settings->reconstruction == RF_RECONSTRUCTION_L2 || !variances )
        options.method = RF_RECONSTRUCT_L2;
    return options.method == RF_RECONSTRUCT_WEIGHTED
               ? rf_reconstruct_halves( halves->half, &options, rgb, halves->solution, info, NULL )
               : solve_constant( films, halves, &options, rgb, info );
}

// The noise of the picture, as that of a film with the solutions as its halves, which are spread to four floats a pixel in place.
static RfRelmse estimate_noise( const Halves* halves, const RfFilm* film, const RfPicture* picture )
{
    RfFilm solved = { .width = film->width, .height = film->height };
    for ( int h = 0; h < 2; ++h )
    {
        float* solution = halves->solution[h];
        for ( size_t i = pixels_of( film ); i-- > 0; )
        {
            float of_pixel[4] = { solution[3 * i], solution[3 * i + 1], solution[3 * i + 2], 1.0f };
            for ( size_t c = 0; c < 4; ++c )
                solution[4 * i + c] = (float)halves->half[h].passes * of_pixel[c];
        }
        solved.half[h] = solution;
        solved.passes[h] = film->passes[h];
        solved.weight[h] = halves->half[h].passes;
    }
    if ( picture->variance != NULL )
        rf_estimate_variance( &solved, RF_NORMALIZE_RATIO, picture->variance );
    return rf_estimate_relmse( &solved, RF_NORMALIZE_RATIO, picture->rgb );
}

static RfRelmse finish_pixels( const RfFilm* primal, RfPicture* picture )
{
    rf_combine_film( primal, RF_NORMALIZE_RATIO, picture->rgb, NULL );
    if ( picture->variance != NULL )
        rf_estimate_variance( primal, RF_NORMALIZE_RATIO, picture->variance );
    return rf_estimate_relmse( primal, RF_NORMALIZE_RATIO, picture->rgb );
}

RfRelmse rf_finish_gradients( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch )
{
    const RfFilm* primal = films + RF_FILM_PRIMAL;
    rf_combine_film( primal, RF_NORMALIZE_RATIO, picture->rgb, picture->weight );
    if ( settings->reconstruction == RF_RECONSTRUCTION_NONE )
        return finish_pixels( primal, picture );
    Work work = place_work( films->width, films->height, &( RfLayout ){ .memory = scratch } );
    Halves halves = load_halves( films, &work );
    RfReconstructInfo info;
    if ( solve( settings, films, &halves, work.solver, picture->rgb, &info ) != RF_OK )
    {
        // samples that are not finite: the pixels as they are show where
        picture->solved = RF_SOLVED_NOT;
        finish_pixels( primal, picture );
        return rf_plain_relmse( (double)NAN );
    }
    picture->solved = info.converged ? RF_SOLVED : RF_SOLVED_ROUGHLY;
    if ( halves.half[0].passes > 0.0 && halves.half[1].passes > 0.0 ) // a single pass may lie in either half
        return estimate_noise( &halves, primal, picture );
    if ( picture->variance != NULL )
        rf_estimate_variance( primal, RF_NORMALIZE_RATIO, picture->variance ); // 0: a single pass
    return rf_plain_relmse( (double)NAN );
}

// The estimator.

static bool is_tile( const RfTile* tile )
{
    int w = tile->width, h = tile->height;
    bool is_block = tile->kind == RF_TILE_BLOCK && w >= 2 && h >= 2 && w <= RF_MAX_TILE_SIDE && h <= RF_MAX_TILE_SIDE;
    return tile->kind == RF_TILE_NONE || is_block;
}

static RfResult check( const RfRenderSettings* s, RfError* error )
{
    if ( s->group > 0 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "the estimator 'gradient' reuses no frames, where gradients seldom pay: group 0, not %d", s->group );
    if ( !is_tile( &s->tile ) )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator 'gradient' needs tiles of 1 pixel, or blocks of 2x2 to %dx%d",
                        RF_MAX_TILE_SIDE, RF_MAX_TILE_SIDE );
    if ( s->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator 'gradient' has exact weights only" );
    if ( s->normalize != RF_NORMALIZE_CROSSFIT )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator 'gradient' has no normalisation to choose" );
    return RF_OK;
}

static RfEstimatorSizes sizes( const RfEstimatorGroup* group )
{
    GradientPlan plan;
    RfLayout scratch = { 0 };
    compile( group, &plan );
    place_gradient_scratch( &plan, &scratch );
    return ( RfEstimatorSizes ){
        .jobs = plan.tiles.patches,
        .compiled = sizeof plan,
        .batch = sizeof( GradientBatch ),
        .trace_scratch = scratch.bytes,
        .accumulate_scratch = 64,
        .finish_scratch = rf_finish_gradients_bytes( group->settings, group->width, group->height ),
        .diffuse_record = sizeof( float[4] ),
        .glossy_record = sizeof( float[4] ),
        .directions = 1,
    };
}

static void lay_out_batch( const RfEstimatorGroup* group, void* memory )
{
    (void)group;
    GradientBatch* batch = memory;
    batch->tile_count = 0;
}

static void lay_out_scratch( const RfEstimatorGroup* group, void* memory )
{
    place_gradient_scratch( group->compiled, &( RfLayout ){ .memory = memory } );
}

const RfEstimator rf_gradient_estimator = {
    .name = "gradient",
    .films = RF_GRADIENT_FILMS,
    .filters = true,
    .draws_by_filter = true,
    .has_gradients = true,
    .has_alpha = true,
    .has_features = true,
    .has_variance = true,
    .usual_passes = 4, // two in each half: their variances are known
    .tile = { RF_TILE_BLOCK, 4, 4 },
    .check = check,
    .sizes = sizes,
    .compile = compile,
    .lay_out_batch = lay_out_batch,
    .lay_out_scratch = lay_out_scratch,
    .trace = trace,
    .first_hits = first_hits,
    .accumulate = accumulate,
    .finish = rf_finish_gradients,
};
