// Denoises the halves of a frame, blends their mean with the noisy picture, and tells the error of the blend
// (src/denoise/README.md).
#include "base/try.h"
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
#define FEW 10.0 // parts that an interval must not hang on

// What the halves tell of a block: errors are relative, summed over pixels and channels.
typedef struct Block
{
    double noisy;                // V: of the picture
    double gain;                 // N: half of what a small weight w of the denoised picture takes off it
    double step;                 // Q: squared distance of the two
    double weight, others;       // w, and w from the other blocks alone
    double half_gain, half_step; // of the halves, likewise, in the mean of both
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
static double clean_value( const Work* w, size_t i, size_t c, double share )
{
    return share * (double)w->clean[0][3 * i + c] + ( 1.0 - share ) * (double)w->clean[1][3 * i + c];
}

static void mix_clean( const Work* w, float* rgb )
{
    for ( size_t i = 0; i < w->pixels; ++i )
    {
        for ( size_t c = 0; c < 3; ++c )
            rgb[3 * i + c] = (float)clean_value( w, i, c, share_of( w, i ) );
    }
}

static void sum_block( const Work* w, int b )
{
    int width = w->frame->width, left = b % w->columns * SIDE, top = b / w->columns * SIDE;
    Block* block = w->blocks + b;
    for ( int y = top; y < top + SIDE && y < w->frame->height; ++y )
    {
        for ( int x = left; x < left + SIDE && x < width; ++x )
        {
            size_t i = (size_t)y * (size_t)width + (size_t)x;
            double share = share_of( w, i ), scale = sqrt( share * ( 1.0 - share ) );
            for ( size_t c = 0; c < 3; ++c )
            {
                double d = scale * ( (double)w->half[0][3 * i + c] - (double)w->half[1][3 * i + c] );
                double clean = scale * ( (double)w->clean[0][3 * i + c] - (double)w->clean[1][3 * i + c] );
                double step = clean_value( w, i, c, share ) - (double)w->rgb[3 * i + c];
                double apart = (double)w->half[1][3 * i + c] - (double)w->half[0][3 * i + c];
                double first = (double)w->clean[0][3 * i + c] - (double)w->half[0][3 * i + c];
                double second = (double)w->clean[1][3 * i + c] - (double)w->half[1][3 * i + c];
                block->noisy += d * d / w->below[i];
                block->gain += d * ( d - clean ) / w->below[i];
                block->step += step * step / w->below[i];
                block->half_gain += 0.5 * apart * ( first - second ) / w->below[i];
                block->half_step += 0.5 * ( first * first + second * second ) / w->below[i];
            }
        }
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

static double quotient( double gain, double step ) { return step > 0.0 ? fmin( fmax( gain / step, 0.0 ), 1.0 ) : gain > 0.0; }

// The weight of the denoised picture in a block from those around it, with and without its own.
static void weigh_block( const Work* w, int b )
{
    double gain[2] = { 0.0 }, step[2] = { 0.0 };
    int column = b % w->columns, row = b / w->columns;
    for ( int y = row - REACH; y <= row + REACH; ++y )
    {
        for ( int x = column - REACH; x <= column + REACH; ++x )
        {
            if ( x < 0 || x >= w->columns || y < 0 || y >= w->rows )
                continue;
            const Block* other = w->blocks + y * w->columns + x;
            double weight = w->counts[abs( y - row )][abs( x - column )];
            for ( int k = 0; k < 2 - ( x == column && y == row ); ++k )
            {
                gain[k] += weight * other->gain;
                step[k] += weight * other->step;
            }
        }
    }
    w->blocks[b].weight = quotient( gain[0], step[0] );
    w->blocks[b].others = quotient( gain[1], step[1] );
}

// By how much a weight lowers the error of a block.
static double saved( const Block* b, double weight ) { return weight * ( 2.0 * b->gain - weight * b->step ); }

static int part_of( const Work* w, int b ) { return b / w->columns / 2 * ( ( w->columns + 1 ) / 2 ) + b % w->columns / 2; }

static int part_count( const Work* w ) { return ( ( w->columns + 1 ) / 2 ) * ( ( w->rows + 1 ) / 2 ); }

// Sums the error of the blend, with weights from other blocks, over parts of 2 by 2 blocks.
static void sum_parts( const Work* w, double* parts )
{
    for ( int b = 0; b < w->columns * w->rows; ++b )
        parts[part_of( w, b )] += w->blocks[b].noisy - saved( w->blocks + b, w->blocks[b].others );
}

// The error of a half, blended like the picture, is twice the noise less what it gains (E23); that of the picture is
// `relmse`. The exponent that this makes of twice the samples, within what denoised pictures have.
static double exponent_of( const Work* w, double relmse )
{
    double half = 0.0;
    for ( int b = 0; b < w->columns * w->rows; ++b )
    {
        const Block* k = w->blocks + b;
        half += 2.0 * k->noisy - k->others * ( 2.0 * k->half_gain - k->others * k->half_step );
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
        double gain = block->noisy > 0.0 ? fmax( saved( block, block->others ) / block->noisy, -1.0 ) : 0.0;
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
        w->blocks[b].weight = w->blocks[b].others = 0.0;
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

// The weight at a pixel, linear between the middles of blocks.
static double weight_at( const Work* w, int x, int y )
{
    double u = fmin( fmax( ( x + 0.5 ) / SIDE - 0.5, 0.0 ), w->columns - 1.0 );
    double v = fmin( fmax( ( y + 0.5 ) / SIDE - 0.5, 0.0 ), w->rows - 1.0 );
    int column = (int)u, row = (int)v, right = column + ( column < w->columns - 1 ), down = row + ( row < w->rows - 1 );
    const Block *upper = w->blocks + row * w->columns, *lower = w->blocks + down * w->columns;
    u -= column;
    v -= row;
    return ( 1.0 - v ) * ( ( 1.0 - u ) * upper[column].weight + u * upper[right].weight ) +
           v * ( ( 1.0 - u ) * lower[column].weight + u * lower[right].weight );
}

static double blend( const Work* w, float* rgb )
{
    double sum = 0.0;
    for ( int y = 0; y < w->frame->height; ++y )
    {
        for ( int x = 0; x < w->frame->width; ++x )
        {
            size_t i = (size_t)y * (size_t)w->frame->width + (size_t)x;
            double weight = is_known( w, i ) ? weight_at( w, x, y ) : 0.0, share = share_of( w, i );
            for ( size_t c = 0; c < 3; ++c )
            {
                double noisy = (double)w->frame->rgb[3 * i + c];
                rgb[3 * i + c] =
                    weight > 0.0 ? (float)( noisy + weight * ( clean_value( w, i, c, share ) - noisy ) ) : (float)noisy;
            }
            sum += weight;
        }
    }
    return sum / (double)w->pixels;
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
            double weight = is_known( w, i )
                                ? weight_at( w, (int)( i % (size_t)w->frame->width ), (int)( i / (size_t)w->frame->width ) )
                                : 0.0;
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

RfResult rf_denoise( RfDenoiser* denoiser, const RfNoisyFrame* frame, float* rgb, RfDenoised* denoised, RfDenoisedSums* sums,
                     RfError* error )
{
    Work w;
    *denoised = ( RfDenoised ){ .noisy = (double)NAN, .denoised = s_unknown, .exponent = (double)NAN };
    RfResult result = create( frame, &w, error );
    if ( result == RF_OK )
    {
        bool halves = frame->half != NULL;
        split( &w );
        float scale = exposure_of( &w );
        if ( frame->albedo != NULL )
            pad( frame->albedo, frame->width, frame->height, w.padded[1] );
        if ( frame->normal != NULL )
            pad( frame->normal, frame->width, frame->height, w.padded[2] );
        for ( int h = 0; h < 1 + halves && result == RF_OK; ++h )
            result = run( denoiser, &w, w.half[h], scale, w.clean[h], error );
        if ( !halves )
            memcpy( w.clean[1], w.clean[0], 3 * w.pixels * sizeof *rgb );
        for ( int b = 0; b < w.columns * w.rows; ++b )
            w.blocks[b].weight = 1.0;
        if ( halves && result == RF_OK )
        {
            mix_clean( &w, w.layer );
            rf_likely_denominators( frame->width, frame->height, w.layer, w.clean[0], w.clean[1], w.below );
            result = conclude( &w, denoised, sums, error );
        }
        if ( result == RF_OK )
            result = blend_layers( denoiser, &w, scale, error );
        if ( result == RF_OK )
            denoised->share = blend( &w, rgb );
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
