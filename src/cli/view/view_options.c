// Chooses a view by the options and the header of a file, and an exposure by the light.
#include "cli/view/view_options.h"

#include "output/frame_file.h"

#include <math.h>
#include <stdio.h>

static void read_text( const char* path, RfKey key, char text[RF_VIEW_NAME_SIZE] )
{
    RfError none;
    if ( rf_read_exr_string( path, rf_key_name( key ), text, RF_VIEW_NAME_SIZE, &none ) != RF_OK )
        text[0] = '\0';
}

// What no scene may ask for (scene/shared_json.h) is not taken from a header either.
static double read_number( const char* path, RfKey key, double least, double most, double otherwise )
{
    double number = rf_read_exr_number( path, rf_key_name( key ) );
    return isfinite( number ) && number >= least && number <= most ? number : otherwise;
}

static RfViewText choose_view( const RfViewOptions* options, const char* path )
{
    RfViewText text = { .exposure = read_number( path, RF_KEY_EXPOSURE, -32.0, 32.0, 0.0 ),
                        .gamma = read_number( path, RF_KEY_GAMMA, 0.01, 100.0, 1.0 ) };
    read_text( path, RF_KEY_VIEW, text.transform );
    read_text( path, RF_KEY_LOOK, text.look );
    if ( options->view != NULL )
    {
        snprintf( text.transform, sizeof text.transform, "%s", options->view );
        text.look[0] = '\0';
    }
    if ( options->look != NULL )
        snprintf( text.look, sizeof text.look, "%s", options->look );
    if ( options->exposure_given )
        text.exposure = options->exposure;
    return text;
}

RfResult rf_open_chosen_view( const RfViewOptions* options, const char* path, RfLog* log, RfView** view, RfViewText* chosen,
                              RfError* error )
{
    RfError why;
    *chosen = choose_view( options, path );
    RfResult result = rf_open_view( chosen, view, &why );
    if ( result == RF_OK )
        return RF_OK;
    if ( result == RF_ERROR_MEMORY || options->view != NULL || options->look != NULL )
        return rf_fail( error, result, "--view: %.500s", why.text );
    rf_warn( log, "%s: shown by the sRGB curve: %.500s", path, why.text );
    chosen->transform[0] = chosen->look[0] = '\0';
    return rf_open_view( chosen, view, error );
}

static void add_light( const RfImage* image, double* sum, double* count )
{
    for ( size_t i = 0; i < (size_t)image->width * (size_t)image->height; ++i )
    {
        const float* rgb = image->rgb + 3 * i;
        double luminance = 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
        if ( !( luminance > 1e-9 && luminance < 1e30 ) )
            continue;
        *sum += log2( luminance );
        *count += 1.0;
    }
}

RfResult rf_find_exposure( const char* const* paths, int count, double* stops, RfError* error )
{
    double sum = 0.0, pixels = 0.0;
    for ( int i = 0; i < count; ++i )
    {
        RfImage image = { 0 };
        RfResult result = rf_read_exr( paths[i], &image, error );
        if ( result != RF_OK )
            return result;
        add_light( &image, &sum, &pixels );
        rf_destroy_image( &image );
    }
    *stops = pixels > 0.0 ? log2( 0.18 ) - sum / pixels : 0.0;
    return RF_OK;
}
