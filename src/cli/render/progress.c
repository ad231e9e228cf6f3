// The progress line: share done, time left, error and rate; rewritten in place on a terminal only.
#include "cli/render/progress.h"

#include "cli/messages.h"
#include "cli/render/render_json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define COLUMNS 80       // of a terminal: the line has fewer
#define LOG_SECONDS 10.0 // between lines where standard error is no terminal

RfProgressLine rf_create_progress_line( bool quiet )
{
    return ( RfProgressLine ){ .quiet = quiet, .terminal = isatty( STDERR_FILENO ) == 1, .shown = -1.0 };
}

static void format_duration( double seconds, char* text, size_t size )
{
    // A tiny share makes the estimate meaningless: leave it out.
    if ( !isfinite( seconds ) || seconds > 1e6 )
    {
        snprintf( text, size, "-:--" );
        return;
    }
    long whole = (long)ceil( seconds );
    if ( whole < 3600 )
        snprintf( text, size, "%ld:%02ld", whole / 60, whole % 60 );
    else
        snprintf( text, size, "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60 );
}

static void format_rate( double rate, char* text, size_t size )
{
    if ( !isfinite( rate ) || rate < 0.0 )
        rate = 0.0;
    if ( rate >= 1e6 )
        snprintf( text, size, "%.1f M samples/s", rate * 1e-6 );
    else
        snprintf( text, size, "%.0f k samples/s", rate * 1e-3 );
}

// Appends a part if the line still fits the terminal.
static bool append_part( char* text, size_t size, const char* part )
{
    size_t length = strlen( text ), most = size < COLUMNS ? size : COLUMNS;
    if ( length + 2 + strlen( part ) >= most )
        return false;
    snprintf( text + length, size - length, "  %s", part );
    return true;
}

static void append_noise( const RfProgress* progress, char* text, size_t size )
{
    char noise[RF_NOISE_TEXT_SIZE], part[96];
    const char* bound = progress->relmse_is_lower_bound ? "at least " : "";
    if ( !isgreater( progress->relmse, 0.0 ) || !isfinite( progress->relmse ) )
        return;
    rf_format_noise( progress->relmse, noise );
    snprintf( part, sizeof part, "noise %s%s (relMSE %.2g)", bound, noise, progress->relmse );
    if ( append_part( text, size, part ) )
        return;
    snprintf( part, sizeof part, "noise %s%s", bound, noise );
    append_part( text, size, part );
}

void rf_format_progress( const RfProgress* progress, char* text, size_t size )
{
    char spent[48], left[48], part[64], flicker[RF_NOISE_TEXT_SIZE];
    format_duration( floor( progress->seconds ), spent, sizeof spent );
    format_duration( progress->left, left, sizeof left );
    int frame = progress->frames_done < progress->frames_all ? progress->frames_done + 1 : progress->frames_all;
    snprintf( text, size, "frame %d/%d  %.0f %%  %s spent  %s left", frame, progress->frames_all,
              floor( 100.0 * progress->share ), spent, left );
    append_noise( progress, text, size );
    rf_format_flicker( progress->flicker, flicker );
    snprintf( part, sizeof part, "flicker %s%s", progress->flicker_is_lower_bound ? "at least " : "", flicker );
    if ( isgreater( progress->flicker, 0.0 ) && isfinite( progress->flicker ) )
        append_part( text, size, part );
    format_rate( progress->samples / progress->seconds, part, sizeof part );
    append_part( text, size, part );
}

void rf_clear_progress( RfProgressLine* line )
{
    if ( line->width > 0 )
        fprintf( stderr, "\r%*s\r", line->width, "" );
    line->width = 0;
}

void rf_show_progress( RfProgressLine* line, const RfProgress* progress )
{
    double next = line->terminal ? ( line->shown >= 0.0 ? line->shown + 0.1 : 0.0 ) : fmax( line->shown, 0.0 ) + LOG_SECONDS;
    if ( line->quiet || progress->seconds < next )
        return;
    char text[160];
    rf_format_progress( progress, text, sizeof text );
    line->shown = progress->seconds;
    if ( !line->terminal )
    {
        fprintf( stderr, "%s\n", text );
        return;
    }
    // Padded to overwrite the previous line.
    line->width = fprintf( stderr, "\r%-*s", line->width > 1 ? line->width - 1 : 0, text );
    fflush( stderr );
}

void rf_show_frame( RfProgressLine* line, const RfFrameResult* result, int number, int done, int all, double seconds )
{
    char spent[48];
    if ( line->quiet || line->terminal )
        return;
    format_duration( floor( seconds ), spent, sizeof spent );
    fprintf( stderr, "frame %d/%d  number %d  %.2f s  %s spent", done, all, number, result->seconds, spent );
    char noise[RF_NOISE_TEXT_SIZE];
    rf_format_noise( result->relmse_estimate, noise );
    if ( result->specks.share >= RF_SPECKS_STAND_OUT )
    {
        rf_format_noise( result->specks.rest, noise );
        fprintf( stderr, "  %d speck%s %.0f %% of the error, the rest: noise %s (relMSE %.3g)", result->specks.pixels,
                 result->specks.pixels == 1 ? " holds" : "s hold", floor( 100.0 * result->specks.share ), noise,
                 result->specks.rest );
    }
    else if ( result->relmse_is_lower_bound )
        fprintf( stderr, "  noise at least %s (relMSE %.3g, likely %.3g: ten pixels hold %.0f %% of it)", noise,
                 result->relmse_estimate, result->relmse_likely, 100.0 * result->worst_ten_share );
    else if ( isfinite( result->relmse_estimate ) )
        fprintf( stderr, "  noise %s (relMSE %.3g)", noise, result->relmse_estimate );
    if ( result->denoised != NULL && isfinite( result->denoised->denoised.relmse ) )
    {
        rf_format_noise( fmax( result->denoised->denoised.relmse, 0.0 ), noise );
        fprintf( stderr, "  denoised %s (relMSE %.3g)", noise, result->denoised->denoised.relmse );
    }
    rf_format_flicker( result->flicker_estimate, noise );
    if ( isgreater( result->flicker_estimate, 0.0 ) )
        fprintf( stderr, "  flicker %s%s", result->flicker_is_lower_bound ? "at least " : "", noise );
    rf_format_flicker( result->flicker_likely, noise );
    if ( result->flicker_is_lower_bound )
        fprintf( stderr, ", likely %s", noise );
    fprintf( stderr, "  %.4g samples/pixel, %.4g effective\n", result->native_spp, result->effective_spp );
}

void rf_show_frame_count( bool quiet, int done, int all )
{
    if ( !quiet && isatty( STDERR_FILENO ) != 0 )
        fprintf( stderr, "\r%d of %d frames%s", done, all, done == all ? "\n" : "" );
}
