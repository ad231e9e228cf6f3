// Counts allocations by name against a budget; a request beyond it fails.
#include "base/arena.h"

#include "base/remedy.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define ALIGNMENT 64

size_t rf_arena_size( size_t bytes ) { return ( ( bytes > 0 ? bytes : 1 ) + ALIGNMENT - 1 ) / ALIGNMENT * ALIGNMENT; }

static RfMemoryEntry* find_entry( RfArena* arena, const char* name )
{
    for ( int i = 0; i < arena->entry_count; ++i )
    {
        if ( strcmp( arena->entries[i].name, name ) == 0 )
            return arena->entries + i;
    }
    if ( arena->entry_count == RF_MAX_MEMORY_ENTRIES )
        return NULL;
    RfMemoryEntry* entry = arena->entries + arena->entry_count++;
    *entry = ( RfMemoryEntry ){ .name = name };
    return entry;
}

RfArena rf_create_arena( size_t budget ) { return ( RfArena ){ .budget = budget }; }

RfResult rf_arena_reserve( RfArena* arena, const char* name, size_t bytes, RfError* error )
{
    if ( bytes > SIZE_MAX - ALIGNMENT )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: %zu bytes are more than any machine has", name, bytes );
    size_t rounded = rf_arena_size( bytes );
    if ( rounded > rf_arena_room( arena ) )
        return rf_advise( rf_fail( error, RF_ERROR_MEMORY, "%s: %.1f MiB do not fit, %.1f of %.1f MiB are in use", name,
                                   (double)rounded / 1048576.0, (double)arena->bytes / 1048576.0,
                                   (double)arena->budget / 1048576.0 ),
                          RF_REMEDY_MEMORY, 0, error );
    RfMemoryEntry* entry = find_entry( arena, name );
    if ( entry == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: the arena has no room for another name", name );
    arena->bytes += rounded;
    entry->bytes += rounded;
    if ( arena->bytes > arena->peak )
        arena->peak = arena->bytes;
    if ( entry->bytes > entry->peak )
        entry->peak = entry->bytes;
    return RF_OK;
}

void rf_arena_release( RfArena* arena, const char* name, size_t bytes )
{
    size_t rounded = rf_arena_size( bytes );
    RfMemoryEntry* entry = find_entry( arena, name );
    arena->bytes -= rounded;
    if ( entry != NULL )
        entry->bytes -= rounded;
}

RfResult rf_arena_alloc( RfArena* arena, const char* name, size_t bytes, void** memory, RfError* error )
{
    *memory = NULL;
    RfResult result = rf_arena_reserve( arena, name, bytes, error );
    if ( result != RF_OK )
        return result;
    *memory = aligned_alloc( ALIGNMENT, rf_arena_size( bytes ) );
    if ( *memory != NULL )
        return RF_OK;
    rf_arena_release( arena, name, bytes );
    return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory, %.1f MiB more are needed", name,
                    (double)rf_arena_size( bytes ) / 1048576.0 );
}

void rf_arena_free( RfArena* arena, const char* name, void* memory, size_t bytes )
{
    if ( memory == NULL )
        return;
    free( memory );
    rf_arena_release( arena, name, bytes );
}

size_t rf_arena_room( const RfArena* arena )
{
    if ( arena->budget == 0 )
        return SIZE_MAX;
    return arena->budget > arena->bytes ? arena->budget - arena->bytes : 0;
}
