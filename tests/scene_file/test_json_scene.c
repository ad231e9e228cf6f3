// Scene files: what they change of a glTF, and every way to get one wrong.
#include "support/scene_files.h"
#include "support/cli_run.h"
#include "support/image_files.h"
#include "support/test.h"

#include "scene/movement.h"
#include "scene/pose.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MUTATIONS 600

#define EDIT( shots ) "\"camera\":[{\"name\":\"Eye\"}," shots "]"

static RfScene load_members( const char* members )
{
    RfScene scene;
    RfError error = { 0 };
    if ( try_members( members, &scene, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return scene;
}

static void expect_line( const char* members, RfResult code, const RfError* error, const char* part )
{
    if ( code == RF_OK || code != error->code || strstr( error->text, part ) == NULL || strchr( error->text, '\n' ) != NULL ||
         strstr( error->text, "/scene.json: " ) == NULL )
        fail_msg( "'%s' gave %s '%s' instead of '%s'", members, rf_result_name( code ), error->text, part );
}

static void expect_fault( const char* members, const char* part )
{
    RfScene scene;
    RfError error = { 0 };
    RfResult code = try_members( members, &scene, &error );
    expect_line( members, code, &error, part );
    assert_null( scene.path );
    assert_null( scene.cameras );
    assert_int_equal( try_members( members, &scene, NULL ), code ); // the report may be NULL
}

static void assert_rgb( RfVec3 got, double r, double g, double b )
{
    const double three[3] = { (double)got.x, (double)got.y, (double)got.z };
    assert_three( three, r, g, b, 1e-6 );
}

TEST( test_scene_alone_changes_nothing )
{
    RfScene scene = load_members( "\"about\":\"nothing added\"" ), gltf;
    RfError error;
    assert_int_equal( load_named( "room.gltf", &gltf, &error ), RF_OK );
    assert_int_equal( scene.material_count, 5 );
    assert_int_equal( scene.triangles.count, 1 );
    assert_int_equal( scene.camera_count, 2 );
    assert_int_equal( scene.chosen_camera, 0 );
    assert_non_null( strstr( scene.path, "/scene.json" ) );
    assert_true( scene.content_hash != gltf.content_hash );
    assert_rgb( scene.environment.radiance, 0, 0, 0 );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &gltf );
}

TEST( test_materials_are_replaced )
{
    RfScene scene = load_members(
        "\"materials\":{\"vase\":{\"exponent\":200,\"doubleSided\":true},"
        "\"wood floor\":{\"baseColorFactor\":[0.1,0.2,0.3,1],\"specularFactor\":1,\"roughnessFactor\":0.5,\"ior\":1.5,"
        "\"sheenColorFactor\":[0.9,0.5,0.1],\"sheenRoughnessFactor\":0.5},"
        "\"lamp\":{\"emissiveStrength\":8},"
        "\"materials[3]\":{\"bsdf\":\"lambert\",\"diffuse\":[0.7,0.6,0.5],\"emissiveFactor\":[0,0,1]}}" );
    const RfMaterial* m = scene.materials;
    assert_int_equal( m[0].kind, RF_BSDF_PHONG );
    assert_rgb( m[0].diffuse, 0.2, 0.1, 0.1 ); // as it was
    assert_close( (double)m[0].exponent, 200.0, 0 );
    assert_true( m[0].double_sided );
    assert_int_equal( m[1].kind, RF_BSDF_SHEEN );
    assert_rgb( m[1].sheen, 0.9, 0.5, 0.1 );
    assert_close( (double)m[1].sheen_alpha, 0.25, 1e-6 );
    assert_rgb( m[1].diffuse, 0.1, 0.2, 0.3 );
    assert_rgb( m[1].specular, 0.04, 0.04, 0.04 );
    assert_close( (double)m[1].alpha, 0.25, 1e-6 );
    assert_rgb( m[2].emission, 8, 8, 8 );
    assert_rgb( m[4].emission, 0, 8, 0 ); // all of a name
    assert_int_equal( m[3].kind, RF_BSDF_LAMBERT );
    assert_rgb( m[3].diffuse, 0.7, 0.6, 0.5 );
    assert_rgb( m[3].emission, 0, 0, 1 );
    rf_destroy_scene( &scene );

    scene = load_members( "\"materials\":{\"vase\":{\"bsdf\":\"gltf\",\"metallicFactor\":1,\"baseColorFactor\":[0.9,0.8,0.7,1],"
                          "\"roughnessFactor\":0.4},\"wood floor\":{\"bsdf\":\"phong\",\"diffuse\":[0,0,0],"
                          "\"specular\":[1,1,1],\"exponent\":3},\"lamp\":{\"transmissionFactor\":1,\"metallicFactor\":0,"
                          "\"thicknessFactor\":1,\"ior\":1.3}}" );
    assert_int_equal( scene.materials[0].kind, RF_BSDF_GGX );
    assert_rgb( scene.materials[0].specular, 0.9, 0.8, 0.7 );
    assert_int_equal( scene.materials[1].kind, RF_BSDF_PHONG );
    assert_close( (double)scene.materials[1].exponent, 3.0, 0 );
    assert_int_equal( scene.materials[2].kind, RF_BSDF_GLASS );
    assert_close( (double)scene.materials[2].ior, 1.3, 1e-6 );
    rf_destroy_scene( &scene );
}

TEST( test_cameras_take_over )
{
    RfScene scene = load_members( EDIT( "{\"name\":\"Side\",\"frame\":9},{\"name\":\"Eye\",\"frame\":12.5}" ) );
    assert_int_equal( scene.camera_count, 3 );
    assert_int_equal( scene.chosen_camera, 3 );
    const RfCamera* edit = scene.cameras + 2;
    assert_string_equal( edit->name, "edit" );
    assert_int_equal( rf_camera_shots( edit ), 3 );
    assert_true( edit->edit->in_frames && edit->edit->shots[1].from == 8.0 && edit->edit->shots[2].from == 11.5 );
    assert_int_equal( edit->edit->shots[1].camera, 1 );
    rf_destroy_scene( &scene );
    scene = load_members( EDIT( "{\"name\":\"Side\",\"time\":2}" ) );
    assert_true( !scene.cameras[2].edit->in_frames && scene.cameras[2].end >= 2.0 );
    rf_destroy_scene( &scene );
}

// At all places where glTF has them: what is dropped is not even looked at.
TEST( test_textures_can_be_dropped )
{
    static const char* const places[] = {
        "\"normalTexture\":{\"index\":0}",
        "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"metallicFactor\":0.5}",
        "\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{\"index\":0},\"metallicFactor\":0.5}",
        "\"extensions\":{\"KHR_materials_specular\":{\"specularTexture\":{\"index\":0}}}",
        "\"extensions\":{\"KHR_materials_volume\":{\"thicknessTexture\":{\"index\":0}}}",
        "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseTexture\":{\"index\":0}}}",
    };
    RfError error = { 0 };
    RfScene scene;
    for ( size_t i = 0; i < sizeof places / sizeof places[0]; ++i )
    {
        char text[512];
        snprintf( text, sizeof text, "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"name\":\"a\",%s}]}", places[i] );
        write_text( "bare.gltf", text );
        write_text( "bare.json", "{\"scene\":\"bare.gltf\",\"materials\":{\"a\":{\"textures\":true}}}" );
        assert_int_equal( load_named( "bare.json", &scene, &error ), RF_ERROR_FORMAT );
        assert_non_null( strstr( error.text, "index is 0, but there are 0 textures" ) );
        write_text( "bare.json", "{\"scene\":\"bare.gltf\",\"materials\":{\"a\":{\"textures\":false}}}" );
        assert_int_equal( load_named( "bare.json", &scene, &error ), RF_OK );
        if ( strstr( places[i], "metallicFactor" ) != NULL ) // which stays
            assert_true( rf_max_component( scene.materials[0].diffuse ) < 0.6f );
        rf_destroy_scene( &scene );
    }
}

TEST( test_faults_of_materials )
{
    static const char* const faults[][2] = {
        { "\"materials\":[]", "materials: must be an object of materials by name, got an array of 0" },
        { "\"materials\":{\"vase\":3}", "materials.vase: must be an object, got 3" },
        { "\"materials\":{\"vasse\":{}}", "materials.vasse: the scene has no such material: did you mean 'vase'? there are "
                                          "'vase', 'wood floor', 'lamp', 'materials[3]', 'lamp'" },
        { "\"materials\":{\"wood\":{}}", "materials.wood: the scene has no such material: did you mean 'wood floor'?" },
        { "\"materials\":{\"vase\":{\"exponent\":\"high\"}}",
          "materials.vase.exponent: must be a number from 0 to 1e+06, got \"high\"" },
        { "\"materials\":{\"vase\":{\"exponent\":-1}}", "materials.vase.exponent: must be a number from 0 to 1e+06, got -1" },
        { "\"materials\":{\"vase\":{\"Exponent\":1}}",
          "materials.vase.Exponent: unknown key, did you mean exponent? The keys here are: bsdf, diffuse" },
        { "\"materials\":{\"wood floor\":{\"exponent\":1}}",
          "materials[\"wood floor\"].exponent: has no effect on bsdf \"gltf\"" },
        { "\"materials\":{\"vase\":{\"roughnessFactor\":1}}",
          "materials.vase.roughnessFactor: has no effect on bsdf \"phong\": add \"bsdf\": \"gltf\"" },
        { "\"materials\":{\"vase\":{\"diffuse\":[0.6,0,0]}}",
          "materials.vase: diffuse + specular reflect 1.1 of the incident light" },
        { "\"materials\":{\"vase\":{\"diffuse\":[0.6,0]}}",
          "materials.vase.diffuse: must be an array of 3 numbers, got an array of 2" },
        { "\"materials\":{\"vase\":{\"bsdf\":\"ggx\"}}",
          "materials.vase.bsdf: must be one of gltf, lambert, phong, got \"ggx\"" },
        { "\"materials\":{\"lamp\":{\"bsdf\":\"phong\",\"diffuse\":[0,0,0]}}", "materials.lamp.specular: is missing" },
        { "\"materials\":{\"lamp\":{\"bsdf\":\"lambert\",\"diffuse\":[0,0,0],\"exponent\":3}}",
          "materials.lamp.exponent: has no effect on bsdf \"lambert\"" },
        { "\"materials\":{\"lamp\":{\"emissiveFactor\":[2,0,0]}}",
          "materials.lamp.emissiveFactor[0]: must be a number from 0 to 1, got 2" },
        { "\"materials\":{\"lamp\":{\"ior\":0.5}}", "materials.lamp.ior: must be a number from 1 to 100, got 0.5" },
        { "\"materials\":{\"lamp\":{\"doubleSided\":1}}", "materials.lamp.doubleSided: must be true or false, got 1" },
        { "\"materials\":{\"lamp\":{\"alphaMode\":\"CUT\"}}", "materials.lamp.alphaMode: must be one of OPAQUE, MASK, BLEND" },
        { "\"materials\":{\"lamp\":{\"textures\":\"no\"}}", "materials.lamp.textures: must be true or false" },
    };
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
        expect_fault( faults[i][0], faults[i][1] );
}

static void write_map( const char* name, unsigned char mantissa );

TEST( test_faults_of_files )
{
    write_map( "bright.hdr", 255 );
    static const char* const faults[][2] = {
        { "\"scene\":\"room.gltf\"", "duplicate" },
        { "\"sky\":3",
          "sky: unknown key, the keys here are: scene, environment, materials, lights, objects, camera, render, view" },
        { "\"enviroment\":3", "enviroment: unknown key, did you mean environment?" },
        { "\"environment\":3", "environment: must be an object, got 3" },
        { "\"environment\":{}", "environment: gives no light: give radiance, map or both" },
        { "\"environment\":{\"radiance\":1}", "environment.radiance: must be an array of 3 numbers, got 1" },
        { "\"environment\":{\"radiance\":[1,-1,1]}", "environment.radiance[1]: must be a number from 0 to 1e+15, got -1" },
        { "\"environment\":{\"radiance\":[1,1,1],\"rotation\":null}",
          "environment.rotation: must be a number from -1e+06 to 1e+06, got null" },
        { "\"environment\":{\"radiance\":[1,1,1],\"visible\":0}", "environment.visible: must be true or false, got 0" },
        { "\"environment\":{\"radiance\":[1,1,1],\"interpolation\":\"linear\"}",
          "environment.interpolation: has no effect without keys" },
        { "\"environment\":{\"radiance\":[1,1,1],\"keys\":[]}", "environment.keys: must be an array of 1 to" },
        { "\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"time\":1}]}",
          "environment.keys[0]: has no strength, radiance or rotation: give it one, or leave it out" },
        { "\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"frame\":2,\"strength\":1},{\"time\":1,\"strength\":2}]}",
          "environment.keys[1].time: unknown key, the keys here are: frame, strength, radiance, rotation" },
        { "\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"time\":1,\"strength\":-1}]}",
          "environment.keys[0].strength: must be a number from 0 to 1e+15, got -1" },
        { "\"environment\":{\"radiance\":[1,1,1],\"strength\":1,\"keys\":[{\"time\":1,\"strength\":1}]}",
          "environment.strength: keys have it too: leave one of the two out" },
        { "\"environment\":{\"radiance\":[1e9,1,1],\"keys\":[{\"time\":1,\"strength\":1e9}]}",
          "environment: radiance times strength is brighter than 1e+15: lower one of them" },
        { "\"environment\":{\"map\":\"\"}", "environment.map: must be a string that is not empty, got \"\"" },
        { "\"environment\":{\"map\":\"none.exr\"}", "/none.exr: cannot be opened" },
        { "\"environment\":{\"map\":\"https://a.org/b.hdr\"}",
          "environment.map: https://a.org/b.hdr: is not fetched: download it" },
        { "\"environment\":{\"map\":\"room.gltf\"}", "environment.map: " },
        { "\"environment\":{\"map\":\"bright.hdr\",\"radiance\":[1e15,1e15,1e15]}",
          "environment.map: times radiance is brighter than 1e+15 somewhere: lower radiance" },
        { "\"camera\":3",
          "camera: must be the name of a camera, a camera-path file (.json), a camera path or a list of cameras, got 3" },
        { "\"camera\":[]", "camera: must be an array of" },
        { "\"camera\":[{}]", "camera[0].name: is missing" },
        { "\"camera\":[{\"name\":\"Nobody\"}]", "choose one of 'Eye', 'Side'" },
        { "\"camera\":[{\"name\":\"Eye\",\"time\":0}]", "camera[0]: the first camera shows the first frame" },
        { EDIT( "{\"name\":\"Side\"}" ), "camera[1]: give either time (seconds) or frame" },
        { EDIT( "{\"name\":\"Side\",\"time\":1,\"frame\":9}" ), "camera[1]: give either time (seconds) or frame" },
        { EDIT( "{\"name\":\"Side\",\"frame\":1}" ), "camera[1].frame: must be a number from 2 to 1e+06, got 1" },
        { EDIT( "{\"name\":\"Side\",\"frame\":9},{\"name\":\"Eye\",\"time\":9}" ),
          "camera[2]: give all cameras a time, or all a frame" },
        { EDIT( "{\"name\":\"Side\",\"frame\":9},{\"name\":\"Eye\",\"frame\":9}" ), "camera[2].frame: is not later than" },
        { "\"camera\":\"Nobody\"", "camera: " },
        { "\"camera\":\"Nobody\"", "choose one of 'Eye', 'Side'" },
        { "\"camera\":\"none.json\"", "/none.json: cannot be opened" },
        { "\"camera\":\"scene.json\"", "camera: " },
        { "\"camera\":{}", "camera.kind: is missing" },
        { "\"camera\":{\"kind\":\"keyed\",\"keys\":[{\"time\":0}]}", "camera.keys[0].position: is missing" },
    };
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
        expect_fault( faults[i][0], faults[i][1] );
    static const char* const files[][2] = {
        { "", "line 1, column 0" },
        { "{\"scene\": \"room.gltf\",\n \"camera\" \"Eye\"}", "line 2, column " },
        { "{}", "scene: is missing: must be the name of a .glb or .gltf file" },
        { "{\"scene\":3}", "scene: must be a string" },
        { "{\"scene\":\"scene.json\"}", "scene: must be a .glb or .gltf file, got \"scene.json\"" },
        { "{\"asset\":{\"version\":\"2.0\"}}", "is a glTF: give it a name that ends in .gltf" },
    };
    for ( size_t i = 0; i < sizeof files / sizeof files[0]; ++i )
    {
        RfScene scene;
        RfError error = { 0 };
        write_text( "scene.json", files[i][0] );
        RfResult code = load_named( "scene.json", &scene, &error );
        expect_line( files[i][0], code, &error, files[i][1] );
    }
    RfScene scene;
    RfError error = { 0 };
    write_text( "scene.json", "{\"scene\":\"none.glb\"}" );
    assert_int_equal( load_named( "scene.json", &scene, &error ), RF_ERROR_IO );
    assert_non_null( strstr( error.text, "/none.glb: cannot be opened" ) );
    write_text( "scene.json", "{\"scene\":\"HTTP://a.org/b.glb\"}" );
    assert_int_equal( load_named( "scene.json", &scene, &error ), RF_ERROR_UNSUPPORTED );
    assert_int_equal( strncmp( error.text, "HTTP://a.org/b.glb: is not fetched: download it", 47 ), 0 );
}

static void write_map( const char* name, unsigned char mantissa )
{
    uint8_t pixels[4 * 8];
    for ( int i = 0; i < 8; ++i )
        memcpy( pixels + 4 * i, ( const uint8_t[4] ){ mantissa, 64, 0, 129 }, 4 );
    size_t size;
    uint8_t* bytes = encode_hdr( 4, 2, pixels, &size );
    cli_write( name, bytes, size );
    free( bytes );
}

TEST( test_environment_is_read )
{
    RfScene scene = load_members( "\"environment\":{\"radiance\":[0.5,1,2],\"visible\":false}" );
    assert_rgb( scene.environment.radiance, 0.5, 1, 2 );
    assert_true( scene.environment.hidden );
    assert_null( scene.environment.map );
    rf_destroy_scene( &scene );

    write_map( "sky.hdr", 128 );
    scene = load_members( "\"environment\":{\"map\":\"sky.hdr\",\"rotation\":450}" );
    assert_rgb( scene.environment.radiance, 1, 1, 1 );
    assert_false( scene.environment.hidden );
    assert_close( (double)scene.environment.rotation, 1.5707963267948966, 1e-6 );
    assert_int_equal( scene.environment.width, 4 );
    assert_int_equal( scene.environment.height, 2 );
    assert_close( (double)scene.environment.map[0], 1.0, 0.01 );
    uint64_t hash = scene.content_hash;
    rf_destroy_scene( &scene );
    write_map( "sky.hdr", 130 ); // another map, another scene
    scene = load_members( "\"environment\":{\"map\":\"sky.hdr\",\"rotation\":450}" );
    assert_true( scene.content_hash != hash );
    rf_destroy_scene( &scene );
}

// The value of a change of the sky, at a time.
static double sky_at( const RfScene* scene, RfChangedValue value, double time )
{
    double number = -1.0;
    for ( int i = 0; i < scene->movement->change_count; ++i )
    {
        if ( scene->movement->changes[i].value == value )
            rf_sample_channel( &scene->movement->changes[i].channel, time, &number );
    }
    return number;
}

#define SUNRISE                                                                                                                  \
    "\"environment\":{\"radiance\":[1,2,3],\"map\":\"sky.hdr\",\"interpolation\":\"linear\",\"keys\":["                          \
    "{\"time\":1,\"strength\":0,\"rotation\":0},{\"time\":2,\"strength\":4},{\"time\":3,\"rotation\":720}]}"

TEST( test_environment_has_keys )
{
    write_map( "sky.hdr", 128 );
    RfScene scene = load_members( SUNRISE );
    assert_rgb( scene.environment.radiance, 1, 2, 3 ); // of which the strength is a factor
    assert_true( scene.environment.changes );
    assert_int_equal( scene.movement->change_count, 2 );
    assert_true( scene.movement->start == 1.0 && scene.movement->end == 3.0 );
    assert_int_equal( scene.key_fps.numerator, 0 );
    assert_close( sky_at( &scene, RF_CHANGED_SKY_STRENGTH, 1.25 ), 1.0, 1e-12 );
    assert_close( sky_at( &scene, RF_CHANGED_SKY_STRENGTH, 9.0 ), 4.0, 0.0 );
    assert_close( sky_at( &scene, RF_CHANGED_SKY_ROTATION, 2.0 ), 6.283185307179586, 1e-12 ); // twice around
    rf_destroy_scene( &scene );

    // smooth, without leaving the range of the keys, at the frames of the file; constant radiance does not turn
    scene = load_members( "\"render\":{\"fps\":10},\"environment\":{\"radiance\":[1,1,1],\"keys\":[{\"frame\":1,\"strength\":1},"
                          "{\"frame\":11,\"strength\":0,\"rotation\":0},{\"frame\":21,\"strength\":0,\"rotation\":90}]}" );
    assert_int_equal( scene.movement->change_count, 1 );
    assert_true( scene.movement->end == 2.0 && scene.key_fps.numerator == 10 && scene.fps.numerator == 10 );
    assert_close( sky_at( &scene, RF_CHANGED_SKY_STRENGTH, 0.5 ), 0.3125, 1e-12 ); // a cubic of slopes -1.5 and 0
    for ( int k = 10; k <= 20; ++k )
        assert_true( sky_at( &scene, RF_CHANGED_SKY_STRENGTH, 0.1 * k ) == 0.0 );
    rf_destroy_scene( &scene );

    // colours, without or with a factor on them
    scene = load_members( "\"environment\":{\"strength\":2,\"interpolation\":\"linear\",\"keys\":["
                          "{\"time\":0,\"radiance\":[1,2,0]},{\"time\":1,\"radiance\":[0,2,4]}]}" );
    RfPosedScene posed = { 0 };
    assert_int_equal( rf_pose_scene( &scene, 0.25, &posed, NULL ), RF_OK );
    assert_rgb( posed.scene.environment.radiance, 1.5f, 4, 2 );
    rf_destroy_pose( &posed );
    rf_destroy_scene( &scene );

    // keys that are equal change nothing
    scene = load_members( "\"environment\":{\"radiance\":[1,2,1],\"strength\":0.5,\"keys\":[{\"time\":1,\"rotation\":1}]}" );
    assert_null( scene.movement );
    assert_rgb( scene.environment.radiance, 0.5, 1, 0.5 );
    rf_destroy_scene( &scene );
    scene = load_members( "\"environment\":{\"map\":\"sky.hdr\",\"keys\":[{\"time\":1,\"strength\":3,\"rotation\":90},"
                          "{\"time\":2,\"strength\":3,\"rotation\":90}]}" );
    assert_null( scene.movement );
    assert_rgb( scene.environment.radiance, 3, 3, 3 );
    assert_close( (double)scene.environment.rotation, 1.5707963267948966, 1e-6 );
    rf_destroy_scene( &scene );
}

TEST( test_environment_is_frozen )
{
    RfSceneOptions options = { .freeze = true };
    RfScene scene, moving = load_members( SUNRISE ); // writes the file
    RfError error = { 0 };
    char path[256];
    snprintf( path, sizeof path, "%s/scene.json", cli_folder() );
    assert_int_equal( rf_load_scene_with( path, &options, &scene, NULL, &error ), RF_OK );
    assert_null( scene.movement );
    assert_true( scene.frozen && !scene.environment.changes && scene.content_hash != moving.content_hash );
    assert_rgb( scene.environment.radiance, 0, 0, 0 );
    assert_int_equal( scene.unrendered_count, 1 );
    assert_string_equal( scene.unrendered[0].what, "environment" );
    assert_int_equal( rf_check_rendered( &scene, &error ), RF_OK );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &moving );
    // as in the first frame, which is later: at 1.5 s
    moving = load_members( SUNRISE ",\"camera\":{\"kind\":\"keyed\",\"target\":[0,0,0],\"keys\":[{\"frame\":37,"
                                   "\"position\":[0,0,5]},{\"frame\":49,\"position\":[0,1,5]}]}" );
    assert_int_equal( rf_load_scene_with( path, &options, &scene, NULL, &error ), RF_OK );
    assert_rgb( scene.environment.radiance, 2, 4, 6 );
    assert_close( (double)scene.environment.rotation, 3.141592653589793, 1e-6 );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &moving );
}

static void expect_extras_fault( const char* extras, const char* part )
{
    RfScene scene;
    RfError error = { 0 };
    write_room( extras );
    assert_int_not_equal( load_named( "room.gltf", &scene, &error ), RF_OK );
    if ( strstr( error.text, part ) == NULL || strstr( error.text, "/room.gltf: " ) == NULL )
        fail_msg( "'%s' gave '%s'", extras, error.text );
}

TEST( test_environment_in_gltf )
{
    write_map( "sky.hdr", 128 );
    write_room(
        ",\"extras\":{\"other\":1,\"reframe\":{\"environment\":{\"radiance\":[1,2,3],\"map\":\"sky.hdr\",\"rotation\":-90}}}" );
    RfScene scene = load_members( "" );
    assert_rgb( scene.environment.radiance, 1, 2, 3 );
    assert_int_equal( scene.environment.width, 4 );
    assert_close( (double)scene.environment.rotation, -1.5707963267948966, 1e-6 );
    rf_destroy_scene( &scene );
    scene = load_members( "\"environment\":{\"radiance\":[4,4,4]}" ); // instead of it
    assert_rgb( scene.environment.radiance, 4, 4, 4 );
    assert_null( scene.environment.map );
    rf_destroy_scene( &scene );
    write_room( ",\"extras\":\"text of another program\"" );
    scene = load_members( "" );
    rf_destroy_scene( &scene );

    // keys at the frames of the glTF, which a scene file replaces
    write_room( ",\"extras\":{\"reframe\":{\"render\":{\"fps\":10},\"environment\":{\"map\":\"sky.hdr\",\"keys\":["
                "{\"frame\":1,\"rotation\":0},{\"frame\":11,\"rotation\":360}]}}}" );
    scene = load_members( "" );
    assert_true( scene.environment.changes && scene.movement->end == 1.0 && scene.key_fps.numerator == 10 );
    rf_destroy_scene( &scene );
    scene = load_members( "\"environment\":{\"radiance\":[4,4,4]}" );
    assert_null( scene.movement );
    assert_true( !scene.environment.changes && scene.key_fps.numerator == 0 );
    rf_destroy_scene( &scene );
    expect_extras_fault( ",\"extras\":{\"reframe\":3}", "scenes[0].extras.reframe: must be an object, got 3" );
    expect_extras_fault( ",\"extras\":{\"reframe\":{\"sky\":3}}", "scenes[0].extras.reframe.sky: unknown key" );
    expect_extras_fault( ",\"extras\":{\"reframe\":{\"environment\":{\"radiance\":[1,1]}}}",
                         "scenes[0].extras.reframe.environment.radiance: must be an array of 3 numbers" );
    expect_extras_fault( ",\"extras\":{\"reframe\":{\"environment\":{\"map\":\"../gone.hdr\"}}}",
                         "../gone.hdr: cannot be opened" );
    expect_extras_fault( ",\"extras\":{\"reframe\":{\"environment\":{\"map\":\"/sky.hdr\"}}}", "begins with '/'" );
    expect_extras_fault( ",\"extras\":{\"reframe\":{\"environment\":{\"map\":\"file:sky.hdr\"}}}", "has a scheme" );
    expect_extras_fault( ",\"extras\":{\"reframe\":{\"environment\":{\"map\":\"gone.hdr\"}}}", "gone.hdr: cannot be opened" );
    write_room( "" );
}

// room.gltf with the file sky.hdr as its last bufferView, and with `environment` and `warnings` in its extras.
static void write_embedded( const char* environment, const char* warnings )
{
    write_room( ",\"extras\":{\"reframe\":{}}" );
    size_t size;
    free( cli_read( "sky.hdr", &size ) );
    json_t* room = cli_read_json( "room.gltf" );
    json_t *buffers = json_object_get( room, "buffers" ), *views = json_object_get( room, "bufferViews" );
    json_array_append_new( buffers, json_pack( "{s:s, s:I}", "uri", "sky.hdr", "byteLength", (json_int_t)size ) );
    json_array_append_new(
        views, json_pack( "{s:i, s:I}", "buffer", (int)json_array_size( buffers ) - 1, "byteLength", (json_int_t)size ) );
    json_t* scene = json_array_get( json_object_get( room, "scenes" ), 0 );
    json_t* ours = json_object_get( json_object_get( scene, "extras" ), "reframe" );
    json_t* sky = json_loads( environment, 0, NULL );
    if ( json_is_true( json_object_get( sky, "bufferView" ) ) )
        json_object_set_new( sky, "bufferView", json_integer( (int)json_array_size( views ) - 1 ) );
    json_object_set_new( ours, "environment", sky );
    json_object_set_new( ours, "export_warnings", json_loads( warnings, JSON_DECODE_ANY, NULL ) );
    json_object_set_new( ours, "export_losses", json_loads( "[\"'sun': is\\nlost\"]", 0, NULL ) );
    char* text = json_dumps( room, 0 );
    write_text( "room.gltf", text );
    free( text );
    json_decref( room );
}

static void expect_embedded_fault( const char* environment, const char* warnings, const char* part )
{
    RfScene scene;
    RfError error = { 0 };
    write_embedded( environment, warnings );
    assert_int_not_equal( load_named( "room.gltf", &scene, &error ), RF_OK );
    if ( strstr( error.text, part ) == NULL || strstr( error.text, "/room.gltf: " ) == NULL )
        fail_msg( "'%s' gave '%s'", environment, error.text );
}

#define LAST "{\"bufferView\":true}" // write_embedded knows its number

TEST( test_map_and_warnings_inside_gltf )
{
    write_map( "sky.hdr", 128 );
    write_embedded( LAST, "[\"'a\\u001b[31m\\u0085': left out\", \"café\"]" );
    RfScene scene = load_members( "" );
    assert_int_equal( scene.environment.width, 4 );
    assert_int_equal( scene.environment.height, 2 );
    assert_close( (double)scene.environment.map[0], 1.0, 0.01 );
    assert_int_equal( scene.export_loss_count, 1 );
    assert_string_equal( scene.export_losses[0], "'sun': is?lost" );
    assert_int_equal( scene.export_warning_count, 2 );
    assert_string_equal( scene.export_warnings[0], "'a?[31m?\?': left out" );
    assert_string_equal( scene.export_warnings[1], "café" );
    uint64_t hash = scene.content_hash;
    rf_destroy_scene( &scene );
    write_map( "sky.hdr", 130 ); // another map, another scene
    scene = load_members( "" );
    assert_true( scene.content_hash != hash );
    rf_destroy_scene( &scene );
    expect_embedded_fault( "{\"bufferView\":99}", "[]", "environment.bufferView: names bufferView 99, but there are" );
    expect_embedded_fault( "{\"bufferView\":-1}", "[]", "environment.bufferView: must be a number" );
    expect_embedded_fault( "{\"bufferView\":0.5}", "[]", "environment.bufferView: must be a whole number" );
    expect_embedded_fault( "{\"bufferView\":0}", "[]", "environment.bufferView: " );
    expect_embedded_fault( "{\"bufferView\":true,\"map\":\"sky.hdr\"}", "[]", "has both map and bufferView" );
    expect_embedded_fault( LAST, "[7]", "extras.reframe.export_warnings[0]: must be" );
    expect_embedded_fault( LAST, "\"none\"", "extras.reframe.export_warnings: must be" );
    write_room( "" );
    RfError error = { 0 };
    assert_int_not_equal( try_members( "\"environment\":{\"bufferView\":0}", &scene, &error ), RF_OK );
    assert_non_null( strstr( error.text, "environment.bufferView: unknown key" ) );
}

#define PATH "{\"kind\":\"dolly\",\"from\":[0,0,5],\"to\":[0,0,3],\"target\":[0,0,0],\"frames\":7}"

static uint64_t hash_of( const char* members )
{
    RfScene scene = load_members( members );
    uint64_t hash = scene.content_hash;
    rf_destroy_scene( &scene );
    return hash;
}

TEST( test_cameras_are_chosen_and_replaced )
{
    RfError error;
    int index;
    RfScene scene = load_members( "\"camera\":\"Side\"" );
    assert_int_equal( rf_find_camera( &scene, NULL, &index, &error ), RF_OK );
    assert_string_equal( scene.cameras[index].name, "Side" );
    assert_int_equal( rf_find_camera( &scene, "Eye", &index, &error ), RF_OK );
    assert_int_equal( index, 0 );
    rf_destroy_scene( &scene );

    scene = load_members( "\"camera\":" PATH );
    assert_int_equal( rf_find_camera( &scene, NULL, &index, &error ), RF_OK );
    assert_int_equal( index, 2 );
    assert_string_equal( scene.cameras[index].name, "path" );
    RfEye eye;
    assert_int_equal(
        rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras + index, NULL, { 24, 1 }, 16, 9 }, 3, &eye, &error ), RF_OK );
    assert_close( (double)eye.origin.z, 4.0, 1e-6 );
    rf_destroy_scene( &scene );

    write_text( "walk.json", PATH );
    scene = load_members( "\"camera\":\"walk.json\"" );
    assert_int_equal( scene.chosen_camera, 3 );
    assert_non_null( strstr( scene.cameras[2].name, "/walk.json" ) );
    rf_destroy_scene( &scene );
    uint64_t hash = hash_of( "\"camera\":\"walk.json\"" );
    assert_true( hash == hash_of( "\"camera\":\"walk.json\"" ) );
    assert_true( hash != hash_of( "\"camera\":  \"walk.json\"" ) );
    write_text( "walk.json", PATH " " );
    assert_true( hash != hash_of( "\"camera\":\"walk.json\"" ) );
}

static RfResult load_lit( const char* lights, RfScene* scene, RfError* error )
{
    char text[400];
    write_text( "lit.gltf", "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":["
                            "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
                            "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}}],"
                            "\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
                            "{\"type\":\"point\",\"name\":\"Lamp\",\"intensity\":2},"
                            "{\"type\":\"directional\",\"name\":\"Sun\"}]}}}" );
    write_text( "lamp.ies", "IESNA:LM-63-2002\nTILT=NONE\n1 -1 3 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n4 4\n" );
    snprintf( text, sizeof text, "{\"scene\":\"lit.gltf\",\"lights\":%s}", lights );
    write_text( "lit.json", text );
    return load_named( "lit.json", scene, error );
}

TEST( test_lights_get_what_gltf_lacks )
{
    static const char* const faults[][2] = {
        { "[]", "lit.json: lights: must be an object of lights by name" },
        { "{\"Lmap\":{}}", "lit.json: lights.Lmap: " },
        { "{\"Lamp\":{\"iesfile\":\"a\"}}", "lights.Lamp.iesfile: unknown key" },
        { "{\"Lamp\":{\"ies\":3}}", "lights.Lamp.ies: must be" },
        { "{\"Lamp\":{\"ies\":\"no.ies\"}}", "no.ies" },
        { "{\"Lamp\":{\"angle\":1}}", "lights[0].extras.reframe.angle: unknown key" },
        { "{\"Sun\":{\"angle\":200}}", "lights[1].extras.reframe.angle: must be" },
    };
    RfScene scene;
    RfError error;
    if ( load_lit( "{\"Lamp\":{\"ies\":\"lamp.ies\",\"radius\":0.25},\"Sun\":{\"angle\":60}}", &scene, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_int_equal( scene.punctual_count, 2 );
    assert_true( scene.punctuals[0].radius == 0.25f && scene.punctuals[0].profile != NULL );
    assert_true( scene.punctuals[0].profile->most == 12.0f ); // the multiplier is 3
    assert_true( fabs( (double)scene.punctuals[1].versine - ( 1.0 - cos( 30.0 * 3.14159265358979 / 180.0 ) ) ) < 1e-6 );
    rf_destroy_scene( &scene );
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
    {
        RfResult code = load_lit( faults[i][0], &scene, &error );
        if ( code == RF_OK || strstr( error.text, faults[i][1] ) == NULL )
            fail_msg( "'%s' gave '%s' instead of '%s'", faults[i][0], error.text, faults[i][1] );
    }
}

TEST( test_mutations_never_crash )
{
    static const char text[] =
        "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[1,2,3],\"rotation\":45,\"visible\":true},\"materials\":{"
        "\"vase\":{\"exponent\":20,\"diffuse\":[0.1,0.1,0.1]},\"lamp\":{\"emissiveStrength\":3,\"textures\":false}},"
        "\"objects\":[{\"node\":\"nodes[2]\",\"scale\":2,\"keys\":[{\"time\":0,\"rotation\":{\"yaw\":9}},{\"time\":1,\"visible\":"
        "false,"
        "\"rotation\":[0,0,0,1]}]},{\"file\":\"room.gltf\",\"name\":\"b\",\"interpolation\":\"linear\",\"keys\":[{\"frame\":1,"
        "\"translation\":"
        "[0,0,0]},{\"frame\":9,\"translation\":[1,0,0]}]}],\"camera\":" PATH ",\"render\":{\"spp\":3}}";
    const char* many = getenv( "REFRAME_MUTATIONS" );
    uint64_t count = many != NULL ? (uint64_t)atoll( many ) : MUTATIONS;
    int loaded = 0;
    for ( uint64_t i = 0; i < count; ++i )
    {
        char bytes[sizeof text];
        memcpy( bytes, text, sizeof text );
        cli_write( "scene.json", bytes, mutate_bytes( (uint8_t*)bytes, sizeof text - 1, 5 * ( i + 1 ) ) );
        RfScene scene;
        RfError error = { 0 };
        RfResult result = load_named( "scene.json", &scene, &error );
        assert_true( result == RF_OK || ( error.text[0] != 0 && scene.path == NULL ) );
        loaded += result == RF_OK;
        rf_destroy_scene( &scene );
    }
    assert_true( loaded > 0 );
}

static int enter( void** state )
{
    (void)state;
    cli_enter();
    write_room( "" );
    return 0;
}

static int leave( void** state )
{
    (void)state;
    cli_leave();
    return 0;
}

SHARED_BY_TESTS( enter, leave )
