// Renders one frame by bidirectional path tracing on one thread, as a baseline for scripts/compare-kernels.
// Usage: bench_bidirectional SCENE.glb OUT.pfm FRAME WIDTH HEIGHT SPP SEED MAX_DEPTH
// Prints the CPU seconds, loading included. A PFM file holds floats, the lowest row first.
#include "scene/camera.h"
#include "scene/json/scene_file.h"
#include "support/bidirectional.h"
#include "support/render_support.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static int write_pfm( const char* path, int width, int height, const float* rgb )
{
    FILE* file = fopen( path, "wb" );
    if ( file == NULL )
        return 1;
    fprintf( file, "PF\n%d %d\n-1.0\n", width, height );
    size_t row = 3 * (size_t)width, written = 0;
    for ( int y = height - 1; y >= 0; --y )
        written += fwrite( rgb + row * (size_t)y, sizeof *rgb, row, file );
    return fclose( file ) != 0 || written != row * (size_t)height;
}

static int run( char** argv )
{
    RfScene scene;
    RfError error = { 0 };
    RfLog log = { 0 };
    RfEye eye;
    int camera, first, step, width = atoi( argv[4] ), height = atoi( argv[5] );
    bool loaded =
        rf_load_scene( argv[1], &scene, &log, &error ) == RF_OK && rf_find_camera( &scene, NULL, &camera, &error ) == RF_OK;
    if ( loaded )
    {
        rf_camera_numbers( scene.cameras + camera, &first, &step );
        double frame = (double)( atoi( argv[3] ) - first ) / step;
        loaded = rf_camera_eye( &scene, scene.cameras + camera, frame, 24, 1, width, height, &eye, &error ) == RF_OK;
    }
    if ( !loaded )
    {
        fprintf( stderr, "bench_bidirectional: %s\n", error.text );
        return 2;
    }
    RfTracer* tracer = make_tracer( &scene );
    const char* lacks = bidirectional_lacks( tracer, &eye );
    if ( lacks != NULL )
    {
        fprintf( stderr, "bench_bidirectional: %s: has %s\n", argv[1], lacks );
        return 2;
    }
    BidirectionalSettings settings = { .spp = atoi( argv[6] ),
                                       .seed = strtoull( argv[7], NULL, 10 ),
                                       .max_depth = atoi( argv[8] ) };
    float* rgb = malloc( 3 * (size_t)width * (size_t)height * sizeof *rgb );
    if ( rgb == NULL )
        abort();
    bidirectional_image( tracer, &eye, &settings, rgb );
    struct timespec time;
    clock_gettime( CLOCK_PROCESS_CPUTIME_ID, &time );
    printf( "%.3f\n", (double)time.tv_sec + 1e-9 * (double)time.tv_nsec );
    int failed = write_pfm( argv[2], width, height, rgb );
    free( rgb );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
    return failed;
}

int main( int argc, char** argv )
{
    rf_set_float_mode();
    if ( argc == 9 )
        return run( argv );
    fprintf( stderr, "usage: bench_bidirectional SCENE.glb OUT.pfm FRAME WIDTH HEIGHT SPP SEED MAX_DEPTH\n" );
    return 2;
}
