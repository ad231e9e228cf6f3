// The estimators there are. A further one is a folder and a row here.
#include "gradient/gradient.h"
#include "reuse/reuse.h"

#include <string.h>

// The first is the default.
static const RfEstimator* const s_estimators[] = {
    &rf_reuse_estimator,
    &rf_gradient_estimator,
};

#define ESTIMATOR_COUNT ( (int)( sizeof s_estimators / sizeof s_estimators[0] ) )

const RfEstimator* rf_find_estimator( const char* name )
{
    for ( int i = 0; i < ESTIMATOR_COUNT; ++i )
    {
        if ( strcmp( s_estimators[i]->name, name ) == 0 )
            return s_estimators[i];
    }
    return NULL;
}

const char* rf_estimator_name( const RfEstimator* estimator ) { return estimator->name; }

RfTile rf_default_tile( const RfEstimator* estimator ) { return estimator->tile; }

RfFilter rf_default_filter( const RfEstimator* estimator )
{
    return estimator->filters && !estimator->draws_by_filter ? RF_FILTER_BLACKMAN_HARRIS : RF_FILTER_BOX;
}

RfRenderSettings rf_default_render_settings( void )
{
    return ( RfRenderSettings ){
        .estimator = s_estimators[0],
        .spp = 28,
        .group = RF_GROUP_AUTO,
        .tile = s_estimators[0]->tile,
        .light_paths = RF_LIGHT_PATHS_OFF,
        .kernel_normalization = RF_KERNEL_EXACT,
        .adaptive = RF_ADAPTIVE_AUTO,
        .weights = RF_WEIGHTS_EXACT,
        .normalize = RF_NORMALIZE_CROSSFIT,
        .filter = RF_FILTER_BOX,
        .max_depth = 12,
        .light_samples = 1,
        .seed = 1,
    };
}
