// A self-contained HTML page: a frame of markup, style and script that is compiled
// into the program, blocks of bytes as base64, and the data, JSON. It loads nothing:
// opened from a folder, without a network, it is all there. Written atomically.
#ifndef REFRAME_PAGE_PAGE_H
#define REFRAME_PAGE_PAGE_H

#include "image/atomic_file.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct RfPage
{
    RfAtomicFile file;
    uint64_t bytes; // written so far
} RfPage;

// Begins the page. `path` must outlive it. After success end or discard it.
RfResult rf_open_page( const char* path, const char* title, RfPage* page, RfError* error );

// Adds bytes that the script finds by the id, of letters, digits and '-'.
RfResult rf_add_page_block( RfPage* page, const char* id, const void* bytes, size_t size, RfError* error );

// Ends the page with its data, JSON of any content, and commits the file. On
// failure the page is gone.
RfResult rf_end_page( RfPage* page, const char* json, RfError* error );

void rf_discard_page( RfPage* page );

#endif
