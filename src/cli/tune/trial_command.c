// Runs `tune` and `cost`: parses, loads, searches, and reports as text, SVG and JSON.
#include "cli/tune/trial_command.h"

#include "base/system.h"
#include "base/try.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDEST 4.0 // times the lower end of its interval: the upper one of a figure that is printed

bool rf_is_known( const RfInterval* value )
{
    return isfinite( value->value ) && isgreater( value->low, 0.0 ) && islessequal( value->high, WIDEST * value->low );
}

// What is said of a gain of which so little is known; an interval shrinks as the root of the time.
static void format_unknown( const RfInterval* gain, double spent, char* text, size_t size )
{
    char span[32];
    double width = log( gain->high / gain->low ) / log( WIDEST );
    rf_format_span( spent * width * width, span, sizeof span );
    if ( isgreater( gain->low, 1.0 ) )
        snprintf( text, size, "at least %.2g times faster than path tracing at equal noise", gain->low );
    else if ( isless( gain->high, 1.0 ) )
        snprintf( text, size, "at least %.2g times slower than path tracing at equal noise", 1.0 / gain->high );
    else if ( isfinite( width ) )
        snprintf( text, size, "gain over path tracing not known within the budget: needs about %s", span );
    else
        snprintf( text, size, "gain over path tracing not known within the budget" );
}

void rf_format_gain( const RfInterval* gain, double spent, char* text, size_t size )
{
    bool slower = isless( gain->value, 1.0 );
    double value = slower ? 1.0 / gain->value : gain->value;
    if ( !isfinite( value ) )
        snprintf( text, size, "not compared with path tracing" );
    else if ( !rf_is_known( gain ) )
        format_unknown( gain, spent, text, size );
    else if ( gain->low <= 1.0 && gain->high >= 1.0 )
        snprintf( text, size, "%s path tracing at equal noise (%.2f times its speed, 95 %%: %.2f to %.2f)",
                  value < 1.1 ? "about as fast as"
                  : slower    ? "possibly slower than"
                              : "possibly faster than",
                  gain->value, gain->low, gain->high );
    else
        snprintf( text, size, "%.2g times %s than path tracing at equal noise (95 %%: %.2g to %.2g)", value,
                  slower ? "slower" : "faster", slower ? 1.0 / gain->high : gain->low, slower ? 1.0 / gain->low : gain->high );
}

void rf_format_figure( const RfInterval* value, char text[RF_FIGURE_SIZE] )
{
    if ( rf_is_known( value ) )
        snprintf( text, RF_FIGURE_SIZE, "%.3g", value->value );
    else if ( isfinite( value->low ) && isgreater( value->low, 0.0 ) )
        snprintf( text, RF_FIGURE_SIZE, ">%.2g", value->low );
    else
        snprintf( text, RF_FIGURE_SIZE, "?" );
}

void rf_format_span( double seconds, char* text, size_t size )
{
    static const struct
    {
        double below, unit;
        const char* name;
    } units[] = { { 120.0, 1.0, "s" }, { 7200.0, 60.0, "min" }, { 172800.0, 3600.0, "h" }, { INFINITY, 86400.0, "days" } };
    int k = 0;
    while ( k < 3 && !isless( seconds, units[k].below ) )
        k += 1;
    double value = seconds / units[k].unit;
    snprintf( text, size, isless( value, 10.0 ) ? "%.2g %s" : "%.0f %s", value, units[k].name );
}

void rf_format_reuse( int eyes, const RfTile* tile, char* text, size_t size )
{
    char name[RF_TILE_NAME_SIZE];
    rf_tile_name( tile, name );
    bool tiles = tile->kind != RF_TILE_NONE;
    if ( eyes > 1 )
        snprintf( text, size, tiles ? "groups of %d and %s tiles" : "groups of %d", eyes, name );
    else if ( tiles )
        snprintf( text, size, "%s tiles", name );
    else
        snprintf( text, size, "path tracing" );
}

// Parses the command line over a scene file's defaults, or with NULL over ours.
static RfResult parse( const RfField* defaults, RfTrialCommand* c, RfError* error )
{
    RfRenderOptions* render = &c->options->render;
    c->reset();
    RfResult result = defaults != NULL ? rf_read_render_defaults( defaults, render ) : RF_OK;
    if ( result == RF_OK )
        result = rf_parse_options( c->table, c->argc, c->argv, &render->scene, &c->help, error );
    return result == RF_OK && !c->help ? c->settle( c->user, error ) : result;
}

// Makes a path of the runs alone.
static void keep_runs( RfCameraPath* path )
{
    free( path->eyes );
    free( path->run_of_frame );
    path->eyes = path->runs;
    path->count = path->run_count;
    path->runs = NULL;
    path->run_of_frame = NULL;
}

static RfResult choose_runs( RfTrialCommand* c, RfError* error )
{
    int count, runs;
    RF_TRY( rf_choose_frames( c->options->render.frames, &c->file, &c->path, &c->asked, &count, error ) );
    c->frames = rf_runs_of_frames( &c->path, c->asked, count, &runs );
    c->asked_runs = malloc( (size_t)count * sizeof( int ) );
    if ( c->frames == NULL || c->asked_runs == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %d frames", count );
    for ( int i = 0; i < count; ++i )
    {
        c->asked_runs[i] = c->path.run_of_frame[c->asked[i]];
        c->asked[i] = rf_frame_number( &c->path, c->asked[i] );
    }
    c->asked_count = count;
    keep_runs( &c->path );
    c->shot = ( RfShot ){ NULL, c->path.eyes, c->path.count, c->frames, runs };
    return RF_OK;
}

// Loads what the options name. The size becomes that of the path.
static RfResult load( RfTrialCommand* c, RfError* error )
{
    RfRenderOptions* options = &c->options->render;
    RfLog log = rf_stderr_log( c->table->command );
    RF_TRY( rf_open_scene_file( options->scene, &c->file, error ) );
    RfField defaults = rf_scene_file_defaults( &c->file, error );
    RfResult result = RF_OK;
    if ( defaults.json != NULL )
        result = parse( &defaults, c, error );
    if ( result == RF_OK )
        result = rf_load_scene_file( &c->file, &options->movement, &c->scene, &log, error );
    if ( result == RF_OK )
        result = rf_check_rendered( &c->scene, error );
    if ( result == RF_OK )
        result = rf_check_file_light_groups( options, &c->file, &c->scene, error );
    rf_take_scene_depth( options, &c->scene );
    if ( result == RF_OK )
        result = rf_take_effect_options( options, &c->scene, &log, error );
    if ( result == RF_OK )
        result = rf_create_asked_path( options, &c->scene, &c->path, &log, error );
    if ( result != RF_OK )
        return result;
    options->size = ( RfSize ){ c->path.eyes[0].width, c->path.eyes[0].height };
    result = choose_runs( c, error );
    if ( result == RF_OK )
        result = rf_create_tracer_by( options->settings.threads, &c->scene, &c->tracer, error );
    c->shot.tracer = c->tracer;
    return result == RF_OK ? rf_warn_of_depth( &c->shot, options, &log, &c->beyond_depth, error ) : result;
}

static void unload( RfTrialCommand* c )
{
    rf_destroy_tracer( c->tracer );
    rf_destroy_camera_path( &c->path );
    rf_destroy_scene( &c->scene );
    rf_close_scene_file( &c->file );
    free( c->frames );
    free( c->asked );
    free( c->asked_runs );
}

static RfResult report( const RfTrialCommand* c, RfError* error )
{
    const char *json = c->options->render.json, *svg = c->options->svg;
    RfResult result = c->finish( c->user, error );
    if ( result == RF_OK && rf_prints_text( json ) )
    {
        c->print( c->user );
        result = rf_flush_output( error );
    }
    if ( result == RF_OK && svg != NULL )
        result = c->plot( c->user, svg, error );
    return result == RF_OK && json != NULL ? rf_write_json( json, c->json( c->user ), error ) : result;
}

static RfResult run( RfTrialCommand* c, RfError* error )
{
    rf_catch_interrupts();
    RfResult result = load( c, error );
    if ( result == RF_OK )
        result = c->search( c->user, error );
    RfError interruption = *error;
    if ( result != RF_OK && !( result == RF_ERROR_INTERRUPTED && c->found ) )
        return result;
    RfResult reported = report( c, error );
    if ( reported == RF_OK && result != RF_OK )
        *error = interruption;
    return reported == RF_OK ? result : reported;
}

int rf_run_trial_command( RfTrialCommand* c )
{
    RfError error = { 0 };
    c->start = rf_wall_seconds();
    RfResult result = parse( NULL, c, &error );
    if ( result == RF_OK )
        result = c->help ? rf_show_help( c->table, &error ) : run( c, &error );
    unload( c );
    return result == RF_OK ? 0 : rf_report_error( c->table->command, &error );
}

#define OVERTIME 0.1 // of the budget, and these seconds, for what is being rendered
#define OVERTIME_SECONDS 2.0

double rf_budget_left( const RfTrialCommand* c, double* deadline )
{
    double budget = c->options->budget, now = rf_wall_seconds(), left = c->start + budget - now;
    left = left > 0.5 * budget ? left : 0.5 * budget;
    *deadline = now + left + OVERTIME * budget + OVERTIME_SECONDS;
    return left;
}

json_t* rf_trial_row_json( json_t* object, const RfTrialRow* row )
{
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &row->tile, tile );
    rf_json_add( object, "{s:i, s:s, s:i}", "group", row->group, "tile", tile, "spp", row->spp );
    return RF_SET_FIGURES( object, { "seconds", row->seconds }, { "cpu_seconds", row->cpu_seconds }, { "relmse", row->relmse } );
}

const char* rf_scene_title( const RfTrialOptions* options )
{
    const char* slash = strrchr( options->render.scene, '/' );
    return slash != NULL ? slash + 1 : options->render.scene;
}
