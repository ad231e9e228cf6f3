// Pixel filters other than the box of one pixel: how much a sample at a place of the film counts in the
// pixels around it (src/reuse/estimators.md, section 14). The filters are separable, h(x) h(y), and tabulated in steps
// of 1/256 pixel, each with the exact mean of h, so that their integrals are exact, too.
//
// One filter more is a value of RfFilter (reframe/render_settings.h), a row of FILTERS (film/pixel_filter.c) with its integral,
// and its name in scenes/scene.schema.json (a test compares).
#ifndef REFRAME_FILM_PIXEL_FILTER_H
#define REFRAME_FILM_PIXEL_FILTER_H

#include "base/built_in.h"
#include "reframe/render.h"

#include <stdbool.h>

#define RF_FILTER_STEPS 256 // to a pixel
#define RF_FILTER_REACH 4   // pixels to each side of a sample's own that it may count in, at most
#define RF_FILTER_TAPS ( 2 * RF_FILTER_REACH + 1 )

typedef struct RfPixelFilter
{
    int reach;                                              // in whole pixels, to each side of a sample's own
    int taps;                                               // 2 reach + 1
    float rows[RF_FILTER_STEPS * RF_FILTER_TAPS];           // by place in the pixel, `taps` each: h for the pixels around
    float beyond[RF_FILTER_REACH];                          // integral of h beyond pixel d from the filter's own, to one side
    float cumulative[RF_FILTER_STEPS * RF_FILTER_TAPS + 1]; // integral of h over so many steps, from the left end
    double worth; // of a sample drawn by the filter beside one of the plain kind: ∫∫ h² in both directions
} RfPixelFilter;

// The names of filters, as users write them, in the order of RfFilter, with NULL at the end.
extern const char* const rf_filter_words[];

bool rf_is_filter( RfFilter filter );

// Is there a filter? NULL stands for the box of one pixel.
static inline bool rf_has_filter( const RfPixelFilter* filter ) { return rf_calls_for( filter != NULL, RF_EFFECT_PIXEL_FILTER ); }

// Does the filter count each sample in its own pixel only, as a box of one pixel does?
static inline bool rf_is_plain_filter( const RfRenderSettings* settings )
{
    double width = settings->filter_width;
    return settings->filter == RF_FILTER_BOX && ( width == 1.0 || width == 0.0 );
}

// Pixels that a sample counts in.
int rf_filter_pixels( const RfRenderSettings* settings );
void rf_make_pixel_filter( const RfRenderSettings* settings, RfPixelFilter* filter );

// What is left of the integral of h around pixel p within a film of `size` pixels.
static inline float rf_filter_coverage( const RfPixelFilter* filter, int p, int size )
{
    float left = p < filter->reach ? filter->beyond[p] : 0.0f;
    float right = size - 1 - p < filter->reach ? filter->beyond[size - 1 - p] : 0.0f;
    return 1.0f - left - right;
}

// Weights that a sample in pixel q, at `place` 0 to 1 in it, has in pixels q − reach to q + reach; 0 outside the film, and
// at its border scaled so that their integral over the film is 1 in every pixel.
static inline void rf_filter_weights( const RfPixelFilter* filter, int q, float place, int size, float* weights )
{
    int step = (int)( place * RF_FILTER_STEPS );
    const float* row = filter->rows + ( step < RF_FILTER_STEPS ? step : RF_FILTER_STEPS - 1 ) * filter->taps;
    int reach = filter->reach;
    for ( int k = 0; k < filter->taps; ++k )
        weights[k] = row[k];
    if ( q >= 2 * reach && q < size - 2 * reach )
        return;
    for ( int k = 0; k < filter->taps; ++k )
    {
        int p = q + k - reach;
        weights[k] = p >= 0 && p < size ? weights[k] / rf_filter_coverage( filter, p, size ) : 0.0f;
    }
}

// A place drawn from the filter of pixel p, from the pixel's left or upper end on: below 0 and above 1 it lies in another
// pixel, never outside the film. `random` is uniform, 0 to 1.
float rf_draw_filter_place( const RfPixelFilter* filter, int p, int size, float random );

#endif
