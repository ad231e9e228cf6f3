// Cryptomatte and index passes of finished frames, from what covers their pixels (film/covering.h).
#ifndef REFRAME_RENDER_SURFACE_LAYERS_H
#define REFRAME_RENDER_SURFACE_LAYERS_H

#include "film/cryptomatte.h"

struct RfRenderer;
struct RfLiveFilm;
struct RfFrameBuffer;

// What surfaces are called, of a whole render; NULL and 0 where it is not asked for. As all names, not of the render's budget.
typedef struct RfSurfaceTables
{
    RfCryptomatteIds ids[RF_CRYPTOMATTE_KINDS];
    float *object_index, *material_index;
} RfSurfaceTables;
RfResult rf_make_surface_tables( const RfScene* scene, const RfRenderSettings* settings, RfSurfaceTables* tables,
                                 RfError* error );
void rf_destroy_surface_tables( RfSurfaceTables* tables );

// Fills the buffer's mattes and lists them as layers of its frame, and its index AOVs.
void rf_finish_surfaces( const struct RfRenderer* renderer, const struct RfLiveFilm* live, struct RfFrameBuffer* buffer );

#endif
