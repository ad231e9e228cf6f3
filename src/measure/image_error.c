// relMSE and its intervals (Student's t over blocks of pixels); the worst pixels are kept in a heap. Frames of two sequences in pairs.
#include "measure/image_error.h"

#include "base/remedy.h"
#include "base/try.h"
#include "film/brightness.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAME 4096

RfResult rf_pair_frames( const int* const numbers[2], const int counts[2], RfFramePairs* pairs, RfError* error )
{
    size_t most = (size_t)counts[0] + (size_t)counts[1];
    int at[2] = { 0, 0 };
    *pairs = ( RfFramePairs ){ .all = malloc( ( 4 * most + 1 ) * sizeof( int ) ) };
    if ( pairs->all == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %zu frames", most );
    pairs->both = pairs->all + most;
    pairs->lacking[0] = pairs->both + most;
    pairs->lacking[1] = pairs->lacking[0] + most;
    while ( at[0] < counts[0] || at[1] < counts[1] )
    {
        bool first = at[0] < counts[0] && ( at[1] == counts[1] || numbers[0][at[0]] <= numbers[1][at[1]] );
        int number = first ? numbers[0][at[0]] : numbers[1][at[1]];
        bool both = first && at[1] < counts[1] && numbers[1][at[1]] == number;
        pairs->all[pairs->all_count++] = number;
        if ( both )
            pairs->both[pairs->count++] = number;
        else // the first lacks what is the second's alone
            pairs->lacking[first][pairs->lacking_count[first]++] = number;
        at[0] += first;
        at[1] += both || !first;
    }
    return RF_OK;
}

void rf_free_frame_pairs( RfFramePairs* pairs )
{
    free( pairs->all );
    *pairs = ( RfFramePairs ){ 0 };
}

RfResult rf_check_all_paired( const RfFramePairs* pairs, const char* const patterns[2], RfError* error )
{
    const int* counts = pairs->lacking_count;
    if ( counts[0] + counts[1] == 0 )
        return RF_OK;
    bool by = counts[0] == 0 || ( counts[1] > 0 && pairs->lacking[1][0] < pairs->lacking[0][0] ); // which lacks the first one
    return rf_advise( rf_fail( error, RF_ERROR_IO, "frame %d is in %.300s but not in %.300s", pairs->lacking[by][0],
                               patterns[!by], patterns[by] ),
                      RF_REMEDY_FRAMES, 0, error );
}

int rf_sequence_step( const char* pattern, int number )
{
    char name[MAX_NAME];
    if ( rf_sequence_name( pattern, number, name, sizeof name, NULL ) != RF_OK )
        return 1;
    double step = rf_read_exr_number( name, "reframe/step" );
    return isgreaterequal( step, 1.0 ) && step <= 1e6 ? (int)step : 1;
}

static RfResult pair_sequences( const char* const patterns[2], RfFramePairs* pairs, RfError* error )
{
    int *numbers[2] = { NULL, NULL }, counts[2] = { 0, 0 };
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
        result = rf_sequence_frames( patterns[i], numbers + i, counts + i, error );
    if ( result == RF_OK )
        result = rf_pair_frames( (const int* const*)numbers, counts, pairs, error );
    free( numbers[0] );
    free( numbers[1] );
    return result == RF_OK ? rf_check_all_paired( pairs, patterns, error ) : result;
}

static RfResult read_pair( const char* const patterns[2], int number, RfImage images[2], RfError* error )
{
    char names[2][MAX_NAME];
    RfExrWindow windows[2];
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        result = rf_sequence_name( patterns[i], number, names[i], sizeof names[i], error );
        if ( result == RF_OK )
            result = rf_read_exr_layer( names[i], NULL, images + i, windows + i, error );
    }
    if ( result == RF_OK && memcmp( windows, windows + 1, sizeof *windows ) != 0 )
        result = rf_fail( error, RF_ERROR_FORMAT, "%.400s and %.400s have different data windows", names[0], names[1] );
    return result;
}

static RfResult add_pair( const char* const patterns[2], int number, int count, RfErrorSummary* sum, RfError* error )
{
    RfImage images[2] = { { 0 }, { 0 } };
    RfResult result = read_pair( patterns, number, images, error );
    if ( result == RF_OK && sum->frames == 0 )
        result = rf_create_summary( images[0].width, images[0].height, count, sum, error );
    if ( result == RF_OK )
        result = rf_summary_add( sum, images, images + 1, error );
    rf_destroy_image( images );
    rf_destroy_image( images + 1 );
    return result;
}

RfResult rf_measure_sequences( const char* pattern, const char* reference, RfErrorMetrics* metrics, RfError* error )
{
    const char* const patterns[2] = { pattern, reference };
    RfErrorSummary sum = { 0 };
    RfFramePairs pairs = { .count = 1 };
    bool are_sequences = rf_is_sequence( pattern );
    RfResult result = RF_OK;
    if ( are_sequences != rf_is_sequence( reference ) )
        result = rf_fail( error, RF_ERROR_USAGE, "%s is a sequence and %s a single file: give two of a kind",
                          patterns[!are_sequences], patterns[are_sequences] );
    else if ( are_sequences )
        result = pair_sequences( patterns, &pairs, error );
    for ( int i = 0; i < pairs.count && result == RF_OK; ++i )
        result = add_pair( patterns, are_sequences ? pairs.both[i] : 1, pairs.count, &sum, error );
    if ( result == RF_OK )
        *metrics = rf_summary_metrics( &sum );
    rf_destroy_summary( &sum );
    rf_free_frame_pairs( &pairs );
    return result;
}

#define BLOCK_SIDE 16 // pixels; blocks at the right and lower border may be cropped
#define MIN_BLOCKS 16 // larger blocks need at least this many
#define MIN_STRIPS 8

double rf_student_quantile( int freedom )
{
    static const double few[] = { 12.7062, 4.3027, 3.1824 };
    if ( freedom <= 3 )
        return few[freedom - 1];
    // Abramowitz, Stegun 26.7.5
    double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z, n = freedom;
    return z + ( z3 + z ) / ( 4.0 * n ) + ( 5.0 * z5 + 16.0 * z3 + 3.0 * z ) / ( 96.0 * n * n ) +
           ( 3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z ) / ( 384.0 * n * n * n );
}

static int ceil_divide( int a, int b ) { return ( a + b - 1 ) / b; }

static int blocks_of( int side ) { return ceil_divide( side, BLOCK_SIDE ); }

// The smallest blocks of an image.
typedef struct Blocks
{
    const double* sums; // row by row
    int width, height;  // of the image
    double values;      // of a pixel: channels times frames
    double mean;
} Blocks;

static double cropped_side( int index, int side, int size )
{
    int left = size - index * side;
    return left < side ? left : side;
}

// The half-width of the interval from blocks of `across` × `down` of the smallest. With w the number of pixels of a block,
// the sampling variance of the weighted mean is Σ w² (block mean − mean)² / (Σ w)². NaN if there are fewer than `fewest` blocks.
static double margin_of( const Blocks* b, int across, int down, int fewest )
{
    int smallest = blocks_of( b->width ), rows = blocks_of( b->height ), columns = ceil_divide( smallest, across );
    int count = columns * ceil_divide( rows, down );
    double spread = 0.0;
    if ( count < fewest )
        return NAN;
    for ( int i = 0; i < count; ++i )
    {
        int column = i % columns, row = i / columns;
        double weight = cropped_side( column, across * BLOCK_SIDE, b->width ) * cropped_side( row, down * BLOCK_SIDE, b->height );
        double sum = 0.0;
        for ( int y = row * down; y < ( row + 1 ) * down && y < rows; ++y )
        {
            for ( int x = column * across; x < ( column + 1 ) * across && x < smallest; ++x )
                sum += b->sums[y * smallest + x];
        }
        double delta = sum / b->values - weight * b->mean;
        spread += delta * delta;
    }
    return rf_student_quantile( count - 1 ) * sqrt( count / ( count - 1.0 ) * spread ) / ( (double)b->width * b->height );
}

// Half the width of the interval of the mean; NaN for a single block.
static double mean_margin( const Blocks* b )
{
    int columns = blocks_of( b->width ), rows = blocks_of( b->height );
    double margin = margin_of( b, 1, 1, 2 ); // fmax ignores NaN
    for ( int side = 2; side < columns || side < rows; side *= 2 )
        margin = fmax( margin, margin_of( b, side, side, MIN_BLOCKS ) );
    return fmax( fmax( margin, margin_of( b, columns, 1, MIN_STRIPS ) ), margin_of( b, 1, rows, MIN_STRIPS ) );
}

RfInterval rf_log_interval( double value, double margin )
{
    return ( RfInterval ){ value, value * exp( -margin ), value * exp( margin ) };
}

double rf_influence_margin( const double* influence, int count, double variance )
{
    double square = 0.0, fourth = 0.0;
    if ( count < 2 )
        return NAN;
    for ( int i = 0; i < count; ++i )
    {
        double i2 = influence[i] * influence[i];
        square += i2;
        fourth += i2 * i2;
    }
    // the mean of the fourth power is three times the squared mean of the second for normal influences
    double freedom = fourth > 0.0 ? 3.0 * square * square / fourth - 1.0 : count - 1.0;
    freedom = fmin( fmax( freedom, 1.0 ), count - 1.0 );
    double spread = rf_student_quantile( (int)freedom ) * sqrt( square * count / ( count - 1.0 ) );
    return sqrt( spread * spread + 1.96 * 1.96 * variance );
}

#define TRIMMED_PER_THOUSAND 1

RfResult rf_create_summary( int width, int height, int frames, RfErrorSummary* summary, RfError* error )
{
    *summary = ( RfErrorSummary ){ .width = width, .height = height, .worst_pixel = { -1, -1, -1, 0.0 } };
    if ( width < 1 || height < 1 || frames < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "%d frames of %dx%d pixels cannot be measured", frames, width, height );
    size_t pixels = (size_t)width * (size_t)height * (size_t)frames;
    summary->worst_room = pixels / 1000 * TRIMMED_PER_THOUSAND;
    summary->worst = calloc( summary->worst_room + 1, sizeof( double ) );
    summary->block_sums = calloc( (size_t)blocks_of( width ) * (size_t)blocks_of( height ), sizeof( double ) );
    summary->below = malloc( (size_t)width * (size_t)height * sizeof( double ) );
    if ( summary->worst != NULL && summary->block_sums != NULL && summary->below != NULL )
        return RF_OK;
    rf_destroy_summary( summary );
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory measuring %d frames of %dx%d pixels", frames, width, height );
}

void rf_destroy_summary( RfErrorSummary* summary )
{
    free( summary->worst );
    free( summary->block_sums );
    free( summary->below );
    *summary = ( RfErrorSummary ){ 0 };
}

static void swap( double* a, double* b )
{
    double c = *a;
    *a = *b;
    *b = c;
}

static void sift_down( double* heap, size_t count )
{
    size_t i = 0;
    for ( ;; )
    {
        size_t least = i;
        for ( size_t child = 2 * i + 1; child <= 2 * i + 2 && child < count; ++child )
            least = heap[child] < heap[least] ? child : least;
        if ( least == i )
            return;
        swap( heap + i, heap + least );
        i = least;
    }
}

// Sums the errors that are not among the worst. Subtracting the worst from the total at the
// end would lose the rest to cancellation next to a single firefly.
static void add_relative( RfErrorSummary* summary, double value, int x, int y )
{
    summary->relative_sum += value;
    if ( value > summary->worst_pixel.relative )
        summary->worst_pixel = ( RfWorstPixel ){ summary->frames, x, y, value };
    if ( summary->worst_room > 0 && value > summary->worst[0] )
    {
        swap( &value, summary->worst );
        sift_down( summary->worst, summary->worst_room );
    }
    summary->kept_sum += value;
}

// Adds a pixel and returns the signed difference, summed over its channels.
static double add_pixel( RfErrorSummary* summary, const float* image, const float* reference, double below, int x, int y )
{
    bool is_nan = false, is_inf = false, reference_nan = false, reference_inf = false;
    double squared = 0.0, sum = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        is_nan |= isnan( image[c] ) != 0;
        is_inf |= isinf( image[c] ) != 0;
        reference_nan |= isnan( reference[c] ) != 0;
        reference_inf |= isinf( reference[c] ) != 0;
        double difference = (double)image[c] - (double)reference[c];
        squared += difference * difference;
        sum += difference;
        summary->max = fmax( summary->max, fabs( difference ) );
    }
    summary->nan += is_nan;
    summary->inf += is_inf;
    summary->reference_nan += reference_nan;
    summary->reference_inf += reference_inf;
    if ( is_nan || is_inf || reference_nan || reference_inf )
        return 0.0;
    summary->squared_sum += squared;
    summary->signed_sum += sum;
    summary->reference_sum += rf_mean_of_channels( reference );
    add_relative( summary, squared / below, x, y );
    return sum;
}

static RfResult check_frame( const RfErrorSummary* summary, const RfImage* image, const RfImage* reference, RfError* error )
{
    if ( image->width != reference->width || image->height != reference->height )
        return rf_fail( error, RF_ERROR_FORMAT, "the image has %dx%d pixels, the reference %dx%d", image->width, image->height,
                        reference->width, reference->height );
    if ( image->width != summary->width || image->height != summary->height )
        return rf_fail( error, RF_ERROR_FORMAT, "the image has %dx%d pixels, the frames before it %dx%d", image->width,
                        image->height, summary->width, summary->height );
    return RF_OK;
}

RfResult rf_summary_add( RfErrorSummary* summary, const RfImage* image, const RfImage* reference, RfError* error )
{
    RF_TRY( check_frame( summary, image, reference, error ) );
    int width = summary->width, columns = blocks_of( width );
    rf_relmse_denominators( reference->rgb, width, summary->height, summary->below );
    for ( int y = 0; y < summary->height; ++y )
    {
        double* sums = summary->block_sums + y / BLOCK_SIDE * columns;
        for ( int x = 0; x < width; ++x )
        {
            size_t i = (size_t)y * (size_t)width + (size_t)x;
            sums[x / BLOCK_SIDE] += add_pixel( summary, image->rgb + 3 * i, reference->rgb + 3 * i, summary->below[i], x, y );
        }
    }
    summary->pixels += (size_t)width * (size_t)summary->height;
    summary->frames += 1;
    return RF_OK;
}

RfErrorMetrics rf_summary_metrics( const RfErrorSummary* summary )
{
    RfErrorMetrics metrics = { .nan = summary->nan,
                               .inf = summary->inf,
                               .reference_nan = summary->reference_nan,
                               .reference_inf = summary->reference_inf,
                               .worst = summary->worst_pixel };
    if ( summary->pixels == 0 || rf_has_no_error( &metrics ) )
    {
        metrics.relmse = metrics.relmse_trimmed = metrics.mse = metrics.max = NAN;
        metrics.bias = metrics.bias_low = metrics.bias_high = metrics.reference_mean = NAN;
        return metrics;
    }
    double pixels = (double)summary->pixels;
    metrics.relmse = summary->relative_sum / pixels;
    metrics.relmse_trimmed = summary->kept_sum / ( pixels - fmin( (double)summary->worst_room, pixels ) );
    metrics.mse = summary->squared_sum / ( 3.0 * pixels );
    metrics.max = summary->max;
    metrics.bias = summary->signed_sum / ( 3.0 * pixels );
    metrics.reference_mean = summary->reference_sum / pixels;
    double margin =
        mean_margin( &( Blocks ){ summary->block_sums, summary->width, summary->height, 3.0 * summary->frames, metrics.bias } );
    metrics.bias_low = metrics.bias - margin;
    metrics.bias_high = metrics.bias + margin;
    return metrics;
}

RfResult rf_measure_error( const RfImage* image, const RfImage* reference, RfErrorMetrics* out, RfError* error )
{
    *out = ( RfErrorMetrics ){ 0 };
    RfErrorSummary summary;
    RfResult result = rf_create_summary( image->width, image->height, 1, &summary, error );
    if ( result == RF_OK )
        result = rf_summary_add( &summary, image, reference, error );
    if ( result == RF_OK )
        *out = rf_summary_metrics( &summary );
    rf_destroy_summary( &summary );
    return result;
}

RfResult rf_measure_frame( RfErrorSummary* summary, int frames, const RfImage* image, const RfImage* reference,
                           RfErrorMetrics* metrics, RfError* error )
{
    RfResult result = rf_measure_error( image, reference, metrics, error );
    if ( result == RF_OK && summary->frames == 0 )
        result = rf_create_summary( image->width, image->height, frames, summary, error );
    return result == RF_OK ? rf_summary_add( summary, image, reference, error ) : result;
}
