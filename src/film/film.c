// Sums of a frame's two halves, the picture that they make, and its variance. What goes over all pixels goes over the rows in
// parallel, by the threads that OpenMP has for the caller.
#include "film/film.h"

#include "base/fault.h"
#include "math/fastmath.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

static size_t pixels_of( const RfFilm* film ) { return (size_t)film->width * (size_t)film->height; }

// A mean in 64 bits: from the highest on the upper ten of a float behind its sign, the step, and for each channel 18 that count
// steps from −NEGATIVE on. Only gradients have negative means.
#define CODES ( 1 << 18 )
#define NEGATIVE ( 1 << 15 )

static uint64_t pack_mean( const double mean[3] )
{
    double step = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        if ( !isfinite( mean[c] ) )
            return 0;
        step = fmax( step, mean[c] > 0.0 ? mean[c] / ( CODES - 1 - NEGATIVE ) : mean[c] / -NEGATIVE );
    }
    if ( step < (double)FLT_MIN || step > 0.25 * (double)FLT_MAX )
        return 0;
    uint32_t upper = ( (uint32_t)rf_float_bits( (float)step ) >> 21 ) + 1;
    double steps = 1.0 / (double)rf_bits_float( (int32_t)( upper << 21 ) );
    uint64_t packed = (uint64_t)upper << 54;
    for ( int c = 0; c < 3; ++c )
        packed |= (uint64_t)(int64_t)( steps * mean[c] + ( NEGATIVE + 0.5 ) ) << 18 * c;
    return packed;
}

void rf_film_mean( const RfFilm* film, size_t i, double mean[4] )
{
    uint64_t packed = film->mean[i];
    double step = (double)rf_bits_float( (int32_t)( packed >> 54 << 21 ) );
    for ( int c = 0; c < 3; ++c )
        mean[c] = step * ( (int)( packed >> 18 * c & ( CODES - 1 ) ) - NEGATIVE );
    mean[3] = film->mean_b != NULL && i < pixels_of( film ) ? (double)film->mean_b[i] : 1.0;
}

void rf_clear_film_counts( RfFilm* film )
{
    for ( int h = 0; h < 2; ++h )
    {
        film->passes[h] = 0;
        film->weight[h] = film->held[h] = 0.0;
    }
    film->landed = film->extra_samples = 0;
}

void rf_clear_film_pixels( RfFilm* film, size_t first, size_t count )
{
    for ( size_t part = 0; part < ( film->split ? 2 : 1 ); ++part )
    {
        size_t from = part * pixels_of( film ) + first;
        for ( int h = 0; h < 2; ++h )
            memset( film->half[h] + 4 * from, 0, 4 * count * sizeof( float ) );
        if ( film->mean != NULL )
            memset( film->mean + from, 0, count * sizeof *film->mean );
    }
    float* const extra[3] = { film->extra[0], film->extra[1], film->mean_b };
    for ( int k = 0; k < 3; ++k )
    {
        if ( extra[k] != NULL )
            memset( extra[k] + first, 0, count * sizeof( float ) );
    }
}

void rf_clear_film( RfFilm* film )
{
    size_t width = (size_t)film->width;
    rf_clear_film_counts( film );
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        rf_clear_film_pixels( film, (size_t)y * width, width );
    }
}

// Takes the mean so far out of both halves, in place of that before.
static void take_mean_out( RfFilm* film, size_t i )
{
    double sums[2][4], mean[4], weight = film->weight[0] + film->weight[1];
    for ( int h = 0; h < 2; ++h )
        rf_film_sums_at( film, i, h, sums[h] );
    for ( int c = 0; c < 4; ++c )
        mean[c] = ( sums[0][c] + sums[1][c] ) / weight;
    film->mean[i] = pack_mean( mean );
    if ( film->mean_b != NULL && i < pixels_of( film ) )
        film->mean_b[i] = (float)mean[3];
    rf_film_mean( film, i, mean );
    for ( size_t k = 0; k < 8; ++k )
        film->half[k / 4][4 * i + k % 4] = (float)( sums[k / 4][k % 4] - film->weight[k / 4] * mean[k % 4] );
}

void rf_end_film_pass( RfFilm* film, int half, double weight )
{
    film->passes[half] += 1;
    film->weight[half] += weight;
    if ( film->mean == NULL || ( film->passes[0] + film->passes[1] ) % film->block != 0 || RF_FAULT( long_sums ) )
        return;
    size_t of_row = (size_t)film->width * ( film->split ? 2 : 1 );
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        for ( size_t i = (size_t)y * of_row; i < ( (size_t)y + 1 ) * of_row; ++i )
            take_mean_out( film, i );
    }
    for ( int h = 0; h < 2; ++h )
        film->held[h] = film->weight[h];
}

void rf_combine_film( const RfFilm* film, RfNormalize normalize, float* rgb, float* weight )
{
    size_t width = (size_t)film->width;
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        rf_combine_film_pixels( film, normalize, (size_t)y * width, width, rgb, weight );
    }
}

void rf_combine_film_pixels( const RfFilm* film, RfNormalize normalize, size_t first, size_t count, float* rgb, float* weight )
{
    for ( size_t i = first; i < first + count; ++i )
    {
        RfFilmPixel p = rf_film_pixel( film, i );
        for ( int c = 0; c < 3; ++c )
            rgb[3 * i + (size_t)c] = (float)rf_film_value( &p, normalize, c );
        if ( weight != NULL )
            weight[i] = (float)( ( p.half[0][3] + p.half[1][3] ) / ( p.weight[0] + p.weight[1] ) );
    }
}

static RfFilmPixel part_pixel( const RfFilm* film, const RfFilm* part, size_t i )
{
    RfFilmPixel p = rf_film_pixel( film, i ), of_part = rf_film_pixel( part, i );
    for ( int h = 0; h < 2; ++h )
    {
        memcpy( p.half[h], of_part.half[h], 3 * sizeof( double ) );
        memcpy( p.own[h], of_part.own[h], 3 * sizeof( double ) );
    }
    return p;
}

void rf_combine_part( const RfFilm* film, const RfFilm* part, RfNormalize normalize, float* rgb )
{
    size_t width = (size_t)film->width;
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        for ( size_t i = (size_t)y * width; i < ( (size_t)y + 1 ) * width; ++i )
        {
            RfFilmPixel p = part_pixel( film, part, i );
            for ( int c = 0; c < 3; ++c )
                rgb[3 * i + (size_t)c] = (float)rf_film_value( &p, normalize, c );
        }
    }
}

double rf_removed_share( const RfFilm* films, RfNormalize normalize, const float* rgb )
{
    static const double luminance[3] = { 0.2126, 0.7152, 0.0722 };
    double of_part[RF_FILM_PARTS][2] = { { 0.0 } }, removed = 0.0, kept = 0.0;
#pragma omp parallel for schedule( static )
    for ( int part = 0; part < RF_FILM_PARTS; ++part )
    {
        rf_set_float_mode();
        for ( size_t i = rf_film_part( films, part ); i < rf_film_part( films, part + 1 ); ++i )
        {
            RfFilmPixel p = part_pixel( films, films + 1, i );
            for ( int c = 0; c < 3; ++c )
            {
                of_part[part][0] += luminance[c] * rf_film_value( &p, normalize, c );
                of_part[part][1] += luminance[c] * (double)rgb[3 * i + (size_t)c];
            }
        }
    }
    for ( int part = 0; part < RF_FILM_PARTS; ++part )
    {
        removed += of_part[part][0];
        kept += of_part[part][1];
    }
    return removed > 0.0 && removed + kept > 0.0 ? fmin( removed / ( removed + kept ), 1.0 ) : 0.0;
}

void rf_combine_alpha( const RfFilm* film, RfNormalize normalize, const float* sky, float* alpha )
{
    size_t width = (size_t)film->width, count = width * (size_t)film->height;
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        for ( size_t i = (size_t)y * width; i < ( (size_t)y + 1 ) * width; ++i )
        {
            // a colour that is 1 where a ray hits something, and 0 where it does not
            RfFilmPixel p = rf_film_pixel( film, i );
            memset( p.own, 0, sizeof p.own );
            for ( size_t h = 0; h < 2; ++h )
                p.half[h][0] = p.half[h][3] - (double)sky[h * count + i];
            alpha[i] = (float)rf_film_value( &p, normalize, 0 );
        }
    }
}

void rf_estimate_variance( const RfFilm* film, RfNormalize normalize, float* variance )
{
    size_t width = (size_t)film->width;
    double share = rf_film_half_share( film );
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        for ( size_t i = (size_t)y * width; i < ( (size_t)y + 1 ) * width; ++i )
        {
            RfFilmPixel p = rf_film_pixel( film, i );
            for ( int c = 0; c < 3; ++c )
            {
                double d =
                    share > 0.0 ? rf_film_half_value( &p, normalize, 0, c ) - rf_film_half_value( &p, normalize, 1, c ) : 0.0;
                variance[3 * i + (size_t)c] = (float)( share * d * d );
            }
        }
    }
}

void rf_combine_half( const RfFilm* film, RfNormalize normalize, float* half )
{
    size_t width = (size_t)film->width;
    bool alone = rf_film_half_share( film ) == 0.0;
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        for ( size_t i = (size_t)y * width; i < ( (size_t)y + 1 ) * width; ++i )
        {
            RfFilmPixel p = rf_film_pixel( film, i );
            for ( int c = 0; c < 3; ++c )
                half[4 * i + (size_t)c] =
                    (float)( alone ? rf_film_value( &p, normalize, c ) : rf_film_half_value( &p, normalize, 0, c ) );
            half[4 * i + 3] = alone ? 1.0f : (float)( p.weight[0] / ( p.weight[0] + p.weight[1] ) );
        }
    }
}

static void mean_of_halves( const RfFilm* film, int first, int last, size_t i, double mean[3] )
{
    double sum[4] = { 0.0 }, of_half[4];
    for ( int h = first; h <= last; ++h )
    {
        rf_film_sums_at( film, i, h, of_half );
        for ( int c = 0; c < 4; ++c )
            sum[c] += of_half[c];
    }
    for ( int c = 0; c < 3; ++c )
        mean[c] = sum[3] > 0.0 ? sum[c] / sum[3] : 0.0;
}

void rf_add_film_steps( const RfFilm* film, int first, int last, bool down, float* image )
{
    size_t width = (size_t)film->width, step = down ? width : 1;
    int rows = down ? film->height - 1 : film->height;
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < rows; ++y )
    {
        size_t start = (size_t)y * width, end = start + width - ( down ? 0 : 1 );
        rf_set_float_mode();
        for ( size_t i = start; i < end; ++i )
        {
            double here[3], there[3];
            mean_of_halves( film, first, last, i, here );
            mean_of_halves( film, first, last, i + step, there );
            for ( size_t c = 0; c < 3; ++c )
                image[3 * i + c] += (float)( there[c] - here[c] );
        }
    }
}
