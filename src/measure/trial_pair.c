#include "measure/trial_pair.h"

#include "base/system.h"

#include <math.h>
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

void rf_begin_pair( RfTrialPair* p, int first )
{
    p->first = first;
    p->square = p->first_mean = p->last_mean = p->steps = 0.0;
    p->step_count = 0;
    memset( p->relmse, 0, sizeof p->relmse );
    memset( p->pixels, 0, sizeof p->pixels );
    memset( p->worst, 0, sizeof p->worst );
}

// The slots of a frame of the region: which cell each is.
typedef struct Slots
{
    const int32_t* slot; // by cell; −1: none
    int cells;
} Slots;

static Slots slots_of( const RfTestPieces* pieces, int frame )
{
    int cells = pieces->across * pieces->down;
    return ( Slots ){ pieces->slot + (size_t)frame * (size_t)cells, cells };
}

// Where the colours of a slot are.
static float* colors_of( const RfTrialPair* p, int32_t slot )
{
    return p->rgb + 3 * RF_CELL_PIXELS * (size_t)( slot - p->pieces->first_slot[p->first] );
}

RfResult rf_keep_first( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    RfTrialPair* p = user;
    Slots s = slots_of( p->pieces, p->first + frame->frame );
    int32_t pixel[RF_CELL_PIXELS];
    for ( int cell = 0; cell < s.cells; ++cell )
    {
        int count = s.slot[cell] >= 0 ? rf_cell_pixels( p->pieces, cell, pixel ) : 0;
        for ( int k = 0; k < count; ++k )
            memcpy( colors_of( p, s.slot[cell] ) + 3 * k, frame->rgb + 3 * (size_t)pixel[k], 3 * sizeof( float ) );
    }
    return RF_OK;
}

// Subtracts the second render from a cell of the first; returns the sum of ½ d², and adds the weighted one to the piece.
static double subtract_cell( RfTrialPair* p, const RfFrameResult* frame, int32_t slot, int count, const int32_t* pixel )
{
    float* d = colors_of( p, slot );
    const float* weight = p->weight + RF_CELL_PIXELS * (size_t)slot;
    double square = 0.0, relmse = 0.0;
    for ( int k = 0; k < count; ++k )
    {
        double sum = 0.0;
        for ( int c = 0; c < 3; ++c )
        {
            double delta = (double)d[3 * k + c] - (double)frame->rgb[3 * (size_t)pixel[k] + (size_t)c];
            sum += 0.5 * delta * delta;
            d[3 * k + c] = (float)delta;
        }
        square += sum;
        relmse += (double)weight[k] * sum;
    }
    p->relmse[p->pieces->piece[slot]] += relmse;
    rf_keep_worst_cell( p->worst, relmse );
    p->pixels[p->pieces->piece[slot]] += count;
    return square;
}

// ½ squared change of the difference since the frame before, summed over a cell.
static double change_of_cell( const RfTrialPair* p, int32_t slot, int32_t slot_before, int count )
{
    const float *now = colors_of( p, slot ), *before = colors_of( p, slot_before );
    double sum = 0.0;
    for ( int i = 0; i < 3 * count; ++i )
    {
        double change = (double)now[i] - (double)before[i];
        sum += 0.5 * change * change;
    }
    return sum;
}

RfResult rf_compare_second( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    RfTrialPair* p = user;
    Slots s = slots_of( p->pieces, p->first + frame->frame );
    const int32_t* before = frame->frame > 0 ? s.slot - s.cells : NULL;
    int32_t pixel[RF_CELL_PIXELS];
    double square = 0.0, step = 0.0, all = 0.0, shared = 0.0;
    for ( int cell = 0; cell < s.cells; ++cell )
    {
        if ( s.slot[cell] < 0 )
            continue;
        int count = rf_cell_pixels( p->pieces, cell, pixel );
        square += subtract_cell( p, frame, s.slot[cell], count, pixel );
        all += count;
        if ( before == NULL || before[cell] < 0 )
            continue;
        step += change_of_cell( p, s.slot[cell], before[cell], count );
        shared += count;
    }
    double mean = all > 0.0 ? square / ( 3.0 * all ) : 0.0;
    p->square += square / 3.0;
    p->first_mean = frame->frame == 0 ? mean : p->first_mean;
    p->last_mean = frame->frame == p->eyes - 1 ? mean : p->last_mean;
    p->steps += shared > 0.0 ? step / ( 3.0 * shared ) : 0.0;
    p->step_count += shared > 0.0;
    return RF_OK;
}

// The mean over the frames. Consecutive frames of a long path share all groups but one each: in the first, frame t has
// the first position of the group that frame t−1 is not in; in the other, frame t−1 has the
// last position. In all shared groups they are neighbours. So the mean square of e_t − e_{t−1}
// combines the steps between neighbouring positions with both end positions. If one group is
// the whole path, there are only the steps. NaN if no pixel is measured in two consecutive frames.
static double change_of( const RfTrialPair* p )
{
    double ends = 0.5 * ( p->first_mean + p->last_mean ), step = p->step_count > 0 ? p->steps / p->step_count : (double)NAN;
    if ( p->eyes == 1 )
        return ends;
    return p->whole ? 0.5 * step : ( ends + 0.5 * step * ( p->eyes - 1 ) ) / p->eyes;
}

void rf_end_pair( const RfTrialPair* p, int passes, RfTrial* trial )
{
    double weight = 0.0, change = change_of( p );
    for ( int i = 0; i < p->pieces->count; ++i )
    {
        trial->pieces[i].weight += p->pixels[i];
        trial->pieces[i].relmse += passes * p->relmse[i];
        trial->relmse += passes * p->relmse[i];
        weight += p->pixels[i];
    }
    for ( int k = 0; k < RF_WORST_CELLS; ++k )
        rf_keep_worst_cell( trial->worst, passes * p->worst[k] );
    trial->piece_count = p->pieces->count;
    trial->groups += 1;
    trial->weight += weight;
    trial->mse += passes * p->square;
    trial->change_weight += change == change ? weight : 0.0;
    trial->change += change == change ? passes * weight * change : 0.0;
}
