// The lens and the shutter of a camera, as files have them.
#ifndef REFRAME_SCENE_CAMERA_PATH_OPTICS_H
#define REFRAME_SCENE_CAMERA_PATH_OPTICS_H

#include "reframe/camera.h"

#define RF_DEFAULT_SENSOR 0.024 // height of the film, m: that of 35 mm film

typedef struct RfOptics
{
    double fstop;      // 0: by the radius
    double radius;     // of the lens, m; 0: a pinhole
    double sensor;     // height of the film, m: with the angle of view it gives the focal length that f-numbers divide
    double focus;      // m along the view; 0: none given
    char* focus_node;  // the node that is in focus, owned; NULL: by distance
    int blades;        // 0, or 3 and more
    double rotation;   // of the blades, rad
    double shutter[2]; // when it opens and closes, frames from the frame's own time
} RfOptics;

struct RfField;

// Reads the member "lens" of a camera path or of a glTF node's extras; without it `optics` is a pinhole whose shutter is open for
// no time.
RfResult rf_read_optics( const struct RfField* object, RfOptics* optics );

void rf_destroy_optics( RfOptics* optics );

static inline bool rf_has_shutter( const RfOptics* optics ) { return optics->shutter[1] > optics->shutter[0]; }
static inline bool rf_has_lens( const RfOptics* optics ) { return optics->fstop > 0.0 || optics->radius > 0.0; }

// The radius of the lens for a camera of this angle of view, m. An orthographic camera has no focal length: 1 m, as in Cycles.
double rf_optics_radius( const RfOptics* optics, const RfEye* eye );

#endif
