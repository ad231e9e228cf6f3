// Finds the threshold of the clamp. A pilot traces some patches of frames all over a path, each in two halves, and lists what their
// paths bring. For any threshold c that tells the variance that would be left and the light that would be taken out, squared the
// bias: in blocks of pixels, by the product of what both halves have lost, which is unbiased, relative to the brightness of the
// block. The least sum for the samples that the render will have is taken. It grows with them, since the
// variance falls with their number and the bias does not.
#include "render/clamp_threshold.h"

#include "base/random.h"
#include "base/system.h"
#include "math/vec3.h"
#include "reframe/measure.h"
#include "render/renderer.h"
#include "render/settings.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#define PILOT_SEED 1    // whatever that of the render: its seeds, and so its shots, get the same threshold
#define PILOT_FRAMES 16 // of a path, at most
// Samples of the pilot: this part of the path's, within limits.
#define PILOT_SHARE 0.03
#define LEAST_PILOT 128e3
#define MOST_PILOT 512e3
#define MOST_OF_FRAME 128e3 // whose paths are listed at once
#define BLOCK 4             // pixels
// Thresholds that are tried: by half octaves, in luminance.
#define LEAST_STEP ( -64 )
#define STEPS 256
#define FEW_PATHS 0.005 // of all, which do not count in the brightness of blocks
// A larger threshold takes out less light: the largest is taken that costs little more than the least, and is not far from it.
#define LITTLE_MORE 1.05
#define FAR_STEPS 4
// Of the variance without a clamp: where more is left, only what the pilot has not seen is clamped. Lamps seen by chains are part of
// the picture.
static const double s_worth_it[RF_CLAMP_KINDS] = { [RF_CLAMP_PATHS] = 0.9, [RF_CLAMP_CHAINS] = 0.5 };
#define SEEN_SHARE 0.7 // of what a frame sees, that another of its group sees as well, about
#define USUAL_SPP 64.0 // where a flicker or a time ends the render, not a number of samples

// What a path brought to a block.
typedef struct Path
{
    int32_t block;
    int16_t kind, half;
    float luminance;
} Path;

// Sums over the blocks of a path, by threshold, of paths of a kind.
typedef struct Tally
{
    double variance[STEPS]; // of a sample, relative to the squared brightness
    double bias[STEPS];     // squared, likewise
    float largest;          // that a path brought
} Tally;

typedef struct Pilot
{
    RfRenderer* renderer;
    RfRenderSettings settings; // the renderer's, with a seed of the pilot's own
    RfLiveFilm* film;          // borrowed
    RfClampWatch* watches;     // of `slots` batches that are traced at once: as many as there are threads, for their lists
    int slots;
    Path* paths; // of a frame
    size_t count, capacity;
    int columns, blocks;   // of the film
    double* sums;          // by block and half: samples and luminance
    double* kept;          // by block: luminance without rare paths
    double samples, light; // of the path: and the sum of their luminance
    Tally tally[RF_CLAMP_KINDS];
} Pilot;

static float step_threshold( float step ) { return exp2f( 0.5f * ( step + LEAST_STEP ) ); }

static int block_of( const Pilot* p, int32_t pixel )
{
    int width = p->renderer->setup->sizes.width;
    return pixel / width / BLOCK * p->columns + pixel % width / BLOCK;
}

static RfResult fail_memory( RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the pilot of the clamp: give a value in the place of auto" );
}

static bool take_paths( Pilot* p, const RfClampWatch* watch, int half )
{
    size_t wanted = p->count + (size_t)watch->count;
    if ( wanted > p->capacity )
    {
        size_t capacity = 2 * wanted;
        Path* paths = realloc( p->paths, capacity * sizeof *paths );
        if ( paths == NULL )
            return false;
        p->paths = paths;
        p->capacity = capacity;
    }
    for ( int i = 0; i < watch->count; ++i )
    {
        float luminance = watch->paths[i].luminance;
        if ( !isfinite( luminance ) )
            continue;
        int kind = (int)watch->paths[i].kind;
        p->paths[p->count++] = ( Path ){ block_of( p, watch->paths[i].pixel ), (int16_t)kind, (int16_t)half, luminance };
        p->tally[kind].largest = rf_maxf( p->tally[kind].largest, luminance );
    }
    return true;
}

// Traces patches [first, first + count) of a list into the half of the film that the pass goes to.
static bool trace_patches( Pilot* p, RfEstimatorGroup* group, const int* patches, int count, int pass )
{
    int half = pass % 2;
    RfRenderer* r = p->renderer;
    const RfEstimator* estimator = r->setup->settings.estimator;
    RfRayCounts rays = { 0 };
#pragma omp parallel num_threads( r->setup->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        void* scratch = r->memory.trace_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            RfEstimatorGroup watched = *group;
            watched.clamp_watch = p->watches + i;
            watched.clamp_watch->count = 0;
            estimator->trace( &watched, ( RfTraceJob ){ .job = patches[i], .pass = pass }, r->memory.batches[i], scratch, &mine );
        }
#pragma omp critical
        rf_add_rays( &rays, &mine );
    }
    rf_add_rays( &r->rays, &rays );
    RfAccumulateJob job = { .end_row = r->setup->sizes.height, .films = p->film->films, .half = half, .weight = 1.0f };
    estimator->accumulate( group, job, r->memory.batches, count, r->memory.accumulate_scratch[0] );
    bool listed = true;
    for ( int i = 0; i < count && listed; ++i )
        listed = take_paths( p, p->watches + i, half );
    return listed;
}

static void sum_blocks( Pilot* p )
{
    const RfFilm* film = p->film->films;
    memset( p->sums, 0, (size_t)p->blocks * 4 * sizeof *p->sums );
    for ( size_t i = 0; i < (size_t)film->width * (size_t)film->height; ++i )
    {
        double* sums = p->sums + 4 * (size_t)block_of( p, (int32_t)i );
        for ( int h = 0; h < 2; ++h )
        {
            const float* value = film->half[h] + 4 * i;
            sums[2 * h] += (double)value[3];
            sums[2 * h + 1] += (double)rf_luminance( rf_vec3( value[0], value[1], value[2] ) );
        }
    }
}

static int compare_paths( const void* a, const void* b )
{
    const Path *x = a, *y = b;
    if ( x->block != y->block )
        return x->block < y->block ? -1 : 1;
    if ( x->kind != y->kind )
        return x->kind < y->kind ? -1 : 1;
    if ( x->half != y->half )
        return x->half < y->half ? -1 : 1;
    return ( x->luminance > y->luminance ) - ( x->luminance < y->luminance );
}

// Of one half, in ascending order: what thresholds leave of the squares, and what they take out.
static void add_half( const Path* paths, size_t count, double* squares, double* lost )
{
    double below = 0.0, above = 0.0;
    size_t at = 0;
    for ( size_t i = 0; i < count; ++i )
        above += (double)paths[i].luminance;
    for ( int k = 0; k < STEPS; ++k )
    {
        double c = (double)step_threshold( (float)k );
        for ( ; at < count && (double)paths[at].luminance <= c; ++at )
        {
            below += (double)paths[at].luminance * (double)paths[at].luminance;
            above -= (double)paths[at].luminance;
        }
        squares[k] = below + c * c * (double)( count - at );
        lost[k] = at < count ? fmax( above - c * (double)( count - at ), 0.0 ) : 0.0;
    }
}

// The paths of a block and a kind.
typedef struct Block
{
    const Path* paths;
    size_t count, of_first; // those of the first half come first
    const double* sums;     // of Pilot.sums
} Block;

static Block block_from( const Pilot* p, size_t first )
{
    Block b = { .paths = p->paths + first, .sums = p->sums + 4 * (size_t)p->paths[first].block };
    for ( ; first + b.count < p->count && b.paths[b.count].block == b.paths->block && b.paths[b.count].kind == b.paths->kind;
          ++b.count )
        b.of_first += b.paths[b.count].half == 0;
    return b;
}

static size_t count_above( const Pilot* p, float c )
{
    size_t count = 0;
    for ( size_t i = 0; i < p->count; ++i )
        count += p->paths[i].luminance > c;
    return count;
}

// The brightness of blocks, without what few paths bring above all others: those would make their own block bright.
static void find_brightness( Pilot* p )
{
    int low = 0, high = STEPS - 1;
    while ( low < high )
    {
        int middle = ( low + high ) / 2;
        bool few = (double)count_above( p, step_threshold( (float)middle ) ) <= FEW_PATHS * (double)p->count;
        low = few ? low : middle + 1;
        high = few ? middle : high;
    }
    float c = step_threshold( (float)low );
    for ( int i = 0; i < p->blocks; ++i )
        p->kept[i] = p->sums[4 * i + 1] + p->sums[4 * i + 3];
    for ( size_t i = 0; i < p->count; ++i )
        p->kept[p->paths[i].block] -= (double)rf_maxf( p->paths[i].luminance - c, 0.0f );
}

static void add_block( Pilot* p, const Block* b )
{
    double squares[2][STEPS], lost[2][STEPS], pixels = b->sums[0] + b->sums[2];
    if ( !( b->sums[0] > 0.0 && b->sums[2] > 0.0 ) )
        return;
    add_half( b->paths, b->of_first, squares[0], lost[0] );
    add_half( b->paths + b->of_first, b->count - b->of_first, squares[1], lost[1] );
    double mean = fmax( p->kept[b->paths->block], 0.0 ) / pixels, scale = 1.0 / ( mean * mean + RF_RELMSE_EPSILON );
    Tally* tally = p->tally + b->paths->kind;
    for ( int k = 0; k < STEPS; ++k )
    {
        tally->variance[k] += scale * ( squares[0][k] + squares[1][k] );
        tally->bias[k] += scale * pixels * ( lost[0][k] / b->sums[0] ) * ( lost[1][k] / b->sums[2] );
    }
}

static void add_blocks( Pilot* p )
{
    sum_blocks( p );
    if ( p->count > 0 )
        qsort( p->paths, p->count, sizeof *p->paths, compare_paths );
    find_brightness( p );
    Block b;
    for ( size_t first = 0; first < p->count; first += b.count )
    {
        b = block_from( p, first );
        add_block( p, &b );
    }
    for ( int i = 0; i < p->blocks; ++i )
    {
        const double* sums = p->sums + 4 * (size_t)i;
        if ( !( sums[0] > 0.0 && sums[2] > 0.0 ) )
            continue;
        p->samples += sums[0] + sums[2];
        p->light += fmax( p->kept[i], 0.0 );
    }
}

// Patches of a frame, evenly spread over them, from a place that differs from frame to frame.
static int list_patches( const Pilot* p, int frame, int wanted, int* patches )
{
    const RfRenderer* r = p->renderer;
    int jobs = r->setup->sizes.of_estimator.jobs, count = wanted < jobs ? wanted : jobs;
    uint64_t key = rf_pass_key( p->settings.seed, (uint32_t)frame, RF_GROUP_OF_CLAMP, 0 );
    double start = (double)( key >> 40 ) / (double)( 1u << 24 );
    for ( int i = 0; i < count; ++i )
        patches[i] = (int)( ( i + start ) * jobs / count );
    return count;
}

// Caustics that are left out are in the last of them.
static void clear_films( const Pilot* p )
{
    for ( int f = 0; f < p->renderer->setup->sizes.film_count; ++f )
        rf_clear_film( p->film->films + f );
}

static bool look_at_frame( Pilot* p, int frame, int wanted, int* patches )
{
    RfRenderer* r = p->renderer;
    RfEstimatorGroup group = rf_frames_as_group( r, frame, 1, (int)RF_GROUP_OF_CLAMP );
    group.settings = &p->settings;
    group.filter = NULL;
    group.clamp = NULL;
    group.shared = r->memory.shared;
    int count = list_patches( p, frame, wanted, patches ), slots = p->slots;
    bool listed = true;
    clear_films( p );
    p->count = 0;
    int passes = 2 * ( ( wanted + count / 2 ) / count ); // small frames have several
    for ( int pass = 0; pass < passes && listed; ++pass )
    {
        if ( group.shared != NULL )
            r->setup->settings.estimator->prepare( &group, pass, r->memory.shared, &r->rays );
        for ( int first = 0; first < count && listed; first += slots )
            listed = trace_patches( p, &group, patches + first, count - first < slots ? count - first : slots, pass );
    }
    if ( listed )
        add_blocks( p );
    clear_films( p );
    return listed;
}

// Samples that count in a pixel: those of the frames around reach it too, most of them, and a filter joins those of several pixels.
static double worth_of( const RfRenderer* r )
{
    const RfRenderSettings* s = &r->setup->settings;
    double filtered = rf_is_plain_filter( s ) ? 1.0 : r->setup->filter.worth;
    return ( 1.0 + SEEN_SHARE * ( r->setup->plan.eyes - 1 ) ) / filtered;
}

// The threshold of the least error, or where the relMSE is given, of the fewest samples that reach it.
static float choose_threshold( const Pilot* p, const Tally* tally )
{
    const RfRenderer* r = p->renderer;
    const RfRenderSettings* s = &r->setup->settings;
    double worth = worth_of( r ), spp = rf_is_stopping( s ) ? USUAL_SPP : s->spp, cost[STEPS];
    int least = 0;
    for ( int k = 0; k < STEPS; ++k )
    {
        double variance = tally->variance[k] / ( p->samples * worth ), bias = tally->bias[k] / p->samples;
        cost[k] = s->noise > 0.0 ? ( bias < s->noise ? variance / ( s->noise - bias ) : INFINITY ) : variance / spp + bias;
        least = cost[k] < cost[least] ? k : least;
    }
    double limit = LITTLE_MORE * cost[least], beyond = 0.0;
    int best = least;
    for ( int k = least; k < STEPS && k <= least + FAR_STEPS; ++k )
        best = cost[k] <= limit ? k : best;
    if ( best < least + FAR_STEPS && best + 1 < STEPS && cost[best + 1] > limit ) // in between: no jumps by the step
        beyond = ( limit - cost[best] ) / ( cost[best + 1] - cost[best] );
    if ( !( cost[least] < s_worth_it[tally - p->tally] * cost[STEPS - 1] ) ) // also where nothing was found twice
        best = STEPS - 1, beyond = 0.0;
    // beyond what the pilot has seen, nothing is known; with more samples larger ones are found
    double seen = worth * spp * r->setup->sizes.width * r->setup->sizes.height / p->samples;
    return rf_minf( step_threshold( (float)( best + beyond ) ), tally->largest * (float)sqrt( fmax( seen, 1.0 ) ) );
}

// A kind of which the pilot has seen nothing has the threshold of the other; of neither, there is none. Lights seen by chains are few
// in a pilot, so their threshold is not below the brightness of the picture.
static RfClampThresholds choose_thresholds( const Pilot* p )
{
    bool paths = p->tally[RF_CLAMP_PATHS].largest > 0.0f, chains = p->tally[RF_CLAMP_CHAINS].largest > 0.0f;
    float of_paths = paths ? choose_threshold( p, p->tally + RF_CLAMP_PATHS ) : INFINITY;
    float of_chains = chains ? choose_threshold( p, p->tally + RF_CLAMP_CHAINS ) : of_paths;
    float mean = p->samples > 0.0 ? (float)( p->light / p->samples ) : 0.0f;
    return ( RfClampThresholds ){ { paths ? of_paths : of_chains, rf_maxf( mean, of_chains ) } };
}

// False without memory.
static bool look_at_path( Pilot* p, int* patches )
{
    const RfRenderer* r = p->renderer;
    int all = r->setup->plan.frames, frames = all < PILOT_FRAMES ? all : PILOT_FRAMES;
    double pixels = (double)r->setup->sizes.width * (double)r->setup->sizes.height;
    double samples = fmin( fmax( PILOT_SHARE * pixels * all * r->setup->settings.spp, LEAST_PILOT ), MOST_PILOT );
    double of_patch = pixels / r->setup->sizes.of_estimator.jobs;
    int wanted = (int)ceil( fmin( samples / frames, MOST_OF_FRAME ) / ( 2.0 * of_patch ) );
    for ( int k = 0; k < frames; ++k )
    {
        if ( !look_at_frame( p, (int)( ( 2 * (int64_t)k + 1 ) * all / ( 2 * frames ) ), wanted, patches ) )
            return false;
    }
    return true;
}

// All frames have the same thresholds: shots of one set would differ in brightness.
static RfResult run_pilot( RfRenderer* r, Pilot* p, int* patches, RfError* error )
{
    if ( !look_at_path( p, patches ) )
        return fail_memory( error );
    RfClampThresholds chosen = choose_thresholds( p );
    for ( int frame = 0; frame < r->setup->plan.frames; ++frame )
    {
        for ( int kind = 0; kind < RF_CLAMP_KINDS; ++kind )
            r->clamps[frame].threshold[kind] =
                r->clamps[frame].threshold[kind] > 0.0f ? r->clamps[frame].threshold[kind] : chosen.threshold[kind];
    }
    return rf_check_worlds( &r->worlds, error );
}

// What a list of a batch's paths can hold: those of all pairings, light by chains and what is own-frame.
static int list_capacity( const RfRenderer* r ) { return RF_LANES * 2 * ( r->setup->sizes.of_estimator.directions + 1 ); }

static RfResult find_by_pilot( RfRenderer* r, RfError* error )
{
    int width = r->setup->sizes.width, height = r->setup->sizes.height, threads = r->setup->settings.threads;
    int slots = r->memory.batch_slots < threads ? r->memory.batch_slots : threads;
    int columns = ( width + BLOCK - 1 ) / BLOCK, blocks = columns * ( ( height + BLOCK - 1 ) / BLOCK ),
        capacity = list_capacity( r );
    RfRenderSettings settings = r->setup->settings;
    settings.seed = PILOT_SEED;
    Pilot p = {
        .slots = slots, .renderer = r, .settings = settings, .film = r->memory.films, .columns = columns, .blocks = blocks
    };
    int* patches = malloc( (size_t)r->setup->sizes.of_estimator.jobs * sizeof *patches );
    RfWatchedPath* lists = malloc( (size_t)slots * (size_t)capacity * sizeof *lists );
    p.watches = malloc( (size_t)slots * sizeof *p.watches );
    p.sums = malloc( (size_t)blocks * 4 * sizeof *p.sums );
    p.kept = malloc( (size_t)blocks * sizeof *p.kept );
    bool allocated = patches != NULL && lists != NULL && p.watches != NULL && p.sums != NULL && p.kept != NULL;
    for ( int i = 0; i < slots && allocated; ++i )
        p.watches[i] = ( RfClampWatch ){ .paths = lists + (size_t)i * (size_t)capacity, .capacity = capacity };
    RfResult result = allocated ? run_pilot( r, &p, patches, error ) : fail_memory( error );
    free( patches );
    free( lists );
    free( p.watches );
    free( p.sums );
    free( p.kept );
    free( p.paths );
    return result;
}

RfResult rf_find_clamps( RfRenderer* r, RfError* error )
{
    double value = r->setup->settings.clamp;
    int frames = r->setup->shot.eye_count;
    if ( value == 0.0 )
        return RF_OK;
    r->clamps = malloc( (size_t)frames * sizeof *r->clamps );
    if ( r->clamps == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the thresholds of %d frames", frames );
    double chains = r->setup->settings.clamp_chains > 0.0 ? r->setup->settings.clamp_chains : value;
    for ( int frame = 0; frame < frames; ++frame )
        r->clamps[frame] = ( RfClampThresholds ){ { (float)value, (float)chains } };
    return value == RF_CLAMP_AUTO ? find_by_pilot( r, error ) : RF_OK;
}
