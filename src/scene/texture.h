// Textures: pixels in memory, and their lookup by a material.
#ifndef REFRAME_SCENE_TEXTURE_H
#define REFRAME_SCENE_TEXTURE_H

#include <stdbool.h>
#include <stdint.h>

// An image in one colour space, rows from top to bottom. 8-bit images are kept as 8 bits.
typedef struct RfTexture
{
    int width, height, channels; // 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha
    uint8_t* bytes;              // or NULL; then
    float* floats;               // linear
    float table[256];            // linear value of each byte of colour; alpha is stored linearly
    float largest;               // largest colour value
    double outside;              // share of its light beyond Rec. 709, which was clipped
    bool plays;                  // other images are seen at other times: a pose has that of its time
} RfTexture;

typedef enum RfWrap
{
    RF_WRAP_REPEAT,
    RF_WRAP_MIRROR,
    RF_WRAP_CLAMP,
} RfWrap;

// A use of a texture by a material.
typedef struct RfTextureRef
{
    int texture;        // index into RfScene.textures; −1: none
    int uv_set;         // 0 or 1
    RfWrap wrap[2];     // along u and v
    bool nearest;       // nearest neighbour; else bilinear
    float transform[6]; // u' = t0 u + t1 v + t2, v' = t3 u + t4 v + t5
} RfTextureRef;

// KHR_texture_transform: u' = T · R · S · u, the rotation in radians, counter-clockwise as the image is seen. Five numbers: offset,
// rotation, scale.
void rf_set_uv_transform( const double by[5], float transform[6] );

// Transforms the coordinates of a point to u', v' on the texture.
void rf_transform_uv( const RfTextureRef* ref, const float uv[2], float out[2] );

// Linear RGB and alpha at u', v'; (0, 0) is the upper left corner of the image. Grey is copied
// to RGB; without an alpha channel alpha is 1.
void rf_look_up( const RfTexture* texture, const RfTextureRef* ref, const float at[2], float rgba[4] );

// Fetches the texels of such a lookup into the cache.
void rf_prefetch_texels( const RfTexture* texture, const RfTextureRef* ref, const float at[2] );

// An upper bound of the colour values that lookups give between the corners `low` and `high`
// in u', v'; 0 means that they are all black, at all times.
float rf_texture_bound( const RfTexture* texture, const RfTextureRef* ref, const float low[2], const float high[2] );

#endif
