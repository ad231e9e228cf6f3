// Passes of the picture: emission, direct, indirect, reflection and transmission add up to it in rooms with all kinds of light and in
// every mode, whichever are asked for, and each has what its name says.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include <stdio.h>

#define EYES 5
#define WIDTH 24
#define HEIGHT 18
#define VALUES ( 3 * WIDTH * HEIGHT )
#define FRAME 2
#define PASSES 5
#define TOLERANCE 1e-5 // of a value and the brightness

enum
{
    EMISSION,
    DIRECT,
    INDIRECT,
    REFLECTION,
    TRANSMISSION
};

static const float* const* passes_of( const RfFrameResult* frame ) { return frame->aovs + RF_AOV_EMISSION; }

static void expect_same_pass( const RfFrameResult* a, const RfFrameResult* b, int pass )
{
    assert_memory_equal( passes_of( a )[pass], passes_of( b )[pass], VALUES * sizeof( float ) );
}

// The sum of all passes is the picture, which is as without them where `same`, but for rounding; the brightness of each over that of the picture goes
// to `shares`.
static void check( const char* what, Stage* stage, int frames, RfRenderSettings settings, bool same, double shares[PASSES] )
{
    const RfFrameResult* whole = render_some( stage, FRAME, frames, &settings );
    settings.aovs |= RF_PASS_AOVS;
    const RfFrameResult* split = render_some( stage, FRAME, frames, &settings );
    assert_true( stage->previews >= 1 );
    double bright = brightness( split->rgb, VALUES );
    for ( int p = 0; p < PASSES; ++p )
    {
        assert_non_null( passes_of( split )[p] );
        shares[p] = brightness( passes_of( split )[p], VALUES ) / bright;
    }
    expect_sum( what, "the sum of passes", passes_of( split ), PASSES, split->rgb, VALUES, TOLERANCE, bright );
    if ( same )
        expect_sum( what, "the picture with passes", ( const float* const[] ){ split->rgb }, 1, whole->rgb, VALUES, TOLERANCE,
                    bright );
    settings.aovs &= ~( RF_AOV_BIT( RF_AOV_EMISSION ) | RF_AOV_BIT( RF_AOV_INDIRECT ) | RF_AOV_BIT( RF_AOV_REFLECTION ) );
    const RfFrameResult* some = render_some( stage, FRAME, frames, &settings );
    assert_null( passes_of( some )[INDIRECT] );
    expect_same_pass( some, split, DIRECT );
    expect_same_pass( some, split, TRANSMISSION );
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
    Stage stage;
    open_stage( &stage, scene, EYES, 3.0f, WIDTH, HEIGHT );
    for ( int mode = 0; mode < REUSE_MODES; ++mode )
    {
        char what[80];
        double shares[PASSES];
        snprintf( what, sizeof what, "%s, mode %d", name, mode );
        // chains are followed for the passes, which single pixels do without
        check( what, &stage, 1, reuse_mode( mode ), mode % 2 == 1, shares );
        expect_shares( what, shares, least );
    }
    close_stage( &stage );
}

TEST( test_rooms_without_chains )
{
    check_room( "open", make_open_scene( LIT_BY_ALL ), ( double[] ){ 0.1, 0.3, 0.05, 0, 0 } );
    check_room( "room", make_room( ROOM_GGX ), ( double[] ){ 0, 0.3, 0.2, 0, 0 } );
    check_room( "panes", make_pane_room( PANES_AND_ALL ), ( double[] ){ 0, 0.3, 0.1, 0.1, 0.02 } );
}

TEST( test_mirrors_and_glass )
{
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

TEST( test_moving_rooms )
{
    static const char* const rooms[] = { "dimmer", "glow", "blackout", "lamps", "sweep", "mirrors", "panes", "sky" };
    for ( size_t k = 0; k < sizeof rooms / sizeof rooms[0]; ++k )
    {
        Stage stage;
        open_moving_stage( &stage, rooms[k], WIDTH, HEIGHT );
        for ( int mode = 0; mode < REUSE_MODES; ++mode )
        {
            char what[80];
            double shares[PASSES];
            snprintf( what, sizeof what, "%s, mode %d", rooms[k], mode );
            check( what, &stage, 1, reuse_mode( mode ), mode % 2 == 1, shares );
            if ( !( shares[DIRECT] > 0.001 ) )
                fail_msg( "%s: direct has %g of the light", what, shares[DIRECT] );
        }
        close_stage( &stage );
    }
}

// With a clamp they add up to the picture that it leaves; with extra samples, and beside light groups.
TEST( test_clamp_extra_samples_and_groups )
{
    static const char* const rooms[] = { "dimmer", "mirrors" };
    for ( int k = 0; k < 6; ++k )
    {
        Stage stage;
        RfRenderSettings settings = reuse_mode( REUSE_MODES - 1 );
        double shares[PASSES];
        open_moving_stage( &stage, rooms[k % 2], WIDTH, HEIGHT );
        settings.clamp = k / 2 == 0 ? 0.5 : 0.0;
        settings.adaptive = k / 2 == 1 ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
        settings.light_groups = k / 2 == 2 ? "lamps" : NULL;
        check( rooms[k % 2], &stage, 1, settings, true, shares );
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
        { "lens", "mirrors", 3, 0.05f, 0, 5, 1 },           { "shutter", "sweep", 3, 0.0f, 4, 5, 1 },
        { "lens and shutter", "panes", 1, 0.05f, 4, 5, 1 }, { "long sums", "dimmer", 2, 0.0f, 0, 70, 1 },
        { "sweeps", "mirrors", 3, 0.0f, 0, 5, 3 },
    };
    for ( size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k )
    {
        Stage stage;
        RfRenderSettings settings = reuse_mode( cases[k].mode );
        double shares[PASSES];
        settings.spp = cases[k].spp;
        open_moving_stage( &stage, cases[k].room, WIDTH, HEIGHT );
        blur_eyes( stage.eyes, stage.eye_count, cases[k].lens, 2.0f, cases[k].blur_steps );
        if ( cases[k].frames > 1 )
        {
            RfRenderSettings split = settings;
            split.aovs |= RF_PASS_AOVS;
            settings.memory = least_memory( &stage, FRAME, cases[k].frames, &split );
        }
        check( cases[k].what, &stage, cases[k].frames, settings, cases[k].mode % 2 == 1, shares );
        if ( !( shares[DIRECT] > 0.001 ) )
            fail_msg( "%s: direct has %g of the light", cases[k].what, shares[DIRECT] );
        close_stage( &stage );
    }
}

// Direct light needs no further vertices: by the same random numbers it is the same without them, and there is no other then.
TEST( test_direct_light_is_that_of_depth_two )
{
    RfScene scenes[] = { make_open_scene( LIT_BY_ALL ), make_room( ROOM_GGX ), make_mirror_room( GLASS_BALL ) };
    for ( int k = 0; k < 3; ++k )
    {
        Stage stage;
        open_stage( &stage, scenes[k], EYES, 3.0f, WIDTH, HEIGHT );
        for ( int mode = 0; mode < REUSE_MODES; ++mode )
        {
            char what[80];
            snprintf( what, sizeof what, "scene %d, mode %d", k, mode );
            RfRenderSettings settings = reuse_mode( mode );
            settings.aovs = RF_PASS_AOVS;
            const RfFrameResult* deep = render_one( &stage, FRAME, &settings );
            settings.max_depth = 2;
            const RfFrameResult* shallow = render_one( &stage, FRAME, &settings );
            double bright = brightness( deep->rgb, VALUES );
            double indirect = brightness( passes_of( shallow )[INDIRECT], VALUES );
            expect_sum( what, "direct", passes_of( deep ) + DIRECT, 1, passes_of( shallow )[DIRECT], VALUES, TOLERANCE, bright );
            expect_sum( what, "emission", passes_of( deep ), 1, passes_of( shallow )[EMISSION], VALUES, TOLERANCE, bright );
            if ( indirect > 1e-6 * bright )
                fail_msg( "%s: indirect light by two vertices: %g", what, indirect / bright );
        }
        close_stage( &stage );
    }
}

// With alpha the sky is taken out of the picture, and of emission.
TEST( test_alpha_takes_the_sky_out_of_emission )
{
    Stage stage;
    open_stage( &stage, make_open_scene( LIT_BY_MAP ), EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = reuse_mode( REUSE_MODES - 1 );
    settings.aovs = RF_PASS_AOVS;
    const RfFrameResult* with = render_one( &stage, FRAME, &settings );
    settings.aovs |= RF_AOV_BIT( RF_AOV_ALPHA );
    const RfFrameResult* without = render_one( &stage, FRAME, &settings );
    double bright = brightness( with->rgb, VALUES );
    assert_true( brightness( passes_of( with )[EMISSION], VALUES ) > 0.01 * bright );
    assert_true( brightness( passes_of( without )[EMISSION], VALUES ) == 0.0 );
    expect_sum( "alpha", "direct", passes_of( without ) + DIRECT, 1, passes_of( with )[DIRECT], VALUES, TOLERANCE, bright );
    close_stage( &stage );
}

TEST( test_what_cannot_be_split_is_refused )
{
    Stage stage;
    open_stage( &stage, make_room( ROOM_GGX ), EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = small_settings( 1, 6 );
    settings.aovs = RF_AOV_BIT( RF_AOV_DIRECT );
    settings.weights = RF_WEIGHTS_UNWEIGHTED;
    expect_refused( &stage, &settings, "the biased weights cannot split light into passes" );
    settings.weights = RF_WEIGHTS_EXACT;
    assert_int_equal( rf_choose_effects( &stage.scene, 0, RF_EFFECT_BIT( RF_EFFECT_CHAINS ), NULL ), RF_OK );
    expect_refused( &stage, &settings, "chains are left out" );
    assert_int_equal( rf_choose_effects( &stage.scene, 0, 0, NULL ), RF_OK );
    rf_use_estimator( &settings, rf_find_estimator( "gradient" ) );
    expect_refused( &stage, &settings, "the estimator 'gradient' has no passes of its light" );
    close_stage( &stage );
}
