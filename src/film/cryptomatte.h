// Cryptomatte: ids of names, ranks of a pixel's coverage, and the manifest (Friedman, Jones, Cryptomatte Specification, version 1.2,
// Psyop 2018, github.com/Psyop/Cryptomatte/specification).
#ifndef REFRAME_FILM_CRYPTOMATTE_H
#define REFRAME_FILM_CRYPTOMATTE_H

#include "film/covering.h"

#define RF_CRYPTOMATTE_KINDS 3
#define RF_CRYPTOMATTE_LAYERS 3 // of a kind: two ranks each

// Kind k is that of the set's bit 1 << k.
typedef struct RfCryptomatteKind
{
    const char* word;                          // "object"
    const char* name;                          // "CryptoObject"
    const char* layers[RF_CRYPTOMATTE_LAYERS]; // "CryptoObject00" and so on
} RfCryptomatteKind;
extern const RfCryptomatteKind g_rf_cryptomatte_kinds[RF_CRYPTOMATTE_KINDS];

// MurmurHash3_x86_32 of a text with seed 0 (Appleby 2011, public domain).
uint32_t rf_murmur3_32( const char* text );

// The bits of the 32-bit float that is the id of a name: its hash, with the exponent kept from 0 and 255, which are zero,
// denormals, infinity and NaN.
uint32_t rf_cryptomatte_id( const char* name );

// The ids of what surfaces are, by object (from node −1 on) or by material.
typedef struct RfCryptomatteIds
{
    int kind;
    uint32_t material_count; // of the scene
    uint32_t* id;            // owned
} RfCryptomatteIds;
RfResult rf_make_cryptomatte_ids( const RfScene* scene, int kind, RfCryptomatteIds* ids, RfError* error );
void rf_destroy_cryptomatte_ids( RfCryptomatteIds* ids );

// Warns of different names with one id, once for each pair of the set of kinds: a matte of one is that of the other, too.
void rf_warn_of_equal_ids( const RfScene* scene, unsigned kinds, RfLog* log );

// The ranks of a frame: layer k has RGBA for each pixel, the ids and coverages of ranks 2 k and 2 k + 1, in descending order of
// coverage, which is the share of the weight of all samples. Ranks without a surface are 0. Surfaces of one name are one.
void rf_finish_cryptomatte( const RfCovering* pixels, size_t count, const RfCryptomatteIds* ids,
                            float* const layers[RF_CRYPTOMATTE_LAYERS] );

// JSON with all names of a kind that surfaces of the scene have, and their ids as 8 hexadecimal digits: {"bunny":"13851a76"}. The
// caller frees it; NULL: there is no memory.
char* rf_cryptomatte_manifest( const RfScene* scene, int kind );

#endif
