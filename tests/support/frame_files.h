// Frames of noise and of motion for the tests of flicker.
#ifndef REFRAME_TESTS_FRAME_FILES_H
#define REFRAME_TESTS_FRAME_FILES_H

#include "image/exr.h"
#include "measure/flicker.h"
#include "support/image_support.h"

#include <jansson.h>

enum
{
    WIDTH = 64,
    HEIGHT = 48,
    PIXELS = WIDTH * HEIGHT,
    VALUES = 3 * PIXELS
};

// Black and finite, without layers.
RfFlickerFrame make_frame( int number );

// A layer of so many channels that has the value everywhere; to be given to a frame or freed.
float* make_layer( int channels, float value );

// The same motion everywhere, pixels, +y up.
void set_motion( RfFlickerFrame* frame, float x, float y );

// Independent normal values, mean 0, deviation `scale`.
void fill_noise( RfFlickerFrame* frame, uint32_t seed, float scale );

RfFlickerSums measure( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error );
RfFlickerMetrics measured( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error );

void check_near( double value, double wanted, double tolerance );

// ---- page checks ----

// Frames for the page of `report`, and what it then holds. In the folder of cli_run.

const char* cli_path( const char* name ); // of a file; valid until the next call
void page_make_folder( const char* name );

// A frame of one value, with attributes.
void page_write_frame( const char* name, int width, int height, float value, const RfExrString* strings, int count );
// Frames first to last of one value each: `value`, more by `step` from frame to frame.
void page_write_frames( const char* pattern, int first, int last, float value, float step );

// The data of a page with so many pictures (beside scene values and AOVs), as a browser finds it: up to the next end of a script.
json_t* page_read_data( const char* page, int blocks );
int page_count( const char* text, const char* part );

const json_t* page_sequence( const json_t* data, size_t index );
const json_t* page_item( const json_t* sequence, const char* key, size_t i ); // of a curve
void page_check_item( const json_t* sequence, const char* key, size_t i, double wanted );
// The value of a fact; NULL where the page does not have it.
const char* page_fact( const json_t* sequence, const char* group, const char* label );

#endif
