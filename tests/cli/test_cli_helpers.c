// Parts of the program that need no scene: frame lists, OpenEXR matrices, fingerprints,
// the progress line.
#include "support/test.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/render/progress.h"
#include "cli/render/render_files.h"
#include "cli/render/render_json.h"
#include "cli/tune/trial_command.h"
#include "scene/pinhole.h"

#include <unistd.h>

// Of a sequence with these two numbers.
static void expect_frames_of( int first, int last, const char* text, const char* wanted )
{
    int *frames, count, there[2] = { first, last };
    char list[256] = "";
    RfError error = { .code = RF_OK };
    if ( rf_parse_frames( text, there, 2, &frames, &count, &error ) != RF_OK )
        fail_msg( "%s: %s", text, error.text );
    for ( int i = 0, used = 0; i < count; ++i )
        used += snprintf( list + used, sizeof list - (size_t)used, i > 0 ? " %d" : "%d", frames[i] );
    free( frames );
    assert_string_equal( list, wanted );
}

static void expect_frames( const char* text, const char* wanted ) { expect_frames_of( 3, 10, text, wanted ); }

static void expect_refused( const char* text, const char* part )
{
    int *frames, count, there[] = { 10 };
    RfError error = { .code = RF_OK };
    assert_int_equal( rf_parse_frames( text, there, 1, &frames, &count, &error ), RF_ERROR_USAGE );
    assert_null( frames );
    if ( strstr( error.text, part ) == NULL )
        fail_msg( "'%s' gave '%s'", text, error.text );
}

TEST( test_frame_lists_as_users_write_them )
{
    expect_frames( NULL, "1 2 3 4 5 6 7 8 9 10" );
    expect_frames( "7", "7" );
    expect_frames( "-1", "10" );
    expect_frames( "-3--1", "8 9 10" );
    expect_frames( "-3-10", "8 9 10" );
    expect_frames( "1-10x4", "1 5 9" );
    expect_frames( "9,2-3,3,1--1x9", "1 2 3 9 10" );
    expect_frames( "1-3x9223372036854775807", "1" );
    expect_frames( "@9-10,2", "2 9 10" );
    expect_frames_of( -3, 3, NULL, "-3 -2 -1 0 1 2 3" );
    expect_frames_of( -3, 3, "-3", "1" ); // from the end
    expect_frames_of( -3, 3, "@-3", "-3" );
    expect_frames_of( -3, 3, "@-2--1,-1,@-3-3x3", "-3 -2 -1 0 3" );
    expect_frames_of( -9, -7, "-1,@-9", "-9 -7" );
    expect_refused( "0", "no frame 0, the camera's path has 10 frames" );
    expect_refused( "11", "no frame 11" );
    expect_refused( "-11", "no frame -11" );
    expect_refused( "3-2", "runs backwards" );
    expect_refused( "@-1", "no frame -1" );
    static const char* const wrong[] = {
        "", "1,", ",1", "a", "1-", "1-3x0", "1-3x-1", "1 - 3", "--1", "1-3x", "99999999999999999999", "@", "1-@3", "@@1"
    };
    for ( size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i )
        expect_refused( wrong[i], "expected frames such as" );
}

// p' = p · M, divided by w.
static void apply( const float m[16], const double p[3], double out[3] )
{
    double r[4];
    for ( int j = 0; j < 4; ++j )
        r[j] = p[0] * m[j] + p[1] * m[4 + j] + p[2] * m[8 + j] + m[12 + j];
    for ( int j = 0; j < 3; ++j )
        out[j] = r[j] / r[3];
}

TEST( test_matrices_project_as_the_eye_does )
{
    RfEye eye = rf_make_eye( rf_vec3( 1, 2, 3 ), rf_vec3( 1, -0.5f, 0.25f ), rf_vec3( 0, 1, 0 ), 0.8, 160, 90 );
    float camera[16], ndc[16];
    rf_eye_matrices( &eye, camera, ndc );
    // The point two metres behind the upper right corner of the film.
    double half_x = 0.5 * 160 / eye.focal, half_y = 0.5 * 90 / eye.focal, p[3], out[3];
    RfVec3 d = rf_add( eye.forward, rf_add( rf_scale( eye.right, (float)half_x ), rf_scale( eye.up, (float)half_y ) ) );
    const float axes[3] = { d.x, d.y, d.z }, origin[3] = { eye.origin.x, eye.origin.y, eye.origin.z };
    for ( int i = 0; i < 3; ++i )
        p[i] = origin[i] + 2.0 * axes[i];
    apply( camera, p, out );
    assert_true( fabs( out[0] - 2.0 * half_x ) < 1e-5 && fabs( out[1] - 2.0 * half_y ) < 1e-5 );
    assert_true( fabs( out[2] + 2.0 ) < 1e-5 );
    apply( ndc, p, out );
    assert_true( fabs( out[0] - 1.0 ) < 1e-5 && fabs( out[1] - 1.0 ) < 1e-5 );
    assert_true( fabs( out[2] - 0.99 ) < 1e-5 ); // 1 − 2 · 1 cm / 2 m
}

// A point that a shifted lens shows in the upper right corner of a film of wide pixels.
TEST( test_matrices_of_shifted_lenses )
{
    RfEye eye = rf_make_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.8, 160, 90 );
    rf_shift_eye( &eye, 1.5, 0.25, -0.1 );
    float camera[16], ndc[16];
    rf_eye_matrices( &eye, camera, ndc );
    // in heights of the picture, which at a distance of 1 is 2 tan 0.4 high
    double high = 2.0 * tan( 0.4 ), p[3] = { ( 0.5 * 160 * 1.5 / 90 + 0.25 ) * high, ( 0.5 - 0.1 ) * high, -1.0 }, out[3];
    apply( ndc, p, out );
    assert_true( fabs( out[0] - 1.0 ) < 1e-5 && fabs( out[1] - 1.0 ) < 1e-5 );
    RfProjection at = rf_project( &eye, rf_vec3( (float)( 0.999 * p[0] ), (float)( 0.999 * p[1] ), -1 ), rf_vec3( 0, 0, 1 ) );
    assert_true( at.seen && at.x == 159 && at.y == 0 );
    const float inverse[2] = { 1.0f / eye.focal_x, 1.0f / eye.focal };
    RfVec3 d = rf_pinhole_ray( &eye, inverse, 159, 0, 1.0f, 0.0f );
    assert_true( fabs( (double)( d.x / d.z ) + p[0] ) < 1e-5 && fabs( (double)( d.y / d.z ) + p[1] ) < 1e-5 );
    float film[2];
    rf_pinhole_position( &eye, d, film );
    assert_true( fabs( (double)film[0] - 80.0 ) < 1e-3 && fabs( (double)film[1] - 45.0 ) < 1e-3 );
}

TEST( test_fingerprints_change_with_every_setting )
{
    RfRenderOptions options = { .fps = { 24, 1 }, .tile = "1", .settings = rf_default_render_settings() };
    RfScene scene = { .content_hash = 17 };
    RfCameraPath path = { .count = 3, .hash = 5 };
    AUTO_TRACER tracer;
    assert_int_equal( rf_create_tracer( &scene, &tracer, NULL ), RF_OK );
    RfOutput subject = { .pattern = "f.####.exr", .tracer = tracer, .path = &path, .settings = options.settings };
    char first[17], other[17];
    rf_frame_fingerprint( &subject, 0, first );
    assert_int_equal( strlen( first ), 16 );
    subject.settings.threads = 7;
    subject.settings.memory = 12345678;
    subject.settings.files.half = true;
    subject.pattern = "elsewhere.exr";
    rf_frame_fingerprint( &subject, 0, other );
    assert_string_equal( first, other );
    rf_frame_fingerprint( &subject, 1, other );
    assert_string_not_equal( first, other );
    subject.settings.seed = 2;
    rf_frame_fingerprint( &subject, 0, other );
    assert_string_not_equal( first, other );
    subject.settings.seed = 1;
    path.hash = 6;
    rf_frame_fingerprint( &subject, 0, other );
    assert_string_not_equal( first, other );
    path.hash = 5;
    scene.content_hash = 18;
    rf_frame_fingerprint( &subject, 0, other );
    assert_string_not_equal( first, other );
}

// relMSE adds up three channels: where each is off by a tenth it is 0.03.
TEST( test_noise_in_percent )
{
    static const struct
    {
        double relmse;
        const char* text;
    } cases[] = {
        { 0.03, "10 %" }, { 0.0003, "1 %" },    { 3e-7, "0.032 %" },        { 0.0, "0 %" },      { 2.95, "99 %" },
        { 3.0, "100 %" }, { 1200.0, "2000 %" }, { (double)NAN, "unknown" }, { -1.0, "unknown" }, { (double)INFINITY, "unknown" }
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        char text[RF_NOISE_TEXT_SIZE];
        rf_format_noise( cases[i].relmse, text );
        assert_string_equal( text, cases[i].text );
    }
}

// No figure whose interval is wider than a factor of 4.
TEST( test_gains_are_said_as_far_as_they_are_known )
{
    static const struct
    {
        RfInterval gain;
        const char *text, *cell;
    } cases[] = {
        { { 3.0, 2.0, 4.0 }, "3 times faster than path tracing at equal noise (95 %: 2 to 4)", "3" },
        { { 0.5, 0.25, 0.8 }, "2 times slower than path tracing at equal noise (95 %: 1.2 to 4)", "0.5" },
        { { 1.25, 0.8, 2.0 },
          "possibly faster than path tracing at equal noise (1.25 times its speed, 95 %: 0.80 to 2.00)",
          "1.25" },
        { { 624.89, 5.06, 77216.9 }, "at least 5.1 times faster than path tracing at equal noise", ">5.1" },
        { { 0.01, 0.001, 0.5 }, "at least 2 times slower than path tracing at equal noise", ">0.001" },
        { { 1.0, 0.25, 4.0 }, "gain over path tracing not known within the budget: needs about 80 s", ">0.25" },
        { { 2.0, (double)NAN, (double)NAN }, "gain over path tracing not known within the budget", "?" },
        { { (double)NAN, (double)NAN, (double)NAN }, "not compared with path tracing", "?" },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        char text[160], cell[RF_FIGURE_SIZE];
        rf_format_gain( &cases[i].gain, 20.0, text, sizeof text );
        rf_format_figure( &cases[i].gain, cell );
        assert_string_equal( text, cases[i].text );
        assert_string_equal( cell, cases[i].cell );
    }
}

static json_t* frame_with_specks( double likely, const RfSpecks* specks, const RfScene* scene )
{
    return json_pack( "{s:f, s:o}", "relmse_likely", likely, "specks", rf_specks_json( specks, scene ) );
}

static void expect_specks( const json_t* sum, const char* words, const char* advice )
{
    char text[512];
    RfRenderSettings settings = rf_default_render_settings();
    assert_true( rf_format_specks( sum, text, sizeof text ) );
    assert_string_equal( text, words );
    const char* given = rf_speck_advice( sum, &settings );
    assert_int_equal( given != NULL, advice != NULL );
    if ( given != NULL )
        assert_string_equal( given, advice );
}

// Frames count by their errors. The sentence names a material and a kind that has most of it, and what helps.
TEST( test_specks_in_words )
{
    RfMaterial materials[] = { { .name = "steel" }, { .name = "wall" } };
    RfScene scene = { .materials = materials, .material_count = 2 };
    RfSpecks one = { .pixels = 1,
                     .share = 0.9969,
                     .rest = 0.03,
                     .part_count = 1,
                     .parts = { { .kind = RF_SPECK_CHANCE, .material = 1, .pixels = 1, .share = 0.9969 } } };
    RfSpecks glints = { .pixels = 9,
                        .share = 0.5,
                        .rest = 0.01,
                        .part_count = 2,
                        .parts = { { .kind = RF_SPECK_GLINT, .material = 0, .pixels = 6, .share = 0.4 },
                                   { .kind = RF_SPECK_GLINT, .material = -1, .pixels = 3, .share = 0.1 } } };
    RfSpecks sky = { .pixels = 3,
                     .share = 0.4,
                     .rest = 0.03,
                     .part_count = 1,
                     .parts = { { .kind = RF_SPECK_OTHER, .material = -1, .pixels = 3, .share = 0.4 } } };
    RfSpecks none = { .rest = 0.03 };
    json_auto_t* frames = json_array();
    assert_null( rf_sum_specks( frames ) );
    json_array_append_new( frames, frame_with_specks( 0.9, &one, &scene ) );
    json_t* sum = rf_sum_specks( frames );
    expect_specks( sum,
                   "1 speck holds 99 % of the error, mostly on 'wall' (caustics found by chance); the rest has about 10 % noise "
                   "(relMSE 0.03)",
                   "--clamp auto" );
    json_decref( sum );
    json_array_append_new( frames, frame_with_specks( 2.7, &glints, &scene ) );
    json_array_append_new( frames, json_pack( "{s:n, s:n}", "relmse_likely", "specks" ) ); // kept, or a single pass
    sum = rf_sum_specks( frames );
    expect_specks( sum,
                   "10 specks in 2 frames hold 62 % of the error, mostly glints; the rest has about 8.2 % noise (relMSE 0.02)",
                   "raise --spp" );
    const json_t* rows = json_object_get( sum, "materials" );
    assert_int_equal( json_array_size( rows ), 3 );
    assert_string_equal( json_string_value( json_object_get( json_array_get( rows, 0 ), "material" ) ), "steel" );
    assert_true( json_is_null( json_object_get( json_array_get( rows, 2 ), "material" ) ) );
    assert_true( fabs( rf_json_number_of( json_array_get( rows, 0 ), "share" ) - 0.75 * 0.4 ) < 1e-12 );
    const json_t* glint = json_object_get( json_object_get( sum, "kinds" ), "glint" );
    assert_true( rf_json_number_of( glint, "pixels" ) == 9.0 && fabs( rf_json_number_of( glint, "share" ) - 0.375 ) < 1e-12 );
    json_decref( sum );
    json_array_clear( frames );
    json_array_append_new( frames, frame_with_specks( 0.0, &sky, &scene ) ); // no error: no share
    char text[512];
    sum = rf_sum_specks( frames );
    assert_false( rf_format_specks( sum, text, sizeof text ) );
    json_decref( sum );
    json_array_append_new( frames, frame_with_specks( 1.0, &sky, &scene ) );
    json_array_remove( frames, 0 );
    sum = rf_sum_specks( frames );
    expect_specks( sum, "3 specks hold 40 % of the error, mostly in the sky; the rest has about 10 % noise (relMSE 0.03)", NULL );
    json_decref( sum );
    json_array_clear( frames );
    json_array_append_new( frames, frame_with_specks( 1.0, &none, &scene ) );
    sum = rf_sum_specks( frames );
    assert_true( sum != NULL && !rf_format_specks( sum, text, sizeof text ) );
    json_decref( sum );
}

TEST( test_progress_line_is_short_and_right )
{
    char text[160];
    RfProgress progress = {
        .frames_done = 11, .frames_all = 48, .share = 0.25, .samples = 26.6e6, .seconds = 14.0, .left = 42.0
    };
    rf_format_progress( &progress, text, sizeof text );
    assert_string_equal( text, "frame 12/48  25 %  0:14 spent  0:42 left  1.9 M samples/s" );
    progress.relmse = 0.00314;
    rf_format_progress( &progress, text, sizeof text );
    assert_string_equal( text, "frame 12/48  25 %  0:14 spent  0:42 left  noise 3.2 % (relMSE 0.0031)" );
    progress.flicker = 0.0123;
    progress.flicker_is_lower_bound = true;
    rf_format_progress( &progress, text, sizeof text );
    assert_string_equal( text, "frame 12/48  25 %  0:14 spent  0:42 left  noise 3.2 % (relMSE 0.0031)" );
    progress = ( RfProgress ){ .frames_all = 1, .relmse = (double)NAN, .left = (double)NAN };
    rf_format_progress( &progress, text, sizeof text );
    assert_string_equal( text, "frame 1/1  0 %  0:00 spent  -:-- left  0 k samples/s" );
    progress = ( RfProgress ){ .frames_done = 2, .frames_all = 2, .share = 1.0, .samples = 5e3, .seconds = 10.0 };
    rf_format_progress( &progress, text, sizeof text );
    assert_string_equal( text, "frame 2/2  100 %  0:10 spent  0:00 left  0 k samples/s" );
    // what does not fit on a line of a terminal stays away, the rate first
    progress = ( RfProgress ){ .frames_done = 99998,
                               .frames_all = 99999,
                               .share = 0.5,
                               .samples = 4e14,
                               .seconds = 359999.0,
                               .left = 359999.0,
                               .relmse = 1.2345e-5 };
    rf_format_progress( &progress, text, sizeof text );
    assert_string_equal( text, "frame 99999/99999  50 %  99:59:59 spent  99:59:59 left  noise 0.2 %" );
}

// Where standard error is a pipe: a plain line every ten seconds, from the start.
TEST( test_progress_off_a_terminal )
{
    char text[512];
    FILE* log = tmpfile();
    int terminal = dup( STDERR_FILENO );
    assert_true( log != NULL && terminal >= 0 );
    dup2( fileno( log ), STDERR_FILENO );
    RfProgressLine line = rf_create_progress_line( false ), quiet = rf_create_progress_line( true );
    static const double seconds[] = { 0.1, 5.0, 9.9, 10.2, 15.0, 20.1, 20.3, 46.5, 48.0 };
    for ( size_t i = 0; i < sizeof seconds / sizeof seconds[0]; ++i )
    {
        RfProgress progress = {
            .frames_all = 25, .share = seconds[i] / 50.0, .samples = 1e6, .seconds = seconds[i], .left = 50.0 - seconds[i]
        };
        rf_show_progress( &line, &progress );
        rf_show_progress( &quiet, &progress );
    }
    rf_clear_progress( &line );
    fflush( stderr );
    dup2( terminal, STDERR_FILENO );
    close( terminal );
    rewind( log );
    text[fread( text, 1, sizeof text - 1, log )] = '\0';
    fclose( log );
    assert_string_equal( text, "frame 1/25  20 %  0:10 spent  0:40 left  98 k samples/s\n"
                               "frame 1/25  40 %  0:20 spent  0:30 left  49 k samples/s\n"
                               "frame 1/25  93 %  0:46 spent  0:04 left  22 k samples/s\n" );
}
