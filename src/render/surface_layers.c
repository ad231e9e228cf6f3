// Makes the layers of a frame that show which surface is where.
#include "render/surface_layers.h"

#include "render/renderer.h"
#include "scene/placement.h"

#include <stdlib.h>

RfResult rf_make_surface_tables( const RfScene* scene, const RfRenderSettings* settings, RfSurfaceTables* tables, RfError* error )
{
    RfResult result = RF_OK;
    *tables = ( RfSurfaceTables ){ .object_index = NULL };
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS && result == RF_OK; ++k )
    {
        if ( ( settings->cryptomatte & 1u << k ) != 0 )
            result = rf_make_cryptomatte_ids( scene, k, tables->ids + k, error );
    }
    bool objects = ( settings->aovs & RF_AOV_BIT( RF_AOV_OBJECT_INDEX ) ) != 0,
         materials = ( settings->aovs & RF_AOV_BIT( RF_AOV_MATERIAL_INDEX ) ) != 0;
    if ( objects )
        tables->object_index = malloc( ( (size_t)scene->node_count + 1 ) * sizeof *tables->object_index );
    if ( materials )
        tables->material_index = malloc( ( (size_t)scene->material_count + 1 ) * sizeof *tables->material_index );
    if ( ( objects && tables->object_index == NULL ) || ( materials && tables->material_index == NULL ) )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the indices of %d objects", scene->node_count );
    if ( objects )
        rf_list_object_indices( scene, tables->object_index );
    if ( materials )
        rf_list_material_indices( scene, tables->material_index );
    return result;
}

void rf_destroy_surface_tables( RfSurfaceTables* tables )
{
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
        rf_destroy_cryptomatte_ids( tables->ids + k );
    free( tables->object_index );
    free( tables->material_index );
}

static void finish_mattes( const RfRenderer* r, const RfLiveFilm* live, size_t pixels, RfFrameBuffer* buffer )
{
    int count = buffer->result.layer_count;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        float* const* mattes = buffer->mattes + k * RF_CRYPTOMATTE_LAYERS;
        if ( mattes[0] == NULL )
            continue;
        rf_finish_cryptomatte( live->covering, pixels, r->surfaces.ids + k, mattes );
        for ( int i = 0; i < RF_CRYPTOMATTE_LAYERS; ++i )
            buffer->list[count++] =
                ( RfLayer ){ .name = g_rf_cryptomatte_kinds[k].layers[i], .letters = "rgba", .values = mattes[i] };
    }
    buffer->result.layers = buffer->list;
    buffer->result.layer_count = count;
}

void rf_finish_surfaces( const RfRenderer* r, const RfLiveFilm* live, RfFrameBuffer* buffer )
{
    size_t pixels = (size_t)r->setup->sizes.width * (size_t)r->setup->sizes.height;
    const RfScene* scene = rf_tracer_scene( r->setup->shot.tracer );
    if ( live->covering == NULL )
        return;
    finish_mattes( r, live, pixels, buffer );
    if ( buffer->layers[RF_AOV_OBJECT_INDEX] != NULL )
        rf_finish_index( live->covering, pixels, scene, RF_AOV_OBJECT_INDEX, r->surfaces.object_index,
                         buffer->layers[RF_AOV_OBJECT_INDEX] );
    if ( buffer->layers[RF_AOV_MATERIAL_INDEX] != NULL )
        rf_finish_index( live->covering, pixels, scene, RF_AOV_MATERIAL_INDEX, r->surfaces.material_index,
                         buffer->layers[RF_AOV_MATERIAL_INDEX] );
}
