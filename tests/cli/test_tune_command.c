// reframe tune: table, JSON, plot, the render command it prints, and its errors.
#include "support/cli_run.h"
#include "support/test.h"

#include <jansson.h>
#include <time.h>

// Returns how many were tried.
static int check_rows( const json_t* tune )
{
    static const char* const keys[] = { "group",  "tile",    "bytes_films", "bytes_hits", "chunks", "predicted_gain", "seconds",
                                        "relmse", "flicker", "phi",         "efficiency", "gain",   "chosen" };
    const json_t* rows = json_object_get( tune, "rows" );
    int chosen = 0, excluded = 0, usual = 0, tried = 0;
    int last = (int)json_array_size( json_object_get( tune, "rounds" ) );
    double best = 0.0, winner = 0.0; // of the last round
    for ( size_t i = 0; i < json_array_size( rows ); ++i )
    {
        const json_t* row = json_array_get( rows, i );
        for ( size_t k = 0; k < sizeof keys / sizeof keys[0]; ++k )
            assert_non_null( json_object_get( row, keys[k] ) );
        usual += json_is_true( json_object_get( row, "default" ) );
        if ( !json_is_null( json_object_get( row, "excluded" ) ) )
        {
            assert_true( json_is_null( json_object_get( row, "efficiency" ) ) &&
                         json_is_false( json_object_get( row, "chosen" ) ) );
            excluded += 1;
            continue;
        }
        int rounds = (int)json_integer_value( json_object_get( row, "rounds" ) );
        if ( rounds == 0 ) // no time left
        {
            assert_true( json_is_null( json_object_get( row, "efficiency" ) ) &&
                         json_is_false( json_object_get( row, "default" ) ) );
            continue;
        }
        tried += 1;
        double efficiency = json_number_value( json_object_get( row, "efficiency" ) );
        assert_true( efficiency > 0.0 && json_number_value( json_object_get( row, "flicker" ) ) > 0.0 );
        assert_true( rounds <= last );
        best = rounds == last ? fmax( best, efficiency ) : best;
        if ( !json_is_true( json_object_get( row, "chosen" ) ) )
            continue;
        chosen += 1;
        winner = efficiency;
        assert_int_equal( rounds, last );
    }
    assert_int_equal( usual, 1 );
    assert_true( chosen == 1 && excluded == 7 * 2 && best > 0.0 && winner == best ); // groups 6 and 8
    return tried;
}

static int count_of( const char* text, const char* end, const char* part )
{
    int count = 0;
    for ( const char* at = text; ( at = strstr( at, part ) ) != NULL && at < end; at += strlen( part ) )
        count += 1;
    return count;
}

// Runs tune with budgets that grow until it has measured so many settings and chosen one: how many seconds that takes, the machine decides.
// `command` has a %d for the budget.
static json_t* tune_settings( const char* command, int budget, int wanted )
{
    for ( int measured = 0; budget < 10000; budget *= 4 )
    {
        cli_expect( cli_run( command, budget ), 0, NULL );
        json_t* tune = cli_read_json( "tune.json" );
        const json_t* rows = json_object_get( tune, "rows" );
        measured = 0;
        for ( size_t i = 0; i < json_array_size( rows ); ++i )
            measured += json_is_number( json_object_get( json_array_get( rows, i ), "efficiency" ) );
        if ( measured >= wanted && json_is_string( json_object_get( tune, "command" ) ) )
            return tune;
        json_decref( tune );
    }
    fail_msg( "fewer than %d settings are measured: %s", wanted, command );
    return NULL;
}

// A line of groups for each tile that was tried, axes, and a ring around the winner.
static void check_plot( const char* svg, const json_t* tune, int tried )
{
    static const char* const words[] = { ">memory beyond the scene, MiB<",
                                         ">efficiency, 1 / (relMSE ",
                                         ">tile 1 (none)<",
                                         ">tile 2x2<",
                                         ">tile 3x3<",
                                         ">tile 4x4<",
                                         ">tile rooks16<" };
    for ( size_t i = 0; i < sizeof words / sizeof words[0]; ++i )
        assert_int_equal( count_of( svg, svg + strlen( svg ), words[i] ), 1 );
    char mark[64] = "", place[64], x[16], y[16];
    const json_t* rows = json_object_get( tune, "rows" );
    for ( size_t i = 0; i < json_array_size( rows ); ++i )
    {
        const json_t* row = json_array_get( rows, i );
        if ( json_is_true( json_object_get( row, "chosen" ) ) )
            snprintf( mark, sizeof mark, ">group %d, tile %s<", (int)json_integer_value( json_object_get( row, "group" ) ),
                      json_string_value( json_object_get( row, "tile" ) ) );
    }
    assert_non_null( strstr( svg, mark ) );
    const char* ring = svg; // the only circle that is not filled
    while ( ( ring = strstr( ring, "<circle cx=\"" ) ) != NULL && strstr( ring, " fill=\"none\"" ) > strchr( ring, '>' ) )
        ring += 1;
    assert_non_null( ring );
    assert_int_equal( sscanf( ring, "<circle cx=\"%15[0-9.]\" cy=\"%15[0-9.]\"", x, y ), 2 );
    snprintf( place, sizeof place, "%s %s", x, y );
    int lines = 0, through = 0, points = 0;
    for ( const char* line = svg; line != NULL; line = strchr( line + 1, '\n' ) )
    {
        const char* end = line + 1 + strcspn( line + 1, "\n" );
        if ( count_of( line, end, "clip-path=\"url(#plot)\"" ) == 0 )
            continue;
        lines += 1;
        points += count_of( line, end, "M" ) + count_of( line, end, "L" );
        through += count_of( line, end, place );
    }
    assert_true( lines >= 2 && lines <= 7 && through >= 1 && points == tried );
}

// Table, JSON and plot; the command that it gives is taken by render.
TEST( test_command_it_gives_is_taken_by_render )
{
    static const char options[] = "--size=16x9 --spp 5 --frames 20-21 --seed 7 --memory 200M --max-depth 4";
    // words of options in the name of a folder, where the checkout may lie, are not options
    cli_expect( cli_run( "mkdir quiet-budget && ln -s $VASE quiet-budget/vase.glb" ), 0, NULL );
    char tuned[256];
    snprintf( tuned, sizeof tuned,
              "$R tune quiet-budget/vase.glb %s --budget %%d --quiet --svg plot.svg --json tune.json > table.txt", options );
    json_t* tune = tune_settings( tuned, 10, 3 );
    int tried = check_rows( tune );
    cli_expect( cli_run( "python3 -c \"import xml.dom.minidom as m; m.parse('plot.svg')\"" ), 0, NULL );
    size_t size;
    AUTO_FREE char* svg = cli_read( "plot.svg", &size );
    check_plot( svg, tune, tried );
    AUTO_FREE char* table = cli_read( "table.txt", &size );
    const char* command = json_string_value( json_object_get( tune, "command" ) );
    assert_non_null( strstr( table, command ) );
    assert_non_null( strstr( table, "14 settings: spp would more than double" ) );
    assert_non_null( strstr( command, " --size=16x9 --spp 5 --frames 20-21 --seed 7 --memory 200M --max-depth 4" ) );
    cli_expect_verdict( table, tune, "best: " );
    assert_null( strstr( command, " --budget" ) );
    assert_null( strstr( command, " --quiet" ) );
    assert_int_equal( strncmp( command, "reframe ", 8 ), 0 );
    cli_expect( cli_run( "$R %s --quiet > out.txt", command + 8 ), 0, NULL );
    assert_int_equal( cli_count_files( ".exr", "out" ), 2 );
    json_decref( tune );
    // words on the way, and JSON alone on standard output
    const CliResult* said = NULL;
    for ( int budget = 4; budget < 10000 && ( said == NULL || strstr( said->err, "reframe tune: round 1: " ) == NULL );
          budget *= 4 )
    {
        said = cli_run( "$R tune $VASE %s --clamp auto --aov removed --budget %d --json -", options, budget );
        assert_true( said->status == 0 && said->out[0] == '{' );
    }
    assert_non_null( strstr( said->err, "reframe tune: round 1: " ) );
}

TEST( test_names_are_quoted_for_the_shell )
{
    cli_expect( cli_run( "cp $VASE \"a b'c.glb\"" ), 0, NULL );
    json_auto_t* tune =
        tune_settings( "$R tune \"a b'c.glb\" --size 8x6 --spp 1 --frames 3 --camera 'Camera' --budget %d --quiet --json "
                       "tune.json > out.txt",
                       4, 1 );
    const char* command = json_string_value( json_object_get( tune, "command" ) );
    static const char start[] = "reframe render 'a b'\\''c.glb' -o out/frame.####.exr --group ";
    assert_int_equal( strncmp( command, start, strlen( start ) ), 0 );
    cli_expect( cli_run( "$R %s --overwrite --quiet > out.txt", command + 8 ), 0, NULL );
}

TEST( test_wrong_commands_are_refused )
{
    char text[256];
    snprintf( text, sizeof text,
              "{\"scene\":\"%s\",\"render\":{\"size\":[8,6],\"spp\":3,\"frames\":\"2-3\",\"group\":1,\"tile\":\"2x2\"}}",
              REFRAME_VASE_ROOM );
    cli_write( "scene.json", text, strlen( text ) );
    cli_expect( cli_run( "$R tune scene.json --budget 1 --quiet --json tune.json > out.txt" ), 0, NULL );
    json_t* tune = cli_read_json( "tune.json" );
    assert_int_equal( json_integer_value( json_object_get( tune, "width" ) ), 8 );
    assert_int_equal( json_integer_value( json_object_get( tune, "frames" ) ), 2 );
    json_decref( tune );
    cli_expect( cli_run( "$R tune" ), 2, "reframe tune: SCENE is missing" );
    cli_expect( cli_run( "$R tune scene.json --budget -1" ), 2, "reframe tune: --budget: expected " );
    cli_expect( cli_run( "$R tune scene.json --budget" ), 2, "reframe tune: --budget: its value is missing" );
    cli_expect( cli_run( "$R tune scene.json --frames 99" ), 2, "reframe tune: --frames: there is no frame 99" );
    cli_expect( cli_run( "$R tune scene.json --size 4000x3000 --memory 1M" ), 1, "give --memory " );
    cli_expect( cli_run( "$R tune scene.json --size 400x300 --memory 1500K --budget 1 --quiet" ), 1,
                "reframe tune: a budget of 1500 KiB is too small for frames of 400x300" );
    cli_expect( cli_run( "$R tune nowhere.glb" ), 1, "reframe tune: nowhere.glb: " );
    cli_expect( cli_run( "$R tune scene.json --budget 4 --quiet --svg no/where/plot.svg > out.txt" ), 1, "--svg: no/where: " );
    cli_expect( cli_run( "$R tune --help > out.txt" ), 0, NULL );
}

// The budget that the error names works; what does not fit stays in table and JSON.
TEST( test_named_least_budget_works )
{
    static const char command[] = "$R tune $VASE --size 64x36 --spp 9 --quiet --json tune.json";
    const CliResult* said = cli_run( "%s --budget 6 --memory 1M", command );
    cli_expect( said, 1, "give --memory " );
    long least = strtol( strstr( said->err, "give --memory " ) + strlen( "give --memory " ), NULL, 10 );
    cli_expect( cli_run( "%s --budget 6 --memory %ldM", command, least - 1 ), 1, "give --memory " );
    char enough[256];
    snprintf( enough, sizeof enough, "%s --budget %%d --memory %ldM > table.txt", command, least );
    json_auto_t* tune = tune_settings( enough, 6, 1 );
    const json_t* rows = json_object_get( tune, "rows" );
    size_t size;
    char *table = cli_read( "table.txt", &size ), why[96];
    int without_room = 0;
    for ( size_t i = 0; i < json_array_size( rows ); ++i )
    {
        const json_t* row = json_array_get( rows, i );
        long megabytes = (long)( ( json_integer_value( json_object_get( row, "bytes_least" ) ) + 1048575 ) / 1048576 );
        snprintf( why, sizeof why, "does not fit in memory, needs at least %ldM", megabytes );
        assert_true( megabytes >= least );
        if ( megabytes == least )
            continue;
        without_room += 1;
        assert_string_equal( json_string_value( json_object_get( row, "excluded" ) ), why );
    }
    assert_non_null( strstr( table, ": does not fit in memory" ) );
    assert_true( without_room > 0 && without_room < (int)json_array_size( rows ) );
    free( table );
}

TEST( test_interrupt_exits_130 )
{
    cli_start( "exec $R tune $VASE --size 320x200 --budget 1000 > out.txt 2> said.txt" );
    size_t size = 0;
    for ( int i = 0; i < 60000 && size == 0; ++i ) // it says that it begins
    {
        nanosleep( &( struct timespec ){ .tv_nsec = 10000000 }, NULL );
        if ( cli_exists( "said.txt" ) )
            free( cli_read( "said.txt", &size ) );
    }
    assert_int_equal( cli_wait( 2 )->status, 130 );
    AUTO_FREE char* said = cli_read( "said.txt", &size );
    assert_non_null( strstr( said, "reframe tune: interrupted" ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
