// Light groups: the pictures of all groups add up to the picture, which is what it is without them, in every mode and in rooms with
// all kinds of light; each is the picture under the lights of its group alone, by the same random numbers.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include "scene/light_groups.h"
#include "trace/trace.h"

#include <stdio.h>

#define EYES 5
#define WIDTH 24
#define HEIGHT 18
#define VALUES ( 3 * WIDTH * HEIGHT )
#define FRAME 2
#define TOLERANCE 1e-5 // of a value and the brightness

typedef struct Lit
{
    const RfScene* scene;
    const RfLights* lights;
    const RfLightGroups* groups;
    int group;
} Lit;

static bool is_lit( void* user, uint32_t light )
{
    const Lit* lit = user;
    uint32_t punctual = light - lit->lights->triangle_count;
    if ( light < lit->lights->triangle_count )
        return lit->groups->material[rf_material_of( lit->scene, lit->lights->light[light].triangle )] == lit->group;
    return ( punctual < (uint32_t)lit->lights->punctual_count ? lit->groups->punctual[punctual] : lit->groups->sky ) ==
           lit->group;
}

// Each group against a picture of a tracer under its lights alone.
static void check_alone( const char* what, Stage* stage, RfRenderSettings settings, const RfFrameResult* split, double bright )
{
    RfLightGroups groups;
    const RfTracer* tracer = stage_tracer( stage );
    assert_int_equal( rf_find_light_groups( &stage->scene, "all", &groups, NULL ), RF_OK );
    settings.light_groups = NULL;
    Lit lit = { .scene = &stage->scene, .lights = rf_tracer_lights( tracer ), .groups = &groups };
    for ( ; lit.group < split->layer_count; ++lit.group )
    {
        RfRelitTracer* relit;
        const RfLayer* layer = split->layers + lit.group;
        assert_int_equal( rf_create_relit_tracer( tracer, is_lit, &lit, &relit, NULL ), RF_OK );
        RfShot shot = { rf_relit_tracer( relit ), stage->eyes, stage->eye_count, &( int ){ FRAME }, 1 };
        const RfFrameResult* alone = render_shot( stage, &shot, &settings );
        rf_destroy_relit_tracer( relit );
        expect_sum( what, layer->name, &layer->values, 1, alone->rgb, VALUES, TOLERANCE, bright );
    }
    rf_destroy_light_groups( &groups );
}

typedef enum Compared
{
    ALL,
    SUM_AND_PICTURE, // a group alone would differ: by chance that depends on the other lights, or by what moves
    SUM,             // the clamp acts on each group by itself
} Compared;

// Groups add up; the picture is that without groups. Returns how many groups shine.
static int check( const char* what, Stage* stage, int frames, RfRenderSettings settings, Compared compared )
{
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    const RfFrameResult* whole = render_some( stage, FRAME, frames, &settings );
    assert_int_equal( whole->layer_count, 0 );
    settings.light_groups = "all";
    const RfFrameResult* split = render_some( stage, FRAME, frames, &settings );
    assert_true( stage->previews >= 1 );
    double bright = brightness( whole->rgb, VALUES );
    const float* groups[RF_LIGHT_GROUPS_MOST];
    int shining = 0;
    for ( int g = 0; g < split->layer_count; ++g )
    {
        assert_string_equal( split->layers[g].letters, "RGB" );
        groups[g] = split->layers[g].values;
        shining += brightness( groups[g], VALUES ) > 1e-3 * bright;
    }
    expect_sum( what, "the sum of groups", groups, split->layer_count, split->rgb, VALUES, TOLERANCE, bright );
    if ( compared != SUM )
        expect_sum( what, "the picture", &split->rgb, 1, whole->rgb, VALUES, TOLERANCE, bright );
    if ( compared == ALL )
        check_alone( what, stage, settings, split, brightness( split->rgb, VALUES ) );
    return shining;
}

// One line of error for what cannot split light; light paths are off where nobody asks for them.
TEST( test_refusals )
{
    static const char* const texts[] = { "light paths cannot split light by groups", "the biased weights cannot split light",
                                         "the estimator 'gradient' cannot split light", "caustics cannot be left out", NULL };
    Stage stage;
    open_stage( &stage, make_mirror_room( GLASS_BALL ), 1, 3.0f, WIDTH, HEIGHT );
    tag_lights( &stage.scene, 1 );
    for ( int k = 0; k < 5; ++k )
    {
        RfRenderSettings settings = reuse_mode( 0 );
        settings.light_groups = "all";
        settings.light_paths = k == 0 ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
        settings.weights = k == 1 ? RF_WEIGHTS_EQ15 : RF_WEIGHTS_EXACT;
        settings.estimator = k == 2 ? rf_find_estimator( "gradient" ) : settings.estimator;
        stage.scene.effects_left_out = k == 3 ? RF_EFFECT_BIT( RF_EFFECT_CAUSTICS ) : 0;
        expect_refused( &stage, &settings, texts[k] );
    }
    close_stage( &stage );
}

static void check_room( const char* name, RfScene scene, int tags, int shining, Compared compared )
{
    Stage stage;
    open_stage( &stage, scene, EYES, 3.0f, WIDTH, HEIGHT );
    tag_lights( &stage.scene, tags );
    for ( int mode = 0; mode < REUSE_MODES; ++mode )
    {
        char what[80];
        snprintf( what, sizeof what, "%s, mode %d", name, mode );
        int count = check( what, &stage, 1, reuse_mode( mode ), mode == 0 ? ALL : compared );
        if ( count < shining )
            fail_msg( "%s: %d groups shine", what, count );
    }
    close_stage( &stage );
}

TEST( test_still_rooms )
{
    check_room( "open", make_open_scene( LIT_BY_ALL ), 3, 4, ALL );
    check_room( "sky", make_open_scene( LIT_BY_MAP ), 1, 1, ALL );
    check_room( "panes", make_pane_room( PANES_AND_ALL ), 2, 3, SUM_AND_PICTURE );
    RfScene room = make_room( ROOM_GGX );
    add_punctual( &room, make_point_light( rf_vec3( 1.0f, 2.0f, 1.0f ), 2.0f ) );
    add_punctual( &room, make_point_light( rf_vec3( -1.0f, 1.0f, 1.0f ), 1.0f ) );
    check_room( "room", room, 2, 3, ALL );
}

TEST( test_chains )
{
    static const MirrorRoom kinds[] = { MIRROR_BY_SIGN, FACING_MIRRORS, GLASS_BALL,         LAYERED_SLAB, LAMP_IN_GLASS,
                                        SHARP_PLASTIC,  CLEAR_COAT,     MIRROR_BEHIND_BULB, GLASS_TANK,   BLENDED_MIRROR };
    for ( size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k )
    {
        char name[32];
        snprintf( name, sizeof name, "mirror room %d", (int)kinds[k] );
        RfScene room = make_mirror_room( kinds[k] );
        add_punctual( &room, make_point_light( rf_vec3( 1.0f, 2.0f, 1.0f ), 2.0f ) );
        check_room( name, room, 2, kinds[k] == GLASS_TANK ? 1 : 2, SUM_AND_PICTURE );
    }
    check_room( "glass under the sky", make_mirror_in_the_open( LIT_BY_ALL ), 3, 4, SUM_AND_PICTURE );
}

TEST( test_moving_rooms )
{
    static const char* const rooms[] = { "dimmer", "glow", "blackout", "lamps", "torch", "seen", "mirrors", "panes", "sky" };
    for ( size_t k = 0; k < sizeof rooms / sizeof rooms[0]; ++k )
    {
        Stage stage;
        open_moving_stage( &stage, rooms[k], WIDTH, HEIGHT );
        tag_lights( &stage.scene, 2 );
        for ( int mode = 0; mode < REUSE_MODES; ++mode )
        {
            char what[80];
            snprintf( what, sizeof what, "%s, mode %d", rooms[k], mode );
            check( what, &stage, 1, reuse_mode( mode ), SUM_AND_PICTURE );
        }
        close_stage( &stage );
    }
}

TEST( test_clamp_and_extra_samples )
{
    static const char* const rooms[] = { "dimmer", "mirrors" };
    for ( int k = 0; k < 4; ++k )
    {
        Stage stage;
        RfRenderSettings settings = reuse_mode( REUSE_MODES - 1 );
        open_moving_stage( &stage, rooms[k % 2], WIDTH, HEIGHT );
        tag_lights( &stage.scene, 1 );
        add_punctual( &stage.scene, make_point_light( rf_vec3( 1.0f, 2.0f, 1.0f ), 2.0f ) );
        settings.clamp = k < 2 ? 0.5 : 0.0;
        settings.adaptive = k < 2 ? RF_ADAPTIVE_OFF : RF_ADAPTIVE_ON;
        check( rooms[k % 2], &stage, 1, settings, k < 2 ? SUM : SUM_AND_PICTURE );
        close_stage( &stage );
    }
}

TEST( test_blur_long_sums_and_sweeps )
{
    static const struct
    {
        const char *what, *room;
        int mode;
        float lens;
        int blur_steps, spp, frames;
    } cases[] = {
        { "lens", "mirrors", 3, 0.05f, 0, 5, 1 },
        { "shutter", "torch", 3, 0.0f, 4, 5, 1 },
        { "lens and shutter", "dimmer", 2, 0.05f, 4, 5, 1 },
        { "long sums", "dimmer", 2, 0.0f, 0, 70, 1 },
        { "sweeps", "torch", 3, 0.0f, 0, 5, 3 },
        { "sweeps without tiles", "dimmer", 2, 0.0f, 0, 5, 3 },
    };
    for ( size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k )
    {
        Stage stage;
        RfRenderSettings settings = reuse_mode( cases[k].mode );
        settings.spp = cases[k].spp;
        open_moving_stage( &stage, cases[k].room, WIDTH, HEIGHT );
        tag_lights( &stage.scene, 2 );
        blur_eyes( stage.eyes, stage.eye_count, cases[k].lens, 2.0f, cases[k].blur_steps );
        if ( cases[k].frames > 1 )
        {
            RfRenderSettings split = settings;
            split.light_paths = RF_LIGHT_PATHS_OFF;
            split.light_groups = "all";
            settings.memory = least_memory( &stage, FRAME, cases[k].frames, &split );
        }
        check( cases[k].what, &stage, cases[k].frames, settings, SUM_AND_PICTURE );
        close_stage( &stage );
    }
}
