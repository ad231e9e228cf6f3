// --effects and --no-effect as a user sees them: in info, in a render's line, JSON, warnings and header, and with --resume.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "image/exr.h"

#define SMALL "--size 24x18 --spp 3 --frames 2 --group 1 --no-adaptive --float "

static void expect_same_pixels( const char* one, const char* two, bool same )
{
    AUTO_IMAGE a = cli_read_exr( one ), b = cli_read_exr( two );
    size_t bytes = 3 * (size_t)a.width * (size_t)a.height * sizeof( float );
    assert_int_equal( memcmp( a.rgb, b.rgb, bytes ) == 0, same );
}

static void expect_header( const char* name, const char* key, const char* wanted )
{
    const char* value = cli_exr_text( name, key );
    assert_int_equal( value != NULL, wanted != NULL );
    if ( wanted != NULL )
        assert_non_null( strstr( value, wanted ) );
}

static const json_t* row_of( const json_t* json, const char* name )
{
    size_t i;
    const json_t* row;
    json_array_foreach( json_object_get( json, "effects" ), i, row )
    {
        if ( strcmp( json_string_value( json_object_get( row, "name" ) ), name ) == 0 )
            return row;
    }
    fail_msg( "no effect %s", name );
    return NULL;
}

TEST( test_info_tells_all_effects )
{
    const CliResult* result = cli_run( "$R info $VASE --no-effect phong" );
    cli_expect( result, 0, "--no-effect phong: changes the picture: materials keep" );
    assert_non_null( strstr( result->out, "  out  phong " ) );
    cli_expect( cli_run( "$R info $VASE --effects all --json all.json > text" ), 0, NULL );
    json_auto_t* json = cli_read_json( "all.json" );
    assert_true( json_is_true( json_object_get( row_of( json, "panes" ), "forced" ) ) );
    assert_true( json_is_false( json_object_get( row_of( json, "panes" ), "on" ) ) );
    assert_true( json_is_false( json_object_get( row_of( json, "environment" ), "forced" ) ) );
    assert_string_equal( json_string_value( json_object_get( row_of( json, "adaptive" ), "option" ) ), "--adaptive" );
}

TEST( test_names_are_checked )
{
    cli_expect( cli_run( "$R info $VASE --no-effect mirors" ), 2, "--no-effect: unknown effect 'mirors', did you mean mirrors?" );
    cli_expect( cli_run( "$R render $VASE -o a.exr --no-effect adaptive" ), 2,
                "--no-effect: adaptive cannot be left out of a scene: give --no-adaptive" );
    cli_expect( cli_run( "$R tune $VASE --budget 0 --no-effect pixel-filter" ), 2, "give --filter box" );
    cli_expect( cli_run( "$R tune $VASE --no-effect panes,panes" ), 2, "the effect panes is given twice" );
    write_room( "" );
    write_text( "bad.json", "{\"scene\":\"room.gltf\",\"render\":{\"no_effect\":\"pane\"}}" );
    cli_expect( cli_run( "$R render bad.json -o a.exr" ), 1,
                "bad.json: render.no_effect: unknown effect 'pane', did you mean panes?" );
}

TEST( test_renders_say_what_they_do )
{
    cli_expect( cli_run( "$R render $VASE -o said.exr " SMALL "--verbose --no-effect phong,light-tree --json said.json 2> said" ),
                0, NULL );
    cli_expect( cli_run( "grep -q 'effects: diffuse,ggx,.*; left out: phong,light-tree$' said" ), 0, NULL );
    cli_expect( cli_run( "grep -q 'warning: --no-effect light-tree: changes nothing: up to 2 lights' said" ), 0, NULL );
    json_auto_t* json = cli_read_json( "said.json" );
    json_t* out = json_object_get( json, "effects_left_out" );
    assert_int_equal( json_array_size( out ), 2 );
    assert_string_equal( json_string_value( json_array_get( out, 0 ) ), "phong" );
    assert_int_equal( json_array_size( json_object_get( json, "effects_forced" ) ), 0 );
    assert_int_equal( json_array_size( json_object_get( json, "warnings" ) ), 2 );
    expect_header( "said.exr", "reframe/calls-for", "diffuse,ggx,area-lights" );
    expect_header( "said.exr", "reframe/no-effect", "phong,light-tree" );
    expect_header( "said.exr", "reframe/effects", NULL );
}

// Frames of a render without an effect are others; those of a render with all effects called for are what they were.
TEST( test_resume_knows_effects )
{
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL "--quiet" ), 0, NULL );
    expect_header( "r.exr", "reframe/no-effect", NULL );
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL "--quiet --resume" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL "--quiet --resume --no-effect phong 2>&1 | grep resume: >&2" ), 0,
                "of another render, of --no-effect none (here phong): give" );
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL "--quiet --resume --effects all" ), 1,
                "of another render, of --effects auto (here all): give" );
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL "--quiet --overwrite --effects all --json r.json" ), 0, NULL );
    expect_header( "r.exr", "reframe/effects", "all" );
    cli_expect( cli_run( "$R render $VASE -o r.exr " SMALL "--quiet --resume --effects all" ), 0, NULL );
    json_auto_t* json = cli_read_json( "r.json" );
    assert_true( json_array_size( json_object_get( json, "effects_forced" ) ) > 5 );
}

TEST( test_no_lens_is_a_pinhole )
{
#define LENS "--fstop 1 --focus 3 --shutter 0.5 --quiet "
    cli_expect( cli_run( "$R render $VASE -o pinhole.exr " SMALL "--quiet" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o lens.exr " SMALL LENS ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o left.exr " SMALL LENS "--no-effect depth-of-field,motion-blur 2> said" ), 0, NULL );
    expect_same_pixels( "pinhole.exr", "left.exr", true );
    expect_same_pixels( "pinhole.exr", "lens.exr", false );
    expect_header( "lens.exr", "reframe/calls-for", "depth-of-field,motion-blur" );
}

TEST( test_scene_files_may_leave_out )
{
    write_room( "" );
    write_text( "sky.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[1,2,4]},"
                            "\"render\":{\"no_effect\":\"environment\"}}" );
    write_text( "dark.json", "{\"scene\":\"room.gltf\"}" );
    cli_expect( cli_run( "$R render sky.json -o sky.exr --size 24x18 --spp 8 --group 0 --quiet --float 2> said" ), 0, NULL );
    cli_expect( cli_run( "$R render dark.json -o dark.exr --size 24x18 --spp 8 --group 0 --quiet --float" ), 0, NULL );
    expect_same_pixels( "sky.exr", "dark.exr", true );
    cli_expect( cli_run( "$R info sky.json 2> said | grep -q '  out  environment .*left out: the sky is black'" ), 0, NULL );
}

// In header, JSON and the last line, with and without a clamp.
TEST( test_caustics_are_counted )
{
#define STILL_LIFE "'" REFRAME_SCENE_FOLDER "/still-life.glb' "
    cli_expect( cli_run( "$R info " STILL_LIFE "| grep -q '  on   caustics  .*material'" ), 0, NULL );
    cli_expect( cli_run( "$R render " STILL_LIFE "-o s.exr " SMALL "--aov removed" ), 2, "or caustics left out" );
    const CliResult* done =
        cli_run( "$R render " STILL_LIFE "-o s.exr " SMALL "--aov removed --no-effect caustics --json s.json" );
    cli_expect( done, 0, NULL );
    assert_non_null( strstr( done->err, "--no-effect caustics: changes the picture: light that mirrors, glass" ) );
    assert_non_null( strstr( done->out, "% of the light removed" ) );
    json_t *json = cli_read_json( "s.json" ), *frame = json_array_get( json_object_get( json, "frames" ), 0 );
    assert_true( json_number_value( json_object_get( frame, "removed_share" ) ) > 0.0 );
    assert_null( json_object_get( frame, "clamp_threshold" ) );
    json_decref( json );
    expect_header( "s.exr", "reframe/removed-share", "0." );
    expect_header( "s.exr", "reframe/clamp-threshold", NULL );
    cli_expect( cli_run( "$R render " STILL_LIFE "-o c.exr " SMALL "--quiet --clamp 1 --no-effect caustics 2> said" ), 0, NULL );
    expect_header( "c.exr", "reframe/removed-share", "0." );
    expect_header( "c.exr", "reframe/clamp-threshold", "1" );
    cli_expect( cli_run( "$R render $VASE -o v.exr " SMALL "--quiet" ), 0, NULL );
    expect_header( "v.exr", "reframe/removed-share", NULL );
    expect_header( "v.exr", "reframe/max-depth", NULL );
    expect_header( "v.exr", "reframe/beyond-depth-share", NULL );
}

// On standard error, in header and JSON; by info where the scene file has the limit.
TEST( test_light_beyond_depth_is_told )
{
    char line[128];
    double share = 0.0;
    write_text( "cut.json", "{\"scene\":\"" REFRAME_VASE_ROOM "\",\"render\":{\"max_depth\":3}}" );
    const CliResult* done = cli_run( "$R render cut.json -o d.exr --size 24x18 --spp 2 --frames 1 --quiet --json d.json" );
    cli_expect( done, 0, NULL );
    json_t* json = cli_read_json( "d.json" );
    share = json_number_value( json_object_get( json, "beyond_depth_share" ) );
    assert_true( share > 0.0005 && share < 1.0 );
    snprintf( line, sizeof line, "warning: --max-depth 3: about %.2g %% of the light is beyond and missing", 100.0 * share );
    assert_non_null( strstr( done->err, line ) );
    json_decref( json );
    expect_header( "d.exr", "reframe/max-depth", "3" );
    expect_header( "d.exr", "reframe/beyond-depth-share", "0." );
    assert_non_null( strstr( cli_run( "$R info cut.json 2> said" )->out, "max depth  3: about 1" ) );
    done = cli_run( "$R tune cut.json --budget 0 --size 24x18 --json -" );
    cli_expect( done, 0, "--max-depth 3: about" );
    assert_non_null( strstr( done->out, "beyond_depth_share" ) );
    done = cli_run( "$R render cut.json -o d.exr --size 24x18 --spp 2 --frames 1 --max-depth none --overwrite --quiet" );
    cli_expect( done, 0, NULL );
    assert_null( strstr( done->err, "max-depth" ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
