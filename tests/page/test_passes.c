// Passes are found in files of Reframe, Blender and Nuke, in one part or several, each once, and look as what they are.
#include "page/pass_groups.h"
#include "support/image_files.h"
#include "support/image_support.h"
#include "support/test.h"

enum
{
    SIDE = 4,
    PIXELS = SIDE * SIDE
};

static const float s_values[PIXELS] = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16 };

// A file with colour and these channels.
static void write_channels( const char* path, const char* const* names, int count )
{
    AUTO_IMAGE image;
    assert_int_equal( rf_create_image( SIDE, SIDE, &image, NULL ), RF_OK );
    RfExrChannel channels[64];
    RfExrOptions options = rf_default_exr_options();
    for ( int i = 0; i < count; ++i )
        channels[i] = ( RfExrChannel ){ .name = names[i], .values = s_values, .stride = 1 };
    options.channels = channels;
    options.channel_count = count;
    assert_int_equal( rf_write_exr( path, &image, &options, NULL ), RF_OK );
}

// The names of the passes of a file.
static void list_names( const char* path, char* text, size_t size )
{
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    RfFilePasses passes;
    assert_int_equal( rf_read_exr_header( path, NULL, &header, NULL ), RF_OK );
    assert_int_equal( rf_list_passes( &header, &passes, NULL ), RF_OK );
    rf_name_passes( &passes, text, size );
    rf_free_passes( &passes );
}

static void check_names( const char* path, const char* wanted )
{
    char text[512];
    list_names( path, text, sizeof text );
    assert_string_equal( text, wanted );
}

TEST( test_names_of_reframe )
{
    static const char* const names[] = {
        "light_key.R",      "light_key.G",
        "light_key.B",      "depth.Z",
        "motion.X",         "motion.Y",
        "motion.Z",         "motion.W",
        "normal.X",         "normal.Y",
        "normal.Z",         "A",
        "CryptoObject00.R", "CryptoObject00.G",
        "CryptoObject00.B", "CryptoObject00.A",
        "CryptoObject01.R", "CryptoObject01.G",
        "CryptoObject01.B", "CryptoObject01.A",
        "object_index.Y",   "dx.R",
        "primal.variance",  "direct.R",
        "direct.G",         "direct.B",
    };
    const char* path = cli_path( "r.exr" );
    write_channels( path, names, (int)( sizeof names / sizeof names[0] ) );
    // a dx without green and blue is none
    check_names( path, "normal, depth, motion, direct, alpha, light_key, CryptoObject, object_index, primal.variance" );
    char text[24];
    list_names( path, text, sizeof text );
    assert_string_equal( text, "normal, depth, ..." );
    char layer[RF_PASS_LAYER_SIZE];
    assert_string_equal( rf_layer_of_file( path, "depth", layer ), "depth.Z" );
    assert_string_equal( rf_layer_of_file( path, "motion", layer ), "motion.X,motion.Y,motion.Z" );
    assert_string_equal( rf_layer_of_file( path, "nothing", layer ), "nothing" );
    assert_null( rf_layer_of_file( path, NULL, layer ) );
}

TEST( test_names_of_blender )
{
    static const char* const names[] = {
        "ViewLayer.Depth.Z",
        "ViewLayer.Vector.X",
        "ViewLayer.Vector.Y",
        "ViewLayer.Vector.Z",
        "ViewLayer.Vector.W",
        "ViewLayer.DiffCol.R",
        "ViewLayer.DiffCol.G",
        "ViewLayer.DiffCol.B",
        "ViewLayer.Combined_at.R",
        "ViewLayer.Combined_at.G",
        "ViewLayer.Combined_at.B",
        "ViewLayer.Mist.Z",
        "ViewLayer.Combined.A",
        "ViewLayer.Denoising Albedo.R",
        "ViewLayer.Denoising Albedo.G",
        "ViewLayer.Denoising Albedo.B",
        "ViewLayer.CryptoAsset0.r",
        "ViewLayer.CryptoAsset0.g",
    };
    const char* path = cli_path( "b.exr" );
    write_channels( path, names, (int)( sizeof names / sizeof names[0] ) );
    check_names( path, "albedo, denoise_albedo, depth, motion, alpha, light_at, CryptoAsset, Mist" );
    char layer[RF_PASS_LAYER_SIZE];
    assert_string_equal( rf_layer_of_file( path, "light_at", layer ),
                         "ViewLayer.Combined_at.R,ViewLayer.Combined_at.G,ViewLayer.Combined_at.B" );
    assert_string_equal( rf_layer_of_file( path, "Mist", layer ), "ViewLayer.Mist.Z" );
    assert_string_equal( rf_layer_of_file( path, "ViewLayer.Mist", layer ), "ViewLayer.Mist.Z" );
    assert_string_equal( rf_layer_of_file( path, "Depth", layer ), "ViewLayer.Depth.Z" );
}

// Of Nuke's two layers of motion each may be a part.
TEST( test_names_of_nuke )
{
    const Foreign parts[] = {
        { .names = { "B", "G", "R" }, .values = { 1, 1, 1 }, .width = 8, .height = 4, .part = "rgba" },
        { .names = { "backward.u", "backward.v" }, .values = { 1, 2 }, .width = 8, .height = 4, .part = "backward" },
        { .names = { "forward.u", "forward.v" }, .values = { 3, 4 }, .width = 8, .height = 4, .part = "forward" },
    };
    const char* path = cli_path( "n.exr" );
    write_foreign_exr( path, parts, (int)( sizeof parts / sizeof parts[0] ) );
    check_names( path, "motion" );
    char layer[RF_PASS_LAYER_SIZE];
    assert_string_equal( rf_layer_of_file( path, "backward", layer ), "backward.u,backward.v,forward.u" );
}

// A part is the layer where its channels have none; a Cryptomatte may have a part for each two ranks.
TEST( test_parts )
{
    const Foreign parts[] = {
        { .names = { "A", "B", "G", "R" }, .values = { 1, 1, 1, 1 }, .width = 8, .height = 4, .part = "rgba" },
        { .names = { "Z" }, .values = { 3 }, .width = 8, .height = 4, .part = "depth" },
        { .names = { "light_key.B", "light_key.G", "light_key.R" }, .values = { 1 }, .width = 8, .height = 4, .part = "key" },
        { .names = { "A", "B", "G", "R" }, .values = { 1, 1, 1, 1 }, .width = 8, .height = 4, .part = "CryptoObject00" },
        { .names = { "A", "B", "G", "R" }, .values = { 1, 1, 1, 1 }, .width = 8, .height = 4, .part = "CryptoObject01" },
        { .names = { "light_key.B", "light_key.G", "light_key.R" }, .values = { 1 }, .width = 8, .height = 4, .part = "again" },
    };
    const char* path = cli_path( "p.exr" );
    write_foreign_exr( path, parts, (int)( sizeof parts / sizeof parts[0] ) );
    check_names( path, "depth, alpha, light_key, again.light_key, CryptoObject" );
    char layer[RF_PASS_LAYER_SIZE];
    AUTO_IMAGE image;
    RfExrWindow window;
    assert_int_equal( rf_read_exr_layer( path, rf_layer_of_file( path, "light_key", layer ), &image, &window, NULL ), RF_OK );
}

static void draw( const char* name, RfLook look, int channels, const float* values, int pixels, float* rgb )
{
    RfFilePass pass = { .look = look, .channel_count = channels };
    snprintf( pass.name, sizeof pass.name, "%s", name );
    RfLookRange range = rf_pass_range( &pass, values, (size_t)channels, (size_t)pixels );
    rf_draw_pass( &pass, range, values, (size_t)channels, (size_t)pixels, rgb );
}

// An id has the same colour in all ranks, and its coverage weighs it.
TEST( test_mattes_are_coloured_by_id )
{
    const uint32_t bits[2] = { 0x3f2a91c4u, 0x40b37e05u };
    float ids[2], rgb[12];
    memcpy( ids, bits, sizeof ids );
    const float pairs[4][4] = {
        { ids[0], 1.0f, 0.0f, 0.0f }, { ids[1], 0.5f, 0.0f, 0.0f }, { ids[1], 0.75f, ids[0], 0.25f }, { 0.0f, 1.0f, 0.0f, 0.0f }
    };
    draw( "CryptoObject", RF_LOOK_MATTES, 4, pairs[0], 4, rgb );
    for ( int c = 0; c < 3; ++c )
        assert_true( fabsf( rgb[6 + c] - ( 1.5f * rgb[3 + c] + 0.25f * rgb[c] ) ) < 1e-6f && rgb[9 + c] == 0.0f );
    assert_true( fabsf( rgb[0] - 2.0f * rgb[3] ) + fabsf( rgb[1] - 2.0f * rgb[4] ) + fabsf( rgb[2] - 2.0f * rgb[5] ) > 0.1f );
}

TEST( test_indices_and_signs )
{
    float rgb[12];
    const float indices[4] = { 0.0f, 1.0f, 2.0f, 1.0f };
    draw( "object_index", RF_LOOK_INDEX, 1, indices, 4, rgb );
    assert_true( rgb[0] + rgb[1] + rgb[2] == 0.0f && memcmp( rgb + 3, rgb + 9, 3 * sizeof *rgb ) == 0 );
    assert_true( fabsf( rgb[3] - rgb[6] ) + fabsf( rgb[4] - rgb[7] ) + fabsf( rgb[5] - rgb[8] ) > 0.1f );
    const float differences[6] = { 0.0f, -1.0f, 1.0f, 0.0f, 0.0f, NAN };
    draw( "dx", RF_LOOK_SIGNED, 3, differences, 2, rgb );
    assert_true( rgb[1] < rgb[0] && rgb[0] < rgb[2] && rgb[3] == rgb[0] && isnan( rgb[5] ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
