// A picture of linear light that a browser can show at any exposure: small, and
// without bands at the stops where it is looked at.
//
// A JPEG has 8 bits, which is too few for the logarithm of a whole range of light:
// 26 stops in 256 steps are bands of 7 %. So the logarithm is split:
//   base    the brightness of cells of 16x16 pixels, at each cell's centre, in
//           1/256 stop, for red, green and blue; between the centres bilinear
//   detail  how many stops a pixel lies above its base, as a byte
//               128 ± 32 ln( 1 + 2 |stops| )
//           whose steps are 1/64 stop (1.1 %, the step of an 8-bit sRGB display in
//           its lights) next to the base, wider the farther from it, where an edge hides
//           them, and reach ±26 stops; as a JPEG with full chroma
// The logarithm is log2( max( v, 0 ) + 1/512 ): no one sees what is darker, at +6
// stops even. The base of a cell is the square of the mean root of its values: close
// to its lights, and not carried away by a firefly.
//
// The bytes: side of a cell, columns, rows of the base (16 bits each, little-endian,
// as all that follows), 3 columns · rows signed 16-bit values, red, green and blue
// interleaved, row by row; then the JPEG.
#ifndef REFRAME_PAGE_PICTURE_H
#define REFRAME_PAGE_PICTURE_H

#include "reframe/image.h"

#define RF_PICTURE_CELL 16
#define RF_PICTURE_QUALITY 90
// What a pixel may take, on the mean; noisier pictures get a lower quality.
#define RF_PICTURE_MAX_BITS 8.5

// Encodes the image; the caller frees *bytes. NaN becomes magenta and bright, so
// that it shows, infinity the brightest. `name` begins the error line. Fails with
// RF_ERROR_MEMORY, or RF_ERROR_USAGE where the sides are out of bounds.
RfResult rf_encode_picture( const RfImage* image, const char* name, unsigned char** bytes, size_t* size, RfError* error );

// The mean over boxes of `factor` x `factor` pixels, those at the right and the lower
// border cut. The image is the caller's to destroy. NaN stays NaN.
RfResult rf_shrink_image( const RfImage* image, int factor, RfImage* small, RfError* error );

#endif
