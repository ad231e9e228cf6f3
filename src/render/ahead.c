#include "render/ahead.h"

#include "base/random.h"
#include "base/system.h"
#include "film/film_flicker.h"
#include "render/set_up.h"
#include "render/forecast.h"
#include "render/frames.h"
#include "render/pair_rule.h"
#include "render/pass.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define EYES 5               // of a group that is looked at, at most
#define FIRST_PIXELS 1024.0  // of a picture in the first round,
#define FIRST_PASSES 4       // and passes
#define MOST_PIXELS 9216.0   // in the second
#define MOST_PASSES 64
#define LEAST_PIXELS 256.0
#define SMALLER 4.0          // times fewer pixels than those of the render, at least
#define SHARE 0.01           // of the work of the render
#define AHEAD_SEED 0x61686561

typedef struct Look
{
    RfRenderer* r;
    RfEye* eyes;  // of the whole path, with a smaller film
    double pixels;
    int passes;
    int round;
    double* weights; // of places
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
    out.focal *= y;
    out.axis_x *= x;
    out.axis_y *= y;
    RfPose* poses[] = { &out.open, &out.close };
    for ( int i = 0; i < 2; ++i )
    {
        poses[i]->focal *= y;
        poses[i]->axis_x *= x;
        poses[i]->axis_y *= y;
    }
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
    s.hold_all = false;
    s.pieces = NULL;
    s.seed = rf_mix64( s.seed + (uint64_t)( AHEAD_SEED + look->round * RF_STOP_PLACES + place ) );
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

// Means over the frames of the group, and over its pairs.
static void measure( RfRenderer* r, RfStopPlace* place, double weight )
{
    RfFilmCombine combine = rf_film_combine( r->settings.normalize );
    double noise = 0.0, variance = 0.0, covariance = 0.0;
    int eyes = r->plan.eyes;
    for ( int i = 0; i < eyes; ++i )
    {
        RfLiveFilm* live = rf_find_film( r, i );
        RfRelmse relmse = rf_finish_picture( r, live, &( RfPicture ){ .rgb = r->memory.buffers->rgb } );
        noise += relmse.likely * r->settings.spp / eyes;
        if ( i + 1 == eyes )
            break;
        RfFlicker f = rf_flicker_of_films( live->films, rf_find_film( r, i + 1 )->films, combine );
        variance += 0.5 * ( f.before + f.now ) * r->settings.spp / ( eyes - 1 );
        covariance += f.product * r->settings.spp / ( eyes - 1 );
    }
    double all = place->weight + weight;
    place->noise += ( noise - place->noise ) * weight / all;
    place->pair.variance += ( variance - place->pair.variance ) * weight / all;
    place->pair.covariance += ( covariance - place->pair.covariance ) * weight / all;
    place->weight = all;
    const RfRayCounts* rays = &r->rays;
    place->rays = (double)( rays->primary + rays->path + rays->shadow + rays->tile + rays->eye ) / fmax( (double)rays->primary, 1.0 );
}

// Renders a small group around a place of the path.
static RfResult look_at( const Look* look, int number, RfError* error )
{
    RfRenderer* outer = look->r;
    RfStopAhead* ahead = &outer->stop.ahead;
    int eyes = outer->plan.eyes < EYES ? outer->plan.eyes : EYES, frames[EYES];
    int first = ahead->places[number].frame - eyes / 2, last = outer->plan.frames - eyes;
    first = first < 0 ? 0 : first > last ? last : first;
    for ( int i = 0; i < eyes; ++i )
        frames[i] = i;
    RfRenderer r = { .tracer = outer->tracer,
                     .eyes = look->eyes + first,
                     .frames = frames,
                     .frames_all = eyes,
                     .settings = settings_of( look, eyes, number ),
                     .callbacks = { .user = outer, .progress = pass_on },
                     .kept_frame = RF_NO_FRAME };
    RfResult result = rf_set_up_render( &r, eyes, error );
    r.batches_all = INFINITY;
    if ( result == RF_OK )
        result = rf_alloc_render( &r, error );
    if ( result == RF_OK )
        result = render_passes( &r, error );
    if ( result == RF_OK )
        measure( &r, ahead->places + number, look->passes * (double)r.sizes.width * r.sizes.height );
    ahead->samples += (double)r.rays.primary;
    free( r.traced_jobs );
    rf_free_render_memory( &r.sizes, &r.memory );
    return result;
}

static RfResult look_around( Look* look, RfError* error )
{
    RfRenderer* r = look->r;
    for ( int i = 0; i < r->plan.frames; ++i )
        look->eyes[i] = shrink( r->eyes + i, look->pixels );
    RfResult result = RF_OK;
    for ( int i = 0; i < r->stop.ahead.count && result == RF_OK; ++i )
        result = look_at( look, i, error );
    look->round += 1;
    return result;
}

// The places: from the first of the frames asked for to the last.
static void choose_places( RfRenderer* r )
{
    RfStopAhead* ahead = &r->stop.ahead;
    int eyes = r->plan.eyes, most = 1 + ( r->frames_all - 1 ) / eyes * 2;
    ahead->count = most < RF_STOP_PLACES ? most : RF_STOP_PLACES;
    for ( int i = 0; i < ahead->count; ++i )
    {
        int at = ahead->count > 1 ? (int)( (int64_t)i * ( r->frames_all - 1 ) / ( ahead->count - 1 ) ) : 0;
        ahead->places[i] = ( RfStopPlace ){ .frame = r->frames[at] };
    }
}

RfResult rf_look_ahead( RfRenderer* r, RfError* error )
{
    if ( !( r->settings.noise > 0.0 || r->settings.flicker > 0.0 ) )
        return RF_OK;
    r->forecast = calloc( (size_t)r->plan.frames, sizeof *r->forecast );
    if ( r->forecast == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left to foretell %d frames", r->plan.frames );
    choose_places( r );
    RfStopAhead* ahead = &r->stop.ahead;
    double film = (double)r->eyes->width * r->eyes->height, start = rf_wall_seconds();
    Look look = { .r = r, .passes = FIRST_PASSES, .pixels = fmin( FIRST_PIXELS, film / SMALLER ) };
    look.eyes = malloc( (size_t)r->plan.frames * sizeof *look.eyes );
    if ( look.eyes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for %d eyes", r->plan.frames );
    RfResult result = look_around( &look, error );
    if ( result == RF_OK )
    {
        double samples = SHARE * film * rf_expected_samples( &r->stop, r->frames_all ) - ahead->samples;
        if (getenv("P21")) fprintf(stderr,"expected %g, first round %g, left %g, film %g\n", rf_expected_samples( &r->stop, r->frames_all ), ahead->samples, samples,film);
        double each = samples / ( ahead->count * (double)( r->plan.eyes < EYES ? r->plan.eyes : EYES ) );
        look.pixels = fmin( fmin( MOST_PIXELS, film / SMALLER ), each / FIRST_PASSES );
        look.passes = (int)fmin( each / look.pixels, MOST_PASSES );
        if ( look.pixels >= LEAST_PIXELS )
            result = look_around( &look, error );
    }
    free( look.eyes );
    ahead->seconds = rf_wall_seconds() - start;
    if (getenv("P21")) for ( int i = 0; i < ahead->count; ++i ) fprintf(stderr,"place %d: noise %g var %g cov %g f1 %g  rays %g\n", ahead->places[i].frame, ahead->places[i].noise,ahead->places[i].pair.variance,ahead->places[i].pair.covariance,ahead->places[i].pair.variance-ahead->places[i].pair.covariance,ahead->places[i].rays);
    if (getenv("P21")) fprintf(stderr,"samples %g of %g, %g s, px %g passes %d\n", ahead->samples, film*rf_expected_samples( &r->stop, r->frames_all ), ahead->seconds, look.pixels,look.passes);
    return result;
}
