// Counter-based random numbers: a key made of (seed, frame, group, pass, pixel) and a
// dimension give a number, independent of call order and thread. So results are the same bit
// for bit with any number of threads, any split of the frames and after any resume.
//
// The mixing function is the two-round multiply-xorshift of C. Wellons' hash prospector
// ("lowbias32"); a key of two words decorrelates streams that share one of them.
#ifndef REFRAME_BASE_RANDOM_H
#define REFRAME_BASE_RANDOM_H

#include <stdint.h>

typedef struct RfRandomKey
{
    uint32_t a, b;
} RfRandomKey;

static inline uint32_t rf_mix32( uint32_t x )
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

// 64-bit finaliser (splitmix64) for the slow, outer part of a key.
static inline uint64_t rf_mix64( uint64_t x )
{
    x += 0x9e3779b97f4a7c15ull;
    x = ( x ^ ( x >> 30 ) ) * 0xbf58476d1ce4e5b9ull;
    x = ( x ^ ( x >> 27 ) ) * 0x94d049bb133111ebull;
    return x ^ ( x >> 31 );
}

// The part of the key common to all pixels of a pass.
static inline uint64_t rf_pass_key( uint64_t seed, uint32_t frame, uint32_t group, uint32_t pass )
{
    uint64_t key = rf_mix64( seed );
    key = rf_mix64( key ^ ( (uint64_t)frame << 32 | group ) );
    return rf_mix64( key ^ pass );
}

// The key of the path of one pixel in one pass.
static inline RfRandomKey rf_pixel_key( uint64_t pass_key, uint32_t pixel )
{
    uint64_t key = rf_mix64( pass_key ^ pixel );
    return ( RfRandomKey ){ (uint32_t)key, (uint32_t)( key >> 32 ) };
}

// 32 random bits for one dimension.
static inline uint32_t rf_random_bits( RfRandomKey key, uint32_t dimension )
{
    return rf_mix32( rf_mix32( key.a + dimension * 0x9e3779b9u ) ^ key.b );
}

// 24 of 32 bits as a fraction in [0, 1).
static inline float rf_fraction( uint32_t bits ) { return (float)(int32_t)( bits >> 8 ) * 0x1p-24f; }
static inline float rf_random( RfRandomKey key, uint32_t dimension ) { return rf_fraction( rf_random_bits( key, dimension ) ); }

#endif
