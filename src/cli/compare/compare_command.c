// reframe compare A B: the error of image A against reference B, files or
// sequences, frame by frame and over all frames.
#include "cli/compare/compare_command.h"

#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "image/sequence.h"
#include "measure/image_error.h"
#include "measure/sequences.h"
#include "output/frame_file.h"
#include "page/pass_groups.h"
#include "reframe/effects.h"
#include "reframe/image.h"
#include "reframe/measure.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define COMPARE_NAME_SIZE 4096

typedef struct CompareFrames
{
    const char* patterns[2]; // A, B; a folder's sequence once it is found
    char found[2][COMPARE_NAME_SIZE];
    bool by_number;        // one is a folder: what both have is measured
    const char* layers[2]; // NULL: the colour
    const char* list;      // of --frames; NULL: all
    bool overlap;          // measure what both have
    int* frames;           // NULL: two files, which count as frame 1
    int count;
    int* missing; // between the first and the last, of both sequences
    int missing_count;
    int* lacking[2]; // frames that the other alone has; by_number
    int lacking_count[2];
} CompareFrames;

// Two images of the same pixels, and their window.
typedef struct ComparePair
{
    size_t clipped[2]; // pixels
    char names[2][COMPARE_NAME_SIZE];
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

static void set_metrics( json_t* object, const RfErrorMetrics* metrics )
{
    json_object_set_new( object, "relmse", rf_json_number( metrics->relmse ) );
    json_object_set_new( object, "relmse_trimmed", rf_json_number( metrics->relmse_trimmed ) );
    json_object_set_new( object, "mse", rf_json_number( metrics->mse ) );
    json_object_set_new( object, "bias", rf_json_number( metrics->bias ) );
    json_object_set_new( object, "bias_low", rf_json_number( metrics->bias_low ) );
    json_object_set_new( object, "bias_high", rf_json_number( metrics->bias_high ) );
    json_object_set_new( object, "max", rf_json_number( metrics->max ) );
    json_object_set_new( object, "nan", json_integer( (json_int_t)metrics->nan ) );
    json_object_set_new( object, "inf", json_integer( (json_int_t)metrics->inf ) );
    json_object_set_new( object, "reference_nan", json_integer( (json_int_t)metrics->reference_nan ) );
    json_object_set_new( object, "reference_inf", json_integer( (json_int_t)metrics->reference_inf ) );
    json_object_set_new( object, "reference_mean", rf_json_number( metrics->reference_mean ) );
}

static void set_clipped( json_t* object, const size_t clipped[2] )
{
    json_object_set_new( object, "clipped", json_integer( (json_int_t)clipped[0] ) );
    json_object_set_new( object, "reference_clipped", json_integer( (json_int_t)clipped[1] ) );
}

static json_t* worst_json( int frame, const RfWorstPixel* worst )
{
    return worst->frame < 0 ? json_null()
                            : json_pack( "{s:i, s:i, s:i, s:o}", "frame", frame, "x", worst->x, "y", worst->y, "relative",
                                         rf_json_number( worst->relative ) );
}

// One element of "frames".
static json_t* error_frame_json( int frame, const RfErrorMetrics* metrics )
{
    json_t* row = json_object();
    json_object_set_new( row, "frame", json_integer( frame ) );
    set_metrics( row, metrics );
    json_object_set_new( row, "worst", worst_json( frame, &metrics->worst ) );
    return row;
}

// The complete JSON; takes ownership of `rows`. `worst_frame` is the number of the frame with the worst pixel.
static json_t* error_json( json_t* rows, const RfErrorMetrics* metrics, int worst_frame, const char* verdict )
{
    json_t* object = json_object();
    json_object_set_new( object, "frames", rows );
    set_metrics( object, metrics );
    json_object_set_new( object, "worst", worst_json( worst_frame, &metrics->worst ) );
    json_object_set_new( object, "verdict", rf_json_text( verdict ) );
    return object;
}

static void append( char* text, size_t size, const char* more )
{
    size_t used = strlen( text );
    snprintf( text + used, size - used, "%s", more );
}

// In percent of the reference's brightness, where it has one. Clipped pixels lack light, so their bias is not that of the renders.
static void say_bias( const RfErrorMetrics* m, const size_t clipped[2], char* text, size_t size )
{
    bool relative = m->reference_mean > 0.0;
    double scale = relative ? 100.0 / m->reference_mean : 1.0, bias = m->bias * scale;
    const char* unit = relative ? " %" : "";
    char part[256];
    if ( clipped[0] + clipped[1] > 0 )
        snprintf( part, sizeof part, "no verdict on bias, clipped pixels are compared (%zu of A, %zu of B): mean error %+.2g%s",
                  clipped[0], clipped[1], bias, unit );
    else if ( !isfinite( m->bias_low ) )
        snprintf( part, sizeof part, "mean error %+.2g%s (too few pixels to tell bias from noise)", bias, unit );
    else
    {
        double low = m->bias_low * scale, high = m->bias_high * scale;
        const char* what = low > 0.0    ? "significant bias, too bright"
                           : high < 0.0 ? "significant bias, too dark"
                                        : "no significant bias";
        snprintf( part, sizeof part, "%s: mean error %+.2g%s (95 %%: %+.2g to %+.2g%s)", what, bias, unit, low, high, unit );
    }
    append( text, size, part );
}

// Of a picture that is off everywhere the error is not noise.
static bool is_offset( const RfErrorMetrics* m ) { return m->bias * m->bias > 0.5 * m->mse; }

static void say_noise( const RfErrorMetrics* m, char* text, size_t size )
{
    char part[256], percent[RF_NOISE_TEXT_SIZE];
    rf_format_noise( m->relmse, percent );
    snprintf( part, sizeof part, "; relMSE %.3g (about %s %s per pixel", m->relmse, percent, is_offset( m ) ? "error" : "noise" );
    append( text, size, part );
    if ( m->relmse_trimmed < 0.5 * m->relmse )
    {
        rf_format_noise( m->relmse_trimmed, percent );
        snprintf( part, sizeof part, ", %s without the worst 0.1 %% of pixels", percent );
        append( text, size, part );
    }
    append( text, size, ")" );
}

void rf_error_verdict( const RfErrorMetrics* m, const size_t clipped[2], const int* worst_frame, char* text, size_t size )
{
    text[0] = '\0';
    if ( rf_has_no_error( m ) )
    {
        append( text, size, "no error can be reported: there are NaN or infinite values" );
        return;
    }
    if ( m->max == 0.0 )
    {
        append( text, size, "no difference: all pixels are identical" );
        if ( clipped[0] > 0 )
            append( text, size, ", clipped ones too" );
        return;
    }
    say_bias( m, clipped, text, size );
    say_noise( m, text, size );
    char part[128], frame[32] = "";
    if ( worst_frame != NULL )
        snprintf( frame, sizeof frame, " in frame %d", *worst_frame );
    if ( m->worst.frame >= 0 )
    {
        snprintf( part, sizeof part, "; worst pixel (%d, %d)%s, off by %.2g %%", m->worst.x, m->worst.y, frame,
                  100.0 * sqrt( m->worst.relative / 3.0 ) );
        append( text, size, part );
    }
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
        print_not_measured( frames->patterns[i], frames->lacking[i], frames->lacking_count[i] );
}

static void set_missing( json_t* json, const CompareFrames* frames )
{
    json_object_set_new( json, "missing", rf_json_frames( frames->missing, frames->missing_count ) );
    json_object_set_new( json, "missing_a", rf_json_frames( frames->lacking[0], frames->lacking_count[0] ) );
    json_object_set_new( json, "missing_b", rf_json_frames( frames->lacking[1], frames->lacking_count[1] ) );
}

static bool has_frame( const int* frames, int count, int frame )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( frames[i] == frame )
            return true;
    }
    return false;
}

// Replaces the list by the frames that --frames names, all of which must exist.
static RfResult choose_frames( CompareFrames* frames, const int* b, int b_count, RfError* error )
{
    int *wanted, count;
    RfResult result = rf_parse_frames( frames->list, frames->frames, frames->count, &wanted, &count, error );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        bool in_a = has_frame( frames->frames, frames->count, wanted[i] );
        if ( !in_a || !has_frame( b, b_count, wanted[i] ) )
            result = rf_fail( error, RF_ERROR_IO, "%s: frame %d is missing", frames->patterns[in_a ? 1 : 0], wanted[i] );
    }
    if ( result != RF_OK )
    {
        free( wanted );
        return result;
    }
    free( frames->frames );
    frames->frames = wanted;
    frames->count = count;
    return RF_OK;
}

static RfResult find_chosen( CompareFrames* frames, RfError* error )
{
    int* b = NULL;
    int b_count = 0;
    RfResult result = rf_sequence_frames( frames->patterns[0], &frames->frames, &frames->count, error );
    if ( result == RF_OK )
        result = rf_sequence_frames( frames->patterns[1], &b, &b_count, error );
    if ( result == RF_OK )
        result = choose_frames( frames, b, b_count, error );
    free( b );
    return result;
}

static RfResult find_all( CompareFrames* frames, RfError* error )
{
    RfResult result = rf_match_sequences( frames->patterns[0], frames->patterns[1], &frames->frames, &frames->count, error );
    if ( result != RF_OK )
        return result;
    return rf_missing_frames( frames->frames, frames->count, &frames->missing, &frames->missing_count, error );
}

// Sorts the frames of both into those that they share, and those that one lacks; *all gets them all.
static RfResult pair_frames( CompareFrames* frames, int* const numbers[2], const int counts[2], int** all, int* all_count,
                             RfError* error )
{
    size_t most = (size_t)counts[0] + (size_t)counts[1];
    int at[2] = { 0, 0 };
    *all_count = frames->count = 0;
    *all = malloc( most * sizeof( int ) );
    frames->frames = malloc( most * sizeof( int ) );
    for ( int i = 0; i < 2; ++i )
        frames->lacking[i] = malloc( most * sizeof( int ) );
    if ( *all == NULL || frames->frames == NULL || frames->lacking[0] == NULL || frames->lacking[1] == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %zu frames", most );
    while ( at[0] < counts[0] || at[1] < counts[1] )
    {
        bool first = at[0] < counts[0] && ( at[1] == counts[1] || numbers[0][at[0]] <= numbers[1][at[1]] );
        int number = first ? numbers[0][at[0]] : numbers[1][at[1]];
        bool both = first && at[1] < counts[1] && numbers[1][at[1]] == number;
        ( *all )[( *all_count )++] = number;
        if ( both )
            frames->frames[frames->count++] = number;
        else // A lacks what is B's alone
            frames->lacking[first][frames->lacking_count[first]++] = number;
        at[0] += first;
        at[1] += both || !first;
    }
    if ( frames->count == 0 )
        return rf_fail( error, RF_ERROR_IO, "%.400s and %.400s have no frame in common", frames->patterns[0],
                        frames->patterns[1] );
    return RF_OK;
}

static RfResult find_common( CompareFrames* frames, RfError* error )
{
    int *numbers[2] = { NULL, NULL }, counts[2], *all = NULL, all_count;
    RfResult result = rf_sequence_frames( frames->patterns[0], numbers, counts, error );
    if ( result == RF_OK )
        result = rf_sequence_frames( frames->patterns[1], numbers + 1, counts + 1, error );
    if ( result == RF_OK )
        result = pair_frames( frames, numbers, counts, &all, &all_count, error );
    if ( result == RF_OK )
        result = rf_missing_frames( all, all_count, &frames->missing, &frames->missing_count, error );
    free( numbers[0] );
    free( numbers[1] );
    free( all );
    return result;
}

static RfResult open_folders( CompareFrames* frames, RfError* error )
{
    struct stat status;
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        if ( stat( frames->patterns[i], &status ) != 0 || !S_ISDIR( status.st_mode ) )
            continue;
        result = rf_find_folder_sequence( frames->patterns[i], frames->found[i], COMPARE_NAME_SIZE, error );
        frames->patterns[i] = frames->found[i];
        frames->by_number = true;
    }
    return result;
}

// Finds the frames of two sequences, which must be the same but for those of folders, or the two files.
// free_compare_frames in any case.
static RfResult find_compare_frames( CompareFrames* frames, RfError* error )
{
    bool are_sequences;
    frames->count = 1;
    RfResult result = open_folders( frames, error );
    if ( result == RF_OK )
        result = rf_check_patterns( frames->patterns[0], frames->patterns[1], &are_sequences, error );
    if ( result != RF_OK )
        return result;
    if ( !are_sequences && frames->list != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: needs sequences, and these are two files" );
    if ( !are_sequences )
        return RF_OK;
    if ( frames->by_number && frames->list == NULL )
        return find_common( frames, error );
    return frames->list != NULL ? find_chosen( frames, error ) : find_all( frames, error );
}

static void free_compare_frames( CompareFrames* frames )
{
    free( frames->frames );
    free( frames->missing );
    for ( int i = 0; i < 2; ++i )
    {
        free( frames->lacking[i] );
        frames->lacking[i] = NULL;
    }
    frames->frames = frames->missing = NULL;
}

// The file of a frame. '#' is special only in sequences.
static RfResult compare_name( const CompareFrames* frames, const char* pattern, int frame, char name[COMPARE_NAME_SIZE],
                              RfError* error )
{
    if ( frames->frames != NULL || rf_is_sequence( pattern ) )
        return rf_sequence_name( pattern, frame, name, COMPARE_NAME_SIZE, error );
    if ( snprintf( name, COMPARE_NAME_SIZE, "%s", pattern ) >= COMPARE_NAME_SIZE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", pattern );
    return RF_OK;
}

static int at_least( int a, int b ) { return a > b ? a : b; }
static int at_most( int a, int b ) { return a < b ? a : b; }

// Crops an image in place.
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

// Aligns two images by their data windows.
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
        result = compare_name( frames, frames->patterns[i], frame, pair->names[i], error );
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
    bool has_all;       // `all` has been created, for the first frame's size
    RfWorstPixel worst; // of all frames so far, where the files have it
    size_t clipped[2];  // pixels of A and B, over all frames
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
    char name[COMPARE_NAME_SIZE];
    RfResult result =
        frames != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "no memory left for the names of %d frames", count );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        result = compare_name( &compare->in, pattern, frame_number( compare, i ), name, error );
        if ( result == RF_OK && stat( name, frames + i ) != 0 )
            frames[i].st_ino = 0;
    }
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        struct stat diff;
        result = compare_name( &compare->in, compare->diff, frame_number( compare, i ), name, error );
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
    RfResult result = check_diff_names( compare, compare->in.patterns[0], error );
    return result == RF_OK ? check_diff_names( compare, compare->in.patterns[1], error ) : result;
}

// Turns the image into the signed difference, and writes it.
static RfResult write_diff( const Compare* compare, int frame, ComparePair* pair, RfError* error )
{
    RfImage* image = pair->images;
    const RfImage* reference = pair->images + 1;
    char name[COMPARE_NAME_SIZE];
    RfResult result = compare_name( &compare->in, compare->diff, frame, name, error );
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

static RfResult measure( Compare* compare, int frame, const ComparePair* pair, RfError* error )
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
        print_error_head();
    if ( compare->table )
        print_error_row( number, &metrics );
    json_t* row = error_frame_json( frame, &metrics );
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
    bool has_worst = metrics.worst.frame >= 0 && compare->in.frames != NULL;
    int worst = metrics.worst.frame >= 0 ? frame_number( compare, metrics.worst.frame ) : 0;
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
        json_t* json = error_json( json_incref( compare->rows ), &metrics, worst, verdict );
        set_missing( json, &compare->in );
        set_clipped( json, compare->clipped );
        result = rf_write_json( compare->json, json, error );
    }
    if ( result == RF_OK )
        result = rf_flush_output( error );
    return result == RF_OK ? check_finite( compare, &metrics, error ) : result;
}

static RfResult run( Compare* compare, RfError* error )
{
    RfResult result = find_compare_frames( &compare->in, error );
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
          .meta = "[@]A-B[xSTEP][,...]",
          .default_text = "all",
          .help = "compare only these frames of the sequences" },
        { .name = "layer",
          .type = RF_OPTION_STRING,
          .value = compare.in.layers,
          .meta = "NAME",
          .default_text = "colour",
          .help = "a pass by name, a part or a channel of the files, or three channels X,Y,Z" },
        { .name = "reference-layer",
          .type = RF_OPTION_STRING,
          .value = compare.in.layers + 1,
          .meta = "NAME",
          .default_text = "that of --layer",
          .help = "layer of B, if it is named differently" },
        { .name = "overlap",
          .type = RF_OPTION_BOOL,
          .value = &compare.in.overlap,
          .help = "if the data windows differ, compare the pixels that both have" },
        { .name = "diff",
          .writes = ".exr",
          .type = RF_OPTION_STRING,
          .value = &compare.diff,
          .meta = "FILE",
          .help = "write the signed difference A - B as EXR; #### is the frame number" },
        { .name = "json",
          .writes = ".json",
          .type = RF_OPTION_STRING,
          .value = &compare.json,
          .meta = "FILE",
          .help = "write the result as JSON; - for standard output, instead of the table" },
        { .name = "quiet", .type = RF_OPTION_BOOL, .value = &compare.quiet, .help = "no progress" },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "Measures the error of A against the reference B: EXR files, sequences named with ####, or folders of one "
                   "sequence each, whose frames are matched by number.",
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
        result = rf_show_help( &table, &error );
        return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
    }
    compare.table = rf_prints_text( compare.json );
    if ( compare.in.layers[1] == NULL )
        compare.in.layers[1] = compare.in.layers[0];
    if ( result == RF_OK )
        result = run( &compare, &error );
    free_compare_frames( &compare.in );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
