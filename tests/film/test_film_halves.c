// Combining the two halves of a film (src/reuse/estimators.md, E2): by hand, without bias in the mean
// over many pixels, and relMSE from the difference of the halves.
#include "base/random.h"
#include "film/film.h"
#include "film/film_error.h"
#include "measure/image_error.h"
#include "support/statistics.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 256
#define HEIGHT 256
#define PIXELS ( WIDTH * HEIGHT )

typedef struct Film
{
    RfFilm film;
    float* rgb;
    float* weight;
} Film;

static Film make_film( int width, int height, int even, int odd )
{
    size_t pixels = (size_t)width * (size_t)height;
    Film f = { .film = { .width = width, .height = height, .passes = { even, odd }, .weight = { even, odd } } };
    for ( int h = 0; h < 2; ++h )
        f.film.half[h] = calloc( pixels, 4 * sizeof( float ) );
    f.film.mean = calloc( pixels, sizeof *f.film.mean );
    f.rgb = calloc( pixels, 3 * sizeof( float ) );
    f.weight = calloc( pixels, sizeof( float ) );
    if ( f.film.half[0] == NULL || f.film.half[1] == NULL || f.film.mean == NULL || f.rgb == NULL || f.weight == NULL )
        abort();
    f.film.block = rf_film_block( 1 );
    return f;
}

static void free_film( Film* f )
{
    free( f->film.half[0] );
    free( f->film.half[1] );
    free( f->film.mean );
    free( f->rgb );
    free( f->weight );
}

static void set_pixel( Film* f, int half, size_t i, float r, float g, float b, float w )
{
    float* p = f->film.half[half] + 4 * i;
    p[0] = r;
    p[1] = g;
    p[2] = b;
    p[3] = w;
}

static void near( float value, double expected ) { assert_true( fabs( (double)value - expected ) <= 1e-6 * fabs( expected ) ); }

// (E2) as it is written, for halves of as many passes: averages, not sums.
static double equation_2( double ae, double be, double ao, double bo )
{
    double ce = be > 0.0 ? ae / be : 0.0, co = bo > 0.0 ? ao / bo : 0.0;
    return 0.5 * ( ae + co * ( 1.0 - be ) ) + 0.5 * ( ao + ce * ( 1.0 - bo ) );
}

TEST( test_combined_halves_by_hand )
{
    Film f = make_film( 2, 1, 2, 3 );
    set_pixel( &f, 0, 0, 1.0f, 2.0f, 0.0f, 1.5f );
    set_pixel( &f, 1, 0, 4.0f, 5.0f, 7.0f, 3.5f );
    set_pixel( &f, 0, 1, 3.0f, 0.0f, 1.0f, 2.5f );
    set_pixel( &f, 1, 1, 6.0f, 1.0f, 1.0f, 2.0f );
    rf_combine_film( &f.film, RF_NORMALIZE_CROSSFIT, f.rgb, f.weight );
    // ( 1 + 4/3.5 (2 − 1.5) + 4 + 1/1.5 (3 − 3.5) ) / 5 and so on
    near( f.rgb[0], ( 1.0 + 4.0 / 7.0 + 4.0 - 1.0 / 3.0 ) / 5.0 );
    near( f.rgb[1], ( 2.0 + 5.0 / 7.0 + 5.0 - 2.0 / 3.0 ) / 5.0 );
    near( f.rgb[2], ( 1.0 + 7.0 ) / 5.0 );
    near( f.rgb[3], ( 3.0 - 1.5 + 6.0 + 1.2 ) / 5.0 );
    near( f.weight[0], 1.0 );
    near( f.weight[1], 0.9 );
    rf_combine_film( &f.film, RF_NORMALIZE_RATIO, f.rgb, NULL );
    near( f.rgb[0], 1.0 );
    near( f.rgb[5], 2.0 / 4.5 );
    rf_combine_film( &f.film, RF_NORMALIZE_NONE, f.rgb, NULL );
    near( f.rgb[1], 7.0 / 5.0 );
    near( f.rgb[4], 1.0 / 5.0 );
    free_film( &f );
}

// Radiance 2 that frames share and 3 that is own-frame: the hits of other frames add nothing to the latter.
TEST( test_own_light_has_its_own_sums )
{
    Film f = make_film( 2, 1, 2, 3 ); // the own-frame light of a film of one pixel is in the second
    float variance[3];
    f.film.width = 1;
    f.film.split = true;
    set_pixel( &f, 0, 0, 3.0f, 3.0f, 0.0f, 1.5f );
    set_pixel( &f, 1, 0, 7.0f, 7.0f, 7.0f, 3.5f );
    set_pixel( &f, 0, 1, 5.4f, 0.0f, 5.4f, 1.8f );
    set_pixel( &f, 1, 1, 9.3f, 0.0f, 9.3f, 3.1f );
    rf_combine_film( &f.film, RF_NORMALIZE_CROSSFIT, f.rgb, f.weight );
    near( f.rgb[0], 5.0 );
    near( f.rgb[1], 2.0 );
    near( f.rgb[2], ( 2.0 * 0.5 + 7.0 ) / 5.0 + 3.0 );
    near( f.weight[0], 1.0 );
    rf_estimate_variance( &f.film, RF_NORMALIZE_CROSSFIT, variance );
    assert_true( variance[0] < 1e-12f && variance[1] < 1e-12f && variance[2] > 0.1f );
    rf_combine_film( &f.film, RF_NORMALIZE_RATIO, f.rgb, NULL );
    near( f.rgb[0], 5.0 );
    near( f.rgb[2], 7.0 / 5.0 + 3.0 );
    rf_combine_film( &f.film, RF_NORMALIZE_NONE, f.rgb, NULL );
    near( f.rgb[0], ( 3.0 + 7.0 + 5.4 + 9.3 ) / 5.0 );
    free_film( &f );
}

// Extra samples bring all of their light, 5, to what is shared: neither quotient takes it for its own.
TEST( test_extra_samples_bring_own_light )
{
    Film f = make_film( 2, 1, 2, 3 );
    float extra[2] = { 4.0f, 6.0f }, variance[3];
    f.film.width = 1;
    f.film.split = true;
    f.film.extra[0] = extra;
    f.film.extra[1] = extra + 1;
    set_pixel( &f, 0, 0, 2.0f * 1.5f + 5.0f * 4.0f, 0.0f, 0.0f, 5.5f );
    set_pixel( &f, 1, 0, 2.0f * 3.5f + 5.0f * 6.0f, 0.0f, 0.0f, 9.5f );
    set_pixel( &f, 0, 1, 3.0f * 1.8f, 0.0f, 0.0f, 1.8f );
    set_pixel( &f, 1, 1, 3.0f * 3.1f, 0.0f, 0.0f, 3.1f );
    for ( int c = RF_NORMALIZE_CROSSFIT; c < RF_NORMALIZE_NONE; ++c )
    {
        rf_combine_film( &f.film, (RfNormalize)c, f.rgb, NULL );
        near( f.rgb[0], 5.0 );
        rf_estimate_variance( &f.film, (RfNormalize)c, variance );
        assert_true( variance[0] < 1e-12f );
    }
    rf_combine_film( &f.film, RF_NORMALIZE_NONE, f.rgb, NULL );
    near( f.rgb[0], ( 2.0 * 5.0 + 5.0 * 10.0 + 3.0 * 4.9 ) / 15.0 );
    free_film( &f );
}

static float uniform( uint32_t pixel, uint32_t dimension ) { return rf_random( rf_pixel_key( 4711, pixel ), dimension ); }

// A million passes of the same value: a sum in floats alone would be off by
// half a per cent.
TEST( test_long_sums_do_not_drift )
{
    enum
    {
        PASSES = 1 << 20
    };
    const float value = 0.1f;
    for ( int samples = 1; samples <= 1000; samples = samples * 7 + 3 )
    {
        Film f = make_film( 1, 1, 0, 0 );
        f.film.block = rf_film_block( samples );
        for ( int pass = 0; pass < PASSES; ++pass )
        {
            for ( int s = 0; s < samples && ( samples == 1 || pass < 1 << 12 ); ++s )
            {
                for ( int c = 0; c < 3; ++c )
                    f.film.half[pass & 1][c] += value;
            }
            f.film.half[pass & 1][3] += 1.0f;
            rf_end_film_pass( &f.film, pass & 1, 1.0 );
        }
        assert_int_equal( f.film.passes[0], PASSES / 2 );
        assert_int_equal( f.film.passes[1], PASSES / 2 );
        rf_combine_film( &f.film, RF_NORMALIZE_NONE, f.rgb, f.weight );
        double count = samples == 1 ? PASSES : (double)samples * ( 1 << 12 );
        double off = (double)f.rgb[0] / ( (double)value * count / PASSES ) - 1.0;
        printf( "%d samples a pass: off by %.2g\n", samples, off );
        assert_true( fabs( off ) < RF_FILM_ADDITIONS * 0x1p-25 );
        assert_true( f.weight[0] == 1.0f );
        free_film( &f );
    }
}

// Sums of a pixel over both halves.
static void sum_pixel( const Film* f, size_t i, double sums[4] )
{
    RfFilmPixel p = rf_film_pixel( &f->film, i );
    for ( int c = 0; c < 4; ++c )
        sums[c] = p.half[0][c] + p.half[1][c];
}

// What a film that has had `weight` passes of the values in each half makes of some blocks of them: added to `off`, relative to the
// brightest channel, and of B to itself.
static void drift( Film* f, const float* values, double weight, int blocks, double* off )
{
    size_t pixels = (size_t)f->film.width;
    double* before = malloc( 4 * pixels * sizeof *before );
    if ( before == NULL )
        abort();
    rf_clear_film( &f->film );
    for ( size_t k = 0; k < 8 * pixels; ++k )
        f->film.half[k / ( 4 * pixels )][k % ( 4 * pixels )] = (float)( weight * (double)values[k % ( 4 * pixels )] );
    f->film.weight[0] = f->film.weight[1] = weight;
    f->film.passes[0] = f->film.block - 1;
    rf_end_film_pass( &f->film, 1, 0.0 );
    assert_true( f->film.held[0] == weight && f->film.held[1] == weight );
    for ( size_t i = 0; i < pixels; ++i )
        sum_pixel( f, i, before + 4 * i );
    int passes = blocks * f->film.block;
    for ( int pass = 0; pass < passes; ++pass )
    {
        float* sums = f->film.half[pass & 1];
        for ( size_t k = 0; k < 4 * pixels; ++k )
            sums[k] += values[k];
        rf_end_film_pass( &f->film, pass & 1, 1.0 );
    }
    for ( size_t i = 0; i < pixels; ++i )
    {
        double sums[4];
        sum_pixel( f, i, sums );
        for ( size_t c = 0; c < 4; ++c )
            off[4 * i + c] += ( ( sums[c] - before[4 * i + c] ) / passes - (double)values[4 * i + c] ) /
                              (double)values[4 * i + ( c < 3 ? 0 : 3 )];
    }
    free( before );
}

// 10^9 additions of the same values: their error is the mean of that of blocks in their midst. Extra samples bring B more than the
// passes have.
TEST( test_1e9_equal_additions_stay_within_3e_5 )
{
    enum
    {
        PLACES = 64,
        VALUES = 512
    };
    float* values = malloc( 4 * VALUES * sizeof *values );
    float* mean_b = malloc( VALUES * sizeof *mean_b );
    double* off = malloc( 4 * VALUES * sizeof *off );
    if ( values == NULL || mean_b == NULL || off == NULL )
        abort();
    for ( int adaptive = 0; adaptive < 2; ++adaptive )
    {
        Film f = make_film( VALUES, 1, 0, 0 );
        double worst = 0.0, of_b = 0.0;
        if ( adaptive )
            f.film.mean_b = mean_b;
        for ( uint32_t i = 0; i < VALUES; ++i )
        {
            float brightest = exp2f( 2.0f * uniform( i, 0 ) - 1.0f );
            for ( uint32_t c = 0; c < 3; ++c )
                values[4 * i + c] = brightest * ( c > 0 ? uniform( i, c ) : 1.0f );
            values[4 * i + 3] = adaptive ? 1.0f + 3.0f * uniform( i, 3 ) : 1.0f;
        }
        memset( off, 0, 4 * VALUES * sizeof *off );
        for ( int place = 0; place < PLACES; ++place )
            drift( &f, values, floor( 5e8 * ( place + 0.5 ) / PLACES ), 2, off );
        for ( int k = 0; k < 4 * VALUES; ++k )
        {
            double* most = k % 4 < 3 ? &worst : &of_b;
            *most = fmax( *most, fabs( off[k] ) / PLACES );
        }
        printf( "1e9 additions: off by %.2g, B by %.2g\n", worst, of_b );
        assert_true( worst < 3e-5 && of_b < 3e-5 && ( adaptive || of_b == 0.0 ) );
        free_film( &f );
    }
    free( values );
    free( mean_b );
    free( off );
}

// With or without a mean taken out, the image is the same but for rounding.
TEST( test_the_mean_is_part_of_the_sum )
{
    enum
    {
        PASSES = 100
    };
    Film plain = make_film( 3, 2, 0, 0 ), held = make_film( 3, 2, 0, 0 );
    held.film.block = 14;
    for ( int pass = 0; pass < PASSES; ++pass )
    {
        int half = pass % 3 == 0;
        for ( int i = 0; i < 4 * 6; ++i )
        {
            float value = (float)( ( pass + 3 * i ) % 17 - ( i % 4 == 2 ? 8 : 0 ) );
            plain.film.half[half][i] += value;
            held.film.half[half][i] += value;
        }
        rf_end_film_pass( &plain.film, half, 1.0 );
        rf_end_film_pass( &held.film, half, 1.0 );
    }
    assert_true( plain.film.held[0] == 0.0 && held.film.held[0] > 0.0 );
    for ( size_t i = 0; i < 6; ++i )
    {
        RfFilmPixel a = rf_film_pixel( &plain.film, i ), b = rf_film_pixel( &held.film, i );
        for ( int k = 0; k < 8; ++k )
            assert_true( fabs( a.half[k / 4][k % 4] - b.half[k / 4][k % 4] ) <= 0x1p-24 * fabs( a.half[k / 4][k % 4] ) );
    }
    free_film( &plain );
    free_film( &held );
}

TEST( test_equal_halves_are_equation_2 )
{
    enum
    {
        PASSES = 4
    };
    Film f = make_film( WIDTH, HEIGHT, PASSES, PASSES );
    for ( uint32_t i = 0; i < PIXELS; ++i )
    {
        for ( int h = 0; h < 2; ++h )
        {
            uint32_t d = 4 * (uint32_t)h;
            set_pixel( &f, h, i, uniform( i, d ), uniform( i, d + 1 ), uniform( i, d + 2 ), 0.1f + 8.0f * uniform( i, d + 3 ) );
        }
    }
    rf_combine_film( &f.film, RF_NORMALIZE_CROSSFIT, f.rgb, NULL );
    for ( size_t i = 0; i < 3 * PIXELS; ++i )
    {
        const float* e = f.film.half[0] + 4 * ( i / 3 );
        const float* o = f.film.half[1] + 4 * ( i / 3 );
        double n = PASSES;
        double expected = equation_2( (double)e[i % 3] / n, (double)e[3] / n, (double)o[i % 3] / n, (double)o[3] / n );
        // rounding is relative to the terms, not to what they leave of each other
        double size = (double)e[i % 3] * ( 1.0 + n / (double)e[3] ) + (double)o[i % 3] * ( 1.0 + n / (double)o[3] );
        assert_true( fabs( (double)f.rgb[i] - expected ) < 1e-6 * ( size + fabs( expected ) ) );
    }
    free_film( &f );
}

// Passes of weight 3 and 1 are as four equal ones, three of them alike.
TEST( test_a_pass_of_weight_3_counts_three_times )
{
    Film heavy = make_film( WIDTH, HEIGHT, 0, 0 ), often = make_film( WIDTH, HEIGHT, 0, 0 );
    for ( int pass = 0; pass < 4; ++pass )
    {
        int weight = pass < 2 ? 3 : 1, half = pass % 2;
        for ( int k = 0; k < 4 * PIXELS; ++k )
        {
            float value = (float)(int)( 16.0f * uniform( (uint32_t)k, (uint32_t)pass ) ) / 16.0f;
            heavy.film.half[half][k] += (float)weight * value;
            for ( int i = 0; i < weight; ++i )
                often.film.half[half][k] += value;
        }
        rf_end_film_pass( &heavy.film, half, weight );
        for ( int i = 0; i < weight; ++i )
            rf_end_film_pass( &often.film, half, 1.0 );
    }
    assert_true( heavy.film.passes[0] == 2 && often.film.passes[0] == 4 );
    for ( int c = RF_NORMALIZE_CROSSFIT; c <= RF_NORMALIZE_NONE; ++c )
    {
        rf_combine_film( &heavy.film, (RfNormalize)c, heavy.rgb, heavy.weight );
        rf_combine_film( &often.film, (RfNormalize)c, often.rgb, often.weight );
        assert_memory_equal( heavy.rgb, often.rgb, 3 * PIXELS * sizeof( float ) );
        assert_memory_equal( heavy.weight, often.weight, PIXELS * sizeof( float ) );
        double a = rf_estimate_relmse( &heavy.film, (RfNormalize)c, heavy.rgb ).likely;
        assert_true( a > 0.0 && a == rf_estimate_relmse( &often.film, (RfNormalize)c, often.rgb ).likely );
    }
    free_film( &heavy );
    free_film( &often );
}

static void check_plain_mean( int even, int odd )
{
    Film f = make_film( WIDTH, HEIGHT, even, odd );
    for ( uint32_t i = 0; i < PIXELS; ++i )
    {
        set_pixel( &f, 0, i, uniform( i, 0 ), 9.0f * uniform( i, 1 ), 1e6f * uniform( i, 2 ), (float)even );
        set_pixel( &f, 1, i, uniform( i, 3 ), 0.1f * uniform( i, 4 ), 1e-6f * uniform( i, 5 ), (float)odd );
    }
    rf_combine_film( &f.film, RF_NORMALIZE_CROSSFIT, f.rgb, f.weight );
    for ( size_t i = 0; i < 3 * PIXELS; ++i )
    {
        double sum = (double)f.film.half[0][4 * ( i / 3 ) + i % 3] + (double)f.film.half[1][4 * ( i / 3 ) + i % 3];
        float mean = (float)( sum / ( even + odd ) );
        assert_memory_equal( f.rgb + i, &mean, sizeof mean );
        assert_true( f.weight[i / 3] == 1.0f );
    }
    free_film( &f );
}

TEST( test_whole_weights_give_the_plain_mean )
{
    check_plain_mean( 1, 1 );
    check_plain_mean( 4, 3 );
    check_plain_mean( 700, 701 );
}

TEST( test_empty_halves_leave_the_other )
{
    static const RfNormalize normalizes[] = { RF_NORMALIZE_CROSSFIT, RF_NORMALIZE_RATIO, RF_NORMALIZE_NONE };
    for ( int c = 0; c < 3; ++c )
    {
        Film f = make_film( 3, 1, 1, 1 );
        set_pixel( &f, 0, 1, 3.0f, 2.0f, 1.0f, 0.5f ); // pixel 0: nothing; 1: even only; 2: odd only
        set_pixel( &f, 1, 2, 3.0f, 2.0f, 1.0f, 0.5f );
        rf_combine_film( &f.film, normalizes[c], f.rgb, f.weight );
        assert_true( f.rgb[0] == 0.0f && f.rgb[1] == 0.0f && f.rgb[2] == 0.0f && f.weight[0] == 0.0f );
        // E2: ( 3 + 0 (1 − 0.5) + 0 + 6 (1 − 0) ) / 2
        double expected = normalizes[c] == RF_NORMALIZE_CROSSFIT ? 4.5 : ( normalizes[c] == RF_NORMALIZE_RATIO ? 6.0 : 1.5 );
        near( f.rgb[3], expected );
        near( f.rgb[6], expected );
        assert_true( isfinite( rf_estimate_relmse( &f.film, normalizes[c], f.rgb ).likely ) );

        f.film.passes[1] = 0; // a single pass in all: no other half, c = 0
        f.film.weight[1] = 0.0;
        set_pixel( &f, 1, 2, 0.0f, 0.0f, 0.0f, 0.0f );
        rf_combine_film( &f.film, normalizes[c], f.rgb, f.weight );
        near( f.rgb[3], normalizes[c] == RF_NORMALIZE_RATIO ? 6.0 : 3.0 );
        assert_true( f.rgb[6] == 0.0f );
        assert_true( isnan( rf_estimate_relmse( &f.film, normalizes[c], f.rgb ).likely ) );
        free_film( &f );
    }
}

// A pass of a made-up pixel: weight w with mean 1, light 0.5 w + w² with mean
// 0.5 + 4/3: light that goes with the weight, which a quotient gets wrong.
static void add_noisy_pass( Film* f, int half, uint32_t i, uint32_t pass )
{
    float w = 2.0f * uniform( i, pass );
    float* p = f->film.half[half] + 4 * (size_t)i;
    p[0] += w * ( 0.5f + w );
    p[1] += w;
    p[2] += 0.5f * w;
    p[3] += w;
}

#define NOISY_MEAN ( 0.5 + 4.0 / 3.0 )

// In standard errors: how far the mean over the pixels is off. `spread`: their
// standard deviation.
static double distance( const Film* f, int channel, double expected, double* spread )
{
    double* values = malloc( PIXELS * sizeof *values );
    if ( values == NULL )
        abort();
    for ( size_t i = 0; i < PIXELS; ++i )
        values[i] = (double)f->rgb[3 * i + (size_t)channel];
    double error, mean = mean_of( values, PIXELS, &error );
    free( values );
    *spread = error * sqrt( (double)PIXELS );
    return ( mean - expected ) / error;
}

static void check_unbiased( int even, int odd )
{
    Film f = make_film( WIDTH, HEIGHT, even, odd );
    for ( uint32_t i = 0; i < PIXELS; ++i )
    {
        for ( int pass = 0; pass < even + odd; ++pass )
            add_noisy_pass( &f, pass >= even, i, (uint32_t)pass );
    }
    double spread[3], away[3];
    for ( int c = RF_NORMALIZE_CROSSFIT; c <= RF_NORMALIZE_NONE; ++c )
    {
        rf_combine_film( &f.film, (RfNormalize)c, f.rgb, NULL );
        away[c] = distance( &f, 0, NOISY_MEAN, spread + c );
    }
    printf( "%d + %d passes: E2 %.2f SE off (sd %.3f), ratio %.1f SE (sd %.3f), plain %.2f SE (sd %.3f)\n", even, odd, away[0],
            spread[0], away[1], spread[1], away[2], spread[2] );
    assert_true( fabs( away[RF_NORMALIZE_CROSSFIT] ) < 4.0 );
    assert_true( fabs( away[RF_NORMALIZE_NONE] ) < 4.0 );
    assert_true( fabs( away[RF_NORMALIZE_RATIO] ) > 10.0 );
    if ( even > 2 )
        assert_true( spread[RF_NORMALIZE_CROSSFIT] < 0.9 * spread[RF_NORMALIZE_NONE] );
    // constant light: E2 is as good as the ratio
    rf_combine_film( &f.film, RF_NORMALIZE_CROSSFIT, f.rgb, NULL );
    double flat;
    distance( &f, 2, 0.5, &flat );
    assert_true( flat < 1e-5 );
    free_film( &f );
}

TEST( test_combination_has_no_bias )
{
    check_unbiased( 1, 1 );
    check_unbiased( 2, 1 );
    check_unbiased( 3, 3 );
    check_unbiased( 7, 2 );
}

// Noise of uniform distribution, independent in passes, pixels, channels.
static void check_relmse( RfNormalize normalize, int even, int odd )
{
    enum
    {
        BIG = 512
    };
    const float mean = 2.0f, width = 1.0f; // variance width²/12 per pass and channel
    Film f = make_film( BIG, BIG, even, odd );
    for ( uint32_t i = 0; i < BIG * BIG; ++i )
    {
        for ( int pass = 0; pass < even + odd; ++pass )
        {
            uint32_t d = 4 * (uint32_t)pass;
            float* p = f.film.half[pass >= even] + 4 * (size_t)i;
            for ( uint32_t c = 0; c < 3; ++c )
                p[c] += mean + width * ( uniform( i, d + c ) - 0.5f );
            p[3] += 1.0f;
        }
    }
    rf_combine_film( &f.film, normalize, f.rgb, NULL );
    double expected = 3.0 * (double)( width * width ) / 12.0 / ( even + odd ) / ( (double)( mean * mean ) + RF_RELMSE_EPSILON );
    double estimate = rf_estimate_relmse( &f.film, normalize, f.rgb ).likely;
    printf( "%d + %d passes: relMSE %.6f, estimate %.6f\n", even, odd, expected, estimate );
    assert_true( fabs( estimate / expected - 1.0 ) < 0.05 );
    free_film( &f );
}

TEST( test_difference_estimates_relmse )
{
    for ( int c = RF_NORMALIZE_CROSSFIT; c <= RF_NORMALIZE_NONE; ++c )
    {
        check_relmse( (RfNormalize)c, 1, 1 );
        check_relmse( (RfNormalize)c, 4, 4 );
        check_relmse( (RfNormalize)c, 5, 2 );
    }
}
