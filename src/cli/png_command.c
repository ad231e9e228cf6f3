// reframe png: EXR files as PNG, to look at.
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "reframe/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define COMMAND "png"

static double s_exposure;
static const char *s_layer, *s_frames;
static bool s_quiet;
static const char* const s_files[] = { "IN", "OUT" };
static const RfOption s_options[] = {
    { .name = "exposure",
      .type = RF_OPTION_REAL,
      .value = &s_exposure,
      .min = -32,
      .max = 32,
      .meta = "E",
      .help = "exposure in stops: each doubles the brightness" },
    { .name = "layer",
      .type = RF_OPTION_STRING,
      .value = &s_layer,
      .meta = "NAME",
      .default_text = "colour",
      .help = "a layer, part or channel of the files, or three channels X,Y,Z" },
    { .name = "frames",
      .type = RF_OPTION_STRING,
      .value = &s_frames,
      .meta = "A-B[xSTEP][,...]",
      .default_text = "all",
      .help = "convert only these frames of a sequence" },
    { .name = "quiet", .type = RF_OPTION_BOOL, .value = &s_quiet, .help = "no progress, no summary" },
};
static const RfCommandTable s_table = { .command = COMMAND,
                                        .summary = "Writes EXR files as 8-bit PNG with the sRGB curve, and with their alpha if "
                                                   "they have one. IN is a file, a sequence named with ####, or its folder; "
                                                   "OUT a file, a name with #### for a sequence, or an existing folder.",
                                        .files = s_files,
                                        .file_count = 2,
                                        .writes_last = true,
                                        .options = s_options,
                                        .option_count = sizeof s_options / sizeof s_options[0] };

// What is read and written.
typedef struct Job
{
    RfSequenceInput from;
    char to[RF_FILE_NAME_SIZE]; // a pattern or a file
} Job;

// In a folder the names are those of what is read.
static RfResult name_output( const char* to, Job* job, RfError* error )
{
    const char *from = job->from.pattern, *slash = strrchr( from, '/' ), *base = slash != NULL ? slash + 1 : from;
    const char* dot = strrchr( base, '.' );
    int length = dot != NULL ? (int)( dot - base ) : (int)strlen( base ), used;
    const char* end = to + strlen( to ) - 1;
    if ( rf_is_folder( to ) )
        used = snprintf( job->to, sizeof job->to, "%s%s%.*s.png", to, *end == '/' ? "" : "/", length, base );
    else
        used = snprintf( job->to, sizeof job->to, "%s", to );
    if ( used >= (int)sizeof job->to )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", to );
    dot = strrchr( job->to, '.' );
    if ( dot != NULL && strcasecmp( dot, ".exr" ) == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: ends as a file of another kind: name it .png", to );
    if ( job->from.count > 1 && !rf_is_sequence( job->to ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: has no #### for the number, but there are %d frames", to, job->from.count );
    return RF_OK;
}

// The channel A of a file; NULL where it has none of the size of its colour.
static float* read_alpha( const char* path, const RfImage* image )
{
    static const char* const s_name = "A";
    RfExrWindow window;
    float* alpha = NULL;
    if ( rf_read_exr_channels( path, &s_name, 1, &window, &alpha, NULL ) != RF_OK )
        return NULL;
    if ( window.width == image->width && window.height == image->height )
        return alpha;
    free( alpha );
    return NULL;
}

static RfResult convert( const char* from, const char* to, RfError* error )
{
    RfImage image = { 0 };
    RfExrWindow window;
    RfResult result =
        s_layer == NULL ? rf_read_exr( from, &image, error ) : rf_read_exr_layer( from, s_layer, &image, &window, error );
    if ( result != RF_OK )
        return result;
    float* alpha = s_layer == NULL ? read_alpha( from, &image ) : NULL;
    result = rf_write_png_alpha( to, &image, alpha, (float)s_exposure, error );
    free( alpha );
    rf_destroy_image( &image );
    return result;
}

static RfResult convert_frame( const Job* job, int frame, RfError* error )
{
    char from[RF_FILE_NAME_SIZE], to[RF_FILE_NAME_SIZE];
    RfResult result = rf_sequence_name( job->from.pattern, frame, from, sizeof from, error );
    if ( result == RF_OK )
        result = rf_sequence_name( job->to, frame, to, sizeof to, error );
    return result == RF_OK ? convert( from, to, error ) : result;
}

static RfResult run( const char* const files[2], Job* job, RfError* error )
{
    const RfSequenceInput* from = &job->from;
    RfLog log = rf_stderr_log( COMMAND );
    RfResult result = rf_find_sequence_input( files[0], s_frames, &job->from, error );
    if ( result == RF_OK )
        result = name_output( files[1], job, error );
    if ( result == RF_OK && !from->is_sequence )
        return convert( from->pattern, job->to, error );
    if ( result == RF_OK && s_frames == NULL )
        result = rf_warn_of_missing( from, &log, error );
    for ( int i = 0; i < from->count && result == RF_OK; ++i )
    {
        result = convert_frame( job, from->frames[i], error );
        rf_show_frame_count( s_quiet, i + 1, from->count );
    }
    if ( result != RF_OK || s_quiet )
        return result;
    rf_print( "%d frame%s in %s\n", from->count, from->count == 1 ? "" : "s", job->to );
    return rf_flush_output( error );
}

int rf_command_png( int argc, char** argv )
{
    const char* files[2];
    bool help;
    RfError error;
    Job job = { .from = { .count = 0 } };
    RfResult result = rf_parse_options( &s_table, argc, argv, files, &help, &error );
    if ( result == RF_OK && help )
        result = rf_show_help( &s_table, &error );
    else if ( result == RF_OK )
        result = run( files, &job, &error );
    rf_free_sequence_input( &job.from );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
