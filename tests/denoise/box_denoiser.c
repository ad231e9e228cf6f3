// A library with the functions of Open Image Denoise that we call, for tests: the mean over 5x5 pixels. With FAKE_OIDN=old it is of
// version 1.4, with fail it fails.
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define API __attribute__( ( visibility( "default" ) ) )
#define REACH 2

typedef struct Filter
{
    const float* colour;
    float* output;
    int width, height;
} Filter;

static const char* s_error;
static int s_device;

static bool is_asked( const char* what )
{
    const char* text = getenv( "FAKE_OIDN" );
    return text != NULL && strcmp( text, what ) == 0;
}

API void* oidnNewDevice( int type ) { return type == 1 ? &s_device : NULL; }
API void oidnSetDeviceInt( void* device, const char* name, int value ) { (void)device, (void)name, (void)value; }
API void oidnSetDeviceBool( void* device, const char* name, bool value ) { (void)device, (void)name, (void)value; }
API int oidnGetDeviceInt( void* device, const char* name ) { return (void)device, (void)name, is_asked( "old" ) ? 10403 : 20000; }
API void oidnCommitDevice( void* device ) { (void)device; }
API void oidnReleaseDevice( void* device ) { (void)device; }

API int oidnGetDeviceError( void* device, const char** message )
{
    int code = s_error != NULL;
    (void)device;
    *message = s_error;
    s_error = NULL;
    return code;
}

API void* oidnNewFilter( void* device, const char* type ) { return (void)device, (void)type, calloc( 1, sizeof( Filter ) ); }
API void oidnSetFilterBool( void* filter, const char* name, bool value ) { (void)filter, (void)name, (void)value; }
API void oidnSetFilterInt( void* filter, const char* name, int value ) { (void)filter, (void)name, (void)value; }
API void oidnSetFilterFloat( void* filter, const char* name, float value ) { (void)filter, (void)name, (void)value; }
API void oidnCommitFilter( void* filter ) { (void)filter; }
API void oidnReleaseFilter( void* filter ) { free( filter ); }

API void oidnSetSharedFilterImage( void* filter, const char* name, void* pixels, int format, size_t width, size_t height,
                                   size_t offset, size_t pixel_stride, size_t row_stride )
{
    Filter* f = filter;
    (void)format, (void)offset, (void)pixel_stride, (void)row_stride;
    f->width = (int)width;
    f->height = (int)height;
    if ( strcmp( name, "color" ) == 0 )
        f->colour = pixels;
    if ( strcmp( name, "output" ) == 0 )
        f->output = pixels;
}

static int within( int place, int size ) { return place < 0 ? 0 : place < size ? place : size - 1; }

API void oidnExecuteFilter( void* filter )
{
    const Filter* f = filter;
    s_error = is_asked( "fail" ) ? "it has no memory" : NULL;
    for ( int i = 0; i < 3 * f->width * f->height; ++i )
    {
        int x = i / 3 % f->width, y = i / 3 / f->width;
        float sum = 0.0f;
        for ( int k = 0; k < ( 2 * REACH + 1 ) * ( 2 * REACH + 1 ); ++k )
        {
            int px = within( x + k % ( 2 * REACH + 1 ) - REACH, f->width ),
                py = within( y + k / ( 2 * REACH + 1 ) - REACH, f->height );
            sum += f->colour[3 * ( py * f->width + px ) + i % 3];
        }
        f->output[i] = sum / (float)( ( 2 * REACH + 1 ) * ( 2 * REACH + 1 ) );
    }
}
