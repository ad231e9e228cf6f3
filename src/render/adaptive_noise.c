#include "render/adaptive_noise.h"

#include "base/random.h"
#include "base/system.h"
#include "render/adaptive.h"
#include "render/adaptive_extra.h"
#include "scene/textured.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define NOISE_GROUP 0xc0000000u // no other group has this number
#define FRAMES 8                // of the path that are looked at
#define BLOCK 8                 // pixels: side of what is drawn
// Pixels that are rendered twice: this share of the camera rays of a whole render, within limits.
#define PAIR_SHARE 0.004
#define LEAST_PAIRS 1024.0
#define MOST_PAIRS 32768.0
#define DARK 1e-3 // what relMSE adds to squares
// A class of few pixels is taken for the mean of its kind: that counts as so many pixels.
#define PRIOR_PIXELS 32.0
// Relative to the materials that are alike. No class is taken for less noisy than these: of few samples with rare bright
// ones among them, most estimates are too low.
#define LEAST_VARIANCE 1.0
#define MOST_VARIANCE 1e4

static int class_of( const RfMaterialNoise* noise, int materials, int32_t material )
{
    return noise[material].special ? material : materials;
}

void rf_add_noise( const RfMaterialNoise* noise, RfFirstHits first, float* sums )
{
    const RfVertexLanes* v = first.hits;
    for ( int i = 0; i < v->count; ++i )
    {
        float* sum = sums + 4 * (size_t)first.pixel[v->slot[i]];
        const RfMaterialNoise* n = noise + v->material[i];
        sum[0] += n->variance[0];
        sum[1] += n->variance[1];
        sum[2] += 1.0f;
        sum[3] += n->cost;
    }
}

// Blocks of the film, each with probability `share`.
static void draw_blocks( const RfRenderer* r, int frame, double share, float* drawn )
{
    int width = r->sizes.width, across = ( width + BLOCK - 1 ) / BLOCK;
    uint64_t key = rf_pass_key( r->settings.seed, (uint32_t)frame, NOISE_GROUP, 2 );
    for ( int y = 0; y < r->sizes.height; ++y )
    {
        for ( int x = 0; x < width; ++x )
        {
            RfRandomKey block = rf_pixel_key( key, (uint32_t)( y / BLOCK * across + x / BLOCK ) );
            drawn[(size_t)y * (size_t)width + (size_t)x] = (double)rf_random( block, 0 ) < share ? 1.0f : 0.0f;
        }
    }
}

// Notes the class of each pixel's hit, plus 1, and counts the rays of its sample. Counts of integers do not depend on
// the order of threads.
static void note_classes( const RfRenderer* r, RfFirstHits first, float* classes )
{
    const RfVertexLanes* v = first.hits;
    for ( int i = 0; i < v->count; ++i )
    {
        int class = class_of( r->memory.noise, r->sizes.materials, v->material[i] );
        RfMaterialNoise* n = r->memory.noise + class;
        classes[first.pixel[v->slot[i]]] = 1.0f + (float)class;
#pragma omp atomic
        n->samples += 1;
#pragma omp atomic
        n->rays += first.path_rays != NULL ? first.path_rays[v->slot[i]] : 1;
    }
}

static void trace_half( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int first, int count )
{
    const RfEstimator* estimator = r->settings.estimator;
#pragma omp parallel num_threads( r->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        void* scratch = r->memory.trace_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            RfTraceJob job = { 0, first + i, pass->number };
            estimator->trace( pass->group, job, r->memory.batches[i], scratch, &mine );
            note_classes( r, estimator->first_hits( scratch ), live->films[0].extra[pass->half] );
        }
#pragma omp critical
        rf_add_rays( &r->rays, &mine );
    }
}

// Renders the drawn blocks of a frame into both halves of the film.
static void render_blocks( RfRenderer* r, int frame, RfLiveFilm* live )
{
    RfEstimatorGroup group = rf_frames_as_group( r, frame, 1, (int)NOISE_GROUP );
    group.need = live->need;
    group.filter = NULL;
    live->frame = frame;
    int jobs = r->sizes.of_estimator.jobs, slots = r->memory.batch_slots;
    for ( int half = 0; half < 2; ++half )
    {
        RfPass pass = { &group, half, half, 1 };
        for ( int first = 0; first < jobs; first += slots )
        {
            int count = jobs - first < slots ? jobs - first : slots;
            trace_half( r, &pass, live, first, count );
            rf_accumulate_extra( r, &pass, live, count );
        }
    }
}

static double pixel_mean( const RfFilm* film, size_t i )
{
    double sum = 0.0;
    for ( size_t c = 0; c < 3; ++c )
        sum += (double)film->half[0][4 * i + c] + (double)film->half[1][4 * i + c];
    return sum / 6.0;
}

// Half the squared difference is the variance of one sample.
static double pixel_square( const RfFilm* film, size_t i )
{
    double sum = 0.0;
    for ( size_t c = 0; c < 3; ++c )
    {
        double d = (double)film->half[0][4 * i + c] - (double)film->half[1][4 * i + c];
        sum += 0.5 * d * d;
    }
    return sum;
}

// Adds a part of a block to its class, once.
static void end_part( RfMaterialNoise* n, int set, double mean )
{
    if ( n->part_pixels == 0.0 )
        return;
    double part = n->part_square / ( mean * mean + DARK );
    n->pixels[set] += n->part_pixels;
    n->sum[set] += part;
    n->most[set] = fmax( n->most[set], part );
    n->part_pixels = n->part_square = 0.0;
}

// Adds a pixel to the classes of its two hits, half to each. Returns its mean.
static double add_pixel( RfMaterialNoise* noise, const RfFilm* film, size_t i )
{
    double square = pixel_square( film, i );
    for ( int half = 0; half < 2; ++half )
    {
        RfMaterialNoise* n = noise + (int)film->extra[half][i] - 1;
        n->part_pixels += 0.5;
        n->part_square += 0.5 * square;
    }
    return pixel_mean( film, i );
}

// A block of the film: the mean around its pixels is that of all of them.
static void sum_block( RfMaterialNoise* noise, int set, const RfFilm* film, int x0, int y0 )
{
    size_t found[BLOCK * BLOCK];
    double mean = 0.0;
    int count = 0;
    for ( int k = 0; k < BLOCK * BLOCK; ++k )
    {
        int x = x0 + k % BLOCK, y = y0 + k / BLOCK;
        size_t i = (size_t)y * (size_t)film->width + (size_t)x;
        if ( x >= film->width || y >= film->height || film->extra[0][i] == 0.0f || film->extra[1][i] == 0.0f )
            continue;
        mean += add_pixel( noise, film, i );
        found[count++] = i;
    }
    for ( int k = 0; k < 2 * count; ++k )
        end_part( noise + (int)film->extra[k % 2][found[k / 2]] - 1, set, mean / count );
}

static void sum_blocks( RfMaterialNoise* noise, int set, const RfFilm* film )
{
    for ( int y = 0; y < film->height; y += BLOCK )
    {
        for ( int x = 0; x < film->width; x += BLOCK )
            sum_block( noise, set, film, x, y );
    }
}

// Σ of a class. One block with a firefly counts as much as all others together at most.
static double robust_sum( const RfMaterialNoise* n, int set )
{
    return n->sum[set] - n->most[set] + fmin( n->most[set], n->sum[set] - n->most[set] );
}

// The mean rays of a class. One that was hardly seen costs what the mean of all does.
static void find_costs( RfMaterialNoise* noise, int materials )
{
    double samples = 0.0, rays = 0.0;
    for ( int k = 0; k <= materials; ++k )
    {
        samples += (double)noise[k].samples;
        rays += (double)noise[k].rays;
    }
    double mean = samples > 0.0 ? rays / samples : 1.0;
    for ( int k = 0; k <= materials; ++k )
    {
        RfMaterialNoise* n = noise + k;
        n->cost = (float)( 1.0 + ( (double)n->rays + PRIOR_PIXELS * mean ) / ( (double)n->samples + PRIOR_PIXELS ) );
    }
    for ( int k = 0; k < materials; ++k )
        noise[k].cost = noise[k].special ? noise[k].cost : noise[materials].cost;
}

// From sums to variances.
static void find_variances( RfMaterialNoise* noise, int materials, int set )
{
    double sum = 0.0, pixels = 0.0;
    for ( int k = 0; k < materials; ++k )
    {
        sum += robust_sum( noise + k, set );
        pixels += noise[k].pixels[set];
    }
    const RfMaterialNoise* alike = noise + materials;
    double mean = pixels > 0.0 ? sum / pixels : 0.0;
    double unit = alike->pixels[set] >= PRIOR_PIXELS ? robust_sum( alike, set ) / alike->pixels[set] : mean;
    for ( int k = 0; k <= materials; ++k )
    {
        RfMaterialNoise* n = noise + k;
        double variance = ( robust_sum( n, set ) + PRIOR_PIXELS * mean ) / ( n->pixels[set] + PRIOR_PIXELS );
        bool measured = n->special && pixels > 0.0 && unit > 0.0;
        n->variance[set] = measured ? (float)fmin( fmax( variance / unit, LEAST_VARIANCE ), MOST_VARIANCE ) : 1.0f;
    }
}

static void clear_classes( const RfRenderer* r )
{
    const RfScene* scene = rf_tracer_scene( r->tracer );
    memset( r->memory.noise, 0, rf_material_noise_bytes( &r->sizes ) );
    for ( int k = 0; k < r->sizes.materials; ++k )
    {
        const RfMaterial* material = scene->materials + k;
        r->memory.noise[k].special = material->kind == RF_BSDF_GLASS || rf_may_be_smooth( material );
    }
}

void rf_measure_noise( RfRenderer* r, RfLiveFilm* live )
{
    if ( r->memory.noise == NULL || r->memory.noise_known )
        return;
    clear_classes( r );
    int path = r->plan.frames, frames = path < FRAMES ? path : FRAMES, frame = live->frame;
    double pixels = (double)r->sizes.width * (double)r->sizes.height;
    double pairs = fmin( fmax( PAIR_SHARE * pixels * path * r->settings.spp, LEAST_PAIRS ), MOST_PAIRS );
    uint32_t* landed = live->aovs.landed;
    float* sky = live->aovs.mean[RF_AOV_ALPHA];
    live->aovs.landed = NULL; // AOVs do not count these samples
    live->aovs.mean[RF_AOV_ALPHA] = NULL;
    for ( int k = 0; k < frames; ++k )
    {
        int looked_at = (int)( ( 2 * (int64_t)k + 1 ) * path / ( 2 * frames ) );
        draw_blocks( r, looked_at, pairs / ( pixels * frames ), live->need );
        render_blocks( r, looked_at, live );
        sum_blocks( r->memory.noise, k % 2, live->films );
        rf_clear_film( live->films );
    }
    live->frame = frame;
    live->aovs.landed = landed;
    live->aovs.mean[RF_AOV_ALPHA] = sky;
    memset( live->need, 0, rf_need_bytes( &r->sizes ) );
    for ( int set = 0; set < 2; ++set )
        find_variances( r->memory.noise, r->sizes.materials, set );
    find_costs( r->memory.noise, r->sizes.materials );
    r->memory.noise_known = true;
}
