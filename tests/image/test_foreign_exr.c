// EXR files of other programs: layouts and channel names, refusals, and damaged files,
// which may fail but must not crash, hang or allocate wildly.
#include "support/image_support.h"
#include "support/test.h"

#include <openexr.h>
#include <time.h>

typedef struct Layout
{
    exr_storage_t storage;
    exr_compression_t compression;
    exr_pixel_type_t type;
    const char* names[8]; // sorted; channel i has value 1000 i + 10 y + x
    int sampling;         // of all channels
    int tile_width, tile_height;
    exr_attr_box2i_t window;
    int parts;
} Layout;

static exr_attr_box2i_t make_window( int x0, int y0, int x1, int y1 )
{
    return ( exr_attr_box2i_t ){ .min = { .x = x0, .y = y0 }, .max = { .x = x1, .y = y1 } };
}

static Layout default_layout( void )
{
    return ( Layout ){ .storage = EXR_STORAGE_SCANLINE,
                       .compression = EXR_COMPRESSION_ZIP,
                       .type = EXR_PIXEL_FLOAT,
                       .names = { "B", "G", "R" },
                       .sampling = 1,
                       .tile_width = 16,
                       .tile_height = 8,
                       .window = make_window( -5, 3, 31, 47 ),
                       .parts = 1 };
}

static void encode_chunk( exr_context_t context, int part, const exr_chunk_info_t* chunk, int x, int y )
{
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal( exr_encoding_initialize( context, part, chunk, &pipeline ), EXR_ERR_SUCCESS );
    float* values[8] = { 0 };
    for ( int c = 0; c < pipeline.channel_count; ++c )
    {
        exr_coding_channel_info_t* channel = pipeline.channels + c;
        int width = channel->width, height = channel->height;
        values[c] = calloc( (size_t)width * (size_t)height + 1, sizeof( float ) );
        uint32_t* whole = (uint32_t*)values[c];
        for ( int i = 0; i < width * height; ++i )
        {
            int value = 1000 * c + 10 * ( y + i / width ) + x + i % width + 5000 * part;
            if ( channel->data_type == EXR_PIXEL_UINT )
                whole[i] = (uint32_t)value;
            else
                values[c][i] = (float)value;
        }
        channel->encode_from_ptr = (const uint8_t*)values[c];
        channel->user_data_type = channel->data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = 4;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = 4 * width;
    }
    assert_int_equal( exr_encoding_choose_default_routines( context, part, &pipeline ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_encoding_run( context, part, &pipeline ), EXR_ERR_SUCCESS );
    for ( int c = 0; c < 8; ++c )
        free( values[c] );
    exr_encoding_destroy( context, &pipeline );
}

static void define_part( exr_context_t context, const Layout* layout, int part )
{
    int index;
    const exr_attr_v2f_t center = { .x = 0.0f, .y = 0.0f };
    assert_int_equal( exr_add_part( context, part == 0 ? "one" : "two", layout->storage, &index ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_initialize_required_attr( context, part, &layout->window, &layout->window, 1.0f, &center, 1.0f,
                                                    EXR_LINEORDER_INCREASING_Y, layout->compression ),
                      EXR_ERR_SUCCESS );
    if ( layout->storage == EXR_STORAGE_TILED )
        assert_int_equal( exr_set_tile_descriptor( context, part, (uint32_t)layout->tile_width, (uint32_t)layout->tile_height,
                                                   EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN ),
                          EXR_ERR_SUCCESS );
    for ( int c = 0; layout->names[c] != NULL; ++c )
        assert_int_equal( exr_add_channel( context, part, layout->names[c], layout->type, EXR_PERCEPTUALLY_LOGARITHMIC,
                                           layout->sampling, layout->sampling ),
                          EXR_ERR_SUCCESS );
}

static void write_part( exr_context_t context, const Layout* layout, int part )
{
    int width = layout->window.max.x - layout->window.min.x + 1;
    int height = layout->window.max.y - layout->window.min.y + 1;
    exr_chunk_info_t chunk;
    if ( layout->storage == EXR_STORAGE_TILED )
    {
        for ( int y = 0; y < height; y += layout->tile_height )
        {
            for ( int x = 0; x < width; x += layout->tile_width )
            {
                assert_int_equal(
                    exr_write_tile_chunk_info( context, part, x / layout->tile_width, y / layout->tile_height, 0, 0, &chunk ),
                    EXR_ERR_SUCCESS );
                encode_chunk( context, part, &chunk, x, y );
            }
        }
        return;
    }
    int lines;
    assert_int_equal( exr_get_scanlines_per_chunk( context, part, &lines ), EXR_ERR_SUCCESS );
    for ( int y = 0; y < height; y += lines )
    {
        assert_int_equal( exr_write_scanline_chunk_info( context, part, layout->window.min.y + y, &chunk ), EXR_ERR_SUCCESS );
        encode_chunk( context, part, &chunk, 0, y );
    }
}

static const char* write_layout( const Layout* layout )
{
    const char* path = cli_path( "layout.exr" );
    exr_context_t context = NULL;
    assert_int_equal( exr_start_write( &context, path, EXR_WRITE_FILE_DIRECTLY, NULL ), EXR_ERR_SUCCESS );
    for ( int part = 0; part < layout->parts; ++part )
        define_part( context, layout, part );
    assert_int_equal( exr_write_header( context ), EXR_ERR_SUCCESS );
    for ( int part = 0; part < layout->parts; ++part )
        write_part( context, layout, part );
    assert_int_equal( exr_finish( &context ), EXR_ERR_SUCCESS );
    return path;
}

// Reads a layout; channels of the file that R, G, B come from are given.
static void check_layout( const Layout* layout, int red, int green, int blue )
{
    AUTO_IMAGE image;
    RfError error = { 0 };
    if ( rf_read_exr( write_layout( layout ), &image, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_int_equal( image.width, layout->window.max.x - layout->window.min.x + 1 );
    assert_int_equal( image.height, layout->window.max.y - layout->window.min.y + 1 );
    const int sources[3] = { red, green, blue };
    // lossy formats, and halfs above 2048, keep 8 bits or so
    float precision = layout->type == EXR_PIXEL_HALF ? 0x1p-10f : 0.0f;
    for ( int i = 0; i < 3 * image.width * image.height; ++i )
    {
        int x = i / 3 % image.width, y = i / 3 / image.width;
        float wanted = (float)( 1000 * sources[i % 3] + 10 * y + x );
        if ( fabsf( image.rgb[i] - wanted ) > precision * wanted )
            fail_msg( "(%d, %d) channel %d: %g, not %g", x, y, i % 3, (double)image.rgb[i], (double)wanted );
    }
}

static void check_refused( const Layout* layout, RfResult wanted, const char* word )
{
    RfImage image;
    RfError error = { 0 };
    assert_int_equal( rf_read_exr( write_layout( layout ), &image, &error ), wanted );
    if ( strstr( error.text, word ) == NULL || strstr( error.text, "layout.exr" ) == NULL )
        fail_msg( "'%s' lacks '%s'", error.text, word );
    assert_null( image.rgb );
}

TEST( test_every_layout_is_read )
{
    const exr_compression_t compressions[] = { EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE, EXR_COMPRESSION_ZIPS,
                                               EXR_COMPRESSION_ZIP, EXR_COMPRESSION_PIZ };
    const exr_pixel_type_t types[] = { EXR_PIXEL_UINT, EXR_PIXEL_HALF, EXR_PIXEL_FLOAT };
    for ( int i = 0; i < 30; ++i )
    {
        Layout layout = default_layout();
        layout.compression = compressions[i % 5];
        layout.type = types[i / 5 % 3];
        layout.storage = i < 15 ? EXR_STORAGE_SCANLINE : EXR_STORAGE_TILED;
        check_layout( &layout, 2, 1, 0 );
    }
}

TEST( test_parts_are_found )
{
    Layout layout = default_layout();
    layout.parts = 2;
    check_layout( &layout, 2, 1, 0 );
    layout.storage = EXR_STORAGE_TILED;
    check_layout( &layout, 2, 1, 0 );
}

TEST( test_channel_names_of_others )
{
    const struct
    {
        const char* names[8];
        int red, green, blue;
    } cases[] = {
        { { "A", "B", "G", "R", "Z", "x.R" }, 3, 2, 1 },
        { { "B", "G", "R", "left.B", "left.G", "left.R" }, 2, 1, 0 },
        { { "ViewLayer.Combined.A", "ViewLayer.Combined.B", "ViewLayer.Combined.G", "ViewLayer.Combined.R" }, 3, 2, 1 },
        { { "L.Combined.B", "L.Combined.G", "L.Combined.R", "L.Diff.B", "L.Diff.G", "L.Diff.R" }, 2, 1, 0 },
        { { "A.x.B", "A.x.G", "A.x.R", "L.Combined.B", "L.Combined.G", "L.Combined.R" }, 5, 4, 3 },
        { { "A", "Y" }, 1, 1, 1 },
        { { "R", "Y", "Z" }, 1, 1, 1 },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        // all ways through the library's choice of routines, some of which are traps
        for ( int way = 0; way < 8; ++way )
        {
            Layout layout = default_layout();
            memcpy( layout.names, cases[i].names, sizeof layout.names );
            layout.type = way % 2 == 0 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
            layout.compression = way / 2 % 2 == 0 ? EXR_COMPRESSION_NONE : EXR_COMPRESSION_ZIP;
            layout.storage = way / 4 == 0 ? EXR_STORAGE_SCANLINE : EXR_STORAGE_TILED;
            check_layout( &layout, cases[i].red, cases[i].green, cases[i].blue );
        }
    }
}

TEST( test_refused_channels )
{
    Layout layout = default_layout();
    const char* const two[8] = { "a.B", "a.G", "a.R", "b.B", "b.G", "b.R" };
    memcpy( layout.names, two, sizeof two );
    check_refused( &layout, RF_ERROR_UNSUPPORTED, "a, b" );
    const char* const none[8] = { "A", "Z" };
    memcpy( layout.names, none, sizeof none );
    check_refused( &layout, RF_ERROR_UNSUPPORTED, "A, Z" );
    const char* const chroma[8] = { "BY", "RY", "Y" };
    memcpy( layout.names, chroma, sizeof chroma );
    check_refused( &layout, RF_ERROR_UNSUPPORTED, "chroma" );
    layout = default_layout();
    layout.sampling = 2;
    layout.window = make_window( 0, 0, 31, 31 );
    check_refused( &layout, RF_ERROR_UNSUPPORTED, "subsampled" );
}

// Replaces the value of an attribute whose name and type are `key` (with the
// zeros between and after them) in the bytes of a file.
static void patch( char* bytes, size_t size, const char* key, size_t key_size, size_t skip, char value )
{
    for ( size_t i = 0; i + key_size + skip < size; ++i )
    {
        if ( memcmp( bytes + i, key, key_size ) == 0 )
        {
            bytes[i + key_size + skip] = value;
            return;
        }
    }
    fail_msg( "%s is not in the file", key );
}

static RfResult read_bytes( const char* bytes, size_t size, RfError* error )
{
    const char* path = cli_path( "damaged.exr" );
    RfImage image;
    cli_write( path, bytes, size );
    error->text[0] = 0;
    RfResult result = rf_read_exr( path, &image, error );
    if ( result != RF_OK )
    {
        assert_null( image.rgb );
        assert_non_null( strstr( error->text, "damaged.exr" ) );
    }
    else
        rf_destroy_image( &image );
    return result;
}

TEST( test_refused_compression )
{
    Layout layout = default_layout();
    size_t size;
    RfError error;
    AUTO_FREE char* bytes = cli_read( write_layout( &layout ), &size );
    patch( bytes, size, "compression\0compression", 24, 4, 8 );
    if ( !rf_has_dwa() )
    {
        assert_int_equal( read_bytes( bytes, size, &error ), RF_ERROR_UNSUPPORTED );
        assert_non_null( strstr( error.text, "its compression is DWA, which this build of reframe lacks" ) );
    }
}

TEST( test_deep_images_are_refused )
{
    Layout layout = default_layout();
    layout.compression = EXR_COMPRESSION_NONE;
    layout.storage = EXR_STORAGE_DEEP_SCANLINE;
    const char* path = cli_path( "deep.exr" );
    exr_context_t context = NULL;
    assert_int_equal( exr_start_write( &context, path, EXR_WRITE_FILE_DIRECTLY, NULL ), EXR_ERR_SUCCESS );
    define_part( context, &layout, 0 );
    assert_int_equal( exr_write_header( context ), EXR_ERR_SUCCESS );
    int32_t no_samples[64] = { 0 };
    for ( int y = layout.window.min.y; y <= layout.window.max.y; ++y )
        assert_int_equal( exr_write_deep_scanline_chunk( context, 0, y, "", 0, 0, no_samples, 37 * 4 ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_finish( &context ), EXR_ERR_SUCCESS );
    RfImage image;
    RfError error = { 0 };
    assert_int_equal( rf_read_exr( path, &image, &error ), RF_ERROR_UNSUPPORTED );
    assert_non_null( strstr( error.text, "deep" ) );
}

TEST( test_no_image_is_one_line )
{
    RfImage image;
    RfError error;
    assert_int_equal( rf_read_exr( cli_path( "none.exr" ), &image, &error ), RF_ERROR_IO );
    assert_int_equal( rf_read_exr( cli_folder(), &image, &error ), RF_ERROR_IO );
    assert_int_equal( read_bytes( "", 0, &error ), RF_ERROR_FORMAT );
    char garbage[4096];
    uint32_t seed = 1;
    for ( int round = 0; round < 20; ++round )
    {
        for ( size_t i = 0; i < sizeof garbage; ++i )
            garbage[i] = (char)next_random( &seed );
        if ( round % 2 == 1 )
            memcpy( garbage, "\x76\x2f\x31\x01\x02\0\0\0", 8 ); // the right beginning
        assert_int_equal( read_bytes( garbage, sizeof garbage, &error ), RF_ERROR_FORMAT );
    }
}

TEST( test_truncated_files_fail )
{
    for ( int c = 0; c < 5; ++c )
    {
        Layout layout = default_layout();
        layout.compression = (exr_compression_t)c;
        layout.storage = c % 2 == 0 ? EXR_STORAGE_SCANLINE : EXR_STORAGE_TILED;
        size_t size;
        RfError error;
        AUTO_FREE char* bytes = cli_read( write_layout( &layout ), &size );
        for ( size_t end = 0; end < size; end += 1 + size / 50 )
            assert_int_not_equal( read_bytes( bytes, end, &error ), RF_OK );
        assert_int_not_equal( read_bytes( bytes, size - 1, &error ), RF_OK );
    }
}

static void mutate( char* bytes, size_t size, uint32_t* seed )
{
    static const char special[] = { 0, 1, 0x7f, (char)0x80, (char)0xff };
    uint32_t count = 1 + next_random( seed ) % 4;
    for ( uint32_t i = 0; i < count; ++i )
    {
        // half of the damage to the header, where it hurts more
        size_t range = next_random( seed ) % 2 == 0 && size > 450 ? 450 : size;
        size_t at = next_random( seed ) % range;
        uint32_t kind = next_random( seed ) % 3;
        if ( kind == 0 )
            bytes[at] ^= (char)( 1 << next_random( seed ) % 8 );
        else if ( kind == 1 )
            bytes[at] = special[next_random( seed ) % sizeof special];
        else
            bytes[at] = (char)next_random( seed );
    }
}

// Any result will do; the sanitizers and the clock are the judges.
TEST( test_mutations_never_crash )
{
    const char* rounds_text = getenv( "REFRAME_FUZZ_ROUNDS" );
    int rounds = rounds_text != NULL ? atoi( rounds_text ) : 20;
    const char* seed_text = getenv( "REFRAME_FUZZ_SEED" );
    uint32_t seed = seed_text != NULL ? (uint32_t)atoi( seed_text ) : 12345;
    time_t start = time( NULL );
    int read = 0, all = 0;
    for ( int i = 0; i < 10; ++i )
    {
        Layout layout = default_layout();
        layout.compression = (exr_compression_t)( i % 5 );
        layout.storage = i < 5 ? EXR_STORAGE_SCANLINE : EXR_STORAGE_TILED;
        layout.type = i % 2 == 0 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
        size_t size;
        AUTO_FREE char* bytes = cli_read( write_layout( &layout ), &size );
        AUTO_FREE char* damaged = malloc( size );
        for ( int round = 0; round < rounds; ++round, ++all )
        {
            RfError error;
            memcpy( damaged, bytes, size );
            mutate( damaged, size, &seed );
            read += read_bytes( damaged, size, &error ) == RF_OK;
        }
    }
    print_message( "%d of %d damaged files read\n", read, all );
    assert_true( difftime( time( NULL ), start ) < 30.0 + 0.05 * all );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
