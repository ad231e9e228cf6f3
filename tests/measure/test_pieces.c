// Pieces: what is measured in them is what the whole render shows there, for a fraction of its samples.
#include "measure/trial_pieces.h"
#include "measure/trial.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"

#define EYES 5
#define WIDTH 160
#define HEIGHT 120
#define PIXELS 3000.0

typedef struct Setup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[EYES];
    int frames[EYES];
    RfTestPieces pieces;
} Setup;

static RfRenderSettings settings_of( int group, const char* tile, uint64_t seed )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.memory = (size_t)256 << 20;
    settings.group = group;
    settings.spp = 5;
    settings.max_depth = 2;
    settings.seed = seed;
    settings.adaptive = RF_ADAPTIVE_OFF;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

static void begin( Setup* s, float degrees, double pixels, bool filtered )
{
    RfError error;
    s->scene = make_room( ROOM_DIFFUSE );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, EYES, degrees, WIDTH, HEIGHT );
    for ( int i = 0; i < EYES; ++i )
        s->frames[i] = i;
    assert_int_equal( rf_choose_pieces( s->tracer, s->eyes, EYES, EYES / 2, pixels, filtered, 1, &s->pieces, &error ), RF_OK );
}

static void end( Setup* s )
{
    rf_destroy_test_pieces( &s->pieces );
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

// How many values of the pieces there are, and how many of them differ between two renders.
static void compare( const Setup* s, const Rendered* a, const Rendered* b, int* values, int* differ )
{
    int32_t pixel[RF_CELL_PIXELS];
    int cells = s->pieces.across * s->pieces.down;
    *values = *differ = 0;
    for ( int i = 0; i < EYES * cells; ++i )
    {
        int count = s->pieces.slot[i] >= 0 ? rf_cell_pixels( &s->pieces, i % cells, pixel ) : 0;
        for ( int k = 0; k < 3 * count; ++k )
        {
            size_t at = 3 * ( (size_t)( i / cells ) * WIDTH * HEIGHT + (size_t)pixel[k / 3] ) + (size_t)k % 3;
            *values += 1;
            *differ += a->rgb[at] != b->rgb[at];
        }
    }
}

// A piece is the same to the bit, but where a surface comes into sight between the pixels that are followed.
static void check_pieces( float degrees, int group, const char* tile, RfFilter filter )
{
    Setup s;
    begin( &s, degrees, PIXELS, filter != RF_FILTER_BOX );
    RfRenderSettings settings = settings_of( group, tile, 7 );
    settings.filter = filter;
    AUTO_BY( free_rendered ) Rendered whole = render_frames( s.tracer, s.eyes, EYES, s.frames, EYES, &settings );
    RfPieces pieces = rf_pieces_from( &s.pieces, 0 );
    settings.pieces = &pieces;
    AUTO_BY( free_rendered ) Rendered part = render_frames( s.tracer, s.eyes, EYES, s.frames, EYES, &settings );
    int values, differ;
    compare( &s, &whole, &part, &values, &differ );
    double traced = (double)part.stats.rays.primary / (double)whole.stats.rays.primary;
    print_message( "%g degrees, group %d, tile %s, %s: %d of %d values differ, %.1f %% of the samples\n", (double)degrees, group,
                   tile, rf_filter_name( filter ), differ, values, 100.0 * traced );
    assert_true( values > ( filter == RF_FILTER_BOX ? 3 : 2 ) * 1000 * EYES && differ <= values / 100 );
    assert_true( traced < ( filter == RF_FILTER_BOX ? 0.4 : 0.6 ) );
    assert_true( group > 0 || differ == 0 );
    end( &s );
}

TEST( test_pieces_are_parts_of_the_whole )
{
    check_pieces( 1.0f, 0, "1", RF_FILTER_BOX );
    check_pieces( 1.0f, 2, "1", RF_FILTER_BOX );
    check_pieces( 1.0f, 2, "3x3", RF_FILTER_BOX );
    check_pieces( 6.0f, 2, "3x3", RF_FILTER_BOX );
    check_pieces( 6.0f, 1, "rooks16", RF_FILTER_BOX );
    check_pieces( 1.0f, 0, "3x3", RF_FILTER_BLACKMAN_HARRIS );
    check_pieces( 1.0f, 2, "3x3", RF_FILTER_BLACKMAN_HARRIS );
}

// They lie all over the picture, do not overlap, and are as many pixels as were asked for.
TEST( test_pieces_are_spread )
{
    Setup s;
    begin( &s, 1.0f, PIXELS, false );
    const RfTestPieces* p = &s.pieces;
    assert_true( p->count >= 3 && p->pixels > 0.5 * PIXELS && p->pixels < 2.0 * PIXELS );
    int cells = p->across * p->down, in_half[2][2] = { { 0 } };
    const int32_t* slot = p->slot + EYES / 2 * cells;
    for ( int i = 0; i < cells; ++i )
        in_half[i / p->across * 2 / p->down][i % p->across * 2 / p->across] += slot[i] >= 0;
    assert_true( in_half[0][0] + in_half[1][0] > 0 && in_half[0][1] + in_half[1][1] > 0 );
    assert_true( in_half[0][0] + in_half[0][1] > 0 && in_half[1][0] + in_half[1][1] > 0 );
    for ( int i = 0; i < EYES * cells; ++i )
        assert_true( p->slot[i] < 0 || p->traced[i] );
    end( &s );
    // most of a picture is taken as a whole, in pieces that make it up
    begin( &s, 1.0f, 0.9 * WIDTH * HEIGHT, false );
    assert_true( s.pieces.traced == NULL && s.pieces.count == RF_MAX_PIECES );
    assert_int_equal( s.pieces.first_slot[EYES], EYES * s.pieces.across * s.pieces.down );
    end( &s );
    // one pixel asked for is one piece
    begin( &s, 1.0f, 1.0, false );
    assert_int_equal( s.pieces.count, 1 );
    end( &s );
}

static void try_both( const Setup* s, double pixels, uint64_t seed, RfTrial trials[2] )
{
    RfRenderSettings settings = settings_of( 0, "1", seed );
    AUTO_BY( rf_destroy_test_region ) RfTestRegion region;
    RfError error;
    settings.threads = 1;
    RfShot shot = { s->tracer, s->eyes, EYES, NULL, 0 };
    RfTestSite site = { EYES / 2, EYES, pixels };
    assert_int_equal( rf_create_test_region( &shot, NULL, &site, &settings, &region, &error ), RF_OK );
    for ( int reuse = 0; reuse < 2; ++reuse )
    {
        settings = settings_of( 2 * reuse, reuse ? "3x3" : "1", seed );
        settings.threads = 1;
        assert_int_equal( rf_run_trial( &region, reuse ? 1 : EYES, 2, &settings, trials + reuse, &error ), RF_OK );
        trials[reuse].cpu_seconds = trials[reuse].timed_samples; // a busy machine's times are not what is tested
        trials[reuse].time_noise = 0.0;
    }
}

// In the mean over seeds, each with other pieces, trials find the error of the whole pictures, and their intervals hold the
// ratio of errors.
TEST( test_trials_of_pieces_find_the_error )
{
    Setup s;
    begin( &s, 1.0f, PIXELS, false );
    int seeds = getenv( "REFRAME_LONG" ) != NULL ? 100 : 24, held = 0;
    static RfTrial whole[2], pieces[2];
    try_both( &s, WIDTH * HEIGHT, 1, whole );
    double truth[2] = { rf_trial_relmse( whole, 1.0 ), rf_trial_relmse( whole + 1, 1.0 ) }, found[2] = { 0.0, 0.0 };
    for ( int k = 0; k < seeds; ++k )
    {
        try_both( &s, PIXELS, (uint64_t)k, pieces );
        RfInterval gain = rf_trial_gain( pieces, pieces + 1 );
        held += gain.low <= truth[0] / truth[1] && truth[0] / truth[1] <= gain.high;
        for ( int reuse = 0; reuse < 2; ++reuse )
            found[reuse] += rf_trial_relmse( pieces + reuse, 1.0 ) / seeds;
    }
    print_message( "relMSE of pieces %.3f and %.3f, of whole pictures %.3f and %.3f; %d of %d intervals hold the ratio\n",
                   found[0], found[1], truth[0], truth[1], held, seeds );
    assert_true( fabs( log( found[0] / truth[0] ) ) < 0.4 && fabs( log( found[1] / truth[1] ) ) < 0.4 );
    assert_true( held >= 0.75 * seeds );
    end( &s );
}

// What needs whole frames refuses pieces.
TEST( test_pieces_are_refused_with_what_needs_frames )
{
    Setup s;
    begin( &s, 1.0f, PIXELS, false );
    RfPieces pieces = rf_pieces_from( &s.pieces, 0 );
    for ( int k = 0; k < 2; ++k )
    {
        RfRenderSettings settings = settings_of( 1, "3x3", 1 ), resolved;
        RfError error;
        settings.pieces = &pieces;
        assert_int_equal( rf_resolve_settings( &( RfShot ){ s.tracer, s.eyes, EYES, NULL, 0 }, &settings, &resolved, &error ),
                          RF_OK );
        settings.noise = k == 0 ? 0.1 : 0.0;
        settings.adaptive = k == 1 ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
        assert_int_equal( rf_resolve_settings( &( RfShot ){ s.tracer, s.eyes, EYES, NULL, 0 }, &settings, &resolved, &error ),
                          RF_ERROR_USAGE );
    }
    end( &s );
}
