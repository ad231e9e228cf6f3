// Eyes with the lens and the shutter of their camera.
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/leave_out.h"
#include "scene/pinhole.h"

#include <string.h>

// A camera at a frame of its path.
typedef struct Moment
{
    const RfScene* scene;
    const RfCamera* camera;
    double frame;
    int numerator, denominator;
    RfError* error;
} Moment;

static RfOptics optics_of( const RfCamera* camera )
{
    if ( camera->track != NULL )
        return camera->track->optics;
    return camera->optics != NULL ? *camera->optics : ( RfOptics ){ .sensor = RF_DEFAULT_SENSOR };
}

static RfResult eye_at( const Moment* m, double offset, int width, int height, RfEye* eye )
{
    int step = m->camera->track != NULL && m->camera->track->in_frames ? m->camera->track->step : 1;
    return rf_camera_eye( m->scene, m->camera, m->frame + offset / step, m->numerator, m->denominator, width, height, eye,
                          m->error );
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
    int node = find_node( m->scene, name );
    if ( node < 0 )
        return rf_fail( m->error, RF_ERROR_SCENE, "camera '%.60s': its lens is focused on '%.60s', which the scene does not have",
                        m->camera->name, name );
    // a path that counts frames has no seconds of its own
    bool counts = m->camera->track != NULL && m->camera->track->in_frames;
    double time =
        counts ? m->frame * m->denominator / m->numerator : rf_camera_time( m->camera, m->frame, m->numerator, m->denominator );
    RfMat4 world;
    rf_node_world_matrix( m->scene, node, time, &world );
    const double* o = m->scene->origin;
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
    double time =
        rf_camera_time( m->camera, m->frame + offset / ( track->in_frames ? track->step : 1 ), m->numerator, m->denominator );
    RfResult result = rf_sample_camera_track( track, time, &view, m->error );
    *fstop = view.fstop > 0.0 ? view.fstop : *fstop;
    *focus = view.focus > 0.0 ? view.focus : *focus;
    return result;
}

static RfResult add_lens( const Moment* m, const RfLens* asked, RfOptics* optics, double offset, RfEye* eye )
{
    if ( rf_is_left_out( m->scene, RF_EFFECT_DEPTH_OF_FIELD ) )
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
    if ( node != NULL && !( focus > 0.0 ) )
        result = distance_of_node( m, eye, node, &focus );
    if ( result == RF_OK && !( focus > 0.0 ) )
        return rf_fail( m->error, RF_ERROR_SCENE, "camera '%.60s': its lens has an aperture but no focus: give it a distance",
                        m->camera->name );
    if ( result == RF_OK )
        rf_set_lens( eye, radius, focus, optics->blades, optics->rotation );
    return result;
}

RfResult rf_camera_lens_eye( const RfScene* scene, const RfCamera* camera, const RfLens* asked, double frame, int numerator,
                             int denominator, int width, int height, RfEye* eye, RfError* error )
{
    Moment m = { scene, camera, frame, numerator, denominator, error };
    RfOptics optics = optics_of( camera );
    if ( asked != NULL && asked->has_shutter )
        memcpy( optics.shutter, asked->shutter, sizeof optics.shutter );
    bool blurs = rf_has_shutter( &optics ) && !rf_is_left_out( scene, RF_EFFECT_MOTION_BLUR );
    double middle = blurs ? 0.5 * ( optics.shutter[0] + optics.shutter[1] ) : 0.0;
    RfEye open, close;
    RfResult result = eye_at( &m, middle, width, height, eye );
    if ( result == RF_OK )
        result = add_lens( &m, asked, &optics, middle, eye );
    if ( result != RF_OK || !blurs )
        return result;
    result = eye_at( &m, optics.shutter[0], width, height, &open );
    if ( result == RF_OK )
        result = eye_at( &m, optics.shutter[1], width, height, &close );
    if ( result == RF_OK )
        rf_set_shutter( eye, &open, &close );
    return result;
}
