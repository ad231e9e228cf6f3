#include "render/held_records.h"

#include "render/frames.h"
#include "render/pass.h"

#define ENTRY "held hit records"

typedef struct HeldBatch
{
    void* memory;
    size_t bytes;
} HeldBatch;

typedef struct Held
{
    HeldBatch* batches; // by pass
    size_t count, room;
} Held;

static RfResult hold( RfRenderer* r, const RfEstimatorGroup* group, int count, Held* held, RfError* error )
{
    const RfEstimator* estimator = r->settings.estimator;
    for ( int i = 0; i < count; ++i )
    {
        const void* batch = r->memory.batches[i];
        HeldBatch copy = { .bytes = estimator->serialise( group, batch, NULL ) };
        RfResult result = rf_arena_alloc( &r->memory.arena, ENTRY, copy.bytes, &copy.memory, error );
        if ( result != RF_OK )
            return result;
        estimator->serialise( group, batch, copy.memory );
        held->batches[held->count++] = copy;
    }
    return RF_OK;
}

static RfResult trace_pass( RfRenderer* r, const RfPass* pass, int jobs, Held* held, RfError* error )
{
    RfResult result = RF_OK;
    rf_prepare_pass( r, pass );
    for ( int first = 0; first < jobs && result == RF_OK; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
        rf_trace_chunk( r, pass, first, count );
        result = hold( r, pass->group, count, held, error );
        if ( result == RF_OK )
            result = rf_end_chunk( r, count, error );
    }
    return result;
}

// Of the held records as many at a time as there are batches to deserialise them into.
static void accumulate_pass( RfRenderer* r, const RfPass* pass, int jobs, const HeldBatch* held )
{
    rf_begin_pass( r );
    for ( int first = 0; first < jobs; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
#pragma omp parallel for num_threads( r->settings.threads ) schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            rf_set_float_mode();
            r->settings.estimator->deserialise( pass->group, held[first + i].memory, r->memory.batches[i] );
        }
        rf_accumulate_chunk( r, pass, count );
    }
    if ( r->sizes.adaptive )
        rf_prepare_pass( r, pass ); // for its extra samples
    rf_end_pass( r, pass );
}

static void free_held( RfRenderer* r, Held* held )
{
    for ( size_t i = 0; i < held->count; ++i )
        rf_arena_free( &r->memory.arena, ENTRY, held->batches[i].memory, held->batches[i].bytes );
    rf_arena_free( &r->memory.arena, ENTRY, held->batches, held->room * sizeof *held->batches );
}

RfResult rf_render_held( RfRenderer* r, const RfEstimatorGroup* estimator_group, const RfGroup* group, RfError* error )
{
    int jobs = group->eyes * r->sizes.of_estimator.jobs;
    Held held = { .room = (size_t)jobs * (size_t)group->passes };
    RfResult result = rf_arena_alloc( &r->memory.arena, ENTRY, held.room * sizeof *held.batches, (void**)&held.batches, error );
    for ( int k = 0; k < group->passes && result == RF_OK; ++k )
    {
        RfPass pass = rf_make_pass( estimator_group, group, k );
        pass.traced = k * pass.weight; // AOVs are means over them
        result = trace_pass( r, &pass, jobs, &held, error );
        rf_filter_aovs( r, &pass );
    }
    for ( int k = 0; k < group->passes && result == RF_OK; ++k )
    {
        RfPass pass = rf_make_pass( estimator_group, group, k );
        accumulate_pass( r, &pass, jobs, held.batches + (size_t)k * (size_t)jobs );
    }
    free_held( r, &held );
    return result;
}

// A batch to count with, outside the budget, of which nothing else is in use yet.
typedef struct Counter
{
    RfArena arena;
    void *scratch, *batch;
} Counter;

static RfResult alloc_counter( const RfRenderer* r, Counter* c, RfError* error )
{
    const RfEstimator* estimator = r->settings.estimator;
    RfEstimatorGroup group = rf_frames_as_group( r, 0, r->plan.eyes, 0 );
    *c = ( Counter ){ .arena = rf_create_arena( 0 ) };
    RfResult result = rf_arena_alloc( &c->arena, "scratch", r->sizes.of_estimator.trace_scratch, &c->scratch, error );
    if ( result == RF_OK )
        result = rf_arena_alloc( &c->arena, "hit records", r->sizes.of_estimator.batch, &c->batch, error );
    if ( result != RF_OK )
        return result;
    estimator->lay_out_scratch( &group, c->scratch );
    estimator->lay_out_batch( &group, c->batch );
    return RF_OK;
}

static void free_counter( const RfRenderer* r, Counter* c )
{
    rf_arena_free( &c->arena, "scratch", c->scratch, r->sizes.of_estimator.trace_scratch );
    rf_arena_free( &c->arena, "hit records", c->batch, r->sizes.of_estimator.batch );
}

// Bytes that rf_render_held allocates for a group.
static size_t count_group( const RfRenderer* r, int number, Counter* c )
{
    const RfEstimator* estimator = r->settings.estimator;
    RfEstimatorGroup estimator_group = rf_estimator_group( r, number );
    RfGroup group = rf_group( &r->plan, number );
    size_t per_frame = (size_t)r->sizes.of_estimator.jobs, jobs = (size_t)group.eyes * per_frame;
    size_t bytes = rf_arena_size( jobs * (size_t)group.passes * sizeof( HeldBatch ) );
    for ( int pass = 0; pass < group.passes; ++pass )
    {
        for ( size_t job = 0; job < jobs; ++job )
        {
            RfTraceJob one = { (int)( job / per_frame ), (int)( job % per_frame ), pass };
            estimator->trace_first_hits( &estimator_group, one, c->batch, c->scratch );
            bytes += rf_arena_size( estimator->serialise( &estimator_group, c->batch, NULL ) );
        }
    }
    return bytes;
}

RfResult rf_count_held( RfRenderer* r, RfError* error )
{
    Counter counter;
    RfResult result = alloc_counter( r, &counter, error );
    rf_set_float_mode();
    for ( int g = 0; g < r->plan.groups && result == RF_OK; ++g )
    {
        if ( !rf_group_wanted( r, rf_group( &r->plan, g ) ) )
            continue;
        size_t bytes = count_group( r, g, &counter );
        r->sizes.held = bytes > r->sizes.held ? bytes : r->sizes.held;
    }
    free_counter( r, &counter );
    return result;
}
