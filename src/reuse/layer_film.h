// The layers of a frame while it is rendered: means over its native samples
// so far, as they come out of the harvest, and counts of what landed.
#ifndef REFRAME_REUSE_LAYER_FILM_H
#define REFRAME_REUSE_LAYER_FILM_H

#include "image/film.h"
#include "reuse/harvest.h"
#include "reuse/layers.h"

typedef struct RfLayerFilm
{
    // per pixel, NULL where not asked for
    float* mean[RF_LAYER_COUNT]; // rf_layer_channels floats; depth: the weight of what is there, too
    uint32_t* landed;            // RF_LAYER_SAMPLES
} RfLayerFilm;

// Those that rf_add_to_layers fills.
#define RF_HARVESTED_LAYERS                                                                                                      \
    ( RF_LAYER_BIT( RF_LAYER_ALBEDO ) | RF_LAYER_BIT( RF_LAYER_NORMAL ) | RF_LAYER_BIT( RF_LAYER_DEPTH ) |                       \
      RF_LAYER_BIT( RF_LAYER_MOTION ) )

// Floats (or counts) per pixel that a layer needs while it is rendered.
int rf_layer_film_floats( RfLayer layer );

void rf_clear_layer_film( RfLayerFilm* film, int width, int height );

// What a batch adds to: the film of its own frame.
typedef struct RfLayerJob
{
    RfLayerFilm* film;
    const RfEye* eye;
    const RfEye* previous; // of the path; NULL at its ends
    const RfEye* next;
    float weight;        // of the pass
    float weight_before; // of all passes of the film before it
} RfLayerJob;

// Adds the native hits that rf_harvest_batch left in the workspace; every pixel
// of a patch once. Batches of one pass may be added at the same time.
void rf_add_to_layers( const RfLayerJob* job, const RfHarvestScratch* scratch );

// The layer's image: rf_layer_channels floats per pixel. `colour` is the film of
// the frame, which variance is of.
void rf_finish_layer( const RfLayerFilm* film, RfLayer layer, const RfFilm* colour, RfFilmCombine combine, float* image );

#endif
