// The attributes by which compositors find a frame's Cryptomatte and the names in it (Cryptomatte Specification, "Metadata").
#ifndef REFRAME_OUTPUT_MATTE_STRINGS_H
#define REFRAME_OUTPUT_MATTE_STRINGS_H

#include "film/cryptomatte.h"
#include "image/exr.h"
#include "output/pass_names.h"
#include "reframe/output.h"

#define RF_MATTE_STRINGS ( 4 * RF_CRYPTOMATTE_KINDS )

// cryptomatte/KEY/name, hash, conversion and manifest of each kind, KEY the first seven digits of the hash of its name.
typedef struct RfMatteStrings
{
    RfExrString strings[RF_MATTE_STRINGS];
    int count;
    char names[RF_MATTE_STRINGS][40];
    char layers[RF_CRYPTOMATTE_KINDS][RF_PASS_CHANNEL_SIZE];
    char* manifests[RF_CRYPTOMATTE_KINDS];
} RfMatteStrings;

// Those of the kinds that the settings ask for, which point into `strings`.
RfResult rf_make_matte_strings( const RfOutput* output, RfMatteStrings* strings, RfError* error );
void rf_free_matte_strings( RfMatteStrings* strings );

#endif
