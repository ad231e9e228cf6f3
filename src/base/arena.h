// A budgeted arena: everything a render allocates beyond scene and BVH comes
// from one of these, each entry with a name, so that a report can say where
// the memory of a group went. The arena counts; the memory itself comes from
// the system, aligned to a cache line.
#ifndef REFRAME_BASE_ARENA_H
#define REFRAME_BASE_ARENA_H

#include "reframe/render.h"

#include <stddef.h>

typedef struct RfArena
{
    size_t budget; // bytes; 0 = without limit
    size_t bytes;  // in use now
    size_t peak;   // high-water mark
    int entry_count;
    RfMemoryEntry entries[RF_MAX_MEMORY_ENTRIES];
} RfArena;

// An empty arena with a budget in bytes (0: no limit).
RfArena rf_create_arena( size_t budget );

// Allocates `bytes` (aligned to 64) under `name`. Fails with RF_ERROR_MEMORY
// where the budget or the system has no room; the line says how much was asked,
// for what, and how much is left. Not thread-safe: allocate outside loops.
RfResult rf_arena_alloc( RfArena* arena, const char* name, size_t bytes, void** memory, RfError* error );

// Gives an allocation back. NULL is allowed.
void rf_arena_free( RfArena* arena, const char* name, void* memory, size_t bytes );

// Counts `bytes` that somebody else allocates, who cannot be made to ask here; fails like
// rf_arena_alloc. And counts them no more.
RfResult rf_arena_reserve( RfArena* arena, const char* name, size_t bytes, RfError* error );
void rf_arena_release( RfArena* arena, const char* name, size_t bytes );

// What an allocation of `bytes` takes of the budget.
size_t rf_arena_size( size_t bytes );

// Bytes that can still be had.
size_t rf_arena_room( const RfArena* arena );

#endif
