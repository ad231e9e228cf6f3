// Poses textures that show image after image.
#include "scene/pose_images.h"

#include "base/file.h"
#include "scene/image_sequence.h"
#include "scene/movement.h"

#include <string.h>

static size_t round_up( size_t bytes ) { return ( bytes + 63 ) / 64 * 64; }

static size_t list_bytes( const RfScene* scene ) { return round_up( (size_t)scene->texture_count * sizeof( RfTexture ) ); }

size_t rf_images_bytes( const RfScene* scene )
{
    const RfMovement* movement = scene->movement;
    size_t bytes = movement->sequence_count > 0 ? list_bytes( scene ) : 0;
    for ( int i = 0; i < movement->sequence_count; ++i )
        bytes += round_up( movement->sequences[i].bytes );
    return bytes;
}

size_t rf_image_scratch( const RfScene* scene )
{
    size_t most = 0;
    for ( int i = 0; scene->movement != NULL && i < scene->movement->sequence_count; ++i )
        most = scene->movement->sequences[i].scratch > most ? scene->movement->sequences[i].scratch : most;
    return most;
}

RfResult rf_pose_images( const RfScene* scene, double time, char* memory, RfScene* posed, RfError* error )
{
    const RfMovement* movement = scene->movement;
    RfResult result = RF_OK;
    if ( movement->sequence_count == 0 )
        return RF_OK;
    posed->textures = (RfTexture*)(void*)memory;
    memcpy( posed->textures, scene->textures, (size_t)scene->texture_count * sizeof *posed->textures );
    memory += list_bytes( scene );
    for ( int i = 0; result == RF_OK && i < movement->sequence_count; ++i )
    {
        const RfImageSequence* s = movement->sequences + i;
        result = rf_place_sequence_image( s, rf_sequence_number( s, time ), memory, posed->textures + s->texture, error );
        memory += round_up( s->bytes );
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
