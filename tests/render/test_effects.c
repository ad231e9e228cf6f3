// The list of effects is complete, names what runs, and forcing or leaving out does what it says.
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/test.h"

#include "render/memory/memory.h"
#include "scene/lens.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EYES 3
#define WIDTH 32
#define HEIGHT 20

static RfRenderSettings quick( int group, const char* tile )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = 2 * group + 1;
    settings.threads = 1;
    settings.memory = (size_t)256 << 20;
    settings.adaptive = RF_ADAPTIVE_OFF;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

static RfScene glass_room( void ) { return make_glass_room(); }
static RfScene pane_room( void ) { return make_pane_room( PANES_AND_ALL ); }
static RfScene textured_room( void ) { return make_textured_room(); }
static RfScene blended_room( void ) { return make_blended_room(); }
static RfScene phong_room( void ) { return make_room( ROOM_PHONG ); }
static RfScene open_scene( void ) { return make_open_scene( LIT_BY_ALL ); }
static RfScene metal_room( void ) { return make_mirror_room( SHARP_METAL ); }
static RfScene mirror_room( void ) { return make_mirror_room( FLAT_MIRROR ); }

static RfScene ( *const s_scenes[] )( void ) = { phong_room,   glass_room, pane_room,  textured_room,
                                                 blended_room, open_scene, metal_room, mirror_room };
#define SCENES ( sizeof s_scenes / sizeof s_scenes[0] )

// Every trait by which code is switched is the reason of a row, which is on where the trait is.
TEST( test_every_trait_has_its_row )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = quick( 1, "3x3" );
    uint64_t seen = 0;
    for ( size_t k = 0; k < 2 * SCENES; ++k )
    {
        RfScene scene = s_scenes[k / 2]();
        RfEffect rows[RF_MAX_EFFECTS];
        rf_set_lens( eyes, k % 2 == 0 ? 0.0 : 0.05, 2.0, 0, 0.0 );
        eyes[1].moves = k % 2 == 0 ? 0 : 1;
        RfSceneTraits traits = rf_scene_traits( &scene, eyes, EYES, &settings );
        assert_int_equal( rf_list_render_effects( &scene, eyes, EYES, &settings, rows ), RF_EFFECT_COUNT );
#define CHECK( flag, effect )                                                                                                    \
    assert_int_equal( rows[RF_EFFECT_##effect].on, traits.flag );                                                                \
    seen |= traits.flag ? RF_EFFECT_BIT( RF_EFFECT_##effect ) : 0;
        RF_TRAIT_LIST( CHECK )
#undef CHECK
        // models without an effect of their own go with that of GGX
        static const RfEffectId of_kind[RF_BSDF_KIND_COUNT] = {
            [RF_BSDF_LAMBERT] = RF_EFFECT_DIFFUSE,
            [RF_BSDF_PHONG] = RF_EFFECT_PHONG,
            [RF_BSDF_GGX] = RF_EFFECT_GGX,
            [RF_BSDF_COATED] = RF_EFFECT_CLEARCOAT,
            [RF_BSDF_SHEEN] = RF_EFFECT_SHEEN,
            [RF_BSDF_ANISOTROPIC] = RF_EFFECT_ANISOTROPY,
            [RF_BSDF_IRIDESCENT] = RF_EFFECT_IRIDESCENCE,
            [RF_BSDF_LAYERED] = RF_EFFECT_GGX,
            [RF_BSDF_TRANSLUCENT] = RF_EFFECT_DIFFUSE_TRANSMISSION,
            [RF_BSDF_FROSTED] = RF_EFFECT_TRANSMISSION,
        };
        for ( int kind = RF_BSDF_PHONG; kind < RF_BSDF_GLASS; ++kind )
            assert_true( rows[of_kind[kind]].on || ( traits.kinds >> kind & 1u ) == 0 );
        bool glass = rows[RF_EFFECT_MIRRORS].on || rows[RF_EFFECT_TRANSMISSION].on;
        assert_int_equal( glass, traits.kinds >> RF_BSDF_GLASS & 1u );
        rf_destroy_scene( &scene );
    }
#define SEEN( flag, effect ) assert_true( ( seen & RF_EFFECT_BIT( RF_EFFECT_##effect ) ) != 0 );
    RF_TRAIT_LIST( SEEN )
#undef SEEN
}

TEST( test_rows_have_names_and_reasons )
{
    RfScene scene = make_room( ROOM_DIFFUSE );
    RfRenderSettings settings = quick( 0, "1" );
    RfEffect rows[RF_MAX_EFFECTS];
    assert_int_equal( rf_list_render_effects( &scene, NULL, 0, &settings, rows ), RF_EFFECT_COUNT );
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        uint64_t set;
        assert_int_equal( rows[i].id, i );
        assert_string_equal( rows[i].name, rf_effect_name( (RfEffectId)i ) );
        assert_true( rows[i].why[0] != '\0' );
        assert_int_equal( rf_parse_effects( rows[i].name, &set, NULL ), RF_OK );
        assert_true( set == RF_EFFECT_BIT( i ) );
    }
    rf_destroy_scene( &scene );
}

static Rendered render_scene( const RfScene* scene, const RfRenderSettings* settings )
{
    RfTracer* tracer = make_tracer( scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    Rendered rendered = render_frames( tracer, eyes, EYES, &( int ){ 1 }, 1, settings );
    rf_destroy_tracer( tracer );
    return rendered;
}

// The picture with all effects forced is that without, to rounding, and the code does run: batches are larger.
TEST( test_forced_effects_leave_the_picture )
{
    static const struct
    {
        int group;
        const char* tile;
    } settings_of[] = { { 0, "1" }, { 1, "1" }, { 1, "3x3" } };
    for ( size_t k = 0; k < SCENES; ++k )
    {
        for ( size_t s = 0; s < sizeof settings_of / sizeof settings_of[0]; ++s )
        {
            RfRenderSettings settings = quick( settings_of[s].group, settings_of[s].tile );
            RfScene scene = s_scenes[k]();
            Rendered as_called = render_scene( &scene, &settings );
            assert_int_equal( rf_choose_effects( &scene, rf_forcible_effects(), 0, NULL ), RF_OK );
            Rendered forced = render_scene( &scene, &settings );
            double most = 0.0;
            for ( size_t i = 0; i < 3 * forced.pixels; ++i )
            {
                double a = (double)as_called.rgb[i], b = (double)forced.rgb[i];
                most = fmax( most, fabs( a - b ) / ( fabs( a ) + 1e-3 ) );
            }
            if ( !( most < 2e-5 ) )
                fail_msg( "scene %zu, group %d, tile %s: differs by %g of itself", k, settings_of[s].group, settings_of[s].tile,
                          most );
            assert_true( forced.stats.peak_bytes > as_called.stats.peak_bytes );
            free_rendered( &as_called );
            free_rendered( &forced );
            rf_destroy_scene( &scene );
        }
    }
}

// Each effect that a scene can do without is off then, and says so.
TEST( test_left_out_effects_are_off )
{
    RfRenderSettings settings = quick( 1, "3x3" );
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        RfScene scene = s_scenes[(size_t)i % SCENES]();
        RfError error;
        RfEffect rows[RF_MAX_EFFECTS];
        RfResult result = rf_choose_effects( &scene, 0, RF_EFFECT_BIT( i ), &error );
        if ( rf_effect_without( (RfEffectId)i ) == RF_WITHOUT_IMPOSSIBLE )
        {
            assert_int_equal( result, RF_ERROR_USAGE );
            assert_non_null( strstr( error.text, rf_effect_name( (RfEffectId)i ) ) );
        }
        else
        {
            assert_int_equal( result, RF_OK );
            rf_list_render_effects( &scene, NULL, 0, &settings, rows );
            assert_true( rows[i].left_out && !rows[i].on );
            assert_non_null( strstr( rows[i].why, "left out" ) );
        }
        rf_destroy_scene( &scene );
    }
}

static RfScene coated_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    RfMaterial* m = scene.materials + ROOM_OBJECT_MATERIAL;
    m->kind = RF_BSDF_COATED;
    m->clearcoat = 1.0f;
    m->clearcoat_alpha = 0.1f;
    return scene;
}

static RfScene sheen_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    RfMaterial* m = scene.materials + ROOM_OBJECT_MATERIAL;
    m->kind = RF_BSDF_SHEEN;
    m->sheen = rf_vec3( 0.9f, 0.5f, 0.8f );
    m->sheen_alpha = 0.2f;
    return scene;
}

static RfScene ggx_room( void ) { return make_room( ROOM_GGX ); }

static RfScene layered_room( bool coat, bool anisotropy, bool film )
{
    RfScene scene = coat ? coated_room() : ggx_room();
    RfMaterial* m = scene.materials + ROOM_OBJECT_MATERIAL;
    m->anisotropy = anisotropy ? 0.8f : 0.0f;
    m->stretch_x = 1.0f;
    m->film = film ? 1.0f : 0.0f;
    m->film_ior = 1.5f;
    m->film_thickness = 300.0f;
    rf_choose_layers( m );
    return scene;
}

static RfScene anisotropic_room( void ) { return layered_room( false, true, false ); }
static RfScene iridescent_room( void ) { return layered_room( false, false, true ); }
static RfScene all_layers_room( void ) { return layered_room( true, true, true ); }
static RfScene room_without_coat( void ) { return layered_room( false, true, true ); }
static RfScene room_without_film( void ) { return layered_room( true, true, false ); }

static RfScene phong_as_lambert( void )
{
    RfScene scene = make_room( ROOM_PHONG );
    for ( uint32_t i = 0; i < scene.material_count; ++i )
    {
        if ( scene.materials[i].kind == RF_BSDF_PHONG )
            scene.materials[i].kind = RF_BSDF_LAMBERT;
    }
    return scene;
}

static RfScene lit_by_sky( void ) { return make_open_scene( LIT_BY_SKY ); }
static RfScene lit_by_lamps( void ) { return make_open_scene( LIT_BY_LAMPS ); }

static RfScene lit_by_both( void )
{
    RfScene sky = make_open_scene( LIT_BY_SKY ), scene = make_open_scene( LIT_BY_LAMPS );
    scene.environment.radiance = sky.environment.radiance;
    rf_destroy_scene( &sky );
    return scene;
}

static RfScene curtain_room( void ) { return make_curtain_room( CURTAIN ); }

// The light that its curtain, shade and leaf let through is lost.
static RfScene opaque_curtains( void )
{
    RfScene scene = make_curtain_room( CURTAIN );
    for ( uint32_t i = 0; i < scene.material_count; ++i )
    {
        if ( scene.materials[i].kind == RF_BSDF_TRANSLUCENT )
            scene.materials[i].kind = RF_BSDF_GGX;
    }
    return scene;
}

static RfScene absorbing_ball( void ) { return make_mirror_room( ABSORBING_BALL ); }

static RfScene clear_ball( void )
{
    RfScene scene = make_mirror_room( ABSORBING_BALL );
    for ( uint32_t i = 0; i < scene.material_count; ++i )
        scene.materials[i].absorption = rf_vec3( 0, 0, 0 );
    return scene;
}

// A picture without an effect has the bits of the scene that was made without it, and not those of the whole scene.
TEST( test_left_out_is_as_made_without )
{
    static const struct
    {
        RfEffectId effect;
        RfScene ( *with )( void );
        RfScene ( *without )( void );
    } cases[] = { { RF_EFFECT_CLEARCOAT, coated_room, ggx_room },
                  { RF_EFFECT_SHEEN, sheen_room, ggx_room },
                  { RF_EFFECT_DIFFUSE_TRANSMISSION, curtain_room, opaque_curtains },
                  { RF_EFFECT_ANISOTROPY, anisotropic_room, ggx_room },
                  { RF_EFFECT_IRIDESCENCE, iridescent_room, ggx_room },
                  { RF_EFFECT_CLEARCOAT, all_layers_room, room_without_coat },
                  { RF_EFFECT_IRIDESCENCE, all_layers_room, room_without_film },
                  { RF_EFFECT_PHONG, phong_room, phong_as_lambert },
                  { RF_EFFECT_ENVIRONMENT, lit_by_both, lit_by_lamps },
                  { RF_EFFECT_PUNCTUAL_LIGHTS, lit_by_both, lit_by_sky },
                  { RF_EFFECT_ABSORPTION, absorbing_ball, clear_ball } };
    RfRenderSettings settings = quick( 1, "3x3" );
    for ( size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k )
    {
        RfScene whole = cases[k].with(), left = cases[k].with(), made = cases[k].without();
        assert_int_equal( rf_choose_effects( &left, 0, RF_EFFECT_BIT( cases[k].effect ), NULL ), RF_OK );
        Rendered a = render_scene( &left, &settings ), b = render_scene( &made, &settings ),
                 c = render_scene( &whole, &settings );
        assert_memory_equal( a.rgb, b.rgb, 3 * a.pixels * sizeof( float ) );
        assert_memory_not_equal( a.rgb, c.rgb, 3 * a.pixels * sizeof( float ) );
        free_rendered( &a );
        free_rendered( &b );
        free_rendered( &c );
        rf_destroy_scene( &whole );
        rf_destroy_scene( &left );
        rf_destroy_scene( &made );
    }
}

// Selection by power has its own proof, tests/light/test_light_sampling_unbiased.c.
TEST( test_no_light_tree_is_selection_by_power )
{
    RfRenderSettings settings = quick( 1, "3x3" );
    RfScene left = open_scene(), whole = open_scene();
    assert_int_equal( rf_choose_effects( &left, 0, RF_EFFECT_BIT( RF_EFFECT_LIGHT_TREE ), NULL ), RF_OK );
    Rendered a = render_scene( &left, &settings ), c = render_scene( &whole, &settings );
    settings.light_sampling = RF_LIGHTS_BY_POWER;
    Rendered b = render_scene( &whole, &settings );
    assert_memory_equal( a.rgb, b.rgb, 3 * a.pixels * sizeof( float ) );
    assert_memory_not_equal( a.rgb, c.rgb, 3 * a.pixels * sizeof( float ) );
    free_rendered( &a );
    free_rendered( &b );
    free_rendered( &c );
    rf_destroy_scene( &left );
    rf_destroy_scene( &whole );
}

TEST( test_words_are_checked )
{
    uint64_t set;
    RfError error;
    char text[RF_EFFECTS_TEXT_SIZE];
    assert_int_equal( rf_parse_effects( "panes,chains", &set, &error ), RF_OK );
    assert_true( set == ( RF_EFFECT_BIT( RF_EFFECT_PANES ) | RF_EFFECT_BIT( RF_EFFECT_CHAINS ) ) );
    rf_format_effects( set, text, sizeof text );
    assert_string_equal( text, "panes,chains" );
    assert_int_equal( rf_parse_effects( "mirors", &set, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "did you mean mirrors?" ) );
    assert_int_equal( rf_parse_effects( "panes,panes", &set, &error ), RF_ERROR_USAGE );
    assert_int_equal( rf_parse_effects( "zzzzzzzzzzzz", &set, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "smooth-gloss" ) ); // all are named
    RfScene scene = make_room( ROOM_DIFFUSE );
    uint64_t panes = RF_EFFECT_BIT( RF_EFFECT_PANES );
    assert_int_equal( rf_choose_effects( &scene, RF_EFFECT_BIT( RF_EFFECT_ENVIRONMENT ), 0, &error ), RF_ERROR_USAGE );
    assert_int_equal( rf_choose_effects( &scene, panes, panes, &error ), RF_ERROR_USAGE );
    rf_destroy_scene( &scene );
}
