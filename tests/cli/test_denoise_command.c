// `render --denoise` and `reframe denoise` as a user has them, by the library of support that takes means over 5x5 pixels; and by Open
// Image Denoise where it is found.
#include "output/frame_file.h"
#include "reframe/denoise.h"
#include "support/cli_run.h"
#include "support/test.h"

#define BOX "--denoiser " REFRAME_BOX_DENOISER
#define LARGE "$R render $VASE --size 128x72 --quiet "
#define RENDER "$R render $VASE --size 64x36 --quiet "

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )

// Sum over all channels of a picture.
static double light_of( const char* name, const char* layer )
{
    double sum = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        char channel[64];
        RfExrWindow window;
        snprintf( channel, sizeof channel, "%s%s%c", layer, layer[0] != '\0' ? "." : "", "RGB"[c] );
        float* values = cli_read_channel( name, channel, &window );
        assert_non_null( values );
        for ( int i = 0; i < window.width * window.height; ++i )
            sum += (double)values[i];
        free( values );
    }
    return sum;
}

static double figure( const json_t* json, const char* key )
{
    const json_t* value = json_object_get( json, key );
    if ( !json_is_number( value ) )
        fail_msg( "%s is no number", key );
    return json_number_value( value );
}

// Two renders of the same samples, one of them denoised: its layer `noisy` is the picture of the other.
TEST( test_render_keeps_the_noisy_picture )
{
    const char* const texts[][2] = { { "reframe/denoiser", "Open Image Denoise 2.0.0" },
                                     { "reframe/tile", "rooks16" },
                                     { "reframe/aov", "denoise_albedo,denoise_normal,half" } };
    cli_expect( cli_run( LARGE "-o clean.##.exr --frames 1-2 --spp 8 --group 1 --float --denoise " BOX " --json c.json" ), 0,
                NULL );
    cli_expect( cli_run( LARGE "-o raw.##.exr --frames 1-2 --spp 8 --group 1 --float --filter box --tile rooks16" ), 0, NULL );
    cli_expect_exr_texts( "clean.01.exr", texts, sizeof texts / sizeof texts[0] );
    for ( int c = 0; c < 3; ++c )
    {
        RfExrWindow window;
        const char noisy_name[] = { 'n', 'o', 'i', 's', 'y', '.', "RGB"[c], '\0' }, name[] = { "RGB"[c], '\0' };
        float *noisy = cli_read_channel( "clean.02.exr", noisy_name, &window ),
              *raw = cli_read_channel( "raw.02.exr", name, &window );
        float* clean = cli_read_channel( "clean.02.exr", name, &window );
        assert_memory_equal( noisy, raw, 128 * 72 * sizeof( float ) );
        assert_true( memcmp( clean, raw, 128 * 72 * sizeof( float ) ) != 0 );
        free( noisy );
        free( raw );
        free( clean );
    }
    json_t *json = cli_read_json( "c.json" ), *row = json_array_get( json_object_get( json, "frames" ), 1 );
    const json_t* denoised = json_object_get( row, "denoised" );
    // over the brightness of the denoised picture, which the mean over 5x5 pixels blurs
    assert_true( fabs( figure( denoised, "noisy_relmse" ) / figure( row, "relmse_likely" ) - 1.0 ) < 0.3 );
    double relmse = figure( denoised, "relmse" );
    assert_true( relmse < figure( denoised, "noisy_relmse" ) && figure( denoised, "low" ) <= relmse &&
                 figure( denoised, "high" ) >= relmse );
    assert_true( fabs( strtod( cli_exr_text( "clean.02.exr", "reframe/denoised-relmse" ), NULL ) / relmse - 1.0 ) < 1e-4 );
    json_decref( json );
}

// Samples of the first frame.
static double spp_of( const char* name )
{
    json_t* json = cli_read_json( name );
    double spp = figure( json_array_get( json_object_get( json, "frames" ), 0 ), "native_spp" );
    json_decref( json );
    return spp;
}

// In groups of frames and without: by the upper end of what is told, or by the noise where that is less.
TEST( test_noise_stops_by_the_denoised_error )
{
    for ( int group = 0; group < 2; ++group )
    {
        cli_expect( cli_run( LARGE "-o stop.##.exr --frames 1-3 --group %d --noise 0.01 --overwrite --denoise " BOX
                                   " --json s.json",
                             group ),
                    0, NULL );
        json_t *json = cli_read_json( "s.json" ), *rows = json_object_get( json, "frames" );
        for ( size_t f = 0; f < 3; ++f )
        {
            const json_t* row = json_array_get( rows, f );
            assert_true( json_is_true( json_object_get( row, "reached" ) ) );
            assert_true( fmin( figure( json_object_get( row, "denoised" ), "high" ), figure( row, "relmse_likely" ) ) <= 0.01 );
        }
        json_decref( json );
    }
    const CliResult* few = cli_run( RENDER "-o cap.exr --frames 1 --group 0 --noise 1e-5 --spp 8 --denoise " BOX );
    cli_expect( few, 0, "--noise: 0.18 % (relMSE 1e-05) not reached in 1 of 1 frames, frame 1 has up to " );
}

// Windows of frames, by path tracing and with reuse, and what they predict.
TEST( test_cost_of_denoised_pictures )
{
#define COST "$R cost $VASE --size 64x36 --frames 1-8 --group 1 --budget 4s --denoise "
    const CliResult* done = cli_run( COST "--noise 0.1,0.01 --quiet --svg cost.svg " BOX );
    cli_expect( done, 0, NULL );
    const char* first = strstr( done->out, "\n  denoised " );
    assert_non_null( first );
    assert_non_null( strstr( first + 1, "\n  denoised " ) );
    assert_non_null( strstr( done->out, "\n    denoised       " ) );
    cli_expect( cli_run( "grep -c 'path tracing, denoised' cost.svg" ), 0, NULL );
    cli_expect( cli_run( COST "--noise 0.1,0.01 --quiet --json cost.json " BOX ), 0, NULL );
    json_t *json = cli_read_json( "cost.json" ), *curves = json_object_get( json, "denoised" );
    for ( size_t k = 0; k < 2; ++k )
    {
        const json_t *curve = json_array_get( curves, k ), *wanted = json_object_get( curve, "wanted" );
        double relmse = figure( curve, "relmse" ), spp = figure( curve, "spp" ), exponent = figure( curve, "exponent" );
        assert_true( figure( curve, "low" ) <= relmse && relmse <= figure( curve, "high" ) );
        assert_true( spp >= 16.0 && exponent >= 0.25 && exponent <= 1.0 && json_array_size( wanted ) == 2 );
        double predicted = figure( json_array_get( wanted, 1 ), "spp" ), exact = spp * pow( relmse / 0.01, 1.0 / exponent );
        assert_true( predicted >= fmax( exact, 4.0 ) - 1.0 && predicted <= fmax( exact, 4.0 ) + 3.0 );
    }
    json_decref( json );
    cli_expect( cli_run( COST "--denoiser none.so" ), 1, "the denoiser cannot be loaded: none.so: " );
}

TEST( test_last_line_tells_both_errors )
{
    const CliResult* done = cli_run( "$R render $VASE --size 64x36 -o line.exr --frames 1 --spp 8 --group 0 --denoise " BOX );
    cli_expect( done, 0, NULL );
    assert_non_null( strstr( done->out, "\nNoise " ) );
    assert_non_null( strstr( done->out, ", denoised " ) );
    assert_non_null( strstr( done->out, "bias included)\n" ) );
    cli_expect( cli_run( RENDER "-o few.exr --frames 1 --spp 2 --group 0 --denoise " BOX " --json few.json" ), 0, NULL );
    json_t* json = cli_read_json( "few.json" );
    json_t* row = json_array_get( json_object_get( json, "frames" ), 0 );
    assert_true( json_is_null( json_object_get( json_object_get( row, "denoised" ), "relmse" ) ) );
    json_decref( json );
}

// By the layers of a file: the same as while rendering. All else stays.
TEST( test_files_are_denoised_later )
{
    cli_expect( cli_run( RENDER "-o two/now.####.exr --frames 1-2 --spp 8 --group 1 --float --denoise " BOX
                                " --light-groups lamps --aov depth,direct,indirect,emission,reflection,transmission "
                                "--cryptomatte object --colorspace acescg" ),
                0, NULL );
    cli_expect( cli_run( RENDER "-o one/now.####.exr --frames 1-2 --spp 8 --group 1 --float --filter box --tile rooks16 "
                                "--light-groups lamps --aov denoise_albedo,denoise_normal,half,depth,direct,indirect,emission,"
                                "reflection,transmission --cryptomatte object --colorspace acescg" ),
                0, NULL );
    const CliResult* done = cli_run( "$R denoise one -o later " BOX );
    cli_expect( done, 0, NULL );
    assert_non_null( strstr( done->out, "2 frames in later/now.####.exr by Open Image Denoise 2.0.0, " ) );
    assert_non_null( strstr( done->out, "\nEach frame is denoised by itself: " ) );
    RfImage now = cli_read_exr( "two/now.0002.exr" ), later = cli_read_exr( "later/now.0002.exr" );
    for ( int i = 0; i < 3 * 64 * 36; ++i )
        assert_true( fabsf( now.rgb[i] - later.rgb[i] ) <= 1e-4f * ( fabsf( now.rgb[i] ) + 0.01f ) );
    rf_destroy_image( &now );
    rf_destroy_image( &later );
    static const char* const kept[] = { "depth.Z", "CryptoObject00.r", "CryptoObject01.a", "half.W", "denoise_normal.X" };
    for ( size_t k = 0; k < sizeof kept / sizeof kept[0]; ++k )
    {
        RfExrWindow window;
        float *before = cli_read_channel( "one/now.0002.exr", kept[k], &window ),
              *after = cli_read_channel( "later/now.0002.exr", kept[k], &window );
        assert_memory_equal( before, after, 64 * 36 * sizeof( float ) );
        free( before );
        free( after );
    }
    static const char* const texts[] = { "reframe/scene", "reframe/seed", "cryptomatte/f834d0a/name", "reframe/colorspace" };
    for ( size_t k = 0; k < sizeof texts / sizeof texts[0]; ++k )
    {
        char before[256];
        const char* text = cli_exr_text( "one/now.0002.exr", texts[k] );
        if ( text == NULL && k == 2 )
            continue; // another key
        assert_non_null( text );
        snprintf( before, sizeof before, "%s", text );
        cli_expect_exr_text( "later/now.0002.exr", texts[k], before );
    }
    double all = light_of( "later/now.0002.exr", "" ), passes = 0.0;
    static const char* const split[] = { "direct", "indirect", "emission", "reflection", "transmission" };
    for ( size_t k = 0; k < sizeof split / sizeof split[0]; ++k )
        passes += light_of( "later/now.0002.exr", split[k] );
    assert_true( fabs( passes / all - 1.0 ) < 1e-3 );
    // once more, from the layer noisy: the same
    cli_expect( cli_run( "$R denoise later -o again " BOX " --quiet" ), 0, NULL );
    RfImage first = cli_read_exr( "later/now.0001.exr" ), second = cli_read_exr( "again/now.0001.exr" );
    for ( int i = 0; i < 3 * 64 * 36; ++i )
        assert_true( fabsf( first.rgb[i] - second.rgb[i] ) <= 1e-5f * ( fabsf( first.rgb[i] ) + 0.01f ) );
    rf_destroy_image( &first );
    rf_destroy_image( &second );
}

// In parts and by the names of another program.
TEST( test_files_of_other_forms_are_denoised )
{
    static const char* const forms[] = { "--names blender", "--names nuke --parts each", "--compression piz --overscan 4" };
    for ( size_t k = 0; k < sizeof forms / sizeof forms[0]; ++k )
    {
        cli_expect(
            cli_run( RENDER
                     "-o form.exr --frames 1 --spp 8 --group 0 --filter box --aov denoise_albedo,denoise_normal,half,motion "
                     "--overwrite %s",
                     forms[k] ),
            0, NULL );
        const CliResult* done = cli_run( "$R denoise form.exr -o formed.exr " BOX " --overwrite --json -" );
        cli_expect( done, 0, NULL );
        assert_null( strstr( done->out, "\"relmse\": null" ) );
        cli_expect( cli_run( "$R compare formed.exr form.exr --layer noisy --reference-layer %s --json -",
                             k == 0 ? "ViewLayer.Combined" : "R,G,B" ),
                    0, NULL );
    }
}

// Along the motion, by any names of it: Blender's is negated to the next frame. A list of frames that are not beside each other is
// denoised frame by frame.
TEST( test_frames_beside_are_followed )
{
    static const char* const names[] = { "reframe", "blender", "nuke" };
    for ( int k = 0; k < 3; ++k )
    {
        cli_expect( cli_run( RENDER
                             "-o m%d/f.##.exr --frames 1-3 --spp 8 --group 0 --tile 1 --filter box --float --names %s --aov "
                             "half,denoise_albedo,denoise_normal,motion",
                             k, names[k] ),
                    0, NULL );
        cli_expect( cli_run( "$R denoise m%d -o c%d --json c.json --quiet " BOX, k, k ), 0, NULL );
        json_t *json = cli_read_json( "c.json" ), *rows = json_object_get( json, "frames" );
        double along = 0.0;
        for ( size_t f = 0; f < 3; ++f )
            along += figure( json_array_get( rows, f ), "along_motion" );
        assert_true( along > 0.03 );
        json_decref( json );
        const CliResult* same = cli_run( "$R compare c%d/f.02.exr c0/f.02.exr", k );
        cli_expect( same, 0, NULL );
        assert_non_null( strstr( same->out, "all pixels are identical" ) );
    }
    cli_expect( cli_run( "$R denoise m0 -o some --frames 1,3 --json c.json --quiet " BOX ), 0, NULL );
    json_t* json = cli_read_json( "c.json" );
    assert_true( figure( json_array_get( json_object_get( json, "frames" ), 1 ), "along_motion" ) == 0.0 );
    json_decref( json );
}

TEST( test_files_without_halves )
{
    cli_expect( cli_run( RENDER "-o plain.exr --frames 1 --spp 8 --group 0" ), 0, NULL );
    const CliResult* done = cli_run( "$R denoise plain.exr -o smooth.exr " BOX );
    cli_expect( done, 0, "warning: the error of 1 frame is not known: render with --denoise or --aov half" );
    assert_non_null( strstr( done->out, "error unknown" ) );
}

// The estimates of other commands are not those of the noisy picture.
TEST( test_estimates_are_of_the_denoised_picture )
{
    cli_expect( cli_run( LARGE "-o est/f.##.exr --frames 1-2 --spp 8 --group 0 --aov variance --denoise " BOX ), 0, NULL );
    double told = strtod( cli_exr_text( "est/f.01.exr", "reframe/denoised-relmse" ), NULL ) / 2.0 +
                  strtod( cli_exr_text( "est/f.02.exr", "reframe/denoised-relmse" ), NULL ) / 2.0;
    cli_expect( cli_run( "$R report est -o est.html --json est.json --quiet" ), 0, NULL );
    json_t *report = cli_read_json( "est.json" ), *sequence = json_array_get( json_object_get( report, "sequences" ), 0 );
    assert_true( fabs( figure( sequence, "relmse_estimate" ) / told - 1.0 ) < 1e-3 );
    json_decref( report );
    const CliResult* done = cli_run( "$R flicker est/f.##.exr --json -" );
    cli_expect( done, 0, NULL );
    assert_non_null( strstr( done->out, "\"error_from\": null" ) );
}

TEST( test_resume_knows_the_denoiser )
{
    cli_expect( cli_run( RENDER "-o res.##.exr --frames 1-2 --spp 4 --group 0 --denoise " BOX ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE --size 64x36 -o res.##.exr --frames 1-2 --spp 4 --group 0 --check --denoise " BOX ), 0,
                NULL );
    cli_expect( cli_run( RENDER "-o res.##.exr --frames 1-2 --spp 4 --group 0 --tile rooks16 --filter box --resume "
                                "--aov denoise_albedo,denoise_normal,half" ),
                1, "of --denoiser Open Image Denoise 2.0.0 (here none)" );
}

TEST( test_bad_input_is_one_line )
{
    cli_expect( cli_run( RENDER "-o bad.exr --frames 1 --spp 4 --group 0 --aov half" ), 0, NULL );
    cli_expect( cli_run( "$R denoise bad.exr" ), 2, "-o is missing" );
    cli_expect( cli_run( "$R denoise bad.exr -o bad.exr " BOX ), 2, "bad.exr: would overwrite an input" );
    cli_expect( cli_run( "$R denoise bad.exr -o ./bad.exr " BOX ), 2, "would overwrite an input" );
    cli_expect( cli_run( "$R denoise none.exr -o x.exr " BOX ), 1, "none.exr: " );
    cli_expect( cli_run( "$R denoise bad.exr -o x.exr --denoiser none.so" ), 1, "the denoiser cannot be loaded: none.so: " );
    cli_expect( cli_run( "FAKE_OIDN=old $R denoise bad.exr -o x.exr " BOX ), 1, "is Open Image Denoise 1.4, but 2.0 or later" );
    cli_expect( cli_run( "FAKE_OIDN=fail $R denoise bad.exr -o x.exr " BOX ), 1, "Open Image Denoise: it has no memory" );
    assert_false( cli_exists( "x.exr" ) );
    cli_expect( cli_run( "$R denoise bad.exr -o x.exr --quiet " BOX ), 0, NULL );
    cli_expect( cli_run( "$R denoise bad.exr -o x.exr " BOX ), 1, "x.exr: already exists: --overwrite replaces it" );
    cli_expect(
        cli_run( RENDER "-o s.1.exr --frames 1 --spp 4 --group 0 --aov half; " LARGE "-o s.2.exr --frames 2 --spp 4 --group 0" ),
        0, NULL );
    cli_expect( cli_run( "$R denoise s.#.exr -o sizes --quiet " BOX ), 1,
                "s.2.exr: has 128x72 pixels, but the first frame 64x36" );
    // a system may have a library of its own
    if ( cli_run( "HOME=/none XDG_CACHE_HOME=/none REFRAME_OIDN= $R denoise bad.exr -o o.exr --quiet" )->status != 0 )
        cli_expect( cli_run( "HOME=/none XDG_CACHE_HOME=/none REFRAME_OIDN= $R denoise bad.exr -o o.exr" ), 1,
                    "Open Image Denoise 2 is not there: get it by scripts/install-packages --denoiser, or name its library" );
    cli_expect( cli_run( "head -c 20000 bad.exr > cut.exr; $R denoise cut.exr -o y.exr " BOX ), 1, "cut.exr: " );
    assert_false( cli_exists( "y.exr" ) );
    cli_expect( cli_run( RENDER "-o g.exr --frames 1 --spp 4 --denoise --estimator gradient " BOX ), 2,
                "the estimator 'gradient' has no half AOV" );
    cli_expect( cli_run( RENDER "-o g.exr --frames 1 --spp 4 --denoise --denoiser none.so" ), 1,
                "the denoiser cannot be loaded: none.so: " );
    assert_false( cli_exists( "g.exr" ) );
}

TEST( test_open_image_denoise_where_it_is )
{
    RfDenoiser* denoiser;
    RfError error;
    if ( rf_open_denoiser( NULL, 0, &denoiser, &error ) != RF_OK )
    {
        print_message( "skipped: %s\n", error.text );
        return;
    }
    print_message( "ran by %s\n", rf_denoiser_name( denoiser ) );
    rf_close_denoiser( denoiser );
    cli_expect( cli_run( LARGE "-o real.exr --frames 1 --spp 8 --group 0 --denoise --json real.json" ), 0, NULL );
    json_t *json = cli_read_json( "real.json" ), *row = json_array_get( json_object_get( json, "frames" ), 0 );
    const json_t* denoised = json_object_get( row, "denoised" );
    assert_true( figure( denoised, "relmse" ) < figure( denoised, "noisy_relmse" ) );
    json_decref( json );
    cli_expect( cli_run( LARGE "-o real2.exr --frames 1 --spp 8 --group 0 --denoise --threads 1" ), 0, NULL );
    cli_expect( cli_run( "$R compare real.exr real2.exr" ), 0, NULL );
#define UNTIL "$R render $VASE --size 320x180 --quiet --frames 1 --group 0 --tile 1 --noise 0.01 "
    cli_expect( cli_run( UNTIL "-o less.exr --denoise --json less.json" ), 0, NULL );
    cli_expect( cli_run( UNTIL "-o more.exr --filter box --json more.json" ), 0, NULL );
    assert_true( spp_of( "less.json" ) < 0.5 * spp_of( "more.json" ) );
}
