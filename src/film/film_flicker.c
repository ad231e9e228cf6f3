#include "film/film_flicker.h"

#include "film/film_pixel.h"

#include <math.h>

#define WORST 10 // pixels

// Errors of a frame, from a film or kept.
typedef struct Errors
{
    const RfFilm* film; // NULL: kept
    const float* kept;
    RfFilmCombine combine;
} Errors;

typedef struct Sums
{
    double before, now, product;
    double worst[WORST]; // squared changes of pixels, descending
} Sums;

// √(e o) / (e + o) times the difference of the halves: with variance v per weight it has the variance v / (e + o) of the
// whole. Extra samples make the weights those of the pixel.
static void error_of_pixel( const RfFilm* film, RfFilmCombine combine, size_t i, double error[3] )
{
    RfFilmPixel p = rf_film_pixel( film, i );
    double e = p.weight[0], o = p.weight[1], scale = sqrt( e * o ) / ( e + o );
    for ( int c = 0; c < 3; ++c )
        error[c] = scale * ( rf_film_half_value( &p, combine, 0, c ) - rf_film_half_value( &p, combine, 1, c ) );
}

static void load_pixel( const Errors* errors, size_t i, double error[3] )
{
    if ( errors->film != NULL )
        error_of_pixel( errors->film, errors->combine, i, error );
    else
        for ( size_t c = 0; c < 3; ++c )
            error[c] = (double)errors->kept[3 * i + c];
}

static void keep_worst( double worst[WORST], double value )
{
    for ( int k = 0; k < WORST && value > 0.0; ++k )
    {
        if ( value <= worst[k] )
            continue;
        double next = worst[k];
        worst[k] = value;
        value = next;
    }
}

static void add_pixel( Sums* sums, const double before[3], const double now[3] )
{
    double change = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        sums->before += before[c] * before[c];
        sums->now += now[c] * now[c];
        sums->product += before[c] * now[c];
        change += ( now[c] - before[c] ) * ( now[c] - before[c] );
    }
    keep_worst( sums->worst, change );
}

static size_t pixels_of( const RfFilm* film ) { return (size_t)film->width * (size_t)film->height; }

static RfFlicker flicker_of( const Errors* before, const Errors* now )
{
    Sums sums = { 0 };
    size_t pixels = pixels_of( now->film );
    for ( size_t i = 0; i < pixels; ++i )
    {
        double a[3], b[3];
        load_pixel( before, i, a );
        load_pixel( now, i, b );
        add_pixel( &sums, a, b );
    }
    double change = sums.before + sums.now - 2.0 * sums.product, worst = 0.0, scale = 1.0 / ( 3.0 * (double)pixels );
    for ( int k = 0; k < WORST; ++k )
        worst += sums.worst[k];
    return ( RfFlicker ){ .before = scale * sums.before,
                          .now = scale * sums.now,
                          .product = scale * sums.product,
                          .worst_share = change > 0.0 ? fmin( worst / change, 1.0 ) : 0.0 };
}

static bool has_halves( const RfFilm* film ) { return rf_film_half_share( film ) > 0.0; }

static RfFlicker unknown( void )
{
    return ( RfFlicker ){ .before = (double)NAN, .now = (double)NAN, .product = (double)NAN, .worst_share = (double)NAN };
}

RfFlicker rf_flicker_of_films( const RfFilm* before, const RfFilm* now, RfFilmCombine combine )
{
    if ( !has_halves( before ) || !has_halves( now ) )
        return unknown();
    return flicker_of( &( Errors ){ .film = before, .combine = combine }, &( Errors ){ .film = now, .combine = combine } );
}

RfFlicker rf_flicker_since( const float* before, const RfFilm* now, RfFilmCombine combine )
{
    if ( !has_halves( now ) )
        return unknown();
    return flicker_of( &( Errors ){ .kept = before }, &( Errors ){ .film = now, .combine = combine } );
}

double rf_film_mean_square( const RfFilm* film, RfFilmCombine combine )
{
    size_t pixels = pixels_of( film );
    double sum = 0.0;
    for ( size_t i = 0; i < pixels && has_halves( film ); ++i )
    {
        double error[3];
        error_of_pixel( film, combine, i, error );
        sum += error[0] * error[0] + error[1] * error[1] + error[2] * error[2];
    }
    return has_halves( film ) ? sum / ( 3.0 * (double)pixels ) : (double)NAN;
}

void rf_keep_film_error( const RfFilm* film, RfFilmCombine combine, float* error )
{
    size_t pixels = pixels_of( film );
    for ( size_t i = 0; i < pixels; ++i )
    {
        double e[3] = { (double)NAN, (double)NAN, (double)NAN };
        if ( has_halves( film ) )
            error_of_pixel( film, combine, i, e );
        for ( size_t c = 0; c < 3; ++c )
            error[3 * i + c] = (float)e[c];
    }
}
