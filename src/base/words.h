// Texts put together, ends of names, and corrections of misspelt words, for messages.
#ifndef REFRAME_BASE_WORDS_H
#define REFRAME_BASE_WORDS_H

#include "reframe/error.h"

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

// Words that stand for bits of a set, and how messages name them.
typedef struct RfWordSet
{
    const char *what, *given, *expected; // "unknown <what> 'x', expected <expected>", "<given> x is given twice"
    const char* const* words;
    const unsigned* bits; // of each
    int count;
} RfWordSet;

// "albedo,depth" to the bits of these words; NULL is none. Fails with RF_ERROR_USAGE for a word that is not there (naming the nearest,
// or what is expected), or whose bits come twice.
RfResult rf_parse_words( const RfWordSet* of, const char* text, unsigned* set, RfError* error );

#endif
