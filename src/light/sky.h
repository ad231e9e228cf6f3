// The environment as a light: what it sends from each direction, and
// directions drawn in proportion to that.
#ifndef REFRAME_LIGHT_SKY_H
#define REFRAME_LIGHT_SKY_H

#include "scene/scene.h"

typedef struct RfSky
{
    const RfEnvironment* environment; // NULL: there is none
    float cos_rotation, sin_rotation;
    float mean_luminance; // over the sphere, W/(m² sr)
    RfVec3 lean;          // mean of luminance times direction: where most of it comes from
    // of a map: chances of its rows, and of the pixels within each, summed up
    double* row_sum;    // height + 1
    float* row_density; // height: the row's share over the solid angle of one of its pixels
    float* column_sum;  // height × ( width + 1 )
} RfSky;

// A direction towards the sky and what comes from there.
typedef struct RfSkySample
{
    RfVec3 wi;       // unit
    RfVec3 radiance; // W/(m² sr)
    float pdf_solid_angle;
} RfSkySample;

// An environment that is black everywhere is none. Fails with RF_ERROR_MEMORY
// only. The environment must outlive the sky.
RfResult rf_make_sky( const RfEnvironment* environment, RfSky* sky, RfError* error );
void rf_destroy_sky( RfSky* sky );

// Radiance from the unit direction wi; of a map between its pixels' middles,
// linearly. There must be a sky.
RfVec3 rf_sky_radiance( const RfSky* sky, RfVec3 wi );
// About the luminance of the light that falls on a surface with unit normal n,
// were nothing in the way, W/m²: its first two bands (Ramamoorthi, Hanrahan, An
// Efficient Representation for Irradiance Environment Maps, 2001), but at least a
// tenth of the mean. There must be a sky.
static inline float rf_sky_irradiance_estimate( const RfSky* sky, RfVec3 n )
{
    float mean = RF_PI * sky->mean_luminance;
    return rf_maxf( mean + 2.0f * RF_PI * rf_dot( sky->lean, n ), 0.1f * mean );
}

// Density with which rf_sample_sky chooses wi, per solid angle: above 0
// wherever the radiance is.
float rf_sky_pdf_solid_angle( const RfSky* sky, RfVec3 wi );
// `pick`: two times 32 random bits, `place`: two numbers in [0, 1).
RfSkySample rf_sample_sky( const RfSky* sky, const uint32_t pick[2], const float place[2] );

#endif
