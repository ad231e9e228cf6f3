// Lights that move or change: which they are, found once, and the lights of a group of frames, by which all of them select with
// the same probabilities (src/reuse/estimators.md, section 18).
#ifndef REFRAME_LIGHT_CHANGING_H
#define REFRAME_LIGHT_CHANGING_H

#include "light/light.h"

// A light that moves or changes.
typedef struct RfChangingLight
{
    uint32_t number;
    int32_t dim; // of a triangle: index into RfChangingLights.dim of its material; −1: that does not dim
    RfVec3 mean; // of a triangle: mean radiance with the emission that its material was loaded with
} RfChangingLight;

// Those of a scene.
typedef struct RfChangingLights
{
    uint32_t still_triangles;          // lights that are triangles and stand still, which have the first numbers
    uint32_t first_moving, end_moving; // triangles among which are all that move and may emit
    uint32_t* of_moving;               // the light of each, or RF_NO_LIGHT
    uint32_t dim_count;
    uint32_t* dim;        // materials that emit and dim
    bool* dim_moves;      // whether some triangle of it moves
    uint32_t* dimmed;     // of those of `light` that are triangles and stand still: by their materials, ascending
    uint32_t* dimmed_end; // of each material, in that
    uint32_t count;
    RfChangingLight* light; // triangles and punctual lights, by their numbers, ascending
    double still_sum;       // of the intensities in the tree of those that do not change
    bool by_tree;           // there are so many lights that trees select them
    RfLightTree none;
} RfChangingLights;

bool rf_lights_change( const RfScene* scene );

// Whether there is a sky, at some time at least.
static inline bool rf_may_have_sky( const RfScene* scene )
{
    return rf_max_component( scene->environment.radiance ) > 0.0f || ( scene->environment.changes && scene->movement != NULL );
}

// The number of triangles that move and may emit.
uint32_t rf_count_moving_emitters( const RfScene* scene );

// The light that a triangle is that moves, or RF_NO_LIGHT.
static inline uint32_t rf_moving_light( const RfLights* lights, uint32_t triangle )
{
    const RfChangingLights* changing = lights->changing;
    if ( changing == NULL || triangle < changing->first_moving || triangle >= changing->end_moving )
        return RF_NO_LIGHT;
    return changing->of_moving[triangle - changing->first_moving];
}

// A frame of a group.
typedef struct RfLitFrame
{
    RfScene* scene;         // as posed. Its materials that dim are set to what paths of the group look up, where they are its own
    const RfVec3* emission; // by rf_note_emission
} RfLitFrame;

// Notes the emission of materials that dim in a scene as it has been posed: lights->changing->dim_count of them.
void rf_note_emission( const RfLights* still, const RfScene* posed, RfVec3* emission );

// The lights of a group of frames.
typedef struct RfGroupLights
{
    RfLights* lights; // of each frame
    // what they share, in the same block of memory but for alias tables and tree
    RfPunctual* punctual;
    RfLight* light;
    RfEnvironment* environment;
    float* power_fraction;
    uint32_t *alias, *alias_threshold;
    uint8_t *part, *material_part;
    RfLightTree tree;
} RfGroupLights;

// `still`: lights of the scene as it was loaded, `loaded`, some of which change; both must outlive the group, as must the posed
// scenes of its `count` frames. Fails with RF_ERROR_MEMORY.
RfResult rf_create_group_lights( const RfLights* still, const RfScene* loaded, int count, const RfLitFrame* frame,
                                 RfGroupLights** out, RfError* error );
// Lights for rf_light_part alone: nothing is placed, and no light can be selected.
RfResult rf_create_group_parts( const RfLights* still, const RfScene* loaded, int count, const RfLitFrame* frame,
                                RfGroupLights** out, RfError* error );
// NULL is allowed.
void rf_destroy_group_lights( RfGroupLights* group );

// Bytes that the lights of a group of so many frames need, and the emission noted for each; 0 where none changes.
size_t rf_group_lights_bytes( const RfScene* scene, int frames );

// Sets the shape of a triangle light, by its corners.
void rf_shape_light( RfVec3 a, RfVec3 b, RfVec3 c, RfLight* light );

// Vose's alias table of `powers`, which sum to `total`. Fails with RF_ERROR_MEMORY.
RfResult rf_build_alias( RfLights* lights, const double* powers, double total, RfError* error );

// The radiance that the tables of a sky are made for.
static inline RfVec3 rf_sky_reference( const RfEnvironment* e )
{
    return rf_max_component( e->radiance ) > 0.0f ? e->radiance : rf_vec3( 1, 1, 1 );
}

#endif
