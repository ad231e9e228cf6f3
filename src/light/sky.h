// The environment as a light: its radiance by direction, and directions sampled
// in proportion to that.
#ifndef REFRAME_LIGHT_SKY_H
#define REFRAME_LIGHT_SKY_H

#include "scene/scene.h"

typedef struct RfSky
{
    const RfEnvironment* environment; // NULL: there is none
    float cos_rotation, sin_rotation;
    float mean_luminance;    // over the sphere, W/(m² sr)
    RfVec3 luminance_moment; // mean of luminance times direction over the sphere, W/(m² sr)
    double* row_cosine;      // of a map: height + 1 cosines with +y, of the upper ends of its rows and of the lowest end
    // of a map: cumulative distributions of its rows, and of the pixels of each row
    double* row_cdf;    // height + 1
    float* row_density; // height: the row's probability over the solid angle of one of its pixels
    float* column_cdf;  // height × ( width + 1 )
    // where searches begin: the entries at every 1 / row_parts and 1 / column_parts, powers of two
    int row_parts, column_parts;
    int32_t* row_guide;    // row_parts + 1
    int32_t* column_guide; // height × ( column_parts + 1 )
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

// Radiance from the unit direction wi; maps are interpolated linearly between
// pixel centres. There must be a sky.
RfVec3 rf_sky_radiance( const RfSky* sky, RfVec3 wi );
// An estimate of the luminance of the unoccluded irradiance on a surface with unit
// normal n, W/m²: its first two bands of spherical harmonics (Ramamoorthi,
// Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001),
// but at least a tenth of the mean. There must be a sky.
static inline float rf_sky_irradiance_estimate( const RfSky* sky, RfVec3 n )
{
    float mean = RF_PI * sky->mean_luminance;
    return rf_maxf( mean + 2.0f * RF_PI * rf_dot( sky->luminance_moment, n ), 0.1f * mean );
}

// Density per solid angle of rf_sample_sky at wi: above 0 wherever the radiance is.
float rf_sky_pdf_solid_angle( const RfSky* sky, RfVec3 wi );
// `bits` select the pixel: 32 for its row, 32 for its column. `u`: two uniform
// numbers in [0, 1) for the point within it.
RfSkySample rf_sample_sky( const RfSky* sky, const uint32_t bits[2], const float u[2] );
// The same without the radiance, which is 0: most directions are never asked for it.
RfSkySample rf_sample_sky_direction( const RfSky* sky, const uint32_t bits[2], const float u[2] );

#endif
