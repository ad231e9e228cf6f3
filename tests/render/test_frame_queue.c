// Finished frames are handed over on a thread of their own (settings.queue): in order,
// while rendering continues, whatever stops it, and within the budget.
#include "support/render_support.h"
#include "support/test.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define EYES 7
#define WIDTH 33
#define HEIGHT 18

static const int s_all[EYES] = { 0, 1, 2, 3, 4, 5, 6 };

typedef struct Setup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[EYES];
} Setup;

static void begin( Setup* s )
{
    s->scene = make_room( ROOM_GGX );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, EYES, 3.0f, WIDTH, HEIGHT );
}

static void end( Setup* s )
{
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

static RfRenderSettings queued( int group, int queue )
{
    RfRenderSettings settings = small_settings( group, 6 );
    settings.queue = queue;
    return settings;
}

TEST( test_queue_changes_no_frame )
{
    Setup s;
    begin( &s );
    for ( int group = 0; group <= 2; group += 2 )
    {
        RfRenderSettings settings = queued( group, 0 );
        Rendered plain = render_all( s.tracer, s.eyes, EYES, &settings );
        for ( int queue = 1; queue <= 8; queue += 3 )
        {
            settings.queue = queue;
            Rendered again = render_all( s.tracer, s.eyes, EYES, &settings );
            assert_int_equal( again.count, EYES );
            assert_memory_equal( again.rgb, plain.rgb, 3 * plain.pixels * EYES * sizeof( float ) );
            assert_memory_equal( again.weight, plain.weight, plain.pixels * EYES * sizeof( float ) );
            free_rendered( &again );
        }
        free_rendered( &plain );
    }
    end( &s );
}

// What the two callbacks see of each other.
typedef struct Watch
{
    pthread_t renderer;
    atomic_int progress; // calls so far
    atomic_int frames;   // calls that have begun
    int wait_for;        // progress calls that the first frame waits for
    int fail_at;         // frame
    int stop_at;         // progress call
    bool timed_out;
    bool same_thread;
} Watch;

static void sleep_ms( long ms )
{
    struct timespec time = { 0, ms * 1000000 };
    nanosleep( &time, NULL );
}

static RfResult take_frame( void* user, const RfFrameResult* result, RfError* error )
{
    Watch* w = user;
    assert_int_equal( result->frame, atomic_fetch_add( &w->frames, 1 ) ); // in order
    w->same_thread = pthread_equal( pthread_self(), w->renderer ) != 0;
    for ( int ms = 0; result->frame == 0 && atomic_load( &w->progress ) < w->wait_for && !w->timed_out; ++ms )
    {
        sleep_ms( 1 );
        w->timed_out = ms > 600000; // a hang, on any machine
    }
    return result->frame == w->fail_at ? rf_fail( error, RF_ERROR_IO, "disk full" ) : RF_OK;
}

static bool count_progress( void* user, const RfProgress* progress )
{
    (void)progress;
    Watch* w = user;
    return atomic_fetch_add( &w->progress, 1 ) + 1 != w->stop_at;
}

static RfResult watch( const Setup* s, const RfRenderSettings* settings, Watch* w, RfError* error )
{
    w->renderer = pthread_self();
    RfRenderCallbacks callbacks = { .user = w, .frame = take_frame, .progress = count_progress };
    error->text[0] = 0;
    return rf_render( &( RfShot ){ s->tracer, s->eyes, EYES, s_all, EYES }, settings, &callbacks, NULL, error );
}

// The first frame's callback ends only after two more frames were rendered.
TEST( test_rendering_does_not_wait )
{
    Setup s;
    begin( &s );
    RfError error;
    RfRenderSettings settings = queued( 0, 2 ); // one chunk, so one report, a pass: 6 a frame
    Watch w = { .wait_for = 18, .fail_at = -1, .stop_at = -1 };
    assert_int_equal( watch( &s, &settings, &w, &error ), RF_OK );
    assert_false( w.timed_out );
    assert_false( w.same_thread );
    assert_int_equal( w.frames, EYES );
    assert_int_equal( w.progress, 6 * EYES );

    settings.queue = 0;
    w = ( Watch ){ .fail_at = -1, .stop_at = -1 };
    assert_int_equal( watch( &s, &settings, &w, &error ), RF_OK );
    assert_true( w.same_thread );
    end( &s );
}

TEST( test_failure_stops_the_render )
{
    Setup s;
    begin( &s );
    RfError error;
    for ( int queue = 0; queue <= 2; ++queue )
    {
        for ( int at = 0; at < EYES; at += 3 )
        {
            RfRenderSettings settings = queued( 1, queue );
            Watch w = { .fail_at = at, .stop_at = -1 };
            assert_int_equal( watch( &s, &settings, &w, &error ), RF_ERROR_IO );
            assert_string_equal( error.text, "disk full" );
            assert_int_equal( w.frames, at + 1 ); // none after it
        }
    }
    // long before the end: frame 0 of 7 fails, six passes a frame
    RfRenderSettings settings = queued( 0, 1 );
    Watch w = { .fail_at = 0, .stop_at = -1 };
    assert_int_equal( watch( &s, &settings, &w, &error ), RF_ERROR_IO );
    assert_true( w.progress <= 6 * EYES );
    end( &s );
}

// What is finished when somebody stops the render is handed over all the same,
// and if that fails, this is what is reported.
TEST( test_interruption_keeps_finished_frames )
{
    Setup s;
    begin( &s );
    RfError error;
    RfRenderSettings settings = queued( 0, 4 );
    Watch w = { .wait_for = 20, .fail_at = -1, .stop_at = 20 }; // in the fourth frame, while the first is written
    assert_int_equal( watch( &s, &settings, &w, &error ), RF_ERROR_INTERRUPTED );
    assert_false( w.timed_out );
    assert_int_equal( w.frames, 3 );
    w = ( Watch ){ .wait_for = 20, .fail_at = 1, .stop_at = 20 };
    assert_int_equal( watch( &s, &settings, &w, &error ), RF_ERROR_IO );
    assert_string_equal( error.text, "disk full" );
    assert_int_equal( w.frames, 2 );
    end( &s );
}

TEST( test_queue_keeps_the_budget )
{
    Setup s;
    begin( &s );
    RfRenderSettings settings = queued( 1, 0 );
    Rendered plain = render_all( s.tracer, s.eyes, EYES, &settings );
    size_t needed = plain.stats.peak_bytes, image = WIDTH * HEIGHT * 4 * sizeof( float );
    settings.queue = 4;
    Rendered more = render_all( s.tracer, s.eyes, EYES, &settings );
    assert_true( more.stats.peak_bytes >= needed + 3 * image && more.stats.peak_bytes < needed + 4 * image );
    free_rendered( &more );
    // what does not fit is not queued; less memory than without a queue is not needed
    for ( size_t memory = needed + 4 * image; memory + image / 3 > needed; memory -= image / 3 )
    {
        settings.memory = memory;
        Rendered again = render_all( s.tracer, s.eyes, EYES, &settings );
        assert_true( again.stats.peak_bytes <= memory );
        assert_memory_equal( again.rgb, plain.rgb, 3 * plain.pixels * EYES * sizeof( float ) );
        free_rendered( &again );
    }
    free_rendered( &plain );
    RfError error;
    settings.memory = 0;
    settings.queue = RF_MAX_QUEUE + 1;
    assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, s_all, EYES }, &settings, NULL, NULL, &error ),
                      RF_ERROR_USAGE );
    settings.queue = -1;
    assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, s_all, EYES }, &settings, NULL, NULL, &error ),
                      RF_ERROR_USAGE );
    settings.queue = 3; // nobody takes the frames
    assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, s_all, EYES }, &settings, NULL, NULL, &error ), RF_OK );
    end( &s );
}
