// reframe compare A B: the error of image A against reference B, files or
// sequences, frame by frame and over all frames.
#include "base/try.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/shared_options.h"
#include "cli/render/progress.h"
#include "image/sequence.h"
#include "measure/image_error.h"
#include "output/frame_file.h"
#include "page/pass_groups.h"
#include "reframe/effects.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct CompareFrames
{
    const char* names[2]; // A, B as given
    RfSequenceInput in[2];
    const char* layers[2]; // NULL: the colour
    const char* list;      // of --frames; NULL: all
    bool overlap;          // measure what both have
    RfFramePairs pairs;    // of sequences
    int count;             // of frames, or 1
    int* missing;          // between the first and the last, of both sequences
    int missing_count;
} CompareFrames;

// Two images of the same pixels, and their window.
typedef struct ComparePair
{
    size_t clipped[2]; // pixels
    char names[2][RF_FILE_NAME_SIZE];
    RfImage images[2];
    RfExrWindow window;
} ComparePair;

static void print_error_head( void )
{
    printf( "%7s  %11s  %11s  %11s  %11s  %11s  %6s  %6s\n", "frame", "relMSE", "trimmed", "MSE", "bias", "max", "NaN", "Inf" );
}

// Prints the row of a frame, or of "all", with the NaN and Inf of both images.
static void print_error_row( const char* frame, const RfErrorMetrics* metrics )
{
    printf( "%7s  %11.4e  %11.4e  %11.4e  %+11.4e  %11.4e  %6zu  %6zu\n", frame, metrics->relmse, metrics->relmse_trimmed,
            metrics->mse, metrics->bias, metrics->max, metrics->nan + metrics->reference_nan,
            metrics->inf + metrics->reference_inf );
}

static void set_metrics( json_t* object, const RfErrorMetrics* m )
{
    RF_SET_FIGURES( object, { "relmse", m->relmse }, { "relmse_trimmed", m->relmse_trimmed }, { "mse", m->mse },
                    { "bias", m->bias }, { "bias_low", m->bias_low }, { "bias_high", m->bias_high }, { "max", m->max } );
    rf_json_add( object, "{s:I, s:I, s:I, s:I, s:o}", "nan", (json_int_t)m->nan, "inf", (json_int_t)m->inf, "reference_nan",
                 (json_int_t)m->reference_nan, "reference_inf", (json_int_t)m->reference_inf, "reference_mean",
                 rf_json_number( m->reference_mean ) );
}

static void set_clipped( json_t* object, const size_t clipped[2] )
{
    rf_json_add( object, "{s:I, s:I}", "clipped", (json_int_t)clipped[0], "reference_clipped", (json_int_t)clipped[1] );
}

static json_t* worst_json( int frame, const RfWorstPixel* worst )
{
    return worst->frame < 0 ? json_null()
                            : json_pack( "{s:i, s:i, s:i, s:o}", "frame", frame, "x", worst->x, "y", worst->y, "relative",
                                         rf_json_number( worst->relative ) );
}

// In percent of the reference's brightness, where it has one. Clipped pixels lack light, so their bias is not that of the renders.
static void say_bias( const RfErrorMetrics* m, const size_t clipped[2], char* text, size_t size )
{
    bool relative = m->reference_mean > 0.0;
    double scale = relative ? 100.0 / m->reference_mean : 1.0, bias = m->bias * scale;
    double low = m->bias_low * scale, high = m->bias_high * scale;
    const char* unit = relative ? " %" : "";
    const char* what = low > 0.0    ? "significant bias, too bright"
                       : high < 0.0 ? "significant bias, too dark"
                                    : "no significant bias";
    if ( clipped[0] + clipped[1] > 0 )
        rf_append( text, size, "no verdict on bias, clipped pixels are compared (%zu of A, %zu of B): mean error %+.2g%s",
                   clipped[0], clipped[1], bias, unit );
    else if ( !isfinite( m->bias_low ) )
        rf_append( text, size, "mean error %+.2g%s (too few pixels to tell bias from noise)", bias, unit );
    else
        rf_append( text, size, "%s: mean error %+.2g%s (95 %%: %+.2g to %+.2g%s)", what, bias, unit, low, high, unit );
}

// Of a picture that is off everywhere the error is not noise.
static bool is_offset( const RfErrorMetrics* m ) { return m->bias * m->bias > 0.5 * m->mse; }

static void say_noise( const RfErrorMetrics* m, char* text, size_t size )
{
    char percent[RF_NOISE_TEXT_SIZE];
    rf_format_noise( m->relmse, percent );
    rf_append( text, size, "; relMSE %.3g (about %s %s per pixel", m->relmse, percent, is_offset( m ) ? "error" : "noise" );
    rf_format_noise( m->relmse_trimmed, percent );
    if ( m->relmse_trimmed < 0.5 * m->relmse )
        rf_append( text, size, ", %s without the worst 0.1 %% of pixels", percent );
    rf_append( text, size, ")" );
}

void rf_error_verdict( const RfErrorMetrics* m, const size_t clipped[2], const int* worst_frame, char* text, size_t size )
{
    text[0] = '\0';
    if ( rf_has_no_error( m ) )
    {
        rf_append( text, size, "no error can be reported: there are NaN or infinite values" );
        return;
    }
    if ( m->max == 0.0 )
    {
        rf_append( text, size, "no difference: all pixels are identical%s", clipped[0] > 0 ? ", clipped ones too" : "" );
        return;
    }
    say_bias( m, clipped, text, size );
    say_noise( m, text, size );
    if ( m->worst.frame < 0 )
        return;
    rf_append( text, size, "; worst pixel (%d, %d)", m->worst.x, m->worst.y );
    if ( worst_frame != NULL )
        rf_append( text, size, " in frame %d", *worst_frame );
    rf_append( text, size, ", off by %.2g %%", 100.0 * sqrt( m->worst.relative / 3.0 ) );
}

static void print_not_measured( const char* lacking, const int* frames, int count )
{
    char text[256];
    rf_format_frames( frames, count, text, sizeof text );
    if ( count > 0 )
        rf_print( "not measured: frame%s %s, missing from %s\n", count == 1 ? "" : "s", text, lacking );
}

// Prints which frames were not measured, and whose they lack; nothing where there is none. And the same
// as keys of the JSON.
static void print_missing( const CompareFrames* frames )
{
    print_not_measured( "both sequences", frames->missing, frames->missing_count );
    for ( int i = 0; i < 2; ++i )
        print_not_measured( frames->in[i].pattern, frames->pairs.lacking[i], frames->pairs.lacking_count[i] );
}

static void set_missing( json_t* json, const CompareFrames* frames )
{
    const RfFramePairs* pairs = &frames->pairs;
    rf_json_add( json, "{s:o, s:o, s:o}", "missing", rf_json_frames( frames->missing, frames->missing_count ), "missing_a",
                 rf_json_frames( pairs->lacking[0], pairs->lacking_count[0] ), "missing_b",
                 rf_json_frames( pairs->lacking[1], pairs->lacking_count[1] ) );
}

// Of the sequence that has a frame which both are to have, but for folders, whose common frames are measured.
static RfResult check_pairs( CompareFrames* frames, RfError* error )
{
    RfFramePairs* pairs = &frames->pairs;
    const char* const patterns[2] = { frames->in[0].pattern, frames->in[1].pattern };
    if ( frames->list != NULL && pairs->lacking_count[1] > 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: frame %d is missing", patterns[1], pairs->lacking[1][0] );
    if ( frames->list != NULL ) // what else B has is not wanted
    {
        pairs->lacking_count[0] = 0;
        return RF_OK;
    }
    if ( !rf_is_folder( frames->names[0] ) && !rf_is_folder( frames->names[1] ) )
        return rf_check_all_paired( pairs, patterns, error );
    return pairs->count > 0
               ? RF_OK
               : rf_fail( error, RF_ERROR_IO, "%.400s and %.400s have no frame in common", patterns[0], patterns[1] );
}

// Finds the frames of two sequences, which must be the same but for those of folders, or the two files.
// free_compare_frames in any case.
static RfResult find_compare_frames( CompareFrames* frames, RfError* error )
{
    RfSequenceInput* in = frames->in;
    RfResult result = rf_find_sequence_input( frames->names[0], frames->list, in, error );
    if ( result == RF_OK )
        result = rf_find_sequence_input( frames->names[1], NULL, in + 1, error );
    if ( result == RF_OK && in[0].is_sequence != in[1].is_sequence )
        result = rf_fail( error, RF_ERROR_USAGE, "%s is a sequence and %s a single file: give two of a kind",
                          in[!in[0].is_sequence].pattern, in[in[0].is_sequence].pattern );
    frames->count = 1;
    if ( result != RF_OK || !in[0].is_sequence )
        return result;
    result = rf_pair_frames( ( const int* const[] ){ in[0].frames, in[1].frames }, ( const int[] ){ in[0].count, in[1].count },
                             &frames->pairs, error );
    if ( result == RF_OK )
        result = check_pairs( frames, error );
    frames->count = frames->pairs.count;
    if ( result != RF_OK || frames->list != NULL )
        return result;
    return rf_missing_frames( frames->pairs.all, frames->pairs.all_count, &frames->missing, &frames->missing_count, error );
}

static void free_compare_frames( CompareFrames* frames )
{
    rf_free_sequence_input( frames->in );
    rf_free_sequence_input( frames->in + 1 );
    rf_free_frame_pairs( &frames->pairs );
    free( frames->missing );
}

static int frame_number( const CompareFrames* frames, int i ) { return frames->pairs.both != NULL ? frames->pairs.both[i] : 1; }

static int at_least( int a, int b ) { return a > b ? a : b; }
static int at_most( int a, int b ) { return a < b ? a : b; }

static void crop( RfImage* image, const RfExrWindow* from, const RfExrWindow* to )
{
    for ( int y = 0; y < to->height; ++y )
    {
        size_t row = (size_t)( to->y - from->y + y ) * (size_t)from->width + (size_t)( to->x - from->x );
        memmove( image->rgb + 3 * (size_t)y * (size_t)to->width, image->rgb + 3 * row, 3 * (size_t)to->width * sizeof( float ) );
    }
    image->width = to->width;
    image->height = to->height;
}

static RfResult align( bool overlap, ComparePair* pair, const RfExrWindow windows[2], RfError* error )
{
    const RfExrWindow *a = windows, *b = windows + 1;
    pair->window = *a;
    if ( memcmp( a, b, sizeof *a ) == 0 )
        return RF_OK;
    if ( !overlap && a->x == b->x && a->y == b->y )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "%.300s has %dx%d pixels, %.300s %dx%d: --overlap compares the pixels that both have", pair->names[0],
                        a->width, a->height, pair->names[1], b->width, b->height );
    if ( !overlap )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "the data windows differ: %.300s has %dx%d pixels from (%d, %d) on, %.300s %dx%d from (%d, %d) on: "
                        "--overlap compares the pixels that both have",
                        pair->names[0], a->width, a->height, a->x, a->y, pair->names[1], b->width, b->height, b->x, b->y );
    RfExrWindow both = { .x = at_least( a->x, b->x ), .y = at_least( a->y, b->y ) };
    int64_t right = at_most( a->x + ( a->width - 1 ), b->x + ( b->width - 1 ) );
    int64_t bottom = at_most( a->y + ( a->height - 1 ), b->y + ( b->height - 1 ) );
    if ( right < both.x || bottom < both.y )
        return rf_fail( error, RF_ERROR_FORMAT, "%.400s and %.400s have no pixel in common: their data windows lie apart",
                        pair->names[0], pair->names[1] );
    both.width = (int)( right - both.x + 1 );
    both.height = (int)( bottom - both.y + 1 );
    for ( int i = 0; i < 2; ++i )
        crop( pair->images + i, windows + i, &both );
    pair->window = both;
    return RF_OK;
}

// Clipped pixels that only the header tells of, since DWA changes their values.
static size_t hidden_clipped( const char* name, const char* layer )
{
    char layers[RF_EFFECTS_TEXT_SIZE];
    const char* wanted = layer != NULL ? layer : RF_COLOUR_LAYER;
    size_t length = strlen( wanted );
    bool listed = false;
    if ( rf_read_exr_string( name, rf_key_name( RF_KEY_CLIPPED_LAYERS ), layers, sizeof layers, NULL ) != RF_OK )
        return 0;
    for ( const char* word = layers; *word != '\0' && !listed; word += strcspn( word, "," ), word += *word == ',' )
        listed = strncmp( word, wanted, length ) == 0 && ( word[length] == ',' || word[length] == '\0' );
    double pixels = listed ? rf_read_exr_number( name, rf_key_name( RF_KEY_CLIPPED_PIXELS ) ) : 0.0;
    return isgreater( pixels, 0.0 ) && pixels < 1e15 ? (size_t)pixels : 0;
}

static RfResult read_compare_pair( const CompareFrames* frames, int frame, ComparePair* pair, RfError* error )
{
    RfExrWindow windows[2] = { { 0 }, { 0 } };
    RfResult result = RF_OK;
    pair->images[0] = pair->images[1] = ( RfImage ){ 0 };
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        result = rf_sequence_input_name( frames->in + i, frame, pair->names[i], error );
        if ( result == RF_OK )
            result =
                rf_read_pass_image( pair->names[i], frames->layers[i], pair->images + i, windows + i, pair->clipped + i, error );
        if ( result == RF_OK && pair->clipped[i] == 0 )
            pair->clipped[i] = hidden_clipped( pair->names[i], frames->layers[i] );
    }
    return result == RF_OK ? align( frames->overlap, pair, windows, error ) : result;
}

static void destroy_compare_pair( ComparePair* pair )
{
    rf_destroy_image( pair->images );
    rf_destroy_image( pair->images + 1 );
}

#define COMMAND "compare"

typedef struct Compare
{
    CompareFrames in;
    const char* diff; // or NULL
    const char* json; // or NULL
    bool quiet;
    bool table; // the table goes to standard output
    RfErrorSummary all;
    RfWorstPixel worst; // of all frames so far, where the files have it
    size_t clipped[2];  // pixels of A and B, over all frames
    json_t* rows;
} Compare;

static void show_progress( const Compare* compare, int i )
{
    bool rows_are_seen = compare->table && isatty( STDOUT_FILENO ) != 0; // they show the progress
    rf_show_frame_count( compare->quiet || rows_are_seen || compare->in.count < 2, i, compare->in.count );
}

// The signed difference of a frame.
static RfResult diff_name( const Compare* compare, int frame, char name[RF_FILE_NAME_SIZE], RfError* error )
{
    if ( rf_is_sequence( compare->diff ) )
        return rf_sequence_name( compare->diff, frame, name, RF_FILE_NAME_SIZE, error );
    if ( snprintf( name, RF_FILE_NAME_SIZE, "%s", compare->diff ) >= RF_FILE_NAME_SIZE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", compare->diff );
    return RF_OK;
}

// No difference image may overwrite a frame of this sequence.
static RfResult check_diff_names( const Compare* compare, const RfSequenceInput* in, RfError* error )
{
    int count = compare->in.count;
    struct stat* frames = calloc( (size_t)count, sizeof *frames );
    char name[RF_FILE_NAME_SIZE];
    RfResult result =
        frames != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "out of memory for the names of %d frames", count );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        result = rf_sequence_input_name( in, frame_number( &compare->in, i ), name, error );
        if ( result == RF_OK && stat( name, frames + i ) != 0 )
            frames[i].st_ino = 0;
    }
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        struct stat diff;
        result = diff_name( compare, frame_number( &compare->in, i ), name, error );
        bool is_there = result == RF_OK && stat( name, &diff ) == 0;
        for ( int k = 0; k < count && is_there && result == RF_OK; ++k )
        {
            if ( frames[k].st_ino == diff.st_ino && frames[k].st_dev == diff.st_dev )
                result = rf_fail( error, RF_ERROR_USAGE, "--diff: %s: is one of the images being compared: choose another name",
                                  name );
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
        return rf_fail( error, RF_ERROR_USAGE, "--diff: %d frames need a name with ####, got '%s'", compare->in.count,
                        compare->diff );
    RF_TRY( check_diff_names( compare, compare->in.in, error ) );
    return check_diff_names( compare, compare->in.in + 1, error );
}

// Turns the image into the signed difference, and writes it.
static RfResult write_diff( const Compare* compare, int frame, ComparePair* pair, RfError* error )
{
    RfImage* image = pair->images;
    const RfImage* reference = pair->images + 1;
    char name[RF_FILE_NAME_SIZE];
    RF_TRY( diff_name( compare, frame, name, error ) );
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

static RfResult measure( Compare* compare, int frame, const ComparePair* pair, RfError* error )
{
    RfErrorMetrics metrics;
    const RfImage *image = pair->images, *reference = pair->images + 1;
    RfResult result = rf_measure_frame( &compare->all, compare->in.count, image, reference, &metrics, error );
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
        print_error_head();
    if ( compare->table )
        print_error_row( number, &metrics );
    json_t* row = json_pack( "{s:i}", "frame", frame );
    set_metrics( row, &metrics );
    rf_json_add( row, "{s:o}", "worst", worst_json( frame, &metrics.worst ) );
    set_clipped( row, pair->clipped );
    json_array_append_new( compare->rows, row );
    for ( int i = 0; i < 2; ++i )
        compare->clipped[i] += pair->clipped[i];
    return RF_OK;
}

static RfResult compare_frame( Compare* compare, int frame, RfError* error )
{
    ComparePair pair;
    RfResult result = read_compare_pair( &compare->in, frame, &pair, error );
    if ( result == RF_OK )
        result = measure( compare, frame, &pair, error );
    if ( result == RF_OK && compare->diff != NULL )
        result = write_diff( compare, frame, &pair, error );
    destroy_compare_pair( &pair );
    return result;
}

static RfResult check_finite( const Compare* compare, const RfErrorMetrics* m, RfError* error )
{
    bool image = m->nan > 0 || m->inf > 0, reference = m->reference_nan > 0 || m->reference_inf > 0;
    const char *a = compare->in.in[0].pattern, *b = compare->in.in[1].pattern;
    if ( image && reference )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "%.380s: %zu pixels with NaN, %zu with infinity, and %.380s: %zu and %zu: no error can be reported", a,
                        m->nan, m->inf, b, m->reference_nan, m->reference_inf );
    if ( image || reference )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no error can be reported",
                        reference ? b : a, image ? m->nan : m->reference_nan, image ? m->inf : m->reference_inf );
    return RF_OK;
}

static RfResult finish( Compare* compare, RfError* error )
{
    RfErrorMetrics metrics = rf_summary_metrics( &compare->all );
    metrics.worst = compare->worst;
    if ( rf_has_no_error( &metrics ) )
        metrics.worst.frame = -1;
    bool has_worst = metrics.worst.frame >= 0 && compare->in.pairs.both != NULL;
    int worst = metrics.worst.frame >= 0 ? frame_number( &compare->in, metrics.worst.frame ) : 0;
    char verdict[1024];
    rf_error_verdict( &metrics, compare->clipped, has_worst ? &worst : NULL, verdict, sizeof verdict );
    if ( compare->table )
        print_error_row( "all", &metrics );
    if ( compare->table && isfinite( metrics.bias_low ) )
        printf( "bias, 95 %% confidence interval: %+.4e to %+.4e\n", metrics.bias_low, metrics.bias_high );
    if ( compare->table && !rf_has_no_error( &metrics ) )
        printf( "%s\n", verdict );
    if ( compare->table )
        print_missing( &compare->in );
    RfResult result = RF_OK;
    if ( compare->json != NULL )
    {
        json_t* json = json_pack( "{s:O}", "frames", compare->rows );
        set_metrics( json, &metrics );
        rf_json_add( json, "{s:o, s:o}", "worst", worst_json( worst, &metrics.worst ), "verdict", rf_json_text( verdict ) );
        set_missing( json, &compare->in );
        set_clipped( json, compare->clipped );
        result = rf_write_json( compare->json, json, error );
    }
    if ( result == RF_OK )
        result = rf_flush_output( error );
    return result == RF_OK ? check_finite( compare, &metrics, error ) : result;
}

static RfResult run( void* user, RfError* error )
{
    Compare* compare = user;
    compare->table = rf_prints_text( compare->json );
    if ( compare->in.layers[1] == NULL )
        compare->in.layers[1] = compare->in.layers[0];
    RF_TRY( find_compare_frames( &compare->in, error ) );
    RF_TRY( check_diff( compare, error ) );
    compare->rows = json_array();
    RfResult result = RF_OK;
    for ( int i = 0; i < compare->in.count && result == RF_OK; ++i )
    {
        result = compare_frame( compare, frame_number( &compare->in, i ), error );
        show_progress( compare, i + 1 );
    }
    if ( result == RF_OK )
        result = finish( compare, error );
    json_decref( compare->rows );
    rf_destroy_summary( &compare->all );
    return result;
}

int rf_command_compare( int argc, char** argv )
{
    static const char* const files[] = { "A", "B" };
    Compare compare = { .worst = { .frame = -1 } };
    const RfOption options[] = {
        RF_TEXT_OPTION( "frames", &compare.in.list, "[@]A-B[xSTEP][,...]", "compare only these frames of the sequences",
                        .default_text = "all" ),
        RF_TEXT_OPTION( "layer", compare.in.layers, "NAME",
                        "a pass by name, a part or a channel of the files, or three channels X,Y,Z", .default_text = "colour" ),
        RF_TEXT_OPTION( "reference-layer", compare.in.layers + 1, "NAME", "layer of B, if it is named differently",
                        .default_text = "that of --layer" ),
        RF_FLAG_OPTION( "overlap", &compare.in.overlap, "if the data windows differ, compare the pixels that both have" ),
        RF_TEXT_OPTION( "diff", &compare.diff, "FILE", "write the signed difference A - B as EXR; #### is the frame number",
                        .writes = ".exr" ),
        RF_RESULT_OPTIONS( compare, "write the result as JSON; - for standard output, instead of the table", "no progress" ),
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "Measures the error of A against the reference B: EXR files, sequences named with ####, or folders of one "
                   "sequence each, whose frames are matched by number.",
        RF_TABLE_ROWS( files, options )
    };
    int status = rf_run_command( &table, argc, argv, compare.in.names, run, &compare );
    free_compare_frames( &compare.in );
    return status;
}
