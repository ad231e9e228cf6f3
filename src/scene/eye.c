#include "scene/eye.h"

RfEye rf_make_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double yfov, int width, int height )
{
    RfEye eye;
    eye.origin = origin;
    double f[3] = { (double)forward.x, (double)forward.y, (double)forward.z };
    double u[3] = { (double)up.x, (double)up.y, (double)up.z }, r[3];
    rf_unit3( f );
    rf_cross3( f, u, r ); // in doubles: up may lean far towards forward
    rf_unit3( r );
    rf_cross3( r, f, u );
    eye.forward = rf_vec3( (float)f[0], (float)f[1], (float)f[2] );
    eye.right = rf_vec3( (float)r[0], (float)r[1], (float)r[2] );
    eye.up = rf_vec3( (float)u[0], (float)u[1], (float)u[2] );
    eye.focal = (float)( 0.5 * (double)height / tan( 0.5 * yfov ) );
    eye.width = width;
    eye.height = height;
    return eye;
}

void rf_eye_matrices( const RfEye* eye, float world_to_camera[16], float world_to_ndc[16] )
{
    const RfVec3 axes[3] = { eye->right, eye->up, rf_scale( eye->forward, -1.0f ) };
    double camera[4][4] = { { 0 } };
    for ( int j = 0; j < 3; ++j )
    {
        camera[0][j] = axes[j].x;
        camera[1][j] = axes[j].y;
        camera[2][j] = axes[j].z;
        camera[3][j] =
            -( (double)eye->origin.x * axes[j].x + (double)eye->origin.y * axes[j].y + (double)eye->origin.z * axes[j].z );
    }
    camera[3][3] = 1.0;
    const double near = 0.01;
    double x_scale = 2.0 * eye->focal / eye->width, y_scale = 2.0 * eye->focal / eye->height;
    for ( int i = 0; i < 4; ++i )
    {
        const double* row = camera[i];
        for ( int j = 0; j < 4; ++j )
            world_to_camera[4 * i + j] = (float)row[j];
        world_to_ndc[4 * i + 0] = (float)( x_scale * row[0] );
        world_to_ndc[4 * i + 1] = (float)( y_scale * row[1] );
        world_to_ndc[4 * i + 2] = (float)( -row[2] - 2.0 * near * row[3] );
        world_to_ndc[4 * i + 3] = (float)-row[2];
    }
}
