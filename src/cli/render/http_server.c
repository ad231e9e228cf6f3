// libmicrohttpd on a socket of the loopback interface.
#include "cli/render/http_server.h"

#include "trace/trace.h"

#include <errno.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#define IDLE_SECONDS 10u      // of a connection
#define MOST_CONNECTIONS 128u // the render needs files, too

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

static enum MHD_Result queue( struct MHD_Connection* connection, unsigned status, const RfHttpReply* reply )
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
    const RfHttpServer* server = user;
    RfHttpReply reply = { .type = "text/plain" };
    unsigned status = MHD_HTTP_OK;
    rf_set_float_mode();
    if ( strcmp( method, MHD_HTTP_METHOD_GET ) != 0 )
        status = MHD_HTTP_METHOD_NOT_ALLOWED;
    else if ( !is_for_us( MHD_lookup_connection_value( connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_HOST ) ) )
        status = MHD_HTTP_FORBIDDEN;
    else if ( !server->answer( server->user, path, &reply ) )
    {
        status = MHD_HTTP_NOT_FOUND;
        reply = ( RfHttpReply ){ .type = "text/plain", .owned = reply.owned };
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
static RfResult listen_on( int port, int* listener, RfHttpServer* server, RfError* error )
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
    server->port = ntohs( address.sin_port );
    return RF_OK;
}

RfResult rf_start_http_server( int port, RfHttpAnswer* answer, void* user, RfHttpServer* server, RfError* error )
{
    int listener;
    *server = ( RfHttpServer ){ .answer = answer, .user = user };
    RfResult result = listen_on( port, &listener, server, error );
    if ( result == RF_OK )
        server->daemon = MHD_start_daemon( MHD_USE_POLL_INTERNAL_THREAD, 0, NULL, NULL, on_request, server,
                                           MHD_OPTION_LISTEN_SOCKET, listener, MHD_OPTION_CONNECTION_TIMEOUT, IDLE_SECONDS,
                                           MHD_OPTION_CONNECTION_LIMIT, MOST_CONNECTIONS, MHD_OPTION_END );
    if ( result == RF_OK && server->daemon == NULL )
        result = fail_port( port, "no server", error );
    if ( result != RF_OK && listener >= 0 )
        close( listener );
    return result;
}

void rf_stop_http_server( RfHttpServer* server ) { MHD_stop_daemon( server->daemon ); }
