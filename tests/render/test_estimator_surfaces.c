// Groups, tiles, extra samples and light paths are unbiased in rooms with what lies over GGX or changes its lobe: sheen of constant
// and of textured colour and roughness, over cloth and over metal; brushed metal; films; layers. All show the same of unlit surfaces.
#include "support/rooms.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 32
#define HEIGHT 24
#define BLOCK 6
#define EYES 7

typedef struct Setting
{
    int group, spp;
    const char* tile;
    RfAdaptive adaptive;
} Setting;

// Against the plain path tracer of the tests.
static void check( const char* what, RfScene scene, const Setting* settings, int count )
{
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    RfEye away[EYES];
    orbit_eyes( eyes, EYES, 6.0f, WIDTH, HEIGHT );
    orbit_eyes( away, EYES, 14.0f, WIDTH, HEIGHT );
    int more = getenv( "REFRAME_LONG" ) != NULL ? 4 : 1, frame = 3;
    eyes[frame] = away[EYES - 1]; // sees much that the others do not: there extra samples pay
    RfRenderSettings plain = plain_settings();
    plain.max_depth = 4;
    Images reference = reference_images( tracer, eyes, frame, 48 * more, &plain );
    for ( int i = 0; i < count; ++i )
    {
        char name[64];
        const Setting* s = settings + i;
        snprintf( name, sizeof name, "%s, group %d tile %s:", what, s->group, s->tile );
        RfRenderSettings render = plain;
        render.group = s->group;
        render.spp = s->spp * more;
        render.adaptive = s->adaptive;
        render.memory = (size_t)512 << 20;
        assert_true( rf_parse_tile( s->tile, &render.tile ) );
        Images rendered = rendered_images( tracer, eyes, EYES, frame, render );
        assert_unbiased( name, &rendered, &reference, BLOCK );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static const Setting s_all[] = { { 3, 6, "3x3", RF_ADAPTIVE_OFF },
                                 { 0, 16, "rooks4", RF_ADAPTIVE_OFF },
                                 { 3, 6, "1", RF_ADAPTIVE_ON } };

static RfMaterial make_cloth( RfVec3 sheen, float alpha )
{
    RfMaterial m = make_plastic( 0.5f, 0.8f );
    m.kind = RF_BSDF_SHEEN;
    m.sheen = sheen;
    m.sheen_alpha = alpha;
    return m;
}

static void replace( RfScene* scene, uint32_t material, RfMaterial by )
{
    by.name = scene->materials[material].name;
    by.double_sided = scene->materials[material].double_sided;
    scene->materials[material] = by;
}

// Cloth on the walls, wide sheen on the ball, narrow sheen over the metal of the block.
static RfScene make_cloth_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    replace( &scene, 0, make_cloth( rf_vec3( 0.9f, 0.9f, 0.9f ), 0.1f ) );
    replace( &scene, ROOM_OBJECT_MATERIAL, make_cloth( rf_vec3( 1.0f, 0.5f, 0.8f ), 0.5f ) );
    RfMaterial velvet = make_metal( 0.8f, 0.5f );
    velvet.kind = RF_BSDF_SHEEN;
    velvet.sheen = rf_vec3( 0.9f, 0.6f, 0.2f );
    velvet.sheen_alpha = RF_MIN_SHEEN_ALPHA;
    replace( &scene, 4, velvet );
    return scene;
}

TEST( test_sheen ) { check( "sheen", make_cloth_room(), s_all, 3 ); }

TEST( test_textured_sheen )
{
    RfScene scene = make_cloth_room();
    add_test_textures( &scene );
    RfFactors factors = { .base = { 0.8, 0.7, 0.6, 1 },
                          .roughness = 0.6,
                          .specular = 1,
                          .specular_color = { 1, 1, 1 },
                          .ior = 1.5,
                          .sheen_color = { 0.9, 0.6, 0.2 },
                          .sheen_roughness = 0.7 };
    uint32_t materials[] = { 0, ROOM_OBJECT_MATERIAL };
    for ( int i = 0; i < 2; ++i )
    {
        RfTextured* cloth = texture_material( &scene, materials[i], factors );
        rf_derive_layers( &factors, scene.materials + materials[i] );
        use_texture( cloth, RF_TEXTURE_SHEEN_COLOR, i, 0 );
        use_texture( cloth, RF_TEXTURE_SHEEN_ROUGHNESS, 1 - i, 1 );
        use_texture( cloth, RF_TEXTURE_NORMAL, 2, i );
    }
    check( "textured sheen", scene, s_all, 1 );
}

// Brushed metal on the walls, a film over the metal of the ball, and on the block all layers at once.
static RfScene make_metal_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    RfMaterial brushed = make_metal( 0.7f, 0.5f );
    brushed.kind = RF_BSDF_ANISOTROPIC;
    brushed.anisotropy = 0.8f;
    brushed.stretch_x = 0.6f;
    brushed.stretch_y = 0.8f;
    RfMaterial film = make_metal( 0.8f, 0.5f );
    film.kind = RF_BSDF_IRIDESCENT;
    film.film = 1.0f;
    film.film_ior = 1.4f;
    film.film_thickness = 420.0f;
    RfMaterial layered = make_cloth( rf_vec3( 0.8f, 0.5f, 0.9f ), 0.2f );
    layered.kind = RF_BSDF_LAYERED;
    layered.clearcoat = 0.7f;
    layered.clearcoat_alpha = 0.2f;
    layered.anisotropy = 0.5f;
    layered.stretch_x = 1.0f;
    layered.film = 0.8f;
    layered.film_ior = 1.3f;
    layered.film_thickness = 300.0f;
    replace( &scene, 0, brushed );
    replace( &scene, ROOM_OBJECT_MATERIAL, film );
    replace( &scene, 4, layered );
    return scene;
}

TEST( test_metals ) { check( "brushed metal, films, layers", make_metal_room(), s_all, 1 ); }

// A ball of glass before cloth: its light paths end there.
TEST( test_light_paths )
{
    RfScene scene = make_mirror_room( GLASS_BALL );
    for ( uint32_t i = 0; i < scene.material_count; ++i )
    {
        RfMaterial* m = scene.materials + i;
        if ( m->kind == RF_BSDF_LAMBERT && !( rf_max_component( m->emission ) > 0.0f ) )
            replace( &scene, i, make_cloth( m->diffuse, 0.2f ) );
    }
    ChainCase c = chain_case( "sheen behind glass, light paths", 5 );
    c.settings = g_connected + 1;
    c.setting_count = 1;
    check_chains( &c, scene );
}

static float largest( const Images* images, int pixel )
{
    float found = 0.0f;
    for ( int k = 0; k < images->count; ++k )
        found = rf_maxf( found, images->rgb[k][3 * pixel + 1] );
    return found;
}

// A room without light, of which walls and lamps are unlit: the rest is black, but for what mirrors and glass show.
static void check_unlit( const char* what, MirrorRoom kind )
{
    static const Setting s_settings[] = { { 3, 6, "3x3", RF_ADAPTIVE_OFF },
                                          { 2, 8, "1", RF_ADAPTIVE_OFF },
                                          { 0, 16, "rooks4", RF_ADAPTIVE_OFF } };
    RfScene scene = make_mirror_room( kind );
    for ( uint32_t i = 0; i < scene.material_count; ++i )
    {
        RfMaterial* m = scene.materials + i;
        bool wall = m->kind == RF_BSDF_LAMBERT && i % 2 == 0;
        m->emission = wall ? m->diffuse : m->emission;
        m->diffuse = wall ? rf_vec3( 0, 0, 0 ) : m->diffuse;
        m->unlit = wall || rf_max_component( m->emission ) > 0.0f;
    }
    RfTracer* tracer = make_tracer( &scene );
    assert_false( rf_tracer_has_light( tracer ) );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 6.0f, WIDTH, HEIGHT );
    RfRenderSettings plain = plain_settings();
    plain.spp = 32;
    Images reference = rendered_images( tracer, eyes, EYES, 3, plain );
    int black = 0, bright = 0;
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        black += largest( &reference, i ) == 0.0f;
        bright += largest( &reference, i ) > 0.1f;
    }
    if ( black < 10 || bright < 100 )
        fail_msg( "%s: %d pixels are black, %d bright", what, black, bright );
    for ( size_t i = 0; i < sizeof s_settings / sizeof s_settings[0]; ++i )
    {
        char name[64];
        RfRenderSettings render = plain;
        render.group = s_settings[i].group;
        render.spp = s_settings[i].spp;
        assert_true( rf_parse_tile( s_settings[i].tile, &render.tile ) );
        snprintf( name, sizeof name, "unlit, %s, group %d tile %s:", what, render.group, s_settings[i].tile );
        Images rendered = rendered_images( tracer, eyes, EYES, 3, render );
        assert_unbiased( name, &rendered, &reference, BLOCK );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_unlit_surfaces )
{
    check_unlit( "flat mirror", FLAT_MIRROR );
    check_unlit( "mirror ball", MIRROR_BALL );
    check_unlit( "glass ball", GLASS_BALL );
    check_unlit( "panes", PANES_IN_A_ROW );
    check_unlit( "smooth plastic", SMOOTH_PLASTIC );
}
