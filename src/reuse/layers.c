#include "reuse/layers.h"

#include <string.h>

typedef struct Layer
{
    const char* name;
    const char* letters;
} Layer;

static const Layer s_layers[RF_LAYER_COUNT] = {
    [RF_LAYER_ALBEDO] = { "albedo", "RGB" },     [RF_LAYER_NORMAL] = { "normal", "XYZ" },
    [RF_LAYER_DEPTH] = { "depth", "Z" },         [RF_LAYER_MOTION] = { "motion", "XYZW" },
    [RF_LAYER_VARIANCE] = { "variance", "RGB" }, [RF_LAYER_SAMPLES] = { "samples", "Y" },
};

const char* rf_layer_name( RfLayer layer ) { return s_layers[layer].name; }

const char* rf_layer_letters( RfLayer layer ) { return s_layers[layer].letters; }

int rf_layer_channels( RfLayer layer ) { return (int)strlen( s_layers[layer].letters ); }

bool rf_layer_is_half( RfLayer layer ) { return layer == RF_LAYER_ALBEDO || layer == RF_LAYER_NORMAL; }
