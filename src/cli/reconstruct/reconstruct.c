// reframe reconstruct: images from primal and gradients in EXR files.

#include "base/system.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/options.h"
#include "cli/reconstruct/reconstruct_solve.h"
#include "cli/render/progress.h"
#include "image/sequence.h"

#include <stdlib.h>
#include <string.h>

#define COMMAND "reconstruct"

// What was asked for, and how it went.
typedef struct Job
{
    RfReconstructFiles files;
    const char *output, *json;
    RfReconstructChoice choice;
    RfReconstructSolve solve; // the last
    RfReconstructInfo info;   // the worst of all frames
    bool half, quiet, table;
    double seconds;
    json_t *rows, *warnings;
    RfLog* log;
} Job;

static const char* method_name( const Job* job ) { return rf_reconstruct_methods[job->solve.options.method]; }

// What the header says of the image.
static void describe( const Job* job, char* text, size_t size )
{
    if ( job->solve.options.method == RF_RECONSTRUCT_WEIGHTED )
        snprintf( text, size, "weighted, %s",
                  job->solve.own_weights ? "weights from the same data: biased" : "weights from the other half: unbiased" );
    else
        snprintf( text, size, "%s, alpha %g: %s", method_name( job ), (double)job->solve.options.alpha,
                  job->info.biased ? "biased" : "unbiased" );
}

static RfResult write_image( const Job* job, int number, const RfReconstructFrame* frame, const RfImage* image, RfError* error )
{
    char name[RF_FILE_NAME_SIZE], text[128];
    describe( job, text, sizeof text );
    const RfExrString said = { "reframe/reconstruction", text };
    RfExrOptions options = rf_default_exr_options();
    options.half = job->half;
    options.x = frame->window.x;
    options.y = frame->window.y;
    options.fps_numerator = frame->fps_numerator;
    options.fps_denominator = frame->fps_denominator;
    options.strings = &said;
    options.string_count = 1;
    RfResult result = RF_OK;
    if ( job->files.inputs[0].is_sequence )
        result = rf_sequence_name( job->output, number, name, sizeof name, error );
    return result == RF_OK ? rf_write_exr( job->files.inputs[0].is_sequence ? name : job->output, image, &options, error )
                           : result;
}

static void keep( Job* job, int number, const RfReconstructInfo* info, double seconds )
{
    job->info.iterations = info->iterations > job->info.iterations ? info->iterations : job->info.iterations;
    job->info.residual = info->residual > job->info.residual ? info->residual : job->info.residual;
    job->info.converged = job->info.converged && info->converged;
    job->info.biased = job->info.biased || info->biased;
    job->seconds += seconds;
    if ( !info->converged )
        rf_warn( job->log, "frame %d: not converged: after %d iterations the residual is %.2g", number, info->iterations,
                 info->residual );
    json_array_append_new( job->rows,
                           json_pack( "{s:i, s:s, s:i, s:o, s:b, s:b, s:o}", "frame", number, "method", method_name( job ),
                                      "iterations", info->iterations, "residual", rf_json_number( info->residual ), "converged",
                                      info->converged, "biased", info->biased, "seconds", rf_json_number( seconds ) ) );
}

static RfResult reconstruct_frame( Job* job, int number, RfError* error )
{
    RfReconstructFrame frame;
    RfImage image = { 0 };
    RfReconstructInfo info = { 0 };
    char name[RF_FILE_NAME_SIZE];
    const RfSequenceInput* input = job->files.inputs;
    snprintf( name, sizeof name, "%s", input->pattern );
    RfResult result = input->is_sequence ? rf_sequence_name( input->pattern, number, name, sizeof name, error ) : RF_OK;
    if ( result != RF_OK )
        return result;
    result = rf_read_reconstruct_frame( &job->files, number, &frame, error );
    double start = rf_wall_seconds();
    if ( result == RF_OK )
        result = rf_solve_frame( &job->choice, &frame, name, &job->solve, &image, &info, error );
    if ( result == RF_OK )
    {
        keep( job, number, &info, rf_wall_seconds() - start );
        result = write_image( job, number, &frame, &image, error );
    }
    rf_destroy_image( &image );
    rf_free_reconstruct_frame( &frame );
    return result;
}

static RfResult finish( Job* job, RfError* error )
{
    char text[128];
    int count = (int)json_array_size( job->rows );
    describe( job, text, sizeof text );
    if ( job->table && !job->quiet )
        rf_print( "%d frame%s in %s: %s; %d iterations, residual %.1e, %.2f s\n", count, count == 1 ? "" : "s", job->output, text,
                  job->info.iterations, job->info.residual, job->seconds );
    if ( job->json == NULL )
        return rf_flush_output( error );
    json_t* json = json_pack( "{s:O, s:s, s:i, s:i, s:o, s:b, s:b, s:o, s:O}", "frames", job->rows, "method", method_name( job ),
                              "halves", job->solve.half_count, "iterations", job->info.iterations, "residual",
                              rf_json_number( job->info.residual ), "converged", job->info.converged, "biased", job->info.biased,
                              "seconds", rf_json_number( job->seconds ), "warnings", job->warnings );
    if ( json != NULL && job->solve.options.method != RF_RECONSTRUCT_WEIGHTED )
        json_object_set_new( json, "alpha", rf_json_number( job->choice.alpha ) );
    return rf_write_json( job->json, json, error );
}

static RfResult run( Job* job, RfError* error )
{
    const RfSequenceInput* input = job->files.inputs;
    if ( job->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "-o FILE is missing, see reframe reconstruct --help" );
    RfResult result = rf_find_reconstruct_files( &job->files, error );
    if ( result == RF_OK && input->is_sequence && !rf_is_sequence( job->output ) )
        result = rf_fail( error, RF_ERROR_USAGE, "-o: %s: has no #### for the number of the frame", job->output );
    for ( int k = 0; k < 4 && result == RF_OK; ++k )
    {
        if ( rf_may_be_same_file( input[k].pattern, job->output ) )
            result = rf_fail( error, RF_ERROR_USAGE, "-o: %s: is what is read: choose another name", job->output );
    }
    if ( result == RF_OK && input->is_sequence && job->files.frames == NULL )
        result = rf_warn_of_missing( input, job->log, error );
    int count = input->is_sequence ? input->count : 1;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        result = reconstruct_frame( job, input->is_sequence ? input->frames[i] : 1, error );
        rf_show_frame_count( job->quiet || count < 2, i + 1, count );
    }
    if ( result == RF_OK && job->solve.own_weights )
        rf_warn( job->log, "the weights come from the data that they weigh, which biases the image: give the two halves" );
    return result == RF_OK ? finish( job, error ) : result;
}

#define TEXT_OPTION( option, to, what, usual, words )                                                                            \
    {                                                                                                                            \
        .name = option, .type = RF_OPTION_STRING, .value = &( to ), .meta = what, .default_text = usual, .help = words           \
    }

int rf_command_reconstruct( int argc, char** argv )
{
    static const char* const names[] = { "IMAGES" };
    Job job = { .choice.alpha = 0.2, .info = { .converged = true } };
    const RfOption options[] = {
        { .name = "output",
          .letter = 'o',
          .writes = ".exr",
          .type = RF_OPTION_STRING,
          .value = &job.output,
          .meta = "FILE",
          .help = "the image; for a sequence with #### for the frame" },
        { .name = "method",
          .type = RF_OPTION_CHOICE,
          .value = &job.choice.method,
          .given = &job.choice.method_given,
          .choices = rf_reconstruct_methods,
          .default_text = "weighted where two halves have variances, else l2",
          .help = "constant weights; inverse variances of the other half; least absolute differences, which is biased" },
        { .name = "alpha",
          .type = RF_OPTION_REAL,
          .value = &job.choice.alpha,
          .given = &job.choice.alpha_given,
          .min = 1e-4,
          .max = 1e4,
          .meta = "A",
          .default_text = "0.2",
          .help = "of l2 and l1: how much the primal counts against the gradients" },
        TEXT_OPTION( "primal", job.files.primal, "NAME", "primal, else the colour", "the layer of the noisy image, or X,Y,Z" ),
        TEXT_OPTION( "dx", job.files.dx, "NAME", "dx", "the layer of differences to the pixel on the right" ),
        TEXT_OPTION( "dy", job.files.dy, "NAME", "dy", "the layer of differences to the pixel below" ),
        TEXT_OPTION( "variance", job.files.variance, "A,X,Y", "primal.variance,dx.variance,dy.variance",
                     "three channels: variances of primal, dx and dy" ),
        { .name = "dx-from",
          .type = RF_OPTION_STRING,
          .value = &job.files.dx_from,
          .reads = true,
          .meta = "FILE",
          .help = "dx are in this file or sequence instead" },
        { .name = "dy-from",
          .type = RF_OPTION_STRING,
          .value = &job.files.dy_from,
          .reads = true,
          .meta = "FILE",
          .help = "dy are in this file or sequence instead" },
        TEXT_OPTION( "frames", job.files.frames, "A-B[xSTEP][,...]", "all", "only these of the sequence, by their numbers" ),
        { .name = "half",
          .type = RF_OPTION_BOOL,
          .value = &job.half,
          .default_text = "off",
          .help = "16-bit floats instead of 32" },
        { .name = "json",
          .writes = ".json",
          .type = RF_OPTION_STRING,
          .value = &job.json,
          .meta = "FILE",
          .help = "how the solves went as JSON in FILE, - for standard output" },
        { .name = "quiet", .type = RF_OPTION_BOOL, .value = &job.quiet, .help = "no progress, no line about what was written" },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "Reconstructs images from a noisy primal image and noisy gradients, layers of EXR files of this or another "
                   "program. IMAGES is a file, a sequence named with ####, or its folder; or two of them, the independent halves "
                   "of a render. Halves may also be the layers even.primal, even.dx, odd.primal and so on of one file.",
        .files = names,
        .file_count = 1,
        .file_max = 2,
        .file_total = &job.files.image_count,
        .options = options,
        .option_count = sizeof options / sizeof options[0],
    };
    RfError error = { 0 };
    bool help = false;
    RfResult result = rf_parse_options( &table, argc, argv, job.files.images, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &table, stdout );
        result = rf_flush_output( &error );
        return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
    }
    job.rows = json_array();
    job.warnings = json_array();
    RfToldWarnings told = { COMMAND, job.warnings };
    RfLog log = rf_keeping_log( &told );
    job.log = &log;
    job.table = job.json == NULL || strcmp( job.json, "-" ) != 0;
    if ( result == RF_OK )
        result = run( &job, &error );
    rf_free_reconstruct_files( &job.files );
    json_decref( job.rows );
    json_decref( job.warnings );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
