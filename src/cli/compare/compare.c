// reframe compare A B: the error of image A against reference B, files or
// sequences, frame by frame and over all frames.
#include "cli/commands.h"
#include "cli/compare/compare_frames.h"
#include "cli/compare/compare_report.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "cli/messages.h"
#include "image/sequence.h"
#include "measure/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define COMMAND "compare"

typedef struct Compare
{
    RfCompareFrames in;
    const char* diff; // or NULL
    const char* json; // or NULL
    bool quiet;
    bool table; // the table goes to standard output
    RfErrorSummary all;
    bool has_all;       // `all` has been created, for the first frame's size
    RfWorstPixel worst; // of all frames so far, where the files have it
    json_t* rows;
} Compare;

static void show_progress( const Compare* compare, int i )
{
    bool rows_are_seen = compare->table && isatty( STDOUT_FILENO ) != 0; // they show the progress
    rf_show_frame_count( compare->quiet || rows_are_seen || compare->in.count < 2, i, compare->in.count );
}

static int frame_number( const Compare* compare, int i ) { return compare->in.frames != NULL ? compare->in.frames[i] : 1; }

// No difference image may overwrite a frame of this sequence.
static RfResult check_diff_names( const Compare* compare, const char* pattern, RfError* error )
{
    int count = compare->in.count;
    struct stat* frames = calloc( (size_t)count, sizeof *frames );
    char name[RF_COMPARE_NAME_SIZE];
    RfResult result =
        frames != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "no memory left for the names of %d frames", count );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        result = rf_compare_name( &compare->in, pattern, frame_number( compare, i ), name, error );
        if ( result == RF_OK && stat( name, frames + i ) != 0 )
            frames[i].st_ino = 0;
    }
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        struct stat diff;
        result = rf_compare_name( &compare->in, compare->diff, frame_number( compare, i ), name, error );
        bool is_there = result == RF_OK && stat( name, &diff ) == 0;
        for ( int k = 0; k < count && is_there && result == RF_OK; ++k )
        {
            if ( frames[k].st_ino == diff.st_ino && frames[k].st_dev == diff.st_dev )
                result = rf_fail( error, RF_ERROR_USAGE,
                                  "--diff: %s: is one of the images that are compared: choose another name", name );
        }
    }
    free( frames );
    return result;
}

// Checks before the work that every difference image has a name of its own.
static RfResult check_diff( const Compare* compare, RfError* error )
{
    if ( compare->diff == NULL )
        return RF_OK;
    if ( compare->in.count > 1 && !rf_is_sequence( compare->diff ) )
        return rf_fail( error, RF_ERROR_USAGE, "--diff: %d frames want a name with ####, got '%s'", compare->in.count,
                        compare->diff );
    RfResult result = check_diff_names( compare, compare->in.patterns[0], error );
    return result == RF_OK ? check_diff_names( compare, compare->in.patterns[1], error ) : result;
}

// Turns the image into the signed difference, and writes it.
static RfResult write_diff( const Compare* compare, int frame, RfComparePair* pair, RfError* error )
{
    RfImage* image = pair->images;
    const RfImage* reference = pair->images + 1;
    char name[RF_COMPARE_NAME_SIZE];
    RfResult result = rf_compare_name( &compare->in, compare->diff, frame, name, error );
    if ( result != RF_OK )
        return result;
    size_t count = 3 * (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < count; ++i )
        image->rgb[i] -= reference->rgb[i];
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    options.x = pair->window.x;
    options.y = pair->window.y;
    return rf_write_exr( name, image, &options, error );
}

// Converts the worst pixel to the coordinates of the file. Where values are not finite there
// is none.
static void place_worst( Compare* compare, const RfExrWindow* window, RfErrorMetrics* metrics )
{
    RfWorstPixel* worst = &metrics->worst;
    if ( rf_has_no_error( metrics ) )
        worst->frame = -1;
    if ( worst->frame < 0 )
        return;
    worst->x += window->x;
    worst->y += window->y;
    if ( compare->worst.frame >= 0 && worst->relative <= compare->worst.relative )
        return;
    compare->worst = *worst;
    compare->worst.frame = (int)json_array_size( compare->rows );
}

static RfResult measure( Compare* compare, int frame, const RfComparePair* pair, RfError* error )
{
    RfErrorMetrics metrics;
    const RfImage *image = pair->images, *reference = pair->images + 1;
    RfResult result = rf_measure_error( image, reference, &metrics, error );
    if ( result == RF_OK && !compare->has_all )
    {
        result = rf_create_summary( image->width, image->height, compare->in.count, &compare->all, error );
        compare->has_all = result == RF_OK;
    }
    if ( result == RF_OK )
        result = rf_summary_add( &compare->all, image, reference, error );
    if ( result != RF_OK )
    {
        char reason[512];
        snprintf( reason, sizeof reason, "%.511s", error->text );
        return rf_fail( error, result, "%.200s against %.200s: %s", pair->names[0], pair->names[1], reason );
    }
    place_worst( compare, &pair->window, &metrics );
    char number[16];
    snprintf( number, sizeof number, "%d", frame );
    if ( compare->table && json_array_size( compare->rows ) == 0 )
        rf_print_error_head();
    if ( compare->table )
        rf_print_error_row( number, &metrics );
    json_array_append_new( compare->rows, rf_error_frame_json( frame, &metrics ) );
    return RF_OK;
}

static RfResult compare_frame( Compare* compare, int frame, RfError* error )
{
    RfComparePair pair;
    RfResult result = rf_read_compare_pair( &compare->in, frame, &pair, error );
    if ( result == RF_OK )
        result = measure( compare, frame, &pair, error );
    if ( result == RF_OK && compare->diff != NULL )
        result = write_diff( compare, frame, &pair, error );
    rf_destroy_compare_pair( &pair );
    return result;
}

static RfResult check_finite( const Compare* compare, const RfErrorMetrics* m, RfError* error )
{
    bool image = m->nan > 0 || m->inf > 0, reference = m->reference_nan > 0 || m->reference_inf > 0;
    const char* const* patterns = compare->in.patterns;
    if ( image && reference )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "%.380s: %zu pixels with NaN, %zu with infinity, and %.380s: %zu and %zu: no error can be reported",
                        patterns[0], m->nan, m->inf, patterns[1], m->reference_nan, m->reference_inf );
    if ( image || reference )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no error can be reported",
                        patterns[reference], image ? m->nan : m->reference_nan, image ? m->inf : m->reference_inf );
    return RF_OK;
}

static RfResult finish( Compare* compare, RfError* error )
{
    RfErrorMetrics metrics = rf_summary_metrics( &compare->all );
    metrics.worst = compare->worst;
    if ( rf_has_no_error( &metrics ) )
        metrics.worst.frame = -1;
    int worst = metrics.worst.frame >= 0 ? frame_number( compare, metrics.worst.frame ) : -1;
    char verdict[1024];
    rf_error_verdict( &metrics, compare->in.frames != NULL ? worst : -1, verdict, sizeof verdict );
    if ( compare->table )
        rf_print_error_row( "all", &metrics );
    if ( compare->table && isfinite( metrics.bias_low ) )
        printf( "bias, 95 %% interval: %+.4e to %+.4e\n", metrics.bias_low, metrics.bias_high );
    if ( compare->table && !rf_has_no_error( &metrics ) )
        printf( "%s\n", verdict );
    if ( compare->table )
        rf_print_missing( &compare->in );
    RfResult result = RF_OK;
    if ( compare->json != NULL )
    {
        json_t* json = rf_error_json( json_incref( compare->rows ), &metrics, worst, verdict );
        rf_set_missing( json, &compare->in );
        result = rf_write_json( compare->json, json, error );
    }
    if ( result == RF_OK )
        result = rf_flush_output( error );
    return result == RF_OK ? check_finite( compare, &metrics, error ) : result;
}

static RfResult run( Compare* compare, RfError* error )
{
    RfResult result = rf_find_compare_frames( &compare->in, error );
    if ( result == RF_OK )
        result = check_diff( compare, error );
    if ( result != RF_OK )
        return result;
    compare->rows = json_array();
    for ( int i = 0; i < compare->in.count && result == RF_OK; ++i )
    {
        result = compare_frame( compare, frame_number( compare, i ), error );
        show_progress( compare, i + 1 );
    }
    if ( result == RF_OK )
        result = finish( compare, error );
    json_decref( compare->rows );
    if ( compare->has_all )
        rf_destroy_summary( &compare->all );
    return result;
}

int rf_command_compare( int argc, char** argv )
{
    static const char* const files[] = { "A", "B" };
    Compare compare = { .worst = { .frame = -1 } };
    const RfOption options[] = {
        { .name = "frames",
          .type = RF_OPTION_STRING,
          .value = &compare.in.list,
          .meta = "A-B[xSTEP][,...]",
          .default_text = "all",
          .help = "only these of the sequences, by their numbers" },
        { .name = "layer",
          .type = RF_OPTION_STRING,
          .value = compare.in.layers,
          .meta = "NAME",
          .default_text = "the colour",
          .help = "a layer, part or channel of the files, or three channels X,Y,Z" },
        { .name = "reference-layer",
          .type = RF_OPTION_STRING,
          .value = compare.in.layers + 1,
          .meta = "NAME",
          .default_text = "that of --layer",
          .help = "the same of B, where its name is another" },
        { .name = "overlap",
          .type = RF_OPTION_BOOL,
          .value = &compare.in.overlap,
          .default_text = "off",
          .help = "where the data windows differ, measure the pixels that both have" },
        { .name = "diff",
          .writes = ".exr",
          .type = RF_OPTION_STRING,
          .value = &compare.diff,
          .meta = "FILE",
          .help = "write A - B, signed, as EXR; #### is the frame" },
        { .name = "json",
          .writes = ".json",
          .type = RF_OPTION_STRING,
          .value = &compare.json,
          .meta = "FILE",
          .help = "write the results as JSON, - for standard output instead of the table" },
        { .name = "quiet", .type = RF_OPTION_BOOL, .value = &compare.quiet, .help = "no progress on standard error" },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "The error of A against the reference B: EXR files, sequences named with ####, or folders of "
                   "one sequence each, whose frames are paired by their numbers.",
        .files = files,
        .file_count = 2,
        .options = options,
        .option_count = sizeof options / sizeof options[0],
    };
    RfError error = { 0 };
    bool help = false;
    RfResult result = rf_parse_options( &table, argc, argv, compare.in.patterns, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &table, stdout );
        result = rf_flush_output( &error );
        return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
    }
    compare.table = compare.json == NULL || strcmp( compare.json, "-" ) != 0;
    if ( compare.in.layers[1] == NULL )
        compare.in.layers[1] = compare.in.layers[0];
    if ( result == RF_OK )
        result = run( &compare, &error );
    rf_free_compare_frames( &compare.in );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
