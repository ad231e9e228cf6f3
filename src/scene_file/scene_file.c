// Opens a scene file: the glTF that it names with its materials overridden, objects, environment and camera path.
#include "scene_file/scene_file.h"

#include "base/file.h"
#include "base/try.h"
#include "base/words.h"
#include "gltf/gltf_document.h"
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/light_groups.h"
#include "scene/shared_json.h"
#include "scene/twins.h"
#include "scene_file/objects.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char* const s_keys[] = {
    "scene", "environment", "materials", "lights", "objects", "camera", "render", "view", NULL
};

static RfResult check_document( const RfJsonDocument* document, RfError* error )
{
    RfField root = rf_root_field( document, error );
    if ( rf_has_member( &root, "asset" ) )
        return rf_field_fail( &root, "is a glTF: give it a name that ends in .gltf" );
    rf_field_keys( &root, s_keys );
    return rf_field_require( &root, "scene", "the name of a .glb or .gltf file" );
}

RfResult rf_open_scene_file( const char* path, RfSceneFile* file, RfError* error )
{
    *file = ( RfSceneFile ){ .path = strdup( path ) };
    RfResult result = file->path != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", path );
    if ( result == RF_OK && rf_ends_with( path, ".json" ) )
    {
        result = rf_open_json( path, &file->document, error );
        if ( result == RF_OK )
            result = check_document( &file->document, error );
    }
    if ( result != RF_OK )
        rf_close_scene_file( file );
    return result;
}

void rf_close_scene_file( RfSceneFile* file )
{
    rf_close_json( &file->document );
    free( file->path );
    *file = ( RfSceneFile ){ 0 };
}

RfField rf_scene_file_defaults( const RfSceneFile* file, RfError* error )
{
    RfField root = rf_root_field( &file->document, error );
    root.file = file->path; // also of a glTF, which has none
    return rf_field_member( &root, "render" );
}

// Is a light group all that is said of the environment, which is the glTF's?
static bool only_tags( const RfField* environment )
{
    return json_object_size( environment->json ) == 1 && rf_has_member( environment, "light_group" );
}

// How a scene is read.
typedef struct Reading
{
    const RfSceneOptions* options;
    const double* frozen_at; // seconds; NULL: as the glTF's own default camera has its first frame
    RfLog* log;
    RfFps fps; // that the scene file asks for; 0/0: it does not
} Reading;

static RfResult read_fps( const RfField* root, RfFps* fps )
{
    RfField render = rf_field_member( root, "render" ), field = rf_field_member( &render, "fps" );
    char number[40];
    if ( field.json == NULL )
        return RF_OK;
    const char* text = json_string_value( field.json );
    snprintf( number, sizeof number, "%.9g", json_number_value( field.json ) );
    return rf_parse_fps( text != NULL ? text : number, fps )
               ? RF_OK
               : rf_field_must_be( &field, "a whole number, 29.97 and the like, or a fraction such as \"30000/1001\"" );
}

// What is read with the glTF.
typedef struct Survey
{
    RfField list; // of the objects
    RfFps fps;    // at which their keys count frames; 0/0: at those that the glTF asks for
    RfObjects objects;
    RfChannel* channels; // their keys are the objects'
    RfGltfOptions* options;
} Survey;

// Reads what moves in the document. What objects place is not loaded yet.
static RfResult survey( void* user, const json_t* root, RfError* error )
{
    Survey* s = user;
    RfFps fps = s->fps.numerator > 0 ? s->fps : rf_gltf_document_fps( root );
    rf_destroy_objects( &s->objects ); // where the file is read again
    free( s->channels );
    s->list.error = error;
    RfResult result = rf_read_objects( &s->list, fps, &s->objects );
    s->options->channels = s->channels = calloc( (size_t)s->objects.count * RF_OBJECT_PATHS + 1, sizeof *s->channels );
    if ( result != RF_OK || s->channels == NULL )
        return result != RF_OK ? result : rf_field_no_memory( &s->list );
    return rf_find_nodes( &s->objects, root, s->channels, &s->options->channel_count );
}

static RfResult load_gltf( const RfField* root, const Reading* reading, RfScene* scene )
{
    const char* name = NULL;
    RfField field = rf_field_member( root, "scene" ), environment = rf_field_member( root, "environment" );
    bool in_frames = false, given = reading->fps.numerator > 0;
    RfResult result = rf_field_text( &field, &name );
    if ( result == RF_OK && rf_ends_with( name, ".json" ) )
        return rf_field_must_be( &field, "a .glb or .gltf file" );
    char* path = result == RF_OK ? rf_path_beside( root->file, name ) : NULL;
    if ( path == NULL )
        return result != RF_OK ? result : rf_field_no_memory( root );
    RfGltfOptions options = { .freeze = reading->options->freeze,
                              .animation = reading->options->animation,
                              .accept_losses = reading->options->accept_losses,
                              .variant = reading->options->variant,
                              .materials = rf_field_member( root, "materials" ),
                              .lights = rf_field_member( root, "lights" ),
                              .survey = survey,
                              .no_environment = environment.json != NULL && !only_tags( &environment ),
                              .fps = reading->fps,
                              .in_frames = &in_frames,
                              .frozen_at = reading->frozen_at };
    Survey s = { .list = rf_field_member( root, "objects" ), .fps = reading->fps, .options = &options };
    options.user = &s;
    result = rf_load_gltf_with( path, &options, scene, reading->log, root->error );
    free( path );
    in_frames = in_frames || s.objects.in_frames;
    if ( result == RF_OK && in_frames && given )
        scene->fps = reading->fps;
    if ( result == RF_OK && in_frames && scene->key_fps.numerator == 0 ) // else the glTF's environment has some
        scene->key_fps = rf_scene_fps( scene );
    if ( result == RF_OK )
    {
        double first = reading->frozen_at != NULL ? *reading->frozen_at : rf_gltf_first_time( scene );
        result = rf_place_files( &s.objects, given ? reading->fps : rf_scene_fps( scene ),
                                 reading->options->freeze ? &first : NULL, reading->options->accept_losses, scene, reading->log );
    }
    rf_destroy_objects( &s.objects );
    free( s.channels );
    return result;
}

static RfResult read_environment( const RfField* field, RfFps fps, RfEnvironmentText* text )
{
    RfResult result = rf_read_environment( field, false, fps, text );
    if ( result != RF_OK || text->map == NULL )
        return result;
    char* path = rf_path_beside( field->file, text->map );
    result = path != NULL ? rf_load_environment( field, path, text ) : rf_field_no_memory( field );
    free( path );
    return result;
}

static RfResult tag_environment( const RfField* field, RfScene* scene )
{
    const char* name = NULL;
    RF_TRY( rf_read_light_group( field, &name ) );
    if ( scene->environment.map == NULL && rf_max_component( scene->environment.radiance ) <= 0.0f &&
         !scene->environment.changes )
        return rf_field_fail( field, "the scene has none: give radiance, map or both" );
    return rf_tag_light( scene, name, &scene->environment.light_group ) ? RF_OK : rf_field_no_memory( field );
}

static RfResult load_environment( const RfField* root, const Reading* reading, RfScene* scene )
{
    RfField field = rf_field_member( root, "environment" );
    RfEnvironmentText text;
    bool given = reading->fps.numerator > 0;
    RfFps fps = given ? reading->fps : rf_scene_fps( scene );
    if ( field.json == NULL )
        return RF_OK;
    if ( only_tags( &field ) )
        return tag_environment( &field, scene );
    RfResult result = read_environment( &field, fps, &text );
    if ( result == RF_OK )
        scene->content_hash = rf_hash_environment( scene->content_hash, &text.environment );
    if ( result == RF_OK )
        result = rf_give_environment( &field, &text, scene, reading->log );
    if ( result == RF_OK && text.in_frames && scene->key_fps.numerator == 0 )
        scene->key_fps = fps;
    if ( result == RF_OK && text.in_frames && given )
        scene->fps = fps;
    rf_destroy_environment_text( &text );
    return result;
}

// What --freeze still has to freeze: the file's own environment.
static RfResult freeze_rest( const Reading* reading, RfScene* scene, RfError* error )
{
    if ( !reading->options->freeze || !scene->environment.changes )
        return RF_OK;
    rf_warn( reading->log, "%s: the environment changes: frozen as in the first frame", scene->path );
    double first = reading->frozen_at != NULL ? *reading->frozen_at : rf_gltf_first_time( scene );
    return rf_freeze_environment( scene, first, error );
}

static bool is_name_taken( const RfScene* scene, const char* name )
{
    for ( int i = 0; i < scene->camera_count; ++i )
    {
        if ( strcmp( scene->cameras[i].name, name ) == 0 )
            return true;
    }
    return false;
}

// Appends the camera and selects it. Takes ownership of the camera, or destroys it on failure.
static RfResult add_camera( const RfField* field, RfScene* scene, RfCamera* camera )
{
    if ( !rf_make_room( &scene->cameras, (size_t)scene->camera_count, sizeof *scene->cameras ) )
    {
        rf_destroy_camera( camera );
        return rf_field_no_memory( field );
    }
    scene->cameras[scene->camera_count++] = *camera;
    scene->chosen_camera = scene->camera_count;
    if ( camera->track != NULL ) // else it is in this file, whose hash is added
        scene->content_hash = rf_hash_bytes( scene->content_hash, &camera->track->hash, sizeof camera->track->hash );
    return RF_OK;
}

static RfResult choose_camera( const RfField* field, const char* name, RfScene* scene )
{
    int index;
    RfError error = { 0 };
    RfResult result = rf_find_camera( scene, name, &index, &error );
    if ( result != RF_OK ) // the scene file's fault, not the command line's
        return rf_field_fail_as( field, RF_ERROR_SCENE, &error );
    scene->chosen_camera = index + 1;
    return RF_OK;
}

static RfResult load_path_file( const RfField* field, const char* name, RfScene* scene )
{
    RfCamera camera;
    RfError error = { 0 };
    char* path = rf_path_beside( field->file, name );
    if ( path == NULL )
        return rf_field_no_memory( field );
    RfResult result = rf_load_camera( path, &camera, &error );
    free( path );
    return result == RF_OK ? add_camera( field, scene, &camera ) : rf_field_fail_as( field, result, &error );
}

// The camera of a scene file that is an edit: a list of { "name": a camera of the scene, "time": seconds or "frame": its first }
// (scenes/scene.schema.json), one after the other.

#define MOST_SHOTS 100000

static RfResult read_name( const RfField* item, const RfScene* scene, RfEditShot* shot )
{
    const char* name = NULL;
    RfField field = rf_field_member( item, "name" );
    RfError fault = { 0 };
    rf_field_require( item, "name", "the name of a camera in the glTF" );
    RF_TRY( rf_field_text( &field, &name ) );
    if ( rf_find_camera( scene, name, &shot->camera, &fault ) != RF_OK )
        return rf_field_fail( &field, "%.700s", fault.text );
    const RfCameraTrack* track = scene->cameras[shot->camera].track;
    if ( track != NULL && track->in_frames )
        return rf_field_fail(
            &field, "camera '%.60s' counts frames of its own, not the scene's seconds: it cannot be part of an edit", name );
    return RF_OK;
}

static RfResult read_begin( const RfField* item, int index, RfEdit* edit )
{
    RfField time = rf_field_member( item, "time" ), frame = rf_field_member( item, "frame" );
    RfEditShot* shot = edit->shots + index;
    if ( index == 0 && ( time.json != NULL || frame.json != NULL ) )
        return rf_field_fail( item, "the first camera shows the first frame: it has neither time nor frame" );
    if ( index == 0 )
        return RF_OK;
    if ( ( time.json != NULL ) == ( frame.json != NULL ) )
        return rf_field_fail( item, "give either time (seconds) or frame, at which this camera takes over" );
    edit->in_frames = index == 1 ? frame.json != NULL : edit->in_frames;
    if ( edit->in_frames != ( frame.json != NULL ) )
        return rf_field_fail( item, "give all cameras a time, or all a frame" );
    RF_TRY( edit->in_frames ? rf_field_number( &frame, rf_range( 2.0, RF_MAX_TRACK_FRAMES ), &shot->from )
                            : rf_field_number( &time, rf_range( 0.0, RF_MAX_TRACK_SECONDS ), &shot->from ) );
    shot->from -= edit->in_frames ? 1.0 : 0.0; // frame 1 is at 0
    if ( index > 1 && !( shot->from > shot[-1].from ) )
        return rf_field_fail( edit->in_frames ? &frame : &time, "is not later than that of the camera before it" );
    return RF_OK;
}

static RfResult read_shot( const RfField* item, int index, const RfScene* scene, RfEdit* edit )
{
    static const char* const s_keys[] = { "name", "time", "frame", NULL };
    rf_field_keys( item, s_keys );
    RfResult result = read_name( item, scene, edit->shots + index );
    return result == RF_OK ? read_begin( item, index, edit ) : result;
}

// To the last key of the cameras that it shows, and to the last cut.
static void find_end( const RfScene* scene, RfCamera* camera )
{
    const RfEdit* edit = camera->edit;
    for ( int i = 0; i < edit->count; ++i )
    {
        const RfCamera* shown = scene->cameras + edit->shots[i].camera;
        camera->end = shown->animated ? fmax( camera->end, shown->end ) : camera->end;
    }
    if ( !edit->in_frames )
        camera->end = fmax( camera->end, edit->shots[edit->count - 1].from );
}

// It lasts as long as its cameras and the scene move. `name` is copied.
static RfResult read_camera_edit( const RfField* list, const RfScene* scene, const char* name, RfCamera* camera )
{
    *camera = ( RfCamera ){ .node = -1, .animated = true };
    RfResult result = rf_field_array( list, "cameras", 1, MOST_SHOTS );
    if ( result != RF_OK )
        return result;
    size_t count = json_array_size( list->json );
    camera->name = strdup( name );
    camera->edit = calloc( 1, sizeof *camera->edit );
    if ( camera->edit != NULL )
        camera->edit->shots = calloc( count, sizeof *camera->edit->shots );
    if ( camera->name == NULL || camera->edit == NULL || camera->edit->shots == NULL )
        result = rf_field_no_memory( list );
    for ( size_t i = 0; i < count && result == RF_OK; ++i )
    {
        RfField item = rf_field_item( list, i );
        result = read_shot( &item, (int)i, scene, camera->edit );
    }
    if ( result != RF_OK )
    {
        rf_destroy_camera( camera );
        return result;
    }
    camera->edit->count = (int)count;
    const RfCamera* first = scene->cameras + camera->edit->shots[0].camera; // by which `info` describes it
    camera->projection = first->track != NULL ? (int)first->track->projection : first->projection;
    find_end( scene, camera );
    return RF_OK;
}

static RfResult load_camera( const RfField* root, RfScene* scene )
{
    RfField field = rf_field_member( root, "camera" );
    if ( field.json == NULL )
        return RF_OK;
    bool edit = json_is_array( field.json );
    if ( json_is_object( field.json ) || edit )
    {
        RfCamera camera;
        const char* kind = edit ? "edit" : "path";
        char name[32];
        snprintf( name, sizeof name, "%s", kind );
        for ( int i = 2; is_name_taken( scene, name ); ++i )
            snprintf( name, sizeof name, "%s#%d", kind, i );
        RfResult result = edit ? read_camera_edit( &field, scene, name, &camera ) : rf_read_camera( &field, name, &camera );
        return result == RF_OK ? add_camera( &field, scene, &camera ) : result;
    }
    const char* name = NULL;
    if ( !json_is_string( field.json ) )
        return rf_field_must_be( &field, "the name of a camera, a camera-path file (.json), a camera path or a list of cameras" );
    RF_TRY( rf_field_text( &field, &name ) );
    return rf_ends_with( name, ".json" ) ? load_path_file( &field, name, scene ) : choose_camera( &field, name, scene );
}

static RfResult rename_scene( const RfSceneFile* file, RfScene* scene, RfError* error )
{
    char* path = strdup( file->path );
    if ( path == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", file->path );
    free( scene->path );
    scene->path = path;
    scene->content_hash = rf_hash_bytes( scene->content_hash, &file->document.hash, sizeof file->document.hash );
    return RF_OK;
}

// `first`: when the glTF's own camera has its first frame, and when the scene's has.
static RfResult load_all( const RfSceneFile* file, Reading* reading, RfScene* scene, double first[2], RfError* error )
{
    RfField root = rf_root_field( &file->document, error ), view = rf_field_member( &root, "view" );
    RfResult result = read_fps( &root, &reading->fps );
    if ( result == RF_OK )
        result = load_gltf( &root, reading, scene );
    first[0] = result == RF_OK ? rf_gltf_first_time( scene ) : 0.0;
    if ( result == RF_OK )
        result = load_environment( &root, reading, scene );
    if ( result == RF_OK )
        result = load_camera( &root, scene );
    if ( result == RF_OK )
        result = rf_read_view( &view, &scene->view );
    if ( result == RF_OK )
        result = rename_scene( file, scene, error );
    first[1] = result == RF_OK ? rf_gltf_first_time( scene ) : 0.0;
    if ( result == RF_OK )
        result = freeze_rest( reading, scene, error );
    if ( result != RF_OK )
        rf_destroy_scene( scene );
    return result;
}

static RfResult load( const RfSceneFile* file, const RfSceneOptions* options, RfScene* scene, RfLog* log, RfError* error )
{
    RfGltfOptions plain = { .freeze = options->freeze,
                            .animation = options->animation,
                            .accept_losses = options->accept_losses,
                            .variant = options->variant };
    Reading reading = { .options = options, .log = log };
    double first[2], same[2];
    if ( file->document.root == NULL )
        return rf_load_gltf_with( file->path, &plain, scene, log, error );
    memset( scene, 0, sizeof *scene );
    RfResult result = load_all( file, &reading, scene, first, error );
    if ( result != RF_OK || !scene->frozen || first[0] == first[1] )
        return result;
    rf_destroy_scene( scene );
    Reading again = { .options = options, .frozen_at = first + 1 };
    return load_all( file, &again, scene, same, error );
}

RfResult rf_load_scene_file( const RfSceneFile* file, const RfSceneOptions* options, RfScene* scene, RfLog* log, RfError* error )
{
    RF_TRY( load( file, options, scene, log, error ) );
    RfResult result = rf_take_out_twins( scene, log, error );
    if ( result != RF_OK )
        rf_destroy_scene( scene );
    return result;
}

RfResult rf_load_scene( const char* path, RfScene* scene, RfLog* log, RfError* error )
{
    return rf_load_scene_with( path, &( RfSceneOptions ){ 0 }, scene, log, error );
}

RfResult rf_load_scene_with( const char* path, const RfSceneOptions* options, RfScene* scene, RfLog* log, RfError* error )
{
    RfSceneFile file;
    memset( scene, 0, sizeof *scene );
    RF_TRY( rf_open_scene_file( path, &file, error ) );
    RfResult result = rf_load_scene_file( &file, options, scene, log, error );
    rf_close_scene_file( &file );
    return result;
}

RfResult rf_open_scene( const char* path, RfScene** scene, RfLog* log, RfError* error )
{
    return rf_open_scene_with( path, &( RfSceneOptions ){ 0 }, scene, log, error );
}

RfResult rf_open_scene_with( const char* path, const RfSceneOptions* options, RfScene** scene, RfLog* log, RfError* error )
{
    *scene = calloc( 1, sizeof **scene );
    if ( *scene == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", path );
    RfResult result = rf_load_scene_with( path, options, *scene, log, error );
    if ( result != RF_OK )
    {
        rf_close_scene( *scene );
        *scene = NULL;
    }
    return result;
}

void rf_close_scene( RfScene* scene )
{
    if ( scene != NULL )
        rf_destroy_scene( scene );
    free( scene );
}
