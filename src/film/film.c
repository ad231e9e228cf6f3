// Sums of a frame's two halves, the picture that they make, and its variance. What goes over all pixels goes over the rows in
// parallel, by the threads that OpenMP has for the caller.
#include "film/film.h"

#include "base/fault.h"
#include "film/normalize.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

void rf_clear_film_counts( RfFilm* film )
{
    for ( int h = 0; h < 2; ++h )
    {
        film->passes[h] = 0;
        film->weight[h] = 0.0;
    }
    film->landed = film->extra_samples = 0;
}

void rf_clear_film_pixels( RfFilm* film, size_t first, size_t count )
{
    size_t own = rf_film_sums( film->width, film->height, false ) + 4 * first;
    for ( int h = 0; h < 2; ++h )
    {
        memset( film->half[h] + 4 * first, 0, 4 * count * sizeof( float ) );
        if ( film->split )
            memset( film->half[h] + own, 0, 4 * count * sizeof( float ) );
        if ( film->total[h] != NULL )
            memset( film->total[h] + 4 * first, 0, 4 * count * sizeof( double ) );
        if ( film->total[h] != NULL && film->split )
            memset( film->total[h] + own, 0, 4 * count * sizeof( double ) );
        if ( film->extra[h] != NULL )
            memset( film->extra[h] + first, 0, count * sizeof( float ) );
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

// Moves sums of a half into its totals.
static void empty_sums( RfFilm* film, int half, size_t first, size_t count )
{
    for ( size_t i = first; i < first + count; ++i )
        film->total[half][i] += (double)film->half[half][i];
    memset( film->half[half] + first, 0, count * sizeof( float ) );
}

void rf_end_film_pass( RfFilm* film, int half, double weight )
{
    film->passes[half] += 1;
    film->weight[half] += weight;
    if ( film->total[half] == NULL || film->passes[half] % film->total_every != 0 || RF_FAULT( long_sums ) )
        return;
    size_t of_row = rf_film_sums( film->width, 1, film->split );
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        empty_sums( film, half, (size_t)y * of_row, of_row );
    }
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

void rf_combine_removed( const RfFilm* films, RfNormalize normalize, float* rgb )
{
    rf_combine_part( films, films + 1, normalize, rgb );
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

static double mean_of_halves( const RfFilm* film, int first, int last, size_t i, size_t c )
{
    double sum = 0.0, count = 0.0;
    for ( int h = first; h <= last; ++h )
    {
        const double* total = film->total[h];
        sum += (double)film->half[h][4 * i + c] + ( total != NULL ? total[4 * i + c] : 0.0 );
        count += (double)film->half[h][4 * i + 3] + ( total != NULL ? total[4 * i + 3] : 0.0 );
    }
    return count > 0.0 ? sum / count : 0.0;
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
            for ( size_t c = 0; c < 3; ++c )
                image[3 * i + c] +=
                    (float)( mean_of_halves( film, first, last, i + step, c ) - mean_of_halves( film, first, last, i, c ) );
        }
    }
}
