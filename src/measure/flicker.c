// Follows points of one frame into the next by depth and motion, and sums the change of their error.
#include "measure/flicker.h"

#include "film/brightness.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

#define FOLLOW_DEPTH_TOLERANCE 0.02
#define FOLLOW_NO_SURFACE 1e9 // depths from here on, infinite, or not above 0 mean: no surface

// Bilinear interpolation: pixels and their weights, which sum to 1; none is 0.
typedef struct Taps
{
    int count;
    size_t pixel[4];
    double weight[4];
} Taps;

#define SLIT_WIDTH 480 // frames are repeated equally often to fill at least about this many pixels

RfResult rf_create_slit_scan( int frames, int height, int parts, RfSlitScan* scan, RfError* error )
{
    *scan = ( RfSlitScan ){ .height = height };
    scan->repeat = frames > 0 && frames < SLIT_WIDTH ? ( SLIT_WIDTH - 1 ) / frames + 1 : 1;
    return rf_create_image( frames * scan->repeat, height * parts, &scan->image, error );
}

void rf_destroy_slit_scan( RfSlitScan* scan )
{
    rf_destroy_image( &scan->image );
    *scan = ( RfSlitScan ){ 0 };
}

void rf_add_slit( RfSlitScan* scan, int frame, int part, const RfImage* image, int column )
{
    size_t width = (size_t)scan->image.width;
    for ( int y = 0; y < scan->height; ++y )
    {
        const float* from = image->rgb + 3 * ( (size_t)y * (size_t)image->width + (size_t)column );
        size_t row = (size_t)part * (size_t)scan->height + (size_t)y;
        float* to = scan->image.rgb + 3 * ( row * width + (size_t)frame * (size_t)scan->repeat );
        for ( int i = 0; i < scan->repeat; ++i )
            memcpy( to + 3 * i, from, 3 * sizeof( float ) );
    }
}

// True if the frame is in full groups only, and in as many as any frame can be.
static bool is_inside( const RfGroupPlan* plan, int frame )
{
    if ( plan->groups == 1 )
        return true;
    if ( frame < 0 || frame >= plan->frames )
        return false;
    int first, last;
    rf_groups_of_frame( plan, frame, &first, &last );
    return last - first + 1 == plan->eyes && rf_group( plan, first ).eyes == plan->eyes &&
           rf_group( plan, last ).eyes == plan->eyes;
}

bool rf_is_seam( const RfSeams* seams, int frame )
{
    int index = frame - seams->first;
    if ( seams->period > 0 )
        return index % seams->period == 0;
    return seams->slides && !( is_inside( &seams->plan, index ) && is_inside( &seams->plan, index - 1 ) );
}

#define FORGIVEN 1e-3 // tolerance, pixels

void rf_destroy_flicker_frame( RfFlickerFrame* frame )
{
    rf_destroy_image( &frame->signal );
    rf_destroy_image( &frame->variance );
    free( frame->below );
    free( frame->motion );
    free( frame->depth );
    *frame = ( RfFlickerFrame ){ 0 };
}

RfResult rf_take_brightness( RfFlickerFrame* frame, const RfImage* picture, RfError* error )
{
    if ( !frame->is_finite ) // nothing is told of it
        return RF_OK;
    frame->below = malloc( (size_t)picture->width * (size_t)picture->height * sizeof *frame->below );
    if ( frame->below == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the brightness of %dx%d pixels", picture->width,
                        picture->height );
    rf_relmse_denominators( picture->rgb, picture->width, picture->height, frame->below );
    return RF_OK;
}

static void cross( const double* a, const double* b, double out[3] )
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot( const double* a, const double* b ) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Expresses the other camera's depth by coordinates of this one. This camera gives (x z, y z,
// z) = C·P + c, and the other's depth is w·P + v. With q from Cᵀ q = w, that depth is q·((x z,
// y z, z) − c) + v.
static bool expect_depth( const double now[3][4], const double before[4], double expect[4] )
{
    double q[3], normal[3];
    cross( now[1], now[2], normal );
    double volume = dot( now[0], normal ), size = 1.0;
    for ( int i = 0; i < 3; ++i )
        size *= sqrt( dot( now[i], now[i] ) );
    if ( !( fabs( volume ) > 1e-9 * size ) || !isfinite( volume ) )
        return false;
    for ( int i = 0; i < 3; ++i )
    {
        cross( now[( i + 1 ) % 3], now[( i + 2 ) % 3], normal );
        q[i] = dot( before, normal ) / volume;
        expect[i] = q[i];
    }
    expect[3] = before[3] - q[0] * now[0][3] - q[1] * now[1][3] - q[2] * now[2][3];
    return isfinite( expect[0] + expect[1] + expect[2] + expect[3] );
}

RfFollow rf_follow( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate )
{
    RfFollow follow = { .now = now, .before = before, .compensate = compensate };
    if ( !now->has_camera || !before->has_camera || !expect_depth( now->camera, before->camera[2], follow.expect ) )
    {
        follow.expect[0] = follow.expect[1] = follow.expect[3] = 0.0;
        follow.expect[2] = 1.0;
    }
    return follow;
}

// Splits a coordinate inside the image into integer and fraction; false outside.
static bool split( double x, int size, int* first, double* rest )
{
    if ( !isgreaterequal( x, -FORGIVEN ) || !islessequal( x, size - 1 + FORGIVEN ) )
        return false;
    x = x < 0.0 ? 0.0 : x > size - 1 ? size - 1 : x;
    *first = (int)x;
    *rest = x - *first;
    return true;
}

// The taps at a point; false outside the frame (with a tolerance of a thousandth of a pixel).
static bool find_taps( int width, int height, double x, double y, Taps* taps )
{
    int column, row;
    double u, v;
    taps->count = 0;
    if ( !split( x, width, &column, &u ) || !split( y, height, &row, &v ) )
        return false;
    for ( int k = 0; k < 4; ++k )
    {
        double weight = ( k & 1 ? u : 1.0 - u ) * ( k & 2 ? v : 1.0 - v );
        if ( weight == 0.0 )
            continue;
        taps->pixel[taps->count] = (size_t)( row + ( k >> 1 ) ) * (size_t)width + (size_t)( column + ( k & 1 ) );
        taps->weight[taps->count++] = weight;
    }
    return true;
}

typedef enum Seen
{
    SEEN_SOMETHING,
    SEEN_NOTHING,
    SEEN_BOTH, // a depth edge between them, or undefined depth
} Seen;

static bool is_background( double z ) { return z >= FOLLOW_NO_SURFACE || z <= 0.0; }

static Seen find_depth( const float* depth, const Taps* taps, double* z )
{
    int nothing = 0;
    *z = 0.0;
    for ( int k = 0; k < taps->count; ++k )
    {
        double value = (double)depth[taps->pixel[k]];
        if ( isnan( value ) )
            return SEEN_BOTH;
        nothing += is_background( value );
        *z += taps->weight[k] * value;
    }
    return nothing == 0 ? SEEN_SOMETHING : nothing == taps->count ? SEEN_NOTHING : SEEN_BOTH;
}

static bool is_same_surface( const RfFollow* follow, double x, double y, const Taps* here, const Taps* there )
{
    if ( follow->now->depth == NULL || follow->before->depth == NULL )
        return true;
    double z, found;
    Seen seen = find_depth( follow->now->depth, here, &z );
    if ( seen == SEEN_BOTH || find_depth( follow->before->depth, there, &found ) != seen )
        return false;
    if ( seen == SEEN_NOTHING )
        return true;
    const double* e = follow->expect;
    double expected = z * ( e[0] * x + e[1] * y + e[2] ) + e[3];
    return fabs( found - expected ) <= FOLLOW_DEPTH_TOLERANCE * expected;
}

// Moves the point to its position in the previous frame and finds the taps there; false if it
// was not visible.
static bool follow_point( const RfFollow* follow, double* x, double* y, Taps* taps )
{
    const RfImage* now = &follow->now->signal;
    const RfImage* before = &follow->before->signal;
    Taps here;
    if ( !follow->compensate )
        return find_taps( before->width, before->height, *x, *y, taps );
    if ( !find_taps( now->width, now->height, *x, *y, &here ) )
        return false;
    double motion[2] = { 0.0, 0.0 };
    for ( int k = 0; k < here.count; ++k )
    {
        motion[0] += here.weight[k] * (double)follow->now->motion[2 * here.pixel[k]];
        motion[1] += here.weight[k] * (double)follow->now->motion[2 * here.pixel[k] + 1];
    }
    double x_before = *x + motion[0], y_before = *y - motion[1];
    if ( !find_taps( before->width, before->height, x_before, y_before, taps ) )
        return false;
    if ( !is_same_surface( follow, *x, *y, &here, taps ) )
        return false;
    *x = x_before;
    *y = y_before;
    return true;
}

#define PI 3.14159265358979323846

typedef struct Group
{
    int count;
    double split; // upper end of the slow band, cycles per frame
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

static double below_at( const RfFlickerFrame* frame, const Taps* taps )
{
    double sum = frame->below != NULL ? 0.0 : 1.0;
    for ( int k = 0; k < taps->count && frame->below != NULL; ++k )
        sum += taps->weight[k] * frame->below[taps->pixel[k]];
    return sum;
}

// Collects the values of a pixel through the group, relative to its mean brightness; false if it was not visible in all frames.
static bool collect( const Group* group, int column, int row, double series[3][RF_SPECTRUM_FRAMES] )
{
    double x = column, y = row, below = 0.0;
    int last = group->count - 1;
    Taps taps = { 1, { (size_t)row * (size_t)group->frames[last]->signal.width + (size_t)column }, { 1.0 } };
    for ( int t = last; t >= 0; --t )
    {
        const float* rgb = group->frames[t]->signal.rgb;
        below += below_at( group->frames[t], &taps );
        for ( int c = 0; c < 3; ++c )
        {
            series[c][t] = 0.0;
            for ( int i = 0; i < taps.count; ++i )
                series[c][t] += taps.weight[i] * (double)rgb[3 * taps.pixel[i] + (size_t)c];
        }
        if ( t > 0 && !follow_point( group->follow + t, &x, &y, &taps ) )
            return false;
    }
    double brightness = sqrt( below / group->count );
    for ( int k = 0; k < 3 * group->count; ++k )
        series[k % 3][k / 3] /= brightness;
    return true;
}

static void add_series( const Group* group, const double* series, RfSpectrumSums* sums )
{
    for ( int k = 0; k < group->count; ++k )
    {
        double x = 0.0;
        for ( int t = 0; t < group->count; ++t )
            x += group->cosines[k][t] * series[t];
        double power = x * x / group->count, frequency = k / ( 2.0 * group->count );
        double* band = k == 0 ? &sums->frozen : frequency <= group->split ? &sums->drift : &sums->boiling;
        *band += power;
    }
}

static void add_spectrum_row( const Group* group, int y, RfSpectrumSums* sums )
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

RfResult rf_add_spectrum_group( RfSpectrumSums* sums, const RfFlickerFrame* const* frames, int count, double split,
                                bool compensate, RfError* error )
{
    if ( count < 2 || count > RF_SPECTRUM_FRAMES )
        return rf_fail( error, RF_ERROR_USAGE, "a spectrum of %d frames is not possible: use 2 to %d", count,
                        RF_SPECTRUM_FRAMES );
    if ( rf_is_cut( frames[count - 1], frames[0] ) )
        return RF_OK;
    Group group = { .count = count, .split = split, .frames = frames };
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
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory measuring %d rows", height );
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < height; ++y )
    {
        rf_set_float_mode();
        add_spectrum_row( &group, y, rows + y );
    }
    for ( int y = 0; y < height; ++y )
        add_sums( sums, rows + y );
    free( rows );
    sums->groups += 1;
    if ( 1.0 / ( 2.0 * count ) > split ) // the slow band contains no coefficient
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

typedef struct Pair
{
    RfFollow follow;
    bool has_error;
} Pair;

static double variance_at( const RfFlickerFrame* frame, const Taps* taps, int channel )
{
    double sum = 0.0;
    for ( int k = 0; k < taps->count; ++k )
        sum += taps->weight[k] * taps->weight[k] * (double)frame->variance.rgb[3 * taps->pixel[k] + (size_t)channel];
    return sum;
}

static void add_pixel( const Pair* pair, size_t pixel, const Taps* taps, RfFlickerSums* sums )
{
    const RfFlickerFrame *now = pair->follow.now, *before = pair->follow.before;
    double below = 0.5 * ( ( now->below != NULL ? now->below[pixel] : 1.0 ) + below_at( before, taps ) );
    for ( int c = 0; c < 3; ++c )
    {
        double a = (double)now->signal.rgb[3 * pixel + (size_t)c], b = 0.0;
        for ( int k = 0; k < taps->count; ++k )
            b += taps->weight[k] * (double)before->signal.rgb[3 * taps->pixel[k] + (size_t)c];
        sums->difference += ( a - b ) * ( a - b );
        sums->relative += ( a - b ) * ( a - b ) / below;
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
        Taps taps;
        if ( !follow_point( &pair->follow, &px, &py, &taps ) )
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
    if ( rf_is_cut( now, before ) )
        return RF_OK;
    RfFlickerSums* rows = calloc( (size_t)height, sizeof *rows );
    if ( rows == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory measuring %d rows", height );
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
        sums->difference = sums->relative = sums->square = NAN;
    return RF_OK;
}

void rf_add_flicker( RfFlickerSums* sums, const RfFlickerSums* more )
{
    sums->pairs += more->pairs;
    sums->pixels += more->pixels;
    sums->all_pixels += more->all_pixels;
    sums->motion += more->motion;
    sums->difference += more->difference;
    sums->relative += more->relative;
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
    RfFlickerMetrics metrics = { NAN, NAN, NAN, NAN, 0.0, NAN };
    if ( sums->all_pixels > 0.0 )
        metrics.coverage = sums->pixels / sums->all_pixels;
    if ( !( sums->pixels > 0.0 ) )
        return metrics;
    metrics.f1 = sqrt( sums->difference / ( 3.0 * sums->pixels ) );
    metrics.f1_relative = sqrt( sums->relative / ( 3.0 * sums->pixels ) );
    metrics.phi = find_phi( sums );
    metrics.mse = sums->square / ( 6.0 * sums->pixels );
    metrics.motion = sums->motion / sums->pixels;
    return metrics;
}
