// One description of a block of memory. A function that takes pieces from a layout measures the block where the layout has
// no memory, and places the pieces where it has: what a block takes and what lies where cannot disagree.
#ifndef REFRAME_BASE_LAYOUT_H
#define REFRAME_BASE_LAYOUT_H

#include <stddef.h>

typedef struct RfLayout
{
    char* memory; // aligned to 64; NULL: pieces are measured alone
    size_t bytes; // of the pieces so far
} RfLayout;

// The bytes that rf_take takes for so many.
static inline size_t rf_piece_bytes( size_t bytes ) { return ( bytes + 63 ) / 64 * 64; }

// The next piece, aligned to 64; NULL without memory, and for no elements.
static inline void* rf_take( RfLayout* layout, size_t count, size_t size )
{
    void* piece = layout->memory != NULL && count > 0 ? layout->memory + layout->bytes : NULL;
    layout->bytes += rf_piece_bytes( count * size );
    return piece;
}

// Points `at` to so many elements, or to NULL for none. It may lie in an earlier piece, since it is looked at only where
// there is memory.
#define RF_PLACE( layout, at, count )                                                                                            \
    do                                                                                                                           \
    {                                                                                                                            \
        void* piece_ = rf_take( ( layout ), (size_t)( count ), sizeof *( at ) );                                                 \
        if ( ( layout )->memory != NULL )                                                                                        \
            ( at ) = piece_;                                                                                                     \
    } while ( 0 )

#endif
