#include "gradient/gradient_films.h"

typedef struct Target
{
    float* film[RF_GRADIENT_FILMS];
    float weight, primal_weight; // of differences, of values
    int width;
} Target;

// Adds `value` with its weight to a film, and its square to that of the squares.
static inline void add( const Target* t, int film, size_t pixel, float weight, const float value[3] )
{
    float *sum = t->film[film] + 4 * pixel, square = 0.0f;
    for ( int c = 0; c < 3; ++c )
    {
        sum[c] += weight * value[c];
        square += value[c] * value[c];
    }
    sum[3] += weight;
    t->film[RF_FILM_SQUARES][4 * pixel + (size_t)film] += weight * square;
}

static inline void add_difference( const Target* t, int film, size_t pixel, const float here[3], const float there[3] )
{
    add( t, film, pixel, t->weight, ( float[3] ){ there[0] - here[0], there[1] - here[1], there[2] - here[2] } );
}

static inline void add_unshared( const Target* t, size_t pixel, const float value[3] )
{
    float* sum = t->film[RF_FILM_UNSHARED] + 4 * pixel;
    for ( int c = 0; c < 3; ++c )
        sum[c] += t->primal_weight * value[c];
    sum[3] += t->primal_weight;
}

// Adds the rows of a tile that belong to the job. All its pixels and pairs count, also those that other tiles have.
static uint64_t add_tile( const Target* t, const RfExtendedTile* tile, const RfGradientBatch* batch, int lane,
                          RfAccumulateJob job )
{
    int across = tile->x1 - tile->x0;
    int first = tile->y0 > job.first_row ? tile->y0 : job.first_row, end = tile->y1 < job.end_row ? tile->y1 : job.end_row;
    for ( int y = first; y < end; ++y )
    {
        for ( int x = tile->x0; x < tile->x1; ++x )
        {
            int here = lane + ( y - tile->y0 ) * across + ( x - tile->x0 );
            size_t pixel = (size_t)y * (size_t)t->width + (size_t)x;
            add( t, RF_FILM_PRIMAL, pixel, t->primal_weight, batch->value[here] );
            add_unshared( t, pixel, batch->unshared[here] );
            if ( x + 1 < tile->x1 )
                add_difference( t, RF_FILM_DX, pixel, batch->common[here], batch->common[here + 1] );
            if ( y + 1 < tile->y1 )
                add_difference( t, RF_FILM_DY, pixel, batch->common[here], batch->common[here + across] );
            if ( job.landed != NULL )
                job.landed[pixel] += 1;
            if ( job.sky != NULL )
                job.sky[pixel] += t->primal_weight * batch->value[here][3];
        }
    }
    return end > first ? (uint64_t)( end - first ) * (uint64_t)across : 0;
}

uint64_t rf_accumulate_gradients( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count )
{
    // a pixel is in eight pairs, of which four have the same path
    float share = group->settings->tile.kind == RF_TILE_NONE ? 0.25f : 1.0f;
    Target target = { .weight = job.weight, .primal_weight = share * job.weight, .width = group->width };
    for ( int f = 0; f < RF_GRADIENT_FILMS; ++f )
        target.film[f] = job.films[f].half[job.half];
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfGradientBatch* batch = batches[k];
        int lane = 0;
        for ( int i = 0; i < batch->tile_count && batch->eye == job.eye; ++i )
        {
            landed += add_tile( &target, batch->tile + i, batch, lane, job );
            lane += rf_tile_area( batch->tile + i );
        }
    }
    return landed;
}
