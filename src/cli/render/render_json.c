// The result of a render as JSON: settings, effects, rays, memory, seconds, and each frame.
#include "cli/render/render_json.h"

#include "cli/messages.h"
#include "cli/render/clipped_pixels.h"
#include "cli/render/specks_json.h"
#include "image/colour.h"
#include "output/names.h"

#include <stdio.h>

json_t* rf_frame_json( const RfFrameResult* result, const RfScene* scene, const RfCameraPath* path,
                       const RfRenderSettings* settings, int same_as )
{
    json_t* json = json_pack( "{s:i}", "frame", rf_frame_number( path, result->frame ) );
    RF_SET_FIGURES( json, { "seconds", result->seconds }, { "relmse_estimate", result->relmse_estimate } );
    json_object_set_new( json, "relmse_is_lower_bound", json_boolean( result->relmse_is_lower_bound ) );
    RF_SET_FIGURES( json, { "relmse_likely", result->relmse_likely }, { "worst_ten_share", result->worst_ten_share },
                    { "native_spp", result->native_spp }, { "effective_spp", result->effective_spp } );
    json_object_set_new( json, "kept", json_false() );
    RF_SET_FIGURES( json, { "noise_percent", rf_noise_percent( result->relmse_estimate ) } );
    json_object_set_new( json, "specks", rf_specks_json( &result->specks, scene ) );
    if ( result->solved != RF_SOLVED )
        json_object_set_new( json, "reconstruction",
                             json_string( result->solved == RF_SOLVED_NOT ? "failed" : "not converged" ) );
    if ( path->eyes[result->frame].blur_steps > 0 )
        json_object_set_new( json, "blur_steps", json_integer( path->eyes[result->frame].blur_steps ) );
    if ( same_as >= 0 )
        json_object_set_new( json, "same_as", json_integer( rf_frame_number( path, same_as ) ) );
    if ( settings->flicker > 0.0 )
    {
        RF_SET_FIGURES( json, { "flicker_estimate", result->flicker_estimate } );
        json_object_set_new( json, "flicker_is_lower_bound", json_boolean( result->flicker_is_lower_bound ) );
        RF_SET_FIGURES( json, { "flicker_likely", result->flicker_likely },
                        { "flicker_worst_ten_share", result->flicker_worst_ten_share } );
    }
    if ( settings->clamp != 0.0 )
        RF_SET_FIGURES( json, { "clamp_threshold", result->clamp }, { "clamp_threshold_chains", result->clamp_chains } );
    if ( result->removes )
        json_object_set_new( json, "removed_share", rf_json_number( result->removed ) );
    if ( settings->noise > 0.0 || settings->flicker > 0.0 )
        json_object_set_new( json, "reached", json_boolean( result->reached ) );
    return json;
}

// The names of effects that are on, left out or forced.
static json_t* names_json( const RfRenderRun* run, bool on, bool left_out, bool forced )
{
    json_t* names = json_array();
    for ( int i = 0; i < run->effect_count; ++i )
    {
        const RfEffect* e = run->effects + i;
        if ( ( on && e->on ) || ( left_out && e->left_out ) || ( forced && e->forced ) )
            json_array_append_new( names, json_string( e->name ) );
    }
    return names;
}

json_t* rf_effects_json( const RfScene* scene, const RfRenderSettings* settings )
{
    RfEffect effects[RF_MAX_EFFECTS];
    int count = rf_list_render_effects( scene, NULL, 0, settings, effects );
    json_t* list = json_array();
    for ( int i = 0; i < count; ++i )
    {
        const RfEffect* e = effects + i;
        const char* option = rf_effect_option( e->id );
        json_array_append_new( list, json_pack( "{s:s, s:b, s:o, s:b, s:b, s:o}", "name", e->name, "on", e->on, "why",
                                                rf_json_text( e->why ), "left_out", e->left_out, "forced", e->forced, "option",
                                                option != NULL ? json_string( option ) : json_null() ) );
    }
    return list;
}

static json_t* count_json( uint64_t count ) { return json_integer( (json_int_t)count ); }

static json_t* rays_json( const RfRayCounts* rays )
{
    return json_pack( "{s:o, s:o, s:o, s:o, s:o}", "primary", count_json( rays->primary ), "path", count_json( rays->path ),
                      "shadow", count_json( rays->shadow ), "tile", count_json( rays->tile ), "eye", count_json( rays->eye ) );
}

// The peak of each entry; they need not coincide.
static json_t* bytes_json( const RfRenderStats* stats )
{
    json_t* bytes = json_object();
    for ( int i = 0; i < stats->entry_count; ++i )
    {
        char key[64];
        snprintf( key, sizeof key, "%s", stats->entries[i].name );
        for ( char* c = key; *c != '\0'; ++c )
            *c = *c == ' ' ? '_' : *c;
        json_object_set_new( bytes, key, json_integer( (json_int_t)stats->entries[i].peak ) );
    }
    return bytes;
}

json_t* rf_render_json( const RfRenderOptions* options, const RfRenderRun* run )
{
    const RfRenderStats* stats = run->stats;
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &options->settings.tile, tile );
    json_t* json = json_pack( "{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:s, s:s, s:s, s:i, s:o, s:i, s:b}", "version",
                              rf_version(), "scene", rf_json_text( options->scene ), "frames", run->frames, "seconds",
                              rf_json_number( run->seconds ), "seconds_scene", rf_json_number( run->seconds_scene ), "peak_bytes",
                              count_json( stats->peak_bytes ), "budget_bytes", count_json( stats->budget_bytes ), "bytes",
                              bytes_json( stats ), "rays", rays_json( &stats->rays ), "group", stats->group, "tile", tile,
                              "weights", rf_weights_name( options->settings.weights ), "normalize",
                              rf_normalize_name( options->settings.normalize ), "threads", stats->threads, "effects",
                              names_json( run, true, false, false ), "kept_frames", run->kept, "interrupted", run->interrupted );
    json_object_set_new( json, "effects_left_out", names_json( run, false, true, false ) );
    json_object_set_new( json, "effects_forced", names_json( run, false, false, true ) );
    json_object_set_new(
        json, "filter",
        json_pack( "{s:s, s:f}", "name", rf_filter_name( options->settings.filter ), "width", options->settings.filter_width ) );
    if ( rf_is_other_estimator( options->settings.estimator ) )
    {
        json_object_set_new( json, "estimator", json_string( rf_estimator_name( options->settings.estimator ) ) );
        json_object_set_new( json, "reconstruction", json_string( rf_reconstruction_name( options->settings.reconstruction ) ) );
        json_object_set_new(
            json, "shared_paths",
            json_pack( "{s:o, s:o}", "found", count_json( stats->rays.thinned ), "kept", count_json( stats->rays.kept ) ) );
    }
    if ( options->settings.light_paths != RF_LIGHT_PATHS_OFF )
    {
        json_object_set_new( json, "light_paths", json_string( rf_light_paths_name( options->settings.light_paths ) ) );
        json_object_set_new( json, "kernel_normalization",
                             json_string( rf_kernel_normalization_name( options->settings.kernel_normalization ) ) );
    }
    const RfFrameFiles* files = &options->settings.files;
    if ( files->names != RF_NAMES_REFRAME )
        json_object_set_new( json, "names", json_string( rf_pass_names_words[files->names] ) );
    if ( files->colour_space != RF_REC709 )
        json_object_set_new( json, "colorspace", json_string( rf_colour_space_words[files->colour_space] ) );
    if ( options->overscan != NULL )
        json_object_set_new( json, "overscan", json_string( options->overscan ) );
    if ( files->time_code != NULL )
        json_object_set_new( json, "timecode", rf_json_text( files->time_code ) );
    json_t* specks = rf_sum_specks( run->frames );
    json_object_set_new( json, "specks", specks != NULL ? specks : json_null() );
    json_object_set_new( json, "clipped_pixels", rf_sum_clipped( run->frames ) );
    json_object_set_new( json, "repeated_frames", json_integer( run->repeated ) );
    RfAdaptive adaptive = options->settings.adaptive;
    json_object_set_new( json, "adaptive", json_boolean( adaptive == RF_ADAPTIVE_ON || stats->adaptive_frames > 0 ) );
    json_object_set( json, "warnings", run->warnings );
    json_object_set_new( json, "adaptive_mode", json_string( rf_adaptive_name( adaptive ) ) );
    json_object_set_new( json, "adaptive_frames", json_integer( stats->adaptive_frames ) );
    json_object_set_new( json, "beyond_depth_share", rf_json_number( run->beyond_depth ) );
    double clamp = options->settings.clamp;
    json_object_set_new( json, "clamp",
                         clamp == RF_CLAMP_AUTO ? json_string( "auto" )
                         : clamp == 0.0         ? json_string( "off" )
                                                : rf_json_number( clamp ) );
    if ( options->settings.clamp_chains > 0.0 )
        json_object_set_new( json, "clamp_chains", rf_json_number( options->settings.clamp_chains ) );
    if ( options->settings.noise > 0.0 )
        json_object_set_new( json, "noise",
                             json_pack( "{s:f, s:i}", "wanted", options->settings.noise, "missed", stats->missed ) );
    if ( options->settings.flicker > 0.0 )
        json_object_set_new( json, "flicker",
                             json_pack( "{s:f, s:i}", "wanted", options->settings.flicker, "missed", stats->flicker_missed ) );
    if ( options->settings.time > 0.0 )
        json_object_set_new( json, "time",
                             json_pack( "{s:f, s:b}", "wanted", options->settings.time, "too_short", stats->hurried ) );
    return json;
}
