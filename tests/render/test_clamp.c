// The clamp (src/reuse/estimators.md, E15): picture and light taken out are together the picture without a clamp, whatever the
// surfaces, the reuse and the filter; what is not to be clamped is not; the automatic threshold is the same for any threads and
// choice of frames, and grows with the samples.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>

#define EYES 5
#define WIDTH 24
#define HEIGHT 18
#define VALUES ( 3 * WIDTH * HEIGHT )
#define FRAME 2

// Renders a frame with and without a clamp at this part of its mean. Returns the share of the light that is taken out.
static double check_sum( const char* what, Stage* stage, RfRenderSettings settings, double part )
{
    const RfFrameResult* whole = render_one( stage, FRAME, &settings );
    double mean = mean_value( whole->rgb, VALUES );
    settings.clamp = part * mean;
    settings.aovs |= RF_AOV_BIT( RF_AOV_REMOVED );
    const RfFrameResult* clamped = render_one( stage, FRAME, &settings );
    const float* removed = clamped->aovs[RF_AOV_REMOVED];
    assert_non_null( removed );
    const float* both[2] = { clamped->rgb, removed };
    expect_sum( what, "the picture with what is taken out", both, 2, whole->rgb, VALUES, 2e-6, mean );
    return mean_value( removed, VALUES ) / mean;
}

static void check_stage( const char* what, Stage* stage, RfRenderSettings settings )
{
    double most = check_sum( what, stage, settings, 0.01 ), less = check_sum( what, stage, settings, 1.0 );
    if ( !( most > 0.02 && less < most && less >= 0.0 ) )
        fail_msg( "%s: shares %g and %g", what, most, less );
    close_stage( stage );
}

static void check_room( const char* what, RfScene scene, RfRenderSettings settings )
{
    Stage stage;
    open_stage( &stage, scene, EYES, 3.0f, WIDTH, HEIGHT );
    check_stage( what, &stage, settings );
}

TEST( test_picture_and_removed_are_the_whole )
{
    static const struct
    {
        int group;
        const char* tile;
    } reuse[] = { { 0, "1" }, { 0, "3x3" }, { 2, "1" }, { 2, "3x3" }, { 1, "rooks4" } };
    for ( size_t k = 0; k < sizeof reuse / sizeof reuse[0]; ++k )
    {
        RfRenderSettings settings = tiled_settings( reuse[k].group, 6, reuse[k].tile );
        char what[80];
        snprintf( what, sizeof what, "group %d, tile %s", reuse[k].group, reuse[k].tile );
        check_room( what, make_room( ROOM_DIFFUSE ), settings );
        check_room( what, make_room( ROOM_GGX ), settings );
        check_room( what, make_pane_room( PANES_AND_ALL ), settings );
        check_room( what, make_blended_room(), settings );
        check_room( what, make_open_scene( LIT_BY_ALL ), settings );
        static const MirrorRoom rooms[] = { FLAT_MIRROR, GLASS_BALL, SMOOTH_PLASTIC, CLEAR_COAT, LAMP_IN_GLASS };
        for ( size_t m = 0; m < sizeof rooms / sizeof rooms[0]; ++m )
            check_room( what, make_mirror_room( rooms[m] ), settings );
    }
}

TEST( test_filters_lenses_light_paths_and_extra_samples )
{
    Stage blurred;
    RfRenderSettings settings = tiled_settings( 2, 6, "3x3" );
    settings.filter = RF_FILTER_BLACKMAN_HARRIS;
    settings.filter_width = 1.5;
    check_room( "filter", make_mirror_room( GLASS_BALL ), settings );
    open_stage( &blurred, make_room( ROOM_GGX ), EYES, 3.0f, WIDTH, HEIGHT );
    blur_eyes( blurred.eyes, EYES, 0.05f, 3.0f, 0 );
    check_stage( "lens", &blurred, settings );
    settings = tiled_settings( 0, 6, "3x3" );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    check_room( "light paths", make_mirror_room( GLASS_BALL ), settings );
    settings = tiled_settings( 1, 6, "3x3" );
    settings.adaptive = RF_ADAPTIVE_ON;
    check_room( "extra samples", make_room( ROOM_GGX ), settings );
}

TEST( test_what_moves )
{
    static const char* const names[] = { "sweep", "mirrors", "panes", "figure" };
    for ( size_t k = 0; k < sizeof names / sizeof names[0]; ++k )
    {
        Stage stage;
        open_moving_stage( &stage, names[k], WIDTH, HEIGHT );
        assert_true( check_sum( names[k], &stage, tiled_settings( 1, 6, "3x3" ), 0.01 ) > 0.02 );
        close_stage( &stage );
    }
}

// With a threshold near 0 the rest is what paths of two vertices bring.
TEST( test_direct_light_stays )
{
    Stage stage;
    open_stage( &stage, make_room( ROOM_GGX ), EYES, 3.0f, WIDTH, HEIGHT );
    for ( int group = 0; group < 3; group += 2 )
    {
        RfRenderSettings settings = tiled_settings( group, 6, "3x3" );
        settings.clamp = 1e-20;
        const float* clamped = render_one( &stage, FRAME, &settings )->rgb;
        settings.clamp = 0.0;
        settings.max_depth = 2;
        const float* direct = render_one( &stage, FRAME, &settings )->rgb;
        assert_true( mean_value( direct, VALUES ) > 0.0 );
        for ( int i = 0; i < VALUES; ++i )
            assert_true( fabsf( clamped[i] - direct[i] ) <= 1e-5f * ( fabsf( direct[i] ) + 0.01f ) );
    }
    close_stage( &stage );
}

TEST( test_automatic_threshold )
{
    Stage stage;
    open_stage( &stage, make_mirror_room( GLASS_BALL ), EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = tiled_settings( 1, 6, "3x3" );
    settings.clamp = RF_CLAMP_AUTO;
    settings.threads = 1;
    const RfFrameResult* first = render_some( &stage, 0, EYES, &settings );
    settings.threads = 3;
    const RfFrameResult* alone = render_one( &stage, 3, &settings );
    assert_true( first[0].clamp > 0.0 && isfinite( first[0].clamp ) );
    assert_true( alone->clamp == first[3].clamp && alone->removed == first[3].removed );
    assert_true( first[3].removed > 0.0 && first[3].removed < 0.5 );
    // all frames have one, whatever the seed of the render, and the values that were found give the same picture
    assert_true( first[0].clamp == first[4].clamp );
    settings.seed = 7;
    const RfFrameResult* other = render_one( &stage, 3, &settings );
    assert_true( other->clamp == alone->clamp && other->removed != alone->removed );
    settings.clamp = alone->clamp;
    settings.clamp_chains = alone->clamp_chains;
    assert_true( render_one( &stage, 3, &settings )->removed == other->removed );
    settings.clamp = RF_CLAMP_AUTO;
    settings.clamp_chains = 0.0;
    double last = 0.0;
    for ( int spp = 3; spp <= 3072; spp *= 32 ) // of a frame that is not rendered to the end
    {
        settings.spp = spp;
        settings.group = 0;
        settings.tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
        settings.max_depth = spp > 100 ? 4 : 12;
        const RfFrameResult* found = render_one( &stage, 3, &settings );
        assert_true( found->clamp > last );
        last = found->clamp;
    }
    close_stage( &stage );
}

TEST( test_refusals )
{
    Stage stage;
    open_stage( &stage, make_room( ROOM_DIFFUSE ), EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = tiled_settings( 1, 6, "1" );
    settings.clamp = -2.0;
    expect_refused( &stage, &settings, "clamp must be 0 to" );
    settings.clamp = (double)NAN;
    expect_refused( &stage, &settings, "clamp must be 0 to" );
    settings.clamp = 0.0;
    settings.clamp_chains = 1.0;
    expect_refused( &stage, &settings, "needs a clamp of paths" );
    settings.clamp_chains = 0.0;
    settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
    expect_refused( &stage, &settings, "removed needs a clamp" );
    settings.clamp = 1.0;
    settings.weights = RF_WEIGHTS_EQ15;
    expect_refused( &stage, &settings, "exact weights: --weights exact, or --clamp off" );
    settings = tiled_settings( 0, 6, "1" );
    rf_use_estimator( &settings, rf_find_estimator( "gradient" ) );
    settings.clamp = 1.0;
    expect_refused( &stage, &settings, "no clamp" );
    close_stage( &stage );
}
