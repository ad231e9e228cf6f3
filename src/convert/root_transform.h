// A model turned and scaled as a whole, and its counts.
#ifndef REFRAME_CONVERT_ROOT_TRANSFORM_H
#define REFRAME_CONVERT_ROOT_TRANSFORM_H

#include "convert/model.h"
#include "reframe/convert.h"

// Puts one more node above all roots: scales by `scale` and, with `z_up`, turns
// a model whose z is up so that its y is. Nothing where there is nothing to do.
// RF_ERROR_MEMORY leaves the model as it was.
RfResult rf_apply_root_transform( RfModel* model, bool z_up, double scale, RfError* error );

// Counts what is in a model.
RfModelCounts rf_count_model( const RfModel* model );

#endif
