#include "support/render_support.h"

#include "render_support.h"
#include "reuse/tile/tile.h"
#include "support/statistics.h"
#include "support/test.h"

#define MOST_FRAMES 64

static void* must_alloc( size_t bytes )
{
    void* memory = malloc( bytes );
    if ( memory == NULL )
        abort();
    return memory;
}

static void must( RfResult result, const RfError* error )
{
    if ( result == RF_OK )
        return;
    fprintf( stderr, "unexpected failure: %s\n", error->text );
    abort();
}

static RfResult keep_frame( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    Rendered* r = user;
    memcpy( r->rgb + 3 * r->pixels * (size_t)r->count, frame->rgb, 3 * r->pixels * sizeof( float ) );
    memcpy( r->weight + r->pixels * (size_t)r->count, frame->weight, r->pixels * sizeof( float ) );
    r->relmse_estimate[r->count] = frame->relmse_estimate;
    r->relmse_likely[r->count] = frame->relmse_likely;
    r->relmse_is_lower_bound[r->count] = frame->relmse_is_lower_bound;
    r->clamp[r->count] = frame->clamp;
    r->removed[r->count] = frame->removed;
    r->native_spp[r->count] = frame->native_spp;
    r->effective_spp[r->count] = frame->effective_spp;
    r->count += 1;
    return RF_OK;
}

Rendered render_frames( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                        const RfRenderSettings* settings )
{
    Rendered r = { .pixels = (size_t)eyes->width * (size_t)eyes->height };
    if ( frame_count > MOST_FRAMES )
        abort();
    r.rgb = must_alloc( 3 * r.pixels * (size_t)frame_count * sizeof( float ) );
    r.weight = must_alloc( r.pixels * (size_t)frame_count * sizeof( float ) );
    RfRenderCallbacks callbacks = { .user = &r, .frame = keep_frame };
    RfError error;
    RfRenderSettings of_suite = *settings;
    of_suite.seed += suite_seed();
    of_suite.spp *= suite_samples();
    must( rf_render( &( RfShot ){ tracer, eyes, eye_count, frames, frame_count }, &of_suite, &callbacks, &r.stats, &error ),
          &error );
    float bias = settings->group > 0 || settings->tile.kind != RF_TILE_NONE ? (float)suite_bias() : 1.0f;
    for ( size_t i = 0; bias != 1.0f && i < 3 * r.pixels * (size_t)r.count; ++i )
        r.rgb[i] *= bias;
    return r;
}

Rendered render_all( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings )
{
    int frames[MOST_FRAMES];
    for ( int i = 0; i < eye_count && i < MOST_FRAMES; ++i )
        frames[i] = i;
    return render_frames( tracer, eyes, eye_count, frames, eye_count, settings );
}

double share_of_others( const float* a, const float* b, int count )
{
    int others = 0;
    for ( int i = 0; i < count; ++i )
        others += !( fabsf( a[i] - b[i] ) <= 0.01f * ( fabsf( a[i] ) + fabsf( b[i] ) ) + 1e-4f );
    return (double)others / count;
}

float* copy_floats( const float* from, size_t count )
{
    float* to = malloc( count * sizeof *to );
    assert_non_null( to );
    memcpy( to, from, count * sizeof *to );
    return to;
}

void free_rendered( Rendered* rendered )
{
    free( rendered->rgb );
    free( rendered->weight );
    *rendered = ( Rendered ){ 0 };
}

RfTracer* make_tracer( const RfScene* scene )
{
    RfTracer* tracer = NULL;
    RfError error;
    must( rf_create_tracer( scene, &tracer, &error ), &error );
    return tracer;
}

RfRenderSettings plain_settings( void )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.tile = rf_no_tile();
    settings.adaptive = RF_ADAPTIVE_OFF;
    return settings;
}

// ---- light path set ----

void draw_light_path_set( const RfScene* scene, int width, int height, LightPathSet* set )
{
    *set = ( LightPathSet ){ .tracer = make_tracer( scene ), .settings = plain_settings() };
    set->settings.threads = 1;
    set->settings.light_paths = RF_LIGHT_PATHS_ON;
    set->group = ( RfEstimatorGroup ){
        .tracer = set->tracer, .settings = &set->settings, .width = width, .height = height, .eye_count = 1
    };
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
        set->group.traits.chain_triangles += rf_is_chain_surface( scene->materials + scene->triangles.material[i] );
    set->group.traits.most_lights = scene->triangles.count + 1;
    set->path = ( RfPathSettings ){ .tracer = set->tracer, .max_depth = 12, .light_samples = 1 };
    RfLayout layout = { 0 };
    rf_place_light_paths( &set->group, &layout );
    set->paths = aligned_alloc( 64, layout.bytes );
    assert_non_null( set->paths );
    memset( set->paths, 0, layout.bytes );
    rf_draw_light_paths( &set->group, 0, set->paths );
}

void free_light_path_set( LightPathSet* set )
{
    free( set->paths );
    rf_destroy_tracer( set->tracer );
}

// ---- hard cases ----

RfRenderSettings small_settings( int group, int spp )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    settings.group = group;
    settings.spp = spp;
    settings.max_depth = 5;
    settings.threads = 1; // small pictures: more would wait for each other
    settings.memory = (size_t)256 << 20;
    return settings;
}

// What (E2) subtracts is bounded by what the pixel holds in all.
static bool may_be_negative( const RfRenderSettings* settings )
{
    return settings->group != 0 && settings->weights == RF_WEIGHTS_EXACT && settings->normalize == RF_NORMALIZE_CROSSFIT;
}

static void fail_pixel( const char* what, const RfRenderSettings* s, size_t i, double value )
{
    print_error( "%s: group %d, weights %d, normalize %d: value %zu is %g\n", what, s->group, (int)s->weights, (int)s->normalize,
                 i, value );
    fail();
}

double check_sane_settings( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count,
                            const RfRenderSettings* settings )
{
    Rendered r = render_all( tracer, eyes, eye_count, settings );
    assert_int_equal( r.count, eye_count );
    double sum = 0.0;
    size_t values = 3 * r.pixels * (size_t)r.count;
    for ( size_t i = 0; i < values; ++i )
    {
        double value = (double)r.rgb[i];
        if ( !isfinite( value ) || ( value < 0.0 && !may_be_negative( settings ) ) )
            fail_pixel( what, settings, i, value );
        sum += value / (double)values;
    }
    for ( size_t i = 0; i < r.pixels * (size_t)r.count; ++i )
    {
        double weight = (double)r.weight[i];
        if ( !isfinite( weight ) || weight < 0.0 )
            fail_pixel( what, settings, i, weight );
    }
    for ( int k = 0; k < r.count; ++k )
    {
        if ( !( r.removed[k] >= 0.0 && r.removed[k] <= 1.0 ) || ( settings->clamp != 0.0 && !( r.clamp[k] > 0.0 ) ) )
            fail_msg( "%s: a share of %g is taken out by a threshold of %g", what, r.removed[k], r.clamp[k] );
    }
    free_rendered( &r );
    return sum;
}

double check_sane( const char* what, const RfScene* scene, const RfEye* eyes, int eye_count )
{
    RfTracer* tracer = make_tracer( scene );
    RfRenderSettings settings = small_settings( 0, 4 );
    double mean = check_sane_settings( what, tracer, eyes, eye_count, &settings );
    settings = small_settings( 2, 10 );
    for ( int n = RF_NORMALIZE_CROSSFIT; n <= RF_NORMALIZE_NONE; ++n )
    {
        settings.normalize = (RfNormalize)n;
        check_sane_settings( what, tracer, eyes, eye_count, &settings );
    }
    settings.normalize = RF_NORMALIZE_CROSSFIT;
    settings.clamp = RF_CLAMP_AUTO;
    settings.tile = ( RfTile ){ RF_TILE_BLOCK, 2, 2 };
    check_sane_settings( what, tracer, eyes, eye_count, &settings );
    settings = small_settings( 2, 10 );
    for ( int w = RF_WEIGHTS_EQ15; w <= RF_WEIGHTS_UNWEIGHTED; ++w )
    {
        settings.weights = (RfWeights)w;
        check_sane_settings( what, tracer, eyes, eye_count, &settings );
    }
    rf_destroy_tracer( tracer );
    return mean;
}

// ---- tune setup ----

void begin_tune_setup( TuneSetup* s, int eyes, int spp )
{
    s->scene = make_room( ROOM_DIFFUSE );
    s->tracer = make_tracer( &s->scene );
    orbit_eyes( s->eyes, TUNE_EYES, 1.0f, TUNE_WIDTH, TUNE_HEIGHT );
    for ( int i = 0; i < TUNE_EYES; ++i )
        s->frames[i] = i;
    s->settings = rf_default_render_settings();
    s->settings.filter = RF_FILTER_BOX;
    s->settings.spp = spp;
    s->settings.memory = (size_t)256 << 20;
    s->settings.threads = 2;
    s->job = ( RfTuneJob ){ .shot = { s->tracer, s->eyes, eyes, s->frames, eyes }, .settings = &s->settings };
}

void end_tune_setup( TuneSetup* s )
{
    rf_destroy_tracer( s->tracer );
    rf_destroy_scene( &s->scene );
}

int tune_rows_tried( const RfTune* tune )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += tune->rows[i].excluded == NULL;
    return count;
}
