#include "image/film.h"

#include <math.h>
#include <string.h>

void rf_clear_film( RfFilm* film )
{
    for ( int h = 0; h < 2; ++h )
    {
        memset( film->half[h], 0, rf_film_half_bytes( film->width, film->height ) );
        if ( film->total[h] != NULL )
            memset( film->total[h], 0, rf_film_total_bytes( film->width, film->height ) );
        film->passes[h] = 0;
        film->weight[h] = 0.0;
    }
    film->landed = 0;
}

void rf_end_film_pass( RfFilm* film, int half, double weight )
{
    film->passes[half] += 1;
    film->weight[half] += weight;
    if ( film->total[half] == NULL || film->passes[half] % film->total_every != 0 )
        return;
    size_t count = 4 * (size_t)film->width * (size_t)film->height;
    for ( size_t i = 0; i < count; ++i )
        film->total[half][i] += (double)film->half[half][i];
    memset( film->half[half], 0, rf_film_half_bytes( film->width, film->height ) );
}

// Sums of one pixel in the two halves.
typedef struct Pixel
{
    double half[2][4];
    double weight[2];
} Pixel;

static Pixel pixel_of( const RfFilm* film, size_t i )
{
    Pixel p = { .weight = { film->weight[0], film->weight[1] } };
    for ( int h = 0; h < 2; ++h )
    {
        for ( size_t c = 0; c < 4; ++c )
            p.half[h][c] = (double)film->half[h][4 * i + c] + ( film->total[h] != NULL ? film->total[h][4 * i + c] : 0.0 );
    }
    return p;
}

// c_h = A_h / B_h, 0 where nothing landed.
static double quotient( const double* half, int c ) { return half[3] > 0.0 ? half[c] / half[3] : 0.0; }

// (E2) in sums, n the weights of a half's passes: [ A_e + c_o (n_e − B_e) + A_o + c_e (n_o − B_o) ] / (n_e + n_o).
// Where B is exactly n, as without reuse, this is the plain mean, bit for bit.
static double crossfit( const Pixel* p, int c )
{
    double e = p->half[0][c] + quotient( p->half[1], c ) * ( p->weight[0] - p->half[0][3] );
    double o = p->half[1][c] + quotient( p->half[0], c ) * ( p->weight[1] - p->half[1][3] );
    return ( e + o ) / ( p->weight[0] + p->weight[1] );
}

static double combine_channel( const Pixel* p, RfFilmCombine combine, int c )
{
    double a = p->half[0][c] + p->half[1][c], b = p->half[0][3] + p->half[1][3];
    switch ( combine )
    {
        case RF_FILM_CROSSFIT: return crossfit( p, c );
        case RF_FILM_RATIO: return b > 0.0 ? a / b : 0.0;
        case RF_FILM_PLAIN: return a / ( p->weight[0] + p->weight[1] );
    }
    return 0.0;
}

void rf_combine_film( const RfFilm* film, RfFilmCombine combine, float* rgb, float* weight )
{
    size_t count = (size_t)film->width * (size_t)film->height;
    for ( size_t i = 0; i < count; ++i )
    {
        Pixel p = pixel_of( film, i );
        for ( int c = 0; c < 3; ++c )
            rgb[3 * i + (size_t)c] = (float)combine_channel( &p, combine, c );
        if ( weight != NULL )
            weight[i] = (float)( ( p.half[0][3] + p.half[1][3] ) / ( p.weight[0] + p.weight[1] ) );
    }
}

// What a half alone makes of a pixel.
static double half_value( const Pixel* p, RfFilmCombine combine, int h, int c )
{
    const double* own = p->half[h];
    switch ( combine )
    {
        case RF_FILM_CROSSFIT:
            return ( own[c] + quotient( p->half[1 - h], c ) * ( p->weight[h] - own[3] ) ) / p->weight[h];
        case RF_FILM_RATIO: return quotient( own, c );
        case RF_FILM_PLAIN: return own[c] / p->weight[h];
    }
    return 0.0;
}

// With variance v per weight the halves differ by v (1/e + 1/o), the whole has
// v / (e + o): what the square of the difference is multiplied by. 0 where one
// of them is empty.
static double half_share( const RfFilm* film )
{
    double e = film->weight[0], o = film->weight[1];
    return e > 0.0 && o > 0.0 ? e * o / ( ( e + o ) * ( e + o ) ) : 0.0;
}

void rf_estimate_variance( const RfFilm* film, RfFilmCombine combine, float* variance )
{
    size_t count = (size_t)film->width * (size_t)film->height;
    double share = half_share( film );
    for ( size_t i = 0; i < count; ++i )
    {
        Pixel p = pixel_of( film, i );
        for ( int c = 0; c < 3; ++c )
        {
            double d = share > 0.0 ? half_value( &p, combine, 0, c ) - half_value( &p, combine, 1, c ) : 0.0;
            variance[3 * i + (size_t)c] = (float)( share * d * d );
        }
    }
}

double rf_estimate_relmse( const RfFilm* film, RfFilmCombine combine, const float* rgb )
{
    double share = half_share( film );
    if ( share == 0.0 )
        return (double)NAN;
    size_t count = (size_t)film->width * (size_t)film->height;
    double sum = 0.0;
    for ( size_t i = 0; i < count; ++i )
    {
        Pixel p = pixel_of( film, i );
        double error = 0.0, mean = 0.0;
        for ( int c = 0; c < 3; ++c )
        {
            double d = half_value( &p, combine, 0, c ) - half_value( &p, combine, 1, c );
            error += d * d;
            mean += (double)rgb[3 * i + (size_t)c] / 3.0;
        }
        sum += share * error / ( mean * mean + 0.001 );
    }
    return sum / (double)count;
}
