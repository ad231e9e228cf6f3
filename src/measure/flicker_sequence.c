// Layers of files for flicker, and the flicker of a whole sequence (also that of reframe/measure.h).
#include "measure/flicker_sequence.h"

#include "base/remedy.h"
#include "base/try.h"
#include "output/frame_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAX_LAYERS 6
#define USUAL_RATE 24.0 // frames per second, where the files do not tell

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
        RF_TRY( find_one( path, header, tails[c], RF_REMEDY_NONE, layers->variance + c, error ) );
    }
    if ( rf_is_denoised( path ) || layers->variance[0] == NULL || layers->variance[1] == NULL || layers->variance[2] == NULL )
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
    const char* const* const names[3] = { layers->motion, &layers->depth, layers->variance };
    static const int counts[3] = { 2, 1, 3 };
    int where[3][3] = { { 0 } };
    bool has[3];
    float *all, *values[3] = { NULL, NULL, NULL };
    Wanted wanted = { .count = 0 };
    RfExrWindow window;
    for ( int k = 0; k < 3; ++k )
    {
        has[k] = names[k][0] != NULL && ( !layers->may_lack || has_channels( header, names[k], counts[k] ) );
        add_wanted( &wanted, names[k], has[k] ? counts[k] : 0, where[k] );
    }
    if ( wanted.count == 0 )
        return RF_OK;
    RfResult result = rf_read_exr_channels( path, wanted.names, wanted.count, &window, &all, error );
    if ( result == RF_OK )
        result = check_window( path, &window, path, header, "layers and colour need the same data window", error );
    for ( int k = 0; k < 3 && result == RF_OK; ++k )
    {
        size_t pixels = (size_t)window.width * (size_t)window.height;
        values[k] = has[k] ? select_channels( all, pixels, wanted.count, where[k], counts[k] ) : NULL;
        if ( has[k] && values[k] == NULL )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its layers", path );
    }
    free( all );
    frame->motion = values[0];
    frame->depth = values[1];
    if ( values[2] != NULL )
        frame->variance = ( RfImage ){ window.width, window.height, values[2] };
    return result;
}

static RfResult read_colour( const char* path, const RfFlickerLayers* layers, const RfExrHeader* first, const char* first_path,
                             RfFlickerFrame* frame, RfError* error )
{
    RfExrWindow window;
    RF_TRY( rf_read_exr_layer( path, layers->colour, &frame->signal, &window, error ) );
    return check_window( path, &window, first_path, first, "all frames of a sequence need the same size and data window", error );
}

RfResult rf_read_flicker_frame( const char* path, const RfFlickerLayers* layers, const RfExrHeader* first, const char* first_path,
                                RfFlickerFrame* frame, RfError* error )
{
    *frame = ( RfFlickerFrame ){ 0 };
    RfExrHeader header;
    RF_TRY( rf_read_exr_header( path, layers->colour, &header, error ) );
    take_camera( &header, frame );
    if ( rf_read_exr_string( path, "reframe/shot", frame->shot, sizeof frame->shot, NULL ) != RF_OK )
        frame->shot[0] = '\0';
    RfResult result = read_colour( path, layers, first, first_path, frame, error );
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

#define MOST_FRAMES 10000000

static bool read_whole( const char* path, const char* name, int min, int max, int* value )
{
    double number = rf_read_exr_number( path, name );
    bool is_whole = number >= min && number <= max && number == floor( number );
    *value = is_whole ? (int)number : 0;
    return is_whole;
}

RfSeams rf_read_seams( const char* path, int number, int last )
{
    RfSeams seams = { 0 };
    int group, spp, frame, frames;
    if ( !read_whole( path, "reframe/group", 1, MOST_FRAMES, &group ) || !read_whole( path, "reframe/spp", 1, 1 << 20, &spp ) ||
         !read_whole( path, "reframe/frame", -MOST_FRAMES, MOST_FRAMES, &frame ) )
        return seams;
    seams.first = number - ( frame - 1 );
    if ( !read_whole( path, "reframe/frames", 1, MOST_FRAMES, &frames ) )
        frames = last - seams.first + 1;
    char shot[64];
    int first, end;
    if ( rf_read_exr_string( path, "reframe/shot", shot, sizeof shot, NULL ) == RF_OK &&
         sscanf( shot, "%d-%d", &first, &end ) == 2 )
    {
        seams.first = number - ( frame - first );
        frames = end - first + 1;
        frame = frame - first + 1;
    }
    if ( frames < frame || frame < 1 )
        return seams;
    seams.slides = true;
    seams.plan = rf_plan_groups( frames, group, spp );
    return seams;
}

// The frames are consecutive, and the reference has all of them.
static RfResult check_frames( const RfFlickerRun* run, RfError* error )
{
    const int* frames = run->frames;
    char path[RF_FLICKER_NAME_SIZE];
    if ( run->frame_count < 2 )
        return rf_fail( error, RF_ERROR_IO, "%s: has only frame %d: flicker needs at least two neighbouring frames", run->pattern,
                        frames[0] );
    int step = rf_sequence_step( run->pattern, frames[0] );
    for ( int i = 1; i < run->frame_count; ++i )
    {
        if ( frames[i] != frames[i - 1] + step )
            return rf_advise( rf_fail( error, RF_ERROR_IO, "%s: frame %d is followed by %d, and flicker needs consecutive frames",
                                       run->pattern, frames[i - 1], frames[i] ),
                              RF_REMEDY_FRAMES, 0, error );
    }
    for ( int i = 0; i < run->frame_count && run->reference != NULL; ++i )
    {
        RF_TRY( rf_sequence_name( run->reference, frames[i], path, sizeof path, error ) );
        if ( access( path, F_OK ) != 0 )
            return rf_fail( error, RF_ERROR_IO, "%.400s: is missing: the reference needs frame %d, which %.400s has", path,
                            frames[i], run->pattern );
    }
    return RF_OK;
}

RfResult rf_open_flicker_run( RfFlickerRun* run, RfError* error )
{
    RF_TRY( check_frames( run, error ) );
    return rf_sequence_name( run->pattern, run->frames[0], run->first_path, sizeof run->first_path, error );
}

void rf_close_flicker_run( RfFlickerRun* run )
{
    for ( int i = 0; i < RF_SPECTRUM_FRAMES; ++i )
        rf_destroy_flicker_frame( run->ring + i );
    rf_destroy_exr_header( &run->first );
    rf_destroy_summary( &run->summary );
    free( run->pairs );
}

// Groups, the window of the spectrum, and room for what is measured.
static RfResult begin( RfFlickerRun* run, RfError* error )
{
    run->seams = run->period > 0 ? ( RfSeams ){ .period = run->period, .first = run->first_frame }
                                 : rf_read_seams( run->first_path, run->frames[0], run->frames[run->frame_count - 1] );
    run->has_seams = rf_has_seams( &run->seams );
    run->window = run->frame_count < RF_SPECTRUM_FRAMES ? run->frame_count : RF_SPECTRUM_FRAMES;
    run->ring_size = run->has_spectrum ? run->window : 2;
    double rate = run->first.fps_numerator > 0 ? (double)run->first.fps_numerator / run->first.fps_denominator : USUAL_RATE;
    run->split = fmin( RF_DRIFT_HERTZ * rf_sequence_step( run->pattern, run->frames[0] ) / rate, 0.5 );
    run->pairs = calloc( (size_t)run->frame_count, sizeof *run->pairs );
    if ( run->pairs == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d frames", run->frame_count );
    return rf_create_summary( run->first.width, run->first.height, run->frame_count, &run->summary, error );
}

static size_t count_not_finite( const RfErrorSummary* s ) { return s->nan + s->inf + s->reference_nan + s->reference_inf; }

// Counts values that are not finite, adds the slit, and makes the signal the error where there is a reference.
static RfResult take_images( RfFlickerRun* run, int i, RfFlickerFrame* frame, const RfImage* reference, RfError* error )
{
    bool has_reference = reference->rgb != NULL;
    size_t before = count_not_finite( &run->summary );
    RF_TRY( rf_summary_add( &run->summary, &frame->signal, has_reference ? reference : &frame->signal, error ) );
    frame->number = run->frames[i];
    frame->is_finite = count_not_finite( &run->summary ) == before;
    RF_TRY( rf_take_brightness( frame, has_reference ? reference : &frame->signal, error ) );
    if ( run->slit != NULL )
        rf_add_slit( run->slit, i, 0, &frame->signal, run->column );
    if ( run->slit != NULL && has_reference )
        rf_add_slit( run->slit, i, 1, reference, run->column );
    size_t values = 3 * (size_t)frame->signal.width * (size_t)frame->signal.height;
    for ( size_t k = 0; has_reference && k < values; ++k )
        frame->signal.rgb[k] -= reference->rgb[k];
    return RF_OK;
}

static RfResult read_frame( RfFlickerRun* run, int i, RfError* error )
{
    char path[RF_FLICKER_NAME_SIZE];
    RfFlickerFrame* frame = run->ring + i % run->ring_size;
    RfImage reference = { 0 };
    rf_destroy_flicker_frame( frame );
    RfResult result = rf_sequence_name( run->pattern, run->frames[i], path, sizeof path, error );
    if ( result == RF_OK )
        result = rf_read_flicker_frame( path, &run->layers, &run->first, run->first_path, frame, error );
    if ( result == RF_OK && run->reference != NULL )
    {
        result = rf_sequence_name( run->reference, run->frames[i], path, sizeof path, error );
        if ( result == RF_OK )
            result = rf_read_aligned( path, run->reference_layer, &run->first, run->first_path, &reference, error );
    }
    if ( result == RF_OK )
        result = take_images( run, i, frame, &reference, error );
    rf_destroy_image( &reference );
    return result;
}

static void add_to_parts( RfFlickerParts* parts, bool border, const RfFlickerSums* sums )
{
    rf_add_flicker( &parts->all, sums );
    rf_add_flicker( border ? &parts->border : &parts->inside, sums );
}

// Frees what the spectrum, which keeps the frame, does not need.
static void forget_layers( const RfFlickerRun* run, RfFlickerFrame* frame )
{
    rf_destroy_image( &frame->variance );
    if ( rf_is_compensated( run ) )
        return;
    free( frame->motion );
    free( frame->depth );
    frame->motion = frame->depth = NULL;
}

// The groups of a shot are its own.
static RfResult enter_shot( RfFlickerRun* run, int i, RfError* error )
{
    char path[RF_FLICKER_NAME_SIZE];
    RfResult result = rf_sequence_name( run->pattern, run->frames[i], path, sizeof path, error );
    run->cuts += 1;
    if ( result != RF_OK || run->period > 0 )
        return result;
    run->seams = rf_read_seams( path, run->frames[i], run->frames[run->frame_count - 1] );
    run->has_seams = run->has_seams || rf_has_seams( &run->seams );
    return RF_OK;
}

static RfResult measure_pair( RfFlickerRun* run, int i, RfError* error )
{
    const RfFlickerFrame* now = run->ring + i % run->ring_size;
    RfFlickerFrame* before = run->ring + ( i - 1 ) % run->ring_size;
    if ( rf_is_cut( now, before ) )
        return enter_shot( run, i, error );
    RfFlickerPair* pair = run->pairs + run->pair_count;
    RfResult result = rf_measure_flicker( now, before, rf_is_compensated( run ), run->reference != NULL, &pair->sums, error );
    pair->frame = now->number;
    pair->border = run->has_seams && rf_is_seam( &run->seams, now->number );
    pair->is_followed = run->follows && rf_has_flicker_layers( &run->layers, now, before );
    if ( result == RF_OK && pair->is_followed )
        result = rf_measure_flicker( now, before, true, true, &pair->followed, error );
    if ( result != RF_OK )
        return result;
    run->pair_count += 1;
    add_to_parts( &run->plain, pair->border, &pair->sums );
    if ( pair->is_followed )
        add_to_parts( &run->followed, pair->border, &pair->followed );
    forget_layers( run, before );
    return RF_OK;
}

static RfResult measure_window( RfFlickerRun* run, int i, RfError* error )
{
    const RfFlickerFrame* frames[RF_SPECTRUM_FRAMES];
    if ( !run->has_spectrum || !rf_ends_group( i, run->frame_count ) )
        return RF_OK;
    for ( int t = 0; t < run->window; ++t )
        frames[t] = run->ring + ( i - run->window + 1 + t ) % run->ring_size;
    return rf_add_spectrum_group( &run->spectrum, frames, run->window, run->split, rf_is_compensated( run ), error );
}

RfResult rf_measure_flicker_run( RfFlickerRun* run, RfError* error )
{
    RfResult result = begin( run, error );
    for ( int i = 0; i < run->frame_count && result == RF_OK; ++i )
    {
        result = read_frame( run, i, error );
        if ( result == RF_OK && i > 0 )
            result = measure_pair( run, i, error );
        if ( result == RF_OK )
            result = measure_window( run, i, error );
        if ( run->progress != NULL )
            run->progress( run->user, i + 1 );
    }
    run->errors = rf_summary_metrics( &run->summary );
    return result;
}

// Against a reference pixels are compared where they are, else along the motion.
static RfResult choose_usual_layers( RfFlickerRun* run, RfError* error )
{
    RfResult result = rf_read_exr_header( run->first_path, NULL, &run->first, error );
    if ( result != RF_OK || run->reference != NULL )
        return result;
    result = rf_find_flicker_layers( run->first_path, &run->first, NULL, NULL, &run->layers, error );
    if ( run->layers.motion[0] == NULL )
        run->layers.depth = NULL;
    return result == RF_OK ? rf_find_variance_layers( run->first_path, &run->first, &run->layers, error ) : result;
}

RfResult rf_measure_sequence_flicker( const char* pattern, const char* reference, RfFlickerMetrics* metrics, RfError* error )
{
    RfFlickerRun run = { .pattern = pattern, .reference = reference };
    int* frames = NULL;
    RfResult result = rf_sequence_frames( pattern, &frames, &run.frame_count, error );
    run.frames = frames;
    if ( result == RF_OK )
        result = rf_open_flicker_run( &run, error );
    if ( result == RF_OK )
        result = choose_usual_layers( &run, error );
    if ( result == RF_OK )
        result = rf_measure_flicker_run( &run, error );
    if ( result == RF_OK )
        *metrics = rf_flicker_metrics( &run.plain.all );
    rf_close_flicker_run( &run );
    free( frames );
    return result;
}
