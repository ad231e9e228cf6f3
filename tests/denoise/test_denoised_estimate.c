// The error that is told of denoised pictures, their bias included, is the true one, by Open Image Denoise and the halves that a render
// makes: the quotient of the means over seeds is within 10 % of 1, and what the seeds leave open. And the denoised picture is no
// worse than the noisy one, to within 5 %. With REFRAME_LONG in six rooms with
// three sample counts, else in one. Skipped where there is no denoiser.
#include "scene/camera.h"
#include "scene_file/scene_file.h"
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 128
#define HEIGHT 72
#define FRAME ( STAGE_EYES / 2 )
#define REFERENCE_SEED 1000003
#define MOST_SEEDS 40

typedef struct Setting
{
    int group;
    const char* tile;
    int spp, seeds; // with REFRAME_LONG
} Setting;

static const Setting s_settings[] = {
    { 0, "1", 16, 24 }, { 0, "1", 4, 40 }, { 0, "1", 64, 10 }, { 3, "3x3", 14, 12 }, { 8, "rooks16", 16, 8 },
};

#define SETTINGS (int)( sizeof s_settings / sizeof s_settings[0] )

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static const RfFrameResult* render_by( Stage* stage, const Setting* setting, uint64_t seed )
{
    RfRenderSettings settings = plain_settings();
    settings.group = setting->group;
    settings.spp = setting->spp;
    settings.seed = seed;
    settings.filter = RF_FILTER_BOX;
    settings.aovs = RF_DENOISE_AOVS | RF_AOV_BIT( RF_AOV_HALF );
    assert_true( rf_parse_tile( setting->tile, &settings.tile ) );
    return render_one( stage, FRAME, &settings );
}

static void open_room( const char* room, Stage* stage )
{
    char file[512];
    RfScene scene;
    RfEye eyes[STAGE_EYES];
    RfError error = { 0 };
    RfLog log = { 0 };
    int camera;
    snprintf( file, sizeof file, "%s/%s.glb", REFRAME_SCENE_FOLDER, room );
    if ( rf_load_scene( file, &scene, &log, &error ) != RF_OK || rf_find_camera( &scene, NULL, &camera, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    for ( int i = 0; i < STAGE_EYES; ++i )
    {
        if ( rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras + camera, NULL, { 24, 1 }, WIDTH, HEIGHT }, 3.0 + i,
                            eyes + i, &error ) != RF_OK )
            fail_msg( "%s", error.text );
    }
    open_stage_before( stage, scene, eyes, STAGE_EYES );
}

// Told and true errors of the seeds.
typedef struct Errors
{
    double told[MOST_SEEDS], is[MOST_SEEDS], noisy, clean; // sums of true errors, too
    int count, within;
} Errors;

static double quotient( const Errors* e, int without )
{
    double told = 0.0, is = 0.0;
    for ( int k = 0; k < e->count; ++k )
    {
        told += k == without ? 0.0 : e->told[k];
        is += k == without ? 0.0 : e->is[k];
    }
    return told / is;
}

// Of the quotient (the jackknife; Quenouille, Notes on bias in estimation, Biometrika 43, 1956).
static double standard_error( const Errors* e )
{
    double mean = 0.0, squares = 0.0;
    for ( int k = 0; k < e->count; ++k )
        mean += quotient( e, k ) / e->count;
    for ( int k = 0; k < e->count; ++k )
        squares += ( quotient( e, k ) - mean ) * ( quotient( e, k ) - mean );
    return sqrt( squares * ( e->count - 1 ) / e->count );
}

static void add_seed( RfDenoiser* denoiser, const RfFrameResult* frame, const float* reference, double floor, Errors* e )
{
    static float clean[3 * WIDTH * HEIGHT];
    RfDenoised denoised;
    RfError error;
    RfErrorMetrics metrics;
    const RfNoisyFrame noisy = rf_noisy_frame( frame );
    if ( rf_denoise( denoiser, &noisy, clean, &denoised, NULL, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    const RfImage image = { WIDTH, HEIGHT, clean }, truth = { WIDTH, HEIGHT, (float*)reference };
    assert_int_equal( rf_measure_error( &image, &truth, &metrics, &error ), RF_OK );
    e->is[e->count] = metrics.relmse - floor;
    e->told[e->count] = denoised.denoised.relmse;
    e->within += e->is[e->count] <= denoised.denoised.high;
    e->clean += metrics.relmse;
    const RfImage before = { WIDTH, HEIGHT, (float*)frame->rgb };
    assert_int_equal( rf_measure_error( &before, &truth, &metrics, &error ), RF_OK );
    e->noisy += metrics.relmse;
    e->count += 1;
}

// Of settings: those that are off, and those of which the seeds leave little open.
typedef struct Tally
{
    int off, sharp;
} Tally;

static void check_room( RfDenoiser* denoiser, const char* room, int settings, Tally* tally )
{
    static Stage stage;
    open_room( room, &stage );
    const Setting converged = { 0, "3x3", is_long() ? 4096 : 512, 1 };
    const RfFrameResult* frame = render_by( &stage, &converged, REFERENCE_SEED );
    float* reference = copy_floats( frame->rgb, 3 * WIDTH * HEIGHT );
    double floor = frame->relmse_likely;
    for ( const Setting* s = s_settings; s < s_settings + settings; ++s )
    {
        static Errors e;
        e = ( Errors ){ .count = 0 };
        for ( int seed = 1; seed <= ( is_long() ? s->seeds : 8 ); ++seed )
            add_seed( denoiser, render_by( &stage, s, (uint64_t)( 100 + seed ) ), reference, floor, &e );
        double told = quotient( &e, -1 ), open = standard_error( &e );
        printf( "%-14s group %d tile %-7s spp %2d: noisy %.4f, denoised %.4f, told / true %.2f +- %.2f, %d of %d within the "
                "interval\n",
                room, s->group, s->tile, s->spp, e.noisy / e.count, e.clean / e.count, told, open, e.within, e.count );
        tally->off += !( fabs( told - 1.0 ) <= 0.1 + 3.0 * open && e.clean <= 1.05 * e.noisy );
        tally->sharp += open < 0.15;
    }
    free( reference );
    close_stage( &stage );
}

TEST( test_told_errors_are_true )
{
    static const char* const rooms[] = { "noise-checker",  "vase-room",   "bounced-room",
                                         "noise-corridor", "noise-shelf", "noise-patio" };
    RfDenoiser* denoiser;
    RfError error;
    Tally tally = { 0, 0 };
    if ( rf_open_denoiser( NULL, 1, &denoiser, &error ) != RF_OK )
    {
        print_message( "skipped: %s\n", error.text );
        return;
    }
    for ( size_t i = 0; i < ( is_long() ? sizeof rooms / sizeof rooms[0] : 1 ); ++i )
        check_room( denoiser, rooms[i], is_long() ? SETTINGS : 1, &tally );
    rf_close_denoiser( denoiser );
    assert_int_equal( tally.off, 0 );
    assert_true( tally.sharp >= ( is_long() ? SETTINGS : 1 ) );
}
