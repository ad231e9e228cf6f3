#include "output/frame_attributes.h"

#include "scene/scene.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static const char* const s_names[RF_KEY_COUNT] = {
#define RF_KEY_NAME( constant, name ) name,
    RF_KEY_LIST( RF_KEY_NAME )
#undef RF_KEY_NAME
};

const char* rf_key_name( RfKey key ) { return s_names[key]; }

static void put_text( RfAttributes* a, RfKey key, const char* value ) { a->values[key] = value; }

__attribute__( ( format( printf, 3, 4 ) ) ) static void put( RfAttributes* a, RfKey key, const char* format, ... )
{
    va_list args;
    va_start( args, format );
    vsnprintf( a->texts[key], RF_ATTRIBUTE_SIZE, format, args );
    va_end( args );
    a->values[key] = a->texts[key];
}

static void put_settings( RfAttributes* a, const RfRenderSettings* s )
{
    char tile[RF_TILE_NAME_SIZE], aovs[RF_AOVS_TEXT_SIZE];
    rf_tile_name( &s->tile, tile );
    rf_format_aovs( s->aovs, aovs, sizeof aovs );
    put( a, RF_KEY_GROUP, "%d", s->group );
    put( a, RF_KEY_SPP, "%d", s->spp );
    put( a, RF_KEY_TILE, "%s", tile );
    put_text( a, RF_KEY_WEIGHTS, rf_weights_name( s->weights ) );
    put_text( a, RF_KEY_NORMALIZE, rf_normalize_name( s->normalize ) );
    put( a, RF_KEY_SEED, "%llu", (unsigned long long)s->seed );
    put( a, RF_KEY_MAX_DEPTH, "%d", s->max_depth );
    put( a, RF_KEY_LIGHT_SAMPLES, "%d", s->light_samples );
    if ( s->filter != RF_FILTER_BOX || s->filter_width != 1.0 )
    {
        put_text( a, RF_KEY_FILTER, rf_filter_name( s->filter ) );
        put( a, RF_KEY_FILTER_WIDTH, "%.9g", s->filter_width );
    }
    if ( s->adaptive != RF_ADAPTIVE_OFF )
        put_text( a, RF_KEY_ADAPTIVE, s->adaptive == RF_ADAPTIVE_ON ? "yes" : rf_adaptive_name( s->adaptive ) );
    if ( s->noise > 0.0 )
        put( a, RF_KEY_NOISE, "%.9g", s->noise );
    if ( s->flicker > 0.0 )
        put( a, RF_KEY_FLICKER, "%.9g", s->flicker );
    if ( s->time > 0.0 )
        put( a, RF_KEY_TIME, "%.9g", s->time );
    if ( s->aovs != 0 )
        put( a, RF_KEY_AOV, "%s", aovs );
    if ( s->estimator != rf_default_render_settings().estimator )
        put_text( a, RF_KEY_ESTIMATOR, rf_estimator_name( s->estimator ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF )
        put_text( a, RF_KEY_LIGHT_PATHS, rf_light_paths_name( s->light_paths ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF && s->kernel_normalization != RF_KERNEL_EXACT )
        put_text( a, RF_KEY_KERNEL_NORMALIZATION, rf_kernel_normalization_name( s->kernel_normalization ) );
    if ( s->reconstruction != RF_RECONSTRUCTION_WEIGHTED )
        put_text( a, RF_KEY_RECONSTRUCTION, rf_reconstruction_name( s->reconstruction ) );
}

// Of options: nothing where none was given.
static void put_effects( RfAttributes* a, const RfScene* scene )
{
    char names[RF_EFFECTS_TEXT_SIZE];
    rf_format_effects( scene->effects_left_out, names, sizeof names );
    if ( scene->effects_left_out != 0 )
        put( a, RF_KEY_NO_EFFECT, "%s", names );
    rf_format_effects( scene->effects_forced, names, sizeof names );
    if ( scene->effects_forced != 0 )
        put( a, RF_KEY_EFFECTS, "%s",
             ( scene->effects_forced | scene->effects_left_out ) == ( rf_forcible_effects() | scene->effects_left_out ) ? "all"
                                                                                                                        : names );
}

static void put_frame( RfAttributes* a, const RfOutput* output, const RfFrameResult* frame )
{
    char fingerprint[RF_FINGERPRINT_SIZE];
    rf_frame_fingerprint( output, frame->frame, fingerprint );
    put_text( a, RF_KEY_VERSION, rf_version() );
    put_text( a, RF_KEY_SCENE, rf_tracer_scene( output->tracer )->path );
    put_text( a, RF_KEY_CAMERA, output->path->name );
    put( a, RF_KEY_FRAME, "%d", rf_frame_number( output->path, frame->frame ) );
    put( a, RF_KEY_FRAMES, "%d", output->path->count );
    if ( output->path->step > 1 )
        put( a, RF_KEY_STEP, "%d", output->path->step );
    if ( isfinite( frame->relmse_estimate ) )
    {
        put( a, RF_KEY_RELMSE_ESTIMATE, "%.6g", frame->relmse_estimate );
        put_text( a, RF_KEY_RELMSE_IS_LOWER_BOUND, frame->relmse_is_lower_bound ? "yes" : NULL );
        put( a, RF_KEY_RELMSE_LIKELY, "%.6g", frame->relmse_likely );
        put( a, RF_KEY_WORST_TEN_SHARE, "%.6g", frame->worst_ten_share );
    }
    if ( output->settings.flicker > 0.0 && isfinite( frame->flicker_estimate ) )
    {
        put( a, RF_KEY_FLICKER_ESTIMATE, "%.6g", frame->flicker_estimate );
        put_text( a, RF_KEY_FLICKER_IS_LOWER_BOUND, frame->flicker_is_lower_bound ? "yes" : NULL );
        put( a, RF_KEY_FLICKER_LIKELY, "%.6g", frame->flicker_likely );
        put( a, RF_KEY_FLICKER_WORST_TEN_SHARE, "%.6g", frame->flicker_worst_ten_share );
    }
    if ( output->settings.noise > 0.0 || output->settings.flicker > 0.0 )
        put_text( a, RF_KEY_REACHED, frame->reached ? "yes" : "no" );
    put_effects( a, rf_tracer_scene( output->tracer ) );
    put_text( a, RF_KEY_CALLS_FOR, output->calls_for );
    put( a, RF_KEY_NATIVE_SPP, "%.9g", frame->native_spp );
    put( a, RF_KEY_EFFECTIVE_SPP, "%.6g", frame->effective_spp );
    put_text( a, RF_KEY_DEVICE, rf_tracer_device( output->tracer ) );
    put( a, RF_KEY_FINGERPRINT, "%s", fingerprint );
}

void rf_list_attributes( const RfOutput* output, const RfFrameResult* frame, RfAttributes* a )
{
    for ( int i = 0; i < RF_KEY_COUNT; ++i )
        a->values[i] = NULL;
    a->count = 0;
    put_settings( a, &output->settings );
    put_frame( a, output, frame );
    for ( int i = 0; i < RF_KEY_COUNT; ++i )
    {
        if ( a->values[i] != NULL )
            a->strings[a->count++] = ( RfExrString ){ s_names[i], a->values[i] };
    }
}
