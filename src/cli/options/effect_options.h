// --effects and --no-effect, and the options that decide on effects.
#ifndef REFRAME_CLI_OPTIONS_EFFECT_OPTIONS_H
#define REFRAME_CLI_OPTIONS_EFFECT_OPTIONS_H

#include "cli/options/render_options.h"
#include "reframe/effects.h"

// Sets options->left_out from --no-effect. Fails with RF_ERROR_USAGE.
RfResult rf_parse_effect_options( RfRenderOptions* options, RfError* error );

// Leaves out and forces what the options ask for, before the scene has a path, and warns of pictures that are others then.
RfResult rf_take_effect_options( const RfRenderOptions* options, RfScene* scene, RfLog* log, RfError* error );

// The option that decides on an effect, such as "--aov albedo"; NULL where the scene or the camera does.
const char* rf_effect_option( RfEffectId effect );

#endif
