// Suggests corrections of misspelt words, for error messages.
#ifndef REFRAME_BASE_WORDS_H
#define REFRAME_BASE_WORDS_H

// The one of `count` words nearest to `word` by edit distance, or NULL if none is close enough
// to be a misspelling.
const char* rf_nearest_word( const char* word, const char* const* words, int count );

#endif
