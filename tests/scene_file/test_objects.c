// Objects of scene files: nodes that move by keys, and files that are placed, against glTF alone and closed forms.
#include "support/cli_run.h"
#include "support/image_files.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "scene/movement.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MUTATIONS 300

static char s_warnings[4096];

static void keep_warning( void* user, const char* text )
{
    (void)user;
    size_t used = strlen( s_warnings );
    snprintf( s_warnings + used, sizeof s_warnings - used, "%s\n", text );
}

// {"scene": FILE, MEMBERS}.
static RfResult try_scene( const char* name, const char* members, bool freeze, RfScene* scene, RfError* error )
{
    char text[8192], path[256];
    RfSceneFile file;
    RfLog log = { .fn = keep_warning };
    RfSceneOptions options = { .freeze = freeze };
    s_warnings[0] = 0;
    memset( scene, 0, sizeof *scene );
    snprintf( text, sizeof text, "{\"scene\":\"%s\",%s}", name, members );
    write_text( "scene.json", text );
    snprintf( path, sizeof path, "%s/scene.json", cli_folder() );
    RfResult result = rf_open_scene_file( path, &file, error );
    if ( result != RF_OK )
        return result;
    result = rf_load_scene_file( &file, &options, scene, &log, error );
    rf_close_scene_file( &file );
    return result;
}

static RfScene load_scene( const char* name, const char* members )
{
    RfScene scene;
    RfError error = { 0 };
    if ( try_scene( name, members, false, &scene, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return scene;
}

static RfScene load_alone( const char* name )
{
    char path[256];
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    return gltf_load( path );
}

static void expect_fault( const char* objects, const char* part )
{
    char members[4096];
    RfScene scene;
    RfError error = { 0 };
    snprintf( members, sizeof members, "\"objects\":%s", objects );
    RfResult result = try_scene( "room.glb", members, false, &scene, &error );
    if ( result == RF_OK || result != error.code || strstr( error.text, part ) == NULL || strchr( error.text, '\n' ) != NULL ||
         strstr( error.text, "/scene.json: objects" ) == NULL )
        fail_msg( "'%s' gave %s '%s' instead of '%s'", objects, rf_result_name( result ), error.text, part );
    assert_null( scene.path );
    assert_int_equal( try_scene( "room.glb", members, false, &scene, NULL ), result );
}

static void assert_same_moments( const RfScene* a, const RfScene* b )
{
    for ( int k = -1; k <= 9; ++k )
    {
        uint64_t left, right;
        RfError error;
        assert_int_equal( rf_moment_hash( a, 0.25 * k, &left, &error ), RF_OK );
        assert_int_equal( rf_moment_hash( b, 0.25 * k, &right, &error ), RF_OK );
        assert_true( left == right );
    }
    assert_true( a->movement->start == b->movement->start && a->movement->end == b->movement->end );
    assert_memory_equal( &a->bounds_min, &b->bounds_min, sizeof a->bounds_min );
    assert_memory_equal( &a->bounds_max, &b->bounds_max, sizeof a->bounds_max );
}

// ---- Files ----------------------------------------------------------------------

static const float s_corners[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };

static void write_glb( const char* name, GltfBuilder* b, const char* rest )
{
    size_t size;
    uint8_t* bytes = build_glb( b, rest, &size );
    cli_write( name, bytes, size );
    free( bytes );
}

#define TRIANGLE "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}"
#define ANIMATE( path )                                                                                                          \
    "\"animations\":[{\"name\":\"Own\",\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{\"sampler\":0,"                  \
    "\"target\":{\"node\":1,\"path\":\"" path "\"}}]}],"

// room.glb: a floor, a door 2 m to the right with a handle below it, which stand still, and a camera. With `animation` the door moves.
static void write_door( const char* name, const char* animation )
{
    GltfBuilder b = { 0 };
    static const float s_times[] = { 0.5f, 1, 2 };
    static const float s_turns[] = { 0, 0, 0, 1, .5f, .5f, .5f, .5f, 0, 1, 0, 0 };
    char rest[4096];
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    add_gltf_floats( &b, "SCALAR", 1, 3, s_times );
    add_gltf_floats( &b, "VEC4", 4, 3, s_turns );
    snprintf( rest, sizeof rest,
              "%s\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
              "\"nodes\":[{\"mesh\":0},{\"name\":\"Door\",\"mesh\":0,\"translation\":[2,0,0],\"children\":[2]},"
              "{\"name\":\"Handle\",\"mesh\":0,\"translation\":[0,0,1]},{\"name\":\"Eye\",\"camera\":0,\"translation\":[0,0,5]},"
              "{\"name\":\"Leaf\",\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,9,0,0,1],\"mesh\":0},{\"name\":\"Leaf\"}],"
              "\"materials\":[{\"name\":\"wood\"}],\"meshes\":[" TRIANGLE "]",
              animation );
    write_glb( name, &b, rest );
}

#define TURN                                                                                                                     \
    "{\"time\":0.5,\"rotation\":[0,0,0,1]},{\"time\":1,\"rotation\":[0.5,0.5,0.5,0.5]},{\"time\":2,\"rotation\":[0,1,0,0]}"

// A figure of an arm that bends, a disc that slides and a face that changes, all in two animations, and a stone that stands still.
static void write_figure( void )
{
    GltfBuilder b = { 0 };
    static const uint8_t s_joints[] = { 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0 };
    static const float s_weights[] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
    static const float s_times[] = { 0.5f, 1, 1.5f }, s_moves[] = { 0, 0, 0, 1, 2, 0, 0, 3, 0 },
                       s_target[] = { 0, 0, 1, 0, 0, 2, 0, 0, 3 };
    static const float s_shares[] = { 0, 1, 0.25f }, s_uvs[] = { 0, 0, 1, 0, 0, 1 };
    static const uint8_t s_pixels[] = { 255, 0, 0, 0, 0, 255 };
    size_t size;
    uint8_t* png = encode_png( 2, 1, 3, s_pixels, &size );
    cli_write( "picture.png", png, size );
    free( png );
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    add_gltf_accessor( &b, 5121, "VEC4", 3, s_joints, sizeof s_joints, "" );
    add_gltf_floats( &b, "VEC4", 4, 3, s_weights );
    add_gltf_floats( &b, "SCALAR", 1, 3, s_times );
    add_gltf_floats( &b, "VEC3", 3, 3, s_moves );
    add_gltf_floats( &b, "VEC3", 3, 3, s_target );
    add_gltf_floats( &b, "SCALAR", 1, 3, s_shares );
    add_gltf_floats( &b, "VEC2", 2, 3, s_uvs );
    write_glb(
        "figure.glb", &b,
        "\"nodes\":[{\"mesh\":0,\"skin\":0,\"name\":\"Arm\"},{\"children\":[2]},{\"name\":\"Hand\"},{\"mesh\":1,\"name\":"
        "\"Disc\"},"
        "{\"mesh\":2,\"name\":\"Face\"},{\"mesh\":1,\"translation\":[0,0,5]}],\"skins\":[{\"joints\":[1,2]}],"
        "\"images\":[{\"uri\":\"picture.png\"}],\"textures\":[{\"source\":0}],"
        "\"materials\":[{\"name\":\"fur\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}},{\"name\":\"stone\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2,\"TEXCOORD_0\":7},"
        "\"material\":0}]},{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":1}]},"
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":5}]}]}],"
        "\"animations\":[{\"name\":\"Go\",\"samplers\":[{\"input\":3,\"output\":4},{\"input\":3,\"output\":6}],"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"translation\"}},"
        "{\"sampler\":0,\"target\":{\"node\":3,\"path\":\"translation\"}},"
        "{\"sampler\":1,\"target\":{\"node\":4,\"path\":\"weights\"}}]},"
        "{\"name\":\"Grow\",\"samplers\":[{\"input\":3,\"output\":4}],"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":3,\"path\":\"translation\"}},"
        "{\"sampler\":0,\"target\":{\"node\":3,\"path\":\"scale\"}}]}]" );
}

// ---- Nodes ----------------------------------------------------------------------

TEST( test_keys_of_a_node )
{
    RfScene alone = load_alone( "moving.glb" );
    RfScene scene =
        load_scene( "room.glb", "\"objects\":[{\"node\":\"Door\",\"interpolation\":\"linear\",\"keys\":[" TURN "]}]" );
    assert_int_equal( scene.triangles.count, alone.triangles.count );
    assert_int_equal( scene.placement_count, 2 ); // with its handle
    assert_int_equal( scene.cameras[0].animated, 0 );
    assert_same_moments( &scene, &alone );
    rf_destroy_scene( &scene );
    // they go before those of the file, of which others stay
    scene = load_scene( "moving.glb", "\"objects\":[{\"node\":\"nodes[1]\",\"interpolation\":\"linear\",\"keys\":[{\"time\":1,"
                                      "\"translation\":[2,0,0]},{\"time\":2,\"translation\":[2,0,8]}]}]" );
    RfPosedScene pose = gltf_pose_at( &scene, 2.0 ); // half a turn about y
    gltf_assert_placed_corner( &pose.scene, scene.placements[0].first, 1, 1, 0, 8 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
    scene = load_scene( "moving.glb", "\"objects\":[{\"node\":\"Door\",\"rotation\":{\"yaw\":90}}]" );
    assert_null( scene.movement );
    gltf_assert_corner( &scene, 4, 2, 0, -1 );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &alone );
}

TEST( test_smooth_keys_are_those_of_cameras )
{
    static const char* const s_how[] = { "catmull-rom", "linear" };
    for ( int k = 0; k < 2; ++k )
    {
        char members[1024], path[1024];
        snprintf(
            path, sizeof path,
            "{\"kind\":\"keyed\",\"interpolation\":\"%s\",\"keys\":[{\"time\":0,\"position\":[0,0,0],\"rotation\":{\"yaw\":0}},"
            "{\"time\":1,\"position\":[3,1,0],\"rotation\":{\"yaw\":90,\"pitch\":10}},"
            "{\"time\":3,\"position\":[3,5,2],\"rotation\":{\"yaw\":200,\"roll\":30}}]}",
            s_how[k] );
        snprintf( members, sizeof members,
                  "\"objects\":[{\"node\":\"Door\",\"interpolation\":\"%s\",\"keys\":[{\"time\":0,\"translation\":[0,0,0],"
                  "\"rotation\":{\"yaw\":0}},{\"time\":1,\"translation\":[3,1,0],\"rotation\":{\"yaw\":90,\"pitch\":10}},"
                  "{\"time\":3,\"translation\":[3,5,2],\"rotation\":{\"yaw\":200,\"roll\":30}}]}]",
                  s_how[k] );
        RfCamera camera = load_path( path );
        RfScene scene = load_scene( "room.glb", members );
        for ( int i = 0; i <= 12; ++i )
        {
            RfView view = view_at( &camera, 0.25 * i );
            RfPosedScene pose = gltf_pose_at( &scene, 0.25 * i );
            const double *m = pose.scene.placements[0].matrix.m, *at = view.position;
            for ( int c = 0; c < 3; ++c )
            {
                assert_close( m[12 + c], at[c], 1e-12 );
                assert_close( m[4 + c], view.up[c], 1e-12 );
                assert_close( m[8 + c], -view.forward[c], 1e-12 );
            }
            rf_destroy_pose( &pose );
        }
        rf_destroy_scene( &scene );
        rf_destroy_camera( &camera );
    }
}

TEST( test_a_node_with_a_matrix )
{
    RfScene scene = load_scene(
        "room.glb", "\"objects\":[{\"node\":\"nodes[4]\",\"translation\":[0,7,0],\"rotation\":[0,0,0,1],\"scale\":2}]" );
    gltf_assert_corner( &scene, 6, 0, 7, 0 );
    gltf_assert_corner( &scene, 7, 2, 7, 0 );
    rf_destroy_scene( &scene );
}

TEST( test_a_node_that_carries_a_camera )
{
    RfScene scene =
        load_scene( "room.glb", "\"objects\":[{\"node\":\"Eye\",\"keys\":[{\"time\":1,\"translation\":[0,0,5]},{\"time\":3,"
                                "\"translation\":[0,1,5]}]}]" );
    assert_true( scene.cameras[0].animated && scene.cameras[0].start == 1.0 && scene.cameras[0].end == 3.0 );
    rf_destroy_scene( &scene );
}

TEST( test_what_is_shown )
{
    RfScene scene = load_scene( "room.glb", "\"objects\":[{\"node\":\"Door\",\"visible\":false}]" );
    assert_int_equal( scene.triangles.count, 2 ); // nor what is below it
    assert_null( scene.movement );
    rf_destroy_scene( &scene );
    const char* keyed = "\"objects\":[{\"node\":\"Door\",\"keys\":[{\"time\":0,\"visible\":false},{\"time\":1,\"visible\":true},"
                        "{\"time\":2,\"visible\":false}]},{\"file\":\"figure.glb\",\"keys\":[{\"time\":0,\"visible\":true},"
                        "{\"time\":1,\"visible\":false}]},{\"file\":\"figure.glb\",\"visible\":false}]";
    scene = load_scene( "room.glb", keyed );
    for ( int k = -1; k <= 5; ++k )
    {
        double time = 0.5 * k;
        RfPosedScene pose = gltf_pose_at( &scene, time );
        assert_int_equal( pose.scene.placement_count, 6 );
        for ( int i = 0; i < 6; ++i )
            assert_int_equal( pose.scene.placements[i].shown, i < 2 ? time >= 1.0 && time < 2.0 : time < 1.0 );
        rf_destroy_pose( &pose );
    }
    rf_destroy_scene( &scene );
    // frozen, as they begin
    RfError error = { 0 };
    assert_int_equal( try_scene( "room.glb", keyed, true, &scene, &error ), RF_OK );
    assert_int_equal( rf_triangle_count( &scene ), 2 + 4 );
    rf_destroy_scene( &scene );
}

// ---- Files that are placed ------------------------------------------------------

TEST( test_a_still_file_is_part_of_the_scene )
{
    RfScene room = load_alone( "room.glb" ),
            scene = load_scene( "room.glb", "\"objects\":[{\"file\":\"room.glb\",\"translation\":[0,0,-3],\"scale\":[1,2,1],"
                                            "\"rotation\":{\"yaw\":90}}]" );
    assert_null( scene.movement );
    assert_int_equal( scene.placement_count, 0 );
    assert_int_equal( scene.triangles.count, 2 * room.triangles.count );
    assert_int_equal( scene.camera_count, 1 );
    assert_int_equal( scene.material_count, 2 * room.material_count );
    assert_int_equal( scene.instance_count, 2 * room.instance_count );
    assert_true( scene.content_hash != room.content_hash );
    gltf_assert_corner( &scene, 14, 0, 2, -3 );
    gltf_assert_corner( &scene, 13, 0, 0, -4 );
    gltf_assert_corner( &scene, 16, 0, 0, -6 ); // of the door
    assert_int_equal( scene.triangles.material[3], 0 );
    assert_int_equal( scene.triangles.material[4], room.material_count );
    assert_true( (double)scene.bounds_min.z == -13.0 && (double)scene.bounds_max.y == 2.0 && (double)scene.bounds_max.x == 10.0 );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &room );
}

TEST( test_as_if_by_gltf_alone )
{
    GltfBuilder b = { 0 };
    static const float s_times[] = { 0, 2 }, s_moves[] = { 0, 0, 0, 8, 4, 2 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "VEC3", 3, 2, s_moves );
    GltfBuilder copy = b;
    write_glb( "leaf.glb", &b, "\"nodes\":[{\"mesh\":0}],\"materials\":[{}],\"meshes\":[" TRIANGLE "]" );
    write_glb(
        "leaves.glb", &copy,
        "\"nodes\":[{\"mesh\":0},{\"children\":[2],\"scale\":[1,2,1]},{\"mesh\":0}],\"materials\":[{}],\"meshes\":[" TRIANGLE
        "]," ANIMATE( "translation" ) "\"extras\":0" );
    RfScene alone = load_alone( "leaves.glb" ),
            scene = load_scene( "leaf.glb",
                                "\"objects\":[{\"file\":\"leaf.glb\",\"scale\":[1,2,1],\"interpolation\":\"linear\","
                                "\"keys\":[{\"time\":0,\"translation\":[0,0,0]},{\"time\":2,\"translation\":[8,4,2]}]}]" );
    assert_int_equal( scene.placement_count, alone.placement_count );
    assert_int_equal( scene.placements[0].first, alone.placements[0].first );
    assert_same_moments( &scene, &alone );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &alone );
}

// That mover `i` of one pose is that of another, further along x.
static void assert_same_mover( const RfPosedScene* a, int i, const RfPosedScene* b, int j, double x )
{
    const RfPlacement *left = a->scene.placements + i, *right = b->scene.placements + j;
    assert_int_equal( left->shown, right->shown );
    assert_int_equal( a->scene.meshes[left->mesh].triangles.count, b->scene.meshes[right->mesh].triangles.count );
    for ( int c = 0; left->shown && c < 3; ++c )
    {
        double p[3];
        gltf_find_placed_corner( &b->scene, right->first, c, p );
        gltf_assert_placed_corner( &a->scene, left->first, c, p[0] + x, p[1], p[2] );
    }
}

#define TWICE                                                                                                                    \
    "\"objects\":[{\"file\":\"figure.glb\",\"translation\":[10,0,0],\"animation\":\"Go\",\"start\":2,\"speed\":2,\"repeat\":"    \
    "\"loop\"},"                                                                                                                 \
    "{\"file\":\"figure.glb\",\"translation\":[20,0,0],\"animation\":\"Go\",\"start\":-0.25,\"repeat\":\"hold\"}]"

TEST( test_a_file_twice_at_other_times )
{
    RfScene alone = load_alone( "figure.glb" ), scene = load_scene( "figure.glb", TWICE );
    assert_int_equal( alone.placement_count, 3 );
    assert_int_equal( scene.placement_count, 9 );
    assert_int_equal( scene.triangles.count, 3 );
    assert_int_equal( scene.still_placement_count, 0 );
    assert_true( scene.movement->start == 0.0 && scene.movement->end == 2.5 );
    for ( int k = -2; k <= 16; ++k )
    {
        double time = 0.25 * k + 0.0625, played = fmax( ( time - 2.0 ) * 2.0, 0.0 );
        RfPosedScene all = gltf_pose_at( &scene, time ), own = gltf_pose_at( &alone, time ),
                     looped = gltf_pose_at( &alone, 0.5 + fmod( played, 1.0 ) ),
                     held = gltf_pose_at( &alone, 0.5 + fmin( fmax( time + 0.25, 0.0 ), 1.0 ) );
        for ( int i = 0; i < 3; ++i )
        {
            assert_same_mover( &all, i, &own, i, 0.0 );
            assert_same_mover( &all, 3 + i, &looped, i, 10.0 );
            assert_same_mover( &all, 6 + i, &held, i, 20.0 );
        }
        rf_destroy_pose( &all );
        rf_destroy_pose( &own );
        rf_destroy_pose( &looped );
        rf_destroy_pose( &held );
    }
    rf_destroy_scene( &scene );
    rf_destroy_scene( &alone );
}

#define MANY 2000 // triangles of a mesh
#define PLACES 400

// Instances that save enough memory to be placed, in a scene where others move.
TEST( test_instances_come_before_what_moves )
{
    GltfBuilder b = { 0 };
    uint8_t indices[3 * MANY];
    float places[3 * PLACES];
    for ( int i = 0; i < 3 * MANY; ++i )
        indices[i] = (uint8_t)( i % 3 );
    for ( int i = 0; i < 3 * PLACES; ++i )
        places[i] = (float)( i / 3 );
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    add_gltf_accessor( &b, 5121, "SCALAR", 3 * MANY, indices, sizeof indices, "" );
    add_gltf_floats( &b, "VEC3", 3, PLACES, places );
    write_glb( "many.glb", &b,
               "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\"nodes\":[{\"mesh\":0,\"extensions\":{"
               "\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2}}}}],"
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]" );
    RfScene alone = load_alone( "moving.glb" ),
            scene = load_scene( "moving.glb", "\"objects\":[{\"file\":\"figure.glb\",\"animation\":\"Go\"},"
                                              "{\"file\":\"many.glb\",\"translation\":[0,0,9]}]" );
    assert_int_equal( scene.placement_count, PLACES + 2 + 3 );
    assert_int_equal( scene.still_placement_count, PLACES );
    for ( int i = 0; i < scene.placement_count; ++i )
        assert_int_equal( scene.placements[i].mover, i < PLACES ? -1 : i - PLACES );
    for ( int i = 0; i < PLACES; i += 57 )
        gltf_assert_placed_corner( &scene, scene.triangles.count + (uint32_t)( i * MANY + 5 ), 1, i + 1, i, i + 9 );
    RfPosedScene pose = gltf_pose_at( &scene, 1.5 ), own = gltf_pose_at( &alone, 1.5 );
    for ( int i = 0; i < 2; ++i )
        assert_same_mover( &pose, PLACES + i, &own, i, 0.0 );
    rf_destroy_pose( &pose );
    rf_destroy_pose( &own );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &alone );
}

TEST( test_materials_and_textures_are_their_own )
{
    RfScene scene =
        load_scene( "figure.glb", "\"objects\":[{\"file\":\"figure.glb\",\"materials\":{\"stone\":{\"baseColorFactor\":"
                                  "[1,0,0,1],\"metallicFactor\":0}}}]" );
    int count = (int)scene.material_count / 2;
    assert_int_equal( scene.texture_count, 2 );
    const char* const names[] = { "fur", "stone" };
    for ( int i = 0; i < 2 * count; ++i )
    {
        const RfMaterial* m = scene.materials + i;
        if ( i % count < 2 )
            assert_string_equal( m->name, names[i % count] );
        if ( i % count == 0 )
            assert_int_equal( m->textured->refs[RF_TEXTURE_BASE].texture, i / count );
    }
    for ( uint32_t i = 0; i < rf_triangle_count( &scene ); ++i )
    {
        bool placed = i < 2 ? i == 1 : i >= 5; // two stones, then the movers of each
        assert_in_range( rf_material_of( &scene, i ), placed ? (uint32_t)count : 0,
                         placed ? 2 * (uint32_t)count - 1 : (uint32_t)count - 1 );
    }
    assert_true( (double)scene.materials[count + 1].diffuse.y < 0.1 );
    rf_destroy_scene( &scene );
}

TEST( test_which_animation )
{
    RfScene scene = load_scene( "room.glb", "\"objects\":[{\"file\":\"figure.glb\",\"animation\":\"Grow\",\"speed\":4}]" );
    assert_int_equal( scene.placement_count, 1 ); // the disc alone, with Go left out whole
    assert_true( scene.movement->start == 0.0 && scene.movement->end == 0.25 );
    assert_string_equal( s_warnings, "" );
    rf_destroy_scene( &scene );
    scene = load_scene( "room.glb", "\"objects\":[{\"file\":\"figure.glb\"},{\"file\":\"figure.glb\"}]" );
    char* first = strstr( s_warnings, "animation 'Go' is used" );
    assert_non_null( first );
    assert_null( strstr( first + 1, "animation 'Go' is used" ) ); // of a file once
    rf_destroy_scene( &scene );
    scene = load_scene( "room.glb", "\"objects\":[{\"file\":\"figure.glb\",\"animation\":\"Grow\"},{\"file\":\"figure.glb\"}]" );
    assert_non_null( strstr( s_warnings, "animation 'Go' is used" ) );
    rf_destroy_scene( &scene );
}

TEST( test_what_a_placed_file_leaves_behind )
{
    GltfBuilder b = { 0 };
    write_glb(
        "sky.glb", &b,
        "\"scenes\":[{\"nodes\":[0],\"extras\":{\"reframe\":{\"environment\":{\"radiance\":[1,1,1]},\"export_losses\":[\"a "
        "loss\"],\"export_warnings\":[\"a warning\"]}}}],"
        "\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\","
        "\"name\":\"Sun\"}]}},\"nodes\":[{\"translation\":[0,1,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]" );
    RfScene scene = load_scene(
        "room.glb", "\"objects\":[{\"file\":\"sky.glb\",\"translation\":[1,2,3]},{\"file\":\"sky.glb\",\"name\":\"sky\","
                    "\"keys\":[{\"time\":0,\"translation\":[0,0,0]},{\"time\":1,\"translation\":[1,0,0]}]}]" );
    assert_non_null( strstr( s_warnings, "objects[0]: the environment of 'sky.glb' is left out" ) );
    assert_int_equal( scene.punctual_count, 2 );
    gltf_assert_rgb( scene.punctuals[0].position, 1, 3, 3 );
    assert_int_equal( scene.unrendered_count, 0 );
    RfPosedScene pose = gltf_pose_at( &scene, 0.5 ); // the lamp of the second goes with it
    gltf_assert_rgb( pose.scene.punctuals[0].position, 1, 3, 3 );
    gltf_assert_rgb( pose.scene.punctuals[1].position, 0.5, 1, 0 );
    rf_destroy_pose( &pose );
    assert_string_equal( scene.export_losses[1], "sky: a loss" );
    assert_string_equal( scene.export_warnings[1], "sky: a warning" );
    rf_destroy_scene( &scene );
}

#define POINTER( sampler, pointer )                                                                                              \
    "{\"sampler\":" sampler                                                                                                      \
    ",\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"" pointer "\"}}}}"

// A lamp and a material that dim and one that changes, twice: in the second the last stands still, since the scene file says what
// it is, and all goes twice as fast.
TEST( test_what_changes_in_placed_files )
{
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    add_gltf_floats( &b, "SCALAR", 1, 2, ( const float[] ){ 0, 2 } );
    add_gltf_floats( &b, "SCALAR", 1, 2, ( const float[] ){ 0, 1 } );
    write_glb( "dims.glb", &b,
               "\"nodes\":[{\"mesh\":0},{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],\"extensions\":{"
               "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}},\"materials\":[{\"emissiveFactor\":[1,1,1]},{"
               "\"name\":"
               "\"shiny\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0},{\"attributes\":{"
               "\"POSITION\":0},\"material\":1}]}],\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":"
               "[" POINTER( "0", "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength" ) "," POINTER(
                   "0", "/materials/1/pbrMetallicRoughness/roughnessFactor" ) "," POINTER( "0", "/extensions/KHR_lights_punctual/"
                                                                                                "lights/0/intensity" ) "]}]" );
    RfScene scene = load_scene( "room.glb", "\"objects\":[{\"file\":\"dims.glb\"},{\"file\":\"dims.glb\",\"speed\":2,"
                                            "\"materials\":{\"shiny\":{\"roughnessFactor\":0.5}}}]" );
    uint32_t first = scene.material_count - 4;
    assert_int_equal( scene.unrendered_count, 0 );
    assert_int_equal( scene.movement->change_count, 5 );
    assert_int_equal( scene.placement_count, 1 );
    for ( int k = 0; k <= 4; ++k )
    {
        double t[2] = { 0.125 * k, 0.25 * k };
        RfPosedScene pose = gltf_pose_at( &scene, 0.25 * k );
        const RfMaterial* m = pose.scene.materials + first;
        for ( int i = 0; i < 2; ++i )
        {
            gltf_assert_rgb( pose.scene.punctuals[i].intensity, t[i], t[i], t[i] );
            gltf_assert_rgb( m[2 * i].emission, t[i], t[i], t[i] );
        }
        gltf_assert_near( m[1].alpha, fmax( t[0] * t[0], 1e-3 ) );
        gltf_assert_near( m[3].alpha, 0.25 );
        rf_destroy_pose( &pose );
    }
    assert_true( scene.materials[first + 1].changes && !scene.materials[first + 3].changes );
    rf_destroy_scene( &scene );
}

TEST( test_the_origin_is_that_of_the_scene )
{
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    write_glb( "far.glb", &b,
               "\"nodes\":[{\"mesh\":0,\"translation\":[1000000.125,0,0]}],\"materials\":[{}],\"meshes\":[" TRIANGLE "]" );
    RfScene scene = load_scene( "far.glb", "\"objects\":[{\"file\":\"room.glb\",\"translation\":[1000000.25,0,0]}]" );
    assert_true( scene.origin[0] > 999000.0 );
    gltf_assert_corner( &scene, 3, 1000000.25 - scene.origin[0], 0, 0 );
    rf_destroy_scene( &scene );
}

// ---- Frames ---------------------------------------------------------------------

static RfResult try_path( const RfScene* scene, RfFps fps, const char* camera, RfCameraPath* path, RfError* error )
{
    RfPathOptions options = { .camera = camera, .fps = fps, .width = 8, .height = 8 };
    return rf_create_camera_path( scene, &options, path, error );
}

#define DOOR                                                                                                                     \
    "\"objects\":[{\"node\":\"Door\",\"keys\":[{\"frame\":1,\"translation\":[2,0,0]},{\"frame\":11,\"translation\":[3,0,0]}]}]"
#define PATH( lens )                                                                                                             \
    "\"camera\":{\"kind\":\"keyed\",\"step\":5,\"target\":[0,0,0]," lens "\"keys\":[{\"frame\":6,\"position\":[0,0,5]},"         \
    "{\"frame\":16,\"position\":[0,1,5]}]}"

TEST( test_frames_of_keys )
{
    RfCameraPath path;
    RfError error = { 0 };
    RfScene scene = load_scene( "room.glb", "\"render\":{\"fps\":\"30000/1001\"}," DOOR "," PATH( "" ) );
    assert_int_equal( try_path( &scene, ( RfFps ){ 0 }, NULL, &path, &error ), RF_OK );
    assert_int_equal( path.count, 3 ); // 6, 11, 16: the door reaches its last key in the second
    assert_int_equal( path.first, 6 );
    for ( int i = 0; i < 3; ++i )
        assert_true( path.eyes[i].time == ( 5.0 * i + 5.0 ) * 1001.0 / 30000.0 );
    assert_true( path.eyes[1].time == scene.movement->end );
    rf_destroy_camera_path( &path );
    assert_int_equal( try_path( &scene, ( RfFps ){ 24, 1 }, NULL, &path, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "keys of the scene count frames, at 29.97 frames per second rather than 24" ) );
    rf_destroy_scene( &scene );
    // the glTF asks for others than 24
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    write_glb( "shot.glb", &b,
               "\"scenes\":[{\"nodes\":[0],\"extras\":{\"reframe\":{\"render\":{\"fps\":10}}}}],"
               "\"nodes\":[{\"name\":\"Door\",\"mesh\":0}],\"materials\":[{}],\"meshes\":[" TRIANGLE "]" );
    scene = load_scene( "shot.glb", DOOR );
    assert_true( scene.movement->end == 1.0 && scene.key_fps.numerator == 10 );
    rf_destroy_scene( &scene );
    // in the middle of a shutter
    scene = load_scene( "room.glb", DOOR "," PATH( "\"lens\":{\"shutter\":[0,1]}," ) );
    assert_int_equal( try_path( &scene, ( RfFps ){ 0 }, NULL, &path, &error ), RF_OK );
    assert_close( path.eyes[1].time, 10.5 / 24.0, 1e-12 );
    rf_destroy_camera_path( &path );
    rf_destroy_scene( &scene );
}

TEST( test_frozen_as_the_camera_begins )
{
    RfScene scene;
    RfError error = { 0 };
    const char* members = "\"camera\":{\"kind\":\"keyed\",\"target\":[0,0,0],\"keys\":[{\"frame\":49,\"position\":[0,0,5]},"
                          "{\"frame\":60,\"position\":[0,1,5]}]},\"objects\":[{\"file\":\"figure.glb\",\"start\":2,"
                          "\"animation\":\"Go\",\"speed\":0.001},{\"file\":\"figure.glb\",\"start\":1.5,\"animation\":\"Go\"}]";
    assert_int_equal( try_scene( "moving.glb", members, true, &scene, &error ), RF_OK );
    assert_true( scene.frozen );
    assert_null( scene.movement );
    // at 2 s: half a turn of the door, the one disc as it begins, the other halfway
    bool turned = false, began = false, halfway = false;
    for ( uint32_t i = 0; i < scene.triangles.count; ++i )
    {
        RfVec3 p = rf_corner( &scene.triangles, i, 0 ), q = rf_corner( &scene.triangles, i, 1 );
        turned = turned || ( fabs( (double)p.x - 2.0 ) < 1e-6 && fabs( (double)q.x - 1.0 ) < 1e-6 );
        began = began || ( fabs( (double)p.x ) < 1e-6 && fabs( (double)p.y ) < 1e-6 && p.z == 0.0f );
        halfway = halfway || ( fabs( (double)p.x - 1.0 ) < 1e-6 && fabs( (double)p.y - 2.0 ) < 1e-6 );
    }
    assert_true( turned && began && halfway );
    rf_destroy_scene( &scene );
}

TEST( test_what_loops_counts_one_round )
{
    RfCameraPath path;
    RfError error = { 0 };
    RfScene scene = load_scene( "room.glb", "\"objects\":[{\"file\":\"figure.glb\",\"start\":1,\"repeat\":\"loop\"}]" );
    assert_int_equal( try_path( &scene, ( RfFps ){ 24, 1 }, NULL, &path, &error ), RF_OK );
    assert_int_equal( path.count, 49 ); // from 0 s
    assert_true( path.eyes[24].time == 1.0 );
    rf_destroy_camera_path( &path );
    rf_destroy_scene( &scene );
}

// ---- Faults ---------------------------------------------------------------------

TEST( test_faults )
{
    static const char* const s_faults[][2] = {
        { "{}", "objects: must be an array" },
        { "[1]", "objects[0]: must be an object" },
        { "[{}]", "objects[0]: has neither node, one of the scene, nor file" },
        { "[{\"node\":\"Door\",\"file\":\"figure.glb\"}]", "objects[0].node: not together with file" },
        { "[{\"node\":\"Door\"}]", "objects[0]: changes nothing" },
        { "[{\"node\":\"Doro\",\"visible\":false}]",
          "objects[0].node: the scene has no such node: did you mean 'Door'? there are" },
        { "[{\"node\":\"Leaf\",\"visible\":false}]", "2 nodes are called 'Leaf': give the number of one: nodes[4], nodes[5]" },
        { "[{\"node\":\"Door\",\"visible\":true},{\"node\":\"nodes[1]\",\"scale\":2}]",
          "objects[1]: sets 'nodes[1]', as objects[0] does" },
        { "[{\"node\":\"nodes[4]\",\"scale\":2}]", "has a matrix in the file: give it translation, rotation and scale" },
        { "[{\"node\":\"Eye\",\"visible\":false}]", "objects[0]: 'Eye' has nothing that could be hidden" },
        { "[{\"node\":\"Door\",\"start\":2}]", "objects[0].start: unknown key" },
        { "[{\"node\":\"Door\",\"scale\":\"big\"}]", "objects[0].scale: must be a number or an array of 3 numbers, got \"big\"" },
        { "[{\"node\":\"Door\",\"rotation\":[1,2,3]}]", "objects[0].rotation: must be an array of 4 numbers" },
        { "[{\"node\":\"Door\",\"visible\":1}]", "objects[0].visible: must be true or false" },
        { "[{\"node\":\"Door\",\"scale\":2,\"interpolation\":\"linear\"}]", "interpolation: has no effect without keys" },
        { "[{\"node\":\"Door\",\"keys\":[]}]", "objects[0].keys: must be an array of 1" },
        { "[{\"node\":\"Door\",\"keys\":[{\"time\":1}]}]", "objects[0].keys[0]: has no translation, rotation, scale or visible" },
        { "[{\"node\":\"Door\",\"keys\":[{\"scale\":1}]}]", "objects[0].keys[0].time: is missing" },
        { "[{\"node\":\"Door\",\"keys\":[{\"time\":1,\"scale\":1},{\"frame\":2,\"scale\":1}]}]",
          "objects[0].keys[1].frame: unknown key" },
        { "[{\"node\":\"Door\",\"keys\":[{\"time\":1,\"scale\":1},{\"time\":1,\"scale\":1}]}]",
          "objects[0].keys[1].time: 1 is not later" },
        { "[{\"node\":\"Door\",\"scale\":1,\"keys\":[{\"time\":1,\"scale\":1}]}]", "objects[0].scale: keys have it too" },
        { "[{\"file\":\"x.json\"}]", "objects[0].file: must be a .glb or .gltf file: scene files do not nest" },
        { "[{\"file\":\"none.glb\"}]", "objects[0].file: " },
        { "[{\"file\":\"figure.glb\",\"animation\":\"Run\"}]", "objects[0].animation: " },
        { "[{\"file\":\"figure.glb\",\"animation\":\"Run\"}]", "none is called 'Run': there are 'Go', 'Grow'" },
        { "[{\"file\":\"figure.glb\",\"variant\":\"Red\"}]", "objects[0].variant: " },
        { "[{\"file\":\"figure.glb\",\"variant\":\"Red\"}]", "none is called 'Red': there are none" },
        { "[{\"file\":\"room.glb\",\"speed\":2}]", "objects[0].speed: 'room.glb' has no animation" },
        { "[{\"file\":\"figure.glb\",\"speed\":0}]", "objects[0].speed: must be a number from 1e-06 to 1e+06, got 0" },
        { "[{\"file\":\"figure.glb\",\"repeat\":\"twice\"}]", "objects[0].repeat: must be one of hold, loop" },
        { "[{\"file\":\"figure.glb\",\"materials\":{\"ston\":{}}}]",
          "objects[0].materials.ston: the scene has no such material" },
    };
    for ( size_t i = 0; i < sizeof s_faults / sizeof s_faults[0]; ++i )
        expect_fault( s_faults[i][0], s_faults[i][1] );
    cli_write( "broken.glb", "{\"asset\":{\"version\":\"2.0\"},\"nodes\":7}", 37 );
    expect_fault( "[{\"file\":\"broken.glb\",\"scale\":2}]", "broken.glb: document: nodes must be an array" );
}

// Nodes that stay where they are whatever is set.
TEST( test_moves_without_effect )
{
    static const char s_camera[] = "{\"asset\":{\"version\":\"2.0\"},\"cameras\":[{\"type\":\"perspective\",\"perspective\":{"
                                   "\"yfov\":0.8,\"znear\":0.1}}],\"nodes\":[{\"name\":\"Eye\",\"camera\":0,\"extras\":{"
                                   "\"reframe\":{\"path\":{\"kind\":\"zoom\"}}}}]}";
    RfScene scene;
    RfError error = { 0 };
    cli_write( "eye.gltf", s_camera, sizeof s_camera - 1 );
    assert_int_equal( try_scene( "eye.gltf", "\"objects\":[{\"node\":\"Eye\",\"translation\":[0,1,0]}]", false, &scene, &error ),
                      RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "objects[0]: 'Eye' is a camera with a path of its own" ) );
    assert_int_equal( try_scene( "figure.glb", "\"objects\":[{\"node\":\"Arm\",\"scale\":2}]", false, &scene, &error ),
                      RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "objects[0]: 'Arm' has a skin" ) );
    scene = load_scene( "figure.glb", "\"objects\":[{\"node\":\"Arm\",\"visible\":false}]" );
    rf_destroy_scene( &scene );
}

// What is put under a node before it is checked.
TEST( test_broken_files )
{
    static const char s_scene[] =
        "{\"scene\":\"room.glb\",\"objects\":[{\"file\":\"broken.glb\",\"scale\":2,\"keys\":["
        "{\"time\":0,\"translation\":[0,0,0]},{\"time\":1,\"translation\":[1,0,0]}],\"repeat\":\"loop\"}]}";
    const char* many = getenv( "REFRAME_MUTATIONS" );
    uint64_t count = many != NULL ? (uint64_t)atoll( many ) : MUTATIONS;
    size_t size;
    char* whole = cli_read( "figure.glb", &size );
    char* bytes = malloc( size );
    int loaded = 0;
    write_text( "scene.json", s_scene );
    for ( uint64_t i = 0; i < count; ++i )
    {
        RfScene scene;
        RfError error = { 0 };
        memcpy( bytes, whole, size );
        cli_write( "broken.glb", bytes, mutate_bytes( (uint8_t*)bytes, size, 3 * ( i + 1 ) ) );
        RfResult result = load_named( "scene.json", &scene, &error );
        if ( result != RF_OK && ( strstr( error.text, "broken.glb" ) == NULL || strchr( error.text, '\n' ) != NULL ) )
            fail_msg( "%llu: '%s'", (unsigned long long)i, error.text );
        loaded += result == RF_OK;
        rf_destroy_scene( &scene );
    }
    assert_in_range( loaded, 1, count - 1 );
    free( bytes );
    free( whole );
}

static int enter( void** state )
{
    (void)state;
    cli_enter();
    write_door( "room.glb", "" );
    write_door( "moving.glb", ANIMATE( "rotation" ) );
    write_figure();
    return 0;
}

SHARED_BY_TESTS( enter, cli_leave_group )
