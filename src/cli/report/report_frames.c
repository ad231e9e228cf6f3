// Finds the sequences of a report, and adds their frames to the page: pictures, passes, values for the probe, error and flicker.
#include "cli/report/report_frames.h"

#include "base/try.h"
#include "cli/messages.h"
#include "cli/render/progress.h"
#include "cli/render/render_json.h"
#include "image/exr.h"
#include "image/sequence.h"
#include "measure/flicker_sequence.h"
#include "output/frame_file.h"

#include <libgen.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LEAST_WIDTH 160 // of pictures of passes; passes are left out where they would become narrower, unless frames are
#define LEAST_BITS 2.5  // per pixel; pictures are made smaller rather than coarser
#define BLOCK_BYTES 64  // of the markup about a block

#define MOST_NAMES 65535 // of a Cryptomatte, for 16 bits
#define READ_CHANNELS 24 // at once: a file is decompressed as a whole, but all passes of large frames take much memory

static RfResult find_frames( const char* place, RfPageSequence* sequence, RfError* error )
{
    RfSequenceInput* input = &sequence->input;
    RfResult result = rf_find_sequence_input( place, NULL, input, error );
    if ( result != RF_OK || input->is_sequence )
        return result;
    input->frames = malloc( sizeof( int ) );
    if ( input->frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", place );
    input->frames[0] = input->count = 1;
    return RF_OK;
}

RfResult rf_open_page_sequence( const char* place, const char* layer, RfPageSequence* sequence, RfError* error )
{
    char copy[RF_FILE_NAME_SIZE]; // which basename and dirname may change
    *sequence = ( RfPageSequence ){ .layer = layer };
    snprintf( copy, sizeof copy, "%s", place );
    snprintf( sequence->name, sizeof sequence->name, "%.255s", basename( copy ) );
    RfResult result = find_frames( place, sequence, error );
    if ( result == RF_OK )
        result = rf_sequence_input_name( &sequence->input, sequence->input.frames[0], sequence->first, error );
    if ( result == RF_OK )
        sequence->layer = rf_layer_of_file( sequence->first, layer, sequence->layer_text );
    if ( result == RF_OK )
        result = rf_read_exr_header( sequence->first, sequence->layer, &sequence->header, error );
    snprintf( copy, sizeof copy, "%s", sequence->input.pattern );
    if ( result == RF_OK )
        result = rf_find_render_json( dirname( copy ), &sequence->render, error );
    return result;
}

static void close_sequence( RfPageSequence* sequence )
{
    rf_free_sequence_input( &sequence->input );
    rf_destroy_exr_header( &sequence->header );
    json_decref( sequence->render );
    *sequence = ( RfPageSequence ){ 0 };
}

bool rf_has_page_frame( const RfPageSequence* sequence, int frame )
{
    const RfSequenceInput* input = &sequence->input;
    return bsearch( &frame, input->frames, (size_t)input->count, sizeof( int ), rf_compare_frames ) != NULL;
}

static int64_t at_least( int64_t a, int64_t b ) { return a > b ? a : b; }
static int64_t at_most( int64_t a, int64_t b ) { return a < b ? a : b; }

RfExrWindow rf_page_window( const RfExrHeader* header )
{
    int64_t left = at_least( header->x, header->display_x ), top = at_least( header->y, header->display_y );
    int64_t right = at_most( (int64_t)header->x + header->width, (int64_t)header->display_x + header->display_width );
    int64_t bottom = at_most( (int64_t)header->y + header->height, (int64_t)header->display_y + header->display_height );
    if ( left >= right || top >= bottom )
        return ( RfExrWindow ){ 0, 0, header->width, header->height };
    return ( RfExrWindow ){ (int)( left - header->x ), (int)( top - header->y ), (int)( right - left ), (int)( bottom - top ) };
}

static bool is_at_picture( const RfExrWindow* w, const RfExrHeader* header )
{
    return w->x == header->x && w->y == header->y && w->width == header->width && w->height == header->height;
}

static int batch_of( const RfPageLayers* layers, int first )
{
    int count = 1, channels = layers->passes.passes[first].channel_count;
    while ( first + count < layers->count && channels + layers->passes.passes[first + count].channel_count <= READ_CHANNELS )
        channels += layers->passes.passes[first + count++].channel_count;
    return count;
}

// As many as find room at no less than LEAST_WIDTH pixels.
static void choose_factor( const RfExrHeader* header, int pictures, double share, RfPageLayers* layers )
{
    RfExrWindow window = rf_page_window( header );
    double pixels = (double)window.width * window.height, bits = 0.0;
    int most = window.width / LEAST_WIDTH;
    most = most > 1 ? most : 1;
    for ( ;; layers->count -= 1 )
    {
        bits = share / ( (double)layers->count * pictures ) * 0.75 * 8.0; // of a picture
        layers->factor = (int)ceil( sqrt( pixels * LEAST_BITS / bits ) );
        layers->factor = layers->factor < 1 ? 1 : layers->factor;
        if ( layers->factor <= most || layers->count == 1 )
            break;
    }
    layers->width = ( window.width + layers->factor - 1 ) / layers->factor;
    layers->height = ( window.height + layers->factor - 1 ) / layers->factor;
    layers->bits = fmin( bits / ( (double)layers->width * layers->height ), RF_PICTURE_MAX_BITS );
}

// Those that lie where the picture does, before the others.
static void sort_out( const RfExrHeader* header, RfPageLayers* layers )
{
    RfFilePasses* list = &layers->passes;
    for ( int i = 0; i < list->count; ++i )
    {
        RfFilePass pass = list->passes[i];
        if ( !is_at_picture( &pass.window, header ) )
            continue;
        memmove( list->passes + layers->count + 1, list->passes + layers->count, (size_t)( i - layers->count ) * sizeof pass );
        list->passes[layers->count++] = pass;
    }
}

// Copies what the page shows of `stride` interleaved values of a file, row by row; in place as well.
static void crop( const RfExrHeader* header, const float* from, int stride, float* to )
{
    RfExrWindow window = rf_page_window( header );
    size_t row = (size_t)window.width * (size_t)stride;
    for ( int y = 0; y < window.height; ++y )
    {
        size_t first = (size_t)( window.y + y ) * (size_t)header->width + (size_t)window.x;
        memmove( to + (size_t)y * row, from + first * (size_t)stride, row * sizeof( float ) );
    }
}

// A sequence at work.
typedef struct Work
{
    RfPage* page;
    RfPageTrack* track;
    int number; // of the frame
    char path[RF_FILE_NAME_SIZE];
    RfFlickerLayers layers;
    RfFlickerFrame ring[2]; // this frame and the one before, at their places modulo 2
    bool has_frame[2];      // and their signals are what flicker wants
    RfErrorSummary errors;
} Work;

// Takes a pass, an index of those shown: `stride` floats for each pixel that the page shows.
typedef RfResult VisitPass( Work* to, int pass, const float* values, int stride, RfError* error );

// Reads the passes of a frame, several at once. *whole: false where its file lacks one of them.
static RfResult visit_passes( Work* to, const char* path, VisitPass* visit, bool* whole, RfError* error )
{
    const RfExrHeader* header = &to->track->sequence.header;
    const RfPageLayers* layers = &to->track->layers;
    RfResult result = RF_OK;
    *whole = layers->count > 0;
    for ( int first = 0, count; first < layers->count && *whole && result == RF_OK; first += count )
    {
        const RfFilePass* passes = layers->passes.passes + first;
        RfExrWindow window;
        float* values = NULL;
        int stride, at = 0;
        count = batch_of( layers, first );
        result = rf_read_passes( path, passes, count, &window, &values, &stride, error );
        *whole = result == RF_OK && is_at_picture( &window, header );
        if ( *whole )
            crop( header, values, stride, values );
        else if ( result != RF_ERROR_MEMORY )
            result = RF_OK;
        for ( int i = 0; i < count && *whole && result == RF_OK; at += passes[i++].channel_count )
            result = visit( to, first + i, values + at, stride, error );
        free( values );
    }
    return result;
}

static RfResult take_range( Work* to, int pass, const float* values, int stride, RfError* error )
{
    RfExrWindow window = rf_page_window( &to->track->sequence.header );
    RfPageLayers* layers = &to->track->layers;
    (void)error;
    layers->ranges[pass] =
        rf_pass_range( layers->passes.passes + pass, values, (size_t)stride, (size_t)window.width * (size_t)window.height );
    return RF_OK;
}

// Names of the ids of Cryptomattes, those of `typical` for all frames.
static RfResult find_names( const char* typical, RfPageLayers* layers, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < layers->count && result == RF_OK; ++i )
    {
        if ( layers->passes.passes[i].look == RF_LOOK_MATTES )
            result = rf_read_matte_names( typical, layers->passes.passes + i, layers->names + i, error );
        if ( layers->names[i].count >= MOST_NAMES )
            rf_free_matte_names( layers->names + i );
    }
    return result;
}

static void free_page_layers( RfPageLayers* layers )
{
    for ( int i = 0; i < layers->count && layers->names != NULL; ++i )
        rf_free_matte_names( layers->names + i );
    free( layers->names );
    rf_free_passes( &layers->passes );
    free( layers->ranges );
    *layers = ( RfPageLayers ){ 0 };
}

// Finds the passes of the first file; the ranges of their values are those of the middle frame, unless that lacks them: the first
// has nothing that moves from a frame before.
static RfResult find_page_layers( Work* work, RfError* error )
{
    RfPageTrack* track = work->track;
    const RfPageSequence* sequence = &track->sequence;
    RfPageLayers* layers = &track->layers;
    int pictures = 0, typical = 0;
    for ( int i = 0; i < track->run->count; ++i )
    {
        int number = track->run->numbers[i];
        if ( !rf_has_page_frame( sequence, number ) )
            continue;
        typical = pictures == 0 || i <= track->run->count / 2 ? number : typical;
        ++pictures;
    }
    if ( pictures == 0 || !( (double)track->run->passes / track->run->track_count > 0.0 ) )
        return RF_OK;
    RF_TRY( rf_sequence_input_name( &sequence->input, typical, work->path, error ) );
    RF_TRY( rf_list_passes( &sequence->header, &layers->passes, error ) );
    sort_out( &sequence->header, layers );
    if ( layers->count > 0 )
        choose_factor( &sequence->header, pictures, (double)track->run->passes / track->run->track_count, layers );
    layers->ranges = malloc( (size_t)( layers->count + 1 ) * sizeof *layers->ranges );
    layers->names = calloc( (size_t)layers->count + 1, sizeof *layers->names );
    if ( layers->ranges == NULL || layers->names == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its passes", sequence->input.pattern );
    bool whole;
    RfResult result = visit_passes( work, work->path, take_range, &whole, error );
    if ( result == RF_OK && !whole )
        result = visit_passes( work, sequence->first, take_range, &whole, error );
    if ( !whole )
        layers->count = 0;
    return result == RF_OK ? find_names( work->path, layers, error ) : result;
}

// Adds the image as a picture, smaller by `factor`, in a block.
static RfResult add_picture( Work* to, const char* id, const RfImage* image, int factor, double bits, RfError* error )
{
    RfImage small = { 0 };
    unsigned char* bytes = NULL;
    size_t size = 0;
    RfResult result = factor > 1 ? rf_shrink_image( image, factor, &small, error ) : RF_OK;
    if ( result == RF_OK )
        result = rf_encode_picture( factor > 1 ? &small : image, bits, to->path, &bytes, &size, error );
    if ( result == RF_OK )
        result = rf_add_page_block( to->page, id, bytes, size, error );
    free( bytes );
    rf_destroy_image( &small );
    return result;
}

// The name that covers most of a pixel comes first; 0: none.
static int name_at( const RfMatteNames* names, const float* value )
{
    uint32_t id;
    memcpy( &id, value, sizeof id );
    return rf_find_matte_name( names, id ) + 1;
}

// Adds the names at the centres of the pixels of a picture, as runs. Where these are short, as in grass, they are left out: they
// would take more than the picture.
static RfResult add_names( Work* to, int pass, const float* values, int stride, RfError* error )
{
    const RfPageLayers* layers = &to->track->layers;
    const RfMatteNames* names = layers->names + pass;
    RfExrWindow window = rf_page_window( &to->track->sequence.header );
    int pixels = layers->width * layers->height;
    size_t most = (size_t)pixels / 2, used = 0; // bytes
    unsigned char* bytes = malloc( most + 4 );
    if ( bytes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the names of a Cryptomatte", to->path );
    for ( int i = 0, name = -1, run = 0; i <= pixels && used <= most; ++i )
    {
        int x = i % layers->width * layers->factor + layers->factor / 2,
            y = i / layers->width * layers->factor + layers->factor / 2;
        x = x < window.width ? x : window.width - 1;
        y = y < window.height ? y : window.height - 1;
        int here = i < pixels ? name_at( names, values + (size_t)stride * ( (size_t)y * (size_t)window.width + (size_t)x ) ) : -1;
        if ( run > 0 && ( here != name || run == 65535 ) )
        {
            for ( int b = 0; b < 4; ++b )
                bytes[used++] = (unsigned char)( ( b < 2 ? name : run ) >> 8 * ( b & 1 ) & 255 );
            run = 0;
        }
        name = here;
        run += 1;
    }
    char id[48];
    snprintf( id, sizeof id, "n%d-%d-%d", to->track->index, pass, to->number );
    RfResult result = used <= most ? rf_add_page_block( to->page, id, bytes, used, error ) : RF_OK;
    free( bytes );
    return result;
}

static RfResult add_pass( Work* to, int pass, const float* values, int stride, RfError* error )
{
    const RfPageLayers* layers = &to->track->layers;
    RfExrWindow window = rf_page_window( &to->track->sequence.header );
    RfImage image;
    char id[48];
    RF_TRY( rf_create_image( window.width, window.height, &image, error ) );
    snprintf( id, sizeof id, "l%d-%d-%d", to->track->index, pass, to->number );
    rf_draw_pass( layers->passes.passes + pass, layers->ranges[pass], values, (size_t)stride,
                  (size_t)window.width * (size_t)window.height, image.rgb );
    RfResult result = add_picture( to, id, &image, layers->factor, layers->bits, error );
    rf_destroy_image( &image );
    return result == RF_OK && layers->names[pass].count > 0 ? add_names( to, pass, values, stride, error ) : result;
}

json_t* rf_page_layers_json( const RfPageLayers* layers )
{
    static const char* const looks[] = {
        "light", "deviation", "normal", "depth", "motion", "share", "signed", "index", "mattes"
    };
    json_t* list = json_array();
    for ( int i = 0; i < layers->count; ++i )
    {
        const RfFilePass* pass = layers->passes.passes + i;
        json_t* names = json_array();
        for ( int k = 0; k < layers->names[i].count; ++k )
            json_array_append_new( names, rf_json_text( layers->names[i].names[k].name ) );
        json_array_append_new( list, json_pack( "{s:o, s:s, s:b, s:o, s:o, s:i, s:i, s:o}", "name", rf_json_text( pass->name ),
                                                "look", looks[pass->look], "group", pass->is_group, "low",
                                                rf_json_number( layers->ranges[i].low ), "high",
                                                rf_json_number( layers->ranges[i].high ), "width", layers->width, "height",
                                                layers->height, "names", names ) );
    }
    return list;
}

bool rf_has_page_mix( const RfPageLayers* layers )
{
    int groups = 0, shown = 0;
    for ( int i = 0; i < layers->passes.count; ++i )
    {
        groups += layers->passes.passes[i].is_group;
        shown += layers->passes.passes[i].is_group && i < layers->count;
    }
    return groups > 1 && shown == groups;
}

void rf_page_block_id( const RfPageTrack* track, int number, char id[32] ) { snprintf( id, 32, "s%d-%d", track->index, number ); }

static RfResult add_values( Work* to, const char* id, const RfImage* image, RfError* error )
{
    unsigned char* bytes;
    size_t size;
    RfResult result = rf_encode_values( image, to->track->value_factor, to->path, &bytes, &size, error );
    if ( result == RF_OK )
        result = rf_add_page_block( to->page, id, bytes, size, error );
    free( bytes );
    return result;
}

// Adds picture, scene values and passes of a frame. *whole: false where its file lacks passes.
static RfResult add_blocks( Work* to, const RfImage* image, bool* whole, RfError* error )
{
    RfPageTrack* track = to->track;
    RfExrWindow window = rf_page_window( &track->sequence.header );
    int most = track->run->width, factor = most > 0 ? ( window.width + most - 1 ) / most : 1;
    uint64_t before = to->page->raw, ends[3];
    char id[32];
    RfImage shown;
    RF_TRY( rf_create_image( window.width, window.height, &shown, error ) );
    crop( &track->sequence.header, image->rgb, 3, shown.rgb );
    rf_page_block_id( track, to->number, id );
    RfResult result = add_picture( to, id, &shown, factor, RF_PICTURE_MAX_BITS, error );
    track->picture_bytes += to->page->raw - before;
    ends[0] = to->page->bytes;
    id[0] = 'v';
    if ( result == RF_OK && track->value_factor > 0 )
        result = add_values( to, id, &shown, error );
    ends[1] = to->page->bytes;
    rf_destroy_image( &shown );
    if ( result == RF_OK )
        result = visit_passes( to, to->path, add_pass, whole, error );
    ends[2] = to->page->bytes;
    track->value_bytes += ends[1] - ends[0];
    track->layer_bytes += ends[2] - ends[1];
    track->picture_width = ( window.width + factor - 1 ) / factor;
    track->picture_height = ( window.height + factor - 1 ) / factor;
    return result;
}

// Without a reference flicker follows the motion and rests on the variance of the colour, where the files have them; what `flicker`
// would refuse is left out.
static void find_layers( Work* work )
{
    RfPageTrack* track = work->track;
    const RfPageSequence* sequence = &track->sequence;
    RfFlickerLayers* layers = &work->layers;
    bool alone = track->reference == NULL && !sequence->is_reference;
    if ( !alone || rf_find_flicker_layers( sequence->first, &sequence->header, NULL, NULL, layers, NULL ) != RF_OK ||
         layers->motion[0] == NULL )
        *layers = ( RfFlickerLayers ){ 0 };
    if ( alone && sequence->layer == NULL )
        rf_find_variance_layers( sequence->first, &sequence->header, layers, NULL );
    layers->colour = sequence->layer;
    layers->may_lack = true;
    track->compensated = layers->motion[0] != NULL;
}

static size_t count_bad( const RfImage* image )
{
    size_t bad = 0, pixels = (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < pixels; ++i )
        bad += !isfinite( image->rgb[3 * i] ) || !isfinite( image->rgb[3 * i + 1] ) || !isfinite( image->rgb[3 * i + 2] );
    return bad;
}

static RfResult measure_error( Work* work, RfPageFrame* figures, RfFlickerFrame* frame, RfImage* reference, RfError* error )
{
    RfErrorMetrics metrics;
    RF_TRY( rf_measure_frame( &work->errors, work->track->run->count, &frame->signal, reference, &metrics, error ) );
    figures->relmse = metrics.relmse;
    size_t count = 3 * (size_t)reference->width * (size_t)reference->height;
    for ( size_t i = 0; i < count; ++i )
        frame->signal.rgb[i] -= reference->rgb[i];
    frame->is_finite = !rf_has_no_error( &metrics );
    return rf_take_brightness( frame, reference, error );
}

// Takes what `render` recorded of the frame, in its JSON or in the file. Times are in no
// image file, so that equal renders give equal files.
static void take_said( const RfPageSequence* sequence, int number, const char* path, RfPageFrame* figures )
{
    const struct
    {
        const char *key, *attribute;
        double* value;
    } numbers[] = { { "relmse_estimate", "reframe/relmse-estimate", &figures->relmse },
                    { "seconds", NULL, &figures->seconds },
                    { "native_spp", "reframe/native-spp", &figures->samples },
                    { "effective_spp", "reframe/effective-spp", &figures->effective } };
    size_t i;
    char text[8];
    const json_t *row, *said = NULL;
    json_array_foreach( json_object_get( sequence->render, "frames" ), i, row )
    {
        if ( rf_json_number_of( row, "frame" ) == number )
            said = row;
    }
    for ( i = 0; i < sizeof numbers / sizeof numbers[0]; ++i )
    {
        *numbers[i].value = rf_json_number_of( said, numbers[i].key );
        if ( isnan( *numbers[i].value ) && numbers[i].attribute != NULL )
            *numbers[i].value = rf_read_exr_number( path, numbers[i].attribute );
    }
    if ( rf_is_denoised( path ) ) // whose own error is another
    {
        figures->relmse = rf_read_exr_number( path, "reframe/denoised-relmse" );
        return;
    }
    figures->at_least =
        json_is_true( json_object_get( said, "relmse_is_lower_bound" ) ) ||
        ( rf_read_exr_string( path, "reframe/relmse-is-lower-bound", text, sizeof text, NULL ) == RF_OK && text[0] == 'y' );
}

// The pair of this frame and the one before, if both are there and have the layers.
static RfResult measure_flicker( Work* work, int i, RfError* error )
{
    RfPageTrack* track = work->track;
    RfFlickerSums sums;
    const int* numbers = track->run->numbers;
    const RfFlickerFrame *now = work->ring + i % 2, *before = work->ring + ( i + 1 ) % 2;
    bool pair = i > 0 && work->has_frame[0] && work->has_frame[1] && numbers[i] == numbers[i - 1] + 1;
    if ( !pair || rf_is_cut( now, before ) || !rf_has_flicker_layers( &work->layers, now, before ) )
        return RF_OK;
    RF_TRY( rf_measure_flicker( now, before, track->compensated, track->reference != NULL, &sums, error ) );
    RfFlickerMetrics metrics = rf_flicker_metrics( &sums );
    track->frames[i].phi = metrics.phi;
    track->frames[i].f1 = metrics.f1_relative;
    rf_add_flicker( &track->flicker, &sums );
    return RF_OK;
}

static RfResult read_reference( const RfPageTrack* track, int number, RfImage* image, RfError* error )
{
    char path[RF_FILE_NAME_SIZE];
    RF_TRY( rf_sequence_input_name( &track->reference->sequence.input, number, path, error ) );
    return rf_read_aligned( path, track->reference->sequence.layer, &track->sequence.header, track->sequence.first, image,
                            error );
}

static RfResult add_frame( Work* work, int i, RfError* error )
{
    RfPageTrack* track = work->track;
    int number = track->run->numbers[i];
    RfPageFrame* figures = track->frames + i;
    RfFlickerFrame* frame = work->ring + i % 2;
    char* path = work->path;
    work->number = number;
    rf_destroy_flicker_frame( frame );
    work->has_frame[i % 2] = false;
    if ( !rf_has_page_frame( &track->sequence, number ) )
        return RF_OK;
    RF_TRY( rf_sequence_input_name( &track->sequence.input, number, path, error ) );
    RF_TRY( rf_read_flicker_frame( path, &work->layers, &track->sequence.header, track->sequence.first, frame, error ) );
    RF_TRY( add_blocks( work, &frame->signal, &figures->has_layers, error ) );
    figures->shown = true;
    figures->bad = count_bad( &frame->signal );
    frame->number = number;
    frame->is_finite = figures->bad == 0;
    take_said( &track->sequence, number, path, figures );
    if ( track->reference != NULL || track->sequence.is_reference ) // an estimate would not belong there
    {
        figures->relmse = NAN;
        figures->at_least = false;
    }
    RfImage reference = { 0 };
    RfResult result = RF_OK;
    if ( track->reference != NULL && rf_has_page_frame( &track->reference->sequence, number ) )
        result = read_reference( track, number, &reference, error );
    bool has_reference = reference.rgb != NULL;
    if ( result == RF_OK && has_reference )
        result = measure_error( work, figures, frame, &reference, error );
    else if ( result == RF_OK )
        result = rf_take_brightness( frame, &frame->signal, error );
    rf_destroy_image( &reference );
    work->has_frame[i % 2] = !track->sequence.is_reference && ( has_reference || track->reference == NULL );
    return result == RF_OK ? measure_flicker( work, i, error ) : result;
}

static void sum_up( Work* work )
{
    RfPageTrack* track = work->track;
    double sum = 0.0;
    int count = 0;
    for ( int i = 0; i < track->run->count; ++i )
    {
        if ( isnan( track->frames[i].relmse ) )
            continue;
        sum += track->frames[i].relmse;
        ++count;
    }
    track->estimate = count > 0 && track->reference == NULL ? sum / count : NAN;
    track->has_error = work->errors.frames > 0;
    if ( track->has_error )
        track->error = rf_summary_metrics( &work->errors );
}

// False: the work is to stop.
static bool go_on( RfPageRun* run )
{
    rf_show_frame_count( run->quiet, ++run->done, run->all );
    return !rf_is_interrupted();
}

// Those of the page's frames, and of the holes between them, that the sequence lacks, ascending.
static void list_missing( RfPageTrack* track )
{
    const RfPageRun* all = track->run;
    for ( int i = 0, k = 0; i < all->count || k < all->hole_count; )
    {
        bool is_hole = i == all->count || ( k < all->hole_count && all->holes[k] < all->numbers[i] );
        int number = is_hole ? all->holes[k++] : all->numbers[i++];
        if ( !rf_has_page_frame( &track->sequence, number ) )
            track->missing[track->missing_count++] = number;
    }
}

RfResult rf_add_page_track( RfPage* page, RfPageTrack* track, RfError* error )
{
    RfPageRun* all = track->run;
    RfExrWindow window = rf_page_window( &track->sequence.header );
    Work work = { .page = page, .track = track };
    track->frames = malloc( (size_t)all->count * sizeof( RfPageFrame ) );
    track->missing = malloc( (size_t)( all->count + all->hole_count ) * sizeof( int ) );
    if ( track->frames == NULL || track->missing == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for %d frames", track->sequence.input.pattern, all->count );
    for ( int i = 0; i < all->count; ++i )
        track->frames[i] =
            ( RfPageFrame ){ .relmse = NAN, .seconds = NAN, .samples = NAN, .effective = NAN, .phi = NAN, .f1 = NAN };
    track->value_factor =
        rf_values_factor( window.width, window.height, (double)all->values / all->track_count / all->count - BLOCK_BYTES );
    list_missing( track );
    find_layers( &work );
    RfResult result = find_page_layers( &work, error );
    for ( int i = 0; i < all->count && result == RF_OK; ++i )
    {
        result = add_frame( &work, i, error );
        if ( result == RF_OK && track->frames[i].shown && !go_on( all ) )
            result = rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted: no page is written" );
    }
    if ( result == RF_OK )
        sum_up( &work );
    rf_destroy_flicker_frame( work.ring );
    rf_destroy_flicker_frame( work.ring + 1 );
    rf_destroy_summary( &work.errors );
    return result;
}

void rf_free_page_track( RfPageTrack* track )
{
    free_page_layers( &track->layers );
    free( track->frames );
    free( track->missing );
    close_sequence( &track->sequence );
}
