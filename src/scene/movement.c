// Adds to what changes, and frees what moves.
#include "scene/movement.h"

#include "scene/animation.h"

#include <math.h>
#include <stdlib.h>

static bool is_empty( const RfMovement* m ) { return m->mover_count == 0 && m->lamp_count == 0 && m->change_count == 0; }

RfMovement* rf_open_movement( RfScene* scene )
{
    if ( scene->movement == NULL )
        scene->movement = calloc( 1, sizeof *scene->movement );
    return scene->movement;
}

bool rf_add_change( RfScene* scene, RfChange* change )
{
    RfMovement* movement = rf_open_movement( scene );
    size_t count = movement != NULL ? (size_t)movement->change_count : 0;
    RfChange* grown = movement != NULL ? realloc( movement->changes, ( count + 1 ) * sizeof *grown ) : NULL;
    if ( grown == NULL )
    {
        rf_destroy_channel( &change->channel );
        return false;
    }
    double start, end;
    rf_channel_span( &change->channel, &start, &end );
    bool first = is_empty( movement );
    movement->start = first ? start : fmin( movement->start, start );
    movement->end = first ? end : fmax( movement->end, end );
    movement->changes = grown;
    movement->changes[movement->change_count++] = *change;
    return true;
}

void rf_drop_empty_movement( RfScene* scene )
{
    if ( scene->movement == NULL || !is_empty( scene->movement ) )
        return;
    rf_destroy_movement( scene->movement );
    scene->movement = NULL;
}

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
