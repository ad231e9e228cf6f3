// Trials: what one window of frames says about the middle of a long path is what a render
// of the whole path shows.
#include "measure/trial.h"
#include "support/render_support.h"
#include "render/groups.h"
#include "support/scene_builder.h"
#include "support/test.h"

#define EYES 17
#define WIDTH 20
#define HEIGHT 15

typedef struct Setup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[EYES];
    RfTestRegion site;
} Setup;

static RfRenderSettings settings_of( int group, const char* tile )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.memory = (size_t)256 << 20;
    settings.threads = 1;
    settings.group = group;
    settings.adaptive = RF_ADAPTIVE_OFF; // trials have none
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

static void begin( Setup* s, float degrees, int centre, int frames )
{
    RfRenderSettings settings = settings_of( 0, "1" );
    RfError error;
    s->scene = make_room( ROOM_DIFFUSE );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, EYES, degrees, WIDTH, HEIGHT );
    RfShot shot = { s->tracer, s->eyes, EYES, NULL, 0 };
    RfTestSite site = { centre, frames, WIDTH * HEIGHT };
    assert_int_equal( rf_create_test_region( &shot, NULL, &site, &settings, &s->site, &error ), RF_OK );
}

static void end( Setup* s )
{
    rf_destroy_test_region( &s->site );
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

static RfTrial trial_of( const Setup* s, int windows, int passes, const RfRenderSettings* settings )
{
    RfTrial trial;
    RfError error;
    if ( rf_run_trial( &s->site, windows, passes, settings, &trial, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return trial;
}

static void expect_near( const char* what, double found, double expected, double share )
{
    if ( !( fabs( found - expected ) <= share * fabs( expected ) ) )
        fail_msg( "%s: %g, not %g", what, found, expected );
}

// Every pixel has one, and the pieces of a small picture make it up.
static void check_weights( const RfTestRegion* site )
{
    const RfTestPieces* pieces = &site->pieces;
    int32_t pixel[RF_CELL_PIXELS];
    int cells = pieces->across * pieces->down, pixels = 0;
    assert_true( pieces->traced == NULL && pieces->pixels == WIDTH * HEIGHT );
    for ( int i = 0; i < site->frames * cells; ++i )
    {
        int count = rf_cell_pixels( pieces, i % cells, pixel );
        pixels += count;
        for ( int k = 0; k < count; ++k )
        {
            float weight = site->weight[RF_CELL_PIXELS * pieces->slot[i] + k];
            assert_true( weight > 0.0f && weight <= 1000.0f );
        }
    }
    assert_int_equal( pixels, site->frames * WIDTH * HEIGHT );
}

// Both pictures of one render: the exact one has the errors that it has without a clamp, and what the clamped one gains in
// variance it loses in light.
TEST( test_clamped_and_exact_come_from_one_render )
{
    Setup s;
    begin( &s, 1.0f, 7, EYES );
    RfRenderSettings settings = settings_of( 1, "3x3" );
    RfTrial exact = trial_of( &s, 3, 4, &settings );
    assert_true( exact.clamp.relmse == 0.0 && exact.clamp.threshold == 0.0 && exact.pieces[0].clamped == 0.0 );
    double last = 0.0, missing = 1.0;
    static const double thresholds[] = { 0.01, 0.1, 1e6 };
    for ( int i = 0; i < 3; ++i )
    {
        settings.clamp = thresholds[i];
        RfTrial trial = trial_of( &s, 3, 4, &settings );
        const RfClampSums* c = &trial.clamp;
        expect_near( "exact relMSE", trial.relmse, exact.relmse, 1e-3 );
        expect_near( "exact change", trial.change, exact.change, 1e-3 );
        expect_near( "threshold", c->threshold / c->frames, thresholds[i], 1e-6 );
        double sum = 0.0, lost = c->removed / c->light;
        for ( int k = 0; k < trial.piece_count; ++k )
            sum += trial.pieces[k].clamped;
        expect_near( "pieces", sum, c->relmse, 1e-9 );
        expect_near( "of a sample", rf_trial_clamped_error( &trial ).value, c->relmse / trial.weight, 1e-9 );
        assert_true( c->relmse > last && c->relmse <= 1.001 * trial.relmse && lost < missing );
        assert_true( i < 2 ? lost > 0.0 && c->bias > 0.0 : lost == 0.0 && c->bias == 0.0 );
        last = c->relmse;
        missing = lost;
    }
    end( &s );
}

TEST( test_region_is_cut_at_the_ends_of_the_path )
{
    static const int cases[][4] = { { 7, 5, 5, 5 }, { 0, 5, 0, 5 }, { 16, 5, 12, 5 }, { 3, 99, 0, EYES }, { 9, 1, 9, 1 } };
    for ( int i = 0; i < 5; ++i )
    {
        Setup s;
        begin( &s, 1.0f, cases[i][0], cases[i][1] );
        assert_int_equal( s.site.first, cases[i][2] );
        assert_int_equal( s.site.frames, cases[i][3] );
        assert_true( s.site.whole == ( cases[i][3] == EYES ) );
        assert_true( s.site.eyes->width == WIDTH && s.site.eyes->height == HEIGHT );
        check_weights( &s.site );
        end( &s );
    }
}

// Counts and properties that hold whatever the samples are.
TEST( test_sums_hold_for_any_samples )
{
    Setup s;
    begin( &s, 1.0f, 7, EYES );
    RfRenderSettings settings = settings_of( 0, "1" );
    RfTrial one = trial_of( &s, 5, 3, &settings ), again = trial_of( &s, 5, 3, &settings ), sum = one;
    assert_int_equal( one.groups, 5 );
    assert_true( one.weight == 5.0 * WIDTH * HEIGHT && one.samples == 2 * 3 * one.weight );
    assert_true( one.timed_samples > 0.0 && one.timed_samples <= one.samples );
    assert_true( one.cpu_seconds > 0.0 && one.finish_seconds >= 0.0 );
    assert_true( one.relmse == again.relmse && one.change == again.change );
    // frames without reuse are independent
    expect_near( "phi", rf_trial_phi( &one ), 1.0, 1e-9 );
    expect_near( "F1", rf_trial_f1( &one, 4.0 ), sqrt( 2.0 / 3.0 * one.relmse / one.weight / 4.0 ), 1e-9 );
    rf_add_trial( &sum, &again );
    expect_near( "relMSE of both", rf_trial_relmse( &sum, 8.0 ), rf_trial_relmse( &one, 8.0 ), 1e-12 );
    expect_near( "samples", rf_trial_relmse( &one, 16.0 ), 0.5 * rf_trial_relmse( &one, 8.0 ), 1e-12 );
    sum.cpu_seconds = 2.0 * one.cpu_seconds;
    expect_near( "seconds", rf_trial_sample_seconds( &sum ), rf_trial_sample_seconds( &one ), 1e-12 );
    settings.seed = 2;
    RfTrial other = trial_of( &s, 5, 3, &settings );
    assert_true( other.relmse != one.relmse );
    // as many windows as fit, at least one
    settings.group = 3;
    assert_int_equal( trial_of( &s, 5, 2, &settings ).groups, 2 );
    assert_int_equal( trial_of( &s, 0, 2, &settings ).groups, 1 );
    end( &s );
}

// More passes: the error of one does not grow. It falls, as numbers are stratified, and most where nearly all light is direct, as here.
TEST( test_more_passes_no_more_error )
{
    Setup s;
    begin( &s, 1.0f, 7, EYES );
    RfRenderSettings settings = settings_of( 0, "1" );
    RfTrial few = { 0 }, many = { 0 };
    for ( int k = 0; k < 8; ++k )
    {
        settings.seed = (uint64_t)k;
        RfTrial a = trial_of( &s, EYES, 4, &settings ), b = trial_of( &s, EYES, 16, &settings );
        rf_add_trial( &few, &a );
        rf_add_trial( &many, &b );
    }
    double error = rf_trial_relmse( &many, 1.0 ) / rf_trial_relmse( &few, 1.0 );
    printf( "error of a sample, 16 passes over 4: %.3f\n", error );
    assert_true( error > 0.5 && error < 1.0 );
    end( &s );
}

// Eyes that are all the same see the same: two neighbours share all windows but one each.
TEST( test_equal_eyes_average_their_samples )
{
    Setup s;
    begin( &s, 0.0f, 7, 9 );
    for ( int group = 1; group <= 4; group += 3 )
    {
        RfRenderSettings settings = settings_of( group, "1" );
        RfTrial trial = trial_of( &s, 1, 4, &settings );
        double eyes = 2 * group + 1;
        expect_near( "phi", rf_trial_phi( &trial ), 1.0 / eyes, 0.02 );
        settings.group = 0;
        RfTrial plain = trial_of( &s, 9, 4, &settings );
        expect_near( "relMSE", rf_trial_relmse( &trial, eyes ), rf_trial_relmse( &plain, eyes * eyes ), 0.35 );
    }
    end( &s );
    // all of the path in one window: the same picture throughout
    begin( &s, 0.0f, 7, EYES );
    RfRenderSettings settings = settings_of( 8, "1" );
    RfTrial trial = trial_of( &s, 1, 2, &settings );
    assert_true( trial.relmse > 0.0 && rf_trial_phi( &trial ) < 1e-6 );
    end( &s );
}

#define MIDDLE 7
#define SEEDS 16 // frames 7 and 8 lie in no window at the ends

// Mean over the seeds of the middle frames of the path, from differences of two renders.
typedef struct Truth
{
    double relmse, f1, phi;
} Truth;

// Of a pixel of a frame.
static double weight_of( const RfTestRegion* site, int frame, int pixel )
{
    const RfTestPieces* pieces = &site->pieces;
    int x = pixel % WIDTH, y = pixel / WIDTH, cells = pieces->across * pieces->down;
    int32_t slot = pieces->slot[frame * cells + y / RF_CELL_SIDE * pieces->across + x / RF_CELL_SIDE], in_cell[RF_CELL_PIXELS];
    int count = rf_cell_pixels( pieces, y / RF_CELL_SIDE * pieces->across + x / RF_CELL_SIDE, in_cell ), k = 0;
    while ( k < count && in_cell[k] != pixel )
        ++k;
    return (double)site->weight[RF_CELL_PIXELS * slot + k];
}

static Truth render_truth( const Setup* s, const RfRenderSettings* settings )
{
    static const int frames[2] = { MIDDLE, MIDDLE + 1 };
    size_t floats = 3 * WIDTH * HEIGHT;
    double relative = 0.0, square = 0.0, step = 0.0;
    for ( int k = 0; k < SEEDS; ++k )
    {
        RfRenderSettings a = *settings, b = *settings;
        a.seed = (uint64_t)( 100 + 2 * k );
        b.seed = (uint64_t)( 101 + 2 * k );
        AUTO_BY( free_rendered ) Rendered x = render_frames( s->tracer, s->site.eyes, EYES, frames, 2, &a );
        AUTO_BY( free_rendered ) Rendered y = render_frames( s->tracer, s->site.eyes, EYES, frames, 2, &b );
        for ( size_t i = 0; i < floats; ++i )
        {
            double d0 = (double)x.rgb[i] - (double)y.rgb[i], d1 = (double)x.rgb[floats + i] - (double)y.rgb[floats + i];
            double w0 = weight_of( &s->site, MIDDLE, (int)( i / 3 ) ), w1 = weight_of( &s->site, MIDDLE + 1, (int)( i / 3 ) );
            relative += 0.5 * d0 * d0 * w0;
            square += 0.25 * ( d0 * d0 * w0 + d1 * d1 * w1 );
            step += ( d1 - d0 ) * ( d1 - d0 ) / ( 1.0 / w0 + 1.0 / w1 );
        }
    }
    double count = (double)floats * SEEDS;
    return ( Truth ){ relative / count * 3.0, sqrt( step / count ), step / ( 2.0 * square ) };
}

// One window's figures against those of the path's windows together.
static void check_long_path( int group, const char* tile, int passes )
{
    Setup s;
    begin( &s, 2.0f, MIDDLE, EYES );
    RfRenderSettings settings = settings_of( group, tile );
    RfTrial sum = { 0 };
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = (uint64_t)k;
        RfTrial trial = trial_of( &s, 1, passes, &settings );
        rf_add_trial( &sum, &trial );
    }
    settings.spp = passes * ( 2 * group + 1 );
    Truth truth = render_truth( &s, &settings );
    printf( "group %d tile %s: relMSE %.5f of %.5f, F1 %.5f of %.5f, phi %.3f of %.3f\n", group, tile,
            rf_trial_relmse( &sum, settings.spp ), truth.relmse, rf_trial_f1( &sum, settings.spp ), truth.f1,
            rf_trial_phi( &sum ), truth.phi );
    expect_near( "relMSE", rf_trial_relmse( &sum, settings.spp ), truth.relmse, 0.15 );
    expect_near( "F1", rf_trial_f1( &sum, settings.spp ), truth.f1, 0.1 );
    expect_near( "phi", rf_trial_phi( &sum ), truth.phi, 0.1 );
    end( &s );
}

TEST( test_long_path_has_the_predicted_error )
{
    check_long_path( 0, "1", 4 );
    check_long_path( 0, "1", 16 );
    check_long_path( 1, "1", 4 );
    check_long_path( 2, "2x2", 4 );
    check_long_path( 3, "3x3", 4 );
}

static bool refuse( void* user )
{
    *(int*)user += 1;
    return false;
}

TEST( test_wrong_settings_are_refused )
{
    Setup s;
    RfTrial trial;
    RfError error;
    begin( &s, 1.0f, 7, 5 );
    RfRenderSettings settings = settings_of( 3, "1" );
    assert_int_equal( rf_run_trial( &s.site, 1, 4, &settings, &trial, &error ), RF_ERROR_USAGE );
    settings.group = RF_GROUP_AUTO;
    assert_int_equal( rf_run_trial( &s.site, 1, 4, &settings, &trial, &error ), RF_ERROR_USAGE );
    settings.group = 2;
    assert_int_equal( rf_run_trial( &s.site, 1, 1, &settings, &trial, &error ), RF_ERROR_USAGE );
    settings.memory = 1000;
    assert_int_equal( rf_run_trial( &s.site, 1, 2, &settings, &trial, &error ), RF_ERROR_MEMORY );
    settings.memory = (size_t)64 << 20;
    int calls = 0;
    RfTrialWatch watch = { refuse, &calls };
    s.site.watch = &watch;
    assert_int_equal( rf_run_trial( &s.site, 1, 2, &settings, &trial, &error ), RF_ERROR_INTERRUPTED );
    assert_int_equal( calls, 1 );
    AUTO_BY( rf_destroy_test_region ) RfTestRegion region;
    RfTestSite site = { 7, 5, WIDTH * HEIGHT };
    assert_int_equal( rf_create_test_region( &s.site.shot, &watch, &site, &settings, &region, &error ), RF_ERROR_INTERRUPTED );
    end( &s );
}
