#include "scene/eye.h"

RfEye rf_make_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double yfov, int width, int height )
{
    return rf_make_eye_inline( origin, forward, up, yfov, width, height );
}

RfEye rf_make_orthographic_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double ymag, int width, int height )
{
    RfEye eye = rf_make_eye_inline( origin, forward, up, 1.0, width, height );
    eye.projection = RF_ORTHOGRAPHIC;
    eye.focal = eye.focal_x = (float)( 0.5 * (double)height / ymag );
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
    eye->focal_x = (float)( (double)eye->focal / pixel_aspect );
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
        if ( eye->projection != RF_PERSPECTIVE )
        {
            double w = eye->projection == RF_ORTHOGRAPHIC ? row[3] : 0.0, used = eye->projection == RF_ORTHOGRAPHIC ? 1.0 : 0.0;
            world_to_ndc[4 * i + 0] = (float)( used * x_scale * row[0] + x_shift * w );
            world_to_ndc[4 * i + 1] = (float)( used * y_scale * row[1] + y_shift * w );
            world_to_ndc[4 * i + 2] = (float)( used * -2.0 * row[2] / ( far - near ) - w * ( far + near ) / ( far - near ) );
            world_to_ndc[4 * i + 3] = (float)w;
            continue;
        }
        world_to_ndc[4 * i + 0] = (float)( x_scale * row[0] - x_shift * row[2] );
        world_to_ndc[4 * i + 1] = (float)( y_scale * row[1] - y_shift * row[2] );
        world_to_ndc[4 * i + 2] = (float)( -row[2] - 2.0 * near * row[3] );
        world_to_ndc[4 * i + 3] = (float)-row[2];
    }
}
