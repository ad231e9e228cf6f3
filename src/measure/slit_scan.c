#include "measure/slit_scan.h"

#include <string.h>

RfResult rf_create_slit_scan( int frames, int height, int parts, RfSlitScan* scan, RfError* error )
{
    *scan = ( RfSlitScan ){ .height = height };
    scan->repeat = frames > 0 && frames < RF_SLIT_WIDTH ? ( RF_SLIT_WIDTH - 1 ) / frames + 1 : 1;
    return rf_create_image( frames * scan->repeat, height * parts, &scan->image, error );
}

void rf_destroy_slit_scan( RfSlitScan* scan )
{
    rf_destroy_image( &scan->image );
    *scan = ( RfSlitScan ){ 0 };
}

void rf_add_slit( RfSlitScan* scan, int frame, int part, const RfImage* image, int column )
{
    size_t width = (size_t)scan->image.width;
    for ( int y = 0; y < scan->height; ++y )
    {
        const float* from = image->rgb + 3 * ( (size_t)y * (size_t)image->width + (size_t)column );
        size_t row = (size_t)part * (size_t)scan->height + (size_t)y;
        float* to = scan->image.rgb + 3 * ( row * width + (size_t)frame * (size_t)scan->repeat );
        for ( int i = 0; i < scan->repeat; ++i )
            memcpy( to + 3 * i, from, 3 * sizeof( float ) );
    }
}
