// The estimate of F1 from the halves of two films, against the known truth: frames that share most of their samples,
// some, or none; halves of unequal size; extra samples; fireflies.
#include "support/test.h"
#include "base/random.h"
#include "film/film_error.h"
#include "reframe/measure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define WIDTH 40
#define HEIGHT 30
#define PIXELS ( WIDTH * HEIGHT )
#define SEEDS 12

typedef struct Frame
{
    float half[2][4 * PIXELS], extra[2][PIXELS];
    RfFilm film;
    float rgb[3 * PIXELS];
} Frame;

static Frame s_frames[2];

// A pass's value in a pixel, of mean 1: even noise, or 1 in `rare` passes that carries all.
static float draw( uint32_t seed, uint32_t pass, int pixel, int rare )
{
    float u = rf_random( rf_pixel_key( rf_pass_key( seed, 0, 0, pass ), (uint32_t)pixel ), 0 );
    return rare == 0 ? 2.0f * u : u * (float)rare < 1.0f ? (float)rare : 0.0f;
}

static void clear( Frame* f, bool extra )
{
    memset( f, 0, sizeof *f );
    f->film = ( RfFilm ){ .width = WIDTH,
                          .height = HEIGHT,
                          .half = { f->half[0], f->half[1] },
                          .extra = { extra ? f->extra[0] : NULL, extra ? f->extra[1] : NULL } };
}

static void add_pass( Frame* f, uint32_t seed, uint32_t pass, int rare )
{
    int half = (int)( pass & 1 );
    for ( int i = 0; i < PIXELS; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            f->half[half][4 * i + c] += draw( seed, pass, i, rare ) * (float)( c + 1 );
        f->half[half][4 * i + 3] += 1.0f;
    }
    rf_end_film_pass( &f->film, half, 1.0 );
}

// An extra sample of each third pixel: it counts as a pass there.
static void add_extra( Frame* f, uint32_t seed, uint32_t pass )
{
    int half = (int)( pass & 1 );
    for ( int i = 0; i < PIXELS; i += 3 )
    {
        for ( int c = 0; c < 3; ++c )
            f->half[half][4 * i + c] += draw( seed, pass, i, 0 ) * (float)( c + 1 );
        f->half[half][4 * i + 3] += 1.0f;
        f->extra[half][i] += 1.0f;
    }
}

static double true_f1_squared( void )
{
    double sum = 0.0;
    for ( int i = 0; i < 3 * PIXELS; ++i )
    {
        double change = (double)s_frames[1].rgb[i] - (double)s_frames[0].rgb[i]; // the true values are the same
        sum += change * change;
    }
    return sum / ( 3.0 * PIXELS );
}

// By what is kept of both, not divided by their brightness.
static double absolute_f1_squared( void )
{
    static float kept[2][RF_KEPT_FLOATS * PIXELS];
    double sum = 0.0;
    for ( int k = 0; k < 2; ++k )
        rf_keep_film_error( &s_frames[k].film, RF_NORMALIZE_CROSSFIT, kept[k] );
    for ( int i = 0; i < RF_KEPT_FLOATS * PIXELS; ++i )
    {
        double change = (double)kept[1][i] - (double)kept[0][i];
        sum += i % RF_KEPT_FLOATS < 3 ? change * change : 0.0;
    }
    return sum / ( 3.0 * PIXELS );
}

static double s_relative; // the same ratio of the relative F1²

// Passes [first, end) of the two frames; estimate of F1² over truth, both in the mean.
static double ratio( uint32_t first0, uint32_t end0, uint32_t first1, uint32_t end1, bool extra, int rare )
{
    double estimate = 0.0, truth = 0.0, relative = 0.0;
    for ( uint32_t seed = 1; seed <= SEEDS; ++seed )
    {
        const uint32_t ends[2][2] = { { first0, end0 }, { first1, end1 } };
        for ( uint32_t k = 0; k < 2; ++k )
        {
            clear( s_frames + k, extra );
            for ( uint32_t pass = ends[k][0]; pass < ends[k][1]; ++pass )
                add_pass( s_frames + k, seed, pass, rare );
            for ( uint32_t pass = 0; pass < 5 && extra; ++pass ) // an odd number: the halves of a pixel differ
                add_extra( s_frames + k, seed, 1000 + 100 * k + pass );
            rf_combine_film( &s_frames[k].film, RF_NORMALIZE_CROSSFIT, s_frames[k].rgb, NULL );
        }
        RfFlicker f = rf_flicker_of_films( &s_frames[0].film, &s_frames[1].film, RF_NORMALIZE_CROSSFIT );
        estimate += absolute_f1_squared();
        relative += rf_flicker_f1_squared( &f );
        truth += true_f1_squared();
        RfFlicker own = rf_flicker_of_films( &s_frames[0].film, &s_frames[0].film, RF_NORMALIZE_CROSSFIT );
        assert_true( rf_film_mean_square( &s_frames[0].film, RF_NORMALIZE_CROSSFIT ) == own.before );
    }
    s_relative = relative / truth * ( 2.0 * 2.0 + RF_RELMSE_EPSILON ); // the mean of the channels is 2
    printf( "passes %u-%u and %u-%u: F1 %.4f, estimated %.4f; squared and relative, over the truth: %.3f\n", first0, end0, first1,
            end1, sqrt( truth / SEEDS ), sqrt( estimate / SEEDS ), s_relative );
    return estimate / truth;
}

// 12 · 1,200 pixels of 3 channels that are one: the mean of so many squares is known to 1.2 %.
TEST( test_estimate_is_true )
{
    static const uint32_t passes[][4] = {
        { 0, 14, 14, 28 }, { 0, 14, 7, 21 },  { 0, 14, 1, 15 }, { 0, 13, 2, 15 },
        { 0, 5, 1, 6 },    { 0, 26, 14, 28 }, { 0, 40, 2, 40 },
    };
    for ( size_t i = 0; i < sizeof passes / sizeof passes[0]; ++i )
    {
        double r = ratio( passes[i][0], passes[i][1], passes[i][2], passes[i][3], false, 0 );
        assert_true( r > 0.94 && r < 1.06 );
        assert_true( s_relative > 0.94 && s_relative < 1.06 );
    }
}

TEST( test_extra_samples_count )
{
    double r = ratio( 0, 8, 2, 10, true, 0 );
    assert_true( r > 0.94 && r < 1.06 );
    assert_true( s_relative > 0.94 && s_relative < 1.06 );
}

// One sample in 400: most pixels have none, and the errors are as right; the brightness that they are relative to is known less.
TEST( test_fireflies )
{
    double r = ratio( 0, 14, 2, 16, false, 400 );
    assert_true( r > 0.9 && r < 1.1 );
    assert_true( s_relative > 0.8 && s_relative < 1.25 );
}

TEST( test_all_in_common_is_no_flicker )
{
    for ( int k = 0; k < 2; ++k )
    {
        clear( s_frames + k, false );
        for ( uint32_t pass = 0; pass < 6; ++pass )
            add_pass( s_frames + k, 1, pass, 0 );
    }
    RfFlicker f = rf_flicker_of_films( &s_frames[0].film, &s_frames[1].film, RF_NORMALIZE_CROSSFIT );
    assert_true( f.now > 0.0 && fabs( rf_flicker_f1_squared( &f ) ) < 1e-12 * f.now );
    assert_false( rf_flicker_is_lower_bound( &f ) );
}

TEST( test_what_is_kept_is_the_film )
{
    static float kept[RF_KEPT_FLOATS * PIXELS];
    ratio( 0, 6, 2, 8, false, 0 );
    RfFlicker films = rf_flicker_of_films( &s_frames[0].film, &s_frames[1].film, RF_NORMALIZE_CROSSFIT );
    rf_keep_film_error( &s_frames[0].film, RF_NORMALIZE_CROSSFIT, kept );
    RfFlicker since = rf_flicker_since( kept, &s_frames[1].film, RF_NORMALIZE_CROSSFIT );
    assert_true( fabs( films.product - since.product ) <= 1e-6 * films.now &&
                 fabs( films.before - since.before ) <= 1e-6 * films.now );
    assert_true( fabs( films.now - since.now ) <= 1e-6 * films.now && fabs( films.worst_share - since.worst_share ) < 1e-6 );
}

// A change in one pixel is not to be trusted: what is reported is what the others make of it.
TEST( test_few_pixels_are_a_lower_bound )
{
    ratio( 0, 6, 2, 8, false, 0 );
    RfFlicker without = rf_flicker_of_films( &s_frames[0].film, &s_frames[1].film, RF_NORMALIZE_CROSSFIT );
    assert_false( rf_flicker_is_lower_bound( &without ) );
    assert_true( rf_reported_flicker( &without ) == rf_flicker_f1_squared( &without ) && rf_flicker_doubt( &without ) == 1.0 );
    s_frames[1].half[0][4 * 77] += 1000.0f;
    RfFlicker with = rf_flicker_of_films( &s_frames[0].film, &s_frames[1].film, RF_NORMALIZE_CROSSFIT );
    assert_true( rf_flicker_is_lower_bound( &with ) && rf_flicker_doubt( &with ) > 1.0 );
    double told = rf_reported_flicker( &with ), others = rf_flicker_f1_squared( &without );
    assert_true( rf_flicker_f1_squared( &with ) > 10.0 * others && told < others && told > 0.9 * others );
}

TEST( test_a_single_pass_tells_nothing )
{
    clear( s_frames, false );
    clear( s_frames + 1, false );
    add_pass( s_frames, 1, 0, 0 );
    add_pass( s_frames + 1, 1, 0, 0 );
    RfFlicker f = rf_flicker_of_films( &s_frames[0].film, &s_frames[1].film, RF_NORMALIZE_CROSSFIT );
    assert_true( isnan( rf_flicker_f1_squared( &f ) ) &&
                 isnan( rf_film_mean_square( &s_frames[0].film, RF_NORMALIZE_CROSSFIT ) ) );
}
