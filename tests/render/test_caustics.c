// Caustics that are left out: what the camera sees by mirrors, glass and metals stays, where nothing throws any the picture has the
// same bits, and settings that cannot leave them out are refused. (That the picture is right: reuse/test_estimator_caustics.c.)
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include <math.h>

#define EYES 3
#define WIDTH 32
#define HEIGHT 24
#define VALUES ( 3 * WIDTH * HEIGHT )
#define FRAME 1
#define CAUSTICS RF_EFFECT_BIT( RF_EFFECT_CAUSTICS )

static RfRenderSettings settings_of( int group, int spp )
{
    RfRenderSettings settings = tiled_settings( group, spp, "3x3" );
    settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
    return settings;
}

// Renders a scene with its caustics, then without; takes both over.
static void render_both( Stage stages[2], RfScene with, RfScene without, RfRenderSettings settings, const RfFrameResult* of[2] )
{
    open_stage( stages, with, EYES, 4.0f, WIDTH, HEIGHT );
    open_stage( stages + 1, without, EYES, 4.0f, WIDTH, HEIGHT );
    assert_int_equal( rf_choose_effects( &stages[1].scene, 0, CAUSTICS, NULL ), RF_OK );
    settings.aovs = 0;
    of[0] = render_one( stages, FRAME, &settings );
    settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
    of[1] = render_one( stages + 1, FRAME, &settings );
    assert_true( brightness( of[1]->aovs[RF_AOV_REMOVED], VALUES ) == 0.0 );
}

static void close_both( Stage stages[2] )
{
    close_stage( stages );
    close_stage( stages + 1 );
}

// A lamp that a mirror shows, and all that paths of two vertices find.
TEST( test_what_is_seen_stays )
{
    static const MirrorRoom rooms[] = { MIRROR_BY_SIGN, MIRROR_BEHIND_BULB, LAMP_IN_GLASS, SHARP_METAL };
    for ( size_t k = 0; k < 2 * sizeof rooms / sizeof rooms[0]; ++k )
    {
        Stage stages[2];
        const RfFrameResult* of[2];
        RfRenderSettings settings = settings_of( (int)k % 2, 6 );
        settings.max_depth = 2;
        render_both( stages, make_mirror_room( rooms[k / 2] ), make_mirror_room( rooms[k / 2] ), settings, of );
        for ( int i = 0; i < VALUES; ++i )
            assert_true( fabsf( of[1]->rgb[i] - of[0]->rgb[i] ) <= 1e-5f * fabsf( of[0]->rgb[i] ) + 1e-6f );
        close_both( stages );
    }
}

// What is taken out is spread by the pixel filter like the picture: about as much of it.
TEST( test_filters_spread_what_is_taken_out )
{
    Stage stage;
    open_stage( &stage, make_mirror_room( FLAT_MIRROR ), EYES, 4.0f, WIDTH, HEIGHT );
    assert_int_equal( rf_choose_effects( &stage.scene, 0, CAUSTICS, NULL ), RF_OK );
    RfRenderSettings settings = settings_of( 1, 48 );
    double plain = mean_value( render_one( &stage, FRAME, &settings )->aovs[RF_AOV_REMOVED], VALUES );
    settings.filter = RF_FILTER_BLACKMAN_HARRIS;
    double filtered = mean_value( render_one( &stage, FRAME, &settings )->aovs[RF_AOV_REMOVED], VALUES );
    if ( !( plain > 0.0 && fabs( filtered / plain - 1.0 ) < 0.1 ) )
        fail_msg( "%g and %g", plain, filtered );
    close_stage( &stage );
}

// Where nothing throws caustics the picture has the same bits.
TEST( test_nothing_to_leave_out )
{
    for ( int kind = ROOM_DIFFUSE; kind <= ROOM_PHONG; ++kind )
    {
        Stage stages[2];
        const RfFrameResult* of[2];
        render_both( stages, make_room( (RoomKind)kind ), make_room( (RoomKind)kind ), settings_of( 1, 6 ), of );
        assert_memory_equal( of[0]->rgb, of[1]->rgb, VALUES * sizeof( float ) );
        close_both( stages );
    }
}

TEST( test_refusals )
{
    Stage stage, diffuse;
    open_stage( &stage, make_mirror_room( FLAT_MIRROR ), EYES, 4.0f, WIDTH, HEIGHT );
    open_stage( &diffuse, make_room( ROOM_DIFFUSE ), EYES, 4.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = settings_of( 0, 3 );
    expect_refused( &stage, &settings, "needs a clamp, or caustics left out" );
    assert_int_equal( rf_choose_effects( &stage.scene, 0, CAUSTICS, NULL ), RF_OK );
    assert_int_equal( rf_choose_effects( &diffuse.scene, 0, CAUSTICS, NULL ), RF_OK );
    settings = settings_of( 1, 3 );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    expect_refused( &stage, &settings, "light paths bring caustics" );
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    expect_refused( &stage, &settings, NULL );
    settings.weights = RF_WEIGHTS_EQ15;
    expect_refused( &stage, &settings, "exact weights" );
    expect_refused( &diffuse, &settings, NULL );
    settings = settings_of( 0, 3 );
    settings.aovs = 0;
    rf_use_estimator( &settings, rf_find_estimator( "gradient" ) );
    expect_refused( &stage, &settings, "cannot leave caustics out" );
    close_stage( &stage );
    close_stage( &diffuse );
}

TEST( test_what_moves )
{
    Stage stage;
    open_moving_stage( &stage, "mirrors", WIDTH, HEIGHT );
    assert_int_equal( rf_choose_effects( &stage.scene, 0, CAUSTICS, NULL ), RF_OK );
    assert_true( stage.eye_count >= EYES );
    stage.eye_count = EYES;
    RfRenderSettings settings = settings_of( 1, 3 );
    expect_refused( &stage, &settings, "in which something moves" );
    settings = settings_of( 0, 3 );
    expect_refused( &stage, &settings, NULL );
    close_stage( &stage );
}
