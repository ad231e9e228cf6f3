// Takes pieces one after the other.
#include "base/layout.h"

void* rf_take( RfLayout* layout, size_t count, size_t size )
{
    void* piece = layout->memory != NULL && count > 0 ? layout->memory + layout->bytes : NULL;
    layout->bytes += rf_piece_bytes( count * size );
    return piece;
}
