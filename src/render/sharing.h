// How a render shares the light of what changes among the frames of a group (src/reuse/estimators.md, section 18), and how much
// light that is: for people who ask why a picture is noisier than that of a room in which nothing changes.
#ifndef REFRAME_RENDER_SHARING_H
#define REFRAME_RENDER_SHARING_H

#include "reframe/render.h"
#include "scene/changes.h"

typedef enum RfShared
{
    RF_SHARED_AS_IT_IS, // the same in all frames of the group
    RF_SHARED_SCALED,   // kept apart, and scaled to each frame
    RF_SHARED_NOT,      // own-frame: of use for the frame alone that it was traced for
    RF_SHARED_WAYS
} RfShared;

// "shared", "scaled", "own-frame".
const char* rf_shared_name( RfShared shared );

// One of what changes.
typedef struct RfLightSharing
{
    int frames[RF_SHARED_WAYS]; // of RfSharing.frames, by what holds in the group around each. All 0 where it does not shine
    double share;               // of the light of the path's pictures, 0 to 1; NaN: not known
} RfLightSharing;

typedef struct RfSharing
{
    int frames;         // of the path that were looked at
    int group;          // half-width
    RfLightSharing* of; // owned: of what changes, in its order
    // shares of all light: of lights by how they are shared, on surfaces that stand still; and on those that move or change
    double light[RF_SHARED_WAYS], moving;
} RfSharing;

// Looks at a path with small films (rf_sharing_film): pictures of up to 8 moments, one for each light that changes, of about 4 samples.
// `settings` are those of the render, resolved; `changing` is as rf_list_changing has it. Fails as rf_render does.
RfResult rf_find_sharing( const RfTracer* tracer, const RfCameraPath* path, const RfRenderSettings* settings,
                          const RfChanging* changing, int count, RfSharing* sharing, RfError* error );
void rf_destroy_sharing( RfSharing* sharing );

// The size of film that it wants for pictures of this aspect, width over height, with so many lights that change.
void rf_sharing_film( double aspect, int lights, int* width, int* height );

#endif
