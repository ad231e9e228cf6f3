// How large a group and a tile pay: a few thousand paths along the camera's way, traced by the render's own estimator, tell how
// their light varies, how many cameras see their hits, and how many rays that takes; the gain follows by fixed costs of rays
// (src/reuse/estimators.md, E29).
#include "film/pixel_filter.h"
#include "reframe/plan.h"
#include "render/memory/memory.h"
#include "render/groups.h"
#include "render/settings.h"
#include "render/worlds.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Traces some batches of the path by the estimator, one at a time.
typedef struct Probe
{
    const RfEye* eyes;
    RfGroupPlan plan;          // of the largest groups looked at
    RfRenderSettings settings; // with a seed of its own
    RfArena arena;
    RfRenderSizes sizes; // for the largest group looked at
    void *compiled, *scratch, *batch, *tile_pilot;
    RfEstimatorGroup group;
    int jobs;
    int eye; // index in it of the frame that is traced
    RfWorlds worlds;
} Probe;

// The probe looks at so many frames, and pairs of batches of each; every second one is looked at from other frames.
#define PROBE_FRAMES 4
#define LEAST_JOBS 3
#define MOST_JOBS 16
#define SAMPLES_OF_JOB 2e5 // of the whole path: a pair in each frame for so many, a few per cent of their time
#define SEEN_EVERY 2

// What it counted: sums over own-frame samples.
typedef struct Counts
{
    double samples;
    RfRayCounts rays;  // without reuse between frames
    RfTileCount tiles; // in pairs of batches
    double counted;    // samples of those batches whose hits are looked at, and what they have
    double hits, glossy;
    // by row
    double share[RF_PLAN_ROWS]; // Σ w: share of each hit's weight that its own frame keeps
    double eye_rays[RF_PLAN_ROWS];
} Counts;

// The largest tile that is looked at: paths in it tell of smaller ones.
static const RfTile s_largest_tile = { RF_TILE_BLOCK, 8, 8 };

#define PROBE_SEED 1 // whatever that of the render: the choice of the group is not to depend on it

static void compile_group( Probe* p )
{
    p->group.compiled = p->compiled;
    if ( p->compiled != NULL )
        p->settings.estimator->compile( &p->group, p->compiled );
}

static RfResult alloc_probe( Probe* p, RfError* error )
{
    const RfEstimator* estimator = p->settings.estimator;
    RfResult result = rf_arena_alloc( &p->arena, "group", p->sizes.of_estimator.compiled, &p->compiled, error );
    compile_group( p );
    if ( result == RF_OK )
        result = rf_arena_alloc( &p->arena, "scratch", p->sizes.of_estimator.trace_scratch, &p->scratch, error );
    if ( result != RF_OK )
        return result;
    estimator->lay_out_scratch( &p->group, p->scratch );
    result = rf_arena_alloc( &p->arena, "hit records", p->sizes.of_estimator.batch, &p->batch, error );
    if ( result == RF_OK )
        estimator->lay_out_batch( &p->group, p->batch );
    if ( result == RF_OK ) // without room for it nothing is compared
        rf_arena_alloc( &p->arena, "tile pilot", p->sizes.of_estimator.tile_pilot, &p->tile_pilot, NULL );
    return result;
}

// For groups of up to `most_eyes`. Fails with RF_ERROR_MEMORY.
static RfResult begin_probe( const RfShot* shot, const RfRenderSettings* settings, int most_eyes, Probe* probe, RfError* error )
{
    const RfScene* scene = rf_tracer_scene( shot->tracer );
    const RfEye* eyes = shot->eyes;
    int eye_count = shot->eye_count;
    RfGroupPlan plan = rf_plan_shots( eyes, eye_count, most_eyes / 2, settings->spp );
    *probe = ( Probe ){ .eyes = eyes, .plan = plan, .settings = *settings };
    double samples = (double)eyes->width * eyes->height * eye_count * settings->spp;
    probe->jobs = (int)fmax( fmin( samples / SAMPLES_OF_JOB, MOST_JOBS ), LEAST_JOBS );
    probe->settings.seed = PROBE_SEED;
    probe->arena = rf_create_arena( settings->memory );
    probe->sizes = rf_render_sizes( scene, eyes, &plan, 1, settings );
    probe->group =
        rf_size_group( scene, rf_scene_traits( scene, eyes, eye_count, &probe->settings ), eyes, plan.eyes, &probe->settings );
    probe->group.tracer = shot->tracer;
    probe->group.probe = plan.eyes > 1;
    probe->group.max_depth = rf_tracer_lights( shot->tracer )->count > 0 ? settings->max_depth : 1;
    RfResult result =
        rf_create_worlds( shot, rf_worlds_held( scene, eye_count, plan.eyes, false, false ), false, &probe->worlds, error );
    return result == RF_OK ? alloc_probe( probe, error ) : result;
}

static void end_probe( Probe* p )
{
    rf_destroy_worlds( &p->worlds );
    rf_arena_free( &p->arena, "group", p->compiled, p->sizes.of_estimator.compiled );
    rf_arena_free( &p->arena, "scratch", p->scratch, p->sizes.of_estimator.trace_scratch );
    rf_arena_free( &p->arena, "hit records", p->batch, p->sizes.of_estimator.batch );
    rf_arena_free( &p->arena, "tile pilot", p->tile_pilot, p->sizes.of_estimator.tile_pilot );
    p->scratch = NULL;
    p->batch = NULL;
}

// Sets the probe's group to `eyes` frames around `frame`, as far as its shot goes.
static void aim_probe( Probe* p, int frame, int eyes )
{
    int first;
    rf_frames_around( &p->plan, frame, &first, &eyes );
    p->group.eyes = p->eyes + first;
    p->group.first_frame = first;
    p->group.eye_count = eyes;
    p->eye = frame - first;
    compile_group( p );
    p->group.tracers = rf_open_worlds( &p->worlds, first, eyes );
    p->group.tracer = p->group.tracers != NULL && eyes == 1 ? *p->group.tracers : p->worlds.still;
}

static int probe_frame( const Probe* p, int i )
{
    return (int)( (int64_t)( 2 * i + 1 ) * p->plan.frames / ( 2 * PROBE_FRAMES ) );
}

// The batch of the k-th position there: spread over the film, other places in every frame.
static int probe_job( const Probe* p, int i, int k )
{
    int64_t place = PROBE_FRAMES * k + i, places = PROBE_FRAMES * p->jobs;
    return (int)( ( 2 * place + 1 ) * p->sizes.of_estimator.jobs / ( 2 * places ) );
}

// Which light holds in all frames is a matter of the group.
static void look_again( Probe* p, int job, int pass )
{
    RfRayCounts rays = { 0 };
    if ( p->group.tracers == NULL )
        return;
    p->group.first_hits_only = true;
    p->settings.estimator->trace( &p->group, ( RfTraceJob ){ p->eye, job, pass }, p->batch, p->scratch, &rays );
    p->group.first_hits_only = false;
}

static void count_row( Probe* p, int frame, int job, int pass, int row, int eyes, Counts* c )
{
    RfReuseCount count = { 0 };
    if ( p->settings.estimator->count_reuse == NULL )
        return;
    aim_probe( p, frame, eyes );
    look_again( p, job, pass );
    p->settings.estimator->count_reuse( &p->group, p->eye, p->batch, p->scratch, &count );
    c->hits += row == 0 ? count.hits : 0.0;
    c->glossy += row == 0 ? count.glossy : 0.0;
    c->share[row] += count.own_share;
    c->eye_rays[row] += count.eye_rays;
}

// Traces a batch of a frame for itself alone, and another of the same pixels before it, whose numbers are independent: of the other
// half of the passes.
static void trace_pair( Probe* p, int frame, RfTraceJob job, bool seen, Counts* c )
{
    const RfEstimator* estimator = p->settings.estimator;
    bool pair = estimator->count_tiles != NULL && p->tile_pilot != NULL;
    aim_probe( p, frame, 1 );
    for ( int k = pair ? 1 : 0; k >= 0; --k )
    {
        RfTraceJob of_pair = { job.eye, job.job, job.pass + k };
        int samples = estimator->trace( &p->group, of_pair, p->batch, p->scratch, &c->rays );
        c->samples += samples;
        c->counted += k == 0 && seen ? samples : 0;
        if ( pair )
            estimator->count_tiles( &p->group, p->batch, p->scratch, p->tile_pilot, k == 0 ? &c->tiles : NULL );
    }
}

// The i-th of the frames looked at, in batches that are a pass of their own each: small films have fewer patches.
static void count_frame( Probe* p, int i, const int* eyes, int rows, Counts* c )
{
    int frame = probe_frame( p, i );
    bool moves = p->worlds.count > 0; // then batches are traced again for each row, whose swept geometry is made once
    for ( int k = 0; k < p->jobs; ++k )
    {
        RfTraceJob job = { 0, probe_job( p, i, k ), 2 * k };
        bool seen = k % SEEN_EVERY == 0;
        trace_pair( p, frame, job, seen, c );
        for ( int r = 0; r < rows && seen && !moves; ++r )
            count_row( p, frame, job.job, job.pass, r, eyes[r], c );
    }
    for ( int r = 0; r < rows && moves; ++r )
    {
        for ( int k = 0; k < p->jobs; k += SEEN_EVERY )
            count_row( p, frame, probe_job( p, i, k ), 2 * k, r, eyes[r], c );
    }
}

// Counts for groups of eyes[0 … rows), the first of which is 1.
static void count_plan( Probe* probe, const int* eyes, int rows, Counts* counts )
{
    *counts = ( Counts ){ 0 };
    rf_set_float_mode();
    for ( int i = 0; i < PROBE_FRAMES; ++i )
        count_frame( probe, i, eyes, rows, counts );
    if ( counts->counted == 0.0 ) // all beside a film that is smaller than a tile
        counts->samples = counts->counted = 1.0;
}

static const int s_groups[RF_PLAN_ROWS] = { 0, 1, 2, 3, 4, 6, 8, 12, 16 };

// Relative costs of rays, which the choice of the group rests on: about nanoseconds on one core of
// a 2.5 GHz Xeon with AVX2.
#define COST_PRIMARY 100.0 // including records and films
#define COST_PATH 200.0
#define COST_SHADOW 100.0
#define COST_TILE 40.0
#define COST_PAIR 21.0     // a path of another pixel of the tile, beside the ray to it
#define COST_TILES 150.0   // a path, where there are tiles at all
#define COST_EYE 30.0      // a visibility test
#define COST_ADD 4.0       // adding a hit to a film, plus
#define COST_SPREAD 2.5    // this for each pixel more that the filter has, and
#define COST_DIRECTION 7.0 // this for each direction of a glossy hit

// Why the automatic choice leaves a row out.
static const char s_no_room[] = "does not fit in memory", s_films[] = "films take over half of the memory",
                  s_sweeps[] = "needs several sweeps", s_rounded[] = "samples rounded up too far";

#define FLAT 0.95       // of the best gain is good enough: smaller groups need less memory, and less time for a single frame
#define FEW 16          // samples of a size, at least, for their squares to count as they are
#define LEAST_REST 0.02 // of the variance that paths bring without tiles is assumed to be beside it
#define ROUNDING 1.25   // rounding up may trace so many times the samples asked for

static void list_rows( const RfShot* shot, const RfRenderSettings* settings, const int* half_widths, int count, RfPlan* plan )
{
    int spp = settings->spp, longest = rf_longest_shot( shot->eyes, shot->eye_count );
    for ( int i = 0; i < count; ++i )
    {
        RfGroupPlan groups = rf_plan_samples( shot, half_widths[i], spp );
        plan->rows[plan->count++] = ( RfPlanRow ){ .group = groups.eyes / 2,
                                                   .eyes = groups.eyes,
                                                   .spp = groups.spp,
                                                   .samples = NAN,
                                                   .rays_primary = NAN,
                                                   .rays_path = NAN,
                                                   .rays_shadow = NAN,
                                                   .rays_tile = NAN,
                                                   .rays_eye = NAN,
                                                   .reach = NAN,
                                                   .error = NAN,
                                                   .reuse = NAN,
                                                   .gain = NAN };
        if ( groups.eyes == longest || !rf_has_groups( settings->estimator ) )
            break;
    }
}

// The tiles that a choice is among: the one asked for, or those of rf_tile_sides.
typedef struct Tiles
{
    int count;
    RfTile traced; // by the probe
    RfTile tile[RF_TILE_CHOICES];
} Tiles;

// Of a sample, relative: what RfTileCount comes to.
typedef struct Variances
{
    double own, shared, light_sample;
    double paths[RF_TILE_CHOICES];
} Variances;

typedef struct Choice
{
    const RfShot* shot;
    RfRenderSettings settings; // resolved but for group and tile
    Tiles tiles;
    RfPixelFilter filter;
    Variances variances;
    int light_samples; // asked for
    int directions;    // of a glossy hit's record, in the tile traced
} Choice;

static Tiles find_tiles( bool chosen, const RfRenderSettings* resolved )
{
    Tiles tiles = { 1, resolved->tile, { resolved->tile } };
    if ( !chosen )
        return tiles;
    tiles.traced = s_largest_tile;
    tiles.count = RF_TILE_CHOICES;
    for ( int i = 0; i < RF_TILE_CHOICES; ++i )
        tiles.tile[i] = ( RfTile ){ i == 0 ? RF_TILE_NONE : RF_TILE_BLOCK, rf_tile_sides[i], rf_tile_sides[i] };
    return tiles;
}

static int pixels_of( const RfTile* tile )
{
    return tile->kind == RF_TILE_NONE ? 1 : tile->kind == RF_TILE_BLOCK ? tile->width * tile->height : tile->width;
}

// Other pixels that share a tile with a pixel of the film, on average: tiles begin anywhere, and end at its border.
static double neighbours_of( const RfTile* tile, const RfEye* eye )
{
    const int sides[2] = { tile->width, tile->height }, sizes[2] = { eye->width, eye->height };
    double pixels = 1.0;
    if ( tile->kind != RF_TILE_BLOCK )
        return pixels_of( tile ) - 1;
    for ( int axis = 0; axis < 2; ++axis )
    {
        double squares = 0.0;
        for ( int shift = 0; shift < sides[axis]; ++shift )
        {
            for ( int begin = -shift; begin < sizes[axis]; begin += sides[axis] )
            {
                double length = fmin( begin + sides[axis], sizes[axis] ) - fmax( begin, 0 );
                squares += length * length;
            }
        }
        pixels *= squares / ( (double)sides[axis] * sizes[axis] );
    }
    return pixels - 1.0;
}

// A sample without reuse between frames: the rays that it takes, and its relative variance, of light that no other frame has and of
// the rest.
typedef struct Sample
{
    double primary, path, shadow, tile, pairs;
    double hits, adding; // of camera rays; the cost of adding those to a film
    double own, shared;
} Sample;

// The last octave that FEW reach: what is above counts as that.
static int highest_octave( const double* counts )
{
    int octave = RF_TILE_OCTAVES - 1;
    for ( double sum = counts[octave]; octave > 0 && sum < FEW; sum += counts[octave] )
        octave -= 1;
    return octave;
}

// Where nothing was compared, all light is shared and as noisy.
static Variances find_variances( const RfTileCount* c )
{
    Variances v = { .shared = c->pixels > 0.0 ? 0.0 : 1.0 };
    double pixels[RF_TILE_OCTAVES], paths[RF_TILE_OCTAVES];
    for ( int k = 0; k < RF_TILE_OCTAVES; ++k )
    {
        pixels[k] = c->pairs[k].pixels;
        paths[k] = c->paths[k].paths;
    }
    int high_pixel = highest_octave( pixels ), high_path = highest_octave( paths );
    for ( int k = 0; k < RF_TILE_OCTAVES && c->pixels > 0.0; ++k )
    {
        double of_pixels = ldexp( 1.0 / c->pixels, k > high_pixel ? high_pixel - k : 0 ),
               of_paths = ldexp( 1.0 / c->pixels, k > high_path ? high_path - k : 0 );
        v.own += of_pixels * c->pairs[k].own;
        v.shared += of_pixels * c->pairs[k].shared;
        for ( int t = 0; t < RF_TILE_CHOICES; ++t )
            v.paths[t] += of_paths * c->paths[k].moment[t];
    }
    v.light_sample = c->pixels > 0.0 ? c->light_sample / c->pixels : 0.0;
    return v;
}

// What the pixel filter leaves of the variance of a sample per pixel, where those within `side` pixels have the same error. In every
// pass tiles begin elsewhere, so pixels at a distance d share one with the probability 1 − d / side, in both directions.
static double noise_left( const Choice* choice, int side )
{
    const RfPixelFilter* filter = &choice->filter;
    double mean[RF_FILTER_TAPS] = { 0.0 }, left = 0.0;
    if ( rf_is_plain_filter( &choice->settings ) )
        return 1.0;
    for ( int step = 0; step < RF_FILTER_STEPS; ++step )
    {
        for ( int k = 0; k < filter->taps; ++k )
        {
            double h = (double)filter->rows[step * filter->taps + k];
            mean[k] += h / RF_FILTER_STEPS;
            left += h * h / RF_FILTER_STEPS;
        }
    }
    for ( int k = 0; k < filter->taps; ++k )
    {
        for ( int l = 0; l < filter->taps; ++l )
            left += k != l ? mean[k] * mean[l] * fmax( 1.0 - (double)abs( k - l ) / side, 0.0 ) : 0.0;
    }
    return left * left;
}

// Of the i-th tile.
static Sample sample_of( const Choice* choice, int i, const Counts* c )
{
    const Tiles* tiles = &choice->tiles;
    Sample s = { .primary = (double)c->rays.primary / c->samples,
                 .path = (double)c->rays.path / c->samples,
                 .shadow = (double)c->rays.shadow / c->samples,
                 .tile = (double)c->rays.tile / c->samples,
                 .hits = c->hits / c->counted,
                 .shared = 1.0 };
    int traced = pixels_of( &tiles->traced ), own = pixels_of( &tiles->tile[i] ), directions = choice->directions - traced + own;
    const Variances* v = &choice->variances;
    s.pairs = neighbours_of( &tiles->tile[i], choice->shot->eyes );
    s.own = v->own;
    s.shared = v->shared;
    if ( tiles->count > 1 )
    {
        // what paths bring is as much as the tile leaves of it, and not averaged by the filter within the tile
        double rest = fmax( v->shared - v->paths[RF_TILE_CHOICES - 1], LEAST_REST * v->paths[0] );
        bool fewer = own == 1 && choice->light_samples == 1; // a light sample less at first hits without tiles
        directions -= fewer;
        double connected = c->tiles.connected[RF_TILE_CHOICES - 1];
        s.tile *= connected > 0.0 ? c->tiles.connected[i] / connected : 0.0;
        s.shadow -= fewer && s.hits > 0.0 ? s.shadow * s.hits / ( 2.0 * s.hits + s.path ) : 0.0;
        rest += fewer ? v->light_sample : 0.0;
        double alone = noise_left( choice, 1 );
        s.own *= alone;
        s.shared = alone * rest + noise_left( choice, rf_tile_sides[i] ) * v->paths[i];
    }
    s.adding = s.hits * ( COST_ADD + COST_SPREAD * ( rf_filter_pixels( &choice->settings ) - 1 ) ) +
               c->glossy / c->counted * COST_DIRECTION * directions;
    return s;
}

// Samples and rays of the frames asked for, over all sweeps.
static void count_rays( const RfGroupPlan* plan, const RfShot* shot, const Counts* counts, const Sample* sample, int index,
                        RfPlanRow* row )
{
    const int* frames = shot->frames;
    int frame_count = shot->frame_count;
    double pixels = (double)shot->eyes->width * shot->eyes->height;
    int per_sweep = row->fit.sweeps > 1 ? row->fit.films : frame_count;
    double samples = 0.0, others = 0.0;
    for ( int first = 0; first < frame_count; first += per_sweep )
        rf_add_group_samples( plan, frames, first, first + per_sweep < frame_count ? first + per_sweep : frame_count, &samples,
                              &others );
    double per = pixels / counts->counted;
    row->samples = samples * pixels;
    row->rays_primary = samples * pixels;
    row->rays_path = samples * pixels * sample->path;
    row->rays_shadow = samples * pixels * sample->shadow;
    row->rays_tile = samples * pixels * sample->tile;
    // visibility from the own camera is tested in blended scenes only, and counted there
    row->rays_eye =
        row->eyes > 1 ? others / ( row->eyes - 1 ) * per * counts->eye_rays[index] : samples * per * counts->eye_rays[index];
}

static double cost_of_sample( const Sample* s )
{
    double tiles = s->pairs > 0.0 ? COST_TILES + COST_PAIR * s->pairs + COST_TILE * s->tile : 0.0;
    return COST_PRIMARY * s->primary + COST_PATH * s->path + COST_SHADOW * s->shadow + tiles + s->adding;
}

// Relative error times cost of a pixel, which is to be small, where samples are reused in the frames of a row.
static double product_of( const RfGroupPlan* plan, const Sample* s, RfPlanRow* row, const Counts* c, int index )
{
    double own = cost_of_sample( s ), samples = (double)plan->frames * plan->spp;
    double reuse = row->eyes > 1 ? COST_EYE * c->eye_rays[index] / c->counted / ( row->eyes - 1 ) + s->adding : 0.0;
    row->error = s->own + s->shared / row->reach;
    row->reuse = reuse / own;
    return row->error * rf_plan_work( plan, own, reuse ) / samples;
}

static RfShot whole_path( const RfShot* shot )
{
    return ( RfShot ){ shot->tracer, shot->eyes, shot->eye_count, NULL, shot->eye_count };
}

// Why the automatic choice leaves a group out; NULL: it does not. It depends on path, size and settings
// alone, as if the whole path were asked for and one thread had all the memory. Several sweeps
// repeat the tracing, which the gain does not account for.
static const char* reason_against( const RfShot* shot, const RfRenderSettings* settings, const RfPlanRow* row )
{
    RfRenderSettings s = *settings;
    s.group = row->group;
    s.threads = 1;
    if ( s.adaptive == RF_ADAPTIVE_AUTO ) // what may be of use in some frames is no reason for smaller groups in all
        s.adaptive = RF_ADAPTIVE_OFF;
    RfGroupPlan plan = rf_plan_samples( shot, row->group, settings->spp );
    RfRenderSizes sizes = rf_render_sizes( rf_tracer_scene( shot->tracer ), shot->eyes, &plan, shot->eye_count, &s );
    RfMemoryFit fit;
    RfShot whole = whole_path( shot );
    if ( rf_fit_memory( &whole, &s, &fit, NULL ) != RF_OK )
        return s_no_room;
    if ( rf_films_bytes( &sizes ) > settings->memory / 2 )
        return s_films;
    if ( fit.sweeps > 1 )
        return s_sweeps;
    return (double)row->spp > ROUNDING * settings->spp ? s_rounded : NULL;
}

// The smallest group whose gain is as good as the best.
static void choose_row( RfPlan* plan )
{
    double best = 1.0;
    for ( int i = 0; i < plan->count; ++i )
        best = plan->rows[i].excluded == NULL && plan->rows[i].gain > best ? plan->rows[i].gain : best;
    while ( plan->rows[plan->chosen].excluded != NULL || plan->rows[plan->chosen].gain < FLAT * best )
        plan->chosen += 1;
    plan->rows[plan->chosen].chosen = true;
}

// A group that was chosen for the memory at hand goes without the memory of extra samples, which few frames may
// need, rather than through the path several times.
static RfResult settle_adaptive( const RfShot* shot, const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    RfShot whole = whole_path( shot );
    RfPlanRow* row = plan->rows + plan->chosen;
    RfRenderSettings s = *settings;
    RfMemoryFit fit;
    plan->adaptive = settings->adaptive == RF_ADAPTIVE_AUTO && row->eyes == 1 ? RF_ADAPTIVE_OFF : settings->adaptive;
    s.group = row->group;
    s.threads = 1;
    if ( plan->adaptive != RF_ADAPTIVE_AUTO || ( rf_fit_memory( &whole, &s, &fit, NULL ) == RF_OK && fit.sweeps == 1 ) )
        return RF_OK;
    plan->adaptive = s.adaptive = RF_ADAPTIVE_OFF;
    s.threads = settings->threads;
    return rf_fit_memory( shot, &s, &row->fit, error );
}

static int rows_against( const RfPlan* plan, const char* reason )
{
    int count = 0;
    for ( int i = 0; i < plan->count; ++i )
        count += plan->rows[i].excluded == reason;
    return count;
}

// `tiles`: they are chosen as well.
static void explain( RfPlan* plan, const RfRenderSettings* settings, bool tiles )
{
    char rounded[96];
    snprintf( rounded, sizeof rounded, "%d sample%s would be rounded up by more than a quarter", settings->spp,
              settings->spp == 1 ? "" : "s" );
    const char* const reasons[][3] = { { s_films, s_films, s_films },
                                       { s_sweeps, s_sweeps, "need several sweeps" },
                                       { s_rounded, rounded, rounded },
                                       { s_no_room, s_no_room, "do not fit in memory" } };
    const RfPlanRow* best = plan->rows + plan->chosen;
    for ( int i = 0; i < plan->count; ++i )
        best = plan->rows[i].excluded == NULL && plan->rows[i].gain > best->gain ? plan->rows + i : best;
    size_t size = sizeof plan->why;
    if ( !rf_has_groups( settings->estimator ) )
    {
        snprintf( plan->why, size, "the estimator '%s' reuses no frames", settings->estimator->name );
        return;
    }
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &best->tile, tile );
    size_t used = (size_t)snprintf( plan->why, size,
                                    "the smallest group within 5 %% of the best gain at fixed ray costs, %.1f with group %d",
                                    best->gain, best->group );
    if ( tiles && used < size )
        used += (size_t)snprintf( plan->why + used, size - used, " and tile %s", tile );
    for ( size_t k = 0; k < sizeof reasons / sizeof reasons[0] && used < size; ++k )
    {
        int rows = rows_against( plan, reasons[k][0] );
        if ( rows > 0 )
            used += (size_t)snprintf( plan->why + used, size - used, "; %d row%s excluded: %s", rows, rows == 1 ? "" : "s",
                                      reasons[k][rows == 1 ? 1 : 2] );
    }
    if ( plan->adaptive != settings->adaptive && plan->rows[plan->chosen].eyes > 1 && used < size )
        snprintf( plan->why + used, size - used, "; without extra samples, which do not fit in memory" );
}

static RfResult count( const RfShot* shot, const RfRenderSettings* settings, const RfPlan* plan, Counts* counts, RfError* error )
{
    Probe probe;
    int group_eyes[RF_PLAN_ROWS], most = 1;
    for ( int i = 0; i < plan->count; ++i )
    {
        // rows that do not fit have no room for their records here
        group_eyes[i] = rf_plan_row_fits( plan->rows + i ) ? plan->rows[i].eyes : 1;
        most = group_eyes[i] > most ? group_eyes[i] : most;
    }
    RfResult result = begin_probe( shot, settings, most, &probe, error );
    if ( result == RF_OK )
    {
        count_plan( &probe, group_eyes, plan->count, counts );
        result = rf_check_worlds( &probe.worlds, error );
    }
    end_probe( &probe );
    return result;
}

// Only the smallest group has to fit.
static RfResult fit_row( const Choice* choice, int i, RfPlanRow* row, RfError* error )
{
    RfRenderSettings s = choice->settings;
    s.group = row->group;
    s.tile = row->tile;
    RfResult result = rf_fit_memory( choice->shot, &s, &row->fit, error );
    if ( result != RF_OK && i == 0 )
        return result;
    row->excluded = i == 0 ? NULL : result != RF_OK ? s_no_room : reason_against( choice->shot, &s, row );
    return RF_OK;
}

static RfResult fit_rows( const Choice* choice, RfPlan* plan, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < plan->count && result == RF_OK; ++i )
        result = fit_row( choice, i, plan->rows + i, error );
    return result;
}

// The product of a row with the i-th tile; INFINITY where that does not fit.
static double try_tile( const Choice* choice, int index, int tile, const Counts* counts, RfPlanRow* row )
{
    RfPlanRow tried = *row;
    tried.tile = choice->tiles.tile[tile];
    if ( choice->tiles.count > 1 && ( fit_row( choice, index, &tried, NULL ) != RF_OK || !rf_plan_row_fits( &tried ) ||
                                      ( tried.excluded != NULL && row->excluded == NULL ) ) )
        return INFINITY;
    Sample sample = sample_of( choice, tile, counts );
    RfGroupPlan groups = rf_plan_samples( choice->shot, row->group, choice->settings.spp );
    double product = product_of( &groups, &sample, &tried, counts, index );
    count_rays( &groups, choice->shot, counts, &sample, index, &tried );
    *row = tried;
    return product;
}

// Finds the tile of each row and its gain: over path tracing where tiles are chosen, else over the tile alone.
static void weigh_rows( const Choice* choice, const Counts* counts, RfPlan* plan )
{
    double first = 1.0;
    for ( int i = 0; i < plan->count; ++i )
    {
        RfPlanRow* row = plan->rows + i;
        if ( !rf_plan_row_fits( row ) )
            continue;
        row->reach = counts->share[i] > 0.0 ? counts->hits / counts->share[i] : 1.0;
        RfPlanRow best = *row;
        double least = INFINITY;
        for ( int t = 0; t < choice->tiles.count; ++t )
        {
            RfPlanRow tried = *row;
            double product = try_tile( choice, i, t, counts, &tried );
            first = i == 0 && t == 0 && product > 0.0 ? product : first;
            if ( product < least )
            {
                least = product;
                best = tried;
            }
        }
        best.gain = least > 0.0 ? first / least : 1.0;
        *row = best;
    }
}

// Rows that fit, and what the probe counts for them.
static RfResult find_rows( Choice* choice, bool chosen, RfPlan* plan, Counts* counts, RfError* error )
{
    RfRenderSettings settings = choice->settings;
    choice->tiles = find_tiles( chosen, &settings );
    settings.tile = choice->tiles.traced;
    for ( int i = 0; i < plan->count; ++i )
        plan->rows[i].tile = choice->tiles.tile[0];
    RfResult result = fit_rows( choice, plan, error );
    if ( result == RF_OK )
        result = count( choice->shot, &settings, plan, counts, error );
    RfGroupPlan groups = rf_plan_shots( choice->shot->eyes, choice->shot->eye_count, 0, settings.spp );
    choice->directions = rf_render_sizes( rf_tracer_scene( choice->shot->tracer ), choice->shot->eyes, &groups, 1, &settings )
                             .of_estimator.directions;
    return result;
}

static RfResult plan_groups( const RfShot* shot, const RfRenderSettings* settings, const int* half_widths, int count,
                             RfPlan* plan, RfError* error )
{
    Choice choice = { .shot = shot, .light_samples = settings->light_samples };
    RfRenderSettings* common = &choice.settings;
    Counts counts;
    *plan = ( RfPlan ){ .count = 0 };
    RfResult result = rf_resolve_common( shot, settings, common, error );
    if ( result != RF_OK )
        return result;
    if ( !rf_is_plain_filter( common ) )
        rf_make_pixel_filter( common, &choice.filter );
    bool chosen = settings->tile.kind == RF_TILE_AUTO && common->estimator->count_tiles != NULL;
    list_rows( shot, common, half_widths, count, plan );
    result = find_rows( &choice, chosen, plan, &counts, error );
    for ( int k = 0; k < 2 && chosen && result == RF_ERROR_MEMORY; ++k ) // no room to look at large tiles: its own, or none
    {
        common->tile = k == 0 ? common->estimator->tile : ( RfTile ){ RF_TILE_NONE, 1, 1 };
        result = find_rows( &choice, false, plan, &counts, error );
    }
    if ( result != RF_OK )
        return result;
    choice.variances = find_variances( &counts.tiles );
    weigh_rows( &choice, &counts, plan );
    plan->hit_share = counts.hits / counts.counted;
    plan->glossy_share = counts.glossy / counts.counted;
    choose_row( plan );
    RfPlanRow* row = plan->rows + plan->chosen;
    common->tile = row->tile;
    result = settle_adaptive( shot, common, plan, error );
    if ( result != RF_OK )
        return result;
    explain( plan, common, chosen );
    rf_record_bytes( rf_tracer_scene( shot->tracer ), common, row->eyes, &plan->bytes_diffuse, &plan->bytes_glossy );
    return RF_OK;
}

RfResult rf_plan_render( const RfShot* shot, const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    return plan_groups( shot, settings, s_groups, RF_PLAN_ROWS, plan, error );
}

RfResult rf_plan_group( const RfShot* shot, const RfRenderSettings* settings, int group, RfPlan* plan, RfError* error )
{
    return plan_groups( shot, settings, ( int[] ){ 0, group }, group > 0 ? 2 : 1, plan, error );
}
void rf_record_bytes( const RfScene* scene, const RfRenderSettings* settings, int eyes, size_t* diffuse, size_t* glossy )
{
    RfEye eye = { .width = 1, .height = 1 };
    RfEstimatorGroup group = rf_size_group( scene, rf_scene_traits( scene, &eye, 1, settings ), &eye, eyes, settings );
    RfEstimatorSizes sizes = settings->estimator->sizes( &group );
    *diffuse = sizes.diffuse_record;
    *glossy = sizes.glossy_record;
}
