// AOVs of a render: closed forms, the variance against the true one, the same bits however
// the frames come about, and no influence on colour.
#include "bsdf/thin_film.h"
#include "bsdf/sheen.h"
#include "support/filter_reference.h"
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Those of the estimator of frames and tiles, with a clamp.
#define REUSE_AOVS ( RF_ALL_AOVS & ~RF_GRADIENT_AOVS )

static RfRenderSettings layered( int group, int spp )
{
    RfRenderSettings settings = small_settings( group, spp );
    settings.aovs = REUSE_AOVS;
    settings.clamp = 0.05;
    return settings;
}

#define WIDTH 37
#define HEIGHT 34
#define PIXELS ( WIDTH * HEIGHT )
#define DISTANCE 3.0f

// A wall at z = −DISTANCE from x = left on, and nothing else; it shines, so that
// there is something to vary.
static RfScene make_wall( float left, RfMaterial material )
{
    SceneBuilder b = { 0 };
    material.emission = rf_vec3( 0.3f, 0.2f, 0.1f );
    uint32_t m = add_material( &b, material );
    add_quad( &b, m, rf_vec3( left, -50, -DISTANCE ), rf_vec3( 50, -50, -DISTANCE ), rf_vec3( 50, 50, -DISTANCE ),
              rf_vec3( left, 50, -DISTANCE ) );
    return finish_scene( &b );
}

static RfEye look( RfVec3 origin, RfVec3 forward )
{
    return rf_make_eye( origin, forward, rf_vec3( 0, 1, 0 ), 0.8, WIDTH, HEIGHT );
}

static void assert_near( double value, double wanted, double tolerance, const char* what )
{
    if ( !( fabs( value - wanted ) <= tolerance ) )
        fail_msg( "%s: %.9g instead of %.9g", what, value, wanted );
}

static void assert_all( const float* values, int channels, int channel, double wanted, double tolerance, const char* what )
{
    for ( int i = 0; i < PIXELS; ++i )
        assert_near( (double)values[i * channels + channel], wanted, tolerance, what );
}

// A camera before a wall that moves right and up and steps back.
TEST( test_moving_wall_by_hand )
{
    Stage stage;
    RfVec3 ahead = rf_vec3( 0, 0, -1 );
    RfEye eyes[3] = { look( rf_vec3( -0.1f, 0, 0 ), ahead ), look( rf_vec3( 0, 0, 0 ), ahead ),
                      look( rf_vec3( 0.2f, 0.05f, 0 ), ahead ) };
    open_stage_before( &stage, make_wall( -50, make_lambert( 0.2f, 0.4f, 0.6f ) ), eyes, 3 );
    double pixels_per_m = (double)eyes[0].focal / (double)DISTANCE;
    for ( int group = 0; group <= 1; ++group ) // 1: windows that are cut
    {
        RfRenderSettings settings = layered( group, 5 );
        const RfFrameResult* f = render_some( &stage, 0, 3, &settings );
        for ( int k = 0; k < 3; ++k )
        {
            const float* const* layers = f[k].aovs;
            assert_all( layers[RF_AOV_ALBEDO], 3, 0, 0.2, 1e-6, "albedo.R" );
            assert_all( layers[RF_AOV_ALBEDO], 3, 1, 0.4, 1e-6, "albedo.G" );
            assert_all( layers[RF_AOV_ALBEDO], 3, 2, 0.6, 1e-6, "albedo.B" );
            assert_all( layers[RF_AOV_NORMAL], 3, 0, 0.0, 1e-6, "normal.X" );
            assert_all( layers[RF_AOV_NORMAL], 3, 1, 0.0, 1e-6, "normal.Y" );
            assert_all( layers[RF_AOV_NORMAL], 3, 2, 1.0, 1e-6, "normal.Z" );
            assert_all( layers[RF_AOV_DEPTH], 1, 0, (double)DISTANCE, 1e-5, "depth.Z" ); // not the distance
            assert_all( layers[RF_AOV_VARIANCE], 3, 1, 0.0, 1e-9, "variance.G" );        // nothing varies
        }
        const float* first = f[0].aovs[RF_AOV_MOTION];
        const float* middle = f[1].aovs[RF_AOV_MOTION];
        const float* last = f[2].aovs[RF_AOV_MOTION];
        assert_all( first, 4, 0, 0.0, 0.0, "no frame before" );
        assert_all( first, 4, 2, -0.1 * pixels_per_m, 1e-4, "first motion.Z" );
        assert_all( middle, 4, 0, 0.1 * pixels_per_m, 1e-4, "motion.X" );
        assert_all( middle, 4, 1, 0.0, 1e-5, "motion.Y" );
        assert_all( middle, 4, 2, -0.2 * pixels_per_m, 1e-4, "motion.Z" );
        assert_all( middle, 4, 3, -0.05 * pixels_per_m, 1e-4, "motion.W" ); // the camera rises, the wall sinks
        assert_all( last, 4, 1, 0.05 * pixels_per_m, 1e-4, "last motion.Y" );
        assert_all( last, 4, 3, 0.0, 0.0, "no frame after" );
    }
    close_stage( &stage );
}

// The depth of an orthographic camera is that along the view, of a panorama the distance; motion at the seam is the short way.
TEST( test_other_projections_by_hand )
{
    Stage stage;
    RfRenderSettings settings = layered( 0, 5 );
    RfVec3 ahead = rf_vec3( 0, 0, -1 ), up = rf_vec3( 0, 1, 0 );
    RfEye eyes[2] = { rf_make_orthographic_eye( rf_vec3( 0, 0, 0 ), ahead, up, 0.8, WIDTH, HEIGHT ),
                      rf_make_orthographic_eye( rf_vec3( 0.1f, -0.2f, 0.5f ), ahead, up, 0.8, WIDTH, HEIGHT ) };
    open_stage_before( &stage, make_wall( -50, make_lambert( 0.2f, 0.4f, 0.6f ) ), eyes, 2 );
    const RfFrameResult* f = render_some( &stage, 0, 1, &settings );
    double pixels_per_m = 0.5 * HEIGHT / 0.8;
    assert_all( f[0].aovs[RF_AOV_DEPTH], 1, 0, (double)DISTANCE, 1e-5, "orthographic depth" );
    assert_all( f[0].aovs[RF_AOV_MOTION], 4, 2, -0.1 * pixels_per_m, 1e-4, "orthographic motion.Z" );
    assert_all( f[0].aovs[RF_AOV_MOTION], 4, 3, 0.2 * pixels_per_m, 1e-4, "orthographic motion.W" );

    // the wall is seen at the seam, behind the view; what misses it turns as well
    const float angle = 0.3f;
    stage.eyes[0] = rf_make_panoramic_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, 1 ), up, WIDTH, HEIGHT );
    stage.eyes[1] = rf_make_panoramic_eye( rf_vec3( 0, 0, 0 ), rf_vec3( sinf( angle ), 0, cosf( angle ) ), up, WIDTH, HEIGHT );
    f = render_some( &stage, 0, 1, &settings );
    double moved = (double)angle * WIDTH / 6.283185307179586;
    assert_all( f[0].aovs[RF_AOV_MOTION], 4, 2, moved, 2e-3, "panoramic motion.Z" );
    assert_all( f[0].aovs[RF_AOV_MOTION], 4, 3, 0.0, 2e-3, "panoramic motion.W" );
    double longitude = 3.141592653589793 / WIDTH, latitude = 1.5707963267948966 / HEIGHT; // of the pixel's middle
    int row = HEIGHT / 2 - 1;
    double far = (double)DISTANCE / ( cos( longitude ) * cos( latitude ) );
    assert_near( (double)f[0].aovs[RF_AOV_DEPTH][row * WIDTH], far, 0.02 * far, "panoramic depth" );
    assert_near( (double)f[0].aovs[RF_AOV_DEPTH][row * WIDTH + WIDTH - 1], far, 0.02 * far, "panoramic depth" );
    close_stage( &stage );
}

// Pixels that the wall covers in part, and pixels where nothing is.
TEST( test_edges_and_empty_pixels )
{
    Stage stage;
    float angle = 0.02f;
    RfEye eyes[2] = { look( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ) ),
                      look( rf_vec3( 0, 0, 0 ), rf_vec3( sinf( angle ), 0, -cosf( angle ) ) ) }; // turned right
    open_stage_before( &stage, make_wall( 0.013f, make_lambert( 0.5f, 0.5f, 0.5f ) ), eyes, 2 );
    RfRenderSettings settings = layered( 0, 64 );
    const RfFrameResult* f = render_some( &stage, 0, 1, &settings );
    double focal = (double)eyes[0].focal;
    int partial = 0;
    for ( int y = 0; y < HEIGHT; ++y )
    {
        for ( int x = 0; x < WIDTH; ++x )
        {
            int i = y * WIDTH + x;
            double edge = 0.5 * WIDTH + 0.013 / (double)DISTANCE * focal, covered = x + 1 - edge;
            covered = covered < 0.0 ? 0.0 : covered > 1.0 ? 1.0 : covered;
            double error = covered > 0.0 && covered < 1.0 ? 5.0 * sqrt( 0.25 / 64.0 ) : 1e-6;
            partial += covered > 0.0 && covered < 1.0;
            double found = (double)f[0].aovs[RF_AOV_NORMAL][3 * i + 2];
            assert_near( found, covered, error, "covered part" );
            assert_near( (double)f[0].aovs[RF_AOV_ALBEDO][3 * i], 0.5 * found, 1e-6, "albedo" );
            double depth = (double)f[0].aovs[RF_AOV_DEPTH][i];
            assert_near( depth, found > 0.0 ? (double)DISTANCE : 1e10, found > 0.0 ? 1e-5 : 0.0, "depth" );
            // a turn is a matter of the direction alone: the pixel's middle will do, to within its size
            double a = atan( ( x + 0.5 - 0.5 * WIDTH ) / focal ), moved = ( tan( a - (double)angle ) - tan( a ) ) * focal;
            assert_near( (double)f[0].aovs[RF_AOV_MOTION][4 * i + 2], moved, 0.03, "motion by turning" );
            assert_near( (double)f[0].aovs[RF_AOV_SAMPLES][i], 64.0, 0.0, "samples" );
        }
    }
    assert_int_equal( partial, HEIGHT );

    // turned around: the wall is behind the other camera, as is what is infinitely far
    stage.eyes[1] = look( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, 1 ) );
    f = render_some( &stage, 0, 2, &settings );
    for ( int c = 0; c < 4; ++c )
    {
        assert_all( f[0].aovs[RF_AOV_MOTION], 4, c, 0.0, 0.0, "behind the other eye" );
        assert_all( f[1].aovs[RF_AOV_MOTION], 4, c, 0.0, 0.0, "behind the other eye" );
    }

    // in the plane of the wall: next to nowhere on the other film, but a number
    stage.eyes[1] = look( rf_vec3( 1, 0, -DISTANCE ), rf_vec3( 0, 0, -1 ) );
    f = render_some( &stage, 0, 1, &settings );
    for ( int i = 0; i < 4 * PIXELS; ++i )
        assert_true( isfinite( f[0].aovs[RF_AOV_MOTION][i] ) );
    close_stage( &stage );
}

// Albedo and normal have the filter of the colour, depth and motion do not.
TEST( test_an_edge_has_the_pixel_filter )
{
    Stage stage;
    RfEye eyes[2] = { look( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ) ), look( rf_vec3( 0.1f, 0, 0 ), rf_vec3( 0, 0, -1 ) ) };
    open_stage_before( &stage, make_wall( 0.013f, make_lambert( 0.5f, 0.25f, 0.5f ) ), eyes, 2 );
    RfRenderSettings settings = layered( 0, 64 );
    const RfFrameResult* box = render_some( &stage, 0, 1, &settings );
    settings.filter = RF_FILTER_TENT;
    settings.filter_width = 3.0;
    const RfFrameResult* f = render_some( &stage, 0, 1, &settings );
    double edge = 0.5 * WIDTH + 0.013 / (double)DISTANCE * (double)eyes[0].focal;
    for ( int x = 0; x < WIDTH; ++x )
    {
        double all = filter_integral( RF_FILTER_TENT, 3.0, -x - 0.5, WIDTH - x - 0.5 );
        double covered = filter_integral( RF_FILTER_TENT, 3.0, edge - x - 0.5, WIDTH - x - 0.5 ) / all, albedo = 0.0,
               normal = 0.0;
        for ( int y = 0; y < HEIGHT; ++y )
        {
            albedo += (double)f[0].aovs[RF_AOV_ALBEDO][3 * ( y * WIDTH + x ) + 1] / HEIGHT;
            normal += (double)f[0].aovs[RF_AOV_NORMAL][3 * ( y * WIDTH + x ) + 2] / HEIGHT;
        }
        assert_near( normal, covered, 0.01, "filtered normal" );
        assert_near( albedo, 0.25 * normal, 1e-5, "filtered albedo" );
    }
    assert_memory_equal( f[0].aovs[RF_AOV_DEPTH], box[0].aovs[RF_AOV_DEPTH], (size_t)PIXELS * sizeof( float ) );
    assert_memory_equal( f[0].aovs[RF_AOV_MOTION], box[0].aovs[RF_AOV_MOTION], (size_t)PIXELS * 4 * sizeof( float ) );
    close_stage( &stage );
}

TEST( test_albedo_of_materials )
{
    RfMaterial cloth = make_plastic( 0.6f, 0.25f );
    cloth.kind = RF_BSDF_SHEEN;
    cloth.sheen = rf_vec3( 0.5f, 1.0f, 0.0f );
    cloth.sheen_alpha = 1.0f;
    RfMaterial materials[] = { make_metal( 0.9f, 0.3f ), make_plastic( 0.6f, 0.25f ), make_phong( 0.2f, 0.6f, 40.0f ), cloth };
    double e = (double)rf_sheen_albedo( 1.0f, 1.0f );
    double wanted[] = { 0.9, 0.04 + 0.96 * 0.3, 0.8, 0.5 * e + ( 1.0 - e ) * ( 0.04 + 0.96 * 0.3 ) };
    for ( int k = 0; k < 4; ++k )
    {
        Stage stage;
        RfEye eye = look( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ) );
        open_stage_before( &stage, make_wall( -50, materials[k] ), &eye, 1 );
        RfRenderSettings settings = layered( 0, 2 );
        const RfFrameResult* f = render_some( &stage, 0, 1, &settings );
        assert_all( f[0].aovs[RF_AOV_ALBEDO], 3, 0, wanted[k], 1e-6, "albedo" );
        close_stage( &stage );
    }
}

#define EYES 7

// Under a film: its colours, over what passes the brightest of them; of a mirror as well.
TEST( test_albedo_of_films )
{
    RfMaterial plastic = make_plastic( 1.0f, 0.25f ), mirror = make_metal( 0.9f, 0.3f );
    plastic.kind = RF_BSDF_IRIDESCENT;
    mirror.kind = RF_BSDF_SPECTRAL;
    mirror.alpha = mirror.ior = 0.0f;
    plastic.film = mirror.film = 0.5f;
    plastic.film_ior = mirror.film_ior = 1.9f;
    plastic.film_thickness = mirror.film_thickness = 250.0f;
    for ( int k = 0; k < 2; ++k )
    {
        RfMaterial m = k == 0 ? plastic : mirror;
        RfVec3 film = rf_film_fresnel( m.specular, 1.0f, m.film_ior, m.film_thickness );
        double f[3] = { film.x, film.y, film.z }, f0[3] = { m.specular.x, m.specular.y, m.specular.z },
               diffuse[3] = { m.diffuse.x, m.diffuse.y, m.diffuse.z }, most = (double)rf_max_component( film );
        Stage stage;
        RfEye eye = look( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ) );
        open_stage_before( &stage, make_wall( -50, m ), &eye, 1 );
        RfRenderSettings settings = layered( 0, 2 );
        const RfFrameResult* frames = render_some( &stage, 0, 1, &settings );
        for ( int c = 0; c < 3; ++c )
        {
            double base = k == 0 ? diffuse[c] * ( 1.0 - 0.5 * f0[0] - 0.5 * most ) : 0.0;
            double got = (double)frames[0].aovs[RF_AOV_ALBEDO][c];
            assert_true( fabs( got - ( 0.5 * f0[c] + 0.5 * f[c] + base ) ) < 1e-5 && got <= 1.0 );
        }
        assert_true( f[0] - f[2] > 0.01 || f[2] - f[0] > 0.01 );
        close_stage( &stage );
    }
}

TEST( test_samples_are_counted )
{
    Stage stage;
    open_stage( &stage, make_room( ROOM_GGX ), EYES, 4.0f, WIDTH, HEIGHT );
    for ( int group = 0; group <= 2; ++group )
    {
        RfRenderSettings settings = layered( group, 6 );
        const RfFrameResult* f = render_some( &stage, 0, EYES, &settings );
        for ( int k = 0; k < EYES; ++k )
        {
            double sum = 0.0;
            for ( int i = 0; i < PIXELS; ++i )
            {
                double samples = (double)f[k].aovs[RF_AOV_SAMPLES][i];
                assert_true( group == 0 ? samples == 6.0 : samples >= 6.0 ); // its own always
                sum += samples;
            }
            assert_near( sum / PIXELS, f[k].effective_spp, 1e-9, "mean of the samples" );
            assert_true( group == 0 || sum / PIXELS > 9.0 );
        }
    }
    close_stage( &stage );
}

#define SEEDS 32
#define BLOCK 3 // pixels, wide and high

// The mean of the layer against the variance of the pixels over seeds: blocks
// of pixels give a t-test.
static void check_variance( RoomKind kind, int group )
{
    Stage stage;
    enum
    {
        W = 18,
        H = 12,
        N = 3 * W * H,
        FRAMES = 5
    };
    open_stage( &stage, make_room( kind ), FRAMES, 4.0f, W, H );
    static double sum[N], square[N], layer[N];
    memset( sum, 0, sizeof sum );
    memset( square, 0, sizeof square );
    memset( layer, 0, sizeof layer );
    for ( int seed = 1; seed <= SEEDS; ++seed )
    {
        RfRenderSettings settings = layered( group, 12 );
        settings.seed = (uint64_t)seed;
        settings.max_depth = 3;
        const RfFrameResult* f = render_some( &stage, 2, 1, &settings );
        for ( int i = 0; i < N; ++i )
        {
            double v = (double)f[0].rgb[i];
            sum[i] += v;
            square[i] += v * v;
            layer[i] += (double)f[0].aovs[RF_AOV_VARIANCE][i] / SEEDS;
        }
    }
    double difference[( W / BLOCK ) * ( H / BLOCK )] = { 0 }, all = 0.0, all_layer = 0.0;
    for ( int i = 0; i < N; ++i )
    {
        double variance = ( square[i] - sum[i] * sum[i] / SEEDS ) / ( SEEDS - 1 );
        int x = i / 3 % W, y = i / 3 / W;
        // relative to the brightness, so that no block decides alone
        double mean = sum[i] / SEEDS, scale = 1.0 / ( mean * mean + 1e-3 );
        difference[y / BLOCK * ( W / BLOCK ) + x / BLOCK] += ( layer[i] - variance ) * scale;
        all += variance * scale;
        all_layer += layer[i] * scale;
    }
    int blocks = ( W / BLOCK ) * ( H / BLOCK );
    double mean = 0.0, spread = 0.0;
    for ( int b = 0; b < blocks; ++b )
        mean += difference[b] / blocks;
    for ( int b = 0; b < blocks; ++b )
        spread += ( difference[b] - mean ) * ( difference[b] - mean ) / ( blocks - 1 );
    double t = mean / sqrt( spread / blocks );
    print_message( "kind %d, group %d: layer / true variance %.3f, t %.2f\n", kind, group, all_layer / all, t );
    assert_true( fabs( t ) < 5.0 );
    assert_true( all_layer / all > 0.8 && all_layer / all < 1.25 ); // some 5 % are chance
    close_stage( &stage );
}

TEST( test_variance_is_the_true_one )
{
    check_variance( ROOM_DIFFUSE, 0 );
    check_variance( ROOM_DIFFUSE, 1 );
    check_variance( ROOM_PHONG, 2 );
}

TEST( test_same_bits_however_the_frames_come_about )
{
    static const int groups[] = { 0, 1, 20 };
    Stage stage;
    open_stage( &stage, make_room( ROOM_GGX ), EYES, 4.0f, WIDTH, HEIGHT );
    for ( int g = 0; g < 3; ++g )
    {
        RfRenderSettings settings = layered( groups[g], 5 );
        settings.filter = g == 1 ? RF_FILTER_BLACKMAN_HARRIS : RF_FILTER_BOX;
        const RfFrameResult* whole = render_some( &stage, 0, EYES, &settings );
        size_t peak = stage.stats.peak_bytes;
        settings.threads = 3;
        settings.queue = 2;
        const RfFrameResult* threads = render_some( &stage, 0, EYES, &settings );
        settings.threads = 1;
        settings.memory = peak - peak / 16;
        const RfFrameResult* small = render_some( &stage, 0, EYES, &settings );
        assert_true( stage.stats.peak_bytes <= settings.memory );
        settings.memory = 0;
        settings.aovs = RF_PASS_AOVS; // of which the picture is the sum
        const RfFrameResult* passes = render_some( &stage, 0, EYES, &settings );
        settings.aovs = 0;
        const RfFrameResult* without = render_some( &stage, 0, EYES, &settings );
        for ( int k = 0; k < EYES; ++k )
        {
            expect_same_bits( whole + k, threads + k );
            expect_same_bits( whole + k, small + k );
            assert_memory_equal( whole[k].rgb, passes[k].rgb, (size_t)PIXELS * 3 * sizeof( float ) );
            expect_sum( "room", "the picture", ( const float* const[] ){ whole[k].rgb }, 1, without[k].rgb, 3 * PIXELS, 1e-5,
                        brightness( without[k].rgb, 3 * PIXELS ) );
            for ( int l = 0; l < RF_AOV_COUNT; ++l )
                assert_null( without[k].aovs[l] );
        }
        settings.aovs = REUSE_AOVS;
        const RfFrameResult* alone = render_some( &stage, 4, 1, &settings );
        expect_same_bits( whole + 4, alone );
        settings.aovs = RF_AOV_BIT( RF_AOV_DEPTH );
        const RfFrameResult* one = render_some( &stage, 4, 1, &settings );
        assert_memory_equal( whole[4].aovs[RF_AOV_DEPTH], one[0].aovs[RF_AOV_DEPTH], (size_t)PIXELS * sizeof( float ) );
        assert_null( one[0].aovs[RF_AOV_ALBEDO] );
    }
    close_stage( &stage );
}

// Each AOV alone, or with the passes, of which the picture is the sum, is what it is among all of them, and none is empty: so a new row
// of RF_AOV_LIST that nothing fills is found.
TEST( test_each_alone_is_as_among_all )
{
    Stage stage;
    open_stage( &stage, make_glass_room(), 3, 4.0f, 24, 18 );
    RfScene* scene = &stage.scene;
    scene->nodes = calloc( 1, sizeof *scene->nodes ); // one, which all surfaces are of
    scene->node_count = 1;
    scene->nodes[0].parent = -1;
    scene->node_runs = malloc( sizeof *scene->node_runs );
    scene->node_runs[0] = ( RfNodeRun ){ 0, 1 };
    scene->node_run_count = 1;
    RfRenderSettings settings = layered( 1, 6 );
    settings.aovs = REUSE_AOVS;
    const RfFrameResult* all = render_some( &stage, 1, 1, &settings );
    for ( int a = 0; a < RF_AOV_PRIMAL; ++a ) // those of gradients are tested with these
    {
        settings.aovs = RF_AOV_BIT( a );
        settings.aovs |= a == RF_AOV_VARIANCE || a == RF_AOV_HALF || a == RF_AOV_REMOVED ? RF_PASS_AOVS : 0;
        const RfFrameResult* alone = render_some( &stage, 1, 1, &settings );
        size_t count = (size_t)( alone->width * alone->height * rf_aov_channels( (RfAov)a ) );
        assert_memory_equal( alone[0].aovs[a], all[0].aovs[a], count * sizeof( float ) );
        double sum = 0.0;
        for ( size_t i = 0; i < count; ++i )
            sum += fabs( (double)alone[0].aovs[a][i] );
        assert_true( sum > 0.0 || a == RF_AOV_EMISSION ); // there is no lamp in view
    }
    close_stage( &stage );
}

TEST( test_budget_counts_aov_films )
{
    Stage stage;
    RfError error;
    open_stage( &stage, make_room( ROOM_DIFFUSE ), EYES, 4.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = layered( 1, 3 ); // one pass of each group: no more batches at once without AOVs
    settings.aovs &= ~( RF_AOV_BIT( RF_AOV_OBJECT_INDEX ) | RF_AOV_BIT( RF_AOV_MATERIAL_INDEX ) |
                        RF_PASS_AOVS ); // whose records are larger, too
    render_some( &stage, 0, EYES, &settings );
    size_t with = stage.stats.peak_bytes;
    settings.aovs = 0;
    render_some( &stage, 0, EYES, &settings );
    // three films of 19 floats, one image of 28, and the features of a batch
    size_t more = WIDTH * HEIGHT * ( 3 * 19 + 28 ) * sizeof( float ) + sizeof( RfFeatures );
    size_t difference = with - stage.stats.peak_bytes;
    assert_true( difference >= more && difference < more + 4096 );
    settings.aovs = REUSE_AOVS;
    int failures = 0;
    for ( size_t memory = 1000; memory < with; memory = memory * 5 / 4 )
    {
        RfRenderStats stats;
        settings.memory = memory; // fails at every allocation once
        RfResult result =
            rf_render( &( RfShot ){ stage.tracer, stage.eyes, EYES, &( int ){ 0 }, 1 }, &settings, NULL, &stats, &error );
        assert_true( result == RF_OK || result == RF_ERROR_MEMORY );
        assert_true( stats.peak_bytes <= memory );
        failures += result != RF_OK;
    }
    assert_true( failures > 5 );
    settings.memory = 0;
    settings.aovs = RF_AOV_BIT( RF_AOV_COUNT );
    assert_int_equal( rf_render( &( RfShot ){ stage.tracer, stage.eyes, EYES, &( int ){ 0 }, 1 }, &settings, NULL, NULL, &error ),
                      RF_ERROR_USAGE );
    close_stage( &stage );
}
