#include "film/aov.h"

#include <string.h>

typedef struct AovRow
{
    const char* name;
    const char* letters;
} AovRow;

static const AovRow s_aovs[RF_AOV_COUNT] = {
    [RF_AOV_ALBEDO] = { "albedo", "RGB" },  [RF_AOV_NORMAL] = { "normal", "XYZ" },     [RF_AOV_DEPTH] = { "depth", "Z" },
    [RF_AOV_MOTION] = { "motion", "XYZW" }, [RF_AOV_VARIANCE] = { "variance", "RGB" }, [RF_AOV_SAMPLES] = { "samples", "Y" },
};

const char* rf_aov_name( RfAov aov ) { return s_aovs[aov].name; }

const char* rf_aov_letters( RfAov aov ) { return s_aovs[aov].letters; }

int rf_aov_channels( RfAov aov ) { return (int)strlen( s_aovs[aov].letters ); }

bool rf_aov_is_half( RfAov aov ) { return aov == RF_AOV_ALBEDO || aov == RF_AOV_NORMAL; }
