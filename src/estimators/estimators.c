// The estimators there are, and what they use by default.
#include "estimators/estimators.h"

#include "gradient/gradient.h"
#include "reuse/reuse.h"

#include <math.h>
#include <string.h>

#define TABLE( name, what ) &rf_##name##_estimator,
static const RfEstimator* const s_estimators[] = { RF_ESTIMATOR_LIST( TABLE ) };
#undef TABLE

#define WORD( name, what ) #name,
const char* const rf_estimator_words[] = { RF_ESTIMATOR_LIST( WORD ) NULL };
#undef WORD

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

const RfEstimator* rf_estimator_at( int index ) { return index >= 0 && index < ESTIMATOR_COUNT ? s_estimators[index] : NULL; }

const char* rf_estimator_name( const RfEstimator* estimator ) { return estimator->name; }

RfTile rf_default_tile( const RfEstimator* estimator )
{
    return estimator->count_tiles != NULL ? ( RfTile ){ RF_TILE_AUTO, 1, 1 } : estimator->tile;
}

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
        .tile = rf_default_tile( s_estimators[0] ),
        .light_paths = RF_LIGHT_PATHS_OFF,
        .kernel_normalization = RF_KERNEL_EXACT,
        .adaptive = RF_ADAPTIVE_AUTO,
        .weights = RF_WEIGHTS_EXACT,
        .normalize = RF_NORMALIZE_CROSSFIT,
        .filter = rf_default_filter( s_estimators[0] ),
        .max_depth = RF_MAX_DEPTH,
        .light_samples = 1,
        .seed = 1,
    };
}

void rf_use_estimator( RfRenderSettings* settings, const RfEstimator* estimator )
{
    settings->estimator = estimator;
    settings->tile = rf_default_tile( estimator );
    settings->filter = rf_default_filter( estimator );
}

#define MOST_SPP_FOR_NOISE ( 1 << 16 ) // noise that has not come down by then will not

int rf_default_most_spp( double noise, double flicker )
{
    return isgreater( noise, 0.0 ) || isgreater( flicker, 0.0 ) ? MOST_SPP_FOR_NOISE : RF_MAX_SPP;
}
