#include "measure/spectrum.h"

#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

typedef struct Group
{
    int count;
    const RfFlickerFrame* const* frames;
    RfFollow follow[RF_SPECTRUM_FRAMES];                    // [t]: from frame t to t − 1
    double cosines[RF_SPECTRUM_FRAMES][RF_SPECTRUM_FRAMES]; // [k][t], including s_k
} Group;

bool rf_ends_group( int index, int count )
{
    int end = index + 1;
    return end == count || ( end >= RF_SPECTRUM_FRAMES && ( end - RF_SPECTRUM_FRAMES ) % RF_SPECTRUM_STEP == 0 );
}

static void fill_cosines( Group* group )
{
    int n = group->count;
    for ( int k = 0; k < n; ++k )
    {
        for ( int t = 0; t < n; ++t )
            group->cosines[k][t] = sqrt( ( k == 0 ? 1.0 : 2.0 ) / n ) * cos( PI * ( 2 * t + 1 ) * k / ( 2.0 * n ) );
    }
}

// Collects the values of a pixel through the group; false if it was not visible in all frames.
static bool collect( const Group* group, int column, int row, double series[3][RF_SPECTRUM_FRAMES] )
{
    double x = column, y = row;
    int last = group->count - 1;
    RfTaps taps = { 1, { (size_t)row * (size_t)group->frames[last]->signal.width + (size_t)column }, { 1.0 } };
    for ( int t = last;; --t )
    {
        const float* rgb = group->frames[t]->signal.rgb;
        for ( int c = 0; c < 3; ++c )
        {
            series[c][t] = 0.0;
            for ( int i = 0; i < taps.count; ++i )
                series[c][t] += taps.weight[i] * (double)rgb[3 * taps.pixel[i] + (size_t)c];
        }
        if ( t == 0 )
            return true;
        if ( !rf_follow_point( group->follow + t, &x, &y, &taps ) )
            return false;
    }
}

static void add_series( const Group* group, const double* series, RfSpectrumSums* sums )
{
    for ( int k = 0; k < group->count; ++k )
    {
        double x = 0.0;
        for ( int t = 0; t < group->count; ++t )
            x += group->cosines[k][t] * series[t];
        double power = x * x / group->count, frequency = k / ( 2.0 * group->count );
        double* band = k == 0 ? &sums->frozen : frequency <= RF_SPECTRUM_SPLIT ? &sums->drift : &sums->boiling;
        *band += power;
    }
}

static void add_row( const Group* group, int y, RfSpectrumSums* sums )
{
    int width = group->frames[0]->signal.width;
    double series[3][RF_SPECTRUM_FRAMES];
    for ( int x = 0; x < width; ++x )
    {
        if ( !collect( group, x, y, series ) )
            continue;
        for ( int c = 0; c < 3; ++c )
            add_series( group, series[c], sums );
        sums->pixels += 1.0;
    }
    sums->all_pixels += width;
}

static void add_sums( RfSpectrumSums* sums, const RfSpectrumSums* more )
{
    sums->pixels += more->pixels;
    sums->all_pixels += more->all_pixels;
    sums->frozen += more->frozen;
    sums->drift += more->drift;
    sums->boiling += more->boiling;
}

RfResult rf_add_spectrum_group( RfSpectrumSums* sums, const RfFlickerFrame* const* frames, int count, bool compensate,
                                RfError* error )
{
    if ( count < 2 || count > RF_SPECTRUM_FRAMES )
        return rf_fail( error, RF_ERROR_USAGE, "a spectrum of %d frames is not possible: use 2 to %d", count,
                        RF_SPECTRUM_FRAMES );
    Group group = { .count = count, .frames = frames };
    fill_cosines( &group );
    bool finite = frames[0]->is_finite;
    for ( int t = 1; t < count; ++t )
    {
        finite = finite && frames[t]->is_finite;
        group.follow[t] = rf_follow( frames[t], frames[t - 1], compensate );
    }
    int height = frames[0]->signal.height;
    RfSpectrumSums* rows = calloc( (size_t)height, sizeof *rows );
    if ( rows == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left to measure %d rows", height );
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < height; ++y )
    {
        rf_set_float_mode();
        add_row( &group, y, rows + y );
    }
    for ( int y = 0; y < height; ++y )
        add_sums( sums, rows + y );
    free( rows );
    sums->groups += 1;
    if ( 1.0 / ( 2.0 * count ) > RF_SPECTRUM_SPLIT ) // the slow band contains no coefficient
        sums->drift = NAN;
    if ( !finite )
        sums->frozen = sums->drift = sums->boiling = NAN;
    return RF_OK;
}

RfSpectrum rf_spectrum( const RfSpectrumSums* sums )
{
    RfSpectrum spectrum = { NAN, NAN, NAN, 0.0 };
    if ( sums->all_pixels > 0.0 )
        spectrum.coverage = sums->pixels / sums->all_pixels;
    if ( !( sums->pixels > 0.0 ) )
        return spectrum;
    double values = 3.0 * sums->pixels;
    spectrum.frozen = sqrt( sums->frozen / values );
    spectrum.drift = sqrt( sums->drift / values );
    spectrum.boiling = sqrt( sums->boiling / values );
    return spectrum;
}
