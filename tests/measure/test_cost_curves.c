// reframe cost: points of both curves, predictions by hand and by a render, and what the
// command prints.
#include "support/cli_run.h"
#include "measure/cost.h"
#include "support/render_support.h"
#include "render/groups.h"
#include "support/scene_builder.h"
#include "support/test.h"
#include "reuse/tile/tile.h"

#include <jansson.h>

#define MOST_EYES 30
#define WIDTH 16
#define HEIGHT 12

typedef struct Setup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[MOST_EYES];
    int frames[MOST_EYES];
    RfRenderSettings settings;
    RfCostJob job;
} Setup;

static void begin( Setup* s, int eyes, int group )
{
    s->scene = make_room( ROOM_DIFFUSE );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, MOST_EYES, 1.0f, WIDTH, HEIGHT );
    for ( int i = 0; i < MOST_EYES; ++i )
        s->frames[i] = i;
    s->settings = rf_default_render_settings();
    s->settings.filter = RF_FILTER_BOX;
    s->settings.group = group;
    s->settings.memory = (size_t)256 << 20;
    s->settings.threads = 2;
    s->job = ( RfCostJob ){ .shot = { s->tracer, s->eyes, eyes, s->frames, eyes }, .settings = &s->settings, .budget = 1.0 };
}

static void end( Setup* s )
{
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

static void check_curve( const RfCostCurve* c )
{
    assert_true( c->count >= 1 && c->count <= RF_COST_LEVELS );
    for ( int i = 0; i < c->count; ++i )
    {
        assert_true( i == 0 ? c->rows[i].spp == 2 : c->rows[i].spp > c->rows[i - 1].spp );
        assert_true( c->rows[i].relmse > 0.0 && c->rows[i].seconds > 0.0 && c->rows[i].cpu_seconds > 0.0 );
    }
    // 64 times the samples, and more: no luck makes up for that
    for ( int i = 1; i < c->count; ++i )
        assert_true( c->rows[i].spp < 128 || c->rows[i].relmse < 0.2 * c->rows[0].relmse );
    assert_true( c->line.error.value > 0.0 && c->line.exponent.low < c->line.exponent.high );
    assert_true( c->sample_seconds > 0.0 && c->finish_seconds >= 0.0 );
}

TEST( test_both_curves_are_rendered )
{
    Setup s;
    begin( &s, 12, 2 );
    RfCost cost;
    RfError error;
    assert_int_equal( rf_measure_cost( &s.job, &cost, &error ), RF_OK );
    check_curve( &cost.plain );
    check_curve( &cost.reuse );
    assert_int_equal( cost.plain.eyes, 1 );
    assert_int_equal( cost.reuse.eyes, 5 );
    assert_true( cost.pixels == WIDTH * HEIGHT ); // small pictures are tried as a whole
    RfInterval speedup = rf_cost_speedup( &s.job, &cost, 0.01, ( const int[2] ){ 12, 12 } );
    assert_true( speedup.low < speedup.value && speedup.value < speedup.high );
    // the same samples with five frames and tiles of nine have less error, by far
    assert_true( rf_line_error( &cost.reuse.line, 4.0 ).value < 0.5 * rf_line_error( &cost.plain.line, 4.0 ).value );
    end( &s );
}

// A path of one frame, and of two, which is one group.
TEST( test_short_paths_have_curves )
{
    for ( int eyes = 1; eyes <= 2; ++eyes )
    {
        Setup s;
        begin( &s, eyes, 4 );
        RfCost cost;
        RfError error;
        assert_int_equal( rf_measure_cost( &s.job, &cost, &error ), RF_OK );
        assert_int_equal( cost.reuse.eyes, eyes );
        assert_int_equal( cost.positions, eyes );
        check_curve( &cost.reuse );
        end( &s );
    }
}

TEST( test_nothing_to_compare )
{
    Setup s;
    begin( &s, 4, 0 );
    s.settings.tile = rf_no_tile();
    RfCost cost;
    RfError error;
    assert_int_equal( rf_measure_cost( &s.job, &cost, &error ), RF_ERROR_USAGE );
    end( &s );
}

static bool no_more( void* user )
{
    (void)user;
    return false;
}

TEST( test_interruption_returns_no_rows )
{
    Setup s;
    begin( &s, 8, 2 );
    RfTrialWatch watch = { no_more, NULL };
    s.job.watch = &watch;
    RfCost cost;
    RfError error;
    assert_int_equal( rf_measure_cost( &s.job, &cost, &error ), RF_ERROR_INTERRUPTED );
    assert_int_equal( cost.reuse.count, 0 );
    end( &s );
}

static void near( double value, double expected ) { assert_true( fabs( value / expected - 1.0 ) < 1e-12 ); }

// Of one sample such an error, that falls as the samples to the power of -1.
static RfErrorLine reciprocal( double error ) { return ( RfErrorLine ){ 1.0, { error, error, error }, { 1.0, 1.0, 1.0 } }; }

// By hand: error 0.7 of one sample, 0.07 wanted, 10 samples; a second for each
// sample of a pixel, 5 for finishing.
TEST( test_predictions_by_hand )
{
    Setup s;
    begin( &s, 20, 0 );
    RfCostCurve plain = { .group = 0, .eyes = 1, .line = reciprocal( 0.699 ), .sample_seconds = 1.0, .finish_seconds = 5.0 };
    RfCostPrediction p = rf_predict_cost( &s.job, &plain, 0.07, 20 );
    assert_int_equal( p.spp, 10 );
    near( p.frame_seconds, 10.0 * WIDTH * HEIGHT + 5.0 );
    near( p.seconds, 20.0 * p.frame_seconds );
    near( p.low, p.frame_seconds );
    near( p.high, p.frame_seconds );
    assert_int_equal( p.tried, 0 );
    // the error falls as samples^-2, known to a quarter: half the samples, to an eighth; 10 are over four times the 2 that were tried
    RfCostCurve steep = plain;
    steep.line = ( RfErrorLine ){ 2.0, { 1.5625, 1.0, 2.44140625 }, { 2.0, 2.0, 2.0 } };
    steep.count = 1;
    steep.rows[0].spp = 2;
    p = rf_predict_cost( &s.job, &steep, 0.0641, 20 );
    assert_true( p.spp == 10 && p.tried == 2 );
    near( p.low, 8.0 * WIDTH * HEIGHT + 5.0 );
    near( p.high, 13.0 * WIDTH * HEIGHT + 5.0 );
    // in the frames asked for a sample takes less
    steep.alone = 0.5;
    near( rf_predict_cost( &s.job, &steep, 0.0641, 20 ).seconds, 20.0 * ( 5.0 * WIDTH * HEIGHT + 5.0 ) );
    // groups of 3: whole passes of each of the 3 groups, 12 samples; the first and the last group have 12 passes
    RfCostCurve reuse = plain;
    reuse.group = 1;
    reuse.eyes = 3;
    p = rf_predict_cost( &s.job, &reuse, 0.07, 20 );
    assert_int_equal( p.spp, 12 );
    near( p.seconds, 3.0 * ( 16.0 * 4.0 + 2.0 * 12.0 ) * WIDTH * HEIGHT + 20.0 * 5.0 );
    // sweeps of one frame: as many times a frame alone
    double alone = 0.0;
    for ( int i = 0; i < 20; ++i )
    {
        RfCostJob one = s.job;
        one.shot.frames = s.frames + i;
        one.shot.frame_count = 1;
        alone += rf_predict_cost( &one, &reuse, 0.07, 1 ).seconds;
    }
    near( rf_predict_cost( &s.job, &reuse, 0.07, 1 ).seconds, alone );
    // two samples are the least, and there is a most
    assert_int_equal( rf_predict_cost( &s.job, &plain, 10.0, 20 ).spp, 2 );
    assert_int_equal( rf_predict_cost( &s.job, &plain, 1e-9, 20 ).spp, 0 );
    assert_true( isnan( rf_predict_cost( &s.job, &plain, 1e-9, 20 ).seconds ) );
    end( &s );
}

// By hand: the exact picture needs 70 samples. One clamp needs 20, but its bias is too large for less; one 40.
TEST( test_clamps_are_weighed_by_hand )
{
    Setup s;
    begin( &s, 20, 0 );
    RfCost cost = { .reuse = { .group = 0, .eyes = 1, .line = reciprocal( 6.99 ), .sample_seconds = 1.0 },
                    .clamps = { { 0.5, reciprocal( 0.999 ), 0.05, 0.1 }, { 2.0, reciprocal( 3.599 ), 0.01, 0.02 } },
                    .clamp_count = 2 };
    const RfCostClamp* clamp;
    RfCostPrediction p = rf_predict_clamped_cost( &s.job, &cost, 0.1, 20, &clamp );
    assert_true( p.spp == 20 && clamp == cost.clamps );
    near( p.seconds, 20.0 * 20.0 * WIDTH * HEIGHT );
    p = rf_predict_clamped_cost( &s.job, &cost, 0.04, 20, &clamp );
    assert_true( p.spp == 120 && clamp == cost.clamps + 1 );
    p = rf_predict_clamped_cost( &s.job, &cost, 0.011, 20, &clamp ); // 636 samples are fewer than 3599
    assert_true( clamp == NULL && p.spp == 636 );
    double relmse;
    assert_true( rf_best_clamp( &cost, 10.0, &relmse ) == cost.clamps );
    near( relmse, 0.1499 );
    assert_true( rf_best_clamp( &cost, 100.0, &relmse ) == cost.clamps + 1 );
    cost.clamps[0] = ( RfCostClamp ){ 8.0, reciprocal( 0.5 ), 0.0, 0.0 }; // takes out nothing, and seems better by chance
    assert_true( rf_best_clamp( &cost, 10.0, &relmse ) == cost.clamps + 1 );
    rf_predict_clamped_cost( &s.job, &cost, 0.1, 20, &clamp );
    assert_true( clamp == cost.clamps + 1 );
    cost.clamp_count = 0;
    assert_null( rf_best_clamp( &cost, 10.0, &relmse ) );
    end( &s );
}

// Both curves come from the same samples; the clamped one has less variance, and some of the light is missing.
TEST( test_clamps_are_tried )
{
    Setup s;
    begin( &s, 6, 1 );
    s.job.relmse = 0.01;
    RfCost cost;
    RfError error;
    assert_int_equal( rf_measure_cost( &s.job, &cost, &error ), RF_OK );
    check_curve( &cost.reuse );
    assert_true( cost.clamp_count >= 1 );
    for ( int i = 0; i < cost.clamp_count; ++i )
    {
        const RfCostClamp* c = cost.clamps + i;
        assert_true( c->threshold > 0.0 && c->missing >= 0.0 && c->missing < 0.5 && c->bias >= 3.0 * c->missing * c->missing );
        assert_true( c->line.error.value > 0.0 &&
                     rf_line_error( &c->line, 4.0 ).value < 1.5 * rf_line_error( &cost.reuse.line, 4.0 ).value );
    }
    s.settings.weights = RF_WEIGHTS_EQ15; // which have no clamp
    assert_int_equal( rf_measure_cost( &s.job, &cost, &error ), RF_OK );
    assert_int_equal( cost.clamp_count, 0 );
    end( &s );
}

TEST( test_command_says_what_json_says )
{
    cli_enter();
    cli_expect(
        cli_measure( "$R cost $VASE --size 40x30 --group 1 --tile 3x3 --noise 12.91%,0.5 --frames 5-9 --quiet --json c.json "
                     "--svg c.svg > c.txt",
                     4 ),
        0, NULL );
    size_t size;
    char* text = cli_read( "c.json", &size );
    json_error_t fault;
    json_auto_t* json = json_loadb( text, size, 0, &fault );
    assert_non_null( json );
    json_t* rows = json_object_get( json, "rows" );
    size_t count = json_array_size( rows );
    assert_true( count >= 2 );
    assert_true( json_is_false( json_object_get( json_array_get( rows, 0 ), "reuse" ) ) );
    assert_true( json_is_true( json_object_get( json_array_get( rows, count - 1 ), "reuse" ) ) );
    assert_int_equal( json_integer_value( json_object_get( json_array_get( rows, count - 1 ), "group" ) ), 1 );
    assert_true( json_real_value( json_object_get( json, "speedup_at_equal_error" ) ) > 0.0 );
    assert_true( json_real_value( json_object_get( json, "slope" ) ) < 0.0 );
    assert_true( json_real_value( json_object_get( json, "slope_plain_low" ) ) <
                 json_real_value( json_object_get( json, "slope_plain_high" ) ) );
    assert_true( json_real_value( json_object_get( json, "speedup_low" ) ) <
                 json_real_value( json_object_get( json, "speedup_high" ) ) );
    json_t *wanted = json_object_get( json, "wanted" ), *clamps = json_object_get( json, "clamps" );
    assert_true( json_array_size( clamps ) >= 1 );
    assert_true( json_number_value( json_object_get( json_array_get( clamps, 0 ), "clamp" ) ) > 0.0 );
    assert_non_null( json_object_get( json_array_get( wanted, 0 ), "clamped" ) ); // or null
    assert_int_equal( json_array_size( wanted ), 2 );
    json_t *dear = json_array_get( wanted, 0 ), *cheap = json_array_get( wanted, 1 );
    assert_true( json_integer_value( json_object_get( json_object_get( dear, "plain" ), "spp" ) ) >
                 json_integer_value( json_object_get( json_object_get( cheap, "plain" ), "spp" ) ) );
    AUTO_FREE char* table = cli_read( "c.txt", &size );
    cli_expect_verdict( table, json, "groups of 3 and 3x3 tiles, at " );
    free( text );
    text = cli_read( "c.svg", &size );
    assert_true( size > 500 && strstr( text, "<svg" ) != NULL && strstr( text, "group 1, tile 3x3" ) != NULL );
    free( text );
    text = cli_read( "c.txt", &size );
    assert_non_null( strstr( text, "13 % noise (relMSE 0.05):\n  exact " ) );
    assert_non_null( strstr( text, "\n  path tracing " ) );
    assert_non_null( strstr( text, " for all 5 (--spp " ) );
    bool sloped = strstr( text, "groups of 3 and 3x3 tiles: relMSE falls as samples^-" ) != NULL;
    assert_true( sloped || count < 4 ); // a busy machine may have one row of each
    free( text );
    cli_expect( cli_measure( "$R cost $VASE --size 8x6 --group 0 --noise 1e-9 --frames 5 --quiet > c.txt", 4 ), 0, NULL );
    text = cli_read( "c.txt", &size );
    assert_non_null( strstr( text, "(relMSE 1e-09): exact more than 1048576 spp, the limit\n" ) );
    free( text );
    cli_leave();
}

TEST( test_wrong_commands_are_refused )
{
    cli_enter();
    cli_expect( cli_run( "$R cost" ), 2, "SCENE" );
    cli_expect( cli_run( "$R cost $VASE --noise 0.1,x" ), 2, "--noise: expected numbers above 0" );
    cli_expect( cli_run( "$R cost $VASE --noise 0" ), 2, "--noise: expected numbers above 0" );
    cli_expect( cli_run( "$R cost $VASE --flicker 0.1,x" ), 2, "--flicker: expected numbers above 0" );
    cli_expect( cli_run( "$R cost $VASE --noise 0.1," ), 2, "--noise: expected numbers above 0" );
    cli_expect( cli_run( "$R cost $VASE --budget 0" ), 2, "--budget" );
    cli_expect( cli_run( "$R cost $VASE --group 0 --tile 1" ), 2, "path tracing" );
    cli_expect( cli_run( "$R cost missing.glb" ), 1, "missing.glb" );
    cli_expect( cli_run( "$R cost $VASE --size 8x6 --budget 4 --group 1 --quiet --svg no/such/c.svg > c.txt" ), 1, "no/such" );
    cli_leave();
}
