// A further estimator needs no line of the driver: a plain path tracer, one path at a time, behind
// the socket of render/estimator.h. Its picture is that of frame and tile reuse with groups of one
// frame and no tiles, bit for bit; and an estimator may ask for several films.
#include "render/estimator.h"
#include "estimators/estimators.h"
#include "support/reference_tracer.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"
#include "reuse/tile/tile.h"

#include <math.h>
#include <string.h>

#define WIDTH 39
#define HEIGHT 34
#define EYES 5

// One row of pixels.
typedef struct Row
{
    int eye, row, count;
    float rgb[WIDTH][3];
} Row;

static RfEstimatorSizes plain_sizes( const RfEstimatorGroup* group )
{
    return ( RfEstimatorSizes ){
        .jobs = group->height, .batch = sizeof( Row ), .trace_scratch = 64, .accumulate_scratch = 64, .directions = 1
    };
}

static void nothing_to_lay_out( const RfEstimatorGroup* group, void* memory )
{
    (void)group;
    (void)memory;
}

static int plain_trace( const RfEstimatorGroup* group, RfTraceJob job, void* batch, void* scratch, RfRayCounts* rays )
{
    (void)scratch;
    Row* row = batch;
    const RfRenderSettings* s = group->settings;
    ReferenceSettings settings = reference_settings_of( s, group->first_frame + job.eye );
    settings.max_depth = group->max_depth;
    row->eye = job.eye;
    row->row = job.job;
    row->count = group->width;
    for ( int x = 0; x < row->count; ++x )
    {
        RfVec3 c = reference_sample( group->tracer, group->eyes + job.eye, &settings, job.pass, x, row->row );
        row->rgb[x][0] = c.x;
        row->rgb[x][1] = c.y;
        row->rgb[x][2] = c.z;
    }
    rays->primary += (uint64_t)row->count;
    return row->count;
}

// Adds channels [first, end) of a row to a film, with its weight.
static void add_row( const Row* row, RfAccumulateJob job, int film, int first, int end )
{
    float* pixel = job.films[film].half[job.half] + 4 * (size_t)row->row * (size_t)row->count;
    for ( int x = 0; x < row->count; ++x, pixel += 4 )
    {
        for ( int c = first; c < end; ++c )
            pixel[c] += job.weight * row->rgb[x][c];
        pixel[3] += job.weight;
    }
}

static bool is_in( const Row* row, RfAccumulateJob job )
{
    return row->eye == job.eye && row->row >= job.first_row && row->row < job.end_row;
}

// Adds the rows of a job, red to film `red_film` and the rest to film 0; returns the samples.
static uint64_t add_rows( RfAccumulateJob job, void* const* batches, int batch_count, int red_film )
{
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const Row* row = batches[k];
        if ( !is_in( row, job ) )
            continue;
        add_row( row, job, 0, red_film == 0 ? 0 : 1, 3 );
        if ( red_film > 0 )
            add_row( row, job, red_film, 0, 1 );
        landed += (uint64_t)row->count;
    }
    return landed;
}

static uint64_t plain_accumulate( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                                  void* scratch )
{
    (void)group;
    (void)scratch;
    return add_rows( job, batches, batch_count, 0 );
}

static const RfEstimator s_plain = {
    .name = "plain",
    .films = 1,
    .sizes = plain_sizes,
    .lay_out_batch = nothing_to_lay_out,
    .lay_out_scratch = nothing_to_lay_out,
    .trace = plain_trace,
    .accumulate = plain_accumulate,
};

// The same with red in a film of its own, which `finish` puts together again.
static uint64_t split_accumulate( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                                  void* scratch )
{
    (void)group;
    (void)scratch;
    return add_rows( job, batches, batch_count, 1 );
}

static RfRelmse split_finish( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch )
{
    (void)settings;
    (void)scratch;
    float red[3 * WIDTH * HEIGHT];
    rf_combine_film( films + 1, RF_NORMALIZE_CROSSFIT, red, NULL );
    rf_combine_film( films, RF_NORMALIZE_CROSSFIT, picture->rgb, picture->weight );
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
        picture->rgb[3 * i] = red[3 * i];
    return rf_plain_relmse( (double)NAN );
}

static RfRenderSettings settings_of( const RfEstimator* estimator )
{
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.tile = rf_no_tile();
    settings.spp = 5;
    settings.max_depth = 5;
    settings.light_samples = 2;
    settings.seed = 7;
    settings.threads = 2;
    settings.memory = (size_t)256 << 20;
    if ( estimator != NULL )
        settings.estimator = estimator;
    return settings;
}

static Rendered render_all_of( const RfTracer* tracer, const RfEye* eyes, const RfEstimator* estimator )
{
    RfRenderSettings settings = settings_of( estimator );
    return render_all( tracer, eyes, EYES, &settings );
}

static void assert_same( const Rendered* a, const Rendered* b )
{
    assert_memory_equal( a->rgb, b->rgb, 3 * a->pixels * EYES * sizeof( float ) );
    assert_memory_equal( a->weight, b->weight, a->pixels * EYES * sizeof( float ) );
}

static RfScene s_scene;
static RfTracer* s_tracer;
static RfEye s_eyes[EYES];

static int set_up( void** state )
{
    (void)state;
    s_scene = make_glass_room();
    s_tracer = make_tracer( &s_scene );
    orbit_eyes( s_eyes, EYES, 4.0f, WIDTH, HEIGHT );
    return 0;
}

static int tear_down( void** state )
{
    (void)state;
    rf_destroy_tracer( s_tracer );
    rf_destroy_scene( &s_scene );
    return 0;
}

TEST( test_equals_reuse_without_reuse )
{
    Rendered reuse = render_all_of( s_tracer, s_eyes, NULL ), plain = render_all_of( s_tracer, s_eyes, &s_plain );
    assert_same( &reuse, &plain );
    assert_true( plain.relmse_estimate[2] == reuse.relmse_estimate[2] && plain.relmse_estimate[2] > 0.0 );
    assert_true( plain.effective_spp[2] == 5.0 && plain.stats.rays.primary == reuse.stats.rays.primary );

    RfEstimator split = s_plain;
    split.films = 2;
    split.accumulate = split_accumulate;
    split.finish = split_finish;
    Rendered two = render_all_of( s_tracer, s_eyes, &split );
    assert_same( &reuse, &two );
    assert_true( isnan( two.relmse_estimate[2] ) );
    free_rendered( &two );
    free_rendered( &plain );
    free_rendered( &reuse );
}

// Threads, memory and the frames asked for are the driver's: no estimator need think of them.
TEST( test_driver_does_the_rest )
{
    RfRenderSettings settings = settings_of( &s_plain );
    settings.group = 1;
    Rendered all = render_all( s_tracer, s_eyes, EYES, &settings );
    settings.threads = 3;
    settings.memory = all.stats.fit.least;
    Rendered tight = render_frames( s_tracer, s_eyes, EYES, ( int[] ){ 1, 3 }, 2, &settings );
    assert_memory_equal( frame_rgb( &all, 1 ), frame_rgb( &tight, 0 ), 3 * all.pixels * sizeof( float ) );
    assert_memory_equal( frame_rgb( &all, 3 ), frame_rgb( &tight, 1 ), 3 * all.pixels * sizeof( float ) );
    assert_true( tight.stats.peak_bytes <= tight.stats.budget_bytes );
    assert_true( all.native_spp[2] >= 5.0 && all.effective_spp[2] == all.native_spp[2] ); // nothing is shared
    free_rendered( &tight );
    free_rendered( &all );
}

static RfResult refuse( const RfRenderSettings* settings, RfError* error )
{
    return settings->light_samples > 1 ? rf_fail( error, RF_ERROR_USAGE, "one light sample only" ) : RF_OK;
}

static RfFirstHits no_hits( const void* scratch )
{
    (void)scratch;
    return ( RfFirstHits ){ .hits = NULL };
}

// What an estimator lacks is an error with its name, before any work.
TEST( test_what_it_lacks_is_said )
{
    RfError error;
    RfRenderSettings resolved, adaptive = settings_of( &s_plain ), aovs = adaptive, none = adaptive;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s_tracer, s_eyes, EYES, NULL, 0 }, &adaptive, &resolved, &error ),
                      RF_OK );
    assert_int_equal( resolved.adaptive, RF_ADAPTIVE_OFF ); // auto
    adaptive.adaptive = RF_ADAPTIVE_ON;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s_tracer, s_eyes, EYES, NULL, 0 }, &adaptive, &resolved, &error ),
                      RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "'plain' has no adaptive sampling" ) );
    aovs.aovs = RF_AOV_BIT( RF_AOV_NORMAL );
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s_tracer, s_eyes, EYES, NULL, 0 }, &aovs, &resolved, &error ),
                      RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "'plain' has no" ) );
    RfEstimator first = s_plain;
    first.first_hits = no_hits;
    aovs.estimator = &first;
    aovs.aovs = RF_AOV_BIT( RF_AOV_DENOISE_NORMAL );
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s_tracer, s_eyes, EYES, NULL, 0 }, &aovs, &resolved, &error ),
                      RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "'plain' has no AOVs for denoisers" ) );
    none.estimator = NULL;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s_tracer, s_eyes, EYES, NULL, 0 }, &none, &resolved, &error ),
                      RF_ERROR_USAGE );
    RfEstimator strict = s_plain;
    strict.check = refuse;
    none.estimator = &strict;
    assert_int_equal( rf_resolve_settings( &( RfShot ){ s_tracer, s_eyes, EYES, NULL, 0 }, &none, &resolved, &error ),
                      RF_ERROR_USAGE );
    assert_string_equal( error.text, "one light sample only" );
}

// Settings that come from a program are checked as those of the command line are.
TEST( test_settings_out_of_range_are_refused )
{
    RfError error;
    RfRenderSettings resolved, bad[6];
    for ( int i = 0; i < 6; ++i )
        bad[i] = settings_of( NULL );
    bad[0].weights = (RfWeights)99;
    bad[1].normalize = (RfNormalize)99;
    bad[2].light_sampling = (RfLightSampling)99;
    bad[3].files.compression = (RfExrCompression)99;
    bad[4].threads = RF_MAX_THREADS + 1;
    bad[5].aovs = ~0u;
    for ( int i = 0; i < 6; ++i )
        assert_int_equal( rf_resolve_settings( &( RfShot ){ s_tracer, s_eyes, EYES, NULL, 0 }, bad + i, &resolved, &error ),
                          RF_ERROR_USAGE );
    // no tiles are no tiles, whatever size was left in the settings
    RfRenderSettings no_tiles = settings_of( NULL );
    no_tiles.tile = ( RfTile ){ RF_TILE_NONE, 8, 8 };
    Rendered plain = render_all_of( s_tracer, s_eyes, NULL ), left = render_all( s_tracer, s_eyes, EYES, &no_tiles );
    assert_same( &plain, &left );
    free_rendered( &left );
    free_rendered( &plain );
    rf_destroy_camera_path( NULL );
    rf_destroy_image( NULL );
}

static RfResult fail_silently( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)user;
    (void)frame;
    (void)error;
    return RF_ERROR_IO;
}

TEST( test_a_silent_callback_is_named )
{
    RfError error;
    RfRenderSettings settings = settings_of( NULL );
    RfRenderCallbacks callbacks = { .frame = fail_silently };
    assert_int_equal( rf_render( &( RfShot ){ s_tracer, s_eyes, EYES, ( int[] ){ 1 }, 1 }, &settings, &callbacks, NULL, &error ),
                      RF_ERROR_IO );
    assert_int_equal( error.code, RF_ERROR_IO );
    assert_non_null( strstr( error.text, "frame 2 was not taken" ) );
}

TEST( test_estimators_have_names )
{
    assert_ptr_equal( rf_find_estimator( "reuse" ), rf_default_render_settings().estimator );
    assert_string_equal( rf_estimator_name( rf_find_estimator( "reuse" ) ), "reuse" );
    assert_null( rf_find_estimator( "plain" ) );
    for ( int i = 0; rf_estimator_words[i] != NULL; ++i )
        assert_ptr_equal( rf_find_estimator( rf_estimator_words[i] ), rf_estimator_at( i ) );
}

SHARED_BY_TESTS( set_up, tear_down )
