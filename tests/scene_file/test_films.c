// Image sequences as textures, and materials with keys: in scene files, in the extras of a glTF, and in poses.
#include "support/cli_run.h"
#include "support/image_files.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "scene/texture.h"
#include "scene/movement.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Files ----------------------------------------------------------------------

static void write_png( const char* name, int width, uint8_t grey )
{
    uint8_t pixels[3 * 64];
    size_t size;
    memset( pixels, grey, sizeof pixels );
    uint8_t* bytes = encode_png( width, 1, 3, pixels, &size );
    cli_write( name, bytes, size );
    free( bytes );
}

// film.1.png to film.4.png: black, dark, bright and white, of different sizes.
static void write_film( void )
{
    write_png( "film.1.png", 4, 0 );
    write_png( "film.2.png", 64, 51 );
    write_png( "film.3.png", 1, 204 );
    write_png( "film.4.png", 2, 255 );
}

#define FILM( more ) "{\"frames\":\"film.#.png\",\"last\":4,\"fps\":10" more "}"

// room.glb: a wall of "paint" and a screen of "Screen", with coordinates, and an image of which `image` says more.
static void write_screen( const char* image, const char* rest )
{
    static const float s_corners[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, s_uvs[] = { 0, 0, 1, 0, 0, 1 }, s_keys[] = { 0, 1 };
    GltfBuilder b = { 0 };
    char text[4096];
    size_t size;
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    add_gltf_floats( &b, "VEC2", 2, 3, s_uvs );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_keys ); // times, and values of OWN
    add_gltf_floats( &b, "SCALAR", 1, 2, s_keys );
    snprintf( text, sizeof text,
              "\"images\":[{\"uri\":\"film.2.png\"%s}],\"samplers\":[{\"magFilter\":9728}],"
              "\"textures\":[{\"sampler\":0,\"source\":0}],\"nodes\":[{\"mesh\":0},{\"name\":\"Tv\",\"mesh\":1}],"
              "\"materials\":[{\"name\":\"paint\"},{\"name\":\"Screen\",\"emissiveFactor\":[1,1,1],"
              "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],\"meshes\":["
              "{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":0}]},"
              "{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":1}]}]%s",
              image, rest );
    uint8_t* bytes = build_glb( &b, text, &size );
    cli_write( "room.glb", bytes, size );
    free( bytes );
}

static RfResult try_scene( const char* members, bool freeze, RfScene* scene, RfError* error )
{
    char text[4096], path[256];
    RfSceneOptions options = { .freeze = freeze };
    snprintf( text, sizeof text, "{\"scene\":\"room.glb\",%s}", members );
    write_text( "scene.json", text );
    snprintf( path, sizeof path, "%s/scene.json", cli_folder() );
    memset( scene, 0, sizeof *scene );
    return rf_load_scene_with( path, &options, scene, NULL, error );
}

static RfScene load_scene( const char* members )
{
    RfScene scene;
    RfError error = { 0 };
    if ( try_scene( members, false, &scene, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return scene;
}

static void expect_fault( const char* members, const char* part )
{
    RfScene scene;
    RfError error = { 0 };
    RfResult result = try_scene( members, false, &scene, &error );
    if ( result == RF_OK || result != error.code || strstr( error.text, part ) == NULL || strchr( error.text, '\n' ) != NULL )
        fail_msg( "'%s' gave %s '%s' instead of '%s'", members, rf_result_name( result ), error.text, part );
    assert_null( scene.path );
}

// ---- When which image is shown --------------------------------------------------

TEST( test_numbers )
{
    RfImageSequence s = { .first = 7, .last = 10, .start = 0.5, .fps = 10.0 };
    static const double s_times[] = { -1, 0.5, 0.59995, 0.6, 0.85, 0.9, 99 };
    static const int s_held[] = { 7, 7, 8, 8, 10, 10, 10 }, s_looped[] = { 7, 7, 8, 8, 10, 7, 8 };
    for ( int i = 0; i < 7; ++i )
    {
        s.loops = false;
        assert_int_equal( rf_sequence_number( &s, s_times[i] ), s_held[i] );
        s.loops = true;
        if ( i < 6 )
            assert_int_equal( rf_sequence_number( &s, s_times[i] ), s_looped[i] );
    }
    // a frame shows its image, whatever its time is rounded to
    s = ( RfImageSequence ){ .first = 1, .last = 100000, .fps = 30000.0 / 1001.0 };
    for ( int frame = 1; frame <= 100000; frame += 7 )
        assert_int_equal( rf_sequence_number( &s, (double)(float)( ( frame - 1.0 ) * 1001.0 / 30000.0 ) ), frame );
    double start, end;
    s = ( RfImageSequence ){ .first = 7, .last = 10, .start = -0.1, .fps = 10.0 };
    rf_sequence_span( &s, &start, &end );
    assert_true( start == 0.0 && fabs( end - 0.2 ) < 1e-12 );
}

// ---- Films ----------------------------------------------------------------------

static double seen( const RfScene* scene, int texture )
{
    float rgba[4];
    RfTextureRef ref = { .texture = texture };
    rf_look_up( scene->textures + texture, &ref, ( const float[] ){ 0.5f, 0.5f }, 0.0f, rgba );
    return (double)rgba[0];
}

static double linear( int grey ) { return (double)rf_srgb_to_linear( (float)grey / 255.0f ); }

static void check_poses( const RfScene* scene, int texture )
{
    static const int s_greys[] = { 0, 51, 204, 255 };
    size_t bytes = rf_pose_bytes( scene );
    RfPosedScene pose = { .memory = aligned_alloc( 64, bytes ) };
    RfError error = { 0 };
    uint64_t hash, before = 0;
    memset( pose.memory, 0xa5, bytes );
    for ( int k = 0; k < 12; ++k )
    {
        double time = 0.05 * k - 0.1;
        int image = k < 2 ? 0 : k >= 8 ? 3 : ( k - 2 ) / 2;
        assert_int_equal( rf_pose_scene( scene, time, &pose, &error ), RF_OK );
        assert_close( seen( &pose.scene, texture ), linear( s_greys[image] ), 1e-6 );
        assert_close( (double)pose.scene.textures[texture].largest, linear( s_greys[image] ), 1e-6 );
        assert_int_equal( rf_moment_hash( scene, time, &hash, &error ), RF_OK );
        assert_true( hash == pose.hash );
        bool changed = k == 4 || k == 6 || k == 8;
        assert_true( k == 0 || ( hash != before ) == changed );
        before = hash;
    }
    void* memory = pose.memory;
    rf_destroy_pose( &pose );
    free( memory );
}

#define EMISSIVE( film ) "\"materials\":{\"Screen\":{\"emissiveTexture\":" film "}}"

TEST( test_a_screen_plays )
{
    RfScene scene = load_scene( EMISSIVE( FILM( "" ) ) );
    assert_int_equal( scene.movement->sequence_count, 1 );
    assert_true( scene.movement->start == 0.0 && fabs( scene.movement->end - 0.3 ) < 1e-12 );
    assert_true( scene.materials[1].changes && !scene.materials[0].changes );
    // it is an object that moves, and the wall is not
    assert_int_equal( scene.triangles.count, 1 );
    assert_int_equal( scene.triangle_count, 2 );
    assert_int_equal( scene.placement_count - scene.still_placement_count, 1 );
    const RfMaterial* screen = scene.materials + 1;
    int texture = screen->textured->refs[RF_TEXTURE_EMISSIVE].texture, base = screen->textured->refs[RF_TEXTURE_BASE].texture;
    assert_int_equal( scene.movement->sequences[0].texture, texture );
    assert_close( seen( &scene, base ), linear( 51 ), 1e-6 );
    assert_false( scene.textures[base].plays );
    check_poses( &scene, texture );
    // black at first, but not at all times
    assert_true( rf_max_component( rf_mean_emission( &scene, screen, 1 ) ) > 0.0f );
    RfPosedScene pose = gltf_pose_at( &scene, 0.0 );
    assert_true( rf_max_component( rf_mean_emission( &pose.scene, pose.scene.materials + 1, 1 ) ) == 0.0f );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
}

TEST( test_what_a_film_keeps_of_a_texture )
{
    RfScene scene =
        load_scene( "\"render\":{\"fps\":8},\"materials\":{\"Screen\":{\"baseColorTexture\":{\"frames\":\"film.#.png\","
                    "\"first\":2,\"last\":3,\"start\":1,\"repeat\":\"loop\"}}}" );
    const RfTextureRef* ref = scene.materials[1].textured->refs + RF_TEXTURE_BASE;
    assert_true( ref->nearest ); // its sampler
    const RfImageSequence* s = scene.movement->sequences;
    assert_true( s->loops && s->start == 1.0 && s->fps == 8.0 && s->srgb );
    assert_int_equal( scene.texture_count, 1 ); // the image of the glTF is not decoded
    rf_destroy_scene( &scene );
    // one image is no sequence
    scene = load_scene( EMISSIVE( "{\"frames\":\"film.#.png\",\"first\":3,\"last\":3}" ) );
    assert_null( scene.movement );
    assert_close( seen( &scene, scene.materials[1].textured->refs[RF_TEXTURE_EMISSIVE].texture ), linear( 204 ), 1e-6 );
    rf_destroy_scene( &scene );
}

TEST( test_films_of_a_gltf )
{
    write_screen( ",\"extras\":{\"reframe\":" FILM( "" ) "}", "" );
    RfScene scene = load_scene( "\"about\":\"as it is\"" );
    assert_int_equal( scene.movement->sequence_count, 1 );
    check_poses( &scene, scene.materials[1].textured->refs[RF_TEXTURE_BASE].texture );
    rf_destroy_scene( &scene );
    write_screen( ",\"extras\":{\"reframe\":{\"frames\":\"../film.#.png\",\"last\":4}}", "" );
    expect_fault( "\"about\":\"\"", "room.glb: images[0]: " );
    expect_fault( "\"about\":\"\"", "../film.1.png: cannot be opened" );
    write_screen( ",\"extras\":{\"reframe\":{\"frames\":\"film.#.png\"}}", "" );
    expect_fault( "\"about\":\"\"", "room.glb: images[0].extras.reframe.last: is missing: must be the number of the last image" );
    write_screen( ",\"extras\":{\"reframe\":{\"frames\":\"film.#.png\",\"last\":5}}", "" );
    expect_fault( "\"about\":\"\"", "room.glb: images[0]: " );
    expect_fault( "\"about\":\"\"", "film.5.png: cannot be opened" );
    write_screen( "", "" );
}

TEST( test_films_are_placed )
{
    RfScene scene = load_scene( EMISSIVE( FILM( "" ) ) ",\"objects\":[{\"file\":\"room.glb\",\"translation\":[5,0,0]," EMISSIVE(
        FILM( ",\"start\":1" ) ) "}]" );
    assert_int_equal( scene.movement->sequence_count, 2 );
    assert_int_equal( scene.material_count, 4 );
    const RfImageSequence* second = scene.movement->sequences + 1;
    assert_int_equal( second->texture, scene.materials[3].textured->refs[RF_TEXTURE_EMISSIVE].texture );
    assert_true( scene.movement->start == 0.0 && fabs( scene.movement->end - 1.3 ) < 1e-12 );
    RfPosedScene pose = gltf_pose_at( &scene, 1.2 );
    assert_close( seen( &pose.scene, second->texture ), linear( 204 ), 1e-6 );
    assert_close( seen( &pose.scene, scene.movement->sequences[0].texture ), 1.0, 1e-6 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
}

TEST( test_films_are_frozen )
{
    RfScene scene;
    RfError error = { 0 };
    assert_int_equal( try_scene( EMISSIVE( FILM( ",\"start\":-0.25" ) ), true, &scene, &error ), RF_OK );
    assert_null( scene.movement );
    assert_true( scene.frozen && !scene.materials[1].changes );
    assert_int_equal( scene.triangles.count, 2 );
    assert_close( seen( &scene, scene.materials[1].textured->refs[RF_TEXTURE_EMISSIVE].texture ), linear( 204 ), 1e-6 );
    rf_destroy_scene( &scene );
}

TEST( test_images_are_of_the_content )
{
    RfScene scene = load_scene( EMISSIVE( FILM( "" ) ) );
    uint64_t hash = scene.content_hash;
    rf_destroy_scene( &scene );
    write_png( "film.3.png", 1, 205 );
    scene = load_scene( EMISSIVE( FILM( "" ) ) );
    assert_true( scene.content_hash != hash );
    // what changes behind the back of a render is found where it does not fit
    write_png( "film.3.png", 7, 204 );
    write_png( "film.2.png", 7, 51 );
    RfPosedScene pose = gltf_pose_at( &scene, 0.2 );
    rf_destroy_pose( &pose );
    cli_write( "film.3.png", "gone", 4 );
    RfError error = { 0 };
    assert_int_equal( rf_pose_scene( &scene, 0.2, &pose, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "film.3.png: not a PNG" ) );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
    write_film();
    scene = load_scene( EMISSIVE( "{\"frames\":\"film.#.png\",\"first\":3,\"last\":4}" ) );
    write_png( "film.3.png", 64, 204 );
    assert_int_equal( rf_pose_scene( &scene, 0.0, &pose, &error ), RF_ERROR_IO );
    assert_non_null( strstr( error.text, "film.3.png: has grown since the scene was read" ) );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
    write_film();
}

TEST( test_faults_of_films )
{
    static const char* const faults[][2] = {
        { "3", "scene.json: materials.Screen.emissiveTexture: must be an object, got 3" },
        { "{}", "emissiveTexture.frames: is missing: must be the name of a sequence, such as \"film.####.png\"" },
        { "{\"frames\":\"film.png\"}", "emissiveTexture.frames: must be the name of a sequence" },
        { "{\"frames\":\"#.film.#.png\",\"last\":4}", "emissiveTexture.frames: " },
        { "{\"frames\":\"film.#.png\"}", "emissiveTexture.last: is missing: must be the number of the last image" },
        { "{\"frames\":\"film.#.png\",\"last\":0}", "emissiveTexture.last: must be from 1, the first image, to 100000" },
        { "{\"frames\":\"film.#.png\",\"last\":100001}", "emissiveTexture.last: must be from 1, the first image, to 100000" },
        { "{\"frames\":\"film.#.png\",\"last\":1.5}", "emissiveTexture.last: must be a whole number, got 1.5" },
        { FILM( ",\"fps\":0" ), "duplicate" },
        { "{\"frames\":\"film.#.png\",\"last\":4,\"fps\":0}",
          "emissiveTexture.fps: must be a number from 1e-06 to 1e+06, got 0" },
        { FILM( ",\"repeat\":\"bounce\"" ), "emissiveTexture.repeat: must be one of hold, loop, got \"bounce\"" },
        { FILM( ",\"frame\":1" ), "emissiveTexture.frame: unknown key, did you mean frames?" },
        { "{\"frames\":\"film.#.png\",\"last\":5}", "scene.json: materials.Screen.emissiveTexture: " },
        { "{\"frames\":\"film.#.png\",\"last\":5}", "/film.5.png: cannot be opened" },
    };
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
    {
        char members[512];
        snprintf( members, sizeof members, "\"materials\":{\"Screen\":{\"emissiveTexture\":%s}}", faults[i][0] );
        expect_fault( members, faults[i][1] );
    }
    write_text( "odd.gltf", "{\"asset\":{\"version\":\"2.0\"},\"images\":{},\"materials\":[{\"name\":\"Screen\"}]}" );
    write_text( "odd.json", "{\"scene\":\"odd.gltf\"," EMISSIVE( FILM( "" ) ) "}" );
    RfScene scene;
    RfError error = { 0 };
    assert_int_equal( load_named( "odd.json", &scene, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "odd.gltf: document: images must be an array, got an object" ) );
    cli_write( "film.5.png", "text", 4 );
    expect_fault( EMISSIVE( "{\"frames\":\"film.#.png\",\"last\":5}" ),
                  "/film.5.png: not a PNG, JPEG, WebP, EXR or Radiance HDR image" );
}

// ---- Keys of materials ----------------------------------------------------------

#define DIMMER                                                                                                                   \
    "\"interpolation\":\"linear\",\"keys\":[{\"frame\":1,\"emissiveStrength\":8},{\"frame\":11,\"emissiveStrength\":0}]"

TEST( test_materials_have_keys )
{
    RfScene scene = load_scene( "\"render\":{\"fps\":10},\"materials\":{\"paint\":{\"emissiveFactor\":[1,0.5,0]," DIMMER "}}" );
    assert_true( scene.materials[0].dims && !scene.materials[0].changes );
    assert_int_equal( scene.triangles.count, 2 ); // a lamp that dims stays where it is
    assert_true( scene.movement->start == 0.0 && scene.movement->end == 1.0 && scene.key_fps.numerator == 10 );
    for ( int k = 0; k <= 4; ++k )
    {
        RfPosedScene pose = gltf_pose_at( &scene, 0.25 * k );
        gltf_assert_rgb( pose.scene.materials[0].emission, 8.0 - 2.0 * k, 4.0 - k, 0 );
        rf_destroy_pose( &pose );
    }
    rf_destroy_scene( &scene );
    // smooth colours do not leave the range of their keys
    scene = load_scene( "\"materials\":{\"paint\":{\"keys\":[{\"time\":0,\"baseColorFactor\":[1,0,0,1]},"
                        "{\"time\":1,\"baseColorFactor\":[0,0,0,1]},{\"time\":2,\"baseColorFactor\":[0,1,0,1]}]}}" );
    assert_true( scene.materials[0].changes );
    for ( int k = 0; k <= 20; ++k )
    {
        RfPosedScene pose = gltf_pose_at( &scene, 0.1 * k );
        const double* base = pose.scene.materials[0].textured->factors.base;
        assert_true( base[0] >= 0.0 && base[0] <= 1.0 && base[1] >= 0.0 && base[1] <= 1.0 && base[2] == 0.0 );
        assert_true( k == 10 ? base[0] == 0.0 && base[1] == 0.0 : k > 10 ? base[0] == 0.0 : base[1] == 0.0 );
        rf_destroy_pose( &pose );
    }
    rf_destroy_scene( &scene );
    RfError error = { 0 };
    assert_int_equal( try_scene( "\"materials\":{\"paint\":{\"emissiveFactor\":[1,1,1]," DIMMER "}}", true, &scene, &error ),
                      RF_OK );
    assert_null( scene.movement );
    gltf_assert_rgb( scene.materials[0].emission, 8, 8, 8 );
    rf_destroy_scene( &scene );
}

#define OWN                                                                                                                      \
    ",\"extensionsUsed\":[\"KHR_animation_pointer\"],\"animations\":[{\"samplers\":[{\"input\":2,\"output\":3}],\"channels\":["  \
    "{\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":"                    \
    "\"/materials/0/pbrMetallicRoughness/metallicFactor\"}}}}]}]"

TEST( test_values_of_scene_files_go_before_animations )
{
    write_screen( "", OWN );
    RfScene scene = load_scene( "\"materials\":{}" );
    assert_true( scene.materials[0].changes && scene.movement != NULL );
    rf_destroy_scene( &scene );
    scene = load_scene( "\"materials\":{\"paint\":{\"metallicFactor\":1,\"roughnessFactor\":0.5}}" );
    assert_true( !scene.materials[0].changes && scene.movement == NULL );
    gltf_assert_rgb( scene.materials[0].diffuse, 0, 0, 0 );
    assert_true( fabs( (double)scene.materials[0].alpha - 0.25 ) < 1e-6 );
    rf_destroy_scene( &scene );
    scene = load_scene( "\"materials\":{\"paint\":{\"keys\":[{\"time\":0,\"metallicFactor\":1},"
                        "{\"time\":1,\"metallicFactor\":0}]}}" );
    RfPosedScene pose = gltf_pose_at( &scene, 0.0 );
    assert_true( scene.movement->change_count == 1 && pose.scene.materials[0].textured->factors.metallic == 1.0 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
    write_screen( "", "" );
}

TEST( test_faults_of_keys_of_materials )
{
    static const char* const faults[][2] = {
        { "\"paint\":{\"interpolation\":\"linear\"}", "materials.paint.interpolation: has no effect without keys" },
        { "\"paint\":{\"keys\":[{\"time\":1,\"ior\":2}]}",
          "materials.paint.keys[0].ior: unknown key, the keys here are: time, baseC" },
        { "\"paint\":{\"metallicFactor\":1,\"keys\":[{\"time\":1,\"metallicFactor\":1}]}",
          "materials.paint.metallicFactor: keys have it too: leave one of the two out" },
        { "\"paint\":{\"keys\":[{\"time\":1,\"emissiveFactor\":[2,0,0]}]}",
          "materials.paint.keys[0].emissiveFactor[0]: must be a number from 0 to 1, got 2" },
        { "\"paint\":{\"bsdf\":\"lambert\",\"diffuse\":[0,0,0],\"keys\":[{\"time\":1,\"roughnessFactor\":1}]}",
          "materials.paint.keys: roughnessFactor has no effect on another bsdf: add \"bsdf\": \"gltf\"" },
    };
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
    {
        char members[512];
        snprintf( members, sizeof members, "\"materials\":{%s}", faults[i][0] );
        expect_fault( members, faults[i][1] );
    }
}

static int enter( void** state )
{
    (void)state;
    cli_enter();
    write_film();
    write_screen( "", "" );
    return 0;
}

SHARED_BY_TESTS( enter, cli_leave_group )
