// Small images for the corpus of the fuzz targets, called by make-corpus.
//
//     make_fuzz_images FOLDER     which has png, jpeg, webp, exr and hdr
#include "support/image_files.h"

#include "reframe/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char* s_folder;

static const char* path_of( const char* name )
{
    static char path[4096];
    snprintf( path, sizeof path, "%s/%s", s_folder, name );
    return path;
}

static void save( const char* name, uint8_t* bytes, size_t size )
{
    FILE* file = fopen( path_of( name ), "wb" );
    if ( file == NULL || fwrite( bytes, 1, size, file ) != size || fclose( file ) != 0 )
        exit( 1 );
    free( bytes );
}

static void save_coded( void )
{
    uint8_t pixels[9 * 5 * 4];
    uint16_t wide[9 * 5 * 3];
    size_t size;
    char name[32];
    for ( size_t i = 0; i < sizeof pixels; ++i )
        pixels[i] = (uint8_t)( i * 37 + i / 7 * 11 );
    for ( size_t i = 0; i < sizeof wide / sizeof wide[0]; ++i )
        wide[i] = (uint16_t)( i * 9973 );
    for ( int channels = 1; channels <= 4; ++channels )
    {
        snprintf( name, sizeof name, "png/channels-%d.png", channels );
        uint8_t* bytes = encode_png( 9, 5, channels, pixels, &size );
        save( name, bytes, size );
    }
    uint8_t* bytes = encode_png16( 9, 5, 3, wide, &size );
    save( "png/wide.png", bytes, size );
    for ( int channels = 1; channels <= 4; channels += channels == 1 ? 2 : 1 )
    {
        snprintf( name, sizeof name, "jpeg/channels-%d.jpg", channels );
        bytes = encode_jpeg( 9, 5, channels, pixels, &size );
        save( name, bytes, size );
    }
#ifdef REFRAME_WEBP
    for ( int i = 0; i < 4; ++i )
    {
        int channels = 3 + i % 2;
        snprintf( name, sizeof name, "webp/%s-%d.webp", i < 2 ? "lossless" : "lossy", channels );
        bytes = encode_webp( 9, 5, channels, i >= 2, pixels, &size );
        save( name, bytes, size );
    }
#endif
    for ( size_t i = 3; i < sizeof pixels; i += 4 ) // the exponents: radiance about 1
        pixels[i] = (uint8_t)( 127 + i / 4 % 3 );
    bytes = encode_hdr( 9, 5, pixels, &size );
    save( "hdr/runs.hdr", bytes, size );
    bytes = encode_hdr( 4, 5, pixels, &size );
    save( "hdr/flat.hdr", bytes, size );
}

static void save_exr( const char* name, RfExrCompression compression, bool half )
{
    float rgb[8 * 6 * 3], depth[8 * 6];
    for ( int i = 0; i < 8 * 6 * 3; ++i )
        rgb[i] = (float)( i % 29 ) * 0.11f;
    for ( int i = 0; i < 8 * 6; ++i )
        depth[i] = 1.0f + (float)i;
    const RfExrChannel channel = { .name = "depth.Z", .values = depth, .stride = 1 };
    const RfExrString strings[] = { { "reframe/fingerprint", "0123456789abcdef" }, { "owner", "somebody" } };
    RfExrOptions options = rf_default_exr_options();
    options.compression = compression;
    options.half = half;
    options.fps_numerator = 24;
    options.fps_denominator = 1;
    options.channels = &channel;
    options.channel_count = 1;
    options.strings = strings;
    options.string_count = 2;
    const RfImage image = { 8, 6, rgb };
    RfError error;
    if ( rf_write_exr( path_of( name ), &image, &options, &error ) != RF_OK )
        exit( 1 );
}

int main( int argc, char** argv )
{
    if ( argc != 2 )
        return 2;
    s_folder = argv[1];
    save_coded();
    save_exr( "exr/none.exr", RF_EXR_NONE, true );
    save_exr( "exr/zip.exr", RF_EXR_ZIP, true );
    save_exr( "exr/piz.exr", RF_EXR_PIZ, false );
    const Foreign parts[] = {
        { { "B", "G", "R" }, { 1, 2, 3 }, 1, 2, 5, 4, true, "beauty" },
        { { "Z" }, { 7 }, 0, 0, 6, 3, false, "depth" },
    };
    write_foreign_exr( path_of( "exr/parts.exr" ), parts, 2 );
    return 0;
}
