// Words for settings, as users write them and files have them.
#ifndef REFRAME_OUTPUT_NAMES_H
#define REFRAME_OUTPUT_NAMES_H

#include "reframe/render.h"

// In the order of their enums, with NULL at the end.
extern const char* const rf_weights_words[];
extern const char* const rf_normalize_words[];
extern const char* const rf_light_paths_words[];
extern const char* const rf_kernel_normalization_words[];
extern const char* const rf_reconstruction_words[];
extern const char* const rf_adaptive_words[];
extern const char* const rf_pass_names_words[];
extern const char* const rf_parts_words[];

// Whether users see another estimator than the usual one: that of the biased weights has its name.
bool rf_is_other_estimator( const RfEstimator* estimator );

#endif
