// Runs the pilot, decides by its variances and costs which pixels pay, and renders their extra samples.
#include "render/adaptive/adaptive.h"

#include "base/random.h"
#include "base/system.h"
#include "render/accumulation.h"
#include "scene/textured.h"
#include "trace/trace.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define BINS 64
// Cost of a sample beside that of a path: for each further camera of a group, and
// of an extra one, which comes in broken wavefronts.
#define COST_OF_EYE 0.05
#define COST_OF_EXTRA 1.2
#define COST_OF_EXTRA_NOISY 1.6 // packed into few batches, with a pilot that follows chains
#define LEAST_GAIN 0.02         // by these figures, which are rough
#define LOOK_GAIN 0.01          // that justifies a pilot: a coarse look may miss some of it
// The same with RF_ADAPTIVE_AUTO where materials differ in noise, of which little is known, too: samples that promised a fifth of
// error times cost brought nothing (src/reuse/tried.md).
#define LEAST_GAIN_NOISY 0.25
#define LOOK_GAIN_NOISY 0.2
// Where materials differ in noise: θ from the least to the most, over about so many pixels.
#define LEAST_THETA 0.05
#define MOST_THETA 64.0
#define THETA_STEP 1.1
#define SOME_PIXELS 1024

// rf_extra_threshold for gains from `least_gain` on.
static double threshold( const double* counts, int bins, double all, int eyes, double worth, double least_gain )
{
    double best = 1.0, least = 0.0, without = 0.0;
    for ( int step = 0; step <= 10 * ( RF_MOST_EXTRA - 1 ) * fmin( worth, 1.0 ); ++step )
    {
        double theta = 1.0 + 0.1 * step, error = 0.0, cost = all * ( 1.0 + COST_OF_EYE * ( eyes - 1 ) );
        for ( int b = 0; b < bins; ++b )
        {
            double info = (double)bins / ( b + 1 );
            error += counts[b] / fmax( info, theta );
            cost += counts[b] * COST_OF_EXTRA * fmax( 0.0, theta - info ) / worth;
        }
        without = step == 0 ? error * cost : without;
        if ( step > 0 && error * cost >= least )
            continue;
        best = theta;
        least = error * cost;
    }
    return least > ( 1.0 - least_gain ) * without ? 1.0 : best;
}

double rf_extra_threshold( const double* counts, int bins, double all, int eyes )
{
    return threshold( counts, bins, all, eyes, 1.0, LEAST_GAIN );
}

// The mean of ρ over the passes.
static float pixel_share( const RfPilotSums* sums, size_t i ) { return fminf( sums->share[i] / sums->passes, 1.0f ); }

// Which of the two measurements of variance is meant.
typedef enum Measured
{
    FIRST,
    SECOND,
    BOTH,
} Measured;

static float pixel_variance( const RfPilotSums* sums, size_t i, Measured which )
{
    if ( sums->noise == NULL || sums->noise[4 * i + 2] == 0.0f )
        return 1.0f;
    float variance = which == BOTH ? 0.5f * ( sums->noise[4 * i] + sums->noise[4 * i + 1] ) : sums->noise[4 * i + (size_t)which];
    return variance / sums->noise[4 * i + 2];
}

// The mean cost of a pixel's samples. Only ratios matter.
static float pixel_cost( const RfPilotSums* sums, size_t i )
{
    return sums->noise != NULL && sums->noise[4 * i + 2] > 0.0f ? sums->noise[4 * i + 3] / sums->noise[4 * i + 2] : 1.0f;
}

// Extra samples of a pixel in a pass: the error is least for its cost where samples go with the root of variance over cost.
static float extra_of( const RfPilotSums* sums, size_t i, Measured which, float share, double theta )
{
    float wanted = (float)theta * sqrtf( pixel_variance( sums, i, which ) / pixel_cost( sums, i ) );
    float extra = fmaxf( 0.0f, wanted - 1.0f / share ) / (float)sums->worth;
    return fminf( extra, RF_MOST_EXTRA_NOISY );
}

static void count_share( float share, double* counts )
{
    if ( share > 0.0f )
        counts[(int)fminf( share * BINS, BINS - 1 )] += 1.0;
}

// θ for the pixels with samples where all materials are alike.
static double threshold_alike( const RfPilotSums* sums, double least_gain )
{
    double counts[BINS] = { 0 }, seen = 0.0; // whole numbers: in any order the same
#pragma omp parallel reduction( + : seen, counts[:BINS] )
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( size_t i = 0; i < sums->pixels; ++i )
        {
            if ( sums->samples != NULL && sums->samples[i] == 0.0f )
                continue;
            count_share( pixel_share( sums, i ), counts );
            seen += 1.0;
        }
    }
    return threshold( counts, BINS, seen, sums->eyes, sums->worth, least_gain );
}

// Error times cost for a theta, over some pixels: of samples placed by one measurement, by the variances of another.
static double error_times_cost( const RfPilotSums* sums, Measured placed_by, Measured judged_by, double theta )
{
    size_t stride = sums->pixels / SOME_PIXELS + 1;
    double error = 0.0, cost = 0.0, passes = 0.0;
    for ( size_t i = 0; i < sums->pixels; i += stride )
    {
        if ( sums->samples != NULL && sums->samples[i] == 0.0f )
            continue;
        passes += (double)pixel_cost( sums, i );
        float share = pixel_share( sums, i );
        if ( share <= 0.0f )
            continue;
        float extra = extra_of( sums, i, placed_by, share, theta );
        error += (double)( pixel_variance( sums, i, judged_by ) / ( 1.0f / share + (float)sums->worth * extra ) );
        cost += COST_OF_EXTRA_NOISY * (double)( extra * pixel_cost( sums, i ) );
    }
    return error * ( passes * ( 1.0 + COST_OF_EYE * ( sums->eyes - 1 ) ) + cost );
}

// The theta that is best by one measurement. 0: no extra samples pay.
static double best_theta( const RfPilotSums* sums, Measured which )
{
    double least = error_times_cost( sums, which, which, 0.0 ), best = 0.0;
    for ( double theta = LEAST_THETA; theta <= MOST_THETA; theta *= THETA_STEP )
    {
        double product = error_times_cost( sums, which, which, theta );
        if ( product >= least )
            continue;
        least = product;
        best = theta;
    }
    return best;
}

// The same, where a margin is asked for. A few bright paths make a material look noisier than it is, and samples that are placed
// by them look better than they are. So what is placed by each measurement is judged by the other.
static double threshold_wary( const RfPilotSums* sums, double least_gain )
{
    double with = 0.0, without = 0.0;
    for ( int judge = FIRST; judge <= SECOND; ++judge )
    {
        Measured other = judge == FIRST ? SECOND : FIRST;
        double scale = error_times_cost( sums, other, (Measured)judge, 0.0 );
        if ( scale > 0.0 )
            with += error_times_cost( sums, other, (Measured)judge, best_theta( sums, other ) ) / scale;
        without += scale > 0.0;
    }
    return with > ( 1.0 - least_gain ) * without || without == 0.0 ? 0.0 : best_theta( sums, BOTH );
}

// The same where materials differ. 0: no extra samples pay.
static double threshold_noisy( const RfPilotSums* sums )
{
    if ( sums->wary )
        return threshold_wary( sums, LEAST_GAIN_NOISY );
    double theta = best_theta( sums, BOTH );
    bool pays = error_times_cost( sums, BOTH, BOTH, theta ) < ( 1.0 - LEAST_GAIN ) * error_times_cost( sums, BOTH, BOTH, 0.0 );
    return pays ? theta : 0.0;
}

bool rf_extra_may_pay( const RfPilotSums* sums )
{
    return sums->noise != NULL ? threshold_wary( sums, LOOK_GAIN_NOISY ) > 0.0 : threshold_alike( sums, LOOK_GAIN ) > 1.0;
}

float rf_set_need( const RfPilotSums* sums )
{
    double theta = sums->noise != NULL ? threshold_noisy( sums ) : threshold_alike( sums, LEAST_GAIN );
    float most = 0.0f;
#pragma omp parallel reduction( max : most )
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( size_t i = 0; i < sums->pixels; ++i )
        {
            float share = pixel_share( sums, i );
            sums->share[i] = share > 0.0f ? extra_of( sums, i, BOTH, share, theta ) : 0.0f;
            most = fmaxf( most, sums->share[i] );
        }
    }
    return most;
}

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

static RfPilotSums pilot_sums( const RfRenderer* r, const RfLiveFilm* live, int eyes, int passes )
{
    return ( RfPilotSums ){ .share = live->need,
                            .noise = r->memory.noise != NULL ? live->films[0].half[0] : NULL,
                            .pixels = rf_film_pixels( &r->setup->sizes ),
                            .passes = (float)passes,
                            .eyes = eyes,
                            .wary = r->setup->settings.adaptive == RF_ADAPTIVE_AUTO,
                            .worth = extra_worth( r ) };
}

// One ray for each pixel of some tiles, drawn like those of an extra sample: are there enough pixels without help for
// a pilot to be worth it? The film is empty yet and lends its counts of extra samples.
static bool look_for_gain( RfRenderer* r, RfEstimatorGroup group, RfLiveFilm* live )
{
    float *drawn = live->films[0].extra[0], *samples = live->films[0].extra[1];
    fill( r, (float)fmax( LOOK_SHARE, LOOK_PIXELS / (double)rf_film_pixels( &r->setup->sizes ) ), drawn );
    group.need = drawn;
    run_pilot_pass( r, &group, PILOT_PASSES, live, samples );
    RfPilotSums sums = pilot_sums( r, live, group.eye_count, 1 );
    sums.samples = samples;
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
    RfPilotSums sums = pilot_sums( r, live, group.eye_count, PILOT_PASSES );
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
    rf_frames_as_group( r, pass->group->first_frame, pass->group->eye_count,
                        pass->group->number ); // with its swept geometry again
}
