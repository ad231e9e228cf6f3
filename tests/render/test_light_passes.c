// Passes of the picture: emission, direct, indirect, reflection and transmission add up to it in rooms with all kinds of light and in
// every mode, whichever are asked for, and each has what its name says.
#include "support/moving_rooms.h"
#include "support/render_support.h"
#include "support/rooms.h"

#include "scene/light_groups.h"

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
#define PASSES 5
#define TOLERANCE 1e-5 // of a value and the brightness

typedef struct Split
{
    double rgb[VALUES], pass[PASSES][VALUES];
    bool given[PASSES];
    int layers, frame, previews;
} Split;

enum
{
    EMISSION,
    DIRECT,
    INDIRECT,
    REFLECTION,
    TRANSMISSION
};

static RfResult keep( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    Split* split = user;
    if ( frame->frame != split->frame )
        return RF_OK;
    split->layers = frame->layer_count;
    for ( int i = 0; i < VALUES; ++i )
        split->rgb[i] = (double)frame->rgb[i];
    for ( int p = 0; p < PASSES; ++p )
    {
        const float* values = frame->aovs[RF_AOV_EMISSION + p];
        split->given[p] = values != NULL;
        for ( int i = 0; i < VALUES && values != NULL; ++i )
            split->pass[p][i] = (double)values[i];
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

// The sum of all passes is the picture, which is as without them where `same`; the brightness of each over that of the picture goes
// to `shares`.
static void check( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings settings,
                   bool same, double shares[PASSES] )
{
    static Split whole, split, some;
    static double sum[VALUES];
    render( tracer, eyes, eye_count, &settings, &whole );
    settings.aovs |= RF_PASS_AOVS;
    render( tracer, eyes, eye_count, &settings, &split );
    assert_true( split.previews >= 1 );
    double bright = brightness( split.rgb );
    memset( sum, 0, sizeof sum );
    for ( int p = 0; p < PASSES; ++p )
    {
        assert_true( split.given[p] );
        shares[p] = brightness( split.pass[p] ) / bright;
        for ( int i = 0; i < VALUES; ++i )
            sum[i] += split.pass[p][i];
    }
    expect_equal( what, "the sum of passes", sum, split.rgb, bright );
    if ( same )
        assert_memory_equal( split.rgb, whole.rgb, sizeof whole.rgb );
    settings.aovs &= ~( RF_AOV_BIT( RF_AOV_EMISSION ) | RF_AOV_BIT( RF_AOV_INDIRECT ) | RF_AOV_BIT( RF_AOV_REFLECTION ) );
    render( tracer, eyes, eye_count, &settings, &some );
    assert_false( some.given[INDIRECT] );
    assert_memory_equal( some.pass[DIRECT], split.pass[DIRECT], sizeof some.pass[DIRECT] );
    assert_memory_equal( some.pass[TRANSMISSION], split.pass[TRANSMISSION], sizeof some.pass[DIRECT] );
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
#define MODES ( sizeof g_modes / sizeof g_modes[0] )

static RfRenderSettings settings_of( size_t mode )
{
    RfRenderSettings settings = small_settings( g_modes[mode].group, 5 );
    settings.filter = g_modes[mode].filter;
    settings.filter_width = 0.0;
    assert_true( rf_parse_tile( g_modes[mode].tile, &settings.tile ) );
    return settings;
}

static void expect_shares( const char* what, const double shares[PASSES], const double least[PASSES] )
{
    for ( int p = 0; p < PASSES; ++p )
    {
        bool sound = least[p] > 0.0 ? shares[p] >= least[p] : shares[p] < 1e-5;
        if ( !sound )
            fail_msg( "%s: %s has %g of the light, not %g", what, rf_aov_name( (RfAov)( RF_AOV_EMISSION + p ) ), shares[p],
                      least[p] );
    }
}

// `least`: share of each pass, 0: it is black.
static void check_room( const char* name, RfScene scene, const double least[PASSES] )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &scene );
    for ( size_t k = 0; k < MODES; ++k )
    {
        char what[80];
        double shares[PASSES];
        snprintf( what, sizeof what, "%s, mode %d", name, (int)k );
        // chains are followed for the passes, which single pixels do without
        check( what, tracer, eyes, EYES, settings_of( k ), k % 2 == 1, shares );
        expect_shares( what, shares, least );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void test_rooms_without_chains( void** state )
{
    (void)state;
    check_room( "open", make_open_scene( LIT_BY_ALL ), ( double[] ){ 0.1, 0.3, 0.05, 0, 0 } );
    check_room( "room", make_room( ROOM_GGX ), ( double[] ){ 0, 0.3, 0.2, 0, 0 } );
    check_room( "panes", make_pane_room( PANES_AND_ALL ), ( double[] ){ 0, 0.3, 0.1, 0.1, 0.02 } );
}

static void test_mirrors_and_glass( void** state )
{
    (void)state;
    static const struct
    {
        MirrorRoom kind;
        double least[PASSES];
    } cases[] = {
        { MIRROR_BY_SIGN, { 0, 0.2, 0.15, 0.2, 0 } },
        { FACING_MIRRORS, { 0, 0.2, 0.2, 0.1, 0 } },
        { GLASS_BALL, { 0, 0.15, 0.15, 0.04, 0.15 } },
        { ROUGH_SLAB, { 0, 0.12, 0.12, 0.01, 0.25 } },
        { LAYERED_SLAB, { 0.15, 0.1, 0.07, 0.1, 0.08 } },
        { PANES_IN_A_ROW, { 0, 0.3, 0.2, 0.03, 0 } },
        { LAMP_IN_GLASS, { 0, 0.02, 0.07, 0.005, 0.4 } },
        { SHARP_PLASTIC, { 0, 0.25, 0.2, 0.04, 0 } },
        { CLEAR_COAT, { 0, 0.3, 0.2, 0, 0 } },
        { BLENDED_MIRROR, { 0, 0.2, 0.2, 0.1, 0 } },
    };
    for ( size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k )
    {
        char name[32];
        snprintf( name, sizeof name, "mirror room %d", (int)cases[k].kind );
        check_room( name, make_mirror_room( cases[k].kind ), cases[k].least );
    }
    check_room( "glass under the sky", make_mirror_in_the_open( LIT_BY_ALL ), ( double[] ){ 0.1, 0.2, 0.06, 0.06, 0 } );
}

static void test_moving_rooms( void** state )
{
    (void)state;
    static const char* const rooms[] = { "dimmer", "glow", "blackout", "lamps", "sweep", "mirrors", "panes", "sky" };
    for ( size_t k = 0; k < sizeof rooms / sizeof rooms[0]; ++k )
    {
        MovingRoom room = load_moving_room( rooms[k], WIDTH, HEIGHT );
        RfTracer* tracer = make_tracer( &room.scene );
        for ( size_t mode = 0; mode < MODES; ++mode )
        {
            char what[80];
            double shares[PASSES];
            snprintf( what, sizeof what, "%s, mode %d", rooms[k], (int)mode );
            check( what, tracer, room.eyes, room.eye_count, settings_of( mode ), mode % 2 == 1, shares );
            if ( !( shares[DIRECT] > 0.001 ) )
                fail_msg( "%s: direct has %g of the light", what, shares[DIRECT] );
        }
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

// With a clamp they add up to the picture that it leaves; with extra samples, and beside light groups.
static void test_clamp_extra_samples_and_groups( void** state )
{
    (void)state;
    static const char* const rooms[] = { "dimmer", "mirrors" };
    for ( int k = 0; k < 6; ++k )
    {
        MovingRoom room = load_moving_room( rooms[k % 2], WIDTH, HEIGHT );
        RfTracer* tracer = make_tracer( &room.scene );
        RfRenderSettings settings = settings_of( MODES - 1 );
        double shares[PASSES];
        settings.clamp = k / 2 == 0 ? 0.5 : 0.0;
        settings.adaptive = k / 2 == 1 ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
        settings.light_groups = k / 2 == 2 ? "lamps" : NULL;
        check( rooms[k % 2], tracer, room.eyes, room.eye_count, settings, true, shares );
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
    settings.aovs |= RF_PASS_AOVS;
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
        { "lens", "mirrors", 3, 0.05f, 0, 5, 1 },           { "shutter", "sweep", 3, 0.0f, 4, 5, 1 },
        { "lens and shutter", "panes", 1, 0.05f, 4, 5, 1 }, { "long sums", "dimmer", 2, 0.0f, 0, 70, 1 },
        { "sweeps", "mirrors", 3, 0.0f, 0, 5, 3 },
    };
    for ( size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k )
    {
        MovingRoom room = load_moving_room( cases[k].room, WIDTH, HEIGHT );
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
        double shares[PASSES];
        settings.spp = cases[k].spp;
        s_frames = cases[k].frames;
        if ( s_frames > 1 )
            settings.memory = least_memory( tracer, room.eyes, room.eye_count, settings );
        check( cases[k].what, tracer, room.eyes, room.eye_count, settings, cases[k].mode % 2 == 1, shares );
        s_frames = 1;
        if ( !( shares[DIRECT] > 0.001 ) )
            fail_msg( "%s: direct has %g of the light", cases[k].what, shares[DIRECT] );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

// Direct light needs no further vertices: by the same random numbers it is the same without them, and there is no other then.
static void test_direct_light_is_that_of_depth_two( void** state )
{
    (void)state;
    RfScene scenes[] = { make_open_scene( LIT_BY_ALL ), make_room( ROOM_GGX ), make_mirror_room( GLASS_BALL ) };
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    for ( size_t k = 0; k < 3; ++k )
    {
        static Split deep, shallow;
        RfTracer* tracer = make_tracer( scenes + k );
        for ( size_t mode = 0; mode < MODES; ++mode )
        {
            char what[80];
            snprintf( what, sizeof what, "scene %d, mode %d", (int)k, (int)mode );
            RfRenderSettings settings = settings_of( mode );
            settings.aovs = RF_PASS_AOVS;
            render( tracer, eyes, EYES, &settings, &deep );
            settings.max_depth = 2;
            render( tracer, eyes, EYES, &settings, &shallow );
            double bright = brightness( deep.rgb );
            expect_equal( what, "direct", deep.pass[DIRECT], shallow.pass[DIRECT], bright );
            expect_equal( what, "emission", deep.pass[EMISSION], shallow.pass[EMISSION], bright );
            if ( brightness( shallow.pass[INDIRECT] ) > 1e-6 * bright )
                fail_msg( "%s: indirect light by two vertices: %g", what, brightness( shallow.pass[INDIRECT] ) / bright );
        }
        rf_destroy_tracer( tracer );
        rf_destroy_scene( scenes + k );
    }
}

// With alpha the sky is taken out of the picture, and of emission.
static void test_alpha_takes_the_sky_out_of_emission( void** state )
{
    (void)state;
    static Split with, without;
    RfScene scene = make_open_scene( LIT_BY_MAP );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = settings_of( MODES - 1 );
    settings.aovs = RF_PASS_AOVS;
    render( tracer, eyes, EYES, &settings, &with );
    settings.aovs |= RF_AOV_BIT( RF_AOV_ALPHA );
    render( tracer, eyes, EYES, &settings, &without );
    assert_true( brightness( with.pass[EMISSION] ) > 0.01 * brightness( with.rgb ) );
    assert_true( brightness( without.pass[EMISSION] ) == 0.0 );
    expect_equal( "alpha", "direct", without.pass[DIRECT], with.pass[DIRECT], brightness( with.rgb ) );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void expect_refused( const RfTracer* tracer, const RfRenderSettings* settings, const char* part )
{
    RfEye eyes[EYES];
    RfRenderSettings resolved;
    RfError error = { 0 };
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    assert_int_equal( rf_resolve_settings( &( RfShot ){ tracer, eyes, EYES, NULL, 0 }, settings, &resolved, &error ),
                      RF_ERROR_USAGE );
    if ( strstr( error.text, part ) == NULL )
        fail_msg( "'%s' has no '%s'", error.text, part );
}

static void test_what_cannot_be_split_is_refused( void** state )
{
    (void)state;
    RfScene scene = make_room( ROOM_GGX );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = small_settings( 1, 6 );
    settings.aovs = RF_AOV_BIT( RF_AOV_DIRECT );
    settings.weights = RF_WEIGHTS_UNWEIGHTED;
    expect_refused( tracer, &settings, "the biased weights cannot split light into passes" );
    settings.weights = RF_WEIGHTS_EXACT;
    assert_int_equal( rf_choose_effects( &scene, 0, RF_EFFECT_BIT( RF_EFFECT_CHAINS ), NULL ), RF_OK );
    expect_refused( tracer, &settings, "chains are left out" );
    assert_int_equal( rf_choose_effects( &scene, 0, 0, NULL ), RF_OK );
    rf_use_estimator( &settings, rf_find_estimator( "gradient" ) );
    expect_refused( tracer, &settings, "the estimator 'gradient' has no passes of its light" );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_rooms_without_chains ),
        cmocka_unit_test( test_mirrors_and_glass ),
        cmocka_unit_test( test_moving_rooms ),
        cmocka_unit_test( test_clamp_extra_samples_and_groups ),
        cmocka_unit_test( test_blur_long_sums_and_sweeps ),
        cmocka_unit_test( test_direct_light_is_that_of_depth_two ),
        cmocka_unit_test( test_alpha_takes_the_sky_out_of_emission ),
        cmocka_unit_test( test_what_cannot_be_split_is_refused ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
