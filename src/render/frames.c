// Frames of a render: their films from the first window that holds them to the
// last, and then to the caller.
#include "base/system.h"
#include "render/adaptive.h"

// Was the frame asked for? The frames are in ascending order.
static bool asked_for( const RfRenderer* r, int frame )
{
    int low = 0, end = r->frame_count;
    while ( low < end )
    {
        int middle = low + ( end - low ) / 2;
        if ( r->frames[middle] == frame )
            return true;
        if ( r->frames[middle] < frame )
            low = middle + 1;
        else
            end = middle;
    }
    return false;
}

LiveFilm* rf_find_film( const RfRenderer* r, int frame )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame == frame )
            return r->memory.films + i;
    }
    return NULL;
}

void rf_open_films( RfRenderer* r, int window )
{
    RfGroup group = rf_group( &r->plan, window );
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        int first, last;
        rf_groups_of_frame( &r->plan, frame, &first, &last );
        if ( first != window || !asked_for( r, frame ) )
            continue;
        LiveFilm* live = rf_find_film( r, -1 );
        live->frame = frame;
        live->noise = live->seen = 0.0;
        rf_clear_film( &live->film );
        rf_clear_aov_film( &live->layers, r->sizes.width, r->sizes.height );
        if ( r->settings.adaptive )
            rf_run_pilot( r, live );
    }
}

RfFilmCombine rf_film_combine( RfNormalize normalize )
{
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return RF_FILM_CROSSFIT;
        case RF_NORMALIZE_RATIO: return RF_FILM_RATIO;
        case RF_NORMALIZE_NONE: return RF_FILM_PLAIN;
    }
    return RF_FILM_CROSSFIT;
}

static bool note_finished( RfRenderer* r, const LiveFilm* live, double relmse )
{
    double weight = live->film.weight[0] + live->film.weight[1];
    return rf_note_finished( &r->stop, ( RfFrameNoise ){ .frame = live->frame,
                                                         .passes = live->film.passes[0] + live->film.passes[1],
                                                         .weight = weight,
                                                         .noise = relmse * weight,
                                                         .seen = weight } );
}

static RfResult finish_film( RfRenderer* r, LiveFilm* live, RfError* error )
{
    RfFilmCombine combine = rf_film_combine( r->settings.normalize );
    RfFrameBuffer* buffer = rf_next_frame_buffer( &r->delivery );
    rf_combine_film( &live->film, combine, buffer->rgb, buffer->weight );
    double now = rf_wall_seconds(), pixels = (double)r->sizes.width * (double)r->sizes.height;
    buffer->result = ( RfFrameResult ){
        .frame = live->frame,
        .width = r->sizes.width,
        .height = r->sizes.height,
        .rgb = buffer->rgb,
        .weight = buffer->weight,
        .seconds = now - r->last_frame,
        .relmse_estimate = rf_estimate_relmse( &live->film, combine, buffer->rgb ),
        .native_spp = live->film.passes[0] + live->film.passes[1] + (double)live->film.extra_samples / pixels,
        .effective_spp = (double)live->film.landed / pixels,
    };
    buffer->result.reached = !rf_is_stopping( &r->settings ) || note_finished( r, live, buffer->result.relmse_estimate );
    r->last_relmse = buffer->result.relmse_estimate;
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
    {
        buffer->result.layers[l] = buffer->layers[l];
        if ( buffer->layers[l] != NULL )
            rf_finish_aov( &live->layers, (RfAov)l, &live->film, combine, buffer->layers[l] );
    }
    r->last_frame = now;
    live->frame = -1;
    r->frames_done += 1;
    rf_queue_frame( &r->delivery );
    return rf_check_frame_queue( &r->delivery, error );
}

RfResult rf_close_films( RfRenderer* r, int window, RfError* error )
{
    RfGroup group = rf_group( &r->plan, window );
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        int first, last;
        rf_groups_of_frame( &r->plan, frame, &first, &last );
        if ( last != window || !asked_for( r, frame ) )
            continue;
        RfResult result = finish_film( r, rf_find_film( r, frame ), error );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

bool rf_group_wanted( const RfRenderer* r, RfGroup window )
{
    bool wanted = false;
    for ( int frame = window.first; frame < window.first + window.eyes && !wanted; ++frame )
        wanted = asked_for( r, frame );
    return wanted;
}

void rf_add_aovs( const RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int eye, const RfHarvestScratch* scratch )
{
    int frame = harvest->first_frame + eye;
    LiveFilm* live = rf_find_film( r, frame );
    if ( live == NULL )
        return;
    RfAovJob job = {
        .film = &live->layers,
        .eye = r->eyes + frame,
        .previous = frame > 0 ? r->eyes + frame - 1 : NULL,
        .next = frame + 1 < r->plan.frames ? r->eyes + frame + 1 : NULL,
        .weight = (float)window->weight,
        .weight_before = (float)( live->film.weight[0] + live->film.weight[1] ),
    };
    rf_add_to_aovs( &job, scratch );
}
