// reframe png: EXR files as PNG, to look at.
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/png/png_picture.h"
#include "cli/options/frame_lists.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "cli/view/view_options.h"
#include "reframe/output.h"

#include <stdio.h>
#include <string.h>

#define COMMAND "png"

static RfViewOptions s_view;
static RfPngPicture s_picture;
static const char* s_frames;
static int s_window;
static bool s_quiet;
static const char* const s_windows[] = { "display", "data", NULL };
static const char* const s_files[] = { "IN", "OUT" };
static const RfOption s_options[] = {
    RF_REAL_OPTION( "exposure", &s_view.exposure, -32, 32, "E|auto",
                    "exposure in stops: each doubles the brightness; auto: middle grey, for all frames alike",
                    .given = &s_view.exposure_given, .keyword = "auto", .keyword_value = RF_EXPOSURE_AUTO,
                    .default_text = "the files', else 0" ),
    RF_VIEW_OPTIONS( s_view, RF_HEADING_BASIC ),
    RF_TEXT_OPTION(
        "layer", &s_picture.layer, "NAME",
        "a pass, such as depth, light_key or CryptoObject, drawn so that it can be seen; or a part, a channel, or three "
        "channels X,Y,Z as they are",
        .default_text = "colour" ),
    RF_TEXT_OPTION( "matte", &s_picture.matte, "NAME",
                    "the pixels that an object, material or asset of this name covers, by the Cryptomatte of the files" ),
    RF_TEXT_OPTION( "mix", &s_picture.mix, "GROUP=F[,...]",
                    "the sum of the light groups, these with other factors: key=0.3,fill=2; the others with 1" ),
    RF_CHOICE_OPTION( "window", &s_window, s_windows, "the picture alone, or all pixels of the files, with overscan" ),
    RF_TEXT_OPTION( "frames", &s_frames, "[@]A-B[xSTEP][,...]", "convert only these frames of a sequence",
                    .default_text = "all" ),
    RF_FLAG_OPTION( "quiet", &s_quiet, "no progress, no summary" ),
};
static const RfCommandTable s_table = { .command = COMMAND,
                                        .summary =
                                            "Writes EXR files as 8-bit PNG, by the view that they name or the sRGB curve, "
                                            "and with their alpha if they have one. IN is a file, a sequence named with "
                                            "####, or its folder; OUT a file, a name with #### for a sequence, or a folder, "
                                            "which is made where it is missing.",
                                        RF_TABLE_ROWS( s_files, s_options ),
                                        .writes_last = ".png" };

// What is read and written.
typedef struct Job
{
    const char* files[2];
    RfSequenceInput from;
    char to[RF_FILE_NAME_SIZE]; // a pattern or a file
    RfView* view;               // NULL: what is shown is no light
} Job;

// Is this the folder of the files? Of a sequence, what is not called .png is.
static bool is_folder_name( const char* to, const RfSequenceInput* from )
{
    const char* dot = strrchr( to, '.' );
    return rf_is_folder( to ) || to[strlen( to ) - 1] == '/' ||
           ( from->is_sequence && !rf_is_sequence( to ) && ( dot == NULL || strchr( dot, '/' ) != NULL ) );
}

// In a folder the names are those of what is read.
static RfResult name_output( const char* to, Job* job, RfError* error )
{
    const char *from = job->from.pattern, *slash = strrchr( from, '/' ), *base = slash != NULL ? slash + 1 : from;
    const char* dot = strrchr( base, '.' );
    int length = dot != NULL ? (int)( dot - base ) : (int)strlen( base ), used;
    const char* end = to + strlen( to ) - 1;
    if ( is_folder_name( to, &job->from ) )
        used = snprintf( job->to, sizeof job->to, "%s%s%.*s.png", to, *end == '/' ? "" : "/", length, base );
    else
        used = snprintf( job->to, sizeof job->to, "%s", to );
    if ( used >= (int)sizeof job->to )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", to );
    if ( job->from.count > 1 && !rf_is_sequence( job->to ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: has no #### for the number, but there are %d frames", to, job->from.count );
    return RF_OK;
}

static RfResult convert_frame( const Job* job, int frame, RfError* error )
{
    char from[RF_FILE_NAME_SIZE], to[RF_FILE_NAME_SIZE];
    RfResult result = rf_sequence_input_name( &job->from, frame, from, error );
    if ( result == RF_OK )
        result = rf_sequence_name( job->to, frame, to, sizeof to, error );
    return result == RF_OK ? rf_write_png_picture( &s_picture, from, to, error ) : result;
}

// The first frame, the one in the middle and the last stand for all.
typedef struct Samples
{
    char names[3][RF_FILE_NAME_SIZE];
    const char* paths[3];
    int count;
} Samples;

static RfResult choose_samples( const RfSequenceInput* from, Samples* samples, RfError* error )
{
    int all = from->is_sequence ? from->count : 1, chosen[3] = { 0, all / 2, all - 1 };
    RfResult result = RF_OK;
    samples->count = all < 3 ? all : 3;
    for ( int i = 0; i < samples->count && result == RF_OK; ++i )
    {
        samples->paths[i] = samples->names[i];
        result = rf_sequence_input_name( from, from->is_sequence ? from->frames[chosen[i]] : 0, samples->names[i], error );
    }
    return result;
}

// As the first frame has it; for light, or where one is asked for.
static RfResult open_view( Job* job, const Samples* samples, RfError* error )
{
    RfLog log = rf_stderr_log( COMMAND );
    RfViewText chosen;
    bool automatic = s_view.exposure_given && s_view.exposure == (double)RF_EXPOSURE_AUTO;
    RfResult result = RF_OK;
    if ( !s_picture.takes_exposure && ( s_view.exposure_given || s_view.view != NULL || s_view.look != NULL ) )
        rf_warn( &log, "%s is no light: exposure and view do not change it",
                 s_picture.matte != NULL ? "a matte" : s_picture.layer );
    if ( !s_picture.takes_exposure )
        return RF_OK;
    if ( automatic )
        result = rf_find_exposure( samples->paths, samples->count, &s_view.exposure, error );
    s_picture.exposure = s_view.exposure;
    if ( result == RF_OK && ( s_picture.takes_view || s_view.view != NULL ) )
        result = rf_open_chosen_view( &s_view, samples->paths[0], &log, &job->view, &chosen, error );
    s_picture.view = job->view;
    return result;
}

static RfResult open_picture( Job* job, RfError* error )
{
    Samples samples;
    s_picture.data_window = s_window == 1;
    RfResult result = choose_samples( &job->from, &samples, error );
    if ( result == RF_OK )
        result = rf_find_png_picture( &s_picture, samples.paths, samples.count, error );
    return result == RF_OK ? open_view( job, &samples, error ) : result;
}

static RfResult run( void* user, RfError* error )
{
    Job* job = user;
    const RfSequenceInput* from = &job->from;
    RfLog log = rf_stderr_log( COMMAND );
    RfResult result = rf_find_sequence_input( job->files[0], s_frames, &job->from, error );
    if ( result == RF_OK )
        result = name_output( job->files[1], job, error );
    if ( result == RF_OK )
        result = open_picture( job, error );
    if ( result == RF_OK )
        result = rf_prepare_output_folder( job->to, error );
    if ( result == RF_OK && !from->is_sequence )
        return rf_write_png_picture( &s_picture, from->pattern, job->to, error );
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
    Job job = { .view = NULL };
    int status = rf_run_command( &s_table, argc, argv, job.files, run, &job );
    rf_close_view( job.view );
    rf_free_sequence_input( &job.from );
    return status;
}
