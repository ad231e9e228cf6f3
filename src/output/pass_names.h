// What the channels of a pass are called in a file: Reframe's own names, those of Blender's multilayer files, and those that
// Nuke reads as its layers; and which pass a channel of any of these has.
//
// Blender's passes are as Cycles of Blender 3.4 and 4.3 writes them: motion to the next frame has the opposite sign (now minus
// next), normals are along the axes of its world, in which Z is up: (x, −z, y). Nuke's motion leads to the pixel's place in
// the other frame, as ours (Foundry, Ocula User Guide, "VectorGenerator").
#ifndef REFRAME_OUTPUT_PASS_NAMES_H
#define REFRAME_OUTPUT_PASS_NAMES_H

#include "reframe/render_settings.h"

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

#endif
