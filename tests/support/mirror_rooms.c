#include "support/mirror_rooms_internal.h"
#include "support/textured_room.h"

#include <stdlib.h>

void add_upright( SceneBuilder* b, uint32_t material, float x0, float y0, float x1, float y1, float z )
{
    add_quad( b, material, rf_vec3( x0, y0, z ), rf_vec3( x1, y0, z ), rf_vec3( x1, y1, z ), rf_vec3( x0, y1, z ) );
}

void add_wall_mirror( SceneBuilder* b, uint32_t material ) { add_upright( b, material, -1.6f, 0.3f, 1.6f, 2.3f, BACK ); }

RfMaterial make_pane( float r, float g, float b )
{
    RfMaterial pane = make_glass( 1.5f, 0.0f, true );
    pane.tint = rf_vec3( r, g, b );
    return pane;
}

static SceneBuilder start_room( void )
{
    SceneBuilder b = { 0 };
    add_material( &b, make_lambert( 0.6f, 0.55f, 0.5f ) );
    add_material( &b, make_lambert( 0.7f, 0.15f, 0.1f ) );
    add_material( &b, make_lambert( 0.1f, 0.2f, 0.7f ) );
    add_material( &b, make_light( 2.0f, false ) );
    add_material( &b, make_plastic( 0.6f, 0.25f ) );
    add_material( &b, make_metal( 0.9f, 0.3f ) );
    add_box( &b, WALL, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_quad( &b, RED, rf_vec3( -1.95f, 0.1f, -0.5f ), rf_vec3( -1.95f, 0.1f, 1.9f ), rf_vec3( -1.95f, 2.5f, 1.9f ),
              rf_vec3( -1.95f, 2.5f, -0.5f ) );
    add_quad( &b, BLUE, rf_vec3( 1.95f, 0.1f, 0.5f ), rf_vec3( 1.95f, 0.1f, -1.5f ), rf_vec3( 1.95f, 2.5f, -1.5f ),
              rf_vec3( 1.95f, 2.5f, 0.5f ) );
    // large and dim: a bright one, found by way of a mirror once in hundreds of samples, would make the tails of
    // the distributions too heavy for the t-tests of single pixels
    add_quad( &b, LAMP, rf_vec3( -1.7f, 2.95f, -1.7f ), rf_vec3( 1.7f, 2.95f, -1.7f ), rf_vec3( 1.7f, 2.95f, 1.7f ),
              rf_vec3( -1.7f, 2.95f, 1.7f ) );
    for ( int i = 0; i < 4; ++i ) // stripes on the front wall, which mirrors show
    {
        float x = 1.5f - 0.8f * (float)i;
        add_quad( &b, i % 2 == 0 ? BLUE : RED, rf_vec3( x, 0.3f, 1.97f ), rf_vec3( x - 0.4f, 0.3f, 1.97f ),
                  rf_vec3( x - 0.4f, 2.4f, 1.97f ), rf_vec3( x, 2.4f, 1.97f ) );
    }
    add_box( &b, BLOCK, rf_vec3( -0.7f, 0.0f, -0.5f ), rf_vec3( 0.5f, 0.45f, 0.4f ), false );
    add_sphere( &b, BALL, rf_vec3( 1.0f, 0.4f, 0.5f ), 0.35f, 10 );
    return b;
}

static RfMaterial make_tinted_mirror( float r, float g, float b )
{
    RfMaterial m = make_mirror( 1.0f );
    m.specular = rf_vec3( r, g, b );
    return m;
}

static uint32_t add_flat_mirror( SceneBuilder* b )
{
    uint32_t mirror = add_material( b, make_tinted_mirror( 0.9f, 0.8f, 0.6f ) );
    add_wall_mirror( b, mirror );
    return mirror;
}

static void add_facing_mirrors( SceneBuilder* b )
{
    uint32_t mirror = add_flat_mirror( b );
    add_quad( b, mirror, rf_vec3( 1.5f, 0.4f, -BACK ), rf_vec3( -1.5f, 0.4f, -BACK ), rf_vec3( -1.5f, 2.4f, -BACK ),
              rf_vec3( 1.5f, 2.4f, -BACK ) );
}

static void add_corner_mirrors( SceneBuilder* b )
{
    add_flat_mirror( b );
    uint32_t mirror = add_material( b, make_tinted_mirror( 0.7f, 0.9f, 0.9f ) );
    add_quad( b, mirror, rf_vec3( 1.9f, 0.2f, 1.5f ), rf_vec3( 1.9f, 0.2f, -1.8f ), rf_vec3( 1.9f, 2.4f, -1.8f ),
              rf_vec3( 1.9f, 2.4f, 1.5f ) );
}

// A corner of the grid of the L-shaped mirror, moved within the plane where it is not on the outline.
static RfVec3 grid_corner( int i, int j )
{
    float u = (float)i, v = (float)j;
    if ( i > 0 && i < 6 && j > 0 && j < 4 && i != 3 && j != 2 )
    {
        u += 0.3f * sinf( 5.0f * (float)i + 3.0f * (float)j );
        v += 0.3f * cosf( 2.0f * (float)i - 7.0f * (float)j );
    }
    RfVec3 across = rf_vec3( 0.52f, 0.0f, -0.09f ), up = rf_vec3( 0.02f, 0.5f, 0.11f );
    return rf_madd( rf_madd( rf_vec3( -1.6f, 0.3f, -1.4f ), across, u ), up, v );
}

static void add_l_shaped_mirror( SceneBuilder* b )
{
    uint32_t mirror = add_material( b, make_tinted_mirror( 0.9f, 0.8f, 0.6f ) );
    for ( int j = 0; j < 4; ++j )
    {
        for ( int i = 0; i < ( j < 2 ? 6 : 3 ); ++i )
            add_quad( b, mirror, grid_corner( i, j ), grid_corner( i + 1, j ), grid_corner( i + 1, j + 1 ),
                      grid_corner( i, j + 1 ) );
    }
}

static void add_coplanar_mirrors( SceneBuilder* b )
{
    uint32_t grey = add_material( b, make_tinted_mirror( 0.95f, 0.95f, 0.95f ) );
    uint32_t gold = add_material( b, make_tinted_mirror( 0.9f, 0.6f, 0.3f ) );
    add_upright( b, grey, -1.7f, 0.3f, -0.3f, 2.3f, BACK );
    add_upright( b, gold, 0.2f, 0.5f, 1.7f, 2.5f, BACK );
}

// Between a red and a shining box.
static void add_standing_mirror( SceneBuilder* b )
{
    RfMaterial shining = make_lambert( 0.2f, 0.7f, 0.2f );
    shining.emission = rf_vec3( 0.1f, 0.4f, 0.1f );
    add_upright( b, add_material( b, make_mirror( 0.9f ) ), -0.8f, 0.6f, 1.5f, 2.4f, 0.0f );
    add_box( b, RED, rf_vec3( 0.7f, 0.8f, 0.6f ), rf_vec3( 1.1f, 1.6f, 1.0f ), false );
    add_box( b, add_material( b, shining ), rf_vec3( 1.0f, 0.9f, -1.1f ), rf_vec3( 1.4f, 1.9f, -0.7f ), false );
}

static void add_sign( SceneBuilder* b, float radiance )
{
    add_flat_mirror( b );
    uint32_t sign = add_material( b, make_light( radiance, false ) );
    add_quad( b, sign, rf_vec3( 0.9f, 1.4f, -BACK ), rf_vec3( -0.6f, 1.4f, -BACK ), rf_vec3( -0.6f, 2.2f, -BACK ),
              rf_vec3( 0.9f, 2.2f, -BACK ) );
}

// One sheet before the mirror and one behind the eyes.
static void add_screens( SceneBuilder* b )
{
    uint32_t screen = add_material( b, make_lambert( 0.8f, 0.8f, 0.7f ) );
    add_upright( b, screen, -0.4f, 0.5f, 1.3f, 1.9f, -1.5f );
    add_upright( b, screen, -1.5f, 0.8f, 0.5f, 2.2f, 1.85f );
    add_flat_mirror( b );
}

static void add_mirrors( SceneBuilder* b, MirrorRoom kind )
{
    switch ( kind )
    {
        case FACING_MIRRORS: add_facing_mirrors( b ); break;
        case CORNER_MIRRORS: add_corner_mirrors( b ); break;
        case L_SHAPED_MIRROR: add_l_shaped_mirror( b ); break;
        case COPLANAR_MIRRORS: add_coplanar_mirrors( b ); break;
        case NARROW_MIRROR: add_upright( b, add_material( b, make_mirror( 0.9f ) ), 0.7f, 0.2f, 1.8f, 2.6f, BACK ); break;
        case STANDING_MIRROR: add_standing_mirror( b ); break;
        case MASKED_SCREENS:
        case BLENDED_SCREENS: add_screens( b ); break;
        case MIRROR_BY_SIGN: add_sign( b, 3.0f ); break;
        case MIRROR_BEHIND_BULB:
            add_sign( b, 20.0f );
            add_sphere( b, add_material( b, make_pane( 0.9f, 0.8f, 0.7f ) ), rf_vec3( -0.1f, 1.1f, -0.6f ), 0.6f, 12 );
            break;
        case MIRROR_BEHIND_PANE:
            add_flat_mirror( b );
            add_upright( b, add_material( b, make_pane( 0.7f, 0.9f, 0.8f ) ), -1.3f, 0.6f, 1.0f, 2.1f, -1.2f );
            break;
        default: add_flat_mirror( b );
    }
}

// What varies over the first material of the kind.
static void add_variation( RfScene* scene, MirrorRoom kind )
{
    RfFactors factors = { .base = { 0.95, 0.9, 0.8, 1 }, .metallic = 1, .ior = 1.5 };
    add_test_textures( scene );
    RfTextured* t = texture_material( scene, FIRST_OWN, factors );
    if ( kind != MASKED_SCREENS && kind != BLENDED_SCREENS )
        t->model = RF_TEXTURED_GLASS;
    else
        t->factors.metallic = 0;
    t->masked = kind == MASKED_MIRROR || kind == MASKED_SCREENS;
    t->alpha_cutoff = 0.5f;
    t->blended = kind == BLENDED_MIRROR || kind == BLENDED_SCREENS;
    if ( t->blended )
        t->factors.base[3] = 0.6;
    else if ( kind == BUMPY_MIRROR )
        use_texture( t, RF_TEXTURE_NORMAL, BUMP_TEXTURE, 0 );
    else
        use_texture( t, RF_TEXTURE_BASE, COLOR_TEXTURE, 0 );
}

RfScene make_mirror_room( MirrorRoom kind )
{
    SceneBuilder b = start_room();
    if ( kind < MIRROR_BALL || kind == MIRROR_BEHIND_BULB )
        add_mirrors( &b, kind );
    else
        add_glass( &b, kind );
    RfScene scene = finish_scene( &b );
    if ( kind >= BUMPY_MIRROR && kind <= BLENDED_SCREENS )
        add_variation( &scene, kind );
    return scene;
}

RfScene make_mirror_in_the_open( OpenLight light )
{
    RfScene scene = make_open_scene( light );
    SceneBuilder b = { .scene = scene, .vertex_room = scene.triangles.vertex_count, .triangle_room = scene.triangles.count };
    add_upright( &b, add_material( &b, make_tinted_mirror( 0.9f, 0.8f, 0.6f ) ), -1.5f, 0.05f, 1.4f, 2.2f, -1.2f );
    free( b.scene.path );
    return finish_scene( &b );
}

void sweep_eyes( RfEye* eyes, int count, int width, int height )
{
    for ( int i = 0; i < count; ++i )
    {
        float k = (float)( i - count / 2 ), a = 8.0f * RF_PI / 180.0f * k;
        RfVec3 o = rf_vec3( 0.05f * k, 1.3f, 1.0f );
        eyes[i] = rf_make_eye( o, rf_vec3( sinf( a ), -0.1f, -cosf( a ) ), rf_vec3( 0, 1, 0 ), 0.8, width, height );
    }
}

void crossing_eyes( RfEye* eyes, int count, int width, int height )
{
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 o = rf_vec3( -1.25f, 1.3f, 0.2f * (float)( count / 2 - i ) );
        eyes[i] = rf_make_eye( o, rf_vec3( 1.0f, -0.05f, -0.35f * o.z ), rf_vec3( 0, 1, 0 ), 1.0, width, height );
    }
}
