// Frees scenes and their parts, lists what is not rendered, and says how many frames per second a scene has.
#include "scene/scene.h"

#include "scene/camera_path/camera_track.h"
#include "scene/deformation.h"
#include "scene/image_sequence.h"
#include "scene/movement.h"

#include <stdlib.h>
#include <string.h>

void rf_destroy_punctual( RfPunctual* punctual )
{
    free( punctual->name );
    rf_release_profile( punctual->profile );
    memset( punctual, 0, sizeof *punctual );
}

RfFps rf_scene_fps( const RfScene* scene ) { return scene->fps.numerator > 0 ? scene->fps : ( RfFps ){ 24, 1 }; }

bool rf_note_unrendered( RfScene* scene, const char* what, const char* why )
{
    size_t count = (size_t)scene->unrendered_count;
    const RfUnrendered* last = count > 0 ? scene->unrendered + count - 1 : NULL;
    if ( last != NULL && strcmp( last->what, what ) == 0 && strcmp( last->why, why ) == 0 )
        return true;
    RfUnrendered* grown = realloc( scene->unrendered, ( count + 1 ) * sizeof *grown );
    if ( grown == NULL )
        return false;
    scene->unrendered = grown;
    RfUnrendered entry = { strdup( what ), strdup( why ) };
    scene->unrendered[scene->unrendered_count++] = entry;
    return entry.what != NULL && entry.why != NULL;
}

void rf_destroy_triangles( RfTriangles* triangles )
{
    free( triangles->positions );
    free( triangles->normals );
    free( triangles->uvs );
    free( triangles->uvs1 );
    free( triangles->colors );
    free( triangles->tangents );
    free( triangles->indices );
    free( triangles->material );
    memset( triangles, 0, sizeof *triangles );
}

void rf_destroy_camera( RfCamera* camera )
{
    if ( camera->track != NULL )
        rf_destroy_camera_track( camera->track );
    free( camera->track );
    if ( camera->edit != NULL )
        free( camera->edit->shots );
    free( camera->edit );
    free( camera->cuts );
    if ( camera->zoom != NULL )
        rf_destroy_channel( &camera->zoom->channel );
    free( camera->zoom );
    if ( camera->optics != NULL )
        rf_destroy_optics( camera->optics );
    free( camera->optics );
    free( camera->name );
    memset( camera, 0, sizeof *camera );
}

void rf_destroy_scene( RfScene* scene )
{
    if ( scene == NULL )
        return;
    rf_destroy_triangles( &scene->triangles );
    for ( int i = 0; scene->meshes != NULL && i < scene->mesh_count; ++i )
    {
        rf_destroy_triangles( &scene->meshes[i].triangles );
        rf_destroy_deformation( scene->meshes[i].deformation );
    }
    free( scene->meshes );
    free( scene->placements );
    free( scene->placement_blocks );
    rf_destroy_movement( scene->movement );
    for ( int i = 0; scene->unrendered != NULL && i < scene->unrendered_count; ++i )
    {
        free( scene->unrendered[i].what );
        free( scene->unrendered[i].why );
    }
    free( scene->unrendered );
    for ( uint32_t i = 0; scene->materials != NULL && i < scene->material_count; ++i )
    {
        free( scene->materials[i].name );
        free( scene->materials[i].textured );
    }
    for ( int i = 0; scene->textures != NULL && i < scene->texture_count; ++i )
        rf_destroy_texture( scene->textures + i );
    free( scene->textures );
    for ( int i = 0; scene->nodes != NULL && i < scene->node_count; ++i )
    {
        free( scene->nodes[i].name );
        free( scene->nodes[i].object );
        free( scene->nodes[i].asset );
    }
    free( scene->node_runs );
    for ( int i = 0; scene->channels != NULL && i < scene->channel_count; ++i )
        rf_destroy_channel( scene->channels + i );
    for ( int i = 0; scene->cameras != NULL && i < scene->camera_count; ++i )
        rf_destroy_camera( scene->cameras + i );
    for ( int i = 0; scene->punctuals != NULL && i < scene->punctual_count; ++i )
        rf_destroy_punctual( scene->punctuals + i );
    free( scene->punctuals );
    free( scene->environment.map );
    free( scene->materials );
    free( scene->nodes );
    free( scene->channels );
    free( scene->cameras );
    for ( int i = 0; i < scene->moving_count; ++i )
        free( scene->moving[i] );
    free( scene->moving );
    for ( int i = 0; i < scene->variant_count; ++i )
        free( scene->variants[i] );
    free( scene->variants );
    for ( int i = 0; i < scene->export_loss_count; ++i )
        free( scene->export_losses[i] );
    free( scene->export_losses );
    for ( int i = 0; i < scene->export_warning_count; ++i )
        free( scene->export_warnings[i] );
    free( scene->export_warnings );
    for ( int i = 0; i < scene->light_group_count; ++i )
        free( scene->light_groups[i] );
    free( scene->light_groups );
    free( scene->path );
    memset( scene, 0, sizeof *scene );
}
