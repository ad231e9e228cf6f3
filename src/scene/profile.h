// Intensity profiles of lamps: a table over vertical and horizontal angles, bilinear in both, from an IES file (ANSI/IES LM-63)
// or from numbers.
//
// Directions are those in which light leaves, in the frame of the lamp's node: vertical angle 0 is −z, 180 degrees +z; horizontal
// angle 0 is −y, 90 degrees −x, as Blender takes the files. Outside of the vertical angles it is dark.
#ifndef REFRAME_SCENE_PROFILE_H
#define REFRAME_SCENE_PROFILE_H

#include "math/vec3.h"
#include "reframe/error.h"

#include <stddef.h>

#define RF_PROFILE_BYTES ( 16u << 20 ) // the largest IES file
#define RF_PROFILE_ANGLES 4096         // at most, along each axis
#define RF_PROFILE_VALUES ( 1 << 20 )

// Shared by the lamps that have it.
typedef struct RfProfile
{
    int references;
    int rows, columns;            // vertical and horizontal angles; two columns, 0 and 2π, where it is round about the axis
    float *vertical, *horizontal; // radians, ascending; horizontal ones from 0 to 2π
    float* value;                 // of a column all rows, then the next; at least 0
    double mean;                  // over the sphere
    float most;
    double cos_reach; // of the vertical angle beyond which it is dark; from above, where `up`
    double cos_half;  // of the angle beyond which it is at most half of the most
    bool up;          // it shines upwards only
} RfProfile;

// The angles of a table in degrees, and its values, all those of the first horizontal angle first.
typedef struct RfProfileTable
{
    int rows, columns;
    double *vertical, *horizontal, *value;
} RfProfileTable;

// Makes a profile of a table; its `references` is 1. Angles ascend, vertical ones within 0 to 180, horizontal ones either a single
// 0, or from 0 to 90 or 180 (mirrored), or to 360; 90 to 270 stand for 0 to 180, as in Blender. What ends up to 45 degrees short of 360
// closes the circle (LM-63-2002). Fails with RF_ERROR_FORMAT, and "`path`: " before the message, or RF_ERROR_MEMORY.
RfResult rf_make_profile( const char* path, const RfProfileTable* table, RfProfile** out, RfError* error );

// Reads the text of an IES file, of type C photometry, with TILT=NONE, or TILT=INCLUDE, whose factors are those of other
// positions of the lamp: candela, with its multiplier and ballast factors. Fails like rf_make_profile, with RF_ERROR_UNSUPPORTED for
// what is well-formed.
RfResult rf_read_ies( const char* path, const void* bytes, size_t size, RfProfile** out, RfError* error );

// One reference less; NULL is allowed.
void rf_release_profile( RfProfile* profile );

// The value in a unit direction.
float rf_profile_value( const RfProfile* profile, RfVec3 local );

#endif
