// What settings, passes and frames are called, as users write it and files have it.
#ifndef REFRAME_OUTPUT_NAMES_H
#define REFRAME_OUTPUT_NAMES_H

#include "reframe/render.h"

// Words of settings, in the order of their enums, with NULL at the end.
extern const char* const rf_weights_words[];
extern const char* const rf_normalize_words[];
extern const char* const rf_light_paths_words[];
extern const char* const rf_guiding_words[];
extern const char* const rf_kernel_normalization_words[];
extern const char* const rf_reconstruction_words[];
extern const char* const rf_adaptive_words[];
extern const char* const rf_pass_names_words[];
extern const char* const rf_parts_words[];

// Whether users see another estimator than the usual one: that of the biased weights has its name.
bool rf_is_other_estimator( const RfEstimator* estimator );

// What the channels of a pass are called in a file: Reframe's own names, those of Blender's multilayer files, and those that
// Nuke reads as its layers; and which pass a channel of any of these has.
//
// Blender's passes are as Cycles of Blender 3.4 and 4.3, or of 5.0 and 5.2, writes them: motion to the next frame has the opposite sign (now minus
// next), normals are along the axes of its world, in which Z is up: (x, −z, y). Nuke's motion leads to the pixel's place in
// the other frame, as ours (Foundry, Ocula User Guide, "VectorGenerator").

#define RF_BLENDER_LAYER "ViewLayer" // Blender's own name for its first

#define RF_PASS_CHANNEL_SIZE 256 // bytes of a channel's name; OpenEXR has names of up to 255
#define RF_PASS_MOST 200         // bytes of a pass's name
#define RF_PASS_PICTURE ""       // the pass of R, G and B; that of A is "alpha"

// A channel of a pass.
typedef struct RfPassChannel
{
    char name[RF_PASS_CHANNEL_SIZE]; // "ViewLayer.Normal.Y"
    int component;                   // of the pass whose values it has: 2, the pass's Z
    bool negated;                    // and with the opposite sign
} RfPassChannel;

// Channel i of a pass with so many letters: "motion", "XYZW", 3. Passes are AOVs by name, "alpha", RF_PASS_PICTURE, "light_NAME" and
// layers such as "CryptoObject00". Those for which a program has no name of its own keep theirs.
void rf_name_pass_channel( RfPassNames names, const char* pass, const char* letters, int i, RfPassChannel* channel );

// The name of a layer in a file, without the letters of its channels: "ViewLayer.CryptoObject" for "CryptoObject".
void rf_name_pass_layer( RfPassNames names, const char* pass, char name[RF_PASS_CHANNEL_SIZE] );

// Whether a channel of a file, by its full name or that in its part, has this letter of a pass by any of the namings;
// *negated: with the opposite sign.
bool rf_is_pass_channel( const char* channel, const char* pass, char letter, bool* negated );

// Time codes of frames: hours, minutes, seconds and frames as in SMPTE ST 12-1, packed as OpenEXR's attribute timeCode.

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
