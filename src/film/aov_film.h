// The AOVs of a frame while it is rendered: means over the own-frame samples so far,
// and counts of the samples that landed.
#ifndef REFRAME_FILM_AOV_FILM_H
#define REFRAME_FILM_AOV_FILM_H

#include "film/aov.h"
#include "film/film.h"
#include "path/lanes.h"
#include "scene/eye.h"

typedef struct RfAovFilm
{
    // per pixel, NULL where not asked for
    float* mean[RF_AOV_COUNT]; // rf_aov_channels floats; depth: the weight of what is there, too; alpha: two planes, the
                               // weight of the camera rays that missed in each half of the film
    uint32_t* landed;          // RF_AOV_SAMPLES
} RfAovFilm;

// Those that rf_add_to_aovs fills, from first hits.
#define RF_FIRST_HIT_AOV_BIT( constant, name, letters, half, first_hit, what )                                                   \
    ( ( first_hit ) ? RF_AOV_BIT( RF_AOV_##constant ) : 0u ) |
#define RF_FIRST_HIT_AOVS ( RF_AOV_LIST( RF_FIRST_HIT_AOV_BIT ) 0u )

// Floats (or counts) per pixel that an AOV needs while it is rendered.
int rf_aov_film_floats( RfAov aov );

// Sets all sums and counts to 0.
void rf_clear_aov_film( RfAovFilm* film, int width, int height );

// The camera rays of a batch and their hits.
typedef struct RfFirstHits
{
    const RfVertexLanes* hits;
    const RfRayLanes* rays;
    const int32_t* pixel; // of each ray, by slot: y·width + x
} RfFirstHits;

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

// Adds the first hits of a batch, at most one in each pixel. Batches without common pixels
// may be added at the same time.
void rf_add_to_aovs( const RfAovJob* job, RfFirstHits first );

// The image of an AOV: rf_aov_channels floats per pixel. `colour` are the films of the frame, the first its colour,
// which RF_AOV_VARIANCE is taken from.
void rf_finish_aov( const RfAovFilm* film, RfAov aov, const RfFilm* colour, RfFilmCombine combine, float* image );

#endif
