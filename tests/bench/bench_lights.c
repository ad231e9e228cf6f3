// Light sampling by the tree against light sampling by power: CPU time per path on
// one thread, and the efficiency 1 / (relMSE · time) against a reference.
// Usage: bench_lights [--quick] [SCENE.glb]. Without a scene: halls of 10 to
// 10,000 lamps of the same total power.
#include "base/random.h"
#include "light/light.h"
#include "measure/image_error.h"
#include "scene/camera.h"
#include "scene_file/scene_file.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "trace/trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define WIDTH 96
#define HEIGHT 54
#define REPEATS 5
#define BLOCK 1024
#define PICKS ( 1024 * BLOCK )

static double cpu_seconds( void )
{
    struct timespec time;
    clock_gettime( CLOCK_PROCESS_CPUTIME_ID, &time );
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int compare_doubles( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

static double median( double* values, int count )
{
    qsort( values, (size_t)count, sizeof *values, compare_doubles );
    return values[count / 2];
}

// A hall of 40 × 30 m with cupboards, and lamps of one power in all that hang
// below its ceiling, in rows.
static RfScene make_hall( int lamps )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.6f, 0.6f, 0.55f ) ),
             plastic = add_material( &b, make_plastic( 0.5f, 0.3f ) );
    int columns = (int)ceil( sqrt( lamps * 4.0 / 3.0 ) ), rows = ( lamps + columns - 1 ) / columns;
    float side = 0.35f * rf_minf( 40.0f / (float)columns, 30.0f / (float)rows );
    uint32_t lamp = add_material( &b, make_light( 3000.0f / ( (float)lamps * side * side ), false ) );
    add_box( &b, grey, rf_vec3( -20, 0, -15 ), rf_vec3( 20, 3.5f, 15 ), true );
    for ( int i = 0; i < 120; ++i )
    {
        RfRandomKey key = rf_pixel_key( 5, (uint32_t)i );
        float x = 39.0f * rf_random( key, 0 ) - 20.0f, z = 29.0f * rf_random( key, 1 ) - 15.0f;
        add_box( &b, plastic, rf_vec3( x, 0, z ), rf_vec3( x + 0.9f, 0.5f + 1.5f * rf_random( key, 2 ), z + 0.6f ), false );
    }
    for ( int i = 0; i < lamps; ++i )
    {
        float x = -20.0f + 40.0f * ( (float)( i % columns ) + 0.5f ) / (float)columns;
        float z = -15.0f + 30.0f * ( (float)( i / columns ) + 0.5f ) / (float)rows;
        float y = 3.2f - 0.3f * (float)( i % 2 ), h = 0.5f * side;
        add_quad( &b, lamp, rf_vec3( x - h, y, z - h ), rf_vec3( x + h, y, z - h ), rf_vec3( x + h, y, z + h ),
                  rf_vec3( x - h, y, z + h ) );
    }
    return finish_scene( &b );
}

typedef struct Subject
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eye;
} Subject;

static Rendered render( const Subject* subject, RfLightSampling picking, int spp, uint64_t seed, int threads )
{
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = spp;
    settings.seed = seed;
    settings.threads = threads;
    settings.max_depth = 6;
    settings.light_sampling = picking;
    return render_all( subject->tracer, &subject->eye, 1, &settings );
}

static double error_of( const Rendered* image, const Rendered* reference )
{
    RfImage a = { .width = WIDTH, .height = HEIGHT, .rgb = image->rgb },
            r = { .width = WIDTH, .height = HEIGHT, .rgb = reference->rgb };
    RfErrorMetrics metrics;
    RfError error;
    return rf_measure_error( &a, &r, &metrics, &error ) == RF_OK ? metrics.relmse : NAN;
}

// Nanoseconds per pick, and per question for the chance of a light, at random
// places that are in groups near each other.
static void time_picks( const Subject* subject, double* pick, double* chance )
{
    const RfLights* lights = rf_tracer_lights( subject->tracer );
    const RfTriangles* t = &subject->scene.triangles;
    static float s_x[3][BLOCK], s_n[3][BLOCK];
    static uint32_t s_bits[2][BLOCK];
    static RfLightSelection s_pick[BLOCK];
    const float *x[3] = { s_x[0], s_x[1], s_x[2] }, *n[3] = { s_n[0], s_n[1], s_n[2] };
    const uint32_t* bits[2] = { s_bits[0], s_bits[1] };
    double sum = 0.0, seconds[2] = { 0 };
    for ( uint32_t block = 0; block < PICKS / BLOCK; ++block )
    {
        RfRandomKey key = rf_pixel_key( 3, block );
        uint32_t v = (uint32_t)( rf_random( key, 0 ) * (float)t->vertex_count );
        for ( uint32_t i = 0; i < BLOCK; ++i )
        {
            for ( uint32_t c = 0; c < 3; ++c )
            {
                s_x[c][i] = t->positions[3 * v + c] + rf_random( key, 8 + 3 * i + c );
                s_n[c][i] = t->normals[3 * v + c];
            }
            s_bits[0][i] = rf_random_bits( key, 4000 + 2 * i );
            s_bits[1][i] = rf_random_bits( key, 4001 + 2 * i );
        }
        double start = cpu_seconds();
        rf_select_lights( lights, RF_LIGHTS_BY_TREE, BLOCK, x, n, bits, s_pick );
        double middle = cpu_seconds();
        for ( int i = 0; i < BLOCK; ++i )
            sum += (double)rf_light_probability( lights, RF_LIGHTS_BY_TREE, s_pick[i].light == RF_NO_LIGHT ? 0 : s_pick[i].light,
                                                 rf_vec3( s_x[0][i], s_x[1][i], s_x[2][i] ),
                                                 rf_vec3( s_n[0][i], s_n[1][i], s_n[2][i] ) );
        seconds[0] += middle - start;
        seconds[1] += cpu_seconds() - middle;
    }
    *pick = seconds[0] * 1e9 / PICKS;
    *chance = seconds[1] * 1e9 / PICKS;
    if ( sum == 1e30 )
        printf( "\n" ); // the sum is used
}

static void measure( const char* name, const Subject* subject, int reference_spp )
{
    static const RfLightSampling s_ways[] = { RF_LIGHTS_BY_TREE, RF_LIGHTS_BY_POWER };
    enum
    {
        SPP = 16
    };
    double seconds[2][REPEATS], errors[2] = { 0 }, time[2], pick = 0.0, chance = 0.0;
    Rendered reference = render( subject, RF_LIGHTS_BY_TREE, reference_spp, 1000, 2 );
    for ( int k = 0; k < REPEATS; ++k )
    {
        for ( int way = 0; way < 2; ++way )
        {
            double start = cpu_seconds();
            Rendered image = render( subject, s_ways[way], SPP, (uint64_t)( 1 + k ), 1 );
            seconds[way][k] = cpu_seconds() - start;
            errors[way] += error_of( &image, &reference ) / REPEATS;
            free_rendered( &image );
        }
    }
    for ( int way = 0; way < 2; ++way )
        time[way] = median( seconds[way], REPEATS ) * 1e6 / ( SPP * WIDTH * HEIGHT );
    time_picks( subject, &pick, &chance );
    printf( "%-12s %7u %8.0f %8.0f %9.2f %9.2f %10.4g %10.4g %12.2f\n", name, rf_tracer_lights( subject->tracer )->count, pick,
            chance, time[0], time[1], errors[0], errors[1], errors[1] * time[1] / ( errors[0] * time[0] ) );
    fflush( stdout );
    free_rendered( &reference );
}

static int measure_file( const char* path, int reference_spp )
{
    Subject subject;
    RfLog log = { 0 };
    RfError error;
    int camera;
    RfResult result = rf_load_scene( path, &subject.scene, &log, &error );
    if ( result == RF_OK )
        result = rf_find_camera( &subject.scene, NULL, &camera, &error );
    if ( result == RF_OK )
        result = rf_camera_eye(
            &( RfCameraSampling ){ &subject.scene, subject.scene.cameras + camera, NULL, { 24, 1 }, WIDTH, HEIGHT }, 24.0,
            &subject.eye, &error );
    if ( result != RF_OK )
    {
        fprintf( stderr, "bench_lights: %s\n", error.text );
        return 1;
    }
    subject.tracer = make_tracer( &subject.scene );
    measure( "scene", &subject, reference_spp );
    rf_destroy_tracer( subject.tracer );
    rf_destroy_scene( &subject.scene );
    return 0;
}

int main( int argc, char** argv )
{
    bool quick = argc > 1 && strcmp( argv[1], "--quick" ) == 0;
    int first = quick ? 2 : 1, reference_spp = quick ? 128 : 1024;
    rf_set_float_mode();
    printf( "%-12s %7s %8s %8s %9s %9s %10s %10s %12s\n", "", "lights", "pick ns", "chance", "tree µs", "power µs", "tree err",
            "power err", "tree/power" );
    if ( argc > first )
        return measure_file( argv[first], reference_spp );
    for ( int lamps = 10; lamps <= 10000; lamps *= 10 )
    {
        Subject subject = { .scene = make_hall( lamps ) };
        subject.tracer = make_tracer( &subject.scene );
        subject.eye =
            rf_make_eye( rf_vec3( -14.0f, 1.7f, 9.0f ), rf_vec3( 1.0f, -0.55f, -0.5f ), rf_vec3( 0, 1, 0 ), 0.7, WIDTH, HEIGHT );
        char name[32];
        snprintf( name, sizeof name, "%d lamps", lamps );
        measure( name, &subject, reference_spp );
        rf_destroy_tracer( subject.tracer );
        rf_destroy_scene( &subject.scene );
    }
    return 0;
}
