// Light groups: the pictures of all groups add up to the picture, which is what it is without them, in every mode and in rooms with
// all kinds of light; each is the picture under the lights of its group alone, by the same random numbers.
#include "support/moving_rooms.h"
#include "support/render_support.h"
#include "support/rooms.h"

#include "scene/light_groups.h"
#include "trace/relit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define EYES 5
#define WIDTH 24
#define HEIGHT 18
#define VALUES ( 3 * WIDTH * HEIGHT )
#define FRAME 2
#define TOLERANCE 1e-5 // of a value and the brightness

typedef struct Split
{
    int frame, groups, previews;
    double rgb[VALUES], group[RF_LIGHT_GROUPS_MOST][VALUES];
    char names[RF_LIGHT_GROUPS_MOST][16];
} Split;

static RfResult keep( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    Split* split = user;
    if ( frame->frame != split->frame )
        return RF_OK;
    split->groups = frame->layer_count;
    for ( int i = 0; i < VALUES; ++i )
        split->rgb[i] = (double)frame->rgb[i];
    for ( int g = 0; g < split->groups; ++g )
    {
        snprintf( split->names[g], sizeof split->names[g], "%s", frame->layers[g].name );
        assert_string_equal( frame->layers[g].letters, "RGB" );
        for ( int i = 0; i < VALUES; ++i )
            split->group[g][i] = (double)frame->layers[g].values[i];
    }
    return RF_OK;
}

static void show( void* user, const RfPreview* preview )
{
    Split* split = user;
    split->previews += preview->frame == split->frame && preview->rgb != NULL;
}

static const int g_frames[] = { FRAME, FRAME + 1, FRAME + 2 };
static int s_frames = 1; // that are rendered, of which the first is looked at

static void render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings, Split* split )
{
    RfRenderCallbacks callbacks = { .user = split, .frame = keep, .preview = show };
    RfError error = { 0 };
    memset( split, 0, sizeof *split );
    split->frame = eye_count > FRAME ? FRAME : 0;
    const int* frames = split->frame == FRAME ? g_frames : &split->frame;
    if ( rf_render( &( RfShot ){ tracer, eyes, eye_count, frames, s_frames }, settings, &callbacks, NULL, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

static double brightness( const double* values )
{
    double sum = 0.0;
    for ( int i = 0; i < VALUES; ++i )
        sum += fabs( values[i] );
    return sum / VALUES;
}

static void expect_equal( const char* what, const char* of, const double* got, const double* wanted, double bright )
{
    for ( int i = 0; i < VALUES; ++i )
    {
        if ( !( fabs( got[i] - wanted[i] ) <= TOLERANCE * ( fabs( wanted[i] ) + bright ) ) )
            fail_msg( "%s: value %d of %s is %.9g, not %.9g", what, i, of, got[i], wanted[i] );
    }
}

// What shines gets a tag in turn; every `tags` + 1-th thing gets none.
static void tag( RfScene* scene, int tags )
{
    static const char* const names[] = { "key", "fill", "back", "lamp 4", "lamp 5", "lamp 6", "lamp 7", "lamp 8" };
    int n = 0;
    uint16_t tag_of[9] = { 0 };
    for ( int k = 0; k < tags; ++k )
        assert_true( rf_tag_light( scene, names[k], tag_of + k ) );
    for ( int i = 0; i < scene->punctual_count; ++i )
        scene->punctuals[i].light_group = tag_of[n++ % ( tags + 1 )];
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        RfMaterial* m = scene->materials + i;
        if ( rf_max_component( m->emission ) > 0.0f || m->dims )
            m->light_group = tag_of[n++ % ( tags + 1 )];
    }
    scene->environment.light_group = tag_of[n++ % ( tags + 1 )];
}

static void add_lamp( RfScene* scene, RfPunctual lamp )
{
    scene->punctuals = realloc( scene->punctuals, ( (size_t)scene->punctual_count + 1 ) * sizeof *scene->punctuals );
    assert_non_null( scene->punctuals );
    scene->punctuals[scene->punctual_count++] = lamp;
}

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
static void check_alone( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings settings,
                         const Split* split )
{
    static Split alone;
    RfLightGroups groups;
    const RfScene* scene = rf_tracer_scene( tracer );
    assert_int_equal( rf_find_light_groups( scene, "all", &groups, NULL ), RF_OK );
    settings.light_groups = NULL;
    Lit lit = { .scene = scene, .lights = rf_tracer_lights( tracer ), .groups = &groups };
    for ( ; lit.group < split->groups; ++lit.group )
    {
        RfRelitTracer* relit;
        assert_int_equal( rf_create_relit_tracer( tracer, is_lit, &lit, &relit, NULL ), RF_OK );
        render( rf_relit_tracer( relit ), eyes, eye_count, &settings, &alone );
        rf_destroy_relit_tracer( relit );
        expect_equal( what, split->names[lit.group], split->group[lit.group], alone.rgb, brightness( split->rgb ) );
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
static int check( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings settings,
                  Compared compared )
{
    static Split whole, split;
    static double sum[VALUES];
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    render( tracer, eyes, eye_count, &settings, &whole );
    assert_int_equal( whole.groups, 0 );
    settings.light_groups = "all";
    render( tracer, eyes, eye_count, &settings, &split );
    assert_true( split.previews >= 1 );
    double bright = brightness( whole.rgb );
    int shining = 0;
    memset( sum, 0, sizeof sum );
    for ( int g = 0; g < split.groups; ++g )
    {
        shining += brightness( split.group[g] ) > 1e-3 * bright;
        for ( int i = 0; i < VALUES; ++i )
            sum[i] += split.group[g][i];
    }
    expect_equal( what, "the sum of groups", sum, split.rgb, bright );
    if ( compared != SUM )
        expect_equal( what, "the picture", split.rgb, whole.rgb, bright );
    if ( compared == ALL )
        check_alone( what, tracer, eyes, eye_count, settings, &split );
    return shining;
}

static const struct
{
    int group;
    const char* tile;
    RfFilter filter;
} g_modes[] = {
    { 0, "1", RF_FILTER_BOX },
    { 0, "3x3", RF_FILTER_BLACKMAN_HARRIS },
    { 2, "1", RF_FILTER_BLACKMAN_HARRIS },
    { 2, "3x3", RF_FILTER_BOX },
};

static RfRenderSettings settings_of( size_t mode )
{
    RfRenderSettings settings = small_settings( g_modes[mode].group, 5 );
    settings.filter = g_modes[mode].filter;
    settings.filter_width = 0.0;
    assert_true( rf_parse_tile( g_modes[mode].tile, &settings.tile ) );
    return settings;
}

#define MODES ( sizeof g_modes / sizeof g_modes[0] )

// One line of error for what cannot split light; light paths are off where nobody asks for them.
static void test_refusals( void** state )
{
    (void)state;
    RfEye eyes[1];
    RfScene scene = make_mirror_room( GLASS_BALL );
    orbit_eyes( eyes, 1, 3.0f, WIDTH, HEIGHT );
    tag( &scene, 1 );
    RfTracer* tracer = make_tracer( &scene );
    for ( int k = 0; k < 5; ++k )
    {
        RfRenderSettings settings = settings_of( 0 ), resolved;
        RfError error = { 0 };
        settings.light_groups = "all";
        static const char* const texts[] = { "light paths cannot split light by groups", "the biased weights cannot split light",
                                             "the estimator 'gradient' cannot split light", "caustics cannot be left out", NULL };
        settings.light_paths = k == 0 ? RF_LIGHT_PATHS_ON : k == 4 ? RF_LIGHT_PATHS_AUTO : RF_LIGHT_PATHS_OFF;
        settings.weights = k == 1 ? RF_WEIGHTS_EQ15 : RF_WEIGHTS_EXACT;
        settings.estimator = k == 2 ? rf_find_estimator( "gradient" ) : settings.estimator;
        scene.effects_left_out = k == 3 ? RF_EFFECT_BIT( RF_EFFECT_CAUSTICS ) : 0;
        RfResult result = rf_resolve_settings( &( RfShot ){ tracer, eyes, 1, NULL, 1 }, &settings, &resolved, &error );
        assert_int_equal( result, texts[k] != NULL ? RF_ERROR_USAGE : RF_OK );
        if ( texts[k] != NULL && strstr( error.text, texts[k] ) == NULL )
            fail_msg( "'%s' is no '%s'", error.text, texts[k] );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void check_room( const char* name, RfScene scene, int tags, int shining, Compared compared )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    tag( &scene, tags );
    RfTracer* tracer = make_tracer( &scene );
    for ( size_t k = 0; k < MODES; ++k )
    {
        char what[80];
        snprintf( what, sizeof what, "%s, mode %d", name, (int)k );
        int count = check( what, tracer, eyes, EYES, settings_of( k ), k == 0 ? ALL : compared );
        if ( count < shining )
            fail_msg( "%s: %d groups shine", what, count );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void test_still_rooms( void** state )
{
    (void)state;
    check_room( "open", make_open_scene( LIT_BY_ALL ), 3, 4, ALL );
    check_room( "sky", make_open_scene( LIT_BY_MAP ), 1, 1, ALL );
    check_room( "panes", make_pane_room( PANES_AND_ALL ), 2, 3, SUM_AND_PICTURE );
    RfScene room = make_room( ROOM_GGX );
    add_lamp( &room, make_point_light( rf_vec3( 1.0f, 2.0f, 1.0f ), 2.0f ) );
    add_lamp( &room, make_point_light( rf_vec3( -1.0f, 1.0f, 1.0f ), 1.0f ) );
    check_room( "room", room, 2, 3, ALL );
}

static void test_chains( void** state )
{
    (void)state;
    static const MirrorRoom kinds[] = { MIRROR_BY_SIGN, FACING_MIRRORS, GLASS_BALL,         LAYERED_SLAB, LAMP_IN_GLASS,
                                        SHARP_PLASTIC,  CLEAR_COAT,     MIRROR_BEHIND_BULB, GLASS_TANK,   BLENDED_MIRROR };
    for ( size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k )
    {
        char name[32];
        snprintf( name, sizeof name, "mirror room %d", (int)kinds[k] );
        RfScene room = make_mirror_room( kinds[k] );
        add_lamp( &room, make_point_light( rf_vec3( 1.0f, 2.0f, 1.0f ), 2.0f ) );
        check_room( name, room, 2, kinds[k] == GLASS_TANK ? 1 : 2, SUM_AND_PICTURE );
    }
    check_room( "glass under the sky", make_mirror_in_the_open( LIT_BY_ALL ), 3, 4, SUM_AND_PICTURE );
}

static void test_moving_rooms( void** state )
{
    (void)state;
    static const char* const rooms[] = { "dimmer", "glow", "blackout", "lamps", "torch", "seen", "mirrors", "panes", "sky" };
    for ( size_t k = 0; k < sizeof rooms / sizeof rooms[0]; ++k )
    {
        MovingRoom room = load_moving_room( rooms[k], WIDTH, HEIGHT );
        tag( &room.scene, 2 );
        RfTracer* tracer = make_tracer( &room.scene );
        for ( size_t mode = 0; mode < MODES; ++mode )
        {
            char what[80];
            snprintf( what, sizeof what, "%s, mode %d", rooms[k], (int)mode );
            check( what, tracer, room.eyes, room.eye_count, settings_of( mode ), SUM_AND_PICTURE );
        }
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

static void test_clamp_and_extra_samples( void** state )
{
    (void)state;
    static const char* const rooms[] = { "dimmer", "mirrors" };
    for ( int k = 0; k < 4; ++k )
    {
        MovingRoom room = load_moving_room( rooms[k % 2], WIDTH, HEIGHT );
        tag( &room.scene, 1 );
        add_lamp( &room.scene, make_point_light( rf_vec3( 1.0f, 2.0f, 1.0f ), 2.0f ) );
        RfTracer* tracer = make_tracer( &room.scene );
        RfRenderSettings settings = settings_of( MODES - 1 );
        settings.clamp = k < 2 ? 0.5 : 0.0;
        settings.adaptive = k < 2 ? RF_ADAPTIVE_OFF : RF_ADAPTIVE_ON;
        check( rooms[k % 2], tracer, room.eyes, room.eye_count, settings, k < 2 ? SUM : SUM_AND_PICTURE );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

// The least memory, in which each frame has a sweep of its own.
static size_t least_memory( const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings settings )
{
    RfRenderSettings resolved;
    RfMemoryFit fit;
    RfError error = { 0 };
    RfShot shot = { tracer, eyes, eye_count, g_frames, s_frames };
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    settings.light_groups = "all";
    assert_int_equal( rf_resolve_settings( &shot, &settings, &resolved, &error ), RF_OK );
    resolved.memory = 1;
    assert_int_equal( rf_fit_memory( &shot, &resolved, &fit, &error ), RF_ERROR_MEMORY );
    resolved.memory = fit.least;
    assert_int_equal( rf_fit_memory( &shot, &resolved, &fit, &error ), RF_OK );
    assert_int_equal( fit.sweeps, s_frames );
    return resolved.memory;
}

static void test_blur_long_sums_and_sweeps( void** state )
{
    (void)state;
    static const struct
    {
        const char *what, *room;
        size_t mode;
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
        MovingRoom room = load_moving_room( cases[k].room, WIDTH, HEIGHT );
        tag( &room.scene, 2 );
        for ( int i = 0; i < room.eye_count; ++i )
        {
            RfEye *eye = room.eyes + i, open = *eye, close = open;
            close.origin.y += 0.1f;
            if ( cases[k].blur_steps > 0 )
                rf_set_shutter( eye, &open, &close );
            eye->opens = cases[k].blur_steps > 0 ? eye->time - 0.02 : 0.0;
            eye->closes = cases[k].blur_steps > 0 ? eye->time + 0.02 : 0.0;
            eye->blur_steps = cases[k].blur_steps;
            eye->lens_radius = cases[k].lens;
            eye->focus = 2.0f;
        }
        RfTracer* tracer = make_tracer( &room.scene );
        RfRenderSettings settings = settings_of( cases[k].mode );
        settings.spp = cases[k].spp;
        s_frames = cases[k].frames;
        if ( s_frames > 1 )
            settings.memory = least_memory( tracer, room.eyes, room.eye_count, settings );
        check( cases[k].what, tracer, room.eyes, room.eye_count, settings, SUM_AND_PICTURE );
        s_frames = 1;
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_still_rooms ),
        cmocka_unit_test( test_chains ),
        cmocka_unit_test( test_refusals ),
        cmocka_unit_test( test_moving_rooms ),
        cmocka_unit_test( test_clamp_and_extra_samples ),
        cmocka_unit_test( test_blur_long_sums_and_sweeps ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
