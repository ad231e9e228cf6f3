#include "measure/cost.h"

#include "base/random.h"
#include "base/system.h"
#include "measure/bias_interval.h"
#include "reuse/group.h"

#include <math.h>
#include <string.h>

#define FIRST_PASSES 2
#define WANTED_LEVELS 4    // as many as the budget is laid out for
#define FEWEST_PIXELS 20000 // of a picture: smaller ones are all set-up, and tiles reach too far in them
#define PROBE_PIXELS 6000
#define UNITS ( RF_COST_LEVELS * RF_COST_PLACES )

// A place and a level: the same for both curves, with seeds of its own.
typedef struct Unit
{
    int passes;
    RfTrial trials[2]; // plain, with reuse
} Unit;

typedef struct Study
{
    const RfCostJob* job;
    RfCost* cost;
    RfRenderSettings settings[2]; // resolved
    RfTrialSite sites[RF_COST_PLACES];
    int site_count;
    Unit units[UNITS];
    int unit_count;
    double start;
} Study;

static int scaled( int side, double scale )
{
    int pixels = (int)floor( side * scale + 0.5 );
    return pixels < 1 ? 1 : pixels;
}

// A picture of at most so many pixels, no larger than the render's.
static void choose_size( const RfEye* eye, double pixels, int* width, int* height )
{
    double scale = sqrt( pixels / ( (double)eye->width * eye->height ) );
    *width = scale < 1.0 ? scaled( eye->width, scale ) : eye->width;
    *height = scale < 1.0 ? scaled( eye->height, scale ) : eye->height;
}

static RfResult make_site( Study* s, double place, int width, int height, RfTrialSite* site, RfError* error )
{
    const RfCostJob* job = s->job;
    int frame = job->frames[(int)( place * job->frame_count )];
    return rf_create_trial_site( job->tracer, job->eyes, job->eye_count, frame, 2 * s->settings[1].group + 1, width, height,
                                 s->settings + 1, job->watch, site, error );
}

// All frames of the site, by path tracing and in one group.
static RfResult try_both( Study* s, const RfTrialSite* site, int passes, uint64_t salt, RfTrial trials[2], RfError* error )
{
    RfResult result = RF_OK;
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
    {
        RfRenderSettings settings = s->settings[k];
        settings.seed = rf_mix64( settings.seed ^ rf_mix64( salt ) );
        result = rf_run_trial( s->job->tracer, site, k == 0 ? site->frames : 1, passes, &settings, s->job->watch, trials + k, error );
    }
    return result;
}

// Seconds that a pixel of a place takes at the first level, by a small picture.
static RfResult probe( Study* s, double* pixel_seconds, RfError* error )
{
    int width, height;
    choose_size( s->job->eyes, PROBE_PIXELS, &width, &height );
    double start = rf_wall_seconds();
    RfTrialSite site;
    RfTrial trials[2];
    RfResult result = make_site( s, 0.5, width, height, &site, error );
    if ( result == RF_OK )
        result = try_both( s, &site, FIRST_PASSES, 0x9b0be, trials, error );
    rf_destroy_trial_site( &site );
    *pixel_seconds = ( rf_wall_seconds() - start ) / ( (double)width * height );
    return result;
}

// Pictures as large as let the budget have WANTED_LEVELS, each twice as long as the
// one before.
static RfResult make_sites( Study* s, RfError* error )
{
    double pixel_seconds;
    RfResult result = probe( s, &pixel_seconds, error );
    s->cost->places = s->job->frame_count < RF_COST_PLACES ? s->job->frame_count : RF_COST_PLACES;
    double left = s->job->budget - ( rf_wall_seconds() - s->start );
    double pixels = left / ( ( 1 << WANTED_LEVELS ) * pixel_seconds * s->cost->places );
    choose_size( s->job->eyes, pixels > FEWEST_PIXELS ? pixels : FEWEST_PIXELS, &s->cost->width, &s->cost->height );
    for ( int i = 0; i < s->cost->places && result == RF_OK; ++i )
    {
        s->site_count = i + 1;
        result = make_site( s, ( i + 0.5 ) / s->cost->places, s->cost->width, s->cost->height, s->sites + i, error );
    }
    return result;
}

static double relmse_of( const RfTrial* trial ) { return trial->relmse / trial->weight; } // of a single sample

// Error of a single sample and seconds of it, over all units but one (−1: all).
// More samples tell more of the error: units weigh as their passes.
static void sum_units( const Study* s, int curve, int without, double* relmse, double* seconds, double* cpu )
{
    double error = 0.0, weight = 0.0, wall = 0.0, work = 0.0, samples = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        if ( i == without )
            continue;
        const RfTrial* trial = s->units[i].trials + curve;
        error += s->units[i].passes * relmse_of( trial );
        weight += s->units[i].passes;
        wall += trial->wall_seconds;
        work += trial->cpu_seconds;
        samples += trial->timed_samples;
    }
    *relmse = error / weight;
    *seconds = wall / samples;
    *cpu = work / samples;
}

static double log_speedup( const Study* s, int without )
{
    double relmse[2], seconds[2], cpu;
    for ( int k = 0; k < 2; ++k )
        sum_units( s, k, without, relmse + k, seconds + k, &cpu );
    return log( relmse[0] * seconds[0] / ( relmse[1] * seconds[1] ) );
}

// By the jackknife over the units.
static void weigh_speedup( Study* s )
{
    int n = s->unit_count;
    double whole = log_speedup( s, -1 ), mean = 0.0, square = 0.0;
    for ( int i = 0; i < n && n > 1; ++i )
    {
        double d = log_speedup( s, i ) - whole;
        mean += d / n;
        square += d * d / n;
    }
    double margin = n > 1 ? rf_student_quantile( n - 1 ) * sqrt( ( n - 1 ) * ( square - mean * mean ) ) : (double)NAN;
    s->cost->speedup = exp( whole );
    s->cost->speedup_low = exp( whole - margin );
    s->cost->speedup_high = exp( whole + margin );
}

// Least squares through the logarithms, all rows alike.
static void fit_slope( RfCostCurve* c )
{
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    c->slope = c->slope_low = c->slope_high = (double)NAN;
    for ( int i = 0; i < c->count; ++i )
    {
        double u = log( c->rows[i].seconds ), v = log( c->rows[i].relmse );
        if ( !isfinite( u ) || !isfinite( v ) )
            continue;
        n += 1.0;
        x += u;
        y += v;
        xx += u * u;
        xy += u * v;
        yy += v * v;
    }
    double spread = xx - x * x / n;
    if ( n < 2.0 || !( spread > 0.0 ) )
        return;
    c->slope = ( xy - x * y / n ) / spread;
    double rest = yy - y * y / n - c->slope * c->slope * spread;
    if ( n < 3.0 )
        return;
    double margin = rf_student_quantile( (int)n - 2 ) * sqrt( fmax( rest, 0.0 ) / ( n - 2.0 ) / spread );
    c->slope_low = c->slope - margin;
    c->slope_high = c->slope + margin;
}

static double frame_pixels( const RfCostJob* job ) { return (double)job->eyes->width * job->eyes->height; }

static double frame_seconds( const RfCostJob* job, const RfCostCurve* c, double spp, double sample_seconds )
{
    return frame_pixels( job ) * spp * sample_seconds + c->finish_seconds;
}

// A level's row: its places together.
static void add_row( Study* s, int curve, RfCostCurve* c, int passes )
{
    double relmse = 0.0, wall = 0.0, cpu = 0.0, samples = 0.0;
    for ( int i = s->unit_count - s->cost->places; i < s->unit_count; ++i )
    {
        const RfTrial* trial = s->units[i].trials + curve;
        relmse += relmse_of( trial ) / passes / s->cost->places;
        wall += trial->wall_seconds;
        cpu += trial->cpu_seconds;
        samples += trial->timed_samples;
    }
    c->rows[c->count++] = ( RfCostRow ){ .spp = passes, .seconds = frame_seconds( s->job, c, passes, wall / samples ),
                                         .cpu_seconds = frame_seconds( s->job, c, passes, cpu / samples ), .relmse = relmse };
}

// What finishing a frame takes is told by the first level.
static void settle_finish( Study* s, int curve, RfCostCurve* c )
{
    double seconds = 0.0, pixels = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        seconds += s->units[i].trials[curve].finish_seconds;
        pixels += s->units[i].trials[curve].finish_pixels;
    }
    c->finish_seconds = pixels > 0.0 ? fmax( seconds, 0.0 ) / pixels * frame_pixels( s->job ) : 0.0;
}

static RfResult run_level( Study* s, int level, RfError* error )
{
    int passes = FIRST_PASSES << level;
    if ( s->job->say != NULL )
        s->job->say( s->job->user, s->cost, passes );
    for ( int i = 0; i < s->cost->places; ++i )
    {
        Unit* unit = s->units + s->unit_count;
        unit->passes = passes;
        RfResult result = try_both( s, s->sites + i, passes, (uint64_t)( level * RF_COST_PLACES + i + 1 ), unit->trials, error );
        if ( result != RF_OK )
        {
            s->unit_count = level * s->cost->places; // whole levels only
            return result;
        }
        s->unit_count += 1;
    }
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        if ( level == 0 )
            settle_finish( s, k, curves[k] );
        add_row( s, k, curves[k], passes );
    }
    return RF_OK;
}

// Levels as long as one that takes twice as long as the last still fits.
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

static void conclude( Study* s )
{
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        double cpu;
        fit_slope( curves[k] );
        sum_units( s, k, -1, &curves[k]->relmse, &curves[k]->sample_seconds, &cpu );
    }
    weigh_speedup( s );
    s->cost->seconds = rf_wall_seconds() - s->start;
}

static RfResult resolve( Study* s, RfError* error )
{
    const RfCostJob* job = s->job;
    RfRenderSettings asked = *job->settings;
    asked.noise = asked.time = 0.0;
    asked.hold_all = false;
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
        return rf_fail( error, RF_ERROR_USAGE, "--group 0 --tile 1 is path tracing, which all is compared with: take a larger group or a tile" );
    s->cost->plain = ( RfCostCurve ){ .group = 0, .eyes = 1, .tile = plain->tile };
    s->cost->reuse = ( RfCostCurve ){ .group = reuse->group, .eyes = groups.eyes, .tile = reuse->tile };
    return RF_OK;
}

RfResult rf_measure_cost( const RfCostJob* job, RfCost* cost, RfError* error )
{
    Study s = { .job = job, .cost = cost, .start = rf_wall_seconds() };
    *cost = ( RfCost ){ .places = 0 };
    RfResult result = resolve( &s, error );
    if ( result == RF_OK )
        result = make_sites( &s, error );
    if ( result == RF_OK )
        result = run_levels( &s, error );
    for ( int i = 0; i < s.site_count; ++i )
        rf_destroy_trial_site( s.sites + i );
    if ( s.unit_count > 0 )
        conclude( &s );
    if ( result == RF_OK && !( cost->plain.relmse > 0.0 && cost->reuse.relmse > 0.0 ) )
        return rf_fail( error, RF_ERROR_SCENE, "the pictures have no error that can be measured: they are black, or hold what is no number" );
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
        rf_add_window_samples( &plan, job->frames, first, end, &samples, &unused );
    }
    p.spp = plan.spp;
    p.frame_seconds = frame_seconds( job, curve, plan.spp, curve->sample_seconds );
    p.seconds = samples * frame_pixels( job ) * curve->sample_seconds + job->frame_count * curve->finish_seconds;
    return p;
}
