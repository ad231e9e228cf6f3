// Internal to scene/pose.c: the images that textures show at a time.
#ifndef REFRAME_SCENE_POSE_IMAGES_H
#define REFRAME_SCENE_POSE_IMAGES_H

#include "base/layout.h"
#include "scene/scene.h"

// What reading one of them takes meanwhile.
size_t rf_image_scratch( const RfScene* scene );

// Decodes the images of a time for `posed` into the layout; without memory they are only measured. Errors name the file.
RfResult rf_pose_images( const RfScene* scene, double time, RfLayout* layout, RfScene* posed, RfError* error );

// Extends a hash by which images they are.
uint64_t rf_hash_images( const RfScene* scene, double time, uint64_t hash );

#endif
