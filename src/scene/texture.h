// Textures: pixels in memory and how a material looks them up.
#ifndef REFRAME_SCENE_TEXTURE_H
#define REFRAME_SCENE_TEXTURE_H

#include <stdbool.h>
#include <stdint.h>

// An image in one colour space, rows from top to bottom. 8 bits stay 8 bits.
typedef struct RfTexture
{
    int width, height, channels; // 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha
    uint8_t* bytes;              // or NULL, and
    float* floats;               // linear
    float table[256];            // linear value of a byte of colour; alpha is linear as it is
    float largest;               // of all values of colour
} RfTexture;

typedef enum RfWrap
{
    RF_WRAP_REPEAT,
    RF_WRAP_MIRROR,
    RF_WRAP_CLAMP,
} RfWrap;

// One use of a texture.
typedef struct RfTextureRef
{
    int texture;        // index into RfScene.textures; −1: none
    int uv_set;         // 0 or 1
    RfWrap wrap[2];     // along u and v
    bool nearest;       // else bilinear
    float transform[6]; // u' = t0 u + t1 v + t2, v' = t3 u + t4 v + t5
} RfTextureRef;

// Where on the texture a point with these coordinates lies: u', v'.
void rf_transform_uv( const RfTextureRef* ref, const float uv[2], float out[2] );

// Linear RGB and alpha at u', v' (0, 0 is the image's upper left corner). Grey
// is spread over the three, a missing alpha is 1.
void rf_look_up( const RfTexture* texture, const RfTextureRef* ref, const float at[2], float rgba[4] );

// At least the largest value of colour that look-ups can give between the
// corners `low` and `high` in u', v'; 0 means that all of them are black.
float rf_texture_bound( const RfTexture* texture, const RfTextureRef* ref, const float low[2], const float high[2] );

#endif
