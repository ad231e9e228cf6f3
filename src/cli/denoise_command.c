// reframe denoise: rendered sequences without their noise.
#include "base/system.h"
#include "base/try.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/shared_options.h"
#include "cli/render/progress.h"
#include "image/exr.h"
#include "image/sequence.h"
#include "output/frame_file.h"
#include "output/names.h"
#include "reframe/denoise.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define COMMAND "denoise"
#define MOST_LAYERS 64
#define MOST_NEW 16 // channels

// A pass of the file, by any of the namings.
typedef struct Layer
{
    float* values; // as many as letters; NULL: it is not there
    int letters;   // 3 or 4
    const char* channels[4];
} Layer;

// What is read of a frame, and written again.
typedef struct Frame
{
    RfExrCopy copy;
    RfImage image;
    Layer half, albedo, normal, motion, noisy;
    Layer layers[MOST_LAYERS];
    RfNoisyLayer noisy_layers[MOST_LAYERS];
    int layer_count;
    char names[MOST_NEW][RF_PASS_CHANNEL_SIZE];
    char noisy_part[RF_PASS_CHANNEL_SIZE];
    char texts[8][64];
    RfExrString strings[8];
    char path[RF_FILE_NAME_SIZE];
    float* rgb; // before, 3 per pixel
    RfDenoisedHalves halves;
} Frame;

typedef struct Job
{
    const char* images;
    RfSequenceInput input;
    const char *output, *frames, *library, *json;
    char pattern[RF_FILE_NAME_SIZE]; // of the output
    int threads;
    bool overwrite, quiet;
    RfDenoiser* denoiser;
    RfDenoisedSums sums;
    int width, height; // of the first frame
    double noisy;      // sum over the frames
    Frame* window[3];  // before, now, after; NULL: there is none, or it is of no use
    int no_halves;     // frames whose error is not known
    int followed;      // frames that those beside them may help
    double seconds;
    json_t *rows, *warnings;
    RfLog* log;
} Job;

static const char* find_channel( const RfExrHeader* header, const char* pass, char letter, bool* negated )
{
    for ( int i = 0; i < header->channel_count; ++i )
    {
        if ( rf_is_pass_channel( header->channels[i].text, pass, letter, negated ) )
            return header->channels[i].text;
    }
    return NULL;
}

static RfResult read_layer( const char* path, const RfExrHeader* header, const char* pass, const char* letters, Layer* layer,
                            RfError* error )
{
    RfExrWindow window;
    bool negated[4];
    *layer = ( Layer ){ .letters = (int)strlen( letters ) };
    for ( int i = 0; i < layer->letters; ++i )
    {
        layer->channels[i] = find_channel( header, pass, letters[i], negated + i );
        if ( layer->channels[i] == NULL )
            return RF_OK;
    }
    RF_TRY( rf_read_exr_channels( path, layer->channels, layer->letters, &window, &layer->values, error ) );
    for ( int i = 0; i < layer->letters * window.width * window.height; ++i )
        layer->values[i] *= negated[i % layer->letters] ? -1.0f : 1.0f;
    return RF_OK;
}

static RfResult add_layer( const char* path, const char* pass, int set, bool is_raw, Frame* frame, RfError* error )
{
    Layer* layer = frame->layers + frame->layer_count;
    if ( frame->layer_count == MOST_LAYERS )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: has more than %d layers of light", path, MOST_LAYERS );
    RF_TRY( read_layer( path, &frame->copy.header, pass, "RGB", layer, error ) );
    if ( layer->values != NULL )
        frame->noisy_layers[frame->layer_count++] = ( RfNoisyLayer ){ set, layer->values, is_raw };
    return RF_OK;
}

// The light of groups, each a layer light_NAME, and the passes that split light: each set adds up to the picture.
static RfResult read_layers( const char* path, Frame* frame, RfError* error )
{
    const RfExrHeader* header = &frame->copy.header;
    bool is_raw = frame->noisy.values == NULL; // else they have been denoised with the picture
    RfResult result = RF_OK;
    for ( int i = 0; i < header->channel_count && result == RF_OK; ++i )
    {
        char name[RF_PASS_CHANNEL_SIZE];
        const char *text = header->channels[i].text, *dot = strrchr( text, '.' ), *start = strstr( text, RF_LIGHT_LAYER );
        if ( dot == NULL || strcmp( dot, ".R" ) != 0 || start == NULL || ( start != text && start[-1] != '.' ) )
            continue;
        snprintf( name, sizeof name, "%.*s", (int)( dot - start ), start );
        result = add_layer( path, name, 0, is_raw, frame, error );
    }
    for ( int a = 0; a < RF_AOV_COUNT && result == RF_OK; ++a )
    {
        if ( ( RF_PASS_AOVS & RF_AOV_BIT( a ) ) != 0 )
            result = add_layer( path, rf_aov_name( (RfAov)a ), 1, is_raw, frame, error );
    }
    return result;
}

static RfResult read_frame( const char* path, Frame* frame, RfError* error )
{
    RF_TRY( rf_read_exr_copy( path, &frame->copy, error ) );
    const RfExrHeader* header = &frame->copy.header;
    RF_TRY( rf_read_exr( path, &frame->image, error ) );
    RF_TRY( read_layer( path, header, RF_NOISY_LAYER, "RGB", &frame->noisy, error ) );
    RF_TRY( read_layer( path, header, rf_aov_name( RF_AOV_HALF ), "RGBW", &frame->half, error ) );
    RF_TRY( read_layer( path, header, rf_aov_name( RF_AOV_DENOISE_ALBEDO ), "RGB", &frame->albedo, error ) );
    RF_TRY( read_layer( path, header, rf_aov_name( RF_AOV_DENOISE_NORMAL ), "XYZ", &frame->normal, error ) );
    RF_TRY( read_layer( path, header, rf_aov_name( RF_AOV_MOTION ), "XYZW", &frame->motion, error ) );
    if ( frame->noisy.values != NULL )
        memcpy( frame->image.rgb, frame->noisy.values, 3 * sizeof( float ) * (size_t)header->width * (size_t)header->height );
    return read_layers( path, frame, error );
}

static void free_frame( Frame* frame )
{
    if ( frame == NULL )
        return;
    Layer* const layers[] = { &frame->half, &frame->albedo, &frame->normal, &frame->motion, &frame->noisy };
    rf_free_denoised_halves( &frame->halves );
    free( frame->rgb );
    rf_free_exr_copy( &frame->copy );
    rf_destroy_image( &frame->image );
    for ( size_t i = 0; i < sizeof layers / sizeof layers[0]; ++i )
        free( layers[i]->values );
    for ( int i = 0; i < frame->layer_count; ++i )
        free( frame->layers[i].values );
    free( frame );
}

// Puts a layer's values in the place of its channels.
static void replace( RfExrCopy* copy, const Layer* layer )
{
    for ( int i = 0; i < copy->options.channel_count; ++i )
    {
        for ( int c = 0; c < layer->letters; ++c )
        {
            RfExrChannel* channel = copy->channels + i;
            const RfExrName* name = rf_find_exr_name( &copy->header, layer->channels[c], strlen( layer->channels[c] ) );
            if ( name == NULL || name->own != channel->name )
                continue;
            channel->values = layer->values + c;
            channel->stride = layer->letters;
            channel->meaning = RF_EXR_COLOUR;
            channel->component = c;
        }
    }
}

static RfPassNames names_of( const char* path )
{
    char text[32];
    if ( rf_read_exr_string( path, rf_key_name( RF_KEY_NAMES ), text, sizeof text, NULL ) != RF_OK )
        return RF_NAMES_REFRAME;
    for ( int i = 0; rf_pass_names_words[i] != NULL; ++i )
    {
        if ( strcmp( text, rf_pass_names_words[i] ) == 0 )
            return (RfPassNames)i;
    }
    return RF_NAMES_REFRAME;
}

// Adds the noisy picture as a layer of its own.
static void add_noisy( const char* path, const float* noisy, Frame* frame )
{
    RfExrOptions* options = &frame->copy.options;
    bool several = frame->copy.part[0] != '\0';
    for ( int c = 0; c < 3; ++c )
    {
        RfPassChannel channel;
        rf_name_pass_channel( names_of( path ), RF_NOISY_LAYER, "RGB", c, &channel );
        snprintf( frame->names[c], sizeof frame->names[c], "%s", channel.name );
        frame->copy.channels[options->channel_count++] = ( RfExrChannel ){ .name = frame->names[c],
                                                                           .values = noisy + c,
                                                                           .stride = 3,
                                                                           .part = several ? frame->noisy_part : NULL,
                                                                           .meaning = RF_EXR_COLOUR,
                                                                           .component = c };
    }
    snprintf( frame->noisy_part, sizeof frame->noisy_part, "%s", frame->names[0] );
    *strrchr( frame->noisy_part, '.' ) = '\0';
}

static void put( Frame* frame, RfKey key, const char* text )
{
    int i = frame->copy.options.string_count++;
    snprintf( frame->texts[i], sizeof frame->texts[i], "%s", text );
    frame->strings[i] = ( RfExrString ){ rf_key_name( key ), frame->texts[i] };
    frame->copy.options.strings = frame->strings;
}

static RfResult write_frame( Job* job, int number, const RfDenoised* denoised, Frame* frame, RfError* error )
{
    char name[RF_FILE_NAME_SIZE], text[64];
    if ( frame->noisy.values == NULL )
        add_noisy( frame->path, frame->rgb, frame );
    for ( int l = 0; l < frame->layer_count; ++l )
        replace( &frame->copy, frame->layers + l );
    put( frame, RF_KEY_DENOISER, rf_denoiser_name( job->denoiser ) );
    if ( isfinite( denoised->denoised.relmse ) )
    {
        snprintf( text, sizeof text, "%.6g", denoised->denoised.relmse );
        put( frame, RF_KEY_DENOISED_RELMSE, text );
        snprintf( text, sizeof text, "%.6g", denoised->denoised.low );
        put( frame, RF_KEY_DENOISED_LOW, text );
        snprintf( text, sizeof text, "%.6g", denoised->denoised.high );
        put( frame, RF_KEY_DENOISED_HIGH, text );
    }
    put( frame, RF_KEY_FINGERPRINT, "denoised" ); // no frame that a render would go on from
    RF_TRY( rf_sequence_name( job->pattern, number, name, sizeof name, error ) );
    return rf_write_exr( name, &frame->image, &frame->copy.options, error );
}

static RfNoisyFrame noisy_of( const Frame* frame )
{
    return ( RfNoisyFrame ){ .width = frame->image.width,
                             .height = frame->image.height,
                             .rgb = frame->rgb,
                             .half = frame->half.values,
                             .albedo = frame->albedo.values,
                             .normal = frame->normal.values,
                             .motion = frame->motion.values,
                             .layer_count = frame->layer_count,
                             .layers = frame->noisy_layers,
                             .halves = frame->halves.half[0] != NULL ? &frame->halves : NULL,
                             .passes = rf_read_exr_number( frame->path, rf_key_name( RF_KEY_NATIVE_SPP ) ) };
}

// Frames that can be followed into those beside them have their halves denoised at once, for all of them.
static bool is_followed( const Frame* frame )
{
    return frame->motion.values != NULL && frame->albedo.values != NULL && frame->normal.values != NULL &&
           frame->half.values != NULL;
}

static RfResult check_size( Job* job, const Frame* frame, RfError* error )
{
    job->width = job->width > 0 ? job->width : frame->image.width;
    job->height = job->height > 0 ? job->height : frame->image.height;
    return frame->image.width == job->width && frame->image.height == job->height
               ? RF_OK
               : rf_fail( error, RF_ERROR_FORMAT, "%s: has %dx%d pixels, but the first frame %dx%d: denoise them one by one",
                          frame->path, frame->image.width, frame->image.height, job->width, job->height );
}

static RfResult load_frame( Job* job, int number, Frame* frame, RfError* error )
{
    RF_TRY( rf_sequence_input_name( &job->input, number, frame->path, error ) );
    RF_TRY( read_frame( frame->path, frame, error ) );
    RF_TRY( check_size( job, frame, error ) );
    size_t size = 3 * sizeof( float ) * (size_t)frame->image.width * (size_t)frame->image.height;
    frame->rgb = malloc( size );
    if ( frame->rgb == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its pixels", frame->path );
    memcpy( frame->rgb, frame->image.rgb, size );
    if ( !is_followed( frame ) )
        return RF_OK;
    double start = rf_wall_seconds();
    const RfNoisyFrame noisy = noisy_of( frame );
    RF_TRY( rf_denoise_halves( job->denoiser, &noisy, &frame->halves, error ) );
    job->seconds += rf_wall_seconds() - start;
    return RF_OK;
}

static int number_of( const Job* job, int i ) { return job->input.is_sequence ? job->input.frames[i] : 1; }

// The frames around number `i` of `count`: the one before and the one after only where they have been rendered beside it and can be
// followed.
static RfResult slide( Job* job, int i, int count, RfError* error )
{
    Frame** window = job->window;
    free_frame( window[0] );
    window[0] = window[1];
    window[1] = window[2];
    window[2] = NULL;
    if ( i > 0 && number_of( job, i ) != number_of( job, i - 1 ) + 1 )
    {
        free_frame( window[0] );
        window[0] = NULL;
    }
    for ( int k = 1; k <= 2; ++k )
    {
        const Frame* before = window[k - 1];
        bool wanted = k == 1 || ( is_followed( before ) && i + 1 < count && number_of( job, i + 1 ) == number_of( job, i ) + 1 );
        if ( window[k] != NULL || !wanted )
            continue;
        window[k] = calloc( 1, sizeof( Frame ) );
        if ( window[k] == NULL )
            return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a frame" );
        RF_TRY( load_frame( job, number_of( job, i + k - 1 ), window[k], error ) );
    }
    return RF_OK;
}

static RfFrameBeside beside( const Frame* frame )
{
    return frame != NULL && is_followed( frame ) ? ( RfFrameBeside ){ &frame->halves, frame->albedo.values, frame->normal.values }
                                                 : ( RfFrameBeside ){ NULL, NULL, NULL };
}

static RfResult denoise_frame( Job* job, int number, RfError* error )
{
    Frame* frame = job->window[1];
    RfDenoised denoised;
    double start = rf_wall_seconds();
    RfNoisyFrame in = noisy_of( frame );
    in.beside[0] = beside( job->window[0] );
    in.beside[1] = beside( job->window[2] );
    RF_TRY( rf_denoise( job->denoiser, &in, frame->image.rgb, &denoised, &job->sums, error ) );
    RF_TRY( write_frame( job, number, &denoised, frame, error ) );
    job->seconds += rf_wall_seconds() - start;
    job->noisy += isfinite( denoised.noisy ) ? denoised.noisy : 0.0;
    job->no_halves += isfinite( denoised.denoised.relmse ) == 0;
    job->followed += is_followed( frame );
    json_t* row = rf_denoised_json( denoised.noisy, &denoised.denoised );
    json_array_append_new( job->rows,
                           RF_SET_FIGURES( rf_json_add( row, "{s:i}", "frame", number ), { "share", denoised.share },
                                           { "along_motion", denoised.along }, { "seconds", rf_wall_seconds() - start } ) );
    return RF_OK;
}

static RfResult finish( Job* job, RfError* error )
{
    char text[RF_DENOISED_TEXT_SIZE];
    int count = (int)json_array_size( job->rows );
    RfErrorEstimate mean = rf_denoised_error( &job->sums );
    double noisy = job->noisy / job->sums.frames;
    if ( job->no_halves > 0 )
        rf_warn( job->log, "the error of %d frame%s is not known: render with --denoise or --aov half, and at least 4 samples",
                 job->no_halves, job->no_halves == 1 ? "" : "s" );
    rf_format_denoised( noisy, &mean, text );
    if ( rf_prints_text( job->json ) && !job->quiet )
        rf_print( "%d frame%s in %s by %s, %.2f s: %s\n", count, count == 1 ? "" : "s", job->pattern,
                  rf_denoiser_name( job->denoiser ), job->seconds, job->sums.frames > 0 ? text : "error unknown" );
    if ( count > 1 && job->followed == 0 && rf_prints_text( job->json ) && !job->quiet )
        rf_print( "Each frame is denoised by itself: with --denoise --aov motion, those before and after would help\n" );
    if ( job->json == NULL )
        return rf_flush_output( error );
    json_t* json = rf_denoised_json( noisy, &mean );
    json_object_set_new( json, "seconds", rf_json_number( job->seconds ) );
    rf_json_add( json, "{s:O, s:s, s:O}", "frames", job->rows, "denoiser", rf_denoiser_name( job->denoiser ), "warnings",
                 job->warnings );
    return rf_write_json( job->json, json, error );
}

// The output is a pattern, a file, or a folder for files of the same names.
static RfResult find_output( Job* job, RfError* error )
{
    const RfSequenceInput* input = &job->input;
    const char *slash = strrchr( input->pattern, '/' ), *own = slash != NULL ? slash + 1 : input->pattern;
    if ( job->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "-o is missing: say where the frames go, such as -o clean" );
    bool is_file = rf_ends_with( job->output, ".exr" );
    int written = is_file ? snprintf( job->pattern, sizeof job->pattern, "%s", job->output )
                          : snprintf( job->pattern, sizeof job->pattern, "%s/%s", job->output, own );
    if ( written >= (int)sizeof job->pattern )
        return rf_fail( error, RF_ERROR_USAGE, "-o: the name is too long" );
    if ( input->is_sequence && !rf_is_sequence( job->pattern ) )
        return rf_fail( error, RF_ERROR_USAGE, "-o: %s: has no #### for the number of the frame", job->output );
    if ( rf_may_be_same_file( input->pattern, job->pattern ) )
        return rf_fail( error, RF_ERROR_USAGE, "-o: %s: is also the input: choose another name", job->output );
    return rf_prepare_output_folder( job->pattern, error );
}

static RfResult check_existing( const Job* job, int count, RfError* error )
{
    char name[RF_FILE_NAME_SIZE];
    struct stat status;
    for ( int i = 0; i < count && !job->overwrite; ++i )
    {
        RF_TRY( rf_sequence_name( job->pattern, number_of( job, i ), name, sizeof name, error ) );
        if ( stat( name, &status ) == 0 )
            return rf_fail( error, RF_ERROR_IO, "%s: already exists: --overwrite replaces it", name );
    }
    return RF_OK;
}

static RfResult run( void* user, RfError* error )
{
    Job* job = user;
    RF_TRY( rf_find_sequence_input( job->images, job->frames, &job->input, error ) );
    RF_TRY( find_output( job, error ) );
    int count = job->input.is_sequence ? job->input.count : 1;
    RF_TRY( check_existing( job, count, error ) );
    RF_TRY( rf_open_denoiser( job->library, job->threads, &job->denoiser, error ) );
    rf_catch_interrupts();
    if ( job->input.is_sequence && job->frames == NULL )
        RF_TRY( rf_warn_of_missing( &job->input, job->log, error ) );
    for ( int i = 0; i < count; ++i )
    {
        if ( rf_is_interrupted() )
            return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted: %d of %d frames are denoised and kept", i, count );
        RF_TRY( slide( job, i, count, error ) );
        RF_TRY( denoise_frame( job, number_of( job, i ), error ) );
        rf_show_frame_count( job->quiet || count < 2, i + 1, count );
    }
    return finish( job, error );
}

int rf_command_denoise( int argc, char** argv )
{
    static const char* const names[] = { "IMAGES" };
    Job job = { .threads = 0 };
    const RfOption options[] = {
        RF_TEXT_OPTION( "output", &job.output, "FOLDER|PATTERN",
                        "folder for files of the same names, or their names with #### for the frame number", .letter = 'o',
                        .writes = "" ),
        RF_TEXT_OPTION( "frames", &job.frames, "A-B[xSTEP][,...]", "denoise only these frames of the sequence",
                        .default_text = "all" ),
        RF_DENOISER_OPTION( job.library ),
        RF_FLAG_OPTION( "overwrite", &job.overwrite, "replace existing files", .heading = RF_HEADING_OUTPUT ),
        RF_RESULT_OPTIONS( job, "write the errors as JSON; - for standard output", "no progress, no summary" ),
        RF_INT_OPTION( "threads", &job.threads, 1, RF_MAX_THREADS, "T", "threads", .default_text = "all cores",
                       .heading = RF_HEADING_PERFORMANCE ),
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary =
            "Denoises rendered frames with Open Image Denoise, and tells the error that is left, bias included, where the "
            "files have the layer half (render --denoise, or --aov half). IMAGES is a file, a sequence named with ####, or "
            "its folder. Light groups and passes still add up to the picture; other layers stay as they are, and the "
            "picture before is the layer noisy. With the layer motion, the frames before and after help where they can.",
        RF_TABLE_ROWS( names, options ),
    };
    job.rows = json_array();
    job.warnings = json_array();
    RfReportedWarnings reported = { COMMAND, job.warnings };
    RfLog log = rf_keeping_log( &reported );
    job.log = &log;
    int status = rf_run_command( &table, argc, argv, &job.images, run, &job );
    rf_close_denoiser( job.denoiser );
    rf_free_denoised_sums( &job.sums );
    for ( int k = 0; k < 3; ++k )
        free_frame( job.window[k] );
    rf_free_sequence_input( &job.input );
    json_decref( job.rows );
    json_decref( job.warnings );
    return status;
}
