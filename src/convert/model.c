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
