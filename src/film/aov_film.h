// The layers of a frame while it is rendered: means over its native samples
// so far, as they come out of the harvest, and counts of what landed.
#ifndef REFRAME_FILM_AOV_FILM_H
#define REFRAME_FILM_AOV_FILM_H

#include "film/film.h"
#include "reuse/harvest.h"
#include "film/aov.h"

typedef struct RfAovFilm
{
    // per pixel, NULL where not asked for
    float* mean[RF_AOV_COUNT]; // rf_aov_channels floats; depth: the weight of what is there, too
    uint32_t* landed;          // RF_AOV_SAMPLES
} RfAovFilm;

// Those that rf_add_to_aovs fills.
#define RF_FIRST_HIT_AOVS                                                                                                        \
    ( RF_AOV_BIT( RF_AOV_ALBEDO ) | RF_AOV_BIT( RF_AOV_NORMAL ) | RF_AOV_BIT( RF_AOV_DEPTH ) | RF_AOV_BIT( RF_AOV_MOTION ) )

// Floats (or counts) per pixel that a layer needs while it is rendered.
int rf_aov_film_floats( RfAov layer );

void rf_clear_aov_film( RfAovFilm* film, int width, int height );

// What a batch adds to: the film of its own frame.
typedef struct RfAovJob
{
    RfAovFilm* film;
    const RfEye* eye;
    const RfEye* previous; // of the path; NULL at its ends
    const RfEye* next;
    float weight;        // of the pass
    float weight_before; // of all passes of the film before it
} RfAovJob;

// Adds the native hits that rf_harvest_batch left in the workspace; every pixel
// of a patch once. Batches of one pass may be added at the same time.
void rf_add_to_aovs( const RfAovJob* job, const RfHarvestScratch* scratch );

// The layer's image: rf_aov_channels floats per pixel. `colour` is the film of
// the frame, which variance is of.
void rf_finish_aov( const RfAovFilm* film, RfAov layer, const RfFilm* colour, RfFilmCombine combine, float* image );

#endif
