#include "render/ahead.h"

#include "base/random.h"
#include "base/system.h"
#include "film/film_flicker.h"
#include "render/set_up.h"
#include "render/frames.h"
#include "render/pass.h"

#include <math.h>
#include <stdlib.h>

#define EYES 2             // of a group that is looked at, at most
#define APART 7            // frames from place to place, at least
#define FIRST_PIXELS 512.0 // of a picture in the first round,
#define MOST_PIXELS 9216.0 // and in the second
#define LEAST_PIXELS 256.0 // less tells nothing
#define PASSES 4
#define MOST_PASSES 64
#define SHARE 0.008 // of the work of the render, as the first round predicts it
#define AHEAD_SEED 0x61686561

// All is looked at twice, with other random numbers: what differs is chance.
enum
{
    TRIES = 2
};

typedef struct Look
{
    RfRenderer* r;
    double pixels;
    int passes, eye_count;
    int runs; // so far
    double weight[TRIES];
    RfStopPlace places[RF_STOP_PLACES][TRIES];
} Look;

// The same eye with a film of about so many pixels.
static RfEye shrink( const RfEye* eye, double pixels )
{
    double scale = fmin( sqrt( pixels / ( (double)eye->width * eye->height ) ), 1.0 );
    RfEye out = *eye;
    out.width = (int)fmax( floor( scale * eye->width + 0.5 ), 1.0 );
    out.height = (int)fmax( floor( scale * eye->height + 0.5 ), 1.0 );
    float x = (float)out.width / (float)eye->width, y = (float)out.height / (float)eye->height;
    out.focal_x *= x;
    float* across[] = { &out.axis_x, &out.open.axis_x, &out.close.axis_x };
    float* down[] = { &out.focal, &out.axis_y, &out.open.focal, &out.open.axis_y, &out.close.focal, &out.close.axis_y };
    for ( size_t i = 0; i < sizeof across / sizeof *across; ++i )
        *across[i] *= x;
    for ( size_t i = 0; i < sizeof down / sizeof *down; ++i )
        *down[i] *= y;
    return out;
}

// Told as the render's own progress, of which nothing is done yet.
static bool pass_on( void* user, const RfProgress* inner )
{
    RfRenderer* r = user;
    if ( r->callbacks.progress == NULL )
        return true;
    RfProgress progress = {
        .frames_all = r->frames_all,
        .left = (double)NAN,
        .samples = r->stop.ahead.samples + inner->samples,
        .seconds = rf_wall_seconds() - r->start,
        .relmse = (double)NAN,
        .flicker = (double)NAN,
    };
    return r->callbacks.progress( r->callbacks.user, &progress );
}

static RfRenderSettings settings_of( const Look* look, int eyes, int place )
{
    RfRenderSettings s = look->r->settings;
    s.noise = s.flicker = s.time = 0.0;
    s.spp = look->passes;
    s.group = eyes / 2;
    s.adaptive = RF_ADAPTIVE_OFF;
    s.aovs = 0;
    s.files = ( RfFrameFiles ){ 0 };
    s.queue = 0;
    s.pieces = NULL;
    s.seed = rf_mix64( s.seed + (uint64_t)( AHEAD_SEED + look->runs * RF_STOP_PLACES + place ) );
    return s;
}

static RfResult render_passes( RfRenderer* r, RfError* error )
{
    RfGroup group = rf_group( &r->plan, 0 );
    RfEstimatorGroup estimator_group = rf_estimator_group( r, 0 );
    estimator_group.shared = r->memory.shared;
    rf_open_films( r, 0 );
    RfResult result = RF_OK;
    for ( int k = 0; k < group.passes && result == RF_OK; ++k )
    {
        RfPass pass = rf_make_pass( &estimator_group, &group, k );
        result = rf_render_pass( r, &pass, error );
    }
    return result;
}

// Means over the frames of the group, and over its pairs. Without its ten worst pixels a small picture tells more of how
// noise changes along the path.
static RfStopPlace measure( RfRenderer* r, bool pairs )
{
    RfFilmCombine combine = rf_film_combine( r->settings.normalize );
    RfStopPlace sum = { 0 };
    int eyes = r->plan.eyes;
    for ( int i = 0; i < eyes; ++i )
    {
        RfLiveFilm* live = rf_find_film( r, i );
        RfRelmse relmse = rf_finish_picture( r, live, &( RfPicture ){ .rgb = r->memory.buffers->rgb } );
        sum.noise += ( 1.0 - relmse.worst_share ) * relmse.likely * r->settings.spp / eyes;
        if ( i + 1 == eyes || !pairs )
            continue;
        RfFlicker f = rf_flicker_of_films( live->films, rf_find_film( r, i + 1 )->films, combine );
        sum.variance += 0.5 * ( f.before + f.now ) * r->settings.spp / ( eyes - 1 );
        sum.apart += 0.5 * rf_flicker_f1_squared( &f ) * r->settings.spp / ( eyes - 1 );
    }
    return sum;
}

static double weight_of( const Look* look ) { return look->pixels * look->passes; }

// The mean with what was found before.
static void add( RfStopPlace* mean, RfStopPlace found, double before, double now )
{
    double t = now / ( before + now );
    mean->noise += t * ( found.noise - mean->noise );
    mean->variance += t * ( found.variance - mean->variance );
    mean->apart += t * ( found.apart - mean->apart );
}

// In a small picture neighbours move by fewer pixels. Frames that are as many times farther apart move by as many as those
// of the render do.
static int frame_of( const Look* look, int centre, int i )
{
    const RfGroupPlan* plan = &look->r->plan;
    double film = (double)look->r->eyes->width * look->r->eyes->height;
    int step = (int)fmax( floor( sqrt( film / look->pixels ) + 0.5 ), 1.0 ), most = ( plan->frames - 1 ) / ( EYES - 1 );
    step = step < most ? step : most > 1 ? most : 1;
    int reach = step * ( look->eye_count - 1 ), first = centre - reach / 2, last = plan->frames - 1 - reach;
    return ( first < 0 ? 0 : first > last ? last : first ) + i * step;
}

// Renders a small group around a place of the path.
static RfResult look_at( Look* look, int number, RfError* error )
{
    RfRenderer* outer = look->r;
    RfStopAhead* ahead = &outer->stop.ahead;
    int eyes = look->eye_count, frames[EYES], try = look->runs % TRIES;
    RfEye small[EYES];
    for ( int i = 0; i < eyes; ++i )
    {
        frames[i] = i;
        small[i] = shrink( outer->eyes + frame_of( look, ahead->places[number].frame, i ), look->pixels );
    }
    RfRenderer r = { .tracer = outer->tracer,
                     .eyes = small,
                     .frames = frames,
                     .frames_all = eyes,
                     .settings = settings_of( look, eyes, number ),
                     .callbacks = { .user = outer, .progress = pass_on },
                     .kept_frame = RF_NO_FRAME };
    RfResult result = rf_set_up_render( &r, eyes, error );
    r.batches_all = (double)INFINITY;
    if ( result == RF_OK )
        result = rf_alloc_render( &r, error );
    if ( result == RF_OK )
        result = render_passes( &r, error );
    if ( result == RF_OK )
        add( look->places[number] + try, measure( &r, outer->stop.goals.flicker > 0.0 ), look->weight[try], weight_of( look ) );
    ahead->samples += (double)r.rays.primary;
    free( r.traced_jobs );
    rf_free_render_memory( &r.sizes, &r.memory );
    return result;
}

// All places, twice.
static RfResult look_around( Look* look, RfError* error )
{
    RfRenderer* r = look->r;
    RfResult result = RF_OK;
    for ( int k = 0; k < TRIES; ++k )
    {
        for ( int i = 0; i < r->stop.ahead.count && result == RF_OK; ++i )
            result = look_at( look, i, error );
        look->weight[look->runs++ % TRIES] += weight_of( look );
    }
    return result;
}

// The places: from the first of the frames asked for to the last.
static void choose_places( RfRenderer* r )
{
    RfStopAhead* ahead = &r->stop.ahead;
    int most = 1 + ( r->frames_all - 1 ) / APART;
    ahead->count = most < RF_STOP_PLACES ? most : RF_STOP_PLACES;
    for ( int i = 0; i < ahead->count; ++i )
    {
        int at = ahead->count > 1 ? (int)( (int64_t)i * ( r->frames_all - 1 ) / ( ahead->count - 1 ) ) : 0;
        ahead->places[i] = ( RfStopPlace ){ .frame = r->frames[at] };
    }
}

// One of the three figures of a place.
static double* figure_of( RfStopPlace* place, int which )
{
    return which == 0 ? &place->noise : which == 1 ? &place->variance : &place->apart;
}

// A figure at all places: its logarithms are drawn towards their mean, by as much of their variance as is chance.
static void settle( Look* look, int which )
{
    RfStopAhead* ahead = &look->r->stop.ahead;
    double mean = 0.0, chance = 0.0, all = 0.0, n = ahead->count, value[RF_STOP_PLACES];
    for ( int i = 0; i < ahead->count; ++i )
    {
        double a = *figure_of( look->places[i], which ), b = *figure_of( look->places[i] + 1, which );
        value[i] = log( 0.5 * ( a + b ) );
        if ( !( a > 0.0 && b > 0.0 && isfinite( value[i] ) ) )
            return; // all stay 0: nothing is known
        mean += value[i] / n;
        chance += 0.25 * log( a / b ) * log( a / b ) / n;
    }
    for ( int i = 0; i < ahead->count; ++i )
        all += ( value[i] - mean ) * ( value[i] - mean ) / ( n - 1.0 );
    double kept = all > 0.0 ? fmax( 1.0 - chance / all, 0.0 ) : 0.0;
    for ( int i = 0; i < ahead->count; ++i )
        *figure_of( ahead->places + i, which ) = exp( mean + kept * ( value[i] - mean ) );
}

static void settle_all( Look* look )
{
    for ( int which = 0; which < 3; ++which )
        settle( look, which );
}

// A second round, if the first predicts a render that is worth it.
static RfResult look_closer( Look* look, RfError* error )
{
    RfRenderer* r = look->r;
    double film = (double)r->eyes->width * r->eyes->height, all = film * rf_expected_samples( &r->stop, r->frames_all );
    double each = ( SHARE * all - r->stop.ahead.samples ) / ( TRIES * r->stop.ahead.count * (double)look->eye_count );
    if ( !( each > PASSES * FIRST_PIXELS ) )
        return RF_OK;
    look->pixels = fmin( fmin( MOST_PIXELS, 0.25 * film ), each / PASSES );
    look->passes = (int)fmin( each / look->pixels, MOST_PASSES );
    return look_around( look, error );
}

static RfResult look_twice( Look* look, RfError* error )
{
    RfResult result = look_around( look, error );
    if ( result != RF_OK )
        return result;
    settle_all( look );
    result = look_closer( look, error );
    settle_all( look );
    return result;
}

RfResult rf_look_ahead( RfRenderer* r, RfError* error )
{
    bool predicts = r->settings.noise > 0.0 || r->settings.flicker > 0.0;
    if ( !predicts || r->callbacks.progress == NULL ) // nobody is reported
        return RF_OK;
    double start = rf_wall_seconds();
    Look look = { .r = r, .passes = PASSES, .eye_count = r->plan.eyes < EYES ? r->plan.eyes : EYES };
    look.pixels = fmin( FIRST_PIXELS, 0.25 * r->eyes->width * r->eyes->height );
    choose_places( r );
    RfResult result = rf_alloc_forecast( r->plan.frames, &r->forecast, error );
    if ( result == RF_OK && r->stop.ahead.count > 1 && look.pixels >= LEAST_PIXELS )
        result = look_twice( &look, error );
    else
        r->stop.ahead.count = 0;
    if ( result == RF_ERROR_MEMORY && r->forecast.frames != NULL ) // then without
    {
        r->stop.ahead.count = 0;
        result = RF_OK;
    }
    r->stop.ahead.seconds = rf_wall_seconds() - start;
    return result;
}
