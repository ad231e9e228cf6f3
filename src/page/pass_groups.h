// The passes that a file holds beside its picture, by the names of Reframe, Blender or Nuke, in one part or several, and how each is
// shown: the only place that knows how a pass looks, for the report page and for PNG files.
#ifndef REFRAME_PAGE_PASS_GROUPS_H
#define REFRAME_PAGE_PASS_GROUPS_H

#include "image/exr.h"
#include "page/picture.h"

#define RF_PASS_NAME_SIZE 256

typedef struct RfFilePass
{
    char name[RF_PASS_NAME_SIZE];  // Reframe's, such as "depth", "light_key" or "CryptoObject"; else the file's, "DiffDir"
    char layer[RF_PASS_NAME_SIZE]; // its layer or part in the file: "ViewLayer.Depth"; "": it has several
    RfLook look;
    bool is_light;         // scene light, which exposure and view are for
    bool is_group;         // of lights: with all others it adds up to the picture
    const char** channels; // full names in the order of their letters; they point into the header
    int channel_count;
    int all_channels;   // that there are in the file; the look takes channel_count
    unsigned negated;   // bits of the channels with the opposite sign
    RfExrWindow window; // data window of its part
} RfFilePass;

typedef struct RfFilePasses
{
    RfFilePass* passes;
    int count;
    const char** names; // of the channels of all
} RfFilePasses;

// Lists the passes of a file, each once: the AOVs of Reframe in its order, then the others by name. The ranks of a Cryptomatte are one
// pass. The colour itself is none, its alpha is. The header must outlive the list. Fails with RF_ERROR_MEMORY. Free it in any case.
RfResult rf_list_passes( const RfExrHeader* header, RfFilePasses* passes, RfError* error );
void rf_free_passes( RfFilePasses* passes );

// The pass with this name, or whose layer has it in the file, with or without the name of Blender's view layer; NULL: none.
const RfFilePass* rf_find_pass( const RfFilePasses* passes, const char* name );

// "depth, light_key, CryptoObject": their names, truncated with "..." where there is no room.
void rf_name_passes( const RfFilePasses* passes, char* text, size_t size );

// What rf_read_exr_layer calls the layer that a user names for this file: that of the pass with the name, else the name itself. NULL
// (the colour) stays. `text` has RF_PASS_LAYER_SIZE bytes.
#define RF_PASS_LAYER_SIZE ( 3 * RF_PASS_NAME_SIZE )
const char* rf_layer_of_file( const char* path, const char* name, char* text );

// rf_read_exr_picture by the names of passes as well, in the signs of Reframe; the third channel is 0 where a pass has two. The error
// lists the passes of the file.
RfResult rf_read_pass_image( const char* path, const char* name, RfImage* image, RfExrWindow* window, size_t* clipped,
                             RfError* error );

// Reads the channels of passes one behind the other, *stride floats a pixel, in the signs of Reframe: no more than
// RF_EXR_MAX_CHANNELS, with one data window. The caller frees *values.
RfResult rf_read_passes( const char* path, const RfFilePass* passes, int count, RfExrWindow* window, float** values, int* stride,
                         RfError* error );

// The range of a pass for rf_draw_pass, and its picture: light as it is, anything else for the sRGB curve at exposure 0.
RfLookRange rf_pass_range( const RfFilePass* pass, const float* values, size_t stride, size_t pixels );
void rf_draw_pass( const RfFilePass* pass, RfLookRange range, const float* values, size_t stride, size_t pixels, float* rgb );

// Names of a Cryptomatte's ids: a manifest in the header of the file has them (Friedman and Jones, Cryptomatte Specification 1.2.0).

typedef struct RfMatteName
{
    uint32_t id; // the bits of the float that has it
    char* name;
} RfMatteName;

typedef struct RfMatteNames
{
    RfMatteName* names; // by id, ascending
    int count;
} RfMatteNames;

// Reads the names of a pass that is a Cryptomatte; none where the file has no manifest of it. Fails with RF_ERROR_MEMORY and as
// rf_list_exr_strings. Free it in any case.
RfResult rf_read_matte_names( const char* path, const RfFilePass* pass, RfMatteNames* names, RfError* error );
void rf_free_matte_names( RfMatteNames* names );

// The index of an id, or -1.
int rf_find_matte_name( const RfMatteNames* names, uint32_t id );

#endif
