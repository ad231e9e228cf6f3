// Frees scenes and their parts, lists what is not rendered, and says how many frames per second a scene has.
#include "scene/scene.h"

#include "scene/camera_path/camera_track.h"
#include "scene/deformation.h"
#include "scene/movement.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void rf_destroy_punctual( RfPunctual* punctual )
{
    free( punctual->name );
    rf_release_profile( punctual->profile );
    memset( punctual, 0, sizeof *punctual );
}

#define MAX_WHOLE_FPS 1000000
#define MAX_FPS_PART 100000000
#define MAX_BROADCAST_FPS 240

bool rf_broadcast_fps( double decimal, RfFps* fps )
{
    double whole = round( 1.001 * decimal ), exact = whole / 1.001;
    bool stands = false;
    if ( !( whole >= 1.0 && whole <= MAX_BROADCAST_FPS ) || ( (int)whole % 24 != 0 && (int)whole % 30 != 0 ) )
        return false;
    for ( double unit = 100.0; unit < 1e16 && !stands; unit *= 10.0 )
        stands = fabs( round( exact * unit ) / unit - decimal ) < 1e-12 * decimal;
    if ( stands )
        *fps = ( RfFps ){ 1000 * (int)whole, 1001 };
    return stands;
}

bool rf_parse_fps( const char* text, RfFps* fps )
{
    size_t length = strspn( text, "0123456789" );
    char* end;
    if ( length == 0 || length > 9 )
        return false;
    long whole = strtol( text, &end, 10 ), part = 1;
    if ( *end == '.' && isdigit( (unsigned char)end[1] ) && strspn( end + 1, "0123456789" ) == strlen( end + 1 ) )
        return rf_broadcast_fps( strtod( text, NULL ), fps );
    if ( *end == '/' )
    {
        length = strspn( end + 1, "0123456789" );
        part = length > 0 && length <= 9 ? strtol( end + 1, &end, 10 ) : 0;
    }
    long most = part == 1 ? MAX_WHOLE_FPS : MAX_FPS_PART;
    if ( *end != '\0' || whole < 1 || whole > most || part < 1 || part > MAX_FPS_PART )
        return false;
    *fps = ( RfFps ){ (int)whole, (int)part };
    return true;
}

RfFps rf_scene_fps( const RfScene* scene ) { return scene->fps.numerator > 0 ? scene->fps : ( RfFps ){ 24, 1 }; }

bool rf_make_room( void* list, size_t count, size_t size )
{
    void* old;
    memcpy( &old, list, sizeof old );
    void* grown = realloc( old, ( count + 1 ) * size );
    if ( grown != NULL )
        memcpy( list, &grown, sizeof grown );
    return grown != NULL;
}

bool rf_note_unrendered( RfScene* scene, const char* what, const char* why )
{
    int count = scene->unrendered_count;
    const RfUnrendered* last = count > 0 ? scene->unrendered + count - 1 : NULL;
    if ( last != NULL && strcmp( last->what, what ) == 0 && strcmp( last->why, why ) == 0 )
        return true;
    if ( !rf_make_room( &scene->unrendered, (size_t)count, sizeof *scene->unrendered ) )
        return false;
    RfUnrendered entry = { strdup( what ), strdup( why ) };
    scene->unrendered[scene->unrendered_count++] = entry;
    return entry.what != NULL && entry.why != NULL;
}

const RfAttributeTraits g_rf_attributes[RF_ATTRIBUTE_COUNT] = {
    [RF_POSITION] = { offsetof( RfTriangles, positions ), 3, 0.0f },
    [RF_NORMAL] = { offsetof( RfTriangles, normals ), 3, 0.0f },
    [RF_UV] = { offsetof( RfTriangles, uvs ), 2, 0.0f },
    [RF_UV1] = { offsetof( RfTriangles, uvs1 ), 2, 0.0f },
    [RF_COLOR] = { offsetof( RfTriangles, colors ), 4, 1.0f },
    [RF_TANGENT] = { offsetof( RfTriangles, tangents ), 4, 0.0f },
};

void rf_destroy_triangles( RfTriangles* triangles )
{
    for ( int a = 0; a < RF_ATTRIBUTE_COUNT; ++a )
        free( *rf_attribute( triangles, a ) );
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

void rf_destroy_channel( RfChannel* channel )
{
    if ( channel->curve != NULL )
        rf_destroy_curve( channel->curve );
    free( channel->curve );
    free( channel->times );
    free( channel->values );
    memset( channel, 0, sizeof *channel );
}

void rf_destroy_movement( RfMovement* movement )
{
    if ( movement == NULL )
        return;
    for ( int i = 0; movement->skins != NULL && i < movement->skin_count; ++i )
    {
        free( movement->skins[i].joints );
        free( movement->skins[i].inverse_binds );
    }
    for ( int i = 0; movement->movers != NULL && i < movement->mover_count; ++i )
        free( movement->movers[i].weights );
    for ( int i = 0; movement->changes != NULL && i < movement->change_count; ++i )
        rf_destroy_channel( &movement->changes[i].channel );
    for ( int i = 0; movement->sequences != NULL && i < movement->sequence_count; ++i )
        free( movement->sequences[i].pattern );
    free( movement->sequences );
    free( movement->lamps );
    free( movement->materials );
    free( movement->changes );
    free( movement->nodes );
    free( movement->skins );
    free( movement->movers );
    free( movement );
}

static void free_texts( char** texts, int count )
{
    for ( int i = 0; i < count; ++i )
        free( texts[i] );
    free( texts );
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
    free_texts( scene->moving, scene->moving_count );
    free_texts( scene->variants, scene->variant_count );
    free_texts( scene->losses, scene->loss_count );
    free_texts( scene->export_losses, scene->export_loss_count );
    free_texts( scene->export_warnings, scene->export_warning_count );
    free_texts( scene->light_groups, scene->light_group_count );
    free( scene->path );
    memset( scene, 0, sizeof *scene );
}

RfResult rf_check_rendered( const RfScene* scene, RfError* error )
{
    int more = scene->unrendered_count - 1;
    char rest[32] = "";
    if ( more < 0 || scene->frozen )
        return RF_OK;
    if ( more > 0 )
        snprintf( rest, sizeof rest, " (and %d more)", more );
    return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: %s: %s%s: take it out, or freeze all as in the first frame (--freeze)",
                    scene->path, scene->unrendered->what, scene->unrendered->why, rest );
}
