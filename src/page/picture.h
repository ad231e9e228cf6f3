// A compact HDR image format for a browser, to be displayed at any exposure without visible banding.
//
// The 8 bits of a JPEG are too few for the logarithm of the whole range: 26 stops in 256 steps give bands of 7 %. So the logarithm is
// split into two layers:
//   base    the brightness at the centres of cells of 16×16 pixels, in 1/256 stop, interpolated bilinearly between the centres
//   detail  the difference of a pixel to its base in stops, as a byte 128 ± 32 ln( 1 + 2 |stops| ): steps of 1/64 stop next to the base
//           (1.1 %, as of an 8-bit sRGB display in the highlights), wider farther from it, where an edge hides them. A JPEG
// The logarithm is log2( max( v, 0 ) + 1/512 ): anything darker is invisible even at +6 stops. The base of a cell is the square of its
// mean square root: close to its bright pixels, but not dominated by a firefly.
//
// Layout: cell size, columns and rows of the base (16 bits each, little-endian like all that follows); 3 · columns · rows signed 16-bit
// values, red, green and blue interleaved, row by row; then the JPEG.
#ifndef REFRAME_PAGE_PICTURE_H
#define REFRAME_PAGE_PICTURE_H

#include "reframe/image.h"

#define RF_PICTURE_CELL 16
#define RF_PICTURE_QUALITY 90
// A limit of the mean bits per pixel; noisier images get a lower quality.
#define RF_PICTURE_MAX_BITS 8.5

// Encodes the image with `most_bits` per pixel or fewer; the caller frees *bytes. NaN becomes bright magenta, so that it is noticed, and
// infinity the brightest value. `name` begins the message. Fails with RF_ERROR_MEMORY, or RF_ERROR_USAGE if the size is out of bounds.
RfResult rf_encode_picture( const RfImage* image, double most_bits, const char* name, unsigned char** bytes, size_t* size,
                            RfError* error );

// Averages boxes of `factor` × `factor` pixels, cropped at the right and lower border. NaN stays NaN.
RfResult rf_shrink_image( const RfImage* image, int factor, RfImage* small, RfError* error );

// Pictures of AOVs: values to light that the page shows through the sRGB curve.

typedef enum RfLook
{
    RF_LOOK_LIGHT,     // three channels as they are
    RF_LOOK_DEVIATION, // three channels of variance: their square roots
    RF_LOOK_NORMAL,    // three channels: (1 + n) / 2; black where there is none
    RF_LOOK_DEPTH,     // one channel: near is white, far dark, by the logarithm; nothing is black
    RF_LOOK_MOTION,    // two channels: red to the right, green up, grey at rest
    RF_LOOK_SHARE,     // one channel: the part of `high`
    RF_LOOK_SIGNED,    // three channels: 0 is grey, black and white are -high and high
    RF_LOOK_INDEX,     // one channel of whole numbers, each a colour; 0 is black
    RF_LOOK_MATTES,    // any number of pairs, id and coverage: the ids' colours by their coverage (rf_draw_mattes)
} RfLook;

// What black and white stand for: depth from low to high, the others up to high.
typedef struct RfLookRange
{
    float low, high;
} RfLookRange;

// Channels that a look takes: 1, 2 or 3; of mattes the least, 2.
int rf_look_channels( RfLook look );

// The range of `pixels` pixels of interleaved values, `stride` floats apart.
RfLookRange rf_look_range( RfLook look, const float* values, size_t stride, size_t pixels );

// Draws them; three floats for each pixel.
void rf_draw_look( RfLook look, RfLookRange range, const float* values, size_t stride, size_t pixels, float* rgb );

// The same of mattes: `pairs` of id and coverage a pixel. The bits of an id are its number, 0 is nothing: black.
void rf_draw_mattes( const float* values, int pairs, size_t stride, size_t pixels, float* rgb );

// Scene values of a frame, for the pixel probe of the page: linear, as half floats.
//
// Layout, little-endian: factor, columns, rows (16 bits each); then columns · rows values of red,
// green and blue as half floats, interleaved, rows from top to bottom. A value is the mean of a box
// of factor × factor pixels, cropped at the right and lower border.

#define RF_VALUES_HEADER_BYTES 6
#define RF_VALUES_MAX_FACTOR 64

// The same of values, clamped to ±65504; NaN and infinity stay.
RfResult rf_encode_values( const RfImage* image, int factor, const char* name, unsigned char** bytes, size_t* size,
                           RfError* error );

// The bytes that an image takes on the page, as base64.
double rf_values_page_bytes( int width, int height, int factor );

// The smallest factor whose values take no more than `most` bytes of the page; 0: none does.
int rf_values_factor( int width, int height, double most );

#endif
