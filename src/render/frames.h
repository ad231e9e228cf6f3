// Frames of a render: their films from the first group that holds them to the last,
// and then to the caller.
#ifndef REFRAME_RENDER_FRAMES_H
#define REFRAME_RENDER_FRAMES_H

#include "render/renderer.h"

// Was this frame of the sweep asked for?
bool rf_is_asked( const RfRenderer* renderer, int frame );

// Was any frame of the group asked for?
bool rf_group_wanted( const RfRenderer* renderer, RfGroup group );

// Clears films for the asked frames that group `number` is the first to hold.
void rf_open_films( RfRenderer* renderer, int number );

// Fills the AOVs of a frame into the buffer, as far as they were asked for: those of this mask, the others of its result are NULL.
void rf_finish_aovs( const RfRenderer* renderer, const RfLiveFilm* live, unsigned aovs, RfFrameBuffer* buffer );

// Samples of a frame per pixel, extra ones too.
double rf_native_spp( const RfRenderer* renderer, const RfFilm* film );

// Hands over the frames whose last group is `number`, in order.
RfResult rf_close_films( RfRenderer* renderer, int number, RfError* error );

#endif
