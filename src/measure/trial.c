#include "measure/trial.h"

#include "base/remedy.h"

#include "base/random.h"
#include "film/pixel_filter.h"
#include "measure/crops.h"
#include "reframe/measure.h"
#include "measure/trial_pair.h"
#include "render/settings.h"
#include "reuse/tile.h"

#include <math.h>
#include <stdlib.h>

#define PILOT_PASSES 2
#define MAX_PILOT_PASSES 8 // when smaller groups contribute fewer samples per frame

static int clamp( int value, int low, int high ) { return value < low ? low : value > high ? high : value; }

// Sum over the channels of the traced pixels around a pixel, and the count of values.
static double sum_around( const RfTestRegion* region, const RfFrameResult* frame, int x, int y, int* count )
{
    RfPieces pieces = rf_pieces_from( &region->pieces, frame->frame );
    double sum = 0.0;
    *count = 0;
    for ( int ny = clamp( y - 1, 0, y ); ny <= y + 1 && ny < frame->height; ++ny )
    {
        for ( int nx = clamp( x - 1, 0, x ); nx <= x + 1 && nx < frame->width; ++nx )
        {
            if ( region->pieces.traced != NULL && !rf_is_traced( &pieces, pieces.cells, nx, ny ) )
                continue;
            const float* p = frame->rgb + 3 * ( (size_t)ny * (size_t)frame->width + (size_t)nx );
            sum += (double)p[0] + (double)p[1] + (double)p[2];
            *count += 3;
        }
    }
    return sum;
}

// relMSE weights of a frame, from the mean over the channels, blurred over the pixel's neighbours.
static RfResult keep_weights( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    RfTestRegion* region = user;
    const RfTestPieces* pieces = &region->pieces;
    int cells = pieces->across * pieces->down;
    const int32_t* slot = pieces->slot + (size_t)frame->frame * (size_t)cells;
    int32_t pixel[RF_CELL_PIXELS];
    for ( int cell = 0; cell < cells; ++cell )
    {
        int pixels = slot[cell] >= 0 ? rf_cell_pixels( pieces, cell, pixel ) : 0, count;
        for ( int k = 0; k < pixels; ++k )
        {
            double mean = sum_around( region, frame, pixel[k] % frame->width, pixel[k] / frame->width, &count ) / count;
            region->weight[RF_CELL_PIXELS * (size_t)slot[cell] + (size_t)k] =
                (float)( 1.0 / ( mean * mean + RF_RELMSE_EPSILON ) );
        }
    }
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
    s->estimator = rf_default_render_settings().estimator;
    for ( s->group = region->crops != NULL ? 0 : region->frames / 2;; s->group /= 2 )
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
    s.adaptive = RF_ADAPTIVE_OFF;
    s.seed = rf_mix64( settings->seed ^ rf_mix64( (uint64_t)region->first ) ) ^ 0x5175ull;
    choose_pilot_settings( tracer, region, &s );
    RfPieces pieces = rf_pieces_from( &region->pieces, 0 );
    s.pieces = region->pieces.traced != NULL ? &pieces : NULL;
    RfTrialMeter meter;
    RfResult result = rf_render_metered( tracer, region->eyes, region->frames, &s, keep_weights, region, watch, &meter, error );
    region->seconds = meter.all_cpu;
    region->samples = meter.all_samples;
    return result;
}

// Parts of the pictures, or the whole of them where the estimator renders no parts.
static RfResult choose_pieces( const RfTracer* tracer, RfTestRegion* region, int centre, double pixels, uint64_t seed,
                               const RfRenderSettings* settings, RfError* error )
{
    double all = (double)region->eyes->width * region->eyes->height;
    return rf_choose_pieces( tracer, region->eyes, region->frames, centre - region->first,
                             rf_can_render_pieces( settings ) ? pixels : all, !rf_is_plain_filter( settings ), seed,
                             &region->pieces, error );
}

RfResult rf_create_test_region( const RfTracer* tracer, const RfEye* eyes, int eye_count, int centre, int frames, double pixels,
                                const RfRenderSettings* settings, const RfTrialWatch* watch, RfTestRegion* region,
                                RfError* error )
{
    *region = ( RfTestRegion ){ .frames = clamp( frames, 1, eye_count ) };
    region->whole = region->frames == eye_count;
    region->first = clamp( centre - region->frames / 2, 0, eye_count - region->frames );
    region->eyes = eyes + region->first;
    uint64_t seed = rf_mix64( settings->seed ) ^ (uint64_t)centre;
    RfResult result = RF_OK;
    if ( !rf_can_render_pieces( settings ) )
        result = rf_choose_crops( region->eyes, region->frames, pixels, seed, &region->crops, &region->pieces, error );
    if ( region->crops != NULL )
    {
        region->eyes = region->crops;
        region->frames = RF_CROPS;
        region->whole = false;
    }
    else if ( result == RF_OK )
        result = choose_pieces( tracer, region, centre, pixels, seed, settings, error );
    if ( result != RF_OK )
        return result;
    size_t slots = (size_t)region->pieces.first_slot[region->frames];
    region->weight = malloc( ( slots + 1 ) * RF_CELL_PIXELS * sizeof *region->weight );
    if ( region->weight == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "the system has no memory left to try settings on %d frames", region->frames );
    return render_pilot( tracer, settings, watch, region, error );
}

void rf_destroy_test_region( RfTestRegion* region )
{
    rf_destroy_test_pieces( &region->pieces );
    free( region->crops );
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
    double seconds[2];
    RfPieces pieces = rf_pieces_from( &region->pieces, first );
    rf_begin_pair( pair, first );
    for ( int twin = 0; twin < 2; ++twin )
    {
        RfRenderSettings s = *settings;
        s.seed = group_seed( settings->seed, region->first + first, twin );
        s.pieces = region->pieces.traced != NULL ? &pieces : NULL;
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
        trial->finish_pixels += region->pieces.pixels * pair->eyes;
        seconds[twin] = meter.cpu / meter.samples;
    }
    double noise = log( seconds[0] / seconds[1] );
    trial->time_noise += isfinite( noise ) ? noise * noise : 0.0;
    trial->time_count += 1;
    rf_end_pair( pair, settings->spp, trial );
    return RF_OK;
}

// The most slots that `eyes` consecutive frames of the region have.
static size_t most_slots( const RfTestPieces* pieces, int eyes )
{
    int32_t most = 0;
    for ( int f = 0; f + eyes <= pieces->frames; ++f )
    {
        int32_t slots = pieces->first_slot[f + eyes] - pieces->first_slot[f];
        most = slots > most ? slots : most;
    }
    return (size_t)most;
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
    RfTrialPair pair = {
        .eyes = eyes, .whole = region->whole && eyes == region->frames, .pieces = &region->pieces, .weight = region->weight
    };
    pair.rgb = malloc( ( most_slots( &region->pieces, eyes ) + 1 ) * 3 * RF_CELL_PIXELS * sizeof( float ) );
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
    sum->change_weight += trial->change_weight;
    sum->change += trial->change;
    sum->time_noise += trial->time_noise;
    sum->time_count += trial->time_count;
    for ( int k = 0; k < RF_WORST_CELLS; ++k )
        rf_keep_worst_cell( sum->worst, trial->worst[k] );
    for ( int i = 0; i < trial->piece_count && sum->piece_count < RF_TRIAL_PIECES; ++i )
        sum->pieces[sum->piece_count++] = trial->pieces[i];
}

// NaN where nothing was measured.
static double mean( double sum, double count ) { return count > 0.0 ? sum / count : (double)NAN; }

double rf_trial_relmse( const RfTrial* trial, double spp ) { return mean( trial->relmse, trial->weight ) / spp; }

static double mean_change( const RfTrial* trial ) { return mean( trial->change, trial->change_weight ); }

double rf_trial_f1( const RfTrial* trial, double spp ) { return sqrt( 2.0 * mean_change( trial ) / spp ); }

double rf_trial_phi( const RfTrial* trial ) { return trial->mse > 0.0 ? mean_change( trial ) * trial->weight / trial->mse : 0.0; }

double rf_trial_sample_seconds( const RfTrial* trial ) { return mean( trial->cpu_seconds, trial->timed_samples ); }

double rf_trial_efficiency( const RfTrial* trial, double pixels )
{
    return 1.0 / ( rf_trial_relmse( trial, 1.0 ) * rf_trial_sample_seconds( trial ) * pixels );
}

size_t rf_test_region_bytes( int frames, size_t pixels )
{
    return (size_t)frames * pixels * sizeof( float ) + rf_test_pieces_bytes( frames, pixels );
}

size_t rf_trial_bytes( int eyes, size_t pixels ) { return 3 * (size_t)eyes * pixels * sizeof( float ); }
