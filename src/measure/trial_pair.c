#include "measure/trial_pair.h"

#include "base/system.h"

#include <stdlib.h>
#include <string.h>

typedef struct Clock
{
    double samples, cpu, wall;
} Clock;

typedef struct Metered
{
    RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error );
    void* user;
    const RfTrialWatch* watch;
    bool one_thread;
    bool begun;
    Clock first, last;
    double callbacks; // CPU seconds spent in `frame`
} Metered;

static double cpu_seconds( const Metered* m ) { return m->one_thread ? rf_thread_seconds() : rf_process_seconds(); }

static bool on_progress( void* user, const RfProgress* progress )
{
    Metered* m = user;
    m->last = ( Clock ){ progress->samples, cpu_seconds( m ), rf_wall_seconds() };
    if ( !m->begun )
        m->first = m->last;
    m->begun = true;
    return m->watch == NULL || m->watch->should_continue == NULL || m->watch->should_continue( m->watch->user );
}

static RfResult on_frame( void* user, const RfFrameResult* frame, RfError* error )
{
    Metered* m = user;
    double start = cpu_seconds( m );
    RfResult result = m->frame( m->user, frame, error );
    m->callbacks += cpu_seconds( m ) - start;
    return result;
}

RfResult rf_render_metered( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                            RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error ), void* user,
                            const RfTrialWatch* watch, RfTrialMeter* meter, RfError* error )
{
    Metered m = { .frame = frame, .user = user, .watch = watch, .one_thread = settings->threads == 1 };
    RfRenderCallbacks callbacks = { &m, on_frame, on_progress };
    int* frames = malloc( (size_t)eye_count * sizeof *frames );
    if ( frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for a list of %d frames", eye_count );
    for ( int i = 0; i < eye_count; ++i )
        frames[i] = i;
    Clock start = { 0.0, cpu_seconds( &m ), rf_wall_seconds() };
    RfResult result = rf_render( tracer, eyes, eye_count, frames, eye_count, settings, &callbacks, NULL, error );
    double end = cpu_seconds( &m );
    free( frames );
    if ( m.last.samples == m.first.samples )
        m.first = start;
    *meter = ( RfTrialMeter ){
        .samples = m.last.samples - m.first.samples,
        .cpu = m.last.cpu - m.first.cpu,
        .wall = m.last.wall - m.first.wall,
        .finish_cpu = end - m.last.cpu - m.callbacks,
        .all_samples = m.last.samples,
        .all_cpu = end - start.cpu,
    };
    return result;
}

void rf_begin_pair( RfTrialPair* pair, const float* weight )
{
    pair->weight = weight;
    pair->relmse = pair->square = pair->ends = pair->steps = 0.0;
}

RfResult rf_keep_first( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    RfTrialPair* p = user;
    memcpy( p->rgb + 3 * p->pixels * (size_t)frame->frame, frame->rgb, 3 * p->pixels * sizeof( float ) );
    return RF_OK;
}

RfResult rf_compare_second( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    RfTrialPair* p = user;
    size_t floats = 3 * p->pixels;
    float *now = p->rgb + floats * (size_t)frame->frame, *before = frame->frame > 0 ? now - floats : NULL;
    const float* weight = p->weight + p->pixels * (size_t)frame->frame;
    double relative = 0.0, square = 0.0, step = 0.0;
    for ( size_t i = 0; i < p->pixels; ++i )
    {
        double sum = 0.0;
        for ( size_t c = 3 * i; c < 3 * i + 3; ++c )
        {
            double d = (double)now[c] - (double)frame->rgb[c], change = before != NULL ? d - (double)before[c] : 0.0;
            sum += d * d;
            step += change * change;
            now[c] = (float)d;
        }
        square += sum;
        relative += (double)weight[i] * sum;
    }
    p->relmse += 0.5 * relative / (double)p->pixels;
    p->square += 0.5 * square / (double)floats;
    p->steps += 0.5 * step / (double)floats;
    if ( frame->frame == 0 )
        p->ends += 0.25 * square / (double)floats;
    if ( frame->frame == p->eyes - 1 )
        p->ends += 0.25 * square / (double)floats;
    return RF_OK;
}

// Consecutive frames of a long path share all groups but one each: in the first, frame t has
// the first position of the group that frame t−1 is not in; in the other, frame t−1 has the
// last position. In all shared groups they are neighbours. So the mean square of e_t − e_{t−1}
// combines the steps between neighbouring positions with both end positions. If one group is
// the whole path, there are only the steps.
static double change_of( const RfTrialPair* p )
{
    return p->whole && p->eyes > 1 ? 0.5 * p->steps * p->eyes / ( p->eyes - 1 ) : p->ends + 0.5 * p->steps;
}

void rf_end_pair( const RfTrialPair* p, int passes, RfTrial* trial )
{
    double weight = (double)p->pixels * p->eyes, each = weight * passes / p->eyes;
    trial->groups += 1;
    trial->weight += weight;
    trial->relmse += each * p->relmse;
    trial->mse += each * p->square;
    trial->change += each * change_of( p );
}
