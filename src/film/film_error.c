// The estimate of a film's relMSE. Its numerator, the squared difference of the halves, is
// unbiased in every pixel, with fireflies and with errors that tiles and groups correlate between
// neighbours. The denominator needs the true value, which a firefly's own value would hide: so it
// is taken from the surroundings, where it must not depend on the pixel's error.
//
// - The mean of the 3×3 pixels without the one in the middle, in the half in which this pixel is darker: a
//   firefly is in the other one, and so are its copies in the pixels of a tile.
// - Where it is noisy it is drawn towards the mean of 5×5 pixels, this towards that of some 24×24, and that
//   towards the picture's, by the ratio of signal to noise (a Wiener filter).
// - The pixel's own value counts by how much more its neighbours differ than their noise explains: all at
//   clean edges, nothing in even areas (Lee, Digital image enhancement and noise filtering by use of local
//   statistics, IEEE PAMI 1980).
// - It is never less than what both halves have: a glint that both have seen is no firefly.
//
// A glint in one pixel that one sample in ten hits cannot be told from a firefly. Where the sum hangs on
// that, in its ten worst pixels, only what it is at least can be reported: those pixels with denominators from
// their own values.
#include "film/film_pixel.h"
#include "film/film_surroundings.h"

#include <math.h>

#define REACH 2 // of the window, pixels to each side
#define NEAR 1  // of the inner one
#define SIDE ( 2 * REACH + 1 )
#define STRIP 64 // columns processed together
#define COLUMNS ( STRIP + 2 * REACH )
// The inverse of the squared relative difference that is expected between a window and what is around it:
// 0.7 and 0.4.
#define WIDE_PRIOR 2.0
#define NEAR_PRIOR 6.0
#define OUTLIER 2.0     // noise counts so many times against what the neighbours differ by
#define WORST 10        // pixels
#define AMBIGUOUS 0.7   // part of the sum that must not hang on what the worst pixels are
#define CORRECTION 1.05 // the shrunk values are too large by some 2 %: in eleven scenes other than those of scripts/check-noise

// What is kept of a pixel.
typedef struct Pixel
{
    double half[2]; // mean of the channels
    double value;   // of the picture, likewise
    double error;   // squared difference of the halves, summed over the channels
} Pixel;

// Columns [first, end) of the film with the rows around the one that is looked
// at, row y in slot y mod SIDE.
typedef struct Strip
{
    const RfFilm* film;
    RfFilmCombine combine;
    const float* rgb;
    int first, end;
    double share; // rf_film_half_share
    Pixel pixels[SIDE][COLUMNS];
} Strip;

// A pixel of the sum, as it is taken and with the denominator from its own value.
typedef struct Term
{
    double likely, least;
} Term;

typedef struct Sum
{
    double likely;
    Term worst[WORST]; // descending
    int count;         // of them
} Sum;

static double mean_of_channels( const float* rgb ) { return ( (double)rgb[0] + (double)rgb[1] + (double)rgb[2] ) / 3.0; }

static Pixel load_pixel( const RfFilm* film, RfFilmCombine combine, const float* rgb, size_t i )
{
    RfFilmPixel p = rf_film_pixel( film, i );
    Pixel pixel = { .value = mean_of_channels( rgb + 3 * i ) };
    for ( int c = 0; c < 3; ++c )
    {
        double a = rf_film_half_value( &p, combine, 0, c ), b = rf_film_half_value( &p, combine, 1, c );
        pixel.half[0] += a / 3.0;
        pixel.half[1] += b / 3.0;
        pixel.error += ( a - b ) * ( a - b );
    }
    return pixel;
}

// The rows around y; those above have been loaded.
static void go_to_row( Strip* s, int y )
{
    int height = s->film->height, bottom = y + REACH < height ? y + REACH : height - 1;
    for ( int row = y == 0 ? 0 : y + REACH; row <= bottom; ++row )
    {
        size_t start = (size_t)row * (size_t)s->film->width;
        for ( int x = s->first; x < s->end; ++x )
            s->pixels[row % SIDE][x - s->first] = load_pixel( s->film, s->combine, s->rgb, start + (size_t)x );
    }
}

// Variance of a pixel's value as its halves have it.
static double own_variance( const Strip* s, const Pixel* p )
{
    double d = p->half[0] - p->half[1];
    return s->share * d * d;
}

// Sums over the window around a pixel, without the pixel.
typedef struct Window
{
    double darker;         // the half in which the pixel is the darker
    double value, squared; // of the picture
    double variance;       // own_variance
    int count;
} Window;

static Window look_around( const Strip* s, int x, int y, int darker, int reach )
{
    int left = x - reach > s->first ? x - reach : s->first, right = x + reach < s->end ? x + reach : s->end - 1;
    int top = y > reach ? y - reach : 0, bottom = y + reach < s->film->height ? y + reach : s->film->height - 1;
    Window w = { 0 };
    for ( int row = top; row <= bottom; ++row )
    {
        for ( int i = left; i <= right; ++i )
        {
            const Pixel* p = &s->pixels[row % SIDE][i - s->first];
            if ( row == y && i == x )
                continue;
            w.darker += p->half[darker];
            w.value += p->value;
            w.squared += p->value * p->value;
            w.variance += own_variance( s, p );
            w.count += 1;
        }
    }
    return w;
}

// The window's mean, drawn towards the mean of a wider area. Noise is at least that of the wider area:
// a window without a firefly does not know that there are some.
static RfAround narrow( const RfSurroundings* around, RfAround wide, const Window* w, double prior )
{
    double variance = fmax( wide.variance, w->variance / w->count );
    double share = rf_signal_share( wide.mean, prior * variance * around->correlation / w->count );
    return ( RfAround ){ .mean = wide.mean + share * ( w->darker / w->count - wide.mean ), .variance = variance };
}

// How far a pixel's own value is to be trusted, 0 to 1: by what its neighbours' differ beyond their noise.
static double own_trust( const Window* near, double own )
{
    double n = near->count, mean = near->value / n, noise = near->variance / n;
    double signal = fmax( near->squared / n - mean * mean - noise, 0.0 );
    return signal > 0.0 ? signal / ( signal + OUTLIER * fmax( noise, own ) ) : 0.0;
}

// Estimate of a pixel's true value.
static double likely_value( const Strip* s, const RfSurroundings* around, const Pixel* p, int x, int y )
{
    int darker = p->half[0] < p->half[1] ? 0 : 1;
    Window wide = look_around( s, x, y, darker, REACH ), near = look_around( s, x, y, darker, NEAR );
    if ( near.count == 0 )
        return p->value;
    RfAround found = narrow( around, rf_look_around( around, x, y, darker, p->half ), &wide, WIDE_PRIOR );
    found = narrow( around, found, &near, NEAR_PRIOR );
    double likely = found.mean + own_trust( &near, own_variance( s, p ) ) * ( p->value - found.mean );
    return fmax( likely, fmax( p->half[darker], 0.0 ) );
}

static void add( Sum* sum, Term term )
{
    sum->likely += term.likely;
    if ( sum->count == WORST && term.likely <= sum->worst[WORST - 1].likely )
        return;
    int i = sum->count < WORST ? sum->count++ : WORST - 1;
    for ( ; i > 0 && sum->worst[i - 1].likely < term.likely; --i )
        sum->worst[i] = sum->worst[i - 1];
    sum->worst[i] = term;
}

// Adds columns [first, end) of the film.
static void add_strip( Sum* sum, const RfSurroundings* around, const RfFilm* film, RfFilmCombine combine, const float* rgb,
                       int first, int end )
{
    Strip s = {
        .film = film,
        .combine = combine,
        .rgb = rgb,
        .first = first > REACH ? first - REACH : 0,
        .end = end + REACH < film->width ? end + REACH : film->width,
        .share = rf_film_half_share( film ),
    };
    for ( int y = 0; y < film->height; ++y )
    {
        go_to_row( &s, y );
        for ( int x = first; x < end; ++x )
        {
            const Pixel* p = &s.pixels[y % SIDE][x - s.first];
            double likely = likely_value( &s, around, p, x, y ), most = fmax( likely, fabs( p->value ) );
            add( sum, ( Term ){ p->error / ( likely * likely + 0.001 ), p->error / ( most * most + 0.001 ) } );
        }
    }
}

static RfRelmse conclude( const Sum* sum, double scale )
{
    Term worst = { 0.0, 0.0 };
    for ( int i = 0; i < sum->count; ++i )
    {
        worst.likely += sum->worst[i].likely;
        worst.least += sum->worst[i].least;
    }
    double least = sum->likely - worst.likely + worst.least;
    return ( RfRelmse ){
        .likely = CORRECTION * scale * sum->likely,
        .least = scale * least,
        .worst_share = sum->likely > 0.0 ? worst.likely / sum->likely : 0.0,
        .is_lower_bound = least < AMBIGUOUS * sum->likely,
    };
}

RfRelmse rf_estimate_relmse( const RfFilm* film, RfFilmCombine combine, const float* rgb )
{
    double share = rf_film_half_share( film );
    if ( share == 0.0 )
        return rf_plain_relmse( (double)NAN );
    RfSurroundings around;
    rf_survey_film( film, combine, &around );
    Sum sum = { 0 };
    for ( int first = 0; first < film->width; first += STRIP )
        add_strip( &sum, &around, film, combine, rgb, first, first + STRIP < film->width ? first + STRIP : film->width );
    return conclude( &sum, share / ( (double)film->width * (double)film->height ) );
}
