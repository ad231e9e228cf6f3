// Passes are unbiased: emission and direct light against the plain path tracer of the tests with no further vertices, and all of
// them, by frames and tiles, against single pixels of one frame.
#include "support/render_one.h"
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 32
#define HEIGHT 24
#define VALUES ( 3 * WIDTH * HEIGHT )
#define BLOCK 4
#define EYES 7
#define FRAME 3

static int more( void ) { return getenv( "REFRAME_LONG" ) != NULL ? 4 : 1; }

#define PASSES 5
#define SUM PASSES // emission and direct light together

// Images of each pass, from the same renders.
typedef struct PassImages
{
    Images of[PASSES + 1];
} PassImages;

// One image per seed, from `first` on.
static PassImages pass_images( Stage* stage, RfRenderSettings settings, uint64_t first )
{
    PassImages images = { 0 };
    settings.aovs = RF_PASS_AOVS;
    settings.spp *= suite_samples();
    for ( int p = 0; p <= PASSES; ++p )
        images.of[p] = ( Images ){ .width = WIDTH, .height = HEIGHT, .count = SEEDS };
    for ( int seed = 0; seed < SEEDS; ++seed )
    {
        settings.seed = first + (uint64_t)seed + suite_seed();
        const float* const* passes = render_one( stage, FRAME, &settings )->aovs + RF_AOV_EMISSION;
        for ( int p = 0; p < PASSES; ++p )
            images.of[p].rgb[seed] = copy_floats( passes[p], VALUES );
        float* sum = images.of[SUM].rgb[seed] = copy_floats( passes[0], VALUES );
        for ( int i = 0; i < VALUES; ++i )
            sum[i] += passes[1][i];
    }
    return images;
}

static void free_passes( PassImages* images )
{
    for ( int p = 0; p <= PASSES; ++p )
        free_images( images->of + p );
}

static const struct
{
    int group;
    const char* tile;
    RfFilter filter;
} s_modes[] = { { 0, "3x3", RF_FILTER_BOX }, { 3, "1", RF_FILTER_BOX }, { 3, "3x3", RF_FILTER_BLACKMAN_HARRIS } };

static RfRenderSettings settings_of( int group, const char* tile, RfFilter filter, int spp )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp * more();
    settings.max_depth = 5;
    settings.filter = filter;
    settings.filter_width = rf_default_filter_width( filter );
    settings.memory = (size_t)512 << 20;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

TEST( test_emission_and_direct_light )
{
    RfScene scenes[] = { make_open_scene( LIT_BY_ALL ), make_room( ROOM_GGX ) };
    for ( int k = 0; k < 2; ++k )
    {
        Stage stage;
        open_stage( &stage, scenes[k], EYES, 4.0f, WIDTH, HEIGHT );
        RfRenderSettings shallow = settings_of( 0, "1", RF_FILTER_BOX, 1 );
        shallow.max_depth = 2;
        Images reference = reference_images( stage_tracer( &stage ), stage.eyes, FRAME, 48 * more(), &shallow );
        for ( size_t mode = 0; mode < 2; ++mode ) // the plain filter, as the reference
        {
            char what[64];
            snprintf( what, sizeof what, "scene %d, group %d tile %s:", k, s_modes[mode].group, s_modes[mode].tile );
            RfRenderSettings settings = settings_of( s_modes[mode].group, s_modes[mode].tile, s_modes[mode].filter, 7 );
            PassImages images = pass_images( &stage, settings, 1 );
            assert_unbiased( what, images.of + SUM, &reference, BLOCK );
            free_passes( &images );
        }
        free_images( &reference );
        close_stage( &stage );
    }
}

static void check_room( const char* name, RfScene scene, unsigned passes )
{
    Stage stage;
    open_stage( &stage, scene, EYES, 4.0f, WIDTH, HEIGHT );
    for ( size_t mode = 0; mode < sizeof s_modes / sizeof s_modes[0]; ++mode )
    {
        PassImages one = pass_images( &stage, settings_of( 0, "1", s_modes[mode].filter, 28 ), 1000 );
        PassImages shared =
            pass_images( &stage, settings_of( s_modes[mode].group, s_modes[mode].tile, s_modes[mode].filter, 7 ), 1 );
        for ( int p = 0; p < PASSES; ++p )
        {
            char what[96];
            RfAov pass = (RfAov)( RF_AOV_EMISSION + p );
            snprintf( what, sizeof what, "%s, %s, group %d tile %s:", name, rf_aov_name( pass ), s_modes[mode].group,
                      s_modes[mode].tile );
            if ( ( passes & RF_AOV_BIT( pass ) ) != 0 )
                assert_unbiased( what, shared.of + p, one.of + p, BLOCK );
        }
        free_passes( &one );
        free_passes( &shared );
    }
    close_stage( &stage );
}

TEST( test_mirrors_and_glass )
{
    unsigned all = RF_PASS_AOVS;
    check_room( "layered slab", make_mirror_room( LAYERED_SLAB ), all );
    check_room( "panes", make_pane_room( PANES_AND_ALL ), all & ~RF_AOV_BIT( RF_AOV_EMISSION ) );
}

STATISTICAL_TESTS
