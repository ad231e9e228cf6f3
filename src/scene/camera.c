// A camera of a scene at a moment, as an RfEye: its place, its lens, its shutter. Projections: scene/projection.h.
#include "scene/camera.h"

#include "base/json.h"
#include "base/try.h"
#include "base/words.h"
#include "scene/camera_path/camera_track.h"
#include "scene/leave_out.h"
#include "scene/movement.h"
#include "scene/projection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

RfEye rf_make_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double yfov, int width, int height )
{
    return rf_make_eye_inline( origin, forward, up, yfov, width, height );
}

RfEye rf_make_orthographic_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double ymag, int width, int height )
{
    RfEye eye = rf_make_eye_inline( origin, forward, up, 1.0, width, height );
    eye.projection = RF_ORTHOGRAPHIC;
    eye.focal = eye.focal_x = rf_pixels_over( 0.5 * (double)height, ymag );
    return eye;
}

RfEye rf_make_panoramic_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, int width, int height )
{
    RfEye eye = rf_make_eye_inline( origin, forward, up, 1.0, width, height );
    const double pi = 3.14159265358979323846;
    eye.projection = RF_PANORAMIC;
    eye.focal = (float)( (double)height / pi );
    eye.focal_x = (float)( (double)width / ( 2.0 * pi ) );
    return eye;
}

void rf_shift_eye( RfEye* eye, double pixel_aspect, double shift_x, double shift_y )
{
    double height = (double)eye->height;
    eye->focal_x = rf_pixels_over( (double)eye->focal, pixel_aspect );
    if ( eye->focal_x == 0.0f ) // which renders refuse
        return;
    eye->axis_x = (float)( 0.5 * (double)eye->width - shift_x * height / pixel_aspect );
    eye->axis_y = (float)( 0.5 * height + shift_y * height );
}

void rf_eye_matrices( const RfEye* eye, float world_to_camera[16], float world_to_ndc[16] )
{
    const double none[3] = { 0.0, 0.0, 0.0 };
    rf_eye_matrices_around( eye, none, world_to_camera, world_to_ndc );
}

void rf_eye_matrices_around( const RfEye* eye, const double origin[3], float world_to_camera[16], float world_to_ndc[16] )
{
    const double o[3] = { origin[0] + eye->origin.x, origin[1] + eye->origin.y, origin[2] + eye->origin.z };
    const RfVec3 axes[3] = { eye->right, eye->up, rf_scale( eye->forward, -1.0f ) };
    double camera[4][4] = { { 0 } };
    for ( int j = 0; j < 3; ++j )
    {
        camera[0][j] = axes[j].x;
        camera[1][j] = axes[j].y;
        camera[2][j] = axes[j].z;
        camera[3][j] = -( o[0] * axes[j].x + o[1] * axes[j].y + o[2] * axes[j].z );
    }
    camera[3][3] = 1.0;
    const double near = 0.01, far = 1000.0;
    double x_scale = 2.0 * eye->focal_x / eye->width, y_scale = 2.0 * eye->focal / eye->height;
    // 0 unless the lens is shifted
    double x_shift = 2.0 * eye->axis_x / eye->width - 1.0, y_shift = 1.0 - 2.0 * eye->axis_y / eye->height;
    for ( int i = 0; i < 4; ++i )
    {
        const double* row = camera[i];
        for ( int j = 0; j < 4; ++j )
            world_to_camera[4 * i + j] = (float)row[j];
        float* ndc = world_to_ndc + 4 * i;
        switch ( rf_projection_of( eye ) )
        {
            case RF_PERSPECTIVE:
                ndc[0] = (float)( x_scale * row[0] - x_shift * row[2] );
                ndc[1] = (float)( y_scale * row[1] - y_shift * row[2] );
                ndc[2] = (float)( -row[2] - 2.0 * near * row[3] );
                ndc[3] = (float)-row[2];
                break;
            case RF_ORTHOGRAPHIC:
                ndc[0] = (float)( x_scale * row[0] + x_shift * row[3] );
                ndc[1] = (float)( y_scale * row[1] + y_shift * row[3] );
                ndc[2] = (float)( -2.0 * row[2] / ( far - near ) - row[3] * ( far + near ) / ( far - near ) );
                ndc[3] = (float)row[3];
                break;
            case RF_PANORAMIC: memset( ndc, 0, 4 * sizeof *ndc ); break;
        }
    }
}

#define MAX_FRAMES 1000000
#define NAMES_LISTED 12

// Beyond this coordinate a float has no precision left for a camera.
#define MAX_COORDINATE 1e15

static void list_names( const RfScene* scene, char* text, size_t size )
{
    for ( int i = 0; i < scene->camera_count && i < NAMES_LISTED; ++i )
        rf_append( text, size, "%s'%.40s'", i > 0 ? ", " : "", scene->cameras[i].name );
    if ( scene->camera_count > NAMES_LISTED )
        rf_append( text, size, " and %d more", scene->camera_count - NAMES_LISTED );
}

static int default_camera( const RfScene* scene )
{
    if ( scene->chosen_camera > 0 )
        return scene->chosen_camera - 1;
    for ( int i = 0; i < scene->camera_count; ++i )
    {
        if ( scene->cameras[i].animated )
            return i;
    }
    return 0;
}

RfResult rf_find_camera( const RfScene* scene, const char* name, int* index, RfError* error )
{
    const char* path = scene->path != NULL ? scene->path : "scene";
    *index = -1;
    if ( scene->camera_count == 0 )
        return rf_fail( error, RF_ERROR_SCENE,
                        "%s: has no camera: export one from the modelling program, or give it one in a scene file", path );
    if ( name == NULL )
    {
        *index = default_camera( scene );
        return RF_OK;
    }
    for ( int i = 0; i < scene->camera_count; ++i )
    {
        if ( strcmp( scene->cameras[i].name, name ) == 0 )
        {
            *index = i;
            return RF_OK;
        }
    }
    char names[640] = "";
    list_names( scene, names, sizeof names );
    return rf_fail( error, RF_ERROR_USAGE, "%s: has no camera '%.60s': choose one of %s", path, name, names );
}

// Times are in the camera's unit: seconds, or frames where its path counts these.
static bool counts_frames( const RfCamera* camera ) { return camera->track != NULL && camera->track->in_frames; }

// The time of the first frame: 0 s, and of a path by frame numbers that of its first. One key alone names no range: where something
// moves, its frames begin with 1.
static double first_time( const RfScene* scene, const RfCamera* camera )
{
    if ( !counts_frames( camera ) )
        return 0.0;
    bool still = !camera->animated && camera->track->kind == RF_TRACK_KEYED && scene->movement != NULL;
    int step = camera->track->step;
    return still && camera->start > 0.0 ? camera->start - step * floor( camera->start / step ) : camera->start;
}

// The time up to which there are frames: to the camera's last key and that of all that moves, unless its path says how long it is.
static double last_time( const RfScene* scene, const RfCamera* camera, double fps )
{
    const RfCameraTrack* track = camera->track;
    bool counts = counts_frames( camera ), moves = camera->animated && camera->end > camera->start;
    bool is_given = track != NULL && ( track->kind != RF_TRACK_KEYED || ( counts && camera->animated ) );
    double end = moves || counts ? camera->end : 0.0;
    if ( is_given || scene->movement == NULL )
        return end;
    return fmax( end, counts ? scene->movement->end * fps : scene->movement->end );
}

// Blames the file: most often its times are wrong.
static RfResult fail_too_long( const RfScene* scene, const RfCamera* camera, double fps, double duration, RfError* error )
{
    if ( camera->track != NULL )
        return rf_fail( error, RF_ERROR_SCENE,
                        "%s: %g s at %g frames/s are more than %d frames: shorten it or lower the frames per second",
                        camera->track->clock, duration, fps, MAX_FRAMES );
    return rf_fail( error, RF_ERROR_SCENE,
                    "%s: camera '%.60s': its animation of %g s at %g frames/s is more than %d frames: shorten it or lower the "
                    "frames per second",
                    scene->path != NULL ? scene->path : "scene", camera->name, duration, fps, MAX_FRAMES );
}

RfResult rf_camera_frames( const RfScene* scene, const RfCamera* camera, double fps, RfCameraFrames* frames, RfError* error )
{
    bool counts = counts_frames( camera );
    double first = first_time( scene, camera );
    *frames = ( RfCameraFrames ){ .first = floor( first ) == first ? (int)first + 1 : 1, .step = 1, .count = 1 };
    if ( isfinite( fps ) == 0 || fps <= 0.0 )
        return rf_fail( error, RF_ERROR_USAGE, "camera '%.60s': frames per second must be above 0, got %g", camera->name, fps );
    frames->step = counts ? camera->track->step : 1;
    double duration = last_time( scene, camera, fps ) - first;
    // key times written as floats miss their frame slightly
    double count = floor( duration * ( counts ? 1.0 / frames->step : fps ) + 1e-3 ) + 1.0;
    if ( camera->edit != NULL && camera->edit->in_frames )
        count = fmax( count, floor( camera->edit->shots[camera->edit->count - 1].from ) + 1.0 );
    if ( ( count <= (double)MAX_FRAMES ) == false )
        return fail_too_long( scene, camera, fps, duration, error );
    frames->count = count > 1.0 ? (int)count : 1;
    return RF_OK;
}

void rf_node_world_matrix( const RfScene* scene, int node, double time, RfMat4* matrix )
{
    *matrix = rf_mat4_identity();
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        RfMat4 local;
        rf_node_local_matrix( scene, node, time, &local );
        *matrix = rf_mat4_mul( &local, matrix );
    }
}

// Normalises in double, so that no scale overflows or underflows a float.
static bool unit_axis( const double* column, double sign, double axis[3] )
{
    double largest = fmax( fabs( column[0] ), fmax( fabs( column[1] ), fabs( column[2] ) ) );
    if ( isfinite( column[0] + column[1] + column[2] ) == 0 || ( largest > 0.0 ) == false )
        return false;
    double sum = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        axis[i] = sign * ( column[i] / largest );
        sum += axis[i] * axis[i];
    }
    for ( int i = 0; i < 3; ++i )
        axis[i] /= sqrt( sum );
    return true;
}

static RfVec3 in_scene( const RfScene* scene, const double v[3] )
{
    return rf_vec3( (float)( v[0] - scene->origin[0] ), (float)( v[1] - scene->origin[1] ), (float)( v[2] - scene->origin[2] ) );
}

static bool in_range( const double* origin )
{
    for ( int i = 0; i < 3; ++i )
    {
        // written so that NaN fails
        if ( ( fabs( origin[i] ) <= MAX_COORDINATE ) == false )
            return false;
    }
    return true;
}

static bool has_fov( RfProjectionKind projection ) { return rf_projection_traits( projection )->extent == RF_EXTENT_FOV; }

// Makes a new camera in perspective one of another projection.
static void project_otherwise( RfEye* eye, RfProjectionKind projection, double ymag )
{
    switch ( projection )
    {
        case RF_PERSPECTIVE: break;
        case RF_ORTHOGRAPHIC:
            *eye = rf_make_orthographic_eye( eye->origin, eye->forward, eye->up, ymag, eye->width, eye->height );
            break;
        case RF_PANORAMIC: *eye = rf_make_panoramic_eye( eye->origin, eye->forward, eye->up, eye->width, eye->height ); break;
    }
}

// The field of view at a time, where it changes. False: there is none.
static bool zoom_to( const RfCamera* camera, double time, double* yfov, double* ymag )
{
    double value[4];
    if ( camera->zoom == NULL )
        return true;
    rf_sample_change( camera->zoom, time, value );
    if ( camera->zoom->value == RF_CHANGED_YMAG )
        *ymag = value[0];
    else if ( has_fov( (RfProjectionKind)camera->projection ) )
        *yfov = value[0];
    return value[0] > 0.0 && value[0] < rf_changed_traits( camera->zoom->value )->high;
}

static RfResult node_eye( const RfCameraSampling* sampling, double time, RfEye* eye, RfError* error )
{
    const RfScene* scene = sampling->scene;
    const RfCamera* self = sampling->camera;
    const RfProjectionKind projection = (RfProjectionKind)self->projection;
    RfMat4 world;
    rf_node_world_matrix( scene, self->node, time, &world );
    double forward[3], up[3];
    bool sound = unit_axis( world.m + 8, -1.0, forward ) && unit_axis( world.m + 4, 1.0, up );
    if ( sound )
    {
        double cosine = forward[0] * up[0] + forward[1] * up[1] + forward[2] * up[2];
        sound = fabs( cosine ) < 1.0 - 1e-9;
    }
    if ( sound == false || in_range( world.m + 12 ) == false )
        return rf_fail( error, RF_ERROR_SCENE,
                        "%s: camera '%.60s' at %g s: its transform is degenerate or not finite: "
                        "remove zero scales from it and from its parents",
                        scene->path != NULL ? scene->path : "scene", self->name, time );
    double yfov = has_fov( projection ) ? self->yfov : 1.0, ymag = self->ymag;
    if ( !zoom_to( self, time, &yfov, &ymag ) )
        return rf_fail( error, RF_ERROR_SCENE,
                        "%s: camera '%.60s' at %g s: its field of view is not more than 0: straighten its curve",
                        scene->path != NULL ? scene->path : "scene", self->name, time );
    *eye = rf_make_eye_inline( in_scene( scene, world.m + 12 ), rf_vec3_of( forward, 1.0 ), rf_vec3_of( up, 1.0 ), yfov,
                               sampling->width, sampling->height );
    project_otherwise( eye, projection, ymag );
    return RF_OK;
}

static RfResult track_eye( const RfCameraSampling* sampling, double time, RfEye* eye, RfError* error )
{
    const RfCamera* self = sampling->camera;
    RfView view;
    RF_TRY( rf_sample_camera_track( self->track, time, &view, error ) );
    if ( !in_range( view.position ) )
        return rf_fail( error, RF_ERROR_SCENE, "%s: leads beyond %g: scale it down", self->track->name, MAX_COORDINATE );
    *eye = rf_make_eye_inline( in_scene( sampling->scene, view.position ), rf_vec3_of( view.forward, 1.0 ),
                               rf_vec3_of( view.up, 1.0 ), has_fov( view.projection ) ? view.fov : 1.0, sampling->width,
                               sampling->height );
    project_otherwise( eye, view.projection, view.fov );
    if ( view.aspect != 1.0 || view.shift[0] != 0.0 || view.shift[1] != 0.0 )
        rf_shift_eye( eye, view.aspect, view.shift[0], view.shift[1] );
    return RF_OK;
}

static RfResult check_film( const RfCameraSampling* sampling, RfEye* eye, RfError* error )
{
    *eye = ( RfEye ){ 0 };
    if ( sampling->width > 0 && sampling->height > 0 )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE, "camera '%.60s': the film must have pixels, got %d × %d", sampling->camera->name,
                    sampling->width, sampling->height );
}

static RfResult eye_at_time( const RfCameraSampling* sampling, double time, RfEye* eye, RfError* error )
{
    return sampling->camera->track != NULL ? track_eye( sampling, time, eye, error ) : node_eye( sampling, time, eye, error );
}

// The time of frame `frame` of a camera's path, counted from 0, in its unit.
static double camera_time( const RfCameraSampling* sampling, double frame )
{
    const RfCamera* camera = sampling->camera;
    if ( counts_frames( camera ) )
        return first_time( sampling->scene, camera ) + frame * camera->track->step;
    // A single division of integers, so that the time of a frame does not depend on how it is
    // computed.
    return frame * (double)sampling->fps.denominator / (double)sampling->fps.numerator;
}

// The moment of the scene that a camera sees in a frame. The frame that a path calls 1 is at 0 s.
static double scene_time( const RfCameraSampling* sampling, double frame )
{
    double time = camera_time( sampling, frame );
    return counts_frames( sampling->camera ) ? time * (double)sampling->fps.denominator / (double)sampling->fps.numerator : time;
}

// Frames of a path for each unit of its time.
static double frames_per_unit( const RfCameraSampling* sampling )
{
    const RfCamera* camera = sampling->camera;
    return counts_frames( camera ) ? 1.0 / camera->track->step : (double)sampling->fps.numerator / sampling->fps.denominator;
}

// The shot that a frame is in, as a path of its own.
typedef struct ShotPath
{
    RfCameraSampling sampling; // of `camera`; frames count from the beginning of the whole path
    RfCamera camera;
    RfCameraTrack track;
    int64_t number;
    double first, last; // frames of its ends
    double begin, end;  // seconds, of a camera that jumps with its node: before and after them it is where it is then
} ShotPath;

#define FRAME_SLACK 1e-3 // of a frame, by which key times that are written as floats miss it

// The shot of an edit that a frame is in.
static int find_edit_shot( const RfCameraSampling* sampling, double frame )
{
    const RfEdit* edit = sampling->camera->edit;
    double slack = edit->in_frames ? FRAME_SLACK : FRAME_SLACK / frames_per_unit( sampling );
    double at = edit->in_frames ? frame : camera_time( sampling, frame );
    int shot = 0;
    while ( shot + 1 < edit->count && edit->shots[shot + 1].from <= at + slack )
        shot += 1;
    return shot;
}

static void find_shot( const RfCameraSampling* sampling, double frame, ShotPath* shot );

// That camera alone: like the edit, it counts its frames from 0 s.
static void find_shot_of_edit( const RfCameraSampling* sampling, double frame, ShotPath* shot )
{
    int number = find_edit_shot( sampling, frame );
    const RfCamera* shown = sampling->scene->cameras + sampling->camera->edit->shots[number].camera;
    RfCameraSampling own = *sampling;
    own.camera = shown;
    find_shot( &own, frame, shot );
    shot->number += (int64_t)number << 32;
    shot->first = shown->animated ? shot->first : -(double)INFINITY;
    shot->last = shown->animated ? shot->last : (double)INFINITY;
    shot->camera.animated = true;
}

// Between two jumps of its node.
static void find_step( const RfCamera* camera, double time, double rate, ShotPath* shot )
{
    int number = 0;
    while ( number < camera->cut_count && camera->cuts[number] <= time )
        number += 1;
    shot->number = number;
    if ( number > 0 )
    {
        shot->begin = camera->cuts[number - 1];
        shot->first = shot->begin * rate;
    }
    if ( number < camera->cut_count )
    {
        shot->end = nextafter( camera->cuts[number], -(double)INFINITY );
        shot->last = shot->end * rate;
    }
}

static void find_shot( const RfCameraSampling* sampling, double frame, ShotPath* shot )
{
    const RfCamera* camera = sampling->camera;
    if ( camera->edit != NULL )
    {
        find_shot_of_edit( sampling, frame, shot );
        return;
    }
    double start = first_time( sampling->scene, camera ), rate = frames_per_unit( sampling );
    double fps = (double)sampling->fps.numerator / sampling->fps.denominator;
    double first = ( camera->start - start ) * rate, last = ( camera->end - start ) * rate;
    bool waits = first > FRAME_SLACK, stays = ( last_time( sampling->scene, camera, fps ) - start ) * rate > last + FRAME_SLACK;
    // it is held before its first key and after its last, up to a cut
    *shot = ( ShotPath ){ .sampling = *sampling,
                          .camera = *camera,
                          .first = waits ? -(double)INFINITY : first,
                          .last = stays ? (double)INFINITY : last };
    shot->begin = -(double)INFINITY;
    shot->end = (double)INFINITY;
    shot->sampling.camera = &shot->camera;
    if ( camera->track != NULL && camera->track->cut_count > 0 )
    {
        shot->number = rf_track_shot( camera->track, start + ( frame + FRAME_SLACK ) / rate );
        shot->track = rf_shot_of_track( camera->track, (int)shot->number );
        shot->camera.track = &shot->track;
        shot->first = shot->number > 0 ? ( shot->track.start - start ) * rate : shot->first;
        shot->last = shot->number < camera->track->cut_count ? ( shot->track.end - start ) * rate : shot->last;
    }
    if ( camera->track == NULL && camera->cut_count > 0 )
        find_step( camera, start + ( frame + FRAME_SLACK ) / rate, rate, shot );
    if ( frame < shot->first - FRAME_SLACK )
        shot->first = -(double)INFINITY;
    if ( frame > shot->last + FRAME_SLACK )
        shot->last = (double)INFINITY;
}

static RfResult eye_of_shot( const ShotPath* shot, double frame, RfEye* eye, RfError* error )
{
    RF_TRY( check_film( &shot->sampling, eye, error ) );
    RF_TRY( eye_at_time( &shot->sampling, fmin( fmax( camera_time( &shot->sampling, frame ), shot->begin ), shot->end ), eye,
                         error ) );
    eye->shot = shot->number;
    return RF_OK;
}

int rf_camera_shots( const RfCamera* camera )
{
    if ( camera->edit != NULL )
        return camera->edit->count;
    return 1 + ( camera->track != NULL ? camera->track->cut_count : camera->cut_count );
}

// Takes ownership of the track, or frees it on failure.
static RfResult wrap_track( RfCameraTrack* track, const char* name, RfCamera* camera, RfError* error )
{
    *camera = ( RfCamera ){ .name = strdup( name ), .track = malloc( sizeof *camera->track ), .node = -1 };
    if ( camera->name == NULL || camera->track == NULL )
    {
        free( camera->name );
        free( camera->track );
        *camera = ( RfCamera ){ 0 };
        rf_destroy_camera_track( track );
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", name );
    }
    *camera->track = *track;
    camera->animated = track->end > track->start;
    camera->start = track->start;
    camera->end = track->end;
    return RF_OK;
}

RfResult rf_load_camera( const char* path, RfCamera* camera, RfError* error )
{
    RfCameraTrack track;
    *camera = ( RfCamera ){ 0 };
    RfResult result = rf_load_camera_track( path, &track, error );
    return result == RF_OK ? wrap_track( &track, path, camera, error ) : result;
}

RfResult rf_read_camera( const RfField* object, const char* name, RfCamera* camera )
{
    RfCameraTrack track;
    *camera = ( RfCamera ){ 0 };
    RfResult result = rf_read_camera_track( object, &track );
    return result == RF_OK ? wrap_track( &track, name, camera, object->error ) : result;
}

// The lens and the shutter.

// A camera at a frame of its path.
typedef struct Moment
{
    const ShotPath* shot;
    const RfCameraSampling* sampling; // its
    const RfCamera* camera;           // its
    double frame;
    RfError* error;
} Moment;

static RfOptics optics_of( const RfCamera* camera )
{
    if ( camera->track != NULL )
        return camera->track->optics;
    return camera->optics != NULL ? *camera->optics : ( RfOptics ){ .sensor = RF_DEFAULT_SENSOR };
}

// A path that goes on beyond its end as it came there: `inside` is as far before the end as `eye` becomes behind it. It
// turns from the end by as much as from there to the end: R = E Iᵀ E, with axes as columns.
static void go_on( const RfEye* end, const RfEye* inside, RfEye* eye )
{
    *eye = *end;
    eye->origin = rf_sub( rf_scale( end->origin, 2.0f ), inside->origin );
    eye->focal *= end->focal / inside->focal;
    eye->focal_x *= end->focal_x / inside->focal_x;
    eye->axis_x += end->axis_x - inside->axis_x;
    eye->axis_y += end->axis_y - inside->axis_y;
    const RfVec3 e[3] = { end->right, end->up, end->forward }, in[3] = { inside->right, inside->up, inside->forward };
    RfVec3* const out[3] = { &eye->right, &eye->up, &eye->forward };
    for ( int k = 0; k < 3; ++k )
    {
        *out[k] = rf_vec3( 0, 0, 0 );
        for ( int j = 0; j < 3; ++j )
            *out[k] = rf_madd( *out[k], e[j], rf_dot( in[j], e[k] ) );
        *out[k] = rf_scale( *out[k], 1.0f / rf_length( *out[k] ) );
    }
}

static RfResult eye_at( const Moment* m, double offset, RfEye* eye )
{
    int step = m->camera->track != NULL && m->camera->track->in_frames ? m->camera->track->step : 1;
    double frame = m->frame + offset / step, end = fmin( fmax( frame, m->shot->first ), m->shot->last );
    RfEye at_end, inside;
    if ( !m->camera->animated || fabs( frame - end ) < FRAME_SLACK )
        return eye_of_shot( m->shot, frame, eye, m->error );
    RfResult result = eye_of_shot( m->shot, end, &at_end, m->error );
    if ( result == RF_OK )
        result = eye_of_shot( m->shot, 2.0 * end - frame, &inside, m->error );
    bool held = m->camera->cut_count > 0 && memcmp( &at_end, &inside, sizeof inside ) == 0; // without rounding
    if ( result == RF_OK && held )
        *eye = at_end;
    else if ( result == RF_OK )
        go_on( &at_end, &inside, eye );
    return result;
}

static int find_node( const RfScene* scene, const char* name )
{
    for ( int i = 0; i < scene->node_count; ++i )
    {
        if ( scene->nodes[i].name != NULL && strcmp( scene->nodes[i].name, name ) == 0 )
            return i;
    }
    return -1;
}

static RfResult distance_of_node( const Moment* m, const RfEye* eye, const char* name, double* focus )
{
    int node = find_node( m->sampling->scene, name );
    if ( node < 0 )
        return rf_fail( m->error, RF_ERROR_SCENE, "camera '%.60s': its lens is focused on '%.60s', which the scene does not have",
                        m->camera->name, name );
    double time = scene_time( m->sampling, m->frame );
    RfMat4 world;
    rf_node_world_matrix( m->sampling->scene, node, time, &world );
    const double* o = m->sampling->scene->origin;
    RfVec3 p = rf_vec3( (float)( world.m[12] - o[0] ), (float)( world.m[13] - o[1] ), (float)( world.m[14] - o[2] ) );
    *focus = (double)rf_pinhole_depth( eye, p );
    if ( *focus > 0.0 )
        return RF_OK;
    return rf_fail( m->error, RF_ERROR_SCENE,
                    "camera '%.60s': its lens is focused on '%.60s', which is behind it in frame %g: focus by a distance",
                    m->camera->name, name, m->frame + 1.0 );
}

// The values of the keys, if there are any.
static RfResult sample_keys( const Moment* m, double offset, double* fstop, double* focus )
{
    const RfCameraTrack* track = m->camera->track;
    if ( track == NULL || ( track->focus.count == 0 && track->fstop.count == 0 ) )
        return RF_OK;
    RfView view;
    double time = camera_time( m->sampling, m->frame + offset / ( track->in_frames ? track->step : 1 ) );
    RfResult result = rf_sample_camera_track( track, time, &view, m->error );
    *fstop = view.fstop > 0.0 ? view.fstop : *fstop;
    *focus = view.focus > 0.0 ? view.focus : *focus;
    return result;
}

// A lens asked for has the limits of one that is read.
static RfResult check_lens( const RfLens* lens, RfError* error )
{
    const double* shutter = lens->shutter;
    if ( lens->has_fstop && !( lens->fstop >= 0.0 && lens->fstop <= RF_MAX_FSTOP ) )
        return rf_fail( error, RF_ERROR_USAGE, "the f-number of a lens must be 0 to %g, got %g", RF_MAX_FSTOP, lens->fstop );
    if ( !( lens->focus >= 0.0 && lens->focus <= RF_MAX_FOCUS ) )
        return rf_fail( error, RF_ERROR_USAGE, "the focus of a lens must be 0 to %g m, got %g", RF_MAX_FOCUS, lens->focus );
    if ( lens->has_shutter && !( shutter[0] >= -RF_MAX_SHUTTER && shutter[0] <= shutter[1] && shutter[1] <= RF_MAX_SHUTTER ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "a shutter must open and close within %g frames of the frame's time, got %g and %g", RF_MAX_SHUTTER,
                        shutter[0], shutter[1] );
    if ( lens->blur_steps < 0 || lens->blur_steps > RF_MAX_BLUR_STEPS )
        return rf_fail( error, RF_ERROR_USAGE, "what moves is blurred by 1 to %d steps, got %d", RF_MAX_BLUR_STEPS,
                        lens->blur_steps );
    return RF_OK;
}

static RfResult add_lens( const Moment* m, RfOptics* optics, double offset, RfEye* eye )
{
    const RfLens* asked = m->sampling->lens;
    if ( rf_is_left_out( m->sampling->scene, RF_EFFECT_DEPTH_OF_FIELD ) )
        return RF_OK;
    double focus = optics->focus;
    RfResult result = sample_keys( m, offset, &optics->fstop, &focus );
    const char* node = optics->focus_node;
    bool asks_focus = asked != NULL && ( asked->focus > 0.0 || asked->focus_node != NULL );
    if ( asked != NULL && asked->has_fstop )
    {
        optics->fstop = asked->fstop;
        optics->radius = 0.0;
    }
    if ( asks_focus )
    {
        focus = asked->focus;
        node = asked->focus_node;
    }
    double radius = rf_optics_radius( optics, eye );
    if ( result == RF_OK && asks_focus && !( radius > 0.0 ) )
        return rf_fail( m->error, RF_ERROR_USAGE,
                        "camera '%.60s': a focus changes nothing without an aperture: give it an f-number", m->camera->name );
    if ( result != RF_OK || !( radius > 0.0 ) )
        return result;
    if ( !rf_projection_traits( rf_projection_of( eye ) )->takes_lens )
        return rf_fail( m->error, RF_ERROR_SCENE,
                        "camera '%.60s': a %s camera has no depth of field here: leave the aperture out", m->camera->name,
                        g_rf_projection_names[eye->projection] );
    if ( node != NULL && !( focus > 0.0 ) )
        RF_TRY( distance_of_node( m, eye, node, &focus ) );
    if ( !( focus > 0.0 ) )
        return rf_fail( m->error, RF_ERROR_SCENE, "camera '%.60s': its lens has an aperture but no focus: give it a distance",
                        m->camera->name );
    rf_set_lens( eye, radius, focus, optics->blades, optics->rotation );
    return RF_OK;
}

static int64_t shot_number( const RfCameraSampling* sampling, double frame )
{
    ShotPath shot;
    find_shot( sampling, frame, &shot );
    return shot.number;
}

// How far the shot of `frame` goes on the way to another frame.
static double end_of_shot( const RfCameraSampling* sampling, double frame, double end )
{
    int64_t number = shot_number( sampling, frame );
    double inside = frame, outside = end;
    if ( shot_number( sampling, end ) == number )
        return end;
    for ( int i = 0; i < 40; ++i )
    {
        double middle = 0.5 * ( inside + outside );
        bool same = shot_number( sampling, middle ) == number;
        inside = same ? middle : inside;
        outside = same ? outside : middle;
    }
    return inside;
}

// What moves is blurred from one frame to another, as far as the shot goes: at a cut it may jump.
static void open_shutter( const RfCameraSampling* sampling, double frame, double first, double last, RfEye* eye )
{
    double begin = end_of_shot( sampling, frame, first ), end = end_of_shot( sampling, frame, last );
    bool cut = begin > first || end < last;
    begin = begin > first ? fmin( begin + 1.5 * FRAME_SLACK, end ) : begin; // shots begin as much before the cut
    eye->opens = scene_time( sampling, begin );
    eye->closes = scene_time( sampling, end );
    eye->blur_steps = sampling->lens != NULL && sampling->lens->blur_steps > 0 ? sampling->lens->blur_steps : RF_BLUR_STEPS;
    if ( cut )
        eye->time = 0.5 * ( eye->opens + eye->closes );
}

RfResult rf_camera_eye( const RfCameraSampling* sampling, double frame, RfEye* eye, RfError* error )
{
    ShotPath shot;
    find_shot( sampling, frame, &shot );
    Moment m = { &shot, &shot.sampling, &shot.camera, frame, error };
    const RfLens* asked = sampling->lens;
    RfOptics optics = optics_of( &shot.camera );
    RF_TRY( asked != NULL ? check_lens( asked, error ) : RF_OK );
    if ( asked != NULL && asked->has_shutter )
        memcpy( optics.shutter, asked->shutter, sizeof optics.shutter );
    bool blurs = rf_has_shutter( &optics ) && !rf_is_left_out( sampling->scene, RF_EFFECT_MOTION_BLUR );
    double middle = blurs ? 0.5 * ( optics.shutter[0] + optics.shutter[1] ) : 0.0;
    RfEye open, close;
    RfResult result = eye_at( &m, middle, eye );
    if ( result == RF_OK )
        result = add_lens( &m, &optics, middle, eye );
    const RfCameraTrack* track = sampling->camera->track;
    double unit = track != NULL && track->in_frames ? track->step : 1.0; // of the shutter, in frames
    eye->time = sampling->scene->movement != NULL ? scene_time( sampling, frame + middle / unit ) : 0.0;
    if ( blurs && sampling->scene->movement != NULL )
        open_shutter( sampling, frame, frame + optics.shutter[0] / unit, frame + optics.shutter[1] / unit, eye );
    if ( result != RF_OK || !blurs )
        return result;
    RF_TRY( eye_at( &m, optics.shutter[0], &open ) );
    RF_TRY( eye_at( &m, optics.shutter[1], &close ) );
    rf_set_shutter( eye, &open, &close );
    return RF_OK;
}
