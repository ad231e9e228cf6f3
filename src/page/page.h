// Writes a self-contained HTML page, atomically: a template of markup, style and script that is compiled into the program, blocks of
// bytes as base64, and JSON data.
#ifndef REFRAME_PAGE_PAGE_H
#define REFRAME_PAGE_PAGE_H

#include "image/atomic_file.h"
#include "reframe/image.h"

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

#endif
