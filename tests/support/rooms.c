#include "support/rooms.h"

#include "image/decode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Materials of every room; further ones follow.
enum
{
    WALL,
    RED,
    BLUE,
    LAMP,
    BLOCK,
    BALL,
    FIRST_OWN, // of the kind of room
};

#define BACK ( -1.9f ) // z of mirrors on the back wall

// A rectangle that faces +z.
static void add_upright( SceneBuilder* b, uint32_t material, float x0, float y0, float x1, float y1, float z );

// Most of the back wall in this material.
static void add_wall_mirror( SceneBuilder* b, uint32_t material );

// A smooth thin wall of glass.
static RfMaterial make_pane( float r, float g, float b );

// What the kinds from MIRROR_BALL on have.
static void add_glass( SceneBuilder* b, MirrorRoom kind );

static void add_upright( SceneBuilder* b, uint32_t material, float x0, float y0, float x1, float y1, float z )
{
    add_quad( b, material, rf_vec3( x0, y0, z ), rf_vec3( x1, y0, z ), rf_vec3( x1, y1, z ), rf_vec3( x0, y1, z ) );
}

static void add_wall_mirror( SceneBuilder* b, uint32_t material ) { add_upright( b, material, -1.6f, 0.3f, 1.6f, 2.3f, BACK ); }

static RfMaterial make_pane( float r, float g, float b )
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

// ---- glass rooms ----

static void add_ball( SceneBuilder* b, RfMaterial material )
{
    add_sphere( b, add_material( b, material ), rf_vec3( -0.1f, 1.1f, 0.1f ), 0.6f, 12 );
}

static void add_slab( SceneBuilder* b, RfMaterial material )
{
    add_box( b, add_material( b, material ), rf_vec3( -0.9f, 0.5f, -0.1f ), rf_vec3( 0.8f, 1.7f, 0.1f ), false );
}

static RfMaterial make_absorbing( float roughness )
{
    RfMaterial glass = make_glass( 1.5f, roughness, false );
    glass.absorption = rf_vec3( 0.3f, 0.8f, 1.5f );
    return glass;
}

static RfMaterial make_layered( void )
{
    RfMaterial glass = make_absorbing( 0.0f );
    glass.diffuse = rf_vec3( 0.4f, 0.3f, 0.1f );
    glass.tint = rf_vec3( 0.4f, 0.5f, 0.5f );
    glass.emission = rf_vec3( 0.1f, 0.1f, 0.2f );
    return glass;
}

static void add_lamp_in_glass( SceneBuilder* b )
{
    add_ball( b, make_absorbing( 0.0f ) );
    add_box( b, add_material( b, make_light( 40.0f, false ) ), rf_vec3( -0.25f, 0.95f, -0.05f ), rf_vec3( 0.05f, 1.25f, 0.25f ),
             false );
}

// With alpha the second and third are rough, the third over a base, and a mirror shows them.
static void add_panes( SceneBuilder* b, float alpha )
{
    RfMaterial second = make_pane( 0.9f, 0.6f, 0.6f ), third = make_pane( 0.5f, 0.7f, 0.9f );
    second.alpha = third.alpha = alpha;
    third.diffuse = rf_scale( rf_vec3( 2.0f, 1.4f, 0.6f ), alpha );
    if ( alpha > 0.0f )
        add_wall_mirror( b, add_material( b, make_mirror( 0.9f ) ) );
    add_upright( b, add_material( b, make_pane( 1.0f, 1.0f, 1.0f ) ), -0.9f, 0.5f, 0.5f, 1.7f, 0.5f );
    add_upright( b, add_material( b, second ), -0.7f, 0.6f, 0.7f, 1.8f, 0.2f );
    add_upright( b, add_material( b, third ), -0.5f, 0.5f, 0.9f, 1.9f, -0.2f );
}

static void add_tank( SceneBuilder* b )
{
    RfMaterial water = make_glass( 1.33f, 0.0f, false );
    water.absorption = rf_vec3( 0.3f, 0.1f, 0.05f );
    add_box( b, add_material( b, water ), rf_vec3( -1.8f, 0.6f, -1.0f ), rf_vec3( 1.8f, 2.6f, 1.9f ), false );
}

// On a ball and on the wall.
static void add_polished( SceneBuilder* b, RfMaterial material )
{
    add_ball( b, material );
    add_wall_mirror( b, b->scene.material_count - 1 );
}

static RfMaterial make_clear_coat( void )
{
    RfMaterial m = make_plastic( 0.6f, 0.5f );
    m.kind = RF_BSDF_COATED;
    m.clearcoat = 1.0f;
    m.clearcoat_alpha = RF_MIN_ALPHA;
    return m;
}

// Stripes on the back wall, which glass shows.
static void add_back_stripes( SceneBuilder* b )
{
    for ( int i = 0; i < 5; ++i )
    {
        float x = -1.8f + 0.8f * (float)i;
        add_upright( b, i % 2 == 0 ? BLUE : RED, x, 0.2f, x + 0.4f, 2.6f, -1.97f );
    }
}

static void add_glass( SceneBuilder* b, MirrorRoom kind )
{
    RfMaterial plastic = make_plastic( 0.6f, 0.05f );
    plastic.alpha = kind == SMOOTH_PLASTIC ? RF_MIN_ALPHA : plastic.alpha;
    add_back_stripes( b );
    switch ( kind )
    {
        case MIRROR_BALL: add_ball( b, make_mirror( 0.9f ) ); break;
        case GLASS_BALL: add_ball( b, make_glass( 1.5f, 0.0f, false ) ); break;
        case ABSORBING_BALL: add_ball( b, make_absorbing( 0.0f ) ); break;
        case GLASS_SLAB: add_slab( b, make_glass( 1.5f, 0.0f, false ) ); break;
        case ABSORBING_SLAB: add_slab( b, make_absorbing( 0.0f ) ); break;
        case ROUGH_SLAB: add_slab( b, make_absorbing( 0.25f ) ); break;
        case FROSTED_SHEETS: add_panes( b, 0.15f ); break;
        case LAYERED_SLAB: add_slab( b, make_layered() ); break;
        case LAMP_IN_GLASS: add_lamp_in_glass( b ); break;
        case PANES_IN_A_ROW: add_panes( b, 0.0f ); break;
        case GLASS_TANK: add_tank( b ); break;
        case SHARP_METAL: add_polished( b, make_metal( 0.9f, 0.05f ) ); break;
        case SMOOTH_PLASTIC:
        case SHARP_PLASTIC: add_polished( b, plastic ); break;
        case CLEAR_COAT: add_polished( b, make_clear_coat() ); break;
        default: break;
    }
}

RfScene make_glass_in_the_open( void )
{
    RfScene scene = make_open_scene( LIT_BY_SKY );
    SceneBuilder b = { .scene = scene, .vertex_room = scene.triangles.vertex_count, .triangle_room = scene.triangles.count };
    uint32_t glass = add_material( &b, make_absorbing( 0.0f ) );
    add_box( &b, glass, rf_vec3( -1.6f, 0.9f, -1.2f ), rf_vec3( 1.6f, 1.1f, 1.2f ), false );
    add_box( &b, glass, rf_vec3( -1.2f, 0.002f, 0.0f ), rf_vec3( -0.1f, 0.1f, 1.2f ), false );
    free( b.scene.path );
    return finish_scene( &b );
}

void low_eyes( RfEye* eyes, int count, int width, int height )
{
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 o = rf_vec3( 0.05f * (float)( i - count / 2 ), 0.8f, 2.4f );
        eyes[i] = rf_make_eye( o, rf_vec3( 0.0f, -0.3f, -1.0f ), rf_vec3( 0, 1, 0 ), 0.9, width, height );
    }
}

// ---- pane room ----

double fresnel( double cos_theta, double ior )
{
    double sin_t = sqrt( 1.0 - cos_theta * cos_theta ) / ior, cos_t = sqrt( 1.0 - sin_t * sin_t );
    double s = ( cos_theta - ior * cos_t ) / ( cos_theta + ior * cos_t );
    double p = ( ior * cos_theta - cos_t ) / ( ior * cos_theta + cos_t );
    return 0.5 * ( s * s + p * p );
}

RfMaterial make_thin_pane( RfVec3 tint, float base )
{
    RfMaterial m = make_glass( 1.5f, 0.0f, true );
    m.tint = tint;
    m.diffuse = rf_vec3( base, base, 0.8f * base );
    return m;
}

enum
{
    PANE_ROOM_WALL,
    PANE_ROOM_LIGHT,
    PANE_ROOM_METAL,
    PANE_ROOM_PLASTIC,
    PANE_ROOM_CLEAR,
    PANE_ROOM_RED,
    PANE_ROOM_MILKY,
    PANE_ROOM_PATTERNED,
    PANE_ROOM_BUMPY,
    PANE_ROOM_BLENDED,
    PANE_ROOM_BALL,
    PANE_ROOM_CURTAIN,
};

static void add_materials( SceneBuilder* b, bool lit )
{
    add_material( b, make_lambert( 0.5f, 0.45f, 0.4f ) );
    add_material( b, make_light( lit ? 6.0f : 0.0f, false ) );
    add_material( b, make_metal( 0.8f, 0.35f ) );
    add_material( b, make_plastic( 0.5f, 0.3f ) );
    add_material( b, make_thin_pane( rf_vec3( 1, 1, 1 ), 0.0f ) );
    add_material( b, make_thin_pane( rf_vec3( 0.9f, 0.3f, 0.2f ), 0.0f ) );
    add_material( b, make_thin_pane( rf_vec3( 0.5f, 0.5f, 0.55f ), 0.4f ) );
    for ( int k = PANE_ROOM_PATTERNED; k <= PANE_ROOM_BLENDED; ++k )
        add_material( b, make_thin_pane( rf_vec3( 0.7f, 0.8f, 0.9f ), 0.0f ) );
    add_material( b, make_thin_pane( rf_vec3( 0.8f, 0.95f, 0.8f ), 0.0f ) );
    add_material( b, make_lambert( 0.4f, 0.6f, 0.4f ) );
}

// A standing square, in the plane of x where `along_z`, else of z.
static void add_square( SceneBuilder* b, uint32_t material, RfVec3 low, float width, float height, bool along_z )
{
    RfVec3 side = along_z ? rf_vec3( 0, 0, width ) : rf_vec3( width, 0, 0 ), up = rf_vec3( 0, height, 0 );
    add_quad( b, material, low, rf_add( low, side ), rf_add( rf_add( low, side ), up ), rf_add( low, up ) );
}

static void add_things( SceneBuilder* b )
{
    // without a ceiling, for sun and sky
    add_quad( b, PANE_ROOM_WALL, rf_vec3( -2, 0, -2 ), rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ) );
    add_square( b, PANE_ROOM_WALL, rf_vec3( -2, 0, -2 ), 4, 3, false );
    add_square( b, PANE_ROOM_WALL, rf_vec3( -2, 0, 2 ), 4, 3, false );
    add_square( b, PANE_ROOM_WALL, rf_vec3( -2, 0, -2 ), 4, 3, true );
    add_square( b, PANE_ROOM_WALL, rf_vec3( 2, 0, -2 ), 4, 3, true );
    for ( int k = 0; k < 2; ++k )
    {
        float y = 2.6f + 0.2f * (float)k;
        add_quad( b, PANE_ROOM_CLEAR, rf_vec3( -2, y, -2 ), rf_vec3( 2, y, -2 ), rf_vec3( 2, y, 2 ), rf_vec3( -2, y, 2 ) );
    }
    add_quad( b, PANE_ROOM_LIGHT, rf_vec3( -1, 2.95f, -1 ), rf_vec3( 1, 2.95f, -1 ), rf_vec3( 1, 2.95f, 1 ),
              rf_vec3( -1, 2.95f, 1 ) );
    add_box( b, PANE_ROOM_PLASTIC, rf_vec3( -0.5f, 0, -1.2f ), rf_vec3( 0.3f, 0.6f, -0.7f ), false );
    add_sphere( b, PANE_ROOM_METAL, rf_vec3( 1.1f, 0.5f, -1.0f ), 0.4f, 10 );
    add_square( b, PANE_ROOM_RED, rf_vec3( -1.6f, 0, -0.4f ), 1.2f, 1.6f, false );
    add_square( b, PANE_ROOM_MILKY, rf_vec3( -0.2f, 0, -0.5f ), 0.9f, 1.2f, false );
    add_square( b, PANE_ROOM_PATTERNED, rf_vec3( 0.8f, 0, -0.3f ), 1.0f, 1.7f, false );
    add_square( b, PANE_ROOM_BUMPY, rf_vec3( 0.1f, 0, -1.9f ), 1.2f, 1.4f, true );
    add_square( b, PANE_ROOM_BLENDED, rf_vec3( -1.2f, 0, -1.6f ), 1.4f, 1.5f, true );
    add_square( b, PANE_ROOM_CURTAIN, rf_vec3( -1.9f, 0, -0.9f ), 1.0f, 2.0f, false );
    add_sphere( b, PANE_ROOM_BALL, rf_vec3( 0.5f, 0.8f, 0.2f ), 0.3f, 10 );
}

// 0 a pattern of transmission and roughness, 1 bumps
static void texture_panes( RfScene* scene )
{
    uint8_t pattern[4 * 16], bumps[4 * 16];
    for ( int i = 0; i < 16; ++i )
    {
        uint8_t p[4] = { (uint8_t)( 90 + 11 * i ), i % 3 == 0 ? 255 : 0, 0, 255 };
        uint8_t n[4] = { (uint8_t)( 108 + 13 * ( i % 4 ) ), (uint8_t)( 148 - 9 * ( i / 4 ) ), 250, 255 };
        for ( int c = 0; c < 4; ++c )
        {
            pattern[4 * i + c] = p[c];
            bumps[4 * i + c] = n[c];
        }
    }
    scene->texture_count = 2;
    scene->textures = calloc( 2, sizeof *scene->textures );
    scene->textures[0] = make_texture( 4, 4, 4, pattern, false );
    scene->textures[1] = make_texture( 4, 4, 4, bumps, false );
    scene->triangles.uvs = calloc( 2 * (size_t)scene->triangles.vertex_count, sizeof( float ) );
    for ( size_t i = 0; i < scene->triangles.vertex_count; ++i )
    {
        const float* p = scene->triangles.positions + 3 * i;
        scene->triangles.uvs[2 * i] = p[0] + 0.9f * p[2];
        scene->triangles.uvs[2 * i + 1] = 0.8f * p[1];
    }
}

static RfTextured* vary( RfScene* scene, uint32_t material, double alpha )
{
    RfMaterial* m = scene->materials + material;
    RfFactors factors = { .specular_color = { 1, 1, 1 }, .specular = 1, .ior = 1.5 };
    double tint[4] = { (double)m->tint.x, (double)m->tint.y, (double)m->tint.z, alpha };
    for ( int c = 0; c < 4; ++c )
        factors.base[c] = tint[c];
    if ( m->kind == RF_BSDF_LAMBERT )
        factors.roughness = factors.base[0] = factors.base[1] = factors.base[2] = 0.6;
    m->textured = make_textured( &factors );
    m->textured->model = m->kind == RF_BSDF_GLASS ? RF_TEXTURED_GLASS : RF_TEXTURED_DIFFUSE;
    m->textured->transmission = 1.0;
    m->textured->blended = alpha < 1.0;
    return m->textured;
}

static RfPunctual lamp( bool sun )
{
    RfPunctual p = make_point_light( rf_vec3( 0.3f, 2.9f, 0.2f ), 5.0f );
    if ( sun )
    {
        p.kind = RF_PUNCTUAL_DIRECTIONAL;
        p.direction = rf_normalize( rf_vec3( 0.35f, -1.0f, -0.4f ) );
        p.intensity = rf_vec3( 3, 2.8f, 2.5f );
    }
    return p;
}

RfScene make_pane_room( PaneLight light )
{
    SceneBuilder b = { 0 };
    add_materials( &b, light == PANES_AND_AREA_LIGHT || light == PANES_AND_ALL );
    add_things( &b );
    RfScene scene = finish_scene( &b );
    texture_panes( &scene );
    RfTextured* patterned = vary( &scene, PANE_ROOM_PATTERNED, 1.0 );
    patterned->factors.roughness = 0.5;
    patterned->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture = patterned->refs[RF_TEXTURE_TRANSMISSION].texture = 0;
    scene.materials[PANE_ROOM_PATTERNED].alpha = 0.25f;
    vary( &scene, PANE_ROOM_BUMPY, 1.0 )->refs[RF_TEXTURE_NORMAL].texture = 1;
    vary( &scene, PANE_ROOM_BLENDED, 0.6 );
    vary( &scene, PANE_ROOM_CURTAIN, 0.5 );
    if ( light == PANES_AND_SKY || light == PANES_AND_ALL )
        scene.environment.radiance = rf_vec3( 0.8f, 1.0f, 1.3f );
    scene.punctual_count = ( light == PANES_AND_LAMP ) + ( light == PANES_AND_SUN ) + 2 * ( light == PANES_AND_ALL );
    scene.punctuals = calloc( 2, sizeof *scene.punctuals );
    for ( int k = 0; k < scene.punctual_count; ++k )
        scene.punctuals[k] = lamp( light == PANES_AND_SUN || k == 1 );
    return scene;
}

// ---- textured room ----

#define SIDE 8

static void* grab( size_t bytes )
{
    void* memory = calloc( 1, bytes );
    if ( memory == NULL )
        abort();
    return memory;
}

RfTextured* make_textured( const RfFactors* factors )
{
    RfTextured* t = grab( sizeof *t );
    t->factors = *factors;
    t->normal_scale = t->clearcoat_normal_scale = 1.0f;
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
        t->refs[i] = ( RfTextureRef ){ .texture = -1, .transform = { 1, 0, 0, 0, 1, 0 } };
    return t;
}

RfTexture make_texture( int width, int height, int channels, const uint8_t* bytes, bool srgb )
{
    size_t size = (size_t)width * (size_t)height * (size_t)channels;
    RfTexture t = { .width = width, .height = height, .channels = channels, .bytes = grab( size ), .largest = 1.0f };
    memcpy( t.bytes, bytes, size );
    for ( int i = 0; i < 256; ++i )
        t.table[i] = srgb ? rf_srgb_to_linear( (float)i / 255.0f ) : (float)i / 255.0f;
    return t;
}

// 0 colour and alpha, 1 roughness and metal, 2 bumps, 3 light
static void add_textures( RfScene* scene )
{
    uint8_t bytes[4][SIDE * SIDE * 4];
    uint32_t seed = 7;
    for ( int i = 0; i < SIDE * SIDE; ++i )
    {
        for ( int k = 0; k < 4; ++k )
        {
            for ( int c = 0; c < 4; ++c )
            {
                seed = seed * 1664525u + 1013904223u;
                bytes[k][4 * i + c] = (uint8_t)( seed >> 24 );
            }
        }
        for ( int c = 0; c < 2; ++c )
            bytes[2][4 * i + c] = (uint8_t)( 96 + bytes[2][4 * i + c] / 4 );
        bytes[2][4 * i + 2] = 255;
        if ( i % SIDE < 4 )
            memset( bytes[3] + 4 * i, 0, 4 );
    }
    scene->texture_count = 4;
    scene->textures = grab( 4 * sizeof *scene->textures );
    for ( int k = 0; k < 4; ++k )
        scene->textures[k] = make_texture( SIDE, SIDE, 4, bytes[k], k == 0 || k == 3 );
}

static void add_attributes( RfScene* scene )
{
    RfTriangles* t = &scene->triangles;
    t->uvs = grab( 2 * (size_t)t->vertex_count * sizeof( float ) );
    t->uvs1 = grab( 2 * (size_t)t->vertex_count * sizeof( float ) );
    t->colors = grab( 4 * (size_t)t->vertex_count * sizeof( float ) );
    for ( size_t i = 0; i < t->vertex_count; ++i )
    {
        const float* p = t->positions + 3 * i;
        t->uvs[2 * i] = 0.7f * p[0] + 0.37f * p[2];
        t->uvs[2 * i + 1] = 0.6f * p[1] + 0.45f * p[2];
        t->uvs1[2 * i] = t->uvs[2 * i + 1];
        t->uvs1[2 * i + 1] = t->uvs[2 * i];
        for ( int c = 0; c < 4; ++c )
            t->colors[4 * i + (size_t)c] = 0.5f + 0.5f * sinf( 3.0f * p[c % 3] + (float)c );
    }
}

void add_test_textures( RfScene* scene )
{
    add_textures( scene );
    add_attributes( scene );
}

RfTextured* texture_material( RfScene* scene, uint32_t material, RfFactors factors )
{
    RfMaterial* m = scene->materials + material;
    m->textured = make_textured( &factors );
    return m->textured;
}

void use_texture( RfTextured* t, RfTextureSlot slot, int number, int set )
{
    t->refs[slot].texture = number;
    t->refs[slot].uv_set = set;
    t->refs[slot].wrap[0] = set == 0 ? RF_WRAP_REPEAT : RF_WRAP_MIRROR;
}

RfScene make_textured_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    add_test_textures( &scene );
    RfFactors paint = { .base = { 0.8, 0.8, 0.7, 1 }, .roughness = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5 };
    use_texture( texture_material( &scene, 0, paint ), RF_TEXTURE_BASE, 0, 0 );
    RfTextured* cut = texture_material( &scene, 1, paint );
    use_texture( cut, RF_TEXTURE_BASE, 0, 1 );
    cut->masked = true;
    cut->alpha_cutoff = 0.5f;
    use_texture( texture_material( &scene, 2, paint ), RF_TEXTURE_EMISSIVE, 3, 0 );
    RfFactors coated = paint;
    coated.specular = 1;
    coated.roughness = 0.6;
    RfTextured* sphere = texture_material( &scene, ROOM_OBJECT_MATERIAL, coated );
    sphere->vertex_colors = true;
    sphere->normal_scale = 0.8f;
    use_texture( sphere, RF_TEXTURE_NORMAL, 2, 0 );
    RfFactors metal = coated;
    metal.metallic = 1;
    metal.roughness = 0.9;
    RfTextured* block = texture_material( &scene, 4, metal );
    use_texture( block, RF_TEXTURE_METALLIC_ROUGHNESS, 1, 1 );
    use_texture( block, RF_TEXTURE_SPECULAR, 0, 0 );
    return scene;
}

static RfTextured* blend( RfScene* scene, uint32_t material, RfFactors factors, double alpha )
{
    factors.base[3] = alpha;
    RfTextured* t = texture_material( scene, material, factors );
    t->blended = true;
    return t;
}

RfScene make_glint_room( RfBsdfKind kind )
{
    RfScene scene = make_room( kind == RF_BSDF_PHONG ? ROOM_PHONG : ROOM_GGX );
    RfMaterial* gloss = scene.materials + ROOM_OBJECT_MATERIAL;
    if ( kind == RF_BSDF_PHONG )
        gloss->exponent = 1000.0f;
    else
        gloss->alpha = 0.04f;
    if ( kind == RF_BSDF_COATED )
    {
        gloss->kind = RF_BSDF_COATED;
        gloss->alpha = 0.5f;
        gloss->clearcoat = 1.0f;
        gloss->clearcoat_alpha = 0.04f;
    }
    scene.punctuals = calloc( 1, sizeof *scene.punctuals );
    scene.punctual_count = 1;
    scene.punctuals[0] = make_point_light( rf_vec3( -0.8f, 2.4f, 1.2f ), 6.0f );
    return scene;
}

RfScene make_blended_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    add_test_textures( &scene );
    RfFactors paint = { .base = { 0.8, 0.5, 0.3, 1 }, .roughness = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5 };
    use_texture( blend( &scene, 1, paint, 0.9 ), RF_TEXTURE_BASE, 0, 1 );
    blend( &scene, 2, paint, 0.7 );
    RfFactors coated = paint;
    coated.specular = 1;
    coated.roughness = 0.5;
    blend( &scene, ROOM_OBJECT_MATERIAL, coated, 0.4 ); // not the block, whose bottom is in the floor
    return scene;
}

RfScene make_varied_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    add_test_textures( &scene );
    RfFactors factors = {
        .base = { 0.8, 0.7, 0.6, 1 }, .metallic = 0.8, .roughness = 0.6, .specular = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5
    };
    RfMaterial* ball = scene.materials + ROOM_OBJECT_MATERIAL;
    ball->kind = RF_BSDF_GLASS;
    ball->ior = 1.5f;
    ball->absorption = rf_vec3( 0.3f, 0.1f, 0.9f );
    RfTextured* glass = texture_material( &scene, ROOM_OBJECT_MATERIAL, factors );
    glass->model = RF_TEXTURED_GLASS;
    glass->transmission = 0.9;
    use_texture( glass, RF_TEXTURE_TRANSMISSION, 0, 1 );
    use_texture( glass, RF_TEXTURE_METALLIC_ROUGHNESS, 1, 0 );
    factors.metallic = 0;
    scene.materials[4].kind = RF_BSDF_COATED;
    RfTextured* coat = texture_material( &scene, 4, factors );
    coat->clearcoat = 0.9;
    coat->clearcoat_roughness = 0.7;
    coat->clearcoat_normal_scale = 0.7f;
    use_texture( coat, RF_TEXTURE_CLEARCOAT, 0, 0 );
    use_texture( coat, RF_TEXTURE_CLEARCOAT_ROUGHNESS, 1, 1 );
    use_texture( coat, RF_TEXTURE_CLEARCOAT_NORMAL, 2, 1 );
    use_texture( coat, RF_TEXTURE_NORMAL, 2, 0 );
    // white paint with a coat that keeps the face's normal over bumps
    scene.materials[1].kind = RF_BSDF_COATED;
    factors.base[0] = factors.base[1] = factors.base[2] = 0.9;
    RfTextured* lacquer = texture_material( &scene, 1, factors );
    lacquer->clearcoat = 1.0;
    lacquer->clearcoat_roughness = 0.4;
    use_texture( lacquer, RF_TEXTURE_NORMAL, 2, 1 );
    return scene;
}

// ---- curtain room ----

// A dielectric over a base that lets light through.
static RfMaterial make_translucent( RfVec3 here, RfVec3 through, float roughness )
{
    RfMaterial m = make_plastic( 0.0f, roughness );
    m.kind = RF_BSDF_TRANSLUCENT;
    m.diffuse = here;
    m.through = through;
    return m;
}

#define FOLDS 16

static RfVec3 on_curtain( int i, float y )
{
    float x = -1.98f + 3.96f * (float)i / FOLDS;
    return rf_vec3( x, y, -0.9f + ( i % 2 == 0 ? 0.08f : -0.08f ) );
}

RfScene make_curtain_room( CurtainRoom kind )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.6f, 0.55f, 0.5f ) ), lamp = add_material( &b, make_light( 12.0f, false ) );
    uint32_t bulb = add_material( &b, make_light( 25.0f, false ) );
    uint32_t cloth = add_material( &b, make_translucent( rf_vec3( 0.3f, 0.2f, 0.1f ), rf_vec3( 0.3f, 0.45f, 0.6f ), 0.8f ) );
    uint32_t leaf = add_material( &b, make_translucent( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, 0 ), 0.4f ) );
    uint32_t shade = add_material( &b, make_translucent( rf_vec3( 0.0f, 0.1f, 0.1f ), rf_vec3( 0.8f, 0.6f, 0.4f ), 0.3f ) );
    add_box( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_quad( &b, lamp, rf_vec3( -1, 1, -1.95f ), rf_vec3( 1, 1, -1.95f ), rf_vec3( 1, 2, -1.95f ), rf_vec3( -1, 2, -1.95f ) );
    for ( int i = 0; i < FOLDS; ++i )
        add_quad( &b, cloth, on_curtain( i, 0.0f ), on_curtain( i + 1, 0.0f ), on_curtain( i + 1, 2.7f ), on_curtain( i, 2.7f ) );
    if ( kind == CURTAIN_CROSSED )
        add_quad( &b, cloth, rf_vec3( -0.6f, 0.2f, 0 ), rf_vec3( 1.4f, 0.2f, 0 ), rf_vec3( 1.4f, 2.4f, 0 ),
                  rf_vec3( -0.6f, 2.4f, 0 ) );
    add_quad( &b, leaf, rf_vec3( 0.2f, 0.4f, 0.1f ), rf_vec3( 1.1f, 0.4f, -0.4f ), rf_vec3( 1.1f, 1.4f, -0.3f ),
              rf_vec3( 0.2f, 1.4f, 0.3f ) );
    add_sphere( &b, shade, rf_vec3( -0.6f, 1.1f, 0.1f ), 0.4f, 10 );
    add_box( &b, bulb, rf_vec3( -0.65f, 1.05f, 0.05f ), rf_vec3( -0.55f, 1.15f, 0.15f ), false );
    if ( kind == CURTAIN_AND_GLASS )
        add_sphere( &b, add_material( &b, make_glass( 1.5f, 0.0f, false ) ), rf_vec3( 0.3f, 0.5f, 0.6f ), 0.3f, 10 );
    RfScene scene = finish_scene( &b );
    add_test_textures( &scene );
    RfFactors factors = { .base = { 0.8, 0.7, 0.6, 1 },
                          .roughness = 0.5,
                          .specular = 1,
                          .specular_color = { 1, 1, 1 },
                          .ior = 1.5,
                          .through = 0.9,
                          .through_color = { 0.6, 0.9, 0.3 } };
    RfTextured* t = texture_material( &scene, leaf, factors );
    t->normal_scale = 0.8f;
    use_texture( t, RF_TEXTURE_BASE, COLOR_TEXTURE, 0 );
    use_texture( t, RF_TEXTURE_NORMAL, BUMP_TEXTURE, 0 );
    use_texture( t, RF_TEXTURE_THROUGH, COLOR_TEXTURE, 1 );
    use_texture( t, RF_TEXTURE_THROUGH_COLOR, COLOR_TEXTURE, 0 );
    return scene;
}
