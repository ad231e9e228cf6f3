// The median over 3×3 pixels and the mean over 5×5.
#include "film/brightness.h"

#define ROOM RF_BRIGHTNESS_ROOM
#define REACH RF_BRIGHTNESS_REACH
#define OF_MEAN 2 // reach of the mean, pixels

static int nearest( int place, int size ) { return place < 0 ? 0 : place < size ? place : size - 1; }

static inline void sort( double* a, double* b )
{
    double low = *b < *a ? *b : *a, high = *b < *a ? *a : *b;
    *a = low;
    *b = high;
}

// Of the 3×3 values around one (Smith, Implementing median filters in XC4000E FPGAs, Xcell 23, 1996).
static double median_around( const double* v )
{
    double p[9] = { v[-ROOM - 1], v[-ROOM], v[-ROOM + 1], v[-1], v[0], v[1], v[ROOM - 1], v[ROOM], v[ROOM + 1] };
    static const unsigned char pairs[][2] = { { 1, 2 }, { 4, 5 }, { 7, 8 }, { 0, 1 }, { 3, 4 }, { 6, 7 }, { 1, 2 },
                                              { 4, 5 }, { 7, 8 }, { 0, 3 }, { 5, 8 }, { 4, 7 }, { 3, 6 }, { 1, 4 },
                                              { 2, 5 }, { 4, 7 }, { 4, 2 }, { 6, 4 }, { 4, 2 } };
    for ( int k = 0; k < 19; ++k )
        sort( p + pairs[k][0], p + pairs[k][1] );
    return p[4];
}

void rf_block_brightness( int width, int height, const RfBlock* block, const RfBlockValues grey, RfBlockValues brightness )
{
    int columns = block->right - block->left, rows = block->bottom - block->top;
    double means[( RF_BRIGHTNESS_SIDE + 2 * OF_MEAN ) * RF_BRIGHTNESS_SIDE]; // of 5 medians of a row
    for ( int j = 0; j < rows + 2 * OF_MEAN; ++j )
    {
        double medians[RF_BRIGHTNESS_SIDE + 2 * OF_MEAN];
        int y = nearest( block->top - OF_MEAN + j, height ) - block->top + REACH;
        for ( int i = 0; i < columns + 2 * OF_MEAN; ++i )
            medians[i] = median_around( grey + y * ROOM + nearest( block->left - OF_MEAN + i, width ) - block->left + REACH );
        for ( int i = 0; i < columns; ++i )
            means[j * columns + i] = ( medians[i] + medians[i + 1] + medians[i + 2] + medians[i + 3] + medians[i + 4] ) / 5.0;
    }
    for ( int j = 0; j < rows; ++j )
    {
        for ( int i = 0; i < columns; ++i )
        {
            const double* m = means + j * columns + i;
            brightness[j * ROOM + i] = ( m[0] + m[columns] + m[2 * columns] + m[3 * columns] + m[4 * columns] ) / 5.0;
        }
    }
}

void rf_relmse_denominators( const float* rgb, int width, int height, double* below )
{
    for ( int k = 0; k < rf_block_count( width, height ); ++k )
    {
        RfBlockValues grey, brightness;
        RfBlock block = rf_block( width, height, k );
        int columns = block.right - block.left, rows = block.bottom - block.top;
        for ( int j = 0; j < rows + 2 * REACH; ++j )
        {
            for ( int i = 0; i < columns + 2 * REACH; ++i )
                grey[j * ROOM + i] = rf_mean_of_channels( rgb + 3 * rf_block_pixel( width, height, &block, i, j ) );
        }
        rf_block_brightness( width, height, &block, grey, brightness );
        for ( int j = 0; j < rows; ++j )
        {
            for ( int i = 0; i < columns; ++i )
                below[(size_t)( block.top + j ) * (size_t)width + (size_t)( block.left + i )] =
                    rf_relmse_denominator( brightness[j * ROOM + i] );
        }
    }
}
