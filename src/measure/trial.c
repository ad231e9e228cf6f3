#include "measure/trial.h"

#include "base/remedy.h"

#include "base/random.h"
#include "measure/error.h"
#include "measure/trial_pair.h"
#include "reuse/tile.h"

#include <math.h>
#include <stdlib.h>

#define GUIDE_PASSES 2
#define MOST_GUIDE_PASSES 8 // where smaller groups give a frame less

RfEye rf_resize_eye( const RfEye* eye, int width, int height )
{
    RfEye resized = *eye;
    resized.focal = eye->focal * (float)height / (float)eye->height;
    resized.width = width;
    resized.height = height;
    return resized;
}

static size_t eye_pixels( const RfEye* eye ) { return (size_t)eye->width * (size_t)eye->height; }

static int clamp( int value, int low, int high ) { return value < low ? low : value > high ? high : value; }

// The mean of the channels over the pixel and its neighbours, as a weight.
static void weigh_pixels( const float* rgb, int width, int height, float* weight )
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
    RfTestRegion* site = user;
    size_t pixels = (size_t)frame->width * (size_t)frame->height;
    weigh_pixels( frame->rgb, frame->width, frame->height, site->weight + pixels * (size_t)frame->frame );
    return RF_OK;
}

static bool guide_fits( const RfTracer* tracer, const RfTestRegion* site, const RfRenderSettings* settings )
{
    RfRenderSettings s = *settings;
    RfMemoryFit fit;
    s.threads = 1;
    RfResult result = rf_fit_memory( rf_tracer_scene( tracer ), site->eyes, site->frames, site->frames, &s, &fit, NULL );
    return result == RF_OK && fit.sweeps == 1;
}

// One window of all frames, so that every frame has the samples of all of them, and
// tiles; where memory is short no tiles, or smaller groups, for the settings that are
// tried may take less than that. At worst path tracing, than which nothing takes less.
static void choose_guide( const RfTracer* tracer, const RfTestRegion* site, RfRenderSettings* s )
{
    RfTile tiles[2] = { rf_default_render_settings().tile, rf_no_tile() };
    for ( s->group = site->frames / 2;; s->group /= 2 )
    {
        int eyes = clamp( 2 * s->group + 1, 1, site->frames );
        s->spp = clamp( GUIDE_PASSES * site->frames / eyes, GUIDE_PASSES, MOST_GUIDE_PASSES );
        for ( int k = 0; k < 2; ++k )
        {
            s->tile = tiles[k];
            if ( s->memory == 0 || guide_fits( tracer, site, s ) )
                return;
        }
        if ( s->group == 0 )
            return;
    }
}

static RfResult render_guide( const RfTracer* tracer, const RfRenderSettings* settings, const RfTrialWatch* watch,
                              RfTestRegion* site, RfError* error )
{
    RfRenderSettings s = *settings;
    s.weights = RF_WEIGHTS_EXACT;
    s.normalize = RF_NORMALIZE_CROSSFIT;
    s.aovs = 0;
    s.queue = 0;
    s.seed = rf_mix64( settings->seed ^ rf_mix64( (uint64_t)site->first ) ) ^ 0x5175ull;
    choose_guide( tracer, site, &s );
    RfTrialMeter meter;
    RfResult result = rf_render_metered( tracer, site->eyes, site->frames, &s, keep_weights, site, watch, &meter, error );
    site->seconds = meter.all_cpu;
    site->samples = meter.all_samples;
    return result;
}

RfResult rf_create_test_region( const RfTracer* tracer, const RfEye* eyes, int eye_count, int centre, int frames, int width,
                                int height, const RfRenderSettings* settings, const RfTrialWatch* watch, RfTestRegion* site,
                                RfError* error )
{
    *site = ( RfTestRegion ){ .frames = clamp( frames, 1, eye_count ) };
    site->whole = site->frames == eye_count;
    site->first = clamp( centre - site->frames / 2, 0, eye_count - site->frames );
    size_t pixels = (size_t)width * (size_t)height;
    site->eyes = malloc( (size_t)site->frames * sizeof *site->eyes );
    site->weight = malloc( (size_t)site->frames * pixels * sizeof *site->weight );
    if ( site->eyes == NULL || site->weight == NULL )
        return rf_advise( rf_fail( error, RF_ERROR_MEMORY, "no memory left to try settings on %d frames of %dx%d", site->frames,
                                   width, height ),
                          RF_REMEDY_MEMORY, 0, error );
    for ( int i = 0; i < site->frames; ++i )
        site->eyes[i] = rf_resize_eye( eyes + site->first + i, width, height );
    return render_guide( tracer, settings, watch, site, error );
}

void rf_destroy_test_region( RfTestRegion* site )
{
    free( site->eyes );
    free( site->weight );
    *site = ( RfTestRegion ){ 0 };
}

// Both seeds of a window: other random numbers than its neighbours' and its twin's.
static uint64_t window_seed( uint64_t seed, int window, int twin )
{
    return rf_mix64( rf_mix64( seed ) ^ ( (uint64_t)window << 1 | (uint64_t)twin ) );
}

static RfResult try_window( const RfTracer* tracer, const RfTestRegion* site, int first, const RfRenderSettings* settings,
                            const RfTrialWatch* watch, RfTrialPair* pair, RfTrial* trial, RfError* error )
{
    size_t pixels = eye_pixels( site->eyes );
    rf_begin_pair( pair, site->weight + pixels * (size_t)first );
    for ( int twin = 0; twin < 2; ++twin )
    {
        RfRenderSettings s = *settings;
        s.seed = window_seed( settings->seed, site->first + first, twin );
        RfTrialMeter meter;
        RfResult result = rf_render_metered( tracer, site->eyes + first, pair->eyes, &s,
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

RfResult rf_run_trial( const RfTracer* tracer, const RfTestRegion* site, int windows, int passes,
                       const RfRenderSettings* settings, const RfTrialWatch* watch, RfTrial* trial, RfError* error )
{
    *trial = ( RfTrial ){ 0 };
    // a group that would hold more than the site can only be a path's that is all in it
    int eyes = 2 * settings->group + 1 <= site->frames ? 2 * settings->group + 1 : site->frames;
    if ( settings->group < 0 || settings->group > site->frames / 2 )
        return rf_fail( error, RF_ERROR_USAGE, "a site of %d frames cannot try groups of %d", site->frames,
                        2 * settings->group + 1 );
    if ( passes < 2 )
        return rf_fail( error, RF_ERROR_USAGE, "a trial needs 2 passes or more, got %d", passes );
    int count = clamp( windows, 1, site->frames / eyes ), first = ( site->frames - count * eyes ) / 2;
    RfRenderSettings s = *settings;
    s.spp = passes; // of a single window
    s.aovs = 0;
    s.queue = 0;
    RfTrialPair pair = { .eyes = eyes, .whole = site->whole && eyes == site->frames, .pixels = eye_pixels( site->eyes ) };
    pair.rgb = malloc( rf_trial_bytes( eyes, pair.pixels ) );
    if ( pair.rgb == NULL )
        return rf_advise( rf_fail( error, RF_ERROR_MEMORY, "no memory left to try groups of %d frames", eyes ), RF_REMEDY_MEMORY,
                          0, error );
    RfResult result = RF_OK;
    for ( int w = 0; w < count && result == RF_OK; ++w )
        result = try_window( tracer, site, first + w * eyes, &s, watch, &pair, trial, error );
    free( pair.rgb );
    return result;
}

void rf_add_trial( RfTrial* sum, const RfTrial* trial )
{
    sum->windows += trial->windows;
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
