// Denoises the halves of a frame, blends their mean with the noisy picture, and tells the error of the blend
// (src/denoise/README.md).
#include "base/try.h"
#include "denoise/beside.h"
#include "denoise/oidn.h"
#include "film/brightness.h"
#include "film/film_error.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MARGIN 32      // mirrored pixels around what the network sees
#define SIDE 16        // of a block, pixels: what rooks16 correlates lies within one
#define NEAR 1.0       // standard deviation of the weights of the blocks around one, in blocks
#define WIDE 4.0       // and of those of a wider neighbourhood,
#define REACH 12       // of which so many count, to each side
#define WIDE_SHARE 0.1 // which count so much
#define T_95 1.96
#define LEAST_EXPONENT 0.25
#define MUCH_NOISE 0.7 // relMSE of a block
#define FEW 10.0       // parts that an interval must not hang on

// The steps of the blend: from the picture to the denoised one, and from there to the mean along the motion.
enum
{
    CLEAN,
    ALONG,
    STEPS
};

// N and Q of the steps: half of what a small weight takes off the error, and products of the steps.
typedef struct Gains
{
    double gain[STEPS], step[STEPS], product;
} Gains;

// What the halves tell of a block: errors are relative, summed over pixels and channels.
typedef struct Block
{
    double noisy; // V: of the picture
    Gains gains;
    double weight[STEPS], others[STEPS]; // of the steps, the second at most the first; and those from the other blocks alone
    double half_gain, half_step;         // of the first step in the halves, in the mean of both
} Block;

typedef struct Work
{
    const RfNoisyFrame* frame;
    size_t pixels;
    int columns, rows; // of blocks
    float* padded[4];  // pictures with a margin: colour, albedo, normal, denoised
    float* rgb;        // the picture, 0 where it is not finite
    int unknown;       // pixels that are not
    float* half[2];    // its halves; without, the picture itself is the first
    float* clean[2];   // denoised
    float* along[2];   // their mean with the frames beside, along the motion; NULL: there are none
    double* below;     // of the squared errors
    float* layer;      // a layer denoised
    Block* blocks;
    double counts[REACH + 1][REACH + 1]; // weights of blocks by their distance
} Work;

static void destroy( Work* w )
{
    for ( int k = 0; k < 4; ++k )
        free( w->padded[k] );
    for ( int h = 0; h < 2; ++h )
    {
        free( w->half[h] );
        free( w->clean[h] );
        free( w->along[h] );
    }
    free( w->rgb );
    free( w->below );
    free( w->layer );
    free( w->blocks );
}

static RfResult create( const RfNoisyFrame* frame, Work* w, RfError* error )
{
    size_t pixels = (size_t)frame->width * (size_t)frame->height, image = 3 * pixels * sizeof( float );
    size_t padded = 3 * sizeof( float ) * (size_t)( frame->width + 2 * MARGIN ) * (size_t)( frame->height + 2 * MARGIN );
    bool good = true;
    *w = ( Work ){ .frame = frame,
                   .pixels = pixels,
                   .columns = ( frame->width - 1 ) / SIDE + 1,
                   .rows = ( frame->height - 1 ) / SIDE + 1,
                   .rgb = malloc( image ),
                   .below = malloc( pixels * sizeof( double ) ),
                   .layer = malloc( image ) };
    w->blocks = calloc( (size_t)w->columns * (size_t)w->rows, sizeof *w->blocks );
    for ( int k = 0; k < 4; ++k )
        good = ( w->padded[k] = malloc( padded ) ) != NULL && good;
    for ( int h = 0; h < 2; ++h )
    {
        good = ( w->half[h] = malloc( image ) ) != NULL && good;
        good = ( w->clean[h] = malloc( image ) ) != NULL && good;
        if ( rf_has_frames_beside( frame ) )
            good = ( w->along[h] = malloc( image ) ) != NULL && good;
    }
    return good && w->rgb != NULL && w->below != NULL && w->layer != NULL && w->blocks != NULL
               ? RF_OK
               : rf_fail( error, RF_ERROR_MEMORY, "out of memory for denoising %dx%d pixels", frame->width, frame->height );
}

static int mirrored( int place, int size )
{
    int period = 2 * size, at = ( place % period + period ) % period;
    return at < size ? at : period - 1 - at;
}

// Copies a picture with its mirrored margin; what is not finite becomes 0.
static void pad( const float* rgb, int width, int height, float* padded )
{
    int wide = width + 2 * MARGIN, high = height + 2 * MARGIN;
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < high; ++y )
    {
        rf_set_float_mode();
        const float* row = rgb + 3 * (size_t)width * (size_t)mirrored( y - MARGIN, height );
        float* to = padded + 3 * (size_t)wide * (size_t)y;
        for ( int x = 0; x < wide; ++x )
        {
            for ( int c = 0; c < 3; ++c )
            {
                float value = row[3 * mirrored( x - MARGIN, width ) + c];
                to[3 * x + c] = isfinite( value ) ? value : 0.0f;
            }
        }
    }
}

static RfResult run( RfDenoiser* denoiser, Work* w, const float* rgb, float scale, float* clean, RfError* error )
{
    const RfNoisyFrame* frame = w->frame;
    int wide = frame->width + 2 * MARGIN, high = frame->height + 2 * MARGIN;
    const float* normal = frame->albedo != NULL ? frame->normal : NULL;
    pad( rgb, frame->width, frame->height, w->padded[0] );
    const RfOidnImages images = { .width = wide,
                                  .height = high,
                                  .colour = w->padded[0],
                                  .albedo = frame->albedo != NULL ? w->padded[1] : NULL,
                                  .normal = normal != NULL ? w->padded[2] : NULL,
                                  .scale = scale };
    RF_TRY( rf_run_oidn( denoiser, &images, w->padded[3], error ) );
    for ( int y = 0; y < frame->height; ++y )
        memcpy( clean + 3 * (size_t)frame->width * (size_t)y,
                w->padded[3] + 3 * ( (size_t)wide * (size_t)( y + MARGIN ) + MARGIN ), 3 * (size_t)frame->width * sizeof *clean );
    return RF_OK;
}

// What brings the middle of the logarithms of the brightness of blocks to 0.18: it hardly changes from frame to frame.
static float exposure_of( const Work* w )
{
    const RfNoisyFrame* frame = w->frame;
    double sum = 0.0;
    int count = 0;
    for ( int b = 0; b < w->columns * w->rows; ++b )
    {
        int left = b % w->columns * SIDE, top = b / w->columns * SIDE, pixels = 0;
        double light = 0.0;
        for ( int y = top; y < top + SIDE && y < frame->height; ++y )
        {
            for ( int x = left; x < left + SIDE && x < frame->width; ++x )
            {
                light += rf_mean_of_channels( w->rgb + 3 * ( (size_t)y * (size_t)frame->width + (size_t)x ) );
                ++pixels;
            }
        }
        if ( light / pixels <= 1e-8 )
            continue;
        sum += log2( light / pixels );
        ++count;
    }
    return count > 0 ? (float)( 0.18 / exp2( sum / count ) ) : 1.0f;
}

// The share of the first half in pixel i; 1: there is no other.
static double share_of( const Work* w, size_t i )
{
    double share = w->frame->half != NULL ? (double)w->frame->half[4 * i + 3] : 1.0;
    return share > 0.0 && share < 1.0 ? share : 1.0;
}

// Are all channels of the picture and of its half finite?
static bool is_known( const Work* w, size_t i )
{
    const float *p = w->frame->rgb + 3 * i, *half = w->frame->half != NULL ? w->frame->half + 4 * i : p;
    return isfinite( p[0] + p[1] + p[2] ) && isfinite( half[0] + half[1] + half[2] );
}

static void split( Work* w )
{
    const RfNoisyFrame* frame = w->frame;
    for ( size_t i = 0; i < w->pixels; ++i )
    {
        double a = share_of( w, i );
        bool known = is_known( w, i );
        w->unknown += !known;
        for ( size_t c = 0; c < 3; ++c )
        {
            double mean = known ? (double)frame->rgb[3 * i + c] : 0.0;
            double first = a < 1.0 && known ? (double)frame->half[4 * i + c] : mean;
            w->rgb[3 * i + c] = (float)mean;
            w->half[0][3 * i + c] = (float)first;
            w->half[1][3 * i + c] = a < 1.0 ? (float)( ( mean - a * first ) / ( 1.0 - a ) ) : (float)mean;
        }
    }
}

// The mean of the denoised halves.
static double mean_of( float* const half[2], size_t i, size_t c, double share )
{
    return share * (double)half[0][3 * i + c] + ( 1.0 - share ) * (double)half[1][3 * i + c];
}

static void mix_clean( const Work* w, float* rgb )
{
    for ( size_t i = 0; i < w->pixels; ++i )
    {
        for ( size_t c = 0; c < 3; ++c )
            rgb[3 * i + c] = (float)mean_of( w->clean, i, c, share_of( w, i ) );
    }
}

static double apart( float* const half[2], size_t at ) { return (double)half[0][at] - (double)half[1][at]; }

static void add_pixel( const Work* w, size_t i, Block* block )
{
    double share = share_of( w, i ), scale = sqrt( share * ( 1.0 - share ) );
    Gains* g = &block->gains;
    for ( size_t at = 3 * i; at < 3 * i + 3; ++at )
    {
        size_t c = at - 3 * i;
        double d = scale * apart( w->half, at ), clean = scale * apart( w->clean, at );
        double mean = mean_of( w->clean, i, c, share ), step = mean - (double)w->rgb[at];
        double first = (double)w->clean[0][at] - (double)w->half[0][at],
               second = (double)w->clean[1][at] - (double)w->half[1][at];
        block->noisy += d * d / w->below[i];
        g->gain[CLEAN] += d * ( d - clean ) / w->below[i];
        g->step[CLEAN] += step * step / w->below[i];
        block->half_gain -= 0.5 * apart( w->half, at ) * ( first - second ) / w->below[i];
        block->half_step += 0.5 * ( first * first + second * second ) / w->below[i];
        if ( w->along[0] == NULL )
            continue;
        double along = scale * apart( w->along, at ), further = mean_of( w->along, i, c, share ) - mean;
        g->gain[ALONG] += d * ( clean - along ) / w->below[i];
        g->step[ALONG] += further * further / w->below[i];
        g->product += step * further / w->below[i];
    }
}

// Pixel number `k` of SIDE² of a block; false where it is beyond the picture.
static bool is_inside( const Work* w, int b, int k, size_t* pixel )
{
    int x = b % w->columns * SIDE + k % SIDE, y = b / w->columns * SIDE + k / SIDE;
    *pixel = (size_t)y * (size_t)w->frame->width + (size_t)x;
    return x < w->frame->width && y < w->frame->height;
}

// The relMSE of the noise in a block.
static double noise_of_block( const Work* w, int b )
{
    double sum = 0.0;
    int count = 0;
    for ( int k = 0; k < SIDE * SIDE; ++k )
    {
        size_t i;
        if ( !is_inside( w, b, k, &i ) )
            continue;
        double share = share_of( w, i );
        for ( size_t at = 3 * i; at < 3 * i + 3; ++at )
            sum += share * ( 1.0 - share ) * apart( w->half, at ) * apart( w->half, at ) / w->below[i];
        ++count;
    }
    return sum / count;
}

// What squared errors are divided by: where there is much noise, the brightness of the denoised halves, since that of the noisy ones
// has a part in it; where there is little, that of the noisy ones, since a denoiser blurs detail that is dark.
static RfResult find_denominators( Work* w, RfError* error )
{
    int width = w->frame->width, height = w->frame->height;
    double* noisy = malloc( w->pixels * sizeof *noisy );
    if ( noisy == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for denoising %dx%d pixels", width, height );
    mix_clean( w, w->layer );
    rf_likely_denominators( width, height, w->layer, w->clean[0], w->clean[1], w->below );
    rf_likely_denominators( width, height, w->rgb, w->half[0], w->half[1], noisy );
    for ( int b = 0; b < w->columns * w->rows; ++b )
    {
        double noise = noise_of_block( w, b ) / MUCH_NOISE, part = 1.0 / ( 1.0 + noise * noise );
        for ( int k = 0; k < SIDE * SIDE; ++k )
        {
            size_t i;
            if ( is_inside( w, b, k, &i ) )
                w->below[i] *= pow( noisy[i] / w->below[i], part );
        }
    }
    free( noisy );
    return RF_OK;
}

static void sum_block( const Work* w, int b )
{
    for ( int k = 0; k < SIDE * SIDE; ++k )
    {
        size_t i;
        if ( is_inside( w, b, k, &i ) )
            add_pixel( w, i, w->blocks + b );
    }
}

static void list_counts( Work* w )
{
    for ( int k = 0; k < ( REACH + 1 ) * ( REACH + 1 ); ++k )
    {
        int x = k % ( REACH + 1 ), y = k / ( REACH + 1 );
        double square = x * x + y * y;
        w->counts[y][x] = exp( -0.5 * square / ( NEAR * NEAR ) ) + WIDE_SHARE * exp( -0.5 * square / ( WIDE * WIDE ) );
    }
}

// By how much weights lower the error.
static double saved( const Gains* g, const double weight[STEPS] )
{
    return weight[CLEAN] * ( 2.0 * g->gain[CLEAN] - weight[CLEAN] * g->step[CLEAN] ) +
           weight[ALONG] * ( 2.0 * g->gain[ALONG] - weight[ALONG] * g->step[ALONG] ) -
           2.0 * weight[CLEAN] * weight[ALONG] * g->product;
}

static double quotient( double gain, double step, double most )
{
    return step > 0.0 ? fmin( fmax( gain / step, 0.0 ), most ) : gain > 0.0 ? most : 0.0;
}

static void take_better( const Gains* g, double clean, double along, double weight[STEPS] )
{
    const double other[STEPS] = { clean, along };
    if ( saved( g, other ) > saved( g, weight ) )
    {
        weight[CLEAN] = clean;
        weight[ALONG] = along;
    }
}

// The weights that lower the error most: the minimum of a quadratic form over the triangle 0 <= along <= clean <= 1, which is inside or
// on one of its sides.
static void solve( const Gains* g, double weight[STEPS] )
{
    double n = g->gain[CLEAN], m = g->gain[ALONG], q = g->step[CLEAN], r = g->step[ALONG], p = g->product, det = q * r - p * p;
    weight[CLEAN] = quotient( n, q, 1.0 );
    weight[ALONG] = 0.0;
    if ( !( r > 0.0 ) )
        return;
    double diagonal = quotient( n + m, q + 2.0 * p + r, 1.0 ), clean = ( n * r - m * p ) / det, along = ( m * q - n * p ) / det;
    take_better( g, diagonal, diagonal, weight );
    take_better( g, 1.0, quotient( m - p, r, 1.0 ), weight );
    if ( along > 0.0 && along < clean && clean < 1.0 )
        take_better( g, clean, along, weight );
}

static void add_gains( Gains* sum, const Gains* g, double count )
{
    for ( int k = 0; k < STEPS; ++k )
    {
        sum->gain[k] += count * g->gain[k];
        sum->step[k] += count * g->step[k];
    }
    sum->product += count * g->product;
}

// The weights in a block from those around it, with and without its own.
static void weigh_block( const Work* w, int b )
{
    Gains all = { { 0.0 }, { 0.0 }, 0.0 }, others = all;
    int column = b % w->columns, row = b / w->columns;
    for ( int y = row - REACH; y <= row + REACH; ++y )
    {
        for ( int x = column - REACH; x <= column + REACH; ++x )
        {
            if ( x < 0 || x >= w->columns || y < 0 || y >= w->rows )
                continue;
            const Block* other = w->blocks + y * w->columns + x;
            double count = w->counts[abs( y - row )][abs( x - column )];
            add_gains( &all, &other->gains, count );
            if ( x != column || y != row )
                add_gains( &others, &other->gains, count );
        }
    }
    solve( &all, w->blocks[b].weight );
    solve( &others, w->blocks[b].others );
}

static int part_of( const Work* w, int b ) { return b / w->columns / 2 * ( ( w->columns + 1 ) / 2 ) + b % w->columns / 2; }

static int part_count( const Work* w ) { return ( ( w->columns + 1 ) / 2 ) * ( ( w->rows + 1 ) / 2 ); }

// Sums the error of the blend, with weights from other blocks, over parts of 2 by 2 blocks.
static void sum_parts( const Work* w, double* parts )
{
    for ( int b = 0; b < w->columns * w->rows; ++b )
        parts[part_of( w, b )] += w->blocks[b].noisy - saved( &w->blocks[b].gains, w->blocks[b].others );
}

// The error of a half, blended like the picture, is twice the noise less what it gains (E23); that of the picture is
// `relmse`. The exponent that this makes of twice the samples, within what denoised pictures have.
static double exponent_of( const Work* w, double relmse )
{
    double half = 0.0;
    for ( int b = 0; b < w->columns * w->rows; ++b )
    {
        const Block* k = w->blocks + b;
        half += 2.0 * k->noisy - k->others[CLEAN] * ( 2.0 * k->half_gain - k->others[CLEAN] * k->half_step );
    }
    double q = half > 0.0 && relmse > 0.0 ? log2( half / relmse ) : 1.0;
    return fmin( fmax( q, LEAST_EXPONENT ), 1.0 );
}

// Whether most blocks gain, in proportion to their noise: a mean that could not be so much above 0 by chance.
static bool does_help( const Work* w )
{
    int count = w->columns * w->rows;
    double sum = 0.0, squares = 0.0;
    for ( int b = 0; b < count; ++b )
    {
        const Block* block = w->blocks + b;
        double gain = block->noisy > 0.0 ? fmax( saved( &block->gains, block->others ) / block->noisy, -1.0 ) : 0.0;
        sum += gain;
        squares += gain * gain;
    }
    return sum > T_95 * sqrt( squares );
}

// A sum of independent parts, its 95 % interval, and whether it hangs on a few of them.
static RfErrorEstimate estimate( const double* parts, int count, double scale )
{
    double sum = 0.0, squares = 0.0, spread = 0.0;
    for ( int k = 0; k < count; ++k )
    {
        sum += parts[k];
        squares += parts[k] * parts[k];
    }
    for ( int k = 0; k < count; ++k )
        spread += ( parts[k] - sum / count ) * ( parts[k] - sum / count );
    double reach = count > 1 ? T_95 * sqrt( spread * count / ( count - 1.0 ) ) : (double)NAN;
    return ( RfErrorEstimate ){ .relmse = scale * sum,
                                .low = scale * fmax( sum - reach, 0.0 ),
                                .high = scale * fmax( sum + reach, 0.0 ),
                                .is_vague = sum * sum < FEW * squares };
}

static const RfErrorEstimate s_unknown = { (double)NAN, (double)NAN, (double)NAN, false };

RfErrorEstimate rf_denoised_error( const RfDenoisedSums* sums )
{
    return sums->frames > 0 ? estimate( sums->of_part, sums->count, 1.0 / sums->frames ) : s_unknown;
}

void rf_free_denoised_sums( RfDenoisedSums* sums )
{
    free( sums->of_part );
    *sums = ( RfDenoisedSums ){ 0 };
}

static RfResult add_to_sums( const double* parts, int count, double scale, RfDenoisedSums* sums, RfError* error )
{
    if ( sums == NULL )
        return RF_OK;
    if ( sums->of_part == NULL )
    {
        *sums = ( RfDenoisedSums ){ .count = count, .of_part = calloc( (size_t)count, sizeof *parts ) };
        if ( sums->of_part == NULL )
            return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the errors of a shot" );
    }
    ++sums->frames;
    for ( int k = 0; k < count && k < sums->count; ++k )
        sums->of_part[k] += scale * parts[k];
    return RF_OK;
}

// Chooses the weights of the blocks, and tells the errors.
static RfResult conclude( Work* w, RfDenoised* out, RfDenoisedSums* sums, RfError* error )
{
    int count = w->columns * w->rows;
    double scale = 1.0 / (double)w->pixels, *parts = calloc( (size_t)part_count( w ), sizeof *parts );
    if ( parts == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the error of a frame" );
    for ( int b = 0; b < count; ++b )
        sum_block( w, b );
    list_counts( w );
    for ( int b = 0; b < count; ++b )
        weigh_block( w, b );
    bool helps = does_help( w );
    for ( int b = 0; b < count && !helps; ++b )
    {
        for ( int k = 0; k < STEPS; ++k )
            w->blocks[b].weight[k] = w->blocks[b].others[k] = 0.0;
    }
    sum_parts( w, parts );
    RfResult result = RF_OK;
    if ( w->frame->passes >= RF_LEAST_DENOISED_PASSES && w->unknown == 0 )
    {
        out->noisy = 0.0;
        for ( int b = 0; b < count; ++b )
            out->noisy += scale * w->blocks[b].noisy;
        out->denoised = estimate( parts, part_count( w ), scale );
        out->exponent = exponent_of( w, out->denoised.relmse / scale );
        result = add_to_sums( parts, part_count( w ), scale, sums, error );
    }
    free( parts );
    return result;
}

// The weight of a step at a pixel, linear between the middles of blocks.
static double weight_at( const Work* w, size_t i, int step )
{
    int x = (int)( i % (size_t)w->frame->width ), y = (int)( i / (size_t)w->frame->width );
    double u = fmin( fmax( ( x + 0.5 ) / SIDE - 0.5, 0.0 ), w->columns - 1.0 );
    double v = fmin( fmax( ( y + 0.5 ) / SIDE - 0.5, 0.0 ), w->rows - 1.0 );
    int column = (int)u, row = (int)v, right = column + ( column < w->columns - 1 ), down = row + ( row < w->rows - 1 );
    const Block *upper = w->blocks + row * w->columns, *lower = w->blocks + down * w->columns;
    u -= column;
    v -= row;
    return ( 1.0 - v ) * ( ( 1.0 - u ) * upper[column].weight[step] + u * upper[right].weight[step] ) +
           v * ( ( 1.0 - u ) * lower[column].weight[step] + u * lower[right].weight[step] );
}

static void blend( const Work* w, float* rgb, RfDenoised* denoised )
{
    double sums[STEPS] = { 0.0 };
    for ( size_t i = 0; i < w->pixels; ++i )
    {
        double share = share_of( w, i ), weight[STEPS] = { 0.0 };
        for ( int k = 0; k < STEPS && is_known( w, i ); ++k )
            weight[k] = weight_at( w, i, k );
        for ( size_t c = 0; c < 3; ++c )
        {
            double noisy = (double)w->frame->rgb[3 * i + c], clean = mean_of( w->clean, i, c, share );
            double along = w->along[0] != NULL ? mean_of( w->along, i, c, share ) : clean;
            double value = noisy + weight[CLEAN] * ( clean - noisy ) + weight[ALONG] * ( along - clean );
            rgb[3 * i + c] = weight[CLEAN] > 0.0 ? (float)value : (float)noisy;
        }
        for ( int k = 0; k < STEPS; ++k )
            sums[k] += weight[k];
    }
    denoised->share = sums[CLEAN] / (double)w->pixels;
    denoised->along = sums[ALONG] / (double)w->pixels;
}

// Denoises the layers by the weights of the picture.
static RfResult blend_layers( RfDenoiser* denoiser, Work* w, float scale, RfError* error )
{
    for ( int l = 0; l < w->frame->layer_count; ++l )
    {
        const RfNoisyLayer* layer = w->frame->layers + l;
        if ( !layer->is_raw )
            continue;
        RF_TRY( run( denoiser, w, layer->rgb, scale, w->layer, error ) );
        for ( size_t i = 0; i < w->pixels; ++i )
        {
            double weight = is_known( w, i ) ? weight_at( w, i, CLEAN ) : 0.0;
            for ( size_t c = 0; c < 3 && weight > 0.0; ++c )
                layer->rgb[3 * i + c] += (float)( weight * (double)( w->layer[3 * i + c] - layer->rgb[3 * i + c] ) );
        }
    }
    return RF_OK;
}

// What the layers of a set lack of the picture is shared out among them by their size.
static void add_up( const RfNoisyFrame* frame, const float* rgb, int set, size_t i )
{
    for ( size_t c = 0; c < 3; ++c )
    {
        double sum = 0.0, size = 0.0;
        int count = 0;
        for ( int l = 0; l < frame->layer_count; ++l )
        {
            if ( frame->layers[l].set != set )
                continue;
            sum += (double)frame->layers[l].rgb[3 * i + c];
            size += fabs( (double)frame->layers[l].rgb[3 * i + c] );
            ++count;
        }
        for ( int l = 0; l < frame->layer_count; ++l )
        {
            float* value = frame->layers[l].rgb + 3 * i + c;
            if ( frame->layers[l].set == set )
                *value +=
                    (float)( ( (double)rgb[3 * i + c] - sum ) * ( size > 0.0 ? fabs( (double)*value ) / size : 1.0 / count ) );
        }
    }
}

// The halves that are denoised before are copied, so that all are freed alike.
static RfResult denoise_halves( RfDenoiser* denoiser, Work* w, float scale, RfError* error )
{
    const RfNoisyFrame* frame = w->frame;
    bool halves = frame->half != NULL;
    if ( frame->albedo != NULL )
        pad( frame->albedo, frame->width, frame->height, w->padded[1] );
    if ( frame->normal != NULL )
        pad( frame->normal, frame->width, frame->height, w->padded[2] );
    for ( int h = 0; h < 1 + halves && frame->halves == NULL; ++h )
        RF_TRY( run( denoiser, w, w->half[h], scale, w->clean[h], error ) );
    for ( int h = 0; h < 2 && frame->halves != NULL; ++h )
        memcpy( w->clean[h], frame->halves->half[h], 3 * w->pixels * sizeof( float ) );
    if ( !halves )
        memcpy( w->clean[1], w->clean[0], 3 * w->pixels * sizeof( float ) );
    return RF_OK;
}

RfResult rf_denoise_halves( RfDenoiser* denoiser, const RfNoisyFrame* frame, RfDenoisedHalves* halves, RfError* error )
{
    Work w;
    *halves = ( RfDenoisedHalves ){ { NULL, NULL } };
    RfResult result = create( frame, &w, error );
    if ( result == RF_OK )
    {
        split( &w );
        result = denoise_halves( denoiser, &w, exposure_of( &w ), error );
    }
    for ( int h = 0; h < 2 && result == RF_OK; ++h )
    {
        halves->half[h] = w.clean[h];
        w.clean[h] = NULL;
    }
    destroy( &w );
    return result;
}

void rf_free_denoised_halves( RfDenoisedHalves* halves )
{
    for ( int h = 0; h < 2; ++h )
        free( halves->half[h] );
    *halves = ( RfDenoisedHalves ){ { NULL, NULL } };
}

RfResult rf_denoise( RfDenoiser* denoiser, const RfNoisyFrame* frame, float* rgb, RfDenoised* denoised, RfDenoisedSums* sums,
                     RfError* error )
{
    Work w;
    *denoised = ( RfDenoised ){ .noisy = (double)NAN, .denoised = s_unknown, .exponent = (double)NAN };
    RfResult result = create( frame, &w, error );
    if ( result == RF_OK )
    {
        split( &w );
        float scale = exposure_of( &w );
        result = denoise_halves( denoiser, &w, scale, error );
        for ( int b = 0; b < w.columns * w.rows; ++b )
            w.blocks[b].weight[CLEAN] = 1.0;
        if ( frame->half != NULL && result == RF_OK )
        {
            result = find_denominators( &w, error );
            if ( w.along[0] != NULL )
                rf_mean_along_motion( frame, w.clean, w.along );
            if ( result == RF_OK )
                result = conclude( &w, denoised, sums, error );
        }
        if ( result == RF_OK )
            result = blend_layers( denoiser, &w, scale, error );
        if ( result == RF_OK )
            blend( &w, rgb, denoised );
        int sets = 0;
        for ( int l = 0; l < frame->layer_count; ++l )
            sets = frame->layers[l].set >= sets ? frame->layers[l].set + 1 : sets;
        for ( size_t i = 0; i < w.pixels && result == RF_OK; ++i )
        {
            for ( int set = 0; set < sets; ++set )
                add_up( frame, rgb, set, i );
        }
    }
    destroy( &w );
    return result;
}
