// reframe render: from a scene and a camera path to EXR files.
#include "cli/render/render_command.h"

#include "base/system.h"
#include "base/try.h"
#include "cli/commands.h"
#include "cli/options/frame_lists.h"
#include "cli/render/render_files.h"
#include "cli/render/render_json.h"
#include "cli/messages.h"
#include "film/cryptomatte.h"
#include "render/estimator.h"
#include "render/settings.h"
#include "scene/placement.h"
#include "scene/scene.h"
#include "scene_file/scene_file.h"
#include "trace/trace.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MUCH_HALO 0.25 // of the work

static void note_solve( RfFrameErrors* errors, RfSolved solved, int number )
{
    if ( solved == RF_SOLVED_ROUGHLY && errors->roughly++ == 0 )
        errors->first_rough = number;
    if ( solved == RF_SOLVED_NOT && errors->not_solved++ == 0 )
        errors->first_not_solved = number;
}

static void note_frame_error( RfFrameErrors* errors, const RfFrameResult* result, int number )
{
    ++errors->frames;
    errors->relmse_sum += result->relmse_estimate;
    errors->likely_sum += result->relmse_likely;
    errors->lower_bounds += result->relmse_is_lower_bound;
    errors->missed += result->noise_missed;
    errors->removes = errors->removes || result->removes;
    errors->removed_sum += result->removed;
    errors->flicker_missed += result->flicker_missed;
    if ( isgreater( result->flicker_likely, errors->worst_flicker ) )
    {
        errors->worst_flicker = result->flicker_likely;
        errors->worst_pair = number;
    }
    note_solve( errors, result->solved, number );
    double relmse = result->relmse_likely;
    if ( result->denoised != NULL )
        relmse = fmin( relmse, result->denoised->denoised.high );
    if ( errors->frames > 1 && islessequal( relmse, errors->worst_relmse ) )
        return;
    errors->worst_relmse = relmse;
    errors->worst_frame = number;
    errors->worst_is_lower_bound = result->denoised == NULL && result->relmse_is_lower_bound;
}

// Makes a frame that of the same picture as the one before it.
static void stop_flicker( RfFrameResult* result )
{
    result->flicker_estimate = result->flicker_likely = result->flicker_worst_ten_share = 0.0;
    result->flicker_is_lower_bound = result->flicker_missed = false;
    result->reached = !result->noise_missed;
}

// Prints a line about the error of the frames, where it is known: the mean, or where it is and what helps.
static void print_frame_errors( const RfRenderJob* job )
{
    const RfFrameErrors* errors = &job->errors;
    double reported = errors->relmse_sum / errors->frames, likely = errors->likely_sum / errors->frames;
    char text[512], noise[RF_NOISE_TEXT_SIZE];
    if ( job->denoised.frames > 0 )
    {
        RfErrorEstimate denoised = rf_denoised_error( &job->denoised );
        rf_format_denoised( job->noisy_sum / job->denoised.frames, &denoised, text );
        printf( "%c%s\n", toupper( text[0] ), text + 1 );
        return;
    }
    if ( errors->frames == 0 || isfinite( reported ) == 0 )
        return;
    json_t* specks = rf_sum_specks( job->frames_json );
    rf_format_noise( reported, noise );
    if ( rf_format_specks( specks, text, sizeof text ) )
    {
        const char* advice = rf_speck_advice( specks, &job->options.settings );
        rf_print( "%s%s%s\n", text, advice != NULL ? ": " : "", advice != NULL ? advice : "" );
    }
    else if ( errors->lower_bounds > 0 )
        printf( "At least %s noise (relMSE %.3g, likely %.3g)\n", noise, reported, likely );
    else
        printf( "About %s noise (relMSE %.3g)\n", noise, reported );
    json_decref( specks );
}

// What pilots have found. Thresholds are to be given to other shots of the set.
static void print_pilots( const RfRenderSettings* s, const RfRenderStats* stats )
{
    if ( s->clamp == RF_CLAMP_AUTO && stats->clamp > 0.0 && fmax( stats->clamp, stats->clamp_chains ) <= RF_MAX_CLAMP )
        printf( "For all shots of a set: --clamp %.4g --clamp-chains %.4g\n", stats->clamp, stats->clamp_chains );
    if ( stats->guide_tables > 0 )
        printf( "Paths were guided to light that is hard to find; --guide off goes without\n" );
    else if ( s->guide == RF_GUIDE_ON )
        printf( "--guide on: the pilot learned nothing, no path was guided\n" );
}

// Warns of reconstructions that did not converge, or failed.
static void warn_of_solves( const RfFrameErrors* errors, RfLog* log )
{
    if ( errors->roughly > 0 )
        rf_warn( log,
                 "the reconstruction of %d frame%s stopped before it converged, frame %d the first: raise --spp, or try "
                 "--reconstruction l2",
                 errors->roughly, errors->roughly == 1 ? "" : "s", errors->first_rough );
    if ( errors->not_solved > 0 )
        rf_warn( log,
                 "%d frame%s could not be reconstructed, since samples are infinite or NaN, frame %d the first: they show "
                 "the primal picture, as with --reconstruction none",
                 errors->not_solved, errors->not_solved == 1 ? "" : "s", errors->first_not_solved );
}

// Warns where --noise, --flicker or --time was not met.
static void warn_of_stop( const RfFrameErrors* errors, const RfRenderSettings* settings, const RfRenderStats* stats,
                          int frame_count, int run_count, bool denoised, RfLog* log )
{
    char wanted[RF_NOISE_TEXT_SIZE], worst[RF_NOISE_TEXT_SIZE];
    rf_format_noise( settings->noise, wanted );
    rf_format_noise( errors->worst_relmse, worst );
    if ( stats->missed > 0 )
        rf_warn( log,
                 "--noise: %s (relMSE %.3g) not reached in %d of %d frames, frame %d %shas %s%s (relMSE %.3g): allow more %s",
                 wanted, settings->noise, stats->missed, frame_count, errors->worst_frame,
                 errors->worst_is_lower_bound ? "likely " : "", denoised ? "up to " : "", worst, errors->worst_relmse,
                 settings->time > 0.0 ? "--time or --spp" : "--spp" );
    rf_format_flicker( settings->flicker, wanted );
    rf_format_flicker( errors->worst_flicker, worst );
    if ( stats->flicker_missed > 0 )
        rf_warn( log, "--flicker: %s not reached in %d of %d frames, frames %d and %d have likely %s: allow more %s", wanted,
                 stats->flicker_missed, frame_count, errors->worst_pair - 1, errors->worst_pair, worst,
                 settings->time > 0.0 ? "--time or --spp" : "--spp" );
    if ( stats->hurried )
        rf_warn( log, "--time %g: too short for this size and these groups: the least, 2 samples per pixel, took %.3g s a frame",
                 settings->time, stats->seconds / run_count );
}

// A single pass, which gives no estimate of its variance.
static void warn_of_variance( const RfRenderSettings* s, const RfCameraPath* path, const int* frames, int frame_count,
                              RfLog* log )
{
    RfGroupPlan plan = rf_plan_shots( path->runs, path->run_count, s->group, s->spp );
    if ( ( s->aovs & RF_AOV_BIT( RF_AOV_VARIANCE ) ) == 0 || s->noise > 0.0 || s->flicker > 0.0 ||
         s->time > 0.0 ) // never a single pass
        return;
    for ( int i = 0; i < frame_count; ++i )
    {
        if ( rf_frame_passes( &plan, path->run_of_frame[frames[i]] ) > 1 )
            continue;
        rf_warn( log, "--aov variance: will be 0 in frame %d, which has one pass only: raise --spp",
                 rf_frame_number( path, frames[i] ) );
        return;
    }
}

static bool is_unlit( const RfScene* scene )
{
    uint32_t i = 0;
    while ( i < scene->material_count && !scene->materials[i].unlit )
        ++i;
    return i < scene->material_count;
}

static void warn_of_scene( const RfRenderOptions* options, const RfScene* scene, const RfTracer* tracer, RfLog* log )
{
    if ( rf_triangle_count( scene ) == 0 )
        rf_warn( log, "%s: has no triangles, the picture will be %s", options->scene,
                 rf_tracer_has_light( tracer ) ? "sky alone" : "black" );
    else if ( rf_tracer_has_light( tracer ) || is_unlit( scene ) )
        return;
    else if ( scene->punctual_count > 0 )
        rf_warn( log, "%s: none of its lamps has any power ('%.60s' is one of %d), no material emits, the picture will be black",
                 options->scene, scene->punctuals[0].name, scene->punctual_count );
    else
        rf_warn( log, "%s: has no lights (no material emits, no lamp, no environment), the picture will be black",
                 options->scene );
}

// A reconstruction that is biased, or that so few samples cannot have.
static void warn_of_reconstruction( const RfRenderSettings* s, RfLog* log )
{
    if ( !s->estimator->has_gradients )
        return;
    if ( s->reconstruction == RF_RECONSTRUCTION_L1 )
        rf_warn( log, "--reconstruction l1: is biased, and the error estimate does not know by how much" );
    else if ( s->reconstruction == RF_RECONSTRUCTION_WEIGHTED && s->spp < s->estimator->usual_passes )
        rf_warn( log, "--reconstruction weighted: is l2 with less than %d samples: raise --spp", s->estimator->usual_passes );
}

// Light paths that were asked for and that there are none of, or whose normalisation is biased.
static void warn_of_light_paths( const RfRenderSettings* s, const RfEffect* effect, RfLog* log )
{
    if ( s->light_paths == RF_LIGHT_PATHS_ON && !effect->on )
        rf_warn( log, "--light-paths on: there are none: %s", effect->why );
    else if ( effect->on && s->kernel_normalization != RF_KERNEL_EXACT )
        rf_warn( log, "--kernel-normalization %s: is biased, and the error estimate does not know by how much",
                 rf_kernel_normalization_name( s->kernel_normalization ) );
}

// Prints on standard error which settings differ from those asked for.
static void print_settings( const RfRenderSettings* asked, const RfRenderSettings* used, const RfMemoryFit* fit,
                            const RfCameraPath* path )
{
    RfGroupPlan plan = rf_plan_shots( path->runs, path->run_count, used->group, used->spp );
    char tile[RF_TILE_NAME_SIZE], memory[RF_BYTES_TEXT_SIZE];
    rf_tile_name( &used->tile, tile );
    if ( ( asked->group == RF_GROUP_AUTO && rf_has_groups( used->estimator ) ) || asked->tile.kind == RF_TILE_AUTO )
        fprintf( stderr, "reframe render: auto takes --group %d --tile %s here, see reframe tune\n", used->group, tile );
    if ( asked->group > used->group )
        fprintf( stderr, "reframe render: --group %d cut to the %s: groups of its %d frames\n", asked->group,
                 plan.cameras != NULL ? "longest shot" : "path", plan.eyes );
    if ( asked->spp != used->spp ) // full groups only, with the same passes each
        fprintf( stderr, "reframe render: --spp %d rounded %s to %d: %d groups of %d frames hold a frame, %d sample%s in each\n",
                 asked->spp, used->spp > asked->spp ? "up" : "down", used->spp, plan.eyes, plan.eyes, plan.passes,
                 plan.passes == 1 ? "" : "s" );
    rf_format_memory( used->memory, memory );
    if ( fit->threads < used->threads )
        fprintf( stderr, "reframe render: %s of memory are enough for %d of %d threads\n", memory, fit->threads, used->threads );
    if ( fit->sweeps > 1 )
        fprintf( stderr, "reframe render: %s of memory hold the films of %d frame%s: the path is rendered in %d sweeps\n", memory,
                 fit->films, fit->films == 1 ? "" : "s", fit->sweeps );
}

static uint64_t set_of( const RfEffect* effects, int count, bool left_out, bool forced )
{
    uint64_t set = 0;
    for ( int i = 0; i < count; ++i )
    {
        const RfEffect* e = effects + i;
        bool listed = left_out ? e->left_out : forced ? e->forced : e->on;
        set |= listed ? RF_EFFECT_BIT( e->id ) : 0;
    }
    return set;
}

// Prints the names of the effects that are on, left out and forced in a line on standard error.
static void print_effects( const RfEffect* effects, int count )
{
    char on[RF_EFFECTS_TEXT_SIZE], out[RF_EFFECTS_TEXT_SIZE], forced[RF_EFFECTS_TEXT_SIZE];
    rf_format_effects( set_of( effects, count, false, false ), on, sizeof on );
    rf_format_effects( set_of( effects, count, true, false ), out, sizeof out );
    rf_format_effects( set_of( effects, count, false, true ), forced, sizeof forced );
    fprintf( stderr, "reframe render: effects: %s%s%s%s%s\n", on[0] != '\0' ? on : "none", out[0] != '\0' ? "; left out: " : "",
             out, forced[0] != '\0' ? "; forced: " : "", forced );
}

static RfShot shot_of( const RfRenderJob* job )
{
    return ( RfShot ){ job->tracer, job->path.runs, job->path.run_count, job->runs, job->run_count };
}

// The halo of the frames that are rendered, which --json tells; it is said where it is much.
static void note_halo( RfRenderJob* job )
{
    const RfRenderOptions* options = &job->options;
    RfShot shot = shot_of( job );
    RfError ignored;
    if ( job->run_count == 0 || ( options->quiet && options->json == NULL ) ||
         rf_plan_halo( &shot, &options->settings, MUCH_HALO, &job->halo, &ignored ) != RF_OK || job->halo.share < MUCH_HALO ||
         options->quiet )
        return;
    char cheaper[96] = ", which no smaller group saves at the same noise";
    if ( job->halo.group < options->settings.group )
        snprintf( cheaper, sizeof cheaper, "; --group %d takes about %.0f %% less time for the same noise", job->halo.group,
                  100.0 * job->halo.saved );
    fprintf( stderr, "reframe render: about %.0f %% of the time goes into the halo, frames beside those asked for%s\n",
             100.0 * job->halo.share, cheaper );
}

// Says in which of the frames nothing changes, and that these are rendered once, on standard error.
static void print_runs( const RfCameraPath* path, const int* frames, int frame_count, int run_count )
{
    int stretches = 0, first = 0, last = 0;
    if ( run_count == frame_count )
        return;
    for ( int i = 1; i < frame_count; ++i )
    {
        if ( path->run_of_frame[frames[i]] != path->run_of_frame[frames[i - 1]] )
            continue;
        bool begins = i == 1 || path->run_of_frame[frames[i - 1]] != path->run_of_frame[frames[i - 2]];
        stretches += begins;
        first = begins && stretches == 1 ? frames[i - 1] : first;
        last = stretches == 1 ? frames[i] : last;
    }
    char more[48] = "";
    if ( stretches > 1 )
        snprintf( more, sizeof more, " and %d more times", stretches - 1 );
    fprintf( stderr, "reframe render: nothing changes in frames %d to %d%s: equal frames are rendered once, %d of %d in all\n",
             rf_frame_number( path, first ), rf_frame_number( path, last ), more, run_count, frame_count );
}

static void destroy_render_job( RfRenderJob* job )
{
    rf_stop_preview( &job->preview );
    rf_close_denoiser( job->denoiser );
    rf_free_denoised_sums( &job->denoised );
    pthread_mutex_destroy( &job->speech );
    rf_destroy_tracer( job->tracer );
    rf_destroy_camera_path( &job->path );
    rf_destroy_scene( &job->scene );
    rf_close_scene_file( &job->file );
    free( job->frames );
    free( job->runs );
    free( job->kept );
    if ( job->films != NULL )
        fclose( job->films );
    json_decref( job->frames_json );
    json_decref( job->reported.lines );
}

static RfOutput output_of( const RfRenderJob* job )
{
    return ( RfOutput ){
        .pattern = job->options.output,
        .tracer = job->tracer,
        .path = &job->path,
        .settings = job->options.settings,
        .calls_for = job->calls_for,
    };
}

// Replaces the settings by those that are used.
static RfResult resolve( RfRenderJob* job, RfError* error )
{
    job->asked = job->options.settings;
    RfShot shot = shot_of( job );
    RF_TRY( rf_resolve_settings( &shot, &job->asked, &job->options.settings, error ) );
    return rf_fit_memory( &shot, &job->options.settings, &job->fit, error );
}

// What the export lost changes the picture: said first, and with --quiet too.
static void print_losses( const RfRenderJob* job )
{
    const RfScene* scene = &job->scene;
    for ( int i = 0; i < scene->export_loss_count; ++i )
        fprintf( stderr, "reframe render: lost by the export: %s\n", scene->export_losses[i] );
    if ( scene->export_warning_count > 0 && !job->options.quiet )
        fprintf( stderr, "reframe render: %d warning%s of the export: see reframe info\n", scene->export_warning_count,
                 scene->export_warning_count == 1 ? "" : "s" );
}

// Before the scene, which may take long, unless it is the scene's file that asks for it.
static RfResult open_denoiser( RfRenderJob* job, RfError* error )
{
    if ( job->options.denoise && job->denoiser == NULL )
        RF_TRY( rf_open_denoiser( job->options.denoiser, job->options.settings.threads, &job->denoiser, error ) );
    job->options.settings.files.denoiser = job->denoiser != NULL ? rf_denoiser_name( job->denoiser ) : NULL;
    return RF_OK;
}

static RfResult load_scene( RfRenderJob* job, RfError* error )
{
    RF_TRY( open_denoiser( job, error ) );
    RF_TRY( rf_open_scene_file( job->options.scene, &job->file, error ) );
    RfField defaults = rf_scene_file_defaults( &job->file, error );
    RfResult result = RF_OK;
    if ( defaults.json != NULL )
        result = rf_parse_render_options_over( &defaults, job->argc, job->argv, &job->options, error );
    if ( result == RF_OK )
        result = open_denoiser( job, error );
    if ( result == RF_OK )
        result = rf_load_scene_file( &job->file, &job->options.movement, &job->scene, &job->log, error );
    if ( result == RF_OK && !job->options.check )
        print_losses( job );
    if ( result == RF_OK && job->scene.film_alpha && !job->options.alpha_given )
        job->options.settings.aovs |= RF_AOV_BIT( RF_AOV_ALPHA );
    rf_take_scene_depth( &job->options, &job->scene );
    if ( result == RF_OK )
        result = rf_check_rendered( &job->scene, error );
    if ( result == RF_OK )
        result = rf_check_file_light_groups( &job->options, &job->file, &job->scene, error );
    return result == RF_OK ? rf_take_effect_options( &job->options, &job->scene, &job->log, error ) : result;
}

static RfResult fail_numbers( const RfRenderJob* job, RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %d frames", job->frame_count );
}

static RfResult find_runs( RfRenderJob* job, RfError* error )
{
    free( job->runs );
    job->runs = rf_runs_of_frames( &job->path, job->frames, job->frame_count, &job->run_count );
    return job->runs != NULL ? RF_OK : fail_numbers( job, error );
}

static void list_effects( RfRenderJob* job )
{
    const RfRenderSettings* settings = &job->options.settings;
    job->effect_count = rf_list_render_effects( &job->scene, job->path.runs, job->path.run_count, settings, job->effects );
    rf_format_effects( set_of( job->effects, job->effect_count, false, false ), job->calls_for, sizeof job->calls_for );
}

// Loads the scene, the path and the frames of the options, and settles what is left to render: reported on standard error.
// With --check nothing is settled of the files.
static RfResult load_render_job( RfRenderJob* job, RfError* error )
{
    RF_TRY( load_scene( job, error ) );
    RF_TRY( rf_create_asked_path( &job->options, &job->scene, &job->path, &job->log, error ) );
    RF_TRY( rf_choose_frames( job->options.frames, &job->file, &job->path, &job->frames, &job->frame_count, error ) );
    int asked_count = job->frame_count;
    job->kept = malloc( (size_t)asked_count * sizeof( int ) );
    RF_TRY( job->kept != NULL ? find_runs( job, error ) : fail_numbers( job, error ) );
    RF_TRY( rf_create_tracer_by( job->options.settings.threads, &job->scene, &job->tracer, error ) );
    RF_TRY( resolve( job, error ) );
    list_effects( job );
    job->output = output_of( job );
    RfError reason = { 0 };
    if ( rf_check_time_code( &job->output, &reason ) != RF_OK )
        return rf_fail( error, RF_ERROR_USAGE, "--timecode: %.1000s", reason.text );
    if ( job->options.check )
        return RF_OK;
    RfResult result =
        rf_prepare_output( &job->output, &job->options, job->frames, &job->frame_count, job->kept, &job->log, error );
    RfFramesLeft left = { &job->output, job->frames, job->frame_count, job->kept, asked_count - job->frame_count };
    if ( result == RF_OK && left.count > 0 )
        result = rf_find_films( &left, &job->options, &job->log, &job->films, error );
    job->frame_count = left.count;
    job->kept_count = left.kept_count;
    job->kept_films = job->films != NULL ? job->frames[0] : -1;
    if ( result == RF_OK )
        result = find_runs( job, error ); // of what is left
    if ( result == RF_OK && !job->options.quiet && job->options.depth_of_scene )
        fprintf( stderr, "reframe render: max depth %d, from the glTF\n", job->options.settings.max_depth );
    if ( result == RF_OK && !job->options.quiet )
        print_settings( &job->asked, &job->options.settings, &job->fit, &job->path );
    if ( result == RF_OK )
        note_halo( job );
    if ( result != RF_OK || job->options.quiet )
        return result;
    if ( job->options.verbose )
        print_effects( job->effects, job->effect_count );
    print_runs( &job->path, job->frames, job->frame_count, job->run_count );
    if ( job->films != NULL )
        fprintf( stderr, "reframe render: continues from the films of frame %d\n",
                 rf_frame_number( &job->path, job->frames[0] ) );
    return RF_OK;
}

// What can be warned of before the work.
static RfResult warn_before_render( RfRenderJob* job, RfError* error )
{
    warn_of_scene( &job->options, &job->scene, job->tracer, &job->log );
    rf_warn_of_equal_ids( &job->scene, job->options.settings.cryptomatte, &job->log );
    warn_of_variance( &job->options.settings, &job->path, job->frames, job->frame_count, &job->log );
    warn_of_reconstruction( &job->options.settings, &job->log );
    warn_of_light_paths( &job->options.settings, job->effects + RF_EFFECT_LIGHT_PATHS, &job->log );
    RfShot shot = shot_of( job );
    return rf_warn_of_depth( &shot, &job->options, &job->log, &job->output.beyond_depth, error );
}

// A black picture of a scene with lights: most likely the camera is inside something.
static void warn_if_black( RfRenderJob* job, const RfFrameResult* result )
{
    size_t count = 3 * (size_t)result->width * (size_t)result->height;
    if ( job->reported_black || !rf_tracer_has_light( job->tracer ) )
        return;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( result->rgb[i] != 0.0f )
            return;
    }
    job->reported_black = true;
    rf_clear_progress( &job->line );
    rf_warn( &job->log, "%s: frame %d is black, no light reaches the camera: is it inside a wall, or looking away?",
             job->options.scene, rf_frame_number( &job->path, result->frame ) );
}

static RfResult write_frame( RfRenderJob* job, const RfFrameResult* result, int same_as, RfError* error )
{
    int number = rf_frame_number( &job->path, result->frame );
    RfResult written = rf_write_frame( &job->output, result, error );
    if ( written != RF_OK )
        return written;
    if ( result->frame != job->kept_films )
        rf_remove_films_file( &job->output, result->frame ); // of no use any more
    rf_note_live_frame( &job->preview, number );
    pthread_mutex_lock( &job->speech );
    ++job->frames_done;
    note_frame_error( &job->errors, result, number );
    warn_if_black( job, result );
    rf_show_frame( &job->line, result, number, job->frames_done, job->frame_count,
                   rf_wall_seconds() - job->start - job->seconds_scene );
    pthread_mutex_unlock( &job->speech );
    json_t* row = rf_frame_json( result, &job->scene, &job->path, &job->options.settings, same_as );
    rf_add_clipped( job->options.output, number, row );
    json_array_append_new( job->frames_json, row );
    return RF_OK;
}

// A finished run: every frame of it that is wanted gets the picture. Called in the thread that writes.
static RfResult write_run( RfRenderJob* job, const RfFrameResult* run, RfError* error )
{
    RfFrameResult frame = *run;
    int same_as = -1;
    while ( job->frames_done < job->frame_count && job->path.run_of_frame[job->frames[job->frames_done]] == run->frame )
    {
        frame.frame = job->frames[job->frames_done];
        RF_TRY( write_frame( job, &frame, same_as, error ) );
        same_as = same_as < 0 ? frame.frame : same_as;
        frame.seconds = 0.0; // rendered once
        stop_flicker( &frame );
    }
    return RF_OK;
}

static RfResult on_run( void* user, const RfFrameResult* run, RfError* error )
{
    RfRenderJob* job = user;
    RfDenoisedFrame clean;
    if ( job->denoiser == NULL )
        return write_run( job, run, error );
    pthread_mutex_lock( &job->denoising );
    RfResult result = rf_denoise_frame( job->denoiser, run, &job->denoised, &clean, error );
    pthread_mutex_unlock( &job->denoising );
    job->noisy_sum += result == RF_OK && isfinite( clean.denoised.noisy ) ? clean.denoised.noisy : 0.0;
    if ( result == RF_OK )
        result = write_run( job, &clean.frame, error );
    rf_free_denoised_frame( &clean );
    return result;
}

// What --noise stops by: the upper end of the interval.
static RfJudged on_judge( void* user, const RfFrameResult* frame )
{
    RfRenderJob* job = user;
    RfDenoisedFrame clean;
    RfError error;
    pthread_mutex_lock( &job->denoising );
    RfResult result = rf_denoise_frame( job->denoiser, frame, NULL, &clean, &error );
    if ( result != RF_OK && job->not_judged.code == RF_OK )
        job->not_judged = error;
    pthread_mutex_unlock( &job->denoising );
    RfJudged judged = { result == RF_OK ? clean.denoised.denoised.high : (double)NAN, clean.denoised.exponent };
    rf_free_denoised_frame( &clean );
    return judged;
}

static bool on_progress( void* user, const RfProgress* progress )
{
    RfRenderJob* job = user;
    pthread_mutex_lock( &job->speech );
    rf_show_progress( &job->line, progress );
    pthread_mutex_unlock( &job->speech );
    rf_note_live_progress( &job->preview, progress );
    return !rf_is_interrupted() && job->not_judged.code == RF_OK;
}

static int first_frame_of_run( const RfRenderJob* job, int run )
{
    int i = 0;
    while ( i < job->frame_count - 1 && job->path.run_of_frame[job->frames[i]] < run )
        ++i;
    return rf_frame_number( &job->path, job->frames[i] );
}

static void on_preview( void* user, const RfPreview* preview )
{
    RfRenderJob* job = user;
    RfError error = { 0 };
    int number = first_frame_of_run( job, preview->frame );
    if ( rf_take_preview( &job->preview, preview, number, job->options.settings.threads, &error ) == RF_OK )
        return;
    pthread_mutex_lock( &job->speech );
    rf_clear_progress( &job->line );
    rf_warn( &job->log, "%.1000s", error.text );
    pthread_mutex_unlock( &job->speech );
}

static RfResult start_preview( RfRenderJob* job, RfError* error )
{
    const char* option = job->options.preview;
    RfResult result = rf_start_preview( option, &job->output, job->kept_count + job->frame_count, &job->preview, error );
    for ( int i = 0; i < job->kept_count && result == RF_OK; ++i )
        rf_note_live_frame( &job->preview, rf_frame_number( &job->path, job->kept[i] ) );
    if ( result == RF_OK && job->preview.serving && !job->options.quiet )
        fprintf( stderr, "reframe render: live page: http://127.0.0.1:%d/\n", job->preview.port );
    return result;
}

// The file is there; what the one before it was named after may be finished.
static RfResult end_films( RfRenderJob* job, RfError* error )
{
    RfResult result = rf_end_films_file( &job->keeping, error );
    int first = job->frames[job->frames_done];
    if ( result != RF_OK )
        return result;
    if ( job->kept_films >= 0 && job->kept_films != first )
        rf_remove_films_file( &job->output, job->kept_films );
    job->kept_films = first;
    return RF_OK;
}

// Says how often films are saved, where that is news, or why they could not be.
static void report_autosave( RfRenderJob* job, const RfError* failure )
{
    RfAutosave* autosave = &job->autosave;
    double interval = rf_note_saved( autosave );
    bool warns = failure != NULL && !autosave->in_trouble;
    char size[RF_BYTES_TEXT_SIZE];
    rf_format_memory( job->keeping.bytes, size );
    autosave->in_trouble = failure != NULL;
    pthread_mutex_lock( &job->speech );
    if ( warns || interval > 0.0 )
        rf_clear_progress( &job->line );
    if ( warns )
        rf_warn( &job->log, "--autosave: the films of frames in work are not saved: %.900s", failure->text );
    else if ( failure == NULL && interval > 0.0 && !job->options.quiet )
        fprintf( stderr, "reframe render: --autosave: films of frames in work are saved, %s on disk, and again in %.3g s\n", size,
                 interval );
    pthread_mutex_unlock( &job->speech );
}

// The films of a render, into a file named after the first frame that is not written. NULL: that is all.
static RfResult on_save( void* user, const void* bytes, size_t size, RfError* error )
{
    RfRenderJob* job = user;
    RfFramesLeft left = { .output = &job->output,
                          .frames = job->frames + job->frames_done,
                          .count = job->frame_count - job->frames_done };
    RfResult result = job->keeping.open ? RF_OK : rf_create_films_file( &left, &job->keeping, error );
    if ( result == RF_OK )
        result = bytes != NULL ? rf_append_films( &job->keeping, bytes, size, error ) : end_films( job, error );
    job->not_kept = result == RF_OK ? ( RfError ){ 0 } : *error;
    if ( ( result != RF_OK && !rf_is_interrupted() ) || bytes == NULL )
        report_autosave( job, result != RF_OK ? error : NULL );
    return result;
}

static bool on_saves( void* user, size_t bytes )
{
    RfRenderJob* job = user;
    RfError error = { 0 };
    bool due = rf_is_save_due( &job->autosave, &job->output, bytes, &error );
    if ( error.code == RF_OK )
        return due;
    pthread_mutex_lock( &job->speech );
    rf_clear_progress( &job->line );
    rf_warn( &job->log, "--autosave: %.1000s", error.text );
    pthread_mutex_unlock( &job->speech );
    return due;
}

static RfResult on_load( void* user, void* bytes, size_t size, RfError* error )
{
    RfRenderJob* job = user;
    return fread( bytes, size, 1, job->films ) == 1 ? RF_OK
                                                    : rf_fail( error, RF_ERROR_IO, "the films of frame %d cannot be read",
                                                               rf_frame_number( &job->path, job->frames[0] ) );
}

static RfResult fail_interrupted( RfRenderJob* job, RfError* error )
{
    char films[RF_FILMS_NAME_SIZE + 256] = "", name[RF_FILMS_NAME_SIZE];
    if ( job->keeping.open )
        end_films( job, &job->not_kept );
    bool kept = job->kept_films >= 0 && rf_films_file_name( &job->output, job->kept_films, name, NULL ) == RF_OK;
    if ( job->not_kept.code != RF_OK )
        snprintf( films, sizeof films, "; without the films of those in work%s: %.900s", kept ? " but older ones" : "",
                  job->not_kept.text );
    else if ( kept )
        snprintf( films, sizeof films, " from the films in %.900s", name );
    return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted: %d of %d frames are finished and kept, %s continues%s",
                    job->kept_count + job->frames_done, job->kept_count + job->frame_count,
                    job->options.overwrite ? "--resume --overwrite" : "--resume", films );
}

static RfResult render( RfRenderJob* job, RfError* error )
{
    if ( rf_is_interrupted() )
        return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted before the first frame" );
    RF_TRY( start_preview( job, error ) );
    rf_clean_output_folder( job->options.output ); // killed in the midst of a file, a render leaves a part
    job->line = rf_create_progress_line( job->options.quiet );
    RfRenderCallbacks callbacks = { .user = job, .frame = on_run, .progress = on_progress, .save = on_save };
    callbacks.load = job->films != NULL ? on_load : NULL;
    callbacks.judge = job->denoiser != NULL ? on_judge : NULL;
    job->autosave.interval = job->options.autosave;
    callbacks.saves = job->options.autosave > 0.0 ? on_saves : NULL;
    RfShot shot = shot_of( job );
    callbacks.preview = job->options.preview != NULL ? on_preview : NULL;
    RfResult result = rf_render( &shot, &job->options.settings, &callbacks, &job->stats, error );
    job->stats.missed = job->errors.missed; // of frames, not of runs
    job->stats.flicker_missed = job->errors.flicker_missed;
    rf_clear_progress( &job->line );
    if ( result == RF_ERROR_INTERRUPTED && job->not_judged.code != RF_OK )
        return *error = job->not_judged, job->not_judged.code;
    if ( result == RF_ERROR_INTERRUPTED )
        return fail_interrupted( job, error );
    if ( result == RF_ERROR_USAGE && job->films != NULL )
    {
        RfError reason = *error;
        return rf_fail( error, result, "--resume: frame %d: %.900s: add --overwrite without --resume to start over",
                        rf_frame_number( &job->path, job->frames[0] ), reason.text );
    }
    if ( result == RF_OK )
        warn_of_solves( &job->errors, &job->log );
    if ( result == RF_OK )
        warn_of_stop( &job->errors, &job->options.settings, &job->stats, job->frame_count, job->run_count, job->denoiser != NULL,
                      &job->log );
    return result;
}

static RfResult write_json( const RfRenderJob* job, bool interrupted, RfError* error )
{
    const RfRenderOptions* options = &job->options;
    json_t* json = rf_render_json( job, rf_join_kept_frames( job ), interrupted );
    if ( job->scene.movement != NULL )
        rf_add_changes( &job->scene, interrupted ? NULL : job->tracer, options, json, NULL );
    return rf_write_json( options->json, json, error );
}

static RfResult report( RfRenderJob* job, RfError* error )
{
    const char* json_name = job->options.json;
    if ( json_name == NULL || strcmp( json_name, "-" ) != 0 )
    {
        rf_print( "%d frame%s in %s, %.1f s", job->frame_count, job->frame_count == 1 ? "" : "s", job->options.output,
                  rf_wall_seconds() - job->start );
        if ( job->errors.removes )
            printf( ", %.2g %% of the light removed", 100.0 * job->errors.removed_sum / job->errors.frames );
        if ( job->kept_count > 0 )
            printf( "; %d kept from before", job->kept_count );
        printf( "\n" );
        print_pilots( &job->options.settings, &job->stats );
        print_frame_errors( job );
    }
    return json_name == NULL ? rf_flush_output( error ) : write_json( job, false, error );
}

// What is of no use after the last frame.
static void clean_up( const RfRenderJob* job )
{
    for ( int i = 0; i < job->kept_count; ++i )
        rf_remove_films_file( &job->output, job->kept[i] );
    for ( int i = 0; i < job->frame_count; ++i )
        rf_remove_films_file( &job->output, job->frames[i] );
    rf_clean_output_folder( job->options.output );
}

static RfResult run( RfRenderJob* job, RfError* error )
{
    RfResult result = load_render_job( job, error );
    if ( result == RF_OK && job->options.check )
        return rf_check_render( job, error );
    if ( result == RF_OK )
        result = warn_before_render( job, error );
    job->frames_json = json_array();
    job->seconds_scene = rf_wall_seconds() - job->start;
    // where nothing is rendered: all frames exist already, or an interruption came first
    job->stats = ( RfRenderStats ){ .group = job->options.settings.group, .spp = job->options.settings.spp };
    if ( result == RF_OK && job->frame_count > 0 )
        result = render( job, error );
    if ( result == RF_OK )
        clean_up( job );
    if ( result == RF_OK || result == RF_ERROR_INTERRUPTED )
        rf_warn_of_clipped( job );
    if ( result == RF_ERROR_INTERRUPTED && job->options.json != NULL )
    {
        RfResult written = write_json( job, true, error ); // `error` keeps the line about the interruption
        return written == RF_OK ? result : written;
    }
    return result == RF_OK ? report( job, error ) : result;
}

int rf_command_render( int argc, char** argv )
{
    RfError error;
    bool help;
    RfRenderJob job = { .argc = argc,
                        .argv = argv,
                        .reported = { "render", json_array() },
                        .speech = PTHREAD_MUTEX_INITIALIZER,
                        .denoising = PTHREAD_MUTEX_INITIALIZER,
                        .start = rf_wall_seconds() };
    job.log = rf_keeping_log( &job.reported );
    RfResult result = rf_parse_render_options( argc, argv, &job.options, &help, &error );
    if ( result == RF_OK && help )
        result = rf_show_help( &rf_render_table, &error );
    else if ( result == RF_OK )
    {
        rf_catch_interrupts();
        result = run( &job, &error );
    }
    destroy_render_job( &job );
    return result == RF_OK ? 0 : rf_report_error( "render", &error );
}
