#include "convert/root_transform.h"

#include <stdlib.h>
#include <string.h>

RfResult rf_apply_root_transform( RfModel* model, bool z_up, double scale, RfError* error )
{
    if ( !z_up && scale == 1.0 )
        return RF_OK;
    RfModelNode* nodes = malloc( ( (size_t)model->node_count + 1 ) * sizeof *nodes );
    if ( nodes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d nodes", model->node_count + 1 );
    RfMat4 matrix = { { scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, 1 } };
    if ( z_up ) // x stays, z becomes y, y becomes −z
        matrix = ( RfMat4 ){ { scale, 0, 0, 0, 0, 0, -scale, 0, 0, scale, 0, 0, 0, 0, 0, 1 } };
    nodes[0] = ( RfModelNode ){ .name = NULL, .parent = -1, .matrix = matrix };
    for ( int i = 0; i < model->node_count; ++i )
    {
        nodes[i + 1] = model->nodes[i];
        nodes[i + 1].parent += 1; // the −1 of former roots becomes 0, the new node
    }
    free( model->nodes );
    model->nodes = nodes;
    model->node_count += 1;
    for ( int i = 0; i < model->camera_count; ++i )
        model->cameras[i].node += 1;
    for ( int i = 0; i < model->light_count; ++i )
        model->lights[i].node += 1;
    return RF_OK;
}

RfModelCounts rf_count_model( const RfModel* model )
{
    RfModelCounts counts = { .meshes = model->mesh_count,
                             .nodes = model->node_count,
                             .materials = model->material_count,
                             .images = model->image_count,
                             .cameras = model->camera_count,
                             .lights = model->light_count };
    for ( int i = 0; i < model->mesh_count; ++i )
        counts.triangles += model->meshes[i].triangle_count;
    return counts;
}
