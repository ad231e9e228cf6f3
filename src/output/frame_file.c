// A finished frame as an EXR file.
#include "reframe/output.h"

#include "output/frame_aovs.h"
#include "output/frame_difference.h"
#include "scene/eye.h"
#include "scene/scene.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define MAX_NAME 4096
#define TEXT_SIZE RF_EFFECTS_TEXT_SIZE // the longest text that is made here

RfFrameFiles rf_default_frame_files( void )
{
    return ( RfFrameFiles ){ .written = true, .half = true, .compression = RF_EXR_ZIP };
}

RfOutput rf_default_output( void ) { return ( RfOutput ){ .settings = rf_default_render_settings() }; }

// In the order of the file. Each is there at most once.
typedef enum Key
{
    VERSION,
    SCENE,
    CAMERA,
    FRAME,
    FRAMES,
    STEP,
    GROUP,
    SPP,
    TILE,
    WEIGHTS,
    NORMALIZE,
    SEED,
    MAX_DEPTH,
    LIGHT_SAMPLES,
    FILTER,
    FILTER_WIDTH,
    ADAPTIVE,
    NOISE,
    FLICKER,
    TIME,
    RELMSE_ESTIMATE,
    RELMSE_IS_LOWER_BOUND,
    RELMSE_LIKELY,
    WORST_TEN_SHARE,
    FLICKER_ESTIMATE,
    FLICKER_IS_LOWER_BOUND,
    FLICKER_LIKELY,
    FLICKER_WORST_TEN_SHARE,
    REACHED,
    NATIVE_SPP,
    EFFECTIVE_SPP,
    AOV,
    ESTIMATOR,
    RECONSTRUCTION,
    LIGHT_PATHS,
    KERNEL_NORMALIZATION,
    EFFECTS,
    NO_EFFECT,
    CALLS_FOR,
    DEVICE,
    FINGERPRINT,
    KEY_COUNT
} Key;

static const char* const s_names[KEY_COUNT] = {
    [VERSION] = "reframe/version",
    [SCENE] = "reframe/scene",
    [CAMERA] = "reframe/camera",
    [FRAME] = "reframe/frame",
    [FRAMES] = "reframe/frames",
    [STEP] = "reframe/step",
    [GROUP] = "reframe/group",
    [SPP] = "reframe/spp",
    [TILE] = "reframe/tile",
    [WEIGHTS] = "reframe/weights",
    [NORMALIZE] = "reframe/normalize",
    [SEED] = "reframe/seed",
    [MAX_DEPTH] = "reframe/max-depth",
    [LIGHT_SAMPLES] = "reframe/light-samples",
    [FILTER] = "reframe/filter",
    [FILTER_WIDTH] = "reframe/filter-width",
    [ADAPTIVE] = "reframe/adaptive",
    [NOISE] = "reframe/noise",
    [FLICKER] = "reframe/flicker",
    [TIME] = "reframe/time",
    [RELMSE_ESTIMATE] = "reframe/relmse-estimate",
    [RELMSE_IS_LOWER_BOUND] = "reframe/relmse-is-lower-bound",
    [RELMSE_LIKELY] = "reframe/relmse-likely",
    [WORST_TEN_SHARE] = "reframe/worst-ten-share",
    [FLICKER_ESTIMATE] = "reframe/flicker-estimate",
    [FLICKER_IS_LOWER_BOUND] = "reframe/flicker-is-lower-bound",
    [FLICKER_LIKELY] = "reframe/flicker-likely",
    [FLICKER_WORST_TEN_SHARE] = "reframe/flicker-worst-ten-share",
    [REACHED] = "reframe/reached",
    [NATIVE_SPP] = "reframe/native-spp",
    [EFFECTIVE_SPP] = "reframe/effective-spp",
    [AOV] = "reframe/aov",
    [ESTIMATOR] = "reframe/estimator",
    [RECONSTRUCTION] = "reframe/reconstruction",
    [LIGHT_PATHS] = "reframe/light-paths",
    [KERNEL_NORMALIZATION] = "reframe/kernel-normalization",
    [EFFECTS] = "reframe/effects",
    [NO_EFFECT] = "reframe/no-effect",
    [CALLS_FOR] = "reframe/calls-for",
    [DEVICE] = "reframe/device",
    [FINGERPRINT] = "reframe/fingerprint",
};

typedef struct Attributes
{
    const char* values[KEY_COUNT]; // NULL: not there
    char texts[KEY_COUNT][TEXT_SIZE];
    RfExrString strings[KEY_COUNT]; // those that are there
    int count;
} Attributes;

static void put_text( Attributes* a, Key key, const char* value ) { a->values[key] = value; }

__attribute__( ( format( printf, 3, 4 ) ) ) static void put( Attributes* a, Key key, const char* format, ... )
{
    va_list args;
    va_start( args, format );
    vsnprintf( a->texts[key], TEXT_SIZE, format, args );
    va_end( args );
    a->values[key] = a->texts[key];
}

static void put_settings( Attributes* a, const RfRenderSettings* s )
{
    char tile[RF_TILE_NAME_SIZE], aovs[RF_AOVS_TEXT_SIZE];
    rf_tile_name( &s->tile, tile );
    rf_format_aovs( s->aovs, aovs, sizeof aovs );
    put( a, GROUP, "%d", s->group );
    put( a, SPP, "%d", s->spp );
    put( a, TILE, "%s", tile );
    put_text( a, WEIGHTS, rf_weights_name( s->weights ) );
    put_text( a, NORMALIZE, rf_normalize_name( s->normalize ) );
    put( a, SEED, "%llu", (unsigned long long)s->seed );
    put( a, MAX_DEPTH, "%d", s->max_depth );
    put( a, LIGHT_SAMPLES, "%d", s->light_samples );
    if ( s->filter != RF_FILTER_BOX || s->filter_width != 1.0 )
    {
        put_text( a, FILTER, rf_filter_name( s->filter ) );
        put( a, FILTER_WIDTH, "%.9g", s->filter_width );
    }
    if ( s->adaptive != RF_ADAPTIVE_OFF )
        put_text( a, ADAPTIVE, s->adaptive == RF_ADAPTIVE_ON ? "yes" : rf_adaptive_name( s->adaptive ) );
    if ( s->noise > 0.0 )
        put( a, NOISE, "%.9g", s->noise );
    if ( s->flicker > 0.0 )
        put( a, FLICKER, "%.9g", s->flicker );
    if ( s->time > 0.0 )
        put( a, TIME, "%.9g", s->time );
    if ( s->aovs != 0 )
        put( a, AOV, "%s", aovs );
    if ( s->estimator != rf_default_render_settings().estimator )
        put_text( a, ESTIMATOR, rf_estimator_name( s->estimator ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF )
        put_text( a, LIGHT_PATHS, rf_light_paths_name( s->light_paths ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF && s->kernel_normalization != RF_KERNEL_EXACT )
        put_text( a, KERNEL_NORMALIZATION, rf_kernel_normalization_name( s->kernel_normalization ) );
    if ( s->reconstruction != RF_RECONSTRUCTION_WEIGHTED )
        put_text( a, RECONSTRUCTION, rf_reconstruction_name( s->reconstruction ) );
}

// Of options: nothing where none was given.
static void put_effects( Attributes* a, const RfScene* scene )
{
    char names[RF_EFFECTS_TEXT_SIZE];
    rf_format_effects( scene->effects_left_out, names, sizeof names );
    if ( scene->effects_left_out != 0 )
        put( a, NO_EFFECT, "%s", names );
    rf_format_effects( scene->effects_forced, names, sizeof names );
    if ( scene->effects_forced != 0 )
        put( a, EFFECTS, "%s",
             ( scene->effects_forced | scene->effects_left_out ) == ( rf_forcible_effects() | scene->effects_left_out ) ? "all"
                                                                                                                        : names );
}

static void put_frame( Attributes* a, const RfOutput* output, const RfFrameResult* frame )
{
    char fingerprint[RF_FINGERPRINT_SIZE];
    rf_frame_fingerprint( output, frame->frame, fingerprint );
    put_text( a, VERSION, rf_version() );
    put_text( a, SCENE, rf_tracer_scene( output->tracer )->path );
    put_text( a, CAMERA, output->path->name );
    put( a, FRAME, "%d", rf_frame_number( output->path, frame->frame ) );
    put( a, FRAMES, "%d", output->path->count );
    if ( output->path->step > 1 )
        put( a, STEP, "%d", output->path->step );
    if ( isfinite( frame->relmse_estimate ) )
    {
        put( a, RELMSE_ESTIMATE, "%.6g", frame->relmse_estimate );
        put_text( a, RELMSE_IS_LOWER_BOUND, frame->relmse_is_lower_bound ? "yes" : NULL );
        put( a, RELMSE_LIKELY, "%.6g", frame->relmse_likely );
        put( a, WORST_TEN_SHARE, "%.6g", frame->worst_ten_share );
    }
    if ( output->settings.flicker > 0.0 && isfinite( frame->flicker_estimate ) )
    {
        put( a, FLICKER_ESTIMATE, "%.6g", frame->flicker_estimate );
        put_text( a, FLICKER_IS_LOWER_BOUND, frame->flicker_is_lower_bound ? "yes" : NULL );
        put( a, FLICKER_LIKELY, "%.6g", frame->flicker_likely );
        put( a, FLICKER_WORST_TEN_SHARE, "%.6g", frame->flicker_worst_ten_share );
    }
    if ( output->settings.noise > 0.0 || output->settings.flicker > 0.0 )
        put_text( a, REACHED, frame->reached ? "yes" : "no" );
    put_effects( a, rf_tracer_scene( output->tracer ) );
    put_text( a, CALLS_FOR, output->calls_for );
    put( a, NATIVE_SPP, "%.9g", frame->native_spp );
    put( a, EFFECTIVE_SPP, "%.6g", frame->effective_spp );
    put_text( a, DEVICE, rf_tracer_device( output->tracer ) );
    put( a, FINGERPRINT, "%s", fingerprint );
}

static void list_attributes( const RfOutput* output, const RfFrameResult* frame, Attributes* a )
{
    for ( int i = 0; i < KEY_COUNT; ++i )
        a->values[i] = NULL;
    a->count = 0;
    put_settings( a, &output->settings );
    put_frame( a, output, frame );
    for ( int i = 0; i < KEY_COUNT; ++i )
    {
        if ( a->values[i] != NULL )
            a->strings[a->count++] = ( RfExrString ){ s_names[i], a->values[i] };
    }
}

// Frames of one run were rendered as one: there is no motion between them.
static bool has_same_eye( const RfCameraPath* path, int frame, int other )
{
    return path->run_of_frame != NULL && other >= 0 && other < path->count &&
           path->run_of_frame[frame] == path->run_of_frame[other];
}

RfResult rf_write_frame( const RfOutput* output, const RfFrameResult* frame, RfError* error )
{
    char name[MAX_NAME];
    if ( !output->settings.files.written )
        return rf_fail( error, RF_ERROR_USAGE, "settings.files is not set: start from rf_default_frame_files" );
    RfResult result =
        rf_sequence_name( output->pattern, rf_frame_number( output->path, frame->frame ), name, sizeof name, error );
    if ( result != RF_OK )
        return result;
    Attributes attributes;
    RfAovChannels aovs;
    list_attributes( output, frame, &attributes );
    const bool still[2] = { has_same_eye( output->path, frame->frame, frame->frame - 1 ),
                            has_same_eye( output->path, frame->frame, frame->frame + 1 ) };
    rf_list_aov_channels( frame, output->settings.files.half, still, &aovs );
    RfExrOptions exr = rf_default_exr_options();
    exr.compression = output->settings.files.compression;
    exr.half = output->settings.files.half;
    exr.fps_numerator = output->path->fps.numerator;
    exr.fps_denominator = (unsigned int)output->path->fps.denominator;
    exr.has_camera = true;
    const RfEye* eye = output->path->eyes + frame->frame;
    exr.pixel_aspect = eye->focal / eye->focal_x;
    rf_eye_matrices_around( eye, output->path->origin, exr.world_to_camera, exr.world_to_ndc );
    exr.strings = attributes.strings;
    exr.string_count = attributes.count;
    exr.channels = aovs.channels;
    exr.channel_count = aovs.count;
    // The writer only reads the pixels; RfImage has no const flavour.
    RfImage image = { .width = frame->width, .height = frame->height, .rgb = (float*)frame->rgb };
    return rf_write_exr( name, &image, &exr, error );
}

// A value as the option takes it: adaptive sampling that is on is "yes" in files.
static const char* option_value( Key key, const char* value )
{
    return key == ADAPTIVE && strcmp( value, "yes" ) == 0 ? rf_adaptive_name( RF_ADAPTIVE_ON ) : value;
}

// What a key that is not in a file stands for.
static const char* absent_value( Key key )
{
    switch ( key )
    {
        case ADAPTIVE: return rf_adaptive_name( RF_ADAPTIVE_OFF );
        case NOISE:
        case FLICKER:
        case TIME: return "0";
        case RECONSTRUCTION: return rf_reconstruction_name( RF_RECONSTRUCTION_WEIGHTED );
        case LIGHT_PATHS: return rf_light_paths_name( RF_LIGHT_PATHS_OFF );
        case KERNEL_NORMALIZATION: return rf_kernel_normalization_name( RF_KERNEL_EXACT );
        case AOV:
        case NO_EFFECT: return "none";
        case EFFECTS: return "auto";
        case FILTER: return rf_filter_name( RF_FILTER_BOX );
        case FILTER_WIDTH: return "1";
        case ESTIMATOR: return rf_estimator_name( rf_default_render_settings().estimator );
        default: return "";
    }
}

static void add_difference( RfFrameDifference* list, int* count, const char* name, const char* there, const char* here )
{
    if ( *count == RF_MAX_DIFFERENCES || strcmp( there, here ) == 0 )
        return;
    RfFrameDifference* difference = list + ( *count )++;
    difference->name = name;
    snprintf( difference->there, sizeof difference->there, "%s", there );
    snprintf( difference->here, sizeof difference->here, "%s", here );
}

static void add_size( const RfOutput* output, const char* name, RfFrameDifference* list, int* count )
{
    const RfEye* eye = output->path->eyes;
    char there[32], here[32];
    RfImage image;
    if ( rf_read_exr( name, &image, NULL ) != RF_OK )
        return;
    snprintf( there, sizeof there, "%dx%d", image.width, image.height );
    snprintf( here, sizeof here, "%dx%d", eye->width, eye->height );
    rf_destroy_image( &image );
    add_difference( list, count, "size", there, here );
}

// It is in no header, but in the fingerprint.
static void add_roulette( const RfOutput* output, const char* name, int frame, RfFrameDifference* list, int* count )
{
    char found[64], fingerprint[RF_FINGERPRINT_SIZE];
    RfOutput other = *output;
    bool here = output->settings.tile_roulette;
    other.settings.tile_roulette = !here;
    rf_frame_fingerprint( &other, frame, fingerprint );
    if ( rf_read_exr_string( name, s_names[FINGERPRINT], found, sizeof found, NULL ) == RF_OK &&
         strcmp( found, fingerprint ) == 0 )
        add_difference( list, count, "tile-roulette", here ? "no" : "yes", here ? "yes" : "no" );
}

int rf_list_frame_differences( const RfOutput* output, int frame, RfFrameDifference list[RF_MAX_DIFFERENCES] )
{
    static const Key keys[] = { VERSION,   FRAME,         CAMERA,         FRAMES,      GROUP,
                                SPP,       TILE,          WEIGHTS,        NORMALIZE,   SEED,
                                MAX_DEPTH, LIGHT_SAMPLES, ADAPTIVE,       NOISE,       TIME,
                                AOV,       FLICKER,       ESTIMATOR,      EFFECTS,     NO_EFFECT,
                                FILTER,    FILTER_WIDTH,  RECONSTRUCTION, LIGHT_PATHS, KERNEL_NORMALIZATION };
    char name[MAX_NAME], there[RF_DIFFERENCE_SIZE];
    int count = 0;
    Attributes wanted;
    RfFrameResult none = { .frame = frame };
    list_attributes( output, &none, &wanted );
    if ( rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, NULL ) != RF_OK )
        return 0;
    for ( size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i )
    {
        const char* here = wanted.values[keys[i]];
        bool is_there = rf_read_exr_string( name, s_names[keys[i]], there, sizeof there, NULL ) == RF_OK;
        add_difference( list, &count, s_names[keys[i]] + strlen( "reframe/" ),
                        is_there ? option_value( keys[i], there ) : absent_value( keys[i] ),
                        here != NULL ? option_value( keys[i], here ) : absent_value( keys[i] ) );
    }
    add_size( output, name, list, &count );
    add_roulette( output, name, frame, list, &count );
    return count;
}
