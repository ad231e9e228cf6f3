// Connections to light paths bring the light of mirrors and glass without bias, also past thin panes: that of lamps
// in a mirror against the mirrored lamps, that of area lights against paths that hit them by chance. Welch tests over 16 seeds.
#include "light/small_emitters.h"
#include "support/test.h"
#include "support/unbiased.h"
#include "support/rooms.h"
#include "support/statistics.h"

#define WIDTH 24
#define HEIGHT 18

static int samples( int spp ) { return getenv( "REFRAME_LONG" ) != NULL ? 16 * spp : spp; }

// A square lamp that faces down, or up.
static void add_square_lamp( SceneBuilder* b, float radiance, float x, float y, float half, bool up )
{
    uint32_t light = add_material( b, make_light( radiance, false ) );
    float z = up ? -half : half;
    add_quad( b, light, rf_vec3( x - half, y, -z ), rf_vec3( x + half, y, -z ), rf_vec3( x + half, y, z ),
              rf_vec3( x - half, y, z ) );
}

// Level panes: between the lamps and half of the mirror, in two colours that together let nothing pass; and between all of these and
// the eye, or the ceiling. `mirrored`: the panes as they are seen in the mirror, too.
static void add_level_panes( SceneBuilder* b, bool mirrored )
{
    uint32_t red = add_material( b, make_thin_pane( rf_vec3( 0.9f, 0.4f, 0.0f ), 0.0f ) ),
             blue = add_material( b, make_thin_pane( rf_vec3( 0.0f, 0.0f, 0.8f ), 0.0f ) ),
             grey = add_material( b, make_thin_pane( rf_vec3( 0.6f, 0.7f, 0.5f ), 0.0f ) );
    for ( int side = 1; side >= ( mirrored ? -1 : 1 ); side -= 2 )
    {
        float y = 2.0f * (float)side;
        add_quad( b, grey, rf_vec3( -9, y, -9 ), rf_vec3( 9, y, -9 ), rf_vec3( 9, y, 0.4f ), rf_vec3( -9, y, 0.4f ) );
        y = 0.5f * (float)side;
        add_quad( b, red, rf_vec3( -9, y, -9 ), rf_vec3( 0.2f, y, -9 ), rf_vec3( 0.2f, y, 9 ), rf_vec3( -9, y, 9 ) );
        y = 0.4f * (float)side;
        add_quad( b, blue, rf_vec3( -0.1f, y, -9 ), rf_vec3( 0.7f, y, -9 ), rf_vec3( 0.7f, y, 9 ), rf_vec3( -0.1f, y, 9 ) );
    }
}

// A ceiling over a floor that is a perfect mirror, or over the mirrored lamp alone; `squares`: with a large lamp and a small one.
static RfScene make_ceiling( RfPunctual lamp, bool squares, bool panes, bool mirror )
{
    SceneBuilder b = { 0 };
    uint32_t white = add_material( &b, make_lambert( 0.7f, 0.6f, 0.5f ) );
    RfMaterial perfect = make_mirror( 1.0f );
    perfect.specular = rf_vec3( 1, 1, 1 );
    uint32_t floor = add_material( &b, perfect );
    add_quad( &b, white, rf_vec3( -2, 3, -2 ), rf_vec3( 2, 3, -2 ), rf_vec3( 2, 3, 2 ), rf_vec3( -2, 3, 2 ) );
    float half = squares || lamp.kind == RF_PUNCTUAL_DIRECTIONAL ? 9.0f : 2.0f; // light paths go to all of it
    if ( mirror )
        add_quad( &b, floor, rf_vec3( -half, 0, half ), rf_vec3( half, 0, half ), rf_vec3( half, 0, -half ),
                  rf_vec3( -half, 0, -half ) );
    if ( panes )
        add_level_panes( &b, !mirror );
    for ( int up = 0; squares && up < 2 - mirror; ++up )
    {
        add_square_lamp( &b, 3.0f, 1.7f, up ? -1.2f : 1.2f, 0.8f, up );
        add_square_lamp( &b, 300.0f, -1.2f, up ? -1.0f : 1.0f, 0.04f, up );
    }
    RfScene scene = finish_scene( &b );
    scene.punctuals = malloc( 2 * sizeof *scene.punctuals );
    if ( scene.punctuals == NULL )
        abort();
    scene.punctuals[0] = scene.punctuals[1] = lamp;
    scene.punctuals[1].position.y *= -1.0f;
    scene.punctuals[1].direction.y *= -1.0f;
    if ( lamp.soft ) // turned to the mirror, which parts all ways in one ratio: that of discs of the same falloff
        scene.punctuals[1].radius *= ( 3.0f + lamp.position.y ) / lamp.position.y;
    scene.punctuals[0].name = scene.punctuals[1].name = NULL;
    scene.punctual_count = mirror ? 1 : 2;
    return scene;
}

static Images ceiling_images( RfPunctual lamp, bool squares, bool panes, bool mirror, int spp )
{
    AUTO_SCENE scene = make_ceiling( lamp, squares, panes, mirror );
    if ( squares && mirror )
        assert_int_equal( rf_count_small_emitters( &scene ), 2 );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eye = rf_make_eye( rf_vec3( 0, 1, 0 ), rf_vec3( 0.2f, 1, 0.1f ), rf_vec3( 0, 0, 1 ), 0.9, WIDTH, HEIGHT );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = spp;
    settings.max_depth = 3;
    settings.light_paths = mirror ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
    Images images = rendered_images( tracer, &eye, 1, 0, settings );
    return images;
}

static void check_lamp( const char* what, RfPunctual lamp, bool panes )
{
    Images connected = ceiling_images( lamp, false, panes, true, samples( 48 ) ),
           mirrored = ceiling_images( lamp, false, panes, false, samples( 16 ) );
    assert_unbiased( what, &connected, &mirrored, 4 );
    free_images( &connected );
    free_images( &mirrored );
}

TEST( test_lamps_without_size_shine_in_mirrors )
{
    RfPunctual lamp = make_point_light( rf_vec3( 0.3f, 1.2f, -0.2f ), 3.0f );
    check_lamp( "point", lamp, false );
    check_lamp( "point, panes", lamp, true );
    lamp.kind = RF_PUNCTUAL_SPOT;
    lamp.direction = rf_normalize( rf_vec3( -0.3f, -1.0f, 0.1f ) );
    lamp.cos_inner = 0.8f;
    lamp.cos_outer = 0.4f;
    check_lamp( "spot", lamp, false );
    lamp.kind = RF_PUNCTUAL_DIRECTIONAL;
    lamp.direction = rf_normalize( rf_vec3( -1.0f, -0.7f, 0.1f ) ); // comes in below the ceiling
    check_lamp( "sun", lamp, false );
    check_lamp( "sun, panes", lamp, true );
}

TEST( test_lamps_with_size_shine_in_mirrors )
{
    RfPunctual lamp = make_point_light( rf_vec3( 0.3f, 1.2f, -0.2f ), 3.0f );
    lamp.radius = 0.4f;
    check_lamp( "ball", lamp, false );
    lamp.soft = true;
    check_lamp( "disc that turns", lamp, false );
    lamp.kind = RF_PUNCTUAL_PLANE;
    lamp.half[0] = 0.5f;
    lamp.half[1] = 0.3f;
    lamp.direction = rf_normalize( rf_vec3( -0.3f, -1.0f, 0.1f ) );
    lamp.across = rf_normalize( rf_vec3( 0.1f, 0.0f, 0.3f ) ); // the mirrored one has the same
    check_lamp( "plane", lamp, false );
    lamp.ellipse = true;
    lamp.tan_spread = 1.0f;
    lamp.spread_scale = 4.6598f; // 1 / ( 1 − π/4 )
    check_lamp( "ellipse with a spread, panes", lamp, true );
    lamp.kind = RF_PUNCTUAL_DIRECTIONAL;
    lamp.direction = rf_normalize( rf_vec3( -1.0f, -0.7f, 0.1f ) );
    lamp.versine = 0.02f;
    check_lamp( "sun with an angle", lamp, false );
}

// One whose profile is its own mirror image about its x axis, which is level.
TEST( test_profiles_shine_in_mirrors )
{
    RfPunctual lamp = make_beam( rf_vec3( 0.3f, 1.2f, -0.2f ), rf_vec3( -0.3f, -1.0f, 0.1f ), 3.0f );
    lamp.across = rf_normalize( rf_vec3( 0.1f, 0.0f, 0.3f ) );
    lamp.profile->references = 3; // lamps of both scenes
    check_lamp( "profile", lamp, false );
}

// The large lamp is left to chance, the small one and that without size to connections.
TEST( test_emitters_are_divided )
{
    RfPunctual lamp = make_point_light( rf_vec3( 0.3f, 1.2f, -0.2f ), 2.0f );
    for ( int panes = 0; panes < 2; ++panes )
    {
        Images divided = ceiling_images( lamp, true, panes, true, samples( 32 ) ),
               mirrored = ceiling_images( lamp, true, panes, false, samples( 16 ) );
        assert_unbiased( panes ? "divided, panes" : "divided", &divided, &mirrored, 4 );
        free_images( &divided );
        free_images( &mirrored );
    }
}

static void check_room( const char* what, MirrorRoom kind, int max_depth, const ChainSetting* setting )
{
    ChainCase c = chain_case( what, max_depth );
    c.settings = setting;
    c.setting_count = 1;
    check_chains( &c, make_mirror_room( kind ) );
}

TEST( test_area_lights_shine_through_glass )
{
    check_room( "glass ball", GLASS_BALL, 5, g_connected + 1 );
    check_room( "layered slab", LAYERED_SLAB, 5, g_connected );
}

TEST( test_area_lights_shine_in_mirrors ) { check_room( "mirror ball", MIRROR_BALL, 4, g_connected ); }

// A ceiling and a wall over smooth metal, a plate and a ball, with a pane between. Mirrors would bring light that the reference lacks.
static RfScene make_plates( RfPunctual lamp, float roughness )
{
    SceneBuilder b = { 0 };
    uint32_t white = add_material( &b, make_lambert( 0.7f, 0.6f, 0.5f ) ), satin = add_material( &b, make_plastic( 0.6f, 0.6f ) ),
             metal = add_material( &b, make_metal( 0.8f, roughness ) ),
             pane = add_material( &b, make_thin_pane( rf_vec3( 0.9f, 0.6f, 0.4f ), 0.0f ) );
    add_quad( &b, white, rf_vec3( -2, 2, -2 ), rf_vec3( 2, 2, -2 ), rf_vec3( 2, 2, 2 ), rf_vec3( -2, 2, 2 ) );
    add_quad( &b, satin, rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 2, 2 ), rf_vec3( -2, 2, 2 ) );
    add_quad( &b, metal, rf_vec3( -1.5f, 0, 1.5f ), rf_vec3( 0.3f, 0, 1.5f ), rf_vec3( 0.3f, 0.2f, -1.5f ),
              rf_vec3( -1.5f, 0.2f, -1.5f ) );
    add_sphere( &b, metal, rf_vec3( 0.9f, 0.3f, 0.2f ), 0.4f, 16 );
    add_quad( &b, pane, rf_vec3( -0.6f, 1.2f, -2 ), rf_vec3( 0.5f, 1.2f, -2 ), rf_vec3( 0.5f, 1.2f, 0.5f ),
              rf_vec3( -0.6f, 1.2f, 0.5f ) );
    RfScene scene = finish_scene( &b );
    scene.punctuals = malloc( sizeof *scene.punctuals );
    if ( scene.punctuals == NULL )
        abort();
    scene.punctuals[0] = lamp;
    scene.punctuals[0].name = NULL;
    scene.punctual_count = 1;
    return scene;
}

static void check_plates( const char* what, RfPunctual lamp, float roughness, int group, const char* tile )
{
    AUTO_SCENE scene = make_plates( lamp, roughness );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[3];
    for ( int i = 0; i < 3; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0.05f * (float)i, 0.7f, -1.2f ), rf_vec3( 0.1f, 0.8f, 1 ), rf_vec3( 0, 1, 0 ), 0.9, WIDTH,
                               HEIGHT );
    RfRenderSettings settings = plain_settings();
    settings.max_depth = 4;
    settings.group = group;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    Images reference = reference_images( tracer, eyes, 1, samples( 256 ), &settings );
    settings.spp = samples( group == 0 ? 24 : 14 );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    Images connected = rendered_images( tracer, eyes, 3, 1, settings );
    assert_unbiased( what, &connected, &reference, 4 );
    free_images( &reference );
    free_images( &connected );
}

TEST( test_smooth_metals_throw_light )
{
    RfPunctual lamp = make_point_light( rf_vec3( 0.2f, 1.5f, 0.3f ), 2.0f );
    check_plates( "point, smooth metals, 0:1", lamp, 0.2f, 0, "1" );
    check_plates( "point, smooth metals, 1:3x3", lamp, 0.1f, 1, "3x3" );
    lamp.kind = RF_PUNCTUAL_DIRECTIONAL;
    lamp.direction = rf_normalize( rf_vec3( -0.2f, -0.7f, 1.0f ) ); // comes in below the ceiling
    check_plates( "sun, smooth metals, 1:3x3", lamp, 0.2f, 1, "3x3" );
    lamp = make_point_light( rf_vec3( 0.2f, 1.5f, 0.3f ), 2.0f );
    lamp.radius = 0.25f;
    check_plates( "ball, smooth metals, 1:3x3", lamp, 0.2f, 1, "3x3" );
}

STATISTICAL_TESTS
