// Encodes HDR pictures for the page: a coarse base of brightness, and the detail over it as a JPEG.
#include "page/picture.h"

#include "base/try.h"
#include "image/decode.h"
#include "image/half.h"
#include "image/encode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LEVELS 1024
#define NOWHERE 1e9f // depths from here on are of nothing

int rf_look_channels( RfLook look )
{
    bool one = look == RF_LOOK_DEPTH || look == RF_LOOK_SHARE || look == RF_LOOK_INDEX;
    return one ? 1 : look == RF_LOOK_MOTION || look == RF_LOOK_MATTES ? 2 : 3;
}

static void include( RfLookRange* range, float value )
{
    range->low = fminf( range->low, value );
    range->high = fmaxf( range->high, value );
}

RfLookRange rf_look_range( RfLook look, const float* values, size_t stride, size_t pixels )
{
    RfLookRange range = { INFINITY, look == RF_LOOK_DEPTH ? 0.0f : 1e-6f };
    double squares = 0.0;
    size_t count = 0;
    for ( size_t i = 0; i < pixels; ++i )
    {
        const float* v = values + stride * i;
        if ( look == RF_LOOK_DEPTH && v[0] > 0.0f && v[0] < NOWHERE )
            include( &range, v[0] );
        else if ( look == RF_LOOK_MOTION && isfinite( v[0] ) && isfinite( v[1] ) )
            include( &range, fmaxf( fabsf( v[0] ), fabsf( v[1] ) ) );
        else if ( look == RF_LOOK_SHARE && isfinite( v[0] ) )
            include( &range, v[0] );
        for ( int c = 0; look == RF_LOOK_SIGNED && c < 3; ++c )
        {
            squares += isfinite( v[c] ) ? (double)v[c] * (double)v[c] : 0.0;
            count += isfinite( v[c] ) && v[c] != 0.0f;
        }
    }
    if ( count > 0 ) // a few large values shall not make all others grey
        include( &range, (float)( 3.0 * sqrt( squares / (double)count ) ) );
    if ( !( range.low < range.high ) )
        range.low = 0.5f * range.high;
    return range;
}

// Light that the sRGB curve turns into each display level.
static void fill_light( float light[LEVELS + 1] )
{
    for ( int i = 0; i <= LEVELS; ++i )
        light[i] = rf_srgb_to_linear( (float)i / LEVELS );
}

// NaN is kept, so that it shows.
static float display( const float light[LEVELS + 1], float level )
{
    return isnan( level ) ? level : light[(int)( LEVELS * fminf( fmaxf( level, 0.0f ), 1.0f ) + 0.5f )];
}

// Spreads small numbers over all bits, 0 to 0: the last steps of MurmurHash3 (Appleby, public domain).
static uint32_t mix_bits( uint32_t bits )
{
    bits = ( bits ^ bits >> 16 ) * 0x85ebca6bu;
    bits = ( bits ^ bits >> 13 ) * 0xc2b2ae35u;
    return bits ^ bits >> 16;
}

// A colour that tells ids apart: hue, saturation and brightness by different bits; 0 is black.
static void color_of( uint32_t bits, const float* light, float out[3] )
{
    float hue = (float)( bits >> 16 ) / 65536.0f * 6.0f,
          value = bits != 0 ? 0.55f + 0.45f * (float)( bits & 255u ) / 255.0f : 0.0f;
    float pale = 0.5f * (float)( bits >> 8 & 255u ) / 255.0f;
    for ( int c = 0; c < 3; ++c )
    {
        float away = fabsf( fmodf( hue + ( c == 0 ? 0.0f : c == 1 ? 4.0f : 2.0f ), 6.0f ) - 3.0f ); // from the opposite hue
        float pure = fminf( fmaxf( away - 1.0f, 0.0f ), 1.0f );
        out[c] = display( light, value * ( pale + ( 1.0f - pale ) * pure ) );
    }
}

static void draw_mattes( const float* v, int pairs, const float* light, float out[3] )
{
    out[0] = out[1] = out[2] = 0.0f;
    for ( int i = 0; i < pairs; ++i )
    {
        uint32_t bits;
        float color[3];
        memcpy( &bits, v + 2 * i, sizeof bits );
        color_of( bits, light, color );
        for ( int c = 0; c < 3; ++c )
            out[c] += v[2 * i + 1] != 0.0f ? color[c] * v[2 * i + 1] : 0.0f;
    }
}

static void draw_pixel( RfLook look, RfLookRange range, const float* v, const float* light, float out[3] )
{
    float level = 0.0f, scale = 0.5f / range.high;
    switch ( look )
    {
        case RF_LOOK_LIGHT:
        case RF_LOOK_DEVIATION:
            for ( int c = 0; c < 3; ++c )
                out[c] = look == RF_LOOK_LIGHT ? v[c] : sqrtf( fmaxf( v[c], 0.0f ) );
            return;
        case RF_LOOK_NORMAL:
        {
            float offset = v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f ? 0.0f : 0.5f;
            for ( int c = 0; c < 3; ++c )
                out[c] = display( light, offset + 0.5f * v[c] );
            return;
        }
        case RF_LOOK_MOTION:
            out[0] = display( light, 0.5f + scale * v[0] );
            out[1] = display( light, 0.5f + scale * v[1] );
            out[2] = display( light, 0.5f );
            return;
        case RF_LOOK_DEPTH:
            if ( v[0] > 0.0f && v[0] < NOWHERE )
                level = 0.1f + 0.9f * ( 1.0f - logf( v[0] / range.low ) / logf( range.high / range.low ) );
            break;
        case RF_LOOK_SHARE: level = v[0] / range.high; break;
        case RF_LOOK_SIGNED:
            for ( int c = 0; c < 3; ++c )
                out[c] = display( light, 0.5f + scale * v[c] );
            return;
        case RF_LOOK_INDEX: color_of( fabsf( v[0] ) < 1e9f ? mix_bits( (uint32_t)llrintf( v[0] ) ) : 0, light, out ); return;
        case RF_LOOK_MATTES: draw_mattes( v, 1, light, out ); return;
    }
    out[0] = out[1] = out[2] = display( light, level );
}

void rf_draw_look( RfLook look, RfLookRange range, const float* values, size_t stride, size_t pixels, float* rgb )
{
    float light[LEVELS + 1];
    fill_light( light );
    for ( size_t i = 0; i < pixels; ++i )
        draw_pixel( look, range, values + stride * i, light, rgb + 3 * i );
}

void rf_draw_mattes( const float* values, int pairs, size_t stride, size_t pixels, float* rgb )
{
    float light[LEVELS + 1];
    fill_light( light );
    for ( size_t i = 0; i < pixels; ++i )
        draw_mattes( values + stride * i, pairs, light, rgb + 3 * i );
}

#define FLOOR ( 1.0f / 512.0f )
#define STOP 256 // units per stop
#define BRIGHTEST 65504.0f
#define HEADER_BYTES 6

typedef struct Base
{
    int columns, rows;
    int16_t* values; // 3 per cell
} Base;

// Clamps to the range that is encoded, 0 to BRIGHTEST; a pixel with a NaN becomes magenta.
static void take_pixel( const float* from, float out[3] )
{
    bool is_nan = isnan( from[0] ) || isnan( from[1] ) || isnan( from[2] );
    for ( int c = 0; c < 3; ++c )
    {
        float value = is_nan ? ( c == 1 ? 0.0f : 16.0f ) : from[c];
        out[c] = FLOOR + fminf( fmaxf( value, 0.0f ), BRIGHTEST );
    }
}

static int16_t to_units( float light ) { return (int16_t)lrintf( STOP * log2f( light ) ); }

static void measure_cell( const RfImage* image, int column, int row, int16_t out[3] )
{
    int x_end = ( column + 1 ) * RF_PICTURE_CELL, y_end = ( row + 1 ) * RF_PICTURE_CELL;
    x_end = x_end < image->width ? x_end : image->width;
    y_end = y_end < image->height ? y_end : image->height;
    float sums[3] = { 0.0f, 0.0f, 0.0f }, pixel[3];
    int count = 0;
    for ( int y = row * RF_PICTURE_CELL; y < y_end; ++y )
    {
        for ( int x = column * RF_PICTURE_CELL; x < x_end; ++x, ++count )
        {
            take_pixel( image->rgb + 3 * ( (size_t)y * (size_t)image->width + (size_t)x ), pixel );
            for ( int c = 0; c < 3; ++c )
                sums[c] += sqrtf( pixel[c] );
        }
    }
    for ( int c = 0; c < 3; ++c )
    {
        float mean = sums[c] / (float)count;
        out[c] = to_units( mean * mean );
    }
}

// The two cells whose centres enclose pixel `x`, and the weight of the second in 1/32: cell
// centres are between pixels.
static void place( int x, int count, int cells[2], int* share )
{
    int units = 2 * x + 1 - RF_PICTURE_CELL; // distance in half pixels from the first centre
    int cell = units < 0 ? -1 : units / ( 2 * RF_PICTURE_CELL );
    *share = units - cell * 2 * RF_PICTURE_CELL;
    cells[0] = cell < 0 ? 0 : cell < count ? cell : count - 1;
    cells[1] = cell + 1 < count ? cell + 1 : count - 1;
}

static int mix( int a, int b, int share )
{
    return a * ( 2 * RF_PICTURE_CELL - share ) + b * share; // in 1/32 units
}

// Code table: the byte for each number of units above the base, −LIMIT to LIMIT.
#define LIMIT ( 32 * STOP )

static void fill_codes( unsigned char codes[2 * LIMIT + 1] )
{
    for ( int units = -LIMIT; units <= LIMIT; ++units )
    {
        double steps = rint( 32.0 * log( 1.0 + 2.0 * abs( units ) / STOP ) );
        steps = steps < 127.0 ? steps : 127.0;
        codes[units + LIMIT] = (unsigned char)( 128.0 + ( units < 0 ? -steps : steps ) );
    }
}

static void encode_row( const RfImage* image, const Base* base, int y, const unsigned char* codes, unsigned char* out )
{
    int rows[2], down;
    place( y, base->rows, rows, &down );
    const int16_t* upper = base->values + 3 * rows[0] * base->columns;
    const int16_t* lower = base->values + 3 * rows[1] * base->columns;
    const float* from = image->rgb + 3 * (size_t)y * (size_t)image->width;
    for ( int x = 0; x < image->width; ++x )
    {
        int cells[2], across;
        float pixel[3];
        place( x, base->columns, cells, &across );
        take_pixel( from + 3 * x, pixel );
        for ( int c = 0; c < 3; ++c )
        {
            int left = mix( upper[3 * cells[0] + c], lower[3 * cells[0] + c], down );
            int right = mix( upper[3 * cells[1] + c], lower[3 * cells[1] + c], down );
            int level = mix( left, right, across ); // 1/1024 units
            int units = to_units( pixel[c] ) - ( level + 512 >= 0 ? ( level + 512 ) / 1024 : -( ( 511 - level ) / 1024 ) );
            units = units < -LIMIT ? -LIMIT : units > LIMIT ? LIMIT : units;
            out[3 * x + c] = codes[units + LIMIT];
        }
    }
}

static RfResult measure_base( const RfImage* image, const char* name, Base* base, RfError* error )
{
    base->columns = ( image->width + RF_PICTURE_CELL - 1 ) / RF_PICTURE_CELL;
    base->rows = ( image->height + RF_PICTURE_CELL - 1 ) / RF_PICTURE_CELL;
    base->values = malloc( 3 * (size_t)base->columns * (size_t)base->rows * sizeof( int16_t ) );
    if ( base->values == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its picture", name );
    for ( int row = 0; row < base->rows; ++row )
    {
        for ( int column = 0; column < base->columns; ++column )
            measure_cell( image, column, row, base->values + 3 * ( row * base->columns + column ) );
    }
    return RF_OK;
}

static unsigned char* put16( unsigned char* out, int value )
{
    out[0] = (unsigned char)( (unsigned int)value & 255u );
    out[1] = (unsigned char)( (unsigned int)value >> 8 & 255u );
    return out + 2;
}

static RfResult concatenate( const Base* base, const unsigned char* jpeg, size_t jpeg_size, const char* name,
                             unsigned char** bytes, size_t* size, RfError* error )
{
    size_t count = 3 * (size_t)base->columns * (size_t)base->rows;
    *size = HEADER_BYTES + 2 * count + jpeg_size;
    *bytes = malloc( *size );
    if ( *bytes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its picture", name );
    unsigned char* out = put16( put16( put16( *bytes, RF_PICTURE_CELL ), base->columns ), base->rows );
    for ( size_t i = 0; i < count; ++i )
        out = put16( out, base->values[i] );
    memcpy( out, jpeg, jpeg_size );
    return RF_OK;
}

// Noisy images need more bits: lowers the quality until the size is small enough.
static RfResult encode_detail( const unsigned char* codes, const RfImage* image, double most_bits, const char* name,
                               unsigned char** jpeg, size_t* size, RfError* error )
{
    static const int qualities[] = { RF_PICTURE_QUALITY, 82, 72, 60, 45, 30, 18, 10, 5 };
    const int count = (int)( sizeof qualities / sizeof qualities[0] );
    double most = 1000.0 + (double)image->width * image->height * most_bits / 8.0;
    RfResult result = RF_OK;
    *jpeg = NULL;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        free( *jpeg );
        result = rf_encode_jpeg( codes, image->width, image->height, qualities[i], name, jpeg, size, error );
        if ( result == RF_OK && (double)*size <= most )
            break;
    }
    return result;
}

RfResult rf_encode_picture( const RfImage* image, double most_bits, const char* name, unsigned char** bytes, size_t* size,
                            RfError* error )
{
    *bytes = NULL;
    *size = 0;
    if ( image->width < 1 || image->height < 1 || image->width > RF_JPEG_MAX_SIDE || image->height > RF_JPEG_MAX_SIDE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: an image of %dx%d pixels cannot be encoded", name, image->width,
                        image->height );
    Base base = { 0 };
    size_t jpeg_size, pixels = (size_t)image->width * (size_t)image->height;
    unsigned char* jpeg = NULL;
    unsigned char* codes = malloc( 3 * pixels + 2 * LIMIT + 1 ); // the image, followed by the code table
    RfResult result = codes != NULL ? measure_base( image, name, &base, error )
                                    : rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its picture", name );
    if ( result == RF_OK )
    {
        fill_codes( codes + 3 * pixels );
        for ( int y = 0; y < image->height; ++y )
            encode_row( image, &base, y, codes + 3 * pixels, codes + 3 * (size_t)y * (size_t)image->width );
        result = encode_detail( codes, image, most_bits, name, &jpeg, &jpeg_size, error );
    }
    if ( result == RF_OK )
        result = concatenate( &base, jpeg, jpeg_size, name, bytes, size, error );
    free( jpeg );
    free( codes );
    free( base.values );
    return result;
}

RfResult rf_shrink_image( const RfImage* image, int factor, RfImage* small, RfError* error )
{
    RfResult result =
        rf_create_image( ( image->width + factor - 1 ) / factor, ( image->height + factor - 1 ) / factor, small, error );
    if ( result != RF_OK )
        return result;
    for ( int y = 0; y < small->height; ++y )
    {
        for ( int x = 0; x < small->width; ++x )
        {
            double sums[3] = { 0.0, 0.0, 0.0 };
            int count = 0;
            for ( int v = y * factor; v < ( y + 1 ) * factor && v < image->height; ++v )
            {
                for ( int u = x * factor; u < ( x + 1 ) * factor && u < image->width; ++u, ++count )
                {
                    for ( int c = 0; c < 3; ++c )
                        sums[c] += (double)image->rgb[3 * ( (size_t)v * (size_t)image->width + (size_t)u ) + (size_t)c];
                }
            }
            for ( int c = 0; c < 3; ++c )
                small->rgb[3 * ( (size_t)y * (size_t)small->width + (size_t)x ) + (size_t)c] = (float)( sums[c] / count );
        }
    }
    return RF_OK;
}

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

RfResult rf_encode_values( const RfImage* image, int factor, const char* name, unsigned char** bytes, size_t* size,
                           RfError* error )
{
    *bytes = NULL;
    *size = 0;
    RfImage small = { 0 };
    RF_TRY( factor > 1 ? rf_shrink_image( image, factor, &small, error ) : RF_OK );
    const RfImage* from = factor > 1 ? &small : image;
    size_t count = 3 * (size_t)from->width * (size_t)from->height;
    *bytes = malloc( RF_VALUES_HEADER_BYTES + 2 * count );
    RfResult result = RF_OK;
    if ( *bytes != NULL )
    {
        unsigned char* out = put16( *bytes, factor );
        out = put16( put16( out, from->width ), from->height );
        for ( size_t i = 0; i < count; ++i )
            out = put16( out, rf_float_to_half( rf_clamp_half( from->rgb[i] ) ) );
        *size = (size_t)( out - *bytes );
    }
    else
        result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its values", name );
    rf_destroy_image( &small );
    return result;
}
