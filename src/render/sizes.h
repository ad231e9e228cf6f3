// What a render will allocate, by the byte: memory/memory.h allocates the same sums.
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
    int total_every;      // passes of a half of a film before it is emptied; 0: never
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

// Bytes of the films of all frames held at once, with their AOVs.
size_t rf_films_bytes( const RfRenderSizes* sizes );
// Bytes of one finished frame on its way to the caller.
size_t rf_image_bytes( const RfRenderSizes* sizes );
// Bytes of the table of finished frames.
size_t rf_ring_bytes( const RfRenderSizes* sizes );
// Bytes of the workspaces of all threads.
size_t rf_scratch_bytes( const RfRenderSizes* sizes );
// Bytes that writing a frame takes. They are counted, not allocated here.
size_t rf_writer_bytes( const RfRenderSizes* sizes );
// Bytes of so many batches of records.
size_t rf_records_bytes( const RfRenderSizes* sizes, int batches );
// Bytes of everything but the batches, with one finished frame.
size_t rf_fixed_bytes( const RfRenderSizes* sizes );

// Bytes of single arrays, 0 where they are not needed: a half of a film, and its totals in doubles; what is known of the
// frames' noise; the errors of a finished frame; wanted samples and weights of extra samples of an adaptive film; the noise of materials; an
// AOV while it is rendered and when it is finished.
size_t rf_half_bytes( const RfRenderSizes* sizes );
size_t rf_totals_bytes( const RfRenderSizes* sizes );
size_t rf_noise_estimates_bytes( const RfRenderSizes* sizes );
size_t rf_kept_errors_bytes( const RfRenderSizes* sizes );
size_t rf_need_bytes( const RfRenderSizes* sizes );
size_t rf_glints_bytes( const RfRenderSizes* sizes );
size_t rf_extra_bytes( const RfRenderSizes* sizes );
size_t rf_material_noise_bytes( const RfRenderSizes* sizes );
size_t rf_matte_bytes( const RfRenderSizes* sizes, int kind ); // a layer of Cryptomatte
size_t rf_layer_list_bytes( const RfRenderSizes* sizes );
size_t rf_covering_bytes( const RfRenderSizes* sizes ); // surfaces of a film
size_t rf_aov_film_bytes( const RfRenderSizes* sizes, int aov );
size_t rf_aov_image_bytes( const RfRenderSizes* sizes, int aov );

#endif
