// Files read and written by OpenEXR's C++ library, for tests; in builds that have it.
#ifndef REFRAME_TESTS_OPENEXR_FILE_H
#define REFRAME_TESTS_OPENEXR_FILE_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C"
{
#endif

    // Reads a channel of the part that has it, with its data window of that size. False where the library refuses.
    bool read_by_openexr( const char* path, const char* channel, int width, int height, float* values );

    // Writes R, G, B as halves and Z as floats, all of `values`, three floats a pixel; Z is the first.
    bool write_by_openexr( const char* path, int width, int height, const float* values, bool tiled, bool dwab );

#ifdef __cplusplus
}
#endif

#endif
