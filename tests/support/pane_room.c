#include "support/pane_room.h"

#include "support/textured_room.h"

#include <math.h>
#include <stdlib.h>

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
    WALL,
    LIGHT,
    METAL,
    PLASTIC,
    CLEAR,
    RED,
    MILKY,
    PATTERNED,
    BUMPY,
    BLENDED,
    BALL,
    CURTAIN,
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
    for ( int k = PATTERNED; k <= BLENDED; ++k )
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
    add_quad( b, WALL, rf_vec3( -2, 0, -2 ), rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ) );
    add_square( b, WALL, rf_vec3( -2, 0, -2 ), 4, 3, false );
    add_square( b, WALL, rf_vec3( -2, 0, 2 ), 4, 3, false );
    add_square( b, WALL, rf_vec3( -2, 0, -2 ), 4, 3, true );
    add_square( b, WALL, rf_vec3( 2, 0, -2 ), 4, 3, true );
    for ( int k = 0; k < 2; ++k )
    {
        float y = 2.6f + 0.2f * (float)k;
        add_quad( b, CLEAR, rf_vec3( -2, y, -2 ), rf_vec3( 2, y, -2 ), rf_vec3( 2, y, 2 ), rf_vec3( -2, y, 2 ) );
    }
    add_quad( b, LIGHT, rf_vec3( -1, 2.95f, -1 ), rf_vec3( 1, 2.95f, -1 ), rf_vec3( 1, 2.95f, 1 ), rf_vec3( -1, 2.95f, 1 ) );
    add_box( b, PLASTIC, rf_vec3( -0.5f, 0, -1.2f ), rf_vec3( 0.3f, 0.6f, -0.7f ), false );
    add_sphere( b, METAL, rf_vec3( 1.1f, 0.5f, -1.0f ), 0.4f, 10 );
    add_square( b, RED, rf_vec3( -1.6f, 0, -0.4f ), 1.2f, 1.6f, false );
    add_square( b, MILKY, rf_vec3( -0.2f, 0, -0.5f ), 0.9f, 1.2f, false );
    add_square( b, PATTERNED, rf_vec3( 0.8f, 0, -0.3f ), 1.0f, 1.7f, false );
    add_square( b, BUMPY, rf_vec3( 0.1f, 0, -1.9f ), 1.2f, 1.4f, true );
    add_square( b, BLENDED, rf_vec3( -1.2f, 0, -1.6f ), 1.4f, 1.5f, true );
    add_square( b, CURTAIN, rf_vec3( -1.9f, 0, -0.9f ), 1.0f, 2.0f, false );
    add_sphere( b, BALL, rf_vec3( 0.5f, 0.8f, 0.2f ), 0.3f, 10 );
}

// 0 a pattern of transmission and roughness, 1 bumps
static void add_textures( RfScene* scene )
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
    add_textures( &scene );
    RfTextured* patterned = vary( &scene, PATTERNED, 1.0 );
    patterned->factors.roughness = 0.5;
    patterned->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture = patterned->refs[RF_TEXTURE_TRANSMISSION].texture = 0;
    scene.materials[PATTERNED].alpha = 0.25f;
    vary( &scene, BUMPY, 1.0 )->refs[RF_TEXTURE_NORMAL].texture = 1;
    vary( &scene, BLENDED, 0.6 );
    vary( &scene, CURTAIN, 0.5 );
    if ( light == PANES_AND_SKY || light == PANES_AND_ALL )
        scene.environment.radiance = rf_vec3( 0.8f, 1.0f, 1.3f );
    scene.punctual_count = ( light == PANES_AND_LAMP ) + ( light == PANES_AND_SUN ) + 2 * ( light == PANES_AND_ALL );
    scene.punctuals = calloc( 2, sizeof *scene.punctuals );
    for ( int k = 0; k < scene.punctual_count; ++k )
        scene.punctuals[k] = lamp( light == PANES_AND_SUN || k == 1 );
    return scene;
}
