#include "support/mirror_rooms_internal.h"

#include <stdlib.h>

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

static void add_panes( SceneBuilder* b )
{
    add_upright( b, add_material( b, make_pane( 1.0f, 1.0f, 1.0f ) ), -0.9f, 0.5f, 0.5f, 1.7f, 0.5f );
    add_upright( b, add_material( b, make_pane( 0.9f, 0.6f, 0.6f ) ), -0.7f, 0.6f, 0.7f, 1.8f, 0.2f );
    add_upright( b, add_material( b, make_pane( 0.5f, 0.7f, 0.9f ) ), -0.5f, 0.5f, 0.9f, 1.9f, -0.2f );
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

void add_glass( SceneBuilder* b, MirrorRoom kind )
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
        case LAYERED_SLAB: add_slab( b, make_layered() ); break;
        case LAMP_IN_GLASS: add_lamp_in_glass( b ); break;
        case PANES_IN_A_ROW: add_panes( b ); break;
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
