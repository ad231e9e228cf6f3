// A program that uses the library, of C and (consumer.cpp) of C++:
//   consumer SCENE FOLDER
// renders three frames of the scene's first camera twice, with two seeds, to FOLDER/one.####.exr
// and FOLDER/two.####.exr, compares the two sequences, and prints the plan, the measures and an error.
#include <reframe/reframe.h>

#include <stdio.h>
#include <string.h>

#define WIDTH 48
#define HEIGHT 27
#define FRAMES 3

static void print_warning( void* user, const char* line ) { fprintf( stderr, "%s: %s\n", (const char*)user, line ); }

static RfResult write_frame( void* user, const RfFrameResult* frame, RfError* error )
{
    const RfOutput* output = (const RfOutput*)user;
    printf( "frame %d: %.4g samples per pixel\n", frame->frame + 1, frame->effective_spp );
    return rf_write_frame( output, frame, error );
}

// A second look at progress->share would tell how far it is; 1 goes on.
static bool go_on( void* user, const RfProgress* progress )
{
    (void)user;
    return progress->frames_done <= progress->frames_all;
}

static RfResult print_scene( const RfScene* scene, RfError* error )
{
    RfSceneInfo info;
    RfCameraInfo camera;
    RfEffect effects[RF_MAX_EFFECTS];
    RfFps fps = { 24, 1 };
    RfResult result = rf_scene_info( scene, &info, error );
    if ( result == RF_OK )
        result = rf_scene_camera( scene, 0, fps, &camera, error );
    if ( result != RF_OK )
        return result;
    printf( "%u triangles, %u materials, %u lights, camera %s of %d frames\n", info.triangles, info.materials, info.lights,
            camera.name, camera.frames );
    int count = rf_list_effects( scene, effects );
    for ( int i = 0; i < count; ++i )
    {
        if ( effects[i].on )
            printf( "effect %s: %s\n", effects[i].name, effects[i].why );
    }
    return RF_OK;
}

static RfResult print_plan( const RfTracer* tracer, const RfCameraPath* path, const int* frames, const RfRenderSettings* settings,
                            RfError* error )
{
    RfShot shot = { tracer, path->eyes, path->count, frames, FRAMES };
    RfPlan plan;
    RfResult result = rf_plan_render( &shot, settings, &plan, error );
    for ( int i = 0; result == RF_OK && i < plan.count; ++i )
        printf( "%cplan: group %d, gain %.2f, %zu bytes\n", plan.rows[i].chosen ? '*' : ' ', plan.rows[i].group,
                plan.rows[i].gain, plan.rows[i].fit.bytes_films + plan.rows[i].fit.bytes_hits + plan.rows[i].fit.bytes_lists );
    return result;
}

static RfResult render( const RfTracer* tracer, const RfCameraPath* path, const int* frames, RfRenderSettings asked,
                        const char* pattern, RfError* error )
{
    RfOutput output = rf_default_output();
    RfShot shot = { tracer, path->eyes, path->count, frames, FRAMES };
    RfRenderStats stats;
    char effects[RF_EFFECTS_TEXT_SIZE];
    RfRenderCallbacks callbacks = { .user = &output, .frame = write_frame, .progress = go_on };
    output.pattern = pattern;
    output.tracer = tracer;
    output.path = path;
    output.calls_for = effects;
    RfResult result = rf_resolve_settings( &shot, &asked, &output.settings, error );
    if ( result == RF_OK )
        result = rf_prepare_output_folder( pattern, error );
    if ( result == RF_OK )
        rf_name_effects( &shot, &output.settings, effects );
    if ( result == RF_OK )
        result = rf_render( &shot, &output.settings, &callbacks, &stats, error );
    for ( int i = 0; result == RF_OK && i < FRAMES; ++i )
    {
        RfFrameFileState state;
        result = rf_check_frame_file( &output, frames[i], &state, error );
        if ( result == RF_OK && state != RF_FRAME_FILE_SAME )
            result = rf_fail( error, RF_ERROR_IO, "%s: frame %d is not what was rendered", pattern, frames[i] + 1 );
    }
    if ( result == RF_OK )
        printf( "%s: group %d, %llu camera rays\n", pattern, stats.group, (unsigned long long)stats.rays.primary );
    return result;
}

static RfResult compare( const char* one, const char* two, RfError* error )
{
    RfErrorMetrics metrics;
    RfFlickerMetrics flicker;
    RfResult result = rf_measure_sequences( one, two, &metrics, error );
    if ( result == RF_OK )
        result = rf_measure_sequence_flicker( one, two, &flicker, error );
    if ( result == RF_OK )
        printf( "relMSE %.3g, bias %.3g, flicker %.3g\n", metrics.relmse, metrics.bias, flicker.f1 );
    if ( result == RF_OK && !( metrics.relmse > 0.0 && flicker.phi > 0.0 ) )
        result = rf_fail( error, RF_ERROR_FORMAT, "two seeds gave the same pictures" );
    return result;
}

static RfResult run( const RfScene* scene, RfTracer** tracer, RfCameraPath* path, const char* folder, RfError* error )
{
    const int frames[FRAMES] = { 3, 4, 5 };
    char one[1024], two[1024], tile[RF_TILE_NAME_SIZE];
    RfPathOptions options = { .fps = { 24, 1 }, .width = WIDTH, .height = HEIGHT };
    RfRenderSettings settings = rf_default_render_settings();
    snprintf( one, sizeof one, "%s/one.####.exr", folder );
    snprintf( two, sizeof two, "%s/two.####.exr", folder );
    settings.spp = 6;
    settings.group = 1;
    settings.files = rf_default_frame_files();
    settings.queue = 1;
    RfResult result = rf_parse_aovs( "albedo,depth,motion", &settings.aovs, error );
    if ( result == RF_OK && !rf_parse_tile( "2x2", &settings.tile ) )
        result = rf_fail( error, RF_ERROR_USAGE, "2x2 should be a tile" );
    rf_tile_name( &settings.tile, tile );
    printf( "tile %s, weights %s\n", tile, rf_weights_name( settings.weights ) );
    if ( result == RF_OK )
        result = rf_create_camera_path( scene, &options, path, error );
    if ( result == RF_OK )
        result = rf_create_tracer( scene, tracer, error );
    if ( result == RF_OK )
        result = print_plan( *tracer, path, frames, &settings, error );
    if ( result == RF_OK )
        result = render( *tracer, path, frames, settings, one, error );
    settings.seed = 2;
    if ( result == RF_OK )
        result = render( *tracer, path, frames, settings, two, error );
    return result == RF_OK ? compare( one, two, error ) : result;
}

// What cannot be done says why, and what would help.
static RfResult print_failure( const RfTracer* tracer, const RfCameraPath* path, RfError* error )
{
    RfError expected;
    RfRenderSettings settings = rf_default_render_settings(), resolved;
    RfMemoryFit fit;
    settings.group = 0;
    settings.memory = 100000;
    RfShot shot = { tracer, path->eyes, path->count, NULL, FRAMES };
    RfResult result = rf_resolve_settings( &shot, &settings, &resolved, error );
    if ( result != RF_OK )
        return result;
    result = rf_fit_memory( &shot, &resolved, &fit, &expected );
    printf( "%s: %s; %zu bytes are enough\n", rf_result_name( result ), expected.text, expected.least_memory );
    if ( result == RF_ERROR_MEMORY && expected.remedy == RF_REMEDY_MEMORY && expected.least_memory > settings.memory )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE, "a budget of 100,000 bytes should be too small" );
}

// Two pixels of 1 and 3 whose difference is said to be 4.
static RfResult reconstruct( RfError* error )
{
    const float primal[6] = { 1.0f, 1.0f, 1.0f, 3.0f, 3.0f, 3.0f }, dx[6] = { 4.0f, 4.0f, 4.0f }, dy[6] = { 0.0f };
    const RfGradientImages in = { 2, 1, primal, dx, dy };
    float rgb[6];
    RfReconstructOptions options = rf_default_reconstruct_options();
    options.alpha = 1.0f;
    RfResult result = rf_reconstruct( &in, NULL, &options, rgb, NULL, error );
    if ( result == RF_OK && ( rgb[0] < 0.3333f || rgb[0] > 0.3334f ) )
        return rf_fail( error, RF_ERROR_USAGE, "reconstructed %g instead of a third", (double)rgb[0] );
    return result;
}

int main( int argc, char** argv )
{
    RfScene* scene = NULL;
    RfTracer* tracer = NULL;
    RfCameraPath path = rf_empty_camera_path();
    RfError error;
    RfLog log = { print_warning, argv[0], 0 };
    RfResult result;
    if ( argc != 3 )
        result = rf_fail( &error, RF_ERROR_USAGE, "usage: consumer SCENE FOLDER" );
    else
        result = rf_open_scene( argv[1], &scene, &log, &error );
    if ( result == RF_OK )
        result = print_scene( scene, &error );
    if ( result == RF_OK )
        result = run( scene, &tracer, &path, argv[2], &error );
    if ( result == RF_OK )
        result = print_failure( tracer, &path, &error );
    if ( result == RF_OK )
        result = reconstruct( &error );
    if ( result != RF_OK )
        fprintf( stderr, "reframe %s: %s\n", rf_version(), error.text );
    rf_destroy_tracer( tracer );
    rf_destroy_camera_path( &path );
    rf_close_scene( scene );
    return result == RF_OK ? 0 : 1;
}
