// reframe reconstruct: images from primal and gradients in EXR files.
#include "base/system.h"
#include "base/try.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/shared_options.h"
#include "cli/render/progress.h"
#include "image/exr.h"
#include "image/sequence.h"
#include "output/names.h"
#include "reframe/image.h"
#include "reframe/reconstruct.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What was asked for; NULL where it was not.
typedef struct ReconstructFiles
{
    const char* images[2]; // a file, sequence or folder, and that of the other half
    int image_count;
    const char *frames, *primal, *dx, *dy, *variance; // of the options of these names
    const char *dx_from, *dy_from;
    RfSequenceInput inputs[4]; // images[0], images[1], dx_from, dy_from
} ReconstructFiles;

// The data of one frame. Images of a half that is not there are empty.
typedef struct ReconstructFrame
{
    RfExrWindow window, display;
    int fps_numerator; // of the first file; 0: it has none
    unsigned int fps_denominator;
    int half_count;    // 1 or 2
    bool has_variance; // of all halves
    RfImage primal[2], dx[2], dy[2];
    float* variance[2][3]; // of the primal, of dx, of dy
} ReconstructFrame;

// What was asked for.
typedef struct ReconstructChoice
{
    int method;
    double alpha;
    bool method_given, alpha_given;
} ReconstructChoice;

// What was done with a frame.
typedef struct ReconstructSolve
{
    RfReconstructOptions options;
    bool own_weights; // they come from the data that they weigh
    int half_count;
} ReconstructSolve;

#define LAYER_SIZE 512
#define VARIANCES "primal.variance,dx.variance,dy.variance"

enum
{
    FROM_DX = 2, // indices of inputs
    FROM_DY = 3
};

static const char* const s_prefixes[2] = { "even.", "odd." };

// Finds the frames of all inputs, and checks that what is given goes together. Free it in any case.
static RfResult find_reconstruct_files( ReconstructFiles* files, RfError* error )
{
    const char* names[4] = { files->images[0], files->image_count > 1 ? files->images[1] : NULL, files->dx_from, files->dy_from };
    RfResult result = RF_OK;
    if ( files->image_count > 1 && ( files->dx_from != NULL || files->dy_from != NULL ) )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: gradients of one file cannot be those of two halves: give one image",
                        files->dx_from != NULL ? "dx-from" : "dy-from" );
    for ( int k = 0; k < 4 && result == RF_OK; ++k )
    {
        if ( names[k] != NULL )
            result = rf_find_sequence_input( names[k], k == 0 ? files->frames : NULL, files->inputs + k, error );
        if ( result == RF_OK && names[k] != NULL && files->inputs[k].is_sequence != files->inputs[0].is_sequence )
            result = rf_fail( error, RF_ERROR_USAGE, "%s is %s, but %s is %s", names[0],
                              files->inputs[0].is_sequence ? "a sequence" : "a file", names[k],
                              files->inputs[k].is_sequence ? "a sequence" : "a file" );
    }
    return result;
}

static void free_reconstruct_files( ReconstructFiles* files )
{
    for ( int k = 0; k < 4; ++k )
        rf_free_sequence_input( files->inputs + k );
}

static bool has_channel( const RfExrHeader* header, const char* prefix, const char* name )
{
    char full[LAYER_SIZE + 16];
    snprintf( full, sizeof full, "%s%s", prefix, name );
    return rf_find_exr_name( header, full, strlen( full ) ) != NULL;
}

// Reads a layer (NULL: the colour); all must have the window of the first. Where it is missing, the message
// reports the option that names it.
static RfResult read_layer( const char* path, const char* layer, const char* option, ReconstructFrame* frame, RfImage* image,
                            RfError* error )
{
    RfExrWindow window;
    RfError here;
    RfResult result = rf_read_exr_layer( path, layer, image, &window, &here );
    if ( result == RF_ERROR_FORMAT )
        return rf_fail( error, result, "%.900s: name it by --%s", here.text, option );
    if ( result != RF_OK )
        return rf_fail( error, result, "%s", here.text );
    if ( frame->window.width == 0 )
        frame->window = window;
    if ( memcmp( &window, &frame->window, sizeof window ) != 0 )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %s is %dx%d at (%d, %d), but the primal %dx%d at (%d, %d)", path,
                        layer != NULL ? layer : "the colour", window.width, window.height, window.x, window.y,
                        frame->window.width, frame->window.height, frame->window.x, frame->window.y );
    return RF_OK;
}

// "even." and "dx" or the name that was given: "even.dx".
static const char* layer_name( const char* prefix, const char* given, const char* usual, char text[LAYER_SIZE] )
{
    snprintf( text, LAYER_SIZE, "%s%s", prefix, given != NULL ? given : usual );
    return text;
}

// Gradients: a layer of the image, or of a file of their own, where it may be the colour.
static RfResult read_gradient( const char* path, const char* from, const char* prefix, const char* given, const char* name,
                               ReconstructFrame* frame, RfImage* image, RfError* error )
{
    char layer[LAYER_SIZE], channel[8];
    if ( from == NULL )
        return read_layer( path, layer_name( prefix, given, name, layer ), name, frame, image, error );
    RfExrHeader header;
    RF_TRY( rf_read_exr_header( from, NULL, &header, error ) );
    snprintf( channel, sizeof channel, "%s.R", name );
    bool is_layer = given != NULL || has_channel( &header, "", channel );
    rf_destroy_exr_header( &header );
    return read_layer( from, is_layer ? layer_name( "", given, name, layer ) : NULL, name, frame, image, error );
}

// Three channels into three planes.
static RfResult read_variance( const char* path, const char* prefix, const char* given, ReconstructFrame* frame, float* planes[3],
                               RfError* error )
{
    char layer[LAYER_SIZE];
    const char* names = given != NULL ? given : VARIANCES;
    size_t used = 0;
    layer[0] = '\0';
    while ( used < sizeof layer ) // the prefix goes to each of the names
    {
        size_t length = strcspn( names, "," );
        used += (size_t)snprintf( layer + used, sizeof layer - used, "%s%.*s%s", prefix, (int)length, names,
                                  names[length] != '\0' ? "," : "" );
        if ( names[length] == '\0' )
            break;
        names += length + 1;
    }
    RfImage image = { 0 };
    RfResult result = read_layer( path, layer, "variance A,X,Y", frame, &image, error );
    size_t count = (size_t)image.width * (size_t)image.height;
    for ( size_t c = 0; c < 3 && result == RF_OK; ++c )
    {
        planes[c] = malloc( count * sizeof( float ) );
        if ( planes[c] == NULL )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its variances", path );
        for ( size_t i = 0; i < count && planes[c] != NULL; ++i )
            planes[c][i] = image.rgb[3 * i + c];
    }
    rf_destroy_image( &image );
    return result;
}

// Files of a frame: of the image, its other half, dx and dy; "" where there is none.
typedef struct Paths
{
    char of[4][RF_FILE_NAME_SIZE];
} Paths;

static RfResult read_half( const ReconstructFiles* files, const Paths* paths, const RfExrHeader* header, int file,
                           const char* prefix, int k, ReconstructFrame* frame, RfError* error )
{
    char layer[LAYER_SIZE];
    const char *path = paths->of[file], *dx = paths->of[FROM_DX], *dy = paths->of[FROM_DY];
    bool named = files->primal != NULL || prefix[0] != '\0' || has_channel( header, prefix, "primal.R" );
    const char* primal = named ? layer_name( prefix, files->primal, "primal", layer ) : NULL;
    RfResult result = read_layer( path, primal, "primal", frame, frame->primal + k, error );
    if ( result == RF_OK )
        result = read_gradient( path, dx[0] != '\0' ? dx : NULL, prefix, files->dx, "dx", frame, frame->dx + k, error );
    if ( result == RF_OK )
        result = read_gradient( path, dy[0] != '\0' ? dy : NULL, prefix, files->dy, "dy", frame, frame->dy + k, error );
    bool has_variance = files->variance != NULL || has_channel( header, prefix, "primal.variance" );
    if ( result == RF_OK && has_variance )
        result = read_variance( path, prefix, files->variance, frame, frame->variance[k], error );
    frame->has_variance = has_variance && ( k == 0 || frame->has_variance );
    frame->half_count = k + 1;
    return result;
}

// What the layers of a half begin with that were not named: Blender's layer in files of its names.
static const char* usual_prefix( const ReconstructFiles* files, const RfExrHeader* header )
{
    static const char blender[] = RF_BLENDER_LAYER ".";
    bool named = files->primal != NULL || files->dx != NULL || files->dy != NULL || files->variance != NULL;
    return !named && has_channel( header, blender, "primal.R" ) ? blender : "";
}

// The half that a file is, or the two that it holds.
static RfResult read_file( const ReconstructFiles* files, const Paths* paths, int file, ReconstructFrame* frame, RfError* error )
{
    RfExrHeader header;
    char channel[LAYER_SIZE];
    RF_TRY( rf_read_exr_header( paths->of[file], NULL, &header, error ) );
    if ( file == 0 )
    {
        frame->fps_numerator = header.fps_numerator, frame->fps_denominator = header.fps_denominator;
        frame->display = ( RfExrWindow ){ header.display_x, header.display_y, header.display_width, header.display_height };
    }
    snprintf( channel, sizeof channel, "%.500s.R", files->primal != NULL ? files->primal : "primal" );
    bool both = files->image_count == 1 && files->dx_from == NULL && files->dy_from == NULL &&
                has_channel( &header, s_prefixes[0], channel );
    RfResult result = RF_OK;
    if ( !both )
        result = read_half( files, paths, &header, file, usual_prefix( files, &header ), file, frame, error );
    for ( int k = 0; k < 2 && both && result == RF_OK; ++k )
        result = read_half( files, paths, &header, file, s_prefixes[k], k, frame, error );
    rf_destroy_exr_header( &header );
    return result;
}

// Reads a frame of this number. Free it in any case.
static RfResult read_reconstruct_frame( const ReconstructFiles* files, int number, ReconstructFrame* frame, RfError* error )
{
    Paths* paths = calloc( 1, sizeof *paths );
    RfResult result = paths != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "out of memory for the names of files" );
    *frame = ( ReconstructFrame ){ .half_count = 0 };
    for ( int k = 0; k < 4 && result == RF_OK; ++k )
        result = rf_sequence_input_name( files->inputs + k, number, paths->of[k], error );
    for ( int k = 0; k < files->image_count && result == RF_OK; ++k )
        result = read_file( files, paths, k, frame, error );
    free( paths );
    return result;
}

static void free_reconstruct_frame( ReconstructFrame* frame )
{
    for ( int k = 0; k < 2; ++k )
    {
        rf_destroy_image( frame->primal + k );
        rf_destroy_image( frame->dx + k );
        rf_destroy_image( frame->dy + k );
        for ( int c = 0; c < 3; ++c )
            free( frame->variance[k][c] );
    }
    *frame = ( ReconstructFrame ){ .half_count = 0 };
}

static RfGradientImages reconstruct_images( const ReconstructFrame* frame, int k )
{
    return ( RfGradientImages ){ frame->window.width, frame->window.height, frame->primal[k].rgb, frame->dx[k].rgb,
                                 frame->dy[k].rgb };
}

// The words of --method, in the order of RfReconstructMethod; NULL ends them.
static const char* const reconstruct_methods[] = { "l2", "weighted", "l1", NULL };

// The method depends on what is in the file.
static RfResult choose_method( const ReconstructChoice* choice, const ReconstructFrame* frame, const char* name,
                               ReconstructSolve* solve, RfError* error )
{
    bool can_weigh = frame->half_count == 2 && frame->has_variance && !choice->alpha_given;
    *solve = ( ReconstructSolve ){ .options = rf_default_reconstruct_options(), .half_count = frame->half_count };
    solve->options.alpha = (float)choice->alpha;
    solve->options.method = choice->method_given ? (RfReconstructMethod)choice->method
                            : can_weigh          ? RF_RECONSTRUCT_WEIGHTED
                                                 : RF_RECONSTRUCT_L2;
    if ( solve->options.method != RF_RECONSTRUCT_WEIGHTED )
        return RF_OK;
    solve->own_weights = frame->half_count == 1;
    if ( choice->alpha_given )
        return rf_fail( error, RF_ERROR_USAGE, "--alpha: needs --method l2 or l1; weighted takes its weights from variances" );
    if ( !frame->has_variance )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "%s: has no channel primal.variance: name its variances by --variance A,X,Y, or choose --method l2",
                        name );
    return RF_OK;
}

// Adds the other half to the first: their mean is what the methods without weights solve.
static void average_halves( ReconstructFrame* frame )
{
    RfImage* const images[3] = { frame->primal, frame->dx, frame->dy };
    size_t count = 3 * (size_t)frame->window.width * (size_t)frame->window.height;
    for ( int k = 0; k < 3 && frame->half_count == 2; ++k )
    {
        for ( size_t i = 0; i < count; ++i )
            images[k][0].rgb[i] = 0.5f * ( images[k][0].rgb[i] + images[k][1].rgb[i] );
    }
}

static RfGradientHalf half_of( const ReconstructFrame* frame, int k )
{
    return ( RfGradientHalf ){ .images = reconstruct_images( frame, k ),
                               .variance = frame->variance[k][0],
                               .variance_dx = frame->variance[k][1],
                               .variance_dy = frame->variance[k][2],
                               .passes = 1.0 };
}

static RfResult solve_frame( const ReconstructSolve* solve, ReconstructFrame* frame, float* rgb, RfReconstructInfo* info,
                             RfError* error )
{
    if ( solve->options.method == RF_RECONSTRUCT_WEIGHTED )
    {
        // a single half stands for both, so it gets its own weights
        RfGradientHalf halves[2] = { half_of( frame, 0 ), half_of( frame, solve->own_weights ? 0 : 1 ) };
        RfResult result = rf_reconstruct_halves( halves, &solve->options, rgb, NULL, info, error );
        info->biased = solve->own_weights;
        return result;
    }
    average_halves( frame );
    RfGradientImages in = reconstruct_images( frame, 0 );
    return rf_reconstruct( &in, NULL, &solve->options, rgb, info, error );
}

// Chooses the method and solves into `image`, which the caller destroys. `name` is the file, for messages. The
// frame's images are used up.
static RfResult rf_solve_frame( const ReconstructChoice* choice, ReconstructFrame* frame, const char* name,
                                ReconstructSolve* solve, RfImage* image, RfReconstructInfo* info, RfError* error )
{
    RfError here;
    RF_TRY( choose_method( choice, frame, name, solve, error ) );
    RF_TRY( rf_create_image( frame->window.width, frame->window.height, image, error ) );
    RfResult result = solve_frame( solve, frame, image->rgb, info, &here );
    if ( result == RF_OK )
        return RF_OK;
    // options are checked: what the library refuses is in the file
    return rf_fail( error, result == RF_ERROR_USAGE ? RF_ERROR_FORMAT : result, "%.400s: %.500s", name, here.text );
}

#define COMMAND "reconstruct"

// What was asked for, and how it went.
typedef struct Job
{
    ReconstructFiles files;
    const char *output, *json;
    ReconstructChoice choice;
    ReconstructSolve solve; // the last
    RfReconstructInfo info; // the worst of all frames
    bool half, quiet, table;
    double seconds;
    json_t *rows, *warnings;
    RfLog* log;
} Job;

static const char* method_name( const Job* job ) { return reconstruct_methods[job->solve.options.method]; }

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

static RfResult write_image( const Job* job, int number, const ReconstructFrame* frame, const RfImage* image, RfError* error )
{
    char name[RF_FILE_NAME_SIZE], text[128];
    describe( job, text, sizeof text );
    const RfExrString said = { "reframe/reconstruction", text };
    RfExrOptions options = rf_default_exr_options();
    options.half = job->half;
    options.x = frame->window.x;
    options.y = frame->window.y;
    options.display = frame->display;
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
    ReconstructFrame frame;
    RfImage image = { 0 };
    RfReconstructInfo info = { 0 };
    char name[RF_FILE_NAME_SIZE];
    RF_TRY( rf_sequence_input_name( job->files.inputs, number, name, error ) );
    RfResult result = read_reconstruct_frame( &job->files, number, &frame, error );
    double start = rf_wall_seconds();
    if ( result == RF_OK )
        result = rf_solve_frame( &job->choice, &frame, name, &job->solve, &image, &info, error );
    if ( result == RF_OK )
    {
        keep( job, number, &info, rf_wall_seconds() - start );
        result = write_image( job, number, &frame, &image, error );
    }
    rf_destroy_image( &image );
    free_reconstruct_frame( &frame );
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

static RfResult run( void* user, RfError* error )
{
    Job* job = user;
    job->table = rf_prints_text( job->json );
    const RfSequenceInput* input = job->files.inputs;
    if ( job->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "-o FILE is missing, see reframe reconstruct --help" );
    RfResult result = find_reconstruct_files( &job->files, error );
    if ( result == RF_OK && input->is_sequence && !rf_is_sequence( job->output ) )
        result = rf_fail( error, RF_ERROR_USAGE, "-o: %s: has no #### for the number of the frame", job->output );
    for ( int k = 0; k < 4 && result == RF_OK; ++k )
    {
        if ( rf_may_be_same_file( input[k].pattern, job->output ) )
            result = rf_fail( error, RF_ERROR_USAGE, "-o: %s: is also the input: choose another name", job->output );
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

int rf_command_reconstruct( int argc, char** argv )
{
    static const char* const names[] = { "IMAGES" };
    Job job = { .choice.alpha = 0.2, .info = { .converged = true } };
    const RfOption options[] = {
        RF_TEXT_OPTION( "output", &job.output, "FILE", "output image; for a sequence, with #### for the frame number",
                        .letter = 'o', .writes = ".exr" ),
        RF_CHOICE_OPTION( "method", &job.choice.method, reconstruct_methods,
                          "least squares with constant weights, or weighted by the variances of the other half; least absolute "
                          "differences, which is biased",
                          .given = &job.choice.method_given,
                          .default_text = "weighted where two halves have variances, else l2" ),
        RF_REAL_OPTION( "alpha", &job.choice.alpha, 1e-4, 1e4, "A",
                        "weight of the primal image against the gradients, with l2 and l1", .given = &job.choice.alpha_given ),
        RF_TEXT_OPTION( "primal", &job.files.primal, "NAME", "layer of the noisy image, or three channels X,Y,Z",
                        .default_text = "primal, else colour" ),
        RF_TEXT_OPTION( "dx", &job.files.dx, "NAME", "layer of differences to the pixel on the right", .default_text = "dx" ),
        RF_TEXT_OPTION( "dy", &job.files.dy, "NAME", "layer of differences to the pixel below", .default_text = "dy" ),
        RF_TEXT_OPTION( "variance", &job.files.variance, "A,X,Y", "three channels: variances of primal, dx and dy",
                        .default_text = "primal.variance,dx.variance,dy.variance" ),
        RF_TEXT_OPTION( "dx-from", &job.files.dx_from, "FILE", "read dx from this file or sequence instead", .reads = true ),
        RF_TEXT_OPTION( "dy-from", &job.files.dy_from, "FILE", "read dy from this file or sequence instead", .reads = true ),
        RF_TEXT_OPTION( "frames", &job.files.frames, "A-B[xSTEP][,...]", "reconstruct only these frames of the sequence",
                        .default_text = "all" ),
        RF_FLAG_OPTION( "half", &job.half, "16-bit floats instead of 32", .heading = RF_HEADING_OUTPUT ),
        RF_RESULT_OPTIONS( job, "write statistics of the solves as JSON; - for standard output", "no progress, no summary" ),
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "Reconstructs images from a noisy primal image and noisy gradients, layers of EXR files of this or another "
                   "program. IMAGES is a file, a sequence named with ####, or its folder; or two of them, the independent halves "
                   "of a render. Halves may also be the layers even.primal, even.dx, odd.primal and so on of one file.",
        RF_TABLE_ROWS( names, options ),
        .file_max = 2,
        .file_total = &job.files.image_count
    };
    job.rows = json_array();
    job.warnings = json_array();
    RfReportedWarnings reported = { COMMAND, job.warnings };
    RfLog log = rf_keeping_log( &reported );
    job.log = &log;
    int status = rf_run_command( &table, argc, argv, job.files.images, run, &job );
    free_reconstruct_files( &job.files );
    json_decref( job.rows );
    json_decref( job.warnings );
    return status;
}
