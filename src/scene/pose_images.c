// Poses textures that show image after image.
#include "scene/pose_images.h"

#include "base/file.h"
#include "scene/image_sequence.h"
#include "scene/movement.h"

#include <string.h>

size_t rf_image_scratch( const RfScene* scene )
{
    size_t most = 0;
    for ( int i = 0; scene->movement != NULL && i < scene->movement->sequence_count; ++i )
        most = scene->movement->sequences[i].scratch > most ? scene->movement->sequences[i].scratch : most;
    return most;
}

RfResult rf_pose_images( const RfScene* scene, double time, RfLayout* layout, RfScene* posed, RfError* error )
{
    const RfMovement* movement = scene->movement;
    RfResult result = RF_OK;
    if ( movement->sequence_count == 0 )
        return RF_OK;
    RF_PLACE( layout, posed->textures, scene->texture_count );
    if ( layout->memory != NULL )
        memcpy( posed->textures, scene->textures, (size_t)scene->texture_count * sizeof *posed->textures );
    for ( int i = 0; result == RF_OK && i < movement->sequence_count; ++i )
    {
        const RfImageSequence* s = movement->sequences + i;
        void* image = rf_take( layout, s->bytes, 1 );
        if ( layout->memory != NULL )
            result = rf_place_sequence_image( s, rf_sequence_number( s, time ), image, posed->textures + s->texture, error );
    }
    return result;
}

uint64_t rf_hash_images( const RfScene* scene, double time, uint64_t hash )
{
    for ( int i = 0; i < scene->movement->sequence_count; ++i )
    {
        int number = rf_sequence_number( scene->movement->sequences + i, time );
        hash = rf_hash_bytes( hash, &number, sizeof number );
    }
    return hash;
}
