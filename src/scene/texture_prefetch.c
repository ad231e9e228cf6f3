#include "scene/texture_prefetch.h"

#include "scene/textured_lookup.h"

// The corners' numbers, which tell where their texture coordinates are.
static void fetch_corners( const RfScene* scene, const RfTexturedPoint* points, int count )
{
    for ( int i = 0; i < count; ++i )
        __builtin_prefetch( scene->triangles.indices + 3 * (size_t)points[i].triangle );
}

static void fetch_coordinates( const RfScene* scene, const RfTexturedPoint* points, int count )
{
    for ( int i = 0; i < count && scene->triangles.uvs != NULL; ++i )
    {
        const uint32_t* corners = scene->triangles.indices + 3 * (size_t)points[i].triangle;
        for ( int k = 0; k < 3; ++k )
            __builtin_prefetch( scene->triangles.uvs + 2 * (size_t)corners[k] );
    }
}

static void fetch_texels( const RfScene* scene, const RfTexturedPoint* points, int count )
{
    for ( int i = 0; i < count; ++i )
    {
        const RfTextureRef* refs = points[i].material->textured->refs;
        for ( int slot = 0; slot < RF_TEXTURE_SLOT_COUNT; ++slot )
        {
            if ( refs[slot].texture < 0 )
                continue;
            float at[2];
            rf_texture_coordinates( scene, refs + slot, points[i].triangle, points[i].u, points[i].v, at );
            rf_prefetch_texels( scene->textures + refs[slot].texture, refs + slot, at );
        }
    }
}

void rf_prefetch_textures( const RfScene* scene, const RfTexturedPoint* points, int count )
{
    fetch_corners( scene, points, count );
    fetch_coordinates( scene, points, count );
    fetch_texels( scene, points, count );
}
