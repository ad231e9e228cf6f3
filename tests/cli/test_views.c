// View transforms against Blender's own, and how `png` chooses one.
#include "support/cli_run.h"
#include "support/test.h"

#include "cli/view/view.h"
#include "image/decode.h"
#include "reframe/image.h"

// What Blender shows of a colour, of 255: 3.4 for Filmic, 4.3 for AgX.
typedef struct Shown
{
    const char *transform, *look;
    float light[3], shown[3], tolerance;
} Shown;

static const Shown s_shown[] = {
    { "Standard", "", { 0.18f, 0.5f, 2.0f }, { 117.6f, 187.5f, 255.0f }, 0.1f },
    { "Filmic", "", { 0.01f, 0.18f, 0.5f }, { 25.8f, 127.6f, 177.2f }, 0.6f },
    { "filmic", "None", { 1.0f, 4.0f, 16.0f }, { 205.8f, 242.1f, 254.9f }, 0.6f },
    { "Filmic", "High Contrast", { 0.01f, 0.18f, 1.0f }, { 13.1f, 127.6f, 220.1f }, 0.6f },
    { "AgX", "", { 0.01f, 0.01f, 0.01f }, { 18.5f, 18.5f, 18.5f }, 0.7f },
    { "AgX", "", { 0.18f, 0.18f, 0.18f }, { 117.6f, 117.6f, 117.6f }, 0.7f },
    { "AgX", "", { 4.0f, 4.0f, 4.0f }, { 233.0f, 233.0f, 233.0f }, 0.7f },
    { "AgX", "AgX - Base Contrast", { 0.5f, 0.02f, 0.02f }, { 180.2f, 41.7f, 28.3f }, 4.0f },
    { "AgX", "", { 0.02f, 0.02f, 1.0f }, { 48.7f, 93.2f, 209.4f }, 6.0f },
    { "agx", "punchy", { 0.18f, 0.18f, 0.18f }, { 88.3f, 88.3f, 88.3f }, 0.9f },
};

TEST( test_our_views_are_those_of_blender )
{
    setenv( "OCIO", "", 1 );
    for ( size_t i = 0; i < sizeof s_shown / sizeof s_shown[0]; ++i )
    {
        const Shown* s = s_shown + i;
        RfViewText text = { .exposure = 0.0 };
        snprintf( text.transform, sizeof text.transform, "%s", s->transform );
        snprintf( text.look, sizeof text.look, "%s", s->look );
        for ( int stops = 0; stops < 2; ++stops ) // by the view's exposure, or as they are
        {
            RfView* view;
            RfError error;
            text.exposure = stops;
            assert_int_equal( rf_open_view( &text, &view, &error ), RF_OK );
            float rgb[3];
            for ( int c = 0; c < 3; ++c )
                rgb[c] = s->light[c] / exp2f( (float)stops );
            rf_apply_view( view, rgb, 1 );
            rf_close_view( view );
            for ( int c = 0; c < 3; ++c )
            {
                if ( !( fabsf( 255.0f * rgb[c] - s->shown[c] ) <= s->tolerance ) )
                    fail_msg( "%s, %s: %g is shown as %g, not %g", s->transform, s->look, (double)s->light[c],
                              (double)( 255.0f * rgb[c] ), (double)s->shown[c] );
            }
        }
    }
}

TEST( test_odd_light_is_shown )
{
    static const char* const s_views[] = { "Standard", "Filmic", "AgX" };
    for ( int i = 0; i < 3; ++i )
    {
        RfViewText text = { .gamma = 2.0 };
        snprintf( text.transform, sizeof text.transform, "%s", s_views[i] );
        snprintf( text.look, sizeof text.look, "%s", i == 2 ? "Very High Contrast" : "" );
        RfView* view;
        float rgb[] = { -1.0f, 0.0f, INFINITY, 1e30f, -INFINITY, 1e-30f, -0.1f, 0.2f, 0.3f, 0.04f, 0.04f, 0.04f };
        assert_int_equal( rf_open_view( &text, &view, NULL ), RF_OK );
        rf_apply_view( view, rgb, 4 );
        for ( size_t k = 0; k < sizeof rgb / sizeof rgb[0]; ++k )
            assert_true( rgb[k] >= 0.0f && rgb[k] <= 1.0f );
        rf_close_view( view );
        text.gamma = 1.0;
        float plain[] = { 0.04f, 0.04f, 0.04f };
        assert_int_equal( rf_open_view( &text, &view, NULL ), RF_OK );
        rf_apply_view( view, plain, 1 );
        rf_close_view( view );
        assert_true( fabsf( sqrtf( plain[0] ) - rgb[9] ) < 1e-5f );
    }
}

// A file of one colour, which names a view unless `view` is NULL.
static void write_grey( const char* name, float light, const char* view, const char* exposure )
{
    float rgb[4 * 3];
    for ( int i = 0; i < 12; ++i )
        rgb[i] = light;
    RfImage image = { 2, 2, rgb };
    RfExrString strings[] = { { "reframe/view", view }, { "reframe/exposure", exposure } };
    RfExrOptions options = rf_default_exr_options();
    options.strings = strings;
    options.string_count = view == NULL ? 0 : 2;
    assert_int_equal( rf_write_exr( cli_path( name ), &image, &options, NULL ), RF_OK );
}

static int level_of( const char* name )
{
    size_t size;
    AUTO_FREE char* bytes = cli_read( name, &size );
    AUTO_BY( rf_destroy_pixels ) RfPixels pixels = { 0 };
    RfError error;
    assert_int_equal( rf_decode_image( bytes, size, name, &pixels, &error ), RF_OK );
    int level = *(const unsigned char*)pixels.data;
    return level;
}

static void expect_level( int level, const char* name, const char* options )
{
    cli_expect( cli_run( "$R png %s.exr %s.png %s", name, name, options ), 0, NULL );
    char png[64];
    snprintf( png, sizeof png, "%s.png", name );
    if ( abs( level_of( png ) - level ) > 1 )
        fail_msg( "%s, %s: a level of %d, not %d", name, options, level_of( png ), level );
}

TEST( test_png_shows_as_the_file_says )
{
    write_grey( "agx.exr", 0.09f, "AgX", "1" );
    write_grey( "plain.exr", 0.09f, NULL, NULL );
    expect_level( 118, "agx", "" );
    expect_level( 118, "agx", "--view standard" );
    expect_level( 85, "agx", "--view standard --exposure 0" );
    expect_level( 88, "agx", "--look punchy" );
    expect_level( 85, "plain", "" );
    expect_level( 128, "plain", "--view filmic --exposure 1" );
    expect_level( 118, "plain", "--exposure auto" );
    write_grey( "bright.exr", 900.0f, NULL, NULL );
    expect_level( 118, "bright", "--exposure auto" );
    write_grey( "black.exr", 0.0f, NULL, NULL );
    expect_level( 0, "black", "--exposure auto" );
    cli_expect( cli_run( "$R png agx.exr b.png --view none" ), 2, "unknown view 'none', expected Standard, Filmic, AgX" );
    cli_expect( cli_run( "$R png agx.exr b.png --look soft" ), 2, "unknown look 'soft' of the view 'AgX'" );
    write_grey( "other.exr", 0.09f, "Cinema", "1" );
    const CliResult* other = cli_run( "$R png other.exr other.png" );
    assert_int_equal( other->status, 0 );
    assert_non_null( strstr( other->err, "other.exr: shown by the sRGB curve: unknown view 'Cinema'" ) );
    assert_int_equal( level_of( "other.png" ), 118 );
    write_grey( "odd.exr", 0.18f, "Standard", "1e30" );
    expect_level( 118, "odd", "" );
    cli_expect( cli_run( "$R png agx.exr b.png --exposure bright" ), 2, "--exposure" );
    assert_false( cli_exists( "b.png" ) );
}

TEST( test_png_makes_its_folder )
{
    write_grey( "s.0001.exr", 0.1f, NULL, NULL );
    write_grey( "s.0002.exr", 0.2f, NULL, NULL );
    cli_expect( cli_run( "$R png s.####.exr shown" ), 0, NULL );
    assert_true( cli_exists( "shown/s.0001.png" ) && cli_exists( "shown/s.0002.png" ) );
    cli_expect( cli_run( "$R png s.####.exr more/t.##.png --exposure auto" ), 0, NULL );
    // the middle of both
    assert_true( abs( level_of( "more/t.01.png" ) - 100 ) <= 1 );
    cli_expect( cli_run( "$R png s.0001.exr one/" ), 0, NULL );
    assert_true( cli_exists( "one/s.0001.png" ) );
    cli_expect( cli_run( "$R png s.0001.exr no/such/a.png" ), 1, "cannot be made" );
}

TEST( test_scene_files_name_a_view )
{
    static const char* const faults[][2] = {
        { "3", "s.json: view: must be an object, got 3" },
        { "{}", "view.transform: is missing: must be the name of a view, such as \"AgX\"" },
        { "{\"transform\":\"AgX\",\"looks\":\"Punchy\"}", "view.looks: unknown key, did you mean look?" },
        { "{\"transform\":\"AgX\",\"exposure\":40}", "view.exposure: must be" },
        { "{\"transform\":\"AgX\",\"gamma\":0}", "view.gamma: must be" },
    };
    char text[300];
    for ( size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i )
    {
        int size = snprintf( text, sizeof text, "{\"scene\":\"%s\",\"view\":%s}", REFRAME_VASE_ROOM, faults[i][0] );
        cli_write( "s.json", text, (size_t)size );
        cli_expect( cli_run( "$R info s.json" ), 1, faults[i][1] );
    }
    int size =
        snprintf( text, sizeof text, "{\"scene\":\"%s\",\"view\":{\"transform\":\"AgX\",\"exposure\":1}}", REFRAME_VASE_ROOM );
    cli_write( "s.json", text, (size_t)size );
    cli_expect( cli_run( "$R render s.json -o v/v.####.exr --frames 1 --size 16x9 --spp 4 --group 0 --quiet" ), 0, NULL );
    cli_expect( cli_run( "$R png v/v.0001.exr shown.png" ), 0, NULL );
    cli_expect( cli_run( "$R png v/v.0001.exr asked.png --view agx --exposure 1" ), 0, NULL );
    cli_expect( cli_run( "$R png v/v.0001.exr plain.png --view standard --exposure 0" ), 0, NULL );
    assert_int_equal( cli_run( "cmp shown.png asked.png" )->status, 0 );
    assert_int_equal( cli_run( "cmp -s shown.png plain.png" )->status, 1 );
    cli_expect( cli_run( "$R report v -o v.html" ), 0, NULL );
    assert_int_equal( cli_run( "grep -q '\"view\":\"AgX\"' v.html && grep -q '\"exposure\":1.0,' v.html" )->status, 0 );
    cli_expect( cli_run( "$R report v -o w.html --view none" ), 2, "--view: unknown view 'none'" );
    assert_false( cli_exists( "w.html" ) );
}

#ifdef REFRAME_OCIO

static const char s_config[] = "ocio_profile_version: 2\n"
                               "roles: {scene_linear: lin, default: lin}\n"
                               "file_rules:\n  - !<Rule> {name: Default, colorspace: default}\n"
                               "displays:\n  sRGB:\n    - !<View> {name: Half, colorspace: half}\n"
                               "looks:\n  - !<Look>\n    name: Half - Dark\n    process_space: lin\n"
                               "    transform: !<MatrixTransform> {matrix: [.5,0,0,0, 0,.5,0,0, 0,0,.5,0, 0,0,0,1]}\n"
                               "colorspaces:\n  - !<ColorSpace>\n    name: lin\n"
                               "  - !<ColorSpace>\n    name: half\n"
                               "    from_scene_reference: !<MatrixTransform> {matrix: [.5,0,0,0, 0,.5,0,0, 0,0,.5,0, 0,0,0,1]}\n";

TEST( test_views_of_a_configuration )
{
    cli_write( "config.ocio", s_config, sizeof s_config - 1 );
    cli_write( "broken.ocio", "}", 1 );
    write_grey( "c.exr", 0.8f, NULL, NULL );
    setenv( "OCIO", "config.ocio", 1 );
    expect_level( 102, "c", "--view half" );
    expect_level( 51, "c", "--view HALF --look dark" );
    expect_level( 231, "c", "" );
    cli_expect( cli_run( "$R png c.exr b.png --view quarter" ), 2, "in the configuration Half" );
    cli_expect( cli_run( "$R png c.exr b.png --view half --look light" ), 2, "expected Half - Dark" );
    setenv( "OCIO", "broken.ocio", 1 );
    expect_level( 231, "c", "" );
    cli_expect( cli_run( "$R png c.exr b.png --view half" ), 1, "broken.ocio: OpenColorIO cannot read it" );
    setenv( "OCIO", "", 1 );
}

#endif

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
