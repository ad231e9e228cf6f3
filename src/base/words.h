// Texts put together, ends of names, and corrections of misspelt words, for messages.
#ifndef REFRAME_BASE_WORDS_H
#define REFRAME_BASE_WORDS_H

#include <stdbool.h>
#include <stddef.h>

// Appends to a text, whose buffer has `size` bytes, what snprintf would write; cut where it is full.
void rf_append( char* text, size_t size, const char* format, ... ) __attribute__( ( format( printf, 3, 4 ) ) );

// Appends words, up to NULL, with `between` between them, and `last` before the last.
void rf_append_words( char* text, size_t size, const char* const* words, const char* between, const char* last );

// True if `text` ends with `end` and is longer.
bool rf_ends_with( const char* text, const char* end );

// True of files with this extension, in any case: ".glb".
bool rf_has_extension( const char* path, const char* extension );

// The one of `count` words nearest to `word` by edit distance, or NULL if none is close enough
// to be a misspelling.
const char* rf_nearest_word( const char* word, const char* const* words, int count );

#endif
