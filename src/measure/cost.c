#include "measure/cost.h"

#include "base/random.h"
#include "base/system.h"
#include "render/groups.h"
#include "reuse/tile.h"

#include <math.h>
#include <string.h>

#define FIRST_PASSES 2
#define WANTED_LEVELS 4  // levels that the budget is planned for
#define MIN_PIXELS 20000 // of a test image: in smaller ones set-up dominates and tiles are too large
#define PROBE_PIXELS 6000
#define UNITS ( RF_COST_LEVELS * RF_COST_POSITIONS )

typedef struct Study
{
    const RfCostJob* job;
    RfCost* cost;
    RfRenderSettings settings[2]; // resolved
    RfTestRegion regions[RF_COST_POSITIONS];
    int region_count;
    RfTrial trials[UNITS][2]; // per position and level: path tracing and reuse, with different seeds
    RfCostUnit units[UNITS];  // the measurements of these trials
    int unit_count;
    double start;
} Study;

static int scaled( int side, double scale )
{
    int pixels = (int)floor( side * scale + 0.5 );
    return pixels < 1 ? 1 : pixels;
}

// The size of an image of at most `pixels` pixels, not larger than the render's.
static void choose_size( const RfEye* eye, double pixels, int* width, int* height )
{
    double scale = sqrt( pixels / ( (double)eye->width * eye->height ) );
    *width = scale < 1.0 ? scaled( eye->width, scale ) : eye->width;
    *height = scale < 1.0 ? scaled( eye->height, scale ) : eye->height;
}

static RfResult make_region( Study* s, double position, int width, int height, RfTestRegion* region, RfError* error )
{
    const RfCostJob* job = s->job;
    int frame = job->frames[(int)( position * job->frame_count )];
    return rf_create_test_region( job->tracer, job->eyes, job->eye_count, frame, 2 * s->settings[1].group + 1, width, height,
                                  s->settings + 1, job->watch, region, error );
}

// Renders all frames of the region by path tracing, and as one group with reuse.
static RfResult try_both( Study* s, const RfTestRegion* region, int passes, uint64_t salt, RfTrial trials[2], RfError* error )
{
    RfResult result = RF_OK;
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
    {
        RfRenderSettings settings = s->settings[k];
        settings.seed = rf_mix64( settings.seed ^ rf_mix64( salt ) );
        result = rf_run_trial( s->job->tracer, region, k == 0 ? region->frames : 1, passes, &settings, s->job->watch, trials + k,
                               error );
    }
    return result;
}

// Estimates the seconds per pixel of a position at the first level, from a small image.
static RfResult probe( Study* s, double* pixel_seconds, RfError* error )
{
    int width, height;
    choose_size( s->job->eyes, PROBE_PIXELS, &width, &height );
    double start = rf_wall_seconds();
    RfTestRegion region;
    RfTrial trials[2];
    RfResult result = make_region( s, 0.5, width, height, &region, error );
    if ( result == RF_OK )
        result = try_both( s, &region, FIRST_PASSES, 0x9b0be, trials, error );
    rf_destroy_test_region( &region );
    *pixel_seconds = ( rf_wall_seconds() - start ) / ( (double)width * height );
    return result;
}

// Creates test regions with images so large that the budget allows WANTED_LEVELS levels, each
// taking twice as long as the one before.
static RfResult make_regions( Study* s, RfError* error )
{
    double pixel_seconds;
    RfResult result = probe( s, &pixel_seconds, error );
    s->cost->positions = s->job->frame_count < RF_COST_POSITIONS ? s->job->frame_count : RF_COST_POSITIONS;
    double left = s->job->budget - ( rf_wall_seconds() - s->start );
    double pixels = left / ( ( 1 << WANTED_LEVELS ) * pixel_seconds * s->cost->positions );
    choose_size( s->job->eyes, pixels > MIN_PIXELS ? pixels : MIN_PIXELS, &s->cost->width, &s->cost->height );
    for ( int i = 0; i < s->cost->positions && result == RF_OK; ++i )
    {
        s->region_count = i + 1;
        result = make_region( s, ( i + 0.5 ) / s->cost->positions, s->cost->width, s->cost->height, s->regions + i, error );
    }
    return result;
}

static double frame_pixels( const RfCostJob* job ) { return (double)job->eyes->width * job->eyes->height; }

static double frame_seconds( const RfCostJob* job, const RfCostCurve* c, double spp, double sample_seconds )
{
    return frame_pixels( job ) * spp * sample_seconds + c->finish_seconds;
}

// Adds the row of a level: the mean over its positions.
static void add_row( Study* s, int curve, RfCostCurve* c, int passes )
{
    double relmse = 0.0, wall = 0.0, cpu = 0.0, samples = 0.0;
    for ( int i = s->unit_count - s->cost->positions; i < s->unit_count; ++i )
    {
        const RfCostPart* part = s->units[i].parts + curve;
        relmse += part->relmse / passes / s->cost->positions;
        wall += part->wall_seconds;
        cpu += part->cpu_seconds;
        samples += part->samples;
    }
    c->rows[c->count++] = ( RfCostRow ){ .spp = passes,
                                         .seconds = frame_seconds( s->job, c, passes, wall / samples ),
                                         .cpu_seconds = frame_seconds( s->job, c, passes, cpu / samples ),
                                         .relmse = relmse };
}

// Takes the time for finishing a frame from the first level.
static void fit_finish_time( Study* s, int curve, RfCostCurve* c )
{
    double seconds = 0.0, pixels = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        seconds += s->trials[i][curve].finish_seconds;
        pixels += s->trials[i][curve].finish_pixels;
    }
    c->finish_seconds = pixels > 0.0 ? fmax( seconds, 0.0 ) / pixels * frame_pixels( s->job ) : 0.0;
}

static RfCostPart part_of( const RfTrial* trial )
{
    return ( RfCostPart ){ .relmse = trial->relmse / trial->weight,
                           .wall_seconds = trial->wall_seconds,
                           .cpu_seconds = trial->cpu_seconds,
                           .samples = trial->timed_samples };
}

static RfResult run_level( Study* s, int level, RfError* error )
{
    int passes = FIRST_PASSES << level;
    if ( s->job->report != NULL )
        s->job->report( s->job->user, s->cost, passes );
    for ( int i = 0; i < s->cost->positions; ++i )
    {
        RfTrial* trials = s->trials[s->unit_count];
        RfResult result = try_both( s, s->regions + i, passes, (uint64_t)( level * RF_COST_POSITIONS + i + 1 ), trials, error );
        if ( result != RF_OK )
        {
            s->unit_count = level * s->cost->positions; // completed levels only
            return result;
        }
        s->units[s->unit_count++] = ( RfCostUnit ){ passes, { part_of( trials ), part_of( trials + 1 ) } };
    }
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        if ( level == 0 )
            fit_finish_time( s, k, curves[k] );
        add_row( s, k, curves[k], passes );
    }
    return RF_OK;
}

// Runs levels as long as one that takes twice as long as the last still fits the budget.
static RfResult run_levels( Study* s, RfError* error )
{
    double last = 0.0;
    for ( int level = 0; level < RF_COST_LEVELS; ++level )
    {
        double begin = rf_wall_seconds();
        if ( level > 0 && begin - s->start + 2.0 * last > s->job->budget )
            break;
        RfResult result = run_level( s, level, error );
        if ( result != RF_OK )
            return result;
        last = rf_wall_seconds() - begin;
    }
    return RF_OK;
}

static RfInterval slope_of( const RfCostCurve* c )
{
    double seconds[RF_COST_LEVELS], errors[RF_COST_LEVELS];
    for ( int i = 0; i < c->count; ++i )
    {
        seconds[i] = c->rows[i].seconds;
        errors[i] = c->rows[i].relmse;
    }
    return rf_fit_slope( seconds, errors, c->count );
}

static void fit_curves( Study* s )
{
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        RfCostPart sum = rf_sum_cost_units( s->units, s->unit_count, k, -1 );
        curves[k]->slope = slope_of( curves[k] );
        curves[k]->relmse = sum.relmse;
        curves[k]->sample_seconds = sum.wall_seconds;
    }
    s->cost->speedup = rf_cost_speedup( s->units, s->unit_count );
    s->cost->seconds = rf_wall_seconds() - s->start;
}

static RfResult resolve_settings( Study* s, RfError* error )
{
    const RfCostJob* job = s->job;
    RfRenderSettings asked = *job->settings;
    asked.noise = asked.time = 0.0;
    asked.hold_all = false;
    asked.adaptive = RF_ADAPTIVE_OFF;
    RfRenderSettings *plain = s->settings, *reuse = s->settings + 1;
    RfResult result = rf_resolve_settings( job->tracer, job->eyes, job->eye_count, &asked, reuse, error );
    if ( result != RF_OK )
        return result;
    *plain = *reuse;
    plain->group = 0;
    plain->tile = rf_no_tile();
    RfGroupPlan groups = rf_plan_groups( job->eye_count, reuse->group, 1 );
    reuse->group = groups.eyes / 2;
    if ( reuse->group == 0 && reuse->tile.kind == RF_TILE_NONE )
        return rf_fail( error, RF_ERROR_USAGE,
                        "group 0 with tile 1 is path tracing, which all is compared with: take a larger group or a tile" );
    s->cost->plain = ( RfCostCurve ){ .group = 0, .eyes = 1, .tile = plain->tile };
    s->cost->reuse = ( RfCostCurve ){ .group = reuse->group, .eyes = groups.eyes, .tile = reuse->tile };
    return RF_OK;
}

RfResult rf_measure_cost( const RfCostJob* job, RfCost* cost, RfError* error )
{
    Study s = { .job = job, .cost = cost, .start = rf_wall_seconds() };
    *cost = ( RfCost ){ .positions = 0 };
    RfResult result = resolve_settings( &s, error );
    if ( result == RF_OK )
        result = make_regions( &s, error );
    if ( result == RF_OK )
        result = run_levels( &s, error );
    for ( int i = 0; i < s.region_count; ++i )
        rf_destroy_test_region( s.regions + i );
    if ( s.unit_count > 0 )
        fit_curves( &s );
    if ( result == RF_OK && !( cost->plain.relmse > 0.0 && cost->reuse.relmse > 0.0 ) )
        return rf_fail( error, RF_ERROR_SCENE,
                        "the error of the test images cannot be measured: they are black, or have NaN or infinite pixels" );
    return result;
}

RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep )
{
    double wanted = ceil( curve->relmse / relmse );
    RfCostPrediction p = { .frame_seconds = (double)NAN, .seconds = (double)NAN };
    if ( !( wanted <= RF_MAX_SPP ) )
        return p;
    RfGroupPlan plan = rf_plan_groups( job->eye_count, curve->group, wanted < 2.0 ? 2 : (int)wanted );
    double samples = 0.0, unused = 0.0;
    for ( int first = 0; first < job->frame_count; first += per_sweep )
    {
        int end = job->frame_count - first < per_sweep ? job->frame_count : first + per_sweep;
        rf_add_group_samples( &plan, job->frames, first, end, &samples, &unused );
    }
    p.spp = plan.spp;
    p.frame_seconds = frame_seconds( job, curve, plan.spp, curve->sample_seconds );
    p.seconds = samples * frame_pixels( job ) * curve->sample_seconds + job->frame_count * curve->finish_seconds;
    return p;
}
