// Compares two samples of the same pixels, and weighs the paths of large tiles as smaller ones would (src/reuse/estimators.md, E29).
#include "reuse/tile_pilot.h"

#include "path/mis.h"
#include "reuse/accumulate/accumulate.h"

#include <math.h>
#include <string.h>

#define CELL 4          // pixels, the side of a cell: pixels of about the same brightness
#define MOST_CELLS 8192 // of both batches, a power of 2; at least twice as many as there are
#define MOST_PIXELS 4096
#define DARK 1e-3         // as in the relMSE
#define LEAST_BRIGHT 0.01 // floor for the square of a cell's mean, in parts of that of all: few samples may miss all light

// Sums over the pixels of a cell, of both batches.
typedef struct Cell
{
    double light, lit;   // of what shines by the light of others, and its samples
    double all, samples; // of everything
    double pairs;        // pixels that both have
    double light_sample; // that a second light sample at first hits takes away
    double scale;        // 1 / (b² + 0.001)
} Cell;

// What a path brings, as without tiles.
typedef struct Path
{
    int cell;
    float square;
    float moment[RF_TILE_CHOICES]; // E29
} Path;

// By batch; luminance.
typedef struct Pixel
{
    float own[2], shared[2];    // light that its own frame alone can show, and light of hits
    bool sampled[2], shines[2]; // shines: is a lamp, or sky
} Pixel;

struct RfTilePilot
{
    RfFilm film; // has no pixels: what lands is looked at
    void *accumulation, *landing;
    int32_t pixel_key[MOST_PIXELS], cell_key[MOST_CELLS];
    Pixel pixels[MOST_PIXELS];
    Cell cells[MOST_CELLS];
    double connected[RF_TILE_CHOICES];
    int path_count;
    Path paths[2 * RF_LANES];
    RF_ALIGN float light[RF_LANES]; // by hit
};

RfTilePilot* rf_place_tile_pilot( const RfReusePlan* plan, RfLayout* layout )
{
    RfTilePilot* pilot = rf_take( layout, 1, sizeof *pilot );
    RfLayout accumulation = { 0 }, landing = { 0 };
    rf_place_accumulation( plan, &accumulation );
    rf_place_landing( plan, &landing );
    char *first = rf_take( layout, accumulation.bytes, 1 ), *second = rf_take( layout, landing.bytes, 1 );
    if ( pilot != NULL )
    {
        pilot->film = ( RfFilm ){ 0 };
        pilot->accumulation = first;
        pilot->landing = second;
    }
    return pilot;
}

// The place of a key in a table whose free places have −1; there is always a free one.
static int find_key( int32_t* keys, int size, int32_t key )
{
    int at = (int)( (uint32_t)key * 2654435769u >> 8 ) & ( size - 1 );
    while ( keys[at] != key && keys[at] >= 0 )
        at = ( at + 1 ) & ( size - 1 );
    return at;
}

static int cell_at( RfTilePilot* pilot, const RfEstimatorGroup* group, int32_t pixel )
{
    int32_t x = pixel % group->width / CELL, y = pixel / group->width / CELL;
    int32_t key = y * ( group->width / CELL + 1 ) + x;
    int at = find_key( pilot->cell_key, MOST_CELLS, key );
    if ( pilot->cell_key[at] < 0 )
        pilot->cells[at] = ( Cell ){ .pairs = 0.0 };
    pilot->cell_key[at] = key;
    return at;
}

static float luminance_of( const float* rgb ) { return rf_luminance( rf_vec3( rgb[0], rgb[1], rgb[2] ) ); }

// ---- Light by pixel

static Pixel* pixel_of( RfTilePilot* pilot, int32_t pixel )
{
    int at = find_key( pilot->pixel_key, MOST_PIXELS, pixel );
    if ( pilot->pixel_key[at] < 0 )
        pilot->pixels[at] = ( Pixel ){ .sampled = { false } };
    pilot->pixel_key[at] = pixel;
    return pilot->pixels + at;
}

static void add_light( const RfEstimatorGroup* group, int half, const RfHitBatch* batch, const RfHarvestScratch* scratch,
                       RfTilePilot* pilot )
{
    const RfVertexLanes* v = scratch->hits;
    RfAccumulateJob job = { .end_row = group->height, .films = &pilot->film, .weight = 1.0f };
    rf_land_batch( group, job, batch, pilot->accumulation, pilot->landing );
    const RfLandedHits* landed = pilot->landing;
    const RfLayerSet* set = &batch->layers;
    for ( int i = 0; i < landed->count; ++i )
        pixel_of( pilot, landed->pixel[i] )->shared[half] += luminance_of( landed->value[0] + 4 * i );
    for ( int i = batch->count; i < rf_listed( batch ); ++i )
    {
        for ( int layer = 0; layer < set->base_parts * rf_kinds( set ); ++layer )
            pixel_of( pilot, batch->pixel[i] )->own[half] += luminance_of( batch->light[layer].radiance + 4 * (size_t)i );
    }
    for ( int i = 0; i < batch->count + batch->miss_count; ++i )
    {
        Pixel* pixel = pixel_of( pilot, batch->pixel[i] );
        pixel->sampled[half] = true;
        pixel->shines[half] = i >= batch->count;
    }
    for ( int i = 0; i < rf_record_count( v ); ++i )
    {
        if ( rf_luminance( RF_GET3( v->emission, i ) ) > 0.0f )
            pixel_of( pilot, scratch->pixel[v->slot[i]] )->shines[half] = true;
    }
}

static void add_to_cells( const RfEstimatorGroup* group, RfTilePilot* pilot )
{
    for ( int k = 0; k < MOST_PIXELS; ++k )
    {
        const Pixel* p = pilot->pixels + k;
        if ( pilot->pixel_key[k] < 0 )
            continue;
        Cell* cell = pilot->cells + cell_at( pilot, group, pilot->pixel_key[k] );
        for ( int half = 0; half < 2; ++half )
        {
            double light = (double)p->own[half] + (double)p->shared[half];
            bool lit = p->sampled[half] && !p->shines[half];
            cell->all += light;
            cell->samples += p->sampled[half];
            cell->light += lit ? light : 0.0;
            cell->lit += lit;
        }
        cell->pairs += p->sampled[0] && p->sampled[1];
    }
}

// ---- Light of hits

static float chain_throughput( const RfHarvestScratch* scratch, int slot )
{
    return rf_follows_chains( scratch ) ? rf_luminance( RF_GET3( scratch->chains->throughput, slot ) ) : 1.0f;
}

// Adds what arrives at the hits, times f, to pilot->light; `scale` times.
static void add_arrival( const RfVertexLanes* v, float ( *directions )[RF_LANES], float scale, RfHarvestScratch* scratch,
                         float* light )
{
    RfLaneScratch* s = &scratch->wavefront.scratch;
    const float* wi[3] = { directions[0], directions[1], directions[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_lanes( v, wi, f, s->pdf );
    for ( int i = 0; i < rf_record_count( v ); ++i )
    {
        float q[3];
        rf_weigh_arrival( &scratch->arrival, i, s->pdf[i], q );
        light[i] += scale * rf_luminance( rf_vec3( f[0][i] * q[0], f[1][i] * q[1], f[2][i] * q[2] ) );
    }
}

// What a second light sample takes from the variance: the squared difference of their parts.
static void add_light_samples( const RfEstimatorGroup* group, RfHarvestScratch* scratch, RfTilePilot* pilot )
{
    const RfVertexLanes* v = scratch->hits;
    int samples = rf_reuse_plan( group )->shape.light_samples;
    if ( samples != 2 || group->settings->light_samples > 1 )
        return;
    memset( pilot->light, 0, sizeof pilot->light );
    for ( int d = 0; d < samples; ++d )
    {
        rf_gather_light_sample( scratch->direct + d, RF_ALL_PARTS, v->count, (float)samples, &scratch->arrival );
        add_arrival( v, scratch->direct[d].wi, d == 0 ? 1.0f : -1.0f, scratch, pilot->light );
    }
    for ( int i = 0; i < rf_record_count( v ); ++i )
    {
        int slot = v->slot[i];
        double apart = (double)( pilot->light[i] * chain_throughput( scratch, slot ) );
        pilot->cells[cell_at( pilot, group, scratch->pixel[slot] )].light_sample += apart * apart;
    }
}

// What the paths bring to the hits by second vertices, as without tiles; false where none does.
static bool find_path_light( const RfEstimatorGroup* group, RfHarvestScratch* scratch, RfTilePilot* pilot )
{
    const RfVertexLanes* v = scratch->hits;
    const RfPairingLanes* own = scratch->tiles->pairings;
    const float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    int parts = rf_reuse_plan( group )->shape.layers.parts;
    bool any = false;
    memset( pilot->light, 0, sizeof pilot->light );
    for ( int part = 0; part < parts; ++part )
    {
        rf_gather_scattered( v, rf_record_count( v ), wi, rf_arrivals_of_part( &scratch->wavefront, part ), 1.0f,
                             &scratch->arrival );
        for ( int c = 0; c < 3; ++c )
            memset( scratch->arrival.a[c], 0, sizeof scratch->arrival.a[c] );
        add_arrival( v, scratch->scattered, 1.0f, scratch, pilot->light );
    }
    for ( int i = 0; i < rf_record_count( v ); ++i )
    {
        float share = own->weight[i];
        bool reused = scratch->tiles->hits.second[i] >= 0 && share > 0.0f;
        pilot->light[i] = reused ? pilot->light[i] / share * chain_throughput( scratch, v->slot[i] ) : 0.0f;
        any = any || pilot->light[i] > 0.0f;
    }
    return any;
}

// ---- Smaller tiles

// The places of a tile's pixels, from its first row and column on.
typedef struct Places
{
    int x[RF_MAX_TILE_PIXELS], y[RF_MAX_TILE_PIXELS];
} Places;

static Places find_places( const RfEstimatorGroup* group, const RfHarvestScratch* scratch, const int32_t* member, int size )
{
    Places p;
    int low_x = INT32_MAX, low_y = INT32_MAX;
    for ( int k = 0; k < size; ++k )
    {
        int pixel = scratch->pixel[scratch->hits->slot[member[k]]];
        p.x[k] = pixel % group->width;
        p.y[k] = pixel / group->width;
        low_x = p.x[k] < low_x ? p.x[k] : low_x;
        low_y = p.y[k] < low_y ? p.y[k] : low_y;
    }
    for ( int k = 0; k < size; ++k )
    {
        p.x[k] -= low_x;
        p.y[k] -= low_y;
    }
    return p;
}

// Whether pixel `other` of the large tile is in the smaller one of a pixel, which begins so that all of it is in the large one, the
// first column in its first and the last column in its last.
static bool share_tile( int pixel, int other, int side, int largest )
{
    int first = largest > 1 ? ( pixel * ( largest - side ) + ( largest - 1 ) / 2 ) / ( largest - 1 ) : 0;
    return other >= first && other < first + side;
}

// The share that a path has of the densities with which the paths of each smaller tile would have found its second vertex, and how
// many of these could have.
static void find_shares( const RfTileReuse* tiles, const Places* places, int own, float share[RF_TILE_CHOICES],
                         double connected[RF_TILE_CHOICES] )
{
    const RfTileHits* hits = &tiles->hits;
    int i = own, size = hits->size[i], rank = hits->rank[i];
    const int32_t* member = hits->member + hits->begin[i];
    float sum[RF_TILE_CHOICES] = { 0.0f };
    for ( int k = 0; k < size; ++k )
    {
        float weight = tiles->pairings[rank >= k ? rank - k : rank - k + size].weight[member[k]];
        for ( int t = 0; t < RF_TILE_CHOICES && weight > 0.0f; ++t )
        {
            int side = rf_tile_sides[t], largest = rf_tile_sides[RF_TILE_CHOICES - 1];
            if ( share_tile( places->x[rank], places->x[k], side, largest ) &&
                 share_tile( places->y[rank], places->y[k], side, largest ) )
            {
                sum[t] += weight;
                connected[t] += k != rank;
            }
        }
    }
    for ( int t = 0; t < RF_TILE_CHOICES; ++t )
        share[t] = sum[t] > 0.0f ? tiles->pairings[0].weight[i] / sum[t] : 1.0f;
}

// Lists the paths of one tile.
static void add_tile( const RfEstimatorGroup* group, const RfHarvestScratch* scratch, int first, RfTilePilot* pilot )
{
    const RfTileHits* hits = &scratch->tiles->hits;
    int begin = hits->begin[first], size = hits->size[first];
    const int32_t* member = hits->member + begin;
    Places places = find_places( group, scratch, member, size );
    int cell = cell_at( pilot, group, scratch->pixel[scratch->hits->slot[first]] );
    float mean = 0.0f;
    for ( int k = 0; k < size; ++k )
        mean += pilot->light[member[k]] / (float)size;
    for ( int k = 0; k < size; ++k )
    {
        float share[RF_TILE_CHOICES], light = pilot->light[member[k]];
        if ( !( light > 0.0f ) )
            continue;
        find_shares( scratch->tiles, &places, member[k], share, pilot->connected );
        Path* path = pilot->paths + pilot->path_count++;
        *path = ( Path ){ .cell = cell, .square = light * light };
        for ( int t = 0; t < RF_TILE_CHOICES; ++t )
            path->moment[t] = light * ( light - mean ) * share[t];
    }
}

static void add_tiles( const RfEstimatorGroup* group, RfHarvestScratch* scratch, RfTilePilot* pilot )
{
    const RfTile* tile = &rf_reuse_plan( group )->patches.tile; // smaller ones tell of none but themselves
    bool largest =
             tile->kind == RF_TILE_BLOCK && tile->width == rf_tile_sides[RF_TILE_CHOICES - 1] && tile->height == tile->width,
         tiles = largest && rf_reuses_tiles( scratch ) && group->max_depth > 1 && scratch->hits->count > 0;
    if ( !tiles || !find_path_light( group, scratch, pilot ) )
        return;
    for ( int i = 0; i < rf_record_count( scratch->hits ); ++i )
    {
        if ( scratch->tiles->hits.rank[i] == 0 )
            add_tile( group, scratch, i, pilot );
    }
}

static void add_batch( const RfEstimatorGroup* group, int half, const RfHitBatch* batch, RfHarvestScratch* scratch,
                       RfTilePilot* pilot )
{
    add_light( group, half, batch, scratch, pilot );
    add_light_samples( group, scratch, pilot );
    add_tiles( group, scratch, pilot );
}

void rf_begin_tile_pair( const RfEstimatorGroup* group, const RfHitBatch* batch, RfHarvestScratch* scratch, RfTilePilot* pilot )
{
    memset( pilot->pixel_key, -1, sizeof pilot->pixel_key );
    memset( pilot->cell_key, -1, sizeof pilot->cell_key );
    pilot->path_count = 0;
    memset( pilot->connected, 0, sizeof pilot->connected );
    add_batch( group, 0, batch, scratch, pilot );
}

// Finds what the squares of cells are divided by; cells without a pair have 0. As in the relMSE, which takes the median of pixels, lamps
// do not hide what is noisy around them.
static void find_scales( RfTilePilot* pilot )
{
    double light = 0.0, lit = 0.0;
    for ( int k = 0; k < MOST_CELLS; ++k )
    {
        light += pilot->cell_key[k] < 0 ? 0.0 : pilot->cells[k].light;
        lit += pilot->cell_key[k] < 0 ? 0.0 : pilot->cells[k].lit;
    }
    double mean = lit > 0.0 ? light / lit : 0.0, least = DARK + LEAST_BRIGHT * mean * mean;
    for ( int k = 0; k < MOST_CELLS; ++k )
    {
        Cell* cell = pilot->cells + k;
        if ( pilot->cell_key[k] < 0 )
            continue;
        double bright = cell->lit > 0.0 ? cell->light / cell->lit : cell->samples > 0.0 ? cell->all / cell->samples : 0.0;
        cell->scale = cell->pairs > 0.0 ? 1.0 / ( bright * bright + least ) : 0.0;
    }
}

static int octave_of( double square )
{
    int exponent;
    frexp( square, &exponent ); // square < 2^exponent
    int octave = square > 0.0 ? exponent - 1 - RF_FIRST_TILE_OCTAVE : 0;
    return octave < 0 ? 0 : octave < RF_TILE_OCTAVES ? octave : RF_TILE_OCTAVES - 1;
}

static void count_pairs( const RfEstimatorGroup* group, RfTilePilot* pilot, RfTileCount* count )
{
    for ( int k = 0; k < MOST_PIXELS; ++k )
    {
        const Pixel* p = pilot->pixels + k;
        if ( pilot->pixel_key[k] < 0 || !p->sampled[0] || !p->sampled[1] )
            continue;
        double scale = pilot->cells[cell_at( pilot, group, pilot->pixel_key[k] )].scale;
        double own = (double)p->own[0] - (double)p->own[1], shared = (double)p->shared[0] - (double)p->shared[1];
        own *= 0.5 * own * scale;
        shared *= 0.5 * shared * scale;
        int octave = octave_of( own + shared );
        count->pixels += 1.0;
        count->pairs[octave].pixels += 1.0;
        count->pairs[octave].own += own;
        count->pairs[octave].shared += shared;
    }
}

void rf_end_tile_pair( const RfEstimatorGroup* group, const RfHitBatch* batch, RfHarvestScratch* scratch, RfTilePilot* pilot,
                       RfTileCount* count )
{
    add_batch( group, 1, batch, scratch, pilot );
    add_to_cells( group, pilot );
    find_scales( pilot );
    count_pairs( group, pilot, count );
    for ( int t = 0; t < RF_TILE_CHOICES; ++t )
        count->connected[t] += pilot->connected[t];
    for ( int k = 0; k < MOST_CELLS; ++k )
    {
        const Cell* cell = pilot->cells + k;
        if ( pilot->cell_key[k] >= 0 && cell->pairs > 0.0 )
            count->light_sample += cell->scale * cell->light_sample * cell->pairs / cell->samples;
    }
    for ( int k = 0; k < pilot->path_count; ++k )
    {
        const Path* path = pilot->paths + k;
        const Cell* cell = pilot->cells + path->cell;
        int octave = octave_of( (double)path->square * cell->scale );
        double scale = cell->samples > 0.0 ? cell->scale * cell->pairs / cell->samples : 0.0;
        count->paths[octave].paths += 1.0;
        for ( int t = 0; t < RF_TILE_CHOICES; ++t )
            count->paths[octave].moment[t] += scale * (double)path->moment[t];
    }
}
