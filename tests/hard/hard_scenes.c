#include "hard/hard.h"
#include "scene/lens.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

RfMaterial hard_grey( void ) { return make_lambert( 0.5f, 0.45f, 0.4f ); }

RfMaterial hard_glossy( void ) { return make_plastic( 0.6f, 0.5f ); }

void hard_eyes( HardScene* h, RfVec3 from, RfVec3 step, RfVec3 forward, double degrees )
{
    for ( int i = 0; i < h->eye_count; ++i )
        h->eyes[i] = rf_make_eye( rf_madd( from, step, (float)( i - h->eye_count / 2 ) ), forward, rf_vec3( 0, 1, 0 ),
                                  degrees * PI / 180.0, HARD_WIDTH, HARD_HEIGHT );
}

void hard_film( HardScene* h, int width, int height )
{
    for ( int i = 0; i < h->eye_count; ++i )
    {
        RfEye* e = h->eyes + i;
        double yfov = 2.0 * atan( 0.5 * (double)e->height / (double)e->focal );
        *e = rf_make_eye( e->origin, e->forward, e->up, yfov, width, height );
    }
}

void hard_stage( HardScene* h, RfMaterial object )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, hard_grey() ), red = add_material( &b, make_lambert( 0.6f, 0.2f, 0.15f ) );
    uint32_t light = add_material( &b, make_light( 10.0f, false ) ), thing = add_material( &b, object );
    add_quad( &b, thing, rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ), rf_vec3( -2, 0, -2 ) );
    add_quad( &b, grey, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 0, -2 ), rf_vec3( 2, 3, -2 ), rf_vec3( -2, 3, -2 ) );
    add_quad( &b, red, rf_vec3( -2, 0, 2 ), rf_vec3( -2, 0, -2 ), rf_vec3( -2, 3, -2 ), rf_vec3( -2, 3, 2 ) );
    add_quad( &b, light, rf_vec3( -0.6f, 2.5f, -0.6f ), rf_vec3( 0.6f, 2.5f, -0.6f ), rf_vec3( 0.6f, 2.5f, 0.6f ),
              rf_vec3( -0.6f, 2.5f, 0.6f ) );
    add_box( &b, thing, rf_vec3( -0.6f, 0.0f, -0.5f ), rf_vec3( 0.7f, 0.6f, 0.5f ), false );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0.2f, 1.3f, 2.1f ), rf_vec3( 0.1f, 0, 0 ), rf_vec3( -0.1f, -0.45f, -1.0f ), 50.0 );
}

void hard_move( HardScene* h, float scale, RfVec3 shift )
{
    move_scene( &h->scene, scale, shift );
    for ( int i = 0; i < h->eye_count; ++i )
    {
        h->eyes[i].origin = rf_madd( shift, h->eyes[i].origin, scale );
        h->eyes[i].lens_radius *= scale;
        h->eyes[i].focus *= scale;
    }
}

SceneBuilder hard_reopen( RfScene* scene )
{
    SceneBuilder b = { .scene = *scene, .vertex_room = scene->triangles.vertex_count, .triangle_room = scene->triangles.count };
    free( b.scene.path );
    b.scene.path = NULL;
    *scene = ( RfScene ){ 0 };
    return b;
}

void hard_add_lenses( const HardScene* h, RfEye* eyes )
{
    float reach = rf_maxf( rf_length( rf_sub( h->scene.bounds_max, h->scene.bounds_min ) ), 1e-20f );
    for ( int i = 0; i < h->eye_count; ++i )
        rf_set_lens( eyes + i, 0.01 * (double)reach, 0.5 * (double)reach, i % 2 == h->eye_count / 2 % 2 ? 0 : 5, 0.1 );
}

bool hard_are_eyes_equal( const HardScene* h )
{
    bool equal = h->eye_count > 1;
    for ( int i = 1; i < h->eye_count; ++i )
    {
        const RfEye *a = h->eyes, *b = h->eyes + i;
        RfVec3 moved = rf_sub( a->origin, b->origin ), turned = rf_sub( a->forward, b->forward ), rolled = rf_sub( a->up, b->up );
        equal = equal && rf_dot( moved, moved ) + rf_dot( turned, turned ) + rf_dot( rolled, rolled ) == 0.0f;
    }
    return equal;
}
