// Saves and loads the state of a render. One function goes through it for both, so that they cannot disagree.
#include "render/state.h"

#include "base/system.h"

#include <string.h>

// What the sizes of the rest depend on. It has no padding.
typedef struct Shape
{
    int32_t width, height, films, live, frames, of_sweep;
    uint32_t aovs, adaptive, paired, stopping, cryptomatte, covering;
    uint64_t split, stop;
} Shape;

typedef struct Stream
{
    RfRenderer* r;
    bool loading;
    size_t* counted; // instead of moving
    RfResult result;
    RfError* error;
} Stream;

static void move( Stream* s, void* bytes, size_t size )
{
    const RfRenderCallbacks* callbacks = &s->r->setup->callbacks;
    if ( s->counted != NULL )
        *s->counted += size;
    if ( s->counted != NULL || s->result != RF_OK || size == 0 )
        return;
    s->result = s->loading ? callbacks->load( callbacks->user, bytes, size, s->error )
                           : callbacks->save( callbacks->user, bytes, size, s->error );
}

#define MOVE( s, value ) move( s, &( value ), sizeof( value ) )

static RfResult fail_other( RfError* error )
{
    return rf_fail( error, RF_ERROR_USAGE, "the films that were kept are of other frames or settings, or of another build" );
}

typedef struct Walk
{
    RfMemoryWalk walk;
    Stream* stream;
} Walk;

static void move_block( RfMemoryWalk* walk, const char* name, size_t bytes, void** block )
{
    (void)name;
    move( ( (Walk*)walk )->stream, *block, bytes );
}

static void move_film( Stream* s, RfFilm* film )
{
    MOVE( s, film->block );
    MOVE( s, film->passes );
    MOVE( s, film->weight );
    MOVE( s, film->held );
    MOVE( s, film->landed );
    MOVE( s, film->extra_samples );
}

static void move_live_film( Stream* s, RfLiveFilm* live )
{
    const RfRenderSizes* sizes = &s->r->setup->sizes;
    MOVE( s, live->frame );
    MOVE( s, live->noise );
    MOVE( s, live->flicker );
    MOVE( s, live->noise_seen );
    MOVE( s, live->pair );
    MOVE( s, live->most_need );
    MOVE( s, live->most_glints );
    for ( int f = 0; f < sizes->film_count; ++f )
        move_film( s, live->films + f );
    Walk walk = { .walk = { .take = move_block, .sizes = sizes }, .stream = s };
    rf_walk_film_arrays( &walk.walk, live );
    live->aovs.filter = sizes->filtered ? &s->r->setup->filter : NULL;
}

// The clock goes on from where it was.
static void move_times( Stream* s )
{
    RfRenderer* r = s->r;
    double now = rf_wall_seconds(), elapsed[2] = { now - r->start, now - r->last_frame };
    MOVE( s, elapsed );
    r->start = now - elapsed[0];
    r->last_frame = now - elapsed[1];
}

// The camera path stays this render's.
static void move_stop( Stream* s )
{
    RfRenderer* r = s->r;
    if ( !r->setup->sizes.stopping )
        return;
    RfStop stop = r->stop;
    stop.rule.plan.cameras = NULL;
    MOVE( s, stop );
    stop.rule.plan.cameras = r->stop.rule.plan.cameras;
    r->stop = stop;
    MOVE( s, r->until.done );
    MOVE( s, r->until.next );
    MOVE( s, r->until.due );
    MOVE( s, r->until.estimates.group );
    MOVE( s, r->until.estimates.done );
    MOVE( s, r->until.estimates.count );
    if ( s->result == RF_OK && (unsigned)r->until.estimates.count > (unsigned)r->memory.film_slots )
        s->result = fail_other( s->error );
    move( s, r->memory.noise_estimates, (size_t)r->until.estimates.count * sizeof *r->memory.noise_estimates );
    r->until.estimates.frames = r->memory.noise_estimates;
}

static void move_renderer( Stream* s )
{
    RfRenderer* r = s->r;
    MOVE( s, r->at );
    MOVE( s, r->rays );
    MOVE( s, r->batches_done );
    MOVE( s, r->batches_all );
    MOVE( s, r->share );
    MOVE( s, r->kept_frame );
    move( s, r->memory.kept_errors,
          r->memory.kept_errors != NULL ? RF_KEPT_FLOATS * rf_film_pixels( &r->setup->sizes ) * sizeof( float ) : 0 );
    move_times( s );
    move_stop( s );
}

static Shape shape_of( const RfRenderer* r )
{
    const RfRenderSizes* sizes = &r->setup->sizes;
    int done = r->frames_done, first = (int)( r->sweep.frames - r->setup->shot.frames );
    Shape shape = {
        .width = sizes->width,
        .height = sizes->height,
        .films = sizes->film_count,
        .frames = r->setup->shot.frame_count - done,
        .of_sweep = first + r->sweep.count - done,
        .aovs = sizes->aovs,
        .adaptive = sizes->adaptive,
        .paired = sizes->paired,
        .stopping = sizes->stopping,
        .cryptomatte = sizes->cryptomatte,
        .covering = sizes->covering,
        .split = sizes->of_estimator.splits,
        .stop = sizeof( RfStop ),
    };
    for ( int i = 0; i < r->memory.film_slots; ++i )
        shape.live += r->memory.films[i].frame != -1;
    return shape;
}

size_t rf_state_bytes( RfRenderer* r )
{
    size_t shared = 0, film = 0;
    move_renderer( &( Stream ){ .r = r, .counted = &shared } );
    move_live_film( &( Stream ){ .r = r, .counted = &film }, r->memory.films );
    film += sizeof *r->memory.noise_estimates; // of which there may be more later
    return sizeof( Shape ) + (size_t)r->setup->shot.frame_count * sizeof( int ) + shared + (size_t)r->memory.film_slots * film;
}

RfResult rf_save_state( RfRenderer* r, RfError* error )
{
    Stream s = { .r = r, .error = error };
    Shape shape = shape_of( r );
    MOVE( &s, shape );
    move( &s, (void*)( r->setup->shot.frames + r->frames_done ), (size_t)shape.frames * sizeof( int ) );
    move_renderer( &s );
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame != -1 )
            move_live_film( &s, r->memory.films + i );
    }
    return s.result;
}

// Are the frames that were left those that are asked for now?
static void check_frames( Stream* s )
{
    const RfShot* shot = &s->r->setup->shot;
    for ( int i = 0; i < shot->frame_count && s->result == RF_OK; ++i )
    {
        int frame = -1;
        MOVE( s, frame );
        if ( s->result == RF_OK && frame != shot->frames[i] )
            s->result = fail_other( s->error );
    }
}

static RfResult check_shape( const RfRenderer* r, const Shape* shape, RfError* error )
{
    Shape mine = shape_of( r );
    mine.live = shape->live;
    mine.of_sweep = shape->of_sweep;
    if ( memcmp( shape, &mine, sizeof mine ) != 0 || shape->of_sweep < 1 || shape->of_sweep > shape->frames )
        return fail_other( error );
    if ( shape->live > r->memory.film_slots )
        return rf_fail( error, RF_ERROR_MEMORY,
                        "the films of %d frames were kept, and the budget has room for %d: allow more memory", shape->live,
                        r->memory.film_slots );
    return RF_OK;
}

RfResult rf_load_state( RfRenderer* r, RfError* error )
{
    Stream s = { .r = r, .loading = true, .error = error };
    Shape shape = { 0 };
    r->sweep = ( RfSweep ){ .frames = r->setup->shot.frames };
    MOVE( &s, shape );
    if ( s.result == RF_OK )
        s.result = check_shape( r, &shape, error );
    check_frames( &s );
    if ( s.result == RF_OK )
        move_renderer( &s );
    if ( s.result == RF_OK && (unsigned)r->at.group >= (unsigned)r->setup->plan.groups )
        s.result = fail_other( error );
    for ( int i = 0; i < shape.live && s.result == RF_OK; ++i )
        move_live_film( &s, r->memory.films + i );
    r->first_sweep = shape.of_sweep;
    r->resuming = true;
    return s.result;
}
