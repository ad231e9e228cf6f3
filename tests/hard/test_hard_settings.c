// Settings at and beyond their limits, and renders stopped by their callbacks.
#include "support/render_support.h"
#include "support/test.h"

#include <limits.h>

#define EYES 5
#define WIDTH 24
#define HEIGHT 18

typedef struct Setup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[EYES];
} Setup;

static void begin( Setup* s, RoomKind kind )
{
    s->scene = make_room( kind );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, EYES, 3.0f, WIDTH, HEIGHT );
}

static void end( Setup* s )
{
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

TEST( test_settings_at_their_limits )
{
    for ( int kind = ROOM_DIFFUSE; kind <= ROOM_GGX; ++kind )
    {
        Setup s;
        begin( &s, (RoomKind)kind );
        for ( int group = 0; group <= 2; ++group )
        {
            RfRenderSettings settings = small_settings( group, 1 );
            check_sane_settings( "1 sample", s.tracer, s.eyes, EYES, &settings );
            settings.max_depth = 1;
            assert_true( check_sane_settings( "depth 1", s.tracer, s.eyes, EYES, &settings ) == 0.0 ); // no light in view
            settings.max_depth = 2;
            settings.light_samples = RF_MAX_LIGHT_SAMPLES;
            assert_true( check_sane_settings( "64 light samples", s.tracer, s.eyes, EYES, &settings ) > 0.0 );
            settings = small_settings( group, 2 );
            settings.max_depth = RF_MAX_DEPTH;
            settings.seed = UINT64_MAX;
            settings.threads = 7;
            check_sane_settings( "deep", s.tracer, s.eyes, EYES, &settings );
        }
        RfRenderSettings settings = small_settings( RF_MAX_GROUP, 3 );
        check_sane_settings( "group beyond the path", s.tracer, s.eyes, EYES, &settings );
        check_sane_settings( "one frame", s.tracer, s.eyes, 1, &settings );
        settings.group = RF_GROUP_AUTO;
        check_sane_settings( "auto", s.tracer, s.eyes, EYES, &settings );
        end( &s );
    }
}

// Paths that end at the first hit look up no direction, in which models of several layers would have to be anything.
TEST( test_depth_1_of_layers )
{
    for ( int layers = 0; layers < 4; ++layers )
    {
        Setup s = { .scene = make_room( ROOM_GGX ) };
        orbit_eyes( s.eyes, EYES, 3.0f, WIDTH, HEIGHT );
        for ( uint32_t i = 0; i < s.scene.material_count; ++i )
        {
            RfMaterial* m = s.scene.materials + i;
            if ( m->kind != RF_BSDF_GGX )
                continue;
            m->film = layers & 1 ? 1.0f : 0.0f;
            m->film_ior = 1.5f;
            m->film_thickness = 400.0f;
            m->anisotropy = layers & 2 ? 0.8f : 0.0f;
            m->stretch_x = 1.0f;
            rf_choose_layers( m );
        }
        s.tracer = make_tracer( &s.scene );
        RfRenderSettings settings = small_settings( 1, 3 );
        settings.max_depth = 1;
        assert_true( check_sane_settings( "layers at depth 1", s.tracer, s.eyes, EYES, &settings ) == 0.0 );
        end( &s );
    }
}

static RfResult render_one( const Setup* s, const RfEye* eyes, int eye_count, int frame, const RfRenderSettings* settings,
                            RfError* error )
{
    error->text[0] = 0;
    return rf_render( &( RfShot ){ s->tracer, eyes, eye_count, &frame, 1 }, settings, NULL, NULL, error );
}

static void refuse( const Setup* s, const RfRenderSettings* settings )
{
    RfError error;
    assert_int_equal( render_one( s, s->eyes, EYES, 0, settings, &error ), RF_ERROR_USAGE );
    assert_true( error.code == RF_ERROR_USAGE && error.text[0] != 0 );
    assert_int_equal( rf_render( &( RfShot ){ s->tracer, s->eyes, EYES, &( int ){ 0 }, 1 }, settings, NULL, NULL, NULL ),
                      RF_ERROR_USAGE );
}

// Rounded to what groups need, but not beyond the most: what is resolved can be resolved again.
TEST( test_most_samples_resolve_to_themselves )
{
    AUTO_SCENE scene = make_room( ROOM_DIFFUSE );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[20];
    orbit_eyes( eyes, 20, 1.0f, 4, 3 );
    RfRenderSettings settings = small_settings( 3, RF_MAX_SPP ), once, twice;
    RfError error;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ tracer, eyes, 20, NULL, 0 }, &settings, &once, &error ), RF_OK );
    assert_int_equal( once.spp, RF_MAX_SPP / 7 * 7 );
    assert_int_equal( rf_resolve_settings( &( RfShot ){ tracer, eyes, 20, NULL, 0 }, &once, &twice, &error ), RF_OK );
    assert_int_equal( twice.spp, once.spp );
}

TEST( test_settings_out_of_range )
{
    static const int bad_spp[] = { 0, -1, RF_MAX_SPP + 1, INT_MIN, INT_MAX };
    static const int bad_group[] = { -2, RF_MAX_GROUP + 1, INT_MIN, INT_MAX };
    static const int bad_depth[] = { 0, -1, RF_MAX_DEPTH + 1, INT_MAX };
    static const int bad_samples[] = { 0, -1, RF_MAX_LIGHT_SAMPLES + 1, INT_MAX };
    Setup s;
    begin( &s, ROOM_DIFFUSE );
    for ( int k = 0; k < 4; ++k )
    {
        RfRenderSettings settings = small_settings( 1, bad_spp[k] );
        refuse( &s, &settings );
        settings = small_settings( bad_group[k], 1 );
        refuse( &s, &settings );
        settings = small_settings( 1, 1 );
        settings.max_depth = bad_depth[k];
        refuse( &s, &settings );
        settings = small_settings( 1, 1 );
        settings.light_samples = bad_samples[k];
        refuse( &s, &settings );
    }
    end( &s );
}

TEST( test_eyes_and_frames_out_of_range )
{
    static const int bad_sizes[][2] = { { 0, 10 }, { 10, 0 }, { -1, 10 }, { RF_MAX_IMAGE_SIDE + 1, 1 }, { 1, INT_MAX } };
    Setup s;
    RfError error;
    begin( &s, ROOM_DIFFUSE );
    RfRenderSettings settings = small_settings( 1, 1 );
    for ( int k = 0; k < 5; ++k )
    {
        RfEye eye = s.eyes[0];
        eye.width = bad_sizes[k][0];
        eye.height = bad_sizes[k][1];
        assert_int_equal( render_one( &s, &eye, 1, 0, &settings, &error ), RF_ERROR_USAGE );
    }
    assert_int_equal( render_one( &s, s.eyes, 0, 0, &settings, &error ), RF_ERROR_USAGE );
    assert_int_equal( render_one( &s, s.eyes, EYES, EYES, &settings, &error ), RF_ERROR_USAGE );
    assert_int_equal( render_one( &s, s.eyes, EYES, -1, &settings, &error ), RF_ERROR_USAGE );
    int disordered[] = { 2, 1 }, twice[] = { 1, 1 };
    assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, disordered, 2 }, &settings, NULL, NULL, &error ),
                      RF_ERROR_USAGE );
    assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, twice, 2 }, &settings, NULL, NULL, &error ),
                      RF_ERROR_USAGE );
    assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, twice, 0 }, &settings, NULL, NULL, &error ),
                      RF_ERROR_USAGE );
    s.eyes[3].width += 1;
    assert_int_equal( render_one( &s, s.eyes, EYES, 0, &settings, &error ), RF_ERROR_USAGE );
    end( &s );
}

TEST( test_too_little_memory )
{
    Setup s;
    RfError error;
    begin( &s, ROOM_GGX );
    RfRenderSettings settings = small_settings( 2, 3 );
    AUTO_BY( free_rendered ) Rendered whole = render_all( s.tracer, s.eyes, EYES, &settings );
    size_t needed = whole.stats.peak_bytes;
    int failures = 0;
    for ( size_t memory = 1; memory <= needed; memory = memory * 3 / 2 + 1 )
    {
        settings.memory = memory; // fails at every step of the allocations once
        RfRenderStats stats;
        int frame = 0;
        RfResult result = rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, &frame, 1 }, &settings, NULL, &stats, &error );
        assert_true( result == RF_OK || result == RF_ERROR_MEMORY );
        assert_true( stats.peak_bytes <= memory );
        failures += result != RF_OK;
    }
    assert_true( failures > 10 );
    end( &s );
}

// Stops at the frame, or the progress report, of this number.
typedef struct Stopper
{
    int at, seen;
} Stopper;

static RfResult stop_at_frame( void* user, const RfFrameResult* result, RfError* error )
{
    Stopper* s = user;
    assert_int_equal( result->frame, s->seen );
    return s->seen++ == s->at ? rf_fail( error, RF_ERROR_IO, "disk full" ) : RF_OK;
}

static bool stop_at_progress( void* user, const RfProgress* progress )
{
    Stopper* s = user;
    assert_true( progress->share > 0.0 && progress->share <= 1.0 + 1e-9 && progress->samples > 0.0 );
    return s->seen++ != s->at;
}

TEST( test_callbacks_stop_the_render )
{
    static const int all[EYES] = { 0, 1, 2, 3, 4 };
    Setup s;
    RfError error;
    begin( &s, ROOM_GGX );
    for ( int group = 0; group <= 2; ++group )
    {
        RfRenderSettings settings = small_settings( group, 5 );
        for ( int at = 0; at < EYES; at += 2 )
        {
            Stopper stopper = { at, 0 };
            RfRenderCallbacks callbacks = { .user = &stopper, .frame = stop_at_frame };
            assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, all, EYES }, &settings, &callbacks, NULL, &error ),
                              RF_ERROR_IO );
            assert_string_equal( error.text, "disk full" );
            assert_int_equal( stopper.seen, at + 1 ); // none after it
            stopper.seen = 0;
            callbacks = ( RfRenderCallbacks ){ .user = &stopper, .progress = stop_at_progress };
            assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, all, EYES }, &settings, &callbacks, NULL, &error ),
                              RF_ERROR_INTERRUPTED );
            assert_int_equal( stopper.seen, at + 1 );
        }
        Stopper never = { -1, 0 };
        RfRenderCallbacks callbacks = { .user = &never, .progress = stop_at_progress };
        assert_int_equal( rf_render( &( RfShot ){ s.tracer, s.eyes, EYES, all, EYES }, &settings, &callbacks, NULL, &error ),
                          RF_OK );
    }
    end( &s );
}
