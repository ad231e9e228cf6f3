// What the tests of images share: a temporary folder, images to write, files
// to look into. Included by each test once; not all use all of it.
#ifndef REFRAME_TEST_IMAGE_SUPPORT_H
#define REFRAME_TEST_IMAGE_SUPPORT_H

#include "support/test.h"
#include "image/exr.h"

#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define UNUSED_OK __attribute__( ( unused ) )

static char temp_folder[64];

static UNUSED_OK int make_temp_folder( void** state )
{
    (void)state;
    strcpy( temp_folder, "/tmp/reframe-test-XXXXXX" );
    return mkdtemp( temp_folder ) == NULL;
}

// A path in the folder, good until the eighth call after.
static UNUSED_OK const char* temp_path( const char* name )
{
    static char paths[8][320];
    static int next;
    char* path = paths[next++ % 8];
    snprintf( path, sizeof paths[0], "%s/%s", temp_folder, name );
    return path;
}

// Removes the files if asked to; counts them, hidden ones too.
static int walk_files( int do_remove )
{
    DIR* folder = opendir( temp_folder );
    assert_non_null( folder );
    int count = 0;
    for ( const struct dirent* entry = readdir( folder ); entry != NULL; entry = readdir( folder ) )
    {
        if ( strcmp( entry->d_name, "." ) == 0 || strcmp( entry->d_name, ".." ) == 0 )
            continue;
        count += 1;
        if ( do_remove )
            remove( temp_path( entry->d_name ) );
    }
    closedir( folder );
    return count;
}

static UNUSED_OK int count_files( void ) { return walk_files( 0 ); }

static UNUSED_OK int remove_temp_folder( void** state )
{
    (void)state;
    walk_files( 1 );
    return rmdir( temp_folder );
}

static UNUSED_OK uint32_t next_random( uint32_t* seed )
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return *seed;
}

// Noise with a smooth part, signs and six orders of magnitude.
static UNUSED_OK RfImage make_image( int width, int height, uint32_t seed )
{
    RfImage image;
    RfError error;
    assert_int_equal( rf_create_image( width, height, &image, &error ), RF_OK );
    for ( int i = 0; i < 3 * width * height; ++i )
    {
        float noise = (float)( next_random( &seed ) >> 8 ) * 0x1p-24f;
        image.rgb[i] = ( i % 7 == 0 ? -1.0f : 1.0f ) * noise * noise * noise * ( i % 11 == 0 ? 3000.0f : 1.0f );
    }
    return image;
}

static UNUSED_OK size_t image_bytes( const RfImage* image )
{
    return 3 * sizeof( float ) * (size_t)image->width * (size_t)image->height;
}

static UNUSED_OK RfImage write_and_read( const char* name, const RfImage* image, const RfExrOptions* options )
{
    RfError error = { 0 };
    RfImage back = { 0 };
    if ( rf_write_exr( temp_path( name ), image, options, &error ) != RF_OK ||
         rf_read_exr( temp_path( name ), &back, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return back;
}

static UNUSED_OK char* load_file( const char* path, size_t* size )
{
    FILE* file = fopen( path, "rb" );
    assert_non_null( file );
    fseek( file, 0, SEEK_END );
    *size = (size_t)ftell( file );
    rewind( file );
    char* bytes = malloc( *size + 1 );
    assert_non_null( bytes );
    assert_int_equal( fread( bytes, 1, *size, file ), *size );
    fclose( file );
    return bytes;
}

static UNUSED_OK void save_file( const char* path, const char* bytes, size_t size )
{
    FILE* file = fopen( path, "wb" );
    assert_non_null( file );
    assert_int_equal( fwrite( bytes, 1, size, file ), size );
    fclose( file );
}

#endif
