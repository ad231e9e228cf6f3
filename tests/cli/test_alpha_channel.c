// reframe render --alpha as a user sees it: RGBA in the files, a PNG with straight alpha, commands that read the files.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "image/exr.h"

#define WIDTH 24
#define HEIGHT 18
#define SMALL "--size 24x18 --spp 8 --group 0 --quiet"

static void write_scene( void )
{
    write_room( "" ); // a triangle
    write_text( "sky.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[1,2,4]}}" );
}

// The names of the channels in the header, which are sorted: one after another, each with 16 bytes behind it.
static void check_order( const char* name, const char* wanted )
{
    size_t size, at = 0;
    char *bytes = cli_read( name, &size ), *list = NULL;
    for ( size_t i = 0; i + 20 < size && list == NULL; ++i )
        list = memcmp( bytes + i, "channels\0chlist\0", 16 ) == 0 ? bytes + i + 20 : NULL;
    assert_non_null( list );
    for ( ; list[at] != '\0'; at += strlen( list + at ) + 17 )
        assert_true( *wanted != '\0' && list[at] == *wanted++ && list[at + 1] == '\0' );
    assert_true( *wanted == '\0' );
    free( bytes );
}

TEST( test_files_are_premultiplied_rgba )
{
    write_scene();
    cli_expect( cli_run( "$R render sky.json -o a/f.####.exr " SMALL " --alpha" ), 0, NULL );
    cli_expect( cli_run( "$R render sky.json -o n/f.####.exr " SMALL ), 0, NULL );
    check_order( "a/f.0001.exr", "ABGR" );
    check_order( "n/f.0001.exr", "BGR" );
    assert_null( cli_read_channel( "n/f.0001.exr", "A", NULL ) );
    float *alpha = cli_read_channel( "a/f.0001.exr", "A", NULL ), *blue = cli_read_channel( "a/f.0001.exr", "B", NULL ),
          *plain = cli_read_channel( "n/f.0001.exr", "B", NULL );
    assert_true( alpha != NULL && blue != NULL && plain != NULL );
    int none = 0, all = 0;
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        none += alpha[i] == 0.0f && blue[i] == 0.0f;
        all += alpha[i] == 1.0f;
        float difference = blue[i] + 4.0f * ( 1.0f - alpha[i] ) - plain[i];
        assert_true( difference < 0.01f && difference > -0.01f ); // half floats
    }
    assert_true( none > 50 && all > 50 && none + all < WIDTH * HEIGHT );
    free( alpha );
    free( blue );
    free( plain );
}

TEST( test_png_has_straight_alpha )
{
    write_scene();
    cli_expect( cli_run( "$R render sky.json -o a.exr " SMALL " --alpha" ), 0, NULL );
    cli_expect( cli_run( "$R render sky.json -o n.exr " SMALL ), 0, NULL );
    cli_expect( cli_run( "$R png a.exr a.png --exposure -3" ), 0, NULL );
    cli_expect( cli_run( "$R png n.exr n.png" ), 0, NULL );
    size_t size;
    char *with = cli_read( "a.png", &size ), *without = cli_read( "n.png", &size );
    assert_int_equal( with[25], 6 ); // PNG: colour and alpha
    assert_int_equal( without[25], 2 );
    free( with );
    free( without );
    // straight: at the rim the colour is that of the triangle, half as bright if it were not divided
    RfImage image = { 1, 1, ( float[3] ){ 0.25f, 0.125f, 0.5f } };
    const char* path = cli_path( "one.png" );
    float half = 0.5f, one = 1.0f;
    assert_int_equal( rf_write_png_alpha( path, &image, &half, 0.0f, NULL ), RF_OK );
    AUTO_FREE char* straight = cli_read( "one.png", &size );
    size_t first = size;
    image.rgb = ( float[3] ){ 0.5f, 0.25f, 1.0f };
    assert_int_equal( rf_write_png_alpha( path, &image, &one, 0.0f, NULL ), RF_OK );
    AUTO_FREE char* opaque = cli_read( "one.png", &size );
    // a pixel is red green blue alpha behind the byte of the filter: the files differ in alpha and checksums alone
    assert_int_equal( first, size );
    int different = 0;
    for ( size_t i = 0; i < size; ++i )
        different += straight[i] != opaque[i];
    assert_true( different > 0 && different <= 1 + 4 + 4 );
}

TEST( test_other_commands_read_it )
{
    write_scene();
    cli_expect( cli_run( "$R render sky.json -o c/f.####.exr " SMALL " --alpha --aov depth" ), 0, NULL );
    const CliResult* same = cli_run( "$R compare c/f.####.exr c/f.####.exr --json -" );
    cli_expect( same, 0, NULL );
    assert_non_null( strstr( same->out, "\"max\": 0.0" ) );
    cli_expect( cli_run( "$R compare --layer A c/f.0001.exr c/f.0001.exr" ), 0, NULL );
    cli_expect( cli_run( "cp c/f.0001.exr c/f.0002.exr && $R flicker c/f.####.exr" ), 0, NULL );
    cli_expect( cli_run( "rm c/f.0002.exr && $R report c -o page.html" ), 0, NULL );
    // a picture with alpha is another one
    cli_expect( cli_run( "$R render sky.json -o c/f.####.exr " SMALL " --resume --aov depth" ), 1, "--resume: c/f.0001.exr" );
    cli_expect( cli_run( "$R render sky.json -o c/f.####.exr " SMALL " --resume --alpha --aov depth" ), 0, NULL );
    // a scene file may ask for it
    write_text( "asks.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[1,2,4]},\"render\":{\"alpha\":true}}" );
    cli_expect( cli_run( "$R render asks.json -o b.exr " SMALL ), 0, NULL );
    check_order( "b.exr", "ABGR" );
    // and a glTF, whose default goes behind the command line
    write_room( ",\"extras\":{\"reframe\":{\"render\":{\"alpha\":true}}}" );
    cli_expect( cli_run( "$R render room.gltf -o d.exr " SMALL " && $R render room.gltf -o e.exr --no-alpha " SMALL ), 0, NULL );
    check_order( "d.exr", "ABGR" );
    check_order( "e.exr", "BGR" );
    write_room( ",\"extras\":{\"reframe\":{\"render\":{\"alpha\":1}}}" );
    cli_expect( cli_run( "$R render room.gltf -o d.exr " SMALL ), 1, "extras.reframe.render.alpha: must be" );
    write_room( "" );
    cli_expect( cli_run( "$R render sky.json -o r.exr --aov alpha" ), 2, "unknown AOV 'alpha'" );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
