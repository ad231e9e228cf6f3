// Denoises a finished frame, with the layers that add up to its picture.
#include "base/try.h"
#include "output/frame_file.h"
#include "scene/light_groups.h"

#include <stdlib.h>
#include <string.h>

// Copies an image of three channels to where layer `i` is denoised.
static float* copy_image( RfDenoisedFrame* to, int i, const float* rgb )
{
    size_t size = 3 * (size_t)to->frame.width * (size_t)to->frame.height;
    float* copy = to->pixels + size * (size_t)i;
    memcpy( copy, rgb, size * sizeof *copy );
    return copy;
}

static bool is_light( const RfLayer* layer ) { return strncmp( layer->name, RF_LIGHT_LAYER, strlen( RF_LIGHT_LAYER ) ) == 0; }

// Copies the layers that are denoised, and lists them; the first image is that of the picture.
static int list_layers( const RfFrameResult* frame, RfDenoisedFrame* out, RfNoisyLayer* list )
{
    int count = 0;
    for ( int i = 0; i < frame->layer_count; ++i )
    {
        out->layers[i] = frame->layers[i];
        if ( !is_light( frame->layers + i ) )
            continue;
        float* copy = copy_image( out, 1 + count, frame->layers[i].values );
        out->layers[i].values = copy;
        list[count++] = ( RfNoisyLayer ){ 0, copy, true };
    }
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
    {
        if ( frame->aovs[a] == NULL || ( RF_PASS_AOVS & RF_AOV_BIT( a ) ) == 0 )
            continue;
        float* copy = copy_image( out, 1 + count, frame->aovs[a] );
        out->frame.aovs[a] = copy;
        list[count++] = ( RfNoisyLayer ){ 1, copy, true };
    }
    return count;
}

RfResult rf_denoise_frame( RfDenoiser* denoiser, const RfFrameResult* frame, RfDenoisedSums* sums, RfDenoisedFrame* out,
                           RfError* error )
{
    RfNoisyLayer list[RF_LIGHT_GROUPS_MOST + RF_AOV_COUNT];
    size_t image = 3 * (size_t)frame->width * (size_t)frame->height * sizeof( float );
    int most = 1 + frame->layer_count + __builtin_popcount( RF_PASS_AOVS );
    *out = ( RfDenoisedFrame ){ .frame = *frame,
                                .layers = malloc( (size_t)( frame->layer_count + 1 ) * sizeof *out->layers ),
                                .pixels = malloc( (size_t)most * image ) };
    if ( out->layers == NULL || out->pixels == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d denoised layers of %dx%d pixels", most, frame->width,
                        frame->height );
    RfNoisyFrame noisy = rf_noisy_frame( frame );
    noisy.layer_count = list_layers( frame, out, list );
    noisy.layers = list;
    RF_TRY( rf_denoise( denoiser, &noisy, out->pixels, &out->denoised, sums, error ) );
    out->layers[frame->layer_count] = ( RfLayer ){ .name = RF_NOISY_LAYER, .letters = "RGB", .values = frame->rgb };
    out->frame.rgb = out->pixels;
    out->frame.layers = out->layers;
    out->frame.layer_count = frame->layer_count + 1;
    out->frame.denoised = &out->denoised;
    return RF_OK;
}

void rf_free_denoised_frame( RfDenoisedFrame* frame )
{
    free( frame->layers );
    free( frame->pixels );
    frame->layers = NULL;
    frame->pixels = NULL;
}
