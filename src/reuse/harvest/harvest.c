// Traces a batch into hit records: its pixels, one lens point and shutter time for all of them, camera rays and
// their specular chains, hits, and the light that the rest of their paths brings.
#include "reuse/harvest/harvest_steps.h"

#include "path/roulette.h"
#include "scene/projection.h"

#include <math.h>
#include <string.h>

#define LATTICE_SALT 0x1a771ce00000u // keeps the keys of lattices apart
#define LENS_SALT 0x1e4500000000u    // keeps the random numbers of the lens apart
// Light samples per first hit with tiles, at least. Tiles share all other light, and these samples are cheap beside the rest of
// a path (scripts/bench/RESULTS.md).
#define DIRECT_SAMPLES 2
// Chain samples per hit behind a chain (path/chain_samples.h).
#define CHAIN_SAMPLES 4

static int direct_samples( const RfEstimatorGroup* group, int tile_pixels, bool connections )
{
    int least = tile_pixels == 1 || connections || group->even_light_samples ? 1 : DIRECT_SAMPLES;
    return group->settings->light_samples > least ? group->settings->light_samples : least;
}

RfBatchShape rf_batch_shape( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    bool specular = rf_has_specular( group->traits.kinds );
    int tile_pixels = rf_tile_pixels( &settings->tile );
    bool chains = rf_wants_chains( &group->traits, settings, tile_pixels );
    bool connections = rf_wants_light_paths( &group->traits, settings );
    bool exact = settings->weights == RF_WEIGHTS_EXACT && !group->even_light_samples; // not in gradients
    bool caustics = group->traits.without_caustics && exact;
    bool samples = chains && group->traits.chain_triangles > 0 && !connections && !group->even_light_samples && !caustics;
    // at the ends of a path, groups of more frames are shorter, and have the memory of those
    int groups = exact ? group->traits.light_groups : 0;
    int frames = !group->traits.lamps_alone || !exact ? 1 : group->eye_count < RF_FRAMES_MOST ? group->eye_count : RF_FRAMES_MOST;
    RfLayerSet layers = {
        .base_parts = groups > 1 ? groups : 1,
        .by_kind = ( settings->aovs & RF_PASS_AOVS ) != 0 && exact,
        .removed = settings->clamp != 0.0 || caustics,
    };
    layers.parts = layers.base_parts;
    if ( group->eye_count > 1 && exact )
    {
        int alone = group->traits.lamps_alone < layers.base_parts ? group->traits.lamps_alone : layers.base_parts;
        layers.parts += group->traits.dimmable + ( frames > 1 ? alone * frames : 0 );
    }
    layers.parts = layers.parts < RF_PARTS_MOST + 1 ? layers.parts : RF_PARTS_MOST + 1;
    return ( RfBatchShape ){
        .eyes = group->eye_count,
        .light_samples = direct_samples( group, tile_pixels, connections ),
        .tile_pixels = tile_pixels,
        .params = rf_glossy_params( group->traits.kinds ),
        .blurred = rf_is_blurred( &group->traits ),
        .moments = rf_calls_for( group->traits.moves && group->traits.blur_steps > 0, RF_EFFECT_MOTION_BLUR ),
        .moving_lights = group->traits.moving_lights ? group->traits.most_lights : 0,
        .blended = group->traits.blended,
        .panes = group->traits.panes,
        .own_frame_light = specular || chains || group->traits.sky,
        .filtered = !rf_is_plain_filter( settings ),
        .chains = chains,
        .own_light = ( group->traits.moves && group->eye_count > 1 && exact ) || caustics,
        .caustics = caustics,
        .surfaces = ( group->traits.moves && rf_follows_motion( settings ) ) || rf_wants_covering( settings ),
        .features = rf_finds_features( settings ),
        .covering = rf_surface_kinds( settings ),
        .chain_samples = rf_calls_for( samples, RF_EFFECT_CHAINS ) ? CHAIN_SAMPLES : 0,
        .connections = connections,
        .clamped = settings->clamp != 0.0,
        .light_frames = frames,
        .groups = groups,
        .layers = layers,
    };
}

RfHarvest rf_make_harvest( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    return ( RfHarvest ){
        .path = { .tracer = group->tracer,
                  .max_depth = group->max_depth,
                  .light_samples = settings->light_samples,
                  .light_sampling = settings->light_sampling },
        .tracers = group->tracers,
        .shape = rf_batch_shape( group ),
        .patches = rf_lay_out_patches( &settings->tile, group->traits.scattered, group->width, group->height ),
        .alpha = ( settings->aovs & RF_AOV_BIT( RF_AOV_ALPHA ) ) != 0,
        .seed = settings->seed,
        .drawn_by = group->need != NULL ? group->filter : NULL,
        .eyes = group->eyes,
        .first_frame = group->first_frame,
        .group = group->number,
        .passes_before = group->passes_before,
        .pieces = settings->pieces,
        .need = group->need,
        .round = group->round,
        .packed = group->packed,
        .single = group->single,
        .first_hits_only = group->first_hits_only,
        .light_paths = rf_drawn_light_paths( group->shared ),
        .kernel_normalization = settings->kernel_normalization,
        .clamps = group->clamp,
        .clamp_watch = group->clamp_watch,
    };
}

// The lattice of a pass of a frame: its half and its number in that. False for pilots and extra samples, whose numbers are random.
static bool find_point( const RfHarvest* harvest, int eye, int pass, RfLattice* lattice )
{
    if ( harvest->passes_before < 0 || harvest->need != NULL )
        return false;
    int64_t number = harvest->passes_before + pass;
    lattice->half = rf_pass_key( harvest->seed ^ LATTICE_SALT, 0, 0, (uint32_t)( number & 1 ) );
    lattice->pass = (uint32_t)( number >> 1 );
    lattice->frame = (uint32_t)( harvest->first_frame + eye );
    return true;
}

RfLensSample rf_draw_lens( const RfHarvest* harvest, RfTraceJob job )
{
    uint64_t pass_key = rf_harvest_key( harvest, job.eye, job.pass ) ^ LENS_SALT;
    RfRandomKey key = rf_pixel_key( rf_mix64( pass_key + (uint64_t)harvest->round ), (uint32_t)job.job );
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

RfHarvest rf_harvest_at( const RfHarvest* harvest, int eye, RfLensSample lens, RfHarvestScratch* scratch )
{
    RfHarvest at = *harvest;
    at.path.tracer = rf_harvest_tracer( harvest, eye );
    at.path.occluders = &scratch->occluders;
    if ( !rf_is_blurred_shape( &harvest->shape ) )
        return at;
    for ( int l = 0; l < harvest->shape.eyes; ++l )
        scratch->eyes[l] = rf_sample_eye( harvest->eyes + l, lens );
    at.eyes = scratch->eyes;
    if ( scratch->tracers == NULL )
        return at;
    for ( int l = 0; l < harvest->shape.eyes; ++l )
        scratch->tracers[l] = rf_tracer_at( rf_harvest_tracer( harvest, l ), lens.time,
                                            scratch->at_moment + (size_t)l * rf_tracer_at_bytes( harvest->shape.moving_lights ) );
    at.tracers = scratch->tracers;
    at.path.tracer = scratch->tracers[eye];
    return at;
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
    bool in_tiles = rf_reuses_tiles( scratch ) && !harvest->single;
    out->count = in_tiles ? scratch->tile_count : count;
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

// Drops the listed pixels whose tiles have no pixel in the pieces that are traced. Returns how many are left.
static int choose_traced( const RfHarvest* harvest, int eye, int count, RfHarvestScratch* scratch )
{
    const uint8_t* cells = rf_frame_cells( harvest->pieces, harvest->first_frame + eye );
    int width = harvest->eyes[eye].width;
    bool in_tiles = rf_reuses_tiles( scratch ), traced[RF_LANES] = { false };
    for ( int i = 0; i < count; ++i )
    {
        int y = scratch->pixel[i] / width, x = scratch->pixel[i] - y * width;
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

// Adaptive sampling by rounds: a tile is sampled with the probability mean need − harvest->round. Returns how many pixels are
// left.
static int choose_needy( const RfHarvest* harvest, uint64_t key, int count, RfHarvestScratch* scratch )
{
    Tiles list;
    list_tiles( harvest, count, scratch, &list );
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
// wavefronts, of which this lists number harvest->round.
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
            if ( wavefront == harvest->round )
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

static void copy_hits( const RfVertexLanes* v, RfHitBatch* batch )
{
    batch->count = rf_record_count( v );
    for ( int k = 0; k <= RF_BSDF_KIND_COUNT; ++k )
        batch->first[k] = v->first[k] < batch->count ? v->first[k] : batch->count;
    size_t bytes = (size_t)batch->count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( batch->p[c], v->p[c], bytes );
        memcpy( batch->ng[c], v->ng[c], bytes );
    }
    int first = v->first[RF_BSDF_FIRST_GLOSSY];
    bytes = (size_t)( batch->count - first ) * sizeof( float );
    if ( bytes == 0 )
        return;
    rf_face_cameras( v, batch );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( batch->n[c], v->n[c] + first, bytes );
        memcpy( batch->wo[c], v->wo[c] + first, bytes );
    }
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        if ( batch->param[p] != NULL )
            memcpy( batch->param[p], v->param[p] + first, bytes );
    }
}

static void copy_views( const RfHarvestScratch* scratch, RfHitBatch* batch )
{
    batch->has_views = batch->view != NULL && ( rf_follows_chains( scratch ) || batch->panes[0] != NULL );
    if ( batch->view == NULL )
        return;
    for ( int i = 0; i < batch->count; ++i )
        batch->view[i] = !rf_follows_chains( scratch ) ? RF_VIEW_DIRECT : scratch->chains->view[scratch->hits->slot[i]];
}

// Lists the own-frame samples behind the misses: specular first hits, and chains that end without a non-specular vertex.
static void note_own_frame( const RfVertexLanes* first, const uint8_t* recorded, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    for ( int i = 0; i < first->count; ++i )
    {
        int slot = first->slot[i];
        if ( recorded[slot] )
            continue;
        rf_miss_pixel( batch )[batch->miss_count] = scratch->pixel[slot];
        scratch->miss_slot[batch->miss_count++] = slot;
    }
}

// All that a chain finds.
static float light_of_chain( const RfChains* chains, int base_parts, int slot )
{
    float sum = 0.0f;
    for ( int k = 0; k < base_parts * chains->events; ++k )
    {
        for ( int c = 0; c < 3; ++c )
            sum += chains->finds[k].light[c][slot] + ( chains->clamped ? chains->finds[k].found[c][slot] : 0.0f );
    }
    return sum;
}

// Lists glints: light that a chain finds on its way, for pixels that have a hit as well.
static void note_glints( const RfHarvestScratch* scratch, int base_parts, RfHitBatch* batch, int32_t* glint_slot )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        if ( light_of_chain( scratch->chains, base_parts, slot ) == 0.0f )
            continue;
        rf_glint_pixel( batch )[batch->glint_count] = scratch->pixel[slot];
        glint_slot[batch->glint_count++] = slot;
    }
}

// Notes the pixel of each hit, miss and own-frame sample.
static void note_pixels( int base_parts, int count, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    uint8_t hit[RF_LANES], recorded[RF_LANES];
    memset( hit, 0, (size_t)count );
    memset( recorded, 0, (size_t)count );
    for ( int i = 0; i < scratch->first.count; ++i )
        hit[scratch->first.slot[i]] = 1;
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        recorded[slot] = 1;
        batch->pixel[i] = scratch->pixel[slot];
    }
    int32_t* miss_pixel = rf_miss_pixel( batch );
    batch->miss_count = batch->glint_count = 0;
    for ( int slot = 0; slot < count; ++slot )
    {
        miss_pixel[batch->miss_count] = scratch->pixel[slot];
        scratch->miss_slot[batch->miss_count] = slot;
        batch->miss_count += !hit[slot];
    }
    scratch->ray_miss_count = batch->sky_count = batch->miss_count;
    note_own_frame( &scratch->first, recorded, scratch, batch );
    if ( rf_follows_chains( scratch ) )
        note_glints( scratch, base_parts, batch, scratch->glint_slot );
}

// Film offsets of what is listed from `first` on.
static void note_offsets( const RfHarvestScratch* scratch, int first, int count, const int32_t* slot, RfHitBatch* batch )
{
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 2; ++c )
            batch->offset[c][first + i] = scratch->place[c][slot[i]];
    }
}

void rf_list_hits( const RfHarvest* harvest, int count, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    copy_hits( scratch->hits, batch );
    copy_views( scratch, batch );
    note_pixels( rf_base_parts( &harvest->path ), count, scratch, batch );
    if ( batch->offset[0] == NULL )
        return;
    note_offsets( scratch, 0, batch->count, scratch->hits->slot, batch );
    note_offsets( scratch, batch->count, batch->miss_count, scratch->miss_slot, batch );
    note_offsets( scratch, batch->count + batch->miss_count, batch->glint_count, scratch->glint_slot, batch );
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
}

void rf_sample_direct( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int k = harvest->path.light_samples, samples = harvest->shape.light_samples;
    for ( int set = 0; set < rf_light_set_count( &harvest->path, samples ); ++set )
    {
        int j = set % samples;
        uint32_t dimension =
            j < k ? rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j
                  : rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)( j - k ) + RF_DIMENSION_OPPOSITE;
        RfPathSettings at = rf_settings_of_sample( &harvest->path, samples, set );
        rays->shadow += (uint64_t)rf_sample_lights( &at, &scratch->wavefront, scratch->hits, dimension, scratch->direct + set,
                                                    &scratch->wavefront.scratch );
    }
}

// Thin panes that camera rays pass do not count towards max_depth. Returns RfWavefront.spent.
static const int32_t* find_passed_panes( const RfHarvest* harvest, RfHarvestScratch* scratch, float* const wi[3] )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->spent, 0, sizeof scratch->spent );
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
        scratch->spent[v->slot[i]] = cos_g < 0.0f && rf_is_at_pane( harvest->path.tracer, v, i ) ? -1 : 0;
    }
    return scratch->spent;
}

// Tiles share the light of chains; not where connections find it, nor where replayed rays could meet other surfaces, nor in
// gradients, nor without caustics, which all of it is.
static bool shares_chain_light( const RfHarvest* harvest, const RfHarvestScratch* scratch )
{
    return rf_reuses_tiles( scratch ) && rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) &&
           !rf_tracer_runs( harvest->path.tracer ).any_blended && harvest->path.connector == NULL && !harvest->path_roulette &&
           harvest->path_source == NULL && !harvest->shape.caustics;
}

// How tiles share paths.
static RfTileReuseSettings tile_settings( const RfHarvest* harvest, const RfHarvestScratch* scratch )
{
    return ( RfTileReuseSettings ){
        .path = &harvest->path,
        .tile_pixels = harvest->shape.tile_pixels,
        .tile_of = scratch->tile_of,
        .tile_count = scratch->tile_count,
        .path_roulette = harvest->path_roulette,
        .chain_light = shares_chain_light( harvest, scratch ),
        .source = harvest->path_source,
    };
}

void rf_trace_hit_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    const RfVertexLanes* v = scratch->hits;
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    bool chain_light = shares_chain_light( harvest, scratch );
    wavefront->spent = rf_follows_chains( scratch ) ? scratch->chains->length : NULL;
    wavefront->chain_light = !( chain_light || scratch->chain_samples != NULL ) ? NULL
                             : rf_reuses_tiles( scratch )                       ? &scratch->tiles->slots.chain_light
                                                                                : scratch->chain_light;
    rf_scatter_deferred( &harvest->path, wavefront, v, 1, wi );
    int specular = v->count - rf_record_count( v );
    if ( specular > 0 )
        memcpy( scratch->specular_pdf, wavefront->scratch.pdf + rf_record_count( v ), (size_t)specular * sizeof( float ) );
    if ( specular > 0 && rf_tracer_has_panes( harvest->path.tracer ) )
        wavefront->spent = find_passed_panes( harvest, scratch, wi );
    if ( rf_reuses_tiles( scratch ) )
    {
        RfTileReuseSettings settings = tile_settings( harvest, scratch );
        rays->tile += rf_trace_tile_tails( &settings, v, wi, wavefront, scratch->tiles );
    }
    else
        rf_trace_tails( &harvest->path, wavefront, 2 );
    if ( wavefront->chain_light != NULL )
        rf_add_chain_light( harvest, scratch, rf_chain_sampling( harvest, chain_light ) );
}

void rf_find_first_hits( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    RfLaneScratch* lanes = &scratch->wavefront.scratch;
    rf_find_vertices( &harvest->path, &scratch->camera_rays, true, &scratch->first, lanes );
    if ( scratch->surfaces == NULL )
        return;
    size_t count = (size_t)scratch->camera_rays.count;
    memcpy( scratch->surfaces->triangle, lanes->triangle, count * sizeof *lanes->triangle );
    memcpy( scratch->surfaces->u, lanes->u, count * sizeof *lanes->u );
    memcpy( scratch->surfaces->v, lanes->v, count * sizeof *lanes->v );
}

// Splits tiles by chain length, since paths with different numbers of vertices left do not share, and without caustics by whether
// hits throw them: what second vertices send on is a caustic to some hits, and to others not.
static void split_tiles( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    if ( !harvest->shape.caustics )
    {
        rf_split_tiles( v, scratch->chains->length, scratch->tile_of, &scratch->tile_count );
        return;
    }
    int32_t key[RF_LANES];
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        for ( int i = v->first[kind]; i < v->first[kind + 1]; ++i )
            key[v->slot[i]] = rf_throws_caustics( v, (RfBsdfKind)kind, i ) +
                              2 * ( rf_follows_chains( scratch ) ? scratch->chains->length[v->slot[i]] : 0 );
    }
    rf_split_tiles( v, key, scratch->tile_of, &scratch->tile_count );
}

void rf_follow_camera_rays( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* first = &scratch->first;
    RfWavefront* wavefront = &scratch->wavefront;
    scratch->hits = &scratch->first;
    if ( rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) && rf_has_chains( first ) )
    {
        scratch->chains->clamped = scratch->clamp != NULL;
        rf_follow_chains( &harvest->path, first, &scratch->camera_rays, !harvest->first_hits_only, wavefront, scratch->chains );
        scratch->hits = &scratch->chains->hits;
    }
    if ( rf_reuses_tiles( scratch ) && ( rf_follows_chains( scratch ) || harvest->shape.caustics ) )
        split_tiles( harvest, scratch );
    if ( scratch->features != NULL && harvest->need == NULL && !harvest->first_hits_only )
        rf_find_features( &harvest->path, first, &scratch->camera_rays, !harvest->alpha, wavefront, scratch->features );
}

// First hits of a batch, with the cameras at its point of the lens.
static int harvest_first_hits( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch,
                               RfRayCounts* rays )
{
    const RfEye* eye = harvest->eyes + job.eye;
    RfWavefront* wavefront = &scratch->wavefront;
    uint64_t key = rf_harvest_key( harvest, job.eye, job.pass );
    batch->eye = job.eye;
    rf_clear_ray_counts( wavefront );

    int count = rf_list_patch( &harvest->patches, eye, key, job.job, scratch->pixel, scratch->tile_of, &scratch->tile_count );
    int32_t copy[RF_LANES];
    if ( rf_is_adaptive( harvest ) && harvest->packed )
        count = pack_needy( harvest, key, count, scratch, copy );
    else if ( rf_is_adaptive( harvest ) )
        count = choose_needy( harvest, key, count, scratch );
    else if ( harvest->pieces != NULL )
        count = choose_traced( harvest, job.eye, count, scratch );
    make_keys( key, count, scratch->pixel, wavefront );
    set_lattice( harvest, job, count, scratch->pixel, &wavefront->lattice );
    if ( rf_is_adaptive( harvest ) && harvest->packed )
        make_copies_keys( harvest, job, count, copy, scratch );
    rf_make_camera_rays( harvest->drawn_by, eye, count, scratch->pixel, wavefront, &scratch->camera_rays );
    for ( int c = 0; c < 2 && scratch->place[0] != NULL; ++c )
        memcpy( scratch->place[c], wavefront->scratch.random[c], (size_t)count * sizeof( float ) );
    rf_find_first_hits( harvest, scratch );
    rays->primary += (uint64_t)count;
    if ( scratch->own != NULL )
        rf_note_moving_hits( harvest->path.tracer, scratch );
    rf_follow_camera_rays( harvest, scratch );
    rf_draw_sides( wavefront, 1, scratch->hits );
    rf_list_hits( harvest, count, scratch, batch );
    if ( batch->surface != NULL )
        rf_note_surfaces( harvest, count, scratch, batch );
    return count;
}

void rf_scale_roulette( RfHarvestScratch* scratch, int count )
{
    bool chains = rf_follows_chains( scratch );
    for ( int slot = 0; slot < count; ++slot )
    {
        float most = 1.0f;
        if ( chains )
            most = rf_maxf( scratch->chains->throughput[0][slot],
                            rf_maxf( scratch->chains->throughput[1][slot], scratch->chains->throughput[2][slot] ) );
        scratch->wavefront.roulette_scale[slot] = rf_shared_factor( most );
    }
}

// The rest of the paths; with light paths, connections at all vertices.
static void trace_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    if ( harvest->light_paths == NULL )
    {
        rf_trace_hit_tails( harvest, scratch, rays );
        return;
    }
    RfLightPathConnector connector =
        rf_make_connector( harvest->light_paths, harvest->kernel_normalization, &harvest->path, scratch->connections );
    RfHarvest connected = *harvest;
    connected.path.connector = &connector.connector;
    rf_trace_hit_tails( &connected, scratch, rays );
    for ( int j = 0; j < harvest->path.light_samples; ++j )
        rf_note_lit( &connected.path, &scratch->wavefront, scratch->direct + j, j, scratch->hits->count );
    rf_connect_vertices( &connector, &scratch->wavefront, NULL, scratch->hits, 1 );
}

// From here on light is kept apart that holds in its own frame alone, or caustics: what the chains before first hits have found does
// the former anyway, and is none of the latter.
static void split_light( RfHarvest* harvest, int count, RfHarvestScratch* scratch )
{
    harvest->path.own = &scratch->own->paths;
    for ( int base = 0; base < rf_base_parts( &harvest->path ); ++base )
        rf_clear_arrivals( count, rf_own_arrivals( harvest->path.own, base ) );
    harvest->path.own->caustics = false;
    if ( harvest->shape.caustics )
        rf_begin_caustics( count, harvest->path.own );
    else
        memset( harvest->path.own->touched, 0, (size_t)count );
    int base_parts = rf_base_parts( &harvest->path ), kinds = rf_hit_kinds( &harvest->shape.layers );
    for ( int k = 0; k < base_parts * kinds; ++k )
        memset( scratch->own->layers[k].light, 0, 4 * (size_t)count * sizeof( float ) );
    for ( int base = 0; base < base_parts && scratch->own->removed != NULL; ++base )
        memset( scratch->own->removed[base].light, 0, 4 * (size_t)count * sizeof( float ) );
}

// Estimates by first hits alone, without paths, how much of their light is own-frame.
static void look_for_own_light( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    wavefront->spent = NULL;
    wavefront->chain_light = NULL;
    rf_sample_direct( harvest, scratch, rays );
    rf_scatter_deferred( &harvest->path, wavefront, scratch->hits, 1, wi );
    rf_count_path_rays( wavefront, &wavefront->rays );
    rf_find_vertices_past_panes( &harvest->path, &wavefront->rays, 0, &wavefront->vertices, &wavefront->scratch );
    rf_find_own_parts( harvest, wavefront->scratch.triangle, scratch );
}

// From here on light groups are kept apart, if there are any: light as it is in the frame, by base part.
static void begin_groups( RfHarvest* harvest, RfHarvestScratch* scratch )
{
    harvest->path.grouped = rf_tracer_lights( harvest->path.tracer )->group_count > 1 && harvest->shape.layers.parts > 1;
    scratch->wavefront.dimmed = scratch->dimmed;
}

// From here on light of all parts is kept apart at slots [0, count) of a frame's hits: what the chains before them have found of it is
// as in the frame.
static void begin_parts( RfHarvest* harvest, int eye, int count, RfHarvestScratch* scratch )
{
    bool frames = rf_looks_at_frames( harvest );
    harvest->path.parts =
        ( rf_tracer_lights( harvest->path.tracer )->dimmed_count > 0 || frames ) && harvest->shape.layers.parts > 1;
    harvest->path.frames = frames ? harvest->tracers : NULL;
    harvest->path.frame = harvest->path.at_frame = eye;
    for ( int part = 0; part <= rf_dimmed_parts( &harvest->path ); ++part )
        rf_clear_arrivals( count, rf_arrivals_of_part( &scratch->wavefront, part ) );
}

static int harvest_batch( RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;
    begin_groups( harvest, scratch );
    int count = harvest_first_hits( harvest, job, batch, scratch, rays );

    // the rest of their paths
    if ( scratch->own != NULL )
        memset( scratch->own->part, 0, sizeof scratch->own->part );
    if ( rf_splits_light( harvest ) || harvest->shape.caustics )
        split_light( harvest, count, scratch );
    begin_parts( harvest, batch->eye, count, scratch );
    wavefront->rays.count = 0;
    rf_scale_roulette( scratch, count );
    bool lit = harvest->path.max_depth > 1 && !harvest->first_hits_only;
    if ( lit )
    {
        rf_sample_direct( harvest, scratch, rays );
        trace_tails( harvest, scratch, rays );
    }
    else if ( rf_splits_light( harvest ) && harvest->path.max_depth > 1 )
        look_for_own_light( harvest, scratch, rays );
    rays->path += wavefront->path_rays;
    rays->shadow += wavefront->shadow_rays;

    // visibility from all cameras of the group, then MIS weights
    rf_test_batch_visibility( harvest, batch, scratch, rays );
    if ( harvest->first_hits_only )
        return count;
    if ( scratch->clamp != NULL )
        rf_begin_clamp( harvest, batch, scratch );
    rf_weight_batch( harvest, batch, scratch );
    if ( harvest->shape.own_frame_light )
        rf_light_own_frame( harvest, batch, scratch );
    if ( harvest->path.own != NULL )
        rf_add_own_light( harvest, batch, scratch );
    return count;
}

int rf_harvest_batch( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    if ( rf_is_blurred_shape( &harvest->shape ) )
        batch->lens = rf_draw_lens( harvest, job );
    RfHarvest at = rf_harvest_at( harvest, job.eye, batch->lens, scratch );
    return harvest_batch( &at, job, batch, scratch, rays );
}
