// Writes the picture of the frame in work to a file, or keeps it for the live page and answers that page's requests.
#include "cli/render/preview_output.h"

#include "base/system.h"
#include "cli/messages.h"
#include "cli/options/render_options.h"
#include "image/atomic_file.h"
#include "image/png.h"
#include "page/page_assets.h"
#include "page/pass_groups.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAME 4096
#define MOST_SHARE 0.01 // of the time of a render, for the pictures of the page

static RfResult write_file( const char* name, const void* bytes, size_t size, RfError* error )
{
    RfAtomicFile file;
    RfResult result = rf_open_atomic_file( name, &file, error );
    if ( result != RF_OK )
        return result;
    file.unsynced = true; // the next replaces it
    result = rf_append_atomic_file( &file, bytes, size, error );
    return rf_end_atomic_file( &file, result, error );
}

// Reports before the work that it cannot be written.
static RfResult probe_file( const char* name, RfError* error )
{
    static const char block[4096] = { 0 };
    RfError reason = { 0 };
    RfAtomicFile file;
    RfResult result = rf_open_atomic_file( name, &file, &reason );
    if ( result == RF_OK )
    {
        result = rf_append_atomic_file( &file, block, sizeof block, &reason );
        rf_discard_atomic_file( &file );
    }
    return result == RF_OK ? RF_OK : rf_fail( error, result, "--preview: %.1000s", reason.text );
}

// The live page.

static bool answer_page( RfHttpReply* reply )
{
    static const char style[] = "{{style}}", script[] = "{{script}}";
    const char *begin = rf_live_html, *first = strstr( begin, style ), *second = strstr( begin, script );
    const char* parts[] = { begin, rf_page_css, first + sizeof style - 1, rf_live_js, second + sizeof script - 1 };
    const size_t sizes[] = { (size_t)( first - begin ), strlen( parts[1] ), (size_t)( second - parts[2] ), strlen( parts[3] ),
                             strlen( parts[4] ) };
    reply->type = "text/html; charset=utf-8";
    for ( int i = 0; i < 5; ++i )
    {
        reply->parts[i] = parts[i];
        reply->sizes[i] = sizes[i];
    }
    return true;
}

static bool take_bytes( void* bytes, size_t size, const char* type, RfHttpReply* reply )
{
    *reply = ( RfHttpReply ){ .type = type, .parts = { bytes }, .sizes = { size }, .owned = bytes, .stays = reply->stays };
    return bytes != NULL;
}

// Opens the file of a finished frame. The caller frees both in any case.
static bool open_frame( const RfLivePreview* p, int number, char name[MAX_NAME], RfExrHeader* header, RfFilePasses* passes )
{
    *header = ( RfExrHeader ){ 0 };
    *passes = ( RfFilePasses ){ 0 };
    return rf_sequence_name( p->output->pattern, number, name, MAX_NAME, NULL ) == RF_OK &&
           rf_read_exr_header( name, NULL, header, NULL ) == RF_OK && rf_list_passes( header, passes, NULL ) == RF_OK;
}

// Lists the passes of a finished frame; all have the same.
static void list_passes( RfLivePreview* p, int number )
{
    char name[MAX_NAME];
    RfExrHeader header;
    RfFilePasses passes;
    if ( open_frame( p, number, name, &header, &passes ) )
        p->ranges = malloc( ( (size_t)passes.count + 1 ) * sizeof *p->ranges );
    p->passes = p->ranges != NULL ? json_array() : NULL;
    for ( int i = 0; i < passes.count && p->passes != NULL; ++i )
    {
        const RfFilePass* pass = passes.passes + i;
        bool bright = pass->look == RF_LOOK_LIGHT || pass->look == RF_LOOK_DEVIATION;
        json_array_append_new( p->passes, json_pack( "{s:o, s:b}", "name", rf_json_text( pass->name ), "light", bright ) );
        p->ranges[i].low = NAN;
    }
    rf_free_passes( &passes );
    rf_destroy_exr_header( &header );
}

static bool answer_status( RfLivePreview* p, RfHttpReply* reply )
{
    const RfCameraPath* path = p->output->path;
    pthread_mutex_lock( &p->mutex );
    int first = p->finished_count > 0 ? p->finished[0] : -1;
    pthread_mutex_unlock( &p->mutex );
    if ( first >= 0 && p->passes == NULL )
        list_passes( p, first );
    pthread_mutex_lock( &p->mutex );
    const RfProgress* progress = &p->progress;
    json_t* finished = rf_json_frames( p->finished, p->finished_count );
    json_t* json =
        json_pack( "{s:o, s:i, s:f, s:f, s:o, s:i, s:i, s:f, s:f}", "finished", finished, "frames", progress->frames_all, "share",
                   progress->share, "seconds", progress->seconds, "left", rf_json_number( progress->left ), "version", p->version,
                   "frame", p->frame, "spp", p->spp, "fps", (double)path->fps.numerator / path->fps.denominator );
    pthread_mutex_unlock( &p->mutex );
    json_object_set_new( json, "passes", p->passes != NULL ? json_incref( p->passes ) : json_array() );
    json_object_set_new( json, "scene", rf_json_text( rf_tracer_scene( p->output->tracer )->path ) );
    json_object_set_new( json, "output", rf_json_text( p->output->pattern ) );
    char* text = json_dumps( json, JSON_COMPACT );
    json_decref( json );
    return take_bytes( text, text != NULL ? strlen( text ) : 0, "application/json", reply );
}

static bool answer_picture( const RfImage* image, RfHttpReply* reply )
{
    unsigned char* bytes = NULL;
    size_t size = 0;
    if ( image->rgb == NULL || rf_encode_picture( image, RF_PICTURE_MAX_BITS, "preview", &bytes, &size, NULL ) != RF_OK )
        return false;
    return take_bytes( bytes, size, "application/octet-stream", reply );
}

// The frame in work; the render may go on while it is encoded.
static bool answer_preview( RfLivePreview* p, RfHttpReply* reply )
{
    RfImage copy = { 0 };
    pthread_mutex_lock( &p->mutex );
    bool good = p->version > 0 && rf_create_image( p->image.width, p->image.height, &copy, NULL ) == RF_OK;
    if ( good )
        memcpy( copy.rgb, p->image.rgb, 3 * sizeof( float ) * (size_t)copy.width * (size_t)copy.height );
    pthread_mutex_unlock( &p->mutex );
    double began = rf_wall_seconds();
    good = good && answer_picture( &copy, reply );
    pthread_mutex_lock( &p->mutex );
    p->encoded = rf_wall_seconds() - began;
    pthread_mutex_unlock( &p->mutex );
    rf_destroy_image( &copy );
    return good;
}

static bool is_finished( RfLivePreview* p, int number )
{
    bool found = false;
    pthread_mutex_lock( &p->mutex );
    for ( int i = 0; i < p->finished_count && !found; ++i )
        found = p->finished[i] == number;
    pthread_mutex_unlock( &p->mutex );
    return found;
}

// A pass of a finished frame, by its number in the list of passes.
static bool draw_pass( RfLivePreview* p, int number, long index, RfImage* image )
{
    char name[MAX_NAME];
    RfExrHeader header;
    RfFilePasses passes;
    RfExrWindow window;
    float* values = NULL;
    int stride;
    bool good = open_frame( p, number, name, &header, &passes ) && index >= 0 && index < passes.count &&
                index < (long)json_array_size( p->passes );
    const RfFilePass* pass = good ? passes.passes + index : NULL;
    good = good && rf_read_passes( name, pass, 1, &window, &values, &stride, NULL ) == RF_OK &&
           rf_create_image( window.width, window.height, image, NULL ) == RF_OK;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    if ( good && isnan( p->ranges[index].low ) )
        p->ranges[index] = rf_pass_range( pass, values, (size_t)stride, pixels );
    if ( good )
        rf_draw_pass( pass, p->ranges[index], values, (size_t)stride, pixels, image->rgb );
    free( values );
    rf_free_passes( &passes );
    rf_destroy_exr_header( &header );
    return good;
}

// A finished frame, from its file: "12", or "12/3", one of its passes.
static bool answer_frame( RfLivePreview* p, const char* text, RfHttpReply* reply )
{
    char name[MAX_NAME], *end, *last;
    RfImage image = { 0 };
    long number = strtol( text, &end, 10 ), pass = *end == '/' ? strtol( end + 1, &last, 10 ) : -1;
    bool has_pass = *end == '/' && last != end + 1 && *last == '\0';
    if ( *text == '\0' || ( *end != '\0' && !has_pass ) || number != (int)number || !is_finished( p, (int)number ) )
        return false;
    reply->stays = true;
    bool good = has_pass ? draw_pass( p, (int)number, pass, &image )
                         : rf_sequence_name( p->output->pattern, (int)number, name, sizeof name, NULL ) == RF_OK &&
                               rf_read_exr_layer( name, NULL, &image, &( RfExrWindow ){ 0 }, NULL ) == RF_OK;
    good = good && answer_picture( &image, reply );
    rf_destroy_image( &image );
    return good;
}

static bool answer( void* user, const char* path, RfHttpReply* reply )
{
    RfLivePreview* p = user;
    if ( strcmp( path, "/" ) == 0 )
        return answer_page( reply );
    if ( strcmp( path, "/status" ) == 0 )
        return answer_status( p, reply );
    if ( strcmp( path, "/preview" ) == 0 )
        return answer_preview( p, reply );
    return strncmp( path, "/frame/", 7 ) == 0 && answer_frame( p, path + 7, reply );
}

RfResult rf_start_preview( const char* option, const RfOutput* output, int frames, RfLivePreview* preview, RfError* error )
{
    int port;
    *preview = ( RfLivePreview ){ .output = output, .taken = -INFINITY };
    if ( option == NULL )
        return RF_OK;
    if ( !rf_is_port( option, &port ) )
    {
        preview->file = option;
        return probe_file( option, error );
    }
    RfError reason = { 0 };
    preview->finished = malloc( (size_t)frames * sizeof( int ) );
    if ( preview->finished == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d frames", frames );
    preview->progress.left = (double)NAN;
    preview->progress.frames_all = frames;
    pthread_mutex_init( &preview->mutex, NULL );
    RfResult result = rf_start_http_server( port, answer, preview, &preview->server, &reason );
    preview->serving = result == RF_OK;
    return preview->serving ? RF_OK : rf_fail( error, result, "--preview: %.1000s", reason.text );
}

void rf_stop_preview( RfLivePreview* p )
{
    if ( p->serving )
        rf_stop_http_server( &p->server );
    p->serving = false;
    rf_destroy_image( &p->image );
    json_decref( p->passes );
    free( p->ranges );
    free( p->finished );
    p->finished = NULL;
}

static RfResult write_picture( RfLivePreview* p, const RfPreview* picture, RfError* error )
{
    RfImage image = { .width = picture->width, .height = picture->height, .rgb = (float*)picture->rgb };
    unsigned char* bytes = NULL;
    size_t size;
    RfResult result = rf_encode_png( p->file, &image, &bytes, &size, error );
    if ( result == RF_OK )
        result = write_file( p->file, bytes, size, error );
    free( bytes );
    return result;
}

static void keep_picture( RfLivePreview* p, const RfPreview* picture, int number, int threads )
{
    double now = rf_wall_seconds();
    pthread_mutex_lock( &p->mutex );
    bool due = now >= p->taken + p->encoded / ( MOST_SHARE * threads );
    if ( due && p->image.rgb == NULL )
        due = rf_create_image( picture->width, picture->height, &p->image, NULL ) == RF_OK;
    if ( due )
    {
        memcpy( p->image.rgb, picture->rgb, 3 * sizeof( float ) * (size_t)picture->width * (size_t)picture->height );
        p->frame = number;
        p->spp = picture->native_spp;
        p->version += 1;
        p->taken = now;
    }
    pthread_mutex_unlock( &p->mutex );
}

RfResult rf_take_preview( RfLivePreview* p, const RfPreview* picture, int number, int threads, RfError* error )
{
    if ( p->serving )
        keep_picture( p, picture, number, threads );
    RfResult result = p->file != NULL ? write_picture( p, picture, error ) : RF_OK;
    bool first = !p->broken;
    p->broken = p->broken || result != RF_OK;
    return first ? result : RF_OK;
}

void rf_note_live_progress( RfLivePreview* p, const RfProgress* progress )
{
    if ( !p->serving )
        return;
    pthread_mutex_lock( &p->mutex );
    int frames = p->progress.frames_all;
    p->progress = *progress;
    p->progress.frames_all = frames;
    pthread_mutex_unlock( &p->mutex );
}

void rf_note_live_frame( RfLivePreview* p, int number )
{
    if ( !p->serving )
        return;
    pthread_mutex_lock( &p->mutex );
    p->finished[p->finished_count++] = number;
    pthread_mutex_unlock( &p->mutex );
}
