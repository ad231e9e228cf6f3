// How large a group pays: for some half-widths n, what a render of this path
// would hold, trace and gain, by the cost model of Reusing Frames in Camera
// Animation (FR 16; estimators.md section 8):
//
//     gain = reach · (c_e + c_l) / (c_e + c_l + (eyes − 1) c_v)
//
// times what the passes at the ends of a short path and, in the measured one,
// several sweeps leave of it.
// FR has the number of frames for `reach`, as if all saw the same; here it is the
// samples that land in a pixel for each of its own, counted with a few thousand
// hits along the path.
//
// What `--group auto` takes rests on counts alone, with costs of rays that are
// fixed: the same on any run, thread count and choice of frames. Only what is
// told besides, c_e, c_l, c_v and seconds, is measured.
#ifndef REFRAME_PLAN_H
#define REFRAME_PLAN_H

#include "reframe/render.h"

#define RF_PLAN_ROWS 9
#define RF_PLAN_TEXT 512

typedef struct RfPlanRow
{
    int group;       // half-width n, cut to the path
    int eyes;        // in a full group
    int spp;         // as rendered
    RfMemoryFit fit; // `least` alone where it does not fit: then what follows is NaN
    double samples;  // native ones of the frames asked for
    double repeated; // how often each is traced, on the average over the sweeps
    double rays_primary, rays_path, rays_shadow, rays_tile, rays_eye; // expected
    double reach;                                                     // samples that land in a pixel for each of its own
    double gain;                                                      // with fixed costs: what the choice rests on
    double measured_gain; // with those of this scene and machine; NaN until rf_measure_plan
    double seconds;       // of the render, likewise
    const char* excluded; // why auto does not consider it; NULL: it does
    bool chosen;
} RfPlanRow;

typedef struct RfPlan
{
    RfPlanRow rows[RF_PLAN_ROWS];
    int count;                          // fewer where the path ends
    int chosen;                         // index of the row that auto takes
    char why[RF_PLAN_TEXT];             // it takes it
    double hit_share, glossy_share;     // of the camera rays: hits that make records, and those among them that are glossy
    size_t bytes_diffuse, bytes_glossy; // of one record
    double c_e, c_l, c_v; // measured, seconds: a camera ray, the light at its hit, one reuse; NaN until rf_measure_plan
} RfPlan;

static inline bool rf_plan_row_fits( const RfPlanRow* row ) { return row->fit.films > 0; }

// Fills the rows; `settings` as for rf_render, their group is not looked at.
// `frames` are those asked for: bytes, rays and seconds are of these, the choice
// is not. Fails as rf_resolve_settings does, and as rf_fit_memory does for a group of one frame.
RfResult rf_plan_render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                         const RfRenderSettings* settings, RfPlan* plan, RfError* error );

// Measures the costs by about so many seconds of the render's own phases on one
// thread, and fills in what rests on them. Settings as for rf_plan_render.
RfResult rf_measure_plan( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                          double seconds, RfPlan* plan, RfError* error );

// Bytes of a hit record of a diffuse and of a glossy hit.
void rf_record_bytes( const RfScene* scene, const RfRenderSettings* settings, int eyes, size_t* diffuse, size_t* glossy );

#endif
