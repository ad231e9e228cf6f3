// AOVs beside what reframe/aov.h has: their sums while a frame is rendered. They are means over the own-frame samples so far,
// and counts of the samples that landed.
#ifndef REFRAME_FILM_AOV_H
#define REFRAME_FILM_AOV_H

#include "film/film.h"
#include "film/pixel_filter.h"
#include "path/features.h"
#include "reframe/aov.h"
#include "scene/eye.h"
#include "scene/scene.h"

// Are 16 bits enough for it in a file? Those like colour; all others need the range or the precision of 32.
bool rf_aov_is_half( RfAov aov );

// Whether frames are to know where their surfaces are in those before and after them.
static inline bool rf_follows_motion( const RfRenderSettings* settings )
{
    return ( settings->aovs & RF_AOV_BIT( RF_AOV_MOTION ) ) != 0;
}

// Whether camera rays are to be followed to what denoisers want to know.
static inline bool rf_finds_features( const RfRenderSettings* settings ) { return ( settings->aovs & RF_DENOISE_AOVS ) != 0; }

// The labels of RF_PASS_AOVS in a switch.
#define RF_PASS_AOV_CASES                                                                                                        \
    case RF_AOV_EMISSION:                                                                                                        \
    case RF_AOV_DIRECT:                                                                                                          \
    case RF_AOV_INDIRECT:                                                                                                        \
    case RF_AOV_REFLECTION:                                                                                                      \
    case RF_AOV_TRANSMISSION

// Of the films of gradients, what differences lack (src/gradient/gradient.h).
#define RF_UNSHARED_FILM 4

typedef struct RfAovFilm
{
    // per pixel, NULL where not asked for
    float* mean[RF_AOV_COUNT];   // rf_aov_channels floats; depth: the weight of what is there, too; alpha: two planes, the
                                 // weight of the camera rays that missed in each half of the film
    uint32_t* landed;            // RF_AOV_SAMPLES
    const RfPixelFilter* filter; // of the colour, which albedo and normal have, too; NULL: the plain one
} RfAovFilm;

// Those that rf_add_to_aovs fills, from first hits; and among them those that have the pixel filter of the colour.
#define RF_AOV_OF_FILMS 0
#define RF_AOV_OF_HITS 1
#define RF_AOV_OF_FILTERED_HITS 2
#define RF_FIRST_HIT_AOV_BIT( constant, name, letters, half, source, what )                                                      \
    ( RF_AOV_OF_##source != RF_AOV_OF_FILMS ? RF_AOV_BIT( RF_AOV_##constant ) : 0u ) |
#define RF_FILTERED_AOV_BIT( constant, name, letters, half, source, what )                                                       \
    ( RF_AOV_OF_##source == RF_AOV_OF_FILTERED_HITS ? RF_AOV_BIT( RF_AOV_##constant ) : 0u ) |
#define RF_FIRST_HIT_AOVS ( RF_AOV_LIST( RF_FIRST_HIT_AOV_BIT ) 0u )
#define RF_FILTERED_AOVS ( RF_AOV_LIST( RF_FILTERED_AOV_BIT ) 0u )

// Floats (or counts) per pixel that an AOV needs while it is rendered; `filtered`: with another than the plain filter.
int rf_aov_film_floats( RfAov aov, bool filtered );
void rf_clear_aov_film( RfAovFilm* film, int width, int height );

// The camera rays of a batch and their hits.
typedef struct RfFirstHits
{
    const RfVertexLanes* hits;
    const RfRayLanes* rays;
    const RfSurfaceLanes* surfaces; // that the rays hit; NULL unless RF_AOV_MOTION is to follow what moves
    const int32_t* pixel;           // of each ray, by slot: y·width + x; −1: another ray of the pass has the AOVs of its pixel
    const float* place[2];          // in it, to the right and down, 0 to 1; NULL with the plain pixel filter
    const RfFeatures* features;     // NULL unless RF_DENOISE_AOVS are asked for
    const uint16_t* path_rays;      // traced so far beyond the camera ray, by slot; NULL: not counted
} RfFirstHits;

// What a batch adds to: the film of its own frame.
typedef struct RfAovJob
{
    RfAovFilm* film;
    const RfEye* eye;
    const RfEye* others[2];   // of the frames before and after; NULL at the ends of the path
    const RfScene* scene;     // at the frame, where something moves; else NULL
    const RfScene* scenes[2]; // and at the others, where there are eyes
    float weight;             // of the pass
    float weight_before;      // of all passes of the film before it
} RfAovJob;

// Adds the first hits of a batch, at most one in each pixel. Batches without common pixels
// may be added at the same time.
void rf_add_to_aovs( const RfAovJob* job, RfFirstHits first );

// With a filter: adds the samples of the pass that has just been traced, with its weight, to rows [first_row, end_row).
void rf_spread_aovs( const RfAovFilm* film, int width, int height, float weight, int first_row, int end_row );

// The image of an AOV: rf_aov_channels floats per pixel. `colour` are the films of the frame, the first its colour,
// which RF_AOV_VARIANCE is taken from.
void rf_finish_aov( const RfAovFilm* film, RfAov aov, const RfFilm* colour, RfNormalize normalize, float* image );

#endif
