// EXR files as other programs write them: any channels, data windows, parts.
#ifndef REFRAME_TESTS_FOREIGN_EXR_H
#define REFRAME_TESTS_FOREIGN_EXR_H

#include <stdbool.h>

// A part: channels of these names (sorted), each with one value; the display
// window is 64x64 from (0, 0) on.
typedef struct Foreign
{
    const char* names[6];
    float values[6];
    int x, y, width, height; // data window
    bool half;
    const char* part; // its name; NULL: "one"
} Foreign;

void write_foreign_exr( const char* path, const Foreign* parts, int count );

#endif
