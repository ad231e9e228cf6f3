// Loading of files made by gltf_builder.h, and checks of what comes out, for
// the tests of the glTF reader.
#ifndef REFRAME_TESTS_GLTF_CHECKS_H
#define REFRAME_TESTS_GLTF_CHECKS_H

#include "support/gltf_builder.h"

#include "scene/scene.h"

extern GltfFolder gltf_folder;
extern char gltf_warnings[4096]; // of the last load, a line each

// Group set-up and tear-down: make and remove the folder.
int gltf_enter( void** state );
int gltf_leave( void** state );

// Both fail the test where the file does not load.
RfScene gltf_load( const char* path );
RfScene gltf_load_built( GltfBuilder* b, const char* rest );

// To within 1e-6, relative above 1.
void gltf_assert_near( float got, double want );
void gltf_assert_three( const float* got, double x, double y, double z );
void gltf_assert_rgb( RfVec3 got, double r, double g, double b );

// Position and normal of a corner, counted over all triangles.
void gltf_assert_corner( const RfScene* scene, int corner, double x, double y, double z );
void gltf_assert_normal( const RfScene* scene, int corner, double x, double y, double z );

// That the last load has warned so.
void gltf_assert_warned( const char* text );

#endif
