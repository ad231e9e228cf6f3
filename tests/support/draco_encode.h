// Meshes compressed by libdraco, for tests; in builds that have it.
#ifndef REFRAME_TESTS_DRACO_ENCODE_H
#define REFRAME_TESTS_DRACO_ENCODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C"
{
#endif

    // Of all points, packed. Its unique id is its place in the list.
    typedef struct DracoAttribute
    {
        char kind; // 'p'osition, 'n'ormal, 't'exture coordinates, 'c'olour, other: generic
        int type;  // glTF's component type
        int components;
        bool normalized;
        int bits; // of quantisation; 0: none
        const void* values;
    } DracoAttribute;

    typedef struct DracoInput
    {
        uint32_t points, faces;
        const uint32_t* indices;
        int attribute_count;
        DracoAttribute attributes[8];
        bool sequential; // keeps the order of points and faces; else the edgebreaker
        bool cloud;      // points alone
    } DracoInput;

    // Returns the bytes, for the caller to free; NULL if libdraco refuses.
    uint8_t* encode_draco( const DracoInput* input, size_t* size );

#ifdef __cplusplus
}
#endif

#endif
