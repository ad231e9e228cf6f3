// Adds the frames of a sequence to the page: pictures, AOVs, values for the probe, error and flicker.
#include "cli/report/report_frames.h"

#include "cli/messages.h"
#include "cli/report/report_input.h"
#include "measure/image_error.h"
#include "measure/flicker.h"
#include "measure/flicker_sequence.h"
#include "page/page.h"
#include "page/picture.h"
#include "reframe/aov.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LEAST_BITS 2.5 // per pixel; pictures are made smaller rather than coarser

// How an AOV looks on the page; false: it is not shown. Without a default, so that the compiler names a new one.
static bool look_of( RfAov aov, RfLook* look )
{
    switch ( aov )
    {
        case RF_AOV_REMOVED:
        case RF_AOV_ALBEDO: *look = RF_LOOK_LIGHT; return true;
        case RF_AOV_NORMAL: *look = RF_LOOK_NORMAL; return true;
        case RF_AOV_DEPTH: *look = RF_LOOK_DEPTH; return true;
        case RF_AOV_MOTION: *look = RF_LOOK_MOTION; return true;
        case RF_AOV_VARIANCE: *look = RF_LOOK_DEVIATION; return true;
        case RF_AOV_SAMPLES:
        case RF_AOV_ALPHA: *look = RF_LOOK_SHARE; return true;
        case RF_AOV_PRIMAL:
        case RF_AOV_DX:
        case RF_AOV_DY:
        case RF_AOV_COUNT: break;
    }
    return false;
}

// Blender's names: of the first channel; the others follow by their letters.
static const char* const s_blender[RF_AOV_COUNT][2] = {
    [RF_AOV_ALBEDO] = { "DiffCol.R" }, [RF_AOV_NORMAL] = { "Normal.X" },  [RF_AOV_DEPTH] = { "Depth.Z", "Depth.V" },
    [RF_AOV_MOTION] = { "Vector.X" },  [RF_AOV_ALPHA] = { "Combined.A" },
};

static bool is_at_picture( const RfExrName* channel, const RfExrHeader* header )
{
    const RfExrWindow* w = &channel->window;
    return w->x == header->x && w->y == header->y && w->width == header->width && w->height == header->height;
}

static const char* find_tail( const RfExrHeader* header, const char* tail )
{
    size_t end = strlen( tail );
    for ( int i = 0; i < header->channel_count; ++i )
    {
        const char* name = header->channels[i].text;
        size_t length = strlen( name );
        if ( length >= end && strcmp( name + length - end, tail ) == 0 && ( length == end || name[length - end - 1] == '.' ) &&
             is_at_picture( header->channels + i, header ) )
            return name;
    }
    return NULL;
}

// The channel with the same name but for the last letter.
static const char* find_sister( const RfExrHeader* header, const char* first, char letter )
{
    size_t length = strlen( first );
    for ( int i = 0; i < header->channel_count; ++i )
    {
        const char* name = header->channels[i].text;
        if ( strlen( name ) == length && memcmp( name, first, length - 1 ) == 0 && name[length - 1] == letter &&
             is_at_picture( header->channels + i, header ) )
            return name;
    }
    return NULL;
}

static bool find_layer( const RfExrHeader* header, RfAov aov, RfPageLayer* layer )
{
    const char *name = rf_aov_name( aov ), *letters = rf_aov_letters( aov );
    *layer = ( RfPageLayer ){ .name = name };
    if ( !look_of( aov, &layer->look ) )
        return false;
    char tail[64] = "A";
    if ( aov != RF_AOV_ALPHA )
        snprintf( tail, sizeof tail, "%s.%c", name, letters[0] );
    layer->channels[0] = find_tail( header, tail );
    for ( int t = 0; t < 2 && s_blender[aov][t] != NULL && layer->channels[0] == NULL; ++t )
        layer->channels[0] = find_tail( header, s_blender[aov][t] );
    bool is_there = layer->channels[0] != NULL;
    for ( int c = 1; c < rf_look_channels( layer->look ) && is_there; ++c )
    {
        layer->channels[c] = find_sister( header, layer->channels[0], letters[c] );
        is_there = layer->channels[c] != NULL;
    }
    return is_there;
}

// Reads the channels of all layers at once: `count` floats for each pixel. NULL where the file lacks one.
static float* read_all( const RfPageLayers* layers, const char* path, RfExrWindow* window, int* count )
{
    const char* names[3 * RF_AOV_COUNT];
    float* values = NULL;
    *count = 0;
    for ( int i = 0; i < layers->count; ++i )
    {
        for ( int c = 0; c < rf_look_channels( layers->layers[i].look ); ++c )
            names[( *count )++] = layers->layers[i].channels[c];
    }
    return rf_read_exr_channels( path, names, *count, window, &values, NULL ) == RF_OK ? values : NULL;
}

static void choose_factor( const RfExrHeader* header, int pictures, double share, RfPageLayers* layers )
{
    double bits = share / ( (double)layers->count * pictures ) * 0.75 * 8.0; // of a picture
    layers->factor = (int)ceil( sqrt( (double)header->width * header->height * LEAST_BITS / bits ) );
    layers->factor = layers->factor < 1 ? 1 : layers->factor;
    layers->width = ( header->width + layers->factor - 1 ) / layers->factor;
    layers->height = ( header->height + layers->factor - 1 ) / layers->factor;
    layers->bits = fmin( bits / ( (double)layers->width * layers->height ), RF_PICTURE_MAX_BITS );
}

// Finds the AOVs of the first file, and the ranges of their values in `typical`. `pictures` is the number
// of frames that the AOVs of this sequence will have, `share` its part of RF_PAGE_LAYER_BYTES.
static void find_page_layers( const RfPageSequence* sequence, const char* typical, int pictures, double share,
                              RfPageLayers* layers )
{
    *layers = ( RfPageLayers ){ 0 };
    for ( RfAov aov = 0; aov < RF_AOV_COUNT && pictures > 0; ++aov )
        layers->count += find_layer( &sequence->header, aov, layers->layers + layers->count );
    if ( layers->count == 0 )
        return;
    choose_factor( &sequence->header, pictures, share, layers );
    RfExrWindow window;
    int stride, at = 0;
    float* values = read_all( layers, typical, &window, &stride );
    if ( values == NULL )
        layers->count = 0;
    for ( int i = 0; i < layers->count; ++i )
    {
        RfPageLayer* layer = layers->layers + i;
        layer->range = rf_look_range( layer->look, values + at, (size_t)stride, (size_t)window.width * (size_t)window.height );
        if ( strcmp( layer->name, rf_aov_name( RF_AOV_ALPHA ) ) == 0 )
            layer->range = ( RfLookRange ){ 0.0f, 1.0f };
        at += rf_look_channels( layer->look );
    }
    free( values );
}

// Draws a layer at full size, shrinks and adds it.
static RfResult add_one( RfPage* page, const RfPageLayers* layers, int index, const char* id, const float* values, int stride,
                         RfImage* full, const char* path, RfError* error )
{
    const RfPageLayer* layer = layers->layers + index;
    RfImage small = { 0 };
    unsigned char* bytes = NULL;
    size_t size = 0;
    rf_draw_look( layer->look, layer->range, values, (size_t)stride, (size_t)full->width * (size_t)full->height, full->rgb );
    RfResult result = layers->factor > 1 ? rf_shrink_image( full, layers->factor, &small, error ) : RF_OK;
    if ( result == RF_OK )
        result = rf_encode_picture_within( layers->factor > 1 ? &small : full, layers->bits, path, &bytes, &size, error );
    if ( result == RF_OK )
        result = rf_add_page_block( page, id, bytes, size, error );
    free( bytes );
    rf_destroy_image( &small );
    return result;
}

// Adds their pictures of a frame; *added is false where its file lacks one of them.
static RfResult add_page_layers( RfPage* page, const RfPageLayers* layers, int track, int number, const char* path, bool* added,
                                 RfError* error )
{
    RfExrWindow window;
    RfImage full;
    int stride, at = 0;
    *added = false;
    if ( layers->count == 0 )
        return RF_OK;
    float* values = read_all( layers, path, &window, &stride );
    if ( values == NULL )
        return RF_OK;
    RfResult result = rf_create_image( window.width, window.height, &full, error );
    for ( int i = 0; i < layers->count && result == RF_OK; ++i )
    {
        char id[48];
        snprintf( id, sizeof id, "l%d-%d-%d", track, i, number );
        result = add_one( page, layers, i, id, values + at, stride, &full, path, error );
        at += rf_look_channels( layers->layers[i].look );
    }
    *added = result == RF_OK;
    rf_destroy_image( &full );
    free( values );
    return result;
}

json_t* rf_page_layers_json( const RfPageLayers* layers )
{
    static const char* const looks[] = { "light", "deviation", "normal", "depth", "motion", "share" };
    json_t* list = json_array();
    for ( int i = 0; i < layers->count; ++i )
    {
        const RfPageLayer* layer = layers->layers + i;
        json_array_append_new( list,
                               json_pack( "{s:s, s:s, s:o, s:o, s:i, s:i, s:i}", "name", layer->name, "look", looks[layer->look],
                                          "low", rf_json_number( layer->range.low ), "high", rf_json_number( layer->range.high ),
                                          "factor", layers->factor, "width", layers->width, "height", layers->height ) );
    }
    return list;
}

void rf_page_block_id( const RfPageTrack* track, int number, char id[32] ) { snprintf( id, 32, "s%d-%d", track->index, number ); }

static RfResult add_picture( RfPage* page, RfPageTrack* track, int number, const RfImage* image, const char* path,
                             RfError* error )
{
    RfImage small = { 0 };
    int factor = track->width > 0 ? ( image->width + track->width - 1 ) / track->width : 1;
    unsigned char* bytes = NULL;
    size_t size = 0;
    RfResult result = factor > 1 ? rf_shrink_image( image, factor, &small, error ) : RF_OK;
    const RfImage* picture = factor > 1 ? &small : image;
    if ( result == RF_OK )
        result = rf_encode_picture( picture, path, &bytes, &size, error );
    char id[32];
    rf_page_block_id( track, number, id );
    if ( result == RF_OK )
        result = rf_add_page_block( page, id, bytes, size, error );
    track->picture_width = picture->width;
    track->picture_height = picture->height;
    track->picture_bytes += size;
    free( bytes );
    rf_destroy_image( &small );
    return result;
}

static RfResult add_values( RfPage* page, RfPageTrack* track, const char* id, const RfImage* image, int factor, const char* path,
                            RfError* error )
{
    unsigned char* bytes;
    size_t size;
    uint64_t before = page->bytes;
    RfResult result = rf_encode_values( image, factor, path, &bytes, &size, error );
    if ( result == RF_OK )
        result = rf_add_page_block( page, id, bytes, size, error );
    track->value_bytes += page->bytes - before;
    free( bytes );
    return result;
}

RfResult rf_add_page_fine_values( RfPage* page, RfPageTrack* track, int number, int factor, RfError* error )
{
    char path[RF_PAGE_NAME_SIZE], id[32];
    RfImage image;
    RfExrWindow window;
    RfResult result = rf_page_frame_path( track->sequence, number, path, error );
    if ( result == RF_OK )
        result = rf_read_exr_layer( path, track->sequence->layer, &image, &window, error );
    if ( result != RF_OK )
        return result;
    snprintf( id, sizeof id, "w%d-%d", track->index, number );
    result = add_values( page, track, id, &image, factor, path, error );
    rf_destroy_image( &image );
    track->fine_frame = number;
    track->fine_factor = factor;
    return result;
}

// Adds picture, scene values and AOVs of a frame, an index into track->numbers; `path` is its file.
static RfResult add_page_blocks( RfPage* page, RfPageTrack* track, int frame, const RfImage* image, const char* path,
                                 RfError* error )
{
    int number = track->numbers[frame];
    char id[32];
    RfResult result = add_picture( page, track, number, image, path, error );
    snprintf( id, sizeof id, "v%d-%d", track->index, number );
    if ( result == RF_OK && track->value_factor > 0 )
        result = add_values( page, track, id, image, track->value_factor, path, error );
    uint64_t before = page->bytes;
    if ( result == RF_OK )
        result = add_page_layers( page, &track->layers, track->index, number, path, &track->frames[frame].has_layers, error );
    track->layer_bytes += page->bytes - before;
    return result;
}

// Finds the AOVs of the sequence; the ranges of their values are those of the middle frame.
static RfResult find_page_aovs( RfPageTrack* track, RfError* error )
{
    int pictures = 0, typical = 0;
    char path[RF_PAGE_NAME_SIZE];
    for ( int i = 0; i < track->count; ++i )
    {
        if ( !rf_has_page_frame( track->sequence, track->numbers[i] ) )
            continue;
        typical = pictures == 0 || i <= track->count / 2 ? track->numbers[i] : typical;
        ++pictures;
    }
    if ( pictures == 0 || !( track->layer_share > 0.0 ) )
        return RF_OK;
    RfResult result = rf_page_frame_path( track->sequence, typical, path, error );
    if ( result == RF_OK )
        find_page_layers( track->sequence, path, pictures, track->layer_share, &track->layers );
    if ( result == RF_OK && track->layers.count == 0 ) // the middle frame may lack them
        find_page_layers( track->sequence, track->sequence->first, pictures, track->layer_share, &track->layers );
    return result;
}

typedef struct Work
{
    RfPage* page;
    RfPageTrack* track;
    RfFlickerLayers layers;
    RfFlickerFrame ring[2]; // this frame and the one before, at their places modulo 2
    bool has_frame[2];      // and their signals are what flicker wants
    RfErrorSummary errors;
    bool has_summary;
} Work;

// Chooses motion and depth and, without a reference, the variance of the colour, where the
// files have them; what `flicker` would refuse is left out.
static void find_layers( Work* work )
{
    RfPageTrack* track = work->track;
    const RfPageSequence* sequence = track->sequence;
    RfFlickerLayers* layers = &work->layers;
    *layers = ( RfFlickerLayers ){ 0 };
    if ( !sequence->is_reference &&
         ( rf_find_flicker_layers( sequence->first, &sequence->header, NULL, NULL, layers, NULL ) != RF_OK ||
           layers->motion[0] == NULL ) )
        *layers = ( RfFlickerLayers ){ 0 };
    bool alone = track->reference == NULL && !sequence->is_reference;
    if ( alone && sequence->layer == NULL )
        rf_find_variance_layers( sequence->first, &sequence->header, layers, NULL );
    layers->colour = sequence->layer;
    layers->may_lack = true;
    track->compensated = alone && layers->motion[0] != NULL;
    track->follows = !alone && layers->motion[0] != NULL;
    track->has_variance = layers->variance[0] != NULL;
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
    RfResult result = rf_measure_error( &frame->signal, reference, &metrics, error );
    if ( result == RF_OK && !work->has_summary )
    {
        result = rf_create_summary( frame->signal.width, frame->signal.height, work->track->count, &work->errors, error );
        work->has_summary = result == RF_OK;
    }
    if ( result == RF_OK )
        result = rf_summary_add( &work->errors, &frame->signal, reference, error );
    if ( result != RF_OK )
        return result;
    figures->relmse = metrics.relmse;
    size_t count = 3 * (size_t)reference->width * (size_t)reference->height;
    for ( size_t i = 0; i < count; ++i )
        frame->signal.rgb[i] -= reference->rgb[i];
    frame->is_finite = !rf_has_no_error( &metrics );
    return RF_OK;
}

// Takes what `render` recorded of the frame, in its JSON or in the file. Times are in no
// image file, so that equal renders give equal files.
static void take_said( const RfPageSequence* sequence, int number, const char* path, RfPageFrame* figures )
{
    size_t i;
    const json_t* row;
    json_array_foreach( json_object_get( sequence->render, "frames" ), i, row )
    {
        if ( rf_json_number_of( row, "frame" ) != number )
            continue;
        figures->relmse = rf_json_number_of( row, "relmse_estimate" );
        figures->seconds = rf_json_number_of( row, "seconds" );
        figures->samples = rf_json_number_of( row, "native_spp" );
        figures->effective = rf_json_number_of( row, "effective_spp" );
        figures->at_least = json_is_true( json_object_get( row, "relmse_is_lower_bound" ) );
        figures->worst_ten_share = rf_json_number_of( row, "worst_ten_share" );
    }
    if ( isnan( figures->relmse ) )
        figures->relmse = rf_read_exr_number( path, "reframe/relmse-estimate" );
    char text[8];
    if ( !figures->at_least )
        figures->at_least =
            rf_read_exr_string( path, "reframe/relmse-is-lower-bound", text, sizeof text, NULL ) == RF_OK && text[0] == 'y';
    if ( isnan( figures->worst_ten_share ) )
        figures->worst_ten_share = rf_read_exr_number( path, "reframe/worst-ten-share" );
    if ( isnan( figures->samples ) )
        figures->samples = rf_read_exr_number( path, "reframe/native-spp" );
    if ( isnan( figures->effective ) )
        figures->effective = rf_read_exr_number( path, "reframe/effective-spp" );
}

// The pair of this frame and the one before, if both are there. Along the motion only
// where both have the layers.
static RfResult measure_flicker( Work* work, int i, RfError* error )
{
    RfPageTrack* track = work->track;
    RfFlickerSums sums, followed;
    const RfFlickerFrame *now = work->ring + i % 2, *before = work->ring + ( i + 1 ) % 2;
    bool pair = i > 0 && work->has_frame[0] && work->has_frame[1] && track->numbers[i] == track->numbers[i - 1] + 1;
    if ( !pair || rf_is_cut( now, before ) )
        return RF_OK;
    track->pair_count += 1;
    bool has_layers = rf_has_flicker_layers( &work->layers, now, before );
    if ( !track->follows && !has_layers )
        return RF_OK;
    RfResult result = rf_measure_flicker( now, before, track->compensated, track->reference != NULL, &sums, error );
    if ( result == RF_OK && track->follows && has_layers )
    {
        result = rf_measure_flicker( now, before, true, true, &followed, error );
        rf_add_flicker( &track->followed, &followed );
    }
    if ( result != RF_OK )
        return result;
    RfFlickerMetrics metrics = rf_flicker_metrics( &sums );
    track->frames[i].phi = metrics.phi;
    track->frames[i].f1 = metrics.f1;
    rf_add_flicker( &track->flicker, &sums );
    return RF_OK;
}

static RfResult add_frame( Work* work, int i, RfError* error )
{
    RfPageTrack* track = work->track;
    int number = track->numbers[i];
    RfPageFrame* figures = track->frames + i;
    RfFlickerFrame* frame = work->ring + i % 2;
    char path[RF_PAGE_NAME_SIZE];
    rf_destroy_flicker_frame( frame );
    work->has_frame[i % 2] = false;
    if ( !rf_has_page_frame( track->sequence, number ) )
        return RF_OK;
    RfResult result = rf_page_frame_path( track->sequence, number, path, error );
    if ( result == RF_OK )
        result = rf_read_flicker_frame( path, &work->layers, &track->sequence->header, track->sequence->first, frame, error );
    if ( result == RF_OK )
        result = add_page_blocks( work->page, track, i, &frame->signal, path, error );
    if ( result != RF_OK )
        return result;
    figures->shown = true;
    figures->bad = count_bad( &frame->signal );
    frame->number = number;
    frame->is_finite = figures->bad == 0;
    bool has_reference = track->reference != NULL && rf_has_page_frame( track->reference, number );
    take_said( track->sequence, number, path, figures );
    if ( track->reference != NULL || track->sequence->is_reference ) // an estimate would not belong there
    {
        figures->relmse = figures->worst_ten_share = NAN;
        figures->at_least = false;
    }
    RfImage reference = { 0 };
    if ( has_reference )
        result = rf_page_frame_path( track->reference, number, path, error );
    if ( result == RF_OK && has_reference )
        result =
            rf_read_aligned( path, track->reference->layer, &track->sequence->header, track->sequence->first, &reference, error );
    if ( result == RF_OK && has_reference )
        result = measure_error( work, figures, frame, &reference, error );
    rf_destroy_image( &reference );
    work->has_frame[i % 2] = !track->sequence->is_reference && ( has_reference || track->reference == NULL );
    return result == RF_OK ? measure_flicker( work, i, error ) : result;
}

static void sum_up( Work* work )
{
    RfPageTrack* track = work->track;
    double sum = 0.0;
    int count = 0;
    for ( int i = 0; i < track->count; ++i )
    {
        if ( isnan( track->frames[i].relmse ) )
            continue;
        sum += track->frames[i].relmse;
        ++count;
    }
    track->estimate = count > 0 && track->reference == NULL ? sum / count : NAN;
    track->has_error = work->has_summary;
    if ( work->has_summary )
        track->error = rf_summary_metrics( &work->errors );
}

RfResult rf_add_page_track( RfPage* page, RfPageTrack* track, RfPageProgressFn* progress, void* user, RfError* error )
{
    Work work = { .page = page, .track = track };
    track->frames = malloc( (size_t)track->count * sizeof( RfPageFrame ) );
    if ( track->frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for %d frames", track->sequence->pattern, track->count );
    for ( int i = 0; i < track->count; ++i )
        track->frames[i] = ( RfPageFrame ){
            .relmse = NAN, .seconds = NAN, .samples = NAN, .effective = NAN, .phi = NAN, .f1 = NAN, .worst_ten_share = NAN
        };
    find_layers( &work );
    RfResult result = find_page_aovs( track, error );
    for ( int i = 0; i < track->count && result == RF_OK; ++i )
    {
        result = add_frame( &work, i, error );
        if ( result == RF_OK && track->frames[i].shown && !progress( user ) )
            result = rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted: no page is written" );
    }
    if ( result == RF_OK )
        sum_up( &work );
    rf_destroy_flicker_frame( work.ring );
    rf_destroy_flicker_frame( work.ring + 1 );
    if ( work.has_summary )
        rf_destroy_summary( &work.errors );
    return result;
}

int* rf_page_missing_frames( const RfPageTrack* track, int* count )
{
    *count = 0;
    int* missing = malloc( (size_t)( track->count + track->hole_count + 1 ) * sizeof( int ) );
    for ( int i = 0, k = 0; missing != NULL && ( i < track->count || k < track->hole_count ); )
    {
        bool is_hole = i == track->count || ( k < track->hole_count && track->holes[k] < track->numbers[i] );
        int number = is_hole ? track->holes[k++] : track->numbers[i++];
        if ( !rf_has_page_frame( track->sequence, number ) )
            missing[( *count )++] = number;
    }
    return missing;
}

void rf_free_page_track( RfPageTrack* track )
{
    free( track->frames );
    track->frames = NULL;
}
