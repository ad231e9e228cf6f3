// Caustics that are left out: what the camera sees by mirrors, glass and metals stays, where nothing throws any the picture has the
// same bits, and settings that cannot leave them out are refused. (That the picture is right: reuse/test_estimator_caustics.c.)
#include "support/moving_rooms.h"
#include "support/render_support.h"
#include "support/rooms.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define EYES 3
#define WIDTH 32
#define HEIGHT 24
#define VALUES ( 3 * WIDTH * HEIGHT )
#define CAUSTICS RF_EFFECT_BIT( RF_EFFECT_CAUSTICS )

static RfRenderSettings settings_of( int group, int spp )
{
    RfRenderSettings settings = small_settings( group, spp );
    settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
    assert_true( rf_parse_tile( "3x3", &settings.tile ) );
    return settings;
}

static float most_removed( const KeptPicture* kept )
{
    float most = 0.0f;
    for ( int i = 0; i < VALUES; ++i )
        most = fmaxf( most, fabsf( kept->aov[RF_AOV_REMOVED][i] ) );
    return most;
}

// A lamp that a mirror shows, and all that paths of two vertices find.
static void test_what_is_seen_stays( void** state )
{
    (void)state;
    static KeptPicture whole, left;
    static const MirrorRoom rooms[] = { MIRROR_BY_SIGN, MIRROR_BEHIND_BULB, LAMP_IN_GLASS, SHARP_METAL };
    const int frame = 1;
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    for ( size_t k = 0; k < 2 * sizeof rooms / sizeof rooms[0]; ++k )
    {
        RfScene scene = make_mirror_room( rooms[k / 2] );
        RfRenderSettings settings = settings_of( (int)k % 2, 6 );
        settings.max_depth = 2;
        RfTracer* tracer = make_tracer( &scene );
        settings.aovs = 0;
        render_picture( &( RfShot ){ tracer, eyes, EYES, &frame, 1 }, &settings, &whole );
        rf_destroy_tracer( tracer );
        assert_int_equal( rf_choose_effects( &scene, 0, CAUSTICS, NULL ), RF_OK );
        tracer = make_tracer( &scene );
        settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
        render_picture( &( RfShot ){ tracer, eyes, EYES, &frame, 1 }, &settings, &left );
        assert_true( most_removed( &left ) == 0.0f );
        for ( int i = 0; i < VALUES; ++i )
            assert_true( fabsf( left.rgb[i] - whole.rgb[i] ) <= 1e-5f * fabsf( whole.rgb[i] ) + 1e-6f );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &scene );
    }
}

static double mean_removed( const RfTracer* tracer, const RfEye* eyes, const RfRenderSettings* settings )
{
    static KeptPicture kept;
    const int frame = 1;
    double sum = 0.0;
    render_picture( &( RfShot ){ tracer, eyes, EYES, &frame, 1 }, settings, &kept );
    for ( int i = 0; i < VALUES; ++i )
        sum += (double)kept.aov[RF_AOV_REMOVED][i];
    return sum / VALUES;
}

// What is taken out is spread by the pixel filter like the picture: about as much of it.
static void test_filters_spread_what_is_taken_out( void** state )
{
    (void)state;
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    RfScene scene = make_mirror_room( FLAT_MIRROR );
    assert_int_equal( rf_choose_effects( &scene, 0, CAUSTICS, NULL ), RF_OK );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = settings_of( 1, 48 );
    double plain = mean_removed( tracer, eyes, &settings );
    settings.filter = RF_FILTER_BLACKMAN_HARRIS;
    double filtered = mean_removed( tracer, eyes, &settings );
    if ( !( plain > 0.0 && fabs( filtered / plain - 1.0 ) < 0.1 ) )
        fail_msg( "%g and %g", plain, filtered );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Where nothing throws caustics the picture has the same bits.
static void test_nothing_to_leave_out( void** state )
{
    (void)state;
    static KeptPicture whole, left;
    const int frame = 1;
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    for ( int kind = ROOM_DIFFUSE; kind <= ROOM_PHONG; ++kind )
    {
        RfScene scene = make_room( (RoomKind)kind );
        RfRenderSettings settings = settings_of( 1, 6 );
        RfTracer* tracer = make_tracer( &scene );
        settings.aovs = 0;
        render_picture( &( RfShot ){ tracer, eyes, EYES, &frame, 1 }, &settings, &whole );
        rf_destroy_tracer( tracer );
        assert_int_equal( rf_choose_effects( &scene, 0, CAUSTICS, NULL ), RF_OK );
        tracer = make_tracer( &scene );
        settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
        render_picture( &( RfShot ){ tracer, eyes, EYES, &frame, 1 }, &settings, &left );
        assert_memory_equal( whole.rgb, left.rgb, VALUES * sizeof( float ) );
        assert_true( most_removed( &left ) == 0.0f );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &scene );
    }
}

static void expect_refusal( const RfScene* scene, const RfEye* eyes, RfRenderSettings settings, const char* words )
{
    const int frame = 1;
    RfError error = { 0 };
    RfTracer* tracer = make_tracer( scene );
    RfResult result = rf_render( &( RfShot ){ tracer, eyes, EYES, &frame, 1 }, &settings, NULL, NULL, &error );
    rf_destroy_tracer( tracer );
    assert_int_equal( result, words != NULL ? RF_ERROR_USAGE : RF_OK );
    if ( words != NULL && strstr( error.text, words ) == NULL )
        fail_msg( "%s", error.text );
}

static void test_refusals( void** state )
{
    (void)state;
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    RfScene scene = make_mirror_room( FLAT_MIRROR ), diffuse = make_room( ROOM_DIFFUSE );
    expect_refusal( &scene, eyes, settings_of( 0, 3 ), "needs a clamp, or caustics left out" );
    assert_int_equal( rf_choose_effects( &scene, 0, CAUSTICS, NULL ), RF_OK );
    assert_int_equal( rf_choose_effects( &diffuse, 0, CAUSTICS, NULL ), RF_OK );
    RfRenderSettings settings = settings_of( 1, 3 );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    expect_refusal( &scene, eyes, settings, "light paths bring caustics" );
    settings.light_paths = RF_LIGHT_PATHS_AUTO;
    expect_refusal( &scene, eyes, settings, NULL );
    settings.weights = RF_WEIGHTS_EQ15;
    expect_refusal( &scene, eyes, settings, "exact weights" );
    expect_refusal( &diffuse, eyes, settings, NULL );
    settings = settings_of( 0, 3 );
    settings.aovs = 0;
    rf_use_estimator( &settings, rf_find_estimator( "gradient" ) );
    expect_refusal( &scene, eyes, settings, "cannot leave caustics out" );
    rf_destroy_scene( &scene );
    rf_destroy_scene( &diffuse );
}

static void test_what_moves( void** state )
{
    (void)state;
    MovingRoom room = load_moving_room( "mirrors", WIDTH, HEIGHT );
    assert_int_equal( rf_choose_effects( &room.scene, 0, CAUSTICS, NULL ), RF_OK );
    assert_true( room.eye_count >= EYES );
    expect_refusal( &room.scene, room.eyes, settings_of( 1, 3 ), "in which something moves" );
    expect_refusal( &room.scene, room.eyes, settings_of( 0, 3 ), NULL );
    rf_destroy_scene( &room.scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_what_is_seen_stays ),
        cmocka_unit_test( test_filters_spread_what_is_taken_out ),
        cmocka_unit_test( test_nothing_to_leave_out ),
        cmocka_unit_test( test_what_moves ),
        cmocka_unit_test( test_refusals ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
