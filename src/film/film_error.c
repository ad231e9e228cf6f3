// The estimate of a film's relMSE. Its numerator, the squared difference of the halves, is
// unbiased in every pixel, with fireflies and with errors that tiles and groups correlate between
// neighbours. The denominator needs the true value: where noise is heavy, the pixel's own value
// would hide exactly the pixels with the largest errors (estimates of a third of the true error
// were seen). Energy that only one half has is taken for a firefly. The true value is then taken
// as the mean of those neighbours whose common energy is about that of this pixel, which keeps
// to its side of an edge. Where that is less than half of the pixel's value and a neighbour is
// as bright in both halves, it is taken for an edge that few samples hit, and its own value
// is used. A glint in one pixel that one sample in ten hits cannot be told from a firefly.
#include "film/film_pixel.h"

#include <math.h>

#define REACH 3 // the surroundings: 7×7 pixels
#define SIDE ( 2 * REACH + 1 )
#define LIKENESS 0.3 // relative difference of two similar values
#define DARK 0.001   // plus this absolute difference
#define EDGE 2.0     // times its neighbourhood: above that, an edge that few samples hit
#define STRIP 64     // columns processed together
#define COLUMNS ( STRIP + 2 * REACH )

// Columns [first, end) of the film with the rows around the one that is looked
// at, row y in slot y mod SIDE.
typedef struct Strip
{
    const RfFilm* film;
    RfFilmCombine combine;
    const float* rgb;
    int first, end;
    double half[SIDE][2][COLUMNS]; // mean of the channels
    int rows;                      // of them
} Strip;

static size_t index_of( const RfFilm* film, int x, int y ) { return (size_t)y * (size_t)film->width + (size_t)x; }

static void load_row( Strip* s, int y )
{
    for ( int x = s->first; x < s->end; ++x )
    {
        RfFilmPixel p = rf_film_pixel( s->film, index_of( s->film, x, y ) );
        for ( int h = 0; h < 2; ++h )
        {
            double sum = 0.0;
            for ( int c = 0; c < 3; ++c )
                sum += rf_film_half_value( &p, s->combine, h, c );
            s->half[y % SIDE][h][x - s->first] = sum / 3.0;
        }
    }
}

// The rows around y; those above have been loaded.
static void go_to_row( Strip* s, int y )
{
    int height = s->film->height, top = y > REACH ? y - REACH : 0, bottom = y + REACH < height ? y + REACH : height - 1;
    for ( int row = y == 0 ? 0 : y + REACH; row <= bottom; ++row )
        load_row( s, row );
    s->rows = bottom - top + 1;
}

// Common energy of the two halves in pixel x of row y.
static double common_part( const Strip* s, int x, int y )
{
    return fmax( fmin( s->half[y % SIDE][0][x - s->first], s->half[y % SIDE][1][x - s->first] ), 0.0 );
}

static double mean_of_channels( const float* rgb ) { return ( (double)rgb[0] + (double)rgb[1] + (double)rgb[2] ) / 3.0; }

// Mean over the neighbours whose common energy is about that of pixel x in row y.
static double likes( const Strip* s, int x, int y )
{
    int left = x - REACH > s->first ? x - REACH : s->first, right = x + REACH < s->end ? x + REACH : s->end - 1;
    int top = y > REACH ? y - REACH : 0;
    double common = common_part( s, x, y ), sum = 0.0;
    int count = 0;
    for ( int row = top; row < top + s->rows; ++row )
    {
        for ( int i = left; i <= right; ++i )
        {
            double other = common_part( s, i, row );
            bool like = fabs( other - common ) <= LIKENESS * fmax( other, common ) + DARK;
            sum += like ? mean_of_channels( s->rgb + 3 * index_of( s->film, i, row ) ) : 0.0;
            count += like;
        }
    }
    return sum / count;
}

// Largest common energy of pixel x in row y and its direct neighbours.
static double beside( const Strip* s, int x, int y )
{
    int left = x > s->first ? x - 1 : x, right = x + 1 < s->end ? x + 1 : x;
    int top = y > 0 ? y - 1 : y, bottom = y + 1 < s->film->height ? y + 1 : y;
    double most = 0.0;
    for ( int row = top; row <= bottom; ++row )
    {
        for ( int i = left; i <= right; ++i )
            most = fmax( most, common_part( s, i, row ) );
    }
    return most;
}

// Estimate of a pixel's true value for the denominator: at most its own value, at least the
// common energy of the halves.
static double likely_value( const Strip* s, int x, int y )
{
    double own = fabs( mean_of_channels( s->rgb + 3 * index_of( s->film, x, y ) ) ), common = common_part( s, x, y );
    double like = fmin( own, fmax( common, likes( s, x, y ) ) );
    return own > EDGE * like && beside( s, x, y ) >= own ? own : like;
}

static double squared_difference( const Strip* s, int x, int y )
{
    RfFilmPixel p = rf_film_pixel( s->film, index_of( s->film, x, y ) );
    double sum = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        double d = rf_film_half_value( &p, s->combine, 0, c ) - rf_film_half_value( &p, s->combine, 1, c );
        sum += d * d;
    }
    return sum;
}

// Sum over columns [first, end) of the film.
static double strip_sum( const RfFilm* film, RfFilmCombine combine, const float* rgb, int first, int end )
{
    Strip s = {
        .film = film,
        .combine = combine,
        .rgb = rgb,
        .first = first > REACH ? first - REACH : 0,
        .end = end + REACH < film->width ? end + REACH : film->width,
    };
    double sum = 0.0;
    for ( int y = 0; y < film->height; ++y )
    {
        go_to_row( &s, y );
        for ( int x = first; x < end; ++x )
        {
            double value = likely_value( &s, x, y );
            sum += squared_difference( &s, x, y ) / ( value * value + 0.001 );
        }
    }
    return sum;
}

double rf_estimate_relmse( const RfFilm* film, RfFilmCombine combine, const float* rgb )
{
    double share = rf_film_half_share( film );
    if ( share == 0.0 )
        return (double)NAN;
    double sum = 0.0;
    for ( int first = 0; first < film->width; first += STRIP )
        sum += strip_sum( film, combine, rgb, first, first + STRIP < film->width ? first + STRIP : film->width );
    return share * sum / ( (double)film->width * (double)film->height );
}
