// What each kind of a light can do. Internal to this folder; the kinds are listed in light/light.h.
#ifndef REFRAME_LIGHT_KINDS_H
#define REFRAME_LIGHT_KINDS_H

#include "light/emission.h"
#include "light/light.h"

typedef struct RfLightModel
{
    // Luminance of the flux over π, W, by which lights are selected where there is no tree; at infinity, the flux through the
    // scene's bounding ball. An estimate will do.
    double ( *selection_power )( const RfLights* lights, uint32_t light );
    // Bounds, cone and intensity for the light tree, in radii of the ball. NULL: it competes with the root of the tree.
    RfTreeLight ( *bound )( const RfLights* lights, uint32_t light );
    // rf_sample_emitter, after range, light and pdf_light have been set.
    bool ( *sample_emitter )( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e );
    // rf_emit_towards, after the direction has been set. NULL: at infinity.
    bool ( *emit )( const RfLights* lights, RfEmission* e );
} RfLightModel;

extern const RfLightModel g_rf_light_models[];

// The bounds of a triangle of this number, wherever it is.
RfTreeLight rf_bound_triangle( const RfLights* lights, const RfLight* light, uint32_t number );

static inline const RfLightModel* rf_light_model( const RfLights* lights, uint32_t light )
{
    return g_rf_light_models + rf_light_kind( lights, light );
}

#endif
