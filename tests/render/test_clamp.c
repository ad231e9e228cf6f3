// The clamp (src/reuse/estimators.md, E15): picture and light taken out are together the picture without a clamp, whatever the
// surfaces, the reuse and the filter; what is not to be clamped is not; the automatic threshold is the same for any threads and
// choice of frames, and grows with the samples.
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

#define EYES 5
#define WIDTH 24
#define HEIGHT 18
#define VALUES ( 3 * WIDTH * HEIGHT )

static RfRenderSettings settings_of( int group, const char* tile )
{
    RfRenderSettings settings = small_settings( group, 6 );
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

static double mean( const float* values )
{
    double sum = 0.0;
    for ( int i = 0; i < VALUES; ++i )
        sum += (double)values[i];
    return sum / VALUES;
}

// Renders frame 2 with and without a clamp at this part of its mean. Returns the share of the light that is taken out.
static double check_sum( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings settings,
                         double part )
{
    static KeptPicture whole, clamped;
    int frame = 2;
    RfShot shot = { tracer, eyes, eye_count, &frame, 1 };
    render_picture( &shot, &settings, &whole );
    double brightness = mean( whole.rgb ), removed = 0.0;
    settings.clamp = part * brightness;
    settings.aovs |= RF_AOV_BIT( RF_AOV_REMOVED );
    render_picture( &shot, &settings, &clamped );
    assert_int_equal( clamped.channels[RF_AOV_REMOVED], 3 );
    for ( int i = 0; i < VALUES; ++i )
    {
        double sum = (double)clamped.rgb[i] + (double)clamped.aov[RF_AOV_REMOVED][i], wanted = (double)whole.rgb[i];
        if ( !( fabs( sum - wanted ) <= 2e-6 * ( fabs( wanted ) + brightness ) ) )
            fail_msg( "%s: value %d is %.9g and %.9g taken out, not %.9g", what, i, (double)clamped.rgb[i],
                      (double)clamped.aov[RF_AOV_REMOVED][i], wanted );
        removed += (double)clamped.aov[RF_AOV_REMOVED][i];
    }
    return removed / ( VALUES * brightness );
}

static void check_room( const char* what, RfScene scene, const RfEye* eyes, int eye_count, RfRenderSettings settings )
{
    RfTracer* tracer = make_tracer( &scene );
    double most = check_sum( what, tracer, eyes, eye_count, settings, 0.01 );
    double less = check_sum( what, tracer, eyes, eye_count, settings, 1.0 );
    if ( !( most > 0.02 && less < most && less >= 0.0 ) )
        fail_msg( "%s: shares %g and %g", what, most, less );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void test_picture_and_removed_are_the_whole( void** state )
{
    (void)state;
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    static const struct
    {
        int group;
        const char* tile;
    } reuse[] = { { 0, "1" }, { 0, "3x3" }, { 2, "1" }, { 2, "3x3" }, { 1, "rooks4" } };
    for ( size_t k = 0; k < sizeof reuse / sizeof reuse[0]; ++k )
    {
        RfRenderSettings settings = settings_of( reuse[k].group, reuse[k].tile );
        char what[80];
        snprintf( what, sizeof what, "group %d, tile %s", reuse[k].group, reuse[k].tile );
        check_room( what, make_room( ROOM_DIFFUSE ), eyes, EYES, settings );
        check_room( what, make_room( ROOM_GGX ), eyes, EYES, settings );
        check_room( what, make_pane_room( PANES_AND_ALL ), eyes, EYES, settings );
        check_room( what, make_blended_room(), eyes, EYES, settings );
        check_room( what, make_open_scene( LIT_BY_ALL ), eyes, EYES, settings );
        static const MirrorRoom rooms[] = { FLAT_MIRROR, GLASS_BALL, SMOOTH_PLASTIC, CLEAR_COAT, LAMP_IN_GLASS };
        for ( size_t m = 0; m < sizeof rooms / sizeof rooms[0]; ++m )
            check_room( what, make_mirror_room( rooms[m] ), eyes, EYES, settings );
    }
}

static void test_filters_lenses_light_paths_and_extra_samples( void** state )
{
    (void)state;
    RfEye eyes[EYES], blurred[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = settings_of( 2, "3x3" );
    settings.filter = RF_FILTER_BLACKMAN_HARRIS;
    settings.filter_width = 1.5;
    check_room( "filter", make_mirror_room( GLASS_BALL ), eyes, EYES, settings );
    memcpy( blurred, eyes, sizeof eyes );
    for ( int k = 0; k < EYES; ++k )
    {
        blurred[k].lens_radius = 0.05f;
        blurred[k].focus = 3.0f;
    }
    check_room( "lens", make_room( ROOM_GGX ), blurred, EYES, settings );
    settings = settings_of( 0, "3x3" );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    check_room( "light paths", make_mirror_room( GLASS_BALL ), eyes, EYES, settings );
    settings = settings_of( 1, "3x3" );
    settings.adaptive = RF_ADAPTIVE_ON;
    check_room( "extra samples", make_room( ROOM_GGX ), eyes, EYES, settings );
}

static void test_what_moves( void** state )
{
    (void)state;
    static const char* const names[] = { "sweep", "mirrors", "panes", "figure" };
    for ( size_t k = 0; k < sizeof names / sizeof names[0]; ++k )
    {
        MovingRoom room = load_moving_room( names[k], WIDTH, HEIGHT );
        RfTracer* tracer = make_tracer( &room.scene );
        assert_true( check_sum( names[k], tracer, room.eyes, room.eye_count, settings_of( 1, "3x3" ), 0.01 ) > 0.02 );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

// With a threshold near 0 the rest is what paths of two vertices bring.
static void test_direct_light_stays( void** state )
{
    (void)state;
    static KeptPicture clamped, direct;
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    int frame = 2;
    for ( int group = 0; group < 3; group += 2 )
    {
        RfScene scene = make_room( ROOM_GGX );
        RfTracer* tracer = make_tracer( &scene );
        RfShot shot = { tracer, eyes, EYES, &frame, 1 };
        RfRenderSettings settings = settings_of( group, "3x3" );
        settings.clamp = 1e-20;
        render_picture( &shot, &settings, &clamped );
        settings.clamp = 0.0;
        settings.max_depth = 2;
        render_picture( &shot, &settings, &direct );
        assert_true( mean( direct.rgb ) > 0.0 );
        for ( int i = 0; i < VALUES; ++i )
            assert_true( fabsf( clamped.rgb[i] - direct.rgb[i] ) <= 1e-5f * ( fabsf( direct.rgb[i] ) + 0.01f ) );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &scene );
    }
}

typedef struct Thresholds
{
    int count;
    double clamp[EYES], chains[EYES], removed[EYES];
} Thresholds;

static RfResult note( void* user, const RfFrameResult* result, RfError* error )
{
    (void)error;
    Thresholds* t = user;
    t->clamp[t->count] = result->clamp;
    t->chains[t->count] = result->clamp_chains;
    t->removed[t->count++] = result->removed;
    return RF_OK;
}

static Thresholds find_thresholds( const RfTracer* tracer, const RfEye* eyes, const int* frames, int count,
                                   const RfRenderSettings* settings )
{
    Thresholds found = { 0 };
    RfRenderCallbacks callbacks = { .user = &found, .frame = note };
    RfError error = { 0 };
    RfResult result = rf_render( &( RfShot ){ tracer, eyes, EYES, frames, count }, settings, &callbacks, NULL, &error );
    if ( result != RF_OK )
        fail_msg( "%s", error.text );
    return found;
}

static void test_automatic_threshold( void** state )
{
    (void)state;
    const int all[EYES] = { 0, 1, 2, 3, 4 }, one[1] = { 3 };
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfScene scene = make_mirror_room( GLASS_BALL );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = settings_of( 1, "3x3" );
    settings.clamp = RF_CLAMP_AUTO;
    settings.threads = 1;
    Thresholds first = find_thresholds( tracer, eyes, all, EYES, &settings );
    settings.threads = 3;
    Thresholds alone = find_thresholds( tracer, eyes, one, 1, &settings );
    assert_true( first.clamp[0] > 0.0 && isfinite( first.clamp[0] ) );
    assert_true( alone.clamp[0] == first.clamp[3] && alone.removed[0] == first.removed[3] );
    assert_true( first.removed[3] > 0.0 && first.removed[3] < 0.5 );
    // all frames have one, whatever the seed of the render, and the values that were found give the same picture
    assert_true( first.clamp[0] == first.clamp[4] );
    settings.seed = 7;
    Thresholds other = find_thresholds( tracer, eyes, one, 1, &settings );
    assert_true( other.clamp[0] == alone.clamp[0] && other.removed[0] != alone.removed[0] );
    settings.clamp = alone.clamp[0];
    settings.clamp_chains = alone.chains[0];
    assert_true( find_thresholds( tracer, eyes, one, 1, &settings ).removed[0] == other.removed[0] );
    settings.clamp = RF_CLAMP_AUTO;
    settings.clamp_chains = 0.0;
    double last = 0.0;
    for ( int spp = 3; spp <= 3072; spp *= 32 ) // of a frame that is not rendered to the end
    {
        settings.spp = spp;
        settings.group = 0;
        settings.tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
        settings.max_depth = spp > 100 ? 4 : 12;
        Thresholds found = find_thresholds( tracer, eyes, one, 1, &settings );
        assert_true( found.clamp[0] > last );
        last = found.clamp[0];
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void expect_refusal( const RfTracer* tracer, const RfEye* eyes, const RfRenderSettings* settings, const char* words )
{
    const int frame = 0;
    RfError error = { 0 };
    assert_int_equal( rf_render( &( RfShot ){ tracer, eyes, EYES, &frame, 1 }, settings, NULL, NULL, &error ), RF_ERROR_USAGE );
    if ( strstr( error.text, words ) == NULL )
        fail_msg( "%s", error.text );
}

static void test_refusals( void** state )
{
    (void)state;
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfScene scene = make_room( ROOM_DIFFUSE );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = settings_of( 1, "1" );
    settings.clamp = -2.0;
    expect_refusal( tracer, eyes, &settings, "clamp must be 0 to" );
    settings.clamp = (double)NAN;
    expect_refusal( tracer, eyes, &settings, "clamp must be 0 to" );
    settings.clamp = 0.0;
    settings.clamp_chains = 1.0;
    expect_refusal( tracer, eyes, &settings, "needs a clamp of paths" );
    settings.clamp_chains = 0.0;
    settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
    expect_refusal( tracer, eyes, &settings, "removed needs a clamp" );
    settings.clamp = 1.0;
    settings.weights = RF_WEIGHTS_EQ15;
    expect_refusal( tracer, eyes, &settings, "exact weights: --weights exact, or --clamp off" );
    settings = settings_of( 0, "1" );
    rf_use_estimator( &settings, rf_find_estimator( "gradient" ) );
    settings.clamp = 1.0;
    expect_refusal( tracer, eyes, &settings, "no clamp" );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_picture_and_removed_are_the_whole ),
        cmocka_unit_test( test_filters_lenses_light_paths_and_extra_samples ),
        cmocka_unit_test( test_what_moves ),
        cmocka_unit_test( test_direct_light_stays ),
        cmocka_unit_test( test_automatic_threshold ),
        cmocka_unit_test( test_refusals ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
