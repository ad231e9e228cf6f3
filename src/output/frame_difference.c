#include "output/frame_difference.h"

#include "output/frame_attributes.h"
#include "scene/eye.h"

#include <stdio.h>
#include <string.h>

#define MAX_NAME 4096

// A value as the option takes it: adaptive sampling that is on is "yes" in files.
static const char* option_value( RfKey key, const char* value )
{
    return key == RF_KEY_ADAPTIVE && strcmp( value, "yes" ) == 0 ? rf_adaptive_name( RF_ADAPTIVE_ON ) : value;
}

// What a key that is not in a file stands for.
static const char* absent_value( RfKey key )
{
    switch ( key )
    {
        case RF_KEY_ADAPTIVE: return rf_adaptive_name( RF_ADAPTIVE_OFF );
        case RF_KEY_NOISE:
        case RF_KEY_FLICKER:
        case RF_KEY_TIME: return "0";
        case RF_KEY_RECONSTRUCTION: return rf_reconstruction_name( RF_RECONSTRUCTION_WEIGHTED );
        case RF_KEY_LIGHT_PATHS: return rf_light_paths_name( RF_LIGHT_PATHS_OFF );
        case RF_KEY_KERNEL_NORMALIZATION: return rf_kernel_normalization_name( RF_KERNEL_EXACT );
        case RF_KEY_AOV:
        case RF_KEY_NO_EFFECT: return "none";
        case RF_KEY_EFFECTS: return "auto";
        case RF_KEY_FILTER: return rf_filter_name( RF_FILTER_BOX );
        case RF_KEY_FILTER_WIDTH: return "1";
        case RF_KEY_ESTIMATOR: return rf_estimator_name( rf_default_render_settings().estimator );
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

int rf_list_frame_differences( const RfOutput* output, int frame, RfFrameDifference list[RF_MAX_DIFFERENCES] )
{
    static const RfKey keys[] = {
        RF_KEY_VERSION,   RF_KEY_FRAME,         RF_KEY_CAMERA,         RF_KEY_FRAMES,      RF_KEY_GROUP,
        RF_KEY_SPP,       RF_KEY_TILE,          RF_KEY_WEIGHTS,        RF_KEY_NORMALIZE,   RF_KEY_SEED,
        RF_KEY_MAX_DEPTH, RF_KEY_LIGHT_SAMPLES, RF_KEY_ADAPTIVE,       RF_KEY_NOISE,       RF_KEY_TIME,
        RF_KEY_AOV,       RF_KEY_FLICKER,       RF_KEY_ESTIMATOR,      RF_KEY_EFFECTS,     RF_KEY_NO_EFFECT,
        RF_KEY_FILTER,    RF_KEY_FILTER_WIDTH,  RF_KEY_RECONSTRUCTION, RF_KEY_LIGHT_PATHS, RF_KEY_KERNEL_NORMALIZATION
    };
    char name[MAX_NAME], there[RF_DIFFERENCE_SIZE];
    int count = 0;
    RfAttributes wanted;
    RfFrameResult none = { .frame = frame };
    rf_list_attributes( output, &none, &wanted );
    if ( rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, NULL ) != RF_OK )
        return 0;
    for ( size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i )
    {
        const char* here = wanted.values[keys[i]];
        bool is_there = rf_read_exr_string( name, rf_key_name( keys[i] ), there, sizeof there, NULL ) == RF_OK;
        add_difference( list, &count, rf_key_name( keys[i] ) + strlen( "reframe/" ),
                        is_there ? option_value( keys[i], there ) : absent_value( keys[i] ),
                        here != NULL ? option_value( keys[i], here ) : absent_value( keys[i] ) );
    }
    add_size( output, name, list, &count );
    return count;
}
