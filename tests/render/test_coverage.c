// Cryptomatte's coverages: by their means those that rays from the camera count, with and without reuse, filters, mirrors, panes,
// lenses and what moves; they add up to alpha, and are the same however the frames come about.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"

#include "base/random.h"
#include "film/cryptomatte.h"
#include "film/pixel_filter.h"
#include "scene/lens.h"
#include "scene/projection.h"
#include "scene/placement.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EYES 5
#define FRAME 2
#define WIDTH 32
#define HEIGHT 24
#define PIXELS ( WIDTH * HEIGHT )
#define SEEDS 8
#define BLOCK 8
#define BLOCKS ( PIXELS / ( BLOCK * BLOCK ) )
#define MOST 40 // names
#define RAYS 64 // of each pixel and seed

static const RfFrameResult* render( Stage* stage, RfRenderSettings settings )
{
    settings.cryptomatte = RF_CRYPTOMATTE_OBJECT;
    const RfFrameResult* p = render_one( stage, FRAME, &settings );
    assert_int_equal( p->layer_count, 3 );
    for ( int k = 0; k < 3; ++k )
        assert_string_equal( p->layers[k].name, g_rf_cryptomatte_kinds[0].layers[k] );
    return p;
}

static RfRenderSettings settings_of( int group, int spp, const char* tile, RfFilter filter )
{
    RfRenderSettings settings = tiled_settings( group, spp, tile );
    settings.adaptive = RF_ADAPTIVE_OFF;
    settings.filter = filter;
    settings.filter_width = rf_default_filter_width( filter );
    return settings;
}

// Coverages by name and pixel.
typedef struct Mattes
{
    int count;
    uint32_t id[MOST];
    double coverage[MOST][PIXELS];
} Mattes;

static int place_of( Mattes* m, uint32_t id )
{
    int k = 0;
    while ( k < m->count && m->id[k] != id )
        ++k;
    assert_true( k < MOST );
    m->id[k] = id;
    m->count += k == m->count;
    return k;
}

// Clears the coverages; the names keep their places.
static void clear( Mattes* m ) { memset( m->coverage, 0, sizeof m->coverage ); }

static void decode( const RfFrameResult* p, Mattes* m )
{
    clear( m );
    for ( int i = 0; i < PIXELS; ++i )
    {
        double before = 1.0 + 1e-6, sum = 0.0;
        for ( int rank = 0; rank < 6; ++rank )
        {
            const float* at = p->layers[rank / 2].values + 4 * i + 2 * ( rank % 2 );
            uint32_t id;
            memcpy( &id, at, sizeof id );
            assert_true( (double)at[1] <= before && ( id != 0 ) == ( at[1] > 0.0f ) );
            before = (double)at[1];
            sum += (double)at[1];
            if ( id != 0 )
                m->coverage[place_of( m, id )][i] += (double)at[1];
        }
        assert_true( sum <= 1.0 + 1e-5 );
    }
}

// What a ray of the camera hits, through a place of a pixel.
static uint32_t id_at( const RfTracer* tracer, const RfEye* eye, int x, int y, float u, float v )
{
    const float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    RfVec3 o, d;
    uint32_t triangle;
    float a, b;
    rf_eye_ray( eye, inverse, x, y, u, v, &o, &d );
    rf_trace_nearest( tracer, 1, ( const float*[] ){ &o.x, &o.y, &o.z }, ( const float*[] ){ &d.x, &d.y, &d.z }, false, &triangle,
                      &a, &b );
    const RfScene* scene = rf_tracer_scene( tracer );
    return triangle != RF_MISS ? rf_cryptomatte_id( rf_object_name( scene, rf_node_of_triangle( scene, triangle ) ) ) : 0;
}

// Counts rays, by the filter.
static void count_rays( const RfTracer* tracer, const RfEye* eye, const RfRenderSettings* settings, int seed, Mattes* m )
{
    static double all[PIXELS];
    RfPixelFilter filter;
    bool plain = rf_is_plain_filter( settings );
    rf_make_pixel_filter( settings, &filter );
    memset( all, 0, sizeof all );
    clear( m );
    for ( int i = 0; i < PIXELS * RAYS; ++i )
    {
        RfRandomKey key =
            rf_pixel_key( rf_pass_key( 77, (uint32_t)seed, 0, (uint32_t)( i / PIXELS ) ), (uint32_t)( i % PIXELS ) );
        int x = i % WIDTH, y = i % PIXELS / WIDTH, reach = plain ? 0 : filter.reach;
        float u = rf_random( key, 0 ), v = rf_random( key, 1 ), across[RF_FILTER_TAPS] = { 1 }, down[RF_FILTER_TAPS] = { 1 };
        RfEye at = rf_sample_eye( eye, ( RfLensSample ){ rf_random( key, 2 ), rf_random( key, 3 ), rf_random( key, 4 ) } );
        uint32_t id = id_at( tracer, &at, x, y, u, v );
        int place = id != 0 ? place_of( m, id ) : -1;
        if ( !plain )
        {
            rf_filter_weights( &filter, x, u, WIDTH, across );
            rf_filter_weights( &filter, y, v, HEIGHT, down );
        }
        for ( int k = 0; k < ( 2 * reach + 1 ) * ( 2 * reach + 1 ); ++k )
        {
            int px = x + k % ( 2 * reach + 1 ) - reach, py = y + k / ( 2 * reach + 1 ) - reach;
            if ( px < 0 || px >= WIDTH || py < 0 || py >= HEIGHT )
                continue;
            double weight = (double)across[px - x + reach] * (double)down[py - y + reach];
            all[py * WIDTH + px] += weight;
            if ( place >= 0 )
                m->coverage[place][py * WIDTH + px] += weight;
        }
    }
    for ( int k = 0; k < m->count; ++k )
    {
        for ( int i = 0; i < PIXELS; ++i )
            m->coverage[k][i] /= all[i];
    }
}

// By name: blocks of the picture, then the whole of it.
typedef double Blocks[MOST][BLOCKS + 1][SEEDS];

static void add_to_blocks( const Mattes* m, int seed, Blocks blocks )
{
    for ( int k = 0; k < m->count; ++k )
    {
        for ( int b = 0; b <= BLOCKS; ++b )
            blocks[k][b][seed] = 0.0;
        for ( int i = 0; i < PIXELS; ++i )
        {
            int block = i / WIDTH / BLOCK * ( WIDTH / BLOCK ) + i % WIDTH / BLOCK;
            blocks[k][block][seed] += m->coverage[k][i] / ( BLOCK * BLOCK );
            blocks[k][BLOCKS][seed] += m->coverage[k][i] / PIXELS;
        }
    }
}

// `still`: the scene as it is in the frame.
static void check( const char* what, Stage* stage, Stage* still, RfRenderSettings settings )
{
    static Mattes mattes;
    static Blocks rendered, counted;
    mattes.count = 0;
    memset( rendered, 0, sizeof rendered );
    memset( counted, 0, sizeof counted );
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = (uint64_t)k + 1;
        decode( render( stage, settings ), &mattes );
        add_to_blocks( &mattes, k, rendered );
        count_rays( stage_tracer( still ), stage->eyes + FRAME, &settings, k, &mattes );
        add_to_blocks( &mattes, k, counted );
    }
    double least = 1.0, error, bias = 0.0;
    int compared = 0;
    for ( int k = 0; k < mattes.count; ++k )
    {
        for ( int b = 0; b <= BLOCKS; ++b )
        {
            double mean = mean_of( counted[k][b], SEEDS, &error ), own = mean_of( rendered[k][b], SEEDS, &error );
            if ( mean < 0.002 ) // few rays count it
                continue;
            compared += 1;
            least = fmin( least, welch_p( rendered[k][b], SEEDS, counted[k][b], SEEDS ) );
            bias = b == BLOCKS ? fmax( bias, fabs( own - mean ) ) : bias;
        }
    }
    printf( "%s: %d names, %d means, least p %.2g, a share of the picture is off by %.2g at most\n", what, mattes.count, compared,
            least, bias );
    assert_true( compared > 20 );
    assert_true( least * compared > 1e-4 && bias < 2e-3 );
}

// Names quads and other bodies of a scene that has no nodes: a node for each two triangles of materials of few, one for each of the
// others.
static void name_surfaces( RfScene* scene )
{
    scene->nodes = calloc( 64, sizeof *scene->nodes );
    const RfTriangles* t = &scene->triangles;
    uint32_t first = 0, count = t->count;
    scene->triangles.count = 0; // as a reader appends them
    while ( first < count )
    {
        uint32_t end = first + 1;
        while ( end < count && t->material[end] == t->material[first] )
            ++end;
        end = end - first <= 16 && first + 2 <= end ? first + 2 : end;
        char name[16];
        int node = scene->node_count < 34 ? scene->node_count++ : 33;
        snprintf( name, sizeof name, "part %d", node );
        if ( scene->nodes[node].name == NULL )
            scene->nodes[node].name = strdup( name );
        scene->nodes[node].parent = -1;
        scene->triangles.count = first;
        assert_true( rf_begin_node_run( scene, node ) );
        first = end;
    }
    scene->triangles.count = count;
}

static void check_room( const char* what, RfScene scene, float degrees, RfRenderSettings settings )
{
    Stage stage;
    open_stage( &stage, scene, EYES, degrees, WIDTH, HEIGHT );
    name_surfaces( &stage.scene );
    check( what, &stage, &stage, settings );
    close_stage( &stage );
}

TEST( test_mean_is_what_rays_hit )
{
    check_room( "path tracing", make_room( ROOM_DIFFUSE ), 4.0f, settings_of( 0, 8, "1", RF_FILTER_BOX ) );
    check_room( "tiles", make_room( ROOM_GGX ), 4.0f, settings_of( 0, 8, "3x3", RF_FILTER_BLACKMAN_HARRIS ) );
    check_room( "group", make_room( ROOM_DIFFUSE ), 4.0f, settings_of( 2, 10, "1", RF_FILTER_BOX ) );
    check_room( "group, tiles, filter", make_room( ROOM_GGX ), 4.0f, settings_of( 2, 10, "3x3", RF_FILTER_BLACKMAN_HARRIS ) );
    RfRenderSettings adaptive = settings_of( 2, 10, "3x3", RF_FILTER_BLACKMAN_HARRIS );
    adaptive.adaptive = RF_ADAPTIVE_ON;
    check_room( "extra samples", make_room( ROOM_GGX ), 15.0f, adaptive );
}

// What a mirror or a pane shows counts for it, through which part of it another camera of the group sees it as well.
TEST( test_mirrors_panes_and_coats )
{
    static const struct
    {
        const char* name;
        MirrorRoom kind;
    } s_rooms[] = { { "flat mirror", FLAT_MIRROR }, { "mirror of many triangles", L_SHAPED_MIRROR },
                    { "panes", PANES_IN_A_ROW },    { "mirror behind a pane", MIRROR_BEHIND_PANE },
                    { "glass ball", GLASS_BALL },   { "coat", CLEAR_COAT },
                    { "blended", BLENDED_SCREENS }, { "sharp plastic", SMOOTH_PLASTIC } };
    for ( size_t i = 0; i < sizeof s_rooms / sizeof s_rooms[0]; ++i )
    {
        check_room( s_rooms[i].name, make_mirror_room( s_rooms[i].kind ), 6.0f,
                    settings_of( 2, 10, "3x3", i % 2 == 0 ? RF_FILTER_BLACKMAN_HARRIS : RF_FILTER_BOX ) );
    }
    check_room( "panes without chains", make_mirror_room( PANES_IN_A_ROW ), 6.0f, settings_of( 0, 8, "1", RF_FILTER_BOX ) );
}

TEST( test_what_moves )
{
    Stage room, frame;
    open_moving_stage( &room, "sweep", WIDTH, HEIGHT );
    open_still_stage( &frame, "sweep", FRAME, WIDTH, HEIGHT );
    for ( int n = 0; n < room.scene.node_count; ++n ) // of the same order, but other names
    {
        free( room.scene.nodes[n].name );
        room.scene.nodes[n].name = strdup( frame.scene.nodes[n].name );
    }
    check( "sweep", &room, &frame, settings_of( 2, 10, "3x3", RF_FILTER_BLACKMAN_HARRIS ) );
    close_stage( &room );
    close_stage( &frame );
}

TEST( test_lens_and_shutter )
{
    Stage stage;
    open_stage( &stage, make_room( ROOM_GGX ), EYES, 4.0f, WIDTH, HEIGHT );
    name_surfaces( &stage.scene );
    for ( int k = 0; k < EYES; ++k )
    {
        RfEye *eye = stage.eyes + k, open = *eye, close = open;
        close.origin.y += 0.1f;
        rf_set_shutter( eye, &open, &close );
        eye->lens_radius = 0.08f;
        eye->focus = 1.5f;
    }
    check( "lens and shutter", &stage, &stage, settings_of( 2, 10, "3x3", RF_FILTER_BLACKMAN_HARRIS ) );
    close_stage( &stage );
}

// Over the sky, by the ratio of weights of either, coverages add up to alpha; cross-fitted alpha has the same mean. Any number of
// threads gives the same bits, and the index is that of the first rank.
TEST( test_coverages_add_up_to_alpha )
{
    Stage stage;
    open_stage( &stage, make_open_scene( LIT_BY_SKY ), EYES, 0.0f, WIDTH, HEIGHT );
    name_surfaces( &stage.scene );
    for ( int i = 0; i < EYES; ++i )
        stage.eyes[i] = rf_make_eye( rf_vec3( 0.2f * (float)( i - EYES / 2 ), 1.2f, 4.5f ), rf_vec3( 0, -0.05f, -1 ),
                                     rf_vec3( 0, 1, 0 ), 0.7, WIDTH, HEIGHT );
    for ( int k = 0; k < 4; ++k )
    {
        RfRenderSettings settings =
            settings_of( k < 2 ? 0 : 2, 10, "3x3", k % 2 == 0 ? RF_FILTER_BOX : RF_FILTER_BLACKMAN_HARRIS );
        settings.normalize = RF_NORMALIZE_RATIO;
        settings.aovs = RF_AOV_BIT( RF_AOV_ALPHA ) | RF_AOV_BIT( RF_AOV_OBJECT_INDEX );
        const RfFrameResult* p = render( &stage, settings );
        settings.threads = 2;
        settings.normalize = RF_NORMALIZE_CROSSFIT;
        const RfFrameResult* q = render( &stage, settings );
        for ( int k = 0; k < 3; ++k )
            assert_memory_equal( p->layers[k].values, q->layers[k].values, 4 * PIXELS * sizeof( float ) );
        assert_memory_equal( p->aovs[RF_AOV_OBJECT_INDEX], q->aovs[RF_AOV_OBJECT_INDEX], PIXELS * sizeof( float ) );
        double most = 0.0, difference = 0.0;
        for ( int i = 0; i < PIXELS; ++i )
        {
            double sum = 0.0, first = (double)p->layers[0].values[4 * i + 1];
            for ( int rank = 0; rank < 6; ++rank )
                sum += (double)p->layers[rank / 2].values[4 * i + 2 * ( rank % 2 ) + 1];
            most = fmax( most, fabs( sum - (double)p->aovs[RF_AOV_ALPHA][i] ) );
            difference += ( sum - (double)q->aovs[RF_AOV_ALPHA][i] ) / PIXELS;
            uint32_t id;
            int index = (int)p->aovs[RF_AOV_OBJECT_INDEX][i];
            memcpy( &id, p->layers[0].values + 4 * i, sizeof id );
            assert_true( index == 0 ? first <= 0.5 : id == rf_cryptomatte_id( rf_object_name( &stage.scene, index - 1 ) ) );
        }
        printf( "add up to alpha within %.2g, in the mean %.2g from that of cross-fitting\n", most, fabs( difference ) );
        assert_true( most < 1e-5 && fabs( difference ) < 2e-3 );
    }
    close_stage( &stage );
}
