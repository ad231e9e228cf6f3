// Estimates error from differences of independently seeded passes, and cost from CPU time, on pieces of the picture.
#include "measure/trial.h"

#include "base/random.h"
#include "base/system.h"
#include "film/brightness.h"
#include "film/pixel_filter.h"
#include "render/settings.h"
#include "reuse/tile/tile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Timings of one render. Set-up ends with the first chunk of records; `cpu` covers
// the `samples` after it, or everything if there is only one chunk.
typedef struct TrialMeter
{
    double samples, cpu;
    double finish_cpu; // from the last chunk on, without the callbacks
    double all_samples, all_cpu;
} TrialMeter;

// Two renders of a group, and what is not a sum over its pixels.
typedef struct TrialPair
{
    RfTrial* trial; // gets the errors, times the passes
    int passes, eyes;
    bool whole;                   // the frames are the whole path
    const RfTestPieces* pieces;   // of the region
    int first;                    // frame of the region
    const float* weight;          // of the region
    float* rgb;                   // of the group's slots: the first render, then the differences to the second
    float* removed;               // with a clamp: what it took out of the first render; NULL: there is none
    double pixels;                // measured
    double first_mean, last_mean; // of ½ d² in the first and the last frame
    double steps;                 // sum of the means of ½ (d_t − d_{t−1})² over the pixels that both frames measure
    int step_count;
} TrialPair;

void rf_keep_worst_cell( double worst[RF_WORST_CELLS], double relmse )
{
    for ( int k = 0; k < RF_WORST_CELLS; ++k )
    {
        if ( relmse <= worst[k] )
            continue;
        double next = worst[k];
        worst[k] = relmse;
        relmse = next;
    }
}

typedef struct Clock
{
    double samples, cpu;
} Clock;

typedef struct Metered
{
    RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error );
    void* user;
    const RfTrialWatch* watch;
    bool one_thread;
    bool begun;
    Clock first, last;
    double callbacks; // CPU seconds spent in `frame`
} Metered;

static double cpu_seconds( const Metered* m ) { return m->one_thread ? rf_thread_seconds() : rf_process_seconds(); }

static bool on_progress( void* user, const RfProgress* progress )
{
    Metered* m = user;
    m->last = ( Clock ){ progress->samples, cpu_seconds( m ) };
    if ( !m->begun )
        m->first = m->last;
    m->begun = true;
    return m->watch == NULL || m->watch->should_continue == NULL || m->watch->should_continue( m->watch->user );
}

static RfResult on_frame( void* user, const RfFrameResult* frame, RfError* error )
{
    Metered* m = user;
    double start = cpu_seconds( m );
    RfResult result = m->frame( m->user, frame, error );
    m->callbacks += cpu_seconds( m ) - start;
    return result;
}

// Renders all frames of a segment of the path; each goes to the callback `frame`, whose time
// is not counted.
static RfResult render_metered( const RfTestRegion* region, int first, int eye_count, const RfRenderSettings* settings,
                                RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error ), void* user,
                                TrialMeter* meter, RfError* error )
{
    Metered m = { .frame = frame, .user = user, .watch = region->watch, .one_thread = settings->threads == 1 };
    RfRenderCallbacks callbacks = { .user = &m, .frame = on_frame, .progress = on_progress };
    int* frames = malloc( (size_t)eye_count * sizeof *frames );
    if ( frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a list of %d frames", eye_count );
    for ( int i = 0; i < eye_count; ++i )
        frames[i] = i;
    Clock start = { 0.0, cpu_seconds( &m ) };
    RfResult result = rf_render( &( RfShot ){ region->shot.tracer, region->eyes + first, eye_count, frames, eye_count }, settings,
                                 &callbacks, NULL, error );
    double end = cpu_seconds( &m );
    free( frames );
    if ( m.last.samples == m.first.samples )
        m.first = start;
    *meter = ( TrialMeter ){
        .samples = m.last.samples - m.first.samples,
        .cpu = m.last.cpu - m.first.cpu,
        .finish_cpu = end - m.last.cpu - m.callbacks,
        .all_samples = m.last.samples,
        .all_cpu = end - start.cpu,
    };
    return result;
}

// Prepares for the first render of the group that begins with frame `first` of the region.
static void begin_pair( TrialPair* p, int first )
{
    p->first = first;
    p->pixels = p->first_mean = p->last_mean = p->steps = 0.0;
    p->step_count = 0;
}

// Where the colours of a slot are.
static float* colors_of( const TrialPair* p, int32_t slot )
{
    return p->rgb + 3 * RF_CELL_PIXELS * (size_t)( slot - p->pieces->first_slot[p->first] );
}

// A channel of the picture without a clamp.
static float exact_value( const RfFrameResult* frame, size_t i )
{
    const float* removed = frame->aovs[RF_AOV_REMOVED];
    return removed != NULL ? frame->rgb[i] + removed[i] : frame->rgb[i];
}

// Frame callback of the first render: keeps the frame.
static RfResult keep_first( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    TrialPair* p = user;
    const int32_t* slot = rf_frame_slots( p->pieces, p->first + frame->frame );
    int32_t pixel[RF_CELL_PIXELS];
    for ( int cell = 0; cell < p->pieces->across * p->pieces->down; ++cell )
    {
        int count = slot[cell] >= 0 ? rf_cell_pixels( p->pieces, cell, pixel ) : 0;
        size_t to = count > 0 ? (size_t)( colors_of( p, slot[cell] ) - p->rgb ) : 0;
        for ( int k = 0; k < 3 * count; ++k )
        {
            size_t i = 3 * (size_t)pixel[k / 3] + (size_t)( k % 3 );
            p->rgb[to + (size_t)k] = exact_value( frame, i );
            if ( p->removed != NULL )
                p->removed[to + (size_t)k] = frame->aovs[RF_AOV_REMOVED][i];
        }
    }
    return RF_OK;
}

// Adds what the clamp took out of a channel, and the error of what is left; `delta` is the difference without a clamp.
static double add_clamped( TrialPair* p, double delta, double exact, double first, double second, double weight )
{
    double left = delta - ( first - second );
    p->trial->clamp.bias += weight * first * second;
    p->trial->clamp.removed += first + second;
    p->trial->clamp.light += 2.0 * exact + delta;
    return weight * 0.5 * left * left;
}

// Subtracts the second render from a cell of the first; returns the weighted sum of ½ d², and adds it to the piece.
static double subtract_cell( TrialPair* p, const RfFrameResult* frame, int32_t slot, int count, const int32_t* pixel )
{
    float* d = colors_of( p, slot );
    const float* weight = p->weight + RF_CELL_PIXELS * (size_t)slot;
    double relmse = 0.0, clamped = 0.0;
    for ( int k = 0; k < count; ++k )
    {
        double sum = 0.0;
        for ( int c = 0; c < 3; ++c )
        {
            size_t i = 3 * (size_t)pixel[k] + (size_t)c;
            double exact = (double)exact_value( frame, i ), delta = (double)d[3 * k + c] - exact;
            sum += 0.5 * delta * delta;
            if ( p->removed != NULL )
                clamped += add_clamped( p, delta, exact, (double)p->removed[( d - p->rgb ) + 3 * k + c],
                                        (double)frame->aovs[RF_AOV_REMOVED][i], (double)weight[k] );
            d[3 * k + c] = (float)delta;
        }
        relmse += (double)weight[k] * sum;
    }
    RfPieceError* piece = p->trial->pieces + p->pieces->piece[slot];
    piece->weight += count;
    piece->relmse += p->passes * relmse;
    piece->clamped += p->passes * clamped;
    p->trial->relmse += p->passes * relmse;
    p->trial->clamp.relmse += p->passes * clamped;
    rf_keep_worst_cell( p->trial->worst, p->passes * relmse );
    p->pixels += count;
    return relmse;
}

// ½ squared change of the difference since the frame before, over the mean of both denominators, summed over a cell.
static double change_of_cell( const TrialPair* p, int32_t slot, int32_t slot_before, int count )
{
    const float *now = colors_of( p, slot ), *before = colors_of( p, slot_before );
    const float *weight = p->weight + RF_CELL_PIXELS * (size_t)slot,
                *weight_before = p->weight + RF_CELL_PIXELS * (size_t)slot_before;
    double sum = 0.0;
    for ( int i = 0; i < 3 * count; ++i )
    {
        double change = (double)now[i] - (double)before[i];
        double below = 0.5 / (double)weight[i / 3] + 0.5 / (double)weight_before[i / 3];
        sum += 0.5 * change * change / below;
    }
    return sum;
}

// Frame callback of the second render: subtracts the frame and accumulates the sums.
static RfResult compare_second( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    TrialPair* p = user;
    int cells = p->pieces->across * p->pieces->down;
    const int32_t* slot = rf_frame_slots( p->pieces, p->first + frame->frame );
    const int32_t* before = frame->frame > 0 ? slot - cells : NULL;
    int32_t pixel[RF_CELL_PIXELS];
    double square = 0.0, step = 0.0, all = 0.0, shared = 0.0;
    for ( int cell = 0; cell < cells; ++cell )
    {
        if ( slot[cell] < 0 )
            continue;
        int count = rf_cell_pixels( p->pieces, cell, pixel );
        square += subtract_cell( p, frame, slot[cell], count, pixel );
        all += count;
        if ( before == NULL || before[cell] < 0 )
            continue;
        step += change_of_cell( p, slot[cell], before[cell], count );
        shared += count;
    }
    p->trial->clamp.threshold += frame->clamp;
    p->trial->clamp.frames += 1.0;
    double mean = all > 0.0 ? square / ( 3.0 * all ) : 0.0;
    p->first_mean = frame->frame == 0 ? mean : p->first_mean;
    p->last_mean = frame->frame == p->eyes - 1 ? mean : p->last_mean;
    p->steps += shared > 0.0 ? step / ( 3.0 * shared ) : 0.0;
    p->step_count += shared > 0.0;
    return RF_OK;
}

// The mean over the frames. Consecutive frames of a long path share all groups but one each: in the first, frame t has
// the first position of the group that frame t−1 is not in; in the other, frame t−1 has the
// last position. In all shared groups they are neighbours. So the mean square of e_t − e_{t−1}
// combines the steps between neighbouring positions with both end positions. If one group is
// the whole path, there are only the steps. NaN if no pixel is measured in two consecutive frames.
static double change_of( const TrialPair* p )
{
    double ends = 0.5 * ( p->first_mean + p->last_mean ), step = p->step_count > 0 ? p->steps / p->step_count : (double)NAN;
    if ( p->eyes == 1 )
        return ends;
    return p->whole ? 0.5 * step : ( ends + 0.5 * step * ( p->eyes - 1 ) ) / p->eyes;
}

static void end_pair( const TrialPair* p )
{
    double change = change_of( p );
    p->trial->groups += 1;
    p->trial->weight += p->pixels;
    p->trial->log_passes += p->pixels * log( p->passes );
    p->trial->change_weight += change == change ? p->pixels : 0.0;
    p->trial->change += change == change ? p->passes * p->pixels * change : 0.0;
}

#define PILOT_PASSES 2
#define MAX_PILOT_PASSES 8 // when smaller groups contribute fewer samples per frame

static int clamp( int value, int low, int high ) { return value < low ? low : value > high ? high : value; }

// Brightness of the pixels of a cell; a pixel that is not traced counts as the nearest one of the cell.
static void cell_brightness( const RfTestRegion* region, const RfFrameResult* frame, const RfBlock* cell,
                             RfBlockValues brightness )
{
    RfPieces pieces = rf_pieces_from( &region->pieces, frame->frame );
    RfBlockValues grey;
    int width = frame->width, reach = RF_BRIGHTNESS_REACH;
    for ( int j = 0; j < cell->bottom - cell->top + 2 * reach; ++j )
    {
        for ( int i = 0; i < cell->right - cell->left + 2 * reach; ++i )
        {
            size_t pixel = rf_block_pixel( width, frame->height, cell, i, j );
            int x = (int)( pixel % (size_t)width ), y = (int)( pixel / (size_t)width );
            if ( region->pieces.traced != NULL && !rf_is_traced( &pieces, pieces.cells, x, y ) )
                pixel = (size_t)clamp( y, cell->top, cell->bottom - 1 ) * (size_t)width +
                        (size_t)clamp( x, cell->left, cell->right - 1 );
            grey[j * RF_BRIGHTNESS_ROOM + i] = rf_mean_of_channels( frame->rgb + 3 * pixel );
        }
    }
    rf_block_brightness( width, frame->height, cell, grey, brightness );
}

static RfResult keep_weights( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    RfTestRegion* region = user;
    const RfTestPieces* pieces = &region->pieces;
    const int32_t* slot = rf_frame_slots( pieces, frame->frame );
    int32_t pixel[RF_CELL_PIXELS];
    for ( int cell = 0; cell < pieces->across * pieces->down; ++cell )
    {
        int pixels = slot[cell] >= 0 ? rf_cell_pixels( pieces, cell, pixel ) : 0;
        if ( pixels == 0 )
            continue;
        RfBlock block = { pixel[0] % frame->width, pixel[0] / frame->width, pixel[pixels - 1] % frame->width + 1,
                          pixel[pixels - 1] / frame->width + 1 };
        RfBlockValues brightness;
        cell_brightness( region, frame, &block, brightness );
        for ( int k = 0; k < pixels; ++k )
        {
            int x = pixel[k] % frame->width - block.left, y = pixel[k] / frame->width - block.top;
            region->weight[RF_CELL_PIXELS * (size_t)slot[cell] + (size_t)k] =
                (float)( 1.0 / rf_relmse_denominator( brightness[y * RF_BRIGHTNESS_ROOM + x] ) );
        }
    }
    return RF_OK;
}

static bool pilot_fits( const RfTracer* tracer, const RfTestRegion* region, const RfRenderSettings* settings )
{
    RfRenderSettings s = *settings;
    RfMemoryFit fit;
    s.threads = 1;
    RfShot group = { tracer, region->eyes, region->frames, NULL, region->frames };
    RfResult result = rf_fit_memory( &group, &s, &fit, NULL );
    return result == RF_OK && fit.sweeps == 1;
}

// Settings for the pilot image: all frames as one group, so that every frame uses the samples
// of all, with tiles. If memory is short, no tiles or smaller groups, since the settings to be
// tried may need less memory than that; at worst path tracing, which needs the least.
static void choose_pilot_settings( const RfTracer* tracer, const RfTestRegion* region, RfRenderSettings* s )
{
    RfTile tiles[2] = { { RF_TILE_BLOCK, 3, 3 }, rf_no_tile() };
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

static RfResult render_pilot( RfTestRegion* region, const RfRenderSettings* settings, RfError* error )
{
    RfRenderSettings s = *settings;
    s.weights = RF_WEIGHTS_EXACT;
    s.normalize = RF_NORMALIZE_CROSSFIT;
    s.aovs = 0;
    s.light_groups = NULL;
    s.clamp = s.clamp_chains = 0.0;
    s.queue = 0;
    s.adaptive = RF_ADAPTIVE_OFF;
    s.seed = rf_mix64( settings->seed ^ rf_mix64( (uint64_t)region->first ) ) ^ 0x5175ull;
    choose_pilot_settings( region->shot.tracer, region, &s );
    RfPieces pieces = rf_pieces_from( &region->pieces, 0 );
    s.pieces = region->pieces.traced != NULL ? &pieces : NULL;
    TrialMeter meter;
    RfResult result = render_metered( region, 0, region->frames, &s, keep_weights, region, &meter, error );
    region->seconds = meter.all_cpu;
    region->samples = meter.all_samples;
    return result;
}

// Parts of the pictures, or the whole of them where the estimator renders no parts.
static RfResult choose_pieces( RfTestRegion* region, int centre, double pixels, const RfRenderSettings* settings, RfError* error )
{
    uint64_t seed = rf_mix64( settings->seed ) ^ (uint64_t)centre;
    if ( !rf_can_render_pieces( settings ) )
    {
        RfResult result = rf_choose_crops( region->eyes, region->frames, pixels, seed, &region->crops, &region->pieces, error );
        if ( result != RF_OK || region->crops != NULL )
            return result;
        pixels = (double)region->eyes->width * region->eyes->height;
    }
    return rf_choose_pieces( region->shot.tracer, region->eyes, region->frames, centre - region->first, pixels,
                             !rf_is_plain_filter( settings ), seed, &region->pieces, error );
}

RfResult rf_create_test_region( const RfShot* shot, const RfTrialWatch* watch, const RfTestSite* site,
                                const RfRenderSettings* settings, RfTestRegion* region, RfError* error )
{
    *region = ( RfTestRegion ){ .shot = *shot, .watch = watch, .frames = site->frames };
    RfGroupPlan plan = rf_plan_shots( shot->eyes, shot->eye_count, 0, 1 );
    rf_frames_around( &plan, site->centre, &region->first, &region->frames );
    int most = clamp( site->frames, 1, shot->eye_count );
    if ( region->frames < most ) // of several shots
    {
        region->frames = most;
        region->first = clamp( site->centre - most / 2, 0, shot->eye_count - most );
    }
    region->whole = region->frames == shot->eye_count;
    region->eyes = shot->eyes + region->first;
    RfResult result = choose_pieces( region, site->centre, site->pixels, settings, error );
    if ( region->crops != NULL )
    {
        region->eyes = region->crops;
        region->frames = RF_CROPS;
        region->whole = false;
    }
    if ( result != RF_OK )
        return result;
    size_t slots = (size_t)region->pieces.first_slot[region->frames];
    region->weight = malloc( ( slots + 1 ) * RF_CELL_PIXELS * sizeof *region->weight );
    if ( region->weight == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory trying settings on %d frames", region->frames );
    return render_pilot( region, settings, error );
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

static RfResult try_group( const RfTestRegion* region, int first, const RfRenderSettings* settings, TrialPair* pair,
                           RfError* error )
{
    RfTrial* trial = pair->trial;
    double seconds[2];
    RfPieces pieces = rf_pieces_from( &region->pieces, first );
    begin_pair( pair, first );
    for ( int twin = 0; twin < 2; ++twin )
    {
        RfRenderSettings s = *settings;
        s.seed = group_seed( settings->seed, region->first + first, twin );
        s.pieces = region->pieces.traced != NULL ? &pieces : NULL;
        TrialMeter meter;
        RfResult result =
            render_metered( region, first, pair->eyes, &s, twin == 0 ? keep_first : compare_second, pair, &meter, error );
        if ( result != RF_OK )
            return result;
        trial->samples += meter.all_samples;
        trial->timed_samples += meter.samples;
        trial->cpu_seconds += meter.cpu;
        trial->finish_seconds += meter.finish_cpu;
        trial->finish_pixels += region->pieces.pixels * pair->eyes;
        seconds[twin] = meter.cpu / meter.samples;
    }
    double noise = log( seconds[0] / seconds[1] );
    trial->time_noise += isfinite( noise ) ? noise * noise : 0.0;
    trial->time_count += 1;
    end_pair( pair );
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

RfResult rf_run_trial( const RfTestRegion* region, int groups, int passes, const RfRenderSettings* settings, RfTrial* trial,
                       RfError* error )
{
    *trial = ( RfTrial ){ .piece_count = region->pieces.count };
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
    s.aovs = ( s.aovs & RF_PASS_AOVS ) | ( s.clamp != 0.0 ? RF_AOV_BIT( RF_AOV_REMOVED ) : 0u );
    s.queue = 0;
    TrialPair pair = { .trial = trial,
                       .passes = passes,
                       .eyes = eyes,
                       .whole = region->whole && eyes == region->frames,
                       .pieces = &region->pieces,
                       .weight = region->weight };
    size_t values = ( most_slots( &region->pieces, eyes ) + 1 ) * 3 * RF_CELL_PIXELS;
    pair.rgb = malloc( ( s.clamp != 0.0 ? 2 : 1 ) * values * sizeof( float ) );
    pair.removed = s.clamp != 0.0 && pair.rgb != NULL ? pair.rgb + values : NULL;
    if ( pair.rgb == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory trying groups of %d frames", eyes );
    RfResult result = RF_OK;
    for ( int w = 0; w < count && result == RF_OK; ++w )
        result = try_group( region, first + w * eyes, &s, &pair, error );
    free( pair.rgb );
    return result;
}

void rf_add_weighed_trial( RfTrial* sum, const RfTrial* trial, double weight, int first )
{
    sum->groups += trial->groups;
    sum->samples += trial->samples;
    sum->timed_samples += trial->timed_samples;
    sum->cpu_seconds += trial->cpu_seconds;
    sum->finish_seconds += trial->finish_seconds;
    sum->finish_pixels += trial->finish_pixels;
    sum->time_noise += trial->time_noise;
    sum->time_count += trial->time_count;
    sum->clamp.threshold += trial->clamp.threshold;
    sum->clamp.frames += trial->clamp.frames;
    sum->weight += weight * trial->weight;
    sum->log_passes += weight * trial->log_passes;
    sum->relmse += weight * trial->relmse;
    sum->change_weight += weight * trial->change_weight;
    sum->change += weight * trial->change;
    sum->clamp.relmse += weight * trial->clamp.relmse;
    sum->clamp.bias += weight * trial->clamp.bias;
    sum->clamp.removed += weight * trial->clamp.removed;
    sum->clamp.light += weight * trial->clamp.light;
    for ( int k = 0; k < RF_WORST_CELLS; ++k )
        rf_keep_worst_cell( sum->worst, weight * trial->worst[k] );
    int end = first + trial->piece_count < RF_TRIAL_PIECES ? first + trial->piece_count : RF_TRIAL_PIECES;
    for ( int i = first; i < end; ++i )
    {
        const RfPieceError* piece = trial->pieces + ( i - first );
        sum->pieces[i].weight += weight * piece->weight;
        sum->pieces[i].relmse += weight * piece->relmse;
        sum->pieces[i].clamped += weight * piece->clamped;
    }
    sum->piece_count = end > sum->piece_count ? end : sum->piece_count;
}

void rf_add_trial( RfTrial* sum, const RfTrial* trial ) { rf_add_weighed_trial( sum, trial, 1.0, sum->piece_count ); }

// NaN where nothing was measured.
static double mean( double sum, double count ) { return count > 0.0 ? sum / count : (double)NAN; }

double rf_trial_relmse( const RfTrial* trial, double spp ) { return mean( trial->relmse, trial->weight ) / spp; }

double rf_trial_passes( const RfTrial* trial ) { return exp( mean( trial->log_passes, trial->weight ) ); }

static double mean_change( const RfTrial* trial ) { return mean( trial->change, trial->change_weight ); }

double rf_trial_f1( const RfTrial* trial, double spp ) { return sqrt( 2.0 * mean_change( trial ) / spp ); }

double rf_trial_phi( const RfTrial* trial )
{
    return isgreater( trial->relmse, 0.0 ) ? 3.0 * mean_change( trial ) * trial->weight / trial->relmse : 0.0;
}

double rf_trial_sample_seconds( const RfTrial* trial ) { return mean( trial->cpu_seconds, trial->timed_samples ); }

size_t rf_test_region_bytes( int frames, size_t pixels )
{
    return (size_t)frames * pixels * sizeof( float ) + rf_test_pieces_bytes( frames, pixels );
}

size_t rf_trial_bytes( int eyes, size_t pixels ) { return 3 * (size_t)eyes * pixels * sizeof( float ); }

// Where the ten worst pixels hold 30 % of an error, 19 of 20 errors are below twice what is seen (render/README.md, "At
// least"): rarer and larger ones have not been hit yet. So much is added to the margin of the error's logarithm, in
// proportion to the share that the worst cells hold.
#define TAIL_MARGIN ( 0.693147 / 0.3 )

#define TIME_NOISE 0.03 // the least standard deviation of the logarithm of seconds per sample

// Sums over the pieces that are common to both.
typedef struct Sums
{
    double weight[2], relmse[2];
} Sums;

static Sums sum_pieces( const RfTrial* const trials[2], int count )
{
    Sums s = { { 0.0, 0.0 }, { 0.0, 0.0 } };
    for ( int i = 0; i < count; ++i )
    {
        for ( int t = 0; t < 2; ++t )
        {
            s.weight[t] += trials[t]->pieces[i].weight;
            s.relmse[t] += trials[t]->pieces[i].relmse;
        }
    }
    return s;
}

// Share of a piece in the relMSE of a trial, less that in its pixels.
static double influence_on( const RfTrial* trial, int i, double weight, double relmse )
{
    return trial->pieces[i].relmse / relmse - trial->pieces[i].weight / weight;
}

static double time_variance( const RfTrial* trial )
{
    double variance = trial->time_count > 0 ? trial->time_noise / ( 4.0 * trial->time_count * trial->time_count ) : 0.0;
    return fmax( variance, TIME_NOISE * TIME_NOISE );
}

double rf_trial_time_margin( const RfTrial* trial ) { return 1.96 * sqrt( time_variance( trial ) ); }

static double tail_margin( const RfTrial* trial )
{
    double worst = 0.0;
    for ( int k = 0; k < RF_WORST_CELLS; ++k )
        worst += trial->worst[k];
    return isgreater( trial->relmse, 0.0 ) ? TAIL_MARGIN * worst / trial->relmse : 0.0;
}

RfInterval rf_trial_gain( const RfTrial* plain, const RfTrial* reuse )
{
    const RfTrial* trials[2] = { plain, reuse };
    double influence[RF_TRIAL_PIECES];
    int count = plain->piece_count < reuse->piece_count ? plain->piece_count : reuse->piece_count;
    Sums s = sum_pieces( trials, count );
    // cost times both weights
    double plain_cost = s.relmse[0] * s.weight[1] * rf_trial_sample_seconds( plain );
    double reuse_cost = s.relmse[1] * s.weight[0] * rf_trial_sample_seconds( reuse );
    if ( !isgreater( plain_cost, 0.0 ) || !isgreater( reuse_cost, 0.0 ) || isinf( plain_cost ) || isinf( reuse_cost ) )
        return ( RfInterval ){ (double)NAN, (double)NAN, (double)NAN };
    double value = plain_cost / reuse_cost;
    for ( int i = 0; i < count; ++i )
        influence[i] = influence_on( plain, i, s.weight[0], s.relmse[0] ) - influence_on( reuse, i, s.weight[1], s.relmse[1] );
    double margin = rf_influence_margin( influence, count, time_variance( plain ) + time_variance( reuse ) );
    double plain_tail = tail_margin( plain ), reuse_tail = tail_margin( reuse );
    return rf_log_interval( value, sqrt( margin * margin + plain_tail * plain_tail + reuse_tail * reuse_tail ) );
}

RfInterval rf_trial_error( const RfTrial* trial )
{
    double influence[RF_TRIAL_PIECES], value = rf_trial_relmse( trial, 1.0 );
    const RfTrial* const same[2] = { trial, trial };
    Sums s = sum_pieces( same, trial->piece_count );
    if ( !isgreater( value, 0.0 ) || isinf( value ) )
        return ( RfInterval ){ (double)NAN, (double)NAN, (double)NAN };
    for ( int i = 0; i < trial->piece_count; ++i )
        influence[i] = influence_on( trial, i, s.weight[0], s.relmse[0] );
    double margin = rf_influence_margin( influence, trial->piece_count, 0.0 ), tail = tail_margin( trial );
    return rf_log_interval( value, sqrt( margin * margin + tail * tail ) );
}

RfInterval rf_trial_clamped_error( const RfTrial* trial )
{
    RfTrial clamped = *trial; // what has been clamped has no tail
    clamped.relmse = trial->clamp.relmse;
    memset( clamped.worst, 0, sizeof clamped.worst );
    for ( int i = 0; i < trial->piece_count; ++i )
        clamped.pieces[i].relmse = trial->pieces[i].clamped;
    return rf_trial_error( &clamped );
}
