// Reads edits of cameras from scene files.
#include "scene/json/camera_edit.h"

#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/camera_path/camera_track_read.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_SHOTS 100000

static RfResult read_name( const RfField* item, const RfScene* scene, RfEditShot* shot )
{
    const char* name = NULL;
    RfField field = rf_field_member( item, "name" );
    RfError fault = { 0 };
    rf_field_require( item, "name", "the name of a camera in the glTF" );
    RfResult result = rf_field_text( &field, &name );
    if ( result != RF_OK )
        return result;
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
    RfResult result = edit->in_frames ? rf_field_number( &frame, rf_range( 2.0, RF_MAX_TRACK_FRAMES ), &shot->from )
                                      : rf_field_number( &time, rf_range( 0.0, RF_MAX_TRACK_SECONDS ), &shot->from );
    shot->from -= edit->in_frames ? 1.0 : 0.0; // frame 1 is at 0
    if ( result == RF_OK && index > 1 && !( shot->from > shot[-1].from ) )
        return rf_field_fail( edit->in_frames ? &frame : &time, "is not later than that of the camera before it" );
    return result;
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

RfResult rf_read_camera_edit( const RfField* list, const RfScene* scene, const char* name, RfCamera* camera )
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
