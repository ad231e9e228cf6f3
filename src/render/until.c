// Windows that are rendered until noise or time says so: what rf_stop decides
// by, taken from the films and the clock.
#include "base/system.h"
#include "render/render_internal.h"

#include <math.h>

// The image of a film is made for it in a buffer that waits for the next frame.
static void estimate_noise( RfRenderer* r, LiveFilm* live )
{
    RfFilmCombine combine = rf_film_combine( r->settings.normalize );
    RfFrameBuffer* buffer = rf_next_frame_buffer( &r->delivery );
    rf_combine_film( &live->film, combine, buffer->rgb, NULL );
    live->seen = live->film.weight[0] + live->film.weight[1];
    live->noise = live->seen * rf_estimate_relmse( &live->film, combine, buffer->rgb );
}

// Estimates take time: they are made where they decide, and of enough others to
// tell what the frames to come are like.
static bool is_looked_at( const RfRenderer* r, const RfNoiseEstimates* look, int i )
{
    int first, last;
    rf_groups_of_frame( &r->plan, look->frames[i].frame, &first, &last );
    bool as_good = look->frames[i].passes >= look->frames[0].passes;
    return last == look->window || i == look->count / 2 || ( i == look->count - 1 && as_good );
}

// The films of a window after `done` passes of it.
static RfNoiseEstimates look_at_films( RfRenderer* r, int number, int done )
{
    RfNoiseEstimates look = { .window = number, .done = done, .frames = r->memory.looks };
    RfGroup window = rf_group( &r->plan, number );
    for ( int frame = window.first; frame < window.first + window.eyes; ++frame )
    {
        const LiveFilm* live = rf_find_film( r, frame );
        if ( live == NULL )
            continue;
        const RfFilm* film = &live->film;
        r->memory.looks[look.count++] = ( RfFrameNoise ){ .frame = frame,
                                                          .passes = film->passes[0] + film->passes[1],
                                                          .weight = film->weight[0] + film->weight[1],
                                                          .noise = live->noise,
                                                          .seen = live->seen };
    }
    for ( int i = 0; i < look.count && r->settings.noise > 0.0; ++i )
    {
        RfFrameNoise* frame = r->memory.looks + i;
        if ( frame->passes < 2 || !is_looked_at( r, &look, i ) )
            continue;
        LiveFilm* live = rf_find_film( r, frame->frame );
        if ( live->seen != frame->weight ) // not since the last window
            estimate_noise( r, live );
        frame->noise = live->noise;
        frame->seen = live->seen;
    }
    return look;
}

RfResult rf_render_until( RfRenderer* r, const RfHarvest* harvest, RfError* error )
{
    RfStop* stop = &r->stop;
    RfGroup window = rf_begin_group( stop, harvest->window );
    RfNoiseEstimates look = look_at_films( r, harvest->window, 0 );
    int due, done = 0;
    while ( ( due = rf_passes_due( stop, &look, done, rf_wall_seconds() - r->start ) ) > done )
    {
        int next = stop->seconds > 0.0 ? done + 1 : due;
        for ( ; done < next; ++done )
        {
            RfResult result = rf_render_pass( r, harvest, &window, done, error );
            if ( result != RF_OK )
                return result;
            rf_note_pass( stop, window.eyes, rf_wall_seconds() - r->start );
        }
        if ( next == due )
            look = look_at_films( r, harvest->window, done );
    }
    rf_end_group( stop, done );
    return RF_OK;
}
