// A map is sampled by its pixels: first a row, then a pixel of the row, then a
// direction inside the pixel, uniformly by solid angle. A pixel's probability is
// proportional to the mean over it of the interpolated luminance (rf_sky_radiance),
// so no direction that emits has density 0.
#include "light/sky.h"

#include "base/fault.h"

#include <stdlib.h>
#include <string.h>

static const float* pixel( const RfEnvironment* e, int x, int y )
{
    x = x < 0 ? x + e->width : ( x >= e->width ? x - e->width : x );
    y = y < 0 ? 0 : ( y >= e->height ? e->height - 1 : y );
    return e->map + 3 * ( (size_t)y * (size_t)e->width + (size_t)x );
}

static double luminance_at( const RfEnvironment* e, int x, int y )
{
    const float* p = pixel( e, x, y );
    return (double)rf_luminance( rf_mul( e->radiance, rf_vec3( p[0], p[1], p[2] ) ) );
}

// Mean over a pixel of the interpolated luminance: weights ⅛ ¾ ⅛ along each axis.
static double mean_luminance( const RfEnvironment* e, int x, int y )
{
    double sum = 0.0, side = RF_FAULT( sky_neighbours ) ? 0.0 : 0.125, middle = 1.0 - 2.0 * side;
    for ( int j = -1; j <= 1; ++j )
    {
        for ( int i = -1; i <= 1; ++i )
            sum += ( i == 0 ? middle : side ) * ( j == 0 ? middle : side ) * luminance_at( e, x + i, y + j );
    }
    return sum;
}

// Solid angle of a pixel of row y, sr.
static double pixel_solid_angle( const RfSky* sky, const RfEnvironment* e, int y )
{
    return ( sky->row_cosine[y] - sky->row_cosine[y + 1] ) * 2.0 * 3.14159265358979324 / e->width;
}

// The cumulative distribution of a row, 0 to 1; returns the power of the row.
static double sum_row( const RfSky* sky, const RfEnvironment* e, int y, float* sum )
{
    double total = 0.0;
    for ( int x = 0; x < e->width; ++x )
        total += mean_luminance( e, x, y );
    double run = 0.0;
    sum[0] = 0.0f;
    for ( int x = 0; x < e->width; ++x )
    {
        run += mean_luminance( e, x, y );
        float cumulative = total > 0.0 ? (float)( run / total ) : (float)( x + 1 ) / (float)e->width;
        sum[x + 1] = cumulative < 1.0f ? cumulative : 1.0f;
    }
    sum[e->width] = 1.0f;
    return total * pixel_solid_angle( sky, e, y );
}

static double sum_rows( const RfEnvironment* e, RfSky* sky )
{
    sky->row_cdf[0] = 0.0;
    for ( int y = 0; y < e->height; ++y )
    {
        float* columns = sky->column_cdf + (size_t)y * ( (size_t)e->width + 1 );
        sky->row_cdf[y + 1] = sky->row_cdf[y] + sum_row( sky, e, y, columns );
    }
    double total = sky->row_cdf[e->height];
    for ( int y = 1; y <= e->height && total > 0.0; ++y )
        sky->row_cdf[y] /= total;
    for ( int y = 0; y < e->height; ++y )
        sky->row_density[y] = (float)( ( sky->row_cdf[y + 1] - sky->row_cdf[y] ) / pixel_solid_angle( sky, e, y ) );
    return total / ( 4.0 * 3.14159265358979324 );
}

// The last entry from `low` on that is not above u, of those that are followed by a larger one; the next is at `high` at most.
static int find_row( const double* sum, int low, int high, double u )
{
    while ( high - low > 1 )
    {
        int middle = ( low + high ) / 2;
        if ( sum[middle] <= u )
            low = middle;
        else
            high = middle;
    }
    return low;
}

static int find_column( const float* sum, int low, int high, double u )
{
    while ( high - low > 1 )
    {
        int middle = ( low + high ) / 2;
        if ( (double)sum[middle] <= u )
            low = middle;
        else
            high = middle;
    }
    return low;
}

// A power of two, so that the parts' borders are exact; some four entries each.
static int parts_of( int count )
{
    int parts = 1;
    while ( parts * 8 <= count )
        parts *= 2;
    return parts;
}

static void note_guides( const RfEnvironment* e, RfSky* sky )
{
    for ( int k = 0; k <= sky->row_parts; ++k )
        sky->row_guide[k] = find_row( sky->row_cdf, 0, e->height, (double)k / sky->row_parts );
    for ( int y = 0; y < e->height; ++y )
    {
        const float* columns = sky->column_cdf + (size_t)y * ( (size_t)e->width + 1 );
        int32_t* guide = sky->column_guide + (size_t)y * ( (size_t)sky->column_parts + 1 );
        for ( int k = 0; k <= sky->column_parts; ++k )
            guide[k] = find_column( columns, 0, e->width, (double)k / sky->column_parts );
    }
}

static RfVec3 direction_of( const RfSky* sky, double u, double cos_up );

// Mean of luminance times direction over the sphere.
static RfVec3 luminance_moment( const RfSky* sky, const RfEnvironment* e )
{
    double sum[3] = { 0 };
    for ( int y = 0; y < e->height; ++y )
    {
        double solid_angle = pixel_solid_angle( sky, e, y ), cos_up = cos( ( y + 0.5 ) / e->height * 3.14159265358979324 );
        for ( int x = 0; x < e->width; ++x )
        {
            RfVec3 d = direction_of( sky, ( x + 0.5 ) / e->width, cos_up );
            double light = luminance_at( e, x, y ) * solid_angle / ( 4.0 * 3.14159265358979324 );
            sum[0] += light * (double)d.x;
            sum[1] += light * (double)d.y;
            sum[2] += light * (double)d.z;
        }
    }
    return rf_vec3( (float)sum[0], (float)sum[1], (float)sum[2] );
}

RfResult rf_make_sky( const RfEnvironment* e, RfSky* sky, RfError* error )
{
    *sky = ( RfSky ){ 0 };
    if ( !( rf_max_component( e->radiance ) > 0.0f ) )
        return RF_OK;
    sky->mean_luminance = rf_luminance( e->radiance );
    sky->cos_rotation = cosf( e->rotation );
    sky->sin_rotation = sinf( e->rotation );
    if ( e->map != NULL )
    {
        sky->row_cosine = malloc( ( (size_t)e->height + 1 ) * sizeof *sky->row_cosine );
        sky->row_cdf = malloc( ( (size_t)e->height + 1 ) * sizeof *sky->row_cdf );
        sky->column_cdf = malloc( (size_t)e->height * ( (size_t)e->width + 1 ) * sizeof *sky->column_cdf );
        sky->row_density = malloc( (size_t)e->height * sizeof *sky->row_density );
        sky->row_parts = parts_of( e->height );
        sky->column_parts = parts_of( e->width );
        sky->row_guide = malloc( ( (size_t)sky->row_parts + 1 ) * sizeof *sky->row_guide );
        sky->column_guide = malloc( (size_t)e->height * ( (size_t)sky->column_parts + 1 ) * sizeof *sky->column_guide );
        if ( sky->row_cosine == NULL || sky->row_cdf == NULL || sky->column_cdf == NULL || sky->row_density == NULL ||
             sky->row_guide == NULL || sky->column_guide == NULL )
        {
            rf_destroy_sky( sky );
            return rf_fail( error, RF_ERROR_MEMORY, "no memory for the distribution of an environment of %d x %d pixels",
                            e->width, e->height );
        }
        for ( int y = 0; y <= e->height; ++y )
            sky->row_cosine[y] = cos( (double)y / e->height * 3.14159265358979324 );
        sky->mean_luminance = (float)sum_rows( e, sky );
        sky->luminance_moment = luminance_moment( sky, e );
        note_guides( e, sky );
    }
    if ( !( sky->mean_luminance > 0.0f ) )
    {
        rf_destroy_sky( sky );
        return RF_OK;
    }
    sky->environment = e;
    return RF_OK;
}

void rf_destroy_sky( RfSky* sky )
{
    free( sky->row_cosine );
    free( sky->row_cdf );
    free( sky->row_density );
    free( sky->column_cdf );
    free( sky->row_guide );
    free( sky->column_guide );
    *sky = ( RfSky ){ 0 };
}

// The position of a direction on the map, in pixels.
typedef struct MapPosition
{
    float x, y;
} MapPosition;

static MapPosition position_of( const RfSky* sky, RfVec3 d )
{
    const RfEnvironment* e = sky->environment;
    float x = d.x * sky->cos_rotation - d.z * sky->sin_rotation; // undoes the rotation
    float z = d.x * sky->sin_rotation + d.z * sky->cos_rotation;
    float u = atan2f( x, -z ) * ( 0.5f * RF_INV_PI ) + 0.5f;
    float v = atan2f( sqrtf( x * x + z * z ), d.y ) * RF_INV_PI; // stays accurate at the poles
    return ( MapPosition ){ u * (float)e->width, v * (float)e->height };
}

static int clamp_index( float value, int count )
{
    int i = (int)value;
    return i < 0 ? 0 : ( i >= count ? count - 1 : i );
}

RfVec3 rf_sky_radiance( const RfSky* sky, RfVec3 wi )
{
    const RfEnvironment* e = sky->environment;
    if ( e->map == NULL )
        return e->radiance;
    MapPosition at = position_of( sky, wi );
    float left = floorf( at.x - 0.5f ), top = floorf( at.y - 0.5f );
    float fx = at.x - 0.5f - left, fy = at.y - 0.5f - top;
    const float* p[4];
    for ( int k = 0; k < 4; ++k )
        p[k] = pixel( e, (int)left + k % 2, (int)top + k / 2 );
    float c[3];
    for ( int i = 0; i < 3; ++i )
    {
        float upper = p[0][i] + fx * ( p[1][i] - p[0][i] ), lower = p[2][i] + fx * ( p[3][i] - p[2][i] );
        c[i] = upper + fy * ( lower - upper );
    }
    return rf_mul( e->radiance, rf_vec3( c[0], c[1], c[2] ) );
}

static float pixel_pdf( const RfSky* sky, int x, int y )
{
    const RfEnvironment* e = sky->environment;
    const float* columns = sky->column_cdf + (size_t)y * ( (size_t)e->width + 1 );
    return sky->row_density[y] * ( columns[x + 1] - columns[x] );
}

float rf_sky_pdf_solid_angle( const RfSky* sky, RfVec3 wi )
{
    const RfEnvironment* e = sky->environment;
    if ( e->map == NULL )
        return 0.25f * RF_INV_PI;
    MapPosition at = position_of( sky, wi );
    return pixel_pdf( sky, clamp_index( at.x, e->width ), clamp_index( at.y, e->height ) );
}

// Unit vector at azimuth 2π (u − ½) from the centre of the map, and the given height.
static RfVec3 direction_of( const RfSky* sky, double u, double cos_up )
{
    double azimuth = 2.0 * 3.14159265358979324 * ( u - 0.5 );
    double across = sqrt( fmax( 1.0 - cos_up * cos_up, 0.0 ) );
    double x = across * sin( azimuth ), z = -across * cos( azimuth );
    double c = (double)sky->cos_rotation, s = (double)sky->sin_rotation;
    return rf_vec3( (float)( x * c + z * s ), (float)cos_up, (float)( z * c - x * s ) );
}

RfSkySample rf_sample_sky_direction( const RfSky* sky, const uint32_t bits[2], const float u[2] )
{
    const RfEnvironment* e = sky->environment;
    RfSkySample sample = { .radiance = rf_vec3( 0, 0, 0 ) };
    if ( e->map == NULL )
    {
        sample.wi = direction_of( sky, (double)u[0], 1.0 - 2.0 * (double)u[1] );
        sample.pdf_solid_angle = 0.25f * RF_INV_PI;
        return sample;
    }
    double of_row = (double)bits[0] * 0x1p-32, of_column = (double)bits[1] * 0x1p-32;
    const int32_t* guide = sky->row_guide + (int)( of_row * sky->row_parts );
    int y = find_row( sky->row_cdf, guide[0], guide[1] + 1, of_row );
    guide = sky->column_guide + (size_t)y * ( (size_t)sky->column_parts + 1 ) + (int)( of_column * sky->column_parts );
    int x = find_column( sky->column_cdf + (size_t)y * ( (size_t)e->width + 1 ), guide[0], guide[1] + 1, of_column );
    double top = sky->row_cosine[y], bottom = sky->row_cosine[y + 1];
    double cos_up = top + ( (double)u[1] + 0x1p-25 ) * ( bottom - top );
    sample.wi = direction_of( sky, ( x + (double)u[0] + 0x1p-25 ) / e->width, cos_up );
    sample.pdf_solid_angle = pixel_pdf( sky, x, y );
    return sample;
}

RfSkySample rf_sample_sky( const RfSky* sky, const uint32_t bits[2], const float u[2] )
{
    RfSkySample sample = rf_sample_sky_direction( sky, bits, u );
    sample.radiance = rf_sky_radiance( sky, sample.wi );
    return sample;
}
