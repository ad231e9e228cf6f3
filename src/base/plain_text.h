// Text that is safe on a terminal, whatever the names of files and objects hold.
#ifndef REFRAME_BASE_PLAIN_TEXT_H
#define REFRAME_BASE_PLAIN_TEXT_H

#include <stddef.h>

// Bytes of the UTF-8 character that begins here; 0 for a byte that begins none, an overlong one, half of a surrogate pair, and what is
// above U+10FFFF.
size_t rf_utf8_bytes( const char* text );

// Copies `text` with its control characters written as \n, \t or \x1b, so that it stays one line
// and no terminal obeys it: those of ASCII, and U+0080 to U+009F as UTF-8 or as single bytes.
// Truncated to `size` at a whole character or escape. Returns `plain`.
char* rf_plain_text( const char* text, char* plain, size_t size );

#endif
