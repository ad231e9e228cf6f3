#include "convert/glb_document.h"

#include <math.h>

static bool all_finite( const float* values, uint64_t count )
{
    for ( uint64_t i = 0; values != NULL && i < count; ++i )
    {
        if ( !isfinite( values[i] ) )
            return false;
    }
    return true;
}

static RfResult check_mesh( const RfModel* model, int index, RfError* error )
{
    const RfModelMesh* mesh = model->meshes + index;
    const char* name = mesh->name != NULL ? mesh->name : "";
    uint64_t vertices = mesh->vertex_count, corners = 3ull * mesh->triangle_count;
    if ( vertices == 0 || corners == 0 || mesh->positions == NULL || mesh->indices == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': has no triangles", index, name );
    if ( mesh->material < -1 || mesh->material >= model->material_count )
        return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': there is no material %d", index, name, mesh->material );
    if ( !all_finite( mesh->positions, 3 * vertices ) || !all_finite( mesh->normals, 3 * vertices ) ||
         !all_finite( mesh->uvs, 2 * vertices ) || !all_finite( mesh->colors, 4 * vertices ) )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "mesh %d '%s': has coordinates that are not finite numbers: repair the file it came from", index, name );
    for ( uint64_t i = 0; i < corners; ++i )
    {
        if ( mesh->indices[i] >= vertices )
            return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': triangle %llu: there is no vertex %lu", index, name,
                            (unsigned long long)( i / 3 ), (unsigned long)mesh->indices[i] );
    }
    return RF_OK;
}

static bool within( float value, float low, float high )
{
    return value >= low && value <= high; // false for NaN
}

static RfResult check_material( const RfModel* model, int index, RfError* error )
{
    const RfModelMaterial* m = model->materials + index;
    bool good = within( m->metallic, 0, 1 ) && within( m->roughness, 0, 1 ) && within( m->specular, 0, 1 ) &&
                within( m->transmission, 0, 1 ) && within( m->alpha_cutoff, 0, 1 ) && m->ior >= 1.0f && isfinite( m->ior );
    for ( int i = 0; i < 4; ++i )
        good = good && within( m->base_color[i], 0, 1 );
    for ( int i = 0; i < 3; ++i )
        good = good && m->emission[i] >= 0.0f && isfinite( m->emission[i] );
    const int images[3] = { m->base_color_image, m->normal_image, m->emissive_image };
    for ( int i = 0; i < 3; ++i )
        good = good && images[i] >= -1 && images[i] < model->image_count;
    if ( good )
        return RF_OK;
    return rf_fail( error, RF_ERROR_FORMAT, "material %d '%s': has a value that glTF cannot hold", index,
                    m->name != NULL ? m->name : "" );
}

static RfResult check_node( const RfModel* model, int index, RfError* error )
{
    const RfModelNode* node = model->nodes + index;
    bool good = node->parent >= -1 && node->parent < index;
    for ( int i = 0; i < 16; ++i )
        good = good && isfinite( node->matrix.m[i] );
    for ( int i = 0; i < node->mesh_count; ++i )
        good = good && node->meshes[i] >= 0 && node->meshes[i] < model->mesh_count;
    if ( good )
        return RF_OK;
    return rf_fail( error, RF_ERROR_FORMAT, "node %d '%s': its parent, matrix or meshes are out of range", index,
                    node->name != NULL ? node->name : "" );
}

static RfResult check_lights_and_cameras( const RfModel* model, RfError* error )
{
    for ( int i = 0; i < model->camera_count; ++i )
    {
        const RfModelCamera* camera = model->cameras + i;
        if ( !( camera->yfov > 0.0 && camera->yfov < 3.14159265 ) || camera->node < 0 || camera->node >= model->node_count )
            return rf_fail( error, RF_ERROR_FORMAT, "camera %d: its field of view or node is out of range", i );
    }
    for ( int i = 0; i < model->light_count; ++i )
    {
        const RfModelLight* light = model->lights + i;
        bool good =
            light->node >= 0 && light->node < model->node_count && light->intensity >= 0.0f && isfinite( light->intensity );
        for ( int k = 0; k < 3; ++k )
            good = good && within( light->color[k], 0, 1 );
        if ( light->kind == RF_MODEL_SPOT )
            good =
                good && light->inner_angle >= 0.0f && light->inner_angle < light->outer_angle && light->outer_angle <= 1.5707964f;
        if ( !good )
            return rf_fail( error, RF_ERROR_FORMAT, "light %d: has a value that glTF cannot hold", i );
    }
    return RF_OK;
}

RfResult rf_check_model( const RfModel* model, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < model->mesh_count && result == RF_OK; ++i )
        result = check_mesh( model, i, error );
    for ( int i = 0; i < model->material_count && result == RF_OK; ++i )
        result = check_material( model, i, error );
    for ( int i = 0; i < model->node_count && result == RF_OK; ++i )
        result = check_node( model, i, error );
    return result == RF_OK ? check_lights_and_cameras( model, error ) : result;
}
