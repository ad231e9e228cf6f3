// Image files made in memory, for the tests of what reads them. The bytes are
// the caller's to free.
#ifndef REFRAME_TESTS_IMAGE_FILES_H
#define REFRAME_TESTS_IMAGE_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// 1 to 4 channels (grey, grey and alpha, RGB, RGBA) of 8 bits.
uint8_t* encode_png( int width, int height, int channels, const uint8_t* pixels, size_t* size );
// Grey or RGB of 16 bits, with a gamma of 1 named in the file.
uint8_t* encode_png16( int width, int height, int channels, const uint16_t* pixels, size_t* size );
// Grey, RGB or CMYK (4), quality 100 without subsampling.
uint8_t* encode_jpeg( int width, int height, int channels, const uint8_t* pixels, size_t* size );
#ifdef REFRAME_WEBP
// RGB or RGBA, lossless or of quality 100.
uint8_t* encode_webp( int width, int height, int channels, bool lossy, const uint8_t* pixels, size_t* size );
#endif
// Run-length encoded from 8 pixels a row, else flat. 4 bytes per pixel: RGBE.
uint8_t* encode_hdr( int width, int height, const uint8_t* rgbe, size_t* size );
// ZIP, 32-bit floats, 3 per pixel.
uint8_t* encode_exr( int width, int height, float* rgb, size_t* size );

// A PNG's first bytes that promise this size, with nothing behind them.
size_t promise_png( uint8_t bytes[64], uint32_t width, uint32_t height );

// ---- foreign exr ----

// EXR files as other programs write them: any channels, data windows, parts.

// A part: channels of these names (sorted), each with one value; the display
// window is 64x64 from (0, 0) on.
typedef struct Foreign
{
    const char* names[6];
    float values[6];
    int x, y, width, height; // data window
    bool half;
    const char* part; // its name; NULL: "one"
} Foreign;

void write_foreign_exr( const char* path, const Foreign* parts, int count );

#endif
