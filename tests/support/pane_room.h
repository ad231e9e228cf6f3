// A room with thin panes of all kinds.
#ifndef REFRAME_TESTS_PANE_ROOM_H
#define REFRAME_TESTS_PANE_ROOM_H

#include "support/scene_builder.h"

typedef enum PaneLight
{
    PANES_AND_AREA_LIGHT,
    PANES_AND_LAMP, // a point light
    PANES_AND_SUN,
    PANES_AND_SKY,
    PANES_AND_ALL,
} PaneLight;

// The GGX room of scene_builder.h, lit through a ceiling of clear panes, two in a row. Inside stand coloured
// panes, one with a base, one whose transmission and roughness vary, one with bumps, one that is alpha-blended,
// a ball of thin glass and a blended curtain.
RfScene make_pane_room( PaneLight light );

// A smooth thin wall with this tint over a Lambert base.
RfMaterial make_thin_pane( RfVec3 tint, float base );

// F of a dielectric, by Fresnel's equations.
double fresnel( double cos_theta, double ior );

#endif
