// What is made of the options of `reframe render`.
#include "cli/options/render_options.h"

#include "cli/options/effect_options.h"
#include "cli/options/file_options.h"
#include "cli/options/render_table.h"
#include "output/names.h"

#include <math.h>
#include <string.h>

#define WRITE_QUEUE 2                  // frames: one being written, one waiting
#define MOST_SPP_FOR_NOISE ( 1 << 16 ) // noise that has not come down by then will not

int rf_default_most_spp( double noise ) { return isgreater( noise, 0.0 ) ? MOST_SPP_FOR_NOISE : RF_MAX_SPP; }

static bool ends_with( const char* text, const char* end )
{
    size_t length = strlen( text ), end_length = strlen( end );
    return length > end_length && strcmp( text + length - end_length, end ) == 0;
}

static RfResult check( const RfRenderOptions* options, RfError* error )
{
    if ( options->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "-o is missing: say where the frames go, such as -o out/frame.####.exr" );
    if ( !ends_with( options->output, ".exr" ) )
        return rf_fail( error, RF_ERROR_USAGE, "--output: wants a name that ends in .exr, got '%s'", options->output );
    if ( rf_render_parse.is_half_given && rf_render_parse.is_float_given &&
         options->settings.files.half == rf_render_parse.is_float )
        return rf_fail( error, RF_ERROR_USAGE, "--half and --float: only one of the two" );
    return RF_OK;
}

RfRenderOptions rf_default_render_options( void )
{
    RfRenderOptions options = { .settings = rf_default_render_settings() };
    options.estimator = rf_estimator_name( options.settings.estimator );
    options.settings.files = rf_default_frame_files();
    options.settings.queue = WRITE_QUEUE;
    options.weights = options.settings.weights;
    options.normalize = options.settings.normalize;
    options.adaptive = options.settings.adaptive;
    options.reconstruction = options.settings.reconstruction;
    options.light_paths = options.settings.light_paths;
    options.kernel_normalization = options.settings.kernel_normalization;
    options.filter = -1;
    return options;
}

static void reset( void )
{
    rf_render_parse.options = rf_default_render_options();
    rf_render_parse.is_float = rf_render_parse.is_float_given = rf_render_parse.is_half_given = false;
    rf_render_parse.compression = rf_render_parse.options.settings.files.compression;
}

static void take_words( RfRenderOptions* options )
{
    options->settings.weights = (RfWeights)options->weights;
    options->settings.normalize = (RfNormalize)options->normalize;
    options->settings.adaptive = (RfAdaptive)options->adaptive;
    options->settings.reconstruction = (RfReconstruction)options->reconstruction;
    options->settings.light_paths = (RfLightPathsUse)options->light_paths;
    options->settings.kernel_normalization = (RfKernelNormalization)options->kernel_normalization;
}

void rf_settle_filter( RfRenderOptions* options )
{
    bool given = options->filter >= 0;
    options->settings.filter = given ? (RfFilter)options->filter : rf_default_filter( options->settings.estimator );
}

RfResult rf_parse_estimator_option( RfRenderOptions* options, RfError* error )
{
    const RfEstimator* estimator = rf_find_estimator( options->estimator );
    if ( estimator == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--estimator: wants reuse or gradient, got '%s'", options->estimator );
    options->settings.estimator = estimator;
    options->settings.tile = rf_default_tile( estimator );
    return RF_OK;
}

RfResult rf_parse_tile_option( RfRenderOptions* options, RfError* error )
{
    if ( options->tile == NULL )
        return RF_OK;
    if ( rf_parse_tile( options->tile, &options->settings.tile ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE,
                    "--tile: wants 1, WxH such as 3x3, or rooksN such as rooks16, of at most %d pixels, got '%s'",
                    RF_MAX_TILE_PIXELS, options->tile );
}

RfResult rf_parse_aov_option( RfRenderOptions* options, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_parse_aovs( options->aov, &options->settings.aovs, &reason );
    options->settings.aovs |= options->alpha ? RF_AOV_BIT( RF_AOV_ALPHA ) : 0u;
    return result == RF_OK ? result : rf_fail( error, result, "--aov: %.1000s", reason.text );
}

RfResult rf_settle_render_options( RfRenderOptions* options, RfError* error )
{
    RfRenderSettings* settings = &options->settings;
    take_words( options );
    if ( settings->adaptive == RF_ADAPTIVE_ON && settings->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "--adaptive: wants --weights exact, not %s",
                        rf_weights_name( settings->weights ) );
    RfResult result = rf_parse_estimator_option( options, error );
    if ( result == RF_OK )
        rf_settle_filter( options );
    if ( result == RF_OK && strcmp( options->estimator, "gradient" ) != 0 &&
         options->reconstruction != RF_RECONSTRUCTION_WEIGHTED )
        return rf_fail( error, RF_ERROR_USAGE, "--reconstruction: wants --estimator gradient" );
    if ( result == RF_OK )
        result = rf_parse_tile_option( options, error );
    if ( result == RF_OK )
        result = rf_parse_aov_option( options, error );
    if ( result == RF_OK )
        result = rf_parse_effect_options( options, error );
    if ( ( settings->noise > 0.0 || settings->time > 0.0 ) && !options->spp_given )
        settings->spp = rf_default_most_spp( settings->noise );
    return result;
}

// Parses on top of the current values.
static RfResult parse( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &rf_render_table, argc, argv, &rf_render_parse.options.scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    result = check( &rf_render_parse.options, error );
    rf_render_parse.options.settings.files.compression = (RfExrCompression)rf_render_parse.compression;
    if ( rf_render_parse.is_float_given )
        rf_render_parse.options.settings.files.half = !rf_render_parse.is_float;
    *options = rf_render_parse.options;
    return result == RF_OK ? rf_settle_render_options( options, error ) : result;
}

RfResult rf_parse_render_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    reset();
    return parse( argc, argv, options, help, error );
}

RfResult rf_read_render_defaults( const RfField* defaults, RfRenderOptions* options )
{
    reset();
    RfError error = { 0 };
    RfField tile = rf_field_member( defaults, "tile" ), aov = rf_field_member( defaults, "aov" ),
            no_effect = rf_field_member( defaults, "no_effect" );
    RfField estimator = rf_field_member( defaults, "estimator" );
    RfResult result = rf_take_file_options( &rf_render_table, defaults );
    if ( result == RF_OK && rf_parse_estimator_option( &rf_render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &estimator, &error );
    if ( result == RF_OK && rf_parse_tile_option( &rf_render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &tile, &error );
    if ( result == RF_OK && rf_parse_aov_option( &rf_render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &aov, &error );
    if ( result == RF_OK && rf_parse_effect_options( &rf_render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &no_effect, &error );
    take_words( &rf_render_parse.options );
    *options = rf_render_parse.options;
    return result;
}

RfResult rf_read_reuse_defaults( const RfField* defaults, RfRenderOptions* options )
{
    RfError error = { 0 };
    RfField estimator = rf_field_member( defaults, "estimator" );
    RfResult result = rf_read_render_defaults( defaults, options );
    if ( result != RF_OK || options->settings.estimator == rf_default_render_settings().estimator )
        return result;
    rf_fail( &error, RF_ERROR_USAGE, "--estimator: plan, tune and cost know the estimator reuse only" );
    return rf_fail_file_option( &estimator, &error );
}

RfResult rf_parse_render_options_over( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, RfError* error )
{
    bool help;
    RfResult result = rf_read_render_defaults( defaults, options );
    return result == RF_OK ? parse( argc, argv, options, &help, error ) : result;
}

void rf_print_render_help( void ) { rf_print_help( &rf_render_table, stdout ); }
