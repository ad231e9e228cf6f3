// The tables of pixel filters against their formulas: weights, what is left at the border of a film, places drawn.
#include "base/random.h"
#include "film/pixel_filter.h"
#include "support/filter_reference.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>

static const struct
{
    RfFilter filter;
    double width;
} s_filters[] = { { RF_FILTER_BOX, 1.5 },
                  { RF_FILTER_BOX, 4.0 },
                  { RF_FILTER_TENT, 1.0 },
                  { RF_FILTER_TENT, 0.5 },
                  { RF_FILTER_GAUSSIAN, 1.5 },
                  { RF_FILTER_BLACKMAN_HARRIS, 1.5 },
                  { RF_FILTER_BLACKMAN_HARRIS, 4.0 } };

#define FILTERS ( sizeof s_filters / sizeof s_filters[0] )
#define SIZE 20 // of a film, pixels

static RfPixelFilter make( size_t k )
{
    RfPixelFilter filter;
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = s_filters[k].filter;
    settings.filter_width = s_filters[k].width;
    rf_make_pixel_filter( &settings, &filter );
    assert_int_equal( filter.taps * filter.taps, rf_filter_pixels( &settings ) );
    return filter;
}

TEST( test_weights_are_those_of_the_formula )
{
    for ( size_t k = 0; k < FILTERS; ++k )
    {
        RfPixelFilter filter = make( k );
        double worst = 0.0;
        for ( int step = 0; step < RF_FILTER_STEPS; step += 5 )
        {
            float weights[RF_FILTER_TAPS];
            rf_filter_weights( &filter, 100, ( (float)step + 0.5f ) / RF_FILTER_STEPS, 200, weights );
            for ( int tap = 0; tap < filter.taps; ++tap )
            {
                double from = (double)step / RF_FILTER_STEPS - ( tap - filter.reach ) - 0.5;
                double mean = filter_integral( s_filters[k].filter, s_filters[k].width, from, from + 1.0 / RF_FILTER_STEPS );
                worst = fmax( worst, fabs( (double)weights[tap] - mean * RF_FILTER_STEPS ) );
            }
        }
        assert_true( worst < 1e-5 );
    }
}

// The integral over the film of the weight of each pixel is 1, in films narrower than the filter, too.
TEST( test_every_pixel_has_the_whole_filter )
{
    for ( size_t k = 0; k < FILTERS; ++k )
    {
        RfPixelFilter filter = make( k );
        for ( int size = 1; size <= SIZE; ++size )
        {
            double sum[SIZE + 2 * RF_FILTER_REACH] = { 0 };
            for ( int i = 0; i < size * RF_FILTER_STEPS; ++i )
            {
                float weights[RF_FILTER_TAPS];
                int q = i / RF_FILTER_STEPS;
                rf_filter_weights( &filter, q, ( (float)( i % RF_FILTER_STEPS ) + 0.5f ) / RF_FILTER_STEPS, size, weights );
                for ( int tap = 0; tap < filter.taps; ++tap )
                    sum[q + tap] += (double)weights[tap] / RF_FILTER_STEPS; // pixel q + tap − reach
            }
            for ( int p = -filter.reach; p < size + filter.reach; ++p )
                assert_true( fabs( sum[p + filter.reach] - ( p >= 0 && p < size ? 1.0 : 0.0 ) ) < 1e-5 );
        }
    }
}

// Places stay in the film, and their distribution function is that of the filter within it.
TEST( test_places_are_drawn_by_the_filter )
{
    for ( size_t k = 0; k < FILTERS; ++k )
    {
        RfPixelFilter filter = make( k );
        for ( int p = 0; p < SIZE; p += p == 1 ? 8 : p == 9 ? 10 : 1 )
        {
            double low = -p - 0.5, high = SIZE - p - 0.5;
            double all = filter_integral( s_filters[k].filter, s_filters[k].width, low, high );
            for ( int i = 0; i < 50; ++i )
            {
                float random = ( (float)i + 0.5f ) / 50.0f, place = rf_draw_filter_place( &filter, p, SIZE, random );
                assert_true( (float)p + place >= 0.0f && (float)p + place <= SIZE );
                double below = filter_integral( s_filters[k].filter, s_filters[k].width, low, (double)place - 0.5 ) / all;
                assert_true( fabs( below - (double)random ) < 2e-3 );
            }
        }
    }
}
