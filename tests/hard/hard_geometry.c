// Hard cases of geometry and scale.
#include "hard/hard.h"

#include <math.h>
#include <string.h>

static void scaled( HardScene* h, float scale, RfVec3 shift )
{
    hard_stage( h, hard_glossy() );
    hard_move( h, scale, shift );
}

static void scale_m6( HardScene* h ) { scaled( h, 1e-6f, rf_vec3( 0, 0, 0 ) ); }
static void scale_p6( HardScene* h ) { scaled( h, 1e6f, rf_vec3( 0, 0, 0 ) ); }
static void scale_m12( HardScene* h ) { scaled( h, 1e-12f, rf_vec3( 0, 0, 0 ) ); }
static void scale_p12( HardScene* h ) { scaled( h, 1e12f, rf_vec3( 0, 0, 0 ) ); }
static void moved( HardScene* h ) { scaled( h, 1e4f, rf_vec3( 1e6f, -1e6f, 1e6f ) ); }

// Triangles of no area among the others, and needles down to nothing.
static void degenerate( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    for ( int i = 0; i < 12; ++i )
    {
        float x = -1.0f + 0.15f * (float)i, thin = i < 10 ? powf( 10.0f, -(float)i ) * 0.1f : 0.0f;
        RfVec3 p = rf_vec3( x, 0.1f, 0.8f ), q = rf_vec3( x, 0.9f, 0.8f );
        add_quad( &b, 3, p, rf_add( p, rf_vec3( thin, 0, 0 ) ), rf_add( q, rf_vec3( thin, 0, 0 ) ), q );
        add_quad( &b, 3, p, p, p, p );
    }
    h->scene = finish_scene( &b );
}

static void duplicates( HardScene* h )
{
    hard_stage( h, hard_grey() );
    SceneBuilder b = hard_reopen( &h->scene );
    for ( int i = 0; i < 3; ++i )
        add_box( &b, 3, rf_vec3( -0.6f, 0.0f, -0.5f ), rf_vec3( 0.7f, 0.6f, 0.5f ), false );
    h->scene = finish_scene( &b );
}

// A second floor in the plane of the first, seen from above like it, but its underside shines. All leans, so that hits have
// rounding; the corners of the floors are exact, and so is their plane.
static void coincident( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    RfMaterial shining = hard_glossy();
    shining.emission = rf_vec3( 4, 4, 4 );
    shining.double_sided = false;
    uint32_t below = add_material( &b, shining );
    add_quad( &b, below, rf_vec3( -1.5f, 0, -1.5f ), rf_vec3( 1.5f, 0, -1.5f ), rf_vec3( 1.5f, 0, 1.5f ),
              rf_vec3( -1.5f, 0, 1.5f ) );
    for ( uint32_t i = 0; i < b.scene.triangles.vertex_count; ++i )
        b.scene.triangles.positions[3 * (size_t)i + 1] += 0.25f * b.scene.triangles.positions[3 * (size_t)i];
    memset( b.scene.triangles.normals, 0, 3 * (size_t)b.scene.triangles.vertex_count * sizeof( float ) );
    h->scene = finish_scene( &b );
}

static void zero_normals( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    memset( h->scene.triangles.normals, 0, 3 * (size_t)h->scene.triangles.vertex_count * sizeof( float ) );
}

static void flipped_normals( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( uint32_t i = 0; i < 3 * h->scene.triangles.vertex_count; ++i )
        h->scene.triangles.normals[i] = -h->scene.triangles.normals[i];
}

// Smooth normals that lean by up to 80 degrees: eyes and lights below the shading horizon.
static void leaning_normals( HardScene* h )
{
    hard_stage( h, make_metal( 0.9f, 0.3f ) );
    for ( uint32_t i = 0; i < h->scene.triangles.vertex_count; ++i )
    {
        float* n = h->scene.triangles.normals + 3 * (size_t)i;
        RfVec3 lean =
            rf_normalize( rf_vec3( n[0] + ( i % 2 == 0 ? 5.0f : -4.0f ) * n[1], n[1] + 5.0f * n[2], n[2] - 5.0f * n[0] ) );
        memcpy( n, &lean, sizeof lean );
    }
}

// A sheet with eyes on both of its sides, and light on both.
static void sheet( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    add_quad( &b, 3, rf_vec3( 1.0f, 0, 1.8f ), rf_vec3( 1.0f, 0, -1.8f ), rf_vec3( 1.0f, 1.2f, -1.8f ),
              rf_vec3( 1.0f, 1.2f, 1.8f ) );
    h->scene = finish_scene( &b );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] =
            rf_make_eye( rf_vec3( i % 2 == 0 ? 1.9f : 0.9f - 0.9f * (float)( i % 3 ), 0.8f, 1.0f ),
                         rf_vec3( i % 2 == 0 ? -1.0f : 1.0f, -0.1f, -0.5f ), rf_vec3( 0, 1, 0 ), 1.0, HARD_WIDTH, HARD_HEIGHT );
}

// In every tile some pixels see what is 0.1 m away, others what is 1e4 m away.
static void depth_edges( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    uint32_t far = add_material( &b, hard_grey() ), light = add_material( &b, make_light( 3.0f, true ) );
    for ( int i = 0; i < 4; ++i ) // bars before the eyes
    {
        float x = -0.06f + 0.04f * (float)i;
        add_quad( &b, 3, rf_vec3( x, 1.0f, 2.0f ), rf_vec3( x + 0.013f, 1.0f, 2.0f ), rf_vec3( x + 0.013f, 1.6f, 2.0f ),
                  rf_vec3( x, 1.6f, 2.0f ) );
    }
    add_quad( &b, far, rf_vec3( -1e4f, -1e4f, -1e4f ), rf_vec3( 1e4f, -1e4f, -1e4f ), rf_vec3( 1e4f, 1e4f, -1e4f ),
              rf_vec3( -1e4f, 1e4f, -1e4f ) );
    add_quad( &b, light, rf_vec3( -3e3f, 9e3f, -9e3f ), rf_vec3( 3e3f, 9e3f, -9e3f ), rf_vec3( 3e3f, 9e3f, -3e3f ),
              rf_vec3( -3e3f, 9e3f, -3e3f ) );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0, 1.4f, 2.1f ), rf_vec3( 0.002f, 0, 0 ), rf_vec3( 0, 2.0f, -1.0f ), 55.0 );
}

// Two plates whose distance is 1e-12 of their size: second vertices almost touch the hits. Lit by the plates themselves.
static void touching_plates( HardScene* h )
{
    SceneBuilder b = { 0 };
    RfMaterial glowing = hard_grey();
    glowing.diffuse = rf_vec3( 0.5f, 0.5f, 0.5f );
    glowing.emission = rf_vec3( 1, 1, 1 );
    glowing.double_sided = true;
    uint32_t m = add_material( &b, glowing );
    add_quad( &b, m, rf_vec3( -1, 0, 1 ), rf_vec3( 1, 0, 1 ), rf_vec3( 1, 0, -1 ), rf_vec3( -1, 0, -1 ) );
    add_quad( &b, m, rf_vec3( -1, 1e-12f, 1 ), rf_vec3( -1, 1e-12f, -1 ), rf_vec3( 1, 1e-12f, -1 ), rf_vec3( 1, 1e-12f, 1 ) );
    h->scene = finish_scene( &b );
    // between the plates and above them
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( rf_vec3( 1e-13f * (float)i, i % 2 == 1 ? 5e-13f : 0.4f, 0 ), rf_vec3( 0.1f, -1, -1 ),
                                  rf_vec3( 0, 1, 0 ), 0.7, HARD_WIDTH, HARD_HEIGHT );
    h->value = 1.0 + 0.5 + 0.25 + 0.125; // of 4 vertices
    h->within = 1e-3;
    h->sharp = true;
}

// A corner whose walls the hits touch, in a crowd of scales: a fan of 30 plates around one edge.
static void fan( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    for ( int i = 0; i < 30; ++i )
    {
        float angle = powf( 0.5f, (float)i );
        add_quad( &b, 3, rf_vec3( 1.9f, 0.1f, 1.0f ), rf_vec3( 1.0f, 0.1f, 1.0f ),
                  rf_vec3( 1.0f, 0.1f + sinf( angle ), 1.0f - cosf( angle ) ),
                  rf_vec3( 1.9f, 0.1f + sinf( angle ), 1.0f - cosf( angle ) ) );
    }
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 1.4f, 0.9f, 1.7f ), rf_vec3( 0.02f, 0, 0 ), rf_vec3( 0, -0.8f, -1 ), 30.0 );
}

// An edge between two walls at the origin, looked at from 1e-12 m to 1 m: hits and second vertices at all distances.
static void corner( HardScene* h )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, hard_grey() ), light = add_material( &b, make_light( 10.0f, false ) );
    add_quad( &b, grey, rf_vec3( 0, 0, 1 ), rf_vec3( 2, 0, 1 ), rf_vec3( 2, 0, -1 ), rf_vec3( 0, 0, -1 ) );
    add_quad( &b, grey, rf_vec3( 0, 0, 1 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 2, -1 ), rf_vec3( 0, 2, 1 ) );
    add_quad( &b, light, rf_vec3( 1, 2, -1 ), rf_vec3( 2, 2, -1 ), rf_vec3( 2, 2, 1 ), rf_vec3( 1, 2, 1 ) );
    h->scene = finish_scene( &b );
    for ( int i = 0; i < 7; ++i )
    {
        float d = powf( 10.0f, -4.0f * (float)( i < 3 ? i : 6 - i ) );
        h->eyes[i] = rf_make_eye( rf_vec3( d, 0.7f * d, 0 ), rf_vec3( -1, -0.8f, -0.1f ), rf_vec3( 0, 0, 1 ), 1.7, HARD_WIDTH,
                                  HARD_HEIGHT );
    }
}

// The ground is a quad of 2000 km under a room; its hits have the rounding of its corners.
static void far_ground( HardScene* h )
{
    hard_stage( h, hard_grey() );
    SceneBuilder b = hard_reopen( &h->scene );
    float r = 1e6f;
    RfVec3 x = rf_vec3( 0.8f * r, -0.3f * r, 0.1f * r ), z = rf_vec3( -0.1f * r, 0.1f * r, 0.9f * r ),
           at = rf_vec3( 1.6f, -0.8f, 0 );
    add_quad( &b, 3, rf_add( rf_sub( z, x ), at ), rf_add( rf_add( x, z ), at ), rf_add( rf_sub( x, z ), at ),
              rf_sub( at, rf_add( x, z ) ) );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 2.8f, 1.0f, 1.2f ), rf_vec3( 0.05f, 0, 0 ), rf_vec3( -0.1f, -1, -0.3f ), 50.0 );
}

const HardCase g_hard_geometry[] = {
    { "scale-1e-6", "a scene scaled by 1e-6", "products of edges, fixed offsets", HARD_DOUBLE, 1.5, scale_m6, NULL },
    { "scale-1e6", "a scene scaled by 1e6", "the same", HARD_DOUBLE, 1.5, scale_p6, NULL },
    { "scale-1e-12", "a scene scaled by 1e-12", "products of four lengths below floats", HARD_DOUBLE, 1.5, scale_m12, NULL },
    { "scale-1e12", "a scene scaled by 1e12", "products of four lengths beyond floats", HARD_DOUBLE, 1.5, scale_p12, NULL },
    { "moved-1e6", "a scene of 3e4 m, moved by 1e6 m along each axis",
      "rounding of coordinates: 0.06 m; files that lie far out are moved back (tests/gltf/test_gltf_origin.c)", HARD_DOUBLE, 1.5,
      moved, NULL },
    { "degenerate", "triangles without area, needles down to nothing", "normals 0/0", HARD_DOUBLE, 1.5, degenerate, NULL },
    { "duplicates", "a block four times in one place", "rays that find themselves again", HARD_DOUBLE, 1.5, duplicates, NULL },
    { "coincident", "two floors in one plane, one of them a light from below",
      "rays that find the other one; light at distance 0", HARD_DOUBLE, 1.5, coincident, NULL },
    { "zero-normals", "vertex normals of 0", "0/0", HARD_DOUBLE, 1.5, zero_normals, NULL },
    { "flipped-normals", "vertex normals that face into the surface", "cosines below 0", HARD_DOUBLE, 1.5, flipped_normals,
      NULL },
    { "leaning-normals", "vertex normals that lean by up to 80 degrees", "eyes below the shading horizon", HARD_PLAIN, 1.5,
      leaning_normals, NULL },
    { "sheet", "a sheet seen from both sides", "hits of one side seen from the other", HARD_DOUBLE, 1.5, sheet, NULL },
    { "depth-edges", "tiles across depth edges of 1e5", "1/d2 that differ by 1e10", HARD_DOUBLE, 3.0, depth_edges, NULL },
    { "touching-plates", "two plates 1e-12 m apart", "second vertices 1e-12 m away", HARD_VALUE, 0, touching_plates, NULL },
    { "fan", "plates around one edge, at angles down to 1e-9", "hits next to edges", HARD_DOUBLE, 2.5, fan, NULL },
    { "corner-1e-12", "an edge seen from 1e-12 m to 1 m", "second vertices at 1e-12 m, 1/d2 of 1e24", HARD_DOUBLE, 2.5, corner,
      NULL },
    { "far-ground", "a tilted ground of 2000 km under a room", "hits with the rounding of its corners", HARD_DOUBLE, 1.5,
      far_ground, NULL },
    { 0 },
};
