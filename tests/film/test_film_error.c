// The relMSE estimate from the halves of a film is honest under heavy noise: fireflies in
// single pixels and whole tiles, edges, dark regions, noise larger than the picture. On
// average, against the error relative to the known truth.
#include "support/test.h"
#include "base/random.h"
#include "film/film.h"
#include "film/film_error.h"
#include "measure/image_error.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 150 // two strips and a part
#define HEIGHT 90
#define PIXELS ( WIDTH * HEIGHT )
#define SEEDS 32
#define PASSES 14

typedef struct Noise
{
    float probability, strength; // of a firefly: rare samples carry the light of all
    int tile;                    // pixels across that have it together
} Noise;

typedef float ( *Truth )( int x, int y );

static float flat( int x, int y ) { return (void)x, (void)y, 0.4f; }
static float dark( int x, int y ) { return (void)x, (void)y, 0.01f; }
static float edge( int x, int y ) { return ( x / 20 + y / 20 ) % 2 == 0 ? 0.05f : 1.5f; }
static float slope( int x, int y ) { return 0.02f + 0.01f * (float)( x + y ); }

// What a pass adds to a pixel of true value 1: a firefly, or uniform in 0.5 to 1.5
// times the rest.
static float sample( Noise noise, uint32_t seed, uint32_t pass, int x, int y )
{
    float base = 1.0f - noise.probability * noise.strength;
    uint32_t place = (uint32_t)( y / noise.tile * WIDTH + x / noise.tile ), own = (uint32_t)( y * WIDTH + x );
    uint64_t key = rf_pass_key( seed, 0, 0, pass );
    float lucky = rf_random( rf_pixel_key( key, place ), 0 ), even = rf_random( rf_pixel_key( key, own ), 1 );
    return base * ( 0.5f + even ) + ( lucky < noise.probability ? noise.strength : 0.0f );
}

static void fill_half( RfFilm* film, int half, Truth truth, Noise noise, uint32_t seed )
{
    for ( int i = 0; i < PIXELS; ++i )
    {
        float* p = film->half[half] + 4 * (size_t)i;
        for ( uint32_t pass = (uint32_t)half; pass < PASSES; pass += 2 )
        {
            float v = truth( i % WIDTH, i / WIDTH ) * sample( noise, seed, pass, i % WIDTH, i / WIDTH );
            for ( int c = 0; c < 3; ++c )
                p[c] += v;
            p[3] += 1.0f;
        }
    }
}

static double true_relmse( Truth truth, const float* rgb )
{
    static float true_rgb[3 * PIXELS];
    RfErrorMetrics metrics;
    for ( int i = 0; i < 3 * PIXELS; ++i )
        true_rgb[i] = truth( i / 3 % WIDTH, i / 3 / WIDTH );
    RfImage image = { .width = WIDTH, .height = HEIGHT, .rgb = (float*)rgb }, reference = image;
    reference.rgb = true_rgb;
    assert_int_equal( rf_measure_error( &image, &reference, &metrics, NULL ), RF_OK );
    return metrics.relmse;
}

// The mean estimate over the mean error lies between these.
static void check_between( const char* what, Truth truth, Noise noise, double low, double high )
{
    static float half[2][4 * PIXELS], rgb[3 * PIXELS];
    double estimate = 0.0, error = 0.0;
    for ( uint32_t seed = 1; seed <= SEEDS; ++seed )
    {
        memset( half, 0, sizeof half );
        RfFilm film = { .width = WIDTH,
                        .height = HEIGHT,
                        .half = { half[0], half[1] },
                        .passes = { PASSES / 2, PASSES / 2 },
                        .weight = { PASSES / 2, PASSES / 2 } };
        fill_half( &film, 0, truth, noise, seed );
        fill_half( &film, 1, truth, noise, seed );
        rf_combine_film( &film, RF_NORMALIZE_CROSSFIT, rgb, NULL );
        estimate += rf_estimate_relmse( &film, RF_NORMALIZE_CROSSFIT, rgb ).likely / SEEDS;
        error += true_relmse( truth, rgb ) / SEEDS;
    }
    printf( "%-30s relMSE %8.4f, estimated %8.4f: %.3f\n", what, error, estimate, estimate / error );
    assert_true( error > 0.0 && estimate / error > low && estimate / error < high );
}

static void check( const char* what, Truth truth, Noise noise ) { check_between( what, truth, noise, 0.85, 1.15 ); }

// Where the error is larger than the picture, and most pixels have not yet seen
// what makes it bright: of the right size, no more.
static void check_size( const char* what, Truth truth, Noise noise ) { check_between( what, truth, noise, 0.5, 2.0 ); }

TEST( test_noise_without_fireflies )
{
    Noise mild = { 0.0f, 0.0f, 1 };
    check( "even noise, flat", flat, mild );
    check( "even noise, dark", dark, mild );
    check( "even noise, edges", edge, mild );
    check( "even noise, slope", slope, mild );
}

TEST( test_fireflies_of_pixels )
{
    Noise rare = { 0.0005f, 25.0f, 1 }, strong = { 0.0005f, 100.0f, 1 };
    check( "fireflies, flat", flat, rare );
    check( "fireflies, edges", edge, rare );
    check( "fireflies, slope", slope, rare );
    check_size( "strong fireflies, flat", flat, strong );
    check_size( "strong fireflies, edges", edge, strong );
}

TEST( test_fireflies_of_tiles )
{
    Noise blocks = { 0.0005f, 15.0f, 3 };
    check( "fireflies of 3x3 tiles, flat", flat, blocks );
    check( "fireflies of 3x3 tiles, edges", edge, blocks );
    check( "fireflies of 3x3 tiles, slope", slope, blocks );
}

TEST( test_noise_beyond_the_picture )
{
    Noise wild = { 0.01f, 60.0f, 1 };
    check_size( "wild noise, flat", flat, wild );
    check_size( "wild noise, slope", slope, wild );
}

// Fireflies put into even noise are listed, and what is left is the noise without them.
TEST( test_specks_are_listed )
{
    static const int places[] = { 1234, 7, 9999, 12345, 5000 };
    static float half[2][4 * PIXELS], rgb[3 * PIXELS];
    RfFilm film = { .width = WIDTH,
                    .height = HEIGHT,
                    .half = { half[0], half[1] },
                    .passes = { PASSES / 2, PASSES / 2 },
                    .weight = { PASSES / 2, PASSES / 2 } };
    const RfNormalize none = RF_NORMALIZE_NONE;
    fill_half( &film, 0, flat, ( Noise ){ 0.0f, 0.0f, 1 }, 1 );
    fill_half( &film, 1, flat, ( Noise ){ 0.0f, 0.0f, 1 }, 1 );
    rf_combine_film( &film, none, rgb, NULL );
    RfRelmse clean = rf_estimate_relmse( &film, none, rgb );
    assert_true( clean.specks.pixels == 0 && clean.specks.count == 0 && clean.specks.rest == clean.likely );
    for ( int k = 0; k < 5; ++k )
        half[k % 2][4 * places[k] + 1] += 1000.0f / (float)( k + 1 );
    rf_combine_film( &film, none, rgb, NULL );
    RfRelmse spotted = rf_estimate_relmse( &film, none, rgb );
    double share = 0.0;
    assert_true( spotted.specks.pixels == 5 && spotted.specks.count == 5 );
    for ( int k = 0; k < 5; ++k )
    {
        double error = 0.5 * 1000.0 / ( k + 1 ) / ( PASSES / 2 );
        assert_int_equal( spotted.specks.worst[k].pixel, places[k] );
        assert_true( fabs( spotted.specks.worst[k].variance / ( error * error ) - 1.0 ) < 0.2 );
        share += spotted.specks.worst[k].share;
    }
    assert_true( fabs( share - spotted.specks.share ) < 1e-9 && share > 0.9 );
    assert_true( fabs( spotted.specks.rest / clean.likely - 1.0 ) < 0.02 );
    // a third of the picture is no set of specks
    for ( int i = 0; i < PIXELS / 3; ++i )
        half[0][4 * i] += 1000.0f;
    rf_combine_film( &film, none, rgb, NULL );
    assert_int_equal( rf_estimate_relmse( &film, none, rgb ).specks.pixels, 0 );
    half[0][4] = (float)NAN;
    rf_combine_film( &film, none, rgb, NULL );
    RfRelmse broken = rf_estimate_relmse( &film, none, rgb );
    assert_true( broken.specks.pixels == 0 && broken.specks.count == 0 && isnan( broken.specks.rest ) );
}

// A film narrower and lower than the surroundings, and values that are no
// picture at all, are answered with a number.
TEST( test_small_films_give_a_number )
{
    float half[2][4 * 6] = { { 0.0f } }, rgb[3 * 6];
    for ( int i = 0; i < 6; ++i )
    {
        half[0][4 * i] = 1.0f;
        half[1][4 * i] = 3.0f;
        half[0][4 * i + 3] = half[1][4 * i + 3] = 1.0f;
    }
    static const int sizes[][2] = { { 1, 1 }, { 6, 1 }, { 1, 6 }, { 3, 2 } };
    for ( size_t k = 0; k < sizeof sizes / sizeof sizes[0]; ++k )
    {
        RfFilm film = {
            .width = sizes[k][0], .height = sizes[k][1], .half = { half[0], half[1] }, .passes = { 1, 1 }, .weight = { 1, 1 }
        };
        rf_combine_film( &film, RF_NORMALIZE_NONE, rgb, NULL );
        RfRelmse relmse = rf_estimate_relmse( &film, RF_NORMALIZE_NONE, rgb );
        // red alone: halves 1 and 3. The value is between that of the darker half and of the picture,
        // 1/3 and 2/3 in the mean of the channels
        double least = 0.25 * 4.0 / ( 4.0 / 9.0 + RF_RELMSE_EPSILON );
        assert_true( relmse.least >= 0.99 * least && relmse.likely < 4.5 * least );
        assert_true( fabs( relmse.worst_share - 1.0 ) < 1e-9 ); // fewer than ten pixels
    }
}
