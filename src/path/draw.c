// The random numbers of vertices.
#include "path/wavefront.h"

void rf_draw_lanes( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, int numbers,
                    float random[][RF_LANES] )
{
    for ( int k = 0; k < numbers; ++k )
    {
        float* restrict out = random[k];
#pragma omp simd
        for ( int i = 0; i < count; ++i )
        {
            RfRandomKey key = { keys->key_a[slot[i]], keys->key_b[slot[i]] };
            out[i] = rf_random( key, dimension + (uint32_t)k );
        }
    }
}

// Two words to select a light: of the dimension and of its twin.
static void draw_bits( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, uint32_t bits[2][RF_LANES] )
{
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfRandomKey key = { keys->key_a[slot[i]], keys->key_b[slot[i]] };
        bits[0][i] = rf_random_bits( key, dimension );
        bits[1][i] = rf_random_bits( key, dimension | RF_DIMENSION_TWIN );
    }
}

void rf_draw_light_numbers( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, RfLaneScratch* scratch )
{
    uint32_t own = dimension & ~RF_DIMENSION_OPPOSITE;
    draw_bits( keys, count, slot, own, scratch->bits );
    rf_draw_lanes( keys, count, slot, own + 1, 2, scratch->random );
    if ( own == dimension )
        return;
    float *u = scratch->random[0], *v = scratch->random[1];
    for ( int i = 0; i < count; ++i )
    {
        scratch->bits[0][i] ^= 0x80000000u;
        u[i] += u[i] < 0.5f ? 0.5f : -0.5f;
        v[i] += v[i] < 0.5f ? 0.5f : -0.5f;
    }
}
