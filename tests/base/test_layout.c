// One description measures a block and places its pieces.
#include "support/test.h"
#include "base/layout.h"

typedef struct Block
{
    char* bytes;
    double ( *rows )[3];
    struct Block* inner;
    int* none;
} Block;

static Block* place_block( int bytes, int rows, bool inner, RfLayout* layout )
{
    Block* block = rf_take( layout, 1, sizeof *block );
    RF_PLACE( layout, block->bytes, bytes );
    RF_PLACE( layout, block->rows, rows );
    RF_PLACE( layout, block->inner, inner );
    if ( inner )
        RF_PLACE( layout, block->inner->bytes, bytes );
    RF_PLACE( layout, block->none, 0 );
    return block;
}

TEST( test_places_what_it_measures )
{
    RfLayout measured = { 0 };
    assert_null( place_block( 65, 3, true, &measured ) );
    assert_int_equal( measured.bytes, 64 + 128 + 128 + 64 + 128 );
    RfLayout placed = { .memory = aligned_alloc( 64, measured.bytes ) };
    memset( placed.memory, 0xff, measured.bytes );
    Block* block = place_block( 65, 3, true, &placed );
    assert_int_equal( placed.bytes, measured.bytes );
    assert_ptr_equal( block, placed.memory );
    assert_ptr_equal( block->bytes, placed.memory + 64 );
    assert_ptr_equal( block->rows, placed.memory + 192 );
    assert_ptr_equal( block->inner, placed.memory + 320 );
    assert_ptr_equal( block->inner->bytes, placed.memory + 384 );
    assert_null( block->none );
    free( placed.memory );
}

TEST( test_leaves_out_what_is_not_there )
{
    RfLayout layout = { .memory = aligned_alloc( 64, 128 ) };
    Block* block = place_block( 1, 0, false, &layout );
    assert_int_equal( layout.bytes, 128 );
    assert_null( block->rows );
    assert_null( block->inner );
    free( layout.memory );
}
