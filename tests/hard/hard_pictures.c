#include "hard/hard_pictures.h"

#include "support/statistics.h"

#include <math.h>
#include <stdlib.h>

#define BLOCK 4       // pixels
#define ROUNDING 1e-4 // relative: films and reference sum in different orders

double* hard_new_picture( const HardPictures* p )
{
    double* rgb = calloc( 3 * (size_t)p->width * (size_t)p->height, sizeof *rgb );
    if ( rgb == NULL )
        abort();
    return rgb;
}

void hard_free_pictures( HardPictures* p )
{
    for ( int k = 0; k < p->count; ++k )
        free( p->rgb[k] );
    p->count = 0;
}

static double block_mean( const HardPictures* p, int k, int x0, int y0, int x1, int y1 )
{
    double sum = 0.0;
    int count = 0;
    for ( int y = y0; y < y1 && y < p->height; ++y )
    {
        for ( int x = x0; x < x1 && x < p->width; ++x, ++count )
        {
            const double* c = p->rgb[k] + 3 * ( (size_t)y * (size_t)p->width + (size_t)x );
            sum += c[0] + c[1] + c[2];
        }
    }
    return sum / ( 3.0 * count );
}

// Welch's test of the means of a block; those that differ by rounding alone are equal.
static double block_p( const HardPictures* a, const HardPictures* b, int x0, int y0, int x1, int y1 )
{
    double va[HARD_MOST_SEEDS], vb[HARD_MOST_SEEDS];
    for ( int k = 0; k < a->count; ++k )
        va[k] = block_mean( a, k, x0, y0, x1, y1 );
    for ( int k = 0; k < b->count; ++k )
        vb[k] = block_mean( b, k, x0, y0, x1, y1 );
    double ma = mean_of( va, a->count, NULL ), mb = mean_of( vb, b->count, NULL );
    return fabs( ma - mb ) <= ROUNDING * fabs( mb ) ? 1.0 : welch_p( va, a->count, vb, b->count );
}

void hard_compare( const HardPictures* a, const HardPictures* b, HardDifference* out )
{
    double va[HARD_MOST_SEEDS], vb[HARD_MOST_SEEDS], ea, eb, smallest = 1.0;
    int tested = 0, size = a->width > 256 ? a->width / 16 : BLOCK;
    for ( int k = 0; k < a->count; ++k )
        va[k] = block_mean( a, k, 0, 0, a->width, a->height );
    for ( int k = 0; k < b->count; ++k )
        vb[k] = block_mean( b, k, 0, 0, b->width, b->height );
    double ma = mean_of( va, a->count, &ea ), mb = mean_of( vb, b->count, &eb );
    out->bias = mb > 0.0 ? ma / mb - 1.0 : ma;
    out->interval = 1.96 * sqrt( ea * ea + eb * eb ) / ( mb > 0.0 ? mb : 1.0 );
    out->whole_p = block_p( a, b, 0, 0, a->width, a->height );
    for ( int y = 0; y < a->height; y += size )
    {
        for ( int x = 0; x < a->width; x += size, ++tested )
            smallest = fmin( smallest, block_p( a, b, x, y, x + size, y + size ) );
    }
    for ( int y = 0; y < a->height && size == BLOCK; ++y, ++tested ) // rows and columns: tiles move light by pixels
        smallest = fmin( smallest, block_p( a, b, 0, y, a->width, y + 1 ) );
    for ( int x = 0; x < a->width && size == BLOCK; ++x, ++tested )
        smallest = fmin( smallest, block_p( a, b, x, 0, x + 1, a->height ) );
    out->block_p = 1.0 - pow( 1.0 - smallest, tested );
}

double hard_relmse( const HardPictures* p, const HardPictures* guide )
{
    double whole = 0.0, sum = 0.0;
    size_t values = 3 * (size_t)p->width * (size_t)p->height;
    for ( int k = 0; k < guide->count; ++k )
        whole += block_mean( guide, k, 0, 0, p->width, p->height ) / guide->count;
    for ( size_t i = 0; i < values; ++i )
    {
        double mean = 0.0, square = 0.0, of_guide = 0.0;
        for ( int k = 0; k < p->count; ++k )
            mean += p->rgb[k][i] / p->count;
        for ( int k = 0; k < p->count; ++k )
            square += ( p->rgb[k][i] - mean ) * ( p->rgb[k][i] - mean ) / ( p->count - 1 );
        for ( int k = 0; k < guide->count; ++k )
            of_guide += guide->rgb[k][i] / guide->count;
        double least = whole > 0.0 ? 0.01 * whole * whole : 1.0;
        sum += square / ( of_guide * of_guide + least ) / (double)values;
    }
    return sum;
}

double hard_mean_weight_p( const HardPictures* p )
{
    double error, mean = mean_of( p->weight, p->count, &error );
    return fabs( mean - 1.0 ) <= ROUNDING ? 1.0 : student_p( fabs( mean - 1.0 ) / fmax( error, 1e-300 ), p->count - 1 );
}

int hard_count_lit( const HardPictures* p )
{
    int lit = 0;
    for ( int k = 0; k < p->count; ++k )
    {
        for ( size_t i = 0; i < 3 * (size_t)p->width * (size_t)p->height; ++i )
            lit += p->rgb[k][i] != 0.0;
    }
    return lit;
}

void hard_compare_value( const HardPictures* p, const HardScene* h, HardDifference* out )
{
    double means[HARD_MOST_SEEDS], error, value = h->value;
    for ( int k = 0; k < p->count; ++k )
        means[k] = block_mean( p, k, 0, 0, p->width, p->height );
    double mean = mean_of( means, p->count, &error );
    out->bias = mean / value - 1.0;
    out->interval = 1.96 * error / value;
    double beyond = fmax( fabs( mean - value ) - h->within * value, 0.0 );
    out->whole_p = beyond > 0.0 ? student_p( beyond / fmax( error, 1e-300 ), p->count - 1 ) : 1.0;
    out->block_p = 1.0;
}
