#include "support/render_support.h"
#include "reuse/tile/tile.h"
#include "support/statistics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_FRAMES 64

static void* must_alloc( size_t bytes )
{
    void* memory = malloc( bytes );
    if ( memory == NULL )
        abort();
    return memory;
}

static void must( RfResult result, const RfError* error )
{
    if ( result == RF_OK )
        return;
    fprintf( stderr, "unexpected failure: %s\n", error->text );
    abort();
}

static RfResult keep_frame( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    Rendered* r = user;
    memcpy( r->rgb + 3 * r->pixels * (size_t)r->count, frame->rgb, 3 * r->pixels * sizeof( float ) );
    memcpy( r->weight + r->pixels * (size_t)r->count, frame->weight, r->pixels * sizeof( float ) );
    r->relmse_estimate[r->count] = frame->relmse_estimate;
    r->relmse_likely[r->count] = frame->relmse_likely;
    r->relmse_is_lower_bound[r->count] = frame->relmse_is_lower_bound;
    r->native_spp[r->count] = frame->native_spp;
    r->effective_spp[r->count] = frame->effective_spp;
    r->count += 1;
    return RF_OK;
}

Rendered render_frames( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                        const RfRenderSettings* settings )
{
    Rendered r = { .pixels = (size_t)eyes->width * (size_t)eyes->height };
    if ( frame_count > MOST_FRAMES )
        abort();
    r.rgb = must_alloc( 3 * r.pixels * (size_t)frame_count * sizeof( float ) );
    r.weight = must_alloc( r.pixels * (size_t)frame_count * sizeof( float ) );
    RfRenderCallbacks callbacks = { &r, keep_frame, NULL };
    RfError error;
    RfRenderSettings of_suite = *settings;
    of_suite.seed += suite_seed();
    of_suite.spp *= suite_samples();
    must( rf_render( tracer, eyes, eye_count, frames, frame_count, &of_suite, &callbacks, &r.stats, &error ), &error );
    float bias = settings->group > 0 || settings->tile.kind != RF_TILE_NONE ? (float)suite_bias() : 1.0f;
    for ( size_t i = 0; bias != 1.0f && i < 3 * r.pixels * (size_t)r.count; ++i )
        r.rgb[i] *= bias;
    return r;
}

Rendered render_all( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings )
{
    int frames[MOST_FRAMES];
    for ( int i = 0; i < eye_count && i < MOST_FRAMES; ++i )
        frames[i] = i;
    return render_frames( tracer, eyes, eye_count, frames, eye_count, settings );
}

void free_rendered( Rendered* rendered )
{
    free( rendered->rgb );
    free( rendered->weight );
    *rendered = ( Rendered ){ 0 };
}

RfTracer* make_tracer( const RfScene* scene )
{
    RfTracer* tracer = NULL;
    RfError error;
    must( rf_create_tracer( scene, &tracer, &error ), &error );
    return tracer;
}

RfRenderSettings plain_settings( void )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.tile = rf_no_tile();
    settings.adaptive = RF_ADAPTIVE_OFF;
    return settings;
}
