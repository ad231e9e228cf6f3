// Writes a self-contained HTML page, atomically: a template of markup, style and script that is compiled into the program, blocks of
// bytes as base64, and JSON data.
#ifndef REFRAME_PAGE_PAGE_H
#define REFRAME_PAGE_PAGE_H

#include "image/atomic_file.h"
#include "reframe/image.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct RfPage
{
    RfAtomicFile file;
    uint64_t bytes;   // written so far
    uint64_t raw;     // of the blocks in them, before base64
    const char* rest; // of the template
    RfResult result;  // of the writes so far
    RfError* error;
} RfPage;

// Begins the page. `path` must outlive it. After success end or discard it.
RfResult rf_open_page( const char* path, const char* title, RfPage* page, RfError* error );

// Adds a block of bytes that the script finds by its id, of letters, digits and '-'.
RfResult rf_add_page_block( RfPage* page, const char* id, const void* bytes, size_t size, RfError* error );

// Ends the page with its JSON data and commits the file. On failure the page is discarded.
RfResult rf_end_page( RfPage* page, const char* json, RfError* error );

void rf_discard_page( RfPage* page );

// Scene values of a frame, for the pixel probe of the page: linear, as half floats.
//
// Layout, little-endian: factor, columns, rows (16 bits each); then columns · rows values of red,
// green and blue as half floats, interleaved, rows from top to bottom. A value is the mean of a box
// of factor × factor pixels, cropped at the right and lower border.

#define RF_VALUES_HEADER_BYTES 6
#define RF_VALUES_MAX_FACTOR 64

// Encodes the image; the caller frees *bytes. Values are clamped to ±65504; NaN and infinity stay.
// `name` begins the message. Fails with RF_ERROR_MEMORY.
RfResult rf_encode_values( const RfImage* image, int factor, const char* name, unsigned char** bytes, size_t* size,
                           RfError* error );

// The bytes that an image takes on the page, as base64.
double rf_values_page_bytes( int width, int height, int factor );

// The smallest factor whose values take no more than `most` bytes of the page; 0: none does.
int rf_values_factor( int width, int height, double most );

#endif
