// Phase 2, COMPUTE: the hit records that land in a frame, weighted (E1, E3),
// into the halves of its film.
#ifndef REFRAME_REUSE_ACCUMULATE_H
#define REFRAME_REUSE_ACCUMULATE_H

#include "film/film.h"
#include "reuse/records.h"
#include "reframe/render.h"

// Rows [first_row, end_row) of the film of one eye of the window.
typedef struct RfAccumulateJob
{
    int eye;
    int first_row, end_row;
    RfFilm* film;
    int half;
    uint32_t* landed; // samples per pixel of the film, counted up; or NULL
} RfAccumulateJob;

// What all jobs of a chunk share.
typedef struct RfAccumulate
{
    const RfEye* eyes;
    RfBatchShape shape;
    RfWeights weights;
    float weight;              // of the pass in the film
    const RfHitBatch* batches; // in the order in which they add to the film
    int batch_count;
} RfAccumulate;

typedef struct RfAccumulateScratch
{
    RF_ALIGN int32_t pixel[RF_LANES];
    RF_ALIGN float ratio[RF_LANES]; // r_t, 0 where the hit does not land
    RF_ALIGN float wo[3][RF_LANES];
    RF_ALIGN float f[3][RF_LANES];
    RF_ALIGN float sum[3][RF_LANES];
    RF_ALIGN float pdf[RF_LANES];
    RF_ALIGN float mixture[RF_LANES];
} RfAccumulateScratch;

// Adds a chunk to some rows of a film; returns how many samples landed there.
// Jobs on different rows or films may run at the same time. For
// RF_WEIGHTS_EQ15 `landed_eyes` has rf_seen_words per pixel of the film, all
// zero at first, and the chunk must be the whole pass; else NULL.
uint64_t rf_accumulate_rows( const RfAccumulate* compute, RfAccumulateJob job, uint32_t* landed_eyes,
                             RfAccumulateScratch* scratch );

#endif
