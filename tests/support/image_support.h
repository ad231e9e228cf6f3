// What the tests of images share: images to write into the folder of cli_run.h. Included by each test once; not all use all of it.
#ifndef REFRAME_TEST_IMAGE_SUPPORT_H
#define REFRAME_TEST_IMAGE_SUPPORT_H

#include "image/exr.h"
#include "support/cli_run.h"
#include "support/test.h"

#define UNUSED_OK __attribute__( ( unused ) )

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
    if ( rf_write_exr( cli_path( name ), image, options, &error ) != RF_OK ||
         rf_read_exr( cli_path( name ), &back, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return back;
}

#endif
