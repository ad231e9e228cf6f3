// Small pictures of some frames, with and without the limit. Both have the same random numbers, so that they differ by the light
// beyond the limit alone.
#include "light/light.h"
#include "math/vec3.h"
#include "reframe/render.h"
#include "trace/trace.h"

#include <math.h>

#define PILOT_FRAMES 8
#define PILOT_SIDE 48 // of a picture, pixels, the longer one
#define PILOT_SPP 16  // of all frames together

static RfRenderSettings pilot_settings( const RfRenderSettings* settings, int frames )
{
    RfRenderSettings pilot = rf_default_render_settings();
    pilot.group = 0;
    pilot.tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
    pilot.spp = ( PILOT_SPP + frames - 1 ) / frames;
    pilot.filter = RF_FILTER_BOX;
    pilot.filter_width = rf_default_filter_width( RF_FILTER_BOX );
    pilot.adaptive = RF_ADAPTIVE_OFF;
    pilot.guide = RF_GUIDE_OFF;
    pilot.light_samples = settings->light_samples;
    pilot.light_sampling = settings->light_sampling;
    pilot.threads = 1; // pictures are too small to share out, and take little memory, whatever the budget
    return pilot;
}

static RfEye shrink( RfEye eye )
{
    double longer = eye.width > eye.height ? eye.width : eye.height, scale = fmin( PILOT_SIDE / longer, 1.0 );
    int width = (int)fmax( scale * eye.width, 1.0 ), height = (int)fmax( scale * eye.height, 1.0 );
    float x = (float)width / (float)eye.width, y = (float)height / (float)eye.height;
    eye.focal_x *= x;
    eye.axis_x *= x;
    eye.focal *= y;
    eye.axis_y *= y;
    eye.width = width;
    eye.height = height;
    return eye;
}

static RfResult sum_picture( void* user, const RfFrameResult* result, RfError* error )
{
    double* sum = user;
    (void)error;
    for ( int i = 0; i < result->width * result->height; ++i )
    {
        const float* c = result->rgb + 3 * (size_t)i;
        *sum += (double)rf_luminance( rf_vec3( c[0], c[1], c[2] ) );
    }
    return RF_OK;
}

RfResult rf_find_light_beyond_depth( const RfShot* shot, const RfRenderSettings* settings, double* share, RfError* error )
{
    *share = 0.0;
    if ( settings->max_depth >= RF_MAX_DEPTH || shot->eye_count < 1 || rf_tracer_lights( shot->tracer )->count == 0 )
        return RF_OK;
    int frames = shot->eye_count < PILOT_FRAMES ? shot->eye_count : PILOT_FRAMES;
    RfRenderSettings pilot = pilot_settings( settings, frames );
    double cut = 0.0, whole = 0.0;
    RfResult result = RF_OK;
    for ( int k = 0; k < frames && result == RF_OK; ++k )
    {
        static const int only = 0;
        RfEye eye = shrink( shot->eyes[( 2 * (int64_t)k + 1 ) * shot->eye_count / ( 2 * frames )] );
        RfShot picture = { shot->tracer, &eye, 1, &only, 1 };
        pilot.max_depth = settings->max_depth;
        result = rf_render( &picture, &pilot, &( RfRenderCallbacks ){ .user = &cut, .frame = sum_picture }, NULL, error );
        pilot.max_depth = RF_MAX_DEPTH;
        if ( result == RF_OK )
            result = rf_render( &picture, &pilot, &( RfRenderCallbacks ){ .user = &whole, .frame = sum_picture }, NULL, error );
    }
    *share = whole > 0.0 ? fmax( 1.0 - cut / whole, 0.0 ) : 0.0;
    return result;
}
