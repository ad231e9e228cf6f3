// Groups that are rendered until a noise, a flicker or a time is reached.
#ifndef REFRAME_RENDER_STOP_UNTIL_H
#define REFRAME_RENDER_STOP_UNTIL_H

#include "render/renderer.h"

// Begins group `number`, or goes on with it; its passes have the numbers and weights of the group that is returned.
RfGroup rf_begin_until( RfRenderer* renderer, int number );

// Whether settings.noise, flicker and time want another pass of the group.
bool rf_is_pass_due( RfRenderer* renderer, int number );

// A pass of so many frames is done.
void rf_note_group_pass( RfRenderer* renderer, int eyes );

// Group `number` is done: its frames are judged, where that is still to be done.
void rf_end_until( RfRenderer* renderer, int number );

#endif
