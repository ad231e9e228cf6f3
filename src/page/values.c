#include "page/values.h"

#include "image/half.h"
#include "page/picture.h"

#include <math.h>
#include <stdlib.h>

static int divide_up( int a, int b ) { return ( a + b - 1 ) / b; }

double rf_values_page_bytes( int width, int height, int factor )
{
    double bytes = RF_VALUES_HEADER_BYTES + 6.0 * divide_up( width, factor ) * divide_up( height, factor );
    return 4.0 * ceil( bytes / 3.0 );
}

int rf_values_factor( int width, int height, double most )
{
    for ( int factor = 1; factor <= RF_VALUES_MAX_FACTOR; ++factor )
    {
        if ( rf_values_page_bytes( width, height, factor ) <= most )
            return factor;
    }
    return 0;
}

static unsigned char* put16( unsigned char* out, unsigned int value )
{
    out[0] = (unsigned char)( value & 255u );
    out[1] = (unsigned char)( value >> 8 & 255u );
    return out + 2;
}

RfResult rf_encode_values( const RfImage* image, int factor, const char* name, unsigned char** bytes, size_t* size,
                           RfError* error )
{
    *bytes = NULL;
    *size = 0;
    RfImage small = { 0 };
    RfResult result = factor > 1 ? rf_shrink_image( image, factor, &small, error ) : RF_OK;
    if ( result != RF_OK )
        return result;
    const RfImage* from = factor > 1 ? &small : image;
    size_t count = 3 * (size_t)from->width * (size_t)from->height;
    *bytes = malloc( RF_VALUES_HEADER_BYTES + 2 * count );
    if ( *bytes != NULL )
    {
        unsigned char* out = put16( *bytes, (unsigned int)factor );
        out = put16( put16( out, (unsigned int)from->width ), (unsigned int)from->height );
        for ( size_t i = 0; i < count; ++i )
            out = put16( out, rf_float_to_half( rf_clamp_half( from->rgb[i] ) ) );
        *size = (size_t)( out - *bytes );
    }
    else
        result = rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for its values", name );
    rf_destroy_image( &small );
    return result;
}
