// Makes a picture of the oldest frame in work, as seldom as its cost demands.
#include "render/preview.h"

#include "base/system.h"

#include <math.h>

#define LEAST_SECONDS 1.0 // between two
#define MOST_SHARE 0.01   // of the time of a render

static const RfLiveFilm* oldest_film( const RfRenderer* r )
{
    const RfLiveFilm* oldest = NULL;
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        const RfLiveFilm* live = r->memory.films + i;
        if ( live->frame != -1 && ( oldest == NULL || live->frame < oldest->frame ) )
            oldest = live;
    }
    return oldest;
}

// Without the estimate of its error. With one half alone the cross-fitted picture is A, whose B may be far from 1.
static void combine( const RfRenderer* r, const RfLiveFilm* live, float* rgb )
{
    const RfFilm* film = live->films;
    bool halves = film->passes[0] > 0 && film->passes[1] > 0;
    RfNormalize normalize = halves ? r->setup->settings.normalize : RF_NORMALIZE_RATIO;
    rf_combine_film( film, normalize, rgb, NULL );
}

void rf_show_preview( RfRenderer* r )
{
    const RfRenderCallbacks* callbacks = &r->setup->callbacks;
    const RfLiveFilm* live = oldest_film( r );
    double began = rf_wall_seconds();
    if ( callbacks->preview == NULL || live == NULL || began < r->next_preview )
        return;
    RfFrameBuffer* buffer = rf_free_frame_buffer( &r->queue ); // lent: the next finished frame overwrites it
    if ( buffer == NULL )
        return;
    if ( r->setup->settings.estimator->finish != NULL )
        rf_finish_picture( r, live, &( RfPicture ){ .rgb = buffer->rgb } );
    else
        combine( r, live, buffer->rgb );
    const RfFilm* film = live->films;
    callbacks->preview( callbacks->user, &( RfPreview ){ .frame = live->frame,
                                                         .width = film->width,
                                                         .height = film->height,
                                                         .rgb = buffer->rgb,
                                                         .native_spp = film->passes[0] + film->passes[1] } );
    double now = rf_wall_seconds();
    r->next_preview = now + fmax( LEAST_SECONDS, ( now - began ) / MOST_SHARE );
}
