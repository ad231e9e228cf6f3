// Frees what moves.
#include "scene/movement.h"

#include <stdlib.h>

void rf_destroy_movement( RfMovement* movement )
{
    if ( movement == NULL )
        return;
    for ( int i = 0; movement->skins != NULL && i < movement->skin_count; ++i )
    {
        free( movement->skins[i].joints );
        free( movement->skins[i].inverse_binds );
    }
    for ( int i = 0; movement->movers != NULL && i < movement->mover_count; ++i )
        free( movement->movers[i].weights );
    for ( int i = 0; movement->changes != NULL && i < movement->change_count; ++i )
        rf_destroy_channel( &movement->changes[i].channel );
    free( movement->lamps );
    free( movement->changes );
    free( movement->nodes );
    free( movement->skins );
    free( movement->movers );
    free( movement );
}
