// What scripts/blender/export.py cannot carry is named, with the object: small scenes made inside Blender
// (support/blender_losses.py) are exported, and the warnings read. Skipped where Blender or its numpy is missing.
#include "support/blender_run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MOST 24
#define EDGES "the edges of spots have the light of Blender's on the whole, but fall off otherwise: "

// Makes the scene, exports it, and compares all warnings, each of which is printed twice, with those told. The folder stays.
static void export_and_expect( const char* scene, const char* const told[MOST] )
{
    if ( !enter_with_blender() )
        skip();
    cli_expect( cli_run( BLENDER "--factory-startup --python-exit-code 9 -P " REFRAME_SOURCE_DIR
                                 "/tests/support/blender_losses.py -- %s > log 2>&1",
                         scene ),
                0, NULL );
    const CliResult* done = cli_run(
        BLENDER "%s.blend -P " REFRAME_SOURCE_DIR "/scripts/blender/export.py -- %s.glb --bake-cache cache > log", scene, scene );
    assert_int_equal( done->status, 0 );
    int count = 0, lines = 0;
    for ( ; told[count] != NULL; ++count )
    {
        char line[512];
        snprintf( line, sizeof line, "blender-export: warning: %s\n", told[count] );
        if ( strstr( done->err, line ) == NULL )
            fail_msg( "%s: is not told: %s\nbut:\n%s", scene, told[count], done->err );
    }
    for ( const char* at = done->err; ( at = strstr( at, "blender-export: warning: " ) ) != NULL; ++at )
        ++lines;
    if ( lines != 2 * count )
        fail_msg( "%s: %d warnings instead of %d:\n%s", scene, lines / 2, count, done->err );
}

static void expect_warnings( const char* scene, const char* const told[MOST] )
{
    export_and_expect( scene, told );
    cli_leave();
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

static void test_plain_scene_has_no_warning( void** state )
{
    (void)state;
    expect_warnings( "plain", ( const char* const[MOST] ){ NULL } );
}

static void test_lamps_that_rays_treat_otherwise( void** state )
{
    (void)state;
    bool is_4 = blender_major() >= 4;
    expect_warnings( "lamps",
                     ( const char* const[MOST] ){
                         "'for gloss': a sun of 0.5 degrees: its shadows are sharp here, it is not seen in mirrors, and lights "
                         "nothing through solid glass",
                         "'through walls': lights through everything in Blender: throws shadows here",
                         "'for gloss': hidden from some kinds of rays in Blender: lights all surfaces here",
                         "'lens': seen by the camera in Blender: not seen here",
                         "'window': an area lamp that the camera does not see in Blender: may be in view here, and hides what is "
                         "behind",
                         "world 'sky' is hidden from some kinds of rays in Blender: lights all surfaces here",
                         "spot lamps, and point lamps in view, have no radius here: sharp shadows, not seen in mirrors, no light "
                         "through solid glass: 'lens'",
                         is_4 ? EDGES "'lens'" : NULL,
                     } );
}

// Of Blender 4.
static void test_lamps_of_blender_4( void** state )
{
    (void)state;
    if ( blender_major() < 4 )
        skip();
    expect_warnings( "linked", ( const char* const[MOST] ){
                                   "'cube', 'for some': lights some objects only in Blender (light linking): all here",
                                   "'past some': only some objects throw its shadows in Blender (shadow linking): all do here",
                                   "'wide': the cone of a spot that is scaled by 2 and 1: taken as round",
                                   EDGES "'wide'",
                                   "'close': soft falloff: left out, which gives what is near up to 6 % more light",
                                   "spot lamps, and point lamps in view, have no radius here: sharp shadows, not seen in "
                                   "mirrors, no light through solid "
                                   "glass: 'wide', 'close'",
                               } );
}

static void test_instances_are_reported_as_well( void** state )
{
    (void)state;
    expect_warnings( "instances", ( const char* const[MOST] ){
                                      "'torch': lights through everything in Blender: throws shadows here",
                                      "'ghost': hidden from some kinds of rays in Blender: seen by all here",
                                      "'pit': left out: holdouts do not exist in Reframe",
                                      "'fur': hair: left out",
                                      "'dust': a point cloud: left out",
                                      "'far': collections that the camera does not see in Blender: seen by all rays here",
                                  } );
}

static void test_objects_that_are_hidden_in_some_frames( void** state )
{
    (void)state;
    export_and_expect( "switched",
                       ( const char* const[MOST] ){
                           "'builds': moves or changes: not exported; as in the first frame, by `reframe render --freeze` alone",
                           "'blinks', 'comes', 'goes', 'place': hidden in some of the frames: not exported; as in the first "
                           "frame, by `reframe render --freeze` alone",
                       } );
    assert_true( has_node( "switched.glb", "goes", "" ) && has_node( "switched.glb", "stays", "" ) &&
                 has_node( "switched.glb", "piece", "" ) );
    assert_false( has_node( "switched.glb", "comes", "" ) || has_node( "switched.glb", "is away", "" ) );
    cli_leave();
}

static void test_what_changes( void** state )
{
    (void)state;
    bool is_4 = blender_major() >= 4;
    expect_warnings( "changes",
                     ( const char* const[MOST] ){
                         "'ball', 'cone', 'edge', 'spread', 'wide': moves or changes: not exported; as in the first frame, by "
                         "`reframe render --freeze` alone",
                         "'bulb': lamp, node 'Emission': animated or driven: taken as in the first frame",
                         "world 'sky', node 'Background': animated or driven: taken as in the first frame",
                         "spot lamps, and point lamps in view, have no radius here: sharp shadows, not seen in mirrors, no light "
                         "through solid glass: 'edge'",
                         is_4 ? EDGES "'edge', 'cone'" : NULL,
                     } );
    expect_warnings( "more_changes", ( const char* const[MOST] ){
                                         "'bright', 'red', 'size', 'sun': moves or changes: not exported; as in the first frame, "
                                         "by `reframe render --freeze` alone",
                                         "'sun': a sun of 5.7 degrees: its shadows are sharp here, it is not seen in mirrors, "
                                         "and lights nothing through solid glass",
                                         "'cube': material 'paint': animated or driven: taken as in the first frame",
                                     } );
}

static void test_what_blender_does_to_pictures( void** state )
{
    (void)state;
    expect_warnings( "pictures", ( const char* const[MOST] ){
                                     "Freestyle's lines are left out",
                                     "view layers 'back': left out: 'ViewLayer' is exported",
                                     "view layer 'ViewLayer' is rendered without the world in Blender: exported with it",
                                     "view layer 'ViewLayer' is rendered without surfaces in Blender: exported with them",
                                     "the render region is ignored: the whole picture is exported",
                                 } );
}

static void test_what_takes_light_away( void** state )
{
    (void)state;
    export_and_expect(
        "darkness",
        ( const char* const[MOST] ){
            "'dark area': lamp: takes light away in Blender: left out",
            "'dark point': lamp: takes light away in Blender: left out",
            "'dark sun': lamp: takes light away in Blender: left out",
            "'dark spot': lamp: takes light away in Blender: left out",
            "'nodes': lamp: takes light away in Blender: left out",
            "'hole': material 'hole': takes light away in Blender: does not shine here",
            "'bright': material 'bright': reflects more light than arrives in Blender: its colour is "
            "taken as 1 at most",
            "world 'sky' takes light away in Blender: left out",
            blender_major() < 4
                ? "'bright': material 'bright': reflects more light than arrives in Blender: its diffuse part is 8 % darker"
                : NULL,
        } );
    assert_true( has_node( "darkness.glb", "twice area", "" ) && has_node( "darkness.glb", "key area", "" ) );
    // the file is one that is read
    cli_expect( cli_run( "$R info darkness.glb > log" ), 0, NULL );
    cli_leave();
}

// Which of two lamps of one name gets a number is up to Blender.
static void test_lamps_of_instances_in_view( void** state )
{
    (void)state;
    const char* seen = blender_major() >= 4 ? "torch" : "torch.001";
    const char* behind = blender_major() >= 4 ? "torch.001" : "torch";
    char told[256];
    snprintf( told, sizeof told,
              "spot lamps, and point lamps in view, have no radius here: sharp shadows, not seen in mirrors, no light through "
              "solid glass: '%s'",
              seen );
    export_and_expect( "placed_lamps", ( const char* const[MOST] ){
                                           "'panel': an area lamp that the camera does not see in Blender: may be in view "
                                           "here, and hides what is behind",
                                           told,
                                       } );
    assert_true( has_node( "placed_lamps.glb", behind, " sphere" ) );
    assert_false( has_node( "placed_lamps.glb", seen, " sphere" ) );
    cli_leave();
}

static void test_what_cycles_leaves_out_by_its_settings( void** state )
{
    (void)state;
    bool is_4 = blender_major() >= 4;
    expect_warnings(
        "cycles_settings",
        ( const char* const[MOST] ){
            "light ends after few bounces in Blender (8 in all, 2 glossy): it goes on here (see --max-depth)",
            "caustics by mirrors are off in Blender: on here",
            "caustics by glass are off in Blender: on here",
            "light is clamped in Blender: all of it is here",
            "light is approximated after some bounces in Blender (fast GI): not here",
            "the film is transparent behind glass in Blender: glass shows the world here",
            is_4 ? "the view's exposure of 1, gamma of 2, look 'AgX - High Contrast', curves: left out: pictures have the "
                   "scene's own light"
                 : "the view's exposure of 1, gamma of 2, look 'High Contrast', curves: left out: pictures have the scene's "
                   "own light",
            "'once': lights by few bounces in Blender: by all here",
            "'cube': material 'veil': has no transparent shadows in Blender: has them here",
            "'rock': adaptive subdivision: taken as 5 further levels",
        } );
}

static void test_what_meshes_carry_over_time( void** state )
{
    (void)state;
    expect_warnings( "carried", ( const char* const[MOST] ){
                                    "'colours', 'coordinates', 'materials': moves or changes: not exported; as in the first "
                                    "frame, by `reframe render --freeze` alone",
                                } );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_plain_scene_has_no_warning ),
        cmocka_unit_test( test_lamps_that_rays_treat_otherwise ),
        cmocka_unit_test( test_lamps_of_blender_4 ),
        cmocka_unit_test( test_instances_are_reported_as_well ),
        cmocka_unit_test( test_objects_that_are_hidden_in_some_frames ),
        cmocka_unit_test( test_what_changes ),
        cmocka_unit_test( test_what_blender_does_to_pictures ),
        cmocka_unit_test( test_what_takes_light_away ),
        cmocka_unit_test( test_lamps_of_instances_in_view ),
        cmocka_unit_test( test_what_cycles_leaves_out_by_its_settings ),
        cmocka_unit_test( test_what_meshes_carry_over_time ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
