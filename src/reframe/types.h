// What the other public headers share: linkage, vectors, frame rates, the version.
#ifndef REFRAME_TYPES_H
#define REFRAME_TYPES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// What stands between these two has C linkage and is visible in the shared library.
// Nothing else of the library is.
#ifdef __cplusplus
#define RF_API_BEGIN                                                                                                             \
    extern "C"                                                                                                                   \
    {                                                                                                                            \
        _Pragma( "GCC visibility push(default)" )
#define RF_API_END                                                                                                               \
    _Pragma( "GCC visibility pop" )                                                                                              \
    }
#else
#define RF_API_BEGIN _Pragma( "GCC visibility push(default)" )
#define RF_API_END _Pragma( "GCC visibility pop" )
#endif

RF_API_BEGIN

// A point, a direction or a linear RGB colour. Lengths are metres.
typedef struct RfVec3
{
    float x, y, z;
} RfVec3;

// Frames per second as a fraction: 24/1, 24000/1001.
typedef struct RfFps
{
    int numerator;
    int denominator;
} RfFps;

// The version of the library that is linked, such as "1.0.0".
const char* rf_version( void );

// The version of its pictures: a number that grows when the same settings make others.
int rf_pictures( void );

// What it was built with of the libraries that it can do without, such as "Draco, WebP"; "" where there are none.
const char* rf_built_with( void );

RF_API_END

#endif
