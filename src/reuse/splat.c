#include "reuse/splat.h"

#include <string.h>

typedef float Float4 __attribute__( ( vector_size( 16 ) ) );

// film += r · (value, 1), four lanes at once. Spelled out, since the compiler would go through
// the stack and stall on it.
static inline void add_to_pixel( float* film, float ratio, const float* value )
{
    Float4 v, sum;
    memcpy( &v, value, sizeof v );
    memcpy( &sum, film, sizeof sum );
    sum += v * ratio;
    memcpy( film, &sum, sizeof sum );
}

// rf_splat_diffuse for batches with views, whose ways to the eye have filters.
static uint64_t splat_filtered( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range )
{
    uint64_t landed = 0;
    for ( int i = 0; i < batch->first[RF_BSDF_FIRST_GLOSSY]; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( !( s->ratio[i] > 0.0f ) || pixel < range.low || pixel >= range.end )
            continue;
        const float* value = batch->radiance + 4 * i;
        float filtered[4] = { value[0] * s->filter[0][i], value[1] * s->filter[1][i], value[2] * s->filter[2][i], 1.0f };
        add_to_pixel( range.film + 4 * (size_t)pixel, s->ratio[i], filtered );
        ++landed;
    }
    return landed;
}

uint64_t rf_splat_diffuse( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range )
{
    if ( rf_has_views( batch ) )
        return splat_filtered( batch, s, range );
    uint64_t landed = 0;
    int count = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = 0; i < count; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( s->ratio[i] > 0.0f && pixel >= range.low && pixel < range.end )
        {
            add_to_pixel( range.film + 4 * (size_t)pixel, s->ratio[i], batch->radiance + 4 * i );
            ++landed;
        }
    }
    return landed;
}

uint64_t rf_splat_glossy( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range )
{
    uint64_t landed = 0;
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = first; i < batch->count; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( s->ratio[i] > 0.0f && pixel >= range.low && pixel < range.end )
        {
            float value[4] = { s->sum[0][i - first], s->sum[1][i - first], s->sum[2][i - first], 1.0f };
            for ( int c = 0; c < 3 && rf_has_views( batch ); ++c )
                value[c] *= s->filter[c][i];
            add_to_pixel( range.film + 4 * (size_t)pixel, s->ratio[i], value );
            ++landed;
        }
    }
    return landed;
}

static void splat_sky( const RfHitBatch* batch, float weight, RfPixelRange range )
{
    for ( int i = 0; i < batch->sky_count; ++i )
    {
        int32_t pixel = rf_miss_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
            range.sky[pixel] += weight;
    }
}

uint64_t rf_splat_misses( const RfHitBatch* batch, bool black, float weight, RfPixelRange range )
{
    if ( rf_calls_for( range.sky != NULL, RF_EFFECT_ALPHA ) )
        splat_sky( batch, weight, range );
    uint64_t landed = 0;
    for ( int i = 0; i < batch->miss_count; ++i )
    {
        int32_t pixel = rf_miss_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
        {
            if ( black )
                range.film[4 * (size_t)pixel + 3] += weight;
            else
                add_to_pixel( range.film + 4 * (size_t)pixel, weight, rf_miss_radiance( batch ) + 4 * (size_t)i );
            ++landed;
        }
    }
    return landed;
}

void rf_splat_glints( const RfHitBatch* batch, float weight, RfPixelRange range )
{
    for ( int i = 0; i < batch->glint_count; ++i )
    {
        int32_t pixel = rf_glint_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
            add_to_pixel( range.film + 4 * (size_t)pixel, weight, rf_glint_radiance( batch ) + 4 * (size_t)i );
    }
}

void rf_count_landed( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range, uint32_t* landed )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( s->ratio[i] > 0.0f && pixel >= range.low && pixel < range.end )
            landed[pixel] += 1;
    }
}

void rf_count_misses( const RfHitBatch* batch, RfPixelRange range, uint32_t* landed )
{
    for ( int i = 0; i < batch->miss_count; ++i )
    {
        int32_t pixel = rf_miss_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
            landed[pixel] += 1;
    }
}
