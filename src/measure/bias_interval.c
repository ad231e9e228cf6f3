#include "measure/bias_interval.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double rf_student_quantile( int freedom )
{
    static const double few[] = { 12.7062, 4.3027, 3.1824 };
    if ( freedom <= 3 )
        return few[freedom - 1];
    // Abramowitz, Stegun 26.7.5
    double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z, n = freedom;
    return z + ( z3 + z ) / ( 4.0 * n ) + ( 5.0 * z5 + 16.0 * z3 + 3.0 * z ) / ( 96.0 * n * n ) +
           ( 3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z ) / ( 384.0 * n * n * n );
}

// Blocks of side_x × side_y pixels.
typedef struct Blocks
{
    const double* smallest; // the sums of the smallest blocks
    double* sums;           // as many elements
    int width, height;      // of the image
    double values;
} Blocks;

static int ceil_divide( int a, int b ) { return ( a + b - 1 ) / b; }

static double cropped_side( int index, int side, int size )
{
    int left = size - index * side;
    return left < side ? left : side;
}

// Merges the smallest blocks into blocks of `across` × `down` of them.
static void join_blocks( const Blocks* blocks, int across, int down )
{
    int columns = ceil_divide( blocks->width, RF_BLOCK_SIDE ), rows = ceil_divide( blocks->height, RF_BLOCK_SIDE );
    int joined = ceil_divide( columns, across );
    memset( blocks->sums, 0, (size_t)joined * (size_t)ceil_divide( rows, down ) * sizeof( double ) );
    for ( int y = 0; y < rows; ++y )
    {
        for ( int x = 0; x < columns; ++x )
            blocks->sums[y / down * joined + x / across] += blocks->smallest[y * columns + x];
    }
}

// The half-width of the interval from one block size. With w the number of pixels of a block,
// the sampling variance of the weighted mean is Σ w² (block mean − mean)² / (Σ w)². NaN if
// there are fewer than `fewest` blocks.
static double margin_of( const Blocks* blocks, int across, int down, int fewest )
{
    int side_x = across * RF_BLOCK_SIDE, side_y = down * RF_BLOCK_SIDE;
    int columns = ceil_divide( blocks->width, side_x ), rows = ceil_divide( blocks->height, side_y ), count = columns * rows;
    double pixels = (double)blocks->width * blocks->height, sum = 0.0, spread = 0.0;
    if ( count < fewest )
        return NAN;
    join_blocks( blocks, across, down );
    for ( int i = 0; i < count; ++i )
        sum += blocks->sums[i];
    double mean = sum / ( pixels * blocks->values );
    for ( int i = 0; i < count; ++i )
    {
        double weight = cropped_side( i % columns, side_x, blocks->width ) * cropped_side( i / columns, side_y, blocks->height );
        double delta = blocks->sums[i] / blocks->values - weight * mean;
        spread += delta * delta;
    }
    return rf_student_quantile( count - 1 ) * sqrt( count / ( count - 1.0 ) * spread ) / pixels;
}

RfResult rf_mean_margin( const double* sums, int width, int height, double values, double* margin, RfError* error )
{
    int columns = ceil_divide( width, RF_BLOCK_SIDE ), rows = ceil_divide( height, RF_BLOCK_SIDE );
    Blocks blocks = { .smallest = sums, .width = width, .height = height, .values = values };
    *margin = NAN;
    blocks.sums = malloc( (size_t)columns * (size_t)rows * sizeof( double ) );
    if ( blocks.sums == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the blocks of %dx%d pixels", width, height );
    *margin = margin_of( &blocks, 1, 1, 2 ); // fmax ignores NaN
    for ( int side = 2; side < columns || side < rows; side *= 2 )
        *margin = fmax( *margin, margin_of( &blocks, side, side, RF_MIN_BLOCKS ) );
    *margin = fmax( *margin, margin_of( &blocks, columns, 1, RF_MIN_STRIPS ) );
    *margin = fmax( *margin, margin_of( &blocks, 1, rows, RF_MIN_STRIPS ) );
    free( blocks.sums );
    return RF_OK;
}
