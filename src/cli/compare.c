// reframe compare A B: the error of image A against reference B, files or
// sequences, frame by frame and over all frames.
#include "cli/commands.h"
#include "cli/options.h"
#include "cli/progress.h"
#include "cli/report.h"
#include "image/exr.h"
#include "image/sequence.h"
#include "measure/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define COMMAND "compare"
#define NAME_SIZE 4096

typedef struct Compare
{
    const char* patterns[2]; // A, B
    const char* diff;        // or NULL
    const char* json;        // or NULL
    bool quiet;
    bool table;    // standard output is free for the table
    int* frames;   // NULL: two files, which count as frame 1
    int frame_count;
    RfErrorSummary all;
    bool has_all;  // `all` has been created, for the first frame's size
    json_t* rows;
} Compare;

// The line of one frame or of all; NaN and Inf of both images.
static void print_row( const char* frame, const RfErrorMetrics* metrics )
{
    printf( "%7s  %11.4e  %11.4e  %11.4e  %+11.4e  %11.4e  %6zu  %6zu\n", frame, metrics->relmse,
            metrics->relmse_trimmed, metrics->mse, metrics->bias, metrics->max, metrics->nan + metrics->reference_nan,
            metrics->inf + metrics->reference_inf );
}

static void print_head( void )
{
    printf( "%7s  %11s  %11s  %11s  %11s  %11s  %6s  %6s\n", "frame", "relMSE", "trimmed", "MSE", "bias", "max", "NaN",
            "Inf" );
}

static void print_all( const RfErrorMetrics* metrics )
{
    print_row( "all", metrics );
    if ( isfinite( metrics->bias_low ) )
        printf( "bias, 95 %% interval: %+.4e to %+.4e\n", metrics->bias_low, metrics->bias_high );
}

static void set_metrics( json_t* object, const RfErrorMetrics* metrics )
{
    json_object_set_new( object, "relmse", rf_json_number( metrics->relmse ) );
    json_object_set_new( object, "relmse_trimmed", rf_json_number( metrics->relmse_trimmed ) );
    json_object_set_new( object, "mse", rf_json_number( metrics->mse ) );
    json_object_set_new( object, "bias", rf_json_number( metrics->bias ) );
    json_object_set_new( object, "max", rf_json_number( metrics->max ) );
    json_object_set_new( object, "nan", json_integer( (json_int_t)metrics->nan ) );
    json_object_set_new( object, "inf", json_integer( (json_int_t)metrics->inf ) );
    json_object_set_new( object, "reference_nan", json_integer( (json_int_t)metrics->reference_nan ) );
    json_object_set_new( object, "reference_inf", json_integer( (json_int_t)metrics->reference_inf ) );
}

static json_t* frame_json( int frame, const RfErrorMetrics* metrics )
{
    json_t* row = json_object();
    json_object_set_new( row, "frame", json_integer( frame ) );
    set_metrics( row, metrics );
    return row;
}

static json_t* all_json( json_t* rows, const RfErrorMetrics* metrics )
{
    json_t* object = json_object();
    json_object_set( object, "frames", rows );
    set_metrics( object, metrics );
    json_object_set_new( object, "bias_low", rf_json_number( metrics->bias_low ) );
    json_object_set_new( object, "bias_high", rf_json_number( metrics->bias_high ) );
    return object;
}

static void show_progress( const Compare* compare, int i )
{
    bool rows_are_seen = compare->table && isatty( STDOUT_FILENO ) != 0; // they are progress enough
    rf_show_frame_count( compare->quiet || rows_are_seen || compare->frame_count < 2, i, compare->frame_count );
}

// A frame that only one of the sequences has is an error that names it.
static RfResult match_frames( const Compare* compare, const int* a, int a_count, const int* b, int b_count,
                              RfError* error )
{
    int count = a_count > b_count ? a_count : b_count;
    for ( int i = 0; i < count; ++i )
    {
        if ( i < a_count && i < b_count && a[i] == b[i] )
            continue;
        bool in_a = i == b_count || ( i < a_count && a[i] < b[i] );
        return rf_fail( error, RF_ERROR_IO, "frame %d is in %s but not in %s: compare sequences of the same frames",
                        in_a ? a[i] : b[i], compare->patterns[in_a ? 0 : 1], compare->patterns[in_a ? 1 : 0] );
    }
    return RF_OK;
}

static RfResult find_sequences( Compare* compare, RfError* error )
{
    int* b = NULL;
    int b_count = 0;
    RfResult result = rf_sequence_frames( compare->patterns[0], &compare->frames, &compare->frame_count, error );
    if ( result == RF_OK )
        result = rf_sequence_frames( compare->patterns[1], &b, &b_count, error );
    if ( result == RF_OK )
        result = match_frames( compare, compare->frames, compare->frame_count, b, b_count, error );
    free( b );
    return result;
}

static RfResult find_frames( Compare* compare, RfError* error )
{
    bool sequences[2] = { rf_is_sequence( compare->patterns[0] ), rf_is_sequence( compare->patterns[1] ) };
    compare->frame_count = 1;
    if ( sequences[0] != sequences[1] )
        return rf_fail( error, RF_ERROR_USAGE, "%s is a sequence and %s a single file: give two of a kind",
                        compare->patterns[sequences[0] ? 0 : 1], compare->patterns[sequences[0] ? 1 : 0] );
    if ( sequences[0] )
    {
        RfResult result = find_sequences( compare, error );
        if ( result != RF_OK )
            return result;
    }
    if ( compare->diff != NULL && compare->frame_count > 1 && !rf_is_sequence( compare->diff ) )
        return rf_fail( error, RF_ERROR_USAGE, "--diff: %d frames want a name with ####, got '%s'",
                        compare->frame_count, compare->diff );
    return RF_OK;
}

// The file of a frame: only where there are sequences is '#' looked at.
static RfResult frame_name( const Compare* compare, const char* pattern, int frame, char* name, RfError* error )
{
    if ( compare->frames != NULL || rf_is_sequence( pattern ) )
        return rf_sequence_name( pattern, frame, name, NAME_SIZE, error );
    if ( snprintf( name, NAME_SIZE, "%s", pattern ) >= NAME_SIZE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", pattern );
    return RF_OK;
}

// Turns the image into the signed difference, and writes it.
static RfResult write_diff( const Compare* compare, int frame, RfImage* image, const RfImage* reference,
                            RfError* error )
{
    char name[NAME_SIZE];
    RfResult result = frame_name( compare, compare->diff, frame, name, error );
    if ( result != RF_OK )
        return result;
    size_t count = 3 * (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < count; ++i )
        image->rgb[i] -= reference->rgb[i];
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    return rf_write_exr( name, image, &options, error );
}

static RfResult measure( Compare* compare, int frame, char names[2][NAME_SIZE], const RfImage* image,
                         const RfImage* reference, RfError* error )
{
    RfErrorMetrics metrics;
    RfResult result = rf_measure_error( image, reference, &metrics, error );
    if ( result == RF_OK && !compare->has_all )
    {
        result = rf_create_summary( image->width, image->height, compare->frame_count, &compare->all, error );
        compare->has_all = result == RF_OK;
    }
    if ( result == RF_OK )
        result = rf_summary_add( &compare->all, image, reference, error );
    if ( result != RF_OK )
        return rf_fail( error, result, "%s against %s: %s", names[0], names[1], error->text );
    char number[16];
    snprintf( number, sizeof number, "%d", frame );
    if ( compare->table && json_array_size( compare->rows ) == 0 )
        print_head();
    if ( compare->table )
        print_row( number, &metrics );
    json_array_append_new( compare->rows, frame_json( frame, &metrics ) );
    return RF_OK;
}

static RfResult compare_frame( Compare* compare, int frame, RfError* error )
{
    char names[2][NAME_SIZE];
    RfImage images[2] = { { 0 }, { 0 } };
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        result = frame_name( compare, compare->patterns[i], frame, names[i], error );
        if ( result == RF_OK )
            result = rf_read_exr( names[i], images + i, error );
    }
    if ( result == RF_OK )
        result = measure( compare, frame, names, images, images + 1, error );
    if ( result == RF_OK && compare->diff != NULL )
        result = write_diff( compare, frame, images, images + 1, error );
    rf_destroy_image( images );
    rf_destroy_image( images + 1 );
    return result;
}

static RfResult check_finite( const Compare* compare, const RfErrorMetrics* m, RfError* error )
{
    bool image = m->nan > 0 || m->inf > 0, reference = m->reference_nan > 0 || m->reference_inf > 0;
    if ( image && reference )
        return rf_fail( error, RF_ERROR_FORMAT, "%.380s: %zu pixels with NaN, %zu with infinity, and %.380s: %zu and %zu: no error can be told",
                        compare->patterns[0], m->nan, m->inf, compare->patterns[1], m->reference_nan, m->reference_inf );
    if ( image || reference )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no error can be told",
                        compare->patterns[reference], image ? m->nan : m->reference_nan, image ? m->inf : m->reference_inf );
    return RF_OK;
}

static RfResult finish( Compare* compare, RfError* error )
{
    RfErrorMetrics metrics = rf_summary_metrics( &compare->all );
    if ( compare->table )
        print_all( &metrics );
    RfResult result = RF_OK;
    if ( compare->json != NULL )
        result = rf_write_json( compare->json, all_json( compare->rows, &metrics ), error );
    if ( result == RF_OK )
        result = rf_flush_output( error );
    return result == RF_OK ? check_finite( compare, &metrics, error ) : result;
}

static RfResult run( Compare* compare, RfError* error )
{
    RfResult result = find_frames( compare, error );
    if ( result != RF_OK )
        return result;
    compare->rows = json_array();
    for ( int i = 0; i < compare->frame_count && result == RF_OK; ++i )
    {
        result = compare_frame( compare, compare->frames != NULL ? compare->frames[i] : 1, error );
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
    Compare compare = { 0 };
    const RfOption options[] = {
        { .name = "diff", .type = RF_OPTION_STRING, .value = &compare.diff, .meta = "FILE",
          .help = "write A - B, signed, as EXR; #### is the frame" },
        { .name = "json", .type = RF_OPTION_STRING, .value = &compare.json, .meta = "FILE",
          .help = "write the results as JSON, - for standard output instead of the table" },
        { .name = "quiet", .type = RF_OPTION_BOOL, .value = &compare.quiet, .help = "no progress on standard error" },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "The error of A against the reference B: EXR files, or sequences named with ####.",
        .files = files,
        .file_count = 2,
        .options = options,
        .option_count = sizeof options / sizeof options[0],
    };
    RfError error = { 0 };
    bool help = false;
    RfResult result = rf_parse_options( &table, argc, argv, compare.patterns, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &table, stdout );
        result = rf_flush_output( &error );
        return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
    }
    compare.table = compare.json == NULL || strcmp( compare.json, "-" ) != 0;
    if ( result == RF_OK )
        result = run( &compare, &error );
    free( compare.frames );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
