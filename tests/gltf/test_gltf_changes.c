// What changes by KHR_animation_pointer, against closed forms: lamps, materials, textures and lenses, and how files go wrong.
#include "support/image_files.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "scene/leave_out.h"
#include "scene/movement.h"
#include "scene/pose.h"
#include "scene/textured.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// All keys but those of a truth are at 1 and 3 s. Accessors: 0 times, 1 intensities, 2 colours, 3 angles, 4 places, 5 a spline, 6
// truths and 7 their times, 8 a triangle and 9 its texture coordinates, 10 strengths, 11 emission, 12 base colours, 13 offsets, 14
// fractions, 15 a PNG.
static GltfBuilder make_keys( void )
{
    static const float s_at[] = { 1, 3 }, s_watts[] = { 0, 8 }, s_colors[] = { 1, 0, 0.5f, 0, 1, 0.5f }, s_angles[] = { 0.5f, 1 },
                       s_places[] = { 0, 0, 0, 2, 4, 6 }, s_spline[] = { 0, 1, 3, 1, 5, 0 }, s_when[] = { 1, 2 };
    static const float s_triangle[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, s_uvs[] = { 0, 0, 1, 0, 0, 1 }, s_strengths[] = { 7, 0 },
                       s_emission[] = { 0, 0, 0, 1, 0.5f, 0 }, s_bases[] = { 1, 0, 0, 1, 0, 0.5f, 0, 0.25f },
                       s_offsets[] = { 0, 1, 2, 0 }, s_fractions[] = { 0.25f, 0.75f };
    static const uint8_t s_shown[] = { 0, 1 }, s_white[] = { 255, 255, 255, 255 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "SCALAR", 1, 2, s_at );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_watts );
    add_gltf_floats( &b, "VEC3", 3, 2, s_colors );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_angles );
    add_gltf_floats( &b, "VEC3", 3, 2, s_places );
    add_gltf_floats( &b, "SCALAR", 1, 6, s_spline );
    add_gltf_accessor( &b, 5121, "SCALAR", 2, s_shown, sizeof s_shown, "" );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_when );
    add_gltf_floats( &b, "VEC3", 3, 3, s_triangle );
    add_gltf_floats( &b, "VEC2", 2, 3, s_uvs );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_strengths );
    add_gltf_floats( &b, "VEC3", 3, 2, s_emission );
    add_gltf_floats( &b, "VEC4", 4, 2, s_bases );
    add_gltf_floats( &b, "VEC2", 2, 2, s_offsets );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_fractions );
    size_t size;
    uint8_t* png = encode_png( 1, 1, 4, s_white, &size );
    add_gltf_accessor( &b, 5121, "SCALAR", (int)size, png, size, "" );
    free( png );
    return b;
}

// How far a time is between the keys.
static double part_of( double time ) { return fmin( fmax( ( time - 1.0 ) / 2.0, 0.0 ), 1.0 ); }

#define KEYS( output ) "{\"input\":0,\"output\":" output "}"
#define SPLINE "{\"input\":0,\"output\":5,\"interpolation\":\"CUBICSPLINE\"}"
#define STEPS( input, output ) "{\"input\":" input ",\"output\":" output ",\"interpolation\":\"STEP\"}"
#define POINTER( pointer ) "\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"" pointer "\"}}"
#define CHANGES( sampler, pointer ) "{\"sampler\":" sampler ",\"target\":{\"path\":\"pointer\"," POINTER( pointer ) "}}"
#define ANIMATE( samplers, channels ) "\"animations\":[{\"samplers\":[" samplers "],\"channels\":[" channels "]}]"

// ---- Lamps ------------------------------------------------------------------------

#define LIGHT "/extensions/KHR_lights_punctual/lights/0/"

#define LIGHTS( light ) "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[" light "]}}"
#define WITH_LIGHT "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}"

#define SPOT "{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":0.25},\"range\":9}"
#define FOUR_CHANGES                                                                                                             \
    CHANGES( "0", LIGHT "intensity" )                                                                                            \
    "," CHANGES( "1", LIGHT "color" ) "," CHANGES( "2", LIGHT "spot/outerConeAngle" ) "," CHANGES( "4", LIGHT "range" )
#define MOVES "{\"sampler\":3,\"target\":{\"node\":0,\"path\":\"translation\"}}"

// A spot of which all changes, at two nodes, of which one moves.
TEST( test_a_lamp_that_changes )
{
    GltfBuilder b = make_keys();
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{" WITH_LIGHT "},{\"translation\":[7,0,0]," WITH_LIGHT "}]," LIGHTS( SPOT ) "," ANIMATE(
                KEYS( "1" ) "," KEYS( "2" ) "," KEYS( "3" ) "," KEYS( "4" ) "," SPLINE, FOUR_CHANGES "," MOVES ) );
    assert_int_equal( scene.unrendered_count, 0 );
    assert_string_equal( gltf_warnings, "" );
    assert_int_equal( scene.punctual_count, 2 );
    assert_true( scene.punctuals[0].changes && scene.punctuals[1].changes );
    assert_true( scene.movement->start == 1.0 && scene.movement->end == 3.0 );
    assert_int_equal( scene.movement->change_count, 4 );
    gltf_assert_rgb( scene.punctuals[1].intensity, 8, 8, 4 ); // the most of each channel
    for ( int k = -1; k <= 9; ++k )
    {
        double time = 0.5 * k, t = part_of( time );
        RfPosedScene pose = gltf_pose_at( &scene, time );
        assert_ptr_equal( pose.scene.materials, scene.materials );
        for ( int i = 0; i < 2; ++i )
        {
            const RfPunctual* lamp = pose.scene.punctuals + i;
            double x = i == 0 ? 2.0 * t : 7.0;
            gltf_assert_rgb( lamp->intensity, 8.0 * t * ( 1.0 - t ), 8.0 * t * t, 4.0 * t );
            gltf_assert_rgb( lamp->position, x, i == 0 ? 4.0 * t : 0.0, i == 0 ? 6.0 * t : 0.0 );
            gltf_assert_rgb( lamp->direction, 0, 0, -1 );
            gltf_assert_near( lamp->cos_inner, cos( 0.25 ) );
            gltf_assert_near( lamp->cos_outer, cos( 0.5 + 0.5 * t ) );
            // Hermite: from 1 with the slope 3 to 5 with the slope 1, over 2 s
            double h = ( 2 * t * t * t - 3 * t * t + 1 ) * 1.0 + ( t * t * t - 2 * t * t + t ) * 2.0 * 3.0 +
                       ( 3 * t * t - 2 * t * t * t ) * 5.0 + ( t * t * t - t * t ) * 2.0 * 1.0;
            gltf_assert_near( lamp->range, h );
        }
        rf_destroy_pose( &pose );
    }
    RfPosedScene full = { .in_shutter = true, .middle = 2.0 }; // its place as well
    assert_int_equal( rf_pose_scene( &scene, 2.5, &full, NULL ), RF_OK );
    gltf_assert_rgb( full.scene.punctuals[0].intensity, 2, 2, 2 );
    gltf_assert_rgb( full.scene.punctuals[0].position, 1, 2, 3 );
    rf_destroy_pose( &full );
    assert_false( rf_scene_moves( &scene, 0.0, 1.0 ) );
    assert_true( rf_scene_moves( &scene, 1.0, 1.5 ) );
    rf_destroy_scene( &scene );
}

#define BULB LIGHTS( "{\"type\":\"point\",\"intensity\":5}" )
#define SWITCH ANIMATE( STEPS( "7", "6" ), CHANGES( "0", "/nodes/0/extensions/KHR_node_visibility/visible" ) )
#define SWITCHED "\"nodes\":[{\"children\":[1]},{\"translation\":[0,3,0]," WITH_LIGHT "}]," BULB "," SWITCH

TEST( test_a_lamp_that_is_switched )
{
    GltfBuilder b = make_keys();
    RfScene scene = gltf_load_built( &b, SWITCHED );
    assert_int_equal( scene.unrendered_count, 0 );
    gltf_assert_rgb( scene.punctuals[0].intensity, 5, 5, 5 );
    static const double s_at[] = { 0, 1, 1.99, 2, 9 };
    for ( int i = 0; i < 5; ++i )
    {
        double want = i < 3 ? 0.0 : 5.0;
        RfPosedScene pose = gltf_pose_at( &scene, s_at[i] );
        gltf_assert_rgb( pose.scene.punctuals[0].intensity, want, want, want );
        gltf_assert_rgb( pose.scene.punctuals[0].position, 0, 3, 0 );
        rf_destroy_pose( &pose );
    }
    assert_true( rf_scene_moves( &scene, 1.0, 2.0 ) );
    assert_false( rf_scene_moves( &scene, 0.0, 1.5 ) );
    rf_destroy_scene( &scene );
}

static void assert_hash_of_pose( const RfScene* scene, double time )
{
    uint64_t hash;
    RfPosedScene pose = gltf_pose_at( scene, time );
    assert_int_equal( rf_moment_hash( scene, time, &hash, NULL ), RF_OK );
    assert_true( hash == pose.hash );
    rf_destroy_pose( &pose );
}

// ---- Materials --------------------------------------------------------------------

#define TRIANGLE( material ) "{\"attributes\":{\"POSITION\":8,\"TEXCOORD_0\":9},\"material\":" material "}"
#define TWO_TRIANGLES "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[" TRIANGLE( "0" ) "," TRIANGLE( "1" ) "]}],"
#define STRENGTH "/materials/1/extensions/KHR_materials_emissive_strength/emissiveStrength"
#define GLOW ANIMATE( KEYS( "10" ) "," KEYS( "11" ), CHANGES( "0", STRENGTH ) "," CHANGES( "1", "/materials/1/emissiveFactor" ) )

// Dark at first, and in the middle brighter than at any key: (1 - t) × 7 t, the most of which bounds the light that is loaded.
TEST( test_a_material_that_dims )
{
    GltfBuilder b = make_keys();
    RfScene scene = gltf_load_built( &b, TWO_TRIANGLES "\"materials\":[{\"emissiveFactor\":[1,1,1]},{}]," GLOW );
    assert_int_equal( scene.unrendered_count, 0 );
    assert_int_equal( scene.triangles.count, 2 ); // it stands still
    assert_int_equal( scene.placement_count, 0 );
    assert_true( scene.materials[1].dims && !scene.materials[1].changes && !scene.materials[0].dims );
    gltf_assert_rgb( scene.materials[1].emission, 7, 3.5, 0 );
    size_t bytes = rf_pose_bytes( &scene );
    RfPosedScene pose = { .memory = aligned_alloc( 64, bytes ) };
    void* memory = pose.memory;
    for ( int k = 0; k <= 8; ++k )
    {
        double time = 0.5 * k, t = part_of( time ), red = 7.0 * ( 1.0 - t ) * t;
        assert_int_equal( rf_pose_scene( &scene, time, &pose, NULL ), RF_OK );
        gltf_assert_rgb( pose.scene.materials[1].emission, red, 0.5 * red, 0 );
        gltf_assert_rgb( pose.scene.materials[0].emission, 1, 1, 1 );
        assert_hash_of_pose( &scene, time );
    }
    rf_destroy_pose( &pose );
    free( memory );
    rf_destroy_scene( &scene );
}

// From 1 up and back in 2 s, with slopes of 4: 3 half-way, the most that it is. Downwards it is held at 0.
TEST( test_a_spline_between_its_keys )
{
    for ( int down = 0; down < 2; ++down )
    {
        float slope = down ? -4.0f : 4.0f;
        GltfBuilder b = make_keys();
        add_gltf_floats( &b, "SCALAR", 1, 6, ( const float[] ){ 0, 1, slope, -slope, 1, 0 } );
        RfScene scene = gltf_load_built(
            &b, TWO_TRIANGLES "\"materials\":[{},{\"emissiveFactor\":[1,1,1]}]," ANIMATE(
                    "{\"input\":0,\"output\":16,\"interpolation\":\"CUBICSPLINE\"}", CHANGES( "0", STRENGTH ) ) );
        double most = down ? 1.0 : 3.0, middle = down ? 0.0 : 3.0;
        gltf_assert_rgb( scene.materials[1].emission, most, most, most );
        RfPosedScene pose = gltf_pose_at( &scene, 2.0 );
        gltf_assert_rgb( pose.scene.materials[1].emission, middle, middle, middle );
        rf_destroy_pose( &pose );
        rf_destroy_scene( &scene );
    }
}

#define PBR "/materials/1/pbrMetallicRoughness/"
#define SHAPES                                                                                                                   \
    ANIMATE( KEYS( "12" ) "," KEYS( "14" ), CHANGES( "0", PBR "baseColorFactor" ) "," CHANGES(                                   \
                                                "1", PBR "metallicFactor" ) "," CHANGES( "1", PBR "roughnessFactor" ) )

// Metal in part, of a base colour: glTF's model, with 0.04 for dielectrics.
static void assert_is_made_of( const RfMaterial* m, const double base[3], double metallic, double roughness )
{
    double d = 1.0 - metallic;
    gltf_assert_rgb( m->diffuse, d * base[0], d * base[1], d * base[2] );
    gltf_assert_rgb( m->specular, 0.04 * d + metallic * base[0], 0.04 * d + metallic * base[1], 0.04 * d + metallic * base[2] );
    gltf_assert_near( m->alpha, roughness * roughness );
}

// Its primitive alone moves; that of another material stands still.
TEST( test_a_material_that_changes )
{
    GltfBuilder b = make_keys();
    RfScene scene =
        gltf_load_built( &b, TWO_TRIANGLES "\"materials\":[{},{\"pbrMetallicRoughness\":{\"metallicFactor\":1}}]," SHAPES );
    const RfMaterial* loaded = scene.materials + 1;
    assert_int_equal( scene.unrendered_count, 0 );
    assert_int_equal( scene.triangles.count, 1 );
    assert_int_equal( scene.placement_count, 1 );
    assert_int_equal( scene.instance_count, 2 );
    assert_int_equal( scene.meshes[0].triangles.count, 1 );
    assert_int_equal( scene.meshes[0].triangles.material[0], 1 );
    assert_null( scene.materials[0].textured );
    assert_true( loaded->changes && !loaded->dims && loaded->textured != NULL );
    assert_true( rf_may_be_sharp( loaded ) && rf_may_throw_caustics( loaded ) ); // as it is at some time
    assert_true( rf_max_component( loaded->diffuse ) > 0.0f );
    for ( int k = 1; k <= 7; ++k )
    {
        double t = part_of( 0.5 * k ), base[3] = { 1.0 - t, 0.5 * t, 0.0 }, fraction = 0.25 + 0.5 * t;
        RfMaterial at;
        RfPosedScene pose = gltf_pose_at( &scene, 0.5 * k );
        rf_material_at( &pose.scene, pose.scene.materials + 1, 1, 0.25f, 0.25f, &at );
        assert_is_made_of( &at, base, fraction, fraction );
        assert_is_made_of( pose.scene.materials + 1, base, fraction, fraction );
        assert_int_equal( at.kind, RF_BSDF_GGX );
        assert_true( pose.scene.placements[0].shown );
        gltf_assert_placed_corner( &pose.scene, 1, 1, 1, 0, 0 );
        rf_destroy_pose( &pose );
        assert_hash_of_pose( &scene, 0.5 * k );
    }
    assert_true( rf_scene_moves( &scene, 1.0, 1.5 ) );
    assert_false( rf_scene_moves( &scene, 3.0, 4.0 ) );
    rf_destroy_scene( &scene );
}

// A metal that is a mirror in the file is none where its roughness changes; one whose colour changes stays one.
TEST( test_metals_that_change )
{
    GltfBuilder b = make_keys(), c = make_keys();
    RfScene scene =
        gltf_load_built( &b, TWO_TRIANGLES "\"materials\":[{},{\"pbrMetallicRoughness\":{\"roughnessFactor\":0}}]," ANIMATE(
                                 KEYS( "14" ), CHANGES( "0", PBR "roughnessFactor" ) ) );
    assert_int_equal( scene.materials[1].kind, RF_BSDF_GGX );
    rf_destroy_scene( &scene );
    scene = gltf_load_built( &c, TWO_TRIANGLES "\"materials\":[{},{\"pbrMetallicRoughness\":{\"roughnessFactor\":0}}]," ANIMATE(
                                     KEYS( "12" ), CHANGES( "0", PBR "baseColorFactor" ) ) );
    assert_int_equal( scene.materials[1].kind, RF_BSDF_GLASS );
    RfPosedScene pose = gltf_pose_at( &scene, 2.0 );
    gltf_assert_rgb( pose.scene.materials[1].specular, 0.5, 0.25, 0 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
}

// What a material of its own model has no use for, and what no triangle has, changes nothing.
TEST( test_what_changes_without_effect )
{
    GltfBuilder b = make_keys(), c = make_keys();
    RfScene scene = gltf_load_built( &b, TWO_TRIANGLES "\"materials\":[{},{\"extras\":{\"reframe\":{\"bsdf\":\"lambert\","
                                                       "\"diffuse\":[1,0,0]}}}]," SHAPES );
    assert_null( scene.movement );
    assert_int_equal( scene.triangles.count, 2 );
    rf_destroy_scene( &scene );
    scene = gltf_load_built(
        &c, "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[" TRIANGLE( "0" ) "]}],\"materials\":[{},{}]," SHAPES );
    assert_null( scene.movement );
    rf_destroy_scene( &scene );
}

#define TRANSFORM PBR "baseColorTexture/extensions/KHR_texture_transform/"
#define TEXTURED                                                                                                                 \
    "\"images\":[{\"bufferView\":15,\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],\"materials\":[{},{"              \
    "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"rotation\":0.5,"   \
    "\"scale\":[3,4]}}}}}],"

TEST( test_a_texture_that_slides )
{
    GltfBuilder b = make_keys();
    RfScene scene =
        gltf_load_built( &b, TWO_TRIANGLES TEXTURED ANIMATE( KEYS( "13" ) "," KEYS( "3" ),
                                                             CHANGES( "0", TRANSFORM "offset" ) "," CHANGES(
                                                                 "1", TRANSFORM "rotation" ) "," CHANGES( "0", "/materials/1/"
                                                                                                               "occlusionTexture/"
                                                                                                               "extensions/KHR_"
                                                                                                               "texture_"
                                                                                                               "transform/"
                                                                                                               "offset" ) ) );
    assert_int_equal( scene.unrendered_count, 0 );
    assert_int_equal( scene.movement->change_count, 2 ); // occlusion is ignored at all times
    for ( int k = 1; k <= 7; ++k )
    {
        double t = part_of( 0.5 * k ), angle = 0.5 + 0.5 * t;
        RfPosedScene pose = gltf_pose_at( &scene, 0.5 * k );
        const float* to = pose.scene.materials[1].textured->refs[RF_TEXTURE_BASE].transform;
        gltf_assert_three( to, 3.0 * cos( angle ), 4.0 * sin( angle ), 2.0 * t );
        gltf_assert_three( to + 3, -3.0 * sin( angle ), 4.0 * cos( angle ), 1.0 - t );
        rf_destroy_pose( &pose );
    }
    rf_destroy_scene( &scene );
}

// ---- Clocks and choices -------------------------------------------------------------

#define LAMP "\"nodes\":[{\"name\":\"a\"," WITH_LIGHT "}]," BULB ","
#define DIMMER ANIMATE( KEYS( "1" ), CHANGES( "0", LIGHT "intensity" ) )

static void assert_intensity( const RfScene* scene, double time, double want )
{
    RfPosedScene pose = gltf_pose_at( scene, time );
    gltf_assert_rgb( pose.scene.punctuals[0].intensity, want, want, want );
    rf_destroy_pose( &pose );
}

// From 10 s on, four times as fast: a round takes half a second.
TEST( test_a_clock )
{
    GltfBuilder b = make_keys();
    RfClock clock = { .start = 10.0, .speed = 4.0, .loops = true };
    RfScene scene = gltf_load_with( write_gltf( &b, &gltf_folder, LAMP DIMMER ), &( RfGltfOptions ){ .clock = &clock } );
    assert_true( scene.movement->start == 10.0 && scene.movement->end == 10.5 );
    assert_intensity( &scene, 9.0, 0.0 );
    assert_intensity( &scene, 10.125, 2.0 );
    assert_intensity( &scene, 12.25, 4.0 );
    rf_destroy_scene( &scene );
}

#define NAMED( name, samplers )                                                                                                  \
    "{\"name\":\"" name "\",\"samplers\":[" samplers "],\"channels\":[" CHANGES( "0", LIGHT "intensity" ) "]}"

TEST( test_animations_that_contend )
{
    GltfBuilder b = make_keys();
    const char* path =
        write_gltf( &b, &gltf_folder, LAMP "\"animations\":[" NAMED( "on", KEYS( "1" ) ) "," NAMED( "off", KEYS( "10" ) ) "]" );
    RfScene scene = gltf_load( path );
    gltf_assert_warned( "animation 'on' is used: 'off', which moves the same, is left out" );
    assert_intensity( &scene, 3.0, 8.0 );
    rf_destroy_scene( &scene );
    scene = gltf_load_with( path, &( RfGltfOptions ){ .animation = "off" } );
    assert_intensity( &scene, 1.0, 7.0 );
    rf_destroy_scene( &scene );
}

// As in the first frame, or at another time.
TEST( test_frozen )
{
    double at = 2.0;
    GltfBuilder b = make_keys(), c = make_keys();
    RfScene scene = gltf_load_with( write_gltf( &b, &gltf_folder, LAMP DIMMER ), &( RfGltfOptions ){ .freeze = true } );
    assert_null( scene.movement );
    assert_true( scene.frozen && !scene.punctuals[0].changes );
    gltf_assert_warned( "light 'a' moves or changes: frozen as in the first frame" );
    gltf_assert_rgb( scene.punctuals[0].intensity, 0, 0, 0 );
    rf_destroy_scene( &scene );
    scene = gltf_load_with( write_gltf( &c, &gltf_folder, TWO_TRIANGLES "\"materials\":[{},{\"name\":\"glow\"}]," GLOW ),
                            &( RfGltfOptions ){ .freeze = true, .frozen_at = &at } );
    assert_null( scene.movement );
    gltf_assert_warned( "material 'glow' moves or changes: frozen as in the first frame" );
    gltf_assert_rgb( scene.materials[1].emission, 1.75, 0.875, 0 );
    assert_false( scene.materials[1].dims );
    rf_destroy_scene( &scene );
}

// Equal keys say what a value is, and nothing changes.
TEST( test_keys_that_are_equal )
{
    GltfBuilder b = make_keys();
    int same = add_gltf_floats( &b, "SCALAR", 1, 2, ( const float[] ){ 3, 3 } );
    assert_int_equal( same, 16 );
    RfScene scene = gltf_load_built( &b, LAMP ANIMATE( KEYS( "16" ), CHANGES( "0", LIGHT "intensity" ) ) );
    assert_null( scene.movement );
    gltf_assert_rgb( scene.punctuals[0].intensity, 3, 3, 3 );
    rf_destroy_scene( &scene );
}

// The list of an exporter names nodes: that of a lamp that dims is rendered, another is not.
TEST( test_what_is_said_to_change )
{
    GltfBuilder b = make_keys();
    RfScene scene = gltf_load_built(
        &b, "\"scenes\":[{\"nodes\":[0],\"extras\":{\"reframe\":{\"moving\":[\"a\",\"smoke\"]}}}]," LAMP DIMMER );
    assert_int_equal( scene.unrendered_count, 1 );
    assert_string_equal( scene.unrendered[0].what, "object 'smoke'" );
    rf_destroy_scene( &scene );
}

TEST( test_what_is_left_out )
{
    GltfBuilder b = make_keys(), c = make_keys();
    RfScene scene = gltf_load_built( &b, LAMP DIMMER );
    assert_int_equal( rf_choose_effects( &scene, 0, RF_EFFECT_BIT( RF_EFFECT_PUNCTUAL_LIGHTS ), NULL ), RF_OK );
    RfPosedScene pose = gltf_pose_at( &scene, 2.0 );
    assert_int_equal( pose.scene.punctual_count, 0 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
    scene = gltf_load_built( &c, TWO_TRIANGLES "\"materials\":[{},{}]," GLOW );
    assert_int_equal( rf_choose_effects( &scene, 0, RF_EFFECT_BIT( RF_EFFECT_AREA_LIGHTS ), NULL ), RF_OK );
    pose = gltf_pose_at( &scene, 2.0 );
    gltf_assert_rgb( pose.scene.materials[1].emission, 0, 0, 0 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
}

// ---- Lenses -----------------------------------------------------------------------

#define CAMERA "\"nodes\":[{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}]"
#define ZOOM( keys )                                                                                                             \
    CAMERA "," ANIMATE( keys, CHANGES( "0", "/cameras/0/perspective/yfov" ) "," CHANGES( "0", "/cameras/0/perspective/znear" ) )

// The focal length, in pixels of a picture 200 high, is 100 / tan(yfov / 2).
TEST( test_a_camera_that_zooms )
{
    GltfBuilder b = make_keys();
    RfScene scene = gltf_load_built( &b, ZOOM( KEYS( "3" ) ) );
    const RfCamera* camera = scene.cameras;
    RfEye eye;
    RfCameraFrames frames;
    assert_int_equal( scene.unrendered_count, 0 ); // the near plane is ignored when it stands still, too
    assert_null( scene.movement );                 // nothing in the world moves
    assert_true( camera->animated && camera->start == 1.0 && camera->end == 3.0 );
    assert_int_equal( rf_camera_frames( &scene, camera, 4.0, &frames, NULL ), RF_OK );
    assert_int_equal( frames.count, 13 );
    for ( int k = 1; k <= 7; ++k )
    {
        assert_int_equal(
            rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras, NULL, { 1, 1 }, 300, 200 }, 0.5 * k, &eye, NULL ),
            RF_OK );
        gltf_assert_near( eye.focal, 100.0 / tan( 0.5 * ( 0.5 + 0.5 * part_of( 0.5 * k ) ) ) );
    }
    RfLens lens = { .has_shutter = true, .shutter = { -0.25, 0.25 } };
    RfCameraSampling sampling = { &scene, camera, &lens, { 4, 1 }, 300, 200 };
    assert_int_equal( rf_camera_eye( &sampling, 8.0, &eye, NULL ), RF_OK );
    gltf_assert_near( eye.focal, 100.0 / tan( 0.375 ) );
    assert_true( eye.moves );
    rf_destroy_scene( &scene );
}

// Two cameras, of which an edit shows the second first; the default has as many pixels as 960x540.
TEST( test_the_shape_of_the_picture )
{
#define TALL "{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1,\"aspectRatio\":0.5625}}"
#define EVEN "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":-3,\"ymag\":3,\"znear\":0,\"zfar\":9}}"
    GltfBuilder b = make_keys();
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"camera\":0,\"name\":\"tall\"},{\"camera\":1,\"name\":\"even\"}],\"scenes\":[{\"nodes\":[0,1]}],"
            "\"cameras\":[" TALL "," EVEN "]" );
    RfEditShot shots[] = { { 1, 0.0 }, { 0, 1.0 } };
    RfCamera cameras[] = { scene.cameras[0], scene.cameras[1], { .name = "edit", .edit = &( RfEdit ){ 2, shots, false } } };
    RfScene edited = scene;
    edited.cameras = cameras;
    edited.camera_count = 3;
    static const struct
    {
        const char* camera;
        int asked[2], size[2];
        double unmet;
    } cases[] = {
        { "tall", { 0, 0 }, { 540, 960 }, 0.0 },    { "even", { 0, 0 }, { 720, 720 }, 0.0 },
        { "tall", { 9, 16 }, { 9, 16 }, 0.0 },      { "tall", { 360, 641 }, { 360, 641 }, 0.0 }, // to a pixel
        { "tall", { 64, 36 }, { 64, 36 }, 0.5625 }, { "even", { 64, 36 }, { 64, 36 }, 1.0 },
        { "edit", { 0, 0 }, { 720, 720 }, 0.5625 }, { "edit", { 64, 36 }, { 64, 36 }, 1.0 },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        RfCameraPath path;
        RfPathOptions options = { .camera = cases[i].camera, .width = cases[i].asked[0], .height = cases[i].asked[1] };
        assert_int_equal( rf_create_camera_path( &edited, &options, &path, NULL ), RF_OK );
        assert_int_equal( path.eyes->width, cases[i].size[0] );
        assert_int_equal( path.eyes->height, cases[i].size[1] );
        gltf_assert_near( path.unmet_aspect, cases[i].unmet );
        rf_destroy_camera_path( &path );
    }
    edited.film_width = edited.film_height = 32; // the file's own goes before
    RfCameraPath path;
    assert_int_equal( rf_create_camera_path( &edited, &( RfPathOptions ){ .camera = "tall" }, &path, NULL ), RF_OK );
    assert_int_equal( path.eyes->height, 32 );
    rf_destroy_camera_path( &path );
    rf_destroy_scene( &scene );
}

TEST( test_a_camera_that_jumps_to_another_lens )
{
    GltfBuilder b = make_keys();
    RfScene scene = gltf_load_built( &b, ZOOM( STEPS( "0", "3" ) ) );
    assert_int_equal( scene.cameras[0].cut_count, 1 );
    assert_true( scene.cameras[0].cuts[0] == 3.0 );
    rf_destroy_scene( &scene );
}

// ---- Files that are broken ----------------------------------------------------------

static const struct
{
    const char *rest, *part;
} s_broken[] = {
    { LAMP ANIMATE( KEYS( "16" ), CHANGES( "0", LIGHT "intensity" ) ),
      "animations[0].samplers[0]: intensity of the output is -1, it must be 0 to 1e+09" },
    { LAMP ANIMATE( KEYS( "17" ), CHANGES( "0", LIGHT "intensity" ) ),
      "intensity of the output is 1e+10, beyond what reframe reads" },
    { LAMP ANIMATE( KEYS( "1" ), CHANGES( "0", LIGHT "range" ) ), "range of the output is 0, it must be more than 0" },
    { LAMP ANIMATE( KEYS( "2" ), CHANGES( "0", LIGHT "intensity" ) ), "accessors[2] has elements of 3 numbers, 1 are needed" },
    { LAMP ANIMATE( KEYS( "1" ), CHANGES( "0", "/extensions/KHR_lights_punctual/lights/1/intensity" ) ),
      "lights/1/intensity' names a light that does not exist" },
    { TWO_TRIANGLES ANIMATE( KEYS( "1" ), CHANGES( "0", "/materials/0/emissiveFactor" ) ),
      "names a material that does not exist" },
    { TWO_TRIANGLES "\"materials\":[{},{}]," ANIMATE( KEYS( "1" ), CHANGES( "0", PBR "roughnessFactor" ) ),
      "roughnessFactor of the output is 8, it must be 0 to 1" },
    { CAMERA "," ANIMATE( KEYS( "1" ), CHANGES( "0", "/cameras/0/perspective/yfov" ) ),
      "yfov of the output is 0, it must be more than 0 and at most 3.14159" },
    { "\"nodes\":[{\"name\":\"a\"," WITH_LIGHT
      "}]," LIGHTS( SPOT ) "," ANIMATE( KEYS( "3" ), CHANGES( "0", LIGHT "spot/innerConeAngle" ) ),
      "light 'a' at 2.25 s: the inner angle of its cone is larger than the outer" },
    { "\"nodes\":[{\"name\":\"a\"," WITH_LIGHT
      "}]," LIGHTS( "{\"type\":\"spot\",\"spot\":{},\"extras\":{\"reframe\":{\"profile\":{\"vertical\":[0,90],\"horizontal\":[0],"
                    "\"relative\":[1,0]}}}}" ) "," ANIMATE( KEYS( "3" ), CHANGES( "0", LIGHT "spot/innerConeAngle" ) ),
      "has a profile, which stands still, in the place of a cone that changes" },
};

TEST( test_broken_files )
{
    for ( size_t i = 0; i < sizeof s_broken / sizeof s_broken[0]; ++i )
    {
        GltfBuilder b = make_keys();
        add_gltf_floats( &b, "SCALAR", 1, 2, ( const float[] ){ 1, -1 } );
        add_gltf_floats( &b, "SCALAR", 1, 2, ( const float[] ){ 1, 1e10f } );
        gltf_refuse_built( &b, s_broken[i].rest, s_broken[i].part );
    }
}

#define RICH                                                                                                                     \
    "\"nodes\":[{\"mesh\":0},{" WITH_LIGHT "},{\"camera\":0}],\"meshes\":[{\"primitives\":[" TRIANGLE( "0" ) "," TRIANGLE(       \
        "1" ) "]}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}]"                            \
              "," LIGHTS( SPOT ) "," TEXTURED                                                                                    \
              ANIMATE( KEYS( "1" ) "," KEYS( "2" ) "," KEYS( "3" ) "," KEYS( "4" ) "," SPLINE "," KEYS( "13" ) "," KEYS( "11" ), \
                       FOUR_CHANGES "," CHANGES( "5", TRANSFORM "offset" ) "," CHANGES(                                          \
                           "6", "/materials/0/emissiveFactor" ) "," CHANGES( "2", "/cameras/0/perspective/"                      \
                                                                                  "yfov" ) ",{\"sampler\":"                      \
                                                                                           "3,\"target\":{"                      \
                                                                                           "\"node\":1,"                         \
                                                                                           "\"path\":"                           \
                                                                                           "\"translation\""                     \
                                                                                           "}}" )

TEST( test_mutated_files )
{
    size_t size;
    GltfBuilder b = make_keys();
    uint8_t *bytes = build_glb( &b, RICH, &size ), *mutated = malloc( size );
    RfScene scene = gltf_load( write_bytes( &gltf_folder, "a.glb", bytes, size ) );
    assert_int_equal( scene.unrendered_count, 0 );
    assert_int_equal( scene.movement->change_count, 6 );
    rf_destroy_scene( &scene );
    int loaded = 0;
    for ( uint64_t i = 0; i < 2000; ++i )
    {
        memcpy( mutated, bytes, size );
        RfError error = { 0 };
        size_t length = mutate_bytes( mutated, size, i );
        if ( rf_load_gltf( write_bytes( &gltf_folder, "a.glb", mutated, length ), &scene, NULL, &error ) != RF_OK )
        {
            assert_true( error.text[0] != 0 );
            continue;
        }
        RfPosedScene pose = { 0 };
        assert_true( rf_pose_scene( &scene, 1.75, &pose, &error ) == RF_OK || error.text[0] != 0 );
        rf_destroy_pose( &pose );
        rf_destroy_scene( &scene );
        loaded += 1;
    }
    assert_true( loaded > 100 );
    free( mutated );
    free( bytes );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
