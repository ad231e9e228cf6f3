// Textures out of images, and textures that show image after image.
#ifndef REFRAME_SCENE_IMAGE_SEQUENCE_H
#define REFRAME_SCENE_IMAGE_SEQUENCE_H

#include "image/decode.h"
#include "scene/texture.h"

#include <stddef.h>
#include <stdint.h>

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
