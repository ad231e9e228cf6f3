// Estimates the relMSE of a film, and the flicker of two. The relMSE's numerator, the squared difference of the halves, is
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
// A glint in one pixel that one sample in ten hits cannot be distinguished from a firefly. Where the sum hangs on
// that, in its ten worst pixels, only what it is at least can be reported: those pixels with denominators from
// their own values.
//
// Specks are counted by a histogram of the terms: all above the lowest edge that is RF_SPECK times the mean term below it.
#include "film/film_error.h"

#include "film/normalize.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

#define LEAST_SIDE 8 // pixels
#define REACH 2      // of the window, pixels to each side
#define NEAR 1       // of the inner one
#define SIDE ( 2 * REACH + 1 )
#define STRIP 64 // columns processed together
#define ROWS 32  // rows of a strip: what a thread looks at before another may go on
#define COLUMNS ( STRIP + 2 * REACH )
#define CELLS 32 // across and down, at most
// The inverse of the squared relative difference that is expected between a window and what is around it:
// 0.7 and 0.4.
#define WIDE_PRIOR 2.0
#define NEAR_PRIOR 6.0
#define OUTLIER 2.0   // noise counts so many times against what the neighbours differ by
#define WORST 10      // pixels
#define AMBIGUOUS 0.7 // part of the sum that must not hang on what the worst pixels are
// The shrunk values are too large by some 2 %: in eleven scenes other than those of scripts/validate estimate.
#define CORRECTION 1.05

// A coarse grid over the film, for the surroundings of a pixel beyond its direct neighbours. Sums over the pixels of a cell,
// each the mean of its channels.
typedef struct Cell
{
    double half[2];
    double squared; // of the difference of the halves
    int pixels;
} Cell;

typedef struct Surroundings
{
    int side; // of a cell, pixels
    int columns, rows;
    Cell cells[CELLS][CELLS];
    Cell all;
    double share;       // rf_film_half_share
    double correlation; // of errors in neighbouring pixels: variance of a sum over that of independent ones, at least 1
} Surroundings;

// The wide surroundings of a pixel.
typedef struct Around
{
    double mean;     // in one half, drawn towards the picture's where it is noisy
    double variance; // of a pixel of the picture
} Around;

// The part of a deviation from `mean` that is signal where noise has this variance, if the signal
// deviates by about as much as the mean itself. 0 to 1.
static inline double signal_share( double mean, double variance )
{
    double signal = mean * mean;
    return signal > 0.0 ? signal / ( signal + variance ) : 0.0;
}

static void add_to_cell( Cell* cell, const double half[2] )
{
    double d = half[0] - half[1];
    cell->half[0] += half[0];
    cell->half[1] += half[1];
    cell->squared += d * d;
    cell->pixels += 1;
}

static void add_cell( Cell* sum, const Cell* cell )
{
    sum->half[0] += cell->half[0];
    sum->half[1] += cell->half[1];
    sum->squared += cell->squared;
    sum->pixels += cell->pixels;
}

// Mean of the channels in each half.
static void grey( const RfFilm* film, RfNormalize normalize, size_t i, double half[2] )
{
    RfFilmPixel p = rf_film_pixel( film, i );
    for ( int h = 0; h < 2; ++h )
    {
        half[h] = 0.0;
        for ( int c = 0; c < 3; ++c )
            half[h] += rf_film_half_value( &p, normalize, h, c ) / 3.0;
    }
}

// Errors that are independent add up in their squares, those of a tile in themselves.
static double correlation_of( const Surroundings* around )
{
    double of_sums = 0.0;
    for ( int row = 0; row < around->rows; ++row )
    {
        for ( int column = 0; column < around->columns; ++column )
        {
            const Cell* cell = &around->cells[row][column];
            double d = cell->half[0] - cell->half[1];
            of_sums += d * d;
        }
    }
    return around->all.squared > 0.0 ? fmax( of_sums / around->all.squared, 1.0 ) : 1.0;
}

static void survey_cell( const RfFilm* film, RfNormalize normalize, int side, int column, int row, Cell* cell )
{
    int right = ( column + 1 ) * side < film->width ? ( column + 1 ) * side : film->width;
    int bottom = ( row + 1 ) * side < film->height ? ( row + 1 ) * side : film->height;
    for ( int y = row * side; y < bottom; ++y )
    {
        for ( int x = column * side; x < right; ++x )
        {
            double half[2];
            grey( film, normalize, (size_t)y * (size_t)film->width + (size_t)x, half );
            add_to_cell( cell, half );
        }
    }
}

// Sums a film up.
static void survey( const RfFilm* film, RfNormalize normalize, Surroundings* around )
{
    int longer = film->width > film->height ? film->width : film->height, side = ( longer + CELLS - 1 ) / CELLS;
    memset( around, 0, sizeof *around );
    around->side = side = side > LEAST_SIDE ? side : LEAST_SIDE;
    around->columns = ( film->width + side - 1 ) / side;
    around->rows = ( film->height + side - 1 ) / side;
    around->share = rf_film_half_share( film );
#pragma omp parallel for schedule( static )
    for ( int i = 0; i < around->rows * around->columns; ++i )
    {
        rf_set_float_mode();
        survey_cell( film, normalize, side, i % around->columns, i / around->columns,
                     &around->cells[i / around->columns][i % around->columns] );
    }
    for ( int row = 0; row < around->rows; ++row )
    {
        for ( int column = 0; column < around->columns; ++column )
            add_cell( &around->all, &around->cells[row][column] );
    }
    around->correlation = correlation_of( around );
}

// The 3×3 cells around pixel (x, y) without its own values `pixel`, in one half.
static Around look_wide( const Surroundings* around, int x, int y, int half, const double pixel[2] )
{
    int column = x / around->side, row = y / around->side;
    int left = column > 0 ? column - 1 : 0, right = column + 1 < around->columns ? column + 1 : column;
    int top = row > 0 ? row - 1 : 0, bottom = row + 1 < around->rows ? row + 1 : row;
    Cell sum = { .half = { -pixel[0], -pixel[1] }, .squared = -( pixel[0] - pixel[1] ) * ( pixel[0] - pixel[1] ), .pixels = -1 };
    for ( int i = top; i <= bottom; ++i )
    {
        for ( int k = left; k <= right; ++k )
            add_cell( &sum, &around->cells[i][k] );
    }
    double whole = fmax( around->all.half[half] / around->all.pixels, 0.0 );
    if ( sum.pixels < 1 )
        return ( Around ){ .mean = whole };
    double variance = around->share * fmax( sum.squared, 0.0 ) / sum.pixels;
    double mean = sum.half[half] / sum.pixels;
    return ( Around ){
        .mean = whole + signal_share( whole, variance * around->correlation / sum.pixels ) * ( mean - whole ),
        .variance = variance,
    };
}

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
    RfNormalize normalize;
    const float* rgb;
    int first, end;
    double share; // rf_film_half_share
    Pixel pixels[SIDE][COLUMNS];
} Strip;

// A pixel of the sum, as it is taken and with the denominator from its own value.
typedef struct Term
{
    double likely, least;
    double error; // Pixel.error
    int pixel;
} Term;

// Half octaves, from 2^-LOW on.
#define BINS 256
#define LOW 64

typedef struct Sum
{
    double likely;
    int pixels;
    int count; // of the worst
    int binned[BINS];
    double in_bin[BINS];          // sum of the terms
    Term worst[RF_LISTED_SPECKS]; // descending
} Sum;

static double mean_of_channels( const float* rgb ) { return ( (double)rgb[0] + (double)rgb[1] + (double)rgb[2] ) / 3.0; }

static Pixel load_pixel( const RfFilm* film, RfNormalize normalize, const float* rgb, size_t i )
{
    RfFilmPixel p = rf_film_pixel( film, i );
    Pixel pixel = { .value = mean_of_channels( rgb + 3 * i ) };
    for ( int c = 0; c < 3; ++c )
    {
        double a = rf_film_half_value( &p, normalize, 0, c ), b = rf_film_half_value( &p, normalize, 1, c );
        pixel.half[0] += a / 3.0;
        pixel.half[1] += b / 3.0;
        pixel.error += ( a - b ) * ( a - b );
    }
    return pixel;
}

// The rows around y; those above have been loaded, unless this is the first that is looked at.
static void go_to_row( Strip* s, int y, bool first )
{
    int height = s->film->height, top = y > REACH ? y - REACH : 0, bottom = y + REACH < height ? y + REACH : height - 1;
    for ( int row = first ? top : y + REACH; row <= bottom; ++row )
    {
        size_t start = (size_t)row * (size_t)s->film->width;
        for ( int x = s->first; x < s->end; ++x )
            s->pixels[row % SIDE][x - s->first] = load_pixel( s->film, s->normalize, s->rgb, start + (size_t)x );
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
static Around narrow( const Surroundings* around, Around wide, const Window* w, double prior )
{
    double variance = fmax( wide.variance, w->variance / w->count );
    double share = signal_share( wide.mean, prior * variance * around->correlation / w->count );
    return ( Around ){ .mean = wide.mean + share * ( w->darker / w->count - wide.mean ), .variance = variance };
}

// How far a pixel's own value is to be trusted, 0 to 1: by what its neighbours' differ beyond their noise.
static double own_trust( const Window* near, double own )
{
    double n = near->count, mean = near->value / n, noise = near->variance / n;
    double signal = fmax( near->squared / n - mean * mean - noise, 0.0 );
    return signal > 0.0 ? signal / ( signal + OUTLIER * fmax( noise, own ) ) : 0.0;
}

// Estimate of a pixel's true value.
static double likely_value( const Strip* s, const Surroundings* around, const Pixel* p, int x, int y )
{
    int darker = p->half[0] < p->half[1] ? 0 : 1;
    Window wide = look_around( s, x, y, darker, REACH ), near = look_around( s, x, y, darker, NEAR );
    if ( near.count == 0 )
        return p->value;
    Around found = narrow( around, look_wide( around, x, y, darker, p->half ), &wide, WIDE_PRIOR );
    found = narrow( around, found, &near, NEAR_PRIOR );
    double likely = found.mean + own_trust( &near, own_variance( s, p ) ) * ( p->value - found.mean );
    return fmax( likely, fmax( p->half[darker], 0.0 ) );
}

// The bin of a positive term.
static int bin_of( double likely )
{
    int exponent;
    double mantissa = frexp( likely, &exponent ); // 0.5 to 1
    int bin = 2 * ( exponent + LOW ) - ( mantissa < sqrt( 0.5 ) ? 2 : 1 );
    return bin < 0 ? 0 : bin < BINS ? bin : BINS - 1;
}

static double lower_edge( int bin ) { return exp2( 0.5 * bin - LOW ); }

static void note_worst( Sum* sum, Term term )
{
    if ( sum->count == RF_LISTED_SPECKS && term.likely <= sum->worst[RF_LISTED_SPECKS - 1].likely )
        return;
    int i = sum->count < RF_LISTED_SPECKS ? sum->count++ : RF_LISTED_SPECKS - 1;
    for ( ; i > 0 && sum->worst[i - 1].likely < term.likely; --i )
        sum->worst[i] = sum->worst[i - 1];
    sum->worst[i] = term;
}

static void add( Sum* sum, Term term )
{
    sum->likely += term.likely;
    sum->pixels += 1;
    if ( term.likely > 0.0 && isfinite( term.likely ) )
    {
        int bin = bin_of( term.likely );
        sum->binned[bin] += 1;
        sum->in_bin[bin] += term.likely;
    }
    note_worst( sum, term );
}

static void add_sum( Sum* sum, const Sum* part )
{
    sum->likely += part->likely;
    sum->pixels += part->pixels;
    for ( int bin = 0; bin < BINS; ++bin )
    {
        sum->binned[bin] += part->binned[bin];
        sum->in_bin[bin] += part->in_bin[bin];
    }
    for ( int i = 0; i < part->count; ++i )
        note_worst( sum, part->worst[i] );
}

// Adds columns [first, end) of rows [top, bottom) of the film.
static void add_block( Sum* sum, const Surroundings* around, const RfFilm* film, RfNormalize normalize, const float* rgb,
                       int first, int end, int top, int bottom )
{
    Strip s = {
        .film = film,
        .normalize = normalize,
        .rgb = rgb,
        .first = first > REACH ? first - REACH : 0,
        .end = end + REACH < film->width ? end + REACH : film->width,
        .share = rf_film_half_share( film ),
    };
    for ( int y = top; y < bottom; ++y )
    {
        go_to_row( &s, y, y == top );
        for ( int x = first; x < end; ++x )
        {
            const Pixel* p = &s.pixels[y % SIDE][x - s.first];
            double likely = likely_value( &s, around, p, x, y ), most = fmax( likely, fabs( p->value ) );
            add( sum, ( Term ){ .likely = p->error / ( likely * likely + 0.001 ),
                                .least = p->error / ( most * most + 0.001 ),
                                .error = p->error,
                                .pixel = y * film->width + x } );
        }
    }
}

// `share`: rf_film_half_share; `scale`: of the sum of all terms.
static RfSpeckList find_specks( const Sum* sum, double share, double scale )
{
    RfSpeckList specks = { .rest = CORRECTION * scale * sum->likely };
    if ( !isfinite( sum->likely ) )
        return ( RfSpeckList ){ .rest = (double)NAN };
    int most = (int)( RF_MOST_SPECKS * sum->pixels ), above = 0;
    double terms = 0.0, of_specks = 0.0;
    for ( int bin = BINS - 1; bin > 0; --bin )
    {
        above += sum->binned[bin];
        terms += sum->in_bin[bin];
        if ( above > ( most > WORST ? most : WORST ) || above == sum->pixels )
            break;
        double mean = fmax( sum->likely - terms, 0.0 ) / ( sum->pixels - above );
        if ( sum->binned[bin] == 0 || lower_edge( bin ) < fmax( RF_SPECK * mean, RF_LEAST_SPECK / share ) )
            continue;
        specks.pixels = above;
        of_specks = terms;
    }
    if ( specks.pixels == 0 )
        return specks;
    specks.share = fmin( of_specks / sum->likely, 1.0 );
    specks.rest = CORRECTION * scale * fmax( sum->likely - of_specks, 0.0 );
    specks.count = specks.pixels < RF_LISTED_SPECKS ? specks.pixels : RF_LISTED_SPECKS;
    for ( int i = 0; i < specks.count; ++i )
    {
        specks.worst[i].pixel = sum->worst[i].pixel;
        specks.worst[i].share = sum->worst[i].likely / sum->likely;
        specks.worst[i].variance = share * sum->worst[i].error;
    }
    return specks;
}

static RfRelmse conclude( const Sum* sum, double share, double scale )
{
    Term worst = { 0 };
    for ( int i = 0; i < sum->count && i < WORST; ++i )
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
        .specks = find_specks( sum, share, scale ),
    };
}

RfRelmse rf_estimate_relmse( const RfFilm* film, RfNormalize normalize, const float* rgb )
{
    double share = rf_film_half_share( film );
    if ( share == 0.0 )
        return rf_plain_relmse( (double)NAN );
    Surroundings around;
    survey( film, normalize, &around );
    Sum sum = { 0 };
    int strips = ( film->width + STRIP - 1 ) / STRIP, blocks = strips * ( ( film->height + ROWS - 1 ) / ROWS );
#pragma omp parallel for schedule( dynamic, 1 ) ordered
    for ( int i = 0; i < blocks; ++i )
    {
        int left = i % strips * STRIP, right = left + STRIP < film->width ? left + STRIP : film->width;
        int top = i / strips * ROWS, bottom = top + ROWS < film->height ? top + ROWS : film->height;
        Sum part = { 0 };
        rf_set_float_mode();
        add_block( &part, &around, film, normalize, rgb, left, right, top, bottom );
#pragma omp ordered
        add_sum( &sum, &part );
    }
    return conclude( &sum, share, share / ( (double)film->width * (double)film->height ) );
}

// Errors of a frame, from a film or kept.
typedef struct Errors
{
    const RfFilm* film; // NULL: kept
    const float* kept;
    RfNormalize normalize;
} Errors;

typedef struct Sums
{
    double before, now, product;
    double worst[WORST]; // squared changes of pixels, descending
} Sums;

// √(e o) / (e + o) times the difference of the halves: with variance v per weight it has the variance v / (e + o) of the
// whole. Extra samples make the weights those of the pixel.
static void error_of_pixel( const RfFilm* film, RfNormalize normalize, size_t i, double error[3] )
{
    RfFilmPixel p = rf_film_pixel( film, i );
    double e = p.weight[0], o = p.weight[1], scale = sqrt( e * o ) / ( e + o );
    for ( int c = 0; c < 3; ++c )
        error[c] = scale * ( rf_film_half_value( &p, normalize, 0, c ) - rf_film_half_value( &p, normalize, 1, c ) );
}

static void load_error( const Errors* errors, size_t i, double error[3] )
{
    if ( errors->film != NULL )
        error_of_pixel( errors->film, errors->normalize, i, error );
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

static void add_errors( Sums* sums, const double before[3], const double now[3] )
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

static void add_sums( Sums* sums, const Sums* part )
{
    sums->before += part->before;
    sums->now += part->now;
    sums->product += part->product;
    for ( int k = 0; k < WORST; ++k )
        keep_worst( sums->worst, part->worst[k] );
}

static size_t pixels_of( const RfFilm* film ) { return (size_t)film->width * (size_t)film->height; }

static RfFlicker flicker_of( const Errors* before, const Errors* now )
{
    Sums sums = { 0 }, of_part[RF_FILM_PARTS] = { { 0 } };
    size_t pixels = pixels_of( now->film );
#pragma omp parallel for schedule( static )
    for ( int part = 0; part < RF_FILM_PARTS; ++part )
    {
        rf_set_float_mode();
        for ( size_t i = rf_film_part( now->film, part ); i < rf_film_part( now->film, part + 1 ); ++i )
        {
            double a[3], b[3];
            load_error( before, i, a );
            load_error( now, i, b );
            add_errors( of_part + part, a, b );
        }
    }
    for ( int part = 0; part < RF_FILM_PARTS; ++part )
        add_sums( &sums, of_part + part );
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

RfFlicker rf_flicker_of_films( const RfFilm* before, const RfFilm* now, RfNormalize normalize )
{
    if ( !has_halves( before ) || !has_halves( now ) )
        return unknown();
    return flicker_of( &( Errors ){ .film = before, .normalize = normalize },
                       &( Errors ){ .film = now, .normalize = normalize } );
}

RfFlicker rf_flicker_since( const float* before, const RfFilm* now, RfNormalize normalize )
{
    if ( !has_halves( now ) )
        return unknown();
    return flicker_of( &( Errors ){ .kept = before }, &( Errors ){ .film = now, .normalize = normalize } );
}

double rf_film_mean_square( const RfFilm* film, RfNormalize normalize )
{
    double of_part[RF_FILM_PARTS] = { 0.0 }, sum = 0.0;
    if ( !has_halves( film ) )
        return (double)NAN;
#pragma omp parallel for schedule( static )
    for ( int part = 0; part < RF_FILM_PARTS; ++part )
    {
        rf_set_float_mode();
        for ( size_t i = rf_film_part( film, part ); i < rf_film_part( film, part + 1 ); ++i )
        {
            double error[3];
            error_of_pixel( film, normalize, i, error );
            of_part[part] += error[0] * error[0] + error[1] * error[1] + error[2] * error[2];
        }
    }
    for ( int part = 0; part < RF_FILM_PARTS; ++part )
        sum += of_part[part];
    return sum / ( 3.0 * (double)pixels_of( film ) );
}

void rf_keep_film_error( const RfFilm* film, RfNormalize normalize, float* error )
{
    size_t width = (size_t)film->width;
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < film->height; ++y )
    {
        rf_set_float_mode();
        for ( size_t i = (size_t)y * width; i < ( (size_t)y + 1 ) * width; ++i )
        {
            double e[3] = { (double)NAN, (double)NAN, (double)NAN };
            if ( has_halves( film ) )
                error_of_pixel( film, normalize, i, e );
            for ( size_t c = 0; c < 3; ++c )
                error[3 * i + c] = (float)e[c];
        }
    }
}
