#include "measure/trial.h"

#include "base/remedy.h"

#include "base/random.h"
#include "measure/error.h"
#include "measure/trial_pair.h"
#include "reuse/tile.h"

#include <math.h>
#include <stdlib.h>

#define PILOT_PASSES 2
#define MAX_PILOT_PASSES 8 // when smaller groups contribute fewer samples per frame

RfEye rf_resize_eye( const RfEye* eye, int width, int height )
{
    RfEye resized = *eye;
    float scale = (float)height / (float)eye->height;
    resized.focal = eye->focal * (float)height / (float)eye->height;
    resized.focal_x = eye->focal_x * (float)height / (float)eye->height;
    resized.axis_x = 0.5f * (float)width + ( eye->axis_x - 0.5f * (float)eye->width ) * scale;
    resized.axis_y = 0.5f * (float)height + ( eye->axis_y - 0.5f * (float)eye->height ) * scale;
    resized.width = width;
    resized.height = height;
    return resized;
}

static size_t eye_pixels( const RfEye* eye ) { return (size_t)eye->width * (size_t)eye->height; }

static int clamp( int value, int low, int high ) { return value < low ? low : value > high ? high : value; }

// relMSE weights from the mean over the channels, blurred over the pixel's neighbours.
static void compute_weights( const float* rgb, int width, int height, float* weight )
{
    for ( int y = 0; y < height; ++y )
    {
        for ( int x = 0; x < width; ++x )
        {
            double sum = 0.0;
            int count = 0;
            for ( int ny = clamp( y - 1, 0, y ); ny <= y + 1 && ny < height; ++ny )
            {
                for ( int nx = clamp( x - 1, 0, x ); nx <= x + 1 && nx < width; ++nx )
                {
                    const float* p = rgb + 3 * ( (size_t)ny * (size_t)width + (size_t)nx );
                    sum += (double)p[0] + (double)p[1] + (double)p[2];
                    count += 3;
                }
            }
            double mean = sum / count;
            weight[(size_t)y * (size_t)width + (size_t)x] = (float)( 1.0 / ( mean * mean + RF_RELMSE_EPSILON ) );
        }
    }
}

static RfResult keep_weights( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    RfTestRegion* region = user;
    size_t pixels = (size_t)frame->width * (size_t)frame->height;
    compute_weights( frame->rgb, frame->width, frame->height, region->weight + pixels * (size_t)frame->frame );
    return RF_OK;
}

static bool pilot_fits( const RfTracer* tracer, const RfTestRegion* region, const RfRenderSettings* settings )
{
    RfRenderSettings s = *settings;
    RfMemoryFit fit;
    s.threads = 1;
    RfResult result = rf_fit_memory( rf_tracer_scene( tracer ), region->eyes, region->frames, region->frames, &s, &fit, NULL );
    return result == RF_OK && fit.sweeps == 1;
}

// Settings for the pilot image: all frames as one group, so that every frame uses the samples
// of all, with tiles. If memory is short, no tiles or smaller groups, since the settings to be
// tried may need less memory than that; at worst path tracing, which needs the least.
static void choose_pilot_settings( const RfTracer* tracer, const RfTestRegion* region, RfRenderSettings* s )
{
    RfTile tiles[2] = { rf_default_render_settings().tile, rf_no_tile() };
    for ( s->group = region->frames / 2;; s->group /= 2 )
    {
        int eyes = clamp( 2 * s->group + 1, 1, region->frames );
        s->spp = clamp( PILOT_PASSES * region->frames / eyes, PILOT_PASSES, MAX_PILOT_PASSES );
        for ( int k = 0; k < 2; ++k )
        {
            s->tile = tiles[k];
            if ( s->memory == 0 || pilot_fits( tracer, region, s ) )
                return;
        }
        if ( s->group == 0 )
            return;
    }
}

static RfResult render_pilot( const RfTracer* tracer, const RfRenderSettings* settings, const RfTrialWatch* watch,
                              RfTestRegion* region, RfError* error )
{
    RfRenderSettings s = *settings;
    s.weights = RF_WEIGHTS_EXACT;
    s.normalize = RF_NORMALIZE_CROSSFIT;
    s.aovs = 0;
    s.queue = 0;
    s.seed = rf_mix64( settings->seed ^ rf_mix64( (uint64_t)region->first ) ) ^ 0x5175ull;
    choose_pilot_settings( tracer, region, &s );
    RfTrialMeter meter;
    RfResult result = rf_render_metered( tracer, region->eyes, region->frames, &s, keep_weights, region, watch, &meter, error );
    region->seconds = meter.all_cpu;
    region->samples = meter.all_samples;
    return result;
}

RfResult rf_create_test_region( const RfTracer* tracer, const RfEye* eyes, int eye_count, int centre, int frames, int width,
                                int height, const RfRenderSettings* settings, const RfTrialWatch* watch, RfTestRegion* region,
                                RfError* error )
{
    *region = ( RfTestRegion ){ .frames = clamp( frames, 1, eye_count ) };
    region->whole = region->frames == eye_count;
    region->first = clamp( centre - region->frames / 2, 0, eye_count - region->frames );
    size_t pixels = (size_t)width * (size_t)height;
    region->eyes = malloc( (size_t)region->frames * sizeof *region->eyes );
    region->weight = malloc( (size_t)region->frames * pixels * sizeof *region->weight );
    if ( region->eyes == NULL || region->weight == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "the system has no memory left to try settings on %d frames of %dx%d",
                        region->frames, width, height );
    for ( int i = 0; i < region->frames; ++i )
        region->eyes[i] = rf_resize_eye( eyes + region->first + i, width, height );
    return render_pilot( tracer, settings, watch, region, error );
}

void rf_destroy_test_region( RfTestRegion* region )
{
    free( region->eyes );
    free( region->weight );
    *region = ( RfTestRegion ){ 0 };
}

// The seed of one of the two renders (twins) of a group, different for every group and twin.
static uint64_t group_seed( uint64_t seed, int group, int twin )
{
    return rf_mix64( rf_mix64( seed ) ^ ( (uint64_t)group << 1 | (uint64_t)twin ) );
}

static RfResult try_group( const RfTracer* tracer, const RfTestRegion* region, int first, const RfRenderSettings* settings,
                           const RfTrialWatch* watch, RfTrialPair* pair, RfTrial* trial, RfError* error )
{
    size_t pixels = eye_pixels( region->eyes );
    rf_begin_pair( pair, region->weight + pixels * (size_t)first );
    for ( int twin = 0; twin < 2; ++twin )
    {
        RfRenderSettings s = *settings;
        s.seed = group_seed( settings->seed, region->first + first, twin );
        RfTrialMeter meter;
        RfResult result = rf_render_metered( tracer, region->eyes + first, pair->eyes, &s,
                                             twin == 0 ? rf_keep_first : rf_compare_second, pair, watch, &meter, error );
        if ( result != RF_OK )
            return result;
        trial->samples += meter.all_samples;
        trial->timed_samples += meter.samples;
        trial->cpu_seconds += meter.cpu;
        trial->wall_seconds += meter.wall;
        trial->finish_seconds += meter.finish_cpu;
        trial->finish_pixels += (double)pixels * pair->eyes;
    }
    rf_end_pair( pair, settings->spp, trial );
    return RF_OK;
}

RfResult rf_run_trial( const RfTracer* tracer, const RfTestRegion* region, int groups, int passes,
                       const RfRenderSettings* settings, const RfTrialWatch* watch, RfTrial* trial, RfError* error )
{
    *trial = ( RfTrial ){ 0 };
    // a group with more frames than the region must contain the whole path
    int eyes = 2 * settings->group + 1 <= region->frames ? 2 * settings->group + 1 : region->frames;
    if ( settings->group < 0 || settings->group > region->frames / 2 )
        return rf_fail( error, RF_ERROR_USAGE, "a test region of %d frames is too short for groups of %d", region->frames,
                        2 * settings->group + 1 );
    if ( passes < 2 )
        return rf_fail( error, RF_ERROR_USAGE, "a trial needs at least 2 passes, got %d", passes );
    int count = clamp( groups, 1, region->frames / eyes ), first = ( region->frames - count * eyes ) / 2;
    RfRenderSettings s = *settings;
    s.spp = passes; // of a single group
    s.aovs = 0;
    s.queue = 0;
    RfTrialPair pair = { .eyes = eyes, .whole = region->whole && eyes == region->frames, .pixels = eye_pixels( region->eyes ) };
    pair.rgb = malloc( rf_trial_bytes( eyes, pair.pixels ) );
    if ( pair.rgb == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "the system has no memory left to try groups of %d frames", eyes );
    RfResult result = RF_OK;
    for ( int w = 0; w < count && result == RF_OK; ++w )
        result = try_group( tracer, region, first + w * eyes, &s, watch, &pair, trial, error );
    free( pair.rgb );
    return result;
}

void rf_add_trial( RfTrial* sum, const RfTrial* trial )
{
    sum->groups += trial->groups;
    sum->weight += trial->weight;
    sum->samples += trial->samples;
    sum->timed_samples += trial->timed_samples;
    sum->cpu_seconds += trial->cpu_seconds;
    sum->wall_seconds += trial->wall_seconds;
    sum->finish_seconds += trial->finish_seconds;
    sum->finish_pixels += trial->finish_pixels;
    sum->relmse += trial->relmse;
    sum->mse += trial->mse;
    sum->change += trial->change;
}

double rf_trial_relmse( const RfTrial* trial, double spp ) { return trial->relmse / trial->weight / spp; }

double rf_trial_f1( const RfTrial* trial, double spp ) { return sqrt( 2.0 * trial->change / trial->weight / spp ); }

double rf_trial_phi( const RfTrial* trial ) { return trial->mse > 0.0 ? trial->change / trial->mse : 0.0; }

double rf_trial_sample_seconds( const RfTrial* trial ) { return trial->cpu_seconds / trial->timed_samples; }

double rf_trial_efficiency( const RfTrial* trial, double pixels )
{
    return 1.0 / ( rf_trial_relmse( trial, 1.0 ) * rf_trial_sample_seconds( trial ) * pixels );
}

size_t rf_test_region_bytes( int frames, size_t pixels )
{
    return (size_t)frames * ( pixels * sizeof( float ) + sizeof( RfEye ) );
}

size_t rf_trial_bytes( int eyes, size_t pixels ) { return (size_t)eyes * pixels * 3 * sizeof( float ); }
