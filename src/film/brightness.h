// The brightness by which relMSE divides squared errors (src/reuse/estimators.md, E23): of the mean of the channels the median over
// 3×3 pixels, and of that the mean over 5×5. A single bright pixel does not lower its own error. At borders the nearest pixel is
// repeated.
#ifndef REFRAME_FILM_BRIGHTNESS_H
#define REFRAME_FILM_BRIGHTNESS_H

#include "reframe/measure.h"

#include <stddef.h>
#include <stdint.h>

#define RF_BRIGHTNESS_SIDE 32 // of a block, pixels, at most
#define RF_BRIGHTNESS_REACH 3
#define RF_BRIGHTNESS_ROOM ( RF_BRIGHTNESS_SIDE + 2 * RF_BRIGHTNESS_REACH )

// Of a picture; `right` and `bottom` are beyond it.
typedef struct RfBlock
{
    int left, top, right, bottom;
} RfBlock;

// Values row by row, RF_BRIGHTNESS_ROOM a row.
typedef double RfBlockValues[RF_BRIGHTNESS_ROOM * RF_BRIGHTNESS_ROOM];

// Blocks of a picture, in order, all of about one size.
static inline int rf_blocks_along( int pixels ) { return ( pixels - 1 ) / RF_BRIGHTNESS_SIDE + 1; }
static inline int rf_block_count( int width, int height ) { return rf_blocks_along( width ) * rf_blocks_along( height ); }
static inline RfBlock rf_block( int width, int height, int i )
{
    int64_t across = rf_blocks_along( width ), down = rf_blocks_along( height ), column = i % across, row = i / across;
    return ( RfBlock ){ (int)( column * width / across ), (int)( row * height / down ), (int)( ( column + 1 ) * width / across ),
                        (int)( ( row + 1 ) * height / down ) };
}

// The pixel of a picture that is nearest to the place of value (i, j) of a block with the pixels around it.
static inline size_t rf_block_pixel( int width, int height, const RfBlock* block, int i, int j )
{
    int x = block->left - RF_BRIGHTNESS_REACH + i, y = block->top - RF_BRIGHTNESS_REACH + j;
    x = x < 0 ? 0 : x < width ? x : width - 1;
    y = y < 0 ? 0 : y < height ? y : height - 1;
    return (size_t)y * (size_t)width + (size_t)x;
}

static inline double rf_mean_of_channels( const float* rgb )
{
    return ( (double)rgb[0] + (double)rgb[1] + (double)rgb[2] ) / 3.0;
}

// From the means of the channels of a block and of RF_BRIGHTNESS_REACH pixels around it (rf_block_pixel) to its brightness.
void rf_block_brightness( int width, int height, const RfBlock* block, const RfBlockValues grey, RfBlockValues brightness );

// What squared errors of all pixels of a picture are divided by: brightness² + RF_RELMSE_EPSILON.
void rf_relmse_denominators( const float* rgb, int width, int height, double* below );

static inline double rf_relmse_denominator( double brightness ) { return brightness * brightness + RF_RELMSE_EPSILON; }

#endif
