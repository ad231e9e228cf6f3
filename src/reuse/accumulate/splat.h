// From hits that are projected and lit to the pixels of films.
#ifndef REFRAME_REUSE_ACCUMULATE_SPLAT_H
#define REFRAME_REUSE_ACCUMULATE_SPLAT_H

#include "reuse/accumulate/hit_light.h"
#include "reuse/reuse_plan.h"

// The films of a job that its batches add to. Only pixels [low, end) belong to it.
typedef struct RfSplatFilm
{
    RfFilmLayers layers;
    RfFilm* film; // NULL where the layers bring it nothing
} RfSplatFilm;

typedef struct RfSplat
{
    int count;
    RfSplatFilm films[RF_FRAME_FILMS_MOST]; // the picture first
    int half;                               // of the films
    bool splits;                            // glints are added to the films' sums of own-frame light, where they have such
    const RfPixelFilter* filter;            // by which samples are spread; NULL: each counts in its own pixel
    int width, height;                      // of the films
    int32_t low, end;
    float weight;         // of the pass in the films
    float* counted;       // like films: whose weights count the samples of the frame itself; NULL: none
    float* sky;           // weight of the camera rays that missed, 1 per pixel; NULL: not asked for
    RfCovering* covering; // of the pixels by surfaces; NULL: not asked for
    uint32_t* landed;     // samples that land in each pixel, counted up; NULL: not asked for
} RfSplat;

#define RF_LANDING_BINS 128

// The hits of a batch that landed in a frame: those of a pixel in their order, and without a pixel filter sorted into bins of
// pixels; with one all in their order, since a hit then counts in pixels of several bins.
typedef struct RfLandedHits
{
    int count;
    bool sorted;
    int32_t low, high;                  // the first and the last pixel of them
    int shift;                          // bin b holds pixels from low + (b << shift) on
    int16_t first[RF_LANDING_BINS + 1]; // hits [first[b], first[b+1]) are in bin b
    int32_t* pixel;
    float* ratio;                      // r_t
    float* offset[2];                  // in the pixel; NULL without a pixel filter
    uint32_t* surface;                 // that the frame sees first on its way to each; NULL unless covering is asked for
    float* value[RF_FRAME_FILMS_MOST]; // by film: 4 each: r g b 1, times r_t
    bool lit[RF_FRAME_FILMS_MOST];     // else the film has none of them
} RfLandedHits;

// An empty landing, for so many films.
RfLandedHits* rf_place_landed_hits( int films, bool filtered, bool covering, RfLayout* layout );

// The hits of a batch at a camera.
typedef struct RfProjectedHits
{
    RF_ALIGN int32_t pixel[RF_LANES];
    RF_ALIGN float ratio[RF_LANES];     // r_t, 0 where the hit does not land
    RF_ALIGN float filter[3][RF_LANES]; // of the way to the camera; only for batches with views
    float* offset[2];                   // place in the pixel; NULL without a pixel filter
} RfProjectedHits;

// Lists the hits of a batch that land in the frame of camera `eye`. Returns them in `order`, RF_LANES, as the landing has them.
void rf_list_landing( const RfHitBatch* batch, int eye, const RfProjectedHits* at, bool sorted, int16_t* order,
                      RfLandedHits* landing );

// Keeps their light in a film.
void rf_keep_light( const RfHitBatch* batch, const RfProjectedHits* at, RfHitLight light, const int16_t* order, int film,
                    RfLandedHits* landing );

// Adds a batch to the pixels of the films, its hits as they landed, and in its `own` frame misses and glints. Returns how many samples
// landed there.
uint64_t rf_splat( const RfSplat* splat, const RfHitBatch* batch, bool own, const RfLandedHits* landing );

#endif
