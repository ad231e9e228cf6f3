// Memory, defaults and counts of a model that is being converted.
#include "convert/model.h"

#include <stdlib.h>
#include <string.h>

RfModelMaterial rf_default_model_material( void )
{
    return ( RfModelMaterial ){
        .base_color = { 1, 1, 1, 1 },
        .roughness = 1.0f,
        .specular = 1.0f,
        .ior = 1.5f,
        .alpha_cutoff = 0.5f,
        .base_color_image = -1,
        .normal_image = -1,
        .emissive_image = -1,
    };
}

static void free_mesh( RfModelMesh* mesh )
{
    free( mesh->name );
    free( mesh->positions );
    free( mesh->normals );
    free( mesh->uvs );
    free( mesh->colors );
    free( mesh->indices );
}

void rf_destroy_model( RfModel* model )
{
    for ( int i = 0; model->meshes != NULL && i < model->mesh_count; ++i )
        free_mesh( model->meshes + i );
    for ( int i = 0; model->materials != NULL && i < model->material_count; ++i )
        free( model->materials[i].name );
    for ( int i = 0; model->images != NULL && i < model->image_count; ++i )
    {
        free( model->images[i].name );
        free( model->images[i].bytes );
    }
    for ( int i = 0; model->cameras != NULL && i < model->camera_count; ++i )
        free( model->cameras[i].name );
    for ( int i = 0; model->lights != NULL && i < model->light_count; ++i )
        free( model->lights[i].name );
    for ( int i = 0; model->nodes != NULL && i < model->node_count; ++i )
    {
        free( model->nodes[i].name );
        free( model->nodes[i].meshes );
    }
    free( model->meshes );
    free( model->materials );
    free( model->images );
    free( model->cameras );
    free( model->lights );
    free( model->nodes );
    memset( model, 0, sizeof *model );
}

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
