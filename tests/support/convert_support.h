// Files to convert, and scenes loaded from what came out, for the tests of
// `reframe convert`. All names are in the folder of cli_run.h.
#ifndef REFRAME_TESTS_CONVERT_SUPPORT_H
#define REFRAME_TESTS_CONVERT_SUPPORT_H

#include "scene/scene.h"

#include <stdbool.h>

// Set-up and tear-down of a test: a folder of its own.
int convert_enter( void** state );
int convert_leave( void** state );

void convert_write( const char* name, const char* text );

// a.obj with a.mtl and wall.png: 5 triangles of 4 materials, and a line.
void convert_write_obj( void );

// Fails the test where the file does not load.
RfScene convert_load( const char* name );

// To within 1e-5, relative above 1.
bool convert_near( double a, double b );
void convert_assert_point( const float* p, double x, double y, double z );

// That the folder holds what the test wrote, this many files, and no more.
void convert_assert_files( int count );

#endif
