// Eyes with the lens and the shutter of their camera.
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/leave_out.h"
#include "scene/pinhole.h"

#include <math.h>
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

// Frames of a path between its ends.
static double path_frames( const Moment* m )
{
    const RfCamera* c = m->camera;
    bool counts = c->track != NULL && c->track->in_frames;
    return ( c->end - c->start ) * ( counts ? 1.0 / c->track->step : (double)m->numerator / m->denominator );
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

static RfResult eye_at( const Moment* m, double offset, int width, int height, RfEye* eye )
{
    int step = m->camera->track != NULL && m->camera->track->in_frames ? m->camera->track->step : 1;
    double frame = m->frame + offset / step, last = path_frames( m ), end = fmin( fmax( frame, 0.0 ), last );
    RfEye at_end, inside;
    // key times written as floats miss their frame slightly
    if ( !m->camera->animated || fabs( frame - end ) < 1e-3 )
        return rf_camera_eye( m->scene, m->camera, frame, m->numerator, m->denominator, width, height, eye, m->error );
    RfResult result = rf_camera_eye( m->scene, m->camera, end, m->numerator, m->denominator, width, height, &at_end, m->error );
    if ( result == RF_OK )
        result = rf_camera_eye( m->scene, m->camera, 2.0 * end - frame, m->numerator, m->denominator, width, height, &inside,
                                m->error );
    if ( result == RF_OK )
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
    if ( eye->projection == RF_PANORAMIC )
        return rf_fail( m->error, RF_ERROR_SCENE,
                        "camera '%.60s': a panoramic camera has no depth of field here: leave the aperture out",
                        m->camera->name );
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
