// The plan: what it says of a render is what the render does, and --group auto
// takes the row that it marks.
#include "cli_run.h"
#include "render_support.h"
#include "reuse/group.h"
#include "reuse/plan.h"
#include "scene_builder.h"

#include <jansson.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MOST_EYES 70
#define WIDTH 32
#define HEIGHT 24

typedef struct Setup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[MOST_EYES];
    int frames[MOST_EYES];
} Setup;

static void begin( Setup* s, RoomKind kind, float degrees )
{
    s->scene = make_room( kind );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, MOST_EYES, degrees, WIDTH, HEIGHT );
    for ( int i = 0; i < MOST_EYES; ++i )
        s->frames[i] = i;
}

static void end( Setup* s )
{
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

static RfRenderSettings settings_of( int spp )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.spp = spp;
    settings.memory = (size_t)256 << 20;
    settings.threads = 2;
    return settings;
}

static RfPlan plan_of( const Setup* s, int eyes, const RfRenderSettings* settings )
{
    RfPlan plan;
    RfError error = { 0 };
    if ( rf_plan_render( s->tracer, s->eyes, eyes, s->frames, eyes, settings, &plan, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return plan;
}

// A path ends the table with the group that holds all of it.
static void test_rows( void** state )
{
    (void)state;
    static const int paths[][3] = { { 1, 1, 1 }, { 2, 2, 2 }, { 3, 2, 3 }, { 5, 3, 5 }, { 6, 4, 6 }, { 9, 5, 9 }, { 48, 9, 33 } };
    static const int groups[] = { 0, 1, 2, 3, 4, 6, 8, 12, 16 };
    Setup s;
    begin( &s, ROOM_DIFFUSE, 1.0f );
    RfRenderSettings settings = settings_of( 28 );
    for ( int i = 0; i < 7; ++i )
    {
        RfPlan plan = plan_of( &s, paths[i][0], &settings );
        assert_int_equal( plan.count, paths[i][1] );
        int chosen = 0;
        for ( int r = 0; r < plan.count; ++r )
        {
            RfGroupPlan expected = rf_plan_groups( paths[i][0], groups[r], 28 );
            assert_int_equal( plan.rows[r].eyes, expected.eyes );
            assert_int_equal( plan.rows[r].group, expected.eyes / 2 );
            assert_int_equal( plan.rows[r].spp, expected.spp );
            chosen += plan.rows[r].chosen;
        }
        assert_int_equal( plan.rows[plan.count - 1].eyes, paths[i][2] );
        assert_int_equal( chosen, 1 );
        assert_true( plan.rows[plan.chosen].chosen && plan.why[0] != 0 );
        assert_true( fabs( plan.rows[0].reach - 1.0 ) < 1e-6 && fabs( plan.rows[0].gain - 1.0 ) < 1e-6 );
    }
    end( &s );
}

// Eyes that are all the same see all of each other's hits: then it is (FR 16).
static void test_formula( void** state )
{
    (void)state;
    Setup s;
    RfError error;
    begin( &s, ROOM_DIFFUSE, 0.0f );
    RfRenderSettings settings = settings_of( 17 );
    RfPlan plan = plan_of( &s, 17, &settings );
    for ( int r = 0; r < plan.count; ++r )
    {
        assert_true( fabs( plan.rows[r].reach - plan.rows[r].eyes ) < 0.01 * plan.rows[r].eyes );
        assert_true( isnan( plan.rows[r].measured_gain ) );
    }
    assert_int_equal( rf_measure_plan( s.tracer, s.eyes, 17, &settings, 0.05, &plan, &error ), RF_OK );
    assert_true( plan.c_e > 0.0 && plan.c_l > 0.0 && plan.c_v > 0.0 );
    const RfPlanRow* whole = plan.rows + plan.count - 1; // one window, without ends
    double own = plan.c_e + plan.c_l, formula = 17.0 * own / ( own + 16.0 * plan.c_v );
    assert_true( fabs( whole->measured_gain - formula ) < 0.02 * formula );
    double seconds = whole->rays_primary * ( own + 16.0 * plan.c_v ) / whole->fit.threads;
    assert_true( fabs( whole->seconds - seconds ) < 1e-6 * seconds );
    end( &s );
}

static void expect_near( const char* what, int group, double planned, uint64_t counted )
{
    if ( !( fabs( planned - (double)counted ) <= 0.1 * (double)counted ) )
        fail_msg( "group %d: %s rays: planned %.0f, traced %.0f", group, what, planned, (double)counted );
}

// Rays, bytes, threads and chunks of every row are those of a render of it.
static void test_forecast( void** state )
{
    (void)state;
    Setup s;
    begin( &s, ROOM_GGX, 2.0f );
    RfRenderSettings settings = settings_of( 5 );
    RfPlan plan = plan_of( &s, 12, &settings );
    for ( int r = 0; r < plan.count; ++r )
    {
        const RfPlanRow* row = plan.rows + r;
        settings.group = row->group;
        Rendered done = render_all( s.tracer, s.eyes, 12, &settings );
        const RfRayCounts* rays = &done.stats.rays;
        assert_true( row->rays_primary == (double)rays->primary );
        expect_near( "path", row->group, row->rays_path, rays->path );
        expect_near( "shadow", row->group, row->rays_shadow, rays->shadow );
        expect_near( "tile", row->group, row->rays_tile, rays->tile );
        if ( row->group > 0 )
            expect_near( "eye", row->group, row->rays_eye, rays->eye );
        assert_memory_equal( &row->fit, &done.stats.fit, sizeof row->fit );
        size_t bytes = row->fit.bytes_films + row->fit.bytes_hits + row->fit.bytes_lists;
        assert_true( done.stats.peak_bytes >= bytes && done.stats.peak_bytes < bytes + 1024 );
        free_rendered( &done );
    }
    end( &s );
}

// Only films and the samples asked for keep auto from the best row.
static void test_choice( void** state )
{
    (void)state;
    Setup s;
    begin( &s, ROOM_DIFFUSE, 0.2f );
    RfRenderSettings settings = settings_of( 34 );
    RfPlan plan = plan_of( &s, MOST_EYES, &settings );
    double best = 0.0;
    for ( int r = 0; r < plan.count; ++r )
        best = plan.rows[r].excluded == NULL ? fmax( best, plan.rows[r].gain ) : best;
    for ( int r = 0; r < plan.chosen; ++r )
        assert_true( plan.rows[r].excluded != NULL || plan.rows[r].gain < 0.9 * best );
    assert_true( plan.rows[plan.chosen].gain >= 0.9 * best && plan.rows[plan.chosen].group > 2 );
    // what has no part in it
    int group = plan.rows[plan.chosen].group;
    settings.seed = 77;
    settings.threads = 13;
    settings.memory = (size_t)900 << 20;
    RfRenderSettings used;
    RfError error;
    for ( int k = 0; k < 2; ++k )
    {
        assert_int_equal( rf_resolve_settings( s.tracer, s.eyes, MOST_EYES, &settings, &used, &error ), RF_OK );
        assert_int_equal( used.group, group );
        settings.group = RF_GROUP_AUTO;
    }
    Rendered one = render_frames( s.tracer, s.eyes, MOST_EYES, &( int ){ 40 }, 1, &settings );
    assert_int_equal( one.stats.group, group );
    free_rendered( &one );
    // a single sample is not to become many
    settings = settings_of( 1 );
    plan = plan_of( &s, MOST_EYES, &settings );
    assert_int_equal( plan.rows[plan.chosen].group, 0 );
    assert_non_null( strstr( plan.why, "rounded up" ) );
    end( &s );
}

static void test_choice_by_memory( void** state )
{
    (void)state;
    Setup s;
    begin( &s, ROOM_DIFFUSE, 0.2f );
    RfRenderSettings settings = settings_of( 34 );
    size_t film = (size_t)WIDTH * HEIGHT * 32;
    int last = 99, first = -1;
    for ( size_t films = 60; films > 0; films /= 2 )
    {
        RfMemoryFit fit;
        RfError error;
        settings.group = 0;
        settings.memory = (size_t)1 << 30;
        assert_int_equal( rf_fit_memory( &s.scene, s.eyes, MOST_EYES, MOST_EYES, &settings, &fit, &error ), RF_OK );
        settings.memory = fit.least + films * film;
        RfPlan plan = plan_of( &s, MOST_EYES, &settings );
        int group = plan.rows[plan.chosen].group;
        assert_true( group <= last );
        last = group;
        first = first < 0 ? group : first;
        settings.group = RF_GROUP_AUTO;
        Rendered one = render_frames( s.tracer, s.eyes, MOST_EYES, &( int ){ 0 }, 1, &settings );
        assert_true( one.stats.group == group && one.stats.peak_bytes <= settings.memory );
        free_rendered( &one );
    }
    assert_true( first > last );
    settings.memory = 1000;
    RfPlan plan;
    RfError error;
    assert_int_equal( rf_plan_render( s.tracer, s.eyes, MOST_EYES, s.frames, 1, &settings, &plan, &error ), RF_ERROR_MEMORY );
    assert_non_null( strstr( error.text, "give --memory " ) );
    end( &s );
}

static json_t* read_json( const char* name )
{
    size_t size;
    char* text = cli_read( name, &size );
    json_t* json = json_loads( text, 0, NULL );
    free( text );
    assert_non_null( json );
    return json;
}

static const json_t* chosen_row( const json_t* plan )
{
    const json_t *rows = json_object_get( plan, "rows" ), *chosen = NULL;
    for ( size_t i = 0; i < json_array_size( rows ); ++i )
    {
        const json_t* row = json_array_get( rows, i );
        if ( json_is_true( json_object_get( row, "chosen" ) ) )
        {
            assert_null( chosen );
            chosen = row;
        }
    }
    assert_non_null( chosen );
    return chosen;
}

static void test_command( void** state )
{
    (void)state;
    static const char options[] = "--size 64x36 --spp 9 --memory 40M";
    cli_expect( cli_run( "$R plan $VASE %s --quiet --json plan.json", options ), 0, NULL );
    const CliResult* said = cli_run( "$R plan $VASE %s --quiet", options );
    assert_int_equal( said->status, 0 );
    assert_true( said->err[0] == 0 && strstr( said->out, "\n* --group auto takes " ) != NULL );
    cli_expect( cli_run( "$R render $VASE %s -o a.exr --frames 20 --quiet --json render.json", options ), 0, NULL );
    json_t *plan = read_json( "plan.json" ), *render = read_json( "render.json" );
    const json_t* row = chosen_row( plan );
    assert_int_equal( json_integer_value( json_object_get( row, "group" ) ), json_integer_value( json_object_get( render, "group" ) ) );
    assert_true( json_integer_value( json_object_get( row, "bytes_hits" ) ) > 0 );
    assert_true( json_number_value( json_object_get( row, "predicted_gain" ) ) > 1.0 );
    // records: under a quarter of what the paper's example takes
    const json_t* paper = json_object_get( plan, "bytes_paper_example" );
    assert_true( json_number_value( json_object_get( paper, "theirs" ) ) == 1787520000.0 );
    assert_true( 4.0 * json_number_value( json_object_get( paper, "ours" ) ) < 1787520000.0 );
    assert_true( json_integer_value( json_object_get( json_object_get( plan, "bytes_record" ), "diffuse" ) ) <= 56 );
    json_decref( plan );
    json_decref( render );
}

static void test_command_defaults_and_errors( void** state )
{
    (void)state;
    char text[512];
    snprintf( text, sizeof text, "{\"scene\":\"%s\",\"render\":{\"size\":[40,30],\"spp\":5,\"tile\":\"1\",\"frames\":\"2-3\",\"group\":1}}",
              REFRAME_VASE_ROOM );
    cli_write( "scene.json", text, strlen( text ) );
    cli_expect( cli_run( "$R plan scene.json --quiet --json plan.json" ), 0, NULL );
    json_t* plan = read_json( "plan.json" );
    const json_t* first = json_array_get( json_object_get( plan, "rows" ), 0 );
    assert_string_equal( json_string_value( json_object_get( first, "tile" ) ), "1" );
    assert_int_equal( json_integer_value( json_object_get( first, "spp" ) ), 5 );
    assert_true( json_number_value( json_object_get( json_object_get( first, "rays" ), "primary" ) ) == 2 * 40 * 30 * 5 );
    json_decref( plan );
    cli_expect( cli_run( "$R plan scene.json --quiet --spp 6 --json - > plan.json" ), 0, NULL );
    plan = read_json( "plan.json" );
    assert_int_equal( json_integer_value( json_object_get( json_array_get( json_object_get( plan, "rows" ), 0 ), "spp" ) ), 6 );
    json_decref( plan );
    cli_expect( cli_run( "$R plan" ), 2, "reframe plan: " );
    cli_expect( cli_run( "$R plan scene.json --group 3" ), 2, "reframe plan: --group" );
    cli_expect( cli_run( "$R plan scene.json --frames 99" ), 2, "reframe plan: --frames: there is no frame 99" );
    cli_expect( cli_run( "$R plan scene.json --tile 99x99" ), 2, "reframe plan: --tile: wants" );
    cli_expect( cli_run( "$R plan scene.json --memory 1M" ), 1, "give --memory " );
    cli_expect( cli_run( "$R plan nowhere.glb" ), 1, "reframe plan: nowhere.glb: " );
    cli_expect( cli_run( "$R plan --help > /dev/null" ), 0, NULL );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_rows ),
        cmocka_unit_test( test_formula ),
        cmocka_unit_test( test_forecast ),
        cmocka_unit_test( test_choice ),
        cmocka_unit_test( test_choice_by_memory ),
        cmocka_unit_test( test_command ),
        cmocka_unit_test( test_command_defaults_and_errors ),
    };
    return cmocka_run_group_tests( tests, cli_enter_group, cli_leave_group );
}
