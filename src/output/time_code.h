// Time codes of frames: hours, minutes, seconds and frames as in SMPTE ST 12-1, packed as OpenEXR's attribute timeCode.
#ifndef REFRAME_OUTPUT_TIME_CODE_H
#define REFRAME_OUTPUT_TIME_CODE_H

#include "reframe/error.h"
#include "reframe/types.h"

// How frames are counted at a rate.
typedef struct RfTimeCodeRate
{
    int frames; // that a second of the time code has: 30 at 30000/1001 frames per second; 0: the rate has no time code
    bool drops; // leaves out numbers, 2 or 4 of each minute but every tenth, so as to agree with the clock at 29.97 and 59.94
} RfTimeCodeRate;

// That of whole rates up to 30, 48, 50 and 60, and of these times 1000/1001, without dropping.
RfTimeCodeRate rf_time_code_rate( RfFps fps );

// Reads "HH:MM:SS:FF", or "HH:MM:SS;FF" of a time code that drops, into frames since 00:00:00:00. Fails with RF_ERROR_USAGE for
// what is none at the rate.
RfResult rf_parse_time_code( const char* text, RfFps fps, RfTimeCodeRate* rate, int64_t* frames, RfError* error );

// The time code of so many frames after 00:00:00:00, in BCD with flags, as in the 32 bits of a television of 60 fields (OpenEXR:
// TV60_PACKING of its class TimeCode); a day later they are the same. Above 30 frames per second two frames have one number, and
// the field mark is set in the second. 0 where the rate has none.
uint32_t rf_pack_time_code( RfTimeCodeRate rate, int64_t frames );

#endif
