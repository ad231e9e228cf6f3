#include "reframe/image.h"

#include <stdint.h>
#include <stdlib.h>

RfResult rf_create_image( int width, int height, RfImage* image, RfError* error )
{
    *image = ( RfImage ){ 0 };
    if ( width < 1 || height < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "an image of %dx%d pixels is not possible: width and height must be at least 1",
                        width, height );
    size_t pixels = (size_t)width * (size_t)height;
    float* rgb = pixels <= SIZE_MAX / ( 3 * sizeof( float ) ) ? calloc( pixels, 3 * sizeof( float ) ) : NULL;
    if ( rgb == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "an image of %dx%d pixels: the system has no %.1f MiB left", width, height,
                        12.0 * (double)pixels / 1048576.0 );
    *image = ( RfImage ){ .width = width, .height = height, .rgb = rgb };
    return RF_OK;
}

void rf_destroy_image( RfImage* image )
{
    if ( image == NULL )
        return;
    free( image->rgb );
    *image = ( RfImage ){ 0 };
}
