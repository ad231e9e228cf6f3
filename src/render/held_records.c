// All hit records of a group at once, as the frame-reuse paper has them: its
// passes are harvested one after the other and packed, then all are computed.
#include "reuse/serialise.h"
#include "render/render_internal.h"

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

static RfResult hold( RfRenderer* r, const RfBatchShape* shape, int count, Held* held, RfError* error )
{
    for ( int i = 0; i < count; ++i )
    {
        const RfHitBatch* batch = r->memory.batches + i;
        HeldBatch packed = { .bytes = rf_serialise_batch( shape, batch, NULL ) };
        RfResult result = rf_arena_alloc( &r->memory.arena, ENTRY, packed.bytes, &packed.memory, error );
        if ( result != RF_OK )
            return result;
        rf_serialise_batch( shape, batch, packed.memory );
        held->batches[held->count++] = packed;
    }
    return RF_OK;
}

static RfResult harvest_all( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int jobs, Held* held,
                             RfError* error )
{
    for ( int pass = 0; pass < window->passes; ++pass )
    {
        for ( int first = 0; first < jobs; first += r->memory.batch_slots )
        {
            int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
            rf_harvest_chunk( r, harvest, window, pass, first, count );
            RfResult result = hold( r, &harvest->shape, count, held, error );
            if ( result == RF_OK )
                result = rf_end_chunk( r, count, error );
            if ( result != RF_OK )
                return result;
        }
    }
    return RF_OK;
}

// A pass of those held, as many at a time as there is room to unpack them.
static void compute_pass( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int pass, int jobs,
                          const HeldBatch* held )
{
    rf_begin_pass( r, harvest );
    for ( int first = 0; first < jobs; first += r->memory.batch_slots )
    {
        int count = jobs - first < r->memory.batch_slots ? jobs - first : r->memory.batch_slots;
#pragma omp parallel for num_threads( r->settings.threads ) schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
            rf_deserialise_batch( &harvest->shape, held[first + i].memory, r->memory.batches + i );
        rf_accumulate_chunk( r, harvest, window, pass, r->memory.batches, count );
    }
    rf_end_pass( r, harvest, window, pass );
}

static void let_go( RfRenderer* r, Held* held )
{
    for ( size_t i = 0; i < held->count; ++i )
        rf_arena_free( &r->memory.arena, ENTRY, held->batches[i].memory, held->batches[i].bytes );
    rf_arena_free( &r->memory.arena, ENTRY, held->batches, held->room * sizeof *held->batches );
}

RfResult rf_render_held( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, RfError* error )
{
    int jobs = harvest->shape.eyes * r->sizes.patches.count;
    Held held = { .room = (size_t)jobs * (size_t)window->passes };
    RfResult result = rf_arena_alloc( &r->memory.arena, ENTRY, held.room * sizeof *held.batches, (void**)&held.batches, error );
    if ( result == RF_OK )
        result = harvest_all( r, harvest, window, jobs, &held, error );
    for ( int pass = 0; pass < window->passes && result == RF_OK; ++pass )
        compute_pass( r, harvest, window, pass, jobs, held.batches + (size_t)pass * (size_t)jobs );
    let_go( r, &held );
    return result;
}

// A batch to count with, outside the budget, of which nothing else is in use yet.
typedef struct Counter
{
    RfArena arena;
    void *scratch_memory, *batch_memory;
    RfHarvestScratch* scratch;
    RfHitBatch batch;
} Counter;

static RfResult alloc_counter( const RfBatchShape* shape, Counter* c, RfError* error )
{
    *c = ( Counter ){ .arena = rf_create_arena( 0 ) };
    RfResult result = rf_arena_alloc( &c->arena, "scratch", rf_harvest_scratch_bytes( shape ), &c->scratch_memory, error );
    if ( result == RF_OK )
        result = rf_arena_alloc( &c->arena, "hit records", rf_batch_bytes( shape ), &c->batch_memory, error );
    if ( result != RF_OK )
        return result;
    c->scratch = rf_lay_out_harvest_scratch( shape, c->scratch_memory );
    c->batch = rf_lay_out_batch( shape, c->batch_memory );
    return RF_OK;
}

static void free_counter( const RfBatchShape* shape, Counter* c )
{
    rf_arena_free( &c->arena, "scratch", c->scratch_memory, rf_harvest_scratch_bytes( shape ) );
    rf_arena_free( &c->arena, "hit records", c->batch_memory, rf_batch_bytes( shape ) );
}

// Of a window, as rf_render_held allocates them.
static size_t count_window( const RfRenderer* r, int number, Counter* c )
{
    RfHarvest harvest = rf_group_harvest( r, number );
    RfGroup window = rf_group( &r->plan, number );
    RfRayCounts unused = { 0 };
    int patches = r->sizes.patches.count;
    size_t jobs = (size_t)harvest.shape.eyes * (size_t)patches;
    size_t bytes = rf_arena_size( jobs * (size_t)window.passes * sizeof( HeldBatch ) );
    for ( int pass = 0; pass < window.passes; ++pass )
    {
        for ( size_t job = 0; job < jobs; ++job )
        {
            RfHarvestJob of = { (int)( job / (size_t)patches ), (int)( job % (size_t)patches ), pass };
            rf_harvest_first_hits( &harvest, of, &c->batch, c->scratch, &unused );
            bytes += rf_arena_size( rf_serialise_batch( &harvest.shape, &c->batch, NULL ) );
        }
    }
    return bytes;
}

RfResult rf_count_held( RfRenderer* r, RfError* error )
{
    Counter counter;
    RfResult result = alloc_counter( &r->sizes.shape, &counter, error );
    rf_set_float_mode();
    for ( int w = 0; w < r->plan.windows && result == RF_OK; ++w )
    {
        if ( !rf_group_wanted( r, rf_group( &r->plan, w ) ) )
            continue;
        size_t bytes = count_window( r, w, &counter );
        r->sizes.held = bytes > r->sizes.held ? bytes : r->sizes.held;
    }
    free_counter( &r->sizes.shape, &counter );
    return result;
}
