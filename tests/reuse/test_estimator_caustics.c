// Caustics that are left out: the picture is that of an independent reference without them, and with the light taken out that of
// one with them, whatever throws them, lights them and reuses paths.
#include "support/render_one.h"
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <string.h>

#define EYES 3
#define WIDTH 32
#define HEIGHT 24
#define VALUES ( 3 * WIDTH * HEIGHT )
#define REFERENCE_SPP 32
#define CAUSTICS RF_EFFECT_BIT( RF_EFFECT_CAUSTICS )

typedef struct Reuse
{
    int group;
    const char* tile;
    bool adaptive, clamped;
} Reuse;

static RfRenderSettings settings_of( Reuse reuse, int spp )
{
    RfRenderSettings settings = plain_settings();
    settings.group = reuse.group;
    settings.spp = spp;
    settings.max_depth = 6;
    settings.adaptive = reuse.adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
    settings.clamp = reuse.clamped ? 0.3 : 0.0;
    settings.aovs = RF_AOV_BIT( RF_AOV_REMOVED );
    assert_true( rf_parse_tile( reuse.tile, &settings.tile ) );
    return settings;
}

// A picture for each seed, and its sum with the light taken out.
typedef struct Parts
{
    Images picture, sum;
    double removed; // mean
} Parts;

static Parts render_parts( Stage* stage, RfRenderSettings settings )
{
    Parts parts = { .picture = { WIDTH, HEIGHT, SEEDS, { NULL } }, .sum = { WIDTH, HEIGHT, SEEDS, { NULL } } };
    settings.spp *= suite_samples();
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = suite_seed() + (uint64_t)k + 1;
        const RfFrameResult* kept = render_one( stage, 1, &settings );
        const float* removed = kept->aovs[RF_AOV_REMOVED];
        parts.picture.rgb[k] = copy_floats( kept->rgb, VALUES );
        parts.sum.rgb[k] = copy_floats( kept->rgb, VALUES );
        for ( int i = 0; i < VALUES; ++i )
            parts.sum.rgb[k][i] += removed[i];
        parts.removed += mean_value( removed, VALUES ) / SEEDS;
    }
    return parts;
}

static void check( const char* what, RfScene scene, const RfEye* given, int count, const Reuse* reuse )
{
    Stage stage;
    open_stage( &stage, scene, EYES, 4.0f, WIDTH, HEIGHT );
    memcpy( stage.eyes, given != NULL ? given : stage.eyes, EYES * sizeof *given );
    assert_int_equal( rf_choose_effects( &stage.scene, 0, CAUSTICS, NULL ), RF_OK );
    RfRenderSettings settings = settings_of( reuse[0], 6 );
    Images whole = reference_images( stage_tracer( &stage ), stage.eyes, 1, REFERENCE_SPP, &settings );
    Images without = caustic_free_images( stage_tracer( &stage ), stage.eyes, 1, REFERENCE_SPP, &settings );
    for ( int k = 0; k < count; ++k )
    {
        char name[100];
        settings = settings_of( reuse[k], reuse[k].group > 0 ? 9 : 6 );
        Parts parts = render_parts( &stage, settings );
        assert_true( parts.removed > 0.0 );
        snprintf( name, sizeof name, "%s, %d:%s, sum", what, reuse[k].group, reuse[k].tile );
        assert_unbiased( name, &parts.sum, &whole, 4 );
        snprintf( name, sizeof name, "%s, %d:%s, picture", what, reuse[k].group, reuse[k].tile );
        if ( !reuse[k].clamped )
            assert_unbiased( name, &parts.picture, &without, 4 );
        free_images( &parts.picture );
        free_images( &parts.sum );
    }
    free_images( &whole );
    free_images( &without );
    close_stage( &stage );
}

static const Reuse s_all[] = {
    { 0, "1", false, false }, { 1, "rooks4", false, false }, { 1, "2x2", true, false }, { 1, "3x3", false, true }
};
static const Reuse s_both[] = { { 0, "3x3", false, false }, { 1, "3x3", false, false } };

TEST( test_mirrors_and_glass )
{
    check( "mirror", make_mirror_room( FLAT_MIRROR ), NULL, 2, s_both );
    check( "glass", make_mirror_room( GLASS_BALL ), NULL, 4, s_all );
    check( "rough slab", make_mirror_room( ROUGH_SLAB ), NULL, 2, s_both );
    check( "slab over a base", make_mirror_room( LAYERED_SLAB ), NULL, 2, s_both );
}

TEST( test_metals )
{
    check( "sharp metal", make_mirror_room( SHARP_METAL ), NULL, 2, s_both );
    RfScene scene = make_room( ROOM_GGX ); // with a ball that is brushed, and no chain
    RfMaterial* m = scene.materials + ROOM_OBJECT_MATERIAL;
    m->diffuse = rf_vec3( 0, 0, 0 );
    m->specular = rf_vec3( 0.9f, 0.8f, 0.7f );
    m->alpha = 0.08f;
    m->coat_f0 = m->coat_f90 = 1.0f;
    check( "brushed metal", scene, NULL, 4, s_all );
    check( "varied", make_varied_room(), NULL, 2, s_both );
}

TEST( test_panes_and_skies )
{
    check( "panes", make_pane_room( PANES_AND_ALL ), NULL, 2, s_both );
    check( "mirror under all lights", make_mirror_in_the_open( LIT_BY_ALL ), NULL, 2, s_both );
    check( "mirror under a map", make_mirror_in_the_open( LIT_BY_MAP ), NULL, 2, s_both );
    RfEye eyes[EYES];
    low_eyes( eyes, EYES, WIDTH, HEIGHT );
    check( "glass under a sky", make_glass_in_the_open(), eyes, 2, s_both );
}

STATISTICAL_TESTS
