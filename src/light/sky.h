// The environment as a light: its radiance by direction, and directions sampled
// in proportion to that.
#ifndef REFRAME_LIGHT_SKY_H
#define REFRAME_LIGHT_SKY_H

#include "scene/scene.h"

// Distributions of the cells: for a surface that faces +x, −x, +y, −y, +z or −z, and over the sphere.
enum
{
    RF_SKY_SPHERE = 6,
    RF_SKY_LOBES
};

// A column of the alias table of a cell, and the pixel of the same number.
typedef struct RfSkyPixel
{
    uint16_t threshold, alias; // in units of 2⁻¹⁶: below it the column's pixel is selected, else its alias
    float density;             // of the pixel in the cell: its probability over its solid angle, 1/sr
} RfSkyPixel;

typedef struct RfSkyCell
{
    float flux[RF_SKY_LOBES]; // luminance times cosine times solid angle, W/m²
    uint16_t x, y;            // among the cells
} RfSkyCell;

typedef struct RfSky
{
    const RfEnvironment* environment; // NULL: there is none
    float cos_rotation, sin_rotation;
    float mean_luminance;    // over the sphere, W/(m² sr)
    RfVec3 luminance_moment; // mean of luminance times direction over the sphere, W/(m² sr)
    // of a map, in its own directions, before it is turned:
    double* row_cosine;        // height + 1 cosines with +y: of the upper ends of the rows, and of the lowest end
    int column_bits, row_bits; // a cell has 2^column_bits × 2^row_bits pixels, of which some may lie outside of the map
    int cells_across, cells;   // cells in a row of them, and in all
    RfSkyPixel* pixel;         // cell by cell
    RfSkyCell* cell;
    float total[RF_SKY_LOBES]; // of all cells
    uint32_t* sum;             // of each lobe, cells + 1: the cumulative distribution of the cells, in units of 2⁻³¹
    int guide_bits;
    int32_t* guide; // of each lobe, 2^guide_bits + 1: the cells at every 2^−guide_bits
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
// A direction of the sphere. `bits` select the pixel. `u`: two uniform numbers in [0, 1) for the point within it.
RfSkySample rf_sample_sky( const RfSky* sky, const uint32_t bits[2], const float u[2] );

// Samples that are drawn together.
#define RF_SKY_LANES 128

// Directions to surfaces that are lit from the side of their normal, in proportion to a bound of radiance times cosine, with a
// density above 0 wherever both are.
typedef struct RfSkyLanes
{
    const float* n[3];       // unit
    const uint32_t* bits[2]; // select the pixel
    const float* u[2];       // uniform in [0, 1), for the point within it
    float* wi[3];            // unit
    float* pdf_solid_angle;  // 0: nothing arrives
} RfSkyLanes;

// `count` is at most RF_SKY_LANES.
void rf_sample_sky_directions( const RfSky* sky, int count, const RfSkyLanes* lanes );
float rf_sky_pdf_solid_angle_at( const RfSky* sky, RfVec3 n, RfVec3 wi );

#endif
