// Writes the picture of the frame in work to a file, or keeps it for the live page and answers that page's requests.
#include "cli/render/preview_output.h"

#include "base/system.h"
#include "base/try.h"
#include "cli/messages.h"
#include "cli/options/render_options.h"
#include "image/atomic_file.h"
#include "image/encode.h"
#include "page/page_assets.h"
#include "page/pass_groups.h"
#include "scene/scene.h"
#include "trace/trace.h"

#include <errno.h>
#include <math.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#define IDLE_SECONDS 10u      // of a connection
#define MOST_CONNECTIONS 128u // the render needs files, too

#define MAX_NAME 4096
#define MOST_SHARE 0.01 // of the time of a render, for the pictures of the page

static RfResult write_file( const char* name, const void* bytes, size_t size, RfError* error )
{
    RfAtomicFile file;
    RF_TRY( rf_open_atomic_file( name, &file, error ) );
    file.unsynced = true; // the next replaces it
    RfResult result = rf_append_atomic_file( &file, bytes, size, error );
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

typedef struct Reply
{
    const char* type;     // "text/html"
    const char* parts[8]; // texts and bytes, in turn; as many as have a size
    size_t sizes[8];
    void* owned; // freed when it is sent; or NULL
    bool stays;  // the browser may keep it
} Reply;

static bool answer_page( Reply* reply )
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

static bool take_bytes( void* bytes, size_t size, const char* type, Reply* reply )
{
    *reply = ( Reply ){ .type = type, .parts = { bytes }, .sizes = { size }, .owned = bytes, .stays = reply->stays };
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

static bool answer_status( RfLivePreview* p, Reply* reply )
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

static bool answer_picture( const RfImage* image, Reply* reply )
{
    unsigned char* bytes = NULL;
    size_t size = 0;
    if ( image->rgb == NULL || rf_encode_picture( image, RF_PICTURE_MAX_BITS, "preview", &bytes, &size, NULL ) != RF_OK )
        return false;
    return take_bytes( bytes, size, "application/octet-stream", reply );
}

// The frame in work; the render may go on while it is encoded.
static bool answer_preview( RfLivePreview* p, Reply* reply )
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
static bool answer_frame( RfLivePreview* p, const char* text, Reply* reply )
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

// Fills the reply to a path such as "/status"; false: there is no such thing. Called by the server's thread.
static bool answer( RfLivePreview* p, const char* path, Reply* reply )
{
    if ( strcmp( path, "/" ) == 0 )
        return answer_page( reply );
    if ( strcmp( path, "/status" ) == 0 )
        return answer_status( p, reply );
    if ( strcmp( path, "/preview" ) == 0 )
        return answer_preview( p, reply );
    return strncmp( path, "/frame/", 7 ) == 0 && answer_frame( p, path + 7, reply );
}

// Another page that the browser shows could come here under a name of its own (DNS rebinding), but not under these.
static bool is_for_us( const char* host )
{
    static const char* const names[] = { "127.0.0.1", "localhost" };
    for ( size_t i = 0; i < sizeof names / sizeof names[0] && host != NULL; ++i )
    {
        size_t length = strlen( names[i] );
        if ( strncasecmp( host, names[i], length ) == 0 && ( host[length] == ':' || host[length] == '\0' ) )
            return true;
    }
    return false;
}

static enum MHD_Result queue( struct MHD_Connection* connection, unsigned status, const Reply* reply )
{
    struct MHD_IoVec parts[sizeof reply->sizes / sizeof reply->sizes[0]];
    unsigned count = 0;
    for ( size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i )
    {
        if ( reply->sizes[i] > 0 )
            parts[count++] = ( struct MHD_IoVec ){ reply->parts[i], reply->sizes[i] };
    }
    struct MHD_Response* response = MHD_create_response_from_iovec( parts, count, free, reply->owned );
    if ( response == NULL )
    {
        free( reply->owned );
        return MHD_NO;
    }
    MHD_add_response_header( response, MHD_HTTP_HEADER_CONTENT_TYPE, reply->type );
    MHD_add_response_header( response, MHD_HTTP_HEADER_CACHE_CONTROL, reply->stays ? "max-age=86400" : "no-store" );
    MHD_add_response_header( response, "X-Content-Type-Options", "nosniff" );
    MHD_add_response_header( response, MHD_HTTP_HEADER_CONNECTION, "close" );
    enum MHD_Result result = MHD_queue_response( connection, status, response );
    MHD_destroy_response( response );
    return result;
}

static enum MHD_Result on_request( void* user, struct MHD_Connection* connection, const char* path, const char* method,
                                   const char* version, const char* upload, size_t* upload_size, void** state )
{
    (void)version;
    (void)upload;
    (void)upload_size;
    (void)state;
    Reply reply = { .type = "text/plain" };
    unsigned status = MHD_HTTP_OK;
    rf_set_float_mode();
    if ( strcmp( method, MHD_HTTP_METHOD_GET ) != 0 )
        status = MHD_HTTP_METHOD_NOT_ALLOWED;
    else if ( !is_for_us( MHD_lookup_connection_value( connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_HOST ) ) )
        status = MHD_HTTP_FORBIDDEN;
    else if ( !answer( user, path, &reply ) )
    {
        status = MHD_HTTP_NOT_FOUND;
        reply = ( Reply ){ .type = "text/plain", .owned = reply.owned };
    }
    return queue( connection, status, &reply );
}

static RfResult fail_port( int port, const char* what, RfError* error )
{
    if ( errno == EADDRINUSE )
        return rf_fail( error, RF_ERROR_IO, "port %d: is in use: choose another, or 0 for any that is free", port );
    return rf_fail( error, RF_ERROR_IO, "port %d: %s: %s: choose another", port, what, strerror( errno ) );
}

// libmicrohttpd would not say why it cannot.
static RfResult listen_on( int port, int* listener, RfLivePreview* p, RfError* error )
{
    struct sockaddr_in address = { .sin_family = AF_INET,
                                   .sin_port = htons( (uint16_t)port ),
                                   .sin_addr = { .s_addr = htonl( INADDR_LOOPBACK ) } };
    socklen_t size = sizeof address;
    int one = 1;
    *listener = socket( AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0 );
    if ( *listener < 0 )
        return fail_port( port, "no socket", error );
    (void)setsockopt( *listener, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one );
    if ( bind( *listener, (struct sockaddr*)&address, sizeof address ) != 0 || listen( *listener, 16 ) != 0 ||
         getsockname( *listener, (struct sockaddr*)&address, &size ) != 0 )
        return fail_port( port, "cannot be used", error );
    p->port = ntohs( address.sin_port );
    return RF_OK;
}

// A web server for one person on this machine: answers GET on 127.0.0.1, one request at a time, in a thread of its own. Connections
// that send nothing hold nobody up. Port 0: any that is free. The preview may not be moved. Fails with RF_ERROR_IO, where the port is in
// use, too.
static RfResult start_server( int port, RfLivePreview* p, RfError* error )
{
    int listener;
    RfResult result = listen_on( port, &listener, p, error );
    if ( result == RF_OK )
        p->daemon = MHD_start_daemon( MHD_USE_POLL_INTERNAL_THREAD, 0, NULL, NULL, on_request, p, MHD_OPTION_LISTEN_SOCKET,
                                      listener, MHD_OPTION_CONNECTION_TIMEOUT, IDLE_SECONDS, MHD_OPTION_CONNECTION_LIMIT,
                                      MOST_CONNECTIONS, MHD_OPTION_END );
    if ( result == RF_OK && p->daemon == NULL )
        result = fail_port( port, "no server", error );
    if ( result != RF_OK && listener >= 0 )
        close( listener );
    return result;
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
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %d frames", frames );
    preview->progress.left = (double)NAN;
    preview->progress.frames_all = frames;
    pthread_mutex_init( &preview->mutex, NULL );
    RfResult result = start_server( port, preview, &reason );
    preview->serving = result == RF_OK;
    return preview->serving ? RF_OK : rf_fail( error, result, "--preview: %.1000s", reason.text );
}

void rf_stop_preview( RfLivePreview* p )
{
    if ( p->serving )
        MHD_stop_daemon( p->daemon ); // at once, in the midst of a reply too
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
