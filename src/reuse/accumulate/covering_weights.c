// Adds what cameras see first to the tables of the pixels, by the weights and the filter of the colour: as `alpha`.
#include "reuse/accumulate/covering_weights.h"

// Where a sample goes.
typedef struct Cover
{
    const RfPixelFilter* filter;
    RfAccumulateJob job;
    int width, height; // of the film
} Cover;

static void cover( const Cover* c, int32_t pixel, float u, float v, uint32_t surface, float weight )
{
    int y = pixel / c->width, x = pixel - y * c->width;
    if ( !rf_has_filter( c->filter ) )
    {
        if ( y >= c->job.first_row && y < c->job.end_row )
            rf_add_covering( c->job.covering + pixel, surface, weight );
        return;
    }
    int reach = c->filter->reach;
    float across[RF_FILTER_TAPS], down[RF_FILTER_TAPS];
    if ( y + reach < c->job.first_row || y - reach >= c->job.end_row )
        return;
    rf_filter_weights( c->filter, x, u, c->width, across );
    rf_filter_weights( c->filter, y, v, c->height, down );
    for ( int row = 0; row < c->filter->taps; ++row )
    {
        int to_y = y + row - reach;
        for ( int k = 0; k < c->filter->taps && to_y >= c->job.first_row && to_y < c->job.end_row; ++k )
        {
            float share = weight * across[k] * down[row]; // 0 outside the film
            if ( share > 0.0f )
                rf_add_covering( c->job.covering + (size_t)to_y * (size_t)c->width + (size_t)( x + k - reach ), surface, share );
        }
    }
}

void rf_cover_rows( const RfAccumulation* a, RfAccumulateJob job, const RfHitBatch* batch, const RfAccumulateScratch* scratch )
{
    Cover c = { .filter = a->filter, .job = job, .width = a->eyes[job.eye].width, .height = a->eyes[job.eye].height };
    bool own = job.eye == batch->eye, filtered = rf_has_filter( a->filter );
    const uint32_t* seen = own || batch->surface_seen == NULL ? batch->surface : batch->surface_seen + (size_t)job.eye * RF_LANES;
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( scratch->ratio[i] > 0.0f )
            cover( &c, scratch->pixel[i], filtered ? scratch->offset[0][i] : 0.0f, filtered ? scratch->offset[1][i] : 0.0f,
                   seen[i], scratch->ratio[i] );
    }
    for ( int i = batch->count; own && i < batch->count + batch->miss_count; ++i )
        cover( &c, batch->pixel[i], filtered ? batch->offset[0][i] : 0.0f, filtered ? batch->offset[1][i] : 0.0f,
               batch->surface[i], a->weight );
}
