// Learns a guide by a pilot over the whole path of the camera. Some thousand paths of frames all over it tell how much light varies
// from path to path: where it varies little, or few samples are to come, the pilot ends here. Else three more passes learn, each
// guided by what those before have learned. The guide is kept if each of them varies so much less than paths that were not guided, that
// it is worth its rays.
#include "render/guide_pilot.h"

#include "base/system.h"
#include "path/guide_learner.h"
#include "scene/lens.h"
#include "scene/projection.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#define PILOT_SEED 1 // whatever that of the render
#define LENS_SALT 0x1e4500000000u
#define PILOT_FRAMES 16  // of a path, at most
#define PILOT_SHARE 0.03 // of the path's samples
#define LEAST_PATHS 16e3 // what fewer learn does not help
#define MOST_PATHS 128e3
#define USUAL_SPP 64.0 // where a noise, a flicker or a time ends the render
#define AT_ONCE 256    // paths of a batch
#define PARTS 24       // of the pilot's paths
#define PASSES 5
static const int s_parts[PASSES] = { 1, 5, 4, 8, 6 }; // of the passes
#define UNGUIDED_PASSES 2
// Pictures are looked at in so many blocks, each over all frames, in which light varies less than over all of them.
#define COLUMNS 8
#define ROWS 4
#define BLOCKS ( COLUMNS * ROWS )
#define MOST_LIGHT 1e18
#define DARK 1e-3          // what relMSE adds to squares
#define LEAST_VARIANCE 2.0 // of a path, relative to the squared brightness, below which no guide pays
// The larger variances are, the rarer are the paths that make them, and the less a pilot sees of what a guide saves.
#define KNOWN_VARIANCE 8.0
#define GUIDED_COST 1.15  // time of a guided path, beside its rays
#define LEAST_WORTH 1.1   // that a guide is kept for
#define LEAST_PROMISE 0.9 // after fewer passes

// Of the light that paths brought to a block.
typedef struct Block
{
    double count, sum, squares;
} Block;

typedef struct Batch
{
    int frame; // of those of the pilot
    int number, paths;
    RfGuideSample* samples;
    int sample_count;
    Block blocks[BLOCKS];
    double rays;
} Batch;

// What is known of paths of one kind.
typedef struct Light
{
    Block blocks[BLOCKS];
    double paths, rays; // rays of all of them
} Light;

typedef struct Work
{
    RfWavefront wavefront;
    RfGuideNotes notes;
    int block[RF_LANES]; // of paths, by slot
} Work;

typedef struct Pilot
{
    RfRenderer* renderer;
    int frames;
    RfGuideSample* samples;
    int sample_count, capacity;
    int batches; // so far, of a frame: their random numbers
    Light unguided, guided;
} Pilot;

static RfResult fail_memory( RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory learning where light comes from: --guide off does without" );
}

static int frame_of( const Pilot* p, int k )
{
    return (int)( ( 2 * (int64_t)k + 1 ) * p->renderer->setup->shot.eye_count / ( 2 * p->frames ) );
}

// Writes a camera ray of a batch to a lane. Returns its block.
static int make_ray( const Pilot* p, const Batch* batch, int lane, RfWavefront* w )
{
    int frame = frame_of( p, batch->frame );
    const RfEye* eye = p->renderer->setup->shot.eyes + frame;
    uint64_t pass = rf_pass_key( PILOT_SEED, (uint32_t)frame, RF_GROUP_OF_GUIDE, (uint32_t)batch->number );
    RfRandomKey key = rf_pixel_key( pass, (uint32_t)lane ), lens = rf_pixel_key( pass ^ LENS_SALT, (uint32_t)lane );
    float u = rf_random( lens, 0 ), v = rf_random( lens, 1 ), time = rf_random( lens, 2 );
    RfEye sharp = rf_is_sharp( eye ) ? *eye : rf_sample_eye( eye, ( RfLensSample ){ u, v, time } );
    const float inverse[2] = { 1.0f / sharp.focal_x, 1.0f / sharp.focal };
    float x = rf_random( lens, 3 ) * (float)eye->width, y = rf_random( lens, 4 ) * (float)eye->height;
    int column = (int)rf_minf( x, (float)( eye->width - 1 ) ), row = (int)rf_minf( y, (float)( eye->height - 1 ) );
    RfVec3 o, d;
    rf_eye_ray( &sharp, inverse, column, row, rf_minf( x - (float)column, 0x1.fffffep-1f ),
                rf_minf( y - (float)row, 0x1.fffffep-1f ), &o, &d );
    RF_PUT3( w->rays.o, lane, o );
    RF_PUT3( w->rays.d, lane, d );
    RF_PUT3( w->rays.n, lane, d );
    RF_PUT3( w->rays.throughput, lane, rf_vec3( 1, 1, 1 ) );
    w->rays.pdf_solid_angle[lane] = RF_DELTA_PDF;
    w->rays.slot[lane] = lane;
    w->key_a[lane] = key.a;
    w->key_b[lane] = key.b;
    w->roulette_scale[lane] = 1.0f;
    return row * ROWS / eye->height * COLUMNS + column * COLUMNS / eye->width;
}

// Traces a batch. False: out of memory.
static bool trace_batch( const Pilot* p, const RfTracer* tracer, Batch* batch, Work* work )
{
    const RfRenderer* r = p->renderer;
    const RfRenderSettings* settings = &r->setup->settings;
    RfWavefront* w = &work->wavefront;
    RfPathSettings path = { .tracer = tracer,
                            .max_depth = settings->max_depth,
                            .light_samples = settings->light_samples,
                            .light_sampling = settings->light_sampling,
                            .guide = r->guide,
                            .notes = &work->notes };
    batch->samples = malloc( (size_t)batch->paths * RF_MOST_NOTED * sizeof *batch->samples );
    if ( batch->samples == NULL )
        return false;
    w->rays.count = batch->paths;
    for ( int lane = 0; lane < batch->paths; ++lane )
        work->block[lane] = make_ray( p, batch, lane, w );
    rf_clear_guide_notes( batch->paths, &work->notes );
    rf_clear_ray_counts( w );
    rf_clear_arrivals( batch->paths, &w->arrivals );
    rf_trace_tails( &path, w, 1 );
    batch->sample_count = rf_list_guide_samples( w, &work->notes, batch->paths, batch->samples );
    RfGuideSample* fitting = realloc( batch->samples, ( (size_t)batch->sample_count + 1 ) * sizeof *fitting );
    batch->samples = fitting != NULL ? fitting : batch->samples;
    batch->rays = (double)w->path_rays + (double)w->shadow_rays;
    for ( int lane = 0; lane < batch->paths; ++lane )
    {
        double light = fmin( (double)rf_maxf( rf_luminance( RF_GET3( w->arrivals.rest, lane ) ), 0.0f ), MOST_LIGHT );
        Block* block = batch->blocks + work->block[lane];
        block->count += 1.0;
        block->sum += light;
        block->squares += light * light;
    }
    return true;
}

// Traces batches of one tracer, in parallel.
static bool trace_batches( const Pilot* p, const RfTracer* tracer, Batch* batches, int count )
{
    bool fits = true;
#pragma omp parallel num_threads( p->renderer->setup->settings.threads )
    {
        rf_set_float_mode();
        Work* work = aligned_alloc( 64, ( sizeof *work + 63 ) / 64 * 64 );
        bool mine = work != NULL;
        if ( mine )
            memset( &work->wavefront, 0, sizeof work->wavefront );
#pragma omp for schedule( dynamic, 1 )
        for ( int b = 0; b < count; ++b )
            mine = mine && trace_batch( p, tracer, batches + b, work );
        free( work );
#pragma omp critical
        fits = fits && mine;
    }
    return fits;
}

static bool keep( Pilot* p, const Batch* batch, Light* light )
{
    if ( p->sample_count + batch->sample_count > p->capacity )
    {
        int capacity = 2 * p->capacity + batch->sample_count;
        RfGuideSample* samples = realloc( p->samples, (size_t)capacity * sizeof *samples );
        if ( samples == NULL )
            return false;
        p->samples = samples;
        p->capacity = capacity;
    }
    if ( batch->sample_count > 0 )
        memcpy( p->samples + p->sample_count, batch->samples, (size_t)batch->sample_count * sizeof *batch->samples );
    p->sample_count += batch->sample_count;
    for ( int k = 0; k < BLOCKS; ++k )
    {
        Block* to = &light->blocks[k];
        to->count += batch->blocks[k].count;
        to->sum += batch->blocks[k].sum;
        to->squares += batch->blocks[k].squares;
    }
    light->paths += batch->paths;
    light->rays += batch->rays;
    return true;
}

// Traces so many paths of each frame. Those of still scenes share a tracer, and are traced together.
static RfResult trace_pass( Pilot* p, int paths, Light* light, RfError* error )
{
    RfRenderer* r = p->renderer;
    int of_frame = ( paths + AT_ONCE - 1 ) / AT_ONCE, count = of_frame * p->frames;
    Batch* batches = calloc( (size_t)count, sizeof *batches );
    bool fits = batches != NULL, moves = r->worlds.count > 0;
    for ( int b = 0; b < count && fits; ++b )
    {
        batches[b].frame = b / of_frame;
        batches[b].number = p->batches + b % of_frame;
        batches[b].paths = paths * ( b % of_frame + 1 ) / of_frame - paths * ( b % of_frame ) / of_frame;
    }
    for ( int k = 0; k < ( moves ? p->frames : 1 ) && fits && rf_check_worlds( &r->worlds, error ) == RF_OK; ++k )
    {
        const RfTracer* tracer = rf_frames_as_group( r, frame_of( p, k ), 1, (int)RF_GROUP_OF_GUIDE ).tracer;
        fits = trace_batches( p, tracer, batches + k * of_frame, moves ? of_frame : count );
    }
    for ( int b = 0; b < count && batches != NULL; ++b )
    {
        fits = fits && keep( p, batches + b, light );
        free( batches[b].samples );
    }
    free( batches );
    p->batches += of_frame;
    return fits ? rf_check_worlds( &r->worlds, error ) : fail_memory( error );
}

// The variance of paths in a block, relative to the squared brightness; −1: there are too few.
static double variance_of( const Pilot* p, const Light* light, int block )
{
    const Block *b = light->blocks + block, *unguided = p->unguided.blocks + block, *guided = p->guided.blocks + block;
    if ( b->count < 2.0 )
        return -1.0;
    double brightness = ( unguided->sum + guided->sum ) / ( unguided->count + guided->count );
    double variance = ( b->squares - b->sum * b->sum / b->count ) / ( b->count - 1.0 );
    return fmax( variance, 0.0 ) / ( brightness * brightness + DARK );
}

static bool varies( const Pilot* p )
{
    double sum = 0.0, blocks = 0.0;
    for ( int k = 0; k < BLOCKS; ++k )
    {
        double variance = variance_of( p, &p->unguided, k );
        sum += fmax( variance, 0.0 );
        blocks += variance >= 0.0;
    }
    return sum > LEAST_VARIANCE * blocks;
}

// By geometric means over blocks, in which a few rare paths count little.
static bool is_worth_it( const Pilot* p, double least )
{
    double all = 0.0, saved = 0.0, blocks = 0.0;
    for ( int k = 0; k < BLOCKS; ++k )
    {
        double unguided = variance_of( p, &p->unguided, k ), guided = variance_of( p, &p->guided, k );
        if ( !( unguided > 0.0 && guided > 0.0 ) )
            continue;
        all += log( unguided );
        saved += log( unguided / guided );
        blocks += 1.0;
    }
    if ( blocks == 0.0 || !( p->unguided.rays > 0.0 ) )
        return false;
    double rays = ( p->guided.rays / p->guided.paths ) / ( p->unguided.rays / p->unguided.paths );
    double unseen = sqrt( fmax( exp( all / blocks ) / KNOWN_VARIANCE, 1.0 ) );
    return unseen * exp( saved / blocks ) > least * GUIDED_COST * rays;
}

static void drop_guide( RfRenderer* r )
{
    rf_destroy_guide( r->learned );
    r->guide = r->learned = NULL;
}

static RfResult learn( Pilot* p, RfError* error )
{
    RfRenderer* r = p->renderer;
    drop_guide( r );
    r->guide = r->learned = rf_learn_guide( p->samples, p->sample_count );
    if ( r->guide == NULL )
        return fail_memory( error );
    if ( r->guide->table_count == 0 )
        drop_guide( r );
    return RF_OK;
}

static RfResult run_passes( Pilot* p, double paths, RfError* error )
{
    RfRenderer* r = p->renderer;
    RfResult result = RF_OK;
    bool chooses = r->setup->settings.guide == RF_GUIDE_AUTO;
    for ( int pass = 0; pass < PASSES && result == RF_OK; ++pass )
    {
        bool unguided = pass < UNGUIDED_PASSES;
        if ( !unguided )
            p->guided = ( Light ){ .paths = 0.0 }; // of the last pass alone
        result = trace_pass( p, (int)( paths * s_parts[pass] / PARTS / p->frames ), unguided ? &p->unguided : &p->guided, error );
        if ( result == RF_OK && pass == 0 && chooses && !varies( p ) )
            return RF_OK;
        if ( result == RF_OK && !unguided && chooses && !is_worth_it( p, pass == PASSES - 1 ? LEAST_WORTH : LEAST_PROMISE ) )
        {
            drop_guide( r );
            return RF_OK;
        }
        if ( result == RF_OK && pass >= UNGUIDED_PASSES - 1 )
            result = learn( p, error );
    }
    return result;
}

RfResult rf_find_guide( RfRenderer* r, RfError* error )
{
    const RfShot* shot = &r->setup->shot;
    const RfRenderSettings* s = &r->setup->settings;
    double all = (double)r->setup->sizes.width * (double)r->setup->sizes.height * shot->eye_count;
    double paths = fmin( PILOT_SHARE * all * ( r->setup->sizes.stopping ? USUAL_SPP : s->spp ), MOST_PATHS );
    bool few = s->guide == RF_GUIDE_AUTO && paths < LEAST_PATHS;
    if ( !s->estimator->guides || s->guide == RF_GUIDE_OFF || s->max_depth < 2 || rf_tracer_lights( shot->tracer )->count == 0 )
        return RF_OK;
    r->guide = s->learned;
    if ( r->guide != NULL || few )
        return RF_OK;
    paths = fmax( paths, LEAST_PATHS );
    Pilot* p = calloc( 1, sizeof *p );
    if ( p == NULL )
        return fail_memory( error );
    p->renderer = r;
    p->frames = shot->eye_count < PILOT_FRAMES ? shot->eye_count : PILOT_FRAMES;
    RfResult result = run_passes( p, paths, error );
    free( p->samples );
    free( p );
    return result;
}
