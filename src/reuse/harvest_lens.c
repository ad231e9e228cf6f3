// Depth of field and motion blur: a batch is harvested by pinholes (src/reuse/estimators.md, section 12).
#include "reuse/harvest_internal.h"

#define LENS_SALT 0x1e4500000000u // keeps the random numbers of the lens apart

RfLensSample rf_draw_lens( const RfHarvest* harvest, RfTraceJob job )
{
    uint64_t pass_key = rf_harvest_key( harvest, job.eye, job.pass ) ^ LENS_SALT;
    RfRandomKey key = rf_pixel_key( rf_mix64( pass_key + (uint64_t)harvest->round ), (uint32_t)job.job );
    return ( RfLensSample ){ rf_random( key, 0 ), rf_random( key, 1 ), rf_random( key, 2 ) };
}

RfHarvest rf_harvest_at( const RfHarvest* harvest, RfLensSample lens, RfHarvestScratch* scratch )
{
    RfHarvest at = *harvest;
    if ( !rf_is_blurred_shape( &harvest->shape ) )
        return at;
    for ( int l = 0; l < harvest->shape.eyes; ++l )
        scratch->eyes[l] = rf_sample_eye( harvest->eyes + l, lens );
    at.eyes = scratch->eyes;
    return at;
}
