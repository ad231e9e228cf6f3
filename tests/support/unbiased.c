#include "support/test.h"
#include "support/unbiased.h"

#include "support/reference_tracer.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "trace/trace.h"

#include <omp.h>

#define REFERENCE_SEED 1000003 // far from the seeds of the renders

static float* alloc_image( const RfEye* eye )
{
    float* rgb = malloc( 3 * (size_t)eye->width * (size_t)eye->height * sizeof( float ) );
    if ( rgb == NULL )
        abort();
    return rgb;
}

static Images reference_of( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings,
                            bool panes_are_vertices, bool without_caustics )
{
    Images images = { .width = eyes->width, .height = eyes->height, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
        images.rgb[k] = alloc_image( eyes );
#pragma omp parallel for schedule( dynamic, 1 )
    for ( int k = 0; k < SEEDS; ++k )
    {
        ReferenceSettings plain = {
            .spp = spp,
            .max_depth = settings->max_depth,
            .light_samples = settings->light_samples,
            .seed = (uint64_t)( REFERENCE_SEED + k ),
            .frame = frame,
            .light_sampling = settings->light_sampling,
            .panes_are_vertices = panes_are_vertices,
            .without_caustics = without_caustics,
        };
        reference_image( tracer, eyes + frame, &plain, images.rgb[k] );
    }
    return images;
}

Images reference_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings )
{
    return reference_of( tracer, eyes, frame, spp, settings, false, false );
}

Images caustic_free_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings )
{
    return reference_of( tracer, eyes, frame, spp, settings, false, true );
}

Images pane_vertex_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings )
{
    return reference_of( tracer, eyes, frame, spp, settings, true, false );
}

Images rendered_images( const RfTracer* tracer, const RfEye* eyes, int eye_count, int frame, RfRenderSettings settings )
{
    Images images = { .width = eyes->width, .height = eyes->height, .count = SEEDS };
    int helped = 0;
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = (uint64_t)( k + 1 );
        Rendered rendered = render_frames( tracer, eyes, eye_count, &frame, 1, &settings );
        helped += rendered.stats.adaptive_frames;
        images.rgb[k] = alloc_image( eyes );
        memcpy( images.rgb[k], rendered.rgb, 3 * rendered.pixels * sizeof( float ) );
        free_rendered( &rendered );
    }
    assert_true( settings.adaptive != RF_ADAPTIVE_ON || helped > 0 ); // else nothing was tested
    return images;
}

void free_images( Images* images )
{
    for ( int k = 0; k < images->count; ++k )
        free( images->rgb[k] );
    *images = ( Images ){ 0 };
}

static double block_mean( const Images* images, int k, int x0, int y0, int x1, int y1 )
{
    double sum = 0.0;
    for ( int y = y0; y < y1; ++y )
    {
        for ( int x = x0; x < x1; ++x )
        {
            const float* p = images->rgb[k] + 3 * ( (size_t)y * (size_t)images->width + (size_t)x );
            sum += 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
        }
    }
    return sum / ( ( x1 - x0 ) * ( y1 - y0 ) );
}

// Both samples are one number but for the rounding of film sums (n·2⁻²⁵ after n
// passes): sky, black. Nothing is left to a test, and its p would be no draw.
static bool are_constant( const double* a, int count_a, const double* b, int count_b )
{
    double low = a[0], high = a[0];
    for ( int k = 0; k < count_a + count_b; ++k )
    {
        double v = k < count_a ? a[k] : b[k - count_a];
        low = v < low ? v : low;
        high = v > high ? v : high;
    }
    return high - low <= 3e-5 * fabs( high );
}

// Of the means of a block. Where there is nothing to test their count is 0.
static void block_samples( const Images* a, const Images* b, int x0, int y0, int x1, int y1, Sample* of_a, Sample* of_b )
{
    double va[SEEDS] = { 0 }, vb[SEEDS] = { 0 };
    for ( int k = 0; k < a->count; ++k )
        va[k] = block_mean( a, k, x0, y0, x1, y1 );
    for ( int k = 0; k < b->count; ++k )
        vb[k] = block_mean( b, k, x0, y0, x1, y1 );
    *of_a = sample_of( va, a->count );
    *of_b = sample_of( vb, b->count );
    if ( are_constant( va, a->count, vb, b->count ) )
        of_a->count = of_b->count = 0;
}

static Verdict whole_verdict( const Images* a, const Images* b )
{
    Sample of_a, of_b;
    block_samples( a, b, 0, 0, a->width, a->height, &of_a, &of_b );
    return ( Verdict ){
        .whole_off = of_a.mean / of_b.mean - 1.0,
        .whole_error = sqrt( of_a.variance + of_b.variance ) / of_b.mean,
        .whole_p = of_a.count > 0 ? welch_of( of_a, of_b ) : -1.0,
    };
}

Verdict compare_images( const char* what, const Images* a, const Images* b, int block )
{
    int across = ( a->width + block - 1 ) / block, down = ( a->height + block - 1 ) / block, count = across * down;
    Sample *of_a = malloc( (size_t)count * sizeof *of_a ), *of_b = malloc( (size_t)count * sizeof *of_b );
    double* p = malloc( (size_t)count * sizeof *p );
    if ( p == NULL || of_a == NULL || of_b == NULL )
        abort();
    for ( int i = 0; i < count; ++i )
    {
        int x0 = i % across * block, y0 = i / across * block;
        int x1 = x0 + block < a->width ? x0 + block : a->width, y1 = y0 + block < a->height ? y0 + block : a->height;
        block_samples( a, b, x0, y0, x1, y1, of_a + i, of_b + i );
    }
    int tested = 0;
    double smallest = 1.0;
    for ( int i = 0; i < count; ++i )
    {
        if ( of_a[i].count == 0 )
            continue;
        double here = place_p( of_a, of_b, across, down, i );
        smallest = fmin( smallest, here );
        p[tested++] = welch_of( of_a[i], of_b[i] );
        if ( what != NULL && block > 1 && here < FIRST_LEVEL )
            printf( "%s block %d,%d is off by %.2f %%, p %.2g\n", what, i % across * block, i / across * block,
                    100.0 * ( of_a[i].mean / of_b[i].mean - 1.0 ), here );
    }
    if ( tested == 0 )
        abort(); // a test of nothing
    Verdict v = whole_verdict( a, b );
    v.uniform_p = uniform_p( p, tested );
    v.smallest_p = 1.0 - pow( 1.0 - smallest, tested );
    free( of_a );
    free( of_b );
    free( p );
    return v;
}

void assert_unbiased( const char* what, const Images* rendered, const Images* reference, int block )
{
    Verdict b = compare_images( what, rendered, reference, block ), p = compare_images( what, rendered, reference, 1 );
    printf( "%-34s whole %+.3f %% ± %.3f %%, p %.3g, per block smallest p %.3g, uniform p %.3g; per pixel smallest p %.3g\n",
            what, 100.0 * b.whole_off, 100.0 * b.whole_error, b.whole_p, b.smallest_p, b.uniform_p, p.smallest_p );
    assert_true( is_likely( b.whole_p ) );
    assert_true( is_likely( b.smallest_p ) );
    assert_true( is_likely( b.uniform_p ) );
    assert_true( is_likely( p.smallest_p ) );
}

// ---- chain checks ----

#define BLOCK 4
#define PIXELS ( CHAIN_WIDTH * CHAIN_HEIGHT )
#define REFERENCE_SPP 24 // of frames that are tested by block and pixel
#define REFERENCE_SPP_REST 12
#define FRAMES 3
#define MIDDLE 1          // of the frames
#define SHARP_ALPHA 0.01f // GGX lobes that count as nearly specular

static const int s_frames[FRAMES] = { 1, 3, 5 };

const ChainSetting g_all_reuse[4] = {
    { .group = 0, .tile = "3x3", .spp = 6 },
    { .group = 1, .tile = "1", .spp = 6 },
    { .group = 3, .tile = "1", .spp = 7 },
    { .group = 3, .tile = "3x3", .spp = 7 },
};
const ChainSetting g_tiles_and_both[2] = { { .group = 0, .tile = "3x3", .spp = 6 }, { .group = 3, .tile = "3x3", .spp = 7 } };
const ChainSetting g_adaptive[1] = {
    { .group = 3, .tile = "3x3", .spp = 7, .adaptive = true },
};
const ChainSetting g_connected[2] = {
    { .group = 0, .tile = "1", .spp = 3, .connected = true },
    { .group = 1, .tile = "3x3", .spp = 3, .connected = true },
};

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static int samples( int spp ) { return is_long() ? 4 * spp : spp; }

ChainCase chain_case( const char* what, int max_depth )
{
    ChainCase c = { .what = what, .max_depth = max_depth, .settings = g_tiles_and_both, .setting_count = 2 };
    orbit_eyes( c.eyes, CHAIN_EYES, 3.0f, CHAIN_WIDTH, CHAIN_HEIGHT );
    return c;
}

static bool is_sharp( const RfMaterial* m )
{
    if ( m->kind == RF_BSDF_COATED )
        return m->clearcoat_alpha < SHARP_ALPHA;
    return m->kind >= RF_BSDF_FIRST_SPECULAR || ( m->kind == RF_BSDF_GGX && m->alpha < SHARP_ALPHA );
}

// Marks the pixels whose centres see a mirror, glass or a sharp lobe. Returns how many.
static int mark_sharp( const RfTracer* tracer, const RfEye* eye, bool* marked )
{
    int count = 0;
    for ( int i = 0; i < PIXELS; ++i )
    {
        float fx = ( (float)( i % CHAIN_WIDTH ) + 0.5f - 0.5f * CHAIN_WIDTH ) / eye->focal;
        float fy = ( 0.5f * CHAIN_HEIGHT - (float)( i / CHAIN_WIDTH ) - 0.5f ) / eye->focal;
        RfVec3 d = rf_normalize( rf_madd( rf_madd( eye->forward, eye->right, fx ), eye->up, fy ) );
        const float* o_in[3] = { &eye->origin.x, &eye->origin.y, &eye->origin.z };
        const float* d_in[3] = { &d.x, &d.y, &d.z };
        uint32_t triangle;
        float u, v;
        rf_trace_nearest( tracer, 1, o_in, d_in, true, &triangle, &u, &v );
        marked[i] =
            triangle != RF_MISS && is_sharp( rf_tracer_scene( tracer )->materials + rf_triangle_material( tracer, triangle ) );
        count += marked[i];
    }
    return count;
}

// Independent images of the frames that are tested.
typedef struct FrameImages
{
    Images frame[FRAMES];
} FrameImages;

static void free_frames( FrameImages* images )
{
    for ( int f = 0; f < FRAMES; ++f )
        free_images( images->frame + f );
}

static FrameImages reference_frames( const ChainCase* c, const RfTracer* tracer, const RfRenderSettings* settings )
{
    FrameImages images;
    for ( int f = 0; f < FRAMES; ++f )
    {
        int spp = c->every_frame || f == MIDDLE ? REFERENCE_SPP : REFERENCE_SPP_REST;
        images.frame[f] = reference_images( tracer, c->eyes, s_frames[f], samples( spp ), settings );
    }
    return images;
}

static bool has_dispersion( const RfScene* scene )
{
    bool any = false;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        any = any || scene->materials[i].dispersion > 0.0f;
    return any;
}

// Glass without dispersion that has the index of one channel (KHR_materials_dispersion). `glass` is as the scene has it.
static void make_monochrome( const RfMaterial* glass, int channel, RfMaterial* out )
{
    if ( !( glass->dispersion > 0.0f ) )
        return;
    out->kind = RF_BSDF_GLASS;
    out->ior = glass->ior + (float)( channel - 1 ) * ( glass->ior - 1.0f ) * 0.025f * glass->dispersion;
    out->dispersion = 0.0f;
}

static void keep_channel( const FrameImages* from, int channel, FrameImages* to )
{
    for ( int f = 0; f < FRAMES; ++f )
    {
        for ( int i = 0; i < SEEDS * PIXELS; ++i )
            to->frame[f].rgb[i / PIXELS][3 * ( i % PIXELS ) + channel] =
                from->frame[f].rgb[i / PIXELS][3 * ( i % PIXELS ) + channel];
    }
}

// With dispersion: each channel of three scenes of other glass.
static FrameImages reference_channels( const ChainCase* c, RfScene* scene, const RfRenderSettings* settings )
{
    RfMaterial* own = malloc( scene->material_count * sizeof *own );
    FrameImages images = { 0 };
    for ( int channel = 0; channel < 3 && own != NULL; ++channel )
    {
        memcpy( own, scene->materials, scene->material_count * sizeof *own );
        for ( uint32_t i = 0; i < scene->material_count; ++i )
            make_monochrome( own + i, channel, scene->materials + i );
        RfTracer* tracer = make_tracer( scene );
        FrameImages one = reference_frames( c, tracer, settings );
        memcpy( scene->materials, own, scene->material_count * sizeof *own );
        rf_destroy_tracer( tracer );
        if ( channel == 0 )
            images = one;
        else
        {
            keep_channel( &one, channel, &images );
            free_frames( &one );
        }
    }
    free( own );
    return images;
}

// From 0 on and far below those of the references; a different one for each case, so that one unlucky set of
// random numbers is not in all of them. FNV-1a of the name.
static uint64_t first_seed( const char* what )
{
    uint32_t hash = 2166136261u;
    for ( ; *what != '\0'; ++what )
        hash = ( hash ^ (uint8_t)*what ) * 16777619u;
    return hash % 50000u * SEEDS;
}

// By the renderer, which renders the frames together.
static FrameImages rendered_frames( const ChainCase* c, const RfTracer* tracer, RfRenderSettings settings )
{
    FrameImages images;
    for ( int f = 0; f < FRAMES; ++f )
        images.frame[f] = ( Images ){ .width = CHAIN_WIDTH, .height = CHAIN_HEIGHT, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = first_seed( c->what ) + (uint64_t)k;
        Rendered r = render_frames( tracer, c->eyes, CHAIN_EYES, s_frames, FRAMES, &settings );
        for ( int f = 0; f < FRAMES; ++f )
        {
            size_t bytes = 3 * r.pixels * sizeof( float );
            float* rgb = images.frame[f].rgb[k] = malloc( bytes );
            if ( rgb == NULL )
                abort();
            memcpy( rgb, frame_rgb( &r, f ), bytes );
        }
        free_rendered( &r );
    }
    return images;
}

// The pixels that are looked at together.
typedef struct Marked
{
    bool pixel[FRAMES][PIXELS];
    int count;
} Marked;

static void marked_means( const FrameImages* images, const Marked* marked, double means[SEEDS] )
{
    for ( int k = 0; k < SEEDS; ++k )
    {
        means[k] = 0.0;
        for ( int i = 0; i < FRAMES * PIXELS; ++i )
        {
            const float* p = images->frame[i / PIXELS].rgb[k] + 3 * ( i % PIXELS );
            double value = 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
            means[k] += marked->pixel[i / PIXELS][i % PIXELS] ? value / marked->count : 0.0;
        }
    }
}

// Welch's test of the mean over the marked pixels. Prints the relative error of their difference, of which
// a bias of some five is found.
static void assert_marked_unbiased( const FrameImages* rendered, const FrameImages* reference, const Marked* marked )
{
    double a[SEEDS], b[SEEDS], error_a, error_b;
    marked_means( rendered, marked, a );
    marked_means( reference, marked, b );
    double mean = mean_of( a, SEEDS, &error_a ), expected = mean_of( b, SEEDS, &error_b ), p = welch_p( a, SEEDS, b, SEEDS );
    printf( "    %2d %% of the pixels: off by %.2f %% ± %.2f %%, p %.3g\n", 100 * marked->count / ( FRAMES * PIXELS ),
            100.0 * ( mean / expected - 1.0 ), 100.0 * sqrt( error_a * error_a + error_b * error_b ) / expected, p );
    assert_true( is_likely( p ) );
}

static void check_setting( const ChainCase* c, const RfTracer* tracer, RfRenderSettings settings, const ChainSetting* s,
                           const FrameImages* reference, const Marked* marked )
{
    settings.group = s->group;
    settings.spp = samples( s->spp );
    settings.adaptive = s->adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
    settings.light_paths = s->connected ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
    assert_true( rf_parse_tile( s->tile, &settings.tile ) );
    FrameImages rendered = rendered_frames( c, tracer, settings );
    for ( int f = 0; f < FRAMES; ++f )
    {
        char name[96], number[16] = "";
        if ( c->every_frame )
            snprintf( number, sizeof number, ", frame %d", s_frames[f] );
        snprintf( name, sizeof name, "%s%s, group %d tile %s%s%s:", c->what, number, s->group, s->tile,
                  s->adaptive ? ", adaptive" : "", s->connected ? ", connected" : "" );
        if ( c->every_frame || f == MIDDLE )
            assert_unbiased( name, rendered.frame + f, reference->frame + f, BLOCK );
    }
    assert_marked_unbiased( &rendered, reference, marked );
    free_frames( &rendered );
}

void check_chains( const ChainCase* c, RfScene scene )
{
    static Marked marked;
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = plain_settings();
    settings.max_depth = c->max_depth;
    settings.memory = (size_t)256 << 20;
    marked.count = 0;
    for ( int f = 0; f < FRAMES; ++f )
        marked.count += mark_sharp( tracer, c->eyes + s_frames[f], marked.pixel[f] );
    assert_true( marked.count > 0 );
    FrameImages reference =
        has_dispersion( &scene ) ? reference_channels( c, &scene, &settings ) : reference_frames( c, tracer, &settings );
    for ( int k = 0; k < c->setting_count; ++k )
        check_setting( c, tracer, settings, c->settings + k, &reference, &marked );
    for ( int k = 0; is_long() && c->settings != g_all_reuse && k < 4; ++k )
        check_setting( c, tracer, settings, g_all_reuse + k, &reference, &marked );
    free_frames( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}
