// Size and time of a frame's file by each compression. Usage: bench_exr_write FRAME.exr, a frame of `render --float`, whose colours
// and normals are written as halves, as render does without it. Times are CPU seconds, the least of 3, reading back and comparing
// included.
#include "image/exr.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define OUT "bench_exr_write.tmp.exr"
#define REPEATS 3

typedef struct Frame
{
    RfExrHeader header;
    RfExrWindow window;
    float* values[RF_EXR_MAX_CHANNELS];
    RfExrChannel channels[RF_EXR_MAX_CHANNELS];
    int count; // without R, G, B
    RfImage image;
} Frame;

static bool begins( const char* text, const char* with ) { return strncmp( text, with, strlen( with ) ) == 0; }

static RfResult load( const char* path, Frame* frame, RfError* error )
{
    RfResult result = rf_read_exr( path, &frame->image, error );
    if ( result == RF_OK )
        result = rf_read_exr_header( path, NULL, &frame->header, error );
    for ( int c = 0; result == RF_OK && c < frame->header.channel_count; ++c )
    {
        const char* name = frame->header.channels[c].text;
        if ( strcmp( name, "R" ) == 0 || strcmp( name, "G" ) == 0 || strcmp( name, "B" ) == 0 )
            continue;
        result = rf_read_exr_channels( path, &name, 1, &frame->window, &frame->values[frame->count], error );
        bool colour = begins( name, "albedo" ) || begins( name, "light_" );
        frame->channels[frame->count] = ( RfExrChannel ){
            .name = name,
            .values = frame->values[frame->count],
            .stride = 1,
            .half = colour || begins( name, "normal" ) || strcmp( name, "A" ) == 0,
            .lossy = colour,
        };
        ++frame->count;
    }
    return result;
}

static long file_size( const char* path )
{
    FILE* file = fopen( path, "rb" );
    long size = file != NULL && fseek( file, 0, SEEK_END ) == 0 ? ftell( file ) : -1;
    if ( file != NULL )
        fclose( file );
    return size;
}

static double seconds( void ) { return (double)clock() / CLOCKS_PER_SEC; }

// The relMSE of what was read back.
static double error_of( const RfImage* image )
{
    RfImage back;
    if ( rf_read_exr( OUT, &back, NULL ) != RF_OK )
        return NAN;
    double sum = 0.0;
    size_t count = (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < 3 * count; ++i )
    {
        double value = (double)image->rgb[i], error = (double)back.rgb[i] - value;
        sum += error * error / ( value * value + 1e-2 );
    }
    rf_destroy_image( &back );
    return sum / (double)count;
}

static RfResult measure( const Frame* frame, RfExrCompression compression, float level, RfError* error )
{
    RfExrOptions options = rf_default_exr_options();
    options.compression = compression;
    options.dwa_level = level;
    options.channels = frame->channels;
    options.channel_count = frame->count;
    double written = INFINITY, read = INFINITY;
    RfResult result = RF_OK;
    for ( int i = 0; i < REPEATS && result == RF_OK; ++i )
    {
        RfImage back;
        double start = seconds();
        result = rf_write_exr( OUT, &frame->image, &options, error );
        written = fmin( written, seconds() - start );
        start = seconds();
        if ( result == RF_OK && rf_read_exr( OUT, &back, error ) == RF_OK )
            rf_destroy_image( &back );
        read = fmin( read, seconds() - start );
    }
    if ( result != RF_OK )
        return result;
    double all = (double)file_size( OUT );
    options.channel_count = 0;
    result = rf_write_exr( OUT, &frame->image, &options, error );
    if ( result != RF_OK )
        return result;
    char name[32];
    snprintf( name, sizeof name, level > 0.0f ? "%s:%g" : "%s", rf_compression_words[compression], (double)level );
    printf( "| `%s` | %.1f | %.1f | %.2f | %.2f | %.0e |\n", name, all / 1e6, (double)file_size( OUT ) / 1e6, written, read,
            error_of( &frame->image ) );
    return RF_OK;
}

int main( int argc, char** argv )
{
    static const struct
    {
        RfExrCompression compression;
        float level;
    } ways[] = {
        { RF_EXR_NONE, 0.0f },  { RF_EXR_ZIPS, 0.0f },  { RF_EXR_ZIP, 0.0f },    { RF_EXR_PIZ, 0.0f },
        { RF_EXR_DWAA, 15.0f }, { RF_EXR_DWAA, 45.0f }, { RF_EXR_DWAA, 150.0f }, { RF_EXR_DWAB, 45.0f },
    };
    static Frame frame;
    RfError error;
    RfResult result =
        argc == 2 ? load( argv[1], &frame, &error ) : rf_fail( &error, RF_ERROR_USAGE, "usage: bench_exr_write FRAME.exr" );
    printf( "| compression | MB | R, G, B alone | write, s | read R, G, B, s | relMSE |\n|---|---|---|---|---|---|\n" );
    for ( size_t i = 0; result == RF_OK && i < sizeof ways / sizeof ways[0]; ++i )
        result = measure( &frame, ways[i].compression, ways[i].level, &error );
    remove( OUT );
    if ( result != RF_OK )
        fprintf( stderr, "bench_exr_write: %s\n", error.text );
    return result != RF_OK;
}
