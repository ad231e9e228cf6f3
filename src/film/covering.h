// Which surfaces cover each pixel, and by how much, for Cryptomatte and index passes: a small table for each pixel of a frame,
// counted up while it is rendered (src/reuse/estimators.md, section 2).
#ifndef REFRAME_FILM_COVERING_H
#define REFRAME_FILM_COVERING_H

#include "reframe/render_settings.h"
#include "scene/scene.h"

#include <stddef.h>
#include <stdint.h>

// Surfaces that a pixel can have: objects and their materials in pairs, more than a file has ranks for.
#define RF_COVERING_MOST 7

// Weights of the samples of a pixel, by what their camera rays hit first.
typedef struct RfCovering
{
    float nothing;                      // of those that missed
    float lost;                         // of surfaces that found no room
    uint32_t surface[RF_COVERING_MOST]; // numbers by rf_surface_number; 0: free, and so are those after it
    float weight[RF_COVERING_MOST];
} RfCovering;

// What the number of a surface tells apart.
typedef struct RfSurfaceKinds
{
    bool objects, materials;
} RfSurfaceKinds;

// As the settings ask for; neither: no covering is wanted.
RfSurfaceKinds rf_surface_kinds( const RfRenderSettings* settings );
static inline bool rf_wants_covering( const RfRenderSettings* settings )
{
    RfSurfaceKinds kinds = rf_surface_kinds( settings );
    return kinds.objects || kinds.materials;
}

// Fails with RF_ERROR_UNSUPPORTED where there are more pairs of objects and materials than numbers.
RfResult rf_check_surface_numbers( const RfScene* scene, RfSurfaceKinds kinds, RfError* error );

// 1 + object · materials + material, with objects 0 for none and 1 + node, and 0 for what is not told apart. RF_MISS is 0.
uint32_t rf_surface_number( const RfScene* scene, RfSurfaceKinds kinds, uint32_t triangle );

// Adds to a pixel. Where there is no room for another surface, the one of least weight is lost for it if that is less than `weight`,
// else this is: so no surface has more than it should, and only surfaces that cover little have less.
static inline void rf_add_covering( RfCovering* pixel, uint32_t surface, float weight )
{
    int k = 0, least = 0;
    if ( surface == 0 )
    {
        pixel->nothing += weight;
        return;
    }
    for ( ; k < RF_COVERING_MOST && pixel->surface[k] != surface; ++k )
    {
        if ( pixel->surface[k] == 0 )
        {
            pixel->surface[k] = surface;
            break;
        }
        least = pixel->weight[k] < pixel->weight[least] ? k : least;
    }
    if ( k < RF_COVERING_MOST )
    {
        pixel->weight[k] += weight;
        return;
    }
    float lost = pixel->weight[least] < weight ? pixel->weight[least] : weight;
    if ( pixel->weight[least] < weight )
    {
        pixel->surface[least] = surface;
        pixel->weight[least] = weight;
    }
    pixel->lost += lost;
}

// RF_AOV_OBJECT_INDEX and RF_AOV_MATERIAL_INDEX: the index that covers most of each pixel, by the index of each object (from node −1
// on) or material; 0 where nothing does.
void rf_finish_index( const RfCovering* pixels, size_t count, const RfScene* scene, RfAov aov, const float* index_of,
                      float* image );

#endif
