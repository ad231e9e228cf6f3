// What a compositor reads from files: names and conventions of their channels, windows, time codes and cameras.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "image/exr.h"
#include "output/names.h"

#include <openexr.h>

// The same channels in three files, by their names there, with the opposite sign where that is Blender's.
static void compare_pass( const char* pass, const char* letters )
{
    static const char* const files[] = { "reframe.0011.exr", "blender.0011.exr", "blender5.0011.exr", "nuke.0011.exr" };
    for ( int i = 0; letters[i] != '\0'; ++i )
    {
        RfPassChannel own;
        RfExrWindow window;
        rf_name_pass_channel( RF_NAMES_REFRAME, pass, letters, i, &own );
        AUTO_FREE float* wanted = cli_read_channel( files[0], own.name, &window );
        for ( int n = RF_NAMES_BLENDER; n <= RF_NAMES_NUKE; ++n )
        {
            for ( int k = 0; letters[k] != '\0'; ++k )
            {
                RfPassChannel channel;
                rf_name_pass_channel( (RfPassNames)n, pass, letters, k, &channel );
                if ( channel.component != i )
                    continue;
                AUTO_FREE float* values = cli_read_channel( files[n], channel.name, &window );
                for ( int p = 0; p < window.width * window.height; ++p )
                    assert_true( values[p] == ( channel.negated ? -wanted[p] : wanted[p] ) );
            }
        }
    }
}

#define FRAMES "--size 32x18 --spp 2 --group 1 --frames 10-11 --alpha --quiet --aov albedo,normal,depth,motion,variance,samples"

TEST( test_names )
{
    static const char* const words[] = { "reframe", "blender", "blender5", "nuke" };
    for ( int n = 0; n < 4; ++n )
        cli_expect( cli_run( "$R render $VASE -o %s.####.exr --names %s " FRAMES, words[n], words[n] ), 0, NULL );
    compare_pass( RF_PASS_PICTURE, "RGB" );
    compare_pass( "alpha", "A" );
    compare_pass( "albedo", "RGB" );
    compare_pass( "normal", "XYZ" );
    compare_pass( "depth", "Z" );
    compare_pass( "motion", "XYZW" );
    compare_pass( "samples", "Y" );
    // a part for each: channels of a pass stay together
    cli_expect( cli_run( "$R render $VASE -o parts.####.exr --names nuke --parts each " FRAMES ), 0, NULL );
    const CliResult* result = cli_run( "$R compare parts.####.exr nuke.####.exr --json -" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "\"max\": 0.0" ) );
    // resume keeps one naming
    cli_expect( cli_run( "$R render $VASE -o nuke.####.exr --names nuke --resume " FRAMES ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o nuke.####.exr --resume " FRAMES ), 1, "--names nuke (here reframe)" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --names fusion" ), 2, "--names" );
}

// The other commands find motion, depth and variance by all names.
TEST( test_names_are_found )
{
    double f1[3], error[3];
    static const char* const words[] = { "reframe", "blender", "nuke" };
    for ( int n = 0; n < 3; ++n )
    {
        cli_expect( cli_run( "$R flicker %s.####.exr --json f.json > log", words[n] ), 0, NULL );
        json_t* json = cli_read_json( "f.json" );
        assert_true( json_is_true( json_object_get( json, "compensated" ) ) );
        assert_true( json_is_true( json_object_get( json, "masked" ) ) );
        f1[n] = number( json, "f1" );
        json_decref( json );
        cli_expect( cli_run( "$R report %s.####.exr -o page.html --overwrite --json r.json > log", words[n] ), 0, NULL );
        json = cli_read_json( "r.json" );
        error[n] = number( json_array_get( json_object_get( json, "sequences" ), 0 ), "aov_bytes" );
        json_decref( json );
        assert_true( error[n] > 0.0 );
        cli_expect( cli_run( "$R png %s.0011.exr %s.png && cmp %s.png reframe.png", words[n], words[n], words[n] ), 0, NULL );
        cli_expect(
            cli_run( "$R png %s.0011.exr --layer albedo a%s.png && cmp a%s.png areframe.png", words[n], words[n], words[n] ), 0,
            NULL );
    }
    assert_true( f1[1] == f1[0] && f1[2] == f1[0] );
}

// A wall 7 m before a camera that goes by 1 cm, 3, 5, 7, 9, 11: as tests of Blender 3.4 and 4.3 had it, where the film is 64 pixels
// wide, of 50 mm by 36 mm. Their file of frame 5 had X 1.14286, Y 0.571429, Z 1.39682, W 0.698412.
TEST( test_motion_is_blenders )
{
    static const float wall[] = { -9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0 };
    static const uint16_t faces[] = { 0, 1, 2, 0, 2, 3 };
    static const struct
    {
        const char* names;
        const char* channel[4];
        float wanted[4];
    } cases[] = {
        { "blender",
          { "ViewLayer.Vector.X", "ViewLayer.Vector.Y", "ViewLayer.Vector.Z", "ViewLayer.Vector.W" },
          { 1.1428571f, 0.5714286f, 1.3968254f, 0.6984127f } },
        // Nuke: to the pixel's place in the other frame
        { "nuke",
          { "backward.u", "backward.v", "forward.u", "forward.v" },
          { 1.1428571f, 0.5714286f, -1.3968254f, -0.6984127f } },
    };
    GltfBuilder b = { 0 };
    char keys[2048] = "";
    size_t size, used = 0;
    add_gltf_floats( &b, "VEC3", 3, 4, wall );
    add_gltf_u16( &b, 6, faces );
    AUTO_FREE uint8_t* bytes =
        build_glb( &b,
                   "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"emissiveFactor\":[1,1,1]}],\"meshes\":[{\"primitives\":"
                   "[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}]",
                   &size );
    cli_write( "wall.glb", bytes, size );
    for ( int f = 1; f <= 10; ++f )
        used += (size_t)snprintf( keys + used, sizeof keys - used,
                                  "%s{\"frame\":%d,\"position\":[%.4f,%.4f,7],\"target\":[%.4f,%.4f,0]}", f > 1 ? "," : "", f,
                                  0.01 * f * f, 0.005 * f * f, 0.01 * f * f, 0.005 * f * f );
    cli_expect(
        cli_run( "cat > path.json <<'EOF'\n{\"kind\":\"keyed\",\"interpolation\":\"linear\",\"fov\":%.9f,\"keys\":[%s]}\nEOF",
                 2.0 * atan( 18.0 / ( 64.0 * 50.0 / 36.0 ) ) * 180.0 / 3.14159265358979323846, keys ),
        0, NULL );
    for ( size_t i = 0; i < 2; ++i )
    {
        cli_expect(
            cli_run( "$R render wall.glb --camera path.json -o m.exr --frames 5 --size 64x36 --spp 1 --group 0 --aov motion "
                     "--names %s --overwrite --quiet",
                     cases[i].names ),
            0, NULL );
        for ( int c = 0; c < 4; ++c )
        {
            RfExrWindow window;
            AUTO_FREE float* values = cli_read_channel( "m.exr", cases[i].channel[c], &window );
            for ( int p = 0; p < 64 * 36; ++p )
            {
                if ( fabsf( values[p] - cases[i].wanted[c] ) > 1e-4f )
                    fail_msg( "%s is %g", cases[i].channel[c], (double)values[p] );
            }
        }
    }
}

// Standard attributes of a file.
typedef struct Standard
{
    exr_attr_box2i_t data, display;
    exr_attr_m44f_t camera, ndc;
    exr_attr_rational_t fps;
    exr_attr_timecode_t time;
    bool has_ndc, has_time;
} Standard;

static Standard read_standard( const char* name )
{
    exr_context_t file;
    Standard s = { 0 };
    assert_int_equal( exr_start_read( &file, cli_path( name ), NULL ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_get_data_window( file, 0, &s.data ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_get_display_window( file, 0, &s.display ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_attr_get_m44f( file, 0, "worldToCamera", &s.camera ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_attr_get_rational( file, 0, "framesPerSecond", &s.fps ), EXR_ERR_SUCCESS );
    s.has_ndc = exr_attr_get_m44f( file, 0, "worldToNDC", &s.ndc ) == EXR_ERR_SUCCESS;
    s.has_time = exr_attr_get_timecode( file, 0, "timeCode", &s.time ) == EXR_ERR_SUCCESS;
    exr_finish( &file );
    return s;
}

static bool is_window( const exr_attr_box2i_t* w, int x, int y, int width, int height )
{
    return w->min.x == x && w->min.y == y && w->max.x == x + width - 1 && w->max.y == y + height - 1;
}

// Mean of √|a − b|, which rare bright pixels hardly change, over the picture of `a`; `b` has (dx, dy) pixels more at the left
// and the top.
static double mean_difference( const char* a, const char* b, const char* channel, int dx, int dy )
{
    RfExrWindow w, wide;
    float *values = cli_read_channel( a, channel, &w ), *others = cli_read_channel( b, channel, &wide );
    double sum = 0.0;
    for ( int i = 0; i < w.width * w.height; ++i )
        sum += sqrt( fabs( (double)values[i] - (double)others[( i / w.width + dy ) * wide.width + i % w.width + dx] ) );
    free( values );
    free( others );
    return sum / ( w.width * w.height );
}

static double depth_error( const char* a, const char* b, int dx, int dy )
{
    RfExrWindow w, wide;
    float *values = cli_read_channel( a, "depth.Z", &w ), *others = cli_read_channel( b, "depth.Z", &wide );
    double sum = 0.0;
    for ( int i = 0; i < w.width * w.height; ++i )
        sum += fabs( (double)values[i] / (double)others[( i / w.width + dy ) * wide.width + i % w.width + dx] - 1.0 );
    free( values );
    free( others );
    return sum / ( w.width * w.height );
}

#define STILL "--size 60x36 --spp 60 --tile 1 --group 0 --frames 5 --quiet --float --aov depth "

TEST( test_overscan )
{
    cli_expect( cli_run( "$R render $VASE -o a.exr " STILL ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o b.exr --overscan 8%% " STILL ), 0, NULL ); // 4.8 columns, 2.88 rows
    cli_expect( cli_run( "$R render $VASE -o s.exr --seed 2 " STILL ), 0, NULL );
    Standard plain = read_standard( "a.exr" ), wide = read_standard( "b.exr" );
    assert_true( is_window( &plain.data, 0, 0, 60, 36 ) && is_window( &plain.display, 0, 0, 60, 36 ) );
    assert_true( is_window( &wide.data, -5, -3, 70, 42 ) && is_window( &wide.display, 0, 0, 60, 36 ) );
    // the camera is that of the display window
    assert_memory_equal( &plain.camera, &wide.camera, sizeof plain.camera );
    assert_memory_equal( &plain.ndc, &wide.ndc, sizeof plain.ndc );
    // the picture differs from the inner one as it does from one of another seed
    static const char* const channels[] = { "R", "G", "B" };
    for ( int c = 0; c < 3; ++c )
    {
        double inner = mean_difference( "a.exr", "b.exr", channels[c], 5, 3 ),
               noise = mean_difference( "a.exr", "s.exr", channels[c], 0, 0 );
        if ( !( inner > 0.9 * noise && inner < 1.1 * noise ) )
            fail_msg( "%s: the inner picture differs by %g, by chance %g", channels[c], inner, noise );
    }
    // a pixel beside, depth would be another
    double same = depth_error( "a.exr", "b.exr", 5, 3 );
    double beside = fmin( depth_error( "a.exr", "b.exr", 4, 3 ), depth_error( "a.exr", "b.exr", 5, 4 ) );
    if ( !( same < 0.005 && same < 0.25 * beside ) )
        fail_msg( "depth differs by %g, a pixel beside by %g", same, beside );
    // commands show and compare what there is
    cli_expect( cli_run( "$R compare b.exr b.exr > log" ), 0, NULL );
    cli_expect( cli_run( "$R compare a.exr b.exr" ), 1, NULL );
    cli_expect( cli_run( "$R render $VASE -o b.exr --resume " STILL ), 1, "--overscan 5x3 (here none)" );
    cli_expect( cli_run( "$R render $VASE -o b.exr --resume --overscan 8%% " STILL ), 0, NULL );
    cli_expect(
        cli_run( "$R render $VASE -o d.exr --names nuke --overscan 2 --timecode 01:00:00:00 --json d.json --size 8x6 --spp 1 "
                 "--frames 1 --quiet" ),
        0, NULL );
    json_t* json = cli_read_json( "d.json" );
    assert_string_equal( json_string_value( json_object_get( json, "names" ) ), "nuke" );
    assert_string_equal( json_string_value( json_object_get( json, "overscan" ) ), "2" );
    assert_string_equal( json_string_value( json_object_get( json, "timecode" ) ), "01:00:00:00" );
    json_decref( json );
    // as a scene file has it
    cli_expect(
        cli_run(
            "cp $VASE v.glb; echo '{\"scene\":\"v.glb\",\"render\":{\"overscan\":\"2\",\"size\":[8,6],\"spp\":1}}' > o.json; "
            "$R render o.json -o e.exr --frames 1 --quiet" ),
        0, NULL );
    wide = read_standard( "e.exr" );
    assert_true( is_window( &wide.data, -2, -2, 12, 10 ) && is_window( &wide.display, 0, 0, 8, 6 ) );
    // 0 is none, to the bytes
    cli_expect( cli_run( "$R render $VASE -o c.exr --overscan 0 " STILL "&& cmp a.exr c.exr" ), 0, NULL );
}

// Gradients are found by all names, and what is reconstructed from them has the windows of the frame.
TEST( test_reconstruct )
{
    static const char* const words[] = { "reframe", "blender", "nuke" };
    for ( int n = 0; n < 3; ++n )
    {
        cli_expect(
            cli_run( "$R render $VASE -o g.exr --overwrite --size 24x16 --overscan 3 --spp 4 --group 0 --frames 3 --quiet "
                     "--estimator gradient --aov gradients,variance --float --names %s",
                     words[n] ),
            0, NULL );
        cli_expect( cli_run( "$R reconstruct g.exr -o r%s.exr > log", words[n] ), 0, NULL );
        cli_expect( cli_run( "cmp r%s.exr rreframe.exr", words[n] ), 0, NULL );
    }
    exr_context_t file;
    exr_attr_box2i_t data, display;
    assert_int_equal( exr_start_read( &file, cli_path( "rblender.exr" ), NULL ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_get_data_window( file, 0, &data ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_get_display_window( file, 0, &display ), EXR_ERR_SUCCESS );
    exr_finish( &file );
    assert_true( is_window( &data, -3, -3, 30, 22 ) && is_window( &display, 0, 0, 24, 16 ) );
}

TEST( test_overscan_is_refused )
{
    static const char* const wrong[] = { "-1", "1.5", "101%", "x", "%", "5%%", "40000", "''" };
    for ( size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i )
        cli_expect( cli_run( "$R render $VASE -o x.exr --frames 1 --overscan %s", wrong[i] ), 2, "--overscan" );
    cli_expect( cli_run( "$R render $VASE -o x.exr --frames 1 --size 32000x10 --overscan 400" ), 2, "a side of more than 32768" );
    write_text( "round.json",
                "{\"kind\":\"orbit\",\"center\":[0,1,0],\"radius\":2,\"height\":1,\"duration\":1,\"projection\":\"panoramic\"}" );
    cli_expect( cli_run( "$R render $VASE -o x.exr --frames 1 --camera round.json --overscan 4" ), 2,
                "nothing around its picture" );
    assert_false( cli_exists( "x.exr" ) );
}

// Pixels of the display window at which a point of the world is seen, by worldToNDC.
static void project( const Standard* s, const double p[3], double at[2] )
{
    double q[4];
    for ( int j = 0; j < 4; ++j )
        q[j] = p[0] * (double)s->ndc.m[j] + p[1] * (double)s->ndc.m[4 + j] + p[2] * (double)s->ndc.m[8 + j] +
               (double)s->ndc.m[12 + j];
    double width = s->display.max.x + 1.0, height = s->display.max.y + 1.0;
    at[0] = 0.5 * width * ( 1.0 + q[0] / q[3] );
    at[1] = 0.5 * height * ( 1.0 - q[1] / q[3] );
}

// A bright square at (0.5, 0.25, -3), far smaller than the picture, is where the matrices say: for all cameras that have them.
TEST( test_matrices_say_where_things_are )
{
    static const float spot[] = { 0.4f, 0.15f, -3, 0.6f, 0.15f, -3, 0.6f, 0.35f, -3, 0.4f, 0.35f, -3 };
    static const uint16_t faces[] = { 0, 1, 2, 0, 2, 3 };
    static const char* const cameras[] = {
        "\"fov\":40",
        "\"fov\":40,\"shift\":[0.1,-0.15]",
        "\"fov\":40,\"pixelAspect\":1.5",
        "\"projection\":\"orthographic\",\"ymag\":1",
        "\"projection\":\"orthographic\",\"ymag\":1,\"shift\":[-0.1,0.2]",
        "\"fov\":40,\"lens\":{\"radius\":0.01,\"focus\":3}",
    };
    GltfBuilder b = { 0 };
    size_t size;
    add_gltf_floats( &b, "VEC3", 3, 4, spot );
    add_gltf_u16( &b, 6, faces );
    AUTO_FREE uint8_t* bytes =
        build_glb( &b,
                   "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"emissiveFactor\":[1,1,1]}],\"meshes\":[{\"primitives\":"
                   "[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}]",
                   &size );
    cli_write( "spot.glb", bytes, size );
    for ( size_t i = 0; i < 2 * sizeof cameras / sizeof cameras[0]; ++i )
    {
        char text[512];
        snprintf( text, sizeof text,
                  "{\"kind\":\"keyed\",%s,\"keys\":[{\"time\":0,\"position\":[0.1,0.2,0],\"target\":[0.15,0.2,-1]},"
                  "{\"time\":1,\"position\":[0.1,0.2,0],\"target\":[0.15,0.2,-1]}]}",
                  cameras[i / 2] );
        write_text( "one.json", text );
        cli_expect(
            cli_run( "$R render spot.glb --camera one.json -o s.exr --frames 1 --size 80x60 --spp 64 --group 0 --tile 1 --float "
                     "--filter box --quiet --overwrite %s",
                     i % 2 != 0 ? "--overscan 6" : "" ),
            0, NULL );
        RfExrWindow w;
        AUTO_FREE float* red = cli_read_channel( "s.exr", "R", &w );
        double sum = 0.0, x = 0.0, y = 0.0, at[2];
        for ( int k = 0; k < w.width * w.height; ++k )
        {
            sum += (double)red[k];
            x += (double)red[k] * ( w.x + k % w.width + 0.5 );
            y += (double)red[k] * ( w.y + k / w.width + 0.5 );
        }
        Standard s = read_standard( "s.exr" );
        static const double middle[3] = { 0.5, 0.25, -3.0 };
        assert_true( s.has_ndc && sum > 4.0 );
        project( &s, middle, at );
        if ( !( fabs( x / sum - at[0] ) < 0.1 && fabs( y / sum - at[1] ) < 0.1 ) )
            fail_msg( "%s: seen at (%.3f, %.3f), by the matrix at (%.3f, %.3f)", cameras[i / 2], x / sum, y / sum, at[0], at[1] );
    }
}

#define ONE "--size 8x6 --spp 1 --group 0 --quiet --overwrite "

static uint32_t time_of( const char* options )
{
    cli_expect( cli_run( "$R render $VASE -o t.####.exr %s " ONE, options ), 0, NULL );
    Standard s = read_standard( "t.0002.exr" );
    assert_true( s.has_time && s.time.user_data == 0 );
    return s.time.time_and_flags;
}

TEST( test_time_codes )
{
    assert_int_equal( time_of( "--frames 2" ), 0x02 );
    assert_int_equal( time_of( "--frames 2 --timecode 10:20:30:11" ), 0x10203012 );
    assert_int_equal( time_of( "--frames 2 --fps 30000/1001 --timecode '00:00:59;29'" ), 0x00010042 ); // drops 00:01:00;00 and 01
    assert_int_equal( time_of( "--frames 2 --fps 60 --timecode 00:00:00:58" ), 0x00008029 );           // the second of 29
    cli_expect( cli_run( "$R render $VASE -o n.####.exr --frames 2 --fps 120 " ONE ), 0, NULL );
    Standard s = read_standard( "n.0002.exr" );
    assert_true( !s.has_time && s.fps.num == 120 && s.fps.denom == 1 );
    cli_expect( cli_run( "$R render $VASE -o n.####.exr --frames 2 --fps 30000/1001 " ONE ), 0, NULL );
    s = read_standard( "n.0002.exr" );
    assert_true( s.has_time && s.fps.num == 30000 && s.fps.denom == 1001 && s.time.time_and_flags == 0x02 );
    cli_expect( cli_run( "$R render $VASE -o n.####.exr --timecode 01:00:00:24 " ONE ), 2,
                "--timecode: 01:00:00:24: at 24 frames" );
    cli_expect(
        cli_run( "$R render $VASE -o t.####.exr --frames 2 --resume --timecode 01:00:00:00 --size 8x6 --spp 1 --group 0" ), 1,
        "of another render" );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
