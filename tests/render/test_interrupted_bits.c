// A render that is interrupted again and again, and each time goes on from the films it kept, has the same bits as one that is
// not: pictures and AOVs, with other threads and another budget in between. So has one that is killed and goes on from films that
// it saved some time before, and one that shows previews.
#include "scene/light_groups.h"
#include "support/render_one.h"
#include "support/rooms.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EYES 9
#define WIDTH 22
#define HEIGHT 15
#define PIXELS ( WIDTH * HEIGHT )

typedef struct Memory
{
    unsigned char* bytes;
    size_t size, room, read;
    bool whole; // saved some time before the end, which is to be as if the process had been killed there
    int done;   // frames that were handed over before
} Memory;

typedef struct Run
{
    RfFrameResult frames[EYES];
    int times[EYES]; // that a frame was handed over
    int done;
    int chunks, most; // until it is interrupted
    int saved;        // chunks before it is saved; −1: when it is interrupted
    Memory state;
    size_t most_bytes; // that it says to take
    int previews, preview_frame;
    double preview_spp;
    Stage stage;
} Run;

static RfResult keep( void* user, const RfFrameResult* f, RfError* error )
{
    (void)error;
    Run* run = user;
    run->frames[f->frame] = hold_result( &run->stage, f );
    run->times[f->frame] += 1;
    run->done += 1;
    return RF_OK;
}

static bool count_chunk( void* user, const RfProgress* progress )
{
    Run* run = user;
    assert_true( progress->share >= 0.0 && progress->share <= 1.0 + 1e-9 );
    return ++run->chunks < run->most;
}

static RfResult save( void* user, const void* bytes, size_t size, RfError* error )
{
    (void)error;
    Memory* m = &( (Run*)user )->state;
    if ( m->whole )
        return RF_OK;
    if ( bytes == NULL )
    {
        m->whole = true;
        m->done = ( (Run*)user )->done;
        return RF_OK;
    }
    if ( m->size + size > m->room )
    {
        m->room = 2 * ( m->size + size );
        m->bytes = realloc( m->bytes, m->room );
        assert_non_null( m->bytes );
    }
    memcpy( m->bytes + m->size, bytes, size );
    m->size += size;
    return RF_OK;
}

static bool saves( void* user, size_t bytes )
{
    Run* run = user;
    run->most_bytes = bytes;
    return run->chunks == run->saved;
}

static RfResult load( void* user, void* bytes, size_t size, RfError* error )
{
    Memory* m = &( (Run*)user )->state;
    if ( m->read + size > m->size )
        return rf_fail( error, RF_ERROR_IO, "too short" );
    memcpy( bytes, m->bytes + m->read, size );
    m->read += size;
    return RF_OK;
}

static void look( void* user, const RfPreview* preview )
{
    Run* run = user;
    run->previews += 1;
    run->preview_frame = preview->frame;
    run->preview_spp = preview->native_spp;
    assert_int_equal( preview->width * preview->height, PIXELS );
    double sum = 0.0;
    for ( int i = 0; i < 3 * PIXELS; ++i )
        sum += (double)preview->rgb[i];
    assert_true( sum > 0.0 && isfinite( sum ) );
}

typedef struct Case
{
    const char* name;
    RfRenderSettings settings;
    RfScene scene;
    bool in_sweeps; // too little memory for the films of a group
} Case;

static void begin( Run* run, RfScene scene )
{
    *run = ( Run ){ .most = 1 << 30 };
    open_stage( &run->stage, scene, EYES, 4.0f, WIDTH, HEIGHT );
    for ( int k = 0; k < EYES; ++k )
        run->stage.eyes[k].time = k / 24.0;
}

static void end( Run* run )
{
    free( run->state.bytes );
    close_stage( &run->stage );
}

static const int s_frames[EYES] = { 0, 1, 2, 3, 4, 5, 6, 7, 8 };

// Of the frames from `first` on that are left.
static RfResult render( Run* run, const RfRenderSettings* settings, int first, bool resumes )
{
    RfRenderCallbacks callbacks = { .user = run, .frame = keep, .progress = count_chunk, .save = save, .saves = saves };
    callbacks.load = resumes ? load : NULL;
    callbacks.preview = run->previews >= 0 ? look : NULL;
    RfError error = { 0 };
    RfShot shot = stage_shot( &run->stage, s_frames + first, EYES - first );
    RfResult result = rf_render( &shot, settings, &callbacks, NULL, &error );
    if ( result != RF_OK && result != RF_ERROR_INTERRUPTED )
        fail_msg( "%s", error.text );
    return result;
}

static void expect_same( const char* name, const Run* whole, const Run* parts )
{
    for ( int f = 0; f < EYES; ++f )
    {
        const RfFrameResult *a = whole->frames + f, *b = parts->frames + f;
        expect_same_bits( a, b );
        if ( a->native_spp != b->native_spp || a->effective_spp != b->effective_spp || parts->times[f] != 1 ||
             memcmp( &a->relmse_estimate, &b->relmse_estimate, sizeof a->relmse_estimate ) != 0 )
            fail_msg( "%s: frame %d differs: spp %g %g times %d", name, f, a->native_spp, b->native_spp, parts->times[f] );
    }
}

// Interrupted after every `chunks` chunks, with one and two threads by turns.
static int interrupt_often( const Case* c, int chunks, Run* run )
{
    int times = 0;
    bool resumes = false;
    for ( ;; ++times )
    {
        RfRenderSettings settings = c->settings;
        settings.threads = 1 + times % 2;
        if ( times % 3 == 1 && !c->in_sweeps )
            settings.memory *= 2;
        run->chunks = 0;
        run->most = chunks;
        run->saved = times % 2 == 0 ? chunks - 1 : -1;
        run->state.whole = false;
        if ( render( run, &settings, run->done, resumes ) == RF_OK )
            break;
        assert_true( run->state.size > 0 );
        if ( resumes )
        {
            // what was read is what an interruption before it wrote; keep what was written now
            memmove( run->state.bytes, run->state.bytes + run->state.read, run->state.size - run->state.read );
            run->state.size -= run->state.read;
        }
        run->state.read = 0;
        for ( ; run->state.whole && run->done > run->state.done; --run->done )
            run->times[run->done - 1] = 0; // finished once more
        assert_true( run->most_bytes == 0 || run->state.size <= run->most_bytes );
        resumes = true;
    }
    return times;
}

static void check_case( Case* c )
{
    Run whole, parts;
    begin( &whole, c->scene );
    assert_int_equal( render( &whole, &c->settings, 0, false ), RF_OK );
    assert_true( whole.previews > 0 );
    begin( &parts, whole.stage.scene );
    parts.previews = -1;
    int chunks = whole.chunks / 5 + 1, times = interrupt_often( c, chunks, &parts );
    if ( times < 3 )
        fail_msg( "%s: interrupted %d times, in %d chunks", c->name, times, whole.chunks );
    expect_same( c->name, &whole, &parts );
    parts.stage.scene = ( RfScene ){ 0 }; // that of the other
    end( &parts );
    end( &whole );
}

#define REMOVED RF_AOV_BIT( RF_AOV_REMOVED )
#define SURFACES ( RF_AOV_BIT( RF_AOV_OBJECT_INDEX ) | RF_AOV_BIT( RF_AOV_MATERIAL_INDEX ) )
#define AOVS ( RF_ALL_AOVS & ~RF_GRADIENT_AOVS & ~REMOVED )

static RfRenderSettings settings_of( int group, int spp, const char* tile, unsigned aovs )
{
    RfRenderSettings s = rf_default_render_settings();
    s.group = group;
    s.spp = spp;
    s.threads = 2;
    s.memory = (size_t)64 << 20;
    s.adaptive = RF_ADAPTIVE_OFF;
    s.aovs = aovs;
    s.cryptomatte = ( aovs & SURFACES ) != 0 ? RF_CRYPTOMATTE_MATERIAL | RF_CRYPTOMATTE_OBJECT : 0u;
    assert_true( rf_parse_tile( tile, &s.tile ) );
    return s;
}

TEST( test_groups_and_tiles )
{
    static const int groups[] = { 0, 3, 20 };
    for ( int g = 0; g < 3; ++g )
    {
        Case c = { "groups", settings_of( groups[g], 9, g % 2 == 0 ? "3x3" : "1", g % 2 == 0 ? AOVS : 0 ), make_room( ROOM_GGX ),
                   false };
        c.settings.filter = g == 0 ? RF_FILTER_BOX : RF_FILTER_BLACKMAN_HARRIS;
        check_case( &c );
    }
}

TEST( test_adaptive_alpha_and_filters )
{
    for ( int k = 0; k < 2; ++k )
    {
        Case c = { "adaptive", settings_of( 2, 10, "3x3", AOVS | RF_AOV_BIT( RF_AOV_ALPHA ) ),
                   k == 0 ? make_mirror_room( GLASS_BALL ) : make_open_scene( LIT_BY_ALL ), false };
        c.settings.adaptive = RF_ADAPTIVE_ON;
        c.settings.filter = k == 0 ? RF_FILTER_BLACKMAN_HARRIS : RF_FILTER_BOX;
        check_case( &c );
    }
}

TEST( test_stop_rules )
{
    Case noise = { "noise", settings_of( 2, 400, "3x3", 0 ), make_room( ROOM_DIFFUSE ), false };
    noise.settings.noise = 0.05;
    check_case( &noise );
    Case flicker = { "flicker", settings_of( 1, 400, "3x3", AOVS ), make_room( ROOM_GGX ), false };
    flicker.settings.flicker = 0.4;
    check_case( &flicker );
}

TEST( test_gradients_and_biased_weights )
{
    Case gradient = {
        "gradient", settings_of( 0, 10, "4x4", RF_ALL_AOVS & ~( REMOVED | SURFACES | RF_PASS_AOVS | RF_AOV_BIT( RF_AOV_HALF ) ) ),
        make_room( ROOM_DIFFUSE ), false
    };
    gradient.settings.estimator = rf_find_estimator( "gradient" );
    gradient.settings.filter = rf_default_filter( gradient.settings.estimator );
    check_case( &gradient );
    Case biased = { "eq15", settings_of( 2, 10, "1", 0 ), make_room( ROOM_DIFFUSE ), false };
    biased.settings.weights = RF_WEIGHTS_EQ15;
    biased.settings.filter = RF_FILTER_BOX;
    biased.settings.normalize = RF_NORMALIZE_RATIO;
    check_case( &biased );
}

TEST( test_light_paths )
{
    Case c = { "light paths", settings_of( 1, 8, "3x3", 0 ), make_mirror_room( GLASS_BALL ), false };
    c.settings.light_paths = RF_LIGHT_PATHS_ON;
    check_case( &c );
}

TEST( test_clamp )
{
    Case c = { "clamp", settings_of( 1, 8, "3x3", AOVS | REMOVED ), make_mirror_room( MIRROR_BALL ), false };
    c.settings.clamp = RF_CLAMP_AUTO;
    check_case( &c );
}

// Each light group has films of its own.
TEST( test_light_groups )
{
    Case c = { "light groups", settings_of( 2, 10, "3x3", REMOVED ), make_open_scene( LIT_BY_ALL ), false };
    assert_true( rf_tag_light( &c.scene, "sky", &c.scene.environment.light_group ) );
    assert_true( rf_tag_light( &c.scene, "lamp", &c.scene.punctuals[0].light_group ) );
    c.settings.clamp = 1.0;
    c.settings.light_groups = "all";
    check_case( &c );
}

// Films have sums of own-frame light, which are emptied, too.
TEST( test_what_moves )
{
    Case c = { "moving", settings_of( 3, 24, "3x3", AOVS | REMOVED ), load_moving_room( "sweep", WIDTH, HEIGHT ).scene, false };
    c.settings.adaptive = RF_ADAPTIVE_ON;
    c.settings.clamp = 1.0;
    c.settings.filter_width = RF_MAX_FILTER_WIDTH;
    check_case( &c );
}

// A long render empties its films into doubles, and one with too little memory goes along the path several times.
TEST( test_long_renders_and_sweeps )
{
    Case longer = { "totals", settings_of( 0, 48, "1", 0 ), make_room( ROOM_DIFFUSE ), false };
    longer.settings.max_depth = 3;
    longer.settings.filter_width = RF_MAX_FILTER_WIDTH; // fills them soon
    check_case( &longer );
    Case sweeps = { "sweeps", settings_of( 2, 6, "1", 0 ), make_room( ROOM_DIFFUSE ), true };
    sweeps.settings.threads = 1;
    AUTO_BY( close_stage ) Stage stage;
    open_stage( &stage, make_room( ROOM_DIFFUSE ), EYES, 4.0f, WIDTH, HEIGHT );
    sweeps.settings.memory = least_memory( &stage, 0, EYES, &sweeps.settings );
    check_case( &sweeps );
}

// Of other frames, or cut short: an error, no crash.
TEST( test_other_states_are_refused )
{
    Run run;
    begin( &run, make_room( ROOM_DIFFUSE ) );
    RfRenderSettings settings = settings_of( 1, 6, "1", 0 );
    run.most = 3;
    assert_int_equal( render( &run, &settings, 0, false ), RF_ERROR_INTERRUPTED );
    size_t size = run.state.size;
    RfRenderCallbacks callbacks = { .user = &run, .frame = keep, .load = load };
    for ( int k = 0; k < 4; ++k )
    {
        RfError error = { 0 };
        RfRenderSettings other = settings;
        run.state.read = 0;
        run.state.size = k == 0 ? size / 2 : size;
        other.aovs = k == 1 ? AOVS : 0;
        RfShot shot = stage_shot( &run.stage, k == 3 ? s_frames + 1 : s_frames, k < 2 ? EYES : EYES - 1 );
        assert_int_equal( rf_render( &shot, &other, &callbacks, NULL, &error ), k == 0 ? RF_ERROR_IO : RF_ERROR_USAGE );
        assert_true( error.text[0] != '\0' );
    }
    assert_int_equal( run.done, 0 );
    end( &run );
}

// The first comes after the first pass: of the oldest frame, with one sample.
TEST( test_preview_comes_early )
{
    Run run;
    begin( &run, make_room( ROOM_DIFFUSE ) );
    RfRenderSettings settings = settings_of( 1, 6, "1", 0 );
    assert_int_equal( render( &run, &settings, 3, false ), RF_OK );
    assert_true( run.previews >= 1 );
    if ( run.previews == 1 ) // on a free machine: the next would come a second later
    {
        assert_int_equal( run.preview_frame, 3 );
        assert_true( run.preview_spp == 1.0 );
    }
    end( &run );
}
