// Runs the pilot, decides by its variances and costs which pixels pay, and renders their extra samples.
#include "render/adaptive/adaptive.h"

#include "render/accumulation.h"

#include "base/random.h"
#include "base/system.h"
#include "render/adaptive/glint_pilot.h"
#include "render/adaptive/need.h"
#include "scene/textured.h"

#include <math.h>
#include <omp.h>
#include <string.h>

// Weight of an extra sample beside one of a pass.
static double extra_worth( const RfRenderer* r )
{
    return rf_is_plain_filter( &r->setup->settings ) ? 1.0 : r->setup->filter.worth;
}

// Adds the first `count` batches, of one frame alone, to its film.
static void accumulate_extra( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, int count )
{
    float worth = pass->group->filter != NULL ? (float)extra_worth( r ) : 1.0f;
    rf_accumulate_batches( r, pass, ( RfFilmRange ){ live, 1 }, worth, 0, count );
}

// The noise of materials.

#define NOISE_FRAMES 8 // of the path that are looked at
#define BLOCK 8        // pixels: side of what is drawn
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

// Adds to each pixel of `sums` (four floats) the two variances of its hit's class, 1, and its cost.
static void add_noise( const RfMaterialNoise* noise, RfFirstHits first, float* sums )
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
    int width = r->setup->sizes.width, across = ( width + BLOCK - 1 ) / BLOCK;
    uint64_t key = rf_pass_key( r->setup->settings.seed, (uint32_t)frame, RF_GROUP_OF_NOISE, 2 );
    for ( int y = 0; y < r->setup->sizes.height; ++y )
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
static void note_classes( RfRenderer* r, const RfPass* pass, int eye, const void* batch, const void* scratch, void* user )
{
    (void)eye;
    (void)batch;
    RfFirstHits first = r->setup->settings.estimator->first_hits( scratch );
    const RfVertexLanes* v = first.hits;
    float* classes = ( (RfLiveFilm*)user )->films[0].extra[pass->half];
    for ( int i = 0; i < v->count; ++i )
    {
        int class = class_of( r->memory.noise, r->setup->sizes.materials, v->material[i] );
        RfMaterialNoise* n = r->memory.noise + class;
        classes[first.pixel[v->slot[i]]] = 1.0f + (float)class;
#pragma omp atomic
        n->samples += 1;
#pragma omp atomic
        n->rays += first.path_rays != NULL ? first.path_rays[v->slot[i]] : 1;
    }
}

// Renders the drawn blocks of a frame into both halves of the film.
static void render_blocks( RfRenderer* r, int frame, RfLiveFilm* live )
{
    RfEstimatorGroup group = rf_frames_as_group( r, frame, 1, (int)RF_GROUP_OF_NOISE );
    group.need = live->need;
    group.filter = NULL;
    live->frame = frame;
    int jobs = r->setup->sizes.of_estimator.jobs, slots = r->memory.batch_slots;
    for ( int half = 0; half < 2; ++half )
    {
        RfPass pass = { .group = &group, .number = half, .half = half, .weight = 1 };
        for ( int first = 0; first < jobs; first += slots )
        {
            int count = jobs - first < slots ? jobs - first : slots;
            rf_trace_batches( r, &pass, first, count, note_classes, live );
            accumulate_extra( r, &pass, live, count );
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
    const RfScene* scene = rf_tracer_scene( r->setup->shot.tracer );
    memset( r->memory.noise, 0, rf_material_noises( &r->setup->sizes ) * sizeof *r->memory.noise );
    for ( int k = 0; k < r->setup->sizes.materials; ++k )
    {
        const RfMaterial* material = scene->materials + k;
        r->memory.noise[k].special = material->kind >= RF_BSDF_FIRST_SPECULAR || rf_may_be_smooth( material );
    }
}

// Measures the classes, if there are any and it has not been done. Borrows a film that has just been cleared.
static void measure_noise( RfRenderer* r, RfLiveFilm* live )
{
    if ( r->memory.noise == NULL || r->memory.noise_known )
        return;
    clear_classes( r );
    int path = r->setup->plan.frames, frames = path < NOISE_FRAMES ? path : NOISE_FRAMES, frame = live->frame;
    double pixels = (double)r->setup->sizes.width * (double)r->setup->sizes.height;
    double pairs = fmin( fmax( PAIR_SHARE * pixels * path * r->setup->settings.spp, LEAST_PAIRS ), MOST_PAIRS );
    uint32_t* landed = live->aovs.landed;
    float* sky = live->aovs.mean[RF_AOV_ALPHA];
    RfCovering* covering = live->covering;
    live->covering = NULL;
    live->aovs.landed = NULL; // AOVs do not count these samples
    live->aovs.mean[RF_AOV_ALPHA] = NULL;
    for ( int k = 0; k < frames; ++k )
    {
        int looked_at = (int)( ( 2 * (int64_t)k + 1 ) * path / ( 2 * frames ) );
        draw_blocks( r, looked_at, pairs / ( pixels * frames ), live->need );
        render_blocks( r, looked_at, live );
        sum_blocks( r->memory.noise, k % 2, live->films );
        for ( int f = 0; f < r->setup->sizes.film_count; ++f )
            rf_clear_film( live->films + f );
    }
    live->frame = frame;
    live->aovs.landed = landed;
    live->covering = covering;
    live->aovs.mean[RF_AOV_ALPHA] = sky;
    memset( live->need, 0, rf_film_pixels( &r->setup->sizes ) * sizeof *live->need );
    for ( int set = 0; set < 2; ++set )
        find_variances( r->memory.noise, r->setup->sizes.materials, set );
    find_costs( r->memory.noise, r->setup->sizes.materials );
    r->memory.noise_known = true;
}

// Sets a value of each pixel.
static void fill( const RfRenderer* r, float value, float* pixels )
{
    size_t width = (size_t)r->setup->sizes.width;
#pragma omp parallel for num_threads( r->setup->settings.threads ) schedule( static )
    for ( int y = 0; y < r->setup->sizes.height; ++y )
    {
        rf_set_float_mode();
        for ( size_t i = (size_t)y * width; i < ( (size_t)y + 1 ) * width; ++i )
            pixels[i] = value;
    }
}

// The pilot.

#define PILOT_PASSES 2
// The coarse look before the pilot: this part of a frame's pixels, and so many where it is small.
#define LOOK_SHARE ( 1.0 / 16.0 )
#define LOOK_PIXELS 512.0

// The frames around one, as far as its shot goes.
static RfEstimatorGroup pilot_group( RfRenderer* r, int frame )
{
    int eyes = r->setup->plan.eyes, first;
    rf_frames_around( &r->setup->plan, frame, &first, &eyes );
    RfEstimatorGroup group = rf_frames_as_group( r, first, eyes, (int)RF_GROUP_OF_PILOT );
    group.first_hits_only = true;
    group.filter = NULL;
    return group;
}

// One pass over the batches of the frame: as many at once as there is memory for. They share no pixel. `samples`, if
// not NULL, counts the camera rays of each pixel.
static void run_pilot_pass( RfRenderer* r, const RfEstimatorGroup* group, int pass, RfLiveFilm* live, float* samples )
{
    const RfEstimator* estimator = r->setup->settings.estimator;
#pragma omp parallel num_threads( r->setup->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        void* scratch = r->memory.trace_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int slot = 0; slot < r->memory.batch_slots; ++slot )
        {
            void* batch = r->memory.batches[slot];
            for ( int job = slot; job < r->setup->sizes.of_estimator.jobs; job += r->memory.batch_slots )
            {
                estimator->trace( group, ( RfTraceJob ){ live->frame - group->first_frame, job, pass }, batch, scratch, &mine );
                estimator->add_own_shares( batch, scratch, live->need );
                if ( r->memory.noise != NULL )
                    add_noise( r->memory.noise, estimator->first_hits( scratch ), live->films[0].half[0] );
                if ( samples != NULL )
                    estimator->count_samples( batch, 1.0f, samples );
            }
        }
#pragma omp critical
        rf_add_rays( &r->rays, &mine );
    }
}

static float* noise_sums( const RfRenderer* r, const RfLiveFilm* live )
{
    return r->memory.noise != NULL ? live->films[0].half[0] : NULL;
}

// One ray for each pixel of some tiles, drawn like those of an extra sample: are there enough pixels without help for
// a pilot to be worth it? The film is empty yet and lends its counts of extra samples.
static bool look_for_gain( RfRenderer* r, RfEstimatorGroup group, RfLiveFilm* live )
{
    size_t pixels = (size_t)r->setup->sizes.width * (size_t)r->setup->sizes.height;
    float *drawn = live->films[0].extra[0], *samples = live->films[0].extra[1];
    fill( r, (float)fmax( LOOK_SHARE, LOOK_PIXELS / (double)pixels ), drawn );
    group.need = drawn;
    run_pilot_pass( r, &group, PILOT_PASSES, live, samples );
    RfPilotSums sums = { .share = live->need,
                         .noise = noise_sums( r, live ),
                         .samples = samples,
                         .pixels = pixels,
                         .passes = 1.0f,
                         .eyes = group.eye_count,
                         .wary = true,
                         .worth = extra_worth( r ) };
    bool pays = rf_extra_may_pay( &sums );
    fill( r, 0.0f, live->need );
    rf_clear_film( live->films );
    return pays;
}

static void find_need( RfRenderer* r, RfLiveFilm* live )
{
    RfEstimatorGroup group = pilot_group( r, live->frame );
    if ( r->setup->settings.adaptive == RF_ADAPTIVE_AUTO && !look_for_gain( r, group, live ) )
        return;
    for ( int pass = 0; pass < PILOT_PASSES; ++pass )
        run_pilot_pass( r, &group, pass, live, NULL );
    size_t pixels = (size_t)r->setup->sizes.width * (size_t)r->setup->sizes.height;
    RfPilotSums sums = { .share = live->need,
                         .noise = noise_sums( r, live ),
                         .pixels = pixels,
                         .passes = PILOT_PASSES,
                         .eyes = group.eye_count,
                         .wary = r->setup->settings.adaptive == RF_ADAPTIVE_AUTO,
                         .worth = extra_worth( r ) };
    live->most_need = rf_set_need( &sums );
    rf_clear_film( live->films );
}

void rf_run_pilot( RfRenderer* r, RfLiveFilm* live )
{
    fill( r, 0.0f, live->need );
    live->most_need = 0.0f;
    if ( r->setup->plan.eyes > 1 )
    {
        measure_noise( r, live );
        find_need( r, live );
    }
    live->most_glints = 0.0f;
    if ( live->glints != NULL )
        rf_find_glints( r, live, extra_worth( r ) );
    // without extra samples the sums are those of a render without adaptive sampling, bit for bit
    live->films[0].block = rf_film_block( r->setup->plan.eyes * rf_filter_pixels( &r->setup->settings ) +
                                          ( live->most_need > 0.0f ? rf_most_extra( r->memory.noise != NULL ) : 0 ) +
                                          ( live->most_glints > 0.0f ? RF_MOST_GLINTS : 0 ) );
}

// The samples of some tiles of a frame alone.

static void count_extra( RfRenderer* r, const RfPass* pass, int eye, const void* batch, const void* scratch, void* user )
{
    (void)eye;
    (void)scratch;
    RfFilm* film = ( (RfLiveFilm*)user )->films;
    float weight = (float)( pass->weight * extra_worth( r ) );
    uint64_t samples = r->setup->settings.estimator->count_samples( batch, weight, film->extra[pass->half] );
#pragma omp atomic
    film->extra_samples += samples;
}

// A kind of extra samples.
typedef struct Extra
{
    const float* need;
    uint32_t group; // whose numbers they have
    int most;       // of a pixel in a pass
    bool packed, single;
} Extra;

// Extra samples of a frame: of the tiles that are drawn one more, or, packed, as many as fill a batch of each job. Returns
// their number.
static uint64_t render_round( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, Extra kind, int round )
{
    RfEstimatorGroup group = rf_frames_as_group( r, live->frame, 1, (int)( kind.group | (uint32_t)pass->group->number ) );
    group.need = kind.need;
    group.round = round;
    group.packed = kind.packed;
    group.single = kind.single;
    group.shared = pass->group->shared; // that of the pass
    RfPass extra = { .group = &group,
                     .number = kind.most * pass->number + ( kind.packed ? 0 : round ),
                     .half = pass->half,
                     .weight = pass->weight };
    int jobs = r->setup->sizes.of_estimator.jobs;
    uint64_t before = live->films[0].extra_samples;
    for ( int first = 0; first < jobs; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
        rf_trace_batches( r, &extra, first, count, count_extra, live );
        accumulate_extra( r, &extra, live, count );
    }
    return live->films[0].extra_samples - before;
}

static void render_packed( RfRenderer* r, const RfPass* pass, RfLiveFilm* live, Extra kind )
{
    for ( int round = 0; render_round( r, pass, live, kind, round ) > 0; ++round )
        ;
}

static void render_frame_extra( RfRenderer* r, const RfPass* pass, RfLiveFilm* live )
{
    bool noisy = r->memory.noise != NULL;
    Extra tiles = { live->need, RF_GROUP_OF_EXTRA, rf_most_extra( noisy ), noisy, false };
    if ( noisy && live->most_need > 0.0f )
        render_packed( r, pass, live, tiles );
    for ( int round = 0; !noisy && (float)round < live->most_need; ++round )
        render_round( r, pass, live, tiles, round );
    if ( live->most_glints > 0.0f )
        render_packed( r, pass, live, ( Extra ){ live->glints, RF_GROUP_OF_GLINTS, RF_MOST_GLINTS, true, true } );
}

void rf_render_extra( RfRenderer* r, const RfPass* pass )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        RfLiveFilm* live = r->memory.films + i;
        if ( live->frame != -1 && ( live->most_need > 0.0f || live->most_glints > 0.0f ) )
            render_frame_extra( r, pass, live );
    }
    rf_frames_as_group( r, pass->group->first_frame, pass->group->eye_count, pass->group->number ); // with its ghosts again
}
