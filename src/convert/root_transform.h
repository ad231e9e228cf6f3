// Rotates and scales a whole model; counts its parts.
#ifndef REFRAME_CONVERT_ROOT_TRANSFORM_H
#define REFRAME_CONVERT_ROOT_TRANSFORM_H

#include "convert/model.h"

// Adds a root node above all others that scales by `scale` and, with `z_up`, rotates a
// Z-up model to Y-up. Adds none for the identity. RF_ERROR_MEMORY leaves the model
// unchanged.
RfResult rf_apply_root_transform( RfModel* model, bool z_up, double scale, RfError* error );

// The contents of a model; instances count once.
typedef struct RfModelCounts
{
    unsigned long long triangles;
    int meshes, nodes, materials, images, cameras, lights;
} RfModelCounts;

// Counts the parts of a model.
RfModelCounts rf_count_model( const RfModel* model );

#endif
