// All hit records of a group at once, as the frame-reuse paper has them: its
// passes are harvested one after the other and packed, then all are computed.
#include "reuse/render_internal.h"

#define ENTRY "held hit records"

typedef struct Held
{
    RfHitBatch* batches; // by pass
    size_t count, room;
} Held;

static RfResult allocate( RfRenderer* r, size_t bytes, void** memory, RfError* error )
{
    if ( bytes > rf_arena_room( &r->memory.arena ) )
        return rf_fail( error, RF_ERROR_MEMORY, "--hold-all: the hit records of a group do not fit into %zu KiB: give more --memory, or leave it off",
                        r->memory.arena.budget / 1024 );
    return rf_arena_alloc( &r->memory.arena, ENTRY, bytes, memory, error );
}

static RfResult hold( RfRenderer* r, const RfBatchShape* shape, int count, Held* held, RfError* error )
{
    for ( int i = 0; i < count; ++i )
    {
        const RfHitBatch* batch = r->memory.batches + i;
        void* memory;
        RfResult result = allocate( r, rf_packed_batch_bytes( shape, batch ), &memory, error );
        if ( result != RF_OK )
            return result;
        held->batches[held->count++] = rf_pack_batch( shape, batch, memory );
    }
    return RF_OK;
}

static RfResult harvest_all( RfRenderer* r, const RfHarvest* harvest, const RfWindow* window, int jobs, Held* held, RfError* error )
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

static void let_go( RfRenderer* r, const RfBatchShape* shape, Held* held )
{
    // a batch's first array is where its memory begins
    for ( size_t i = 0; i < held->count; ++i )
        rf_arena_free( &r->memory.arena, ENTRY, held->batches[i].p[0], rf_packed_batch_bytes( shape, held->batches + i ) );
    rf_arena_free( &r->memory.arena, ENTRY, held->batches, held->room * sizeof *held->batches );
}

RfResult rf_render_held( RfRenderer* r, const RfHarvest* harvest, const RfWindow* window, RfError* error )
{
    int jobs = harvest->shape.eyes * r->sizes.patches.count;
    Held held = { .room = (size_t)jobs * (size_t)window->passes };
    RfResult result = allocate( r, held.room * sizeof *held.batches, (void**)&held.batches, error );
    if ( result == RF_OK )
        result = harvest_all( r, harvest, window, jobs, &held, error );
    for ( int pass = 0; pass < window->passes && result == RF_OK; ++pass )
    {
        rf_begin_pass( r, harvest );
        rf_compute_chunk( r, harvest, window, pass, held.batches + (size_t)pass * (size_t)jobs, jobs );
        rf_end_pass( r, harvest, window, pass );
    }
    let_go( r, &harvest->shape, &held );
    return result;
}
