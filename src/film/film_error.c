// Estimates the relMSE of a film, and the flicker of two. The relMSE's numerator, the squared difference of the halves, is
// unbiased in every pixel, with fireflies and with errors that tiles and groups correlate between neighbours. The denominator is
// the brightness of the true picture (film/brightness.h), estimated from the brightness v of the picture, a and b of its halves
// (src/reuse/estimators.md, E24):
//
// - Of noise that is skewed the median is too low, by an amount that falls as one over the samples: v has lost v − (a + b) / 2
//   more than the truth (the jackknife, Quenouille, Notes on bias in estimation, Biometrika 43, 1956).
// - A firefly, copied to the pixels of a tile, passes the median. It lies in one half: where the halves differ by much, that in
//   which the pixel is darker is taken.
// - Light so rare that most pixels have seen none of it passes no median. A block of pixels is brighter by the mean of what one
//   half alone has above the median, without the ten largest, which may be a firefly and its copies.
//
// A pixel's error is one squared difference. Where the sum hangs on the ten worst pixels, only what it is at least can be
// reported: those with denominators from their own values. Where much light is rare, no pixel's brightness is known well, and all
// are.
//
// Specks are counted by a histogram of the terms: all above the lowest edge that is RF_SPECK times the mean term below it.
#include "film/film_error.h"

#include "film/brightness.h"
#include "film/film.h"
#include "trace/trace.h"

#include <math.h>

#define ROOM RF_BRIGHTNESS_ROOM
#define REACH RF_BRIGHTNESS_REACH
#define DIFFERENCE 10.0 // times the squared relative difference of the halves: how much the darker one counts
#define WORST 10        // pixels
#define VAGUE 0.1       // light that one half alone has, over the brightness: more leaves the latter unknown
#define AMBIGUOUS 0.7   // part of the sum that must not hang on what the worst pixels are

// What is kept of a pixel.
typedef struct Pixel
{
    double half[2]; // mean of the channels
    double value;   // of the picture, likewise
    double error;   // squared difference of the halves, summed over the channels
} Pixel;

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
    double likely, least;
    double bright, rare; // brightness, and the light that one half alone has above it
    int pixels;
    int count; // of the worst
    int binned[BINS];
    double in_bin[BINS];          // sum of the terms
    Term worst[RF_LISTED_SPECKS]; // descending
} Sum;

// A picture and its halves, from a film, or with NULL for it as pictures.
typedef struct Halves
{
    int width, height;
    const float* rgb; // NULL: the film's
    const RfFilm* film;
    RfNormalize normalize;
    const float* half[2];
} Halves;

static Pixel load_pixel( const Halves* from, size_t i )
{
    Pixel pixel = { .value = from->rgb != NULL ? rf_mean_of_channels( from->rgb + 3 * i ) : 0.0 };
    if ( from->film == NULL )
    {
        for ( int h = 0; h < 2; ++h )
            pixel.half[h] = rf_mean_of_channels( from->half[h] + 3 * i );
        return pixel;
    }
    RfFilmPixel p = rf_film_pixel( from->film, i );
    for ( int c = 0; c < 3; ++c )
    {
        double a = rf_film_half_value( &p, from->normalize, 0, c ), b = rf_film_half_value( &p, from->normalize, 1, c );
        pixel.half[0] += a / 3.0;
        pixel.half[1] += b / 3.0;
        pixel.value += from->rgb == NULL ? rf_film_value( &p, from->normalize, c ) / 3.0 : 0.0;
        pixel.error += ( a - b ) * ( a - b );
    }
    return pixel;
}

// Of a block.
typedef struct Values
{
    RfBlockValues half[2], value; // means of the channels, with the pixels around it
    double error[RF_BRIGHTNESS_SIDE * RF_BRIGHTNESS_SIDE];
    RfBlockValues dark[2], bright; // brightness of the halves and of the picture
} Values;

static void load_block( const Halves* from, const RfBlock* block, Values* values )
{
    int columns = block->right - block->left, rows = block->bottom - block->top;
    for ( int j = 0; j < rows + 2 * REACH; ++j )
    {
        for ( int i = 0; i < columns + 2 * REACH; ++i )
        {
            Pixel p = load_pixel( from, rf_block_pixel( from->width, from->height, block, i, j ) );
            values->half[0][j * ROOM + i] = p.half[0];
            values->half[1][j * ROOM + i] = p.half[1];
            values->value[j * ROOM + i] = p.value;
            if ( i >= REACH && i < columns + REACH && j >= REACH && j < rows + REACH )
                values->error[( j - REACH ) * RF_BRIGHTNESS_SIDE + i - REACH] = p.error;
        }
    }
    for ( int h = 0; h < 2; ++h )
        rf_block_brightness( from->width, from->height, block, values->half[h], values->dark[h] );
    rf_block_brightness( from->width, from->height, block, values->value, values->bright );
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

// What has been lost of the brightness of a picture, by those of its halves.
static double lost_brightness( const Values* v, int at ) { return v->bright[at] - 0.5 * ( v->dark[0][at] + v->dark[1][at] ); }

// The brightness at a pixel that is darker in half `darker`.
static double likely_brightness( const Values* v, int at, int darker )
{
    double lost = lost_brightness( v, at ), seen = v->bright[at] + lost, dark = fmax( v->dark[darker][at] + 2.0 * lost, 0.0 );
    double above = fmax( seen - dark, 0.0 ) / ( dark + sqrt( RF_RELMSE_EPSILON ) );
    return dark + ( seen - dark ) / ( 1.0 + DIFFERENCE * above * above );
}

// The mean over a block of what one half alone has above the brightness, and is not known to be lost, without the largest;
// `all`: the sum with them.
static double rare_light( const Values* v, int columns, int rows, double* all )
{
    double sum = 0.0, largest[WORST] = { 0.0 };
    for ( int j = 0; j < rows; ++j )
    {
        for ( int i = 0; i < columns; ++i )
        {
            int at = j * ROOM + i, centre = at + REACH * ( ROOM + 1 );
            double a = v->half[0][centre] - v->bright[at], b = v->half[1][centre] - v->bright[at];
            double alone = 0.5 * ( a + b ) - fmax( fmin( a, b ), 0.0 );
            keep_worst( largest, alone );
            sum += alone - lost_brightness( v, at );
        }
    }
    *all = fmax( sum, 0.0 );
    for ( int k = 0; k < WORST; ++k )
        sum -= largest[k];
    return fmax( sum, 0.0 ) / ( columns * rows );
}

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
    sum->least += term.least;
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
    sum->least += part->least;
    sum->bright += part->bright;
    sum->rare += part->rare;
    sum->pixels += part->pixels;
    for ( int bin = 0; bin < BINS; ++bin )
    {
        sum->binned[bin] += part->binned[bin];
        sum->in_bin[bin] += part->in_bin[bin];
    }
    for ( int i = 0; i < part->count; ++i )
        note_worst( sum, part->worst[i] );
}

// The brightness of a pixel of a block; `rare`: rare_light.
static double brightness_at( const Values* v, int at, double rare )
{
    int centre = at + REACH * ( ROOM + 1 );
    return rare + likely_brightness( v, at, v->half[0][centre] < v->half[1][centre] ? 0 : 1 );
}

static void add_block( Sum* sum, const Halves* from, const RfBlock* block )
{
    Values v;
    load_block( from, block, &v );
    double all, rare = rare_light( &v, block->right - block->left, block->bottom - block->top, &all );
    sum->rare += all;
    for ( int y = block->top; y < block->bottom; ++y )
    {
        for ( int x = block->left; x < block->right; ++x )
        {
            int j = y - block->top, i = x - block->left, at = j * ROOM + i, centre = at + REACH * ( ROOM + 1 );
            double likely = brightness_at( &v, at, rare );
            sum->bright += likely;
            double most = fmax( likely, fabs( v.value[centre] ) ), error = v.error[j * RF_BRIGHTNESS_SIDE + i];
            add( sum, ( Term ){ .likely = error / rf_relmse_denominator( likely ),
                                .least = error / rf_relmse_denominator( most ),
                                .error = error,
                                .pixel = y * from->width + x } );
        }
    }
}

// `share`: rf_film_half_share; `scale`: of the sum of all terms.
static RfSpeckList find_specks( const Sum* sum, double share, double scale )
{
    RfSpeckList specks = { .rest = scale * sum->likely };
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
    specks.rest = scale * fmax( sum->likely - of_specks, 0.0 );
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
    bool vague = sum->rare > VAGUE * sum->bright;
    return ( RfRelmse ){
        .likely = scale * sum->likely,
        .least = scale * ( vague ? sum->least : least ),
        .worst_share = sum->likely > 0.0 ? worst.likely / sum->likely : 0.0,
        .is_lower_bound = vague || least < AMBIGUOUS * sum->likely,
        .specks = find_specks( sum, share, scale ),
    };
}

RfRelmse rf_estimate_relmse( const RfFilm* film, RfNormalize normalize, const float* rgb )
{
    double share = rf_film_half_share( film );
    if ( share == 0.0 )
        return rf_plain_relmse( (double)NAN );
    Sum sum = { 0 };
    const Halves halves = { film->width, film->height, rgb, film, normalize, { NULL, NULL } };
#pragma omp parallel for schedule( dynamic, 1 ) ordered
    for ( int i = 0; i < rf_block_count( film->width, film->height ); ++i )
    {
        Sum part = { 0 };
        RfBlock block = rf_block( film->width, film->height, i );
        rf_set_float_mode();
        add_block( &part, &halves, &block );
#pragma omp ordered
        add_sum( &sum, &part );
    }
    return conclude( &sum, share, share / ( (double)film->width * (double)film->height ) );
}

void rf_likely_denominators( int width, int height, const float* rgb, const float* half_a, const float* half_b, double* below )
{
    const Halves halves = { .width = width, .height = height, .rgb = rgb, .half = { half_a, half_b } };
#pragma omp parallel for schedule( dynamic, 1 )
    for ( int i = 0; i < rf_block_count( width, height ); ++i )
    {
        Values v;
        RfBlock block = rf_block( width, height, i );
        int columns = block.right - block.left, rows = block.bottom - block.top;
        rf_set_float_mode();
        load_block( &halves, &block, &v );
        for ( int k = 0; k < columns * rows; ++k )
        {
            int x = k % columns, y = k / columns;
            below[(size_t)( block.top + y ) * (size_t)width + (size_t)( block.left + x )] =
                rf_relmse_denominator( brightness_at( &v, y * ROOM + x, 0.0 ) );
        }
    }
}

// Errors of a frame, from a film or kept.
typedef struct Errors
{
    const RfFilm* film; // NULL: kept
    const float* kept;
    RfNormalize normalize;
} Errors;

// The errors of a block of pixels, and what their squares are divided by.
typedef struct BlockErrors
{
    double error[RF_BRIGHTNESS_SIDE * RF_BRIGHTNESS_SIDE][3], below[RF_BRIGHTNESS_SIDE * RF_BRIGHTNESS_SIDE];
} BlockErrors;

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

// Pixel number `k` of a block.
static size_t pixel_of_block( const RfBlock* block, int width, int k )
{
    int columns = block->right - block->left;
    return (size_t)( block->top + k / columns ) * (size_t)width + (size_t)( block->left + k % columns );
}

static int pixels_of_block( const RfBlock* block ) { return ( block->right - block->left ) * ( block->bottom - block->top ); }

static void load_errors( const Errors* errors, int width, int height, const RfBlock* block, BlockErrors* out )
{
    int count = pixels_of_block( block ), columns = block->right - block->left;
    for ( int k = 0; k < count && errors->film == NULL; ++k )
    {
        const float* kept = errors->kept + RF_KEPT_FLOATS * pixel_of_block( block, width, k );
        for ( int c = 0; c < 3; ++c )
            out->error[k][c] = (double)kept[c];
        out->below[k] = (double)kept[3];
    }
    if ( errors->film == NULL )
        return;
    Values v;
    double all;
    load_block( &( Halves ){ .width = width, .height = height, .film = errors->film, .normalize = errors->normalize }, block,
                &v );
    rare_light( &v, columns, block->bottom - block->top, &all ); // with the largest: a firefly brightens its block, too
    for ( int k = 0; k < count; ++k )
    {
        error_of_pixel( errors->film, errors->normalize, pixel_of_block( block, width, k ), out->error[k] );
        out->below[k] = rf_relmse_denominator( brightness_at( &v, k / columns * ROOM + k % columns, all / count ) );
    }
}

static void add_errors( Sums* sums, const BlockErrors* before, const BlockErrors* now, int k )
{
    double change = 0.0, below = 0.5 * ( before->below[k] + now->below[k] );
    for ( int c = 0; c < 3; ++c )
    {
        double a = before->error[k][c], b = now->error[k][c];
        sums->before += a * a / below;
        sums->now += b * b / below;
        sums->product += a * b / below;
        change += ( b - a ) * ( b - a ) / below;
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
    Sums sums = { 0 };
    int width = now->film->width, height = now->film->height;
#pragma omp parallel for schedule( dynamic, 1 ) ordered
    for ( int i = 0; i < rf_block_count( width, height ); ++i )
    {
        Sums part = { 0 };
        BlockErrors a, b;
        RfBlock block = rf_block( width, height, i );
        rf_set_float_mode();
        load_errors( before, width, height, &block, &a );
        load_errors( now, width, height, &block, &b );
        for ( int k = 0; k < pixels_of_block( &block ); ++k )
            add_errors( &part, &a, &b, k );
#pragma omp ordered
        add_sums( &sums, &part );
    }
    double change = sums.before + sums.now - 2.0 * sums.product, worst = 0.0,
           scale = 1.0 / ( 3.0 * (double)pixels_of( now->film ) );
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
    const Errors errors = { .film = film, .normalize = normalize };
    return has_halves( film ) ? flicker_of( &errors, &errors ).now : (double)NAN;
}

void rf_keep_film_error( const RfFilm* film, RfNormalize normalize, float* kept )
{
    const Errors errors = { .film = film, .normalize = normalize };
    bool known = has_halves( film );
#pragma omp parallel for schedule( dynamic, 1 )
    for ( int i = 0; i < rf_block_count( film->width, film->height ); ++i )
    {
        BlockErrors of_block;
        RfBlock block = rf_block( film->width, film->height, i );
        rf_set_float_mode();
        if ( known )
            load_errors( &errors, film->width, film->height, &block, &of_block );
        for ( int k = 0; k < pixels_of_block( &block ); ++k )
        {
            float* to = kept + RF_KEPT_FLOATS * pixel_of_block( &block, film->width, k );
            for ( int c = 0; c < 3; ++c )
                to[c] = known ? (float)of_block.error[k][c] : NAN;
            to[3] = known ? (float)of_block.below[k] : 1.0f;
        }
    }
}
