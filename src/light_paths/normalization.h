// How connections are divided by the probability of finding them (src/reuse/estimators.md, section 16;
// --kernel-normalization): exact, or biased, for comparison alone.
#ifndef REFRAME_LIGHT_PATHS_NORMALIZATION_H
#define REFRAME_LIGHT_PATHS_NORMALIZATION_H

#include "light_paths/footprints.h"
#include "path/wavefront.h"
#include "reframe/render_settings.h"

typedef struct RfConnectionWork RfConnectionWork;

typedef struct RfNormalization
{
    bool weighted;               // against scattered rays that find the same light: so the share of light paths can be chosen
    bool balls;                  // RfLightPaths.balls
    RfFootprintFound* note_path; // keeps a light path among the RfCandidates if it may be connected
    // Finds the light of all connections of a block. Those that bring none are closed.
    void ( *solve )( RfConnectionWork* work );
    // Finds inverse_probability of connections to VPLs. NULL: there are none of these.
    void ( *divide_vpls )( RfConnectionWork* work );
    float ( *weigh_chance )( const RfConnector* connector, const RfTrail* trail, int length, uint32_t triangle, RfVec3 point );
} RfNormalization;

const RfNormalization* rf_find_normalization( RfKernelNormalization normalization );

#endif
