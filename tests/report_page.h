// Frames for `report`, and the data of the pages that it wrote, in the folder of cli_run.h.
#ifndef REFRAME_TESTS_REPORT_PAGE_H
#define REFRAME_TESTS_REPORT_PAGE_H

#include "image/exr.h"

#include <jansson.h>

// A file's path; holds until the next call.
const char* in_folder( const char* name );

void make_page_folder( const char* name );
void write_constant( const char* name, int width, int height, float value, const RfExrString* strings, int count );

// Frames first to last of one value each: `value`, more by `step` from frame to frame.
void write_sequence( const char* pattern, int first, int last, float value, float step );

int count_of( const char* text, const char* part );

// The data of a page of so many pictures, as a browser finds it: up to the next end of a script.
json_t* read_data( const char* page, int blocks );

const json_t* sequence_of( const json_t* data, size_t index );
const json_t* item( const json_t* sequence, const char* key, size_t i );
void check_item( const json_t* sequence, const char* key, size_t i, double wanted );

// The value of a fact; NULL where the page does not have it.
const char* fact( const json_t* sequence, const char* group, const char* label );

#endif
