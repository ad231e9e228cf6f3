#include "reuse/spread.h"

#include <string.h>

typedef float Float4 __attribute__( ( vector_size( 16 ) ) );

// The pixels of the range that a sample counts in, and how much.
typedef struct Footprint
{
    int left, columns; // the first one, and how many
    int top, rows;
    float across[RF_FILTER_TAPS]; // by column
    float down[RF_FILTER_TAPS];   // by row
    bool in_range;                // the sample's own pixel
} Footprint;

// Of `reach` pixels around q those within [low, end).
static int clip( int q, int reach, int low, int end, float* weights, int* count )
{
    int first = q - reach > low ? q - reach : low, last = q + reach < end - 1 ? q + reach : end - 1;
    int skipped = first - ( q - reach );
    *count = last - first + 1;
    for ( int k = 0; k < *count && skipped > 0; ++k )
        weights[k] = weights[k + skipped];
    return first;
}

// False where no pixel of the range is in reach.
static bool find_footprint( const RfSpread* s, int32_t pixel, float u, float v, Footprint* f )
{
    int reach = s->filter->reach, y = pixel / s->width, x = pixel - y * s->width;
    int low = s->range.low / s->width, end = s->range.end / s->width;
    if ( y + reach < low || y - reach >= end )
        return false;
    rf_filter_weights( s->filter, x, u, s->width, f->across );
    rf_filter_weights( s->filter, y, v, s->height, f->down );
    f->left = clip( x, reach, 0, s->width, f->across, &f->columns );
    f->top = clip( y, reach, low, end, f->down, &f->rows );
    f->in_range = y >= low && y < end;
    return true;
}

// film += weight · (value, 1) in each pixel.
static void add( const RfSpread* s, const Footprint* f, float weight, const float* value )
{
    Float4 v;
    memcpy( &v, value, sizeof v );
    v *= weight;
    for ( int row = 0; row < f->rows; ++row )
    {
        float* film = s->range.film + 4 * ( (size_t)( f->top + row ) * (size_t)s->width + (size_t)f->left );
        Float4 of_row = v * f->down[row];
        for ( int k = 0; k < f->columns; ++k )
        {
            Float4 sum;
            memcpy( &sum, film + 4 * k, sizeof sum );
            sum += of_row * f->across[k];
            memcpy( film + 4 * k, &sum, sizeof sum );
        }
    }
}

static void add_sky( const RfSpread* s, const Footprint* f, float weight )
{
    for ( int row = 0; row < f->rows; ++row )
    {
        float* sky = s->range.sky + (size_t)( f->top + row ) * (size_t)s->width + (size_t)f->left;
        for ( int k = 0; k < f->columns; ++k )
            sky[k] += weight * f->down[row] * f->across[k];
    }
}

uint64_t rf_spread_hits( const RfHitBatch* batch, const RfAccumulateScratch* scratch, RfSpread s )
{
    uint64_t landed = 0;
    int first_glossy = batch->first[RF_BSDF_FIRST_GLOSSY];
    Footprint f;
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !( scratch->ratio[i] > 0.0f ) ||
             !find_footprint( &s, scratch->pixel[i], scratch->offset[0][i], scratch->offset[1][i], &f ) )
            continue;
        float value[4] = { 0.0f, 0.0f, 0.0f, 1.0f };
        for ( int c = 0; c < 3; ++c )
        {
            value[c] = i < first_glossy ? batch->radiance[4 * i + c] : scratch->sum[c][i - first_glossy];
            value[c] *= batch->has_views ? scratch->filter[c][i] : 1.0f;
        }
        add( &s, &f, scratch->ratio[i], value );
        landed += f.in_range;
    }
    return landed;
}

uint64_t rf_spread_own_frame( const RfHitBatch* batch, bool black, float weight, RfSpread s )
{
    static const float only_weight[4] = { 0.0f, 0.0f, 0.0f, 1.0f };
    uint64_t landed = 0;
    int others = batch->miss_count + batch->glint_count;
    Footprint f;
    for ( int k = 0; k < others; ++k )
    {
        int i = batch->count + k;
        if ( !find_footprint( &s, batch->pixel[i], batch->offset[0][i], batch->offset[1][i], &f ) )
            continue;
        bool miss = k < batch->miss_count;
        add( &s, &f, weight, black && miss ? only_weight : batch->radiance + 4 * (size_t)i );
        if ( s.range.sky != NULL && k < batch->sky_count )
            add_sky( &s, &f, weight );
        landed += miss && f.in_range;
    }
    return landed;
}
