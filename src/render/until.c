// What the stop rule decides by, taken from the films and the clock.
#include "render/until.h"

#include "base/system.h"
#include "render/pass.h"

#include <math.h>

// The picture is made in a buffer that waits for the next frame.
static void estimate_noise( RfRenderer* r, RfLiveFilm* live )
{
    const RfFilm* film = live->films;
    RfFrameBuffer* buffer = rf_next_frame_buffer( &r->queue );
    live->noise_seen = film->weight[0] + film->weight[1];
    RfRelmse relmse = rf_finish_picture( r, live, &( RfPicture ){ .rgb = buffer->rgb } );
    live->noise = live->noise_seen * rf_prudent_relmse( &relmse );
}

// Estimates take time: they are made where they decide, and for enough others to
// predict the frames to come.
static bool wants_estimate( const RfRenderer* r, const RfNoiseEstimates* estimates, int i )
{
    int first, last;
    rf_groups_of_frame( &r->plan, estimates->frames[i].frame, &first, &last );
    bool as_good = estimates->frames[i].passes >= estimates->frames[0].passes;
    return last == estimates->group || i == estimates->count / 2 || ( i == estimates->count - 1 && as_good );
}

// The films of a group after `done` passes of it.
static RfNoiseEstimates estimate_films( RfRenderer* r, int number, int done )
{
    RfFrameNoise* frames = r->memory.noise_estimates;
    RfNoiseEstimates estimates = { .group = number, .done = done, .frames = frames };
    RfGroup group = rf_group( &r->plan, number );
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        const RfLiveFilm* live = rf_find_film( r, frame );
        if ( live == NULL )
            continue;
        const RfFilm* film = live->films;
        frames[estimates.count++] = ( RfFrameNoise ){ .frame = frame,
                                                      .passes = film->passes[0] + film->passes[1],
                                                      .weight = film->weight[0] + film->weight[1],
                                                      .noise = live->noise,
                                                      .seen = live->noise_seen };
    }
    for ( int i = 0; i < estimates.count && r->settings.noise > 0.0; ++i )
    {
        if ( frames[i].passes < 2 || !wants_estimate( r, &estimates, i ) )
            continue;
        RfLiveFilm* live = rf_find_film( r, frames[i].frame );
        if ( live->noise_seen != frames[i].weight ) // new samples since the last estimate
            estimate_noise( r, live );
        frames[i].noise = live->noise;
        frames[i].seen = live->noise_seen;
    }
    return estimates;
}

RfResult rf_render_until( RfRenderer* r, const RfEstimatorGroup* estimator_group, RfError* error )
{
    RfStop* stop = &r->stop;
    RfGroup group = rf_begin_group( stop, estimator_group->number );
    RfNoiseEstimates estimates = estimate_films( r, estimator_group->number, 0 );
    int due, done = 0;
    while ( ( due = rf_passes_due( stop, &estimates, done, rf_wall_seconds() - r->start ) ) > done )
    {
        int next = stop->seconds > 0.0 ? done + 1 : due;
        for ( ; done < next; ++done )
        {
            RfPass pass = rf_make_pass( estimator_group, &group, done );
            RfResult result = rf_render_pass( r, &pass, error );
            if ( result != RF_OK )
                return result;
            rf_note_pass( stop, group.eyes, rf_wall_seconds() - r->start );
        }
        if ( next == due )
            estimates = estimate_films( r, estimator_group->number, done );
    }
    rf_end_group( stop, done );
    return RF_OK;
}
