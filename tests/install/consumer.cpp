// consumer.c as a C++ program would have it: consumer_cpp SCENE FOLDER writes the same files.
#include <reframe/reframe.h>

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{
struct Failure : std::runtime_error
{
    explicit Failure( const RfError& error )
        : std::runtime_error( std::string( rf_result_name( error.code ) ) + ": " + error.text )
    {
    }
};

// Turns a result into an exception.
void check( RfResult result, const RfError& error )
{
    if ( result != RF_OK )
        throw Failure( error );
}

struct Closer
{
    void operator()( RfScene* scene ) const { rf_close_scene( scene ); }
    void operator()( RfTracer* tracer ) const { rf_destroy_tracer( tracer ); }
};

class Path
{
  public:
    Path( const RfScene& scene, RfFps fps, int width, int height )
    {
        RfError error{};
        RfPathOptions options{};
        options.fps = fps;
        options.width = width;
        options.height = height;
        check( rf_create_camera_path( &scene, &options, &m_path, &error ), error );
    }
    ~Path() { rf_destroy_camera_path( &m_path ); }
    Path( const Path& ) = delete;
    Path& operator=( const Path& ) = delete;
    const RfCameraPath& operator*() const { return m_path; }

  private:
    RfCameraPath m_path = rf_empty_camera_path();
};

using Scene = std::unique_ptr<RfScene, Closer>;
using Tracer = std::unique_ptr<RfTracer, Closer>;

Scene open_scene( const char* name )
{
    RfError error{};
    RfScene* scene = nullptr;
    check( rf_open_scene( name, &scene, nullptr, &error ), error );
    return Scene( scene );
}

Tracer create_tracer( const RfScene& scene )
{
    RfError error{};
    RfTracer* tracer = nullptr;
    check( rf_create_tracer( &scene, &tracer, &error ), error );
    return Tracer( tracer );
}

void render( const RfTracer& tracer, const RfCameraPath& path, const std::vector<int>& frames, const RfRenderSettings& asked,
             const std::string& pattern )
{
    RfError error{};
    RfOutput output = rf_default_output();
    output.pattern = pattern.c_str();
    output.tracer = &tracer;
    output.path = &path;
    const RfShot shot = { &tracer, path.eyes, path.count, frames.data(), static_cast<int>( frames.size() ) };
    check( rf_resolve_settings( &shot, &asked, &output.settings, &error ), error );
    char effects[RF_EFFECTS_TEXT_SIZE];
    rf_name_effects( &shot, &output.settings, effects );
    output.calls_for = effects;
    check( rf_prepare_output_folder( output.pattern, &error ), error );
    RfRenderCallbacks callbacks = {};
    callbacks.user = &output;
    callbacks.frame = []( void* user, const RfFrameResult* frame, RfError* failure )
    { return rf_write_frame( static_cast<const RfOutput*>( user ), frame, failure ); };
    check( rf_render( &shot, &output.settings, &callbacks, nullptr, &error ), error );
}

void compare( const std::string& one, const std::string& two )
{
    RfError error{};
    RfErrorMetrics metrics{};
    check( rf_measure_sequences( one.c_str(), two.c_str(), &metrics, &error ), error );
    std::printf( "relMSE %.3g\n", metrics.relmse );
    if ( !( metrics.relmse > 0.0 ) )
        throw std::runtime_error( "two seeds gave the same pictures" );
}

void run( const char* name, const std::string& folder )
{
    const Scene scene = open_scene( name );
    const Tracer tracer = create_tracer( *scene );
    const Path path( *scene, RfFps{ 24, 1 }, 48, 27 );
    const std::vector<int> frames = { 3, 4, 5 };
    RfError error{};
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = rf_default_filter( settings.estimator );
    settings.spp = 6;
    settings.group = 1;
    settings.tile = RfTile{ RF_TILE_BLOCK, 2, 2 };
    settings.files = rf_default_frame_files();
    settings.queue = 1;
    check( rf_parse_aovs( "albedo,depth,motion", &settings.aovs, &error ), error );

    const RfShot shot = { tracer.get(), ( *path ).eyes, ( *path ).count, frames.data(), 3 };
    RfPlan plan{};
    check( rf_plan_render( &shot, &settings, &plan, &error ), error );
    for ( int i = 0; i < plan.count; ++i )
        std::printf( "plan: group %d, gain %.2f\n", plan.rows[i].group, plan.rows[i].gain );

    render( *tracer, *path, frames, settings, folder + "/one.####.exr" );
    settings.seed = 2;
    render( *tracer, *path, frames, settings, folder + "/two.####.exr" );
    compare( folder + "/one.####.exr", folder + "/two.####.exr" );
}
} // namespace

int main( int argc, char** argv )
{
    try
    {
        if ( argc != 3 )
            throw std::runtime_error( "usage: consumer_cpp SCENE FOLDER" );
        try
        {
            open_scene( "there-is-no-such-scene.glb" );
            throw std::logic_error( "a scene that is not there was opened" );
        }
        catch ( const Failure& failure )
        {
            std::printf( "as expected: %s\n", failure.what() );
        }
        run( argv[1], argv[2] );
    }
    catch ( const std::exception& failure )
    {
        std::fprintf( stderr, "%s\n", failure.what() );
        return 1;
    }
    return 0;
}
