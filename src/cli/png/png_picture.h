// What `reframe png` shows of a file: its colour, a pass, the light groups mixed anew, or the matte of a name.
#ifndef REFRAME_CLI_PNG_PICTURE_H
#define REFRAME_CLI_PNG_PICTURE_H

#include "cli/view/view.h"
#include "page/picture.h"

typedef enum RfPngKind
{
    RF_PNG_COLOUR,
    RF_PNG_PASS,
    RF_PNG_VALUES, // of a channel, or three, as they are
    RF_PNG_MIX,
    RF_PNG_MATTE,
} RfPngKind;

#define RF_PNG_MOST_FACTORS 32

typedef struct RfPngPicture
{
    const char *layer, *matte, *mix; // options; NULL: not given
    bool data_window;                // all pixels of the file, not its display window alone

    // Found by rf_find_png_picture.
    RfPngKind kind;
    bool takes_view;     // it is light, or values that may be
    bool takes_exposure; // the same, or bright as light is
    RfLookRange range;   // of the pass, over some frames
    char crypto[64];     // the Cryptomatte with the matte, and its id
    uint32_t id;
    char names[RF_PNG_MOST_FACTORS][64]; // of --mix
    float factors[RF_PNG_MOST_FACTORS];
    int factor_count;

    const RfView* view; // NULL: the sRGB curve
    double exposure;    // without a view; a view has its own
} RfPngPicture;

// Finds in the first of `count` files what is shown, and the range of its values in all of them. Fails with RF_ERROR_USAGE for what
// does not go together, with RF_ERROR_FORMAT for what the file does not hold.
RfResult rf_find_png_picture( RfPngPicture* picture, const char* const* paths, int count, RfError* error );

// Writes the picture of a file as PNG.
RfResult rf_write_png_picture( const RfPngPicture* picture, const char* from, const char* to, RfError* error );

#endif
