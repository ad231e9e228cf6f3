// Frames of a scene that moves, as files: alone, in ranges, resumed, and up to a failure.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

// A lit plate, which moves by `to` within [from, end) of 4 s, before a camera.
static void write_scene( const char* name, float from, float end, float to )
{
    static const float s_plate[] = { -1, -1, -3, 1, -1, -3, 1, 1, -3, -1, 1, -3 };
    static const float s_wall[] = { -9, -9, -6, 9, -9, -6, 9, 9, -6, -9, 9, -6 };
    static const uint16_t s_faces[] = { 0, 1, 2, 0, 2, 3 };
    const float times[] = { 0, from, end, 4 }, places[] = { 0, 0, 0, to, 0, 0, 0, 0, 0, 0, 0, 0 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_plate );
    add_gltf_u16( &b, 6, s_faces );
    add_gltf_floats( &b, "VEC3", 3, 4, s_wall );
    add_gltf_floats( &b, "SCALAR", 1, 4, times );
    add_gltf_floats( &b, "VEC3", 3, 4, places );
    size_t size;
    AUTO_FREE uint8_t* bytes = build_glb(
        &b,
        "\"nodes\":[{\"mesh\":1},{\"mesh\":0,\"name\":\"plate\"},{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\","
        "\"perspective\":{\"yfov\":0.7,\"znear\":0.1}}],\"materials\":[{},{\"emissiveFactor\":[0.5,0.5,0.5]}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]},{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":2},\"indices\":1,\"material\":1}]}],\"animations\":[{\"samplers\":[{\"input\":3,\"output\":4,"
        "\"interpolation\":\"STEP\"}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"translation\"}}]}]",
        &size );
    cli_write( name, bytes, size );
}

#define OPTIONS "--size 24x16 --spp 5 --float --quiet"
#define MOVING OPTIONS " --fps 2 --group 1 --aov motion"

TEST( test_frames_are_those_of_the_sequence )
{
    write_scene( "a.glb", 1.0f, 2.5f, 0.7f );
    cli_expect( cli_run( "$R render a.glb -o all.####.exr --frames 1-7 " MOVING ), 0, NULL );
    cli_expect( cli_run( "$R render a.glb -o part.####.exr --frames 3,6-7 " MOVING ), 0, NULL );
    cli_expect( cli_run( "for k in 3 6 7; do cmp all.000$k.exr part.000$k.exr || exit 1; done" ), 0, NULL );
    cli_expect( cli_run( "! cmp -s all.0002.exr all.0003.exr" ), 0, NULL ); // the same camera, another world
    cli_expect( cli_run( "cp all.0003.exr kept.exr; rm all.0003.exr all.0005.exr" ), 0, NULL );
    cli_expect( cli_run( "$R render a.glb -o all.####.exr --frames 1-7 --resume --json r.json " MOVING ), 0, NULL );
    cli_expect( cli_run( "cmp kept.exr all.0003.exr" ), 0, NULL );
    json_auto_t* json = cli_read_json( "r.json" );
    assert_int_equal( json_integer_value( json_object_get( json, "kept_frames" ) ), 5 );
    write_scene( "a.glb", 1.0f, 2.5f, 0.8f );
    cli_expect( cli_run( "$R render a.glb -o all.####.exr --frames 1-7 --resume " MOVING ), 1, "another scene" );
    cli_expect( cli_run( "$R render a.glb -o blur.####.exr --frames 3 --shutter 1 --blur-steps 2 " MOVING ), 0, NULL );
    cli_expect( cli_run( "$R render a.glb -o blur.####.exr --frames 3 --shutter 1 --resume " MOVING ), 1,
                "another render, of --blur-steps 2 (here 4): " );
    cli_expect( cli_run( "$R render a.glb -o blur.####.exr --frames 3 --resume " MOVING ), 1, "another scene" );
}

// What is written before a frame that cannot be posed stays, and is whole.
TEST( test_a_failure_leaves_whole_files )
{
    write_scene( "b.glb", 2.1f, 2.2f, 3e15f );
    cli_expect( cli_run( "$R render b.glb -o b.####.exr --frames 1-20 --fps 7 --group 0 --tile 1 " OPTIONS ), 1,
                "object 'plate' at 2.14286 s" );
    cli_expect( cli_run( "test -e b.0015.exr && ! test -e b.0016.exr && ls b.*.exr | wc -l | grep -q '^15$'" ), 0, NULL );
    cli_expect( cli_run( "for f in b.*.exr; do $R png $f $f.png || exit 1; done" ), 0, NULL );
}

// All of them brighten.
static void write_many_lamps( const char* name, int count )
{
    static const float s_wall[] = { -9, -9, -6, 9, -9, -6, 9, 9, -6, -9, 9, -6 };
    const float times[] = { 0, 4 }, strength[] = { 0, 9 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_wall );
    add_gltf_u16( &b, 6, ( const uint16_t[] ){ 0, 1, 2, 0, 2, 3 } );
    add_gltf_floats( &b, "SCALAR", 1, 2, times );
    add_gltf_floats( &b, "SCALAR", 1, 2, strength );
    char *text = malloc( 1024 + 512 * (size_t)count ), *end = text;
    end += sprintf( end, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"extensions\":{"
                         "\"KHR_lights_punctual\":{\"lights\":[" );
    for ( int i = 0; i < count; ++i )
        end += sprintf( end, "%s{\"type\":\"point\"}", i > 0 ? "," : "" );
    end += sprintf( end, "]}},\"nodes\":[{\"mesh\":0}" );
    for ( int i = 0; i < count; ++i )
        end += sprintf( end, ",{\"extensions\":{\"KHR_lights_punctual\":{\"light\":%d}}}", i );
    end += sprintf( end, "],\"animations\":[{\"samplers\":[{\"input\":2,\"output\":3}],\"channels\":[" );
    for ( int i = 0; i < count; ++i )
        end += sprintf( end,
                        "%s{\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{"
                        "\"pointer\":\"/extensions/KHR_lights_punctual/lights/%d/intensity\"}}}}",
                        i > 0 ? "," : "", i );
    sprintf( end, "]}]" );
    size_t size;
    AUTO_FREE uint8_t* bytes = build_glb( &b, text, &size );
    cli_write( name, bytes, size );
    free( text );
}

TEST( test_info_names_so_many )
{
    write_many_lamps( "many.glb", 67 );
    cli_expect( cli_run( "$R info many.glb > many.txt && grep -c 'light .*: intensity' many.txt | grep -qx 67 &&"
                         "! grep -q '^  and .* more' many.txt && grep -qx 'changing   67' many.txt" ),
                0, NULL );
}

// Three lamps before a wall: one of them holds, one is dimmed from nothing to its own strength, one moves a little.
static void write_lamps( const char* name )
{
    static const float s_wall[] = { -9, -9, -6, 9, -9, -6, 9, 9, -6, -9, 9, -6 };
    static const uint16_t s_faces[] = { 0, 1, 2, 0, 2, 3 };
    const float times[] = { 0, 4 }, places[] = { -0.1f, 0, -4, 0.1f, 0, -4 }, strength[] = { 0, 9 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_wall );
    add_gltf_u16( &b, 6, s_faces );
    add_gltf_floats( &b, "SCALAR", 1, 2, times );
    add_gltf_floats( &b, "VEC3", 3, 2, places );
    add_gltf_floats( &b, "SCALAR", 1, 2, strength );
    size_t size;
#define LAMP( name ) "{\"name\":\"" name "\",\"type\":\"point\",\"intensity\":9}"
#define AT( x, light )                                                                                                           \
    "{\"name\":\"node " light "\",\"translation\":[" x ",0,-4],\"extensions\":{\"KHR_lights_punctual\":{\"light\":" light "}}}"
    AUTO_FREE uint8_t* bytes = build_glb(
        &b,
        "\"extensionsUsed\":[\"KHR_lights_punctual\",\"KHR_animation_pointer\"],\"extensions\":{\"KHR_lights_punctual\":{"
        "\"lights\":[" LAMP( "held" ) "," LAMP( "dimmed" ) "," LAMP( "moved" ) "]}},\"nodes\":[{\"mesh\":0},{\"camera\":0}," AT(
            "-1", "0" ) "," AT( "1", "1" ) "," AT( "0", "2" ) "],\"cameras\":[{\"type\":\"perspective\",\"perspective\":"
                                                              "{\"yfov\":0.7,\"znear\":0.1}}],\"materials\":[{}],\"meshes\":[{"
                                                              "\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                                                              "\"indices\":1,\"material\":0}]}],\"animations\":[{\"samplers\":[{"
                                                              "\"input\":2,\"output\":3},{\"input\":2,"
                                                              "\"output\":4}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":"
                                                              "4,\"path\":\"translation\"}},{\"sampler\":1,"
                                                              "\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_"
                                                              "pointer\":{\"pointer\":"
                                                              "\"/extensions/KHR_lights_punctual/lights/1/intensity\"}}}}]}]",
        &size );
    cli_write( name, bytes, size );
}

// Lamps that move are looked up in each frame of a group of up to 9: of 13, at the ends of the path alone.
TEST( test_lamps_at_the_ends_of_a_path )
{
    write_lamps( "ends.glb" );
    cli_expect( cli_run( "$R render ends.glb -o ends.####.exr --fps 4 --group 6 " OPTIONS ), 0, NULL );
    cli_expect( cli_run( "$R render ends.glb -o alone.####.exr --fps 4 --group 6 --threads 1 --frames 1,9,17 " OPTIONS ), 0,
                NULL );
    cli_expect( cli_run( "for k in 01 09 17; do cmp ends.00$k.exr alone.00$k.exr || exit 1; done" ), 0, NULL );
}

static void check_change( const json_t* json, size_t index, const char* name, const char* what, const char* way, double share )
{
    const json_t* change = json_array_get( json_object_get( json, "changing" ), index );
    assert_string_equal( json_string_value( json_object_get( change, "name" ) ), name );
    assert_string_equal( json_string_value( json_array_get( json_object_get( change, "what" ), 0 ) ), what );
    assert_int_equal( json_array_size( json_object_get( change, "what" ) ), 1 );
    assert_int_equal( json_integer_value( json_object_get( json_object_get( change, "frames" ), way ) ), 9 );
    assert_float_equal( json_number_value( json_object_get( change, "share" ) ), share, 0.05 );
}

TEST( test_info_says_how_lamps_are_shared )
{
    write_lamps( "lamps.glb" );
    const CliResult* told = cli_run( "$R info lamps.glb --fps 2 --group 2" );
    assert_non_null( strstr( told->out, "  light 'dimmed': intensity; scaled; 2" ) );
    assert_non_null( strstr( told->out, "  light 'moved': place; shared; 4" ) );
    assert_non_null( strstr( told->out, "on   moving                light 'dimmed' and 1 more change from 0 to 4 s" ) );
    cli_expect( cli_run( "$R info lamps.glb --fps 2 --group 2 --json info.json" ), 0, NULL );
    json_t *json = cli_read_json( "info.json" ), *sharing = json_object_get( json, "sharing" );
    assert_int_equal( json_array_size( json_object_get( json, "changing" ) ), 2 );
    check_change( json, 0, "dimmed", "intensity", "scaled", 0.2 );
    check_change( json, 1, "moved", "place", "shared", 0.4 );
    assert_float_equal( json_number_value( json_object_get( sharing, "shared" ) ), 0.8, 0.05 );
    assert_float_equal( json_number_value( json_object_get( sharing, "own_frame" ) ), 0.0, 0.05 );
    json_decref( json );
    // alone, frames share nothing; frozen, nothing changes
    told = cli_run( "$R info lamps.glb --fps 2 --group 0" );
    assert_non_null( strstr( told->out, "  light 'moved': place; 4" ) );
    assert_null( strstr( cli_run( "$R info lamps.glb --freeze" )->out, "changing" ) );
    cli_expect( cli_run( "$R render lamps.glb -o l.####.exr --fps 2 --group 2 --json render.json " OPTIONS ), 0, NULL );
    json = cli_read_json( "render.json" );
    check_change( json, 1, "moved", "place", "shared", 0.4 );
    json_decref( json );
}

#define PANELS 23
#define SIDE 10 // tiles of a panel, of 0.1 m by 0.2 m

// Luminous panels on a node that moves.
static void write_panels( const char* name )
{
    static const float s_times[] = { 0, 4 }, s_places[] = { 0, 0, -3, 1, 0, -3 };
    float corners[( SIDE + 1 ) * ( SIDE + 1 )][3];
    uint16_t faces[SIDE * SIDE][6];
    for ( int i = 0; i < ( SIDE + 1 ) * ( SIDE + 1 ); ++i )
        memcpy( corners[i], ( float[] ){ 0.1f * (float)( i % ( SIDE + 1 ) ), 0.2f * (float)( i / ( SIDE + 1 ) ), 0 }, 12 );
    for ( int i = 0; i < SIDE * SIDE; ++i )
    {
        uint16_t a = (uint16_t)( i % SIDE + i / SIDE * ( SIDE + 1 ) ), b = (uint16_t)( a + 1 ), d = (uint16_t)( a + SIDE + 1 );
        memcpy( faces[i], ( uint16_t[] ){ a, b, (uint16_t)( d + 1 ), a, (uint16_t)( d + 1 ), d }, 12 );
    }
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, ( SIDE + 1 ) * ( SIDE + 1 ), corners[0] );
    add_gltf_u16( &b, 6 * SIDE * SIDE, faces[0] );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "VEC3", 3, 2, s_places );
    char text[2048 + PANELS * 64], *end = text;
    end += sprintf( end,
                    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.7,\"znear\":0.1}}],\"materials\":[{"
                    "\"emissiveFactor\":[1,1,1]}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
                    "\"material\":0}]}],\"animations\":[{\"samplers\":[{\"input\":2,\"output\":3}],\"channels\":[{\"sampler\":0,"
                    "\"target\":{\"node\":1,\"path\":\"translation\"}}]}],\"nodes\":[{\"camera\":0},{\"children\":[2" );
    for ( int i = 1; i < PANELS; ++i )
        end += sprintf( end, ",%d", 2 + i );
    end += sprintf( end, "]}" );
    for ( int i = 0; i < PANELS; ++i )
        end += sprintf( end, ",{\"mesh\":0,\"translation\":[%d,0,0]}", 2 * i );
    sprintf( end, "],\"scenes\":[{\"nodes\":[0,1]}]" );
    size_t size;
    AUTO_FREE uint8_t* bytes = build_glb( &b, text, &size );
    cli_write( name, bytes, size );
}

// The area of what moves counts; what is known is said at once, where choosing a group for so many would take long.
TEST( test_info_of_many_that_move_and_shine )
{
    write_panels( "panels.glb" );
    const CliResult* told = cli_run( "$R info panels.glb" );
    assert_non_null( strstr( told->out, "(emissive triangles 4600, 46 m2; " ) );
    assert_non_null( strstr( told->out, "sharing    not known: " ) && strstr( told->out, ": give --group N\n" ) );
    told = cli_run( "$R info panels.glb --fps 1 --group 1" );
    assert_non_null( strstr( told->out, "in groups of 3 frames 0 % of the light is shared, 0 % scaled, 100 % own-frame" ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
