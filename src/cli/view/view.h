// View transforms: how scene-linear light is shown on a display.
#ifndef REFRAME_CLI_VIEW_H
#define REFRAME_CLI_VIEW_H

#include "scene/scene.h"

typedef struct RfView RfView;

// Opens a view. Its source is the OpenColorIO configuration that $OCIO names (empty: none), else that of an installed Blender, where
// the program is built with OpenColorIO and the configuration has that view; else it is one of our own: Standard is the sRGB curve, Filmic and
// AgX are fits of Blender's 3.4 and 4.3 (see view.c). Fails with RF_ERROR_USAGE, with the names that there are, and with
// RF_ERROR_MEMORY. The caller closes the view.
RfResult rf_open_view( const RfViewText* text, RfView** view, RfError* error );
void rf_close_view( RfView* view );

// Replaces `count` colours, scene-linear Rec. 709, by what an sRGB display shows: encoded, 0 to 1. Threads may share a view.
void rf_apply_view( const RfView* view, float* rgb, int count );

// A view as a table for the report page (src/page/assets/10-light.js): the bytes that are shown of RF_VIEW_CUBE_SIZE levels of red, of
// green and of blue, red the innermost. Levels are equally far apart in log2( light + 1/512 ), from −9 to 6.
#define RF_VIEW_CUBE_SIZE 33
#define RF_VIEW_CUBE_BYTES ( 3 * RF_VIEW_CUBE_SIZE * RF_VIEW_CUBE_SIZE * RF_VIEW_CUBE_SIZE )
void rf_fill_view_cube( const RfView* view, unsigned char* bytes );

#endif
