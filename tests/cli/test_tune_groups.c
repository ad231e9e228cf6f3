// reframe tune --budget 0: table of groups, JSON and errors; render --group auto takes the row it marks.
#include "reframe/render.h"
#include "support/cli_run.h"
#include "support/test.h"

#include <jansson.h>

static const json_t* chosen_row( const json_t* plan )
{
    const json_t *rows = json_object_get( plan, "groups" ), *chosen = NULL;
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

static bool is_null( const json_t* row, const char* key ) { return json_is_null( json_object_get( row, key ) ); }

// The keys of the contract.
static void check_rows( const json_t* plan )
{
    const json_t* rows = json_object_get( plan, "groups" );
    assert_int_equal( json_array_size( rows ), 9 );
    for ( size_t i = 0; i < 9; ++i )
    {
        const json_t* row = json_array_get( rows, i );
        RfTile tile;
        assert_true( rf_parse_tile( json_string_value( json_object_get( row, "tile" ) ), &tile ) && tile.kind != RF_TILE_AUTO );
        static const char* const whole[] = { "bytes_films", "bytes_hits", "bytes_lists", "bytes_least",
                                             "chunks",      "sweeps",     "eyes",        "spp" };
        for ( size_t k = 0; k < sizeof whole / sizeof whole[0]; ++k )
            assert_true( json_integer_value( json_object_get( row, whole[k] ) ) > 0 );
        assert_true( json_is_integer( json_object_get( row, "group" ) ) );
        static const char* const real[] = { "predicted_gain", "reach" };
        for ( size_t k = 0; k < sizeof real / sizeof real[0]; ++k )
            assert_true( json_number_value( json_object_get( row, real[k] ) ) > 0.0 );
        assert_true( json_is_boolean( json_object_get( row, "chosen" ) ) );
    }
    assert_true( json_number_value( json_object_get( chosen_row( plan ), "predicted_gain" ) ) > 1.0 );
    assert_true( is_null( chosen_row( plan ), "excluded" ) );
}

TEST( test_table_and_json_agree )
{
    static const char options[] = "--size 64x36 --spp 9 --memory 40M --filter box";
    cli_expect( cli_run( "$R tune $VASE --budget 0 %s --quiet --json tune.json", options ), 0, NULL );
    const CliResult* said = cli_run( "$R tune $VASE --budget 0 %s --quiet", options );
    assert_int_equal( said->status, 0 );
    assert_true( said->err[0] == 0 && strstr( said->out, "\n* --group auto and --tile auto: " ) != NULL );
    char line[1024], table[1024];
    snprintf( line, sizeof line, "%s", strstr( said->out, "\n* --group auto and --tile auto: " ) );
    snprintf( table, sizeof table, "%.1000s", said->out );
    cli_expect( cli_run( "$R render $VASE %s -o a.exr --frames 20 --quiet --json render.json", options ), 0, NULL );
    json_t *plan = cli_read_json( "tune.json" ), *render = cli_read_json( "render.json" );
    const json_t* row = chosen_row( plan );
    cli_expect_verdict( table, plan, "--group auto: groups of " );
    assert_non_null( strstr( table, "\n48 frames at 64x36 and " ) );
    // nothing is rendered
    assert_int_equal( json_array_size( json_object_get( plan, "rows" ) ), 0 );
    assert_true( is_null( plan, "command" ) );
    assert_int_equal( json_integer_value( json_object_get( row, "group" ) ),
                      json_integer_value( json_object_get( render, "group" ) ) );
    check_rows( plan );
    const char* why = json_string_value( json_object_get( plan, "why" ) );
    assert_non_null( strstr( why, "the smallest group within 5 % of the best gain at fixed ray costs, " ) );
    assert_non_null( strstr( line, why ) );
    assert_true( json_is_false( json_object_get( plan, "at_most" ) ) );
    assert_true( json_integer_value( json_object_get( json_object_get( plan, "bytes_record" ), "diffuse" ) ) <=
                 60 ); // in groups of 33
    json_decref( plan );
    json_decref( render );
}

// What layers of light cost is said before it is spent: films of each frame, and hits that keep more of their light apart.
TEST( test_split_light_is_priced )
{
    cli_expect( cli_run( "$R tune $VASE --budget 0 --size 64x36 --quiet --json tune.json" ), 0, NULL );
    json_t* plan = cli_read_json( "tune.json" );
    assert_true( is_null( plan, "split_light" ) );
    json_decref( plan );
    cli_expect(
        cli_run( "$R tune $VASE --budget 0 --size 64x36 --light-groups lamps --aov direct,indirect --quiet --json tune.json" ), 0,
        NULL );
    plan = cli_read_json( "tune.json" );
    const json_t* split = json_object_get( plan, "split_light" );
    json_int_t films = json_integer_value( json_object_get( split, "films" ) );
    assert_int_equal( films, 3 ); // one lamp, two passes
    assert_true( json_integer_value( json_object_get( split, "bytes_films" ) ) >= films * 64 * 36 * 40 );
    assert_true( json_integer_value( json_object_get( split, "bytes_hits" ) ) > 0 );
    assert_true( is_null( split, "time_share" ) );
    json_decref( plan );
    const CliResult* said = cli_run( "$R tune $VASE --budget 0 --size 64x36 --aov direct,indirect --quiet" );
    assert_int_equal( said->status, 0 );
    assert_non_null( strstr( said->out, "\nlight groups and passes: 2 films more of each frame, " ) );
    cli_expect( cli_run( "$R tune $VASE --budget 0 --light-groups ligt" ), 2, "did you mean 'light'?" );
}

// The group that plan marks and render takes with these options.
static int common_group( const char* options )
{
    cli_expect( cli_run( "$R tune $VASE --budget 0 %s --quiet --json tune.json", options ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE %s -o a.exr --frames 20 --overwrite --quiet --json render.json", options ), 0, NULL );
    json_t *plan = cli_read_json( "tune.json" ), *render = cli_read_json( "render.json" );
    int marked = (int)json_integer_value( json_object_get( chosen_row( plan ), "group" ) );
    int taken = (int)json_integer_value( json_object_get( render, "group" ) );
    json_decref( plan );
    json_decref( render );
    if ( marked != taken )
        fail_msg( "%s: plan marks group %d, render takes %d", options, marked, taken );
    return taken;
}

// Whatever a render takes of memory, plan knows of it: options that change the choice, and some that do not.
TEST( test_options_change_plan_as_render )
{
    static const struct
    {
        const char *plain, *options;
        bool felt;
    } cases[] = {
        { "--size 64x36 --tile 1 --memory 3200K", "--adaptive", true },
        { "--size 64x36 --tile 1 --memory 3200K", "--aov albedo,normal,depth,motion,variance,samples", true },
        { "--size 64x36 --tile 1 --memory 3200K", "--clamp 1 --aov removed", true },
        { "--size 64x36 --tile 1 --memory 2900K", "--noise 1000", true },
        { "--size 64x36 --tile 1 --memory 2900K", "--time 0.001", true },
        { "--size 64x36 --spp 9 --tile 3x3 --memory 12M", "--weights eq15", true },
        { "--size 64x36 --spp 9 --memory 12M", "--weights unweighted --normalize none --tile rooks16 --light-samples 2", false },
    };
    int plain = -1;
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        char options[288];
        if ( i == 0 || strcmp( cases[i].plain, cases[i - 1].plain ) != 0 )
        {
            snprintf( options, sizeof options, "%s --max-depth 3 --filter box", cases[i].plain );
            plain = common_group( options );
        }
        snprintf( options, sizeof options, "%s --max-depth 3 --filter box %s", cases[i].plain, cases[i].options );
        int group = common_group( options );
        assert_true( group != plain || !cases[i].felt );
    }
}

// Rows that do not fit say so, and what they would take.
TEST( test_rows_without_room )
{
    // of one frame, as it is rendered below: more frames wait in more buffers
    static const char options[] = "--size 64x36 --spp 9 --memory 12M --weights eq15 --max-depth 2 --frames 20 --quiet";
    cli_expect( cli_run( "$R tune $VASE --budget 0 %s --json tune.json > table.txt", options ), 0, NULL );
    json_auto_t* plan = cli_read_json( "tune.json" );
    const json_t* rows = json_object_get( plan, "groups" );
    assert_int_equal( json_array_size( rows ), 9 );
    const json_t* last = json_array_get( rows, 8 );
    const char* why = json_string_value( json_object_get( last, "excluded" ) );
    char expected[96];
    json_int_t least = json_integer_value( json_object_get( last, "bytes_least" ) );
    snprintf( expected, sizeof expected, "does not fit in memory, needs at least %dM", (int)( ( least + 1048575 ) / 1048576 ) );
    assert_string_equal( why, expected );
    assert_true( is_null( last, "predicted_gain" ) && is_null( json_object_get( last, "rays" ), "path" ) );
    size_t size;
    AUTO_FREE char* table = cli_read( "table.txt", &size );
    assert_non_null( strstr( table, expected ) );
    // that is the least indeed
    static const char big[] =
        "$R render $VASE --size 64x36 --spp 9 --weights eq15 --max-depth 1 --group 16 --frames 20 -o b.exr --quiet --memory %d";
    cli_expect( cli_run( big, (int)least - 1024 ), 1, "give --memory " );
    cli_expect( cli_run( big, (int)least ), 0, NULL );
}

TEST( test_command_defaults_and_errors )
{
    char text[512];
    snprintf( text, sizeof text,
              "{\"scene\":\"%s\",\"render\":{\"size\":[40,30],\"spp\":5,\"tile\":\"1\",\"frames\":\"2-3\",\"group\":1}}",
              REFRAME_VASE_ROOM );
    cli_write( "scene.json", text, strlen( text ) );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --quiet --json tune.json" ), 0, NULL );
    json_t* plan = cli_read_json( "tune.json" );
    const json_t* first = json_array_get( json_object_get( plan, "groups" ), 0 );
    assert_string_equal( json_string_value( json_object_get( first, "tile" ) ), "1" );
    assert_int_equal( json_integer_value( json_object_get( first, "spp" ) ), 5 );
    assert_true( json_number_value( json_object_get( json_object_get( first, "rays" ), "primary" ) ) == 2 * 40 * 30 * 5 );
    json_decref( plan );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --quiet --spp 6 --json - > tune.json" ), 0, NULL );
    plan = cli_read_json( "tune.json" );
    assert_int_equal( json_integer_value( json_object_get( json_array_get( json_object_get( plan, "groups" ), 0 ), "spp" ) ), 6 );
    json_decref( plan );
    // as many as render may take, which is said
    static const struct
    {
        const char* options;
        int spp;
    } most[] = { { "--time 1", 1048576 }, { "--noise 1 --spp 9", 9 } };
    for ( int i = 0; i < 2; ++i )
    {
        cli_expect( cli_run( "$R tune scene.json --budget 0 --quiet %s --json tune.json", most[i].options ), 0, NULL );
        plan = cli_read_json( "tune.json" );
        assert_int_equal( json_integer_value( json_object_get( json_array_get( json_object_get( plan, "groups" ), 0 ), "spp" ) ),
                          most[i].spp );
        assert_true( json_is_true( json_object_get( plan, "at_most" ) ) );
        json_decref( plan );
    }
    cli_expect( cli_run( "$R plan scene.json" ), 2, "'plan': no such command, did you mean tune?" );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --group 3" ), 2, "reframe tune: --group" );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --adaptive --weights eq15" ), 2,
                "reframe tune: --adaptive: needs --weights exact" );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --weights eq16" ), 2, "reframe tune: --weights: expected" );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --frames 99" ), 2, "reframe tune: --frames: there is no frame 99" );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --tile 99x99" ), 2, "reframe tune: --tile: expected" );
    cli_expect( cli_run( "$R tune scene.json --budget 0 --memory 1M" ), 1, "give --memory " );
}

static const char* range_of( const json_t* nodes, size_t i )
{
    return json_string_value( json_object_get( json_array_get( json_object_get( nodes, "ranges" ), i ), "frames" ) );
}

TEST( test_ranges_for_several_machines )
{
    const CliResult* done =
        cli_run( "$R tune $VASE --budget 0 --size 16x9 --spp 6 --frames 1-12 --nodes 3 --group 1 --quiet --json nodes.json" );
    cli_expect( done, 0, NULL );
    assert_non_null( strstr( done->out, "3 ranges for --nodes 3, group 1" ) );
    assert_non_null( strstr( done->out, "overhead of the halos" ) );
    json_auto_t* json = cli_read_json( "nodes.json" );
    const json_t* nodes = json_object_get( json, "nodes" );
    assert_int_equal( json_integer_value( json_object_get( nodes, "group" ) ), 1 );
    assert_int_equal( json_array_size( json_object_get( nodes, "ranges" ) ), 3 );
    assert_string_equal( range_of( nodes, 0 ), "1-4" );
    assert_string_equal( range_of( nodes, 2 ), "9-12" );
    assert_true( json_real_value( json_object_get( nodes, "overhead" ) ) > 0.2 );
    cli_expect( cli_run( "$R tune $VASE --budget 0 --group 2" ), 2, "--group: needs --nodes" );
    cli_expect( cli_run( "$R render $VASE -o x/f.####.exr --nodes 2" ), 2, "--nodes: needs --check" );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
