// Which channels of an EXR are its colour.
#ifndef REFRAME_IMAGE_EXR_CHANNELS_H
#define REFRAME_IMAGE_EXR_CHANNELS_H

#include "image/exr_stream.h"

typedef struct RfExrChannels
{
    const char* names[3]; // of red, green and blue, or of Y alone; owned by the context
    int count;            // 3, or 1 for Y
} RfExrChannels;

// R, G, B; else the layer P with P.R, P.G and P.B, where there is but one or but
// one whose name ends with "Combined"; else Y. Else an error names what is there, and
// channels->count is how many layers there are. `remedy` is that of several: RF_REMEDY_LAYER or none.
RfResult rf_find_exr_channels( const RfExrStream* stream, const exr_attr_chlist_t* list, RfRemedy remedy, RfExrChannels* channels,
                               RfError* error );

// The channels that `layer` names in this part: a channel (as grey), the three of a
// layer (P.R, P.G, P.B or P.X, P.Y, P.Z), three channels with commas between them,
// or, where it is the part's name, the part's colour. False where it names none.
bool rf_find_exr_layer( const RfExrPart* part, const char* layer, RfExrChannels* channels );

// Opens the part of a file with the colour, in the first that has any, or with what `layer`
// names (NULL: the colour), and finds its channels. rf_close_exr_part where it succeeded.
RfResult rf_open_exr_layer( RfExrStream* stream, const char* layer, RfExrPart* part, RfExrChannels* channels, RfError* error );

// Writes the names of all channels, with commas between them.
void rf_list_exr_channels( const exr_attr_chlist_t* list, char* text, size_t size );

// Fails, naming it, where a channel of this name is missing or subsampled.
RfResult rf_check_exr_channel( const RfExrStream* stream, const exr_attr_chlist_t* list, const char* name, RfError* error );

#endif
