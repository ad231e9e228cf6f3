// The flicker of a whole sequence (reframe/measure.h).
#include "measure/flicker_sequence.h"

#include "base/remedy.h"
#include "image/exr.h"
#include "measure/image_error.h"
#include "measure/flicker.h"
#include "measure/sequences.h"

#include <stdlib.h>
#include <string.h>

#define MAX_LAYERS 6

// True if `name` equals `tail` or ends in a dot followed by `tail`.
static bool has_tail( const char* name, const char* tail )
{
    size_t length = strlen( name ), end = strlen( tail );
    if ( length < end || strcmp( name + length - end, tail ) != 0 )
        return false;
    return length == end || name[length - end - 1] == '.';
}

// Finds the channel with this tail: in the part with the colour if it has any, else in any
// part. Two candidates are an error.
static RfResult find_tail( const char* path, const RfExrHeader* header, const char* tail, RfRemedy remedy, const char** found,
                           RfError* error )
{
    for ( int k = 0; k < 2 && *found == NULL; ++k )
    {
        for ( int c = 0; c < header->channel_count; ++c )
        {
            const RfExrName* channel = header->channels + c;
            if ( ( k == 0 && channel->part != header->part ) || !has_tail( channel->text, tail ) )
                continue;
            if ( *found != NULL )
                return rf_advise( rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: has both %s and %s%s", path, *found, channel->text,
                                           remedy == RF_REMEDY_NONE ? ": choose a file with one of them" : "" ),
                                  remedy, 0, error );
            *found = channel->text;
        }
    }
    return RF_OK;
}

// The channel of the first tail that occurs; NULL if none does.
static RfResult find_one( const char* path, const RfExrHeader* header, const char* const* tails, RfRemedy remedy,
                          const char** found, RfError* error )
{
    RfResult result = RF_OK;
    *found = NULL;
    for ( int t = 0; tails[t] != NULL && *found == NULL && result == RF_OK; ++t )
        result = find_tail( path, header, tails[t], remedy, found, error );
    return result;
}

static const char* find_name( const RfExrHeader* header, const char* name, size_t length )
{
    const RfExrName* found = rf_find_exr_name( header, name, length );
    return found != NULL ? found->text : NULL;
}

static RfResult fail_missing( const char* path, const char* what, const char* name, size_t length, RfError* error )
{
    return rf_fail( error, RF_ERROR_FORMAT, "%s: %s: has no channel %.*s", what, path, (int)length, name );
}

static RfResult name_motion( const char* path, const RfExrHeader* header, const char* text, RfFlickerLayers* layers,
                             RfError* error )
{
    const char* comma = strchr( text, ',' );
    if ( comma == NULL || comma == text || comma[1] == '\0' || strchr( comma + 1, ',' ) != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "motion: must be the names of two channels, X,Y, got '%s'", text );
    const char* names[2] = { text, comma + 1 };
    size_t lengths[2] = { (size_t)( comma - text ), strlen( comma + 1 ) };
    for ( int i = 0; i < 2; ++i )
    {
        layers->motion[i] = find_name( header, names[i], lengths[i] );
        if ( layers->motion[i] == NULL )
            return fail_missing( path, "motion", names[i], lengths[i], error );
    }
    return RF_OK;
}

static RfResult find_motion( const char* path, const RfExrHeader* header, RfFlickerLayers* layers, RfError* error )
{
    static const char* const x[] = { "motion.X", "Vector.X", "backward.u", NULL };
    RfResult result = find_one( path, header, x, RF_REMEDY_MOTION, layers->motion, error );
    if ( result != RF_OK || layers->motion[0] == NULL )
        return result;
    // Y, Nuke's v, of the same layer
    size_t length = strlen( layers->motion[0] );
    char second = layers->motion[0][length - 1] == 'u' ? 'v' : 'Y';
    for ( int c = 0; c < header->channel_count; ++c )
    {
        const char* name = header->channels[c].text;
        if ( strlen( name ) == length && memcmp( name, layers->motion[0], length - 1 ) == 0 && name[length - 1] == second )
            layers->motion[1] = name;
    }
    if ( layers->motion[1] == NULL )
        layers->motion[0] = NULL;
    return RF_OK;
}

RfResult rf_find_variance_layers( const char* path, const RfExrHeader* header, RfFlickerLayers* layers, RfError* error )
{
    static const char* const tails[3][2] = { // the same for both names
                                             { "variance.R" },
                                             { "variance.G" },
                                             { "variance.B" }
    };
    for ( int c = 0; c < 3; ++c )
    {
        RfResult result = find_one( path, header, tails[c], RF_REMEDY_NONE, layers->variance + c, error );
        if ( result != RF_OK )
            return result;
    }
    if ( layers->variance[0] == NULL || layers->variance[1] == NULL || layers->variance[2] == NULL )
        memset( layers->variance, 0, sizeof layers->variance );
    return RF_OK;
}

RfResult rf_find_flicker_layers( const char* path, const RfExrHeader* header, const char* motion, const char* depth,
                                 RfFlickerLayers* layers, RfError* error )
{
    static const char* const depths[] = { "depth.Z", "Depth.Z", "Depth.V", NULL };
    *layers = ( RfFlickerLayers ){ 0 };
    RfResult result =
        motion != NULL ? name_motion( path, header, motion, layers, error ) : find_motion( path, header, layers, error );
    if ( result != RF_OK )
        return result;
    if ( depth != NULL )
    {
        layers->depth = find_name( header, depth, strlen( depth ) );
        if ( layers->depth == NULL )
            return fail_missing( path, "depth", depth, strlen( depth ), error );
    }
    else if ( ( result = find_one( path, header, depths, RF_REMEDY_DEPTH, &layers->depth, error ) ) != RF_OK )
        return result;
    if ( layers->depth == NULL )
        layers->depth = find_name( header, "Z", 1 );
    return RF_OK;
}

// Fails if the data windows differ; `why` says what needs them equal.
static RfResult check_window( const char* path, const RfExrWindow* window, const char* first_path, const RfExrHeader* first,
                              const char* why, RfError* error )
{
    if ( window->width != first->width || window->height != first->height )
        return rf_fail( error, RF_ERROR_FORMAT, "%.400s: has %dx%d pixels and %.400s %dx%d: %s", path, window->width,
                        window->height, first_path, first->width, first->height, why );
    if ( window->x != first->x || window->y != first->y )
        return rf_fail( error, RF_ERROR_FORMAT, "%.350s: its data window begins at (%d, %d), that of %.350s at (%d, %d): %s",
                        path, window->x, window->y, first_path, first->x, first->y, why );
    return RF_OK;
}

RfResult rf_read_aligned( const char* path, const char* layer, const RfExrHeader* first, const char* first_path, RfImage* image,
                          RfError* error )
{
    RfExrWindow window;
    RfResult result = rf_read_exr_layer( path, layer, image, &window, error );
    if ( result == RF_OK )
        result = check_window( path, &window, first_path, first,
                               "a reference needs the same data window as the frame it is compared with", error );
    if ( result != RF_OK )
        rf_destroy_image( image );
    return result;
}

// The rows that give x·z, y·z and z, derived from the matrix to NDC, in which x and y go from
// −1 to 1 over the display window, +y up, and whose last column gives z.
static void take_camera( const RfExrHeader* header, RfFlickerFrame* frame )
{
    frame->has_camera = header->has_world_to_ndc;
    double width = header->display_width, height = header->display_height;
    double left = (double)header->display_x - header->x - 0.5, top = (double)header->display_y - header->y - 0.5;
    for ( int i = 0; i < 4; ++i )
    {
        const float* row = header->world_to_ndc + 4 * i;
        double x = (double)row[0], y = (double)row[1], w = (double)row[3];
        frame->camera[0][i] = 0.5 * width * ( x + w ) + left * w;
        frame->camera[1][i] = 0.5 * height * ( w - y ) + top * w;
        frame->camera[2][i] = w;
    }
}

// The channels to read, without duplicates, and the indices of each layer's channels among
// them.
typedef struct Wanted
{
    const char* names[MAX_LAYERS];
    int count;
} Wanted;

static void add_wanted( Wanted* wanted, const char* const* names, int count, int* where )
{
    for ( int i = 0; i < count; ++i )
    {
        int at = 0;
        while ( at < wanted->count && strcmp( wanted->names[at], names[i] ) != 0 )
            ++at;
        wanted->names[at] = names[i];
        wanted->count += at == wanted->count;
        where[i] = at;
    }
}

static float* select_channels( const float* values, size_t pixels, int channels, const int* where, int count )
{
    float* out = malloc( pixels * (size_t)count * sizeof( float ) );
    for ( size_t i = 0; out != NULL && i < pixels; ++i )
    {
        for ( int c = 0; c < count; ++c )
            out[i * (size_t)count + (size_t)c] = values[i * (size_t)channels + (size_t)where[c]];
    }
    return out;
}

// True if these channels exist with the data window of the colour.
static bool has_channels( const RfExrHeader* header, const char* const* names, int count )
{
    const RfExrWindow window = { header->x, header->y, header->width, header->height };
    for ( int i = 0; i < count; ++i )
    {
        const RfExrName* channel = names[i] != NULL ? rf_find_exr_name( header, names[i], strlen( names[i] ) ) : NULL;
        if ( channel == NULL || memcmp( &channel->window, &window, sizeof window ) != 0 )
            return false;
    }
    return true;
}

static RfResult read_layers( const char* path, const RfFlickerLayers* layers, const RfExrHeader* header, RfFlickerFrame* frame,
                             RfError* error )
{
    bool lack = layers->may_lack;
    bool has_motion = layers->motion[0] != NULL && ( !lack || has_channels( header, layers->motion, 2 ) );
    bool has_depth = layers->depth != NULL && ( !lack || has_channels( header, &layers->depth, 1 ) );
    bool has_variance = layers->variance[0] != NULL && ( !lack || has_channels( header, layers->variance, 3 ) );
    int motion[2] = { 0 }, depth[1] = { 0 }, variance[3] = { 0 };
    Wanted wanted = { .count = 0 };
    add_wanted( &wanted, layers->motion, has_motion ? 2 : 0, motion );
    add_wanted( &wanted, &layers->depth, has_depth ? 1 : 0, depth );
    add_wanted( &wanted, layers->variance, has_variance ? 3 : 0, variance );
    if ( wanted.count == 0 )
        return RF_OK;
    float* values;
    RfExrWindow window;
    RfResult result = rf_read_exr_channels( path, wanted.names, wanted.count, &window, &values, error );
    if ( result == RF_OK )
        result = check_window( path, &window, path, header, "layers and colour need the same data window", error );
    if ( result != RF_OK )
    {
        free( values );
        return result;
    }
    size_t pixels = (size_t)window.width * (size_t)window.height;
    frame->motion = has_motion ? select_channels( values, pixels, wanted.count, motion, 2 ) : NULL;
    frame->depth = has_depth ? select_channels( values, pixels, wanted.count, depth, 1 ) : NULL;
    if ( has_variance )
        frame->variance =
            ( RfImage ){ window.width, window.height, select_channels( values, pixels, wanted.count, variance, 3 ) };
    free( values );
    if ( has_motion != ( frame->motion != NULL ) || has_depth != ( frame->depth != NULL ) ||
         has_variance != ( frame->variance.rgb != NULL ) )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for its layers", path );
    return RF_OK;
}

static RfResult read_colour( const char* path, const RfFlickerLayers* layers, const RfExrHeader* first, const char* first_path,
                             RfFlickerFrame* frame, RfError* error )
{
    RfExrWindow window;
    RfResult result = rf_read_exr_picture( path, layers->colour, &frame->signal, &window, &frame->clipped, error );
    return result == RF_OK ? check_window( path, &window, first_path, first,
                                           "all frames of a sequence need the same size and data window", error )
                           : result;
}

RfResult rf_read_flicker_frame( const char* path, const RfFlickerLayers* layers, const RfExrHeader* first, const char* first_path,
                                RfFlickerFrame* frame, RfError* error )
{
    *frame = ( RfFlickerFrame ){ 0 };
    RfExrHeader header;
    RfResult result = rf_read_exr_header( path, layers->colour, &header, error );
    if ( result != RF_OK )
        return result;
    take_camera( &header, frame );
    if ( rf_read_exr_string( path, "reframe/shot", frame->shot, sizeof frame->shot, NULL ) != RF_OK )
        frame->shot[0] = '\0';
    result = read_colour( path, layers, first, first_path, frame, error );
    if ( result == RF_OK )
        result = read_layers( path, layers, &header, frame, error );
    rf_destroy_exr_header( &header );
    if ( result != RF_OK )
        rf_destroy_flicker_frame( frame );
    return result;
}

bool rf_has_flicker_layers( const RfFlickerLayers* layers, const RfFlickerFrame* now, const RfFlickerFrame* before )
{
    return ( layers->motion[0] == NULL || now->motion != NULL ) &&
           ( layers->depth == NULL || ( now->depth != NULL && before->depth != NULL ) ) &&
           ( layers->variance[0] == NULL || ( now->variance.rgb != NULL && before->variance.rgb != NULL ) );
}

#define MAX_NAME 4096

typedef struct Run
{
    const char* pattern;
    const char* reference; // or NULL
    char first_path[MAX_NAME];
    RfExrHeader first;
    RfFlickerLayers layers; // their names lie in `first`
    RfFlickerSums sums;
} Run;

static RfResult check_numbers( const Run* run, const int* numbers, int count, RfError* error )
{
    if ( count < 2 )
        return rf_fail( error, RF_ERROR_IO, "%s: is frame %d alone: flicker needs two neighbouring ones at least", run->pattern,
                        numbers[0] );
    int step = rf_sequence_step( run->pattern, numbers[0] );
    for ( int i = 1; i < count; ++i )
    {
        if ( numbers[i] != numbers[i - 1] + step )
            return rf_fail( error, RF_ERROR_IO, "%s: after frame %d comes %d: flicker needs every frame", run->pattern,
                            numbers[i - 1], numbers[i] );
    }
    return RF_OK;
}

// Against a reference pixels are compared where they are, else along the motion.
static RfResult open_first( Run* run, int number, RfError* error )
{
    RfResult result = rf_sequence_name( run->pattern, number, run->first_path, sizeof run->first_path, error );
    if ( result == RF_OK )
        result = rf_read_exr_header( run->first_path, NULL, &run->first, error );
    if ( result != RF_OK || run->reference != NULL )
        return result;
    result = rf_find_flicker_layers( run->first_path, &run->first, NULL, NULL, &run->layers, error );
    if ( run->layers.motion[0] == NULL )
        run->layers.depth = NULL;
    return result == RF_OK ? rf_find_variance_layers( run->first_path, &run->first, &run->layers, error ) : result;
}

static RfResult read_reference( const Run* run, int number, RfImage* image, RfError* error )
{
    char path[MAX_NAME];
    RfResult result = rf_sequence_name( run->reference, number, path, sizeof path, error );
    return result == RF_OK ? rf_read_aligned( path, NULL, &run->first, run->first_path, image, error ) : result;
}

// The signal becomes the error where there is a reference.
static RfResult read_frame( const Run* run, int number, RfFlickerFrame* frame, RfError* error )
{
    char path[MAX_NAME];
    RfImage reference = { 0 };
    RfErrorMetrics metrics;
    RfResult result = rf_sequence_name( run->pattern, number, path, sizeof path, error );
    if ( result == RF_OK )
        result = rf_read_flicker_frame( path, &run->layers, &run->first, run->first_path, frame, error );
    if ( result == RF_OK && run->reference != NULL )
        result = read_reference( run, number, &reference, error );
    const RfImage* to = reference.rgb != NULL ? &reference : &frame->signal;
    if ( result == RF_OK )
        result = rf_measure_error( &frame->signal, to, &metrics, error );
    if ( result == RF_OK )
        frame->is_finite = !rf_has_no_error( &metrics );
    size_t values = 3 * (size_t)frame->signal.width * (size_t)frame->signal.height;
    for ( size_t i = 0; result == RF_OK && reference.rgb != NULL && i < values; ++i )
        frame->signal.rgb[i] -= reference.rgb[i];
    rf_destroy_image( &reference );
    return result;
}

static RfResult add_frames( Run* run, const int* numbers, int count, RfError* error )
{
    RfFlickerFrame frames[2] = { { 0 }, { 0 } };
    RfResult result = RF_OK;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        RfFlickerFrame *now = frames + i % 2, *before = frames + ( i + 1 ) % 2;
        RfFlickerSums pair;
        rf_destroy_flicker_frame( now );
        result = read_frame( run, numbers[i], now, error );
        if ( result == RF_OK && i > 0 )
        {
            result = rf_measure_flicker( now, before, run->layers.motion[0] != NULL, run->reference != NULL, &pair, error );
            if ( result == RF_OK )
                rf_add_flicker( &run->sums, &pair );
        }
    }
    rf_destroy_flicker_frame( frames );
    rf_destroy_flicker_frame( frames + 1 );
    return result;
}

RfResult rf_measure_sequence_flicker( const char* pattern, const char* reference, RfFlickerMetrics* metrics, RfError* error )
{
    Run run = { .pattern = pattern, .reference = reference };
    int* numbers = NULL;
    int count = 0;
    RfResult result = rf_sequence_frames( pattern, &numbers, &count, error );
    if ( result == RF_OK )
        result = check_numbers( &run, numbers, count, error );
    if ( result == RF_OK )
        result = open_first( &run, numbers[0], error );
    if ( result == RF_OK )
        result = add_frames( &run, numbers, count, error );
    if ( result == RF_OK )
        *metrics = rf_flicker_metrics( &run.sums );
    rf_destroy_exr_header( &run.first );
    free( numbers );
    return result;
}
