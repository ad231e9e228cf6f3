// A budgeted arena: everything that a render allocates, apart from scene and BVH, comes from
// one. Each allocation has a name, so that a report can list what the memory is used for. The
// arena only counts; the memory itself comes from the system, aligned to a cache line.
#ifndef REFRAME_BASE_ARENA_H
#define REFRAME_BASE_ARENA_H

#include "reframe/error.h"

#include <stddef.h>

#define RF_ARENA_MAX_NAMES 32

typedef struct RfArenaEntry
{
    const char* name; // a string literal
    size_t bytes;     // in use under this name
    size_t peak;      // high-water mark under this name
} RfArenaEntry;

typedef struct RfArena
{
    size_t budget; // bytes; 0: unlimited
    size_t bytes;  // in use
    size_t peak;   // high-water mark
    int entry_count;
    RfArenaEntry entries[RF_ARENA_MAX_NAMES];
} RfArena;

// Creates an empty arena with a budget in bytes (0: unlimited).
RfArena rf_create_arena( size_t budget );

// Allocates `bytes` (aligned to 64) under `name`. Fails with RF_ERROR_MEMORY if the budget or
// the system has no room; the message gives the size and purpose of the allocation and the
// memory in use. Not thread-safe: allocate outside parallel loops.
RfResult rf_arena_alloc( RfArena* arena, const char* name, size_t bytes, void** memory, RfError* error );

// Frees an allocation. `memory` may be NULL.
void rf_arena_free( RfArena* arena, const char* name, void* memory, size_t bytes );

// Counts `bytes` that are allocated elsewhere, by code that cannot use an arena. Fails like
// rf_arena_alloc.
RfResult rf_arena_reserve( RfArena* arena, const char* name, size_t bytes, RfError* error );

// Subtracts bytes counted by rf_arena_reserve.
void rf_arena_release( RfArena* arena, const char* name, size_t bytes );

// What an allocation of `bytes` takes from the budget.
size_t rf_arena_size( size_t bytes );

// Bytes left in the budget.
size_t rf_arena_room( const RfArena* arena );

#endif
