// What the plan says about a render is what the render does, and --group auto and --tile auto take the
// row it marks.
#include "support/render_support.h"
#include "render/groups.h"
#include "reframe/plan.h"
#include "support/scene_builder.h"
#include "support/test.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    settings.filter = RF_FILTER_BOX;
    settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    settings.spp = spp;
    settings.memory = (size_t)256 << 20;
    settings.threads = 2;
    return settings;
}

static RfPlan plan_of( const Setup* s, int eyes, const RfRenderSettings* settings )
{
    RfPlan plan;
    RfError error = { 0 };
    if ( rf_plan_render( &( RfShot ){ s->tracer, s->eyes, eyes, s->frames, eyes }, settings, &plan, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return plan;
}

// A path ends the table with the group that holds all of it.
TEST( test_table_ends_with_the_whole_path )
{
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

// Eyes that are all the same see all of each other's hits: then it is FR (16).
// Nothing is lost where all frames see the same.
TEST( test_equal_eyes_reach_all_frames )
{
    Setup s;
    begin( &s, ROOM_DIFFUSE, 0.0f );
    RfRenderSettings settings = settings_of( 17 );
    RfPlan plan = plan_of( &s, 17, &settings );
    for ( int r = 0; r < plan.count; ++r )
        assert_true( fabs( plan.rows[r].reach - plan.rows[r].eyes ) < 0.01 * plan.rows[r].eyes );
    end( &s );
}

static void expect_near( const char* what, int group, double planned, uint64_t counted )
{
    if ( !( fabs( planned - (double)counted ) <= 0.1 * (double)counted ) )
        fail_msg( "group %d: %s rays: planned %.0f, traced %.0f", group, what, planned, (double)counted );
}

static void check_forecast( const RfTile tile )
{
    Setup s;
    begin( &s, ROOM_GGX, 2.0f );
    RfRenderSettings settings = settings_of( 5 );
    settings.adaptive = RF_ADAPTIVE_OFF; // its rays are not predicted
    settings.tile = tile;
    RfPlan plan = plan_of( &s, 12, &settings );
    for ( int r = 0; r < plan.count; ++r )
    {
        const RfPlanRow* row = plan.rows + r;
        settings.group = row->group;
        settings.tile = row->tile;
        assert_true( row->tile.kind != RF_TILE_AUTO );
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
        if ( !( done.stats.peak_bytes >= bytes && done.stats.peak_bytes < bytes + 1024 ) )
            fail_msg( "group %d: %zu bytes planned, %zu used", row->group, bytes, done.stats.peak_bytes );
        free_rendered( &done );
    }
    end( &s );
}

// Rays, bytes, threads and chunks of every row are those of a render of it.
TEST( test_forecast_is_what_render_does )
{
    check_forecast( ( RfTile ){ RF_TILE_BLOCK, 3, 3 } );
    check_forecast( ( RfTile ){ RF_TILE_AUTO, 1, 1 } );
}

// (E29): what paths in large tiles tell of a smaller one is what its own tell.
TEST( test_variance_in_tiles_is_as_predicted )
{
    static const float turns[] = { 0.0f, 1.0f, 20.0f };
    for ( int k = 0; k < 3; ++k )
    {
        Setup s;
        begin( &s, ROOM_DIFFUSE, turns[k] );
        RfRenderSettings settings = settings_of( 16 );
        settings.tile.kind = RF_TILE_AUTO;
        RfPlan chosen = plan_of( &s, 4, &settings );
        settings.tile = chosen.rows[0].tile;
        assert_true( settings.tile.kind == RF_TILE_BLOCK && settings.tile.width < 8 );
        RfPlan own = plan_of( &s, 4, &settings );
        double predicted = chosen.rows[0].error, measured = own.rows[0].error;
        if ( !( fabs( predicted / measured - 1.0 ) < 0.1 ) )
            fail_msg( "tile %d: predicted %.4f, measured %.4f", settings.tile.width, predicted, measured );
        end( &s );
    }
}

// Paths of two vertices share nothing in tiles, which have a light sample more at first hits.
TEST( test_no_tile_without_indirect_light )
{
    Setup s;
    begin( &s, ROOM_DIFFUSE, 1.0f );
    RfRenderSettings settings = settings_of( 16 ), used;
    settings.tile.kind = RF_TILE_AUTO;
    settings.max_depth = 2;
    settings.light_samples = 2;
    RfPlan plan = plan_of( &s, 8, &settings );
    for ( int r = 0; r < plan.count; ++r )
        assert_int_equal( plan.rows[r].tile.kind, RF_TILE_NONE );
    // a group that is asked for, and an estimator without a choice, take a tile as well
    settings.max_depth = RF_MAX_DEPTH;
    settings.group = 2;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s.tracer, s.eyes, 8, NULL, 0 }, &settings, &used, NULL ), RF_OK );
    plan = plan_of( &s, 8, &settings );
    assert_true( used.group == 2 && plan.rows[2].group == 2 && used.tile.width == plan.rows[2].tile.width &&
                 used.tile.width > 1 );
    settings.estimator = rf_find_estimator( "gradient" );
    settings.group = 0;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s.tracer, s.eyes, 8, NULL, 0 }, &settings, &used, NULL ), RF_OK );
    assert_true( used.tile.kind == RF_TILE_BLOCK && used.tile.width == 4 );
    end( &s );
}

// Only films and the samples asked for keep auto from the best row.
TEST( test_choice_is_the_best_row )
{
    Setup s;
    begin( &s, ROOM_DIFFUSE, 0.2f );
    RfRenderSettings settings = settings_of( 34 );
    RfPlan plan = plan_of( &s, MOST_EYES, &settings );
    double best = 0.0;
    for ( int r = 0; r < plan.count; ++r )
        best = plan.rows[r].excluded == NULL ? fmax( best, plan.rows[r].gain ) : best;
    for ( int r = 0; r < plan.chosen; ++r )
        assert_true( plan.rows[r].excluded != NULL || plan.rows[r].gain < 0.95 * best );
    assert_true( plan.rows[plan.chosen].gain >= 0.95 * best && plan.rows[plan.chosen].group > 2 );
    // what has no part in it
    int group = plan.rows[plan.chosen].group;
    settings.seed = 77;
    settings.threads = 13;
    settings.memory = (size_t)900 << 20;
    RfRenderSettings used;
    RfError error;
    for ( int k = 0; k < 2; ++k )
    {
        assert_int_equal( rf_resolve_settings( &( RfShot ){ s.tracer, s.eyes, MOST_EYES, NULL, 0 }, &settings, &used, &error ),
                          RF_OK );
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

TEST( test_choice_by_memory )
{
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
        RfShot shot = { s.tracer, s.eyes, MOST_EYES, NULL, MOST_EYES };
        assert_int_equal( rf_fit_memory( &shot, &settings, &fit, &error ), RF_OK );
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
    assert_int_equal( rf_plan_render( &( RfShot ){ s.tracer, s.eyes, MOST_EYES, s.frames, 1 }, &settings, &plan, &error ),
                      RF_ERROR_MEMORY );
    assert_true( error.remedy == RF_REMEDY_MEMORY && error.least_memory > settings.memory );
    end( &s );
}

// What does not fit stays in the table, with the budget that it wants.
TEST( test_rows_without_room_stay )
{
    Setup s;
    begin( &s, ROOM_GGX, 0.2f );
    RfRenderSettings settings = settings_of( 34 );
    settings.light_samples = 16;
    settings.max_depth = 2;
    settings.weights = RF_WEIGHTS_EQ15; // holds a whole pass of a group
    settings.memory = (size_t)1 << 40;
    RfPlan roomy = plan_of( &s, MOST_EYES, &settings );
    settings.memory = roomy.rows[3].fit.least;
    RfPlan plan = plan_of( &s, MOST_EYES, &settings );
    assert_int_equal( plan.count, roomy.count );
    for ( int r = 0; r < plan.count; ++r )
    {
        const RfPlanRow* row = plan.rows + r;
        assert_true( rf_plan_row_fits( row ) == ( r <= 3 ) && row->fit.least == roomy.rows[r].fit.least );
        if ( r <= 3 )
            continue;
        assert_true( row->fit.least > settings.memory && row->fit.bytes_films == 0 && isnan( row->gain ) &&
                     isnan( row->rays_path ) );
        assert_non_null( strstr( row->excluded, "does not fit in memory" ) );
    }
    assert_non_null( strstr( plan.why, "5 rows excluded: do not fit in memory" ) );
    end( &s );
}

// A group that auto chose goes without extra samples where they would mean several sweeps; one that was asked for does not.
static void check_resolved( const Setup* s, const RfRenderSettings* settings, const RfPlan* plan )
{
    RfRenderSettings asked = *settings, resolved;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s->tracer, s->eyes, MOST_EYES, NULL, 0 }, &asked, &resolved, NULL ),
                      RF_OK );
    assert_int_equal( resolved.group, plan->rows[plan->chosen].group );
    assert_int_equal( resolved.adaptive, RF_ADAPTIVE_OFF );
    assert_int_equal( plan->adaptive, RF_ADAPTIVE_OFF );
    assert_non_null( strstr( plan->why, "without extra samples" ) );
    asked.group = resolved.group;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s->tracer, s->eyes, MOST_EYES, NULL, 0 }, &asked, &resolved, NULL ),
                      RF_OK );
    assert_int_equal( resolved.adaptive, RF_ADAPTIVE_AUTO );
}

// Several sweeps trace all of it as often: auto does not take such a row, whatever the threads are.
TEST( test_rows_of_several_sweeps_are_not_chosen )
{
    Setup s;
    begin( &s, ROOM_GGX, 0.2f );
    RfRenderSettings settings = settings_of( 34 );
    settings.light_samples = 64;
    settings.max_depth = 2;
    settings.memory = (size_t)1 << 40;
    RfPlan roomy = plan_of( &s, MOST_EYES, &settings );
    size_t film = (size_t)WIDTH * HEIGHT * 32;
    settings.memory = roomy.rows[0].fit.least + 6 * film; // hits leave room for few films, which are far from half of it
    int chosen = -1;
    for ( int threads = 1; threads <= 16; threads *= 4 )
    {
        settings.threads = threads;
        RfPlan plan = plan_of( &s, MOST_EYES, &settings );
        const RfPlanRow *row = plan.rows + plan.chosen, *best = row;
        for ( int r = 0; r < plan.count; ++r )
            best = plan.rows[r].excluded == NULL && plan.rows[r].gain > best->gain ? plan.rows + r : best;
        int swept = 0;
        for ( int r = 0; r < plan.count; ++r )
            swept += plan.rows[r].excluded != NULL && strstr( plan.rows[r].excluded, "needs several sweeps" ) != NULL;
        assert_true( swept > 0 && strstr( plan.why, " several sweeps" ) != NULL );
        // the gain that the reason names is that of the best row that is left
        char gain[64];
        snprintf( gain, sizeof gain, "at fixed ray costs, %.1f with group %d", best->gain, best->group );
        assert_non_null( strstr( plan.why, gain ) );
        assert_true( threads > 1 || row->fit.sweeps == 1 );
        check_resolved( &s, &settings, &plan );
        assert_true( chosen < 0 || chosen == row->group );
        chosen = row->group;
    }
    assert_true( chosen > 0 && chosen < roomy.rows[roomy.chosen].group );
    end( &s );
}

// Samples that a frame traces in groups of 2n+1 of which each has a single pass, on average over the path.
static double all_samples_each( int group )
{
    RfGroupPlan plan = rf_plan_groups( MOST_EYES, group, 17 );
    double samples = 0.0;
    for ( int g = 0; g < plan.groups; ++g )
        samples += (double)rf_group( &plan, g ).passes * rf_group( &plan, g ).eyes;
    return samples / MOST_EYES;
}

static RfHalo halo_of( const Setup* s, int first, int count, int group, double least )
{
    RfHalo halo;
    RfError error = { 0 };
    RfRenderSettings settings = settings_of( 17 );
    settings.group = group;
    if ( rf_plan_halo( &( RfShot ){ s->tracer, s->eyes, MOST_EYES, s->frames + first, count }, &settings, least, &halo,
                       &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return halo;
}

TEST( test_halo_of_short_ranges )
{
    Setup s;
    begin( &s, ROOM_DIFFUSE, 0.0f );
    RfHalo all = halo_of( &s, 0, MOST_EYES, 8, 0.0 ), alone = halo_of( &s, 0, MOST_EYES, 0, 0.0 );
    assert_true( all.share < 1e-9 && all.group == 8 && alone.share < 1e-9 && alone.group == 0 );
    // by samples alone: one frame takes 17 groups of 17, ten take 26
    assert_true( fabs( halo_of( &s, 30, 1, 8, 0.99 ).share - ( 1.0 - all_samples_each( 8 ) / ( 17.0 * 17.0 ) ) ) < 1e-9 );
    assert_true( fabs( halo_of( &s, 30, 10, 8, 0.99 ).share - ( 1.0 - 10.0 * all_samples_each( 8 ) / ( 26.0 * 17.0 ) ) ) < 1e-9 );
    // reuse costs where frames are wanted; equal cameras make up for all of it
    RfHalo one = halo_of( &s, 30, 1, 8, 0.0 ), ten = halo_of( &s, 30, 10, 8, 0.0 ), many = halo_of( &s, 20, 20, 8, 0.0 );
    assert_true( one.share > ten.share && ten.share > many.share && many.share > 0.1 );
    assert_true( ten.share < halo_of( &s, 30, 10, 8, 0.99 ).share && one.group == 8 && one.saved == 0.0 );
    end( &s );
    // cameras that look elsewhere do not
    begin( &s, ROOM_DIFFUSE, 20.0f );
    one = halo_of( &s, 30, 1, 8, 0.0 );
    assert_true( one.group < 4 && one.saved > 0.3 && one.saved < 1.0 );
    end( &s );
}
