// Opens the films of a group's frames, closes those that no later group shares, and queues them.
#include "render/frames.h"

#include "base/system.h"
#include "film/film_error.h"
#include "render/adaptive/adaptive.h"
#include "render/pieces.h"
#include "render/specks.h"

#include <math.h>
#include <string.h>

// The frames are in ascending order.
bool rf_is_asked( const RfRenderer* r, int frame )
{
    int low = 0, end = r->sweep.count;
    while ( low < end )
    {
        int middle = low + ( end - low ) / 2;
        if ( r->sweep.frames[middle] == frame )
            return true;
        if ( r->sweep.frames[middle] < frame )
            low = middle + 1;
        else
            end = middle;
    }
    return false;
}

void rf_open_films( RfRenderer* r, int number )
{
    RfGroup group = rf_group( &r->setup->plan, number );
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        int first, last;
        rf_groups_of_frame( &r->setup->plan, frame, &first, &last );
        if ( first != number || !rf_is_asked( r, frame ) )
            continue;
        RfLiveFilm* live = rf_find_film( r, -1 );
        live->frame = frame;
        live->noise = live->flicker = live->noise_seen = 0.0;
        live->pair = ( RfPairNoise ){ .variance = (double)NAN, .covariance = (double)NAN };
        for ( int f = 0; f < r->setup->sizes.film_count; ++f )
            if ( r->setup->settings.pieces != NULL )
                rf_clear_traced( r->setup->settings.pieces, frame, live->films + f );
            else
                rf_clear_film( live->films + f );
        live->aovs.filter = r->setup->sizes.filtered ? &r->setup->filter : NULL;
        rf_clear_aov_film( &live->aovs, r->setup->sizes.width, r->setup->sizes.height );
        if ( live->covering != NULL )
            memset( live->covering, 0, rf_film_pixels( &r->setup->sizes ) * sizeof *live->covering );
        if ( r->setup->sizes.adaptive )
            rf_run_pilot( r, live );
    }
}

static RfMissed note_finished( RfRenderer* r, const RfLiveFilm* live, const RfFilm* film, const RfRelmse* relmse,
                               const RfFlicker* flicker )
{
    double weight = film->weight[0] + film->weight[1];
    bool judged = r->setup->callbacks.judge != NULL && r->setup->settings.noise > 0.0 && live->noise_seen == weight;
    return rf_note_finished( &r->stop,
                             ( RfFrameNoise ){ .frame = live->frame,
                                               .pair = live->pair,
                                               .passes = film->passes[0] + film->passes[1],
                                               .weight = weight,
                                               .noise = judged ? live->noise : rf_prudent_relmse( relmse ) * weight,
                                               .flicker = rf_flicker_doubt( flicker ) * rf_flicker_f1_squared( flicker ) * weight,
                                               .seen = weight } );
}

// The flicker since the frame before, unknown where that was not rendered or is of another shot; keeps the error of this one for the next.
static RfFlicker take_flicker( RfRenderer* r, const RfLiveFilm* live )
{
    RfNormalize normalize = r->setup->settings.normalize;
    RfFlicker flicker = { .before = (double)NAN, .now = (double)NAN, .product = (double)NAN, .worst_share = (double)NAN };
    if ( !r->setup->sizes.paired )
        return flicker;
    if ( rf_is_kept_before( r, live->frame ) )
        flicker = rf_flicker_since( r->memory.kept_errors, live->films, normalize );
    rf_keep_film_error( live->films, normalize, r->memory.kept_errors );
    r->kept_frame = live->frame;
    return flicker;
}

void rf_finish_aovs( const RfRenderer* r, const RfLiveFilm* live, unsigned aovs, RfFrameBuffer* buffer )
{
    // what several films make up is divided by counts
    bool made = r->setup->settings.estimator->finish != NULL;
    RfNormalize normalize = made ? RF_NORMALIZE_RATIO : r->setup->settings.normalize;
    const RfFilm* pass = live->films + rf_first_pass_film( &r->setup->sizes );
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
    {
        float* to = ( aovs & RF_AOV_BIT( a ) ) != 0 ? buffer->layers[a] : NULL;
        bool splits = buffer->layers[a] != NULL && ( RF_PASS_AOVS & RF_AOV_BIT( a ) ) != 0;
        buffer->result.aovs[a] = to;
        if ( to != NULL && splits )
            rf_combine_part( live->films, pass, normalize, to );
        else if ( to != NULL && !( made && a == RF_AOV_VARIANCE ) )
            rf_finish_aov( &live->aovs, (RfAov)a, live->films, normalize, to );
        pass += splits;
    }
}

// Images of light groups. Of pieces, the rest of the picture is not known.
static void finish_groups( const RfRenderer* r, const RfLiveFilm* live, RfFrameBuffer* buffer )
{
    int count = r->setup->sizes.group_films, first = r->setup->sizes.film_count - count;
    buffer->result.layers = buffer->list;
    if ( r->setup->settings.pieces != NULL )
        return;
    for ( int g = 0; g < count; ++g )
    {
        rf_combine_part( live->films, live->films + first + g, r->setup->settings.normalize, buffer->groups[g] );
        buffer->list[g] =
            ( RfLayer ){ .name = r->setup->group_names[g], .letters = "RGB", .values = buffer->groups[g], .half = true };
    }
    buffer->result.layer_count = count;
}

double rf_native_spp( const RfRenderer* r, const RfFilm* film )
{
    return film->passes[0] + film->passes[1] + (double)film->extra_samples / (double)rf_film_pixels( &r->setup->sizes );
}

// `shared` are the seconds that the frame has of those which its group took.
static RfResult finish_film( RfRenderer* r, RfLiveFilm* live, double shared, RfError* error )
{
    const RfFilm* film = live->films;
    RfFrameBuffer* buffer = rf_next_frame_buffer( &r->queue );
    RfPicture picture = { .rgb = buffer->rgb, .weight = buffer->weight, .variance = buffer->layers[RF_AOV_VARIANCE] };
    RfRelmse relmse = rf_finish_picture( r, live, &picture );
    RfFlicker flicker = take_flicker( r, live );
    double now = rf_wall_seconds(), pixels = (double)r->setup->sizes.width * (double)r->setup->sizes.height;
    bool removes = rf_first_pass_film( &r->setup->sizes ) > r->setup->settings.estimator->films;
    buffer->result = ( RfFrameResult ){
        .frame = live->frame,
        .width = r->setup->sizes.width,
        .height = r->setup->sizes.height,
        .rgb = buffer->rgb,
        .weight = buffer->weight,
        .seconds = shared + ( now - r->last_frame ),
        .relmse_estimate = rf_reported_relmse( &relmse ),
        .relmse_is_lower_bound = relmse.is_lower_bound,
        .relmse_likely = relmse.likely,
        .worst_ten_share = relmse.worst_share,
        .solved = picture.solved,
        .clamp = r->clamps != NULL ? (double)r->clamps[live->frame].threshold[RF_CLAMP_PATHS] : 0.0,
        .clamp_chains = r->clamps != NULL ? (double)r->clamps[live->frame].threshold[RF_CLAMP_CHAINS] : 0.0,
        .removes = removes,
        // of pieces, the rest of the picture is not known
        .removed = removes && r->setup->settings.pieces == NULL
                       ? rf_removed_share( live->films, r->setup->settings.normalize, buffer->rgb )
                       : 0.0,
        .flicker_estimate = sqrt( fmax( rf_reported_flicker( &flicker ), 0.0 * flicker.now ) ),
        .flicker_is_lower_bound = rf_flicker_is_lower_bound( &flicker ),
        .flicker_likely = sqrt( fmax( rf_flicker_f1_squared( &flicker ), 0.0 * flicker.now ) ),
        .flicker_worst_ten_share = flicker.worst_share,
        .native_spp = rf_native_spp( r, film ),
        .effective_spp = (double)film->landed / pixels,
    };
    rf_find_specks( r, live, &relmse.specks, &buffer->result.specks );
    RfMissed missed = { false, false };
    if ( r->setup->sizes.stopping )
        missed = note_finished( r, live, film, &relmse, &flicker );
    buffer->result.noise_missed = missed.noise;
    buffer->result.flicker_missed = missed.flicker;
    buffer->result.reached = !missed.noise && !missed.flicker;
    r->last_flicker = buffer->result.flicker_estimate;
    r->last_flicker_is_lower_bound = buffer->result.flicker_is_lower_bound;
    r->last_relmse = buffer->result.relmse_estimate;
    r->last_is_lower_bound = relmse.is_lower_bound;
    rf_finish_aovs( r, live, ~0u, buffer );
    finish_groups( r, live, buffer );
    rf_finish_surfaces( r, live, buffer );
    r->last_frame = now;
    live->frame = -1;
    r->frames_done += 1;
    r->adaptive_frames += film->extra_samples > 0;
    rf_queue_frame( &r->queue );
    return rf_check_frame_queue( &r->queue, error );
}

// Is this the last group of a frame that was asked for?
static bool is_closed_by( const RfRenderer* r, int number, int frame )
{
    int first, last;
    rf_groups_of_frame( &r->setup->plan, frame, &first, &last );
    return last == number && rf_is_asked( r, frame );
}

// The time of a group that finishes several frames is shared among them equally.
static double share_seconds( RfRenderer* r, int number, RfGroup group )
{
    int count = 0;
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
        count += is_closed_by( r, number, frame );
    if ( count == 0 )
        return 0.0;
    double now = rf_wall_seconds(), spent = now - r->last_frame;
    r->last_frame = now;
    return spent / count;
}

RfResult rf_close_films( RfRenderer* r, int number, RfError* error )
{
    RfGroup group = rf_group( &r->setup->plan, number );
    double shared = share_seconds( r, number, group );
    for ( int frame = group.first; frame < group.first + group.eyes; ++frame )
    {
        if ( !is_closed_by( r, number, frame ) )
            continue;
        RfResult result = finish_film( r, rf_find_film( r, frame ), shared, error );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

bool rf_group_wanted( const RfRenderer* r, RfGroup group )
{
    bool wanted = false;
    for ( int frame = group.first; frame < group.first + group.eyes && !wanted; ++frame )
        wanted = rf_is_asked( r, frame );
    return wanted;
}

RfNoisyFrame rf_noisy_frame( const RfFrameResult* frame )
{
    return ( RfNoisyFrame ){ .width = frame->width,
                             .height = frame->height,
                             .rgb = frame->rgb,
                             .half = frame->aovs[RF_AOV_HALF],
                             .albedo = frame->aovs[RF_AOV_DENOISE_ALBEDO],
                             .normal = frame->aovs[RF_AOV_DENOISE_NORMAL],
                             .passes = frame->native_spp };
}
