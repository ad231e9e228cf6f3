// How the commands that show pictures choose a view: by their options, else as the files say.
#ifndef REFRAME_CLI_VIEW_VIEW_OPTIONS_H
#define REFRAME_CLI_VIEW_VIEW_OPTIONS_H

#include "cli/options/options.h"
#include "cli/view/view.h"
#include "reframe/image.h"

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
