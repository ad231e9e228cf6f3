// How large a group pays: for some half-widths n, what a render of this path
// would hold, trace and gain.
//
//     RfShot shot = { tracer, path.eyes, path.count, frames, frame_count };
//     RfPlan plan;
//     if ( rf_plan_render( &shot, &settings, &plan, &error ) == RF_OK )
//         for ( int i = 0; i < plan.count; ++i )
//             printf( "group %d: gain %.1f\n", plan.rows[i].group, plan.rows[i].gain );
//
// The cost model is (16) of Reusing Frames in Camera Animation:
//
//     gain = reach · (c_e + c_l) / (c_e + c_l + (eyes − 1) c_v)
//
// times what the passes at the ends of a short path leave of it. The paper has the number of frames for `reach`, as if all
// saw the same; here it is the samples that land in a pixel for each of its own, counted with
// a few thousand hits along the path.
//
// All of it rests on counts alone, with fixed costs of rays c: what RF_GROUP_AUTO takes is the same for
// any run, thread count and choice of frames.
#ifndef REFRAME_PLAN_H
#define REFRAME_PLAN_H

#include "reframe/error.h"
#include "reframe/render.h"
#include "reframe/scene.h"
#include "reframe/types.h"

RF_API_BEGIN

#define RF_PLAN_ROWS 9
#define RF_PLAN_TEXT 512

typedef struct RfPlanRow
{
    int group;       // half-width n, cut to the path
    RfTile tile;     // that asked for, or with RF_TILE_AUTO the best one for the group
    int eyes;        // in a full group
    int spp;         // as rendered
    RfMemoryFit fit; // `least` alone where it does not fit: then what follows is NaN
    double samples;  // that the frames asked for trace themselves
    double rays_primary, rays_path, rays_shadow, rays_tile, rays_eye; // expected
    double reach;                                                     // samples that land in a pixel for each of its own
    double error;                                                     // relative variance that a sample per pixel leaves
    double reuse;         // cost of a sample in another frame, over that of tracing it, with fixed costs of rays
    double gain;          // over path tracing where the plan chooses the tile, else over groups of one frame
    const char* excluded; // why RF_GROUP_AUTO does not consider it, a string literal; NULL: it does
    bool chosen;
} RfPlanRow;

typedef struct RfPlan
{
    RfPlanRow rows[RF_PLAN_ROWS];
    int count;                          // fewer where the path ends
    int chosen;                         // index of the row that RF_GROUP_AUTO takes
    RfAdaptive adaptive;                // of the chosen row: RF_ADAPTIVE_AUTO is off where its memory would mean several sweeps
    char why[RF_PLAN_TEXT];             // the reason of the choice, in words
    double hit_share, glossy_share;     // of the camera rays: hits that make records, and those among them that are glossy
    size_t bytes_diffuse, bytes_glossy; // of one record
} RfPlan;

// Does the row fit the memory budget at all?
static inline bool rf_plan_row_fits( const RfPlanRow* row ) { return row->fit.films > 0; }

// Fills the rows; `settings` as for rf_render, their group is not looked at. A row is what a render of its
// group is, the chosen one what RF_GROUP_AUTO takes, with plan->adaptive.
// Bytes, rays and seconds are of the frames of the shot, at least one; the choice is not. Fails with
// RF_ERROR_USAGE for values out of range, and as rf_fit_memory does for a group of one frame.
RfResult rf_plan_render( const RfShot* shot, const RfRenderSettings* settings, RfPlan* plan, RfError* error );

// What a render of some frames takes beyond their share of a render of the whole path: the groups that hold frames around them.
typedef struct RfHalo
{
    double share; // of its work, 0 to 1
    int group;    // the smaller one that takes least for these frames and the same error, or that of the settings
    double saved; // of the work, with that group
} RfHalo;

// By the model above, in which samples are tested in the frames asked for alone. Settings as resolved, with a group. Where the
// share is certain to be under `least`, nothing is traced to find it, and no group either. Fails as rf_plan_render.
RfResult rf_plan_halo( const RfShot* shot, const RfRenderSettings* settings, double least, RfHalo* halo, RfError* error );

// Some of the frames asked for, in a row, for a machine of its own.
typedef struct RfPlanRange
{
    int first, end; // of the list of frames: [first, end)
    double work;    // samples that rendering them alone traces, over those of all frames on one machine
} RfPlanRange;

// Cuts the frames of a shot into min( machines, frame_count ) ranges, for which `ranges` has room. Frames of a camera that stands
// still may share one: shot->frames ascend, but may repeat. Of the cameras only their shots are looked at (NULL: there are no
// cuts), the tracer is not.
// None takes more than 1.05 times the least that the longest one can; within that each cut is where the halo, the groups
// that both sides have to render, is least. The pictures do not depend on the cuts. Settings as resolved, with a group.
// Fails with RF_ERROR_USAGE or RF_ERROR_MEMORY.
RfResult rf_plan_ranges( const RfShot* shot, const RfRenderSettings* settings, int machines, RfPlanRange* ranges,
                         int* range_count, RfError* error );

// Bytes of a hit record of a diffuse and of a glossy hit, in groups of `eyes` frames.
void rf_record_bytes( const RfScene* scene, const RfRenderSettings* settings, int eyes, size_t* diffuse, size_t* glossy );

RF_API_END

#endif
