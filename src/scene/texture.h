// Textures: pixels in memory, their lookup by a material, and textures that show image after image.
#ifndef REFRAME_SCENE_TEXTURE_H
#define REFRAME_SCENE_TEXTURE_H

#include "image/decode.h"

#include <stdbool.h>
#include <stddef.h>
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
    void* levels;    // owned: mip levels from 1 on, one after the other, bytes or floats; NULL: there is level 0 alone
    int level_count; // with level 0; each is half as wide and high as the one before, rounded down, 1 at least
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

// Makes mip levels, linear means of pixels by the area that a pixel of the level covers, which rf_destroy_texture frees. Not for
// sequences. False: there is no memory.
bool rf_make_mip_levels( RfTexture* texture );

void rf_drop_mip_levels( RfTexture* texture );

// Linear RGB and alpha at u', v'; (0, 0) is the upper left corner of the image. Grey is copied
// to RGB; without an alpha channel alpha is 1. `level`: between which mip levels it is interpolated (Williams 1983); up to 0, and
// with nearest neighbours, it is the image.
void rf_look_up( const RfTexture* texture, const RfTextureRef* ref, const float at[2], float level, float rgba[4] );

// The mip level whose pixels have an area, in square units of u', v'.
float rf_mip_level( const RfTexture* texture, double area );

// Fetches the texels of such a lookup of level 0 into the cache.
void rf_prefetch_texels( const RfTexture* texture, const RfTextureRef* ref, const float at[2] );

// An upper bound of the colour values that lookups give between the corners `low` and `high`
// in u', v'; 0 means that they are all black, at all times.
float rf_texture_bound( const RfTexture* texture, const RfTextureRef* ref, const float low[2], const float high[2] );

// Limit of one image file.
#define RF_MAX_IMAGE_BYTES ( (uint64_t)1 << 30 )

// Makes a texture of pixels, whose data it may take. `where` begins the message. Free with rf_destroy_texture, also on failure.
RfResult rf_make_texture( const char* where, RfPixels* pixels, bool srgb, RfTexture* out, RfError* error );

void rf_destroy_texture( RfTexture* texture );

// Bytes of the texture that it makes of such pixels.
size_t rf_texture_bytes( const RfPixels* pixels );

// One image for each number, shown at its time until the next is.
typedef struct RfImageSequence
{
    int texture; // of the scene
    bool srgb;
    char* pattern; // owned: the path, with a run of # for the number
    int first, last;
    double start;   // seconds of the scene up to which, and from which on, the first is shown
    double fps;     // images per second
    bool loops;     // it begins again after the last, which else stays
    double most;    // limit of the values of a pixel
    size_t bytes;   // of the largest, as a texture
    size_t scratch; // bytes that reading it takes meanwhile
} RfImageSequence;

// The number of the image at a time. Times of frames are rounded: an image comes a hundredth of its time early.
int rf_sequence_number( const RfImageSequence* sequence, double time );

// From the first image to the last, in seconds of the scene, which begins at 0.
void rf_sequence_span( const RfImageSequence* sequence, double* start, double* end );

// Reads the headers of all images: sets `bytes` and `scratch`, and extends a hash by the images.
RfResult rf_measure_sequence( RfImageSequence* sequence, uint64_t* hash, RfError* error );

// Decodes an image; free it with rf_destroy_texture.
RfResult rf_load_sequence_image( const RfImageSequence* sequence, int number, RfTexture* out, RfError* error );

// The same in memory of sequence->bytes. Nothing is to be freed.
RfResult rf_place_sequence_image( const RfImageSequence* sequence, int number, void* memory, RfTexture* out, RfError* error );

#endif
