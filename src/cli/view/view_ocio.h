// Views of an OpenColorIO configuration, behind functions of C.
#ifndef REFRAME_CLI_VIEW_OCIO_H
#define REFRAME_CLI_VIEW_OCIO_H

#include <stddef.h>

#ifdef __cplusplus
extern "C"
{
#endif

    typedef struct RfOcioView RfOcioView;

    typedef enum RfOcioResult
    {
        RF_OCIO_OK,
        RF_OCIO_NO_VIEW, // the configuration has no view of this name
        RF_OCIO_NO_LOOK, // nor this look
        RF_OCIO_FAILED,  // it cannot be read, or something in it
    } RfOcioResult;

    // Opens a view of the configuration's sRGB display, or of its default one where there is none, by names without case; a look of
    // "": none. "NAME" also finds the look "VIEW - NAME". `message` has OpenColorIO's own words on failure, and the names that
    // there are where one is not found.
    RfOcioResult rf_ocio_open( const char* config, const char* view, const char* look, RfOcioView** out, char* message,
                               size_t size );
    void rf_ocio_close( RfOcioView* view );

    // Applies it to scene-linear colours, in place.
    void rf_ocio_apply( const RfOcioView* view, float* rgb, int count );

#ifdef __cplusplus
}
#endif

#endif
