// What the memory of a render depends on: memory/memory.h measures and allocates it.
#ifndef REFRAME_RENDER_SIZES_H
#define REFRAME_RENDER_SIZES_H

#include "render/estimator.h"
#include "render/groups.h"

// What the sizes depend on.
typedef struct RfRenderSizes
{
    const RfEstimator* estimator;
    RfEstimatorSizes of_estimator; // for a full group
    int film_count; // of a frame: the estimator's, that of removed light, those of passes (RF_PASS_AOVS), those of light groups
    int pass_films, group_films;
    int width, height;
    int eyes; // of a full group
    int threads;
    int passes;           // of a full group that may be traced at once
    int films;            // frames whose films are held at once
    int buffers;          // finished frames held at once, if there is room
    int ring;             // and the size of the table of them
    unsigned aovs;        // RF_AOV_BIT of the AOVs asked for
    unsigned cryptomatte; // kinds asked for
    bool covering;        // surfaces of pixels are counted, for these or index AOVs
    bool filtered;        // by another than the plain pixel filter
    int film_block;       // passes (RfFilm.block)
    bool stopping;        // by noise, flicker or time
    bool paired;          // by flicker: the films of a group are held at once, and the errors of one more frame
    bool adaptive;        // films may get extra samples
    bool glints;          // likewise for glints
    int materials;        // whose noise is measured for these; 0: all are alike
    int worlds;           // frames whose moving things are held at once (render/worlds.h)
    size_t moving;        // bytes of these: counted, not allocated by memory.h
    RfFrameFiles files;
} RfRenderSizes;

static inline int rf_first_pass_film( const RfRenderSizes* s ) { return s->film_count - s->group_films - s->pass_films; }

// A group of `eye_count` cameras for asking an estimator for its sizes.
RfEstimatorGroup rf_size_group( const RfScene* scene, RfSceneTraits called, const RfEye* eyes, int eye_count,
                                const RfRenderSettings* settings );

// Sizes with the films of `films` frames held at once. The settings must be resolved.
RfRenderSizes rf_render_sizes( const RfScene* scene, const RfEye* eyes, const RfGroupPlan* plan, int films,
                               const RfRenderSettings* settings );

// Batches at once that keep all threads busy.
int rf_batches_wanted( const RfRenderSizes* sizes );

// What is kept at once of batches for frames (RfEstimator.land): of as many batches for each of `films` frames. One thread has no bands
// to share it among.
int rf_landings( const RfRenderSizes* sizes );

// Batches of a pass of a full group.
static inline int rf_batches_of_pass( const RfRenderSizes* sizes ) { return sizes->eyes * sizes->of_estimator.jobs; }

// Kinds of Cryptomatte that are asked for.
int rf_matte_kinds( const RfRenderSizes* sizes );

static inline size_t rf_film_pixels( const RfRenderSizes* sizes ) { return (size_t)sizes->width * (size_t)sizes->height; }

// Entries of RfRenderMemory.noise: one more for the materials that are alike.
static inline size_t rf_material_noises( const RfRenderSizes* sizes )
{
    return sizes->materials > 0 ? (size_t)sizes->materials + 1 : 0;
}

// Bytes that writing a frame takes. They are counted, not allocated here.
size_t rf_writer_bytes( const RfRenderSizes* sizes );

#endif
