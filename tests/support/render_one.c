#include "support/render_one.h"

#include "support/render_support.h"
#include "support/test.h"

// Memory of results, as a list.
typedef struct Held
{
    struct Held* before;
    double bytes[]; // aligned for all that is in it
} Held;

static void* hold( Stage* stage, size_t bytes )
{
    Held* held = calloc( 1, sizeof *held + bytes );
    assert_non_null( held );
    held->before = stage->held;
    stage->held = held;
    return held->bytes;
}

static void* hold_copy( Stage* stage, const void* from, size_t bytes )
{
    return from != NULL ? memcpy( hold( stage, bytes ), from, bytes ) : NULL;
}

void open_stage_before( Stage* stage, RfScene scene, const RfEye* eyes, int eye_count )
{
    assert_true( eye_count <= STAGE_EYES );
    *stage = ( Stage ){ .scene = scene, .eye_count = eye_count };
    memcpy( stage->eyes, eyes, (size_t)eye_count * sizeof *eyes );
}

void open_stage( Stage* stage, RfScene scene, int eye_count, float degrees, int width, int height )
{
    RfEye eyes[STAGE_EYES];
    orbit_eyes( eyes, eye_count, degrees, width, height );
    open_stage_before( stage, scene, eyes, eye_count );
}

void open_moving_stage( Stage* stage, const char* name, int width, int height )
{
    MovingRoom room = load_moving_room( name, width, height );
    open_stage_before( stage, room.scene, room.eyes, room.eye_count );
}

void open_still_stage( Stage* stage, const char* name, int frame, int width, int height )
{
    MovingRoom room = load_still_room( name, frame, width, height );
    open_stage_before( stage, room.scene, room.eyes, room.eye_count );
}

const RfTracer* stage_tracer( Stage* stage )
{
    if ( stage->tracer == NULL )
        stage->tracer = make_tracer( &stage->scene );
    return stage->tracer;
}

void close_stage( Stage* stage )
{
    while ( stage->held != NULL )
    {
        Held* before = stage->held->before;
        free( stage->held );
        stage->held = before;
    }
    rf_destroy_tracer( stage->tracer );
    rf_destroy_scene( &stage->scene );
}

typedef struct Take
{
    Stage* stage;
    RfFrameResult* results;
    int first; // frame
} Take;

RfFrameResult hold_result( Stage* stage, const RfFrameResult* result )
{
    size_t bytes = (size_t)result->width * (size_t)result->height * sizeof( float );
    RfFrameResult kept = *result;
    kept.rgb = hold_copy( stage, result->rgb, 3 * bytes );
    kept.weight = hold_copy( stage, result->weight, bytes );
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
        kept.aovs[a] = hold_copy( stage, result->aovs[a], (size_t)rf_aov_channels( (RfAov)a ) * bytes );
    RfLayer* layers = hold_copy( stage, result->layers, (size_t)result->layer_count * sizeof *layers );
    for ( int k = 0; k < result->layer_count; ++k )
    {
        layers[k].name = hold_copy( stage, layers[k].name, strlen( layers[k].name ) + 1 );
        layers[k].letters = hold_copy( stage, layers[k].letters, strlen( layers[k].letters ) + 1 );
        layers[k].values = hold_copy( stage, layers[k].values, strlen( layers[k].letters ) * bytes );
    }
    kept.layers = layers;
    return kept;
}

static RfResult keep_result( void* user, const RfFrameResult* result, RfError* error )
{
    (void)error;
    Take* take = user;
    take->results[take->stage->handed_over++] = hold_result( take->stage, result );
    return RF_OK;
}

static void count_preview( void* user, const RfPreview* preview )
{
    Take* take = user;
    take->stage->previews += preview->frame == take->first && preview->rgb != NULL;
}

static RfResult try_shot( Stage* stage, const RfShot* shot, const RfRenderSettings* settings, RfFrameResult** results,
                          RfError* error )
{
    Take take = { .stage = stage, .first = shot->frames[0] };
    take.results = *results = hold( stage, (size_t)shot->frame_count * sizeof *take.results );
    stage->previews = stage->handed_over = 0;
    RfRenderCallbacks callbacks = { .user = &take, .frame = keep_result, .preview = count_preview };
    return rf_render( shot, settings, &callbacks, &stage->stats, error );
}

const RfFrameResult* render_shot( Stage* stage, const RfShot* shot, const RfRenderSettings* settings )
{
    RfError error = { 0 };
    RfFrameResult* results;
    if ( try_shot( stage, shot, settings, &results, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_int_equal( stage->handed_over, shot->frame_count );
    return results;
}

RfShot stage_shot( Stage* stage, const int* frames, int frame_count )
{
    return ( RfShot ){ stage_tracer( stage ), stage->eyes, stage->eye_count, frames, frame_count };
}

static const int s_frames[STAGE_EYES] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15 };

const RfFrameResult* render_some( Stage* stage, int first, int count, const RfRenderSettings* settings )
{
    RfShot shot = stage_shot( stage, s_frames + first, count );
    return render_shot( stage, &shot, settings );
}

const RfFrameResult* render_stage( Stage* stage, const RfRenderSettings* settings )
{
    return render_some( stage, 0, stage->eye_count, settings );
}

const RfFrameResult* render_one( Stage* stage, int frame, const RfRenderSettings* settings )
{
    return render_some( stage, frame, 1, settings );
}

static void expect_words( const RfError* error, const char* words )
{
    if ( strstr( error->text, words ) == NULL || strchr( error->text, '\n' ) != NULL )
        fail_msg( "'%s' has no '%s', or several lines", error->text, words );
}

void expect_failure( Stage* stage, const RfRenderSettings* settings, RfResult wanted, const char* words )
{
    RfError error = { 0 };
    RfFrameResult* results;
    RfShot shot = stage_shot( stage, s_frames, stage->eye_count );
    assert_int_equal( try_shot( stage, &shot, settings, &results, &error ), wanted );
    expect_words( &error, words );
}

void expect_refused( Stage* stage, const RfRenderSettings* settings, const char* words )
{
    RfError error = { 0 };
    RfShot shot = stage_shot( stage, s_frames, 1 );
    assert_int_equal( rf_render( &shot, settings, NULL, NULL, &error ), words != NULL ? RF_ERROR_USAGE : RF_OK );
    if ( words != NULL )
        expect_words( &error, words );
}

size_t least_memory( Stage* stage, int first, int count, const RfRenderSettings* settings )
{
    RfRenderSettings resolved;
    RfMemoryFit fit;
    RfError error = { 0 };
    RfShot shot = stage_shot( stage, s_frames + first, count );
    assert_int_equal( rf_resolve_settings( &shot, settings, &resolved, &error ), RF_OK );
    resolved.memory = 1;
    assert_int_equal( rf_fit_memory( &shot, &resolved, &fit, &error ), RF_ERROR_MEMORY );
    resolved.memory = fit.least;
    assert_int_equal( rf_fit_memory( &shot, &resolved, &fit, &error ), RF_OK );
    assert_int_equal( fit.sweeps, count );
    return resolved.memory;
}

void blur_eyes( RfEye* eyes, int count, float lens, float focus, int steps )
{
    for ( int i = 0; i < count; ++i )
    {
        RfEye *eye = eyes + i, open = *eye, close = open;
        close.origin.y += 0.1f;
        if ( steps > 0 )
        {
            rf_set_shutter( eye, &open, &close );
            eye->opens = eye->time - 0.02;
            eye->closes = eye->time + 0.02;
            eye->blur_steps = steps;
        }
        eye->lens_radius = lens;
        eye->focus = focus;
    }
}

RfRenderSettings tiled_settings( int group, int spp, const char* tile )
{
    RfRenderSettings settings = small_settings( group, spp );
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

RfRenderSettings reuse_mode( int mode )
{
    static const struct
    {
        int group;
        const char* tile;
        RfFilter filter;
    } modes[REUSE_MODES] = {
        { 0, "1", RF_FILTER_BOX },
        { 0, "3x3", RF_FILTER_BLACKMAN_HARRIS },
        { 2, "1", RF_FILTER_BLACKMAN_HARRIS },
        { 2, "3x3", RF_FILTER_BOX },
    };
    RfRenderSettings settings = tiled_settings( modes[mode].group, 5, modes[mode].tile );
    settings.filter = modes[mode].filter;
    settings.filter_width = 0.0;
    return settings;
}

double mean_value( const float* values, int count )
{
    double sum = 0.0;
    for ( int i = 0; i < count; ++i )
        sum += (double)values[i];
    return sum / count;
}

double brightness( const float* values, int count )
{
    double sum = 0.0;
    for ( int i = 0; i < count; ++i )
        sum += fabs( (double)values[i] );
    return sum / count;
}

void expect_sum( const char* what, const char* of, const float* const* parts, int part_count, const float* wanted, int count,
                 double tolerance, double bright )
{
    for ( int i = 0; i < count; ++i )
    {
        double sum = 0.0;
        for ( int p = 0; p < part_count; ++p )
            sum += (double)parts[p][i];
        if ( !( fabs( sum - (double)wanted[i] ) <= tolerance * ( fabs( (double)wanted[i] ) + bright ) ) )
            fail_msg( "%s: value %d of %s is %.9g, not %.9g", what, i, of, sum, (double)wanted[i] );
    }
}

void expect_like_aovs( const char* what, const RfFrameResult* a, const RfFrameResult* b, double most )
{
    for ( int k = 0; k < RF_AOV_COUNT; ++k )
    {
        int count = rf_aov_channels( (RfAov)k ) * a->width * a->height;
        double share = a->aovs[k] != NULL ? share_of_others( a->aovs[k], b->aovs[k], count ) : 0.0;
        if ( share > most )
            fail_msg( "%s, frame %d: AOV %s differs in %.2f %% of its values", what, a->frame, rf_aov_name( (RfAov)k ),
                      100.0 * share );
    }
}

static void expect_same_floats( const float* a, const float* b, size_t count )
{
    assert_true( ( a != NULL ) == ( b != NULL ) );
    if ( a != NULL )
        assert_memory_equal( a, b, count * sizeof *a );
}

void expect_same_bits( const RfFrameResult* a, const RfFrameResult* b )
{
    size_t pixels = (size_t)a->width * (size_t)a->height;
    expect_same_floats( a->rgb, b->rgb, 3 * pixels );
    expect_same_floats( a->weight, b->weight, pixels );
    for ( int k = 0; k < RF_AOV_COUNT; ++k )
        expect_same_floats( a->aovs[k], b->aovs[k], (size_t)rf_aov_channels( (RfAov)k ) * pixels );
    assert_int_equal( a->layer_count, b->layer_count );
    for ( int k = 0; k < a->layer_count; ++k )
        expect_same_floats( a->layers[k].values, b->layers[k].values, strlen( a->layers[k].letters ) * pixels );
}
