// What denoised pictures cost: windows of whole frames are rendered and denoised, since a denoiser needs what is around a pixel.
#include "base/system.h"
#include "base/try.h"
#include "measure/cost.h"
#include "measure/trial_pieces.h"
#include "render/groups.h"

#include <math.h>
#include <stdlib.h>

#define WINDOWS 3
#define LEAST_SIDE 96.0 // of a window, or the frame's
#define SAMPLES 16      // of each, or what a group needs
#define MOST_SAMPLES 256
#define MARGIN 64 // pixels that a denoiser looks at beside a picture, both sides

typedef struct Study
{
    const RfCostJob* job;
    RfDenoiser* denoiser;
    RfDenoisedCost* cost;
    RfDenoisedSums sums;
    double exponents, padded, seconds;
    int windows;
} Study;

static RfResult take_frame( void* user, const RfFrameResult* frame, RfError* error )
{
    Study* s = user;
    RfDenoised denoised;
    const RfNoisyFrame noisy = rf_noisy_frame( frame );
    double start = rf_wall_seconds(), pixels = (double)frame->width * frame->height;
    float* rgb = malloc( 3 * sizeof( float ) * (size_t)pixels );
    RfResult result = rgb != NULL ? rf_denoise( s->denoiser, &noisy, rgb, &denoised, &s->sums, error )
                                  : rf_fail( error, RF_ERROR_MEMORY, "out of memory for a denoised window" );
    free( rgb );
    if ( result != RF_OK )
        return result;
    s->seconds += rf_wall_seconds() - start;
    s->padded += (double)( frame->width + MARGIN ) * ( frame->height + MARGIN );
    s->exponents += isfinite( denoised.exponent ) ? denoised.exponent : 1.0;
    s->cost->pixels += pixels;
    s->cost->spp = (int)( frame->native_spp + 0.5 );
    s->windows += 1;
    return RF_OK;
}

static bool may_go_on( void* user, const RfProgress* progress )
{
    const RfTrialWatch* watch = ( (Study*)user )->job->watch;
    (void)progress;
    return watch == NULL || watch->should_continue == NULL || watch->should_continue( watch->user );
}

// Window `k` of a frame, of so many pixels; the same place in all frames of the path.
static RfResult render_window( Study* s, const RfCostCurve* curve, int k, int width, int height, int spp, RfError* error )
{
    static const double s_places[WINDOWS][2] = { { 0.5, 0.5 }, { 0.15, 0.8 }, { 0.85, 0.25 } };
    const RfShot* shot = &s->job->shot;
    int frame = shot->frames[(int)( ( k + 0.5 ) / WINDOWS * shot->frame_count )];
    RfRenderSettings settings = rf_trial_settings( s->job->settings );
    RfRenderCallbacks callbacks = { .user = s, .frame = take_frame, .progress = may_go_on };
    RfEye* eyes = malloc( (size_t)shot->eye_count * sizeof *eyes );
    if ( eyes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the cameras of %d frames", shot->eye_count );
    int x = (int)( s_places[k][0] * ( shot->eyes->width - width ) ),
        y = (int)( s_places[k][1] * ( shot->eyes->height - height ) );
    for ( int i = 0; i < shot->eye_count; ++i )
        eyes[i] = rf_crop_eye( shot->eyes + i, x, y, width, height );
    settings.estimator =
        curve->group == 0 && curve->tile.kind == RF_TILE_NONE ? rf_default_render_settings().estimator : settings.estimator;
    settings.group = curve->group;
    settings.tile = curve->tile;
    settings.spp = spp;
    settings.aovs = RF_DENOISE_AOVS | RF_AOV_BIT( RF_AOV_HALF );
    settings.light_groups = NULL;
    settings.cryptomatte = 0;
    settings.queue = 0;
    const RfShot window = { shot->tracer, eyes, shot->eye_count, &frame, 1 };
    RfResult result = rf_render( &window, &settings, &callbacks, NULL, error );
    free( eyes );
    return result;
}

// Frames times samples per pixel that one frame takes with those beside it.
static double samples_of( const RfCostJob* job, const RfCostCurve* curve, int spp )
{
    RfGroupPlan plan = rf_plan_shots( job->shot.eyes, job->shot.eye_count, curve->group, spp );
    int frame = job->shot.frames[job->shot.frame_count / 2];
    double samples = 0.0, others = 0.0;
    rf_add_group_samples( &plan, &frame, 0, 1, &samples, &others );
    return samples;
}

RfResult rf_measure_denoised_cost( const RfCostJob* job, const RfCostCurve* curve, RfDenoiser* denoiser, double budget,
                                   RfDenoisedCost* cost, RfError* error )
{
    Study s = { .job = job, .denoiser = denoiser, .cost = cost };
    int width = job->shot.eyes->width, height = job->shot.eyes->height, spp = SAMPLES, windows = WINDOWS;
    double all = (double)width * height, least = fmin( LEAST_SIDE * LEAST_SIDE, all ), aspect = (double)width / height;
    double each = samples_of( job, curve, spp ) * curve->sample_seconds; // seconds a pixel
    *cost = ( RfDenoisedCost ){ .needed = each * least, .error = { (double)NAN, (double)NAN, (double)NAN, false } };
    while ( windows > 1 && budget < each * least * windows )
        windows -= 1;
    if ( !( budget >= cost->needed ) )
        return RF_OK;
    double pixels = fmin( budget / ( each * windows ), all );
    while ( 2 * spp <= MOST_SAMPLES && samples_of( job, curve, 2 * spp ) * curve->sample_seconds * pixels * windows < budget )
        spp *= 2;
    int across = (int)fmin( ceil( sqrt( pixels * aspect ) ), width ), down = (int)fmin( ceil( pixels / across ), height );
    RfResult result = RF_OK;
    for ( int k = 0; k < windows && result == RF_OK; ++k )
        result = render_window( &s, curve, k, across, down, spp, error );
    if ( result == RF_OK )
    {
        cost->error = rf_denoised_error( &s.sums );
        cost->exponent = s.exponents / s.windows;
        cost->seconds = s.seconds / s.padded * (double)( width + MARGIN ) * ( height + MARGIN );
    }
    rf_free_denoised_sums( &s.sums );
    return result;
}

RfCostPrediction rf_predict_denoised_cost( const RfCostJob* job, const RfCostCurve* curve, const RfDenoisedCost* cost,
                                           double relmse, int per_sweep )
{
    double wanted = cost->spp * pow( cost->error.relmse / relmse, 1.0 / cost->exponent );
    RfCostPrediction p = rf_predict_samples( job, curve, ceil( fmax( wanted, RF_LEAST_DENOISED_PASSES ) ), per_sweep );
    p.tried = 0; // of pictures that are not denoised
    p.frame_seconds += cost->seconds;
    p.seconds += job->shot.frame_count * cost->seconds;
    return p;
}
