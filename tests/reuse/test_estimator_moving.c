// Frames of rooms in which something moves (src/reuse/estimators.md, section 18), rendered with groups and tiles, have the mean of
// path tracing of a still room each, which a script made without any movement (tests/support/moving_rooms.py).
#include "film/film.h"
#include "render/estimator.h"
#include "support/moving_cases.h"
#include "support/statistics.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

TEST( test_what_passes_by )
{
    check_moving( &( MovingCase ){
        "sweep", 5, { 1, 3, 5 }, 3, { &g_moving_frames, &g_moving_tiles, &g_moving_rooks, &g_moving_adaptive } } );
}

TEST( test_a_door ) { check_moving( &( MovingCase ){ "door", 5, { 1, 3, 5 }, 3, { &g_moving_frames, &g_moving_tiles } } ); }

TEST( test_mirrors_that_turn )
{
    check_moving( &( MovingCase ){ "mirrors", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames, &g_moving_connected } } );
}

TEST( test_figures )
{
    check_moving( &( MovingCase ){ "figure", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_two_lights } } );
}

TEST( test_what_is_shown_at_times )
{
    check_moving( &( MovingCase ){ "shown", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_adaptive } } );
}

TEST( test_panes_that_move )
{
    check_moving( &( MovingCase ){ "panes", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames } } );
}

TEST( test_drapes ) { check_moving( &( MovingCase ){ "drapes", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_adaptive } } ); }

TEST( test_a_sky_through_openings )
{
    check_moving( &( MovingCase ){ "sky", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames } } );
}

TEST( test_lamps_and_a_hidden_sky )
{
    check_moving( &( MovingCase ){ "lamps", 5, { 2, 4 }, 2, { &g_moving_tiles, &g_moving_two_lights } } );
}

// B counts first hits, whatever becomes of their light.
TEST( test_mean_weight_is_1 ) { assert_mean_weight_is_1( "sweep" ); }

#define PIXELS ( MOVING_WIDTH * MOVING_HEIGHT )
#define VALUES ( 3 * PIXELS )
#define MIDDLE ( MOVING_EYES / 2 )
#define FEW 5 // seeds, where a bias would be large

typedef struct OwnSums
{
    double mean;  // of Bᵒ over the picture
    double most;  // by which it is off 1 in a pixel
    double share; // of Aᵒ in all light
    double extra; // the same of extra samples in all weight
} OwnSums;

static OwnSums s_own; // of the frame rendered last

// The pixels, and what is known of own-frame light.
static RfRelmse note_own( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch )
{
    (void)scratch;
    double light = 0.0, own = 0.0, weight = 0.0;
    s_own = ( OwnSums ){ 0 };
    rf_combine_film( films, settings->normalize, picture->rgb, picture->weight );
    for ( size_t i = 0; i < PIXELS; ++i )
    {
        RfFilmPixel p = rf_film_pixel( films, i );
        double b = ( p.own[0][3] + p.own[1][3] ) / ( films->weight[0] + films->weight[1] );
        s_own.mean += b / PIXELS;
        s_own.most = fmax( s_own.most, fabs( b - 1.0 ) );
        s_own.extra += p.extra[0] + p.extra[1];
        weight += p.weight[0] + p.weight[1];
        for ( int c = 0; c < 3; ++c )
        {
            own += p.own[0][c] + p.own[1][c];
            light += p.half[0][c] + p.half[1][c];
        }
    }
    s_own.share = own / ( own + light );
    s_own.extra /= weight;
    return rf_plain_relmse( (double)NAN );
}

// The frame in the middle, by the estimator that notes.
static Rendered render_noting( const MovingRoom* room, const RfTracer* tracer, RfRenderSettings settings, int seed )
{
    static RfEstimator noting;
    int frame = MIDDLE;
    noting = *settings.estimator;
    noting.finish = note_own;
    settings.estimator = &noting;
    settings.seed = (uint64_t)( seed + 1 );
    return render_frames( tracer, room->eyes, room->eye_count, &frame, 1, &settings );
}

// Bᵒ counts the samples of the frame itself, each once, by the pixel filter; extra ones are not among them.
TEST( test_own_samples_are_counted )
{
    static const char* const names[] = { "sky", "late" };
    for ( size_t k = 0; k < 2 * sizeof names / sizeof names[0]; ++k )
    {
        double mean[FEW], most = 0.0, extra = 0.0;
        MovingRoom room = load_moving_room( names[k / 2], MOVING_WIDTH, MOVING_HEIGHT );
        RfTracer* tracer = make_tracer( &room.scene );
        RfRenderSettings settings = moving_settings( &g_moving_adaptive, 3 );
        settings.filter = k % 2 == 0 ? RF_FILTER_BOX : RF_FILTER_BLACKMAN_HARRIS;
        settings.filter_width = k % 2 == 0 ? 1.0 : 1.5;
        for ( int s = 0; s < ( k % 2 == 0 ? 1 : FEW ); ++s )
        {
            Rendered r = render_noting( &room, tracer, settings, s );
            free_rendered( &r );
            mean[s] = s_own.mean;
            most = fmax( most, s_own.most );
            extra = fmax( extra, s_own.extra );
        }
        Sample all = sample_of( mean, k % 2 == 0 ? 1 : FEW );
        printf( "%s: mean weight of own samples %.5f, up to %.2g off; share of extra samples %.3f\n", names[k / 2], all.mean,
                most, extra );
        if ( k % 2 == 0 )
            assert_true( most < 1e-6 );
        else
            assert_false( is_far_off( ( all.mean - 1.0 ) / sqrt( all.variance ), FEW - 1 ) );
        if ( k / 2 == 1 )
            assert_true( extra > 0.01 );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

static int compare_doubles( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

// The median over the values of the picture of their relative variance. `own`: the least share of own-frame light that is found.
static double median_error( const MovingRoom* room, const RfTracer* tracer, const RfRenderSettings* settings, double* own )
{
    static double sum[VALUES], square[VALUES], error[VALUES];
    *own = 1.0;
    for ( int i = 0; i < VALUES; ++i )
        sum[i] = square[i] = 0.0;
    for ( int s = 0; s < SEEDS; ++s )
    {
        Rendered r = render_noting( room, tracer, *settings, s );
        for ( int i = 0; i < VALUES; ++i )
        {
            double value = (double)frame_rgb( &r, 0 )[i];
            sum[i] += value;
            square[i] += value * value;
        }
        free_rendered( &r );
        *own = fmin( *own, s_own.share );
    }
    for ( int i = 0; i < VALUES; ++i )
    {
        double mean = sum[i] / SEEDS;
        error[i] = ( square[i] / SEEDS - mean * mean ) / ( mean * mean + 1e-3 );
    }
    qsort( error, VALUES, sizeof *error, compare_doubles );
    return error[VALUES / 2];
}

// A group in which nearly all light is own-frame is no worse than its frames alone.
TEST( test_own_light_is_that_of_single_frames )
{
    MovingRoom room = load_moving_room( "shade", MOVING_WIDTH, MOVING_HEIGHT );
    RfTracer* tracer = make_tracer( &room.scene );
    MovingSetting setting = g_moving_tiles;
    RfRenderSettings group = moving_settings( &setting, 3 );
    setting.group = 0;
    RfRenderSettings alone = moving_settings( &setting, 3 );
    group.filter = alone.filter = RF_FILTER_BLACKMAN_HARRIS;
    group.filter_width = alone.filter_width = 1.5;
    double own, none, of_group = median_error( &room, tracer, &group, &own ),
                      of_frame = median_error( &room, tracer, &alone, &none );
    printf( "%.1f %% own-frame light: error %.4g, of frames alone %.4g\n", 100.0 * own, of_group, of_frame );
    assert_true( own > 0.9 );
    assert_true( of_group < 1.2 * of_frame );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &room.scene );
}

STATISTICAL_TESTS
