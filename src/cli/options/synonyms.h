// What other programs call our commands and options.
#ifndef REFRAME_CLI_OPTIONS_SYNONYMS_H
#define REFRAME_CLI_OPTIONS_SYNONYMS_H

// The first of our words for `word` that is among `words`, or NULL.
const char* rf_find_synonym( const char* word, const char* const* words, int count );

#endif
