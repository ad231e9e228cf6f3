// Names of settings, as users write them and file headers have them.
#include "output/names.h"

#include "film/pixel_filter.h"

#include <string.h>

const char* const rf_weights_words[] = {
    [RF_WEIGHTS_EXACT] = "exact", [RF_WEIGHTS_EQ15] = "eq15", [RF_WEIGHTS_UNWEIGHTED] = "unweighted", NULL
};
const char* const rf_normalize_words[] = {
    [RF_NORMALIZE_CROSSFIT] = "crossfit", [RF_NORMALIZE_RATIO] = "ratio", [RF_NORMALIZE_NONE] = "none", NULL
};
const char* const rf_light_paths_words[] = {
    [RF_LIGHT_PATHS_AUTO] = "auto",
    [RF_LIGHT_PATHS_ON] = "on",
    [RF_LIGHT_PATHS_OFF] = "off",
    NULL,
};
const char* const rf_kernel_normalization_words[] = {
    [RF_KERNEL_EXACT] = "exact",
    [RF_KERNEL_DISC] = "disc",
    [RF_KERNEL_DENSITY] = "density",
    NULL,
};
const char* const rf_reconstruction_words[] = {
    [RF_RECONSTRUCTION_WEIGHTED] = "weighted",
    [RF_RECONSTRUCTION_L2] = "l2",
    [RF_RECONSTRUCTION_L1] = "l1",
    [RF_RECONSTRUCTION_NONE] = "none",
    NULL,
};
const char* const rf_adaptive_words[] = { [RF_ADAPTIVE_AUTO] = "auto", [RF_ADAPTIVE_ON] = "on", [RF_ADAPTIVE_OFF] = "off", NULL };
const char* const rf_pass_names_words[] = {
    [RF_NAMES_REFRAME] = "reframe", [RF_NAMES_BLENDER] = "blender", [RF_NAMES_NUKE] = "nuke", NULL
};
const char* const rf_parts_words[] = { [RF_PARTS_ONE] = "one", [RF_PARTS_EACH] = "each", NULL };

bool rf_is_other_estimator( const RfEstimator* estimator )
{
    return strcmp( rf_estimator_name( estimator ), rf_estimator_name( rf_default_render_settings().estimator ) ) != 0;
}

const char* rf_weights_name( RfWeights weights ) { return rf_weights_words[weights]; }

const char* rf_normalize_name( RfNormalize normalize ) { return rf_normalize_words[normalize]; }

const char* rf_light_paths_name( RfLightPathsUse use ) { return rf_light_paths_words[use]; }
const char* rf_kernel_normalization_name( RfKernelNormalization normalization )
{
    return rf_kernel_normalization_words[normalization];
}
const char* rf_reconstruction_name( RfReconstruction reconstruction ) { return rf_reconstruction_words[reconstruction]; }

const char* rf_filter_name( RfFilter filter ) { return rf_filter_words[filter]; }

const char* rf_adaptive_name( RfAdaptive adaptive ) { return rf_adaptive_words[adaptive]; }
