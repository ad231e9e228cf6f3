// Adds what cameras see first to the tables of the pixels, by the weights and the filter of the colour: as `alpha`.
#include "reuse/accumulate/covering_weights.h"

static void cover( const RfSplat* s, int32_t pixel, float u, float v, uint32_t surface, float weight )
{
    int y = pixel / s->width, x = pixel - y * s->width, first_row = s->low / s->width, end_row = s->end / s->width;
    if ( !rf_has_filter( s->filter ) )
    {
        if ( y >= first_row && y < end_row )
            rf_add_covering( s->covering + pixel, surface, weight );
        return;
    }
    int reach = s->filter->reach;
    float across[RF_FILTER_TAPS], down[RF_FILTER_TAPS];
    if ( y + reach < first_row || y - reach >= end_row )
        return;
    rf_filter_weights( s->filter, x, u, s->width, across );
    rf_filter_weights( s->filter, y, v, s->height, down );
    for ( int row = 0; row < s->filter->taps; ++row )
    {
        int to_y = y + row - reach;
        for ( int k = 0; k < s->filter->taps && to_y >= first_row && to_y < end_row; ++k )
        {
            float share = weight * across[k] * down[row]; // 0 outside the film
            if ( share > 0.0f )
                rf_add_covering( s->covering + (size_t)to_y * (size_t)s->width + (size_t)( x + k - reach ), surface, share );
        }
    }
}

void rf_cover_rows( const RfSplat* s, const RfHitBatch* batch, bool own, const RfLandedHits* landing )
{
    bool filtered = rf_has_filter( s->filter );
    for ( int i = 0; i < landing->count; ++i )
        cover( s, landing->pixel[i], filtered ? landing->offset[0][i] : 0.0f, filtered ? landing->offset[1][i] : 0.0f,
               landing->surface[i], landing->ratio[i] );
    for ( int i = batch->count; own && i < batch->count + batch->miss_count; ++i )
        cover( s, batch->pixel[i], filtered ? batch->offset[0][i] : 0.0f, filtered ? batch->offset[1][i] : 0.0f,
               batch->surface[i], s->weight );
}
