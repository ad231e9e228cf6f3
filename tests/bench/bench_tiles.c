// What tile reuse with N-rooks patterns gains for indirect light, in
// the manner of figure 6 of the path-reuse paper: mean squared error at equal
// samples, and time, with and without.
// Usage: bench_tiles [--light-samples K] [--spp S] SCENE.glb
//
// Indirect light is what a whole render has beyond one that stops at the second
// vertex: with the same seed both draw the same paths, so their difference is
// free of the noise of direct light. Plain path tracing of many samples and
// another seed is the reference. CPU time of one thread, interleaved repeats.
#include "support/render_support.h"
#include "scene/camera.h"
#include "scene/json/scene_file.h"
#include "reuse/tile/tile.h"
#include "trace/trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define WIDTH 256
#define HEIGHT 192
#define REPEATS 3
#define REFERENCE_TIMES 128 // as many samples

typedef struct Bench
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eye;
    RfRenderSettings settings;
    double* reference; // of the indirect light
} Bench;

typedef struct Figures
{
    double mse, seconds;
    double path_length, tests; // per path: rays beyond the first, tile segments
} Figures;

static double cpu_seconds( void )
{
    struct timespec time;
    clock_gettime( CLOCK_PROCESS_CPUTIME_ID, &time );
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static Rendered render( const Bench* b, const char* tile, int spp, int depth, uint64_t seed )
{
    RfRenderSettings settings = b->settings;
    settings.spp = spp;
    settings.max_depth = depth;
    settings.seed = seed;
    if ( !rf_parse_tile( tile, &settings.tile ) )
        abort();
    int frame = 0;
    return render_frames( b->tracer, &b->eye, 1, &frame, 1, &settings );
}

static double mean_of_channels( const Rendered* r, size_t pixel )
{
    const float* p = r->rgb + 3 * pixel;
    return (double)( p[0] + p[1] + p[2] ) / 3.0;
}

static void make_reference( Bench* b )
{
    int spp = b->settings.spp * REFERENCE_TIMES;
    b->settings.threads = 0;
    Rendered all = render( b, "4x4", spp, b->settings.max_depth, 90001 ), direct = render( b, "4x4", spp, 2, 90001 );
    b->settings.threads = 1;
    b->reference = malloc( all.pixels * sizeof *b->reference );
    if ( b->reference == NULL )
        abort();
    for ( size_t i = 0; i < all.pixels; ++i )
        b->reference[i] = mean_of_channels( &all, i ) - mean_of_channels( &direct, i );
    free_rendered( &all );
    free_rendered( &direct );
}

static Figures measure( const Bench* b, const char* tile, uint64_t seed )
{
    Rendered direct = render( b, tile, b->settings.spp, 2, seed );
    double start = cpu_seconds();
    Rendered all = render( b, tile, b->settings.spp, b->settings.max_depth, seed );
    Figures f = { .seconds = cpu_seconds() - start };
    for ( size_t i = 0; i < all.pixels; ++i )
    {
        double e = mean_of_channels( &all, i ) - mean_of_channels( &direct, i ) - b->reference[i];
        f.mse += e * e / (double)all.pixels;
    }
    double paths = (double)all.stats.rays.primary;
    f.path_length = (double)( all.stats.rays.path + all.stats.rays.primary ) / paths;
    f.tests = (double)all.stats.rays.tile / paths;
    free_rendered( &direct );
    free_rendered( &all );
    return f;
}

static int compare_doubles( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

// Means of the errors, medians of the times.
static Figures summary( const Figures* runs, int step )
{
    Figures f = runs[0];
    double seconds[REPEATS], mse = 0.0;
    for ( int k = 0; k < REPEATS; ++k )
    {
        seconds[k] = runs[k * step].seconds;
        mse += runs[k * step].mse / REPEATS;
    }
    qsort( seconds, REPEATS, sizeof *seconds, compare_doubles );
    f.seconds = seconds[REPEATS / 2];
    f.mse = mse;
    return f;
}

static RfResult load( Bench* b, const char* path, RfError* error )
{
    RfLog log = { 0 };
    int camera;
    RfResult result = rf_load_scene( path, &b->scene, &log, error );
    if ( result == RF_OK )
        result = rf_find_camera( &b->scene, NULL, &camera, error );
    if ( result == RF_OK )
        result = rf_camera_eye( &b->scene, b->scene.cameras + camera, 24.0, 24, 1, WIDTH, HEIGHT, &b->eye, error );
    return result;
}

// Paper: Bekaert, Sbert, Halton 2002, figure 6 and section 4, N = 16: error down by 9 in the
// indirect part; 83 % more time where it was worst, 15 % with many light samples.
static void print_row( const char* tile, int n, int k, const Figures* plain, const Figures* f )
{
    double factor = plain->mse / f->mse, more = f->seconds / plain->seconds - 1.0;
    // section 3.6: rays of N paths alone, over those with the connections, for m effective combinations
    double rays = plain->path_length * ( k + 1 );
    double predicted_more = ( n - 1 ) / rays, best = n / ( 1.0 + predicted_more ), predicted = factor / ( 1.0 + predicted_more );
    printf( "%-8s %10.4g %8.2f %7.0f %% %8.2f %11.0f %% %9.2f %9.2f %8.2f   %s\n", tile, f->mse, factor, 100.0 * more,
            factor / ( 1.0 + more ), 100.0 * predicted_more, predicted, best, f->tests,
            n == 16 ? "factor 9, 15 to 83 % more time" : "-" );
}

static void run( const Bench* b )
{
    static const char* const tiles[] = { "1", "rooks4", "rooks9", "rooks16", "rooks36" };
    enum
    {
        TILES = sizeof tiles / sizeof tiles[0]
    };
    Figures runs[REPEATS][TILES];
    for ( int k = 0; k < REPEATS; ++k )
    {
        for ( int t = 0; t < TILES; ++t )
            runs[k][t] = measure( b, tiles[t], (uint64_t)( 1 + k ) );
    }
    Figures plain = summary( &runs[0][0], TILES );
    printf( "%d samples a pixel, %d light samples a vertex, %.2f rays a path, %.2f us a path\n", b->settings.spp,
            b->settings.light_samples, plain.path_length, plain.seconds * 1e6 / ( (double)b->settings.spp * WIDTH * HEIGHT ) );
    printf( "%-8s %10s %8s %9s %8s %13s %9s %9s %8s   %s\n", "tile", "MSE", "factor", "time", "gain", "time (rays)", "predicted",
            "if m = N", "tests", "paper" );
    for ( int t = 0; t < TILES; ++t )
    {
        RfTile tile;
        Figures f = summary( &runs[0][t], TILES );
        if ( rf_parse_tile( tiles[t], &tile ) )
            print_row( tiles[t], rf_tile_pixels( &tile ), b->settings.light_samples, &plain, &f );
    }
}

int main( int argc, char** argv )
{
    Bench b = { .settings = plain_settings() };
    b.settings.group = 0;
    b.settings.spp = 8;
    int first = 1;
    for ( ; first + 1 < argc && argv[first][0] == '-'; first += 2 )
    {
        int* value = strcmp( argv[first], "--spp" ) == 0 ? &b.settings.spp : &b.settings.light_samples;
        *value = atoi( argv[first + 1] );
    }
    RfError error = { 0 };
    rf_set_float_mode();
    if ( first + 1 != argc )
        fprintf( stderr, "usage: bench_tiles [--light-samples K] [--spp S] SCENE.glb\n" );
    else if ( load( &b, argv[first], &error ) != RF_OK )
        fprintf( stderr, "bench_tiles: %s\n", error.text );
    else
    {
        b.tracer = make_tracer( &b.scene );
        make_reference( &b );
        run( &b );
        return 0;
    }
    return 2;
}
