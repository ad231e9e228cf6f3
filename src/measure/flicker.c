#include "measure/flicker.h"

#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

typedef struct Pair
{
    RfFollow follow;
    bool has_error;
} Pair;

static double variance_at( const RfFlickerFrame* frame, const RfTaps* taps, int channel )
{
    double sum = 0.0;
    for ( int k = 0; k < taps->count; ++k )
        sum += taps->weight[k] * taps->weight[k] * (double)frame->variance.rgb[3 * taps->pixel[k] + (size_t)channel];
    return sum;
}

static void add_pixel( const Pair* pair, size_t pixel, const RfTaps* taps, RfFlickerSums* sums )
{
    const RfFlickerFrame *now = pair->follow.now, *before = pair->follow.before;
    for ( int c = 0; c < 3; ++c )
    {
        double a = (double)now->signal.rgb[3 * pixel + (size_t)c], b = 0.0;
        for ( int k = 0; k < taps->count; ++k )
            b += taps->weight[k] * (double)before->signal.rgb[3 * taps->pixel[k] + (size_t)c];
        sums->difference += ( a - b ) * ( a - b );
        if ( pair->has_error )
            sums->square += a * a + b * b;
        else if ( now->variance.rgb != NULL && before->variance.rgb != NULL )
            sums->square += (double)now->variance.rgb[3 * pixel + (size_t)c] + variance_at( before, taps, c );
    }
    sums->pixels += 1.0;
}

static void add_row( const Pair* pair, int y, RfFlickerSums* sums )
{
    int width = pair->follow.now->signal.width;
    for ( int x = 0; x < width; ++x )
    {
        double px = x, py = y;
        RfTaps taps;
        if ( !rf_follow_point( &pair->follow, &px, &py, &taps ) )
            continue;
        add_pixel( pair, (size_t)y * (size_t)width + (size_t)x, &taps, sums );
        sums->motion += hypot( px - x, py - y );
    }
    sums->all_pixels += width;
}

RfResult rf_measure_flicker( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error,
                             RfFlickerSums* sums, RfError* error )
{
    *sums = ( RfFlickerSums ){ 0 };
    int height = now->signal.height;
    if ( now->signal.width != before->signal.width || height != before->signal.height )
        return rf_fail( error, RF_ERROR_FORMAT, "frame %d has %dx%d pixels, frame %d %dx%d", now->number, now->signal.width,
                        height, before->number, before->signal.width, before->signal.height );
    if ( compensate && now->motion == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "frame %d has no motion layer to compensate with", now->number );
    RfFlickerSums* rows = calloc( (size_t)height, sizeof *rows );
    if ( rows == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left to measure %d rows", height );
    Pair pair = { rf_follow( now, before, compensate ), has_error };
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < height; ++y )
    {
        rf_set_float_mode();
        add_row( &pair, y, rows + y );
    }
    for ( int y = 0; y < height; ++y )
        rf_add_flicker( sums, rows + y );
    free( rows );
    sums->pairs = 1;
    if ( !has_error && ( now->variance.rgb == NULL || before->variance.rgb == NULL ) )
        sums->square = NAN;
    if ( !compensate )
        sums->motion = NAN;
    if ( !now->is_finite || !before->is_finite )
        sums->difference = sums->square = NAN;
    return RF_OK;
}

void rf_add_flicker( RfFlickerSums* sums, const RfFlickerSums* more )
{
    sums->pairs += more->pairs;
    sums->pixels += more->pixels;
    sums->all_pixels += more->all_pixels;
    sums->motion += more->motion;
    sums->difference += more->difference;
    sums->square += more->square;
}

static double find_phi( const RfFlickerSums* sums )
{
    if ( isgreater( sums->square, 0.0 ) && isfinite( sums->square ) )
        return sums->difference / sums->square;
    return sums->square == 0.0 && sums->difference == 0.0 ? 0.0 : NAN;
}

RfFlickerMetrics rf_flicker_metrics( const RfFlickerSums* sums )
{
    RfFlickerMetrics metrics = { NAN, NAN, NAN, 0.0, NAN };
    if ( sums->all_pixels > 0.0 )
        metrics.coverage = sums->pixels / sums->all_pixels;
    if ( !( sums->pixels > 0.0 ) )
        return metrics;
    metrics.f1 = sqrt( sums->difference / ( 3.0 * sums->pixels ) );
    metrics.phi = find_phi( sums );
    metrics.mse = sums->square / ( 6.0 * sums->pixels );
    metrics.motion = sums->motion / sums->pixels;
    return metrics;
}
