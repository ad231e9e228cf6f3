// A model's parts: its end, its root transform, what it counts, and whether glTF can hold it.
#include "convert/model.h"

#include "base/try.h"

#include <math.h>
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
        .base_color_texture = { .image = -1 },
        .normal_texture = { .image = -1 },
        .emissive_texture = { .image = -1 },
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
    for ( int i = 0; mesh->morphs != NULL && i < mesh->morph_count; ++i )
    {
        free( mesh->morphs[i].name );
        free( mesh->morphs[i].positions );
        free( mesh->morphs[i].normals );
    }
    free( mesh->morphs );
    if ( mesh->skin != NULL )
    {
        free( mesh->skin->joints );
        free( mesh->skin->inverse_binds );
        free( mesh->skin->influences );
        free( mesh->skin->weights );
    }
    free( mesh->skin );
}

static void free_animation( RfModelAnimation* animation )
{
    for ( int i = 0; animation->tracks != NULL && i < animation->track_count; ++i )
    {
        free( animation->tracks[i].times );
        free( animation->tracks[i].values );
    }
    free( animation->tracks );
    free( animation->name );
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
        free( model->nodes[i].weights );
    }
    for ( int i = 0; model->animations != NULL && i < model->animation_count; ++i )
        free_animation( model->animations + i );
    free( model->animations );
    free( model->meshes );
    free( model->materials );
    free( model->images );
    free( model->cameras );
    free( model->lights );
    free( model->nodes );
    memset( model, 0, sizeof *model );
}

void rf_split_matrix( const RfMat4* matrix, double translation[3], double rotation[4], double scale[3] )
{
    const double* m = matrix->m;
    double r[3][3]; // columns
    for ( int c = 0; c < 3; ++c )
    {
        translation[c] = m[12 + c];
        scale[c] = sqrt( m[4 * c] * m[4 * c] + m[4 * c + 1] * m[4 * c + 1] + m[4 * c + 2] * m[4 * c + 2] );
    }
    if ( rf_mat4_det3( matrix ) < 0.0 )
        scale[0] = -scale[0];
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < 3; ++i )
            r[c][i] = scale[c] != 0.0 ? m[4 * c + i] / scale[c] : c == i;
    }
    // 4 q qᵀ, of which the column with the largest diagonal element is taken
    const double sums[4] = { 1 + r[0][0] - r[1][1] - r[2][2], 1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2],
                             1 + r[0][0] + r[1][1] + r[2][2] };
    const double xy = r[0][1] + r[1][0], xz = r[0][2] + r[2][0], yz = r[1][2] + r[2][1];
    const double xw = r[1][2] - r[2][1], yw = r[2][0] - r[0][2], zw = r[0][1] - r[1][0];
    const double columns[4][4] = {
        { sums[0], xy, xz, xw }, { xy, sums[1], yz, yw }, { xz, yz, sums[2], zw }, { xw, yw, zw, sums[3] }
    };
    int best = 3;
    for ( int i = 0; i < 3; ++i )
        best = sums[i] > sums[best] ? i : best;
    memcpy( rotation, columns[best], sizeof columns[best] );
    rf_quat_normalize( rotation );
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
    {
        model->cameras[i].node += 1;
        model->cameras[i].xmag *= scale;
        model->cameras[i].ymag *= scale;
    }
    for ( int i = 0; i < model->light_count; ++i )
        model->lights[i].node += 1;
    for ( int i = 0; i < model->mesh_count; ++i )
    {
        const RfModelSkin* skin = model->meshes[i].skin;
        for ( int k = 0; skin != NULL && k < skin->joint_count; ++k )
            skin->joints[k] += 1;
    }
    for ( int i = 0; i < model->animation_count; ++i )
    {
        for ( int k = 0; k < model->animations[i].track_count; ++k )
            model->animations[i].tracks[k].node += 1;
    }
    return RF_OK;
}

RfModelCounts rf_count_model( const RfModel* model )
{
    RfModelCounts counts = { .meshes = model->mesh_count,
                             .nodes = model->node_count,
                             .materials = model->material_count,
                             .images = model->image_count,
                             .cameras = model->camera_count,
                             .lights = model->light_count,
                             .animations = model->animation_count };
    for ( int i = 0; i < model->mesh_count; ++i )
    {
        counts.triangles += model->meshes[i].triangle_count;
        counts.skins += model->meshes[i].skin != NULL;
        counts.morphs += model->meshes[i].morph_count;
    }
    return counts;
}

static bool all_finite( const float* values, uint64_t count )
{
    for ( uint64_t i = 0; values != NULL && i < count; ++i )
    {
        if ( !isfinite( values[i] ) )
            return false;
    }
    return true;
}

// Whether joints, influences and morph targets are within bounds and finite.
static bool is_pose_good( const RfModel* model, const RfModelMesh* mesh )
{
    uint64_t vertices = mesh->vertex_count;
    const RfModelSkin* skin = mesh->skin;
    bool good =
        skin == NULL || ( skin->joint_count > 0 && all_finite( skin->inverse_binds, 16ull * (unsigned)skin->joint_count ) &&
                          all_finite( skin->weights, RF_MODEL_INFLUENCES * vertices ) );
    for ( int i = 0; good && skin != NULL && i < skin->joint_count; ++i )
        good = skin->joints[i] >= 0 && skin->joints[i] < model->node_count;
    for ( uint64_t i = 0; good && skin != NULL && i < RF_MODEL_INFLUENCES * vertices; ++i )
        good = skin->influences[i] < skin->joint_count;
    for ( int i = 0; i < mesh->morph_count; ++i )
        good =
            good && all_finite( mesh->morphs[i].positions, 3 * vertices ) && all_finite( mesh->morphs[i].normals, 3 * vertices );
    return good;
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
    if ( !is_pose_good( model, mesh ) )
        return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': its skin or morph targets are out of range", index, name );
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
    const RfModelTexture* textures[3] = { &m->base_color_texture, &m->normal_texture, &m->emissive_texture };
    for ( int i = 0; i < 3; ++i )
    {
        const RfModelTexture* t = textures[i];
        good = good && t->image >= -1 && t->image < model->image_count && all_finite( t->scale, 2 ) && all_finite( t->offset, 2 );
    }
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
    {
        good = good && node->meshes[i] >= 0 && node->meshes[i] < model->mesh_count;
        const RfModelMesh* mesh = good ? model->meshes + node->meshes[i] : NULL;
        good = good && ( node->mesh_count == 1 || ( mesh->skin == NULL && mesh->morph_count == 0 ) );
        good = good && ( node->weights == NULL || all_finite( node->weights, (unsigned)mesh->morph_count ) );
    }
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
        bool seen = camera->xmag > 0.0 ? isfinite( camera->xmag ) && camera->ymag > 0.0 && isfinite( camera->ymag )
                                       : camera->yfov > 0.0 && camera->yfov < 3.14159265;
        if ( !seen || camera->node < 0 || camera->node >= model->node_count )
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

static RfResult check_animation( const RfModel* model, int index, RfError* error )
{
    const RfModelAnimation* animation = model->animations + index;
    bool good = animation->track_count > 0;
    for ( int i = 0; i < animation->track_count; ++i )
    {
        const RfModelTrack* track = animation->tracks + i;
        good = good && track->node >= 0 && track->node < model->node_count && track->key_count > 0 && track->times[0] >= 0.0f;
        good = good && all_finite( track->times, (unsigned)track->key_count ) &&
               all_finite( track->values, (uint64_t)track->key_count * (unsigned)track->width );
        for ( int k = 1; good && k < track->key_count; ++k )
            good = track->times[k] > track->times[k - 1];
    }
    if ( good )
        return RF_OK;
    return rf_fail( error, RF_ERROR_FORMAT, "animation %d '%s': its keys are out of range", index,
                    animation->name != NULL ? animation->name : "" );
}

RfResult rf_check_model( const RfModel* model, RfError* error )
{
    for ( int i = 0; i < model->mesh_count; ++i )
        RF_TRY( check_mesh( model, i, error ) );
    for ( int i = 0; i < model->material_count; ++i )
        RF_TRY( check_material( model, i, error ) );
    for ( int i = 0; i < model->node_count; ++i )
        RF_TRY( check_node( model, i, error ) );
    for ( int i = 0; i < model->animation_count; ++i )
        RF_TRY( check_animation( model, i, error ) );
    return check_lights_and_cameras( model, error );
}
