// What scripts/blender/export.py cannot carry is named, with the object: small scenes made inside Blender
// (support/blender_losses.py) are exported, and the warnings read. Skipped where Blender or its numpy is missing.
#include "support/blender_run.h"

#define MOST 24
#define UNSEEN "lamps that light as in Blender, but are not seen in mirrors: "
#define EDGES "the edges of spots whose cones change have the light of Blender's on the whole, but fall off otherwise: "

// A line of the exporter: a loss if the text says so, else a warning.
static bool is_told( const char* err, const char* text )
{
    char line[512];
    snprintf( line, sizeof line, "blender-export: %s%s\n", strncmp( text, "loss: ", 6 ) == 0 ? "" : "warning: ", text );
    return strstr( err, line ) != NULL;
}

// Makes the scene, exports it, and compares all losses and warnings with those told.
static void expect_warnings( const char* scene, const char* const told[MOST] )
{
    blender_make( "losses %s", scene );
    const CliResult* done = blender_export( scene, "--accept-losses" );
    assert_int_equal( done->status, 0 );
    int count = 0, lines = 0;
    for ( ; told[count] != NULL; ++count )
        if ( !is_told( done->err, told[count] ) )
            fail_msg( "%s: is not told: %s\nbut:\n%s", scene, told[count], done->err );
    for ( const char* at = done->err; ( at = strstr( at, "blender-export: " ) ) != NULL; ++at )
        ++lines;
    if ( lines != count )
        fail_msg( "%s: %d lines instead of %d:\n%s", scene, lines, count, done->err );
}

// Is there a node of this name, of two parts, in the .glb? Its JSON begins behind 20 bytes.
static bool has_node( const char* file, const char* name, const char* more )
{
    size_t size;
    char text[80], *glb = cli_read( file, &size );
    snprintf( text, sizeof text, "\"name\":\"%s%s\"", name, more );
    assert_true( size > 20 );
    bool found = strstr( glb + 20, text ) != NULL;
    free( glb );
    return found;
}

BLENDER_TEST( test_plain_scene_has_no_warning ) { expect_warnings( "plain", ( const char* const[MOST] ){ NULL } ); }

BLENDER_TEST( test_lamps_that_rays_treat_otherwise )
{
    expect_warnings( "lamps", ( const char* const[MOST] ){
                                  "'through walls': lights through everything in Blender: throws shadows here",
                                  "'for gloss': hidden from some kinds of rays in Blender: lights all surfaces here",
                                  "'lens': seen by the camera in Blender: not seen here",
                                  "loss: world 'sky' is hidden from some kinds of rays in Blender: lights all surfaces here",
                                  "lamps that light as in Blender, but are not seen in mirrors and glass, and light nothing "
                                  "through solid glass: 'for gloss', 'lens', 'window'",
                              } );
}

// Where the light of the whole picture is lost, nothing is written, what was there stays, and all losses are told.
BLENDER_TEST( test_losses_are_errors )
{
    blender_make( "losses lamps" );
    assert_int_equal( cli_run( "mkdir out && echo old > out/old.glb && echo old > out/old-sky.exr" )->status, 0 );
    const CliResult* done = cli_run( BLENDER "lamps.blend -P " BLENDER_SCRIPT "out/old.glb --frames 1-100 --overwrite > log" );
    assert_int_equal( done->status, 1 );
    assert_non_null( strstr( done->err, "blender-export: loss: world 'sky' is hidden from some kinds of rays in Blender: lights "
                                        "all surfaces here\n"
                                        "blender-export: nothing is written for what would be lost: change it in Blender, or "
                                        "export without it by --accept-losses\n" ) );
    assert_string_equal( cli_run( "ls -A out && cat out/*" )->out, "old-sky.exr\nold.glb\nold\nold\n" );
    assert_string_equal( cli_run( "grep -v '^Blender\\|Read blend\\|^$' log | head -2" )->out,
                         "blender-export: frame 10/100\nblender-export: frame 20/100\n" );
}

// Of Blender 4.
BLENDER_TEST( test_lamps_of_blender_4 )
{
    if ( !blender_is_4() )
    {
        cli_leave();
        skip();
    }
    expect_warnings( "linked", ( const char* const[MOST] ){
                                   "'cube', 'for some': lights some objects only in Blender (light linking): all here",
                                   "'past some': only some objects throw its shadows in Blender (shadow linking): all do here",
                                   UNSEEN "'wide', 'close'",
                               } );
}

BLENDER_TEST( test_instances_are_reported_as_well )
{
    expect_warnings( "instances", ( const char* const[MOST] ){
                                      "'torch': lights through everything in Blender: throws shadows here",
                                      "'ghost': hidden from some kinds of rays in Blender: seen by all here",
                                      "'ghost': large smooth faces: up to 20 % darker where they turn from the light",
                                      "'pit': left out: holdouts do not exist in Reframe",
                                      "'fur': hair: left out",
                                      "'dust': a point cloud: left out",
                                      "'far': collections that the camera does not see in Blender: seen by all rays here",
                                  } );
}

BLENDER_TEST( test_objects_that_are_hidden_in_some_frames )
{
    expect_warnings( "switched", ( const char* const[MOST] ){ NULL } );
    assert_true( has_node( "switched.glb", "goes", "" ) && has_node( "switched.glb", "comes", "" ) &&
                 has_node( "switched.glb", "stays", "" ) && has_node( "switched.glb", "piece", "" ) );
    assert_false( has_node( "switched.glb", "is away", "" ) );
}

BLENDER_TEST( test_what_changes )
{
    expect_warnings( "changes",
                     ( const char* const[MOST] ){
                         "loss: 'spread': the spread of the lamp changes: taken as in the frame in which it is brightest",
                         UNSEEN "'edge'",
                         EDGES "'edge', 'cone'",
                     } );
    expect_warnings( "more_changes",
                     ( const char* const[MOST] ){
                         "loss: 'sun': the angle of the lamp changes: taken as in the frame in which it is brightest",
                         UNSEEN "'sun'",
                     } );
}

BLENDER_TEST( test_what_blender_does_to_pictures )
{
    expect_warnings( "pictures", ( const char* const[MOST] ){
                                     "Freestyle's lines are left out",
                                     "view layers 'back': left out: 'ViewLayer' is exported",
                                     "view layer 'ViewLayer' is rendered without the world in Blender: exported with it",
                                     "view layer 'ViewLayer' is rendered without surfaces in Blender: exported with them",
                                     "the render region is ignored: the whole picture is exported",
                                 } );
}

BLENDER_TEST( test_what_takes_light_away )
{
    expect_warnings( "darkness",
                     ( const char* const[MOST] ){
                         "loss: 'dark area': lamp: takes light away in Blender: left out",
                         "loss: 'dark point': lamp: takes light away in Blender: left out",
                         "loss: 'dark sun': lamp: takes light away in Blender: left out",
                         "loss: 'dark spot': lamp: takes light away in Blender: left out",
                         "loss: 'nodes': lamp: takes light away in Blender: left out",
                         "'hole': material 'hole': takes light away in Blender: does not shine here",
                         "'bright': material 'bright': reflects more light than arrives in Blender: its colour is "
                         "taken as 1 at most",
                         "loss: world 'sky' takes light away in Blender: left out",
                         !blender_is_4()
                             ? "'bright': material 'bright': reflects more light than arrives in Blender: its diffuse part is "
                               "9 % darker in even light"
                             : NULL,
                     } );
    assert_true( has_node( "darkness.glb", "twice area", "" ) && has_node( "darkness.glb", "key area", "" ) );
    // the file is one that is read
    cli_expect( cli_run( "$R info darkness.glb > log" ), 0, NULL );
}

// Which of two lamps of one name gets a number is up to Blender.
BLENDER_TEST( test_lamps_of_instances_in_view )
{
    bool is_4 = blender_is_4();
    const char* seen = is_4 ? "panel" : "panel.001";
    const char* behind = is_4 ? "panel.001" : "panel";
    expect_warnings( "placed_lamps",
                     ( const char* const[MOST] ){ is_4 ? UNSEEN "'torch', 'panel'" : UNSEEN "'torch.001', 'panel.001'" } );
    assert_true( has_node( "placed_lamps.glb", behind, " area" ) && has_node( "placed_lamps.glb", seen, "" ) );
    assert_false( has_node( "placed_lamps.glb", seen, " area" ) );
}

BLENDER_TEST( test_what_cycles_leaves_out_by_its_settings )
{
    expect_warnings( "cycles_settings", ( const char* const[MOST] ){
                                            "caustics by mirrors are off in Blender: on here",
                                            "caustics by glass are off in Blender: on here",
                                            "light is approximated after some bounces in Blender (fast GI): not here",
                                            "the film is transparent behind glass in Blender: glass shows the world here",
                                            "the view's curves are left out",
                                            "'once': lights by few bounces in Blender: by all here",
                                            "'cube': material 'veil': has no transparent shadows in Blender: has them here",
                                            "'rock': adaptive subdivision: taken as 5 further levels",
                                        } );
    assert_non_null( strstr( cli_run( "$R info cycles_settings.glb" )->out, ", with alpha\n" ) );
}

// What limits of a kind of bounces cut is told once, with its share; that of all goes over.
BLENDER_TEST( test_limits_of_paths )
{
    blender_make( "losses limits" );
    const CliResult* done = blender_exported( "limits", "" );
    expect_said( done->err, "light ends by limits in Blender (1 diffuse, 0 glossy bounces of 2, 4 transparent, Clamp Direct): "
                            "all of it is here, " );
    assert_null( strstr( strstr( done->err, "warning: " ) + 1, "warning: " ) );
    assert_non_null( strstr( cli_run( "$R info limits.glb" )->out, "max depth  4, from the glTF: about " ) );
}

BLENDER_TEST( test_sides_that_shine_differently )
{
    expect_warnings( "sides",
                     ( const char* const[MOST] ){
                         "loss: 'back': material 'back', node 'Mix Shader': its back shines in Blender, not its front: does not "
                         "shine here: turn the faces round",
                         "loss: 'both': material 'both', node 'Mix Shader': its sides shine differently in Blender: both as the "
                         "front here",
                         "loss: world 'fog' has a volume, which takes light on its way: left out",
                         "'cube': left out where they are far from the camera in Blender (culling): always there here",
                         "'both', 'twin': faces in one place, which shade each other in Blender: as one here",
                     } );
}

BLENDER_TEST( test_what_meshes_carry_over_time ) { expect_warnings( "carried", ( const char* const[MOST] ){ NULL } ); }

BLENDER_TEST( test_missing_films_are_named_once )
{
    expect_warnings( "gone",
                     ( const char* const[MOST] ){
                         "image 'film': /nowhere/film.0001.png and 2 other files of it are missing: magenta, as in Cycles" } );
}
