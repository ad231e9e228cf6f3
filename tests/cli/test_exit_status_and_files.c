// The program from outside: a failure is one line and the right exit status, a success
// leaves complete files, and neither interrupts nor full disks leave partial ones.
#include "support/cli_run.h"
#include "support/test.h"

#include <jansson.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include "image/exr.h"

// A small render of one still frame, and what every small render has.
#define SMALL "--size 24x16 --spp 1 --group 0 --quiet"

#define TRIANGLE "AACAvwAAgL8AAADAAACAPwAAgL8AAADAAAAAAAAAgD8AAADA"
#define NAN_TRIANGLE "AACAvwAAgL8AAADAAACAPwAAwH8AAADAAAAAAAAAgD8AAADA"
#define AWAY_TRIANGLE "AACAPwAAgL8AAADAAACAvwAAgL8AAADAAAAAAAAAgD8AAADA"
#define CAMERA_NODE "{\"name\":\"Eye\",\"camera\":0}"
#define CAMERAS "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"

// A triangle before a camera, as .gltf with its data inside.
static void write_gltf( const char* name, bool camera, const char* triangle, bool light )
{
    char text[4096], mesh[2048] = "";
    if ( triangle != NULL )
        snprintf( mesh, sizeof mesh,
                  ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
                  "\"materials\":[{\"name\":\"skin\",\"emissiveFactor\":[%d,%d,%d]}],"
                  "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
                  "\"min\":[-1,-1,-2],\"max\":[1,1,-2]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
                  "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,%s\"}]",
                  light, light, light, triangle );
    snprintf( text, sizeof text,
              "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,%s\"scenes\":[{\"nodes\":[0%s]}],\"nodes\":[%s%s%s]%s}",
              camera ? CAMERAS : "", camera && triangle != NULL ? ",1" : "", camera ? CAMERA_NODE : "",
              camera && triangle != NULL ? "," : "", triangle != NULL ? "{\"name\":\"thing\",\"mesh\":0}" : "", mesh );
    cli_write( name, text, strlen( text ) );
}

static int enter( void** state )
{
    (void)state;
    cli_enter();
    write_gltf( "one.gltf", true, TRIANGLE, true );
    return 0;
}

static int leave( void** state )
{
    (void)state;
    cli_leave();
    return 0;
}

static json_t* parse_json( const char* text )
{
    json_error_t error;
    json_t* json = json_loads( text, JSON_REJECT_DUPLICATES, &error );
    if ( json == NULL )
        fail_msg( "no JSON: %s in %s", error.text, text );
    return json;
}

static void expect_keys( const json_t* json, const char* keys )
{
    char copy[512];
    snprintf( copy, sizeof copy, "%s", keys );
    size_t count = 0;
    for ( char* key = strtok( copy, " " ); key != NULL; key = strtok( NULL, " " ), ++count )
    {
        if ( json_object_get( json, key ) == NULL )
            fail_msg( "the key %s is missing", key );
    }
    assert_int_equal( json_object_size( json ), count );
}

// Reads a frame of the folder and gives its mean.
static double mean_of( const char* name, int width, int height )
{
    AUTO_IMAGE image = cli_read_exr( name );
    assert_int_equal( image.width, width );
    assert_int_equal( image.height, height );
    double sum = 0.0;
    for ( int i = 0; i < 3 * width * height; ++i )
        sum += image.rgb[i];
    return sum / ( 3.0 * width * height );
}

TEST( test_help_and_version )
{
    static const char* const lines[] = {
        "$R --help",         "$R -h",         "$R --version", "$R render --help", "$R render --help --nonsense", "$R info -h",
        "$R compare --help", "$R png --help", "$R --man"
    };
    for ( size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i )
    {
        const CliResult* result = cli_run( "%s", lines[i] );
        cli_expect( result, 0, NULL );
        assert_string_equal( result->err, "" );
        assert_true( strlen( result->out ) > 5 );
    }
    const char* with = cli_run( "$R --version" )->out;
#ifdef REFRAME_WEBP
    assert_true( strstr( with, ", with " ) != NULL && strstr( with, "WebP" ) != NULL );
#endif
#ifdef REFRAME_DRACO
    assert_true( strstr( with, ", with " ) != NULL && strstr( with, "Draco" ) != NULL );
#endif
#ifdef REFRAME_MESHOPT
    assert_true( strstr( with, ", with " ) != NULL && strstr( with, "meshoptimizer" ) != NULL );
#endif
    assert_int_equal( strncmp( with, "reframe ", 8 ), 0 );
    cli_expect( cli_run( "$R --help > /dev/full" ), 1, "standard output cannot be written" );
}

TEST( test_usage_errors_exit_2 )
{
    cli_expect( cli_run( "$R" ), 2, "no command given" );
    cli_expect( cli_run( "$R rendr x" ), 2, "did you mean render?" );
    cli_expect( cli_run( "$R render one.gltf" ), 2, "reframe render: -o is missing" );
    cli_expect( cli_run( "$R render -o a.exr" ), 2, "reframe render: SCENE is missing" );
    cli_expect( cli_run( "$R render one.gltf -o a.exr --spp 0" ), 2,
                "reframe render: --spp: expected a whole number from 1 to 1048576, got '0'" );
    cli_expect( cli_run( "$R render one.gltf -o a.exr --smp 3" ), 2, "did you mean --spp?" );
    cli_expect( cli_run( "$R render one.gltf -o a.png" ), 2, "expected a name that ends in .exr" );
    cli_expect( cli_run( "$R render one.gltf -o a.exr --tile 3x" ), 2, "--tile: expected auto, 1, WxH such as 3x3, or rooksN" );
    cli_expect( cli_run( "$R render one.gltf -o a.exr --half --float" ), 2, "only one of the two" );
    cli_expect( cli_run( "$R render one.gltf -o a.exr --frames 2" ), 2, "the camera's path has 1 frame" );
    cli_expect( cli_run( "$R render one.gltf -o a.exr --camera Nobody" ), 2, "Nobody" );
    cli_expect( cli_run( "$R render $VASE -o a.exr --frames 1-2" ), 2, "has no ####" );
    cli_expect( cli_run( "$R render $VASE -o 'a##b##.exr' --frames 1-2" ), 2, "##" );
    cli_expect( cli_run( "$R info one.gltf two.gltf" ), 2, "one file too many" );
    assert_int_equal( cli_count_files( ".exr", "." ), 0 );
}

TEST( test_bad_scenes_exit_1 )
{
    cli_expect( cli_run( "$R render none.glb -o a.exr" ), 1, "none.glb" );
    cli_expect( cli_run( "head -c 10000 $VASE > cut.glb; $R render cut.glb -o a.exr" ), 1, "cut.glb" );
    cli_expect( cli_run( "head -c 7 $VASE > tiny.glb; $R info tiny.glb" ), 1, "tiny.glb" );
    cli_expect( cli_run( ": > empty.glb; $R info empty.glb" ), 1, "empty.glb" );
    cli_expect( cli_run( "$R info https://a.org/b.glb" ), 1, "https://a.org/b.glb: is not fetched: download it" );
    cli_expect( cli_run( "$R info https://a.org/b.json" ), 1, "https://a.org/b.json: is not fetched: download it" );
    write_gltf( "nan.gltf", true, NAN_TRIANGLE, true );
    cli_expect( cli_run( "$R render nan.gltf -o a.exr" ), 1, "nan.gltf" );
    write_gltf( "blind.gltf", false, TRIANGLE, true );
    const CliResult* result = cli_run( "$R render blind.gltf -o a.exr" );
    assert_true( result->status == 1 || result->status == 2 );
    assert_non_null( strstr( result->err, "camera" ) );
    assert_int_equal( cli_count_files( ".exr", "." ), 0 );
}

#ifndef REFRAME_SANITIZED // which needs far more
TEST( test_more_threads_than_the_limits_allow )
{
    cli_expect( cli_run( "ulimit -v 2000000; $R render $VASE -o t.exr --frames 1 --size 16x9 --spp 1 --threads 256" ), 1,
                "of 256 threads: lower --threads, or raise ulimit -v or -u" );
}
#endif

TEST( test_black_pictures_warn )
{
    write_gltf( "dark.gltf", true, TRIANGLE, false );
    cli_expect( cli_run( "$R render dark.gltf -o dark.exr " SMALL ), 0, "reframe render: warning: dark.gltf: has no lights" );
    assert_true( mean_of( "dark.exr", 24, 16 ) == 0.0 );
    write_gltf( "void.gltf", true, NULL, false );
    cli_expect( cli_run( "$R render void.gltf -o void.exr " SMALL ), 0, "warning: void.gltf: has no triangles" );
    assert_true( mean_of( "void.exr", 24, 16 ) == 0.0 );
    // A light that the eye cannot see by any path: its one side is turned away.
    write_gltf( "away.gltf", true, AWAY_TRIANGLE, true );
    cli_expect( cli_run( "$R render away.gltf -o away.exr " SMALL ), 0, "away.gltf: frame 1 is black" );
    assert_true( mean_of( "away.exr", 24, 16 ) == 0.0 );
}

TEST( test_small_paths_and_images )
{
    cli_expect( cli_run( "$R render one.gltf -o one.exr --size 1x1 --spp 4" ), 0, NULL );
    mean_of( "one.exr", 1, 1 );
    cli_expect( cli_run( "$R render one.gltf -o new/one.####.exr --size 9x5 --spp 2 --group 8 --float" ), 0, NULL );
    assert_true( mean_of( "new/one.0001.exr", 9, 5 ) > 0.0 ); // the triangle's own light, seen by the eye
    cli_expect( cli_run( "$R png one.exr one.png --exposure=1.5" ), 0, NULL );
    assert_true( cli_exists( "one.png" ) );
}

TEST( test_folders_that_cannot_be_written )
{
    cli_expect( cli_run( "$R render one.gltf -o no/such/a.exr " SMALL ), 1, "no/such: " );
    cli_expect( cli_run( "$R render one.gltf -o one.gltf/a.exr " SMALL ), 1, "one.gltf: is not a folder" );
    // Not even root makes files there.
    cli_expect( cli_run( "$R render one.gltf -o /proc/a.exr " SMALL ), 1, "/proc/a.exr: cannot be written" );
    if ( geteuid() != 0 )
        cli_expect( cli_run( "mkdir shut && chmod 555 shut && $R render one.gltf -o shut/a.exr " SMALL ), 1,
                    "shut/a.exr: cannot be written" );
}

TEST( test_existing_frames )
{
    cli_expect( cli_run( "$R render $VASE -o f.####.exr --frames 1-3 " SMALL ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o f.####.exr --frames 3-4 " SMALL ), 1, "f.0003.exr: already exists" );
    cli_expect( cli_run( "$R render $VASE -o f.####.exr --frames 1-3 --overwrite " SMALL ), 0, NULL );
    // Threads do not change the picture: the three are kept as they are. Another file format would mix the sequence.
    cli_run( "touch -d 2001-01-01 f.*.exr" );
    cli_expect( cli_run( "$R render $VASE -o f.####.exr --frames 1-5 --resume --compression piz --parts each " SMALL ), 1,
                "f.0001.exr: is of another render, of --compression zip (here piz), --parts one (here each): give the same" );
    const CliResult* result = cli_run( "$R render $VASE -o f.####.exr --frames 1-5 --resume --threads 1 " SMALL );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "2 frames in f.####.exr" ) );
    assert_non_null( strstr( result->out, "3 kept" ) );
    assert_int_equal( atoi( cli_run( "find . -name 'f.*.exr' ! -newermt 2002-01-01 | wc -l" )->out ), 3 );
    cli_expect( cli_run( "$R render $VASE -o f.####.exr --frames 1-5 --check " SMALL ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o f.####.exr --frames 1-5 --resume --seed 2 " SMALL ), 1,
                "f.0001.exr: is of another render, of --seed 1 (here 2): give the same" );
    cli_expect(
        cli_run( "$R render $VASE -o f.####.exr --frames 1-5 --resume --filter tent " SMALL ), 1,
        "f.0001.exr: is of another render, of --filter blackman-harris (here tent), --filter-width 1.5 (here 1): give the same" );
    cli_expect( cli_run( "$R render $VASE -o f.####.exr --frames 1-5 --resume --filter-width 2 " SMALL ), 1,
                "f.0001.exr: is of another render, of --filter-width 1.5 (here 2): give the same" );
    cli_expect( cli_run( "mv f.0002.exr f.0001.exr; $R render $VASE -o f.####.exr --frames 1-5 --resume " SMALL ), 1,
                "f.0001.exr: is of another render, of frame 2 (here 1): give the same" );
    cli_expect( cli_run( "echo text > f.0001.exr; $R render $VASE -o f.####.exr --frames 1-5 --resume " SMALL ), 1,
                "not a frame of this render" );
    cli_expect( cli_run( "$R render $VASE -o g.####.exr --frames -2--1 --resume " SMALL ), 0, NULL );
    assert_true( cli_exists( "g.0047.exr" ) && cli_exists( "g.0048.exr" ) );
    result = cli_run( "$R render $VASE -o g.####.exr --frames -2--1 --resume " SMALL );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "0 frames" ) );
}

TEST( test_words_for_compressions )
{
    static const struct
    {
        const char *words, *text;
    } cases[] = {
        { "rle", "--compression: expected none, zip, zips, piz, dwaa or dwab, got 'rle'" },
        { "zip:4", "--compression: only dwaa and dwab have a level, got 'zip:4'" },
        { "dwaa:", "--compression: expected a level of DWA from 0 to 250, as dwaa:45, got 'dwaa:'" },
        { "dwab:251", "--compression: expected a level of DWA from 0 to 250, as dwab:45, got 'dwab:251'" },
        { "none --parts two", "--parts: expected" },
#ifdef REFRAME_DWA
        { "dwaa --float", "DWA compresses colours of 32 bits in parts of their own only" },
#endif
    };
    char command[256];
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        snprintf( command, sizeof command, "$R render $VASE -o c.exr --frames 1 --compression %s " SMALL, cases[i].words );
        cli_expect( cli_run( "%s", command ), 2, cases[i].text );
        assert_false( cli_exists( "c.exr" ) );
    }
#ifndef REFRAME_DWA
    cli_expect( cli_run( "$R render $VASE -o c.exr --frames 1 --compression dwaa " SMALL ), 1,
                "this build of reframe lacks DWA" );
#endif
}

// The program of a build is the only one there, so that no kernel but its own can be had.
TEST( test_kernels )
{
    cli_expect( cli_run( "REFRAME_KERNEL=fast $R --version" ), 1, "REFRAME_KERNEL: 'fast': no kernel" );
    const CliResult* run = cli_run( "$R --version" );
    char kernel[16] = "", command[80];
    assert_int_equal( sscanf( strstr( run->out, "(pictures" ), "(pictures %*d, %15[a-z0-9-]", kernel ), 1 );
    snprintf( command, sizeof command, "REFRAME_KERNEL=%s $R --version", kernel );
    cli_expect( cli_run( "%s", command ), 0, NULL );
    bool least = strcmp( kernel, "x86-64-v2" ) == 0;
    cli_expect( cli_run( least ? "REFRAME_KERNEL=x86-64-v3 $R --version" : "REFRAME_KERNEL=x86-64-v2 $R --version" ), 1,
                "REFRAME_KERNEL: " );
}

TEST( test_header_tells_the_settings )
{
    cli_expect( cli_run( "$R render $VASE -o a.exr --frames 2 --seed 18446744073709551615 " SMALL ), 0, NULL );
    const char* version = strstr( cli_run( "$R --version" )->out, "(pictures " );
    char pictures[12] = "";
    assert_true( version != NULL && sscanf( version, "(pictures %11[0-9]", pictures ) == 1 );
    const char* const wanted[][2] = { { "reframe/version", REFRAME_VERSION },
                                      { "reframe/pictures", pictures },
                                      { "reframe/scene", REFRAME_VASE_ROOM },
                                      { "reframe/camera", "Camera" },
                                      { "reframe/frame", "2" },
                                      { "reframe/frames", "48" },
                                      { "reframe/group", "0" },
                                      { "reframe/spp", "1" },
                                      { "reframe/weights", "exact" },
                                      { "reframe/normalize", "crossfit" },
                                      { "reframe/seed", "18446744073709551615" } };
    cli_expect_exr_texts( "a.exr", wanted, sizeof wanted / sizeof wanted[0] );
}

TEST( test_json_has_every_key )
{
    const CliResult* result =
        cli_run( "$R render $VASE -o j.####.exr --frames 1-2 --json - --size 24x16 --spp 3 --group 1 --quiet" );
    cli_expect( result, 0, NULL );
    json_t* json = parse_json( result->out );
    expect_keys( json,
                 "version pictures scene frames seconds seconds_scene peak_bytes budget_bytes bytes rays group tile weights "
                 "normalize threads effects effects_left_out effects_forced kept_frames interrupted clamp adaptive adaptive_mode "
                 "adaptive_frames warnings losses export_losses export_warnings repeated_frames filter specks "
                 "beyond_depth_share clipped_pixels halo guide guide_tables" );
    expect_keys( json_object_get( json, "rays" ), "primary path shadow tile eye" );
    expect_keys( json_object_get( json, "bytes" ), "film_table films adaptive image scratch hit_records writer" );
    json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 2 );
    expect_keys( json_array_get( frames, 1 ), "frame seconds relmse_estimate relmse_is_lower_bound relmse_likely worst_ten_share "
                                              "native_spp effective_spp kept noise_percent specks clipped_pixels" );
    expect_keys( json_object_get( json_array_get( frames, 1 ), "specks" ),
                 "pixels share rest_relmse rest_noise_percent kinds materials" );
    expect_keys( json_object_get( json, "specks" ), "pixels share rest_relmse rest_noise_percent kinds materials frames" );
    assert_int_equal( json_integer_value( json_object_get( json_array_get( frames, 1 ), "frame" ) ), 2 );
    assert_int_equal( json_integer_value( json_object_get( json, "group" ) ), 1 );
    assert_string_equal( json_string_value( json_object_get( json, "scene" ) ), REFRAME_VASE_ROOM );
    assert_string_equal( json_string_value( json_array_get( json_object_get( json, "effects" ), 0 ) ), "diffuse" );
    json_decref( json );
    cli_expect( cli_run( "$R render $VASE -o j.####.exr --overwrite --frames 1 --json j.json " SMALL ), 0, NULL );
    size_t size;
    AUTO_FREE char* text = cli_read( "j.json", &size );
    json_decref( parse_json( text ) );
    assert_int_equal( cli_count_files( ".tmp", "." ), 0 );
}

TEST( test_info_tells_cameras_and_materials )
{
    const CliResult* result = cli_run( "$R info $VASE" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "Camera: 48 frames at 24 frames/s, animated" ) );
    assert_non_null( strstr( result->out, "material 'vase'" ) );
    result = cli_run( "$R info $VASE --json - --fps 48" );
    cli_expect( result, 0, NULL );
    json_auto_t* json = parse_json( result->out );
    expect_keys(
        json, "triangles stored_triangles instances materials lights cameras effects moving changing sharing frozen unrendered "
              "size fps alpha losses export_losses export_warnings variants light_groups beyond_depth_share" );
    json_t* camera = json_array_get( json_object_get( json, "cameras" ), 0 );
    expect_keys( camera, "name frames first step animated shots" );
    assert_int_equal( json_integer_value( json_object_get( camera, "frames" ) ), 95 );
    assert_int_equal( json_integer_value( json_object_get( json, "lights" ) ), 2 );
    expect_keys( json_array_get( json_object_get( json, "effects" ), 0 ), "name on why left_out forced option" );
}

TEST( test_scene_script_repeats_its_bytes )
{
    static const char script[] = REFRAME_SOURCE_DIR "/scenes/make-vase-room.py";
    // The same arguments give the same bytes; an animated path may have one frame.
    cli_expect( cli_run( "'%s' same.glb && cmp same.glb $VASE", script ), 0, NULL );
    cli_expect( cli_run( "'%s' still.glb --frames 1 && $R render still.glb -o still.exr " SMALL, script ), 0, NULL );
    assert_true( mean_of( "still.exr", 24, 16 ) > 0.0 );
    cli_expect( cli_run( "'%s' no/such/a.glb", script ), 1, "no/such/a.glb" );
}

static void sleep_ms( long ms )
{
    struct timespec time = { ms / 1000, ms % 1000 * 1000000 };
    nanosleep( &time, NULL );
}

TEST( test_interrupt_keeps_finished_frames )
{
    // `exec`: the signal is for the program, not for the shell.
    cli_start( "exec $R render $VASE -o i/f.####.exr --size 96x54 --spp 64 --group 0 --quiet" );
    for ( int i = 0; i < 24000 && !cli_exists( "i/f.0001.exr" ); ++i )
        sleep_ms( 25 );
    const CliResult* result = cli_wait( SIGINT );
    cli_expect( result, 130, "reframe render: interrupted: " );
    int finished = cli_count_files( ".exr", "i" );
    assert_true( finished >= 1 && finished < 48 );
    assert_int_equal( cli_count_files( "", "i" ), finished + cli_count_files( ".films", "i" ) ); // no temporary file stays
    for ( int i = 1; i <= finished; ++i )
    {
        char name[64];
        snprintf( name, sizeof name, "i/f.%04d.exr", i );
        assert_true( mean_of( name, 96, 54 ) > 0.0 );
    }
}

TEST( test_full_disk_leaves_no_part_of_a_file )
{
    // a folder in the way is reported before anything is rendered, though another frame comes first
    cli_expect(
        cli_run( "mkdir -p way/f.0002.exr way/j; $R render $VASE -o way/f.####.exr --frames 1-2 --size 8x6 --spp 1 --group 0 "
                 "--quiet --overwrite" ),
        1, "way/f.0002.exr: is a folder: choose another name" );
    cli_expect( cli_run( "$R render $VASE -o way/f.####.exr --frames 1 --size 8x6 --spp 1 --group 0 --quiet --json way/j" ), 1,
                "--json: way/j: is a folder: choose another name" );
    assert_false( cli_exists( "way/f.0001.exr" ) );
    // A file size limit fails a write where it is reached, as a full disk does;
    // without a TMPDIR, where ThreadSanitizer would want a larger file of its own.
    const CliResult* result = cli_run(
        "mkdir full; ulimit -f 8; TMPDIR=/none $R render $VASE -o full/f.####.exr --frames 1-2 --size 128x96 --spp 1 --group 0 "
        "--quiet --compression none" );
    cli_expect( result, 1, "full/f.0001.exr" );
    assert_int_equal( cli_count_files( "", "full" ), 0 );
    result = cli_run( "$R render one.gltf -o j.exr --json /dev/full " SMALL );
    cli_expect( result, 1, "/dev/full" );
}

SHARED_BY_TESTS( enter, leave )
