// Guessing what a misspelt word was meant to be, for error lines.
#ifndef REFRAME_BASE_WORDS_H
#define REFRAME_BASE_WORDS_H

// The one of `count` words nearest to `word` if it is near enough to be a
// misspelling, else NULL.
const char* rf_nearest_word( const char* word, const char* const* words, int count );

#endif
