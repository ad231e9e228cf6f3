// Extra samples for pixels that few other frames help: which pixels get them, and that
// nothing else changes the result.
#include "support/cli_run.h"
#include "render/adaptive/adaptive.h"
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"

#include <math.h>
#include <string.h>

#define EYES 9

static Rendered render( const RfTracer* tracer, RfRenderSettings settings, int frame )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, 40, 30 );
    settings.memory = settings.memory > 0 ? settings.memory : (size_t)256 << 20;
    settings.max_depth = 4;
    if ( frame < 0 )
        return render_all( tracer, eyes, EYES, &settings );
    return render_frames( tracer, eyes, EYES, &frame, 1, &settings );
}

static RfRenderSettings adaptive_settings( void )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.group = 2;
    settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    settings.spp = RF_LEAST_GLINT_SPP;
    settings.adaptive = RF_ADAPTIVE_ON;
    return settings;
}

static void check_nothing_else_decides( const RfTracer* tracer, RfRenderSettings settings )
{
    settings.threads = 1;
    Rendered all = render( tracer, settings, -1 );
    settings.threads = 3;
    Rendered one = render( tracer, settings, 3 );
    settings.memory = all.stats.fit.least;
    Rendered tight = render( tracer, settings, -1 );
    if ( settings.adaptive == RF_ADAPTIVE_ON ) // else nothing was tested; auto decides for each frame, by a pilot of its own
        assert_true( all.stats.adaptive_frames > 0 && one.stats.adaptive_frames > 0 );
    assert_memory_equal( frame_rgb( &all, 3 ), frame_rgb( &one, 0 ), 3 * all.pixels * sizeof( float ) );
    assert_memory_equal( frame_rgb( &all, 0 ), frame_rgb( &tight, 0 ), 3 * all.pixels * EYES * sizeof( float ) );
    assert_true( tight.stats.peak_bytes <= tight.stats.budget_bytes );
    free_rendered( &all );
    free_rendered( &one );
    free_rendered( &tight );
}

// A frame is the same whichever others are asked for, and for any threads and memory.
TEST( test_nothing_else_decides )
{
    RfScene scene = make_mirror_room( MIRROR_BALL );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = adaptive_settings();
    check_nothing_else_decides( tracer, settings );
    settings.adaptive = RF_ADAPTIVE_AUTO;
    check_nothing_else_decides( tracer, settings );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// The same of glints, which auto finds in every frame of this room.
TEST( test_nothing_else_decides_glints )
{
    RfScene scene = make_glint_room( RF_BSDF_GGX );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = adaptive_settings();
    settings.adaptive = RF_ADAPTIVE_AUTO;
    Rendered all = render( tracer, settings, -1 );
    assert_int_equal( all.stats.adaptive_frames, EYES );
    double spp = all.native_spp[EYES / 2];
    printf( "%.3f samples for %.3f\n", spp, (double)all.stats.spp );
    assert_true( spp > all.stats.spp * 1.01 && spp < all.stats.spp * 1.1 );
    free_rendered( &all );
    check_nothing_else_decides( tracer, settings );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Renders the middle frame of eyes `degrees` apart; its picture is that of RF_ADAPTIVE_OFF or ON.
static void check_auto( RfScene scene, float degrees, const char* tile, RfAdaptive same_as )
{
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    int frame = EYES / 2;
    orbit_eyes( eyes, EYES, degrees, 80, 60 );
    RfRenderSettings settings = adaptive_settings();
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    settings.group = EYES / 2;
    settings.memory = (size_t)256 << 20;
    settings.max_depth = 4;
    settings.adaptive = same_as;
    Rendered expected = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
    settings.adaptive = RF_ADAPTIVE_AUTO;
    Rendered found = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
    assert_memory_equal( frame_rgb( &found, 0 ), frame_rgb( &expected, 0 ), 3 * found.pixels * sizeof( float ) );
    assert_int_equal( found.stats.adaptive_frames, same_as == RF_ADAPTIVE_ON );
    // the look: a ray for one pixel in nine, as 512 of 4800. Where noise is measured, off does without these rays as well.
    RfSceneTraits traits = rf_scene_traits( &scene, eyes, EYES, &settings );
    double look = (double)found.stats.rays.primary - (double)expected.stats.rays.primary;
    bool measured = same_as == RF_ADAPTIVE_OFF && rf_noise_differs( &traits );
    assert_true( look > 0.07 * (double)found.pixels && ( measured || look < 0.15 * (double)found.pixels ) );
    free_rendered( &expected );
    free_rendered( &found );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Auto renders what on does where extra samples pay, and elsewhere, but for the rays of its look, what off does.
TEST( test_auto_decides_by_frame )
{
    check_auto( make_mirror_room( BUMPY_MIRROR ), 3.0f, "3x3", RF_ADAPTIVE_ON );
    check_auto( make_mirror_room( MIRROR_BALL ), 3.0f, "1", RF_ADAPTIVE_OFF );
    check_auto( make_room( ROOM_DIFFUSE ), 15.0f, "1", RF_ADAPTIVE_ON );
    check_auto( make_room( ROOM_DIFFUSE ), 0.2f, "1", RF_ADAPTIVE_OFF );
    check_auto( make_room( ROOM_DIFFUSE ), 0.2f, "3x3", RF_ADAPTIVE_OFF );
}

// Where extra samples cannot be had, auto is off without a word, and takes no memory.
TEST( test_auto_is_off_where_it_must )
{
    RfScene scene = make_glass_room();
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 15.0f, 40, 30 );
    RfRenderSettings settings = adaptive_settings(), resolved;
    settings.memory = (size_t)256 << 20;
    static const struct
    {
        RfWeights weights;
        int group, eyes;
        RfAdaptive resolved;
    } cases[] = { { RF_WEIGHTS_EXACT, 1, EYES, RF_ADAPTIVE_AUTO },
                  { RF_WEIGHTS_EXACT, 0, EYES, RF_ADAPTIVE_OFF },
                  { RF_WEIGHTS_EXACT, 1, 1, RF_ADAPTIVE_OFF },
                  { RF_WEIGHTS_EQ15, 1, EYES, RF_ADAPTIVE_OFF },
                  { RF_WEIGHTS_UNWEIGHTED, 1, EYES, RF_ADAPTIVE_OFF } };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        settings.adaptive = RF_ADAPTIVE_AUTO;
        settings.weights = cases[i].weights;
        settings.group = cases[i].group;
        RfShot shot = { tracer, eyes, cases[i].eyes, NULL, 1 };
        assert_int_equal( rf_resolve_settings( &shot, &settings, &resolved, NULL ), RF_OK );
        assert_int_equal( resolved.adaptive, cases[i].resolved );
        RfMemoryFit fit, off;
        assert_int_equal( rf_fit_memory( &shot, &resolved, &fit, NULL ), RF_OK );
        resolved.adaptive = RF_ADAPTIVE_OFF;
        assert_int_equal( rf_fit_memory( &shot, &resolved, &off, NULL ), RF_OK );
        size_t more =
            cases[i].resolved == RF_ADAPTIVE_AUTO ? 5 * sizeof( float ) * 40 * 30 : 0; // need, glints, extra, and the mean of B
        size_t noise = more > 0 ? ( scene.material_count + 1 ) * sizeof( RfMaterialNoise ) : 0;
        assert_true( fit.bytes_films >= off.bytes_films + more && fit.bytes_films < off.bytes_films + more + 256 + noise );
        settings.adaptive = RF_ADAPTIVE_ON;
        bool exact = cases[i].weights == RF_WEIGHTS_EXACT;
        assert_int_equal( rf_resolve_settings( &( RfShot ){ tracer, eyes, cases[i].eyes, NULL, 0 }, &settings, &resolved, NULL ),
                          exact ? RF_OK : RF_ERROR_USAGE );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Without other frames there is nothing to make up for.
TEST( test_single_frames_are_as_without )
{
    RfScene scene = make_glass_room();
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = adaptive_settings();
    settings.group = 0;
    Rendered with = render( tracer, settings, -1 );
    settings.adaptive = RF_ADAPTIVE_OFF;
    Rendered without = render( tracer, settings, -1 );
    assert_memory_equal( with.rgb, without.rgb, 3 * with.pixels * EYES * sizeof( float ) );
    assert_true( with.native_spp[2] == RF_LEAST_GLINT_SPP );
    free_rendered( &with );
    free_rendered( &without );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_threshold_follows_the_weights )
{
    enum
    {
        BINS = 64
    };
    double counts[BINS] = { 0 };
    counts[BINS - 1] = 1000.0; // a frame alone: equal samples are best
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 1 ) == 1.0 );
    counts[BINS - 1] = 0.0;
    counts[BINS / 7] = 1000.0; // all of them are helped alike: none gets more
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 7 ) <= (double)BINS / ( BINS / 7 + 1 ) );
    // some are alone: brought to between what they have, 1, and the others, 6.4; where the
    // derivative of error times cost is 0, theta^2 is cost / (cost of an extra sample x error)
    for ( int few = 50; few <= 400; few *= 2 )
    {
        counts[BINS - 1] = few;
        counts[BINS / 7] = 1000.0 - few;
        double theta = rf_extra_threshold( counts, BINS, 1000.0, 7 );
        double error = few / theta + ( 1000.0 - few ) / 6.4, cost = 1300.0 + few * 1.2 * ( theta - 1.0 );
        assert_true( fabs( theta * theta - cost / ( 1.2 * error ) ) < 0.1 * theta * theta );
    }
    counts[BINS - 1] = 2.0; // too few to matter
    counts[BINS / 7] = 998.0;
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 7 ) == 1.0 );
    counts[BINS / 7] = counts[BINS - 1] = 0.0; // nothing but sky
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 7 ) == 1.0 );
}

// Pixels without help whose samples have variance 1, 4 and 16, among others with help.
TEST( test_need_follows_the_noise )
{
    enum
    {
        PIXELS = 1000
    };
    static float share[PIXELS], noise[4 * PIXELS];
    for ( int i = 0; i < PIXELS; ++i )
    {
        share[i] = i < 60 ? 2.0f : 2.0f / 7.0f; // sums of two passes
        noise[4 * i] = noise[4 * i + 1] = 2.0f * ( i < 20 ? 16.0f : i < 40 ? 4.0f : 1.0f );
        noise[4 * i + 2] = noise[4 * i + 3] = 2.0f;
    }
    RfPilotSums sums = { share, noise, NULL, PIXELS, 2.0f, 7, false, 1.0 };
    assert_true( rf_extra_may_pay( &sums ) );
    float most = rf_set_need( &sums );
    printf( "extra samples: %.2f %.2f %.2f %.2f\n", (double)share[0], (double)share[20], (double)share[40], (double)share[999] );
    assert_true( most == share[0] && most <= RF_MOST_EXTRA_NOISY && share[999] == 0.0f );
    assert_true( share[20] > share[40] );
    // samples as the root of the variance
    assert_true( fabsf( ( 1.0f + share[0] ) / ( 1.0f + share[20] ) - 2.0f ) < 0.01f );
    // the same pixels, were they alike
    double counts[7] = { 940.0, 0, 0, 0, 0, 0, 60.0 };
    double theta = rf_extra_threshold( counts, 7, PIXELS, 7 );
    assert_true( (double)share[0] > theta - 1.0 );
}

// Of 1000 pixels the first 300 have no help; all of these are as noisy, and the first 150 cost `cost` times as much. By
// the second measurement their noise is `second`.
static float set_need( float first, float second, float cost, bool wary, float share[1000] )
{
    enum
    {
        PIXELS = 1000
    };
    static float noise[4 * PIXELS];
    for ( int i = 0; i < PIXELS; ++i )
    {
        share[i] = i < 300 ? 2.0f : 2.0f / 7.0f;
        noise[4 * i] = 2.0f * ( i < 300 ? first : 1.0f );
        noise[4 * i + 1] = 2.0f * ( i < 300 ? second : 1.0f );
        noise[4 * i + 2] = 2.0f;
        noise[4 * i + 3] = 2.0f * ( i < 150 ? cost : 1.0f );
    }
    RfPilotSums sums = { share, noise, NULL, PIXELS, 2.0f, 7, wary, 1.0 };
    return rf_set_need( &sums );
}

// Samples that cost more rays are fewer, as the root of their cost.
TEST( test_need_follows_the_cost )
{
    static float share[1000];
    assert_true( set_need( 30.0f, 30.0f, 4.0f, true, share ) > 0.0f );
    printf( "extra samples: %.2f of dear pixels, %.2f of others\n", (double)share[0], (double)share[299] );
    assert_true( share[0] > 0.0f && share[299] < RF_MOST_EXTRA_NOISY && share[999] == 0.0f );
    assert_true( fabsf( ( 1.0f + share[299] ) / ( 1.0f + share[0] ) - 2.0f ) < 0.01f );
}

// What is noisy by both measurements gets extra samples. What one of them finds noisy, by a single bright path, gets none
// with RF_ADAPTIVE_AUTO.
TEST( test_need_wants_two_witnesses )
{
    static float share[1000];
    assert_true( set_need( 8.0f, 8.0f, 4.0f, true, share ) > 0.0f );
    assert_true( set_need( 15.99f, 0.01f, 4.0f, true, share ) == 0.0f );
    assert_true( set_need( 0.01f, 15.99f, 4.0f, true, share ) == 0.0f );
    assert_true( set_need( 0.01f, 15.99f, 4.0f, false, share ) > 0.0f );
}

// Of 1000 pixels, lit as `base`, the first `glints` show a lamp of radiance 100 in a part `share` of them. Returns the extra samples
// of all.
static double set_glints( int glints, float share, float base, float extra[1000] )
{
    enum
    {
        PIXELS = 1000
    };
    static float sums[4 * PIXELS];
    for ( int i = 0; i < PIXELS; ++i )
    {
        sums[4 * i] = i < glints ? 100.0f * share : 0.0f;
        sums[4 * i + 1] = i < glints ? 1e4f * share : 0.0f;
        sums[4 * i + 2] = base;
        sums[4 * i + 3] = 1.0f;
    }
    float most = rf_set_glints( sums, PIXELS, 7.0, 1.0, extra );
    double sum = 0.0;
    for ( int i = 0; i < PIXELS; ++i )
        sum += most > 0.0f ? (double)extra[i] : 0.0;
    assert_true( most == 0.0f || ( most == extra[0] && most <= RF_MOST_GLINTS && extra[999] == 0.0f ) );
    return sum;
}

// Few pixels get what they need, more of them a tenth of the samples, and none where they are no larger part of the error
// than of the picture.
TEST( test_glints_keep_their_budget )
{
    static float extra[1000];
    double one = set_glints( 1, 0.02f, 0.2f, extra ), some = set_glints( 10, 0.02f, 0.2f, extra );
    assert_true( set_glints( 0, 0.0f, 0.0f, extra ) == 0.0 ); // without light
    printf( "extra samples: %.2f for one glint, %.2f for ten\n", one, some );
    assert_true( one > 7.0 && one < some && some > 0.07 * 1000.0 && some < 0.1 * 1000.0 );
    assert_true( set_glints( 1000, 0.02f, 0.2f, extra ) == 0.0 );
    assert_true( set_glints( 10, 0.0f, 0.2f, extra ) == 0.0 );
    assert_true( set_glints( 10, 1.0f, 0.2f, extra ) == 0.0 );  // all of the pixel
    assert_true( set_glints( 10, 1e-3f, 1e3f, extra ) == 0.0 ); // lost in other light
    assert_true( set_glints( 0, 0.0f, 0.0f, extra ) == 0.0 );   // in the dark
}

// Of the classes: glass that few paths find light through is measured to be noisier than walls, and gets more
// samples for it, in a render whose films count them.
TEST( test_noise_is_measured )
{
    RfScene scene = make_glass_room();
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    RfSceneTraits glass = rf_scene_traits( &scene, NULL, 0, &settings );
    assert_true( rf_noise_differs( &glass ) );
    rf_destroy_scene( &scene );
    scene = make_room( ROOM_PHONG );
    RfSceneTraits walls = rf_scene_traits( &scene, NULL, 0, &settings );
    assert_true( !rf_noise_differs( &walls ) );
    rf_destroy_scene( &scene );
}

TEST( test_command_line_takes_it )
{
    cli_enter();
    cli_expect( cli_run( "$R render $VASE -o a.exr --frames 3 --size 24x16 --spp 3 --group 1 --quiet --adaptive --json a.json && "
                         "grep -q '\"adaptive\": *true' a.json && grep -q '\"adaptive_mode\": *\"on\"' a.json" ),
                0, NULL );
    cli_expect( cli_run( "$R render $VASE -o a.exr --resume --frames 3 --size 24x16 --spp 3 --group 1 --quiet" ), 1,
                "--resume: " );
    cli_expect( cli_run( "$R render $VASE -o b.exr --adaptive --weights eq15" ), 2, "--adaptive: needs --weights exact" );
    cli_expect( cli_run( "$R render $VASE -o c.exr --frames 3 --size 24x16 --noise 0.1 --group 2 --quiet --adaptive" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o d.exr --frames 20 --size 24x16 --spp 3 --group 1 --quiet --json d.json && "
                         "grep -q '\"adaptive\": *false' d.json && grep -q '\"adaptive_mode\": *\"auto\"' d.json" ),
                0, NULL );
    // other settings, though the picture is the same
    cli_expect( cli_run( "$R render $VASE -o d.exr --resume --frames 20 --size 24x16 --spp 3 --group 1 --quiet --no-adaptive" ),
                1, "--resume: " );
    cli_expect( cli_run( "$R render $VASE -o d.exr --resume --frames 20 --size 24x16 --spp 3 --group 1 --quiet --adaptive auto" ),
                0, NULL );
    // nothing to settle: auto is off, and goes on with what was rendered without
    cli_expect( cli_run( "$R render $VASE -o e.exr --frames 20 --size 24x16 --spp 3 --group 0 --quiet --no-adaptive && "
                         "$R render $VASE -o e.exr --resume --frames 20 --size 24x16 --spp 3 --group 0 --quiet --json e.json && "
                         "grep -q '\"adaptive_mode\": *\"off\"' e.json" ),
                0, NULL );
    cli_expect( cli_run( "$R render $VASE -o f.exr --frames 3 --size 24x16 --spp 3 --group 1 --quiet --weights eq15" ), 0, NULL );
    cli_leave();
}
