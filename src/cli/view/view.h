// View transforms: how scene-linear light is shown on a display.
#ifndef REFRAME_CLI_VIEW_H
#define REFRAME_CLI_VIEW_H

#include "cli/options/options.h"
#include "reframe/image.h"
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

#define RF_EXPOSURE_AUTO 1000

// Values of the options.
typedef struct RfViewOptions
{
    const char *view, *look; // NULL: not given
    double exposure;         // stops, or RF_EXPOSURE_AUTO
    bool exposure_given;
} RfViewOptions;

#define RF_VIEW_OPTIONS( options, group )                                                                                        \
    RF_TEXT_OPTION( "view", &( options ).view, "NAME",                                                                           \
                    "view transform: standard (sRGB), filmic, agx, or one of the configuration in $OCIO",                        \
                    .default_text = "the files', else standard", .heading = group ),                                             \
        RF_TEXT_OPTION( "look", &( options ).look, "NAME", "look of the view, such as \"high contrast\"; none",                  \
                        .default_text = "the files'", .heading = group )

// Opens the view of frames with a header like that of the file `path`, and says which it is. A view that is given drops the files' look.
// Where the files name one that is not here, the sRGB curve takes its place, with a warning; one that is asked for is an error. The
// caller closes the view.
RfResult rf_open_chosen_view( const RfViewOptions* options, const char* path, RfLog* log, RfView** view, RfViewText* chosen,
                              RfError* error );

// The exposure at which the light of some files has a geometric mean of 0.18, middle grey (Reinhard et al. 2002, eq. 1 and 2); black
// pixels do not count. 0 where all is black. Fails as rf_read_exr.
RfResult rf_find_exposure( const char* const* paths, int count, double* stops, RfError* error );

#endif
