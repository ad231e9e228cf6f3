#include "film/aov.h"

#include <string.h>

typedef struct Layer
{
    const char* name;
    const char* letters;
} Layer;

static const Layer s_layers[RF_AOV_COUNT] = {
    [RF_AOV_ALBEDO] = { "albedo", "RGB" },  [RF_AOV_NORMAL] = { "normal", "XYZ" },     [RF_AOV_DEPTH] = { "depth", "Z" },
    [RF_AOV_MOTION] = { "motion", "XYZW" }, [RF_AOV_VARIANCE] = { "variance", "RGB" }, [RF_AOV_SAMPLES] = { "samples", "Y" },
};

const char* rf_aov_name( RfAov layer ) { return s_layers[layer].name; }

const char* rf_aov_letters( RfAov layer ) { return s_layers[layer].letters; }

int rf_aov_channels( RfAov layer ) { return (int)strlen( s_layers[layer].letters ); }

bool rf_aov_is_half( RfAov layer ) { return layer == RF_AOV_ALBEDO || layer == RF_AOV_NORMAL; }
