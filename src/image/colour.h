// Linear colour by its primaries and white point. Everything but files is in Rec. 709.
#ifndef REFRAME_IMAGE_COLOUR_H
#define REFRAME_IMAGE_COLOUR_H

#include "reframe/image.h"

// CIE 1931 x, y of red, green, blue and white, as the attribute `chromaticities` of OpenEXR has them.
typedef struct RfChromaticities
{
    float xy[4][2];
} RfChromaticities;

// The words of colour spaces, in the order of RfColourSpace, with NULL at the end; and their chromaticities.
extern const char* const rf_colour_space_words[];
const RfChromaticities* rf_chromaticities_of( RfColourSpace space );

// A change of primaries; the white point is adapted by the Bradford transform.
typedef struct RfColourConversion
{
    bool needed; // else both are the same but for rounding
    float matrix[3][3];
} RfColourConversion;

// False: one of them is no colour space, since the primaries lie on a line or do not enclose the white point.
bool rf_convert_between( const RfChromaticities* from, const RfChromaticities* to, RfColourConversion* conversion );

// What three values are. Variances change as the squares of a colour do whose parts are the deviations: exactly where the noise of
// the three goes together, as that of light does which a path brings; and back to what they were.
typedef enum RfColourKind
{
    RF_COLOUR_NONE, // no colour: kept as it is
    RF_COLOUR_LIGHT,
    RF_COLOUR_VARIANCE,
} RfColourKind;

// Row `to` of a conversion, of the three values at rgb.
float rf_convert_component( const RfColourConversion* conversion, RfColourKind kind, int to, const float rgb[3] );

// Converts `count` triples, `stride` floats apart, in place.
void rf_convert_colours( const RfColourConversion* conversion, RfColourKind kind, float* rgb, size_t count, size_t stride );

// The same of light that a scene is made of: values below 0, of colours beyond the primaries, become 0. Returns their share of the light.
double rf_convert_light( const RfColourConversion* conversion, float* rgb, size_t count, size_t stride );

#endif
