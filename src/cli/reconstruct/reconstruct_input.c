#include "cli/reconstruct/reconstruct_input.h"

#include "image/exr.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LAYER_SIZE 512
#define VARIANCES "primal.variance,dx.variance,dy.variance"

enum
{
    FROM_DX = 2, // indices of inputs
    FROM_DY = 3
};

static const char* const s_prefixes[2] = { "even.", "odd." };

RfResult rf_find_reconstruct_files( RfReconstructFiles* files, RfError* error )
{
    const char* names[4] = { files->images[0], files->image_count > 1 ? files->images[1] : NULL, files->dx_from, files->dy_from };
    RfResult result = RF_OK;
    if ( files->image_count > 1 && ( files->dx_from != NULL || files->dy_from != NULL ) )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: gradients of one file cannot be those of two halves: give one image",
                        files->dx_from != NULL ? "dx-from" : "dy-from" );
    for ( int k = 0; k < 4 && result == RF_OK; ++k )
    {
        if ( names[k] != NULL )
            result = rf_find_sequence_input( names[k], k == 0 ? files->frames : NULL, files->inputs + k, error );
        if ( result == RF_OK && names[k] != NULL && files->inputs[k].is_sequence != files->inputs[0].is_sequence )
            result = rf_fail( error, RF_ERROR_USAGE, "%s is %s, but %s is %s", names[0],
                              files->inputs[0].is_sequence ? "a sequence" : "a file", names[k],
                              files->inputs[k].is_sequence ? "a sequence" : "a file" );
    }
    return result;
}

void rf_free_reconstruct_files( RfReconstructFiles* files )
{
    for ( int k = 0; k < 4; ++k )
        rf_free_sequence_input( files->inputs + k );
}

static bool has_channel( const RfExrHeader* header, const char* prefix, const char* name )
{
    char full[LAYER_SIZE + 16];
    snprintf( full, sizeof full, "%s%s", prefix, name );
    return rf_find_exr_name( header, full, strlen( full ) ) != NULL;
}

// Reads a layer (NULL: the colour); all must have the window of the first. Where it is missing, the message
// tells the option that names it.
static RfResult read_layer( const char* path, const char* layer, const char* option, RfReconstructFrame* frame, RfImage* image,
                            RfError* error )
{
    RfExrWindow window;
    RfError here;
    RfResult result = rf_read_exr_layer( path, layer, image, &window, &here );
    if ( result == RF_ERROR_FORMAT )
        return rf_fail( error, result, "%.900s: name it by --%s", here.text, option );
    if ( result != RF_OK )
        return rf_fail( error, result, "%s", here.text );
    if ( frame->window.width == 0 )
        frame->window = window;
    if ( memcmp( &window, &frame->window, sizeof window ) != 0 )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %s is %dx%d at (%d, %d), but the primal %dx%d at (%d, %d)", path,
                        layer != NULL ? layer : "the colour", window.width, window.height, window.x, window.y,
                        frame->window.width, frame->window.height, frame->window.x, frame->window.y );
    return RF_OK;
}

// "even." and "dx" or the name that was given: "even.dx".
static const char* layer_name( const char* prefix, const char* given, const char* usual, char text[LAYER_SIZE] )
{
    snprintf( text, LAYER_SIZE, "%s%s", prefix, given != NULL ? given : usual );
    return text;
}

// Gradients: a layer of the image, or of a file of their own, where it may be the colour.
static RfResult read_gradient( const char* path, const char* from, const char* prefix, const char* given, const char* name,
                               RfReconstructFrame* frame, RfImage* image, RfError* error )
{
    char layer[LAYER_SIZE], channel[8];
    if ( from == NULL )
        return read_layer( path, layer_name( prefix, given, name, layer ), name, frame, image, error );
    RfExrHeader header;
    RfResult result = rf_read_exr_header( from, NULL, &header, error );
    if ( result != RF_OK )
        return result;
    snprintf( channel, sizeof channel, "%s.R", name );
    bool is_layer = given != NULL || has_channel( &header, "", channel );
    rf_destroy_exr_header( &header );
    return read_layer( from, is_layer ? layer_name( "", given, name, layer ) : NULL, name, frame, image, error );
}

// Three channels into three planes.
static RfResult read_variance( const char* path, const char* prefix, const char* given, RfReconstructFrame* frame,
                               float* planes[3], RfError* error )
{
    char layer[LAYER_SIZE];
    const char* names = given != NULL ? given : VARIANCES;
    size_t used = 0;
    layer[0] = '\0';
    while ( used < sizeof layer ) // the prefix goes to each of the names
    {
        size_t length = strcspn( names, "," );
        used += (size_t)snprintf( layer + used, sizeof layer - used, "%s%.*s%s", prefix, (int)length, names,
                                  names[length] != '\0' ? "," : "" );
        if ( names[length] == '\0' )
            break;
        names += length + 1;
    }
    RfImage image = { 0 };
    RfResult result = read_layer( path, layer, "variance A,X,Y", frame, &image, error );
    size_t count = (size_t)image.width * (size_t)image.height;
    for ( size_t c = 0; c < 3 && result == RF_OK; ++c )
    {
        planes[c] = malloc( count * sizeof( float ) );
        if ( planes[c] == NULL )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for its variances", path );
        for ( size_t i = 0; i < count && planes[c] != NULL; ++i )
            planes[c][i] = image.rgb[3 * i + c];
    }
    rf_destroy_image( &image );
    return result;
}

// Files of a frame: of the image, its other half, dx and dy; "" where there is none.
typedef struct Paths
{
    char of[4][RF_FILE_NAME_SIZE];
} Paths;

static RfResult read_half( const RfReconstructFiles* files, const Paths* paths, const RfExrHeader* header, int file,
                           const char* prefix, int k, RfReconstructFrame* frame, RfError* error )
{
    char layer[LAYER_SIZE];
    const char *path = paths->of[file], *dx = paths->of[FROM_DX], *dy = paths->of[FROM_DY];
    bool named = files->primal != NULL || prefix[0] != '\0' || has_channel( header, prefix, "primal.R" );
    const char* primal = named ? layer_name( prefix, files->primal, "primal", layer ) : NULL;
    RfResult result = read_layer( path, primal, "primal", frame, frame->primal + k, error );
    if ( result == RF_OK )
        result = read_gradient( path, dx[0] != '\0' ? dx : NULL, prefix, files->dx, "dx", frame, frame->dx + k, error );
    if ( result == RF_OK )
        result = read_gradient( path, dy[0] != '\0' ? dy : NULL, prefix, files->dy, "dy", frame, frame->dy + k, error );
    bool has_variance = files->variance != NULL || has_channel( header, prefix, "primal.variance" );
    if ( result == RF_OK && has_variance )
        result = read_variance( path, prefix, files->variance, frame, frame->variance[k], error );
    frame->has_variance = has_variance && ( k == 0 || frame->has_variance );
    frame->half_count = k + 1;
    return result;
}

// The half that a file is, or the two that it holds.
static RfResult read_file( const RfReconstructFiles* files, const Paths* paths, int file, RfReconstructFrame* frame,
                           RfError* error )
{
    RfExrHeader header;
    char channel[LAYER_SIZE];
    RfResult result = rf_read_exr_header( paths->of[file], NULL, &header, error );
    if ( result != RF_OK )
        return result;
    if ( file == 0 )
        frame->fps_numerator = header.fps_numerator, frame->fps_denominator = header.fps_denominator;
    snprintf( channel, sizeof channel, "%.500s.R", files->primal != NULL ? files->primal : "primal" );
    bool both = files->image_count == 1 && files->dx_from == NULL && files->dy_from == NULL &&
                has_channel( &header, s_prefixes[0], channel );
    if ( !both )
        result = read_half( files, paths, &header, file, "", file, frame, error );
    for ( int k = 0; k < 2 && both && result == RF_OK; ++k )
        result = read_half( files, paths, &header, file, s_prefixes[k], k, frame, error );
    rf_destroy_exr_header( &header );
    return result;
}

RfResult rf_read_reconstruct_frame( const RfReconstructFiles* files, int number, RfReconstructFrame* frame, RfError* error )
{
    Paths* paths = calloc( 1, sizeof *paths );
    RfResult result = paths != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "no memory left for the names of files" );
    *frame = ( RfReconstructFrame ){ .half_count = 0 };
    for ( int k = 0; k < 4 && result == RF_OK; ++k )
    {
        const RfSequenceInput* input = files->inputs + k;
        if ( input->is_sequence )
            result = rf_sequence_name( input->pattern, number, paths->of[k], sizeof paths->of[k], error );
        else
            memcpy( paths->of[k], input->pattern, sizeof input->pattern );
    }
    for ( int k = 0; k < files->image_count && result == RF_OK; ++k )
        result = read_file( files, paths, k, frame, error );
    free( paths );
    return result;
}

void rf_free_reconstruct_frame( RfReconstructFrame* frame )
{
    for ( int k = 0; k < 2; ++k )
    {
        rf_destroy_image( frame->primal + k );
        rf_destroy_image( frame->dx + k );
        rf_destroy_image( frame->dy + k );
        for ( int c = 0; c < 3; ++c )
            free( frame->variance[k][c] );
    }
    *frame = ( RfReconstructFrame ){ .half_count = 0 };
}

RfGradientImages rf_reconstruct_images( const RfReconstructFrame* frame, int k )
{
    return ( RfGradientImages ){ frame->window.width, frame->window.height, frame->primal[k].rgb, frame->dx[k].rgb,
                                 frame->dy[k].rgb };
}
